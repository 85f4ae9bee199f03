"""Where the slide turns back."""

from dataclasses import dataclass

import numpy as np

from .coordinates import Array
from .errors import PinpressError
from .linkage import Linkage
from .motion import carried

SAMPLES = 720  # per turn; two dead centres closer than half a degree would be taken for none


@dataclass(frozen=True)
class DeadCentres:
    """Outermost turning points of the slide along its guide's axis over one turn.

    Attributes:
        top_angle, bottom_angle: of the driver joint, 0 to 2 pi [rad]. top: the far end along the axis, upwards in an upright press.
        top_position, bottom_position: of the slide [m].
    """

    top_angle: float
    top_position: float
    bottom_angle: float
    bottom_position: float

    @property
    def stroke(self) -> float:
        """Distance between the dead centres [m]."""
        return self.top_position - self.bottom_position


def dead_centres(press: Linkage) -> DeadCentres:
    """Dead centres of a press whose crank turns fully, to rounding: zeros of the slide's speed, bisected once and kept with the press.

    Raises:
        PinpressError: the linkage has no slide, or its slide never turns back.
        SingularityError: the linkage locks within the turn.
    """
    return press.dead_centres


def found(press: Linkage) -> DeadCentres:
    """The same, worked out."""
    _ = press.slide_guide  # it has a slide
    turns = press.passage.period or 2 * np.pi

    def slide(angle: Array) -> tuple[Array, Array]:
        motion = carried(press, angle, 1.0)
        return motion.slide_position, motion.slide_velocity

    # A press is often drawn at a dead centre: a grid that starts off the drawn pose has no sample on it.
    samples = np.linspace(0.0, turns, round(SAMPLES * turns / (2 * np.pi)) + 1) - 0.38 * np.pi / SAMPLES
    speeds = slide(samples)[1]
    turning = np.flatnonzero(np.signbit(speeds[:-1]) != np.signbit(speeds[1:]))
    if len(turning) < 2:
        raise PinpressError(f"the slide of {press.name} does not turn back within a turn of the driver: it has no dead centres")
    low, high = samples[turning], samples[turning + 1]
    before = np.signbit(speeds[turning])
    for _ in range(60):  # halves half a degree down to rounding
        middle = 0.5 * (low + high)
        same = np.signbit(slide(middle)[1]) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    angles = 0.5 * (low + high)
    positions = slide(angles)[0]
    angles = np.where(np.abs(angles) < 1e-12, 0.0, angles % (2 * np.pi))  # not 360 degrees for one drawn there
    top, bottom = int(positions.argmax()), int(positions.argmin())
    return DeadCentres(float(angles[top]), float(positions[top]), float(angles[bottom]), float(positions[bottom]))
