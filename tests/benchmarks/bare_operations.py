"""The operations on arrays of the planar engine, written in one line after the other: what is left of its time without everything else.

From crank angles to the driving torque and all bearing forces of a press that is a chain of dyads, with one slide on the frame, no loads,
no friction and no gears, at constant speed: with the engine's own constants and in its order, but nothing is checked, chosen or kept, and
no motion and no reactions are made. Its time is the least that the engine's way of computing can take with NumPy.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import pinpress as pp

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
PIECE = 8192  # crank angles that are worked through at a time


class Chain:
    """The constants of such a press, as its engine has them."""

    def __init__(self, press: pp.Linkage) -> None:
        self.branch, engine = press.branch, press.engine("plane")
        self.plane, self.bodies = plane, bodies = engine.plane, engine.bodies  # type: ignore[attr-defined]
        assert {block.kind for block in plane.blocks} == {"dyad"}
        assert bodies.in_one_plane
        assert len(plane.prismatic) == 1
        self.inner = self.branch.angles[1:-1].copy()
        self.rotors = slice(1, 1 + len(plane.revolute))
        self.dyads = [(block.loops[0], block.pair, block.known[0], plane.driven[block.loops[0]]) for block in plane.blocks]
        self.slide = plane.prismatic[0]
        self.slide_loop = next(iter(plane.loops_of_joint[self.slide].items()))


class Closed(NamedTuple):
    """What `closed` hands on, with one column for each crank angle."""

    basis: ComplexArray
    inverses: ComplexArray
    transfers: list[tuple[list[tuple[int, Array]], Array | None]]
    first: Array
    second: Array


def inverse_dynamics(chain: Chain, points: int, speed: float) -> tuple[Array, Array]:
    """Driving torques (n,) and forces (3, bearings, n) over one turn at constant speed [rad/s]."""
    angle = np.arange(points, dtype=float) * (2 * np.pi / points)
    if points <= PIECE:
        return _forces(chain, closed(chain, angle), speed)
    torque, force = np.empty(points), np.empty((3, len(chain.plane.parents) + len(chain.plane.loop_heights), points))
    for start in range(0, points, PIECE):
        some = slice(start, start + PIECE)
        torque[some], force[..., some] = _forces(chain, closed(chain, angle[some]), speed)
    return torque, force


def closed(chain: Chain, angle: Array) -> Closed:
    """Closed positions at crank angles (n,) and their influence coefficients."""
    plane, n = chain.plane, len(angle)
    np.minimum.reduce(angle), np.maximum.reduce(angle)
    # joint coordinates from the table of the branch
    interval = chain.inner.searchsorted(angle, "right")
    h = angle - chain.branch.angles.take(interval)
    powers = chain.branch.coefficients.take(interval, 2)
    pairs = powers[1::2]
    pairs *= h
    pairs += powers[::2]
    x = pairs[2]
    h *= h
    x *= h
    x += pairs[1]
    x *= h
    x += pairs[0]
    x[plane.driver] = angle
    # rotors, gaps and columns of the loop Jacobian
    basis = np.empty((1 + len(x), n), complex)
    basis[0] = 1.0
    rotors, angles = basis[chain.rotors], plane.turn.dot(x)
    np.cos(angles, rotors.real)
    np.sin(angles, rotors.imag)
    basis[-1] = x[chain.slide]
    rows = plane.closure.dot(basis)
    gaps = rows[: len(chain.dyads)]
    np.maximum.reduce(np.sqrt(np.maximum.reduce((gaps.conj() * gaps).real, 0)))
    # both columns of every dyad, inverted
    columns = rows.take(plane.dyad_columns, 0)
    inverses = columns.conj()
    inverses *= 1.0 / (inverses[:, ::-1] * columns).imag
    # influence coefficients, dyad by dyad
    first, second = np.empty((2, len(x), n))
    first[plane.driver], second[plane.driver] = 1.0, 0.0
    transfers: list[tuple[list[tuple[int, Array]], Array | None]] = []
    for (_, pair, known, driven), inverse in zip(chain.dyads, inverses, strict=True):
        moved = by_driver = None if driven is None else (inverse * rows[driven]).imag
        found = [(joint, (inverse * rows[row]).imag) for joint, row in known]
        for joint, transfer in found:
            moved = transfer * first[joint] if moved is None else moved + transfer * first[joint]
        first[pair] = moved
        transfers.append((found, by_driver))
    spin = plane.turn.dot(first)
    spin *= spin
    opened = plane.centripetal.dot(rotors * spin)
    for (loop, pair, _, _), inverse, (found, _) in zip(chain.dyads, inverses, transfers, strict=True):
        moved = (inverse * opened[loop]).imag
        for joint, transfer in found:
            moved += transfer * second[joint]
        second[pair] = moved
    return Closed(basis, inverses, transfers, first, second)


def _forces(chain: Chain, states: Closed, speed: float) -> tuple[Array, Array]:
    """Driving torques (n,) and forces (3, bearings, n) of all bearings; their moments, too, are computed."""
    plane, bodies, basis = chain.plane, chain.bodies, states.basis
    count, n = len(plane.parents), basis.shape[1]
    v, a = states.first * speed, states.second * (speed * speed)
    np.add.reduce(a, None)
    # forces of the open tree
    acceleration = np.empty(basis.shape, complex)
    acceleration[0] = 1.0
    factor, spin = acceleration[chain.rotors], plane.turn.dot(v)
    np.multiply(spin, -spin, factor.real)
    factor.imag = plane.turn.dot(a)
    factor *= basis[chain.rotors]
    acceleration[-1] = a[chain.slide]
    found = bodies.open_tree.dot(acceleration)
    work, carried, own = found[:count], found[count : 2 * count], found[2 * count]
    arms = bodies.arms.dot(basis[:, :1])
    efforts = plane.turn.T.dot((basis[chain.rotors].conj() * work[:-1]).imag)
    efforts[chain.slide] = work[-1].real
    # forces of the pins, dyad by dyad
    bearings = np.empty((count + len(chain.dyads), n), complex)
    pins = bearings[count:]
    for (loop, pair, _, _), inverse, (known, driven) in zip(chain.dyads[::-1], states.inverses[::-1], states.transfers[::-1], strict=True):
        needed, pin = efforts[pair], pins[loop]
        parts = inverse * needed
        np.add(parts[0], parts[1], pin)
        pin *= 1j
        np.conjugate(pin, pin)
        for joint, transfer in [*known, (plane.driver, driven)]:
            if transfer is not None:
                asked = transfer * needed
                efforts[joint] += asked[0]
                efforts[joint] += asked[1]
    np.add(bodies.minus_incidence.dot(pins.view(float)).view(complex), carried, bearings[:count])
    # vectors in the world
    loop, sign = chain.slide_loop
    turning = (arms[0].conj() * own).imag - sign * (arms[-1].conj() * pins[loop]).imag
    force, moment = np.zeros((3, len(bearings), n)), np.zeros((3, len(bearings), n))
    for axis, along, across, normal in plane.world_components:
        if along:
            np.multiply(bearings.real, along, force[axis])
        if across:
            np.multiply(bearings.imag, across, force[axis])
        if normal:
            np.multiply(turning, normal, moment[axis, chain.slide])
            np.multiply(efforts[plane.driver], normal * plane.sense[plane.driver], moment[axis, plane.driver])
    np.add.reduce(force, None) + np.add.reduce(moment, None)
    return efforts[plane.driver], force
