"""`pinpress simulate`: let the press of a job run under its motor, flywheel and loads, or find its steady state."""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..common.files import make_folder
from ..common.outlets.described import Figure, Section
from ..common.outlets.text import entries, written
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..jobs.job import Job, traces_of
from ..simulation.described import numerics
from ..simulation.duty import stroke_duties
from ..simulation.elastic.parts_in_words import elastic_in_words
from ..simulation.elastic.run import ElasticRun
from ..simulation.run import Run, inputs_of
from ..visual.recording import traced
from .options import SIGNS, add_job_options, open_job, print_inputs, progress, say_written, write_report

if TYPE_CHECKING:
    from ..elasticity.impacts import ImpactsByTurn

BAR = "{percentage:3.0f} % |{bar}| {n:.3f} of {total:.3f} s, {remaining} to go"
EXAMPLE = """\
e.g. press.yaml, with its table or file: zxn2_3000b:
  loads: {draw: {kind: drawing, force: 1000 kN, start: 10 mm}}
  motor: {kind: induction, rated_power: 75 kW, rated_speed: 1485 r/min, inertia: 1.2 kg m2, ratio: 20.7}
  flywheel: 6000 kg m2
  run: {duration: 3 s, speed: 70 r/min}        # or steady: yes
pinpress simulate press.yaml --set run.duration=5s --out out
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `simulate` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "simulate",
        help="let a press run under motor, flywheel, clutch, brake and loads, or find its steady state",
        description="Let the press run as the section run says, or find its steady state. Prints speeds, energies, the motor's torque,\n"
        "the strokes and the peak force of every bearing. With elastic in the job the press runs on springs. With --out also writes\n"
        "simulation.csv (every quantity at every instant), strokes.csv (a line for each stroke), recording.html and report.html.",
        epilog=SIGNS + EXAMPLE,
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
    if options.out is not None:
        make_folder(options.out)  # before a run that may be long
    done = _run(job)
    began = time.perf_counter()
    reactions = inverse_dynamics(job.press, done, list(job.loads.values()), job.friction)
    took = time.perf_counter() - began
    print(f"{done.title}\n\n{written(_sections(done, reactions))}")
    words = f"{1e3 * done.stats.wall_time:.1f} ms simulation, {1e3 * took:.1f} ms torque and forces"
    few = "peaks are peaks of the states: if a blow falls between two states, raise run.points"
    blows = job.loads and job.elastic is not None and not job.sections["run"].get("steady")
    print("\n".join(entries([*([Figure("states", f"{len(done.time)}", where=few)] if blows else []), Figure("time taken", words)])))
    print_inputs(job, [*inputs_of(reactions), *(elastic_in_words(job.elastic) if job.elastic is not None else [])])
    if options.out is not None:
        from ..visual.recording import record  # slow to import

        (reactions if job.elastic is None else done).to_csv(options.out / "simulation.csv")
        names = ["simulation.csv"]
        if len(job.press.drivers) == 1:  # several have no strokes of one crank
            stroke_duties(done).to_csv(options.out / "strokes.csv")
            names.append("strokes.csv")
        record(job.press, done, options.out / "recording.html", reactions=reactions, traces=traces_of(job), flywheel=job.flywheel)
        pages = write_report(job, options.out, results=_beside(job, done), reactions=reactions)
        say_written(options.out, [*names, "recording.html", *pages])
    return 0


def _run(job: Job) -> Run:
    duration = job.sections.get("run", {}).get("duration")
    if duration is None:
        return job.simulate()
    with progress(duration, BAR) as told:
        return job.simulate(progress=told)


def _sections(run: Run, reactions: Reactions) -> list[Section]:
    """Sections of a printed run: its results, its forces, and the residuals of the equations."""
    forces = [part for part in reactions.described() if part.title not in ("Motion", "Slide", "Process")]
    if isinstance(run, ElasticRun):
        forces = [part for part in forces if part.title == "Checks"]
        forces[:0] = [part for found in journals(run) for part in found.described()]
    *forces, checks = forces
    return [*run.described(), *forces, replace(checks, figures=[*checks.figures, *numerics(run)])]


def _beside(job: Job, run: Run) -> list[Tabular]:
    """Additional results for the page of an elastic run: its vibrations, or the impacts of journals with clearance."""
    if not isinstance(run, ElasticRun):
        return []
    from ..elasticity.vibration import natural_frequencies  # seldom needed

    if run.elastic.clearances:
        return list(journals(run))
    return [natural_frequencies(job.press, run.elastic)]


def journals(run: ElasticRun) -> list[ImpactsByTurn]:
    """Impacts of journals with clearance, for a run of at least one turn."""
    from ..elasticity.impacts import journal_impacts  # seldom needed

    if abs(run.crank_angle[-1] - run.crank_angle[0]) < 2 * np.pi:
        return []
    return [journal_impacts(run, name) for name in run.elastic.clearances]
