"""What an engineer reads off one period of a press, as text."""

from collections.abc import Callable

import numpy as np

from ..common.quantities import RPM, Array
from ..kinematics.motion import Motion
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage
from .inverse_dynamics import Reactions

AXES = "xyz"


def summary(press: Linkage, motion: Motion, result: Reactions) -> str:
    """Stroke, peaks and ranges over the period, and how well the equations are fulfilled; units and crank angles beside every number.

    Peaks are the largest of the motion's points; dead centres are exact. Signs as in `reactions`.
    """
    lines = [
        f"{press.name}: {abs(motion.crank_speed[0]) / RPM:g} r/min of joint {press.driver}, {len(motion.crank_angle)} crank angles,"
        f" engine {result.engine!r}",
        *(_slide(press, motion) if press.slide else []),
        *_torque(motion, result),
        *_gear_pairs(motion, result),
        *_bearings(motion, result),
        *_shaking(result),
        "",
        "Checks",
        f"  {'largest loop gap':26}{motion.closure_error.max():12.3g} m",
        f"  {'largest power residual':26}{np.abs(result.power_residual).max():12.3g} of the peak power",
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
        f"  {'stroke':26}{1e3 * ends.stroke:12.3f} mm",
        *(
            f"  {name:26}{1e3 * place:12.3f} mm     at {np.degrees(angle):8.3f} deg, {time(angle):.6f} s"
            for name, place, angle in (
                ("top dead centre", ends.top_position, ends.top_angle),
                ("bottom dead centre", ends.bottom_position, ends.bottom_angle),
            )
        ),
        f"  {'position at crank angle 0':26}{1e3 * position[0]:12.3f} mm",
        _extreme("fastest along the axis", velocity, motion, "m/s", np.argmax),
        _extreme("fastest against it", velocity, motion, "m/s", np.argmin),
        _extreme("largest acceleration", acceleration, motion, "m/s2", np.argmax),
        _extreme("smallest acceleration", acceleration, motion, "m/s2", np.argmin),
    ]


def _torque(motion: Motion, result: Reactions) -> list[str]:
    torque = result.driving_torque
    return [
        "",
        "Driving torque (on the driver, along its axis)",
        _extreme("largest", torque, motion, "N m", np.argmax),
        _extreme("smallest", torque, motion, "N m", np.argmin),
        f"  {'rms':26}{np.sqrt(np.mean(torque**2)):12.6g} N m",
        _extreme("largest power", 1e-3 * torque * motion.crank_speed, motion, "kW", np.argmax),
    ]


def _gear_pairs(motion: Motion, result: Reactions) -> list[str]:
    lines = ["", "Gear pairs (torque on the joint that mimics, along its axis)"] if result.coupling_torque else []
    for name, torque in result.coupling_torque.items():
        lines += [_extreme(f"{name}, largest", torque[:, 0], motion, "N m", np.argmax)]
        lines += [_extreme(f"{name}, smallest", torque[:, 0], motion, "N m", np.argmin)]
    return lines


def _bearings(motion: Motion, result: Reactions) -> list[str]:
    axes = [i for i in range(3) if any(force[:, i].any() for force in result.bearing_force.values())]
    width = max(14, *(len(name) for name in result.bearing_force))
    heads = ["peak force [N]", "at crank [deg]", *(f"range {AXES[i]} [N]" for i in axes), "peak moment [N m]"]
    lines = ["", "Bearings (action of parent on child, of link1 on link2)", f"  {'':{width}}" + "".join(f"{head:>18}" for head in heads)]
    for name, force in result.bearing_force.items():
        size = np.linalg.norm(force, axis=1)
        at = int(size.argmax())
        numbers = [f"{size[at]:.0f}", f"{_degrees(motion, at):.2f}", *(f"{np.ptp(force[:, i]):.0f}" for i in axes)]
        numbers.append(f"{np.linalg.norm(result.bearing_moment[name], axis=1).max():.0f}")
        lines.append(f"  {name:{width}}" + "".join(f"{number:>18}" for number in numbers))
    return lines


def _shaking(result: Reactions) -> list[str]:
    lines = ["", "Shaking force on the foundation, weight included"]
    for i, axis in enumerate(AXES):
        force = result.shaking_force[:, i]
        if force.any():
            low, high = force.min().round() + 0.0, force.max().round() + 0.0  # not "-0"
            lines.append(f"  {axis:26}{low:12.0f} N   to {high:12.0f} N,  range {np.ptp(force):10.0f} N")
    return lines


def _extreme(name: str, values: Array, motion: Motion, unit: str, choose: Callable[[Array], np.intp]) -> str:
    at = int(choose(values))
    return f"  {name:26}{values[at]:12.6g} {unit:7}at {_degrees(motion, at):8.3f} deg"


def _degrees(motion: Motion, at: int) -> float:
    return float(motion.crank_degrees[at])
