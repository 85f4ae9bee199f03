"""Energy that a drive gives in a period at constant speed, and the flywheel that lets an even torque do it.

Where a motor gives the mean of the driving torque all the time, the flywheel takes up what is too much and gives off what is missing. The
kinetic energy that it stores between its lowest and its highest speed is the range of the integral of driving torque less mean torque over
the crank angle. With the inertia J of all that turns evenly it is J w (w_highest - w_lowest), to the first order of the speed drop: the
driving torque is that at constant speed w, which has the inertia of the linkage in it. `steady_state` finds the speed under a real motor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.arguments import expect, positive, typed
from ..common.errors import PinpressError
from ..common.numerics import NODES, gauss_rule, polynomial_values
from ..common.quantities import Array
from ..common.results import Record
from ..kinematics.motion import is_constant, is_cycle
from .extremes import MeanStates, at_peaks, over_time, rms_of
from .panels import Panels
from .reactions import Reactions

UNITS = {
    "speed": "rad/s",
    "work": "J",
    "mean_power": "W",
    "mean_torque": "N m",
    "rms_torque": "N m",
    "largest_torque": "N m",
    "stored": "J",
    "lowest_at": "rad",
    "highest_at": "rad",
}


@dataclass(frozen=True, repr=False)
class PeriodEnergy(Record, units=UNITS):
    """What a press asks of its drive in one period at constant speed.

    Attributes:
        speed: Speed of the crank, negative backwards [rad/s].
        work: Work of the drive in the period: what loads, dampers and friction take [J].
        mean_power: Work by the duration of the period [W].
        mean_torque: Mean of the driving torque [N m].
        rms_torque: Root mean square of the driving torque: a motor without a flywheel heats by it [N m].
        largest_torque: Largest size of the driving torque [N m].
        stored: Energy that a flywheel takes up and gives off again, where the motor gives the mean torque [J].
        lowest_at: Crank angle at which the flywheel would be slowest [rad].
        highest_at: Crank angle at which it would be fastest [rad].
    """

    speed: float
    work: float
    mean_power: float
    mean_torque: float
    rms_torque: float
    largest_torque: float
    stored: float
    lowest_at: float
    highest_at: float

    @typed
    def speed_drop(self, inertia: float) -> float:
        """Highest less lowest speed divided by the mean, to first order [-].

        Args:
            inertia: Inertia of flywheel and drive at the driver joint [kg m2].

        Raises:
            PinpressError: The inertia is no positive number.
        """
        return self.stored / (positive("inertia", inertia, "kg m2") * self.speed**2)

    @typed
    def inertia(self, speed_drop: float) -> float:
        """Inertia of flywheel and drive at the driver joint that holds the drop of speed, to first order [kg m2].

        Args:
            speed_drop: Highest less lowest speed divided by the mean [-].

        Raises:
            PinpressError: The drop is no positive number.
        """
        return self.stored / (positive("speed_drop", speed_drop, "-") * self.speed**2)


@typed
def driving_energy(reactions: Reactions) -> PeriodEnergy:
    """Work of the drive, its mean power and torque, and the energy that a flywheel has to store.

    They are integrals and extremes over the period and do not depend on its states, unless a load is known in these alone.

    Args:
        reactions: Reactions to one period of a crank at constant speed, as `cycle` gives it, under loads and friction.

    Raises:
        PinpressError: The motion is not one period at constant speed, or the driver slides.
    """
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    motion = reactions.motion
    reactions._press.refuse_sliding_driver("flywheels and their energy are those of a crank; simulate runs it under a drive")
    reactions._press.refuse_several_drivers("what they give is driving_torque * crank_speed, over time")
    if not is_cycle(motion) or not is_constant(motion.crank_speed):
        raise PinpressError("the motion is not one period of a crank at constant speed: give reactions to cycle(press, speed=...)")
    found, speed = over_time(reactions), float(motion.crank_speed[0])
    torque = found.reactions.driving_torque
    mean = float(found.share @ torque)
    angle, missing = _missing(found, torque - mean, speed)
    lowest, highest = int(missing.argmax()), int(missing.argmin())
    return PeriodEnergy(
        speed=speed,
        work=mean * speed * float(found.weight.sum()),
        mean_power=mean * speed,
        mean_torque=mean,
        rms_torque=rms_of(torque, found.share),
        largest_torque=float(np.abs(at_peaks(reactions).reactions.driving_torque).max()),
        stored=float(np.ptp(missing)),
        lowest_at=float(angle[lowest]),
        highest_at=float(angle[highest]),
    )


def _missing(found: MeanStates, excess: Array, speed: float) -> tuple[Array, Array]:
    """Crank angles (m,) [rad] at which the energy that a flywheel has given off is largest or smallest, and this energy (m,) [J].

    Args:
        found: nodes of panels, or given states.
        excess: (n,) torque in them beyond the mean [N m].
        speed: of the crank [rad/s].
    """
    motion = found.reactions.motion
    if not len(found.borders):
        work = speed * found.weight * excess  # from the middle of the step before a state to the middle of the step after it
        return motion.crank_angle + 0.5 * speed * found.weight, np.cumsum(work)
    rule, half = gauss_rule(), 0.5 * speed * np.diff(found.borders)
    values = excess.reshape(-1, NODES).T
    panels = Panels(found.borders, rule.polynomial(values).T[:, None, :], None)
    before = np.append(0.0, np.cumsum(half * (rule.weights @ values)))
    passed = panels.roots(0)
    panel, _, x = panels.place(passed)
    within = before[panel] + half[panel] * polynomial_values(rule.integral(values)[:, panel], x)
    angle = motion.crank_angle[0] + speed * (np.append(found.borders, passed) - motion.time[0])
    return angle, np.append(before, within)
