"""Process loads: forces between slide and bolster, as functions of the slide's height and direction of travel.

They act along the slide's guide axis; on the slide positive along the axis, on the frame the opposite. The slide works against the axis,
downwards in an upright press, so a positive force resists the working stroke. Heights [m] are slide positions above a datum: the load's
``datum`` (a slide position [m]), by default that of bottom dead centre. Magnitudes may be arrays (S,), one value a scenario.

The load cases are those of Zhang 2007 (JF75G-125), 5.7, as functions of height instead of time: a press slows down under its load,
and windows in time then miss the stroke that they were made for.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..common.arrays import Array
from ..common.checks import any_numbers, number
from ..common.errors import PinpressError, shown
from ..common.frozen import Frozen
from ..common.scenario_numbers import set_field
from .checks import check_datum, check_height, check_magnitude, check_scenarios, check_span, checked_numbers, fixed
from .protocol import ForceInterval, ProcessLoad, datum

if TYPE_CHECKING:
    pass

__all__ = [
    "Blanking",
    "ConstantForce",
    "DeepDrawing",
    "ElasticDie",
    "ForceInterval",
    "ForceStroke",
    "Idle",
    "ProcessLoad",
    "TimeForce",
    "datum",
    "step",
]


@dataclass(frozen=True)
class Idle:
    """The press runs empty: no force. Zhang 2007, 5.7.1 (1)."""

    datum: float | None = None

    def __post_init__(self) -> None:
        check_datum(self)

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return ()


@dataclass(frozen=True, eq=False)
class ConstantForce:
    """Pulse about bottom dead centre: constant force wherever the slide is lower than a height, both ways. Zhang 2007, 5.7.1 (2).

    The window in time of 5.7.3, t = 2.5 ms before and after bottom dead centre, is for a crank r and a rod l at crank speed w, nearly,
    the height r (1 + r/l) (w t)^2 / 2: for r = 15 mm, l = 300 mm and 300 strokes/min 0.0486 mm.

    Attributes:
        force: [N], one number or (S,), not negative. height: [m], not negative; with 0 it acts nowhere. datum: see the module.
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"force": 0}

    force: float | Array
    height: float
    datum: float | None = None

    def __post_init__(self) -> None:
        check_magnitude(self, "force")
        check_height(self, "height")
        check_datum(self)
        if self.height < 0:
            raise PinpressError(f"ConstantForce: height is {self.height:g}; give the height above bottom dead centre [m], not negative")

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return (ForceInterval(self.height, -math.inf, partial(_constant, self.force)),) if self.height else ()


@dataclass(frozen=True, eq=False)
class Blanking:
    """Quarter sine on the way down: F sin(pi/2 (start - h)/(start - end)) until the blank breaks through. Zhang 2007, 5.7.1 (3).

    Attributes:
        force: the largest, F, at the height end [N]. stripping: constant force that holds the slide back over the same heights on the way
            up, as the punch leaves the strip [N]. One number or (S,), not negative.
        start, end: heights at which the punch meets the blank and breaks through [m]; start above end. datum: see the module.
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"force": 0, "stripping": 0}

    force: float | Array
    start: float
    end: float
    stripping: float | Array = 0.0
    datum: float | None = None

    def __post_init__(self) -> None:
        check_magnitude(self, "force")
        check_magnitude(self, "stripping")
        check_scenarios(self, "force", "stripping")
        check_span(self)
        check_datum(self)

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        if downwards:
            return (ForceInterval(self.start, self.end, partial(_sine, self.force, self.start, 0.5 * math.pi / (self.start - self.end))),)
        return (ForceInterval(self.start, self.end, partial(_constant, -self.stripping)),) if np.any(self.stripping) else ()


@dataclass(frozen=True, eq=False)
class DeepDrawing:
    """Half sine on the way down: F sin(pi (start - h)/(start - end)). Zhang 2007, 5.7.1 (4).

    Attributes:
        force: the largest, F, midway [N], one number or (S,), not negative.
        start, end: heights at which the punch meets the blank and the cup is drawn [m]; start above end. datum: see the module.
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"force": 0}

    force: float | Array
    start: float
    end: float = 0.0
    datum: float | None = None

    def __post_init__(self) -> None:
        check_magnitude(self, "force")
        check_span(self)
        check_datum(self)

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        if not downwards:
            return ()
        return (ForceInterval(self.start, self.end, partial(_sine, self.force, self.start, math.pi / (self.start - self.end))),)


@dataclass(frozen=True, eq=False)
class ForceStroke(Frozen):
    """Table of force over height, on the way down: linear between its points, no force beyond them.

    Attributes:
        heights: (n,) [m], at least two, strictly rising or falling; kept rising.
        forces: (n,) or (n, S) at the heights [N]; negative where the slide is drawn down. datum: see the module.
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"forces": 1}

    heights: ArrayLike
    forces: ArrayLike
    datum: float | None = None

    def __post_init__(self) -> None:
        heights, forces = checked_numbers(self, "heights"), checked_numbers(self, "forces")
        if heights.ndim != 1 or len(heights) < 2:
            raise PinpressError(f"ForceStroke: heights has shape {heights.shape}; give (n,) of at least two [m]")
        if forces.ndim not in (1, 2) or len(forces) != len(heights) or not forces.size:
            raise PinpressError(f"ForceStroke: forces has shape {forces.shape}; give one force for each of the {len(heights)} heights [N]")
        if heights[0] > heights[-1]:
            heights, forces = heights[::-1], forces[::-1]
        if not np.all(np.diff(heights) > 0):
            raise PinpressError("ForceStroke: heights neither rises nor falls throughout; sort its points, each height once")
        with np.errstate(all="ignore"):
            slopes = np.diff(forces, axis=0).T / np.diff(heights)
        if not np.isfinite(slopes).all():
            raise PinpressError("ForceStroke: heights are too close together for the change of forces between them; move them apart")
        set_field(self, "heights", fixed(heights))
        set_field(self, "forces", fixed(forces))
        check_datum(self)

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        if not downwards:
            return ()
        heights = np.asarray(self.heights).tolist()
        forces: list[Any] = list(np.asarray(self.forces)) if np.ndim(self.forces) == 2 else np.asarray(self.forces).tolist()
        points = list(zip(heights, forces, strict=True))
        return tuple(
            ForceInterval(upper, lower, partial(_line, force, (above - force) / (upper - lower), lower))
            for (lower, force), (upper, above) in itertools.pairwise(points)
        )


@dataclass(frozen=True, eq=False)
class ElasticDie:
    """A die, stop or cushion met at a height: spring and damper side by side below it, both ways, that push but never pull.

    Its force is k (height - h) - c v, zero where that is negative. Where the slide meets it with a damper, the force begins with a jump.

    Attributes:
        height: at which the slide touches the unloaded die [m].
        stiffness: k, positive [N/m]. damping: c, not negative [N s/m]. One number or (S,). datum: see the module.
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"stiffness": 0, "damping": 0}

    height: float
    stiffness: float | Array
    damping: float | Array = 0.0
    datum: float | None = None

    def __post_init__(self) -> None:
        check_height(self, "height")
        check_magnitude(self, "stiffness")
        check_magnitude(self, "damping")
        check_scenarios(self, "stiffness", "damping")
        check_datum(self)
        if not np.all(np.asarray(self.stiffness) > 0):
            raise PinpressError(f"ElasticDie: stiffness is {shown(self.stiffness)}; give a positive one [N/m]")

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return (ForceInterval(self.height, -math.inf, partial(_contact, self.height, self.stiffness, self.damping), one_sided=True),)


@dataclass(frozen=True, eq=False)
class TimeForce:
    """Force between slide and bolster as a function of time, for comparison with models that prescribe it so.

    It stays where it is in time when the press slows down under its load: prefer a process load.

    Attributes:
        force: time [s] (n,) -> force on the slide along its guide's axis [N] (n,), or one number.
        edges: instants at which it is not smooth [s]; kept sorted.
    """

    force: Callable[[Array], ArrayLike]
    edges: Sequence[float] = ()

    def __post_init__(self) -> None:
        if not callable(self.force):
            raise PinpressError(f"TimeForce: force is {shown(self.force)}; give a function of time [s]")
        edges = checked_numbers(self, "edges")
        if edges.ndim != 1:
            raise PinpressError(f"TimeForce: edges has shape {edges.shape}; give a sequence of instants [s]")
        set_field(self, "edges", tuple(np.unique(edges).tolist()))


def step(x: ArrayLike, x0: float, h0: float, x1: float, h1: float) -> Array:
    """ADAMS' function STEP: h0 up to x0, h1 from x1, between them h0 + (h1 - h0) d^2 (3 - 2 d) with d = (x - x0)/(x1 - x0).

    As in the load functions of Zhang 2007, 5.7.3 to 5.7.5. x: any shape, that of what is returned.

    Raises:
        PinpressError: x1 not above x0, or a value that is not a number.
    """
    at = any_numbers("step: x", x)
    if np.isnan(at).any():
        raise PinpressError("step: x is not finite")
    begin, before, end, after = (number(f"step: {name}", value) for name, value in (("x0", x0), ("h0", h0), ("x1", x1), ("h1", h1)))
    if end > begin and not math.isfinite(1 / (end - begin)):
        raise PinpressError("step: x0 and x1 are too near to each other: move them apart")
    if not end > begin:
        raise PinpressError(f"step: x1 is {end:g}, not above x0, {begin:g}; write step(x, x0, h0, x1, h1) with x0 < x1")
    share = np.clip((at - begin) / (end - begin), 0.0, 1.0)
    share = share * share * (3.0 - 2.0 * share)
    return np.asarray(before * (1.0 - share) + after * share)


# The laws are module functions that `partial` binds, not closures: loads can then be sent to other processes.


def _constant(force: Any, height: Any, velocity: Any) -> Any:
    return force + 0.0 * height  # of the height's shape


def _sine(force: Any, start: float, rate: float, height: Any, velocity: Any) -> Any:
    angle = rate * (start - height)
    return force * (math.sin(angle) if isinstance(angle, float) else np.sin(angle))  # for one number NumPy takes ten times as long


def _line(force: Any, slope: Any, lower: float, height: Any, velocity: Any) -> Any:
    return force + slope * (height - lower)


def _contact(touching: float, stiffness: Any, damping: Any, height: Any, velocity: Any) -> Any:
    return stiffness * (touching - height) - damping * velocity
