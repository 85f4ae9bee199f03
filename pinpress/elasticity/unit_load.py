"""Elastic compliance of a press at its slide, part by part, by the unit-load method.

The crank is held at its angle. A force F acts on the slide along its guide, positive along the axis (upwards), and its reaction acts on the
table. It moves the slide by F c relative to the rigid press. The compliance c is the sum of n . n / k over all parts, with their
stiffnesses k and their internal forces n under F = 1 N (Castigliano's second theorem; see any textbook on strength of materials).
Deflections are of first order.
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
from ..common.quantities import Array, DriverCoordinate
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..kinematics.motion import Motion
from ..kinematics.servo_motion import servo_cycle
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Load, PointForce
from .springs import Spring, Stiffness, internal_forces, sharing, springs_of

RIGID = 1e-12  # a compliance below this share of the largest over the motion is a rounding error
POINTS = 360  # states of a turn
SOFT = 1e9  # stiffness of a rigid bearing in a trial that shares forces differently [N/m]


@dataclass(frozen=True, eq=False, repr=False)
class SlideCompliance(OfPress, Tabular):
    """Compliance of a press at its slide, over n crank angles. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        stiffness: stiffnesses of its parts.
        crank_angle: (n,) angle of the driver joint [rad]; position of a sliding driver [m].
        slide_position: (n,) slide position of the rigid press [m].
        height: (n,) height of the slide above bottom dead centre [m].
        compliance: (n,) compliance of the slide relative to the table along the guide, with the crank held [m/N].
        parts: name of a part -> (n,) its share of the compliance [m/N].
        bottom_stiffness: stiffness at bottom dead centre [N/m].
        bottom_shares: name of a part -> its share of the deflection at bottom dead centre [-].
    """

    _press: Linkage
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

    @property
    def coordinate(self) -> DriverCoordinate:
        """Kind of the driver's coordinate."""
        return self._held.press.driver_coordinates[0]

    @cached_property
    def effective_mass(self) -> Array:
        """(n,) effective mass of the slide and of the links that move with it in elastic deflection, with the crank held [kg].

        It is twice the kinetic energy at a slide velocity of 1 m/s when everything moves in proportion to the deflection under a force on
        the slide (Rayleigh's method). It does not include the frame's mass. It is computed at the first access.
        """
        return np.asarray(read_only(_moving_mass(self._held) / self.compliance**2))

    def largest_parts(self, most: int) -> list[tuple[str, Array]]:
        """Names and compliances (n,) of up to ``most`` parts [m/N], and of all others together as "others".

        The part with the largest share of the compliance at any crank angle comes first. Parts that never reach 0.5 % of the largest
        compliance are left out.
        """
        shares = {name: float((part / self.compliance).max()) for name, part in self.parts.items()}
        visible = 5e-3 * float(self.compliance.max())  # a smaller part would be thinner than a line of the chart
        ranked = sorted(self.parts.items(), key=lambda item: -round(shares[item[0]], 9))  # equal shares differ by rounding errors
        named = [(name, part) for name, part in ranked if part.max() >= visible][:most]
        rest = self.compliance - np.sum([part for _, part in named], axis=0)
        return [*named, ("others", np.maximum(rest, 0.0))] if rest.max() >= visible else named

    def columns(self) -> dict[str, Array]:
        """A row for each crank angle: angle, position, height, compliance and its parts."""
        columns = {
            "{} [{}]".format(*self.coordinate.heads[0]): self.crank_angle,
            "slide_position [m]": self.slide_position,
            "height [m]": self.height,
        }
        return columns | {"compliance [m/N]": self.compliance} | {f"{name} [m/N]": part for name, part in self.parts.items()}


@typed
def compliance(press: Linkage, stiffness: Stiffness, *, angle: ArrayLike | None = None) -> SlideCompliance:
    """Find the compliance of a press at its slide over the crank angle, and the share of each part.

    Parallel rods on the slide share the force by their stiffnesses and those of their bearings. The moment of a guide, or the arm of a link
    with more than two bearings, cannot take part in this sharing; for a press that needs it an error is raised.

    Args:
        press: a press with one driver and a slide.
        stiffness: stiffnesses of its parts.
        angle: (n,) crank angles [rad]; by default 360 per turn over one period, without its end. For a sliding driver positions [m]; by
            default 361 over its travel.

    Raises:
        UnknownNameError: the linkage has no such bearing or link.
        PinpressError: a stiffness is not as described, the press has several drivers or no dead centres, no part in the line of force is
            elastic at a crank angle, or a guide's moment or an arm would share forces with parallel rods.
        SingularityError: the linkage locks.
    """
    springs = springs_of(press, stiffness)
    press.refuse_several_drivers("they have no one crank angle; see slide_deflection of a motion")
    centres = dead_centres(press)
    if angle is None and press.driver_coordinates[0].turns:
        angle = np.arange(POINTS * press.period_turns) * (2 * np.pi / POINTS)
    elif angle is None:
        angle = np.linspace(press.branch.angles[0], press.branch.angles[-1], POINTS + 1)
    motion = servo_cycle(press, speed=0.0, angle=angle)
    held = hold(press, springs, motion)
    shares = held.moved(held.unit)
    total = np.sum(list(shares.values()), axis=0)
    lowest = hold(press, springs, servo_cycle(press, speed=0.0, angle=[centres.bottom_angle]))
    bottom = {name: float(share[0]) for name, share in lowest.moved(lowest.unit).items()}
    at_bottom = sum(bottom.values())
    if not total.min() > RIGID * max(float(total.max()), at_bottom) or not at_bottom > RIGID * total.max():
        where = motion.crank_angle[int(total.argmin())] if at_bottom > RIGID * total.max() else centres.bottom_angle
        place = press.driver_coordinates[0].at(where)
        raise PinpressError(f"nothing of {press.name} yields at {place}: give a part in the line of force a stiffness")
    return SlideCompliance(
        _press=press,
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


@dataclass(frozen=True, eq=False, repr=False)
class HeldPress:
    """An elastic press in the poses of a motion, with its drivers held in each pose.

    Attributes:
        press: the press.
        springs: its elastic parts.
        motion: the motion.
        shared: stiffnesses that determine how bearings share forces, see `springs.sharing`.
    """

    press: Linkage
    springs: tuple[Spring, ...]
    motion: Motion
    shared: Mapping[str, float]

    @cached_property
    def unloaded(self) -> list[Array]:
        """Internal forces under weight and inertia alone, at the speeds of the motion [N, N m]."""
        return self.in_motion([])

    @cached_property
    def size(self) -> float:
        """Size of a trial load that is large compared with rounding errors of weight and inertia [N]."""
        return max([1.0, *(float(np.abs(force).max()) for force in self.unloaded)])

    @cached_property
    def unit(self) -> list[Array]:
        """Internal forces under 1 N on the slide along its guide [N, N m]."""
        return self.under(str(self.press.slide), self.press.slide_direction, self.press.tool.point)

    def under(self, link: str, direction: Array, point: Array) -> list[Array]:
        """Additional internal forces under 1 N; internal forces are linear in the loads [N, N m].

        Args:
            link: name of the link on which the force acts.
            direction: (3,) unit vector in world axes.
            point: (3,) point in the link's own frame [m].
        """
        load = PointForce(link, self.size * direction, (float(point[0]), float(point[1]), float(point[2])))
        return [(loaded - none) / self.size for loaded, none in zip(self.in_motion([load]), self.unloaded, strict=True)]

    def moved(self, forces: Sequence[Array]) -> dict[str, Array]:
        """Name of a part -> (n,) displacement of the slide by the deflection of this part under internal forces [m].

        Raises:
            PinpressError: a preloaded joint opens, and its stiffness determines how parts share forces.
        """
        if self.press.engine_of_one_driver.redundant(self.press.closed):
            for part, force in zip(self.springs, forces, strict=True):
                if part.kind != "frame" and part.opens(force):
                    raise PinpressError(
                        f"the joint of {part.name} opens, and {self.press.name} shares forces by stiffnesses, which change then: give it"
                        " more preload, or a press whose forces do not depend on them"
                    )
        return {
            part.name: np.asarray(np.einsum("nk,nk->n", n, part.elongations(force)))
            for part, n, force in zip(self.springs, self.unit, forces, strict=True)
        }

    def in_motion(self, loads: Sequence[Load]) -> list[Array]:
        """Internal forces under loads, weight and inertia, at the speeds of the motion [N, N m]."""
        reactions = inverse_dynamics(self.press, self.motion, loads, stiffness=self.shared)
        return internal_forces(self.press, self.springs, self.motion, reactions)


def hold(press: Linkage, springs: tuple[Spring, ...], motion: Motion) -> HeldPress:
    """The elastic press in the poses of a motion.

    Raises:
        PinpressError: a guide's moment or an arm would share forces with parallel rods.
    """
    if press.uneven:
        press.refuse_contacts("they push bearings apart, so deflections do not add up; write only their ratios, as gears or <relation>")
    held = HeldPress(press, springs, motion, sharing(press, springs))
    apart = any(part.kind == "moment" or (part.kind == "rod" and len(part.bearings) == 1) for part in springs)
    if apart and press.engine_of_one_driver.redundant(press.closed):
        _refuse_unshared(held)
    return held


def _refuse_unshared(held: HeldPress) -> None:
    """Raise PinpressError if self-equilibrated forces do work on the deflections: then the computed forces are not those of the elastic
    press.

    Self-equilibrated forces z are the difference between two distributions of the same load. With scalar products weighted by compliances,
    the relative error of the deflection is (N . z)^2 / (z . z) / (N . N).
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
            loaded = (size > 1e-16 * work(held.unit, held.unit)) & (whole > 0.0)  # a smaller square is a rounding error
            if np.any(done[loaded] ** 2 > 1e-9 * size[loaded] * whole[loaded]):  # relative error of the deflection
                raise PinpressError(
                    f"parallel rods of {held.press.name} do not share forces by their own springs and those of their bearings alone: make"
                    " both sides alike, or leave out the guides' moments and arms"
                )


def _moving_mass(held: HeldPress) -> Array:
    """Sum (n,) of mass times squared displacement under 1 N on the slide [kg m2/N2].

    Six equal masses, two on each of its principal axes, have the inertia of a rigid body. Unit forces on these masses give their
    displacements in world axes.
    """
    press, total = held.press, np.zeros(len(held.motion.crank_angle))
    directions = press.engine_of_one_driver.directions
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
