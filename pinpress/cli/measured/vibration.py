"""`pinpress measured vibration`: find modes and mounts of a frame from hits, or orders of a running press, from accelerometers."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ...common.errors import PinpressError
from ...common.files import make_folder
from ...dynamics.inputs import Inputs, of_press, stated
from ...jobs.job import Job
from ..options import numbers, open_job, print_inputs, write_pictures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...common.results import Tabular
    from ...foundation.mounted_press import MountedPress
    from ...measured.hit_modes import MeasuredModes
    from ...measured.vibration_record import VibrationRecord
    from ...measured.vibration_spectra import OrderSpectra

EPILOG = """\
--points is a CSV file with the columns channel (with its unit, "A [g]"), x, y, z [m], direction (x, -z, ...) and, if needed, part (bed or
crown) and gain [m/s2 per V]. Records are .csv, .parquet, .mat or .mf4 files with these channels, all in equal steps of time.

For a frame at rest that is hit with a soft hammer, the command finds the modes. Give --band, or --job with a foundation: then the measured
modes are compared with calculated modes, and --fit finds stiffness and damping of the mounts.

For a running press with --angle, --tacho or --speed of the crank, the command finds amplitudes by order of the speed.

e.g. pinpress measured vibration hits.csv --points points.csv --band "3 100 Hz" --out out
     pinpress measured vibration run.csv --points points.csv --angle "crank [deg]" --orders 6 --out out
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `vibration` among those of `measured`; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "vibration",
        help="natural frequencies, damping and mounts from hits on the frame, or orders of the running press, from accelerometers",
        description="Print the modes of a frame from hits, with their deviations, and compare them with calculated modes if the frame is\n"
        "given; or print the orders of a running press. With --out also writes channels.csv, spectra.csv, modes.csv or orders.csv,\n"
        "with --fit mounts.csv, and if Matplotlib is installed spectra.png, modes.png or orders.png.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("records", nargs="+", metavar="RECORD", help="files of measured columns, all with the same channels")
    option("--points", type=Path, required=True, metavar="CSV", help="places and directions of the accelerometers, see below")
    option("--time", metavar="COLUMN", help="column of the time (default: time or t)")
    option("--angle", metavar="COLUMN", help="crank angle of a running press, rad, deg or turns")
    option("--tacho", metavar="COLUMN", help="pulses of a tacho on the crank of a running press")
    option("--pulses", type=int, default=1, metavar="N", help="pulses of the tacho in a turn of the crank (default: 1)")
    option(
        "--speed",
        type=numbers("rad/s"),
        metavar="SPEEDS",
        help="constant speed of a running press, such as 200r/min: one speed, or one for each record",
    )
    option("--orders", type=float, default=12.0, metavar="N", help="highest order (default: %(default)g)")
    option(
        "--band",
        type=numbers("Hz"),
        metavar="BAND",
        help='lowest and highest frequency of modes, such as "3 100 Hz" (default: from the calculated modes)',
    )
    option("--count", type=int, metavar="N", help="number of modes (default: all modes above the noise)")
    option("--job", dest="file", metavar="FILE", help="the press with its foundation, for calculated modes")
    option("--variant", metavar="NAME", help="one of the job's variants")
    option("--set", metavar="NAME=VALUE", action="append", default=[], help="another value of the job, as for other commands")
    option("--fit", action="store_true", help="fit stiffness and damping of the mounts to the measured modes")
    option("--out", type=Path, metavar="DIR", help="folder for the files; made if there is none")
    parser.set_defaults(run=run, load=[])


def run(options: argparse.Namespace) -> int:
    """Print modes or orders, and write the files.

    Raises:
        PinpressError: options do not go together, a record or its points are wrong, or computing or writing fails.
    """
    from ...measured.mount_fit import fit_mounts  # imported here to save start-up time of other commands
    from ...measured.vibration_record import vibration

    running = any(each is not None for each in (options.angle, options.tacho, options.speed))
    _refuse_what_does_not_go_together(options, running)
    job = None if running or options.file is None else open_job(options)
    system = _standing(job)
    asked = {name: getattr(options, name) for name in ("time", "angle", "tacho", "pulses", "speed")}
    record = vibration(options.records, options.points, **asked)
    orders = record.order_spectra(options.orders) if running else None
    found = None if running else _modes(record, system, options)
    fitted = fit_mounts(system, found) if options.fit and system is not None and found is not None else None
    if options.out is not None:
        make_folder(options.out)
    parts: dict[str, Tabular | None] = {"channels": record, "orders": orders, "modes": found, "mounts": fitted}
    results = {name: each for name, each in parts.items() if each is not None}
    print("\n\n".join(map(str, results.values())))
    print_inputs(job, _inputs(job, options))
    if options.out is not None:
        _write(record, results, orders, found, options.out)
    return 0


def _refuse_what_does_not_go_together(options: argparse.Namespace, running: bool) -> None:
    of_hits = [f"--{name}" for name in ("band", "count", "job", "fit") if getattr(options, "file" if name == "job" else name)]
    if running and of_hits:
        raise PinpressError(
            f"{of_hits[0]} is for hits on a frame at rest, but a turning crank is given: leave out one of them. Orders of a running press"
            " look like modes"
        )
    if options.fit and options.file is None:
        raise PinpressError("--fit needs the mounts as described: also give --job, a press with its foundation")
    if options.band is not None and len(options.band) != 2:
        raise PinpressError(f"--band has {len(options.band)} numbers: give the lowest and the highest frequency, --band '3 100 Hz'")
    if not running and options.file is None and options.band is None:
        raise PinpressError(
            "the band of frequencies is missing: give --band '3 100 Hz', or --job with a foundation; for a running press give --angle,"
            " --tacho or --speed"
        )


def _standing(job: Job | None) -> MountedPress | None:
    """The press on its mounts as described; None if it is not given."""
    if job is None:
        return None
    _ = job.need("foundation")
    return job.mounted


def _modes(record: VibrationRecord, system: MountedPress | None, options: argparse.Namespace) -> MeasuredModes:
    """The measured modes, compared with the calculated modes if the press is given."""
    from ...foundation.mounted_press import modes  # to save start-up time

    return record.modes(None if system is None else modes(system), band=options.band, count=options.count)


def _inputs(job: Job | None, options: argparse.Namespace) -> Inputs:
    """Inputs as text."""
    given = [("records", ", ".join(options.records)), ("points", str(options.points))]
    return [*([] if job is None else of_press(job.press)), *given, stated()]


def _write(
    record: VibrationRecord, results: dict[str, Tabular], orders: OrderSpectra | None, found: MeasuredModes | None, folder: Path
) -> None:
    """Write the files, and print their names."""
    spectra = record.spectra()
    tables = {**results, "spectra": spectra}
    for name, each in tables.items():
        each.to_csv(folder / f"{name}.csv")
    names = [f"{name}.csv" for name in tables]

    def draw() -> dict[str, Figure]:
        from ...plots import charts  # slow to import

        pictures = {"spectra.png": charts.draw(spectra, "spectra")}
        if orders is not None:
            strongest = max(range(len(orders.channels)), key=lambda k: float(orders.amplitude[..., k].max()))
            pictures["orders.png"] = charts.draw(orders, f"orders {orders.channels[strongest]}")
        if found is not None and found.beside is not None:
            pictures["modes.png"] = charts.draw(found, "damping", "mac")
        return pictures

    write_pictures(folder, names, draw)
