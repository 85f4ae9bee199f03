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

from . import command_end  # noqa: F401  first: from here on Ctrl-C ends a command without a traceback
from .dead_centres import DeadCentres, dead_centres
from .errors import AssemblyError, PinpressError, PinpressWarning, SimulationError, SingularityError, UnknownNameError, UrdfError
from .forces import PointForce, SpringDamper
from .friction import Friction
from .linkage import Linkage
from .loading import load, presses
from .motion import Motion, cycle
from .reactions import Reactions, inverse_dynamics
from .units import RPM

__all__ = [
    "RPM",
    "Accuracy",
    "Active",
    "AddedMass",
    "AssemblyError",
    "At",
    "Balance",
    "Brake",
    "Capacities",
    "Case",
    "Clutch",
    "ConstantTorque",
    "Counterweight",
    "DeadCentreShift",
    "DeadCentres",
    "Duty",
    "EccentricLoad",
    "Elasticity",
    "Extreme",
    "FailedPoint",
    "Finding",
    "Flywheel",
    "Friction",
    "Guide",
    "Harmonics",
    "Linkage",
    "Measurement",
    "Motion",
    "MotionDerivative",
    "OperatingPoints",
    "Outcome",
    "Peak",
    "PinpressError",
    "PinpressWarning",
    "PointForce",
    "Range",
    "Ratings",
    "Reactions",
    "Report",
    "Rms",
    "Rod",
    "Room",
    "Run",
    "Runs",
    "SimulationError",
    "SingularityError",
    "SlideDeflection",
    "SnapThrough",
    "SpeedLimit",
    "SpringDamper",
    "Stats",
    "Stiffness",
    "Sweep",
    "Synthesis",
    "TradeOff",
    "Trial",
    "UnknownNameError",
    "UrdfError",
    "accuracy",
    "arrangements",
    "balance",
    "check",
    "cycle",
    "dead_centre_shift",
    "dead_centres",
    "drives",
    "duty",
    "eccentric_load",
    "elasticity",
    "extremes",
    "film",
    "foundation",
    "harmonics",
    "inverse_dynamics",
    "load",
    "loads",
    "measures",
    "motion_derivatives",
    "operating_points",
    "permissible_breakthrough",
    "permissible_eccentricity",
    "pivot_positions",
    "plot_accuracy",
    "plot_bearings",
    "plot_comparison",
    "plot_dead_centre_shift",
    "plot_elasticity",
    "plot_polar",
    "plot_ratings",
    "plot_shaking",
    "plot_slide",
    "plot_snap_through",
    "plot_torque",
    "plot_trade_offs",
    "presses",
    "ratings",
    "record",
    "report",
    "reshaped",
    "save_plot",
    "simulate",
    "slide_deflection",
    "snap_through",
    "speed_limit",
    "steady_state",
    "still",
    "strokes",
    "sweep",
    "synthesise",
    "trade_off",
    "with_counterweights",
    "write_urdf",
]

if TYPE_CHECKING:
    from . import arrangements, drives, foundation, loads, measures
    from .balance_measures import AddedMass, Peak, Range, Rms
    from .balance_plots import plot_trade_offs
    from .balance_result import Active, Balance, Outcome
    from .balancing import balance
    from .breakthrough import SnapThrough, permissible_breakthrough, snap_through
    from .capacities import Capacities
    from .checking import Report, check
    from .compliance import Elasticity, elasticity
    from .counterweights import Counterweight, with_counterweights
    from .driveline import At, Brake, Clutch
    from .drives import ConstantTorque, Flywheel
    from .elastic_elements import Rod, Stiffness
    from .elastic_plots import plot_dead_centre_shift, plot_elasticity, plot_snap_through
    from .elastic_slide import DeadCentreShift, SlideDeflection, dead_centre_shift, slide_deflection
    from .extreme_values import Extreme, extremes
    from .figures import save_plot
    from .filming import film, still
    from .findings import Finding
    from .geometry import reshaped
    from .harmonic_analysis import Harmonics, harmonics
    from .inertia_responses import Case
    from .measurements import Accuracy, Measurement
    from .operating import operating_points
    from .operating_table import OperatingPoints
    from .plots import plot_bearings, plot_comparison, plot_polar, plot_shaking, plot_slide, plot_torque
    from .precision_plots import plot_accuracy
    from .rating import Ratings, ratings
    from .rating_guides import EccentricLoad, Guide, eccentric_load, permissible_eccentricity
    from .rating_plots import plot_ratings
    from .rating_speed import SpeedLimit, speed_limit
    from .recording import record
    from .reporting import report
    from .rooms import Room
    from .run import Run, Stats
    from .run_duty import Duty, duty, strokes
    from .scenarios import Runs
    from .sensitivities import MotionDerivative, motion_derivatives
    from .sensitivities_pivots import pivot_positions
    from .simulation import simulate
    from .steady import steady_state
    from .sweep_table import FailedPoint, Sweep
    from .sweeping import sweep
    from .synthesis import Synthesis, synthesise
    from .trade_offs import TradeOff, trade_off
    from .trials import Trial
    from .work_precision import accuracy
    from .writing import write_urdf

_LATER = {
    "balance_measures": ("AddedMass", "Peak", "Range", "Rms"),
    "balance_plots": ("plot_trade_offs",),
    "balance_result": ("Active", "Balance", "Outcome"),
    "balancing": ("balance",),
    "breakthrough": ("SnapThrough", "permissible_breakthrough", "snap_through"),
    "capacities": ("Capacities",),
    "checking": ("Report", "check"),
    "compliance": ("Elasticity", "elasticity"),
    "counterweights": ("Counterweight", "with_counterweights"),
    "driveline": ("At", "Brake", "Clutch"),
    "drives": ("ConstantTorque", "Flywheel"),
    "elastic_elements": ("Rod", "Stiffness"),
    "elastic_plots": ("plot_dead_centre_shift", "plot_elasticity", "plot_snap_through"),
    "elastic_slide": ("DeadCentreShift", "SlideDeflection", "dead_centre_shift", "slide_deflection"),
    "extreme_values": ("Extreme", "extremes"),
    "figures": ("save_plot",),
    "filming": ("film", "still"),
    "findings": ("Finding",),
    "geometry": ("reshaped",),
    "harmonic_analysis": ("Harmonics", "harmonics"),
    "inertia_responses": ("Case",),
    "measurements": ("Accuracy", "Measurement"),
    "operating": ("operating_points",),
    "operating_table": ("OperatingPoints",),
    "plots": ("plot_bearings", "plot_comparison", "plot_polar", "plot_shaking", "plot_slide", "plot_torque"),
    "precision_plots": ("plot_accuracy",),
    "rating": ("Ratings", "ratings"),
    "rating_guides": ("EccentricLoad", "Guide", "eccentric_load", "permissible_eccentricity"),
    "rating_plots": ("plot_ratings",),
    "rating_speed": ("SpeedLimit", "speed_limit"),
    "recording": ("record",),
    "reporting": ("report",),
    "rooms": ("Room",),
    "run": ("Run", "Stats"),
    "run_duty": ("Duty", "duty", "strokes"),
    "scenarios": ("Runs",),
    "sensitivities": ("MotionDerivative", "motion_derivatives"),
    "sensitivities_pivots": ("pivot_positions",),
    "simulation": ("simulate",),
    "steady": ("steady_state",),
    "sweep_table": ("FailedPoint", "Sweep"),
    "sweeping": ("sweep",),
    "synthesis": ("Synthesis", "synthesise"),
    "trade_offs": ("TradeOff", "trade_off"),
    "trials": ("Trial",),
    "work_precision": ("accuracy",),
    "writing": ("write_urdf",),
}


def __getattr__(name: str) -> Any:
    """What is imported when it is first used: who wants one turn should not wait for the rest."""
    from importlib import import_module

    if name in ("arrangements", "drives", "foundation", "loads", "measures"):
        return import_module(f".{name}", __name__)
    for module, names in _LATER.items():
        if name in names:
            return getattr(import_module(f".{module}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
