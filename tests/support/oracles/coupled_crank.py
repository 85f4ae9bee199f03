"""The textbook crank-slide with a flywheel, lossy gears, clutch, brake and one-way loads, without pinpress.

Wherever the crank rests, or both sides of the clutch have the same speed, each combination of turning, slipping and holding is tried, and
the one whose accelerations agree with it happens. SciPy integrates the equation of `textbook_crank_slide` from one decision to the next.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from .textbook_crank_slide import acceleration, height, lever

AHEAD = 1e-9  # crank angle [rad], height [m] and time [s] by which a border counts as passed


class Load(NamedTuple):
    """A force on the slide between two heights [N, m], upwards positive, on the way down or up."""

    upper: float
    lower: float
    force: Callable[[float], float]
    falling: bool = True


@dataclass
class Coupled:
    """Torques in N m at the crank, flywheel in kg m2.

    drive: of the speed of the flywheel and the direction, +1 or -1, in which it turns; at rest it matters.
    clutch: capacity over the time; infinite: flywheel and crank are one.
    brake: the same.
    breaks: times at which these change sharply [s].
    """

    flywheel: float
    drive: Callable[[float, int], float] = lambda speed, side: 0.0
    clutch: Callable[[float], float] = lambda time: math.inf
    brake: Callable[[float], float] = lambda time: 0.0
    breaks: Sequence[float] = ()
    loads: Sequence[Load] = ()

    def run(self, duration: float, angle: float, speed: float, own: float | None = None) -> tuple[float, float, float]:
        """Angle and speed of the crank, and speed of the flywheel, at the end; ``own``: speed of the flywheel at the start."""
        time, q, w = 0.0, angle, speed
        wheel, lost = speed if own is None else own, 0
        for _ in range(1000):
            if time >= duration - AHEAD:
                return q, w, wheel
            until = min([b for b in self.breaks if b > time + AHEAD] + [duration])
            now = lambda t, start=time, end=until: min(max(t, start + AHEAD), end - AHEAD)  # noqa: E731
            way, slip, side = self._happens(now(time), q, w, wheel, lost)
            falling = way * lever(q + AHEAD * way, math) < 0
            acting = [load for load in self.loads if self._acts(load, q, way)]

            def rates(t, y, way=way, slip=slip, side=side, acting=acting, now=now):
                return [y[1], *self._rates(now(t), y[0], y[1], y[2], way, slip, side, acting)]

            events = self._events(q, way, slip, side, falling, acting, now)
            found = solve_ivp(rates, (time, until), [q, w, wheel], "DOP853", rtol=1e-11, atol=1e-12, events=events, max_step=0.05)
            time, (q, w, wheel) = float(found.t[-1]), map(float, found.y[:, -1])
            passed = {event.name for event, times in zip(events, found.t_events, strict=True) if len(times)}
            w = 0.0 if "rest" in passed else w
            wheel = w if "grip" in passed or slip == 0 else 0.0 if "stands" in passed else wheel
            lost = (
                int(math.copysign(1, self.drive(wheel, side) - self.flywheel * rates(time, [q, w, wheel])[2])) if "slips" in passed else 0
            )
        raise AssertionError("it switches without end")

    def _acts(self, load, q, way):
        ahead = q + AHEAD * way
        return load.lower < height(ahead, math) <= load.upper and load.falling == (way * lever(ahead, math) < 0)

    def _resisting(self, time, q, way, acting):
        return sum(load.force(height(q, math)) * lever(q, math) for load in acting) - way * self.brake(time)

    def _rates(self, time, q, w, wheel, way, slip, side, acting):
        """Accelerations of crank and flywheel."""
        torque, through = self.drive(wheel, side), slip * self.clutch(time) if slip else 0.0
        if slip:
            crank = acceleration(q, w, self._resisting(time, q, way, acting) + through, 0.0) if way else 0.0
            return crank, (torque - through) / self.flywheel
        crank = acceleration(q, w, self._resisting(time, q, way, acting) + torque, self.flywheel) if way else 0.0
        return crank, crank

    def _happens(self, time, q, w, wheel, lost):
        """Direction of the crank, of the slip and of the flywheel, -1, 0 or 1 each; ``lost``: of the slip, where the clutch lets go."""
        sign = lambda value: int(math.copysign(1, value))  # noqa: E731
        ways = (sign(w),) if w else (1, -1, 0)
        slips = (0,) if math.isinf(self.clutch(time)) else (sign(wheel - w),) if wheel != w else (lost,) if lost else (1, -1, 0)
        for way in ways:
            for slip in slips:
                sides = (sign(wheel),) if wheel else (1, -1) if slip else (way,)
                for side in sides:
                    if self._agrees(time, q, w, wheel, way, slip, side, bool(lost)):
                        return way, slip, side
        raise AssertionError(f"nothing can happen at {time}, {q}, {w}, {wheel}")

    def _agrees(self, time, q, w, wheel, way, slip, side, lost):
        acting = [load for load in self.loads if self._acts(load, q, way)]
        crank, shaft = self._rates(time, q, w, wheel, way, slip, side, acting)
        if not way and min(self._clear(time, q, wheel, slip)) < 0:
            return False
        if way and not w and not crank * way > 0:
            return False
        if slip and not wheel and not shaft * side > 0:
            return False
        if slip and wheel == w:
            return lost or (shaft - crank) * slip > 0
        return bool(slip) or abs(self.drive(wheel, side) - self.flywheel * shaft) <= self.clutch(time)

    def _clear(self, time, q, wheel, slip):
        """By how much what holds the crank at rest exceeds what it takes, against a start forward and back [rad/s2]."""
        found = []
        for way in (1, -1):
            acting = [load for load in self.loads if self._acts(load, q, way)]
            found.append(-way * self._rates(time, q, 0.0, wheel, way, slip, way if not wheel else int(math.copysign(1, wheel)), acting)[0])
        return found

    def _events(self, q, way, slip, side, falling, acting, now):
        found = []

        def add(name, value):
            value.name, value.terminal, value.direction = name, True, -1
            found.append(value)

        if way:
            add("rest", lambda t, y: way * y[1])
            at = height(q + AHEAD * way, math)
            edges = {edge for load in self.loads for edge in (load.upper, load.lower) if (edge < at if falling else edge > at)}
            if edges:
                edge = max(edges) if falling else min(edges)
                add("edge", lambda t, y: (height(y[0], math) - edge) * (1 if falling else -1))
            turn = math.pi * ((math.floor if way < 0 else math.ceil)((q + 2 * AHEAD * way) / math.pi))
            add("turn", lambda t, y: way * (turn - y[0]))
        else:
            add("start", lambda t, y: min(self._clear(now(t), y[0], y[2], slip)))
        if slip:
            add("grip", lambda t, y: slip * (y[2] - y[1]))
            add("stands", lambda t, y: side * y[2])
        elif not math.isinf(self.clutch(now(0.0))):
            add(
                "slips",
                lambda t, y: (
                    self.clutch(now(t))
                    - abs(self.drive(y[2], side) - self.flywheel * self._rates(now(t), y[0], y[1], y[2], way, 0, side, acting)[1])
                ),
            )
        return found


def kloss(power: float, rated_speed: float, ratio: float, efficiency: float) -> Callable[[float, int], float]:
    """Torque at the crank of an induction motor of four poles at 50 Hz behind gears with losses (Kloss), for `Coupled.drive`."""
    synchronous = np.pi * 50.0
    lag = (synchronous - rated_speed) * (2.5 + math.sqrt(2.5**2 - 1))

    def torque(speed: float, side: int) -> float:
        behind = synchronous - ratio * speed
        own = ratio * 2 * 2.5 * power / rated_speed * behind * lag / (behind**2 + lag**2)
        return own * efficiency if own * (speed or side * ratio) >= 0 else own / efficiency

    return torque
