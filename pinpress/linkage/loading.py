"""From a file to a `Linkage`: `load` parses it, checks its elements, builds the linkage, puts it together and judges it, each once."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from ..common.arguments import LARGEST, numbers, typed
from ..common.errors import PinpressError, UnknownNameError, UrdfError, caution, shown, suggestion
from ..common.files import alike, path_of
from ..common.quantities import Array
from ..engines.constraints import LoopJoint, Relation, gear
from . import cams, machine_elements
from .checks import assembly as assembly_checks
from .checks import elements as element_checks
from .description import Description, Loop
from .description import Relation as DescribedRelation
from .document import Document, check_command, read, refuse_errors
from .driving.drivers import Proposal, propose, settle
from .formats import companion, dialects
from .formats.free_bodies import Base, with_base
from .home import mount
from .linkage import Linkage


def presses() -> tuple[str, ...]:
    """Names of the presses that come with pinpress; `load` takes them in place of a path."""
    return tuple(sorted(path.stem for path in _library().glob("*.urdf")))


@typed
def load(
    path: str | os.PathLike[str],
    driver: str | Sequence[str] | None = None,
    slide: str | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
    *,
    drivers: str | Sequence[str] | None = None,
    base: Base = "fixed",
    pose: Mapping[str, float] | None = None,
) -> Linkage:
    """Read a linkage from a URDF with ``<loop_joint>`` elements, put it together and check that its driver determines it.

    A closed drawn pose is taken as it is. Where loops are drawn open, they are closed, in this order: near ``pose``; near the ``<home>`` of
    the file; near the drawn pose with the drivers held, then with all joints free; from the middles of the limits; from random poses.
    ``press.assembly.how`` says what was taken, ``press.closed`` has the joint coordinates. These count from the zeros of the file.

    Files in other formats are turned into such a URDF first (``press.text``): URDF with the loops of Drake, URDF+ and Gazebo, SDF, and MJCF
    (by the package mujoco). The manual says which parts of them are read.

    Args:
        path: of the URDF, SDF or MJCF file, or the name of a shipped press (`presses`).
        driver: name of the driven joint, or names of as many as the linkage has degrees of freedom; default: those in the file's
            ``<transmission>`` elements.
        slide: name of the slide link, which a prismatic joint guides on the frame; default: the link "slide", or the child of the joint
            "slide_guide", or the only link so guided, unless it is the base of a robot, which carries all else that moves.
        gravity: in world axes [m/s2].
        drivers: another name of ``driver``.
        base: what a free joint of the file does: "fixed": it holds its body where the file draws it; "floating": it is free. Its six
            coordinates are then joints of their own, called after it with ``_x``, ``_y``, ``_z`` (along the axes of the body it hangs on),
            ``_rz``, ``_ry`` and ``_rx`` (one after the other, about the axes that the turns before have reached) behind. They are at
            their limit where the turn about y is a quarter turn. A free body that loops join to the rest is always free.
        pose: coordinates of some joints [rad or m], by their names, from the zeros of the file: the linkage is put together near them, with
            these joints held where it closes so. It chooses between assemblies.

    Raises:
        UrdfError: the file cannot be read, or makes no sense; no driver, or more or fewer drivers than degrees of freedom; a loop drawn
            far open that would be closed with its points read otherwise.
        UnknownNameError: ``pose`` names no joint of the file.
        AssemblyError: the loops do not close anywhere, or not near ``pose``.
        SingularityError: the driver does not determine the drawn pose, or assemblies meet there: the message lists poses that choose one.

    Warns:
        PinpressWarning: a linkage that is hardly meant: a loop drawn open by more than a hundredth of the linkage's size; lengths, angles,
            masses or inertias that are hardly in SI units; attributes and elements that are not read. `check` says more.
    """
    if driver is not None and drivers is not None:
        raise PinpressError("driver and drivers are both given, two names of one argument: leave one of them out")
    return load_document(parse(locate(path)), driver if drivers is None else drivers, slide, gravity, base=base, pose=pose)


def load_document(
    document: Document,
    driver: str | Sequence[str] | None = None,
    slide: str | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
    *,
    base: Base = "fixed",
    pose: Mapping[str, float] | None = None,
    in_file: bool = True,
    command: str = "",
) -> Linkage:
    """`load` of what was parsed.

    Args:
        document: a URDF.
        driver: as for `load`.
        slide: as for `load`.
        gravity: as for `load`.
        base: as for `load`.
        pose: as for `load`.
        in_file: whether users see the URDF. Else warnings name no line of it, and its centres of mass are not checked: the program that
            wrote it knows them.
        command: what lists all that is wrong; empty for the command ``pinpress check``.
    """
    document = with_base(document, base)
    refuse_errors(element_checks.errors(document), command or check_command(document.file))
    press, of_drivers = settle(mount(build(document, driver, slide, gravity), pose))
    refuse_without_driver(press)
    command = command or check_command(press.file, () if driver is None else press.drivers, slide)
    refuse_errors(assembly_checks.errors(press, in_file), command)
    findings = list(assembly_checks.remarks(press, quick=True, centres=in_file))
    refuse_errors(findings, command)
    of_file = list(element_checks.once(finding for finding in document.remarks if finding.severity == "warning"))
    if in_file:
        of_file += element_checks.warnings(document)
    for finding in (*of_file, *of_drivers, *findings):
        caution((finding if in_file else replace(finding, line=None)).message(press.file))
    return press


def locate(path: str | os.PathLike[str]) -> str | os.PathLike[str]:
    """The path of a URDF file, given itself or the name of a shipped press; raises UrdfError if there is neither."""
    file = path_of("path", path)
    if file.lstrip().startswith("<"):
        raise UrdfError(
            "path", None, None, "this is the text of a description, not the path of a file", "write it to a file and give the path of that"
        )
    if os.path.exists(file):
        return path
    if file in presses():
        return _library() / f"{file}.urdf"
    if file.endswith((".urdf", ".xml", ".sdf", ".mjcf")) or "\0" in file:
        return path  # reading it says what is wrong with it
    shipped = presses()
    remedy = f"name a URDF file or a shipped press ({', '.join(shipped)})"
    raise UrdfError(file, None, None, f"no such file{suggestion(file, shipped) or alike(file)}", remedy)


def shipped_table(name: str) -> Path | None:
    """The pin table of a shipped press; None if none has this name."""
    return _library() / f"{name}.yaml" if name in presses() else None


def parse(path: str | os.PathLike[str]) -> Document:
    """The URDF that a file is, or that says the same; raises UrdfError if there is none."""
    if path_of("path", path).endswith((".yaml", ".yml")):
        raise UrdfError(path_of("path", path), None, None, "this is a table of pins, not a URDF", "make a press of it by pp.build(path)")
    document = Document(path_of("path", path), read(path))
    root = document.robot
    if root.tag == "robot":
        return dialects.plain(companion.joined(document))
    if root.tag == "sdf":
        from .formats import sdf  # seldom needed

        return sdf.read(document)
    if root.tag == "mujoco":
        from .formats import mjcf  # seldom needed, and it takes the package mujoco

        return mjcf.read(document)
    remedy = "give a URDF, an SDF or an MJCF file"
    raise UrdfError(document.file, str(root), root.line, "the root element is not <robot>, <sdf> or <mujoco>", remedy)


def build(
    document: Document,
    driver: str | Sequence[str] | None,
    slide: str | None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
) -> Linkage:
    """The linkage of a URDF without errors in its elements, not yet put together; arguments and errors as of `load`."""
    description = document.description
    drivers = _drivers(document, driver)
    try:
        model = pin.buildModelFromXML(document.text.decode())
    except (ValueError, RuntimeError) as error:  # no file is known that passes the checks and fails here
        raise UrdfError(document.file, None, None, f"Pinocchio cannot read it: {error}", "simplify the file") from error
    model.gravity.linear = numbers("gravity", gravity, (3,), unit="m/s2")
    if np.abs(model.gravity.linear).max() > LARGEST:
        raise PinpressError(f"gravity is {shown(gravity)}: give m/s2, {LARGEST:g} at most")
    for joint in description.joints:
        if joint.name in drivers and joint.type == "prismatic" and joint.limits:
            _refuse_without_travel(document, joint.name, *joint.limits)
    places = {name: place for place, name in enumerate(tuple(model.names)[1:])}
    for name, inertia in description.armature.items():
        model.armature[places[name]] = inertia
    loops = tuple(_loop_joint(model, loop) for loop in description.loops)
    mimics = (
        gear(j.name, places[j.name], places[j.mimic.leader], j.mimic.multiplier, j.mimic.offset, j.mimic.line)
        for j in description.joints
        if j.mimic
    )
    related = (_relation(relation, places) for relation in description.relations)
    relations = (*mimics, *related, *(cams.relation(cam, document, model) for cam in description.cams))
    elements = machine_elements.placed(document, model, loops)
    of_elements = machine_elements.relations_of(document, elements, model, loops, [places[driver] for driver in drivers], relations)
    return Linkage(
        name=description.name,
        document=document,
        model=model,
        links=description.links,
        root=description.root,
        loops=loops,
        relations=relations + of_elements,
        drivers=drivers,
        slide=_slide(description, slide, drivers),
        joint_springs=description.joint_springs,
        contacts=(*machine_elements.contacts_of(elements, relations + of_elements), *cams.contacts(document, model, relations)),
    )


def refuse_without_driver(press: Linkage) -> None:
    """Raise UrdfError for a linkage of which nothing says what drives it; the message proposes drivers."""
    if press.drivers or not press.assembly.closes:
        return
    proposal = propose(press)
    remedy = (
        f"its mobility as drawn is {press.mobility}: name what drives, best {proposal.in_words}, in a URDF by"
        ' <transmission name="drive"><joint name="..."/></transmission>, else by load(..., drivers=...), in a job drivers: ...'
    )
    if not press.mobility:
        remedy = "nothing can move as it is drawn: a loop, a gear pair or a fixed joint too many"
    raise UrdfError(press.file, press.document.called("robot", press.name), None, "no driver", remedy)


@typed
def propose_drivers(press: Linkage | str | os.PathLike[str]) -> Proposal:
    """Propose drivers of a linkage: joints that move it independently and well, nearest to the frame and called like motors first.

    Args:
        press: a linkage, whatever drives it now, or the path of a file, or the name of a shipped press.

    Raises:
        UrdfError: the file cannot be read, or makes no sense.
        AssemblyError: the loops do not close.
    """
    if not isinstance(press, Linkage):
        document = with_base(parse(locate(press)), "fixed")
        refuse_errors(element_checks.errors(document), check_command(document.file))
        press = mount(build(document, (), None))
        if not press.assembly.closes:
            refuse_errors(assembly_checks.errors(press), check_command(press.file))
    return propose(press)


def _library() -> Path:
    """Folder of the shipped URDF files: in the package where it was installed from a wheel, beside it in a checkout."""
    here = Path(__file__).resolve().parents[1]
    return next(folder for folder in (here / "urdf", here.parent / "urdf") if folder.is_dir())


def _refuse_without_travel(document: Document, name: str, lower: float, upper: float) -> None:
    """Raise UrdfError for a driver that slides and cannot move between these limits [m]."""
    if lower < upper:
        return
    problem = f"the driver slides from {lower:g} to {upper:g} m, the <limit> of its joint, and so not at all"
    if lower == upper == 0.0:
        problem = "the <limit> of the driver, which slides, is 0 to 0 m, as programs write it that know no limits: it could not move"
    remedy = "write its travel from the drawn pose in m: lower, and an upper above it"
    raise UrdfError(document.file, document.called("joint", name), document.find("joint", name).line, problem, remedy)


def _drivers(document: Document, driver: str | Sequence[str] | None) -> tuple[str, ...]:
    """Names of the driver joints: those of the argument, else those of the file."""
    description = document.description
    moving = [joint.name for joint in description.joints if joint.type != "fixed"]
    given: tuple[str, ...] = description.drivers
    if driver is not None:
        given = tuple(driver) if isinstance(driver, list | tuple) else (driver,)  # type: ignore[assignment]
    for name in given:
        if not isinstance(name, str) or name not in moving:
            raise UnknownNameError("moving joint", name, moving)
    if len(set(given)) < len(given):
        raise PinpressError(f"driver names a joint twice: {', '.join(given)}")
    if not given and not moving:
        remedy = "write joints that move, and name one that drives"
        raise UrdfError(document.file, document.called("robot", description.name), None, "no driver", remedy)
    return given


def _loop_joint(model: pin.Model, loop: Loop) -> LoopJoint:
    ends: list[tuple[int, Array, Array]] = []
    turned = pin.Quaternion.FromTwoVectors(np.array([1.0, 0.0, 0.0]), np.array(loop.axis)).matrix()  # the first axis to the loop's
    for end in (loop.link1, loop.link2):
        frame = model.frames[model.getFrameId(end.link, pin.BODY)]
        place = frame.placement * pin.SE3(pin.rpy.rpyToMatrix(np.array(end.rpy)), np.array(end.xyz))
        ends.append((int(frame.parentJoint), place.translation, place.rotation @ turned))
    return LoopJoint(loop.name, loop.type, *ends[0], *ends[1], loop.line)


def _relation(relation: DescribedRelation, places: Mapping[str, int]) -> Relation:
    """The equation of a ``<relation>``, divided by the coefficient of its first joint; ``places``: of the joints in v."""
    joints, first = [places[name] for name in relation.joints], relation.coefficients[0]
    coefficients = {joint: coefficient / first for joint, coefficient in zip(joints, relation.coefficients, strict=True)}
    return Relation(relation.joints[0], coefficients, relation.offset / first, relation.line)


def _slide(description: Description, slide: str | None, drivers: Sequence[str]) -> str | None:
    """Name of the slide link: that of the argument, else as `load` chooses it."""
    guided = description.guided
    if slide is None:
        by_joint = {joint: link for link, joint in guided.items()}
        works = [link for link, guide in guided.items() if not _is_base(description, guide, drivers)]
        only = works[0] if len(guided) == len(works) == 1 else None
        return "slide" if "slide" in guided else by_joint.get("slide_guide", only)
    if not isinstance(slide, str) or slide not in description.links:
        raise UnknownNameError("link", slide, description.links)
    if description.bodies[slide] not in map(description.bodies.get, guided):
        raise PinpressError(
            f"link {shown(slide)} is not guided by the frame{suggestion(slide, guided)}; guided links: {', '.join(guided) or 'none'}"
        )
    return slide


def _is_base(description: Description, guide: str, drivers: Sequence[str]) -> bool:
    """Whether a slide is the base of a robot that floats in a plane: all that moves hangs on it, drivers as well, and nothing but its guide
    joins it to the frame."""
    bodies, root = description.bodies, description.root
    on_frame = [joint.name for joint in description.joints if joint.type != "fixed" and bodies[joint.parent] == root]
    looped = any(bodies[end.link] == root for loop in description.loops for end in (loop.link1, loop.link2))
    return bool(drivers) and guide not in drivers and on_frame == [guide] and not looped
