"""Natural vibrations of an elastic press: frequencies, damping and shapes over the crank angle.

The equations of an elastic press are linearised about the rigid pose at each crank angle: M u'' + C u' + K u = 0, with the free coordinates
u of `SprungPress`. The springs are unloaded in this pose, so K = sum k g g' with the gradients g of their elongations. The change of the
pose during a vibration is neglected: the lowest natural frequency should be several times the crank's frequency. The crank is held, as by a
drive of constant speed, or turns with the flywheel on its shaft. In the second case there is also a rigid-body mode of frequency zero,
which is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import numbers, typed
from ..common.errors import PinpressError
from ..common.frozen import FrozenMapping, read_only
from ..common.numerics import damped_modes, undamped_modes
from ..common.quantities import Array
from ..common.results import Tabular
from ..drives.transmission import Flywheel
from ..kinematics.cycle import motion_through_change_points
from ..linkage.assembly import refuse_far
from ..linkage.linkage import Linkage, OfPress
from ..simulation.elastic.description import Elastic
from ..simulation.elastic.press.assembly import sprung_press
from ..simulation.elastic.press.geometry import BodyState
from ..simulation.elastic.press.plane import PlaneGeometry
from ..simulation.elastic.press.space import SpaceGeometry, SpaceState
from ..simulation.elastic.press.sprung_press import SprungPress
from ..simulation.elastic.yielding import FRAME, link_joint, part_stiffness

MOUNTS = "mounts"  # name of the springs below a frame
POINTS = 360  # crank angles of a turn
APART = 1e-9  # modes whose mutual damping is a smaller share are damped independently
NAMED = 3  # parts and links in the name of a mode


@dataclass(frozen=True, eq=False, repr=False)
class ElasticModes(OfPress, Tabular):
    """The m lowest free vibrations of an elastic press at each of n crank angles, by rising frequency. All arrays are read-only.

    If two frequencies meet over the turn, their curves cross or veer. Modes are numbered by frequency at each angle.

    Attributes:
        press_name: name of the press.
        elastic: the elastic parts.
        flywheel: flywheel on a crank that turns freely; None: the crank is held.
        crank_angle: (n,) crank angles [rad].
        natural_frequency: (n, m) undamped natural frequencies [rad/s].
        damping_ratio: (n, m) damping divided by critical damping, 1 or more for an overdamped mode [-].
        shapes: (n, m, links, 3) undamped shapes: displacement of each moving link's centre of mass along the two axes of the plane [m], and
            its rotation [rad], scaled to a modal mass of 1 kg; for a linkage in space (n, m, links, 6) in world axes, as in `ElasticRun`.
        strain_energy: name of an elastic part -> (n, m) its share of the strain energy [-].
        kinetic_energy: name of a link, "crown" or "shaft" -> (n, m) its share of the kinetic energy [-].
    """

    _press: Linkage
    elastic: Elastic
    flywheel: Flywheel | None
    crank_angle: Array
    natural_frequency: Array
    damping_ratio: Array
    shapes: Array
    strain_energy: Mapping[str, Array]
    kinetic_energy: Mapping[str, Array]
    _bottom: float
    _bending: Array  # (n, m, Q) coordinates of the shapes of flexible links, in the order of `SprungPress`

    @property
    def title(self) -> str:
        low, high = self.natural_frequency[:, 0].min() / (2 * np.pi), self.natural_frequency[:, 0].max() / (2 * np.pi)
        return f"ElasticModes of {self.press_name}: {self.natural_frequency.shape[1]} modes, the lowest {low:.4g} to {high:.4g} Hz"

    @property
    def nearest_to_bottom(self) -> int:
        """Number of the crank angle nearest to bottom dead centre."""
        apart = np.abs((self.crank_angle - self._bottom + np.pi) % (2 * np.pi) - np.pi)
        return int(apart.argmin())

    def words(self, state: int, mode: int) -> tuple[str, str]:
        """The parts with most of a mode's strain energy, and the links with most of its kinetic energy, with their shares."""
        return _most(self.strain_energy, state, mode), _most(self.kinetic_energy, state, mode)

    def columns(self) -> dict[str, Array]:
        """A row for each crank angle: the natural frequencies of all modes, then their damping ratios."""
        count = self.natural_frequency.shape[1]
        columns = {"crank_angle [rad]": self.crank_angle}
        columns |= {f"natural_frequency_{k + 1} [rad/s]": self.natural_frequency[:, k] for k in range(count)}
        return columns | {f"damping_ratio_{k + 1} [-]": self.damping_ratio[:, k] for k in range(count)}


def _most(shares: Mapping[str, Array], state: int, mode: int) -> str:
    ordered = sorted(((round(float(share[state, mode]), 9), name) for name, share in shares.items()), key=lambda item: -item[0])
    named = [(share, name) for share, name in ordered[:NAMED] if share >= 0.1] or ordered[:1]
    return ", ".join(f"{name} {100 * share:.0f} %" for share, name in named)


@typed
def natural_frequencies(
    press: Linkage, elastic: Elastic, *, angle: ArrayLike | None = None, flywheel: Flywheel | None = None
) -> ElasticModes:
    """Find natural frequencies, damping ratios and mode shapes of an elastic press over the crank angle.

    Args:
        press: a press with one driver that turns.
        elastic: the elastic parts, as for `simulate`.
        angle: (n,) crank angles [rad]; by default 360 per turn over one period, without its end.
        flywheel: flywheel on the driver's shaft of a crank that turns freely; None: the crank is held, or turns at a constant speed.

    Raises:
        UnknownNameError: the linkage has no such bearing or link.
        PinpressError: a part has no stiffness or a link no mass, a pin has clearance, or the crank does not turn
            fully and no angle is given.
        AssemblyError: the linkage does not reach an angle.
    """
    if isinstance(elastic, Elastic) and elastic.clearances:
        raise PinpressError("a pin with clearance has no natural frequency, as it opens and closes: leave the clearances out")
    sprung, angles = sprung_press(press, elastic), _angles(press, angle)
    geometry = sprung.geometry
    coordinates, _, _ = geometry.rigid(motion_through_change_points(press, angles, 0.0))
    state = geometry.state(coordinates, np.zeros_like(coordinates))
    forces = sprung.spring_forces(state)
    mass, count = sprung.mass_at(state).copy(), sprung.free - (flywheel is None)
    wheel = 0.0 if flywheel is None else flywheel_inertia(flywheel)
    mass[..., -1, -1] += wheel
    squared, shapes = undamped_modes(mass[..., :count, :count], forces.stiffness[:, :count, :count])
    first = 0 if flywheel is None else 1  # the rigid-body mode has no frequency
    frequency, shapes = np.sqrt(np.maximum(squared[:, first:], 0.0)), shapes[:, :, first:]
    free = np.zeros((len(angles), sprung.free, shapes.shape[2]))
    free[:, :count] = shapes
    moved = np.swapaxes(sprung.carry @ free, 1, 2)
    if isinstance(geometry, SpaceGeometry):
        displaced, bending = _shapes_in_space(geometry, state, moved), moved[:, :, :0]
        kinetic = _kinetic_energy_in_space(geometry, state, moved, wheel)
    else:
        displaced = moved[:, :, : 3 * press.model.nv].reshape(*moved.shape[:2], -1, 3)
        bending = moved[:, :, geometry.rigid_size :]
        kinetic = _kinetic_energy(geometry, moved, wheel)
    return ElasticModes(
        _press=press,
        elastic=elastic,
        flywheel=flywheel,
        crank_angle=read_only(angles),
        natural_frequency=read_only(frequency),
        damping_ratio=read_only(_damping_ratios(frequency, shapes, forces.damping[:, :count, :count])),
        shapes=read_only(displaced.copy()),
        strain_energy=_shares(_strain_energy(sprung, elastic, state, moved)),
        kinetic_energy=_shares(kinetic),
        _bottom=float(sprung.reference.crank_angle[0]),
        _bending=read_only(bending.copy()),
    )


def flywheel_inertia(flywheel: Flywheel) -> float:
    """Inertia of a flywheel [kg m2]; raises `PinpressError` if it has several."""
    if np.ndim(flywheel.inertia):
        raise PinpressError("flywheel has several inertias: give one, natural frequencies are those of one press")
    return float(flywheel.inertia)


def _angles(press: Linkage, given: ArrayLike | None) -> Array:
    if given is None:
        if press.period_turns is None:
            raise PinpressError(f"the crank of {press.name} does not turn fully: give the crank angles as angle=[...]")
        return np.asarray(np.arange(POINTS * press.period_turns) * (2 * np.pi / POINTS), dtype=float)
    angles = np.atleast_1d(numbers("angle", given, unit="rad"))
    if angles.ndim != 1 or not len(angles):
        raise PinpressError(f"angle has shape {angles.shape}: give (n,) crank angles [rad]")
    refuse_far("angle", angles, press.driver_coordinates)
    return angles


def _damping_ratios(frequency: Array, shapes: Array, damping: Array) -> Array:
    """(n, m) damping ratios of modes with frequencies (n, m) and shapes (n, f, m).

    Dampers proportional to the springs damp each mode separately. Other dampers couple the modes; then the ratios follow from the
    eigenvalues of the damped press in first-order form.
    """
    modal = np.swapaxes(shapes, 1, 2) @ damping @ shapes
    diagonal: Array = np.diagonal(modal, axis1=1, axis2=2)
    tiny = np.finfo(float).tiny
    if np.abs(modal - diagonal[:, None, :] * np.eye(diagonal.shape[1])).max() <= APART * max(float(diagonal.max()), tiny):
        return np.asarray(diagonal / (2 * np.maximum(frequency, tiny)), dtype=float)
    return np.array([damped_modes(w, c).ratio for w, c in zip(frequency, modal, strict=True)])


def _strain_energy(sprung: SprungPress, elastic: Elastic, state: BodyState, moved: Array) -> dict[str, Array]:
    """Name of a part -> (n, m) twice its strain energy, for displacements (n, m, k). A rod and its pin share by compliance; in space the
    rotation of a bearing is a separate part."""
    press, geometry, springs, energy = sprung.press, sprung.geometry, sprung.springs, dict[str, Array]()
    stored = springs.stiffness * (moved @ geometry.gradient(geometry.strains(state)).swapaxes(1, 2)) ** 2
    rods = {(name, link_joint(press, rod.link) - 1): rod for rod in elastic.stiffness.rods for name in rod.between}
    for spring, (bearing, body) in enumerate(zip(springs.bearing, geometry.lines.first, strict=True)):
        name = press.bearings[bearing] if bearing >= 0 else FRAME if geometry.base is None else MOUNTS
        part = name if springs.sign[spring] else f"{name} turning"
        share, rod = 1.0, rods.get((name, int(body)))
        if rod is not None:
            share = springs.stiffness[spring] / part_stiffness(name, elastic.stiffness.bearings[name])
        energy[part] = energy.get(part, 0.0) + share * stored[:, :, spring]
        if rod is not None and share < 1.0:
            energy[rod.name] = energy.get(rod.name, 0.0) + (1.0 - share) * stored[:, :, spring]
    linear = sprung.linear.stiffness * sprung.linear_rates(moved) ** 2
    for column, part in enumerate(sprung.linear.parts):
        energy[part] = energy.get(part, 0.0) + linear[:, :, column]
    return energy


def _kinetic_energy(geometry: PlaneGeometry, moved: Array, flywheel: float) -> dict[str, Array]:
    """Name of a body, or "flywheel" -> (n, m) twice its kinetic energy, for displacements (n, m, k)."""
    press = geometry.press
    energy = (geometry.inertia * moved**2)[:, :, : geometry.rigid_size].reshape(*moved.shape[:2], -1, 3).sum(axis=3)
    for link in geometry.flexible:
        energy[:, :, link.body] += link.mass * (moved[:, :, link.columns] ** 2).sum(axis=2)
    energies = {press.link_of(body + 1): energy[:, :, body] for body in range(press.model.nv)}
    if geometry.crown is not None:
        energies["crown"] = energy[:, :, geometry.crown]
    if geometry.base is not None:
        energies[FRAME] = energy[:, :, geometry.base]
    if flywheel:
        body = geometry.rotor if geometry.rotor is not None else press.joints.index(press.driver)
        energies["flywheel"] = flywheel * moved[:, :, 3 * body + 2] ** 2
    return energies


def _shares(parts: Mapping[str, Array]) -> FrozenMapping[str, Array]:
    total = np.maximum(np.sum(list(parts.values()), axis=0), np.finfo(float).tiny)
    return FrozenMapping({name: read_only(part / total) for name, part in parts.items()})


def _shapes_in_space(geometry: SpaceGeometry, state: SpaceState, moved: Array) -> Array:
    """(n, m, links, 6) displacements of all moving links of a linkage in space, in world axes, as in `ElasticRun`.

    A shape is a small displacement of all coordinates of the bodies from the rigid pose. The derivatives of a body's rotation matrix give
    its small rotation vector and its kinetic energy.

    Args:
        geometry: geometry of the elastic press.
        state: the n rigid poses.
        moved: (n, m, k) shapes of m modes in all coordinates.
    """
    press, changed = geometry.press, _changed_matrices(geometry, state, moved)
    n, m = moved.shape[:2]
    matrices = state.turned.matrix.reshape(n, 1, -1, 3, 3)[:, :, : geometry.count]
    spin = changed.reshape(n, m, -1, 3, 3) @ matrices.swapaxes(-1, -2)
    turn = np.stack([spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]], axis=-1)
    straight = moved[:, :, : 6 * geometry.count].reshape(n, m, -1, 6)[..., :3]
    shapes = np.zeros((n, m, press.model.nv, 6))
    for body, joint in enumerate(geometry.joints):
        shapes[:, :, joint - 1] = np.concatenate([straight[:, :, body], turn[:, :, body]], axis=2)
    for joint in range(1, press.model.nv + 1):
        if joint not in geometry.joints:  # a massless cross moves with its carrier
            body = geometry.joints.index(int(press.model.parents[joint]))
            place = geometry.own_axes[body].T @ (press.model.jointPlacements[joint].translation - geometry.lever[body])
            arm = (matrices[:, 0, body] @ place)[:, None]
            shapes[:, :, joint - 1] = np.concatenate([straight[:, :, body] + np.cross(turn[:, :, body], arm), turn[:, :, body]], axis=2)
    return shapes


def _kinetic_energy_in_space(geometry: SpaceGeometry, state: SpaceState, moved: Array, flywheel: float) -> dict[str, Array]:
    """Name of a link, or "flywheel" -> (n, m) twice its kinetic energy, for shapes as in `_shapes_in_space`; ``flywheel``: its inertia [kg
    m2]."""
    changed = _changed_matrices(geometry, state, moved)
    n, m = moved.shape[:2]
    turning = (geometry.weigh(changed.reshape(n * m, -1, 9)).reshape(changed.shape) * changed).sum(axis=3)
    straight = (moved[:, :, : 6 * geometry.count].reshape(n, m, -1, 6)[..., :3] ** 2).sum(axis=3) * geometry.mass_of
    energy = {geometry.press.link_of(joint): (turning + straight)[:, :, body] for body, joint in enumerate(geometry.joints)}
    return energy | ({"flywheel": flywheel * moved[:, :, -1] ** 2} if flywheel else {})


def _changed_matrices(geometry: SpaceGeometry, state: SpaceState, moved: Array) -> Array:
    """(n, m, B, 9) changes of the bodies' matrices by the shapes."""
    n, m, count = *moved.shape[:2], geometry.count
    by = state.turned.by[:, None, :count]
    turning = moved[:, :, : 6 * count].reshape(n, m, count, 6)[..., 3:]
    every = np.concatenate([turning, np.broadcast_to(moved[:, :, None, -1:], (n, m, count, 1))], axis=3)
    return np.asarray((every[..., None, :] @ by)[..., 0, :])
