"""Racks and screws: pairs of a shaft and a slide in one carrier, which the force between their teeth moves.

Engines relate the coordinates of the two joints, by a force on the slide along its axis and a torque on the shaft about its own. Between
teeth or threads both are one wrench, of shaft on slide: the force through the shaft's axis, and the torque, which for a rack is the moment
of the force at the pitch line. The carrier feels it through the shaft's bearing, and nothing of it along the slide's guide. A pressure
angle would add a force across the two, which no description gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..common.quantities import Array
from .constraints import Relation


class Rack(NamedTuple):
    """A slide that meshes with a shaft.

    Attributes:
        relation: index of the relation.
        slide: the joint that slides, in v.
        shaft: the joint that turns, in v.
        by_torque: force on the slide along its axis, by the effort of the relation.
        turning: torque on the shaft about its axis, by the same.
    """

    relation: int
    slide: int
    shaft: int
    by_torque: float
    turning: float


def find_racks(parents: Sequence[int], turns: Sequence[bool], relations: Sequence[Relation]) -> tuple[Rack, ...]:
    """The relations of a shaft and a slide that the same body carries.

    Args:
        parents: parent of every joint.
        turns: whether every joint turns.
        relations: of the linkage.
    """
    racks = []
    for k, relation in enumerate(relations):
        if relation.curve is not None:
            continue
        joints = [joint for joint, coefficient in relation.coefficients.items() if coefficient]
        slides, shafts = ([joint for joint in joints if turns[joint] is turning] for turning in (False, True))
        if len(slides) == len(shafts) == 1 and parents[slides[0]] == parents[shafts[0]]:
            slide, shaft = slides[0], shafts[0]
            racks.append(Rack(k, slide, shaft, relation.coefficients[slide], relation.coefficients[shaft]))
    return tuple(racks)


class PlacedAxis(NamedTuple):
    """A joint over a motion: (n, 3) origin of its child's frame [m] and direction of its axis, both in the world."""

    origin: Array
    direction: Array


def between_teeth(rack: Rack, efforts: Array, slide: PlacedAxis, shaft: PlacedAxis, force: Array, moment: Array) -> None:
    """Let the forces and moments (bearings, n, 3) of the two joints be those of bearings between which teeth push; ``efforts``: (n,) of the
    relation on the joint that it determines."""
    push = (rack.by_torque * efforts)[:, None] * slide.direction
    torque = (rack.turning * efforts)[:, None] * shaft.direction
    force[rack.slide] -= push
    moment[rack.slide] += torque - np.cross(shaft.origin - slide.origin, push)
    force[rack.shaft] += push
    moment[rack.shaft] -= torque
