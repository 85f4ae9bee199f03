"""`pinpress report`: all that a press does, on one page."""

import argparse
from pathlib import Path

from ..common.errors import PinpressError
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import cycle
from ..linkage.linkage import Linkage
from ..ratings.permissible_force import Capacities
from ..ratings.rating import PressRatings, rate
from ..visual.recording import traced
from . import part_specs
from .options import SIGNS, SPEED, add_force_options, add_press_options, add_trace_option, forces, load_other, load_press
from .units import driver_speed, quantity

POINTS = 720  # of a turn


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `report` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "report",
        help="one page with all that a press does: it moves beside the charts of its motion, forces and ratings",
        description="Turn a press through one period at constant speed and write a page to open by double click: the press turning with\n"
        "its forces, and charts that follow it. Loads, friction and capacities add their charts and tables.",
        epilog=f"{part_specs.explained('load', 'spring', 'friction')}\n{SIGNS}"
        "e.g. pinpress report zxn2_3000b --speed 70 --load blanking:force=1000kN,start=6mm,end=2mm --nominal-force 3000kN\n"
        "     --nominal-height 13mm --out report.html\n",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("--speed", type=driver_speed, required=True, metavar="RPM", help=SPEED)
    option("--out", type=Path, required=True, metavar="HTML", help="write this page")
    add_force_options(parser)
    add_nominal_options(parser)
    add_before_option(parser)
    add_trace_option(parser)
    add_points_option(parser)
    add_press_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the page, and say so on stdout.

    Raises:
        PinpressError: Options do not go together, or computing or writing fails.
    """
    from ..visual.reports.report import report  # slow to import

    press = load_press(options)
    _ = traced(press, options.trace)  # a wrong one is found before the work
    motion = cycle(press, speed=options.speed.of(press.driver_coordinates[0]), points=states(press, options))
    reactions = inverse_dynamics(press, motion, **forces(options, press))
    ratings = permissible(press, options)
    before = None if options.before is None else press_before(options)
    results = [] if ratings is None else [ratings]
    report(press, motion, options.out, reactions=reactions, traces=options.trace, before=before, results=results)
    print(f"wrote {options.out}")
    return 0


def add_nominal_options(parser: argparse.ArgumentParser) -> None:
    """Options of `permissible`."""
    option = parser.add_argument
    option("--nominal-force", type=quantity("N"), metavar="N", help="permissible force at any height, to compare the process force with")
    option(
        "--nominal-height",
        type=quantity("m"),
        metavar="H",
        help="height from which down the crank's torque lets the nominal force act (default: at any); other limits see pinpress ratings",
    )


def add_before_option(parser: argparse.ArgumentParser) -> None:
    """Option of `press_before`."""
    help = "another press, or the same pin table without --set, drawn beside this one in the report at the same speed"
    parser.add_argument("--before", metavar="FILE", help=help)


def add_points_option(parser: argparse.ArgumentParser) -> None:
    """Option of `states`."""
    parser.add_argument("--points", type=int, metavar="N", help=f"number of crank angles of the period (default: {POINTS} a turn)")


def permissible(press: Linkage, options: argparse.Namespace) -> PressRatings | None:
    """The permissible force over the height; None where none is given."""
    if options.nominal_force is None:
        if options.nominal_height is not None:
            raise PinpressError("--nominal-height is that of a nominal force: give --nominal-force too")
        return None
    return rate(press, options.speed.of(press.driver_coordinates[0]), Capacities(options.nominal_force, options.nominal_height))


def press_before(options: argparse.Namespace) -> Reactions:
    """Another press at the same speed, under the same forces."""
    press = load_other(options, options.before)
    motion = cycle(press, speed=options.speed.of(press.driver_coordinates[0]), points=states(press, options))
    return inverse_dynamics(press, motion, **forces(options, press))


def states(press: Linkage, options: argparse.Namespace) -> int:
    """Number of states of a period."""
    if options.points is not None:
        return int(options.points)
    return POINTS * (press.period_turns if press.driver_coordinates[0].turns else 1)
