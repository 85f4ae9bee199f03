"""Modes of a press whose flywheel and other rotors spin: forward and backward whirl over the speed, and critical speeds.

Gyroscopic moments do no work, so an undamped system keeps its energy: M u'' + w G u' + K u = 0 has n real frequencies at every crank speed
w. With Cholesky factors M = A A^T, K = B B^T and x = (B^T u, A^T u'), whose square is twice the energy,

    x' = S x,  S = [[0, B^T A^-T], [-A^-1 B, -w A^-1 G A^-T]]

where S is skew-symmetric: its eigenvalues are purely imaginary and its eigenvectors orthogonal. They are computed from the Hermitian matrix
-i S. At a critical speed, where the crank's harmonic of order k meets a natural frequency, (K - w^2 (k^2 M - i k G)) u = 0, a Hermitian
eigenvalue problem in 1 / w^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import suitable_numbers, typed, whole_number
from ..common.errors import PinpressError
from ..common.frozen import read_only
from ..common.numerics import pair_modes
from ..common.quantities import Array, ComplexArray
from ..common.results import Tabular
from .mounted_press import MOST_ORDERS, MountedPress, motion_in_words

SAME_MODE = 0.7  # least scalar product of the shapes of a mode at two consecutive speeds


@dataclass(frozen=True, eq=False, repr=False)
class WhirlDiagram(Tabular):
    """The n modes of a press on its mounts over the speed of its crank, each mode tracked from the lowest speed. All arrays are read-only.

    Attributes:
        system: the press on its mounts.
        speed: (s,) speeds of the crank [rad/s].
        frequency: (s, n) natural frequencies without damping [rad/s].
        damping_ratio: (s, n) damping ratio of each mode by dampers and loss factors, to first order in the damping [-].
        whirl: (s, n) sense of whirl of the rotors' axes: 1 on a circle forward (with the rotor's spin), -1 on a circle backward, 0 on a
            line.
        shapes: (s, n, coordinates) complex shapes u, which move as the real part of u exp(i frequency time), of u* M u = 1 kg.
    """

    system: MountedPress
    speed: Array
    frequency: Array
    damping_ratio: Array
    whirl: Array
    shapes: ComplexArray

    @property
    def title(self) -> str:
        low, high = self.speed[0], self.speed[-1]
        return f"WhirlDiagram of {self.system.press.name}: {self.frequency.shape[1]} modes from {low:.4g} to {high:.4g} rad/s"

    def words(self, mode: int) -> str:
        """Sense of whirl of a mode at the highest speed: "forward", "backward", or "" if it hardly whirls."""
        turns = float(self.whirl[-1, mode])
        # less than a tenth of the motion is whirl: neither forward nor backward
        return "" if abs(turns) < 0.1 else "forward" if turns > 0 else "backward"

    def motion(self, mode: int) -> str:
        """Name of the motion with most of a mode's kinetic energy at the highest speed, at the instant when this energy is largest, as in
        `VibrationModes.motion`."""
        shape = self.shapes[-1, mode]
        phase = np.exp(-0.5j * np.angle(shape @ self.system.mass @ shape))
        return motion_in_words(self.system, (shape * phase).real)

    def critical_speeds(self, order: int = 1) -> Array:
        """(c,) critical speeds: crank speeds at which a harmonic of the crank meets a natural frequency, rising [rad/s].

        They are exact, also outside the range of ``speed``. There are at most n: the frequency of a forward mode may rise faster than the
        harmonic.

        Args:
            order: harmonic of the crank, 1 to 10 000.

        Raises:
            PinpressError: ``order`` is not a whole number in this range.
        """
        from scipy.linalg import eigh  # slow to import

        k = whole_number("order", order, 1, MOST_ORDERS)
        inverse = eigh(k**2 * self.system.mass - 1j * k * self.system.gyroscopic, self.system.stiffness, eigvals_only=True)
        least = np.finfo(float).eps * np.abs(inverse).max()
        return np.asarray(1 / np.sqrt(inverse[inverse > least][::-1]))

    def columns(self) -> dict[str, Array]:
        """A row for each speed: frequency, damping ratio and whirl of every mode."""
        columns = {"speed [rad/s]": self.speed}
        for k in range(self.frequency.shape[1]):
            columns |= {
                f"frequency_{k + 1} [rad/s]": self.frequency[:, k],
                f"damping_ratio_{k + 1} [-]": self.damping_ratio[:, k],
                f"whirl_{k + 1} [-]": self.whirl[:, k],
            }
        return columns


@typed
def whirl(system: MountedPress, speeds: ArrayLike) -> WhirlDiagram:
    """Find the modes of a press whose rotors spin, over the speed of its crank.

    Args:
        system: the press on its mounts, with rotors.
        speeds: (s,) speeds of the crank, rising, the first one zero or positive [rad/s].

    Raises:
        PinpressError: the system has no rotors, or the speeds are not as described.
    """
    if not system.rotors:
        raise PinpressError("nothing spins on the frame: give rotors= to mounted, or take modes")
    wanted = "an array of numbers, rising, none negative, the last one positive [rad/s]"
    speed = suitable_numbers(
        "speeds", speeds, wanted, (None,), lambda values: len(values) and values[0] >= 0 and values[-1] > 0 and np.all(np.diff(values) > 0)
    )
    equations = _Equations.of(system)
    # modes may have equal frequencies at standstill; a millionth of the highest speed separates them
    followed = [equations.modes(float(speed[0]) or 1e-6 * float(speed[-1]))]
    for low, high in pairwise(speed.tolist()):
        followed.append(equations.follow(followed[-1], low, high, 8))  # at most 8 halvings of an interval of speeds
    frequency, vectors = (np.array([each[k] for each in followed]) for k in (0, 1))
    if speed[0] == 0:
        frequency[0] = equations.modes(0.0)[0]
    n = len(system.mass)
    moving = np.linalg.solve(equations.mass_factor.T, vectors[:, n:])  # velocities (s, n, modes); the total energy of a mode is 1 / 2
    resisted = [np.einsum("sik,ij,sjk->sk", moving.conj(), matrix, moving).real for matrix in (system.damping, system.loss)]
    shapes = np.swapaxes(moving / (1j * frequency[:, None, :]), 1, 2)
    size = np.sqrt(np.einsum("ski,ij,skj->sk", shapes.conj(), system.mass, shapes).real)
    shapes = shapes / size[..., None]
    return WhirlDiagram(
        system=system,
        speed=read_only(np.array(speed)),
        frequency=read_only(frequency),
        damping_ratio=read_only((resisted[0] + resisted[1] / frequency) / frequency),
        whirl=read_only(np.where(speed[:, None] > 0, _sense(system, shapes), 0.0)),
        shapes=read_only(shapes),
    )


@dataclass(frozen=True, eq=False)
class _Equations:
    """The equations of the module's docstring: factor A of the mass, and S as a constant part and a part proportional to the speed."""

    mass_factor: Array
    still: Array
    spinning: Array

    @classmethod
    def of(cls, system: MountedPress) -> _Equations:
        n, factor = len(system.mass), np.linalg.cholesky(system.mass)
        across = np.linalg.solve(factor, np.linalg.cholesky(system.stiffness)).T
        turned = np.linalg.solve(factor, np.linalg.solve(factor, system.gyroscopic.T).T)
        nothing = np.zeros((n, n))
        still, spinning = (
            np.block(parts) for parts in ([[nothing, across], [-across.T, nothing]], [[nothing, nothing], [nothing, -turned]])
        )
        return cls(np.asarray(factor), still, spinning)

    def modes(self, speed: float) -> tuple[Array, ComplexArray]:
        """Frequencies (n,), rising, and unit vectors x (2 n, n) of the modes."""
        values, vectors = np.linalg.eigh(-1j * (self.still + speed * self.spinning))
        half = len(values) // 2
        return values[half:], vectors[:, half:]

    def follow(self, before: tuple[Array, ComplexArray], low: float, high: float, halvings: int) -> tuple[Array, ComplexArray]:
        """The modes at a speed, in the order of the modes at a lower speed. If they change much in between, the interval is halved."""
        frequency, vectors = self.modes(high)
        products = np.abs(before[1].conj().T @ vectors)
        mine, theirs = np.arange(len(products)), products.argmax(axis=1)
        # the squares of a row or column sum to at most 1, so a square above 0.5 identifies the partner
        if not np.all(products[mine, theirs] ** 2 > 0.5):
            mine, theirs = pair_modes(products**2)
        if halvings and products[mine, theirs].min() < SAME_MODE:
            middle = self.follow(before, low, 0.5 * (low + high), halvings - 1)
            return self.follow(middle, 0.5 * (low + high), high, halvings - 1)
        return frequency[theirs], vectors[:, theirs]


def _sense(system: MountedPress, shapes: ComplexArray) -> Array:
    """Sense of whirl (s, n) of the rotors' axes, weighted by angular momentum, for shapes (s, n, coordinates)."""
    swept, size = np.zeros(shapes.shape[:2]), np.zeros(shapes.shape[:2])
    for rotor in system.rotors:
        turn = shapes @ system.motion_of(rotor.on)[3:].T
        momentum = np.linalg.norm(rotor.momentum)
        if momentum == 0:
            continue
        axis = rotor.momentum / momentum
        tilt = turn - (turn @ axis)[..., None] * axis
        swept += 2 * momentum * (np.cross(tilt.real, -tilt.imag) @ axis)  # a quarter of a period later the tilt is minus its imaginary part
        size += momentum * (np.abs(tilt) ** 2).sum(axis=-1)
    tilts = size > 1e-9**2 * size.max(initial=0.0)  # a smaller tilt of the rotors is a rounding error
    return np.asarray(np.divide(swept, size, out=np.zeros_like(swept), where=tilts))
