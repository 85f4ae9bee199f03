"""Equations of closed loops in NumPy, for programs that have none that are exact: they give Jacobians and gaps, an expert does the rest.

A loop's equations are points that coincide: one in a ball, two on the axis of a pin. Where loops hold each other, in the plane or by pins
in space, equations say the same twice; then rates and multipliers are those with the least sum of squares.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pinpress.common.errors import PinpressError, SimulationError
from pinpress.common.quantities import Array, ComplexArray
from pinpress.engines.constraints import LoopJoint
from pinpress.linkage.linkage import Linkage

RANK = 1e-9  # singular values below this are zero

SAMPLES = 512  # states of the turn that is walked when the model is made; Newton's method starts from them later
CLOSED = 1e-11  # largest last Newton step, whose Jacobian is of the state before it [m, rad]
MOST_NEWTON_STEPS = 12

Terms = Callable[[Array], tuple[Array, Array]]
"""Jacobian (rows, nv) and gaps (rows,) of the loops at joint coordinates (nv,)."""


class Ends(NamedTuple):
    """Two points that coincide in a closed loop.

    Attributes:
        name: name of the loop; a pin has two such points.
        joint1: Pinocchio joint whose body carries the first point, 0 for the frame.
        point1: (3,) place of the first point in that joint's frame [m].
        joint2: Pinocchio joint whose body carries the second point, 0 for the frame.
        point2: (3,) place of the second point in that joint's frame [m].
    """

    name: str
    joint1: int
    point1: Array
    joint2: int
    point2: Array


def ends_of(press: Linkage) -> tuple[Ends, ...]:
    """The points that coincide in the loops of a press with one driver.

    Raises:
        PinpressError: the press has several drivers, no loops, or a welded loop.
    """
    if len(press.drivers) > 1:
        raise PinpressError(f"it is compared on one driver, {press.name} has {len(press.drivers)}")
    if not press.loops:
        raise PinpressError(f"{press.name} has no loops, and needs nothing but its tree")
    return tuple(ends for loop in press.loops for ends in _ends(loop, 0.5 * press.size))


def _ends(loop: LoopJoint, arm: float) -> list[Ends]:
    if loop.type == "fixed":
        raise PinpressError(f"it is compared on balls and pins, and {loop.name} is a weld")
    along = [0.0, arm] if loop.type == "revolute" else [0.0]
    return [
        Ends(loop.name, loop.joint1, loop.point1 + s * loop.rotation1[:, 0], loop.joint2, loop.point2 + s * loop.rotation2[:, 0])
        for s in along
    ]


def carriers_of(press: Linkage) -> list[int]:
    """Of every Pinocchio joint the one whose body takes its part in programs that have no bodies without mass: a cross between two joints
    is left to the body after it."""
    tree = press.model
    carriers = list(range(tree.njoints))
    for j in range(tree.njoints - 1, 0, -1):
        children = [k for k in range(1, tree.njoints) if tree.parents[k] == j]
        if not tree.inertias[j].mass and len(children) == 1:
            carriers[j] = carriers[children[0]]
    return carriers


def with_loops(press: Linkage, ends: tuple[Ends, ...], tree: Array, on_second: Array) -> dict[str, Array]:
    """Forces of all bearings, parent on child and link1 on link2 (n, 3) [N].

    Args:
        press: the press.
        ends: its points that coincide.
        tree: (n, nv, 3) forces of the joints of the open tree, in world axes [N].
        on_second: (n, ends, 3) forces on the second points by the first ones, in world axes [N].
    """
    force = {name: tree[:, j].copy() for j, name in enumerate(press.joints)}
    force |= {loop.name: np.zeros((len(tree), 3)) for loop in press.loops}
    for k, end in enumerate(ends):
        force[end.name] += on_second[:, k]
        for joint, sign in ((end.joint1, 1.0), (end.joint2, -1.0)):
            while joint:  # all joints between the point and the frame carry it
                force[press.joints[joint - 1]] += sign * on_second[:, k]
                joint = press.model.parents[joint]
    return force


class LoopEquations:
    """Closing, rates and multipliers of a press's loops, for many states at once.

    Attributes:
        kept: rows of the Jacobian that have an effect: of a pin in the plane two of three.
        driver: the driver's place in v.
        passive: places of the other joints in v.
        square: whether there are as many equations as passive joints.
    """

    def __init__(self, press: Linkage, program: str, terms: Terms) -> None:
        """Walk a turn of the crank.

        Args:
            press: a press with one driver.
            program: name of the program, for messages.
            terms: what the program gives.

        Raises:
            PinpressError: the crank does not turn fully.
        """
        self._press, self._program, self._terms = press, program, terms
        self.driver = press.driver_indices[0]
        self.passive = [j for j in range(len(press.joints)) if j != self.driver]
        rows, _ = terms(press.closed)
        self.kept = np.flatnonzero(np.abs(rows).max(axis=1) > RANK)
        self.square = len(self.kept) == len(self.passive)
        self._turns, self._series = self._walked()

    def solve(self, matrix: Array, right: Array) -> Array:
        """Solutions (n, m) of systems (n, k, m) with right sides (n, k), by least squares where loops hold each other."""
        if self.square:
            return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
        return np.asarray((np.linalg.pinv(matrix, rcond=RANK) @ right[..., None])[..., 0])

    def rates(self, columns: Array, drift: Array, driver: float) -> Array:
        """(n, nv) joint rates, or accelerations with the drift (n, kept), for a given one of the driver."""
        rates = np.full((len(columns), columns.shape[2]), float(driver))
        rates[:, self.passive] = self.solve(columns[:, :, self.passive], -columns[:, :, self.driver] * driver - drift)
        return rates

    def multipliers(self, columns: Array, tree: Array) -> tuple[Array, Array]:
        """Torque on the driver (n,), and multipliers (n, rows) of all rows, from efforts of the open tree (n, nv)."""
        found = self.solve(columns[:, :, self.passive].swapaxes(1, 2), tree[:, self.passive])
        torque = tree[:, self.driver] - np.einsum("nr,nr->n", columns[:, :, self.driver], found)
        rows = np.zeros((len(tree), self._rows))
        rows[:, self.kept] = found
        return torque, rows

    def closed(self, angle: Array, guess: Array) -> tuple[Array, Array]:
        """Closed joint coordinates (n, nv) at crank angles (n,) and the Jacobians there (n, kept, nv), from guesses (n, nv).

        Raises:
            SimulationError: Newton's method does not converge.
        """
        x = guess.copy()
        x[:, self.driver] = angle
        last = np.inf
        for _ in range(MOST_NEWTON_STEPS):
            terms = [self._terms(state) for state in x]
            columns = np.array([columns for columns, _ in terms])[:, self.kept]
            gaps = np.array([gaps for _, gaps in terms])[:, self.kept]
            change = self.solve(columns[:, :, self.passive], gaps)
            x[:, self.passive] -= change
            last = float(np.abs(change).max(initial=0.0))
            if last < CLOSED:
                return x, columns
        raise SimulationError(f"{self._program} does not close the loops of {self._press.name}: its last Newton step is {last:.3g}")

    def predicted(self, angle: Array) -> Array:
        """(n, nv) joint coordinates at crank angles (n,), by the series of the walked turn."""
        powers = np.ones((len(angle), len(self._series)), dtype=complex)
        np.cumprod(np.broadcast_to(np.exp(1j * angle)[:, None], powers[:, 1:].shape), axis=1, out=powers[:, 1:])
        return np.asarray((powers @ self._series).real + angle[:, None] * self._turns)

    @property
    def _rows(self) -> int:
        return len(self._terms(self._press.closed)[1])

    def _walked(self) -> tuple[Array, ComplexArray]:
        """Whole turns of each joint in one of the crank (nv,), and the Fourier series (harmonics, nv) of the rest."""
        angles = 2 * np.pi * np.arange(SAMPLES + 1) / SAMPLES
        states = [self._press.closed.copy()]
        for k, angle in enumerate(angles):
            guess = states[-1] if k < 3 else 3 * states[-1] - 3 * states[-2] + states[-3]
            states.append(self.closed(np.array([angle]), guess[None])[0][0])
        walked = np.array(states[1:])
        turns = (walked[-1] - walked[0]) / (2 * np.pi)
        if np.abs(turns - turns.round()).max() > CLOSED:
            raise PinpressError(f"it needs a crank that turns fully and comes back, unlike that of {self._press.name}")
        series = np.fft.rfft(walked[:-1] - angles[:-1, None] * turns.round(), axis=0) / SAMPLES
        series[1:] *= 2
        seen = np.flatnonzero(np.abs(series).max(axis=1) > 1e-14)
        return turns.round(), series[: seen[-1] + 1]
