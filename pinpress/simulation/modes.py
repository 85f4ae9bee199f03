"""What is switched while a press runs: places of forces, grips of clutch and brake, sides of a drive's corners."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

from ..common.arrays import Array
from ..drives.driveline import Mode
from ..loads.process import Stretch
from .system import Acting


class Dynamics(Protocol):
    """The linkage as it is integrated: its crank alone, or all its joints. ``size``: of position and speed; ``crank``: its place there;
    ``alone``: whether it is the only driver, so that the linkage rests where it does."""

    size: int
    crank: int
    alone: bool

    def at(self, position: Array, speed: Array) -> Any:
        """What forces need of a state: an object with the crank's ``angle`` and ``speed``, and the ``coordinates``, (value, rate) each."""

    def accelerations(self, instant: Any, torque: float, forces: Sequence[float], inertia: float) -> Any:
        """Accelerations (size,) at an instant under a torque on the crank and forces along the coordinates, with inertia added to the
        crank."""

    def of_crank(self, accelerations: Any) -> float:
        """The crank's acceleration among these."""

    def stands(self, instant: Any, time: float) -> None:
        """Raise where the crank rests and the links do not."""

    def moved(self, position: Array, angle: float) -> tuple[Array, Array]:
        """Positions a small angle of the crank away, and speeds that lead there."""

    def project(self, position: Array, speed: Array) -> tuple[Array, Array] | None:
        """The nearest state with closed loops; None where none can be open."""

    def closed(self, position: Array, speed: Array) -> tuple[Array, Array]:
        """States (size, n) with their loops closed."""


class Place(NamedTuple):
    """Where a force is: between two values of its coordinate, which rises or falls; the stretch that acts there; whether that pushes."""

    low: float
    high: float
    rising: bool
    stretch: Stretch | None
    pushing: bool = True


class Modes(NamedTuple):
    """All that is switched: the driveline's mode, the place of every force (None of one in time), and on which side of the corners of its
    torque the drive runs; whether the press is ``standing``, held by loads that resist either way."""

    line: Mode
    places: tuple[Place | None, ...]
    sides: tuple[int, ...] = ()
    standing: bool = False


class Switch(NamedTuple):
    """What a switching function is of: a force ("low", "high", "turn", "contact"), the drive ("corner"), a clutch or brake ("grips",
    "slips", "closes", "opens"), or a press that stands ("starts", +1 or -1)."""

    what: str
    of: int | str


def place_of(force: Acting, inside: float, rising: bool, value: float, rate: float) -> Place:
    """Place of a force at a value of its coordinate; ``inside`` is a value near it that is on no border."""
    borders = force.borders()
    low = max((b for b in borders if b < inside), default=-math.inf)
    high = min((b for b in borders if b >= inside), default=math.inf)
    stretch = next((s for s in force.stretches(rising) if s.lower < inside - force.datum <= s.upper), None)
    pushing = stretch is None or not stretch.one_sided or float(stretch.force(value - force.datum, rate)) >= 0
    return Place(low, high, rising, stretch, pushing)
