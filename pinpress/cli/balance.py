"""`pinpress balance`: the best counterweights of a press."""

import argparse
from pathlib import Path

from ..common.files import make_folder
from ..dynamics.inputs import motion_in_words, of_loads, of_press, stated
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..jobs.job import Job
from ..linkage.writing import write_urdf
from .options import add_job_options, open_job, print_inputs, say_written, write_report

EXAMPLE = """\
Regions are those of links: radius (with centre), corners, at a point, or replaces: yes for the link itself in another size; mass is the
least and the largest. Criteria are the range, rms or peak of a force, moment or torque, or the added mass. Range and rms leave out the
constant part. With several dies, settings or speeds a region may say reset: mass or position, what is adjusted for each of them.
e.g. press.yaml, with its table or file: zxn2_3000b:
  speed: 70 r/min
  balance:
    regions: {crank: {radius: 300 mm}, rod: {radius: 300 mm, mass: 0 200 kg}}
    minimise: {kind: range, quantity: shaking_force, axis: z}
    limits: [{kind: range, quantity: shaking_force, axis: x, most: 100 kN}, {kind: added-mass, most: 661 kg}]
    dies: 0 300 kg
pinpress balance press.yaml --out out
"""


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `balance` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "balance",
        help="the counterweights that minimise shaking forces, torque or bearing forces, with proof",
        description="Find the best counterweights in the regions of the job, and prove that they are optimal. Prints them, the limits\n"
        "that act, and all forces before and after. With --out also writes balanced.urdf, balance.csv (forces before and after),\n"
        "counterweights.csv, and report.html: the balanced press, dashed before.",
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_job_options(parser, "the files")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the counterweights with their effects, and write the files.

    Raises:
        PinpressError: the job is wrong, or computing or writing fails.
    """
    job = open_job(options)
    balanced = job.balance()
    print(balanced)
    motions = [("motion", motion_in_words(condition.motion)) for condition in balanced.conditions]
    print_inputs(job, [*of_press(balanced.original), *motions, *of_loads(balanced.conditions[0].loads), stated()])
    if options.out is not None:
        make_folder(options.out)
        _write(job, options.out)
    return 0


def _write(job: Job, folder: Path) -> None:
    """Write the files, and print their names. The URDF is drawn as the press's file draws it, wherever its angles are counted from."""
    balanced, as_drawn = job.balance(), job.as_drawn
    write_urdf(as_drawn.with_inertias(list(balanced.press.model.inertias), balanced.press.name), folder / "balanced.urdf")
    balanced.to_csv(folder / "balance.csv")
    anew = any(weights != balanced.counterweights for weights in balanced.settings)
    files = {f"counterweights_{k}.csv" if anew else "counterweights.csv": weights for k, weights in enumerate(balanced.settings)}
    for file, weights in files.items():
        weights.to_csv(folder / file)
    # with all bearings, of which balancing computes only those that are asked for
    first, press = balanced.conditions[0], balanced.presses[0]
    before = inverse_dynamics(first.set_up(balanced.original), balanced.reactions_before[0].motion, first.loads)
    after = inverse_dynamics(press, balanced.reactions_after[0].motion, first.loads)
    page = write_report(job, folder, results=[balanced], reactions=after, before=before)
    say_written(folder, ["balanced.urdf", "balance.csv", *files, *page])
