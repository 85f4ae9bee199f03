"""`pinpress ratings`: find the permissible force, energy and speed of a press."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..common.errors import PinpressError
from ..common.files import make_folder
from ..common.outlets.described import Figure as Number
from ..common.outlets.described import Section
from ..common.outlets.text import written
from ..common.quantities import RPM, DriverCoordinate
from ..dynamics.described import Places, process_figures
from ..dynamics.extremes import at_peaks
from ..dynamics.inputs import motion_in_words, of_friction, of_loads, of_press, stated
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import cycle
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load, StandingLoad
from ..ratings.along_motion import MotionRatings, limits_in_words, rate_motion
from ..ratings.permissible_force import Capacities, capacities_in_words
from ..ratings.rating import PressRatings, rate
from .words import part_specs
from .words.by_driver import by_driver, named
from .words.forces import add_flywheel_option, add_force_options, loads
from .words.motions import add_motion_options, motion_of, refuse_beside_motion, refuse_without_motion
from .words.outputs import add_out_option, print_inputs, write_pictures
from .words.press import add_press_options, add_refused_option, load_press
from .words.units import OfDriver, driver_effort, quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EPILOG = f"""\
Numbers are in SI units, heights above bottom dead centre in m; the speed is in r/min, or in mm/s for a sliding driver.
e.g. pinpress ratings zxn2_3000b --speed 70 --nominal-force 3000e3 --nominal-height 0.013 --flywheel 2000 --speed-drop 0.2 --bearing A=2e6
     --out out

Springs and point forces act in addition to the process, and need --at-speed.

{part_specs.explained("load", "spring", "friction")}"""
NUMBERS = {
    "nominal-height": ("H", "m", "below this height the crank's torque allows the nominal force"),
    "speed-drop": ("D", "-", "largest drop of the flywheel's speed in a stroke, a fraction, e.g. 0.2"),
    "motor-power": ("W", "W", "power that restores the energy in continuous use; leave it out for single strokes"),
    "slide-acceleration": ("A", "m/s2", "largest acceleration that tool and feed allow"),
    "shaking-force": ("N", "N", "largest force on the foundation, weight excluded"),
    "contact-height": ("H", "m", "height where the tool meets the work; default: the nominal height"),
    "dwell-tolerance": ("H", "m", "distance from bottom dead centre that counts as dwell; default: a hundredth of the stroke"),
}
POINTS = 720  # crank angles of a turn at which the process is checked
POINTS_OF_STROKE = 181  # crank angles of the working stroke
NOT_CAPACITIES = ("contact_height", "dwell_tolerance")


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `ratings` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "ratings",
        help="permissible force over the slide's height, energy, and highest speed",
        description="Print the permissible force of a press at each height, limited by torque, bearings and energy, and its top speed.\n"
        "With --motion print the permissible force in each state of the motion, limited by the torques of all drivers and by bearings.\n"
        "With --out also writes ratings.csv (SI units) and, if Matplotlib is installed, ratings.png.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_motion_options(parser)
    add_capacity_options(parser, required=True)
    add_flywheel_option(parser, "goes with --speed-drop")
    add_force_options(parser, stiffness=False)
    add_refused_option(parser, "--motor", "ratings need only the power of the motor: give --motor-power")
    option(
        "--points",
        type=int,
        metavar="N",
        help=f"number of crank angles in the working stroke (default: {POINTS_OF_STROKE})",
    )
    add_press_options(parser)
    add_out_option(parser, "the files")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the ratings, and write the files.

    Raises:
        PinpressError: the capacity of a bearing is not a positive number, one of flywheel and speed drop is missing, or computing or
            writing fails.
    """
    if (options.flywheel is None) != (options.speed_drop is None):
        raise PinpressError(
            "the energy of a flywheel needs --flywheel and --speed-drop: give both, e.g. --speed-drop 0.2, or leave both out"
        )
    acting = loads(options)
    beside, process_loads = ([load for load in acting if isinstance(load, StandingLoad) == so] for so in (True, False))
    press = load_press(options)
    if options.motion is not None:
        return _along_motion(press, options, beside, process_loads)
    refuse_without_motion(press, "one speed does not determine the motion of several drivers")
    friction = part_specs.frictions(options.friction, press)
    coordinate = press.driver_coordinates[0]
    speed = options.speed.of(coordinate)
    found = rated(press, options, beside, friction, points=POINTS_OF_STROKE if options.points is None else options.points)
    turns = press.period_turns if coordinate.turns else 1
    process = inverse_dynamics(press, cycle(press, speed, points=POINTS * turns), process_loads, bearings=()) if process_loads else None
    lines = [] if process is None else ["", written([Section("Process", process_figures(process)), permitted(process, found)])]
    if options.out is not None:
        make_folder(options.out)
    print("\n".join([str(found), *lines]))
    pace = f"{speed / RPM:g} r/min" if coordinate.turns else f"up to {1e3 * abs(speed):g} mm/s"
    at = f"{pace}, {'with' if options.at_speed else 'without'} weights and inertia forces"
    limits = capacities_in_words(found.capacities, coordinate)
    under = [*(of_loads(acting) if acting else []), *(of_friction(friction) if friction else [])]
    print_inputs([*of_press(press), ("speed", at), *limits, *under, stated()])
    if options.out is not None:
        _write(found, process, options.out)
    return 0


def _along_motion(press: Linkage, options: argparse.Namespace, beside: Sequence[Load], process_loads: Sequence[Load]) -> int:
    """Print the permissible force in a given motion, and write it; arguments as in `run`."""
    motion, friction = motion_of(press, options, None), part_specs.frictions(options.friction, press)
    found = rated_along(press, motion, options, beside, friction)
    process = inverse_dynamics(press, motion, process_loads, bearings=()) if process_loads else None
    lines = [] if process is None else ["", written([Section("Process", process_figures(process)), permitted(process, found)])]
    if options.out is not None:
        make_folder(options.out)
    print("\n".join([str(found), *lines]))
    acting = [*beside, *process_loads]
    under = [*(of_loads(acting) if acting else []), *(of_friction(friction) if friction else [])]
    print_inputs([*of_press(press), ("motion", motion_in_words(motion)), *limits_in_words(found), *under, stated()])
    if options.out is not None:
        found.to_csv(options.out / "ratings.csv")
        print(f"\nwrote {options.out / 'ratings.csv'}")
    return 0


def rated_along(
    press: Linkage, motion: Motion, options: argparse.Namespace, loads: Sequence[Load], friction: Mapping[str, Friction]
) -> MotionRatings:
    """Rate a press along a motion by `add_capacity_options`; other arguments and errors as for `rated`."""
    refuse_beside_motion(options, "flywheel", "at_speed", *(name.replace("-", "_") for name in NUMBERS))
    capable = {name: effort.of(coordinate) for name, effort, coordinate in _efforts(press, options)}
    bearings = part_specs.by_bearing("--bearing", options.bearing, "N", "force", "2e6")
    capacities = Capacities(options.nominal_force, bearings=bearings, drivers=capable)
    return rate_motion(press, motion, capacities, loads=loads, friction=friction)


def _efforts(press: Linkage, options: argparse.Namespace) -> list[tuple[str, OfDriver, DriverCoordinate]]:
    """Names of drivers, their values of --torque, and their coordinates."""
    given = by_driver(press, "--torque", options.torque, "=5e3")
    return [(name, effort, press.driver_coordinates[press.drivers.index(name)]) for name, effort in given.items()]


def add_capacity_options(parser: argparse.ArgumentParser, *, required: bool) -> None:
    """Options of `rated`; ``required``: whether a press is always rated."""
    option = parser.add_argument
    option("--nominal-force", type=quantity("N"), required=required, metavar="N", help="largest process force at any height")
    for name, (value, unit, words) in NUMBERS.items():
        option(f"--{name}", type=quantity(unit), metavar=value, help=words)
    option(
        "--torque",
        type=named(driver_effort),
        action="append",
        default=[],
        metavar="NM",
        help="torque capacity at the driver joint, in place of --nominal-height; force capacity of a sliding driver [N]; with several"
        " drivers A=NM, given several times",
    )
    option(
        "--bearing", action="append", default=[], metavar="NAME=N", help="largest force in a bearing or guide; may be given several times"
    )
    option(
        "--at-speed",
        action="store_true",
        help="take weights and inertia forces at this speed into account (default: the process force alone)",
    )


def capacities_given(options: argparse.Namespace) -> list[str]:
    """The given options of `add_capacity_options` except the nominal force."""
    names = [*NUMBERS, "torque", "bearing", "at-speed"]
    return [f"--{name}" for name in names if getattr(options, name.replace("-", "_")) not in (None, [], False)]


def rated(
    press: Linkage, options: argparse.Namespace, loads: Sequence[Load], friction: Mapping[str, Friction], points: int = POINTS_OF_STROKE
) -> PressRatings:
    """Rate a press by `add_capacity_options`.

    Args:
        press: the press.
        options: options of `add_capacity_options`, with --speed and --flywheel (an energy limit if --speed-drop is given).
        loads: springs and forces at points that act in addition to the process.
        friction: friction of bearings and guides.
        points: number of crank angles in the working stroke.

    Raises:
        PinpressError: a capacity is wrong, or the press cannot be rated.
    """
    given = {name.replace("-", "_"): getattr(options, name.replace("-", "_")) for name in NUMBERS}
    extra = {name: given.pop(name) for name in NOT_CAPACITIES}
    flywheel = part_specs.flywheel(options.flywheel)
    if flywheel is not None and options.speed_drop is not None:
        given["flywheel_inertia"] = flywheel.inertia
    coordinate = press.driver_coordinates[0]
    torque = next((effort.of(coordinate) for _, effort, coordinate in _efforts(press, options)), None)
    bearings = part_specs.by_bearing("--bearing", options.bearing, "N", "force", "2e6")
    capacities = Capacities(options.nominal_force, bearings=bearings, torque=torque, **given)
    speed = options.speed.of(coordinate)
    return rate(press, speed, capacities, at_speed=options.at_speed, loads=loads, friction=friction, points=points, **extra)


def permitted(process: Reactions, found: PressRatings | MotionRatings) -> Section:
    """Shares of the process in the permissible force and energy."""
    peaks = at_peaks(process).reactions if isinstance(found, PressRatings) else process
    shares = found.utilisation(peaks)
    at = int(np.argmax(shares))
    figures = [Number("of the permissible force", float(shares[at]), "share", Places.of(process._press, peaks.motion).said(at))]
    if isinstance(found, PressRatings):
        work = process.process_work * found.turns / (process.motion.period_turns or 1)
        figures += [Number(f"of the {name}", work / energy, "share", "by its work in a stroke") for name, energy in found.energies.items()]
    return Section("Process by what is permitted", figures)


def _write(found: PressRatings, process: Reactions | None, folder: Path) -> None:
    """Write the files, and print their names."""
    found.to_csv(folder / "ratings.csv")

    def draw() -> dict[str, Figure]:
        from ..plots.charts import draw as charts  # slow to import

        return {"ratings.png": charts(found, "force", "work", page=process)}

    write_pictures(folder, ["ratings.csv"], draw)
