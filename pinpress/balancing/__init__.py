"""Counterweights that minimise shaking forces, torques or bearing forces, with a proof of the optimum.

    regions = [pp.balancing.CounterweightRegion("crank", radius=0.3), pp.balancing.CounterweightRegion("rod", radius=0.3)]  # m
    vertical = pp.balancing.Range("shaking_force", "z")
    best = pp.balancing.balance(press, motion, regions=regions, minimise=vertical, limits={pp.balancing.AddedMass(): 600.0})
    print(best)  # counterweights, what holds them back, and all forces before and after
    pp.inverse_dynamics(best.press, motion)

At a given motion all forces are linear in the masses, so the search is a convex program with one optimum. The arrangements of textbooks are
in `pinpress.balancing.classical`.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
