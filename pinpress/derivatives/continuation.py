"""From one geometry of a planar linkage to another, its assembly kept, at all crank angles at once.

Newton's method alone could land in another assembly. So the pivots move in steps, each predicted from the exact derivatives of the joint
coordinates, and a step is taken where Newton's method has little left to correct and every block of equations stays well away from where
two assemblies meet; else half of it.
"""

from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import AssemblyError, SingularityError
from ..engines.closure import ACCEPTED, Closure
from ..engines.planar.kinematics import close
from ..engines.planar.model import Plane
from .geometry_shift import Shift, shifted
from .motion import States

SHORTEST = 2.0**-10  # step, as a share of the way: where a shorter one is needed, the linkage locks
MOST = 40  # steps that are tried: where more are needed, it locks too
CORRECTED = 0.1  # share of its predicted step by which Newton's method may correct a joint
NEARLY = 1e-3  # what it may correct in any case [rad, or lengths of the linkage]
KEPT = 0.5  # share of its margin that a block must keep in a step


class Carried(NamedTuple):
    """The linkage at the end of the way, and its closed configurations at the crank angles."""

    plane: Plane
    closure: Closure


def carried(plane: Plane, position: Array, by: Shift) -> Carried:
    """Move the pivots of a linkage with closed joint coordinates (nv, n), its crank held.

    Raises:
        AssemblyError: with its new lengths the linkage cannot be closed at one of the crank angles.
        SingularityError: it can, but two assemblies meet on the way there.
    """
    angle = position[plane.driver]
    reached = close(plane, angle, position, with_margins=True)
    here, share, step, tried = plane, 0.0, 1.0, 0
    while share < 1.0:
        step, tried = min(step, 1.0 - share), tried + 1
        there = shifted(plane, by if share + step == 1.0 else by.times(share + step))
        predicted = step * States.of(here, reached.position).slope(by)
        closure = close(there, angle, reached.position + predicted, with_margins=True)
        if _belongs(there, closure, reached, predicted).all():
            here, reached, share, step = there, closure, share + step, 2 * step
        elif step <= SHORTEST or tried >= MOST:
            raise _lost(there, shifted(plane, by), closure, reached, predicted)
        else:
            step /= 2
    return Carried(here, reached)


def _belongs(plane: Plane, closure: Closure, before: Closure, predicted: Array) -> Array:
    """Whether configurations (n,) continue the ones before."""
    assert closure.margins is not None
    assert before.margins is not None
    with np.errstate(all="ignore"):  # what failed is not finite, and no continuation
        corrected = np.abs(closure.position - before.position - predicted).max(axis=0)
        near = corrected <= CORRECTED * np.abs(predicted).max(axis=0) + NEARLY * (1 + plane.size)
        margins = closure.margins * np.sign(before.margins)
        kept = (margins >= KEPT * np.abs(before.margins)).all(axis=0)
        return np.asarray((closure.gap <= ACCEPTED * plane.tolerance) & near & kept)


def _lost(there: Plane, target: Plane, closure: Closure, before: Closure, predicted: Array) -> AssemblyError | SingularityError:
    """Why the linkage cannot be carried on."""
    assert before.margins is not None
    at = int(np.argmin(_belongs(there, closure, before, predicted)))
    angle, margin = float(before.position[there.driver, at]), float(np.abs(before.margins[:, at]).min(initial=1.0))
    end = close(target, np.array([angle]), before.position[:, at : at + 1])
    if end.gap[0] <= ACCEPTED * target.tolerance:
        return SingularityError("on the way to the new lengths two assemblies of the linkage meet; go there in other steps", angle, margin)
    gap = float(end.gap[0]) if np.isfinite(end.gap[0]) else np.inf
    return AssemblyError("the linkage cannot be assembled with the new lengths", angle, gap, end.iterations)
