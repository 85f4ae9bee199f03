"""Triangles from the mesh files that a URDF names."""

import os
import re
from pathlib import Path

import numpy as np

from . import urdf
from .errors import PinpressError, UrdfError
from .shapes import Mesh

KINDS = "STL (.stl), Wavefront (.obj) or COLLADA (.dae)"
_INDICES = re.compile(rb"<(?:p|v|vcount)\b[^>]*>([^<]*)<|(?:count|offset|stride)\s*=\s*[\"']([^\"']*)")


def read(file: str, link: str, name: str, scale: tuple[float, ...]) -> Mesh:
    """A mesh, by the name that the URDF ``file`` gives it: a path, which may be relative to the URDF, ``file://...`` or ``package://...``.

    A package is looked for in ROS_PACKAGE_PATH, among the folders that the URDF is in, and beside them.

    Args:
        link: whose visual it is. scale: along x, y, z.

    Raises:
        PinpressError: the mesh is not found, no mesh, without triangles, or flat or not finite after scaling.
    """
    place = f"link {link!r}: mesh {name!r}"
    factors = np.array(scale)
    if not factors.all():
        raise PinpressError(f"{place} has the scale {' '.join(map(str, scale))}, which makes it flat; give numbers other than 0")
    path = _located(file, name)
    if path is None:
        raise PinpressError(
            f"{place} is in no package that is known; put the folder of the package, or the one it is in, into ROS_PACKAGE_PATH, or give"
            " the mesh's path relative to the URDF"
        )
    if not path.is_file():
        raise PinpressError(f"{place}: there is no file {os.fspath(path)!r}; correct the path, or put the mesh there")
    try:
        problem = _problem(path.suffix.lower(), path.read_bytes())
    except OSError as error:
        raise PinpressError(f"{place} cannot be read: {error.strerror}; make {os.fspath(path)!r} readable") from error
    if problem:
        raise PinpressError(f"{place} {problem}; give an intact file, {KINDS}")

    import coal  # part of Pinocchio, but seldom needed

    try:
        found = coal.MeshLoader().load(os.fspath(path), np.ones(3))  # unscaled: here a scale of any size is safe
    except Exception as error:
        raise PinpressError(f"{place} cannot be read as triangles; give an intact file, {KINDS}") from error
    faces = np.array([[side[0], side[1], side[2]] for side in map(found.tri_indices, range(found.num_tris))], dtype=np.int64)
    with np.errstate(all="ignore"):  # what is not finite is refused below
        vertices = np.array(found.vertices(), dtype=float) * factors
    if len(faces) == 0 or faces.max() >= len(vertices):
        raise PinpressError(f"{place} has no triangles, or some without corners; give an intact file, {KINDS}")
    if not np.isfinite(vertices).all():
        raise PinpressError(f"{place} has a vertex that is not finite; repair the mesh, or give a smaller scale")
    if np.prod(np.sign(factors)) < 0:
        faces = faces[:, ::-1].copy()  # mirrored: the outside would be the inside
    for array in (vertices, faces):
        array.setflags(write=False)
    return Mesh(vertices, faces)


def _located(file: str, name: str) -> Path | None:
    """Where a mesh is; None where its package is nowhere."""
    folder = Path(file).resolve().parent
    if not name.startswith("package://"):
        return folder / re.sub("^file://", "", name)
    package, _, rest = name.removeprefix("package://").partition("/")
    for root in filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)):
        if Path(root).name == package and (Path(root) / rest).exists():
            return Path(root) / rest
        if (Path(root) / package).is_dir():
            return Path(root) / package / rest
    for parent in (folder, *folder.parents):
        if parent.name == package:
            return parent / rest
        if (parent / package).is_dir():
            return parent / package / rest
    return None


def _problem(suffix: str, content: bytes) -> str | None:
    """Why a file is not what its name says; None if it may be.

    The library that reads meshes goes by the content where the name does not help, ends the process on some broken files of other kinds,
    makes room for as many vertices as the largest index in a COLLADA file says, and never ends on an index that is no number.
    """
    if suffix == ".stl":
        triangles = int.from_bytes(content[80:84], "little")
        whole = 0 < triangles <= (len(content) - 84) // 50 or content.lstrip()[:5].lower() == b"solid"
        return None if whole else "is not an STL file, or one that ends early"
    if suffix == ".obj":
        return None if re.search(rb"^[ \t]*v[ \t]", content, re.MULTILINE) and b"\0" not in content else "is not a Wavefront file"
    if suffix != ".dae":
        return f"is of an unknown kind, {suffix!r}"
    try:
        root = urdf.tree("", content)
    except (UrdfError, ValueError):  # ValueError: an attribute that is not text
        return "is not a COLLADA file"
    numbers = (number for match in _INDICES.finditer(content) for number in (match[1] or match[2] or b"").split())
    if root.tag != "COLLADA" or not all(re.fullmatch(rb"\d{1,12}", number) and int(number) <= len(content) for number in numbers):
        return "is not a COLLADA file, or one with a broken index"
    return None
