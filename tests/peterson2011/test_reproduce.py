"""The thesis as a whole, on optimised gaits that nobody has computed: those take minutes."""

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from PIL import Image

import legspring as ls
from legspring.mapping import HEADINGS, SLOPES_DEG
from legspring.peterson2011 import store as module
from legspring.peterson2011.figures import FIGURES
from legspring.peterson2011.figures.beyond import BEYOND
from legspring.peterson2011.reproduce import TABLES, reproduce
from legspring.peterson2011.store import DATA, Store
from tests.made_up import made_up_limits, made_up_optima


class Calls(list[str]):
    """Methods of optimisation that were asked for, in their order."""

    def optimal_atlas(self, animal: Any, *, method: str, starts: xr.Dataset | None = None, **_: Any) -> xr.Dataset:
        assert (starts is None) == (method == "nelder-mead")
        self.append(method)
        return made_up_optima(SLOPES_DEG, HEADINGS, seed=len(self))


@pytest.fixture(scope="module")
def calls() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        noted = Calls()
        patch.setattr(module, "optimal_atlas", noted.optimal_atlas)
        patch.setattr(module, "limits", lambda *_: made_up_limits())
        yield noted


@pytest.fixture(scope="module")
def thesis(calls: Calls, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the thesis reproduced."""
    out = tmp_path_factory.mktemp("thesis")
    assert reproduce(out) == out / "report.html"
    assert calls == ["nelder-mead", "default"]
    return out


def test_all_figures_are_there(thesis: Path) -> None:
    for figure in [*FIGURES.values(), *BEYOND.values()]:
        with Image.open(thesis / "figures" / f"{figure.stem}.png") as picture:
            assert min(picture.size) > 300
            assert np.asarray(picture.convert("L")).std() > 5.0, f"{figure.stem} looks empty"
        assert (thesis / "figures" / f"{figure.stem}.pdf").read_bytes().startswith(b"%PDF")


# Fronts between gaits that nobody has computed are empty.
def test_all_tables_and_data_are_there(thesis: Path) -> None:
    assert len(list((thesis / "tables").glob("*.csv"))) == len(TABLES)
    for name, (_, _, rows) in DATA.items():
        if name == "start":
            # None were asked for.
            assert not list((thesis / "data").glob("start_*"))
            continue
        with xr.open_dataset(thesis / "data" / f"{name}.nc") as dataset:
            assert set(rows) <= set(dataset.dims)
        with (thesis / "data" / f"{name}.csv").open(encoding="utf-8") as stream:
            assert len(list(csv.reader(stream))) > (0 if name == "fronts" else 3)
    with (thesis / "data" / "claims.csv").open(encoding="utf-8") as stream:
        assert [row["number"] for row in csv.DictReader(stream)] == [str(number) for number in range(1, 29)]
    assert not (thesis / "data" / ".unfinished").exists()


def test_the_report_stands_alone(thesis: Path) -> None:
    text = (thesis / "report.html").read_text(encoding="utf-8")
    assert all(figure.caption.split(".")[0][:30] in text for figure in FIGURES.values())
    assert not re.findall(r'(?:src|href)="(?!data:|#|data/|tables/|figures/)[^"]*"', text)
    assert all((thesis / link).is_file() for link in re.findall(r'href="((?:data|tables|figures)/[^"]*)"', text))


def test_what_is_stored_is_not_computed_again(thesis: Path, calls: Calls) -> None:
    before, stamp = list(calls), (thesis / "data" / "optima.nc").stat().st_mtime_ns
    report = (thesis / "report.html").stat().st_mtime_ns
    picture = thesis / "figures" / f"{FIGURES['5.9'].stem}.png"
    picture.unlink()
    assert reproduce(thesis, only=["5.9"]) == thesis
    assert picture.is_file() and calls == before
    assert (thesis / "data" / "optima.nc").stat().st_mtime_ns == stamp
    assert (thesis / "report.html").stat().st_mtime_ns == report


@pytest.mark.long
def test_a_part_computes_only_what_it_needs(calls: Calls, tmp_path: Path) -> None:
    before = list(calls)
    reproduce(tmp_path, only=["3.2", "3.1", "4.1"])
    names = sorted(path.name for path in tmp_path.rglob("*") if path.is_file())
    stems = [FIGURES[number].stem for number in ("3.2", "4.1")]
    assert {f"{stem}{suffix}" for stem in stems for suffix in (".png", ".pdf")} <= set(names)
    assert calls == before and "optima.nc" not in names and "report.html" not in names


@pytest.mark.long
def test_the_method_of_the_thesis_and_a_fresh_start(thesis: Path, calls: Calls, tmp_path: Path) -> None:
    reproduce(tmp_path, only=["5.1"], method="nelder-mead")
    assert calls[-1] == "nelder-mead" and not (tmp_path / "data" / "optima.nc").exists()
    count = len(calls)
    reproduce(tmp_path, only=["5.1"], method="nelder-mead", fresh=True)
    assert len(calls) == count + 1


@pytest.mark.long
def test_further_starts_of_the_thesiss_search(thesis: Path, calls: Calls) -> None:
    before = len(calls)
    reproduce(thesis, starts=2)
    assert calls[before:] == ["nelder-mead"] * 2
    reproduce(thesis, only=["6.agreement"], starts=2)
    assert len(calls) == before + 2
    with xr.open_dataset(thesis / "data" / "start_2.nc") as second:
        assert {"stability", "efficiency"} == set(second.data_vars)
    text = (thesis / "report.html").read_text(encoding="utf-8")
    assert "From 2 other starts, it gives" in text and "3 runs of the thesis's search" in text.replace("&#39;", "'")
    with (thesis / "tables" / "table_6_agreement.csv").open(encoding="utf-8") as stream:
        assert [row["by"] for row in csv.DictReader(stream)].count("nearest of all other starts") == 2


@pytest.mark.long
def test_datasets_of_other_code_are_not_used(calls: Calls, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reproduce(tmp_path, only=["5.1"], method="nelder-mead")
    count = len(calls)
    monkeypatch.setattr(module, "code_stamp", lambda: "other")
    reproduce(tmp_path, only=["5.1"], method="nelder-mead")
    assert len(calls) == count + 1


def damaged(path: Path, how: str) -> None:
    """Damage a dataset in one of many ways."""
    with xr.open_dataset(path) as file:
        dataset = file.load()
    match how:
        case "garbage":
            path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(range(256)) * 9)
        case "truncated":
            path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
        case "empty":
            path.write_bytes(b"")
        case "other type":
            path.write_text("slope_deg,heading\n1,2\n", encoding="utf-8")
        case "no attribute":
            del dataset.attrs["seconds"]
            dataset.to_netcdf(path)
        case "odd attribute":
            dataset.attrs["seconds"] = "long"
            dataset.to_netcdf(path)
        case "no variable":
            dataset.drop_vars("speed").to_netcdf(path)
        case "other numbers":
            dataset["speed"].values *= 1.0 + 1e-12
            dataset.to_netcdf(path)


HOW = "garbage", "truncated", "empty", "other type", "no attribute", "odd attribute", "no variable", "other numbers"


@pytest.mark.parametrize("how", HOW)
def test_damaged_datasets_are_computed_again(
    thesis: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, how: str
) -> None:
    path = tmp_path / "atlas.nc"
    whole = (thesis / "data" / "atlas.nc").read_bytes()
    path.write_bytes(whole)
    with xr.open_dataset(path) as file:
        atlas = file.load()
    calls: list[str] = []

    def computed(*_: Any, **__: Any) -> xr.Dataset:
        calls.append("atlas")
        return atlas.copy(deep=True)

    monkeypatch.setattr(ls, "atlas", computed)
    xr.testing.assert_identical(store(tmp_path).atlas, atlas)
    assert calls == [] and caplog.messages == [] and path.read_bytes() == whole
    damaged(path, how)
    xr.testing.assert_equal(store(tmp_path).atlas, atlas)
    assert calls == ["atlas"]
    assert caplog.messages == [f"{path}: is damaged, or not ours; computing it again"]
    xr.testing.assert_equal(store(tmp_path).atlas, atlas)
    assert calls == ["atlas"]


def store(directory: Path) -> Store:
    return Store(directory, "default", workers=1, progress=False)


def test_a_directory_in_the_place_of_a_dataset_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "atlas.nc").mkdir()
    with pytest.raises(IsADirectoryError, match=r"atlas\.nc: is a directory; must be a file"):
        _ = store(tmp_path).atlas


def test_times_count_what_stopped_runs_did(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    resumed = made_up_optima(SLOPES_DEG, HEADINGS).assign_attrs(seconds=74.0)
    monkeypatch.setattr(module, "optimal_atlas", lambda *_, **__: resumed)
    for _ in range(2):
        again = store(tmp_path)
        assert again.nelder_mead.attrs["seconds"] == again.seconds["nelder_mead"] == 74.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"only": ["9.9"]}, "only = '9.9'"),
        ({"method": "simplex"}, "method = 'simplex'"),
        ({"workers": 0}, "workers"),
        ({"starts": -1}, "starts = -1"),
    ],
)
def test_wrong_arguments_before_any_work(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        reproduce(tmp_path / "new", **change)
    assert not (tmp_path / "new").exists()


def test_what_was_computed_says_how_and_by_what(thesis: Path) -> None:
    with xr.open_dataset(thesis / "data" / "atlas.nc") as atlas:
        assert atlas.attrs["code"] and float(atlas.attrs["seconds"]) > 0.0
        assert json.loads(atlas.attrs["parameters"])["name"] == "cockroach"
