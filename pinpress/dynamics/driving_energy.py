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
from ..common.quantities import Array
from ..common.results import Record
from ..kinematics.motion import is_constant, is_cycle
from .extremes import MeanStates, at_peaks, over_time, rms_of
from .peaks import GAUSS
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

    They are integrals and extremes over the period, whatever states the motion has. Under loads that are known in its states alone they
    are sums over these, in which the process has its `Reactions.process_work`.

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
    mean_states, speed = over_time(reactions), float(motion.crank_speed[0])
    torque = mean_states.reactions.driving_torque
    if mean_states.reactions is reactions:
        step = float(motion.crank_angle[1] - motion.crank_angle[0])
        along = 0.0 if reactions._press.slide is None else reactions.process_force * motion.slide_velocity
        rest = torque + along / speed  # without the process, whose force may jump between two states
        works = 0.5 * (rest + np.roll(rest, -1)) * step + reactions._process_steps
        mean = float(works.mean() / step)
        angle, missing = np.append(motion.crank_angle[1:], motion.crank_angle[0]), np.cumsum(works - mean * step)
        work = float(works.sum())
    else:
        way = float(np.copysign(2 * np.pi * (motion.period_turns or 1), speed))
        mean = float(mean_states.share @ torque)
        angle, missing = _missing(mean_states, mean, way)
        work = mean * way
    lowest, highest = int(missing.argmax()), int(missing.argmin())
    return PeriodEnergy(
        speed=speed,
        work=work,
        mean_power=mean * speed,
        mean_torque=mean,
        rms_torque=rms_of(torque, mean_states.share),
        largest_torque=float(np.abs(at_peaks(reactions).reactions.driving_torque).max()),
        stored=float(np.ptp(missing)),
        lowest_at=float(angle[lowest]),
        highest_at=float(angle[highest]),
    )


def _missing(states: MeanStates, mean: float, way: float) -> tuple[Array, Array]:
    """Crank angles (m,) [rad] and the energy (m,) that the flywheel has given off until then [J]: at the steps of the integral over the
    period's ``way`` [rad], and within them wherever the torque passes its mean. In a step the torque is the cubic through Gauss's nodes.
    """
    polynomial = np.polynomial.polynomial
    nodes, _ = GAUSS
    torque, share = (values.reshape(-1, 1 + len(nodes)) for values in (states.reactions.driving_torque - mean, states.share))
    angle, half = states.reactions.motion.crank_angle[:: 1 + len(nodes)], 0.5 * way * share.sum(axis=1)
    before = np.append(0.0, np.cumsum(way * (share * torque).sum(axis=1)))[:-1]
    cubic = np.linalg.solve(polynomial.polyvander(nodes, len(nodes) - 1), torque[:, 1:].T)
    places = np.concatenate([[-1.0], nodes, [1.0]])
    values = polynomial.polyval(places, cubic)
    step, gap = np.nonzero(np.signbit(values[:, :-1]) != np.signbit(values[:, 1:]))
    at, to, low, high = places[gap], places[gap + 1], values[step, gap], values[step, gap + 1]
    passed = at + (to - at) * low / (low - high)  # an error of second order here is one of fourth order in the energy
    energy = polynomial.polyint(cubic, lbnd=-1.0)[:, step]
    within = before[step] + half[step] * polynomial.polyval(passed, energy, tensor=False)
    return np.append(angle, angle[step] + half[step] * (1 + passed)), np.append(before, within)
