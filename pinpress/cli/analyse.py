"""`pinpress analyse`: one period at constant speed."""

import argparse
import time

from ..common import tables
from ..common.errors import PinpressError
from ..common.files import make_folder
from ..dynamics.inputs import inputs
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..dynamics.summary import summary
from ..kinematics.motion import cycle
from ..linkage.linkage import Linkage
from ..linkage.loading import load
from ..ratings.permissible_force import Capacities, capacities_in_words
from ..ratings.rating import PressRatings, rate
from ..visual.recording import traced
from . import part_specs
from .options import (
    SIGNS,
    SPEED,
    add_force_options,
    add_out_option,
    add_press_options,
    add_report_option,
    add_trace_option,
    forces,
    load_press,
    print_inputs,
    refuse_pages_without_folder,
    with_zero,
    write_pages,
)
from .units import driver_speed, quantity

POINTS = 720  # of a turn


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `analyse` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "analyse",
        help="one period at constant speed: motion, driving torque, every bearing force, under loads, springs and friction",
        description="Turn a press through one period at constant speed: one turn of the crank, or with gears as many turns as it takes\n"
        "until the press repeats itself. Prints a summary; with --out also writes cycle.csv (every quantity at every crank angle, units\n"
        "in the header) and recording.html (the press turning with its forces, a page to open by double click); with --report also\n"
        "report.html, which has charts beside the press.",
        epilog=f"{part_specs.explained('load', 'spring', 'friction')}\n{SIGNS}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("--speed", type=driver_speed, required=True, metavar="RPM", help=SPEED)
    add_force_options(parser)
    option("--nominal-force", type=quantity("N"), metavar="N", help="permissible force at any height, to compare the process force with")
    option(
        "--nominal-height",
        type=quantity("m"),
        metavar="H",
        help="height from which down the crank's torque lets the nominal force act (default: at any); other limits see pinpress ratings",
    )
    add_out_option(parser, "the files")
    add_report_option(parser)
    option("--before", metavar="FILE", help="another press, drawn beside this one in the report at the same speed")
    add_trace_option(parser)
    option("--points", type=int, metavar="N", help=f"number of crank angles of the period (default: {POINTS} a turn)")
    option(
        "--engine", choices=("auto", "plane", "pinocchio"), default="auto", help="method of computation (default: the fastest that serves)"
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
        raise PinpressError("--before is for the report: give --report too")
    press = load_press(options)
    _ = traced(press, options.trace)  # a wrong one is found before the work
    acting = forces(options, press)
    walk = time.perf_counter()
    _ = press.branch  # followed here, so that the times below are those of any further motion
    start = time.perf_counter()
    speed = options.speed.of(press.driver_coordinates[0])
    motion = cycle(press, speed=speed, points=_points(press, options), engine=options.engine)
    middle = time.perf_counter()
    reactions = inverse_dynamics(press, motion, **acting, engine=options.engine)
    end = time.perf_counter()
    permissible = _permissible(press, options)
    print(summary(press, motion, reactions, None if permissible is None else permissible.utilisation(reactions)))
    took = [1e3 * (until - since) for since, until in ((walk, start), (start, middle), (middle, end))]
    further = f"ms following the assembly once, {took[1]:.1f} ms motion, {took[2]:.1f} ms torque and forces"
    print(tables.entry("time taken", f"{took[0]:.1f}", further))
    print_inputs([*inputs(reactions), *([] if permissible is None else capacities_in_words(permissible.capacities))])
    if options.out is not None:
        before = None if options.before is None else _before(options)
        make_folder(options.out)
        reactions.to_csv(options.out / "cycle.csv")
        write_pages(press, reactions, options, ["cycle.csv"], before, permissible)
    return 0


def _permissible(press: Linkage, options: argparse.Namespace) -> PressRatings | None:
    """The permissible force over the height; None where none is given."""
    if options.nominal_force is None:
        if options.nominal_height is not None:
            raise PinpressError("--nominal-height is that of a nominal force: give --nominal-force too")
        return None
    return rate(press, options.speed.of(press.driver_coordinates[0]), Capacities(options.nominal_force, options.nominal_height))


def _before(options: argparse.Namespace) -> Reactions:
    press = with_zero(load(options.before), options.zero)
    motion = cycle(press, speed=options.speed.of(press.driver_coordinates[0]), points=_points(press, options))
    return inverse_dynamics(press, motion, **forces(options, press))


def _points(press: Linkage, options: argparse.Namespace) -> int:
    if options.points is not None:
        return int(options.points)
    return POINTS * (press.period_turns if press.driver_coordinates[0].turns else 1)
