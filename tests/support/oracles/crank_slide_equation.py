"""The exact equation of motion of the JF75G-125, in plain formulas, integrated from edge to edge of its loads by SciPy.

    I q'' + I' q'^2 / 2 + V' = M - F X1'

Source: Zhang 2007, 4.2, with its errors put right: the lambda^2 terms of x' need a minus (4.2.1), dV/dq has m1 rho1 and g. q is the crank
angle from bottom dead centre, X the way of a slide along the machine's axis from the crankshaft, positive downwards for the slide
(k = 1, s = +1) and upwards for the counterweight (k = 2, s = -1). The lengths are inferred, see the URDF. Nothing of pinpress is used here.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

G = 9.80665
J_CRANKS = 0.289 + 0.217
M1, RHO1, M4, RHO3 = 52.25, 0.015, 18.38, 0.0297  # cranks: mass, radius of the centre of mass
R, LENGTH = 0.015, 0.3
TIGHT = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-12}


class Side(NamedTuple):
    """A crank-slider: crank radius, rod length, rod's centre of mass from the crank pin, its mass and inertia, mass of the slide, sign."""

    r: float
    length: float
    rho: float
    rod: float
    inertia: float
    slide: float
    sign: int


SIDES = (Side(R, LENGTH, 0.15, 77.49, 77.49 * 0.3**2 / 12, 2200.0, 1), Side(0.0297, 0.6, 0.3, 113.31, 113.31 * 0.6**2 / 12, 1045.0, -1))


class Coefficients(NamedTuple):
    """I [kg m2], I', V' [N m] without flywheel, height of the slide above bottom dead centre [m] and its derivative by q."""

    inertia: float
    slope: float
    weight: float
    height: float
    lever: float


def coefficients(q: float) -> Coefficients:
    s, c = math.sin(q), math.cos(q)
    inertia, slope, weight = J_CRANKS, 0.0, G * (M1 * RHO1 - M4 * RHO3) * s
    height = lever = 0.0
    for side in SIDES:
        lam = side.r / side.length
        a = math.sqrt(1 - (lam * s) ** 2)
        a1 = -(lam**2) * s * c / a  # derivatives of A
        a2 = -(lam**2) * (c * c - s * s) / a - a1 * a1 / a
        x1, x2 = -side.r * s + (side.length - side.rho) * a1, -side.r * c + (side.length - side.rho) * a2
        y1, y2 = side.rho * lam * c, -side.rho * lam * s
        p1, p2 = lam * c / a, -lam * s / a - lam * c * a1 / (a * a)
        big1, big2 = -side.r * s + side.length * a1, -side.r * c + side.length * a2
        inertia += side.rod * (x1 * x1 + y1 * y1) + side.inertia * p1 * p1 + side.slide * big1 * big1
        slope += 2 * (side.rod * (x1 * x2 + y1 * y2) + side.inertia * p1 * p2 + side.slide * big1 * big2)
        weight -= G * side.sign * (side.rod * x1 + side.slide * big1)
        if side.sign > 0:
            height, lever = side.r * (1 - c) + side.length * (1 - a), -big1
    return Coefficients(inertia, slope, weight, height, lever)


def angle_of(height: float) -> float:
    """Crank angle, 0 to pi, at which the slide stands at a height above bottom dead centre: the cosine rule."""
    x = R + LENGTH - height
    return math.acos((x * x + R * R - LENGTH**2) / (2 * R * x))


class Window(NamedTuple):
    """A force on the slide, positive upwards, between two heights [m].

    ``way``: on the way up (1), down (-1) or on both (0). ``law``: height and velocity upwards to force [N]. ``contact``: it never pulls.
    """

    upper: float
    lower: float
    way: int
    law: Callable[[float, float], float]
    contact: bool = False


class Solution(NamedTuple):
    """States at the times asked for (n,): q, q' and q'', works of drive and against the loads, motor torque squared over time, and the
    drive's states (k, n). ``crossings``: (time, q, q') wherever an edge, dead centre or stop was passed. ``stalled``: whether it ends at
    rest, with loads in the way."""

    time: np.ndarray
    angle: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    drive_work: np.ndarray
    load_work: np.ndarray
    motor_squared: np.ndarray
    states: np.ndarray
    crossings: list[tuple[float, float, float]]
    stalled: bool


def no_torque(time, angle, speed, states):
    return 0.0


def solve(
    times,
    speed,
    flywheel,
    angle=0.0,
    torque=no_torque,
    motor=None,
    states=(),
    rates=None,
    corners=(),
    windows=(),
    in_time=None,
    instants=(),
):
    """Integrate up to the last of the rising ``times``.

    ``torque(time, angle, speed, states)`` on the crank, ``motor`` the same of the motor's own shaft, ``rates`` of the drive's ``states``;
    ``corners``: functions of the same arguments at whose zeros the torque is not smooth. ``in_time``: force on the slide over time, not
    smooth at the ``instants``.
    """
    motor = motor or torque
    times = np.asarray(times, dtype=float)
    k = len(states)
    edges = {0.0, math.pi}
    for window in windows:
        for height in (window.upper, window.lower):
            if 0 < height < 2 * R:
                edges |= {angle_of(height), 2 * math.pi - angle_of(height)}
    within_a_turn = np.array(sorted(edges))
    every = np.concatenate([within_a_turn + 2 * math.pi * turn for turn in range(-60, 400)])  # far more turns than any run here has

    def act(way, low, high, pushing):
        """Right-hand side in a stretch between two edges, turning one way."""
        middle = coefficients(0.5 * (low + high))
        rising = middle.lever * way > 0
        acting = [w for w in windows if w.lower < middle.height < w.upper and w.way in (0, 1 if rising else -1)]
        acting = [w for w in acting if not w.contact or w in pushing]

        def full(t, y):
            q, w, own = y[0], y[1], y[5:]
            at = coefficients(q)
            velocity = at.lever * w
            force = sum(window.law(at.height, velocity) for window in acting) + (in_time(t) if in_time else 0.0)
            drive, shaft = torque(t, q, w, own), motor(t, q, w, own)
            alpha = (drive - 0.5 * at.slope * w * w - at.weight + force * at.lever) / (at.inertia + flywheel)
            return [w, alpha, drive * w, -force * velocity, shaft * shaft, *(rates(t, q, w, own) if k else ())]

        return full

    contacts = [w for w in windows if w.contact]

    def push(window, y):
        """A contact's law: its force were it closed."""
        at = coefficients(y[0])
        return window.law(at.height, at.lever * y[1])

    y, t = np.array([angle, speed, 0.0, 0.0, 0.0, *states]), 0.0
    ends = sorted({*(i for i in instants if 0 < i < times[-1]), times[-1]})
    crossings, found, stalled, place = [], [], False, None

    while t < times[-1]:
        until = next(e for e in ends if e > t)
        way = int(np.sign(y[1]))
        for guess in (way,) if way else (1, -1):
            low, high = between(every, y[0], guess) if place is None or not way else place
            pushing = [w for w in contacts if push(w, y) > -1e-6]
            f = act(guess, low, high, pushing)
            if way or (f(t, y)[1] or f(t + 1e-6, y)[1]) * guess > 0:
                break
        else:
            stalled = True
            break
        way = guess
        ahead = y + 1e-9 * np.array(f(t, y))
        pushing = [w for w in contacts if push(w, ahead) > 0]
        f = act(way, low, high, pushing)
        events = [
            event(lambda t, y, high=high: y[0] - high, 1),
            event(lambda t, y, low=low: y[0] - low, -1),
            event(lambda t, y: y[1], -way),
        ]
        others = [lambda t, y, corner=corner: corner(t, y[0], y[1], y[5:]) for corner in corners]
        others += [lambda t, y, w=w: push(w, y) for w in contacts]
        events += [event(g, -int(np.sign(g(t + 1e-9, ahead)))) for g in others]
        piece = solve_ivp(f, (t, until), y, events=events, dense_output=True, **TIGHT)
        assert piece.success, piece.message
        end = piece.t[-1]
        mine = (times >= t) & (times < end) if end < times[-1] else times >= t
        if mine.any():
            at = piece.sol(times[mine])
            found.append(np.vstack([at, [f(s, column)[1] for s, column in zip(times[mine], at.T, strict=True)]]))
        t, y = end, piece.y[:, -1].copy()
        place = (low, high)
        if len(piece.t_events[0]):
            y[0] = high
            place = between(every, high, 1)
        elif len(piece.t_events[1]):
            y[0] = low
            place = between(every, low, -1)
        elif len(piece.t_events[2]):
            y[1] = 0.0
        if any(len(e) for e in piece.t_events[:3]):
            crossings.append((t, float(y[0]), float(y[1])))
    all_states = np.hstack(found) if found else np.zeros((6 + k, 0))
    q, w, a, drive_work, load_work, motor_squared = all_states[[0, 1, -1, 2, 3, 4]]
    known = times[: all_states.shape[1]]
    return Solution(known, q, w, a, drive_work, load_work, motor_squared, all_states[5:-1], crossings, stalled)


def between(edges, angle, way):
    """The edges next to an angle, seen that way from it."""
    i = int(np.searchsorted(edges, angle + way * 1e-9))
    return float(edges[i - 1]), float(edges[i])


def event(function, direction):
    def g(t, y):
        return function(t, y)

    g.terminal, g.direction = True, direction  # type: ignore[attr-defined]
    return g
