"""The limits of a press in use: permissible force over the stroke, work, speed, eccentric loads.

    capacities = pp.ratings.Capacities(3e6, nominal_height=0.013, bearings={"A": 2e6}, flywheel_inertia=2000.0, speed_drop=0.2)
    rated = pp.ratings.rate(press, 70 * pp.RPM, capacities)
    print(rated)  # which limit governs at which height
    pp.plots.draw(rated, "force", "near_bottom", "work")

Capacities are the limits of the parts: nominal force, crank torque, bearings, flywheel, motor. Heights are slide positions above bottom
dead centre [m].
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
