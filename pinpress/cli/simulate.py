"""`pinpress simulate`: simulate a press under drive, flywheel and process loads."""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.errors import PinpressError
from ..common.files import make_folder
from ..common.outlets.described import Figure, Section
from ..common.outlets.text import entries, written
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load
from ..simulation.described import numerics
from ..simulation.duty import stroke_duties
from ..simulation.elastic.description import Elastic
from ..simulation.elastic.parts_in_words import elastic_in_words
from ..simulation.elastic.run import ElasticRun
from ..simulation.run import Run, inputs_of
from ..simulation.simulate import METHODS, simulate
from ..simulation.steady_state import steady_state
from ..visual.recording import traced
from .words import part_specs
from .words.by_driver import by_driver, named, parted
from .words.forces import add_flywheel_option, add_force_options, loads
from .words.outputs import SIGNS, add_page_options, print_inputs, refuse_pages_without_folder, write_pages
from .words.press import add_press_options, load_press
from .words.progress import progress
from .words.springs import add_spring_options, springs
from .words.units import OfDriver, driver_position, driver_speed, quantity

if TYPE_CHECKING:
    from ..elasticity.impacts import ImpactsByTurn

BAR = "{percentage:3.0f} % |{bar}| {n:.3f} of {total:.3f} s, {remaining} to go"
STEADY_POINTS = 720  # states of a turn of the steady state, as in `analyse`: fewer states miss peaks of short blows
EXAMPLE = """\
e.g. pinpress simulate zxn2_3000b --speed 70 --duration 3 --motor induction:rated_power=75kW,rated_speed=1485,inertia=1.2,ratio=20.7
     --flywheel 6000 --load drawing:force=1000kN,start=10mm --out out --report"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `simulate` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "simulate",
        help="simulate a press under motor, flywheel and process load",
        description="Simulate a press under drive, flywheel and process loads, or find its steady state. Prints speeds, energies, the\n"
        "motor's torque, the strokes and the peak force of every bearing. With --stiffness the press runs on springs. With --out also\n"
        "writes simulation.csv (every quantity at every instant), strokes.csv (a line for each stroke, SI units) and recording.html (the\n"
        "press turning with its forces, a page to open by double click).",
        epilog=f"{part_specs.explained('load', 'spring', 'friction', 'motor', 'clutch', 'elastic', 'mount')}\n{SIGNS}\n\n{EXAMPLE}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option(
        "--speed",
        type=named(driver_speed),
        action="append",
        default=[],
        metavar="RPM",
        help="crank speed at the start, or near the steady state, in r/min; speed of a sliding driver in mm/s; with several drivers"
        " A=30, once for each driver that moves (default: 0)",
    )
    option(
        "--angle",
        type=named(driver_position),
        action="append",
        default=[],
        metavar="DEG",
        help="crank angle at the start; position of a sliding driver in mm; with several drivers A=30 (default: 0)",
    )
    until = parser.add_mutually_exclusive_group(required=True)
    until.add_argument("--duration", type=quantity("s"), metavar="S", help="length of the run, in s")
    until.add_argument("--steady", action="store_true", help="find one period of the steady state near --speed")
    help = "motor or other drive of the crank, see below (default: none); with several drivers A:KIND:KEYS, once for each drive"
    option("--motor", metavar="KIND:KEYS", action="append", default=[], help=help)
    more = "inertia=J,speed=RPM if it turns before a clutch closes; with several drivers A:J, once for each flywheel"
    add_flywheel_option(parser, more, several=True)
    add_force_options(parser, stiffness=False)
    option("--clutch", metavar="KEYS", help="clutch between flywheel and crank, see below")
    option("--brake", metavar="KEYS", help="brake on the crank, see below")
    add_spring_options(parser)
    option("--method", choices=METHODS, default="auto", help="method of computation (default: %(default)s, the fastest that can be used)")
    option("--step", type=quantity("s"), metavar="S", help="fixed step of integration, in s (default: the error controls the steps)")
    help = "relative error of a step (default: 1e-11); for a press on springs, of its displacements (default: 1e-5)"
    option("--tolerance", type=float, metavar="T", help=help)
    option(
        "--points",
        type=int,
        metavar="N",
        help="number of states in the results (default: 120 a turn, at least 120; 720 a turn with --steady)",
    )
    option("--gravity", type=quantity("m/s2"), default=9.81, metavar="G", help="gravity downwards, in m/s2 (default: %(default)s)")
    add_press_options(parser)
    add_page_options(parser, "the three files")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the summary and write the files.

    Raises:
        PinpressError: Options do not go together, or computing or writing fails.
    """
    refuse_pages_without_folder(options)
    press = load_press(options, gravity=(0.0, 0.0, -options.gravity))
    _ = traced(press, options.trace)  # refuse a wrong point before the work
    acting, friction = loads(options), part_specs.frictions(options.friction, press)
    elastic = springs(options, press)
    done = _run(press, acting, friction, elastic, options)
    began = time.perf_counter()
    reactions = inverse_dynamics(press, done, acting, friction)
    took = time.perf_counter() - began
    print(f"{done.title}\n\n{written(_sections(done, reactions))}")
    took_words = f"{1e3 * done.stats.wall_time:.1f} ms simulation, {1e3 * took:.1f} ms torque and forces"
    few = "peaks are peaks of the states: if a blow falls between two states, raise --points"
    counted = [Figure("states", f"{len(done.time)}", where=few)] if acting and elastic is not None and not options.steady else []
    print("\n".join(entries([*counted, Figure("time taken", took_words)])))
    print_inputs([*inputs_of(reactions), *(elastic_in_words(elastic) if elastic is not None else [])])
    if options.out is not None:
        states = reactions if elastic is None else done
        states.to_csv(options.out / "simulation.csv")
        names = ["simulation.csv"]
        if len(press.drivers) == 1:  # several have no strokes of one crank
            stroke_duties(done).to_csv(options.out / "strokes.csv")
            names.append("strokes.csv")
        write_pages(press, reactions, options, names, results=_beside(press, done, options))
    return 0


def _sections(run: Run, reactions: Reactions) -> list[Section]:
    """Sections of a printed run: its results, its forces, and the residuals of the equations."""
    forces = [part for part in reactions.described() if part.title not in ("Motion", "Slide", "Process")]
    if isinstance(run, ElasticRun):
        forces = [part for part in forces if part.title == "Checks"]
        forces[:0] = [part for found in journals(run) for part in found.described()]
    *forces, checks = forces
    return [*run.described(), *forces, replace(checks, figures=[*checks.figures, *numerics(run)])]


def _beside(press: Linkage, run: Run, options: argparse.Namespace) -> list[Tabular]:
    """Additional results for the page of an elastic run: its vibrations, or the impacts of journals with clearance."""
    if not (options.report and isinstance(run, ElasticRun)):
        return []
    from ..elasticity.vibration import natural_frequencies  # seldom needed

    if run.elastic.clearances:
        return list(journals(run))
    return [natural_frequencies(press, run.elastic)]


def journals(run: ElasticRun) -> list[ImpactsByTurn]:
    """Impacts of journals with clearance, for a run of at least one turn."""
    from ..elasticity.impacts import journal_impacts  # seldom needed

    if abs(run.crank_angle[-1] - run.crank_angle[0]) < 2 * np.pi:
        return []
    return [journal_impacts(run, name) for name in run.elastic.clearances]


def _run(
    press: Linkage, acting: Sequence[Load], friction: Mapping[str, Friction], elastic: Elastic | None, options: argparse.Namespace
) -> Run:
    """Compute the run, or one period of the steady state."""
    speeds, angles = _start(press, "--speed", options.speed), _start(press, "--angle", options.angle)
    coordinates = dict(zip(press.drivers, press.driver_coordinates, strict=True))
    motors = by_driver(press, "--motor", [parted(press, words) for words in options.motor], ":constant:value=567")
    flywheels = by_driver(press, "--flywheel", [parted(press, words) for words in options.flywheel], ":2000")
    drives = {name: part_specs.motor(words, coordinates[name]) for name, words in motors.items()}
    wheels = {name: part_specs.flywheel(words) for name, words in flywheels.items()}
    one = len(press.drivers) == 1
    parts: dict[str, Any] = {
        "drive": drives.get(press.driver) if one else drives,
        "flywheel": wheels.get(press.driver) if one else wheels,
        "loads": acting,
        "friction": friction,
        "points": options.points,
        "tolerance": options.tolerance,
    }
    if elastic is not None:
        parts["elastic"] = elastic
    clutch = None if options.clutch is None else part_specs.part("--clutch", part_specs.CLUTCH, options.clutch)
    brake = None if options.brake is None else part_specs.part("--brake", part_specs.BRAKE, options.brake)
    if options.steady:
        press.refuse_sliding_driver("--steady needs turns of a crank; give --duration in its place")
        _refuse_beside_steady(press, options, speeds)
    if elastic is not None and (options.method != "auto" or options.step is not None):
        option = "--step" if options.method == "auto" else "--method"
        raise PinpressError(
            f"{option} does not go with --stiffness: a press on springs has a separate method with its steps; leave {option} out"
        )
    if options.out is not None:
        make_folder(options.out)  # before a run that may be long
    if options.steady:
        points = STEADY_POINTS * press.period_turns if options.points is None else options.points
        run: Run = steady_state(press, speeds[0], angle=angles[0], **parts | {"points": points})
        return run
    how = {"method": options.method, "step": options.step}
    start = (speeds[0], angles[0]) if one else (speeds, angles)
    with progress(options.duration, BAR) as told:
        run = simulate(press, options.duration, speed=start[0], angle=start[1], clutch=clutch, brake=brake, progress=told, **parts, **how)
    return run


def _start(press: Linkage, option: str, given: Sequence[tuple[str, OfDriver]]) -> list[float]:
    """Speed or position of every driver at the start [rad/s or m/s; rad or m]."""
    found = by_driver(press, option, given, "=30")
    coordinates = zip(press.drivers, press.driver_coordinates, strict=True)
    return [found[name].of(coordinate) if name in found else 0.0 for name, coordinate in coordinates]


def _refuse_beside_steady(press: Linkage, options: argparse.Namespace, speeds: Sequence[float]) -> None:
    press.refuse_several_drivers("several drivers have no common stroke that repeats itself; give --duration in place of --steady")
    for name, absent in (("clutch", None), ("brake", None), ("step", None), ("method", "auto")):
        if getattr(options, name) != absent:
            raise PinpressError(f"--{name} does not go with --steady: leave --{name} out, or give --duration in place of --steady")
    if not options.motor:
        raise PinpressError("--steady needs a --motor that keeps the press running; its kinds see --help")
    if speeds[0] == 0:
        raise PinpressError("--steady needs the approximate speed of the press, not 0: --speed, e.g. --speed 70")
