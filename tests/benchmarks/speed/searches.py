"""Searches for the masses of table 5-1 of Zhang 2007 beside its proved optimum: evaluations, times and what they find.

An evaluation is what it is to a program that knows nothing of the problem: the press with these masses, and the forces of a turn. The proof
makes its series from the press itself; its time has all of that. The searches themselves run on the linear combination of three such turns,
and their times are those of as many evaluations, by the time of the proof.
"""

import numpy as np
from benchmarks.stopwatch import least, ms, table
from validation.zhang2007_balancing import opposed, proved, ranges, turning, with_masses
from validation.zhang2007_search import searches


def main(quick: bool = False) -> None:
    """Print the table."""
    press = opposed()

    def evaluation() -> float:
        return float(np.ptp(turning.__wrapped__(with_masses(press, 100.0, 1000.0)).shaking_force[:, 2]))

    one, proof = least((evaluation, proved.__wrapped__), 1 if quick else 3)
    print(f"one evaluation {ms(one)} ms, the proof {ms(proof)} ms\n")
    rows = [(name, f"{s.least:.4f}", s.evaluations, f"{s.evaluations * one / proof:.1f}") for name, s in searches(ranges(press)).items()]
    print(table(("", "range [N]", "evaluations", "time by the proof's"), [*rows, ("proved optimum", f"{proved()[1]:.4f}", "", "1.0")]))
