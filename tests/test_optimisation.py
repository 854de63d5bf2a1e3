"""The best actuation: results are gaits, as good as any that other ways find."""

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from legspring import Animal, Gait, cockroach, load_animal, optimize, trade_off
from legspring.actuated import GOAL, Actuated, Map
from legspring.direct import direct, is_programmable, tried
from legspring.kernel.walker import Floats
from legspring.objective import Goal, Objective
from legspring.optimisation import front, is_among, rank, scan, spread_out
from legspring.optimum import TIE, Method, Optimum, best_of
from legspring.peterson2011.constraints import TABLE_3_1

LEAST, MOST = TABLE_3_1.actuation
Case = tuple[float, float, str, Goal, Map]
"""Slope (deg), heading, family; what is minimised, and the map whose eigenvalues count."""
CASES: list[Case] = [
    (0, 0.15, "A", "efficiency", "reduced"),
    (0, 0.15, "A", "stability", "complete"),
    (20, 0.2, "FB", "stability", "complete"),
    (25, 0.3, "B", "stability", "complete"),
    (45, 0.15, "B", "efficiency", "complete"),
    (60, 0.3, "B", "stability", "reduced"),
]


def best(case: Case, method: Method = "default", seed: int = 0) -> Optimum:
    """Return the optimum of a case, searched for but once."""
    return searched(case, method, seed)


@cache
def searched(case: Case, method: Method, seed: int) -> Optimum:
    slope_deg, heading, family, objective, of = case
    found = optimize(
        cockroach(),
        slope_deg=slope_deg,
        heading=heading,
        family=family,
        objective=objective,
        map=of,
        method=method,
        seed=seed,
    )
    assert found is not None
    return found


def candidate(optimum: Gait) -> tuple[Floats, Floats]:
    """Return actuation in units of nominal lengths, and unknowns."""
    actuated = Actuated(optimum.animal, optimum.slope, optimum.heading, optimum.family)
    return optimum.actuation / actuated.lengths, actuated.problem.z_of(optimum)


@pytest.mark.parametrize("method", ["default", "nelder-mead"])
@pytest.mark.parametrize("case", CASES)
def test_an_optimum_is_a_gait_with_the_value_it_claims(case: Case, method: Method) -> None:
    optimum = best(case, method)
    slope_deg, heading, family, objective, of = case
    assert (optimum.slope, optimum.heading, optimum.family) == (math.radians(slope_deg), heading, family)
    assert (optimum.objective, optimum.map, optimum.method) == (objective, of, method)
    assert optimum.residual < 1e-10 and optimum.drift < 1e-6
    assert optimum.invalid() is None
    values = {"reduced": optimum.reduced_eigenvalue, "complete": abs(optimum.multipliers[0])}
    own = optimum.transport_cost if objective == "efficiency" else values[of]
    assert optimum.value == pytest.approx(own, abs=1e-5)
    ratio, z = candidate(optimum)
    assert np.all((ratio >= LEAST) & (ratio <= MOST))
    assert np.all(z[1:] >= TABLE_3_1.phase[0] - 1e-9)
    score = Objective(optimum.animal, optimum.slope, heading, family, objective, of)(ratio, z)
    assert optimum.penalised == pytest.approx(score.total, abs=1e-5)
    assert optimum.ending


@pytest.mark.parametrize("case", CASES)
def test_no_worse_than_the_method_of_the_thesis(case: Case) -> None:
    assert best(case).penalised <= best(case, "nelder-mead").penalised + TIE


@pytest.mark.long
@pytest.mark.parametrize(("case", "seeds"), [(CASES[0], 3), (CASES[2], 3), (CASES[3], 2)])
def test_the_seed_does_not_matter(case: Case, seeds: int) -> None:
    values = [best(case, "default", seed).penalised for seed in range(seeds)]
    assert max(values) - min(values) < TIE


def test_known_optima() -> None:
    assert best(CASES[0]).value == pytest.approx(0.4611, abs=1e-3)
    assert best(CASES[1]).value == pytest.approx(0.1042, abs=1e-3)
    assert best(CASES[3]).value == pytest.approx(0.1300, abs=1e-3)
    # As stable as can be: down to what does not count.
    assert best(CASES[5]).value < TIE


@pytest.mark.parametrize(
    ("case", "known"),
    [
        # What a map finds by passing optima on from cell to cell, and one cell alone once missed.
        ((0, 0.15, "A", "stability", "reduced"), 0.2655),
        ((30, 0.15, "A", "efficiency", "reduced"), 0.9360),
        ((25, 0.2, "A", "stability", "reduced"), 0.2427),
        ((45, 0.0, "B", "stability", "reduced"), 0.0010),
    ],
)
def test_one_cell_finds_what_a_map_does(case: Case, known: float) -> None:
    assert best(case).penalised < known + 1.5 * TIE


def test_nothing_nearby_is_better() -> None:
    for case in CASES[:4]:
        slope_deg, heading, family, goal, of = case
        objective = Objective(cockroach(), math.radians(slope_deg), heading, family, goal, of)
        ratio, z = candidate(best(case))
        changes = 0.03 * np.random.default_rng(1).uniform(-1.0, 1.0, (40, 3))
        totals = [objective(np.clip(ratio + change, LEAST, MOST), z).total for change in changes]
        assert min(totals) > best(case).penalised - TIE
        assert max(totals) > best(case).penalised + 10.0 * TIE


@pytest.mark.parametrize("slope_deg", [45, 90])
def test_the_cheapest_gait_on_the_back_legs_only_lifts_the_body(slope_deg: float) -> None:
    optimum = best((slope_deg, 0.15, "B", "efficiency", "complete"))
    least = math.sin(math.radians(slope_deg))
    assert least - 1e-9 < optimum.value < least + TIE
    assert optimum.penalised < least + TIE
    # As many actuations are as cheap, the smallest is taken: less of it breaks a constraint or costs more.
    objective = Objective(optimum.animal, optimum.slope, 0.15, "B", "efficiency")
    ratio, z = candidate(optimum)
    assert optimum.active
    assert objective(ratio, z).total < least + TIE < objective(0.97 * ratio, z).total
    other = candidate(best((slope_deg, 0.15, "B", "efficiency", "complete"), "nelder-mead"))[0]
    assert np.sum(ratio**2) < np.sum(other**2)


@pytest.mark.parametrize("method", ["default", "nelder-mead"])
def test_none_where_there_is_no_gait(roach: Animal, method: Method) -> None:
    assert optimize(roach, slope_deg=0, heading=0.0, family="B", method=method) is None


@pytest.mark.parametrize("method", ["default", "nelder-mead"])
def test_constraints_of_ones_own(roach: Animal, method: Method) -> None:
    here: dict[str, Any] = {"slope_deg": 60, "heading": 0.3, "family": "B", "objective": "efficiency"}
    rules = replace(TABLE_3_1, actuation=(0.55, 0.7), phase=(-1.2, 0.9))
    optimum = optimize(roach, **here, method=method, constraints=rules)
    assert optimum is not None
    ratio, z = candidate(optimum)
    assert np.all((ratio > 0.55 - 1e-9) & (ratio < 0.7 + 1e-9)) and np.all(z[1:] > -1.2 - 1e-9)
    assert any("the actuation is at least 0.55 l0" in words for words in optimum.active) or method == "nelder-mead"
    usual = optimize(roach, **here, method=method)
    assert usual == optimize(roach, **here, method=method, constraints=TABLE_3_1)
    assert usual is not None and usual.penalised <= optimum.penalised + TIE


def test_all_families_are_searched(roach: Animal) -> None:
    found = optimize(roach, slope_deg=45, heading=0.15, objective="efficiency")
    assert found is not None
    assert found.family == "B"
    assert found.penalised == best(CASES[4]).penalised


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"objective": "beauty"}, "objective = 'beauty'"),
        ({"map": "some"}, "map = 'some'"),
        ({"method": "simplex"}, "method = 'simplex'"),
        ({"constraints": "none"}, "constraints = 'none': must be 'peterson2011'"),
        ({"family": "X"}, "'X'"),
        ({"heading": 2.0}, "heading = 2"),
        ({"slope_deg": 100.0}, "slope_deg = 100"),
        ({"slope_deg": None}, "slope"),
    ],
)
def test_wrong_arguments(roach: Animal, change: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"slope_deg": 45.0, "heading": 0.15, "family": "B"} | change
    with pytest.raises(ValueError, match=message):
        optimize(roach, **arguments)


def test_what_the_programme_is_not_written_for(roach: Animal) -> None:
    """It is tried instead, by the default method alone."""
    assert is_programmable(roach)
    for other in (
        roach.replace(yaw="free", inertia=2.04e-7),
        roach.replace(damping=1e-4),
        roach.without("FL"),
        roach.without("F"),
        roach.replace(**{"F.phase": 0.1}),
        roach.replace(**{"F.offset": 0.1}),
    ):
        assert not is_programmable(other)
    with pytest.raises(ValueError, match="method = 'nelder-mead': must be default for"):
        optimize(roach.without("F"), slope_deg=45, heading=0.15, method="nelder-mead")
    with pytest.raises(ValueError, match="map = 'reduced': must be complete"):
        optimize(load_animal("single_leg"), slope_deg=45, map="reduced")
    with pytest.raises(ValueError, match="heading is missing"):
        optimize(roach, slope_deg=45)


@pytest.mark.long
def test_trials_find_what_the_programme_finds(roach: Animal) -> None:
    """For the cockroach both are there: the trials are no better, and not much worse."""
    place: dict[str, Any] = {"slope_deg": 45, "heading": 0.15, "family": "B"}
    best = optimize(roach, **place)
    objective = direct(roach, math.radians(45), "B", 0.15, "stability", "complete", "peterson2011")
    trial = tried(objective, seed=0)
    assert best is not None and trial is not None
    assert best.penalised - 1e-3 < trial.penalised < best.penalised + 0.02
    assert trial.invalid() is None and trial.value == pytest.approx(abs(trial.multipliers[0]))
    # What the trials charge a gait for is what the programme charges it for.
    own = objective.trial(best)
    assert own.total == pytest.approx(best.penalised, abs=1e-6)


def test_a_front_of_an_animal_with_speeds_of_its_own() -> None:
    gaits = trade_off(load_animal("climbing_template"), family="P", points=4)
    assert gaits
    values = [(abs(gait.multipliers[0]), gait.transport_cost) for gait in gaits]
    assert values == sorted(values) and [cost for _, cost in values] == sorted((c for _, c in values), reverse=True)


@dataclass(frozen=True)
class Told(Optimum):
    """An optimum that costs what it is told to."""

    cost: float = 0.0

    @property
    def transport_cost(self) -> float:
        return self.cost


def told(family: str, penalised: float, cost: float, size: float = 0.5) -> Told:
    """Return an optimum that nobody has computed; its actuation in units of nominal lengths."""
    return Told(
        animal=cockroach(),
        slope=0.5,
        heading=0.15,
        family=family,
        speed=0.3,
        phase=(0.0, 0.0, 0.0),
        actuation=(size * 0.032, size * 0.026, size * 0.019),
        residual=0.0,
        penalised=penalised,
        cost=cost,
    )


@pytest.mark.parametrize(
    ("optima", "winner"),
    [
        ([("A", 0.3, 0.5), ("B", 0.2, 0.9)], "B"),
        ([("A", 0.2009, 0.5), ("B", 0.2, 0.9)], "A"),
        ([("A", 0.2011, 0.5), ("B", 0.2, 0.9)], "B"),
        ([("A", 0.2, 0.5, 0.6), ("B", 0.2, 0.5009, 0.4)], "B"),
        ([("A", 0.2, 0.5, 0.6), ("B", 0.2, 0.5011, 0.4)], "A"),
        # What is no rival for the best is none for the cheapest, either.
        ([("A", 0.2, 0.5, 0.6), ("B", 0.2005, 0.9, 0.2), ("MB", 0.3, 0.1, 0.1)], "A"),
        ([("FB", 0.2, 0.5)], "FB"),
    ],
)
def test_the_best_then_the_cheaper_then_the_less_actuated(optima: list[Any], winner: str) -> None:
    for rows in (optima, optima[::-1]):
        chosen = best_of([told(*row) for row in rows])
        assert chosen is not None and chosen.family == winner


def test_the_best_of_nothing() -> None:
    assert best_of([]) is None


def test_a_scan_finds_the_gaits_of_each_actuation(roach: Animal) -> None:
    objective = Objective(roach, math.radians(45), 0.15, "B", "stability")
    candidates = scan(objective, nodes=32)
    ratios, starts = (np.array(rows) for rows in list(zip(*candidates, strict=True))[:2])
    assert len(candidates) > 20
    assert LEAST <= ratios.min() < 0.3 and 0.8 < ratios.max() <= MOST
    assert np.all(objective.actuated.solve(ratios, starts).residuals < GOAL)
    for number, one in enumerate(candidates):
        before = [other.unknowns for other in candidates[:number] if other.actuation is one.actuation]
        assert not is_among(one.unknowns, before)


def test_candidates_are_ranked_and_spread_out(roach: Animal) -> None:
    objective = Objective(roach, math.radians(45), 0.15, "B", "stability", "reduced")
    candidates = scan(objective, nodes=32)
    ranked = rank(objective, candidates)
    scores = [objective.alone(one.actuation, one.unknowns) for one in ranked]
    totals = [score.total for score in scores if score is not None]
    assert len(totals) == len(ranked) < len(candidates)
    assert totals == sorted(totals)
    few = rank(objective, candidates, totals[5])
    assert few == ranked[:5]
    assert rank(objective, []) == []
    chosen = spread_out(ranked, 3)
    assert len(chosen) <= 3 and chosen[0][1] is ranked[0][1]


@pytest.fixture(scope="module")
def trade() -> list[Gait]:
    return trade_off(cockroach(), slope_deg=10, heading=0.15, family="A", map="reduced", points=5)


def test_a_trade_off_leads_from_the_most_stable_gait_to_the_cheapest(trade: list[Gait]) -> None:
    ends = [best((10.0, 0.15, "A", goal, "reduced")) for goal in ("stability", "efficiency")]
    # Two eigenvalues nearly meet there: the value that the search saw of them has fewer digits.
    assert trade[0].reduced_eigenvalue == pytest.approx(ends[0].reduced_eigenvalue, abs=1e-6)
    assert trade[-1].transport_cost == pytest.approx(ends[1].value, abs=1e-6)
    assert 4 <= len(trade) <= 5
    assert all(gait.invalid() is None and gait.family == "A" for gait in trade)
    eigenvalues, costs = ([getattr(gait, name) for gait in trade] for name in ("reduced_eigenvalue", "transport_cost"))
    assert np.all(np.diff(eigenvalues) > 0.0) and np.all(np.diff(costs) < TIE)
    # Worth it: between the ends both are well below the straight line that joins them.
    middle = np.interp(eigenvalues[1:-1], eigenvalues[:: len(trade) - 1], costs[:: len(trade) - 1])
    assert np.all(costs[1:-1] < middle - 10.0 * TIE)


def test_a_front_stays_within_its_bounds(trade: list[Gait]) -> None:
    objective = Objective(cockroach(), math.radians(10), 0.15, "A", "efficiency", "reduced")
    stable, cheap = objective.candidate(trade[0]), objective.candidate(trade[-1])
    scores = front(objective, stable, cheap, 3)
    low, middle, high = (objective.eigenvalue(score) for score in scores)
    assert middle < 0.5 * (low + high) + TIE
    # One and the same gait leaves nothing to trade; what is no gait is no end.
    assert len(front(objective, cheap, cheap, 5)) == 2
    assert front(objective, stable._replace(unknowns=np.array([1.0, 3.0, 3.0, 3.0])), cheap, 3) == []


def test_trade_offs_of_nothing(roach: Animal) -> None:
    assert trade_off(roach, slope_deg=0, heading=0.0, family="B") == []
    with pytest.raises(ValueError, match="points = 1: must be a whole number from 2 to 1000"):
        trade_off(roach, slope_deg=10, heading=0.15, family="A", points=1)
