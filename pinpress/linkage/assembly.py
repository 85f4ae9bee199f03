"""How a linkage is assembled: its drawn pose closed by the engine that suits, and that assembly followed over the crank angle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import Array
from ..engines import branch
from ..engines.branch import SMALLEST_MARGIN, Branch, Gap, Returning
from ..engines.engine import ACCEPTED, Closure, Engine
from ..engines.forces import RANK
from ..engines.planar.engine import PlanarEngine
from ..engines.planar.kinematics import moves, openings
from ..engines.spatial.engine import SpatialEngine
from ..engines.spatial.kinematics import PassiveJacobian, close, rank
from ..engines.spatial.model import Rows, SpatialModel

CLEAR = 1e-2  # smallest margin of a redundant linkage over a turn; below it all its equations are solved in one block


class Assembly(NamedTuple):
    """A linkage put together in its drawn pose, the drivers at zero.

    Attributes:
        engines: the engines that can compute the linkage, by their names, the fastest first.
        drawn: the drawn pose, closed as far as Newton's method could.
        gaps: (rows,) of the equations of loops and couplings as drawn, see `engines.spatial.model`.
        determined: whether the drivers determine how all joints move there.
        rows: the equations in the closed pose; None where they have not been worked out yet.
        branch: the assembly over the crank angle; None where it has not been followed yet.
    """

    engines: Mapping[str, Engine]
    drawn: Closure
    gaps: Array
    determined: bool
    rows: Rows | None
    branch: Branch | None


def assembled(spatial_model: SpatialModel) -> Assembly:
    """The drawn pose of a linkage, closed by the fastest engine that can compute it."""
    start, spatial_engine = as_drawn(spatial_model), SpatialEngine(spatial_model)
    for one_block in (False, True) if len(spatial_model.drivers) == 1 else ():
        planar = PlanarEngine.of(spatial_model, one_block)
        if planar is None:
            break
        drawn = planar.close(np.zeros(1), start[:, None], with_margins=True)
        # A block of a redundant linkage may lock where the other blocks lead it: a parallelogram with a third crank at its change point.
        walked = _full_turn(planar, spatial_model, drawn) if planar.plane.redundant and not one_block else None
        fit = one_block or walked is not None or not planar.plane.redundant
        if fit and drawn.margins is not None and np.abs(drawn.margins).min(initial=1.0) > RANK:
            engines: dict[str, Engine] = {planar.name: planar, spatial_engine.name: spatial_engine}
            return Assembly(engines, drawn, _planar_gaps(planar, start), moves(planar.plane, drawn), None, walked)
    return _in_space(spatial_engine, start)


def _in_space(spatial_engine: SpatialEngine, start: Array) -> Assembly:
    """The drawn pose of any linkage from joint coordinates (nv,)."""
    spatial_model = spatial_engine.spatial
    count, equations = len(spatial_model.drivers), spatial_model.equations()
    along = np.array([1.0] + [0.0] * (count - 1))
    drawn = close(spatial_model, equations, np.zeros((count, 1)), along, start[:, None])
    gaps, rows, determined = equations.at(start).gaps, None, False
    if np.isfinite(drawn.position).all():
        rows = equations.at(drawn.position[:, 0])
        mobility = spatial_model.model.nv - rank(rows.columns)
        determined = mobility == count and PassiveJacobian(rows.columns, spatial_model).rank == len(spatial_model.passive_joints)
    return Assembly({spatial_engine.name: spatial_engine}, drawn, gaps, determined, rows, None)


def as_drawn(spatial_model: SpatialModel) -> Array:
    """(nv,) joint coordinates of the drawn pose as the file has it, not yet closed: zero, but for joints that a gear pair with an offset
    moves away from zero while the drivers are there."""
    position, found = np.zeros(spatial_model.model.nv), set(spatial_model.drivers)
    meshed: dict[int, list[tuple[int, float, float]]] = {}
    for each in spatial_model.couplings:
        meshed.setdefault(each.leader, []).append((each.follower, each.multiplier, each.offset))
        if each.multiplier:
            meshed.setdefault(each.follower, []).append((each.leader, 1 / each.multiplier, -each.offset / each.multiplier))
    followers = {each.follower for each in spatial_model.couplings}
    leaders = sorted({each.leader for each in spatial_model.couplings}, key=lambda joint: (joint in followers, joint))
    for start in (*sorted(found), *leaders):
        reached = [start]
        found.add(start)
        for joint in reached:  # grows as it goes
            for other, multiplier, offset in meshed.get(joint, ()):
                if other not in found:
                    position[other] = multiplier * position[joint] + offset
                    found.add(other)
                    reached.append(other)
    return position


def followed(
    engine: Engine,
    spatial_model: SpatialModel,
    closed: Array,
    *,
    smallest_margin: float = SMALLEST_MARGIN,
    gap: Gap | None = None,
    begin: float = 0.0,
) -> Branch:
    """The assembly of a linkage with one driver, followed over the crank angle from a closed pose (nv,); see `branch.walk`."""
    close_drivers, along = engine.closing_function(), np.ones(1)

    def close_angle(angle: Array, guess: Array) -> Closure:
        return close_drivers(angle[None], along, guess)

    returning = Returning(spatial_model.on_loop, np.array([axis.turns for axis in spatial_model.axes]))
    return branch.walk(close_angle, closed, returning, spatial_model.size, ACCEPTED * engine.tolerance, smallest_margin, gap, begin)


def through_change_points(engine: Engine, spatial_model: SpatialModel, found: Branch) -> Branch:
    """A branch followed further, through change points; see `Linkage.branch_through_change_points`."""
    if found.period is not None or not any(found.locks):
        return found
    middle = 0.5 * float(found.angles[0] + found.angles[-1])  # the drawn pose may be beside a change point
    start = branch.predict(found, np.array([middle]))[:, 0]
    further = followed(engine, spatial_model, start, gap=engine.gaps, begin=middle)
    return further if further.change_points else found


def _full_turn(planar: PlanarEngine, spatial_model: SpatialModel, drawn: Closure) -> Branch | None:
    """The branch, if the driver turns fully with the equations in the blocks of this engine and stays well away from locks; else None."""
    try:
        walked = followed(planar, spatial_model, drawn.position[:, 0], smallest_margin=CLEAR)
    except PinpressError:
        return None
    return walked if walked.period is not None else None


def _planar_gaps(planar: PlanarEngine, x: Array) -> Array:
    """`Assembly.gaps` of joint coordinates (nv,) of a planar linkage."""
    spatial_model = planar.spatial
    turns = np.zeros(sum(loop.held_rotations for loop in spatial_model.loops))  # axes are parallel in the plane
    slips = [
        (x[each.follower] - each.multiplier * x[each.leader] - each.offset)
        * (spatial_model.size if spatial_model.axes[each.follower].turns else 1.0)
        for each in spatial_model.couplings
    ]
    return np.concatenate([openings(planar.plane, x).ravel(), turns, slips])
