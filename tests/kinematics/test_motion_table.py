"""`read_motion`: motions of one driver and of several from tables, beside geared presses, which move as their motors do together."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import texts
from support.generators.period_presses import five_bar, of_two_motors
from support.generators.small_linkages import hybrid

import pinpress as pp

RATIO, SPEED = 0.5, 3.0


def table(path: Path, heads: str, *columns: Any, separator: str = ",") -> Path:
    rows = [separator.join(f"{value:.17g}" for value in row) for row in zip(*columns, strict=True)]
    rows = [row.replace(".", ",") for row in rows] if separator == ";" else rows
    path.write_text("\n".join([heads.replace(",", separator), *rows]) + "\n", encoding="utf-8")
    return path


def test_two_motors_move_and_drive_as_gears_do(tmp_path: Path) -> None:
    """The geared five-bar is computed in the plane, from one driver; power tells what its one motor takes."""
    geared, press = five_bar(RATIO), of_two_motors()
    turn = pp.cycle(geared, SPEED, points=144)
    want = pp.inverse_dynamics(geared, turn)
    angle = np.degrees(turn.crank_angle)
    motion = pp.read_motion(press, table(tmp_path / "m.csv", "time [s],O [deg],P [deg]", turn.time, angle, RATIO * angle))
    np.testing.assert_allclose(motion.slide_position, turn.slide_position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.crank_speed, np.outer(np.ones(144), [SPEED, RATIO * SPEED]), rtol=1e-9)
    result = pp.inverse_dynamics(press, motion)
    largest = np.abs(want.driving_torque).max()
    # the derived accelerations are zero but for rounding of the table, which counts by the square of the step
    np.testing.assert_allclose(result.driving_torque @ [1.0, RATIO], want.driving_torque, rtol=0, atol=1e-7 * largest)
    for name, force in want.bearing_force.items():
        np.testing.assert_allclose(result.bearing_force[name], force, rtol=0, atol=1e-7 * np.abs(want.bearing_force["S"]).max())


def test_a_motion_that_was_written_is_read_as_it_was(tmp_path: Path) -> None:
    press = of_two_motors()
    time = np.linspace(0.0, 1.0, 60, endpoint=False)
    swing = np.sin(2 * np.pi * time)
    motion = pp.servo_cycle(press, np.column_stack([2 * np.pi * time, 0.3 * swing]), time=time, period=1.0)
    motion.to_csv(tmp_path / "motion.csv")
    motion.to_csv(tmp_path / "motion.csv.gz")
    assert (tmp_path / "motion.csv.gz").read_bytes()[:2] == b"\x1f\x8b"  # gzip's own mark
    pp.inverse_dynamics(press, motion).to_csv(tmp_path / "cycle.csv")
    for name in ("motion.csv", "motion.csv.gz", "cycle.csv"):
        again = pp.read_motion(press, tmp_path / name)
        for each in ("crank_angle", "crank_speed", "crank_acceleration", "time"):
            np.testing.assert_array_equal(getattr(again, each), getattr(motion, each))


def test_drivers_that_turn_and_slide_with_decimal_commas(tmp_path: Path) -> None:
    press = hybrid()
    time = np.linspace(0.0, 1.0, 72, endpoint=False)
    crank, ram = 2 * np.pi * time, 0.04 * np.sin(2 * np.pi * time)
    want = pp.servo_cycle(press, np.column_stack([crank, ram]), time=time, period=1.0)
    heads = "t [ms],note [-],ram_guide [mm],A [rad]"
    found = pp.read_motion(press, table(tmp_path / "m.csv", heads, 1e3 * time, time, 1e3 * ram, crank, separator=";"), period=1.0)
    np.testing.assert_allclose(found.crank_angle, want.crank_angle, rtol=0, atol=1e-14)
    # in ms the steps are equal but for rounding, so that a quintic spline takes the place of the trigonometric polynomial
    np.testing.assert_allclose(found.crank_acceleration, want.crank_acceleration, rtol=0, atol=1e-6)
    assert str(found).startswith("Motion of press: 72 states, A at 0 to 355 deg, ram_guide at -40 to 40 mm, slide at ")
    result = pp.inverse_dynamics(press, found)
    assert ", driving torque of A " in result.title
    assert ", driving force of ram_guide " in result.title
    assert result.title.count(" N m") == 1


@pytest.mark.parametrize("head", ["A [deg]", "angle [deg]", "angle [°]", "crank_angle [rad]"])
def test_one_driver(head: str, tmp_path: Path) -> None:
    press = texts.shipped("zxn2_3000b")
    time = np.linspace(0.0, 1.0, 91)
    angle = 2 * np.pi * time - np.sin(2 * np.pi * time)
    shown = angle if "rad" in head else np.degrees(angle)
    found = pp.read_motion(press, table(tmp_path / "m.csv", f"time [s],{head}", time, shown), period=1.0)
    want = pp.servo_cycle(press, angle, time=time, period=1.0)
    np.testing.assert_allclose(found.slide_acceleration, want.slide_acceleration, rtol=0, atol=1e-9)
