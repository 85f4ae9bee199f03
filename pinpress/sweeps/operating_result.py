"""The table of operating points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..common.arrays import Array
from ..common.errors import UnknownNameError
from ..common.results import Tabular
from ..common.units import RPM


@dataclass(frozen=True, eq=False, repr=False)
class OperatingPoints(Tabular):
    """Extremes over a period at every speed and amplitude of a load. All arrays are read-only.

    Attributes:
        linkage: its name.
        speeds: (n,) of the driver [rad/s]. forces: (m,) amplitudes of the load [N].
        results: name -> (n, m): largest_driving_torque and smallest_driving_torque [N m], peak_force_A of every bearing asked for, the
            largest magnitude [N], range_shaking_force_x, _y and _z, largest less smallest [N].
        angles: name of an extreme torque or peak -> (n, m) crank angle at which it is [rad]; empty where they were not asked for.
    """

    linkage: str
    speeds: Array
    forces: Array
    results: Mapping[str, Array]
    angles: Mapping[str, Array]

    @property
    def title(self) -> str:
        speeds, forces = (f"{values.min():.6g} to {values.max():.6g}" for values in (self.speeds, self.forces))
        return f"OperatingPoints of {self.linkage}: {len(self.speeds)} speeds, {speeds} rad/s, and {len(self.forces)} forces, {forces} N"

    def __str__(self) -> str:
        speeds, forces = self.speeds / RPM, self.forces
        lines = [
            f"{self.linkage} at {len(speeds)} speeds, {speeds.min():g} to {speeds.max():g} r/min, and {len(forces)} forces,"
            f" {forces.min():g} to {forces.max():g} N",
            f"  {'over a turn':32}{'smallest':>14}{'largest':>14}",
        ]
        lines += [f"  {f'{name} [{unit(name)}]':32}{values.min():14.6g}{values.max():14.6g}" for name, values in self.results.items()]
        return "\n".join(lines)

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.speeds), len(self.forces)

    @property
    def axes(self) -> dict[str, Array]:
        """The axes of the grid by their names in the columns."""
        return {"speed": self.speeds, "force": self.forces}

    def columns(self) -> dict[str, Array]:
        """All points, forces fastest, as (n m,) columns under their names with units: speed, force, results and angles."""
        columns = {"speed": np.repeat(self.speeds, self.shape[1]), "force": np.tile(self.forces, self.shape[0])}
        columns |= {name: values.ravel() for name, values in self.results.items()}
        columns |= {f"angle_of_{name}": values.ravel() for name, values in self.angles.items()}
        return {f"{name} [{unit(name)}]": values for name, values in columns.items()}

    def grid(self, name: str) -> Array:
        """A result (n, m).

        Raises:
            UnknownNameError: no such result.
        """
        if name not in self.results:
            raise UnknownNameError("result", name, self.results)
        return self.results[name]


def unit(name: str) -> str:
    """Unit of a column."""
    if name.startswith("angle_of_"):
        return "rad"
    return "rad/s" if name == "speed" else "N m" if name.endswith("driving_torque") else "N"
