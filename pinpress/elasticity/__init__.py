"""Elastic parts between crank and slide: compliance, bottom dead centre over speed, snap-through of a blank.

    stiffness = pp.elasticity.Stiffness(dict.fromkeys("ABCDEF", 2e9), shaft=3e7, frame=4e9)  # bearings in N/m, shaft in N m/rad
    compliance = pp.elasticity.compliance(press, stiffness)
    compliance.bottom_stiffness  # N/m at the slide
    pp.elasticity.snap_through(force=1e6, stiffness=compliance.bottom_stiffness, mass=7000.0).overshoot  # m

Deflections are small: the springs of the parts displace the slide but do not change the motion of the linkage.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
