"""The presses of Zhang 2007 as its chapters use them."""

import numpy as np

from ..balancing.counterweights import Counterweight, with_counterweights
from ..common.quantities import RPM
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import cycle
from ..linkage.linkage import Linkage
from ..linkage.loading import load

SPEED = 300 * RPM
GRAVITY = 9.80665
POINTS = 720
FLYWHEEL_MASS, FLYWHEEL_INERTIA = 940.0, 136.0  # [kg, kg m2]
TORQUE = 567.0  # M_d of (4.3.3) [N m]
START = 10 * np.pi  # speed at which its runs begin, at bottom dead centre [rad/s]


def presses() -> dict[str, Linkage]:
    """The plain, the opposed and the symmetric press under this gravity (the thesis prints none), by the names that are shipped."""
    return {f"jf75g_125{kind}": load(f"jf75g_125{kind}", gravity=(0, 0, -GRAVITY)) for kind in ("_plain", "", "_symmetric")}


def turning(press: Linkage, speed: float = SPEED) -> Reactions:
    """A turn at constant speed [rad/s]."""
    return inverse_dynamics(press, cycle(press, speed, points=POINTS))


def with_masses(press: Linkage, rod: float, counterweight: float) -> Linkage:
    """The opposed press with other masses [kg] of auxiliary rod (of the same shape) and counterweight."""
    old = {link: press.model.inertias[press.model.getJointId(joint)] for link, joint in _JOINTS.items()}
    change, lever = rod - old["auxiliary_rod"].mass, old["auxiliary_rod"].lever
    shape = old["auxiliary_rod"].inertia[1, 1] / old["auxiliary_rod"].mass
    x, y, z = (float(place) for place in lever)
    return with_counterweights(
        press,
        [
            Counterweight("auxiliary_rod", change, (x, y, z), float(shape * change)),
            Counterweight("counterweight", counterweight - old["counterweight"].mass),
        ],
    )


def weight(press: Linkage) -> float:
    """Of all that moves [N]."""
    return GRAVITY * float(sum(inertia.mass for inertia in press.model.inertias))


def clean(value: float, peak: float) -> float:
    """Zero for what is rounding beside a peak."""
    return value if abs(value) > 1e-9 * abs(peak) else 0.0


def figures(chapter: int, first: int, last: int) -> tuple[str, ...]:
    """Their numbers."""
    return tuple(f"Fig. {chapter}-{k}" for k in range(first, last + 1))


_JOINTS = {"auxiliary_rod": "P3", "counterweight": "counterweight_guide"}
