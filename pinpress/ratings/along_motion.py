"""The permissible process force along a given motion of one or several drivers, such as two servo motors.

In a state of the motion all reactions are affine in the process force F: R = R0 + F R1. R0 are those of the press with its weights, inertia
forces and springs in this motion, R1 those of its links without mass to a force of 1 N. |R0 + F R1| = C gives the force that a capacity C
permits. With friction |R| still crosses C once, which is found by Newton's method; see `permissible_force`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import expect, typed
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import FrozenMapping, read_only
from ..common.numerics import bracketed_roots
from ..common.quantities import Array
from ..common.results import Tabular
from ..dynamics.applied_loads import force_on_slide
from ..dynamics.inputs import Inputs, written
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Friction, Load
from .permissible_force import (
    BEARING,
    BESIDE,
    FURTHEST,
    NOMINAL,
    SAME,
    TIE,
    Capacities,
    governing_names,
    known_bearings,
    largest_factor,
    refuse_other_effort,
    refuse_unrated,
    without_masses,
)

INSTEAD = {
    "nominal_height": "a motion has no single bottom dead centre; give torques, drivers={...}",
    "flywheel_inertia": "a motion has no single stroke that takes energy; see driving_torque * crank_speed of inverse_dynamics",
    "motor_power": "see driving_torque * crank_speed of inverse_dynamics",
    "slide_acceleration": "compare it with slide_acceleration of the motion",
    "shaking_force": "compare it with shaking_force of inverse_dynamics",
}


@dataclass(frozen=True, eq=False, repr=False)
class MotionRatings(OfPress, Tabular):
    """The permissible process force of a press in each of the n states of a motion. All arrays are read-only.

    A process force presses on the slide along its guide, upwards in an upright press, as the process does on the way down.

    Attributes:
        press_name: name of the press.
        capacities: capacities as given.
        motion: the motion.
        loads: springs, balance cylinders and constant forces in addition to the process, as given.
        friction: friction of bearings and guides, as given.
        force: (n,) permissible process force, the smallest force that a limit permits [N].
        limits: name of a limit -> (n,) process force that it permits alone, at most the nominal force [N]. The names are "nominal force",
            "torque A" or, of a driver that slides, "driving force A", with the drivers' names, and "bearing NAME".
        limited_by: (n,) name of the limit that governs.
    """

    _press: Linkage
    capacities: Capacities
    motion: Motion
    loads: tuple[Load, ...]
    friction: Mapping[str, Friction]
    force: Array
    limits: Mapping[str, Array]
    limited_by: tuple[str, ...]

    @property
    def title(self) -> str:
        return f"MotionRatings of {self.press_name}: {len(self.force)} states, at least {self.force.min():.6g} N"

    def utilisation(self, reactions: Reactions) -> Array:
        """Process force / permissible force in the same state (n,) [-], read-only: above 1 the press is overloaded.

        Args:
            reactions: reactions of the same press to the same motion under process loads.

        Raises:
            PinpressError: the reactions belong to another press or another motion.
        """
        expect("reactions", reactions, Reactions, "inverse_dynamics")
        given, mine = reactions.motion, self.motion
        if reactions._press.name != self.press_name:
            raise PinpressError(
                f"the reactions belong to {reactions._press.name}, but the ratings to {self.press_name}: give reactions of the same press"
            )
        if not all(np.array_equal(getattr(given, name), getattr(mine, name)) for name in ("joint_position", "v", "a")):
            raise PinpressError("the reactions belong to another motion: give inverse_dynamics(press, ratings.motion, loads)")
        return read_only(reactions.process_force / self.force)

    def columns(self) -> dict[str, Array | list[str]]:
        """A row for each state: time, drivers, slide, permissible force, and the force that each limit permits."""
        motion = self.motion
        return {
            **{name: column for name, column in motion.columns().items() if name == "time [s]"},
            **motion.position_columns(),
            "slide_position [m]": motion.slide_position,
            "slide_velocity [m/s]": motion.slide_velocity,
            "force [N]": self.force,
            "limited_by": list(self.limited_by),
            **{f"{name} [N]": force for name, force in self.limits.items()},
        }


@typed
def rate_motion(
    press: Linkage,
    motion: Motion,
    capacities: Capacities,
    *,
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    engine: str = "auto",
) -> MotionRatings:
    """Find the permissible process force in each state of a motion, in addition to weights and inertia forces.

    This is for servo presses and presses with several drivers, each with a separate capacity; `rate` is for a crank at constant
    speed.

    Args:
        press: a press with a slide.
        motion: a motion of this press, from `servo_cycle`, `read_motion`, `simulate` or `cycle`.
        capacities: the nominal force, capacities of the drivers (``drivers``, or ``torque`` with one driver) and of bearings.
        loads: springs and dampers, e.g. a balance cylinder, and constant forces on links, in addition to the process.
        friction: name of a bearing or guide -> friction, as in `inverse_dynamics`; a state at rest has no friction.
        engine: as in `cycle`.

    Raises:
        PinpressError: the press has no slide, friction locks it, the motion belongs to another press, a capacity does not suit a motion or
        has a wrong unit, a load is a process load, or the press exceeds a capacity without a process (the message names the state).
        UnknownNameError: the press has no such driver, bearing or link.
        SingularityError: the linkage locks in a state.
    """
    expect("motion", motion, Motion, "servo_cycle")
    limits = [*_driver_limits(press, capacities), *(_bearing_limit(capacities, name) for name in known_bearings(capacities, press))]
    refuse_unrated(press, loads, friction, at_speed=True)
    refuse_motion_of_another(press, motion)
    _ = press.slide_guide  # which refuses a press without a slide
    given = _Given(press, motion, capacities, tuple(loads), FrozenMapping(friction), engine)
    idle = given.under(0.0)
    for limit in limits:
        _refuse_exceeded(motion, limit, limit.size(idle))
    permitted = _beside_friction(given, limits) if friction else _affine(given, limits, idle)
    most = capacities.nominal_force
    capped = {name: read_only(np.minimum(force, most)) for name, force in ({NOMINAL: np.full(given.count, most)} | permitted).items()}
    return MotionRatings(
        _press=press,
        capacities=capacities,
        motion=motion,
        loads=given.loads,
        friction=given.friction,
        force=read_only(np.min(list(capped.values()), axis=0)),
        limits=FrozenMapping(capped),
        limited_by=governing_names(capped),
    )


def limits_in_words(ratings: MotionRatings) -> Inputs:
    """The capacities of a rating along a motion, by their names."""
    given, press = ratings.capacities, ratings._press
    rows = [("nominal force", written(given.nominal_force, "N"))]
    rows += [(limit.name, written(limit.capacity, limit.unit)) for limit in _driver_limits(press, given)]
    return [*rows, *((f"bearing {name}", written(force, "N")) for name, force in given.bearings.items())]


class _Limit(NamedTuple):
    """A capacity of a driver or bearing.

    Attributes:
        name: as in `MotionRatings.limits`.
        what: bears it, in words.
        capacity: largest magnitude [N or N m].
        unit: of it.
        reaction: gives the driving torque or bearing force (n, k) of reactions.
    """

    name: str
    what: str
    capacity: float
    unit: str
    reaction: Callable[[Reactions], Array]

    def size(self, reactions: Reactions) -> Array:
        """Magnitudes (n,) in reactions."""
        return np.asarray(np.linalg.norm(self.reaction(reactions), axis=1))


@dataclass(frozen=True, eq=False)
class _Given:
    """The arguments of `rate_motion`, checked."""

    press: Linkage
    motion: Motion
    capacities: Capacities
    loads: tuple[Load, ...]
    friction: Mapping[str, Friction]
    engine: str

    @property
    def count(self) -> int:
        return len(self.motion.crank_angle)

    @property
    def bearings(self) -> tuple[str, ...]:
        return tuple(self.capacities.bearings)

    def under(self, force: Array | float) -> Reactions:
        """Reactions under process forces, one or (n,) [N], beside weights, inertia forces and the other loads."""
        loads = [*self.loads, force_on_slide(self.press, np.full(self.count, force))]
        return inverse_dynamics(self.press, self.motion, loads, self.friction, engine=self.engine, bearings=self.bearings)


def _affine(given: _Given, limits: Sequence[_Limit], idle: Reactions) -> dict[str, Array]:
    """The forces (n,) that limits permit where all reactions are affine in the process force."""
    pushed = [force_on_slide(given.press, 1.0)]
    unit = inverse_dynamics(without_masses(given.press), given.motion, pushed, engine=given.engine, bearings=given.bearings)
    return {limit.name: largest_factor(limit.reaction(idle), limit.reaction(unit), limit.capacity) for limit in limits}


def _beside_friction(given: _Given, limits: Sequence[_Limit]) -> dict[str, Array]:
    """The forces (n,) that limits permit where friction goes with weights and inertia forces too; infinite where they are beyond
    `FURTHEST`.

    Raises:
        PinpressError: friction locks the linkage, or a smaller force than one that is permitted is not.
    """
    nominal = given.capacities.nominal_force
    largest, step, found = FURTHEST * nominal, BESIDE * nominal, {}
    furthest = given.under(largest)
    for limit in limits:
        limited = limit.size(furthest) > limit.capacity

        def missing(force: Array, limit: _Limit = limit, limited: NDArray[np.bool_] = limited) -> tuple[Array, Array]:
            """Shares less 1 and their slopes; of states that nothing limits what has a root of its own."""
            share, beside = (limit.size(given.under(some)) / limit.capacity for some in (force, force + step))
            return np.where(limited, share - 1.0, force / largest - 0.5), np.where(limited, (beside - share) / step, 1.0 / largest)

        force = bracketed_roots(missing, np.zeros(given.count), np.full(given.count, largest), relative=SAME)
        for part in (0.25, 0.5, 0.75):
            beyond = limited & (limit.size(given.under(part * force)) > (1.0 + TIE) * limit.capacity)
            if beyond.any():
                place = given.motion.place(int(beyond.argmax()))
                raise PinpressError(
                    f"at {place} there is no single permissible force with friction: '{limit.name}' permits"
                    f" {force[beyond.argmax()]:.6g} N, but not every smaller force. Rate the motion without friction"
                )
        found[limit.name] = np.where(limited, force, np.inf)
    return found


def _driver_limits(press: Linkage, capacities: Capacities) -> Iterator[_Limit]:
    """The capacities of drivers; raises as `_of_drivers`."""
    for name, capacity in _of_drivers(press, capacities).items():
        column = press.drivers.index(name)
        coordinate = press.driver_coordinates[column]

        def torque(reactions: Reactions, column: int = column) -> Array:
            return reactions.driving_torque.reshape(len(reactions.driving_torque), -1)[:, [column]]

        kind = "torque" if coordinate.turns else "driving force"
        yield _Limit(f"{kind} {name}", f"the driving {coordinate.effort} of {shown(name)}", capacity, coordinate.effort_unit, torque)


def _bearing_limit(capacities: Capacities, name: str) -> _Limit:
    def force(reactions: Reactions) -> Array:
        return reactions.bearing_force[name]

    return _Limit(BEARING + name, f"the force in bearing {shown(name)}", capacities.bearings[name], "N", force)


def _of_drivers(press: Linkage, capacities: Capacities) -> dict[str, float]:
    """Capacities of drivers by their names; raises as `rate_motion` where capacities are none of a motion."""
    for name, instead in INSTEAD.items():
        if getattr(capacities, name) is not None:
            raise PinpressError(f"{name} is not a capacity along a given motion: {instead}")
    if capacities.torque is not None:
        first = press.drivers[0]
        press.refuse_several_drivers(f"torque does not name a driver; give drivers={{{first!r}: {capacities.torque:g}}}")
        refuse_other_effort(capacities, press.driver_coordinates[0])
        return {press.driver: capacities.torque}
    for name in capacities.drivers:
        if name not in press.drivers:
            raise UnknownNameError("driver", name, press.drivers)
        refuse_other_effort(capacities, press.driver_coordinates[press.drivers.index(name)], name)
    return {name: capacities.drivers[name] for name in press.drivers if name in capacities.drivers}


def _refuse_exceeded(motion: Motion, limit: _Limit, size: Array) -> None:
    """Raise PinpressError where reactions (n,) exceed a capacity without a process."""
    worst = int(size.argmax())
    if size[worst] > limit.capacity:
        raise PinpressError(
            f"{limit.what} is {size[worst]:.6g} {limit.unit} at {motion.place(worst)} without a process, but the capacity is"
            f" {limit.capacity:.6g} {limit.unit}: move more slowly, or raise the capacity"
        )
