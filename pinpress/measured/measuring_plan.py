"""Choose the motions to measure, and the time of each motion, so that the records determine the press as well as possible.

    motions = pp.measured.measuring_motions(press, [30 * pp.RPM, 50 * pp.RPM, 70 * pp.RPM])
    print(pp.measured.plan(press, motions, noise=1400.0, time=24.0, cylinder=True))

The information matrix of a motion is the mean of Y'Y over its time, divided by the variance of the torque's noise; Y has the columns of
`regressor`. The matrices of motions that share the time are added to the information of the prior:

    deviations^2 = diagonal of (prior + time x sum of share x information)^-1.

The shares that minimise the sum of squares of relative deviations are a convex problem (an A-optimal experiment). The multiplicative
algorithm (Torsney 1983) solves it. The slope of the sum at the answer bounds the gain of any other shares.

At one constant speed the inertia of the crank needs no torque, and constant friction cannot be separated from viscous friction. If the
speed oscillates with the period of the stroke, all terms are functions of the crank angle only. An oscillation with a period of 2.6 strokes
separates them.
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
from .identification import WIDE
from .regressor import LOSSES, loss_columns, refuse_losses

LEARNT = 0.9  # a mass or inertia with a larger ratio of posterior to prior deviation was not learnt


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
        unknown: for each motion, names of the parameters that this motion alone does not determine.
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
    motions: dict[str, Motion] = {}
    wanted = numbers("speeds", speeds, (None,), unit="rad/s")
    if not len(wanted) or not ((wanted > 0) & (wanted < 1e4)).all():
        raise PinpressError(f"speeds is {shown(speeds)}: give positive speeds of the crank [rad/s]")
    share = number("swing", swing)
    if not 0 <= share < 1:
        raise PinpressError(f"swing is {share:g}: give a share of the speed from 0 to below 1")
    turns, periods = whole_number("count", count, 2, 200), numbers("strokes", strokes, (None,))
    for speed in wanted:
        plain = f"{speed / RPM:.4g} r/min"
        time = np.arange(72 * turns) / 72 * 2 * np.pi / speed
        motions[plain] = servo_cycle(press, speed * time, speed=np.full(len(time), speed), acceleration=np.zeros(len(time)), time=time)
        for each in periods if share else ():
            rate = speed / positive("strokes", each, "-", 1e3)
            angle = speed * time - share * speed / rate * (np.cos(rate * time) - 1)
            faster, change = speed * (1 + share * np.sin(rate * time)), share * speed * rate * np.cos(rate * time)
            name = f"{plain} ±{100 * share:.3g} % in {each:g} strokes"
            motions[name] = servo_cycle(press, angle, speed=faster, acceleration=change, time=time)
    return FrozenMapping(motions)


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
    expected: Mapping[str, float] = FrozenMapping({}),
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
    alone = np.array([task.deviations(task.before + each) for each in information])
    after = task.deviations(task.before + np.tensordot(share, information, 1))
    names = tuple(task.unknowns.parameters[k].name for k in chosen)

    def unknown_with(deviation: Array) -> tuple[str, ...]:
        """Names of the chosen parameters that these deviations leave unknown."""
        inertial, before = task.unknowns.inertial, task.unknowns.deviation
        left = [deviation[k] > LEARNT * before[k] if k < inertial else WIDE * deviation[k] > task.sizes[k] for k in chosen]
        return tuple(name for name, is_left in zip(names, left, strict=True) if is_left)

    unknown, never = tuple(map(unknown_with, alone)), unknown_with(after)
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
    """The p unknowns of a plan, without the encoder's zero, as functions of q scaled numbers.

    Attributes:
        unknowns: the unknowns with their prior.
        sizes: (p,) sizes with which deviations are compared; 0 if the press does not have the parameter.
        spread: (p, q) changes of the unknowns by the scaled numbers.
        before: (q, q) information of the prior.
        information: (m, q, q) information of each motion for one sample with noise 1.
    """

    unknowns: Unknowns
    sizes: Array
    spread: Array
    before: Array
    information: Array

    def deviations(self, information: Array) -> Array:
        """(p,) standard deviations for an information matrix (q, q)."""
        scale = 1 / np.sqrt(np.diag(information))
        root = np.linalg.cholesky(scale[:, None] * information * scale)
        return np.asarray(np.linalg.norm(np.linalg.solve(root, (self.spread * scale).T), axis=0))


def _task(unknowns: Unknowns, motions: Mapping[str, Motion], losses: Losses, expected: Mapping[str, float]) -> _Task:
    equations, inertial = unknowns.equations, unknowns.inertial
    lost = unknowns.parameters[inertial : unknowns.zero]
    for name in expected:
        if name not in [each.name for each in lost]:
            raise UnknownNameError("loss", name, [each.name for each in lost])

    def torque(motion: Motion, zero: float = 0.0) -> Array:
        """(n, p - 1) torque by all parameters except the encoder's zero, for this zero."""
        angle, speed, acceleration = motion.crank_angle - zero, motion.crank_speed, motion.crank_acceleration
        masses = equations.coefficients(angle)["torque"].columns(speed, acceleration)
        return np.hstack([masses, loss_columns(equations.press, angle, speed, acceleration, losses.friction, losses.cylinder)])

    columns, weights = [torque(motion) for motion in motions.values()], []
    for motion in motions.values():
        duration = np.gradient(motion.time) if len(motion.time) > 1 else np.ones(1)
        weights.append(duration / duration.sum())
    sizes = np.array([each.size for each in equations.parameters] + [0.0] * len(lost) + [ZERO_DEVIATION])
    for k, each in enumerate(lost, inertial):
        if each.name in expected:
            sizes[k] = positive(f"expected {each.name}", expected[each.name], each.unit)
        else:  # 5 % of the rms torque
            pairs = [
                (np.sqrt(w @ (c[:, :inertial] @ equations.values) ** 2), np.sqrt(w @ c[:, k] ** 2))
                for w, c in zip(weights, columns, strict=True)
            ]
            sizes[k] = max(0.05 * rms / own for rms, own in pairs if own > 0)
    # the prior deviation of a loss is twice its expected value
    spread = unknowns.scaled(np.append(2.0 * sizes[inertial : unknowns.zero], ZERO_DEVIATION))
    spread = spread[:, np.abs(spread).max(axis=0) > 0]
    values = np.append(equations.values, sizes[inertial : unknowns.zero])
    information = []
    for motion, rows, weight in zip(motions.values(), columns, weights, strict=True):
        by_zero = (torque(motion, TURN) @ values - torque(motion, -TURN) @ values) / (2 * TURN)
        whole = np.column_stack([rows, by_zero]) @ spread
        information.append(whole.T @ (weight[:, None] * whole))
    weighed = unknowns.weighed @ spread
    return _Task(unknowns, sizes, spread, np.eye(spread.shape[1]) + weighed.T @ weighed, np.array(information))


def _chosen(task: _Task, information: Array, wanted: Sequence[str] | None) -> list[int]:
    """Places of the wanted parameters."""
    names = [each.name for each in task.unknowns.parameters[:-1]]  # without the encoder's zero
    if wanted is None:
        together, before = task.deviations(task.before + information.mean(axis=0)), task.unknowns.deviation
        learnt = [k for k in range(task.unknowns.inertial) if task.sizes[k] > 0 and together[k] < LEARNT * before[k]]
        return [*learnt, *range(task.unknowns.inertial, len(names))]
    for name in wanted:
        if not isinstance(name, str) or name not in names or task.sizes[names.index(name)] == 0:
            raise UnknownNameError("parameter", name, [name for name, size in zip(names, task.sizes, strict=False) if size > 0])
    if not len(wanted):
        raise PinpressError("wanted is empty: name one parameter or more")
    return [names.index(name) for name in wanted]


def _shares(before: Array, information: Array, matter: Array) -> tuple[Array, float]:
    """Shares that minimise the trace of ``matter`` x covariance, and an upper bound of what other shares can gain, relative to it."""
    scale = 1 / np.sqrt(np.diag(before + information.sum(axis=0)))
    start, parts, aim = (scale[:, None] * each * scale for each in (before, information, matter))
    share = np.full(len(parts), 1 / len(parts))
    for _ in range(20_000):
        inverse = np.linalg.inv(start + np.tensordot(share, parts, 1))
        value = float((aim * inverse).sum())
        slopes = np.tensordot(parts, inverse @ aim @ inverse, 2)  # how much the trace falls with each share
        gap = float(slopes.max() - share @ slopes) / value if value > 0 else 0.0  # 0: everything is known, all shares are as good
        if gap < 1e-3:
            break
        share = share * np.sqrt(np.maximum(slopes, 0.0))
        share /= share.sum()
    kept = np.where(share >= 0.005, share, 0.0)
    kept /= kept.sum()
    rounded = float((aim * np.linalg.inv(start + np.tensordot(kept, parts, 1))).sum())
    return kept, max(1 - (1 - gap) * value / rounded, 0.0) if rounded > 0 else 0.0


def _why(press: Linkage, motion: Motion) -> str:
    """The reason why a motion leaves parameters unknown; empty if no known reason applies."""
    speed = motion.crank_speed
    change = float(np.ptp(speed))
    if change <= 1e-3 * np.abs(speed).max():
        return "at one speed viscous and constant friction cannot be separated, and the crank's inertia makes no torque"
    places = np.floor(np.mod(motion.crank_angle, 2 * np.pi) / (2 * np.pi) * 36).astype(int)
    spread = max(float(np.ptp(speed[places == each])) for each in np.unique(places))
    slope = float(np.abs(np.gradient(speed, motion.crank_angle)).max()) * 2 * np.pi / 36
    if spread <= 0.05 * change + slope and press.period_turns == 1:
        return "the speed swings in step with the stroke, so all torques are one function of the crank angle"
    return ""
