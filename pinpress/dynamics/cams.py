"""Cams under load: contact force, pressure angle, curvature and Hertzian pressure, and the speed at which the roller leaves the cam."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError, UnknownNameError
from ..common.quantities import Array
from ..common.results import Tabular
from ..engines.machine_elements.cams import TURN, CamContact
from ..kinematics.cycle import moved
from ..kinematics.motion import Motion, blank, finite, is_constant
from ..linkage.linkage import Linkage, OfPress, is_same_press, told_apart
from .extremes import between_states
from .inverse_dynamics import in_other_states
from .reactions import Reactions

MODULUS, POISSON = 2.1e11, 0.3  # of steel [Pa, -]
AT_REST = 1e-4  # share of the speed that is used as rest: inertia forces are nearly zero, and friction still has its sign
NEGLIGIBLE = 1e-12  # share by which rounding errors let the effort of a cam fall with the speed
CONVERGED, MOST_STEPS = 1e-9, 60  # for the speed of lift-off: relative change at which the search ends, and largest number of speeds


@dataclass(frozen=True, eq=False, repr=False)
class CamReactions(Tabular, OfPress):
    """A cam and the roller of its follower over a motion of n states, see `cam`.

    Angles are those of the cam's law. Extremes of forces and pressures are those of the whole motion: at the corners of the law and the
    steps of loads they are the limits on both sides, and smooth peaks are found between the states. Each extreme comes with its angle, 0 to
    2 pi.

    Attributes:
        motion: the motion.
        name: of the cam.
        grooved: whether the roller is in a groove, which holds it on both sides.
        angle: (n,) 0 to 2 pi [rad].
        lift: (n,) of the follower [m; of an arm rad].
        pressure_angle: (n,) from the way of the roller to the force of the cam, positive against the cam's sense of rotation [rad].
        pitch_radius: (n,) radius of curvature of the path of the roller's centre on the cam [m]; negative where the cam is hollow.
        surface_radius: (n,) radius of curvature of the surface that the roller touches without a groove [m].
        force: (n,) contact force [N]; positive: the cam pushes the roller away.
        effort: (n,) force along the guide, or moment about the pivot, that the cam exerts on the follower [N; of an arm N m].
        cam_torque: (n,) torque that turns the cam against the contact force [N m].
        pressure: (n,) Hertzian pressure of the line contact, cam and roller of steel [Pa]; 0 where the cam does not push a roller without a
            groove.
        largest_pressure_angle: largest size of the pressure angle over a turn of the cam [rad], and where; without a groove only over the
            rises, where the cam drives its follower.
        least_radius: least radius of the convex surface over a turn of the cam [m], and where.
        largest_force: the force of the largest size, with its sign [N], and where.
        least_force: [N], and where. Below 0 the roller leaves a cam without a groove, and the forces are not those of the press.
        largest_pressure: [Pa], and where.
        lift_off_speed: speed of the driver at which the least force is 0 under the same loads [rad/s]; 0 if the cam does not push the
            roller at rest. None in a groove, if no speed lifts the roller off, if the motion has no constant speed of one driver, and if
            the search does not converge because loads change with the speed.
    """

    motion: Motion
    name: str
    grooved: bool
    angle: Array
    lift: Array
    pressure_angle: Array
    pitch_radius: Array
    surface_radius: Array
    force: Array
    effort: Array
    cam_torque: Array
    pressure: Array
    largest_pressure_angle: tuple[float, float]
    least_radius: tuple[float, float]
    largest_force: tuple[float, float]
    least_force: tuple[float, float]
    largest_pressure: tuple[float, float]
    lift_off_speed: float | None
    _press: Linkage

    @property
    def arm(self) -> bool:
        """Whether the follower is on an arm, so that lifts are angles."""
        return bool(_contact(self._press, self.name).arm)

    @property
    def title(self) -> str:
        forces = f"contact force {self.least_force[0]:.6g} to {self.largest_force[0]:.6g} N"
        return f"CamReactions of {self.name} in {self.press_name}: {len(self.angle)} states, {forces}"

    def columns(self) -> dict[str, Array]:
        """The driver's coordinate, then all quantities of the cam under their names with units."""
        lift, effort = ("rad", "N m") if self.arm else ("m", "N")
        units = {"angle": "rad", "lift": lift, "pressure_angle": "rad", "pitch_radius": "m", "surface_radius": "m", "force": "N"}
        units |= {"effort": effort, "cam_torque": "N m", "pressure": "Pa"}
        return self.motion.position_columns() | {f"{name} [{unit}]": getattr(self, name) for name, unit in units.items()}


@typed
def cam(press: Linkage, reactions: Reactions, name: str) -> CamReactions:
    """Find pressure angle, curvature, contact force and Hertzian pressure of a cam, and the speed at which its roller leaves it.

    Args:
        press: the press.
        reactions: its reactions to a motion.
        name: of the cam.

    Raises:
        UnknownNameError: the press has no cam of this name.
        PinpressError: the reactions are of another press, or a force is not finite.
    """
    contact = _contact(press, name)
    if not is_same_press(press, reactions._press):
        raise PinpressError(f"the reactions are of {told_apart(reactions._press, press)}: give reactions of {press.name}")
    states = _states(contact, reactions)
    finite(f"force in {name}", states.force)
    peaks = _states(contact, between_states(reactions, lambda each: _resolvable(_states(contact, each))).peak_states().reactions)
    geometry = contact.at(states.angle)
    with np.errstate(divide="ignore"):
        pitch_radius = 1.0 / geometry.curvature
    curvature, sharpest = contact.largest(lambda each: each.curvature)
    return CamReactions(
        motion=reactions.motion,
        name=name,
        grooved=contact.grooved,
        angle=states.angle % TURN,
        lift=geometry.lift,
        pressure_angle=geometry.pressure_angle,
        pitch_radius=pitch_radius,
        surface_radius=pitch_radius - contact.roller_radius,
        force=states.force,
        effort=states.effort,
        cam_torque=states.torque,
        pressure=states.pressure,
        largest_pressure_angle=contact.largest_pressure_angle(_way(reactions.motion.v[:, contact.curve.joint])),
        least_radius=(1.0 / curvature - contact.roller_radius if curvature > 0.0 else math.inf, sharpest),
        largest_force=_extreme(peaks, peaks.force, lambda force: np.abs(force).argmax()),
        least_force=_extreme(peaks, peaks.force, np.argmin),
        largest_pressure=_extreme(peaks, peaks.pressure, np.argmax),
        lift_off_speed=None if contact.grooved else _lift_off_speed(contact, reactions),
        _press=press,
    )


class _States(NamedTuple):
    """Angle of the law, contact force, effort on the follower, torque on the cam and Hertzian pressure in n states: (n,) each."""

    angle: Array
    force: Array
    effort: Array
    torque: Array
    pressure: Array


def _contact(press: Linkage, name: str) -> CamContact:
    cams = {contact.name: contact for contact in press.contacts if isinstance(contact, CamContact)}
    if not isinstance(name, str) or name not in cams:
        raise UnknownNameError("cam", name, cams)
    return cams[name]


def _states(contact: CamContact, reactions: Reactions) -> _States:
    motion = reactions.motion
    angle = contact.angle(motion.joint_position.T)
    geometry, effort = contact.at(angle), _effort(contact, reactions)
    force = effort / geometry.leverage
    curvature = np.where(force >= 0.0, 1.0, -1.0) * geometry.curvature  # of the flank that the roller touches
    relative = 1.0 / contact.roller_radius + curvature / (1.0 - curvature * contact.roller_radius)
    pushing = np.abs(force) if contact.grooved else np.maximum(force, 0.0)
    pressure = np.sqrt(pushing * MODULUS * relative / (2 * np.pi * (1.0 - POISSON**2) * contact.roller_width))
    return _States(angle, force, effort, effort * geometry.slope, pressure)


def _resolvable(states: _States) -> Iterator[tuple[Array, float]]:
    """What is resolved between states; the square of the pressure, which has no slope where the force begins."""
    yield from ((values[:, None], 0.0) for values in (states.force, states.effort, states.torque, states.pressure**2))


def _effort(contact: CamContact, reactions: Reactions) -> Array:
    """Effort (n,) of the cam on its follower, positive away from the cam [N; of an arm N m]."""
    return contact.sense * blank(reactions.motion, reactions._complete.relations[contact.relation])


def _way(rate: Array) -> float:
    """1 or -1 if a joint turns one way at these rates (n,), else 0."""
    return float(np.sign(rate.min()) if np.sign(rate.min()) == np.sign(rate.max()) else 0.0)


def _extreme(states: _States, values: Array, choose: Callable[[Array], np.intp]) -> tuple[float, float]:
    k = int(choose(values))
    return float(values[k]), float(states.angle[k] % TURN)


def _lift_off_speed(contact: CamContact, reactions: Reactions) -> float | None:
    """The speed of the driver at which the least effort on the follower is 0.

    Inertia forces grow with the square of the speed, so the efforts at two speeds give the efforts at all other speeds. If loads change
    with the speed, this step is repeated at the speed found.
    """
    motion, press = reactions.motion, reactions._press
    if len(press.drivers) > 1 or not is_constant(motion.crank_speed) or not motion.crank_speed.any():
        return None

    def at_rest_and_need(each: Reactions, share: float) -> tuple[Array, Array]:
        """Efforts at rest, and the inverse square of the share of the speed at which each effort becomes zero."""
        trials = (in_other_states(each, _at_other_speed(press, each.motion, part)) for part in (AT_REST, share))
        rest, fast = (_effort(contact, trial) for trial in trials)
        return rest, (rest - fast) / (share**2 * np.where(rest > 0.0, rest, 1.0))

    share = 1.0
    for _ in range(MOST_STEPS):
        trial = share

        def efforts(each: Reactions, trial: float = trial) -> Iterator[tuple[Array, float]]:
            yield from ((values[:, None], 0.0) for values in at_rest_and_need(each, trial))

        peaks = between_states(reactions, efforts).peak_states().reactions
        for step in range(MOST_STEPS):
            rest, need = at_rest_and_need(peaks, share)
            if rest.min() <= 0.0:
                return 0.0
            if need.max() * share**2 <= NEGLIGIBLE:
                return None
            led_to, share = share, float(need.max() ** -0.5)
            if abs(share - led_to) > CONVERGED * share:
                continue
            if step <= 1:  # no load changes with the speed, or the peaks are those at this speed already
                return share * float(abs(motion.crank_speed[0]))
            break
    return None


def _at_other_speed(press: Linkage, motion: Motion, share: float) -> Motion:
    """The same positions at the same times, with the speeds multiplied by a factor ``share``."""
    speed, acceleration = share * motion.crank_speed, share**2 * motion.crank_acceleration
    return moved(press, press.branch_through_change_points, motion.crank_angle, speed, acceleration, motion._time, "auto")
