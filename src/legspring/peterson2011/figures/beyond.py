"""Beyond the thesis: the second branch, true stability, back legs that pull, what stability costs, and yaw.

`BEYOND` has the figures by name, in the form of the thesis's own.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from legspring.drawing.style import COLOURS, GRAY, MARKERS, PAGE, label, new_figure, styled, units
from legspring.figures.maps import Limits, add_bar, add_legend, draw_map, family_order, panel_grid
from legspring.peterson2011.claims.chapter2 import SWITCH_DEG
from legspring.peterson2011.figures.chapter4 import COSTS, EIGENVALUES, UNSTABLE
from legspring.peterson2011.figures.chapter6 import AXIS_WORDS
from legspring.peterson2011.figures.families import FAMILY_FIGURES
from legspring.peterson2011.figures.registry import FAMILY_WORDS, ThesisFigure
from legspring.peterson2011.limits import crossings, outline
from legspring.peterson2011.surfaces import names as line_names
from legspring.peterson2011.tables import LEG_WORDS

MOST_DOTS = 30
"""Touch-downs that are shown of a simulation; more would hide the lines."""
EXCESS: Limits = (-0.5, 1.5)
"""Range of colours for a multiplier minus 1, below 0 in stable gaits."""
YAWS: Limits = (0.0, 15.0)
"""Range of colours for yaw, deg."""
BESIDE = 0.05
"""Distance of a name from its line, in parts of an axis."""
DASHES = ("-", "--", "-.", ":")
"""Of lines that may lie on one another."""
BAR, LEAST_BAR = 12.0, 0.02
"""Width of a bar (deg of slope) and its least height (m g)."""
LEAST_SPAN = 0.1
"""Least range of an axis: fronts that are a single point shall not be blown up."""


def second_minus_first(atlas: xr.Dataset) -> xr.Dataset:
    """Return by how much the measures of the second branch exceed those of the first; its families are the second's."""
    both = atlas.reindex(branch=[0, 1], fill_value={"family": ""})
    first, second = both.isel(branch=0), both.isel(branch=1)
    names = ["reduced_eigenvalue", "max_multiplier", "transport_cost"]
    return (second[names] - first[names]).assign(family=second["family"]).assign_attrs(atlas.attrs)


def complete_minus_reduced(atlas: xr.Dataset) -> xr.DataArray:
    """Return by how much the largest multiplier of the complete map exceeds the thesis's eigenvalue."""
    words = {"long_name": "multiplier of the complete map minus eigenvalue of the reduced map"}
    return (atlas["max_multiplier"] - atlas["reduced_eigenvalue"]).assign_attrs(words)


@styled
def second_branch(atlas: xr.Dataset) -> Figure:
    """Draw maps of how much more unstable and costly the second branch is than the first."""
    change = second_minus_first(atlas)
    return _two_maps(
        change,
        ("reduced_eigenvalue", "eigenvalue (thesis), second minus published", None),
        ("transport_cost", "transport cost, second minus published", None),
    )


@styled
def true_stability(atlas: xr.Dataset) -> Figure:
    """Draw maps of the complete map's largest multiplier, and of how much it exceeds the thesis's eigenvalue."""
    first = atlas.isel(branch=0)
    return _two_maps(
        first.assign(excess=complete_minus_reduced(first)),
        ("max_multiplier", "largest multiplier, complete map", EIGENVALUES),
        ("excess", "complete minus reduced map (thesis)", None),
    )


@styled
def back_legs_pull(back_pulls: xr.Dataset) -> Figure:
    """Draw maps of stability and cost of the gaits whose back legs pull."""
    return _two_maps(
        back_pulls.isel(branch=0),
        ("max_multiplier", "largest multiplier, complete map", EIGENVALUES),
        ("transport_cost", "transport cost", COSTS),
    )


def most_stable(gaits: xr.Dataset) -> xr.Dataset:
    """Return the most stable gait of each cell, by the complete map."""
    chosen: xr.Dataset = gaits.isel(branch=gaits["max_multiplier"].fillna(np.inf).argmin("branch"))
    return chosen.drop_vars("branch")


@styled
def yaw(yawing: xr.Dataset) -> Figure:
    """Draw maps of stability and of the yaw's amplitude of gaits of a body that yaws, the most stable of each cell."""
    best = most_stable(yawing)
    return _two_maps(
        best.assign(excess=best["max_multiplier"] - 1.0),
        ("excess", "largest multiplier, complete map, minus 1", EXCESS),
        ("yaw_amplitude", "amplitude of the yaw (deg)", YAWS),
    )


@styled
def yaw_forces(ranges: xr.Dataset) -> Figure:
    """Draw the ranges of peak forces against slope: as measured, of point masses and of bodies with hips and yaw.

    Parameters
    ----------
    ranges
        Over leg, axis, slope_deg and extreme; ``measured``, and a variable for each body.
    """
    figure = new_figure(PAGE, 0.66 * PAGE)
    panels = figure.subplots(2, 2, sharex=True, sharey="row")
    places = [(leg, axis) for leg in ("F", "B") for axis in ("lateral", "fore_aft")]
    for letter, axes, (leg, axis) in zip("abcd", panels.flat, places, strict=True):
        _ranges(axes, ranges.sel(leg=leg, axis=axis))
        axes.set_title(f"{letter}) {LEG_WORDS[leg]} legs, {AXIS_WORDS[axis]}")
    figure.supxlabel("slope (deg)")
    figure.supylabel(f"peak force ({units('m g')})")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=len(ranges.data_vars))
    return figure


def _ranges(axes: Axes, ranges: xr.Dataset) -> None:
    """Draw the ranges of one force: measured ones as wide bars, the others side by side within them."""
    slopes, names = ranges["slope_deg"].values, [str(name) for name in ranges.data_vars if name != "measured"]
    axes.axhline(0.0, color=GRAY, linewidth=0.6)
    axes.use_sticky_edges = False
    for number, name in enumerate(["measured", *names]):
        low, high = (ranges[name].sel(extreme=extreme).values for extreme in ("min", "max"))
        look: dict[str, Any] = {"width": BAR, "color": "0.85", "label": name}
        shift = 0.0
        if number:
            look |= {"width": 0.6 * BAR / len(names), "color": COLOURS[number - 1]}
            shift = BAR / len(names) * (number - 0.5 - 0.5 * len(names))
        # A range of a single force would not show.
        axes.bar(slopes + shift, np.maximum(high - low, LEAST_BAR), bottom=low, **look)
    axes.set_xticks(slopes)


def _two_maps(gaits: xr.Dataset, *panels: tuple[str, str, Limits | None]) -> Figure:
    """Draw maps side by side, each in its own colours; panels are of a variable, a title and limits."""
    figure, grid = panel_grid(len(panels))
    maps = []
    for letter, axes, (name, title, limits) in zip("ab", grid, panels, strict=True):
        maps.append(draw_map(axes, gaits, name, limits=limits, title=f"{letter}) {title}")._replace(words=""))
        add_bar(figure, maps[-1:])
    add_legend(figure, maps)
    return figure


@styled
def decay(decays: xr.Dataset) -> Figure:
    """Draw the distance of disturbed gaits from undisturbed ones against time, beside both predictions.

    Parameters
    ----------
    decays
        Of `legspring.peterson2011.decay.decays`.
    """
    columns = min(3, decays.sizes["gait"])
    rows = -(-decays.sizes["gait"] // columns)
    figure = new_figure(PAGE, 0.33 * PAGE * rows)
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for number, axes in enumerate(panels.flat):
        if number < decays.sizes["gait"]:
            _decay_of_one(axes, decays.isel(gait=number))
        else:
            axes.remove()
    figure.supxlabel("strides")
    figure.supylabel("distance from the gait")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def _decay_of_one(axes: Axes, one: xr.Dataset) -> None:
    """Draw the distance of one gait; both predictions start where the fit does."""
    strides, distance = one["stride"].values, one["distance"].values
    low, high = one.attrs["fit_from"], one.attrs["fit_to"]
    below = np.flatnonzero(distance < 0.1 * low)
    end = min(below[0] + 4 if len(below) else len(strides), len(strides))
    start = int(np.argmax(distance < high))
    axes.axhspan(low, high, color="0.93", linewidth=0.0, label="fitted")
    axes.plot(
        strides[:end],
        distance[:end],
        "o",
        color=GRAY,
        markersize=2.5,
        markevery=-(-end // MOST_DOTS),
        label="simulated",
    )
    later = strides[start:end] - strides[start]
    for name, words, line, colour in (
        ("max_multiplier", "complete map", "-", COLOURS[0]),
        ("reduced_eigenvalue", "reduced map (thesis)", "--", COLOURS[1]),
    ):
        predicted = distance[start] * float(one[name]) ** later
        axes.plot(strides[start:end], predicted, line, color=colour, label=words)
    axes.set(yscale="log", title=str(one["gait"].item()), ylim=(1e-2 * low, 1e4 * high), xlim=(0.0, None))


@styled
def trade_off(fronts: xr.Dataset) -> Figure:
    """Draw eigenvalue against cost from the most stable to the cheapest gait of each family, a panel for each slope.

    Parameters
    ----------
    fronts
        Over slope_deg, family and point; heading (rad) is among its attributes.
    """
    slopes = fronts["slope_deg"].values
    columns = min(len(slopes), 2)
    rows = -(-len(slopes) // columns)
    figure = new_figure(PAGE, 0.38 * PAGE * rows)
    panels = figure.subplots(rows, columns, squeeze=False)
    for axes in panels.flat[len(slopes) :]:
        axes.remove()
    lines: dict[str, Line2D] = {}
    for axes, slope in zip(panels.flat, slopes, strict=False):
        lines |= _fronts_of_slope(axes, fronts.sel(slope_deg=slope))
        axes.set_title(f"{slope:g} deg, {fronts.attrs['heading']:g} rad")
    ends = [
        Line2D(
            [], [], linestyle="none", marker="o", markersize=8, markeredgecolor=GRAY, markerfacecolor=face, label=words
        )
        for face, words in ((GRAY, "most stable"), ("white", "cheapest"))
    ]
    figure.supxlabel("transport cost")
    figure.supylabel("largest eigenvalue magnitude (thesis)")
    families = [lines[str(family)] for family in fronts["family"].values if str(family) in lines]
    figure.legend(handles=[*families, *ends], loc="outside upper center", ncols=len(families) + 2)
    return figure


def _fronts_of_slope(axes: Axes, fronts: xr.Dataset) -> dict[str, Line2D]:
    """Draw a front for each family that has one; return their lines."""
    lines = {}
    for number, family in enumerate(map(str, fronts["family"].values)):
        front = fronts.sel(family=family).dropna("point")
        cost, eigenvalue = front["transport_cost"].values, front["reduced_eigenvalue"].values
        if not len(cost):
            continue
        look: dict[str, Any] = {"color": COLOURS[number % len(COLOURS)], "marker": MARKERS[number % len(MARKERS)]}
        (lines[family],) = axes.plot(cost, eigenvalue, "-", label=family, **look)
        # Hollow over filled where both ends are one gait.
        axes.plot(cost[:1], eigenvalue[:1], markersize=8, zorder=3, **look)
        axes.plot(cost[-1:], eigenvalue[-1:], markersize=5.5, markerfacecolor="white", zorder=4, **look)
    for limits, change in ((axes.get_xlim(), axes.set_xlim), (axes.get_ylim(), axes.set_ylim)):
        middle, span = 0.5 * sum(limits), max(1.1 * (limits[1] - limits[0]), LEAST_SPAN)
        change(middle - 0.5 * span, middle + 0.5 * span)
    axes.ticklabel_format(useOffset=False)
    return lines


@styled
def single_leg(legs: xr.Dataset) -> Figure:
    """Draw stability and robustness of one leg that pushes or pulls against slope, for some headings.

    Parameters
    ----------
    legs
        Over variant, function, slope_deg and heading; the first variant is drawn.
    """
    figure = new_figure(PAGE, 0.42 * PAGE)
    panels = figure.subplots(1, 2, sharex=True)
    shown = legs.isel(variant=0)
    headings = shown["heading"].values.tolist()
    for axes, name in zip(panels, ("max_multiplier", "recovery_steps"), strict=True):
        for colour, function in zip(COLOURS, ("push", "pull"), strict=False):
            for number, heading in enumerate(headings):
                values = shown[name].sel(function=function, heading=heading)
                shade = 0.35 + 0.65 * number / max(len(headings) - 1, 1)
                words = f"{function}, {heading:g} rad"
                axes.plot(values["slope_deg"], values, ".-", color=colour, alpha=shade, label=words)
        for slope in SWITCH_DEG:
            axes.axvline(slope, color=GRAY, linestyle=":", linewidth=0.8)
        axes.set_xlabel("slope (deg)")
    panels[0].axhline(1.0, color=GRAY, linewidth=0.6)
    panels[0].set(ylim=(0.0, 2.0), ylabel="largest multiplier", title="a) stability")
    panels[1].set(ylim=(0.0, None), ylabel="steps to recover", title="b) robustness")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(headings))
    return figure


@styled
def surfaces(lines: xr.Dataset) -> Figure:
    """Draw the lines over slope and heading at which families of gaits end.

    Parameters
    ----------
    lines
        Of `legspring.peterson2011.surfaces.lines`.
    """
    figure = new_figure(PAGE, 0.5 * PAGE)
    axes = figure.subplots()
    words, met = line_names(lines), []
    for n, name in words.items():
        met += [] if name in met else [name]
        one = lines.isel(line=n)
        look = "-" if one["kind"] == "fold" else "--"
        label = name if list(words.values()).index(name) == n else None
        axes.plot(one["slope_deg"], one["heading"], look, color=COLOURS[met.index(name) % len(COLOURS)], label=label)
    axes.plot(lines["cusp_slope_deg"], lines["cusp_heading"], "^", color="black", linestyle="", label="cusp")
    spots = zip(*(lines[f"label_{name}"].values for name in ("slope_deg", "heading", "family")), strict=True)
    for slope_deg, heading, family in spots:
        box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        axes.text(slope_deg, heading, str(family), ha="center", va="center", bbox=box)
    axes.set(xlabel="slope (deg)", ylabel="heading (rad)", xlim=(0.0, 90.0), ylim=(0.0, None))
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


@styled
def survival(found: xr.Dataset) -> Figure:
    """Draw what gaits survive against their largest multiplier.

    Parameters
    ----------
    found
        Of `legspring.peterson2011.survival.survivals`.
    """
    names = ("recovery_steps", "least_push", "roughest")
    labels = ("steps back from 0.5 m v_des", "least push not survived (m v_des)", "slope noise survived (deg)")
    figure = new_figure(PAGE, 0.36 * PAGE)
    panels = figure.subplots(1, len(names), sharex=True)
    families = sorted(set(found["family"].values.tolist()))
    for axes, name, about in zip(panels, names, labels, strict=True):
        top = float(found[name].max())
        for number, family in enumerate(families):
            one = found.isel(gait=found["family"].values == family)
            known = one[name].notnull().values
            look: dict[str, Any] = {"linestyle": "none", "marker": MARKERS[number], "color": COLOURS[number]}
            axes.plot(one["max_multiplier"][known], one[name][known], label=family, **look)
            more = one["max_multiplier"].values[~known]
            axes.plot(more, np.full(len(more), 1.06 * top), markerfacecolor="white", **look)
        axes.set(xlabel="largest multiplier", ylabel=about)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(families))
    return figure


def label_places(limits: xr.Dataset) -> dict[str, tuple[float, float]]:
    """Return where to write the name of each family: beside its line, where there are gaits, far from other lines."""
    low, high = (np.array([limits[name].values[n] for name in ("slope_deg", "heading")]) for n in (0, -1))
    span = high - low
    on_lines = {family: np.array(crossings(limits.sel(family=family))) for family in family_order(limits)}
    places, taken = {}, [np.array([corner]) for corner in ((0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0))]
    for family, pairs in on_lines.items():
        if not len(pairs):
            continue
        lines, cells = ((pairs[:, n] - low) / span for n in (0, 1))
        ways = cells - lines
        spots = lines + BESIDE * ways / np.linalg.norm(ways, axis=1, keepdims=True)
        others = [(rest[:, 0] - low) / span for name, rest in on_lines.items() if len(rest) and name != family]
        around = np.vstack([*others, *taken])
        room = np.min(np.linalg.norm(spots[:, None] - around[None], axis=2), axis=1)
        best = spots[int(np.argmax(np.where(np.all((spots > 0.04) & (spots < 0.96), axis=1), room, -1.0)))]
        taken.append(best[None])
        places[family] = tuple((low + span * best).tolist())
    return places


@styled
def optimised_limits(limits: xr.Dataset) -> Figure:
    """Draw the lines over slope and heading at which optimised gaits of each family cease to exist.

    Parameters
    ----------
    limits
        Of `legspring.peterson2011.limits.limits`.
    """
    objectives = [str(objective) for objective in limits["objective"].values]
    figure = new_figure(PAGE, 0.42 * PAGE)
    panels = figure.subplots(1, len(objectives), sharex=True, sharey=True, squeeze=False)[0]
    for axes, objective in zip(panels, objectives, strict=True):
        names = label_places(limits.sel(objective=objective))
        for number, family in enumerate(family_order(limits)):
            pieces = list(outline(limits.sel(objective=objective, family=family)))
            lines = LineCollection(pieces, colors=COLOURS[number], linestyles=DASHES[number], label=family)
            axes.add_collection(lines)
            if family in names:
                axes.text(*names[family], family, color=COLOURS[number], ha="center", va="center")
        axes.set(title=objective, xlabel=label(limits["slope_deg"].attrs), ylabel=label(limits["heading"].attrs))
        axes.set(xlim=limits["slope_deg"].values[[0, -1]], ylim=limits["heading"].values[[0, -1]])
        axes.label_outer()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


BEYOND: Mapping[str, ThesisFigure] = {
    figure.number: figure
    for figure in (
        ThesisFigure(
            "beyond_second_branch",
            "atlas",
            second_branch,
            "The second gait of a cell minus the published one: a) largest eigenvalue magnitude as the thesis has it, "
            "b) transport cost. Where it is blue, the second is the more stable or the cheaper one. Markers show the "
            f"second gait's family ({FAMILY_WORDS}); cells hatched in grey have no second gait.",
        ),
        ThesisFigure(
            "beyond_surfaces",
            "surfaces",
            surfaces,
            "Where the families of gaits with the thesis's actuation begin and end, over slope and heading. Solid: "
            "lines of folds, in which two gaits meet and beyond which there are none; in the cusp one turns back. "
            "Dashed: lines on which a leg has nothing to do; across them it pushes instead of pulling. "
            f"{FAMILY_WORDS}; none: all pull. Letters stand at slopes at which gaits were followed.",
        ),
        ThesisFigure(
            "beyond_limits",
            "limits",
            optimised_limits,
            "Where gaits with optimised actuation cease to exist, by family: Figure 5.1 with lines in place of dots. "
            "Each line was sought between a cell with a gait and its neighbour without one, by following the optimum "
            "there, to a thirty-second of a cell. Letters stand on the side on which there are gaits. "
            f"{FAMILY_WORDS}.",
        ),
        ThesisFigure(
            "beyond_survival",
            "survivals",
            survival,
            "What gaits with the thesis's actuation survive, against their stability: steps until they are back from a "
            "sideways push; the least push, in any of eight directions at any of four moments of a stride, that they "
            "do not survive; the noise of the slope from step to step, a standard deviation, that half of the runs "
            f"survive. Hollow, above: they survive all that was tried. {FAMILY_WORDS}.",
        ),
        ThesisFigure(
            "beyond_true_stability",
            "atlas",
            true_stability,
            "Stability of the published gaits: a) largest magnitude of the complete map's multipliers, which says how "
            "much of a disturbance a stride leaves, in the colours of Figure 4.2; b) the same minus the thesis's "
            f"eigenvalue. Where it is red, the gait is less stable than the thesis has it. {UNSTABLE}",
        ),
        ThesisFigure(
            "beyond_decays",
            "decays",
            decay,
            "Decay of small disturbances of published gaits. Dots: distance from the undisturbed gait at each "
            "touch-down, in simulations. Lines: slopes that the two maps predict, from where the fit begins. The "
            "fit uses the shaded range, below the first transient and above the accuracy of the integration.",
        ),
        ThesisFigure(
            "beyond_back_legs_pull",
            "back_pulls",
            back_legs_pull,
            "Gaits whose back legs pull: a) largest magnitude of the complete map's multipliers, b) transport cost. "
            "Markers show which legs push (F: front; M: middle; none: all legs pull). Where there are several in a "
            f"cell, the one with the most negative phase of the back legs is shown. {UNSTABLE}",
        ),
        ThesisFigure(
            "beyond_trade_off",
            "fronts",
            trade_off,
            "Stability against efficiency: largest eigenvalue magnitude and transport cost of gaits with optimised "
            "actuation, for each slope and family. Along a line, no gait is both more stable and cheaper than another "
            "one; a family with a single point has no conflict. The axes differ from panel to panel.",
        ),
        *FAMILY_FIGURES,
        ThesisFigure(
            "beyond_single_leg",
            "single_leg",
            single_leg,
            "One leg that pushes or pulls: a) largest multiplier of the most stable gait, b) steps to recover from an "
            "impulse of 0.5, the more of both sides, against slope, for some headings; the leg has the length of the "
            "middle ones and the stiffness of three. Between the dotted lines, by the thesis, pushing gives way to "
            "pulling. Larger multipliers than 2 are not shown in a), gaits that do not recover not in b).",
        ),
        ThesisFigure(
            "beyond_yaw",
            "yawing",
            yaw,
            "The cockroach as a rigid body that yaws, its hips where they are: the most stable gait of each cell. "
            "a) Largest magnitude of the complete map's multipliers, minus 1: where it is red, small disturbances "
            f"grow. b) Largest yaw to either side. Markers show the families ({FAMILY_WORDS}). {UNSTABLE}",
        ),
        ThesisFigure(
            "beyond_yaw_forces",
            "yaw_forces",
            yaw_forces,
            "Peak forces of front and back legs, from the smallest to the largest over headings of 0.05 to 0.40 rad: "
            "as measured (wide bars), of the point mass (published gaits, and all), of a body with hips whose yaw "
            "is held, and of one that yaws.",
        ),
    )
}
