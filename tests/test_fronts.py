"""Trade-offs: gaits of which none is better in all that is asked."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import legspring as ls
from legspring import Animal, Gait
from legspring.candidates import Judge, Trial, box_of
from legspring.criteria import criteria, criterion
from legspring.figures import draw_front
from legspring.fronts import Front, spread, undominated

RANGES = {"F.stiffness": (0.5, 2.5), "M.stiffness": (0.5, 2.5), "B.stiffness": (0.5, 2.5)}
FEW = 144


@pytest.fixture(scope="module")
def level(roach: Animal) -> Gait:
    return ls.find_gaits(roach, slope_deg=10, heading=0.15, family="A")[0]


@pytest.fixture(scope="module")
def found(level: Gait) -> Front:
    return ls.pareto(level, RANGES, minimize=["stability", "transport_cost"], evaluations=FEW, points=10, workers=2)


def left(gait: Gait) -> float:
    """Return how far parameters are from one place, by a function of which the front is known."""
    f, m = (gait.point[gait.system.place_of(f"{pair}.stiffness")] for pair in "FM")
    return float((f - 1.2) ** 2 + (m - 1.4) ** 2)


def right(gait: Gait) -> float:
    """Return how far they are from another one."""
    f, m = (gait.point[gait.system.place_of(f"{pair}.stiffness")] for pair in "FM")
    return float((f - 1.6) ** 2 + (m - 1.4) ** 2)


def test_a_front_that_is_known(level: Gait) -> None:
    """Of squared distances from two places it is the straight line between them, and its own square root."""
    ranges = {name: RANGES[name] for name in ("F.stiffness", "M.stiffness")}
    front = ls.pareto(level, ranges, minimize=[left, right], evaluations=48, points=9)
    assert 7 <= len(front.gaits) <= 9
    assert np.sqrt(front.values).sum(axis=1) == pytest.approx(0.4, abs=2e-3)
    assert front.values[0, 0] < 1e-5 and front.values[-1, 1] < 1e-5
    places = np.array([front.box.values(place) for place in front.places])
    assert places[:, 1] == pytest.approx(1.4, abs=0.02)
    assert np.all(np.diff(places[:, 0]) > 0.0) and places[[0, -1], 0] == pytest.approx([1.2, 1.6], abs=0.01)
    # Spread evenly: no gap is more than two and a half times the mean one.
    gaps = np.linalg.norm(np.diff(front.values / np.ptp(front.values, axis=0), axis=0), axis=1)
    assert gaps.max() < 2.5 * gaps.mean()


def test_nothing_is_better_than_a_front(level: Gait, found: Front) -> None:
    """Neither one of its gaits, nor any of some animals made up at random."""
    assert 6 <= len(found.gaits) <= 10 and found.evaluations == FEW
    assert all(gait.invalid() is None for gait in found.gaits)
    values = found.values
    for n, one in enumerate(values):
        assert not any(np.all(other <= one) for k, other in enumerate(values) if k != n)
    assert np.all(np.diff(values[:, 0]) > 0.0) and np.all(np.diff(values[:, 1]) < 0.0)
    judge = Judge(box_of([level], RANGES), (level,), criteria(["stability", "transport_cost"]), np.ones(2))
    known = judge.first()
    rng, tried = np.random.default_rng(5), 0
    for place in rng.random((40, 3)):
        trial = judge(place, 0, known)
        if trial.gait is not None:
            tried += 1
            assert not np.any(np.all(trial.values < values - 1e-3, axis=1))
    assert tried > 10


def test_what_is_said_of_a_gait_of_a_front_is_so(found: Front) -> None:
    for gait, value, place in zip(found.gaits, found.values, found.places, strict=True):
        assert value == pytest.approx([max(abs(gait.multipliers)), gait.transport_cost])
        assert np.all((place >= 0.0) & (place <= 1.0))
        other = gait.animal
        again = ls.find_gaits(other, slope_deg=10, heading=0.15, family="A")
        assert min(abs(one.transport_cost - value[1]) for one in again) < 1e-8


@pytest.mark.long
def test_a_front_does_not_depend_on_workers_nor_on_stops(level: Gait, tmp_path: Path, monkeypatch: Any) -> None:
    asked: dict[str, Any] = {"minimize": ["stability", "transport_cost"], "evaluations": 96, "points": 5, "seed": 3}
    ranges = {"B.stiffness": (1.0, 2.0), "F.stiffness": (1.0, 2.0)}
    alone = ls.pareto(level, ranges, workers=1, **asked)
    both = ls.pareto(level, ranges, workers=2, **asked)
    assert np.array_equal(alone.values, both.values)
    judged, calls = Judge.__call__, [0]

    def stopping(self: Judge, *arguments: Any) -> Trial:
        calls[0] += 1
        if calls[0] > 60:
            raise KeyboardInterrupt
        return judged(self, *arguments)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(Judge, "__call__", stopping)
        ls.pareto(level, ranges, store=tmp_path, workers=1, **asked)
    assert list(tmp_path.iterdir())
    calls[0] = 0

    def counting(self: Judge, *arguments: Any) -> Trial:
        calls[0] += 1
        return judged(self, *arguments)

    with monkeypatch.context() as patch:
        patch.setattr(Judge, "__call__", counting)
        resumed = ls.pareto(level, ranges, store=tmp_path, **asked)
        assert calls[0] == 48
        again = ls.pareto(level, ranges, store=tmp_path, **asked)
        assert calls[0] == 48
    assert np.array_equal(resumed.values, alone.values) and np.array_equal(again.values, alone.values)


def test_families_compete(roach: Animal) -> None:
    gaits = ls.find_gaits(roach, slope_deg=15, heading=0.3)
    families = {gait.family for gait in gaits}
    assert len(families) > 1
    front = ls.pareto(
        gaits, {"M.stiffness": (1.4, 1.6)}, minimize=["stability", "transport_cost"], evaluations=0, refine=False
    )
    own = np.array([[max(abs(gait.multipliers)), gait.transport_cost] for gait in gaits])
    best = [n for n, one in enumerate(own) if not any(np.all(other <= one) for k, other in enumerate(own) if k != n)]
    assert {gait.branch for gait in front.gaits} == {gaits[n].branch for n in best}


@pytest.mark.long
def test_bounds_and_constraints(level: Gait, tmp_path: Path) -> None:
    assert level.friction < 2.0
    asked: dict[str, Any] = {"minimize": ["stability", "transport_cost"], "evaluations": 48, "points": 5}
    front = ls.pareto(level, RANGES, bounds={"friction": (None, 0.9 * level.friction)}, **asked)
    assert front.gaits and all(gait.friction <= 0.9 * level.friction for gait in front.gaits)
    none = ls.pareto(level, RANGES, bounds={"friction": (None, 0.01)}, **asked | {"refine": False})
    assert none.gaits == () and none.separation() == [] and none.at_limits() == []
    with pytest.raises(ValueError, match="must have gaits"):
        draw_front(none)
    kept = {"constraints": "peterson2011", "store": tmp_path, "refine": False}
    stored = [ls.pareto(level, RANGES, **asked | kept) for _ in range(2)]
    assert np.array_equal(stored[0].values, stored[1].values)
    charged = ls.pareto(level, RANGES, constraints="peterson2011", **asked | {"evaluations": 0, "refine": False})
    assert len(charged.gaits) == 1 and charged.penalties[0] >= 0.0


def test_what_is_large_and_what_has_no_slope(level: Gait) -> None:
    """Steps to recover are whole numbers: the local search holds them, and never makes them worse."""
    front = ls.pareto(
        level,
        {"B.stiffness": (1.2, 1.8)},
        minimize=["recovery", "transport_cost"],
        maximize=["mean_speed"],
        evaluations=16,
        points=6,
    )
    assert front.signs.tolist() == [1.0, 1.0, -1.0]
    assert np.array_equal(front.values[:, 0], np.round(front.values[:, 0]))
    data = front.to_dataset()
    assert data["best"].values.tolist() == ["least", "least", "most"]
    assert isinstance(draw_front(data), Figure)


def test_criteria(level: Gait, roach: Animal) -> None:
    assert criterion("peak_force").function(level) == pytest.approx(np.max(np.abs(level.peak_force)))
    assert criterion("stability").function(level) == pytest.approx(abs(level.multipliers[0]))
    slip = ls.find_gaits(ls.load_animal("spring_loaded_inverted_pendulum"))[0]
    # Energy is kept: its multiplier of 1 says nothing.
    rest = sorted(abs(slip.multipliers), key=lambda size: abs(size - 1.0))[1:]
    assert criterion("stability").function(slip) == pytest.approx(max(rest))
    flat = ls.find_gaits(roach, slope_deg=15, heading=0.2)[0]
    assert criterion("recovery").function(flat) == max(flat.recover(impulse).steps for impulse in (-0.5, 0.5))  # type: ignore[type-var]
    assert criterion("push").function(flat) > 0.5
    assert 0.3 < criterion("basin").function(flat) < 1.0
    unstable = min(
        ls.find_gaits(ls.load_animal("cockroach_rigid"), slope_deg=45, heading=0.15),
        key=lambda g: -abs(g.multipliers[0]),
    )
    assert abs(unstable.multipliers[0]) > 1.0
    assert criterion("basin").function(unstable) == criterion("push").function(unstable) == 0.0
    assert 1.0 <= criterion("roughness").function(flat) <= 30.0


def test_a_front_as_a_dataset(found: Front, tmp_path: Path) -> None:
    path = tmp_path / "front.nc"
    found.to_dataset().to_netcdf(path)
    with xr.open_dataset(path) as back:
        assert np.array_equal(back["objectives"].values, found.values)
        assert back["transport_cost"].values == pytest.approx(found.values[:, 1])
        assert back["parameters"].shape == (len(found.gaits), 3)
        assert back.attrs["separation"] == "\n".join(found.separation())
        assert isinstance(draw_front(back), Figure)
    with pytest.raises(ValueError, match=r"must be one of legspring\.pareto"):
        draw_front(xr.Dataset())


def test_what_separates_the_ends(found: Front) -> None:
    (line,) = found.separation()
    assert line.startswith("from the best stability to the best transport_cost: ")
    move = found.places[-1] - found.places[0]
    for name, one, value in zip(found.box.names, move, found.box.values(found.places[-1]), strict=True):
        assert (f"{name} " in line) and (abs(one) < 0.05 or f"-> {value:.4g} N/m ({100 * one:+.0f} %" in line)


def test_fronts_of_points() -> None:
    def trial(*values: float) -> Trial:
        return Trial(np.zeros(1), 0, None, np.array(values), np.zeros(0))

    points = [trial(1.0, 3.0), trial(2.0, 2.0), trial(2.0, 2.5), trial(3.0, 1.0), trial(2.0, 2.0), trial(4.0, 1.0)]
    assert [one.values.tolist() for one in undominated(points)] == [[1.0, 3.0], [2.0, 2.0], [3.0, 1.0]]
    assert undominated([]) == [] and spread([], 3) == []
    line = [trial(float(n), -float(n)) for n in range(101)]
    chosen = [one.values[0] for one in spread(line, 5)]
    assert chosen == [0.0, 25.0, 50.0, 75.0, 100.0]


@pytest.mark.parametrize(
    ("over", "asked", "words"),
    [
        ({}, {}, "over = {}: must map parameters to ranges"),
        ({"F.stiffness": 1.0}, {}, "must be a range, two rising numbers"),
        ({"F.stiffness": (2.0, 1.0)}, {}, "must be a range, two rising numbers"),
        ({"F.stiffness": (2.0, 3.0)}, {}, "must hold the gait's own, 1.5"),
        ({"F.stiffness": (-1.0, 3.0)}, {}, "must be within 0 and inf"),
        ({"speed": (0.1, 3.0)}, {}, "must be no coordinate of the start"),
        ({"F.phase": (-1.0, 3.0)}, {}, "must be no parameter that was free"),
        ({"nonsense": (0.0, 1.0)}, {}, "nonsense"),
        ({"F.stiffness": (1.0, 2.0), "stiffness": (1.0, 2.0)}, {}, "must not have 'stiffness' beside 'F.stiffness'"),
        (RANGES, {"minimize": ["stability"]}, "must be two criteria or more"),
        (RANGES, {"minimize": ["stability", "nonsense"]}, "must be one of stability"),
        (RANGES, {"minimize": ["stability", "stability"]}, "must be named once"),
        (RANGES, {"maximize": ["stability"]}, "must be one or the other"),
        (RANGES, {"bounds": {"friction": (2.0, 1.0)}}, "must be a range"),
        (RANGES, {"bounds": {"friction": 2.0}}, "must be a range"),
        (RANGES, {"points": 1}, "points = 1"),
        (RANGES, {"evaluations": -1}, "evaluations = -1"),
        (RANGES, {"constraints": "none"}, "constraints = 'none'"),
        (RANGES, {"minimize": [left, right], "store": "kept"}, "store = 'kept': must be left out"),
        (RANGES, {"bounds": {left: (None, 1.0)}, "store": "kept"}, "store = 'kept': must be left out"),
        (RANGES, {"minimize": None}, "must be two criteria or more"),
        (RANGES, {"minimize": 3}, "must be names of measures"),
        (RANGES, {"minimize": [left, lambda _: None]}, "must return a number, and returns None"),
        ({"F.stiffness": "12"}, {}, "must be a range, two rising numbers"),
    ],
)
def test_what_is_refused(level: Gait, over: Any, asked: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError) as refused:
        ls.pareto(level, over, **{"minimize": ["stability", "transport_cost"]} | asked)
    assert words in str(refused.value) and "\n" not in str(refused.value)


def test_no_gait_to_begin_with() -> None:
    with pytest.raises(ValueError, match="gaits"):
        ls.pareto([], RANGES, minimize=["stability", "transport_cost"])


def test_functions_of_one_name_are_two_criteria(level: Gait) -> None:
    some = [lambda gait: left(gait), lambda gait: right(gait)]
    front = ls.pareto(level, {"F.stiffness": (1.0, 2.0)}, minimize=some, evaluations=0, points=4)
    assert [one.name for one in front.criteria] == ["<lambda>", "<lambda> 2"] and len(front.gaits) > 1
    slip = ls.find_gaits(ls.load_animal("spring_loaded_inverted_pendulum"))[0]
    with pytest.raises(ValueError, match="must be of one animal"):
        ls.pareto([level, slip], {"mass": (1e-3, 90.0)}, minimize=["speed", "friction"])
