"""Dimensions of a press that scatter: which pivots a dimension moves, how far, and how the dimension is distributed.

A deviation d of a dimension moves its pivots by d times the dimension's direction, on straight lines. So an angle is exact to first order
only: its pivot leaves the arc by half the arm times the square of the angle (0.02 um for an arm of 0.5 m and 0.01 deg). Bearings in the
same place of a link of a planar press are on one pin, e.g. where three links meet, and move together.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import number, numbers, suitable_numbers, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError, caution, shown
from ..common.frozen import Frozen
from ..common.parameters import set_field
from ..common.quantities import Array
from ..derivatives.motion import Pivots, directed
from ..linkage.linkage import Linkage

SHAPES = ("normal", "uniform", "truncated")
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, eq=False)
class Dimension(Frozen):
    """A dimension of a press with its tolerance: ``Dimension("EF", {("F", "rod"): (1, 0, 0)}, 50e-6)``.

    Attributes:
        name: name in results.
        direction: (bearing, link) -> (3,) derivative of the bearing's position by the dimension, in the link's own frame, as in
            `derivatives.motion_derivatives` [-, of an angle m/rad].
        tolerance: half-width +/- of the tolerance [m, of an angle rad]. If the tolerances of a drawing are not symmetric, give the press
            their middle, and give half of their width here.
        shape: "normal"; "uniform": all deviations within the tolerance are equally likely; "truncated": normal, but no deviation is
            outside the tolerance; or (n,) measured deviations, one of which is drawn for each press.
        sd: standard deviation of a normal dimension, or of a truncated one before truncation; None: a third of the tolerance.
        unit: unit of the dimension, "m" or "rad".
    """

    name: str
    direction: Pivots
    tolerance: float
    shape: str | ArrayLike = "normal"
    sd: float | None = None
    unit: str = "m"

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise PinpressError(f"name of a dimension is {shown(self.name)}: give a text, e.g. 'EF'")
        if not isinstance(self.unit, str) or self.unit not in ("m", "rad"):
            raise PinpressError(f"dimension {self.name!r}: unit is {shown(self.unit)}: give 'm' or 'rad'")
        set_field(self, "direction", self._checked_direction())
        set_field(self, "tolerance", self._size("tolerance", self.tolerance))
        if isinstance(self.shape, str):
            if self.shape not in SHAPES:
                raise PinpressError(
                    f"shape of {self.name!r} is {shown(self.shape)}: give {', '.join(map(repr, SHAPES))} or measured deviations (n,)"
                )
        else:
            set_field(self, "shape", self._checked_sample())
        if self.sd is not None:
            if not isinstance(self.shape, str) or self.shape == "uniform":
                raise PinpressError(
                    f"dimension {self.name!r}: sd is given, but a uniform or measured dimension determines its sd: leave out sd"
                )
            set_field(self, "sd", self._size("sd", self.sd))
            if _is_normal(self) and self.sd > self.tolerance:
                caution(
                    f"dimension {self.name!r}: sd is {self.sd:g} {self.unit}, above its tolerance of {self.tolerance:g}, so a third of all"
                    " parts would miss the tolerance: exchange both, or check the units"
                )
        super().__post_init__()

    @property
    def standard_deviation(self) -> float:
        """Standard deviation of the drawn deviations [m or rad]."""
        if not isinstance(self.shape, str):
            return float(np.std(np.asarray(self.shape)))
        if self.shape == "uniform":
            return self.tolerance / math.sqrt(3.0)
        return self._sd if _is_normal(self) else self._sd * _truncated_sd(self.tolerance / self._sd)

    @property
    def mean(self) -> float:
        """Mean deviation [m or rad]; 0 except for measured deviations."""
        return 0.0 if isinstance(self.shape, str) else float(np.mean(np.asarray(self.shape)))

    def draw(self, generator: np.random.Generator, samples: int) -> Array:
        """Draw deviations (samples,), one for each press [m or rad]."""
        if not isinstance(self.shape, str):
            return generator.choice(np.asarray(self.shape), samples)
        if self.shape == "uniform":
            return generator.uniform(-self.tolerance, self.tolerance, samples)
        if self.shape == "normal":
            return self._sd * generator.standard_normal(samples)
        from scipy.special import ndtr, ndtri  # to save start-up time

        end = float(ndtr(self.tolerance / self._sd))
        cut = self._sd * ndtri(generator.uniform(1.0 - end, end, samples))
        return np.asarray(np.clip(cut, -self.tolerance, self.tolerance))

    @property
    def _sd(self) -> float:
        """Standard deviation of a normal dimension, or of a truncated one before truncation."""
        return self.sd or self.tolerance / 3.0

    def _size(self, what: str, value: object) -> float:
        return number(f"{what} of dimension {self.name!r}", value, self.unit, positive=True)

    def _checked_direction(self) -> dict[tuple[str, str], Array]:
        what = f"direction of dimension {self.name!r}"
        if not isinstance(self.direction, Mapping) or not self.direction:
            raise PinpressError(
                f"{what} is {shown(self.direction)}: give {{(bearing, link): (x, y, z)}}, derivatives in the link's own frame"
            )
        checked = {}
        for key, values in self.direction.items():
            if not (isinstance(key, tuple) and len(key) == 2 and all(isinstance(name, str) for name in key)):
                raise PinpressError(f"{what}: {shown(key)} is not a pair of names: write (bearing, link)")
            checked[key] = suitable_numbers(f"{what}: {shown(key)}", values, "three finite numbers, in the link's own frame", (3,))
        if not any(vector.any() for vector in checked.values()):
            raise PinpressError(f"{what} is zero, so it moves no pivot: give a derivative other than (0, 0, 0)")
        return checked

    def _checked_sample(self) -> Array:
        what = f"measured deviations of dimension {self.name!r}"
        sample = numbers(what, self.shape, (None,), unit=self.unit)
        if len(sample) < 2 or not np.ptp(sample):
            raise PinpressError(f"{what} are {shown(sample.tolist())}: give at least two different deviations")
        largest = float(np.abs(sample).max())
        if largest > 100.0 * self.tolerance:
            caution(
                f"{what} reach {largest:g} {self.unit}, but the tolerance is {self.tolerance:g} {self.unit}: give deviations from the"
                f" nominal dimension, in {self.unit}"
            )
        return sample


def _truncated_sd(limit: float) -> float:
    """Standard deviation of a standard normal variable that is truncated at +/- limit."""
    if limit < 1e-3:  # nearly uniform, where the difference below cancels
        return limit / math.sqrt(3.0)
    inside = math.erf(limit / math.sqrt(2.0))
    return math.sqrt(1.0 - math.sqrt(2.0 / math.pi) * limit * math.exp(-0.5 * limit * limit) / inside)


# ------------------------------------------------------------------------------------------------------ dimensions by names of pins


@typed
def link_length(
    press: Linkage,
    first: str,
    second: str,
    tolerance: float,
    *,
    name: str | None = None,
    shape: str | ArrayLike = "normal",
    sd: float | None = None,
) -> Dimension:
    """The distance between two pins of a link, in the plane of a planar press.

    The second pin moves away from the first pin. All other pins of the link stay.

    Args:
        press: the press.
        first: a pin of the link, or a bearing in the frame.
        second: another pin of the same link.
        tolerance: half-width +/- of the distance's tolerance [m].
        name: name of the dimension; None: the names of both pins.
        shape: as in `Dimension`.
        sd: as in `Dimension`.

    Raises:
        UnknownNameError: the press does not have a bearing with this name.
        PinpressError: no link has both pins, both pins are in one place, or one of them is a guide.
    """
    body = _common_body(press, first, second)
    arm = _arm(press, body, first, second)
    along = arm / np.linalg.norm(arm)
    return Dimension(
        _join_names(first, second) if name is None else name,
        _moved_pin(press, body, press.link_of(body), second, along),
        tolerance,
        shape,
        sd,
    )


@typed
def pin_angle(
    press: Linkage,
    first: str,
    vertex: str,
    second: str,
    tolerance: float,
    *,
    name: str | None = None,
    shape: str | ArrayLike = "normal",
    sd: float | None = None,
) -> Dimension:
    """The angle between two arms of a link.

    The second pin moves at a right angle to its arm from the vertex. It moves on a straight line, which is an angle to first order. All
    other pins of the link stay.

    Args:
        press: the press; in space the pin moves in the plane of both arms.
        first: pin at the end of the first arm.
        vertex: pin where the arms meet.
        second: pin at the end of the second arm.
        tolerance: half-width +/- of the angle's tolerance [rad].
        name: name of the dimension; None: "angle" and the names of the pins.
        shape: as in `Dimension`.
        sd: as in `Dimension`.

    Raises:
        UnknownNameError: the press does not have a bearing with this name.
        PinpressError: no link has all three pins, two pins are in one place, a bearing is a guide, or the arms of a press in space are in
            one line.
    """
    body = _common_body(press, first, vertex, second)
    first_arm, second_arm = (_arm(press, body, vertex, pin) for pin in (first, second))
    normal = _normal(press, body)
    if normal is None:
        normal = np.cross(first_arm, second_arm)
        size = np.linalg.norm(normal)
        if not size > 1e-9 * np.linalg.norm(first_arm) * np.linalg.norm(second_arm):  # the sine of the angle is rounding error
            raise PinpressError(
                f"the arms {vertex}-{first} and {vertex}-{second} are in one line, so their angle has no plane: give a Dimension with the"
                " direction in which a pin moves"
            )
        normal /= size
    away = np.cross(normal, second_arm) * (1.0 if np.cross(first_arm, second_arm) @ normal >= 0 else -1.0)  # the angle grows
    return Dimension(
        f"angle {_join_names(first, vertex, second)}" if name is None else name,
        _moved_pin(press, body, press.link_of(body), second, away),
        tolerance,
        shape,
        sd,
        unit="rad",
    )


@typed
def pin_position(
    press: Linkage,
    bearing: str,
    axis: str | Sequence[float],
    tolerance: float,
    *,
    link: str | None = None,
    name: str | None = None,
    shape: str | ArrayLike = "normal",
    sd: float | None = None,
) -> Dimension:
    """The position of a pin or guide in a link, by default in the frame. All other pins of the link stay.

    Args:
        press: the press.
        bearing: the pin or guide; a guide is moved as a line.
        axis: direction of the motion in the link's own frame (for the frame: world axes), "x", "y", "z" or a vector (3,) of any length.
        tolerance: half-width +/- of the position's tolerance [m].
        link: the link in which the bearing moves; None: the frame.
        name: name of the dimension; None: the bearing's name and the axis.
        shape: as in `Dimension`.
        sd: as in `Dimension`.

    Raises:
        UnknownNameError: the press does not have a bearing or link with this name.
        PinpressError: the bearing is not on this link or cannot be moved in it, or axis is not an axis.
    """
    if isinstance(axis, str):
        if axis not in AXES:
            raise PinpressError(f"axis is {shown(axis)}: give 'x', 'y', 'z' or three numbers")
        along, called = np.array(AXES[axis]), axis
    else:
        vector = suitable_numbers("axis", axis, "'x', 'y', 'z' or three numbers that are not all zero", (3,), np.any)
        along = vector / np.abs(vector).max()  # squares of very large ones overflow
        along, called = along / np.linalg.norm(along), f"({', '.join(f'{part:g}' for part in vector)})"
    where = press.root if link is None else link
    refuse_unknown("bearing", bearing, press.bearings)
    refuse_unknown("link", where, press.links)
    directed(press, {(bearing, where): along})  # refuses links that the bearing is not on
    if name is None:
        name = f"{bearing} {called}" if link is None else f"{bearing} {called} in {link}"
    return Dimension(name, _moved_pin(press, press.frame_of(where).parentJoint, where, bearing, along), tolerance, shape, sd)


def _common_body(press: Linkage, *pins: str) -> int:
    """The body that has all these pins."""
    bodies: list[set[int]] = []
    for pin in pins:
        refuse_unknown("bearing", pin, press.bearings)
        bodies.append(_ends(press, press.bearings.index(pin)))
        if not _is_pin(press, pin):
            raise PinpressError(f"{pin!r} is a guide, not a pin: move it by pin_position(press, {pin!r}, 'x', ...)")
    if len(set(pins)) < len(pins):
        raise PinpressError(f"a pin is named twice in {', '.join(pins)}: name different pins")
    common = set.intersection(*bodies)
    if not common:
        named = [" and ".join(press.link_of(body) for body in sorted(ends)) for ends in bodies]
        which = "; ".join(f"{pin} joins {links}" for pin, links in zip(pins, named, strict=True))
        raise PinpressError(f"no link has the pins {', '.join(pins)} ({which}): name pins of one link")
    return min(common)


def refuse_unknown(kind: str, name: object, known: Sequence[str]) -> None:
    """Raise UnknownNameError if a name is not among the known names."""
    if not isinstance(name, str) or name not in known:
        raise UnknownNameError(kind, name, known)


def _ends(press: Linkage, bearing: int) -> set[int]:
    """The two bodies that a bearing joins."""
    if bearing < len(press.joints):
        return {int(press.model.parents[bearing + 1]), bearing + 1}
    loop = press.loops[bearing - len(press.joints)]
    return {int(loop.joint1), int(loop.joint2)}


def _position(press: Linkage, body: int, bearing: str) -> Array:
    """Position (3,) of a bearing in the frame of the body's first link [m]."""
    place = press.bearings.index(bearing)
    if place < len(press.joints):
        point = press.model.jointPlacements[place + 1].translation if press.model.parents[place + 1] == body else np.zeros(3)
    else:
        loop = press.loops[place - len(press.joints)]
        point = loop.point1 if loop.joint1 == body else loop.point2
    return np.array(press.frame_of(press.link_of(body)).placement.actInv(point))


def _moved_pin(press: Linkage, body: int, link: str, bearing: str, by: Array) -> dict[tuple[str, str], Array]:
    """The direction that moves one pin of a link, in the frame of the link.

    A pin at the origin of the body's frame cannot move in this frame; instead all other pins move the other way.
    """
    pin = _bearings_of_pin(press, body, bearing)
    if not body or press.joints[body - 1] not in pin:
        return {(name, link): by for name in pin}
    return {(name, link): -by for name in _bearings_on(press, body) if name not in pin}


def _bearings_of_pin(press: Linkage, body: int, bearing: str) -> list[str]:
    """The bearings of a body that share a pin with this bearing: in a planar press all bearings in this place, e.g. where three links meet.

    In space, bearings in one place may be the axes of a cross, so only this bearing counts.
    """
    if not _is_pin(press, bearing) or _normal(press, body) is None:
        return [bearing]
    place, near = _position(press, body, bearing), 1e-9 * press.size
    others = (other for other in _bearings_on(press, body) if _is_pin(press, other))
    return [other for other in others if np.linalg.norm(_position(press, body, other) - place) <= near]


def _bearings_on(press: Linkage, body: int) -> list[str]:
    return [bearing for place, bearing in enumerate(press.bearings) if body in _ends(press, place)]


def _is_pin(press: Linkage, bearing: str) -> bool:
    place = press.bearings.index(bearing)
    return place >= len(press.joints) or press.axes[place].turns


def _arm(press: Linkage, body: int, first: str, second: str) -> Array:
    """Vector (3,) from one pin to another, in the frame of the body's first link, in the plane of a planar press [m]."""
    arm = _position(press, body, second) - _position(press, body, first)
    normal = _normal(press, body)
    if normal is not None:
        arm -= (arm @ normal) * normal
    if not arm.any():
        raise PinpressError(f"the pins {first} and {second} are in one place: give a Dimension with the direction in which a pin moves")
    return arm


def _normal(press: Linkage, body: int) -> Array | None:
    """Normal (3,) of the plane of a planar press in the frame of a body's first link; None in space."""
    axes = press.engine().turning_axes(body)
    return press.frame_of(press.link_of(body)).placement.rotation.T @ axes[0] if len(axes) == 1 else None


def _join_names(*pins: str) -> str:
    return "".join(pins) if all(len(pin) == 1 for pin in pins) else "-".join(pins)


# ------------------------------------------------------------------------------------------------------------------------ all dimensions


def check_dimensions(press: Linkage, parts: Sequence[Dimension]) -> tuple[Dimension, ...]:
    """The checked dimensions of a press, each once.

    Raises:
        PinpressError: there is no dimension, a part is not a `Dimension`, two dimensions have the same name, or a bearing is not on the
            link or cannot be moved in it.
        UnknownNameError: the linkage does not have a bearing or link with this name.

    Warns:
        PinpressWarning: a tolerance is larger than a tenth of its link, or than 0.1 rad.
    """
    dimensions = tuple(parts)
    for dimension in dimensions:
        if not isinstance(dimension, Dimension):
            raise PinpressError(f"parts has a {type(dimension).__name__}: give Dimensions, e.g. from link_length(press, ...)")
    names = [dimension.name for dimension in dimensions]
    if not dimensions:
        raise PinpressError("parts is empty: give the dimensions that scatter, parts=[tolerances.link_length(press, ...), ...]")
    if len(set(names)) < len(names):
        twice = ", ".join(sorted({name for name in names if names.count(name) > 1}))
        raise PinpressError(f"dimensions are given twice: {twice}; give each once, or different names")
    for dimension in dimensions:
        directed(press, dimension.direction)
        moved = max(float(np.linalg.norm(vector)) for vector in dimension.direction.values())
        length, tolerance = min(_extent(press, link) for _, link in dimension.direction), dimension.tolerance
        if dimension.unit == "rad" and tolerance > 0.1:
            caution(f"dimension {dimension.name!r} has a tolerance of {tolerance:g} rad, more than 0.1 rad: give rad, not degrees")
        elif dimension.unit == "m" and tolerance * moved > 0.1 * length:
            caution(
                f"dimension {dimension.name!r} has a tolerance of {tolerance:g} m, but the pins of its link are only {length:.3g} m apart."
                f" Is it {tolerance:g} mm? Write {tolerance:g}e-3"
            )
    return dimensions


def _extent(press: Linkage, link: str) -> float:
    """Largest distance between two bearings of a link [m]; the size of the linkage if the link has only one bearing."""
    body = press.frame_of(link).parentJoint
    points = [_position(press, body, name) for name in _bearings_on(press, body)]
    return max((float(np.linalg.norm(first - second)) for first in points for second in points), default=0.0) or press.size


def correlation_matrix(parts: Sequence[Dimension], correlation: Mapping[tuple[str, str], float] | None) -> Array:
    """Coefficients (k, k) of correlation between dimensions.

    Args:
        parts: the dimensions.
        correlation: (name, name) -> correlation coefficient of two normal dimensions [-]; other pairs are independent.

    Raises:
        UnknownNameError: a dimension does not exist.
        PinpressError: a key is not a pair, a pair is given twice, a coefficient is outside -1 to 1, a dimension is not normal, or the
            coefficients contradict each other.
    """
    names, result = [part.name for part in parts], np.eye(len(parts))
    pairs: set[frozenset[str]] = set()
    for pair, value in (correlation or {}).items():
        if not (isinstance(pair, tuple) and len(pair) == 2) or pair[0] == pair[1]:
            raise PinpressError(f"correlation: {shown(pair)} is not a pair of names: write (dimension, dimension)")
        for name in pair:
            refuse_unknown("dimension", name, names)
            if not _is_normal(parts[names.index(name)]):
                raise PinpressError(
                    f"correlation: dimension {name!r} is not normal: give the part that it shares with {pair[1 - pair.index(name)]!r} as a"
                    " separate dimension, which moves the pivots of both"
                )
        place = names.index(pair[0]), names.index(pair[1])
        if frozenset(pair) in pairs:
            raise PinpressError(f"correlation: {shown(pair)} is given twice: give each pair once")
        pairs.add(frozenset(pair))
        result[place] = result[place[::-1]] = suitable_numbers(
            f"correlation of {pair[0]} and {pair[1]}", value, "a number from -1 to 1", suits=lambda coefficient: abs(coefficient) <= 1.0
        )
    if correlation and np.linalg.eigvalsh(result)[0] < -1e-12 * len(parts):  # less is rounding error
        raise PinpressError(
            "correlation: the coefficients contradict each other (their matrix has a negative eigenvalue): make them smaller"
        )
    return result


def _is_normal(part: Dimension) -> bool:
    return isinstance(part.shape, str) and part.shape == "normal"


def draw_deviations(parts: Sequence[Dimension], correlation: Array, samples: int, seed: int) -> Array:
    """Deviations (k, samples) of the dimensions from the nominal ones [m or rad].

    Args:
        parts: the k dimensions.
        correlation: (k, k) from `correlation_matrix`.
        samples: number of presses.
        seed: seed of the random numbers; the same seed gives the same presses.
    """
    count = whole_number("samples", samples, 2, 10**7)
    generator = np.random.default_rng(whole_number("seed", seed, 0, 2**63 - 1))
    drawn = np.array([part.draw(generator, count) for part in parts])
    if not np.array_equal(correlation, np.eye(len(parts))):
        scale = np.array([part.standard_deviation for part in parts])[:, None]
        tied = np.abs(correlation).sum(axis=1) > 1.0
        drawn[tied] = scale[tied] * (root_of(correlation)[np.ix_(tied, tied)] @ (drawn[tied] / scale[tied]))
    return drawn


def root_of(correlation: Array) -> Array:
    """The symmetric square root (k, k) of correlation coefficients (k, k), also if their matrix is singular."""
    values, vectors = np.linalg.eigh(correlation)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T)
