"""`pinpress analyse`: driving torque and bearing forces of one period or motion, by what is permitted, and under the motor."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.errors import SimulationError
from ..common.files import make_folder
from ..common.outlets.described import Figure, Section
from ..common.outlets.text import entries, written
from ..common.quantities import RPM, quantity
from ..common.results import Tabular
from ..dynamics.described import Places
from ..dynamics.driving_energy import driving_energy
from ..dynamics.extremes import at_peaks
from ..dynamics.inputs import inputs, row
from ..dynamics.reactions import Reactions
from ..dynamics.timing import TimingDiagram
from ..elasticity.slide_under_load import DeflectedSlide
from ..elasticity.unit_load import SlideCompliance
from ..fe.link_loads import LinkLoads
from ..jobs.bearings import pins_of
from ..jobs.job import Job, on_springs, stopping_results, traces_of
from ..mains.drive_choice import DriveChoice
from ..ratings.along_motion import MotionRatings
from ..ratings.emergency_stops import StoppingTimes
from ..ratings.permissible_force import capacities_in_words
from ..ratings.pin_use import PinRatings
from ..ratings.rating import PressRatings
from ..simulation.described import run as sections_of
from ..visual.recording import traced
from .options import SHORT, SIGNS, add_job_options, open_job, print_inputs, say_written, write_cam_tables, write_pictures, write_report

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

FILES = {
    PinRatings: "pins.csv",
    LinkLoads: "load_cases.csv",
    StoppingTimes: "stopping.csv",
    DriveChoice: "drives.csv",
    TimingDiagram: "timing.csv",
    SlideCompliance: "compliance.csv",
    DeflectedSlide: "deflection.csv",
}


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `analyse` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "analyse",
        help="driving torque and all bearing forces over a period or motion, what the press permits, and the steady state of its motor",
        description="Turn a press through one period at constant speed (one turn of the crank, or with gears the number of turns after\n"
        "which the press repeats itself), or move one or several drivers by the table of motion. Prints slide, torque and forces; with\n"
        "capacities the permissible force; with sizes of bearings their pressure and life; with stopping the stops under the brake; with\n"
        "mains a motor of a catalogue with its flywheel; with elastic how far the slide yields; with a flywheel its drop of speed; with a\n"
        "motor the steady state. With --out also writes cycle.csv (every quantity in every state), ratings.csv and ratings.png, pins.csv,\n"
        "load_cases.csv and .inp, stopping.csv, timing.csv, drives.csv, compliance.csv, deflection.csv, cam_height.txt and cam_angle.txt\n"
        "(for a controller), and the pages recording.html and report.html.",
        epilog=SIGNS + SHORT + "pinpress analyse press.yaml --out out",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_job_options(parser, "the files")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the summary and write the files.

    Raises:
        PinpressError: the job is wrong, or computing or writing fails.
    """
    job = open_job(options)
    _ = traced(job.press, traces_of(job))  # refuse a wrong point before the work
    reactions, times = _computed(job)
    ratings = job.rate() if "capacities" in job.sections else None
    results: list[Tabular] = [] if ratings is None else [ratings]
    shares = [] if ratings is None or not job.loads else [permitted(reactions, ratings)]
    results += [job.pins()] if pins_of(job.press, job.bearings) else []
    results += [job.load_cases()] if "fe" in job.sections else []
    results += stopping_results(job) if "stopping" in job.sections else []
    results += [job.timing()] if "feed" in job.sections else []
    results += job.cam_tables() if "cam_table" in job.sections else []
    results += [job.choose_drive()] if "mains" in job.sections else []
    results += on_springs(job) if "elastic" in job.sections else []
    more = [line for each in results for line in ("", str(each))]
    if "motion" not in job.sections and len(job.press.drivers) == 1 and job.press.driver_coordinates[0].turns:
        more += _of_flywheel(job, reactions) if job.flywheel is not None or job.motor is not None else []
        more += _of_motor(job, results) if job.motor is not None else []
    print(f"{reactions.title}\n\n{written(reactions.described())}")
    print("\n".join([times, *(["", written(shares)] if shares else []), *more]))
    driving: list[tuple[str, str]] = []
    for name in ("flywheel", "motor"):
        if name in job.sections:
            driving += [row(name, part, job.press.driver_coordinates[0]) for part in job.sections[name].values()]
    capacities = [] if not isinstance(ratings, PressRatings) else capacities_in_words(ratings.capacities, ratings.driver_coordinate)
    *stated, computed = inputs(reactions)
    print_inputs(job, [*stated, *driving, *capacities, computed])
    if options.out is not None:
        _write(job, reactions, ratings, results, options.out)
    return 0


def _computed(job: Job) -> tuple[Reactions, str]:
    """The reactions of the job, and a line with the computing times."""
    began = [time.perf_counter()]
    if len(job.press.drivers) == 1:
        _ = job.press.branch  # followed here, so that the next times are those of any further motion
    began.append(time.perf_counter())
    _ = job.motion()
    began.append(time.perf_counter())
    reactions = job.reactions()
    following, moving, forces_after = 1e3 * np.diff([*began, time.perf_counter()])
    steps = [(following, "following the assembly once")] if len(job.press.drivers) == 1 else []
    (first, what), *others = [*steps, (moving, "motion"), (forces_after, "torque and forces")]
    further = "".join(f", {took:.1f} ms {step}" for took, step in others)
    return reactions, entries([Figure("time taken", f"{first:.1f} ms {what}{further}")])[0]


def permitted(process: Reactions, found: PressRatings | MotionRatings) -> Section:
    """Shares of the process in the permissible force and energy."""
    peaks = at_peaks(process).reactions if isinstance(found, PressRatings) else process
    shares = found.utilisation(peaks)
    at = int(np.argmax(shares))
    figures = [Figure("of the permissible force", float(shares[at]), "share", Places.of(process._press, peaks.motion).said(at))]
    if isinstance(found, PressRatings):
        work = process.process_work * found.turns / (process.motion.period_turns or 1)
        figures += [Figure(f"of the {name}", work / energy, "share", "by its work in a stroke") for name, energy in found.energies.items()]
    return Section("Process by what is permitted", figures)


def _of_flywheel(job: Job, reactions: Reactions) -> list[str]:
    """Work and power of the drive at constant speed, and the flywheel that they need."""
    energy, flywheel = driving_energy(reactions), job.flywheel
    lowest, highest = (quantity("angle").text(angle) for angle in (energy.lowest_at, energy.highest_at))
    figures = [
        Figure("work of the drive", energy.work, "J", "a period"),
        Figure("mean torque", energy.mean_torque, "N m"),
        Figure("mean power", energy.mean_power, "W"),
        Figure("energy that it stores", energy.stored, "J", f"slowest at {lowest}, fastest at {highest}"),
    ]
    if flywheel is not None:
        inertia = float(np.ravel(flywheel.inertia)[0])  # type: ignore[union-attr]  # of one driver
        own = 0.5 * inertia * energy.speed**2
        short = f": it holds only {quantity('J').text(own, 5)} at this speed, and the press stops" if energy.stored >= own else ""
        figures.append(Figure("speed drop", energy.speed_drop(inertia), "share", f"with {inertia:g} kg m2{short}"))
    drop = job.sections.get("capacities", {}).get("speed_drop")
    if drop is not None:
        figures.append(Figure("inertia it takes", energy.inertia(drop), "kg m2", f"with the drive's, for a drop of {100 * drop:g} %"))
    return ["", written([Section("Flywheel (at an even motor torque; drop of speed to first order)", figures)])]


def _of_motor(job: Job, results: list[Tabular]) -> list[str]:
    """Lines with the speeds of the steady state and the motor's duty, or the reason why there is none; the state goes to the results."""
    assert job.speed is not None
    lines = ["", f"Steady state under the motor near {job.speed / RPM:g} r/min; all else here is at constant speed"]
    try:
        run = job.steady_state()
    except SimulationError as error:
        return [*lines, f"  none: {error}"]
    results.append(run)
    return [*lines, *entries([figure for part in sections_of(run) for figure in part.figures])]


def _write(job: Job, reactions: Reactions, ratings: Any, results: list[Tabular], folder: Path) -> None:
    """Write the files, and print their names."""
    from ..visual.recording import record  # slow to import

    make_folder(folder)
    reactions.to_csv(folder / "cycle.csv")
    record(job.press, reactions.motion, folder / "recording.html", reactions=reactions, traces=traces_of(job), flywheel=job.flywheel)
    names = ["cycle.csv", "recording.html", *write_report(job, folder, results=results)]
    for result in results:
        if file := FILES.get(type(result)):
            result.to_csv(folder / file)
            names.append(file)
        if isinstance(result, LinkLoads) and "mesh" in job.sections["fe"]:
            result.write_inp(folder / "load_cases.inp", mesh=job.sections["fe"]["mesh"], nodes=job.sections["fe"].get("nodes", {}))
            names.append("load_cases.inp")
    names += write_cam_tables(job, folder)
    if ratings is None:
        say_written(folder, names)
        return
    ratings.to_csv(folder / "ratings.csv")

    def draw() -> dict[str, "Picture"]:
        from ..plots.charts import draw as charts  # slow to import

        return {"ratings.png": charts(ratings, "force", "work", page=reactions)} if isinstance(ratings, PressRatings) else {}

    write_pictures(folder, [*names, "ratings.csv"], draw)
