"""Bearings with friction over the crank angle of a linkage with one driver.

Friction in the bearings adds a torque that depends on the forces in them, these on the acceleration w' and on friction itself. At a crank
angle the radial force of every bearing is the length of a vector that is affine in all of them:

    N = A w' + B w^2 + G + sum F L + sum e S

with the efforts e = -(c s + mu r |N| sign s) of friction, where s is the speed of the bearing (in a preloaded guide with the preload where
|N| is smaller). The vectors A, B (inertia), G (weight), L (loads) and S (friction) are kept as polynomials, panel by panel, too. By virtual
work friction is the torque sum e ds/dw on the crank, so that w' and all e follow together: they are found in turn until they no longer
change, as in `FrictionLaw.efforts`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..common.errors import PinpressError
from ..common.numerics import NODES
from ..common.quantities import Array
from ..dynamics.panels import POWERS, Panels, last_terms, resolve
from ..engines.engine import ClosedStates
from ..engines.friction import MOST_ITERATIONS, FrictionLaw, fixed_point
from ..engines.machine_elements.forces import bearing_loads
from ..engines.wrenches import AppliedConditions, AppliedForce
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from .failures import failure
from .reduced_model import ReducedModel

BY_ACCELERATION, BY_SQUARED_SPEED, BY_WEIGHT, BY_LOADS = 0, 1, 2, 3  # parts of the radial vectors: A, B, G and the first L
NOTHING = 1e-13  # share of the largest vector of a part below which a component is rounding throughout

UnitForce = Callable[[Motion], Sequence[AppliedForce]]
"""The forces on links over a motion for which a generalized force of 1 along a coordinate stands."""


@dataclass(frozen=True, eq=False, repr=False)
class BearingModel(Panels):
    """Speeds of the bearings with friction, and the vectors of their radial forces, over the crank angle.

    Attributes:
        borders: (p + 1,) of the panels, rising [rad].
        coefficients: (p, rows, q) of powers of x, from -1 to 1 over a panel. Rows are the speeds of the K bearings by that of the crank,
            then C components of A, of B, of G, of every L and of every S.
        period: that of the reduced model.
        law: the friction of the K bearings that have some.
        reduced: reduced model of the same linkage.
        owners: (K, C) 1 where a component belongs to a bearing, else 0.
    """

    law: FrictionLaw
    reduced: ReducedModel
    owners: Array

    @cached_property
    def reversals(self) -> tuple[Array, ...]:
        """Crank angles in the model's range at which each bearing turns back, so that its friction is not smooth [rad]."""
        return tuple(self.roots(row) for row in range(len(self.law.arm)) if self.coefficients[:, row].any())

    def states(self, angle: Array) -> BearingStates:
        """The bearings at crank angles (n,)."""
        rows, _ = self.at(self.reduced.local(angle), derivative=False)
        count, components = self.owners.shape
        vectors = rows[count:].reshape(-1, components, len(angle))
        return BearingStates(self, angle, self._moving(rows[:count].T).T, vectors[:-count], vectors[-count:])

    def torque_at(self, angle: float, way: int, speed: float, net: float, inertia: float, forces: Sequence[float]) -> float:
        """Torque of friction on the crank in one state, by Newton's method: the steps of `BearingStates.torque` take longer there.

        Args:
            angle: crank angle [rad].
            way: +1 or -1, in which the crank turns or starts.
            speed: of the crank [rad/s].
            net: torque on the crank of all but friction, less I' w^2 / 2 [N m].
            inertia: at the crank [kg m2].
            forces: of the loads along the coordinates [N].

        Raises:
            SimulationError: friction locks the linkage.
        """
        law, (count, components) = self.law, self.owners.shape
        local = float(self.reduced.local(np.array([angle]))[0])
        panel, _, x = self.panel_of(local)
        rows = self.coefficients[panel] @ x**POWERS
        moving, vectors = way * self._moving(rows[:count]), rows[count:].reshape(-1, components)
        lever, accelerated = np.where(law.pushes, 0.0, np.abs(moving)), vectors[BY_ACCELERATION] / inertia
        free = accelerated * net + vectors[BY_SQUARED_SPEED] * speed**2 + vectors[BY_WEIGHT]
        for row, force in enumerate(forces):
            if force:
                free = free + vectors[BY_LOADS + row] * force
        ways = np.where(law.pushes, 1.0, -np.sign(moving))
        responses = vectors[-count:] * ways[:, None] - np.outer(way * lever, accelerated)
        viscous = law.viscous * lever * (way * speed)
        efforts = viscous
        for _ in range(MOST_ITERATIONS):
            radial = free + efforts @ responses
            across = np.sqrt(self.owners @ (radial * radial))
            pressing = np.maximum(across, law.preload)
            arm = np.where((self.owners @ radial) * moving < 0, law.backward, law.arm)
            gain = np.where(across > law.preload, arm, 0.0)  # of friction by the force; that of a preload stays as it is
            slopes = (self.owners * radial) @ responses.T * (gain / np.where(across > 0, across, 1.0))[:, None]
            try:
                step = np.linalg.solve(np.eye(count) - slopes, viscous + arm * pressing - efforts)
            except np.linalg.LinAlgError:
                break
            efforts = efforts + step
            # Newton's method squares the error: the next step would be about 1e-18.
            if np.abs(step).max() <= 1e-9 * np.abs(efforts).max():
                # beyond a gain of 1 friction would have to support itself
                if np.abs(slopes).sum(axis=1).max() < 1.0 or np.linalg.eigvals(slopes).real.max() < 1.0:
                    return -way * float(lever @ efforts)
                break
        raise failure("friction locks", None, angle)

    def _moving(self, speeds: Array) -> Array:
        """Speeds (..., K) of the bearings, exactly zero where they are rounding, as at a dead centre."""
        return np.where(np.abs(speeds) <= self._rest, 0.0, speeds)

    @cached_property
    def _rest(self) -> Array:
        # Less than this share of the largest speed is rounding.
        return np.asarray(1e-11 * np.abs(self.coefficients[:, : len(self.law.arm), 0]).max(axis=0))


@dataclass(frozen=True, eq=False, repr=False)
class BearingStates:
    """K bearings at n crank angles.

    Attributes:
        model: of the bearings.
        angle: (n,) crank angles [rad].
        speed: (K, n) speeds of the bearings by that of the crank.
        parts: (parts, C, n) vectors A, B, G and L.
        responses: (K, C, n) vectors S.
    """

    model: BearingModel
    angle: Array
    speed: Array
    parts: Array
    responses: Array

    def torque(
        self, direction: float, speed: Array, net: Array, inertia: Array, forces: Mapping[int, Array], start: Array | None = None
    ) -> tuple[Array, Array]:
        """Torque (n, S) of friction along the travel of the crank [N m], in S scenarios, and sizes (K, n, S) of the efforts of friction.

        Args:
            direction: +1 or -1, in which the crank turns.
            speed: (n, S) its speed in this direction [rad/s].
            net: (n, S) torque along the travel of all but friction, less I' w^2 / 2 [N m].
            inertia: (n, S) or (n, 1) at the crank, infinite where its speed is held [kg m2].
            forces: (n, S) of the loads along each coordinate, by its row [N].
            start: (K, n, S) sizes of efforts to begin with; None: those of viscous friction.

        Raises:
            SimulationError: friction locks the linkage.
        """
        law, moving = self.model.law, (direction * self.speed)[:, :, None]
        pushes = law.pushes[:, None, None]
        lever = np.where(pushes, 0.0, np.abs(moving))
        along = direction * self.parts[BY_ACCELERATION, :, :, None]
        # the efforts act on the acceleration of the crank, too
        responses = self.responses[..., None] * np.where(pushes, 1.0, -np.sign(moving))[:, None] - along * (lever / inertia)[:, None]
        free = along * (net / inertia) + self.parts[BY_SQUARED_SPEED, :, :, None] * speed**2 + self.parts[BY_WEIGHT, :, :, None]
        for row, force in forces.items():
            free = free + self.parts[BY_LOADS + row, :, :, None] * force
        viscous = law.viscous[:, None, None] * lever * speed
        count, size = len(lever), speed.size
        # einsum is slow where its last axis is short, as that of one scenario
        flat = np.broadcast_to(responses, (count, *free.shape)).reshape(count, -1, size)

        def follow(efforts: Array) -> tuple[Array, Array]:
            radial = free + np.einsum("kcm,km->cm", flat, efforts.reshape(count, size)).reshape(free.shape)
            pressing = np.maximum(np.sqrt(np.tensordot(self.model.owners, radial * radial, axes=1)), law.preload[:, None, None])
            backwards = np.tensordot(self.model.owners, radial, axes=1) * moving < 0
            following = viscous + np.where(backwards, law.backward[:, None, None], law.arm[:, None, None]) * pressing
            return following, np.abs(following).max(axis=0)

        efforts, change = fixed_point(follow, viscous if start is None else start, 1e-14)
        if change is not None:
            raise failure("friction locks", None, float(self.angle[int(np.argmax(change.max(axis=1)))]))
        return -(lever * efforts).sum(axis=0), efforts


def build_bearing_model(press: Linkage, law: FrictionLaw, reduced: ReducedModel, unit_forces: Sequence[UnitForce]) -> BearingModel:
    """The model of the bearings of a linkage with one driver.

    Args:
        press: the linkage.
        law: friction of all its bearings.
        reduced: its reduced model.
        unit_forces: of every coordinate of the loads.

    Raises:
        PinpressError: the linkage goes through change points, where its bearing forces have no bounds.
    """
    if press.branch_through_change_points.change_points:
        place = press.driver_coordinates[0].at(press.branch_through_change_points.change_points[0].angle)
        raise PinpressError(
            f"the bearing forces of {press.name} grow without bounds at its change point at {place}: simulate it without friction"
        )
    rubs = (law.arm > 0) | (law.backward > 0) | (law.viscous > 0)
    pressed = bool((law.arm[: len(press.bearings)] > 0).any())  # what pushes gears apart matters to dry friction of bearings alone
    with_friction = np.flatnonzero(rubs & (pressed | ~law.pushes))
    kept_law = law.of(with_friction)
    count, sampling = len(with_friction), _Sampling(press, law, with_friction, unit_forces)
    sampled, _ = resolve(sampling.rows, reduced.borders, sampling.missed)
    coefficients = sampled.coefficients
    speeds = np.abs(coefficients[:, :count]).max(axis=2) / np.where(kept_law.turns, 1.0, press.size)
    fastest = speeds.max(axis=1).clip(min=1.0 if press.driver_coordinates[0].turns else 1.0 / press.size)  # near a lock without bounds
    # Next to the fastest bearing, the speed of one that rests is rounding, which is larger near a lock.
    still = (speeds <= 1e-10 * fastest[:, None]).all(axis=0)
    coefficients[:, np.flatnonzero(still)] = 0.0  # speeds of bearings that do not move are rounding
    vectors = coefficients[:, count:].reshape(len(coefficients), -1, count, 3, NODES)  # (p, parts, K, 3, q)
    size = np.abs(vectors).max(axis=(0, 4))
    counts = (size > NOTHING * size.max(axis=(1, 2), keepdims=True)).any(axis=0) & ((kept_law.arm > 0) | (kept_law.backward > 0))[:, None]
    counts[0, 0] |= not counts.any()  # of viscous friction alone no component counts; one makes no difference
    owners = np.zeros((count, int(counts.sum())))
    owners[np.nonzero(counts)[0], np.arange(owners.shape[1])] = 1.0
    rows = np.concatenate([coefficients[:, :count], vectors[:, :, counts].reshape(len(coefficients), -1, NODES)], axis=1)
    return BearingModel(sampled.borders, rows, reduced.period, kept_law, reduced, owners)


class _Sampling:
    """Samples of a linkage's bearings at crank angles."""

    def __init__(self, press: Linkage, law: FrictionLaw, with_friction: NDArray[np.intp], unit_forces: Sequence[UnitForce]) -> None:
        """Begin with a linkage.

        Args:
            press: the linkage.
            law: friction of all its bearings.
            with_friction: (K,) indices of the bearings with friction.
            unit_forces: of every coordinate of the loads.
        """
        self.press, self.with_friction, self.unit_forces = press, with_friction, unit_forces
        self.count, self.turns = len(law.turns), law.turns[with_friction]

    def rows(self, angles: Array) -> Array:
        """Rows (K + 3 K parts, n) at crank angles (n,): speeds, then the components of all parts."""
        press, zero = self.press, np.zeros((self.count, len(angles)))
        motion = motion_through_change_points(press, angles, 1.0)  # at unit speed rates are derivatives by the crank angle
        states = motion.states(press)
        gravity, mass = float(np.linalg.norm(press.model.gravity.linear)), sum(float(inertia.mass) for inertia in press.model.inertias)
        # All parts but weights are differences: they are as large as these, so that they lose no digits.
        pace = np.sqrt((gravity or 1.0) / self.press.size)
        force = (gravity or 1.0) * mass or 1.0

        def radial(v: float = 0.0, a: Array | float = 0.0, loads: Sequence[AppliedForce] = (), efforts: Array = zero) -> Array:
            state = ClosedStates(states.position, v * states.v, a + 0.0 * states.a, states.basis)
            conditions = AppliedConditions(list(loads), None, None, friction=efforts)
            return bearing_loads(press.engine(), state, conditions, states.v).radial.transpose(0, 2, 1)

        weight = radial()

        def part(vectors: Array, scale: float) -> Array:
            """What vectors have in addition to those of weights, for a unit of what is as large as a scale; zero where it is rounding."""
            more = vectors - weight
            return np.where(np.abs(more) > NOTHING * np.abs(vectors).max(axis=(0, 1), initial=force), more, 0.0) / scale

        parts = [part(radial(a=pace**2 * states.v), pace**2), part(radial(v=pace, a=pace**2 * states.a), pace**2), weight]
        for unit_force in self.unit_forces:
            units = unit_force(motion)
            sizes = [np.abs(unit.force).max() for unit in units]
            sizes += [np.abs(unit.moment).max() / press.size for unit in units if unit.moment is not None]
            scale = force / (float(max(sizes, default=0.0)) or 1.0)
            parts.append(part(radial(loads=[unit.times(scale) for unit in units]), scale))
        for bearing, turns in zip(self.with_friction.tolist(), self.turns.tolist(), strict=True):
            efforts, effort = zero.copy(), force * (press.size if turns else 1.0)
            efforts[bearing] = effort
            parts.append(part(radial(efforts=efforts), effort))
        speed = bearing_loads(press.engine(), states, AppliedConditions([], None, None, friction=zero), states.v).speed[self.with_friction]
        vectors = np.array(parts)
        # next to the largest forces others are rounding, as in the guide of a symmetric press; polynomials do not resolve it
        rubbing = np.where(np.abs(vectors) > NOTHING * np.abs(vectors).max(axis=(1, 2), keepdims=True), vectors, 0.0)[:, self.with_friction]
        return np.concatenate([speed, rubbing.reshape(-1, len(angles))])

    def missed(self, values: Array) -> Array:
        """(p,) what polynomials through values (q, rows, p) on p panels miss, as a share of the speeds and of each part."""
        count, panels = len(self.with_friction), values.shape[2]
        tail, sizes = last_terms(values), np.abs(values).max(axis=0)
        least = np.where(self.turns, 1.0, self.press.size) * (1.0 if self.press.driver_coordinates[0].turns else 1.0 / self.press.size)
        speeds = (tail[:count] / np.maximum(sizes[:count], least[:, None])).max(axis=0)
        # a part is measured by the largest of its vectors on the panel: near a lock they have no bounds, elsewhere some are rounding
        size = sizes[count:].reshape(-1, 3 * count, panels).max(axis=1)
        parts = tail[count:].reshape(-1, 3 * count, panels).max(axis=1) / np.where(size > 0, size, 1.0)
        return np.asarray(np.maximum(speeds, parts.max(axis=0)))
