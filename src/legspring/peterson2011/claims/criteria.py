"""What words are taken to mean in numbers when claims are judged, and what would come of other meanings."""

from dataclasses import dataclass, field
from typing import Any

SAME = 1e-3
"""Changes below it are none: of eigenvalues, costs, and actuations in units of the leg's length."""
ACCURACY = {"deg": 0.01, "rad": 1e-6, "l0": 1e-3, "m g": 1e-3, "": 1e-3}
"""How exactly numbers are known, by unit: those of optima, as a bound that is soft is met to rounding."""
FEWEST = 6
"""Cells below which a share decides nothing."""


@dataclass(frozen=True)
class Word:
    """What a word of the thesis asks for: the shares of cells in which something is to be so."""

    words: str
    least: float = 0.0
    most: float = 1.0

    @property
    def wanted(self) -> str:
        """The criterion; nothing to say where the word leaves nothing open."""
        if self.least == self.most:
            return ""
        return f"at least {self.least:.0%}" if self.least else f"at most {self.most:.0%}"

    def keeps(self, part: float) -> bool:
        """Whether a share is as the word has it."""
        return self.least <= part <= self.most


ALL, NONE = Word("all", least=1.0), Word("none", most=0.0)


def _criterion(ours: float, words: str) -> Any:
    return field(default=ours, metadata={"words": words})


@dataclass(frozen=True)
class Criteria:
    """What the thesis's words are taken to mean, in numbers. The thesis has none: these are ours."""

    majority: float = _criterion(0.5, "share that 'most' asks for")
    rule: float = _criterion(0.75, "share that a statement without a quantifier asks for")
    nearly: float = _criterion(0.9, "share that 'nearly all' asks for, or 'everywhere' on one side of a border")
    few: float = _criterion(0.1, "share that 'rarely' allows")
    near: float = _criterion(0.25, "relative deviation that 'near' or 'about' allows")
    border: float = _criterion(2.5, "deg by which a border may be off; half the distance of cells on low slopes")
    factor: float = _criterion(2.0, "ratio up to which forces are 'of the same size'")
    uniform: float = _criterion(0.25, "standard deviation, in units of the mean, up to which forces are 'uniform'")
    quick: float = _criterion(20.0, "steps within which a recovery is 'quick'")
    follows: float = _criterion(0.2, "relative deviation with which a speed 'follows' another one")
    alike: float = _criterion(0.8, "rank correlation from which on two measures rank gaits 'alike'")
    ideal: float = _criterion(0.05, "eigenvalue below which stability is 'ideal'")
    late: float = _criterion(45.0, "deg from which on a phase is 'high'")
    early: float = _criterion(-30.0, "deg below which a phase is 'strongly negative'")
    limit: float = _criterion(0.88, "actuation in l0 that is as good as its limit of 0.9")
    little: float = _criterion(0.25, "actuation in l0 that is 'as little as possible'; its limit is 0.2")
    slight: float = _criterion(0.2, "difference of actuations in l0 that is 'slight'")
    same_actuation: float = _criterion(0.05, "difference of actuations in l0 of gaits that are 'nearly the same'")
    same_phase: float = _criterion(10.0, "difference of phases in deg of gaits that are 'nearly the same'")

    @property
    def most(self) -> Word:
        """What the thesis says of most."""
        return Word("most", least=self.majority)

    @property
    def as_a_rule(self) -> Word:
        """What it says without a quantifier."""
        return Word("so (no quantifier)", least=self.rule)

    @property
    def nearly_all(self) -> Word:
        """What it says of nearly all, or of all on one side of a border."""
        return Word("everywhere", least=self.nearly)

    @property
    def rarely(self) -> Word:
        """What it says is rare."""
        return Word("rarely", most=self.few)


OURS = Criteria()
LENIENT = Criteria(
    rule=0.6, nearly=0.8, few=0.2, near=0.5, border=5.0, factor=3.0, uniform=0.35, quick=30.0, follows=0.3, alike=0.7,
    ideal=0.1, late=30.0, early=-15.0, limit=0.8, little=0.3, slight=0.3, same_actuation=0.1, same_phase=20.0,
)  # fmt: skip
STRICT = Criteria(
    majority=0.75, rule=0.9, nearly=0.97, few=0.05, near=0.1, border=1.25, factor=1.5, uniform=0.15, quick=10.0,
    follows=0.1, alike=0.9, ideal=0.02, late=60.0, early=-45.0, limit=0.89, little=0.21, slight=0.1,
    same_actuation=0.02, same_phase=5.0,
)  # fmt: skip
"""How verdicts would come out if words meant less, or more."""
MEANINGS = {"lenient": LENIENT, "ours": OURS, "strict": STRICT}
