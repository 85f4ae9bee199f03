"""The slide of an elastic press: its deflection over a motion, and its bottom dead centre over the speed.

The deflection is the displacement of the slide relative to the table along the guide's axis, positive along the axis (upwards), compared
with the rigid press at the same crank angle. It is a first-order result by virtual work, see `compliance`. It is quasi-static: the internal
forces are those of the rigid press in its motion, and vibrations of the slide are not included. So the speed must be well below the first
natural frequency.

Inertia forces grow with the square of the speed: at a given crank angle the deflection at a constant speed w is d0 + w^2 d2. Weight and
other constant forces cause d0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from ..common.arguments import LARGEST, numbers, typed
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..common.results import Tabular
from ..dynamics.between import path_of
from ..kinematics.cycle import doubt_speeds
from ..kinematics.motion import Motion
from ..kinematics.servo_motion import servo_cycle
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Load, Spring, StandingLoad, is_constant
from ..loads.pneumatics import BalanceCylinder
from .springs import Stiffness, springs_of
from .unit_load import HeldPress, hold

WINDOW = np.radians(6.0)  # half width of the window around the rigid bottom dead centre in which the elastic one is searched [rad]
NODES = 24  # Chebyshev nodes in this window


@dataclass(frozen=True, eq=False, repr=False)
class DeflectedSlide(Tabular):
    """Elastic deflection of the slide over a motion of n states. All arrays are read-only.

    Attributes:
        motion: motion of the rigid press.
        deflection: (n,) deflection of the slide along the guide's axis [m].
        parts: name of a part -> (n,) its share of the deflection [m].
        slide_position: (n,) slide position of the elastic press [m].
    """

    motion: Motion
    deflection: Array
    parts: Mapping[str, Array]
    slide_position: Array
    _found: tuple[Motion, Array]  # and its deflection, also in the states between, where it jumps or is largest

    @property
    def title(self) -> str:
        low, high = self._found[1].min(), self._found[1].max()
        return f"DeflectedSlide of {self.motion.linkage}: {len(self.deflection)} states, {low:.4g} to {high:.4g} m"

    def columns(self) -> dict[str, Array]:
        """A row for each state: crank angle (or coordinates of all drivers), slide position, deflection and the parts' shares."""
        columns = self.motion.position_columns() | {"slide_position [m]": self.slide_position}
        return columns | {"deflection [m]": self.deflection} | {f"deflection_{name} [m]": part for name, part in self.parts.items()}


@dataclass(frozen=True, eq=False, repr=False)
class ElasticDeadCentre(OfPress, Tabular):
    """Bottom dead centre of an elastic press over S speeds. Negative is deeper. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        speed: (S,) speeds of the crank [rad/s].
        rigid_angle: crank angle at bottom dead centre of the rigid press [rad].
        rigid_position: slide position of the rigid press at its bottom dead centre [m].
        constant: deflection d0 under weight and constant forces at this crank angle [m].
        by_squared_speed: deflection d2 by inertia at this crank angle / squared crank speed [m s2/rad2].
        crank_angle: (S,) crank angles at the elastic bottom dead centre, where the elastic slide is lowest [rad].
        position: (S,) positions of the elastic slide at these angles [m].
        standstill_position: position of the elastic slide at the elastic bottom dead centre of a press that turns infinitely slowly [m].
    """

    _press: Linkage
    speed: Array
    rigid_angle: float
    rigid_position: float
    constant: float
    by_squared_speed: float
    crank_angle: Array
    position: Array
    standstill_position: float

    @property
    def at_rigid_angle(self) -> Array:
        """(S,) deflection d0 + w^2 d2 with the crank at the rigid bottom dead centre [m]."""
        return self.constant + self.by_squared_speed * self.speed**2

    @property
    def shift(self) -> Array:
        """(S,) shift of bottom dead centre by the speed: position minus standstill_position [m]."""
        return self.position - self.standstill_position

    @property
    def title(self) -> str:
        return f"ElasticDeadCentre of {self.press_name}: {len(self.speed)} speeds, shift {self.shift.min():.4g} to {self.shift.max():.4g} m"

    def columns(self) -> dict[str, Array]:
        """A row for each speed: angle, position, shift, and deflection at the rigid angle."""
        return {
            "crank_speed [rad/s]": self.speed,
            "crank_angle [rad]": self.crank_angle,
            "slide_position [m]": self.position,
            "shift [m]": self.shift,
            "deflection_at_rigid_angle [m]": self.at_rigid_angle,
        }


@typed
def slide_deflection(press: Linkage, motion: Motion, stiffness: Stiffness, *, loads: Sequence[Load] = ()) -> DeflectedSlide:
    """Find the elastic deflection of the slide over a motion, under loads, weight and inertia.

    Args:
        press: a press with a slide, and one or several drivers, which are held at their coordinates in the motion.
        motion: a motion of this press, from `cycle`, `servo_cycle` or a run.
        stiffness: stiffnesses of its parts.
        loads: as for `inverse_dynamics`.

    Raises:
        PinpressError: as `compliance` and `inverse_dynamics`.
        UnknownNameError: as `compliance` and `inverse_dynamics`.
        SingularityError: the linkage locks.
    """
    springs = springs_of(press, stiffness)
    held = hold(press, springs, motion)
    shares = held.moved(held.in_motion(loads))
    deflection = np.sum(list(shares.values()), axis=0)
    path = path_of(motion, press, loads, {}, "auto")

    def along(between: Motion) -> list[tuple[Array, float]]:
        return [(_total(hold(press, springs, between), loads)[:, None], 0.0)]

    resolved, found = None if path is None else path.resolve(along), (motion, deflection)
    if resolved is not None:
        states = resolved.path.at(resolved.peak_times())
        found = states, along(states)[0][0][:, 0]
    return DeflectedSlide(motion, deflection, shares, motion.slide_position + deflection, found)


@typed
def dead_centre_shift(press: Linkage, stiffness: Stiffness, *, speed: ArrayLike, loads: Sequence[StandingLoad] = ()) -> ElasticDeadCentre:
    """Find the bottom dead centre of an elastic press at constant speeds, without process load.

    Args:
        press: a press with one driver and a slide.
        stiffness: stiffnesses of its parts.
        speed: (S,) speeds of the crank, or one number [rad/s].
        loads: constant forces, balance cylinders, and springs without dampers.

    Raises:
        UnknownNameError: as `compliance`.
        PinpressError: as `compliance`, or a speed is not finite, a load depends on the speed, the press is too soft to have a bottom dead
            centre within 6 degrees of the rigid one, or the slide has a shorter period than the other links.
    """
    press.refuse_sliding_driver("the dead centre moves with the speed of a crank; see slide_deflection of a motion")
    speeds = _speeds(speed)
    _refuse_dependent(loads)
    doubt_speeds(press, speeds)
    centres = dead_centres(press)
    if press.period_turns > centres.turns >= 1:
        raise PinpressError(
            f"the slide of {press.name} repeats its motion after {centres.turns} turns, other links only after {press.period_turns}: its"
            " bottom dead centre moves by another distance in each stroke; see slide_deflection of a motion"
        )
    nodes = centres.bottom_angle + WINDOW * chebyshev.chebpts1(NODES)
    angles = np.append(nodes, centres.bottom_angle)
    springs = springs_of(press, stiffness)
    at_rest, in_motion = (hold(press, springs, servo_cycle(press, speed=w, angle=angles)) for w in (0.0, 1.0))
    _refuse_open_joints(at_rest, in_motion, loads, float(np.abs(speeds).max()))
    rest, turning = _total(at_rest, loads), _total(in_motion, loads)
    constant, inertia = rest, turning - rest
    travel = servo_cycle(press, speed=1.0, angle=nodes).slide_position - centres.bottom_position
    curves = [_series(press, values) for values in (travel, constant[:-1], inertia[:-1])]

    def lowest(w: float) -> tuple[float, float]:
        """Crank angle and position of the lowest point at a speed."""
        place, depth = _minimum(press, curves[0] + curves[1] + w**2 * curves[2], w)
        return centres.bottom_angle + WINDOW * place, centres.bottom_position + depth

    points = np.array([lowest(w) for w in speeds])
    return ElasticDeadCentre(
        _press=press,
        speed=speeds,
        rigid_angle=centres.bottom_angle,
        rigid_position=centres.bottom_position,
        constant=float(constant[-1]),
        by_squared_speed=float(inertia[-1]),
        crank_angle=points[:, 0].copy(),
        position=points[:, 1].copy(),
        standstill_position=lowest(0.0)[1],
    )


def _minimum(press: Linkage, total: Array, speed: float) -> tuple[float, float]:
    """Argument and value of the minimum of a Chebyshev series inside (-1, 1).

    Raises:
        PinpressError: the minimum is at an end.
    """
    turns = chebyshev.chebroots(chebyshev.chebder(total))
    real = turns.real[(abs(turns.imag) < 1e-6) & (abs(turns.real) < 1.0)]
    depths = chebyshev.chebval(real, total)
    ends = chebyshev.chebval(np.array([-1.0, 1.0]), total)
    if not len(real) or not depths.min() < ends.min():
        raise PinpressError(
            f"{press.name} is too soft for {speed:.5g} rad/s: no bottom dead centre within 6 deg of the rigid one; check the stiffness"
        )
    return float(real[depths.argmin()]), float(depths.min())


def _total(held: HeldPress, loads: Sequence[Load]) -> Array:
    """Deflection (n,) of the slide under loads [m]."""
    return np.asarray(np.sum(list(held.moved(held.in_motion(loads)).values()), axis=0))


def _refuse_open_joints(at_rest: HeldPress, in_motion: HeldPress, loads: Sequence[Load], fastest: float) -> None:
    """Raise PinpressError if a preloaded joint opens near bottom dead centre at the fastest speed [rad/s], because then deflections are no
    longer linear in the squared speed."""
    if not any(part.joint for part in at_rest.springs):
        return
    for part, still, turning in zip(at_rest.springs, at_rest.in_motion(loads), in_motion.in_motion(loads), strict=True):
        if part.opens(still) or part.opens(still + fastest**2 * (turning - still)):
            raise PinpressError(
                f"the joint of {part.name} opens by {fastest:.5g} rad/s: give it more preload, or see slide_deflection of a motion"
            )


def _series(press: Linkage, values: Array) -> Array:
    """Chebyshev coefficients (NODES,) of a function with these values at the nodes.

    Raises:
        PinpressError: the nodes do not resolve it.
    """
    coefficients = np.asarray(chebyshev.chebvander(chebyshev.chebpts1(NODES), NODES - 1).T @ values * (2 / NODES))
    coefficients[0] *= 0.5
    # the last coefficients estimate the error
    if not np.abs(coefficients[-3:]).max() <= 1e-9 * max(np.abs(coefficients).max(), np.finfo(float).tiny):
        raise PinpressError(f"{press.name} moves too unevenly near bottom dead centre to find its shift: the linkage is close to locking")
    return coefficients


def _speeds(speed: ArrayLike) -> Array:
    speeds = np.atleast_1d(numbers("speed", speed, unit="rad/s"))
    if speeds.ndim != 1 or not len(speeds):
        raise PinpressError(f"speed has shape {speeds.shape}: give (S,) speeds of the crank [rad/s]")
    if not np.abs(speeds).max() <= LARGEST:
        raise PinpressError(f"speed is {np.abs(speeds).max():g}: give rad/s, {LARGEST:g} at most")
    return speeds


def _refuse_dependent(loads: Sequence[StandingLoad]) -> None:
    for load in loads if isinstance(loads, list | tuple) else [loads]:
        spring = isinstance(load, BalanceCylinder) or (isinstance(load, Spring) and load.damping == 0.0)
        if not spring and not is_constant(load):
            raise PinpressError(
                f"load {shown(load)} may depend on the speed: give constant PointForces and PointMoments, BalanceCylinders, and springs"
                " without damping"
            )
