"""A frame as lines. A rigid part has lines from its centre of mass to its mounts and to everything that it carries. An elastic frame has
the lines of its model. A short line below each foot is its mount."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..common.quantities import Array
from .elastic_frame import ElasticFrame
from .frame_parts import rows_at
from .mounted_press import MountedPress

PAD = 0.05  # length of a mount's line, as a share of the picture's size


class FrameLine(NamedTuple):
    """A line of the frame: its name, its nodes (k, 3), and the rows (k, 3, n) of their displacements."""

    name: str
    places: Array
    rows: Array


def frame_lines(system: MountedPress) -> list[FrameLine]:
    """The lines of the frame, its attachments and its mounts."""
    found = list(_elastic_lines(system.frame, len(system.mass))) if isinstance(system.frame, ElasticFrame) else _rigid_lines(system)
    for name, each in system.attached.items():
        on, centre = system.parts[system.carrier if each.on is None else each.on], np.asarray(each.body.centre, dtype=float)
        ends = [np.asarray(spring.point, dtype=float) for spring in each.springs] or [_nearest(found, centre)]
        for end in ends:
            own = system.parts[name]
            foot = rows_at(own if each.springs else on, end)
            found.append(FrameLine(name, np.array([centre, end]), np.array([rows_at(own, centre), foot])))
    down = PAD * float(np.ptp(np.vstack([line.places for line in found]), axis=0).max())
    for k, mount in enumerate(system.mounts):
        foot = np.array(mount.point)
        rows = np.array([system.mount_rows[k], np.zeros_like(system.mount_rows[k])])
        found.append(FrameLine(f"mount {k + 1}", np.array([foot, foot - [0.0, 0.0, down]]), rows))
    return found


def _rigid_lines(system: MountedPress) -> list[FrameLine]:
    """Lines from the centre of mass of each rigid part to its mounts and columns."""
    found = []
    points: dict[str, list[Any]] = {part: [upright.point for upright in system.uprights] for part in (system.bed, system.carrier)}
    points[system.bed] = [*points[system.bed], *(mount.point for mount in system.mounts)]
    for part, ends in points.items():
        body = system.frame if part == system.bed else system.crown
        if body is None or isinstance(body, ElasticFrame):
            continue
        centre = np.asarray(body.centre, dtype=float)
        for end in ends:
            places = np.array([centre, end])
            found.append(FrameLine(part, places, np.array([rows_at(system.parts[part], place) for place in places])))
    return found


def _elastic_lines(frame: ElasticFrame, count: int) -> list[FrameLine]:
    """The lines of a frame's model; if it has no lines, lines from its middle to each interface."""
    shapes = np.pad(frame.shapes, ((0, 0), (0, 0), (0, count - frame.shapes.shape[2])))
    if len(frame.lines):
        return [FrameLine("frame", frame.places[chain], shapes[chain]) for chain in _chains(frame)]
    middle = np.mean(list(frame.nodes.values()), axis=0)
    whole = rows_at(np.eye(6, count), middle)
    ends = [
        (np.array(place), rows_at(np.pad(frame.motions[name], ((0, 0), (0, count - shapes.shape[2]))), place))
        for name, place in frame.nodes.items()
    ]
    return [FrameLine("frame", np.array([middle, place]), np.array([whole, rows])) for place, rows in ends]


def _chains(frame: ElasticFrame) -> list[list[int]]:
    """Chains of connected lines, as numbers of their nodes."""
    found: list[list[int]] = []
    for one, two in frame.lines.tolist():
        if found and found[-1][-1] == one:
            found[-1].append(two)
        else:
            found.append([one, two])
    return found


def _nearest(lines: list[FrameLine], place: Array) -> Array:
    """The node of the lines that is nearest to a place."""
    nodes = np.vstack([line.places for line in lines])
    return np.asarray(nodes[np.linalg.norm(nodes - place, axis=1).argmin()])
