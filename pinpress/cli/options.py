"""What commands have in common: the options of a job, what they print and write, and how they show the progress of long work."""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..common import tables
from ..common.errors import FileEntryError, PinpressError
from ..common.reading.entries import entry_of_text
from ..common.reading.filling import Around, Number, Numbers, Value
from ..dynamics.inputs import Inputs
from ..jobs.grammar import JOB
from ..jobs.job import Job, as_inputs, raise_first, read_job
from ..jobs.job import write_report as write_page
from ..jobs.sources import Source, source, with_loads
from ..linkage.loading import presses

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILE = f"a job or a table of pins (.yaml), a URDF, SDF or MJCF file, or a shipped press: {', '.join(presses())}"
SIGNS = """\
Angles are those of the driver joint, 0 as drawn or where zero says. Forces act from parent on child (in a loop from link1 on link2), in
world axes, z up. The shaking force acts from the machine on its foundation.
"""
SHORT = """\
e.g. a job, press.yaml, after the table of pins or with file: zxn2_3000b in its place:
  speed: 70 r/min
  loads: {draw: {kind: drawing, force: 1500 kN, start: 40 mm}}
"""


def add_job_options(parser: argparse.ArgumentParser, out: str = "", *, speed: bool = True) -> None:
    """Options of `open_job`.

    Args:
        parser: of the command.
        out: what is written into the folder of --out; empty: the command has no such option.
        speed: whether the command has a use for the speed.
    """
    option = parser.add_argument
    option("file", metavar="FILE", help=FILE)
    option("--variant", metavar="NAME", help="one of the job's variants")
    help = "another value, such as loads.draw.force=1200kN, capacities.speed_drop=20%%, r=150, zero=tdc; may be given several times"
    option("--set", metavar="NAME=VALUE", action="append", default=[], help=help)
    option("--load", metavar="KIND:KEYS", action="append", default=[], help="one more load, such as drawing:force=1500kN,start=40mm")
    if speed:
        option("--speed", metavar="SPEED", help="speed of the driver, such as 70r/min or 80mm/s; negative: backwards")
    if out:
        option("--out", type=Path, metavar="DIR", help=f"folder for {out}; made if there is none")


def source_of(options: argparse.Namespace) -> Source:
    """The entries of the job of `add_job_options`."""
    words = [*options.set, *([f"speed={options.speed}"] if getattr(options, "speed", None) is not None else [])]
    return with_loads(source(options.file, options.variant, words, {}), options.load)


def open_job(options: argparse.Namespace) -> Job:
    """The job of `add_job_options`.

    Raises:
        PinpressError: as `pinpress.job`; of changes with the words of the command line.
    """
    return read_job(source_of(options), raise_first)


def number(unit: str) -> Callable[[str], float]:
    """Make a reader for `argparse` of a number with its unit, as in a job."""
    return _read(Number(unit))


def numbers(unit: str) -> Callable[[str], Sequence[float]]:
    """Make a reader for `argparse` of several numbers that share the last unit, as in a job."""
    return _read(Numbers(unit))


def _read(value: Value) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        try:
            return value.read(entry_of_text(text, "", (), JOB), Around())
        except FileEntryError as error:
            raise argparse.ArgumentTypeError(f"{error.problem}; {error.remedy}") from None

    return read


def print_inputs(job: Job | None, rows: Inputs) -> None:
    """Print the inputs of a result, and what the job is."""
    print("\n".join(["", "Inputs", *tables.fitted_words([*rows, *as_inputs(job)])]))


def write_report(job: Job, folder: Path, **more: Any) -> list[str]:
    """Write report.html if Plotly is installed; return the names of what was written."""
    if importlib.util.find_spec("plotly") is None:
        return []
    write_page(job, folder / "report.html", **more)
    return ["report.html"]


def write_cam_tables(job: Job, folder: Path) -> list[str]:
    """Write the cam tables of the job as cam_height.txt and cam_angle.txt; return the names of what was written."""
    tables = job.cam_tables() if "cam_table" in job.sections else []
    return [path.name for table in tables for path in table.write(folder / f"cam_{table.of}.txt")]


def write_pictures(folder: Path, written: Sequence[str], draw: Callable[[], Mapping[str, Figure]]) -> None:
    """Write pictures if Matplotlib is installed, and print the names of the written files.

    Args:
        folder: folder of the files.
        written: names of the files that were written before.
        draw: returns file name -> figure; it is called only if Matplotlib is installed.
    """
    if importlib.util.find_spec("matplotlib") is None:
        print(f"\nwrote {', '.join(str(folder / name) for name in written)}; for pictures: pip install 'pinpress[plots]'")
        return
    from ..plots import style  # slow to import

    figures = draw()
    for name, figure in figures.items():
        style.save(figure, folder / name)
    say_written(folder, [*written, *figures])


def say_written(folder: Path, names: Sequence[str]) -> None:
    """Print the names of the written files."""
    *first, last = (str(folder / name) for name in names)
    print(f"\nwrote {', '.join(first)} and {last}" if first else f"\nwrote {last}")


def refuse_present(path: Path, mark: bytes, remedy: str) -> None:
    """Refuse to write over a file that pinpress did not write; ``mark`` stands in those that it wrote."""
    if path.is_file() and mark not in path.read_bytes():
        raise PinpressError(f"{path} is there already, and pinpress did not write it: {remedy}")


# ------------------------------------------------------------------------------------------------------------------- progress of long work

LEFT = "{percentage:3.0f} % |{bar}| {remaining} to go"
BRIEF = 1.0  # shorter work gets no bar [s]
MINUTE = 60.0  # between two lines [s]
STEADY = 0.03  # tqdm's weight of the newest speed: what comes in parts, one now and two then, goes at the speed of some thirty of them
WIDTH = 80  # of a line


@contextmanager
def progress(total: float, shape: str = LEFT) -> Iterator[Callable[[float], None]]:
    """Show the progress of long work on standard error: a bar on a terminal, elsewhere (as in a log) a line a minute.

    The first call may report work of an earlier run: the remaining time follows from the later calls.

    Args:
        total: amount of work at the end.
        shape: tqdm's ``bar_format``.

    Yields:
        A function that takes the amount of work done.
    """
    if not sys.stderr.isatty():
        yield _line_a_minute(total, shape)
        return
    from tqdm import tqdm  # seldom needed

    with tqdm(total=total, file=sys.stderr, delay=BRIEF, miniters=0, smoothing=STEADY, leave=False, bar_format=shape) as bar:

        def tell(reached: float) -> None:
            if not bar.n:
                bar.initial = bar.n = bar.last_print_n = reached
            bar.update(reached - bar.n)

        yield tell


def _line_a_minute(total: float, shape: str) -> Callable[[float], None]:
    first, begun, last = 0.0, 0.0, 0.0

    def tell(reached: float) -> None:
        nonlocal first, begun, last
        now = time.monotonic()
        if not first:
            first, begun, last = reached, now, now
        elif now - last >= MINUTE:
            from tqdm import tqdm  # seldom needed

            last = now
            words = tqdm.format_meter(reached, total, now - begun, ncols=WIDTH, initial=first, bar_format=shape, ascii=True)
            print(words, file=sys.stderr, flush=True)

    return tell
