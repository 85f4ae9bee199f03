"""`pinpress analyse`: compute one period at constant speed, or a motion from a table."""

import argparse
import time

import numpy as np

from ..common.errors import PinpressError, SimulationError
from ..common.files import make_folder
from ..common.outlets.described import Figure, Section
from ..common.outlets.text import entries, written
from ..common.quantities import RPM, quantity
from ..common.results import Tabular
from ..drives.protocol import Drive
from ..drives.transmission import Flywheel, PrescribedSpeed
from ..dynamics.driving_energy import driving_energy
from ..dynamics.inputs import described, inputs
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..linkage.linkage import Linkage
from ..ratings.permissible_force import capacities_in_words
from ..simulation.described import run as sections_of
from ..simulation.run import Run
from ..simulation.steady_state import steady_state
from ..visual.recording import traced
from .ratings import permitted
from .report import POINTS, add_before_option, add_nominal_options, add_points_option, permissible, press_before
from .words import part_specs, units
from .words.forces import add_flywheel_option, add_force_options, forces
from .words.motions import add_motion_options, motion_of, refuse_beside_motion
from .words.outputs import SIGNS, add_page_options, print_inputs, refuse_pages_without_folder, write_pages
from .words.press import add_press_options, load_press

EXAMPLE = "e.g. pinpress analyse zxn2_3000b --speed 70 --load drawing:force=1500kN,start=40mm --out out --report"


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `analyse` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "analyse",
        help="driving torque and all bearing forces over a period or a motion from a table, under loads and friction",
        description="Turn a press through one period at constant speed: one turn of the crank, or with gears the number of turns after\n"
        "which the press repeats itself. Or with --motion move one or several drivers by a table. Prints a summary;\n"
        "with --out also writes cycle.csv (every quantity in every state, units in the header) and recording.html (the press turning\n"
        "with its forces, a page to open by double click); with --report also report.html (the press with charts).",
        epilog=f"{part_specs.explained('load', 'spring', 'friction', 'motor')}\n{SIGNS}\n\n{EXAMPLE}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_motion_options(parser)
    add_force_options(parser)
    add_nominal_options(parser)
    add_flywheel_option(parser, "prints its drop of speed at a constant motor torque")
    option(
        "--speed-drop",
        type=units.quantity("-"),
        metavar="D",
        help="drop of the flywheel's speed, e.g. 0.1; prints the inertia for this drop",
    )
    option("--motor", metavar="KIND:KEYS", help="motor, see below; prints the steady state under it, with loads and flywheel")
    add_page_options(parser, "the files")
    add_before_option(parser)
    add_points_option(parser)
    option(
        "--engine",
        choices=("auto", "plane", "space", "pinocchio"),
        default="auto",
        help="method of computation (default: the fastest that can be used)",
    )
    add_press_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the summary and write the files.

    Raises:
        PinpressError: Options do not go together, or computing or writing fails.
    """
    refuse_pages_without_folder(options)
    if options.before is not None and not options.report:
        raise PinpressError("--before is for the report: also give --report")
    refuse_beside_motion(options, "nominal_force", "nominal_height", "flywheel", "speed_drop", "motor")
    press = load_press(options)
    _ = traced(press, options.trace)  # refuse a wrong point before the work
    flywheel, motor = _driving(press, options)
    reactions, times = _computed(press, options)
    before = None if options.before is None else press_before(options)
    ratings = permissible(press, options)
    results: list[Tabular] = [] if ratings is None else [ratings]
    more: list[str] = []
    if any(given is not None for given in (flywheel, options.speed_drop, motor)):
        more += _of_flywheel(reactions, flywheel, options.speed_drop)
    if motor is not None:
        steady, words = _of_motor(reactions, motor, flywheel)
        more += words
        results += [] if steady is None else [steady]
    sections = [*reactions.described(), *([] if ratings is None else [permitted(reactions, ratings)])]
    print(f"{reactions.title}\n\n{written(sections)}")
    print("\n".join([times, *more]))
    driving = [(name, described(part)) for name, part in (("flywheel", flywheel), ("motor", motor)) if part is not None]
    capacities = [] if ratings is None else capacities_in_words(ratings.capacities, ratings.driver_coordinate)
    *stated, computed = inputs(reactions)
    table = [] if options.motion is None else [("motion from", options.motion)]
    print_inputs([*stated, *table, *driving, *capacities, computed])
    if options.out is not None:
        make_folder(options.out)
        reactions.to_csv(options.out / "cycle.csv")
        write_pages(press, reactions, options, ["cycle.csv"], before, results, flywheel)
    return 0


def _driving(press: Linkage, options: argparse.Namespace) -> tuple[Flywheel | None, Drive | PrescribedSpeed | None]:
    """Flywheel and motor; raises PinpressError if they do not suit a press at constant speed."""
    flywheel, motor = part_specs.flywheel(options.flywheel), part_specs.motor(options.motor, press.driver_coordinates[0])
    if flywheel is not None and flywheel.speed is not None:
        raise PinpressError(
            "--flywheel: at constant speed the flywheel turns with the crank: leave speed= out, or use pinpress simulate with a clutch"
        )
    if any(given is not None for given in (flywheel, options.speed_drop, motor)):
        press.refuse_sliding_driver("--flywheel, --speed-drop and --motor need a crank that keeps turning; pinpress simulate takes --motor")
    return flywheel, motor


def _computed(press: Linkage, options: argparse.Namespace) -> tuple[Reactions, str]:
    """Compute the reactions over the period of the options, and a line with the computing times."""
    acting = forces(options, press)
    began = [time.perf_counter()]
    if len(press.drivers) == 1:
        _ = press.branch  # followed here, so that the next times are those of any further motion
    began.append(time.perf_counter())
    motion = motion_of(press, options, options.speed, POINTS, options.engine)
    began.append(time.perf_counter())
    reactions = inverse_dynamics(press, motion, **acting, engine=options.engine)
    following, moving, forces_after = 1e3 * np.diff([*began, time.perf_counter()])
    steps = [(following, "following the assembly once")] if len(press.drivers) == 1 else []
    (first, what), *others = [*steps, (moving, "motion"), (forces_after, "torque and forces")]
    further = "".join(f", {took:.1f} ms {step}" for took, step in others)
    return reactions, entries([Figure("time taken", f"{first:.1f} ms {what}{further}")])[0]


def _of_flywheel(reactions: Reactions, flywheel: Flywheel | None, speed_drop: float | None) -> list[str]:
    """Work and power of the drive at constant speed, and the flywheel that they need."""
    energy = driving_energy(reactions)
    lowest, highest = (quantity("angle").text(angle) for angle in (energy.lowest_at, energy.highest_at))
    figures = [
        Figure("work of the drive", energy.work, "J", "a period"),
        Figure("mean torque", energy.mean_torque, "N m"),
        Figure("mean power", energy.mean_power, "W"),
        Figure("energy that it stores", energy.stored, "J", f"slowest at {lowest}, fastest at {highest}"),
    ]
    if flywheel is not None:
        inertia = float(np.ravel(flywheel.inertia)[0])
        own = 0.5 * inertia * energy.speed**2
        short = f": it holds only {quantity('J').text(own, 5)} at this speed, and the press stops" if energy.stored >= own else ""
        figures.append(Figure("speed drop", energy.speed_drop(inertia), "share", f"with {inertia:g} kg m2{short}"))
    if speed_drop is not None:
        inertia = energy.inertia(speed_drop)
        figures.append(Figure("inertia it takes", inertia, "kg m2", f"with the drive's, for a drop of {100 * speed_drop:g} %"))
    return ["", written([Section("Flywheel (at an even motor torque; drop of speed to first order)", figures)])]


def _of_motor(reactions: Reactions, motor: Drive | PrescribedSpeed, flywheel: Flywheel | None) -> tuple[Run | None, list[str]]:
    """The steady state under a motor, and lines with its speeds and the motor's duty; None, and lines with the reason."""
    speed = float(reactions.motion.crank_speed[0])
    lines = ["", f"Steady state under the motor near {speed / RPM:g} r/min; all else here is at constant speed"]
    try:
        run = steady_state(reactions._press, speed, drive=motor, flywheel=flywheel, loads=reactions.loads, friction=reactions.friction)
    except SimulationError as error:
        return None, [*lines, f"  none: {error}"]
    figures = [figure for part in sections_of(run) for figure in part.figures]
    return run, [*lines, *entries(figures)]
