"""Racks and screws: pairs of a shaft and a slide in one carrier, which the force between their teeth moves.

Engines couple the coordinates of the two joints, by a force on the slide along its axis and a torque on the shaft about its own. Between
teeth or threads both are one wrench, of shaft on slide: the force through the shaft's axis, and the torque, which for a rack is the moment
of the force at the pitch line. The carrier feels it through the shaft's bearing, and nothing of it along the slide's guide. A pressure
angle would add a force across the two, which no description gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.quantities import Array
from .joints import Axis, Coupling


class Rack(NamedTuple):
    """A slide that meshes with a shaft.

    Attributes:
        coupling: index of the coupling.
        slide: the joint that slides, in v.
        shaft: the joint that turns, in v.
        by_torque: force on the slide along its axis, by the coupling's effort on its follower.
        turning: torque on the shaft about its axis, by the same.
    """

    coupling: int
    slide: int
    shaft: int
    by_torque: float
    turning: float


def racks(model: pin.Model, axes: Sequence[Axis], couplings: Sequence[Coupling]) -> tuple[Rack, ...]:
    """The couplings of a shaft and a slide that the same body carries."""
    found = []
    for k, pair in enumerate(couplings):
        ends = {pair.follower: 1.0, pair.leader: -pair.multiplier}
        slide, shaft = sorted(ends, key=lambda joint: axes[joint].turns)
        carried = model.parents[slide + 1] == model.parents[shaft + 1]
        if pair.multiplier and carried and axes[shaft].turns and not axes[slide].turns:
            found.append(Rack(k, slide, shaft, ends[slide], ends[shaft]))
    return tuple(found)


class PlacedAxis(NamedTuple):
    """A joint over a motion.

    Attributes:
        origin: (n, 3) of its child's frame, in the world [m].
        direction: (n, 3) of its axis, in the world.
    """

    origin: Array
    direction: Array


def between_teeth(rack: Rack, efforts: Array, slide: PlacedAxis, shaft: PlacedAxis, force: Array, moment: Array) -> None:
    """Let the forces and moments (bearings, n, 3) of the two joints be those of bearings between which teeth push; ``efforts``: (n,) of the
    coupling on its follower."""
    push = (rack.by_torque * efforts)[:, None] * slide.direction
    torque = (rack.turning * efforts)[:, None] * shaft.direction
    force[rack.slide] -= push
    moment[rack.slide] += torque - np.cross(shaft.origin - slide.origin, push)
    force[rack.shaft] += push
    moment[rack.shaft] -= torque
