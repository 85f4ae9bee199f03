"""The linkages that are written out by hand, `six_bar_script` and `spatial_scripts`, as a peer."""

from collections.abc import Callable

from benchmarks.peers.peer import Answer, Peer
from benchmarks.peers.spatial_scripts import ball_rod, bricard
from support.oracles.six_bar_script import six_bar, world_forces

from pinpress.common.errors import PinpressError
from pinpress.common.quantities import Array
from pinpress.linkage.linkage import Linkage


def _six_bar(angle: Array, speed: float, balanced: bool = False) -> tuple[Array, dict[str, Array]]:
    result = six_bar(angle, speed, 0.0, balanced)
    return result["tau"], world_forces(result)


SCRIPTS: dict[str, Callable[[Array, float], tuple[Array, dict[str, Array]]]] = {  # name of the linkage -> its script
    "zxn2_3000b": _six_bar,
    "zxn2_3000b_balanced": lambda angle, speed: _six_bar(angle, speed, True),
    "rssp": ball_rod,
    "bricard": bricard,
}


class HandScript(Peer):
    """A peer that an engineer has written out for one linkage."""

    name = "hand script"
    cannot = "any other linkage, process loads, friction, branches, runs"

    def __init__(self, press: Linkage) -> None:
        """Take the script of a press, by its name. Raises PinpressError if there is none."""
        if press.name not in SCRIPTS:
            *others, last = SCRIPTS
            raise PinpressError(f"it is for {', '.join(others)} and {last} alone")
        self._script = SCRIPTS[press.name]

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """See `Peer`."""
        return Answer(*self._script(angle, speed))
