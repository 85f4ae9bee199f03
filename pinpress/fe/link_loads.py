"""What acts on one link in some states of a motion, in its own axes: bearings, contacts, loads, gravity and the inertia field."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from ..common.arguments import expect, suitable_numbers, typed
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import FrozenMapping, read_only
from ..common.quantities import Array
from ..common.results import Tabular
from ..common.tables import Columns
from ..dynamics.extremes import at_peaks, states_at
from ..dynamics.reactions import Reactions
from ..kinematics.motion import refuse_motion_of_another
from ..kinematics.poses import bearing_points, body_of, contact_points, loaded_bodies, poses
from ..linkage.linkage import Linkage, OfPress
from .input_deck import write_deck

BALANCED = 1e-8  # share of the largest force up to which the residual is rounding error
MOST = 1000  # load cases; nobody reads more of them one by one
PEAK = "peak "


@dataclass(frozen=True, eq=False, repr=False)
class LinkLoads(OfPress, Tabular):
    """What acts on a link in n load cases, in the link's axes. All arrays are read-only.

    Forces and moments are those on the link. A force acts at its point, a moment about its point. With the body force (per mass)
    ``gravity - origin_acceleration - angular_acceleration x r - angular_velocity x (angular_velocity x r)``, where r counts from the
    link's origin, all is in balance.

    Attributes:
        press_name: name of the press.
        link: name of the link; what is fixed to it belongs to it.
        mass: its mass [kg].
        com: (3,) its centre of mass [m].
        inertia: (3, 3) about the centre of mass [kg m2].
        place: (n,) angle or position of the first driver, (n, drivers) of several [rad or m].
        remark: (n,) text such as "where the load begins", or the peak that the case is; mostly empty.
        point: name of what acts -> (n, 3) where it acts [m].
        force: name -> (n, 3) its force [N].
        moment: name -> (n, 3) its moment [N m].
        gravity: (n, 3) [m/s2].
        origin_acceleration: (n, 3) of the link's origin [m/s2].
        angular_velocity: (n, 3) [rad/s].
        angular_acceleration: (n, 3) [rad/s2].
        largest: name -> largest force in the whole motion [N], and the place of the first driver there [rad or m].
        lowest: name -> (3,) smallest components in the whole motion [N].
        highest: name -> (3,) largest components in the whole motion [N].
    """

    _press: Linkage
    link: str
    mass: float
    com: Array
    inertia: Array
    place: Array
    remark: tuple[str, ...]
    point: Mapping[str, Array]
    force: Mapping[str, Array]
    moment: Mapping[str, Array]
    gravity: Array
    origin_acceleration: Array
    angular_velocity: Array
    angular_acceleration: Array
    largest: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    lowest: Mapping[str, Array] = field(default_factory=dict)
    highest: Mapping[str, Array] = field(default_factory=dict)

    @property
    def title(self) -> str:
        force, moment = self.residual
        count = len(self.remark)
        left = f"left over {force.max():.1g} N and {moment.max():.1g} N m"
        return f"LinkLoads of {self.link} of {self.press_name}: {count} load case{'s' if count > 1 else ''}, {left}"

    def body_force(self, points: Array) -> Array:
        """Gravity and inertia force per mass (n, p, 3) at points (p, 3) of the link [m/s2]."""
        spin = self.angular_velocity[:, None]
        turning = np.cross(self.angular_acceleration[:, None], points) + np.cross(spin, np.cross(spin, points))
        return np.asarray((self.gravity - self.origin_acceleration)[:, None] - turning)

    @property
    def residual(self) -> tuple[Array, Array]:
        """Residuals of the balance in each case: sizes of forces (n,) [N], and moments (n,) about the link's origin [N m]."""
        spin, turning = self.angular_velocity, self.angular_acceleration
        weight = self.mass * self.body_force(self.com[None])[:, 0]
        tilted = turning @ self.inertia + np.cross(spin, spin @ self.inertia)
        force = weight + np.sum([*self.force.values()], axis=0)
        moments = [np.cross(self.point[name], self.force[name]) + self.moment[name] for name in self.force]
        moment = np.cross(self.com, weight) - tilted + np.sum(moments, axis=0)
        return np.linalg.norm(force, axis=1), np.linalg.norm(moment, axis=1)

    def columns(self) -> Columns:
        """A row for each force of each case in N, mm and s, with the gravity and the inertia field of its case."""
        names, n = list(self.force), len(self.remark)
        first = self._press.driver_coordinates[0]
        rows: dict[str, Array | list[str] | list[int]] = {"case": [k + 1 for k in range(n) for _ in names]}
        place = self.place.reshape(n, -1)[:, 0] * first.scale
        rows[f"{first.heads[0][0]} [{first.shown_unit}]"] = np.repeat(place, len(names))
        rows["remark"] = [remark for remark in self.remark for _ in names]
        rows["point"] = names * n

        def stacked(of: Mapping[str, Array]) -> Array:
            return np.stack([of[name] for name in names], axis=1).reshape(-1, 3)

        force = stacked(self.force)
        for head, unit, vector in (
            ("", "mm", 1e3 * stacked(self.point)),
            ("force_", "N", force),
            ("moment_", "N mm", 1e3 * stacked(self.moment)),
        ):
            rows |= {f"{head}{axis} [{unit}]": vector[:, k] for k, axis in enumerate("xyz")}
        rows["force [N]"] = np.linalg.norm(force, axis=1)
        rows["force_direction_in_xz [deg]"] = np.degrees(np.arctan2(force[:, 2], force[:, 0]))
        for name, unit, factor in (
            ("gravity", "mm/s2", 1e3),
            ("origin_acceleration", "mm/s2", 1e3),
            ("angular_velocity", "rad/s", 1.0),
            ("angular_acceleration", "rad/s2", 1.0),
        ):
            vectors = factor * np.repeat(getattr(self, name), len(names), axis=0)
            rows |= {f"{name}_{axis} [{unit}]": vectors[:, k] for k, axis in enumerate("xyz")}
        return rows

    def write_inp(self, path: str | os.PathLike[str], *, mesh: str | os.PathLike[str], nodes: Mapping[str, int]) -> None:
        """Write the load cases as steps of an input file of CalculiX or Abaqus, in N, mm, t and s.

        Gravity and inertia are a GRAV for each element, and CENTRIF. (CalculiX has no card for angular acceleration.) Within an element the
        part of the angular acceleration alpha is taken at the middle. This neglects the couple alpha x sum of m_e (dx^2 + dz^2)/12, which
        falls with the square of the elements' size. Moments are CLOADs at degrees of freedom 4 to 6: give them a node of a rigid body or
        coupling. Supports, material and sections stay in the file of the mesh, which is included.

        Args:
            path: of the file to write.
            mesh: input file with ``*NODE`` and ``*ELEMENT`` in mm, in the link's axes.
            nodes: name of each force -> node at which it acts.

        Raises:
            UnknownNameError: no force has such a name.
            PinpressError: a force has no node or one that the mesh lacks, a file cannot be read or written.
        """
        for name in nodes:
            if name not in self.force:
                raise UnknownNameError("force on the link", name, self.force)
        if missing := [name for name in self.force if name not in nodes and self.force[name].any()]:
            raise PinpressError(f"nodes lacks {', '.join(missing)}: give the node at which each force acts, nodes={{{missing[0]!r}: 1}}")
        write_deck(self, path, mesh, nodes)


@typed
def load_cases(press: Linkage, reactions: Reactions, link: str, at: str | Sequence[float] = "extremes") -> LinkLoads:
    """Cut a link free in some states of a motion.

    Args:
        press: the press.
        reactions: reactions of all its bearings to a motion.
        link: name of the link.
        at: "extremes": states with the largest force of each bearing of the link, and with the largest driving torque; "peak NAME": only
            that of one bearing; "peak torque": only that of the driving torque; "states": all states of the motion; or angles of the first
            driver [rad].

    Raises:
        PinpressError: the reactions are of another press or leave out a bearing, the link is the frame, an angle is not in the motion,
            or what acts on the link is not in balance, as with several planets drawn as one.
        UnknownNameError: no such link or bearing.
    """
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    refuse_motion_of_another(press, reactions.motion)
    body = body_of(press, link)
    if body == 0:
        raise PinpressError(f"{link} is the frame, which does not move: its loads are the forces of its bearings, with the opposite sign")
    if reactions.left_out:
        raise PinpressError(f"the reactions leave out {', '.join(reactions.left_out)}: make them without bearings=...")
    peaks = at_peaks(reactions)
    everywhere = _cut_free(press, peaks.reactions, link, body)
    found = _chosen(press, reactions, everywhere, body, at)
    force, moment = found.residual
    size = (
        max(np.linalg.norm(each, axis=1).max() for each in found.force.values())
        + found.mass * np.abs(found.body_force(found.com[None])).max()
    )
    if force.max() > BALANCED * size or moment.max() > BALANCED * size * press.size:
        raise PinpressError(
            f"what acts on {link} is not in balance: {force.max():.4g} N and {moment.max():.4g} N m remain. Load cases do not include"
            " springs in joints and planets that stand for several: take another link, or leave these out"
        )
    sizes = {name: np.linalg.norm(each, axis=1) for name, each in everywhere.force.items()}
    first = everywhere.place.reshape(len(everywhere.remark), -1)[:, 0]
    return LinkLoads(
        **{name: value for name, value in vars(found).items() if name not in ("largest", "lowest", "highest")},
        largest=FrozenMapping({name: (float(size.max()), float(first[size.argmax()])) for name, size in sizes.items()}),
        lowest=FrozenMapping({name: read_only(each.min(axis=0)) for name, each in everywhere.force.items()}),
        highest=FrozenMapping({name: read_only(each.max(axis=0)) for name, each in everywhere.force.items()}),
    )


def _chosen(press: Linkage, reactions: Reactions, everywhere: LinkLoads, body: int, at: str | Sequence[float]) -> LinkLoads:
    """The requested load cases; ``everywhere``: what acts in all states in which a force is largest or jumps."""
    if not isinstance(at, str):
        angles = suitable_numbers("at", at, "angles of the first driver [rad], or a text such as 'extremes'", (None,), len)
        return _cut_free(press, states_at(reactions, angles), everywhere.link, body)
    if at == "states":
        if (count := len(reactions.motion.crank_angle)) > MOST:
            raise PinpressError(f"the motion has {count} states: give at='extremes', or at most {MOST} angles")
        return _cut_free(press, reactions, everywhere.link, body)
    if at != "extremes" and not at.startswith(PEAK):
        raise PinpressError(f"at is {shown(at)}: give 'extremes', 'states', 'peak torque', 'peak NAME' of a bearing, or angles [rad]")
    peaks = at_peaks(reactions)
    torque = np.abs(peaks.reactions.driving_torque).reshape(len(peaks.remarks), -1).max(axis=1)
    sizes = {"torque": torque} | {name: np.linalg.norm(each, axis=1) for name, each in everywhere.force.items()}
    cases: dict[int, list[str]] = {}
    for name in sizes if at == "extremes" else [at.removeprefix(PEAK)]:
        if name not in sizes:
            raise UnknownNameError(f"force on {everywhere.link}", name, sizes)
        cases.setdefault(int(sizes[name].argmax()), []).append(name)
    chosen = sorted(cases)
    remarks = (", ".join(filter(None, [f"largest {' and '.join(cases[k])}", peaks.remarks[k]])) for k in chosen)

    def some(value: Any) -> Any:
        """The chosen rows of arrays, or of mappings of arrays."""
        if isinstance(value, Mapping):
            return FrozenMapping({name: read_only(each[chosen]) for name, each in value.items()})
        return read_only(value[chosen]) if isinstance(value, np.ndarray) else value

    kept = ("com", "inertia", "remark", "largest", "lowest", "highest")
    parts: dict[str, Any] = {name: value if name in kept else some(value) for name, value in vars(everywhere).items()}
    return LinkLoads(**parts | {"remark": tuple(remarks)})


def _cut_free(press: Linkage, reactions: Reactions, link: str, body: int) -> LinkLoads:
    """What acts on a link in all states of reactions."""
    motion, model = reactions.motion, press.model
    frame = model.frames[model.getFrameId(link, pin.BODY)].placement
    at = poses(press, motion.joint_position)
    moving = press.engine(reactions.engine).body_motion(motion.states(press), [body])
    rotation = at.rotation[body] @ frame.rotation
    origin = at.points(body, frame.translation)

    def turned(vectors: Array) -> Array:
        """Vectors (n, 3) of the world in the link's axes."""
        return read_only(np.einsum("nji,nj->ni", rotation, vectors))

    point: dict[str, Array] = {}
    force: dict[str, Array] = {}
    moment: dict[str, Array] = {}

    def add(name: str, where: Array, pushing: Array, turning: Array | None) -> None:
        point[name], force[name] = turned(where - origin), turned(pushing)
        moment[name] = turned(np.zeros_like(pushing) if turning is None else turning)

    carrier = [*list(model.parents)[1:], *(loop.joint1 for loop in press.loops)]
    for name, first, second, where in zip(press.bearings, carrier, loaded_bodies(press), bearing_points(press, at), strict=True):
        if body in (first, second):
            sign = 1.0 if body == second else -1.0
            add(name, where, sign * reactions.bearing_force[name], sign * reactions.bearing_moment[name])
    places = contact_points(press, at, motion.joint_position)
    for contact in press.contacts:
        if contact.name in reactions.bearing_force and body in (contact.first, contact.second):
            sign = 1.0 if body == contact.second else -1.0
            name = contact.name
            add(name, places[name], sign * reactions.bearing_force[name], sign * reactions.bearing_moment[name])
    for number, load in enumerate((load for load in reactions._conditions.loads if load.joint == body), 1):
        add(f"load {number}", at.points(body, load.point), load.force, load.moment)
    inertia = frame.actInv(model.inertias[body])
    shifted = moving.points(frame.translation[None])
    n = len(motion.crank_angle)
    return LinkLoads(
        _press=press,
        link=link,
        mass=float(inertia.mass),
        com=read_only(np.array(inertia.lever)),
        inertia=read_only(np.array(inertia.inertia)),
        place=motion.crank_angle,
        remark=("",) * n,
        point=FrozenMapping(point),
        force=FrozenMapping(force),
        moment=FrozenMapping(moment),
        gravity=turned(np.broadcast_to(model.gravity.linear, (n, 3))),
        origin_acceleration=turned(shifted.acceleration[0].T),
        angular_velocity=turned(moving.spin[0].T),
        angular_acceleration=turned(moving.turning[0].T),
    )
