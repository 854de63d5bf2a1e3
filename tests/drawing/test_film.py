"""Moving pictures."""

import json
import re
from base64 import b64decode
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from PIL import Image
from scipy.interpolate import interp1d

import legspring as ls
from legspring.drawing.stage import PULL, PUSH, PUSHED, THICK, THIN, Shot, Stage, common_window
from legspring.figures import Film, animate
from tests.places import place_of


@pytest.fixture(scope="module")
def gait() -> ls.Gait:
    return ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]


@pytest.fixture(scope="module")
def runner() -> ls.Gait:
    return ls.find_gaits(ls.load_animal("spring_loaded_inverted_pendulum"))[0]


def stage_of(shot: Shot) -> Stage:
    return Stage(Figure().add_subplot(), shot, common_window([shot])[0], shot.strongest)


def points(line: Line2D) -> NDArray[np.float64]:
    return np.column_stack([np.asarray(values, dtype=float) for values in line.get_data()])


def rgb(colour: str) -> tuple[int, ...]:
    return tuple(int(colour[place : place + 2], 16) for place in (1, 3, 5))


def test_the_end_of_a_gait_is_its_beginning(gait: ls.Gait) -> None:
    shot = gait.animate(strides=1).shots[0]
    stride = 1.0 / gait.stride_frequency
    assert (shot.begin, shot.end) == pytest.approx((stride, 2 * stride))
    assert shot.repeats
    stage = stage_of(replace(shot, repeats=False))
    pictures = []
    for elapsed in (0.0, stride):
        stage.show(elapsed)
        feet = np.sort(points(stage.feet), axis=0)
        pictures.append((np.array(stage.legs.get_segments()), feet, np.array(stage.body.centre.get_data())))
    for one, other in zip(*pictures, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_marks_on_the_ground_come_back_after_a_stride(gait: ls.Gait) -> None:
    shot = gait.animate(strides=1).shots[0]
    stage = stage_of(shot)
    places = []
    for elapsed in (0.0, 0.5 * (shot.end - shot.begin), (1.0 - 1e-9) * (shot.end - shot.begin)):
        stage.show(elapsed)
        # In marks; which of them is drawn first is of no account.
        first = points(stage.ground.artist)[0] - stage.ground.marks[0]
        places.append(np.linalg.solve(stage.ground.lattice.T, first) % 1.0)
    start, middle, end = np.exp(2j * np.pi * np.array(places))
    np.testing.assert_allclose(end, start, atol=1e-6)
    # Half of a stride is two marks on.
    np.testing.assert_allclose(middle[1], start[1], atol=0.05)


def test_legs_are_where_the_simulation_has_them(gait: ls.Gait) -> None:
    run = gait.simulate(3)
    shot = Shot(run, 0.0, float(run["time"][-1]), "")
    stage = stage_of(shot)
    camera = interp1d(run["time"].values, shot.camera, axis=0)
    for row in (7, 133, 250, 480):
        time = float(run["time"].values[row])
        stage.show(time)
        down = run["stance"].values[row].astype(bool)
        hips, feet = run["hip"].values[row, down], run["foot"].values[row, down]
        expected = np.stack([hips, feet], axis=1) - camera(time)
        np.testing.assert_allclose(np.array(stage.legs.get_segments()), expected, atol=1e-12)
        free = np.array(stage.free.get_segments())
        lengths = np.hypot(*(free[:, 1] - free[:, 0]).T)
        np.testing.assert_allclose(lengths, run["free_length"].values[row, down], rtol=1e-12)


def test_colour_and_width_say_how_a_leg_works(gait: ls.Gait) -> None:
    run = gait.simulate(2)
    shot = Shot(run, 0.0, float(run["time"][-1]), "")
    stage, seen = stage_of(shot), set()
    for row in range(5, 400, 7):
        stage.show(float(run["time"].values[row]))
        down = run["stance"].values[row].astype(bool)
        force = np.hypot(*run["force"].values[row, down].T)
        # A leg that is longer than without force pulls.
        longer = run["leg_length"].values[row, down] > run["free_length"].values[row, down]
        colours = [tuple(round(255 * part) for part in colour[:3]) for colour in np.asarray(stage.legs.get_color())]
        assert colours == [rgb(PULL) if long else rgb(PUSH) for long in longer]
        widths = np.array(stage.legs.get_linewidth())
        np.testing.assert_allclose(widths, THIN + (THICK - THIN) * force / shot.strongest)
        seen |= set(longer.tolist())
    assert seen == {True, False}


def test_a_push_is_seen_while_it_lasts(gait: ls.Gait) -> None:
    recovery = gait.recover(0.5)
    film = recovery.animate(slow=20)
    shot = film.shots[0]
    begin, end = shot.run.attrs["push_time"]
    np.testing.assert_allclose(shot.run.attrs["push"], [0.5 * shot.run.attrs["desired_speed"], 0.0])
    assert end - begin == pytest.approx(4e-3)
    velocity = shot.run["velocity"].values[:, 0]
    before, after = (int(np.searchsorted(shot.run["time"].values, time)) for time in (begin, end))
    # The legs do little in so short a time.
    assert velocity[after] - velocity[before - 1] == pytest.approx(0.5 * shot.run.attrs["desired_speed"], rel=0.1)
    stage = stage_of(shot)
    for time, visible in ((0.5 * begin, 0), (0.5 * (begin + end), 2), (end + 0.02, 0)):
        stage.show(time)
        assert np.count_nonzero(np.isfinite(points(stage.push)[:, 0])) == visible
    stage.show(begin)
    start, tip = points(stage.push)
    assert start[0] < tip[0] and start[1] == pytest.approx(tip[1])
    frames = list(film.frames())
    pushed = [bool(np.any(np.all(frame[60:-60] == rgb(PUSHED), axis=-1))) for frame in frames[:20]]
    assert True in pushed and not pushed[0] and not pushed[19]


def test_the_camera_goes_along_with_the_mean_of_a_stride(runner: ls.Gait) -> None:
    run = runner.simulate(4)
    shot = Shot(run, 0.0, float(run["time"][-1]), "")
    speed = np.gradient(shot.camera[:, 0], run["time"].values)
    middle = slice(110, -110)
    np.testing.assert_allclose(speed[middle], runner.mean_speed, rtol=1e-3)
    assert np.ptp(shot.camera[middle, 1]) < 1e-3 * np.ptp(run["position"].values[:, 1])


@pytest.mark.parametrize(
    ("suffix", "magic"), [("gif", b"GIF89a"), ("html", b"<!DOCTYPE"), ("mp4", b"ftyp"), ("webm", b"webm")]
)
def test_films_are_files_that_others_read(gait: ls.Gait, tmp_path: Path, suffix: str, magic: bytes) -> None:
    film, path = gait.animate(strides=1), tmp_path / f"run.{suffix}"
    film.save(path)
    assert magic in path.read_bytes()[:64]
    assert list(tmp_path.iterdir()) == [path]
    if suffix == "html":
        return
    if suffix == "gif":
        with Image.open(path) as picture:
            # Frames that show the same as those before are lengthened instead.
            assert getattr(picture, "n_frames", 0) >= len(film) - 2
            assert picture.size == film.shape[::-1]
        return
    from imageio_ffmpeg import count_frames_and_secs, read_frames

    frames, seconds = count_frames_and_secs(str(path))
    assert frames == len(film)
    assert seconds == pytest.approx(film.seconds, abs=0.05)
    about = next(read_frames(str(path)))
    assert isinstance(about, dict) and about["size"] == film.shape[::-1]


def test_slow_motion_is_what_is_said(gait: ls.Gait) -> None:
    film = gait.animate(strides=3, slow=50)
    assert film.seconds == pytest.approx(50 * 3 / gait.stride_frequency, abs=0.5 / film.fps)
    assert film.pace == "50 times slower"
    assert gait.animate(slow=1).pace == "as fast as life"
    assert animate(gait, slow=0.5, strides=50).pace == "2 times faster"


def test_a_player_holds_every_frame(gait: ls.Gait) -> None:
    film = animate(gait, strides=1, width=200)
    page = film._repr_html_()
    found = re.search(r"const frames = (\[.*?\])", page, re.DOTALL)
    assert found is not None
    pictures = json.loads(found.group(1))
    assert len(pictures) == len(film)
    frame = Image.open(BytesIO(b64decode(pictures[5].partition(",")[2])))
    assert frame.size == film.shape[::-1]
    # Nothing comes from elsewhere.
    assert "http" not in page


def test_gaits_are_seen_side_by_side(gait: ls.Gait, runner: ls.Gait) -> None:
    film = animate(gait, runner, slow=20)
    # The shorter one begins anew, as often as is needed, for as long as the longer one lasts.
    one, two = film.shots
    assert film.duration == pytest.approx(2 / runner.stride_frequency)
    stride = 1 / gait.stride_frequency
    assert one.at(2.5 * stride) == pytest.approx(1.5 * stride)
    assert two.at(film.duration / 2) == pytest.approx(1.5 * film.duration / 2 * 4 / 3)
    # Whatever their sizes, both fill their panels.
    for window, shot in zip(common_window(film.shots), film.shots, strict=True):
        assert np.ptp(window, axis=0).max() < 2.0 * np.ptp(shot.extent, axis=0).max()
    assert film.shape[1] == 2 * film.width
    alike = animate(gait, gait.recover(0.2))
    first, second = common_window(alike.shots)
    np.testing.assert_array_equal(first, second)


def test_a_simulation_stands_still_at_its_end(gait: ls.Gait) -> None:
    film = animate(gait.simulate(1), gait.simulate(2))
    assert film.shots[0].at(film.duration) == pytest.approx(1 / gait.stride_frequency)


@pytest.mark.parametrize("name", ls.presets())
def test_every_preset_moves(name: str) -> None:
    animal = ls.load_animal(name)
    gaits = ls.find_gaits(animal, **place_of(animal))
    film = gaits[0].animate(strides=1)
    frames = list(film.frames())
    assert len(frames) == len(film) > 20
    shape = (*film.shape, 3)
    assert all(frame.shape == shape and frame.dtype == np.uint8 for frame in frames)
    assert len({frame.tobytes() for frame in frames}) > 0.9 * len(frames)


def test_a_simulation_is_shown_whole() -> None:
    run = ls.simulate(ls.load_animal("lateral_leg_spring"), speed=0.5, heading=0.1, strides=5)
    film = animate(run)
    assert film.duration == pytest.approx(float(run["time"][-1]))
    assert isinstance(film, Film)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"slow": 0.0}, "slow = 0.0: must be a positive finite number"),
        ({"slow": 1e9}, "must be such that the film has from 2 to 5000 frames"),
        ({"slow": 1e-9}, "must be such that the film has from 2 to 5000 frames"),
        ({"strides": float("nan")}, "strides = nan: must be a positive finite number"),
        ({"strides": 1000}, "strides = 1000: must be at most 500"),
        ({"fps": 0}, "fps = 0: must be a whole number from 1 to 100"),
        ({"fps": 24.5}, "fps = 24.5: must be a whole number"),
        ({"width": 20}, "width = 20: must be a whole number from 160 to 2000"),
    ],
)
def test_what_cannot_be_filmed_is_said(gait: ls.Gait, options: dict[str, float], words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        animate(gait, **options)  # type: ignore[arg-type]


def test_subjects_are_checked(gait: ls.Gait) -> None:
    with pytest.raises(ValueError, match="0 subjects: must be from 1 to 4"):
        animate()
    with pytest.raises(ValueError, match="must be a Gait, a Recovery, or a Dataset"):
        animate("cockroach")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="must be left out; a simulation is shown whole"):
        animate(gait.simulate(), strides=1)


def test_without_its_extra_there_is_no_video(gait: ls.Gait, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("legspring.drawing.film.find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"videos need imageio-ffmpeg, which pip install 'legspring\[video\]' brings"):
        gait.animate().save(tmp_path / "run.mp4")
    with pytest.raises(ValueError, match=r"must end in \.gif, \.html, \.mp4, \.webm"):
        gait.animate().save(tmp_path / "run.avi")


def test_settings_of_others_change_nothing(gait: ls.Gait) -> None:
    film = gait.animate(strides=1, slow=2)
    plain = next(film.frames())
    with mpl.rc_context({"figure.constrained_layout.use": True, "font.size": 20, "axes.grid": True}):
        np.testing.assert_array_equal(next(film.frames()), plain)
