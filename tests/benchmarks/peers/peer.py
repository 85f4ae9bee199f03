"""Peers: the same press in other programs, beside which pinpress is measured.

All answers have the signs of `Reactions`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

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


class Peer:
    """A press made in another program. What a program does not offer stays as it is here.

    Attributes:
        name: name of the program, with its version.
        cannot: what it cannot do for a linkage, in phrases between semicolons.
        inverse: whether it has inverse dynamics of its own to be compared.
        steps: fixed steps worth measuring in a run of some turns at 70 strokes/min, largest first [s].
        tolerances: tolerances worth measuring, of a program that chooses its steps.
        left_out: group of a scene that it cannot run -> why.
    """

    name: str
    cannot: str = ""
    inverse: bool = True
    steps: tuple[float, ...] = ()
    tolerances: tuple[float, ...] = ()
    left_out: Mapping[str, str] = MappingProxyType({})

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """Inverse dynamics of a turn at constant speed, or of a part of one, with weights and without process loads.

        Args:
            angle: (n,) crank angles in equal steps [rad].
            speed: crank speed, with the sign of the steps [rad/s].

        Raises:
            PinpressError: the peer finds no answer.
        """
        raise NotImplementedError

    def prepared(self, scene: Scene) -> Callable[[float], RunEnd]:
        """A function that runs the press through a scene that is not ``left_out``.

        It takes a step, which it shortens until the duration is a whole number of steps [s], or a tolerance, and raises a PinpressError
        where the program finds no end.
        """
        raise NotImplementedError


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
