"""Mechanical press linkages as Pinocchio rigid-body models with closed loops.

    import pinpress as pp

    press = pp.load("zxn2_3000b")
    motion = pp.cycle(press, speed=70 * pp.RPM, points=360)
    result = pp.inverse_dynamics(press, motion)
    result.driving_torque, result.bearing_force["A"], result.shaking_force
    pp.record(press, motion, "press.html", result)
    pp.report(press, motion, "report.html", result)

SI units and radians throughout. World z is up; a planar press stands in the x-z plane.
"""

from typing import TYPE_CHECKING, Any

from .dead_centres import DeadCentres, dead_centres
from .errors import AssemblyError, PinpressError, SimulationError, SingularityError, UnknownNameError, UrdfError
from .forces import PointForce, SpringDamper
from .friction import Friction
from .linkage import Linkage
from .loading import load, presses
from .motion import RPM, Motion, cycle
from .reactions import Reactions, inverse_dynamics

__all__ = [
    "RPM",
    "Accuracy",
    "AssemblyError",
    "At",
    "Brake",
    "Clutch",
    "ConstantTorque",
    "DeadCentres",
    "Duty",
    "Extreme",
    "Finding",
    "Flywheel",
    "Friction",
    "Harmonics",
    "Linkage",
    "Measurement",
    "Motion",
    "PinpressError",
    "PointForce",
    "Reactions",
    "Report",
    "Run",
    "Runs",
    "SimulationError",
    "SingularityError",
    "SpringDamper",
    "Stats",
    "UnknownNameError",
    "UrdfError",
    "accuracy",
    "check",
    "cycle",
    "dead_centres",
    "drives",
    "duty",
    "extremes",
    "film",
    "harmonics",
    "inverse_dynamics",
    "load",
    "loads",
    "plot_accuracy",
    "plot_bearings",
    "plot_comparison",
    "plot_polar",
    "plot_shaking",
    "plot_slide",
    "plot_torque",
    "presses",
    "record",
    "report",
    "save_plot",
    "simulate",
    "steady_state",
    "still",
    "strokes",
    "write_urdf",
]

if TYPE_CHECKING:
    from . import drives, loads
    from .checking import Report, check
    from .driveline import At, Brake, Clutch
    from .drives import ConstantTorque, Flywheel
    from .extreme_values import Extreme, extremes
    from .figures import save_plot
    from .filming import film, still
    from .findings import Finding
    from .harmonic_analysis import Harmonics, harmonics
    from .measurements import Accuracy, Measurement
    from .plots import plot_bearings, plot_comparison, plot_polar, plot_shaking, plot_slide, plot_torque
    from .precision_plots import plot_accuracy
    from .recording import record
    from .reporting import report
    from .run import Run, Stats
    from .run_duty import Duty, duty, strokes
    from .scenarios import Runs
    from .simulation import simulate
    from .steady import steady_state
    from .work_precision import accuracy
    from .writing import write_urdf

_LATER = {
    "checking": ("Report", "check"),
    "driveline": ("At", "Brake", "Clutch"),
    "drives": ("ConstantTorque", "Flywheel"),
    "extreme_values": ("Extreme", "extremes"),
    "figures": ("save_plot",),
    "filming": ("film", "still"),
    "findings": ("Finding",),
    "harmonic_analysis": ("Harmonics", "harmonics"),
    "measurements": ("Accuracy", "Measurement"),
    "plots": ("plot_bearings", "plot_comparison", "plot_polar", "plot_shaking", "plot_slide", "plot_torque"),
    "precision_plots": ("plot_accuracy",),
    "recording": ("record",),
    "reporting": ("report",),
    "run": ("Run", "Stats"),
    "run_duty": ("Duty", "duty", "strokes"),
    "scenarios": ("Runs",),
    "simulation": ("simulate",),
    "steady": ("steady_state",),
    "work_precision": ("accuracy",),
    "writing": ("write_urdf",),
}


def __getattr__(name: str) -> Any:
    """What is imported when it is first used: who wants one turn should not wait for the rest."""
    from importlib import import_module

    if name in ("drives", "loads"):
        return import_module(f".{name}", __name__)
    for module, names in _LATER.items():
        if name in names:
            return getattr(import_module(f".{module}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
