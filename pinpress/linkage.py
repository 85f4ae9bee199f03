"""A press linkage: the URDF's tree as a Pinocchio model, its loops, its driver and its slide."""

from dataclasses import dataclass
from functools import cached_property

import pinocchio as pin

from . import branch, plane_kinematics, spatial
from .branch import Branch, Closure
from .coordinates import Array
from .errors import PinpressError
from .plane import LoopPin, Plane
from .plane_dynamics import Bodies
from .spatial import Spatial

ACCEPTED = 1e3  # times the tolerance of rounding: a loop whose gap is not below that is open


@dataclass(frozen=True, eq=False, repr=False)
class Linkage:
    """A closed linkage with one driver. Made by `load`; read-only, ``model`` too.

    World axes: z up; a planar press stands in the x-z plane. Angles are zero in the drawn pose. SI units.

    Attributes:
        name: the URDF's robot name. file: where it was read. text: the URDF itself.
        model: Pinocchio's model of the tree, loops cut, gravity set.
        links: names of all links, in document order. root: the frame's.
        joints: names of the moving joints in Pinocchio's order (that of v). loops: the pins at which loops were cut.
        driver: name of the driver joint. slide: name of the slide link, None where the linkage has none.
        closed: (nv,) joint coordinates of the drawn pose, closed exactly, driver at zero [rad or m].
        plane, bodies: constants of the planar engine, None where the linkage is not planar (or its loops are redundant).
        spatial: constants of the Pinocchio engine.
    """

    name: str
    file: str
    text: bytes
    model: pin.Model
    links: tuple[str, ...]
    root: str
    joints: tuple[str, ...]
    loops: tuple[LoopPin, ...]
    driver: str
    slide: str | None
    closed: Array
    plane: Plane | None
    bodies: Bodies | None
    spatial: Spatial

    def __repr__(self) -> str:
        return f"<Linkage {self.name}: driver {self.driver}, slide {self.slide}, bearings {', '.join(self.bearings)}>"

    @property
    def bearings(self) -> tuple[str, ...]:
        """Names of all joints and loops that transmit forces: joints in Pinocchio's order, then loops."""
        return self.joints + tuple(loop.name for loop in self.loops)

    @cached_property
    def mobility(self) -> int:
        """Degrees of freedom of the closed linkage: joints less the rank of the loop Jacobian. One, or `load` had refused it."""
        return spatial.mobility(spatial.loop_rows(self.model, self.loops, self.closed)[1])

    @cached_property
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
        axis = place.rotation @ self.spatial.axes[guide].direction
        return guide, float(axis @ place.act(frame.placement.translation))

    @cached_property
    def branch(self) -> Branch:
        """The drawn assembly over the crank angle, walked once.

        Raises:
            AssemblyError: the linkage does not come back to its drawn pose.
        """
        tolerance = ACCEPTED * (self.plane or self.spatial).tolerance
        return branch.walk(lambda angle, guess: self.close(angle, guess, with_margins=True), self.closed, self.spatial.size, tolerance)

    def close(self, angle: Array, guess: Array, engine: str = "auto", with_margins: bool = False) -> Closure:
        """Close the loops at crank angles (n,) from guesses (nv, n); the caller judges the result. ``engine`` as in `cycle`."""
        if plane := self.planar(engine):
            return plane_kinematics.close(plane, angle, guess, with_margins)
        return spatial.close(self.spatial, angle, guess)

    def planar(self, engine: str) -> Plane | None:
        """The constants of the planar engine where ``engine`` ("auto", "plane" or "pinocchio") means it, else None.

        Raises:
            PinpressError: unknown engine, or "plane" for a linkage that is not planar.
        """
        if engine not in ("auto", "plane", "pinocchio"):
            raise PinpressError(f"unknown engine {engine!r}: write 'auto', 'plane' or 'pinocchio'")
        if engine == "plane" and self.plane is None:
            raise PinpressError(f"{self.name} is not a planar linkage with independent loops: use engine='pinocchio' (or 'auto')")
        return None if engine == "pinocchio" else self.plane
