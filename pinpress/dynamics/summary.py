"""The main results over one period of a press, as text."""

from collections.abc import Callable

import numpy as np

from ..common import tables
from ..common.quantities import RPM, Array
from ..kinematics.motion import Motion
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage
from .inverse_dynamics import Reactions

AXES = "xyz"


def summary(press: Linkage, motion: Motion, reactions: Reactions) -> str:
    """Stroke, peaks and ranges over the period, with units and crank angles, and how well the equations are fulfilled.

    Peaks are the largest values among the motion's states; dead centres are exact. Signs are those of `inverse_dynamics`.
    """
    lines = [
        f"{press.name}: {abs(motion.crank_speed[0]) / RPM:g} r/min of joint {press.driver}, {len(motion.crank_angle)} crank angles,"
        f" engine {reactions.engine!r}",
        *(_slide(press, motion) if press.slide else []),
        *_torque(motion, reactions),
        *_gear_pairs(motion, reactions),
        *bearing_table(reactions),
        *_shaking(reactions),
        "",
        "Checks",
        tables.entry("largest loop gap", f"{motion.closure_error.max():.3g}", "m"),
        tables.entry("largest power residual", f"{np.abs(reactions.power_residual).max():.3g}", "of the peak power"),
    ]
    return "\n".join(lines)


def _slide(press: Linkage, motion: Motion) -> list[str]:
    ends = dead_centres(press)
    speed = motion.crank_speed[0]
    position, velocity, acceleration = motion.slide_position, motion.slide_velocity, motion.slide_acceleration

    def time(angle: float) -> float:
        return float((angle if speed > 0 else 2 * np.pi * ends.turns - angle) / abs(speed))

    return [
        "",
        f"Slide ({press.slide})",
        tables.entry("stroke", f"{1e3 * ends.stroke:.3f}", "mm"),
        *(
            tables.entry(name, f"{1e3 * place:.3f}", "mm", f"at {np.degrees(angle):8.3f} deg, {time(angle):.6f} s")
            for name, place, angle in (
                ("top dead centre", ends.top_position, ends.top_angle),
                ("bottom dead centre", ends.bottom_position, ends.bottom_angle),
            )
        ),
        tables.entry("position at crank angle 0", f"{1e3 * position[0]:.3f}", "mm"),
        _extreme("fastest along the axis", velocity, motion, "m/s", np.argmax),
        _extreme("fastest against it", velocity, motion, "m/s", np.argmin),
        _extreme("largest acceleration", acceleration, motion, "m/s2", np.argmax),
        _extreme("smallest acceleration", acceleration, motion, "m/s2", np.argmin),
    ]


def _torque(motion: Motion, reactions: Reactions) -> list[str]:
    torque = reactions.driving_torque
    return [
        "",
        "Driving torque (on the driver, along its axis)",
        _extreme("largest", torque, motion, "N m", np.argmax),
        _extreme("smallest", torque, motion, "N m", np.argmin),
        tables.entry("rms", f"{np.sqrt(np.mean(torque**2)):.6g}", "N m"),
        _extreme("largest power", 1e-3 * torque * motion.crank_speed, motion, "kW", np.argmax),
    ]


def _gear_pairs(motion: Motion, reactions: Reactions) -> list[str]:
    lines = ["", "Gear pairs (torque on the joint that mimics, along its axis)"] if reactions.coupling_torque else []
    for name, torque in reactions.coupling_torque.items():
        lines += [_extreme(f"{name}, largest", torque[:, 0], motion, "N m", np.argmax)]
        lines += [_extreme(f"{name}, smallest", torque[:, 0], motion, "N m", np.argmin)]
    return lines


def bearing_table(reactions: Reactions) -> list[str]:
    """Lines with the largest force and moment of every bearing over a motion's states, and the range of its force along each axis."""
    axes = [i for i in range(3) if any(force[:, i].any() for force in reactions.bearing_force.values())]
    width = max(14, *(len(name) for name in reactions.bearing_force))
    heads = ["peak force [N]", "at crank [deg]", *(f"range {AXES[i]} [N]" for i in axes), "peak moment [N m]"]
    rows = [["", *heads]]
    for name, force in reactions.bearing_force.items():
        size = np.linalg.norm(force, axis=1)
        at = int(size.argmax())
        moment = np.linalg.norm(reactions.bearing_moment[name], axis=1).max()
        ranges = [f"{np.ptp(force[:, i]):.0f}" for i in axes]
        rows.append([name, f"{size[at]:.0f}", f"{_degrees(reactions.motion, at):.2f}", *ranges, f"{moment:.0f}"])
    return ["", "Bearings (action of parent on child, of link1 on link2)", *tables.table(rows, [width, 18])]


def _shaking(reactions: Reactions) -> list[str]:
    lines = ["", "Shaking force on the foundation, weight included"]
    for i, axis in enumerate(AXES):
        force = reactions.shaking_force[:, i]
        if force.any():
            low, high = force.min().round() + 0.0, force.max().round() + 0.0  # not "-0"
            lines.append(tables.entry(axis, f"{low:.0f}", f"N   to {high:12.0f} N,  range {np.ptp(force):10.0f} N"))
    return lines


def _extreme(name: str, values: Array, motion: Motion, unit: str, choose: Callable[[Array], np.intp]) -> str:
    at = int(choose(values))
    return tables.entry(name, f"{values[at]:.6g}", unit, f"at {_degrees(motion, at):8.3f} deg")


def _degrees(motion: Motion, at: int) -> float:
    return float(motion.crank_degrees[at])
