"""Choose the motions to measure, and the time of each motion, so that the records determine the press as well as possible.

    motions = pp.measured.measuring_motions(press, [30 * pp.RPM, 50 * pp.RPM, 70 * pp.RPM])
    print(pp.measured.plan(press, motions, noise=1400.0, time=24.0, cylinder=True))

The information matrix of a motion is the mean of Y'Y over its time / variance of the torque's noise; Y are the columns of `regressor`. The
matrices of motions that share the time are added to the prior of masses and inertias:

    deviations^2 = diagonal of (prior + time x sum of share x information)^-1.

The shares that minimise the sum of squares of relative deviations are a convex problem (an A-optimal experiment). The multiplicative
algorithm (Torsney 1983) solves it. The slope of the sum at the answer bounds the gain of any other shares.

At one constant speed the inertia of the crank makes no torque, and constant friction cannot be separated from viscous friction. If the
speed swings in step with the stroke, all terms are one function of the crank angle. A swing with a period of 2.6 strokes separates them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import number, numbers, positive, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.quantities import RPM, Array
from ..common.results import Tabular
from ..common.tables import Column
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..kinematics.servo_motion import servo_cycle
from ..linkage.linkage import Linkage
from .estimates.prior import NOTHING, USUAL, ZERO_DEVIATION, Losses, Unknowns, unknowns_of
from .estimates.run_rows import TURN
from .regressor import LOSSES, InertialEquations, loss_columns, refuse_losses

STATES = 72  # of a stroke of `measuring_motions`
LOSS = 0.05  # expected share of a loss in the rms torque if ``expected`` does not give it
FASTEST = 1e4  # speed of a crank [rad/s]
DOUBT = 2.0  # relative standard deviation of losses as expected
LEARNT = 0.9  # deviation by that before, above which a parameter of the masses was not learnt
KNOWN = 1.0  # half of a 95 % interval by the value, above which a loss is not known
WIDE = 1.96  # standard deviations of half a 95 % interval
GAP = 1e-3  # relative distance to the optimum at which shares are good enough
STEPS = 20_000  # most steps of the multiplicative algorithm
SHARED = 0.005  # shares below this are left out
EVEN = 1e-3  # relative change of a speed that counts as constant
IN_STEP = 0.05  # change of the speed at one angle by its whole change, below which it swings in step with the stroke
_NONE_GIVEN: Mapping[str, float] = FrozenMapping({})


@dataclass(frozen=True, eq=False, repr=False)
class MeasuringPlan(Tabular):
    """The time to measure each of m motions. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        motions: names of the motions.
        share: (m,) shares of the motions in the time; their sum is 1 [-].
        time: total time [s].
        parameters: names of the p wanted parameters.
        sizes: (p,) reference values of the deviations: expected values of losses, values of masses and inertias, and mass x radius of
            gyration for first moments, in the parameters' units.
        deviation: (p,) standard deviations after the plan, in the parameters' units.
        deviation_alone: (m, p) standard deviations if the whole time is spent on one motion.
        unknown: for each motion, names of the parameters that it alone does not determine.
        why: for each motion, the reason; empty if it determines nearly all parameters.
        gap: upper bound of the relative gain in the sum of squares of relative deviations by other shares [-].
    """

    press_name: str
    motions: tuple[str, ...]
    share: Array
    time: float
    parameters: tuple[str, ...]
    sizes: Array
    deviation: Array
    deviation_alone: Array
    unknown: tuple[tuple[str, ...], ...]
    why: tuple[str, ...]
    gap: float

    @property
    def title(self) -> str:
        return (
            f"MeasuringPlan of {self.press_name}: {self.time:g} s of {np.count_nonzero(self.share)} motions, worst 95 % interval"
            f" ±{100 * self.worst:.3g} %"
        )

    @property
    def interval(self) -> Array:
        """(p,) half width of each 95 % interval / size of the parameter [-]."""
        return np.asarray(WIDE * self.deviation / self.sizes)

    @property
    def interval_alone(self) -> Array:
        """(m, p) half width of each 95 % interval / size of the parameter after the whole time with one motion [-]."""
        return np.asarray(WIDE * self.deviation_alone / self.sizes)

    @property
    def worst(self) -> float:
        """The largest of ``interval`` [-]."""
        return float(self.interval.max())

    def columns(self) -> dict[str, Column]:
        """A row for each motion: share, time, worst interval of this motion alone, and parameters that it does not determine."""
        return {
            "motion": list(self.motions),
            "share [-]": self.share,
            "time [s]": self.share * self.time,
            "worst_interval_alone [-]": self.interval_alone.max(axis=1),
            "leaves_unknown": [", ".join(each) for each in self.unknown],
        }


@typed
def measuring_motions(
    press: Linkage, speeds: ArrayLike, *, swing: float = 0.3, strokes: ArrayLike = (2.6,), count: int = 13
) -> Mapping[str, Motion]:
    """Make motions for `plan`: each constant speed, and swings about it.

    Args:
        press: the press.
        speeds: (s,) speeds of the crank, positive [rad/s].
        swing: amplitude of the swing / speed [-].
        strokes: periods of the swings in strokes. Whole numbers and fractions 1 / n of a stroke give little information.
        count: number of strokes of each motion.

    Returns:
        Name -> motion.

    Raises:
        PinpressError: a number is out of its range; `servo_cycle` refuses the motion.
    """
    found: dict[str, Motion] = {}
    wanted = numbers("speeds", speeds, (None,), unit="rad/s")
    if not len(wanted) or not ((wanted > 0) & (wanted < FASTEST)).all():
        raise PinpressError(f"speeds is {shown(speeds)}: give positive speeds of the crank [rad/s]")
    share = number("swing", swing)
    if not 0 <= share < 1:
        raise PinpressError(f"swing is {share:g}: give a share of the speed from 0 to below 1")
    turns, periods = whole_number("count", count, 2, 200), numbers("strokes", strokes, (None,))
    for speed in wanted:
        plain = f"{speed / RPM:.4g} r/min"
        time = np.arange(turns * STATES) / STATES * 2 * np.pi / speed
        found[plain] = servo_cycle(press, speed * time, speed=np.full(len(time), speed), acceleration=np.zeros(len(time)), time=time)
        for each in periods if share else ():
            rate = speed / positive("strokes", each, "-", 1e3)
            angle = speed * time - share * speed / rate * (np.cos(rate * time) - 1)
            faster, change = speed * (1 + share * np.sin(rate * time)), share * speed * rate * np.cos(rate * time)
            name = f"{plain} ±{100 * share:.3g} % in {each:g} strokes"
            found[name] = servo_cycle(press, angle, speed=faster, acceleration=change, time=time)
    return FrozenMapping(found)


@typed
def plan(
    press: Linkage,
    motions: Mapping[str, Motion],
    *,
    noise: float,
    time: float = 24.0,
    rate: float = 500.0,
    prior: float | Mapping[str, float] = USUAL,
    known: Mapping[str, tuple[float, float]] = NOTHING,
    friction: Sequence[str] = ("crank", "gibs"),
    cylinder: bool = False,
    expected: Mapping[str, float] = _NONE_GIVEN,
    wanted: Sequence[str] | None = None,
) -> MeasuringPlan:
    """Share the time of a measurement among motions so that the wanted parameters become as exact as possible.

    Args:
        press: the press as described, with one crank.
        motions: name -> motion that the drive can make; `measuring_motions` makes some.
        noise: standard deviation of a sample of the torque at the crank [N m].
        time: total time of the measurement [s].
        rate: samples a second [Hz].
        prior: relative standard deviation of masses and inertias as described, as for `identify`.
        known: weighed or gauged values, as for `identify`.
        friction: kinds of friction, as for `identify`: "crank", "pins", "slide_guide", "gibs".
        cylinder: whether there is a balance cylinder.
        expected: name of a loss -> expected value, right within a factor of about three ("crank friction": 800.0), in its unit; by
            default each loss makes 5 % of the torque.
        wanted: names of the parameters to determine; by default all losses, and the masses and inertias that these motions show.

    Raises:
        PinpressError: there is no motion, a motion belongs to another press, or a number is out of its range.
        UnknownNameError: there is no such parameter.

    Warns:
        PinpressWarning: a wanted parameter stays unknown with any shares.
    """
    if not motions or not all(isinstance(name, str) and isinstance(each, Motion) for name, each in motions.items()):
        raise PinpressError(f"motions is {shown(motions)}: give motions by name, measuring_motions(press, speeds)")
    if not all(isinstance(name, str) for name in friction):
        raise PinpressError(f"friction is {shown(friction)}: name kinds of friction, of {', '.join(LOSSES)}")
    refuse_losses(press, friction, cylinder)
    seconds, scatter = positive("time", time, "s"), positive("noise", noise, "N m")
    samples = positive("rate", rate, "Hz") / scatter**2
    losses = Losses(tuple(friction), cylinder, None)
    for name, motion in motions.items():
        if motion.linkage != press.name or motion.crank_angle.ndim != 1:
            raise PinpressError(f"motion {name!r} belongs to {motion.linkage}, not to {press.name}")
        refuse_motion_of_another(press, motion)
    task = _task(unknowns_of(press, prior, losses, known), motions, losses, expected)
    information = seconds * samples * task.information
    chosen = _chosen(task, information, wanted)
    relative = task.spread[chosen] / task.sizes[chosen][:, None]
    share, gap = _shares(task.before, information, relative.T @ relative)
    alone = np.array([_deviations(task, task.before + each) for each in information])
    after = _deviations(task, task.before + np.tensordot(share, information, 1))
    names = tuple(task.unknowns.parameters[k].name for k in chosen)
    unknown = tuple(tuple(name for name, left in zip(names, _left(task, each, chosen), strict=True) if left) for each in alone)
    never = [name for name, left in zip(names, _left(task, after, chosen), strict=True) if left]
    if never:
        caution(
            f"{', '.join(never)}: these motions do not determine it, however long they are measured. Give others, or leave it out of wanted"
        )
    return MeasuringPlan(
        press_name=press.name,
        motions=tuple(motions),
        share=share,
        time=seconds,
        parameters=names,
        sizes=task.sizes[chosen],
        deviation=after[chosen],
        deviation_alone=alone[:, chosen],
        unknown=unknown,
        why=tuple(_why(press, motion) if left else "" for motion, left in zip(motions.values(), unknown, strict=True)),
        gap=gap,
    )


class _Task(NamedTuple):
    """What is looked for, p parameters, in q numbers about one.

    Attributes:
        unknowns: with what is known before.
        sizes: (p,) with which deviations are compared; 0 of what a press does not have.
        spread: (p, q) changes of the parameters by the numbers.
        before: (q, q) information before.
        information: (m, q, q) of each motion, by sample of unit noise.
    """

    unknowns: Unknowns
    sizes: Array
    spread: Array
    before: Array
    information: Array


def _task(unknowns: Unknowns, motions: Mapping[str, Motion], losses: Losses, expected: Mapping[str, float]) -> _Task:
    equations, inertial = unknowns.equations, unknowns.inertial
    lost = unknowns.parameters[inertial : unknowns.zero]
    for name in expected:
        if name not in [each.name for each in lost]:
            raise UnknownNameError("loss", name, [each.name for each in lost])
    columns = {name: _columns(equations, motion, losses) for name, motion in motions.items()}
    weights = {name: _weights(motion) for name, motion in motions.items()}
    sizes = np.array([each.size for each in equations.parameters] + [0.0] * len(lost) + [ZERO_DEVIATION])
    rms = {
        name: (np.sqrt(weights[name] @ (each[:, :inertial] @ equations.values) ** 2), np.sqrt(weights[name] @ each**2))
        for name, each in columns.items()
    }
    for k, each in enumerate(lost, inertial):
        usual = max(LOSS * torque / own[k] for torque, own in rms.values() if own[k] > 0)
        sizes[k] = positive(f"expected {each.name}", expected[each.name], each.unit) if each.name in expected else usual
    spread = unknowns.scaled(np.append(DOUBT * sizes[inertial : unknowns.zero], ZERO_DEVIATION))
    spread = spread[:, np.abs(spread).max(axis=0) > 0]
    values = np.append(equations.values, sizes[inertial : unknowns.zero])
    information = []
    for name, motion in motions.items():
        slopes = [_columns(equations, motion, losses, turn) @ values for turn in (TURN, -TURN)]
        whole = np.column_stack([columns[name], (slopes[0] - slopes[1]) / (2 * TURN)]) @ spread
        information.append(whole.T @ (weights[name][:, None] * whole))
    weighed = unknowns.weighed @ spread
    return _Task(unknowns, sizes, spread, np.eye(spread.shape[1]) + weighed.T @ weighed, np.array(information))


def _columns(equations: InertialEquations, motion: Motion, losses: Losses, zero: float = 0.0) -> Array:
    """(n, p - 1) torque by all parameters but the encoder's zero, where it is this."""
    angle, speed, acceleration = motion.crank_angle - zero, motion.crank_speed, motion.crank_acceleration
    inertial = equations.coefficients(angle)["torque"].columns(speed, acceleration)
    return np.hstack([inertial, loss_columns(equations.press, angle, speed, acceleration, losses.friction, losses.cylinder)])


def _weights(motion: Motion) -> Array:
    """(n,) shares of the states in the time."""
    duration = np.gradient(motion.time) if len(motion.time) > 1 else np.ones(1)
    return np.asarray(duration / duration.sum())


def _chosen(task: _Task, information: Array, wanted: Sequence[str] | None) -> list[int]:
    """Places of the parameters that matter."""
    names = [each.name for each in task.unknowns.parameters[:-1]]  # the zero is found with them
    if wanted is None:
        together, before = _deviations(task, task.before + information.mean(axis=0)), task.unknowns.deviation
        learnt = [k for k in range(task.unknowns.inertial) if task.sizes[k] > 0 and together[k] < LEARNT * before[k]]
        return [*learnt, *range(task.unknowns.inertial, len(names))]
    found = list(wanted)
    for name in found:
        if not isinstance(name, str) or name not in names or task.sizes[names.index(name)] == 0:
            raise UnknownNameError("parameter", name, [name for name, size in zip(names, task.sizes, strict=False) if size > 0])
    if not found:
        raise PinpressError("wanted is empty: name one parameter or more")
    return [names.index(name) for name in found]


def _shares(before: Array, information: Array, matter: Array) -> tuple[Array, float]:
    """Shares that make the trace of ``matter`` x covariance least, and how much less, relative, it can be at most."""
    scale = 1 / np.sqrt(np.diag(before + information.sum(axis=0)))
    start, parts, aim = (scale[:, None] * each * scale for each in (before, information, matter))
    share = np.full(len(parts), 1 / len(parts))
    for _ in range(STEPS):
        inverse = np.linalg.inv(start + np.tensordot(share, parts, 1))
        sensitive = inverse @ aim @ inverse
        value = float((aim * inverse).sum())
        slopes = np.tensordot(parts, sensitive, 2)  # how much the sum falls by a share
        gap = float(slopes.max() - share @ slopes) / value if value > 0 else 0.0  # 0: what is wanted is known, and all shares are as good
        if gap < GAP:
            break
        share = share * np.sqrt(np.maximum(slopes, 0.0))
        share /= share.sum()
    kept = np.where(share >= SHARED, share, 0.0)
    kept /= kept.sum()
    rounded = float((aim * np.linalg.inv(start + np.tensordot(kept, parts, 1))).sum())
    return kept, max(1 - (1 - gap) * value / rounded, 0.0) if rounded > 0 else 0.0


def _deviations(task: _Task, information: Array) -> Array:
    """(p,) standard deviations for an information matrix (q, q)."""
    scale = 1 / np.sqrt(np.diag(information))
    root = np.linalg.cholesky(scale[:, None] * information * scale)
    return np.asarray(np.linalg.norm(np.linalg.solve(root, (task.spread * scale).T), axis=0))


def _left(task: _Task, deviation: Array, chosen: Sequence[int]) -> list[bool]:
    """Whether each of the chosen parameters is left unknown."""
    before = task.unknowns.deviation
    return [
        bool(deviation[k] > LEARNT * before[k]) if k < task.unknowns.inertial else bool(WIDE * deviation[k] > KNOWN * task.sizes[k])
        for k in chosen
    ]


def _why(press: Linkage, motion: Motion) -> str:
    """Why a motion leaves something unknown."""
    speed = motion.crank_speed
    change = float(np.ptp(speed))
    if change <= EVEN * np.abs(speed).max():
        return "at one speed viscous and constant friction cannot be separated, and the crank's inertia makes no torque"
    places = np.floor(np.mod(motion.crank_angle, 2 * np.pi) / (2 * np.pi) * 36).astype(int)
    spread = max(float(np.ptp(speed[places == each])) for each in np.unique(places))
    slope = float(np.abs(np.gradient(speed, motion.crank_angle)).max()) * 2 * np.pi / 36
    if spread <= IN_STEP * change + slope and press.period_turns == 1:
        return "the speed swings in step with the stroke, so all torques are one function of the crank angle"
    return ""
