"""A press linkage: the URDF's tree as a Pinocchio model, its loops, its drivers and its slide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.arrays import Array
from ..common.errors import PinpressError, shown
from ..common.frozen import Frozen
from ..engines import branch
from ..engines.branch import Branch, Returning
from ..engines.change_points import Gap
from ..engines.closure import ACCEPTED, Close, Closure
from ..engines.continuation import SMALLEST_MARGIN
from ..engines.coordinates import Axis, Slot
from ..engines.joints import Coupling, LoopJoint
from ..engines.load_sharing import RANK
from ..engines.planar import kinematics as plane_kinematics
from ..engines.planar import model as plane
from ..engines.planar.bodies import Bodies
from ..engines.planar.bodies import build as bodies_of
from ..engines.planar.model import Plane
from ..engines.spatial import constraints as spatial_equations
from ..engines.spatial import model as spatial
from ..engines.spatial.forward_dynamics import ForwardDynamics
from ..engines.spatial.model import Spatial
from .memo import Model, keep_geometry, per_linkage
from .urdf.document import Document

CLEAR = 1e-2  # margin of a block of redundant equations below which all are solved together
EVEN = 1e-9  # of its moment of inertia, or of the linkage's size: unbalance of a shaft that is rounding


@dataclass(frozen=True, eq=False, repr=False)
class Linkage(Frozen):
    """A closed linkage and its drivers. Made by `load`; read-only, ``model`` too: once it was changed in place, whatever is asked of the
    linkage raises a PinpressError.

    World axes: z up; a planar press stands in the x-z plane. Angles are zero in the drawn pose. SI units. A changed linkage is made by
    ``dataclasses.replace(press, model=...)`` with a changed copy of the model: everything else here is derived.

    Attributes:
        name: the URDF's robot name.
        document: the URDF it was read from.
        model: Pinocchio's model of the tree, loops cut, gravity set.
        links: names of all links, in document order. root: the frame's.
        loops: the bearings at which loops were cut. couplings: gear pairs and the like.
        drivers: names of the driver joints, as many as degrees of freedom.
        slide: name of the slide link, None where the linkage has none.
    """

    name: str
    document: Document
    model: pin.Model
    links: tuple[str, ...]
    root: str
    loops: tuple[LoopJoint, ...]
    couplings: tuple[Coupling, ...]
    drivers: tuple[str, ...]
    slide: str | None

    def __repr__(self) -> str:
        return f"<Linkage {self.name}: driver {', '.join(self.drivers)}, slide {self.slide}, bearings {', '.join(self.bearings)}>"

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
    def size(self) -> float:
        """Largest extent of joints and loops in the drawn pose [m]: the length that angles are weighed by against travels."""
        return self.spatial.size

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Axes of the moving joints, each in its own frame."""
        return self.spatial.axes

    @property
    def slots(self) -> tuple[Slot, ...]:
        """Where the moving joints stand in q."""
        return self.spatial.slots

    @property
    def driver_indices(self) -> tuple[int, ...]:
        """Indices of the driver joints in v."""
        return self.spatial.drivers

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Names of the moving joints in Pinocchio's order, that of v."""
        return tuple(self.model.names)[1:]

    @cached_property
    def bearings(self) -> tuple[str, ...]:
        """Names of all joints and loops that transmit forces: joints in Pinocchio's order, then loops."""
        return self.joints + tuple(loop.name for loop in self.loops)

    @property
    @per_linkage
    def mobility(self) -> int:
        """Degrees of freedom of the closed linkage: joints less the rank of the equations. One a driver, or `load` had refused."""
        return int(self.model.nv) - self.rank

    @property
    @per_linkage
    def rank(self) -> int:
        """Rank of the equations of loops and couplings in the closed drawn pose."""
        if self.plane is not None and plane_kinematics.moves(self.plane, self.drawn):
            return int(self.model.nv) - 1  # each of its blocks gives its joints: that is what it has a plane for
        return spatial.rank(self.closed_rows.columns)

    @property
    @per_linkage
    def spatial(self) -> Spatial:
        """Constants of the Pinocchio engine."""
        return spatial.build(self.model, self.loops, self.couplings, tuple(self.joints.index(driver) for driver in self.drivers))

    @property
    @per_linkage
    def plane(self) -> Plane | None:
        """Constants of the planar engine, None where the linkage is not planar, or needs more than its blocks of equations."""
        return self._assembly.plane

    @property
    @per_linkage
    def bodies(self) -> Bodies | None:
        """Inertial constants of the planar engine."""
        return None if self.plane is None else bodies_of(self.plane, self.model)

    @property
    @per_linkage
    def as_drawn(self) -> Array:
        """(nv,) joint coordinates of the drawn pose as the file has it, not yet closed: zero, and of gear pairs with an offset where these
        put their joints while the drivers are at zero."""
        position, found = np.zeros(self.model.nv), {self.joints.index(driver) for driver in self.drivers}
        meshed: dict[int, list[tuple[int, float, float]]] = {}
        for each in self.couplings:
            meshed.setdefault(each.leader, []).append((each.follower, each.multiplier, each.offset))
            if each.multiplier:
                meshed.setdefault(each.follower, []).append((each.leader, 1 / each.multiplier, -each.offset / each.multiplier))
        followers = {each.follower for each in self.couplings}
        leaders = sorted({each.leader for each in self.couplings}, key=lambda joint: (joint in followers, joint))
        for start in (*sorted(found), *leaders):
            reached = [start]
            found.add(start)
            for joint in reached:  # grows as it goes
                for other, multiplier, offset in meshed.get(joint, ()):
                    if other not in found:
                        position[other] = multiplier * position[joint] + offset
                        found.add(other)
                        reached.append(other)
        return position

    @property
    @per_linkage
    def drawn(self) -> Closure:
        """The drawn pose, its drivers at zero, closed as far as Newton's method came: `load` judges it."""
        return self._assembly.drawn

    @property
    @per_linkage
    def closed(self) -> Array:
        """(nv,) joint coordinates of the drawn pose, closed exactly, drivers at zero [rad or m]."""
        closed = self.drawn.position[:, 0]
        closed.setflags(write=False)
        return closed

    @property
    @per_linkage
    def _assembly(self) -> _Assembly:
        """The drawn pose closed by the engine that suits."""
        start, general = self.as_drawn[:, None], self.spatial
        for one_block in (False, True) if len(self.drivers) == 1 else ():
            planar = plane.build(self.model, self.loops, self.couplings, general.drivers[0], one_block)
            if planar is None:
                break
            closure = plane_kinematics.close(planar, np.zeros(1), start, with_margins=True)
            # Of a redundant linkage one block may lock where the others hold it: a parallelogram with a third crank at its change point.
            walked = self._full_turn(planar, closure) if planar.redundant and not one_block else None
            fit = one_block or walked is not None or not planar.redundant
            if fit and closure.margins is not None and np.abs(closure.margins).min(initial=1.0) > RANK:
                return _Assembly(planar, closure, walked)
        equations, along = general.equations(), [1.0] + [0.0] * (len(self.drivers) - 1)
        closure = spatial.close(general, equations, np.zeros((len(self.drivers), 1)), along, start)
        gaps = equations.at(start[:, 0]).gaps
        rows = equations.at(closure.position[:, 0]) if np.isfinite(closure.position).all() else None
        return _Assembly(None, closure, None, gaps, rows)

    def _walk(
        self,
        planar: Plane | None,
        closed: Array,
        smallest_margin: float = SMALLEST_MARGIN,
        gap: Gap | None = None,
        begin: float = 0.0,
    ) -> Branch:
        general = self.spatial
        returning = Returning(general.on_loop, np.array([axis.turns for axis in general.axes]))
        if planar is not None:
            close: Close = partial(plane_kinematics.close, planar, with_margins=True)
        else:
            close = self._close_spatial
        tolerance = (planar or general).tolerance
        return branch.walk(close, closed, returning, general.size, ACCEPTED * tolerance, smallest_margin, gap, begin)

    def _full_turn(self, planar: Plane, drawn: Closure) -> Branch | None:
        """The branch where the driver turns fully with the equations in the blocks of this plane, well away from locks; else None."""
        try:
            walked = self._walk(planar, drawn.position[:, 0], smallest_margin=CLEAR)
        except PinpressError:
            return None
        return walked if walked.period is not None else None

    @property
    @per_linkage
    def slide_guide(self) -> tuple[int, float]:
        """Place of the slide's guide in v, and the slide's position along the guide in the drawn pose [m].

        Raises:
            PinpressError: the linkage has no slide.
        """
        if self.slide is None:
            raise PinpressError(f"{self.name} has no slide: name a link that the frame guides, load(..., slide=...)")
        frame = self.model.frames[self.model.getFrameId(self.slide, pin.BODY)]
        guide = frame.parentJoint - 1
        place = self.model.jointPlacements[frame.parentJoint]  # in the world, as the frame carries the guide
        axis = place.rotation @ self.axes[guide].direction
        return guide, float(axis @ place.act(frame.placement.translation))

    @property
    @per_linkage(of_geometry=True)
    def branch(self) -> Branch:
        """The drawn assembly over the crank angle, walked once.

        Raises:
            SingularityError: the linkage locks at its drawn pose.
            AssemblyError: its loops do not stay closed, or it moves too fast to be followed.
            PinpressError: it has several drivers.
        """
        if len(self.drivers) > 1:
            raise PinpressError(f"{self.name} has {len(self.drivers)} drivers: give angle, speed and acceleration of all, (n, drivers)")
        if self._assembly.branch is not None:
            return self._assembly.branch
        return self._walk(self.plane, self.closed)

    @property
    @per_linkage(of_geometry=True)
    def passage(self) -> Branch:
        """The same, carried on through change points: where two assemblies meet, a linkage in motion goes on in its own.

        Raises as `branch`.
        """
        found = self.branch
        if found.period is not None or not any(found.locks):
            return found
        middle = 0.5 * float(found.angles[0] + found.angles[-1])  # the drawn pose may be beside a change point
        carried = self._walk(self.plane, branch.predict(found, np.array([middle]))[:, 0], gap=self.gaps, begin=middle)
        return carried if carried.change_points else found

    @property
    def period_turns(self) -> int:
        """Turns of the driver in one period, after which all that matters to motion and forces is where it was. Mostly one; more where gear
        ratios bring something back later. A balanced shaft that is geared to a linkage, and on none of its loops, does not count.

        Raises:
            SingularityError: the linkage locks before.
            PinpressError: it is not back after many turns, or has several drivers.
        """
        if self.turns_until_back is not None:
            return self.turns_until_back
        if self.passage.period is None:
            raise branch.beyond(self.passage, upwards=self.passage.locks[True] is not None)
        raise PinpressError(
            f"{self.name} has no period: an unbalanced shaft is geared so that it is not back after {branch.MOST_TURNS} turns; give crank"
            " angles, cycle(press, speed, angle=[...]), or another gear ratio"
        )

    @property
    @per_linkage
    def turns_until_back(self) -> int | None:
        """The same, None where it is not back, or has several drivers."""
        if len(self.drivers) > 1:
            return None
        found = self.passage
        if found.period is None:
            return None
        counts = [axis.turns and not self._is_balanced(k) for k, axis in enumerate(self.axes)]  # on loops all are back
        periods = branch.periods_until_back(found.advance[counts])
        return None if periods is None else periods * round(found.period / (2 * np.pi))

    def _is_balanced(self, joint: int) -> bool:
        """Whether what a joint carries has the same inertia however far it has turned; ``joint``: place in v."""
        body = joint + 1
        if body in list(self.model.parents)[1:]:
            return False  # it carries other joints
        inertia, axis = self.model.inertias[body], self.axes[joint].direction
        across = np.eye(3) - np.outer(axis, axis)
        transverse = across @ inertia.inertia @ across
        along = axis @ inertia.inertia @ axis
        uneven = inertia.inertia - along * np.outer(axis, axis) - 0.5 * np.trace(transverse) * across
        eccentric = inertia.mass * np.linalg.norm(across @ inertia.lever)
        return bool(np.abs(uneven).max() <= EVEN * along and eccentric <= EVEN * inertia.mass * self.size)

    def with_inertias(self, inertias: Sequence[pin.Inertia], name: str | None = None) -> Linkage:
        """The same linkage with other bodies, and perhaps another name: inertias of all joints, the frame's first, in their frames. What is
        known of its geometry is kept, as loops do not feel masses."""
        model = self.model.copy()
        for joint, inertia in enumerate(inertias):
            model.inertias[joint] = inertia
        changed = replace(self, model=model, name=name or self.name)
        keep_geometry(changed, self)
        return changed

    def forward_dynamics(self, armature: Array) -> ForwardDynamics:
        """Forward dynamics by Pinocchio, of any linkage.

        Args:
            armature: (nv,) inertia that turns with the joints, added to what the model has [kg m2; kg at one that slides].

        Raises:
            PinpressError: an armature of another shape, or not finite.
        """
        return ForwardDynamics(self.spatial, self.closed, self.rank, armature, self.name)

    def link_of(self, joint: int) -> str:
        """Name of the link that the body of a Pinocchio joint (0: the frame) begins with."""
        if joint == 0:
            return self.root
        return next(str(frame.name) for frame in self.model.frames if frame.type == pin.BODY and frame.parentJoint == joint)

    def gaps(self, position: Array) -> Array:
        """Largest gaps (n,) of the loops at joint coordinates (nv, n) [m]."""
        if self.plane is not None:
            return plane_kinematics.gaps(self.plane, position, plane_kinematics.basis(self.plane, position))
        equations = self.spatial.equations()
        return np.array([equations.widest(equations.at(x).gaps) for x in position.T])

    @property
    @per_linkage
    def drawn_gaps(self) -> Array:
        """(rows,) gaps of the equations of loops and couplings as drawn, see `spatial_equations`."""
        if self.plane is None:
            assert self._assembly.gaps is not None
            return self._assembly.gaps
        x, size, axes = self.as_drawn, self.size, self.axes
        turns = np.zeros(sum(loop.held for loop in self.loops))  # axes are parallel in the plane
        slips = [
            (x[each.follower] - each.multiplier * x[each.leader] - each.offset) * (size if axes[each.follower].turns else 1.0)
            for each in self.couplings
        ]
        return np.concatenate([plane_kinematics.openings(self.plane, x).ravel(), turns, slips])

    @property
    @per_linkage
    def closed_rows(self) -> spatial_equations.Rows:
        """The equations in the closed drawn pose."""
        return self._assembly.rows or self.equations(self.closed)

    def equations(self, x: Array) -> spatial_equations.Rows:
        """The equations of loops and couplings at joint coordinates (nv,)."""
        return self.spatial.equations().at(x)

    def close(self, angle: Array, guess: Array, engine: str = "auto", with_margins: bool = False) -> Closure:
        """Close the loops at crank angles (n,) from guesses (nv, n); the caller judges the result. ``engine`` as in `cycle`."""
        if plane := self.planar(engine):
            return plane_kinematics.close(plane, angle, guess, with_margins)
        return self._close_spatial(angle, guess)

    def _close_spatial(self, angle: Array, guess: Array) -> Closure:
        return spatial.close(self.spatial, self.spatial.equations(), angle[None], [1.0], guess)

    def planar(self, engine: str) -> Plane | None:
        """The constants of the planar engine where ``engine`` ("auto", "plane" or "pinocchio") means it, else None.

        Raises:
            PinpressError: unknown engine, or "plane" for a linkage that is not planar.
        """
        if not isinstance(engine, str) or engine not in ("auto", "plane", "pinocchio"):
            raise PinpressError(f"unknown engine {shown(engine)}: write 'auto', 'plane' or 'pinocchio'")
        if engine == "pinocchio":
            return None
        plane = self.plane
        if plane is None and engine == "plane":
            raise PinpressError(
                f"{self.name} is not a planar linkage with one driver and pins for loops: use engine='pinocchio' (or 'auto')"
            )
        return plane


# Outside the class, where it would be taken for the field's default.
Linkage.model = Model()


class _Assembly(NamedTuple):
    """The planar engine's constants, None where the other engine suits; the closed drawn pose; its branch where it was walked to see; where
    the other engine closed it the gaps as drawn, and its equations."""

    plane: Plane | None
    drawn: Closure
    branch: Branch | None
    gaps: Array | None = None
    rows: spatial_equations.Rows | None = None
