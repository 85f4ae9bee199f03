"""How a press vibrates on its mounts: in the steady state, by the harmonics of its shaking force, and in time.

Of a periodic motion every harmonic is solved by itself, (K + i K'' + i w C - w^2 M) U = F: exact for forces that its states resolve. In
time the force is taken for a line between two states; with it a step of the linear system is exact (first-order hold: the matrix
exponential of (x, f, f') over a step), whatever the step beside the natural periods.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import typed
from ..common.arrays import Array, ComplexArray
from ..common.checks import finite_numbers
from ..common.errors import PinpressError, expect, shown
from ..drives.transmission import Flywheel
from ..dynamics.inverse_dynamics import Reactions
from .excitation import forcing, period, step
from .frame_motion import FrameMotion
from .matrices import rows_at
from .mounted_press import MountedPress
from .vibration_modes import quadrature, state_matrix

UNRESOLVED = 1e-3  # share of the last third of the harmonics from which the states do not resolve the force
ROUNDING = 1e-9  # of weight and forces
RESONANCE = "a harmonic meets a natural frequency that has no damping: give the mounts damping or a loss factor, or another speed"

Points = Mapping[str, "ArrayLike | tuple[str, ArrayLike]"]


@typed
def steady_response(system: MountedPress, reactions: Reactions, *, points: Points, flywheel: Flywheel | None = None) -> FrameMotion:
    """The vibration of one period, when all that began it has died away.

    Args:
        system: the press on its mounts.
        reactions: of one period at constant speed (`cycle`), or of one period of `steady_state`.
        points: name -> (3,) point of the frame, world axes [m]; of a frame in two parts (3,) of the bed, or ("crown", (3,)).
        flywheel: on the crank's shaft; it matters where the speed changes. Its inertia is its angular momentum about the crank's axis by
            the crank's speed: of one on a shaft beside, its inertia times the ratio of its speed, negative where that turns the other way.

    Raises:
        PinpressError: an argument that makes no sense, a motion that is no period, or too few states for its shaking force.
    """
    wrench = forcing(system, reactions, flywheel)
    placed = named_points(system, points)
    length, states = period(reactions.motion)
    harmonics = resolved(np.fft.rfft(wrench[:states], axis=0), states, max(np.abs(wrench).max(), np.abs(system.weight[:3]).max()))
    frequency = np.linspace(0.0, 2 * np.pi / length * (len(harmonics) - 1), len(harmonics))
    amplitude = solved(system, frequency, harmonics)

    def in_time(spectrum: ComplexArray) -> Array:
        return np.fft.irfft(spectrum, states, axis=0)

    velocity = 1j * frequency[:, None] * amplitude
    return FrameMotion.of(
        system,
        time=np.linspace(0.0, length, states, endpoint=False),
        points=placed,
        motion=(in_time(amplitude), in_time(velocity), in_time(1j * frequency[:, None] * velocity)),
        mount_force=in_time(mount_forces(system, frequency, amplitude).reshape(len(frequency), -1)).reshape(states, -1, 3),
        forcing=in_time(harmonics),
        period=length,
    )


@typed
def time_response(system: MountedPress, reactions: Reactions, *, points: Points, flywheel: Flywheel | None = None) -> FrameMotion:
    """The vibration from rest, in the static position, as the press runs.

    What begins in full swing shakes a frame at rest; that dies away with the modes' damping.

    Args:
        system: the press on its mounts.
        reactions: of a run of `simulate`, or of any motion in equal steps of time.
        points: as of `steady_response`.
        flywheel: as of `steady_response`.

    Raises:
        PinpressError: an argument that makes no sense, or states that are not at equal intervals of time.
    """
    wrench = forcing(system, reactions, flywheel)
    placed, interval = named_points(system, points), step(reactions.motion)
    u, velocity, acceleration = stepped(system, wrench, interval)
    rows = system.mount_rows
    stiffness, damping, loss = mount_constants(system)
    displaced, moving = np.einsum("mkj,nj->nmk", rows, u), np.einsum("mkj,nj->nmk", rows, velocity)
    later = np.einsum("mkj,nj->nmk", rows, velocity @ quadrature(system).T)
    return FrameMotion.of(
        system,
        time=reactions.motion.time - reactions.motion.time[0],
        points=placed,
        motion=(u, velocity, acceleration),
        mount_force=-(stiffness * displaced + damping * moving + loss * later),
        forcing=wrench,
        period=None,
    )


def stepped(system: MountedPress, wrench: Array, interval: float) -> tuple[Array, Array, Array]:
    """Displacements, velocities and accelerations (states, n) from rest under wrenches (states, n), linear in between."""
    from scipy.linalg import expm  # slow to import

    n = len(system.mass)
    a, b = state_matrix(system), np.vstack([np.zeros((n, n)), np.linalg.inv(system.mass)])
    whole = np.zeros((4 * n, 4 * n))
    whole[: 2 * n, : 2 * n], whole[: 2 * n, 2 * n : 3 * n], whole[2 * n : 3 * n, 3 * n :] = a * interval, b * interval, np.eye(n)
    exponential = expm(whole)
    free, late = exponential[: 2 * n, : 2 * n], exponential[: 2 * n, 3 * n :]
    early = exponential[: 2 * n, 2 * n : 3 * n] - late
    driven = wrench[:-1] @ early.T + wrench[1:] @ late.T
    states = np.zeros((len(wrench), 2 * n))
    state = states[0]
    for k in range(len(driven)):
        state = free @ state + driven[k]
        states[k + 1] = state
    if not np.isfinite(states[-1]).all():
        raise PinpressError("the vibration is not finite: the forces are too large for floating point")
    return states[:, :n], states[:, n:], (states @ a.T + wrench @ b.T)[:, n:]


def solved(system: MountedPress, frequency: Array, harmonics: ComplexArray) -> ComplexArray:
    """Amplitudes (..., n) of the displacement for those of the wrench (..., n) at angular frequencies (...).

    Raises:
        PinpressError: a resonance without damping.
    """
    w = frequency[..., None, None]
    matrix = system.stiffness + 1j * (np.sign(w) * system.loss + w * system.damping) - w**2 * system.mass
    try:
        amplitude = np.linalg.solve(matrix, harmonics[..., None])[..., 0]
    except np.linalg.LinAlgError:
        raise PinpressError(RESONANCE) from None
    if not np.isfinite(amplitude).all():
        raise PinpressError(RESONANCE)
    return np.asarray(amplitude)


def mount_forces(system: MountedPress, frequency: Array, amplitude: ComplexArray) -> ComplexArray:
    """Amplitudes (..., mounts, 3) of what the mounts exert on the frame."""
    stiffness, damping, loss = mount_constants(system)
    w = frequency[..., None, None]
    return np.asarray(-(stiffness + 1j * (np.sign(w) * loss + w * damping)) * np.einsum("mkj,...j->...mk", system.mount_rows, amplitude))


def mount_constants(system: MountedPress) -> tuple[Array, Array, Array]:
    """Stiffness, damping, and stiffness times loss factor of the mounts, (mounts, 3) each."""
    stiffness, damping = np.array([m.stiffness for m in system.mounts]), np.array([m.damping for m in system.mounts])
    return stiffness, damping, stiffness * np.array([m.loss_factor for m in system.mounts])[:, None]


def resolved(harmonics: ComplexArray, states: int, size_of_all: float) -> ComplexArray:
    """Harmonics (k, n) of a wrench over a period of so many states, the one of half their number, whose phase is not known, left out.

    ``size_of_all``: of what the wrench was worked out from, beside which some of it is rounding [N].

    Raises:
        PinpressError: the last third of them is no rounding: the force has jumps, or corners too sharp for the states.
    """
    size = np.abs(harmonics[1:]).reshape(len(harmonics) - 1, -1, 3).max(axis=(1, 2))
    tail = size[2 * len(size) // 3 :].max(initial=0.0)
    if tail > UNRESOLVED * size.max(initial=0.0) and tail > ROUNDING * states * size_of_all:
        raise PinpressError(
            f"{states} states do not resolve the shaking force, which changes too sharply: give more points, or a run to time_response"
        )
    if states % 2 == 0:
        harmonics[-1] = 0.0
    return harmonics


def named_points(system: MountedPress, points: Points) -> dict[str, Array]:
    """(3, n) rows of points by their names.

    Raises:
        PinpressError: no names, a point that is none, or one of a crown that there is not.
    """
    expect("points", points, Mapping, "{'top_beam': (x, y, z), ...}")
    rows = {}
    for name, given in points.items():
        part, place = (1, given[1]) if isinstance(given, tuple) and len(given) == 2 and given[0] == "crown" else (0, given)
        point = finite_numbers(place)
        if not isinstance(name, str) or point is None or point.shape != (3,):
            raise PinpressError(f"point {shown(name)} is {shown(given)}: give x, y, z [m] under a name, or ('crown', (x, y, z))")
        if part >= system.parts:
            raise PinpressError(f"point {shown(name)} is one of the crown, but the frame is in one part: give x, y, z alone")
        rows[name] = rows_at(system.parts, part, point)
    return rows
