"""What there is beyond the thesis: a chapter of the report. Every number in it is computed from the data."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import compress
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from legspring.peterson2011.claims.evidence import animal_of, exists
from legspring.peterson2011.decay import NUDGE
from legspring.peterson2011.figures.beyond import BEYOND, complete_minus_reduced, second_minus_first
from legspring.peterson2011.figures.families import FAMILY_FIGURES
from legspring.peterson2011.fronts import SAME as NO_DIFFERENCE
from legspring.peterson2011.fronts import undominated
from legspring.peterson2011.report import Picture, Section
from legspring.peterson2011.tables import LEG_WORDS, Cell, Table

SAME = 1e-6
"""Differences below it are none."""
STABLE = 0.1
"""Eigenvalue below which we speak of a gait that is all but ideally stable."""
STRIKING = 5
"""How many cells of each kind a table names."""


def sections(
    atlas: xr.Dataset,
    decays: xr.Dataset,
    back_pulls: xr.Dataset,
    fronts: xr.Dataset,
    surfaces: Section,
    survival: Section,
    families: Section,
    single_leg: Section,
    yaw: Section,
    pictures: Mapping[str, Path],
) -> list[Section]:
    """Write the chapter.

    Parameters
    ----------
    atlas
        Gaits with the thesis's actuation, of `legspring.atlas`; branch 0 is the published one.
    decays
        Of `legspring.peterson2011.decay.decays`.
    back_pulls
        An atlas of the families in which the back legs pull.
    fronts
        Gaits from the most stable to the cheapest of each family: ``reduced_eigenvalue`` and ``transport_cost`` over
        slope_deg, family and point, missing where there is none; heading (rad) is among its attributes.
    surfaces
        Of `legspring.peterson2011.surfaces.section`.
    survival
        Of `legspring.peterson2011.survival.section`.
    families
        Of `legspring.peterson2011.families.section`.
    single_leg
        Of `legspring.peterson2011.single_leg.section`.
    yaw
        Of `legspring.peterson2011.yawing.section`.
    pictures
        PNG files of the figures `legspring.peterson2011.figures.beyond.BEYOND`, by name; those missing are left out.
    """
    shown = {name: Picture(path, BEYOND[name].caption) for name, path in pictures.items() if name in BEYOND}
    parts = (
        (_second_branch(atlas), ["beyond_second_branch"]),
        (surfaces, ["beyond_surfaces", "beyond_limits"]),
        (survival, ["beyond_survival"]),
        (_true_stability(atlas, decays), ["beyond_true_stability", "beyond_decays"]),
        (_back_legs_pull(atlas, back_pulls), ["beyond_back_legs_pull"]),
        (_trade_off(fronts), ["beyond_trade_off"]),
        (families, [figure.number for figure in FAMILY_FIGURES]),
        (single_leg, ["beyond_single_leg"]),
        (yaw, ["beyond_yaw", "beyond_yaw_forces"]),
    )
    return [replace(part, figures=[shown[name] for name in names if name in shown]) for part, names in parts]


def _second_branch(atlas: xr.Dataset) -> Section:
    heading = "A second gait in many cells"
    both = atlas.reindex(branch=[0, 1], fill_value={"family": ""})
    first, second = both.isel(branch=0), both.isel(branch=1)
    there, total = exists(second), int(exists(first).sum())
    if not there.any():
        return Section(heading, [f"None of the {total} cells with a gait has a second one."])
    pairs = zip(first["family"].values[there], second["family"].values[there], strict=True)
    same = [str(one) for one, other in pairs if one == other]
    hind = str(atlas["leg"].values[-1])
    stance = [float(gaits["liftoff"].sel(leg=hind).where(there).median()) for gaits in (first, second)]
    return Section(
        heading,
        [
            f"Gaits are not unique: {int(there.sum())} of the {total} cells with a gait have a second one, which the "
            f"thesis does not show. In {len(same)} of them it is of the same family as the published gait "
            f"({_counts(same) or 'none'}). The stance of the {LEG_WORDS.get(hind, hind)} legs lasts {stance[1]:.2f} "
            f"step durations in the second gait and {stance[0]:.2f} in the published one (medians over these cells).",
            f"By the thesis's eigenvalue, the second gait is {_compare(both, 'reduced_eigenvalue', 'stable')}.",
            f"By the complete map's multipliers, it is {_compare(both, 'max_multiplier', 'stable')}.",
            f"It is {_compare(both, 'transport_cost', 'costly')}.",
        ],
        tables=[_striking_cells(both)],
    )


def _compare(both: xr.Dataset, name: str, quality: str) -> str:
    """Say in how many cells the second branch is better and worse in a measure, by how much, and where most."""
    change = second_minus_first(both)[name]
    words = {"stable": ("more stable", "less stable"), "costly": ("cheaper", "dearer")}[quality]
    parts = []
    for word, gain in zip(words, (-change, change), strict=True):
        gain = gain.where(gain > SAME)
        if not gain.notnull().any():
            parts.append(f"{word} in none")
            continue
        cell = _greatest(both, gain)
        before, after = (float(value) for value in cell[name].values)
        parts.append(
            f"{word} in {_number_of(int(gain.count()), 'cell')} ({_spread(gain)}), by {float(gain.median()):.3f} in "
            f"the median and {float(gain.max()):.3f} at most ({_place(cell)}: {after:.3f} instead of {before:.3f})"
        )
    return "; it is ".join(parts)


def _striking_cells(both: xr.Dataset) -> Table:
    """Return the cells in which the second gait gains most in stability, and those in which it gains most in cost."""
    change = second_minus_first(both).stack(cell=("slope_deg", "heading"))
    chosen: list[tuple[float, float]] = []
    for name in ("reduced_eigenvalue", "transport_cost"):
        gained = change[name][(change[name] < -SAME).values]
        chosen += gained.sortby(gained)["cell"].values[:STRIKING].tolist()
    names = {"eigenvalue": "reduced_eigenvalue", "multiplier": "max_multiplier", "cost": "transport_cost"}
    rows: list[tuple[Cell, ...]] = []
    for slope, heading in dict.fromkeys(chosen):
        cell = both.sel(slope_deg=slope, heading=heading)
        numbers = [float(cell[name][branch]) for name in names.values() for branch in (0, 1)]
        families = [str(cell["family"].values[branch]) for branch in (0, 1)]
        rows.append((slope, heading, *families, *numbers))
    columns = [f"{name}_{which}" for name in ("family", *names) for which in ("published", "second")]
    return Table(
        "",
        f"Up to {STRIKING} cells in which the second gait gains most in stability, and as many in which it gains most "
        "in cost. Eigenvalue: of the thesis's map; multiplier: of the complete one.",
        ("slope_deg", "heading_rad", *columns),
        tuple(rows),
    )


def _true_stability(atlas: xr.Dataset, decays: xr.Dataset) -> Section:
    published = atlas.isel(branch=0)
    old, there = (published["liftoff"] > 1.0).any("leg"), exists(published)
    all_old, everywhere = int((atlas["liftoff"] > 1.0).any("leg").sum()), int(exists(atlas).sum())
    return Section(
        "True stability",
        [
            "The thesis's eigenvalues are those of a reduced map: it starts with the feet of the step before where an "
            "undisturbed run would have put them. Those feet matter if legs are still down when the next ones "
            f"touch down, as in {int(old.sum())} of the {int(there.sum())} published gaits "
            f"({_share(int(old.sum()), int(there.sum()))}) and in {all_old} of all {everywhere} "
            f"({_share(all_old, everywhere)}). They remember where the body was a step ago. The complete map therefore "
            "has the displacement over the last step among its variables, and the largest magnitude of its multipliers "
            "is what is left of a disturbance after each stride.",
            _both_maps(published, old),
            _simulated(decays),
        ],
        tables=[_decay_table(decays)],
    )


def _both_maps(gaits: xr.Dataset, old: xr.DataArray) -> str:
    """Say where the two maps agree and where, how often and how much they differ."""
    difference, there = complete_minus_reduced(gaits), exists(gaits)
    parts = []
    if (there & ~old).any():
        largest = float(abs(difference).where(~old).max())
        parts.append(f"Where no leg is left down, both maps agree (to {max(largest, 1e-12):.0e}).")
    if old.any():
        less, more = (int((sign * difference > SAME).sum()) for sign in (1.0, -1.0))
        parts.append(
            f"Elsewhere {_number_of(less, 'gait')} are less stable than the thesis has them and {more} more stable, by "
            f"{float(abs(difference).where(old).median()):.3f} in the median. The difference is greatest at "
            + " and at ".join(_both_values(gaits, sign * difference) for sign in (1.0, -1.0))
            + "."
        )
    multiplier = gaits["max_multiplier"]
    if there.any():
        ideal = [int((gaits[name] < STABLE).sum()) for name in ("reduced_eigenvalue", "max_multiplier")]
        worst = _greatest(gaits, multiplier)
        parts.append(
            f"The largest magnitude is below {STABLE:g}, all but ideal, in {_number_of(ideal[0], 'gait')} by the "
            f"thesis's map and in {ideal[1]} by the complete one. By the latter, {int((multiplier < 1.0).sum())} of "
            f"{int(there.sum())} gaits are stable; the least stable one, with {float(worst['max_multiplier']):.3f}, "
            f"is at {_place(worst)}."
        )
    return " ".join(parts)


def _both_values(gaits: xr.Dataset, difference: xr.DataArray) -> str:
    """Name the gait whose difference is the greatest, and say what each map makes of it."""
    gait = _greatest(gaits, difference)
    reduced, complete = float(gait["reduced_eigenvalue"]), float(gait["max_multiplier"])
    return f"{_place(gait)} (thesis {reduced:.3f}, complete {complete:.3f})"


def _simulated(decays: xr.Dataset) -> str:
    """Say which map simulations bear out."""
    measured = decays["decay"]
    if not measured.notnull().any():
        return "Simulations do not decide which is right: none of them could be fitted."
    errors = {name: np.abs(decays[name] / measured - 1.0) for name in ("max_multiplier", "reduced_eigenvalue")}
    worst = {name: f"{float(error.max()):.1%}" for name, error in errors.items()}
    closer = int((errors["max_multiplier"] < errors["reduced_eigenvalue"]).sum())
    return (
        f"Simulations decide which is right: gaits were disturbed by {NUDGE:g} of their speed and {NUDGE:g} rad, and "
        f"their distance from the undisturbed gait was followed from touch-down to touch-down. What a stride leaves "
        f"of it differs from the complete map's multiplier by {worst['max_multiplier']} at most, and from the thesis's "
        f"eigenvalue by up to {worst['reduced_eigenvalue']}; the complete map is closer in {closer} of "
        f"{_number_of(int(measured.count()), 'gait')}."
    )


def _decay_table(decays: xr.Dataset) -> Table:
    names = ("slope_deg", "heading", "family", "reduced_eigenvalue", "max_multiplier", "decay")
    columns = ("slope_deg", "heading_rad", "family", "thesis's_eigenvalue", "complete_map", "simulated")
    return Table(
        "",
        "What is left of a small disturbance after a stride: by the thesis's reduced map, by the complete map, and in "
        "simulations.",
        columns,
        tuple(zip(*(decays[name].values.tolist() for name in names), strict=True)),
    )


def _back_legs_pull(atlas: xr.Dataset, back_pulls: xr.Dataset) -> Section:
    heading, there = "Gaits whose back legs pull", exists(back_pulls)
    if not there.any():
        return Section(heading, ["A search among the families in which the back legs pull found no gait."])
    published = atlas.isel(branch=0)
    everywhere = int(there.sum(("slope_deg", "heading", "branch")))
    paragraphs = [
        "The thesis reports no gait whose back legs pull. We searched for them in the same way as for all others, "
        f"and found {everywhere} in {_number_of(int(there.any('branch').sum()), 'cell')} of "
        f"{there.isel(branch=0).size} ({_spread(there.where(there))}).",
        f"By the complete map, {int((back_pulls['max_multiplier'] < 1.0).sum())} of the {everywhere} are stable. "
        f"Beside the published gait of the same cell, {_beside(back_pulls, published, 'max_multiplier', 'stable')}; "
        f"{_beside(back_pulls, published, 'transport_cost', 'costly')}.",
    ]
    return Section(heading, paragraphs, tables=[_family_table(back_pulls, published)])


def _beside(gaits: xr.Dataset, published: xr.Dataset, name: str, quality: str) -> str:
    """Say how gaits compare with the published ones of their cells in a measure."""
    change = gaits[name] - published[name]
    better, worse = {"stable": ("more stable", "less stable"), "costly": ("cheaper", "dearer")}[quality]
    text = f"{int((change < -SAME).sum())} are {better} and {int((change > SAME).sum())} {worse}"
    if not (change < -SAME).any():
        return text
    gait = _greatest(gaits, -change)
    before = published[name].sel(slope_deg=gait["slope_deg"], heading=gait["heading"])
    values = f"{float(gait[name]):.3f} instead of {float(before):.3f}"
    return f"{text}, at best by {-float(change.min()):.3f} ({_place(gait)}: {values})"


def _family_table(gaits: xr.Dataset, published: xr.Dataset) -> Table:
    """Return where each family has gaits and what they are like, beside the published gaits of the same cells."""
    rows: list[tuple[Cell, ...]] = []
    for family, pushing in animal_of(gaits).families.items():
        chosen = gaits.where(gaits["family"] == family)
        there = exists(chosen)
        if not there.any():
            continue
        others = published.where(there.any("branch"))
        words = ", ".join(LEG_WORDS.get(pair, pair) for pair in pushing) or "none"
        medians = [
            float(each[name].median()) for name in ("max_multiplier", "transport_cost") for each in (chosen, others)
        ]
        rows.append((words, float(there.sum()), _spread(there.where(there)), *medians))
    names = [f"{name}_{whose}" for name in ("multiplier", "cost") for whose in ("here", "published")]
    return Table(
        "",
        "Gaits whose back legs pull, by the legs that push: how many and where, and the medians of the complete map's "
        "largest multiplier and of the cost, here and of the published gaits in the same cells.",
        ("pushing", "gaits", "where", *names),
        tuple(rows),
    )


def _trade_off(fronts: xr.Dataset) -> Section:
    heading = "What stability costs"
    all_gaits = {slope: _overall_front(fronts.sel(slope_deg=slope)) for slope in fronts["slope_deg"].values.tolist()}
    gaits = {slope: found for slope, found in all_gaits.items() if found}
    if not gaits:
        return Section(heading, ["There are no gaits with optimised actuation to compare."])
    paragraphs = [
        f"A gait may be optimised for stability or for efficiency, or for anything in between. At heading "
        f"{fronts.attrs['heading']:g} rad, the front from the most stable to the cheapest gait was computed for "
        f"{_number_of(len(gaits), 'slope')}, family by family. The table has the front of all families together: the "
        "gaits to which no other one is preferable in both. What a bit of stability costs depends on where on the "
        "front one stands.",
    ]
    if ends := [_ends(slope, front) for slope, front in gaits.items() if len(front) > 1]:
        paragraphs.append(f"Between its ends, the front leads {'; '.join(ends)}.")
    if single := [f"{slope:g}" for slope, front in gaits.items() if len(front) == 1]:
        paragraphs.append(
            f"There is no conflict at {_list(single)} deg: there, one gait is the most stable and the cheapest one."
        )
    return Section(heading, paragraphs, tables=[_front_table(gaits)])


class Compromise(NamedTuple):
    """A gait on a front: largest eigenvalue magnitude of the thesis's map, transport cost, and family."""

    eigenvalue: float
    cost: float
    family: str


def _overall_front(fronts: xr.Dataset) -> list[Compromise]:
    """Return the gaits of a slope, of all families, to which none is preferable; the most stable one comes first."""
    known = fronts.stack(gait=("family", "point")).dropna("gait")
    names = ("reduced_eigenvalue", "transport_cost", "family")
    gaits = sorted(Compromise(*row) for row in zip(*(known[name].values.tolist() for name in names), strict=True))
    points = np.array([gait[:2] for gait in gaits]).reshape(-1, 2)
    return list(compress(gaits, undominated(points)))


def _ends(slope: float, front: Sequence[Compromise]) -> str:
    stable, cheap = front[0], front[-1]
    return (
        f"at {slope:g} deg from {stable.family} with eigenvalue {stable.eigenvalue:.3f} and cost {stable.cost:.3f} to "
        f"{cheap.family} with {cheap.eigenvalue:.3f} and {cheap.cost:.3f}"
    )


def _front_table(gaits: Mapping[float, Sequence[Compromise]]) -> Table:
    return Table(
        "",
        "From the most stable to the cheapest gait of all families, at each slope: every gait that was computed and to "
        f"which none is preferable in both. Differences below {NO_DIFFERENCE:g} count as none.",
        ("slope_deg", "eigenvalue", "cost", "family"),
        tuple((slope, *gait) for slope, front in gaits.items() for gait in front),
    )


def _greatest(gaits: xr.Dataset, values: xr.DataArray) -> xr.Dataset:
    """Return the gait, or the cell of gaits, at which values are greatest."""
    place = np.unravel_index(np.nanargmax(values.values), values.shape)
    return gaits.isel({dim: int(index) for dim, index in zip(values.dims, place, strict=True)})


def _place(gait: xr.Dataset) -> str:
    """Name the cell of a gait."""
    return f"{float(gait['slope_deg']):g} deg, {float(gait['heading']):g} rad"


def _spread(values: xr.DataArray) -> str:
    """Say over which slopes and headings the values that are not missing spread."""
    known = values.notnull()
    ends = []
    for name, unit in (("slope_deg", "deg"), ("heading", "rad")):
        places = known[name].values[known.any([dim for dim in known.dims if dim != name]).values]
        low, high = float(places.min()), float(places.max())
        ends.append(f"{low:g} {unit}" if low == high else f"{low:g} to {high:g} {unit}")
    return ", ".join(ends)


def _counts(words: Sequence[str]) -> str:
    """Count each word."""
    return ", ".join(f"{count} {word}" for word, count in sorted(Counter(words).items()))


def _number_of(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _share(part: float, whole: float) -> str:
    return f"{part / whole:.0%}" if whole else "none"


def _list(words: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))
