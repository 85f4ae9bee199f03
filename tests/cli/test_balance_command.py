"""`pinpress balance`: what it prints and writes is what the library gives; every word it takes; what it says of wrong ones."""

import contextlib
import csv
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.in_browser import data_in
from support.refused_commands import one_line
from support.texts import shipped

import pinpress as pp
from pinpress.balancing import problem
from pinpress.cli import balance as command_balance
from pinpress.cli.main import main
from pinpress.cli.words.part_specs import LOADS

ROOT = Path(__file__).resolve().parents[2]
REGIONS = ["--region", "crank:radius=0.3", "--region", "rod:radius=0.3,mass=0/200"]
ASKED = ["--minimise", "range:shaking_force:z", "--limit", "range:shaking_force:x=1000", "--limit", "added_mass=400"]
X, Z = pp.balancing.Range("shaking_force", "x"), pp.balancing.Range("shaking_force", "z")


def printed(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    assert main(["balance", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    return one_line(capsys, "balance", *arguments)


def six_bar(*speeds: float, points: int = 120) -> pp.balancing.BalancedPress:
    """What the command is asked for, by the library."""
    press = shipped("zxn2_3000b")
    cases = [pp.balancing.OperatingCondition(pp.cycle(press, speed * pp.RPM, points=points)) for speed in speeds]
    regions = [pp.balancing.CounterweightRegion("crank", radius=0.3), pp.balancing.CounterweightRegion("rod", (0, 200), radius=0.3)]
    return pp.balancing.balance(press, cases, regions=regions, minimise=Z, limits={X: 1000.0, pp.balancing.AddedMass(): 400.0})


def test_it_prints_the_balance_and_writes_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert printed(capsys, "zxn2_3000b", "--speed", 70, "--points", 120, *REGIONS, *ASKED).startswith(f"{six_bar(70)}\n\nInputs\n")
    assert not list(tmp_path.iterdir())


def test_files(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "made" / "out"
    text = printed(capsys, "zxn2_3000b", "--speed", 70, "--points", 120, *REGIONS, *ASKED, "--out", out, "--report")
    files = ["balanced.urdf", "balance.csv", "counterweights.csv", "report.html"]
    expected = six_bar(70)
    found, inputs = text.split("\n\nInputs\n")
    assert found == str(expected)
    for words in (
        "press         zxn2_3000b,",
        "motion        one period at 70 r/min",
        *(f"region        {region}" for region in REGIONS[1::2]),
    ):
        assert words in inputs
    assert inputs.endswith(f"\n\nwrote {', '.join(str(out / name) for name in files[:-1])} and {out / files[-1]}\n")
    assert sorted(path.name for path in out.iterdir()) == sorted(files)
    assert read(out / "balance.csv")["after"] == [repr(value) for value in expected.columns()["after"]]
    weights = read(out / "counterweights.csv")
    assert weights["link"] == [weight.link for weight in expected.counterweights]
    assert [float(mass) for mass in weights["mass [kg]"]] == [weight.mass for weight in expected.counterweights]
    data = data_in(out / "report.html")
    assert "dashed: zxn2_3000b, crank at 70 r/min" in data["report"]["subtitle"]
    blocks = [block for section in data["report"]["sections"] for block in section["blocks"]]
    (bearings,) = (block["bearings"] for block in blocks if block["kind"] == "bearings")
    assert [bearing["name"] for bearing in bearings if bearing["before"]] == list(shipped("zxn2_3000b").bearings_as_drawn)


def read(path: Path) -> dict[str, list[str]]:
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    return {name: list(column) for name, column in zip(header, zip(*rows, strict=True), strict=True)}


def test_the_balanced_press_does_what_is_printed(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = printed(capsys, "zxn2_3000b", "--speed", 70, "--points", 120, *REGIONS, *ASKED, "--out", tmp_path)
    press = pp.load(tmp_path / "balanced.urdf")
    result = pp.inverse_dynamics(press, pp.cycle(press, 70 * pp.RPM, points=120))
    table = read(tmp_path / "balance.csv")
    after = dict(zip(table["criterion"], map(float, table["after"]), strict=True))
    expected = {
        "range of the shaking force, z": np.ptp(result.shaking_force[:, 2]),
        "range of the shaking force, x": np.ptp(result.shaking_force[:, 0]),
        "range of the shaking moment, y": np.ptp(result.shaking_moment[:, 1]),
        "range of the driving torque": np.ptp(result.driving_torque),
    } | {f"peak of the bearing force of {name}": np.linalg.norm(force, axis=1).max() for name, force in result.bearing_force.items()}
    assert after == pytest.approx(expected, rel=1e-10)  # masses are written to the last bit; differences of large forces round
    for name, value in expected.items():
        ((kilo, number),) = re.findall(rf"^  {re.escape(name)} \[(k?)N(?: m)?\] +\S+ +(\S+)", text, flags=re.MULTILINE)
        assert float(number) * (1e3 if kilo else 1.0) == pytest.approx(value, rel=6e-5)  # five digits


def test_several_speeds_are_cases(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = printed(capsys, "zxn2_3000b", "--speed", 70, "--speed", -50, "--points", 120, *REGIONS, *ASKED, "--out", tmp_path)
    assert text.startswith(f"{six_bar(70, -50)}\n")
    assert "\n  1          -50 r/min of joint A" in text
    assert read(tmp_path / "balance.csv")["condition"][:4] == ["0", "1", "0", "1"]


def test_dies_are_conditions(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """One counterweight for each die, by 15 / 29.7 of its mass more."""
    words = ["jf75g_125", "--points", 72, "--minimise", "range:shaking_force:z"]
    words += ["--region", "counterweight:at=0/0/0,mass=-600/600,reset=mass", "--die", 100, "--die", "400kg"]
    text = printed(capsys, *words, "--speed", 300, "--out", tmp_path, "--report")
    assert "\n  die of 100 kg  300 r/min of joint O, 72 states\n  die of 400 kg  300 r/min of joint O" in text
    first, second = (float(read(tmp_path / f"counterweights_{k}.csv")["mass [kg]"][0]) for k in range(2))
    assert second - first == pytest.approx(300 * 15 / 29.7, abs=0.02)  # of equal ratios exactly
    assert "die           100 kg" in text
    press = pp.load(tmp_path / "balanced.urdf")
    assert press.model.inertias[press.model.getJointId("slide_guide")].mass == 2200.0
    text = printed(capsys, *words, "--speed", 300, "--speed", 200)
    assert "\n  die of 400 kg (3)  200 r/min" in text


@pytest.mark.exhaustive
def test_settings_are_conditions(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """Strokes of a shipped press by the radius of its cranks: another mass of both blocks, in proportion, and none at its own radius."""
    words: list[object] = ["eccentric_blocks", "--speed", 300, "--points", 72]
    words += ["--minimise", "range:shaking_force:z", "--limit", "range:shaking_force:x=1"]
    for side in ("left", "right"):
        words += ["--region", f"crank_{side}:at=-150mm/0/0,mass=-100/100,reset=mass"]
    text = printed(capsys, *words, "--setting", "r=10", "--setting", "r=15", "--setting", "r=20", "--out", tmp_path)
    assert re.search(r"  r=10 +300 r/min of joint O_left, 72 states\n  r=15 +300 r/min", text)
    assert "r=20" in text
    for number, radius in ((0, 10), (2, 20)):
        masses = np.array(read(tmp_path / f"counterweights_{number}.csv")["mass [kg]"], float)
        np.testing.assert_allclose(masses, 232.974 / 2 * (radius / 15 - 1), atol=0.05)
    assert len((tmp_path / "counterweights_1.csv").read_text(encoding="utf-8").splitlines()) == 1
    text = printed(capsys, *words, "--setting", "r=10", "--setting", "r=15", "--die", 0, "--die", "400kg")
    assert re.search(r"  r=15, die of 400 kg +300 r/min", text)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["eccentric_blocks", "--setting", "q=3"], "no parameter q"),
        (["eccentric_blocks", "--setting", "r"], "write NAME=VALUE"),
        (["eccentric_blocks", "--setting", "r=10,r=12"], "r is given twice"),
        (["missing.urdf", "--setting", "r=10"], "missing.urdf"),
        (["eccentric_blocks", "--setting", "r=10mm"], "--setting r=10mm"),
    ],
)
def test_settings_that_are_none(capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    asked = ["--speed", "60", "--region", "crank_left:at=-0.1/0/0", "--minimise", "range:shaking_force:z"]
    assert main(["balance", *words, *asked]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(("words", "said"), [(["--die", -5], "cannot be negative"), (["--die", "5mm"], "kg")])
def test_dies_that_are_none(capsys: pytest.CaptureFixture[str], words: list[object], said: str) -> None:
    asked = ["crank_slide", "--speed", 60, "--region", "crank:radius=0.1", "--minimise", "range:shaking_force:z"]
    with pytest.raises(SystemExit) if said == "kg" else contextlib.nullcontext():
        assert main(["balance", *map(str, [*asked, *words])]) == 2
    assert said in capsys.readouterr().err


def test_under_a_load(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """The peak of the driving torque while drawing, which counts the load; the report shows it too."""
    press, load = shipped("zxn2_3000b"), pp.loads.DeepDrawing(force=1e6, start=0.010)
    target = pp.balancing.Peak("driving_torque")
    expected = pp.balancing.balance(
        press,
        pp.cycle(press, 70 * pp.RPM, points=120),
        regions=[pp.balancing.CounterweightRegion("crank", radius=0.3)],
        minimise=target,
        limits={pp.balancing.AddedMass(): 300.0},
        loads=[load],
    )
    idle = pp.balancing.balance(
        press,
        pp.cycle(press, 70 * pp.RPM, points=120),
        regions=[pp.balancing.CounterweightRegion("crank", radius=0.3)],
        minimise=target,
        limits={pp.balancing.AddedMass(): 300.0},
    )
    words = ["--load", "drawing:force=1e6,start=0.010", "--region", "crank:radius=0.3", "--minimise", "peak:driving_torque"]
    rest = ["--limit", "added_mass=300", "--points", 120, "--out", tmp_path, "--report"]
    assert printed(capsys, "zxn2_3000b", "--speed", 70, *words, *rest).startswith(f"{expected}\n")
    assert str(expected) != str(idle)
    motion = pp.cycle(expected.press, 70 * pp.RPM, points=120)
    pressed = pp.inverse_dynamics(expected.press, motion, [load])
    largest = max(pressed.process_force.max(), *(np.linalg.norm(force, axis=1).max() for force in pressed.bearing_force.values()))
    assert data_in(tmp_path / "report.html")["peak"] == pytest.approx(largest, rel=1e-9)


class Asked(pp.PinpressError):
    """In place of balancing."""


def asked(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> dict[str, Any]:
    """What the command hands over to `balance`."""
    taken: dict[str, Any] = {}

    def spy(press: pp.Linkage, cases: Any, regions: Any, minimise: Any, limits: Any) -> None:
        taken.update(regions=regions, minimise=minimise, limits=limits)
        raise Asked("taken")

    monkeypatch.setattr(command_balance, "balance", spy)
    assert main(["balance", "crank_slide", "--speed", "60", "--points", "8", *arguments]) == 2
    return taken


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("words", "region"),
    [
        ("crank:at=-0.1428/0/0", pp.balancing.CounterweightRegion("crank", at=(-0.1428, 0.0, 0.0))),
        ("crank:at=0/0/0,mass=-20/0", pp.balancing.CounterweightRegion("crank", (-20.0, 0.0), at=(0.0, 0.0, 0.0))),
        (
            "crank:radius=0.3,centre=0.1/0/-0.2,mass=5/inf",
            pp.balancing.CounterweightRegion("crank", (5.0, math.inf), radius=0.3, centre=(0.1, 0.0, -0.2)),
        ),
        (
            "rod:corner=0/0/0,corner=1/0/0,gyration=0.1",
            pp.balancing.CounterweightRegion("rod", corners=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), gyration=0.1),
        ),
        ("auxiliary_rod:replaces", pp.balancing.CounterweightRegion("auxiliary_rod", replaces=True)),
        ("rod:radius=0.3,mass=0/200,replaces", pp.balancing.CounterweightRegion("rod", (0.0, 200.0), radius=0.3, replaces=True)),
        ("left:rod:at=1/2/3", pp.balancing.CounterweightRegion("left:rod", at=(1.0, 2.0, 3.0))),
    ],
)
def test_regions(monkeypatch: pytest.MonkeyPatch, words: str, region: pp.balancing.CounterweightRegion) -> None:
    assert asked(monkeypatch, "--region", words, "--minimise", "added_mass")["regions"] == [region]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("words", "minimise"),
    [
        (["range:shaking_force:z"], Z),
        (["rms:driving_torque"], pp.balancing.Rms("driving_torque")),
        (["peak:shaking_force"], pp.balancing.Peak("shaking_force")),
        (["peak:bearing_force:A"], pp.balancing.Peak("bearing_force", bearing="A")),
        (["range:bearing_moment:slide_guide:y"], pp.balancing.Range("bearing_moment", "y", "slide_guide")),
        (["peak:bearing_force:left:A"], pp.balancing.Peak("bearing_force", bearing="left:A")),
        (["added_mass"], pp.balancing.AddedMass()),
        (["range:shaking_force:z=2"], {Z: 2.0}),
        (["range:shaking_force:z", "added_mass=0.5"], {Z: 1.0, pp.balancing.AddedMass(): 0.5}),
    ],
)
def test_objectives(monkeypatch: pytest.MonkeyPatch, words: list[str], minimise: Any) -> None:
    options = [option for word in words for option in ("--minimise", word)]
    assert asked(monkeypatch, "--region", "crank:radius=0.1", *options)["minimise"] == minimise


def test_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    words = ["--limit", "range:shaking_force:x=1kN", "--limit", "peak:bearing_force:A:z=0", "--limit", "added_mass=661"]
    expected = {X: 1000.0, pp.balancing.Peak("bearing_force", "z", "A"): 0.0, pp.balancing.AddedMass(): 661.0}
    assert asked(monkeypatch, "--region", "crank:radius=0.1", "--minimise", "added_mass", *words)["limits"] == expected


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--region", "crank"], ["--region crank: it names no link and place", "LINK:radius=R", "--region crank:radius=0.3"]),
        (["--region", ":radius=1"], ["it names no link and place"]),
        (["--region", "crank:"], ["no key ''"]),
        (["--region", "crank:raduis=1"], ["no key 'raduis', did you mean 'radius'?"]),
        (["--region", "crank:radius"], ["radius is '', no number"]),
        (["--region", "crank:radius=0,3"], ["no key '3'"]),
        (["--region", "crank:radius=nan"], ["--region crank:radius=nan: region on 'crank': radius is nan: give a length"]),
        (["--region", "crank:at=1/2"], ["at is '1/2', not x, y, z as 0.1/0/-0.2"]),
        (["--region", "crank:at=1/2/high"], ["at is '1/2/high', not x, y, z"]),
        (["--region", "crank:radius=1,radius=2"], ["radius is given twice"]),
        (["--region", "crank:replaces=yes"], ["replaces is 'yes', but takes no value"]),
        (["--region", "crank:mass=0/5"], ["its place is missing: give at, radius or corners"]),
        (["--region", "crank:radius=1,mass=-5/5kg"], ["only a hole at a point"]),
        (["--region", "crank:radius=1,mass=200"], ["mass is '200', not the least and the most, as 0/200 or 5/inf"]),
        (["--region", "crank:radius=1,mass=2/1"], ["mass is (2.0, 1.0): give least and largest mass"]),
        (["--region", "crank:radius=1,most=5"], ["no key 'most'", "[,mass=LEAST/MOST]", "crank:radius=0.3,mass=0/200"]),
        (["--region", "cranck:radius=1"], ["no link 'cranck', did you mean 'crank'?"]),
        (["--region", "frame:at=0/0/0"], ["'frame' does not move"]),
        (["--minimise", "shaking"], ["--minimise shaking: no criterion 'shaking'", "there are: range, rms, peak, added_mass", "[=WEIGHT]"]),
        (["--minimise", "rnage:shaking_force:z"], ["did you mean 'range'?", "--minimise range:shaking_force:z"]),
        (["--minimise", "range:shaking:z"], ["no quantity 'shaking', did you mean 'shaking_", "driving_torque"]),
        (["--minimise", "range:shaking_force:up"], ["no axis 'up'; there are: x, y, z"]),
        (["--minimise", "range:shaking_force"], ["a vector has no range: give an axis"]),
        (["--minimise", "rms:driving_torque:z"], ["the driving torque has no axis"]),
        (["--minimise", "peak:bearing_force"], ["it names no bearing", "QUANTITY[:BEARING][:AXIS]"]),
        (["--minimise", "peak:bearing_force:Q"], ["no bearing 'Q'"]),
        (["--minimise", "added_mass=much"], ["'much' is no number"]),
        (["--minimise", "added_mass=-1"], ["the weight of the added mass is -1.0"]),
        (["--minimise", "range:shaking_force:z"], ["--minimise range:shaking_force:z: the range of the shaking force, z is given twice"]),
        (["--limit", "added_mass"], ["--limit added_mass: it has no number", "with =MOST", "--limit peak:bearing_force:A=1e5"]),
        (["--limit", "added_mass="], ["'' is no number"]),
        (["--limit", "added_mass=nan"], ["the limit of the added mass is nan"]),
        (["--limit", "mass=5"], ["no criterion 'mass'; there are: range, rms, peak, added_mass"]),
        (
            ["--limit", "range:shaking_force:z=1"],
            ["no counterweights in these regions keep the limit of the range of the shaking force, z, 1 N"],
        ),
        (["--load", "sawing:force=1"], ["no kind 'sawing'"]),
        (["--speed", "0"], ["speed is 0"]),
        (["--points", "1"], ["points is 1"]),
        (["--driver", "Q"], ["no moving joint 'Q'"]),
        (["--report"], ["--report needs a folder to write into: also give --out DIR"]),
        (["--out", "README.md"], ["README.md"]),
    ],
)
def test_errors_name_the_part_and_the_form(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, arguments: list[str], says: list[str]
) -> None:
    monkeypatch.chdir(ROOT)
    usual = ["--speed", "60", "--points", "24", "--region", "crank:radius=0.1", "--minimise", "range:shaking_force:z"]
    error = refused(capsys, "crank_slide", *usual, *arguments)
    for words in says:
        assert words in error


@pytest.mark.parametrize("left_out", ["--speed", "--region", "--minimise"])
def test_usage_errors_exit_with_2(capsys: pytest.CaptureFixture[str], left_out: str) -> None:
    words = {"--speed": "60", "--region": "crank:radius=0.1", "--minimise": "added_mass"}
    with pytest.raises(SystemExit) as stop:
        main(["balance", "crank_slide", *(part for option, word in words.items() if option != left_out for part in (option, word))])
    assert stop.value.code == 2
    says = "one of the arguments --speed --motion is required" if left_out == "--speed" else f"required: {left_out}"
    assert says in capsys.readouterr().err


def test_help_lists_every_word(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["balance", "--help"])
    assert stop.value.code == 0
    text = capsys.readouterr().out
    for word in (
        *command_balance.KEYS,
        *command_balance.KINDS,
        *problem.QUANTITIES,
        *LOADS,
        "added_mass",
        "r/min",
        "balanced.urdf",
        "report.html",
    ):
        assert word in text


def test_the_example_of_the_help_runs(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    example = command_balance.EPILOG.partition("e.g. pinpress balance ")[2].split()
    printed(capsys, *example)
    assert (tmp_path / "out" / "report.html").exists()
