"""The main results over one period of a press, as text."""

from collections.abc import Callable

import numpy as np

from ..common import tables
from ..common.errors import PinpressError
from ..common.quantities import RPM, Array, DriverCoordinate
from ..kinematics.main_data import directions, forward_share, sense_of_rotation
from ..kinematics.motion import Motion
from ..kinematics.slide_path import DeadCentres, dead_centres
from ..linkage.linkage import Linkage
from .extremes import ROUNDING
from .inverse_dynamics import Reactions

AXES = "xyz"
CLOSED = 1e-12  # gap [lengths of the linkage] or residual that is rounding


def summary(press: Linkage, motion: Motion, reactions: Reactions, utilisation: Array | None = None) -> str:
    """Stroke, peaks and ranges over the period, with units, crank angles and heights, and how well the equations are fulfilled.

    Peaks are the largest values among the motion's states; dead centres are exact. Heights of the slide are above bottom dead centre. Signs
    are those of `inverse_dynamics`.

    Args:
        press: The press.
        motion: One period at constant speed.
        reactions: Reactions to this motion.
        utilisation: (n,) process force divided by the permissible force [-]; None: it is not known.
    """
    lines = [
        f"{press.name}: {_speed(press, motion)}",
        f"  {len(motion.crank_angle)} {motion.driver_coordinates[0].position}s{f' from {press.zero}' if press.zero else ''},"
        f" engine {reactions.engine!r}",
        *_slide(press, motion),
        *process_summary(press, motion, reactions, utilisation),
        *_torque(motion, reactions),
        *_gear_pairs(motion, reactions),
        *bearing_table(reactions),
        *_shaking(reactions),
        "",
        "Checks",
        *checks(press, float(motion.closure_error.max()), reactions),
    ]
    return "\n".join(lines)


def _speed(press: Linkage, motion: Motion) -> str:
    """Speed and sense of rotation in words, and strokes per minute where the slide makes one in some turns."""
    if not motion.driver_coordinates[0].turns:
        fastest = float(np.abs(motion.crank_speed).max())
        return f"{press.driver} slides there and back, harmonically, at up to {1e3 * fastest:g} mm/s"
    speed = float(motion.crank_speed[0])
    turning = f"{press.driver} turns {sense_of_rotation(press, speed)} at {abs(speed) / RPM:g} r/min"
    ends = _dead_centres(press)
    return turning if ends is None else f"{abs(speed) / RPM / ends.turns:g} strokes/min, {turning}"


def _slide(press: Linkage, motion: Motion) -> list[str]:
    if press.slide is None:
        return []
    try:
        ends = dead_centres(press)
    except PinpressError as error:
        return ["", f"Slide ({press.slide}): {error}"]
    velocity, acceleration = motion.slide_velocity, motion.slide_acceleration
    coordinate, (down, up) = motion.driver_coordinates[0], directions(press)

    def extreme(name: str, values: Array, unit: str) -> str:
        return _extreme(name, values, motion, unit, np.argmax, ends)

    return [
        "",
        f"Slide ({press.slide}), heights above bottom dead centre",
        tables.entry("stroke", f"{1e3 * ends.stroke:.3f}", "mm"),
        *(_turning(press, motion, ends, down, up) if coordinate.turns else _sliding(coordinate, ends)),
        extreme("fastest, working stroke", -velocity, "m/s"),
        extreme("fastest, return stroke", velocity, "m/s"),
        extreme("largest acceleration up" if up == "up" else "acceleration towards top", acceleration, "m/s2"),
        extreme("largest acceleration down" if down == "down" else "... towards bottom", -acceleration, "m/s2"),
    ]


def process_summary(press: Linkage, motion: Motion, reactions: Reactions, utilisation: Array | None) -> list[str]:
    """Lines with the largest force and the work of the process; none without a process. Arguments as of `summary`."""
    if not reactions.process_force.any():
        return []
    ends, work = _dead_centres(press), reactions.process_work
    turns = motion.period_turns if ends is None or motion.period_turns is None else ends.turns
    work *= (turns or 1) / (motion.period_turns or 1)
    scale = tables.scale("J", [work])
    lines = [
        "",
        "Process (force of the loads between slide and frame)",
        _extreme("largest force", reactions.process_force, motion, "N", np.argmax, ends),
        tables.entry("work", scale.shown(work), scale.unit, "a stroke" if ends else "a period"),
    ]
    if utilisation is not None:
        at = int(np.argmax(utilisation))
        lines.append(tables.entry("of the permissible force", f"{100 * utilisation[at]:.2f}", "%", _place(motion, at, ends)))
    return lines


def _turning(press: Linkage, motion: Motion, ends: DeadCentres, down: str, up: str) -> list[str]:
    """Lines with the dead centres of a crank that turns, and with the time that the strokes take."""
    speed = float(motion.crank_speed[0])
    period, forward = 2 * np.pi * ends.turns / abs(speed), forward_share(ends, speed)

    def time(angle: float) -> float:
        return float((angle if speed > 0 else 2 * np.pi * ends.turns - angle) / abs(speed))

    return [
        *(
            tables.entry(name, f"{np.degrees(angle):.3f}", "deg", f"at {time(angle):.6f} s")
            for name, angle in (("top dead centre", ends.top_angle), ("bottom dead centre", ends.bottom_angle))
        ),
        *([] if press.zero else [tables.entry("as drawn (0 deg)", f"{1e3 * (motion.slide_position[0] - ends.bottom_position):.3f}", "mm")]),
        tables.entry("working stroke", f"{100 * forward:.3f}", "%", f"of the time, {forward * period:.6f} s, {down}"),
        tables.entry("return stroke", f"{100 * (1 - forward):.3f}", "%", f"of the time, {(1 - forward) * period:.6f} s, {up}"),
    ]


def _sliding(coordinate: DriverCoordinate, ends: DeadCentres) -> list[str]:
    """Lines with the dead centres of a press whose driver slides."""
    places = (("top dead centre", ends.top_angle), ("bottom dead centre", ends.bottom_angle))
    return [tables.entry(name, f"{coordinate.scale * place:.3f}", coordinate.shown_unit, "of the driver") for name, place in places]


def _torque(motion: Motion, reactions: Reactions) -> list[str]:
    torque, coordinate = reactions.driving_torque, motion.driver_coordinates[0]
    rms = float(np.sqrt(np.mean(torque**2)))
    scale = tables.scale(coordinate.effort_unit, [float(np.abs(torque).max())])
    return [
        "",
        f"Driving {coordinate.effort} (on the driver, along its axis)",
        _extreme("largest", torque, motion, coordinate.effort_unit, np.argmax),
        _extreme("smallest", torque, motion, coordinate.effort_unit, np.argmin),
        tables.entry("rms", scale.shown(rms), scale.unit),
        _extreme("largest power", torque * motion.crank_speed, motion, "W", np.argmax),
    ]


def _gear_pairs(motion: Motion, reactions: Reactions) -> list[str]:
    lines = ["", "Gear pairs (torque on the joint that mimics, along its axis)"] if reactions.coupling_torque else []
    for name, torque in reactions.coupling_torque.items():
        lines += [_extreme(f"{name}, largest", torque[:, 0], motion, "N m", np.argmax)]
        lines += [_extreme(f"{name}, smallest", torque[:, 0], motion, "N m", np.argmin)]
    return lines


def bearing_table(reactions: Reactions) -> list[str]:
    """Lines with the largest force and moment of every bearing over a motion's states, in the order of the drawing, where the crank and the
    slide are then, and the range of the force along each axis."""
    motion, press = reactions.motion, reactions._press
    names = [name for name in press.bearings_as_drawn if name in reactions.bearing_force]
    sizes = {name: np.linalg.norm(reactions.bearing_force[name], axis=1) for name in names}
    moments = [float(np.linalg.norm(reactions.bearing_moment[name], axis=1).max(initial=0.0)) for name in names]
    largest = max((float(size.max()) for size in sizes.values()), default=0.0)
    forces = tables.scale("N", [largest], ROUNDING * largest)
    turning = tables.scale("N m", moments, ROUNDING * largest * press.size)
    axes = [i for i in range(3) if any(np.abs(reactions.bearing_force[name][:, i]).max() > forces.least for name in names)]
    ends = _dead_centres(press)
    first = motion.driver_coordinates[0]
    heads = [f"peak force [{forces.unit}]", f"at {first.part} [{first.shown_unit}]", *(["height [mm]"] if ends else [])]
    heads += [*(f"range {AXES[i]} [{forces.unit}]" for i in axes), f"peak moment [{turning.unit}]"]
    rows = [["", *heads]]
    for name, moment in zip(names, moments, strict=True):
        at = int(sizes[name].argmax())
        place = [f"{_shown(motion, at):.2f}", *([f"{1e3 * (motion.slide_position[at] - ends.bottom_position):.3f}"] if ends else [])]
        if sizes[name][at] <= forces.least:
            place = ["-"] * len(place)
        ranges = [forces.shown(float(np.ptp(reactions.bearing_force[name][:, i]))) for i in axes]
        rows.append([name, forces.shown(float(sizes[name][at])), *place, *ranges, turning.shown(moment)])
    return ["", "Bearings (action of parent on child, of link1 on link2), each at its peak", *tables.fitted(rows)]


def _shaking(reactions: Reactions) -> list[str]:
    force = reactions.shaking_force
    largest = max((float(np.abs(each).max(initial=0.0)) for each in reactions.bearing_force.values()), default=0.0)
    scale = tables.scale("N", [float(np.abs(force).max(initial=0.0))], ROUNDING * largest)
    lines = ["", "Shaking force on the foundation, weight included"]
    for i, axis in enumerate(AXES):
        if np.abs(force[:, i]).max(initial=0.0) > scale.least:
            low, high, width = (scale.shown(float(value)) for value in (force[:, i].min(), force[:, i].max(), np.ptp(force[:, i])))
            lines.append(tables.entry(axis, low, scale.unit, f"to {high:>10} {scale.unit},  range {width:>10} {scale.unit}"))
    return lines


def checks(press: Linkage, gap: float, reactions: Reactions) -> list[str]:
    """Lines that say how well loops and the balance of power are fulfilled; ``gap``: the largest of a loop [m]."""
    residual = float(np.abs(reactions.power_residual).max())
    closed = "closed to rounding" if gap <= CLOSED * max(press.size, 1.0) else f"{gap:.3g}"
    balanced = "0 to rounding" if residual <= CLOSED else f"{residual:.3g}"
    return [
        tables.entry("largest loop gap", closed, "" if closed.startswith("closed") else "m"),
        tables.entry("largest power residual", balanced, "", "of the peak power: what drive, loads and energies leave over"),
    ]


def _dead_centres(press: Linkage) -> DeadCentres | None:
    try:
        return dead_centres(press) if press.slide is not None else None
    except PinpressError:
        return None


def _extreme(
    name: str, values: Array, motion: Motion, unit: str, choose: Callable[[Array], np.intp], ends: DeadCentres | None = None
) -> str:
    """A line with an extreme of a quantity [SI unit] and the crank angle where it is reached, with dead centres the slide's height too."""
    at, scale = int(choose(values)), tables.scale(unit, [float(np.abs(values).max())])
    return tables.entry(name, scale.shown(float(values[at])), scale.unit, _place(motion, at, ends))


def _place(motion: Motion, at: int, ends: DeadCentres | None) -> str:
    """The crank angle of a state, with dead centres the slide's height too."""
    height = "" if ends is None else f", {1e3 * (motion.slide_position[at] - ends.bottom_position):9.3f} mm"
    return f"at {_shown(motion, at):8.3f} {motion.driver_coordinates[0].shown_unit}{height}"


def _shown(motion: Motion, at: int) -> float:
    return float(motion.shown_position[at])
