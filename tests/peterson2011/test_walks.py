"""Gaits that are followed while their animal changes."""

import numpy as np
import pytest

from legspring import Animal, Gait, find_gaits
from legspring.gait import Invalid
from legspring.peterson2011.walks import Loss, straight, walk, with_hips
from legspring.solve import search_gaits
from tests.conftest import Cells


def same(gait: Gait, other: Gait) -> bool:
    return gait.family == other.family and gait.phase == pytest.approx(other.phase, abs=1e-8)


def test_feet_stay_where_hips_move(roach: Animal, rigid: Animal) -> None:
    hips = [leg.hip for leg in rigid.legs[:3]]
    moved = with_hips(roach, hips)
    for leg, other in zip(moved.legs, rigid.legs, strict=True):
        assert leg.hip == other.hip
        assert (leg.length, leg.angle) == pytest.approx((other.length, other.angle), abs=1e-11)
    back = with_hips(moved, np.zeros((3, 2)))
    for leg, other in zip(back.legs, roach.legs, strict=True):
        assert (leg.length, leg.angle) == pytest.approx((other.length, other.angle), abs=1e-15)


def test_the_straight_path(roach: Animal, rigid: Animal) -> None:
    path = straight(roach, rigid)
    assert path(0.0) == roach and path(1.0) == rigid
    middle = path(0.5)
    assert middle.body.yaw == "free"
    assert middle.body.inertia == pytest.approx(2.0 * 2.04e-7)
    assert middle.legs[0].hip == pytest.approx((-0.00175, 0.007))
    held = straight(roach, rigid.replace(yaw="held"))(0.5)
    assert held.body.yaw == "held" and held.legs == middle.legs


@pytest.mark.parametrize(
    ("changes", "word"), [({"mass": 3e-3}, "mass"), ({"gravity": 1.6}, "gravity"), ({"length": 0.02}, "feet")]
)
def test_animals_too_different_for_a_path(roach: Animal, rigid: Animal, changes: dict[str, float], word: str) -> None:
    with pytest.raises(ValueError, match=f"differ in {word}: must be alike"):
        straight(roach, rigid.replace(**changes))


def test_a_body_of_infinite_inertia_is_a_point_mass(roach: Animal, rigid: Animal, thesis_map: Cells) -> None:
    for cell in ((0, 0.3), (30, 0.15), (60, 0.15), (90, 0.05)):
        for gait in thesis_map[cell]:
            for inertia, tolerance in ((2.04e-3, 1e-4), (2.04e2, 1e-9)):
                heavy = with_hips(roach, [(-1e-6, 2e-6), (1e-6, 0.0), (0.0, 1e-6)], yaw="free", inertia=inertia)
                end = walk(gait, straight(gait.animal, heavy)).end
                assert end is not None
                assert end.phase == pytest.approx(gait.phase, abs=2e-3)
                assert abs(end.yaw) < tolerance and abs(end.yaw_rate * end.system.step_duration) < tolerance


def test_walks_from_the_point_mass_end_at_gaits_that_a_search_finds(
    roach: Animal, rigid: Animal, thesis_map: Cells, rigid_map: Cells
) -> None:
    path = straight(roach, rigid)
    arrived = 0
    for cell, known in rigid_map.items():
        for gait in thesis_map[cell]:
            end = walk(gait, path).end
            if end is not None:
                arrived += 1
                assert end.animal == rigid and end.invalid() is None
                assert sum(same(end, other) for other in known) == 1
    assert arrived >= 10


def test_a_way_back_leads_to_where_it_came_from(roach: Animal, rigid: Animal, thesis_map: Cells) -> None:
    path = straight(roach, rigid)
    gait = thesis_map[30, 0.15][0]
    there = walk(gait, path)
    assert there.end is not None and str(there).startswith("arrived in")
    assert there.places[0] == 0.0 and there.places[-1] == 1.0
    assert len(there.places) == len(there.gaits)
    back = walk(there.end, lambda s: path(1.0 - s)).end
    assert back is not None and same(back, gait)


def test_walks_that_end_early_say_why(roach: Animal, rigid: Animal, thesis_map: Cells) -> None:
    path = straight(roach, rigid)
    cases = (
        ((10, 0.2), Loss.FOLD, ""),
        ((5, 0.25), Loss.JUMP, "BL"),
        ((10, 0.35), Invalid.IDLE, "FL"),
    )
    for cell, loss, leg in cases:
        walks = [walk(gait, path) for gait in thesis_map[cell]]
        (ended,) = [w for w in walks if w.loss is loss and w.detail == leg]
        assert ended.end is None and 0.0 < ended.places[-1] < 1.0
        assert ended.places[-1] - ended.places[-2] < 0.01
        assert str(loss) in str(ended)
        # Just short of it the gait is still there; just past it a search does not find it either.
        assert ended.gaits[-1].invalid() is None
        past = path(ended.places[-1] + 1e-3)
        near = search_gaits(past, slope_deg=cell[0], heading=cell[1], family=ended.gaits[-1].family).gaits
        assert not any(np.allclose(other.phase, ended.gaits[-1].phase, atol=0.02) for other in near)


def test_at_a_fold_another_gait_meets_it(roach: Animal, rigid: Animal, thesis_map: Cells) -> None:
    path = straight(roach, rigid)
    (fold,) = [w for gait in thesis_map[10, 0.2] if (w := walk(gait, path)).loss is Loss.FOLD]
    place, last = fold.places[-1] - 1e-3, fold.gaits[-1]
    search = search_gaits(path(place), slope_deg=10, heading=0.2, family=last.family, starts=400)
    solutions = [*search.gaits, *(rejection.solution for rejection in search.rejections)]
    assert sum(np.allclose(other.phase, last.phase, atol=0.3) for other in solutions) == 2


def test_a_gait_of_another_animal_is_refused(roach: Animal, rigid: Animal) -> None:
    (gait, *_) = find_gaits(roach, slope_deg=30, heading=0.15)
    with pytest.raises(ValueError, match=r"path\(0\) = 'cockroach_rigid': must be an animal that has the gait"):
        walk(gait, lambda s: rigid)
    with pytest.raises(ValueError, match="step = -1"):
        walk(gait, lambda s: roach, step=-1)


def test_a_path_may_come_to_an_end(roach: Animal, thesis_map: Cells) -> None:
    gait = thesis_map[30, 0.15][0]
    walked = walk(gait, lambda s: roach.replace(stiffness=1.5 if s < 0.25 else -1.0))
    assert walked.loss is Loss.NO_ANIMAL and "stiffness" in walked.detail
    assert walked.places[-1] == pytest.approx(0.25, abs=1e-4)
