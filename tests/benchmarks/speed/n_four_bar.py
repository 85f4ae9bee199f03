"""The N-four-bar benchmark to 10 s: errors against its exact motion, and run times.

Run `python tests/benchmarks/speed/n_four_bar.py`. pytest does not collect this file. Times are the least of five, from the loaded
assembly, whose branch has been followed through its singular poses, to a `Run` of eleven states.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.stopwatch import least as least_seconds
from benchmarks.stopwatch import once
from support.oracles import n_four_bar

import pinpress as pp


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    for count, methods in ((1, ("reduced", "constraint")), (2, ("reduced", "constraint")), (40, ("reduced",))):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "assembly.urdf"
            file.write_text(n_four_bar.urdf(count), encoding="utf-8")
            press = pp.load(file)
        _, followed = once(lambda press=press: press.branch_through_change_points)
        print(f"N = {count}: {len(press.joints)} joints; branch followed once, {1e3 * followed:.0f} ms")
        for method in methods:

            def work(press: pp.Linkage = press, method: str = method) -> pp.Run:
                return pp.simulate(press, 10.0, speed=n_four_bar.SPEED, points=11, method=method)

            run, (seconds,) = work(), least_seconds([work], 5)
            known = n_four_bar.EXACT.get(count, {}).items()
            errors = [abs(run.crank_angle[second] - angle) for second, (angle, _) in known]
            worst = f", angles to {max(errors):.1e} rad" if errors else ""
            print(f"  {method:10} {1e3 * seconds:7.1f} ms, energy {run.stats.energy_error:.1e}{worst}")


if __name__ == "__main__":
    main()
