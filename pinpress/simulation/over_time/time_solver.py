"""Integration over time, whatever happens: stops, contacts, clutches, drives with states of their own, forces in time.

An event (see `events`) is located on the integrator's own interpolation; the mode changes there, and the integration goes on. SciPy's
DOP853 integrates with steps by error, or Radau IIA where forces are so stiff that stability limits the steps of DOP853. With a fixed step
the classical Runge-Kutta method integrates, as in Zhang 2007, 4.3 (its update of positions corrected: h^2/6, not h/6).
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853, DenseOutput, OdeSolver
from scipy.optimize import brentq

from ...common.errors import SimulationError
from ...common.frozen import read_only
from ...common.integrators import RadauIIA, RungeKutta4, rounding, slopes
from ...common.quantities import Array
from ...loads.caller_laws import LawError
from ..coupling import OPEN
from ..failures import failure
from ..trajectory import INTEGRALS, Sample
from .events import CornerPassed, Event, EventFinder
from .hybrid_system import HybridSystem, Mode

EXPLICIT, IMPLICIT, FIXED, BY_STIFFNESS = "explicit", "implicit", "fixed step", "by stiffness"


@dataclass(eq=False, repr=False)
class TimeSegment:
    """A part of a run that was integrated over time, step by step. `Integration` fills it, and it is read afterwards.

    Attributes:
        system: what was integrated.
        start: time at the start [s].
        from_rest: whether the crank was at rest at the start.
        times: ends of the steps [s].
        pieces: the vector over each step, as a function of time.
        modes: mode of each step.
        speeds: of the crank at the start and after every step [rad/s].
        ran: the methods, in the order in which they were used.
        steps: number of steps.
        evaluations: of the rates, including those of discarded steps.
        travelled: angle that the crank has turned, in either direction [rad].
    """

    system: HybridSystem
    start: float
    from_rest: bool = False
    times: list[float] = field(default_factory=list)
    pieces: list[Callable[[Any], Array]] = field(default_factory=list)
    modes: list[Mode] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    ran: dict[str, None] = field(default_factory=dict)
    steps: int = 0
    evaluations: int = 0
    travelled: float = 0.0

    @property
    def end(self) -> float:
        return self.times[-1] if self.times else self.start

    @property
    def fastest(self) -> float:
        return max(map(abs, self.speeds), default=0.0)

    @property
    def borders(self) -> Array:
        return read_only(np.array([self.start, *self.times]))

    @property
    def jumps(self) -> Array:
        changes = [
            time for time, (mode, next_mode) in zip(self.times, itertools.pairwise(self.modes), strict=False) if mode is not next_mode
        ]
        return read_only(np.unique([self.start, *changes, self.end]))

    @property
    def standing(self) -> float | None:
        """Time since which the press stands at the end, held by other than a brake [s]; None if it does not stand."""
        stands = [mode.rests and mode.brake.grip is OPEN for mode in self.modes]
        moving = next((k for k in range(len(stands), 0, -1) if not stands[k - 1]), 0)
        return None if moving == len(self.modes) else self.times[moving - 1] if moving else self.start

    @property
    def solvers(self) -> tuple[str, ...]:
        return tuple(self.ran)

    def before(self, late: Callable[[Array], float]) -> tuple[float, Mode, Array, float]:
        """Take back the last step, in which a function ``late`` of the vector has become positive.

        Returns:
            Time at which the step began, its mode, the vector there, and about the time at which the function is zero.
        """
        begin = self.times[-2] if len(self.times) > 1 else self.start
        piece, end, modes = self.pieces.pop(), self.times.pop(), self.modes.pop()
        self.speeds.pop()
        zero = brentq(lambda t: late(piece(t)), begin, end, rtol=1e-15) if late(piece(begin)) < 0 else begin
        return begin, modes, np.asarray(piece(begin)), float(zero)

    def stops(self) -> list[float]:
        """Times at which the crank stopped, where it is integrated alone; with the start where it began at rest [s]."""
        stops, since = [], self.start
        if self.from_rest:  # search behind the start, where the speed is rounding
            stops, since = [self.start], self.start + 1e-3 * (self.times[0] - self.start)
        for piece, end in zip(self.pieces, self.times, strict=True):
            if float(piece(since)[1]) * float(piece(end)[1]) < 0:
                stops.append(float(brentq(lambda t, piece=piece: float(piece(t)[1]), since, end, xtol=1e-300, rtol=1e-15)))
            since = end
        return stops

    def at(self, times: Array, complete: bool = True) -> Sample:
        system, size, integrals = self.system, self.system.dynamics.size, len(INTEGRALS)
        owner, columns = self._vectors(times)
        accelerations = np.empty((0, len(times)))
        if complete:
            columns[: 2 * size] = np.concatenate(system.dynamics.close_loops(columns[:size], columns[size : 2 * size]))
            rates = [system.rates(self.modes[k], float(times[i]), columns[:, i].copy()) for i, k in enumerate(owner.tolist())]
            accelerations = np.array(rates).T[size : 2 * size]
        driving = system.driving(times, columns, [self.modes[k] for k in owner.tolist()])
        states = system.drive_states(columns)
        return Sample(columns[:size], columns[size : 2 * size], accelerations, *driving, states, columns[-integrals:])

    def held_efforts(self, times: Array) -> Array:
        """Efforts (held, n) that hold the speeds of motors at times (n,), see `DrivenPress.held`."""
        owner, columns = self._vectors(times)
        parts = zip(owner.tolist(), times.tolist(), columns.T.copy(), strict=True)
        return np.array([self.system.held_efforts(self.modes[k], time, y) for k, time, y in parts]).T

    def _vectors(self, times: Array) -> tuple[NDArray[np.intp], Array]:
        """Numbers (n,) of the pieces at times (n,), and the vectors (len(y), n) there."""
        owner = np.clip(np.array(self.times).searchsorted(times, side="left"), 0, len(self.times) - 1)
        columns = np.empty((len(self.pieces[0](self.start)), len(times)))
        for k in np.unique(owner).tolist():
            mine = np.flatnonzero(owner == k)
            columns[:, mine] = self.pieces[k](times[mine])
        return owner, columns


class Settings(NamedTuple):
    """How to integrate."""

    tolerance: float  # error accepted of a step, as a share of the sizes
    sizes: Array  # (len(y),) of the entries of the vector
    step: float | None = None  # of the classical Runge-Kutta method [s]; None: steps by error
    method: str = BY_STIFFNESS  # of steps by error: `EXPLICIT`, `IMPLICIT`, or whichever gets on faster, `BY_STIFFNESS`


def integrate(
    system: HybridSystem,
    mode: Mode,
    start: float,
    y: Array,
    until: float,
    settings: Settings,
    finished: Callable[[Array], bool] | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[TimeSegment, Array]:
    """Integrate from a vector in a mode.

    Args:
        system: what is integrated.
        mode: at the start.
        start: time at the start [s].
        y: (len(y),) vector at the start.
        until: time of the end [s].
        settings: how to integrate.
        finished: ends the integration where it is true of the vector at the end of a step.
        progress: called with the time reached [s] after every step.

    Returns:
        The segment, and the vector at its end.

    Raises:
        SimulationError: the press stalls or runs against a lock, steps become too short, or the run would take too long.
    """
    integration = Integration(system, mode, start, y, until, settings)
    while integration.goes_on and not integration.follow_mode(finished, progress):
        pass
    return integration.segment, integration.y


class Integration:
    """An integration in progress: the time, vector and mode reached, and the segment so far."""

    def __init__(self, system: HybridSystem, mode: Mode, start: float, y: Array, until: float, settings: Settings) -> None:
        self.system, self.settings, self.start, self.until = system, settings, start, until
        self.time, self.y, self.mode = start, y, mode
        linkage = system.at(y).linkage
        self.angle = linkage.angle
        self.segment = TimeSegment(system, start, from_rest=bool(linkage.speed == 0), speeds=[float(linkage.speed)])
        # steps end at instants at which something is not smooth, and at a corner of the drive's torque, which they must not pass over
        self.ends = sorted({b for b in system.driven.switch_times if start < b < until} | {until})
        self.corner, self.tries = math.inf, 0
        self.pace = Pace(start, until)
        self.pacer = Pacer() if settings.step is None and settings.method == BY_STIFFNESS else None
        self.first_step: float | None = None
        self.at_once = 0  # events so far one after the other without time going on
        self.shortest = 1e-15 * (until - start)  # less is rounding of the time

    @property
    def goes_on(self) -> bool:
        """Whether the end is not reached yet. Once it is, the segment is made to end there exactly, even if an event came a rounding
        before."""
        if self.time < self.until - 8 * float(np.finfo(float).eps) * abs(self.until):
            return True
        if self.segment.times:
            self.segment.times[-1] = self.until
        return False

    def follow_mode(self, finished: Callable[[Array], bool] | None, progress: Callable[[float], None] | None) -> bool:
        """Take steps of one method in one mode: to an event, to an instant at which something is not smooth, or to a change of method.
        Returns whether the run is ``finished`` there."""
        trials = Trials(self.system, self.mode)
        method, stepper = self._stepper(trials)
        watch = EventFinder(self.system, self.mode, self.time, self.y)
        event: Event | None = None
        while stepper.status == "running" and event is None:
            trials.error = None
            message = stepper.step()
            if stepper.status == "failed" or not np.isfinite(stepper.y).all():
                raise trials.error or self.system.cannot_go_on(self.time, self.y, message)
            piece = stepper.dense_output()
            event, end = watch.first(piece, stepper.t_old, stepper.t)
            # after 4 attempts to end a step at a corner, the corner cuts it
            if isinstance(event, CornerPassed) and self.tries < 4 and end > self.time + self.shortest:
                self.corner, self.tries = end, self.tries + 1
                self.segment.evaluations += stepper.nfev
                return False  # the step is repeated, to end there
            self._keep(piece, stepper, method, event, end)
            if progress is not None:
                progress(self.time)
            self._refuse_too_long(stepper)
            if finished is not None and finished(self.y):
                self.segment.evaluations += stepper.nfev
                return True
            if event is None and self.pacer is not None:
                swiftness = partial(_step_by_time_constant, stepper, self.time, self.y, self.settings.sizes)
                if self.pacer.changes(self.time, self.segment.evaluations + stepper.nfev, swiftness):
                    break
        self.segment.evaluations += stepper.nfev
        self._switch(event)
        return False

    def _stepper(self, trials: "Trials") -> tuple[str, OdeSolver]:
        """The method, and its integrator from the state reached."""
        settings = self.settings
        method = FIXED if settings.step is not None else self.pacer.using if self.pacer is not None else settings.method
        end = min(next(b for b in self.ends if b > self.time), self.corner)
        if self.mode.rests and self.system.varies:  # steps must not pass over what starts a press that stands
            end = min(end, self.time + (self.until - self.start) / 200)
        stepper = _stepper(trials, self.time, self.y, end, settings, method, self.first_step)
        if not np.isfinite(stepper.f).all():
            raise trials.error or failure("not finite", self.time, self.angle)
        return method, stepper

    def _keep(self, piece: DenseOutput, stepper: OdeSolver, method: str, event: "Event | None", end: float) -> None:
        """Add a step, up to its event, to the segment; the integration goes on from its end, with closed loops."""
        segment = self.segment
        segment.steps += 1
        segment.pieces.append(piece)
        segment.times.append(end)
        segment.modes.append(self.mode)
        segment.ran[method] = None
        self.first_step = getattr(stepper, "h_abs", None)
        if event is None:
            self.time, self.y = stepper.t, _close_loops(self.system, stepper)
        else:
            self.at_once = self.at_once + 1 if end <= self.time + self.shortest else 0
            self.time, self.y = end, self.system.project(end, piece(end))
        linkage = self.system.at(self.y).linkage
        segment.travelled += abs(linkage.angle - self.angle)
        segment.speeds.append(float(linkage.speed))
        self.angle = linkage.angle

    def _refuse_too_long(self, stepper: OdeSolver) -> None:
        """Raise SimulationError where the run would take too long, or too many steps to be kept."""
        evaluations = self.segment.evaluations + stepper.nfev
        if self.settings.step is None and self.pace.hopeless(self.time, evaluations, self.segment.travelled):
            swiftest = max(_eigenvalues(stepper, self.time, self.y, self.settings.sizes), key=abs, default=0.0)
            # A rate whose imaginary part is more than half of its size is that of a vibration.
            if abs(swiftest.imag) > 0.5 * abs(swiftest):
                frequency = abs(swiftest.imag) / (2 * np.pi)
                raise failure("vibrates", self.time, self.angle, frequency=frequency, swings=frequency * (self.until - self.time))
            raise failure("too slow", self.time, self.angle)
        most = 1_000_000  # each step is kept in memory
        if self.segment.steps == most:
            raise failure("too many steps", self.time, self.angle, most=most)

    def _switch(self, event: "Event | None") -> None:
        """Change to the mode after an event, or to the other side of the corner at which the step has ended."""
        if event is not None:
            if self.at_once > 100:  # events one after the other
                raise failure("chatters", self.time, self.angle)
            self.mode, self.y = event.after(self.system, self.mode, self.time, self.y)
        elif self.time >= self.corner:
            self.mode = self.system.past_corner(self.mode, self.y)
        self.corner, self.tries = math.inf, 0


# ----------------------------------------------------------------------------------------------------------------------------- methods


class Trials:
    """The rates of a mode as an integrator asks for them: it looks ahead, far beyond where the motion goes. Where a law fails there they
    are NaN, which makes it try a shorter step; the error counts where no step is short enough."""

    def __init__(self, system: HybridSystem, mode: Mode) -> None:
        self.system, self.mode = system, mode
        self.error: LawError | SimulationError | None = None

    def __call__(self, time: float, y: Array) -> Array:
        try:
            return self.system.rates(self.mode, time, y)
        except (LawError, SimulationError) as error:  # SimulationError: where friction would lock the linkage
            self.error = error
            return np.full(len(y), np.nan)


def _stepper(
    rates: Callable[[float, Array], Array],
    time: float,
    y: Array,
    end: float,
    settings: Settings,
    method: str,
    first: float | None,
) -> OdeSolver:
    """The integrator of a method.

    Args:
        rates: dy/dt of a time and a vector.
        time: at the start [s].
        y: vector at the start.
        end: time of the end [s].
        settings: of the integration.
        method: one of the names above.
        first: length of the first step [s]; None if it is not known.
    """
    if settings.step is not None:
        return RungeKutta4(rates, time, y, end, settings.step)
    first, error = None if first is None else min(first, end - time), settings.tolerance * settings.sizes
    relative = 3e-14  # the smallest relative tolerance that SciPy takes: errors of angles must not grow with the angles
    if method == IMPLICIT:
        return RadauIIA(rates, time, y, end, error, relative, len(INTEGRALS), settings.sizes, first)
    more = {} if first is None else {"first_step": first}
    return DOP853(rates, time, y, end, rtol=relative, atol=error, **more)


class Pacer:
    """Chooses the faster of the two methods of steps by error. Each is measured over some steps. The slower one is tried again after longer
    and longer intervals, if the length of the steps relative to the shortest time constant says that it may be the faster one by now.

    Attributes:
        window: number of steps over which the cost of a method is measured, after as many in which it finds its step.
        using: the method in use.
    """

    window = 5

    def __init__(self) -> None:
        self.using = EXPLICIT
        self.cost: dict[str, float] = {}  # evaluations a second of the run
        self.since_change, self.interval, self.steps = 0, 4 * self.window, 0
        self.since: tuple[float, int] | None = None

    def changes(self, time: float, evaluations: int, swiftness: Callable[[], float]) -> bool:
        """Whether the other method is to go on after a step.

        Args:
            time: at the end of the step [s].
            evaluations: of the method in use so far.
            swiftness: returns the step by the shortest time constant.
        """
        self.since_change, self.steps = self.since_change + 1, self.steps + 1
        if self.since_change == self.window:
            self.since = time, evaluations
        if self.since_change == 2 * self.window and self.since is not None and time > self.since[0]:
            # An evaluation of the implicit method, with its algebra, costs as much as 1.5 of the explicit one.
            dearer = 1.5 if self.using == IMPLICIT else 1.0
            self.cost[self.using] = dearer * (evaluations - self.since[1]) / (time - self.since[0])
        if self.since_change < 2 * self.window:
            return False
        other = IMPLICIT if self.using == EXPLICIT else EXPLICIT
        if not self.cost.get(self.using, math.inf) > self.cost.get(other, math.inf):
            if self.since_change < self.interval:
                return False
            long = self.steps >= 200  # then a trial of the other method costs little compared with the run
            self.interval = max(2 * self.interval, self.since_change) if long else self.interval + 4 * self.window
            # With steps shorter than the shortest time constant DOP853 is rarely the slower method, with ten times longer ones Radau IIA.
            if (swiftness() < (0.3 if long else 1.0)) if self.using == EXPLICIT else (swiftness() > 10.0):
                return False
        self.using, self.since_change, self.since = other, 0, None
        return True


class Pace:
    """Watches the pace of a run. One that would take too many evaluations is stopped early, earlier if the crank nearly stands."""

    def __init__(self, start: float, until: float) -> None:
        self.until, self.slow = until, 0
        self.before = start, 0, 0.0

    def hopeless(self, time: float, evaluations: int, travelled: float) -> bool:
        """Whether to give up, at a time [s], after so many evaluations, and an angle ``travelled`` since the start [rad]."""
        since, before, turned = self.before
        if evaluations - before < 12_000:  # about a second of work
            return False
        coming = (evaluations - before) * (self.until - time) / max(time - since, np.finfo(float).tiny)
        # A crank that moved by less than 1 rad in so many evaluations creeps or vibrates, and will not come to its end.
        most = 150_000 if travelled - turned < 1.0 else 15_000_000
        self.slow = self.slow + 1 if coming > most else 0
        self.before = time, evaluations, travelled
        return self.slow >= 3  # a hard place may be passed


def _eigenvalues(integrator: OdeSolver, time: float, y: Array, sizes: Array) -> NDArray[Any]:
    """Rates of the motion's modes [1/s], complex; none if the equations are not finite near the vector."""
    size = len(y) - len(INTEGRALS)
    jacobian = slopes(integrator.fun, time, y, integrator.f, sizes[:size], rounding(integrator.fun, time, y, integrator.f))[:size]
    return np.linalg.eigvals(jacobian) if np.isfinite(jacobian).all() else np.zeros(0)


def _step_by_time_constant(integrator: OdeSolver, time: float, y: Array, sizes: Array) -> float:
    """The integrator's last step by the shortest time constant of the motion; 1 where that is not known."""
    rates = np.abs(_eigenvalues(integrator, time, y, sizes))
    return float(integrator.step_size * rates.max()) if len(rates) else 1.0


def _close_loops(system: HybridSystem, solver: OdeSolver) -> Array:
    """Close the loops of the integrator's vector, from which it goes on, and return the vector."""
    y = system.project(solver.t, solver.y)
    if y is not solver.y:
        solver.y = y
        solver.f = solver.fun(solver.t, y)
    return y
