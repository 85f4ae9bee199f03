"""Inverse dynamics of linkages whose bodies push on each other by teeth or threads: the wrenches there, in place of efforts in joints.

Engines balance all forces with the effort of each relation on the joints that it names. The wrench of its contact has the same power in
every motion of the closed linkage. So a first pass of the engine gives motion, driving torque and efforts of the relations, and a second
one, with the wrenches of the contacts as loads on their bodies, gives zero efforts in joints, and the true bearing forces. This holds for
every engine, and for carriers that only loops join to their gears.

Rubbing and the forces that push gears apart depend on the sizes of efforts. Each of them is a row of the friction law, after the rows of
the bearings: first every `Rubbing`, then every contact with a push. A row of a contact has the effort of its relation for a radial force,
with its sign.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..contacts import Contact, Rubbing
from ..engine import ClosedStates, Engine
from ..friction import FrictionLaw
from ..sharing import share
from ..structure import Structure
from ..wrenches import ORIGIN, AppliedConditions, AppliedForce, BearingLoads, Idle, Wrenches


def friction_law(arm: Array, viscous: Array, preload: Array, structure: Structure) -> FrictionLaw | None:
    """The friction of bearings, (bearings,) each as in `FrictionLaw`, and of the contacts; None if there is none."""
    rubbings, pushing = list(_rubbings(structure)), list(_pushing(structure))
    rubs = any(rubbing.forward or rubbing.backward for _, rubbing in rubbings)
    if not (arm.any() or viscous.any() or rubs):
        return None
    contacts = [contact for contact, _ in rubbings] + pushing
    none = np.zeros(len(contacts))
    turns = [
        *structure.turns,
        *[True] * len(structure.loops),
        *(structure.axes[structure.relations[c.relation].joint].turns for c in contacts),
    ]
    return FrictionLaw(
        arm=np.array([*arm, *(rubbing.forward for _, rubbing in rubbings), *[1.0] * len(pushing)]),
        backward=np.array([*arm, *(rubbing.backward for _, rubbing in rubbings), *map(_push_backward, pushing)]),
        viscous=np.concatenate([viscous, none]),
        preload=np.concatenate([preload, none]),
        turns=np.array(turns),
        pushes=np.arange(len(turns)) >= len(turns) - len(pushing),
        size=structure.size,
    )


def inverse_dynamics(engine: Engine, states: ClosedStates, conditions: AppliedConditions, bearings: bool = True) -> Wrenches:
    """`Engine.inverse_dynamics` with what acts in contacts; forces, moments and power lost of the contacts come behind the bearings."""
    structure, law = engine.structure, conditions.law
    if not structure.contacts:
        return engine.inverse_dynamics(states, conditions, bearings)
    placed = _Placed(engine, states, conditions.compliance)
    rows = np.zeros((placed.bearings + placed.rows, states.v.shape[1]))
    speeds, efforts = rows, rows
    if law is not None:
        own = engine.bearing_loads(states, conditions.under((), None), states.v).speed
        speeds = law.moving(np.concatenate([own, placed.speeds(states.v)]))

        def pressing(efforts: Array) -> Array:
            pressed, by_effort = placed.bearing_loads(conditions, efforts, states.v)
            return np.concatenate([np.sqrt(np.einsum("bni,bni->bn", pressed.radial, pressed.radial)), by_effort[placed.owners]])

        efforts = law.efforts(speeds, pressing, lambda state: structure.place(states.position[:, state]))
    acting = conditions.under(placed.rubbing(efforts), efforts[: placed.bearings])
    result = engine.inverse_dynamics(states, acting, bearings=False)
    friction = np.concatenate([0.0 - efforts[: placed.bearings] * speeds[: placed.bearings], placed.lost(efforts, speeds)])
    if not bearings:
        return Wrenches(result.torque, result.relations, friction, result.force, result.moment)
    by_effort = placed.efforts(acting, result.relations)
    by_size = np.abs(by_effort) if law is None else placed.pushes(efforts)
    pushed = placed.loads(by_effort, by_size)
    wrenches = placed.settle(engine.inverse_dynamics(states, acting.under(pushed, acting.friction), bearings=True))
    wrenches.relations[placed.relations] += by_effort
    force, moment = placed.of_first_on_second(by_effort, by_size, efforts)
    return Wrenches(
        torque=result.torque,
        relations=wrenches.relations,
        friction=friction,
        force=np.concatenate([wrenches.force, force]),
        moment=np.concatenate([wrenches.moment, moment]),
        on_frame=tuple(load for load in (*acting.loads[len(conditions.loads) :], *pushed) if load.joint == 0),
    )


def bearing_loads(engine: Engine, states: ClosedStates, conditions: AppliedConditions, rates: Array) -> BearingLoads:
    """`Engine.bearing_loads` with what acts in contacts; ``conditions.friction`` and the result have the rows of contacts, too."""
    if not engine.structure.contacts or conditions.friction is None:
        return engine.bearing_loads(states, conditions, rates)
    placed = _Placed(engine, states, conditions.compliance)
    pressed, by_effort = placed.bearing_loads(conditions, conditions.friction, rates)
    radial = np.zeros((placed.rows, *pressed.radial.shape[1:]))
    radial[:, :, 0] = by_effort[placed.owners]
    speed = np.concatenate([pressed.speed, placed.speeds(rates)])
    return BearingLoads(speed, np.concatenate([pressed.radial, radial]), pressed.relations)


def indeterminate(engine: Engine, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """`Engine.indeterminate` with the contacts behind the bearings, and with what their idle efforts do to the bearings."""
    marks, relations = engine.indeterminate(position, axes)
    contacts, still = engine.structure.contacts, np.zeros_like(position)
    marks = np.concatenate([marks, np.zeros((len(contacts), 6), dtype=bool)])
    if not relations[[contact.relation for contact in contacts]].any():
        return marks, relations
    placed = _Placed(engine, ClosedStates(position, still, still), None)
    tolerance, ways = engine.structure.rank_tolerance, placed.ways
    residuals = ways.relations[:, placed.relations].transpose(2, 1, 0)
    balanced = np.eye(len(ways.relations)) - np.linalg.pinv(residuals, rcond=tolerance) @ residuals  # (n, ways, idle)
    unrubbed, idle = np.zeros((placed.bearings + placed.rows, len(position[0]))), len(ways.relations) - len(contacts)
    in_contacts = [placed.of_first_on_second(single, single, unrubbed) for single in placed.singles()]
    for place, vectors, unit in ((0, ways.force, 1.0), (3, ways.moment, engine.structure.size)):
        own = np.zeros((len(vectors), len(contacts), *vectors.shape[2:]))
        own[idle:] = [each[place // 3] for each in in_contacts]
        reached = np.einsum("nkc,kbni,ai->cbna", balanced, np.concatenate([vectors, own], axis=1), axes)
        marks[:, place : place + 3] |= np.abs(reached).max(axis=(0, 2)) > 1e2 * tolerance * unit
    return marks, relations


def _rubbings(structure: Structure) -> Iterator[tuple[Contact, Rubbing]]:
    return ((contact, rubbing) for contact in structure.contacts for rubbing in contact.rubbing)


def _pushing(structure: Structure) -> Iterator[Contact]:
    return (contact for contact in structure.contacts if contact.unit.push.any())


def _push_backward(contact: Contact) -> float:
    """Share of the push where the second body drives."""
    sizes = [np.linalg.norm(rubbing.push_backward) for rubbing in contact.rubbing if rubbing.push_backward is not None]
    return float(sizes[0] / np.linalg.norm(contact.unit.push)) if sizes else 1.0


class _Placed:
    """The contacts of a linkage in n states. Efforts of contacts are (contacts, n), of friction (bearings + rows, n)."""

    def __init__(self, engine: Engine, states: ClosedStates, compliance: Array | None) -> None:
        self.engine, self.states, self.compliance = engine, states, compliance
        self.structure, self.contacts = engine.structure, engine.structure.contacts
        self.relations = [contact.relation for contact in self.contacts]
        self.units = [contact.wrench(states.position) for contact in self.contacts]
        self.bearings = len(states.v) + len(self.structure.loops)
        self.rubbings = list(_rubbings(self.structure))
        self.pushing = [self.contacts.index(contact) for contact in _pushing(self.structure)]
        self.owners = [self.contacts.index(contact) for contact, _ in self.rubbings] + self.pushing
        self.rows = len(self.owners)
        n, self.bodies = states.v.shape[1], range(1, len(states.v) + 1)
        motion = engine.body_motion(states, self.bodies, accelerations=False)
        self.rotation = {0: np.broadcast_to(np.eye(3), (n, 3, 3))} | dict(
            zip(self.bodies, motion.rotation.transpose(0, 3, 1, 2), strict=True)
        )
        self.origin = {0: np.zeros((n, 3))} | dict(zip(self.bodies, motion.origin.transpose(0, 2, 1), strict=True))

    def loads(self, by_effort: Array, by_size: Array) -> list[AppliedForce]:
        """Wrenches of contacts on their bodies, from their efforts and the sizes (contacts, n) of the forces that push apart."""
        return self._on_bodies(
            (contact, body, unit.point, unit.force * effort + unit.push * size, unit.couple * effort)
            for contact, own, effort, size in zip(self.contacts, self.units, by_effort[..., None], by_size[..., None], strict=True)
            for body, unit in contact.actions(own)
        )

    def pushes(self, efforts: Array) -> Array:
        """Sizes (contacts, n) of what pushes apart, from its rows of the efforts of friction."""
        sizes = np.zeros((len(self.contacts), efforts.shape[1]))
        sizes[self.pushing] = efforts[self.bearings + len(self.rubbings) :]
        return sizes

    def singles(self) -> Iterator[Array]:
        """For every contact an effort (contacts, n) of this contact only, as large as a multiplier of 1."""
        for k, relation in enumerate(self.relations):
            single = np.zeros((len(self.contacts), len(self.origin[0])))
            single[k] = self.structure.relation_units[relation]
            yield single

    def rubbing(self, efforts: Array) -> list[AppliedForce]:
        """What friction in contacts does to bodies."""
        return self._on_bodies(
            (contact, body, self.units[owner].point, rubbing.force * signed, rubbing.couple * signed)
            for (contact, rubbing), owner, effort in zip(self.rubbings, self.owners, efforts[self.bearings :, :, None], strict=False)
            for body, signed in ((rubbing.second, effort), (rubbing.first, -effort))
        )

    def _on_bodies(self, wrenches: Iterator[tuple[Contact, int, Array, Array, Array]]) -> list[AppliedForce]:
        """Loads of wrenches in the axes of carriers, one a body."""
        sums: dict[int, AppliedForce] = {}
        for contact, body, point, force, couple in wrenches:
            place, vector, moment = self._place(contact, point), self._turned(contact, force), self._turned(contact, couple)
            moment = moment + np.cross(place - self.origin[body], vector)
            before = sums.get(body)
            if before is not None and before.moment is not None:
                vector, moment = vector + before.force, moment + before.moment
            sums[body] = AppliedForce(body, ORIGIN, vector, moment)
        return list(sums.values())

    def _turned(self, contact: Contact, vectors: Array) -> Array:
        """Vectors (3,) or (n, 3) in the axes of the carrier as those (n, 3) of the world."""
        return np.asarray((self.rotation[contact.carrier] @ vectors[..., None])[..., 0])

    def _place(self, contact: Contact, point: Array) -> Array:
        return np.asarray(self._turned(contact, point) + self.origin[contact.carrier])

    def bearing_loads(self, conditions: AppliedConditions, efforts: Array, rates: Array) -> tuple[BearingLoads, Array]:
        """`Engine.bearing_loads` with the wrenches of contacts, and the efforts (contacts, n) of these."""
        acting = conditions.under(self.rubbing(efforts), efforts[: self.bearings])
        by_effort = self.efforts(acting)
        acting = acting.under(self.loads(by_effort, self.pushes(efforts)), acting.friction)
        pressed = self.engine.bearing_loads(self.states, acting, rates)
        if self.idle is not None:
            force = self.settle(self.engine.inverse_dynamics(self.states, acting, bearings=True)).force
            pressed = pressed._replace(radial=np.cross(force, self._directions(rates)))
        return pressed, by_effort

    def _directions(self, rates: Array) -> Array:
        """Axes (bearings, n, 3) about or along which the bearings move at joint rates (nv, n), in the world; zero of loops at rest."""
        spin = self.engine.body_motion(replace(self.states, v=rates), self.bodies, accelerations=False).spin.transpose(0, 2, 1)
        spins = np.concatenate([np.zeros_like(spin[:1]), spin])
        turning = [spins[loop.joint2] - spins[loop.joint1] for loop in self.structure.loops]
        sizes = [np.linalg.norm(each, axis=1, keepdims=True) for each in turning]
        return np.array([*self.axes, *(each / np.where(size > 0, size, 1.0) for each, size in zip(turning, sizes, strict=True))])

    @cached_property
    def axes(self) -> Array:
        """(nv, n, 3) axes of the joints in the world."""
        return np.array([self.rotation[body] @ self.structure.axes[body - 1].direction for body in self.bodies])

    def speeds(self, rates: Array) -> Array:
        """Speeds (rows, n) with which contacts rub at joint rates (nv, n)."""
        speeds = np.zeros((self.rows, rates.shape[1]))
        if not self.rubbings:
            return speeds
        motion = self.engine.body_motion(replace(self.states, v=rates), self.bodies, accelerations=False)
        moving = dict(zip(self.bodies, zip(motion.velocity.transpose(0, 2, 1), motion.spin.transpose(0, 2, 1), strict=True), strict=True))
        for row, ((contact, rubbing), owner) in enumerate(zip(self.rubbings, self.owners, strict=False)):
            force, couple = self._turned(contact, rubbing.force), self._turned(contact, rubbing.couple)
            place = self._place(contact, self.units[owner].point)
            for body, sign in ((rubbing.second, 1.0), (rubbing.first, -1.0)):
                if body:
                    velocity, spin = moving[body]
                    turning = couple + np.cross(place - self.origin[body], force)
                    speeds[row] += sign * (np.einsum("ni,ni->n", force, velocity) + np.einsum("ni,ni->n", turning, spin))
            if rubbing.push_backward is not None:
                speeds[len(self.rubbings) + self.pushing.index(owner)] = speeds[row]
        return speeds

    def lost(self, efforts: Array, speeds: Array) -> Array:
        """Power lost (contacts, n) in the contacts."""
        lost = np.zeros((len(self.contacts), speeds.shape[1]))
        for row, owner in enumerate(self.owners[: len(self.rubbings)], self.bearings):
            lost[owner] -= efforts[row] * speeds[row]
        return lost

    def of_first_on_second(self, by_effort: Array, by_size: Array, efforts: Array) -> tuple[Array, Array]:
        """Forces and moments (contacts, n, 3) of the first on the second bodies where they touch, those of planets of a single one."""
        n, rows = by_effort.shape[1], efforts[self.bearings :, :, None]
        force, moment = np.zeros((2, len(self.contacts), n, 3))
        for k, (contact, unit, effort) in enumerate(zip(self.contacts, self.units, by_effort[..., None], strict=True)):
            own, couple = unit.force * effort + unit.push * by_size[k, :, None], unit.couple * effort
            for (_, rubbing), owner, rubbed in zip(self.rubbings, self.owners, rows, strict=False):
                if owner == k and {rubbing.first, rubbing.second} == {contact.first, contact.second}:
                    sign = 1.0 if rubbing.second == contact.second else -1.0
                    own, couple = own + sign * rubbing.force * rubbed, couple + sign * rubbing.couple * rubbed
            force[k], moment[k] = self._turned(contact, own / contact.count), self._turned(contact, couple / contact.count)
        return force, moment

    # ---------------------------------------------------------------------------------------------------------- redundant equations

    @cached_property
    def idle(self) -> Idle | None:
        """The idle forces of the engine, with efforts in joints; None if they do not involve the contacts."""
        if not self.engine.redundant(self.states.position[:, 0]):
            return None
        idle = self.engine.idle(self.states)
        reached = np.abs(idle.relations[:, self.relations]).max(initial=0.0) > self.structure.rank_tolerance
        return idle if reached else None

    @cached_property
    def ways(self) -> Idle:
        """The idle forces, and how the bearings and the efforts in joints balance an effort of every contact, one of `singles`."""
        idle, nothing = self.idle or self.engine.idle(self.states), AppliedConditions([], None, self.compliance)
        start = self.engine.inverse_dynamics(self.states, nothing, bearings=True)
        balances = [self.engine.inverse_dynamics(self.states, nothing.under(self.loads(k, 0.0 * k), None), True) for k in self.singles()]
        units = self.structure.relation_units[:, None]
        return Idle(
            np.concatenate([idle.relations / units, [(each.relations - start.relations) / units for each in balances]]),
            np.concatenate([idle.force, [each.force - start.force for each in balances]]),
            np.concatenate([idle.moment, [each.moment - start.moment for each in balances]]),
        )

    def efforts(self, acting: AppliedConditions, relations: Array | None = None) -> Array:
        """Efforts (contacts, n) of the contacts.

        If redundant equations leave them open, the remaining efforts in joints become zero, and what is still open is shared among the
        bearings as in `engines.sharing`.

        Args:
            acting: what acts besides contacts, without a law.
            relations: (relations, n) efforts of relations without contacts, where they are known.
        """
        if self.idle is None:
            if relations is None:
                relations = self.engine.inverse_dynamics(self.states, acting, bearings=False).relations
            return np.asarray(relations[self.relations])
        shares = self._shares(self.ways, self.engine.inverse_dynamics(self.states, acting, bearings=True))
        return np.asarray(self.structure.relation_units[self.relations][:, None] * shares[-len(self.contacts) :])

    def settle(self, wrenches: Wrenches) -> Wrenches:
        """The wrenches with the idle forces for which contacts leave no efforts in joints."""
        if self.idle is None:
            return wrenches
        units, count = self.structure.relation_units[:, None], len(self.idle.relations)
        idle = Idle(*(each[:count] for each in self.ways))
        shares = self._shares(idle, wrenches)
        more = (np.einsum("kn,k...n->...n", shares, np.moveaxis(each, 2, -1)) for each in (units * idle.relations, idle.force, idle.moment))
        relations, force, moment = more
        return replace(
            wrenches,
            relations=wrenches.relations + relations,
            force=wrenches.force + np.moveaxis(force, -1, 1),
            moment=wrenches.moment + np.moveaxis(moment, -1, 1),
        )

    def _shares(self, ways: Idle, start: Wrenches) -> Array:
        """Multiples (k, n) of ways by which bearings share forces, and contacts leave no efforts in joints; ``start``: without them."""
        n = len(self.origin[0])
        residuals, rest = np.zeros((len(ways.relations), len(self.contacts), 3, n)), np.zeros((len(self.contacts), 3, n))
        residuals[:, :, 0] = ways.relations[:, self.relations]
        rest[:, 0] = (start.relations / self.structure.relation_units[:, None])[self.relations]
        forces, force = self._across(ways.force, False), self._across(start.force[None], False)[0]
        objectives, starts = [(residuals, 1.0)], [rest]
        if self.compliance is not None:
            weights = np.sqrt(self.compliance)[:, None, None]
            objectives.append((weights * forces, float(weights.max())))
            starts.append(weights * force)
        objectives += [(forces, 1.0), (self._across(ways.moment, True), self.structure.size)]
        starts += [force, self._across(start.moment[None], True)[0]]
        unit = np.broadcast_to(np.eye(len(ways.relations))[:, :, None], (len(ways.relations), len(ways.relations), n))
        return share(slice(None), unit, objectives, self.structure.rank_tolerance).added(starts)

    def _across(self, vectors: Array, turning: bool) -> Array:
        """Vectors (k, bearings, n, 3) as (k, bearings, 3, n), without their components along the axes of joints that turn, or slide."""
        joints = np.flatnonzero(self.structure.turns == turning)
        result = vectors.copy()
        result[:, joints] -= np.einsum("kjni,jni->kjn", vectors[:, joints], self.axes[joints])[..., None] * self.axes[joints]
        return np.asarray(result.transpose(0, 1, 3, 2))
