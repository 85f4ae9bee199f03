"""Cases of stiff forces that act all the time: springs, dampers, speed laws, servos and friction sharp about standstill, for 2 s."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
from extremes.extreme_case import Case, Outcome
from extremes.extreme_crank_slide import CrankSlider, slope
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import pinpress as pp
from pinpress.drives.motors import ConstantTorque, ServoMotor
from pinpress.drives.protocol import SpeedTorqueDrive
from pinpress.loads.process import ForceInterval

MECHANISM = CrankSlider()
GROUP = "Stiff forces for 2 s: runs"
START, SPEED, FLYWHEEL, DURATION = 1.0, 7.0, 100.0, 2.0
BASE = -1.0  # height of the frame's end of a spring, below the slide [m]
ALLOWED = 1e-8  # rad at the end, of steps that err by 1e-11


@dataclass(frozen=True)
class SpeedLaw(SpeedTorqueDrive):
    """Torque gain x (wanted speed - speed)."""

    gain: float
    wanted: float
    inertia: float = 0.0
    rated_torque: float | None = None

    def torque(self, speed: Any, angle: Any = 0.0, time: Any = 0.0, state: Any = ()) -> Any:
        return self.gain * (self.wanted - speed)


@dataclass(frozen=True)
class Rubbing(SpeedTorqueDrive):
    """A torque less friction that passes through zero within the speed ``sharp``."""

    push: float
    friction: float
    sharp: float
    inertia: float = 0.0
    rated_torque: float | None = None

    def torque(self, speed: Any, angle: Any = 0.0, time: Any = 0.0, state: Any = ()) -> Any:
        return self.push - self.friction * np.tanh(speed / self.sharp)


@dataclass(frozen=True)
class GuideFriction:
    """Friction of the guide that passes through zero within the slide's speed ``sharp``."""

    friction: float
    sharp: float
    datum: float = 0.0

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return (ForceInterval(math.inf, -math.inf, self.force),)

    def force(self, height: Any, velocity: Any) -> Any:
        return -self.friction * np.tanh(velocity / self.sharp) + 0.0 * height


def between(stiffness: float, damping: float, start: float = START) -> pp.loads.SpringDamper:
    """A spring and damper below the slide, slack at the start."""
    slack = float(MECHANISM.slide(start)) - BASE
    return pp.loads.SpringDamper("frame", "slide", stiffness, damping, slack, point1=(0.0, 0.0, BASE))


def run(method: str, speed: float = SPEED, **scene: Any) -> pp.Run:
    found = pp.simulate(
        MECHANISM.press(), DURATION, speed=speed, angle=START, flywheel=pp.drives.Flywheel(FLYWHEEL), method=method, **scene
    )
    assert isinstance(found, pp.Run)
    return found


def total(q: Any) -> Any:
    return MECHANISM.inertia(q) + FLYWHEEL


def ends_at(expected: Callable[[], float], bound: float = ALLOWED) -> Callable[[pp.Run], Outcome]:
    return lambda found: Outcome(abs(float(found.crank_angle[-1]) - expected()), bound)


# ---------------------------------------------------------------------------------------------------------------------------- springs


def swung(stiffness: float, speed: float) -> float:
    """Crank angle at the end of undamped swings, by quadrature of the energy in thirty digits: Gauss-Legendre over the angle phi of
    q = middle + half sin(phi), in which the time between two stops is smooth."""
    mpmath.mp.dps = 30
    m = MECHANISM
    r, rod = mpmath.mpf(m.crank), mpmath.mpf(m.rod)

    def slide(q: Any) -> Any:
        return -r * mpmath.cos(q) - mpmath.sqrt(rod**2 - (r * mpmath.sin(q)) ** 2)

    slack = mpmath.mpf(float(m.slide(START)) - BASE) + mpmath.mpf(BASE)

    def potential(q: Any) -> Any:
        weights = m.gravity * (
            -m.crank_mass * m.crank_centre * r * mpmath.cos(q)
            + m.rod_mass * (-(1 - m.rod_centre) * r * mpmath.cos(q) + m.rod_centre * slide(q))
            + m.slide_mass * slide(q)
        )
        return weights + stiffness * (slide(q) - slack) ** 2 / 2

    def inertia(q: Any) -> Any:
        swing = r * mpmath.cos(q) / mpmath.sqrt(rod**2 - (r * mpmath.sin(q)) ** 2)
        lever, rest = r * mpmath.sin(q) * (1 + swing), 1 - m.rod_centre
        along, up = rest * r * mpmath.cos(q), rest * r * mpmath.sin(q) + m.rod_centre * lever
        crank = m.crank_inertia + m.crank_mass * (m.crank_centre * r) ** 2
        return crank + m.rod_mass * (along**2 + up**2) + m.rod_inertia * swing**2 + m.slide_mass * lever**2 + FLYWHEEL

    begin = mpmath.mpf(START)
    energy = potential(begin) + inertia(begin) * mpmath.mpf(speed) ** 2 / 2
    size = float(np.sqrt(2 * float(inertia(begin)) * 0.5 * speed**2 / (stiffness * MECHANISM.lever(START) ** 2)))
    size += abs(float(slope(MECHANISM.potential, START))) / (stiffness * float(MECHANISM.lever(START)) ** 2)

    def stop(way: int) -> Any:
        if speed == 0.0 and (slope(MECHANISM.potential, START) > 0) == (way > 0):
            return begin
        ends = (begin + way * size / 10, begin + 3 * way * size)
        return mpmath.findroot(lambda q: (potential(q) - energy) / energy, ends, solver="anderson")

    low, high = stop(-1), stop(1)
    middle, half = (low + high) / 2, (high - low) / 2

    def pace(phi: Any) -> Any:
        q = middle + half * mpmath.sin(phi)
        left = energy - potential(q)
        if left <= 0:  # at a stop itself: its neighbour's value
            return pace(phi * (1 - mpmath.mpf(10) ** -8))
        return half * mpmath.cos(phi) * mpmath.sqrt(inertia(q) / (2 * left))

    def taken(phi: Any) -> Any:
        """Time from the lower stop."""
        return mpmath.quad(pace, [-mpmath.pi / 2, *([0] if phi > 0 else []), phi], maxdegree=5)

    way_up = taken(mpmath.pi / 2)
    at_start = way_up if begin == high else taken(mpmath.asin((begin - middle) / half)) if begin != low else mpmath.mpf(0)
    phase = (at_start + DURATION) % (2 * way_up)
    since = phase if phase <= way_up else 2 * way_up - phase
    phi = mpmath.findroot(lambda p: (taken(p) - since) / way_up, (since / way_up - mpmath.mpf(1) / 2) * mpmath.pi)
    return float(middle + half * mpmath.sin(phi))


def spring(stiffness: float, speed: float) -> Case:
    return Case(
        GROUP,
        f"undamped spring of {stiffness:.0e} N/m" + (", from rest" if speed == 0 else ""),
        f"angle after thousands of swings by quadrature in thirty digits, {ALLOWED:.0e} rad",
        lambda method: run(method, speed, loads=[between(stiffness, 0.0)]),
        ends_at(lambda: swung(stiffness, speed)),
        ("auto",),
    )


def damped(stiffness: float) -> Case:
    def expected() -> float:
        def force(q: float) -> float:
            lever = float(MECHANISM.lever(q))
            return float(slope(MECHANISM.potential, q)) + stiffness * (float(MECHANISM.slide(q)) - float(MECHANISM.slide(START))) * lever

        return float(brentq(force, START - 0.1, START + 0.1, xtol=1e-15))

    return Case(
        GROUP,
        f"spring of {stiffness:.0e} N/m, its damper {1e-3 * stiffness:.0e} N s/m",
        f"the crank comes to rest where the spring bears the weights, {ALLOWED:.0e} rad",
        lambda method: run(method, loads=[between(stiffness, 1e-3 * stiffness)]),
        ends_at(expected),
        ("auto", "implicit"),
    )


# --------------------------------------------------------------------------------------------------------------- dampers, laws, servos


def damper(damping: float) -> Case:
    """The torque creeps against the damper: c s'^2 w = T - V' - I w w' - I' w^2 / 2, of which the last two are in the square of 1/c and are
    taken at the w of the first ones. Before that the crank comes to a stop within I w / (c s'^2)."""
    torque = 5000.0

    def creep(q: float) -> float:
        return (torque - float(slope(MECHANISM.potential, q))) / (damping * float(MECHANISM.lever(q)) ** 2)

    def corrected(q: float) -> float:
        w, step = creep(q), 1e-6
        slower = (creep(q + step) - creep(q - step)) / (2 * step)
        held = float(total(q)) * w * slower + 0.5 * float(slope(MECHANISM.inertia, q)) * w * w
        return w - held / (damping * float(MECHANISM.lever(q)) ** 2)

    def expected() -> float:
        stopping = float(total(START)) * (SPEED - creep(START)) / (damping * float(MECHANISM.lever(START)) ** 2)
        rates = solve_ivp(lambda t, q: [corrected(float(q[0]))], (0, DURATION), [START + stopping], method="DOP853", rtol=1e-12, atol=1e-14)
        return float(rates.y[0, -1])

    return Case(
        GROUP,
        f"damper of {damping:.0e} N s/m",
        f"creep under the torque, to the square of 1/c, {ALLOWED:.0e} rad",
        lambda method: run(method, drive=ConstantTorque(torque), loads=[between(0.0, damping)]),
        ends_at(expected),
        ("auto", "implicit", "constraint"),
    )


def law(gain: float) -> Case:
    """The speed is lower than wanted by the torque of the motion at that speed, divided by the gain."""

    def expected() -> float:
        def lag(q: float) -> float:
            return SPEED - float(MECHANISM.torque(q, SPEED, 0.0)) / gain

        def late(q: float) -> float:
            parts = pairwise(np.linspace(START, q, 9).tolist())
            return sum(quad(lambda x: 1 / lag(x), a, b, epsabs=0.0, epsrel=1e-13)[0] for a, b in parts) - DURATION

        return float(brentq(late, START + 0.9 * SPEED * DURATION, START + 1.1 * SPEED * DURATION, xtol=1e-14))

    return Case(
        GROUP,
        f"speed law of {gain:.0e} N m s",
        f"speed wanted less torque by gain, the time by quadrature, {ALLOWED:.0e} rad",
        lambda method: run(method, drive=SpeedLaw(gain, SPEED)),
        ends_at(expected),
        ("auto", "implicit", "constraint"),
    )


def servo(stiffness: float) -> Case:
    """The shaft is behind its program by the torque of the motion divided by the stiffness; this error's own rate, times the damping,
    counts too."""
    half, damping = 0.5 * DURATION, 0.1 * stiffness
    motor = ServoMotor((0.0, half, DURATION), (START, START + 1.2, START + 3.0), stiffness, damping, 1e15)

    def lag(time: float) -> float:
        step, program = 1e-5, [float(np.ravel(motor.program(time + d * 1e-5)[0])[0]) for d in (-1, 0, 1)]
        speed = [float(np.ravel(motor.program(time + d * step)[1])[0]) for d in (-1, 0, 1)]
        acceleration = (speed[2] - speed[0]) / (2 * step)
        return float(MECHANISM.torque(program[1], speed[1], acceleration) + FLYWHEEL * acceleration) / stiffness

    def expected() -> float:
        at, step = 0.75 * DURATION, 1e-4
        rate = (lag(at + step) - lag(at - step)) / (2 * step)
        return float(np.ravel(motor.program(at)[0])[0]) - lag(at) + damping / stiffness * rate

    def judge(found: pp.Run) -> Outcome:
        at = int(np.abs(found.time - 0.75 * DURATION).argmin())
        assert found.time[at] == 0.75 * DURATION
        return Outcome(abs(float(found.crank_angle[at]) - expected()), ALLOWED)

    return Case(
        GROUP,
        f"servo of {stiffness:.0e} N m/rad",
        f"behind its program by torque / stiffness, {ALLOWED:.0e} rad",
        lambda method: run(method, 0.0, drive=motor, points=121),
        judge,
        ("auto", "constraint"),
    )


# --------------------------------------------------------------------------------------------------------------------------- friction


def friction(sharp: float) -> Case:
    """Constant friction brings the crank to rest, from where it creeps with the speed at which the friction bears the weights."""
    size = 30_000.0

    def expected() -> float:
        def rates(t: float, y: Any) -> tuple[float, float]:
            q, w = float(y[0]), float(y[1])
            return w, float((-size - 0.5 * slope(MECHANISM.inertia, q) * w * w - slope(MECHANISM.potential, q)) / total(q))

        def stopped(t: float, y: Any) -> float:
            return float(y[1])

        stopped.terminal = True  # type: ignore[attr-defined]
        rest = solve_ivp(rates, (0, DURATION), [START, SPEED], method="DOP853", rtol=1e-12, atol=1e-13, events=stopped)
        at = float(rest.y[0, -1])
        return at - sharp * math.atanh(float(slope(MECHANISM.potential, at)) / size) * (DURATION - float(rest.t[-1]))

    return Case(
        GROUP,
        f"friction sharp within {sharp:.0e} rad/s",
        f"stop under constant friction, then creep, {ALLOWED:.0e} rad",
        lambda method: run(method, drive=Rubbing(0.0, size, sharp)),
        ends_at(expected),
        ("auto", "implicit"),
    )


def guided(sharp: float) -> Case:
    """The same as friction that jumps where the slide turns back, in a run that turns: integrated from dead centre to dead centre."""
    size, torque = 1e4, 5000.0

    def expected() -> float:
        y, time, ways = np.array([START, SPEED]), 0.0, math.floor(START / math.pi)
        while time < DURATION:
            sign = 1.0 if ways % 2 == 0 else -1.0

            def rates(t: float, y: Any, sign: float = sign) -> tuple[float, float]:
                q, w = float(y[0]), float(y[1])
                push = torque - size * sign * float(MECHANISM.lever(q))
                return w, float((push - 0.5 * slope(MECHANISM.inertia, q) * w * w - slope(MECHANISM.potential, q)) / total(q))

            def centre(t: float, y: Any, at: float = (ways + 1) * math.pi) -> float:
                return float(y[0]) - at

            centre.terminal = True  # type: ignore[attr-defined]
            part = solve_ivp(rates, (time, DURATION), y, method="DOP853", rtol=1e-12, atol=1e-13, events=centre)
            y, time, ways = part.y[:, -1], float(part.t[-1]), ways + 1
        return float(y[0])

    return Case(
        GROUP,
        f"friction of the guide sharp within {sharp:.0e} m/s",
        f"friction that jumps at the dead centres, {ALLOWED:.0e} rad",
        lambda method: run(method, drive=ConstantTorque(torque), loads=[GuideFriction(size, sharp)]),
        ends_at(expected),
        ("auto", "implicit"),
    )


def refused(stiffness: float) -> Case:
    """What would be followed swing by swing, thousands of times: the frequency is that of the linear equation."""
    frequency = math.sqrt(stiffness * float(MECHANISM.lever(START)) ** 2 / float(total(START))) / (2 * math.pi)

    def judge(found: Any) -> Outcome:
        said = str(found)
        if not isinstance(found, pp.SimulationError) or "vibrate at" not in said:
            return Outcome(math.inf, 0.1, "no error, but a result" if isinstance(found, pp.Run) else said[:60])
        named = float(said.split("vibrate at ")[1].split(" Hz")[0])
        return Outcome(abs(named / frequency - 1), 0.1, f"SimulationError: vibrates at {named:g} Hz")

    return Case(
        GROUP,
        f"spring of {stiffness:.0e} N/m, hardly damped by a motor",
        "refused, with the frequency (a tenth)",
        lambda method: run(method, drive=SpeedLaw(100.0, SPEED), loads=[between(stiffness, 0.0)]),
        judge,
        ("auto",),
        refused=True,
    )


CASES = [
    *(spring(stiffness, SPEED) for stiffness in (1e10, 1e12, 1e13)),
    spring(1e12, 0.0),
    *(damped(stiffness) for stiffness in (1e10, 1e12, 1e13)),
    *(damper(damping) for damping in (1e10, 1e11)),
    *(law(gain) for gain in (1e9, 1e10, 1e11)),
    *(servo(stiffness) for stiffness in (1e9, 1e10, 1e11)),
    *(friction(sharp) for sharp in (1e-6, 1e-9)),
    guided(1e-9),
    refused(1e12),
]
