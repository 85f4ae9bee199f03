"""The equations of a linkage at many configurations by Pinocchio, one at a time; see `pinocchio.model` and `spatial.equations`."""

from __future__ import annotations

from functools import partial

import numpy as np

from ...common.quantities import Array
from ..joints import configuration
from ..spatial.bodies import Placements
from ..spatial.equations import Equations, Kinematics, Loops
from .model import Equations as OneByOne
from .model import Rows, SpatialModel


def one_by_one(spatial: SpatialModel) -> Kinematics:
    """Kinematics of a linkage by Pinocchio, for use within one call: they hold its data."""
    one = spatial.equations()
    return Kinematics(partial(_equations, one), partial(_drift, one), in_blocks=False)


def _equations(one: OneByOne, loops: Loops, x: Array) -> Equations:
    """The equations of a linkage at joint coordinates (nv, n)."""
    spatial, (count, n) = loops.spatial, x.shape
    gaps, entries = np.empty((loops.rows, n)), np.zeros((loops.entries.shape[1] + 1, n))
    rotation, origin = np.empty((count + 1, 3, 3, n)), np.empty((count + 1, 3, n))
    held = [np.empty((3, loop.held_rotations, n)) for loop in spatial.loops]
    row, joint = loops.entries
    for i in range(n):
        rows = one.at(np.ascontiguousarray(x[:, i]))
        gaps[:, i], entries[:-1, i] = rows.gaps, rows.columns[row, joint]
        for body, placement in enumerate(one.placements):
            rotation[body, ..., i], origin[body, :, i] = placement.rotation, placement.translation
        for prevented, directions in zip(held, rows.held_directions, strict=True):
            prevented[..., i] = directions
    directions = np.array([axis.direction for axis in spatial.axes])
    placed = Placements(rotation, origin, np.einsum("jikn,jk->jin", rotation[1:], directions))
    ends = origin[loops.joint] + np.einsum("elikn,elk->elin", rotation[loops.joint], loops.point)
    return Equations(loops, x, placed, ends, gaps, entries, held)


def _drift(one: OneByOne, loops: Loops, found: Equations, v: Array) -> Array:
    """Second derivative (rows, n) of the gaps at joint rates (nv, n) and no joint acceleration."""
    result, nothing = np.empty_like(found.gaps), np.empty(0)
    q = configuration(loops.spatial.slots, found.x)
    for i in range(v.shape[1]):
        rows = Rows(np.ascontiguousarray(q[:, i]), nothing, nothing, [np.ascontiguousarray(held[..., i]) for held in found.held])
        result[:, i] = one.drift(rows, np.ascontiguousarray(v[:, i]))
    return result
