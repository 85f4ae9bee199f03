"""Jobs with one mistake: each is refused in one line with its place and what to write; `check` lists several at once; editors mark them."""

import re
import warnings
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from support.exploring import examples

import pinpress as pp
from pinpress.cli.main import main
from pinpress.jobs.schema import schema

PRESS = Path(__file__).with_name("press_job.yaml")
TEXT = PRESS.read_text(encoding="utf-8")
SCHEMA = jsonschema.Draft7Validator(schema())
ROBOT = "file: zxn2_3000b\nspeed: 70 r/min\n"

# what is replaced in the file, by what, what the message says; True where only `check` can know it, as it takes the press or another entry
WRONG: list[tuple[str, str, str, bool]] = [
    ("force: 1500 kN", "force: 1500", "loads: draw: force: 1500 has no unit; write 1500 kN or 1500 N, whichever it is", False),
    (
        "force: 1500 kN",
        "force: 1500 t",
        "loads: draw: force: '1500 t' is in 't', which is none of N, kN, MN, tf, did you mean 'tf'?; write e.g. 1500 kN",
        False,
    ),
    ("speed: 70 r/min", "speed: 70", "speed: 70 has no unit; write 70 r/min or 70 rad/s, whichever it is", False),
    ("start: 40 mm", "start: 40,5 mm", "loads: draw: '5 mm' is no key here; write decimals after a point: start: 40.5 mm", False),
    ("kind: drawing", "kind: deepdrawing", "loads: draw: kind: no kind 'deepdrawing', did you mean 'drawing'?; write one of idle", False),
    ("kind: drawing, ", "", "loads: draw: kind is missing; write one of idle, constant-force", False),
    ("force: 1500 kN", "froce: 1500 kN", "loads: draw: 'froce' is no key here, did you mean 'force'?; write some of force, start", False),
    ("force: 1500 kN, ", "", "loads: draw: force is missing; write e.g. {kind: drawing, force: 500 kN, start: 50 mm}", False),
    ("  A: {diameter", "  AA: {diameter", "bearings: AA: no bearing AA, did you mean 'A'?; name one of A,", True),
    ("diameter: 200 mm, ", "", "friction of B, D, E, C, F, which turn, without a radius; add diameter: 120 mm", True),
    ("frame: A D", "frame: {pins: A D}", "frame: keys with values; the pins fixed in the frame stand here, frame: A D", False),
    ("flywheel: 6000 kg m2\n", "", "capacities: speed_drop without a flywheel; add flywheel: 6000 kg m2", True),
    ("flywheel: 6000 kg m2", "flywheel: 6000 kg", "flywheel: '6000 kg' is in 'kg', which is none of kg m2", True),
    ("closes: 350 deg", "closes: 350", "brake: closes: 350 has no unit; write 350 deg of the crank, or 350 s", False),
    ("rise: 50 ms", "rise: fast", "brake: rise: 'fast' is no number; write e.g. 1.5 ms", False),
    ("{torque: 60 kN m, closes", "{closes", "brake: torque is missing; write e.g. {torque: 40 kN m, closes: 350 deg}", False),
    ("efficiency: 0.95", "efficiency: 1.95", "motor: efficiency: 1.95; give a share", True),
    ("efficiency: 0.95", "efficiency: 0.95, poles: four", "motor: poles: 'four' is no whole number; write one, such as 12", False),
    ("ratio: 20.7, ", "", "motor: efficiency without a ratio", True),
    ("speed_drop: 15 %", "speed_drop: 15 mm", "capacities: speed_drop: '15 mm' is in 'mm', which is none of", False),
    ("nominal_height: 13 mm", "nominal_height: -13 mm", "capacities: nominal_height is -0.013", True),
    ("width: 160 mm", "width: 160 mm, preload: 5 kN", "bearings: all: preload is the force of a guide's gibs", True),
    ("zero: tdc", "zero: top", "zero: 'top' is not known here; write one of drawn, tdc, bdc", False),
    ("hard_steel:  {loads.draw.force", "hard_steel:  {loads.drw.force", "", True),  # a variant is read when it is asked for
    (
        "speed: 70 r/min",
        "speed: 70 r/min\nmotion: {file: m.csv}",
        "motion: speed and motion both say how the driver moves; leave out one",
        True,
    ),
    ("speed: 70 r/min", "spead: 70 r/min", "'spead' is no key here, did you mean 'speed'?; write some of", False),
    ("language: en", "language: xx", "report: language: 'xx' is not known here; write one of en, de, zh, ja", False),
    ("count: 2", "count: 2.5", "loads: balance: count: '2.5' is no whole number; write one, such as 12", False),
    ("volume: 300 l", "volume: 0 l", "loads: balance: volume: 0.0; give a finite number that is positive [m3]", True),
    ("drawing: 4711-03,", "logo: logo.bmp,", "report: logo: {folder}/logo.bmp, which cannot be read: No such file", True),
    ("revision: B,", "before: hard_stel,", "before: no variant or press 'hard_stel', did you mean 'hard_steel'?; name one of long", True),
    ("title: Press 3 for plant 7,", "title: Press 3: plant 7,", "there is a colon in a text; write the text in quotes", False),
    ("force: 1500 kN", "force: [1500 kN]", "loads: draw: force: a list; write a number, 1.5 kN", False),
    ("  draw:    {kind", "  draw: {kind: idle}\n  draw:    {kind", "loads: draw: draw stands there twice; remove one of them", False),
    ("frame: A D\n", "frame: A D\nfile: zxn2_3000b\n", "pins: the press is that of file; leave out one of them", True),
]


@pytest.mark.parametrize(("old", "new", "said", "_"), WRONG, ids=[f"{old} -> {new}"[:60] for old, new, *_ in WRONG])
def test_a_mistake_is_refused_in_one_line(old: str, new: str, said: str, _: bool, tmp_path: Path) -> None:
    assert TEXT.count(old) == 1
    file = tmp_path / "press.yaml"
    file.write_text(TEXT.replace(old, new))
    if not said:
        pp.job(file)
        return
    with pytest.raises(pp.PinpressError) as error:
        pp.job(file)
    assert said.replace("{folder}", str(tmp_path)) in str(error.value)
    assert str(error.value).startswith(f"{file}:")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("old", "new", "said", "only_check"), WRONG, ids=[f"{old} -> {new}"[:60] for old, new, *_ in WRONG])
def test_editors_mark_what_a_schema_can_know(old: str, new: str, said: str, only_check: bool) -> None:
    try:
        read = yaml.safe_load(TEXT.replace(old, new))
    except yaml.YAMLError:
        return  # which editors mark without a schema
    wrong = [each.message for each in SCHEMA.iter_errors(read)]
    assert bool(wrong) != only_check or "twice" in said, wrong


TOKENS = re.findall(r"[A-Za-z_]+|[-\d.]+|\s+|.", TEXT)


@examples(40)
@given(st.integers(0, 10_000), st.integers(0, 10_000), st.sampled_from(["drop", "swap", "twice"]))
def test_damaged_jobs_are_refused_or_read(tmp_path_factory: pytest.TempPathFactory, at: int, other: int, how: str) -> None:
    """A token left out, written twice or in place of another one: an error of ours, or a job with finite forces."""
    tokens, k = list(TOKENS), at % len(TOKENS)
    tokens[k] = {"drop": "", "swap": TOKENS[other % len(TOKENS)], "twice": 2 * tokens[k]}[how]
    file = tmp_path_factory.mktemp("jobs", numbered=True) / "press.yaml"
    file.write_text("".join(tokens))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)
        try:
            reactions = pp.job(file, points=24).reactions()
        except pp.PinpressError:
            return
    assert np.isfinite(reactions.driving_torque).all()


CALLS: list[tuple[str, dict, str]] = [
    (
        "name",
        {"set": ["loads.drw.force=1200kN"]},
        "--set loads.drw.force=1200kN: loads has no drw, did you mean 'draw'?; name one of draw, balance",
    ),
    ("unit", {"set": ["loads.draw.force=1200"]}, "--set loads.draw.force=1200: loads: draw: force: 1200 has no unit; write 1200 kN or"),
    ("no value", {"set": ["r"]}, "--set r: write a name and its value"),
    ("parameter", {"set": ["radius=150"]}, "--set radius=150: there is no 'radius'"),
    (
        "variant",
        {"variant": "long_strok"},
        "variants: no variant 'long_strok', did you mean 'long_stroke'?; there are long_stroke, hard_steel",
    ),
    ("section", {"clutch.torque": 60e3}, "clutch.torque: there is no clutch whose torque could change; write all of it, such as clutch: {"),
    ("bearing", {"bearings.AB.permissible": 2e6}, "bearings: AB: no bearing AB"),
    ("gravity", {"gravity": "-9.81 m/s2"}, "gravity: it counts downwards, and is negative; write gravity: 9.81 m/s2"),
    ("comma", {"loads.draw.force": "1,5 MN"}, "loads.draw.force: '1,5 MN' is no number; write decimals after a point"),
    (
        "mixed units",
        {"loads": {"push": {"kind": "point-force", "link": "slide", "force": ["5", "5 kN", "5 MN"]}}},
        "loads: push: force: numbers have different units, and some have none; write the unit at each number, or one behind the last",
    ),
    ("removed", {"clutch": None}, "there is no clutch to remove; leave it out"),
    ("object", {"speed": object()}, "speed: <object object at"),
]


@pytest.mark.parametrize(("_", "given", "said"), CALLS, ids=[name for name, *_ in CALLS])
def test_a_change_that_changes_nothing_is_refused(_: str, given: dict, said: str) -> None:
    with pytest.raises(pp.PinpressError, match=re.escape(said)):
        pp.job(PRESS, **given)


def test_names_of_links_are_those_of_the_press() -> None:
    said = r"loads: payload: link: no link 'left_forarm'.*; name one of frame, crank,"
    with pytest.raises(pp.PinpressError, match=said):
        pp.job(file="zxn2_3000b", loads={"payload": {"kind": "point-force", "link": "left_forarm", "force": [0, 0, -20.0]}})


def test_check_lists_all_that_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "press.yaml"
    file.write_text(TEXT.replace("force: 1500 kN", "force: 1500").replace("bore: 250 mm", "bore: 250").replace("zero: tdc", "points: many"))
    assert main(["check", str(file)]) == 1
    printed = capsys.readouterr().out
    for said in ("loads: draw: force: 1500 has no unit", "loads: balance: bore: 250 has no unit", "points: 'many' is no whole number"):
        assert said in printed


def test_the_job_passes_the_schema_and_a_bare_number_is_marked() -> None:
    assert not list(SCHEMA.iter_errors(yaml.safe_load(TEXT)))
    jsonschema.Draft7Validator.check_schema(schema())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pp.job(PRESS)
