"""Scenes of `compare`: runs of a press, made for any press from a speed, a flywheel and a duration.

A free run is smooth and easy for every method. A press at work is not: a clutch slips and grips, a blank breaks, the slide meets a die, and
a drive holds its speed so hard that it forgets a disturbance within microseconds.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import RPM, Values
from ..drives.motors import InductionMotor
from ..drives.protocol import Drive, SpeedTorqueDrive
from ..drives.transmission import Clutch, Flywheel, Geared, SwitchPoint
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage
from ..loads.process import Blanking, ElasticDie, ProcessLoad
from ..simulation.reduced_model import COORDINATES, reduced_model_of

FREE_RUN, CLUTCH, DIE, SPEED_LAW = SCENES = ("free run", "clutch and blanking", "elastic die", "stiff speed law")
RATED = 1485 * RPM  # speed of the motor [rad/s]
PERIODS = 2.0  # turns in which the motor at its rated power gives the flywheel's energy
BLANKED = 0.2  # share of the flywheel's energy that the blank takes
HEIGHTS = (0.03, 0.01)  # heights above bottom dead centre between which the blank is cut [strokes]
RISE = 0.1  # time in which the clutch builds up its torque [turns]
STRONGER = 2.0  # torque of the clutch, divided by the largest of the blank [-]
DIE_STIFFNESS = 1e10  # [N/m]
COMPRESSED = 0.02  # share of the flywheel's energy that the die takes up and gives back
FORGETS = 1e-6  # approximate time constant of the stiff speed law [turns]
SLOWER = 0.99  # initial speed under the stiff speed law, divided by the speed that it holds [-]


@dataclass(frozen=True)
class SpeedLaw(SpeedTorqueDrive):
    """A drive without inertia that holds a speed by a torque in proportion to the difference.

    Attributes:
        gain: torque by difference of speed [N m s/rad].
        speed: speed that it holds [rad/s].
    """

    gain: float
    speed: float

    @property
    def inertia(self) -> Values:
        return 0.0

    @property
    def rated_torque(self) -> Values | None:
        return None

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return self.gain * (self.speed - speed)


@dataclass(frozen=True, eq=False)
class Scene:
    """A run that all methods of simulation compute.

    Attributes:
        group: one of `SCENES`.
        words: the scene in words.
        turn: approximate duration of a turn [s].
        duration: duration of the run [s].
        angle: crank angle at the start [rad].
        speed: crank speed at the start [rad/s].
        flywheel: flywheel on the crank, or before the clutch.
        drive: drive of the crank; None if there is none.
        clutch: clutch between flywheel and crank; None if they turn together.
        loads: process loads.
        certifying: the two methods of simulation that make the reference.
    """

    group: str
    words: str
    turn: float
    duration: float
    angle: float
    speed: float
    flywheel: Flywheel
    drive: Drive | None = None
    clutch: Clutch | None = None
    loads: Sequence[ProcessLoad] = ()
    certifying: tuple[str, str] = ("constraint", "implicit")

    @property
    def inertia(self) -> float:
        """Moment of inertia of flywheel and drive on the crank's shaft [kg m2]."""
        return float(self.flywheel.inertia) + (0.0 if self.drive is None else float(self.drive.inertia))


def free_run(speed: float, flywheel: float, duration: float) -> Scene:
    """A run without torque, with weights, from crank angle 0."""
    words = f"from {speed / RPM:g} r/min with a flywheel of {flywheel:.4g} kg m2, {duration:.4g} s"
    return Scene(FREE_RUN, words, 2 * math.pi / abs(speed), duration, 0.0, speed, Flywheel(flywheel), certifying=("constraint", "reduced"))


def build_scene(press: Linkage, group: str, speed: float, flywheel: float, duration: float) -> Scene:
    """The scene of a group.

    Raises:
        PinpressError: the press has no slide, or a slide without dead centres, and so no such scene.
    """
    if group == FREE_RUN:
        return free_run(speed, flywheel, duration)
    wheel, turn, energy = Flywheel(flywheel), 2 * math.pi / abs(speed), 0.5 * flywheel * speed**2
    if group == SPEED_LAW:
        gain = 10.0 ** round(math.log10(flywheel / (FORGETS * turn)))
        words = f"torque {gain:.0e} N m s/rad times what the crank lags behind {speed / RPM:g} r/min, from {1 - SLOWER:.0%} below"
        return Scene(group, words, turn, duration, 0.0, SLOWER * speed, wheel, SpeedLaw(gain, speed))
    motor = Geared(InductionMotor(rated_power=energy / (PERIODS * turn), rated_speed=RATED), ratio=RATED / speed)
    driven = f"a motor of {energy / (PERIODS * turn) / 1e3:.3g} kW"
    ends = dead_centres(press)
    if group == DIE:
        height = math.sqrt(2 * COMPRESSED * energy / DIE_STIFFNESS)
        words = f"{driven} and a die of {DIE_STIFFNESS:.0e} N/m, {1e3 * height:.3g} mm above bottom dead centre"
        return Scene(group, words, turn, duration, 0.0, speed, wheel, motor, loads=(ElasticDie(height, DIE_STIFFNESS),))
    assert group == CLUTCH
    blank = build_blank(press, speed, flywheel)
    torque = STRONGER * float(blank.force) * _lever(press, blank.start)
    words = (
        f"{driven}; a clutch of {torque / 1e3:.3g} kN m starts the press at top dead centre; it blanks with"
        f" {blank.force / 1e3:.3g} kN from {1e3 * blank.start:.3g} to {1e3 * blank.end:.3g} mm"
    )
    turning = Flywheel(flywheel, speed=speed)
    clutch = Clutch(torque, closes=SwitchPoint(time=0.0), rise=RISE * turn)
    return Scene(group, words, turn, duration, float(ends.top_angle), 0.0, turning, motor, clutch, (blank,))


def build_blank(press: Linkage, speed: float, flywheel: float) -> Blanking:
    """A blank that takes a share of a flywheel's energy.

    Raises:
        PinpressError: the press has no slide, or a slide without dead centres.
    """
    stroke = dead_centres(press).stroke
    start, end = (height * stroke for height in HEIGHTS)
    energy = 0.5 * flywheel * speed**2
    return Blanking(BLANKED * energy * 0.5 * math.pi / (start - end), start, end)


def _lever(press: Linkage, height: float) -> float:
    """Largest slide travel by crank angle below a height above bottom dead centre [m]."""
    table, bottom = reduced_model_of(press), dead_centres(press).bottom_position
    angles = np.linspace(table.borders[0], table.borders[-1], 721)
    values, slopes = table.at(angles)
    below = values[COORDINATES] - bottom <= height
    if not below.any():
        raise PinpressError(f"the slide of {press.name} is never below {height:g} m above bottom dead centre")
    return float(np.abs(slopes[COORDINATES][below]).max())
