"""Feet that lift off, by a solver for differential equations with events: another way to `pinpress.foundation.lifting_response`.

The equations are written anew from the matrices of the press and its mounts, force and damping of each mount by itself. The solver is one
of those that simulations use, DOP853 or Radau IIA of seven stages; feet switch at zeros on its interpolation. The force is any function of
time.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import DOP853, OdeSolver
from scipy.optimize import brentq

from pinpress.common.integrators import RadauIIA
from pinpress.foundation import MountedPress

LOOKS = np.linspace(0.0, 1.0, 9)[1:]
LEAST_RELATIVE = 3e-14


@dataclass
class Feet:
    """The feet of a press without loss factors, and the motion that is found: its states at the times asked for, and its switches.

    Attributes:
        system: the press on its mounts.
        force: (coordinates,) on the coordinates at a time.
        standing: which feet stand.
        anchor: (mounts, 3) how far from its place each pad grips its foot [m].
        switches: times of lifts and landings [s].
        evaluations: of the rates.
    """

    system: MountedPress
    force: Callable[[float], np.ndarray]
    standing: np.ndarray
    anchor: np.ndarray
    switches: list[tuple[float, int]] = field(default_factory=list)
    evaluations: int = 0

    def __post_init__(self):
        assert not self.system.loss.any()
        self.rows = np.array(self.system.mount_rows)
        self.stiff = np.array([mount.stiffness for mount in self.system.mounts])
        self.damp = np.array([mount.damping for mount in self.system.mounts])
        self.inner = self._without_mounts(self.system.stiffness, self.stiff), self._without_mounts(self.system.damping, self.damp)
        self.inverse = np.linalg.inv(self.system.mass)
        self.free = self.system.mount_load[:, 2] / self.stiff[:, 2]

    def _without_mounts(self, matrix, constants):
        return matrix - np.einsum("mki,mk,mkj->ij", self.rows, constants, self.rows)

    def mount_force(self, x):
        """Force (mounts, 3) of each mount on the frame if all stood."""
        n = len(x) // 2
        return self.system.mount_load - self.stiff * (self.rows @ x[:n] - self.anchor) - self.damp * (self.rows @ x[n:])

    def rate(self, t, x):
        self.evaluations += 1
        n = len(x) // 2
        beside = np.where(self.standing[:, None], self.mount_force(x), 0.0) - self.system.mount_load
        pushed = self.force(t) + np.einsum("mk,mkj->j", beside, self.rows) - self.inner[0] @ x[:n] - self.inner[1] @ x[n:]
        return np.concatenate([x[n:], self.inverse @ pushed])

    def goes_on(self, x):
        """(mounts,) positive while a foot goes on as it does [N]."""
        pressing = self.mount_force(x)[:, 2]
        above = self.stiff[:, 2] * (self.rows[:, 2] @ x[: len(x) // 2] - self.free)
        return np.where(self.standing, pressing, np.maximum(-pressing, above))

    def switch(self, t, number, x):
        self.standing = self.standing.copy()
        self.standing[number] = not self.standing[number]
        self.switches.append((t, number))
        if self.standing[number]:
            there = self.rows[number] @ x[: len(x) // 2]
            slack = np.divide(self.system.mount_load[number], self.stiff[number], out=np.zeros(3), where=self.stiff[number] > 0)
            self.anchor[number, :2] = np.where(self.stiff[number] > 0, there - slack, 0.0)[:2]


def motion(system, force, begin, times, *, method, tolerance, longest):
    """States (times, 2 n) of a motion from a state on.

    Args:
        system: the press on its mounts, with dampers and no loss factors.
        force: (n,) on the coordinates at a time.
        begin: (2 n,) state at the first of the times.
        times: rising [s].
        method: "explicit" or "implicit".
        tolerance: error of a step by the size of displacements and velocities.
        longest: longest step [s].

    Returns:
        The states, and the `Feet` with their switches.
    """
    feet = Feet(system, force, np.ones(len(system.mounts), dtype=bool), np.zeros((len(system.mounts), 3)))
    feet.standing = feet.goes_on(begin) >= 0
    n = len(begin) // 2
    sizes = np.repeat([float(np.abs(feet.free).max()), float(np.abs(feet.free).max() * np.sqrt(feet.stiff.sum() / system.total_mass))], n)
    t, x, found, at, fresh = times[0], np.array(begin), np.zeros((len(times), 2 * n)), 0, -1
    while t < times[-1]:
        solver = _stepper(feet, t, x, times[-1], method, tolerance, sizes, longest)
        switched = None
        while switched is None and solver.status == "running":
            message = solver.step()
            assert solver.status != "failed", message
            dense, since = solver.dense_output(), solver.t_old
            switched = _first(feet, dense, since, solver.t, fresh)
            end = solver.t if switched is None else switched[0]
            upto = int(np.searchsorted(times, end, "right"))
            found[at:upto] = np.array([dense(each) for each in times[at:upto]]).reshape(-1, 2 * n)
            at, fresh = upto, -1
        t = solver.t
        x = np.array(solver.y)
        if switched is not None:
            t, fresh = switched
            x = np.array(dense(t))
            feet.switch(t, fresh, x)
    return found, feet


def _stepper(feet, t, x, end, method, tolerance, sizes, longest) -> OdeSolver:
    if method == "explicit":
        return DOP853(feet.rate, t, x, end, rtol=LEAST_RELATIVE, atol=tolerance * sizes, max_step=longest)
    return RadauIIA(feet.rate, t, x, end, tolerance * sizes, LEAST_RELATIVE, 0, sizes, min(longest, end - t))


def _first(feet, dense, since, until, fresh):
    """Instant and number of the first foot that switches within a step; None where none does."""
    found = []
    ends = since + LOOKS * (until - since)
    values = np.array([feet.goes_on(dense(each)) for each in ends])
    for number in np.flatnonzero((values < 0).any(axis=0)):
        k = int((values[:, number] < 0).argmax())
        low = since if k == 0 else ends[k - 1]
        if k == 0 and (number == fresh or feet.goes_on(dense(low))[number] <= 0):
            low = since + 1e-6 * (ends[0] - since)
        if feet.goes_on(dense(low))[number] <= 0:
            found.append((low, int(number)))
            continue
        zero = brentq(lambda t, number=number: float(feet.goes_on(dense(t))[number]), low, ends[k], xtol=1e-15)
        found.append((float(zero), int(number)))
    return min(found, default=None)
