"""All that the sections of a job allow, as results and as a page."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.results import Tabular
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import cycle
from ..kinematics.motion_table import read_motion
from ..loads.mounts import Frame

if TYPE_CHECKING:
    from ..foundation.mounted_press import MountedPress
    from .job import Job

MOST_STATES = 100_000  # of a period, for the vibration of the frame
SPEEDS = 61  # at which the press on its mounts is shown


def results_of(job: Job) -> Iterator[Tabular]:
    """The results of a job in the order of the page."""
    has, moving = job.sections, "motion" in job.sections
    if "capacities" in has:
        yield job.rate()
    if "motor" in has and not moving and len(job.press.drivers) == 1:
        yield job.steady_state()
    if "elastic" in has:
        yield from _on_springs(job)
    if "run" in has and not has["run"].get("steady"):
        yield job.simulate()
    if "balance" in has:
        yield job.balance()
    if job.mounted is not None:
        yield from _on_mounts(job, job.mounted)
    if "tolerances" in has:
        yield job.scatter()
        if "targets" in has["tolerances"]:
            yield job.allocate()
        if "budget" in has["tolerances"]:
            yield job.budget()
    if "servo" in has:
        yield from servo_results(job)


def servo_results(job: Job) -> Iterator[Tabular]:
    """The motor of the catalogue if there is one, the best motion, its comparison with usual motions, and a capacitor for its energy."""
    from ..servo.comparison import compare_motions  # seldom needed
    from ..servo.sizing import capacitor
    from ..servo.stroke_laws import ready_motions

    given = job.sections["servo"]
    if "motors" in given:
        yield job.choose_motor()
    best = job.best_motion()
    limits, path = given.get("limits", []), given.get("path")
    more = {} if path is None else {"path": path}
    motions = ready_motions(job.press, best.drive, list(job.loads.values()), time=best.motion.duration, limits=limits, **more)
    yield best
    yield compare_motions({f"least {given.get('minimise', 'heat')}": best.motion, **motions}, limits)
    yield capacitor(best.motion)


def _on_springs(job: Job) -> Iterator[Tabular]:
    """Compliance of the slide, and its deflection in the motion."""
    from ..elasticity.slide_under_load import slide_deflection  # seldom needed
    from ..elasticity.unit_load import compliance
    from .bearings import stiffness_of

    stiffness = stiffness_of(job.press, job.bearings, job.sections["elastic"])
    if len(job.press.drivers) == 1:  # it is over the crank angle
        yield compliance(job.press, stiffness)
    yield slide_deflection(job.press, job.motion(), stiffness, loads=list(job.loads.values()))


def _on_mounts(job: Job, system: MountedPress) -> Iterator[Tabular]:
    """Modes of the press on its mounts, and its vibration in the motion, with feet that lift off, and over the speed."""
    from ..foundation.lifting import lifting_response  # seldom needed
    from ..foundation.mounted_press import modes
    from ..foundation.response import steady_response, time_response
    from ..foundation.speed_response import over_speeds
    from ..foundation.whirl_modes import whirl

    given, motion = job.sections["foundation"], job.sections.get("motion")
    reactions = _resolved(job, system)
    points = shown_points(system) | given.get("points", {})
    period = None if motion is None else motion.get("period")
    top = float(np.abs(reactions.motion.crank_speed).max())
    low, high = given.get("speed_range", (0.0, top))
    yield system
    yield modes(system)
    if system.rotors:
        yield whirl(system, np.linspace(0.0, max(top, high), SPEEDS))
    if motion is not None and period is None:
        yield time_response(system, reactions, points=points)
    else:
        yield steady_response(system, reactions, points=points, period=period)
    if "lift_off" in given:
        yield lifting_response(system, reactions, points=points, strokes=given["lift_off"], period=period)
    if "speed_range" in given:
        yield over_speeds(system, np.linspace(low, high, SPEEDS), points=points)


def _resolved(job: Job, system: MountedPress) -> Reactions:
    """The reactions over a period with enough states for the vibration: more than the page has if a blank breaks."""
    from ..foundation.response import states_that_resolve  # seldom needed

    reactions = job.reactions()
    if "motion" in job.sections:  # its states are those of the table
        return reactions
    while len(reactions.motion.crank_angle) < (states := states_that_resolve(system, reactions)) <= MOST_STATES:
        motion = cycle(system.press, speed=float(reactions.motion.crank_speed[0]), points=states)
        reactions = inverse_dynamics(system.press, motion, list(job.loads.values()), job.friction)
    return reactions


def shown_points(system: MountedPress) -> Mapping[str, Any]:
    """Points whose vibration is shown: centres of rigid parts, or bed and carrier of a flexible frame; and machines on the frame."""
    frame, crown = system.frame, system.crown
    if not isinstance(frame, Frame):
        own: dict[str, Any] = {name: name for name in (frame.carrier, frame.bed)}
    elif crown is None:
        own = {"centre of the frame": frame.centre}
    else:
        own = {"centre of the bed": frame.centre, "centre of the crown": ("crown", crown.centre)}
    return own | {name: (name, each.body.centre) for name, each in system.attached.items()}


def traces_of(job: Job) -> list[tuple[str, Any]]:
    """Links and the points of them whose paths are drawn."""
    return [(link, point) for link, points in job.sections.get("traces", {}).items() for point in points]


def motion_of(job: Job) -> Reactions:
    """The reactions that a page of the job shows.

    They are those of the motion or at constant speed; of a job without either those of the servo drive's best motion, or of the run.
    """
    if "motion" not in job.sections and job.speed is None:
        loads = list(job.loads.values())
        if "servo" in job.sections:
            return inverse_dynamics(job.press, job.best_motion().motion.motion, loads, job.friction)
        if "run" in job.sections:
            return inverse_dynamics(job.press, job.simulate(), loads, job.friction)
    return job.reactions()  # it says what the job lacks


def write_report(
    job: Job,
    path: str | os.PathLike[str],
    *,
    results: Sequence[Tabular] | None = None,
    reactions: Reactions | None = None,
    before: Reactions | None = None,
) -> Path:
    """Write the page of a job.

    Args:
        job: the job.
        path: of the page.
        results: what it shows beside the motion; None: all that the job allows.
        reactions: to the motion that it shows; None: those of `motion_of`.
        before: those that it compares with, beside ``reactions``.
    """
    from ..visual.reports.report import report  # slow to import
    from .job import as_inputs  # it imports this module

    name, its = "", None
    if reactions is None:
        reactions = motion_of(job)
        before, name, its = before_of(job)
    results, rows = [*results_of(job)] if results is None else results, as_inputs(job)
    return report(
        reactions._press,
        reactions.motion,
        path,
        reactions=reactions,
        traces=traces_of(job),
        before=before,
        results=results,
        flywheel=job.flywheel,
        header=job.header,
        inputs=rows,
        before_name=name,
        before_inputs=[row for row in as_inputs(its) if row not in rows],
    )


def before_of(job: Job) -> tuple[Reactions | None, str, Job | None]:
    """The reactions of the variant or press with which the page compares, its name if it is a variant, and its job; None without one.

    A press whose file says nothing of its motion moves as that of the job, and without loads of its own under the job's.
    """
    section = job.source.items.get("report")
    entry = None if section is None else section.items("keys with values").get("before")
    if entry is None or entry.value == "none":
        return None, "", None
    name, variants = entry.text("a variant or press"), job.source.below.get("variants")
    if variants is not None and name in variants.items("names with values"):
        other = job.variant(name)
        return motion_of(other), f"variant {name} of {other.press.name}", other
    from .job import job as read  # it imports this module

    path = entry.folder / name
    other = read(path if path.exists() else name)
    if "motion" in other.sections or other.speed is not None:
        return motion_of(other), "", other
    if "motion" in job.sections:
        given = job.sections["motion"]
        motion = read_motion(other.press, given["file"], period=given.get("period"))
    elif job.speed is not None:
        motion = cycle(other.press, speed=job.speed, points=job._points)
    else:
        entry.refuse(f"neither the job nor {name} says how the driver moves", "write speed: 70 r/min")
    return inverse_dynamics(other.press, motion, list((other.loads or job.loads).values()), other.friction), "", other
