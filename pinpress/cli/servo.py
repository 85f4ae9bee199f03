"""`pinpress servo`: find the best motion of a servo press, compare it with usual motions, and choose the smallest motor."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..common import tables
from ..common.errors import PinpressError
from ..common.files import make_folder
from ..common.results import Tabular
from ..dynamics.inputs import Inputs, of_loads, of_press, stated
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..linkage.linkage import Linkage
from ..loads.link import Load
from ..servo.drive import ServoDrive
from ..servo.limits import BearingForce, CrankAcceleration, CrankSpeed, FeedWindow, Limit, RmsTorque, SlideAcceleration, SlideSpeed
from ..servo.paths import Path as ServoPath
from ..servo.paths import Pendulum, Pulse, Stop, Turn
from .words import part_specs
from .words.forces import add_force_options, loads
from .words.outputs import add_out_option, print_inputs, say_written
from .words.press import add_press_options, load_press
from .words.units import quantity, read_quantity

if TYPE_CHECKING:
    from ..servo.comparison import MotionComparison
    from ..servo.motion_optimum import MotionOptimum
    from ..servo.sizing import MotorChoice

SERVO_DRIVE = part_specs.Kind(ServoDrive, "inertia=1.5,ratio=60,gear_inertia=50,peak_torque=2100,rated_torque=800,top_speed=2000")
PATHS: Mapping[str, part_specs.Kind[Any]] = {
    "turn": part_specs.Kind(Turn, "backwards=yes"),
    "stop": part_specs.Kind(Stop, "bottom=0.15"),
    "pendulum": part_specs.Kind(Pendulum, "opening=60mm,dwell=0.2"),
    "pulse": part_specs.Kind(Pulse, "heights=20mm/10mm/0,back=2mm"),
}
LIMITS: Mapping[str, part_specs.Kind[Any]] = {
    "slide-speed": part_specs.Kind(SlideSpeed, "speed=0.2,heights=60mm/0"),
    "crank-speed": part_specs.Kind(CrankSpeed, "speed=40"),
    "slide-acceleration": part_specs.Kind(SlideAcceleration, "acceleration=20"),
    "crank-acceleration": part_specs.Kind(CrankAcceleration, "acceleration=30"),
    "bearing-force": part_specs.Kind(BearingForce, "bearing=A,force=2MN"),
    "rms": part_specs.Kind(RmsTorque, "torque=600"),
    "feed-window": part_specs.Kind(FeedWindow, "height=150mm,time=0.8"),
}


def _explained() -> str:
    lines = [
        "--drive, the motor and its gear; all values at the motor's shaft, except gear_inertia:",
        f"  {part_specs.keys(SERVO_DRIVE)}",
        f"  e.g. --drive {SERVO_DRIVE.example}",
        "--path, the path of the crank in a cycle:",
        *tables.table(([f"{name}:", part_specs.keys(kind)] for name, kind in PATHS.items()), [20, 0]),
        "--limit; heights are two of the slide above bottom dead centre, flank is down, up or both:",
        *tables.table(([f"{name}:", part_specs.keys(kind)] for name, kind in LIMITS.items()), [20, 0]),
    ]
    return "\n".join(lines)


EPILOG = f"""\
--time is the time of a cycle in s, also as a fraction: 60/25 for 25 cycles a minute. At constant crank speed a cycle is a turn.

{_explained()}

{part_specs.explained("load", "spring")}
Give --drive, or a catalogue of --motors with --ratios to choose the smallest sufficient motor. The catalogue is a CSV file with the columns
  motor, inertia [kg m2], copper loss [W/(N m)2], speed [r/min], rated torque [N m], peak torque [N m]
and a row for each point of a motor's curves.

e.g. pinpress servo zxn2_3000b --time 60/25 --load drawing:force=1500kN,start=60mm --limit slide-speed:speed=0.2,heights=60mm/0
     --motors docs/servo_motors.csv --ratios 40,50,60,80 --gear-inertia 50 --out out --report
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `servo` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "servo",
        help="find the motion of a servo press that needs the smallest motor, with proof, and choose this motor",
        description="Find the motion of the crank with the least heat in the motor, time or energy within limits, and prove that it is\n"
        "optimal. Prints it in comparison with usual motions, with the limits that are active. With --out it also writes\n"
        "servo.csv (the motion, SI units), angle.csv and height.csv (for a controller) and comparison.csv; with --report also\n"
        "report.html, the press in this motion.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("--time", type=cycle_time, metavar="S", help="longest time of a cycle [s], see below; not needed with --minimise time")
    option(
        "--minimise",
        choices=("heat", "time", "energy", "peak"),
        default="heat",
        help="quantity to minimise: the heat in the motor, the time, the energy drawn, the largest torque (default: %(default)s)",
    )
    option("--drive", metavar="KEYS", help="motor and gear, see below")
    option("--motors", type=Path, metavar="CSV", help="catalogue to choose the smallest sufficient motor from, see below")
    option(
        "--ratios",
        type=gear_ratios,
        metavar="I,I,...",
        help="gear ratios to try; with --drive the best one replaces the ratio of the drive",
    )
    option("--gear-inertia", type=quantity("kg m2"), metavar="J", help="inertia of the gears at the crank, with --motors [kg m2]")
    option("--pause", type=quantity("s"), metavar="S", help="pause after each cycle, with --motors: the motor cools [s]")
    option("--path", metavar="KIND:KEYS", default="turn", help="path of the crank in a cycle, see below (default: %(default)s)")
    option("--limit", metavar="KIND:KEYS", action="append", default=[], help="limit, see below; may be given several times")
    add_force_options(parser, friction=False, stiffness=False)
    option("--step", type=quantity("s"), default=1e-3, metavar="S", help="step of angle.csv and height.csv (default: %(default)s s)")
    option("--points", type=int, metavar="N", help="number of steps of the path (default: 720, or more until their error is below 0.001)")
    add_press_options(parser)
    add_out_option(parser, "the files")
    option("--report", action="store_true", help="also write report.html: the press with its best motion, and charts that follow it")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the best motion in comparison with others, and write the files.

    Raises:
        PinpressError: Options do not go together, no motion keeps the limits, no motor is sufficient, or writing fails.
    """
    from ..servo.comparison import compare_motions  # imported here to save start-up time of other commands
    from ..servo.sizing import capacitor
    from ..servo.stroke_laws import ready_motions

    _refuse_what_does_not_go_together(options)
    press, acting = load_press(options), loads(options)
    press.refuse_several_drivers("the best motion needs one crank; for several drivers use pinpress analyse --motion FILE")
    path, limits = servo_path(options.path), [limit(words) for words in options.limit]
    choice = _choice(press, acting, path, limits, options) if options.motors is not None else None
    if choice is not None and choice.best is None:
        print(choice)
        raise PinpressError("no motor is sufficient: give larger motors, other --ratios, more --time or a --pause")
    best = _best(press, acting, path, limits, options) if choice is None or choice.best is None else choice.best
    motions = ready_motions(press, best.drive, acting, time=best.motion.duration, path=path, limits=limits)
    compared = compare_motions({f"least {options.minimise}": best.motion, **motions}, limits)
    if options.out is not None:
        make_folder(options.out)
    parts: list[Tabular] = [*([] if choice is None else [choice]), best, compared, capacitor(best.motion)]
    print("\n\n".join(map(str, parts)))
    print_inputs(_inputs(press, acting, options))
    if options.out is not None:
        _write(press, acting, best, compared, parts, options)
    return 0


def cycle_time(text: str) -> float:
    """Reads an option of `argparse`: a time in s, also as a fraction, 60/25."""
    above, slash, below = text.partition("/")
    try:
        return read_quantity(above, "s") / read_quantity(below, "-") if slash else read_quantity(text, "s")
    except (ValueError, ZeroDivisionError):
        raise argparse.ArgumentTypeError(f"{text!r} is not a time: give seconds, as 2.4, or 60/25 for 25 cycles a minute") from None


def gear_ratios(text: str) -> list[float]:
    """Reads an option of `argparse`: numbers with commas between them."""
    try:
        return [read_quantity(part, "-") for part in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of ratios: give numbers with commas between them, 40,60,80") from None


def servo_path(words: str) -> ServoPath:
    """Read the path of a crank from a text such as ``stop:bottom=0.15``. Raises as `part_specs.motor`."""
    made: ServoPath = part_specs.named("--path", PATHS, words)
    return made


def limit(words: str) -> Limit:
    """Read a limit of a servo motion from a text such as ``slide-speed:speed=0.2,heights=60mm/0``. Raises as `part_specs.motor`."""
    made: Limit = part_specs.named("--limit", LIMITS, words)
    return made


def _refuse_what_does_not_go_together(options: argparse.Namespace) -> None:
    if (options.drive is None) == (options.motors is None):
        raise PinpressError(f"give --drive or --motors, one of them; e.g. --drive {SERVO_DRIVE.example}")
    if options.time is None and (options.minimise != "time" or options.motors is not None):
        raise PinpressError("--time of a cycle is missing: give e.g. --time 60/25 for 25 cycles a minute")
    if options.motors is not None and options.ratios is None:
        raise PinpressError("--motors needs the gear ratios to try: give e.g. --ratios 40,60,80")
    if options.motors is not None and options.minimise != "heat":
        raise PinpressError("--motors chooses the motor by its heat: leave out --minimise, or give --drive")
    if options.drive is not None:
        for name in ("gear_inertia", "pause"):
            if getattr(options, name) is not None:
                has = ": --drive has it as a key" if name == "gear_inertia" else ": leave it out"
                raise PinpressError(f"--{name.replace('_', '-')} goes with --motors{has}")
    if options.report and options.out is None:
        raise PinpressError("--report needs a folder to write into: also give --out DIR")


def _choice(press: Linkage, acting: Sequence[Load], path: ServoPath, limits: Sequence[Limit], options: argparse.Namespace) -> MotorChoice:
    from ..servo.motors import read_motors  # to save start-up time
    from ..servo.sizing import choose_motor  # to save start-up time

    return choose_motor(
        press,
        read_motors(options.motors),
        acting,
        ratios=options.ratios,
        time=options.time,
        path=path,
        limits=limits,
        pause=options.pause or 0.0,
        gear_inertia=options.gear_inertia or 0.0,
        points=options.points,
    )


def _best(press: Linkage, acting: Sequence[Load], path: ServoPath, limits: Sequence[Limit], options: argparse.Namespace) -> MotionOptimum:
    from ..servo.optimum import best_motion  # to save start-up time

    return best_motion(
        press,
        part_specs.part("--drive", SERVO_DRIVE, options.drive),
        acting,
        minimise=options.minimise,
        time=options.time,
        path=path,
        limits=limits,
        ratios=options.ratios,
        points=options.points,
    )


def _inputs(press: Linkage, acting: Sequence[Load], options: argparse.Namespace) -> Inputs:
    """Inputs of the motion as text; path, drive and limits as given."""
    given = [("drive", options.drive), ("motors", options.motors), ("path", options.path), *(("limit", words) for words in options.limit)]
    time = [] if options.time is None else [("time", f"{options.time:.6g} s a cycle")]
    return [*of_press(press), *time, *((name, str(words)) for name, words in given if words is not None), *of_loads(acting), stated()]


def _write(
    press: Linkage,
    acting: Sequence[Load],
    best: MotionOptimum,
    compared: MotionComparison,
    parts: Sequence[Tabular],
    options: argparse.Namespace,
) -> None:
    """Write the files, and print their names."""
    from ..servo.controller import controller_table  # to save start-up time

    folder: Path = options.out
    best.to_csv(folder / "servo.csv")
    for of in ("angle", "height"):
        controller_table(best.motion, of, step=options.step).to_csv(folder / f"{of}.csv")
    compared.to_csv(folder / "comparison.csv")
    written = ["servo.csv", "angle.csv", "height.csv", "comparison.csv"]
    if options.report:
        from ..visual.reports.report import report  # Plotly is optional, and slow to import

        # with all bearings, of which the optimum has only those with a limit
        reactions = inverse_dynamics(press, best.motion.motion, acting)
        report(press, best.motion.motion, folder / "report.html", reactions=reactions, results=parts)
        written.append("report.html")
    say_written(folder, written)
