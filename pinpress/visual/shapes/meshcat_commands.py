"""Bodies and their motion as commands for Meshcat's viewer."""

import base64
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from ...common.errors import PinpressError
from ...common.quantities import Array
from ...kinematics.poses import Poses
from ...linkage.linkage import Linkage
from ..pages import NO_MESHCAT
from .appearance import ShownLink
from .solids import Box, Cylinder, Plate, Shape, TriangleMesh

LARGEST = float(np.finfo(np.float32).max)


def body_poses(press: Linkage, at: Poses, frames: Sequence[int]) -> Array:
    """(frames, k, 7) poses of frames in the key frames: position [m] and quaternion x, y, z, w in world axes."""
    poses = np.empty((len(frames), at.position.shape[1], 7))
    turned = np.empty((*poses.shape[:2], 3, 3))
    for frame, pose, rotation in zip((press.model.frames[frame] for frame in frames), poses, turned, strict=True):
        pose[:, :3] = at.points(frame.parentJoint, frame.placement.translation)
        np.matmul(at.rotation[frame.parentJoint], frame.placement.rotation, out=rotation)
    poses[..., 3:] = _quaternions(turned.reshape(-1, 3, 3)).reshape(*poses.shape[:2], 4)
    # q and -q are the same rotation, but an interpolation between them would turn the link the long way round
    flips = np.where(np.sum(poses[:, 1:, 3:] * poses[:, :-1, 3:], axis=2) < 0, -1.0, 1.0)
    poses[:, 1:, 3:] *= np.cumprod(flips, axis=1)[..., None]
    return poses


def _quaternions(rotations: Array) -> Array:
    """(k, 4) quaternions x, y, z, w of rotations (k, 3, 3), from the largest component, because the others are divided by it."""
    r = rotations.reshape(-1, 9).T
    squares = np.array([1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8], 1 - r[0] - r[4] + r[8], 1 + r[0] + r[4] + r[8]])
    products = np.empty((4, 4, len(rotations)))  # four times the products of two components
    for (i, j), value in zip(
        ((0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)),
        (r[1] + r[3], r[2] + r[6], r[5] + r[7], r[7] - r[5], r[2] - r[6], r[3] - r[1]),
        strict=True,
    ):
        products[i, j] = products[j, i] = value
    products[range(4), range(4)] = squares
    largest = squares.argmax(axis=0)
    column = products[largest, :, range(len(rotations))]
    return np.asarray(column / np.linalg.norm(column, axis=1, keepdims=True))


def moves(poses: Array) -> bool:
    """Whether poses (k, 7) differ by more than rounding errors."""
    return bool(np.any(np.ptp(poses, axis=0) > 1e-9))


def commands(bodies: Iterable[ShownLink], poses: dict[str, Array], time: Array) -> Iterator[dict[str, Any]]:
    """Commands in the order in which the page handles them: the animation refers to groups, so it comes last.

    Args:
        bodies: the links that are shown.
        poses: name of a body -> (k, 7) poses, see `body_poses`.
        time: (k,) times of the key frames [s].

    Raises:
        PinpressError: a shape is too large for single precision.
    """
    clips = []
    for i, body in enumerate(bodies):
        path, pose = f"/press/{i}", poses[body.name]  # by index, because a link may have any name
        yield _transform(path, pin.XYZQUATToSE3(pose[0]).homogeneous)
        for j, part in enumerate(body.parts):
            shape, turned = _geometry(part.shape)
            _refuse_unseen([shape, part.placement], f"a visual of link {body.name!r}")
            yield _object(f"{path}/{j}", shape, part.rgba)
            yield _transform(f"{path}/{j}", part.placement @ turned)
        if moves(pose):
            tracks = [_track("position", "vector3", time, pose[:, :3]), _track("quaternion", "quaternion", time, pose[:, 3:])]
            clips.append({"path": path, "clip": {"name": "default", "fps": 1, "tracks": tracks}})
    yield {"type": "set_animation", "path": "", "animations": clips, "options": {"play": False, "repetitions": 1}}


def pack(commands: Iterable[dict[str, Any]]) -> list[str]:
    """Commands in the viewer's format: MessagePack, in base64 for the page.

    Raises:
        PinpressError: Meshcat is not installed, a number is too large for single precision, in which the viewer computes, or different
            times are equal in single precision.
    """
    try:
        import umsgpack  # optional, installed with Meshcat
    except ImportError as error:
        raise PinpressError(NO_MESHCAT) from error

    def extended(array: Array) -> Any:
        """An array in one of Meshcat's extension types of MessagePack, of float32 or uint32."""
        if array.dtype.kind == "f":
            with np.errstate(all="ignore"):  # numbers that overflow were refused before
                return umsgpack.Ext(0x17, array.astype("<f4").tobytes())
        return umsgpack.Ext(0x16, array.astype("<u4").tobytes())

    handlers, packed = {np.ndarray: extended}, []
    for command in commands:
        _refuse_unseen(command, command["path"] or "the motion")
        packed.append(umsgpack.packb(command, force_float_precision="single", ext_handlers=handlers))
    return [base64.b64encode(command).decode("ascii") for command in packed]


def _refuse_unseen(value: Any, what: str) -> None:
    """Raise PinpressError if a number of a command overflows single precision, or if different times of a motion are equal in it."""
    if isinstance(value, dict):
        for name, part in value.items():
            _refuse_unseen(part, {"times": "the time of the motion", "values": "a pose of the motion"}.get(name, what))
        if "times" in value and not (np.diff(value["times"].astype("<f4")) > 0).all():
            raise PinpressError(f"the times of the motion, up to {value['times'].max():g} s, are too near to each other to be shown")
    elif isinstance(value, list):
        for part in value:
            _refuse_unseen(part, what)
    elif isinstance(value, float | np.ndarray) and not (largest := float(np.abs(value).max(initial=0.0))) <= LARGEST:
        raise PinpressError(f"{what} is {largest:g}: a page shows numbers up to {LARGEST:.1g}; give smaller numbers")


def hexadecimal(rgba: Array) -> str:
    """Red, green and blue as six hexadecimal digits."""
    return "".join(f"{round(255 * c):02x}" for c in np.clip(rgba[:3], 0, 1).tolist())


def _transform(path: str, matrix: Array) -> dict[str, Any]:
    return {"type": "set_transform", "path": path, "matrix": matrix.T.ravel().tolist()}  # three.js stores columns


def _track(name: str, kind: str, time: Array, values: Array) -> dict[str, Any]:
    return {"name": f".{name}", "type": kind, "times": time, "values": values.ravel()}


def _object(path: str, shape: dict[str, Any], rgba: Array) -> dict[str, Any]:
    colour, alpha = int(hexadecimal(rgba), 16), float(rgba[3])
    material = {"uuid": "m", "type": "MeshPhongMaterial", "color": colour, "opacity": alpha, "transparent": alpha < 1}
    material |= {"specular": 0x303030, "shininess": 25, "flatShading": shape["type"] == "BufferGeometry"}
    mesh = {"uuid": "o", "type": "Mesh", "geometry": "g", "material": "m"}
    body = {"metadata": {"version": 4.5, "type": "Object"}, "geometries": [shape | {"uuid": "g"}], "materials": [material], "object": mesh}
    return {"type": "set_object", "path": path, "object": body}


def _geometry(shape: Shape) -> tuple[dict[str, Any], Array]:
    """A shape for three.js, and the rotation from three.js's axes to ours."""
    if isinstance(shape, Box):
        return dict(zip(("type", "width", "height", "depth"), ("BoxGeometry", *shape.size), strict=True)), np.eye(4)
    if isinstance(shape, Plate):
        shape = shape.mesh()
    if isinstance(shape, TriangleMesh):
        attributes = {"position": {"itemSize": 3, "type": "Float32Array", "array": shape.vertices.ravel(), "normalized": False}}
        index = {"itemSize": 1, "type": "Uint32Array", "array": shape.faces.ravel(), "normalized": False}
        return {"type": "BufferGeometry", "data": {"attributes": attributes, "index": index}}, np.eye(4)
    if isinstance(shape, Cylinder):
        body = {"type": "CylinderGeometry", "radiusTop": shape.radius, "radiusBottom": shape.radius, "height": shape.length}
        upright = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])  # cylinders of three.js lie along y, ours along z
        return body | {"radialSegments": 64}, upright
    return {"type": "SphereGeometry", "radius": shape.radius, "widthSegments": 48, "heightSegments": 32}, np.eye(4)
