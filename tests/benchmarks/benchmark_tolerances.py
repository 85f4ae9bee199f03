"""Tolerances: time of a sample of presses, its error against presses that are made anew, and how many of other samples are in a band.

python tests/benchmarks/benchmark_tolerances.py

Times are those of the processor, the least of several runs.
"""

import time
from pathlib import Path

import numpy as np

import pinpress as pp
from pinpress.derivatives import pivot_positions, reshaped

ROOT = Path(__file__).resolve().parents[2]
RUNS = 5
COMPARED = 50  # presses that are made anew
OTHERS = 200  # other samples, of SMALL presses each
SMALL = 5000
tol = pp.tolerances


def least_time(call, runs: int = RUNS) -> float:
    """Seconds of the processor."""
    found = []
    for _ in range(runs):
        start = time.process_time()
        call()
        found.append(time.process_time() - start)
    return min(found)


def made_anew(press: pp.Linkage, found: tol.DeadCentreScatter, k: int) -> pp.Linkage:
    """Press k of a sample."""
    at = pivot_positions(press)
    for part, deviation in zip(found.parts, found.deviations[:, k], strict=True):
        for key, vector in part.direction.items():
            at[key] = at[key] + deviation * np.asarray(vector)
    return reshaped(press, at)


def main() -> None:
    press = pp.load("zxn2_3000b")
    parts = tol.read_dimensions(press, ROOT / "docs" / "zxn2_dimensions.csv").parts
    found = tol.bottom_dead_centre(press, parts)
    heights = found.height.nominal + found.height.deviation
    print(f"{press.name}, {len(parts)} dimensions")
    both = least_time(lambda: tol.bottom_dead_centre(press, parts))
    more = least_time(lambda: tol.bottom_dead_centre(press, parts, forces={0.006: 3e6}))
    print(f"  100 000 presses, both dead centres and the stroke   {both:8.3f} s")
    print(f"  torque at a height, beside                          {more - both:8.3f} s")
    few = least_time(lambda: tol.bottom_dead_centre(press, parts, samples=1000))
    print(f"  1000 presses: what does not grow with their number  {few:8.3f} s")
    print(f"  cheapest tolerances, three targets                  {least_time(lambda: allocated(press, parts)):8.3f} s")
    start = time.process_time()
    others = [pp.dead_centres(made_anew(press, found, k)).bottom_position for k in range(COMPARED)]
    one = (time.process_time() - start) / COMPARED
    print(f"  one press made anew, with its dead centres          {1e3 * one:8.3f} ms, times 100 000: {1e5 * one / 60:.0f} min")
    print(f"  largest difference of {COMPARED} of them                   {np.abs(heights[:COMPARED] - others).max():8.1e} m")
    low, high = found.height.band(0.95)
    inside = []
    for seed in range(1, OTHERS + 1):
        deviation = tol.bottom_dead_centre(press, parts, samples=SMALL, seed=seed).height.deviation
        inside.append(np.mean((deviation >= low) & (deviation <= high)))
    spread = f"(+/- {100 * np.std(inside):.2f} a sample)"
    print(f"  band of 95 %: presses of {OTHERS} other samples in it     {100 * np.mean(inside):8.2f} % {spread}")


def allocated(press: pp.Linkage, parts) -> tol.AllocatedTolerances:
    return tol.allocate(press, parts, None, {"height": 5e-5, "top": 2.5e-4, "stroke": 2.3e-4})


if __name__ == "__main__":
    main()
