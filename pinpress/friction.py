"""Viscous and Coulomb friction in bearings and guides.

A bearing resists its turning with the torque c w + mu r F, where F is its radial force (across the axis of rotation), a guide its sliding
with the force c v + mu F, where F is its force across the direction of sliding. F depends on the friction of all bearings: both are found
together. At rest, in a dead centre, Coulomb friction can have any value up to its limit; zero is taken.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .errors import PinpressError, UnknownNameError, shown
from .single_numbers import is_number

if TYPE_CHECKING:
    from .linkage import Linkage

REST = 1e-12  # share of the motion's largest speed below which a bearing rests: in a dead centre the speed is rounding
MOST_ITERATIONS = 200


@dataclass(frozen=True)
class Friction:
    """Friction of a bearing or guide.

    Attributes:
        coefficient: Coulomb's, mu [-].
        radius: of the bearing [m]; a guide has none.
        viscous: torque by angular speed [N m s/rad], in a guide force by speed [N s/m].
    """

    coefficient: float = 0.0
    radius: float | None = None
    viscous: float = 0.0


@dataclass(frozen=True, eq=False, repr=False)
class FrictionLaw:
    """The friction of all bearings, joints in Pinocchio's order, then loops.

    Attributes:
        arm: (bearings,) mu r [m], of guides mu [-]. viscous: (bearings,). turns: (bearings,) true but for guides.
        size: length of the linkage [m].
    """

    arm: Array
    viscous: Array
    turns: NDArray[np.bool_]
    size: float

    def moving(self, speeds: Array) -> Array:
        """Speeds (bearings, n), zero where they are rounding, beside the fastest of the motion."""
        turning = np.abs(speeds[self.turns]).max(initial=0.0)
        sliding = max(self.size * turning, np.abs(speeds[~self.turns]).max(initial=0.0))
        return np.where(np.abs(speeds) <= REST * np.where(self.turns, turning, sliding)[:, None], 0.0, speeds)

    def efforts(self, speeds: Array, forces: Callable[[Array], Array], angle: Array) -> Array:
        """Efforts (bearings, n) of friction, along the speeds, against them.

        Args:
            speeds: (bearings, n) of the bearings; exactly zero where one rests.
            forces: radial forces (bearings, n) under efforts (bearings, n) of friction.
            angle: (n,) crank angles, to name one.

        Raises:
            PinpressError: no consistent forces are found: friction locks the linkage, or nearly so.
        """
        steady = -self.viscous[:, None] * speeds
        against = -self.arm[:, None] * np.sign(speeds)
        found, change = steady, np.full(speeds.shape[1], np.inf)
        for _ in range(MOST_ITERATIONS):
            pressing = forces(found)
            following = steady + against * pressing
            before, change = change, np.abs(following - found).max(axis=0)
            # also beside what the largest force could do: a guide's own may be nothing but rounding
            size = np.maximum(np.abs(following).max(axis=0), self.arm.max() * pressing.max(axis=0))
            found = following
            # rounding can keep the last digits moving: stop where the change no longer shrinks
            if np.all((change <= 1e-15 * size) | ((change <= 1e-12 * size) & (change >= before))):
                return found
            if not np.isfinite(size).all():
                break
        worst = int(np.argmax(np.where(np.isfinite(change), change, np.inf)))
        raise PinpressError(
            f"friction locks the linkage, or nearly so, at crank angle {np.degrees(angle[worst]):.6g} deg: no consistent bearing forces are"
            " found; lower the coefficients of friction, or keep away from the dead point"
        )


def law(friction: Mapping[str, Friction], press: "Linkage") -> FrictionLaw | None:
    """The friction of a linkage's bearings, None where there is none.

    Raises:
        UnknownNameError: a bearing that the linkage does not have.
        PinpressError: a bearing with friction that cannot move, no radius or one that makes no sense, a value negative or not finite.
    """
    if not isinstance(friction, Mapping):
        raise PinpressError("friction is no mapping: give {name of a bearing: Friction(...)}")
    if not friction:
        return None
    turns = [axis.turns for axis in press.spatial.axes] + [True] * len(press.loops)
    arm, viscous = np.zeros(len(press.bearings)), np.zeros(len(press.bearings))
    for name, given in friction.items():
        if name not in press.bearings:
            raise UnknownNameError("bearing", name, press.bearings)
        if not isinstance(given, Friction):
            raise PinpressError(f"friction of {shown(name)} is {shown(given)}: give a Friction")
        index = press.bearings.index(name)
        if any(loop.name == name and loop.type == "fixed" for loop in press.loops):
            raise PinpressError(f"friction of {shown(name)}: a fixed loop does not turn; leave it out")
        for quantity in ("coefficient", "radius", "viscous"):
            value = getattr(given, quantity)
            if value is None and quantity == "radius":
                continue
            if not is_number(value) or float(value) < 0:
                raise PinpressError(f"friction of {shown(name)}: {quantity} is {shown(value)}; give a finite number that is not negative")
        if turns[index] and given.coefficient and given.radius is None:
            raise PinpressError(f"friction of {shown(name)}: its radius is missing; give that of the bearing [m]")
        if not turns[index] and given.radius is not None:
            raise PinpressError(f"friction of {shown(name)}: a guide has no radius; leave it out")
        arm[index] = float(given.coefficient) * (1.0 if given.radius is None else float(given.radius))
        viscous[index] = float(given.viscous)
    return FrictionLaw(arm, viscous, np.array(turns), press.spatial.size) if arm.any() or viscous.any() else None
