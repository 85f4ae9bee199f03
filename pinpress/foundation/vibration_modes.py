"""Natural frequencies, shapes and damping of a press on its mounts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.arguments import typed
from ..common.arrays import Array, ComplexArray
from ..common.checks import finite_numbers, whole_number
from ..common.errors import PinpressError
from ..common.results import Tabular
from ..common.tables import Column
from .matrices import centre_of
from .mounted_press import MountedPress

MOST_ORDERS = 10_000
MOTIONS = ("along x", "along y", "along z", "rocking about x", "rocking about y", "twisting about z")


@dataclass(frozen=True, eq=False, repr=False)
class VibrationModes(Tabular):
    """VibrationModes of free vibration, n of them in the order of their frequencies. All arrays are read-only.

    Attributes:
        press_name: of the press.
        natural_frequency: (n,) undamped [rad/s].
        shapes: (n, n) a mode a column, in the coordinates of `MountedPress`, undamped, of modal mass 1 kg.
        damped_frequency: (n,) zero of a mode that creeps back without swinging [rad/s].
        damping_ratio: (n,) of the critical damping, 1 and more of a mode that creeps back [-].
        eigenvalues: (2 n,) of u'' + ... in first order, from which these two come [1/s]; paired by the order of their absolute values.
        motion: (n,) what has the most of each mode's kinetic energy, about the centres of mass: "along z", "rocking about y", ...;
            "stretching" of a mode in which bed and crown move against each other.
    """

    press_name: str
    natural_frequency: Array
    shapes: Array
    damped_frequency: Array
    damping_ratio: Array
    eigenvalues: ComplexArray
    motion: tuple[str, ...]

    @property
    def title(self) -> str:
        return f"VibrationModes of {self.press_name}: {', '.join(f'{f / (2 * np.pi):.4g}' for f in self.natural_frequency)} Hz"

    def __str__(self) -> str:
        lines = [f"{self.press_name} on its mounts: modes", f"  {'motion':<18}{'frequency':>12}{'speed':>18}{'damping ratio':>15}"]
        for motion, frequency, ratio in zip(self.motion, self.natural_frequency / (2 * np.pi), self.damping_ratio, strict=True):
            lines.append(f"  {motion:<18}{frequency:9.3f} Hz{60 * frequency:10.1f} per min{ratio:15.4f}")
        return "\n".join(lines)

    def resonance_speeds(self, orders: int = 4) -> Array:
        """(orders, n) speeds of the crank [rad/s] at which its first, second, ... harmonic meets each natural frequency.

        Raises:
            PinpressError: orders that are no whole number from 1 to 10 000.
        """
        return np.asarray(self.natural_frequency / np.arange(1, whole_number("orders", orders, 1, MOST_ORDERS) + 1)[:, None])

    def columns(self) -> dict[str, Column]:
        """The modes as columns, one a row."""
        return {
            "motion": list(self.motion),
            "natural_frequency [rad/s]": self.natural_frequency,
            "damped_frequency [rad/s]": self.damped_frequency,
            "damping_ratio [-]": self.damping_ratio,
            "frequency [Hz]": self.natural_frequency / (2 * np.pi),
        }


@typed
def modes(system: MountedPress) -> VibrationModes:
    """Natural frequencies (of M, K), and damping from the eigenvalues of the damped system in first order.

    A loss factor is taken as the viscous damping that loses the same at each mode's own frequency (`quadrature`).

    Args:
        system: the press on its mounts.

    Raises:
        PinpressError: no `MountedPress`.
    """
    squared, shapes = undamped(system)
    frequency = np.sqrt(squared)
    eigenvalues = np.asarray(np.linalg.eigvals(state_matrix(system)), dtype=complex)
    swinging = eigenvalues[eigenvalues.imag > 0]
    creeping = np.sort(eigenvalues[eigenvalues.imag == 0].real)
    half = len(creeping) // 2
    fast, slow = creeping[:half], creeping[half:][::-1]  # of one mode the product is the frequency squared: the fastest with the slowest
    size = np.concatenate([np.abs(swinging), np.sqrt(slow * fast)])
    loss = np.concatenate([-swinging.real, -0.5 * (slow + fast)])
    damped = np.concatenate([swinging.imag, np.zeros(half)])
    order = np.argsort(size)
    return VibrationModes(
        press_name=system.press.name,
        natural_frequency=frequency,
        shapes=shapes,
        damped_frequency=damped[order],
        damping_ratio=(loss / size)[order],
        eigenvalues=eigenvalues,
        motion=tuple(_motion(system, shape) for shape in shapes.T),
    )


def undamped(system: MountedPress) -> tuple[Array, Array]:
    """Squares of the natural frequencies (n,), rising, and shapes (n, n), a mode a column, of modal mass 1."""
    root = np.linalg.inv(np.linalg.cholesky(system.mass))
    squared, vectors = np.linalg.eigh(root @ system.stiffness @ root.T)
    return np.asarray(squared), np.asarray(root.T @ vectors)


def quadrature(system: MountedPress) -> Array:
    """(n, n) what makes of velocities the displacements a quarter of a period later: of each mode its velocity by its frequency.

    With it a loss factor acts in time: a force of the stiffness times the factor on this displacement loses, at each mode's own frequency,
    what it loses in the frequency domain, without a frequency of reference.
    """
    squared, shapes = undamped(system)
    return np.asarray((shapes / np.sqrt(squared)) @ shapes.T @ system.mass)


def state_matrix(system: MountedPress) -> Array:
    """(2 n, 2 n): d/dt of (displacements, velocities) of free vibration."""
    n = len(system.mass)
    solved = np.linalg.solve(system.mass, np.hstack([system.stiffness, system.damping + system.loss @ quadrature(system)]))
    return np.block([[np.zeros((n, n)), np.eye(n)], [-solved[:, :n], -solved[:, n:]]])


def logarithmic_decrement(signal: Array) -> float:
    """Mean logarithmic decrement of a decaying vibration (n,): of the peaks of its absolute value, two a period, by least squares.

    ln(peak / peak a period later); of a damping ratio z it is 2 pi z / sqrt(1 - z^2).

    Args:
        signal: (n,) one component of a vibration, in equal steps of time.

    Raises:
        PinpressError: no (n,) of finite numbers, or fewer than three peaks.
    """
    values = finite_numbers(signal)
    if values is None or values.ndim != 1:
        raise PinpressError("signal is no array (n,) of finite numbers: give one component of a vibration")
    size = np.abs(values)
    peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
    if len(peaks) < 3:
        raise PinpressError(f"signal has {len(peaks)} peaks: give a vibration of two periods or more")
    return float(-2 * np.polyfit(np.arange(len(peaks)), np.log(size[peaks]), 1)[0])


def _motion(system: MountedPress, shape: Array) -> str:
    energy = np.zeros(6)
    moved = []
    for part in range(system.parts):
        body = system.mass[6 * part : 6 * part + 6, 6 * part : 6 * part + 6]
        u, mass, centre = shape[6 * part : 6 * part + 6], body[0, 0], centre_of(body)
        velocity, momentum = u[:3] + np.cross(u[3:], centre), body @ u
        energy[:3] += mass * velocity**2
        energy[3:] += (momentum[3:] - np.cross(centre, momentum[:3])) * u[3:]
        moved.append(np.concatenate([velocity, u[3:]]))
    most = int(energy.argmax())
    if system.parts == 2 and moved[0][most] * moved[1][most] < 0:
        return "stretching" if most == 2 else f"{MOTIONS[most]}, against"
    return MOTIONS[most]
