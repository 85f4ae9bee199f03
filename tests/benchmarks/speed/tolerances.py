"""Tolerances: times of samples of presses, clearances, heat and budgets, and their errors against presses that are made anew; how many of
other samples are in a band.

python tests/benchmarks/speed/tolerances.py

Times are those of the processor, the least of several runs.
"""

import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks import stopwatch

import pinpress as pp
from pinpress.derivatives import pivot_positions, reshaped
from pinpress.kinematics.poses import poses
from pinpress.pin_table.templates import template

ROOT = Path(__file__).resolve().parents[3]
RUNS = 5
COMPARED = 50  # presses that are made anew
OTHERS = 200  # other samples, of SMALL presses each
SMALL = 5000
tol = pp.tolerances


def least_time(call, runs: int = RUNS) -> float:
    """Seconds of the processor."""
    return stopwatch.least([call], runs)[0]


def made_anew(press: pp.Linkage, found: tol.DeadCentreScatter, k: int) -> pp.Linkage:
    """Press k of a sample."""
    at = pivot_positions(press)
    for part, deviation in zip(found.parts, found.deviations[:, k], strict=True):
        for key, vector in part.direction.items():
            at[key] = at[key] + deviation * np.asarray(vector)
    return reshaped(press, at)


QUICK = {"RUNS": 1, "COMPARED": 50, "OTHERS": 1}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    press = pp.load("zxn2_3000b")
    parts = tol.read_dimensions(press, ROOT / "docs" / "zxn2_dimensions.csv").parts
    of_dead_centres(press, parts)
    in_operation(press)
    in_space()
    on_two_points()


def of_dead_centres(press: pp.Linkage, parts: Sequence[tol.Dimension]) -> None:
    found = tol.bottom_dead_centre(press, parts)
    heights = found.height.nominal + found.height.deviation
    print(f"{press.name}, {len(parts)} dimensions")
    both = least_time(lambda: tol.bottom_dead_centre(press, parts))
    more = least_time(lambda: tol.bottom_dead_centre(press, parts, forces={0.006: 3e6}))
    told("100 000 presses, both dead centres and the stroke", both, "s")
    told("torque at a height, beside", more - both, "s")
    few = least_time(lambda: tol.bottom_dead_centre(press, parts, samples=1000))
    told("1000 presses: what does not grow with their number", few, "s")
    told("cheapest tolerances, three targets", least_time(lambda: allocated(press, parts)), "s")
    others, seconds = stopwatch.once(lambda: [pp.dead_centres(made_anew(press, found, k)).bottom_position for k in range(COMPARED)])
    one = seconds / len(others)
    told("one press made anew, with its dead centres", 1e3 * one, f"ms, times 100 000: {1e5 * one / 60:.0f} min")
    told(f"largest difference of {COMPARED} of them", np.abs(heights[:COMPARED] - others).max(), "m")
    low, high = found.height.band(0.95)
    inside = []
    for seed in range(1, OTHERS + 1):
        deviation = tol.bottom_dead_centre(press, parts, samples=SMALL, seed=seed).height.deviation
        inside.append(np.mean((deviation >= low) & (deviation <= high)))
    spread = f"(+/- {100 * np.std(inside):.2f} a sample)"
    told(f"band of 95 %: presses of {OTHERS} other samples in it", 100 * np.mean(inside), f"% {spread}")


def in_operation(press: pp.Linkage) -> None:
    """Clearances, heat and the budget, beside pins displaced and links lengthened in the linkage."""
    turn, pins = pp.cycle(press, 70 * pp.RPM), dict.fromkeys("ABCDEF", 50e-6)
    warm, friction = tol.Temperatures({"rocker": 10.0, "rod": 10.0}), dict.fromkeys("ABCDEF", pp.loads.Friction(0.05, 0.1))
    springs = pp.elasticity.Stiffness(dict.fromkeys("ABCDEF", 2e9), shaft=3e7, frame=4e9)
    speeds = [10 * pp.RPM, 70 * pp.RPM]
    told("play over a turn of 360 states, six pins", 1e3 * least_time(lambda: tol.play(press, turn, pins)), "ms")
    told("  with friction", 1e3 * least_time(lambda: tol.play(press, turn, pins, friction=friction)), "ms")
    told("play over ten speeds", 1e3 * least_time(lambda: tol.play_over_speeds(press, pins, speed=np.linspace(1.0, 7.0, 10))), "ms")
    told("heat", 1e3 * least_time(lambda: tol.heat(press, warm)), "ms")
    given = {"clearance": pins, "stiffness": springs, "temperatures": warm, "process": 5e5}
    told("budget of two speeds, cold and warm", 1e3 * least_time(lambda: tol.budget(press, speeds=speeds, **given)), "ms")

    at_bottom = pp.servo_cycle(press, [pp.dead_centres(press).bottom_angle], speed=0.0)
    play = tol.play(press, at_bottom, pins)
    moved = pp.dead_centres(reshaped(press, displaced_pins(press, at_bottom, pins))).bottom_position
    exact = moved - pp.dead_centres(press).bottom_position
    told("play at bottom dead centre, less pins displaced in it", 1e6 * (play.offset[0] - exact), f"um of {1e6 * exact:.1f} um")
    grown = {key: place * (1 + 12e-6 * 10.0) if key[1] in warm.rise else place for key, place in pivot_positions(press).items()}
    exact = pp.dead_centres(reshaped(press, grown)).bottom_position - pp.dead_centres(press).bottom_position
    told("heat, less links lengthened in it", 1e6 * (tol.heat(press, warm).bottom_shift - exact), f"um of {1e6 * exact:.1f} um")


def displaced_pins(press: pp.Linkage, motion: pp.Motion, clearance: Mapping[str, float]) -> dict[tuple[str, str], np.ndarray]:
    """Positions of pivots with every parent's bearing moved against the force on its child, in the one state of a motion."""
    forces, at, found = pp.inverse_dynamics(press, motion).bearing_force, pivot_positions(press), {}
    rotation = poses(press, motion.joint_position).rotation
    for (name, link), place in at.items():
        joint = press.bearings.index(name)
        parent = int(press.model.parents[joint + 1]) if joint < len(press.joints) else press.loops[joint - len(press.joints)].joint1
        if name in clearance and link == press.link_of(parent):
            force = forces[name][0] * [1, 0, 1]
            found[name, link] = place - clearance[name] * rotation[parent][0].T @ force / np.linalg.norm(force)
    return found


def in_space() -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "rssp.yaml"
        file.write_bytes(template("rssp"))
        press = pp.build(file)
    parts = [
        *(tol.link_length(press, *pins, 50e-6) for pins in (("O", "B_cross"), ("B", "S"))),
        *(tol.pin_position(press, "O", axis, 50e-6) for axis in "xyz"),
        *(tol.pin_position(press, "slide_guide", axis, 50e-6) for axis in "xy"),
    ]
    found = tol.bottom_dead_centre(press, parts)
    print(f"{press.name}, in space, {len(parts)} dimensions")
    told("100 000 presses, both dead centres and the stroke", least_time(lambda: tol.bottom_dead_centre(press, parts), 3), "s")
    others, seconds = stopwatch.once(lambda: [pp.dead_centres(made_anew(press, found, k)).bottom_position for k in range(COMPARED // 5)])
    one = seconds / len(others)
    told("one press made anew, with its dead centres", 1e3 * one, f"ms, times 100 000: {1e5 * one / 60:.0f} min")
    heights = found.height.nominal + found.height.deviation[: len(others)]
    told(f"largest difference of {len(others)} of them", np.abs(heights - others).max(), "m")


def on_two_points() -> None:
    press, single = pp.load("jf75g_125_two_point"), pp.load("jf75g_125")
    parts = {
        f"P4_{side}": [
            tol.link_length(press, "O", f"P2_{side}", 10e-6, name=f"throw {side}"),
            tol.link_length(press, f"P2_{side}", f"P4_{side}", 20e-6, name=f"rod {side}"),
            tol.pin_position(press, "O", "z", 10e-6, name=f"seat {side}"),
            tol.Dimension(f"indexing {side}", {(f"P2_{side}", "crank"): (0.0, 0.0, 0.015)}, np.radians(0.02), unit="rad"),
        ]
        for side in ("front", "back")
    }
    found = tol.parallelism(press, parts)
    slope = found.slopes[1]
    print(f"{press.name}, slopes by {len(slope.parts)} dimensions")
    told("100 000 presses, chain by chain", least_time(lambda: tol.parallelism(press, parts)), "s")
    told("1000 presses: what does not grow with their number", least_time(lambda: tol.parallelism(press, parts, samples=1000)), "s")
    told("standard deviation of the sample", 1e6 * slope.sd, f"um/m, to first order {1e6 * slope.first_order_sd:.2f}")
    pivots = {"throw": ("P2", "crank"), "rod": ("P4", "main_rod"), "seat": ("O", "frame"), "indexing": ("P2", "crank")}
    at, angle = pivot_positions(single), pp.dead_centres(press).bottom_angle
    along = {"seat": np.array([0.0, 0.0, 1.0]), "indexing": np.array([0.0, 0.0, 0.015])}
    worst = 0.0
    for k in range(COMPARED // 5):
        ends = []
        for side in ("front", "back"):
            moved = {key: at[key].copy() for key in pivots.values()}
            for what, key in pivots.items():
                deviation = found.deviations[[part.name for part in slope.parts].index(f"{what} {side}"), k]
                moved[key] += deviation * along.get(what, at[key] / (np.linalg.norm(at[key]) or 1.0))
            ends.append(pp.servo_cycle(reshaped(single, moved), [angle], speed=0.0).slide_position[0])
        worst = max(worst, abs((ends[1] - ends[0]) / np.ptp(found.places[:, 1]) - slope.deviation[k]))
    told(f"largest difference of {COMPARED // 5} presses, chains made anew", worst, "m/m")


def told(what: str, value: float, unit: str) -> None:
    """Print a line."""
    print(f"  {what:52}{f'{value:.3f}' if abs(value) >= 5e-4 or not value else f'{value:.1e}':>9} {unit}")


def allocated(press: pp.Linkage, parts) -> tol.AllocatedTolerances:
    return tol.allocate(press, parts, None, {"height": 5e-5, "top": 2.5e-4, "stroke": 2.3e-4})


if __name__ == "__main__":
    main()
