"""Triangles from the mesh files that a URDF names."""

import os
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ...common import regular_files
from ...common.errors import PinpressError
from . import mesh_checks
from .solids import Mesh

KINDS = "STL (.stl), Wavefront (.obj) or COLLADA (.dae)"


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
    if not os.path.exists(path) or os.path.isdir(path):
        raise PinpressError(f"{place}: there is no file {os.fspath(path)!r}; correct the path, or put the mesh there")
    try:
        content = regular_files.read(path, mesh_checks.MOST_BYTES)
    except (OSError, ValueError) as error:
        said = regular_files.reason(error)
        raise PinpressError(f"{place} cannot be read: {said}; put a mesh file at {os.fspath(path)!r} that is readable") from error
    kind = path.suffix.lower()
    try:
        found = _loaded(kind, mesh_checks.triangles_only(kind, content))
    except mesh_checks.UnfitError as error:
        raise PinpressError(f"{place} {error}; give an intact file, {KINDS}") from error
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


def _loaded(kind: str, content: bytes) -> Any:
    """The mesh in such a content, unscaled; raises UnfitError where there is none."""
    import coal  # part of Pinocchio, but seldom needed

    with tempfile.TemporaryDirectory(prefix="pinpress-") as folder:
        file = Path(folder, f"mesh{kind}")
        file.write_bytes(content)
        try:
            return coal.MeshLoader().load(os.fspath(file), np.ones(3))  # unscaled: here a scale of any size is safe
        except Exception as error:
            raise mesh_checks.UnfitError("cannot be read as triangles") from error


def _located(file: str, name: str) -> Path | None:
    """Where a mesh is; None where its package is nowhere."""
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
