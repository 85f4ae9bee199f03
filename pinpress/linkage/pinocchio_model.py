"""A `Linkage` of a user's own Pinocchio model and its constraints: the URDF that says the same, loaded as any other.

Joints of one coordinate keep their names and their zeros. A joint of several coordinates becomes a joint for each, called after it with an
ending (`_parts`), with links without mass between them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np
import pinocchio as pin

from ..common.arguments import LARGEST, expect, numbers, typed
from ..common.errors import PinpressError, UrdfError, caution, shown
from ..common.quantities import Array
from ..engines.constraints import Relation
from .document import Document, Origin
from .formats.elements import take
from .formats.free_bodies import Base
from .formats.mechanism import Follow, Inertia, Joint, Link, Loop, Mechanism, as_document, in_series, with_hinges
from .formats.mechanism import Relation as NamedRelation
from .linkage import Linkage
from .loading import load_document

Constraint: TypeAlias = "pin.RigidConstraintModel | pin.PointAnchorConstraintModel | pin.FrameAnchorConstraintModel"


@typed
def from_pinocchio(
    model: pin.Model,
    constraint_models: Sequence[Constraint] = (),
    drivers: str | Sequence[str] | None = None,
    q: Array | None = None,
    *,
    relations: Sequence[Relation] = (),
    slide: str | None = None,
    base: Base = "fixed",
) -> Linkage:
    """Make a linkage of a Pinocchio model whose loops are closed by constraint models.

    Names of joints, and of frames as links, are kept. Joints of one coordinate count from their zeros in the model. A joint of several
    coordinates becomes a joint for each: NAME_x, NAME_y and NAME_z of a spherical or translation joint; NAME_x, NAME_y and NAME_rz of a
    planar one; NAME_1 and NAME_2 of a universal joint, NAME_1 and so on of a composite joint; NAME_z, NAME_y and NAME_x of
    `JointModelSphericalZYX`; NAME_x, NAME_y, NAME_z, NAME_rz, NAME_ry and NAME_rx of a free flyer. Spherical joints and free flyers count
    from ``q``. A helical joint is a revolute one, NAME, with a slide NAME_slide that follows it; a mimic joint is a gear pair.

    Two points that are held together on the same two bodies are a hinge, and become one revolute loop. Gravity is that of the model.
    Pinocchio computes with ``model.armature``, and not with the inertia of rotors: where the first is zero the linkage gets the second,
    times the gear ratio squared.

    Args:
        model: Pinocchio's model of the tree. It is not changed, and later changes of it do not change the linkage.
        constraint_models: `RigidConstraintModel` (CONTACT_3D: a point, CONTACT_6D: all directions), `PointAnchorConstraintModel` or
            `FrameAnchorConstraintModel`. Joint 0 is the frame. Those of `Linkage.constraint_models` give the linkage back.
        drivers: as for `load`; the names of joints of several coordinates are those above.
        q: (nq,) configuration of the model, quaternions as x y z w, from which the linkage is put together; by default the neutral one.
        relations: gears that the model does not know, by places of joints in its v, as `Linkage.relations`.
        slide: as for `load`.
        base: as for `load`, of a free flyer on the frame.

    Raises:
        PinpressError: a joint or constraint of another kind, or an argument that does not belong to the model.
        UrdfError: as `load`; its file is the name of the model.
        AssemblyError: as `load`.
        SingularityError: as `load`.

    Warns:
        PinpressWarning: as `load`; an armature of a spherical joint, of a free flyer or of the slides of a planar joint, which is left out.
    """
    if not isinstance(model, pin.Model):
        raise PinpressError(f"model is {shown(model)}: give a pinocchio.Model")
    start = pin.neutral(model) if q is None else numbers("q", q, (model.nq,))
    document = _Reader(model, start).document(list(constraint_models), relations)
    try:
        return load_document(document, drivers, slide, model.gravity.linear, base=base, in_file=False, command="pp.check of its URDF text")
    except UrdfError as error:  # users do not see the lines of the URDF
        raise UrdfError(error.file, error.element, None, error.problem, error.remedy) from None


class _Part(NamedTuple):
    """One coordinate of a joint.

    Attributes:
        ending: of its name.
        type: "revolute" or "prismatic".
        axis: (3,) in the frame of the part.
        place: of the part behind the one before, at zero.
        q: its places in q, of which two hold cosine and sine; empty where q holds no coordinate of it.
        v: its place in v; -1 where none is its own.
        follow: name of the joint that it follows, ratio and offset.
        rotor: whether an armature at its place in v turns or slides with this coordinate.
    """

    ending: str
    type: str
    axis: Array
    place: pin.SE3
    q: tuple[int, ...] = ()
    v: int = -1
    follow: tuple[str, float, float] | None = None
    rotor: bool = True


_X = np.array([1.0, 0.0, 0.0])
_HERE = pin.SE3.Identity()
_WITH_BALLS = ("JointModelSpherical", "JointModelFreeFlyer")  # whose last three parts are a ball joint


@dataclass
class _Reader:
    """Reads a model at a configuration (nq,)."""

    model: pin.Model
    start: Array

    def document(self, constraint_models: Sequence[Constraint], relations: Sequence[Relation]) -> Document:
        model, name = self.model, self.model.name or "model"
        self.taken: set[str] = {frame.name for frame in model.frames} | set(model.names)
        self.links: list[Link] = []
        self.joints: list[Joint] = []
        self.balls: list[tuple[str, ...]] = []
        self.home: dict[str, float] = {}
        self.of_v: dict[int, str] = {}  # name of the joint whose coordinate stands at a place in v
        self.carried = [self._link_name(joint) for joint in range(model.njoints)]
        for joint in range(model.njoints):
            self.links.append(Link(self.carried[joint], self._inertia(joint), (), _origin("joint", model.names[joint])))
            if joint:
                self._read_joint(joint)
        self._read_frames()
        loops = tuple(with_hinges(self._loops(constraint_models))[0])
        origin = _origin("model", name)
        links, joints = tuple(self.links), tuple(self.joints)
        geared = tuple(self._relations(relations))
        of_model = Mechanism(name, links, joints, loops, (), (), origin, tuple(self.balls), geared, self.home)
        return replace(as_document(name, of_model, f"the Pinocchio model {name}"), origins={})

    def _link_name(self, joint: int) -> str:
        """Name of the link in whose frame the body of a joint lies: that of the first frame of a body there, else a new one."""
        bodies = [frame for frame in self.model.frames if frame.type == pin.BODY and frame.parentJoint == joint]
        at_joint = [frame.name for frame in bodies if np.array_equal(frame.placement.homogeneous, np.eye(4))]
        return at_joint[0] if at_joint else take(f"{self.model.names[joint]}_link" if joint else "universe_link", self.taken)

    def _inertia(self, joint: int) -> Inertia | None:
        inertia = self.model.inertias[joint]
        if joint == 0 and not inertia.mass:
            return None
        place = pin.SE3(np.eye(3), np.array(inertia.lever))
        return Inertia(float(inertia.mass), place, np.array(inertia.inertia), _origin("joint", self.model.names[joint]))

    # ------------------------------------------------------------------------------------------------------------------------------ joints

    def _read_joint(self, joint: int) -> None:
        model, name = self.model, self.model.names[joint]
        origin, parent, child = _origin("joint", name), self.carried[model.parents[joint]], self.carried[joint]
        kind, place = model.joints[joint], model.jointPlacements[joint]
        if kind.shortname() == "JointModelFreeFlyer" and model.parents[joint] == 0:
            at = place * pin.XYZQUATToSE3(self.start[kind.idx_q : kind.idx_q + 7])
            self._warn_of_armature(name, kind.idx_v, 6)
            self.joints.append(Joint(name, "floating", parent, child, at, _X, origin))
            return
        parts = self._parts(name, kind)
        between = [take(f"{name}{part.ending}_link", self.taken) for part in parts[:-1]]
        single = [self._single(name + part.ending, part, part.place if k else place * part.place, origin) for k, part in enumerate(parts)]
        joints, links = in_series(single, parent, child, between)
        self.joints += joints
        self.links += links
        if kind.shortname() in _WITH_BALLS:
            self.balls.append(tuple(name + part.ending for part in parts[-3:]))

    def _single(self, name: str, part: _Part, place: pin.SE3, origin: Origin) -> Joint:
        """A joint of one coordinate, whose parent and child are still open."""
        model, v = self.model, part.v
        if len(part.q) == 1:
            self.home[name] = float(self.start[part.q[0]])
        elif part.q:
            cosine, sine = (self.start[k] for k in part.q)
            self.home[name] = float(np.arctan2(sine, cosine))
        joint = Joint(name, part.type, "", "", place, part.axis, origin)
        if part.follow is not None:
            leader, ratio, offset = part.follow
            joint = replace(joint, follow=Follow(leader, ratio, offset, origin))
        if v < 0:
            return joint
        self.of_v[v] = name
        low, high = (float(limit[part.q[0]]) for limit in (model.lowerPositionLimit, model.upperPositionLimit))
        bounded = len(part.q) == 1 and (low > -LARGEST or high < LARGEST)
        effort, velocity = float(model.upperEffortLimit[v]), float(model.upperVelocityLimit[v])
        rotor = float(model.rotorInertia[v] * model.rotorGearRatio[v] ** 2)
        return replace(
            joint,
            limits=(max(low, -LARGEST), min(high, LARGEST)) if bounded else None,
            effort=effort if effort < LARGEST else None,
            velocity=velocity if velocity < LARGEST else None,
            damping=float(model.damping[v]),
            friction=float(model.upperDryFrictionLimit[v]),
            armature=(float(model.armature[v]) or rotor) if part.rotor else 0.0,
        )

    def _parts(self, name: str, kind: pin.JointModel) -> list[_Part]:
        """The parts of a joint, one of the model or of a composite joint."""
        joint, q, v = kind.extract(), kind.idx_q, kind.idx_v
        form = joint.shortname().removeprefix("JointModel")
        axes, slides = np.eye(3), [_Part(f"_{'xyz'[k]}", "prismatic", axis, _HERE, (q + k,), v + k) for k, axis in enumerate(np.eye(3))]
        if form == "Composite":
            return list(self._parts_of_composite(name, joint))
        if form == "Spherical":
            self._warn_of_armature(name, v, 3)
            turned = pin.SE3(pin.Quaternion(self.start[q : q + 4]).matrix(), np.zeros(3))
            return [_Part(f"_{'xyz'[k]}", "revolute", axis, _HERE if k else turned) for k, axis in enumerate(axes)]
        if form == "FreeFlyer":
            self._warn_of_armature(name, v, 6)
            at = pin.XYZQUATToSE3(self.start[q : q + 7])
            of_base = [part._replace(q=(), v=-1, place=_HERE if k else at) for k, part in enumerate(slides)]
            return of_base + [_Part(f"_r{'zyx'[k]}", "revolute", axis, _HERE) for k, axis in enumerate(axes[::-1])]
        if form == "Universal":
            turning = (joint.axis1, joint.axis2)
            return [_Part(f"_{k + 1}", "revolute", np.array(axis), _HERE, (q + k,), v + k) for k, axis in enumerate(turning)]
        if form == "SphericalZYX":
            return [_Part(f"_{'zyx'[k]}", "revolute", axis, _HERE, (q + k,), v + k) for k, axis in enumerate(axes[::-1])]
        if form == "Translation":
            return slides
        if form == "Planar":
            self._warn_of_armature(name, v, 2)  # its rates are those along the axes of the child, which turn
            of_parent = [part._replace(rotor=False) for part in slides[:2]]
            return [*of_parent, _Part("_rz", "revolute", axes[2], _HERE, (q + 2, q + 3), v + 2)]
        if joint.nvExtended != 1:
            raise PinpressError(f"{self.model.name}: joint {name!r} is a {form} joint, which cannot be read: write it as single joints")
        return list(self._parts_of_single(name, kind))

    def _parts_of_single(self, name: str, kind: pin.JointModel) -> Iterator[_Part]:
        """A revolute or prismatic joint; a helical joint, which is a revolute one with a slide that follows it; a joint that mimics one."""
        data = kind.createData()
        kind.calc(data, self.start)
        column, places = np.ravel(data.S), {"q": tuple(range(kind.idx_q, kind.idx_q + kind.nq)), "v": kind.idx_v}
        if kind.shortname() == "JointModelMimic":
            mimic, leaders = kind.extract(), dict(zip(self.model.mimicking_joints, self.model.mimicked_joints, strict=True))
            leader = self.model.joints[leaders[kind.id]]
            if not mimic.scaling or leader.nv != 1:
                raise PinpressError(f"{self.model.name}: joint {name!r} mimics no single joint, or with ratio 0: write a joint of its own")
            follow = str(self.model.names[leader.id]), float(mimic.scaling), float(mimic.offset)
            column, places = column / mimic.scaling, {"follow": follow}
        turning, sliding = column[3:], column[:3]
        if not turning.any():
            yield _Part("", "prismatic", sliding, _HERE, **places)
            return
        yield _Part("", "revolute", turning, _HERE, **places)
        if sliding.any():
            yield _Part("_slide", "prismatic", turning, _HERE, follow=(name, float(sliding @ turning), 0.0))

    def _parts_of_composite(self, name: str, composite: pin.JointModelComposite) -> Iterator[_Part]:
        for k, (joint, place) in enumerate(zip(composite.joints, composite.jointPlacements, strict=True), 1):
            first, *others = self._parts(f"{name}_{k}", joint)
            if joint.shortname() in _WITH_BALLS:
                self.balls.append(tuple(f"{name}_{k}{part.ending}" for part in (first, *others)[-3:]))
            for part in (first._replace(place=place * first.place), *others):
                yield part._replace(ending=f"_{k}{part.ending}")

    def _warn_of_armature(self, name: str, v: int, count: int) -> None:
        if self.model.armature[v : v + count].any():
            caution(f"{self.model.name}: the armature of joint {name!r} is left out; add the rotor to the inertia of a body instead")

    # ------------------------------------------------------------------------------------------------------------ frames, gears and loops

    def _read_frames(self) -> None:
        """All other frames as links that are welded to that of the joint."""
        frames, used, named = self.model.frames, set(self.model.names), set(self.carried)
        for frame in sorted(frames[1:], key=lambda frame: frame.type != pin.BODY):
            weld = frames[frame.parentFrame]
            of_weld = frame.type == pin.BODY and weld.type == pin.FIXED_JOINT and weld.name not in used
            if frame.type == pin.JOINT or frame.name in named or (frame.type == pin.FIXED_JOINT and frame.name in used):
                continue
            joint = str(weld.name) if of_weld else take(f"{frame.name}_weld", self.taken)
            used.add(joint)
            named.add(frame.name)
            origin = _origin("frame", frame.name)
            self.links.append(Link(frame.name, None, (), origin))
            self.joints.append(Joint(joint, "fixed", self.carried[frame.parentJoint], frame.name, frame.placement, _X, origin))

    def _relations(self, relations: Iterable[Relation]) -> Iterator[NamedRelation]:
        for relation in relations:
            expect("an entry of relations", relation, Relation, "Linkage.relations")
            if relation.curve is not None or not set(relation.joints) <= set(self.of_v):
                problem = "is a curve" if relation.curve is not None else "names places in v that are not those of single joints"
                raise PinpressError(f"relations: {relation.name!r} {problem}: give gears of joints of {self.model.name}")
            coefficients = {self.of_v[joint]: float(value) for joint, value in relation.coefficients.items()}
            yield NamedRelation(relation.name, coefficients, float(relation.offset), _origin("relation", relation.name))

    def _loops(self, constraint_models: Sequence[Constraint]) -> Iterator[Loop]:
        taken = {joint.name for joint in self.joints}
        for constraint in constraint_models:
            is_point = _is_point(constraint)
            joints = constraint.joint1_id, constraint.joint2_id
            if not all(0 <= joint < self.model.njoints for joint in joints):
                raise PinpressError(f"constraint {constraint.name!r} joins joints {joints}: {self.model.name} has {self.model.njoints}")
            names = [self.carried[joint] for joint in joints]
            name = take(constraint.name or f"loop_{names[0]}_{names[1]}", taken)
            one, other = (
                (link, pin.SE3(np.eye(3) if is_point else place.rotation, np.array(place.translation)))
                for link, place in zip(names, (constraint.joint1_placement, constraint.joint2_placement), strict=True)
            )
            yield Loop(name, "spherical" if is_point else "fixed", (one, other), None, _origin("constraint", name))


def _origin(tag: str, name: str) -> Origin:
    return Origin(f'<{tag} name="{name}">', 0)


def _is_point(constraint: Constraint) -> bool:
    """Whether a constraint holds points together, and no directions; raises PinpressError if it is of another kind, or has an offset."""
    remedy = "give a RigidConstraintModel CONTACT_3D or CONTACT_6D, or a point or frame anchor"
    if isinstance(constraint, pin.RigidConstraintModel):
        offset = constraint.desired_contact_placement.homogeneous - np.eye(4)
        kinds = {pin.ContactType.CONTACT_3D: True, pin.ContactType.CONTACT_6D: False}
        if constraint.type not in kinds:
            raise PinpressError(f"constraint {constraint.name!r} is of type {constraint.type}: {remedy}")
        is_point = kinds[constraint.type]
    elif isinstance(constraint, pin.PointAnchorConstraintModel | pin.FrameAnchorConstraintModel):
        offset, is_point = np.asarray(constraint.desired_constraint_offset), isinstance(constraint, pin.PointAnchorConstraintModel)
    else:
        raise PinpressError(f"constraint_models has {shown(constraint)}: {remedy}")
    if np.any(offset):
        raise PinpressError(f"constraint {constraint.name!r} has a desired offset: move its joint1_placement by it instead")
    return is_point
