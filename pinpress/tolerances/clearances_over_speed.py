"""Shifts of the dead centres by clearances over the speed, and the lowest speeds at which the forces of bearings reverse.

    print(tolerances.play_over_speeds(press, {"E": 50e-6, "F": 50e-6}, speed=[20 * pp.RPM, 70 * pp.RPM]))

At a crank angle, every force of a press that turns at constant speed w is F0 + w^2 F2. F2 comes from inertia, F0 from weights and from
loads that do not depend on the speed. So the speed at which a bearing's force reverses (see `clearances`) is the root of a quadratic
equation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import numbers, typed
from ..common.errors import PinpressError
from ..common.frozen import FrozenMapping
from ..common.quantities import Array, DriverCoordinate
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..kinematics.cycle import cycle
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Friction, Load
from .clearances import KNOWN_TO, ROUNDING, UNMOVED, GuideClearance, contacts_of, crossings, play
from .virtual_work import unit_forces

SLOWEST = 1e-6  # squares of slower speeds vanish in rounding error, compared with weights [rad/s or m/s]


@dataclass(frozen=True, eq=False, repr=False)
class DeadCentresInClearances(OfPress, Tabular):
    """Shifts of the dead centres by clearances at S speeds. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        coordinate: what the coordinate of the driver is.
        speed: (S,) constant speeds of the crank [rad/s], largest speeds of a driver that slides [m/s].
        bottom_shift: (S,) lowest position of the slide with clearances - lowest position without [m].
        bottom_lowest: (S,) lowest possible bottom_shift, if bearings are undetermined [m].
        bottom_highest: (S,) highest possible bottom_shift, if bearings are undetermined [m].
        top_shift: (S,) highest position of the slide with clearances - highest position without [m].
        reversals: (S,) number of forces that reverse within a period.
        reversing_speed: name of a bearing -> lowest speed at which its force reverses, 0 for a reversal at standstill [rad/s]. Bearings
            whose force never reverses are left out. Empty if a load depends on the speed, or with friction: then forces do not follow
            speed².
    """

    _press: Linkage
    coordinate: DriverCoordinate
    speed: Array
    bottom_shift: Array
    bottom_lowest: Array
    bottom_highest: Array
    top_shift: Array
    reversals: Array
    reversing_speed: Mapping[str, float]

    @property
    def title(self) -> str:
        low, high = self.bottom_shift.min(), self.bottom_shift.max()
        what = f"DeadCentresInClearances of {self.press_name}: {len(self.speed)} speeds"
        return f"{what}, bottom dead centre {low:+.4g} to {high:+.4g} m off"

    def columns(self) -> dict[str, Array]:
        """A row for each speed."""
        return {
            "{} [{}]".format(*self.coordinate.heads[1]): self.speed,
            "bottom_shift [m]": self.bottom_shift,
            "bottom_lowest [m]": self.bottom_lowest,
            "bottom_highest [m]": self.bottom_highest,
            "top_shift [m]": self.top_shift,
            "reversals": self.reversals,
        }


@typed
def play_over_speeds(
    press: Linkage,
    clearance: Mapping[str, float | GuideClearance],
    *,
    speed: ArrayLike,
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    known_to: float = KNOWN_TO,
) -> DeadCentresInClearances:
    """Compute the shifts of a press's dead centres by clearances at constant speeds, and the lowest speeds at which forces reverse.

    Args:
        press: a press with one driver and a slide.
        clearance: as in `play`.
        speed: (S,) speeds of the crank, or one number [rad/s]; the largest speeds of a driver that slides [m/s].
        loads: as in `play`.
        friction: as in `play`.
        known_to: as in `play`.

    Raises:
        UnknownNameError: as `play`.
        PinpressError: a speed is zero or not finite; also as `play` and `cycle`.
    """
    press.refuse_several_drivers("give their motion to play, servo_cycle(press, angles, speed=...)")
    speeds = np.atleast_1d(numbers("speed", speed, unit=f"{press.driver_coordinates[0].unit}/s"))
    if speeds.ndim != 1 or not len(speeds) or not np.all(np.abs(speeds) >= SLOWEST):
        raise PinpressError("speed has no value, or a zero: give speeds other than zero [rad/s]; for standstill use servo_cycle and play")
    plays = [play(press, cycle(press, float(w)), clearance, loads, friction=friction, known_to=known_to) for w in speeds]
    return DeadCentresInClearances(
        _press=press,
        coordinate=press.driver_coordinates[0],
        speed=speeds,
        bottom_shift=np.array([at_speed.bottom_shift for at_speed in plays]),
        bottom_lowest=np.array([at_speed.bottom_band[0] for at_speed in plays]),
        bottom_highest=np.array([at_speed.bottom_band[1] for at_speed in plays]),
        top_shift=np.array([at_speed.top_shift for at_speed in plays]),
        reversals=np.array([len(at_speed.reversals) for at_speed in plays]),
        reversing_speed=FrozenMapping(
            {} if friction else _reversing_speeds(press, clearance, float(speeds[np.abs(speeds).argmax()]), loads)
        ),
    )


def _reversing_speeds(
    press: Linkage, clearance: Mapping[str, float | GuideClearance], fastest: float, loads: Sequence[Load]
) -> dict[str, float]:
    """Lowest speeds at which forces reverse: two speeds give F0 and F2, and a third speed shows whether loads depend on the speed."""
    speeds = np.array([0.5, 0.75, 1.0]) * fastest
    motions = [cycle(press, float(speed)) for speed in speeds]
    unit = unit_forces(press, motions[0])
    contacts = [contacts_of(press, unit, clearance, inverse_dynamics(press, motion, loads)) for motion in motions]
    slow, between, fast = (np.array([contact.force for contact in of_speed]) for of_speed in contacts)
    inertia = (fast - slow) / (speeds[2] ** 2 - speeds[0] ** 2)
    rest = slow - speeds[0] ** 2 * inertia
    if np.abs(rest + speeds[1] ** 2 * inertia - between).max() > ROUNDING * np.abs([slow, fast]).max():
        return {}
    lowest = {}
    for contact, constant, by_squared_speed in zip(contacts[0], rest, inertia, strict=True):
        along, growing = (np.einsum("nk,nk->n", contact.unit, force) for force in (constant, by_squared_speed))
        changes = (np.linalg.norm(contact.unit, axis=1) > UNMOVED) & (along * growing < 0)
        if crossings(motions[0], contact.unit, constant):
            lowest[contact.name] = 0.0
        elif np.any(changes):
            lowest[contact.name] = float(np.sqrt((-along[changes] / growing[changes]).min()))
    return lowest
