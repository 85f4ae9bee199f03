"""Sketch pin tables as SVG: links, pins and dimensions of the drawn pose, or lengths that do not meet."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ..common.outlets.labels import Labels
from ..common.quantities import Array
from ..linkage.skeleton import PitchCircle
from .copies import Parts
from .links import Link
from .placement import Pin, UnreachableError

WIDTH, HEIGHT, MARGIN = 900.0, 700.0, 90.0  # of the picture
COLOURS = ("#a8330f", "#1454c9", "#0f6b42", "#8a5200", "#75448c", "#0b6a7d", "#a3356b", "#6b4226")  # as text 4.5 : 1 and more
INK, PALE, WRONG = "#30363d", "#9aa2ab", "#b03a22"
NORMAL, SMALL = 14.0, 12.0  # sizes of letters [pixels]
BESIDE = (24.0, -24.0, 40.0, -40.0, 56.0, -56.0)  # distances of a dimension line from its pins, in the order tried [pixels]
CLASS = "pinpress-sketch"  # a drawing's styles apply to its whole page, for example a notebook, so they need this class
TEXT = "font:14px sans-serif;fill:#30363d;paint-order:stroke;stroke:#fff;stroke-width:4px"
STYLE = f".{CLASS} text{{{TEXT}}}.{CLASS} .dimension{{font-size:12px;fill:#4a525b}}"


def sketch_of_parts(name: str, parts: Parts, unit: float, unit_name: str, circles: Sequence[PitchCircle] = ()) -> str:
    """Draw the drawn pose of a press: links as bars and plates, pins with their names, lengths in the table's unit; and the pitch
    ``circles`` that lie in the plane of the sketch."""
    flat = [circle for circle in circles if abs(circle.axis[1]) > 1 - 1e-9]
    ways = np.array([[1, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 0, -1]])
    spread = [pin.point for pin in parts.pins.values()]
    spread += [circle.centre + circle.radius * way for circle in flat for way in ways]
    sheet = _Sheet([point[[0, 2]] for point in spread], f"{name}: drawn pose, lengths in {unit_name}")
    colours = {link.name: COLOURS[k % len(COLOURS)] for k, link in enumerate(parts.links)}
    for circle in flat:
        sheet.circle(circle.centre[[0, 2]], circle.radius, "", colours.get(circle.link, INK), "12 4 3 4")
    for k, link in enumerate(parts.links):
        sheet.link(link, parts.pins, COLOURS[k % len(COLOURS)])
    sheet.pins(parts.pins.values(), parts.frame)
    for link in parts.links:
        sheet.dimensions(link, parts.pins, unit)
    for k, link in enumerate(parts.links):
        sheet.name(link, parts.pins, COLOURS[k % len(COLOURS)])
    return sheet.text()


def sketch_of_failure(error: UnreachableError, unit: float, unit_name: str) -> str:
    """Draw the pins that are placed already, with the circles and the line that do not meet."""
    spread = [pin.point[[0, 2]] for pin in error.pins]
    for centre, radius in error.circles:
        spread += [centre + radius * np.array([x, z]) for x, z in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    if error.along is not None:
        point, way = error.along
        spread += [point + way * ((centre - point) @ way) for centre, _ in error.circles]
    sheet = _Sheet(spread, f"{error.element}: {error.problem} (lengths in {unit_name})")
    for centre, radius in error.circles:
        sheet.circle(centre, radius, f"{radius / unit:.6g}")
    if error.along is not None:
        sheet.line(*error.along)
    sheet.pins(error.pins, ())
    return sheet.text()


class _Sheet:
    def __init__(self, points: Iterable[Array], title: str) -> None:
        every = np.array(list(points)) if points else np.zeros((1, 2))
        low, high = every.min(axis=0), every.max(axis=0)
        span = np.maximum(high - low, 1e-3 * max(float((high - low).max()), 1e-9))
        self.scale = float(min((WIDTH - 2 * MARGIN) / span[0], (HEIGHT - 2 * MARGIN) / span[1]))
        self.middle, self.labels = (low + high) / 2, Labels((WIDTH, HEIGHT))
        self.written: list[tuple[Array, str, str | None, str]] = []  # words with their points, until all lines are drawn
        size = {"viewBox": f"0 0 {WIDTH:g} {HEIGHT:g}", "width": f"{WIDTH:g}", "height": f"{HEIGHT:g}"}
        self.root = Element("svg", {"xmlns": "http://www.w3.org/2000/svg", **size, "class": CLASS, "role": "img", "aria-label": title})
        SubElement(self.root, "style").text = STYLE
        SubElement(self.root, "rect", {"width": "100%", "height": "100%", "fill": "#fff"})
        SubElement(self.root, "text", {"x": f"{WIDTH / 2:g}", "y": "30", "text-anchor": "middle"}).text = title
        self.labels.line(np.array([[0.0, 25.0], [WIDTH, 25.0]]), 8.0)

    def at(self, point: Array) -> tuple[float, float]:
        """Sheet coordinates of a point in the picture's plane."""
        x, z = (point - self.middle) * self.scale
        return WIDTH / 2 + float(x), HEIGHT / 2 - float(z)

    def link(self, link: Link, pins: Mapping[str, Pin], colour: str) -> None:
        """Draw a link as a bar or a plate, and a sliding link as a block across its guide."""
        corners = [self.at(pins[name].point[[0, 2]]) for name in link.pins]
        shape = {"fill": colour, "fill-opacity": "0.25", "stroke": colour, "stroke-width": "7"}
        shape |= {"stroke-linejoin": "round", "stroke-linecap": "round"}
        if len(corners) > 1:
            kind = "polygon" if len(corners) > 2 else "polyline"
            SubElement(self.root, kind, {"points": " ".join(f"{x:.1f},{y:.1f}" for x, y in corners), **shape})
            self.labels.line(np.array([*corners, corners[0]]), 3.5)
        if link.guide is not None:
            self._block(link, pins, colour)
        elif len(corners) == 1:
            x, y = corners[0]
            SubElement(self.root, "circle", {"cx": f"{x:.1f}", "cy": f"{y:.1f}", "r": "20", **shape})
            self.labels.circle(np.array([x, y]), 20.0)

    def name(self, link: Link, pins: Mapping[str, Pin], colour: str) -> None:
        """Write the name of a link next to the middle of its pins."""
        middle = np.mean([pins[name].point[[0, 2]] for name in link.pins], axis=0)
        self.written.append((np.array(self.at(middle)), link.name, colour, ""))

    def dimensions(self, link: Link, pins: Mapping[str, Pin], unit: float) -> None:
        """Draw lengths from a link's first pin to its other pins, and the lengths between other pins that the table gives."""
        first, *others = link.pins
        given = [(start, end) for end in others for start, _ in pins[end].lengths if start in others]
        shown = set[tuple[tuple[float, ...], ...]]()
        for start, end in (*((first, other) for other in others), *given):
            a, b = (pins[name].point for name in (start, end))
            ends = tuple(sorted((tuple(a.tolist()), tuple(b.tolist()))))
            length = float(np.linalg.norm(b - a))
            if length > 0 and ends not in shown:
                shown.add(ends)
                self._dimension(np.array(self.at(a[[0, 2]])), np.array(self.at(b[[0, 2]])), f"{length / unit:.6g}")

    def pins(self, pins: Iterable[Pin], frame: Sequence[str]) -> None:
        """Draw pins with their names and the supports of the frame's pins. Pins at one point share a circle."""
        places: dict[tuple[float, float], list[str]] = {}
        for pin in pins:
            x, y = self.at(pin.point[[0, 2]])
            places.setdefault((round(x, 1), round(y, 1)), []).append(pin.name)
        look = {"fill": "#fff", "stroke": INK, "stroke-width": "2"}
        for (x, y), names in places.items():
            if any(name in frame for name in names):
                SubElement(self.root, "path", {"d": f"M{x:.1f},{y:.1f} l-13,20 h26 z M{x - 16:.1f},{y + 20:.1f} h32", **look})
                self.labels.line(np.array([[x, y], [x - 16, y + 20], [x + 16, y + 20], [x, y]]), 1.0)
            SubElement(self.root, "circle", {"cx": f"{x:.1f}", "cy": f"{y:.1f}", "r": "6", **look})
            self.labels.circle(np.array([x, y]), 6.0)
            self.written.insert(0, (np.array([x, y]), ", ".join(names), None, ""))

    def circle(self, centre: Array, radius: float, words: str, colour: str = WRONG, dashes: str = "") -> None:
        """A circle about a pin, with words above it."""
        (x, y), size = self.at(centre), radius * self.scale
        circle = {"cx": f"{x:.1f}", "cy": f"{y:.1f}", "r": f"{size:.1f}"}
        dashed = {"stroke-dasharray": dashes} if dashes else {}
        SubElement(self.root, "circle", {**circle, "fill": "none", "stroke": colour, "stroke-width": "2", **dashed})
        self.labels.circle(np.array([x, y]), size)
        if words:
            self.written.append((np.array([x, y - size]), words, colour, ""))

    def line(self, point: Array, way: Array) -> None:
        """A straight line across the sheet."""
        far = (WIDTH + HEIGHT) / self.scale
        (x1, y1), (x2, y2) = self.at(point - far * way), self.at(point + far * way)
        ends = {"x1": f"{x1:.1f}", "y1": f"{y1:.1f}", "x2": f"{x2:.1f}", "y2": f"{y2:.1f}"}
        SubElement(self.root, "line", {**ends, "stroke": WRONG, "stroke-width": "2", "stroke-dasharray": "12 6"})
        self.labels.line(np.array([[x1, y1], [x2, y2]]), 1.0)

    def text(self) -> str:
        """The sheet as SVG, with its words where they cover nothing."""
        for point, words, colour, kind in self.written:
            (x, y), end = self.labels.place(point, words, SMALL if kind else NORMAL)
            if end is not None:
                self._thin(point, end)
            look = ({"class": kind} if kind else {}) | ({"style": f"fill:{colour}"} if colour else {})
            SubElement(self.root, "text", {"x": f"{x:.1f}", "y": f"{y:.1f}", **look}).text = words
        return ElementTree.tostring(self.root, encoding="unicode")

    def _block(self, link: Link, pins: Mapping[str, Pin], colour: str) -> None:
        """Draw a sliding link: a block between two rails along its guide."""
        assert link.guide is not None
        x, y = self.at(np.mean([pins[name].point[[0, 2]] for name in link.pins], axis=0))
        way = link.guide.direction[[0, 2]]
        angle = math.degrees(math.atan2(-way[1], way[0]))
        turn = {"transform": f"rotate({angle:.2f} {x:.1f} {y:.1f})"}
        for side in (-19, 19):
            ends = {"x1": f"{x - 46:.1f}", "x2": f"{x + 46:.1f}", "y1": f"{y + side:.1f}", "y2": f"{y + side:.1f}"}
            SubElement(self.root, "line", {**ends, **turn, "stroke": PALE, "stroke-width": "4"})
            self.labels.line(self._turned(x, y, angle, ((-46, side), (46, side))), 2.0)
        box = {"x": f"{x - 26:.1f}", "y": f"{y - 16:.1f}", "width": "52", "height": "32", "rx": "3"}
        SubElement(self.root, "rect", {**box, **turn, "fill": colour, "fill-opacity": "0.35", "stroke": colour, "stroke-width": "3"})

        self.labels.line(self._turned(x, y, angle, ((-26, -16), (26, -16), (26, 16), (-26, 16), (-26, -16))), 1.5)

    def _turned(self, x: float, y: float, angle: float, corners: Sequence[tuple[float, float]]) -> Array:
        """Corners about a point, turned by an angle [deg], on the sheet."""
        cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        return np.asarray(np.array(corners) @ np.array([[cos, sin], [-sin, cos]]) + [x, y])

    def _dimension(self, begin: Array, end: Array, words: str) -> None:
        """A line beside a length with its ends marked, where it crosses least; a short length has its words alone."""
        along = end - begin
        length = float(np.linalg.norm(along))
        middle = (begin + end) / 2
        if length > 40.0:  # pixels: a shorter one would be hidden by its marks
            across = np.array([along[1], -along[0]]) / length
            best = min(BESIDE, key=lambda away: self.labels.crossed(begin + away * across, end + away * across))
            a, b = begin + best * across, end + best * across
            self._thin(a, b)
            for corner, place in ((begin, a), (end, b)):
                self._thin(corner + 0.35 * (place - corner), place + math.copysign(4.0, best) * across)
            middle = (a + b) / 2
        self.written.append((middle, words, None, "dimension"))

    def _thin(self, begin: Array, end: Array) -> None:
        """A thin line of a dimension, or to words that stand apart."""
        ends = {"x1": f"{begin[0]:.1f}", "y1": f"{begin[1]:.1f}", "x2": f"{end[0]:.1f}", "y2": f"{end[1]:.1f}"}
        SubElement(self.root, "line", {**ends, "stroke": INK, "stroke-opacity": "0.6", "stroke-width": "1"})
        self.labels.line(np.array([begin, end]), 0.5)
