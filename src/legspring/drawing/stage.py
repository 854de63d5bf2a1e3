"""What a moving picture shows at an instant: an animal on its ground, with the camera going along."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from legspring.drawing.strokes import arrow, body, body_length, round_length, tilt_of_body
from legspring.drawing.style import COLOURS, GRAY, SMALL

Floats = NDArray[np.float64]

PUSH, PULL, PUSHED = COLOURS[0], COLOURS[1], COLOURS[3]
THIN, THICK = 1.0, 5.0
"""Widths of a leg without force and with the largest one, in points."""
MARGIN = 0.12
"""Room around all that moves, by its size."""
FLATTEST, STEEPEST = 0.55, 1.25
"""Least and largest height of a panel by its width."""
MARKS = 4
"""Marks on the ground in a stride, where the animal gets anywhere."""


@dataclass(frozen=True, eq=False)
class Shot:
    """A part of a simulation, from one time to another (s), what it is about, and whether its end is its beginning."""

    run: xr.Dataset
    begin: float
    end: float
    about: str
    repeats: bool = False

    @property
    def name(self) -> str:
        """Whose it is."""
        return str(self.run.attrs["animal"]).replace("_", " ")

    def at(self, elapsed: float) -> float:
        """Return the run's time after so much of the film's (s): one that repeats itself goes on for ever."""
        duration = self.end - self.begin
        return self.begin + (math.fmod(elapsed, duration) if self.repeats else min(elapsed, duration))

    @cached_property
    def camera(self) -> Floats:
        """Where the camera is at each of the run's times, ``(T, 2)``: the centre of mass, its swaying smoothed away.

        A mean over a stride, beyond the ends of the run over its mirror image in a point.
        """
        position = self.run["position"].values
        width = round(self.run.attrs["stride_duration"] / float(np.diff(self.run["time"].values[:2])[0]))
        width = min(width, len(position) - 1)
        before, after = 2 * position[0] - position[width:0:-1], 2 * position[-1] - position[-2 : -width - 2 : -1]
        padded = np.concatenate([before, position, after])
        smooth: Floats = uniform_filter1d(padded, width, axis=0)[width : width + len(position)]
        return smooth

    @cached_property
    def extent(self) -> Floats:
        """Least and largest x and y, seen from the camera, of all that moves in this part: ``(2, 2)``."""
        time = self.run["time"].values
        shown = (time >= self.begin) & (time <= self.end)
        centre, hip, foot = (self.run[name].values for name in ("position", "hip", "foot"))
        centre, turned = centre[:, None], self.run["yaw"].values[:, None]
        seen = [centre, hip, foot, hip + free_legs(hip, foot, self.run["free_length"].values)]
        if "inertia" in self.run.attrs:
            reach = 0.5 * body_length(self.run.attrs["mass"], self.run.attrs["inertia"])
            turned = turned + math.radians(tilt_of(self.run))
            ends = reach * np.stack([-np.sin(turned), np.cos(turned)], axis=-1)
            seen += [centre + ends, centre - ends]
        places = np.concatenate([(what - self.camera[:, None])[shown].reshape(-1, 2) for what in seen])
        return np.array([np.nanmin(places, axis=0), np.nanmax(places, axis=0)])

    @property
    def strongest(self) -> float:
        """Largest force of a leg, m g."""
        return float(np.hypot(*np.moveaxis(self.run["force"].values, -1, 0)).max())


def free_legs(hip: Floats, foot: Floats, free: Floats) -> Floats:
    """Return the legs as they would be without force, from hips along to the feet; nan in swing."""
    along = foot - hip
    result: Floats = along * (free / np.hypot(along[..., 0], along[..., 1]))[..., None]
    return result


def frame_around(extent: Floats) -> Floats:
    """Return a window with room around an extent, neither too flat nor too steep."""
    middle, size = extent.mean(axis=0), (1.0 + 2.0 * MARGIN) * np.ptp(extent, axis=0)
    size[0] = max(size[0], size[1] / STEEPEST)
    size[1] = max(size[1], FLATTEST * size[0])
    return np.array([middle - 0.5 * size, middle + 0.5 * size])


def _lines(axes: Axes, **options: Any) -> LineCollection:
    """Add lines to a panel that are not there yet."""
    lines = LineCollection([], **options)
    axes.add_collection(lines)
    return lines


class Stage:
    """A panel with an animal in it, and all artists that move.

    Parameters
    ----------
    axes
        The panel.
    shot
        What is shown in it.
    window
        Corners of what is seen, from the camera, ``(2, 2)``.
    strongest
        Force that is drawn with the thickest line, m g.
    pace
        What is said of slow motion.
    """

    def __init__(self, axes: Axes, shot: Shot, window: Floats, strongest: float, pace: str = "") -> None:
        self.shot, self.strongest, self.pace = shot, strongest, pace
        axes.set(
            xlim=window[:, 0], ylim=window[:, 1], aspect="equal", xticks=[], yticks=[], title=f"{shot.name}{shot.about}"
        )
        axes.spines[:].set_visible(False)
        self.scenery(axes, window)
        size = float(np.ptp(window, axis=0).max())
        self.ground = Ground(axes, shot, window)
        self.track = axes.plot([], [], color="black", linewidth=0.7, alpha=0.5)[0]
        self.old_feet = axes.plot([], [], "o", color="0.8", markersize=3.5)[0]
        self.free = _lines(axes, colors="0.55", alpha=0.3, linewidths=7.0, capstyle="butt")
        self.body = Body(axes, shot.run)
        self.legs = _lines(axes, capstyle="round")
        self.feet = axes.plot([], [], "o", color="0.2", markersize=4.0)[0]
        self.push = axes.plot([], [], color=PUSHED, linewidth=4.0, solid_capstyle="butt")[0]
        self.reach = 0.2 * size
        self.clock = axes.text(0.985, 0.02, "", transform=axes.transAxes, ha="right", va="bottom", fontsize=SMALL)
        moving = (self.track, self.old_feet, self.free, *self.body.artists, self.legs, self.feet, self.push)
        self.artists: tuple[Artist, ...] = (self.ground.artist, *moving, self.clock)
        for artist in self.artists:
            artist.set_animated(True)

    def scenery(self, axes: Axes, window: Floats) -> None:
        """Draw what does not move: how long a length is, and which way gravity pulls."""
        about, (width, _) = self.shot.run.attrs, np.ptp(window, axis=0)
        length, words = round_length(0.35 * width)
        left, low = window[0] + 0.03 * width
        axes.plot([left, left + length], [low, low], color=GRAY, linewidth=1.5, solid_capstyle="butt")
        axes.text(left + 0.5 * length, low + 0.01 * width, words, ha="center", va="bottom", color=GRAY, fontsize=SMALL)
        slope = math.radians(about["slope_deg"])
        right, top = window[1] - 0.05 * width
        middle, half = top - 0.08 * width, 0.08 * width
        how: dict[str, Any] = {"ha": "right", "va": "center", "fontsize": SMALL}
        if about["view"] == "above" and math.sin(slope):
            half = math.copysign(half, math.sin(slope))
            arrow(axes, (right, middle + half), (right, middle - half))
            axes.text(right - 0.02 * width, middle, r"$g\,\sin\sigma$", **how)
        elif about["view"] == "side" and slope:
            # The ground is drawn level, and gravity as it is seen from it.
            across, down = half * math.sin(slope), half * math.cos(slope)
            arrow(axes, (right + across, middle + down), (right - across, middle - down))
            axes.text(right - 0.02 * width - abs(across), middle, "$g$", **how)

    def show(self, elapsed: float) -> None:
        """Move everything to where it is after so much time (s)."""
        run, shot, time = self.shot.run, self.shot, self.shot.at(elapsed)
        times = run["time"].values
        row = int(np.clip(np.searchsorted(times, time + 1e-12, side="right") - 1, 0, len(times) - 1))
        later, share = min(row + 1, len(times) - 1), 0.0
        if later > row:
            share = float(np.clip((time - times[row]) / (times[later] - times[row]), 0.0, 1.0))

        def between(values: Floats) -> Floats:
            result: Floats = (1.0 - share) * values[row] + share * values[later]
            return result

        camera = between(shot.camera)
        position = between(run["position"].values) - camera
        hip, foot = between(run["hip"].values) - camera, run["foot"].values[row] - camera
        self.ground.show(camera)
        path = np.vstack([run["position"].values[: row + 1] - camera, position])
        self.track.set_data(*path.T)
        self.old_feet.set_data(*(self.footholds[self.put_down <= time] - camera).T)
        self.body.show(position, hip, float(between(run["yaw"].values)))
        self.show_legs(hip, foot, run["force"].values[row], run["free_length"].values[row])
        begin, end = run.attrs.get("push_time", (math.inf, math.inf))
        pushed = begin <= time <= max(end, begin + 0.2 * run.attrs["step_duration"])
        way = np.asarray(run.attrs["push"]) if pushed else np.full(2, np.nan)
        self.push.set_data(*np.transpose([position - self.reach * way / math.hypot(*way), position + 0.0 * way]))
        self.clock.set_text(f"{1e3 * elapsed:.0f} ms\n{self.pace}")

    def show_legs(self, hip: Floats, foot: Floats, force: Floats, free: Floats) -> None:
        """Draw the legs in stance, from hips to feet."""
        down = np.isfinite(foot[:, 0])
        hip, foot, force = hip[down], foot[down], force[down]
        pull = np.sum(force * (foot - hip), axis=1) / np.hypot(*(foot - hip).T)
        self.legs.set_segments(list(np.stack([hip, foot], axis=1)))
        self.legs.set_color([PULL if one > 0.0 else PUSH for one in pull])
        self.legs.set_linewidth(THIN + (THICK - THIN) * np.abs(pull) / max(self.strongest, 1e-300))
        self.free.set_segments(list(np.stack([hip, hip + free_legs(hip, foot, free[down])], axis=1)))
        self.feet.set_data(*foot.T)

    @cached_property
    def _touchdowns(self) -> tuple[Floats, Floats]:
        """When feet were put down (s), ``(N,)``, and where, ``(N, 2)``."""
        foot, times = self.shot.run["foot"].values, self.shot.run["time"].values
        down = np.isfinite(foot[..., 0])
        new = down.copy()
        new[1:] &= ~down[:-1] | (np.abs(np.diff(foot, axis=0)).max(axis=-1) > 0.0)
        rows, legs = np.nonzero(new)
        return times[rows], foot[rows, legs]

    @property
    def put_down(self) -> Floats:
        """When feet were put down, s."""
        return self._touchdowns[0]

    @property
    def footholds(self) -> Floats:
        """Where feet were put down, m."""
        return self._touchdowns[1]


class Ground:
    """Marks on the ground, so far apart that a stride moves them onto each other."""

    def __init__(self, axes: Axes, shot: Shot, window: Floats) -> None:
        run = shot.run
        self.side = run.attrs["view"] == "side"
        duration = float(run["time"].values[-1] - run["time"].values[0])
        stride = (shot.camera[-1] - shot.camera[0]) * run.attrs["stride_duration"] / duration
        size = float(np.ptp(window, axis=0).max())
        if math.hypot(*stride) < 0.05 * size:
            stride = np.array([0.0, size])
        across, along = np.array([stride[1], -stride[0]]) / MARKS, stride / MARKS
        self.lattice = np.stack([across, along])
        if self.side:
            low = float(np.nanmin(run["foot"].values[..., 1]))
            self.level = low
            self.reach = window[:, 0]
            self.artist: Line2D = axes.plot([], [], color=GRAY, linewidth=1.0, marker="|", markersize=6)[0]
            return
        # Enough to fill the window, wherever the camera is between marks.
        count = math.ceil(0.75 * math.hypot(*np.ptp(window, axis=0)) / math.hypot(*along)) + 1
        steps = np.stack(np.meshgrid(*[np.arange(-count, count + 1)] * 2), axis=-1).reshape(-1, 2)
        self.marks = steps @ self.lattice + window.mean(axis=0)
        self.artist = axes.plot([], [], ".", color="0.85", markersize=2.5)[0]

    def show(self, camera: Floats) -> None:
        """Move the marks to where they are seen from the camera."""
        if self.side:
            apart = abs(self.lattice[1, 0]) or float(np.ptp(self.reach))
            first = self.reach[0] - math.fmod(camera[0] + self.reach[0], apart) - apart
            x = np.arange(first, self.reach[1] + 2 * apart, apart)
            self.artist.set_data(x, np.full(len(x), self.level - camera[1]))
            return
        places = np.linalg.solve(self.lattice.T, camera)
        self.artist.set_data(*(self.marks - (places - np.floor(places)) @ self.lattice).T)


def tilt_of(run: xr.Dataset) -> float:
    """Return how the body of a simulation lies along its hips where its yaw is 0, deg."""
    offsets, yaw = run["hip"].values[0] - run["position"].values[0], float(run["yaw"].values[0])
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return tilt_of_body(offsets @ np.array([[cosine, -sine], [sine, cosine]]), run.attrs["view"] == "side")


class Body:
    """The centre of mass, the way from there to the hips and, where it turns, the body."""

    def __init__(self, axes: Axes, run: xr.Dataset) -> None:
        self.spine = _lines(axes, colors=GRAY, linewidths=1.0)
        self.centre = axes.plot([], [], "o", color="black", markersize=6.0)[0]
        self.artists: tuple[Artist, ...] = (self.spine, self.centre)
        self.trunk: Ellipse | None = None
        if "inertia" in run.attrs:
            self.tilt = tilt_of(run)
            self.trunk = body(run.attrs["mass"], run.attrs["inertia"])
            axes.add_patch(self.trunk)
            self.artists = (self.trunk, *self.artists)

    def show(self, position: Floats, hips: Floats, yaw: float) -> None:
        """Move the body."""
        self.centre.set_data(*position[:, None])
        self.spine.set_segments([np.array([position, hip]) for hip in hips])
        if self.trunk is not None:
            self.trunk.set_center((position[0], position[1]))
            self.trunk.set_angle(math.degrees(yaw) + self.tilt)


def common_window(shots: Sequence[Shot]) -> list[Floats]:
    """Return a window for each shot: the same for all, if they are of about the same size."""
    sizes = [float(np.ptp(shot.extent, axis=0).max()) for shot in shots]
    if max(sizes) > 4.0 * min(sizes):
        shape = max(float(np.divide(*np.ptp(frame_around(shot.extent), axis=0)[::-1])) for shot in shots)
        return [_taller(frame_around(shot.extent), shape) for shot in shots]
    low = np.min([shot.extent[0] for shot in shots], axis=0)
    high = np.max([shot.extent[1] for shot in shots], axis=0)
    return [frame_around(np.array([low, high]))] * len(shots)


def _taller(window: Floats, shape: float) -> Floats:
    """Return a window of the same width whose height is so much of it."""
    middle, width = window.mean(axis=0), float(np.ptp(window[:, 0]))
    half = 0.5 * width * np.array([1.0, shape])
    return np.array([middle - half, middle + half])
