"""Error against run time of all methods for a press, beside other programs.

Every error is against a reference that two independent methods agree on; `WorkPrecision.certificates` says how far.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Sequence
from importlib import import_module

import numpy as np
import pinocchio as pin

from ..common.arguments import LARGEST, SMALLEST, number, positive, typed, whole_number
from ..common.errors import PinpressError, shown
from ..common.quantities import RPM
from ..common.results import Records
from ..drives.transmission import Flywheel
from ..kinematics.cycle import MOST_POINTS
from ..linkage.linkage import Linkage
from ..simulation.reduced_model import reduced_model_of
from .contests import inverse_dynamics_contest, measured, proximal_contest
from .measurements import SCENES, SPRINGS, Measurement, WorkPrecision
from .on_springs import SpringsScene, build_springs_scene, springs_contest
from .peers.peer import ClosedFormSolver, Peer
from .scenes import Scene, build_scene
from .simulation import simulation_contest, table_contest

TURNS = 2.0  # length of the runs
HEAVY = 4.0  # inertia of the default flywheel, which keeps the linkage turning, in its largest reduced inertias
PEERS = {  # package that must be installed, the extra that installs it, our module and class
    "hand script": ("numpy", "", "hand_script", "HandScript"),
    "Pinocchio in C++": ("pinocchio", "", "pinocchio_press", "PinocchioCpp"),
    "MuJoCo": ("mujoco", "peers", "mujoco_press", "Mujoco"),
    "MuJoCo's mj_step": ("mujoco", "peers", "mujoco_press", "MujocoSteps"),
    "Exudyn": ("exudyn", "peers", "exudyn_in_space", "exudyn_peer"),
    "Drake": ("pydrake", "drake", "drake_press", "Drake"),
    "Drake's steps": ("pydrake", "drake", "drake_press", "DrakeSteps"),
}


@typed
def compare(
    press: Linkage,
    speed: float,
    *,
    flywheel: Flywheel | None = None,
    duration: float | None = None,
    points: int = 360,
    repeats: int = 3,
    scenes: Sequence[str] = SCENES,
    progress: Callable[[float], None] | None = None,
) -> WorkPrecision:
    """Measure all methods for a press, and this press in other programs where they are installed (`peers`, `drake`, a C++ compiler).

    A loop in C++ is compiled once, in half a minute, into the user's cache folder. What other programs cannot do for a linkage stands in
    `Measurement.cannot`, what is missing or left out in `WorkPrecision.skipped`.

    It measures inverse dynamics of a period at constant speed by all engines; simulations by all methods over tolerances and steps; the
    proximal settings of constraint dynamics; and the number of samples of the reduced table. The simulations are a free run from crank
    angle 0 with weights; a start by a clutch under a motor, and a blank; a stiff elastic die under a motor; a drive that holds the speed
    so hard that the equation is stiff; and half a stroke of the press on springs, in which it blanks. Run times are the least of several
    rounds in which all take turns.

    Args:
        press: a linkage with one driver.
        speed: speed of the crank, in the period and at the start of the runs [rad/s].
        flywheel: flywheel of the runs; by default with 4 times the largest reduced inertia of the linkage.
        duration: length of the runs; by default the time of two turns at that speed [s].
        points: number of crank angles in the period.
        repeats: number of rounds of timing.
        scenes: scenes to simulate, among "free run", "clutch and blanking", "elastic die", "stiff speed law" and "blanking on
            springs".
        progress: function called with the share done, 0 to 1.

    Raises:
        PinpressError: an argument is not as described, or the linkage has several drivers.
        SingularityError: the crank does not turn fully.
        SimulationError: a run does not reach its end.
    """
    speed = _checked(press, speed, points, repeats, scenes)
    inertia = _inertia(press, flywheel)
    lasting = TURNS * 2 * np.pi / abs(speed) if duration is None else positive("duration", duration, "s")
    found, skipped = find_peers(press)
    solvers, missing = find_solvers(press)
    made, unmade = _scenes(press, scenes, speed, inertia, lasting)
    sprung, rigid = _on_springs(press, scenes, speed, inertia)
    contests = (
        inverse_dynamics_contest(press, speed, points, found),
        *(simulation_contest(press, scene, found, solvers) for scene in made),
        *(springs_contest(scene) for scene in sprung),
        proximal_contest(press, speed, inertia),
        table_contest(press),
    )
    total, done = (repeats + 1) * sum(len(contest.contestants) for contest in contests), 0

    def one_done() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done / total)

    return WorkPrecision(
        press_name=press.name,
        scene=f"{speed / RPM:g} r/min; runs of {lasting:.4g} s with a flywheel of {inertia:.4g} kg m2",
        machine=_machine(),
        scenes={scene.group: scene.words for scene in made} | {scene.group: scene.words for scene in sprung},
        certificates={contest.group: contest.certificate for contest in contests if contest.contestants},
        certified_by={contest.group: contest.certified_by for contest in contests if contest.contestants},
        measurements=Records(Measurement, (m for contest in contests for m in measured(contest.contestants, repeats, one_done))),
        skipped=(*skipped, *missing, *unmade, *rigid, *(line for contest in contests for line in contest.skipped)),
    )


def _checked(press: Linkage, speed: object, points: object, repeats: object, scenes: Sequence[str]) -> float:
    """The speed as a number, after all arguments are checked [rad/s]."""
    press.refuse_several_drivers("accuracy is measured of a linkage with one")
    press.refuse_sliding_driver("accuracy is measured of a crank that turns under a flywheel")
    turning = number("speed", speed)
    if not SMALLEST <= abs(turning) <= LARGEST:
        raise PinpressError(f"speed is {turning:g}: give the speed of the crank [rad/s], e.g. 70 * pinpress.RPM")
    whole_number("points", points, 2, MOST_POINTS)
    whole_number("repeats", repeats, 1, 1000)
    if isinstance(scenes, str) or not all(isinstance(scene, str) and scene in SCENES for scene in scenes):
        raise PinpressError(f"scenes are {shown(scenes)}: give some of {', '.join(map(repr, SCENES))}")
    return turning


def find_peers(press: Linkage) -> tuple[tuple[Peer, ...], tuple[str, ...]]:
    """The peers that can treat a press, and a line for each that is skipped, with the reason."""
    peers: list[Peer] = []
    skipped: list[str] = []
    for name, (package, extra, module, kind) in PEERS.items():
        try:
            import_module(package)  # its absence is known even where our module has been imported before
            peers.append(getattr(import_module(f".peers.{module}", __package__), kind)(press))
        except ModuleNotFoundError:
            skipped.append(f"{name} is skipped: not installed; pip install 'pinpress[{extra}]'")
        except PinpressError as error:
            skipped.append(f"{name} is skipped: {error}")
    return tuple(peers), tuple(skipped)


def find_solvers(press: Linkage) -> tuple[tuple[ClosedFormSolver, ...], tuple[str, ...]]:
    """The solvers that can treat a press, or a line that says why there are none."""
    from .peers.hand_script import is_six_bar  # slow to import: pin tables
    from .peers.six_bar_press import INTEGRATORS, SixBarEquation  # slow to import: SciPy

    if not is_six_bar(press):
        return (), ("SciPy on the closed form is skipped: it is for the six-bar alone",)
    balanced = press.name.endswith("_balanced")
    return tuple(SixBarEquation(integrator, balanced) for integrator in INTEGRATORS), ()


def _inertia(press: Linkage, flywheel: Flywheel | None) -> float:
    """Moment of inertia of the flywheel [kg m2]."""
    if flywheel is None:
        table = reduced_model_of(press)
        return HEAVY * float(table.at(table.borders)[0][0].max())
    return number("the flywheel's inertia", flywheel.inertia)


def _scenes(
    press: Linkage, wanted: Sequence[str], speed: float, flywheel: float, duration: float
) -> tuple[tuple[Scene, ...], tuple[str, ...]]:
    """The scenes wanted, and a line for each that this press does not have."""
    made, unmade = [], []
    for group in (scene for scene in SCENES if scene in wanted and scene != SPRINGS):
        try:
            made.append(build_scene(press, group, speed, flywheel, duration))
        except PinpressError as error:
            unmade.append(f"{group} is skipped: {error}")
    return tuple(made), tuple(unmade)


def _on_springs(press: Linkage, wanted: Sequence[str], speed: float, flywheel: float) -> tuple[tuple[SpringsScene, ...], tuple[str, ...]]:
    """The scene of the press on springs where it is wanted, or a line that says why this press has none."""
    if SPRINGS not in wanted:
        return (), ()
    try:
        return (build_springs_scene(press, speed, flywheel),), ()
    except PinpressError as error:
        return (), (f"{SPRINGS} is skipped: {error}",)


def _machine() -> str:
    versions = f"Python {platform.python_version()}, NumPy {np.__version__}, Pinocchio {pin.__version__}"
    return f"{versions}; {platform.system()} {platform.machine()}, {os.cpu_count()} cores"
