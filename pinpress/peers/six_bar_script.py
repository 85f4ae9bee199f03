"""The ZXN2-3000(B) six-bar press written out by hand with NumPy: a peer of pinpress and the tests' independent oracle.

What a good engineer writes for this one press: Newton on the four vector-loop equations, velocities and accelerations from
the same 4x4 matrix, then the 14 Newton-Euler equations of the five bodies for the driving torque and thirteen pin force
components; everything batched over the crank angles. No code is shared with pinpress.

Source: Kong et al. 2025, Forging and Stamping Technology 50(2), 195-203; the moments of inertia are inferred (the paper prints none).

Frame: the paper's picture plane, x right, y up, origin at the rocker pivot D; in pinpress's world the same x, and z for y.
Angles are counter-clockwise from +x: theta1 of A->B, theta2 of B->C, theta3 of D->C, theta4 of E->F. SI units.
F_ij is the force of body i on body j: 0 frame, 1 crank, 2 coupler, 3 rocker, 4 rod, 5 slide. tau acts on the crank, counter-clockwise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

L1, L2, L31, L32, L4 = 0.143, 1.243, 0.375, 0.480, 0.480  # AB, BC, DC, DE, EF [m]
AX, AY = 1.250, -0.200  # crank pivot A seen from D [m]
CORNER = 0.75 * np.pi  # E lies this angle clockwise of C, seen from D
GRAVITY = 9.81  # [m/s2], along -y

M2, M3, M5 = 290.57, 2871.07, 7073.87  # coupler, rocker, slide [kg]
J2, J3 = 37.4, 183.0  # about the centres of mass [kg m2]
P2 = 0.8456  # centre of mass of the coupler from B along BC [m]
P3, Q3 = -0.0086, -0.0038  # centre of mass of the rocker from D: along DC, and a quarter turn counter-clockwise of it [m]
# The bodies that balancing changes: (mass [kg], centre of mass from A along AB or from E along EF [m], inertia about it [kg m2]).
CRANK = {False: (1009.16, 0.0567, 31.5), True: (1614.656, -0.0181, 46.56)}
ROD = {False: (277.68, 0.2400, 5.33), True: (333.216, 0.1924, 9.105)}

UNKNOWNS = ("tau", "F01x", "F01y", "F21x", "F21y", "F23x", "F23y", "F03x", "F03y", "F43x", "F43y", "F54x", "F54y", "F05x")
TAU, F01X, F01Y, F21X, F21Y, F23X, F23Y, F03X, F03Y, F43X, F43Y, F54X, F54Y, F05X = range(14)

# Rows 3(i-1), 3(i-1)+1, 3(i-1)+2 are body i's x, y and moment equation; the slide (rows 12, 13) does not turn.
CONSTANT = np.zeros((14, 14))
for _row, _column, _sign in (
    (0, F01X, 1.0), (1, F01Y, 1.0), (0, F21X, 1.0), (1, F21Y, 1.0), (2, TAU, 1.0),
    (3, F21X, -1.0), (4, F21Y, -1.0), (3, F23X, -1.0), (4, F23Y, -1.0),
    (6, F23X, 1.0), (7, F23Y, 1.0), (6, F03X, 1.0), (7, F03Y, 1.0), (6, F43X, 1.0), (7, F43Y, 1.0),
    (9, F43X, -1.0), (10, F43Y, -1.0), (9, F54X, 1.0), (10, F54Y, 1.0),
    (12, F54X, -1.0), (13, F54Y, -1.0), (12, F05X, 1.0),
):  # fmt: skip
    CONSTANT[_row, _column] = _sign


def closure(theta1: Array, tolerance: float = 1e-8, most: int = 12) -> tuple[Array, Array]:
    """Close both loops at every crank angle at once, by Newton.

    Args:
        theta1: crank angle, shape (n,) [rad].
        tolerance: largest last step [rad, m]. Newton doubles the digits, so the step after it would be about its square.
        most: Newton steps before giving up.

    Returns:
        (theta2, theta3, theta4, y) as columns, shape (n, 4) [rad, rad, rad, m], with y the height of the slide pin F, and
        the loop matrix there, shape (n, 4, 4).

    Raises:
        ArithmeticError: not converged, or in another assembly (coupler below the rocker's end C, or F above E).
    """
    c1, s1 = np.cos(theta1), np.sin(theta1)
    c1c1, s1c1 = 2.0 * c1 * c1 - 1.0, 2.0 * s1 * c1  # of twice the angle
    x = np.empty((theta1.size, 4))
    # Two harmonics, read off a drawing of the press; within 0.005 rad and 0.004 m of the branch the press is built in.
    x[:, 0] = 2.694 + 0.042 * c1 + 0.108 * s1 + 0.007 * c1c1 - 0.009 * s1c1
    x[:, 1] = 1.194 - 0.350 * c1 + 0.170 * s1 + 0.010 * c1c1 - 0.010 * s1c1
    x[:, 2] = -1.979 + 0.350 * c1 - 0.170 * s1 - 0.010 * c1c1 + 0.010 * s1c1
    x[:, 3] = -0.848 - 0.133 * c1 + 0.065 * s1 + 0.025 * c1c1 - 0.030 * s1c1
    bx, by = AX + L1 * c1, AY + L1 * s1
    matrix = np.zeros((theta1.size, 4, 4))
    matrix[:, 3, 3] = -1.0
    gap = np.empty((theta1.size, 4, 1))
    step = np.inf
    for _ in range(most):
        loop_matrix(x, matrix)
        if step < tolerance:
            break
        # The matrix already holds every sine and cosine of the gaps: l2 c2, l31 c3, ...
        gap[:, 0, 0] = bx + matrix[:, 1, 0] + matrix[:, 1, 1]
        gap[:, 1, 0] = by - matrix[:, 0, 0] - matrix[:, 0, 1]
        gap[:, 2, 0] = matrix[:, 3, 1] + matrix[:, 3, 2]
        gap[:, 3, 0] = -matrix[:, 2, 1] - matrix[:, 2, 2] - x[:, 3]
        change = np.linalg.solve(matrix, gap)[..., 0]
        x -= change
        step = float(np.abs(change).max(initial=0.0))
    else:
        raise ArithmeticError(f"loops not closed after {most} Newton steps; last step {step:.3g}")
    if not (np.sin(x[:, 0] - x[:, 1]).min(initial=1.0) > 0.0 and matrix[:, 2, 2].min(initial=1.0) > 0.0):
        raise ArithmeticError("Newton closed the loops in another assembly")
    return x, matrix


def loop_matrix(x: Array, matrix: Array) -> None:
    """Fill in the derivative of the four loop equations by (theta2, theta3, theta4, y), shape (n, 4, 4); its zeros and its -1 stay."""
    c, s = np.cos(x[:, :3]), np.sin(x[:, :3])
    ce, se = np.cos(x[:, 1] - CORNER), np.sin(x[:, 1] - CORNER)
    matrix[:, 0, 0], matrix[:, 1, 0] = -L2 * s[:, 0], L2 * c[:, 0]
    matrix[:, 0, 1], matrix[:, 1, 1] = L31 * s[:, 1], -L31 * c[:, 1]
    matrix[:, 2, 1], matrix[:, 3, 1] = -L32 * se, L32 * ce
    matrix[:, 2, 2], matrix[:, 3, 2] = -L4 * s[:, 2], L4 * c[:, 2]


def six_bar(theta1: ArrayLike, omega1: ArrayLike, alpha1: ArrayLike, balanced: bool = False) -> dict[str, Array]:
    """Motion, driving torque and pin forces of the press at given crank angles.

    Args:
        theta1: crank angle, shape (n,), 0 along +x, counter-clockwise [rad].
        omega1: crank speed, shape (n,) or scalar [rad/s].
        alpha1: crank acceleration, shape (n,) or scalar [rad/s2].
        balanced: with the paper's counterweights on the crank and on the rod.

    Returns:
        Arrays of shape (n,): theta2..theta4 [rad], omega2..omega4 [rad/s], alpha2..alpha4 [rad/s2]; slide_position of F above D [m],
        slide_velocity [m/s], slide_acceleration [m/s2], positive upwards; tau [N m] and the force components named in `UNKNOWNS` [N].
    """
    theta1 = np.atleast_1d(np.asarray(theta1, dtype=float))
    n = theta1.size
    omega1 = np.broadcast_to(np.asarray(omega1, dtype=float), n)
    alpha1 = np.broadcast_to(np.asarray(alpha1, dtype=float), n)

    x, matrix = closure(theta1)
    b1x, b1y = L1 * np.cos(theta1), L1 * np.sin(theta1)  # B from A
    b2x, b2y = matrix[:, 1, 0], -matrix[:, 0, 0]  # C from B
    b3x, b3y = -matrix[:, 1, 1], matrix[:, 0, 1]  # C from D
    e3x, e3y = matrix[:, 3, 1], -matrix[:, 2, 1]  # E from D
    b4x, b4y = matrix[:, 3, 2], -matrix[:, 2, 2]  # F from E

    right = np.zeros((n, 4, 1))
    right[:, 0, 0], right[:, 1, 0] = omega1 * b1y, -omega1 * b1x
    v = np.asarray(np.linalg.solve(matrix, right)[..., 0], dtype=float)
    w1, w2, w3, w4 = omega1**2, v[:, 0] ** 2, v[:, 1] ** 2, v[:, 2] ** 2
    right[:, 0, 0] = alpha1 * b1y + w1 * b1x + w2 * b2x - w3 * b3x
    right[:, 1, 0] = -alpha1 * b1x + w1 * b1y + w2 * b2y - w3 * b3y
    right[:, 2, 0] = w3 * e3x + w4 * b4x
    right[:, 3, 0] = w3 * e3y + w4 * b4y
    a = np.asarray(np.linalg.solve(matrix, right)[..., 0], dtype=float)
    alpha2, alpha3, alpha4 = a[:, 0], a[:, 1], a[:, 2]

    m1, p1, j1 = CRANK[balanced]
    m4, p4, j4 = ROD[balanced]
    f1, f2, f4 = p1 / L1, P2 / L2, p4 / L4  # centres of mass as parts of AB, BC, EF
    g3x, g3y = (P3 * b3x - Q3 * b3y) / L31, (P3 * b3y + Q3 * b3x) / L31  # centre of mass of the rocker from D
    # Accelerations of B and E, then of the centres of mass; r x (alpha, omega): a = alpha k x r - omega^2 r.
    abx, aby = -alpha1 * b1y - w1 * b1x, alpha1 * b1x - w1 * b1y
    aex, aey = -alpha3 * e3y - w3 * e3x, alpha3 * e3x - w3 * e3y
    load = np.empty((n, 14, 1))
    load[:, 0, 0] = m1 * f1 * abx
    load[:, 1, 0] = m1 * (f1 * aby + GRAVITY)
    load[:, 2, 0] = j1 * alpha1
    load[:, 3, 0] = M2 * (abx + f2 * (-alpha2 * b2y - w2 * b2x))
    load[:, 4, 0] = M2 * (aby + f2 * (alpha2 * b2x - w2 * b2y) + GRAVITY)
    load[:, 5, 0] = J2 * alpha2
    load[:, 6, 0] = M3 * (-alpha3 * g3y - w3 * g3x)
    load[:, 7, 0] = M3 * (alpha3 * g3x - w3 * g3y + GRAVITY)
    load[:, 8, 0] = J3 * alpha3
    load[:, 9, 0] = m4 * (aex + f4 * (-alpha4 * b4y - w4 * b4x))
    load[:, 10, 0] = m4 * (aey + f4 * (alpha4 * b4x - w4 * b4y) + GRAVITY)
    load[:, 11, 0] = j4 * alpha4
    load[:, 12, 0] = 0.0
    load[:, 13, 0] = M5 * (a[:, 3] + GRAVITY)

    # Moments about each body's own centre of mass: a force at r has the moment rx Fy - ry Fx.
    system = np.empty((n, 14, 14))
    system[:] = CONSTANT
    system[:, 2, F01X], system[:, 2, F01Y] = f1 * b1y, -f1 * b1x
    system[:, 2, F21X], system[:, 2, F21Y] = (f1 - 1.0) * b1y, (1.0 - f1) * b1x
    system[:, 5, F21X], system[:, 5, F21Y] = -f2 * b2y, f2 * b2x  # the crank's force on the coupler is -F21, at B
    system[:, 5, F23X], system[:, 5, F23Y] = (1.0 - f2) * b2y, (f2 - 1.0) * b2x
    system[:, 8, F23X], system[:, 8, F23Y] = g3y - b3y, b3x - g3x
    system[:, 8, F03X], system[:, 8, F03Y] = g3y, -g3x
    system[:, 8, F43X], system[:, 8, F43Y] = g3y - e3y, e3x - g3x
    system[:, 11, F43X], system[:, 11, F43Y] = -f4 * b4y, f4 * b4x
    system[:, 11, F54X], system[:, 11, F54Y] = (f4 - 1.0) * b4y, (1.0 - f4) * b4x
    forces = np.asarray(np.linalg.solve(system, load)[..., 0], dtype=float)

    result = {name: forces[:, i] for i, name in enumerate(UNKNOWNS)}
    result |= {"theta2": x[:, 0], "theta3": x[:, 1], "theta4": x[:, 2], "slide_position": x[:, 3]}
    result |= {"omega2": v[:, 0], "omega3": v[:, 1], "omega4": v[:, 2], "slide_velocity": v[:, 3]}
    result |= {"alpha2": alpha2, "alpha3": alpha3, "alpha4": alpha4, "slide_acceleration": a[:, 3]}
    return result


def world_forces(result: dict[str, Array]) -> dict[str, Array]:
    """Pin and guide forces under the URDF's joint names.

    Args:
        result: what `six_bar` returned.

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
