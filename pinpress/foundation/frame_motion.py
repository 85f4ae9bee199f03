"""The vibration of a frame over time: of its points, and the force on the floor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..common.arrays import Array
from ..common.errors import PinpressError, UnknownNameError
from ..common.frozen import FrozenMapping
from ..common.results import Tabular
from .mounted_press import MountedPress

NOTHING = 1e-9  # of the weight: a shaking force that is rounding


@dataclass(frozen=True, eq=False, repr=False)
class FrameMotion(Tabular):
    """Vibration about the static position at n states. All arrays are read-only.

    Attributes:
        system: the press on its mounts.
        time: (n,) of the states [s].
        period: of a motion that is one period, its end left out [s]; else None.
        displacement: name of a point -> (n, 3) in world axes [m].
        velocity: name of a point -> (n, 3) in world axes [m/s].
        acceleration: name of a point -> (n, 3) in world axes [m/s2].
        coordinates: (n, coordinates) of the frame's parts, see `mounted_press` [m, rad].
        mount_force: (n, mounts, 3) what each mount exerts on the frame beside its static load [N].
        floor_force: (n, 3) what the mounts exert on the floor beside the weight [N].
        floor_moment: (n, 3) of these forces about the world origin [N m].
        shaking_force: (n, 3) of the machine beside its weight [N].
    """

    system: MountedPress
    time: Array
    period: float | None
    displacement: Mapping[str, Array]
    velocity: Mapping[str, Array]
    acceleration: Mapping[str, Array]
    coordinates: Array
    mount_force: Array
    floor_force: Array
    floor_moment: Array
    shaking_force: Array

    @property
    def title(self) -> str:
        points = ", ".join(self.displacement) or "none"
        return f"FrameMotion of {self.system.press.name}: {len(self.time)} states, {self.time[-1]:.6g} s, points {points}"

    def __str__(self) -> str:
        """Points, forces and mounts; units beside every number."""
        over = f"one period of {self.period:.6g} s" if self.period is not None else f"{self.time[-1]:.6g} s from rest"
        lines = [
            f"{self.system.press.name} on {len(self.system.mounts)} mounts: {over}",
            f"  {'acceleration [m/s2]':<24}{'rms x':>12}{'rms y':>12}{'rms z':>12}{'peak x':>12}{'peak y':>12}{'peak z':>12}",
        ]
        for point in self.acceleration:
            numbers = [*self.rms(point), *self.peak(point)]
            lines.append(f"  {point:<24}" + "".join(f"{number:12.4g}" for number in numbers))
        lines += [
            f"  {'shaking force, rms':<24}{spread(self.shaking_force):12.4g} N",
            f"  {'force on the floor, rms':<24}{spread(self.floor_force):12.4g} N",
        ]
        least = self.least_load
        number = int(least.argmin())
        lifts = ", which lifts off unless it is bolted down" if least[number] < 0 else ""
        lines.append(f"  {'least load on a mount':<24}{least[number]:12.4g} N on mount {number}{lifts}")
        pressures = [pressure for pressure in self.system.pressure if pressure is not None]
        if pressures:
            lines.append(f"  {'mean pressure at rest':<24}{max(pressures) / 1e6:12.4g} MPa at most")
        lines.append(f"  {'sag at rest':<24}{1e3 * np.abs(self.system.sag[:, 2]).max():12.4g} mm at most")
        return "\n".join(lines)

    @classmethod
    def of(
        cls,
        system: MountedPress,
        time: Array,
        points: Mapping[str, Array],
        motion: tuple[Array, Array, Array],
        mount_force: Array,
        forcing: Array,
        period: float | None,
    ) -> FrameMotion:
        """The motion of points from that of the coordinates.

        Args:
            system: the press on its mounts.
            time: (n,) of the states [s].
            points: name of a point -> (3, coordinates) its displacement for each coordinate.
            motion: displacements, velocities and accelerations of the coordinates, (n, coordinates) each.
            mount_force: (n, mounts, 3) what each mount exerts on the frame beside its static load [N].
            forcing: (n, coordinates) wrenches on the parts of the frame [N, N m].
            period: of a motion that is one period [s].
        """
        moved = [{name: np.array(values @ rows.T) for name, rows in points.items()} for values in motion]
        places = np.array([mount.point for mount in system.mounts])
        shaking = sum(forcing[:, 6 * part : 6 * part + 3] for part in range(system.parts))
        return cls(
            system=system,
            time=np.array(time),
            period=period,
            displacement=FrozenMapping(moved[0]),
            velocity=FrozenMapping(moved[1]),
            acceleration=FrozenMapping(moved[2]),
            coordinates=np.array(motion[0]),
            mount_force=np.array(mount_force),
            floor_force=np.array(-mount_force.sum(axis=1)),
            floor_moment=np.array(-np.cross(places, mount_force).sum(axis=1)),
            shaking_force=np.array(np.asarray(shaking)),
        )

    @property
    def transmitted(self) -> float:
        """Force on the floor by shaking force, both as roots of the mean of their squares about their means [-].

        Raises:
            PinpressError: nothing shakes.
        """
        shaking = spread(self.shaking_force)
        if shaking <= NOTHING * np.abs(self.system.weight[:3]).max():
            raise PinpressError(f"no force of {self.system.press.name} shakes the frame: there is nothing to transmit")
        return spread(self.floor_force) / shaking

    @property
    def least_load(self) -> Array:
        """(mounts,) smallest load on each mount, static one included [N].

        Where it is negative, a mount that is not bolted down lifts off, and the linear model does not hold.
        """
        least: Array = (self.system.mount_load[:, 2] + self.mount_force[:, :, 2]).min(axis=0)
        return least

    def rms(self, point: str) -> Array:
        """(3,) root mean square of a point's acceleration about its mean, in world axes [m/s2].

        Raises:
            UnknownNameError: no such point.
        """
        return np.asarray(self._of(point).std(axis=0))

    def peak(self, point: str) -> Array:
        """(3,) largest absolute acceleration of a point [m/s2].

        Raises:
            UnknownNameError: no such point.
        """
        return np.asarray(np.abs(self._of(point)).max(axis=0))

    def _of(self, point: str) -> Array:
        if point not in self.acceleration:
            raise UnknownNameError("point", point, self.acceleration)
        return self.acceleration[point]

    def columns(self) -> dict[str, Array]:
        """Time, the points' displacement, velocity and acceleration, and floor and shaking force, as columns with units."""
        columns = {"time [s]": self.time}
        quantities = (
            ("displacement", "m", self.displacement),
            ("velocity", "m/s", self.velocity),
            ("acceleration", "m/s2", self.acceleration),
        )
        for quantity, unit, by_point in quantities:
            for point, values in by_point.items():
                columns |= {f"{quantity}_{point}_{axis} [{unit}]": values[:, i] for i, axis in enumerate("xyz")}
        for name, unit, values in (
            ("floor_force", "N", self.floor_force),
            ("floor_moment", "N m", self.floor_moment),
            ("shaking_force", "N", self.shaking_force),
        ):
            columns |= {f"{name}_{axis} [{unit}]": values[:, i] for i, axis in enumerate("xyz")}
        return columns


def spread(force: Array) -> float:
    """Root of the mean square of a vector (n, 3) about its mean."""
    return float(np.sqrt((force.std(axis=0) ** 2).sum()))
