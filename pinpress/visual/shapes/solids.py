"""The solids of drawn links: boxes, cylinders, spheres, plates, and triangles from the mesh files that a URDF names.

Assimp, the library within Coal that reads mesh files, is not safe with every file. It follows references between files, and between the
parts of a file, without a limit, and crashes the process if they are too deep. It allocates vertices up to the largest index in the file.
Its run time is quadratic in the number of groups and in the corners of a polygon. So a file is first checked and reduced to its triangles.
Materials, controllers and animations are not shown, so Assimp does not get them.
"""

import itertools
import math
import os
import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common import files
from ...common.errors import PinpressError, UrdfError
from ...common.frozen import read_only
from ...common.quantities import Array
from ...linkage.element import Element, tree

KINDS = "STL (.stl), Wavefront (.obj) or COLLADA (.dae)"
MOST_TRIANGLES = 500_000  # a browser can barely open a page with more
MOST_CORNERS = 1000  # corners of one polygon
MOST_NODES = 10_000  # nodes of a COLLADA scene, every instance counted
DEEPEST_NODES = 200

CORNERS = 48  # corners of the outline of a rounded plate

_LINE = re.compile(rb"^[ \t]*(v|vt|vn|f)[ \t]([^\r\n]*)", re.MULTILINE)  # lines of a Wavefront file that define triangles
_INDICES = re.compile(rb"<(?:p|v|vcount)\b[^>]*>([^<]*)<|(?:count|offset|stride)\s*=\s*[\"']([^\"']*)")
_SHOWN = ("asset", "library_geometries", "library_nodes", "library_visual_scenes", "scene")  # the elements of a COLLADA file that are read
_FACES = ("triangles", "tristrips", "trifans", "polylist", "polygons")


@dataclass(frozen=True)
class Box:
    """A box about its own origin.

    Attributes:
        size: lengths along x, y, z [m].
    """

    size: tuple[float, float, float]


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about its own origin, along z.

    Attributes:
        radius: radius [m].
        length: length [m].
    """

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere about its own origin.

    Attributes:
        radius: radius [m].
    """

    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class TriangleMesh:
    """Triangles. Arrays are read-only.

    Attributes:
        vertices: (n, 3) places of the vertices [m].
        faces: (m, 3) indices of the vertices at the corners of each triangle, anticlockwise seen from outside.
    """

    vertices: Array
    faces: NDArray[np.int64]

    def __repr__(self) -> str:
        return f"<TriangleMesh: {len(self.vertices)} vertices, {len(self.faces)} faces>"


@dataclass(frozen=True, eq=False, repr=False)
class Plate:
    """A plate with a convex outline about its own origin, across z. Arrays are read-only.

    Attributes:
        outline: (n, 2) corners in x and y, anticlockwise [m].
        thickness: from -thickness / 2 to thickness / 2 along z [m].
    """

    outline: Array
    thickness: float

    def __repr__(self) -> str:
        return f"<Plate: {len(self.outline)} corners, {self.thickness:g} m thick>"

    @cached_property
    def area(self) -> tuple[float, Array]:
        """Area [m2] and its centre (2,) [m]."""
        corners, following = self.outline, np.roll(self.outline, -1, axis=0)
        twice = corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]  # twice the areas of the triangles with the origin
        return float(twice.sum() / 2), np.asarray(twice @ (corners + following) / (3 * twice.sum()))

    def mesh(self) -> TriangleMesh:
        """The triangles of the plate; both faces are triangle fans."""
        n = len(self.outline)
        vertices = np.vstack([np.column_stack([self.outline, np.full(n, z * self.thickness)]) for z in (-0.5, 0.5)])
        k = np.arange(n)
        after = (k + 1) % n
        sides = np.vstack([np.column_stack([k, after, after + n]), np.column_stack([k, after + n, k + n])])
        fan = np.column_stack([np.zeros(n - 2, dtype=int), k[1:-1], k[2:]])
        return TriangleMesh(read_only(vertices), read_only(np.vstack([sides, fan[:, ::-1], fan + n]).astype(np.int64)))

    def strips(self) -> list[tuple[Box, Array]]:
        """Twelve boxes side by side along x that fill the outline, each with its centre (2,) [m], for formats without plates."""
        (x1, y1), (x2, y2) = self.outline.T, np.roll(self.outline, -1, axis=0).T
        edges = np.linspace(y1.min(), y1.max(), 13)
        boxes = []
        for y in (edges[1:] + edges[:-1]) / 2:
            cut = (y1 < y) != (y2 < y)
            crossings = x1[cut] + (y - y1[cut]) / (y2[cut] - y1[cut]) * (x2[cut] - x1[cut])
            low, high = float(crossings.min()), float(crossings.max())
            boxes.append((Box((high - low, float(edges[1] - edges[0]), self.thickness)), np.array([(low + high) / 2, y])))
        return boxes


def rounded_plate(centres: Array, radii: Array, thickness: float) -> Plate:
    """The convex plate around circles.

    Args:
        centres: (k, 2) centres of the circles [m].
        radii: (k,) radii of the circles [m].
        thickness: thickness of the plate [m].
    """
    angle = 2 * np.pi * np.arange(CORNERS) / CORNERS
    outwards = np.column_stack([np.cos(angle), np.sin(angle)])
    outermost = np.argmax(outwards @ centres.T + radii, axis=1)
    return Plate(read_only(centres[outermost] + radii[outermost, None] * outwards), thickness)


def half_disc(radius: float, thickness: float) -> Plate:
    """Half a disc about its own origin, on the side of positive x."""
    angle = np.pi * (np.arange(CORNERS // 2 + 1) / (CORNERS // 2) - 0.5)
    return Plate(read_only(radius * np.column_stack([np.cos(angle), np.sin(angle)])), thickness)


Shape = Box | Cylinder | Sphere | Plate | TriangleMesh


def corners(shape: Shape) -> Array:
    """(8, 3) corners of the bounding box of a solid along its own axes [m]."""
    if isinstance(shape, Plate | TriangleMesh):
        vertices = (shape.mesh() if isinstance(shape, Plate) else shape).vertices
        low, high = vertices.min(axis=0), vertices.max(axis=0)
    else:
        if isinstance(shape, Box):
            size = np.array(shape.size)
        elif isinstance(shape, Cylinder):
            size = np.array([2 * shape.radius, 2 * shape.radius, shape.length])
        else:
            size = np.full(3, 2 * shape.radius)
        low, high = -size / 2, size / 2
    return np.array(list(itertools.product(*zip(low, high, strict=True))))


def volume_and_centre(shape: Shape) -> tuple[float, Array]:
    """Volume [m3] of a solid, and its centre (3,) about its own origin [m]."""
    if isinstance(shape, Box):
        return math.prod(shape.size), np.zeros(3)
    if isinstance(shape, Cylinder):
        return math.pi * shape.radius**2 * shape.length, np.zeros(3)
    if isinstance(shape, Sphere):
        return 4 / 3 * math.pi * shape.radius**3, np.zeros(3)
    if isinstance(shape, Plate):
        area, centre = shape.area
        return area * shape.thickness, np.array([*centre, 0.0])
    a, b, c = shape.vertices[shape.faces].transpose(1, 0, 2)
    six = np.sum(a * np.cross(b, c), axis=1)  # six times the volumes of the tetrahedra with the origin
    total = float(six.sum())
    if not total > 0:  # the mesh is not closed
        return 0.0, shape.vertices.mean(axis=0)
    return total / 6, six @ (a + b + c) / (4 * total)


@dataclass(frozen=True, eq=False)
class Part:
    """A solid of a link with its colour. Arrays are read-only.

    Attributes:
        shape: shape of the solid.
        placement: (4, 4) placement of the solid in the link's frame [m].
        rgba: (4,) red, green, blue and opacity, from 0 to 1.
    """

    shape: Shape
    placement: Array
    rgba: Array


def part(shape: Shape, placement: Array, rgba: Array | tuple[float, ...]) -> Part:
    """Make a part with copies of these arrays."""
    return Part(shape, read_only(np.array(placement, dtype=float)), read_only(np.array(rgba, dtype=float)))


@dataclass(frozen=True, eq=False)
class MadeUpSolid:
    """A made-up solid of a link, in world axes in the drawn pose.

    Attributes:
        shape: shape of the solid.
        placement: (4, 4) placement of the solid [m].
        steel: whether it is a pin, which has the colour of steel instead of the link's.
        darker: whether it is a counterweight, which has a darker shade of the link's colour.
    """

    shape: Shape
    placement: Array
    steel: bool = False
    darker: bool = False


def standing(shape: Shape, centre: Array, along: Array | None = None, *, steel: bool = False, darker: bool = False) -> MadeUpSolid:
    """A solid with its z axis along a direction."""
    placement = np.eye(4)
    placement[:3, 3] = centre
    if along is not None:
        z = along / np.linalg.norm(along)
        x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
        x /= np.linalg.norm(x)
        placement[:3, 0], placement[:3, 1], placement[:3, 2] = x, np.cross(z, x), z
    return MadeUpSolid(shape, placement, steel, darker)


def read_mesh(file: str, link: str, name: str, scale: tuple[float, ...]) -> TriangleMesh:
    """Read a mesh.

    A package is searched in ROS_PACKAGE_PATH, among the parent folders of the URDF, and in the folders next to them.

    Args:
        file: the URDF.
        link: link whose visual the mesh is.
        name: name of the mesh in the URDF: a path, which may be relative to the URDF, ``file://...`` or ``package://...``.
        scale: factors along x, y, z.

    Raises:
        PinpressError: the mesh is missing or cannot be read, has no triangles, or is flat or not finite after scaling.
    """
    place = f"link {link!r}: mesh {name!r}"
    factors = np.array(scale)
    if not factors.all():
        raise PinpressError(f"{place} has the scale {' '.join(map(str, scale))}, which makes it flat; give numbers other than 0")
    path = _located(file, name)
    if path is None:
        raise PinpressError(
            f"{place} is in an unknown package; put the folder of the package, or the one it is in, into ROS_PACKAGE_PATH, or give"
            " the mesh's path relative to the URDF"
        )
    if not os.path.exists(path) or os.path.isdir(path):
        raise PinpressError(f"{place}: there is no file {os.fspath(path)!r}; correct the path, or put the mesh there")
    try:
        content = files.read(path, 100_000_000)  # reading a mesh of this size takes half a gigabyte
    except (OSError, ValueError) as error:
        said = files.reason(error)
        raise PinpressError(f"{place} cannot be read: {said}; put a mesh file at {os.fspath(path)!r} that is readable") from error
    kind = path.suffix.lower()
    try:
        mesh = _loaded(kind, triangles_only(kind, content))
    except UnfitError as error:
        raise PinpressError(f"{place} {error}; give an intact file, {KINDS}") from error
    faces = np.array([[side[0], side[1], side[2]] for side in map(mesh.tri_indices, range(mesh.num_tris))], dtype=np.int64)
    with np.errstate(all="ignore"):  # values that are not finite are refused below
        vertices = np.array(mesh.vertices(), dtype=float) * factors
    if len(faces) == 0 or faces.max() >= len(vertices):
        raise PinpressError(f"{place} has no triangles, or some without corners; give an intact file, {KINDS}")
    if not np.isfinite(vertices).all():
        raise PinpressError(f"{place} has a vertex that is not finite; repair the mesh, or give a smaller scale")
    if np.prod(np.sign(factors)) < 0:
        faces = faces[:, ::-1].copy()  # a mirrored mesh would be inside out
    return TriangleMesh(read_only(vertices), read_only(faces))


def _loaded(kind: str, content: bytes) -> Any:
    """The unscaled mesh of a file's content. Raises UnfitError if it cannot be read."""
    import coal  # part of Pinocchio, but seldom needed

    with tempfile.TemporaryDirectory(prefix="pinpress-") as folder:
        file = Path(folder, f"mesh{kind}")
        file.write_bytes(content)
        try:
            return coal.MeshLoader().load(os.fspath(file), np.ones(3))  # unscaled, because a scale of any size is safe in our own code
        except Exception as error:
            raise UnfitError("cannot be read as triangles") from error


def _located(file: str, name: str) -> Path | None:
    """Path of a mesh; None if its package is not found."""
    folder = Path(file).resolve().parent
    if not name.startswith("package://"):
        return folder / re.sub("^file://", "", name)
    package, _, rest = name.removeprefix("package://").partition("/")
    for root in filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)):
        if Path(root).name == package and os.path.exists(Path(root) / rest):
            return Path(root) / rest
        if os.path.isdir(Path(root) / package):
            return Path(root) / package / rest
    for parent in (folder, *folder.parents):
        if parent.name == package:
            return parent / rest
        if os.path.isdir(parent / package):
            return parent / package / rest
    return None


class UnfitError(Exception):
    """A file does not have the format of its name, or is too large."""


def triangles_only(suffix: str, content: bytes) -> bytes:
    """Reduce the content of a mesh file to its triangles.

    Args:
        suffix: ".stl", ".obj" or ".dae".
        content: content of the file.

    Raises:
        UnfitError: the content has another format, is damaged or is too large.
    """
    readers = {".stl": _stl, ".obj": _wavefront, ".dae": _collada}
    if suffix not in readers:
        raise UnfitError(f"is of an unknown kind, {suffix!r}")
    return readers[suffix](content)


def _stl(content: bytes) -> bytes:
    triangles = int.from_bytes(content[80:84], "little")
    if not 0 < triangles <= (len(content) - 84) // 50:
        if content.lstrip()[:5].lower() != b"solid":
            raise UnfitError("is not an STL file, or one that ends early")
        triangles = content.count(b"facet") // 2  # "facet" and "endfacet"
    _check_number(triangles)
    return content


def _wavefront(content: bytes) -> bytes:
    if b"\0" in content:
        raise UnfitError("is not a Wavefront file")
    lines, triangles = [], 0
    for line in _LINE.finditer(re.sub(rb"\\\r?\n", b" ", content)):  # a backslash continues a line
        if line[1] == b"f":
            corners = len(line[2].split())
            _check_corners(corners)
            triangles += max(0, corners - 2)
        lines.append(line[0])
    _check_number(triangles)
    if not any(line.split(None, 1)[0] == b"v" for line in lines):
        raise UnfitError("is not a Wavefront file")
    return b"\n".join(lines) + b"\n"


def _collada(content: bytes) -> bytes:
    try:
        root = tree("", content)
    except UrdfError as error:
        raise UnfitError(f"is not a COLLADA file: {error.problem}") from error
    except ValueError as error:  # an attribute that is not text
        raise UnfitError("is not a COLLADA file") from error
    numbers = (number for match in _INDICES.finditer(content) for number in (match[1] or match[2] or b"").split())
    sound = all(re.fullmatch(rb"\d{1,12}", number) and int(number) <= len(content) for number in numbers)
    if root.tag != "COLLADA" or not root.children or not sound:
        raise UnfitError("is not a COLLADA file, or has a broken index")
    _check_scene(root, content)
    ends = [child.start for child in root.children[1:]] + [root.end]
    libraries = b"".join(content[child.start : end] for child, end in zip(root.children, ends, strict=True) if child.tag in _SHOWN)
    return content[: root.children[0].start] + libraries + content[root.end :]


def _check_scene(root: Element, content: bytes) -> None:
    """Refuse too many nodes, triangles or levels below the scenes; every instance of a node or geometry counts."""
    nodes = [element for element in _elements(root) if element.tag in ("node", "visual_scene")]
    geometries = {element.get("id"): _triangles(element, content) for element in _elements(root) if element.tag == "geometry"}
    libraries = set(root.all("library_nodes"))
    by_id: dict[str, list[Element]] = {}
    by_name: dict[str, list[Element]] = {}
    for node in nodes:
        if node.parent in libraries:
            by_id.setdefault(node.get("id"), []).append(node)
        for name in {node.get("id"), node.get("name"), node.get("sid")}:
            by_name.setdefault(name, []).append(node)

    def below(node: Element) -> list[Element]:
        names = [instance.get("url").removeprefix("#") for instance in node.all("instance_node")]
        return node.all("node") + [other for name in names for other in by_id.get(name) or by_name.get(name, [])]

    totals: dict[Element, tuple[int, int, int]] = {}

    def total(node: Element, above: int = 0) -> tuple[int, int, int]:
        """Number of nodes, triangles and levels from a node down."""
        if above >= DEEPEST_NODES:
            raise UnfitError(f"has nodes that refer to each other in a ring, or more than {DEEPEST_NODES} levels of them")
        if node not in totals:
            parts = [total(other, above + 1) for other in below(node)]
            instances = node.all("instance_geometry")
            own = sum(geometries.get(instance.get("url").removeprefix("#"), 0) for instance in instances)
            count, triangles = 1 + len(instances) + sum(part[0] for part in parts), own + sum(part[1] for part in parts)
            levels = 1 + max((part[2] for part in parts), default=0)
            if count > MOST_NODES:
                raise UnfitError(f"has more than {MOST_NODES} nodes, every instance counted")
            if levels > DEEPEST_NODES:
                raise UnfitError(f"has more than {DEEPEST_NODES} levels of nodes")
            _check_number(triangles)
            totals[node] = count, triangles, levels
        return totals[node]

    for node in nodes:
        total(node)


def _triangles(geometry: Element, content: bytes) -> int:
    """An upper limit of the triangles of a geometry."""
    total = 0
    for faces in (element for element in _elements(geometry) if element.tag in _FACES):
        stride = 1 + max((int(offset) for given in faces.all("input") if (offset := given.get("offset")).isdecimal()), default=0)
        corners = [len(content[p.start : p.end].split(b">", 1)[-1].split()) // stride for p in faces.all("p")]
        if faces.tag == "polygons":
            _check_corners(max(corners, default=0))
        for counts in faces.all("vcount"):
            _check_corners(max(map(int, content[counts.start : counts.end].split(b">", 1)[-1].split()), default=0))
        total += sum(corners) // (3 if faces.tag == "triangles" else 1)
    return total


def _elements(root: Element) -> Iterator[Element]:
    waiting = [root]
    while waiting:
        yield (element := waiting.pop())
        waiting.extend(reversed(element.children))


def _check_number(triangles: int) -> None:
    if triangles > MOST_TRIANGLES:
        raise UnfitError(f"has more than {MOST_TRIANGLES} triangles")


def _check_corners(corners: int) -> None:
    if corners > MOST_CORNERS:
        raise UnfitError(f"has a polygon with more than {MOST_CORNERS} corners")
