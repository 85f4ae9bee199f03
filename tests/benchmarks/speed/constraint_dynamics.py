"""Accelerations of closed linkages, one state at a time: the null space, Pinocchio's `constraintDynamics` and its loop-aware `lcaba`.

Run `python tests/benchmarks/speed/constraint_dynamics.py`. pytest does not collect this file. Presses, rings in space, Cassie, and
chains of 2 to 50 loops turn; random efforts act on all joints of seven states. Times are those of the processor for one state, the least
of several turns, which the three take one after the other. Errors are the largest difference from the accelerations by the null space, as a
share of the largest of the state. `constraintDynamics` has the settings that `method="constraint"` chooses, with the check of each state
that goes with them; `lcaba` those of `SETTINGS` that have the smallest error, to a factor of ten, in the fewest iterations, and no check.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pinocchio as pin

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks import stopwatch
from support import texts
from support.generators import large_linkages
from support.generators.spatial_linkages import bennett, bricard
from support.oracles import cassie, n_four_bar

import pinpress as pp
from pinpress.common.quantities import Array
from pinpress.engines.pinocchio.forward_dynamics import ForwardDynamics, Proximal

STATES, TURNS = 7, 5
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
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    if quick:
        few = {name: make for name, make in LINKAGES.items() if any(word in name for word in ("zxn2", "Cassie", "5 loops"))}
        globals().update({"STATES": 1, "TURNS": 1, "SETTINGS": SETTINGS[20:22], "LINKAGES": few})
    warnings.simplefilter("ignore", pp.PinpressWarning)  # chains of 50 m
    print("| linkage | joints | rows | null space [us] | `constraintDynamics` [us] | error | `lcaba` [us] | error | mu, iterations |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|---|")
    for name, made in LINKAGES.items():
        press = made()
        dynamics = press.forward_dynamics(np.zeros(press.model.nv))
        proximal = dynamics.quick
        assert proximal is not None
        with np.errstate(all="ignore"):
            states = states_of(press)
            truth = [dynamics.acceleration_in_null_space(*state) for state in states]
            ways: list[Way] = [dynamics.acceleration_in_null_space, with_check(dynamics, proximal)]
            chosen, loop_aware = quickest_of_the_best(dynamics, proximal, states, truth)
            seconds = least([*ways, loop_aware], states)
            errors = [error(way, states, truth) for way in (ways[1], loop_aware)]
        times = [f"{1e6 * each:.0f}" for each in seconds]
        print(
            f"| {name} | {press.model.nv} | {dynamics.point_rows} | {times[0]} | {times[1]} | {errors[0]:.0e}"
            f" | {times[2]} | {errors[1]:.0e} | {chosen[0]:.0e}, {chosen[1]} |",
            flush=True,
        )


def states_of(press: pp.Linkage) -> list[State]:
    """Joint coordinates, rates and efforts of a few closed states."""
    drivers, rng = len(press.drivers), np.random.default_rng(0)
    swing = np.multiply.outer(np.linspace(0.02, 0.1, STATES), np.ones(drivers))
    at = swing[:, 0] if drivers == 1 else swing
    motion = pp.servo_cycle(press, angle=at, speed=2.0 + 0 * at, acceleration=0 * at)
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


def quickest_of_the_best(
    dynamics: ForwardDynamics, proximal: Proximal, states: list[State], truth: list[Array]
) -> tuple[tuple[float, int], Way]:
    """The settings of `lcaba`, and a function that calls it with them."""
    ways = [lcaba(dynamics, proximal, *settings) for settings in SETTINGS]
    errors = [error(way, states, truth) for way in ways]
    least_error = min(errors)
    good = [k for k, each in enumerate(errors) if each <= 10 * least_error]
    best = min(good, key=lambda k: SETTINGS[k][1])
    return SETTINGS[best], ways[best]


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


def least(ways: list[Way], states: list[State]) -> list[float]:
    """Least processor time of each way for a state [s]."""

    def all_states(way: Way) -> None:
        for state in states:
            way(*state)

    return [seconds / len(states) for seconds in stopwatch.least([partial(all_states, way) for way in ways], TURNS)]


if __name__ == "__main__":
    main()
