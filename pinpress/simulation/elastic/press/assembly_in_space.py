"""A linkage in space taken apart into bodies on springs: `press_in_space`.

A pin holds its bodies together in three directions, and against turning across its axis; a guide in two directions, and against turning
about three axes; a ball joint in three directions; a weld in all six. Links without mass that only make a joint of several pins through one
point, such as the cross of a universal joint, are no bodies: their pins are one bearing, softer than each of them, as springs in series
are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ....common.errors import PinpressError, shown
from ....common.quantities import Array
from ....kinematics.motion import Motion
from ....linkage.linkage import Linkage
from ..description import Elastic
from ..preloaded_joint import JointSpring, PreloadedJoint
from ..yielding import LIGHTEST, by_bearing, dampers_by_bearing
from .geometry import LinearSprings, Springs, in_columns
from .space import LinesInSpace, SpaceGeometry
from .sprung_press import SprungPress
from .turning import nominal_turns


class _Joint(NamedTuple):
    """A bearing with springs: a "pin", "guide", "ball", "universal" or "weld", of one member, or of the pins of a cross.

    Points [m] and axes (as columns) of each end are in the frame of its Pinocchio's joint, 0 for the frame. The first axis is that of a pin
    or guide; of a universal joint it is the pin on this side.
    """

    kind: str
    members: tuple[int, ...]
    first: int
    second: int
    point1: Array
    point2: Array
    axes1: Array
    axes2: Array


def press_in_space(press: Linkage, elastic: Elastic, reference: Motion) -> SprungPress:
    """A linkage in space on its springs and dampers, with its `SprungPress.reference`.

    Raises:
        UnknownNameError: the linkage has no such bearing.
        PinpressError: it has gear pairs, its driver is not carried by the frame, a link has no mass, a bearing lacks a stiffness, a link is
            held by nothing, or ``elastic`` has parts that motions in space do not know.
    """
    _refuse_unsuitable(press, elastic)
    joints = _joints(press, _light(press))
    stiff = _with_springs(_bodies(press, _light(press)), joints, elastic, reference)
    _refuse_loose(stiff)
    return stiff.with_dampers(elastic.damping_ratio, dampers_by_bearing(press, elastic.dampers))


def _refuse_unsuitable(press: Linkage, elastic: Elastic) -> None:
    unsuitable = {
        "rods": (bool(elastic.stiffness.rods), "give what a rod yields to the stiffness of its bearings"),
        "shaft": (elastic.stiffness.shaft is not None, "leave it out"),
        "frame": (elastic.stiffness.frame is not None, "leave it and crown_mass out"),
        "flexible_links": (bool(elastic.flexible_links), "leave them out"),
        "mounts": (elastic.mounted_frame is not None, "leave them out"),
        "clearances": (bool(elastic.clearances), "leave them out"),
    }
    for name, (is_given, instead) in unsuitable.items():
        if is_given:
            raise PinpressError(f"{press.name} moves in space, and elastic motion in space knows no {name}: {instead}")
    if press.relations:
        raise PinpressError(
            f"{press.name} moves in space and has the gear pair {shown(press.relations[0].name)}, which elastic motion has only in a plane"
        )
    if press.model.parents[press.driver_indices[0] + 1]:
        raise PinpressError(
            f"driver {shown(press.driver)} of {press.name} is carried by a link that moves: elastic motion in space takes a"
            " crank on the frame"
        )


# ---------------------------------------------------------------------------------------------------------------------------------- bodies


def _light(press: Linkage) -> set[int]:
    """Pinocchio's joints whose bodies have no mass."""
    masses = np.array([press.model.inertias[j].mass for j in range(1, press.model.njoints)])
    return {j for j, mass in enumerate(masses, 1) if not mass > LIGHTEST * masses.max()}


def _bodies(press: Linkage, light: set[int]) -> SpaceGeometry:
    """The bodies, with no springs yet."""
    model, driver = press.model, press.driver_indices[0] + 1
    joints = tuple(j for j in range(1, model.njoints) if j not in light)
    if driver in light:
        raise _massless(press, driver)
    own_axes = np.array([_with_third(press.axes[j - 1].direction) if j == driver else np.eye(3) for j in joints])
    shape = []
    for joint, axes in zip(joints, own_axes, strict=True):
        inertia = axes.T @ model.inertias[joint].inertia @ axes
        if not np.linalg.eigvalsh(inertia)[0] > 0:
            raise _massless(press, joint)
        shape.append(0.5 * np.trace(inertia) * np.eye(3) - inertia)
    return SpaceGeometry(
        press=press,
        joints=joints,
        crank_body=joints.index(driver),
        own_axes=own_axes,
        lever=np.array([model.inertias[j].lever for j in joints]),
        mass_of=np.array([model.inertias[j].mass for j in joints]),
        shape=np.array(shape),
        gravity=np.array(model.gravity.linear),
        nominal=nominal_turns(press, (*joints, 0), np.concatenate([own_axes, np.eye(3)[None]])),
        lines=LinesInSpace(*np.zeros((7, 0))),
    )


def _massless(press: Linkage, joint: int) -> PinpressError:
    return PinpressError(
        f"link {shown(press.link_of(joint))} of {press.name} has no mass or no moment of inertia about some axis, so that nothing says how"
        " it moves on its springs: give it those of the real part"
    )


def _with_third(axis: Array) -> Array:
    """Axes as columns, the third one given."""
    first, second = _across(axis)
    return np.column_stack([first, second, axis])


def _across(axis: Array) -> tuple[Array, Array]:
    """Two axes across one, which complete it to a right-handed frame (axis last)."""
    first = np.cross(np.eye(3)[int(np.abs(axis).argmin())], axis)
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


# -------------------------------------------------------------------------------------------------------------------------------- bearings


def _joints(press: Linkage, light: set[int]) -> list[_Joint]:
    """All bearings, in the order of their last members."""
    bearings = [_tree_joint(press, light, j) for j in range(1, press.model.njoints) if j not in light]
    for place, loop in enumerate(press.loops, press.model.nv):
        for joint in (loop.joint1, loop.joint2):
            if joint in light:
                raise _massless(press, joint)
        kind = {"spherical": "ball", "revolute": "pin", "fixed": "weld"}[loop.type]
        bearings.append(_Joint(kind, (place,), loop.joint1, loop.joint2, loop.point1, loop.point2, loop.rotation1, loop.rotation2))
    used = {member for bearing in bearings for member in bearing.members}
    for joint in sorted(light):
        if joint - 1 not in used:
            raise _massless(press, joint)
    return bearings


def _tree_joint(press: Linkage, light: set[int], joint: int) -> _Joint:
    """The bearing by which a body hangs in the tree, with the crosses between it and the body that carries it."""
    model, chain = press.model, [joint]
    while model.parents[chain[0]] in light:
        chain.insert(0, int(model.parents[chain[0]]))
    first, axes = int(model.parents[chain[0]]), [press.axes[j - 1] for j in chain]
    place = model.jointPlacements[chain[0]]
    for before, after in pairwise(chain):
        step, along = model.jointPlacements[after].translation, press.axes[before - 1].direction
        carried = [j for j in range(1, model.njoints) if model.parents[j] == before]
        looped = any(before in (loop.joint1, loop.joint2) for loop in press.loops)
        meets = np.linalg.norm(np.cross(step, along)) <= 1e-9 * press.size  # more is not rounding of the file's numbers
        if not (meets and carried == [after] and not looped and press.axes[before - 1].turns and press.axes[after - 1].turns):
            raise _massless(press, before)
        place = place * model.jointPlacements[after]
    if len(chain) > 3:
        raise _massless(press, chain[0])
    kind = ("pin" if axes[0].turns else "guide", "universal", "ball")[len(chain) - 1]
    own = axes[-1].direction
    one = model.jointPlacements[chain[0]].rotation @ axes[0].direction
    if kind in ("pin", "guide"):
        across = np.column_stack([own, *_across(own)])
        axes1, axes2 = place.rotation @ across, across
    else:
        axes1, axes2 = np.column_stack([one, *_across(one)]), np.column_stack([own, *_across(own)])
    return _Joint(kind, tuple(j - 1 for j in chain), first, joint, np.array(place.translation), np.zeros(3), axes1, axes2)


# --------------------------------------------------------------------------------------------------------------------------------- springs


def _with_springs(bare: SpaceGeometry, joints: Sequence[_Joint], elastic: Elastic, reference: Motion) -> SprungPress:
    press, frame, stiffness = bare.press, bare.count, elastic.stiffness
    every = [member for bearing in joints for member in bearing.members]
    with_moments = [member for bearing in joints if bearing.kind != "ball" for member in bearing.members]
    ball, yields = "a ball joint and holds no moment", ", which moves in space: there every bearing yields"
    directions, turning_too = " in all directions it holds", " and pins, guides, crosses and welds also against turning"
    straight = by_bearing(press, "bearings", stiffness.bearings, "N/m", every, holds_none=ball, yields=f"{yields},{directions}")
    twisting = by_bearing(press, "moments", stiffness.moments, "N m/rad", with_moments, holds_none=ball, yields=f"{yields},{turning_too}")
    body_of = {0: frame, **{joint: body for body, joint in enumerate(bare.joints)}}
    axes = np.concatenate([bare.own_axes, np.eye(3)[None]])
    centres = np.concatenate([bare.lever, np.zeros((1, 3))])
    lines: list[tuple[int, int, Array, float, Array, Array, float]] = []
    springs: list[tuple[float, float, float, int, float]] = []
    alike, preloaded = list(range(len(press.bearings))), []
    for bearing in joints:
        first, second, name = body_of[bearing.first], body_of[bearing.second], bearing.members[-1]
        arm1, arm2 = axes[first].T @ (bearing.point1 - centres[first]), axes[second].T @ (bearing.point2 - centres[second])
        axes1, axes2 = axes[first].T @ bearing.axes1, axes[second].T @ bearing.axes2
        turning = float(first != frame)
        k = 1 / sum(1 / straight[member] for member in bearing.members)
        joint = stiffness.bearings[press.bearings[name]]
        if isinstance(joint, PreloadedJoint):  # of a guide; each of its two directions is nearest to another axis of what carries it
            for number, direction in enumerate(bearing.axes1.T[1:]):
                part = f"{press.bearings[name]} {'xyz'[np.abs(direction).argmax()]}"
                preloaded.append(JointSpring(part, name, joint, number=number))
        for direction in axes1.T[1:] if bearing.kind == "guide" else np.eye(3):
            lines.append((first, second, direction, turning * (bearing.kind == "guide"), arm1, arm2, 1.0))
            springs.append((k, 0.0, 0.0, name, 1.0))
        if bearing.kind != "ball":
            k = 1 / sum(1 / twisting[member] for member in bearing.members)
            # The cosines between these axes of both ends are twists. A weld and a guide twist about three axes.
            twists = {"pin": ((0, 1), (0, 2)), "universal": ((0, 0),)}.get(bearing.kind, ((0, 1), (1, 2), (2, 0)))
            for one, other in twists:
                lines.append((first, second, axes1[:, one], turning, np.zeros(3), axes2[:, other], 0.0))
                springs.append((k, 0.0, 0.0, name, 0.0))
        for member in bearing.members:
            alike[member] = name
    geometry = replace(bare, lines=in_columns(LinesInSpace, lines))
    return SprungPress(
        press=press,
        elastic=elastic,
        geometry=geometry,
        springs=in_columns(Springs, springs),
        linear=LinearSprings(np.zeros((0, bare.size)), np.zeros(0), np.zeros(0), np.zeros(0), ()),
        carry=bare.carry,
        drawn=np.zeros(bare.size),
        reference=reference,
        alike=tuple(alike),
        joints=tuple(preloaded),
    )


def _refuse_loose(sprung: SprungPress) -> None:
    """Raise PinpressError where a body can move without a spring that holds it."""
    if not sprung.frequencies[0] > 1e-7 * sprung.frequencies[-1]:  # a root of rounding, which is 1e-15
        raise PinpressError(
            f"a link of {sprung.press.name} can move or spin without a spring that holds it, as a rod between two ball joints spins about"
            " its line: give one of its ends a universal joint"
        )
