"""`pinpress build`: a press from a pin table, as URDF and as a sketch."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from ..common import files
from ..common.errors import PinpressError, PinTableError
from ..kinematics.check import check
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage
from ..linkage.urdf.document import MOST_BYTES

if TYPE_CHECKING:
    from ..pin_table.building import DrawnPress


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `build` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "build",
        help="a press from a table of pins: a URDF and a sketch",
        description="Make a press from a pin table and write its URDF and a sketch of the drawn pose beside the table.",
        epilog="other commands take the table itself too: pinpress analyse press.yaml --speed 60",
    )
    option = parser.add_argument
    option("file", metavar="TABLE", help="pin table (.yaml); `pinpress new` writes one to start from")
    option("parameters", metavar="NAME=VALUE", nargs="*", help="another value of a parameter of the table, such as r=150")
    option("--out", type=Path, metavar="FILE", help="the URDF; default: the table's name with .urdf. The sketch has its name with .svg")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write URDF and sketch, and print what was made of the table.

    Returns:
        The exit code, 0.

    Raises:
        PinTableError: the table makes no press; where lengths do not meet, the sketch that is written shows why.
        PinpressError: the press cannot move as it should, or a file cannot be written.
    """
    from ..pin_table import building  # with a parser and shapes that other commands do without

    out = options.out or Path(options.file).with_suffix(".urdf")
    if out.suffix == ".svg":
        raise PinpressError(f"--out is {out}: give the URDF's name, press.urdf; the sketch stands beside it")
    if out.is_file() and building.MARK not in files.read(out, MOST_BYTES):
        raise PinpressError(f"{out} is there already, and no pin table made it: give another name by --out")
    sketch = out.with_suffix(".svg")
    try:
        draft = building.draft(options.file, **dict(_parameter(words) for words in options.parameters))
    except PinTableError as error:
        if error.sketch is not None:
            files.write(sketch, error.sketch.encode())
            raise PinpressError(f"{error} (drawn in {sketch})") from error
        raise
    press = draft.press()
    files.write(out, draft.urdf)
    files.write(sketch, draft.sketch.encode())
    print("\n".join([*_described(draft), *_moved(press), ""]))
    print(check(out))
    print(f"\nwrote {out} and {sketch} of {press.name}")
    return 0


def _parameter(words: str) -> tuple[str, str]:
    name, equals, value = words.partition("=")
    if not (name and equals and value):
        raise PinpressError(f"{words!r} is no value of a parameter: write NAME=VALUE, such as r=150")
    return name, value


def _described(draft: DrawnPress) -> list[str]:
    lines = [
        f"{draft.name}: {len(draft.parts.links)} links and the frame",
        "",
        "bearings, and on which link the force of which one is given",
    ]
    lines += [f"  {name:<24}{link1} > {link2}" for name, link1, link2 in draft.bearings()]
    if others := list(draft.other_places()):
        lines += ["", f"other places that the lengths of pins allow [{draft.unit}]"]
        lines += [f"  {name:<24}({x:.6g}, {z:.6g}) in place of ({x0:.6g}, {z0:.6g})" for name, (x0, z0), (x, z) in others]
    if estimates := list(draft.estimates()):
        lines += ["", "estimated, as the table does not give it"]
        lines += [f"  {link:<24}{words}" for link, words in estimates]
    return lines


def _moved(press: Linkage) -> list[str]:
    """Stroke and dead centres, or why there are none."""
    if press.slide is None:
        return []
    try:
        ends = dead_centres(press)
    except PinpressError as error:
        return ["", f"the slide has no stroke: {error}"]
    angles = ", ".join(
        f"{name} at {math.degrees(angle):.2f} deg" for name, angle in (("top", ends.top_angle), ("bottom", ends.bottom_angle))
    )
    return ["", f"stroke {1e3 * ends.stroke:.3f} mm, {angles} of {press.driver}"]
