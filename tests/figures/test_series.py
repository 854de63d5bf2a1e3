"""Figures of motion and energy against time."""

import numpy as np
import pytest

import legspring as ls
from legspring import Gait
from legspring.figures import draw_energy, draw_motion


@pytest.fixture(scope="module")
def gait(roach: ls.Animal) -> Gait:
    return ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]


def test_motion_is_that_of_the_run(gait: Gait) -> None:
    figure, run = draw_motion(gait), gait.simulate(2)
    lateral, fore_aft, yaw, moment, front, *_ = figure.axes
    for axes, values in ((lateral, run["position"][:, 0]), (fore_aft, run["position"][:, 1])):
        np.testing.assert_allclose(np.asarray(axes.lines[0].get_ydata()), 1e3 * values)
    assert not np.any(yaw.lines[0].get_ydata()) and not np.any(moment.lines[0].get_ydata())
    actual, free = front.lines[:2]
    np.testing.assert_allclose(np.asarray(actual.get_ydata()), 1e3 * run["leg_length"].sel(leg="FL"))
    np.testing.assert_allclose(np.asarray(free.get_ydata()), 1e3 * run["free_length"].sel(leg="FL"))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["actual", "force-free"]


def test_energy_is_that_of_the_run(gait: Gait) -> None:
    run = gait.simulate(2)
    figure = draw_energy(run)
    held, change, springs, actuation = figure.axes
    assert "mJ" in held.get_title()
    lines = {line.get_label(): np.asarray(line.get_ydata()) for line in held.lines}
    np.testing.assert_allclose(lines["all"], lines["kinetic"] + lines["height"] + lines["springs"])
    np.testing.assert_allclose(lines["kinetic"], 1e3 * run["kinetic_energy"])
    whole, work = (np.asarray(line.get_ydata()) for line in change.lines[:2])
    np.testing.assert_allclose(whole, work, atol=1e-9)
    assert [line.get_label() for line in springs.lines[:6]] == [str(leg) for leg in run["leg"].values]
    np.testing.assert_allclose(np.asarray(actuation.lines[0].get_ydata()), 1e3 * run["actuation_work"][:, 0])
    assert "unaccounted for: " in figure.get_suptitle()


@pytest.mark.parametrize("name", ["walker", "centipede", "climbing_template"])
def test_other_animals(name: str) -> None:
    animal = ls.load_animal(name)
    run = ls.find_gaits(animal, slope_deg=90 if name == "climbing_template" else 0)[0].simulate(1)
    assert len(draw_motion(run).axes) == 4 + len(animal.pairs) and len(draw_energy(run).axes) == 4


def test_recoveries_are_drawn_and_other_things_are_not(gait: Gait) -> None:
    recovery = gait.recover(0.3)
    assert "push" in [line.get_label() for line in draw_energy(recovery).axes[1].lines]
    assert len(draw_motion(recovery).axes) == 7
    for draw in (draw_energy, draw_motion):
        for other in (None, 3, gait.animal):
            with pytest.raises(ValueError, match=r"run = .*: must be a gait, a recovery, or the Dataset"):
                draw(other)  # type: ignore[arg-type]
