"""`pinpress export`: a press for a controller or another program, as C, FMU or MATLAB."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..common.errors import PinpressError
from ..common.tables import cell, fitted
from ..export.c_source import c_code
from ..export.fmi import fmu
from ..export.m_file import matlab
from ..export.tabulation import stands, tabulate
from ..linkage.loading import presses
from .options import add_job_options, open_job

EPILOG = """\
pinpress export press.yaml --to fmu                          press.fmu, for Simulink and other tools that import an FMU
pinpress export zxn2_3000b --to c --bearing A --bearing F    press code in C99, zxn2_3000b.c and .h, with the forces of two bearings
pinpress export press.yaml --to c --no-bearings --single     slide, driving torque and equation of motion, for a small controller
pinpress export press.yaml --to fmu --compiler "python -m ziglang cc -target x86_64-windows-gnu" --platform win64
"""
ENDINGS = {"c": ".c", "fmu": ".fmu", "m": ".m"}


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `export` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "export",
        help="write a press as C, as an FMU or as MATLAB, which run without Python",
        description="Write a press as a table of its angle: slide, driving torque, shaking force and bearing forces of any state, and the\n"
        "equation of motion. Weights, springs and constant loads are in it; process loads and motors stay outside.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_job_options(parser, speed=False)
    option = parser.add_argument
    option("--to", choices=ENDINGS, required=True, help="c: C99 (.c and .h); fmu: FMI 2.0; m: a function of MATLAB and Octave")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--bearing", metavar="NAME", action="append", help="a bearing with its force and moment; without this option all")
    which.add_argument("--no-bearings", action="store_true", help="slide and driving torque alone")
    option("--tolerance", type=float, default=1e-9, metavar="SHARE", help="share that the table may miss (default: %(default)s)")
    option("--single", action="store_true", help="C tables with 4 bytes a number, exact to 1e-7 of the largest values")
    option("--compiler", metavar="COMMAND", help="C compiler for the binary of an FMU (default: cc)")
    option("--platform", help="FMI's name of the platform for which it compiles, such as win64; by default this machine's")
    option("--out", type=Path, metavar="FILE", help="the file to write; by default FILE's name with the ending of the format")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the files, and print what is in them and how exact they are.

    Returns:
        The exit code, 0.

    Raises:
        PinpressError: see `tabulate`, `c_code`, `fmu` and `matlab`.
    """
    if options.single and options.to != "c":
        raise PinpressError(f"--single is of C tables: leave it out with --to {options.to}")
    if (options.compiler or options.platform) and options.to != "fmu":
        raise PinpressError(f"--compiler and --platform are of an FMU: leave them out with --to {options.to}")
    job = open_job(options)
    bearings = () if options.no_bearings else options.bearing
    loads = {name: load for name, load in job.loads.items() if stands(load)}
    table = tabulate(job.press, bearings, [*loads.values()], tolerance=options.tolerance, friction=job.friction, stiffness=job.stiffness)
    name = Path(options.file).stem if options.file not in presses() else options.file
    out: Path = options.out or Path(name).with_suffix(ENDINGS[options.to])
    written: tuple[Path, ...]
    if options.to == "c":
        written = c_code(table, out, single=options.single)
    elif options.to == "fmu":
        written = (fmu(table, out, compiler=options.compiler or "cc", platform=options.platform),)
    else:
        written = (matlab(table, out),)
    columns = table.columns()
    rows = [list(columns), *([cell(value) for value in row] for row in zip(*columns.values(), strict=True))]
    print("\n".join([table.title, "", *fitted(rows)]))
    if left := [each for each in job.loads if each not in loads]:
        print(f"\nleft outside, as forces that the program gives: {', '.join(left)}")
    if job.elastic is not None:
        print("\nthe table is of the rigid press, without elastic")
    sizes = ", ".join(f"{path} ({path.stat().st_size / 1e3:.0f} kB)" for path in written)
    print(f"\nwrote {sizes}")
    return 0
