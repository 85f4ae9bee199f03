"""Contacts of machine elements: teeth, threads, rollers on cams, through which two bodies push on each other.

A relation moves the joints of a contact. Its multiplier is an effort on the joint that the relation determines. What really acts is the
wrench of one body on the other at their contact. Effort and wrench do the same work in every motion of the linkage: the driving torque is
the same, but the forces in the bearings are not. A contact defines how the wrench follows from the multiplier.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.frozen import Frozen
from ..common.quantities import Array
from .constraints import Relation

ZERO = np.zeros(3)


class UnitWrench(NamedTuple):
    """What the first body does to the second one where the effort of the relation is 1, in the axes of the carrier's joint frame.

    Attributes:
        point: (3,) or (n, 3) where the two bodies touch, in the carrier's joint frame [m].
        force: (3,) or (n, 3) force at the point, which changes its sign with the effort [1/m where the effort is a torque, else 1].
        couple: (3,) or (n, 3) moment in addition to that of the force, which changes its sign with the effort [1, or m].
        push: (3,) or (n, 3) force at the point by the size of the effort, whatever its sign: teeth separate the gears.
    """

    point: Array
    force: Array
    couple: Array = ZERO
    push: Array = ZERO


class Rubbing(NamedTuple):
    """Friction of a contact, as a wrench between two bodies against the speed with which they rub.

    The speed is the power of this wrench in the motion of the second body relative to the first one. Friction is a share of the size of the
    effort of the contact's relation, in the opposite sense. The sense of the wrench is such that the contact's first body drives its second
    one where effort and speed have the same sign.

    Attributes:
        first: Pinocchio joint of the body that rubs, 0 for the frame.
        second: Pinocchio joint of the body on which it rubs, 0 for the frame.
        force: (3,) force on the second body at the contact's point, in the axes of the carrier [1/m where the effort is a torque, else 1].
        couple: (3,) moment on the second body in addition, in the axes of the carrier [1, or m].
        forward: share of the effort where the contact's first body drives its second one.
        backward: share of the effort where the second body drives the first one.
        push_backward: (3,) `UnitWrench.push` where the second body drives, if it is another one, as in a worm gear; None: the same.
    """

    first: int
    second: int
    force: Array
    couple: Array
    forward: float
    backward: float
    push_backward: Array | None = None


class Planets(NamedTuple):
    """Equal planets of which one stands for all. Vectors are in the carrier's joint frame.

    Attributes:
        number: number of planets.
        planet: Pinocchio joint of the drawn planet, one of the two bodies of the contact.
        pin: (3,) centre of the drawn planet [m].
        center: (3,) centre of the sun or ring, the other body [m].
        axis: (3,) direction of the axes of all gears.
    """

    number: int
    planet: int
    pin: Array
    center: Array
    axis: Array


@dataclass(frozen=True, eq=False, repr=False)
class Contact(Frozen):
    """A contact whose wrench has a fixed direction and place in its carrier: teeth at a pitch point, a thread.

    Attributes:
        name: of the contact; empty for the pair of a shaft and a slide in ``<mimic>``, which has no bearing of its own in results.
        kind: "gears", "rack", "screw", "worm" or "cam".
        relation: index of its relation in `Structure.relations`.
        first: Pinocchio joint of the first body, 0 for the frame.
        second: Pinocchio joint of the second body, 0 for the frame.
        carrier: Pinocchio joint of the body that carries both, 0 for the frame.
        unit: the wrench of the first on the second body by the effort.
        rubbing: its friction; empty without losses.
        planets: the equal planets, if this contact of one planet stands for several. Each takes an equal part of the effort. Together they
            load the bearings of sun, ring and carrier only along the axis. The pin of the drawn planet carries the tooth forces of one
            planet. Mass and inertia are those of the drawn link: give it the mass and inertia of all planets for the right torque; its pin
            then carries the weight of all planets.
    """

    name: str
    kind: str
    relation: int
    first: int
    second: int
    carrier: int
    unit: UnitWrench
    rubbing: tuple[Rubbing, ...] = ()
    planets: Planets | None = None

    def wrench(self, position: Array) -> UnitWrench:
        """The unit wrench at joint coordinates (nv, n)."""
        return self.unit

    @property
    def count(self) -> int:
        """Number of equal contacts that share the effort."""
        return 1 if self.planets is None else self.planets.number

    def actions(self, unit: UnitWrench) -> list[tuple[int, UnitWrench]]:
        """What acts on bodies, by their Pinocchio joints, where the first body does this to the second one; in balance altogether."""
        if self.planets is None or self.planets.number == 1:
            return [(self.second, unit), (self.first, _times(unit, -1.0))]
        count, planet, pin_, center, axis = self.planets
        sign = 1.0 if planet == self.second else -1.0
        point, force, couple, push = _times(unit, sign)
        spin = _along(couple + np.cross(point - pin_, force), axis)  # what turns all planets about their pins
        own = UnitWrench(point, force / count, couple / count + (1.0 - 1.0 / count) * spin, push / count)
        other = UnitWrench(center, -_along(force, axis), -_along(couple + np.cross(point - center, force), axis))
        # the pins of the planets that are not drawn
        rest = -(own.couple + other.couple + np.cross(center - point, other.force))
        return [
            (planet, own),
            (self.first + self.second - planet, other),
            (self.carrier, UnitWrench(point, -own.force - other.force, rest, -own.push)),
        ]


def _times(unit: UnitWrench, sign: float) -> UnitWrench:
    return UnitWrench(unit.point, sign * unit.force, sign * unit.couple, sign * unit.push)


def _along(vectors: Array, axis: Array) -> Array:
    return np.asarray((vectors @ axis)[..., None] * axis)


def racks(
    model: pin.Model, turns: Sequence[bool], axes: Sequence[Array], relations: Sequence[Relation], named: Sequence[Contact]
) -> Iterator[Contact]:
    """The contacts of relations between a shaft and a slide that the same body carries, as a pinion and its rack or a screw and its nut,
    which have none of their own.

    Between teeth or threads acts one wrench, of the shaft on the slide: the force along the guide, through the shaft's axis, and a couple
    about it, which for a rack is the moment of the force at the pitch line. A pressure angle would add a force across the two, which
    ``<mimic>`` does not give.

    Args:
        model: of the tree.
        turns: whether every joint turns.
        axes: (3,) of all joints in their own frames.
        relations: of the linkage.
        named: contacts of other relations.
    """
    for k, relation in enumerate(relations):
        joints = [joint for joint, coefficient in relation.coefficients.items() if coefficient]
        slides, shafts = ([joint for joint in joints if turns[joint] is turning] for turning in (False, True))
        if relation.curve is not None or not len(slides) == len(shafts) == 1 or any(contact.relation == k for contact in named):
            continue
        slide, shaft = slides[0] + 1, shafts[0] + 1
        if model.parents[slide] == model.parents[shaft]:
            places = model.jointPlacements
            force, torque = (relation.coefficients[joint - 1] * (places[joint].rotation @ axes[joint - 1]) for joint in (slide, shaft))
            unit = UnitWrench(places[shaft].translation.copy(), force, -torque)
            yield Contact("", "rack", k, shaft, slide, model.parents[slide], unit)
