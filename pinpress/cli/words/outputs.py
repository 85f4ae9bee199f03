"""Output of a command: pages, pictures, paths of points, and inputs of a result."""

from __future__ import annotations

import argparse
import importlib.util
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...common import tables
from ...common.errors import PinpressError
from ...common.results import Tabular
from ...drives.transmission import Flywheel
from ...dynamics.inputs import Inputs
from ...dynamics.reactions import Reactions
from ...linkage.linkage import Linkage

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIGNS = """\
Angles are in degrees of the driver joint, 0 in the pose of the file, or with --zero at a dead centre. Forces act from parent on child
(in a loop from link1 on link2), in world axes, z up. The shaking force acts from the machine on its foundation.
"""


def add_out_option(parser: argparse.ArgumentParser, files: str) -> None:
    """Option --out; ``files``: the written files, for the help."""
    parser.add_argument("--out", type=Path, metavar="DIR", help=f"folder for {files}; created if it does not exist")


def add_page_options(parser: argparse.ArgumentParser, files: str) -> None:
    """Options of `write_pages`; ``files``: the written files, for the help."""
    add_out_option(parser, files)
    add_trace_option(parser)
    parser.add_argument("--report", action="store_true", help="also write report.html: the recording and charts that follow it")


def add_trace_option(parser: argparse.ArgumentParser) -> None:
    """Option --trace, points whose paths are drawn."""
    help = "draw the path of a point, in m in the link's frame; may be given several times"
    parser.add_argument("--trace", type=named_point("a link", "rod:0,0,0.4"), action="append", default=[], metavar="LINK:X,Y,Z", help=help)


def named_point(of: str, example: str) -> Callable[[str], tuple[str, tuple[float, float, float]]]:
    """Make a reader for `argparse` of a name and x, y, z [m], ``coupler:0.6,0,0.1``.

    Args:
        of: Kind of the named object, for messages.
        example: A point, for messages.
    """

    def read(words: str) -> tuple[str, tuple[float, float, float]]:
        name, _, point = words.rpartition(":")  # a name may have a colon in it
        try:
            x, y, z = map(float, point.split(","))
        except ValueError:
            x = y = z = math.nan
        if not name or not math.isfinite(x + y + z):
            raise argparse.ArgumentTypeError(f"{words!r} is not a point of {of}: give its name and x, y, z in m, e.g. {example}")
        return name, (x, y, z)

    return read


def refuse_pages_without_folder(options: argparse.Namespace) -> None:
    """Refuse --report or --trace without a folder to write into."""
    if options.out is None and (options.report or options.trace):
        raise PinpressError(f"--{'report' if options.report else 'trace'} needs a folder to write into: also give --out DIR")


def write_pages(
    press: Linkage,
    reactions: Reactions,
    options: argparse.Namespace,
    names: Sequence[str],
    before: Reactions | None = None,
    results: Sequence[Tabular] = (),
    flywheel: Flywheel | None = None,
) -> None:
    """Write recording.html, and report.html on request, and print their names.

    Args:
        press: the linkage of the pages.
        reactions: reactions to the motion of the pages.
        options: options of `add_page_options`.
        names: names of the files that were written before, in the same folder.
        before: reactions of another press, for the report.
        results: other results of the press, for the report.
        flywheel: flywheel on the driver's shaft; None: the flywheel of a run.
    """
    from ...visual.recording import record  # the pages are slow to import

    pages = ["recording.html"]
    record(press, reactions.motion, options.out / "recording.html", reactions=reactions, traces=options.trace, flywheel=flywheel)
    if options.report:
        from ...visual.reports.report import report  # slow to import

        page = options.out / "report.html"
        report(
            press,
            reactions.motion,
            page,
            reactions=reactions,
            traces=options.trace,
            before=before,
            results=results,
            flywheel=flywheel,
        )
        pages.append("report.html")
    say_written(options.out, [*names, *pages])


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
    from ...plots import style  # slow to import

    figures = draw()
    for name, figure in figures.items():
        style.save(figure, folder / name)
    say_written(folder, [*written, *figures])


def print_inputs(rows: Inputs) -> None:
    """Print the inputs of a result."""
    print("\n".join(["", "Inputs", *tables.fitted_words(rows)]))


def say_written(folder: Path, names: Sequence[str]) -> None:
    """Print the names of the written files."""
    *first, last = (str(folder / name) for name in names)
    print(f"\nwrote {', '.join(first)} and {last}")
