"""Nothing has a size of its own: with lengths, masses and times in other units, every result is the same in those units.

Units are powers of two, so that numbers keep their digits: what differs by more than rounding is an absolute size in a formula.
"""

import dataclasses
import re
from dataclasses import fields, replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from extremes.extreme_sizes import scaled
from support.generators import large_linkages

import pinpress as pp
from pinpress.drives import electric, motors, slip_clutch, transmission
from pinpress.dynamics import applied_loads
from pinpress.engines.friction import REST, FrictionLaw
from pinpress.engines.wrenches import AppliedForce
from pinpress.loads import contacts, hydraulics, link, pneumatics, process, shearing

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

FORCE, TORQUE, INERTIA, POWER, RATE = (1, 1, -2), (2, 1, -2), (2, 1, 0), (2, 1, -3), (0, 0, -1)
PRESSURE = (-1, 1, -2)
LENGTH, TIME, PLAIN = (1, 0, 0), (0, 0, 1), (0, 0, 0)
LOSSES = {"load_loss": POWER, "constant_loss": POWER, "rated_rise": PLAIN, "thermal_time": TIME}  # of every electric motor
INSIDE = None  # an object with units of its own
DIMENSIONS: dict[type, dict[str, tuple[int, int, int] | None]] = {
    link.PointForce: {"link": PLAIN, "force": FORCE, "point": LENGTH},
    link.SpringDamper: {
        "link1": PLAIN,
        "link2": PLAIN,
        "stiffness": (0, 1, -2),
        "damping": (0, 1, -1),
        "free_length": LENGTH,
        "point1": LENGTH,
        "point2": LENGTH,
    },
    pp.loads.Idle: {"datum": LENGTH},
    pp.loads.ConstantForce: {"force": FORCE, "height": LENGTH, "datum": LENGTH},
    pp.loads.Blanking: {"force": FORCE, "start": LENGTH, "end": LENGTH, "stripping": FORCE, "datum": LENGTH},
    pp.loads.DeepDrawing: {"force": FORCE, "start": LENGTH, "end": LENGTH, "datum": LENGTH},
    pp.loads.ForceStroke: {"heights": LENGTH, "forces": FORCE, "datum": LENGTH},
    pp.loads.ElasticDie: {"height": LENGTH, "stiffness": (0, 1, -2), "damping": (0, 1, -1), "datum": LENGTH},
    pp.loads.Impact: {
        "height": LENGTH,
        "stiffness": (0, 1, -2),  # of the exponent 1
        "exponent": PLAIN,
        "damping": (0, 1, -1),
        "depth": LENGTH,
        "datum": LENGTH,
    },
    pp.loads.TwoSidedStop: {
        "lower": LENGTH,
        "upper": LENGTH,
        "stiffness": (0, 1, -2),
        "exponent": PLAIN,
        "damping": (0, 1, -1),
        "depth": LENGTH,
        "datum": LENGTH,
    },
    pp.loads.ImpactDamper: {"heights": LENGTH, "coefficients": (-1, 1, 0), "exponent": PLAIN, "datum": LENGTH},  # of the exponent 2
    pp.loads.HydraulicCushion: {"force": FORCE, "height": LENGTH, "rise": LENGTH, "return_force": FORCE, "datum": LENGTH},
    pp.loads.RateSensitiveBlanking: {
        "force": FORCE,
        "start": LENGTH,
        "end": LENGTH,
        "sensitivity": PLAIN,
        "reference_speed": (1, 0, -1),
        "peak": LENGTH,
        "remaining": PLAIN,
        "stripping": FORCE,
        "datum": LENGTH,
    },
    pp.loads.BalanceCylinder: {
        "bore": LENGTH,
        "pressure": PRESSURE,
        "volume": (3, 0, 0),
        "rod": LENGTH,
        "count": PLAIN,
        "exponent": PLAIN,
        "height": LENGTH,
        "atmosphere": PRESSURE,
        "datum": LENGTH,
    },
    pp.loads.PneumaticCushion: {
        "bore": LENGTH,
        "pressure": PRESSURE,
        "volume": (3, 0, 0),
        "height": LENGTH,
        "rod": LENGTH,
        "count": PLAIN,
        "exponent": PLAIN,
        "atmosphere": PRESSURE,
        "datum": LENGTH,
    },
    pp.loads.TimeForce: {"force": FORCE, "edges": TIME},
    link.Friction: {"coefficient": PLAIN, "radius": LENGTH, "viscous": (2, 1, -1), "preload": FORCE},
    pp.drives.Flywheel: {"inertia": INERTIA, "speed": RATE},
    pp.drives.Corner: {"speed": RATE, "jump": PLAIN},
    pp.drives.PrescribedSpeed: {"speed": RATE},
    pp.drives.ConstantTorque: {"value": TORQUE},
    pp.drives.Geared: {"drive": INSIDE, "ratio": PLAIN, "gear_inertia": INERTIA, "efficiency": PLAIN},
    pp.drives.InductionMotor: {
        **LOSSES,
        "rated_power": POWER,
        "rated_speed": RATE,
        "frequency": RATE,
        "poles": PLAIN,
        "breakdown_ratio": PLAIN,
        "inertia": INERTIA,
    },
    pp.drives.InverterMotor: {
        **LOSSES,
        "rated_torque": TORQUE,
        "rated_speed": RATE,
        "frequency": RATE,
        "rated_frequency": RATE,
        "poles": PLAIN,
        "overload": PLAIN,
        "breakdown_ratio": PLAIN,
        "curve": PLAIN,
        "inertia": INERTIA,
        "inverter_efficiency": PLAIN,
        "feeds_back": PLAIN,
    },
    pp.drives.ServoMotor: {
        "times": TIME,
        "angles": PLAIN,
        "stiffness": TORQUE,
        "damping": (2, 1, -1),
        "peak_torque": TORQUE,
        "inertia": INERTIA,
        "rated_torque": TORQUE,
        "copper": (-2, -1, 1),
        "iron": (2, 1, -1),
        "constant_loss": POWER,
        "regeneration": PLAIN,
        "rated_rise": PLAIN,
        "thermal_time": TIME,
    },
    pp.drives.SlipClutchMotor: {
        **LOSSES,
        "rated_torque": TORQUE,
        "primary_speed": RATE,
        "top_speed": RATE,
        "set_speed": RATE,
        "regulation": PLAIN,
        "lag": TIME,
        "inertia": INERTIA,
        "amplification": TIME,
        "integral_time": TIME,
        "feedback": PLAIN,
        "residual_current": PLAIN,
        "excitation_power": POWER,
    },
    transmission.SwitchPoint: {"time": TIME, "angle": PLAIN},
    transmission.Clutch: {"torque": TORQUE, "closes": INSIDE, "opens": INSIDE, "rise": TIME},
    transmission.Brake: {"torque": TORQUE, "closes": INSIDE, "opens": INSIDE, "rise": TIME},
}


def test_no_field_is_left_out():
    """Of any load, drive, clutch or friction of the library."""
    rooms = (process, contacts, hydraulics, pneumatics, shearing, motors, slip_clutch, transmission, link)
    public = {cls for room in rooms for cls in vars(room).values() if dataclasses.is_dataclass(cls)}
    inner = {transmission.Coupling, electric.ElectricMotor, pp.loads.ForceInterval, AppliedForce, FrictionLaw}
    assert {cls for cls in public if cls.__module__.startswith("pinpress.") and cls not in inner} == set(DIMENSIONS)
    for cls, dimensions in DIMENSIONS.items():
        assert [field.name for field in fields(cls)] == list(dimensions)


def grown(thing, units):
    """The same thing in other units."""
    if thing is None:
        return None
    changes = {}
    for name, dimension in DIMENSIONS[type(thing)].items():
        value = getattr(thing, name)
        if dimension is INSIDE:
            changes[name] = grown(value, units)
        elif callable(value):
            changes[name] = lambda time, law=value: units.of(*FORCE) * law(time / units.time)
        elif dimension != PLAIN and value is not None:
            changes[name] = (np.asarray(value, float) * units.of(*dimension)).tolist()
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


@pytest.mark.one_in(11)
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
    "clutch": {"drive": DRIVES["torque"], "clutch": transmission.Clutch(2e3, closes=transmission.SwitchPoint(time=0.05), rise=0.02)},
    "brake": {"brake": transmission.Brake(2e3, closes=transmission.SwitchPoint(angle=3.6), rise=0.02)},
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


@pytest.mark.one_in(3)
@pytest.mark.parametrize("scene", SCENES)
def test_runs(scene):
    units = UNITS[-1]
    one, other = run(scene, SI), run(scene, units)
    np.testing.assert_allclose(other.crank_angle, one.crank_angle, rtol=0, atol=1e-10)
    np.testing.assert_allclose(other.crank_speed / units.of(*RATE), one.crank_speed, rtol=0, atol=1e-9)
    np.testing.assert_allclose(other.time / units.time, one.time, rtol=0, atol=0)
    assert one.crank_angle[-1] != one.crank_angle[0]
