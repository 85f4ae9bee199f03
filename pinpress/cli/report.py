"""`pinpress report`: all results of a press on one page."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..balancing.counterweights import OperatingCondition
from ..common.errors import PinpressError
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import cycle
from ..linkage.linkage import Linkage
from ..loads.link import StandingLoad
from ..loads.mounts import Frame, Vector
from ..ratings.permissible_force import Capacities
from ..ratings.rating import PressRatings, rate
from ..simulation.steady_state import steady_state
from ..visual.recording import traced
from . import balance, ratings
from .words import part_specs
from .words.forces import Forces, add_flywheel_option, add_force_options, forces
from .words.motions import add_motion_options, motion_of, refuse_beside_motion
from .words.outputs import SIGNS, add_trace_option, named_point
from .words.press import add_press_options, load_other, load_press
from .words.springs import add_joint_option, add_mount_options, mounted_press
from .words.units import OfDriver, driver_speed, quantity

if TYPE_CHECKING:
    from ..foundation.mounted_press import MountedPress

POINTS = 720  # of a turn
MOST_STATES = 100_000  # of a period, for the vibration of the frame
SPEEDS = 61  # at which the press on its mounts is shown
EPILOG = f"""\
Each of these options adds a part to the page: --load (the process), --nominal-force and other capacities (ratings), --motor with --flywheel
(the steady state under the motor), --stiffness (the elastic press, also with
--preloaded-joint), --region with --minimise (the best counterweights), --frame with --mount (springs,
or rubber with --pad) or with a frame file (loads of the mounts, modes, vibration and force on the floor; with
--speed-range over the speed, with --lift-off for mounts that only press).
--frame-point NAME:X,Y,Z is a point of the frame in m in world axes. NAME:PART:X,Y,Z is a point of a part (crown, motor, an interface). On
a flexible frame PART or NAME:PART is an interface.
regions: {balance.REGION}
criteria: {balance.CRITERION}; see pinpress balance --help

{part_specs.explained("load", "spring", "friction", "motor", "joint", "mount")}\
--pad, the rubber pad at each --mount (then a mount has only point=); hardness in Shore A, 20 to 80, or shear_modulus:
  {part_specs.keys(part_specs.PAD)}
  e.g. --pad {part_specs.PAD.example} --mount {part_specs.PLACE.example}

{SIGNS}e.g. pinpress report zxn2_3000b --speed 70 --load blanking:force=1000kN,start=6mm,end=2mm --out report.html
     --nominal-force 3000kN --nominal-height 13mm --motor induction:rated_power=75kW,rated_speed=1485,inertia=1.2,ratio=20.7
     --flywheel 6000
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `report` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "report",
        help="one page with all results of a press: the moving press next to charts of its motion, forces and ratings",
        description="Turn a press through one period at constant speed, or with --motion by a table, and write a page to open by\n"
        "double click: the press turning with its forces, charts that follow it, and all inputs.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_motion_options(parser)
    option("--out", type=Path, metavar="HTML", help="write this page")
    option("--pdf", type=Path, metavar="PDF", help="print the page to this file (needs Chromium and pip install 'pinpress[video]')")
    add_force_options(parser)
    add_joint_option(parser)
    ratings.add_capacity_options(parser, required=False)
    option("--motor", metavar="KIND:KEYS", help="motor, see below: the page also shows the steady state under it, with loads and flywheel")
    add_flywheel_option(parser, "with --motor, and with --speed-drop as an energy of the ratings")
    balance.add_balance_options(parser, required=False)
    add_mount_options(parser, "the page shows its modes, and its vibration at this speed or in this motion")
    option("--pad", metavar="KEYS", help="the rubber pad at each mount, see below")
    help = "also show the vibration of this point of the frame, see below; may be given several times"
    option("--frame-point", type=frame_point, metavar="NAME:X,Y,Z", action="append", default=[], help=help)
    help = "write a page in which the frame swings in its lowest modes, magnified; with rotors at the highest speed of the page"
    option("--modes", type=Path, metavar="HTML", help=help)
    help = "also show the vibration of the idle press from one crank speed to another, in r/min"
    option("--speed-range", type=speed_range, metavar="LOW,HIGH", help=help)
    help = "the mounts press and do not pull: also show the vibration over this number of strokes, with feet that lift off"
    option("--lift-off", type=int, metavar="STROKES", help=help)
    add_before_option(parser)
    add_trace_option(parser)
    add_points_option(parser)
    add_press_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the page, and print its name.

    Raises:
        PinpressError: Options do not go together, or computing or writing fails.
    """
    if options.out is options.pdf is options.modes is None:
        raise PinpressError("nothing to write: give --out page.html or --pdf report.pdf")
    if options.out is not None and options.out.suffix.lower() == ".pdf":
        raise PinpressError(f"--out writes a web page: give --pdf {options.out}, or --out {options.out.with_suffix('.html')}")
    from ..visual.film import pdf  # slow to import
    from ..visual.reports.report import report  # slow to import

    _refuse_what_is_incomplete(options)
    press = load_press(options)
    _ = traced(press, options.trace)  # refuse a wrong point before the work
    if options.frame is not None and options.motion is None:
        press.refuse_sliding_driver("--frame shows the vibration over turns of a crank: leave it out, or give --motion")
    acting, motion = forces(options, press), motion_of(press, options, options.speed, POINTS)
    system = mounted_press(options, press, options.pad, motion=None if options.motion is None else motion)
    reactions = inverse_dynamics(press, motion, **acting)
    results = [*_results(press, reactions, acting, system, options)]
    before = None if options.before is None else press_before(options)
    if options.modes is not None:
        from ..foundation.mounted_press import VibrationModes  # seldom needed
        from ..foundation.whirl_modes import WhirlDiagram  # seldom needed
        from ..visual.swinging import MOST, record_modes  # slow to import

        swinging = [each for each in results if isinstance(each, VibrationModes | WhirlDiagram)][-1]
        record_modes(press, swinging, options.modes, lowest=MOST)
    with tempfile.TemporaryDirectory() as folder:
        page = options.out or Path(folder, "report.html")
        flywheel = part_specs.flywheel(options.flywheel)
        if options.out is not None or options.pdf is not None:
            report(
                press,
                motion,
                page,
                reactions=reactions,
                traces=options.trace,
                before=before,
                results=results,
                flywheel=flywheel,
            )
        if options.pdf is not None:
            pdf(page, options.pdf)
    print(f"wrote {' and '.join(str(path) for path in (options.out, options.pdf, options.modes) if path is not None)}")
    return 0


def _refuse_what_is_incomplete(options: argparse.Namespace) -> None:
    """Refuse an option that is given without the option that it needs."""
    refuse_beside_motion(options, "flywheel", "motor")
    beside = ratings.capacities_given(options)
    if options.nominal_force is None and beside:
        raise PinpressError(f"{beside[0]} is for the ratings: also give --nominal-force, the largest process force at any height")
    if options.flywheel is None and options.speed_drop is not None:
        raise PinpressError("--speed-drop needs a flywheel: also give its inertia, --flywheel")
    if options.flywheel is not None and options.motor is None and options.speed_drop is None:
        raise PinpressError("--flywheel alone has no effect on the page: also give --motor, or --nominal-force and --speed-drop")
    if bool(options.region) != bool(options.minimise) or (options.limit and not options.region):
        raise PinpressError("balancing needs --region and --minimise (and takes --limit): give both, or leave all three out")
    beside = [name for name in ("pad", "frame_point", "speed_range", "lift_off", "modes") if getattr(options, name) not in (None, [])]
    if options.frame is None and not options.mount and beside:
        raise PinpressError(f"--{beside[0].replace('_', '-')} is for the press on its mounts: also give --frame and every --mount")
    if options.region and options.friction:
        raise PinpressError(
            "--region: balancing needs forces that are linear in the masses; friction makes them nonlinear: leave out one of them"
        )


def _results(
    press: Linkage, reactions: Reactions, acting: Forces, system: MountedPress | None, options: argparse.Namespace
) -> Iterator[Tabular]:
    """The results that the options request in addition to motion and forces."""
    coordinate, loads = press.driver_coordinates[0], acting["loads"]
    if options.nominal_force is not None and options.motion is not None:
        standing = [load for load in loads if isinstance(load, StandingLoad)]
        yield ratings.rated_along(press, reactions.motion, options, standing, acting["friction"])
    elif options.nominal_force is not None:
        beside = [load for load in loads if options.at_speed and isinstance(load, StandingLoad)]
        yield ratings.rated(press, options, beside, acting["friction"])
    if options.motor is not None:
        drive = part_specs.motor(options.motor, coordinate)
        parts = {
            "drive": drive,
            "flywheel": part_specs.flywheel(options.flywheel),
            "loads": loads,
            "friction": acting["friction"],
            "points": POINTS * press.period_turns,
        }
        yield steady_state(press, options.speed.of(coordinate), **parts)  # type: ignore[arg-type]  # it refuses what has no motor
    if options.stiffness or options.preloaded_joint:
        from ..elasticity.slide_under_load import slide_deflection  # seldom needed
        from ..elasticity.springs import Stiffness
        from ..elasticity.unit_load import compliance

        joints = part_specs.joints(options.preloaded_joint, press)
        frame = joints.pop(part_specs.COLUMNS, None)
        stiffness = Stiffness(bearings={**acting["stiffness"], **joints}, frame=frame)
        if len(press.drivers) == 1:  # it is over the crank angle
            yield compliance(press, stiffness)
        yield slide_deflection(press, reactions.motion, stiffness, loads=loads)
    if options.region:
        yield balance.balanced_by(press, [OperatingCondition(reactions.motion, loads)], options)
    if system is not None:
        yield from _on_mounts(system, _resolved(system, reactions, acting, options), options)


def _resolved(system: MountedPress, reactions: Reactions, acting: Forces, options: argparse.Namespace) -> Reactions:
    """The reactions over a period with enough states for the vibration: more than the page has if a blank breaks."""
    from ..foundation.response import states_that_resolve  # seldom needed

    if options.motion is not None:  # its states are those of the table
        return reactions
    while len(reactions.motion.crank_angle) < (states := states_that_resolve(system, reactions)) <= MOST_STATES:
        motion = cycle(system.press, speed=float(reactions.motion.crank_speed[0]), points=states)
        reactions = inverse_dynamics(system.press, motion, **acting)
    return reactions


def _on_mounts(system: MountedPress, reactions: Reactions, options: argparse.Namespace) -> Iterator[Tabular]:
    """Results of the frame on its mounts."""
    from ..foundation.lifting import lifting_response  # seldom needed
    from ..foundation.mounted_press import modes
    from ..foundation.response import steady_response, time_response
    from ..foundation.speed_response import over_speeds
    from ..foundation.whirl_modes import whirl

    coordinate, top = system.press.driver_coordinates[0], float(np.abs(reactions.motion.crank_speed).max())
    points = shown_points(system) | _frame_points(system, options.frame_point)
    speeds = None
    if options.speed_range is not None:
        low, high = (speed.of(coordinate) for speed in options.speed_range)
        if not 0 < low < high:
            raise PinpressError("--speed-range needs two positive speeds, the lower one first, e.g. 30,90")
        speeds, top = np.linspace(low, high, SPEEDS), high
    yield system
    yield modes(system)
    if system.rotors:
        yield whirl(system, np.linspace(0.0, top, SPEEDS))
    if options.motion is not None and options.period is None:
        yield time_response(system, reactions, points=points)
    else:
        yield steady_response(system, reactions, points=points, period=options.period)
    if options.lift_off is not None:
        yield lifting_response(system, reactions, points=points, strokes=options.lift_off, period=options.period)
    if speeds is not None:
        yield over_speeds(system, speeds, points=points)


def shown_points(system: MountedPress) -> dict[str, Any]:
    """Points whose vibration is shown: centres of rigid parts, or bed and carrier of a flexible frame; and machines on the frame."""
    frame, crown = system.frame, system.crown
    if not isinstance(frame, Frame):
        own: dict[str, Any] = {name: name for name in (frame.carrier, frame.bed)}
    elif crown is None:
        own = {"centre of the frame": frame.centre}
    else:
        own = {"centre of the bed": frame.centre, "centre of the crown": ("crown", crown.centre)}
    return own | {name: (name, each.body.centre) for name, each in system.attached.items()}


def frame_point(words: str) -> tuple[str, Vector | None]:
    """Reads an option of `argparse`: a name and x, y, z [m], or words alone, which `_frame_points` reads as the name of an interface."""
    return (words, None) if "," not in words and words else named_point("the frame", "crown:0,0,0.9")(words)


def _frame_points(system: MountedPress, given: list[tuple[str, Vector | None]]) -> dict[str, Any]:
    """Points of the frame from the options: NAME:X,Y,Z, NAME:PART:X,Y,Z, or an interface without coordinates."""
    found: dict[str, Any] = {}
    for words, place in given:
        head, colon, part = words.rpartition(":")
        name, on = (head, part) if colon and part in system.parts else (words, words if place is None else None)
        if name in found:
            raise PinpressError(f"--frame-point: {name} is given twice")
        if place is None and (isinstance(system.frame, Frame) or on not in system.frame.nodes):
            wanted = (
                "x, y, z in m" if isinstance(system.frame, Frame) else f"x, y, z in m, or an interface of {', '.join(system.frame.nodes)}"
            )
            raise PinpressError(f"--frame-point {words}: give a name and {wanted}, e.g. crown:0,0,0.9")
        found[name] = on if place is None else place if on is None else (on, place)
    return found


def speed_range(words: str) -> tuple[OfDriver, OfDriver]:
    """Reads an option of `argparse`: two speeds of the driver."""
    low, comma, high = words.partition(",")
    if not comma:
        raise argparse.ArgumentTypeError(f"{words!r} is not a range of speeds: give two speeds with a comma between them, e.g. 30,90")
    return driver_speed(low), driver_speed(high)


def add_nominal_options(parser: argparse.ArgumentParser) -> None:
    """Options of `permissible`."""
    option = parser.add_argument
    option("--nominal-force", type=quantity("N"), metavar="N", help="permissible force at any height, to compare the process force with")
    option(
        "--nominal-height",
        type=quantity("m"),
        metavar="H",
        help="below this height the crank's torque allows the nominal force (default: at any height); other limits see pinpress ratings",
    )


def add_before_option(parser: argparse.ArgumentParser) -> None:
    """Option of `press_before`."""
    help = "another press, or the same pin table without --set, for comparison in the report at the same speed"
    parser.add_argument("--before", metavar="FILE", help=help)


def add_points_option(parser: argparse.ArgumentParser) -> None:
    """Option --points, of `motion_of`."""
    parser.add_argument("--points", type=int, metavar="N", help=f"number of crank angles of the period (default: {POINTS} a turn)")


def permissible(press: Linkage, options: argparse.Namespace) -> PressRatings | None:
    """The permissible force over the height; None without a nominal force."""
    if options.nominal_force is None:
        if options.nominal_height is not None:
            raise PinpressError("--nominal-height needs a nominal force: also give --nominal-force")
        return None
    return rate(press, options.speed.of(press.driver_coordinates[0]), Capacities(options.nominal_force, options.nominal_height))


def press_before(options: argparse.Namespace) -> Reactions:
    """Compute another press at the same speed, under the same forces."""
    press = load_other(options, options.before, options.slide)
    motion = motion_of(press, options, options.speed, POINTS)
    return inverse_dynamics(press, motion, **forces(options, press))
