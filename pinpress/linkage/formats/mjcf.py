"""MJCF, the format of MuJoCo (mujoco.readthedocs.io, "XML Reference"), read by the package mujoco itself.

MuJoCo's compiler resolves classes, includes, frames, angles in degrees and inertia from shapes. Bodies with hinges, slides, balls and free
joints make the tree; ``<equality>`` closes its loops: ``<connect>`` is a pin, ``<weld>`` is fixed, ``<joint>`` a gear pair, ``<tendon>`` an
equation between joints. MuJoCo's equalities are slightly elastic; here they hold exactly.

Coordinates of hinges and slides are MuJoCo's ``qpos``: at ``ref`` the bodies are where the file draws them. The linkage is put together in
the keyframe ``home``, else in the first keyframe, else as drawn.
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
from ...engines.structure import Axis
from ..document import Document, Finding, Origin
from ..document import read as read_text
from ..element import Element, tree
from ..text import as_text
from .elements import make_unique, refuse, remark, take
from .mechanism import (
    Follow,
    Inertia,
    Joint,
    Link,
    Loop,
    Mechanism,
    Relation,
    Shape,
    Spring,
    as_document,
    capsule,
    in_series,
    with_hinges,
)

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
        spec, model, without_files = _compile(mujoco, document)
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise UrdfError(document.file, "<mujoco>", None, f"MuJoCo cannot read it: {reason}", "correct the file") from error
    finally:
        mujoco.set_mju_user_warning(before)
    reader = _Reader(document, mujoco, spec, model)
    reader.remarks += [remark("warning", reader.root, f"MuJoCo warns: {' '.join(text.split())}", "correct the file") for text in warned]
    if without_files:
        reader.remarks.append(remark("note", reader.root, "it is read without meshes and textures, because files are missing", ""))
    return as_document(document.file, reader.mechanism(), f"MJCF by MuJoCo {mujoco.__version__}")


def _compile(mujoco: Any, document: Document) -> tuple[Any, Any, bool]:
    """MuJoCo's specification and model of a file; and whether meshes, height fields and textures were left out, because files are missing
    and every body that moves has an inertia without them.

    Raises:
        UrdfError: the inertia of a body that moves comes from a mesh, and files are missing.
    """
    spec = _parse(mujoco, document)
    try:
        return spec, spec.compile(), False
    except (ValueError, RuntimeError) as error:
        spec = _parse(mujoco, document)  # a failed compilation changes it
        drawn = [geom for geom in spec.geoms if geom.meshname or geom.hfieldname]
        assets = [*spec.meshes, *spec.hfields, *spec.textures, *spec.skins]
        if not assets or "opening file" not in str(error):
            raise
        for body in (geom.parent for geom in drawn):
            if not body.explicitinertial and any(each.joints for each in _upwards(body)):
                reason = " ".join(str(error).split())
                problem = f"the inertia of body {body.name!r} comes from a mesh, and MuJoCo cannot read it: {reason}"
                raise UrdfError(
                    document.file, f'<body name="{body.name}">', None, problem, "put the file there, or give each such body an <inertial>"
                ) from error
        for material in spec.materials:
            for k in range(len(material.textures)):
                material.textures[k] = ""
        for element in (*drawn, *assets):
            spec.delete(element)
        return spec, spec.compile(), True


def _upwards(body: Any) -> Iterator[Any]:
    """A body of a specification and those that carry it, but for the world, of which older versions of MuJoCo know no parent."""
    while body.name != "world":  # a name that no other body may have
        yield body
        body = body.parent


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
        spec = mujoco.MjSpec.from_file(document.file)
    else:
        spec = mujoco.MjSpec.from_string(document.text.decode("utf-8-sig"))
        spec.modelfiledir = os.path.dirname(os.path.abspath(document.file))
    spec.compiler.fusestatic = False
    return spec


class _Reader:
    """Reads a compiled model, and the elements from which it was made."""

    def __init__(self, document: Document, package: Any, spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
        self.file, self.mujoco, self.spec, self.model = document.file, package, spec, model
        self.root = Origin(f'<mujoco model="{spec.modelname}">', document.robot.line)
        self.included = bool(_all(document.robot, "include"))
        self.remarks: list[Finding] = []
        self.balls: dict[int, tuple[str, ...]] = {}
        self.bodies = _by_id(spec.bodies)
        self.hinges = _by_id(spec.joints)
        self.equalities = _by_id(spec.equalities)
        self.taken: set[str] = set()  # names of joints and loops
        self.links: set[str] = set()  # names of links
        self.joint_names = _names(self.hinges, "joint", self.taken)
        self.body_names = _names(self.bodies, "body", self.links)
        self.free = {int(model.jnt_bodyid[k]): k for k in range(model.njnt) if model.jnt_type[k] == int(package.mjtJoint.mjJNT_FREE)}
        home = int(package.mj_name2id(model, int(package.mjtObj.mjOBJ_KEY), "home"))  # -1 without a keyframe of that name
        self.start = model.key_qpos[max(home, 0)] if model.nkey else model.qpos0
        self.drivers = dict(self._drivers())

    def _origin(self, element: Any, tag: str, name: str) -> Origin:
        """Origin of an element, as far as MuJoCo knows it: with several files it does not know which one."""
        words = str(element.info).split()
        line = int(words[-1]) if not self.included and len(words) > 1 and words[-1].isdecimal() else self.root.line
        return Origin(f'<{tag} name="{name}">', line)

    def mechanism(self) -> Mechanism:
        self._refuse_what_moves_otherwise()
        welds = self._welds_of_free_bodies()
        links = [self._link(body) for body in range(self.model.nbody)]
        joints: list[Joint] = []
        for body in range(1, self.model.nbody):
            made, between = self._carrier(body, welds)
            joints += made
            links += between
        joints, loops, relations = self._with_equalities(joints, set(welds.values()))
        self._remark_on_forces()
        fixed = {joint.name for joint in joints if joint.type == "fixed"}
        for name in fixed & self.drivers.keys():
            problem = f"an equality holds joint {name!r}: it does not drive"
            self.remarks.append(remark("warning", self.drivers[name], problem, "remove the actuator or the equality"))
        return Mechanism(
            self.spec.modelname or "press",
            tuple(links),
            tuple(joints),
            tuple(loops),
            tuple((name, origin) for name, origin in self.drivers.items() if name not in fixed),
            tuple(self.remarks),
            self.root,
            tuple(self.balls.values()),
            tuple(relations),
            {name: position for name, position in self._home() if name not in fixed},
        )

    def _home(self) -> Iterator[tuple[str, float | Array]]:
        """Coordinates of hinges and slides at the start, and rotations of balls by the names of their first hinges."""
        for k, adr in enumerate(self.model.jnt_qposadr):
            if k in self.balls:
                yield self.balls[k][0], _rotation(self.start[adr : adr + 4])
            elif int(self.model.jnt_bodyid[k]) not in self.free:
                yield self.joint_names[k], float(self.start[adr])

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

    def _welds_of_free_bodies(self) -> dict[int, int]:
        """The equality that welds a body with a free joint to the world, by the body; it holds the body.

        Raises:
            UrdfError: a free body is joined to nothing, next to others.
        """
        welds: dict[int, int] = {}
        joined: set[int] = set()
        for k in filter(self._is_loop, np.flatnonzero(self.model.eq_active0).tolist()):
            ends = self._end_bodies(k)
            joined |= {int(self.model.body_rootid[body]) for body in ends}
            if 0 in ends and max(ends) in self.free and not self._turns_in(k):
                welds.setdefault(max(ends), k)
        roots = {int(self.model.body_rootid[body]) for body in range(1, self.model.nbody) if self.model.body_jntnum[body]}
        for body in self.free:
            if len(roots) > 1 and body not in joined:
                problem, remedy = "a free body that nothing joins to the others", "write what joins it, or leave it out"
                refuse(self.file, self._body_origin(body), problem, remedy)
        return welds

    def _remark_on_forces(self) -> None:
        """Warn of forces that act in MuJoCo and are not in a URDF."""
        model = self.model
        for k, joint in sorted(self.hinges.items()):
            origin, dof = self._origin(joint, "joint", self.joint_names[k]), int(model.jnt_dofadr[k])
            several = k in self.balls or int(model.jnt_bodyid[k]) in self.free
            if several and (model.jnt_stiffness[k] or model.dof_damping[dof] or model.dof_armature[dof]):
                problem = "stiffness, damping and armature of a joint with several coordinates are not read"
                self.remarks.append(remark("warning", origin, problem, "write hinges and slides"))
        acts = (_values(model, f"tendon_{what}") for what in ("stiffness", "damping", "frictionloss", "limited", "armature"))
        if acting := np.count_nonzero(sum(np.abs(values[: model.ntendon]) for values in acts)):
            problem = f"springs, dampers, friction, limits and inertia of {acting} tendons are not read"
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
        return [] if body in self.free else list(range(first, first + count))

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

    def _carrier(self, body: int, welds: Mapping[int, int]) -> tuple[list[Joint], list[Link]]:
        """The joints from the parent of a body to it, with links without mass between them; ``welds``: of free bodies to the world."""
        model, child = self.model, self.body_names[body]
        parent_body = int(model.body_parentid[body])
        parent, joints = self.body_names[parent_body], self._joints_of(body)
        place = pin.SE3(_rotation(model.body_quat[body]), np.array(model.body_pos[body]) - self._shift(parent_body))
        if not joints:
            kind = "floating" if body in self.free and body not in welds else "fixed"
            if kind == "floating":
                adr = int(model.jnt_qposadr[self.free[body]])
                place = pin.SE3(_rotation(self.start[adr + 3 : adr + 7]), np.array(self.start[adr : adr + 3]))
            elif body in welds:
                end, other = (place for _, place in self._places(welds[body]))
                place = end * other.inverse() if self._end_bodies(welds[body])[1] == body else other * end.inverse()
            given = self.hinges[self.free[body]].name if body in self.free else ""
            name = given or take(f"{child}_{'free' if kind == 'floating' else 'fixed'}", self.taken)
            return [Joint(name, kind, parent, child, place, np.array([1.0, 0.0, 0.0]), self._body_origin(body))], []
        made: list[Joint] = []
        reached = np.zeros(3)  # origin of the last frame, in that of the body
        steps = [(k, axis, name) for k in joints for axis, name in self._axes(k)]
        for step, (k, axis, name) in enumerate(steps, 1):
            anchor = self._shift(body) if step == len(steps) else np.array(model.jnt_pos[k]) if self._turns(k) else reached
            made.append(self._joint(k, name, axis, place * pin.SE3(np.eye(3), anchor - reached)))
            place, reached = pin.SE3.Identity(), anchor
        return in_series(made, parent, child, [take(f"{child}_{step}", self.links) for step in range(1, len(steps))])

    def _axes(self, joint: int) -> list[tuple[Array, str]]:
        """Axes and names of the joints that stand for a joint: three for a ball."""
        name = self.joint_names[joint]
        if self.model.jnt_type[joint] != int(self.mujoco.mjtJoint.mjJNT_BALL):
            return [(np.array(self.model.jnt_axis[joint]), name)]
        names = [take(f"{name}_{axis}", self.taken) for axis in "xyz"]
        self.balls[joint] = tuple(names)
        problem = f"a ball joint is made of revolute joints: {', '.join(names)}"
        self.remarks.append(remark("note", self._origin(self.hinges[joint], "joint", name), problem, ""))
        return list(zip(np.eye(3), names, strict=True))

    def _joint(self, k: int, name: str, axis: Array, place: pin.SE3) -> Joint:
        """A hinge or slide of a joint, whose parent and child are still open."""
        model, dof, kind = self.model, int(self.model.jnt_dofadr[k]), "revolute" if self._turns(k) else "prismatic"
        origin = self._origin(self.hinges[k], "joint", self.joint_names[k])
        if k in self.balls:
            return Joint(name, kind, "", "", place, axis, origin, friction=float(model.dof_frictionloss[dof]))
        spring, armature = self._spring(k, origin)
        return Joint(
            name,
            kind,
            "",
            "",
            place * Axis(axis, kind == "revolute").step(-float(model.qpos0[model.jnt_qposadr[k]])),  # the body is drawn at ref
            axis,
            origin,
            limits=(float(model.jnt_range[k][0]), float(model.jnt_range[k][1])) if model.jnt_limited[k] else None,
            effort=self._effort(k),
            friction=float(model.dof_frictionloss[dof]),
            spring=spring,
            armature=armature,
        )

    def _spring(self, k: int, origin: Origin) -> tuple[Spring | None, float]:
        """Spring, damper and armature of a hinge or slide, with those of the actuators that turn with it."""
        model, dof = self.model, int(self.model.jnt_dofadr[k])
        higher = np.concatenate([np.ravel(_values(model, name)[at]) for name, at in (("jnt_stiffnesspoly", k), ("dof_dampingpoly", dof))])
        if higher.any():
            problem = "stiffness or damping grows with position or speed (a polynomial), which cannot be read"
            refuse(self.file, origin, problem, "write one number")
        damping, armature = float(model.dof_damping[dof]), float(model.dof_armature[dof])
        for actuator in self._actuators_of(k):
            squared = float(model.actuator_gear[actuator][0]) ** 2
            damping += squared * float(_values(model, "actuator_damping")[actuator])
            armature += squared * float(_values(model, "actuator_armature")[actuator])
        stiffness, reference = float(model.jnt_stiffness[k]), float(model.qpos_spring[model.jnt_qposadr[k]])
        return Spring(stiffness, reference if stiffness else 0.0, damping) if stiffness or damping else None, armature

    def _actuators_of(self, joint: int) -> list[int]:
        """The actuators that act on a joint itself."""
        of_joints = (int(self.mujoco.mjtTrn.mjTRN_JOINT), int(self.mujoco.mjtTrn.mjTRN_JOINTINPARENT))
        model = self.model
        return [k for k in range(_count(model)) if model.actuator_trntype[k] in of_joints and model.actuator_trnid[k][0] == joint]

    def _effort(self, joint: int) -> float | None:
        """The largest effort of all actuators on a joint [N m or N]; None if it has no limit."""
        model, total = self.model, 0.0
        for k in self._actuators_of(joint):
            bounds = [np.abs(model.actuator_forcerange[k]).max()] if model.actuator_forcelimited[k] else []
            if model.actuator_ctrllimited[k] and not (
                model.actuator_gaintype[k] or model.actuator_biastype[k] or model.actuator_dyntype[k]
            ):
                bounds.append(np.abs(model.actuator_ctrlrange[k]).max() * abs(model.actuator_gainprm[k][0]))  # the control is the force
            total += min(bounds, default=np.inf) * abs(model.actuator_gear[k][0])
        bound = np.abs(model.jnt_actfrcrange[joint]).max() if model.jnt_actfrclimited[joint] else np.inf
        least = float(min(bound, total or np.inf))
        return least if np.isfinite(least) else None

    # -------------------------------------------------------------------------------------------------------------------------- equalities

    def _is_loop(self, k: int) -> bool:
        return self.model.eq_type[k] in (int(self.mujoco.mjtEq.mjEQ_CONNECT), int(self.mujoco.mjtEq.mjEQ_WELD))

    def _end_bodies(self, k: int) -> tuple[int, int]:
        """The two bodies of a connect or weld."""
        one, two = int(self.model.eq_obj1id[k]), int(self.model.eq_obj2id[k])
        if self._by_sites(k):
            return int(self.model.site_bodyid[one]), int(self.model.site_bodyid[two])
        return one, two

    def _by_sites(self, k: int) -> bool:
        return bool(self.model.eq_objtype[k] == int(self.mujoco.mjtObj.mjOBJ_SITE))

    def _with_equalities(self, joints: list[Joint], done: set[int]) -> tuple[list[Joint], list[Loop], list[Relation]]:
        """The joints with their gear pairs, the loops, and relations between other joints; ``done``: welds that hold free bodies."""
        by_name = {joint.name: joint for joint in joints}
        loops: list[Loop] = []
        relations: list[Relation] = []
        tags = {int(getattr(self.mujoco.mjtEq, f"mjEQ_{tag.upper()}")): tag for tag in ("connect", "weld", "joint", "tendon")}
        for k, element in sorted(self.equalities.items()):
            tag = tags.get(int(self.model.eq_type[k]), "flex")
            ends = "_".join(self.body_names[body] for body in self._end_bodies(k)) if self._is_loop(k) else str(k)
            name = make_unique(element.name or f"{tag}_{ends}", self.taken)  # taken only by what is read
            origin = self._origin(element, tag, name)
            if not self.model.eq_active0[k]:
                self.remarks.append(remark("note", origin, 'it is left out, as active="false" says', ""))
            elif k in done:
                self.remarks.append(remark("note", origin, "it holds a body with a free joint, which is read as fixed", ""))
            elif self._is_loop(k):
                loops.append(Loop(name, "spherical" if self._turns_in(k) else "fixed", self._places(k), None, origin))
                self.taken.add(name)
            elif tag in ("joint", "tendon"):
                self._relate(k, name, by_name, relations, origin)
                self.taken.add(name)
            else:
                refuse(self.file, origin, f"<equality><{tag}> cannot be read", "write <connect>, <weld>, <joint> or <tendon>")
        kept, merged = with_hinges(loops)
        self.remarks += [remark("note", first.origin, f"together with {loop.name!r} it is a hinge", "") for first, loop in merged]
        return list(by_name.values()), kept, relations

    def _turns_in(self, k: int) -> bool:
        """Whether a connect or weld lets its bodies turn; a weld with ``torquescale="0"`` is a connect."""
        weld = self.model.eq_type[k] == int(self.mujoco.mjtEq.mjEQ_WELD)
        return not weld or not self.model.eq_data[k][10]  # the place of a weld's torquescale among its data

    def _places(self, k: int) -> tuple[tuple[str, pin.SE3], tuple[str, pin.SE3]]:
        """The links of a connect or weld, with its place in each. The data of one between bodies hold its points: for a connect the point
        in each body, for a weld the pose of the second body's frame in the first, and an anchor in the second."""
        model, (one, two), turns = self.model, self._end_bodies(k), self._turns_in(k)
        data, straight = model.eq_data[k], np.array([1.0, 0.0, 0.0, 0.0])
        if self._by_sites(k):
            sites = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
            first, second = ((model.site_pos[site], straight if turns else model.site_quat[site]) for site in sites)
        elif model.eq_type[k] == int(self.mujoco.mjtEq.mjEQ_WELD):
            first, second = (data[3:6], straight if turns else data[6:10]), (data[:3], straight)
        else:
            first, second = (data[:3], straight), (data[3:6], straight)
        return (self.body_names[one], self._inside(one, *first)), (self.body_names[two], self._inside(two, *second))

    def _relate(self, k: int, name: str, joints: dict[str, Joint], relations: list[Relation], origin: Origin) -> None:
        """Add an equality of joints or of tendons of joints: what the first one has gained since the drawn pose is a polynomial of what the
        second one has. A pair becomes a gear pair; an equality of more joints determines one that nothing determines yet."""
        model, tendon = self.model, self.model.eq_type[k] == int(self.mujoco.mjtEq.mjEQ_TENDON)
        constant, ratio, *higher = (float(value) for value in model.eq_data[k][:5])
        if any(higher) and model.eq_obj2id[k] >= 0:
            refuse(self.file, origin, "joints that follow each other by a polynomial cannot be read", "write polycoef of two numbers")
        terms: dict[str, float] = {}
        offset = constant
        for one, factor in ((int(model.eq_obj1id[k]), 1.0), (int(model.eq_obj2id[k]), -ratio)):
            for joint, coefficient in self._joints_of_tendon(one, origin) if tendon and one >= 0 else ((one, 1.0),) * (one >= 0):
                if self.joint_names[joint] not in joints:
                    refuse(self.file, origin, f"joint {self.joint_names[joint]!r} has several coordinates", "couple hinges and slides")
                terms[self.joint_names[joint]] = terms.get(self.joint_names[joint], 0.0) + factor * coefficient
                offset += factor * coefficient * float(model.qpos0[model.jnt_qposadr[joint]])
        terms = {joint: coefficient for joint, coefficient in terms.items() if coefficient and joints[joint].type != "fixed"}
        determined = {relation_joint for relation in relations for relation_joint in list(relation.coefficients)[:1]}
        able = [joint for joint in terms if joints[joint].follow is None and joint not in determined]
        if not able:
            refuse(self.file, origin, "all its joints follow others already", "let each joint follow one")
        follower = min(able, key=lambda joint: joint in self.drivers)  # the first that does not drive
        (scale, *_), others = [terms[follower]], {joint: value for joint, value in terms.items() if joint != follower}
        if not others:
            held = joints[follower]
            place = held.place * Axis(held.axis, held.type == "revolute").step(offset / scale)
            joints[follower] = replace(held, type="fixed", place=place, limits=None, spring=None, armature=0.0)
        elif len(others) == 1:
            ((leader, value),) = others.items()
            joints[follower] = replace(joints[follower], follow=Follow(leader, -value / scale, offset / scale, origin))
        else:
            coefficients = {follower: 1.0} | {joint: value / scale for joint, value in others.items()}
            relations.append(Relation(name, coefficients, offset / scale, origin))

    def _joints_of_tendon(self, tendon: int, origin: Origin) -> list[tuple[int, float]]:
        """The joints of a fixed tendon, with their coefficients."""
        model, first = self.model, int(self.model.tendon_adr[tendon])
        parts = range(first, first + int(model.tendon_num[tendon]))
        if any(model.wrap_type[part] != int(self.mujoco.mjtWrap.mjWRAP_JOINT) for part in parts):
            refuse(self.file, origin, "a tendon in space cannot be read", "write a tendon of joints, <fixed>")
        return [(int(model.wrap_objid[part]), float(model.wrap_prm[part])) for part in parts]

    # ----------------------------------------------------------------------------------------------------------------------------- drivers

    def _drivers(self) -> Iterator[tuple[str, Origin]]:
        """Joints with an actuator, in the order of the actuators; of a tendon of joints the first one."""
        model, transmissions = self.model, self.mujoco.mjtTrn
        several = (int(self.mujoco.mjtJoint.mjJNT_FREE), int(self.mujoco.mjtJoint.mjJNT_BALL))
        loads: list[str] = []
        for actuator in sorted(self.spec.actuators, key=lambda each: int(each.id)):
            k, name = int(actuator.id), actuator.name or str(actuator.id)
            origin, kind, joint = self._origin(actuator, "actuator", name), int(model.actuator_trntype[k]), int(model.actuator_trnid[k][0])
            fixed = kind == int(transmissions.mjTRN_TENDON)
            fixed = fixed and model.wrap_type[model.tendon_adr[joint]] == int(self.mujoco.mjtWrap.mjWRAP_JOINT)
            if fixed:
                pulled = self._joints_of_tendon(joint, origin)
                length = " + ".join(f"{coefficient:g} {self.joint_names[each]}" for each, coefficient in pulled)
                joint = pulled[0][0]
                problem = f"it pulls at {length}: joint {self.joint_names[joint]} drives, with its own torque or force in results"
                self.remarks.append(remark("note", origin, problem, ""))
            elif kind not in (int(transmissions.mjTRN_JOINT), int(transmissions.mjTRN_JOINTINPARENT)) or model.jnt_type[joint] in several:
                loads.append(name)
                continue
            yield self.joint_names[joint], origin
        if loads:
            problem = f"actuators that act on no hinge or slide are not read: {', '.join(loads)}"
            self.remarks.append(remark("warning", self.root, problem, "drive joints, or give the forces as loads"))


def _by_id(elements: Any) -> dict[int, Any]:
    return {int(element.id): element for element in elements}


def _names(elements: Mapping[int, Any], tag: str, taken: set[str]) -> dict[int, str]:
    """Names of all elements; those without a name get one."""
    named_first = sorted(elements.items(), key=lambda item: (not item[1].name, item[0]))
    return {k: take(element.name or f"{tag}_{k}", taken) for k, element in named_first}


def _count(model: Any) -> int:
    """Number of actuators."""
    return len(model.actuator_trntype)


def _values(model: Any, name: str) -> Array:
    """Numbers of a model; zeros where MuJoCo is older than they are."""
    return np.asarray(getattr(model, name, np.zeros(model.nv + model.ntendon + _count(model))))


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
