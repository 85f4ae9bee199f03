"""Where the slide of an elastic press is: its deflection over a motion, and how bottom dead centre moves with the speed.

The deflection is that of the slide against the table along the guide's axis, positive along the axis (upwards), beside the rigid press with
its crank at the same angle; of first order, by virtual work, see `compliance`. The slide's own vibrations are not in it: internal forces
are those of the rigid press in its motion (quasi-static deflection, for speeds well below the first natural frequency).

Inertia forces grow with the square of the speed: at a given crank angle the deflection of a press at constant speed w is d0 + w^2 d2, d0
that of weight and other constant forces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import LARGEST, numbers, typed
from ..common.errors import PinpressError, shown
from ..common.quantities import RPM, Array
from ..common.results import Tabular
from ..kinematics.motion import Motion, servo_cycle
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage
from ..loads.link import Load, PointForce, SpringDamper
from .springs import Stiffness
from .unit_load import HeldPress, hold

WINDOW = np.radians(6.0)  # on both sides of the rigid bottom dead centre, in which the elastic one is looked for [rad]
NODES = 24  # of the polynomials in it
UNRESOLVED = 1e-9  # of a polynomial's largest coefficient: what its last ones may be


@dataclass(frozen=True, eq=False, repr=False)
class DeflectedSlide(Tabular):
    """Elastic deflection of the slide over a motion of n states. All arrays are read-only.

    Attributes:
        motion: of the rigid press.
        deflection: (n,) of the slide along the guide's axis [m].
        parts: name of a part -> (n,) its share of the deflection [m].
        slide_position: (n,) of the elastic press [m].
    """

    motion: Motion
    deflection: Array
    parts: Mapping[str, Array]
    slide_position: Array

    @property
    def title(self) -> str:
        low, high = self.deflection.min(), self.deflection.max()
        return f"DeflectedSlide of {self.motion.linkage}: {len(self.deflection)} states, {low:.4g} to {high:.4g} m"

    def __str__(self) -> str:
        low, high = int(self.deflection.argmin()), int(self.deflection.argmax())
        angles = np.degrees(self.motion.crank_angle)
        return (
            f"{self.motion.linkage}: slide deflected by {1e3 * self.deflection[low]:.5g} mm (crank angle {angles[low]:.5g} deg)"
            f" to {1e3 * self.deflection[high]:.5g} mm ({angles[high]:.5g} deg)"
        )

    def columns(self) -> dict[str, Array]:
        """The motion's crank angle, then positions and deflections as (n,) columns under their names with units."""
        columns = {"crank_angle [rad]": self.motion.crank_angle, "slide_position [m]": self.slide_position}
        return columns | {"deflection [m]": self.deflection} | {f"deflection_{name} [m]": part for name, part in self.parts.items()}


@dataclass(frozen=True, eq=False, repr=False)
class ElasticDeadCentre(Tabular):
    """Bottom dead centre of an elastic press over S speeds. Deeper is negative. All arrays are read-only.

    Attributes:
        press_name: of the press.
        speed: (S,) of the crank [rad/s].
        rigid_angle: of the crank at bottom dead centre of the rigid press [rad].
        rigid_position: of its slide there [m].
        constant: d0, deflection under weight and constant forces with the crank there [m].
        by_squared_speed: d2, deflection there by the squared speed of the crank [m s2/rad2].
        crank_angle: (S,) at true bottom dead centre, where the elastic slide is lowest [rad].
        position: (S,) of the elastic slide there [m].
        standstill_position: of the elastic slide at the true bottom dead centre of a press that turns infinitely slowly [m].
    """

    press_name: str
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
        """(S,) what speed moves bottom dead centre by: true position less that at standstill [m]."""
        return self.position - self.standstill_position

    @property
    def title(self) -> str:
        return f"ElasticDeadCentre of {self.press_name}: {len(self.speed)} speeds, shift {self.shift.min():.4g} to {self.shift.max():.4g} m"

    def __str__(self) -> str:
        standing = 1e3 * (self.standstill_position - self.rigid_position)
        rows = [f"{self.press_name}: bottom dead centre {standing:+.5g} mm off the rigid one at standstill"]
        rows += [f"  {w / RPM:8.4g} strokes/min  {1e3 * s:+.5f} mm" for w, s in zip(self.speed, self.shift, strict=True)]
        return "\n".join(rows)

    def columns(self) -> dict[str, Array]:
        """Speed, angle, position, shift and deflection at the rigid angle as (S,) columns under their names with units."""
        return {
            "crank_speed [rad/s]": self.speed,
            "crank_angle [rad]": self.crank_angle,
            "slide_position [m]": self.position,
            "shift [m]": self.shift,
            "deflection_at_rigid_angle [m]": self.at_rigid_angle,
        }


@typed
def slide_deflection(press: Linkage, motion: Motion, stiffness: Stiffness, *, loads: Sequence[Load] = ()) -> DeflectedSlide:
    """Elastic deflection of the slide over a motion, under loads, weight and inertia.

    Args:
        press: with one driver and a slide.
        motion: of this press, by `cycle` or of a run.
        stiffness: of its parts.
        loads: as of `inverse_dynamics`.

    Raises:
        PinpressError: as `compliance` and `inverse_dynamics`.
        UnknownNameError: as `compliance` and `inverse_dynamics`.
        SingularityError: the linkage locks.
    """
    held = hold(press, stiffness, motion)
    shares = held.moved(held.in_motion(loads))
    deflection = np.sum(list(shares.values()), axis=0)
    position = motion.slide_position + deflection
    return DeflectedSlide(motion, deflection, shares, position)


@typed
def dead_centre_shift(
    press: Linkage, stiffness: Stiffness, *, speed: ArrayLike, loads: Sequence[PointForce | SpringDamper] = ()
) -> ElasticDeadCentre:
    """How deep the slide of an elastic press goes at constant speeds, without process load.

    Args:
        press: with one driver and a slide.
        stiffness: of its parts.
        speed: (S,) of the crank, or one number [rad/s].
        loads: constant forces, and springs without dampers, such as those that balance the slide's weight.

    Raises:
        PinpressError: a speed that is not finite, a load that depends on the speed, a press so soft that it has no bottom dead centre
            within 6 degrees of the rigid one, a slide that is back before all that moves with it; else as `compliance`.
    """
    speeds = _speeds(speed)
    _refuse_dependent(loads)
    centres = dead_centres(press)
    if press.period_turns != centres.turns:
        raise PinpressError(
            f"the slide of {press.name} is back after {centres.turns} turns, all that moves with it only after {press.period_turns}: its"
            " bottom dead centre moves by another distance in each stroke; see slide_deflection of a motion"
        )
    series = np.polynomial.chebyshev
    nodes = centres.bottom_angle + WINDOW * series.chebpts1(NODES)
    angles = np.append(nodes, centres.bottom_angle)
    rest, turning = (_total(hold(press, stiffness, servo_cycle(press, speed=w, angle=angles)), loads) for w in (0.0, 1.0))
    constant, inertia = rest, turning - rest
    way = servo_cycle(press, speed=1.0, angle=nodes).slide_position - centres.bottom_position
    curves = [_series(press, values) for values in (way, constant[:-1], inertia[:-1])]

    def lowest(w: float) -> tuple[float, float]:
        """Crank angle and position of the lowest point."""
        total = curves[0] + curves[1] + w**2 * curves[2]
        turns = series.chebroots(series.chebder(total))
        real = turns.real[(abs(turns.imag) < 1e-6) & (abs(turns.real) < 1.0)]
        depths = series.chebval(real, total)
        ends = series.chebval(np.array([-1.0, 1.0]), total)
        if not len(real) or not depths.min() < ends.min():
            raise PinpressError(
                f"{press.name} is too soft for {w:.5g} rad/s: no bottom dead centre within 6 deg of the rigid one; check the stiffness"
            )
        return centres.bottom_angle + WINDOW * float(real[depths.argmin()]), centres.bottom_position + float(depths.min())

    found = np.array([lowest(w) for w in speeds])
    return ElasticDeadCentre(
        press_name=press.name,
        speed=speeds,
        rigid_angle=centres.bottom_angle,
        rigid_position=centres.bottom_position,
        constant=float(constant[-1]),
        by_squared_speed=float(inertia[-1]),
        crank_angle=found[:, 0].copy(),
        position=found[:, 1].copy(),
        standstill_position=lowest(0.0)[1],
    )


def _total(held: HeldPress, loads: Sequence[Load]) -> Array:
    return np.asarray(np.sum(list(held.moved(held.in_motion(loads)).values()), axis=0))


def _series(press: Linkage, values: Array) -> Array:
    """Chebyshev coefficients (NODES,) of what has these values at the nodes."""
    series = np.polynomial.chebyshev
    found = np.asarray(series.chebvander(series.chebpts1(NODES), NODES - 1).T @ values * (2 / NODES))
    found[0] *= 0.5
    if not np.abs(found[-3:]).max() <= UNRESOLVED * max(np.abs(found).max(), np.finfo(float).tiny):
        raise PinpressError(f"{press.name} moves too unevenly about bottom dead centre for its shift to be found: a linkage near its lock")
    return found


def _speeds(speed: ArrayLike) -> Array:
    speeds = np.atleast_1d(numbers("speed", speed))
    if speeds.ndim != 1 or not len(speeds):
        raise PinpressError(f"speed has shape {speeds.shape}: give (S,) speeds of the crank [rad/s]")
    if not np.abs(speeds).max() <= LARGEST:
        raise PinpressError(f"speed is {np.abs(speeds).max():g}: give rad/s, {LARGEST:g} at most")
    return speeds


def _refuse_dependent(loads: Sequence[PointForce | SpringDamper]) -> None:
    for load in loads if isinstance(loads, list | tuple) else [loads]:
        spring = isinstance(load, SpringDamper) and load.damping == 0.0
        if not spring and not (isinstance(load, PointForce) and not callable(load.force) and np.shape(load.force) == (3,)):
            raise PinpressError(f"load {shown(load)} may depend on the speed: give constant PointForces and SpringDampers without damping")
