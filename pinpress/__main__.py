"""The command line: `pinpress`, or `python -m pinpress`."""

import argparse
import io
import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from . import (
    RPM,
    Linkage,
    PinpressError,
    Reactions,
    Run,
    check,
    cycle,
    inverse_dynamics,
    load,
    presses,
    scene_words,
    simulate,
    steady_state,
)
from .scene_words import DRIVES, LOADS, keys
from .simulation_summary import simulation_summary, stroke_columns
from .summary import summary
from .tables import write_csv

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
    _add_simulate(commands)
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


def _add_simulate(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    simulated = commands.add_parser(
        "simulate",
        help="let a press run under motor, flywheel and process load",
        description="Let a press run under drive, flywheel and process loads, or find its steady state. Prints speeds, energies, the\n"
        "motor's torque, the strokes and the peak force of every bearing; with --out also writes simulation.csv (every quantity at every\n"
        "instant), strokes.csv (one line a stroke, SI units) and recording.html (the press turning, a page to open by double click).",
        epilog=_scene_help(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = simulated.add_argument
    add("file", metavar="FILE", help=f"URDF file, or the name of a shipped press: {', '.join(presses())}")
    add("--speed", type=float, default=0.0, metavar="RPM", help="of the crank at the start, or about that of the steady state, in r/min")
    add("--angle", type=float, default=0.0, metavar="DEG", help="of the crank at the start (default: 0, as the URDF draws it)")
    until = simulated.add_mutually_exclusive_group(required=True)
    until.add_argument("--duration", type=float, metavar="S", help="how long it runs, in s")
    until.add_argument("--steady", action="store_true", help="a period of the steady state near --speed")
    add("--drive", metavar="KIND:KEYS", help="what turns the crank, see below (default: nothing)")
    add(
        "--flywheel",
        metavar="J",
        help="its inertia at the driver joint, in kg m2; inertia=J,speed=RPM where it turns before a clutch closes",
    )
    add("--load", metavar="KIND:KEYS", action="append", default=[], help="process load, see below; may be given several times")
    add("--clutch", metavar="KEYS", help="between flywheel and crank, see below")
    add("--brake", metavar="KEYS", help="on the crank, see below")
    add("--method", choices=("reduced", "constraint"), default="reduced", help="how to compute (default: the fast one)")
    add("--step", type=float, metavar="S", help="fixed step of integration, in s (default: steps by error)")
    add("--tolerance", type=float, default=1e-11, metavar="T", help="of the error of a step, relative (default: %(default)g)")
    add("--points", type=int, metavar="N", help="states in the results (default: 120 a turn, at least 120)")
    add("--gravity", type=float, default=9.81, metavar="G", help="downwards, in m/s2 (default: %(default)s)")
    add("--driver", metavar="JOINT", help="driven joint, where the URDF has no <transmission> or another is meant")
    add("--slide", metavar="LINK", help="slide, where it is not the link called slide")
    add("--out", type=Path, metavar="DIR", help="folder for the three files; made if it is not there")
    simulated.set_defaults(run=_simulate)


def _scene_help() -> str:
    kinds = [f"  {name + ':':13}{keys(kind)}" for name, kind in (*DRIVES.items(), *LOADS.items())]
    split = len(DRIVES)
    return "\n".join(
        [
            "drives, keys in brackets may be left out; SI units, but speeds in r/min; with ratio= they act on the crank through gears:",
            *kinds[:split],
            "loads, heights are slide positions above bottom dead centre, or above the slide position datum=:",
            *kinds[split:],
            "clutch and brake, switched at a time or a crank angle:",
            f"  {keys(scene_words.CLUTCH)}",
            "e.g. --flywheel 2000 --load blanking:" + LOADS["blanking"].example,
            "     --drive induction:" + DRIVES["induction"].example,
            "files are CSV, two columns: "
            + "; ".join(f"{name} {', '.join(kind.table.columns)}" for name, kind in (*DRIVES.items(), *LOADS.items()) if kind.table),
            "",
            EPILOG,
        ]
    )


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
        _make(options.out)
        result.to_csv(options.out / "cycle.csv")
        _record(press, result, options.out, ["cycle.csv"])
    return 0


def _simulate(options: argparse.Namespace) -> int:
    drive = None if options.drive is None else scene_words.drive(options.drive)
    flywheel = None if options.flywheel is None else scene_words.flywheel(options.flywheel)
    loads = [scene_words.load(words) for words in options.load]
    clutch = None if options.clutch is None else scene_words.clutch(options.clutch)
    brake = None if options.brake is None else scene_words.brake(options.brake)
    press = load(options.file, driver=options.driver, slide=options.slide, gravity=(0.0, 0.0, -options.gravity))
    if len(press.drivers) > 1:
        raise PinpressError(f"{press.name} has {len(press.drivers)} drivers: the command takes one; simulate it in Python")
    if options.out is not None:
        _make(options.out)  # before a run that may be long
    speed, angle, shared = options.speed * RPM, math.radians(options.angle), {"points": options.points, "tolerance": options.tolerance}
    run: Run
    if options.steady:
        _refuse_beside_steady(options)
        run = steady_state(press, speed, drive, flywheel, loads, angle, **shared)  # type: ignore[arg-type]  # it refuses what has none
    else:
        with _progress(options.duration) as progress:
            run = simulate(
                press,
                options.duration,
                speed,
                angle,
                drive,
                flywheel,
                loads,
                options.method,
                clutch,
                brake,
                step=options.step,
                progress=progress,
                **shared,
            )
    began = time.perf_counter()
    result = inverse_dynamics(press, run, loads=loads)
    took = time.perf_counter() - began
    print(simulation_summary(press, run, result, _scene(options, run), options.steady))
    print(f"  {'time taken':26}{1e3 * run.stats.wall_time:12.1f} ms simulation, {1e3 * took:.1f} ms torque and forces")
    if options.out is not None:
        result.to_csv(options.out / "simulation.csv")
        write_csv(options.out / "strokes.csv", stroke_columns(run))
        _record(press, result, options.out, ["simulation.csv", "strokes.csv"])
    return 0


def _refuse_beside_steady(options: argparse.Namespace) -> None:
    for name, absent in (("clutch", None), ("brake", None), ("step", None), ("method", "reduced")):
        if getattr(options, name) != absent:
            raise PinpressError(f"--{name} does not go with --steady: leave it out, or give --duration in place of --steady")
    if options.speed == 0:
        raise PinpressError("--steady needs a --speed other than 0, about which the press runs, e.g. --speed 70")


def _scene(options: argparse.Namespace, run: Run) -> list[tuple[str, str]]:
    """What was asked for, in the words in which it was."""
    angle = f"crank angle {options.angle:g} deg"
    if options.steady:
        begin = ("looked for near", f"{options.speed:g} r/min, from {angle} on")
    else:  # a drive may have prescribed the speed
        begin = ("from", f"{angle}, {run.crank_speed[0] / RPM:g} r/min")
    asked = [("drive", options.drive), ("flywheel", options.flywheel), *(("load", words) for words in options.load)]
    asked += [("clutch", options.clutch), ("brake", options.brake)]
    return [begin, *((name, words) for name, words in asked if words is not None)]


@contextmanager
def _progress(duration: float) -> Iterator[Callable[[float], None] | None]:
    """A bar on a terminal, once the run takes longer than a second; elsewhere nothing."""
    if not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    shape = "{percentage:3.0f} % |{bar}| {n:.3f} of {total:.3f} s, {remaining} to go"
    with tqdm(total=duration, file=sys.stderr, delay=1.0, miniters=0, leave=False, bar_format=shape) as bar:
        yield lambda reached: bar.update(reached - bar.n)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PinpressError(f"cannot make the folder {folder}: {error.strerror}; choose another --out") from None


def _record(press: Linkage, result: Reactions, folder: Path, written: list[str]) -> None:
    """Record what moved, and say what has been written."""
    from .recording import record

    record(press, result.motion, folder / "recording.html")
    *first, last = (str(folder / name) for name in (*written, "recording.html"))
    print(f"\nwrote {', '.join(first)} and {last}")


if __name__ == "__main__":
    sys.exit(main())
