"""Forces in the loops and gear pairs of a planar linkage: they balance the efforts of the passive joints.

The blocks are worked through in the reverse of the order in which they close. The force p of a pin does the work Re(conj(c) p) on a unit
rate of the joint with the column c in the loop Jacobian. The two joints of a dyad, with columns a and b, need the efforts s and t:

    Re(conj(a) p) = s,  Re(conj(b) p) = t    have the solution    p = i (t a - s b) / D,   D = Im(conj(a) b)

The inverse of its `kinematics.DyadFactor`, conj(b) / D and -conj(a) / D, gives conj(p) as i times their sum, times s and t. What the
force of its pin asks of a joint of an earlier block are s and t times the dyad's transfer from that joint.

The redundant equations of a block leave idle forces open, which earlier blocks balance. `engines.forces` says which multiples of them are
added.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..forces import Objective, lexicographic_least_squares
from .kinematics import DyadFactor, Factor
from .model import Block, Plane


class Statics(NamedTuple):
    """The equations at n configurations, ready to be balanced.

    Attributes:
        plane: constants of the linkage.
        rows: rows of `Plane.closure`.
        factors: what `kinematics.factored` made of them.
        subtree_force: (nv, n) forces of the joints of the open tree [N].
        minus_incidence: (nv, nl) see `Bodies`: by what pin forces relieve the joints.
        idle: for every idle force the forces of the pins (nl, n) and the multipliers of the couplings (nc, n).
        responses: for every idle force what it adds to all bearings (bearings, n).
        compliance: (bearings,) see `compliances`; None where there is none, or no idle force.
        slides: directions (n,) of the coupled prismatic joints, by joint; empty where there is no idle force.
    """

    plane: Plane
    rows: ComplexArray
    factors: Sequence[Factor]
    subtree_force: ComplexArray
    minus_incidence: Array
    idle: list[tuple[ComplexArray, Array]]
    responses: list[ComplexArray]
    compliance: Array | None
    slides: dict[int, ComplexArray]


def build(
    plane: Plane,
    rows: ComplexArray,
    factors: Sequence[Factor],
    subtree_force: ComplexArray,
    minus_incidence: Array,
    basis: ComplexArray,
    compliance: Array | None,
) -> Statics:
    """The equations at configurations with this ``basis`` (nb, n); the other arguments are attributes of `Statics`."""
    if not plane.redundant:
        return Statics(plane, rows, factors, subtree_force, minus_incidence, [], [], None, {})
    idle = list(_idle(plane, rows, factors))
    responses = [np.concatenate([carried(minus_incidence, pins), pins]) for pins, _ in idle]
    coupled = set().union(*plane.coupling_rows)
    slides = {j: product(plane.directions[[k]], basis)[0] for k, j in enumerate(plane.prismatic) if j in coupled}
    return Statics(plane, rows, factors, subtree_force, minus_incidence, idle, responses, compliance, slides)


def balance(statics: Statics, joint_efforts: Array, coupling_multipliers: Array, bearings: ComplexArray) -> None:
    """Find the forces that balance the joints.

    Args:
        statics: the equations.
        joint_efforts: (nv, n) efforts that loops and couplings have to supply; overwritten, the driver's row then holds the driving torque.
        coupling_multipliers: (nc, n) to be filled in.
        bearings: (bearings, n) forces of all bearings to be filled in, joints first [N].
    """
    count = len(statics.subtree_force)
    pins = bearings[count:]
    transmit(statics.plane, statics.rows, statics.factors, joint_efforts, pins, coupling_multipliers)
    np.add(carried(statics.minus_incidence, pins), statics.subtree_force, out=bearings[:count])
    if statics.idle:
        for share, (_, idle_couplings), response in zip(_shares(statics, bearings), statics.idle, statics.responses, strict=True):
            bearings += share * response
            coupling_multipliers += share * idle_couplings


def carried(rows: Array, pins: ComplexArray) -> ComplexArray:
    """Real rows (k, nl), such as those of `Bodies.minus_incidence`, times the forces of the pins (nl, n)."""
    return np.asarray(product(rows, pins.view(float)).view(complex))  # a product of real numbers takes a third of the time


def transmit(
    plane: Plane, rows: ComplexArray, factors: Sequence[Factor], joint_efforts: Array, pins: ComplexArray, coupling_multipliers: Array
) -> None:
    """Fill in the forces of the pins (nl, n) and the multipliers of the couplings (nc, n), without the forces of the joints and without any
    idle force. ``rows`` and ``factors`` as in `Statics`, ``joint_efforts`` as in `balance`."""
    _balance(plane, rows, factors, joint_efforts, pins, coupling_multipliers, len(plane.blocks))


def torques(plane: Plane, multipliers: Array) -> None:
    """Turn multipliers of the couplings (nc, n) into torques on their followers."""
    if len(multipliers):
        multipliers *= np.array([gear[j] for gear, j in zip(plane.coupling_rows, plane.followers, strict=True)])[:, None]


def _balance(
    plane: Plane,
    rows: ComplexArray,
    factors: Sequence[Factor],
    joint_efforts: Array,
    pins: ComplexArray,
    coupling_multipliers: Array,
    blocks: int,
) -> None:
    """Fill in the forces of the first ``blocks`` blocks, in reverse order."""
    for factor in reversed(factors[:blocks]):
        if isinstance(factor, DyadFactor):
            efforts, pin = joint_efforts[factor.pair], pins[factor.loop]
            parts = factor.inverse * efforts
            np.add(parts[0], parts[1], out=pin)
            pin *= 1j
            np.conjugate(pin, out=pin)
            for joint, transfer in factor.transfers:
                _ask(joint_efforts[joint], transfer * efforts)
            if factor.driven is not None:
                _ask(joint_efforts[plane.driver], factor.driven * efforts)
            continue
        block, matrix = factor
        if block.kind == "lever":
            np.conjugate(matrix * -joint_efforts[block.joints[0]], out=pins[block.loops[0]])
        elif block.kind == "gear":
            coupling_multipliers[block.couplings[0]] = joint_efforts[block.joints[0]] / matrix
        elif block.joints:
            _distribute(block, _dense(matrix, joint_efforts[list(block.joints)].T), pins, coupling_multipliers)
        else:  # all its equations are redundant: its forces are idle ones, which `balance` adds
            pins[list(block.loops)] = 0.0
            coupling_multipliers[list(block.couplings)] = 0.0
        _pass_on(plane, block, rows, pins, coupling_multipliers, joint_efforts)


def _ask(effort: Array, asked: Array) -> None:
    """Add both rows (2, n) of what the force of a dyad's pin asks of a joint to the effort (n,) there."""
    effort += asked[0]
    effort += asked[1]


def _dense(matrix: Array, effort: Array) -> Array:
    """Multipliers (n, equations) that supply efforts (n, joints); those of least norm where there are more equations than joints."""
    if matrix.shape[1] == matrix.shape[2]:
        return np.asarray(np.linalg.solve(matrix.transpose(0, 2, 1), effort[:, :, None])[:, :, 0])
    orthogonal, triangle = np.linalg.qr(matrix)
    return np.asarray((orthogonal @ np.linalg.solve(triangle.transpose(0, 2, 1), effort[:, :, None]))[:, :, 0])


def _distribute(block: Block, multipliers: Array, pins: ComplexArray, coupling_multipliers: Array) -> None:
    """Write the multipliers (n, equations) of a block to its loops and couplings."""
    loops = 2 * len(block.loops)
    pins[list(block.loops)] = multipliers[:, 0:loops:2].T + 1j * multipliers[:, 1:loops:2].T
    coupling_multipliers[list(block.couplings)] = multipliers[:, loops:].T


def _pass_on(plane: Plane, block: Block, rows: ComplexArray, pins: ComplexArray, coupling_multipliers: Array, joint_efforts: Array) -> None:
    """Subtract what a block's forces do on the driver and on the joints of earlier blocks from the efforts there."""
    for loop, columns in zip(block.loops, block.known, strict=True):
        driven = plane.driven[loop]
        if driven is None and not columns:
            continue
        pin = pins[loop].conj()
        for joint, row in columns:
            joint_efforts[joint] -= (rows[row] * pin).real
        if driven is not None:
            joint_efforts[plane.driver] -= (rows[driven] * pin).real
    for coupling in block.couplings:
        for joint, by in plane.coupling_rows[coupling].items():
            if joint not in block.joints:
                joint_efforts[joint] -= by * coupling_multipliers[coupling]


def _idle(plane: Plane, rows: ComplexArray, factors: Sequence[Factor]) -> Iterator[tuple[ComplexArray, Array]]:
    """`Statics.idle`: for every redundant equation of a block the forces that balance within the block, and those by which the earlier
    blocks balance them."""
    n = rows.shape[1]
    for place, (block, factor) in enumerate(zip(plane.blocks, factors, strict=True)):
        if not block.redundant or isinstance(factor, DyadFactor):  # a dyad has as many equations as joints
            continue
        own = None if block.kind == "lever" else np.linalg.qr(factor.matrix, mode="complete")[0][:, :, len(block.joints) :]
        for k in range(block.redundant):
            pins, coupling_multipliers = np.zeros((len(plane.loop_heights), n), complex), np.zeros((len(plane.offsets), n))
            joint_efforts = np.zeros((len(plane.parents), n))
            if own is None:  # along the lever
                a = rows[block.own[0][0][1]]
                np.multiply(a, 1j / np.abs(a), out=pins[block.loops[0]])
            else:
                _distribute(block, own[:, :, k], pins, coupling_multipliers)
            _pass_on(plane, block, rows, pins, coupling_multipliers, joint_efforts)
            _balance(plane, rows, factors, joint_efforts, pins, coupling_multipliers, place)
            yield pins, coupling_multipliers


def _shares(statics: Statics, bearings: ComplexArray) -> Array:
    """Multiples (k, n) of the idle forces that are added to the forces of all bearings (bearings, n)."""
    parts = np.array([*statics.responses, bearings])
    for joint, direction in statics.slides.items():  # the force of a gear pair along its slide does not count
        parts[:, joint] = 1j * direction * (direction.conj() * parts[:, joint]).imag
    if statics.compliance is not None:
        forces = np.concatenate([parts.real, parts.imag], axis=1).transpose(2, 1, 0)  # (n, 2 bearings, k + 1)
        weights = np.tile(np.sqrt(statics.compliance), 2)[:, None]
        objectives = ((weights * forces, float(weights.max())), (forces, 1.0))
        return np.asarray(lexicographic_least_squares(Objective(parts[:, :, :-1], parts[:, :, -1], scale) for parts, scale in objectives).T)
    return shares_of(parts)


def shares_of(parts: ComplexArray) -> Array:
    """Multiples (k, n) of k idle forces with which the sum of squared bearing forces is least.

    Args:
        parts: (k + 1, bearings, n) what every idle force adds to all bearings, then the forces of the bearings without idle forces [N].
    """
    # The normal equations are good enough: every idle force loads pins of its own, so that their matrix is far from singular.
    count, n = len(parts) - 1, parts.shape[2]
    real, products = parts.view(float), np.empty((count, len(parts), n))
    for k, a in enumerate(real[:count]):
        summed = np.add.reduce(a * real[k:], axis=1)
        products[k, k:] = summed[:, ::2] + summed[:, 1::2]
        products[k + 1 :, k] = products[k, k + 1 : count]
    if count == 1:
        return np.asarray(-products[0, 1] / products[0, 0])[None, :]
    if count == 2:  # by Cramer's rule, which takes a tenth of the time
        (one, mixed, right1), (_, other, right2) = products
        return np.asarray(np.array([mixed * right2 - other * right1, mixed * right1 - one * right2]) / (one * other - mixed * mixed))
    return np.asarray(-np.linalg.solve(products[:, :count].transpose(2, 0, 1), products[:, count].T[:, :, None])[:, :, 0].T)
