"""How a press depends on the numbers of its pin table: the pivots and the masses that they change, and a number as a dimension.

For each number only the places of the pins are computed again, in a millisecond or two. Derivatives are central differences, because a
table's formulas take no complex numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common.arguments import expect, typed
from ..common.errors import PinpressError, UnknownNameError, cautions_collected, shown
from ..common.quantities import Array
from ..tolerances.dimensions import Dimension
from .building import DrawnPress, drawn_from
from .formulas import number, parameters_of
from .numbers import Path, with_exact_numbers
from .placement import UNITS, size_of
from .reading import Entry
from .urdf_text import drawn_frames

STEP = 1e-5  # of the press, or rad: central differences are then exact to about 1e-10
SAME = 1e-9  # share by which rounding may change what must stay the same
NO_NUMBERS = ("from", "side", "near", "on", "axis", "joint")  # keys of a pin that choose, and do not measure


@typed
def dimension(
    drawn: DrawnPress,
    number_name: str,
    tolerance: float,
    *,
    unit: str = "m",
    name: str | None = None,
    shape: str | ArrayLike = "normal",
    sd: float | None = None,
) -> Dimension:
    """A number of a pin table as a dimension with a tolerance. Every pin that the table computes from this number moves with it.

    The pins move on straight lines, with their derivative by the number, so the dimension is exact to first order.

    Args:
        drawn: the press of `draft`.
        number_name: a parameter, such as "r", or a number of a pin by its keys, such as "pins.D.1" for its first coordinate.
        tolerance: half-width +/- of the tolerance [m, of an angle rad], not in the unit of the table.
        unit: "m", or "rad" if the number is an angle.
        name: name of the dimension; None: the name of the number.
        shape: as in `Dimension`.
        sd: as in `Dimension`.

    Raises:
        UnknownNameError: the table has no such number.
        PinpressError: no pin depends on the number, the unit does not fit it, or the number also changes the drawn angle of a crank, the
            direction of a guide or a ratio.
    """
    expect("drawn", drawn, DrawnPress, "pin_table.draft")
    table, known = drawn._table, dict(_numbers_of(drawn._table))
    if not isinstance(number_name, str) or number_name not in known:
        raise UnknownNameError(f"number in {drawn.file}", number_name, known)
    path, entry = known[number_name]
    if not isinstance(unit, str) or unit not in ("m", "rad"):
        raise PinpressError(f"unit of {number_name} is {shown(unit)}: give 'm' or 'rad'")
    turns = unit == "rad"
    if path[0] == "pins" and (path[-1] == "angle") != turns:
        what, right, wrong = ("a length", "mm", "an angle") if turns else ("an angle", "deg", "a length")
        raise PinpressError(f"{number_name} is {what}, but its tolerance is {wrong}: give the tolerance in {right}")
    value = number(entry, parameters_of(table.items("a table")))
    step = STEP if turns else STEP * size_of(drawn.pins)
    in_table = np.degrees(step) if turns else step / UNITS[drawn.unit]
    with cautions_collected():  # those of the press itself were issued
        ahead, back = (drawn_from(with_exact_numbers(table, {path: value + way * in_table})) for way in (1.0, -1.0))
    refuse_changed(kept_by_variation(drawn), ahead, [number_name])
    after, before = pivots_of(ahead), pivots_of(back)
    slopes = {key: (after[key] - before[key]) / (2.0 * step) for key in after}
    moved = {key: np.where(np.abs(slope) > SAME, slope, 0.0) for key, slope in slopes.items() if np.abs(slope).max() > SAME}
    if not moved:
        raise PinpressError(f"no pin of {drawn.file} depends on {number_name}: leave it out")
    return Dimension(number_name if name is None else name, moved, tolerance, shape, sd, unit)


def _numbers_of(table: Entry) -> Iterator[tuple[str, tuple[Path, Entry]]]:
    """Names of the numbers of parameters and pins -> their keys from the top, and their entries."""
    items = table.items("a table")
    for name, entry in items["parameters"].items("names with numbers").items() if "parameters" in items else ():
        yield name, (("parameters", name), entry)
    for path, entry in _leaves(items["pins"], ("pins",)):
        yield ".".join(path), (path, entry)


def _leaves(entry: Entry, path: Path) -> Iterator[tuple[Path, Entry]]:
    below = {str(k): each for k, each in enumerate(entry.value, 1)} if isinstance(entry.value, tuple) else entry.value
    if isinstance(below, Mapping):
        for key, each in below.items():
            if len(path) < 2 or key not in NO_NUMBERS:
                yield from _leaves(each, (*path, key))
    else:
        yield path, entry


def pivots_of(drawn: DrawnPress) -> dict[tuple[str, str], Array]:
    """(bearing, link) -> (3,) position in the link's own frame [m]."""
    frames = drawn_frames(drawn.parts, drawn.tree)
    pivots = {(each.name, each.link1): frames[each.link1].actInv(frames[each.link2].translation) for each in drawn.tree.joints}
    for loop in drawn.tree.loops:
        assert loop.pin is not None
        point = drawn.parts.pins[loop.pin].point
        pivots |= {(loop.name, link): frames[link].actInv(point) for link in (loop.link1, loop.link2)}
    return pivots


def masses_of(drawn: DrawnPress) -> dict[str, Array]:
    """Joint -> (10,) mass, its moments and moments of inertia of the link that it carries, in the link's own frame [SI]."""
    frames, links = drawn_frames(drawn.parts, drawn.tree), {link.name: link for link in drawn.parts.links}
    masses = {}
    for joint in drawn.tree.joints:
        link, place = links[joint.link2], frames[joint.link2]
        inertia = pin.Inertia(link.mass, place.actInv(link.centre), place.rotation.T @ link.inertia @ place.rotation)
        masses[joint.name] = inertia.toDynamicParameters()
    return masses


def kept_by_variation(drawn: DrawnPress) -> dict[str, Array]:
    """What pivots do not show: how drivers, guides and geared links are turned in the drawn pose, ratios and machine elements."""
    frames, links, tree = drawn_frames(drawn.parts, drawn.tree), {link.name: link for link in drawn.parts.links}, drawn.tree
    elements = drawn.parts.elements
    bodies = {body for element in elements for body in element.bodies}
    geared = {*tree.drivers, *tree.gears, *(leader for leader, _ in tree.gears.values())}
    kept: dict[str, Array] = {f"the ratio of {name}": np.array([ratio]) for name, (_, ratio) in tree.gears.items()}
    for joint in tree.joints:
        carrier, link = frames[joint.link1].rotation.T, links[joint.link2]
        if joint.name in geared or joint.pin is None or link.name in bodies:
            kept[f"the angle of {link.name} in the drawn pose"] = carrier @ frames[link.name].rotation
        if link.guide is not None:
            kept[f"the direction of {joint.name}"] = carrier @ link.guide.direction
    if drawn.tool is not None:
        kept["the point of the tool"] = frames[drawn.tool.link].actInv(drawn.tool.point)
    for element in elements:
        numbers = [value for value in element.values.values() if not isinstance(value, str)]
        kept[f"a number of {element.name}"] = np.array([*numbers, 0.0], dtype=float)
    return kept


def refuse_changed(kept: Mapping[str, Array], drawn: DrawnPress, names: Iterable[str]) -> None:
    """Raise PinpressError if a press with other values of the named numbers differs in what must stay the same (`kept_by_variation`)."""
    now = kept_by_variation(drawn)
    for what, before in kept.items():
        if not np.abs(now[what] - before).max() <= SAME * max(1.0, np.abs(before).max()):
            raise PinpressError(
                f"{what} changes with {', '.join(names)}, but must stay the same: place the pins of a crank by from, length and angle"
            )
