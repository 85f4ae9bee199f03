"""Two linkages in space written out by hand with NumPy, all crank angles at once: the template `rssp`, a crank with a ball-ended rod and a
slide, and `bricard.urdf`, six pins in a ring. Each is closed in closed form; nothing is shared with pinpress.

World axes x, y, z with z up, SI units, constant crank speed. Forces are those of parent on child, as in the files.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRAVITY = np.array([0.0, 0.0, -9.81])  # [m/s2]
X, Y, Z = np.eye(3)

# ------------------------------------------------------------------------------------------------------------- crank, ball-ended rod, slide

PIN = np.array([0.06, -0.08, 0.0])  # B on the crank, which turns about x through the origin [m]
SLIDE = np.array([0.15, 0.03, -0.42])  # S on the slide, which goes along z, as drawn [m]
ROD = SLIDE - PIN
LENGTH = math.sqrt(ROD @ ROD)
CRANK_MASS, ROD_MASS, SLIDE_MASS = 12.0, 6.0, 60.0  # [kg]
CRANK_CENTRE = np.array([0.03, -0.03, 0.0])  # [m]
ROD_INERTIA = np.array(  # about its centre, which is in its middle, as drawn [kg m2]
    [[0.094331, -0.004850999999999999, 0.018522], [-0.004850999999999999, 0.092371, 0.022638], [0.018522, 0.022638, 0.011864000000000012]]
)
FIRST_AXIS = np.array([-0.05198107450593011, 0.9687382067014249, 0.24257834769434053])  # of the cross at B, on the crank as drawn


def ball_rod(angle: Array, speed: float) -> tuple[Array, dict[str, Array]]:
    """Driving torque (n,) [N m] and bearing forces (n, 3) [N] of the template `rssp` at crank angles (n,)."""
    turn = _turned(X, angle)
    pin, first = turn @ PIN, turn @ FIRST_AXIS  # B, and the first axis of the cross
    spin_of_crank = speed * X
    pin_rate, first_rate = np.cross(spin_of_crank, pin), np.cross(spin_of_crank, first)
    pin_second, first_second = np.cross(spin_of_crank, pin_rate), np.cross(spin_of_crank, first_rate)

    # The rod's length gives the slide: rod . rod = LENGTH^2, and twice its derivative.
    rod = SLIDE - pin
    rod[:, 2] = -np.sqrt(LENGTH**2 - rod[:, 0] ** 2 - rod[:, 1] ** 2)
    rod_rate, rod_second = -pin_rate, -pin_second
    rod_rate[:, 2] = -(rod[:, 0] * rod_rate[:, 0] + rod[:, 1] * rod_rate[:, 1]) / rod[:, 2]
    bend = _dot(rod_rate, rod_rate) + rod[:, 0] * rod_second[:, 0] + rod[:, 1] * rod_second[:, 1]
    rod_second[:, 2] = -bend / rod[:, 2]
    slide_acceleration = pin_second[:, 2] + rod_second[:, 2]

    # The cross lets the rod turn about `first` and about an axis of its own square to both: that fixes its spin about its line.
    u, u_rate, u_second = rod / LENGTH, rod_rate / LENGTH, rod_second / LENGTH
    w = np.cross(first, u)
    w_rate = np.cross(first_rate, u) + np.cross(first, u_rate)
    w_second = np.cross(first_second, u) + 2 * np.cross(first_rate, u_rate) + np.cross(first, u_second)
    square, side = _dot(w, w), np.cross(u, w)
    spin = _dot(w_rate, side) / square
    spin_rate = (_dot(w_second, side) + _dot(w_rate, np.cross(u_rate, w)) - 2 * spin * _dot(w, w_rate)) / square
    omega = np.cross(u, u_rate) + spin[:, None] * u
    alpha = np.cross(u, u_second) + spin_rate[:, None] * u + spin[:, None] * u_rate
    second = w / np.sqrt(square)[:, None]

    # Forces: the slide takes what its own motion needs, moments of the rod about B give the rest, then the crank.
    axes = np.stack([second, np.cross(u, second), u], axis=-1)
    drawn = np.cross(FIRST_AXIS, ROD / LENGTH)
    body = axes @ np.stack([drawn, np.cross(ROD / LENGTH, drawn), ROD / LENGTH], axis=-1).T
    inertia = body @ ROD_INERTIA @ body.swapaxes(1, 2)
    push = ROD_MASS * (pin_second + 0.5 * rod_second - GRAVITY)
    moment = _apply(inertia, alpha) + np.cross(omega, _apply(inertia, omega)) + np.cross(0.5 * rod, push)
    normal = np.cross(first, second)  # the cross carries a moment about it
    held = (_dot(moment, u) / _dot(normal, u))[:, None] * normal
    across = np.cross(moment - held, rod) / LENGTH**2
    at_slide = across + ((-SLIDE_MASS * (slide_acceleration - GRAVITY[2]) - across[:, 2]) / u[:, 2])[:, None] * u  # on the rod
    at_pin = push - at_slide  # on the rod
    centre = turn @ CRANK_CENTRE
    on_crank = CRANK_MASS * (np.cross(spin_of_crank, np.cross(spin_of_crank, centre)) - GRAVITY) + at_pin
    torque = -CRANK_MASS * np.cross(centre, GRAVITY)[:, 0] + np.cross(pin, at_pin)[:, 0] + held[:, 0]
    force = {"O": on_crank, "B_cross": at_pin, "B": at_pin, "slide_guide": at_slide * (1.0, 1.0, 0.0), "S": -at_slide}
    return torque, force


# ---------------------------------------------------------------------------------------------------------------------- Bricard's linkage

LINK, TWIST = 0.3, math.pi / 4  # [m, rad]
LINK_MASS, ALONG, ACROSS = 2.959, 0.000592, 0.022491  # [kg, kg m2 about a link's line, about its normals]
MOVING = 5  # links that move


class Link(NamedTuple):
    """A moving link.

    Attributes:
        axis: (n, 3) axis of the pin that hangs it.
        pin: (n, 3) place of that pin [m].
        centre: (n, 3) place of its centre of mass [m].
        velocity: (n, 3) of its centre [m/s].
        push: (n, 3) mass times acceleration of its centre, less its weight [N].
        omega: (n, 3) angular velocity [rad/s].
        moment: (n, 3) of inertia about its centre [N m].
    """

    axis: Array
    pin: Array
    centre: Array
    velocity: Array
    push: Array
    omega: Array
    moment: Array


def bricard(angle: Array, speed: float) -> tuple[Array, dict[str, Array]]:
    """Driving torque (n,) [N m] and bearing forces (n, 3) [N] of `bricard.urdf` at crank angles (n,).

    Mechanics leaves a part of all these forces open: this is the one with the least wrench in J6.
    """
    links, last_axis, last_pin = _chain(angle, speed)
    torque = np.sum([_dot(link.push, link.velocity) + _dot(link.moment, link.omega) for link in links], axis=0) / speed

    # The wrench of the frame on link 5 in J6 has no part about the axis of J6, nor leaves the links beyond J2 to J5 a moment about theirs.
    rows, right = [], []
    for k in range(1, MOVING):
        axis, pin = links[k].axis, links[k].pin
        needed = np.sum([link.moment + np.cross(link.centre - pin, link.push) for link in links[k:]], axis=0)
        rows.append(np.concatenate([np.cross(axis, last_pin - pin), axis], axis=1))
        right.append(_dot(axis, needed))
    rows.append(np.concatenate([np.zeros_like(last_axis), last_axis], axis=1))
    right.append(np.zeros(len(angle)))
    matrix, known = np.stack(rows, axis=1), np.stack(right, axis=1)
    transposed = matrix.swapaxes(1, 2)
    wrench = _apply(transposed, np.linalg.solve(matrix @ transposed, known[..., None])[..., 0])
    last = wrench[:, :3]
    force = {f"J{k + 1}": np.sum([link.push for link in links[k:]], axis=0) - last for k in range(MOVING)}
    return torque, force | {"J6": -last}


def _ring(angle: Array) -> tuple[Array, Array, Array]:
    """Angles of the even pins at those of the odd ones, and their first and second derivatives.

    The ring is closed where a cos(even) + b sin(even) + c = 0 with a, b, c of the odd angles.
    """
    cosine, sine = math.cos(TWIST), math.sin(TWIST)
    co, so = np.cos(angle), np.sin(angle)
    a, b, c = sine**2 + (1 + cosine**2) * co, -2 * cosine * so, cosine**2 + sine**2 * co
    a1, b1, c1 = -(1 + cosine**2) * so, -2 * cosine * co, -(sine**2) * so
    a2, b2, c2 = -(1 + cosine**2) * co, 2 * cosine * so, -(sine**2) * co
    even = np.arctan2(b, a) + np.arccos(-c / np.hypot(a, b))
    ce, se = np.cos(even), np.sin(even)
    by_even = b * ce - a * se
    slope = -(a1 * ce + b1 * se + c1) / by_even
    bend = -(a2 * ce + b2 * se + c2 + 2 * slope * (b1 * ce - a1 * se) - slope**2 * (a * ce + b * se)) / by_even
    return even, slope, bend


def _chain(angle: Array, speed: float) -> tuple[list[Link], Array, Array]:
    """The moving links from the crank on, and axis (n, 3) and place (n, 3) of J6."""
    even, slope, bend = _ring(angle)
    still = np.zeros((len(angle), 3))
    turn, pin = np.broadcast_to(np.eye(3), (len(angle), 3, 3)), still
    omega, alpha, velocity, acceleration = still, still, still, still
    links = []
    for k in range(MOVING):
        odd = k % 2 == 0
        axis = turn[:, :, 2]
        rate = np.full(len(angle), speed) if odd else slope * speed
        spun = np.zeros(len(angle)) if odd else bend * speed**2
        alpha = alpha + spun[:, None] * axis + rate[:, None] * np.cross(omega, axis)
        omega = omega + rate[:, None] * axis
        turn = turn @ _turned(Z, angle if odd else even)
        line = turn[:, :, 0]
        moving, moved = np.cross(omega, line), np.cross(alpha, line) + np.cross(omega, np.cross(omega, line))
        push = LINK_MASS * (acceleration + 0.5 * LINK * moved - GRAVITY)
        momentum = ACROSS * omega + (ALONG - ACROSS) * _dot(line, omega)[:, None] * line
        moment = ACROSS * alpha + (ALONG - ACROSS) * _dot(line, alpha)[:, None] * line + np.cross(omega, momentum)
        links.append(Link(axis, pin, pin + 0.5 * LINK * line, velocity + 0.5 * LINK * moving, push, omega, moment))
        pin, velocity, acceleration = pin + LINK * line, velocity + LINK * moving, acceleration + LINK * moved
        turn = turn @ _turned(X, np.array([TWIST if odd else -TWIST]))
    return links, turn[:, :, 2], pin


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ni,ni->n", a, b))


def _apply(matrix: Array, vector: Array) -> Array:
    return np.asarray(np.einsum("nij,nj->ni", matrix, vector))


def _turned(axis: Array, angle: Array) -> Array:
    """(n, 3, 3) rotations about an axis by angles (n,)."""
    c, s = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.asarray(c * np.eye(3) + s * skew + (1 - c) * np.outer(axis, axis))
