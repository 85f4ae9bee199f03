"""Nothing has a size of its own: with lengths, masses and times in other units, every result is the same in those units.

Units are powers of two, so that numbers keep their digits: what differs by more than rounding is an absolute size in a formula.
"""

import re
from dataclasses import fields, replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from extremes.extreme_sizes import scaled
from support.generators import large_linkages

import pinpress as pp
from pinpress.common.parameters import declared
from pinpress.dynamics import applied_loads
from pinpress.engines.friction import REST

pytestmark = pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # that no press is as large, dense or fast

SIX = "zxn2_3000b"
SPEED = 70 * pp.RPM


class Units(NamedTuple):
    """How many of the new units one of the old ones is."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    def of(self, length=0, mass=0, time=0):
        return self.length**length * self.mass**mass * self.time**time


SI = Units()
UNITS = [Units(length=2.0**-7), Units(mass=2.0**9), Units(time=2.0**-5), Units(2.0**5, 2.0**-6, 2.0**3)]

FORCE, TORQUE, POWER, RATE = (1, 1, -2), (2, 1, -2), (2, 1, -3), (0, 0, -1)
LENGTH, TIME, PLAIN = (1, 0, 0), (0, 0, 1), (0, 0, 0)
BASES = {"m": LENGTH, "kg": (0, 1, 0), "s": TIME, "N": FORCE, "Pa": (-1, 1, -2), "W": POWER, "Hz": RATE, "rad": PLAIN, "K": PLAIN}
INSIDE = None  # an object with units of its own
UNDECLARED: dict[type, dict[str, tuple[int, int, int] | None]] = {
    pp.loads.PointForce: {"link": PLAIN},
    pp.loads.SpringDamper: {"link1": PLAIN, "link2": PLAIN},
    pp.loads.BalanceCylinder: {"count": PLAIN},
    pp.loads.PneumaticCushion: {"count": PLAIN},
    pp.loads.TimeForce: {"force": FORCE, "edges": TIME},
    pp.loads.Friction: {"viscous": (2, 1, -1)},
    pp.drives.Corner: {"jump": PLAIN},
    pp.drives.Geared: {"drive": INSIDE},
    pp.drives.InductionMotor: {"poles": PLAIN},
    pp.drives.InverterMotor: {"poles": PLAIN, "curve": PLAIN, "feeds_back": PLAIN},
    pp.drives.ServoMotor: {"times": TIME, "angles": PLAIN},
    pp.drives.Clutch: {"closes": INSIDE, "opens": INSIDE},
    pp.drives.Brake: {"closes": INSIDE, "opens": INSIDE},
}
"""Dimensions of fields that declare no unit."""


def dimension(unit, exponent):
    """Exponents of length, mass and time in a unit such as "N m s/rad" or "W/(N m)2"; ``exponent``: e of "N/m^e"."""
    powers = np.zeros(3)
    for part, sign in zip(unit.split("/"), (1, -1), strict=False):
        bracket = re.fullmatch(r"\((.*)\)(\d)", part)
        part, times = (bracket[1], int(bracket[2])) if bracket else (part, 1)
        for base, power in re.findall(r"([A-Za-z]+)(\^e|\d*)", part):
            powers += sign * times * (exponent if power == "^e" else int(power or 1)) * np.array(BASES[base])
    return tuple(map(float, powers))


def dimensions(thing):
    """Name of each field of a load, drive or coupling -> its dimension."""
    bare = UNDECLARED.get(type(thing), {})
    units = {field.name: unit.unit for field in fields(thing) if (unit := declared(field))}
    return {
        field.name: dimension(units[field.name], getattr(thing, "exponent", 1)) if field.name in units else bare[field.name]
        for field in fields(thing)
    }


def test_units_are_read():
    assert dimension("N m s/rad", 1) == (2, 1, -1)
    assert dimension("W/(N m)2", 1) == (-2, -1, 1)
    assert dimension("N s^e/m^e", 2) == (-1, 1, 0)


def grown(thing, units):
    """The same thing in other units."""
    if thing is None:
        return None
    changes = {}
    for name, powers in dimensions(thing).items():
        value = getattr(thing, name)
        if powers is INSIDE:
            changes[name] = grown(value, units)
        elif callable(value):
            changes[name] = lambda time, law=value: units.of(*FORCE) * law(time / units.time)
        elif powers != PLAIN and value is not None:
            changes[name] = (np.asarray(value, float) * units.of(*powers)).tolist()
    return replace(thing, **changes)


@cache
def press(units):
    gravity = 9.81 * units.of(1, 0, -2)
    text = scaled(pp.load(SIX).text.decode(), units.length, 0)  # inertias too, by the square of lengths

    def heavier(match):
        return f'{match.group(1)}="{float(match.group(2)) * units.mass!r}"'

    text = re.sub(r'\b(mass value|i[xyz]{2})="([^"]*)"', heavier, text)
    return large_linkages.load(text, gravity=(0.0, 0.0, -gravity))


SPRING = pp.loads.SpringDamper("frame", "slide", stiffness=2e5, damping=500.0, free_length=0.4, point1=(0.0, 0.0, 0.5))
LOADS = {
    "point force": pp.loads.PointForce("coupler", (100.0, 0.0, -50.0), (0.1, 0.0, 0.2)),
    "spring": SPRING,
    "piling": pp.loads.ConstantForce(1e4, 0.05),
    "blanking": pp.loads.Blanking(3e4, 0.04, -0.01, stripping=5e3),
    "drawing": pp.loads.DeepDrawing(3e4, 0.05),
    "table": pp.loads.ForceStroke([0.0, 0.02, 0.06], [2e4, 1e4, 0.0]),
    "die": pp.loads.ElasticDie(0.02, 1e6, 1e3),
    "dampers": pp.loads.ImpactDamper([-0.01, 0.1], [2e5, 1e5]),
    "oil": pp.loads.HydraulicCushion(2e4, 0.05, 0.005, 3e3),
    "shearing": pp.loads.RateSensitiveBlanking(3e4, 0.04, -0.01, 0.05, 1e-3, 0.02, 0.4, 5e3),
    "stops": pp.loads.TwoSidedStop(0.02, 0.25, 1e6, 1.0, 1e3, 0.01),
    "balance cylinder": pp.loads.BalanceCylinder(0.25, 6e5, 0.05),
    "cushion": pp.loads.PneumaticCushion(0.2, 5e5, 0.02, 0.06),
    "in time": pp.loads.TimeForce(lambda time: 1e3 * np.sin(20.0 * time)),
}
RUBBING = {"A": pp.loads.Friction(0.1, 0.05, 2.0), "C": pp.loads.Friction(0.1, 0.05)}


@cache
def at_rest():
    """Crank angles beside bottom dead centre at which the slide moves a little slower, and a little faster, than what counts as rest."""
    linkage = press(SI)
    bottom = pp.dead_centres(linkage).bottom_angle
    bend = float(pp.servo_cycle(linkage, angle=[bottom], speed=1.0).slide_acceleration[0])
    step = REST * linkage.size / bend
    return bottom + step * np.array([-40.0, -4.0, -0.25, 0.25, 4.0])


@cache
def states(units):
    angles = np.concatenate([np.linspace(0.0, 6.0, 13), at_rest()])
    speed, alpha = SPEED * units.of(*RATE), 20.0 * units.of(0, 0, -2)
    times = np.arange(len(angles)) * 0.01 * units.time
    each = pp.servo_cycle(press(units), angle=angles, speed=speed, acceleration=alpha)
    return replace(each, _time=times)  # no motion, but forces in time ask for times


def reactions(units, load=None, rubbing=None):
    given = [] if load is None else [grown(load, units)]
    laws = {name: grown(law, units) for name, law in (rubbing or {}).items()}
    return pp.inverse_dynamics(press(units), states(units), loads=given, friction=laws)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("units", UNITS)
@pytest.mark.parametrize("load", [None, *LOADS])
def test_inverse_dynamics(load, units):
    one, other = (reactions(u, LOADS.get(load), RUBBING if load is None else None) for u in (SI, units))
    compared = [
        (one.driving_torque, other.driving_torque, TORQUE),
        (one.shaking_moment, other.shaking_moment, TORQUE),
        (one.motion.slide_velocity, other.motion.slide_velocity, (1, 0, -1)),
        (one.motion.slide_acceleration, other.motion.slide_acceleration, (1, 0, -2)),
        *((one.bearing_force[name], other.bearing_force[name], FORCE) for name in one.bearing_force),
        *((one.friction_power[name], other.friction_power[name], POWER) for name in one.friction_power),
    ]
    for mine, its, dimension in compared:
        np.testing.assert_allclose(its / units.of(*dimension), mine, rtol=0, atol=1e-14 * np.abs(mine).max())


def test_travel_near_rest_is_told_by_the_size_of_the_press():
    """Punch and stripping: which way the slide moves is decided beside bottom dead centre alike in all units, and as the angles say."""
    blanking, downward = LOADS["blanking"], [True, True, False, False, False]
    for units in (SI, *UNITS):
        force = applied_loads.apply([grown(blanking, units)], press(units), states(units))[0].force[-5:, 2]
        np.testing.assert_array_equal(force > 0, downward)


@pytest.mark.parametrize("units", [SI, *UNITS])
def test_ends_of_a_spring_meet_at_a_share_of_the_press(units):
    linkage = press(units)
    size, motion = linkage.size, pp.servo_cycle(press(units), angle=[1.0], speed=SPEED * units.of(*RATE))
    there = (0.0, 0.0, float(motion.slide_position[0]))
    stretched = pp.loads.SpringDamper("frame", "slide", stiffness=1.0, free_length=0.1 * units.length, point1=there)
    joint, along = linkage.slide_guide[0], np.array([0.0, 0.0, 1.0])
    aside = linkage.model.jointPlacements[joint + 1].translation * (1 - along)
    for share, meets in ((0.5e-12, True), (4e-12, False)):
        spring = replace(stretched, point1=tuple(aside + there + share * size * along))
        if meets:
            with pytest.raises(pp.PinpressError, match="its ends meet"):
                pp.inverse_dynamics(linkage, motion, loads=[spring])
        else:
            pp.inverse_dynamics(linkage, motion, loads=[spring])


DRIVES = {
    "torque": pp.drives.ConstantTorque(400.0),
    "motor": pp.drives.Geared(pp.drives.InductionMotor(30e3, 1460 * pp.RPM, inertia=0.3), 20.0, 5.0, 0.95),
    "inverter": pp.drives.Geared(pp.drives.InverterMotor(200.0, 1460 * pp.RPM, 45.0, inertia=0.3), 20.0),
    "slip clutch": pp.drives.Geared(pp.drives.SlipClutchMotor(190.0, 150.0, 138.0, 130.0, lag=0.05, inertia=0.3), 18.0),
    "servo": pp.drives.ServoMotor([0.0, 0.1, 0.3], [0.0, 0.5, 1.5], 1e6, 1e5, 1e6, inertia=50.0),
}
SCENES: dict[str, dict[str, object]] = {
    **{name: {"drive": drive} for name, drive in DRIVES.items()},
    **{name: {"loads": [load]} for name, load in LOADS.items() if name != "in time"},
    "clutch": {"drive": DRIVES["torque"], "clutch": pp.drives.Clutch(2e3, closes=pp.drives.SwitchPoint(time=0.05), rise=0.02)},
    "brake": {"brake": pp.drives.Brake(2e3, closes=pp.drives.SwitchPoint(angle=3.6), rise=0.02)},
}


def run(scene, units):
    given = {
        name: [grown(each, units) for each in value] if isinstance(value, list) else grown(value, units)
        for name, value in SCENES[scene].items()
    }
    flywheel = grown(pp.drives.Flywheel(500.0), units)
    speed = 0.0 if scene in ("servo", "clutch") else SPEED * units.of(*RATE)
    if scene == "clutch":
        flywheel = grown(pp.drives.Flywheel(500.0, SPEED), units)
    return pp.simulate(
        press(units), 0.2 * units.time, speed=speed, angle=0.0 if scene == "servo" else 3.3, flywheel=flywheel, points=21, **given
    )


@pytest.mark.parametrize("scene", SCENES)
def test_runs(scene):
    units = UNITS[-1]
    one, other = run(scene, SI), run(scene, units)
    np.testing.assert_allclose(other.crank_angle, one.crank_angle, rtol=0, atol=1e-10)
    np.testing.assert_allclose(other.crank_speed / units.of(*RATE), one.crank_speed, rtol=0, atol=1e-9)
    np.testing.assert_allclose(other.time / units.time, one.time, rtol=0, atol=0)
    assert one.crank_angle[-1] != one.crank_angle[0]
