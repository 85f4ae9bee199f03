"""Load cases as an input file of CalculiX and Abaqus, in N, mm, t and s."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..common.errors import PinpressError
from ..common.files import path_of
from ..common.quantities import Array

TO_MM = 1e3  # lengths and accelerations
NOTHING = 1e-12  # share of the largest force or moment below which a component is rounding


def write_deck(cases: Any, path: str | os.PathLike[str], mesh: str | os.PathLike[str], nodes: Mapping[str, int]) -> None:
    """Write the file of `LinkLoads`, whose module imports this one; for the arguments see `LinkLoads.write_inp`."""
    places, elements = _read_mesh(mesh)
    for name, node in nodes.items():
        if node not in places:
            raise PinpressError(f"the mesh {mesh} has no node {node}, at which {name} acts: give the number of one of its nodes")
    middles = {number: np.mean([places[node] for node in corners], axis=0) / TO_MM for number, corners in elements.items()}
    lines = [line for k in range(len(cases.remark)) for line in _step(cases, k, nodes, middles)]
    file = Path(path_of("path", path))
    head = [
        f"** {cases.title}",
        f"** N, mm, t, s, in the axes of {cases.link}; mass {cases.mass * 1e-3:.9g} t: the mesh must have the same",
        f"** centre of mass {', '.join(f'{TO_MM * each:.9g}' for each in cases.com)} mm",
        f"*INCLUDE, INPUT={os.path.relpath(mesh, file.parent)}",
        "*ELSET, ELSET=ALL_OF_LINK",
        *(f"{number}," for number in elements),
    ]
    try:
        file.write_text("\n".join([*head, *lines]) + "\n", encoding="utf-8")
    except OSError as error:
        raise PinpressError(f"{file} cannot be written: {error.strerror}") from error


def _step(cases: Any, k: int, nodes: Mapping[str, int], middles: Mapping[int, Array]) -> Iterator[str]:
    """The lines of a load case."""
    place = cases._press.driver_coordinates[0].at(float(np.ravel(cases.place[k])[0]))
    yield f"** case {k + 1}: {place}{', ' + cases.remark[k] if cases.remark[k] else ''}"
    yield "*STEP"
    yield "*STATIC"
    yield "*CLOAD, OP=NEW"
    for begin, of in ((1, cases.force), (4, {name: TO_MM * each for name, each in cases.moment.items()})):
        least = NOTHING * max(float(np.abs(each[k]).max()) for each in cases.force.values()) * (TO_MM if begin == 4 else 1.0)
        for name, node in nodes.items():
            yield from (f"{node}, {begin + axis}, {value:.12g}" for axis, value in enumerate(of[name][k]) if abs(value) > least)
    yield "*DLOAD, OP=NEW"
    spin, alpha = cases.angular_velocity[k], cases.angular_acceleration[k]
    even = cases.gravity[k] - cases.origin_acceleration[k]
    for number, middle in middles.items():
        field = TO_MM * (even - np.cross(alpha, middle))
        size = float(np.linalg.norm(field))
        if size:
            yield f"{number}, GRAV, {size:.12g}, {', '.join(f'{each:.12g}' for each in field / size)}"
    speed = float(np.linalg.norm(spin))
    if speed:
        yield f"ALL_OF_LINK, CENTRIF, {speed**2:.12g}, 0., 0., 0., {', '.join(f'{each:.12g}' for each in spin / speed)}"
    yield from ("*NODE FILE", "U", "*EL FILE", "S", "*END STEP")


def _read_mesh(mesh: str | os.PathLike[str]) -> tuple[dict[int, Array], dict[int, list[int]]]:
    """Nodes -> places (3,) [mm], and solid, shell or beam elements -> nodes; springs and masses are left out."""
    name = path_of("mesh", mesh)
    try:
        text = Path(name).read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise PinpressError(f"the mesh {name} cannot be read: {error.strerror}") from error
    places: dict[int, Array] = {}
    elements: dict[int, list[int]] = {}
    card, pending = "", list[str]()
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("*"):
            if not line.startswith("**"):
                card, pending = line.upper().replace(" ", ""), []
            continue
        cells = [cell.strip() for cell in line.split(",") if cell.strip()]
        try:
            if card.startswith("*NODE,") or card == "*NODE":
                places[int(cells[0])] = np.array([float(cell) for cell in cells[1:4]])
            elif card.startswith("*ELEMENT,") and not any(kind in card for kind in ("TYPE=SPRING", "TYPE=MASS", "TYPE=DASHPOT")):
                pending += cells
                if not line.rstrip().endswith(","):  # else it goes on in the next line
                    elements[int(pending[0])] = [int(cell) for cell in pending[1:]]
                    pending = []
        except (ValueError, IndexError) as error:
            raise PinpressError(
                f"{name}, line {number}: {line.strip()[:60]!r} is no line of {card.split(',')[0]}: write numbers"
            ) from error
    if not elements:
        raise PinpressError(f"the mesh {name} has no *ELEMENT: give the input file of the link's mesh")
    if lost := {node for corners in elements.values() for node in corners} - places.keys():
        raise PinpressError(f"the mesh {name} has no node {min(lost)}, which its elements name: give the file that has the *NODE cards too")
    return places, elements
