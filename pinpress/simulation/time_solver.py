"""Integration over time, whatever happens: stops, contacts, clutches, drives with states of their own, forces in time.

An event is the zero of a switching function of the `HybridSystem`. It is located on the integrator's own interpolation, the modes are
set anew, and the integration goes on from there. SciPy's DOP853 integrates with steps by error, and where forces are so stiff that it is
held up by its stability, Radau IIA does (see `radau`); or the classical Runge-Kutta method with a fixed step, as Zhang 2007, 4.3, used it
(its update of positions corrected: h^2/6, not h/6).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import DOP853, DenseOutput, OdeSolver
from scipy.optimize import brentq

from ..common.arrays import Array
from ..common.errors import PinpressError, SimulationError
from .hybrid_system import HybridSystem, Modes, Switch
from .radau import RadauIIA, slopes
from .trajectory import INTEGRALS, Sample

EXPLICIT, IMPLICIT, FIXED, BY_STIFFNESS = "explicit", "implicit", "fixed step", "by stiffness"
WINDOW = 5  # steps over which the pace of a method is measured, after as many in which it finds its step
SWIFT, SLOW = 1.0, 10.0  # steps beside the shortest time constant, below and above which DOP853 and Radau IIA are hardly the slower one
LONG, LESS_SWIFT = 200, 0.3  # steps after which a run is long enough to try Radau IIA at shorter ones too
DEARER = 1.5  # an evaluation of the implicit method, with what it does between them, beside one of the explicit method
ASIDE = 1e-3  # of a step from rest: there the crank moves
LEAST_RELATIVE = 3e-14  # tolerance beside the value itself, the least that SciPy takes: angles grow, their errors must not
LOOKED_AT = (0.25, 0.5, 0.75, 1.0)  # of a step: where switching functions are looked at
LOOKS = 200  # in a run's duration, at a press that stands
MOST_TRIES = 4  # to end a step at a corner
MOST_AT_ONCE = 100  # events without time going on
LOOK, PATIENCE = 12_000, 3  # evaluations after which the pace is looked at, and slow looks one after the other that give a run up
MOST_EVALUATIONS = 15_000_000  # of a run that gets on
CREEPING, MOST_CREEPING = 1.0, 150_000  # angle between looks below which a press creeps or vibrates [rad], evaluations of such a run
VIBRATING = 0.5  # imaginary part of the swiftest motion's rate, beside its size, from which it is a vibration
MOST_STEPS = 1_000_000  # in one run; each takes some memory
SHORTEST = 1e-15  # step, beside the duration


class RungeKutta4(OdeSolver):  # type: ignore[misc]
    """The classical Runge-Kutta method of order 4 with a fixed step, interpolated by cubics."""

    t: float
    y: Array

    def __init__(self, fun: Callable[[float, Array], Array], t0: float, y0: Array, t_bound: float, step: float) -> None:
        super().__init__(fun, t0, y0, t_bound, vectorized=False)
        self.fixed, self.f = step, self.fun(t0, self.y)
        self.before = (self.y, self.f)

    def _step_impl(self) -> tuple[bool, str | None]:
        t, y, f = self.t, self.y, self.f
        h = self.fixed if self.t_bound - t > self.fixed * (1 + 1e-9) else self.t_bound - t
        second = self.fun(t + 0.5 * h, y + 0.5 * h * f)
        third = self.fun(t + 0.5 * h, y + 0.5 * h * second)
        fourth = self.fun(t + h, y + h * third)
        self.before = (y, f)
        self.t = self.t_bound if t + h > self.t_bound - 1e-9 * h else t + h
        self.y = y + h / 6 * (f + 2 * (second + third) + fourth)
        self.f = self.fun(self.t, self.y)
        return True, None

    def _dense_output_impl(self) -> DenseOutput:
        return Cubic(self.t_old, self.t, *self.before, self.y, self.f)


class Cubic(DenseOutput):  # type: ignore[misc]
    """The cubic with given values and derivatives at both ends."""

    def __init__(self, t_old: float, t: float, y0: Array, f0: Array, y1: Array, f1: Array) -> None:
        super().__init__(t_old, t)
        self.ends = (y0, f0, y1, f1)

    def _call_impl(self, t: Any) -> Array:
        h = self.t - self.t_old
        s = (np.asarray(t) - self.t_old) / h
        weights = ((1 + 2 * s) * (1 - s) ** 2, h * s * (1 - s) ** 2, s**2 * (3 - 2 * s), h * s**2 * (s - 1))
        parts = [np.multiply.outer(end, weight) for end, weight in zip(self.ends, weights, strict=True)]
        return np.asarray(sum(parts))


@dataclass(eq=False, repr=False)
class TimeSegment:
    """A run over time, step by step: filled by `run`, read afterwards. ``speeds``: of the crank at the start and after every step."""

    system: HybridSystem
    start: float
    from_rest: bool = False
    times: list[float] = field(default_factory=list)
    pieces: list[Callable[[Any], Array]] = field(default_factory=list)
    modes: list[Modes] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    ran: dict[str, None] = field(default_factory=dict)
    steps: int = 0
    evaluations: int = 0
    travelled: float = 0.0

    @property
    def end(self) -> float:
        return self.times[-1] if self.times else self.start

    @property
    def standing(self) -> float | None:
        """Since when the press stands at the end, held by loads; None where it does not."""
        moving = next((k for k in range(len(self.modes), 0, -1) if not self.modes[k - 1].standing), 0)
        return None if moving == len(self.modes) else self.times[moving - 1] if moving else self.start

    @property
    def solvers(self) -> tuple[str, ...]:
        return tuple(self.ran)

    def before(self, late: Callable[[Array], float]) -> tuple[float, Modes, Array, float]:
        """Give up the last step, in which a function of the vector has become positive: when it began, its modes, the vector there,
        and about when the function is zero."""
        begin = self.times[-2] if len(self.times) > 1 else self.start
        piece, end, modes = self.pieces.pop(), self.times.pop(), self.modes.pop()
        self.speeds.pop()
        zero = brentq(lambda t: late(piece(t)), begin, end, rtol=1e-15) if late(piece(begin)) < 0 else begin
        return begin, modes, np.asarray(piece(begin)), float(zero)

    def stops(self) -> list[float]:
        """When the crank, alone, stopped: the start too where it began at rest."""
        found, since = [], self.start
        if self.from_rest:  # behind the start, where the speed is rounding
            found, since = [self.start], self.start + ASIDE * (self.times[0] - self.start)
        for piece, end in zip(self.pieces, self.times, strict=True):
            if float(piece(since)[1]) * float(piece(end)[1]) < 0:
                found.append(float(brentq(lambda t, piece=piece: float(piece(t)[1]), since, end, xtol=1e-300, rtol=1e-15)))
            since = end
        return found

    def heeds_speed(self) -> bool:
        """Whether more than the crank's angle counted for a force after any of the steps."""
        return any(
            self.system.heeds_speed(mode, end, np.asarray(piece(end)))
            for mode, end, piece in zip(self.modes, self.times, self.pieces, strict=True)
        )

    def at(self, times: Array, complete: bool = True) -> Sample:
        system, size, integrals = self.system, self.system.dynamics.size, len(INTEGRALS)
        owner = np.clip(np.array(self.times).searchsorted(times, side="left"), 0, len(self.times) - 1)
        columns = np.empty((len(self.pieces[0](self.start)), len(times)))
        for k in np.unique(owner).tolist():
            mine = np.flatnonzero(owner == k)
            columns[:, mine] = self.pieces[k](times[mine])
        accelerations = np.empty((0, len(times)))
        if complete:
            columns[: 2 * size] = np.concatenate(system.dynamics.closed(columns[:size], columns[size : 2 * size]))
            rates = [system.rates(self.modes[k], float(times[i]), columns[:, i].copy()) for i, k in enumerate(owner.tolist())]
            accelerations = np.array(rates).T[size : 2 * size]
        driving = system.driving(times, columns)
        return Sample(columns[:size], columns[size : 2 * size], accelerations, *driving, columns[-integrals:])


def run(
    system: HybridSystem,
    modes: Modes,
    start: float,
    y: Array,
    until: float,
    tolerance: float,
    scale: Array,
    step: float | None,
    breaks: Sequence[float],
    solver: str = EXPLICIT,
    finished: Callable[[Array], bool] | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[TimeSegment, Array]:
    """Integrate from a state and its modes to a time; the steps, and where it has come to.

    Args:
        y: vector of the `HybridSystem` at the start. scale: (len(y),) sizes of its entries, that the ``tolerance`` is a share of.
        step: of the classical Runge-Kutta method [s]; None: steps by error.
        breaks: instants at which something is not smooth.
        solver: of steps by error: `EXPLICIT`, `IMPLICIT`, or one after the other `BY_STIFFNESS`.
        finished: whether a vector, at the end of a step, is far enough.

    Raises:
        SimulationError: the press stalls, or runs against a lock; steps become too short.
    """
    result = TimeSegment(system, start, bool(system.split(y)[0].speed == 0))
    time, first, stuck = start, None, 0
    angle, fastest = system.split(y)[0].angle, abs(system.split(y)[0].speed)
    result.speeds.append(float(system.split(y)[0].speed))
    pace = Pace(start, until)
    ends = sorted({b for b in breaks if start < b < until} | {until})
    shortest = SHORTEST * (until - start)
    corner, tried = math.inf, 0  # time at which a drive's torque has a corner: a step must end there, not run over it
    close = 8 * float(np.finfo(float).eps) * abs(until)
    pacer = Pacer() if step is None and solver == BY_STIFFNESS else None
    while time < until - close:
        target = min(next(b for b in ends if b > time), corner)

        def rates(t: float, y: Array, modes: Modes = modes) -> Array:
            return system.rates(modes, t, y)

        using = FIXED if step is not None else pacer.using if pacer is not None and not modes.standing else solver
        longest = (until - start) / LOOKS if modes.standing else math.inf  # what starts a press that stands must not be stepped over
        integrator = _integrator(rates, time, y, target, step, using, tolerance, scale, first, longest)
        if not np.isfinite(integrator.f).all():
            raise SimulationError("a torque or force is not finite here, or the linkage locks: look at drive and loads", time, angle)
        event, again = None, False
        values = system.switches(modes, time, y)
        while integrator.status == "running" and event is None:
            message = integrator.step()
            if integrator.status == "failed" or not np.isfinite(integrator.y).all():
                raise _lost(system, time, y, message)
            piece = integrator.dense_output()
            if values:
                event, values = _first_event(system, modes, piece, integrator, values)
            if event is not None and event[0].what == "corner" and tried < MOST_TRIES and event[1] > time + shortest:
                corner, tried, again = event[1], tried + 1, True
                break
            at = integrator.t if event is None else event[1]
            result.steps += 1
            result.pieces.append(piece)
            result.times.append(at)
            result.modes.append(modes)
            result.ran[using] = None
            first = getattr(integrator, "h_abs", None)
            if event is None:
                time, y = integrator.t, _closed(system, integrator)
            else:
                stuck = stuck + 1 if at <= time + shortest else 0
                time, y = at, _project(system, piece(at), at)
            instant = system.split(y)[0]
            result.travelled += abs(instant.angle - angle)
            result.speeds.append(float(instant.speed))
            angle, fastest = instant.angle, max(fastest, abs(instant.speed))
            if progress is not None:
                progress(time)
            if step is None and pace.hopeless(time, result.evaluations + integrator.nfev, result.travelled):
                raise SimulationError(_hopeless(integrator, time, y, scale, until), time, angle)
            if result.steps == MOST_STEPS:
                raise SimulationError(f"more than {MOST_STEPS} steps: simulate in parts, or with a larger tolerance or step", time, angle)
            if finished is not None and finished(y):
                result.evaluations += integrator.nfev
                return result, y
            if pacer is not None and event is None:
                asked = partial(_swiftness, integrator, time, y, scale)
                if pacer.changes(time, result.evaluations + integrator.nfev, asked):
                    break
        result.evaluations += integrator.nfev
        if again:
            continue
        if event is None and time >= corner:
            modes = system.past_corner(modes, y)
        elif event is not None:
            if stuck > MOST_AT_ONCE:
                raise SimulationError("forces switch back and forth without end: it comes to rest where they hold it", time, angle)
            modes, y = system.after(event[0], modes, time, y, fastest)
        corner, tried = math.inf, 0
    if result.times:
        result.times[-1] = until  # an event there may have ended it a rounding before
    return result, y


def _integrator(
    rates: Callable[[float, Array], Array],
    time: float,
    y: Array,
    until: float,
    step: float | None,
    using: str,
    tolerance: float,
    scale: Array,
    first: float | None,
    longest: float,
) -> OdeSolver:
    """The integrator from a vector at a time; ``first``: length of its first step, where it is known; ``longest``: of any. The others as
    of `run`."""
    if step is not None:
        return RungeKutta4(rates, time, y, until, step)
    first = None if first is None else min(first, until - time)
    if using == IMPLICIT and longest == math.inf:
        return RadauIIA(rates, time, y, until, tolerance * scale, LEAST_RELATIVE, len(INTEGRALS), scale, first)
    more = {} if first is None else {"first_step": first}
    return DOP853(rates, time, y, until, max_step=longest, rtol=LEAST_RELATIVE, atol=tolerance * scale, **more)


class Pacer:
    """Which method of steps by error gets on faster: each is measured over some steps, and the slower one tried again after ever longer
    intervals where the steps, beside the shortest time constant, say that it may be the faster one by now."""

    def __init__(self) -> None:
        self.using = EXPLICIT
        self.cost: dict[str, float] = {}  # evaluations a second of the run
        self.taken, self.interval, self.steps = 0, 4 * WINDOW, 0
        self.since: tuple[float, int] | None = None

    def changes(self, time: float, evaluations: int, swiftness: Callable[[], float]) -> bool:
        """Whether the other method is to go on after a step; ``evaluations``: of the method in use so far; ``swiftness``: the step beside
        the shortest time constant."""
        self.taken, self.steps = self.taken + 1, self.steps + 1
        if self.taken == WINDOW:
            self.since = time, evaluations
        if self.taken == 2 * WINDOW and self.since is not None and time > self.since[0]:
            dearer = DEARER if self.using == IMPLICIT else 1.0
            self.cost[self.using] = dearer * (evaluations - self.since[1]) / (time - self.since[0])
        if self.taken < 2 * WINDOW:
            return False
        other = IMPLICIT if self.using == EXPLICIT else EXPLICIT
        if not self.cost.get(self.using, math.inf) > self.cost.get(other, math.inf):
            if self.taken < self.interval:
                return False
            self.interval = max(2 * self.interval, self.taken) if self.steps >= LONG else self.interval + 4 * WINDOW
            swift = SWIFT if self.steps < LONG else LESS_SWIFT
            if (swiftness() < swift) if self.using == EXPLICIT else (swiftness() > SLOW):
                return False
        self.using, self.taken, self.since = other, 0, None
        return True


class Pace:
    """How a run gets on: one that would take too many evaluations is given up early, and earlier where the crank all but stands."""

    def __init__(self, start: float, until: float) -> None:
        self.until, self.slow = until, 0
        self.before = start, 0, 0.0

    def hopeless(self, time: float, evaluations: int, travelled: float) -> bool:
        """Whether to give up, ``evaluations`` and the angle ``travelled`` [rad] since the start."""
        since, asked, turned = self.before
        if evaluations - asked < LOOK:
            return False
        coming = (evaluations - asked) * (self.until - time) / max(time - since, np.finfo(float).tiny)
        most = MOST_CREEPING if travelled - turned < CREEPING else MOST_EVALUATIONS
        self.slow = self.slow + 1 if coming > most else 0
        self.before = time, evaluations, travelled
        return self.slow >= PATIENCE


def _hopeless(integrator: OdeSolver, time: float, y: Array, scale: Array, until: float) -> str:
    """Why a run is given up, and what to do."""
    size = len(y) - len(INTEGRALS)
    jacobian = slopes(integrator.fun, time, y, integrator.f, scale[:size])[:size]
    swiftest = max(np.linalg.eigvals(jacobian), key=abs) if np.isfinite(jacobian).all() else 0.0
    if abs(swiftest.imag) > VIBRATING * abs(swiftest):
        frequency = abs(swiftest.imag) / (2 * np.pi)
        return (
            f"a stiff force makes the press vibrate at {frequency:.3g} Hz, {frequency * (until - time):.2g} times until the end, and each"
            " swing would be followed: give the force a damper, or simulate a shorter time or with a larger tolerance"
        )
    return (
        "at this pace the run would take too long: the linkage locks ahead, or a torque or force is too stiff for this method, or jumps to"
        " and fro; use method='auto', give the force a slope, or simulate in parts"
    )


def _swiftness(integrator: OdeSolver, time: float, y: Array, scale: Array) -> float:
    """The integrator's last step beside the shortest time constant of the motion."""
    size = len(y) - len(INTEGRALS)
    jacobian = slopes(integrator.fun, time, y, integrator.f, scale[:size])[:size]
    return float(integrator.step_size * np.abs(np.linalg.eigvals(jacobian)).max()) if np.isfinite(jacobian).all() else 1.0


def _first_event(
    system: HybridSystem, modes: Modes, piece: DenseOutput, solver: OdeSolver, before: dict[Switch, float]
) -> tuple[tuple[Switch, float] | None, dict[Switch, float]]:
    """The first event of a step, and the switching functions at its end."""
    since, low = solver.t_old, before
    for share in LOOKED_AT:
        at = solver.t if share == 1.0 else solver.t_old + share * (solver.t - solver.t_old)
        values = system.switches(modes, at, piece(at))
        fallen = [switch for switch, value in values.items() if value < 0]
        if fallen:
            return _located(system, modes, piece, since, low, at, fallen), values
        since, low = at, values
    return None, low


def _located(
    system: HybridSystem, modes: Modes, piece: DenseOutput, since: float, low: dict[Switch, float], until: float, fallen: list[Switch]
) -> tuple[Switch, float]:
    """The first of the switching functions that have fallen below zero between two times, and when."""

    def value(switch: Switch, t: float) -> float:  # with the loops closed, as the run goes on from there: a stiff edge wants all digits
        y = _project(system, piece(t), t)
        found = system.switches(modes, t, y)[switch]
        if math.isnan(found):
            raise _lost(system, t, y, None)
        return found

    first, rounding = (fallen[0], until), 8 * np.finfo(float).eps * max(abs(until), abs(since))
    for _ in range(len(low) + 1):
        found = [(_zero(partial(value, switch), since, first[1], low[switch]), switch) for switch in fallen]
        when, which = min(found, key=lambda f: f[0])
        # at one and the same instant a brake that grips comes first: what else happens at rest is for it to decide
        which = next((switch for at, switch in found if switch.what == "grips" and at <= when + rounding), which)
        if when > first[1] - rounding and first[1] != until:
            break
        first = (which, when)
        # one that fell and rose again before the end of the step shows only at the others' events; where two come at once, as an elastic
        # force ends with its stretch, one that has just switched is below zero by rounding
        values = system.switches(modes, when, _project(system, piece(when), when))
        fallen = [switch for switch, after in values.items() if after < 0 and switch != which and low[switch] > 0]
        if when <= since or not fallen:
            break
    return first


def _zero(value: Callable[[float], float], since: float, until: float, low: float) -> float:
    """When a function, ``low`` at ``since``, falls below zero, as it has done at ``until``."""
    if low <= 0 or value(since) <= 0:  # it began at zero: has it risen in between?
        shares = [0.5**k for k in range(1, 40)]
        risen = next((share for share in shares if value(since + share * (until - since)) > 0), None)
        if risen is None:
            return since
        since, until = since + risen * (until - since), since + 2 * risen * (until - since)
    if value(until) >= 0:
        return until
    return float(brentq(value, since, until, xtol=4e-16 * abs(until) + 1e-300, rtol=1e-15))


def _closed(system: HybridSystem, solver: OdeSolver) -> Array:
    """The integrator's vector with closed loops; the integrator goes on from there."""
    y = _project(system, solver.y, solver.t)
    if y is not solver.y:
        solver.y = y
        solver.f = solver.fun(solver.t, y)
    return y


def _project(system: HybridSystem, y: Array, time: float) -> Array:
    size = system.dynamics.size
    try:
        projected = system.dynamics.project(y[:size], y[size : 2 * size])
    except PinpressError as error:
        raise SimulationError(f"the loops do not close any more ({error}): the linkage locks, or the step is too long", time) from error
    return y if projected is None else np.concatenate([*projected, y[2 * size :]])


def _lost(system: HybridSystem, time: float, y: Array, message: str | None) -> SimulationError:
    angle = float(system.split(y)[0].angle)
    return SimulationError(
        f"the integration cannot go on ({message or 'values are not finite'}): the linkage locks ahead, or a force is too stiff",
        time,
        angle if math.isfinite(angle) else None,
    )
