"""Presses with several drivers in the window: one moves, the others stand, and the forces are those of the whole press."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.in_browser import floats
from support.presses.two_servos import TWO_SERVOS

import pinpress as pp
from pinpress.cli.main import main
from pinpress.live.drivers import CLEAR, swing, swings, with_moving
from pinpress.live.pictures import Operation
from pinpress.live.session import Opened, RefusedMessageError, Session
from pinpress.live.sources import opened


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("live") / "two_servos.yaml"
    found.write_text(TWO_SERVOS)
    return found


@pytest.fixture
def session(path: Path) -> Session:
    found = Session(lambda: Opened(opened(str(path), pp.load, {}), Operation(2.0, [], {}, {})))
    found.open()
    return found


@pytest.mark.parametrize(("driver", "positions"), [("A", (0.0, -0.7)), ("B", (0.4, 0.0))])
def test_forces_are_those_of_the_whole_press(path: Path, driver: str, positions: tuple[float, float]) -> None:
    """The whole press is computed in space, by its own motion of two drivers."""
    press = pp.build(path)
    one = with_moving(press, driver, positions)
    assert one.engines[0] == "plane"
    moving = pp.cycle(one, 3.0, points=12)
    reactions = pp.inverse_dynamics(one, moving)
    k = press.drivers.index(driver)
    angle, speed = np.tile(positions, (12, 1)), np.zeros((12, 2))
    angle[:, k], speed[:, k] = moving.crank_angle, moving.crank_speed
    wanted = pp.inverse_dynamics(press, pp.servo_cycle(press, angle, speed=speed, acceleration=0 * speed))
    largest = np.abs(wanted.driving_torque).max()
    assert_allclose(reactions.driving_torque, wanted.driving_torque[:, k], rtol=0, atol=1e-9 * largest)
    (held,) = set(press.drivers) - {driver}
    assert_allclose(reactions.coupling_torque[held][:, 0], wanted.driving_torque[:, 1 - k], rtol=0, atol=1e-9 * largest)
    for bearing, force in wanted.bearing_force.items():
        assert_allclose(reactions.bearing_force[bearing], force, rtol=0, atol=1e-8 * np.abs(force).max())


RACK = """
press: rack
units: mm
frame: O
pins: {O: [0, 0], Q: [30, 0]}
links:
  pinion: {pins: O, mass: 2, disc: 30 x 40}
  slide: {pins: Q, guide: up, mass: 8}
gears: {slide_guide: 0.03 * O}
drive: O
"""


def test_a_rack_is_built_and_swings(tmp_path: Path) -> None:
    """It is not back after a turn of its pinion, so that nothing may show it turning on and on."""
    file = tmp_path / "rack.yaml"
    file.write_text(RACK)
    press = pp.build(file)
    assert press.turns_until_back is None
    assert swings(press)
    session = Session(lambda: Opened(opened(str(file), pp.load, {}), Operation(2.0, [], {}, {})))
    session.open()
    motion = swing(press, 2.0, 48)
    assert motion.period_turns is None
    assert_allclose(motion.slide_position - motion.slide_position[0], 0.03 * (motion.crank_angle - motion.crank_angle[0]), atol=1e-12)
    assert motion.crank_angle.argmax() == 24
    assert main(["build", str(file), "--out", str(tmp_path / "rack.urdf")]) == 0
    assert pp.load(tmp_path / "rack.urdf").turns_until_back is None


def test_a_crank_that_locks_swings(path: Path) -> None:
    press = with_moving(pp.build(path), "A", (0.0, 0.0))
    long = pp.derivatives.reshaped(press, {("P", "crank_1"): 3.5 * pp.derivatives.pivot_positions(press)["P", "crank_1"]})
    low, high = long.branch.angles[[0, -1]]
    motion = swing(long, -2.0, 24)
    assert_allclose([motion.crank_angle.min(), motion.crank_angle.max()], [low + CLEAR * (high - low), high - CLEAR * (high - low)])
    assert_allclose(motion.crank_speed[np.abs(motion.crank_speed).argmax()], -2.0)
    half = np.ptp(motion.crank_angle) / 2
    assert_allclose(motion.time[12], np.pi * half / 2.0)
    assert motion.period_turns is None


def ask(session: Session, kind: str, **more: Any) -> Any:
    return session.answer(json.dumps({"type": kind, **more}))


def test_another_driver_moves(session: Session, path: Path) -> None:
    whole = session.whole()
    assert (whole["drivers"], whole["moving"]) == (("A", "B"), "A")
    assert [each["name"] for each in whole["dimensions"][:2]] == ["A", "B"]
    assert [each["name"] for each in whole["curves"]][1:3] == ["driving torque of A", "torque that holds B"]
    assert whole["driver"]["name"] == "A"
    values = [*whole["values"]]
    values[0] = 20.0
    assert ask(session, "set", values=values, speed=30.0, shapes=False).everyone["curves"] != whole["curves"]
    moved = ask(session, "move", driver="B").everyone
    assert (moved["moving"], moved["values"], moved["speed"]) == ("B", values, 30.0)
    press = with_moving(pp.build(path), "B", (np.radians(20.0), 0.0))
    torque = pp.inverse_dynamics(press, pp.cycle(press, 30 * pp.RPM, points=180)).driving_torque
    shown = floats(moved["curves"][1]["values"])
    assert_allclose(shown[:-1], torque, rtol=0, atol=1e-6 * np.abs(torque).max())
    assert ask(session, "save", name="changed.yaml", replace=True).sender["type"] == "saved"
    assert (path.parent / "changed.yaml").read_text() == TWO_SERVOS  # where drivers stand is no length
    session.open()
    assert session.whole()["moving"] == "B"


def test_what_is_no_driver_is_refused(session: Session) -> None:
    for driver in ("C", "", None, 1, ["A"]):
        with pytest.raises(RefusedMessageError, match="no driver"):
            ask(session, "move", driver=driver)


@pytest.mark.exhaustive
def test_where_a_driver_cannot_stand_is_said(tmp_path: Path) -> None:
    """The couplers are nearly straight as drawn: crank A swings, and with crank B turned outwards they are too short."""
    path = tmp_path / "short.yaml"
    path.write_text(TWO_SERVOS.replace("620", "415"))
    session = Session(lambda: Opened(opened(str(path), pp.load, {}), Operation(2.0, [], {}, {})))
    session.open()
    values = [*session.whole()["values"]]
    values[1] = -20.0
    assert ask(session, "set", values=values, speed=30.0, shapes=False).sender is None
    good = list(values)
    values[1] = 20.0
    assert "two_servos locks on the way from" in ask(session, "set", values=values, speed=30.0, shapes=False).sender["text"]
    assert session.whole()["values"] == good


def test_speeds_are_those_of_the_kind_of_driver(tmp_path: Path) -> None:
    """A crank and a cylinder: each begins at a speed of its kind, the crank at that which was given."""
    path = tmp_path / "mixed.yaml"
    cylinder = "barrel: {pins: B, mass: 60}\n  piston: {pins: K, guide: {cylinder: barrel B K}, travel: [-100, 100], mass: 40}"
    table = TWO_SERVOS.replace("crank_2: {pins: B Q, section: 120 x 80}", cylinder).replace("  D: C", "  D: C\n  K: C")
    table = re.sub(r"  (Q|coupler_2): .*\n", "", table).replace("{P: 620, Q: 620, side: down}", "[0, -500]")
    path.write_text(table.replace("pins: P C,", "pins: P C D K,").replace("[A, B]", "[A, cylinder]"))
    session = Session(lambda: Opened(opened(str(path), pp.load, {}), Operation(2.0, [], {}, {})))
    session.open()
    cylinder_moves = ask(session, "move", driver="cylinder").everyone
    assert (cylinder_moves["speed"], cylinder_moves["speed_unit"]) == (100.0, "mm/s")
    assert [each["name"] for each in cylinder_moves["curves"][1:3]] == ["driving force of cylinder", "torque that holds A"]
    assert_allclose([cylinder_moves["dimensions"][1][end] for end in ("low", "high")], [-100.0, 100.0])
    crank_moves = ask(session, "move", driver="A").everyone
    assert crank_moves["speed"] == pytest.approx(2.0 / pp.RPM)
    assert crank_moves["curves"][2]["name"] == "force that holds cylinder"
