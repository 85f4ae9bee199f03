"""What the parts of a press can bear, as its builder or buyer states it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ..common.checks import positive
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import Frozen, FrozenMapping
from ..linkage.linkage import Linkage

UNITS = {
    "nominal_force": "N",
    "nominal_height": "m",
    "torque": "N m",
    "flywheel_inertia": "kg m2",
    "speed_drop": "-",
    "motor_power": "W",
    "slide_acceleration": "m/s2",
    "shaking_force": "N",
}


@dataclass(frozen=True)
class Capacities(Frozen):
    """Capacities of a press; what is None, or no bearing here, limits nothing.

    Attributes:
        nominal_force: largest process force at any height [N].
        nominal_height: above bottom dead centre, from which down the crank's torque lets the nominal force act [m].
        torque: capacity at the driver joint [N m], in place of the nominal height.
        bearings: name of a bearing or guide -> largest force in it, the magnitude of its vector: the radial force of a planar press [N].
        flywheel_inertia: reduced to the driver joint; the linkage's own is not counted [kg m2].
        speed_drop: largest drop of the flywheel's speed in a stroke, a fraction of the speed; goes with the flywheel. Customary are 0.2 to
            0.3 in single strokes, 0.1 to 0.15 in continuous ones.
        motor_power: that restores the energy from stroke to stroke in continuous use [W]. Leave it out for single strokes, between which
            there is time enough.
        slide_acceleration: largest that tool and feed allow [m/s2].
        shaking_force: largest on the foundation, the weight left out [N].

    Raises:
        PinpressError: a number that is not positive and finite, torque and nominal height at once, a flywheel without a drop of speed or
            the other way round, a drop of more than the speed.
    """

    nominal_force: float
    nominal_height: float | None = None
    torque: float | None = None
    bearings: Mapping[str, float] = field(default_factory=lambda: FrozenMapping({}))
    flywheel_inertia: float | None = None
    speed_drop: float | None = None
    motor_power: float | None = None
    slide_acceleration: float | None = None
    shaking_force: float | None = None

    def __post_init__(self) -> None:
        for name, unit in UNITS.items():
            value = getattr(self, name)
            if value is not None or name == "nominal_force":
                object.__setattr__(self, name, positive(name, value, unit))
        if not isinstance(self.bearings, Mapping):
            raise PinpressError(f"bearings is {shown(self.bearings)}: give a mapping of names to forces [N], e.g. {{'A': 2e6}}")
        known = {name: positive(f"the capacity of bearing {shown(name)}", value, "N") for name, value in self.bearings.items()}
        object.__setattr__(self, "bearings", FrozenMapping(known))
        if self.torque is not None and self.nominal_height is not None:
            raise PinpressError("torque and nominal_height both state the torque capacity: leave one out")
        if (self.flywheel_inertia is None) != (self.speed_drop is None):
            raise PinpressError("flywheel_inertia and speed_drop go together: give both, or neither")
        if self.speed_drop is not None and self.speed_drop > 1.0:
            raise PinpressError(f"speed_drop is {self.speed_drop:g}: give a fraction of the speed, 1 or less")

    def energies(self, speed: float, turns: int = 1) -> dict[str, float]:
        """Name of a source -> work that a stroke may take of it at a crank speed [rad/s] [J].

        A flywheel that slows from w to (1 - d) w gives J w^2 (1 - (1 - d)^2) / 2, a motor of power P restores 2 pi P / w in a turn.

        Args:
            turns: of the crank, from stroke to stroke.
        """
        found = {}
        if self.flywheel_inertia is not None and self.speed_drop is not None:
            # d (2 - d): 1 - (1 - d)^2 would cancel for a small drop
            found["flywheel energy"] = 0.5 * self.flywheel_inertia * speed**2 * self.speed_drop * (2.0 - self.speed_drop)
        if self.motor_power is not None:
            found["motor energy"] = self.motor_power * 2 * math.pi * turns / abs(speed)
        return found


def known_bearings(capacities: Capacities, press: Linkage) -> tuple[str, ...]:
    """Names of the bearings with a capacity, in the press's order.

    Raises:
        PinpressError: no Capacities. UnknownNameError: a bearing that the press does not have.
    """
    if not isinstance(capacities, Capacities):
        raise PinpressError(f"capacities is a {type(capacities).__name__}: give Capacities(nominal_force=...)")
    for name in capacities.bearings:
        if name not in press.bearings:
            raise UnknownNameError("bearing", name, press.bearings)
    return tuple(name for name in press.bearings if name in capacities.bearings)
