"""From a URDF file to a `Linkage`: read, closed in its drawn pose, and found to be moved by its driver alone."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from . import plane, plane_dynamics, plane_kinematics, spatial
from .coordinates import Array
from .errors import AssemblyError, PinpressError, SingularityError, UnknownNameError, UrdfError, suggestion
from .linkage import ACCEPTED, Linkage
from .plane import LoopPin, Plane
from .spatial import Spatial

if TYPE_CHECKING:
    from . import urdf

CLOSE_TO_DRAWN = 0.25  # how far closing the drawn pose may turn a joint [rad], or move it in lengths of the linkage
ROUNDED = 1e-2  # axes as near to parallel as this are meant to be parallel [rad]


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
    from . import urdf  # only reading needs it, and it is a tenth of the package's import

    file = os.fspath(path)
    if not os.path.exists(file) and file in presses():
        path = _library() / f"{file}.urdf"
    elif not os.path.exists(file) and not file.endswith((".urdf", ".xml")):
        raise UrdfError(file, None, None, "no such file", f"name a URDF file or a shipped press ({', '.join(presses())})")
    description = urdf.read(path)
    driver = _driver(description, driver)
    try:
        model = pin.buildModelFromXML(description.text.decode())
    except (ValueError, RuntimeError) as error:  # nothing is known that passes the checks and ends here
        raise UrdfError(description.file, None, None, f"Pinocchio cannot read it: {error}", "simplify the file") from error
    model.gravity.linear = _gravity(gravity)
    loops = tuple(_loop_pin(model, loop) for loop in description.loops)
    joints = tuple(model.names[1:])
    driver_index = joints.index(driver)
    if not model.joints[driver_index + 1].shortname().startswith("JointModelR"):
        raise UrdfError(
            description.file, f'<joint name="{driver}">', _line(description, driver), "the driver does not turn", "drive a crank"
        )
    planar, general = plane.build(model, loops, driver_index), spatial.build(model, loops, driver_index)
    closed = _closed(description, planar, general)
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
        spatial=general,
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


def _closed(description: "urdf.Urdf", planar: Plane | None, general: Spatial) -> Array:
    """Joint coordinates (nv,) of the drawn pose, closed exactly."""
    model, loops, driver = general.model, general.loops, general.driver
    drawn = np.zeros((model.nv, 1))
    closure = plane_kinematics.close(planar, np.zeros(1), drawn) if planar else spatial.close(general, np.zeros(1), drawn)
    closed = closure.position[:, 0]
    tolerance = ACCEPTED * (planar or general).tolerance
    assembled = bool(closure.gap[0] <= tolerance) and np.abs(closed).max() <= CLOSE_TO_DRAWN * max(1.0, general.size)
    gaps, columns = spatial.loop_rows(model, loops, closed if assembled else drawn[:, 0])
    free = spatial.mobility(columns)
    rounded = None
    if plane.PARALLEL < (off := plane.misalignment(model, driver)) < ROUNDED:
        rounded = f"axes are up to {off:.2g} rad from parallel: write angles in full, 1.5707963267948966 for a quarter turn"
    robot = f'<robot name="{description.name}">'
    if free != 1:
        stuck = rounded or "a loop or a fixed joint too many: nothing can move"
        remedy = stuck if free < 1 else "a <loop_joint> is missing, or a link hangs free"
        raise UrdfError(description.file, robot, None, f"mobility is {free}, but one joint drives", remedy)
    if not assembled:
        distance = np.linalg.norm(gaps.reshape(-1, 3), axis=1)
        worst = int(distance.argmax())
        remedy = rounded or "draw it closed, or change the link lengths"
        raise AssemblyError(
            f"{description.file}:{description.loops[worst].line}: loop {loops[worst].name!r} does not close near the drawn pose; {remedy}",
            0.0,
            float(distance[worst]),
            closure.iterations,
        )
    passive = np.delete(columns, driver, axis=1)
    if spatial.mobility(passive) != 0:
        raise SingularityError(
            f"{description.file}: joint {model.names[driver + 1]!r} does not determine the drawn pose;"
            " draw the linkage away from its dead point",
            0.0,
            float(spatial.singular_values(passive).min()),
        )
    closed.setflags(write=False)
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
