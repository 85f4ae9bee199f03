"""Mechanical press linkages as Pinocchio rigid-body models with closed loops.

    import pinpress as pp

    press = pp.load("zxn2_3000b")
    motion = pp.cycle(press, speed=70 * pp.RPM, points=360)
    result = pp.inverse_dynamics(press, motion)
    result.driving_torque, result.bearing_force["A"], result.shaking_force
    pp.record(press, motion, "press.html")

SI units and radians throughout. World z is up; a planar press stands in the x-z plane.
"""

from typing import TYPE_CHECKING, Any

from . import drives, loads
from .dead_centres import DeadCentres, dead_centres
from .driveline import At, Brake, Clutch
from .drives import ConstantTorque, Flywheel
from .errors import AssemblyError, PinpressError, SimulationError, SingularityError, UnknownNameError, UrdfError
from .forces import PointForce, SpringDamper
from .friction import Friction
from .linkage import Linkage
from .loading import load, presses
from .motion import RPM, Motion, cycle
from .reactions import Reactions, inverse_dynamics
from .run import Run, Stats
from .run_duty import Duty, duty, strokes
from .scenarios import Runs
from .simulation import simulate
from .steady import steady_state

__all__ = [
    "RPM",
    "AssemblyError",
    "At",
    "Brake",
    "Clutch",
    "ConstantTorque",
    "DeadCentres",
    "Duty",
    "Finding",
    "Flywheel",
    "Friction",
    "Linkage",
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
    "check",
    "cycle",
    "dead_centres",
    "drives",
    "duty",
    "inverse_dynamics",
    "load",
    "loads",
    "presses",
    "record",
    "simulate",
    "steady_state",
    "strokes",
    "write_urdf",
]

if TYPE_CHECKING:
    from .checking import Report, check
    from .findings import Finding
    from .recording import record
    from .writing import write_urdf

_LATER = {"Report": "checking", "check": "checking", "Finding": "findings", "record": "recording", "write_urdf": "writing"}


def __getattr__(name: str) -> Any:
    """What is imported when it is first used: who only computes should not wait for it."""
    if name in _LATER:
        from importlib import import_module

        return getattr(import_module(f".{_LATER[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
