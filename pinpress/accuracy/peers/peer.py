"""What peers answer and what is asked of them: the same press in other programs, beside which pinpress is measured.

All answers have the signs of `Reactions`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...common.quantities import Array
from ..scenes import Scene


@dataclass(frozen=True, eq=False)
class Answer:
    """Inverse dynamics over n crank angles.

    Attributes:
        torque: (n,) on the driver joint, along its axis [N m].
        force: name of a joint or loop -> (n, 3), action of parent on child (of a loop: of link1 on link2), world axes [N].
    """

    torque: Array
    force: dict[str, Array]


@dataclass(frozen=True, eq=False)
class End:
    """Where a run ends.

    Attributes:
        crank_angle: of the driver joint, unwrapped [rad].
        crank_speed: of the driver joint [rad/s].
        loop_gap: largest distance between the two sides of a bearing that the peer closes by an equation [m]; None where it has none.
        energy_error: kinetic and potential energy less that at the start, relative to the kinetic energy at the start [-]; None where it
            is not kept.
        force: name of a joint or loop -> (3,), as of `Answer` [N].
        evaluations: of the equation of motion, where they are counted.
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
        name: of the program, with its version.
        inverse: whether it has inverse dynamics of its own to be compared.
        steps: fixed steps worth measuring in a run of some turns at 70 strokes/min, largest first; none where it cannot run [s].
        left_out: group of a scene, beside the free run, that it is not for -> why.
    """

    name: str
    inverse: bool
    steps: tuple[float, ...]

    @property
    def left_out(self) -> Mapping[str, str]: ...

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """One turn at constant speed, or a part of one, without process loads, weights included.

        Args:
            angle: (n,) of the crank, in equal steps [rad].
            speed: of the crank, with the sign of the steps [rad/s].

        Raises:
            PinpressError: the peer finds no answer.
        """

    def free_run(self, angle: float, speed: float, inertia: float, duration: float, step: float) -> End:
        """Let the press run without torque.

        Args:
            angle: of the crank at the start [rad].
            speed: of the crank at the start [rad/s].
            inertia: of a flywheel on the crank's shaft [kg m2].
            duration: [s].
            step: [s]; it is shortened until the duration is a whole number of steps.

        Raises:
            PinpressError: the peer finds no answer, or cannot run.
        """

    def run(self, scene: Scene, step: float) -> End:
        """Let the press run through a scene that is not ``left_out``. Args and Raises as of `free_run`."""


class Solver(Protocol):
    """An integrator of SciPy on a press's equation of motion in closed form, as an expert writes it for this one press.

    Attributes:
        name: of the integrator.
        tolerances: that are worth measuring.
        left_out: group of a scene that it is not for -> why.
    """

    @property
    def name(self) -> str: ...
    @property
    def tolerances(self) -> tuple[float, ...]: ...
    @property
    def left_out(self) -> Mapping[str, str]: ...

    def prepared(self, scene: Scene) -> Callable[[float], End]:
        """What finds the end of a scene to a tolerance; it raises a PinpressError where the integrator gives up."""


def steps_of(duration: float, step: float) -> int:
    """How many equal steps, none longer than ``step``, make up a duration."""
    return max(1, int(np.ceil(duration / step * (1 - 1e-9))))
