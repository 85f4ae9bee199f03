"""A frame of beams: bed, columns and crown as welded boxes, for a press without a finite-element model.

The beams are Timoshenko beams in space: they stretch, twist, bend in two planes and deform in shear, which matters for short and high
parts. Stiffness and mass matrix of an element are consistent, with rotary inertia (Przemieniecki, Theory of Matrix Structural Analysis,
1968, chapters 5.6 and 11.7). With P = 12 E I / (G A_s l^2) a beam of length l bends with

    E I / ((1 + P) l^3) [12, 6 l, -12, 6 l; 6 l, (4 + P) l^2, -6 l, (2 - P) l^2; ...]

The torsion constant of a hollow box is that of a thin closed tube, 4 A_m^2 t / circumference (Bredt); that of a solid box follows from the
torsion function of a rectangle (Roark).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import numbers, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import Array
from ..loads.mounts import Vector
from .elastic_frame import WHOLE, ElasticFrame, reduced_frame
from .frame_parts import direction


@dataclass(frozen=True)
class FrameBeam(Checked):
    """A straight beam of a frame. Its section is a box, hollow or solid.

    Attributes:
        start: name of the place at which the beam begins.
        end: name of the place at which the beam ends.
        width: outer width of the section, along ``across`` [m].
        height: outer height of the section, perpendicular to beam and width [m].
        across: (3,) direction of the width in world axes; its component along the beam is ignored [-].
        wall: thickness of the wall; None: the box is solid [m].
        modulus: modulus of elasticity [Pa].
        shear_modulus: shear modulus [Pa].
        density: density, including ribs and other masses that are spread along the beam [kg/m3].

    Raises:
        PinpressError: a number is not positive, or the walls are thicker than the box.
    """

    start: str
    end: str
    width: float = field(metadata=parameter("m", "positive"))
    height: float = field(metadata=parameter("m", "positive"))
    across: Vector = field(metadata=parameter("-", axes=1))
    wall: float | None = field(default=None, metadata=parameter("m", "positive"))
    modulus: float = field(default=2.1e11, metadata=parameter("Pa", "positive"))
    shear_modulus: float = field(default=8.1e10, metadata=parameter("Pa", "positive"))
    density: float = field(default=7850.0, metadata=parameter("kg/m3", "positive"))

    def __post_init__(self) -> None:
        super().__post_init__()
        for end in (self.start, self.end):
            if not isinstance(end, str):
                raise PinpressError(f"FrameBeam: it joins {shown(self.start)} and {shown(self.end)}: give names of places")
        if self.wall is not None and 2 * self.wall >= min(self.width, self.height):
            raise PinpressError(f"FrameBeam: a wall of {self.wall:g} m fills the box: leave wall= out for a solid box")
        set_field(self, "across", direction("FrameBeam: across", self.across))

    @property
    def area(self) -> float:
        """Area of the section [m2]."""
        width, height = self._hollow
        return self.width * self.height - width * height

    @property
    def second_moments(self) -> tuple[float, float]:
        """(2,) second moments of area for bending along the height, and along the width [m4]."""
        width, height = self._hollow
        return (
            (self.width * self.height**3 - width * height**3) / 12,
            (self.height * self.width**3 - height * width**3) / 12,
        )

    @property
    def shear_areas(self) -> tuple[float, float]:
        """(2,) shear areas for shear along the height, and along the width [m2]."""
        if self.wall is None:
            return 5 / 6 * self.area, 5 / 6 * self.area
        return 2 * self.wall * (self.height - self.wall), 2 * self.wall * (self.width - self.wall)

    @property
    def torsion_constant(self) -> float:
        """Torsion constant of the section [m4]."""
        if self.wall is not None:
            width, height = self.width - self.wall, self.height - self.wall
            return 2 * self.wall * (width * height) ** 2 / (width + height)
        long, short = max(self.width, self.height), min(self.width, self.height)
        return long * short**3 * (1 / 3 - 0.21 * short / long * (1 - short**4 / (12 * long**4)))

    @property
    def _hollow(self) -> tuple[float, float]:
        return (0.0, 0.0) if self.wall is None else (self.width - 2 * self.wall, self.height - 2 * self.wall)


@typed
def beam_frame(
    places: Mapping[str, ArrayLike],
    beams: Sequence[FrameBeam],
    *,
    bed: str,
    carrier: str,
    bearings: Mapping[str, str] | None = None,
    elements: int = 8,
    modes: int = 20,
    loss_factor: float = 0.0,
) -> ElasticFrame:
    """Make a frame of beams that are welded together at named places. All places are interfaces.

    Parts that add mass but do not bend, such as flywheel, motor and bolster, are `Attachment`s at the places.

    Args:
        places: name -> (3,) place at which beams meet or a part is attached, in world axes [m].
        beams: beams between these places.
        bed: name of the place on which the loads on the frame act.
        carrier: name of the place that carries crank and guides, and the mass of the links.
        bearings: name of a bearing or guide of the press on the frame -> name of the place that carries it instead; None: all on
            ``carrier``.
        elements: number of finite elements of each beam, 1 to 50.
        modes: number of vibration modes with fixed places that are kept.
        loss_factor: loss factor of the frame's material and joints [-].

    Raises:
        UnknownNameError: a beam, the bed, the carrier or a bearing names an unknown place.
        PinpressError: a place is not a point, two places coincide, a beam has no length or a width along its axis, or the beams are not
            connected.
    """
    count = whole_number("elements", elements, 1, 50)
    points = _points(places)
    if not isinstance(beams, Sequence) or not beams or not all(isinstance(beam, FrameBeam) for beam in beams):
        raise PinpressError(f"beams is {shown(beams)}: give a list of FrameBeam, at least one")
    number_of = {name: k for k, name in enumerate(points)}
    nodes, lines, parts = list(points.values()), [], []
    for beam in beams:
        for name in (beam.start, beam.end):
            if name not in points:
                raise UnknownNameError("place", name, points)
        axes, length = _axes(beam, points[beam.end] - points[beam.start])
        chain = [number_of[beam.start], *range(len(nodes), len(nodes) + count - 1), number_of[beam.end]]
        nodes += [points[beam.start] + share * (points[beam.end] - points[beam.start]) for share in np.arange(1, count) / count]
        lines += list(pairwise(chain))
        parts.append((chain, axes, _element(beam, length / count)))
    if loose := [name for name in points if not any(name in (beam.start, beam.end) for beam in beams)]:
        raise PinpressError(f"no beam reaches {', '.join(loose)}: join it, or leave it out")
    matrices = np.zeros((2, 6 * len(nodes), 6 * len(nodes)))
    for chain, axes, element in parts:
        turned = np.kron(np.eye(4), axes)  # rotation from world axes to the axes of the beam, as rows
        in_world = turned.T @ element @ turned
        for one, two in pairwise(chain):
            rows = np.r_[6 * one : 6 * one + 6, 6 * two : 6 * two + 6]
            matrices[:, rows[:, None], rows] += in_world
    degrees = np.stack([np.repeat(np.arange(len(nodes)), 6), np.tile(np.arange(6), len(nodes))], axis=1)
    return reduced_frame(
        matrices[0],
        matrices[1],
        nodes=np.array(nodes),
        degrees=degrees,
        interfaces=number_of,
        bed=bed,
        carrier=carrier,
        bearings=bearings,
        modes=modes,
        loss_factor=loss_factor,
        lines=np.array(lines),
    )


def _points(places: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """Places (3,) by name; raises PinpressError as `beam_frame`."""
    if not isinstance(places, Mapping) or len(places) < 2:
        raise PinpressError(f"places is {shown(places)}: give a mapping, name of each place: (x, y, z), at least two")
    points: dict[str, Array] = {}
    for name, given in places.items():
        if not isinstance(name, str) or name == WHOLE:
            raise PinpressError(f"place {shown(name)}: give it another name; {WHOLE!r} is the mean motion of the frame")
        point = numbers(f"place {shown(name)}", given, (3,), unit="m")
        if same := [other for other, there in points.items() if np.array_equal(there, point)]:
            raise PinpressError(f"places {shown(same[0])} and {shown(name)} are one: name it once")
        points[name] = point
    return points


def _axes(beam: FrameBeam, along: Array) -> tuple[Array, float]:
    """(3, 3) directions of the beam, its width and its height as rows, and its length; raises PinpressError as `beam_frame`."""
    length = float(np.linalg.norm(along))
    if length == 0:
        raise PinpressError(f"the beam from {beam.start} to {beam.end} has no length: give two places")
    first, across = along / length, np.array(beam.across)
    aside = across - (across @ first) * first
    # the sine of the angle between the beam and the direction of its width
    if np.linalg.norm(aside) < 1e-3:
        raise PinpressError(f"the width of the beam from {beam.start} to {beam.end} lies along it: give another across=")
    second = aside / np.linalg.norm(aside)
    return np.array([first, second, np.cross(first, second)]), length


def _element(beam: FrameBeam, h: float) -> Array:
    """(2, 12, 12) mass and stiffness matrix of an element of length h, in the beam's axes: displacements and rotations of both ends."""
    matrices = np.zeros((2, 12, 12))
    line, mass = np.array([[1.0, -1.0], [-1.0, 1.0]]), beam.density * np.array([[2.0, 1.0], [1.0, 2.0]]) * h / 6
    moments = beam.second_moments
    matrices[:, [[0], [6]], [0, 6]] += mass * beam.area, line * beam.modulus * beam.area / h
    matrices[:, [[3], [9]], [3, 9]] += mass * sum(moments), line * beam.shear_modulus * beam.torsion_constant / h
    # a positive rotation about the second axis has a negative slope along the height (third axis); the slope along the width has the other
    # sign
    for rows, turn, moment, sheared in (((2, 4, 8, 10), -1.0, moments[0], 0), ((1, 5, 7, 11), 1.0, moments[1], 1)):
        sign = np.array([1.0, turn, 1.0, turn])
        ratio = 12 * beam.modulus * moment / (beam.shear_modulus * beam.shear_areas[sheared] * h * h)
        bent = _bending(beam.density * beam.area, beam.density * moment, beam.modulus * moment, h, ratio)
        matrices[:, np.array(rows)[:, None], rows] += bent * np.outer(sign, sign)
    return matrices


def _bending(mass: float, rotary: float, stiffness: float, h: float, ratio: float) -> Array:
    """(2, 4, 4) mass and stiffness matrix of bending in a plane; the coordinates are displacement and slope at both ends.

    Args:
        mass: mass per length [kg/m].
        rotary: rotary inertia per length [kg m].
        stiffness: bending stiffness [N m2].
        h: length of the element [m].
        ratio: P of the module's docstring.
    """
    p, p2 = ratio, ratio * ratio
    stiff = [
        [12, 6 * h, -12, 6 * h],
        [6 * h, (4 + p) * h * h, -6 * h, (2 - p) * h * h],
        [-12, -6 * h, 12, -6 * h],
        [6 * h, (2 - p) * h * h, -6 * h, (4 + p) * h * h],
    ]
    a, b = 13 / 35 + 7 * p / 10 + p2 / 3, 9 / 70 + 3 * p / 10 + p2 / 6
    c, d = (11 / 210 + 11 * p / 120 + p2 / 24) * h, (13 / 420 + 3 * p / 40 + p2 / 24) * h
    e, f = (1 / 105 + p / 60 + p2 / 120) * h * h, -(1 / 140 + p / 60 + p2 / 120) * h * h
    moved = [[a, c, b, -d], [c, e, d, f], [b, d, a, -c], [-d, f, -c, e]]
    i, j = 6 / 5, (1 / 10 - p / 2) * h
    k, m = (2 / 15 + p / 6 + p2 / 3) * h * h, (-1 / 30 - p / 6 + p2 / 6) * h * h
    turned = [[i, j, -i, j], [j, k, -j, m], [-i, -j, i, -j], [j, m, -j, k]]
    both = mass * h * np.array(moved) + rotary / h * np.array(turned)
    return np.array([both / (1 + p) ** 2, stiffness / ((1 + p) * h**3) * np.array(stiff)])
