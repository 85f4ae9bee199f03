"""Inverse kinematics: the positions of the drivers at which a frame is in given places.

The rows of the frame are solved together with those of the loops, all joints being free, from the pose of the place before. So the drivers
are found without a choice of branch, and near singular poses damped steps stay finite.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ...common.arguments import numbers, typed
from ...common.errors import PinpressError
from ...common.quantities import Array
from ...engines.mounting import Mounted, Mounting
from ...engines.spatial.frames import Frame, placed_frame
from ...linkage.assembly import close_on_branch, follow_drivers
from ...linkage.linkage import Linkage

LONGEST = 0.6  # of a joint from place to place [rad, lengths of the linkage]: with a longer one the way between them shows how it goes on
HALVINGS = 10  # most halvings of the way between two places
STARTS = 20  # random starts where a place is not reached from the one before


@typed
def inverse_kinematics(press: Linkage, frame: str, places: ArrayLike) -> Array:
    """Find where the drivers stand when a frame is in places on a path.

    The first place is reached from the linkage's home pose, each other one from the place before, so that the path stays in one assembly.
    What is found leads there: `servo_cycle` with these positions brings the frame to the places. Where there are more drivers than the
    places determine, joints move as little as possible from place to place. All joints stay within their limits. Passive coordinates
    (`Linkage.passive`), such as those of a floating base, rest where the linkage was put together, as in `servo_cycle`.

    Args:
        press: the linkage.
        frame: name of a link, as of `Linkage.placements`.
        places: (n, 3) positions of the frame's origin in world axes [m], or (n, 4, 4) homogeneous matrices from the frame to the world, as
            of `Linkage.placements`.

    Returns:
        (n, motors) positions of the motors [rad or m], which are all drivers but passive ones; (n,) where the linkage has one driver.

    Raises:
        UnknownNameError: no link of this name.
        PinpressError: a place out of reach, with how near the frame comes to it; a way between two places on which the linkage would jump
            to another assembly; an array of another shape, or matrices that are no placements.
    """
    named, targets = press.frame_named(frame), _targets(places)
    reaching, x, found = _Reaching(press, named, targets.oriented), press.closed, []
    for index, (rotation, point) in enumerate(zip(targets.rotation, targets.point, strict=True)):
        target = pin.SE3(rotation, point)
        reached = reaching.find(x, target)
        if reached is None:
            raise PinpressError(f"{frame!r} of {press.name} {_why(reaching, x, target, index)}")
        x = reached
        found.append(x[list(press.driver_indices)])
    positions = np.array(found).reshape(len(targets.point), len(press.drivers))
    if found:
        _refuse_other_assembly(press, frame, reaching, targets, positions)
    return positions[:, : len(press.motors)] if len(press.drivers) > 1 else positions[:, 0]


class _Targets(NamedTuple):
    """Places on a path: (n, 3, 3) rotations, (n, 3) points, and whether the rotations count."""

    rotation: Array
    point: Array
    oriented: bool


def _targets(places: ArrayLike) -> _Targets:
    given = numbers("places", places)
    if given.ndim == 2 and given.shape[1] == 3:
        return _Targets(np.broadcast_to(np.eye(3), (len(given), 3, 3)), given, False)
    if given.ndim != 3 or given.shape[1:] != (4, 4):
        raise PinpressError(f"places has shape {given.shape}: give (n, 3) positions [m], or (n, 4, 4) matrices from the frame to the world")
    rotation = given[:, :3, :3]
    wrong = np.abs(rotation @ rotation.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2), initial=0.0) > 1e-6  # digits of a file
    wrong |= np.linalg.det(rotation) < 0.0
    wrong |= (given[:, 3] != [0.0, 0.0, 0.0, 1.0]).any(axis=1)
    if wrong.any():
        raise PinpressError(f"places[{int(np.argmax(wrong))}] is not a placement: give [[R, p], [0, 0, 0, 1]] with a rotation matrix R")
    left, _, right = np.linalg.svd(rotation)
    return _Targets(left @ right, given[:, :3, 3], True)


class _Reaching(Mounting):
    """Mounts a linkage with a frame in a place. It holds Pinocchio's data: use it within one call."""

    def __init__(self, press: Linkage, frame: Frame, oriented: bool) -> None:
        super().__init__(press.structure)
        self.press, self.frame, self.oriented = press, frame, oriented
        self.in_joint = pin.SE3(frame.rotation, frame.point)
        self.target, self.weight = pin.SE3.Identity(), 1.0
        self.resting = press.driver_indices[len(press.motors) :]
        self.moving = np.ones(len(self.lengths))
        self.moving[list(self.resting)] = 0.0

    def equations(self, x: Array) -> tuple[Array, Array]:
        gaps, columns = super().equations(x)
        joint, size = self.frame.joint, self.structure.size
        at = self.one.placements[joint] * self.in_joint
        moved = at.translation - self.target.translation
        by_joints = np.zeros((6, len(x)))
        if joint:
            by_joints = pin.getJointJacobian(self.one.model, self.one.data, joint, pin.LOCAL_WORLD_ALIGNED)
            by_joints[:3] -= np.cross(self.one.placements[joint].rotation @ self.frame.point, by_joints[3:].T).T
        more, slopes = moved / size, by_joints[:3] / size
        if self.oriented:
            turned = self.target.rotation.T @ at.rotation
            more = np.concatenate([more, pin.log3(turned)])
            slopes = np.concatenate([slopes, pin.Jlog3(turned) @ at.rotation.T @ by_joints[3:]])
        return np.concatenate([gaps, self.weight * more]), np.concatenate([columns, self.weight * slopes])

    def reach(self, x: Array, target: pin.SE3) -> Mounted:
        """The pose that is found from joint coordinates (nv,)."""
        self.target = target
        return self.close(x, self.resting)

    def find(self, x: Array, target: pin.SE3) -> Array | None:
        """Joint coordinates (nv,) with the frame in the target, to which a way leads from these; None if none is found."""
        if (reached := self.go(x, target, HALVINGS)) is not None:
            return reached
        random = np.random.default_rng(0)
        for spread in np.linspace(0.1, 1.0, STARTS):  # from elsewhere: steps may have ended at the limit of a joint
            mounted = self.reach(x + spread * self.moving * self.lengths * random.normal(size=len(x)), target)
            if mounted.misfit <= self.closed and (led := self.led(x, mounted.position, target)) is not None:
                return led
        return None

    def go(self, x: Array, target: pin.SE3, halvings: int) -> Array | None:
        """`find`, straight to the target, in short steps or with the drivers on a straight line."""
        mounted = self.reach(x, target)
        if mounted.misfit <= self.closed:
            if np.abs((mounted.position - x) / self.lengths).max() <= LONGEST:
                return mounted.position
            if (led := self.led(x, mounted.position, target)) is not None:
                return led
        if not halvings:
            return None
        middle = self.go(x, _middle(self.at(x), target, self.oriented), halvings - 1)
        return None if middle is None else self.go(middle, target, halvings - 1)

    def led(self, x: Array, after: Array, target: pin.SE3) -> Array | None:
        """Where the drivers lead on a straight line between two poses (nv,); None if the frame then misses the target."""
        drivers, structure = list(self.structure.drivers), self.structure
        try:
            if len(drivers) > 1:
                moved = follow_drivers(self.press.engine(), structure, x, after[drivers][None], self.press.name)
            else:
                moved = close_on_branch(self.press.engine(), structure, self.press.branch, after[drivers], self.press.name).position
        except PinpressError:
            return None
        return moved[:, 0] if self.is_at(moved[:, 0], target) else None

    def is_at(self, x: Array, target: pin.SE3) -> bool:
        distance, angle = self.errors(self.at(x), target)
        return max(distance / self.press.size, angle) <= 10 * self.closed

    def at(self, x: Array) -> pin.SE3:
        """Where the frame is at joint coordinates (nv,)."""
        return pin.SE3(placed_frame(self.press.loops_in_space, self.frame, x[:, None])[0])

    def errors(self, placed: pin.SE3, target: pin.SE3) -> tuple[float, float]:
        """How far a place is from another one [m], and by what angle it is turned [rad]."""
        angle = float(np.linalg.norm(pin.log3(target.rotation.T @ placed.rotation))) if self.oriented else 0.0
        return float(np.linalg.norm(placed.translation - target.translation)), angle


def _middle(before: pin.SE3, after: pin.SE3, oriented: bool) -> pin.SE3:
    """The place half way on a straight line."""
    rotation = before.rotation @ pin.exp3(0.5 * pin.log3(before.rotation.T @ after.rotation)) if oriented else after.rotation
    return pin.SE3(rotation, 0.5 * (before.translation + after.translation))


def _why(reaching: _Reaching, x: Array, target: pin.SE3, index: int) -> str:
    """Why no pose was found for a place from joint coordinates (nv,) at the place before."""
    place = f"place {index}, {np.array2string(target.translation, precision=6)} m"
    if reaching.reach(x, target).misfit <= reaching.closed:
        return (
            f"reaches {place}, but no straight way of the drivers leads there from the {'home pose' if index == 0 else 'place before'}: the"
            " linkage locks on it, or comes to another assembly; give places in between that lead round"
        )
    reaching.weight = 1e-3  # loops first
    near = Mounting(reaching.structure).close(reaching.reach(x, target).position, reaching.resting).position
    distance, angle = reaching.errors(reaching.at(near), target)
    turned = f" and {np.degrees(angle):.3g} deg" if reaching.oriented else ""
    return (
        f"does not reach {place}: the nearest pose that was found is {1e3 * distance:.4g} mm{turned} away, at"
        f" {reaching.structure.place(near)}; give places within reach and within the limits of the joints"
    )


def _refuse_other_assembly(press: Linkage, frame: str, reaching: _Reaching, targets: _Targets, positions: Array) -> None:
    """Raise PinpressError where the drivers, moved on straight lines, do not bring the frame to its places."""
    x = press._closed_at("places", positions if len(press.drivers) > 1 else positions[:, 0])[0]
    for index, (coordinates, rotation, point) in enumerate(zip(x.T, targets.rotation, targets.point, strict=True)):
        if not reaching.is_at(coordinates, pin.SE3(rotation, point)):
            raise PinpressError(
                f"{frame!r} of {press.name} reaches place {index} in another assembly than the one that its drivers lead to on straight"
                " lines: give places in between that lead round, or load the linkage in that assembly, load(..., pose=...)"
            )
