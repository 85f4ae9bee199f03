"""Which bearing of a press is a joint of its tree and which one closes a loop; their names, and the senses of their forces.

1. Links that slide in the frame hang there.
2. Then, again and again, the first link in the table's order hangs that can: (a) by a driven or geared pin or guide; (b) by its guide, or
   by its first pin; (c) by any of its pins; (d) on links that slide in the frame, which (a) to (c) leave out. A link with a guide hangs by
   that.
3. Every other meeting at a pin closes a loop.

A bearing has its pin's name. Where three or more links meet at a pin K, the one that hung first is the reference, and every other link
has a bearing K_<link>, with the force of the reference on that link. Otherwise the force of a joint is that of what carries a link on
that link, and the force of a loop that of the link written first on the other one; the frame counts as written first, links that slide in
it as last.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..common.errors import suggestion
from .copies import Parts
from .links import FRAME, Link
from .reading import Entry


@dataclass(frozen=True)
class Joint:
    """A bearing of the tree.

    Attributes:
        name: of the bearing.
        pin: that it is at; None of a guide.
        parent: the link that carries the other one.
        child: the link that hangs.
    """

    name: str
    pin: str | None
    parent: str
    child: str


@dataclass(frozen=True)
class Loop:
    """A bearing that closes a loop.

    Attributes:
        name: of the bearing.
        pin: that it is at.
        link1: the link whose force it has.
        link2: the link on which that acts.
    """

    name: str
    pin: str
    link1: str
    link2: str


@dataclass(frozen=True)
class Tree:
    """The tree of a press and the bearings that close its loops.

    Attributes:
        joints: of the tree, in the table's order of the links that hang by them.
        loops: others.
        drivers: names of driven joints.
        gears: by the name of a joint, the joint that it follows and how many times it moves as far.
    """

    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    drivers: tuple[str, ...]
    gears: dict[str, tuple[str, float]]


def build_tree(parts: Parts, table: Entry) -> Tree:
    """The tree of a press.

    Raises:
        PinTableError: links that hang nowhere, or a driver or gear that is no bearing.
    """
    return _Growing(parts, table).tree()


class _Growing:
    def __init__(self, parts: Parts, table: Entry) -> None:
        self.parts, self.table = parts, table
        self.links = {link.name: link for link in parts.links}
        self.order = [FRAME, *self.links]
        self.sliders = [link.name for link in parts.links if link.guide is not None and link.guide.carrier == FRAME]
        self.at: dict[str, list[str]] = {name: [] for name in parts.pins}
        for pin in parts.frame:
            self.at[pin].append(FRAME)
        for link in parts.links:
            for pin in link.pins:
                self.at[pin].append(link.name)
        self.hung = [FRAME]
        self.by: dict[str, tuple[str | None, str]] = {}  # pin (None: its guide) and parent of every hung link
        self.special = {*parts.drivers, *parts.gears, *(leader for leader, _ in parts.gears.values())}

    def _refuse_held(self, link: Link) -> None:
        """Raise PinTableError where a link that slides in the frame has a pin that is fixed there."""
        held = next((pin for pin in link.pins if pin in self.parts.frame), None)
        if held is not None:
            remedy = f"take {held} out of frame:, or leave the guide out"
            link.entry.refuse(f"it is to slide in the frame, and its pin {held} is fixed there", remedy)

    def tree(self) -> Tree:
        """Hang all links, then name the bearings."""
        for name in self.sliders:
            self._refuse_held(self.links[name])
            self._hang(name, None, FRAME)
        while len(self.hung) <= len(self.links):
            self._hang(*self._next())
        self._check_free_ends()
        joints = tuple(Joint(self._joint_name(name), *self.by[name], name) for name in self.links)
        named = {joint.pin or joint.name: joint.name for joint in reversed(joints)}  # of several at a pin, the first
        gears = {self._bearing(name, named): (self._bearing(leader, named), k) for name, (leader, k) in self.parts.gears.items()}
        self._refuse_without_carrier({joint.name: joint for joint in joints}, gears)
        return Tree(joints, tuple(self._loops()), tuple(self._bearing(name, named) for name in self.parts.drivers), gears)

    def _hang(self, link: str, pin: str | None, parent: str) -> None:
        self.hung.append(link)
        self.by[link] = pin, parent

    def _next(self) -> tuple[str, str | None, str]:
        """The link that hangs next, its pin and what it hangs on."""
        waiting = [link for link in self.links.values() if link.name not in self.hung]
        for choose in (self._driven, self._first, self._any, self._on_sliders):
            for link in waiting:
                if found := choose(link):
                    return link.name, *found
        loose = ", ".join(link.name for link in waiting)
        waiting[0].entry.refuse(
            f"{loose}: connected to nothing that hangs in the frame", "name a pin that it shares with other links or the frame"
        )

    def _driven(self, link: Link) -> tuple[str | None, str] | None:
        if link.guide is not None:
            return self._by_guide(link) if link.guide.name in self.special else None
        return next((found for pin in link.pins if pin in self.special and (found := self._at_pin(pin))), None)

    def _first(self, link: Link) -> tuple[str | None, str] | None:
        return self._by_guide(link) if link.guide is not None else self._at_pin(link.pins[0])

    def _any(self, link: Link) -> tuple[str | None, str] | None:
        return None if link.guide is not None else next((found for pin in link.pins if (found := self._at_pin(pin))), None)

    def _on_sliders(self, link: Link) -> tuple[str | None, str] | None:
        if link.guide is not None:
            return self._by_guide(link, also=True)
        return next((found for pin in link.pins if (found := self._at_pin(pin, also=True))), None)

    def _by_guide(self, link: Link, also: bool = False) -> tuple[None, str] | None:
        assert link.guide is not None
        carrier = link.guide.carrier
        return (None, carrier) if carrier in self.hung and (also or carrier not in self.sliders) else None

    def _at_pin(self, pin: str, also: bool = False) -> tuple[str, str] | None:
        """The reference link of a pin, where it hangs already; one that slides in the frame only where ``also`` says so."""
        there = [name for name in self.hung if name in self.at[pin] and (also or name not in self.sliders)]
        if not there:
            return None
        every = [name for name in self.hung if name in self.at[pin]]
        return pin, every[0] if len(self.at[pin]) > 2 else there[0]

    def _reference(self, pin: str) -> str:
        return next(name for name in self.hung if name in self.at[pin])

    def _check_free_ends(self) -> None:
        """Refuse a link that one bearing alone holds, which nothing moves; mobility would refuse it too, but speaks of loops."""
        guided = [link for link in self.links.values() if link.guide is not None]
        held = {link.name for link in guided} | {link.guide.carrier for link in guided if link.guide is not None}
        for link in self.links.values():
            meetings = [pin for pin in link.pins if len(self.at[pin]) > 1]
            if len(meetings) == 1 and link.name not in held and meetings[0] not in self.special:
                remedy = "give a slide its guide: up, others a pin with another link"
                link.entry.refuse(f"it hangs by pin {meetings[0]} alone and swings freely", remedy)

    def _joint_name(self, link: str) -> str:
        pin, _ = self.by[link]
        if pin is None:
            guide = self.links[link].guide
            assert guide is not None
            return guide.name
        return pin if len(self.at[pin]) == 2 else f"{pin}_{link}"

    def _loops(self) -> Iterator[Loop]:
        for pin, names in self.at.items():
            if len(names) < 2:
                continue
            reference = self._reference(pin)
            for name in sorted(names, key=self.order.index):
                if name == reference or self.by.get(name, (None,))[0] == pin:
                    continue
                if len(names) > 2:
                    yield Loop(f"{pin}_{name}", pin, reference, name)
                elif self.by.get(reference, (None,))[0] != pin:
                    yield Loop(pin, pin, *sorted((reference, name), key=self._rank))

    def _rank(self, link: str) -> tuple[bool, int]:
        return link in self.sliders, self.order.index(link)

    def _bearing(self, name: str, named: dict[str, str]) -> str:
        """The joint of the tree at a driven or geared pin or guide."""
        entry = self._where(name)
        if name in named:
            if name in self.parts.drivers and name in self.at and FRAME not in self.at[name]:
                both = " and ".join(self.at[name])
                entry.doubt(
                    f"pin {name} is not in the frame: angle, speed and torque are those of {both} against each other; "
                    f"a crank is driven by its pin in the frame: {', '.join(self.parts.frame)}"
                )
            return named[name]
        if name in self.links:
            pin, _ = self.by[name]
            entry.refuse(f"{name} is a link", f"name its bearing: {pin or self._joint_name(name)}")
        if name in self.parts.pins:
            entry.refuse(f"nothing hangs by pin {name}", "name a pin between the frame and a link, or a guide")
        if name.startswith("-") and name[1:] in named:
            remedy = f"write {name[1:]}, and turns: clockwise in the table, or turn it the other way by a negative speed"
            entry.refuse(f"{name} has a sign, and a bearing is named without one", remedy)
        entry.refuse(f"no pin or guide {name}{suggestion(name, named)}", f"name one of {', '.join(named)}")

    def _refuse_without_carrier(self, joints: dict[str, Joint], gears: dict[str, tuple[str, float]]) -> None:
        """Raise PinTableError for a gear pair whose two axes no link holds: teeth mesh by angles against the link that carries both gears,
        and the joints' angles are against other links."""
        for follower, (leader, _) in gears.items():
            geared = joints[follower], joints[leader]
            if {geared[0].parent, geared[0].child}.isdisjoint((geared[1].parent, geared[1].child)):
                carriers = ", ".join(f"{joint.name} is between {joint.parent} and {joint.child}" for joint in geared)
                problem = f"no link carries both axes of the gear pair {follower}, {leader}: {carriers}; teeth would part"
                gears_entry = self.table.items("a table").get("gears", self.table)
                written = gears_entry.items("gears").get(follower, gears_entry)
                written.refuse(problem, "gear bearings that have a link in common; other planetary gears are not computed")

    def _where(self, name: str) -> Entry:
        items = self.table.items("a table")
        key = "drive" if name in self.parts.drivers else "gears"
        return items.get(key, self.table)
