"""`pinpress convert`: a linkage in the format of another program."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..common.errors import PinpressError
from ..linkage.formats.urdf_writer import DIALECTS
from ..linkage.linkage import Linkage
from .options import FILE, open_job

EPILOG = """\
pinpress convert robot.urdf robot.sdf                  for Gazebo
pinpress convert robot.urdf robot.xml                  for MuJoCo
pinpress convert press.yaml press.urdf --home          for programs that start where all joints are at zero
pinpress convert robot.xml robot.urdf --dialect urdf+ --set "drivers=left right"
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `convert` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "convert",
        help="write a linkage in the format of another program: URDF and its dialects, SDF, MJCF",
        description="Write a linkage as URDF (.urdf), SDF for Gazebo (.sdf) or MJCF for MuJoCo (.xml), by the ending of OUT. Warnings say\n"
        "what the other format does not hold. SDF has its zeros in the closed pose; URDF and MJCF keep the zeros of FILE.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("file", metavar="FILE", help=FILE)
    option("out", metavar="OUT", type=Path, help="the file to write; one of this name is replaced")
    option("--set", metavar="NAME=VALUE", action="append", default=[], help="another value, such as drivers=left, slide=ram, r=150")
    option("--home", action="store_true", help="joints of a URDF are at zero in the closed pose, and not where FILE has their zeros")
    option("--dialect", choices=DIALECTS, default=DIALECTS[0], help="how a URDF says loops, gears and drivers (default: %(default)s)")
    parser.set_defaults(run=run, variant=None, load=[])


def run(options: argparse.Namespace) -> int:
    """Write the file, and print what is in it.

    Returns:
        The exit code, 0.

    Raises:
        PinpressError: the linkage cannot be loaded, the format does not hold it, or the file cannot be written.
    """
    out: Path = options.out
    form = _form(out)
    if form != "URDF" and (options.home or options.dialect != DIALECTS[0]):
        raise PinpressError(f"{out} is {form}: --home and --dialect are of a URDF; {form} starts in the closed pose in any case")
    if out.exists() and Path(options.file).exists() and out.samefile(options.file):
        raise PinpressError(f"{out} is the file to convert: give another name")
    press = open_job(options).press
    _write(press, out, form, options)
    counts = [
        (len(press.links), "links"),
        (len(press.joints), "moving joints"),
        (len(press.loops), "loops"),
        (len(press.motors), "drivers"),
    ]
    counted = ", ".join(f"{count} {what}" for count, what in counts)
    print(f"wrote {out}: {counted}; mobility {press.mobility}")
    return 0


def _form(out: Path) -> str:
    forms = {".urdf": "URDF", ".sdf": "SDF", ".xml": "MJCF"}
    if out.suffix.lower() not in forms:
        raise PinpressError(f"{out} has none of the endings {', '.join(forms)}: its ending says the format")
    return forms[out.suffix.lower()]


def _write(press: Linkage, out: Path, form: str, options: argparse.Namespace) -> None:
    if form == "SDF":
        from ..linkage.formats.sdf_writer import write_sdf  # seldom needed, as the others

        write_sdf(press, out)
    elif form == "MJCF":
        from ..linkage.formats.mjcf_writer import write_mjcf  # as above

        write_mjcf(press, out)
    else:
        from ..linkage.writing import write_urdf  # as above

        write_urdf(press, out, home=options.home, dialect=options.dialect)
