"""A linkage with other link lengths: its pivots moved in their links, and the same assembly drawn anew.

Newton's method alone could reach another assembly. The pivots of a planar linkage are therefore moved in steps, at all crank angles at
once. Each step is predicted from the exact derivatives of the joint coordinates. It is accepted if Newton's method corrects the prediction
only a little, and if every block of equations stays well away from where two assemblies meet; else it is halved.
"""

from __future__ import annotations

from dataclasses import replace
from functools import singledispatch
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.arguments import typed
from ..common.errors import AssemblyError, SingularityError
from ..common.quantities import Array
from ..engines.engine import Closure, Engine, joined
from ..engines.following import SingularPosition, follow
from ..engines.pinocchio.engine import PinocchioEngine
from ..engines.pinocchio.equations import OneConfiguration
from ..engines.planar.closing import close
from ..engines.planar.engine import PlanarEngine
from ..engines.planar.equations import Equations
from ..engines.planar.model import Plane
from ..engines.rank import PassiveJacobian
from ..linkage.linkage import Linkage
from .motion import Displacements, Pivots, Shift, States, displaced, shift, shifted

SHORTEST = 2.0**-10  # shortest step, as a share of the way: the linkage counts as locked where a shorter one is needed
MOST = 40  # most steps that are tried: the linkage counts as locked where more are needed
CORRECTED = 0.1  # share of its predicted step by which Newton's method may correct a joint
NEARLY = 1e-3  # correction that is accepted in any case [rad, or lengths of the linkage]


@typed
def reshaped(press: Linkage, pivots: Pivots) -> Linkage:
    """The linkage with some of its pivots elsewhere in their links, in the assembly of its home pose.

    The assembly is followed from the old lengths to the new ones with the drivers at home, and drawn anew there: the coordinates of all
    joints but the drivers are zero in the closed pose with the new lengths. Those of the drivers, and the slide's position, keep their
    meaning; the limits of the other joints are counted from the new pose, and so stay where they are. Inertias do not change in the frames
    of their links: change them with ``dataclasses.replace(press, model=...)`` or counterweights. `write_urdf` writes the linkage.

    Args:
        press: the linkage, planar or not.
        pivots: (bearing, link) -> position (3,) of that bearing in the link's own frame [m], e.g. ``{("B", "crank"): (0.15, 0, 0)}``. A
            joint is moved in its parent link; on its child it is the origin of the link's frame, where nothing can be moved. A loop is
            moved in either link, a guide as a line through the position.

    Raises:
        UnknownNameError: a bearing or link that the linkage does not have.
        PinpressError: a link that the bearing is not on, or in which it cannot be moved; a position that is not three finite numbers, or
            that is out of the plane of a planar linkage.
        AssemblyError: the linkage cannot be closed with the new lengths with its drivers at home.
        SingularityError: it can be closed, but two assemblies meet on the way there.
    """
    moved = displaced(press, pivots)
    return redrawn(press, moved, _closed(press, moved))


def redrawn(press: Linkage, moved: Displacements, position: Array) -> Linkage:
    """The linkage with displaced pivots, drawn anew in the pose that closes it.

    Args:
        press: the linkage.
        moved: displacements of its pivots.
        position: (nv,) joint coordinates of that pose, with the drivers at home.
    """
    placed = _placed(press, moved)
    model, home = placed.model, np.zeros(len(position))
    home[list(press.driver_indices)] = position[list(press.driver_indices)]
    for j, (axis, coordinate) in enumerate(zip(press.axes, position, strict=True), 1):
        if j - 1 in press.driver_indices:
            continue
        model.jointPlacements[j] = model.jointPlacements[j] * axis.step(coordinate)
        joint = model.joints[j]
        if joint.nq == 1:
            for limits in (model.lowerPositionLimit, model.upperPositionLimit):
                limits[joint.idx_q] -= coordinate
    relations = tuple(relation.drawn_in(position - home).through(home) for relation in press.relations)
    gone = dict(zip(press.joints, (position - home).tolist(), strict=True))
    springs = tuple(replace(spring, reference=spring.reference - gone[spring.joint]) for spring in press.joint_springs)
    at_home = tuple(home.tolist()) if home.any() else ()
    return replace(press, model=model, loops=placed.loops, relations=relations, joint_springs=springs, home=at_home, mounted="")


def _placed(press: Linkage, moved: Displacements, share: float = 1.0) -> Linkage:
    """The linkage with a share of the displacements, drawn as before and therefore open."""
    model = press.model.copy()
    for j, displacement in enumerate(moved.joints, 1):
        place = model.jointPlacements[j]
        model.jointPlacements[j] = pin.SE3(place.rotation, place.translation + share * displacement)
    loops = tuple(
        replace(loop, point1=loop.point1 + share * one, point2=loop.point2 + share * two)
        for loop, (one, two) in zip(press.loops, moved.ends, strict=True)
    )
    return replace(press, model=model, loops=loops)


def _closed(press: Linkage, moved: Displacements) -> Array:
    """Joint coordinates (nv,) that close the linkage with displaced pivots, counted from where it was drawn."""
    return _closed_by(press.engine(), press, moved)


@singledispatch
def _closed_by(engine: Engine, press: Linkage, moved: Displacements) -> Array:
    """Joint coordinates (nv,) that close a linkage that need not be planar: its assembly is followed along the way to the new lengths.

    Raises:
        SingularityError: the linkage locks on the way, or cannot be assembled.
    """
    drivers, target = press.closed[list(press.driver_indices), None], OneConfiguration(_placed(press, moved).structure_as_built)

    def close_at(share: float, guess: Array) -> Closure:
        here = _placed(press, moved, share).structure_as_built
        closure = PinocchioEngine(here).closing_function()(drivers, np.zeros_like(drivers), guess)
        if not np.isfinite(closure.widest):
            return closure
        start, rows = press.equations(closure.position[:, 0]), OneConfiguration(here).at(closure.position[:, 0])
        # Gaps change in proportion to displacements, as long as no joint moves.
        opened = target.at(closure.position[:, 0]).gaps - start.gaps
        return replace(closure, first=PassiveJacobian(rows.columns, here).rates(-opened)[:, None])

    def close_part_way(shares: Array, guesses: Array) -> Closure:
        return joined((close_at(float(share), guess[:, None]) for share, guess in zip(shares, guesses.T, strict=True)), len(shares))

    end = follow(close_part_way, press.closed, 1.0, press.size, press.structure.tolerance)
    if isinstance(end, SingularPosition):
        raise SingularityError(
            f"{press.name} cannot be brought to the new lengths: {100 * end.angle:.3g} % of the way it locks, or cannot be assembled",
            0.0,
            end.margin,
        )
    return end


@_closed_by.register(PlanarEngine)
def _closed_in_plane(engine: PlanarEngine, press: Linkage, moved: Displacements) -> Array:
    """Joint coordinates (nv,) that close a planar linkage."""
    plane = engine.plane
    return continue_geometry(plane, press.closed[:, None], shift(press, plane, moved)).closure.position[:, 0]


# ------------------------------------------------------------------- the assembly of a planar linkage, followed to other lengths


class ContinuedGeometry(NamedTuple):
    """A planar linkage with other lengths, closed.

    Attributes:
        plane: the constants of the linkage.
        closure: its closed configurations at the crank angles.
    """

    plane: Plane
    closure: Closure


def continue_geometry(plane: Plane, position: Array, by: Shift) -> ContinuedGeometry:
    """Move the pivots of a closed planar linkage while its crank stands still.

    Args:
        plane: constants of the linkage, with NumPy arrays for matrices.
        position: (nv, n) joint coordinates that close it.
        by: what the displacements add to the rows of the plane.

    Raises:
        AssemblyError: the linkage cannot be closed with its new lengths at one of the crank angles.
        SingularityError: it can be closed, but two assemblies meet on the way there.
    """
    angle = position[plane.driver]
    reached = close(Equations.of(plane), angle, position, with_margins=True)
    here, share, step, tried = plane, 0.0, 1.0, 0
    while share < 1.0:
        step, tried = min(step, 1.0 - share), tried + 1
        there = shifted(plane, by if share + step == 1.0 else by.times(share + step))
        predicted = step * States.of(here, reached.position).slope(by)
        closure = close(Equations.of(there), angle, reached.position + predicted, with_margins=True)
        if _belongs(there, closure, reached, predicted).all():
            here, reached, share, step = there, closure, share + step, 2 * step
        elif step <= SHORTEST or tried >= MOST:
            raise _lost(there, shifted(plane, by), closure, reached, predicted)
        else:
            step /= 2
    return ContinuedGeometry(here, reached)


def _belongs(plane: Plane, closure: Closure, before: Closure, predicted: Array) -> Array:
    """Whether each of n configurations continues the assembly of the one before."""
    assert closure.margins is not None
    assert before.margins is not None
    with np.errstate(all="ignore"):  # a configuration that is not finite is no continuation
        corrected = np.abs(closure.position - before.position - predicted).max(axis=0)
        near = corrected <= CORRECTED * np.abs(predicted).max(axis=0) + NEARLY * (1 + plane.size)
        margins = closure.margins * np.sign(before.margins)
        # A margin that falls faster than by half in a step may have passed zero.
        kept = (margins >= 0.5 * np.abs(before.margins)).all(axis=0)
        return np.asarray((closure.gap <= plane.tolerance) & near & kept)


def _lost(ahead: Plane, target: Plane, closure: Closure, before: Closure, predicted: Array) -> AssemblyError | SingularityError:
    """The error that says why the assembly cannot be followed."""
    assert before.margins is not None
    at = int(np.argmin(_belongs(ahead, closure, before, predicted)))
    angle, margin = float(before.position[ahead.driver, at]), float(np.abs(before.margins[:, at]).min(initial=1.0))
    end = close(Equations.of(target), np.array([angle]), before.position[:, at : at + 1])
    if end.gap[0] <= target.tolerance:
        return SingularityError("on the way to the new lengths two assemblies of the linkage meet; go there in other steps", angle, margin)
    gap = float(end.gap[0]) if np.isfinite(end.gap[0]) else np.inf
    return AssemblyError("the linkage cannot be assembled with the new lengths", angle, gap, end.iterations)
