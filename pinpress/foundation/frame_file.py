"""A press on its mounts from a file in YAML or JSON: the frame, its attachments and rotors, and the mounts.

    frame: {mass: 15 t, centre: 0 100 -350 mm, inertia: 9000 8000 4000 kg m2}
    mounts:
      - points: [-550 -500 -1300 mm, -550 600 -1300 mm, 550 -500 -1300 mm, 550 600 -1300 mm]
        stiffness: 50 50 200 MN/m
    attached: {motor: {mass: 450 kg, centre: 0 900 950 mm, inertia: 20 10 20 kg m2}}
    rotors:
      - {inertia: 136 kg m2, axis: 0 -1 0}

The keys are the fields of this room's classes. ``frame`` has the fields of `Frame`, or the arguments of `beam_frame` or `read_frame`.
``mounts`` has the fields of `Mount` for several points, or a `RubberPad` for each point. ``attached`` has the fields of `Attachment` and of
its body. ``rotors`` has the fields of `Rotor`. Every number has a unit.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..common import files
from ..common.arguments import typed
from ..common.errors import FileEntryError, PinpressError
from ..common.quantities import Array
from ..common.reading.columns import Wanted, read_columns
from ..common.reading.entries import Entry, FileKind, read_entries
from ..common.reading.filling import (
    Around,
    DataFile,
    Listed,
    Named,
    Number,
    Numbers,
    Part,
    Rows,
    Text,
    Whichever,
    Whole,
    naming,
)
from ..common.reading.matrices import is_market
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from .beams import FrameBeam, beam_frame
from .elastic_frame import ElasticFrame, read_frame
from .frame_parts import Attachment, Rotor
from .mounted_press import MountedPress, mounted
from .mounts import Frame, Mount, RubberPad, pad_mount

USUAL_WORDS = {  # other usual words for keys, in lower case
    "weight": "mass",
    "m": "mass",
    "com": "centre",
    "cog": "centre",
    "center": "centre",
    "j": "inertia",
    "i": "inertia",
    "at": "points",
    "point": "points",
    "position": "points",
    "k": "stiffness",
    "c": "damping",
    "feet": "mounts",
    "pads": "mounts",
    "motors": "attached",
    "attachments": "attached",
    "flywheel": "rotors",
    "flywheels": "rotors",
    "columns": "uprights",
    "nodes": "places",
    "elements_per_beam": "elements",
    "ends": "between",
    "from": "between",
}
FRAME_FILE = FileKind("frame file", FileEntryError, "frame and mounts", USUAL_WORDS)
MARKETS = "{mass: m.mtx, stiffness: k.mtx, nodes: nodes.csv, degrees: degrees.csv}"


@typed
def read_mounted(press: Linkage, file: str | os.PathLike[str], *, motion: Motion | None = None) -> MountedPress:
    """Read the frame and the mounts of a press from a file in YAML or JSON, and stand the press on them.

    Keys at the top level; the first two are required. The manual lists the keys below them:

        frame     ``mass``, ``centre``, ``inertia`` of a rigid one; ``places``, ``beams``, ``bed``, ``carrier`` of beams, see `beam_frame`;
                  ``matrices``, ``interfaces``, ``bed``, ``carrier`` of a finite-element model, see `read_frame`
        mounts    a list: ``points``, and for a mount at each point the keys of `Mount`, or a ``pad``, see `RubberPad`
        crown     a rigid upper part, as ``frame``
        uprights  the columns below it, as ``mounts``
        attached  name -> mass, centre, inertia of a body on the frame, ``on`` a part, with ``springs`` as ``mounts``
        rotors    a list: keys of `Rotor`

    Every number has a unit, as ``200 mm``; several numbers can share one unit at the end. A file name is relative to the folder of this
    file.

    Args:
        press: the press that stands on it.
        file: path of the file.
        motion: as for `mounted`.

    Raises:
        PinpressError: the file cannot be read, a key is unknown, missing or without effect, or as `mounted`; the message names file, line
            and keys.
    """
    top = read_entries(Path(files.path_of("file", file)), FRAME_FILE)
    parts = ON_MOUNTS.read(top, Around())
    with naming(top):
        return mounted(press, **parts, motion=motion)


def _mounts(made: Callable[..., Mount], given: dict[str, Any]) -> list[Mount]:
    """A mount at each of the points: a spring, or a rubber pad."""
    points, pad = given.pop("points"), given.pop("pad", None)
    if pad is not None:
        if given:
            raise PinpressError(f"{', '.join(given)} and pad both describe the mount: leave out one of them")
        return [pad_mount(point, pad) for point in points]
    if "stiffness" not in given:
        raise PinpressError("stiffness is missing: give it along x, y and z, stiffness: 50 50 200 MN/m, or a pad")
    return [made(point, **given) for point in points]


def _attached(made: Callable[..., Attachment], given: dict[str, Any]) -> Attachment:
    """An attachment; the keys of its body are on the same level as its own keys."""
    beside = {name: given.pop(name) for name in ("on", "springs") if name in given}
    return made(body=Frame(**given), **beside)


def _beams(made: Callable[..., FrameBeam], given: dict[str, Any]) -> list[FrameBeam]:
    """Beams of one section between several pairs of places."""
    pairs = given.pop("between")
    if any(len(pair) != 2 for pair in pairs):
        raise PinpressError("a beam is between two places: write between: [[left, crown], [right, crown]]")
    return [made(start=start, end=end, **given) for start, end in pairs]


class _Pairs(Text):
    """Pairs of names. A name may contain blanks."""

    def read(self, entry: Entry, around: Around) -> Any:
        example = "pairs of places: [[left, crown], [right, crown]]"
        return [[each.text(example) for each in pair.list(example)] for pair in entry.list(example)]


def _frame_of_beams(made: Callable[..., ElasticFrame], given: dict[str, Any]) -> ElasticFrame:
    return beam_frame(given.pop("places"), given.pop("beams"), **given)


class _Matrices(DataFile):
    """One file with all matrices of a model, or a file for each matrix."""

    def read(self, entry: Entry, around: Around) -> Any:
        if isinstance(entry.value, str):
            if is_market(entry.value):
                entry.refuse(f"{entry.value} holds one matrix", f"write {MARKETS}")
            return {"file": super().read(entry, around)}
        return MARKET.read(entry, around)


class _Table(DataFile):
    """Numbers (rows, columns) of a CSV file. The first line may be a header.

    If ``unit`` is given, the header may name another unit of the same quantity.
    """

    def __init__(self, columns: Sequence[str], unit: str = "-") -> None:
        self.columns, self.unit = columns, unit

    def read(self, entry: Entry, around: Around) -> Any:
        names = [f"{name} {k}" if self.columns.count(name) > 1 else name for k, name in enumerate(self.columns)]
        with naming(entry):
            table = read_columns(super().read(entry, around), {name: Wanted(self.unit, bare=self.unit) for name in names}, by_order=True)
        if len({*table.units.values()}) > 1:
            entry.refuse(f"the header of {table.file} has several units", "give all columns in one unit")
        numbers: Array = np.column_stack([*table.values.values()]).reshape(-1, len(names))
        return numbers


def _files(made: Callable[..., Any], given: dict[str, Any]) -> dict[str, Any]:
    return {"file": given.pop("mass"), **given}


def _frame_of_matrices(made: Callable[..., ElasticFrame], given: dict[str, Any]) -> ElasticFrame:
    return read_frame(**given.pop("matrices"), **given)


MARKET: Part[Any] = Part(
    dict,
    MARKETS,
    {"mass": DataFile(), "stiffness": DataFile(), "nodes": _Table("xyz", "m"), "degrees": _Table(("node", "direction"))},
    needed=("mass", "stiffness", "nodes", "degrees"),
    finish=_files,
)
ELASTIC: Mapping[str, Any] = {  # keys of both kinds of elastic frame
    "bed": Text(),
    "carrier": Text(),
    "bearings": Named(Text(), "{slide_guide: bed}"),
    "modes": Whole(),
    "loss_factor": Number("-"),
}
PAD = Part(RubberPad, "{length: 200 mm, width: 200 mm, thickness: 10 mm, hardness: 65, loss_factor: 0.15, stiffening: 1.3}")
MOUNT: Part[Any] = Part(
    Mount,
    "{points: [550 600 -1300 mm, -550 600 -1300 mm], stiffness: 50 50 200 MN/m}",
    {"points": Rows("m"), "stiffness": Numbers("N/m"), "pad": PAD},
    without=("point", "stiffness"),
    needed=("points",),
    finish=_mounts,
)
BODY = Part(Frame, "{mass: 15 t, centre: 0 100 -350 mm, inertia: 9000 8000 4000 kg m2}")
ATTACHED: Part[Any] = Part(
    Attachment,
    "{mass: 450 kg, centre: 0 900 950 mm, inertia: 20 10 20 kg m2}",
    {**BODY.values, "on": Text(), "springs": Listed(MOUNT, several=True)},
    without=("body",),
    needed=BODY.required,
    finish=_attached,
)
BEAM: Part[Any] = Part(
    FrameBeam,
    "{between: [[left, crown], [right, crown]], width: 200 mm, height: 300 mm, across: 1 0 0}",
    {"between": _Pairs()},
    without=("start", "end"),
    needed=("between",),
    finish=_beams,
)
FRAME = Whichever(
    {
        "beams": Part(
            beam_frame,
            "{places: {crown: 0 0 500 mm}, beams: [{between: [[left, crown]], width: 200 mm, height: 300 mm}], bed: bed, carrier: crown}",
            {"places": Named(Numbers("m"), "{crown: 0 0 500 mm}"), "beams": Listed(BEAM, several=True), **ELASTIC, "elements": Whole()},
            needed=("places", "beams", "bed", "carrier"),
            finish=_frame_of_beams,
        ),
        "matrices": Part(
            read_frame,
            "{matrices: frame.npz, interfaces: {bed: 12, crown: 40}, bed: bed, carrier: crown}",
            {
                "matrices": _Matrices(),
                "interfaces": Named(Whole(), "{bed: 12, crown: 40}"),
                **ELASTIC,
                "lines": _Table(("node", "node")),
            },
            needed=("matrices", "interfaces", "bed", "carrier"),
            finish=_frame_of_matrices,
        ),
        "": BODY,
    }
)

MOUNTED: Mapping[str, Any] = {
    "frame": FRAME,
    "mounts": Listed(MOUNT, several=True),
    "crown": BODY,
    "uprights": Listed(MOUNT, several=True),
    "attached": Named(ATTACHED, "{motor: {mass: ..., centre: ..., inertia: ...}}"),
    "rotors": Listed(Part(Rotor, "{inertia: 136 kg m2, axis: 0 -1 0}")),
}
ON_MOUNTS: Part[dict[str, Any]] = Part(
    dict, "frame: {mass: ..., centre: ..., inertia: ...} and mounts: [{points: ..., stiffness: ...}]", MOUNTED, needed=("frame", "mounts")
)
