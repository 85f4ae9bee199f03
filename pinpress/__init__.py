"""Mechanical press linkages as Pinocchio rigid-body models with closed loops.

    import pinpress as pp

    press = pp.load("zxn2_3000b")  # or the path of your URDF
    motion = pp.cycle(press, speed=70 * pp.RPM, points=360)
    reactions = pp.inverse_dynamics(press, motion)
    reactions.driving_torque, reactions.bearing_force["A"], reactions.shaking_force
    pp.record(press, motion, "press.html", reactions=reactions)
    pp.report(press, motion, "report.html", reactions=reactions)

SI units and radians throughout. World z is up; a planar press stands in the x-z plane. What not everyone needs stands in namespaces:
`pin_table`, `loads`, `drives`, `measures`, `ratings`, `fe`, `servo`, `mains`, `measured`, `tolerances`, `elasticity`, `foundation`,
`balancing`, `synthesis`, `sweeps`, `derivatives`, `export`, `plots`, `video` and `accuracy`.
"""

from .common import command_end  # noqa: F401  from here on Ctrl-C ends a command without a traceback
from .common.public_names import public_names

__version__ = "0.2.0"
__getattr__, __dir__, __all__ = public_names(__name__, __file__)
