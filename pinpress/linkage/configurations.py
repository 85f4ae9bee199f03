"""Closed configurations of a linkage at any positions of its drivers, on the assembly that was drawn."""

from dataclasses import replace

import numpy as np

from ..common.errors import AssemblyError, PinpressError, SingularityError
from ..common.quantities import Array
from ..engines.branch import LARGEST_CORRECTION, Branch, SingularPosition, follow, predict
from ..engines.engine import ACCEPTED, PIECE, Closure, Engine, joined
from ..engines.spatial.model import SpatialModel

MANY_PERIODS = 1000  # from so many periods on the rounding of a crank angle is seen in the gaps of loops
FARTHEST = 1e7  # larger crank angles are rounded by more than 1e-9 rad, which the slide's position would show [rad]


def closed(engine: Engine, spatial_model: SpatialModel, branch: Branch, angles: Array, name: str) -> Closure:
    """Closed configurations at crank angles (n,) on a branch, in pieces that stay in the cache.

    Args:
        engine: engine of the linkage.
        spatial_model: constants of the linkage.
        branch: its drawn assembly.
        angles: (n,) crank angles [rad].
        name: name of the linkage, for errors.

    Raises:
        SingularityError: the linkage locks before one of the angles.
        AssemblyError: the loops do not close.
        PinpressError: the linkage is not followed as far, see `branch.predict`.
    """
    if branch.change_points:
        return _closed_through_change_points(engine, spatial_model, branch, angles, name)
    if branch.period is not None and np.abs(angles).max() > MANY_PERIODS * branch.period:
        return _closed_far_away(engine, spatial_model, branch, angles, name)
    if len(angles) <= PIECE:
        return _closed_piece(engine, spatial_model, angles, predict(branch, angles), name)
    parts = [angles[start : start + PIECE] for start in range(0, len(angles), PIECE)]
    return joined([_closed_piece(engine, spatial_model, part, predict(branch, part), name) for part in parts])


def followed_from(engine: Engine, spatial_model: SpatialModel, start: Array, angles: Array, name: str) -> Array:
    """Closed positions (nv, n) of a linkage with several drivers at driver positions (n, drivers), each followed from the one before.

    Args:
        engine: engine of the linkage.
        spatial_model: constants of the linkage.
        start: (nv,) closed drawn pose, from which the first position is followed.
        angles: (n, drivers) driver positions [rad].
        name: name of the linkage, for errors.

    Raises:
        SingularityError: the linkage locks on the way.
    """
    close_drivers, tolerance = engine.closing_function(), ACCEPTED * engine.tolerance
    position, before, positions = start, np.zeros(len(spatial_model.drivers)), []
    for after in angles:
        distance = float(np.linalg.norm(after - before))
        along = (after - before) / distance if distance else np.zeros_like(after)

        def close(at: Array, guess: Array, before: Array = before, along: Array = along) -> Closure:
            drivers = before[:, None] + np.multiply.outer(along, at)
            return close_drivers(drivers, along, guess)

        end = follow(close, position, distance, spatial_model.size, tolerance)
        if isinstance(end, SingularPosition):
            raise SingularityError(
                f"{name} locks between driver positions {np.degrees(before).round(3)} and {np.degrees(after).round(3)} deg",
                float((before + end.angle * along)[0]),
                end.margin,
            )
        positions.append(end)
        position, before = end, after
    return np.array(positions).T


def refuse_far(name: str, angles: Array) -> None:
    """Raise PinpressError where one of the crank angles [rad], of any shape, is so large that its rounding would be seen in results."""
    worst = float(angles.flat[int(np.abs(angles).argmax())])
    if abs(worst) > FARTHEST:
        raise PinpressError(
            f"{name} is {worst:.6g} rad, {abs(worst) / (2 * np.pi):.3g} turns away: numbers as large are {np.spacing(abs(worst)):.1g} rad"
            f" apart, and the slide would be somewhere else; stay within {FARTHEST:g} rad, take whole turns off"
        )


def _closed_piece(engine: Engine, spatial_model: SpatialModel, angles: Array, guess: Array, name: str) -> Closure:
    """Closed configurations at crank angles (n,) from guesses (nv, n) on the branch; raises AssemblyError."""
    closure, tolerance = engine.close(angles, guess), ACCEPTED * engine.tolerance
    if closure.widest <= tolerance and closure.iterations == 0:
        return closure
    near = LARGEST_CORRECTION * (1 + spatial_model.size)  # another assembly would be far from the prediction
    moved = np.abs(closure.position - guess).max(axis=0)
    if not (closure.widest <= tolerance and moved.max() <= near):
        worst = int(np.argmin((closure.gap <= tolerance) & (moved <= near)))
        problem = f"the loops of {name} do not close on the drawn branch"
        raise AssemblyError(problem, float(angles[worst]), float(closure.gap[worst]), closure.iterations)
    return closure


def _closed_far_away(engine: Engine, spatial_model: SpatialModel, branch: Branch, angles: Array, name: str) -> Closure:
    """Closed configurations many periods away. They are closed within one period, because the rounding of large angles would open the
    loops, and then moved by whole periods."""
    assert branch.period is not None
    turns = np.floor(angles / branch.period)
    closure = closed(engine, spatial_model, branch, angles - turns * branch.period, name)
    position = closure.position + branch.gain_per_period[:, None] * turns
    position[spatial_model.drivers[0]] = angles
    return replace(closure, position=position)


def _closed_through_change_points(engine: Engine, spatial_model: SpatialModel, branch: Branch, angles: Array, name: str) -> Closure:
    """Closed configurations of a branch with change points. Near these its polynomials replace the equations."""
    turns = np.zeros(len(angles)) if branch.period is None else np.floor((angles - branch.angles[0]) / branch.period)
    local = angles - turns * (branch.period or 0.0)
    position, first, second = (np.empty((spatial_model.model.nv, len(angles))) for _ in range(3))
    regular = np.ones(len(angles), dtype=bool)
    for point in branch.change_points:
        beside = np.abs(local - point.angle) < point.inner
        position[:, beside], first[:, beside], second[:, beside] = point.at(local[beside])
        regular &= ~beside
    if regular.any():
        closure = closed(engine, spatial_model, replace(branch, change_points=()), local[regular], name)
        position[:, regular], first[:, regular], second[:, regular] = closure.position, closure.first, closure.second
    gap = engine.gaps(position)
    if not gap.max() <= ACCEPTED * spatial_model.tolerance:
        raise AssemblyError("the loops do not close", float(angles[int(gap.argmax())]), float(gap.max()), 0)
    position += branch.gain_per_period[:, None] * turns
    position[spatial_model.drivers[0]] = angles
    return Closure(position, first, second, gap, float(gap.max()), 0)
