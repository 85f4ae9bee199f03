"""Links drawn in their elastic positions, with magnified displacements."""

from __future__ import annotations

import numpy as np

from ..common.quantities import Array
from ..engines.planar.model import to_world
from ..kinematics.poses import Poses
from ..linkage.linkage import Linkage
from ..simulation.elastic.press.plane import DrawnBodies

SEEN = 0.05  # the largest displacement is drawn as at most this share of the linkage's size
IN_SPACE = 6  # components of a link's displacement in space: three of its centre of mass, and its rotation vector
FACTORS = (1.0, 2.0, 5.0)  # magnifications are these numbers times powers of ten


def magnification(press: Linkage, displacement: Array) -> float:
    """A round magnification, at least 1, for displacements (k, links, 3 or 6); see `ElasticRun.displacement`."""
    straight = 3 if displacement.shape[-1] == IN_SPACE else 2
    largest = float(np.abs(displacement[..., :straight]).max(initial=0.0))
    wanted = SEEN * press.size / largest if largest > 0 else 1.0
    power = 10.0 ** np.floor(np.log10(max(wanted, 1.0)))
    return float(max(factor * power for factor in FACTORS if factor * power <= max(wanted, 1.0)))


def displaced(press: Linkage, at: Poses, displacement: Array) -> Poses:
    """Poses of the bodies of all joints, with displacements (k, links, 3 or 6) of their centres of mass and their rotations added."""
    rotation, position = at.rotation.copy(), at.position.copy()
    shift, turn = displacement[..., :3], displacement[..., 3:]
    if displacement.shape[-1] != IN_SPACE:
        plane = DrawnBodies(press).plane
        normal = np.cross(*(to_world(plane, np.array([axis]))[0] for axis in (1.0 + 0j, 1j)))
        shift, turn = to_world(plane, displacement[..., 0] + 1j * displacement[..., 1]), displacement[..., 2:3] * normal
    for body in range(press.model.nv):
        centre = at.points(body + 1, press.model.inertias[body + 1].lever)
        rotations = rotation_matrices(turn[:, body])
        rotation[body + 1] = rotations @ at.rotation[body + 1]
        arm = at.position[body + 1] - centre
        position[body + 1] = centre + shift[:, body] + (rotations @ arm[:, :, None])[:, :, 0]
    return Poses(rotation, position)


def rotation_matrices(turn: Array) -> Array:
    """Rotation matrices (k, 3, 3) of rotation vectors (k, 3) (Rodrigues' formula)."""
    angle = np.linalg.norm(turn, axis=1)
    axis = turn / np.where(angle > 0, angle, 1.0)[:, None]
    across = np.zeros((len(turn), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        across[:, k, j], across[:, j, k] = axis[:, i], -axis[:, i]
    return np.asarray(np.eye(3) + np.sin(angle)[:, None, None] * across + (1 - np.cos(angle))[:, None, None] * (across @ across))
