"""Measures of a motion, its forces and a run: the numbers in which requirements on a press are stated.

    pp.measures.stroke(motion)  # m
    pp.measures.mechanical_advantage(motion, height=0.013)  # force at the slide by torque at the crank, 13 mm above bottom dead centre
    pp.measures.dwell_time(motion, tolerance=1e-3)  # s within 1 mm of bottom dead centre
    print(pp.measures.extremes(reactions))  # smallest and largest of every quantity, and where

Heights are slide positions above bottom dead centre [m], angles are in rad. Most are continuous in the linkage's lengths, so that they can
be goals and limits of `pinpress.synthesis`.
"""

from .common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
