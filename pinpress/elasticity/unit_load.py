"""Elastic compliance of a press at its slide, part by part, by the unit-load method.

The crank is held at its angle. Under a force F on the slide along its guide, positive along the axis (upwards), with its reaction on the
table, the slide moves by F c beside the rigid press, c = sum of n . n / k over all parts: k their stiffnesses, n their internal forces
under F = 1 N. (Castigliano's second theorem; any textbook of strength of materials.) Deflections are of first order.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.frozen import FrozenMapping, read_only
from ..common.quantities import Array
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..kinematics.motion import Motion, servo_cycle
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage
from ..loads.link import Load, PointForce
from .springs import Part, Stiffness, internal_forces, parts, sharing

RIGID = 1e-12  # of the largest compliance over the motion: less is rounding
POINTS = 360  # of a turn
UNSHARED = 1e-9  # of a deflection: what it may err by
NOTHING_IDLE = 1e-16  # of the work of a force on the slide on itself: idle forces that do less are rounding
SOFT = 1e9  # stiffness of a bearing without one, to share forces otherwise [N/m]


@dataclass(frozen=True, eq=False, repr=False)
class SlideCompliance(Tabular):
    """Compliance of a press at its slide, over n crank angles. All arrays are read-only.

    Attributes:
        press_name: of the press.
        stiffness: what yields.
        crank_angle: (n,) of the driver joint [rad].
        slide_position: (n,) of the rigid press [m].
        height: (n,) of the slide above bottom dead centre [m].
        compliance: (n,) of the slide against the table along the guide, the crank held [m/N].
        parts: name of a part -> (n,) its share of the compliance [m/N].
        bottom_stiffness: stiffness at bottom dead centre [N/m].
        bottom_shares: name of a part -> its share of the deflection there [-].
    """

    press_name: str
    stiffness: Stiffness
    crank_angle: Array
    slide_position: Array
    height: Array
    compliance: Array
    parts: Mapping[str, Array]
    bottom_stiffness: float
    bottom_shares: Mapping[str, float]
    _held: HeldPress

    @property
    def title(self) -> str:
        return f"SlideCompliance of {self.press_name}: {self.bottom_stiffness:.4g} N/m at bottom dead centre"

    def __str__(self) -> str:
        heading = f"{self.press_name}: stiffness at bottom dead centre {1e-6 * self.bottom_stiffness:.5g} kN/mm, of its deflection"
        width = max(map(len, self.bottom_shares))
        most_first = sorted(self.bottom_shares.items(), key=lambda item: -round(item[1], 9))  # equal ones differ by rounding
        return "\n".join([heading, *(f"  {name:<{width}}  {100 * share:6.2f} %" for name, share in most_first)])

    @cached_property
    def effective_mass(self) -> Array:
        """(n,) mass of the slide and what moves with it while the press yields, the crank held [kg].

        It is twice the kinetic energy at a slide velocity of 1 m/s when everything moves in proportion to the deflection under a force on
        the slide (Rayleigh's method). The frame's own mass is not in it. It is computed when it is first asked for.
        """
        return np.asarray(read_only(_moving_mass(self._held) / self.compliance**2))

    def columns(self) -> dict[str, Array]:
        """Angle, position, height, compliance and its parts as (n,) columns under their names with units."""
        columns = {"crank_angle [rad]": self.crank_angle, "slide_position [m]": self.slide_position, "height [m]": self.height}
        return columns | {"compliance [m/N]": self.compliance} | {f"{name} [m/N]": part for name, part in self.parts.items()}


@typed
def compliance(press: Linkage, stiffness: Stiffness, *, angle: ArrayLike | None = None) -> SlideCompliance:
    """Compliance of a press at its slide over the crank angle, and which part gives how much.

    Where loops hold the slide several times over, parallel rods share the force as their stiffness and that of their bearings asks. A
    guide's moment, or an arm of a link with more than two bearings, takes no part in that; where it should, this is refused.

    Args:
        press: with one driver and a slide.
        stiffness: of its parts.
        angle: (n,) crank angles [rad]; by default 360 a turn of one period, its end left out.

    Raises:
        UnknownNameError: a bearing or link that the linkage does not have.
        PinpressError: a stiffness that makes no sense, several drivers, no dead centres, a crank angle at which nothing yields, forces
            shared by what takes no part in that.
        SingularityError: the linkage locks.
    """
    parts(press, stiffness)  # refuses what makes no sense before anything is computed
    centres = dead_centres(press)
    angles = np.arange(POINTS * press.period_turns) * (2 * np.pi / POINTS) if angle is None else angle
    motion = servo_cycle(press, speed=0.0, angle=angles)
    held = hold(press, stiffness, motion)
    shares = held.moved(held.unit)
    total = np.sum(list(shares.values()), axis=0)
    bottom = _compliances_at(press, stiffness, centres.bottom_angle)
    at_bottom = sum(bottom.values())
    if not total.min() > RIGID * max(float(total.max()), at_bottom) or not at_bottom > RIGID * total.max():
        where = np.degrees(motion.crank_angle[int(total.argmin())] if at_bottom > RIGID * total.max() else centres.bottom_angle)
        raise PinpressError(f"nothing of {press.name} yields at crank angle {where:.6g} deg: give a part in the line of force a stiffness")
    return SlideCompliance(
        press_name=press.name,
        stiffness=stiffness,
        crank_angle=motion.crank_angle,
        slide_position=motion.slide_position,
        height=motion.slide_position - centres.bottom_position,
        compliance=total,
        parts=FrozenMapping(shares),
        bottom_stiffness=1 / at_bottom,
        bottom_shares=FrozenMapping({name: share / at_bottom for name, share in bottom.items()}),
        _held=held,
    )


def _compliances_at(press: Linkage, stiffness: Stiffness, angle: float) -> dict[str, float]:
    """Compliances of the parts [m/N] at one crank angle [rad]."""
    held = hold(press, stiffness, servo_cycle(press, speed=0.0, angle=[angle]))
    return {name: float(share[0]) for name, share in held.moved(held.unit).items()}


@dataclass(frozen=True, eq=False, repr=False)
class HeldPress:
    """A press in the poses of a motion, its crank held there against what the deflection does.

    Attributes:
        press: the press.
        springs: its parts.
        motion: whose poses they are.
        shared: stiffnesses by which bearings share forces, see `springs.sharing`.
    """

    press: Linkage
    springs: tuple[Part, ...]
    motion: Motion
    shared: Mapping[str, float]

    @cached_property
    def unloaded(self) -> list[Array]:
        """Internal forces under weight and inertia alone, at the speeds of the motion [N, N m]."""
        return self.in_motion([])

    @cached_property
    def size(self) -> float:
        """Of a load beside which weight and inertia do not drown it in rounding [N]."""
        return max([1.0, *(float(np.abs(force).max()) for force in self.unloaded)])

    @cached_property
    def unit(self) -> list[Array]:
        """Internal forces under 1 N on the slide along its guide [N, N m]."""
        guide, _ = self.press.slide_guide
        axis = self.press.model.jointPlacements[guide + 1].rotation @ self.press.axes[guide].direction
        return self.under(str(self.press.slide), axis, np.zeros(3))

    def under(self, link: str, direction: Array, point: Array) -> list[Array]:
        """Internal forces that 1 N adds, in a world direction at a point of a link: they are linear in loads."""
        load = PointForce(link, self.size * direction, (float(point[0]), float(point[1]), float(point[2])))
        return [(loaded - none) / self.size for loaded, none in zip(self.in_motion([load]), self.unloaded, strict=True)]

    def moved(self, forces: Sequence[Array]) -> dict[str, Array]:
        """Name of a part -> (n,) what it adds to the slide's position under internal forces [m]."""
        return {
            part.name: np.asarray(part.compliance * np.einsum("nk,nk->n", n, force))
            for part, n, force in zip(self.springs, self.unit, forces, strict=True)
        }

    def in_motion(self, loads: Sequence[Load]) -> list[Array]:
        """Internal forces under loads, weight and inertia, at the speeds of the motion."""
        reactions = inverse_dynamics(self.press, self.motion, loads, stiffness=self.shared)
        return internal_forces(self.press, self.springs, self.motion, reactions)


def hold(press: Linkage, stiffness: Stiffness, motion: Motion) -> HeldPress:
    """The press in the poses of a motion; raises as `springs.parts`, or where parallel rods would share as moments or arms ask."""
    springs = parts(press, stiffness)
    held = HeldPress(press, springs, motion, sharing(press, springs))
    apart = any(part.kind == "moment" or (part.kind == "rod" and len(part.bearings) == 1) for part in springs)
    if apart and press.engine().redundant(press.closed):
        _refuse_unshared(held)
    return held


def _refuse_unshared(held: HeldPress) -> None:
    """Raise where idle forces do work on the deflection of the parts: the forces are then not those of the elastic press.

    Idle forces z are the difference between two ways of sharing; the error of the deflection is (N . z)^2 / (z . z) beside N . N, all by
    compliance.
    """
    compliances = [part.compliance for part in held.springs]

    def work(one: Sequence[Array], another: Sequence[Array]) -> Array:
        return np.asarray(sum(c * np.einsum("nk,nk->n", a, b) for c, a, b in zip(compliances, one, another, strict=True)))

    for name in held.press.bearings:
        otherwise = replace(held, shared={**held.shared, name: 0.5 * held.shared.get(name, SOFT)})
        idle = [one - another for one, another in zip(otherwise.unit, held.unit, strict=True)]
        size = work(idle, idle)
        for forces in (held.unit, held.unloaded):
            done, whole = work(forces, idle), work(forces, forces)
            there = (size > NOTHING_IDLE * work(held.unit, held.unit)) & (whole > 0.0)
            if np.any(done[there] ** 2 > UNSHARED * size[there] * whole[there]):
                raise PinpressError(
                    f"parallel rods of {held.press.name} do not share forces by their springs and their bearings' alone: make both sides"
                    " alike, or leave out the guides' moments and arms"
                )


def _moving_mass(held: HeldPress) -> Array:
    """(n,) sum of mass times squared displacement under 1 N on the slide [kg m2/N2].

    A rigid body moves as six equal masses would, two on each of its central axes (equimomental bodies): their displacements in world axes
    are found by unit forces at them.
    """
    press, total = held.press, np.zeros(len(held.motion.crank_angle))
    directions = press.engine().directions
    for joint in range(1, press.model.njoints):
        inertia = press.model.inertias[joint]
        if not inertia.mass > 0:
            continue
        link = press.link_of(joint)
        frame = press.model.frames[press.model.getFrameId(link, pin.BODY)].placement
        second = 0.5 * np.trace(inertia.inertia) * np.eye(3) - inertia.inertia  # integral of r r^T about the centre of mass
        moments, axes = np.linalg.eigh(second)
        for arm in np.sqrt(3 / inertia.mass * np.maximum(moments, 0.0))[:, None] * axes.T:
            for point, direction in itertools.product((inertia.lever + arm, inertia.lever - arm), directions):
                moved = held.moved(held.under(link, direction, frame.actInv(point)))
                total += inertia.mass / 6 * np.sum(list(moved.values()), axis=0) ** 2
    return total
