"""Find the lengths of a linkage that meet requirements best.

    found = pp.synthesis.synthesise(
        press,
        {"B.crank.x": (0.12, 0.143, 0.16)},  # least, first and largest value of a pivot's coordinate [m]
        minimise=lambda trial: trial.reactions.driving_torque.max(),
        subject_to={"stroke": (lambda trial: pp.measures.stroke(trial.motion), 0.30, None)},
        speed=70 * pp.RPM,
    )
    print(found)

Objectives and limits are functions of a `Trial`: the motion and forces of the press with trial lengths. Their gradients are exact.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
