"""The peers that are installed and can treat a press: a script written by hand (for one press), MuJoCo, Exudyn, SciPy on a closed form."""

from collections.abc import Callable, Mapping
from functools import partial
from importlib import import_module
from typing import ClassVar

from ...common.errors import PinpressError
from ...common.quantities import Array
from ...linkage.linkage import Linkage
from ...linkage.loading import load
from ..scenes import Scene
from .peer import Answer, End, Peer, Solver
from .six_bar_script import six_bar, world_forces

INSTALL = "not installed; pip install 'pinpress[peers]'"


def find_peers(press: Linkage) -> tuple[tuple[Peer, ...], tuple[str, ...]]:
    """The peers that can treat a press, and a line for each that is skipped, with the reason."""
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


def find_solvers(press: Linkage) -> tuple[tuple[Solver, ...], tuple[str, ...]]:
    """The solvers that can treat a press, or a line that says why there are none."""
    from .six_bar_equation import INTEGRATORS, SixBarEquation  # SciPy is slow to import

    try:
        HandScript(press)
    except PinpressError as error:
        return (), (f"SciPy on the closed form is skipped: {error}",)
    balanced = press.name.endswith("_balanced")
    return tuple(SixBarEquation(integrator, balanced) for integrator in INTEGRATORS), ()


def _made(package: str, module: str, kind: str, press: Linkage) -> Peer:
    """A peer whose program takes long to import, and may not be installed."""
    import_module(package)  # its absence is known even where our module has been imported before
    peer: Peer = getattr(import_module(module, __package__), kind)(press)
    return peer


class HandScript:
    """`six_bar_script` as a peer: one press, written out by hand."""

    name = "hand script"
    inverse = True
    steps: tuple[float, ...] = ()
    left_out: ClassVar[Mapping[str, str]] = {}

    def __init__(self, press: Linkage) -> None:
        """Take the script's press.

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
        result = six_bar(angle, speed, 0.0, self._balanced)
        return Answer(result["tau"], world_forces(result))

    def free_run(self, angle: float, speed: float, inertia: float, duration: float, step: float) -> End:
        """Not in the script: see `steps`."""
        raise PinpressError("the hand script has no free run: it has no steps")

    def run(self, scene: Scene, step: float) -> End:
        """Not in the script: see `steps`."""
        raise PinpressError("the hand script has no runs: it has no steps")
