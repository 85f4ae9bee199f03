"""What the commands share: how they explain themselves, show progress, and write their pages."""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ..dynamics.inverse_dynamics import Reactions
from ..linkage.linkage import Linkage
from ..linkage.loading import presses

SIGNS = """\
angles are in degrees of the driver joint, 0 as the URDF draws it; forces are the action of parent on child (of a loop, of link1 on link2)
in world axes, z up; the shaking force is the action of the machine on its foundation.
"""
FILE = f"URDF file, or the name of a shipped press: {', '.join(presses())}"
DRIVER = "driven joint, where the URDF has no <transmission> or another is meant"
SLIDE = "slide, where it is not the link called slide"
TRACE = "draw the path of a point, in m in the link's frame; may be given several times"


def trace(words: str) -> tuple[str, tuple[float, float, float]]:
    """A point whose path is drawn, ``coupler:0.6,0,0.1``: the link and x, y, z."""
    link, _, point = words.rpartition(":")  # a link's name may have a colon in it
    try:
        x, y, z = map(float, point.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{words!r} is no point of a link; give the link and x, y, z in m, e.g. rod:0,0,0.4") from None
    return link, (x, y, z)


def write_pages(
    press: Linkage,
    result: Reactions,
    folder: Path,
    written: list[str],
    with_report: bool,
    traces: list[tuple[str, tuple[float, float, float]]],
    before: Reactions | None = None,
) -> None:
    """Write recording.html, and report.html where it is wanted, and say what has been written."""
    from ..visual.recording import record

    record(press, result.motion, folder / "recording.html", result, traces)
    if with_report:
        from ..visual.report import report

        report(press, result.motion, folder / "report.html", result, traces, before)
    *first, last = (str(folder / name) for name in (*written, "recording.html", *(["report.html"] if with_report else [])))
    print(f"\nwrote {', '.join(first)} and {last}")


@contextmanager
def progress(total: float, shape: str) -> Iterator[Callable[[float], None] | None]:
    """A bar on a terminal, once the work takes longer than a second; elsewhere nothing. ``shape``: tqdm's ``bar_format``."""
    if not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=total, file=sys.stderr, delay=1.0, miniters=0, leave=False, bar_format=shape) as bar:
        yield lambda reached: bar.update(reached - bar.n)
