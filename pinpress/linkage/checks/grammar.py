"""The grammar of a URDF: which elements and attributes it may have. `problems` are errors, `find_unknown` warns of what nothing reads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, fields
from functools import cache
from typing import NamedTuple

from ...common.arguments import LARGEST
from ...common.errors import shown, suggestion
from ..description import MACHINE_ELEMENTS, Cam
from ..document import Finding
from ..element import Element

Problem = tuple[Element, str, str]
"""The element at fault, the problem, and the remedy."""


class _Rule(NamedTuple):
    """What an element may contain. Elements without a rule, and names with a namespace prefix, are not checked. An element in another one
    may have its own rule there, under both tags."""

    attributes: str = ""  # "?" follows those that may be missing
    children: str = ""  # "?": at most one; "*": any number; else just one; any other child is an error
    unknown: str = "error"  # what an unknown attribute is: an error, a warning, or a warning if it is misspelt
    foreign_children: str = ""  # written by other programs (ROS, Gazebo, Bullet, Drake, MuJoCo), and read by none of ours
    foreign_attributes: str = ""


def _attributes(kind: type) -> str:
    """Attributes of a machine element; the name and those with a default may be missing."""
    names = (each.name if each.default is MISSING and each.name != "name" else f"{each.name}?" for each in fields(kind))
    return " ".join(name for name in names if name not in ("line?", "points?", "tabulated?"))


_RULES = {
    "robot": _Rule(
        "name? version?",
        "link* joint* loop_joint* relation* gear_mesh* rack* screw* worm* cam* joint_spring* armature* material* transmission* home?",
        "warning",
        "gazebo ros2_control mujoco sensor fixed_frame frame",
    ),
    "link": _Rule(
        "name?",
        "inertial? visual* collision* tool?",
        "warning",
        "sensor self_collision_checking verbose velocity contact audio_source origin",
        "type concave",
    ),
    "joint": _Rule(
        "name? type? independent?",
        "origin? parent child axis? limit? dynamics? calibration? safety_controller? mimic?",
        "warning",
        "joint_properties sensor",
        "dont_collapse",
    ),
    "loop_joint": _Rule("name? type?", "link1 link2 axis?", "warning"),
    "joint_spring": _Rule("joint stiffness? reference? damping?"),
    "armature": _Rule("joint inertia"),
    "relation": _Rule("name? offset?", "joint*"),
    "relation joint": _Rule("name coefficient?"),
    **{tag: _Rule(_attributes(kind)) for tag, kind in MACHINE_ELEMENTS.items()},
    "cam": _Rule(_attributes(Cam), "point* row*"),
    "point": _Rule("angle lift law?"),
    "row": _Rule("angle lift slope? bend?"),
    "inertial": _Rule("", "origin? mass inertia", "warning"),
    "transmission": _Rule("name? type?", "", "warning"),
    "home": _Rule("", "joint*"),
    "home joint": _Rule("name position"),
    "origin": _Rule("xyz? rpy?"),
    "parent": _Rule("link"),
    "child": _Rule("link"),
    "link1": _Rule("link xyz? rpy?"),
    "link2": _Rule("link xyz? rpy?"),
    "axis": _Rule("xyz rpy?"),
    "mass": _Rule("value"),
    "tool": _Rule("xyz name?"),
    "inertia": _Rule("ixx ixy ixz iyy iyz izz"),
    "limit": _Rule("lower? upper? effort velocity", foreign_attributes="acceleration deceleration jerk"),
    "mimic": _Rule("joint multiplier? offset?"),
    # Nothing of the following enters the mechanics.
    "dynamics": _Rule("damping? friction?", "", "misspelt"),
    "calibration": _Rule("rising? falling? reference_position?", "", "misspelt"),
    "safety_controller": _Rule("k_velocity k_position? soft_lower_limit? soft_upper_limit?", "", "misspelt"),
    "visual": _Rule("name?", "origin? geometry material?", "misspelt"),
    "collision": _Rule("name?", "origin? geometry", "misspelt", "verbose contact_coefficients material"),
    "material": _Rule("name?", "color? texture?", "misspelt"),
    "geometry": _Rule("", "box? cylinder? sphere? mesh?", "misspelt"),
    "box": _Rule("size"),
    "cylinder": _Rule("radius length"),
    "sphere": _Rule("radius"),
    "mesh": _Rule("filename scale?", "", "misspelt"),
    "color": _Rule("rgba", "", "misspelt"),
    "texture": _Rule("filename", "", "misspelt"),
}


# What is computed with must have powers and products in floating point.
_QUANTITIES = (
    "xyz",
    "rpy",
    "value",
    "ixx",
    "ixy",
    "ixz",
    "iyy",
    "iyz",
    "izz",
    "multiplier",
    "offset",
    "coefficient",
    "stiffness",
    "reference",
    "damping",
    "position",
    "inertia",
    *("angle", "lift", "slope", "bend"),
    *(each.name for kind in (*MACHINE_ELEMENTS.values(), Cam) for each in fields(kind) if each.type.startswith(("float", "Point"))),
)


def problems(element: Element) -> Iterator[Problem]:
    """Elements and attributes that are unknown, missing, repeated, or not the numbers they should be."""
    tag, rule = element.tag, _rule(element)
    if rule is None:
        return
    yield from _attribute_problems(element, rule)
    words = rule.children.split()
    if not words:
        return
    tags = _names(rule.children)
    for child in element.children:
        if child.tag in tags:
            yield from problems(child)
        elif ":" not in child.tag and child.tag not in rule.foreign_children.split():
            yield child, f"unknown element <{child.tag}>{suggestion(child.tag, tags)}", f"in <{tag}> write one of: {', '.join(tags)}"
    for name, word in zip(tags, words, strict=True):
        children = element.all(name)
        other = next((child for child in children if not child.says_the_same_as(children[0])), None)
        if other is not None and not word.endswith("*"):
            yield other, f"a second <{name}> in one <{tag}>, which says something else", "keep one of them"
        if not children and name == word:
            yield element, f"has no <{name}>", f"write <{name}> in this <{tag}>"
    if tag == "geometry" and len({child.tag for child in element.all(*tags)}) != 1:
        yield element, f"has {len(element.all(*tags))} shapes", f"write just one of: {', '.join(tags)}"
    if tag == "material" and "name" not in element.attributes:
        yield element, "has no name", 'write <material name="...">'


def _attribute_problems(element: Element, rule: _Rule) -> Iterator[Problem]:
    tag, names = element.tag, _names(rule.attributes)
    for name, text in element.attributes.items():
        if name not in names:
            if rule.unknown == "error" and not _is_foreign(name, rule):
                yield element, f"unknown attribute {name!r}{suggestion(name, names)}", f"in <{tag}> write: {', '.join(names)}"
        elif fault := element.fault(name):
            remedy = "write plain numbers, decimals after a point, spaces in between"
            if tag == "limit" and text.strip().lower().lstrip("+-").startswith("inf"):
                remedy = 'URDF has no infinite numbers: write 1e9 for no limit, or type="continuous" of a joint that turns'
            yield element, f"{name}={shown(text)}: {fault}", remedy
        elif name in _QUANTITIES and tag not in ("axis", "sphere", "cylinder") and max(map(abs, element.numbers(name))) > LARGEST:
            yield element, f"{name}={shown(text)} is out of range", f"write SI units; {LARGEST:g} is the largest number"
        elif name in ("size", "radius", "length") and min(element.numbers(name)) <= 0:
            yield element, f"{name}={shown(text)} is not positive", "write the size in metres"
        elif name == "rgba" and not all(0 <= part <= 1 for part in element.numbers(name)):
            yield element, f"rgba={text!r} is not from 0 to 1", 'write, for example, rgba="0.5 0.5 0.5 1"'
    for name, word in zip(names, rule.attributes.split(), strict=True):
        if name == word and not element.get(name):
            yield element, f"has no {name}", f'write <{tag} {name}="..."/>'
    if tag == "dynamics" and not {"damping", "friction"} & element.attributes.keys():
        yield element, "has neither damping nor friction", "write one of them, or remove <dynamics>"


def find_unknown(element: Element) -> Iterator[Finding]:
    """Warnings of attributes and elements that nothing reads and that are no `problems`: they may be misspelt, or in the wrong element.

    What other programs are known to write, and names with a namespace prefix, are left alone.
    """
    tag, rule = element.tag, _rule(element) or _Rule(unknown="misspelt")
    names, tags = _names(rule.attributes), _names(rule.children)
    if rule.unknown != "error":
        mechanical = rule.unknown == "warning"
        for name in element.attributes:
            if name in names or _is_foreign(name, rule):
                continue
            alike = suggestion(name, names)
            if name in tags and mechanical:
                yield warning(element, f"its attribute {name!r} is not read", f"write an element <{name}> in this <{tag}>")
            elif alike or mechanical:
                write = f"attributes of <{tag}> are {', '.join(names)}" if names else f"<{tag}> has no attributes"
                yield warning(element, f"its attribute {name!r} is not read{alike}", f"correct or remove it: {write}")
    elif tag == "origin" and not element.attributes and not element.children and element.end > element.start:  # <origin>0 0 1</origin>
        yield warning(element, "has neither xyz nor rpy; text in it is not read", 'write <origin xyz="..." rpy="..."/>, or remove it')
    # Elements of a <transmission> in ROS, in this spelling; the one that is read is <joint>.
    of_transmissions = "joint", "actuator", "type", "mechanicalReduction", "gap_joint", "passive_joint", "flexJoint", "rollJoint"
    for child in element.children:
        if child.tag in tags:
            yield from find_unknown(child)
        elif rule.unknown == "error" and tag not in ("box", "cylinder", "sphere") and ":" not in child.tag:
            yield warning(element, f"<{child.tag}> in it is not read", f"write what it says as attributes of <{tag}>: {', '.join(names)}")
        elif tag == "transmission" and child.tag not in of_transmissions and suggestion(child.tag, ["joint"]):
            yield warning(element, f"<{child.tag}> in it is not read, did you mean 'joint'?", 'write <joint name="..."/>, the driver')


def _rule(element: Element) -> _Rule | None:
    """The rule of an element, that of its place before that of its tag."""
    there = None if element.parent is None else _RULES.get(f"{element.parent.tag} {element.tag}")
    return there or _RULES.get(element.tag)


@cache
def _names(words: str) -> tuple[str, ...]:
    return tuple(word.rstrip("?*") for word in words.split())


def _is_foreign(attribute: str, rule: _Rule) -> bool:
    return ":" in attribute or attribute == "xmlns" or attribute in rule.foreign_attributes.split()


def warning(element: Element, problem: str, remedy: str) -> Finding:
    """A warning of an element."""
    return Finding("warning", str(element), element.line, problem, remedy)
