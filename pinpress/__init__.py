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

import lazy_loader

from .common import command_end  # noqa: F401  from here on Ctrl-C ends a command without a traceback

__version__ = "0.2.0"
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
