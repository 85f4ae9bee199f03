"""The point of the slide where process forces act: the table's ``tool``, or midway between ends of slots, which URDF cannot express."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from ..common.quantities import Array
from ..linkage.tool_point import middle_of_outermost
from .copies import Parts
from .formulas import Numbers
from .links import FRAME, place_of
from .placement import Pin, size_of
from .reading import Entry
from .tree import Tree


class Tool(NamedTuple):
    """A point of a link.

    Attributes:
        link: name of the link.
        point: (3,) in the world, in the drawn pose [m].
        name: description of the point for messages.
    """

    link: str
    point: Array
    name: str


def read_tool(items: Mapping[str, Entry], pins: Mapping[str, Pin], parts: Parts, tree: Tree, numbers: Numbers) -> Tool | None:
    """Find the point of the slide where process forces act; None if its pins determine it, as in `Linkage.tool`.

    Args:
        items: key -> entry of the table.
        pins: pin name -> pin of the table, before links are copied.
        parts: links and pins in the drawn pose.
        tree: bearings of the parts.
        numbers: reads the table's numbers.

    Raises:
        PinTableError: the press has no slide for its tool, or the tool is not a point.
    """
    guided = {link.name: link for link in parts.links if link.guide is not None and link.guide.carrier == FRAME}
    by_guide = {link.guide.name: link for link in guided.values() if link.guide is not None}
    only = next(iter(guided.values())) if len(guided) == 1 else None
    slide = guided.get("slide") or by_guide.get("slide_guide") or only  # as `load` takes it if the call names no slide
    if "tool" in items:
        entry = items["tool"]
        if slide is None:
            entry.refuse("no link is the slide", "guide one link by the frame, guide: up; if several links are guided, name one slide")
        name = f"{entry.value.strip()} of the table" if isinstance(entry.value, str) else "the tool of the table"
        return Tool(slide.name, place_of(entry, {**pins, **parts.pins}, numbers, slide.origin, slide.rotation), name)
    if slide is None or slide.guide is None:
        return None
    slots = [link.guide for link in parts.links if link.guide is not None and link.guide.carrier == slide.name]
    if not any(slot.ends for slot in slots):
        return None
    bearings = (bearing for bearing in (*tree.joints, *tree.loops) if slide.name in (bearing.link1, bearing.link2))
    points = {bearing.pin: parts.pins[bearing.pin].point for bearing in bearings if bearing.pin is not None}
    for slot in slots:
        points |= slot.ends
    middle = middle_of_outermost(points, slide.guide.direction, size_of(parts.pins))
    return None if middle is None else Tool(slide.name, *middle)
