"""The interface of peers: the same press in other programs, beside which pinpress is measured.

All answers have the signs of `Reactions`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pinpress.accuracy.scenes import Scene
from pinpress.common.quantities import Array


@dataclass(frozen=True, eq=False)
class Answer:
    """Inverse dynamics over n crank angles.

    Attributes:
        torque: (n,) torque on the driver joint, along its axis [N m].
        force: name of a joint or loop -> (n, 3) force of parent on child (of a loop: of link1 on link2), world axes [N].
    """

    torque: Array
    force: dict[str, Array]


@dataclass(frozen=True, eq=False)
class RunEnd:
    """The last state of a run.

    Attributes:
        crank_angle: angle of the driver joint, unwrapped [rad].
        crank_speed: speed of the driver joint [rad/s].
        loop_gap: largest distance between the two sides of a bearing that the peer closes by an equation [m]; None where it has none.
        energy_error: kinetic and potential energy minus that at the start, divided by the kinetic energy at the start [-]; None where
            energy is not kept.
        force: name of a joint or loop -> (3,) force as of `Answer` [N].
        evaluations: number of evaluations of the equation of motion, where they are counted.
    """

    crank_angle: float
    crank_speed: float
    loop_gap: float | None
    energy_error: float | None
    force: dict[str, Array]
    evaluations: int | None = None


class Peer(Protocol):
    """A press made in another program.

    Attributes:
        name: name of the program, with its version.
        inverse: whether it has inverse dynamics of its own to be compared.
        cannot: what it cannot do for a linkage, in phrases between semicolons.
        steps: fixed steps worth measuring in a run of some turns at 70 strokes/min, largest first; none where it cannot run [s].
        left_out: group of a scene (other than the free run) that it cannot run -> why.
    """

    name: str
    inverse: bool
    cannot: str
    steps: tuple[float, ...]

    @property
    def left_out(self) -> Mapping[str, str]: ...

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """Inverse dynamics of a turn at constant speed, or of a part of one, with weights and without process loads.

        Args:
            angle: (n,) crank angles in equal steps [rad].
            speed: crank speed, with the sign of the steps [rad/s].

        Raises:
            PinpressError: the peer finds no answer.
        """

    def free_run(self, angle: float, speed: float, inertia: float, duration: float, step: float) -> RunEnd:
        """Let the press run without torque.

        Args:
            angle: crank angle at the start [rad].
            speed: crank speed at the start [rad/s].
            inertia: moment of inertia of a flywheel on the crank's shaft [kg m2].
            duration: duration of the run [s].
            step: step, which is shortened until the duration is a whole number of steps [s].

        Raises:
            PinpressError: the peer finds no answer, or cannot run.
        """

    def run(self, scene: Scene, step: float) -> RunEnd:
        """Let the press run through a scene that is not ``left_out``.

        Args:
            scene: the scene.
            step: step, which is shortened until the duration is a whole number of steps [s].

        Raises:
            PinpressError: the peer finds no answer, or cannot run.
        """


class ClosedFormSolver(Protocol):
    """An integrator of SciPy on a press's equation of motion in closed form, as an expert writes it for this one press.

    Attributes:
        name: name of the integrator.
        tolerances: tolerances that are worth measuring.
        left_out: group of a scene that it cannot run -> why.
    """

    @property
    def name(self) -> str: ...
    @property
    def tolerances(self) -> tuple[float, ...]: ...
    @property
    def left_out(self) -> Mapping[str, str]: ...

    def prepared(self, scene: Scene) -> Callable[[float], RunEnd]:
        """A function that finds the end of a scene to a tolerance. It raises a PinpressError where the integrator gives up."""


def load_on_slide(scene: Scene, height: float, rate: float) -> float:
    """Force of a scene's loads on the slide, upwards [N], at a height above bottom dead centre [m] that rises at a rate [m/s]."""
    force = 0.0
    for load in scene.loads:
        for interval in load.intervals(rate < 0):
            if interval.lower < height <= interval.upper:
                force += float(interval.acting(float(interval.force(height, rate))))
    return force


def steps_of(duration: float, step: float) -> int:
    """Number of equal steps, none longer than ``step``, that make up a duration."""
    return max(1, int(np.ceil(duration / step * (1 - 1e-9))))
