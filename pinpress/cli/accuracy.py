"""`pinpress accuracy`: compare the errors and run times of all engines and methods."""

import argparse

from ..accuracy.scenes import SCENES
from ..common.files import make_folder
from ..common.quantities import RPM
from ..dynamics.inputs import described, of_press, stated
from .words import part_specs
from .words.outputs import add_out_option, print_inputs, write_pictures
from .words.press import add_press_options, load_press
from .words.progress import progress
from .words.units import quantity

EPILOG = """\
Every error is relative to a reference on which two independent methods agree; the table shows how closely they agree. Times are the least
of several rounds in which all methods take turns. The plot needs 'pinpress[plots]'.
e.g. pinpress accuracy zxn2_3000b --speed 70 --out out
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
    option(
        "--speed",
        type=quantity("r/min"),
        required=True,
        metavar="RPM",
        help="crank speed, in the period and at the start of the runs, in r/min",
    )
    option("--flywheel", metavar="J", help="inertia at the driver joint, in kg m2 (default: 4 times the linkage's inertia)")
    option("--duration", type=quantity("s"), metavar="S", help="length of each run, in s (default: two turns at that speed)")
    option("--points", type=int, default=360, metavar="N", help="number of crank angles in the period (default: %(default)s)")
    option("--repeats", type=int, default=3, metavar="N", help="rounds of timing (default: %(default)s)")
    option(
        "--scene", action="append", choices=SCENES, metavar="SCENE", help=f"scene to simulate, one of: {', '.join(SCENES)} (default: all)"
    )
    add_press_options(parser)
    add_out_option(parser, "accuracy.csv and accuracy.png")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the tables and write the files.

    Raises:
        PinpressError: Loading, measuring or writing fails.
    """
    from ..accuracy.work_precision import compare, plot  # slow to import: mistakes in the options are reported before

    flywheel = part_specs.flywheel(options.flywheel)
    press = load_press(options)
    if options.out is not None:
        make_folder(options.out)
    scenes = options.scene or SCENES
    with progress(1.0, BAR) as told:
        measured = compare(
            press,
            options.speed * RPM,
            flywheel=flywheel,
            duration=options.duration,
            points=options.points,
            repeats=options.repeats,
            scenes=scenes,
            progress=told,
        )
    print(measured)
    turning = [] if flywheel is None else [("flywheel", described(flywheel))]
    print_inputs([*of_press(press), ("speed", f"{options.speed:g} r/min"), *turning, ("scenes", ", ".join(scenes)), stated()])
    if options.out is not None:
        measured.to_csv(options.out / "accuracy.csv")  # first, so that no measurement is lost if Matplotlib is missing
        write_pictures(options.out, ["accuracy.csv"], lambda: {"accuracy.png": plot(measured)})
    return 0
