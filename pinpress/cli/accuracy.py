"""`pinpress accuracy`: compare the errors and run times of all engines and methods."""

import argparse

from ..accuracy.scenes import SCENES
from ..common.errors import PinpressError
from ..common.files import make_folder
from ..common.quantities import RPM
from ..drives.transmission import Flywheel
from ..dynamics.inputs import of_press, row, stated
from .options import add_job_options, open_job, print_inputs, progress, write_pictures

EPILOG = """\
Every error is relative to a reference on which two independent methods agree; the table shows how closely they agree. Times are the least
of several rounds in which all methods take turns. The plot needs 'pinpress[plots]'.
The runs begin at the speed of the job, with its flywheel (default: 4 times the linkage's inertia), and last run.duration (default: two
turns at that speed).
e.g. pinpress accuracy zxn2_3000b --speed 70r/min --out out
"""
BAR = "{percentage:3.0f} % |{bar}| {remaining} to go"


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `accuracy` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "accuracy",
        help="error against run time of all engines and methods for a press",
        description="Measure a press: inverse dynamics by all engines, and simulations by all methods over tolerances and steps\n"
        "(freely, with clutch and blank, on a stiff die, under a stiff drive). Prints tables; with --out also writes\n"
        "accuracy.csv and accuracy.png.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_job_options(parser, "accuracy.csv and accuracy.png")
    option("--points", type=int, default=360, metavar="N", help="number of crank angles in the period (default: %(default)s)")
    option("--repeats", type=int, default=3, metavar="N", help="rounds of timing (default: %(default)s)")
    option(
        "--scene", action="append", choices=SCENES, metavar="SCENE", help=f"scene to simulate, one of: {', '.join(SCENES)} (default: all)"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the tables and write the files.

    Raises:
        PinpressError: Loading, measuring or writing fails.
    """
    from ..accuracy.work_precision import compare, plot  # slow to import: mistakes in the options are reported before

    job = open_job(options)
    press, flywheel = job.press, job.flywheel if isinstance(job.flywheel, Flywheel) else None
    if job.speed is None:
        raise PinpressError("a comparison needs the crank's speed: give --speed 70r/min")
    if options.out is not None:
        make_folder(options.out)
    scenes = options.scene or SCENES
    with progress(1.0, BAR) as told:
        measured = compare(
            press,
            job.speed,
            flywheel=flywheel,
            duration=job.sections.get("run", {}).get("duration"),
            points=options.points,
            repeats=options.repeats,
            scenes=scenes,
            progress=told,
        )
    print(measured)
    turning = [] if flywheel is None else [row("flywheel", flywheel)]
    print_inputs(job, [*of_press(press), ("speed", f"{job.speed / RPM:g} r/min"), *turning, ("scenes", ", ".join(scenes)), stated()])
    if options.out is not None:
        measured.to_csv(options.out / "accuracy.csv")  # first, so that no measurement is lost if Matplotlib is missing
        write_pictures(options.out, ["accuracy.csv"], lambda: {"accuracy.png": plot(measured)})
    return 0
