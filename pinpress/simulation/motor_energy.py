"""What the motor of a run takes from the mains, where it goes, and how warm the motor becomes.

The powers of a motor that tells them, by a method ``power`` that returns a `MotorPower`, follow from speed, torque and states of a run that
is solved already, so that they are integrated afterwards, by Gauss-Legendre quadrature between the borders within which the run is smooth.
Heat and rise have one time constant, so that the rise between two instants is exact for the heat at the nodes:
rise(t2) = rise(t1) exp(-(t2 - t1) / T) + R / T x integral of exp(-(t2 - t) / T) heat(t) dt.
A direct-current link between mains and motor does not act back on the run either; its energy follows from the same powers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..common import tables
from ..common.arguments import finite_numbers, positive
from ..common.errors import PinpressError, caution, said, shown
from ..common.numerics import gauss_rule
from ..common.quantities import Array
from ..common.results import Tabular
from ..drives.direct_current_link import AT_LIMIT, NOT, Course, DirectCurrentLink, LinkedPower
from ..drives.electric import ElectricMotor, MotorPower
from ..drives.motors import InductionMotor, InverterMotor, ServoMotor
from ..drives.slip_clutch import SlipClutchMotor
from ..drives.transmission import innermost
from ..loads.caller_laws import as_given
from .driven_press import DrivenPress
from .trajectory import Sample, Trajectory

LOSSES = ("slip", "load", "constant", "gears", "inverter", "resistor")
FLOWS = ("mains", "drive", *LOSSES, "heat")
"""Powers of a motor: from the mains, of the drive on the crank, those lost on the way, and of these what warms the motor."""
MAINS, DRIVE, SLIP, HEAT = FLOWS.index("mains"), FLOWS.index("drive"), FLOWS.index("slip"), FLOWS.index("heat")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class EnergyFlow(Tabular):
    """Where the power of a motor goes in a run, at its n states. mains = drive + all losses, at every instant; with a link, + capacitor.

    Attributes:
        linkage: name of the linkage.
        time: (n,) [s].
        power: (n,) [W] by name: from the "mains" (negative where braking feeds them), of the "drive" on the crank's shaft; lost by "slip",
            with the square of the "load", as a "constant", whatever the torque, in "gears", "inverter", and the brake "resistor"; and the
            "heat" of slip, load and constant loss that warms the motor. With a direct-current link also that into its "capacitor",
            negative where it gives power, and the "resistor" is also that of the link.
        work: (n,) the same since the start of the run [J].
        strokes: number of strokes in the run; None if the slide has none.
        temperature_rise: (n,) of the motor above its surroundings [K]; None if its rise at the rated point or its time constant is not
            known.
        settled_rise: to which it would settle, if the run were repeated for good [K].
        voltage: (n,) of the direct-current link [V]; None without one.
    """

    linkage: str
    time: Array
    power: Mapping[str, Array]
    work: Mapping[str, Array]
    strokes: float | None
    temperature_rise: Array | None
    settled_rise: float | None
    voltage: Array | None

    @property
    def mean_power(self) -> float:
        """From the mains [W]; 3600 times as much is taken in an hour [J]."""
        return float(self.work["mains"][-1] / self.time[-1])

    @property
    def work_per_stroke(self) -> float | None:
        """From the mains [J]; None if there is no stroke."""
        return None if not self.strokes else float(self.work["mains"][-1]) / self.strokes

    @property
    def efficiency(self) -> float | None:
        """Work of the drive on the crank by that from the mains; None if one of them is not positive."""
        from_mains, on_crank = float(self.work["mains"][-1]), float(self.work["drive"][-1])
        return on_crank / from_mains if from_mains > 0 and on_crank > 0 else None

    @property
    def title(self) -> str:
        from_mains, mean = float(self.work["mains"][-1]), self.mean_power
        work, power = tables.scale("J", [from_mains]), tables.scale("W", [mean])
        return (
            f"EnergyFlow of {self.linkage}: {work.shown(from_mains)} {work.unit} from the mains in {self.time[-1]:.6g} s, mean"
            f" {power.shown(mean)} {power.unit}"
        )

    @property
    def _pictured(self) -> tuple[str, ...]:
        return "time [s]", "mains_power [W]", "drive_power [W]"

    def columns(self) -> dict[str, Array]:
        """Time, all powers and losses, the work from the mains, the temperature rise, and the voltage of a link."""
        columns = {"time [s]": self.time}
        columns |= {f"{name}_{'loss' if name in LOSSES else 'power'} [W]": power for name, power in self.power.items()}
        columns["mains_work [J]"] = self.work["mains"]
        columns |= {} if self.temperature_rise is None else {"temperature_rise [K]": self.temperature_rise}
        return columns | ({} if self.voltage is None else {"link_voltage [V]": self.voltage})


@dataclass(frozen=True, eq=False)
class MotorUse:
    """Powers of a motor, integrated between instants.

    Attributes:
        edges: (m + 1,) instants between which the powers are smooth [s].
        mains: (m, nodes) power that the motor takes, at the nodes of the quadrature between them [W].
        work: (flows, n) the `FLOWS` since the first instant [J].
        elapsed: (n,) time since the first instant, in time constants of the motor's temperature.
        rise: (n,) rise by the heat since the first instant [K]; None if it is not known.
    """

    edges: Array
    mains: Array
    work: Array
    elapsed: Array
    rise: Array | None

    @property
    def settled_rise(self) -> float | None:
        """Rise at the first and last instant, if what happens between them is repeated for good [K]."""
        return None if self.rise is None else float(self.rise[-1] / -np.expm1(-self.elapsed[-1]))


def motor_of(driven: DrivenPress) -> Any | None:
    """The drive that tells where its power goes, see `Drive`; None if a press has no such drive."""
    motor = None if driven.drive is None else as_given(innermost(as_given(driven.drive))[0])
    return motor if callable(getattr(motor, "power", None)) else None


def needed_motor(driven: DrivenPress) -> Any:
    """`motor_of`; raises PinpressError where there is none."""
    motor = motor_of(driven)
    if motor is None:
        raise PinpressError(
            "the drive is no motor whose power from the mains is known: give an InductionMotor, InverterMotor, SlipClutchMotor or"
            " ServoMotor, or a drive of your own with a method power"
        )
    return motor


def flows(driven: DrivenPress, times: Array, sample: Sample) -> Array:
    """(flows, n) the `FLOWS` of a sample at times (n,) [W]; raises PinpressError where they are not finite."""
    motor, ratio = needed_motor(driven), innermost(as_given(driven.drive))[1]
    angle = _crank_angle(driven, sample)
    with np.errstate(all="ignore"):  # what is not finite is refused below
        power = _power(motor, ratio * sample.drive_speed, ratio * angle, times, tuple(sample.drive_states))
    on_crank = sample.drive_torque * sample.drive_speed
    # A smaller loss in gears is the rounding of both powers.
    in_gears = np.where(np.abs(power.shaft - on_crank) > 1e-14 * np.abs(on_crank), power.shaft - on_crank, 0.0)
    parts = (power.mains, on_crank, power.slip, power.load, power.constant, in_gears, power.inverter, power.resistor, power.heat)
    powers = np.array([np.broadcast_to(part, times.shape) for part in parts])
    if not np.isfinite(powers).all():
        raise PinpressError(f"the losses of the {type(motor).__name__} are too large for floating point: give smaller ones [W]")
    return powers


def _crank_angle(driven: DrivenPress, sample: Sample) -> Array:
    return np.asarray(sample.position[driven.press.driver_indices[0] if len(sample.position) > 1 else 0])


def _power(motor: Any, speed: Array, angle: Array, times: Array, states: tuple[Array, ...]) -> MotorPower:
    """Where the power of a motor goes; raises PinpressError where a caller's own drive does not tell it, or its torque says otherwise."""
    try:
        power = motor.power(speed, angle, times, states)
    except PinpressError:
        raise
    except Exception as error:  # whatever a caller's own drive raises
        raise PinpressError(f"{type(motor).__name__}: power cannot be worked out: {said(error)}") from error
    wanted = f"give a pinpress.drives.MotorPower of {times.shape} numbers each, or numbers"
    if not isinstance(power, MotorPower):
        raise PinpressError(f"{type(motor).__name__}: power is {shown(power)}: {wanted}")
    for name, part in power._asdict().items():
        values = finite_numbers(part)
        if values is None and not isinstance(motor, ElectricMotor | ServoMotor):
            raise PinpressError(f"{type(motor).__name__}: {name} of its power is {shown(part)}: {wanted}, all finite")
        if values is not None and values.shape not in ((), times.shape):
            raise PinpressError(f"{type(motor).__name__}: {name} of its power has shape {values.shape}: {wanted}")
    shaft = motor.torque(speed, angle, times, states) * speed
    apart = np.abs(power.shaft - shaft)
    if (apart > 1e-9 * np.abs(shaft).max()).any():  # less is the rounding of the caller's formulas
        k = int(np.argmax(np.broadcast_to(apart, times.shape)))
        raise PinpressError(
            f"{type(motor).__name__}: shaft of its power is {np.broadcast_to(power.shaft, times.shape)[k]:.6g} W at {speed[k]:.6g} rad/s,"
            f" where its torque has {np.broadcast_to(shaft, times.shape)[k]:.6g} W: give torque x speed"
        )
    return power


def integrate_powers(motor: Any, driven: DrivenPress, trajectory: Trajectory, instants: Array) -> MotorUse:
    """What a motor takes and loses between rising instants (n,).

    Raises:
        PinpressError: the motor's time constant is too short, or its losses or rise too large for floating point.
    """
    rule, borders = gauss_rule(), trajectory.borders
    first, last = np.searchsorted(borders, [instants[0], instants[-1]])
    edges = np.unique(np.concatenate([instants, borders[first:last]]))
    resistance, time = (getattr(motor, name, None) for name in ("thermal_resistance", "thermal_time"))
    constant = math.inf if resistance is None or time is None else float(positive(f"{type(motor).__name__}: thermal_time", time, "s"))
    edges = _cut(edges, constant)
    if motor.timed:  # the speeds at which others are not smooth are borders; of these they are not known
        edges = _halve(driven, trajectory, edges)
    half = 0.5 * np.diff(edges)
    times, power = _at_nodes(driven, trajectory, edges[:-1], edges[1:])
    gains = half * (power @ rule.weights)
    work = np.concatenate([np.zeros((len(FLOWS), 1)), gains.cumsum(axis=1)], axis=1)
    places, elapsed = edges.searchsorted(instants), (instants - instants[0]) / constant
    if resistance is None or constant == math.inf:
        return MotorUse(edges, power[MAINS], work[:, places], elapsed, None)
    with np.errstate(all="ignore"):  # what is not finite is refused below
        warmed = (
            float(np.ravel(resistance)[0])
            * (half / constant)
            * ((np.exp((times - edges[1:, None]) / constant) * power[HEAT]) @ rule.weights)
        )
    rise = [0.0]
    for share, more in zip(np.exp(-2.0 * half / constant).tolist(), warmed.tolist(), strict=True):
        rise.append(rise[-1] * share + more)
    if not math.isfinite(sum(rise) + float(work[:, -1].sum())):
        rated_rise = getattr(motor, "rated_rise", None)
        raise PinpressError(f"rated_rise of the {type(motor).__name__} is {shown(rated_rise)}: give that of its data sheet [K]")
    return MotorUse(edges, power[MAINS], work[:, places], elapsed, np.array(rise)[places])


def _at_nodes(driven: DrivenPress, trajectory: Trajectory, starts: Array, ends: Array) -> tuple[Array, Array]:
    """Times (n, nodes) of the quadrature over intervals (n,), and the powers (flows, n, nodes) there."""
    times = 0.5 * (starts + ends)[:, None] + 0.5 * (ends - starts)[:, None] * gauss_rule().nodes
    power = flows(driven, times.ravel(), trajectory.at(times.ravel(), complete=False))
    return times, power.reshape(len(FLOWS), *times.shape)


def _halve(driven: DrivenPress, trajectory: Trajectory, edges: Array) -> Array:
    """Edges (n,) with more of them where the powers are not smooth: an interval is halved until both halves together agree with it, to a
    share of all work."""

    def works(starts: Array, ends: Array) -> Array:
        return np.asarray(0.5 * (ends - starts) * (_at_nodes(driven, trajectory, starts, ends)[1] @ gauss_rule().weights))

    starts, ends = edges[:-1], edges[1:]
    whole = works(starts, ends)
    largest, all_edges = float(np.abs(whole).sum(axis=1).max()), [edges]
    for _ in range(20):  # where a power jumps, what is left after these is a millionth of the interval
        middle = 0.5 * (starts + ends)
        first, second = works(starts, middle), works(middle, ends)
        rough = (np.abs(first + second - whole) > 1e-11 * largest).any(axis=0)
        if not rough.any():
            break
        all_edges.append(middle[rough])
        starts, ends = np.concatenate([starts[rough], middle[rough]]), np.concatenate([middle[rough], ends[rough]])
        whole = np.concatenate([first[:, rough], second[:, rough]], axis=1)
    return np.unique(np.concatenate(all_edges))


def _cut(edges: Array, longest: float) -> Array:
    """Edges (n,) with more of them between, none farther from the next than a time constant, over which the quadrature is exact to
    rounding."""
    pieces = np.ceil(np.diff(edges) / longest).clip(1.0)
    if not pieces.sum() <= 1_000_000:  # more take too much memory
        raise PinpressError(
            f"the motor's thermal_time is {longest:g} s, and the run lasts {edges[-1] - edges[0]:g} s: give the time constant of its"
            " temperature, which is minutes"
        )
    count = pieces.astype(int)
    place = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    inner = np.repeat(edges[:-1], count) + np.repeat(np.diff(edges) / pieces, count) * place
    return np.append(inner, edges[-1])


class ChargedLink(NamedTuple):
    """A direct-current link of a run, as `pinpress.measures.motor_energy` is given it."""

    link: DirectCurrentLink
    voltage: float | None  # at the start [V]; None: that of a stroke that has been repeated for good


def motor_energy_of(
    driven: DrivenPress, times: Array, trajectory: Trajectory, strokes: float | None, initial_rise: float | None, link: ChargedLink | None
) -> EnergyFlow:
    """The `EnergyFlow` at times (n,). Raises as `pinpress.measures.motor_energy`."""
    motor = needed_motor(driven)
    if link is not None:
        _refuse_without_link(motor)
    use = integrate_powers(motor, driven, trajectory, times)
    if initial_rise is not None and use.rise is None:
        raise PinpressError("initial_rise: the motor's temperature is not known: give the motor a rated_rise and a thermal_time")
    power = flows(driven, times, trajectory.at(times, complete=False))
    begin = use.settled_rise if initial_rise is None else initial_rise
    rise = None if use.rise is None or begin is None else use.rise + begin * np.exp(-use.elapsed)
    powers, works = dict(zip(FLOWS, power, strict=True)), dict(zip(FLOWS, use.work, strict=True))
    voltage = None
    if link is not None:
        voltage = _feed(powers, works, _course(driven, trajectory, use, link), link.link, times)
    return EnergyFlow(
        linkage=driven.press.name,
        time=times,
        power=powers,
        work=works,
        strokes=strokes,
        temperature_rise=rise,
        settled_rise=use.settled_rise,
        voltage=voltage,
    )


# ------------------------------------------------------------------------------------------------------------------- direct-current link


def _refuse_without_link(motor: Any) -> None:
    """Raise PinpressError where a motor has no direct-current link, or gives nothing back to it."""
    name = type(motor).__name__
    if isinstance(motor, InductionMotor | SlipClutchMotor):
        raise PinpressError(f"link: the {name} is on the mains, without a direct-current link: leave link out, or drive by a ServoMotor")
    if isinstance(motor, InverterMotor) and not motor.feeds_back:
        raise PinpressError("link: the InverterMotor burns what braking gives back itself: give it feeds_back=True, the link takes that")
    if isinstance(motor, ServoMotor) and not motor.regeneration:
        raise PinpressError(
            "link: the ServoMotor has regeneration=0, which burns what braking gives back before the link gets it: give the share that"
            " its converter lets through, 1 where that loses nothing"
        )


def _course(driven: DrivenPress, trajectory: Trajectory, use: MotorUse, link: ChargedLink) -> Course:
    """The course of a link's energy; raises PinpressError where its voltage falls below the lower one."""
    linked, parts = LinkedPower(link.link, use.edges, use.mains), link.link
    begin = linked.settled() if link.voltage is None else parts.energy_at(link.voltage)
    if begin is None:
        mean = float(use.work[MAINS, -1]) / float(use.edges[-1] - use.edges[0])
        raise PinpressError(
            f"link: a stroke takes {mean:.6g} W on average, more than its mains_power of {parts.mains_power:.6g} W: the voltage falls"
            " from stroke to stroke; give more mains_power, or a slower motion"
        )
    course, lowest = linked.course(begin), parts.energy_at(parts.lower_voltage)
    short = lowest - float(course.energy.min())
    # Less than this share of the link's swing of energy is rounding.
    if short > 1e-9 * float(np.ptp(course.energy)):
        time = float(course.times[int(np.argmin(course.energy))])
        angle = float(_crank_angle(driven, trajectory.at(np.array([time]), complete=False))[0])
        raise PinpressError(
            f"link: at {time:.6g} s, at {driven.press.driver_coordinates[0].at(angle)}, {short:.6g} J are missing to hold its lower_voltage"
            f" of {parts.lower_voltage:g} V: give it more capacitance than {parts.capacitance:g} F, more mains_power or a higher"
            " charged_voltage"
        )
    if not np.isin(course.feeding, (NOT, AT_LIMIT)).any():
        caution("link: braking gives nothing back and the mains have no limit that is reached: the capacitor does nothing")
    return course


def _feed(powers: dict[str, Array], works: dict[str, Array], course: Course, link: DirectCurrentLink, times: Array) -> Array:
    """Put a link between mains and motor into powers and works (n,) by name at times (n,), and return its voltage (n,) [V]."""
    by_motor = powers["mains"]
    mains, burnt = course.powers(link, times, by_motor)
    powers |= {"mains": mains, "resistor": powers["resistor"] + burnt, "capacitor": mains - by_motor - burnt}
    mains_work, burnt_work, energy = course.works(times)
    works |= {"mains": mains_work, "resistor": works["resistor"] + burnt_work, "capacitor": energy - energy[0]}
    return link.voltage_at(energy)


def duty_of_motor(driven: DrivenPress, trajectory: Trajectory, start: float, end: float) -> dict[str, float | None]:
    """What a motor takes and loses from one time to another, as fields of `MotorDuty`."""
    motor = motor_of(driven)
    names = ("mains_work", "slip_loss", "efficiency", "settled_rise")
    if motor is None:
        return dict.fromkeys(names)
    use = integrate_powers(motor, driven, trajectory, np.array([start, end]))
    mains, on_crank, slip = (float(use.work[flow, -1]) for flow in (MAINS, DRIVE, SLIP))
    efficiency = on_crank / mains if mains > 0 and on_crank > 0 else None
    assert use.settled_rise is None or math.isfinite(use.settled_rise)
    return dict(zip(names, (mains, slip, efficiency, use.settled_rise), strict=True))
