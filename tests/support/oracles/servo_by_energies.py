"""Best motions of a servo press by a barrier-Newton method in the squares of the crank's speeds alone: a second convex solver, and the
phase plane for least time.

They share nothing with `pinpress.servo`: the rule of the heat, unknowns and method are others, and in `nodes` the nodes. The press comes in
by its energies, from Pinocchio's `crba` and `computePotentialEnergy` at states that Pinocchio's engine closes; no inverse dynamics. Over a
segment the mean torque is the change of (M + J) b/2 + V and of the work spent on the process, by the step; b is linear between nodes, so
that a segment takes 2 h / (root of b before + root of b after), exactly. Its heat is the square of the mean torque times that time. Errors
fall with the square of the steps, so that results with N and 2 N segments can be extrapolated.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import brentq

import pinpress as pp

FULL = 2.0 * np.pi
PIECES, FEWEST = 40, 4  # pieces of a path, each of ``fine`` segments, and those between two marks at least
STEP = 1e-4  # for the slope of the potential energy at a rest [rad]
STEEP = 24  # power of torques whose sum is made small until they are within their limit
CENTRED, MOST_STEPS = 1e-3, 200  # Newton's decrement at which a point counts as centred, and most steps up to there
ROUNDING = 1e-13  # of the barrier's value, as a share
GROWTH, GAP = 8.0, 1e-8  # of the objective's weight from centre to centre; share of the objective at which the barrier ends


class Press:
    """Height of the slide and energies of a press over its crank angle."""

    def __init__(self, press):
        self.press, self.data = press, press.model.createData()
        ends = pp.dead_centres(press)
        self.top, self.lowest = ends.top_angle, ends.bottom_position
        self.bottom = ends.top_angle + (ends.bottom_angle - ends.top_angle) % FULL

    def _moved(self, angle):
        one = np.ones_like(angle)
        return pp.servo_cycle(self.press, angle, speed=one, acceleration=0.0 * one, engine="pinocchio")

    def slide(self, angle):
        """Height above bottom dead centre and its slope by crank angle, (n,) each."""
        motion = self._moved(angle)
        return motion.slide_position - self.lowest, motion.slide_velocity

    def energies(self, angle):
        """Twice the kinetic energy at unit speed, M [kg m2], and the potential energy [J], (n,) each."""
        motion, model = self._moved(angle), self.press.model
        mass, potential = [], []
        for q, v in zip(motion.q, motion.v, strict=True):
            upper = np.triu(pin.crba(model, self.data, q))
            mass.append(2.0 * v @ upper @ v - np.diag(upper) @ v**2)
            potential.append(pin.computePotentialEnergy(model, self.data, q))
        return np.array(mass), np.array(potential)

    def at_height(self, height, down=True):
        """Crank angle at which the slide passes a height on its way down, or up."""
        low, high = (self.top, self.bottom) if down else (self.bottom, self.top + FULL)
        return brentq(lambda angle: self.slide(np.array([angle]))[0][0] - height, low, high, xtol=1e-13) if height else self.bottom


def drawn(force, start, end=0.0, quarter=False):
    """Work spent from ``start`` down to a height, of a force of a half sine (`DeepDrawing`), or of its first quarter (`Blanking`)."""
    rate = (0.5 if quarter else 1.0) * np.pi / (start - end)
    return lambda height: force / rate * (1.0 - np.cos(rate * (start - np.clip(height, end, start))))


def tabled(heights, forces):
    """Work spent from the highest of falling ``heights`` down to a height, of forces linear between them (`ForceStroke`)."""
    heights, forces = np.array(heights, float)[::-1], np.array(forces, float)[::-1]
    area = np.concatenate([[0.0], np.cumsum(0.5 * (forces[1:] + forces[:-1]) * np.diff(heights))])

    def spent(height):
        at = np.clip(height, heights[0], heights[-1])
        k = np.clip(np.searchsorted(heights, at) - 1, 0, len(heights) - 2)
        return area[-1] - area[k] - 0.5 * (forces[k] + np.interp(at, heights, forces)) * (at - heights[k])

    return spent


def nodes(hand, turns, fine, marks, closed):
    """Crank angles along the legs between ``turns``, on heights ``marks`` and dead centres, graded towards rests. With twice as ``fine``
    each segment is halved."""
    marked = np.array([*(hand.at_height(mark, down) for mark in marks for down in (True, False)), hand.bottom, hand.top])
    found, way = [np.array(turns[:1])], abs(np.diff(turns)).sum()
    for start, end in pairwise(turns):
        inside = np.concatenate([marked - FULL, marked, marked + FULL])
        inside = np.unique(inside[(inside - start) * (inside - end) < -1e-9])
        corners = np.concatenate([[start], inside if end > start else inside[::-1], [end]])
        last = len(corners) - 2
        for k, (a, b) in enumerate(pairwise(corners)):
            count = fine * max(FEWEST, round(PIECES * abs(b - a) / way))
            found.append(a + (b - a) * _shares(count, not closed and k == 0, not closed and k == last)[1:])
    return np.concatenate(found)


def _shares(count, from_rest, to_rest):
    u = np.linspace(0.0, 1.0, count + 1)
    if from_rest and to_rest:
        return 0.5 * (1.0 - np.cos(np.pi * u))
    return u**2 if from_rest else 1.0 - (1.0 - u) ** 2 if to_rest else u


class Way:
    """A path of the crank in segments. The crank rests at both ends and where it turns back or is said to, if the path is not closed.

    Attributes of N segments: angle (N + 1,); step (N,), negative backwards; mass (N + 1,) with the drive; still (N,) mean torque of weights
    and process; height, travel (N + 1,) of the slide; down (N,) whether it goes down; rests, indices of nodes; number (N + 1,) of the
    unknown at a node, -1 at rests; unknowns, their count; holding, torque at each of the rests after a leg.
    """

    def __init__(self, hand, inertia, angle, turns, work=None, closed=False):
        """
        Args:
            hand: a `Press`.
            inertia: of the drive, at the crank.
            angle: of the nodes.
            turns: crank angles between which the legs lead.
            work: spent from above down to a height, or None.
            closed: whether the crank never rests.
        """
        self.angle, self.step = angle, np.diff(angle)
        mass, potential = hand.energies(angle)
        self.mass = mass + inertia
        self.height, self.travel = hand.slide(angle)
        self.down = np.diff(self.height) < 0
        spent = 0.0 if work is None else np.where(self.down, np.diff(work(self.height)), 0.0)
        self.still = (np.diff(potential) + spent) / self.step
        self.rests = np.empty(0, int) if closed else self._ends(turns)
        moving = np.ones(len(angle), bool)
        moving[self.rests] = False
        self.number = np.where(moving, np.cumsum(moving) - 1, -1)
        if closed:
            self.number[-1] = 0
        self.unknowns = int(self.number.max()) + 1
        low, high = (hand.energies(np.array(turns[1:]) + way * STEP)[1] for way in (-1.0, 1.0))
        self.holding = (high - low) / (2.0 * STEP)

    def _ends(self, turns):
        found = [0]
        for end in turns[1:]:
            found.append(found[-1] + 1 + int(np.flatnonzero(abs(self.angle[found[-1] + 1 :] - end) < 1e-9)[0]))
        return np.array(found)

    def speed_limit(self, speed, upper, lower):
        """(N + 1,) largest b where the slide may be so fast between two heights on its way down, infinite elsewhere."""
        beside = np.append(self.down, False) | np.append(False, self.down)
        inside = beside & (self.height > lower - 1e-9) & (self.height < upper + 1e-9) & (abs(self.travel) > 1e-6 * abs(self.travel).max())
        return np.where(inside, speed / np.where(inside, self.travel, 1.0), np.inf) ** 2

    def full(self, b):
        """(N + 1,) b at the nodes, of the unknowns."""
        return np.where(self.number < 0, 0.0, b[self.number])


class Task(NamedTuple):
    """What is to be least, "heat", "time" or "energy", without that of rests, and its limits; None where there is none.

    Attributes: time of moving; most, (N + 1,) b at the nodes; torque, the mean of a segment; fall, by which that is smaller for each rad/s
    of the mean speed; power, mean torque times mean speed; and regeneration share, copper, iron and drag of the drive, at the crank.
    """

    wanted: str
    time: float | None = None
    most: np.ndarray | None = None
    torque: float | None = None
    fall: float = 0.0
    power: float | None = None
    regeneration: float = 1.0
    copper: float = 0.0
    iron: float = 0.0
    drag: float = 0.0


class Found(NamedTuple):
    """Objective, b (N + 1,), and by how much the objective can be larger than the least one of these nodes, as a share."""

    value: float
    b: np.ndarray
    gap: float


# ------------------------------------------------------------------------------------------------------------------------ phase plane


def least_time(way, torque, most):
    """Least time of the legs, as fast as possible forwards from each rest and backwards from the next one, in kinetic energies."""
    limit = 0.5 * way.mass * most
    forwards, backwards = np.zeros_like(limit), np.zeros_like(limit)
    gained = torque * abs(way.step) - way.still * way.step
    lost = torque * abs(way.step) + way.still * way.step
    for i in range(len(gained)):
        forwards[i + 1] = 0.0 if way.number[i + 1] < 0 else min(forwards[i] + gained[i], limit[i + 1])
    for i in range(len(lost) - 1, -1, -1):
        backwards[i] = 0.0 if way.number[i] < 0 else min(backwards[i + 1] + lost[i], limit[i])
    b = np.maximum(2.0 * np.minimum(forwards, backwards) / way.mass, 0.0)
    v = np.sqrt(b)
    return float(np.sum(2.0 * abs(way.step) / (v[1:] + v[:-1])))


# --------------------------------------------------------------------------------------------------------------------- barrier-Newton


def best(way, task, start):
    """The least objective on these nodes.

    Args:
        way: a `Way`.
        task: a `Task`.
        start: a crank speed so slow that limits of speed hardly act.
    """
    gone = np.concatenate([[0.0], np.cumsum(abs(way.step))])
    even = np.ones_like(gone)
    if len(way.rests):
        even = 4.0 * abs(gone[:, None] - gone[way.rests]).min(axis=1) / gone[-1]
    even = start**2 * even if task.most is None else np.minimum(start**2 * even, 0.9 * task.most)
    b = np.empty(way.unknowns)
    b[way.number[way.number >= 0]] = even[way.number >= 0]

    def in_time(b):
        return task.time is None or quantities(way, task, b)["time"].value.sum() < 0.999 * task.time

    def weak(b):
        return bool(all((gate.value < 0.999).all() for gate in gates(quantities(way, task, b), task)))

    logarithms = _logarithms(way, task)
    free = task._replace(torque=None, power=None)
    b = _until(way, free._replace(wanted="time", time=None), b, logarithms, in_time)  # faster, until the time is kept
    b = _until(way, task._replace(wanted="strain"), b, logarithms, weak)
    size, weight = abs(quantities(way, task, b)[task.wanted].value.sum()), logarithms
    while True:
        soft = size / (weight * len(b)) if task.wanted == "energy" else 0.0
        b = _centre(way, task, b, weight / size, soft)
        value = float(quantities(way, task, b, 1e-14 * size)[task.wanted].value.sum())
        gap = logarithms * size / weight / abs(value)
        if gap < GAP:
            return Found(value, way.full(b), gap)
        weight *= GROWTH


def _until(way, task, b, weight, enough):
    while not enough(b):
        size = quantities(way, task, b)[task.wanted].value.sum()
        b = _centre(way, task, b, weight / size, 0.0, enough)
        weight *= GROWTH
        if weight > 1e15:
            raise ArithmeticError("no motion keeps the limits")
    return b


def _centre(way, task, b, weight, soft, until=None):
    """Newton's method down to the centre of the barrier; ``until`` ends it earlier. A power and a falling torque are not
    convex: their Hessians get a ridge."""
    value, gradient, hessian = _barrier(way, task, b, weight, soft)
    for _ in range(MOST_STEPS):
        size = 1.0 / np.sqrt(abs(np.diag(hessian)))
        scaled, ridge = hessian * size * size[:, None], 0.0
        while True:
            try:
                factor = cho_factor(scaled + ridge * np.eye(len(b)))
                break
            except LinAlgError:
                ridge = max(2.0 * ridge, 1e-6)
        step = -size * cho_solve(factor, size * gradient)
        decrement = -gradient @ step
        if decrement < max(CENTRED, ROUNDING * abs(value)):
            return b
        length, there = 1.0, _barrier(way, task, b + step, weight, soft)
        while not there[0] <= value - 0.1 * length * decrement + ROUNDING * abs(value):
            length *= 0.5
            if length < 1e-10:
                return b  # at rounding
            there = _barrier(way, task, b + length * step, weight, soft)
        b, (value, gradient, hessian) = b + length * step, there
        if until is not None and until(b):
            return b
    raise ArithmeticError("no centre was found")


def _barrier(way, task, b, weight, soft):
    """Weighted objective with logarithms of what limits leave, its gradient and Hessian; infinite outside the limits."""
    outside = np.inf, None, None
    most = np.full(way.unknowns, np.inf)
    if task.most is not None:
        np.minimum.at(most, way.number[way.number >= 0], task.most[way.number >= 0])
    if not ((b > 0) & (b < most)).all():
        return outside
    found = quantities(way, task, b, soft)
    whole = found[task.wanted] * weight
    for gate in gates(found, task) if task.wanted != "strain" else ():
        room = 1.0 - gate.value
        if not (room > 0).all():
            return outside
        whole = whole + gate.through(-np.log(room), 1.0 / room, 1.0 / room**2)
    value, gradient, hessian = _gathered(way, whole)
    diagonal, limited = np.arange(way.unknowns), np.isfinite(most)
    value += -np.log(b).sum() - np.log(1.0 - b[limited] / most[limited]).sum()
    gradient += -1.0 / b + 1.0 / (most - b)
    hessian[diagonal, diagonal] += 1.0 / b**2 + 1.0 / (most - b) ** 2
    if task.time is not None:
        total, slope, bend = _gathered(way, found["time"])
        room = task.time - total
        if room <= 0:
            return outside
        value -= np.log(room / task.time)
        gradient += slope / room
        hessian += bend / room + np.outer(slope, slope) / room**2
    return value, gradient, hessian


def _logarithms(way, task):
    """Their number, which bounds how far a centre is from the least objective."""
    each = 2 * len(way.step) * ((task.torque is not None) + (task.power is not None))
    # that of a corner which is rounded is at most one more for each segment
    return 2 * way.unknowns + each + (0 if task.most is None else int(np.isfinite(task.most).sum())) + (task.time is not None)


class Jet(NamedTuple):
    """A quantity of each segment with its first and second derivatives by b at both ends: (N,), (2, N), (2, 2, N)."""

    value: np.ndarray
    slope: np.ndarray
    bend: np.ndarray

    def __add__(self, other):
        return Jet(self.value + other.value, self.slope + other.slope, self.bend + other.bend)

    def __mul__(self, other):
        if not isinstance(other, Jet):
            return Jet(other * self.value, other * self.slope, other * self.bend)
        cross = self.slope[:, None] * other.slope[None] + other.slope[:, None] * self.slope[None]
        return Jet(
            self.value * other.value,
            self.value * other.slope + other.value * self.slope,
            self.value * other.bend + other.value * self.bend + cross,
        )

    def through(self, value, slope, bend):
        """A function of the quantity, by its value and derivatives there."""
        return Jet(value, slope * self.slope, slope * self.bend + bend * self.slope[:, None] * self.slope[None])


def quantities(way, task, b, soft=0.0):
    """Jets of time, heat, energy drawn, torque, power and what is large where these exceed their limits.

    ``soft``: energy by which the corner between energy drawn and given back is rounded.
    """
    before, after = way.full(b)[:-1], way.full(b)[1:]
    first, last, h = way.number[:-1] >= 0, way.number[1:] >= 0, abs(way.step)
    speeds = _root(before, 0, first) + _root(after, 1, last)
    time = speeds.through(2.0 * h / speeds.value, -2.0 * h / speeds.value**2, 4.0 * h / speeds.value**3)
    by_before, by_after = -0.5 * way.mass[:-1] / way.step, 0.5 * way.mass[1:] / way.step
    slope = np.stack([np.where(first, by_before, 0.0), np.where(last, by_after, 0.0)])
    torque = Jet(by_before * before + by_after * after + way.still, slope, np.zeros((2, 2, len(h))))
    rolled = speeds * (0.5 * h)  # integral of the square of the speed over the time
    heat = torque * torque * time + torque * (2.0 * task.drag * way.step) + rolled * task.drag**2
    given = torque * way.step + rolled * (task.drag + task.iron) + heat * task.copper
    size = np.maximum(np.hypot(given.value, soft), 1e-300)
    positive = given.through(0.5 * (given.value + size), 0.5 * (1.0 + given.value / size), 0.5 * soft**2 / size**3)
    found = {
        "time": time,
        "heat": heat,
        "energy": given * task.regeneration + positive * (1.0 - task.regeneration),
        "torque": torque,
        "speed": speeds * 0.5,
        "power": torque * speeds * (0.5 * np.sign(way.step)),
    }
    if task.wanted == "strain":
        parts = [gate.through(*(_falling(k) * gate.value ** (STEEP - k) for k in range(3))) for gate in gates(found, task)]
        found["strain"] = sum(parts[1:], parts[0]) if parts else time * 0.0
    return found


def _falling(k):
    return (1.0, STEEP, STEEP * (STEEP - 1.0))[k]


def gates(found, task):
    """Torque, with what the speed leaves less of it, and power by their limits, in both senses."""
    both = []
    for sign in (1.0, -1.0):
        if task.torque is not None:
            both.append((found["torque"] * sign + found["speed"] * task.fall) * (1.0 / task.torque))
        if task.power is not None:
            both.append(found["power"] * (sign / task.power))
    return both


def _root(values, end, moves):
    """The root of b at one end of each segment."""
    safe = np.where(moves, values, 1.0)
    slope, bend = np.zeros((2, len(values))), np.zeros((2, 2, len(values)))
    slope[end] = np.where(moves, 0.5 / np.sqrt(safe), 0.0)
    bend[end, end] = np.where(moves, -0.25 / safe**1.5, 0.0)
    return Jet(np.sqrt(values), slope, bend)


def _gathered(way, jet):
    """Sum over the segments, its gradient and Hessian by the unknowns."""
    n = way.unknowns
    gradient, hessian = np.zeros(n + 1), np.zeros((n + 1, n + 1))  # the last for rests, and dropped
    ends = way.number[:-1], way.number[1:]
    for k in (0, 1):
        np.add.at(gradient, ends[k], jet.slope[k])
        for j in (0, 1):
            np.add.at(hessian, (ends[k], ends[j]), jet.bend[k, j])
    return jet.value.sum(), gradient[:-1], hessian[:-1, :-1]
