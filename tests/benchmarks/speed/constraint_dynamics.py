"""Accelerations of closed linkages, one state at a time: the null space, Pinocchio's `constraintDynamics` and its loop-aware `lcaba`.

Presses, rings in space, Cassie, and chains of 2 to 50 loops turn; random efforts act on all joints of seven states. Times are of one state.
Errors are the largest difference from the accelerations by the null space, as a share of the largest of the state. `constraintDynamics` has
the settings that `method="constraint"` chooses, with the check of each state that goes with them; `lcaba` those of `SETTINGS` that have the
smallest error, to a factor of ten, in the fewest iterations, and no check.
"""

import warnings
from collections.abc import Callable

import numpy as np
import pinocchio as pin
from benchmarks.stopwatch import least, table
from support import texts
from support.generators import large_linkages
from support.generators.spatial_linkages import bennett, bricard
from support.oracles import cassie, n_four_bar

import pinpress as pp
from pinpress.common.quantities import Array
from pinpress.engines.pinocchio.forward_dynamics import ForwardDynamics, Proximal

# mu as a share of the largest entry of J M^-1 J', and iterations
SETTINGS = [(10.0**power, iterations) for power in (-8, -6, -5, -4, -3, -2, -1) for iterations in (1, 3, 6, 10, 20, 50)]
LINKAGES: dict[str, Callable[[], pp.Linkage]] = {
    "`crank_slide`": lambda: pp.load("crank_slide"),
    "`zxn2_3000b`": lambda: pp.load("zxn2_3000b"),
    "`jf75g_125_two_point`, whose rods hold each other": lambda: pp.load("jf75g_125_two_point"),
    "Bennett": lambda: texts.load(bennett()),
    "Bricard": lambda: texts.load(bricard()),
    "Cassie": lambda: texts.load(cassie.urdf()),
}
LINKAGES |= {f"{count} four-bars in a row": lambda count=count: texts.load(n_four_bar.urdf(count)) for count in (2, 5, 10, 20, 50)}
LINKAGES |= {f"{count} loops in space": lambda count=count: texts.load(large_linkages.spatial_chain(count)) for count in (2, 5, 10, 20, 50)}

State = tuple[Array, Array, Array]
Way = Callable[[Array, Array, Array], Array]


def main(quick: bool = False) -> None:
    """Print the table."""
    linkages, settings = LINKAGES, SETTINGS
    if quick:
        linkages = {name: make for name, make in LINKAGES.items() if any(word in name for word in ("zxn2", "Cassie", "5 loops"))}
        settings = SETTINGS[20:22]
    warnings.simplefilter("ignore", pp.PinpressWarning)  # chains of 50 m
    rows = []
    for name, made in linkages.items():
        press = made()
        dynamics = press.forward_dynamics(np.zeros(press.model.nv))
        proximal = dynamics.quick
        assert proximal is not None
        with np.errstate(all="ignore"):
            states = states_of(press, 1 if quick else 7)
            truth = [dynamics.acceleration_in_null_space(*state) for state in states]
            ways = [lcaba(dynamics, proximal, *each) for each in settings]
            errors = [error(way, states, truth) for way in ways]
            best = min((k for k, each in enumerate(errors) if each <= 10 * min(errors)), key=lambda k: settings[k][1])
            quickest: list[Way] = [dynamics.acceleration_in_null_space, with_check(dynamics, proximal), ways[best]]
            works = [lambda way=way, states=states: [way(*state) for state in states] for way in quickest]
            times = [f"{1e6 * seconds / len(states):.0f}" for seconds in least(works, 1 if quick else 5)]
            off = f"{error(quickest[1], states, truth):.0e}"
        chosen = f"{settings[best][0]:.0e}, {settings[best][1]}"
        rows.append((name, press.model.nv, dynamics.point_rows, *times[:2], off, times[2], f"{errors[best]:.0e}", chosen))
    head = ("linkage", "joints", "rows", "null space [us]", "`constraintDynamics` [us]", "error", "`lcaba` [us]", "error", "mu, iterations")
    print(table(head, rows))


def states_of(press: pp.Linkage, count: int) -> list[State]:
    """Joint coordinates, rates and efforts of a few closed states."""
    rng = np.random.default_rng(0)
    swing = np.linspace(0.02, 0.1, count)
    angle = swing if len(press.drivers) == 1 else np.multiply.outer(swing, np.ones(len(press.drivers)))
    motion = pp.servo_cycle(press, angle=angle, speed=2.0 + 0 * angle, acceleration=0 * angle)
    pairs = zip(np.array(motion.joint_position), np.array(motion.v), strict=True)
    return [(x, v, 100 * rng.normal(size=len(x))) for x, v in pairs]


def with_check(dynamics: ForwardDynamics, proximal: Proximal) -> Way:
    """`constraintDynamics` as method "constraint" calls it."""

    def way(x: Array, v: Array, efforts: Array) -> Array:
        a: Array = pin.constraintDynamics(
            dynamics.model, proximal.data, x, v, efforts, proximal.points, proximal.data_of_points, proximal.settings
        )
        if not proximal.held_clearly(dynamics.lapack):
            raise ArithmeticError("a row is not held clearly")
        return a

    return way


def lcaba(dynamics: ForwardDynamics, proximal: Proximal, share: float, iterations: int) -> Way:
    points = pin.StdVec_RigidConstraintModel(list(proximal.points))
    data, data_of_points = dynamics.model.createData(), pin.StdVec_RigidConstraintData([point.createData() for point in points])
    pin.computeJointMinimalOrdering(dynamics.model, data, points)  # without it: a crash
    settings = pin.ProximalSettings(0.0, 1e-13, share * proximal.largest, iterations)

    def way(x: Array, v: Array, efforts: Array) -> Array:
        a: Array = pin.lcaba(dynamics.model, data, x, v, efforts, points, data_of_points, settings)
        return a

    return way


def error(way: Way, states: list[State], truth: list[Array]) -> float:
    """Largest error of a way, infinite where it has no answer."""
    found = max(float(np.abs(way(*state) - expected).max() / np.abs(expected).max()) for state, expected in zip(states, truth, strict=True))
    return found if np.isfinite(found) else np.inf
