"""Linkages for tests from texts of URDF, and by name; each is read once."""

import re
import tempfile
from functools import cache
from pathlib import Path

from support.process_folder import process_folder

import pinpress as pp

FILES = process_folder("pinpress-linkages-")


@cache
def load(text, gravity=(0.0, 0.0, -9.81), name="linkage.urdf", **options):
    """The linkage of a text, by way of a file of its own. It is read-only, so that tests can share it and what it has found out."""
    return pp.load(file(text, name), gravity=gravity, **options)


def file(text, name="linkage.urdf"):
    """A file of its own with this text."""
    path = Path(tempfile.mkdtemp(dir=FILES)) / name
    path.write_text(text, encoding="utf-8")
    return path


@cache
def shipped(name, gravity=(0.0, 0.0, -9.81)):
    """A shipped press; see `load`."""
    return pp.load(name, gravity=gravity)


def guide_turned_round(name):
    """The text of a shipped press with the axis of its slide's guide turned round, and its limits exchanged."""
    text = shipped(name).text.decode()
    joint = re.search(r'<joint name="slide_guide".*?</joint>', text, re.DOTALL)[0]
    lower, upper = (re.search(rf'{end}="([^"]*)"', joint)[1] for end in ("lower", "upper"))
    other = joint.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -1"/>')
    other = other.replace(f'lower="{lower}" upper="{upper}"', f'lower="{-float(upper)}" upper="{-float(lower)}"')
    assert other.count("0 0 -1") == 1
    return text.replace(joint, other)


NOTHING = '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'


def without_mass(text, *links):
    """A text with nothing in the inertia of links."""
    for link in links:
        start = text.index("<inertial>", text.index(f'<link name="{link}"'))
        end = text.index("</inertial>", start) + len("</inertial>")
        text = text[:start] + NOTHING + text[end:]
    return text
