import json
import subprocess
import sys
from math import atan2, cos, hypot, radians, sin
from pathlib import Path

import pytest

from legspring.model import ModelError, cockroach, load_animal, presets


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "mine.toml"


def test_the_cockroach_is_that_of_table_4_1() -> None:
    roach = cockroach()
    assert roach.name == "cockroach"
    assert "Peterson" in roach.source
    assert (roach.gravity, roach.body.mass, roach.body.inertia, roach.body.yaw) == (
        9.81,
        2.5e-3,
        2.04e-7,
        "held",
    )
    table = {"F": (0.032, 25, 0.016), "M": (0.026, -55, 0.013), "B": (0.019, 120, 0.0095)}
    for leg in roach.legs:
        length, angle_deg, actuation = table[leg.pair]
        tripod_sign = 1 if leg.name in ("FL", "MR", "BL") else -1
        assert (leg.length, leg.actuation, leg.stiffness, leg.hip) == (length, actuation, 1.5, (0.0, 0.0))
        assert leg.angle == tripod_sign * radians(angle_deg)
        assert leg.offset == (0 if tripod_sign > 0 else 1)
    assert roach.families == {"A": ("F", "M", "B"), "FB": ("F", "B"), "MB": ("M", "B"), "B": ("B",)}


def test_the_rigid_cockroach_has_the_point_mass_s_feet() -> None:
    rigid = load_animal("cockroach_rigid")
    assert (rigid.body.yaw, rigid.body.inertia, rigid.body.mass) == ("free", 2.04e-7, 2.5e-3)
    assert "appendix" in rigid.source
    hips = {"FL": (-0.0035, 0.014), "MR": (0.0035, 0.007), "BL": (-0.0035, 0.0)}
    for leg, point in zip(rigid.legs, cockroach().legs, strict=True):
        assert leg.hip == hips.get(leg.name, leg.hip)
        foot = (-point.length * sin(point.angle), point.length * cos(point.angle))
        reach = (foot[0] - leg.hip[0], foot[1] - leg.hip[1])
        assert leg.length == pytest.approx(hypot(*reach), abs=1e-12)
        assert leg.angle == pytest.approx(atan2(-reach[0], reach[1]), abs=1e-11)
        assert (leg.stiffness, leg.actuation) == (point.stiffness, point.actuation)
        assert 0.2 * leg.length < leg.actuation < 0.9 * leg.length, "the thesis's limits"
    assert (rigid.families, rigid.speed_law, rigid.step_law) == (
        cockroach().families,
        cockroach().speed_law,
        cockroach().step_law,
    )


def test_presets_are_listed_and_load_under_their_own_names() -> None:
    assert "cockroach" in presets()
    for name in presets():
        assert load_animal(name).name == name
    assert load_animal("cockroach") == cockroach()


@pytest.mark.parametrize("name", presets())
def test_an_animal_as_the_text_of_a_file(file: Path, name: str) -> None:
    animal = load_animal(name)
    changed = animal.replace(name="mine", mass=animal.body.mass / 3.0)
    for one in (animal, changed, changed.replace(**{f"{animal.pairs[0]}.length": animal.legs[0].length * 1.1})):
        file.write_text(one.to_toml(), encoding="utf-8")
        assert load_animal(file) == one


def test_a_file_like_a_preset(file: Path) -> None:
    file.write_text(
        'like = "cockroach"\nmass = 3e-3\nangle_deg = [30, -60, 130]\n[speed_law]\nlevel = 0.3\nvertical = 0.2\n'
    )
    expected = cockroach().replace(
        name="mine", mass=3e-3, angle_deg=[30, -60, 130], speed_law={"level": 0.3, "vertical": 0.2}
    )
    assert load_animal(file) == load_animal(str(file)) == expected


def test_a_preset_has_the_form_of_a_file(file: Path) -> None:
    import legspring.model.load as load

    file.write_text((Path(load.__file__).with_name("animals") / "cockroach.toml").read_text())
    assert load_animal(file) == cockroach()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mass = ", "Invalid value"),
        ("\x00", "Invalid"),
        ('like = "roach"', r"like = 'roach': must be a preset \(centipede, climbing_template, .*"),
        ('like = ["cockroach"]', "like = .*: must be the name of a preset or"),
        ('like = "cockroach"\nstiffness = -1', "Leg 'FL': stiffness = -1: must be greater than 0"),
        ('like = "cockroach"\ncolour = "brown"', "cannot replace colour: must be among"),
        ('like = "cockroach"\nmass = "3e-3"', "Body: mass = '3e-3': must be a number"),
        ("mass = 3e-3", "Animal 'mine': body is missing; .* mass is unknown"),
        ('[[legs]]\nname = "L"\nangle_deg = "x"', r"legs\[0\]: Leg 'L': angle_deg = 'x': must be a number"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_in_one_line(file: Path, text: str, message: str) -> None:
    file.write_text(text)
    with pytest.raises(ModelError, match=message) as caught:
        load_animal(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert "\n" not in str(caught.value)


def test_a_file_that_is_no_text(file: Path) -> None:
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ModelError, match=r"mine\.toml: "):
        load_animal(file)


def test_what_is_not_there(file: Path) -> None:
    with pytest.raises(ModelError, match=r"mine\.toml: No such file"):
        load_animal(file)
    with pytest.raises(
        ModelError, match=r"^no animal 'roach': must be a preset \(centipede, climbing_template, .*\) or a TOML file$"
    ):
        load_animal("roach")
    with pytest.raises(ModelError, match="Is a directory"):
        load_animal(file.parent)


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b", "a\0.toml", "y" * 300 + ".toml"])
def test_names_that_no_file_can_have(name: str, file: Path) -> None:
    with pytest.raises(ModelError, match=r"^(no animal |y)") as caught:
        load_animal(name)
    assert str(caught.value).isprintable() and len(str(caught.value)) <= 300
    file.write_text(f"like = {json.dumps(name)}")
    with pytest.raises(ModelError, match=r"mine\.toml|^y|/y|\.\.\.$") as caught:
        load_animal(file)
    assert str(caught.value).isprintable() and len(str(caught.value)) <= 300


def test_names_of_files_are_cut_and_labels_are_short(file: Path) -> None:
    long = file.with_name(100 * "n" + ".toml")
    long.write_text('like = "cockroach"')
    assert load_animal(long).name == 60 * "n"
    with pytest.raises(ModelError, match=r"name = .*: string must have at most 60 characters"):
        cockroach().replace(name=61 * "n")


def test_the_model_imports_nothing_heavy() -> None:
    heavy = {"numba", "scipy", "xarray", "pandas", "matplotlib", "netCDF4"}
    code = f"import sys, legspring.model; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("text", ["\ufeff{}", "{}\r\n", "\ufeff{}\r\n"])
def test_what_editors_of_other_systems_write(file: Path, text: str) -> None:
    text = text.format('like = "cockroach"\nmass = 3e-3')
    file.write_bytes((text.replace("\n", "\r\n") if text.endswith("\r\n") else text).replace("\r\r", "\r").encode())
    assert load_animal(file).body.mass == 3e-3


def test_a_file_may_be_like_another_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "first.toml").write_text('like = "cockroach"\nmass = 3e-3')
    (tmp_path / "second.toml").write_text('like = "mine/first.toml"\nstiffness = 2.0')
    # Seen from the file, and not from where Python happens to be.
    monkeypatch.chdir(tmp_path / "mine")
    animal = load_animal(tmp_path / "second.toml")
    assert (animal.name, animal.body.mass, animal.legs[0].stiffness) == ("second", 3e-3, 2.0)


@pytest.mark.parametrize("names", [("a",), ("a", "b"), ("a", "b", "c")])
def test_a_file_that_is_like_itself(tmp_path: Path, names: tuple[str, ...]) -> None:
    for name, like in zip(names, names[1:] + names[:1], strict=True):
        (tmp_path / f"{name}.toml").write_text(f'like = "{like}.toml"')
    with pytest.raises(ModelError, match=r"like = 'a\.toml': must be a file that is not like this one$"):
        load_animal(tmp_path / "a.toml")


@pytest.mark.parametrize("depth", [100, 900, 5000])
def test_arrays_of_any_depth(file: Path, depth: int) -> None:
    file.write_text('like = "cockroach"\nstiffness = ' + "[" * depth + "1" + "]" * depth)
    with pytest.raises(ModelError) as caught:
        load_animal(file)
    assert len(str(caught.value).splitlines()) == 1 and len(str(caught.value)) <= 300


@pytest.mark.parametrize("name", ["two\nlines", "bell\a", "", "\u202e"])
def test_names_can_be_shown(name: str) -> None:
    with pytest.raises(ModelError, match="name = "):
        cockroach().replace(name=name)


def test_names_may_look_like_markup() -> None:
    assert cockroach().replace(name="roach [/old] :smile:").name == "roach [/old] :smile:"
