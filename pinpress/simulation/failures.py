"""Why a simulation cannot go on, or has no answer: all reasons, with what to do."""

from collections.abc import Iterator
from contextlib import contextmanager

from ..common.errors import SimulationError
from ..linkage.linkage import Linkage

REASONS = {
    "stalls": "the press stalls: it comes to rest, and the load holds it there against the drive",
    "too weak": "the press does not get through a stroke: the drive is too weak for the load",
    "no inertia": (
        "the inertia of linkage, flywheel and drive at the crank is {inertia:.6g} kg m2, so no torque determines the motion;"
        " give masses or a flywheel"
    ),
    "runs against a lock": (
        "the linkage locks: its crank turns only from {low} to {high}, and runs against that: simulate a shorter time, or with"
        " method='constraint', which follows all joints on through the lock"
    ),
    "runs against an end": (
        "the driver slides only from {low} to {high}, where its limits are or the linkage locks, and runs against that: simulate a shorter"
        " time, or give a drive that stops it before"
    ),
    "stops at a lock": "the crank stops where the linkage locks, and the links go on: a brake cannot hold it",
    "friction locks": (
        "friction locks the linkage, or nearly so: no consistent bearing forces and acceleration are found; lower the coefficients of"
        " friction"
    ),
    "loops open": "the loops do not close any more ({error}): the linkage locks, or the step is too long",
    "not finite": "a torque or force is not finite here, or the linkage locks: look at drive and loads",
    "cannot go on": "the integration cannot go on ({message}): the linkage locks ahead, or a force is too stiff",
    "chatters": "forces switch back and forth without end: it comes to rest where they hold it",
    "vibrates": (
        "a stiff force makes the press vibrate at {frequency:.3g} Hz, {swings:.2g} times until the end, and each swing would be followed:"
        " give the force a damper, or simulate a shorter time or with a larger tolerance"
    ),
    "too slow": (
        "at this pace the run would take too long: the linkage locks ahead, or a torque or force is too stiff for this method, or jumps to"
        " and fro; use method='auto', give the force a slope, or simulate in parts"
    ),
    "too many steps": "more than {most} steps: simulate in parts, or with a larger tolerance or step",
    "too many periods": "more than {most} periods of the press: simulate in parts",
    "too many turns": "at this speed the crank makes more than {most} turns: simulate in parts",
    "unbalanced": (
        "the energy does not balance: a torque or force changes too sharply for this tolerance; name the speeds at which the drive's torque"
        " is not smooth in its corners, or give a smaller tolerance"
    ),
    "does not come back": (
        "a slide of {press_name} does not come back after a turn, and inertia, forces or lengths change with it: simulate it with"
        " method='constraint'"
    ),
    "jumps": (
        "the crank is {travel:.4g} rad farther than in the state before, in {span:.4g} s, though it turns at {fastest:.4g} rad/s at most:"
        " this run is wrong; simulate it with method='implicit'"
    ),
    "no steady state": (
        "no steady state is found near {speed:g} rad/s ({turns:g} r/min): the drive is too weak for the loads, or gives as much or more at"
        " every speed there (a constant torque has none); try another speed, or let the press run with simulate"
    ),
    "other way": (
        "the motor turns the other way: without load the {motor} turns the driver at {idle}, so that it has no steady state near {speed};"
        " for that direction write {remedy}"
    ),
    "does not repeat": (
        "the press on its springs does not repeat its stroke: the lowest positions of its slide in {strokes} strokes are {depths} mm; let"
        " it run with simulate, or look at stiffness, damping and load"
    ),
    "unstable stroke": (
        "the stroke that repeats itself is unstable: a disturbance of the links grows by {decay:.3g} in each, so that the press does not"
        " come to it; give it more damping, or let it run with simulate"
    ),
    "crank rests": (
        "the crank comes to rest: on its springs a press is followed while its crank turns one way; give it more speed, a larger flywheel"
        " or a stronger drive, or leave elastic out"
    ),
    "no period": (
        "a shaft of {press_name} comes back only after more than {most} turns, so that there is no period to tabulate:"
        " use method='constraint', or another gear ratio"
    ),
}


def failure(reason: str, time: float | None = None, crank_angle: float | None = None, **details: object) -> SimulationError:
    """The error of one of the `REASONS`.

    Args:
        reason: a key of the table.
        time: of the failure [s]; None if it belongs to no instant.
        crank_angle: at the failure [rad]; None if it belongs to none.
        details: values for the gaps in the sentence.
    """
    return SimulationError(REASONS[reason].format(**details), time, crank_angle, reason)


@contextmanager
def name_driver_in_errors(press: Linkage) -> Iterator[None]:
    """A context whose failures say where the driver of this press is in its own unit."""
    try:
        yield
    except SimulationError as error:
        error.coordinate = press.driver_coordinates[0]
        raise
