"""What links look like: visuals against Pinocchio's own reading of them, and plain shapes against Pinocchio's kinematics: a pin is in both
of the links that it joins, whatever the crank angle."""

import dataclasses
import itertools
import os
import re
import struct
from importlib.metadata import files
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, given
from numpy.testing import assert_allclose, assert_array_equal
from support import texts
from support.exploring import examples
from support.generators.random_linkages import drawn, linkages
from support.generators.random_linkages import four_bar as planar_four_bar
from support.generators.small_linkages import two_cranks
from support.generators.spatial_linkages import bennett, bricard, four_bar
from support.in_browser import data_in
from support.oracles import cassie
from support.presses.two_servos import TWO_SERVOS

import pinpress as pp
from pinpress.balancing import Counterweight, with_counterweights
from pinpress.linkage.document import Document
from pinpress.visual.shapes import appearance
from pinpress.visual.shapes.appearance import bodies
from pinpress.visual.shapes.solids import Box, Cylinder, Plate, Sphere, TriangleMesh, corners, half_disc, rounded_plate, volume_and_centre
from pinpress.visual.shapes.stand_ins import ShaftFlywheel

STATES = 24
STEEL = (0.90, 0.91, 0.92, 1.0)


def bare(press: Any, *links: str) -> Any:
    """A press without the visuals of these links, or of all."""
    text = press.text.decode()
    for link in links or press.links:
        start = text.index(f'<link name="{link}">')
        end = text.index("</link>", start)
        text = text[:start] + re.sub("<visual.*?</visual>", "", text[start:end], flags=re.DOTALL) + text[end:]
    return with_text(press, text.encode())


def with_text(press: Any, text: bytes) -> Any:
    """The linkage with another text of its URDF."""
    return dataclasses.replace(press, document=Document(press.file, text))


def loaded(folder: Path, text: str) -> Any:
    file = folder / "press.urdf"
    file.write_text(text, encoding="utf-8")
    return pp.load(file)


def positions(press: Any) -> Any:
    return pp.cycle(press, speed=1.0, points=STATES).joint_position


def within(shape: Any, points: Any) -> Any:
    """Whether points (n, 3) in a shape's own axes are in it, but for rounding."""
    slack = 1e-9
    if isinstance(shape, Box):
        return np.all(np.abs(points) <= np.array(shape.size) / 2 + slack, axis=1)
    if isinstance(shape, Sphere):
        return np.linalg.norm(points, axis=1) <= shape.radius + slack
    if isinstance(shape, Plate):
        along = np.roll(shape.outline, -1, axis=0) - shape.outline
        left = np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(np.linalg.norm(along, axis=1), 1e-12)[:, None]
        inside = np.all(points[:, :2] @ left.T >= np.sum(left * shape.outline, axis=1) - slack, axis=1)
        return inside & (np.abs(points[:, 2]) <= shape.thickness / 2 + slack)
    return (np.hypot(points[:, 0], points[:, 1]) <= shape.radius + slack) & (np.abs(points[:, 2]) <= shape.length / 2 + slack)


class Scene:
    """Bodies of a press in one configuration, placed by Pinocchio."""

    def __init__(self, press: Any, shown: Any, position: Any) -> None:
        self.press, self.model, self.data = press, press.model, press.model.createData()
        q = pin.neutral(self.model)
        for joint, x in zip(list(self.model.joints)[1:], position, strict=True):
            q[joint.idx_q : joint.idx_q + joint.nq] = (np.cos(x), np.sin(x)) if joint.nq == 2 else x
        pin.framesForwardKinematics(self.model, self.data, q)
        self.parts = [(b.name, p, self.data.oMf[b.frame].homogeneous @ p.placement) for b in shown for p in b.parts]

    def holds(self, joint: int, points: Any, links: Any, steel: bool = True) -> Any:
        """Which points (n, 3) are in a part of a link that is fixed to the body of a Pinocchio joint."""
        inside = np.zeros(len(points), dtype=bool)
        for name, part, placement in self.parts:
            if links[name] == joint and (steel or tuple(part.rgba) != STEEL):
                inside |= within(part.shape, (points - placement[:3, 3]) @ placement[:3, :3])
        return inside

    def pins(self) -> Any:
        """Joints of both bodies, place and axis of every bearing that turns."""
        links = {name: self.model.frames[self.model.getFrameId(name, pin.BODY)].parentJoint for name in self.press.links}
        for j, axis in enumerate(self.press.axes, 1):
            if axis.turns:
                yield links, self.model.parents[j], j, self.data.oMi[j].translation, self.data.oMi[j].rotation @ axis.direction
        for loop in self.press.loops:
            if loop.type != "fixed":
                place = self.data.oMi[loop.joint1].act(loop.point1)
                yield links, loop.joint1, loop.joint2, place, self.data.oMi[loop.joint1].rotation @ loop.rotation1[:, 0]


def joined(press: Any, position: Any, normal: Any = None) -> None:
    """Along the axis of every pin, both links are met, and without a gap from one to the other."""
    shown, steps = bodies(press, position), np.linspace(-1.5, 1.5, 6001)[:, None] * press.size
    for state in position[:: max(1, len(position) // 5)]:
        scene = Scene(press, shown, state)
        for links, joint1, joint2, place, axis in scene.pins():
            line = place + steps * (axis if normal is None else normal)
            one, other = (scene.holds(joint, line, links) for joint in (joint1, joint2))
            runs = np.split(np.arange(len(line)), np.flatnonzero(np.diff((one | other).astype(int))) + 1)
            assert any(one[run].any() and other[run].any() and (one | other)[run].all() for run in runs), (joint1, joint2)
            away = np.abs(steps[one | other]).min()
            assert away < 0.35 * press.size  # layers are thin beside the linkage


# ---------------------------------------------------------------------------------------------------------------------------------- visuals


@pytest.mark.parametrize("name", pp.presses())
def test_visuals_as_pinocchio_reads_them(name: str) -> None:
    press = texts.shipped(name)
    shown = bodies(press, positions(press))
    assert tuple(body.name for body in shown) == press.links
    assert all(body.drawn for body in shown)
    visuals = pin.buildGeomFromUrdfString(press.model, press.text.decode(), pin.GeometryType.VISUAL).geometryObjects
    assert sum(len(body.parts) for body in shown) == len(visuals)
    for body in shown:
        assert press.model.frames[body.frame].name == body.name
        mine = [visual for visual in visuals if visual.parentFrame == body.frame]
        for part, visual in zip(body.parts, mine, strict=True):
            same_shape(part.shape, visual.geometry)
            assert_allclose(press.model.frames[body.frame].placement.homogeneous @ part.placement, visual.placement.homogeneous, atol=1e-14)
            assert_allclose(part.rgba, visual.meshColor, atol=1e-14)
            assert not part.placement.flags.writeable
            assert not part.rgba.flags.writeable


def same_shape(shape: Any, reference: Any) -> None:
    if isinstance(shape, Box):
        assert_allclose(shape.size, 2 * reference.halfSide)
    elif isinstance(shape, Cylinder):
        assert_allclose([shape.radius, shape.length], [reference.radius, 2 * reference.halfLength])
    elif isinstance(shape, Sphere):
        assert shape.radius == reference.radius
    else:
        assert_allclose(shape.vertices, reference.vertices(), atol=1e-12)
        corners = [tuple(reference.tri_indices(i)[k] for k in range(3)) for i in range(reference.num_tris)]
        assert_array_equal(shape.faces, corners)


ROTOR = """<robot name="rotor">{materials}
  <link name="frame"/>
  <link name="rotor">{inertial}{visual}</link>{more}
  <joint name="A" type="continuous"><parent link="frame"/><child link="rotor"/><origin xyz="0.3 0 1"/><axis xyz="0 -1 0"/></joint>
  <transmission name="drive"><joint name="A"/></transmission>
</robot>
"""
INERTIAL = """<inertial><origin xyz="{0}"/><mass value="2"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.02"/></inertial>"""
MASS = INERTIAL.format("0 0 0")
VISUAL = '<visual><origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/><geometry>{}</geometry>{}</visual>'


def rotor(folder: Path, visual: str = "", materials: str = "", more: str = "", inertial: str = MASS) -> Any:
    return loaded(folder, ROTOR.format(visual=visual, materials=materials, more=more, inertial=inertial))


def shown_rotor(press: Any) -> Any:
    return next(body for body in bodies(press, np.zeros((1, press.model.nv))) if body.name == "rotor")


def test_colours_by_name_and_in_place(tmp_path: Path) -> None:
    materials = '<material name="red"><color rgba="1 0 0 0.5"/></material>'
    painted = (
        '<material name="red"/>',
        '<material name="red"><color rgba="0 0 1 1"/></material>',  # the name is taken: it stays red
        '<material name="own"><color rgba="0 1 0 1"/></material>',
        '<material name="own"/>',
        '<material name="own"><color rgba="0 0 0 1"/></material>',
    )
    press = rotor(tmp_path, "".join(VISUAL.format('<sphere radius="0.1"/>', paint) for paint in (*painted, "")), materials)
    parts = shown_rotor(press).parts
    visuals = pin.buildGeomFromUrdfString(press.model, press.text.decode(), pin.GeometryType.VISUAL).geometryObjects
    for part, visual in zip(parts[:-1], visuals, strict=False):
        assert_allclose(part.rgba, visual.meshColor)
    assert_array_equal(parts[0].rgba, [1, 0, 0, 0.5])
    assert_allclose(parts[-1].rgba, [0.62, 0.65, 0.69, 1])


@pytest.mark.parametrize(
    ("shape", "says"),
    [
        ('<box size="0 1 1"/>', "link 'rotor': <box> has size='0 1 1'; give sizes greater than 0"),
        ('<box size="nan 1 1"/>', "link 'rotor': <box> has size='nan 1 1'; give finite numbers"),
        ('<box size="1 1"/>', "link 'rotor': <box> has size='1 1'; give finite numbers"),
        ('<cylinder radius="-1" length="1"/>', "link 'rotor': <cylinder> has radius='-1'; give sizes greater than 0"),
        ('<cylinder radius="1"/>', "link 'rotor': <cylinder> has length=''; give finite numbers"),
        ('<sphere radius="1e999"/>', "link 'rotor': <sphere> has radius='1e999'; give finite numbers"),
        ('<capsule radius="1" length="1"/>', "link 'rotor': <capsule> cannot be drawn; use <mesh>, <box>, <cylinder> and <sphere>"),
        ('<mesh filename="m.stl" scale="1 inf 1"/>', "link 'rotor': <mesh> has scale='1 inf 1'; give finite numbers"),
        ('<mesh filename="m.stl" scale="1 0 1"/>', "link 'rotor': mesh 'm.stl' has the scale 1.0 0.0 1.0, which makes it flat"),
    ],
)
def test_sizes_that_cannot_be_drawn(shape: str, says: str, tmp_path: Path) -> None:
    press = rotor(tmp_path)  # `load` refuses most of these, but the text may come from elsewhere
    text = ROTOR.format(visual=VISUAL.format(shape, ""), materials="", more="", inertial=MASS)
    with pytest.raises(pp.PinpressError, match=re.escape(says)):
        shown_rotor(with_text(press, text.encode()))


def test_origin_that_is_not_finite(tmp_path: Path) -> None:
    press = rotor(tmp_path, VISUAL.format('<sphere radius="1"/>', ""))
    broken = with_text(press, press.text.replace(b'rpy="0.4', b'rpy="inf'))
    with pytest.raises(pp.PinpressError, match=re.escape("link 'rotor': <origin> has rpy='inf 0.5 0.6'; give finite numbers")):
        shown_rotor(broken)


@pytest.mark.parametrize("position", [np.zeros(1), np.zeros((0, 1)), np.zeros((2, 3)), np.array([[0.0], [np.nan]])])
def test_joint_positions_of_another_shape_or_not_finite(position: Any, tmp_path: Path) -> None:
    with pytest.raises(pp.PinpressError, match="not finite in state 1" if position.shape == (2, 1) else r"give \(n, 1\)"):
        bodies(rotor(tmp_path), position)


# ----------------------------------------------------------------------------------------------------------------------------------- meshes


CORNERS = np.array([[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 5]], dtype=float)
SIDES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])  # a tetrahedron, seen from outside


def stl(corners: Any = CORNERS) -> bytes:
    triangles = (struct.pack("<12fH", 0, 0, 0, *corners[side].ravel(), 0) for side in SIDES)
    return bytes(80) + struct.pack("<I", len(SIDES)) + b"".join(triangles)


def obj(corners: Any = CORNERS) -> bytes:
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in SIDES]
    return "\n".join([*lines, ""]).encode()


def volume(mesh: Any) -> float:
    """By the divergence theorem: positive where faces are seen from outside."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return float(np.sum(a * np.cross(b, c)) / 6)


@pytest.mark.parametrize("name", ["m.stl", "m.obj"])
@pytest.mark.parametrize("scale", [(1, 1, 1), (0.1, 0.2, 0.3), (0.1, -0.2, 0.3), (-0.001, -0.001, -0.001)])
def test_meshes_are_scaled_and_not_turned_inside_out(name: str, scale: Any, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(stl() if name == "m.stl" else obj())
    numbers = " ".join(map(str, scale))
    (part,) = shown_rotor(rotor(tmp_path, VISUAL.format(f'<mesh filename="{name}" scale="{numbers}"/>', ""))).parts
    mesh = part.shape
    assert isinstance(mesh, TriangleMesh)
    assert volume(mesh) == pytest.approx(5 * abs(np.prod(scale)), rel=1e-6)
    expected = CORNERS * scale
    assert_allclose(sorted(mesh.vertices.tolist()), sorted(expected.tolist()), atol=1e-6)
    assert not mesh.vertices.flags.writeable
    assert not mesh.faces.flags.writeable


def test_where_meshes_are_looked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "space" / "my_press"
    (package / "urdf").mkdir(parents=True)
    (package / "meshes").mkdir()
    mesh = package / "meshes" / "m.stl"
    mesh.write_bytes(stl())

    def found(folder: Path, name: str) -> bool:
        return volume(shown_rotor(rotor(folder, VISUAL.format(f'<mesh filename="{name}"/>', ""))).parts[0].shape) > 4

    assert found(package / "urdf", "../meshes/m.stl")
    assert found(tmp_path, str(mesh))
    assert found(tmp_path, f"file://{mesh}")
    assert found(package / "urdf", "package://my_press/meshes/m.stl")  # the URDF is in the package
    (tmp_path / "space" / "other").mkdir()
    assert found(tmp_path / "space" / "other", "package://my_press/meshes/m.stl")  # the packages are side by side
    with pytest.raises(pp.PinpressError, match=r"link 'rotor': mesh 'package://my_press/.*ROS_PACKAGE_PATH"):
        found(tmp_path, "package://my_press/meshes/m.stl")
    for path in (tmp_path / "space", package):
        monkeypatch.setenv("ROS_PACKAGE_PATH", os.pathsep.join(["/nowhere", str(path)]))
        assert found(tmp_path, "package://my_press/meshes/m.stl")
    monkeypatch.chdir(package)
    relative = pp.load(os.path.join("urdf", "press.urdf"))
    assert volume(shown_rotor(relative).parts[0].shape) > 4


@pytest.mark.parametrize("suffix", ["panda_description/meshes/visual/finger.dae", "cassie_description/meshes/foot-crank.stl"])
def test_real_meshes_as_pinocchio_loads_them(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = next(Path(str(path.locate())) for path in files("example-robot-data") or () if str(path).endswith(suffix))
    share = mesh.parents[len(Path(suffix).parts) + 1]
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(share))
    name = f"package://example-robot-data/robots/{suffix}"
    press = rotor(tmp_path, VISUAL.format(f'<mesh filename="{name}" scale="0.5 0.5 0.5"/>', ""))
    (part,) = shown_rotor(press).parts
    (visual,) = pin.buildGeomFromUrdfString(
        press.model, press.text.decode(), pin.GeometryType.VISUAL, package_dirs=[str(share)]
    ).geometryObjects
    same_shape(part.shape, visual.geometry)


def test_too_many_visuals_in_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    box = VISUAL.format('<box size="1 1 1"/>', "")
    monkeypatch.setattr(appearance, "MOST_SHAPES", 3)
    assert len(shown_rotor(rotor(tmp_path, 3 * box)).parts) == 3
    with pytest.raises(pp.PinpressError, match="link 'rotor': with it there are more than 3 visuals to be drawn; leave some out"):
        shown_rotor(rotor(tmp_path, 4 * box))


def test_too_many_triangles_in_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each mesh has few; what comes after the one that is too many is not read."""
    (tmp_path / "m.stl").write_bytes(stl())
    one, missing = (VISUAL.format(f'<mesh filename="{name}"/>', "") for name in ("m.stl", "missing.stl"))
    monkeypatch.setattr(appearance, "MOST_TRIANGLES", 2 * len(SIDES))
    assert len(shown_rotor(rotor(tmp_path, 2 * one)).parts) == 2
    with pytest.raises(pp.PinpressError, match="more than 8 triangles to be drawn; leave some out, or give coarser meshes"):
        shown_rotor(rotor(tmp_path, 3 * one + missing))


BROKEN = {
    "missing.stl": None,
    "empty.stl": b"",
    "garbage.stl": np.random.default_rng(1).bytes(2000),
    "garbage.obj": b"v 1 2\nf 1 2 3 a",
    "garbage.dae": b"<COLLADA/>",
    "huge_index.dae": b"<COLLADA><mesh><p>0 1 99999999999</p></mesh></COLLADA>",
    "no_index.dae": b"<COLLADA><mesh><p>0 1 2V3</p></mesh></COLLADA>",
    "other.dae": b"<html/>",
    "binary.obj": b"v 0 0 0\n\0",
    "half.stl": stl()[:150],
    "none.stl": bytes(84),
    "points.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "unknown.xyz": b"hello",
    "polygons.ply": b"ply\nformat ascii 1.0\nelement vertex 3\n",  # its reader ends the process on some broken files
    "polygons.stl": b"ply\nformat ascii 1.0\nelement vertex 3\n",
    "ascii.stl": b"solid nothing\nendsolid\n",
    "not_a_number.stl": stl(np.where(CORNERS == 5, np.nan, CORNERS)),
    "infinite.stl": stl(np.where(CORNERS == 5, np.inf, CORNERS)),
    "not_a_number.obj": obj(np.where(CORNERS == 5, np.nan, CORNERS)),
}


@pytest.mark.parametrize("name", BROKEN)
def test_meshes_that_cannot_be_read(name: str, tmp_path: Path) -> None:
    content = BROKEN[name]
    if content is not None:
        (tmp_path / name).write_bytes(content)
    press = rotor(tmp_path, VISUAL.format(f'<mesh filename="{name}"/>', ""))
    remedy = "there is no file .* put the mesh there" if content is None else "(give|repair)"
    with pytest.raises(pp.PinpressError, match=rf"^link 'rotor': mesh '{name}'.*{remedy}"):
        shown_rotor(press)


def test_mesh_that_is_a_folder_and_scale_beyond_numbers(tmp_path: Path) -> None:
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(pp.PinpressError, match="there is no file"):
        shown_rotor(rotor(tmp_path, VISUAL.format('<mesh filename="folder.stl"/>', "")))
    (tmp_path / "m.stl").write_bytes(stl())
    with pytest.raises(pp.PinpressError, match="give a smaller scale"):
        shown_rotor(rotor(tmp_path, VISUAL.format('<mesh filename="m.stl" scale="1e308 1 1"/>', "")))


# ----------------------------------------------------------------------------------------------------------------------------- plain shapes


@pytest.mark.one_in(20)
@pytest.mark.parametrize("name", pp.presses())
def test_pins_join_links_without_visuals(name: str) -> None:
    press = bare(texts.shipped(name))
    assert b"<visual" not in press.text
    position = positions(press)
    shown = bodies(press, position)
    assert tuple(body.name for body in shown) == press.links
    assert not any(body.drawn for body in shown)
    joined(press, position, normal=np.array([0.0, -1.0, 0.0]))


def own_colours(shown: Any) -> list[tuple[float, ...]]:
    """The colour that most parts of each link have."""
    colours = []
    for body in shown:
        painted = [tuple(part.rgba) for part in body.parts]
        assert all(0 <= channel <= 1 for rgba in painted for channel in rgba)
        colours.append(max(set(painted), key=painted.count))
    return colours


@pytest.mark.parametrize("name", pp.presses())
def test_colours_tell_links_apart(name: str) -> None:
    press = bare(texts.shipped(name))
    colours = own_colours(bodies(press, positions(press)))
    for one, other in itertools.combinations(colours, 2):
        assert np.abs(np.subtract(one, other)).max() > 0.1


@pytest.mark.parametrize("name", ["crank_slide", "jf75g_125", "jf75g_125_symmetric", "zxn2_3000b"])
def test_links_pass_each_other_in_layers(name: str) -> None:
    """Along the normal, what is not a pin takes up room that no other link has; all bearings of these presses are at one height."""
    press = bare(texts.shipped(name))
    layers = []
    for body in bodies(press, positions(press)):
        placed = press.model.frames[body.frame].placement  # its turning about the normal changes nothing
        low, high = np.inf, -np.inf
        guided = not press.axes[press.model.frames[body.frame].parentJoint - 1].turns
        for part in body.parts[:1] if guided else body.parts:  # the block of a slide's mass is where nothing passes
            if tuple(part.rgba) != STEEL and body.name != "frame":
                middle = (placed.homogeneous @ part.placement)[1, 3]
                thickness = part.shape.size[2] if isinstance(part.shape, Box) else getattr(part.shape, "length", 0) or part.shape.thickness
                assert_allclose(np.abs(part.placement[:3, :3].T[2] @ placed.rotation.T), [0, 1, 0], atol=1e-9)
                low, high = min(low, middle - thickness / 2), max(high, middle + thickness / 2)
        layers += [(low, high)] if body.name != "frame" else []
    layers.sort()
    assert all(below[1] < above[0] for below, above in itertools.pairwise(layers))


@pytest.mark.parametrize("name", pp.presses())
def test_slides_stay_between_their_rails(name: str) -> None:
    press = bare(texts.shipped(name))
    position = positions(press)
    shown = bodies(press, position)
    rails = [part for part in shown[0].parts if isinstance(part.shape, Box) and max(part.shape.size) == part.shape.size[0]]
    for j, axis in enumerate(press.axes, 1):
        if axis.turns or press.model.parents[j] != 0:
            continue
        slide = next(body for body in shown if press.model.frames[body.frame].parentJoint == j)
        blocks = [part for part in slide.parts if isinstance(part.shape, Box)]  # one for its pins, one of its mass
        direction = press.model.jointPlacements[j].rotation @ axis.direction
        places = [press.model.jointPlacements[j].homogeneous @ block.placement for block in blocks]
        middles = [place[:3, 3] @ direction for place in places]
        halves = [block.shape.size[0] / 2 for block in blocks]
        low = min(middle - half for middle, half in zip(middles, halves, strict=True)) + position[:, j - 1].min()
        high = max(middle + half for middle, half in zip(middles, halves, strict=True)) + position[:, j - 1].max()
        mine = [p for p in rails if abs(abs(p.placement[:3, 0] @ direction) - 1) < 1e-9 and abs(p.placement[1, 3] - places[0][1, 3]) < 1e-9]
        ends = np.array([-1, 1]) / 2
        mine = [p for p in mine if np.allclose(p.placement[:3, 3] @ direction + ends * p.shape.size[0], [low, high], rtol=0, atol=1e-9)]
        assert len(mine) == 2
        for rail in mine:
            for block, place in zip(blocks, places, strict=True):
                apart = abs((rail.placement[:3, 3] - place[:3, 3]) @ place[:3, 1])
                assert apart > (block.shape.size[1] + rail.shape.size[1]) / 2


STEEL_DENSITY = 7850.0


def steel(solids: Any, placement: Any) -> tuple[float, Any]:
    """Mass and centre of mass of solids of steel."""
    found = [volume_and_centre(part.shape) for part in solids]
    masses = STEEL_DENSITY * np.array([volume for volume, _ in found])
    centres = [(placement @ part.placement @ [*centre, 1])[:3] for part, (_, centre) in zip(solids, found, strict=True)]
    return float(masses.sum()), masses @ np.array(centres) / masses.sum()


def test_volumes_and_centres() -> None:
    """Against closed forms, and a plate against its own triangles and strips."""
    plate = rounded_plate(np.array([[0.0, 0.0], [0.4, 0.0], [0.1, 0.3]]), np.array([0.05, 0.02, 0.03]), 0.02)
    mesh = plate.mesh()
    volume, centre = volume_and_centre(plate)
    assert_allclose(volume_and_centre(mesh)[0], volume)
    assert_allclose(volume_and_centre(mesh)[1], centre, atol=1e-12)
    strips = plate.strips()
    assert_allclose(sum(np.prod(box.size) for box, _ in strips), volume, rtol=0.02)
    for (x, y), radius in zip([(0, 0), (0.4, 0), (0.1, 0.3)], (0.05, 0.02, 0.03), strict=True):
        around = [(x, y, 0.0)] + [(x + 0.98 * radius * np.cos(a), y + 0.98 * radius * np.sin(a), 0.0) for a in range(7)]
        assert within(plate, np.array(around)).all()  # it holds its circles
    assert corners(plate)[:, 0].min() == pytest.approx(-0.05, rel=1e-3)
    volume, centre = volume_and_centre(half_disc(0.3, 0.1))
    assert volume == pytest.approx(np.pi * 0.3**2 / 2 * 0.1, rel=5e-3)
    assert_allclose(centre, [4 * 0.3 / (3 * np.pi), 0, 0], atol=1e-3)


@pytest.mark.parametrize(("mass", "place", "shape"), [(3000.0, (-0.1, 0.0, 0.05), Cylinder), (600.0, (-0.3, 0.0, 0.1), Plate)])
def test_counterweights_of_a_balanced_press_have_their_mass_where_it_is(mass: float, place: Any, shape: type, tmp_path: Path) -> None:
    """The 3 tonnes that balancing finds are seen, on links with visuals and without, of a file too; bodies are as before."""
    press = texts.shipped("zxn2_3000b")
    weights = [Counterweight("crank", mass, place), Counterweight("rod", 40.0, (0.3, 0.0, 0.0))]
    balanced = with_counterweights(press, weights)
    read = pp.load(pp.write_urdf(balanced, tmp_path / "balanced.urdf"))
    plain = pp.load(pp.write_urdf(bare(balanced), tmp_path / "plain.urdf"))
    for one, other in ((press, balanced), (press, read), (bare(press), bare(balanced)), (bare(press), plain)):
        position = positions(press)
        before, after = ({body.name: body for body in bodies(each, position)} for each in (one, other))
        for weight in weights:
            body = after[weight.link]
            shades = [0.66 * part.rgba[:3] for part in body.parts]  # of the link's colours
            more = [part for part in body.parts if any(np.allclose(part.rgba[:3], shade) for shade in shades)]
            assert len(more) == 1
            found, centre = steel(more, np.eye(4))
            assert found == pytest.approx(weight.mass, rel=5e-3)
            assert weight.link != "crank" or isinstance(more[0].shape, shape)
            assert_allclose(centre[[0, 2]], np.array(weight.position)[[0, 2]], atol=2e-3)
            assert len(body.parts) >= len(before[weight.link].parts) + 1
        assert [len(after[name].parts) for name in ("coupler", "slide")] == [len(before[name].parts) for name in ("coupler", "slide")]


@pytest.mark.parametrize("radius", ["1e200", "1e-200", "3", "0.02"])
def test_balls_that_can_be_no_counterweights(radius: str) -> None:
    """They are too heavy for their links, or nothing; what is drawn is finite, and masses are those of the file."""
    press = texts.shipped("crank_slide")
    ball = f'<visual name="added_ballast"><geometry><sphere radius="{radius}"/></geometry></visual></link>'
    other = texts.load(press.text.decode().replace("</link>", ball))
    shown = bodies(other, positions(press))
    assert all(np.isfinite(part.placement).all() for body in shown for part in body.parts)
    assert [each.mass for each in other.model.inertias] == [each.mass for each in press.model.inertias]


@pytest.mark.parametrize("mass", [30.0, 4000.0])
def test_slides_are_of_their_mass(mass: float) -> None:
    press = bare(texts.shipped("crank_slide"))
    model = press.model.copy()
    joint = model.frames[model.getFrameId("slide")].parentJoint
    model.inertias[joint] = pin.Inertia(mass, model.inertias[joint].lever, np.eye(3))
    text = re.sub(r'(<link name="slide">.*?<mass value=")[^"]*', rf"\g<1>{mass}", press.text.decode(), count=1, flags=re.DOTALL)
    shown = bodies(dataclasses.replace(with_text(press, text.encode()), model=model), positions(press))
    lug, *block = [part for part in next(body for body in shown if body.name == "slide").parts if isinstance(part.shape, Box)]
    if mass < 100:
        assert steel([lug, *block], np.eye(4))[0] == pytest.approx(mass, rel=1e-9)
    else:  # no slide is larger than its press
        assert np.all(np.array(block[0].shape.size) < 0.43 * press.size)


def test_frame_of_a_press() -> None:
    """It stands behind all that moves, holds every pivot, and its bolster is below the slide wherever that goes."""
    press = bare(texts.shipped("zxn2_3000b"))
    frame, *moving = bodies(press, positions(press))
    placed = [(part, part.placement[:3, 3] + corners(part.shape) @ part.placement[:3, :3].T) for part in frame.parts]
    slide = next(body for body in moving if body.name == "slide")
    guide = press.model.jointPlacements[press.model.frames[slide.frame].parentJoint].homogeneous
    travel = positions(press)[:, press.joints.index("slide_guide")]
    block = [(guide @ np.vstack([(part.placement @ [*corner, 1.0]) for corner in corners(part.shape)]).T)[:3].T for part in slide.parts]
    lowest = min(points[:, 2].min() for points in block) + travel.min()
    highest = max(points[:, 2].max() for part, points in placed if points[:, 2].max() < lowest)  # the bolster, under the slide
    assert 0.02 < lowest - highest < 0.2
    width = max(points[:, 0].max() for points in block) - min(points[:, 0].min() for points in block)
    bolster = next(points for _, points in placed if points[:, 2].max() == highest)
    assert np.ptp(bolster[:, 0]) > 0.9 * width
    everything = np.concatenate([points for _, points in placed])
    assert np.ptp(everything, axis=0).max() < 2.5 * press.size


@pytest.mark.parametrize("name", ["crank_slide", "zxn2_3000b"])
@pytest.mark.parametrize("share", [0.05, 0.2, 1.0])
def test_flywheel_of_its_inertia_turns_with_the_crank(name: str, share: float, tmp_path: Path) -> None:
    """Of steel, a quarter of its radius thick, where this is from 0.15 to 0.3 of the linkage's size; else as large as is drawn."""
    press = texts.shipped(name)
    inertia = np.pi / 2 * STEEL_DENSITY * 0.25 * (share * press.size) ** 5
    run = pp.simulate(press, 0.5, speed=7.0, flywheel=pp.drives.Flywheel(inertia=inertia))
    *links, wheel = bodies(press, run.joint_position, flywheels=[ShaftFlywheel(press.driver, inertia)])
    assert wheel.name == "flywheel"
    disc, axis = wheel.parts[0], press.axes[press.joints.index(press.driver)].direction
    assert disc.shape.radius == pytest.approx(np.clip(share, 0.15, 0.3) * press.size, rel=0.01)
    assert disc.shape.length == 0.25 * disc.shape.radius
    assert_allclose(np.abs(disc.placement[:3, 2] @ axis), 1)
    assert_allclose(disc.placement[[0, 2], 3], 0, atol=1e-12)  # on the crank's shaft, behind all else
    low = min((p.placement[:3, 3] + corners(p.shape) @ p.placement[:3, :3].T)[:, 1].max() for p in wheel.parts[:1])
    assert low > 0
    assert [body.name for body in links] == list(press.links)
    legend = [row["name"] for row in data_in(pp.record(press, run, tmp_path / "out.html"))["legend"]]
    assert legend == [*press.links[1:], "flywheel"]


def test_flywheels_of_several_drivers(tmp_path: Path) -> None:
    path = tmp_path / "two_servos.yaml"
    path.write_text(TWO_SERVOS)
    press = pp.build(path)
    wheels = {"A": pp.drives.Flywheel(inertia=5.0), "B": pp.drives.Flywheel(inertia=20.0)}
    run = pp.simulate(press, 0.02, speed=[3.0, -3.0], flywheel=wheels, method="constraint")
    motion = pp.servo_cycle(press, [[0.0, 0.0], [0.1, 0.1]], speed=[[1.0, 1.0]] * 2, acceleration=np.zeros((2, 2)), time=[0.0, 0.1])
    for page in (pp.record(press, motion, tmp_path / "a.html", flywheel=wheels), pp.record(press, run, tmp_path / "b.html")):
        assert [row["name"] for row in data_in(page)["legend"]][-2:] == ["flywheel of A", "flywheel of B"]
    *_, one, other = bodies(press, motion.joint_position, flywheels=[ShaftFlywheel("A", 30.0), ShaftFlywheel("B", 30.0)])
    apart = one.parts[0].placement[1, 3] - other.parts[0].placement[1, 3]
    assert abs(apart) > one.parts[0].shape.length  # they would cut through each other
    for flywheel, said in ((wheels["A"], "2 drivers"), ({"C": wheels["A"]}, "no driver 'C'"), ({"A": 5.0}, "give a Flywheel")):
        with pytest.raises(pp.PinpressError, match=said):
            pp.record(press, run, tmp_path / "out.html", flywheel=flywheel)


def test_flywheel_of_a_report_and_none_on_a_cylinder(tmp_path: Path) -> None:
    press, wheel = texts.shipped("crank_slide"), pp.drives.Flywheel(inertia=25.0)
    motion = pp.cycle(press, 7.0, points=24)
    run = pp.simulate(press, 0.1, speed=7.0, flywheel=wheel)
    asked: list[dict[str, Any]] = [{"flywheel": wheel}, {"results": [run]}]
    for more in asked:
        page = data_in(pp.report(press, motion, tmp_path / "out.html", **more))
        assert [row["name"] for row in page["legend"]][-1] == "flywheel"
    toggle = pp.build(Path(pp.__file__).parent / "pin_table" / "templates" / "toggle.yaml")
    with pytest.raises(pp.PinpressError, match="no shaft"):
        pp.record(toggle, pp.cycle(toggle, 0.1, points=24), tmp_path / "out.html", flywheel=wheel)


def test_same_press_same_parts() -> None:
    press = bare(texts.shipped("thin_wall"))
    one, other = (bodies(press, positions(press)) for _ in range(2))
    for a, b in zip(one, other, strict=True):
        assert (a.name, a.frame, a.drawn) == (b.name, b.frame, b.drawn)
        for p, r in zip(a.parts, b.parts, strict=True):
            assert_array_equal(corners(p.shape), corners(r.shape))
            assert_array_equal(p.placement, r.placement)
            assert_array_equal(p.rgba, r.rgba)


def test_visuals_of_some_links() -> None:
    press = bare(texts.shipped("zxn2_3000b"), "frame", "coupler", "rod")
    shown = {body.name: body for body in bodies(press, positions(press))}
    assert [name for name, body in shown.items() if not body.drawn] == ["frame", "coupler", "rod"]
    whole = {body.name: body for body in bodies(texts.shipped("zxn2_3000b"), positions(press))}
    for name in ("crank", "rocker", "slide"):
        assert [part.shape for part in shown[name].parts] == [part.shape for part in whole[name].parts]


@pytest.mark.parametrize("text", [bennett(), bricard(), cassie.urdf(), four_bar("revolute"), four_bar("fixed"), four_bar("spherical", "T")])
def test_links_in_space_and_others(text: str, tmp_path: Path) -> None:
    press = loaded(tmp_path, text)
    position = press.closed[None]
    shown = bodies(press, position)
    assert sorted(press.model.frames[body.frame].parentJoint for body in shown) == list(range(press.model.njoints))
    moving = own_colours(shown)[1:]
    assert len(set(moving)) == len(moving)
    scene = Scene(press, shown, position[0])
    for links, joint1, joint2, place, axis in scene.pins():
        for joint in (joint1, joint2):
            if "four_bar" in text:  # in layers, up to a third of its size away
                line = place + 0.3 * press.size * np.outer(np.linspace(-1, 1, 401), [0, 1, 0])
                assert scene.holds(joint, line, links, steel=False).any()
            else:
                bush = place + 0.016 * press.size * np.outer([-1, 0, 1], axis)
                assert scene.holds(joint, bush, links, steel=False).all()


@pytest.mark.parametrize("text", [bennett(), bricard()])
def test_links_in_space_are_rods_from_pin_to_pin(text: str, tmp_path: Path) -> None:
    press = loaded(tmp_path, text)
    scene = Scene(press, bodies(press, press.closed[None]), press.closed)
    ends: dict[int, list[Any]] = {}
    links = {body: press.model.frames[press.model.getFrameId(body, pin.BODY)].parentJoint for body in press.links}
    for _, *joints, place, _ in scene.pins():
        for joint in joints:
            ends.setdefault(joint, []).append(place)
    for joint, (one, other) in ends.items():
        assert scene.holds(joint, np.linspace(one, other, 50), links, steel=False).all()
    assert len(ends) == press.model.njoints


@pytest.mark.exhaustive
@examples(15)
@given(spec=linkages())
def test_pins_join_links_nobody_thought_of(spec: Any, tmp_path: Path) -> None:
    drawing = drawn(spec)
    assume(drawing is not None)
    press = loaded(tmp_path, drawing.urdf("crank"))
    shown = bodies(press, press.closed[None])
    assert len({press.model.frames[body.frame].parentJoint for body in shown}) == len(shown) == press.model.njoints
    assert all(np.isfinite(part.placement).all() for body in shown for part in body.parts)
    joined(press, press.closed[None], press.engine("plane").plane.normal)


@pytest.mark.filterwarnings("ignore:.*density:pinpress.PinpressWarning")
@pytest.mark.parametrize("small", [1.0, 1e-3])
def test_lone_rotor_is_a_disc_of_its_inertia(small: float, tmp_path: Path) -> None:
    moments = re.sub(r'(i[xyz]{2})="([\d.]+)"', lambda m: f'{m[1]}="{float(m[2]) * small**2}"', MASS)
    frame, body = bodies(rotor(tmp_path, inertial=moments), np.zeros((1, 1)))
    assert (frame.name, body.name) == ("frame", "rotor")
    disc, gyration = body.parts[0].shape, small * np.sqrt(0.04 / 2)
    assert isinstance(disc, Cylinder)
    assert 0.3 * gyration < disc.radius < 2 * gyration
    assert_allclose(body.parts[0].placement[[0, 2], 3], 0, atol=1e-12)
    assert frame.parts[0].placement[0, 3] == pytest.approx(0.3)


def test_lone_rotor_without_inertia_is_drawn_all_the_same(tmp_path: Path) -> None:
    press = rotor(tmp_path)
    model = press.model.copy()
    model.inertias[1] = pin.Inertia.Zero()
    frame, body = bodies(dataclasses.replace(press, model=model), np.zeros((1, 1)))
    assert 0.01 < body.parts[0].shape.radius < 0.5
    assert len(frame.parts) > 1


def test_pendulum_reaches_to_its_centre_of_mass(tmp_path: Path) -> None:
    press = rotor(tmp_path, inertial=INERTIAL.format("0 0.7 -0.5"))
    shown = bodies(press, np.zeros((1, 1)))
    scene = Scene(press, shown, [0.0])
    line = np.array([0.3, 0.0, 0.52]) + np.outer(np.linspace(-1, 1, 2001), [0, 1, 0])
    assert scene.holds(1, line, {"frame": 0, "rotor": 1}).any()
    assert scene.holds(1, line + 0.25 * np.array([0, 0, 1]), {"frame": 0, "rotor": 1}).any()  # half way to the pin
    assert not scene.holds(1, line - 0.2 * np.array([0, 0, 1]), {"frame": 0, "rotor": 1}).any()


def test_link_of_no_length_is_a_disc(tmp_path: Path) -> None:
    """An eccentric of no eccentricity: two pins in one place, one above the other."""
    link = f'<link name="{{}}">{MASS}</link>'
    more = link.format("rod") + link.format("slide") + link.format("end")
    more += '<joint name="B" type="continuous"><parent link="rotor"/><child link="rod"/><axis xyz="0 -1 0"/></joint>'
    more += '<joint name="C" type="continuous"><parent link="rod"/><child link="end"/><origin xyz="0.5 0 0"/><axis xyz="0 -1 0"/></joint>'
    more += '<joint name="W" type="fixed"><parent link="frame"/><child link="slide"/></joint>'
    more += "".join(f'<transmission name="drive_{name}"><joint name="{name}"/></transmission>' for name in "BC")
    press = rotor(tmp_path, more=more)
    shown = {body.name: body for body in bodies(press, np.zeros((1, 3)))}
    assert list(shown) == ["frame", "rotor", "rod", "end"]  # the slide is welded to the frame
    disc = shown["rotor"].parts[0].shape
    assert isinstance(disc, Cylinder)
    assert 0.01 < disc.radius < 0.2
    joined(press, np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]), normal=np.array([0.0, -1.0, 0.0]))


WELDED = (
    '<link name="cover">{}</link><joint name="W" type="fixed"><parent link="rotor"/><child link="cover"/><origin xyz="0 0 {}"/></joint>'
)


def test_links_welded_to_others(tmp_path: Path) -> None:
    """Of two links that are welded together, one with visuals: the other is shown if it goes anywhere from there."""
    ball = VISUAL.format('<sphere radius="0.1"/>', "")
    names = [body.name for body in bodies(rotor(tmp_path, ball, more=WELDED.format("", "0.2")), np.zeros((1, 1)))]
    assert names == ["frame", "rotor"]
    names = [body.name for body in bodies(rotor(tmp_path, "", more=WELDED.format(ball, "0.2")), np.zeros((1, 1)))]
    assert names == ["frame", "cover"]
    names = [body.name for body in bodies(rotor(tmp_path, "", more=WELDED.format("", "0.2")), np.zeros((1, 1)))]
    assert names == ["frame", "rotor"]
    arm = f'<link name="end">{MASS}</link><joint name="B" type="continuous"><parent link="cover"/><child link="end"/>'
    arm += '<origin xyz="0.4 0 0"/><axis xyz="0 -1 0"/></joint><transmission name="b"><joint name="B"/></transmission>'
    press = rotor(tmp_path, ball, more=WELDED.format("", "0.2") + arm)
    shown = {body.name: body for body in bodies(press, np.zeros((1, 2)))}
    assert {name: body.drawn for name, body in shown.items()} == {"frame": False, "rotor": True, "cover": False, "end": False}
    middle = shown["cover"].parts[0]
    assert_allclose([middle.placement[0, 3], middle.shape.size[0]], [0.2, 0.4], atol=1e-12)  # a bar from the weld to the pin


# ------------------------------------------------------------------------------------------------------------ as Pinocchio's geometry


def objects(model: Any) -> Any:
    return {each.name: each for each in model.geometryObjects}


@pytest.mark.parametrize("name", pp.presses())
def test_of_shipped_presses_it_is_what_pinocchio_reads(name: str) -> None:
    press = texts.shipped(name)
    ours = objects(pp.visual_model(press))
    theirs = objects(pin.buildGeomFromUrdf(press.model.copy(), press.file, pin.VISUAL))
    assert ours.keys() == theirs.keys()
    for each, other in ((ours[key], theirs[key]) for key in ours):
        assert (each.parentJoint, each.parentFrame, each.overrideMaterial) == (other.parentJoint, other.parentFrame, other.overrideMaterial)
        assert each.geometry == other.geometry
        assert_allclose(each.placement.homogeneous, other.placement.homogeneous, rtol=0, atol=1e-15)
        assert_allclose(each.meshColor, other.meshColor, rtol=0, atol=1e-7)  # theirs are of single precision


@pytest.mark.parametrize("text", [bennett(), planar_four_bar(1.0, 0.3, 0.9, 0.7, 0.5).urdf("O")])
def test_links_without_visuals_have_the_shapes_of_a_recording(text: str) -> None:
    press = texts.load(text)
    motion = pp.servo_cycle(press, angle=np.linspace(0.0, 0.3, 5), speed=1.0)
    drawn = bodies(press, motion.joint_position)
    found = objects(pp.visual_model(press, motion))
    assert {f"{body.name}_{k}" for body in drawn for k in range(len(body.parts))} == found.keys()
    data, geometry = press.model.createData(), pp.visual_model(press, motion)
    placed = geometry.createData()
    pin.updateGeometryPlacements(press.model, data, geometry, placed, motion.q[-1])
    pin.framesForwardKinematics(press.model, data, motion.q[-1])
    for body in drawn:
        for k, part in enumerate(body.parts):
            world = data.oMf[body.frame].homogeneous @ part.placement
            assert_allclose(placed.oMg[geometry.getGeometryId(f"{body.name}_{k}")].homogeneous, world, rtol=0, atol=1e-13)
            assert_array_equal(found[f"{body.name}_{k}"].meshColor, part.rgba)


def test_rails_are_as_long_as_the_travel_of_all_crank_angles() -> None:
    press = texts.load(bare(texts.shipped("crank_slide")).text.decode())
    turn = objects(pp.visual_model(press, pp.cycle(press, speed=1.0, points=3600)))
    short = objects(pp.visual_model(press, pp.servo_cycle(press, angle=[0.0, 0.1], speed=1.0)))
    longest = [each for each in turn if turn[each].geometry != short[each].geometry]
    assert longest != []
    for name, each in objects(pp.visual_model(press)).items():
        if isinstance(each.geometry, coal.Box):
            assert_allclose(each.geometry.halfSide, turn[name].geometry.halfSide, rtol=1e-4)


def test_several_drivers() -> None:
    assert pp.visual_model(two_cranks()).ngeoms == 3


def test_meshes_are_in_it(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_bytes(obj())
    text = texts.shipped("crank_slide").text.decode()
    start, end = text.index("<visual", text.index('<link name="slide"')), text.index("</link>", text.index('<link name="slide"'))
    mesh = '<visual><geometry><mesh filename="m.obj" scale="0.1 0.2 0.3"/></geometry></visual>'
    (tmp_path / "press.urdf").write_text(text[:start] + mesh + text[end:])
    found = objects(pp.visual_model(pp.load(tmp_path / "press.urdf")))["slide_0"]
    assert isinstance(found.geometry, coal.BVHModelOBBRSS)
    assert (found.geometry.num_tris, found.meshPath, found.meshScale.tolist()) == (4, "", [1.0, 1.0, 1.0])
    assert_allclose(sorted(found.geometry.vertices().tolist()), sorted((CORNERS * [0.1, 0.2, 0.3]).tolist()), atol=1e-7)


def test_every_call_makes_new_ones() -> None:
    press = texts.shipped("crank_slide")
    objects(pp.visual_model(press))["slide_0"].placement = pin.SE3.Random()
    first, second = (objects(pp.visual_model(press))["slide_0"].placement for _ in range(2))
    assert first == second


def test_a_motion_of_other_joints_is_refused() -> None:
    motion = pp.cycle(texts.shipped("zxn2_3000b"), speed=1.0, points=4)
    with pytest.raises(pp.PinpressError, match="the motion is of zxn2_3000b with other joints than crank_slide"):
        pp.visual_model(texts.shipped("crank_slide"), motion)
