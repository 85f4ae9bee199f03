"""A press on its mounts as a linear system about its static position, with its natural frequencies, mode shapes and damping.

The system is M u'' + C u' + K u = f, where f is the wrench that the machine exerts on the frame, weight excluded.

The coordinates u of each rigid part of the frame are the displacement of its point at the world origin and its small turn,
(x, y, z, rx, ry, rz) in world axes [m, rad]. First come the coordinates of the bed, then those of the crown if the frame has two parts,
then those of attachments on springs. A frame that bends has six coordinates of its mean motion, then its free vibrations, see
`elastic_frame`. Spatial inertias and wrenches are about the world origin too, so only one point of reference is needed; the matrices are in
`frame_parts`.

The links of the press move with the frame. For joint motions q(t) relative to the frame the six equations of a floating tree are
M(q) u'' + (terms in u' of the links' relative velocities) = shaking wrench of a frame at rest + forces of the mounts. M(q) is the spatial
inertia of the whole press; the model uses its mean over a period. It neglects the change of M over the period and Coriolis forces. Compared
with the vibration, these terms are small in the ratio of moving mass to frame mass. Rotors, such as the flywheel, add the gyroscopic term w
G u' at the crank's speed w to the left side.

The places of points and mounts are those under the static load. When the frame turns by t, a static force f (a weight, or the force of a
mount) at a point p of a part does the second-order work f . (t x (t x p)) / 2. This is the geometric stiffness f . p - (f p^T + p f^T) / 2
against rotation. It makes a tall press on soft mounts tip, and a hanging press swing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..common import plausibility
from ..common.arguments import expect, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError, caution, shown
from ..common.frozen import FrozenMapping, read_only
from ..common.numerics import damped_modes
from ..common.quantities import GRAVITY, Array, ComplexArray
from ..common.results import Tabular
from ..common.tables import Column
from ..dynamics.shaking import on_frame
from ..engines.structure import data_of
from ..kinematics.cycle import cycle
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..linkage.linkage import Linkage
from .elastic_frame import WHOLE, ElasticFrame
from .frame_parts import (
    Attachment,
    Body,
    Rotor,
    Spring,
    body_inertia,
    centre_of,
    gyroscopic_matrix,
    motions_of,
    part_named,
    refuse_loose,
    refuse_pulled,
    rows_at,
    spring_rows,
    springs_together,
    turning_stiffness,
    weight_wrench,
)
from .mounts import Frame, Mount, listed_mounts

MOST_ORDERS = 10_000  # most orders of `resonance_speeds`, to keep the table finite
MOTIONS = ("along x", "along y", "along z", "rocking about x", "rocking about y", "twisting about z")
BENDING = "bending"  # name of a motion in which the frame has most of the elastic energy


@dataclass(frozen=True, eq=False, repr=False)
class MountedPress(Tabular):
    """A press on its mounts, made by `mounted`. All arrays are read-only.

    There are n coordinates. A rigid part has six: displacement (x, y, z) and small rotation (rx, ry, rz) at the world origin, in world axes
    [m, rad]. First come those of the frame, or of its bed and then of its crown; for an elastic frame, the six of its mean motion and then
    its free vibrations of modal mass 1 kg. The coordinates of each attachment on springs follow.

    Attributes:
        press: the press.
        frame: the frame, or its bed.
        crown: the part that carries crank and guides; None if the frame is one part.
        mounts: mounts between floor and frame.
        uprights: columns between bed and crown.
        attached: name of an attachment -> the attachment.
        rotors: the rotors on the frame.
        parts: name of a part -> (6, n) its displacement and rotation at the world origin for a unit of each coordinate. Names are "frame",
            or "bed" and "crown"; interfaces of an elastic frame, whose mean motion is "frame"; and attachments.
        bed: name of the part on which the loads on the frame act.
        carrier: name of the part that carries crank and guides.
        rigid: (n, 6) coordinates in the six rigid-body motions of the whole system, each a unit displacement or rotation at the world
            origin.
        mass: (n, n) mass matrix of frame and press, with the mean inertia of the moving links.
        damping: (n, n) matrix of viscous damping.
        stiffness: (n, n) stiffness matrix for vibrations, with the effect of the static forces.
        loss: (n, n) imaginary part of the complex stiffness matrix.
        gyroscopic: (n, n) skew-symmetric matrix of the rotors at a crank speed of 1 rad/s; the product with the speed is added to
            ``damping``.
        weight: (n,) wrench of all weights about the world origin [N, N m].
        press_weight: (6,) wrench of the weight of the press's links about the world origin [N, N m].
        press_inertia: (6, 6) mean spatial inertia of the links of the press, see the function `press_inertia`.
        mount_load: (mounts, 3) force of each mount on the frame at rest, in world axes [N].
        sag: (mounts, 3) displacement of each mount from its unloaded place, in world axes [m].
    """

    press: Linkage
    frame: Frame | ElasticFrame
    crown: Frame | None
    mounts: tuple[Mount, ...]
    uprights: tuple[Mount, ...]
    attached: Mapping[str, Attachment]
    rotors: tuple[Rotor, ...]
    parts: Mapping[str, Array]
    bed: str
    carrier: str
    rigid: Array
    mass: Array
    damping: Array
    stiffness: Array
    loss: Array
    gyroscopic: Array
    weight: Array
    press_weight: Array
    press_inertia: Array
    mount_load: Array
    sag: Array

    @property
    def title(self) -> str:
        return f"MountedPress {self.press.name}: {self.total_mass:.6g} kg on {len(self.mounts)} mounts"

    def columns(self) -> dict[str, Column]:
        """A row for each mount: place, load, share of the weight, sag (downwards positive) and pressure."""
        places = {f"{axis} [m]": [mount.point[i] for mount in self.mounts] for i, axis in enumerate("xyz")}
        return {
            **places,
            "load [N]": self.upward_load.tolist(),
            "share [-]": self.load_share.tolist(),
            "sag [m]": self.downward_sag.tolist(),
            "pressure [Pa]": list(self.pressure),
        }

    @property
    def total_mass(self) -> float:
        """Mass of frame and press [kg]."""
        return float(self._whole[0, 0])

    @property
    def centre(self) -> Array:
        """(3,) mean centre of mass of frame and press in world axes [m]."""
        return centre_of(self._whole)

    @property
    def _whole(self) -> Array:
        """(6, 6) mean spatial inertia of frame and press about the world origin."""
        return np.asarray(self.rigid.T @ self.mass @ self.rigid)

    @property
    def upward_load(self) -> Array:
        """(mounts,) force of each mount on the frame at rest, upwards (`Linkage.up`) [N]."""
        return np.asarray(self.mount_load @ self.press.up)

    @property
    def downward_sag(self) -> Array:
        """(mounts,) displacement of each mount from its unloaded place, downwards [m]."""
        return np.asarray(-(self.sag @ self.press.up) + 0.0)

    @property
    def load_share(self) -> Array:
        """(mounts,) share of the weight on each mount [-]."""
        share: Array = self.upward_load / self.upward_load.sum()
        return share

    @property
    def pressure(self) -> tuple[float | None, ...]:
        """Mean pressure on each mount at rest [Pa]; None if the mount has no area."""
        return tuple(
            None if mount.area is None else float(load / mount.area) for mount, load in zip(self.mounts, self.upward_load, strict=True)
        )

    def motion_of(self, part: str | None) -> Array:
        """(6, n) motion of a part by its name, as in ``parts``; None: of the carrier.

        Raises:
            UnknownNameError: there is no such part.
        """
        return self.parts[part_named(self.parts, part, self.carrier)]

    @cached_property
    def mount_rows(self) -> Array:
        """(mounts, 3, n) displacement of each mount's point for a unit of each coordinate."""
        return read_only(np.array([rows_at(self.parts[_foot(self.frame, self.bed, mount)], mount.point) for mount in self.mounts]))


@typed
def mounted(
    press: Linkage,
    frame: Frame | ElasticFrame,
    mounts: Sequence[Mount],
    *,
    crown: Frame | None = None,
    uprights: Sequence[Mount] = (),
    attached: Mapping[str, Attachment] | None = None,
    rotors: Sequence[Rotor] = (),
    motion: Motion | None = None,
) -> MountedPress:
    """Stand a press on its mounts.

    Args:
        press: the press. Its links ride with the frame, or with the crown; their inertia is averaged over a period, mostly one turn of the
            crank.
        frame: the frame in one part; with ``crown`` its lower part, the bed, on which the loads on the frame act (the process force); or an
            elastic frame from `beam_frame`, `reduced_frame` or `read_frame`.
        mounts: mounts between floor and frame. They are at interfaces if the frame is elastic.
        crown: upper part of the frame, which carries crank and guides.
        uprights: columns between bed and crown, as springs.
        attached: name -> attachment on the frame, bolted on or on springs, such as the motor; None: no attachments.
        rotors: rotors on the frame, such as flywheel and motor rotor. The masses of the parts that carry them must include their masses.
        motion: motion in equal steps of time, over which the inertia of the links is averaged; None: one period at constant speed. A press
            with several drivers needs it and cannot have rotors: give the flywheels to the responses.

    Raises:
        UnknownNameError: an attachment or a rotor names an unknown part of the frame, or an elastic frame names a bearing that is not on
            it.
        PinpressError: an argument is of another kind, the crank does not turn fully or there are several drivers and no motion is given,
            the motion is of another press, several drivers have rotors, the mounts leave the frame free to move, the weight
            pulls at a mount, or the press tips over.

    Warns:
        PinpressWarning: the frame is so light compared with the links that its mass may be given in t.
    """
    mounts = listed_mounts(mounts, "mounts")
    if (crown is None) != (len(uprights) == 0):
        raise PinpressError("crown and uprights go together: give both, or neither for a frame in one part")
    if crown is not None:
        expect("crown", crown, Frame, "Frame")
        uprights = listed_mounts(uprights, "uprights")
    if isinstance(frame, ElasticFrame):
        if crown is not None:
            raise PinpressError("an elastic frame has no crown= and uprights=: leave them out")
        carried = tuple(press.bearings[k] for k in on_frame(press))
        for bearing in frame.bearings:
            if bearing not in carried:
                raise UnknownNameError("bearing on the frame", bearing, carried)
    own = tuple(_own_parts(frame, crown)[0])
    for name, each in (attached or {}).items():
        if not isinstance(name, str) or name in own or not isinstance(each, Attachment):
            raise PinpressError(f"attached has {shown(name)}: {shown(each)}: give an Attachment under a name other than {', '.join(own)}")
    if not isinstance(rotors, Sequence) or not all(isinstance(each, Rotor) for each in rotors):
        raise PinpressError(f"rotors is {shown(rotors)}: give a list of Rotor")
    if rotors:
        press.refuse_several_drivers(
            "rotors spin with one crank; leave them out, and give flywheel={driver: Flywheel(...)} to the response"
        )
    system = _assemble(press, frame, mounts, crown, tuple(uprights), attached or {}, tuple(rotors), press_inertia(press, motion))
    for k, mount in enumerate(mounts):
        plausibility.point(f"mount {k + 1}: point", np.array(mount.point), press.size)
    along = press.model.gravity.linear / (float(np.linalg.norm(press.model.gravity.linear)) or 1.0)
    stiffness = sum(float(np.square(along) @ mount.static) for mount in mounts)
    if along.any():
        plausibility.mounts(GRAVITY * system.total_mass, stiffness)
    if isinstance(frame, Frame):
        plausibility.frame_inertia(frame.mass, float(np.linalg.eigvalsh(frame.tensor).max()), press.size)
    links = float(system.press_inertia[0, 0])
    # no frame weighs less than a twentieth of the links that it carries
    if (rest := system.total_mass - links) < 0.05 * links:
        caution(
            f"the frame weighs {rest:.4g} kg, the links of {press.name} {links:.4g} kg: give its mass in kg, {rest:.4g}e3 if t are meant"
        )
    return system


def with_mounts(system: MountedPress, mounts: Sequence[Mount]) -> MountedPress:
    """Put a press on other mounts, without averaging its inertia again.

    Raises:
        PinpressError: as `mounted`.
    """
    mounts, carried = listed_mounts(mounts, "mounts"), (system.attached, system.rotors, system.press_inertia)
    return _assemble(system.press, system.frame, mounts, system.crown, system.uprights, *carried)


@typed
def press_inertia(press: Linkage, motion: Motion | None = None) -> Array:
    """Mean spatial inertia of all links about the world origin over one period, or over the states of a motion.

    Args:
        press: a press with one driver, which turns fully; any press with a ``motion``.
        motion: in equal steps of time; None: one period at constant speed.

    Returns:
        Spatial inertia (6, 6) in world axes, linear before angular [kg, kg m, kg m2].

    Raises:
        PinpressError: the crank does not turn fully or there are several drivers, and no motion is given; the motion is of another press.
    """
    model, data = press.model, data_of(press.model)
    if motion is None:
        press.refuse_several_drivers("the inertia of its links is the mean over their motion; give motion=servo_cycle(press, ...)")
        # the mean over 180 poses is exact for harmonics of order below 180
        period = cycle(press, 1.0, points=180 * (press.period_turns if press.driver_coordinates[0].turns else 1))
    else:
        expect("motion", motion, Motion, "servo_cycle")
        refuse_motion_of_another(press, motion)
        period = motion
    total = np.zeros((6, 6))
    for q in period.q:
        pin.forwardKinematics(model, data, q)
        for place, inertia in zip(data.oMi, model.inertias, strict=True):
            if inertia.mass:
                total += place.act(inertia).matrix()
    return total / len(period.q)


@dataclass(frozen=True, eq=False, repr=False)
class VibrationModes(Tabular):
    """The n modes of free vibration, in order of rising frequency. All arrays are read-only.

    Attributes:
        system: the press on its mounts.
        natural_frequency: (n,) undamped natural frequencies [rad/s].
        shapes: (n, n) undamped mode shapes, one column for each mode, in the coordinates of `MountedPress`, scaled to a modal mass of 1 kg.
        damped_frequency: (n,) frequencies of the damped system [rad/s]; zero for an overdamped mode.
        damping_ratio: (n,) damping divided by critical damping, 1 or more for an overdamped mode [-].
        eigenvalues: (2 n,) eigenvalues of the damped system in first-order form; damped frequencies and damping ratios follow from them
            [1/s].
        motion: (n,) name of the motion with most of each mode's kinetic energy, about the centres of mass: "along z", "rocking about y",
            ... In a frame of two parts ", against" follows if bed and crown move against each other; along z this is "stretching". The name
            of an attachment follows if it has more of the energy than the frame: "rocking about y, motor". The name is "bending" if an
            elastic frame has most of the elastic energy.
    """

    system: MountedPress
    natural_frequency: Array
    shapes: Array
    damped_frequency: Array
    damping_ratio: Array
    eigenvalues: ComplexArray
    motion: tuple[str, ...]

    @property
    def press_name(self) -> str:
        """Name of the press."""
        return self.system.press.name

    @property
    def title(self) -> str:
        return f"VibrationModes of {self.press_name}: {', '.join(f'{f / (2 * np.pi):.4g}' for f in self.natural_frequency)} Hz"

    def resonance_speeds(self, orders: int = 4) -> Array:
        """(orders, n) speeds of the crank at which its first, second, ... harmonic meets each natural frequency [rad/s].

        Args:
            orders: number of harmonics, 1 to 10 000.

        Raises:
            PinpressError: ``orders`` is not a whole number in this range.
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
    """Find the modes of free vibration of a press on its mounts at standstill; for spinning rotors use `whirl`.

    Natural frequencies and shapes follow from mass and stiffness alone. Damped frequencies and damping ratios follow from the eigenvalues
    of the damped system in first-order form; each eigenvalue is assigned to the mode with the largest part in its eigenvector. A loss
    factor counts as the viscous damping with the same energy loss at each mode's own frequency.

    Args:
        system: the press on its mounts.

    Raises:
        PinpressError: ``system`` is not a `MountedPress`.
    """
    squared, shapes = natural_modes(system)
    frequency = np.sqrt(squared)
    damped = damped_modes(frequency, shapes.T @ _resisting(system) @ shapes)
    return VibrationModes(
        system=system,
        natural_frequency=frequency,
        shapes=shapes,
        damped_frequency=damped.frequency,
        damping_ratio=damped.ratio,
        eigenvalues=damped.eigenvalues,
        motion=tuple(motion_in_words(system, shape) for shape in shapes.T),
    )


def natural_modes(system: MountedPress) -> tuple[Array, Array]:
    """Squares of the natural frequencies (n,), rising [rad2/s2], and mode shapes (n, n), one column for each mode, of modal mass 1 kg."""
    # with M = A A^T and K = B B^T, the singular values of B^-1 A are the reciprocal frequencies; so the lowest frequencies are precise even
    # if a stiff frame has very much higher ones
    mass_factor = np.linalg.cholesky(system.mass)
    _, reciprocal, vectors = np.linalg.svd(np.linalg.solve(np.linalg.cholesky(system.stiffness), mass_factor))
    return np.asarray(reciprocal**-2), np.linalg.solve(mass_factor.T, vectors.T)


def quadrature(system: MountedPress) -> Array:
    """Matrix (n, n) that divides the velocity of each mode by its natural frequency [s]: the displacement a quarter of a period later.

    It defines loss factors in the time domain: the force is stiffness x loss factor x this displacement. At each mode's own frequency the
    energy loss is the same as in the frequency domain, so no reference frequency has to be chosen.
    """
    squared, shapes = natural_modes(system)
    return np.asarray((shapes / np.sqrt(squared)) @ shapes.T @ system.mass)


def _resisting(system: MountedPress) -> Array:
    """Damping matrix (n, n) of dampers and of losses at each mode's own frequency [N s/m]."""
    return np.asarray(system.damping + system.loss @ quadrature(system))


def state_matrix(system: MountedPress, speed: float = 0.0) -> Array:
    """State matrix (2 n, 2 n) of free vibration at a crank speed [rad/s]: from (displacements, velocities) to their time derivative."""
    n = len(system.mass)
    solved = np.linalg.solve(system.mass, np.hstack([system.stiffness, _resisting(system) + speed * system.gyroscopic]))
    return np.block([[np.zeros((n, n)), np.eye(n)], [-solved[:, :n], -solved[:, n:]]])


def _assemble(
    press: Linkage,
    frame: Frame | ElasticFrame,
    mounts: tuple[Mount, ...],
    crown: Frame | None,
    uprights: tuple[Mount, ...],
    attached: Mapping[str, Attachment],
    rotors: tuple[Rotor, ...],
    moving: Array,
) -> MountedPress:
    """The linear system of checked parts; ``moving`` is the mean inertia of the press. Raises as `mounted`."""
    gravity = np.asarray(press.model.gravity.linear)
    parts, bed, carrier = _own_parts(frame, crown)
    frame_parts, first = tuple(parts), len(next(iter(parts.values())).T)
    sprung = [name for name, each in attached.items() if each.springs]
    count = first + 6 * len(sprung)
    parts = {name: np.pad(motion, ((0, 0), (0, count - first))) for name, motion in parts.items()}
    on = {name: part_named({part: parts[part] for part in frame_parts}, each.on, carrier) for name, each in attached.items()}
    parts |= {name: np.eye(6, count, first + 6 * k) for k, name in enumerate(sprung)}
    parts |= {name: parts[on[name]] for name, each in attached.items() if not each.springs}
    elastic = np.arange(6, first if isinstance(frame, ElasticFrame) else 6)
    own_stiffness = np.zeros(count)
    if isinstance(frame, ElasticFrame):
        own_stiffness[elastic] = frame.natural_frequency**2
        bodies = [Body(WHOLE, frame.inertia)]
    else:
        bodies = [Body(part, body_inertia(each)) for part, each in zip(frame_parts, (frame, crown), strict=False) if each is not None]
    bodies += [Body(name, body_inertia(each.body)) for name, each in attached.items()]
    between = [Spring(upright, carrier, bed) for upright in uprights]
    between += [Spring(mount, name, on[name]) for name, each in attached.items() for mount in each.springs]
    springs = [Spring(mount, _foot(frame, bed, mount), None) for mount in mounts] + between
    rows = [spring_rows(spring, parts) for spring in springs]
    moved = [*bodies, Body(carrier, moving)]
    mass = np.asarray(sum(parts[body.part].T @ body.inertia @ parts[body.part] for body in moved))
    mass[elastic, elastic] += 1.0
    weight = np.asarray(sum(weight_wrench(body.inertia, gravity) @ parts[body.part] for body in moved))

    def together(constants: Sequence[object]) -> Array:
        return springs_together(zip(np.asarray(constants, dtype=float), rows, strict=True), count)

    refuse_loose(
        np.delete(np.delete(mass, elastic, axis=0), elastic, axis=1),
        "frame and press have no inertia for",
        "give the frame its mass and inertia",
    )
    static = together([spring.mount.static for spring in springs]) + np.diag(own_stiffness)
    others = np.setdiff1d(np.arange(count), elastic)
    across = static[np.ix_(elastic, others)]  # static condensation: no force acts on the modal coordinates of an elastic frame
    condensed = static[np.ix_(others, others)] - across.T @ np.linalg.solve(static[np.ix_(elastic, elastic)], across)
    refuse_loose(condensed, "the mounts leave the frame free in", "give mounts there, and stiffness in all directions")
    rest = np.linalg.solve(static, weight)
    sag = np.array([row @ rest for row in rows[: len(mounts)]])
    load = -np.array([mount.static for mount in mounts]) * sag
    refuse_pulled(load, gravity)
    # the static forces rotate with the mean motion of an elastic frame
    turning = parts | dict.fromkeys(frame_parts, parts[WHOLE]) if isinstance(frame, ElasticFrame) else parts
    acting = [(turning[body.part], body.inertia[0, 0] * gravity, centre_of(body.inertia)) for body in moved]
    for spring, row in zip(springs, rows, strict=True):
        force, point = -np.array(spring.mount.static) * (row @ rest), np.array(spring.mount.point)
        acting.append((turning[spring.part], force, point))
        if spring.other is not None:
            acting.append((turning[spring.other], -force, point))
    stiffness = together([spring.mount.stiffness for spring in springs]) + turning_stiffness(acting, count) + np.diag(own_stiffness)
    loss = together([spring.mount.loss_factor * np.array(spring.mount.stiffness) for spring in springs])
    if isinstance(frame, ElasticFrame):
        loss += frame.loss_factor * np.diag(own_stiffness)
    system = MountedPress(
        press=press,
        frame=frame,
        crown=crown,
        mounts=mounts,
        uprights=uprights,
        attached=FrozenMapping(attached),
        rotors=rotors,
        parts=FrozenMapping(parts),
        bed=bed,
        carrier=carrier,
        rigid=np.insert(np.tile(np.eye(6), ((count - len(elastic)) // 6, 1)), np.full(len(elastic), 6), 0.0, axis=0),
        mass=mass,
        damping=together([spring.mount.damping for spring in springs]),
        stiffness=0.5 * (stiffness + stiffness.T),
        loss=loss,
        gyroscopic=gyroscopic_matrix(rotors, parts, carrier, count),
        weight=weight,
        press_weight=weight_wrench(moving, gravity),
        press_inertia=moving,
        mount_load=load,
        sag=sag,
    )
    if np.linalg.eigvalsh(system.stiffness)[0] <= 0:
        raise PinpressError(
            f"{press.name} tips over on these mounts: its weight turns it further than they hold; set them wider apart, or stiffer"
        )
    return system


def _own_parts(frame: Frame | ElasticFrame, crown: Frame | None) -> tuple[dict[str, Array], str, str]:
    """Motions (6, n) of the parts of the frame itself, and the names of bed and carrier."""
    if isinstance(frame, ElasticFrame):
        motions = dict(frame.motions)
        return {WHOLE: np.eye(6, len(motions[frame.bed].T))} | motions, frame.bed, frame.carrier
    own = ("frame",) if crown is None else ("bed", "crown")
    return motions_of(own), own[0], own[-1]


def _foot(frame: Frame | ElasticFrame, bed: str, mount: Mount) -> str:
    """Name of the part at which a mount stands; raises PinpressError if an elastic frame has no interface there."""
    return frame.node_at(mount.point) if isinstance(frame, ElasticFrame) else bed


def motion_in_words(system: MountedPress, shape: Array) -> str:
    """Name of the motion with most of the kinetic energy in a mode shape (n,), as in `VibrationModes.motion`."""
    own = [WHOLE] if isinstance(system.frame, ElasticFrame) else [part for part in system.parts if part not in system.attached]
    sprung = [name for name, each in system.attached.items() if each.springs]
    moved = {part: _motion_of_part(system, part, shape) for part in (*own, *sprung)}
    energy = {"": np.sum([moved[part][1] for part in own], axis=0)} | {name: moved[name][1] for name in sprung}
    where = max(energy, key=lambda name: float(energy[name].sum()))
    most = int(energy[where].argmax())
    if isinstance(system.frame, ElasticFrame):
        bent = shape[6 : 6 + len(system.frame.natural_frequency)] * system.frame.natural_frequency
        if bent @ bent > 0.5 * shape @ system.stiffness @ shape:
            return BENDING
    if where:
        return f"{MOTIONS[most]}, {where}"
    if len(own) == 2 and moved[own[0]][0][most] * moved[own[1]][0][most] < 0:
        return "stretching" if most == 2 else f"{MOTIONS[most]}, against"
    return MOTIONS[most]


def _motion_of_part(system: MountedPress, part: str, shape: Array) -> tuple[Array, Array]:
    """Displacement of a part's centre of mass and its rotation (6,) in a mode shape (n,), and twice the kinetic energy (6,) in each."""
    motion, rows = system.parts[part], system.parts[part].any(axis=0)
    body = np.linalg.pinv(motion[:, rows]).T @ system.mass[np.ix_(rows, rows)] @ np.linalg.pinv(motion[:, rows])
    u, mass, centre = motion @ shape, body[0, 0], centre_of(body)
    velocity, momentum = u[:3] + np.cross(u[3:], centre), body @ u
    energy = np.concatenate([mass * velocity**2, (momentum[3:] - np.cross(centre, momentum[:3])) * u[3:]])
    return np.concatenate([velocity, u[3:]]), energy
