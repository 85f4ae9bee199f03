"""A press linkage: the URDF's tree as a Pinocchio model, its loops, its driver and its slide."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from . import branch, plane, plane_dynamics, plane_kinematics, spatial
from .branch import Branch, Closure
from .coordinates import Array
from .errors import AssemblyError, PinpressError, SingularityError, UnknownNameError, UrdfError, suggestion
from .plane import LoopPin, Plane
from .plane_dynamics import Bodies
from .spatial import Spatial

if TYPE_CHECKING:
    from . import urdf

CLOSE_TO_DRAWN = 0.25  # how far closing the drawn pose may turn a joint [rad], or move it in lengths of the linkage
ACCEPTED = 1e3  # times the tolerance of rounding: a loop whose gap is not below that is open
DETERMINED = 1e-9  # smallest singular value at which the driver still determines the drawn pose


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

    @property
    def mobility(self) -> int:
        """Degrees of freedom of the closed linkage. `load` accepts only linkages with as many as there are drivers."""
        return 1

    @property
    def driver_index(self) -> int:
        """Place of the driver in v."""
        return self.joints.index(self.driver)

    @cached_property
    def slide_guide(self) -> tuple[int, float]:
        """Place of the slide's guide in v, and the slide's position along the guide in the drawn pose [m].

        Raises:
            PinpressError: the linkage has no slide.
        """
        if self.slide is None:
            raise PinpressError(f"{self.name} has no slide: name a link that the frame guides, load(..., slide=...)")
        frame = self.model.frames[self.model.getFrameId(self.slide, pin.BODY)]
        data = self.model.createData()
        pin.computeJointJacobians(self.model, data, pin.neutral(self.model))
        place = data.oMi[frame.parentJoint] * frame.placement
        columns = pin.getJointJacobian(self.model, data, frame.parentJoint, pin.WORLD).reshape(6, self.model.nv)
        axis = columns[:3, frame.parentJoint - 1]
        return frame.parentJoint - 1, float(axis @ place.translation)

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


def presses() -> tuple[str, ...]:
    """Names of the presses that come with pinpress; `load` takes them in place of a path."""
    return tuple(sorted(path.stem for path in _library().glob("*.urdf")))


def load(
    path: str | os.PathLike[str],
    driver: str | None = None,
    slide: str | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
) -> Linkage:
    """Read a linkage from a URDF with ``<loop_joint>`` elements, close its drawn pose exactly and check that its driver determines it.

    Args:
        path: of the URDF file, or the name of a shipped press (`presses`).
        driver: name of the driven joint; default: the one in the file's ``<transmission>``.
        slide: name of the slide link, which a prismatic joint guides on the frame; default: the link "slide", or the child of the joint
            "slide_guide", or the only link so guided.
        gravity: in world axes [m/s2].

    Raises:
        UrdfError: the file cannot be read, or makes no sense; no driver, or more or fewer drivers than degrees of freedom.
        AssemblyError: the loops do not close near the drawn pose.
        SingularityError: the driver does not determine the drawn pose.
    """
    from . import urdf  # reading is all it is for, and it takes a while to import

    file = os.fspath(path)
    if not os.path.exists(file) and file in presses():
        path = _library() / f"{file}.urdf"
    elif not os.path.exists(file) and not file.endswith((".urdf", ".xml")):
        raise UrdfError(file, None, None, "no such file", f"name a URDF file or a shipped press ({', '.join(presses())})")
    description = urdf.read(path)
    driver = _driver(description, driver)
    model = pin.buildModelFromXML(description.text.decode())
    model.gravity.linear = _gravity(gravity)
    loops = tuple(_loop_pin(model, loop) for loop in description.loops)
    joints = tuple(model.names[1:])
    driver_index = joints.index(driver)
    if not model.joints[driver_index + 1].shortname().startswith("JointModelR"):
        raise UrdfError(
            description.file, f'<joint name="{driver}">', _line(description, driver), "the driver does not turn", "drive a crank"
        )
    planar = plane.build(model, loops, driver_index)
    closed = _closed(description, model, loops, driver_index, planar)
    return Linkage(
        name=description.name,
        file=description.file,
        text=description.text,
        model=model,
        links=description.links,
        root=description.root,
        joints=joints,
        loops=loops,
        driver=driver,
        slide=_slide(description, model, slide),
        closed=closed,
        plane=planar,
        bodies=plane_dynamics.build(planar, model, loops) if planar else None,
        spatial=spatial.build(model, loops, driver_index, closed),
    )


def _library() -> Path:
    """Folder of the shipped URDF files: in the package where it was installed from a wheel, beside it in a checkout."""
    here = Path(__file__).resolve().parent
    return next(folder for folder in (here / "urdf", here.parent / "urdf") if folder.is_dir())


def _line(description: "urdf.Urdf", joint: str) -> int:
    return next(j.line for j in description.joints if j.name == joint)


def _driver(description: "urdf.Urdf", driver: str | None) -> str:
    moving = [joint.name for joint in description.joints if joint.type != "fixed"]
    robot = f'<robot name="{description.name}">'
    if driver is not None:
        if driver not in moving:
            raise UnknownNameError("moving joint", driver, moving)
        return driver
    if not description.drivers:
        raise UrdfError(
            description.file,
            robot,
            None,
            "no driver",
            'add <transmission name="drive"><joint name="..."/></transmission>, or load(..., driver=...)',
        )
    if len(description.drivers) > 1:
        raise UrdfError(
            description.file,
            robot,
            None,
            f"{len(description.drivers)} drivers ({', '.join(description.drivers)})",
            "drive one joint: load(..., driver=...)",
        )
    return description.drivers[0]


def _gravity(gravity: Sequence[float]) -> Array:
    try:
        vector = np.asarray(gravity, dtype=float)
    except (TypeError, ValueError):
        vector = np.empty(0)
    if vector.shape != (3,) or not np.all(np.isfinite(vector)):
        raise PinpressError(f"gravity {gravity!r} is not three finite numbers [m/s2]")
    return vector


def _loop_pin(model: pin.Model, loop: "urdf.Loop") -> LoopPin:
    ends = []
    for end in (loop.link1, loop.link2):
        frame = model.frames[model.getFrameId(end.link, pin.BODY)]
        ends += [int(frame.parentJoint), frame.placement.act(np.array(end.xyz))]
    return LoopPin(loop.name, *ends)


def _closed(description: "urdf.Urdf", model: pin.Model, loops: tuple[LoopPin, ...], driver: int, planar: Plane | None) -> Array:
    """Joint coordinates (nv,) of the drawn pose, closed exactly."""
    drawn = np.zeros((model.nv, 1))
    start = spatial.build(model, loops, driver, drawn[:, 0])
    closure = plane_kinematics.close(planar, np.zeros(1), drawn) if planar else spatial.close(start, np.zeros(1), drawn)
    closed = closure.position[:, 0]
    tolerance = ACCEPTED * (planar or start).tolerance
    assembled = bool(closure.gap[0] <= tolerance) and np.abs(closed).max() <= CLOSE_TO_DRAWN * max(1.0, start.size)
    gaps, columns = spatial.loop_rows(model, loops, closed if assembled else drawn[:, 0])
    free = spatial.mobility(columns)
    robot = f'<robot name="{description.name}">'
    if free != 1:
        remedy = "a <loop_joint> is missing, or a link hangs free" if free > 1 else "a loop or a fixed joint too many: nothing can move"
        raise UrdfError(description.file, robot, None, f"mobility is {free}, but one joint drives", remedy)
    if not assembled:
        distance = np.linalg.norm(gaps.reshape(-1, 3), axis=1)
        worst = int(distance.argmax())
        raise AssemblyError(
            f"{description.file}:{description.loops[worst].line}: loop {loops[worst].name!r} does not close near the drawn pose;"
            " draw it closed, or change the link lengths",
            0.0,
            float(distance[worst]),
            closure.iterations,
        )
    passive = np.delete(columns, driver, axis=1)
    if spatial.mobility(passive) != 0:
        values = np.linalg.svd(passive / np.linalg.norm(passive, axis=0), compute_uv=False)
        raise SingularityError(
            f"{description.file}: joint {model.names[driver + 1]!r} does not determine the drawn pose;"
            " draw the linkage away from its dead point",
            0.0,
            float(values.min(initial=0.0)),
        )
    return closed


def _slide(description: "urdf.Urdf", model: pin.Model, slide: str | None) -> str | None:
    guided = {j.child: j.name for j in description.joints if j.type == "prismatic" and model.parents[model.getJointId(j.name)] == 0}
    if slide is not None:
        joint = model.frames[model.getFrameId(slide, pin.BODY)].parentJoint if slide in description.links else 0
        if slide not in description.links:
            raise UnknownNameError("link", slide, description.links)
        if model.names[joint] not in guided.values():
            raise PinpressError(
                f"link {slide!r} is not guided by the frame{suggestion(slide, guided)}; guided links: {', '.join(guided) or 'none'}"
            )
        return slide
    if "slide" in guided:
        return "slide"
    by_joint = {joint: link for link, joint in guided.items()}
    if "slide_guide" in by_joint:
        return by_joint["slide_guide"]
    return next(iter(guided)) if len(guided) == 1 else None
