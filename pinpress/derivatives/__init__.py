"""Exact derivatives of a motion by lengths and pivots, of accelerations by states and efforts, and linkages with other lengths.

    longer = pp.derivatives.reshaped(press, {("B", "crank"): (0.145, 0.0, 0.0)})  # pivot of joint B on the link crank [m]
    by_radius = {("B", "crank"): (1.0, 0.0, 0.0)}  # a direction in which pivots move, m per m
    (change,) = pp.derivatives.motion_derivatives(press, motion, [by_radius])
    change.slide_position  # m per m, one value for each state

    by_state = pp.derivatives.acceleration_derivatives(press, motion)  # of any linkage, under the motion's own driving torque
    by_state.by_rate  # (n, nv, nv), 1/s

Pivots are named by a joint or loop and one of its two links, and are given in that link's frame; `pivot_positions` lists them all.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
