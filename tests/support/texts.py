"""Linkages for tests from texts of URDF, and by name; each is read once."""

from functools import cache

import pinpress as pp


@cache
def load(text, folder, gravity=(0.0, 0.0, -9.81)):
    """The linkage of a text, by way of a file in a folder."""
    file = folder / "linkage.urdf"
    file.write_text(text, encoding="utf-8")
    return pp.load(file, gravity=gravity)


@cache
def shipped(name, gravity=(0.0, 0.0, -9.81)):
    """A shipped press: a linkage is read-only, so that tests can share one, and what it has found out about itself."""
    return pp.load(name, gravity=gravity)
