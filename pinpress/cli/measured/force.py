"""`pinpress measured force`: find the process force over the height of the slide from records of crank angle and motor torque."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...common import tables
from ...common.errors import PinpressError
from ...common.files import make_folder
from ...dynamics.inputs import of_press, stated
from ..options import add_job_options, number, numbers, open_job, print_inputs, write_pictures
from .records import add_column_options, add_identification_options, identification, identification_in_words, read_record

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...linkage.linkage import Linkage
    from ...measured.identification import IdentifiedPress
    from ...measured.records import MeasuredRun
    from ...measured.stroke_force import MeasuredForce

DRAWN = 6  # most strokes in the picture
EPILOG = """\
Records are .csv, .parquet, .mat or .mf4 files of the press at work; name their columns with units, --angle "crank [deg]".
With --idle (records without a blank) the press is identified first (see pinpress measured identify): masses, friction, balance
cylinder and zero of the encoder. Without --idle the press is as described and has no friction.
e.g. pinpress measured force zxn2_3000b docs/records/stroke.csv --idle docs/records/21.csv --idle docs/records/42.csv
     --idle docs/records/63.csv
     --angle "crank [deg]" --torque "motor [N m]" --ratio 20.7 --friction crank,gibs --cylinder
     --heights "0 1 2 3 4 5 6 7 8 9 10 11 mm" --heights-up "0 2 5 9 mm" --out out
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `force` among those of `measured`; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "force",
        help="process force over the height, from records of crank angle and motor torque",
        description="Print the largest force and the work of each stroke, with 95 % bands, and the force over the height of the stroke\n"
        "with most work. With --out also writes for each record RECORD_force.csv, all strokes over the height, and\n"
        "RECORD_strokes.csv, and if Matplotlib is installed force.png.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_job_options(parser, "the files", speed=False)
    option("records", nargs="+", metavar="RECORD", help="files of measured columns, the press at work")
    option(
        "--idle", action="append", default=[], metavar="RECORD", help="a record of the press without a blank; may be given several times"
    )
    heights = 'heights above bottom dead centre between which the force is linear, on the way {}, such as "0 1 2 5 10 mm"'
    option("--heights", type=numbers("m"), required=True, metavar="HEIGHTS", help=heights.format("down"))
    option(
        "--heights-up", type=numbers("m"), default=[], metavar="HEIGHTS", help=heights.format("up; without it no force acts on the way up")
    )
    add_column_options(parser)
    add_identification_options(parser)
    option(
        "--stiffness",
        type=number("N/m"),
        metavar="N/m",
        help="stiffness of the press between crank and die: the slide lags behind under force",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the forces, and write the files.

    Raises:
        PinpressError: an option or a record is wrong, or computing or writing fails.
    """
    from ...measured.stroke_force import force_sensor  # to save start-up time, that of all other commands

    _refuse_what_needs_idle_records(options)
    job = open_job(options)
    press = job.press
    runs = _by_name(options.records, options)
    found = _identified(press, options)
    sensor = force_sensor(
        press if found is None else found,
        options.heights,
        heights_up=options.heights_up,
        drive_inertia=options.drive_inertia,
        stiffness=options.stiffness,
    )
    strokes = {name: list(sensor.strokes(run)) or [sensor.force(run)] for name, run in runs.items()}
    if options.out is not None:
        make_folder(options.out)
    if found is not None:
        print(f"{found.title}\n")
    print("\n\n".join(_in_words(each) for each in strokes.values()))
    given = [("records", ", ".join(options.records))]
    given += [("idle", ", ".join(options.idle)), *identification_in_words(options)] if options.idle else []
    given += [("drive inertia", f"{options.drive_inertia:g} kg m2")] if options.drive_inertia else []
    print_inputs(job, [*of_press(press), *given, stated()])
    if options.out is not None:
        _write(strokes, options.out)
    return 0


def _refuse_what_needs_idle_records(options: argparse.Namespace) -> None:
    if not options.idle and (options.known or options.cylinder or options.friction != "crank,slide_guide"):
        raise PinpressError("--known, --friction and --cylinder need idle records: also give them, --idle 30.csv --idle 60.csv")


def _by_name(records: Sequence[str], options: argparse.Namespace) -> dict[str, MeasuredRun]:
    """Records by the names of their files without endings.

    Raises:
        PinpressError: two records have the same name; or as for `measured.record`.
    """
    found: dict[str, MeasuredRun] = {}
    for file in records:
        if Path(file).stem in found:
            raise PinpressError(
                f"two records are called {Path(file).stem}: give one of them another name, so that the files of both can be"
            )
        found[Path(file).stem] = read_record(options, file)
    return found


def _identified(press: Linkage, options: argparse.Namespace) -> IdentifiedPress | None:
    """Identify the press from idle records; None without idle records."""
    if not options.idle:
        return None
    from ...measured.identification import identify  # to save start-up time

    idle = [read_record(options, file) for file in options.idle]
    return identify(press, idle, **identification(options), drive_inertia=options.drive_inertia)


def _in_words(strokes: Sequence[MeasuredForce]) -> str:
    """The force of the stroke with most work; with several strokes also the largest force and the work of each stroke."""
    most = max(range(len(strokes)), key=lambda k: strokes[k].work)
    if len(strokes) == 1:
        return str(strokes[0])
    rows = [["stroke", "largest force", "at", "work"]]
    for count, each in enumerate(strokes, 1):
        k = int(each.force.argmax())
        largest = f"{1e-3 * each.force[k]:.4g} ± {2e-3 * each.deviation[k]:.2g} kN"
        rows.append(
            [str(count), largest, f"{1e3 * each.heights[k]:.4g} mm", f"{1e-3 * each.work:.4g} ± {2e-3 * each.work_deviation:.2g} kJ"]
        )
    return "\n".join([f"{strokes[0].name}: {len(strokes)} strokes", *tables.fitted(rows), f"stroke {most + 1}:", str(strokes[most])])


def _write(strokes: Mapping[str, Sequence[MeasuredForce]], folder: Path) -> None:
    """Write the files, and print their names."""
    names = []
    for name, forces in strokes.items():
        numbers = range(1, len(forces) + 1)
        parts = [each.columns() for each in forces]
        columns: dict[str, tables.Column] = {"stroke": [str(k) for k, part in zip(numbers, parts, strict=True) for _ in part["way"]]}
        columns |= {head: [value for part in parts for value in part[head]] for head in parts[0]}
        tables.write_csv(folder / f"{name}_force.csv", columns)
        each_stroke: dict[str, tables.Column] = {
            "stroke": [str(k) for k in numbers],
            "largest_force [N]": [float(each.force.max()) for each in forces],
            "work [J]": [each.work for each in forces],
            "work_deviation [J]": [each.work_deviation for each in forces],
        }
        tables.write_csv(folder / f"{name}_strokes.csv", each_stroke)
        names += [f"{name}_force.csv", f"{name}_strokes.csv"]
    several = {name if len(forces) == 1 else f"{name} {k}": each for name, forces in strokes.items() for k, each in enumerate(forces, 1)}
    drawn = {name: several[name] for name in tables.shortened(list(several), DRAWN) if name is not None}

    def draw() -> dict[str, Figure]:
        from ...plots import charts  # slow to import

        return {"force.png": charts.draw(drawn, "force")}

    write_pictures(folder, names, draw)
