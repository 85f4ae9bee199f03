"""From a `Linkage` back to a URDF: the text it was read from, with the numbers that have changed.

What is written is read again before it reaches its place. Where Pinocchio rounds what it reads (it multiplies a centre of mass by the mass
and divides by it again), the number is written that loads to the wanted one.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin

from ..common import files
from ..common.arguments import typed
from ..common.arrays import Array
from ..common.errors import PinpressError
from ..common.files import path_of
from ..engines.coordinates import axes
from . import assembly_checks, loading
from .linkage import Linkage
from .urdf import reader
from .urdf.document import Document
from .urdf.findings import Finding
from .urdf_edits import DYNAMICS, LIMITS, POSITION_LIMITS, edited, placement

MOST_TEXTS = 4  # tried to meet the numbers to the last bit; the second mostly does, or none
ACCEPTED = 1e-12  # relative difference from the linkage with which a text is still it

_UNSAID = ("armature", "rotorInertia", "rotorGearRatio")  # a URDF has nothing to say it with


@typed
def write_urdf(press: Linkage, path: str | os.PathLike[str]) -> Path:
    """Write a linkage, perhaps a changed one, as a URDF that loads to the same numbers, and return its path.

    The text it was read from is kept to the byte (visuals, comments, elements of other programs) but for the numbers in which ``press``
    differs: inertias, placements of joints, of welded links and of loops, axes, limits, gear pairs, drivers, the name. A changed linkage is
    made by ``dataclasses.replace(press, model=..., loops=...)``. A revolute loop keeps its ``<axis>``: the frames of its ends turn.

    Masses, positions and limits load to the last bit, and centres of mass but for it; inertia tensors to 3e-16 of their largest component
    and turned frames to 2e-15, because Pinocchio computes them from what it reads. What is a sum over links that are welded together may
    be off by a last bit too. Of limits of effort, velocity and friction the upper ones count.

    Such links are one body. Where its inertia has changed, the heaviest of them takes the difference and the others keep what the text
    says; where no body has the inertia that is then left for the heaviest, the next takes the difference; where that is so for each, the
    heaviest takes all and the others lose their ``<inertial>``.

    A URDF says nothing of gravity, nor which link is the slide: give `load` both again. The file is replaced only once it is complete.

    Raises:
        PinpressError: other links, joints, loops or gear pairs than in the text; what a URDF cannot hold, such as an armature; a path that
            cannot be written.
        UrdfError, AssemblyError, SingularityError: `load` would refuse the file.
    """
    unwritten = f"{path_of('path', path)} (not written)"  # the file's name in errors
    template = press.document
    before = loading.assembled(template, press.drivers, press.slide)
    _check(press, before)
    aim, tried = press, []
    for _ in range(MOST_TEXTS):
        text = edited(template, before, aim)
        reached = loading.assembled(_read(text, unwritten), None, press.slide)
        gaps = _gaps(press, reached)
        tried.append((sum(gaps.values()), gaps, text, reached))
        if not gaps or (len(tried) > 1 and tried[-1][0] >= tried[-2][0]):
            break
        aim = _corrected(aim, press, reached)
    _, gaps, text, reached = min(tried, key=lambda attempt: attempt[0])
    for what, gap in gaps.items():
        if not gap <= ACCEPTED:
            raise PinpressError(f"{unwritten}: a URDF cannot hold the changed {what} of {press.name}; leave it as in {press.file}")
    _raise_first(assembly_checks.errors(reached))
    return files.write(path, text)


def _read(text: bytes, file: str) -> Document:
    """A text as if it stood in that file; raises its first error."""
    document = Document(file, text)
    _raise_first(reader.errors(document))
    return document


def _raise_first(findings: Iterable[Finding]) -> None:
    for finding in findings:
        if finding.error is not None:
            raise finding.error


# ------------------------------------------------------------------------------------------------------------------ two linkages compared


def _check(press: Linkage, before: Linkage) -> None:
    """Raises where a linkage differs from what it was before in something that is no number, or is not finite."""
    was = _structure(before)
    for what, now in _structure(press).items():
        if now != was[what]:
            raise PinpressError(
                f"{press.name} has other {what} than {press.file}: write_urdf changes numbers alone; edit that file instead"
            )
    for what, numbers, size in _contents(press):
        if size and not np.all(np.isfinite(numbers)):
            raise PinpressError(f"{press.name}: {what}: not finite; write plain numbers, in SI units")


def _structure(press: Linkage) -> dict[str, object]:
    model, known = press.model, [link for link in press.links if press.model.existFrame(link, pin.BODY)]
    return {
        "joints": (tuple(model.names), tuple(model.parents)),
        "joint types": [(joint.shortname()[:11], joint.nq) for joint in model.joints],  # JointModelR, JointModelP; not which axis
        "links": [(link, model.frames[model.getFrameId(link, pin.BODY)].parentJoint) for link in known],
        "loops": [(loop.name, loop.joint1, loop.joint2) for loop in press.loops],
        "gear pairs": [(pair.name, pair.follower) for pair in press.couplings],
    }


def _gaps(press: Linkage, reached: Linkage) -> dict[str, float]:
    """In what linkages of one structure differ, and by how much, relative to the size of such things."""
    gaps = {}
    for (what, wanted, size), (_, got, _) in zip(_contents(press), _contents(reached), strict=True):
        if not np.array_equal(wanted, got):
            gaps[what] = float(np.abs(wanted - got).max()) / size if size else np.inf
    return gaps


def _contents(press: Linkage) -> Iterator[tuple[str, Array, float]]:
    """What a URDF says of a linkage: arrays with their names and sizes, to which rounding is relative; 0 where nothing is rounded."""
    model = press.model
    places = [*model.jointPlacements, *(placement(press, link) for link in press.links)]
    lengths = {
        "placement of joints and links": [place.translation for place in places],
        "centres of mass": [inertia.lever if inertia.mass else np.zeros(3) for inertia in model.inertias],
        "loop ends": [end for loop in press.loops for end in (loop.point1, loop.point2)],
    }
    turned = {
        "directions of joints and links": [place.rotation for place in places],
        "directions of loop ends": [end for loop in press.loops for end in (loop.rotation1, loop.rotation2)],
        "joint axes": [axis.direction for axis in axes(model)],
    }
    size = float(np.abs(np.concatenate([np.ravel(values) for values in lengths.values()])).max()) or 1.0
    yield from ((what, np.array(values), size) for what, values in lengths.items())
    yield from ((what, np.array(values), 1.0) for what, values in turned.items())
    for name, inertia in zip(model.names, model.inertias, strict=True):
        yield f"mass on joint {name!r}", np.array(inertia.mass), inertia.mass
        yield f"inertia tensor on joint {name!r}", inertia.inertia, float(np.abs(inertia.inertia).max())
    for name in (*POSITION_LIMITS.values(), *LIMITS.values(), *DYNAMICS.values(), *_UNSAID):
        yield name, getattr(model, name), 0.0
    yield "loop types", np.array([loop.type for loop in press.loops]), 0.0
    yield "gear pairs", np.array([(pair.leader, pair.multiplier, pair.offset) for pair in press.couplings]), 0.0
    yield "drivers", np.array(press.drivers), 0.0
    yield "name", np.array(press.name), 0.0


def _corrected(aim: Linkage, wanted: Linkage, reached: Linkage) -> Linkage:
    """An aim that is moved by what it missed."""
    model = aim.model.copy()
    for j, (want, got) in enumerate(zip(wanted.model.inertias, reached.model.inertias, strict=True)):
        inertia, place = model.inertias[j], model.jointPlacements[j]
        inertia.mass += want.mass - got.mass
        inertia.lever = inertia.lever + (want.lever - got.lever)
        inertia.inertia = inertia.inertia + (want.inertia - got.inertia)
        place.translation = place.translation + wanted.model.jointPlacements[j].translation - reached.model.jointPlacements[j].translation
    loops = tuple(
        dataclasses.replace(loop, point1=loop.point1 + (want.point1 - got.point1), point2=loop.point2 + (want.point2 - got.point2))
        for loop, want, got in zip(aim.loops, wanted.loops, reached.loops, strict=True)
    )
    return dataclasses.replace(aim, model=model, loops=loops)
