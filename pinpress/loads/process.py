"""Process loads: forces between slide and bolster, as functions of the slide's height and direction of travel; and the protocol that they
and a caller's own follow (`ProcessLoad`): intervals of force over the height.

They act along the slide's guide; on the slide positive in the direction of its position (`Linkage.slide_direction`), upwards in an upright
press, on the frame the opposite. The slide works against it, downwards, so a positive force resists the working stroke. Heights [m] are
slide positions above a datum: the load's ``datum`` (a slide position [m]), by default that of bottom dead centre. Magnitudes may be arrays
(S,), one value a scenario.

The load cases are those of Zhang 2007 (JF75G-125), 5.7, as functions of height instead of time: a press slows down under its load, and
windows in time then miss the stroke that they were made for.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import any_numbers, finite_numbers, number, suitable_numbers, typed
from ..common.errors import PinpressError, shown
from ..common.frozen import read_only
from ..common.parameters import Checked, set_field
from ..common.parameters import parameter as parameter
from ..common.quantities import Array, Values

if TYPE_CHECKING:
    from ..linkage.linkage import Linkage

RESISTS = "positive resists the slide's work"


@dataclass(frozen=True)
class Idle(Checked):
    """The press runs empty: no force. Zhang 2007, 5.7.1 (1).

    Attributes:
        datum: slide position from which heights count [m]; None: that of bottom dead centre.
    """

    datum: float | None = field(default=None, metadata=parameter("m"))

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return ()


@dataclass(frozen=True, eq=False)
class ConstantForce(Checked):
    """Pulse about bottom dead centre: constant force below a height, both ways, so without work in a stroke. Zhang 2007, 5.7.1 (2).

    The window in time of 5.7.3, t = 2.5 ms before and after bottom dead centre, is for a crank r and a rod l at crank speed w, nearly,
    the height r (1 + r/l) (w t)^2 / 2: for r = 15 mm, l = 300 mm and 300 strokes/min 0.0486 mm.

    Attributes:
        force: [N], or (S,) for S scenarios; not negative.
        height: below which it acts [m], not negative; with 0 it acts nowhere.
        datum: slide position from which heights count [m]; None: that of bottom dead centre.
    """

    force: Values = field(metadata=parameter("N", "not negative", scenarios=True, remark=RESISTS))
    height: float = field(metadata=parameter("m"))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.height < 0:
            raise PinpressError(f"ConstantForce: height is {self.height:g}; give the height above bottom dead centre [m], not negative")

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return self._both_ways if self.height else ()

    @cached_property
    def _both_ways(self) -> tuple[ForceInterval, ...]:
        return (ForceInterval(self.height, -math.inf, constant_law(self.force), heeds_velocity=False),)


@dataclass(frozen=True, eq=False)
class Blanking(Checked):
    """Quarter sine on the way down: F sin(pi/2 (start - h)/(start - end)) until the blank breaks through. Zhang 2007, 5.7.1 (3).

    Attributes:
        force: the largest, F, at the height ``end`` [N], or (S,) for S scenarios; not negative.
        start: height at which the punch meets the blank [m].
        end: height at which it breaks through [m], below ``start``.
        stripping: constant force that holds the slide back over the same heights on the way up, as the punch leaves the strip [N], or
            (S,); not negative.
        datum: slide position from which heights count [m]; None: that of bottom dead centre.
    """

    force: Values = field(metadata=parameter("N", "not negative", scenarios=True, remark=RESISTS))
    start: float = field(metadata=parameter("m"))
    end: float = field(metadata=parameter("m"))
    stripping: Values = field(default=0.0, metadata=parameter("N", "not negative", scenarios=True, remark=RESISTS))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_span(self)
        plausibility.stripping("Blanking: stripping", float(np.max(self.stripping)), float(np.max(self.force)))

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        if downwards:
            law: Law = partial(_sine, self.force, self.start, 0.5 * math.pi / (self.start - self.end))
        elif np.any(self.stripping):
            law = constant_law(-self.stripping)
        else:
            return ()
        return (ForceInterval(self.start, self.end, law, heeds_velocity=False),)


@dataclass(frozen=True, eq=False)
class DeepDrawing(Checked):
    """Half sine on the way down: F sin(pi (start - h)/(start - end)). Zhang 2007, 5.7.1 (4).

    Attributes:
        force: the largest, F, midway [N], or (S,) for S scenarios; not negative.
        start: height at which the punch meets the blank [m].
        end: height at which the cup is drawn [m], below ``start``.
        datum: slide position from which heights count [m]; None: that of bottom dead centre.
    """

    force: Values = field(metadata=parameter("N", "not negative", scenarios=True, remark=RESISTS))
    start: float = field(metadata=parameter("m"))
    end: float = field(default=0.0, metadata=parameter("m"))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_span(self)

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        if not downwards:
            return ()
        law = partial(_sine, self.force, self.start, math.pi / (self.start - self.end))
        return (ForceInterval(self.start, self.end, law, heeds_velocity=False),)


@dataclass(frozen=True, eq=False)
class ForceStroke(Checked):
    """Table of force over height, on the way down: linear between its points, no force beyond them.

    Attributes:
        heights: (n,) [m], at least two, strictly rising or falling; kept rising.
        forces: (n,) at the heights [N], or (n, S) for S scenarios; negative where the slide is drawn down.
        datum: slide position from which heights count [m]; None: that of bottom dead centre.
    """

    heights: ArrayLike = field(metadata=parameter("m", axes=1))
    forces: ArrayLike = field(metadata=parameter("N", axes=1, scenarios=True))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        heights, forces = np.asarray(self.heights), np.asarray(self.forces)
        if len(heights) < 2:
            raise PinpressError(f"ForceStroke: heights has shape {heights.shape}; give (n,) of at least two [m]")
        if len(forces) != len(heights):
            raise PinpressError(f"ForceStroke: forces has shape {forces.shape}; give one force for each of the {len(heights)} heights [N]")
        if heights[0] > heights[-1]:
            heights, forces = heights[::-1], forces[::-1]
        if not np.all(np.diff(heights) > 0):
            raise PinpressError("ForceStroke: heights neither rises nor falls throughout; sort its points, each height once")
        with np.errstate(all="ignore"):
            slopes = np.diff(forces, axis=0).T / np.diff(heights)
        if not np.isfinite(slopes).all():
            raise PinpressError("ForceStroke: heights are too close together for the change of forces between them; move them apart")
        set_field(self, "heights", read_only(heights))
        set_field(self, "forces", read_only(forces))

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        if not downwards:
            return ()
        heights = np.asarray(self.heights).tolist()
        forces: list[Any] = list(np.asarray(self.forces)) if np.ndim(self.forces) == 2 else np.asarray(self.forces).tolist()
        points = list(zip(heights, forces, strict=True))
        return tuple(
            ForceInterval(upper, lower, partial(_line, force, (above - force) / (upper - lower), lower), heeds_velocity=False)
            for (lower, force), (upper, above) in itertools.pairwise(points)
        )


@dataclass(frozen=True, eq=False)
class ElasticDie(Checked):
    """A die, stop or cushion met at a height: spring and damper side by side below it, both ways, that push but never pull.

    Its force is k (height - h) - c v, zero where that is negative. Where the slide meets it with a damper, the force begins with a jump.

    Attributes:
        height: at which the slide touches the unloaded die [m].
        stiffness: k, positive [N/m], or (S,) for S scenarios.
        damping: c, not negative [N s/m], or (S,).
        datum: slide position from which heights count [m]; None: that of bottom dead centre.
    """

    height: float = field(metadata=parameter("m"))
    stiffness: Values = field(metadata=parameter("N/m", "positive", scenarios=True))
    damping: Values = field(default=0.0, metadata=parameter("N s/m", "not negative", scenarios=True))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return self._both_ways

    @cached_property
    def _both_ways(self) -> tuple[ForceInterval, ...]:
        law = partial(_contact, self.height, self.stiffness, self.damping)
        return (ForceInterval(self.height, -math.inf, law, one_sided=True, heeds_velocity=bool(np.any(self.damping))),)


@dataclass(frozen=True, eq=False)
class TimeForce:
    """Force between slide and bolster as a function of time, for comparison with models that prescribe it so.

    It stays where it is in time when the press slows down under its load: prefer a process load.

    Attributes:
        force: function of time (n,) [s] that returns the force on the slide along its guide's axis (n,) [N], or one number.
        edges: instants at which it is not smooth [s]; kept sorted.
    """

    force: Callable[[Array], ArrayLike]
    edges: Sequence[float] = ()

    def __post_init__(self) -> None:
        if not callable(self.force):
            raise PinpressError(f"TimeForce: force is {shown(self.force)}; give a function of time [s]")
        edges = finite_numbers(self.edges)
        if edges is None or edges.ndim != 1:
            problem = f"is {shown(self.edges)}" if edges is None else f"has shape {edges.shape}"
            raise PinpressError(f"TimeForce: edges {problem}; give a sequence of instants [s]")
        set_field(self, "edges", tuple(np.unique(edges).tolist()))


def step(x: ArrayLike, x0: float, h0: float, x1: float, h1: float) -> Array:
    """ADAMS' function STEP: h0 up to x0, h1 from x1, between them h0 + (h1 - h0) d^2 (3 - 2 d) with d = (x - x0)/(x1 - x0).

    Source: the load functions of Zhang 2007, 5.7.3 to 5.7.5.

    Args:
        x: places, of any shape; the result has the same shape.
        x0: place at which the step begins.
        h0: value up to x0.
        x1: place at which the step ends, above x0.
        h1: value from x1 on.

    Raises:
        PinpressError: x1 is not above x0, or a value is no number.
    """
    places = any_numbers("step: x", x)
    if np.isnan(places).any():
        raise PinpressError("step: x is not finite")
    begin, before, end, after = (number(f"step: {name}", value) for name, value in (("x0", x0), ("h0", h0), ("x1", x1), ("h1", h1)))
    if end > begin and not math.isfinite(1 / (end - begin)):
        raise PinpressError("step: x0 and x1 are too near to each other: move them apart")
    if not end > begin:
        raise PinpressError(f"step: x1 is {end:g}, not above x0, {begin:g}; write step(x, x0, h0, x1, h1) with x0 < x1")
    share = np.clip((places - begin) / (end - begin), 0.0, 1.0)
    share = share * share * (3.0 - 2.0 * share)
    return np.asarray(before * (1.0 - share) + after * share)


def _check_span(load: Blanking | DeepDrawing) -> None:
    """Raise PinpressError where a load does not start above its end, or so close to it that the rate of its force overflows."""
    extent = load.start - load.end
    if not (extent > 0 and math.isfinite(extent) and math.isfinite(math.pi / extent)):
        raise PinpressError(
            f"{type(load).__name__}: start is {load.start:g}, not above end, {load.end:g}; give heights [m] with start above end"
        )


# The laws are module functions that `partial` binds, not closures: loads can then be sent to other processes.


def constant_law(force: Any) -> Law:
    """The law of a force that depends on nothing, a number or (S,) [N]."""
    return partial(_constant, force)


def _constant(force: Any, height: Any, velocity: Any) -> Any:
    return force + 0.0 * height  # of the height's shape


def _sine(force: Any, start: float, rate: float, height: Any, velocity: Any) -> Any:
    angle = rate * (start - height)
    return force * (math.sin(angle) if isinstance(angle, float) else np.sin(angle))  # for one number NumPy takes ten times as long


def _line(force: Any, slope: Any, lower: float, height: Any, velocity: Any) -> Any:
    return force + slope * (height - lower)


def _contact(touching: float, stiffness: Any, damping: Any, height: Any, velocity: Any) -> Any:
    return stiffness * (touching - height) - damping * velocity


Law = Callable[[Any, Any], Any]  # of numbers a number, of arrays an array


@dataclass(frozen=True)
class ForceInterval:
    """One smooth interval of a process force, in one direction of travel.

    Attributes:
        upper: height up to which it acts, lower < height <= upper [m]; may be infinite.
        lower: height from which it acts [m]; may be infinite.
        force: law of height [m] and velocity along the axis [m/s] that returns the force on the slide along the axis [N]. For numbers it
            returns a number, or (S,) where the load has scenarios; for arrays (..., S) the same shape. It is smooth, even a little beyond
            the interval.
        one_sided: whether the interval is a contact: where the law pulls the contact is lost, and the force is zero.
        heeds_velocity: whether the force depends on the velocity, or the place where a contact is lost does. True is always right.
        sense: 1 where a contact pushes along the axis, upwards, -1 where it pushes against it, as a stop above the slide does.
    """

    upper: float
    lower: float
    force: Law
    one_sided: bool = False
    heeds_velocity: bool = True
    sense: int = 1

    def acting(self, law: Any) -> Any:
        """The force where the law has this value: a contact that would pull is lost."""
        if not self.one_sided:
            return law
        return np.maximum(law, 0.0) if self.sense > 0 else np.minimum(law, 0.0)

    def pushes(self, law: float) -> bool:
        """Whether a contact is not lost where the law has this value."""
        return self.sense * law >= 0


@runtime_checkable
class ProcessLoad(Protocol):
    """A force between slide and bolster: any class with these two members.

    Its intervals are always the same, and their forces depend on height, velocity and direction of travel alone.
    """

    @property
    def datum(self) -> float | None:
        """Slide position from which heights are measured [m]; None for that of bottom dead centre."""

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        """The intervals on the way down (against the slide's direction) or up; disjoint, no force outside them.

        Where both are equal, with the very same laws, the direction of travel does not matter.
        """


@typed
def datum(load: ProcessLoad, press: Linkage) -> float:
    """Slide position from which the heights of a load are measured [m].

    Raises:
        PinpressError: the linkage has no slide, the load has no datum and the linkage no bottom dead centre, or the datum is no number.
    """
    from ..kinematics.slide_path import dead_centres  # with Pinocchio, which describing a load does without

    if not isinstance(load, ProcessLoad) or isinstance(load, type):
        raise PinpressError(f"load is a {type(load).__name__}: give a process load")
    _ = press.slide_guide
    if load.datum is not None:
        wanted = "a slide position [m], or None for bottom dead centre"
        return float(suitable_numbers(f"{type(load).__name__}: datum", load.datum, wanted))
    try:
        return dead_centres(press).bottom_position
    except PinpressError as error:
        raise PinpressError(
            f"{type(load).__name__}: {press.name} has no bottom dead centre to measure heights from ({error});"
            " give datum=, a slide position [m]"
        ) from error
