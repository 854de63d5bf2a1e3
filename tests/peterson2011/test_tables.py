import csv
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from legspring import Animal, Gait
from legspring.constraints import Constraint
from legspring.peterson2011.constraints import TABLE_3_1
from legspring.peterson2011.differences import Difference, difference_table, differences
from legspring.peterson2011.force_tables import (
    agreement_table,
    error_table,
    force_ranges,
    force_tables,
    peak_range,
    peak_ranges,
)
from legspring.peterson2011.published import published_forces
from legspring.peterson2011.tables import constraint_table, parameter_table, save_table
from tests.made_up import best_of, made_up_optima

SLOPES_DEG = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0)
HEADINGS = (0.0, 0.05, 0.15, 0.40, 0.45)


@pytest.fixture(scope="module")
def optima() -> xr.Dataset:
    return made_up_optima(SLOPES_DEG, HEADINGS)


@pytest.fixture(scope="module")
def ranges(optima: xr.Dataset) -> xr.Dataset:
    atlas = optima.sel(objective="stability", family=["B"]).rename(family="branch").assign_coords(branch=[0])
    return force_ranges(atlas, best_of(optima), best_of(made_up_optima(SLOPES_DEG, HEADINGS, seed=2)))


def test_published_forces() -> None:
    forces = published_forces()
    assert set(forces.data_vars) == {"experiment", "model", "stability", "efficiency"}
    at = {"leg": "B", "axis": "fore_aft", "slope_deg": 15.0}
    assert forces["stability"].sel(at).values.tolist() == [0.26, 1.07]
    assert forces["experiment"].sel(leg="M").isnull().all()
    assert all(forces[name].notnull().all() for name in ("model", "stability", "efficiency"))


def test_ranges_are_over_the_headings_of_the_tables_only(optima: xr.Dataset) -> None:
    gaits = best_of(optima).sel(objective="efficiency")
    found = peak_range(gaits)
    force = gaits["peak_force"].sel(leg="M", axis="lateral", slope_deg=45.0).values
    assert found.sel(leg="M", axis="lateral", slope_deg=45.0).values.tolist() == [
        np.nanmin(force[1:4]),
        np.nanmax(force[1:4]),
    ]


def test_a_grid_without_the_slopes_of_the_tables_leaves_them_empty(optima: xr.Dataset) -> None:
    found = peak_range(best_of(optima).sel(objective="stability").sel(slope_deg=[15.0]))
    assert found.sel(slope_deg=15.0).notnull().all()
    assert found.drop_sel(slope_deg=15.0).isnull().all()


def test_the_published_model_columns(thesis_map: dict[tuple[float, float], tuple[Gait, ...]]) -> None:
    peaks = published_forces()["model"]
    headings = sorted({heading for _, heading in thesis_map})
    forces = np.array(
        [
            [
                thesis_map[slope, heading][0].peak_force if thesis_map[slope, heading] else np.full((3, 2), np.nan)
                for heading in headings
            ]
            for slope in SLOPES_DEG
        ]
    )
    gaits = xr.Dataset(
        {"peak_force": (("slope_deg", "heading", "leg", "axis"), forces)},
        coords={"slope_deg": list(SLOPES_DEG), "heading": headings, "leg": peaks["leg"], "axis": peaks["axis"]},
    )
    ours = peak_range(gaits).round(2)
    assert ours.size == 84
    assert float(abs(ours - peaks).max()) < 0.0101


def test_force_tables_hold_ours_beside_the_thesis(ranges: xr.Dataset) -> None:
    tables = force_tables(ranges)
    assert [table.number for table in tables] == ["6.1", "6.2", "6.3"]
    names = [
        f"{objective}{method}"
        for objective in ("stability", "efficiency")
        for method in ("", "_nelder_mead", "_thesis")
    ]
    back = tables[2]
    assert back.columns == ("direction", "slope_deg", "experiment", "model", "model_thesis", *names)
    assert len(back.rows) == 14
    assert back.header[4] == "model thesis"
    row = dict(zip(back.columns, back.rows[8], strict=True))
    assert (row["direction"], row["slope_deg"], row["experiment"]) == ("fore-aft", "15", "0.08 to 0.40")
    assert row["stability_thesis"] == "0.26 to 1.07"
    low, high = ranges["stability"].sel(leg="B", axis="fore_aft", slope_deg=15.0).values
    assert row["stability"] == f"{low:.2f} to {high:.2f}"
    assert {row[2] for row in tables[1].rows} == {""}


def test_a_saved_table_has_two_columns_for_a_range(ranges: xr.Dataset, tmp_path: Path) -> None:
    table = force_tables(ranges)[1]
    save_table(table, tmp_path / f"{table.stem}.csv")
    with open(tmp_path / "table_6_2.csv", newline="") as file:
        first = next(csv.DictReader(file))
    assert (first["direction"], first["slope_deg"]) == ("lateral", "0")
    assert (first["experiment_min"], first["model_thesis_min"], first["model_thesis_max"]) == ("", "-0.31", "0.62")
    expected = ranges["efficiency"].sel(leg="M", axis="lateral", slope_deg=0.0, extreme="max")
    assert float(first["efficiency_max"]) == pytest.approx(float(expected), rel=1e-5)


def test_table_3_1_has_every_constraint() -> None:
    table = constraint_table()
    assert [row[0] for row in table.rows] == [TABLE_3_1.words(constraint) for constraint in Constraint]
    assert [row[1] for row in table.rows].count("soft") == 3
    assert "1.05 times the heading" in table.rows[1][0] and "Below 0.05 rad, at 0.0025 rad more" in table.rows[1][3]
    assert all(row[3].endswith(".") for row in table.rows)


def test_table_4_1_is_about_the_animal(roach: Animal) -> None:
    table = parameter_table(roach.replace(stiffness=(1.0, 2.0, 3.0)), (0.0, 45.0, 90.0), (0.05, 0.15))
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["nominal length l0"] == ("mm", "32", "26", "19", "")
    assert rows["angle at touch-down beta"] == ("deg", "25", "-55", "120", "")
    assert rows["actuation ldev"] == ("mm", "16", "13", "9.5", "")
    assert rows["stiffness k"] == ("N/m", "1", "2", "3", "")
    assert rows["mass m"] == ("g", "", "", "", "2.5")
    assert rows["slope sigma"][-1] == "0 to 90 in steps of 45"
    assert rows["initial heading delta0"][-1] == "0.05 to 0.15 in steps of 0.1"
    assert rows["desired speed v_des"][-1] == "0.35 to 0.2, linear in the slope"
    assert rows["step duration t_des"][-1] == "36.4 to 59.8, by the speed"
    assert "FL, MR, BL" in table.caption


def gaits(forces: list[float], families: list[str], objectives: list[float]) -> xr.Dataset:
    """Return gaits at two headings that are the same for all slopes, but for forces that the thesis agrees with."""
    printed = published_forces()
    selected = best_of(made_up_optima(SLOPES_DEG, (0.10, 0.20)))
    for objective in ("stability", "efficiency"):
        for heading, extreme in enumerate(("min", "max")):
            agreed = printed[objective].sel(extreme=extreme).transpose("slope_deg", "leg", "axis")
            selected["peak_force"].sel(objective=objective).isel(heading=heading)[:] = agreed
    at = {"objective": "stability", "slope_deg": 45.0}
    selected["peak_force"].loc[at | {"leg": "B", "axis": "lateral"}] = forces
    selected["family"].loc[at] = families
    selected["penalised"].loc[at] = objectives
    selected["active"].loc[at] = ["B: a constraint", ""]
    return selected


def only(ours: xr.Dataset, other: xr.Dataset | None = None, optima: xr.Dataset | None = None) -> Difference:
    """Return the only difference; the thesis has 0.19 to 0.25 here."""
    nothing = made_up_optima(SLOPES_DEG, (0.10, 0.20)).where(False)
    (found,) = differences(nothing if optima is None else optima, ours, other)
    assert (found.objective, found.leg, found.axis, found.slope_deg) == ("stability", "B", "lateral", 45.0)
    return found


def test_what_agrees_is_not_listed() -> None:
    assert differences(made_up_optima((45.0,), (0.1,)), gaits([0.19, 0.25], ["B", "B"], [0.1, 0.1])) == ()


def test_a_difference_knows_where_it_occurs() -> None:
    found = only(gaits([0.05, 0.25], ["MB", "B"], [0.1, 0.2]))
    assert (found.extreme, found.ours, found.thesis) == ("min", 0.05, 0.19)
    assert (found.heading, found.family, found.active) == (0.10, "MB", "B: a constraint")
    assert math.isnan(found.nelder_mead) and not found.nelder_mead_is_closer
    assert found.explanation == "Ours: heading 0.1 rad, family MB; what binds there: B: a constraint."


@pytest.mark.parametrize(
    ("forces", "objectives", "reason"),
    [
        ([0.20, 0.25], [0.15, 0.2], "gives its number. At heading 0.1 rad, our objective is 0.100 against 0.150, "
         "family MB against B: the thesis's method stops short of the minimum."),
        ([0.20, 0.25], [0.1, 0.2], "gives its number. At heading 0.1 rad, both end at the same objective, 0.100, "
         "family MB against B: the minimum is not unique."),
        ([0.12, 0.25], [0.05, 0.2], "comes closer. At heading 0.1 rad, our objective is 0.100 against 0.050, "
         "family MB against B: the thesis's method finds a better one."),
        ([0.07, 0.25], [0.05, 0.2], "gives the same as ours."),
        ([math.nan, 0.25], [math.nan, 0.2], "comes closer. At heading 0.1 rad, only our method finds a gait."),
        # The other method's least force is lower, so that its cell decides.
        ([0.20, -0.30], [0.15, 0.1], "comes no closer. At heading 0.2 rad, our objective is 0.200 against 0.100: "
         "the thesis's method finds a better one."),
    ],
)  # fmt: skip
def test_reasons(forces: list[float], objectives: list[float], reason: str) -> None:
    ours = gaits([0.05, 0.25], ["MB", "B"], [0.1, 0.2])
    other = gaits(forces, ["B", "B"], objectives)
    found = differences(made_up_optima((45.0,), (0.1,)).where(False), ours, other)[0]
    assert found.explanation.endswith(f"The thesis's method, run again, {reason}")


def test_other_starts_are_told() -> None:
    ours, other = gaits([0.05, 0.25], ["MB", "B"], [0.1, 0.2]), gaits([0.07, 0.25], ["B", "B"], [0.05, 0.2])
    starts = xr.concat([peak_ranges(gaits([least, 0.25], ["B", "B"], [0.1, 0.1])) for least in (0.1, 0.19)], "start")
    found = differences(made_up_optima((45.0,), (0.1,)).where(False), ours, other, starts.assign_coords(start=[1, 2]))
    assert found[0].explanation.endswith("gives the same as ours. From other starts it gives 0.10 to 0.19.")
    fixed = ours.sel(objective="stability", drop=True).expand_dims(branch=[0])
    table = agreement_table(force_ranges(fixed, ours, other), starts.assign_coords(start=[1, 2]))
    rows = {(str(row[0]), str(row[1])): row[2:4] for row in table.cells}
    total, agree = rows["stability", "best gaits"]
    assert rows["stability", "the same from another start, 1"] == (total, agree)
    # 0.19, the thesis's number, is met by the second start only.
    assert rows["stability", "the same from another start, 2"] == (total, float(agree) + 1)  # type: ignore[arg-type]
    assert rows["stability", "nearest of all other starts"] == (total, float(agree) + 1)  # type: ignore[arg-type]


def test_distances_from_measured_forces(ranges: xr.Dataset) -> None:
    table = error_table(ranges)
    rows = {str(row[0]): row[1:] for row in table.cells}
    away = (ranges["stability_thesis"] - ranges["experiment"]).sel(leg="F").values.ravel()
    expected = math.sqrt(float(np.mean(away[np.isfinite(away)] ** 2)))
    assert rows["stability, as printed"][1] == pytest.approx(expected)
    assert set(rows) >= {"fixed", "fixed, as printed", "stability", "stability, by the thesis's method"}


def test_a_family_that_was_not_selected_may_have_the_number() -> None:
    optima = made_up_optima(SLOPES_DEG, (0.10, 0.20)).where(False)
    at = {"objective": "stability", "slope_deg": 45.0, "heading": 0.20}
    for family in ("A", "B"):  # B is selected there
        optima["peak_force"].loc[at | {"family": family, "leg": "B", "axis": "lateral"}] = 0.19
        optima["penalised"].loc[at | {"family": family}] = 0.3
    found = only(gaits([0.05, 0.25], ["MB", "B"], [0.1, 0.2]), optima=optima)
    assert found.alternative == ("A", 0.20, 0.3, 0.2)
    assert found.explanation.endswith(
        "Family A at heading 0.2 rad has the thesis's number; its objective is 0.300, that of the best family 0.200."
    )


def test_differences_as_a_table() -> None:
    table = difference_table([only(gaits([0.05, 0.25], ["MB", "B"], [0.1, 0.2]))])
    (row,) = table.rows
    assert row[:8] == ("stability", "back", "lateral", "45", "min", "0.05", "", "0.19")
