"""How a linkage is assembled: its drawn pose closed by the engine that suits, that assembly followed over the crank angle, and its closed
configurations at any positions of the drivers.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..common import plausibility
from ..common.errors import AssemblyError, PinpressError, SingularityError
from ..common.frozen import read_only
from ..common.quantities import Array, DriverCoordinate
from ..engines.branch import LARGEST_CORRECTION, Branch, Returning, Travel, leads_on, out_of_branch, predict, walk, walk_beside
from ..engines.change_points import Gap
from ..engines.constraints import Relation
from ..engines.engine import PIECE, Close, Closure, Engine, joined
from ..engines.following import COARSE_STEP, FIRST_STEP, SingularPosition, follow, follow_at_once, path_between
from ..engines.misfit import with_misfit
from ..engines.mounting import Mounting, limits
from ..engines.pinocchio.engine import PinocchioEngine
from ..engines.pinocchio.equations import OneConfiguration, Rows
from ..engines.planar.closing import can_move
from ..engines.planar.engine import PlanarEngine
from ..engines.planar.kinematics import openings
from ..engines.rank import PassiveJacobian, rank
from ..engines.spatial.engine import SpatialEngine
from ..engines.structure import ZERO, Structure

AS_DRAWN = "as drawn"
MANY_TURNS = 256  # of the crank, more than in a period: beyond them the rounding of angles is seen in the gaps of loops and gears
FARTHEST = 1e7  # larger crank angles are rounded by more than 1e-9 rad, which the slide's position would show [rad]


@dataclass(frozen=True, eq=False)
class Assembly:
    """A linkage put together in its home pose, see `Linkage.home`.

    Attributes:
        structure: of the linkage.
        engines: the engines that can compute the linkage, by their names, the fastest first.
        start: (nv,) joint coordinates as the file draws them, not yet closed [rad or m].
        drawn: the home pose, closed as far as Newton's method could.
        how: how the home pose was found.
        branch: the assembly over the crank angle; None if it has not been followed yet.
    """

    structure: Structure
    engines: Mapping[str, Engine]
    start: Array
    drawn: Closure
    how: str = AS_DRAWN
    branch: Branch | None = None

    @property
    def engine(self) -> Engine:
        """The fastest engine."""
        return next(iter(self.engines.values()))

    @property
    def closed(self) -> Array:
        """(nv,) joint coordinates of the closed pose [rad or m]."""
        return self.drawn.position[:, 0]

    @cached_property
    def closes(self) -> bool:
        """Whether the linkage closes in its home pose."""
        return bool(self.drawn.gap[0] <= self.engine.tolerance)

    @property
    def misfit(self) -> float:
        """Gap that is left in the loops because redundant equations contradict each other, as where the numbers of a file are rounded [m];
        0 where all of them close within rounding error."""
        return self.structure.misfit

    @cached_property
    def moved(self) -> dict[str, float]:
        """By how much closing has moved the joints from their drawn places, those that it moved [rad or m]."""
        names = tuple(self.structure.model.names)[1:]
        moves = (self.closed - self.start).tolist()
        return {name: move for name, move in zip(names, moves, strict=True) if abs(move) > 1e-9}  # less is rounding

    @property
    def gap_drawn(self) -> float:
        """The largest gap of a loop or relation as drawn [m]; angles count in sizes of the linkage."""
        return float(self.engine.gaps(self.start[:, None])[0])

    @cached_property
    def others(self) -> tuple[dict[str, float], ...]:
        """Other closed poses with the drivers at home, those among 20 random starts, the nearest to the drawing first: each as the
        coordinates of the one or two joints that tell it from the rest [rad or m]. With the drivers named beside them, as in
        ``load(..., pose={"motor": 0.0} | others[0])``, they choose it; alone they leave the drivers free too. At most 8. They are sought
        when they are first asked for."""
        return self._others[0]

    @property
    def nearer(self) -> dict[str, float] | None:
        """The first of the others, if its joints are nearer to their drawn places than at home."""
        poses, least = self._others
        return poses[0] if poses and least else None

    @cached_property
    def _others(self) -> tuple[tuple[dict[str, float], ...], bool]:
        """`others`, and whether the first of them is nearer to the drawing than home."""
        mounting, drivers = Mounting(self.structure), self.structure.drivers
        poses = [pose for pose in mounting.assemblies(self.closed, drivers, np.pi) if mounting.apart(pose, self.closed).max() > 1e-3]
        poses = sorted(poses, key=lambda pose: float(mounting.apart(pose, self.start).max()))[:8]
        away = [float(mounting.apart(pose, self.start).max()) for pose in (*poses[:1], self.closed)]
        told = mounting.told_apart([*poses, self.closed], len(poses), self.structure.passive_joints)
        return tuple(told), away[0] < away[-1]

    @cached_property
    def gaps(self) -> Array:
        """(rows,) gaps of the equations as drawn, see `engines.structure`."""
        if not isinstance(self.engine, PlanarEngine):
            return self.rows_as_drawn.gaps
        turns = np.zeros(sum(loop.held_rotations for loop in self.structure.loops))  # axes are parallel in the plane
        slips = self.structure.relation_slopes @ self.start - self.structure.relation_offsets
        return read_only(np.concatenate([openings(self.engine.plane, self.start).ravel(), turns, slips]))

    @property
    def rows(self) -> Rows:
        """The equations in the closed pose; in the pose as drawn, if Newton's method failed."""
        return self._rows[1]

    @property
    def rows_as_drawn(self) -> Rows:
        """The equations in the pose as drawn, not yet closed."""
        return self._rows[0]

    @cached_property
    def _rows(self) -> tuple[Rows, Rows]:
        """`rows_as_drawn` and `rows`, together because Pinocchio's workspace for both takes long to make."""
        equations = OneConfiguration(self.structure)
        as_drawn = equations.at(self.start)
        return read_only((as_drawn, equations.at(self.closed) if np.isfinite(self.closed).all() else as_drawn))

    @cached_property
    def determined(self) -> bool:
        """Whether the drivers determine how all joints move in the closed pose."""
        if isinstance(self.engine, PlanarEngine):
            return can_move(self.engine.plane, self.drawn)
        if not np.isfinite(self.closed).all():
            return False
        mobility = self.structure.model.nv - rank(self.rows.columns, self.structure.rank_tolerance)
        passive = PassiveJacobian(self.rows.columns, self.structure)
        return mobility == len(self.structure.drivers) and passive.rank == len(passive.joints)

    @property
    def redundant(self) -> bool:
        """Whether the engine solves more equations than there are joints to be determined."""
        if isinstance(self.engine, PlanarEngine):
            return self.engine.plane.redundant
        return len(self.rows.gaps) > len(self.structure.passive_joints)

    @cached_property
    def rank(self) -> int:
        """Rank of the equations in the closed pose."""
        return (
            int(self.structure.model.nv) - len(self.structure.drivers)
            if self.determined
            else rank(self.rows.columns, self.structure.rank_tolerance)
        )


def assemble(structure: Structure, home: Sequence[float] = (), how: str = "") -> Assembly:
    """The home pose (nv,) of a linkage, by default the drawn one, closed by the fastest engine that can compute it."""
    start = drawn_coordinates(structure)
    at, how = (np.array(home), how) if len(home) else (start, AS_DRAWN)
    assembly = _assembled(structure, start, at, how)
    # A branch that was followed over a full turn stays closed within rounding error.
    if assembly.closes and assembly.determined and (not assembly.redundant or assembly.branch is not None):
        return assembly
    rounded = with_misfit(structure, at)
    return assembly if rounded is structure else _assembled_in_space(rounded, start, at, how)


def _assembled(structure: Structure, start: Array, home: Array, how: str) -> Assembly:
    """`assemble` of a linkage whose equations agree within rounding error, drawn and at home at joint coordinates (nv,)."""
    in_space, drivers = SpatialEngine(structure), home[list(structure.drivers)]
    for one_block in (False, True) if len(structure.drivers) == 1 else ():
        planar = PlanarEngine.of(structure, one_block)
        if planar is None:
            break
        drawn = planar.close(drivers, home[:, None], with_margins=True)
        # A block of a redundant linkage may lock where the other blocks lead it: a parallelogram with a third crank at its change point.
        walked = _full_turn(planar, structure, drawn) if planar.plane.redundant and not one_block else None
        fit = one_block or walked is not None or not planar.plane.redundant
        if fit and drawn.margins is not None and np.abs(drawn.margins).min(initial=1.0) > ZERO:
            engines: dict[str, Engine] = {engine.name: engine for engine in (planar, in_space, PinocchioEngine(structure))}
            return Assembly(structure, engines, start, drawn, how, walked)
    return _assembled_in_space(structure, start, home, how)


def _assembled_in_space(structure: Structure, start: Array, home: Array, how: str) -> Assembly:
    """`_assembled` by the engine in space."""
    in_space, drivers = SpatialEngine(structure), home[list(structure.drivers)]
    drawn = in_space.closing_function()(drivers[:, None], np.eye(len(drivers), 1), home[:, None])
    return Assembly(structure, {engine.name: engine for engine in (in_space, PinocchioEngine(structure))}, start, drawn, how)


def walk_branch(
    engine: Engine,
    structure: Structure,
    start: Array,
    *,
    smallest_margin: float = 0.0,
    gap: Gap | None = None,
) -> Branch:
    """The assembly of a linkage with one driver, followed over the crank angle from a closed pose (nv,); see `engines.branch.walk`.
    A driver that slides goes as far as the limits of its joint."""
    smallest_margin = max(smallest_margin, structure.smallest_margin)
    close_angle, tolerance = _closing_function(engine), engine.tolerance
    returning = Returning(structure.returning, structure.turns)
    begin = float(start[structure.drivers[0]])
    return walk(close_angle, start, returning, structure.size, tolerance, smallest_margin, gap, begin, _travel(structure, begin))


def walk_branch_beside(engine: Engine, structure: Structure, branch: Branch, home: Array) -> Branch | None:
    """The assembly of a linkage with one driver, found from that of one with nearly the same lengths and the same home pose (nv,); see
    `engines.branch.walk_beside`."""
    driver = structure.drivers[0]
    travel = _travel(structure, float(home[driver]))
    if travel is not None and (travel.lower, travel.upper) != (branch.angles[0], branch.angles[-1]):
        return None
    return walk_beside(_closing_function(engine), branch, home, driver, structure.size, engine.tolerance)


def _closing_function(engine: Engine) -> Close:
    """The closing function of an engine, over the positions of the one driver."""
    close_drivers = engine.closing_function()

    def close_angle(angle: Array, guess: Array) -> Closure:
        return close_drivers(angle[None], np.ones((1, len(angle))), guess)

    return close_angle


def _travel(structure: Structure, home: float) -> Travel | None:
    """How far a driver slides: between the limits of its joint, and from its ``home`` [m] if that is outside; None of one that turns."""
    driver = structure.drivers[0]
    if structure.axes[driver].turns:
        return None
    farthest = 20.0 * structure.size  # a driver that slides without limits is followed as far
    lower, upper = (float(limit[driver]) for limit in limits(structure))
    lower, upper = min(home, max(lower, home - farthest)), max(home, min(upper, home + farthest))
    return Travel(lower, upper, min(structure.size, (upper - lower) / (2 * np.pi)))


def walk_through_change_points(engine: Engine, structure: Structure, walked: Branch) -> Branch:
    """A branch followed further, through change points; see `Linkage.branch_through_change_points`."""
    if walked.period is not None or not any(walked.locks):
        return walked
    tolerance = engine.tolerance
    if walked.coordinate.turns and not leads_on(_closing_function(engine), walked, structure.size, tolerance, engine.gaps):
        return walked
    middle = 0.5 * float(walked.angles[0] + walked.angles[-1])  # the drawn pose may be beside a change point
    start = predict(walked, np.array([middle]))[:, 0]
    start[structure.drivers[0]] = middle
    further = walk_branch(engine, structure, start, gap=engine.gaps)
    return further if further.change_points else walked


def close_on_branch(engine: Engine, structure: Structure, branch: Branch, angles: Array, name: str) -> Closure:
    """Closed configurations at crank angles (n,) on a branch, in pieces that stay in the cache.

    Args:
        engine: engine of the linkage.
        structure: constants of the linkage.
        branch: its drawn assembly.
        angles: (n,) crank angles [rad or m].
        name: name of the linkage, for errors.

    Raises:
        SingularityError: the linkage locks before one of the angles.
        AssemblyError: the loops do not close.
        PinpressError: the linkage is not followed as far, see `engines.branch.predict`.
    """
    if branch.change_points:
        return _close_through_change_points(engine, structure, branch, angles, name)
    ends = np.minimum.reduce(angles), np.maximum.reduce(angles)
    if branch.period is None and not branch.angles[0] <= ends[0] <= ends[1] <= branch.angles[-1]:
        further = walk_through_change_points(engine, structure, branch)
        raise out_of_branch(branch, bool(ends[1] > branch.angles[-1]), further)
    if branch.period is not None and max(-ends[0], ends[1]) > MANY_TURNS * 2 * np.pi:
        return _close_far_away(engine, structure, branch, angles, name)
    if len(angles) <= engine.piece:
        return _close_piece(engine, structure, angles, predict(branch, angles, ends), name)
    parts = (angles[start : start + engine.piece] for start in range(0, len(angles), engine.piece))
    return joined((_close_piece(engine, structure, part, predict(branch, part), name) for part in parts), len(angles))


def follow_drivers(
    engine: Engine,
    structure: Structure,
    start: Array,
    angles: Array,
    name: str,
    locked: dict[int, SingularityError] | None = None,
    smallest_margin: float = 0.0,
) -> Array:
    """Closed positions (nv, n) of a linkage with several drivers at driver positions (n, drivers), each followed from the one before.

    Args:
        engine: engine of the linkage.
        structure: constants of the linkage.
        start: (nv,) closed home pose, from which the first position is followed.
        angles: (n, drivers) driver positions [rad or m].
        name: name of the linkage, for errors.
        locked: to be filled in: which positions are not reached because the linkage locks on the way from the last one that is, and the
            errors that say where. They are then ``start``. None: the first of these errors is raised.
        smallest_margin: margin below which the linkage counts as locked, if it is larger than that of the structure.

    Raises:
        SingularityError: the linkage locks on the way.
        PinpressError: a driver slides beyond the limits of its joint.
    """
    begin = start[list(structure.drivers)]
    _refuse_beyond_limits(structure, begin, angles)
    close_drivers, tolerance = engine.closing_function(), engine.tolerance
    least = max(structure.smallest_margin, smallest_margin)
    at, here, result, done, tried = begin, start, np.empty((len(start), len(angles))), 0, PIECE
    while done < len(angles):
        path = np.concatenate([at[None], angles[done : done + tried]])
        path_to = path_between(path, structure.lengths[list(structure.drivers)], PIECE)
        reached = follow_at_once(close_drivers, here, path_to, structure.size, tolerance, least)
        count = reached.shape[1]
        tried = min(PIECE, max(1, 2 * count))
        if not count:
            try:
                reached, count = _walk_between(engine, structure, here, path[0], path[1], name, least)[:, None], 1
            except SingularityError as error:
                if locked is None:
                    raise
                skipped = 1 + _first_within_reach(engine, structure, here, angles[done + 1 :])
                locked |= dict.fromkeys(range(done, done + skipped), error)
                result[:, done : done + skipped] = start[:, None]
                done += skipped
                continue
        result[:, done : done + count] = reached
        at, here, done = path[count], reached[:, -1], done + count
    return result


def _first_within_reach(engine: Engine, structure: Structure, start: Array, angles: Array) -> int:
    """How many of the driver positions (n, drivers) come before the first to which the linkage may be moved from a closed pose (nv,), on a
    straight line.

    All are tried at once, in steps that grow as those of a walk, of which each has to close. Walking to each would take a thousand times as
    long where the way is locked.
    """
    close_drivers, unit, begin = engine.closing_function(), structure.lengths[list(structure.drivers)], start[list(structure.drivers)]
    tried, count = 0, 16
    while tried < len(angles):
        ways = (angles[tried : tried + count] - begin).T
        distances, kept = np.linalg.norm(ways / unit[:, None], axis=0), np.arange(ways.shape[1])
        x, gone, step = np.repeat(start[:, None], len(kept), axis=1), 0.0, FIRST_STEP
        while len(kept) and gone < distances[kept].max():
            gone, step = gone + step, min(2 * step, COARSE_STEP)
            share = np.minimum(1.0, gone / np.maximum(distances[kept], FIRST_STEP))
            closure = close_drivers(begin[:, None] + share * ways[:, kept], np.zeros_like(ways[:, kept]), x)
            closes = closure.gap <= engine.tolerance
            kept, x = kept[closes], closure.position[:, closes]
        if len(kept):
            return tried + int(kept[0])
        tried, count = tried + count, min(PIECE, 2 * count)
    return len(angles)


def _walk_between(
    engine: Engine, structure: Structure, start: Array, before: Array, after: Array, name: str, smallest_margin: float
) -> Array:
    """Closed position (nv,) of a linkage with several drivers, walked to from a closed position (nv,) between two driver positions
    (drivers,); raises SingularityError."""
    close_drivers = engine.closing_function()
    distance = float(np.linalg.norm((after - before) / structure.lengths[list(structure.drivers)]))
    along = (after - before) / distance if distance else np.zeros_like(after)

    def close(at: Array, guess: Array) -> Closure:
        return close_drivers(before[:, None] + np.multiply.outer(along, at), np.repeat(along[:, None], len(at), axis=1), guess)

    end = follow(close, start, distance, structure.size, engine.tolerance, smallest_margin)
    if isinstance(end, SingularPosition):
        locked = before + end.angle * along
        from_here, to_there, place = map(structure.place_of_drivers, (before, after, locked))
        problem = f"{name} locks on the way from {from_here} to {to_there}: keep the motion away from there"
        raise SingularityError(problem, float(locked[0]), end.margin, place, locked.tolist())
    return end


def _refuse_beyond_limits(structure: Structure, begin: Array, angles: Array) -> None:
    """Raise PinpressError if one of several drivers slides beyond the limits of its joint, or beyond where it begins (drivers,);
    ``angles``: (n, drivers) [rad or m]."""
    lower, upper = limits(structure)
    for driver, home, coordinate, positions in zip(structure.drivers, begin.tolist(), structure.coordinates, angles.T, strict=True):
        if coordinate.turns:
            continue
        low, high = min(float(lower[driver]), home), max(float(upper[driver]), home)
        worst = float(positions[np.maximum(low - positions, positions - high).argmax()])
        if not low - 1e-9 <= worst <= high + 1e-9:  # files round limits
            raise PinpressError(
                f"driver {structure.model.names[driver + 1]!r} slides from {coordinate.shown(low)} to {coordinate.shown(high)} only, the"
                f" <limit> of its joint, and is to be at {coordinate.shown(worst)}: keep the motion inside, or widen the limit"
            )


def refuse_far(name: str, angles: Array, coordinates: Sequence[DriverCoordinate]) -> None:
    """Raise PinpressError if one of the crank angles [rad], of any shape, is so large that its rounding would be seen in results, and
    warn of angles that are whole degrees. How far a driver slides is limited in any case."""
    if not coordinates[0].turns:
        return
    worst = float(angles.flat[int(np.abs(angles).argmax())])
    if abs(worst) > FARTHEST:
        raise PinpressError(
            f"{name} is {worst:.6g} rad, {abs(worst) / (2 * np.pi):.3g} turns away: numbers as large are {np.spacing(abs(worst)):.1g} rad"
            f" apart, and the slide would be somewhere else; stay within {FARTHEST:g} rad, take whole turns off"
        )
    plausibility.angles(name, angles)


def drawn_coordinates(structure: Structure) -> Array:
    """(nv,) joint coordinates of the drawn pose as the file has it, not yet closed: zero, but for joints that a gear pair with an offset
    moves away from zero while the drivers are at zero."""
    position, placed = np.zeros(structure.model.nv), set(structure.drivers)
    followers = {relation.joint for relation in structure.relations}
    leaders = {joint for relation in structure.relations for joint in relation.ratios}
    for start in (*structure.drivers, *sorted(leaders, key=lambda joint: (joint in followers, joint))):
        placed.add(start)
        while moved := next(_relations_with_one_joint_left(structure, placed), None):
            relation, joint = moved
            others = sum(by * position[other] for other, by in relation.coefficients.items() if other != joint)
            position[joint] = (relation.offset - others) / relation.coefficients[joint]
            placed.add(joint)
    return position


def _relations_with_one_joint_left(structure: Structure, placed: Collection[int]) -> Iterator[tuple[Relation, int]]:
    """The linear relations all of whose joints but one are placed, with this joint."""
    for relation in (relation for relation in structure.relations if relation.curve is None):
        left = [joint for joint, coefficient in relation.coefficients.items() if coefficient and joint not in placed]
        if len(left) == 1:
            yield relation, left[0]


def _full_turn(planar: PlanarEngine, structure: Structure, drawn: Closure) -> Branch | None:
    """The branch, if the driver turns fully with the equations in the blocks of this engine and stays well away from locks; else None."""
    try:
        walked = walk_branch(planar, structure, drawn.position[:, 0], smallest_margin=1e-2)  # near a lock one block is safer
    except PinpressError:
        return None
    return walked if walked.period is not None else None


def _close_piece(engine: Engine, structure: Structure, angles: Array, guess: Array, name: str) -> Closure:
    """Closed configurations at crank angles (n,) from guesses (nv, n) on the branch; raises AssemblyError."""
    closure, tolerance = engine.close(angles, guess), engine.tolerance
    if closure.widest <= tolerance and closure.iterations == 0:
        return closure
    near = LARGEST_CORRECTION * (1 + structure.size)  # another assembly would be far from the prediction
    moved = np.abs(closure.position - guess).max(axis=0)
    if not (closure.widest <= tolerance and moved.max() <= near):
        worst = int(np.argmin((closure.gap <= tolerance) & (moved <= near)))
        problem = f"the loops of {name} do not close on the drawn branch"
        raise AssemblyError(
            problem,
            float(angles[worst]),
            float(closure.gap[worst]),
            closure.iterations,
            structure.coordinates[0].at(float(angles[worst])),
        )
    return closure


def _close_far_away(engine: Engine, structure: Structure, branch: Branch, angles: Array, name: str) -> Closure:
    """Closed configurations many turns away. They are closed within one period, because the rounding of large angles would open the
    loops, and then moved by whole periods."""
    assert branch.period is not None
    turns = np.floor(angles / branch.period)
    closure = close_on_branch(engine, structure, branch, angles - turns * branch.period, name)
    position = closure.position + branch.gain_per_period[:, None] * turns
    position[structure.drivers[0]] = angles
    gains = zip(branch.gain_per_period / (2 * np.pi), structure.axes, strict=True)
    if any(gain and (not axis.turns or abs(gain - np.round(gain)) > 1e-9) for gain, axis in gains):
        return replace(closure, position=position, basis=None, solved=None)  # these are of where its slides and geared shafts were
    return replace(closure, position=position)


def _close_through_change_points(engine: Engine, structure: Structure, branch: Branch, angles: Array, name: str) -> Closure:
    """Closed configurations of a branch with change points. Near these its polynomials replace the equations."""
    turns = np.zeros(len(angles)) if branch.period is None else np.floor((angles - branch.angles[0]) / branch.period)
    local = angles - turns * (branch.period or 0.0)
    position, first, second = (np.empty((structure.model.nv, len(angles))) for _ in range(3))
    regular = np.ones(len(angles), dtype=bool)
    for point in branch.change_points:
        beside = np.abs(local - point.angle) < point.inner
        position[:, beside], first[:, beside], second[:, beside] = point.at(local[beside])
        regular &= ~beside
    if regular.any():
        closure = close_on_branch(engine, structure, replace(branch, change_points=()), local[regular], name)
        position[:, regular], first[:, regular], second[:, regular] = closure.position, closure.first, closure.second
    gap = engine.gaps(position)
    if not gap.max() <= structure.tolerance:
        worst = int(gap.argmax())
        raise AssemblyError(
            f"the loops of {name} do not close",
            float(angles[worst]),
            float(gap[worst]),
            0,
            structure.coordinates[0].at(float(angles[worst])),
        )
    position += branch.gain_per_period[:, None] * turns
    position[structure.drivers[0]] = angles
    return Closure(position, first, second, gap, float(gap.max()), 0)
