"""`pinpress FILE`: everything that the sections of a job allow, printed and on a page."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..common.errors import PinpressError
from ..common.outlets.text import written
from ..dynamics.inputs import inputs
from ..jobs.job import motion_of, results_of, write_report
from .options import SHORT, add_job_options, open_job, print_inputs, refuse_present

MARK = b'<meta name="generator" content="pinpress">'  # in every page of ours


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `report` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "report",
        help="all that a job allows, as text and as a page; pinpress FILE is short for it",
        description="Compute all that the sections of a job allow, print it, and write a page to open by double click: the press turning\n"
        "with its forces, charts that follow it, a part for each result, and all inputs.",
        epilog=SHORT + "pinpress press.yaml; pinpress press.yaml --variant hard_steel --set speed=60r/min --out page.html --pdf page.pdf",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_job_options(parser)
    option = parser.add_argument
    option("--out", type=Path, metavar="HTML", help="the page (default: the name of the job with .html, in this folder)")
    option("--pdf", type=Path, metavar="PDF", help="print the page to this file (needs Chromium and pip install 'pinpress[video]')")
    option("--modes", type=Path, metavar="HTML", help="also write a page in which the frame on its mounts swings in its lowest modes")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the results, write the page, and print its name.

    Raises:
        PinpressError: the job is wrong, or computing or writing fails.
    """
    if options.out is not None and options.out.suffix.lower() == ".pdf":
        raise PinpressError(f"--out writes a web page: give --pdf {options.out}, or --out {options.out.with_suffix('.html')}")
    job = open_job(options)
    out = options.out or Path(f"{Path(options.file).stem}.html")
    refuse_present(out, MARK, "give another name by --out")
    if options.modes is not None and job.mounted is None:
        raise PinpressError("--modes shows the frame on its mounts: write a foundation into the job, or leave --modes out")
    results = [*results_of(job)]
    reactions = motion_of(job)
    print(f"{reactions.title}\n\n{written(reactions.described())}")
    for each in results:
        print(f"\n{each}")
    print_inputs(job, inputs(reactions))
    write_report(job, out, results=results)
    names = [out]
    if options.pdf is not None:
        from ..visual.film import pdf  # slow to import

        pdf(out, options.pdf)
        names.append(options.pdf)
    if options.modes is not None:
        from ..foundation.mounted_press import VibrationModes  # seldom needed
        from ..foundation.whirl_modes import WhirlDiagram
        from ..visual.swinging import MOST, record_modes

        swinging = [each for each in results if isinstance(each, VibrationModes | WhirlDiagram)][-1]
        record_modes(job.press, swinging, options.modes, lowest=MOST)
        names.append(options.modes)
    print(f"\nwrote {' and '.join(map(str, names))}")
    return 0
