"""Sort the bearings of a press into joints of its tree and bearings that close a loop; name them, and fix the senses of their forces.

1. Links that slide in the frame hang there.
2. Then repeat: hang the first link (in the table's order) that can hang (a) by a driven or geared pin or guide, or a gear by its centre;
   (b) by its guide or its first pin; (c) by any of its pins; (d) on a link that slides in the frame. Steps (a) to (c) do not use links that
   slide in the frame. A link with a guide hangs by its guide.
3. Every other connection at a pin closes a loop.

A bearing has its pin's name. If three or more links meet at a pin K, the link that hung first is the reference. Every other link then has
a bearing K_<link>, whose force acts from the reference on that link. Otherwise the force of a joint acts from the carrying link on the
carried link. The force of a loop acts from the link written first on the other link. Here the frame counts as the first link, and links
that slide in the frame count as the last ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..common.errors import suggestion
from .copies import Parts
from .links import FRAME, Link
from .reading import Entry


@dataclass(frozen=True)
class Bearing:
    """A joint of the tree, or a bearing that closes a loop.

    Attributes:
        name: of the bearing.
        pin: name of its pin; None if the bearing is a guide.
        link1: the link that exerts the bearing's force; of a joint, the link that carries the other one.
        link2: the link on which this force acts; of a joint, the link that is carried.
    """

    name: str
    pin: str | None
    link1: str
    link2: str


@dataclass(frozen=True)
class Tree:
    """The tree of a press and the bearings that close its loops.

    Attributes:
        joints: bearings of the tree, in the table's order of the links that they carry.
        loops: bearings that close a loop.
        drivers: names of driven joints.
        gears: name of a geared joint -> (joint that it follows, ratio of its motion to that one's).
    """

    joints: tuple[Bearing, ...]
    loops: tuple[Bearing, ...]
    drivers: tuple[str, ...]
    gears: dict[str, tuple[str, float]]


def build_tree(parts: Parts, table: Entry) -> Tree:
    """Build the tree of a press.

    Raises:
        PinTableError: a link is connected to nothing, or a driver or gear names no bearing.
    """
    return _Growing(parts, table).tree()


class _Growing:
    def __init__(self, parts: Parts, table: Entry) -> None:
        self.parts, self.table = parts, table
        self.links = {link.name: link for link in parts.links}
        self.order = [FRAME, *self.links]
        self.sliders = [link.name for link in parts.links if link.guide is not None and link.guide.carrier == FRAME]
        carried = [(FRAME, parts.frame), *((link.name, link.pins) for link in parts.links)]
        self.at = {pin: {name: None for name, pins in carried if pin in pins}.keys() for pin in parts.pins}  # links at every pin, in order
        self.hung = [FRAME]
        self.by: dict[str, tuple[str | None, str]] = {}  # pin (None: its guide) and parent of every hung link
        self.special = {*parts.drivers, *parts.gears, *(leader for leader, _ in parts.gears.values())}
        self.meshing = {body: element.carrier for element in parts.elements for body in element.bodies}  # and what carries both
        for link in parts.links:
            self.special.update(pin for pin in link.pins if self.meshing.get(link.name) in self.at[pin])

    def tree(self) -> Tree:
        """Hang all links, then name the bearings."""
        for name in self.sliders:
            link = self.links[name]
            if fixed := next((pin for pin in link.pins if pin in self.parts.frame), None):
                remedy = f"take {fixed} out of frame:, or leave the guide out"
                link.entry.refuse(f"it slides in the frame, but its pin {fixed} is fixed in the frame", remedy)
            self._hang(name, None, FRAME)
        while len(self.hung) <= len(self.links):
            self._hang(*self._next())
        self._check_free_ends()
        joints = tuple(Bearing(self._joint_name(name), *self.by[name], name) for name in self.links)
        named = {joint.pin or joint.name: joint.name for joint in reversed(joints)}  # the first joint at each pin
        gears = {self._bearing(name, named): (self._bearing(leader, named), k) for name, (leader, k) in self.parts.gears.items()}
        self._refuse_without_carrier({joint.name: joint for joint in joints}, gears)
        return Tree(joints, tuple(self._loops()), tuple(self._bearing(name, named) for name in self.parts.drivers), gears)

    def _hang(self, link: str, pin: str | None, parent: str) -> None:
        self.hung.append(link)
        self.by[link] = pin, parent

    def _next(self) -> tuple[str, str | None, str]:
        """The link that hangs next, its pin and what it hangs on."""
        waiting = [link for link in self.links.values() if link.name not in self.hung]
        for step in ("driven", "first", "any", "on a slider"):
            for link in waiting:
                if place := self._place(link, step):
                    return link.name, *place
        loose = ", ".join(link.name for link in waiting)
        remedy = "name a pin that it shares with other links or the frame"
        waiting[0].entry.refuse(f"{loose}: connected to nothing that hangs in the frame", remedy)

    def _place(self, link: Link, step: str) -> tuple[str | None, str] | None:
        """Where a link can hang in a step: its pin (None: its guide) and the link that carries it. None if it cannot hang yet."""
        carriers = [name for name in self.hung if step == "on a slider" or name not in self.sliders]
        if link.guide is not None:
            may = step != "driven" or link.guide.name in self.special
            return (None, link.guide.carrier) if may and link.guide.carrier in carriers else None
        chosen = {"driven": [pin for pin in link.pins if pin in self.special], "first": link.pins[:1]}.get(step, link.pins)
        pin = next((pin for pin in chosen if not self.at[pin].isdisjoint(carriers)), None)
        return None if pin is None else (pin, self._reference(pin))

    def _reference(self, pin: str) -> str:
        return next(name for name in self.hung if name in self.at[pin])

    def _check_free_ends(self) -> None:
        """Refuse a link that hangs by one bearing and that no drive moves. Mobility would refuse it too, but its message is about loops."""
        guided = [link for link in self.links.values() if link.guide is not None]
        held = {link.name for link in guided} | {link.guide.carrier for link in guided if link.guide is not None} | {*self.meshing}
        for link in self.links.values():
            meetings = [pin for pin in link.pins if len(self.at[pin]) > 1]
            if len(meetings) == 1 and link.name not in held and meetings[0] not in self.special:
                remedy = "give a slide guide: up; give any other link a pin that another link has too; name a gear in meshes:"
                link.entry.refuse(f"it hangs only by pin {meetings[0]} and swings freely", remedy)

    def _joint_name(self, link: str) -> str:
        pin, guide = self.by[link][0], self.links[link].guide
        if pin is None:
            assert guide is not None
            return guide.name
        return pin if len(self.at[pin]) == 2 else f"{pin}_{link}"

    def _loops(self) -> Iterator[Bearing]:
        for pin, names in self.at.items():
            if len(names) < 2:
                continue
            reference = self._reference(pin)
            for name in sorted(names, key=self.order.index):
                if name == reference or self.by.get(name, (None,))[0] == pin:
                    continue
                if len(names) > 2:
                    yield Bearing(f"{pin}_{name}", pin, reference, name)
                elif self.by.get(reference, (None,))[0] != pin:
                    yield Bearing(pin, pin, *sorted((reference, name), key=lambda link: (link in self.sliders, self.order.index(link))))

    def _bearing(self, name: str, named: dict[str, str]) -> str:
        """The joint of the tree at a driven or geared pin or guide."""
        entry = self._written("drive" if name in self.parts.drivers else "gears")
        if name in named:
            if name in self.parts.drivers and name in self.at and FRAME not in self.at[name] and self.parts.frame:
                both = " and ".join(self.at[name])
                entry.doubt(
                    f"pin {name} is not in the frame: the drive turns {both} relative to each other; "
                    f"to drive a crank, name its pin in the frame: {', '.join(self.parts.frame)}"
                )
            return named[name]
        if name in self.links:
            entry.refuse(f"{name} is a link", f"name its bearing: {self.by[name][0] or self._joint_name(name)}")
        if name in self.parts.pins:
            entry.refuse(f"nothing hangs by pin {name}", "name a pin between the frame and a link, or a guide")
        if name.startswith("-") and name[1:] in named:
            remedy = f"write {name[1:]}; to turn it the other way write turns: clockwise, or give a negative speed"
            entry.refuse(f"{name} has a sign, but names of bearings have no sign", remedy)
        entry.refuse(f"no pin or guide {name}{suggestion(name, named)}", f"name one of {', '.join(named)}")

    def _refuse_without_carrier(self, joints: dict[str, Bearing], gears: dict[str, tuple[str, float]]) -> None:
        """Refuse a gear pair whose two axes are not on one link.

        Teeth mesh by angles relative to the link that carries both gears; the angles of these joints are relative to other links.
        """
        for follower, (leader, _) in gears.items():
            geared = joints[follower], joints[leader]
            if {geared[0].link1, geared[0].link2}.isdisjoint((geared[1].link1, geared[1].link2)):
                carriers = ", ".join(f"{joint.name} is between {joint.link1} and {joint.link2}" for joint in geared)
                problem = f"no link carries both axes of the gear pair {follower}, {leader}: {carriers}. The teeth would separate"
                written = self._written("gears")
                written = written.items("gears").get(follower, written)
                wheels = " ".join(joint.link2 for joint in geared)
                written.refuse(problem, f"write gears whose carrier moves by their teeth: meshes: {{teeth: {{gears: {wheels}, teeth: }}}}")

    def _written(self, key: str) -> Entry:
        return self.table.items("a table").get(key, self.table)
