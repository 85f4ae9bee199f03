"""`pinpress analyse`: one period at constant speed."""

import argparse
import time
from pathlib import Path

from ..common.errors import PinpressError
from ..common.files import make_folder
from ..common.units import RPM
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..dynamics.summary import summary
from ..kinematics.motion import cycle
from ..linkage.linkage import Linkage
from ..linkage.loading import load
from ..visual.overlays import traced
from .options import DRIVER, FILE, SIGNS, SLIDE, TRACE, trace, write_pages

POINTS = 720  # of a turn


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `analyse` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "analyse",
        help="one turn at constant speed: motion, driving torque, every bearing force",
        description="Turn a press through one period at constant speed: one turn of the crank, or as many as it takes until gears are\n"
        "back. Prints a summary; with --out also writes cycle.csv (every quantity at every crank angle, units in the header) and\n"
        "recording.html (the press turning with its forces, a page to open by double click); with --report also report.html,\n"
        "which has the curves that matter beside the press.",
        epilog=SIGNS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("file", metavar="FILE", help=FILE)
    option("--speed", type=float, required=True, metavar="RPM", help="of the crank, in r/min; negative turns it backwards")
    option("--out", type=Path, metavar="DIR", help="folder for the files; made if it is not there")
    option("--report", action="store_true", help="also write report.html: the recording and charts that follow it")
    option("--before", metavar="FILE", help="another press, drawn beside this one in the report at the same speed")
    option("--trace", type=trace, action="append", default=[], metavar="LINK:X,Y,Z", help=TRACE)
    option("--points", type=int, metavar="N", help=f"crank angles, in all (default: {POINTS} a turn)")
    option("--engine", choices=("auto", "plane", "pinocchio"), default="auto", help="how to compute (default: the fast one)")
    option("--driver", metavar="JOINT", help=DRIVER)
    option("--slide", metavar="LINK", help=SLIDE)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the summary and write the files.

    Raises:
        PinpressError: options that do not go together, and whatever computing and writing raise.
    """
    if options.out is None and (options.report or options.trace):
        raise PinpressError(f"--{'report' if options.report else 'trace'} needs a folder to write into: give --out DIR too")
    if options.before is not None and not options.report:
        raise PinpressError("--before is for the report: give --report too")
    press = load(options.file, driver=options.driver, slide=options.slide)
    _ = traced(press, options.trace)  # a wrong one is found before the work
    walk = time.perf_counter()
    _ = press.branch  # followed here, so that the times below are those of any further motion
    start = time.perf_counter()
    motion = cycle(press, speed=options.speed * RPM, points=_points(press, options), engine=options.engine)
    middle = time.perf_counter()
    result = inverse_dynamics(press, motion, engine=options.engine)
    end = time.perf_counter()
    print(summary(press, motion, result))
    took = [1e3 * (until - since) for since, until in ((walk, start), (start, middle), (middle, end))]
    print(f"  {'time taken':26}{took[0]:12.1f} ms following the assembly once, {took[1]:.1f} ms motion, {took[2]:.1f} ms torque and forces")
    if options.out is not None:
        before = None if options.before is None else _before(options)
        make_folder(options.out)
        result.to_csv(options.out / "cycle.csv")
        write_pages(press, result, options.out, ["cycle.csv"], options.report, options.trace, before)
    return 0


def _before(options: argparse.Namespace) -> Reactions:
    press = load(options.before)
    return inverse_dynamics(press, cycle(press, speed=options.speed * RPM, points=_points(press, options)))


def _points(press: Linkage, options: argparse.Namespace) -> int:
    return options.points if options.points is not None else POINTS * press.period_turns
