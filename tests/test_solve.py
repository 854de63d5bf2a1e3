"""Gaits against the published ones, and against what is known of them."""

import math
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from legspring import Animal, ModelError, find_gaits, load_animal, search_gaits
from legspring.asking import problem_for, tuned
from legspring.gait import Gait, Invalid
from legspring.layout import TIGHT
from legspring.problem import GaitProblem
from legspring.returnmap import complete_map
from legspring.solve import Ending, hindmost, number_branches, same_legs, solve, sort, zeros
from legspring.starts import starts_for
from tests.conftest import Cells, read_reference


def test_all_286_known_gaits_are_found(thesis_map: Cells) -> None:
    first = Counter(gaits[0].family for gaits in thesis_map.values() if gaits)
    pairs = Counter((gaits[0].family, gaits[1].family) for gaits in thesis_map.values() if len(gaits) > 1)
    assert first == {"A": 10, "FB": 37, "MB": 10, "B": 129}
    assert pairs == {("B", "B"): 67, ("FB", "FB"): 18, ("FB", "B"): 15}
    assert {cell for cell, gaits in thesis_map.items() if not gaits} == {(0, 0), (35, 0.45), (40, 0.45), (45, 0.45)}
    assert sum(len(gaits) for gaits in thesis_map.values()) == 286


@pytest.mark.parametrize("row", read_reference("gaits.csv"), ids=lambda r: f"{r['slope_deg']}-{r['heading']}")
def test_branch_0_is_the_published_gait(row: dict[str, str], thesis_map: Cells) -> None:
    gait = thesis_map[float(row["slope_deg"]), float(row["heading"])][0]
    assert gait.family == row["family"]
    assert gait.speed == pytest.approx(float(row["v0"]), abs=1e-9)
    assert np.degrees(gait.phase) == pytest.approx([float(row[f"phi_{leg}_deg"]) for leg in "FMB"], abs=1e-7)
    assert gait.liftoff == pytest.approx([float(row[f"liftoff_{leg}"]) for leg in "FMB"], abs=1e-8)
    assert gait.reduced_eigenvalue == pytest.approx(float(row["reduced_eigenvalue"]), abs=1e-7)
    assert gait.transport_cost == pytest.approx(float(row["transport_cost"]), abs=1e-7)
    # The published peaks are the largest of samples, so that ours lie a little further out.
    peaks = [[float(row[f"{axis}_{leg}"]) for axis in ("lateral", "fore_aft")] for leg in "FMB"]
    assert gait.peak_force == pytest.approx(np.array(peaks), abs=1e-4)
    high, low = gait.net_force
    assert high == pytest.approx([float(row["net_lateral_max"]), float(row["net_fore_aft_max"])], abs=1e-4)
    assert low == pytest.approx([float(row["net_lateral_min"]), float(row["net_fore_aft_min"])], abs=1e-4)


def test_every_gait_carries_its_evidence(thesis_map: Cells) -> None:
    for gaits in thesis_map.values():
        for gait in gaits:
            assert gait.residual < 1e-10
            assert gait.drift < 1e-7
            assert gait.invalid() is None
            # Three legs touch down and three lift off in every step.
            assert Counter(event.split()[1] for event in gait.events) == {"lift-off": 6, "touch-down": 6}


def test_published_branch_is_stable_and_worst_where_the_middle_leg_turns(thesis_map: Cells) -> None:
    eigenvalues = {cell: gaits[0].reduced_eigenvalue for cell, gaits in thesis_map.items() if gaits}
    worst = max(eigenvalues, key=lambda cell: eigenvalues[cell])
    assert worst == (5, 0.20)
    assert eigenvalues[worst] == pytest.approx(0.8732, abs=5e-5)
    assert eigenvalues[0, 0.20] == pytest.approx(0.867, abs=5e-4)


def test_family_b_costs_no_more_than_it_must(thesis_map: Cells) -> None:
    for (slope, heading), gaits in thesis_map.items():
        if gaits and gaits[0].family == "B":
            least = 1.000433 if (slope, heading) == (90, 0.45) else math.sin(math.radians(slope))
            assert gaits[0].transport_cost == pytest.approx(least, abs=1e-6 if least > 1 else 1e-8)


def test_second_branch_is_often_the_more_stable(thesis_map: Cells) -> None:
    both = [gaits for gaits in thesis_map.values() if len(gaits) == 2]
    assert sum(second.reduced_eigenvalue < first.reduced_eigenvalue for first, second in both) == 96
    assert sum(second.transport_cost < first.transport_cost - 1e-6 for first, second in both) == 34
    first, second = thesis_map[0, 0.40]
    assert (first.reduced_eigenvalue, first.transport_cost) == pytest.approx((0.572, 1.067), abs=5e-4)
    assert (second.reduced_eigenvalue, second.transport_cost) == pytest.approx((0.336, 0.685), abs=5e-4)


def test_one_cell_alone_gives_what_the_map_gives(roach: Animal, thesis_map: Cells) -> None:
    for slope, heading in ((0, 0.40), (20, 0.35), (45, 0.15), (40, 0.45)):
        gaits = find_gaits(roach, slope_deg=slope, heading=heading)
        known = thesis_map[slope, heading]
        assert [(g.family, g.branch) for g in gaits] == [(g.family, g.branch) for g in known]
        for gait, other in zip(gaits, known, strict=True):
            assert gait.phase == pytest.approx(other.phase, abs=1e-9)


def test_narrowing_keeps_the_branch_numbers(roach: Animal, thesis_map: Cells) -> None:
    cell = next(cell for cell, gaits in thesis_map.items() if [g.family for g in gaits] == ["FB", "B"])
    (only,) = find_gaits(roach, slope_deg=cell[0], heading=cell[1], family="B")
    assert (only.family, only.branch) == ("B", 1)


def test_gaits_downhill(roach: Animal) -> None:
    gaits = find_gaits(roach, slope_deg=-10, heading=0.15)
    assert gaits
    for gait in gaits:
        # Gravity does work here: the legs take up what it gives.
        assert np.sum(gait.work) == pytest.approx(math.sin(math.radians(-10)), abs=2e-9)


def test_rejections_have_names(roach: Animal) -> None:
    search = search_gaits(roach, slope_deg=0, heading=0.10)
    assert search.rejections
    for rejection in search.rejections:
        assert rejection.solution.residual < 1e-10
        assert rejection.solution.invalid() == (rejection.reason, rejection.leg)
        assert str(rejection.reason) in str(rejection)
    assert search.steps > search.starts == sum(search.endings.values()) > 0
    assert search.endings[Ending.CONVERGED] >= len(search.gaits) + len(search.rejections)
    assert str(Ending.CONVERGED) in search.summary()


def changed(gait: Gait, **changes: object) -> Gait:
    return Gait(**{name: getattr(gait, name) for name in gait.__dataclass_fields__} | changes)


def test_validity_tells_what_is_wrong(thesis_map: Cells) -> None:
    gait = thesis_map[45, 0.15][0]
    front, middle, back = gait.phase
    assert changed(gait, phase=(front + math.pi, middle, back)).invalid() == (Invalid.WRONG_SIGN, "FL")
    weak = changed(gait, actuation=(0.016, 0.00002, 0.0095), phase=(front, 1.5, back)).invalid()
    assert weak is not None
    assert weak[1] == "MR"


def test_every_reason_is_met(roach: Animal, thesis_map: Cells) -> None:
    rng = np.random.default_rng(3)
    gait = thesis_map[75, 0.15][0]
    candidates = [changed(gait, phase=tuple(rng.uniform(-1.6, 1.6, 3))) for _ in range(200)]
    candidates += [changed(thesis_map[0, 0.15][0], animal=roach.replace(stiffness=k)) for k in (1e-4, 1e15)]
    reasons = {reason[0] for reason in (candidate.invalid() for candidate in candidates) if reason}
    # Of the others there are no unknowns to look at here.
    elsewhere = {Invalid.NOT_ISOLATED, Invalid.UNCONFIRMED, Invalid.NO_ANIMAL, Invalid.COLLAPSED}
    assert reasons == set(Invalid) - elsewhere


def test_a_leg_that_is_run_over_is_no_leg() -> None:
    """With a leg straight ahead the body runs over its foot, where the leg has no length and no direction."""
    straight = load_animal("lateral_leg_spring_point").replace(angle_deg=0.0)
    search = search_gaits(straight)
    assert not search.gaits
    assert Invalid.COLLAPSED in {rejection.reason for rejection in search.rejections}


def test_what_is_free_may_be_what_no_animal_has() -> None:
    search = search_gaits(load_animal("single_leg"), slope_deg=45, mean_speed=1.3, free=("T.actuation",))
    (rejection, *_) = [one for one in search.rejections if one.reason == Invalid.NO_ANIMAL]
    assert "actuation = " in rejection.leg and rejection.solution.animal == load_animal("single_leg")


def test_a_light_animal_is_no_accident(roach: Animal) -> None:
    """Its forces are stiff: a stride takes many steps of the integrator, recorded or not."""
    search = search_gaits(roach.replace(mass=1e-5), slope_deg=20, heading=0.3)
    reasons = {rejection.reason for rejection in search.rejections}
    assert reasons and Invalid.NOT_SIMULATED not in reasons
    assert max(rejection.solution.stride.tape.counts[0] for rejection in search.rejections) > 180
    assert [gait.speed for gait in search.gaits] == pytest.approx([0.4842678], abs=1e-6)


def test_solutions_that_prove_to_be_one_count_once(roach: Animal, thesis_map: Cells) -> None:
    gait = thesis_map[45, 0.15][0]
    problem = tuned(roach, gait.slope, gait.heading, gait.family)
    z = problem.z_of(gait)
    gaits, rejections = sort(problem, np.array([z, z + 1e-4, z + 2.0 * math.pi * np.array([0, 1, 0, -1])]))
    assert (len(gaits), len(rejections)) == (1, 0)


def test_a_rigid_body_runs_too(rigid_map: Cells) -> None:
    gaits = [gait for here in rigid_map.values() for gait in here]
    assert len(gaits) > len(rigid_map) and sum(bool(here) for here in rigid_map.values()) >= 15
    for gait in gaits:
        assert gait.residual < 1e-10 and gait.drift < 1e-7
        assert gait.invalid() is None
        state, jacobian = complete_map(gait.system, gait.point)
        assert state == pytest.approx(gait.point[:7], rel=1e-8, abs=1e-9)
        assert jacobian.shape == (7, 7)


def test_steps_of_a_rigid_body_mirror_each_other(rigid_map: Cells) -> None:
    gait = rigid_map[30, 0.15][0]
    run = gait.simulate(strides=1)
    first, second = run.isel(time=slice(0, 101)), run.isel(time=slice(100, 201))
    for name, sign in (("yaw", -1.0), ("yaw_rate", -1.0), ("moment", -1.0)):
        np.testing.assert_allclose(second[name].values, sign * first[name].values, rtol=0, atol=1e-9)
    np.testing.assert_allclose(second["velocity"].values, first["velocity"].values * [-1.0, 1.0], rtol=0, atol=1e-9)
    assert gait.yaw_amplitude == pytest.approx(float(abs(run["yaw"]).max()), rel=1e-9)
    assert gait.yaw_amplitude >= abs(gait.yaw)
    assert gait.peak_moment == pytest.approx(float(abs(run["moment"]).max()), rel=1e-9)
    # What turns the body is the moment.
    turning = gait.animal.body.inertia * np.gradient(run["yaw_rate"].values, run["time"].values, edge_order=2)
    assert turning == pytest.approx(run["moment"].values, abs=0.04 * gait.peak_moment)


def test_on_the_level_a_turned_gait_stays_turned(rigid_map: Cells) -> None:
    for heading in (0.05, 0.15, 0.3):
        for gait in rigid_map[0, heading]:
            assert np.min(np.abs(gait.multipliers - 1.0)) < 1e-6


def test_a_body_that_does_not_yaw_says_so(thesis_map: Cells) -> None:
    gait = thesis_map[45, 0.15][0]
    assert (gait.yaw, gait.yaw_rate, gait.yaw_amplitude) == (0.0, 0.0, 0.0)
    # The point mass's legs pull at its centre.
    assert gait.peak_moment < 1e-15


def test_derivatives_of_the_conditions(thesis_map: Cells, rigid_map: Cells) -> None:
    for gait in (thesis_map[60, 0.15][0], rigid_map[60, 0.15][0]):
        problem = tuned(gait.animal, gait.slope, gait.heading, gait.family)
        z = problem.z_of(gait)
        values, by = problem.residual(z, accuracy=TIGHT)
        assert np.max(np.abs(values)) < 1e-10
        assert by.shape == (1, problem.size, problem.size)
        steps = 1e-5 * np.eye(problem.size)
        ahead, behind = (problem.residual(z + sign * steps, accuracy=TIGHT)[0] for sign in (1.0, -1.0))
        assert by[0] == pytest.approx((ahead - behind).T / 2e-5, abs=1e-7)


def test_derivatives_of_the_conditions_along_the_slope(thesis_map: Cells) -> None:
    """Desired speed, step duration and where the old feet are move with it: as if the animal stood on another slope."""
    gait, h = thesis_map[60, 0.15][0], 1e-5
    problem = tuned(gait.animal, gait.slope, gait.heading, gait.family)
    along = ("slope", "mass", "M.stiffness", "F.offset")
    z = problem.z_of(gait)
    exact = problem.residual(z, along, accuracy=TIGHT)[1][0, :, problem.size :]
    units = problem.task.along[0, 0]  # the unknown speed is counted in desired ones, which change

    def residual(slope: float, **changes: float) -> np.ndarray:
        other = tuned(gait.animal.replace(**changes), slope, gait.heading, gait.family)
        here = z * np.where(np.arange(problem.size) == 0, units / other.task.along[0, 0], 1.0)
        scales = np.array([other.unit(name) / problem.unit(name) for name in problem.conditions])
        return other.residual(here, accuracy=TIGHT)[0][0] * scales

    differences = [
        (residual(gait.slope + h) - residual(gait.slope - h)) / (2.0 * h),
        *(
            (residual(gait.slope, **{name: here + step}) - residual(gait.slope, **{name: here - step})) / (2.0 * step)
            for name, here, step in (("mass", 2.5e-3, 1e-7), ("M.stiffness", 1.5, 1e-4))
        ),
    ]
    for column, difference in enumerate(differences):
        size = np.max(np.abs(difference))
        assert exact[:, column] == pytest.approx(difference, rel=1e-6, abs=1e-6 * size)


def test_a_problem_counts_unknowns_and_conditions(roach: Animal) -> None:
    system = tuned(roach, 0.5, 0.15, "B").system
    phases = ("F.phase", "M.phase", "B.phase")
    whole = GaitProblem(system, phases, {"heading": 0.15, "mean_speed": "desired_speed", "lateral_drift": 0.0})
    assert whole.unknowns == ("speed", *phases) and whole.conditions == ("speed", "heading", "Dx", "Dy")
    with pytest.raises(ValueError, match=r"3 unknowns \(speed, F.phase, M.phase\) for 4 conditions .* 1 more free"):
        GaitProblem(system, phases[:2], whole.given)
    with pytest.raises(ValueError, match=r"5 unknowns .* given mean_speed = desired_speed, .* must have 1 more given"):
        GaitProblem(system, phases, {"mean_speed": "desired_speed", "lateral_drift": 0.0})
    with pytest.raises(ValueError, match=r"given = 'colour': must be one of speed, heading, Dx, Dy, mean_speed"):
        GaitProblem(system, phases, {"colour": 1.0})
    with pytest.raises(ValueError, match="mean_speed = 'colour': must be a number, or one of speed, heading"):
        GaitProblem(system, phases, {**whole.given, "mean_speed": "colour"})
    with pytest.raises(ValueError, match="free = 'slope': must be a parameter to which"):
        GaitProblem(system, ("slope", *phases), whole.given)
    with pytest.raises(ValueError, match=r"'X': must be a pair \(F, M, B\) or a leg"):
        GaitProblem(system, ("X.phase", *phases[1:]), whole.given)


def test_other_parameters_may_be_free(roach: Animal, thesis_map: Cells) -> None:
    """The gait at a heading, once its phases are given, is that of the stiffnesses that are found."""
    gait = thesis_map[60, 0.15][0]
    given = gait.animal.replace(phase=gait.phase)
    problem = GaitProblem(
        replace(gait.system, animal=given),
        ("F.stiffness", "M.stiffness", "B.stiffness"),
        {"heading": gait.heading, "mean_speed": "desired_speed", "lateral_drift": 0.0},
    )
    start = problem.z_of(gait) * 1.02
    found = solve(problem, start, TIGHT, 1e-12)
    other = problem.gait(found.z[0])
    assert [leg.stiffness for leg in other.animal.legs] == pytest.approx([1.5] * 6, rel=1e-8)
    assert other.speed == pytest.approx(gait.speed, rel=1e-9)


def test_a_given_mean_speed_is_kept(roach: Animal) -> None:
    """Another speed than the desired one, with the same step duration."""
    system = tuned(roach, math.radians(45), 0.15, "B").system
    phases = ("F.phase", "M.phase", "B.phase")
    faster = GaitProblem(system, phases, {"heading": 0.15, "mean_speed": 0.28, "lateral_drift": 0.0})
    gaits, _ = sort(faster, zeros(faster, starts_for(faster, 32))[0])
    assert gaits
    for gait in gaits:
        run = gait.simulate(strides=1)
        assert run["position"].values[-1, 1] / run["time"].values[-1] == pytest.approx(0.28, rel=1e-9)


def test_two_threads_may_use_one_problem(roach: Animal) -> None:
    problem = tuned(roach, math.radians(45), 0.15, "B")
    starts = starts_for(problem, 32)
    expected = solve(problem, starts, 1e-8, 1e-7).z
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(lambda _: solve(problem, starts, 1e-8, 1e-7).z, range(16)):
            np.testing.assert_array_equal(found, expected)


def test_a_problem_elsewhere(roach: Animal) -> None:
    here = tuned(roach, 0.5, 0.15, "B")
    assert here.at(slope=0.6, heading=0.2) == tuned(roach, 0.6, 0.2, "B")
    assert problem_for(roach, 0.5, "B", {"heading": 0.15}) == here


def test_phases_of_gaits_lie_in_the_box_searched(thesis_map: Cells, rigid_map: Cells) -> None:
    for (slope, heading), gaits in [*thesis_map.items(), *rigid_map.items()]:
        for gait in gaits:
            problem = tuned(gait.animal, math.radians(slope), heading, gait.family)
            assert np.all(np.abs(gait.phase) <= problem.phase_range())


def test_hindmost_legs_and_branches(roach: Animal, thesis_map: Cells) -> None:
    assert roach.pairs[hindmost(roach)] == "B"
    first, second = thesis_map[45, 0.15]
    assert [g.phase for g in number_branches([second, first])] == [first.phase, second.phase]
    assert number_branches([]) == ()


def test_actuation_changes_the_gait(roach: Animal) -> None:
    (gait, *_) = find_gaits(roach, slope_deg=45, heading=0.15, family="B", actuation=(0.012, 0.013, 0.0095))
    assert gait.actuation == (0.012, 0.013, 0.0095)
    replaced = find_gaits(roach.replace(actuation=(0.012, 0.013, 0.0095)), slope_deg=45, heading=0.15, family="B")
    assert gait.phase == pytest.approx(replaced[0].phase, abs=1e-10)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"heading": 0.1}, "slope"),
        ({"heading": 0.1, "slope": 0.1, "slope_deg": 5}, "slope"),
        ({"heading": 2.0, "slope_deg": 5}, "heading = 2.0"),
        ({"heading": math.nan, "slope_deg": 5}, "heading = nan"),
        ({"heading": 0.1, "slope_deg": 95}, "slope_deg = 95"),
        ({"heading": 0.1, "slope_deg": 5, "family": "X"}, "X"),
        ({"heading": 0.1, "slope_deg": 5, "actuation": (0.01, 0.01)}, "actuation"),
        ({"heading": 0.1, "slope_deg": 5, "actuation": 0.03}, "actuation"),
        ({"heading": 0.1, "slope_deg": 5, "starts": 0}, "starts = 0"),
    ],
)
def test_bad_input_is_named(roach: Animal, arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        search_gaits(roach, **arguments)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_other_laws_may_have_any_phase(roach: Animal) -> None:
    """The sinusoid a quarter of a period later, as a formula: the same gaits, with phases a quarter earlier."""
    shifted = roach.replace(length_law="l0 - ldev*cos(pi*t + phi)")
    ours = find_gaits(roach, slope_deg=45, heading=0.15)
    theirs = find_gaits(shifted, slope_deg=45, heading=0.15)
    assert len(ours) == len(theirs) > 0
    for one, other in zip(ours, theirs, strict=True):
        assert other.speed == pytest.approx(one.speed, rel=1e-9)
        assert np.array(other.phase) == pytest.approx(np.array(one.phase) - np.pi / 2, abs=1e-7)


def test_a_phase_that_is_given_is_not_overwritten(roach: Animal) -> None:
    """Of the heading, the desired speed and no lateral drift, the last is not asked for."""
    animal = roach.replace(**{"F.phase": 0.1})
    assert animal.tuned
    gaits = search_gaits(animal, slope_deg=45, heading=0.15).gaits
    assert gaits
    for gait in gaits:
        assert gait.phase[0] == 0.1 and gait.heading == 0.15
        x, y = gait.stride.states[1, :2]
        assert y / gait.step_duration == pytest.approx(gait.system.desired_speed, rel=1e-10) and abs(x) > 1e-6


def test_where_somebody_stays_there_is_no_transport_cost() -> None:
    """Hopping in place."""
    (gait,) = find_gaits(load_animal("spring_loaded_inverted_pendulum").replace(angle_deg=180.0))
    assert gait.mean_speed == pytest.approx(0.0, abs=1e-9) and not gait.gets_on
    assert math.isnan(gait.transport_cost) and np.all(np.isnan(gait.work))
    assert gait.missing["transport_cost"] == "the gait stays where it is: there is no distance to go by"
    assert not {"transport_cost", "work"} & set(find_gaits(load_animal("single_leg"), slope_deg=45)[0].missing)


def test_a_body_that_no_leg_turns_keeps_its_yaw_rate() -> None:
    spring = load_animal("lateral_leg_spring")
    assert find_gaits(spring)[0].conserved == ("energy", "direction")
    (gait,) = find_gaits(spring.replace(hip=(0.0, 0.0)))
    assert gait.conserved == ("energy", "direction", "yaw_rate")
    assert np.sum(np.abs(gait.multipliers - 1.0) < 1e-6) == 3


@pytest.mark.parametrize("slope_deg", [1.0, 45.0, -30.0, -90.0])
def test_passive_legs_do_not_run_on_a_slope(slope_deg: float) -> None:
    assert not search_gaits(load_animal("spring_loaded_inverted_pendulum"), slope_deg=slope_deg).gaits


@pytest.mark.parametrize("name", ["spring_loaded_inverted_pendulum", "cockroach"])
def test_a_search_stops_by_a_rule_and_says_so(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    animal = load_animal(name)
    place: dict[str, Any] = {"slope_deg": 45.0, "heading": 0.15} if animal.tuned else {}
    whole = search_gaits(animal, starts=24, **place)
    assert Ending.GIVEN_UP not in whole.endings
    monkeypatch.setattr("legspring.solve.MOST_EFFORT", 10)
    search = search_gaits(animal, starts=24, **place)
    assert search.starts == whole.starts == 24 * len(animal.families)
    assert search.endings[Ending.GIVEN_UP] == 16 * len(animal.families)
    assert search.steps < whole.steps
    assert "not searched from, as the search had taken all the effort that is allowed" in search.summary()


def test_what_cannot_walk_is_soon_known_not_to() -> None:
    """A leg that points up, or hardly down."""
    for angle_deg in (0.0, -90.0, -91.0):
        animal = load_animal("spring_loaded_inverted_pendulum").replace(angle_deg=angle_deg)
        search = search_gaits(animal, starts=24)
        assert not search.gaits and not search.rejections
        assert sum(search.endings.values()) == 24


def test_all_ways_to_push_and_pull(roach: Animal) -> None:
    own = find_gaits(roach, slope_deg=45, heading=0.05)
    every = find_gaits(roach, slope_deg=45, heading=0.05, family="all")
    for gait, same in zip(own, every, strict=False):
        assert (gait.family, gait.branch, gait.phase) == (same.family, same.branch, same.phase)
    further = every[len(own) :]
    assert [gait.branch for gait in every] == list(range(len(every)))
    assert "none" in {gait.family for gait in further}, "one in which no leg pushes"
    for gait in further:
        assert gait.family not in roach.families and gait.invalid() is None
        forces = gait.peak_force[:, 1] * np.array([1.0, 1.0, -1.0])
        pulls = [side > 0 for side in gait.animal.functions(gait.family)]
        assert (forces > 0.0).tolist() == pulls


def test_a_leg_is_not_counted_twice(roach: Animal) -> None:
    # The same legs by other names: phi + pi with the other sign.
    gait = find_gaits(roach, slope_deg=45, heading=0.15)[0]
    every = roach.every_family()
    other = replace(
        gait, animal=every, family="none", phase=(*gait.phase[:2], math.remainder(gait.phase[2] + math.pi, 2 * math.pi))
    )
    assert same_legs(gait, other) and not same_legs(gait, replace(gait, animal=every, family="none"))


def test_too_many_pairs_for_all_families() -> None:
    with pytest.raises(ModelError, match="must have 6 pairs of legs at most"):
        find_gaits(load_animal("centipede"), slope_deg=0, family="all")


@pytest.mark.parametrize(
    "name", ["F.angle", "F.actuation", "step_duration", "mass", "gravity", "stiffness", "M.length"]
)
def test_what_is_let_go_is_what_the_animal_would_have_to_have(name: str, roach: Animal) -> None:
    """A gait of another speed is one of the animal that has the value found, and that one has it at that speed."""
    before = find_gaits(roach, slope_deg=45, heading=0.15)[0]
    speed = before.speed + 0.0005
    gaits = find_gaits(roach, slope_deg=45, heading=0.15, speed=speed, free=(name,))
    assert gaits, f"none with {name} free"
    for gait in gaits:
        assert gait.speed == pytest.approx(speed, rel=1e-12)
        assert gait.mean_speed == pytest.approx(gait.system.desired_speed, rel=1e-11)
        other = find_gaits(roach.replace(**{name: gait.freed[name]}), slope_deg=45, heading=0.15)
        nearest = min(other, key=lambda one: float(np.max(np.abs(np.subtract(one.phase, gait.phase)))))
        np.testing.assert_allclose(nearest.phase, gait.phase, atol=1e-8)
        assert nearest.speed == pytest.approx(speed, rel=1e-9)
        np.testing.assert_allclose(np.abs(nearest.multipliers), np.abs(gait.multipliers), atol=1e-6)


@pytest.mark.parametrize("drift", [0.01, -0.004])
def test_the_drift_that_is_asked_for(drift: float, roach: Animal) -> None:
    gaits = find_gaits(roach, slope_deg=45, heading=0.15, lateral_drift=drift)
    assert gaits
    for gait in gaits:
        run = gait.simulate(1)
        step = run.sizes["time"] // 2
        assert float(run["position"][step, 0]) == pytest.approx(drift * gait.step_duration, rel=1e-8)
        assert gait.lateral_drift == pytest.approx(drift, rel=1e-9)


def test_legs_of_a_pair_with_different_actuation(roach: Animal) -> None:
    whole = find_gaits(roach, slope_deg=45, heading=0.15)[0]
    given = roach.replace(phase=whole.phase)
    uneven = given.replace(**{"FL.actuation": 0.0148})
    (gait, *_) = find_gaits(uneven, slope_deg=45, family="B")
    assert [leg.actuation for leg in gait.animal.legs] == [leg.actuation for leg in uneven.legs]
    run = gait.simulate(2)
    ends = run["velocity"].values[[0, run.sizes["time"] // 2, -1]]
    np.testing.assert_allclose(ends[1:], ends[:1].repeat(2, axis=0), atol=1e-9)
    # A leg's actuation that is let go is that leg's alone.
    for other in find_gaits(given, slope_deg=45, family="B", speed=gait.speed, free=("FL.actuation",)):
        if abs(other.freed["FL.actuation"] - 0.0148) < 1e-6:
            np.testing.assert_allclose(other.heading, gait.heading, atol=1e-7)
            break
    else:
        pytest.fail("the same gait was not found with the actuation free")
