"""Error against run time of everything that is offered for a press.

    measured = pp.accuracy(press, speed=70 * pp.RPM)
    print(measured), measured.to_csv("accuracy.csv"), pp.save_plot(pp.plot_accuracy(measured), "accuracy.png")

Every error is against a reference that two independent methods agree on; `Accuracy.certificates` says how far.
"""

import os
import platform
from collections.abc import Callable

import numpy as np
import pinocchio as pin

from . import accuracy_inverse, accuracy_proximal, accuracy_simulation, peers
from .accuracy_simulation import Scene
from .arguments import typed
from .contestants import measured
from .drives import Flywheel
from .errors import PinpressError
from .linkage import Linkage
from .measurements import Accuracy
from .motion import MOST_POINTS, RPM
from .single_numbers import number

TURNS = 2.0  # of the free run
HEAVY = 4.0  # times the linkage's largest reduced inertia: a flywheel that carries it on


@typed
def accuracy(
    press: Linkage,
    speed: float,
    flywheel: Flywheel | None = None,
    duration: float | None = None,
    points: int = 360,
    repeats: int = 3,
    progress: Callable[[float], None] | None = None,
) -> Accuracy:
    """Measure everything that is offered for a press, and the same press in other programs where they are installed (`peers`).

    Inverse dynamics of a period at constant speed by both engines. A free run from crank angle 0, weights on, by both methods of simulation
    over tolerances and steps. The proximal settings of constraint dynamics. The number of samples of the reduced table. Run times are the
    least of ``repeats`` rounds in which all take turns.

    Args:
        press: with one driver.
        speed: of the crank, in the period and at the start of the run [rad/s].
        flywheel: of the run; by default with 4 times the largest reduced inertia of the linkage.
        duration: of the run; by default the time of two turns at that speed [s].
        points: crank angles in the period.
        progress: called with the share done, 0 to 1.

    Raises:
        PinpressError: an argument that makes no sense, a linkage with several drivers.
        SingularityError, SimulationError: the crank does not turn fully, or the run has no end.
    """
    if len(press.drivers) > 1:
        raise PinpressError(f"{press.name} has {len(press.drivers)} drivers: accuracy is measured of a linkage with one")
    speed = number("speed", speed)
    if speed == 0:
        raise PinpressError("speed is 0: give the speed of the crank [rad/s], e.g. 70 * pinpress.RPM")
    for name, value, most in (("points", points, MOST_POINTS), ("repeats", repeats, 1000)):
        if isinstance(value, bool) or not isinstance(value, int) or not 1 < value + (name == "repeats") <= most:
            raise PinpressError(f"{name} is {value!r}: give a whole number, at least {1 + (name == 'points')}")
    if flywheel is not None and not isinstance(flywheel, Flywheel):
        raise PinpressError(f"flywheel is {flywheel!r}: give a Flywheel(...)")
    inertia = (
        HEAVY * float(press.table.at(press.table.borders)[0][0].max())
        if flywheel is None
        else number("the flywheel's inertia", flywheel.inertia)
    )
    lasting = TURNS * 2 * np.pi / abs(speed) if duration is None else number("duration", duration, positive=True)
    found, skipped = peers.find(press)
    contests = (
        accuracy_inverse.contest(press, speed, points, found),
        accuracy_simulation.contest(press, Scene(speed, inertia, lasting), found),
        accuracy_proximal.contest(press, speed, inertia),
        accuracy_simulation.tables(press),
    )
    total, done = (repeats + 1) * sum(len(contest.contestants) for contest in contests), 0

    def one_done() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done / total)

    return Accuracy(
        press=press.name,
        scene=f"{speed / RPM:g} r/min; free run of {lasting:.4g} s with a flywheel of {inertia:.4g} kg m2",
        machine=_machine(),
        certificates={contest.group: contest.certificate for contest in contests if contest.contestants},
        certified_by={contest.group: contest.certified_by for contest in contests if contest.contestants},
        measurements=tuple(m for contest in contests for m in measured(contest.contestants, repeats, one_done)),
        skipped=(*skipped, *(line for contest in contests for line in contest.skipped)),
    )


def _machine() -> str:
    versions = f"Python {platform.python_version()}, NumPy {np.__version__}, Pinocchio {pin.__version__}"
    return f"{versions}; {platform.system()} {platform.machine()}, {os.cpu_count()} cores"
