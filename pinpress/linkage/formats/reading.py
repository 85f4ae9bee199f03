"""A description of a linkage in any format, by its root element, as a URDF."""

from __future__ import annotations

import os

from ...common import files
from ...common.errors import UrdfError
from ..urdf import document
from ..urdf.document import Document
from . import dialects


def document_of(path: str | os.PathLike[str]) -> Document:
    """The URDF that a file is, or that says the same; raises UrdfError where there is none."""
    found = Document(files.path_of("path", path), document.read(path))
    root = found.robot
    if root.tag == "robot":
        return dialects.plain(found)
    if root.tag == "sdf":
        from . import sdf  # seldom needed

        return sdf.read(found)
    if root.tag == "mujoco":
        from . import mjcf  # seldom needed, and it takes the package mujoco

        return mjcf.read(found)
    remedy = "give a URDF, an SDF or an MJCF file"
    raise UrdfError(found.file, str(root), root.line, "the root element is not <robot>, <sdf> or <mujoco>", remedy)
