"""The solids that links are drawn with."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.frozen import read_only
from ...common.quantities import Array


@dataclass(frozen=True)
class Box:
    """A box about its own origin.

    Attributes:
        size: along x, y, z [m].
    """

    size: tuple[float, float, float]


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about its own origin, along z.

    Attributes:
        radius: [m].
        length: [m].
    """

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere about its own origin.

    Attributes:
        radius: [m].
    """

    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """Triangles. Arrays are read-only.

    Attributes:
        vertices: (n, 3) [m].
        faces: (m, 3) indices of the vertices at their corners, anticlockwise seen from outside.
    """

    vertices: Array
    faces: NDArray[np.int64]

    def __repr__(self) -> str:
        return f"<Mesh: {len(self.vertices)} vertices, {len(self.faces)} faces>"


Shape = Box | Cylinder | Sphere | Mesh


@dataclass(frozen=True, eq=False)
class Part:
    """A solid on a link, in a colour. Arrays are read-only.

    Attributes:
        shape: of the solid.
        placement: (4, 4) of the solid in the link's frame [m].
        rgba: (4,) red, green, blue and opacity, from 0 to 1.
    """

    shape: Shape
    placement: Array
    rgba: Array


def part(shape: Shape, placement: Array, rgba: Array | tuple[float, ...]) -> Part:
    """A part with arrays of its own."""
    return Part(shape, read_only(np.array(placement, dtype=float)), read_only(np.array(rgba, dtype=float)))


@dataclass(frozen=True, eq=False)
class Solid:
    """A solid of a link that is made up, in world axes in the drawn pose.

    Attributes:
        shape: of the solid.
        placement: (4, 4) of the solid [m].
        steel: whether it is a pin, in the colour of pins, not of the link.
    """

    shape: Shape
    placement: Array
    steel: bool = False
