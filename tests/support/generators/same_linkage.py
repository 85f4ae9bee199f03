"""The same linkage written in another way: turned with gravity, mirrored, with its driver's axis turned round, with other names, or with
its loops cut elsewhere. What happens in it stays the same."""

from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from support import texts
from support.generators.random_linkages import Drawing

MIRROR = np.array([-1.0, 1.0, 1.0])  # x the other way round
TURNING = -MIRROR  # of axes of turns and of angles: in a mirror left becomes right
ELEMENTS = {  # machine elements, with their attributes that name links
    "gear_mesh": ("gear1", "gear2", "carrier"),
    "rack": ("pinion", "rack", "carrier"),
    "screw": ("screw", "nut"),
    "worm": ("worm", "wheel", "carrier"),
}
OTHER = {"left": "right", "right": "left"}


@dataclass(frozen=True)
class Same:
    """The other linkage.

    Attributes:
        press: itself.
        vectors: (3, 3) what a vector of the first becomes.
        sense: of its driver's coordinate against that of the first.
        names: of links and joints that have others.
    """

    press: Any
    vectors: Any = field(default_factory=lambda: np.eye(3))
    sense: float = 1.0
    names: dict[str, str] = field(default_factory=dict)

    def moments(self, values: Any) -> Any:
        """Moments (n, 3) of the first in the other, where axes of turns change as the determinant says."""
        return np.linalg.det(self.vectors) * values @ self.vectors.T


def _written(root: Any, gravity: Any, slide: str | None) -> Any:
    return texts.load(ElementTree.tostring(root, encoding="unicode"), gravity=tuple(map(float, gravity)), slide=slide)


def _change(element: Any, name: str, signs: Any) -> None:
    if element is not None and element.get(name) is not None:
        numbers = signs * np.array(element.get(name).split(), dtype=float)
        element.set(name, " ".join(repr(float(number)) for number in numbers))


def mirrored(press: Any, random: Any) -> Same:
    """In the plane x = 0. Joint coordinates stay."""
    root = ElementTree.fromstring(press.text)
    for element in root.iter():
        if element.tag != "axis":
            _change(element, "xyz", MIRROR)
            _change(element, "rpy", TURNING)
    for inertia in root.iter("inertia"):
        _change(inertia, "ixy", -1.0)
        _change(inertia, "ixz", -1.0)
    for joint in (*root.iter("joint"), *root.iter("loop_joint")):
        _change(joint.find("axis"), "xyz", MIRROR if joint.get("type") == "prismatic" else TURNING)
    for element in (each for tag in ELEMENTS for each in root.findall(tag)):
        _change(element, "center1", MIRROR)
        _change(element, "center2", MIRROR)
        element.set("hand", OTHER[element.get("hand", "right")])
    return Same(_written(root, press.model.gravity.linear * MIRROR, press.slide), np.diag(MIRROR))


def turned(press: Any, random: Any) -> Same:
    """With gravity, as if the floor were another: the frame is fixed to a link that is turned."""
    root = ElementTree.fromstring(press.text)
    rpy = random.uniform(-3, 3, 3) if random.integers(2) else np.array([0.0, 0.0, random.uniform(-3, 3)])
    children = {child.get("link") for child in root.iter("child")}
    (frame,) = (link.get("name") for link in root.iter("link") if link.get("name") not in children)
    ElementTree.SubElement(root, "link", name="hall")
    bolts = ElementTree.SubElement(root, "joint", name="bolts", type="fixed")
    ElementTree.SubElement(bolts, "parent", link="hall")
    ElementTree.SubElement(bolts, "child", link=frame)
    ElementTree.SubElement(bolts, "origin", xyz="0 0 0", rpy=" ".join(map(repr, map(float, rpy))))
    matrix = pin.rpy.rpyToMatrix(rpy)
    return Same(_written(root, matrix @ press.model.gravity.linear, press.slide), matrix)


def turned_round(press: Any, random: Any) -> Same:
    """The axis of its driver, so that it turns or slides the other way."""
    root = ElementTree.fromstring(press.text)
    (driver,) = (joint for joint in root.iter("joint") if joint.get("name") == press.driver and joint.find("parent") is not None)
    axis = driver.find("axis")
    if axis is None:
        axis = ElementTree.SubElement(driver, "axis", xyz="1 0 0")
    _change(axis, "xyz", -1.0)
    limit = driver.find("limit")
    if limit is not None and limit.get("lower") is not None:
        lower, upper = limit.get("lower"), limit.get("upper", "0")
        limit.set("lower", repr(-float(upper)))
        limit.set("upper", repr(-float(lower)))
    for mimic in root.iter("mimic"):
        if mimic.get("joint") == press.driver:
            mimic.set("multiplier", repr(-float(mimic.get("multiplier", "1"))))
    for joint in root.iterfind("relation/joint"):
        if joint.get("name") == press.driver:
            joint.set("coefficient", repr(-float(joint.get("coefficient", "1"))))
    return Same(_written(root, press.model.gravity.linear, press.slide), sense=-1.0)


def renamed(press: Any, random: Any) -> Same:
    """In another order of names, by which Pinocchio sorts, and of elements."""
    root = ElementTree.fromstring(press.text)
    every = sorted({str(e.get("name")) for kind in ("link", "joint", "loop_joint", *ELEMENTS) for e in root.findall(kind)})
    names = {
        name: f"{letter}{k}_{name}" for name, letter, k in zip(every, random.choice(list("abcdefgz"), len(every)), range(99), strict=False)
    }
    named = dict.fromkeys(("link", "joint", "loop_joint", "parent", "child", "link1", "link2", "mimic"), ("name", "link", "joint"))
    named |= {tag: ("name", *links) for tag, links in ELEMENTS.items()}
    for element in root.iter():
        for attribute in named.get(element.tag, ()):
            if element.get(attribute) in names:
                element.set(attribute, names[element.get(attribute)])
    elements = list(root)
    for element in elements:
        root.remove(element)
    root.extend([elements[k] for k in random.permutation(len(elements))])
    slide = None if press.slide is None else names[press.slide]
    return Same(_written(root, press.model.gravity.linear, slide), names=names)


WAYS = (mirrored, turned, turned_round, renamed)


def cut_elsewhere(drawing: Drawing, random: Any) -> Drawing:
    """A drawing with another spanning tree of the same links, pins and guides: other pins close its loops. Guides and welds stay in the
    tree, the crank stays where it hangs."""
    hung = [(*joint[:4], drawing.placed[joint[3]][1], joint[6], drawing.placed[joint[3]][0]) for joint in drawing.joints]
    edges = [(name, kind, parent, child, place, turned @ axis) for name, kind, parent, child, place, axis, turned in hung]
    for name, ends in drawing.loops:
        (link1, local), (link2, _) = ends
        rotation, origin = drawing.placed[link1]
        edges.append((name, "loop", link1, link2, origin + rotation @ local, drawing.world[:, 2]))
    other = Drawing(drawing.name, drawing.world, drawing.frame)

    def first(edge: Any) -> tuple[int, float]:
        return {"prismatic": 0, "fixed": 0}.get(edge[1], 0 if edge[0] == "crank" else 1), random.random()

    # Kruskal's algorithm: what must be in the tree comes first
    roots = {link: link for link in drawing.bodies}

    def root(link: str) -> str:
        while roots[link] != link:
            link = roots[link]
        return link

    tree, closing = [], []
    for edge in sorted(edges, key=first):
        ends = root(edge[2]), root(edge[3])
        (tree if ends[0] != ends[1] else closing).append(edge)
        roots[ends[0]] = ends[1]
    reached = [drawing.frame]
    while tree:
        edge = next(edge for edge in tree if edge[2] in reached or edge[3] in reached)
        tree.remove(edge)
        name, kind, link1, link2, place, axis = edge
        parent, child = (link1, link2) if link1 in reached else (link2, link1)
        reached.append(child)
        flat = drawing.world.T @ place
        along = complex(*(drawing.world.T @ axis)[:2]) if kind == "prismatic" else None
        at, height = complex(flat[0], flat[1]), float(flat[2])
        if kind == "fixed":
            other.weld(name, parent, child, at, height)
        else:
            sense = 1 if kind == "prismatic" or axis @ drawing.world[:, 2] > 0 else -1
            other.joint(name, parent, child, at, height, along=along, sense=sense)
    for name, _, link1, link2, place, _ in closing:
        flat = drawing.world.T @ place
        other.loop(name, link1, link2, complex(flat[0], flat[1]), float(flat[2]))
    for link, body in drawing.bodies.items():
        if body is not None:
            other.body(link, *body)
    return other
