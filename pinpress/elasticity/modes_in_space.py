"""Shapes of natural vibrations of linkages in space, and where their energy is; see `vibration` for what they are.

A shape is a set of rates of all coordinates of the bodies (`press.space`), small displacements from the rigid pose. The matrix of a
body changes with them by the derivatives of the matrix, which give the vector of its turn and its kinetic energy.
"""

from __future__ import annotations

import numpy as np

from ..common.quantities import Array
from ..simulation.elastic.press.space import SpaceGeometry, SpaceState


def shapes_in_space(geometry: SpaceGeometry, state: SpaceState, moved: Array) -> Array:
    """(n, m, links, 6) displacements of all moving links in world axes, as in `ElasticRun`.

    Args:
        geometry: of the press on its springs.
        state: the n rigid poses.
        moved: (n, m, k) shapes of m modes by all coordinates.
    """
    press, changed = geometry.press, _changed_matrices(geometry, state, moved)
    n, m = moved.shape[:2]
    matrices = state.turned.matrix.reshape(n, 1, -1, 3, 3)[:, :, : geometry.count]
    spin = changed.reshape(n, m, -1, 3, 3) @ matrices.swapaxes(-1, -2)
    turn = np.stack([spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]], axis=-1)
    straight = moved[:, :, : 6 * geometry.count].reshape(n, m, -1, 6)[..., :3]
    shapes = np.zeros((n, m, press.model.nv, 6))
    for body, joint in enumerate(geometry.joints):
        shapes[:, :, joint - 1] = np.concatenate([straight[:, :, body], turn[:, :, body]], axis=2)
    for joint in range(1, press.model.nv + 1):
        if joint not in geometry.joints:  # a cross without mass moves with its carrier
            body = geometry.joints.index(int(press.model.parents[joint]))
            place = geometry.own_axes[body].T @ (press.model.jointPlacements[joint].translation - geometry.lever[body])
            arm = (matrices[:, 0, body] @ place)[:, None]
            shapes[:, :, joint - 1] = np.concatenate([straight[:, :, body] + np.cross(turn[:, :, body], arm), turn[:, :, body]], axis=2)
    return shapes


def kinetic_energy_in_space(geometry: SpaceGeometry, state: SpaceState, moved: Array, flywheel: float) -> dict[str, Array]:
    """Name of a link, or "flywheel" -> (n, m) twice its kinetic energy, of shapes as above; ``flywheel``: its inertia [kg m2]."""
    changed = _changed_matrices(geometry, state, moved)
    n, m = moved.shape[:2]
    turning = (geometry.weigh(changed.reshape(n * m, -1, 9)).reshape(changed.shape) * changed).sum(axis=3)
    straight = (moved[:, :, : 6 * geometry.count].reshape(n, m, -1, 6)[..., :3] ** 2).sum(axis=3) * geometry.mass_of
    energy = {geometry.press.link_of(joint): (turning + straight)[:, :, body] for body, joint in enumerate(geometry.joints)}
    return energy | ({"flywheel": flywheel * moved[:, :, -1] ** 2} if flywheel else {})


def _changed_matrices(geometry: SpaceGeometry, state: SpaceState, moved: Array) -> Array:
    """(n, m, B, 9) how much the matrices of the bodies change."""
    n, m, count = *moved.shape[:2], geometry.count
    by = state.turned.by[:, None, :count]
    turning = moved[:, :, : 6 * count].reshape(n, m, count, 6)[..., 3:]
    every = np.concatenate([turning, np.broadcast_to(moved[:, :, None, -1:], (n, m, count, 1))], axis=3)
    return np.asarray((every[..., None, :] @ by)[..., 0, :])
