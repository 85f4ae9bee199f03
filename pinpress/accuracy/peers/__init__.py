"""The same press in other programs: peers whose answers and run times can be set beside those of pinpress.

    peers, skipped = find(pp.load("zxn2_3000b"))

`find` gives every peer that can treat a press: a hand-written NumPy script (for one press), MuJoCo and Exudyn. Nothing of theirs is
imported before it is called. All answers have pinpress's signs: see `pinpress.reactions`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from ...common.arrays import Array
from ...common.errors import PinpressError
from ...linkage.linkage import Linkage
from ...linkage.loading import load

if TYPE_CHECKING:
    from ..scenes import Scene

INSTALL = "not installed; pip install 'pinpress[peers]'"


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
    """Where a free run ends.

    Attributes:
        crank_angle, crank_speed: of the driver joint, the angle unwrapped [rad, rad/s].
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
            angle: (n,) of the crank in equal steps [rad]. speed: of the crank, with the sign of the steps [rad/s].

        Raises:
            PinpressError: the peer finds no answer.
        """

    def free_run(self, angle: float, speed: float, inertia: float, duration: float, step: float) -> End:
        """Let the press run without torque.

        Args:
            angle, speed: of the crank at the start [rad, rad/s]. inertia: of a flywheel on the crank's shaft [kg m2].
            duration, step: [s]; the step is shortened until the duration is a whole number of steps.

        Raises:
            PinpressError: the peer finds no answer, or cannot run.
        """

    def run(self, scene: "Scene", step: float) -> End:
        """Let the press run through a scene that is not ``left_out``; as `free_run`."""


class Solver(Protocol):
    """An integrator of SciPy on a press's equation of motion in closed form, as an expert writes it for this one press.

    Attributes:
        name: of the integrator. tolerances: worth measuring. left_out: group of a scene that it is not for -> why.
    """

    @property
    def name(self) -> str: ...
    @property
    def tolerances(self) -> tuple[float, ...]: ...
    @property
    def left_out(self) -> Mapping[str, str]: ...

    def prepared(self, scene: "Scene") -> Callable[[float], End]:
        """What finds the end of a scene to a tolerance; it raises a PinpressError where the integrator gives up."""


class HandScript:
    """`six_bar_script` as a peer: one press, written out by hand."""

    name = "hand script"
    inverse = True
    steps: tuple[float, ...] = ()
    left_out: ClassVar[Mapping[str, str]] = {}

    def __init__(self, press: Linkage) -> None:
        """
        Raises:
            PinpressError: another press than the script's.
        """
        shipped = ("zxn2_3000b", "zxn2_3000b_balanced")
        own = load(press.name) if press.name in shipped else None
        if own is None or press.text != own.text or press.model != own.model or press.drivers != own.drivers:
            raise PinpressError(f"it is for {' and '.join(shipped)} alone")
        self._balanced = press.name == shipped[1]

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """See `Peer`."""
        from .six_bar_script import six_bar, world_forces

        result = six_bar(angle, speed, 0.0, self._balanced)
        return Answer(result["tau"], world_forces(result))

    def free_run(self, angle: float, speed: float, inertia: float, duration: float, step: float) -> End:
        """Not in the script: see `steps`."""
        raise PinpressError("the hand script has no free run: it has no steps")

    def run(self, scene: "Scene", step: float) -> End:
        """Not in the script: see `steps`."""
        raise PinpressError("the hand script has no runs: it has no steps")


def find(press: Linkage) -> tuple[tuple[Peer, ...], tuple[str, ...]]:
    """The peers that can treat a press, and one line for each that is skipped, with the reason."""
    peers: list[Peer] = []
    skipped: list[str] = []
    makers: tuple[tuple[str, Callable[[Linkage], Peer]], ...] = (
        ("hand script", HandScript),
        ("MuJoCo", partial(_made, "mujoco", ".mujoco_press", "Mujoco")),
        ("MuJoCo's mj_step", partial(_made, "mujoco", ".mujoco_press", "MujocoSteps")),
        ("Exudyn", partial(_made, "exudyn", ".exudyn_press", "Exudyn")),
    )
    for name, make in makers:
        try:
            peers.append(make(press))
        except ModuleNotFoundError:
            skipped.append(f"{name} is skipped: {INSTALL}")
        except PinpressError as error:
            skipped.append(f"{name} is skipped: {error}")
    return tuple(peers), tuple(skipped)


def solvers(press: Linkage) -> tuple[tuple[Solver, ...], tuple[str, ...]]:
    """The solvers that can treat a press, or a line that says why there are none."""
    from .six_bar_equation import INTEGRATORS, SixBarEquation

    try:
        HandScript(press)
    except PinpressError as error:
        return (), (f"SciPy on the closed form is skipped: {error}",)
    balanced = press.name.endswith("_balanced")
    return tuple(SixBarEquation(integrator, balanced) for integrator in INTEGRATORS), ()


def steps_of(duration: float, step: float) -> int:
    """How many equal steps, none longer than ``step``, make up a duration."""
    return max(1, int(np.ceil(duration / step * (1 - 1e-9))))


def _made(package: str, module: str, kind: str, press: Linkage) -> Peer:
    import_module(package)  # its absence is known even where our module has been imported before
    peer: Peer = getattr(import_module(module, __name__), kind)(press)
    return peer
