"""The ZXN2-3000(B) six-bar press written out by hand with NumPy: a peer of pinpress and an independent solution for the tests.

A good engineer who writes a script for this one press eliminates the unknowns by hand: both loops are closed as triangles, without
iteration; velocities and accelerations follow by Cramer's rule; then the driving torque and thirteen pin force components, body by body,
from the slide to the crank; all crank angles at once. No code is shared with pinpress.

Source: Kong et al. 2025, Forging and Stamping Technology 50(2), 195-203; the moments of inertia are inferred (the paper prints none).

Frame: the paper's picture plane, x right, y up, origin at the rocker pivot D; in pinpress's world the same x, and z for y.
Angles are counter-clockwise from +x: theta1 of A->B, theta2 of B->C, theta3 of D->C, theta4 of E->F. SI units.
F_ij is the force of body i on body j: 0 frame, 1 crank, 2 coupler, 3 rocker, 4 rod, 5 slide. tau acts on the crank, counter-clockwise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

L1, L2, L31, L32, L4 = 0.143, 1.243, 0.375, 0.480, 0.480  # AB, BC, DC, DE, EF [m]
AX, AY = 1.250, -0.200  # crank pivot A seen from D [m]
COS, SIN = np.cos(0.75 * np.pi), np.sin(0.75 * np.pi)  # E lies this angle clockwise of C, seen from D
GRAVITY = 9.81  # [m/s2], along -y

M2, M3, M5 = 290.57, 2871.07, 7073.87  # coupler, rocker, slide [kg]
J2, J3 = 37.4, 183.0  # about the centres of mass [kg m2]
P2 = 0.8456  # centre of mass of the coupler from B along BC [m]
P3, Q3 = -0.0086, -0.0038  # centre of mass of the rocker from D: along DC, and a quarter turn counter-clockwise of it [m]
# The bodies that balancing changes: (mass [kg], centre of mass from A along AB or from E along EF [m], inertia about it [kg m2]).
CRANK = {False: (1009.16, 0.0567, 31.5), True: (1614.656, -0.0181, 46.56)}
ROD = {False: (277.68, 0.2400, 5.33), True: (333.216, 0.1924, 9.105)}

UNKNOWNS = ("tau", "F01x", "F01y", "F21x", "F21y", "F23x", "F23y", "F03x", "F03y", "F43x", "F43y", "F54x", "F54y", "F05x")


class Vectors(NamedTuple):
    """Vectors along the links, x and y, each of shape (n,) [m].

    Attributes:
        b1x: A to B, x.
        b1y: A to B, y.
        b2x: B to C, x.
        b2y: B to C, y.
        b3x: D to C, x.
        b3y: D to C, y.
        e3x: D to E, x.
        e3y: D to E, y.
        b4x: E to F, x.
        b4y: E to F, y.
        slide: height of F above D.
        across: cross product of BC and DC [m2].
    """

    b1x: Array
    b1y: Array
    b2x: Array
    b2y: Array
    b3x: Array
    b3y: Array
    e3x: Array
    e3y: Array
    b4x: Array
    b4y: Array
    slide: Array
    across: Array


def six_bar(theta1: ArrayLike, omega1: ArrayLike, alpha1: ArrayLike, balanced: bool = False) -> dict[str, Array]:
    """Motion, driving torque and pin forces of the press at given crank angles.

    Args:
        theta1: crank angle, shape (n,), 0 along +x, counter-clockwise [rad].
        omega1: crank speed, shape (n,) or scalar [rad/s].
        alpha1: crank acceleration, shape (n,) or scalar [rad/s2].
        balanced: whether the paper's counterweights are on the crank and on the rod.

    Returns:
        Arrays of shape (n,): theta2..theta4 [rad], omega2..omega4 [rad/s], alpha2..alpha4 [rad/s2]; slide_position of F above D [m],
        slide_velocity [m/s], slide_acceleration [m/s2], positive upwards; tau [N m] and the force components named in `UNKNOWNS` [N].

    Raises:
        ArithmeticError: a loop cannot be closed: coupler and rocker do not reach each other, or the rod does not reach the slide's line.
    """
    theta1 = np.atleast_1d(np.asarray(theta1, dtype=float))
    omega1 = np.broadcast_to(np.asarray(omega1, dtype=float), theta1.size)
    alpha1 = np.broadcast_to(np.asarray(alpha1, dtype=float), theta1.size)
    links = closure(theta1)
    angles = {
        "theta2": np.arctan2(links.b2y, links.b2x),
        "theta3": np.arctan2(links.b3y, links.b3x),
        "theta4": np.arctan2(links.b4y, links.b4x),
    }
    rates, squares = _rates(links, omega1, alpha1)
    forces = _forces(links, rates, squares, alpha1, balanced)
    return forces | angles | {"slide_position": links.slide} | rates


def closure(theta1: Array) -> Vectors:
    """Close both loops at every crank angle (n,) at once, each as a triangle with two known sides."""
    b1x, b1y = L1 * np.cos(theta1), L1 * np.sin(theta1)
    bx, by = AX + b1x, AY + b1y  # B from D
    square = bx * bx + by * by
    along = 0.5 * (L31 * L31 - L2 * L2 + square) / square  # C = along B + beside (B turned by a quarter)
    beside = L31 * L31 / square - along * along
    with np.errstate(invalid="ignore"):
        beside = np.sqrt(beside)  # the other root is the assembly with the coupler on the other side of the line B-D
        cx, cy = along * bx - beside * by, along * by + beside * bx
        ex, ey = L32 / L31 * (COS * cx + SIN * cy), L32 / L31 * (COS * cy - SIN * cx)
        drop = np.sqrt(L4 * L4 - ex * ex)  # the other root has the slide above E
    if not np.isfinite(drop).all():
        raise ArithmeticError("a loop cannot be closed: the links are too short")
    b2x, b2y = cx - bx, cy - by
    return Vectors(b1x, b1y, b2x, b2y, cx, cy, ex, ey, -ex, -drop, ey - drop, b2x * cy - b2y * cx)


def _rates(links: Vectors, omega1: Array, alpha1: Array) -> tuple[dict[str, Array], tuple[Array, ...]]:
    """Angular speeds and accelerations of coupler, rocker and rod with the motion of the slide, and the squares of the four speeds."""
    b1x, b1y, b2x, b2y, b3x, b3y, e3x, e3y, b4x, b4y, _, across = links
    # omega2 k x BC - omega3 k x DC = right: 2x2, by Cramer's rule; then the slide's line gives omega4, and the slide's speed follows.
    right_x, right_y = omega1 * b1y, -omega1 * b1x
    omega2 = (right_x * b3x + right_y * b3y) / across
    omega3 = (right_x * b2x + right_y * b2y) / across
    omega4 = -omega3 * e3y / b4y
    w1, w2, w3, w4 = omega1**2, omega2**2, omega3**2, omega4**2
    right_x = alpha1 * b1y + w1 * b1x + w2 * b2x - w3 * b3x
    right_y = -alpha1 * b1x + w1 * b1y + w2 * b2y - w3 * b3y
    alpha2 = (right_x * b3x + right_y * b3y) / across
    alpha3 = (right_x * b2x + right_y * b2y) / across
    alpha4 = -(alpha3 * e3y + w3 * e3x + w4 * b4x) / b4y
    velocity = omega3 * e3x + omega4 * b4x
    acceleration = alpha3 * e3x - w3 * e3y + alpha4 * b4x - w4 * b4y
    slide = {"slide_velocity": velocity, "slide_acceleration": acceleration}
    rates = {"omega2": omega2, "omega3": omega3, "omega4": omega4, "alpha2": alpha2, "alpha3": alpha3, "alpha4": alpha4}
    return slide | rates, (w1, w2, w3, w4)


def _forces(links: Vectors, rates: dict[str, Array], squares: tuple[Array, ...], alpha1: Array, balanced: bool) -> dict[str, Array]:
    """Driving torque and pin forces, body by body, from the slide to the crank."""
    b1x, b1y, b2x, b2y, b3x, b3y, e3x, e3y, b4x, b4y, _, across = links
    alpha2, alpha3, alpha4 = rates["alpha2"], rates["alpha3"], rates["alpha4"]
    w1, w2, w3, w4 = squares
    m1, p1, j1 = CRANK[balanced]
    m4, p4, j4 = ROD[balanced]
    f1, f2, f4 = p1 / L1, P2 / L2, p4 / L4  # centres of mass as parts of AB, BC, EF
    g3x, g3y = (P3 * b3x - Q3 * b3y) / L31, (P3 * b3y + Q3 * b3x) / L31  # centre of mass of the rocker from D
    # Accelerations of B and E, then of the centres of mass; r x (alpha, omega): a = alpha k x r - omega^2 r.
    abx, aby = -alpha1 * b1y - w1 * b1x, alpha1 * b1x - w1 * b1y
    aex, aey = -alpha3 * e3y - w3 * e3x, alpha3 * e3x - w3 * e3y
    # Of each body mass times acceleration and weight, (nx, ny), and the moment k of both and of its inertia about A, B, D, E.
    n1x, n1y = m1 * f1 * abx, m1 * (f1 * aby + GRAVITY)
    n2x, n2y = M2 * (abx + f2 * (-alpha2 * b2y - w2 * b2x)), M2 * (aby + f2 * (alpha2 * b2x - w2 * b2y) + GRAVITY)
    n3x, n3y = M3 * (-alpha3 * g3y - w3 * g3x), M3 * (alpha3 * g3x - w3 * g3y + GRAVITY)
    n4x, n4y = m4 * (aex + f4 * (-alpha4 * b4y - w4 * b4x)), m4 * (aey + f4 * (alpha4 * b4x - w4 * b4y) + GRAVITY)
    k1 = f1 * (b1x * n1y - b1y * n1x) + j1 * alpha1
    k2 = f2 * (b2x * n2y - b2y * n2x) + J2 * alpha2
    k3 = g3x * n3y - g3y * n3x + J3 * alpha3
    k4 = f4 * (b4x * n4y - b4y * n4x) + j4 * alpha4

    # The slide, then moments of the rod about E; coupler and rocker together, moments about B and D; then the crank.
    f54y = -M5 * (rates["slide_acceleration"] + GRAVITY)
    f54x = (b4x * f54y - k4) / b4y
    f43x, f43y = f54x - n4x, f54y - n4y
    k3 = k3 - (e3x * f43y - e3y * f43x)
    f23x, f23y = -(k2 * b3x + k3 * b2x) / across, -(k2 * b3y + k3 * b2y) / across
    f21x, f21y = -f23x - n2x, -f23y - n2y
    f03x, f03y = n3x - f23x - f43x, n3y - f23y - f43y
    f01x, f01y = n1x - f21x, n1y - f21y
    tau = k1 - b1x * f21y + b1y * f21x
    forces = (tau, f01x, f01y, f21x, f21y, f23x, f23y, f03x, f03y, f43x, f43y, f54x, f54y, f54x)
    return dict(zip(UNKNOWNS, forces, strict=True))


def world_forces(result: dict[str, Array]) -> dict[str, Array]:
    """Pin and guide forces by the URDF's joint names.

    Args:
        result: result of `six_bar`.

    Returns:
        For each of A, B, C, D, E, F and slide_guide the force of the joint's parent (a loop's link1) on its child (link2), in world
        axes x, y, z with z up, shape (n, 3) [N].
    """
    n = result["tau"].size
    out = {}
    for name, force, sign in (
        ("A", "F01", 1.0),
        ("B", "F21", -1.0),
        ("C", "F23", 1.0),
        ("D", "F03", 1.0),
        ("E", "F43", -1.0),
        ("F", "F54", -1.0),
    ):
        out[name] = np.zeros((n, 3))
        out[name][:, 0], out[name][:, 2] = sign * result[force + "x"], sign * result[force + "y"]
    out["slide_guide"] = np.zeros((n, 3))
    out["slide_guide"][:, 0] = result["F05x"]
    return out
