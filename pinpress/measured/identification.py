"""Identify masses, friction, balance cylinder and motor constant of a press from records, with 95 % intervals.

    found = pp.measured.identify(press, runs, friction=("crank", "pins", "slide_guide"), cylinder=True)
    print(found)
    found.press  # a Linkage, for pp.write_urdf

The method is least squares over the weak equations of all runs (`weak_form`). Rows for the description of the press and the cones of real
bodies (Wensing 2017) are added.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..common import tables
from ..common.arguments import number, positive, typed
from ..common.errors import PinpressError, UnknownNameError, caution
from ..common.frozen import FrozenMapping
from ..common.quantities import Array
from ..common.results import Record, Records, Tabular
from ..dynamics.applied_loads import force_on_slide
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load
from .estimates.base_parameters import base_parameters
from .estimates.encoder_zero import Start, likely_starts
from .estimates.least_squares import Fit, deviations, fitted
from .estimates.prior import NOTHING, ZERO, Losses, Unknowns, unknowns_of
from .estimates.run_rows import BY_FORCE, RunEquations
from .estimates.weak_form import quantities, smoothed
from .records import MeasuredRun, sample_noise
from .regressor import PIN, Parameter, refuse_losses, slide_rates, turning_bearings

WIDE = 1.96  # standard deviations of half a 95 % interval
PASSES = 20  # most passes with rows linearised about the last estimates


@dataclass(frozen=True, repr=False)
class IdentifiedParameter(Record, units={}):
    """One parameter of a press before and after the identification.

    Attributes:
        name: name, such as "slide mass", "rod moment x" (first moment of mass about the joint), "crank friction".
        unit: unit of its numbers.
        before: described value; None for a loss.
        value: identified value.
        low: lower end of the 95 % interval.
        high: upper end of the 95 % interval.
        posterior: standard deviation from the noise of the records and the prior.
        sandwich: standard deviation from the scatter of the residuals over time; the interval uses the larger of both.
        doubt: standard deviation / standard deviation before; near 1 the records have no information about it. None if nothing was known
            before.
    """

    name: str
    unit: str
    before: float | None
    value: float
    low: float
    high: float
    posterior: float
    sandwich: float
    doubt: float | None


@dataclass(frozen=True, eq=False, repr=False)
class IdentifiedPress(Tabular):
    """A press identified from its records. Arrays are read-only.

    Attributes:
        press: the press with the identified masses; `pinpress.write_urdf` writes it.
        parameters: all unknowns with their 95 % intervals.
        base_parameters: the sums of masses and inertias that torques determine without a prior.
        learnt: number of parameters that the records determine: trace of information / (information + prior) [-].
        friction: friction of bearings and guide, for `pinpress.inverse_dynamics`; pins have the given radii, or by default a twentieth of
            the size of the linkage.
        losses: name -> identified loss of crank, gibs and cylinder, see ``parameters``.
        motor_constant: torque at the crank / current [N m/A]; None if torques were measured.
        motor_constant_interval: 95 % interval of the motor constant; None if torques were measured.
        noise: quantity -> standard deviation of one sample [N m, A, N].
        covariance: (parameters, parameters) covariance of the posterior, in the parameters' units.
    """

    press: Linkage
    parameters: Records[IdentifiedParameter]
    base_parameters: Records[IdentifiedParameter]
    learnt: float
    friction: Mapping[str, Friction]
    losses: Mapping[str, float]
    motor_constant: float | None
    motor_constant_interval: tuple[float, float] | None
    noise: Mapping[str, float]
    covariance: Array

    @property
    def title(self) -> str:
        return f"IdentifiedPress {self.press.name}: {self.learnt:.1f} of {len(self.parameters)} parameters learnt"

    @property
    def values(self) -> Mapping[str, float]:
        """Name of a parameter -> its value, in its unit."""
        return FrozenMapping({each.name: each.value for each in self.parameters})

    @property
    def intervals(self) -> Mapping[str, tuple[float, float]]:
        """Name of a parameter -> ends of its 95 % interval, in its unit."""
        return FrozenMapping({each.name: (each.low, each.high) for each in self.parameters})

    def torque(self, motion: Motion, loads: Sequence[Load] = ()) -> Array:
        """Compute the torque (n,) at the crank that this press needs, friction and balance cylinder included [N m].

        Args:
            motion: motion of the press, from `pinpress.cycle` or `servo_cycle`.
            loads: process loads and other loads.
        """
        losses = self.losses
        rate, height = slide_rates(self.press, motion)
        if self.press.slide is not None and losses.get("cylinder force") is not None:
            force = losses["cylinder force"] + losses["cylinder stiffness"] * height
            loads = [*loads, force_on_slide(self.press, force)]
        torque = inverse_dynamics(self.press, motion, loads, friction=self.friction, bearings=()).driving_torque
        sign = np.sign(motion.crank_speed)
        resisting = losses.get("crank friction", 0.0) + losses.get("gibs friction", 0.0) * np.abs(rate)
        return np.asarray(torque + resisting * sign + losses.get("crank viscous friction", 0.0) * motion.crank_speed)

    def columns(self) -> dict[str, tables.Column]:
        """The parameters as columns."""
        return self.parameters.columns()


@typed
def identify(
    press: Linkage,
    runs: Sequence[MeasuredRun],
    *,
    prior: float | Mapping[str, float] = 0.2,
    known: Mapping[str, tuple[float, float]] = NOTHING,
    friction: Sequence[str] = ("crank", "slide_guide"),
    cylinder: bool = False,
    radii: Mapping[str, float] | None = None,
    drive_inertia: float = 0.0,
    loads: Sequence[Load] = (),
) -> IdentifiedPress:
    """Identify masses, inertias, friction, balance cylinder and motor constant of a press from records of idle running.

    Measure two minutes in total, at three or more speeds. A servo motion is enough too if its speed changes by a third, with a period that
    is not in step with the stroke. If runs have currents in place of torques, the motor constant is identified. For this, fasten a known
    mass to a link in one run: ``MeasuredRun(..., added_mass={"slide": 200.0})``. It determines how exact the motor constant is.

    The encoder's zero is identified too: the parameter "encoder zero" is the angle that all records show in the drawn pose. The crank angle
    is the recorded angle minus this zero.

    Args:
        press: the press as described, with one crank.
        runs: records of the press without process force.
        prior: relative standard deviation of described masses and inertias; or name of a link or parameter -> deviation (others 0.2).
        known: parameter, or "total mass" of all links -> (value, standard deviation) as weighed or gauged, in the parameter's unit:
            {"slide mass": (2200.0, 5.0), "encoder zero": (0.0, 0.001)}.
        friction: kinds of friction: "crank" (constant and viscous torque on the crank), "pins" (one coefficient for all pins),
            "slide_guide" (coefficient x force of the guide), "gibs" (a constant force on the slide).
        cylinder: whether a balance cylinder carries the slide: force + stiffness x height above bottom dead centre.
        radii: pin -> radius [m]; by default one number, coefficient x radius of all pins, is identified [m].
        drive_inertia: inertia of motor and gears at the crank, if the description of the crank does not include it [kg m2].
        loads: springs and other known forces that act in all runs.

    Raises:
        PinpressError: the press has several drivers; a record is shorter than one and a half strokes, or has no torque; some runs have
            currents and others torques; a prior or a friction is wrong; friction of a guide is given for a press without a slide.
        UnknownNameError: a link, pin, parameter or kind of friction does not exist.

    Warns:
        PinpressWarning: all runs are at one speed; the records do not determine a loss or the encoder's zero; the zero is off by some
            degrees; the encoder is too coarse; masses differ from the description by more than the prior allows; the two standard
            deviations of a parameter disagree; the size of the torque differs from that of the described press; residuals are above the
            noise of samples.
    """
    refuse_losses(press, friction, cylinder)
    wanted = Losses(tuple(friction), cylinder, checked_radii(press, radii))
    unknowns = unknowns_of(press, prior, wanted, known)
    records = checked_runs(press, runs)
    _doubt_runs(records)
    inertia = checked_inertia(drive_inertia)
    equations = [RunEquations(unknowns, wanted, inertia, tuple(loads), run, smoothed(run)) for run in records]
    current = records[0].current is not None
    start, unknowns, fit = _best(unknowns, equations, current)
    if not current and not 1 / 3 < start.torque < 3:
        caution(
            f"the torque is {start.torque:.2g} times the torque of the described press: check its unit, and the ratio of motor to crank,"
            " record(..., ratio=20.7)"
        )
    _doubt_fit(unknowns, fit)
    _doubt_residuals(records, fit)
    return _result(unknowns, fit, unknowns.equations.pressed(fit.values[: unknowns.inertial]), wanted)


def _best(unknowns: Unknowns, runs: Sequence[RunEquations], current: bool) -> tuple[Start, Unknowns, Fit]:
    """The estimates with the smallest residual, of those from all likely zeros of the encoder."""
    fits: list[tuple[Start, Unknowns, Fit]] = []
    refusals: list[PinpressError] = []
    for start in likely_starts(unknowns, runs):
        about = unknowns.about_zero(start.about)
        try:
            fits.append((start, about, _settled(about, [each._replace(unknowns=about) for each in runs], start.zero, current)))
        except PinpressError as error:
            refusals.append(error)
    if not fits:
        raise refusals[0]
    return min(fits, key=lambda each: sum(each[2].noise.values()))


def _settled(unknowns: Unknowns, runs: Sequence[RunEquations], zero: float, current: bool) -> Fit:
    """Estimates whose rows are linear about the estimates themselves; ``zero``: first estimate of the encoder's zero [rad].

    A step from pass to pass is halved if the change does not fall, which happens far from the solution, or if the cones make steps
    alternate.
    """
    start = np.array([each.value for each in unknowns.parameters])
    start[unknowns.zero] = zero
    fit = fitted(unknowns, [row for run in runs for row in run.rows(start, {})], current)
    slopes = [run.friction_slopes(fit.values) if set(BY_FORCE) & set(run.losses.friction) else {} for run in runs]
    about, change, step, longest, lengthened = fit.values, math.inf, 1.0, 1.0, False
    for _ in range(PASSES):
        fit = fitted(unknowns, [row for run, own in zip(runs, slopes, strict=True) for row in run.rows(about, own)], current)
        last, moving = change, fit.deviation > 0
        change = float((np.abs(fit.values - about)[moving] / fit.deviation[moving]).max())
        if change <= 1e-3:
            return fit
        if change < (1 - 0.5 * step) * last:
            lengthened |= step < longest
            step = min(2 * step, longest)
        else:
            step *= 0.5
            longest, lengthened = step if lengthened else longest, False
        about = about + step * (fit.values - about)
    if not change <= 1e-2:
        raise PinpressError(
            f"estimates still change by {change:.2g} of their deviations after {PASSES} passes: check signs and units of"
            " torque and angle and the values of known, leave out kinds of friction, or measure at more speeds"
        )
    return fit


def checked_runs(press: Linkage, runs: Sequence[MeasuredRun], for_torque: bool = True) -> list[MeasuredRun]:
    """Check the runs; raises PinpressError if they cannot be used together."""
    found = list(runs)
    if not found:
        raise PinpressError("there are no runs: give records, [pp.measured.record(...)]")
    for run in found:
        if not isinstance(run, MeasuredRun):
            raise PinpressError(f"a run is a {type(run).__name__}: give what measured.record returns, or a MeasuredRun")
        for link in run.added_mass:
            if link not in press.links:
                raise UnknownNameError("link", link, press.links)
        if for_torque and not quantities(run):
            raise PinpressError(f"{run.name} has no torque: name its column, record(..., torque='motor [N m]')")
    currents = [run.current is not None for run in found]
    if any(currents) and not all(currents):
        odd = found[currents.index(not currents[0])]
        raise PinpressError(
            f"{odd.name} and {found[0].name} have a torque and a current: give torques in all runs, or currents in all runs"
        )
    return found


def checked_inertia(drive_inertia: float) -> float:
    """Check the inertia that turns with the crank and is not part of the press; raises PinpressError if it is wrong."""
    inertia = number("drive_inertia", drive_inertia, "kg m2")
    if inertia < 0:
        raise PinpressError(
            f"drive_inertia is {inertia:g}: give the inertia of motor, gears and flywheel at the crank, not negative [kg m2]"
        )
    return positive("drive_inertia", inertia, "kg m2") if inertia else 0.0


def checked_radii(press: Linkage, radii: Mapping[str, float] | None) -> Mapping[str, float] | None:
    """Check the radii of pins; raises PinpressError or UnknownNameError if they are wrong."""
    if radii is None:
        return None
    for name in radii:
        if name not in press.bearings:
            raise UnknownNameError("bearing", name, press.bearings)
    return {name: positive(f"radius of {name}", radius, "m") for name, radius in radii.items()}


# ------------------------------------------------------------------------------------------------------------------------------- warnings


def _doubt_runs(runs: Sequence[MeasuredRun]) -> None:
    """Warn of records with little information."""
    speeds = np.abs([run.speeds for run in runs])
    if np.ptp(speeds) < 0.05 * speeds.max():
        caution(
            f"all runs are at {30 / math.pi * speeds.mean():.4g} r/min: then friction and inertia of the crank follow only from"
            " the description. Measure at two more speeds, or with a speed that changes by a third in 2.6 strokes"
        )
    coarse = 4000  # with fewer counts per turn the noise of the encoder is large
    for run in runs:
        step = run.resolution
        if step is not None and 2 * math.pi / step < coarse:
            caution(
                f"{run.name}: the angle has {2 * math.pi / step:.0f} steps a turn of the crank, so its noise is large: measure it at the"
                f" motor, record(..., angle_ratio=), or with an encoder of {2 * coarse} counts or more"
            )


def _doubt_fit(unknowns: Unknowns, fit: Fit) -> None:
    """Warn of estimates that can mislead."""
    from scipy.special import chdtrc  # to save start-up time

    names, before, by_noise = [each.name for each in unknowns.parameters], unknowns.deviation, deviations(fit.posterior)
    losses = range(unknowns.inertial, unknowns.zero)
    hidden = [names[k] for k in losses if by_noise[k] * fit.weight[k] > 0.3]  # of the rms torque
    if hidden:
        caution(
            f"{', '.join(hidden)}: these records cannot separate it from the other losses. Leave it out, or measure at other speeds, to"
            " separate viscous from constant friction"
        )
    zero, spread = float(fit.values[unknowns.zero]), float(by_noise[unknowns.zero])
    if abs(zero) > 0.3:
        caution(
            f"in the drawn pose the records show an angle of {math.degrees(zero):.5g} deg, not 0: give record(..., zero=) the"
            " encoder's reading in the drawn pose"
        )
    if spread > 0.5 * before[unknowns.zero]:
        caution(
            f"these records do not show the encoder's zero; it counts as {math.degrees(zero):.3g} ± {math.degrees(spread):.2g} deg:"
            f" gauge it at bottom dead centre, and give known={{'{ZERO}': (angle, deviation)}} [rad]"
        )
    changed, learnt = fit.misfit
    if learnt > 0 and chdtrc(learnt, changed) < 1e-4:
        caution(
            f"masses and inertias differ from the description by {math.sqrt(changed / learnt):.2g} times the prior: give a larger prior, or"
            " add to the description what it does not contain"
        )
    determined = [k for k in range(unknowns.inertial) if 0 < by_noise[k] < 0.5 * before[k]] + list(losses)
    scatter = deviations(fit.sandwich)
    apart = [names[k] for k in determined if scatter[k] > 2.5 * by_noise[k]]
    if apart:
        caution(
            f"{', '.join(apart[:4])}{' and others' if len(apart) > 4 else ''}: residuals scatter more than noise, so intervals"
            " are wider: an unmeasured force acts on the press, or the encoder is coarse"
        )


def _doubt_residuals(runs: Sequence[MeasuredRun], fit: Fit) -> None:
    """Warn of measured torques that differ from the torques of the identified press."""
    measured = [quantities(run)["torque"] for run in runs if "torque" in quantities(run)]
    if not measured:
        return
    noise, largest = float(np.median([sample_noise(each) for each in measured])), max(float(np.abs(each).max()) for each in measured)
    left = fit.noise["torque"]
    if left > max(3 * noise, 1e-3 * largest):  # smaller residuals do not matter
        caution(
            f"residuals of the identified press are {left / noise:.2g} times the noise of the torque: an effect has no"
            " parameter (force on the slide, another friction, an encoder that is zeroed again for each run), or a filter delays the"
            " torque"
        )


def _result(unknowns: Unknowns, fit: Fit, press: Linkage, losses: Losses) -> IdentifiedPress:
    before = unknowns.deviation

    def identified(parameter: Parameter, row: Array, known: bool, prior: float) -> IdentifiedParameter:
        """A weighted sum ``row`` (unknowns,) of the unknowns; ``prior``: its standard deviation before, if it was known."""
        value, name = float(row @ fit.values), parameter.name
        by_noise, by_blocks = (math.sqrt(max(float(row @ covariance @ row), 0.0)) for covariance in (fit.posterior, fit.sandwich))
        width = WIDE * max(by_noise, by_blocks)
        never_negative = np.count_nonzero(row) == 1 and (name.endswith(("mass", " I", " xx", " yy", " zz")) or "friction" in name)
        low = max(value - width, 0.0) if never_negative else value - width
        doubt = max(by_noise, by_blocks) / prior if known and prior else None
        return IdentifiedParameter(
            name, parameter.unit, parameter.value if known else None, value, low, value + width, by_noise, by_blocks, doubt
        )

    moving = np.flatnonzero(before > 0)
    records = [
        identified(unknowns.parameters[k], row, bool(np.isfinite(before[k])), float(before[k]))
        for k, row in enumerate(np.eye(len(before)))
        if before[k]
    ]
    bases, sums = base_parameters(unknowns.equations), []
    inertial = unknowns.at(np.zeros(unknowns.inertial))[1]
    for name, unit, row in zip(bases.names, bases.units, bases.matrix, strict=True):
        parameter = Parameter(name, unit, float(row @ unknowns.equations.values), 0.0)
        sums.append(identified(parameter, np.append(row, np.zeros(len(before) - len(row))), True, float(np.linalg.norm(row @ inertial))))
    found = {each.name: float(fit.values[k]) for k, each in enumerate(unknowns.parameters) if unknowns.inertial <= k < unknowns.zero}
    found |= {name: max(value, 0.0) for name, value in found.items() if "friction" in name}  # negative only by rounding errors
    friction: dict[str, Friction] = {}
    if "pins friction" in found:
        usual = PIN * press.size
        share, radii = found.pop("pins friction"), losses.radii
        friction = {name: Friction(share / usual, radius=usual) for name in turning_bearings(press)} if radii is None else {}
        friction |= {name: Friction(share, radius=radius) for name, radius in (radii or {}).items()}
    if "slide guide friction" in found:
        friction[press.joints[press.slide_guide.joint]] = Friction(found.pop("slide guide friction"))
    constant = fit.constant
    return IdentifiedPress(
        press,
        Records(IdentifiedParameter, records),
        Records(IdentifiedParameter, sums),
        fit.learnt,
        friction,
        found,
        None if constant is None else constant[0],
        None if constant is None else (constant[0] - WIDE * constant[1], constant[0] + WIDE * constant[1]),
        fit.noise,
        fit.posterior[np.ix_(moving, moving)],
    )
