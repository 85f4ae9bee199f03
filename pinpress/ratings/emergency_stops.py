"""Emergency stop: how far a press runs on after the signal, and the safety distance that its stopping time demands.

At the signal the clutch opens. The brake closes after a delay, and its torque rises linearly to the full torque. Every stop is a run of
`simulate`. The longest stop begins where the weight helps least, so the worst signal is searched, not read from a grid. Where the brake
does not hold the press, the time to standstill grows without bound, and no time is given.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..common import plausibility
from ..common.arguments import in_unit, positive, suitable_numbers, truth_value, typed
from ..common.errors import PinpressError, caution, cautions_collected
from ..common.frozen import FrozenMapping, read_only
from ..common.numerics import sign_change
from ..common.quantities import GRAVITY, Array
from ..common.results import Record, Tabular
from ..common.tables import Columns
from ..drives.transmission import Brake, Flywheel, SwitchPoint
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.slide_path import dead_centres, turning_points
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Load
from ..simulation.reduced_model import INERTIA, reduced_model_of
from ..simulation.simulate import simulate
from .permissible_force import refuse_unrated
from .safety_distance import LONG, SafetyDistance, length_argument, not_negative, safety_distance

FULL, HALF, UNLOADED = "all springs", "half of the springs", "without the loads"
ACTING = {FULL: "all springs and loads", HALF: "half of the springs and all loads", UNLOADED: "all springs and no loads"}
STEP = math.radians(5.0)  # between signals of the closing stroke, twice as much elsewhere; the worst one is searched between two of them
STATICS = math.radians(0.5)  # between poses in which the holding torque is computed; edges and peaks between them are searched
LONGER = 1e-7  # by which a stop must last longer than another one to count as longer [s]
INSTANTS = 257  # of a stop among which the one is where the crank turns back: it hardly moves there
NARROW = 1e-10  # bracket of a searched angle [rad]
BARELY = 1.01  # holding torque margin below which stops grow long in so narrow a range of signals that one may hide another


@dataclass(frozen=True, repr=False)
class Stop(Record, units={"signal": "rad", "time": "s", "overrun": "rad", "travel": "m"}):
    """A stop after a signal.

    Attributes:
        signal: crank angle at the signal [rad].
        time: from the signal to standstill [s].
        overrun: angle from the signal to standstill, positive in the direction of running; negative if the crank turns back before the
            brake closes [rad].
        travel: way of the slide during the stop, down and up added [m].
    """

    signal: float
    time: float
    overrun: float
    travel: float


StopAfter = Callable[[float], Stop]
"""The stop after a signal at a crank angle [rad]."""


@dataclass(frozen=True, eq=False, repr=False)
class Braking(Tabular):
    """The stops of a press with one state of its brake and loads. All arrays are read-only.

    Attributes:
        signal: (n,) crank angles of the signals [rad], the searched ones of all cases among them; empty, as the next arrays, if the brake
            does not hold.
        torque: of the closed brake at the crank [N m].
        margin: torque / largest torque by which weights and loads turn the standing crank [-]; infinite if nothing turns it.
        slips: crank angles between which the brake does not hold the press [rad], and which way the press then turns. Empty if it holds.
        time: (n,) from each signal to standstill [s].
        overrun: (n,) angle that the crank turns during the stop [rad].
        travel: (n,) way of the slide during the stop [m].
        worst: longest stop by time after a signal of the closing stroke; None if the brake does not hold.
        worst_elsewhere: longest stop of all, if its signal is not in the closing stroke; else None.
        top_stop: stop that ends at top dead centre; the top-stop cam gives its signal. None if there is no such stop.
    """

    signal: Array
    torque: float
    margin: float
    slips: tuple[tuple[float, float, str], ...]
    time: Array
    overrun: Array
    travel: Array
    worst: Stop | None
    worst_elsewhere: Stop | None
    top_stop: Stop | None

    @property
    def title(self) -> str:
        return f"Braking: {self.torque:.6g} N m, {self.margin:.4g} times the holding torque"

    def columns(self) -> dict[str, Array]:
        """A row for each signal."""
        stops = {"time [s]": self.time, "overrun [rad]": self.overrun, "travel [m]": self.travel}
        return {"crank_angle [rad]": self.signal, **stops}


@dataclass(frozen=True, eq=False, repr=False)
class StoppingTimes(OfPress, Tabular):
    """The stops of a press after n signals over a period. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        speed: of the crank at the signal, negative backwards [rad/s].
        delay: from the signal until the brake begins to close [s].
        rise: in which the brake's torque then rises linearly [s].
        control: response time of the control [s].
        device: response time of the protective device, such as a light curtain [s].
        monitor: time by which a stop may last longer before the brake monitor reports it [s]; None: no monitor.
        inertia: of what stays on the crank when the clutch is open, reduced to the crank [kg m2].
        loads: springs, balance cylinders and constant forces, as given.
        signal: (n,) crank angles of the signals, unwrapped from a top dead centre in the direction of running [rad].
        closing: (n,) whether the slide closes there; True at the dead centres too.
        cases: name -> stops: "all springs", "half of the springs", and with loads also "without the loads" (a failed balance cylinder).
    """

    _press: Linkage
    speed: float
    delay: float
    rise: float
    control: float
    device: float
    monitor: float | None
    inertia: float
    loads: tuple[Load, ...]
    signal: Array
    closing: Array
    cases: Mapping[str, Braking]

    @property
    def worst(self) -> Stop:
        """The longest stop after a signal of the closing stroke, with all springs."""
        worst = self.cases[FULL].worst
        assert worst is not None  # a brake that does not hold is refused
        return worst

    @property
    def title(self) -> str:
        signal = self.worst.signal % (2 * np.pi * self._press.period_turns)
        return (
            f"StoppingTimes of {self.press_name}: at most {1e3 * self.worst.time:.1f} ms, after a signal at {math.degrees(signal):.2f} deg"
        )

    def columns(self) -> Columns:
        """A row for each signal; times, overruns and ways of each case whose brake holds."""
        found: dict[str, Array | list[str]] = {"crank_angle [rad]": self.signal}
        found["closing"] = ["yes" if each else "no" for each in self.closing]
        for name, case in self.cases.items():
            if case.worst is not None:
                stops = {head.replace(" [", f", {name} ["): column for head, column in case.columns().items()}
                found |= dict(list(stops.items())[1:])
        return found

    def distance(
        self,
        edition: str,
        *,
        resolution: float | None = None,
        two_hand: bool = False,
        reach: float | None = None,
        supplement: float | None = None,
    ) -> SafetyDistance:
        """Evaluate the formula of a standard for the distance of a protective device from the danger zone.

        The result is no advice: the formula uses a computed stopping time, but the stopping time measured on the press decides.

        Args:
            edition: "ISO 13855:2010", "ISO 13855:2024", "ANSI B11.19" or "OSHA 1910.217".
            resolution: detection capability of a curtain at a right angle to the approach [m]. ISO 13855:2010 and ANSI B11.19 need it.
            two_hand: whether the device is a two-hand control, for ISO 13855.
            reach: D_DS of ISO 13855:2024, which its tables give for the device [m].
            supplement: Z of ISO 13855:2024 [m].

        Raises:
            PinpressError: the edition is unknown, or a value is missing, not as described, or not used by the formula of the edition.

        Warns:
            PinpressWarning: half of the springs do not hold the press, all springs hold it only with the loads, a stop takes more than 2 s,
                a stop outside of the closing stroke is longer, or the resolution is below 5 mm.
        """
        given = {"resolution": resolution, "reach": reach, "supplement": supplement}
        lengths = {name: length_argument(name, value) for name, value in given.items() if value is not None}
        for name, what in ((HALF, "half of the springs"), (UNLOADED, "without the loads the brake")):
            if name in self.cases and self.cases[name].slips:
                caution(f"{what} {_slipping(self.cases[name])}: a distance does not make up for that; give a stronger brake")
        found: dict[str, SafetyDistance | None] = dict.fromkeys(self.cases)
        for name, case in self.cases.items():
            if case.worst is None:
                continue
            if (other := case.worst_elsewhere) is not None:
                place = math.degrees(other.signal % (2 * np.pi * self._press.period_turns))
                outside = f"{other.time:.4g} s after a signal at {place:.2f} deg, outside of the closing stroke"
                caution(f"{name}: a stop takes {outside}, and the distance is that of {case.worst.time:.4g} s")
            in_quarter = float(np.interp(0.5 * np.pi, np.abs(self.signal - self.signal[0]), case.time))
            times = {"stopping": case.worst.time, "at 90 deg": in_quarter, "control": self.control, "device": self.device}
            with nullcontext() if name == FULL else cautions_collected():  # the hint at ms is given once
                found[name] = safety_distance(edition, times, self.monitor, lengths, truth_value("two_hand", two_hand), ACTING[name])
        whole = found.pop(FULL)
        assert whole is not None  # `stopping` refuses a brake that does not hold with all springs
        return replace(whole, failed=found)


@typed
def stopping(
    press: Linkage,
    speed: float,
    brake: float,
    delay: float,
    rise: float,
    *,
    control: float = 0.0,
    device: float = 0.0,
    monitor: float | None = None,
    inertia: float = 0.0,
    loads: Sequence[Load] = (),
) -> StoppingTimes:
    """Find time, overrun and way of the slide to standstill after a signal at any crank angle, with all and with half of the springs.

    Friction of bearings and process forces shorten a stop and are left out. Motor and flywheel are left out too: the clutch is open.

    Args:
        press: a press with one crank and a slide.
        speed: of the crank at the signal, negative backwards [rad/s].
        brake: torque of the brake at the crank, with all springs [N m].
        delay: from the signal of the control until the brake begins to close [s].
        rise: in which its torque then rises linearly [s].
        control: response time of the control, only for the distance [s].
        device: response time of the protective device, only for the distance [s].
        monitor: time by which a stop may last longer before the brake monitor reports it, only for the distance [s]; None: no monitor.
        inertia: of brake disc, driven plate of the clutch, and all else that stays on the crank and is not in the press's file [kg m2].
        loads: springs, balance cylinders and constant forces; a further case leaves all of them out.

    Raises:
        PinpressError: the press has no crank or no slide, an argument is not as described, or the brake does not hold the press at every
            angle. The message names the angles.
        SimulationError: see `simulate`.
        SingularityError: the linkage locks within the period.

    Warns:
        PinpressWarning: in some case the brake barely holds the press: after some signals a stop may then be longer than the longest one
            that was found.
    """
    press.refuse_several_drivers("a stop is of one crank; simulate(press, ..., drive={...}) runs several")
    press.refuse_sliding_driver("a stop is of a crank; simulate(press, ...) runs others")
    wanted = "one number that is not zero [rad/s], e.g. 50 * pinpress.RPM"
    speed = float(suitable_numbers("speed", in_unit("speed", speed, "rad/s"), wanted, suits=lambda value: 1e-9 <= abs(value) <= 1e9))
    plausibility.speeds("speed", speed)
    torque, inertia = positive("brake", brake, "N m"), not_negative("inertia", inertia, "kg m2")
    given = {"delay": delay, "rise": rise, "control": control, "device": device}
    times = {name: not_negative(name, value, "s") for name, value in given.items()}
    for name, time in times.items():
        if time > LONG:
            raise PinpressError(f"{name} is {time:g} s, and no press takes as long: if ms are meant, write {time:g}e-3")
    weight = GRAVITY * float(press.model.inertias[press.slide_guide.joint + 1].mass)
    plausibility.torque("brake", torque, 0.5 * weight * dead_centres(press).stroke)
    refuse_unrated(press, loads, {}, at_speed=True)
    signal, closing = _signals(press, math.copysign(1.0, speed))
    runs = {FULL: (torque, tuple(loads)), HALF: (0.5 * torque, tuple(loads))} | ({UNLOADED: (torque, ())} if loads else {})
    cases, brakes = {}, {}
    for name, (effort, acting) in runs.items():
        brakes[name] = BrakedPress(press, speed, effort, times["delay"], times["rise"], inertia, acting)
        cases[name] = _braking(brakes[name], signal, closing)
        if name == FULL and cases[name].slips:
            raise PinpressError(f"the brake of {torque:g} N m {_slipping(cases[name])}: give a stronger brake, or a balance cylinder")
        if cases[name].worst is not None and cases[name].margin < BARELY:
            caution(
                f"{name}: the brake barely holds the press, with {cases[name].margin:.6g} times its holding torque. In narrow ranges of the"
                " signal a stop then takes very long, and a longer one than the longest here may be missed: give a stronger brake"
            )
    searched = _searched(cases, signal, closing, math.copysign(2 * np.pi * press.period_turns, speed))
    cases = {name: _with_stops(brakes[name], case, searched) for name, case in cases.items()}
    signal, closing = np.append(signal, [*searched]), np.append(closing, [*searched.values()])
    order = np.argsort(math.copysign(1.0, speed) * signal)
    signal, closing = signal[order], closing[order]
    return StoppingTimes(
        _press=press,
        speed=speed,
        **times,
        monitor=None if monitor is None else not_negative("monitor", monitor, "s"),
        inertia=inertia,
        loads=tuple(loads),
        signal=read_only(signal),
        closing=read_only(closing),
        cases=FrozenMapping(cases),
    )


# ------------------------------------------------------------------------------------------------------------------------------- stops


class BrakedPress(NamedTuple):
    """A press that runs at a speed until its brake closes. Attributes as the arguments of `stopping`."""

    press: Linkage
    speed: float
    torque: float
    delay: float
    rise: float
    inertia: float
    loads: tuple[Load, ...]

    def holding_torque(self, angles: Array) -> Array:
        """Torque (n,) that holds the standing crank at angles (n,) [N m]."""
        motion = motion_through_change_points(self.press, angles, 1.0)
        still = replace(motion, crank_speed=0 * motion.crank_speed, v=0 * motion.v, a=0 * motion.a)
        return inverse_dynamics(self.press, still, self.loads, bearings=()).driving_torque

    def longest(self, largest: float) -> float:
        """An upper bound of the time to standstill [s], if the brake holds more than the ``largest`` holding torque [N m].

        With J(phi) and u = w sqrt(J) the equation of motion is u' = -(G + T)/sqrt(J), so that u falls at least at (T - G_max)/sqrt(J_max).
        """
        inertia = float(reduced_model_of(self.press).middles[INERTIA].max()) + self.inertia
        fall = 2 * np.pi * self.press.period_turns * largest  # energy that weights and loads give at most [J]
        energy = inertia * self.speed**2 + 2 * fall
        return self.delay + self.rise + 1.5 * math.sqrt(energy * inertia) / (self.torque - largest)

    def stop(self, signal: float, until: float) -> Stop:
        """The stop after a signal at a crank angle [rad]; it is over at a time [s]."""
        brake = Brake(self.torque, closes=SwitchPoint(time=self.delay), rise=self.rise)
        wheel = Flywheel(self.inertia) if self.inertia else None
        run = simulate(self.press, until, speed=self.speed, angle=signal, flywheel=wheel, brake=brake, loads=self.loads, tolerance=1e-12)
        path = run.trajectory
        moving = path.at(0.5 * (path.borders[:-1] + path.borders[1:]), complete=False).speed[0] != 0.0
        time = float(path.borders[np.flatnonzero(moving)[-1] + 1])  # a press that slips back and stops again stands only then
        angles = path.at(np.linspace(0.0, time, INSTANTS), complete=False).position[0]
        back = 1 + np.flatnonzero(np.diff(angles[:-1]) * np.diff(angles[1:]) < 0.0)  # a slow press may turn back before its brake closes
        places = [signal, *angles[back].tolist(), float(angles[-1])]
        travel = sum(_travel(self.press, start, end) for start, end in pairwise(places))
        return Stop(signal, time, math.copysign(1.0, self.speed) * (places[-1] - signal), travel)


def _travel(press: Linkage, start: float, end: float) -> float:
    """Way of the slide between two crank angles, down and up [m]."""
    ends, period = turning_points(press), 2 * np.pi * dead_centres(press).turns
    low, high = min(start, end), max(start, end)
    turns = [place + k * period for place in ends.places for k in range(*(math.floor((x - place) / period) + 1 for x in (low, high)))]
    path = motion_through_change_points(press, np.array([low, *sorted(turns), high]), 1.0).slide_position
    return float(np.abs(np.diff(path)).sum())


def _signals(press: Linkage, sense: float) -> tuple[Array, Array]:
    """Crank angles (n,) over a period from a top dead centre in the sense of running (1 or -1), and whether the slide closes there."""
    ends, points = dead_centres(press), turning_points(press)
    stroke, whole = 2 * np.pi * ends.turns, 2 * np.pi * press.period_turns
    uppers, lowers = (np.array([points.places[pair[k]] for pair in points.strokes]) for k in (0, 1))
    spans = []
    for upper in uppers:
        start = sense * (upper - ends.top_angle) % stroke
        length = float((sense * (lowers - upper) % stroke).min())
        spans += [(start + k * stroke, start + k * stroke + length) for k in range(round(whole / stroke))]
    after = np.unique(np.concatenate([np.arange(0.0, whole, STEP), *spans]))
    after = after[np.diff(after, prepend=-1.0) > NARROW]
    closing = np.any([(after >= low - NARROW) & (after <= high + NARROW) for low, high in spans], axis=0)
    kept = closing | (np.abs(after % (2 * STEP) - STEP) > STEP - NARROW)
    return ends.top_angle + sense * after[kept], closing[kept]


def _braking(braked: BrakedPress, signal: Array, closing: Array) -> Braking:
    """The stops after signals (n,)."""
    slips, largest = _holding(braked)
    margin = braked.torque / largest if largest else math.inf
    if slips:
        none = np.zeros(0)
        return Braking(none, braked.torque, margin, slips, none, none, none, None, None, None)
    until, period = braked.longest(largest), 2 * np.pi * braked.press.period_turns

    def stop(angle: float) -> Stop:
        return braked.stop(angle, until)

    stops = [stop(float(angle)) for angle in signal]
    time, overrun, travel = (read_only(np.array([getattr(each, name) for each in stops])) for name in ("time", "overrun", "travel"))
    longest = _longest(stop, stops, np.flatnonzero(closing).tolist())
    elsewhere = _elsewhere(stop, stops, closing, math.copysign(period, braked.speed), longest)
    top = _top_stop(braked, stop, stops)
    return Braking(read_only(signal), braked.torque, margin, (), time, overrun, travel, longest, elsewhere, top)


def _searched(cases: Mapping[str, Braking], signal: Array, closing: Array, whole: float) -> dict[float, bool]:
    """The searched signals of all cases that are not among signals (n,) of a period ``whole``, and whether the slide closes there."""
    worst = [
        (stop.signal, closes) for case in cases.values() for stop, closes in ((case.worst, True), (case.worst_elsewhere, False)) if stop
    ]
    found: dict[float, bool] = {}
    for angle, closes in worst:
        place = signal[0] + math.copysign((math.copysign(1.0, whole) * (angle - signal[0])) % abs(whole), whole)
        if np.abs(np.append(signal, [*found]) - place).min() > NARROW:
            found[float(place)] = closes
    return found


def _with_stops(braked: BrakedPress, case: Braking, signals: Iterable[float]) -> Braking:
    """The case with stops after more signals, in the order of running."""
    if case.worst is None:
        return case
    stops = [braked.stop(signal, braked.longest(braked.torque / case.margin)) for signal in signals]
    columns: dict[str, Any] = {
        name: np.append(getattr(case, name), [getattr(each, name) for each in stops]) for name in ("signal", "time", "overrun", "travel")
    }
    order = np.argsort(math.copysign(1.0, braked.speed) * columns["signal"])
    return replace(case, **{name: read_only(column[order]) for name, column in columns.items()})


def _longest(stop: StopAfter, stops: Sequence[Stop], among: Sequence[int]) -> Stop:
    """The longest stop, searched between the signals next to the longest one ``among`` the stops; a signal keeps within these."""
    k = max(among, key=lambda k: stops[k].time)
    places = [stops[j].signal for j in (k - 1, k, k + 1) if j in among]
    return _highest(stop, min(places), max(places), stops[k])


def _elsewhere(stop: StopAfter, stops: Sequence[Stop], closing: Array, whole: float, longest: Stop) -> Stop | None:
    """The longest stop of all, if it takes longer than the ``longest`` one of the closing stroke; signals come again after ``whole``."""
    n = len(stops)
    k = max(range(n), key=lambda k: stops[k].time)
    if closing[[k - 1, k, (k + 1) % n]].all():
        return None
    ends = stops[k - 1].signal - (whole if k == 0 else 0.0), stops[(k + 1) % n].signal + (whole if k == n - 1 else 0.0)
    found = _highest(stop, min(ends), max(ends), stops[k])
    return found if found.time > longest.time + LONGER else None


def _highest(stop: StopAfter, low: float, high: float, best: Stop) -> Stop:
    """The longest stop after a signal from ``low`` to ``high``, by golden section."""
    share = 0.5 * (math.sqrt(5.0) - 1.0)
    inner = [stop(high - share * (high - low)), stop(low + share * (high - low))]
    while high - low > 1e-5:  # [rad]: the time is flat there, so that its error is about the square of that [s]
        if inner[0].time > inner[1].time:
            high = inner[1].signal
            inner = [stop(high - share * (high - low)), inner[0]]
        else:
            low = inner[0].signal
            inner = [inner[1], stop(low + share * (high - low))]
    return max(best, *inner, key=lambda each: each.time)


def _top_stop(braked: BrakedPress, stop: StopAfter, stops: Sequence[Stop]) -> Stop | None:
    """The stop that ends at the top dead centre which ends the period; of several the last."""
    sense, whole = math.copysign(1.0, braked.speed), 2 * np.pi * braked.press.period_turns
    top = stops[0].signal + sense * whole

    def beyond(signal: float) -> float:
        return sense * (signal - top) + stop(signal).overrun

    signals = [*(each.signal for each in stops), top]
    places = [sense * (signal - top) + each.overrun for signal, each in zip(signals, [*stops, stops[0]], strict=True)]
    for k in reversed(range(len(stops))):
        if places[k] < 0.0 <= places[k + 1]:
            return stop(sign_change(beyond, signals[k], signals[k + 1], 1e-9))
    return None


def _holding(braked: BrakedPress) -> tuple[tuple[tuple[float, float, str], ...], float]:
    """Crank angles between which the brake does not hold [rad], and which way the press then turns; and the largest holding torque."""
    period = 2 * np.pi * braked.press.period_turns
    angles = np.arange(0.0, period, period / round(period / STATICS))

    def torque(angle: float) -> float:
        return float(braked.holding_torque(np.array([angle]))[0])

    size = np.abs(braked.holding_torque(angles))
    k = int(size.argmax())
    low, high = angles[k] - STATICS, angles[k] + STATICS
    for _ in range(3):  # a finer grid about the largest value: 1e-5 of a step, where it is flat
        near = np.linspace(low, high, 65)
        j = int(np.abs(braked.holding_torque(near)).argmax())
        low, high = near[max(j - 1, 0)], near[min(j + 1, 64)]
    peak = float(near[j])
    largest = abs(torque(peak))
    if largest < braked.torque:
        return (), largest
    places = np.append(angles, peak % period)
    order = np.argsort(places)
    places = places[order]
    excess = np.append(size, largest)[order] - braked.torque
    start = int(np.argmin(excess))  # held there, unless the brake holds nowhere
    if excess[start] > 0:
        return ((0.0, period, "slips"),), largest
    places = np.concatenate([places[start:], places[: start + 1] + period])
    excess = np.concatenate([excess[start:], excess[: start + 1]])
    edges = [
        sign_change(lambda angle: abs(torque(angle)) - braked.torque, float(a), float(b), NARROW)
        for (a, b), (x, y) in zip(pairwise(places), pairwise(excess), strict=True)
        if (x > 0) != (y > 0)
    ]
    slips = []
    for low, high in zip(edges[::2], edges[1::2], strict=True):
        way = "slips back" if torque(0.5 * (low + high)) * braked.speed > 0 else "runs on"
        slips.append((low % period, low % period + high - low, way))
    return tuple(sorted(slips)), largest


def _slipping(case: Braking) -> str:
    """Where a brake does not hold, as text."""
    return "does not hold the press at " + ", ".join(
        f"{math.degrees(low):.2f} to {math.degrees(high):.2f} deg ({way})" for low, high, way in case.slips
    )
