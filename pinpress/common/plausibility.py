"""Warnings about arguments that are allowed but probably a mistake: speeds, heights and points in another unit.

A limit is far beyond the presses that are built, and the warning names the unit that may be meant.
"""

import math
from collections.abc import Sequence

import numpy as np

from .errors import caution
from .quantities import CRANK, GRAVITY, RPM, Array, DriverCoordinate

FASTEST = 1000.0  # no crank or motor of a press turns faster [rad/s], 9549 r/min
FASTEST_SLIDING = 10.0  # no cylinder, screw or slide of a press is faster [m/s]
FAR = 10.0  # no part of a press is further away [lengths of the linkage]
MILLI = 1e-3
STEEPEST = 10.0  # no motor has a larger breakdown torque or overload [of the rated torque]
DAMPED = 2.0  # no rubber has a larger loss factor
UNWEIGHED = 1e-5  # mass up to which a slide stands for one without mass, as of a table with ``masses: none`` [kg]


def speeds(name: str, values: Array | float, coordinate: DriverCoordinate = CRANK, slide: tuple[float, float] = (0.0, 0.0)) -> None:
    """Warn of speeds of a driver [rad/s or m/s], of any shape, that no press runs at: they may be in r/min or mm/s.

    Args:
        name: what they are, as messages call it.
        values: the speeds.
        coordinate: what the driver's coordinate is.
        slide: largest speed [m/s] and acceleration [m/s2] of the slide at the highest of these speeds of a crank; 0 where not known.
    """
    fastest = abs(values) if isinstance(values, float) else float(np.abs(values).max(initial=0.0))
    if not coordinate.turns:
        if fastest > FASTEST_SLIDING:
            caution(f"{name} is {fastest:g} m/s: if {fastest:g} mm/s are meant, write {fastest:g}e-3")
    elif fastest > FASTEST or too_hard(*slide):
        said = f"{name} is {fastest:g} rad/s, {fastest / RPM:g} r/min"
        said += f", at which the acceleration of the slide reaches {slide[1] / GRAVITY:.3g} g" if too_hard(*slide) else ""
        caution(f"{said}: lower it; in Python {fastest:g} r/min are {fastest:g} * pinpress.RPM")


def angles(name: str, values: Array) -> None:
    """Warn of crank angles [rad], one, (n,) or (n, drivers), that are degrees of a turn or two.

    Whole radians alone are no proof, because a crank may turn many times. People write degrees as multiples of fifteen, as several
    multiples of five, or as smaller steps from one multiple of fifteen to another, perhaps without the last step.
    """
    largest = float(np.abs(values).max(initial=0.0))
    if not 30.0 <= largest <= 720.0 or (values % 1.0).any():
        return
    several = values.size > 2 and np.ptp(values) >= 30.0
    in_degrees = (values % 15.0 == 0.0).all() or (several and (values % 5.0 == 0.0).all())
    if several and not in_degrees:
        last, before = values[-1], values[max(len(values) - 2, 0)]
        ends = last, last + (last - before)  # the last step may be left out
        in_degrees = not (values[0] % 15.0).any() and any(not (end % 15.0).any() for end in ends)
    if in_degrees:
        caution(f"{name} is {'' if values.size == 1 else 'up to '}{largest:g} rad: if degrees are meant, write numpy.radians({name})")


def motor(
    name: str, torque: Array | float, speed: float, inertia: Array | float, units: str = "rated_torque in N m", lossless: float = 0.0
) -> None:
    """Warn of a motor whose numbers do not belong together.

    Args:
        name: of its class.
        torque: its rated one [N m], a number or (S,).
        speed: its rated one [rad/s].
        inertia: of its rotor [kg m2], a number or (S,).
        units: the argument that gives its torque, and its unit.
        lossless: its constant loss [W].
    """
    start = float(np.max(np.asarray(inertia) * speed / torque))
    if start > 60.0:  # [s]: 0.01 to 1 s are usual
        caution(f"{name}: its rated torque takes {start:.3g} s to turn its own rotor up to speed: give {units}, and inertia in kg m2")
    # No motor loses less than a ten-thousandth of its rated power in iron, bearings and fan.
    if 0.0 < lossless < 1e-4 * float(np.min(torque)) * speed:
        caution(f"{name}: constant_loss is {lossless:g} W: if kW are meant, write {lossless:g}e3")


def share(name: str, value: float, largest: float) -> None:
    """Warn of a ratio above the ``largest`` that there is: it may be in per cent."""
    if value > largest:
        caution(f"{name} is {value:g}: if per cent are meant, write {value:g}e-2")


def rise(name: str, value: float | None) -> None:
    """Warn of a temperature rise of a motor [K] that may be a temperature."""
    if value is not None and 200.0 < value < 1000.0:  # no motor becomes warmer by as much, but has such temperatures
        caution(f"{name} is {value:g} K: give by how much it becomes warmer than what is around it, not its temperature")


def engagement(name: str, time: float) -> None:
    """Warn of a time [s] in which a clutch or brake builds up its torque that may be in ms."""
    if time > 10.0:
        caution(f"{name} is {time:g} s: if ms are meant, write {time:g}e-3")


def stripping(name: str, force: float, cutting: float) -> None:
    """Warn of a stripping force [N] that is so small compared with the ``cutting`` force [N] that it may be in kN."""
    if 0.0 < force < 1e-3 * cutting:  # no sheet holds a punch by less
        caution(f"{name} is {force:g} N, beside a force of {cutting:g} N: if kN are meant, write {force:g}e3")


def torque(name: str, value: float, holding: float) -> None:
    """Warn of a torque at the crank [N m] far below the torque ``holding`` the weight of the slide at half its stroke [N m]."""
    if 0.0 < value < 0.005 * holding:  # friction would stop such a motor, clutch or brake
        caution(
            f"{name} is {value:.4g} N m at the crank, {100 * value / holding:.2g} % of the {holding:.4g} N m that hold the weight of the"
            " slide: give torques in N m and powers in W, and the ratio of the gears"
        )


def idle_speed(name: str, speed: float, slide: tuple[float, float], at_half: tuple[float, float]) -> None:
    """Warn of a motor that would turn the idle crank at a ``speed`` [rad/s] at which no press runs.

    Args:
        name: of its class.
        speed: of the crank.
        slide: largest speed [m/s] and acceleration [m/s2] of the slide there.
        at_half: both at half the speed. A speed that is only a little too high is warned of as the speed of the run.
    """
    if speed > FASTEST or too_hard(*at_half):
        said = f", at which the acceleration of the slide reaches {slide[1] / GRAVITY:.3g} g" if too_hard(*slide) else ""
        remedy = "put gears between them, pinpress.drives.Geared(motor, ratio), whose ratio is the motor's speed by that of the crank"
        caution(f"{name} would turn the crank at {speed / RPM:.4g} r/min{said}: {remedy}")


def flywheel(inertia: float, mass: float, size: float) -> None:
    """Warn of a flywheel's moment of inertia [kg m2] on a linkage of that ``mass`` [kg] and ``size`` [m]."""
    # No flywheel has as large a moment of inertia as ten thousand linkages; a million times larger, it is meant to hold the speed.
    if 1e4 * mass * size**2 < inertia < 1e6 * mass * size**2:
        beside = f"beside a linkage of {mass:.4g} kg and {size:.3g} m"
        caution(f"Flywheel: inertia is {inertia:g} kg m2, {beside}: if kg mm2 are meant, write {1e-6 * inertia:g}")


def too_hard(speed: float, acceleration: float) -> bool:
    """Whether no slide of a press reaches both this speed [m/s] and this acceleration [m/s2]; fast presses reach 20 to 30 g.

    One of the two is not enough: near a change point a slide jerks at the lowest speeds; very short strokes may have high accelerations.
    """
    return speed > 3.0 and acceleration > 40 * GRAVITY


def heights(load: str, stretches: Sequence[tuple[float, float]], low: float, high: float, size: float, contact: bool = False) -> None:
    """Warn of a process load that acts nowhere on the slide's stroke, or ends far above it or far from the linkage: its heights may be in
    mm.

    Args:
        load: its name.
        stretches: lower and upper ends [m], both ways.
        low: lower end of the stroke, as height above the load's datum [m]; infinite where it is not known.
        high: upper end of the stroke, also above the datum [m].
        size: length of the linkage [m].
        contact: whether the load is a contact without a lower end, which the slide may touch all the time, or just miss.
    """
    if not stretches:
        return
    lowest, highest = min(lower for lower, _ in stretches), max(upper for _, upper in stretches)
    said = f"{load} acts from {lowest:g} to {highest:g} m above its datum"
    remedy = "give heights and datum in m"
    stroke = high - low
    lowered = low - stroke if contact else low
    if math.isfinite(stroke) and all(lower >= high or upper <= lowered for lower, upper in stretches):
        caution(f"{said}, nowhere on the slide's stroke, which goes from {low:g} to {high:g} m: {remedy}")
    elif math.isfinite(highest - lowest) and max(abs(lowest), abs(highest)) > FAR * size:  # without ends it acts everywhere, as is meant
        caution(f"{said}, far off a linkage of {size:g} m: {remedy}")
    elif not contact and math.isfinite(stroke) and high + stroke < highest < high / MILLI:  # further up it may be meant to act everywhere
        caution(f"{load} acts up to {highest:g} m above its datum, and the slide's stroke ends at {high:.6g} m: {remedy}")


def stepped_over(load: str, stretch: tuple[float, float], step: tuple[float, float], states: int) -> None:
    """Warn of a process load that acts only between two states of a motion and therefore changes no number.

    Args:
        load: its name.
        stretch: lower and upper height from which and up to which it acts [m].
        step: lower and upper height of the slide between which the motion has no state [m].
        states: number of the motion's states.
    """
    reach = f"from {stretch[0]:.4g} to {stretch[1]:.4g} m" if math.isfinite(stretch[0]) else f"below {stretch[1]:.4g} m"
    caution(
        f"{load} acts {reach} above its datum, and none of the motion's {states} states is there: from {step[1]:.4g} m the slide goes on to"
        f" {step[0]:.4g} m, so that the load changes no number; give the motion more points"
    )


def onset(load: str, start: float, high: float) -> None:
    """Warn of a process load that begins from zero above the stroke, so that it has its force already at top dead centre."""
    caution(f"{load} begins at {start:g} m above its datum, and the slide's stroke ends at {high:.6g} m: it begins with a jump; lower it")


def forces(load: str, largest: float, weight: float, feeble: float = 0.05) -> None:
    """Warn of a process load whose ``largest`` force is a ``feeble`` share of the ``weight`` of the slide [N], or less: it may be in kN."""
    if 0.0 < largest < min(1e4, feeble * weight):  # [N]
        share = f"{100 * largest / weight:.2g} % of the weight of the slide"
        caution(f"{load}: its largest force is {largest:g} N, {share}: if kN are meant, write {1e3 * largest:g}")
    # No process takes a hundred thousand weights of the slide; a force of 1e12 weights and more stands for a stop.
    elif weight > GRAVITY * UNWEIGHED and 1e5 * weight < largest < 1e12 * weight:
        caution(f"{load}: its largest force is {largest:g} N, {largest / weight:.2g} times the weight of the slide: give it in N")


def springs(name: str, stiffness: float, load: float, size: float) -> None:
    """Warn of springs [N/m] that the ``load`` [N], the weight of the slide, deflects more than in any press of that ``size`` [m]."""
    if load > 5e-3 * size * stiffness:
        caution(
            f"{name} is {stiffness:g} N/m, which the weight of the slide, {load:.3g} N, deflects by {1e3 * load / stiffness:.3g} mm: give"
            " N/m, 1e6 for 1 kN/mm"
        )


def turning_springs(name: str, stiffness: float, moment: float) -> None:
    """Warn of springs against turning [N m/rad] that a ``moment`` [N m] turns more than in any press."""
    if moment > 1.0 * stiffness:  # [rad]
        caution(
            f"{name} is {stiffness:g} N m/rad, which the weight of the slide at the length of the linkage, {moment:.3g} N m, turns by"
            f" {moment / stiffness:.3g} rad: give N m/rad, 1e6 for 1 kN m/mrad"
        )


def crown(mass: float, links: float) -> None:
    """Warn of a crown that is so light compared with all ``links`` [kg] that its ``mass`` [kg] may be in t."""
    if mass < 0.01 * links:
        caution(f"Elastic: crown_mass is {mass:g} kg, beside {links:.4g} kg of the links: if t are meant, write {mass:g}e3")


def release(force: float, stiffness: float, mass: float, break_time: float, clearance: float) -> None:
    """Warn of a break-through whose numbers may be in N/mm, t, ms or mm."""
    if force > 0.1 * stiffness:  # [m]: no press yields by more
        caution(f"stiffness is {stiffness:g} N/m, which {force:g} N deflect by {1e3 * force / stiffness:.3g} mm: give N/m, 1e6 for 1 kN/mm")
    if (frequency := math.sqrt(stiffness / mass) / (2 * math.pi)) > 2e3:  # [Hz]: no press swings faster
        caution(f"mass is {mass:g} kg, which swings at {frequency:.3g} Hz on {stiffness:g} N/m: if t are meant, write {mass:g}e3")
    if break_time > 0.5:
        caution(f"break_time is {break_time:g} s: if ms are meant, write {break_time:g}e-3")
    if clearance > 0.01:  # of all bearings in a line
        caution(f"clearance is {clearance:g} m: if mm are meant, write {clearance:g}e-3")


def modulus(value: float) -> None:
    """Warn of a modulus of elasticity of metal [Pa] that may be in GPa or MPa."""
    if value < 1e7:
        caution(f"modulus is {value:g} Pa: if GPa are meant, write {value:g}e9; if MPa, {value:g}e6")


def section(name: str, area: float, second_moment: float, length: float) -> None:
    """Warn of an area [m2] and a second moment of area [m4] of a section that no beam of this ``length`` [m] has."""
    radius = math.sqrt(second_moment / area)
    if area > FAR**2 * length**2 or radius > length or radius < 1e-4 * length:
        said = f"area {area:g} m2 and second_moment {second_moment:g} m4 are those of no section of a link of {length:.3g} m"
        caution(f"{name}: {said}: give m2 and m4, 1e-6 for 1 mm2 and 1e-12 for 1 mm4")


def mounts(weight: float, stiffness: float) -> None:
    """Warn of mounts [N/m, all together] that the ``weight`` [N] on them presses in more than any real mount."""
    if weight > 0.5 * stiffness:  # [m]: that is a vibration of 0.7 Hz
        caution(
            f"mounts: the weight of {weight:.4g} N presses them in by {1e3 * weight / stiffness:.3g} mm: give stiffness in N/m, 1e6 for"
            " 1 kN/mm, and mass in kg"
        )


def frame_inertia(mass: float, inertia: float, size: float) -> None:
    """Warn of a frame's largest moment of inertia [kg m2] that does not belong to its ``mass`` [kg], around a linkage of this ``size``
    [m]."""
    radius = math.sqrt(inertia / mass)
    if inertia > 0 and not 0.1 * size < radius < 10.0 * size:
        caution(
            f"frame: with a mass of {mass:g} kg and a moment of inertia of {inertia:g} kg m2 its radius of gyration is {radius:.3g} m,"
            f" around a linkage of {size:.3g} m: give kg and kg m2"
        )


def stroke_time(name: str, value: float) -> None:
    """Warn of a time of a stroke, or between strokes [s], that may be in ms, or a number of strokes a minute."""
    if value > 120.0:
        caution(f"{name} is {value:g} s: if ms are meant, write {value:g}e-3; n strokes a minute take 60 / n")


def slide_speed(name: str, value: float) -> None:
    """Warn of a speed of the slide [m/s] that may be in mm/s."""
    if value > FASTEST_SLIDING:
        caution(f"{name} is {value:g} m/s: if mm/s are meant, write {value:g}e-3")


def target(name: str, value: float, size: float) -> None:
    """Warn of a target for the place of a dead centre [m] that may be in mm or um, of a linkage of that ``size`` [m]."""
    if value > 0.1 * size:
        caution(f"{name} is {value:g} m, beside a linkage of {size:.3g} m: give it in m, {value:g}e-6 if um are meant")


def lean(name: str, value: float) -> None:
    """Warn of a difference of heights over the points of a slide [m] that may be in mm."""
    if value > 5e-3:
        caution(f"{name} is {value:g} m: if mm are meant, write {value:g}e-3")


def contact(load: str, force: float, depth: float, weight: float, size: float) -> None:
    """Warn of a contact whose ``force`` [N] at a ``depth`` [m] is so small compared with the ``weight`` of the slide [N] that its stiffness
    may be in N/mm; ``size``: of the linkage [m]."""
    if depth > 1e-3 * size and 0.0 < force < 0.01 * weight:
        share = f"{100 * force / weight:.2g} % of the weight of the slide"
        caution(f"{load}: {depth:g} m deep its force is {force:g} N, {share}: give stiffness in N/m, 1e6 for 1 kN/mm")


def point(name: str, position: Array, size: float) -> None:
    """Warn of a point (3,) in a link's frame that is far off a linkage of that ``size`` [m], and in mm would be on it, or near."""
    distance = float(np.abs(position).max())
    if FAR * size < distance <= FAR * size / MILLI:
        caution(f"{name} is {distance:g} m from its link's origin, far off a linkage of {size:g} m: give x, y, z in m")


def length(name: str, value: float, size: float) -> None:
    """Warn of a length that is far larger than a linkage of that ``size`` [m], and in mm would fit it."""
    if FAR * size < value <= FAR * size / MILLI:
        caution(f"{name} is {value:g} m, beside a linkage of {size:g} m: give it in m, {value:g}e-3 if mm are meant")


def friction(name: str, coefficient: float, radius: float, size: float, preload: float = 0.0) -> None:
    """Warn of friction of a bearing with a coefficient above 1, a ``radius`` above the ``size`` of the linkage [m], or a ``preload`` [N]
    that may be in kN."""
    if coefficient > 1:
        caution(f"friction of {name}: its coefficient is {coefficient:g}: if per cent are meant, write {coefficient:g}e-2")
    if radius > size:
        caution(f"friction of {name}: its radius is {radius:g} m, beside a linkage of {size:g} m: if mm are meant, write {radius:g}e-3")
    if 0.0 < preload < 100.0:  # [N]: no gibs of a press are preloaded by less
        caution(f"friction of {name}: its preload is {preload:g} N: if kN are meant, write {preload:g}e3")


def cylinder(name: str, what: str, diameter: float) -> None:
    """Warn of a cylinder whose ``diameter`` [m], of its piston or bore as ``what`` says, may be in mm."""
    if diameter > 3.0:
        caution(f"{name}: {what} is {diameter:g} m: if mm are meant, write {diameter:g}e-3")


def air(name: str, pressure: Array, volume: Array) -> None:
    """Warn of air whose gauge ``pressure`` [Pa] or ``volume`` [m3] may be in other units; arrays are of scenarios."""
    least, largest = float(pressure.min()), float(volume.max())
    if 0.0 < least < 1e3:  # [Pa]
        caution(f"{name}: pressure is {least:g} Pa: if bar are meant, write {least:g}e5; if MPa, {least:g}e6")
    if largest > 50.0:  # [m3]
        caution(f"{name}: volume is {largest:g} m3: if litres are meant, write {largest:g}e-3")
