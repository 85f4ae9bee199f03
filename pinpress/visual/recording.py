"""A recording: one web page that shows a press turning, with everything it needs inside the file.

The page holds Meshcat's viewer, the commands that build the scene, and its control bar. It opens by double click,
without a server or a network. World axes are in metres, with z up; a planar press stands in the x-z plane and is seen from -y.
"""

from __future__ import annotations

import base64
import math
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arguments import expect, typed
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.quantities import Array
from ..drives.transmission import Flywheel
from ..dynamics.applied_loads import turning_points
from ..dynamics.reactions import Reactions
from ..engines.branch import predict
from ..engines.structure import configuration
from ..kinematics.motion import Motion, refuse_motion_of_another, refuse_other_joints
from ..kinematics.poses import Poses, bearing_points, contact_points, point_on_body, poses
from ..linkage.linkage import Linkage, is_same_press
from ..loads.link import check_point
from ..simulation.run import Run
from .pages import meshcat, packed, page, write
from .shapes import meshcat_commands
from .shapes.appearance import ShownLink, bodies
from .shapes.bearing_layout import TOWARDS
from .shapes.stand_ins import ShaftFlywheel

if TYPE_CHECKING:
    from ..simulation.elastic.run import ElasticRun

FEWEST_PER_TURN = 36  # key frames per turn of a long motion; at 10 degrees apart a crank pin is off its circle by 0.4 %
FARTHEST = np.pi / 2  # largest crank angle between two states; straight lines connect them [rad]
MOST = 20_000  # key frames; they keep the page of a long run below 20 MB


@typed
def record(
    press: Linkage,
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    reactions: Reactions | None = None,
    traces: Sequence[tuple[str, ArrayLike]] = (),
    flywheel: Flywheel | Mapping[str, Flywheel] | None = None,
) -> Path:
    """Write a self-contained page that shows the press moving, and return its path.

    The page plays in real time, or slowed down if a period takes less than half a second. A motion over one period becomes a loop.
    Long motions are thinned to 360 key frames per turn of the crank. Equal input gives equal bytes. ``#t=0.25`` at the end of the page's
    address stops it at 0.25 s. Links of an `ElasticRun` are drawn in their elastic positions, with displacements magnified by a factor that
    the page states.

    Args:
        press: the linkage. The boxes, cylinders, spheres and meshes of its URDF's ``<visual>`` are drawn; links without visuals get shapes
            from their bearings and masses. The counterweights of `balance` are drawn on all links.
        motion: motion of the linkage, with times.
        path: path of the file, usually ending in `.html`. An old file is replaced only when the page is complete.
        reactions: reactions to this motion. Bearing and guide forces (on child and link2, at their points of action) and the shaking force
            (with its tip at the foot of the press) are drawn as arrows, with one scale of length and colour for all; the force of their
            process loads is drawn in the same way, with its tip at `Linkage.tool`.
        traces: points whose paths are drawn, each the name of a link and x, y, z in its frame [m]. The slide's path is always drawn.
        flywheel: flywheel to draw on the driver's shaft; for several drivers a mapping from driver name to flywheel. By default the
            flywheels of a run.

    Raises:
        PinpressError: the motion has no times, states more than 90 deg of the crank apart or more than 555 turns, a value is not finite,
            the reactions are of another motion or press, a shape cannot be drawn, Meshcat is not installed, or the file cannot be
            written or has the name of a picture or press.
        UnknownNameError: a trace is on a link that the linkage does not have, or a flywheel is on a driver that it does not have.
    """
    content = scene(press, motion, key_frames(press, motion), reactions, traces, shaft_flywheels(press, flywheel, [motion]))
    return write(path, page("recording.html", press.name, content, {"viewer": meshcat()}))


def scene(
    press: Linkage,
    motion: Motion,
    frames: KeyFrames,
    reactions: Reactions | None,
    traces: Sequence[tuple[str, ArrayLike]],
    flywheels: Sequence[ShaftFlywheel],
) -> dict[str, Any]:
    """Data of the page's player (`templates/playback.js`).

    Args:
        press: as for `record`.
        motion: as for `record`.
        frames: key frames of the motion.
        reactions: as for `record`.
        traces: as for `record`.
        flywheels: flywheels to draw.

    Raises:
        PinpressError: as `record`.
    """
    if reactions is not None:
        _refuse_other_reactions(press, motion, reactions)
    at = poses(press, motion.joint_position[frames.states])
    magnified = {}
    if isinstance(motion, Run) and motion.stats.method == "elastic":  # its class would import its solvers
        from .deflected import displaced, magnification  # imports the equations of springs, which other pages do not need

        moved = cast("ElasticRun", motion).displacement[frames.states]
        magnified = {"magnified": magnification(press, moved)}
        at = displaced(press, at, magnified["magnified"] * moved)
    drawn = bodies(press, motion.joint_position[frames.states], flywheels=flywheels)
    flat = f"data:image/svg+xml;base64,{base64.b64encode(press.drawing.encode()).decode()}"  # for browsers without WebGL
    return moving(press, motion, frames, at, reactions, traces) | shapes(press, frames, at, drawn) | magnified | {"drawing": flat}


def shaft_flywheels(press: Linkage, given: Flywheel | Mapping[str, Flywheel] | None, results: Sequence[object]) -> list[ShaftFlywheel]:
    """The flywheels that are drawn.

    Args:
        press: the linkage.
        given: flywheel on the driver's shaft, or driver name -> flywheel; None: those of the first run that has flywheels.
        results: the motion, and the other results of the page.

    Raises:
        PinpressError: there are several drivers and the flywheel does not name one, or its driver slides.
        UnknownNameError: there is no such driver.
    """
    coupled = True
    by_driver: Mapping[str, Flywheel] = {}
    if given is None:
        for run in (result for result in results if isinstance(result, Run)):
            driven = run.problem.driven
            if not by_driver and driven.press.drivers == press.drivers:
                by_driver = driven.flywheels if driven.flywheel is None else {press.driver: driven.flywheel}
                coupled = driven.clutch is None
    elif isinstance(given, Flywheel):
        if len(press.drivers) > 1:
            raise PinpressError(f"{press.name} has {len(press.drivers)} drivers: give flywheel as {{driver: Flywheel}}")
        by_driver = {press.driver: given}
    else:
        by_driver = given
    for name, flywheel in by_driver.items():
        if name not in press.drivers:
            raise UnknownNameError("driver", name, press.drivers)
        if not isinstance(flywheel, Flywheel):
            raise PinpressError(f"flywheel of {shown(name)} is {shown(flywheel)}: give a Flywheel(...)")
        if not press.driver_coordinates[press.drivers.index(name)].turns:
            raise PinpressError(f"driver {name!r} of {press.name} slides, and has no shaft for a flywheel: leave it out")
    largest = {name: float(np.max(flywheel.inertia)) for name, flywheel in by_driver.items()}
    return [ShaftFlywheel(name, inertia, coupled) for name, inertia in largest.items() if inertia > 0]


def moving(
    press: Linkage, motion: Motion, frames: KeyFrames, at: Poses, reactions: Reactions | None, traces: Sequence[tuple[str, ArrayLike]]
) -> dict[str, Any]:
    """The part of `scene` that is drawn over the links: places, forces and paths; ``at``: poses of the bodies in the key frames."""
    touching = contact_points(press, at, motion.joint_position[frames.states])
    names = [*press.bearings, *touching]
    points = np.array([*bearing_points(press, at), *touching.values()])
    where, places = _together(points, 1e-6 * press.size)
    forces: dict[str, Any] = dict.fromkeys(("shaking", "process"))
    peak = 0.0
    if reactions is not None:
        shaking, along = reactions.shaking_force[frames.states], reactions.process_force[frames.states, None]
        largest = (np.linalg.norm(force[frames.states], axis=1).max() for force in reactions.bearing_force.values())
        peak = float(max(*largest, np.linalg.norm(shaking, axis=1).max(), np.abs(along).max()))
        forces["shaking"] = packed(shaking, "shaking_force")
        if along.any():
            place = at.points(press.slide_guide.joint + 1, press.tool.in_body)
            forces["process"] = {
                "place": _packed_path(place, "the place of the process force"),
                "force": packed(along * press.slide_direction, "process_force"),
            }
    return {
        "time": _short(frames.time),  # s
        "crank": _short(frames.shown),  # deg or mm
        "height": None if frames.height is None else _short(frames.height),  # m
        "above": "above BDC" if frames.above_bottom else "above lowest",
        "turn": frames.turn,
        "driver": _driver(motion),
        "period": None if motion.period_turns is None else 360 * motion.period_turns,  # deg
        "size": press.size,
        "places": [_packed_path(points[first], "the place of a bearing") for first in places],
        "bearings": [
            {
                "name": name,
                "place": place,
                "force": None
                if reactions is None
                else packed(reactions.bearing_force[name][frames.states], f"bearing_force[{shown(name)}]"),
            }
            for name, place in zip(names, where, strict=True)
        ],
        **forces,
        "peak": peak,  # largest of all shown forces [N]
        "traces": [
            {"name": name, "link": link, "path": packed(at.points(joint, point), f"the path of {name}"), "keys": frames.turn}
            for name, link, joint, point in traced(press, traces)
        ],
    }


def shapes(press: Linkage, frames: KeyFrames, at: Poses, drawn: Sequence[ShownLink], *, animated: bool = True) -> dict[str, Any]:
    """The part of `scene` that shows the links ``drawn``; ``animated``: whether it contains their motion."""
    paths = meshcat_commands.body_poses(press, at, [body.frame for body in drawn])
    of_body = {body.name: path for body, path in zip(drawn, paths, strict=True)}
    commands = meshcat_commands.commands(drawn, of_body, frames.time)
    return {
        "legend": _legend(drawn, of_body),
        "front": _front(press, at, drawn),
        "scene": meshcat_commands.pack(each for each in commands if animated or each["type"] != "set_animation"),
    }


def traced(press: Linkage, chosen: Sequence[tuple[str, ArrayLike]]) -> list[tuple[str, str, int, Array]]:
    """The points whose paths are drawn: the slide's origin, if there is a slide, and the chosen points.

    Args:
        press: the linkage.
        chosen: points, each the name of a link and x, y, z in its frame [m].

    Returns:
        For each path its name, its link, the joint in whose frame the point is fixed, and the point (3,) in this frame [m].

    Raises:
        PinpressError: a link is unknown, or a point is not three finite numbers.
    """
    points = []
    if press.slide is not None:
        points.append((press.slide, press.slide, *point_on_body(press, press.slide, (0, 0, 0), "slide", "origin")))
    if not isinstance(chosen, list | tuple) or not all(isinstance(trace, list | tuple) and len(trace) == 2 for trace in chosen):
        raise PinpressError(f"traces is {shown(chosen)}: give a list of a link and a point in its frame, e.g. [('coupler', (0.6, 0, 0))]")
    for link, point in chosen:
        what = f"trace of {shown(link)}"
        place = point_on_body(press, link, check_point(f"{what}: point", point), what, "point")
        words = ", ".join(f"{value:g}" for value in np.asarray(point, dtype=float))
        points.append((f"{link} ({words})", link, *place))
    return points


@dataclass(frozen=True, eq=False)
class KeyFrames:
    """Key frames: the k states of a motion that a recording shows.

    Attributes:
        states: (k,) indices of states of the motion.
        time: (k,) times, 0 at the first [s].
        crank: (k,) angles of the (first) driver [rad], or its positions if it slides [m].
        shown: (k,) the values of ``crank`` as the page shows them [deg or mm].
        height: (k,) heights of the slide above bottom dead centre, or above the lowest state if there is none [m]; None without a slide.
        above_bottom: whether heights are above bottom dead centre.
        turn: number of key frames of one period, after which the linkage repeats its path; all key frames if it does not repeat.
    """

    states: NDArray[np.intp]
    time: Array
    crank: Array
    shown: Array
    height: Array | None
    above_bottom: bool
    turn: int


def key_frames(press: Linkage, motion: Motion) -> KeyFrames:
    """Choose key frames. A motion of one period becomes a loop; a long motion is thinned to 360 frames per turn of the crank.

    Raises:
        PinpressError: the motion is of a linkage with other joints or lengths, has no times, states too far apart or too many turns for a
            page, or a value is not finite.
    """
    expect("press", press, Linkage, "load")
    expect("motion", motion, Motion, "cycle or simulate")
    refuse_other_joints(press, motion)
    _refuse_broken(motion, press.slide is not None)
    refuse_motion_of_another(press, motion)
    time = motion.time - motion.time[0]
    crank = np.asarray(motion.crank_angle).reshape(len(time), -1)[:, 0]  # the first of several drivers
    period, first = _period(press, motion), motion.driver_coordinates[0]
    steps, turned = np.abs(np.diff(crank)), abs(crank[-1] - crank[0])
    order, last = np.arange(len(time)), None
    if period is not None and len(time) > 2 and 1e-6 * steps.max() < period - turned <= 1.001 * steps.max():  # a period without its end
        last, end = time[-1] * period / turned, crank[0] + np.sign(crank[-1] - crank[0]) * period
    elif (last := _time_back(press, motion, time)) is not None:
        end = crank[0] + (2 * np.pi * np.rint((crank[-1] - crank[0]) / (2 * np.pi)) if first.turns else 0.0)
    if last is not None:  # the first state is repeated at the end, so that the loop has no jump
        order, time, crank = np.append(order, 0), np.append(time, last), np.append(crank, end)
        steps = np.abs(np.diff(crank))
    turns = float(steps.sum() / (2 * np.pi if first.turns else 2 * np.ptp(crank) or 1.0))  # a sliding driver goes there and back in a turn
    if turns * FEWEST_PER_TURN > MOST:
        raise PinpressError(
            f"{turns:.0f} turns are more than a recording holds ({MOST // FEWEST_PER_TURN}): record a shorter part of the motion"
        )
    if first.turns and steps.max(initial=0.0) > FARTHEST:
        raise PinpressError(
            f"the crank turns {np.degrees(steps.max()):.0f} deg from one state to the next, too far to show the motion in between:"
            f" give a state every {np.degrees(FARTHEST):.0f} deg at least"
        )
    most = min(360 * max(1, np.ceil(turns - 1e-6)), MOST) + 1
    kept = np.rint(np.linspace(0, len(order) - 1, int(min(len(order), most)))).astype(int)  # including the first and the last
    order, crank = order[kept], crank[kept]
    height, above_bottom = None, False
    if press.slide is not None:
        bottom = turning_points(press)[0]
        above_bottom = math.isfinite(bottom)
        height = motion.slide_position[order] - (bottom if above_bottom else motion.slide_position.min())
    beyond = np.flatnonzero(np.abs(crank - crank[0]) >= (period or np.inf) * (1 - 1e-9))
    turn = int(beyond[0]) + 1 if len(beyond) else len(order)
    return KeyFrames(order, time[kept], crank, first.scale * crank, height, above_bottom, turn)


def _refuse_broken(motion: Motion, has_slide: bool) -> None:
    series = {"time": motion.time, "crank_angle": motion.crank_angle, "joint_position": motion.joint_position}
    if has_slide:
        series["slide_position"] = motion.slide_position
    for name, values in series.items():
        bad = ~np.isfinite(values)
        if np.size(values) == 0 or bad.any():
            where = f"is not finite at index {int(np.argwhere(bad)[0][0])}" if bad.any() else "is empty"
            raise PinpressError(f"motion.{name} {where}; record a motion that cycle or simulate returned")
    if np.any(np.diff(motion.time) <= 0):
        raise PinpressError("motion.time does not increase from point to point; order the points of the motion by time")


def _period(press: Linkage, motion: Motion) -> float | None:
    """Crank angle of the motion's period [rad]; None if a body, e.g. a balance shaft, does not return to its initial pose."""
    if motion.period_turns is None:
        return None
    period = 2 * np.pi * motion.period_turns
    before, after = configuration(press.slots, predict(press.branch_through_change_points, np.array([0.0, period]))).T
    return period if np.allclose(before, after, rtol=0.0, atol=1e-9 * (1 + press.size)) else None


def _driver(motion: Motion) -> dict[str, str]:
    """Label of the (first) driver, with the dead centre at its zero by initials, and the unit of its coordinate; with several drivers the
    label is the driver's name."""
    coordinate = motion.driver_coordinates[0]
    zero = "".join(word[0] for word in coordinate.zero.split()).upper() if coordinate.zero.endswith("dead centre") else coordinate.zero
    part = coordinate.part if len(motion.drivers) == 1 else motion.drivers[0]
    return {"name": f"{part} from {zero}" if zero else part, "unit": "°" if coordinate.turns else " mm"}


def _time_back(press: Linkage, motion: Motion, time: Array) -> float | None:
    """Time at which the first state repeats [s]: one step after the last state, if all joints return then (rotating joints after whole
    turns); otherwise None."""
    x, v, a = motion.joint_position, motion.v, motion.a
    if len(time) < 3 or not motion.crank_speed.any():
        return None
    step = float(time[-1] - time[-2])
    short, slow = x[0] - x[-1] - 0.5 * step * (v[0] + v[-1]), v[0] - v[-1] - 0.5 * step * (a[0] + a[-1])
    turning = press.structure.turns
    short = np.where(turning, (short + np.pi) % (2 * np.pi) - np.pi, short)
    back = all(
        np.all(np.abs(missed[kind]) <= 0.01 * np.max(size[kind], initial=0.0))
        for missed, size in ((short, np.ptp(x, axis=0)), (slow, np.abs(v).max(axis=0)))
        for kind in (turning, ~turning)
    )
    return float(time[-1]) + step if back else None


def _refuse_other_reactions(press: Linkage, motion: Motion, reactions: Reactions) -> None:
    """Refuse reactions that do not belong to this motion of the press.

    Raises:
        PinpressError: they are of another press or motion.
    """
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    other, its = reactions.motion, reactions._press
    same = other is motion or (
        other.joints == motion.joints and np.array_equal(other.joint_position, motion.joint_position) and np.array_equal(other.v, motion.v)
    )
    if not same:
        raise PinpressError(
            f"the reactions are of another motion of {other.linkage}: give those that inverse_dynamics(press, motion) returns for this one"
        )
    if not is_same_press(its, press):
        raise PinpressError(f"the reactions are of {its.name}, another press than {press.name}: give reactions of the same press")


def _short(values: Array) -> list[float]:
    """Numbers rounded to nine digits, which suffice for a page and take half the characters."""
    return [float(f"{value:.9g}") for value in values.tolist()]


def _legend(drawn: Sequence[ShownLink], of_body: dict[str, Array]) -> list[dict[str, str]]:
    """The moving links, each with the colour of most of its parts; the first part of a made-up link has the link's colour."""
    moving = [body for body in drawn if meshcat_commands.moves(of_body[body.name])]
    parts = [body.parts if body.drawn else body.parts[:1] for body in moving]
    colours = (Counter(meshcat_commands.hexadecimal(part.rgba) for part in its).most_common(1)[0][0] for its in parts)
    return [{"name": body.name, "colour": f"#{colour}"} for body, colour in zip(moving, colours, strict=True)]


def _front(press: Linkage, at: Poses, drawn: Sequence[ShownLink]) -> list[float]:
    """Direction (3,) from which a press is viewed; [] for a press in space.

    It is the normal of the press's plane, on the side where moving links are in front of the frame; if there is no such side, the side of
    -y. It never points down.
    """
    directions = [(axis.turns, at.rotation[j, 0] @ axis.direction) for j, axis in enumerate(press.axes, 1)]
    turning, sliding = ([direction for turns, direction in directions if turns == kind] for kind in (True, False))
    if not turning or any(np.linalg.norm(np.cross(turning[0], axis)) > 1e-6 for axis in turning):
        return []
    if any(abs(turning[0] @ way) > 1e-6 for way in sliding):  # as of a screw
        return []
    normal = turning[0] * (1.0 if turning[0] @ TOWARDS > 0 else -1.0)
    heights: dict[bool, list[float]] = {True: [], False: []}  # of parts of the frame, of moving links, along the normal
    for body in (each for each in drawn if each.name in press.links):  # a flywheel is behind everything
        frame = press.model.frames[body.frame]
        places = [at.points(frame.parentJoint, frame.placement.act(part.placement[:3, 3]))[0] for part in body.parts]
        heights[frame.parentJoint == 0] += [float(place @ normal) for place in places]
    if all(heights.values()) and np.mean(heights[True]) > np.mean(heights[False]) + 0.01 * press.size and normal[2] < 0.5:
        normal = -normal
    return [float(value) for value in normal]


def _together(points: Array, near: float) -> tuple[list[int], list[int]]:
    """The place of each bearing, and the first bearing of each place, from points (bearings, k, 3): bearings that stay as close as
    ``near`` share a place."""
    where: list[int] = []
    places: list[int] = []
    for number, path in enumerate(points):
        starts_near = np.flatnonzero(np.abs(points[places, 0] - path[0]).max(axis=1) <= near)
        place = next((k for k in starts_near.tolist() if np.abs(points[places[k]] - path).max() <= near), len(places))
        if place == len(places):
            places.append(number)
        where.append(place)
    return where, places


def _packed_path(path: Array, what: str) -> str:
    return packed(path[:1] if np.ptp(path, axis=0).max() == 0.0 else path, what)  # one point if it does not move
