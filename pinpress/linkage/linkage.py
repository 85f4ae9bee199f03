"""A press linkage: the URDF's tree as a Pinocchio model, its loops, its drivers and its slide."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from ..common.arguments import number, numbers
from ..common.errors import PinpressError, SingularityError, UnknownNameError, UrdfError, shown
from ..common.frozen import Frozen, FrozenMapping
from ..common.quantities import Array, DriverCoordinate
from ..engines import branch
from ..engines.branch import Branch
from ..engines.constraints import Coupling, LoopJoint, Relation, gear
from ..engines.contacts import Contact
from ..engines.engine import LOOSEST, Engine
from ..engines.pinocchio.constraint_models import constraint_models
from ..engines.pinocchio.equations import OneConfiguration, Rows
from ..engines.planar.engine import PlanarEngine
from ..engines.planar.model import Plane
from ..engines.spatial.engine import SpatialEngine
from ..engines.spatial.equations import Loops
from ..engines.spatial.frames import Frame, moving_frame, placed_frame
from ..engines.structure import Axis, Slot, Structure, build_structure, configuration
from . import cams
from .assembly import (
    Assembly,
    assemble,
    close_on_branch,
    follow_drivers,
    refuse_far,
    walk_branch,
    walk_branch_beside,
    walk_through_change_points,
)
from .description import JointSpring
from .document import Document
from .driving.freedoms import Freedom, Undriven, undriven
from .machine_elements import Mesh, Placed, contacts_of, placed
from .memo import Model, keep_geometry, keep_geometry_of, per_linkage
from .planarity import Planarity
from .tool_point import ToolPoint, tool_point

if TYPE_CHECKING:
    from ..engines.pinocchio.forward_dynamics import ForwardDynamics

NAME_A_SLIDE = "name a link that the frame guides: load(..., slide=...) or build(..., slide=...), in a job slide: ..."
UPRIGHT = 0.7  # cosine between the slide's axis and the vertical above which words call its ways up and down
LEVEL = 1e-6  # cosine between a slide's axis and the vertical up to which it moves horizontally: files round directions to some six digits


class SlideGuide(NamedTuple):
    """How the slide's position follows from that of its guide's joint: position = sign x joint coordinate + offset.

    Attributes:
        joint: place of the guide in v.
        offset: the slide's position where the coordinate is zero [m].
        sign: 1, or -1 where the guide's axis points down: `Linkage.slide_direction`.
    """

    joint: int
    offset: float
    sign: float


@dataclass(frozen=True, eq=False, repr=False)
class Linkage(Frozen):
    """A closed linkage and its drivers, made by `load`. It is read-only, ``model`` too: after a change in place every use of the linkage
    raises a PinpressError. Inertias that no body has are refused, however the linkage was made.

    World axes: up is against gravity, z by default (`up`); a planar press then stands in the x-z plane. Joint coordinates count from the
    zeros of the file: they are zero in the drawn pose. SI units. A changed linkage is made by ``dataclasses.replace(press, model=...)``
    with a changed copy of the model: everything else here is derived.

    Attributes:
        name: the URDF's robot name.
        document: the URDF it was read from.
        model: Pinocchio's model of the tree, loops cut, gravity set.
        links: names of all links, in document order.
        root: name of the link that is the frame.
        loops: the bearings at which loops were cut.
        relations: gear pairs, racks and screws, as equations between the coordinates of their joints. ``couplings`` lists them by pairs.
        contacts: machine elements through which bodies push on each other, by the multipliers of ``relations``.
        drivers: names of the driver joints, as many as degrees of freedom: `motors`, then ``passive``.
        slide: name of the slide link, None if the linkage has none.
        held: names of the joints that are held as in the home pose, because a link could spin about the line of its bearings, which no
            driver determines. Which joint of such a link that is, and what follows, says `Freedom`.
        zero: where the driver's coordinate is 0, as in "top dead centre"; empty for the pose that the file draws. See `drawn_at`.
        joint_springs: springs and dampers in joints, ``<joint_spring>``. Inertias of motors, ``<armature>``, are in ``model.armature``.
        passive: names of the drivers that no motor moves, such as sprung joints and the joints of a floating base. They are the last of
            ``drivers``, because together with the motors their coordinates determine all others.
        home: (nv,) joint coordinates of the pose in which the linkage is put together, and in which paths of its drivers begin [rad or m];
            empty for the drawn pose. ``closed`` is this pose, closed exactly.
        mounted: how the home pose was found, if it is not the drawn one.
    """

    name: str
    document: Document
    model: pin.Model
    links: tuple[str, ...]
    root: str
    loops: tuple[LoopJoint, ...]
    relations: tuple[Relation, ...]
    drivers: tuple[str, ...]
    slide: str | None
    held: tuple[str, ...] = ()
    zero: str = ""
    passive: tuple[str, ...] = ()
    joint_springs: tuple[JointSpring, ...] = ()
    home: tuple[float, ...] = ()
    mounted: str = ""
    contacts: tuple[Contact, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if wrong := first_unphysical(self.model.inertias):
            joint, problem = wrong
            body = f"link {self.link_of(joint)!r}, with all that is welded to it,"
            raise PinpressError(f"{self.name}: {body} has {problem}: give inertias of bodies, in kg and kg m2 about the centre of mass")
        said = self.document.description
        if self.contacts and (said.machine_elements or said.cams):  # of another model they are elsewhere
            with contextlib.suppress(UrdfError):  # lengths that gears do not go with leave them as they were
                of_cams = cams.contacts(self.document, self.model, self.relations)
                vars(self)["contacts"] = (*contacts_of(self._elements, self.relations), *of_cams)

    def __repr__(self) -> str:
        passive = f", passive {', '.join(self.passive)}" if self.passive else ""
        return f"<Linkage {self.name}: driver {', '.join(self.motors)}{passive}, slide {self.slide}, bearings {', '.join(self.bearings)}>"

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        from html import escape  # to save start-up time: only notebooks need it

        return f"<div><div>{escape(repr(self)[1:-1])}</div>{self.drawing}</div>"

    @property
    def drawing(self) -> str:
        """SVG of the linkage, 60 deg after its drawn pose where one driver turns it as far."""
        from .skeleton import pitch_circles, skeleton  # to save start-up time: the XML library

        try:
            shown = self.drawn_at(float(self.closed[self.driver_indices[0]]) + np.pi / 3)  # the pose of the file is often a dead centre
        except PinpressError:
            shown = self.drawn_at_home()
        links = [self.link_of(joint) for joint in range(self.model.njoints)]
        circles = pitch_circles(shown.model, shown.meshes.values())
        return skeleton(shown.model, self.loops, self.axes, links, f"drawing of {self.name}", circles)

    @property
    def file(self) -> str:
        """Path of the URDF."""
        return self.document.file

    @property
    def text(self) -> bytes:
        """The URDF as it was read."""
        return self.document.text

    @property
    def driver(self) -> str:
        """Name of the driver joint; of the first where there are several."""
        return self.drivers[0]

    @property
    def motors(self) -> tuple[str, ...]:
        """Names of the drivers that motors move: all that are not ``passive``."""
        return self.drivers[: len(self.drivers) - len(self.passive)]

    @property
    def size(self) -> float:
        """Largest extent of joints and loops in the drawn pose [m]: the length by which angles are compared with travels."""
        return self.structure.size

    @property
    def lengths(self) -> Array:
        """(nv,) what counts as 1 rad of each joint [rad or m]."""
        return self.structure.lengths

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Axes of the moving joints, each in its own frame."""
        return self.structure.axes

    @property
    def slots(self) -> tuple[Slot, ...]:
        """Where the moving joints stand in q."""
        return self.structure.slots

    @property
    @per_linkage
    def driver_coordinates(self) -> tuple[DriverCoordinate, ...]:
        """What the coordinates of the drivers are: a crank angle [rad], or the position of a driver that slides [m]."""
        return tuple(replace(each, zero=self.zero) for each in self.structure.coordinates)

    @property
    def driver_indices(self) -> tuple[int, ...]:
        """Indices of the driver joints in v."""
        return self.structure.drivers

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Names of the moving joints in Pinocchio's order, that of v."""
        return tuple(self.model.names)[1:]

    @cached_property
    def bearings(self) -> tuple[str, ...]:
        """Names of all joints and loops that transmit forces: joints in Pinocchio's order, then loops."""
        return self.joints + tuple(loop.name for loop in self.loops)

    @cached_property
    def bearings_as_drawn(self) -> tuple[str, ...]:
        """Names of all bearings in the order of the drawing: joints as the file lists them, each loop where it closes, which is behind the
        joints that carry its two links."""
        names_in_order, carried, left = [], {0}, list(self.loops)
        listed = (joint.get("name") for joint in self.document.robot.all("joint"))
        for name in (name for name in listed if name in self.joints):
            names_in_order.append(name)
            carried.add(self.joints.index(name) + 1)
            closing = [loop for loop in left if {loop.joint1, loop.joint2} <= carried]
            names_in_order += [loop.name for loop in closing]
            left = [loop for loop in left if loop not in closing]
        return tuple(names_in_order)

    @cached_property
    def couplings(self) -> tuple[Coupling, ...]:
        """The relations between the coordinates of two joints each, as follower, leader and ratio: gear pairs, racks and screws."""
        return tuple(Coupling.of(relation) for relation in self.relations if relation.is_pair)

    @property
    def meshes(self) -> Mapping[str, Mesh]:
        """Gears, racks, screws and worms of the file by their names: pitch points and circles, ratios, efficiencies."""
        return FrozenMapping({each.mesh.name: each.mesh for each in self._elements})

    @property
    @per_linkage(of_geometry=True)
    def _elements(self) -> tuple[Placed, ...]:
        """The elements of teeth and threads in the drawn pose; raises UrdfError where they no longer mesh in a changed model."""
        try:
            return placed(self.document, self.model, self.loops)
        except UrdfError:  # pins of one axis may deviate from each other in a changed model
            return placed(self.document, self.model, self.loops, deviating=True)

    @property
    def mobility(self) -> int:
        """Degrees of freedom of the closed linkage: joints less the rank of the equations of loops and relations. These are the drivers and
        the held joints."""
        return int(self.model.nv) - self.rank + len(self.held)

    @property
    @per_linkage
    def freedoms(self) -> tuple[Freedom, ...]:
        """The freedoms that no motor determines: spins and swings, which are held, then the ``passive`` ones. Empty where the motors
        determine how all joints move."""
        return self.undriven(self.motors).freedoms

    def undriven(self, motors: Sequence[str]) -> Undriven:
        """The freedoms that motors in other joints would leave, held joints counted as free; arguments and errors as of `freedoms`."""
        if self.assembly.determined and not self.held and motors == self.drivers:
            return Undriven((), ())
        place = self.joints.index
        taken = [*map(place, self.held), *map(place, self.passive)]
        sprung, base = map(place, self.sprung), map(place, self.base)
        return undriven(self.structure, self.closed, [*map(place, motors)], [*sprung], [*base], taken, len(self.held))

    @property
    def sprung(self) -> tuple[str, ...]:
        """Names of the joints on which springs of the file act."""
        return tuple(spring.joint for spring in self.joint_springs if spring.stiffness)

    @property
    def base(self) -> tuple[str, ...]:
        """Names of the joints of free bodies, six each."""
        return tuple(joint for six in self.document.description.bases.values() for joint in six if joint in self.joints)

    @property
    def rank(self) -> int:
        """Rank of the equations of loops, relations and held joints in the closed home pose."""
        return self.assembly.rank

    @property
    def structure(self) -> Structure:
        """What the engines compute with. Held joints stand still where they are in the home pose, each by a relation."""
        return self.assembly.structure

    @property
    @per_linkage
    def structure_as_built(self) -> Structure:
        """The structure before the linkage is put together, which shows whether its equations contradict each other: `Structure.misfit`."""
        drivers = tuple(self.joints.index(driver) for driver in self.drivers)
        held = {name: self.joints.index(name) for name in self.held}
        still = tuple(Relation(name, {joint: 1.0}, self.home[joint] if self.home else 0.0) for name, joint in held.items())
        return build_structure(self.model, self.loops, (*self.relations, *still), drivers, self.contacts)

    @property
    def engines(self) -> tuple[str, ...]:
        """Names of the engines that can compute the linkage, the fastest first: "plane" a planar linkage with one driver and pins for loops
        whose equations fall into blocks; "space" and "pinocchio" any, "pinocchio" by Pinocchio's own algorithms, one state at a time."""
        return tuple(self.assembly.engines)

    def engine(self, name: str = "auto") -> Engine:
        """An engine by its name, or the fastest ("auto").

        Raises:
            PinpressError: unknown engine, or "plane" for a linkage that is not planar.
        """
        engines = self.assembly.engines
        if isinstance(name, str):
            if name == "auto":
                return next(iter(engines.values()))
            if name in engines:
                return engines[name]
            if name == "plane":
                raise PinpressError(
                    f"{self.name} is not a planar linkage with one driver and pins for loops: use engine='space' (or 'auto')"
                )
        raise PinpressError(f"unknown engine {shown(name)}: write 'auto', 'plane', 'space' or 'pinocchio'")

    def plane_or_refuse(self, refusal: str) -> Plane:
        """The constants of the planar engine.

        Raises:
            PinpressError: the linkage is not planar, or has several drivers, with this message.
        """
        engine = self.engine()
        if not isinstance(engine, PlanarEngine):
            raise PinpressError(refusal)
        return engine.plane

    def with_one_driver(self, driver: str, ratios: Mapping[str, float]) -> Linkage:
        """The linkage with one driver, which its other drivers follow as by gear pairs.

        Args:
            driver: name of the one.
            ratios: travel of every other driver by that of the one, by their names; one of 0 stands.
        """
        of_drivers = dict(zip(self.drivers, self.driver_indices, strict=True))
        home = self.closed  # gears must fit there
        followers = (
            gear(name, joint, of_drivers[driver], ratios[name], float(home[joint] - ratios[name] * home[of_drivers[driver]]))
            for name, joint in of_drivers.items()
            if name != driver
        )
        return replace(self, drivers=(driver,), passive=(), relations=(*self.relations, *followers))

    @property
    @per_linkage(of_geometry=True)
    def engine_of_one_driver(self) -> Engine:
        """The engine of the linkage with all drivers but the first held: that of the plane for a linkage which moves in one, which has an
        engine for one driver alone. Its directions, axes and redundant equations are those of the whole linkage."""
        one = self if len(self.drivers) == 1 else self.with_one_driver(self.driver, dict.fromkeys(self.drivers, 0.0))
        return one.engine()

    def plane_of_motion(self, refusal: str) -> Plane:
        """The plane in which the linkage moves with any of its drivers, and its joints in it.

        Raises:
            PinpressError: the linkage is not planar, with this message.
        """
        engine = self.engine_of_one_driver
        if not isinstance(engine, PlanarEngine):
            raise PinpressError(refusal)
        return engine.plane

    @property
    @per_linkage
    def assembly(self) -> Assembly:
        """The linkage put together in its home pose; `load` judges whether it closes and moves."""
        return assemble(self.structure_as_built, self.home, self.mounted)

    @property
    def closed(self) -> Array:
        """(nv,) joint coordinates of the home pose, closed exactly [rad or m]."""
        return self.assembly.closed

    @property
    @per_linkage(of_geometry=True)
    def planarity(self) -> Planarity:
        """How the linkage lies in the plane of its first driver."""
        return Planarity.of(self.structure)

    def equations(self, x: Array) -> Rows:
        """The equations of loops and relations at joint coordinates (nv,)."""
        return OneConfiguration(self.structure).at(x)

    @property
    @per_linkage
    def slide_guide(self) -> SlideGuide:
        """The slide's guide, and how the slide's position follows from it.

        Raises:
            PinpressError: the linkage has no slide.
        """
        if self.slide is None:
            raise PinpressError(f"{self.name} has no slide: {NAME_A_SLIDE}")
        frame = self.model.frames[self.model.getFrameId(self.slide, pin.BODY)]
        guide = frame.parentJoint - 1
        place = self.model.jointPlacements[frame.parentJoint]  # in the world, as the frame carries the guide
        axis = place.rotation @ self.axes[guide].direction
        sign = -1.0 if axis @ self.up < -LEVEL else 1.0
        return SlideGuide(guide, sign * float(axis @ place.act(frame.placement.translation)), sign)

    @property
    def up(self) -> Array:
        """(3,) unit vector in world axes that points up: against gravity, and along z where there is no gravity."""
        gravity = np.asarray(self.model.gravity.linear)
        size = float(np.linalg.norm(gravity))
        return -gravity / size if size else np.array([0.0, 0.0, 1.0])

    @property
    def slide_direction(self) -> Array:
        """(3,) unit vector in world axes along which the slide's position grows: upwards (see `up`), wherever the axis of its guide points;
        of a slide that moves horizontally along the axis of its guide.

        Raises:
            PinpressError: the linkage has no slide.
        """
        guide, _, sign = self.slide_guide
        return np.asarray(sign * (self.model.jointPlacements[guide + 1].rotation @ self.axes[guide].direction))

    @property
    @per_linkage(of_geometry=True)
    def tool(self) -> ToolPoint:
        """The point of the slide at which process forces act: the ``<tool>`` of its link, else the middle of the pins farthest apart by
        which links hold the slide. Where all of these are in one line along the guide, it is the origin of the slide's link.

        Raises:
            PinpressError: the linkage has no slide.
        """
        return tool_point(self)

    @property
    @per_linkage(of_geometry=True)
    def branch(self) -> Branch:
        """The drawn assembly over the crank angle, walked once.

        Raises:
            SingularityError: the linkage locks at its drawn pose.
            AssemblyError: its loops do not stay closed, or it moves too fast to be followed.
            PinpressError: it has several drivers.
        """
        remedy = f"give their angles over time to pp.servo_cycle(press, angle, time=time), angle (n, {len(self.drivers)})"
        self.refuse_several_drivers(f"one speed does not say how they move together; {remedy}")
        return self.assembly.branch or walk_branch(self.engine(), self.structure, self.closed)

    def follow_beside(self, other: Linkage) -> None:
        """Find the branch of this linkage from that of another one with the same joints and nearly the same lengths.

        That takes a tenth of the time of walking it. If they differ too much, the branch is walked when it is needed.
        """
        if self.joints == other.joints and self.drivers == other.drivers and len(self.drivers) == 1:
            nearby = walk_branch_beside(self.engine(), self.structure, other.branch, other.closed)
            if nearby is not None:
                keep_geometry_of(vars(Linkage)["branch"].fget, self, nearby)

    @property
    @per_linkage(of_geometry=True)
    def branch_through_change_points(self) -> Branch:
        """The branch followed further, through change points: where two assemblies meet, a linkage in motion goes on in its own. Raises as
        `branch`."""
        return walk_through_change_points(self.engine(), self.structure, self.branch)

    @property
    def period_turns(self) -> int:
        """Turns of the driver in one period, after which motion and forces repeat themselves. It is one turn, or more where gear ratios
        bring the linkage back only later. A balanced geared shaft that is on no loop does not count.

        Raises:
            SingularityError: the linkage locks within the period.
            PinpressError: it is not back after many turns, or has several drivers.
        """
        turns = self.turns_until_back
        if turns is not None:
            return turns
        self.refuse_sliding_driver("it has no period of turns; cycle(press, speed=...) moves it there and back")
        if self.branch_through_change_points.period is None:
            raise branch.out_of_branch(self.branch_through_change_points, upwards=self.branch_through_change_points.locks[True] is not None)
        if self.advancing.any():
            joint = int(np.flatnonzero(self.advancing)[0])
            walked = self.branch_through_change_points
            gained = 1e3 * float(walked.gain_per_period[joint]) * 2 * np.pi / (walked.period or np.inf)
            raise PinpressError(
                f"{self.name} has no period: {self.joints[joint]!r} slides on by {gained:.6g} mm in every turn, as on a screw or a rack;"
                " give crank angles, servo_cycle(press, angle, speed=...), and to a command --motion"
            )
        raise PinpressError(
            f"{self.name} has no period: an unbalanced shaft is geared so that it is not back after {branch.MOST_TURNS} turns; give crank"
            " angles, servo_cycle(press, angle, speed=...), or another gear ratio"
        )

    def refuse_sliding_driver(self, refusal: str) -> None:
        """Raise PinpressError if the first driver slides; ``refusal``: why that is not possible here, and what is."""
        if not self.driver_coordinates[0].turns:
            raise PinpressError(f"driver {self.driver!r} of {self.name} slides to and fro: {refusal}")

    def refuse_several_drivers(self, refusal: str) -> None:
        """Raise PinpressError if the linkage has several drivers; ``refusal``: why that is not possible here, and what is."""
        if len(self.drivers) > 1:
            raise PinpressError(f"{self.name} has {len(self.drivers)} drivers: {refusal}")

    def refuse_joint_springs(self, refusal: str) -> None:
        """Raise PinpressError if springs are in joints of the linkage; ``refusal``: what does not take them."""
        if self.joint_springs:
            names = ", ".join(repr(spring.joint) for spring in self.joint_springs)
            raise PinpressError(f"{self.name} has springs in joints {names}: {refusal}")

    @property
    def loses_power(self) -> bool:
        """Whether teeth or threads rub, also without friction in bearings."""
        return any(contact.rubbing for contact in self.contacts)

    @property
    def uneven(self) -> bool:
        """Whether forces in bearings are not in proportion to loads: teeth push gears apart whichever way they turn, or rub."""
        return any(contact.rubbing or contact.unit.push.any() for contact in self.contacts)

    def refuse_contacts(self, refusal: str) -> None:
        """Raise PinpressError if bodies push on each other by teeth, threads or rollers; ``refusal``: which feature does not take such
        elements, and what to do instead."""
        if contacts := self.structure.contacts:
            names = ", ".join(repr(contact.name or self.relations[contact.relation].name) for contact in contacts)
            raise PinpressError(f"{self.name} has teeth, threads or rollers in {names}: {refusal}")

    @property
    @per_linkage
    def turns_until_back(self) -> int | None:
        """Turns of the driver in one period, None if the linkage is not back after many turns, or has several drivers."""
        if len(self.drivers) > 1:
            return None
        walked = self.branch_through_change_points
        if walked.period is None:
            return None
        model, size, carrying = self.model, self.size, set(self.model.parents)
        guide = -1 if self.slide is None else self.slide_guide.joint
        for joint in np.flatnonzero(self.advancing).tolist():  # a feeder along the frame is the same wherever it is, the slide is not
            if joint == guide or joint + 1 in carrying or model.parents[joint + 1]:
                return None
        counts = [  # on loops all are back
            axis.turns and (body in carrying or not _is_balanced(model.inertias[body], axis.direction, size))
            for body, axis in enumerate(self.axes, 1)
        ]
        periods = branch.periods_until_back(walked.gain_per_period[counts])
        return None if periods is None else periods * round(walked.period / (2 * np.pi))

    @property
    def advancing(self) -> NDArray[np.bool_]:
        """(nv,) which joints of a linkage with one driver slide on in every period, as on a screw or a rack, and do not come back."""
        walked = self.branch_through_change_points
        slides = ~self.structure.turns
        return slides & (np.abs(walked.gain_per_period) > 1e-9 * self.size) & (walked.period is not None)  # less is rounding

    def with_inertias(self, inertias: Sequence[pin.Inertia], name: str | None = None) -> Linkage:
        """The linkage with other masses. What is known of its geometry is kept, because it does not depend on masses.

        Args:
            inertias: inertias of the bodies of all Pinocchio joints, the frame's first, in the joints' frames.
            name: name of the changed linkage; by default that of this one.

        Raises:
            PinpressError: another number of inertias than joints, the frame's included, or one that no body has.
        """
        if len(inertias) != self.model.njoints:
            raise PinpressError(f"{len(inertias)} inertias of {self.name}: give {self.model.njoints}, the frame's first")
        model = self.model.copy()
        for joint, inertia in enumerate(inertias):
            model.inertias[joint] = inertia
        changed = replace(self, model=model, name=name or self.name)
        keep_geometry(changed, self)
        return changed

    def drawn_at(self, angle: float, zero: str = "another pose") -> Linkage:
        """The same linkage drawn at another crank angle, where its crank angle is then 0, as are all joint coordinates. Forces, links and
        their frames are the same; `write_urdf` writes it in the new pose.

        Args:
            angle: of the driver [rad]; ``press.drawn_at(pp.dead_centres(press).top_angle, "top dead centre")`` counts from top dead centre.
            zero: what the pose is called, in messages and in the names of columns.

        Raises:
            PinpressError: several drivers, one that slides, or an angle that is not finite or too large.
            SingularityError: the linkage locks before it gets there.
            AssemblyError: the loops do not close.
        """
        if len(self.drivers) > 1 or not self.driver_coordinates[0].turns:
            raise PinpressError(f"{self.name} cannot be drawn at another crank angle: it takes one driver that turns")
        angles = np.array([number("angle", angle)])
        refuse_far("angle", angles, self.driver_coordinates)
        moved = close_on_branch(self.engine(), self.structure, self.branch_through_change_points, angles, self.name).position[:, 0]
        return self._drawn_in(moved, zero)

    def drawn_at_home(self) -> Linkage:
        """The same linkage drawn in its closed home pose, in which all joint coordinates are then 0, for programs that start at zero.
        Forces, links and their frames are the same."""
        return self._drawn_in(self.closed, "home")

    def _drawn_in(self, pose: Array, zero: str) -> Linkage:
        """The linkage drawn in a closed pose (nv,); see `drawn_at`."""
        model = self.model.copy()
        for joint, (axis, slot, coordinate) in enumerate(zip(self.axes, self.slots, pose, strict=True), 1):
            model.jointPlacements[joint] = model.jointPlacements[joint] * axis.step(coordinate)
            if not slot.unbounded:
                model.lowerPositionLimit[slot.start] -= coordinate
                model.upperPositionLimit[slot.start] -= coordinate
        relations = tuple(relation.drawn_in(pose) for relation in self.relations)
        moved = dict(zip(self.joints, pose, strict=True))
        springs = tuple(replace(spring, reference=spring.reference - float(moved[spring.joint])) for spring in self.joint_springs)
        return replace(self, model=model, relations=relations, joint_springs=springs, zero=zero, home=(), mounted="")

    def configuration(self, angle: ArrayLike) -> Array:
        """Pinocchio's configuration q with the loops closed, in the drawn assembly. An unbounded joint has its cosine and sine in it.

        Args:
            angle: of the driver, one number or (n,), up to 1e7 rad [rad], of one that slides its position [m]; of several drivers
                (drivers,) or (n, drivers), in the order of ``drivers``: the assembly is followed from the home pose to the first and from
                each to the next, on straight lines.

        Returns:
            (nq,) of one position of the drivers, (n, nq) of n positions. A new array.

        Raises:
            PinpressError: an angle that is not finite or too large, or another shape.
            SingularityError: the linkage locks before it gets there.
            AssemblyError: the loops do not close.
        """
        x, one = self._closed_at("angle", angle)
        q = np.ascontiguousarray(configuration(self.slots, x).T)
        return np.array(q[0]) if one else q

    def _closed_at(self, name: str, given: ArrayLike) -> tuple[Array, bool]:
        """Closed joint coordinates (nv, n) at positions of the drivers, and whether they are of one position; raises as `configuration`."""
        angles, several = numbers(name, given, unit=self.driver_coordinates[0].unit), len(self.drivers) > 1
        one = angles.ndim == int(several)
        positions = angles[None] if one else angles
        if positions.size == 0 or positions.ndim != 1 + several or positions.shape[1:] != (len(self.drivers),) * several:
            count = len(self.drivers)
            one_driver = "one angle or (n,) angles [rad]" if self.driver_coordinates[0].turns else "one position or (n,) positions [m]"
            shapes = f"({count},) or (n, {count}), the angles of all drivers [rad]" if several else one_driver
            raise PinpressError(f"{name} has shape {angles.shape}: give {shapes}")
        refuse_far(name, positions, self.driver_coordinates)
        if several:
            return follow_drivers(self.engine(), self.structure, self.closed, positions, self.name), one
        return close_on_branch(self.engine(), self.structure, self.branch, positions, self.name).position, one

    def placements(self, frame: str, drivers: ArrayLike | None = None, *, joints: ArrayLike | None = None) -> Array:
        """Where a frame is: homogeneous matrices from the frame to the world, as Pinocchio's ``oMf``.

        Args:
            frame: name of a link; also of one that is welded to another by a fixed joint, which has a frame of its own.
            drivers: positions of the drivers, as of `configuration`.
            joints: closed joint coordinates (n, nv) in place of drivers, such as `Motion.joint_position` [rad or m].

        Returns:
            (n, 4, 4), of one position of the drivers (4, 4). The last column has the origin [m].

        Raises:
            UnknownNameError: no link of this name.
            PinpressError: neither or both of drivers and joints, joints that leave a loop open, or as `configuration`.
            SingularityError: the linkage locks before it gets there.
            AssemblyError: the loops do not close.
        """
        named = self.frame_named(frame)
        x, one = self._given(drivers, joints)
        placed = placed_frame(self.loops_in_space, named, x)
        return placed[0] if one else placed

    def jacobian(self, frame: str, drivers: ArrayLike | None = None, *, joints: ArrayLike | None = None) -> Array:
        """How a frame moves with the drivers: J of (v, w) = J qdot, with the loops closed.

        Rows are the velocity of the frame's origin [m/s], then the angular velocity [rad/s], in world axes, as of Pinocchio's
        ``LOCAL_WORLD_ALIGNED``; columns are the drivers in the order of ``drivers``, each at a rate of 1 rad/s or 1 m/s while the others
        stand. A wrench (f, m) on the frame at its origin takes the drivers' efforts -J^T (f, m).

        Args:
            frame: as of `placements`.
            drivers: as of `placements`.
            joints: as of `placements`.

        Returns:
            (n, 6, drivers), of one position of the drivers (6, drivers).

        Raises:
            UnknownNameError: no link of this name.
            PinpressError: as of `placements`.
            SingularityError: the linkage locks before it gets there, or there the drivers do not determine how the joints move.
            AssemblyError: the loops do not close.
        """
        named = self.frame_named(frame)
        x, one = self._given(drivers, joints)
        columns = moving_frame(self.loops_in_space, x, named).columns
        wrong = ~np.isfinite(columns).all(axis=(0, 1))
        if wrong.any():
            state = int(np.argmax(wrong))
            problem = f"{self.name} locks in state {state}, where its drivers do not determine how it moves: leave the state out"
            place = self.structure.place(x[:, state])
            raise SingularityError(
                problem, float(x[self.driver_indices[0], state]), 0.0, place, x[list(self.driver_indices), state].tolist()
            )
        by_state = np.ascontiguousarray(columns.transpose(2, 0, 1))
        return by_state[0] if one else by_state

    def frame_named(self, link: object) -> Frame:
        """The frame of a link, which may be one that is welded to another by a fixed joint.

        Raises:
            UnknownNameError: the linkage has no such link.
        """
        if not isinstance(link, str) or link not in self.links:
            raise UnknownNameError("link", link, self.links)
        return Frame.of(self.frame_of(link))

    @property
    def loops_in_space(self) -> Loops:
        """The constants of the equations in space."""
        engine = self.engine("space")
        assert isinstance(engine, SpatialEngine)
        return engine.loops

    def _given(self, drivers: ArrayLike | None, joints: ArrayLike | None) -> tuple[Array, bool]:
        """Closed joint coordinates (nv, n) by one of two arguments, and whether they are of one position of the drivers."""
        if (drivers is None) == (joints is None):
            raise PinpressError("give drivers=..., the positions of the drivers, or joints=..., the joint_position of a motion")
        if drivers is not None:
            return self._closed_at("drivers", drivers)
        x = numbers("joints", joints, (None, len(self.joints))).T
        gaps = self.engine("space").gaps(x)
        if not gaps.max(initial=0.0) <= max(LOOSEST * self.size, self.structure.tolerance):
            state = int(gaps.argmax())
            raise PinpressError(
                f"joints leave a loop of {self.name} open by {gaps[state]:.3g} m in state {state}: give the joint_position of a motion of"
                " this linkage, or the positions of its drivers, drivers=..."
            )
        return x, False

    def constraint_models(self) -> tuple[pin.PointAnchorConstraintModel | pin.FrameAnchorConstraintModel, ...]:
        """Pinocchio's own models of the constraints that close the loops, for its algorithms on ``model``. Made anew in each call.

        They come in the order of ``loops``, each with the name of its loop: of a spherical loop, as every pin of a planar press is one, a
        `PointAnchorConstraintModel`; of a revolute one two of these, at its point and on its axis, ``size`` further along; of a fixed one a
        `FrameAnchorConstraintModel`.

        Sides 1 and 2 are link1 and link2 of the loop: ``joint1_id`` and ``joint2_id`` are the joints that carry these links (0: the frame),
        ``joint1_placement`` and ``joint2_placement`` the loop's ends in the frames of these joints; x is the axis of a revolute loop. A
        multiplier is the force of link1 on link2 [N], of a frame with the moment about its origin behind it [N m], in the axes of end 1.
        Turned to the world's by ``data.oMi[joint1_id].rotation @ joint1_placement.rotation``, it is `Reactions.bearing_force`.

        For `constraintDynamics`, ``pinocchio.convertToRigidConstraintModel(press.model, anchor)`` makes a `RigidConstraintModel` of each.
        Their ``contact_force`` is the opposite one, of link2 on link1, in the same axes. Pinocchio has no constraint model of a gear pair:
        see ``couplings``.
        """
        return constraint_models(self.structure, self.closed)

    def forward_dynamics(self, armature: Array) -> ForwardDynamics:
        """Forward dynamics by Pinocchio, of any linkage.

        Args:
            armature: (nv,) inertia that turns with the joints, added to what the model has [kg m2; kg at one that slides].

        Raises:
            PinpressError: an armature of another shape, or not finite.
        """
        from ..engines.pinocchio.forward_dynamics import ForwardDynamics  # only simulation over time needs it, and it is slow to import

        return ForwardDynamics(self.structure, self.closed, self.rank, armature, self.name)

    def frame_of(self, link: str) -> pin.Frame:
        """The frame of a link in the model, with its body (``parentJoint``) and its place in the frame of the body's joint."""
        return self.model.frames[self.model.getFrameId(link, pin.BODY)]

    def link_of(self, joint: int) -> str:
        """Name of the link that the body of a Pinocchio joint (0: the frame) begins with."""
        return self._first_links[joint]

    @property
    @per_linkage
    def _first_links(self) -> dict[int, str]:
        bodies = [(frame.parentJoint, str(frame.name)) for frame in self.model.frames if frame.type == pin.BODY]
        return dict(reversed(bodies)) | {0: self.root}


def first_unphysical(inertias: Sequence[pin.Inertia]) -> tuple[int, str] | None:
    """Index of the first inertia that no body has, and why; None if bodies have all of them.

    No body has a mass below zero, or principal moments that break I1 + I2 >= I3 >= 0. Masses and moments of zero pass, of links without
    mass and of points, and two moments of zero, of links of which only that about the axis of their motion is known.
    """
    masses, levers, tensors = map(np.array, zip(*((inertia.mass, inertia.lever, inertia.inertia) for inertia in inertias), strict=True))
    finite = np.isfinite(masses + levers.sum(axis=1) + tensors.sum(axis=(1, 2)))
    if not finite.all():
        return int(np.argmin(finite)), "a mass, centre of mass or moment of inertia that is not finite"
    moments = np.linalg.eigvalsh(tensors)
    least = np.minimum(moments[:, 0], moments[:, 0] + moments[:, 1] - moments[:, 2])
    # Files may round the moments of each link by 1e-6, and the largest moment of welded links is at least a third of their sum.
    rounding = 4e-6 * np.abs(moments).max(axis=1)
    about_one_axis = np.abs(moments[:, :2]).max(axis=1) <= 1e-12 * moments[:, 2]  # the rounding error of turned frames
    wrong = np.flatnonzero((masses < 0.0) | ((least < -rounding) & ~about_one_axis))
    if not len(wrong):
        return None
    k = int(wrong[0])
    if masses[k] < 0.0:
        return k, f"a mass of {masses[k]:g} kg"
    low, middle, high = moments[k]
    return k, f"principal moments of inertia of {low:g}, {middle:g} and {high:g} kg m2, which no body has"


def _is_balanced(inertia: pin.Inertia, axis: Array, size: float) -> bool:
    """Whether the inertia of a body does not change as it turns about an axis (3,) through its joint's origin, in a linkage of this size
    [m]."""
    normal_part = np.eye(3) - np.outer(axis, axis)  # projects on the plane normal to the axis
    transverse = normal_part @ inertia.inertia @ normal_part
    along = axis @ inertia.inertia @ axis
    uneven = inertia.inertia - along * np.outer(axis, axis) - 0.5 * np.trace(transverse) * normal_part
    eccentric = inertia.mass * np.linalg.norm(normal_part @ inertia.lever)
    return bool(np.abs(uneven).max() <= 1e-9 * along and eccentric <= 1e-9 * inertia.mass * size)  # less is rounding


# Outside the class, where it would be taken for the field's default.
Linkage.model = Model()


class OfPress:
    """Base of the results of a press, which know the press that they are of."""

    _press: Linkage

    @property
    def press_name(self) -> str:
        """Name of the press."""
        return self._press.name


def is_same_press(press: Linkage, other: Linkage) -> bool:
    """Whether two linkages have the same name, links, joints, loops, drivers, lengths and masses, wherever they were read from."""
    return other is press or _made_of(other) == _made_of(press)


def told_apart(press: Linkage, other: Linkage) -> str:
    """How messages call a press that is not the other one."""
    return press.name if press.name != other.name else f"a {press.name} with other lengths, masses or zero"


def _made_of(press: Linkage) -> tuple[object, ...]:
    """What a linkage is made of, apart from the texts and lines of its file."""
    ends = "point1", "rotation1", "point2", "rotation2"
    loops = [(each.name, each.type, each.joint1, each.joint2, *(getattr(each, end).tolist() for end in ends)) for each in press.loops]
    relations = [(each.name, dict(each.coefficients), each.offset, each.curve) for each in press.relations]
    elements = [replace(each, line=0) for each in press.document.description.elements]  # their friction and pressure angles
    return (
        press.name,
        press.links,
        press.drivers,
        press.passive,
        press.joint_springs,
        press.slide,
        press.zero,
        press.home,
        loops,
        relations,
        elements,
        press.model,
    )
