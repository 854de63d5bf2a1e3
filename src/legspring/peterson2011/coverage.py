"""Everything that the thesis has, where it is in the report or the package, and how well it agrees."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from legspring.peterson2011.claims import Verdict
from legspring.peterson2011.claims.evidence import exists
from legspring.peterson2011.force_tables import CLEAR, OBJECTIVES
from legspring.peterson2011.tables import Table


class Entry(NamedTuple):
    """A part of the thesis: where it is here, claims that are about it, and what else there is to say.

    The last may name what `facts` has found in braces.
    """

    part: str
    subject: str
    where: str
    claims: tuple[int, ...] = ()
    words: str = ""


INTEGRATORS = "States agree with those of two integrators of another make to 1e-10, in the package's tests."
PROGRAMS = "Ours are checked in the package's tests against numbers of the author's programs, run again."
NO_NUMBERS = "Drawn from a computed gait; there are no numbers to compare."

ENTRIES = (
    Entry("Chapters 1, 2", "the model with one leg that was there before", "Beyond the thesis", (27,)),
    Entry("Figures 2.1, 3.1", "sketches of the model, and of the conditions of a gait", "same numbers", (), NO_NUMBERS),
    Entry(
        "Figure 2.2",
        "lengths of the legs over four steps",
        "same number",
        (),
        "Simulated with the phases that the thesis states; slope, heading and speed, which it does not, are ours.",
    ),
    Entry("Eqs. 2.1, 2.2", "force and force-free length of a leg", "all simulations", (), INTEGRATORS),
    Entry("Eqs. 2.3-2.6", "motion and foot placement", "all simulations; with hips and yaw: beyond", (), INTEGRATORS),
    Entry(
        "Section 2.4",
        "scaling to a robot",
        "Animal.scale",
        (),
        "Phases, multipliers and costs of scaled animals are the same, in the package's tests.",
    ),
    Entry("Eqs. 3.1-3.4, section 3.2", "conditions of a gait", "all gaits", (), "Met to {residual} by {gaits} gaits."),
    Entry(
        "Section 3.3",
        "eigenvalues",
        "Figure 4.2; True stability",
        (5,),
        "Exact, in place of differences; the thesis's map is not that of the whole state.",
    ),
    Entry("Section 3.4, Figure 3.2", "push, and steps to recover", "Figures 3.2, 4.3, 4.4", (6, 7)),
    Entry("Eq. 3.5", "work with weights b1 and b2", "Animal.work_weights", (), "Both are 1 here, as in the thesis."),
    Entry("Eqs. 3.6, 4.1", "transport cost and its least value", "Figure 4.5", (8,), "Least cost less sine: {least}."),
    Entry(
        "Section 3.5, Table 3.1",
        "optimisation and its constraints",
        "Table 3.1, chapter 5",
        (28,),
        "The penalties are those of the appendix.",
    ),
    Entry("Table 4.1", "parameters", "same number", (), "The same numbers; step durations are by the thesis's fit."),
    Entry("Figure 4.1", "fixed actuation: speed and phases", "same number; by family: beyond", (1, 2, 3, 4)),
    Entry("Figure 4.2", "eigenvalues", "same number", (5, 24)),
    Entry("Figure 4.3", "steps to recover", "same number", (6,)),
    Entry("Figure 4.4", "steps to recover from impulses of all sizes", "same number", (7,)),
    Entry("Figure 4.5", "transport cost", "same number", (8, 24)),
    Entry("Figure 5.1", "existence of optimised gaits", "same number, by both searches", (9, 25)),
    Entry("Figures 5.2-5.4", "stability: actuations", "same numbers, by both searches", (10,)),
    Entry("Figures 5.5-5.7", "stability: phases", "same numbers, by both searches", (11,)),
    Entry("Figures 5.8, 5.9", "stability: eigenvalues", "same numbers, by both searches", (12, 13)),
    Entry("Figures 5.10, 5.11", "stability: costs", "same numbers, by both searches", (17,)),
    Entry("Figures 5.12-5.14", "efficiency: actuations", "same numbers, by both searches", (14,)),
    Entry("Figures 5.15-5.17", "efficiency: phases", "same numbers, by both searches", (14,)),
    Entry("Figures 5.18, 5.19", "efficiency: costs", "same numbers, by both searches", (15, 16)),
    Entry("Figures 5.20, 5.21", "efficiency: eigenvalues", "same numbers, by both searches", (12, 25)),
    Entry("Figures 6.1, 6.2", "forces of animals", "same numbers", (18,), "The printed numbers of Tables 6.1-6.3."),
    Entry("Figures 6.3, 6.4", "forces, fixed actuation", "same numbers", (19,)),
    Entry("Figures 6.5, 6.6", "forces, for stability", "same numbers, by both searches", (20,)),
    Entry("Figures 6.7, 6.8", "forces, for efficiency", "same numbers, by both searches", (20,)),
    Entry(
        "Tables 6.1-6.3", "fixed actuation", "same numbers", (21,), "{fixed} of {printed} numbers agree to 0.02 m g."
    ),
    Entry(
        "Tables 6.1-6.3",
        "optimised actuation",
        "same numbers, and two tables on them",
        (28,),
        "For stability {stability}, for efficiency {efficiency} of {printed} numbers agree to {clear:g} m g.",
    ),
    Entry("Chapters 6, 7", "conclusions", "claims", (22, 23, 26)),
    Entry(
        "Programs: a run and its plots",
        "positions, velocities, yaw, energy, lengths, forces, moment",
        "legspring simulate; draw_motion, draw_energy",
        (),
        INTEGRATORS,
    ),
    Entry(
        "Programs: stance, lift-off, forces, foot placement, hips, first feet",
        "parts of the simulation",
        "all simulations",
        (),
        INTEGRATORS,
    ),
    Entry("Programs: frequency fit", "step durations", "Table 4.1", (), "The thesis's durations to all its digits."),
    Entry(
        "Programs: fixed points, with a choice of unknowns",
        "speed, phases, also placement angles, actuations, step duration",
        "find_gaits, with free=",
        (),
        f"For speed and phases: {PROGRAMS[0].lower()}{PROGRAMS[1:]}",
    ),
    Entry("Programs: eigenvalues by differences", "stability", "Gait.reduced_eigenvalue", (), PROGRAMS),
    Entry("Programs: speed and heading to velocities", "conversion", "every start", (), INTEGRATORS),
    Entry("Programs: flood fill", "gaits over slope and heading", "ls.atlas; chapter 4", (1, 2)),
    Entry(
        "Programs: optimisation with penalties, by families",
        "amplitudes for stability and efficiency",
        "ls.optimize; chapter 5, where the same search is run again",
        (28,),
    ),
    Entry(
        "Programs: robustness, fixed and optimised",
        "steps to recover",
        "Figures 4.3, 4.4; Every family for itself",
        (6, 7, 22),
    ),
    Entry("Programs: comparison of forces", "a norm of errors", "table of errors in chapter 6", (21,)),
    Entry("Programs: plots", "all figures", "chapters 2 to 6", (), "Drawn anew, in the thesis's ranges of colours."),
)


def facts(atlas: xr.Dataset, ranges: xr.Dataset) -> dict[str, str | int | float]:
    """Find the numbers that entries name.

    Parameters
    ----------
    atlas
        Gaits with the thesis's actuation.
    ranges
        Of `legspring.peterson2011.force_tables.force_ranges`.
    """
    there = exists(atlas)
    excess = (atlas["transport_cost"] - np.sin(np.radians(atlas["slope_deg"]))).where(there)
    agree = {name: abs(ranges[name] - ranges[f"{name}_thesis"]) for name in ("model", *OBJECTIVES)}
    return {
        "residual": f"{float(atlas['residual'].max()):.0e}" if there.any() else "-",
        "gaits": int(there.sum()),
        "least": f"{float(excess.min()):.0e}" if there.any() else "-",
        "fixed": int((agree["model"] <= 0.02).sum()),
        "printed": int(ranges["model_thesis"].notnull().sum()),
        "clear": CLEAR,
        **{name: int((agree[name] <= CLEAR).sum()) for name in OBJECTIVES},
    }


def coverage_table(verdicts: Sequence[Verdict], known: Mapping[str, str | int | float]) -> Table:
    """Return what the thesis has, where it is here, and how well it agrees.

    Parameters
    ----------
    verdicts
        On all claims.
    known
        Of `facts`.
    """
    outcomes = {verdict.number: verdict.verdict for verdict in verdicts}

    def agreement(entry: Entry) -> str:
        judged = [f"Claim {number} {outcomes[number]}." for number in entry.claims if number in outcomes]
        return " ".join(filter(None, [entry.words.format(**known), *judged]))

    return Table(
        "",
        "What the thesis has, where it is here, and how well it agrees.",
        ("in_the_thesis", "what", "here", "agreement"),
        tuple((entry.part, entry.subject, entry.where, agreement(entry)) for entry in ENTRIES),
    )
