"""The linkages that are written out by hand, `six_bar_script` and `spatial_scripts`, as a peer."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import ClassVar

from benchmarks.peers.peer import Answer, RunEnd
from benchmarks.peers.spatial_scripts import ball_rod, bricard
from support.oracles.six_bar_script import six_bar, world_forces

from pinpress.accuracy.scenes import Scene
from pinpress.common.errors import PinpressError
from pinpress.common.quantities import Array
from pinpress.linkage.linkage import Linkage
from pinpress.linkage.loading import load
from pinpress.pin_table import templates
from pinpress.pin_table.building import build

NO_RUN = "the hand script has no runs: it has no steps"


def _six_bar(angle: Array, speed: float) -> Answer:
    result = six_bar(angle, speed, 0.0)
    return Answer(result["tau"], world_forces(result))


def _balanced_six_bar(angle: Array, speed: float) -> Answer:
    result = six_bar(angle, speed, 0.0, True)
    return Answer(result["tau"], world_forces(result))


SCRIPTS: dict[str, tuple[Callable[[], Linkage], Callable[[Array, float], Answer]]] = {  # name -> the linkage that it is for, and it
    "zxn2_3000b": (lambda: load("zxn2_3000b"), _six_bar),
    "zxn2_3000b_balanced": (lambda: load("zxn2_3000b_balanced"), _balanced_six_bar),
    "rssp": (lambda: build(Path(templates.__file__).with_name("rssp.yaml")), lambda angle, speed: Answer(*ball_rod(angle, speed))),
    "bricard": (lambda: load(Path(__file__).with_name("bricard.urdf")), lambda angle, speed: Answer(*bricard(angle, speed))),
}


class HandScript:
    """A peer that an engineer has written out for one linkage."""

    name = "hand script"
    inverse = True
    cannot = "any other linkage, process loads, friction, branches, runs"
    steps: tuple[float, ...] = ()
    left_out: ClassVar[Mapping[str, str]] = {}

    def __init__(self, press: Linkage) -> None:
        """Take the script of a press.

        Raises:
            PinpressError: there is none.
        """
        made, script = SCRIPTS.get(press.name, (None, None))
        if made is None or script is None or not _same(press, made()):
            *others, last = SCRIPTS
            raise PinpressError(f"it is for {', '.join(others)} and {last} alone")
        self._script = script

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """See `Peer`."""
        return self._script(angle, speed)

    def free_run(self, angle: float, speed: float, inertia: float, duration: float, step: float) -> RunEnd:
        """Not in the script: see `steps`."""
        raise PinpressError(NO_RUN)

    def run(self, scene: Scene, step: float) -> RunEnd:
        """Not in the script: see `steps`."""
        raise PinpressError(NO_RUN)


def is_six_bar(press: Linkage) -> bool:
    """Whether a linkage is the six-bar, with counterweights or without."""
    made, _ = SCRIPTS.get(press.name, (None, None))
    return made is not None and press.name.startswith("zxn2_3000b") and _same(press, made())


def _same(press: Linkage, own: Linkage) -> bool:
    """Whether a linkage is the one that a script is for, whatever file it comes from."""
    ends, own_ends = ([(at.name, at.type, at.point1.tolist(), at.point2.tolist()) for at in each.loops] for each in (press, own))
    return press.model == own.model and press.drivers == own.drivers and ends == own_ends
