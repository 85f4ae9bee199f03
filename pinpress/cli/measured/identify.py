"""`pinpress measured identify`: find masses, friction, balance cylinder and motor constant of a press from records of idle running."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...common.errors import PinpressError, shown
from ...common.files import make_folder
from ...dynamics.inputs import of_press, stated
from ..options import add_job_options, number, open_job, print_inputs, write_pictures
from .records import add_column_options, add_identification_options, identification, identification_in_words, read_record

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...measured.identification import IdentifiedPress
    from ...measured.records import MeasuredRun
    from ...measured.what_is_known import IdentifiableParameters

EPILOG = """\
Records are .csv, .parquet, .mat or .mf4 files of the press running idle; name their columns with units, --angle "crank [deg]".
Measure at three or more speeds, or with speeds that swing by a third in 2.6 strokes. One constant speed does not separate masses from
friction.
e.g. pinpress measured identify zxn2_3000b docs/records/21.csv docs/records/42.csv docs/records/63.csv
     --angle "crank [deg]" --torque "motor [N m]" --ratio 20.7 --friction crank,gibs --cylinder --out out
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `identify` among those of `measured`; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "identify",
        help="masses, friction, balance cylinder of a press from records of crank angle and motor torque",
        description="Print what records of a running press can show, and what they show: masses, inertias, friction, balance cylinder and\n"
        "motor constant with 95 % intervals. With --out also writes identified.urdf, parameters.csv, and if Matplotlib is\n"
        "installed identifiability.png.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_job_options(parser, "the files", speed=False)
    option("records", nargs="+", metavar="RECORD", help="files of measured columns")
    add_column_options(parser)
    option(
        "--added",
        action="append",
        default=[],
        metavar="RECORD:LINK=MASS",
        help="mass fastened to a link for one record (needed with currents)",
    )
    add_identification_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what the records can show and what they show, and write the files.

    Raises:
        PinpressError: an option or a record is wrong, or computing or writing fails.
    """
    from ...measured.identification import identify  # imported here to save start-up time of other commands
    from ...measured.what_is_known import identifiability

    job = open_job(options)
    press = job.press
    runs, asked = _runs(options), identification(options)
    revealed = identifiability(press, runs, **asked)
    found = identify(press, runs, **asked, drive_inertia=options.drive_inertia)
    if options.out is not None:
        make_folder(options.out)
    notes = [f"  {each.name}: {note}" for each in runs for note in each.notes]
    print("\n".join([*(each.title for each in runs), *notes, "", str(revealed), "", str(found)]))
    print_inputs(job, [*of_press(press), ("records", ", ".join(options.records)), *identification_in_words(options), stated()])
    if options.out is not None:
        _write(found, revealed, options.out)
    return 0


def _runs(options: argparse.Namespace) -> list[MeasuredRun]:
    """The records that the options name."""
    added = _added(options.added, options.records)
    return [read_record(options, file, added_mass=added.get(file, {})) for file in options.records]


def _added(words: Sequence[str], records: Sequence[str]) -> dict[str, dict[str, float]]:
    """Masses by record and link."""
    found: dict[str, dict[str, float]] = {}
    for text in words:
        file, _, rest = text.rpartition(":")
        link, _, mass = rest.partition("=")
        matching = [each for each in records if file and (each == file or Path(each).name == file)]
        if len(matching) != 1 or not link or not mass:
            raise PinpressError(
                f"--added {shown(text)} names no record: write RECORD:LINK=MASS, as in --added {Path(records[0]).name}:slide=200kg"
            )
        try:
            found.setdefault(matching[0], {})[link] = number("kg")(mass)
        except argparse.ArgumentTypeError as error:
            raise PinpressError(f"--added {text}: {error}") from None
    return found


def _write(found: IdentifiedPress, revealed: IdentifiableParameters, folder: Path) -> None:
    """Write the files, and print their names."""
    from ...linkage.writing import write_urdf  # to save start-up time

    names = ["identified.urdf", "parameters.csv"]
    write_urdf(found.press, folder / names[0])
    found.to_csv(folder / names[1])

    def draw() -> dict[str, Figure]:
        from ...plots import charts  # slow to import

        return {"identifiability.png": charts.draw(revealed, "doubt")}

    write_pictures(folder, names, draw)
