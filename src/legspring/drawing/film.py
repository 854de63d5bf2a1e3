"""Moving pictures of gaits, simulations and recoveries."""

import html
import io
import math
import os
import uuid
from base64 import b64encode
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import jinja2
import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from PIL import Image

from legspring.checks import checked_number, checked_positive, shown
from legspring.drawing.stage import PULL, PUSH, PUSHED, Shot, Stage, common_window
from legspring.drawing.style import STYLE
from legspring.files import check_output, whole_file
from legspring.progress import progress_bar

Pictures = Iterator[NDArray[np.uint8]]

STRIDE = 1.8
"""About how long a stride takes in a film whose slow motion is not given, s."""
FACTORS = tuple(digit * 10.0**power for power in range(-6, 7) for digit in (1.0, 2.0, 5.0))
FPS, WIDTH, DPI = 25, 480, 120
"""Frames a second; width of a panel in pixels, and how many of them are an inch."""
HEAD, FOOT = 0.55, 0.35
"""Heights of title and legend, inches."""
MOST_FRAMES, MOST_STRIDES, MOST_SHOTS = 5000, 500, 4
COLOURS_IN_GIF, PALETTE_FRAMES = 96, 24
MACROBLOCK = 2
"""Video has an even number of pixels either way."""
VIDEO = {
    ".mp4": ("libx264", ["-f", "mp4", "-preset", "veryfast", "-crf", "22", "-movflags", "+faststart"]),
    ".webm": ("libvpx", ["-f", "webm", "-deadline", "realtime", "-cpu-used", "8", "-crf", "12", "-b:v", "1M"]),
}
"""Codec of each kind of video, and how it is told to be quick."""
FILMS = (".gif", ".html", *VIDEO)


@runtime_checkable
class Filmed(Protocol):
    """What can be filmed, beside a simulation: a gait, a recovery."""

    def shot(self, strides: float | None = None) -> Shot:
        """Return what is shown of it."""


def animate(
    *subjects: Filmed | xr.Dataset,
    strides: float | None = None,
    slow: float | None = None,
    fps: int = FPS,
    width: int = WIDTH,
) -> "Film":
    """Make a moving picture of a gait, a simulation or a recovery, or of several side by side.

    It is seen as the model is: from above on the slope, or from the side. Legs that push are blue and legs that pull
    red, the thicker the larger their force; the force-free length of each is the broad gray line along it.
    The camera goes along, and marks on the ground are a quarter of a stride apart. Of a gait, the film's end is its
    beginning.

    Parameters
    ----------
    subjects
        Gaits, datasets of `legspring.simulate`, or recoveries of `Gait.recover`; up to four, which begin at once.
    strides
        How much is shown: two of a gait; a simulation is shown whole, a recovery until the gait is back.
    slow
        How many times slower than life; by default a round number by which a stride takes about two seconds.
    fps
        Frames a second.
    width
        Of each panel, in pixels.

    Returns
    -------
    Film
        Notebooks show it; ``save`` writes it to a file.

    Raises
    ------
    ValueError
        For a number out of range, or a simulation and strides.

    Examples
    --------
    >>> import legspring as ls
    >>> gait = ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]
    >>> film = gait.animate(strides=1)
    >>> film.slow, len(film), film.seconds
    (20.0, 45, 1.8)
    """
    if not 1 <= len(subjects) <= MOST_SHOTS:
        raise ValueError(f"{len(subjects)} subjects: must be from 1 to {MOST_SHOTS}")
    if strides is not None and checked_positive("strides", strides) > MOST_STRIDES:
        raise ValueError(f"strides = {strides:g}: must be at most {MOST_STRIDES}")
    fps, width = _whole_number("fps", fps, 1, 100), _whole_number("width", width, 160, 2000)
    shots = tuple(_shot(subject, strides) for subject in subjects)
    shortest = min(shot.run.attrs["stride_duration"] for shot in shots)
    if slow is None:
        slow = min(FACTORS, key=lambda factor: abs(math.log(factor * shortest / STRIDE)))
    film = Film(shots, checked_positive("slow", slow), fps, width)
    if not 2 <= len(film) <= MOST_FRAMES:
        raise ValueError(
            f"slow = {slow:g}: must be such that the film has from 2 to {MOST_FRAMES} frames; it would have {len(film)}"
        )
    return film


def _shot(subject: Filmed | xr.Dataset, strides: float | None) -> Shot:
    """Return what is shown of a subject."""
    if isinstance(subject, xr.Dataset) and "stride_duration" in subject.attrs:
        if strides is not None:
            raise ValueError(f"strides = {strides:g}: must be left out; a simulation is shown whole")
        time, about = subject["time"].values, subject.attrs
        place = f"slope {about['slope_deg']:g} deg, " if about["view"] == "above" else ""
        return Shot(subject, float(time[0]), float(time[-1]), f"\n{place}start at {about['speed']:.3g} m/s")
    if not isinstance(subject, Filmed):
        raise ValueError(f"{shown(subject)}: must be a Gait, a Recovery, or a Dataset of legspring.simulate")
    return subject.shot(strides)


def _whole_number(name: str, value: int, low: int, high: int) -> int:
    """Return a whole number in its range; raise ValueError if it is none."""
    valid = f"a whole number from {low} to {high}"
    if not low <= (number := checked_number(name, value, valid)) <= high or number != round(number):
        raise ValueError(f"{name} = {shown(value)}: must be {valid}")
    return round(number)


@dataclass(frozen=True, eq=False)
class Film:
    """A moving picture, whose frames are drawn as they are asked for.

    Attributes
    ----------
    shots
        What is shown, side by side.
    slow
        How many times slower than life.
    fps
        Frames a second.
    width
        Of each panel, in pixels.
    """

    shots: tuple[Shot, ...]
    slow: float
    fps: int = FPS
    width: int = WIDTH

    @property
    def duration(self) -> float:
        """Time that is shown, s."""
        return max(shot.end - shot.begin for shot in self.shots)

    @property
    def seconds(self) -> float:
        """Length of the film, s."""
        return len(self) / self.fps

    @property
    def pace(self) -> str:
        """What is said of slow motion."""
        if self.slow == 1.0:
            return "as fast as life"
        return f"{self.slow:g} times slower" if self.slow > 1.0 else f"{1.0 / self.slow:.3g} times faster"

    def __len__(self) -> int:
        """Return the number of frames."""
        return round(self.duration * self.slow * self.fps)

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Height and width of a frame, in pixels."""
        width, height = np.ptp(common_window(self.shots)[0], axis=0)
        pixels = self.width * height / width + (HEAD + FOOT) * DPI
        across = self.width * len(self.shots)
        return MACROBLOCK * math.ceil(pixels / MACROBLOCK), MACROBLOCK * math.ceil(across / MACROBLOCK)

    def frames(self) -> Pictures:
        """Draw one frame after another: ``(height, width, 3)``, red, green and blue from 0 to 255."""
        with mpl.rc_context(STYLE):
            figure, stages = self._stages()
            canvas: Any = FigureCanvasAgg(figure)
            canvas.draw()
            empty = canvas.copy_from_bbox(figure.bbox)
            for number in range(len(self)):
                canvas.restore_region(empty)
                for stage in stages:
                    stage.show(number / (self.fps * self.slow))
                    for artist in stage.artists:
                        figure.draw_artist(artist)
                yield np.asarray(canvas.buffer_rgba())[..., :3].copy()

    def _stages(self) -> tuple[Figure, list[Stage]]:
        """Lay out the film: panels side by side, and below them what colours stand for."""
        height, width = self.shape
        figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
        # Whatever the reader's own settings are.
        figure.set_layout_engine("none")
        strongest, windows = max(shot.strongest for shot in self.shots), common_window(self.shots)
        low, high, count = FOOT * DPI / height, 1.0 - (HEAD + FOOT) * DPI / height, len(self.shots)
        stages = []
        for number, (shot, window) in enumerate(zip(self.shots, windows, strict=True)):
            axes = figure.add_axes((number / count, low, 1.0 / count, high))
            stages.append(Stage(axes, shot, window, strongest, self.pace))
        handles = [
            Line2D([], [], color=PUSH, linewidth=3.0, label="pushes"),
            Line2D([], [], color=PULL, linewidth=3.0, label="pulls"),
            Line2D([], [], color="0.55", alpha=0.3, linewidth=7.0, label="force-free"),
        ]
        if any("push" in shot.run.attrs for shot in self.shots):
            handles.append(Line2D([], [], color=PUSHED, linewidth=4.0, label="pushed"))
        figure.legend(handles=handles, loc="lower left", ncols=4, borderaxespad=0.3, columnspacing=1.2)
        return figure, stages

    def save(self, path: str | os.PathLike[str], *, progress: bool = False) -> None:
        """Write the film to a file, which appears whole or not at all.

        Parameters
        ----------
        path
            Its ending says the format: .gif; .html, a page with a player; .mp4 or .webm, for which the extra
            ``video`` has to be installed.
        progress
            Whether to show a progress bar.

        Raises
        ------
        ValueError
            If the ending is another, or what makes videos is not installed.
        OSError
            If the file cannot be written.
        """
        check_film(path)
        suffix = Path(path).suffix.lower()
        write = {".gif": self._write_gif, ".html": self._write_page}.get(suffix, partial(self._write_video, suffix))
        with whole_file(path) as file, progress_bar("frames", len(self), show=progress) as tick:
            write(file, _ticking(self.frames(), tick))

    def _write_gif(self, file: Path, frames: Pictures) -> None:
        first, *rest = _palettes(frames)
        duration = round(100.0 / self.fps) * 10
        first.save(file, format="GIF", save_all=True, append_images=rest, duration=duration, loop=0, optimize=False)

    def _write_page(self, file: Path, frames: Pictures) -> None:
        title = html.escape(" | ".join(shot.name for shot in self.shots))
        page = _environment().get_template("page.html.jinja")
        file.write_text(page.render(title=title, player=self._player(frames)), encoding="utf-8")

    def _write_video(self, suffix: str, file: Path, frames: Pictures) -> None:
        from imageio_ffmpeg import write_frames

        codec, options = VIDEO[suffix]
        height, width = self.shape
        video = write_frames(
            str(file),
            (width, height),
            fps=self.fps,
            codec=codec,
            macro_block_size=MACROBLOCK,
            output_params=options,
            ffmpeg_log_level="error",
        )
        video.send(None)
        for frame in frames:
            video.send(np.ascontiguousarray(frame))
        video.close()

    def player(self) -> str:
        """Return a player as HTML, to be put into a page: play, pause, single frames, speed."""
        return self._player(self.frames())

    def _player(self, frames: Pictures) -> str:
        height, width = self.shape
        template = _environment().get_template("player.html.jinja")
        pictures = [_data_url(picture) for picture in _palettes(frames)]
        name = f"film-{uuid.uuid4().hex[:12]}"
        return template.render(name=name, pictures=pictures, fps=self.fps, width=width, height=height)

    @cached_property
    def _shown(self) -> str:
        return self.player()

    def _repr_html_(self) -> str:
        """Return the player that a notebook asks for."""
        return self._shown


def check_film(path: str | os.PathLike[str]) -> None:
    """Raise ValueError or OSError if a film cannot be written to a file."""
    check_output(path, FILMS)
    if Path(path).suffix.lower() in VIDEO and find_spec("imageio_ffmpeg") is None:
        raise ValueError(
            f"{path}: videos need imageio-ffmpeg, which pip install 'legspring[video]' brings; .gif and .html do not"
        )


def _ticking(frames: Pictures, tick: Callable[[int], None]) -> Pictures:
    for frame in frames:
        yield frame
        tick(1)


def _palettes(frames: Pictures) -> Iterator[Image.Image]:
    """Reduce frames to a few colours, the same in all: those of the first and of some more."""
    pending = list(islice(frames, PALETTE_FRAMES))
    palette = Image.fromarray(np.concatenate(pending[::4])).quantize(COLOURS_IN_GIF, Image.Quantize.MAXCOVERAGE)
    for group in (pending, frames):
        for frame in group:
            yield Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)


def _data_url(picture: Image.Image) -> str:
    stream = io.BytesIO()
    picture.save(stream, format="PNG")
    return f"data:image/png;base64,{b64encode(stream.getvalue()).decode('ascii')}"


def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.PackageLoader("legspring.drawing", "."), undefined=jinja2.StrictUndefined, autoescape=False
    )
