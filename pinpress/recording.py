"""A recording: one web page that shows a press turning, with everything it needs inside the file.

The page holds Meshcat's viewer, the commands that build the scene, and a control bar of its own. It opens by double click,
without a server or a network. World axes as everywhere: metres, z up, a planar press in the x-z plane, seen from -y.
"""

import base64
import html
import importlib.resources
import importlib.util
import json
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from . import files, urdf
from .branch import predict
from .coordinates import configuration
from .errors import PinpressError

if TYPE_CHECKING:
    from .linkage import Linkage
    from .motion import Motion

Array = npt.NDArray[np.float64]

KEYS_PER_TURN = 120  # between keys 3 degrees apart a crank pin leaves its circle by 0.03 % of the crank radius
MOST_KEYS = 1800  # keeps the page of a long run below 2 MB
NOT_INSTALLED = "recordings need Meshcat, which is not installed; pip install 'pinpress[recording]'"
PRIMITIVES = ("box", "cylinder", "sphere")


def record(press: "Linkage", motion: "Motion", path: str | os.PathLike[str]) -> Path:
    """Write a self-contained page that shows the press moving, in real time, and return its path.

    A motion over one turn is closed to a loop. Long motions are thinned to `KEYS_PER_TURN` key frames per turn of the crank.
    The same press and motion give the same bytes. `#t=0.25` at the end of the page's address stops it at 0.25 s.

    Args:
        press: the linkage; its URDF's `<visual>` boxes, cylinders and spheres are drawn.
        motion: configurations with their times [s].
        path: the file to write, usually ending in `.html`. It is replaced only once the page is complete.

    Raises:
        PinpressError: no time in the motion, a value that is not finite, a shape that cannot be drawn, Meshcat not
            installed, or a path that cannot be written.
    """
    keys = _keys(motion, press.slide is not None, _turns_back(press))
    links = _links(press)
    poses = {link.frame: _poses(press.model, keys.q, link.frame) for link in links}
    scene = _pack(_commands(links, poses, keys.time))
    return files.write(path, _page(press.name, keys, _legend(links, poses), scene).encode())


@dataclass(frozen=True)
class _Keys:
    """Key frames: time from the first one [s], angle of the (first) driver [rad], slide position [m] or None, configurations (k, nq)."""

    time: Array
    crank: Array
    slide: Array | None
    q: Array


@dataclass(frozen=True)
class _Link:
    """A link that is drawn: its name, its frame in the model, and its visuals (Pinocchio geometry objects)."""

    name: str
    frame: int
    visuals: list[tuple[Any, Any]]  # geometry object, its placement in the link frame


def _turns_back(press: "Linkage") -> bool:
    """Whether the linkage is where it was after a turn of its driver; with a gear ratio it need not be."""
    if len(press.drivers) > 1 or press.branch.period is None:
        return False
    before, after = configuration(press.spatial.slots, predict(press.branch, np.array([0.0, 2 * np.pi]))).T
    return bool(np.allclose(before, after, rtol=0.0, atol=1e-9 * (1 + press.spatial.size)))


def _keys(motion: "Motion", has_slide: bool, turns_back: bool) -> _Keys:
    series = {"time": motion.time, "crank_angle": motion.crank_angle, "q": motion.q}
    if has_slide:
        series["slide_position"] = motion.slide_position
    for name, values in series.items():
        bad = ~np.isfinite(values)
        if np.size(values) == 0 or bad.any():
            where = f"is not finite at index {int(np.argwhere(bad)[0][0])}" if bad.any() else "is empty"
            raise PinpressError(f"motion.{name} {where}; record a motion that cycle or simulate returned")
    if np.any(np.diff(motion.time) <= 0):
        raise PinpressError("motion.time does not increase from point to point; order the points of the motion by time")
    time, q = motion.time - motion.time[0], np.asarray(motion.q)
    crank = np.asarray(motion.crank_angle).reshape(len(time), -1)[:, 0]  # of several drivers, the first
    last = _closing_time(time, crank) if turns_back else None
    order = np.arange(len(time))
    if last is not None:  # the first configuration once more, so that the loop has no jump
        order, time = np.append(order, 0), np.append(time, last)
        crank = np.append(crank, crank[0] + np.sign(crank[-1] - crank[0]) * 2 * np.pi)
    most = min(KEYS_PER_TURN * max(1, np.ceil(np.ptp(crank) / (2 * np.pi) - 1e-6)), MOST_KEYS) + 1
    kept = np.rint(np.linspace(0, len(order) - 1, int(min(len(order), most)))).astype(int)  # the first and the last among them
    slide = np.asarray(motion.slide_position)[order][kept] if has_slide else None
    return _Keys(time[kept], crank[kept], slide, q[order][kept])


def _closing_time(time: Array, crank: Array) -> float | None:
    """When the first point comes round again [s], if the motion is one turn without its end point; else None."""
    turned = abs(crank[-1] - crank[0])
    gap, step = 2 * np.pi - turned, np.max(np.abs(np.diff(crank)), initial=0.0)
    return float(time[-1] * (1 + gap / turned)) if len(time) > 2 and 1e-6 * step < gap <= 1.001 * step else None


def _links(press: "Linkage") -> list[_Link]:
    model, text = press.model, press.text.decode("utf-8-sig")
    for element in urdf.tree(press.file, text.encode()).all("link"):
        shapes = [shape for visual in element.all("visual") for geometry in visual.all("geometry") for shape in geometry.children]
        for shape in shapes:  # checked here: Pinocchio would drop a capsule and the link's other visuals in silence
            if shape.tag not in PRIMITIVES:
                name = element.get("name")
                raise PinpressError(f"link {name!r}: a recording cannot draw <{shape.tag}>; use <box>, <cylinder> and <sphere>")
    drawn: dict[int, _Link] = {}
    for visual in pin.buildGeomFromUrdfString(model, text, pin.GeometryType.VISUAL).geometryObjects:
        frame = model.frames[visual.parentFrame]
        link = drawn.setdefault(visual.parentFrame, _Link(frame.name, visual.parentFrame, []))
        link.visuals.append((visual, frame.placement.actInv(visual.placement)))
    if not drawn:
        raise PinpressError(f"press {press.name!r} has nothing to draw; give its links <visual> elements")
    return list(drawn.values())


def _poses(model: pin.Model, q: Array, frame: int) -> Array:
    """Pose of a frame over the keys, (k, 7): position [m] and quaternion x, y, z, w in world axes."""
    data = model.createData()
    joint, placement = model.frames[frame].parentJoint, model.frames[frame].placement
    poses = np.empty((len(q), 7))
    for pose, at in zip(poses, q, strict=True):
        pin.forwardKinematics(model, data, at)
        pose[:] = pin.SE3ToXYZQUAT(data.oMi[joint] * placement)
    # q and -q are one rotation, but interpolating between them would turn the link the long way round
    flips = np.where(np.sum(poses[1:, 3:] * poses[:-1, 3:], axis=1) < 0, -1.0, 1.0)
    poses[1:, 3:] *= np.cumprod(flips)[:, None]
    return poses


def _moves(poses: Array) -> bool:
    return bool(np.any(np.ptp(poses, axis=0) > 1e-9))


def _commands(links: list[_Link], poses: dict[int, Array], time: Array) -> Iterator[dict[str, Any]]:
    """Meshcat's commands in the order in which the page handles them: the animation refers to groups, so it comes last."""
    clips = []
    for i, link in enumerate(links):
        path, pose = f"/press/{i}", poses[link.frame]  # by index: a link may have any name
        yield _transform(path, pin.XYZQUATToSE3(pose[0]).homogeneous)
        for j, (visual, placement) in enumerate(link.visuals):
            shape, upright = _shape(visual.geometry)
            yield _object(f"{path}/{j}", shape, visual.meshColor)
            yield _transform(f"{path}/{j}", placement.homogeneous @ upright)
        if _moves(pose):
            tracks = [_track("position", "vector3", time, pose[:, :3]), _track("quaternion", "quaternion", time, pose[:, 3:])]
            clips.append({"path": path, "clip": {"name": "default", "fps": 1, "tracks": tracks}})
    yield {"type": "set_animation", "path": "", "animations": clips, "options": {"play": False, "repetitions": 1}}


def _transform(path: str, matrix: Array) -> dict[str, Any]:
    return {"type": "set_transform", "path": path, "matrix": matrix.T.ravel().tolist()}  # three.js stores columns


def _track(name: str, kind: str, time: Array, values: Array) -> dict[str, Any]:
    return {"name": f".{name}", "type": kind, "times": time.tolist(), "values": values.ravel().tolist()}


def _object(path: str, shape: dict[str, Any], rgba: Array) -> dict[str, Any]:
    colour, alpha = int(_hexadecimal(rgba), 16), float(rgba[3])
    material = {"uuid": "m", "type": "MeshPhongMaterial", "color": colour, "opacity": alpha, "transparent": alpha < 1}
    material |= {"specular": 0x303030, "shininess": 25}
    mesh = {"uuid": "o", "type": "Mesh", "geometry": "g", "material": "m"}
    body = {"metadata": {"version": 4.5, "type": "Object"}, "geometries": [shape | {"uuid": "g"}], "materials": [material], "object": mesh}
    return {"type": "set_object", "path": path, "object": body}


def _hexadecimal(rgba: Array) -> str:
    return "".join(f"{round(255 * c):02x}" for c in np.clip(rgba[:3], 0, 1).tolist())


def _shape(shape: Any) -> tuple[dict[str, Any], Array]:
    """A primitive for three.js, and the rotation from three.js's axes (cylinders lie along y) to URDF's (along z)."""
    if hasattr(shape, "halfSide"):
        x, y, z = (2 * float(half) for half in shape.halfSide)
        return {"type": "BoxGeometry", "width": x, "height": y, "depth": z}, np.eye(4)
    radius = float(shape.radius)
    if not hasattr(shape, "halfLength"):
        return {"type": "SphereGeometry", "radius": radius, "widthSegments": 48, "heightSegments": 32}, np.eye(4)
    body = {"type": "CylinderGeometry", "radiusTop": radius, "radiusBottom": radius, "height": 2 * float(shape.halfLength)}
    return body | {"radialSegments": 64}, np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


def _legend(links: list[_Link], poses: dict[int, Array]) -> list[dict[str, str]]:
    """The moving links with the colour that most of their visuals have."""
    moving = ((link.name, Counter(_hexadecimal(v.meshColor) for v, _ in link.visuals)) for link in links if _moves(poses[link.frame]))
    return [{"name": name, "colour": "#" + colours.most_common(1)[0][0]} for name, colours in moving]


def _pack(commands: Iterable[dict[str, Any]]) -> list[str]:
    """Commands as the viewer takes them: MessagePack, in base64 for the page."""
    try:
        import umsgpack
    except ImportError as error:
        raise PinpressError(NOT_INSTALLED) from error
    packed = (umsgpack.packb(command, force_float_precision="single") for command in commands)
    return [base64.b64encode(command).decode("ascii") for command in packed]


def _viewer() -> dict[str, str]:
    """Meshcat's viewer and its licences. The package is found but not imported, as it would bring a web server with it."""
    spec = importlib.util.find_spec("meshcat")
    if spec is None or not spec.submodule_search_locations:
        raise PinpressError(NOT_INSTALLED)
    root = Path(spec.submodule_search_locations[0]) / "viewer"
    licences = "\n".join((root / name).read_text("utf-8") for name in ("LICENSE", "dist/main.min.js.LICENSE.txt"))
    script = re.sub(r"<(?=/script|!--)", r"\\x3c", (root / "dist/main.min.js").read_text("utf-8"), flags=re.IGNORECASE)
    return {"viewer": script, "licences": html.escape(licences, quote=False)}


def _page(name: str, keys: _Keys, legend: list[dict[str, str]], scene: list[str]) -> str:
    data = {
        "time": keys.time.round(7).tolist(),  # s
        "crank": np.degrees(keys.crank).round(4).tolist(),  # deg
        "slide": None if keys.slide is None else (1e3 * keys.slide).round(3).tolist(),  # mm
        "legend": legend,
        "scene": scene,
    }
    fields = _viewer() | {"title": html.escape(name), "data": json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")}
    template = importlib.resources.files(__package__).joinpath("recording_page.html").read_text("utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda match: fields[match[1]], template)  # one pass: what is filled in is not searched again
