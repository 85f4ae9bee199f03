"""A press on mounts that can press but not pull: vibration over time with feet that lift off and land.

The force on a foot is P - k d - c d', plus the loss of its pad. P is the static load, and d is the upward displacement of the foot. The
foot lifts off when this force falls to zero; then no force acts on it. It lands when it comes back to the end of the unloaded pad, d = P /
k. A free pad springs back at once. It grips the foot where the foot lands, and its horizontal force is zero at that instant, so a press can
walk.

Between two switches of a foot the system is linear. The steps are exact for a force that is linear between two states, as in
`time_response`. The instants at which a foot lifts off or lands are roots of this exact motion; from there the steps continue with other
matrices. A cubic through the force and its rate at both ends of an interval shows whether the foot switches in between.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import typed, whole_number
from ..common.errors import PinpressError, caution
from ..common.frozen import read_only
from ..common.numerics import bracketed_roots
from ..common.quantities import Array
from ..common.results import Tabular
from ..common.tables import Column
from ..dynamics.reactions import Reactions
from ..kinematics.motion import is_cycle
from .mounted_press import MountedPress, quadrature
from .response import (
    RESONANCE,
    Flywheels,
    FrameMotion,
    Points,
    checked_harmonics,
    frame_wrench,
    mean_speed,
    mount_constants,
    named_points,
    period_of,
    spectrum,
    step_matrices,
    time_step,
)

MOST_SWITCHES = 200  # switches of feet in one interval between states; more count as chatter
REACH = 4.0  # bound of (largest eigenvalue) x (time that one Taylor polynomial covers)
TERMS = 34  # terms of a Taylor polynomial; the first omitted term is 4^34 / 34! = 1e-18
ROUNDING = 1e-12  # a foot that has just switched and carries a smaller share of its static load counts as unloaded
FREE_FALL = 2  # index of z among the directions of a mount


@dataclass(frozen=True, eq=False, repr=False)
class LiftingMotion(Tabular):
    """Vibration of a press whose feet lift off, found by `lifting_response`. All arrays are read-only.

    Attributes:
        motion: the vibration over all strokes.
        mount: (l,) number of the mount that lifts off, counted from 1; one entry for each lift, in order of time.
        start: (l,) time at which it lifts off [s].
        end: (l,) time at which it lands; the end of the motion if it does not land [s].
        gap: (l,) largest gap between foot and unloaded pad at the states in between [m].
        walked: (mounts, 2) final displacement of each foot from its original place by walking, along x and y [m].
        change: (strokes - 1,) norm of the change of the state from the end of one stroke to the end of the next, divided by the largest
            norm of the states [-]. The norm is the energy norm of displacements and velocities.
        repeats_after: number of strokes after which the final motion repeats itself; None: it does not repeat itself, or there is only one
            stroke.
    """

    motion: FrameMotion
    mount: NDArray[np.intp]
    start: Array
    end: Array
    gap: Array
    walked: Array
    change: Array
    repeats_after: int | None

    @property
    def title(self) -> str:
        return f"LiftingMotion of {self.motion.system.press.name}: {len(self.mount)} lifts in {self.motion.time[-1]:.6g} s"

    def columns(self) -> dict[str, Column]:
        """A row for each lift. The vibration is in the columns of ``motion``."""
        return {"mount": self.mount, "start [s]": self.start, "end [s]": self.end, "gap [m]": self.gap}


@typed
def lifting_response(
    system: MountedPress,
    reactions: Reactions,
    *,
    points: Points,
    flywheel: Flywheels = None,
    strokes: int = 1,
    period: float | None = None,
) -> LiftingMotion:
    """The vibration over time of a press whose feet are not bolted down: the mounts can press but not pull.

    For one period (of `cycle` or `steady_state`) the vibration starts from the linear steady state; feet whose mounts would pull in this
    state start lifted off. For a run of `simulate` the vibration starts at rest. If no foot lifts off, the result is the linear response,
    which repeats itself every stroke. With lifts, use ``strokes`` to see whether the motion settles and after how many strokes it repeats
    itself; there may be several periodic motions, or none. Rotors spin at the mean speed. Loss factors act at each mode's own frequency, as
    in `time_response`; in `steady_response` they act at the frequency of the force. So with large loss factors the two differ by a few per
    cent even if no foot lifts off.

    Args:
        system: the press on its mounts; each stands on its mounts by its weight.
        reactions: as for `steady_response`, or as for `time_response`.
        points: as for `steady_response`.
        flywheel: as for `steady_response`.
        strokes: number of consecutive periods, 1 to 10 000; 1 if the motion is not one period.
        period: as for `steady_response` [s].

    Raises:
        PinpressError: as `steady_response` or `time_response`; several strokes of a motion that is not one period; a mount without
            stiffness along z; gravity not along -z; a foot that chatters.

    Warns:
        PinpressWarning: the frame turns by more than 0.1 rad, too much for the small angles of the model.
    """
    count = whole_number("strokes", strokes, 1, 10_000)
    wrench, placed, n = frame_wrench(system, reactions, flywheel), named_points(system, points), len(system.mass)
    feet, interval = _Feet(system, mean_speed(system, reactions.motion)), time_step(reactions.motion)
    begin = np.zeros(2 * n)
    if _is_period(reactions, period):
        length, states = period_of(reactions.motion, period)
        checked_harmonics(*spectrum(system, reactions, flywheel, period))
        interval, wrench = length / states, np.vstack([np.tile(wrench[:states], (count, 1)), wrench[:1]])
        begin = _repeating(feet, np.vstack([wrench[:states], wrench[:1]]), interval)
    elif count > 1:
        raise PinpressError("strokes go with one period, of cycle or steady_state: leave strokes= out for another motion")
    course = _march(feet, wrench, interval, begin)
    turned = max(float(np.abs(course.states[:, :n] @ part[3:].T).max()) for part in system.parts.values())
    # up to 0.1 rad, sine and angle differ by less than 0.2 %
    if turned > 0.1:
        caution(
            f"the frame turns by {np.degrees(turned):.3g} deg: it is thrown about, and turns are taken as small here; bolt it down, or"
            " look for a force that is too large"
        )
    time = np.asarray(interval * np.arange(len(wrench)), dtype=float)
    motion = FrameMotion.of(
        system,
        time=time,
        points=placed,
        motion=(course.states[:, :n], course.states[:, n:], course.acceleration),
        mount_force=course.force - system.mount_load,
        wrench=wrench,
        period=None,
    )
    change, repeats_after = _repeats(system, course.states[:: len(wrench) // count]) if count > 1 else (np.zeros(0), None)
    lifts = sorted(course.lifts, key=lambda lift: lift.start)
    height = motion_of_feet(system, course.states[:, :n]) - feet.free
    inside = [(time >= lift.start) & (time <= lift.end) for lift in lifts]
    gap = [max(0.0, float(height[which, lift.mount].max(initial=0.0))) for lift, which in zip(lifts, inside, strict=True)]
    return LiftingMotion(
        motion=motion,
        mount=read_only(np.array([lift.mount + 1 for lift in lifts], dtype=np.intp)),
        start=read_only(np.array([lift.start for lift in lifts])),
        end=read_only(np.array([lift.end for lift in lifts])),
        gap=read_only(np.array(gap)),
        walked=read_only(course.walked),
        change=read_only(change),
        repeats_after=repeats_after,
    )


def motion_of_feet(system: MountedPress, coordinates: Array) -> Array:
    """Displacements (states, mounts) of the feet upwards, from coordinates (states, n) [m]."""
    return np.asarray(coordinates @ system.mount_rows[:, FREE_FALL].T)


def _is_period(reactions: Reactions, period: float | None) -> bool:
    """Whether `period_of` accepts the motion as a period."""
    try:
        period_of(reactions.motion, period)
    except PinpressError:
        if period is not None or is_cycle(reactions.motion):
            raise
        return False
    return True


class _Lift(NamedTuple):
    """A mount, counted from 0, and the times at which it lifts off and lands [s]."""

    mount: int
    start: float
    end: float


class _Course(NamedTuple):
    """States (s, 2 n), accelerations (s, n) and forces of the mounts (s, mounts, 3) of a motion, its lifts, and the final displacements of
    the feet."""

    states: Array
    acceleration: Array
    force: Array
    lifts: list[_Lift]
    walked: Array


class _Feet:
    """The linear systems of a press, one for each set of standing feet. Each is computed when first needed.

    Attributes:
        system: the press on its mounts.
        load: (mounts, 3) static load [N].
        free: (mounts,) displacement at which each pad is unloaded [m].
    """

    def __init__(self, system: MountedPress, speed: float) -> None:
        self.system, self.load = system, np.asarray(system.mount_load)
        if system.press.up[FREE_FALL] < 1.0 - ROUNDING:
            direction = ", ".join(f"{part:g}" for part in np.round(system.press.up, 6) + 0.0)
            raise PinpressError(f"feet lift off along z, but up is ({direction}), against gravity: turn the press so that z is up")
        self.stiffness, self.damping, self.lossy = mount_constants(system)
        if not (self.stiffness[:, FREE_FALL] > 0).all():
            number = int(self.stiffness[:, FREE_FALL].argmin()) + 1
            raise PinpressError(f"mount {number} has no stiffness along z: a foot that does not press cannot lift off; leave it out")
        self.free = self.load[:, FREE_FALL] / self.stiffness[:, FREE_FALL]
        self.rows, self.later, self.speed = system.mount_rows, quadrature(system), speed
        self.inverse = np.linalg.inv(system.mass)
        factor = np.linalg.inv(np.linalg.cholesky(system.mass))
        self.fastest = float(np.sqrt(max(np.linalg.eigvalsh(factor @ system.stiffness @ factor.T)[-1], 0.0)))
        self._factor = factor
        self._matrices: dict[bytes, tuple[Array, Array, float]] = {}
        self._steps: dict[tuple[bytes, float], tuple[Array, Array, Array]] = {}
        self._conditions: dict[bytes, tuple[Array, Array]] = {}

    def matrices(self, standing: NDArray[np.bool_]) -> tuple[Array, Array, float]:
        """a and b of x' = a x + b f with these feet standing, and an upper bound of the absolute eigenvalues of a [1/s].

        In the energy norm, a is skew-symmetric except for the damping matrix. So the norm of a is at most the highest natural frequency
        plus the norm of the damping matrix. A lifted foot cannot raise the natural frequency.
        """
        key = standing.tobytes()
        if key not in self._matrices:
            system, n = self.system, len(self.system.mass)
            off = ~standing
            constants = self.stiffness, self.damping, self.lossy
            without = [np.einsum("mki,mk,mkj->ij", self.rows[off], each[off], self.rows[off]) for each in constants]
            resisting = system.damping - without[1] + self.speed * system.gyroscopic + (system.loss - without[2]) @ self.later
            rate = -self.inverse @ np.hstack([system.stiffness - without[0], resisting])
            a = np.vstack([np.eye(n, 2 * n, n), rate])
            bound = self.fastest + float(np.linalg.norm(self._factor @ resisting @ self._factor.T, 2))
            self._matrices[key] = a, np.vstack([np.zeros((n, n)), self.inverse]), bound
        return self._matrices[key]

    def step(self, standing: NDArray[np.bool_], interval: float) -> tuple[Array, Array, Array]:
        """`step_matrices` of a whole step with these feet standing."""
        key = standing.tobytes(), interval
        if key not in self._steps:
            a, b, _ = self.matrices(standing)
            self._steps[key] = step_matrices(a, b, interval)
        return self._steps[key]

    def constant(self, standing: NDArray[np.bool_], anchor: Array) -> Array:
        """Constant force (n,) on the coordinates: missing static loads of lifted feet, and forces of pads that gripped at another place."""
        forces = np.where(standing[:, None], self.stiffness * anchor, -self.load)
        return np.asarray(np.einsum("mk,mkj->j", forces, self.rows))

    def force(self, anchor: Array, state: Array) -> Array:
        """Forces (mounts, 3) of the mounts on the frame at a state, as if all feet stood."""
        n = len(self.system.mass)
        displaced, moving, later = (self.rows @ each for each in (state[:n], state[n:], self.later @ state[n:]))
        return np.asarray(self.load - self.stiffness * (displaced - anchor) - self.damping * moving - self.lossy * later)

    def holds(self, standing: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Matrix (2, mounts, 2 n) and constants (2, mounts) of two switching functions for each foot; the foot switches when both are
        negative [N].

        The first is the force of the mount for a standing foot, and its negative for a lifted foot. The second is stiffness x height above
        the unloaded pad, for a lifted foot only.
        """
        key = standing.tobytes()
        if key not in self._conditions:
            up, rows, n = self.stiffness[:, FREE_FALL, None], self.rows[:, FREE_FALL], len(self.system.mass)
            resisting = self.damping[:, FREE_FALL, None] * rows + self.lossy[:, FREE_FALL, None] * (rows @ self.later)
            sign, heavy = np.where(standing, 1.0, -1.0), float(np.abs(self.load[:, FREE_FALL]).max())
            force, height = -np.hstack([up * rows, resisting]), np.hstack([up * rows, np.zeros((len(rows), n))])
            matrix = np.stack([sign[:, None] * force, np.where(standing, 0.0, 1.0)[:, None] * height])
            constant = np.stack([sign * self.load[:, FREE_FALL], np.where(standing, -heavy, -self.load[:, FREE_FALL])])
            self._conditions[key] = matrix, constant
        return self._conditions[key]


class _March:
    """The states of the feet along a motion: which feet stand, and where their pads grip.

    Attributes:
        feet: the linear systems.
        standing: (mounts,) whether each foot stands.
        anchor: (mounts, 3) displacement from its original place at which each pad grips its foot, along x and y [m].
        since: (mounts,) time at which each foot last lifted off [s].
        lifts: the lifts that have ended.
    """

    def __init__(self, feet: _Feet, begin: Array) -> None:
        mounts = len(feet.load)
        self.feet, self.anchor = feet, np.zeros((mounts, 3))
        self.standing = feet.force(self.anchor, begin)[:, FREE_FALL] >= -ROUNDING * np.abs(feet.load).max()
        self.since, self.lifts = np.zeros(mounts), list[_Lift]()

    def advance(self, state: Array, early: Array, late: Array, start: float, interval: float) -> Array:
        """The state (2 n,) at the end of an interval, over which the force goes from ``early`` to ``late``, through all switches of feet.

        Raises:
            PinpressError: a foot chatters, or the state is not finite.
        """
        done, fresh = 0.0, np.zeros(len(self.standing), dtype=bool)
        for _ in range(MOST_SWITCHES):
            (a, b, radius), rest = self.feet.matrices(self.standing), (1.0 - done) * interval
            constant = self.feet.constant(self.standing, self.anchor)
            force = early + done * (late - early) + constant, late + constant
            flow = partial(_Flow, a, b, radius, state, force, rest)
            matrices = self.feet.step(self.standing, interval) if done == 0.0 else None
            after = flow().state(1.0) if matrices is None else matrices[0] @ state + matrices[1] @ force[0] + matrices[2] @ force[1]
            if not np.isfinite(after).all():
                raise PinpressError("the vibration is not finite: the forces are too large for floating point")
            rates = a @ state + b @ force[0], a @ after + b @ force[1]
            switch = _first_switch(self.feet, self.standing, fresh, (state, after), rates, rest, flow)
            if switch is None:
                return after
            share, number, state = switch
            done += share * (1.0 - done)
            self._switch(number, state, start + done * interval)
            fresh = np.arange(len(self.standing)) == number
        raise PinpressError(
            f"mount {number + 1} chatters at {start:.6g} s, more than {MOST_SWITCHES} times between two states: give the reactions at more"
            " states, or the mounts damping along z"
        )

    def _switch(self, number: int, state: Array, instant: float) -> None:
        """Let a foot lift off or land."""
        self.standing = self.standing.copy()
        self.standing[number] = not self.standing[number]
        if not self.standing[number]:
            self.since[number] = instant
            return
        self.lifts.append(_Lift(number, float(self.since[number]), instant))
        stiff = self.feet.stiffness[number, :FREE_FALL]
        landing = (self.feet.rows[number] @ state[: len(state) // 2])[:FREE_FALL]
        slack = np.divide(self.feet.load[number, :FREE_FALL], stiff, out=np.zeros(2), where=stiff > 0)
        self.anchor[number, :FREE_FALL] = np.where(stiff > 0, landing - slack, 0.0)


def _repeating(feet: _Feet, wrench: Array, interval: float) -> Array:
    """Periodic state (2 n,) of the linear motion with all feet standing: one period under forces (states, n) returns to this state.

    The state of `steady_response` is not used, because loss factors act differently there: the motion would have to settle first, and its
    strokes would differ although no foot lifts off.

    Raises:
        PinpressError: a harmonic of the force meets a natural frequency without damping.
    """
    a, b, _ = feet.matrices(np.ones(len(feet.load), dtype=bool))
    free, early, late = step_matrices(a, b, interval)
    forced, whole = np.zeros(len(a)), np.linalg.matrix_power(free, len(wrench) - 1)
    for first, second in pairwise(wrench):
        forced = free @ forced + early @ first + late @ second
    try:
        begin = np.linalg.solve(np.eye(len(a)) - whole, forced)
    except np.linalg.LinAlgError:
        raise PinpressError(RESONANCE) from None
    if not np.isfinite(begin).all():
        raise PinpressError(RESONANCE)
    return np.asarray(begin)


def _march(feet: _Feet, wrench: Array, interval: float, begin: Array) -> _Course:
    """The motion under forces (states, n) that are linear in between, starting from a state (2 n,)."""
    n, march = len(begin) // 2, _March(feet, begin)
    states, force = np.zeros((len(wrench), 2 * n)), np.zeros((len(wrench), len(feet.load), 3))
    acceleration, state = np.zeros((len(wrench), n)), begin
    for k in range(len(wrench)):
        a, b, _ = feet.matrices(march.standing)
        states[k], acceleration[k] = state, (a @ state + b @ (wrench[k] + feet.constant(march.standing, march.anchor)))[n:]
        force[k] = np.where(march.standing[:, None], feet.force(march.anchor, state), 0.0)
        if k + 1 < len(wrench):
            state = march.advance(state, wrench[k], wrench[k + 1], k * interval, interval)
    end = (len(wrench) - 1) * interval
    hovering = [_Lift(int(number), float(march.since[number]), end) for number in np.flatnonzero(~march.standing)]
    return _Course(states, acceleration, force, march.lifts + hovering, march.anchor[:, :FREE_FALL])


def _first_switch(
    feet: _Feet,
    standing: NDArray[np.bool_],
    fresh: NDArray[np.bool_],
    ends: tuple[Array, Array],
    rates: tuple[Array, Array],
    length: float,
    flow: Callable[[], _Flow],
) -> tuple[float, int, Array] | None:
    """Share of an interval after which the first foot lifts off or lands, its number and the state at that instant; None if no foot
    switches.

    Args:
        feet: the feet.
        standing: whether each foot stands.
        fresh: feet that have switched at the start of the interval.
        ends: states at both ends of the interval.
        rates: rates of the states at both ends.
        length: length of the interval [s].
        flow: function that computes the exact motion over the interval.
    """
    matrix, constant = feet.holds(standing)
    first, last = (matrix @ each + constant for each in ends)
    first_rate, last_rate = (matrix @ each for each in rates)
    small = ROUNDING * np.abs(feet.load).max()
    if standing.all():  # a cubic lies within the convex hull of these Bezier points
        hull = first[0], last[0], first[0] + length / 3 * first_rate[0], last[0] - length / 3 * last_rate[0]
        if min(float(each.min()) for each in hull) > small:
            return None
    samples = np.linspace(0.0, 1.0, 9)
    s = samples[:, None, None]
    cubic = (1 - s) ** 2 * ((1 + 2 * s) * first + s * length * first_rate) + s**2 * ((3 - 2 * s) * last - (1 - s) * length * last_rate)
    margin = cubic.max(axis=1)  # (samples, mounts): a foot does not switch while this is positive
    margin[0] = np.where(fresh | (np.abs(margin[0]) < small), np.maximum(margin[0], small), margin[0])
    switching = np.flatnonzero((margin < 0).any(axis=0))
    if not len(switching):
        return None
    switches, exact = list[tuple[float, int]](), flow()
    for number in switching:
        sample = int((margin[:, number] < 0).argmax())
        if sample == 0:
            return 0.0, int(number), ends[0]

        def exact_margin(share: Array, number: int = int(number)) -> tuple[Array, Array]:
            values = matrix[:, number] @ exact.state(float(share[0])) + constant[:, number]
            larger = int(values.argmax())
            return values[[larger]], length * (matrix[larger, number] @ exact.rate(float(share[0])))[None]

        low, high = samples[[sample - 1]], samples[[sample]]
        if exact_margin(high)[0] >= 0:  # only the cubic is negative, not the exact motion
            continue
        if sample == 1 and exact_margin(low)[0] <= small:  # the margin grows from zero: start a little later
            low = 1e-6 * high  # a foot that has just switched may still be at its switching point
        root = low if exact_margin(low)[0] <= 0 else bracketed_roots(exact_margin, low, high, absolute=1e-13)
        switches.append((float(root[0]), int(number)))
    if not switches:
        return None
    first_share, mount = min(switches)
    return first_share, mount, exact.state(first_share)


class _Flow:
    """The exact motion over an interval in which the force is linear, as Taylor polynomials over short parts of the interval.

    Attributes:
        a: of x' = a x + b f.
        b: of x' = a x + b f.
        force: f (n,) at the start and at the end of the interval.
        length: length of the interval [s].
        polynomials: (parts, TERMS, 2 n) coefficients of the state, for powers of the share of each part.
    """

    def __init__(self, a: Array, b: Array, radius: float, state: Array, force: tuple[Array, Array], length: float) -> None:
        self.a, self.b, self.force, self.length = a, b, force, length
        parts = max(1, int(np.ceil(radius * length / REACH)))
        h, growing = length / parts, b @ (force[1] - force[0]) / parts
        self.polynomials = np.zeros((parts, TERMS, len(state)))
        for k, terms in enumerate(self.polynomials):
            terms[0] = state
            terms[1] = h * (a @ state + b @ force[0] + k * growing)
            terms[2] = 0.5 * h * (a @ terms[1] + growing)
            for order in range(3, TERMS):
                terms[order] = h / order * (a @ terms[order - 1])
            state = terms.sum(axis=0)

    def state(self, share: float) -> Array:
        """The state after a share of the interval."""
        parts = len(self.polynomials)
        part = min(int(share * parts), parts - 1)
        return np.asarray((share * parts - part) ** np.arange(TERMS) @ self.polynomials[part])

    def rate(self, share: float) -> Array:
        """The time derivative of the state after a share of the interval."""
        return np.asarray(self.a @ self.state(share) + self.b @ ((1.0 - share) * self.force[0] + share * self.force[1]))


def _repeats(system: MountedPress, ends: Array) -> tuple[Array, int | None]:
    """Change (strokes - 1,) of the states at the ends of strokes, and after how many strokes they repeat themselves."""
    factors = np.linalg.cholesky(system.stiffness), np.linalg.cholesky(system.mass)
    n = len(system.mass)
    energy = np.hstack([ends[:, :n] @ factors[0], ends[:, n:] @ factors[1]])[1:]
    size = float(np.linalg.norm(energy, axis=1).max()) or 1.0
    change = np.linalg.norm(np.diff(energy, axis=0), axis=1) / size
    # periods of up to eight strokes are checked
    for after in range(1, min(8, len(energy) - 1) + 1):
        if np.linalg.norm(energy[-1] - energy[-1 - after]) <= 1e-6 * size:
            return change, after
    return change, None
