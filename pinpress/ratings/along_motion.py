"""The permissible process force along a given motion of one or several drivers, such as two servo motors; see `limits`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..common.arguments import expect, typed
from ..common.errors import PinpressError, UnknownNameError
from ..common.frozen import FrozenMapping, read_only
from ..common.quantities import Array
from ..common.results import Tabular
from ..dynamics.applied_loads import force_on_slide
from ..dynamics.inputs import Inputs, written
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Friction, Load
from .limits import NOMINAL, Limit, affine_forces, bearing_limit, driver_limit, forces_with_friction, governing_names, without_masses
from .permissible_force import Capacities, known_bearings, refuse_other_effort, refuse_unrated

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
            "torque DRIVER" ("driving force DRIVER" for a sliding driver) and "bearing NAME".
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
    limits = _limits(press, capacities)
    refuse_unrated(press, loads, friction, at_speed=True)
    refuse_motion_of_another(press, motion)
    _ = press.slide_guide  # raises an error if the press has no slide
    bearings = tuple(capacities.bearings)
    nominal = np.full(len(motion.crank_angle), capacities.nominal_force)

    def under(force: Array) -> Reactions:
        """Reactions to process forces (n,) [N], weights, inertia forces and the other loads."""
        pushed = force_on_slide(press, force)
        return inverse_dynamics(press, motion, [*loads, pushed], friction, engine=engine, bearings=bearings)

    idle = under(0 * nominal)
    for limit in limits:
        size = limit.size(idle)
        worst = int(size.argmax())
        if size[worst] > limit.capacity:
            raise PinpressError(
                f"{limit.what} is {size[worst]:.6g} {limit.unit} at {motion.place(worst)} without a process, but the capacity is"
                f" {limit.capacity:.6g} {limit.unit}: move more slowly, or raise the capacity"
            )
    if friction or press.uneven:

        def sizes(force: Array) -> Array:
            reactions = [under(each) for each in force]
            return np.array([[limit.size(each) for each in reactions] for limit in limits])

        permitted = forces_with_friction(limits, sizes, nominal, motion.place)
    else:
        unit = [force_on_slide(press, 1.0)]
        permitted = affine_forces(limits, idle, inverse_dynamics(without_masses(press), motion, unit, engine=engine, bearings=bearings))
    capped = {name: read_only(np.minimum(force, nominal)) for name, force in ({NOMINAL: nominal} | permitted).items()}
    return MotionRatings(
        _press=press,
        capacities=capacities,
        motion=motion,
        loads=tuple(loads),
        friction=FrozenMapping(friction),
        force=read_only(np.min(list(capped.values()), axis=0)),
        limits=FrozenMapping(capped),
        limited_by=governing_names(capped),
    )


def limits_in_words(ratings: MotionRatings) -> Inputs:
    """The capacities of a rating along a motion, by their names."""
    nominal = ratings.capacities.nominal_force
    limits = _limits(ratings._press, ratings.capacities)
    return [("nominal force", written(nominal, "N")), *((limit.name, written(limit.capacity, limit.unit)) for limit in limits)]


def _limits(press: Linkage, capacities: Capacities) -> list[Limit]:
    """The limits of drivers and bearings; raises as `rate_motion` for capacities that do not suit a motion."""
    bearings = [bearing_limit(name, capacities.bearings[name]) for name in known_bearings(capacities, press)]
    for name, instead in INSTEAD.items():
        if getattr(capacities, name) is not None:
            raise PinpressError(f"{name} is not a capacity along a given motion: {instead}")
    drivers = capacities.drivers
    if capacities.torque is not None:
        first = press.drivers[0]
        press.refuse_several_drivers(f"torque does not name a driver; give drivers={{{first!r}: {capacities.torque:g}}}")
        refuse_other_effort(capacities, press.driver_coordinates[0])
        drivers = {first: capacities.torque}
    for name in capacities.drivers:
        if name not in press.drivers:
            raise UnknownNameError("driver", name, press.drivers)
        refuse_other_effort(capacities, press.driver_coordinates[press.drivers.index(name)], name)
    return [*(driver_limit(press, name, drivers[name], named=True) for name in press.drivers if name in drivers), *bearings]
