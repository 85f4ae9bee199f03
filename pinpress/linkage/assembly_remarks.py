"""What is odd or worth knowing about a linkage that can be loaded: warnings and notes."""

from collections.abc import Iterator

import numpy as np

from ..common.arrays import Array
from ..common.errors import PinpressError
from ..engines.branch import MOST_TURNS, Branch, predict
from ..engines.coordinates import drawn
from ..engines.planar.model import PARALLEL
from . import mobility
from .assembly_checks import apart, rounded
from .linkage import Linkage
from .urdf import element_remarks
from .urdf.document import Element
from .urdf.findings import Finding

OPEN = 1e-6  # a loop drawn further open than this is said to be [lengths of the linkage, rad]
FAR_OPEN, CLOSED_FAR = 0.02, 0.05  # a loop that is drawn as far open [lengths], or moved as far to close it [rad or m], is hardly meant
LARGEST = 50.0  # linkage of a press [m]
DOWNWARDS, BELOW = 0.9, 0.25  # cosine of an axis that points down; how far below its crank a slide hangs [lengths of the linkage]
OUTSIDE = 1e-9  # a joint further beyond its limit than this has left it [rad or m]
HARDLY = 1.0  # a driver that turns by less hardly moves the linkage [deg]
SAMPLES = 720  # per turn
POSES = 6  # looked at for redundancy: one may be a dead centre, where idle forces pass some loops by


def remarks(press: Linkage, robot: "Element") -> Iterator[Finding]:
    """All of them; ``robot``: root element of the linkage's URDF."""
    yield from _drawn_open(press, mobility.held(press), OPEN)
    yield from _units(press, robot)
    yield from _slide_axis(press, robot)
    poses = press.closed[:, None]
    if len(press.drivers) == 1:
        line = next(joint.line for joint in robot.all("joint") if joint.get("name") == press.driver)
        where = f'<joint name="{press.driver}">', line
        try:
            branch = press.branch
        except PinpressError as error:
            yield Finding("warning", *where, f"the drawn assembly cannot be followed through a turn: {error}", "change the link lengths")
        else:
            poses = np.hstack([poses, predict(branch, np.linspace(branch.angles[0], branch.angles[-1], POSES))])
            if branch.period is None and not any(branch.locks):
                problem = f"the linkage is not back at its drawn pose after {MOST_TURNS} turns of it"
                yield Finding("note", *where, problem, "it is followed through as many turns either way: keep motions inside")
            elif branch.period is None and (points := press.branch_through_change_points.change_points):
                places = ", ".join(f"{place:.6g}" for place in sorted(np.degrees(point.angle) for point in points))
                problem = f"two assemblies meet at crank angles of {places} deg"
                yield Finding("note", *where, problem, "a simulated run goes through, in the drawn one; a prescribed turn is refused there")
            elif branch.period is None:
                low, high = np.degrees([branch.angles[0], branch.angles[-1]])
                severity = "note" if high - low > HARDLY else "warning"
                remedy = "keep motions inside, or correct the lengths"
                yield Finding(severity, *where, f"it turns only from {low:.6g} to {high:.6g} deg, where the linkage locks", remedy)
            yield from _limits(press, branch, robot)
    yield from _redundant(press, poses)
    yield from _engine(press)


def severe(press: Linkage, robot: "Element") -> Iterator[Finding]:
    """The warnings of what makes results of another linkage than was meant, found in a moment: `load` passes them on."""
    far = np.abs(press.closed - press.as_drawn).max() > CLOSED_FAR
    yield from _drawn_open(press, mobility.held(press)[: len(press.loops)], OPEN if far else FAR_OPEN)
    yield from _units(press, robot)
    yield from _slide_axis(press, robot)


def _units(press: Linkage, robot: "Element") -> Iterator[Finding]:
    """Of lengths, masses or inertias that are hardly in SI units."""
    if press.size > LARGEST:
        problem = f"the linkage is {press.size:.4g} m long"
        yield Finding("warning", str(robot), robot.line, problem, "write lengths in metres, 0.001 for a millimetre")
    yield from element_remarks.inertias(robot, press.size)


def _slide_axis(press: Linkage, robot: "Element") -> Iterator[Finding]:
    """Of a slide that hangs below its crank and is guided along an axis that points down, so that top and bottom are exchanged."""
    gravity = float(np.linalg.norm(press.model.gravity.linear))
    if press.slide is None or gravity == 0.0:
        return
    guide, _ = press.slide_guide
    place = press.model.jointPlacements[guide + 1]
    axis = place.rotation @ press.axes[guide].direction
    crank = drawn(press.model)[press.driver_indices[0] + 1].translation
    if axis @ press.model.gravity.linear > DOWNWARDS * gravity and axis @ (place.translation - crank) > BELOW * press.size:
        joint = next(joint for joint in robot.all("joint") if joint.get("name") == press.joints[guide])
        problem = f"the axis of slide {press.slide!r} points down, away from the crank: its top is taken for its bottom dead centre"
        yield Finding("warning", str(joint), joint.line, problem, "turn the <axis> round, so that it points up")


def _drawn_open(press: Linkage, among: list[mobility.Held], beyond: float) -> Iterator[Finding]:
    """Of those among loops and gear pairs that are drawn open by more than a part of the linkage's length."""
    gaps, moves = press.drawn_gaps, press.closed - press.as_drawn
    most = int(np.argmax(np.abs(moves)))
    moved = f"joint {press.joints[most]!r} by {_value(press, most, moves[most])}"
    for each in among:
        if each.gap(gaps) > beyond * press.size:
            remedy = f"draw it closed; to close it, load has moved {moved}"
            yield Finding("warning", each.element, each.by.line, f"it is {apart(press, each, gaps)} apart as drawn", remedy)


def _limits(press: Linkage, branch: Branch, robot: "Element") -> Iterator[Finding]:
    """Of joints that leave their limits in a turn of the driver, or as far as it goes."""
    low, high = branch.angles[0], branch.angles[-1]
    angles = np.linspace(low, high, 1 + max(1, round(SAMPLES * (high - low) / (2 * np.pi))))
    positions = predict(branch, angles)
    for name, (lower, upper, element) in element_remarks.limits(robot).items():
        joint = press.joints.index(name)
        if not lower <= 0.0 <= upper and not press.as_drawn[joint]:
            continue  # said of the drawn pose
        for beyond, side, limit in ((lower - positions[joint], "lower", lower), (positions[joint] - upper, "upper", upper)):
            at = int(np.argmax(beyond))
            if beyond[at] > OUTSIDE:
                reached = f"it reaches {_value(press, joint, positions[joint, at])} at crank angle {np.degrees(angles[at]):.6g} deg"
                remedy = "widen the limit, or correct the lengths (limits do not enter any computation)"
                yield Finding("warning", str(element), element.line, f"{reached}, beyond its {side} limit {limit:g}", remedy)


def _value(press: Linkage, joint: int, value: float) -> str:
    """A joint coordinate in words."""
    return f"{value:.6g} rad ({np.degrees(value):.4g} deg)" if press.axes[joint].turns else f"{value:.6g} m"


def _redundant(press: Linkage, poses: Array) -> Iterator[Finding]:
    across, further, among = mobility.redundancy(press, press.closed)
    robot, shared = f'<robot name="{press.name}">', "is shared by least squares, reactions.indeterminate marks it"
    if across:
        problem = f"{_equations(across)} redundant across the plane of the linkage, as in any with parallel pins"
        yield Finding("note", robot, None, problem, f"what bearings carry across it {shared}")
    if further:
        found = [*among, *(each for x in poses.T for each in mobility.redundancy(press, x).among)]
        where = "in the plane" if mobility.lies_in_plane(press) else "in space"
        problem = f"{_equations(further)} redundant {where}, of {', '.join(each.title for each in mobility.held(press) if each in found)}"
        remedy = f"their load {shared}; or give inverse_dynamics a stiffness=; lengths and angles have to fit to all digits"
        yield Finding("note", robot, None, problem, remedy)


def _equations(count: int) -> str:
    return "1 equation is" if count == 1 else f"{count} equations are"


def _engine(press: Linkage) -> Iterator[Finding]:
    if "plane" not in press.engines:
        problem = f"engine 'pinocchio' computes it, one configuration at a time: {_not_planar(press)}"
        remedy, slower = rounded(press), "results are as exact, and take some hundred times longer"
        yield Finding("warning" if remedy else "note", f'<robot name="{press.name}">', None, problem, remedy or slower)


def _not_planar(press: Linkage) -> str:
    """Why the planar engine does not take it."""
    if len(press.drivers) > 1:
        return f"there are {len(press.drivers)} drivers"
    joints, loops = mobility.joints_off_plane(press), mobility.loops_off_plane(press)
    plane = f"the plane in which joint {press.driver!r} turns"
    if (off := max(joints)) > PARALLEL:
        joint = joints.index(off)
        if press.axes[joint].turns:
            return f"the axis of joint {press.joints[joint]!r} is {np.degrees(off):.3g} deg off the normal of {plane}"
        return f"joint {press.joints[joint]!r} slides {np.degrees(off):.3g} deg out of {plane}"
    if (off := max(loops, default=0.0)) > PARALLEL:
        return f"the axis of loop {press.loops[loops.index(off)].name!r} is {np.degrees(off):.3g} deg off the normal of {plane}"
    if welds := [loop.name for loop in press.loops if loop.type == "fixed"]:
        return f"loop {welds[0]!r} is a weld"
    return "its equations do not fall into groups with as many unknown joints, or are singular in these"
