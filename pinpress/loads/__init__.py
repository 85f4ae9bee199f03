"""What a press works against: process loads, forces on links, springs and dampers, friction.

    blanking = pp.loads.Blanking(force=1e6, start=0.006, end=0.002)  # N, m above bottom dead centre
    weight = pp.loads.PointForce("slide", force=(0.0, 0.0, -2e4))  # a die of 2 t on the slide
    friction = {"A": pp.loads.Friction(coefficient=0.05, radius=0.2)}
    pp.inverse_dynamics(press, motion, loads=[blanking, weight], friction=friction).driving_torque.max()

`inverse_dynamics`, `simulate`, `steady_state` and most other functions take these loads. Process loads depend on the slide's height and
resist its motion. Your own process load is a class with the methods of `ProcessLoad`.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
