"""What an engineer reads off a press on its mounts, as text."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .frame_motion import FrameMotion
    from .mounted_press import MountedPress


def motion_text(motion: "FrameMotion") -> str:
    """Points, forces and mounts; units beside every number."""
    from .frame_motion import spread  # which calls this module

    over = f"one period of {motion.period:.6g} s" if motion.period is not None else f"{motion.time[-1]:.6g} s from rest"
    lines = [
        f"{motion.system.press.name} on {len(motion.system.mounts)} mounts: {over}",
        f"  {'acceleration [m/s2]':<24}{'rms x':>12}{'rms y':>12}{'rms z':>12}{'peak x':>12}{'peak y':>12}{'peak z':>12}",
    ]
    for point in motion.acceleration:
        numbers = [*motion.rms(point), *motion.peak(point)]
        lines.append(f"  {point:<24}" + "".join(f"{number:12.4g}" for number in numbers))
    lines += [
        f"  {'shaking force, rms':<24}{spread(motion.shaking_force):12.4g} N",
        f"  {'force on the floor, rms':<24}{spread(motion.floor_force):12.4g} N",
    ]
    least = motion.least_load
    number = int(least.argmin())
    lifts = ", which lifts off unless it is bolted down" if least[number] < 0 else ""
    lines.append(f"  {'least load on a mount':<24}{least[number]:12.4g} N on mount {number}{lifts}")
    pressures = [pressure for pressure in motion.system.pressure if pressure is not None]
    if pressures:
        lines.append(f"  {'mean pressure at rest':<24}{max(pressures) / 1e6:12.4g} MPa at most")
    lines.append(f"  {'sag at rest':<24}{1e3 * np.abs(motion.system.sag[:, 2]).max():12.4g} mm at most")
    return "\n".join(lines)


def standing_text(system: "MountedPress") -> str:
    """Loads, sag and pressure of the mounts at rest."""
    x, y, z = system.centre
    lines = [
        f"{system.press.name} on its mounts at rest: {system.total_mass:.6g} kg, centre of mass {x:.4g}, {y:.4g}, {z:.4g} m",
        f"  {'mount at':<28}{'load':>14}{'share':>10}{'sag':>14}{'pressure':>14}",
    ]
    for mount, load, share, sag, pressure in zip(
        system.mounts, system.mount_load[:, 2], system.load_share, system.sag[:, 2], system.pressure, strict=True
    ):
        place = ", ".join(f"{coordinate:.4g}" for coordinate in mount.point) + " m"
        last = "" if pressure is None else f"{pressure / 1e6:10.4g} MPa"
        lines.append(f"  {place:<28}{load:12.5g} N{100 * share:8.2f} %{-1e3 * sag:11.4g} mm{last}")
    return "\n".join(lines)
