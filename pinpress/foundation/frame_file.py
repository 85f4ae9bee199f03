"""A press on its mounts from a file in YAML or JSON: the frame, what stands on it and spins in it, and the mounts.

    frame: {mass: 15 t, centre: [0, 0.1, -0.35], inertia: [9000, 8000, 4000]}
    mounts:
      - points: [[-0.55, -0.5, -1.3], [-0.55, 0.6, -1.3], [0.55, -0.5, -1.3], [0.55, 0.6, -1.3]]
        stiffness: [50 MN/m, 50 MN/m, 200 MN/m]
    attached: {motor: {mass: 450 kg, centre: [0, 0.9, 0.95], inertia: [20, 10, 20]}}
    rotors:
      - {inertia: 136, axis: [0, -1, 0]}

The keys are the fields of the classes of this room: those of `Frame`, or the arguments of `beam_frame` or of `read_frame`; of `Mount`, at
several points, or a `RubberPad` at each; of `Attachment` with its body's beside; and of `Rotor`. Numbers are in SI units, or have a unit.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, Field
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import numpy as np

from ..common import files
from ..common.arguments import read_quantity, typed
from ..common.errors import FileEntryError, PinpressError, UnknownNameError
from ..common.parameters import declared, in_signature
from ..common.quantities import Array, readable
from ..common.reading.columns import Wanted, read_columns
from ..common.reading.entries import Entry, FileKind, read_entries
from ..common.reading.matrices import is_market
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.mounts import Vector
from .beams import FrameBeam, beam_frame
from .elastic_frame import ElasticFrame, read_frame
from .frame_parts import Attachment, Rotor
from .mounted_press import MountedPress, mounted
from .mounts import Frame, Mount, RubberPad, pad_mount

T = TypeVar("T")

USUAL_WORDS = {  # what else keys are called, in lower case
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
TOP = ("frame", "mounts", "crown", "uprights", "attached", "rotors")
ELASTIC = ("bed", "carrier", "bearings", "modes", "loss_factor")
OF_BEAMS = ("places", "beams", *ELASTIC, "elements")
OF_MATRICES = ("matrices", "interfaces", *ELASTIC, "lines")
MARKET = ("mass", "stiffness", "nodes", "degrees")  # keys of ``matrices`` where it is no one file
MARKETS = "{mass: m.mtx, stiffness: k.mtx, nodes: nodes.csv, degrees: degrees.csv}"
THREE = "a list such as [0, 0.1, -0.35]"
REMEDY = re.compile(r"[:;] (?=(?:give|leave|move|name|join|make|write|there are)\b)")  # before what to do, in messages of others


@typed
def read_mounted(press: Linkage, file: str | os.PathLike[str], *, motion: Motion | None = None) -> MountedPress:
    """Stand a press on its mounts as a file in YAML or JSON says.

    Keys of the top, of which the first two are needed; see the manual for those below them:

        frame     ``mass``, ``centre``, ``inertia`` of a rigid one; ``places``, ``beams``, ``bed``, ``carrier`` of beams, see `beam_frame`;
                  ``matrices``, ``interfaces``, ``bed``, ``carrier`` of a finite-element model, see `read_frame`
        mounts    a list: ``points``, at each of which stands a mount of the other keys, those of `Mount`, or a ``pad``, see `RubberPad`
        crown     a rigid upper part, as ``frame``
        uprights  the columns below it, as ``mounts``
        attached  name -> mass, centre, inertia of what stands on the frame, ``on`` a part, with ``springs`` as ``mounts``
        rotors    a list: keys of `Rotor`

    Numbers are in SI units, or texts with a unit, as ``200 mm``. Files named in it are sought beside it.

    Args:
        press: the press that stands on it.
        file: path of the file.
        motion: as of `mounted`.

    Raises:
        PinpressError: the file cannot be read, a key is unknown, missing or of no use, or as `mounted`; with file, line and keys.
    """
    path = Path(files.path_of("file", file))
    top = read_entries(path, FRAME_FILE)
    items = top.known(TOP, "a frame file")
    _refuse_missing(top, items, ("frame", "mounts"), "frame: {mass: ..., centre: ..., inertia: ...} and mounts: [{points: ..., ...}]")
    parts: dict[str, Any] = {"frame": _frame(items["frame"], path.parent), "mounts": _mounts(items["mounts"])}
    if "crown" in items:
        parts["crown"] = _body(items["crown"])
    if "uprights" in items:
        parts["uprights"] = _mounts(items["uprights"])
    if "attached" in items:
        named = items["attached"].items("a name for each: {motor: {mass: ..., centre: ..., inertia: ...}}")
        parts["attached"] = {name: _attachment(each) for name, each in named.items()}
    if "rotors" in items:
        listed = items["rotors"].list("a list, - {inertia: 136, axis: [0, -1, 0]}")
        parts["rotors"] = [_make(Rotor, _values(Rotor, each, {}), each) for each in listed]
    with _naming(top):
        return mounted(press, **parts, motion=motion)


def _frame(entry: Entry, folder: Path) -> Frame | ElasticFrame:
    items = entry.items("mass, centre and inertia of the frame, its places and beams, or its matrices")
    if "beams" in items:
        entry.known(OF_BEAMS, "frame")
        _refuse_missing(entry, items, ("places", "beams", "bed", "carrier"), "all four for a frame of beams")
        places = {name: _vector(each, "m") for name, each in items["places"].items("places: {crown: [0, 0, 0.5]}").items()}
        boxes = [beam for each in items["beams"].list("a list, - {between: [[left, crown]], width: ...}") for beam in _beams(each)]
        more = _elastic(items) | ({"elements": _whole(items["elements"])} if "elements" in items else {})
        with _naming(entry):
            return beam_frame(places, boxes, **more)
    if "matrices" in items:
        entry.known(OF_MATRICES, "frame")
        _refuse_missing(entry, items, ("interfaces", "bed", "carrier"), "them: names of nodes, and which of these carry bed and crank")
        named = items["interfaces"].items("interfaces: {bed: 12, crown: 40}").items()
        files_of_matrices = _matrices(items["matrices"], folder)
        more = _elastic(items) | {"interfaces": {name: _whole(each) for name, each in named}}
        if "lines" in items:
            more["lines"] = _rows(items["lines"], folder, ("node", "node"))
        with _naming(entry):
            return read_frame(**files_of_matrices, **more)
    return _body(entry)


def _body(entry: Entry) -> Frame:
    return _make(Frame, _values(Frame, entry, {}), entry)


def _attachment(entry: Entry) -> Attachment:
    values = _values(Frame, entry, {"on": _text, "springs": _mounts})
    aside: dict[str, Any] = {name: values.pop(name) for name in ("on", "springs") if name in values}
    body = _make(Frame, values, entry)
    return _make(Attachment, {"body": body, **aside}, entry)


def _mounts(entry: Entry) -> list[Mount]:
    """The mounts of a list: springs, or rubber pads, at several points each."""
    mounts: list[Mount] = []
    for each in entry.list("a list, - {points: [[0.5, 0.6, -1.3]], stiffness: [50 MN/m, 50 MN/m, 200 MN/m]}"):
        items = each.items("points: [[0.5, 0.6, -1.3]], and stiffness: or pad:")
        if "pad" in items:
            each.known(("points", "pad"), "mounts")
            pad = _make(RubberPad, _values(RubberPad, items["pad"], {}), items["pad"])
            _refuse_missing(each, items, ("points",), "where the pads are: points: [[0.5, 0.6, -1.3]]")
            mounts += [pad_mount(point, pad) for point in _points(items["points"])]
        else:
            values = _values(Mount, each, {"points": _points}, without="point")
            _refuse_missing(each, items, ("points",), "where the mounts are: points: [[0.5, 0.6, -1.3]]")
            mounts += [_make(Mount, {"point": point, **values}, each) for point in values.pop("points")]
    return mounts


def _points(entry: Entry) -> list[Vector]:
    example = "a list of points, [[0.5, 0.6, -1.3]]"
    listed = entry.list(example)
    if not listed or not isinstance(listed[0].value, tuple):
        entry.refuse("it is no list of points", f"write {example}")
    return [_vector(each, "m") for each in listed]


def _beams(entry: Entry) -> list[FrameBeam]:
    """Beams of one section between several pairs of places."""
    values = _values(FrameBeam, entry, {"between": _pairs}, without=("start", "end"))
    if "between" not in values:
        entry.refuse("between is missing", "write between which places the beams are: between: [[left, crown], [right, crown]]")
    return [_make(FrameBeam, {"start": start, "end": end, **values}, entry) for start, end in values.pop("between")]


def _pairs(entry: Entry) -> list[tuple[str, str]]:
    example = "pairs of places: [[left, crown], [right, crown]]"
    pairs = []
    for each in entry.list(example):
        ends = each.list(example)
        if len(ends) != 2:
            each.refuse(f"{len(ends)} places", f"write {example}")
        pairs.append((_text(ends[0]), _text(ends[1])))
    return pairs


def _elastic(items: Mapping[str, Entry]) -> dict[str, Any]:
    """Arguments that both kinds of a frame that bends have."""
    arguments: dict[str, Any] = {name: _text(items[name]) for name in ("bed", "carrier")}
    if "bearings" in items:
        carried = items["bearings"].items("the place that carries a bearing: bearings: {slide_guide: bed}")
        arguments["bearings"] = {name: _text(each) for name, each in carried.items()}
    if "modes" in items:
        arguments["modes"] = _whole(items["modes"])
    if "loss_factor" in items:
        arguments["loss_factor"] = _number(items["loss_factor"], "-")
    return arguments


def _matrices(entry: Entry, folder: Path) -> dict[str, Any]:
    """Arguments of `read_frame` that say where the matrices are."""
    if isinstance(entry.value, str):
        if is_market(entry.value):
            entry.refuse(f"{entry.value} holds one matrix", f"write {MARKETS}")
        return {"file": folder / entry.value}
    items = entry.known(MARKET, "matrices")
    _refuse_missing(entry, items, MARKET, f"all four: {MARKETS}, or one .npz")
    mass, stiffness = (folder / _text(items[name]) for name in ("mass", "stiffness"))
    nodes, degrees = _rows(items["nodes"], folder, ("x", "y", "z"), "m"), _rows(items["degrees"], folder, ("node", "direction"))
    return {"file": mass, "stiffness": stiffness, "nodes": nodes, "degrees": degrees}


def _rows(entry: Entry, folder: Path, columns: Sequence[str], unit: str = "-") -> Array:
    """Numbers (rows, columns) of a CSV file, of which the first line may be a header; with a ``unit``, the header may name another one of
    its kind."""
    path, wanted = (
        folder / _text(entry),
        {f"{name} {k}" if columns.count(name) > 1 else name: Wanted(unit, bare=unit) for k, name in enumerate(columns)},
    )
    try:
        table = read_columns(path, wanted, by_order=True)
    except PinpressError as error:
        _refuse_as(entry, str(error))
    if len({*table.units.values()}) > 1:
        entry.refuse(f"the header of {path} has several units", "give all columns in one unit")
    return np.column_stack([*table.values.values()]).reshape(-1, len(columns))


# -------------------------------------------------------------------------------------------------------------------------------- values


def _values(kind: type, entry: Entry, also: Mapping[str, Callable[[Entry], Any]], without: Sequence[str] = ()) -> dict[str, Any]:
    """Values for the fields of a class by the keys of an entry, and those of other keys; refused where a key is unknown or missing."""
    fields = {field.name: field for field in in_signature(kind) if field.name not in without}
    items = entry.known((*fields, *also), kind.__name__)
    needed = [name for name, field in fields.items() if field.default is MISSING]
    _refuse_missing(entry, items, needed, "them, in SI units or with a unit, such as 200 mm")
    return {name: also[name](each) if name in also else _value(fields[name], each) for name, each in items.items()}


def _value(field: Field[Any], entry: Entry) -> Any:
    parameter = declared(field)
    if parameter is None:
        return _text(entry)
    if not parameter.axes:
        return _number(entry, parameter.unit)
    listed = entry.list(THREE)
    if field.name == "inertia" and any(isinstance(each.value, tuple) for each in listed):
        return tuple(_vector(each, parameter.unit) for each in listed)
    return _vector(entry, parameter.unit)


def _vector(entry: Entry, unit: str) -> Vector:
    listed = entry.list(THREE)
    if len(listed) != 3:
        entry.refuse(f"{len(listed)} numbers", "write three, along x, y and z")
    x, y, z = (_number(each, unit) for each in listed)
    return x, y, z


def _number(entry: Entry, unit: str) -> float:
    text = entry.text("a number")
    try:
        return read_quantity(text, unit)
    except ValueError as error:
        units = [each for each in readable(unit) if each != "-"]
        return entry.refuse(f"{text!r} is {error}", f"write a number{f' in {units[0]}, or with a unit' if units else ''}")


def _whole(entry: Entry) -> int:
    text = entry.text("a whole number")
    return int(text) if re.fullmatch(r"[-+]?\d{1,9}", text) else entry.refuse(f"{text!r} is no whole number", "write one, such as 12")


def _text(entry: Entry) -> str:
    return entry.text("one text")


def _refuse_missing(entry: Entry, items: Mapping[str, Entry], names: Sequence[str], remedy: str) -> None:
    missing = [name for name in names if name not in items]
    if missing:
        entry.refuse(f"{' and '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing", f"write {remedy}")


def _make(kind: Callable[..., T], values: Mapping[str, Any], entry: Entry) -> T:
    """An object of a class; errors about its arguments name the entry."""
    with _naming(entry):
        return kind(**values)


@contextmanager
def _naming(entry: Entry) -> Iterator[None]:
    """Let errors about arguments name the entry from which these are; errors about a press stay as they are."""
    try:
        yield
    except PinpressError as error:
        if type(error) not in (PinpressError, UnknownNameError):
            raise
        _refuse_as(entry, str(error))


def _refuse_as(entry: Entry, text: str) -> NoReturn:
    problem, *rest = REMEDY.split(text, maxsplit=1)
    entry.refuse(problem, rest[0] if rest else "write another value")
