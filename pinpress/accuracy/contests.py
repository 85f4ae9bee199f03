"""Contests of `compare`: methods with settings, the work that is timed, and the errors of its answer.

Run times can be compared because contestants take turns, so that other work of the machine slows all of them.

The contests of inverse dynamics stand here. The first is a period at constant speed, from crank angles to the driving torque and every
bearing force. The second compares the proximal settings of Pinocchio's constraint dynamics by accelerations and loop forces at states of a
turn. Redundant equations (every planar pin has one, across the plane) make the matrix of constraint dynamics singular. Its proximal
parameter mu regularises the matrix, and iterations remove the error by mu: with too small a mu rounding is divided by it, with too large a
mu the iterations do not converge.
"""

import gc
import itertools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError
from ..common.quantities import Array
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import cycle
from ..kinematics.servo_motion import servo_cycle
from ..linkage.linkage import Linkage
from ..simulation.reduced_model import reduced_model_of
from .measurements import INVERSE_DYNAMICS, PROXIMAL, PROXIMAL_STATES, Measurement
from .peers.peer import Answer, Peer

TURN = 0.02  # duration of a contestant's turn; its first call finds data and code evicted from the cache [s]
PATIENCE = 2.0  # time after which a contestant that has been timed gets no more turns [s]
GRIDS = 8  # numbers of crank angles that take turns
STATES = 48  # states of a period in which forward dynamics gives the accelerations back
PARAMETERS = (0.0, *(10.0**k for k in range(-14, -1)))
ITERATIONS = (1, 5, 20)
SKIPPED = (
    "proximal settings are skipped: they are compared for loops, without gear pairs, links without mass, or loops that hold each other"
)


class Errors(NamedTuple):
    """Errors of an answer, as in `Measurement`; None where there is none.

    Attributes:
        error: largest error.
        force_error: largest error of a bearing force, as a share of the largest peak of any [-].
        loop_gap: largest distance between the two sides of a loop [m].
        energy_error: error of power or energy [-].
        evaluations: number of crank angles, of evaluations of the equation of motion, or of samples.
    """

    error: float
    force_error: float | None = None
    loop_gap: float | None = None
    energy_error: float | None = None
    evaluations: int | None = None


@dataclass(frozen=True)
class Contestant:
    """A method with a setting that takes part in a contest. A `PinpressError` raised by its work or its judge is an answer too.

    Attributes:
        group: group of the contest.
        method: "plane", "reduced" and so on, or a peer with its version.
        setting: the setting in words.
        number: the setting as a number: a tolerance, a step [s], a proximal parameter or a number of samples; None where it has none.
        work: function that is timed.
        errors: function that judges what the work returns.
        cannot: what the method cannot do, in words.
    """

    group: str
    method: str
    setting: str
    number: float | None
    work: Callable[[], Any]
    errors: Callable[[Any], Errors]
    cannot: str = ""


@dataclass(frozen=True)
class Contest:
    """Contestants of a group, and the reference by which they are judged.

    Attributes:
        group: one of `measurements.GROUPS`.
        contestants: all contestants.
        certificate: difference of the two independent methods that make the reference.
        certified_by: names of these two methods.
        skipped: a line for each method that takes no part, with the reason.
    """

    group: str
    contestants: tuple[Contestant, ...]
    certificate: float
    certified_by: str
    skipped: tuple[str, ...] = ()


def measured(contestants: Sequence[Contestant], repeats: int, done: Callable[[], None]) -> tuple[Measurement, ...]:
    """Judge every contestant once and time all in turn.

    Args:
        contestants: contestants in the order of the result.
        repeats: number of rounds of timing.
        done: function called after every piece of work.
    """
    judged: list[tuple[Contestant, Errors | None, str]] = []
    for contestant in contestants:
        try:
            judged.append((contestant, contestant.errors(contestant.work()), ""))
        except PinpressError as error:
            judged.append((contestant, None, str(error).split(":")[0]))
        done()
    seconds = least_seconds([_tried(contestant.work) for contestant in contestants], repeats, done)
    return tuple(_measurement(*each, time) for each, time in zip(judged, seconds, strict=True))


def inverse_dynamics_contest(press: Linkage, speed: float, points: int, peers: Sequence[Peer]) -> Contest:
    """The contest of the engines and the peers.

    Pinocchio's engine judges the others, and the fastest one judges it: in the plane they share no equation. The torque of a press in space
    is judged by forward dynamics, which gives the accelerations back under it.
    """
    engines, planar = press.engines, press.engines[0] == "plane"
    answers = {engine: _solved(press, speed, points, engine) for engine in engines}
    spatial, first = answers["pinocchio"], answers[engines[0]]
    peak_torque, largest_force = peak_of(spatial.driving_torque), peak_force(spatial.bearing_force)
    comparable = any(not np.all(first.indeterminate[name][:3]) for name in first.bearing_force)
    returned = {} if planar else {engine: _returned(press, answer) for engine, answer in answers.items()}

    def errors(judge: Reactions, answer: Reactions) -> Errors:
        return Errors(
            _off(answer.driving_torque, judge.driving_torque, peak_torque) if planar else returned[answer.engine],
            force_error(answer.bearing_force, judge, largest_force),
            float(answer.motion.closure_error.max()),
            float(np.abs(answer.power_residual).max()),
            points,
        )

    def errors_of_peer(answer: Answer) -> Errors:
        force = force_error(answer.force, first, largest_force, determined=True) if comparable else None
        return Errors(_off(answer.torque, first.driving_torque, peak_torque), force, evaluations=points)

    contestant = partial(Contestant, INVERSE_DYNAMICS, setting=f"{points} crank angles", number=points)
    entries = [
        contestant(
            engine,
            work=_solved_anew(press, speed, points, engine),
            errors=partial(errors, first if answer is spatial else spatial),
            cannot="linkages in space" if engine == "plane" else "",
        )
        for engine, answer in answers.items()
    ]
    angle = first.motion.crank_angle
    angle = first.motion.crank_angle
    entries += [
        contestant(peer.name, work=partial(peer.inverse_dynamics, angle, speed), errors=errors_of_peer, cannot=peer.cannot)
        for peer in peers
        if peer.inverse
    ]
    if not planar:
        return Contest(INVERSE_DYNAMICS, tuple(entries), max(returned.values()), "torque and forward dynamics under it")
    agreement = errors(spatial, first)
    return Contest(INVERSE_DYNAMICS, tuple(entries), max(agreement.error, agreement.force_error or 0.0), "engines plane and pinocchio")


def proximal_contest(press: Linkage, speed: float, flywheel: float) -> Contest:
    """Settings of `constraintDynamics`, among them the one that method `constraint` takes.

    The crank turns with a flywheel and without torque. The reference is the accelerations by the null space of the loops, which need no mu;
    the reduced equation must give the same.
    """
    crank = press.driver_indices[0]
    armature = np.zeros(press.model.nv)
    armature[crank] = flywheel
    dynamics = press.forward_dynamics(armature)
    if dynamics.quick is None or dynamics.quick.least is not None or press.couplings:  # forces at loops that hold each other are open
        return Contest(PROXIMAL, (), 0.0, "", (SKIPPED,))
    turn = cycle(press, speed=speed, points=PROXIMAL_STATES)
    states = list(zip(turn.joint_position.copy(), turn.v.copy(), strict=True))
    truth = np.array([dynamics.acceleration_in_null_space(x, v, dynamics.still) for x, v in states])
    motion = servo_cycle(press, angle=turn.crank_angle, speed=speed, acceleration=truth[:, crank])
    at_loops = inverse_dynamics(press, motion).bearing_force
    expected = np.array([at_loops[loop.name] for loop in press.loops]).transpose(1, 0, 2)
    peak, peak_at_loops = peak_of(truth), peak_of(np.linalg.norm(expected, axis=2))
    table, slope = reduced_model_of(press).at(motion.crank_angle)
    reduced = -(0.5 * slope[0] * speed**2 + slope[1]) / (table[0] + flywheel)
    certificate = float(np.abs(reduced - truth[:, crank]).max() / peak)

    def answers(settings: pin.ProximalSettings) -> list[tuple[Array, Array]]:
        return [dynamics.answer_by(settings, x, v, dynamics.still) for x, v in states]

    def judged(found: list[tuple[Array, Array]]) -> Errors:
        accelerations, forces = (np.array(values) for values in zip(*found, strict=True))
        off = float(np.linalg.norm(forces - expected, axis=2).max() / peak_at_loops) if forces.shape == expected.shape else None
        return Errors(max(float(np.abs(accelerations - truth).max()) / peak, certificate), off)

    settings = [
        (f"{iterations} iteration{'s' * (iterations > 1)}", pin.ProximalSettings(0.0, 1e-13, mu, iterations))
        for iterations in ITERATIONS
        for mu in PARAMETERS
    ]
    settings.append(("as chosen", dynamics.quick.settings))
    entries = [Contestant(PROXIMAL, method, f"mu {each.mu:.0e}", each.mu, partial(answers, each), judged) for method, each in settings]
    return Contest(PROXIMAL, tuple(entries), certificate, "null-space accelerations and the reduced equation")


def force_error(forces: Mapping[str, Array], expected: Reactions, peak: float, determined: bool = False) -> float:
    """Largest distance of a bearing's force from the expected one, as a share of a peak force [-].

    Args:
        forces: name of a bearing -> (n, 3) force [N].
        expected: reactions with the right forces.
        peak: peak force [N].
        determined: whether to leave out the components that rigid-body mechanics leaves undetermined, which other programs share in their
            own ways.
    """
    found = []
    for name, force in expected.bearing_force.items():
        off = forces[name] - force
        if determined:
            off = (off @ expected.indeterminate_axes.T)[:, ~expected.indeterminate[name][:3]]
        found.append(float(np.linalg.norm(off, axis=1).max()))
    return max(found) / peak


def peak_force(forces: Mapping[str, Array]) -> float:
    """Largest force of any bearing (n, 3) in any state [N]; 1 where there is none."""
    return max(float(np.linalg.norm(force, axis=1).max()) for force in forces.values()) or 1.0


def peak_of(values: Array) -> float:
    """The largest magnitude among values; 1 where all are zero, as no error can be relative to zero."""
    return float(np.abs(values).max()) or 1.0


def least_seconds(works: Sequence[Callable[[], object]], repeats: int, done: Callable[[], None] = lambda: None) -> list[float]:
    """Least time of a call of each piece of work [s].

    Args:
        works: functions without arguments, called in turn.
        repeats: number of rounds, without the garbage collector.
        done: function called after every turn.
    """
    best, spent = [float("inf")] * len(works), [0.0] * len(works)
    collecting = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        for _ in range(repeats):
            for k, work in enumerate(works):
                end = time.perf_counter() + TURN
                while spent[k] < PATIENCE:
                    start = time.perf_counter()
                    work()
                    now = time.perf_counter()
                    best[k], spent[k] = min(best[k], now - start), spent[k] + now - start
                    if now > end:
                        break
                done()
    finally:
        if collecting:
            gc.enable()
    return best


def _tried(work: Callable[[], Any]) -> Callable[[], None]:
    def tried() -> None:
        with suppress(PinpressError):
            work()

    return tried


def _measurement(contestant: Contestant, errors: Errors | None, problem: str, seconds: float) -> Measurement:
    """A measurement; an error that is not finite becomes a problem."""
    values = errors or Errors(math.nan)
    error, force, gap, energy, evaluations = (None if value is None or not math.isfinite(value) else value for value in values)
    return Measurement(
        group=contestant.group,
        method=contestant.method,
        setting=contestant.setting,
        number=contestant.number,
        seconds=seconds,
        error=error,
        force_error=force,
        loop_gap=gap,
        energy_error=None if energy is None else abs(energy),
        evaluations=None if evaluations is None else int(evaluations),
        cannot=contestant.cannot,
        problem=problem or ("not finite" if error is None else ""),
    )


def _solved(press: Linkage, speed: float, points: int, engine: str) -> Reactions:
    return inverse_dynamics(press, cycle(press, speed=speed, points=points, engine=engine), engine=engine)


def _solved_anew(press: Linkage, speed: float, points: int, engine: str) -> Callable[[], Reactions]:
    """A function that solves ``points`` crank angles when it is first called, and then a few more, another number each time, so that memory
    is not laid out for one number alone."""
    counts = itertools.chain([points], itertools.cycle(range(points + 1, points + 1 + GRIDS)))
    return lambda: _solved(press, speed, next(counts), engine)


def _off(torque: Array, expected: Array, peak: float) -> float:
    return float(np.abs(torque - expected).max()) / peak


def _returned(press: Linkage, reactions: Reactions) -> float:
    """Largest difference of the accelerations that forward dynamics gives under the driving torque, divided by their peak [-]."""
    dynamics, motion, crank = press.forward_dynamics(np.zeros(press.model.nv)), reactions.motion, press.driver_indices[0]
    some = np.arange(0, len(motion.v), max(1, len(motion.v) // STATES))
    efforts = np.zeros((len(some), press.model.nv))
    efforts[:, crank] = reactions.driving_torque[some]
    states = zip(motion.joint_position[some].copy(), motion.v[some].copy(), efforts, strict=True)
    found = np.array([dynamics.acceleration(*state) for state in states])
    return float(np.abs(found - motion.a[some]).max()) / peak_of(motion.a[some])
