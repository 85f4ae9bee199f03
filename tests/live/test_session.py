"""What a window is answered: the mechanics' own numbers, reasons where lengths make no press, files beside the press's own."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support import texts
from support.in_browser import floats

import pinpress as pp
from pinpress.common import files
from pinpress.common.reading import entries
from pinpress.live.pictures import Operation
from pinpress.live.session import LONGEST, Opened, RefusedMessageError, Session
from pinpress.live.sources import LinkageSource, opened

SPEED = 70 * pp.RPM
TEMPLATES = Path(pp.__file__).parent / "pin_table" / "templates"
KNUCKLE = TEMPLATES / "knuckle.yaml"


def session_of(source: Any, speed: float = SPEED, loads: Any = ()) -> Session:
    found = Session(lambda: Opened(source(), Operation(speed, loads, {}, {})))
    found.open()
    return found


def of_press(name: str, **more: Any) -> Session:
    return session_of(lambda: LinkageSource.of(texts.shipped(name)), **more)


def of_table(path: Path, **parameters: str) -> Session:
    return session_of(lambda: opened(str(path), pp.load, parameters), speed=0.5)


def values(session: Session, **changed: float) -> list[float]:
    """Of all dimensions as they are, some of them changed by their names (blanks and commas as underscores)."""
    whole = session.whole()
    names = [each["name"].replace(" ", "_").replace(",", "") for each in whole["dimensions"]]
    found = list(whole["values"])
    for name, value in changed.items():
        found[names.index(name)] = value
    return found


def ask(session: Session, kind: str, **more: Any) -> Any:
    return session.answer(json.dumps({"type": kind, **more}))


def change(session: Session, speed: float = 70.0, **changed: float) -> Any:
    return ask(session, "set", values=values(session, **changed), speed=speed, shapes=False)


def test_a_window_keeps_the_slide_that_is_named(tmp_path: Path) -> None:
    """That of a table with two slides, also when a slider has changed it."""
    file = tmp_path / "press.yaml"
    text = (TEMPLATES / "crank-slide.yaml").read_text(encoding="utf-8").replace("slide:", "ram:")
    text = text.replace("links:", "  V: {P: 450, x: 0, side: down}\nlinks:")
    more = "  arm: {pins: P V, mass: 9}\n  holder: {pins: V, guide: up, mass: 40}\ndrive:"
    file.write_text(text.replace("drive:", more), encoding="utf-8")
    source = opened(str(file), pp.load, {}, "holder")
    changed = source.changed([1.01 * each.value for each in source.dimensions])
    assert (source.press.slide, changed.slide) == ("holder", "holder")
    assert opened(str(file), pp.load, {}).press.slide is None


def test_a_picture_has_the_numbers_of_the_mechanics() -> None:
    load = pp.loads.DeepDrawing(force=1e6, start=0.040)
    session = of_press("zxn2_3000b", loads=[load])
    message = change(session, speed=50.0, A_to_B=150.0, D_x=10.0).everyone
    press = pp.derivatives.reshaped(texts.shipped("zxn2_3000b"), {("B", "crank"): (0.150, 0, 0), ("D", "frame"): (0.010, 0.0, 0.0)})
    motion = pp.cycle(press, speed=50 * pp.RPM, points=180)
    reactions = pp.inverse_dynamics(press, motion, [load])
    again = np.append(np.arange(180), 0)
    slide, torque, force = message["curves"]
    forces = np.array([np.linalg.norm(each, axis=1) for each in reactions.bearing_force.values()])
    height = motion.slide_position - pp.dead_centres(press).bottom_position
    assert_allclose(floats(torque["values"]), reactions.driving_torque[again], rtol=0, atol=1e-6 * np.abs(reactions.driving_torque).max())
    assert_allclose(floats(force["values"]), forces.max(axis=0)[again], rtol=1e-6)
    assert_allclose(floats(slide["values"]), height[again], rtol=0, atol=1e-7)
    assert force["at"][:180] == [press.bearings[k] for k in forces.argmax(axis=0)]
    for bearing in message["bearings"]:
        its = reactions.bearing_force[bearing["name"]]
        assert_allclose(floats(bearing["force"], 3)[:-1], its, rtol=0, atol=1e-6 * np.abs(its).max())
    assert message["crank"][-1] == 360
    assert message["speed"] == 50


def test_lengths_that_make_no_press_are_refused_and_the_last_good_one_stays() -> None:
    session = of_press("crank_slide")
    good = change(session, O_to_P=110.0).everyone
    for crank, said in ((401.0, "crank angle"), (1e12, "too large")):  # the rod is 400 mm long
        answer = change(session, O_to_P=crank)
        assert answer.everyone is None
        assert answer.sender["type"] == "refused"
        assert said in answer.sender["text"]
        assert session.whole()["values"] == good["values"]
    assert change(session, O_to_P=120.0).everyone["values"][0] == 120.0


def test_it_is_the_same_press_by_whatever_way_it_is_reached() -> None:
    """The branch is followed from the press that was shown before."""
    there, straight = of_press("zxn2_3000b"), of_press("zxn2_3000b")
    for crank in (150.0, 120.0, 160.0, 140.0):
        last = change(there, A_to_B=crank)
    curve = change(straight, A_to_B=140.0).everyone["curves"][1]
    assert_allclose(floats(last.everyone["curves"][1]["values"]), floats(curve["values"]), rtol=1e-6, atol=1e-2)


@pytest.mark.parametrize("name", ["jf75g_125_symmetric", "jf75g_125_two_point"])
def test_halves_change_together(name: str) -> None:
    """One of the rods of a symmetric press alone could not change: the loops would not close."""
    session = of_press(name, speed=10.0)
    (rods,) = [each["name"] for each in session.whole()["dimensions"] if each["group"].startswith("main_rod")]
    answer = change(session, **{rods.replace(" ", "_"): 301.0})
    assert answer.sender is None
    assert any("main_rod" in each["group"] and " and " in each["group"] for each in session.whole()["dimensions"])


def test_notes_come_with_a_picture_and_not_as_warnings() -> None:
    session = of_press("crank_slide")
    assert change(session, speed=70.0).everyone["notes"] == []
    assert change(session, speed=120000.0).everyone["notes"] != []


def test_a_driver_that_slides() -> None:
    session = session_of(lambda: opened(str(TEMPLATES / "toggle.yaml"), pp.load, {}), speed=0.1)
    whole = session.whole()
    assert whole["speed_unit"] == "mm/s"
    assert whole["curves"][1]["name"] == "driving force"
    assert change(session, speed=100.0, U_x=1.0).everyone["values"] != whole["values"]


# ----------------------------------------------------------------------------------------------------------------------------- messages


def good(**other: Any) -> str:
    return json.dumps({"type": "set", "values": [0.0] * 7, "speed": 60.0, "shapes": False} | other)


@pytest.mark.parametrize(
    "text",
    [
        *("", "[]", "null", '"set"', "{}", b"\x00\x01", '{"type": "eval", "code": "1"}', '{"type": ["set"]}'),
        *('{"type": "save", "name": "x.urdf"}', '{"type": "ready", "version": 1, "more": 2}', good(shapes=1), good(extra=1)),
        *(good().replace("60.0", "NaN"), good().replace("60.0", "-Infinity"), "[" * 10000, good() + " " * LONGEST),
    ],
    ids=lambda text: str(text)[:40],
)
def test_messages_that_no_window_sends_are_refused(text: Any, shared: Session) -> None:
    with pytest.raises(RefusedMessageError):
        shared.answer(text)


@pytest.mark.parametrize(
    "other",
    [*({"values": values} for values in ([], [True] * 7, ["1"] * 7, [1e999] * 7, [10**400] * 7, None)), {"speed": "60"}, {"speed": 0}],
    ids=lambda other: str(other)[:40],
)
def test_values_that_are_no_numbers_are_refused(other: dict[str, Any], shared: Session) -> None:
    answer = shared.answer(good(**other).replace("Infinity", "1e999"))
    assert answer.everyone is None
    assert answer.sender["type"] == "refused"


@pytest.fixture(scope="module")
def shared() -> Session:
    """One for tests that change nothing."""
    return of_press("crank_slide")


# -------------------------------------------------------------------------------------------------------------------------------- files


def test_a_table_is_written_with_its_comments(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    shutil.copy(KNUCKLE, path)
    session = of_table(path)
    assert session.whole()["suggested"] == "own_changed.yaml"
    notes = {each["name"]: each["note"] for each in session.whole()["dimensions"]}
    assert notes["r"] == "crank radius"
    change(session, speed=5.0, r=95.5, O_x=740.0)
    assert ask(session, "save", name="other.yaml", replace=False).sender == {"type": "saved", "text": str(tmp_path / "other.yaml")}
    before, after = path.read_text().splitlines(), (tmp_path / "other.yaml").read_text().splitlines()
    assert [(old, new) for old, new in zip(before, after, strict=True) if old != new] == [
        ("  r: 90                       # crank radius", "  r: 95.5                       # crank radius"),
        ("  O: [750, -250]", "  O: [740, -250]"),
    ]
    shown = session.whole()["curves"][0]
    motion = pp.cycle(pp.build(tmp_path / "other.yaml"), 5 * pp.RPM, points=180)
    assert_allclose(np.ptp(floats(shown["values"])), np.ptp(motion.slide_position), rtol=1e-3)


def test_a_urdf_is_written_that_loads_to_the_press_shown(tmp_path: Path) -> None:
    path = tmp_path / "own.urdf"
    path.write_bytes(texts.shipped("zxn2_3000b").text)
    session = session_of(lambda: opened(str(path), pp.load, {}))
    change(session, A_to_B=150.0)
    assert ask(session, "save", name="changed.urdf", replace=False).sender["type"] == "saved"
    wanted = pp.derivatives.reshaped(texts.shipped("zxn2_3000b"), {("B", "crank"): (0.150, 0, 0)})
    motions = [pp.cycle(press, SPEED, points=24) for press in (pp.load(tmp_path / "changed.urdf"), wanted)]
    assert_allclose(*(motion.slide_position for motion in motions), rtol=0, atol=1e-12)


def test_nothing_is_replaced_unasked(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    shutil.copy(KNUCKLE, path)
    session, text = of_table(path), path.read_text()
    change(session, speed=5.0, r=95.0)
    assert ask(session, "save", name="own.yaml", replace=False).sender["type"] == "exists"
    assert path.read_text() == text
    assert ask(session, "save", name="own.yaml", replace=True).sender["type"] == "saved"
    assert "r: 95 " in path.read_text()


NAMES = ["../x.yaml", "/tmp/x.yaml", "a/b.yaml", "a\\b.yaml", ".x.yaml", "x.urdf", "x", "", "x\0.yaml", "C:x.yaml", "x\n.yaml", 5, None]
NAMES += ["x" * 300 + ".yaml", "\u538b" * 100 + ".yaml"]  # the last has 300 bytes


def test_files_are_written_beside_the_own_one_alone(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    path = tmp_path / "in" / "own.yaml"
    shutil.copy(KNUCKLE, path)
    session = of_table(path)
    for name in NAMES:
        assert ask(session, "save", name=name, replace=True).sender["type"] == "unsaved", name
    assert [each.name for each in tmp_path.rglob("*") if each.is_file()] == ["own.yaml"]


def test_parameters_given_are_where_the_sliders_begin(tmp_path: Path) -> None:
    session = of_table(KNUCKLE, r="95")
    assert session.whole()["values"][0] == 95
    assert change(session, speed=5.0, r=90.0).everyone is not None


def test_a_save_under_way_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the file is there once the table was read: the window has the press of the text that was read, and its numbers."""
    path = tmp_path / "own.yaml"
    shutil.copy(KNUCKLE, path)
    session = of_table(path)
    text = path.read_text()

    def read_before_the_save(file: str, most: int) -> bytes:
        content = files.read(file, most)
        path.write_text(text[: text.index("links:") - 3] + "{")
        return content

    monkeypatch.setattr(entries, "read", read_before_the_save)
    path.write_text(text.replace("r: 90", "r: 80"))
    session.open()
    assert session.whole()["broken"] is None
    assert session.whole()["values"][0] == 80


def test_a_file_that_is_mended_is_shown_and_a_wrong_one_is_not(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    shutil.copy(KNUCKLE, path)
    session = of_table(path)
    text = path.read_text()
    path.write_text(text.replace("drive: O", "drive: Q"))
    with pytest.raises(pp.PinTableError, match="Q"):
        session.open()
    assert "Q" in session.whole()["broken"]
    path.write_text(text.replace("r: 90", "r: 80"))
    session.open()
    assert session.whole()["broken"] is None
    assert session.whole()["values"][0] == 80


def test_paths_of_points_follow_the_lengths():
    """A coupler point of a press that is changed."""

    def opening() -> Opened:
        return Opened(LinkageSource.of(texts.shipped("crank_slide")), Operation(SPEED, (), {}, {}, traces=[("rod", (0.1, 0.0, 0.05))]))

    session = Session(opening)
    session.open()
    before = session.whole()["traces"]
    assert [each["name"] for each in before] == ["slide", "rod (0.1, 0, 0.05)"]
    names = [each["name"] for each in session.whole()["dimensions"]]
    longer = list(session.whole()["values"])
    longer[next(k for k, name in enumerate(names) if "P" in name and "W" in name)] *= 1.1
    assert ask(session, "set", values=longer, speed=70.0, shapes=False).everyone["traces"][1]["path"] != before[1]["path"]
