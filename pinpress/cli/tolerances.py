"""`pinpress tolerances`: the scatter of bottom dead centre, the dimensions that cause it, and the cheapest tolerances."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..common.files import make_folder
from ..dynamics.inputs import of_press, stated
from .options import add_job_options, open_job, print_inputs, write_pictures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..jobs.job import Job
    from ..tolerances.accuracy_budget import AccuracyBudget
    from ..tolerances.allocation import AllocatedTolerances

EXAMPLE = """\
e.g. press.yaml, with its table or file: zxn2_3000b:
  tolerances:
    dimensions: {length E F: 0.05 mm, angle C D E: 0.01 deg, position A x: {tolerance: 0.1 mm, shape: uniform}}   # or a CSV file
    within: 50 um
    targets: {height: 50 um}                                    # the cheapest tolerances that keep it
    forces: [{height: 6 mm, force: 3000 kN}]                    # the crank's torque there
    budget: {speeds: 10 50 70 r/min, warm: {rod: 10 K}, process: 500 kN}
  bearings: {F: {clearance: 50 um, stiffness: 3 GN/m}}          # for the budget
A number of a table of pins is a dimension too: r: 0.05 mm, or pins.D.1: 0.1 mm.
A table of dimensions has the columns dimension, tolerance, and if wanted unit (mm, um, m, deg, rad), shape (normal, uniform, truncated),
sd, name, cost (half the tolerance costs twice as much), smallest, largest.
pinpress tolerances press.yaml --out out
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `tolerances` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "tolerances",
        help="scatter of bottom dead centre and stroke, the dimensions that cause it, and the cheapest tolerances",
        description="Compute a sample of presses with dimensions that scatter, and print the scatter of their dead centres: the band of\n"
        "99.73 % of the presses, the worst corners, the dimensions by their shares. With targets find the cheapest tolerances, with\n"
        "proof; with a budget print the shift of bottom dead centre by clearances, springs and heat over the speed. With --out also\n"
        "write dimensions.csv, allocated.csv, budget.csv, and if Matplotlib is installed tolerances.png and budget.png.",
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_job_options(parser, "the files", speed=False)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the effect of tolerances on the press, and write the files.

    Raises:
        PinpressError: the job is wrong, presses cannot be assembled, a target cannot be met, or writing fails.
    """
    job = open_job(options)
    given, found = job.need("tolerances"), job.scatter()
    budgeted = job.budget() if "budget" in given else None
    allocated = job.allocate() if given.get("targets") else None
    print(found)
    if "within" in given:
        share = found.within(given["within"])
        print(f"  within {1e6 * given['within']:g} um at bottom dead centre: {100 * share:.4g} % of the presses")
    for each in (allocated, budgeted):
        if each is not None:
            print(f"\n{each}")
    where = f" of {given['dimensions']}" if isinstance(given["dimensions"], Path) else ""
    sample = f"{len(found.height.deviation)} presses, seed {given.get('seed', 0)}"
    print_inputs(job, [*of_press(job.press), ("dimensions", f"{len(job.dimensions.parts)}{where}"), ("sample", sample), stated()])
    if options.out is not None:
        make_folder(options.out)
        _write(job, allocated, budgeted, options.out)
    return 0


def _write(job: Job, allocated: AllocatedTolerances | None, budgeted: AccuracyBudget | None, folder: Path) -> None:
    """Write the files, and print their names."""
    found, names = job.scatter(), ["dimensions.csv"]
    found.to_csv(folder / "dimensions.csv")
    for each, name in ((allocated, "allocated.csv"), (budgeted, "budget.csv")):
        if each is not None:
            each.to_csv(folder / name)
            names.append(name)

    def draw() -> dict[str, Figure]:
        from ..plots import charts  # slow to import

        within = job.sections["tolerances"].get("within")
        height = found.height if within is None else found.height.with_limit(within)
        pictures = {"tolerances.png": charts.draw(height, "shares", "presses")}
        return pictures if budgeted is None else pictures | {"budget.png": charts.draw(budgeted, "parts")}

    write_pictures(folder, names, draw)
