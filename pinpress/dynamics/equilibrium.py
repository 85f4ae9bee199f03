"""Passive coordinates in static equilibrium with weights and springs, at every position of the motors.

The efforts r that hold the passive coordinates p still are zero: r(m, p) = 0 at motor positions m. Newton's method follows p from the
pose in which the linkage is put together. Only stable equilibria are taken, where the reduced stiffness dr/dp is positive definite: in a
place where it is not, steps go down the potential energy, as the linkage would. Speeds and accelerations are derivatives of p along the
path of the motors, p' = -K^-1 r' and p'' = -K^-1 r'', whose derivatives r' and r'' along the path are central differences of the 8th
order: in steps of 0.02 rad they miss 1e-13 of a smooth r.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..common.errors import AssemblyError, PinpressError
from ..common.quantities import Array
from ..engines.engine import CloseDrivers, ClosedStates, Engine
from ..engines.wrenches import AppliedConditions
from ..kinematics.motion import Motion, closed_motion, shared_by_motions
from ..linkage.linkage import Linkage
from ..loads.link import Load, Spring, is_constant
from . import applied_loads

STEP = 0.02  # of differences [rad or sizes of the linkage]
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])  # d/ds by 9 equal steps
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])  # d2/ds2
LONGEST = 0.1  # step of the motors between two equilibria [rad or sizes]
SHORTEST = 1e-4  # step below which the equilibrium ends there [rad or sizes]
FARTHEST = 0.2  # correction of one step of Newton's method [rad or sizes]
MOST_STEPS = 200  # of Newton's method from the pose in which the linkage is put together, downhill where it is not stable
FEW_STEPS = 8  # the same from a prediction
SETTLED = 1e-12  # correction at which an equilibrium is found [rad or sizes]


def equilibrium(press: Linkage, engine: Engine, motion: Motion, loads: Sequence[Load]) -> Motion:
    """The motion with its motors' positions, speeds and accelerations, and the passive coordinates in stable equilibrium with weights,
    springs in joints, and these loads. Inertia forces do not enter it: it is the motion of motors that move slowly.

    Raises:
        PinpressError: a load that is not constant and no spring; no stable equilibrium is near the pose in which the linkage is put
            together, or it ends at a motor position (a snap-through).
        AssemblyError: the loops do not close on the way.
    """
    for load in loads:
        if not isinstance(load, Spring) and not is_constant(load):
            raise PinpressError(f"an equilibrium takes constant forces, moments and springs, and not the load {load!r}: leave it out")
    statics = _Statics(press, engine, tuple(loads))
    count = len(press.motors)
    motors, speed, acceleration = (
        np.reshape(values, (len(motion.v), -1)).T[:count] for values in (motion.crank_angle, motion.crank_speed, motion.crank_acceleration)
    )
    position = _follow(statics, motors)
    v, a = _rates(statics, position, speed, acceleration)
    rates = engine.rates(position, v, a)
    states = ClosedStates(position, rates.v, rates.a, solved=rates.solved)
    return closed_motion(press, shared_by_motions(press), states, rates.gap, motion._time, None)


@dataclass(frozen=True, eq=False)
class _Statics:
    """A linkage at rest.

    Attributes:
        press: the linkage.
        engine: of the linkage.
        loads: constant forces and springs.
    """

    press: Linkage
    engine: Engine
    loads: tuple[Load, ...]

    @property
    def units(self) -> Array:
        """(drivers,) what counts as 1 rad of each driver [rad or m]."""
        return self.press.lengths[list(self.press.driver_indices)]

    @cached_property
    def close_drivers(self) -> CloseDrivers:
        return self.engine.closing_function()

    def closed(self, drivers: Array, guess: Array) -> Array:
        """Closed positions (nv, n) at driver positions (drivers, n), near guesses (nv, n); raises AssemblyError."""
        closure = self.close_drivers(drivers, np.zeros_like(drivers), guess)
        if not closure.widest <= self.engine.tolerance:
            worst = int(np.nan_to_num(closure.gap, nan=np.inf).argmax())
            place = self.press.structure.place_of_drivers(drivers[:, worst])
            problem = f"the loops of {self.press.name} do not close on the way to an equilibrium"
            raise AssemblyError(problem, float(drivers[0, worst]), float(closure.gap[worst]), closure.iterations, place)
        return closure.position

    def efforts(self, position: Array) -> Array:
        """(passive, n) efforts that hold the passive coordinates at closed positions (nv, n), by their units [N m, or N times the size]."""
        press, still = self.press, np.zeros_like(position)
        states = ClosedStates(position, still, still)
        motion = closed_motion(press, shared_by_motions(press), states, np.zeros(position.shape[1]), None, None)
        loads = applied_loads.apply(self.loads, press, motion, warned=True)
        conditions = AppliedConditions(loads, None, None, applied_loads.joint_efforts(press, self.engine, states))
        first = len(press.motors)
        torque = self.engine.inverse_dynamics(states, conditions, bearings=False).torque[first:]
        return np.asarray(torque * self.units[first:, None])

    def along(self, position: Array, path: Callable[[int], Array]) -> Array:
        """(9, passive, n) efforts beside closed positions (nv, n), where the drivers are at ``path`` of -4 to 4 steps, (drivers, n)."""
        efforts = np.empty((9, len(self.press.passive), position.shape[1]))
        efforts[4] = self.efforts(position)
        for way in (1, -1):
            near = position
            for k in range(way, 5 * way, way):
                near = self.closed(path(k), near)
                efforts[4 + k] = self.efforts(near)
        return efforts

    def roughly(self, position: Array) -> tuple[Array, Array]:
        """Efforts (n, passive) at closed positions (nv, n), and their derivatives (n, passive, passive) to about 9 digits, at once."""
        first, units, n = len(self.press.motors), self.units, position.shape[1]
        count, step = len(units) - first, 1e-5
        moved = np.zeros((len(units), 1 + 2 * count))
        moved[first:, 1:] = np.diag(step * units[first:]) @ np.hstack([np.eye(count), -np.eye(count)])
        beside = (position[list(self.press.driver_indices), :, None] + moved[:, None]).reshape(len(units), -1)
        efforts = self.efforts(self.closed(beside, np.repeat(position, 1 + 2 * count, axis=1))).reshape(count, n, -1)
        slopes = (efforts[..., 1 : 1 + count] - efforts[..., 1 + count :]) / (2 * step)
        return efforts[..., 0].T, slopes.transpose(1, 0, 2)

    def stiffness(self, position: Array) -> Array:
        """(n, passive, passive) derivatives of the efforts by the passive coordinates, in their units, at closed positions (nv, n)."""
        first, units = len(self.press.motors), self.units
        at, columns = position[list(self.press.driver_indices)], []
        for k in range(first, len(units)):
            way = np.zeros((len(units), 1))
            way[k] = STEP * units[k]

            def beside(place: int, way: Array = way) -> Array:
                return np.asarray(at + place * way)

            columns.append(np.tensordot(FIRST, self.along(position, beside), 1) / STEP)
        return np.array(columns).transpose(2, 1, 0)


def _follow(statics: _Statics, motors: Array) -> Array:
    """Closed positions (nv, n) in equilibrium at motor positions (motors, n), followed from the pose in which the linkage is put
    together: those a step apart one after the other, and from these all others at once where that works."""
    units, n = statics.units[: len(motors), None], motors.shape[1]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(motors / units), axis=0))])
    stations = [0]
    for k in range(1, n):
        if way[k] > way[stations[-1]] and (k == n - 1 or way[k + 1] > way[stations[-1]] + LONGEST):
            stations.append(k)
    for some in (stations, list(range(n))):
        walked = _walk(statics, motors[:, some])
        if len(some) == n:
            break
        guess = np.array([np.interp(way, way[some], row) for row in walked])
        drivers = guess[list(statics.press.driver_indices)]
        drivers[: len(motors)] = motors
        found = _settle(statics, drivers, guess, FEW_STEPS)
        if found is not None:
            return found
    return walked


def _walk(statics: _Statics, motors: Array) -> Array:
    """Closed positions (nv, n) in equilibrium at motor positions (motors, n), each followed from the one before."""
    press, units = statics.press, statics.units
    count, home = len(press.motors), press.closed[:, None]
    here = _settle(statics, home[list(press.driver_indices)], home, MOST_STEPS)
    if here is None:
        raise PinpressError(
            f"{press.name} has no stable equilibrium near the pose in which it is put together: draw it in one, or give load(..., pose=...)"
        )
    reached, slope = [], np.zeros((len(units), 1))
    for target in motors.T:
        step = LONGEST
        while True:
            at = here[list(press.driver_indices)]
            left = (target[:, None] - at[:count]) / units[:count, None]
            distance = float(np.linalg.norm(left))
            share = min(1.0, step / distance) if distance else 1.0
            wanted = at.copy()
            wanted[:count] = target[:, None] if share == 1.0 else at[:count] + share * left * units[:count, None]
            wanted[count:] += slope[count:] * share * distance
            there = _settle(statics, wanted, here, FEW_STEPS)
            if there is None:
                step, slope = 0.5 * min(step, distance), np.zeros_like(slope)
                if step < SHORTEST:
                    place = press.structure.place_of_drivers(at[:, 0])
                    raise PinpressError(
                        f"the equilibrium of {press.name} ends near {place}: it snaps over or tips there; keep the motors away, or let it"
                        " run (pp.simulate)"
                    )
                continue
            if distance:
                slope = (there[list(press.driver_indices)] - at) / (share * distance)
            here, step = there, min(LONGEST, 2.0 * step)
            if share == 1.0:
                break
        reached.append(here[:, 0])
    return np.array(reached).T


def _settle(statics: _Statics, drivers: Array, guess: Array, most: int) -> Array | None:
    """The closed positions (nv, n) in stable equilibrium near driver positions (drivers, n), whose motors stand; None if Newton's method
    does not find all of them in so many steps."""
    count, units, drivers = len(statics.press.motors), statics.units[:, None], drivers.copy()
    try:
        near = statics.closed(drivers, guess)
        for _ in range(most):
            efforts, stiffness = statics.roughly(near)
            values, ways = np.linalg.eigh(0.5 * (stiffness + stiffness.transpose(0, 2, 1)))
            largest = np.abs(values).max(axis=1, keepdims=True)
            if not (largest > 0).all():
                return None
            # where a value is negative, the step goes down the energy
            parts = np.einsum("nji,nj->ni", ways, efforts) / np.maximum(np.abs(values), 1e-6 * largest)
            downhill, newton = np.einsum("nij,nj->ni", ways, parts), np.linalg.solve(stiffness, efforts[:, :, None])[:, :, 0]
            against = np.where(values[:, :1] > 0, newton, downhill)
            size = np.abs(against).max(axis=1, keepdims=True)
            drivers[count:] -= (against * np.minimum(1.0, FARTHEST / np.maximum(size, FARTHEST))).T * units[count:]
            near = statics.closed(drivers, near)
            if size.max() <= SETTLED * max(1.0, float(np.abs(drivers / units).max())):
                return near if (values[:, :1] > 1e-9 * largest).all() else None
    except (AssemblyError, np.linalg.LinAlgError):
        return None
    return None


def _rates(statics: _Statics, position: Array, speed: Array, acceleration: Array) -> tuple[Array, Array]:
    """Speeds and accelerations (drivers, n) of all drivers in equilibrium, of those (motors, n) of the motors."""
    press, units = statics.press, statics.units[:, None]
    count, at = len(press.motors), position[list(press.driver_indices)]
    stiffness = statics.stiffness(position)
    v, a = np.zeros_like(at), np.zeros_like(at)
    v[:count], a[:count] = speed, acceleration
    for order, weights, rates in ((1, FIRST, v), (2, SECOND, a)):
        fastest = np.maximum(np.abs(v / units).max(axis=0), np.sqrt(np.abs(a / units).max(axis=0)))
        time = STEP / np.where(fastest > 0.0, fastest, 1.0)  # of one step of the differences [s]

        def later(place: int, time: Array = time) -> Array:
            return np.asarray(at + place * time * v + 0.5 * (place * time) ** 2 * a)

        efforts = statics.along(position, later)
        change = np.tensordot(weights, efforts, 1) / time**order
        rates[count:] = -np.linalg.solve(stiffness, change.T[:, :, None])[:, :, 0].T * units[count:]
    return v, a
