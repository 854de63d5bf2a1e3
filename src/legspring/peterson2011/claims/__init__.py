"""The claims of D. E. Peterson's thesis (2011), each judged by criteria in numbers.

`CLAIMS` lists them; each has a function that looks at the results and judges the claim's parts. What the
thesis's words are taken to mean is in `legspring.peterson2011.claims.criteria`, where it can mean less or more, too.
"""

import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace

from legspring.peterson2011.claims import chapter2, chapter4, chapter5, chapter6
from legspring.peterson2011.claims.criteria import MEANINGS
from legspring.peterson2011.claims.evidence import Outcome, Part, Results, Verdict, combine

__all__ = ["CLAIMS", "Claim", "Outcome", "Part", "Results", "Verdict", "judge"]

NOT_SO = {
    Outcome.FAILS: "Not so",
    Outcome.PARTLY: "Partly so",
    Outcome.UNDECIDED: "Undecided",
    Outcome.OPEN: "Not checked",
}
"""How to begin to say what does not simply hold."""


@dataclass(frozen=True)
class Claim:
    """A claim of the thesis, in our words, and the function that judges its parts."""

    number: int
    chapter: int
    text: str
    parts: Callable[[Results], list[Part]]

    def judge(self, results: Results) -> Verdict:
        """Judge the claim by its parts, and see which would come out otherwise if words meant less, or more."""
        meanings = (replace(results, criteria=criteria) for criteria in MEANINGS.values())
        parts = tuple(
            replace(ours, lenient=lenient.outcome, strict=strict.outcome)
            for lenient, ours, strict in zip(*map(self.parts, meanings), strict=True)
        )
        found = " ".join(part.sentence for part in parts if part.outcome != Outcome.OPEN)
        outcome = combine(part.outcome for part in parts)
        return Verdict(self.number, self.chapter, self.text, outcome, found, _why(parts), parts, self.code)

    @property
    def code(self) -> str:
        """The function that judges it, and the one that looks at either search, where there is one."""
        inner = getattr(sys.modules[self.parts.__module__], f"_{self.parts.__name__}", None)
        return "\n\n".join(inspect.getsource(function).rstrip() for function in (self.parts, inner) if function)


CLAIMS = (
    Claim(
        1,
        4,
        "Most slopes and headings have a gait; high headings on middle slopes do not, and at 0 deg, 0 rad there is "
        "only a trivial one.",
        chapter4.existence,
    ),
    Claim(
        2,
        4,
        "Each slope and heading has one gait, in one family.",
        chapter4.uniqueness,
    ),
    Claim(
        3,
        4,
        "The initial speed follows the desired speed as it falls with slope.",
        chapter4.speed,
    ),
    Claim(
        4,
        4,
        "With rising slope the front legs turn from pushing to pulling, through late phases and short stances; the "
        "middle legs push only at low slopes and headings; the back legs always push, mostly with strongly "
        "negative phases.",
        chapter4.functions,
    ),
    Claim(
        5,
        4,
        "All gaits are stable, most so on steep slopes. On low slopes, headings of 0.3 to 0.4 rad are best and "
        "0.05 to 0.15 rad second best; about 0.20 rad, where the middle legs turn, is worst.",
        chapter4.stability,
    ),
    Claim(
        6,
        4,
        "Most gaits recover from an impulse of half the momentum within ten steps, some need over seventy; "
        "robustness and stability rank gaits alike.",
        chapter4.recovery,
    ),
    Claim(
        7,
        4,
        "At 0.15 rad every gait recovers from every impulse up to 80 %: above 20 deg quickly, at 15 deg most slowly.",
        chapter4.impulses,
    ),
    Claim(
        8,
        4,
        "Gaits of family B cost exactly sin(slope), others more; on low slopes the cost grows with heading and "
        "jumps where the middle legs turn to pulling.",
        chapter4.cost,
    ),
    Claim(
        9,
        5,
        "There are four overlapping families, up to three of them at once; B is missing only on nearly flat "
        "ground, and the back legs never pull.",
        chapter5.families,
    ),
    Claim(
        10,
        5,
        "For stability, front actuation grows with slope and reaches its limit near 50 deg in B; middle actuation "
        "is least in A and grows with heading where those legs pull; back actuation grows with slope, and with "
        "heading where the middle legs push.",
        chapter5.stable_actuation,
    ),
    Claim(
        11,
        5,
        "For stability, the front phase is late where those legs push, the middle phase in MB and in B on steep "
        "slopes; the back phase is almost always negative.",
        chapter5.stable_phase,
    ),
    Claim(
        12,
        5,
        "All optimised gaits are stable, MB and B ideally so except on low slopes; with heading A gets worse and "
        "FB better.",
        chapter5.stability,
    ),
    Claim(
        13,
        5,
        "Stability selects B from 20 deg on; below, A for headings under 0.2 rad and FB above; MB rarely.",
        chapter5.stable_families,
    ),
    Claim(
        14,
        5,
        "Efficiency takes slightly more front and slightly less back actuation than stability; the middle phase is "
        "late where those legs push.",
        chapter5.efficient_gaits,
    ),
    Claim(
        15,
        5,
        "Optimised for efficiency, B costs sin(slope) and MB nearly so; A and FB cost more with slope and heading, "
        "FB less than A.",
        chapter5.efficiency,
    ),
    Claim(
        16,
        5,
        "Efficiency selects B on all but low slopes, from lower ones than stability does; below, A at low headings "
        "and FB from about 0.15 rad.",
        chapter5.efficient_families,
    ),
    Claim(
        17,
        5,
        "Both objectives give nearly the same gaits in FB and B. In A on low slopes they conflict: eigenvalue 0.3 "
        "at a cost of 1.2 against 0.65 at 0.6, with very late middle phases.",
        chapter5.objectives,
    ),
    Claim(
        18,
        6,
        "Measured forces: all legs push on the level; on the vertical front and middle legs pull and back legs "
        "push; the front legs turn at 15 to 30 deg.",
        chapter6.measured,
    ),
    Claim(
        19,
        6,
        "With fixed actuation the front legs turn between 10 and 30 deg, later at higher headings; the middle legs "
        "near 35 deg at low headings, and pull everywhere at high ones; back forces are nearly uniform.",
        chapter6.fixed_forces,
    ),
    Claim(
        20,
        6,
        "For stability, front legs push below 20 deg; middle legs pull above, and below from 0.2 rad. For "
        "efficiency, front legs turn at 10 to 20 deg; middle legs push only below 20 deg and 0.10 rad.",
        chapter6.optimal_forces,
    ),
    Claim(
        21,
        6,
        "Forces are of the measured size, those of front legs of the measured sign; the lateral force of the back "
        "legs, 0.30 to 0.42 m g, is not.",
        chapter6.agreement,
    ),
    Claim(
        22,
        6,
        "On steep slopes, the number of steps to recover comes close to one.",
        chapter6.steep_recovery,
    ),
    Claim(
        23,
        6,
        "Choosing by stability, a cockroach would run at 0.10 to 0.15 rad on low slopes, and by cost at about 0.10 "
        "rad; animals do so at 0.15 +- 0.10 rad.",
        chapter6.chosen_heading,
    ),
    Claim(
        24,
        4,
        "From 25 deg on most gaits are ideally stable, robust and cheap: eigenvalues approach zero.",
        chapter4.towards_zero,
    ),
    Claim(
        25,
        5,
        "Under both objectives the gaits of FB and of B have nearly equal eigenvalues; A, FB and MB exist in parts of "
        "the map only.",
        chapter5.same_eigenvalues,
    ),
    Claim(
        26,
        6,
        "Legs are down for more than half of a stride: in animals for 52 to 66 % on the level, 50 to 74 % on the "
        "vertical (quoted from measurements).",
        chapter6.duty,
    ),
    Claim(
        27,
        2,
        "A model with a single active leg has gaits on the level, where it pushes; from slopes of 15 to 40 deg on it "
        "pulls, for stability and robustness (quoted from work before).",
        chapter2.single_leg,
    ),
    Claim(
        28,
        6,
        "The model columns of Tables 6.1 to 6.3: forces of gaits with fixed actuation, and of those best by either "
        "objective.",
        chapter6.printed_forces,
    ),
)
"""What the thesis claims."""


def judge(results: Results) -> list[Verdict]:
    """Judge every claim of the thesis.

    Parameters
    ----------
    results
        Everything computed and measured.

    Returns
    -------
    list of Verdict
        One for each of `CLAIMS`, in order.
    """
    return [claim.judge(results) for claim in CLAIMS]


def _why(parts: tuple[Part, ...]) -> str:
    """Say which parts do not hold, and the reasons as far as they are known."""
    sentences = []
    for outcome, words in NOT_SO.items():
        which = [part for part in parts if part.outcome == outcome]
        if which:
            reasons = " ".join(dict.fromkeys(part.reason for part in which if part.reason))
            sentences.append(f"{words}: {'; '.join(part.what for part in which)}. {reasons}".strip())
    return " ".join(sentences)
