"""The explorer: what it asks of the package, and whom it answers."""

import math
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import legspring as ls
from legspring import Animal, Gait
from legspring.kept import gait_as_json, gait_from_json

work = pytest.importorskip("legspring.explorer.work")


@pytest.fixture(scope="module")
def found(roach: Animal) -> Any:
    return work.search(roach.model_dump_json(), {"slope_deg": 45.0, "heading": 0.15}, {})


def test_a_search(roach: Animal, found: Any) -> None:
    gaits = ls.find_gaits(roach, slope_deg=45, heading=0.15)
    assert [name for name, _ in found.gaits] == [f"{gait.branch}: family {gait.family}, stable" for gait in gaits]
    assert found.told == {"slope_deg": 45.0, "heading": 0.15, "branch": float(found.sight.branch)}
    shown = gaits[found.sight.branch]
    facts = dict(found.sight.facts)
    assert facts["transport cost (Eqs. 3.5, 3.6)"] == f"{shown.transport_cost:.4g}"
    names = [control.name for control in found.controls]
    assert names[:4] == ["slope_deg", "heading", "mass", "stiffness"] and "FL.damping" in names
    assert all(one.low <= one.value <= one.high for one in found.controls)


def test_what_is_seen_is_the_gait(roach: Animal, found: Any) -> None:
    gait, frames = gait_from_json(found.sight.gait), found.sight.frames
    run = gait.simulate(3)
    times = run["time"].values
    for frame in (0, 20, 50):
        row = int(np.argmin(np.abs(times - 1.0 / gait.stride_frequency - found.sight.forces["time"][frame])))
        legs = (run["foot"] - run["hip"]).values[row]
        assert frames["foot"][frame] - frames["hip"][frame] == pytest.approx(legs, abs=1e-4, nan_ok=True)
        assert np.nan_to_num(np.abs(frames["force"][frame])) == pytest.approx(
            np.hypot(*run["force"].values[row].T), abs=0.02
        )
    # Legs push in the families that say so.
    for n, leg in enumerate(gait.animal.legs):
        total = np.nansum(frames["force"][:, n])
        assert (total > 0.0) == (leg.pair in gait.family)


def test_a_change_is_continued(roach: Animal, found: Any) -> None:
    then = work.change(found.sight.gait, "F.stiffness", 1.52)
    gait = gait_from_json(then.sight.gait)
    same = ls.find_gaits(roach.replace(**{"F.stiffness": 1.52}), slope_deg=45, heading=0.15)
    assert min(abs(gait.speed - other.speed) for other in same) < 1e-9
    assert work.change(then.sight.gait, "F.stiffness", 1.52).sight is not None


def test_where_a_gait_ends(found: Any) -> None:
    beyond = work.change(found.sight.gait, "heading", 0.9)
    assert beyond.sight is None and beyond.words.startswith(
        ("two solutions meet", "the stance of a leg shrinks", "a leg")
    )
    assert 0.3 < beyond.nearest < 0.6
    assert work.change(found.sight.gait, "heading", beyond.nearest).sight is not None
    refused = work.change(found.sight.gait, "nonsense", 1.0)
    assert refused.sight is None and "nonsense" in refused.words and math.isnan(refused.nearest)


def test_what_an_address_says(roach: Animal) -> None:
    asked, text = {"slope_deg": 45.0, "heading": 0.15}, roach.model_dump_json()
    there = work.search(text, asked, {"slope_deg": "40", "branch": "0", "F.stiffness": "1.45"})
    gait: Gait = gait_from_json(there.sight.gait)
    assert gait.slope_deg == pytest.approx(40.0) and gait.animal.legs[0].stiffness == 1.45
    assert there.told == {"slope_deg": 40.0, "heading": 0.15, "branch": 0.0, "F.stiffness": 1.45}
    for given in ({"slope_deg": "abc"}, {"\0": "1"}, {"heading": "1e999"}, {"branch": "77"}, {"<script>": "1"}):
        harmless = work.search(text, asked, given)
        assert harmless.sight is not None and harmless.told["slope_deg"] == 45.0
        assert bool(harmless.words) == ("branch" not in given)
    assert work.search(text, asked, {"slope_deg": "200"}).words.startswith("slope")


def test_gaits_are_kept_as_text(found: Any) -> None:
    for _, text in found.gaits:
        assert gait_as_json(gait_from_json(text)) == text


# Whom it answers -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    serving, panel = pytest.importorskip("legspring.explorer.serving"), pytest.importorskip("panel")
    begun, known = threading.Event(), list[Any]()

    def serve() -> None:
        server, where = serving.served(lambda: panel.pane.Str("a page"))
        known.extend((server, where))
        server.start()
        server.io_loop.add_callback(begun.set)
        server.io_loop.start()

    threading.Thread(target=serve, daemon=True).start()
    assert begun.wait(30.0)
    server, where = known
    yield where
    server.io_loop.add_callback(server.io_loop.stop)


def status(address: str, host: str | None = None) -> int:
    """Return how a server answers."""
    request = urllib.request.Request(address, headers={"Host": host} if host else {})
    try:
        with urllib.request.urlopen(request, timeout=20.0) as answer:
            number: int = answer.status
            return number
    except urllib.error.HTTPError as error:
        return error.code


def test_only_who_knows_the_address_is_answered(address: str) -> None:
    base, _, token = address.rpartition("/")
    assert len(token) >= 20 and base.startswith("http://127.0.0.1:")
    assert status(address) == 200
    for other in (base, f"{base}/", f"{base}/{token[:-1]}", f"{base}/{'x' * len(token)}", f"{base}/index"):
        assert status(other) == 404


def test_other_names_of_this_machine_are_refused(address: str) -> None:
    """So a page of another host, whose name leads here, learns nothing."""
    port = address.rpartition("/")[0].rpartition(":")[2]
    assert status(address, f"localhost:{port}") == 200
    for host in (
        "example.org",
        f"example.org:{port}",
        f"127.0.0.1.example.org:{port}",
        f"xlocalhost:{port}",
        "127.0.0.2",
    ):
        assert status(address, host) == 403
        assert status(f"{address.rpartition('/')[0]}/static/js/bokeh.min.js", host) == 403
