"""The servo motor and its motion program."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..common.arrays import Array
from ..common.checks import finite_numbers
from ..common.errors import PinpressError, shown
from ..common.scenario_numbers import check, set_field
from .protocol import SpeedTorqueDrive, Values, between


@dataclass(frozen=True)
class ServoMotor(SpeedTorqueDrive):
    """A servo motor that follows a motion program of its shaft.

    The program is the cubic spline through its points that stands still at both ends, as it is held at the first angle before and at the
    last one afterwards: its speed has no jump. The torque is stiffness x error of angle + damping x error of speed, within the peak torque.

    Attributes:
        times: (k,) of the program's points, rising [s]. angles: (k,) of the shaft at them [rad].
        stiffness: [N m/rad]. damping: [N m s/rad]. peak_torque: [N m]. inertia: of the rotor [kg m2], or (S,).
        rated_torque: bearable without end [N m]; None: not known.
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"inertia": 0}

    times: Sequence[float] | Array
    angles: Sequence[float] | Array
    stiffness: float
    damping: float
    peak_torque: float
    inertia: Values = 0.0
    rated_torque: float | None = None

    def __post_init__(self) -> None:
        for field, unit in (("times", "s"), ("angles", "rad")):
            values = finite_numbers(getattr(self, field))
            if values is None or values.ndim != 1 or len(values) < 2:
                raise PinpressError(f"ServoMotor: {field} is {shown(getattr(self, field))}; give two or more finite numbers [{unit}]")
            set_field(self, field, tuple(values.tolist()))
        if len(self.times) != len(self.angles):
            raise PinpressError(f"ServoMotor: {len(self.times)} times and {len(self.angles)} angles; give an angle at each time")
        if not np.all(np.diff(self.times) > 0):
            at = int(np.argmin(np.diff(self.times) > 0))
            raise PinpressError(f"ServoMotor: times go from {self.times[at]:g} to {self.times[at + 1]:g} s; give them rising")
        check(self, "stiffness", "positive", "N m/rad")
        check(self, "damping", "not negative", "N m s/rad")
        check(self, "peak_torque", "positive", "N m")
        check(self, "inertia", "not negative", "kg m2", scenarios=True)
        if self.rated_torque is not None:
            check(self, "rated_torque", "positive", "N m")

    @property
    def timed(self) -> bool:
        return True

    def program(self, time: Values) -> tuple[Values, Values]:
        """Angle [rad] and speed [rad/s] of the program at times [s] of any shape."""
        # a number at a time is what an integrator asks for: an array of one takes forty times as long
        start, a, b, c, d = (
            self._rows[bisect_right(self.times, time)]
            if isinstance(time, float)
            else np.moveaxis(self._pieces[np.searchsorted(self._pieces[1:, 0], time, "right")], -1, 0)
        )
        t = time - start
        return a + t * (b + t * (c + t * d)), b + t * (2.0 * c + t * (3.0 * d))

    @cached_property
    def _pieces(self) -> Array:
        """(k + 1, 5): start of each piece of the program and its polynomial, constant first; the first and last are those it is held in."""
        from scipy.interpolate import CubicSpline  # slow to import, and only servo motors need it

        spline = CubicSpline(self.times, self.angles, bc_type="clamped")
        pieces = np.zeros((len(self.times) + 1, 5))
        pieces[:, 0] = [self.times[0], *self.times]
        pieces[1:-1, 1:] = spline.c[::-1].T
        pieces[[0, -1], 1] = self.angles[0], self.angles[-1]
        return pieces

    @cached_property
    def _rows(self) -> list[list[float]]:
        rows: list[list[float]] = self._pieces.tolist()
        return rows

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        wanted_angle, wanted_speed = self.program(time)
        torque = self.stiffness * (wanted_angle - angle) + self.damping * (wanted_speed - speed)
        return between(-self.peak_torque, torque, self.peak_torque)
