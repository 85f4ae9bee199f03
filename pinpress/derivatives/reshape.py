"""A linkage with other link lengths: its pivots moved in their links, and the same assembly drawn anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.errors import SingularityError
from ..engines.closure import ACCEPTED, Closure
from ..engines.continuation import Lock, follow
from ..engines.joints import Coupling
from ..engines.spatial import model as spatial
from ..linkage.linkage import Linkage
from .continuation import carried
from .geometry_shift import shift
from .pivots import Displacements, Pivots, displaced


@typed
def reshaped(press: Linkage, pivots: Pivots) -> Linkage:
    """The linkage with some of its pivots elsewhere in their links, in the assembly it was drawn in; `write_urdf` writes it.

    The assembly is followed from the old lengths to the new ones with the crank at angle 0, and drawn anew there: all joint coordinates are
    zero in the closed pose with the new lengths. The crank angle keeps its meaning, and so does the slide's position; the limits of
    the other joints keep theirs, counted from the new pose. Inertias stay as they are in the frames of their links, whatever the lengths:
    change them with ``dataclasses.replace(press, model=...)`` or counterweights.

    Args:
        pivots: (bearing, link) -> position (3,) of that bearing in the link's own frame [m], e.g. ``{("B", "crank"): (0.15, 0, 0)}``. A
            joint is moved in its parent link; on its child it is the origin of the link's frame, where nothing can be moved. A loop is
            moved in either link, a guide as a line through the position.

    Raises:
        UnknownNameError: a bearing or link that the linkage does not have.
        PinpressError: a link that the bearing is not on, or in which it cannot be moved; a position that is not three finite numbers, or
            that is out of the plane of a planar linkage.
        AssemblyError: with the new lengths the linkage cannot be closed at crank angle 0.
        SingularityError: it can, but two assemblies meet on the way there.
    """
    moved = displaced(press, pivots)
    return redrawn(press, moved, _closed(press, moved))


def redrawn(press: Linkage, moved: Displacements, position: Array) -> Linkage:
    """The linkage with displaced pivots, drawn anew in the pose that closes it, at joint coordinates (nv,), the drivers' zero."""
    placed = _placed(press, moved)
    model = placed.model
    for j, (axis, coordinate) in enumerate(zip(press.axes, position, strict=True), 1):
        if j - 1 in press.driver_indices:
            continue
        turned = pin.exp3(axis.direction * coordinate) if axis.turns else np.eye(3)
        travelled = np.zeros(3) if axis.turns else axis.direction * coordinate
        model.jointPlacements[j] = model.jointPlacements[j] * pin.SE3(turned, travelled)
        joint = model.joints[j]
        if joint.nq == 1:
            for limits in (model.lowerPositionLimit, model.upperPositionLimit):
                limits[joint.idx_q] -= coordinate
    return replace(press, model=model, loops=placed.loops, couplings=tuple(map(_from_zero, press.couplings)))


def _placed(press: Linkage, moved: Displacements, share: float = 1.0) -> Linkage:
    """The linkage with a share of the displacements, still drawn as before, and so open."""
    model = press.model.copy()
    for j, displacement in enumerate(moved.joints, 1):
        place = model.jointPlacements[j]
        model.jointPlacements[j] = pin.SE3(place.rotation, place.translation + share * displacement)
    loops = tuple(
        replace(loop, point1=loop.point1 + share * one, point2=loop.point2 + share * two)
        for loop, (one, two) in zip(press.loops, moved.ends, strict=True)
    )
    return replace(press, model=model, loops=loops)


def _from_zero(coupling: Coupling) -> Coupling:
    """A gear pair whose joints are both zero in the drawn pose."""
    return replace(coupling, offset=0.0)


def _closed(press: Linkage, moved: Displacements) -> Array:
    """Joint coordinates (nv,) that close the linkage with displaced pivots, counted from where it was drawn."""
    if press.plane is not None:
        plane = press.plane.dense
        return carried(plane, press.closed[:, None], shift(press, plane, moved)).closure.position[:, 0]
    return _closed_in_space(press, moved)


def _closed_in_space(press: Linkage, moved: Displacements) -> Array:
    """The same of any linkage, as an assembly is followed over the crank angle; here along the way to the new lengths."""
    drivers, target = np.zeros((len(press.drivers), 1)), _placed(press, moved).spatial.equations()

    def close(share: Array, guess: Array) -> Closure:
        here = _placed(press, moved, float(share[0])).spatial
        closure = spatial.close(here, here.equations(), drivers, [0.0] * len(press.drivers), guess)
        if not np.isfinite(closure.widest):
            return closure
        start, rows = press.equations(closure.position[:, 0]), here.equations().at(closure.position[:, 0])
        # Gaps change in proportion to displacements, as long as no joint moves.
        opened = target.at(closure.position[:, 0]).gaps - start.gaps
        return replace(closure, first=spatial.Passive(rows.columns, here).rates(-opened)[:, None])

    end = follow(close, press.closed, 1.0, press.size, ACCEPTED * press.spatial.tolerance)
    if isinstance(end, Lock):
        raise SingularityError(
            f"{press.name} cannot be brought to the new lengths: {100 * end.angle:.3g} % of the way it locks, or cannot be assembled",
            0.0,
            end.margin,
        )
    return end
