"""A press on its mounts as a linear system about its static position, with its natural frequencies, mode shapes and damping.

The system is M u'' + C u' + K u = f, where f is the wrench that the machine exerts on the frame beside its weight.

The coordinates u of each rigid part of the frame are the displacement of its point at the world origin and its small turn,
(x, y, z, rx, ry, rz) in world axes [m, rad]. The bed's come first, then the crown's where the frame has two parts. Spatial inertias and
wrenches are about the world origin too, so that no other point of reference is needed.

The moving links of the press ride with the frame. For joint motions q(t) relative to the frame the six equations of a floating tree are
M(q) u'' + (terms in u' of the links' relative velocities) = shaking wrench of a frame at rest + forces of the mounts. M(q) is the spatial
inertia of the whole press; its mean over a period is taken. The terms left out (the change of M over the period, Coriolis forces) are of
second order: the ratio of moving mass to frame mass times the vibration. The gyroscopic moment of a flywheel, J w times the rate at which
the frame turns its axis, is left out too.

Points and mounts are given where they are under the static load. When the frame turns by t, a static force f (a weight, or the force of a
mount) at a point p of a part does the work f . (t x (t x p)) / 2 of second order, which is the stiffness f . p - (f p^T + p f^T) / 2
against turning. It makes a tall press on soft mounts tip, and lets a hanging one swing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..common import tables
from ..common.arguments import expect, typed, whole_number
from ..common.errors import PinpressError
from ..common.frozen import read_only
from ..common.quantities import Array, ComplexArray
from ..common.results import Tabular
from ..common.tables import Column
from ..engines.joints import data_of
from ..kinematics.motion import cycle
from ..linkage.linkage import Linkage
from .mounts import (
    Frame,
    Mount,
    body_inertia,
    centre_of,
    listed_mounts,
    refuse_loose,
    refuse_pulled,
    rows_at,
    springs_together,
    turning_stiffness,
    weight_wrench,
)

POSES = 180  # poses of a turn over which the moving mass is averaged; harmonics below this order leave the mean exact
MOST_ORDERS = 10_000  # most orders of `resonance_speeds`, against lists without end
MOTIONS = ("along x", "along y", "along z", "rocking about x", "rocking about y", "twisting about z")


@dataclass(frozen=True, eq=False, repr=False)
class MountedPress(Tabular):
    """A press on its mounts, made by `mounted`. All arrays are read-only.

    There are n coordinates: displacement (x, y, z) and small turn (rx, ry, rz) at the world origin, in world axes [m, rad], of the frame,
    or of its bed and then of its crown.

    Attributes:
        press: the press.
        frame: the frame, or its bed.
        crown: the part that carries crank and guides; None where the frame is one part.
        mounts: mounts between floor and frame.
        uprights: columns between bed and crown.
        mass: (n, n) mass matrix of frame and press, with moving masses at their mean.
        damping: (n, n) matrix of viscous damping.
        stiffness: (n, n) stiffness matrix for vibrations, with the effect of the static forces.
        loss: (n, n) imaginary part of the complex stiffness matrix.
        weight: (n,) wrench of all weights about the world origin [N, N m].
        press_weight: (6,) part of it that the links of the press have.
        press_inertia: (6, 6) mean spatial inertia of the links of the press, see the function `press_inertia`.
        mount_load: (mounts, 3) force of each mount on the frame at rest, in world axes [N].
        sag: (mounts, 3) displacement of each mount from its unloaded place, in world axes, downwards negative [m].
    """

    press: Linkage
    frame: Frame
    crown: Frame | None
    mounts: tuple[Mount, ...]
    uprights: tuple[Mount, ...]
    mass: Array
    damping: Array
    stiffness: Array
    loss: Array
    weight: Array
    press_weight: Array
    press_inertia: Array
    mount_load: Array
    sag: Array

    @property
    def title(self) -> str:
        return f"MountedPress {self.press.name}: {self.total_mass:.6g} kg on {len(self.mounts)} mounts"

    def __str__(self) -> str:
        """Loads, sag and pressure of the mounts at rest."""
        x, y, z = self.centre
        rows = [["mount at", "load", "share", "sag", "pressure"]]
        for mount, load, share, sag, pressure in zip(
            self.mounts, self.mount_load[:, 2], self.load_share, self.sag[:, 2], self.pressure, strict=True
        ):
            place = ", ".join(f"{coordinate:.4g}" for coordinate in mount.point) + " m"
            last = [] if pressure is None else [f"{pressure / 1e6:.4g} MPa"]
            rows.append([place, f"{load:.5g} N", f"{100 * share:.2f} %", f"{-1e3 * sag:.4g} mm", *last])
        title = f"{self.press.name} on its mounts at rest: {self.total_mass:.6g} kg, centre of mass {x:.4g}, {y:.4g}, {z:.4g} m"
        return "\n".join([title, *tables.table(rows, [28, 14, 10, 14])])

    def columns(self) -> dict[str, Column]:
        """A row for each mount: place, load, share of the weight, sag (downwards positive) and pressure."""
        places = {f"{axis} [m]": [mount.point[i] for mount in self.mounts] for i, axis in enumerate("xyz")}
        return {
            **places,
            "load [N]": self.mount_load[:, 2].tolist(),
            "share [-]": self.load_share.tolist(),
            "sag [m]": (-self.sag[:, 2]).tolist(),
            "pressure [Pa]": list(self.pressure),
        }

    @property
    def parts(self) -> int:
        """Number of rigid parts of the frame, 1 or 2."""
        return 1 if self.crown is None else 2

    @property
    def total_mass(self) -> float:
        """Mass of frame and press [kg]."""
        return float(self.mass[0::6, 0::6].sum())

    @property
    def centre(self) -> Array:
        """(3,) mean centre of mass of frame and press in world axes [m]."""
        whole = self.mass[:6, :6] + (self.mass[6:, 6:] if self.parts == 2 else 0.0)
        return centre_of(whole)

    @property
    def load_share(self) -> Array:
        """(mounts,) share of the weight on each mount [-]."""
        share: Array = self.mount_load[:, 2] / self.mount_load[:, 2].sum()
        return share

    @property
    def pressure(self) -> tuple[float | None, ...]:
        """Mean pressure on each mount at rest [Pa]; None where the mount has no area."""
        return tuple(
            None if mount.area is None else float(load / mount.area) for mount, load in zip(self.mounts, self.mount_load[:, 2], strict=True)
        )

    @cached_property
    def mount_rows(self) -> Array:
        """(mounts, 3, n) displacement of each mount's point by one of each coordinate."""
        return read_only(np.array([rows_at(self.parts, 0, np.array(mount.point)) for mount in self.mounts]))


@typed
def mounted(
    press: Linkage, frame: Frame, mounts: Sequence[Mount], *, crown: Frame | None = None, uprights: Sequence[Mount] = ()
) -> MountedPress:
    """Stand a press on its mounts.

    Args:
        press: the press. Its links ride with the frame, or with the crown; their inertia is averaged over a period, mostly one turn of the
            crank.
        frame: the frame in one part; with ``crown`` its lower part, the bed, on which the loads on the frame act (the process force).
        mounts: mounts between floor and frame.
        crown: upper part of the frame, which carries crank and guides.
        uprights: columns between bed and crown, as springs.

    Raises:
        PinpressError: an argument is of another kind, the crank does not turn fully, the mounts leave the frame free to move, the weight
            pulls at a mount, or the press tips over.
    """
    mounts = listed_mounts(mounts, "mounts")
    if (crown is None) != (len(uprights) == 0):
        raise PinpressError("crown and uprights go together: give both, or neither for a frame in one part")
    if crown is not None:
        expect("crown", crown, Frame, "Frame")
        uprights = listed_mounts(uprights, "uprights")
    return _assembled(press, frame, mounts, crown, tuple(uprights), press_inertia(press))


def with_mounts(system: MountedPress, mounts: Sequence[Mount]) -> MountedPress:
    """Stand a press that is on mounts already on other ones, without averaging its inertia again.

    Raises:
        PinpressError: as `mounted`.
    """
    mounts = listed_mounts(mounts, "mounts")
    return _assembled(system.press, system.frame, mounts, system.crown, system.uprights, system.press_inertia)


@typed
def press_inertia(press: Linkage) -> Array:
    """Mean spatial inertia of all links about the world origin over one period.

    Args:
        press: a press with one driver, which turns fully.

    Returns:
        Spatial inertia (6, 6) in world axes, linear before angular [kg, kg m, kg m2].

    Raises:
        PinpressError: the crank does not turn fully, or there are several drivers.
    """
    model, period = press.model, cycle(press, 1.0, points=POSES * (press.period_turns if press.driver_coordinates[0].turns else 1))
    data = data_of(model)
    total = np.zeros((6, 6))
    for q in period.q:
        pin.forwardKinematics(model, data, q)
        for place, inertia in zip(data.oMi, model.inertias, strict=True):
            if inertia.mass:
                total += place.act(inertia).matrix()
    return total / len(period.q)


@dataclass(frozen=True, eq=False, repr=False)
class VibrationModes(Tabular):
    """The n modes of free vibration, by rising frequency. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        natural_frequency: (n,) undamped natural frequencies [rad/s].
        shapes: (n, n) undamped shapes, a mode a column, in the coordinates of `MountedPress`, scaled to a modal mass of 1 kg.
        damped_frequency: (n,) frequencies of the damped system [rad/s]; zero for a mode that creeps back without swinging.
        damping_ratio: (n,) damping divided by critical damping, 1 or more for a mode that creeps back [-].
        eigenvalues: (2 n,) eigenvalues of the damped system in first order, which give damped frequencies and ratios [1/s].
        motion: (n,) motions with most of each mode's kinetic energy, about the centres of mass: "along z", "rocking about y", ... In a
            frame of two parts ", against" follows where bed and crown move against each other; along z this is "stretching".
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
        rows = [["motion", "frequency", "speed", "damping ratio"]]
        for motion, frequency, ratio in zip(self.motion, self.natural_frequency / (2 * np.pi), self.damping_ratio, strict=True):
            rows.append([motion, f"{frequency:.3f} Hz", f"{60 * frequency:.1f} per min", f"{ratio:.4f}"])
        return "\n".join([f"{self.press_name} on its mounts: modes", *tables.table(rows, [18, 12, 18, 15])])

    def resonance_speeds(self, orders: int = 4) -> Array:
        """(orders, n) speeds of the crank at which its first, second, ... harmonic meets each natural frequency [rad/s].

        Args:
            orders: number of harmonics, 1 to 10 000.

        Raises:
            PinpressError: ``orders`` is no whole number in that range.
        """
        return np.asarray(self.natural_frequency / np.arange(1, whole_number("orders", orders, 1, MOST_ORDERS) + 1)[:, None])

    def columns(self) -> dict[str, Column]:
        """A row for each mode: its motion, frequencies and damping ratio."""
        return {
            "motion": list(self.motion),
            "natural_frequency [rad/s]": self.natural_frequency,
            "damped_frequency [rad/s]": self.damped_frequency,
            "damping_ratio [-]": self.damping_ratio,
            "frequency [Hz]": self.natural_frequency / (2 * np.pi),
        }


@typed
def modes(system: MountedPress) -> VibrationModes:
    """Find the modes of free vibration of a press on its mounts.

    Natural frequencies and shapes are those of mass and stiffness alone; damped frequencies and damping ratios come from the eigenvalues of
    the damped system in first order, in the order of their absolute values. A loss factor counts as the viscous damping that loses as much
    energy at each mode's own frequency.

    Args:
        system: the press on its mounts.

    Raises:
        PinpressError: ``system`` is not a `MountedPress`.
    """
    squared, shapes = undamped(system)
    frequency = np.sqrt(squared)
    eigenvalues = np.asarray(np.linalg.eigvals(state_matrix(system)), dtype=complex)
    swinging = eigenvalues[eigenvalues.imag > 0]
    creeping = np.sort(eigenvalues[eigenvalues.imag == 0].real)
    half = len(creeping) // 2
    fast, slow = creeping[:half], creeping[half:][::-1]  # two a mode, whose product is the frequency squared: fastest with slowest
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
    """Squares of the natural frequencies (n,), rising [rad2/s2], and shapes (n, n), a mode a column, of modal mass 1 kg."""
    root = np.linalg.inv(np.linalg.cholesky(system.mass))
    squared, vectors = np.linalg.eigh(root @ system.stiffness @ root.T)
    return np.asarray(squared), np.asarray(root.T @ vectors)


def quadrature(system: MountedPress) -> Array:
    """Matrix (n, n) from velocities to the displacements a quarter of a period later: each mode's velocity divided by its frequency [s].

    It makes a loss factor act in time: stiffness times loss factor times this displacement is a force that loses at each mode's own
    frequency as much energy as in the frequency domain, so that no reference frequency has to be chosen.
    """
    squared, shapes = undamped(system)
    return np.asarray((shapes / np.sqrt(squared)) @ shapes.T @ system.mass)


def state_matrix(system: MountedPress) -> Array:
    """Matrix (2 n, 2 n) of free vibration in first order: d/dt of (displacements, velocities) from these."""
    n = len(system.mass)
    solved = np.linalg.solve(system.mass, np.hstack([system.stiffness, system.damping + system.loss @ quadrature(system)]))
    return np.block([[np.zeros((n, n)), np.eye(n)], [-solved[:, :n], -solved[:, n:]]])


def _assembled(
    press: Linkage, frame: Frame, mounts: tuple[Mount, ...], crown: Frame | None, uprights: tuple[Mount, ...], moving: Array
) -> MountedPress:
    """The linear system of checked parts; ``moving`` is the mean inertia of the press. Raises as `mounted`."""
    parts, gravity = 1 if crown is None else 2, np.asarray(press.model.gravity.linear)
    bodies = [body_inertia(part) for part in (frame, crown) if part is not None]
    press_weight = weight_wrench(moving, gravity)
    bodies[-1] = bodies[-1] + moving
    weight = np.concatenate([weight_wrench(body, gravity) for body in bodies])
    mass = np.zeros((6 * parts, 6 * parts))
    for k, body in enumerate(bodies):
        mass[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = body
    rows = [rows_at(parts, 0, np.array(mount.point)) for mount in mounts]
    between = [rows_at(parts, 1, np.array(upright.point)) - rows_at(parts, 0, np.array(upright.point)) for upright in uprights]
    springs = list(zip((*mounts, *uprights), rows + between, strict=True))
    refuse_loose(mass, "frame and press have no inertia for", "give the frame its mass and inertia")
    static = springs_together((mount.static, at) for mount, at in springs)
    refuse_loose(static, "the mounts leave the frame free in", "give mounts there, and stiffness in all directions")
    rest = np.linalg.solve(static, weight)
    sag = np.array([at @ rest for at in rows])
    load = -np.array([mount.static for mount in mounts]) * sag
    refuse_pulled(load, gravity)
    stiffness = springs_together((mount.stiffness, at) for mount, at in springs)
    stiffness += turning_stiffness(mounts, uprights, between, rest, load, bodies, gravity)
    system = MountedPress(
        press=press,
        frame=frame,
        crown=crown,
        mounts=mounts,
        uprights=uprights,
        mass=mass,
        damping=springs_together((mount.damping, at) for mount, at in springs),
        stiffness=0.5 * (stiffness + stiffness.T),
        loss=springs_together((mount.loss_factor * np.array(mount.stiffness), at) for mount, at in springs),
        weight=weight,
        press_weight=press_weight,
        press_inertia=moving,
        mount_load=load,
        sag=sag,
    )
    if np.linalg.eigvalsh(system.stiffness)[0] <= 0:
        raise PinpressError(
            f"{press.name} tips over on these mounts: its weight turns it further than they hold; set them wider apart, or stiffer"
        )
    return system


def _motion(system: MountedPress, shape: Array) -> str:
    """The motion with most of the kinetic energy of a mode shape (n,), as in `VibrationModes.motion`."""
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
