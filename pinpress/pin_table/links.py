"""The links of a pin table: pins, guide, mass, centre of mass and moments of inertia (given or estimated) of every link.

The coordinates of a link start at its first pin, with x along the line to its second pin and z to the left of this line. The axes of a
slide, of a link with one pin and of a link with pins in space are parallel to the world's. A block on a guide has x along the guide.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ..common.errors import suggestion
from ..common.quantities import Array
from .formulas import Numbers
from .placement import ALIKE, SIDES, Pin, refuse_unless_a_word, signed_axis
from .reading import Entry

FRAME = "frame"
STEEL = 7850.0  # density unless the table gives one [kg/m3]
LIGHTEST, HEAVIEST = 25.0, 25e3  # densities of solid parts, from foam to beyond tungsten [kg/m3]; numbers in g/cm3 are smaller
DENSEST = 1e7  # hundreds of times the density of any metal: a mass above this is probably not in kg [kg/m3]
MASSLESS = 1e-6  # mass of a link without a given mass if the table has ``masses: none`` [kg]
SLENDER = 1 / 10  # thickness / length of a rod of which only the mass is given
WAYS = "up, down, left, right, an angle, or two points"  # of a guide
KEYS = ("pins", "guide", "travel", "mass", "com", "inertia", "gyration", "section", "overhang", "box", "disc", "density", "parts", "note")
PART_KEYS = ("mass", "disc", "box", "density", "at", "inertia", "note")
SOLIDS = ("section", "box", "disc")
MASSIVE = (*SOLIDS, "mass", "parts")  # keys that give a link mass
OF_MASS = ("com", "inertia", "gyration", "density")  # keys that mean nothing without mass


@dataclass(frozen=True, eq=False)
class Guide:
    """A straight guide that a link slides along.

    Attributes:
        name: of the bearing.
        carrier: name of the link that has the guide.
        direction: (3,) unit vector in the drawn pose.
        travel: lowest and highest coordinate from the drawn pose [m]; None if the table does not give it.
        ends: pin name -> (3,) place of the two pins that draw the guide [m]; empty if the table gives a direction.
    """

    name: str
    carrier: str
    direction: Array
    travel: tuple[float, float] | None = None
    ends: Mapping[str, Array] = field(default_factory=dict)


class CrossSection(NamedTuple):
    """The section of a prism between the first two pins of a link: height and width [m], and its density [kg/m3]."""

    height: float
    width: float
    density: float


@dataclass(frozen=True, eq=False)
class Link:
    """A link in the drawn pose, in world coordinates.

    Attributes:
        name: of the link.
        pins: names; the pin by which the link hangs is the first.
        guide: None if the link has no guide.
        mass: [kg].
        centre: (3,) centre of mass [m].
        inertia: (3, 3) about the centre of mass, world axes [kg m2].
        origin: (3,) its first pin.
        rotation: (3, 3) axes of the link in the world.
        estimates: descriptions of the values that the table does not give.
        inertia_given: whether its moments of inertia are given.
        entry: where it stands in the table.
        section: None if the table gives another solid, or none.
    """

    name: str
    pins: tuple[str, ...]
    guide: Guide | None
    mass: float
    centre: Array
    inertia: Array
    origin: Array
    rotation: Array
    estimates: tuple[str, ...]
    inertia_given: bool
    entry: Entry
    section: CrossSection | None


class _Solid(NamedTuple):
    """A plain body.

    Attributes:
        volume: [m3].
        centre: (3,) world coordinates [m].
        axes: (3, 3) its principal axes in the world.
        gyration: (3,) squares of its radii of gyration about these axes [m2].
    """

    volume: float
    centre: Array
    axes: Array
    gyration: Array

    def inertia(self, mass: float) -> Array:
        """Moments of inertia (3, 3) about the centre, world axes [kg m2]."""
        return np.asarray(self.axes @ np.diag(self.gyration * mass) @ self.axes.T)


class _Body(NamedTuple):
    """A mass [kg] with its centre (3,) [m] and the inertia (3, 3) about it [kg m2], in world coordinates."""

    mass: float
    centre: Array
    inertia: Array

    def about(self, point: Array) -> Array:
        """The inertia about a point, by Steiner's rule."""
        lever = self.centre - point
        return self.inertia + self.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))


def read_links(table: Mapping[str, Entry], pins: Mapping[str, Pin], numbers: Numbers) -> tuple[Link, ...]:
    """Read the links of a table, in the table's order.

    Args:
        table: key -> entry of the table.
        pins: pin name -> pin in its place.
        numbers: reads the table's numbers.

    Raises:
        PinTableError: an entry of a link has a wrong key or value.
    """
    reader = _Reader(table, pins, numbers)
    return tuple(reader.link(name, entry) for name, entry in reader.items.items())


class _Reader:
    def __init__(self, table: Mapping[str, Entry], pins: Mapping[str, Pin], numbers: Numbers) -> None:
        self.items = table["links"].items("links by their names: {crank: {pins: A B, mass: 20}}")
        self.pins, self.numbers = pins, numbers
        if "masses" in table and table["masses"].value not in ("none", "all"):
            table["masses"].refuse(f"{table['masses'].value!r}", "write masses: none, or leave it out")
        self.without = "masses" in table and table["masses"].value == "none"
        self.density = self.density_of(table, STEEL)
        self.carried: dict[str, list[str]] = {}
        for name, entry in self.items.items():
            if name == FRAME:
                entry.refuse(f"{name!r} cannot name a link", "choose another name; `frame` at the top lists the pins of the frame")
            refuse_unless_a_word(name, entry, "a link")
            self.carried[name] = self._pins(entry.known(KEYS, "a link"), entry)
        if self.without and all(any(key in MASSIVE for key in entry.items("a link")) for entry in self.items.values()):
            table["masses"].doubt("masses: none has no effect, because every link has a mass: leave out masses: none, or these masses")

    def link(self, name: str, entry: Entry) -> Link:
        """Read a link."""
        items = entry.known(KEYS, "a link")
        pins = self.carried[name]
        guide = self._guide(name, items["guide"]) if "guide" in items else None
        if "travel" in items:
            if guide is None:
                items["travel"].refuse(f"{name} has no guide", "say where it slides: guide: up")
            guide = replace(guide, travel=self._travel(items["travel"]))
        masses = _Masses(self, items, entry, pins, guide)
        body, origin, axes = masses.body(), masses.points[0], masses.rotation
        return Link(name, tuple(pins), guide, *body, origin, axes, tuple(masses.estimates), masses.inertia_given, entry, masses.section)

    def _pins(self, items: Mapping[str, Entry], entry: Entry) -> list[str]:
        if "pins" not in items:
            entry.refuse("no pins", "name the pins of the link: pins: A B")
        names = items["pins"].names("names of pins, separated by blanks")
        for name in names:
            if name not in self.pins:
                items["pins"].refuse(f"no pin {name}{suggestion(name, self.pins)}", f"name some of {', '.join(self.pins)}")
        if len(set(names)) < len(names):
            items["pins"].refuse("a pin is named twice", "name every pin of the link once")
        return names

    def rotation(self, pins: Sequence[str], guide: Guide | None) -> Array:
        """Axes of a link: parallel to the world's, or with x along its guide, or from its first pin to the next pin at another point."""
        first, *others = (self.pins[name].point for name in pins)
        if any(self.pins[name].in_space for name in pins) or (guide is not None and guide.carrier == FRAME):
            return np.eye(3)
        if guide is not None:
            return axes_along(guide.direction)
        apart = next((point - first for point in others if np.linalg.norm((point - first)[[0, 2]]) > 0), None)
        return np.eye(3) if apart is None else axes_along(apart)

    def _guide(self, link: str, entry: Entry) -> Guide:
        name = f"{link}_guide"
        if isinstance(entry.value, Mapping):
            if len(entry.value) != 1:
                entry.refuse(f"{len(entry.value)} names of a guide", "write one: {slot: C D}")
            ((name, entry),) = entry.value.items()
        words = entry.names(WAYS)
        if len(words) == 1:
            return Guide(name, FRAME, self._direction(entry, words[0]))
        if len(words) > 3:
            entry.refuse(f"{len(words)} words", "write a direction, two points, or a link and two points")
        start, end = words[-2:]
        for word in (start, end):
            if word not in self.pins:
                entry.refuse(f"no pin {word}{suggestion(word, self.pins)}", f"name some of {', '.join(self.pins)}, or write {WAYS}")
        carrier = words[0] if len(words) == 3 else self._carrier(link, entry, start, end)
        if len(words) == 3 and carrier not in (*self.items, FRAME):
            entry.refuse(f"no link {carrier}{suggestion(carrier, self.items)}", f"name one of {', '.join(self.items)} or {FRAME}")
        if carrier == link:
            entry.refuse(f"{link} would slide in itself", "name the link that has the guide")
        way = self.pins[end].point - self.pins[start].point
        if not np.linalg.norm(way) > 0:
            entry.refuse(f"{start} and {end} are one point", "name two points that are apart")
        return Guide(name, carrier, way / np.linalg.norm(way), ends={name: self.pins[name].point for name in (start, end)})

    def _travel(self, entry: Entry) -> tuple[float, float]:
        parts = entry.list("how far it slides from the drawn pose, lowest and highest: [-180, 120]")
        if len(parts) != 2:
            entry.refuse(f"{len(parts)} numbers", "write the lowest and the highest, from the drawn pose: [-180, 120]")
        lower, upper = (self.numbers.length(part) for part in parts)
        if not (lower <= 0.0 <= upper and lower < upper):
            problem = f"it slides from {parts[0].value} to {parts[1].value}"
            entry.refuse(problem, "count from the drawn pose, which is 0: [0 or less, 0 or more]")
        return lower, upper

    def _carrier(self, link: str, entry: Entry, start: str, end: str) -> str:
        """The link that has both ends of a guide; the frame if no link has both."""
        having = [name for name, pins in self.carried.items() if name != link and start in pins and end in pins]
        if len(having) > 1:
            entry.refuse(f"{', '.join(having)} have both {start} and {end}", f"say which one has the guide: {having[0]} {start} {end}")
        return having[0] if having else FRAME

    def _direction(self, entry: Entry, word: str) -> Array:
        if word in SIDES:
            x, z = SIDES[word]
            return np.array([x, 0.0, z])
        if (axis := signed_axis(word)) is not None:
            return axis
        if word in self.pins:
            entry.refuse(f"the guide has one point, {word}", f"write {WAYS}")
        if word.isidentifier() and word not in self.numbers.parameters:
            entry.refuse(f"no direction {word!r}{suggestion(word, (*SIDES, *self.numbers.parameters))}", f"write {WAYS}")
        angle = np.radians(self.numbers.number(replace(entry, value=word)))
        return np.array([np.cos(angle), 0.0, np.sin(angle)])

    def density_of(self, items: Mapping[str, Entry], otherwise: float) -> float:
        """The density among keys [kg/m3], or ``otherwise`` if they have no density. Warns if no part of a press has this density."""
        if "density" not in items:
            return otherwise
        value = self.numbers.above_zero(items["density"], "a density")
        if not LIGHTEST <= value <= HEAVIEST:
            items["density"].doubt(f"{value:.6g} kg/m3 is not the density of a solid part: write it in kg/m3, {STEEL:g} for steel")
        return value


class _Masses:
    """Mass, centre of mass and inertia of a link, given or estimated, with descriptions of the ``estimates``."""

    def __init__(self, reader: _Reader, items: Mapping[str, Entry], entry: Entry, pins: Sequence[str], guide: Guide | None) -> None:
        self.reader, self.numbers = reader, reader.numbers
        self.items, self.entry, self.pins = items, entry, pins
        self.points = [reader.pins[name].point for name in pins]
        self.rotation = reader.rotation(pins, guide)
        self.is_rod_or_plate = guide is None and len(pins) > 1
        self.inertia_given = "inertia" in items or "gyration" in items
        self.estimates: list[str] = []
        self.section: CrossSection | None = None

    def body(self) -> _Body:
        """The link with the parts that are welded on."""
        solids = [key for key in SOLIDS if key in self.items]
        if len(solids) > 1:
            self.items[solids[1]].refuse(f"{' and '.join(solids)}", "give one of them; weld others on as parts")
        if "overhang" in self.items and "section" not in self.items:
            self.items["overhang"].refuse("an overhang without a section", "give section: height x width")
        if "inertia" in self.items and "gyration" in self.items:
            self.items["gyration"].refuse("inertia and gyration", "give one of them")
        if solids:
            body = self._of_solid(solids[0])
        elif "mass" in self.items:
            body = self._of_mass()
        elif self.reader.without:
            body = self._weightless()
        else:
            self.entry.refuse("no mass", "give mass, section, box or disc; or say masses: none at the top")
        if "parts" not in self.items:
            return body
        bodies = [body, *(self._part(each) for each in self.items["parts"].list("parts: [{mass: 20, at: A}]"))]
        mass = sum(each.mass for each in bodies)
        centre = sum((each.mass * each.centre for each in bodies), np.zeros(3)) / mass
        return _Body(mass, centre, sum((each.about(centre) for each in bodies), np.zeros((3, 3))))

    def _weightless(self) -> _Body:
        """A link without a given mass, in a table with ``masses: none``."""
        if idle := next((key for key in OF_MASS if key in self.items), None):
            self.items[idle].refuse(f"{idle} of a link without mass", "give its mass")
        self.estimates.append(f"a mass of {1e6 * MASSLESS:g} mg, as masses: none says")
        centre = np.mean(self.points, axis=0)
        size = max(float(np.linalg.norm(point - centre)) for point in self.points) or 0.1
        return _Body(MASSLESS, centre, MASSLESS * size**2 * np.eye(3))

    def _of_mass(self) -> _Body:
        mass = self.numbers.above_zero(self.items["mass"], "a mass")
        centre, inertia, words = self._estimated(mass)
        if self.inertia_given or not words.startswith("a cube"):
            self._doubt_density(self.items)
        if "com" in self.items:
            centre = self._place(self.items["com"])
        if self.inertia_given:
            if "com" not in self.items:
                self.estimates.append(f"centre of mass {self._middle()}")
            return _Body(mass, centre, self._inertia(mass, centre))
        self._check_beside(centre)
        if self.is_rod_or_plate:
            self._doubt_mass(mass, float(np.ptp(self.points, axis=0).max()) ** 3)
        self.estimates.append(f"moments of inertia of {words}" + ("" if "com" in self.items else ", whose centre is taken too"))
        return _Body(mass, centre, inertia)

    def _middle(self) -> str:
        """Description of the assumed centre of mass."""
        if not self.is_rod_or_plate:
            return f"at {self.pins[0]}"
        apart = _apart(self.points)
        if len(apart) > 2:
            return "of a flat plate with its corners at the pins"
        ends = [name for name, place in zip(self.pins, self.points, strict=True) if any(place is each for each in apart)]
        return f"half-way from {ends[0]} to {ends[1]}"

    def _check_beside(self, centre: Array) -> None:
        """Warn of a centre of mass far from the line of a rod: it is probably given in world coordinates, not in the link's."""
        if "com" not in self.items or isinstance(self.items["com"].value, str) or len(self.pins) != 2 or not self.is_rod_or_plate:
            return
        start, end = self.points
        length = np.linalg.norm(end - start)
        along, away = (end - start) / length, centre - start
        if np.linalg.norm(away - (away @ along) * along) > length / 4:
            a, b = self.pins
            self.items["com"].doubt(
                f"it is far from the line {a} {b} of a link that counts as a rod; com is in the link's axes, "
                f"x from {a} to {b}: name a point of pins for a place in the drawing, or give inertia too"
            )

    def _estimated(self, mass: float) -> tuple[Array, Array, str]:
        """Centre of mass and inertia of a cube, rod or plate with the link's pins. Pins at one point count once."""
        points = _apart(self.points)
        if not self.is_rod_or_plate:
            density = self.reader.density_of(self.items, self.reader.density)
            side = (mass / density) ** (1 / 3)
            of = "steel" if density == STEEL else f"{density:g} kg/m3"
            return points[0], mass * side**2 / 6 * np.eye(3), f"a cube of {of}, {side:.3g} m wide"
        if len(points) == 1:
            self.items["pins"].refuse(f"{' and '.join(self.pins)} are one point: a rod of length zero", "move one")
        if len(points) == 2:
            way = points[1] - points[0]
            length = float(np.linalg.norm(way))
            along = np.outer(way, way) / length**2
            thick = (SLENDER * length) ** 2 / 6
            inertia = mass * (length**2 / 12 * (np.eye(3) - along) + thick * along)
            return (points[0] + points[1]) / 2, inertia, f"a uniform rod, {length:.4g} m long"
        if self.inertia_given and "com" in self.items:
            return points[0], np.zeros((3, 3)), ""
        return (*self._plate(mass, points), "a flat plate with its corners at the pins")

    def _plate(self, mass: float, points: Sequence[Array]) -> tuple[Array, Array]:
        """Centroid and inertia of a lamina whose corners are the pins' convex hull."""
        corners = self._corners(np.array(points)[:, [0, 2]])
        following = np.roll(corners, -1, axis=0)
        cross = corners[:, 0] * following[:, 1] - following[:, 0] * corners[:, 1]
        area = float(cross.sum()) / 2
        centroid = ((corners + following) * cross[:, None]).sum(axis=0) / (6 * area)
        a, b = corners - centroid, following - centroid
        cross = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
        squares = sum(np.einsum("n,ni,nj->ij", cross, side, side) for side in (a, b, a + b)) / 24
        second = np.zeros((3, 3))
        second[np.ix_([0, 2], [0, 2])] = squares * mass / area
        return np.array([centroid[0], points[0][1], centroid[1]]), np.trace(second) * np.eye(3) - second

    def _corners(self, points: Array) -> Array:
        """Corners (k, 2) of the convex hull of points, counter-clockwise."""
        away = points - points[0]
        areas = away[:, None, 0] * away[None, :, 1] - away[:, None, 1] * away[None, :, 0]
        if np.abs(areas).max() <= ALIKE * np.square(away).max():
            self.entry.refuse("its pins are on a line, so it is not a plate", "give com and inertia, or a section")
        if len(points) == 3:
            return points if areas[1, 2] > 0 else points[::-1]
        from scipy.spatial import ConvexHull  # half a second to import, for plates of four pins and more

        return np.asarray(points[ConvexHull(points).vertices])

    def _inertia(self, mass: float, centre: Array) -> Array:
        """Read the inertia: about the centre of mass or a pin, by a radius of gyration, or as three moments."""
        if "gyration" in self.items:
            return _about_normal(mass * self._length(self.items["gyration"], "a radius of gyration") ** 2)
        return self._given_inertia(self.items["inertia"], mass, centre)

    def _given_inertia(self, entry: Entry, mass: float, centre: Array) -> Array:
        if isinstance(entry.value, tuple):
            if len(entry.value) != 3:
                entry.refuse(f"{len(entry.value)} moments of inertia", "give one, about the normal, or three: [Ixx, Iyy, Izz]")
            moments = np.array([self.numbers.number(each) for each in entry.value])
            if not (np.all(moments > 0) and moments.max() <= moments.sum() - moments.max()):
                entry.refuse("no body has these moments of inertia", "give three above zero, none larger than the other two together")
            return np.asarray(self.rotation @ np.diag(moments) @ self.rotation.T)
        if isinstance(entry.value, Mapping):
            if len(entry.value) != 1:
                entry.refuse("an inertia about several points", "give it about one: {O: 0.289}")
            ((name, each),) = entry.value.items()
            distance = float(np.linalg.norm((self._place(replace(each, value=name)) - centre)[[0, 2]]))
            about = self.numbers.number(each)
            if about <= mass * distance**2:
                problem = f"{about:.6g} kg m2 about {name} is less than m d2 = {mass * distance**2:.6g} kg m2 of its mass alone"
                each.refuse(problem, f"give it in kg m2; if it is about the centre of mass write inertia: {about:.6g}")
            return _about_normal(about - mass * distance**2)
        value = self.numbers.above_zero(entry, "a moment of inertia")
        if any(self.reader.pins[name].in_space for name in self.pins):
            entry.refuse("one moment of inertia of a link in space", "give three: [Ixx, Iyy, Izz]")
        return _about_normal(value)

    def _of_solid(self, kind: str) -> _Body:
        """A prism between the first two pins, a box or a disc."""
        centre = self._place(self.items["com"]) if "com" in self.items else None
        density = self.reader.density_of(self.items, self.reader.density)
        if kind == "section":
            height, width = self._lengths(self.items[kind], "section: height x width", 2)
            self.section = CrossSection(height, width, density)
            solid = self._prism(self.section)
        else:
            solid = self._solid(kind, self.items, self.points[0] if centre is None else centre)
        if "mass" in self.items:
            mass = self.numbers.above_zero(self.items["mass"], "a mass")
            self._doubt_mass(mass, solid.volume)
            self._doubt_density(self.items)
            if not self.inertia_given:
                self.estimates.append(f"moments of inertia of its {kind}, with the mass that is given")
        else:
            mass = density * solid.volume
            if self.inertia_given:
                self.estimates.append(f"mass of its {kind} of {density:g} kg/m3, {mass:.4g} kg; its moment of inertia is given")
        if not self.inertia_given and centre is not None and kind == "section":
            self.estimates.append("moments of inertia of its section about its middle, taken about com")
        centre = solid.centre if centre is None else centre
        return _Body(mass, centre, self._inertia(mass, centre) if self.inertia_given else solid.inertia(mass))

    def _doubt_mass(self, mass: float, volume: float) -> None:
        """Warn of a mass that is probably not in kg; the link fills at most this volume [m3]."""
        if mass > DENSEST * volume:
            self.items["mass"].doubt(
                f"{mass:.6g} kg in {volume:.3g} m3: no material is that dense. Write kg, and check that units is the drawing's unit"
            )

    def _doubt_density(self, items: Mapping[str, Entry]) -> None:
        """Warn of a density that has no effect."""
        if "density" in items:
            items["density"].doubt("density has no effect, because the mass is given: leave out one of them")

    def _prism(self, section: CrossSection) -> _Solid:
        if len(self.points) < 2:
            self.items["section"].refuse("a section of a link with one pin", "give box or disc, or another pin")
        start, end = self.points[:2]
        length = float(np.linalg.norm(end - start))
        if not length > 0:
            self.items["pins"].refuse(f"{self.pins[0]} and {self.pins[1]} are one point: a rod of length zero", "move one")
        whole = length + 2 * self.numbers.length(self.items["overhang"]) if "overhang" in self.items else length
        if whole <= 0:
            self.items["overhang"].refuse("nothing is left of the link", "write a larger overhang")
        return _box((whole, section.width, section.height), (start + end) / 2, axes_along(end - start))

    def _solid(self, kind: str, items: Mapping[str, Entry], centre: Array) -> _Solid:
        if kind == "box":
            return _box(self._lengths(items["box"], "box: length x width x height", 3), centre, self.rotation)
        radius, thickness = self._lengths(items["disc"], "disc: radius x thickness", 2)
        across = (3 * radius**2 + thickness**2) / 12  # it turns about y
        return _Solid(float(np.pi * radius**2 * thickness), centre, self.rotation, np.array([across, radius**2 / 2, across]))

    def _part(self, entry: Entry) -> _Body:
        """A body that is welded on: a point mass, a disc or a box."""
        items = entry.known(PART_KEYS, "a part")
        kinds = [key for key in ("disc", "box") if key in items]
        if len(kinds) > 1 or not (kinds or "mass" in items):
            entry.refuse("a part without mass" if not kinds else "a disc and a box", "give mass, disc or box")
        centre = self._place(items["at"]) if "at" in items else self.points[0]
        mass = self.numbers.above_zero(items["mass"], "a mass") if "mass" in items else 0.0
        inertia = np.zeros((3, 3))
        if kinds:
            solid = self._solid(kinds[0], items, centre)
            mass = mass or self.reader.density_of(items, self.reader.density) * solid.volume
            inertia = solid.inertia(mass)
        if "mass" in items:
            self._doubt_density(items)
        if "inertia" in items:
            inertia = self._given_inertia(items["inertia"], mass, centre)
        return _Body(mass, centre, inertia)

    def _place(self, entry: Entry) -> Array:
        """World coordinates of a pin, or of a point in the link's coordinates."""
        return place_of(entry, self.reader.pins, self.numbers, self.points[0], self.rotation)

    def _length(self, entry: Entry, what: str) -> float:
        """A length above zero [m]."""
        return self.numbers.above_zero(entry, what) * self.numbers.unit

    def _lengths(self, entry: Entry, what: str, count: int) -> tuple[float, ...]:
        """Lengths above zero, written with x between them or as a list [m]."""
        if isinstance(entry.value, tuple):
            parts: Sequence[Entry] = entry.value
        else:
            parts = [replace(entry, value=part) for part in re.split(r"\s+[x×]\s+|(?<=\d)[x×](?=\d)", entry.text(what))]
        if len(parts) != count:
            entry.refuse(f"{len(parts)} lengths", f"write {what}")
        return tuple(self._length(part, "a length") for part in parts)


def place_of(entry: Entry, pins: Mapping[str, Pin], numbers: Numbers, origin: Array, rotation: Array) -> Array:
    """Read a pin, or a point in a link's coordinates: world coordinates (3,) [m].

    Args:
        entry: name of the pin, or coordinates of the point.
        pins: pin name -> pin in its place.
        numbers: reads the table's numbers.
        origin: (3,) origin of the link's coordinates in the world [m].
        rotation: (3, 3) axes of the link in the world.

    Raises:
        PinTableError: there is no such pin, or the entry is not a point.
    """
    if isinstance(entry.value, str):
        name = entry.value.strip()
        if name not in pins:
            remedy = "name a pin or a point of `pins`, or give [x, z] from the first pin"
            entry.refuse(f"no pin {name}{suggestion(name, pins)}", remedy)
        return pins[name].point
    if isinstance(entry.value, Mapping):
        items = entry.known(("x", "y", "z"), "a point in space")
        own = np.array([numbers.length(items[key]) if key in items else 0.0 for key in "xyz"])
    else:
        values = entry.list("a pin, or [x, z] from the first pin")
        if len(values) != 2:
            entry.refuse(f"{len(values)} numbers found; a point is [x, z]", "write decimals after a point; in space {x: , y: , z: }")
        own = np.array([numbers.length(values[0]), 0.0, numbers.length(values[1])])
    return np.asarray(origin + rotation @ own)


def axes_along(way: Array) -> Array:
    """Axes (3, 3) with x along a direction. In the picture's plane, y is the world's y and z is to the left of x."""
    x = way / np.linalg.norm(way)
    y = np.array([0.0, 1.0, 0.0]) - x[1] * x
    if np.linalg.norm(y) < 1e-9:  # along y: x and z then are the world's z and x
        return np.stack([x, [0.0, 0.0, 1.0], np.cross(x, [0.0, 0.0, 1.0])], axis=1)
    y /= np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _apart(points: Sequence[Array]) -> list[Array]:
    """The points without duplicates."""
    size = float(np.ptp(points, axis=0).max())
    return [p for k, p in enumerate(points) if all(np.abs(p - other).max() > ALIKE * size for other in points[:k])]


def _about_normal(moment: float) -> Array:
    """Moments of inertia of a link of which only the one about the picture's normal has an effect."""
    return moment * np.diag([0.5, 1.0, 0.5])


def _box(size: Sequence[float], centre: Array, axes: Array) -> _Solid:
    """A box with these lengths along its axes [m]."""
    squares = np.square(size)
    return _Solid(float(np.prod(size)), centre, axes, (squares.sum() - squares) / 12)
