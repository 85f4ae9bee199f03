"""A planar press on springs whose frame stands on mounts: the frame is a body of the plane too, and the ground is the last body.

The frame turns and shifts, with all that its bearings and guides carry, and process loads press on it as they press on the slide. The
crank's angle, gear pairs and the slide's position count from the frame. Mounts carry the mean weight of the press in the drawn pose, so
that the frame moves about its place under the static load, as in `foundation`. The flywheel acts on the frame by the torque on the crank
alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ....common.errors import PinpressError
from ....common.quantities import Array
from ....engines.planar.model import to_complex, to_world
from ....kinematics.cycle import cycle
from ....loads.mounts import Frame, Mount
from .geometry import Springs
from .plane import Lines, PlaneGeometry
from .sprung_press import SprungPress


def on_mounts(sprung: SprungPress, frame: Frame, mounts: Sequence[Mount]) -> SprungPress:
    """A press on a fixed frame, put on mounts.

    Raises:
        PinpressError: a mount has a loss factor, the plane lies askew to the mounts' axes, or nothing holds the frame.
    """
    press, geometry = sprung.press, sprung.geometry
    place = len(geometry.centers) - 1
    body = pin.Inertia(frame.mass, np.asarray(frame.centre, dtype=float), frame.tensor) + press.model.inertias[0]
    if not body.mass > 0:
        raise PinpressError("Elastic: the frame on its mounts has no mass: give that of the real one [kg]")
    center, normal = complex(to_complex(geometry.plane, body.lever)), geometry.plane.normal
    gravity = complex(to_complex(geometry.plane, press.model.gravity.linear))
    inertia, weight = np.concatenate([geometry.inertia, np.zeros(3)]), np.concatenate([geometry.weight, np.zeros(3)])
    inertia[3 * place : 3 * place + 3] = body.mass, body.mass, float(normal @ body.inertia @ normal)
    weight[3 * place : 3 * place + 2] = body.mass * gravity.real, body.mass * gravity.imag
    centers = np.append(geometry.centers, 0.0)
    centers[place] = center
    lines = geometry.lines
    arm1, arm2 = lines.arm1 - np.where(lines.first == place, center, 0.0), lines.arm2 - np.where(lines.second == place, center, 0.0)
    of_mounts, springs = _mounts(sprung, mounts, center, _static_load(sprung, center, body.mass))
    lines = Lines._make(np.concatenate(both) for both in zip(lines._replace(arm1=arm1, arm2=arm2), of_mounts, strict=True))
    shapes = np.zeros((2, len(lines.first), 0), dtype=complex)
    behind = (0, 0), (0, 3)
    return replace(
        sprung,
        geometry=replace(geometry, centers=centers, inertia=inertia, weight=weight, lines=lines, shapes=shapes, base=place),
        springs=Springs._make(np.concatenate(both) for both in zip(sprung.springs, springs, strict=True)),
        linear=sprung.linear._replace(rows=np.pad(sprung.linear.rows, behind)),
        carry=_carried(sprung, place),
        drawn=np.concatenate([sprung.drawn, np.zeros(3)]),
        fixed=sprung,
    )


def _carried(sprung: SprungPress, place: int) -> Array:
    """`SprungPress.carry` with the frame's coordinates before the crank's angle.

    Angles on which conditions lie count from the frame: where all links and the frame turn together, so do they.
    """
    press, plane, free = sprung.press, sprung.geometry.plane, sprung.free
    tied = {3 * relation.joint + 2 for relation in press.relations} | ({3 * plane.driver + 2} if sprung.geometry.rotor is None else set())
    untied = [row for row in range(3 * press.model.nv) if row not in tied]
    turning = [column for column, row in enumerate(untied) if row % 3 == 2]
    carry = np.zeros((len(sprung.drawn) + 3, free + 3))
    carry[: len(sprung.drawn), : free - 1], carry[: len(sprung.drawn), -1] = sprung.carry[:, :-1], sprung.carry[:, -1]
    carry[3 * place : 3 * place + 3, free - 1 : free + 2] = np.eye(3)
    angles = np.arange(2, 3 * place, 3)
    carry[angles, free + 1] = 1.0 - sprung.carry[angles][:, turning].sum(axis=1)
    return carry


def _static_load(sprung: SprungPress, center: complex, mass: float) -> Array:
    """Weight (3,) of frame and links on the frame about its centre of mass, the mean over a period [N, N m]."""
    geometry = sprung.geometry
    # The places of the weights are averaged over 180 poses of a turn: the mean of so smooth a curve is exact within rounding.
    motion, bodies = cycle(sprung.press, 1.0, points=180 * (sprung.press.period_turns or 1)), slice(0, geometry.rigid_size, 3)
    moved = geometry.rigid(motion)[0].mean(axis=0)
    places = geometry.centers + moved[bodies] + 1j * moved[1 : geometry.rigid_size : 3]
    weights = geometry.weight[bodies] + 1j * geometry.weight[1 : geometry.rigid_size : 3]
    whole = weights.sum() + mass * complex(to_complex(geometry.plane, sprung.press.model.gravity.linear))
    return np.array([whole.real, whole.imag, ((places - center).conj() * weights).imag.sum()])


def _mounts(sprung: SprungPress, mounts: Sequence[Mount], center: complex, load: Array) -> tuple[Lines, Springs]:
    """Lines and springs of the mounts, each along both axes of the plane, strained so that they carry a load (3,) of the frame."""
    geometry: PlaneGeometry = sprung.geometry
    axes = [to_world(geometry.plane, np.array([along])).reshape(3) for along in (1.0 + 0j, 1j)]
    columns: list[tuple[float, ...]] = []
    for number, mount in enumerate(mounts, 1):
        if mount.loss_factor:
            raise PinpressError(
                f"mount {number} has a loss factor, which belongs to vibration of one frequency; over time give it damping [N s/m], about"
                " loss_factor x stiffness / (2 pi x frequency)"
            )
        for values in (mount.stiffness, mount.damping, mount.static):
            if abs(axes[0] @ (np.array(values) * axes[1])) > 1e-9 * max(values):  # less is rounding of the plane's axes
                raise PinpressError(
                    f"the plane of {sprung.press.name} lies askew to the axes of mount {number}: let the press stand along two of them"
                )
        for axis in axes:
            along_axis = (float(axis @ (np.array(values) * axis)) for values in (mount.stiffness, mount.damping, mount.static))
            columns.append(tuple(along_axis))
    stiffness, damping, static = np.array(columns).T
    points = np.repeat([complex(to_complex(geometry.plane, np.array(mount.point))) for mount in mounts], 2)
    directions = np.tile([1.0 + 0j, 1j], len(mounts))
    arms = points - center
    rows = np.stack([directions.real, directions.imag, (directions.conj() * 1j * arms).real], axis=1)
    for values in (static, stiffness):
        matrix = rows.T @ (values[:, None] * rows)
        if not np.linalg.eigvalsh(matrix)[0] > 0 or np.linalg.cond(matrix) > 1e14:
            raise PinpressError("the mounts do not hold the frame in its plane: give them stiffness along both axes, at two places")
    strain = -static * (rows @ np.linalg.solve(rows.T @ (static[:, None] * rows), load))
    count, nothing = len(points), np.zeros(len(points))
    bodies = np.full(count, len(geometry.centers)), np.full(count, len(geometry.centers) - 1)
    rest = np.divide(strain, stiffness, out=nothing.copy(), where=stiffness > 0)
    lines = Lines(*bodies, points, arms, directions, nothing)
    return lines, Springs(stiffness, damping, rest, np.full(count, -1), np.ones(count))
