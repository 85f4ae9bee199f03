"""The command line: `pinpress`, or `python -m pinpress`."""

import argparse
import io
import sys
import time
from pathlib import Path

from . import RPM, Linkage, Motion, PinpressError, Reactions, check, cycle, inverse_dynamics, load, presses
from .summary import summary

EPILOG = """\
angles are in degrees of the driver joint, 0 as the URDF draws it; forces are the action of parent on child (of a loop, of link1 on link2)
in world axes, z up; the shaking force is the action of the machine on its foundation.
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; exit code 2 with one line on stderr where the input is at fault, 1 where `check` finds errors."""
    options = _parser().parse_args(arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names may have characters that the terminal's encoding lacks
    try:
        return int(options.run(options))
    except PinpressError as error:
        print(f"pinpress: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # e.g. | head
        sys.stderr.close()
        return 0
    except KeyboardInterrupt:
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="pinpress", description="Mechanical press linkages: motion, driving torque, bearing forces.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    analyse = commands.add_parser(
        "analyse",
        help="one turn at constant speed: motion, driving torque, every bearing force",
        description="Turn a press once at constant speed. Prints a summary; with --out also writes cycle.csv (every quantity at every\n"
        "crank angle, units in the header) and recording.html (the press turning, a page to open by double click).",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    analyse.add_argument("file", metavar="FILE", help=f"URDF file, or the name of a shipped press: {', '.join(presses())}")
    analyse.add_argument("--speed", type=float, required=True, metavar="RPM", help="of the crank, in r/min; negative turns it backwards")
    analyse.add_argument("--out", type=Path, metavar="DIR", help="folder for cycle.csv and recording.html; made if it is not there")
    analyse.add_argument("--points", type=int, default=720, metavar="N", help="crank angles in the turn (default: %(default)s)")
    analyse.add_argument("--engine", choices=("auto", "plane", "pinocchio"), default="auto", help="how to compute (default: the fast one)")
    analyse.add_argument("--driver", metavar="JOINT", help="driven joint, where the URDF has no <transmission> or another is meant")
    analyse.add_argument("--slide", metavar="LINK", help="slide, where it is not the link called slide")
    analyse.set_defaults(run=_analyse)
    checked = commands.add_parser(
        "check",
        help="everything that is wrong with a URDF, odd in it, or worth knowing",
        description="List what is wrong with a URDF, with line and remedy: names, numbers, inertias, how links are connected, whether\n"
        "the loops close as drawn and the driver determines them; then what is odd in it, and what is worth knowing.",
        epilog="exit code: 0 without errors (there may be warnings), 1 with errors, 2 for wrong usage",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    checked.add_argument("file", metavar="FILE", help="URDF file, or the name of a shipped press")
    checked.add_argument("--driver", metavar="JOINT", action="append", help="driven joint; may be given several times")
    checked.add_argument("--slide", metavar="LINK", help="slide, where it is not the link called slide")
    checked.set_defaults(run=_check)
    return parser


def _check(options: argparse.Namespace) -> int:
    report = check(options.file, driver=options.driver, slide=options.slide)
    print(report)
    return 1 if report.errors else 0


def _analyse(options: argparse.Namespace) -> int:
    press = load(options.file, driver=options.driver, slide=options.slide)
    walk = time.perf_counter()
    _ = press.branch  # followed here, so that the times below are those of any further motion
    start = time.perf_counter()
    motion = cycle(press, speed=options.speed * RPM, points=options.points, engine=options.engine)
    middle = time.perf_counter()
    result = inverse_dynamics(press, motion, engine=options.engine)
    end = time.perf_counter()
    print(summary(press, motion, result))
    took = [1e3 * (until - since) for since, until in ((walk, start), (start, middle), (middle, end))]
    print(f"  {'time taken':26}{took[0]:12.1f} ms following the assembly once, {took[1]:.1f} ms motion, {took[2]:.1f} ms torque and forces")
    if options.out is not None:
        _write(options.out, press, motion, result)
    return 0


def _write(folder: Path, press: Linkage, motion: Motion, result: Reactions) -> None:
    from .recording import record

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PinpressError(f"cannot make the folder {folder}: {error.strerror}; choose another --out") from None
    result.to_csv(folder / "cycle.csv")
    record(press, motion, folder / "recording.html")
    print(f"\nwrote {folder / 'cycle.csv'} and {folder / 'recording.html'}")


if __name__ == "__main__":
    sys.exit(main())
