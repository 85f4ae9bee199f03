"""MJCF, the format of MuJoCo (mujoco.readthedocs.io, "XML Reference"), read by the package mujoco itself.

MuJoCo's compiler resolves classes, includes, frames, angles in degrees and inertia from shapes. Bodies with hinges, slides and balls make
the tree; ``<equality>`` closes its loops: ``<connect>`` is a pin, ``<weld>`` is fixed, ``<joint>`` a gear pair. MuJoCo's equalities are
slightly elastic; here they hold exactly.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ...common.errors import PinpressError, UrdfError, shown
from ...common.quantities import Array
from ..document import Document, Finding, Origin
from ..document import read as read_text
from ..element import Element, tree
from ..text import as_text
from .elements import make_unique, refuse, remark
from .mechanism import Follow, Inertia, Joint, Link, Loop, Mechanism, Shape, as_document, capsule, massless_link

if TYPE_CHECKING:
    import mujoco

WORLD = "world"


def read(document: Document) -> Document:
    """The URDF that says the same as an MJCF; raises UrdfError if that is no linkage, or MuJoCo refuses the file."""
    try:
        import mujoco  # optional, and slow to import
    except ImportError as error:
        raise PinpressError(
            f"{document.file}: MJCF is read by the package mujoco; pip install 'pinpress[peers]', or mujoco alone"
        ) from error
    _refuse_odd_files(document, document.robot, Path(document.file).absolute().parent, set())
    warned: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(warned.append)  # else they are written to stderr, and to a file in the working directory
    try:
        spec = _parse(mujoco, document)
        spec.compiler.fusestatic = False
        model = spec.compile()
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise UrdfError(document.file, "<mujoco>", None, f"MuJoCo cannot read it: {reason}", "correct the file") from error
    finally:
        mujoco.set_mju_user_warning(before)
    reader = _Reader(document, mujoco, spec, model)
    reader.remarks += [remark("warning", reader.root, f"MuJoCo warns: {' '.join(text.split())}", "correct the file") for text in warned]
    return as_document(document.file, reader.mechanism(), f"MJCF by MuJoCo {mujoco.__version__}")


def _refuse_odd_files(document: Document, root: Element, folder: Path, seen: set[Path]) -> None:
    """Raise UrdfError if a file that MuJoCo would open is a pipe or a device, which may have no end, or if an included file lies
    outside of the model's folder: a user who loads somebody else's model does not expect it to read other files."""
    names = "assetdir", "meshdir", "texturedir"  # of folders in which MuJoCo looks for files
    places = [folder, *(folder / each.get(name) for each in _all(root, "compiler") for name in names if each.get(name))]
    tags = "include", "mesh", "hfield", "texture", "skin", "model"  # of elements that name files
    for element in [each for tag in tags for each in _all(root, tag) if each.get("file")]:
        for path in {Path(os.path.normpath(place / element.get("file"))) for place in places}:  # as MuJoCo takes .. out
            if path.exists() and not path.is_file():
                refuse(document.file, element, f"{shown(str(path))} is not a regular file", "give one")
    for element in _all(root, "include"):
        path = Path(os.path.normpath(folder / element.get("file"))).resolve()
        if not path.is_relative_to(folder.resolve()):
            refuse(document.file, element, f"{shown(str(path))} is outside of the model's folder", "copy it there")
        if path.is_file() and path not in seen:
            seen.add(path)
            _refuse_odd_files(document, tree(str(path), read_text(path)), folder, seen)


def _parse(mujoco: Any, document: Document) -> Any:
    """MuJoCo's specification of a file. MuJoCo reads the file itself if its name ends in .xml, so that it finds included files."""
    if document.file.endswith(".xml"):
        return mujoco.MjSpec.from_file(document.file)
    spec = mujoco.MjSpec.from_string(document.text.decode("utf-8-sig"))
    spec.modelfiledir = os.path.dirname(os.path.abspath(document.file))
    return spec


class _Reader:
    """Reads a compiled model, and the elements from which it was made."""

    def __init__(self, document: Document, package: Any, spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
        self.file, self.mujoco, self.spec, self.model = document.file, package, spec, model
        self.root = Origin(f'<mujoco model="{spec.modelname}">', document.robot.line)
        self.included = bool(_all(document.robot, "include"))
        self.remarks: list[Finding] = []
        self.balls: list[tuple[str, ...]] = []
        self.taken: set[str] = set()
        self.bodies = self._by_id(spec.bodies)
        self.hinges = self._by_id(spec.joints)
        self.equalities = self._by_id(spec.equalities)
        self.body_names = self._names(self.bodies, "body", {WORLD})
        self.body_names[0] = WORLD
        self.joint_names = self._names(self.hinges, "joint", set())

    def _by_id(self, elements: Any) -> dict[int, Any]:
        return {int(element.id): element for element in elements}

    def _names(self, elements: Mapping[int, Any], tag: str, taken: set[str]) -> dict[int, str]:
        """Names of all elements; those without a name get one."""
        taken |= {element.name for element in elements.values()}
        names = {}
        for k, element in sorted(elements.items()):
            names[k] = element.name or make_unique(f"{tag}_{k}", taken)
            taken.add(names[k])
        return names

    def _origin(self, element: Any, tag: str, name: str) -> Origin:
        """Origin of an element, as far as MuJoCo knows it: with several files it does not know which one."""
        words = str(element.info).split()
        line = int(words[-1]) if not self.included and len(words) > 1 and words[-1].isdecimal() else self.root.line
        return Origin(f'<{tag} name="{name}">', line)

    def mechanism(self) -> Mechanism:
        self._refuse_what_moves_otherwise()
        held = self._held_body()
        links = [self._link(body) for body in range(self.model.nbody)]
        joints: list[Joint] = []
        for body in range(1, self.model.nbody):
            made, between = self._carrier(body, held)
            joints += made
            links += between
        self.taken |= {joint.name for joint in joints}
        joints, loops = self._with_equalities(joints)
        self._remark_on_forces()
        name = self.spec.modelname or "press"
        drivers = tuple(self._drivers())
        return Mechanism(name, tuple(links), tuple(joints), tuple(loops), drivers, tuple(self.remarks), self.root, tuple(self.balls))

    # --------------------------------------------------------------------------------------------------------------- what is not a linkage

    def _refuse_what_moves_otherwise(self) -> None:
        model = self.model
        for body in range(1, model.nbody):
            if model.body_mocapid[body] >= 0:
                refuse(self.file, self._body_origin(body), "a mocap body is moved by hand", "give it a joint and drive that")
        if model.nflex:
            refuse(self.file, self.root, "<flex> and <flexcomp> are deformable bodies", "write rigid bodies")
        if self.model.nplugin:
            self.remarks.append(remark("warning", self.root, "plugins are not read", "give what they do as drives and loads"))

    def _held_body(self) -> int | None:
        """The body whose free joint is removed, if it has the only one and the model is joined to the world nowhere else; None if there
        is no free joint."""
        model, free_type = self.model, int(self.mujoco.mjtJoint.mjJNT_FREE)
        free = [k for k in range(model.njnt) if model.jnt_type[k] == free_type]
        if not free:
            return None
        first = int(model.jnt_bodyid[free[0]])
        origin = self._body_origin(first)
        roots = {int(model.body_rootid[body]) for body in range(1, model.nbody) if model.body_jntnum[body]}
        if len(free) > 1 or roots != {first} or any(WORLD in self._ends(k) for k in self._active() if self._is_loop(k)):
            refuse(
                self.file,
                origin,
                "a free joint beside other bodies cannot be read",
                "write the joints that guide the body, or leave it out",
            )
        problem = "the body is free: it is held where it is drawn"
        self.remarks.append(remark("warning", origin, problem, "remove its <freejoint>, if that is meant"))
        return first

    def _remark_on_forces(self) -> None:
        """Warn of forces that act in MuJoCo and are not in a URDF."""
        model = self.model
        for k, joint in sorted(self.hinges.items()):
            if model.jnt_type[k] == int(self.mujoco.mjtJoint.mjJNT_FREE):
                continue
            origin, dof = self._origin(joint, "joint", self.joint_names[k]), int(model.jnt_dofadr[k])
            if model.dof_armature[dof]:
                problem = f"armature={model.dof_armature[dof]:g} is not read"
                self.remarks.append(remark("warning", origin, problem, "give it as a flywheel, or set it in press.model.armature"))
            if np.any(model.jnt_stiffness[k]):
                problem = "the spring of the joint is not read"
                self.remarks.append(remark("warning", origin, problem, "give it as a load: loads=[SpringDamper(...)]"))
        if model.ntendon:
            problem = f"{model.ntendon} tendons are not read"
            self.remarks.append(remark("warning", self.root, problem, "give their forces as loads"))
        if np.any(model.body_gravcomp):
            self.remarks.append(remark("warning", self.root, "gravcomp is not read", "load(..., gravity=(0, 0, 0)) leaves gravity out"))
        if model.opt.density or model.opt.viscosity:
            self.remarks.append(remark("warning", self.root, "density and viscosity of a medium are not read", "give its forces as loads"))
        if np.abs(model.opt.gravity - [0.0, 0.0, -9.81]).max() > 1e-9:
            remedy = f"load(..., gravity=({', '.join(f'{part:g}' for part in model.opt.gravity)}))"
            self.remarks.append(remark("warning", self.root, "the gravity of the file is not read", remedy))

    # ------------------------------------------------------------------------------------------------------------------------------ bodies

    def _body_origin(self, body: int) -> Origin:
        return self._origin(self.bodies[body], "body", self.body_names[body]) if body else self.root

    def _shift(self, body: int) -> Array:
        """(3,) origin of the link in the body's frame: a point on the axis of the joint that carries it."""
        joints = self._joints_of(body)
        return np.array(self.model.jnt_pos[joints[-1]]) if joints and self._turns(joints[-1]) else np.zeros(3)

    def _joints_of(self, body: int) -> list[int]:
        """Joints that move a body relative to its parent, in their order, without a free joint."""
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        free = int(self.mujoco.mjtJoint.mjJNT_FREE)
        return [k for k in range(first, first + count) if self.model.jnt_type[k] != free]

    def _turns(self, joint: int) -> bool:
        return bool(self.model.jnt_type[joint] != int(self.mujoco.mjtJoint.mjJNT_SLIDE))

    def _inside(self, body: int, position: Array, quaternion: Array) -> pin.SE3:
        """A place that is given in a body's frame, in the frame of its link."""
        return pin.SE3(_rotation(quaternion), np.array(position) - self._shift(body))

    def _link(self, body: int) -> Link:
        origin = self._body_origin(body)
        return Link(self.body_names[body], self._inertia(body, origin), tuple(self._shapes(body)), origin)

    def _inertia(self, body: int, origin: Origin) -> Inertia | None:
        """The inertia with which MuJoCo computes; if it is the tensor in the file, with all digits of the file."""
        model, mass = self.model, float(self.model.body_mass[body])
        if body == 0 or not mass:
            return None if not self._joints_of(body) else Inertia(0.0, pin.SE3.Identity(), np.zeros((3, 3)), origin)
        place = self._inside(body, model.body_ipos[body], model.body_iquat[body])
        tensor = np.diag(model.body_inertia[body])
        xx, yy, zz, xy, xz, yz = self.bodies[body].fullinertia
        in_file = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        compiled = place.rotation @ tensor @ place.rotation.T
        # Else MuJoCo made the inertia from shapes, or changed it; the tensor is NaN where the file has none.
        if np.abs(in_file - compiled).max() <= 1e-9 * np.abs(compiled).max():
            return Inertia(mass, pin.SE3(np.eye(3), place.translation), in_file, origin)
        return Inertia(mass, place, tensor, origin)

    def _shapes(self, body: int) -> Iterator[Shape]:
        model, undrawn = self.model, 0
        kinds = "BOX", "SPHERE", "CYLINDER", "CAPSULE", "MESH"
        box, sphere, cylinder, capsules, mesh = (int(getattr(self.mujoco.mjtGeom, f"mjGEOM_{kind}")) for kind in kinds)
        first = int(model.body_geomadr[body])
        for geom in range(first, first + int(model.body_geomnum[body])):
            # MuJoCo shows shapes of groups 0 to 2; the others are mostly for collisions.
            if model.geom_group[geom] >= 3:
                continue
            place = self._inside(body, model.geom_pos[geom], model.geom_quat[geom])
            size, kind, colour = model.geom_size[geom], model.geom_type[geom], tuple(model.geom_rgba[geom])
            if kind == box:
                yield Shape(place, "box", {"size": as_text(2 * size)}, colour)
            elif kind == sphere:
                yield Shape(place, "sphere", {"radius": as_text(size[:1])}, colour)
            elif kind == cylinder:
                yield Shape(place, "cylinder", {"radius": as_text(size[:1]), "length": as_text(2 * size[1:2])}, colour)
            elif kind == capsules:
                yield from capsule(place, float(size[0]), 2 * float(size[1]), colour)
            else:
                undrawn += body > 0 or kind == mesh
        if undrawn:
            problem = f"{undrawn} shapes that are no boxes, cylinders, spheres or capsules are not drawn"
            self.remarks.append(remark("note", self._body_origin(body), problem, ""))

    # ------------------------------------------------------------------------------------------------------------------------------ joints

    def _carrier(self, body: int, held: int | None) -> tuple[list[Joint], list[Link]]:
        """The joints from the parent of a body to it, with links without mass between them."""
        model, child = self.model, self.body_names[body]
        parent_body = int(model.body_parentid[body])
        parent, joints = self.body_names[parent_body], self._joints_of(body)
        place = pin.SE3(_rotation(model.body_quat[body]), np.array(model.body_pos[body]) - self._shift(parent_body))
        if not joints:
            name = make_unique(f"{child}_{'held' if body == held else 'fixed'}", {*self.joint_names.values()})
            return [Joint(name, "fixed", parent, child, place, np.array([1.0, 0.0, 0.0]), self._body_origin(body))], []
        made: list[Joint] = []
        links: list[Link] = []
        reached = np.zeros(3)  # origin of the last frame, in that of the body
        steps = [(k, axis, name) for k in joints for axis, name in self._axes(k)]
        for step, (k, axis, name) in enumerate(steps):
            last = step == len(steps) - 1
            origin = self._origin(self.hinges[k], "joint", self.joint_names[k])
            anchor = np.array(model.jnt_pos[k]) if self._turns(k) else reached
            link = child if last else make_unique(f"{child}_{step + 1}", {*self.body_names.values()})
            anchor = self._shift(body) if last else anchor
            made.append(self._joint(k, name, axis, parent, link, place * pin.SE3(np.eye(3), anchor - reached), origin))
            if not last:
                links.append(massless_link(link, origin))
            parent, place, reached = link, pin.SE3.Identity(), anchor
        return made, links

    def _axes(self, joint: int) -> list[tuple[Array, str]]:
        """Axes and names of the joints that stand for a joint: three for a ball."""
        name = self.joint_names[joint]
        if self.model.jnt_type[joint] != int(self.mujoco.mjtJoint.mjJNT_BALL):
            return [(np.array(self.model.jnt_axis[joint]), name)]
        names = [f"{name}_{axis}" for axis in "xyz"]
        self.balls.append(tuple(names))
        problem = f"a ball joint is made of revolute joints: {', '.join(names)}"
        self.remarks.append(remark("note", self._origin(self.hinges[joint], "joint", name), problem, ""))
        return list(zip(np.eye(3), names, strict=True))

    def _joint(self, k: int, name: str, axis: Array, parent: str, child: str, place: pin.SE3, origin: Origin) -> Joint:
        model, dof = self.model, int(self.model.jnt_dofadr[k])
        limits, ball = None, model.jnt_type[k] == int(self.mujoco.mjtJoint.mjJNT_BALL)
        if model.jnt_limited[k] and not ball:
            drawn = float(model.qpos0[model.jnt_qposadr[k]])  # ref
            lower, upper = (float(limit) - drawn for limit in model.jnt_range[k])
            limits = lower, upper
        return Joint(
            name,
            "revolute" if self._turns(k) else "prismatic",
            parent,
            child,
            place,
            axis,
            origin,
            limits=limits,
            damping=float(np.ravel(model.dof_damping[dof])[0]),
            friction=float(model.dof_frictionloss[dof]),
        )

    # -------------------------------------------------------------------------------------------------------------------------- equalities

    def _active(self) -> list[int]:
        return [k for k in range(self.model.neq) if self.model.eq_active0[k]]

    def _is_loop(self, k: int) -> bool:
        return self.model.eq_type[k] in (int(self.mujoco.mjtEq.mjEQ_CONNECT), int(self.mujoco.mjtEq.mjEQ_WELD))

    def _ends(self, k: int) -> tuple[str, str]:
        """Names of the two bodies of a connect or weld."""
        one, two = (self.body_names[body] for body in self._end_bodies(k))
        return one, two

    def _end_bodies(self, k: int) -> tuple[int, int]:
        one, two = int(self.model.eq_obj1id[k]), int(self.model.eq_obj2id[k])
        if self._by_sites(k):
            return int(self.model.site_bodyid[one]), int(self.model.site_bodyid[two])
        return one, two

    def _by_sites(self, k: int) -> bool:
        return bool(self.model.eq_objtype[k] == int(self.mujoco.mjtObj.mjOBJ_SITE))

    def _with_equalities(self, joints: list[Joint]) -> tuple[list[Joint], list[Loop]]:
        """The joints with their gear pairs, and the loops."""
        by_name = {joint.name: joint for joint in joints}
        loops: list[Loop] = []
        tags = {int(getattr(self.mujoco.mjtEq, f"mjEQ_{tag.upper()}")): tag for tag in ("connect", "weld", "joint", "tendon")}
        for k, element in sorted(self.equalities.items()):
            tag = tags.get(int(self.model.eq_type[k]), "flex")
            ends = "_".join(self._ends(k)) if self._is_loop(k) else str(k)
            name = make_unique(element.name or f"{tag}_{ends}", self.taken)
            origin = self._origin(element, tag, name)
            if not self.model.eq_active0[k]:
                self.remarks.append(remark("note", origin, 'it is left out, as active="false" says', ""))
            elif self._is_loop(k):
                loops.append(self._loop(k, name, origin))
                self.taken.add(name)
            elif tag == "joint":
                joint = self._gear(k, by_name, origin)
                by_name[joint.name] = joint
            else:
                refuse(self.file, origin, f"<equality><{tag}> cannot be read", "write <connect>, <weld> or <joint>")
        return list(by_name.values()), loops

    def _loop(self, k: int, name: str, origin: Origin) -> Loop:
        """A connect or weld. The data of one between bodies hold its points: for a connect the point in each body, for a weld the pose of
        the second body's frame in the first, and an anchor in the second. A weld with ``torquescale="0"`` is a connect."""
        model, (one, two) = self.model, self._end_bodies(k)
        weld = model.eq_type[k] == int(self.mujoco.mjtEq.mjEQ_WELD)
        data, straight = model.eq_data[k], np.array([1.0, 0.0, 0.0, 0.0])
        turns = not weld or data[10] == 0  # the place of a weld's torquescale among its data
        if self._by_sites(k):
            sites = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
            places = [(model.site_pos[site], straight if turns else model.site_quat[site]) for site in sites]
        elif weld:
            places = [(data[3:6], straight if turns else data[6:10]), (data[:3], straight)]
        else:
            places = [(data[:3], straight), (data[3:6], straight)]
        ends = [(self.body_names[body], self._inside(body, *place)) for body, place in zip((one, two), places, strict=True)]
        return Loop(name, "spherical" if turns else "fixed", (ends[0], ends[1]), None, origin)

    def _gear(self, k: int, joints: Mapping[str, Joint], origin: Origin) -> Joint:
        """Joint 1 as an equality of joints moves it: its position from the drawn pose is a polynomial of that of joint 2."""
        model = self.model
        offset, ratio, *higher = (float(value) for value in model.eq_data[k][:5])
        first, second = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
        names = [self.joint_names.get(joint, "") for joint in (first, second)]
        if second < 0:
            if offset:
                refuse(self.file, origin, "it holds a joint beside the drawn pose", "draw it there, or give it no joint")
            return replace(joints[names[0]], type="fixed", limits=None)
        if any(higher):
            refuse(self.file, origin, "joints that follow each other by a polynomial cannot be read", "write polycoef of two numbers")
        if not ratio:
            refuse(self.file, origin, "polycoef has no linear term: the joint is held", "write an equality of this joint alone")
        for name in names:
            if name not in joints:
                refuse(self.file, origin, f"joint {name!r} has several coordinates", "couple hinges and slides")
        if joints[names[0]].follow is None:
            return replace(joints[names[0]], follow=Follow(names[1], ratio, offset, origin))
        if joints[names[1]].follow is None:
            return replace(joints[names[1]], follow=Follow(names[0], 1 / ratio, -offset / ratio, origin))
        refuse(self.file, origin, "both joints follow another one already", "let each joint follow one")

    # ----------------------------------------------------------------------------------------------------------------------------- drivers

    def _drivers(self) -> Iterator[tuple[str, Origin]]:
        """Joints with an actuator, in the order of the actuators."""
        model, seen = self.model, set()
        several = (int(self.mujoco.mjtJoint.mjJNT_FREE), int(self.mujoco.mjtJoint.mjJNT_BALL))
        of_joints = (int(self.mujoco.mjtTrn.mjTRN_JOINT), int(self.mujoco.mjtTrn.mjTRN_JOINTINPARENT))
        for actuator in sorted(self.spec.actuators, key=lambda each: int(each.id)):
            k = int(actuator.id)
            origin = self._origin(actuator, "actuator", actuator.name or str(k))
            joint = int(model.actuator_trnid[k][0])
            if model.actuator_trntype[k] not in of_joints or model.jnt_type[joint] in several:
                self.remarks.append(remark("warning", origin, "an actuator of no hinge or slide is not read", "drive a joint"))
            elif joint not in seen:
                seen.add(joint)
                yield self.joint_names[joint], origin


def _rotation(quaternion: Array) -> Array:
    """(3, 3) rotation matrix of a quaternion, w first."""
    w, x, y, z = (float(part) for part in quaternion)
    return np.asarray(pin.Quaternion(w, x, y, z).normalized().matrix())


def _all(element: Element, tag: str) -> list[Element]:
    """All elements with a tag that an element contains, at any depth."""
    elements = element.all(tag)
    for child in element.children:
        elements += _all(child, tag)
    return elements
