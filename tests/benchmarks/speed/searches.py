"""Searches for the masses of table 5-1 of Zhang 2007 beside its proved optimum: evaluations, times and what they find.

python tests/benchmarks/speed/searches.py

An evaluation is what it is to a program that knows nothing of the problem: the press with these masses, and the forces of a turn. The
proof makes its series from the press itself; its time has all of that. The searches themselves run on the linear combination of three such
turns, and their times are those of as many evaluations, by the time of the proof.
"""

import sys
from pathlib import Path

import numpy as np

import pinpress as pp

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.stopwatch import least as least_seconds
from validation.zhang2007_balancing import opposed, proved, ranges, turning, with_masses
from validation.zhang2007_search import searches

REPEATED = 3


QUICK = {"REPEATED": 1}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    press = opposed()

    def evaluation() -> float:
        return float(np.ptp(turning.__wrapped__(with_masses(press, 100.0, 1000.0)).shaking_force[:, 2]))

    one, proof = least_seconds((evaluation, proved.__wrapped__), REPEATED)
    print(f"pinpress {pp.__version__}; one evaluation {1e3 * one:.2f} ms, the proof {1e3 * proof:.2f} ms")
    print(f"{'':28}{'range [N]':>12}{'evaluations':>13}{'by the proof':>14}")
    for name, found in searches(ranges(press)).items():
        print(f"{name:28}{found.least:12.4f}{found.evaluations:13d}{found.evaluations * one / proof:14.1f}")
    print(f"{'proved optimum':28}{proved()[1]:12.4f}{'':>13}{1.0:14.1f}")


if __name__ == "__main__":
    main()
