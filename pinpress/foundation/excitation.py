"""What shakes the frame: shaking force and moment of the machine, less its weight, and the moment of a flywheel that changes its speed."""

from __future__ import annotations

import numpy as np

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.errors import PinpressError, expect, shown
from ..drives.transmission import Flywheel
from ..dynamics.harmonics import is_cycle
from ..dynamics.inverse_dynamics import Reactions
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..simulation.run import Run
from .mounted_press import MountedPress

EVEN = 1e-9  # difference of steps of time, or of the crank's speed, beside themselves that is none
SAME_SPEED = 1e-6  # of the crank at both ends of a period, and of flywheel and crank


def forcing(system: MountedPress, reactions: Reactions, flywheel: Flywheel | None) -> Array:
    """Wrenches (states, n) about the world origin on the parts of the frame, beside the weight at its mean place [N, N m].

    Of a frame in two parts the loads on the frame act on the bed, all else on the crown. The torque of a motor on the frame is no load: its
    casing turns back on the frame what its rotor gives the crank. The flywheel is not in the URDF: by J w' of its own the frame must turn
    the other way. ``flywheel.inertia`` is its angular momentum about the crank's axis by the crank's speed: that of one on a shaft beside
    is its inertia times the ratio of its speed, negative where that turns the other way.

    Raises:
        PinpressError: reactions of another press, a flywheel in scenarios, on a driver that is not on the frame, or behind a
            slipping clutch.
    """
    expect("system", system, MountedPress, "mounted")
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    press = system.press
    if reactions._press is not press:
        raise PinpressError(
            f"the reactions are of {reactions._press.name}, loaded apart from the press on its mounts: use one Linkage for both"
        )
    shaking = np.hstack([reactions.shaking_force, reactions.shaking_moment])
    wrench = np.zeros((len(shaking), 6 * system.parts))
    wrench[:, -6:] = shaking - system.press_weight
    if flywheel is not None:
        wrench[:, -3:] += flywheel_moment(press, reactions.motion, flywheel)
    if system.parts == 2:
        for load in reactions._under.loads:
            if load.joint == 0:
                on_bed = np.hstack([load.force, np.cross(load.point, load.force)])
                wrench[:, :6] += on_bed
                wrench[:, 6:] -= on_bed
    return wrench


@typed
def flywheel_moment(press: Linkage, motion: Motion, flywheel: Flywheel) -> Array:
    """Moment of a flywheel on the frame, -J w' about the crank's axis.

    Args:
        press: the press, whose driver joint is on the frame.
        motion: of this press.
        flywheel: on the crank's shaft, see `steady_response`.

    Returns:
        (states, 3) in world axes [N m].

    Raises:
        PinpressError: a flywheel with the inertias of several scenarios, on a driver that is not on the frame, or behind a clutch that
            slips.
    """
    if np.ndim(flywheel.inertia):
        raise PinpressError("flywheel has the inertias of several scenarios: give one")
    driver = press.driver_indices[0]
    if press.model.parents[driver + 1] != 0:
        raise PinpressError(
            f"the driver joint {shown(press.driver)} is not on the frame: the moment of its flywheel has no fixed axis there"
        )
    if isinstance(motion, Run):
        difference = np.abs(motion.drive_speed - motion.crank_speed).max()
        if difference > SAME_SPEED * np.abs(motion.crank_speed).max():
            raise PinpressError(
                f"flywheel and crank differ in speed by up to {difference:.4g} rad/s, as a clutch slips: give a run, or the part of one,"
                " in which it holds"
            )
    axis = press.model.jointPlacements[driver + 1].rotation @ press.axes[driver].direction
    return np.asarray(-float(flywheel.inertia) * motion.crank_acceleration[:, None] * axis)


def period(motion: Motion) -> tuple[float, int]:
    """Period [s] of a periodic motion, and its states, equal intervals of time apart, the end left out.

    Raises:
        PinpressError: neither one period at constant speed nor one of a steady state.
    """
    states, speed = len(motion.crank_angle), motion.crank_speed
    angle = 2 * np.pi * (motion.period_turns or 1)
    if is_cycle(motion):
        if np.ptp(speed) <= EVEN * np.abs(speed).max() and not motion.crank_acceleration.any():
            return angle / abs(float(speed[0])), states
    elif isinstance(motion, Run):
        turned = abs(motion.crank_angle[-1] - motion.crank_angle[0])
        if (
            turned > 0.5 * angle
            and abs(turned - angle * round(turned / angle)) < SAME_SPEED
            and abs(speed[-1] - speed[0]) <= SAME_SPEED * abs(speed[0])
        ):
            return float(motion.time[-1] - motion.time[0]), states - 1
    raise PinpressError(
        "the motion is no period: give one at constant speed (cycle without angle=) or one period of steady_state, or use time_response"
    )


def step(motion: Motion) -> float:
    """Interval of time between the states of a motion [s].

    Raises:
        PinpressError: fewer than two states, or states that are not equal intervals apart.
    """
    steps = np.diff(motion.time)
    if not len(steps) or steps.min() <= 0 or np.ptp(steps) > 1e-6 * steps.mean():
        raise PinpressError("the states are not at equal intervals of time: give a run of simulate, or a motion with time= in equal steps")
    return float((motion.time[-1] - motion.time[0]) / len(steps))
