"""Every public entry that takes numbers refuses what NumPy would take for some: masks, imaginary parts, texts, truth values, dates."""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

import pinpress as pp
from pinpress import foundation
from pinpress.drives.protocol import SpeedTorqueDrive
from pinpress.kinematics import measures

ODD = {
    "masked": np.ma.masked_array([1.0, 2.0, 3.0], mask=[0, 1, 0]),
    "masked number": np.ma.masked_array(1.0, mask=True),
    "complex": np.array([1 + 1j, 2.0, 3.0]),
    "complex number": 1 + 2j,
    "texts": ["1", "2", "3"],
    "text": "1",
    "truth values": [True, False, True],
    "truth value": True,
    "dates": np.array(["2026-01-01", "2026-01-02", "2026-01-03"], dtype="M8[D]"),
    "spans of time": np.array([1, 2, 3], dtype="m8[s]"),
    "ragged": [[1.0], [1.0, 2.0]],
}


@cache
def press() -> pp.Linkage:
    return pp.load("crank_slide")


@cache
def turn() -> pp.Motion:
    return pp.cycle(press(), 7.0, points=12)


@cache
def result() -> pp.Reactions:
    return pp.inverse_dynamics(press(), turn())


def under(load: Any) -> pp.Reactions:
    return pp.inverse_dynamics(press(), turn(), [load])


SPRINGS = pp.elasticity.Stiffness(bearings={"O": 1e9, "P": 1e9, "W": 1e9})
ENTRIES: dict[str, Callable[[Any], object]] = {
    "angle of a motion": lambda v: pp.servo_cycle(press(), speed=1.0, angle=v),
    "speed of a motion": lambda v: pp.servo_cycle(press(), speed=v, angle=[0.0, 1.0, 2.0]),
    "speed of a turn": lambda v: pp.cycle(press(), v),
    "acceleration": lambda v: pp.servo_cycle(press(), speed=1.0, angle=[0.0, 1.0, 2.0], acceleration=v),
    "time": lambda v: pp.servo_cycle(press(), speed=1.0, angle=[0.0, 1.0, 2.0], time=v),
    "gravity": lambda v: pp.load("crank_slide", gravity=v),
    "force": lambda v: under(pp.loads.PointForce("slide", v)),
    "force of a function": lambda v: under(pp.loads.PointForce("slide", lambda motion: v)),
    "point of a force": lambda v: under(pp.loads.PointForce("slide", (0.0, 0.0, 1.0), v)),
    "spring": lambda v: under(pp.loads.SpringDamper("slide", "frame", stiffness=v)),
    "end of a spring": lambda v: under(pp.loads.SpringDamper("slide", "frame", 1.0, point2=v)),
    "friction": lambda v: pp.inverse_dynamics(press(), turn(), friction={"P": pp.loads.Friction(v, 0.1)}),
    "stiffness": lambda v: pp.inverse_dynamics(press(), turn(), stiffness={"P": v}),
    "load": lambda v: pp.loads.ConstantForce(v, 0.01),
    "height of a load": lambda v: pp.loads.ConstantForce(1.0, v),
    "heights of a table": lambda v: pp.loads.ForceStroke(v, [1.0, 2.0, 3.0]),
    "forces of a table": lambda v: pp.loads.ForceStroke([0.0, 0.1, 0.2], v),
    "force in time": lambda v: under(pp.loads.TimeForce(lambda time: v)),
    "edges in time": lambda v: pp.loads.TimeForce(lambda time: 0 * time, v),
    "step": lambda v: pp.loads.step(v, 0.0, 0.0, 1.0, 1.0),
    "begin of a step": lambda v: pp.loads.step(0.5, v, 0.0, 1.0, 1.0),
    "duration": lambda v: pp.simulate(press(), v, speed=1.0),
    "speed at the start": lambda v: pp.simulate(press(), 0.01, speed=v),
    "angle at the start": lambda v: pp.simulate(press(), 0.01, speed=1.0, angle=v),
    "steady state": lambda v: pp.steady_state(press(), v, drive=pp.drives.InductionMotor(1e4, 95 * pp.RPM, poles=60)),
    "flywheel": lambda v: pp.drives.Flywheel(v),
    "torque": lambda v: pp.drives.ConstantTorque(v),
    "gear": lambda v: pp.drives.Geared(pp.drives.ConstantTorque(1.0), v),
    "switch": lambda v: pp.drives.SwitchPoint(time=v),
    "clutch": lambda v: pp.drives.Clutch(v),
    "speeds of operating points": lambda v: pp.sweeps.operating_points(press(), v),
    "forces of operating points": lambda v: pp.sweeps.operating_points(
        press(), [1.0], forces=v, unit_load=[pp.loads.DeepDrawing(1.0, 0.01)]
    ),
    "unit load": lambda v: pp.sweeps.operating_points(press(), [1.0], forces=[1.0], unit_load=[pp.loads.PointForce("slide", v)]),
    "capacity": lambda v: pp.ratings.Capacities(nominal_force=v),
    "capacity of a bearing": lambda v: pp.ratings.Capacities(nominal_force=1e5, bearings={"P": v}),
    "length of gibs": lambda v: pp.ratings.Gibs(v, 0.1),
    "normal of gibs": lambda v: pp.ratings.Gibs(0.1, 0.1, normal=v),
    "mass of a region": lambda v: pp.balancing.CounterweightRegion("crank", radius=0.1, mass=v),
    "radius of a region": lambda v: pp.balancing.CounterweightRegion("crank", radius=v),
    "place of a region": lambda v: pp.balancing.CounterweightRegion("crank", at=v),
    "corners of a region": lambda v: pp.balancing.CounterweightRegion("crank", corners=v),
    "axis of a measure": lambda v: pp.balancing.Range("shaking_force", axis=v),
    "point of a measure": lambda v: pp.balancing.Rms("shaking_moment", about=v),
    "counterweight": lambda v: pp.balancing.with_counterweights(press(), [pp.balancing.Counterweight("crank", v, (0.0, 0.0, 0.0))]),
    "place of a counterweight": lambda v: pp.balancing.with_counterweights(press(), [pp.balancing.Counterweight("crank", 1.0, v)]),
    "break-through": lambda v: pp.elasticity.permissible_breakthrough(v, 1e9, mass=500.0),
    "snap-through": lambda v: pp.elasticity.snap_through(v, 1e9, mass=500.0),
    "spring of a bearing": lambda v: pp.elasticity.compliance(press(), pp.elasticity.Stiffness(bearings={"P": v})),
    "angles of elasticity": lambda v: pp.elasticity.compliance(press(), SPRINGS, angle=v),
    "mounts": lambda v: foundation.Mount((0.0, 0.0, 0.0), v),
    "values of a sweep": lambda v: pp.sweeps.operating_points(press(), [1.0], forces=v),
    "height of a speed": lambda v: measures.speed_at(turn(), v),
    "pivots": lambda v: pp.derivatives.motion_derivatives(press(), turn(), {("P", "crank"): v}),
    "efforts": lambda v: pp.derivatives.acceleration_derivatives(press(), turn(), efforts=v),
    "armature": lambda v: pp.derivatives.acceleration_derivatives(press(), turn(), armature=v),
    "reshaped": lambda v: pp.derivatives.reshaped(press(), {("P", "crank"): v}),
}


def accepted(ask: Callable[[Any], object]) -> Iterator[str]:
    for kind, value in ODD.items():
        try:
            ask(value)
        except pp.PinpressError:
            continue
        yield kind


@pytest.mark.parametrize("entry", ENTRIES)
def test_what_is_no_number_is_refused(entry):
    assert list(accepted(ENTRIES[entry])) == []


def test_a_law_that_answers_with_complex_or_masked_numbers_is_refused():
    class Odd(SpeedTorqueDrive):
        def __init__(self, factor: Any) -> None:
            self.factor, self.inertia, self.rated_torque = factor, 0.0, None

        def torque(self, speed, angle=0.0, time=0.0, state=()):
            return -speed * self.factor

    for factor in (1 + 1j, np.ma.masked_array(1.0, mask=True)):
        with pytest.raises(pp.PinpressError, match=r"Odd: .*torque"):
            pp.simulate(press(), 0.1, speed=5.0, drive=Odd(factor))
