"""Sweeps over many points: operating points of a press, and any function on a grid of its arguments.

    table = pp.sweeps.operating_points(press, speeds=np.linspace(30, 70, 5) * pp.RPM, points=90)
    table.to_frame()  # peaks of torque and every bearing force, one row for each speed

    table = pp.sweeps.sweep(torque_of, {"speed": [5.0, 6.0, 7.0]})  # def torque_of(speed): ... return {"torque": ...}
    table.column("torque")

`sweep` runs in several processes, or on a cluster, with an executor. With a file for its results it continues after a stop.
`sweep(..., at_once=True)` gives the function many points at once, as arrays.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
