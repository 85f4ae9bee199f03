"""Free bodies of a URDF: each ``<joint type="floating">`` becomes a fixed joint, or six single joints with massless links between them."""

from __future__ import annotations

from typing import Literal

from ...common.errors import PinpressError, UrdfError, shown
from ..description import FREE, Description, has_mass, names
from ..document import Document, Finding
from ..text import Text, as_text, in_series, tag

Base = Literal["fixed", "floating"]

FAR = 1e9  # limit of the three travels [m]: URDF has no slide without limits
_AXES = ("1 0 0", "0 1 0", "0 0 1", "0 0 1", "0 1 0", "1 0 0")  # in the order of `FREE`


def with_base(document: Document, base: Base) -> Document:
    """The document with its free joints held or split, see `load`; the same document where it has none.

    A free body that a loop joins to links which it does not carry is a part of the linkage, such as the platform of a hexapod or a robot
    with a foot on the ground, and is always split.

    Raises:
        PinpressError: ``base`` is neither "fixed" nor "floating".
        UrdfError: the base shall float, but the file has neither a free joint nor a root link with a mass.
    """
    if not isinstance(base, str) or base not in ("fixed", "floating"):
        raise PinpressError(f"base is {shown(base)}: write 'fixed' or 'floating'")
    robot = document.robot
    free = [joint for joint in robot.all("joint") if joint.get("type") == "floating"]
    if not free and base == "fixed":
        return document
    text, remarks, description = Text(document), list(document.remarks), document.description
    for joint in free:
        name, parent, child = joint.get("name"), joint.of_child("parent", "link"), joint.of_child("child", "link")
        if base == "floating" or _is_in_loop(description, child):
            place = {name: origin.get(name) for origin in joint.all("origin") for name in ("xyz", "rpy") if origin.get(name)}
            text.replace(joint, _split(name, parent, child, place))
        else:
            text.set(joint, {"type": "fixed"})
            problem = f"it leaves link {child!r} free; here it holds it in the drawn pose"
            remarks.append(Finding("warning", str(joint), joint.line, problem, "to leave it free, write load(..., base='floating')"))
    if not free and description.root and not description.bases:
        text.append(robot, _free_root(document, description))
    return Document(document.file, text.edited(), document.origins, tuple(remarks), document.estimated)


def _is_in_loop(description: Description, child: str) -> bool:
    """Whether a loop joins a link that this one carries, or itself, to one that it does not carry."""
    carried = {child}
    for link, joint in description.carriers.items():  # each link behind the one that carries it
        if joint.parent in carried:
            carried.add(link)
    return any((loop.link1.link in carried) != (loop.link2.link in carried) for loop in description.loops)


def _free_root(document: Document, description: Description) -> str:
    """The elements that let the root link of a file without a free joint float."""
    root = next(link for link in document.robot.all("link") if link.get("name") == description.root)
    if not has_mass(root):
        problem = "base='floating', but the file has no free joint, and its root link has no mass"
        raise UrdfError(document.file, str(root), root.line, problem, 'write its <inertial>, or <joint type="floating"> above the base')
    taken = {*description.links, *names(document.robot, "joint")}
    world = next(name for name in ("world", "ground", "universe_of_base") if name not in taken)
    return tag("link", {"name": world}) + _split("base", world, description.root, {})


def _split(name: str, parent: str, child: str, place: dict[str, str]) -> str:
    """Six joints from parent to child, and the five links without mass between them, as text."""
    limit = tag("limit", {"lower": as_text([-FAR]), "upper": as_text([FAR]), "effort": "0", "velocity": "0"})
    kinds = [("prismatic", limit)] * 3 + [("continuous", "")] * 3
    single = [
        ({"name": f"{name}{free}", "type": kind}, tag("axis", {"xyz": axis}) + limits)
        for free, axis, (kind, limits) in zip(FREE, _AXES, kinds, strict=True)
    ]
    return in_series(single, parent, child, [f"{name}{free}" for free in FREE[:-1]], tag("origin", place) if place else "")
