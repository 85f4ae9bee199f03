"""Numbers within others of an entry: what NumPy would take for some is refused, as masks, imaginary parts, texts, truth values, dates.

Numbers that are arguments themselves are tried in `test_hostile_arguments`.
"""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

import pinpress as pp
from pinpress.drives.protocol import SpeedTorqueDrive

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


def under(load: Any) -> pp.Reactions:
    return pp.inverse_dynamics(press(), turn(), [load])


ENTRIES: dict[str, Callable[[Any], object]] = {
    "gravity": lambda v: pp.load("crank_slide", gravity=v),
    "force of a function": lambda v: under(pp.loads.PointForce("slide", lambda motion: v)),
    "force in time": lambda v: under(pp.loads.TimeForce(lambda time: v)),
    "spring": lambda v: under(pp.loads.SpringDamper("slide", "frame", stiffness=v)),
    "friction": lambda v: pp.inverse_dynamics(press(), turn(), friction={"P": pp.loads.Friction(v, 0.1)}),
    "stiffness": lambda v: pp.inverse_dynamics(press(), turn(), stiffness={"P": v}),
    "unit load": lambda v: pp.sweeps.operating_points(press(), [1.0], forces=[1.0], unit_load=[pp.loads.PointForce("slide", v)]),
    "capacity of a bearing": lambda v: pp.ratings.Capacities(nominal_force=1e5, bearings={"P": v}),
    "counterweight": lambda v: pp.balancing.with_counterweights(press(), [pp.balancing.Counterweight("crank", v, (0.0, 0.0, 0.0))]),
    "spring of a bearing": lambda v: pp.elasticity.compliance(press(), pp.elasticity.Stiffness(bearings={"P": v})),
    "spring of the frame": lambda v: pp.elasticity.compliance(press(), pp.elasticity.Stiffness(frame=v)),
    "spring of a rod": lambda v: pp.elasticity.compliance(press(), pp.elasticity.Stiffness(rods=[pp.elasticity.Rod("rod", ("P", "W"), v)])),
    "pivots": lambda v: pp.derivatives.motion_derivatives(press(), turn(), {("P", "crank"): v}),
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
