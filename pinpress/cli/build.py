"""`pinpress new` and `pinpress build`: write a job to start from; build the press of a table of pins, as URDF and as a sketch."""

from __future__ import annotations

import argparse
import os
import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..common import files, tables
from ..common.errors import PinpressError, PinpressWarning, PinTableError
from ..kinematics.check import check_document, summarise_facts
from ..linkage.element import MOST_BYTES
from ..pin_table.templates import TEMPLATES, template
from .options import add_job_options, source_of

if TYPE_CHECKING:
    from ..pin_table.building import DrawnPress


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `new` and `build` among the subcommands; parsed options have ``run``, see `run_new` and `run`."""
    _add_new(commands)
    parser = commands.add_parser(
        "build",
        help="build the press of a table of pins: a URDF and a sketch",
        description="Build the press of a table of pins, and write its URDF and a sketch of the drawn pose next to the table. Prints what\n"
        "is estimated because the table does not give it, and other places that the lengths of pins allow.",
        epilog="pinpress build press.yaml --set r=150 --out press_150.urdf",
    )
    add_job_options(parser, speed=False)
    parser.add_argument("--out", type=Path, metavar="FILE", help="the URDF; default: the table's name with .urdf. The sketch is beside it")
    parser.set_defaults(run=run)


def _add_new(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    parser = commands.add_parser(
        "new",
        help="write a job to start from, and the schema with which editors complete and check it",
        description="Write a job with comments: a table of pins, whose lengths are parameters, and what acts on the press. Change it to\n"
        "describe yours. Beside it stands pinpress.schema.json, by which editors complete keys, show their units and mark mistakes.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("file", metavar="FILE", type=Path, help="new file, such as press.yaml; it must not exist")
    option("--template", choices=TEMPLATES, default=TEMPLATES[0], help=f"kind of press (default: {TEMPLATES[0]})")
    parser.set_defaults(run=run_new)


def run_new(options: argparse.Namespace) -> int:
    """Write a template, and the schema beside it.

    Returns:
        The exit code, 0.

    Raises:
        PinpressError: the file exists already, or cannot be written.
    """
    if options.file.suffix not in (".yaml", ".yml"):
        raise PinpressError(f"{options.file} does not end in .yaml: jobs are YAML files, so give a name with .yaml")
    if os.path.exists(options.file):
        raise PinpressError(f"{options.file} is there already: give another name")
    from ..jobs.schema import FILE, LINE, schema_text  # seldom needed

    schema = options.file.parent / FILE
    files.write(options.file, LINE.encode() + template(options.template))
    files.write(schema, schema_text())
    print(f"wrote {options.file} and {schema}; change it, then: pinpress {options.file}")
    return 0


def run(options: argparse.Namespace) -> int:
    """Write URDF and sketch, and print the press of the table.

    Returns:
        The exit code, 0.

    Raises:
        PinTableError: the table makes no press; if lengths do not meet, the written sketch shows why.
        PinpressError: the press cannot move, or a file cannot be written.
    """
    from ..pin_table import building  # with a parser and shapes that other commands do without

    out = options.out or Path(options.file).with_suffix(".urdf")
    if out.suffix == ".svg":
        raise PinpressError(f"--out is {out}: give the URDF's name, press.urdf; the sketch is written next to it")
    sketch = out.with_suffix(".svg")
    found = source_of(options)
    if found.table is None:
        raise PinpressError(f"{options.file} is no table of pins: build makes a URDF of one; pinpress new press.yaml writes one")
    slide = found.press_sections().get("slide")
    try:
        draft = found.drawn()
        assert draft is not None
    except PinTableError as error:
        if error.sketch is not None:
            files.write(sketch, error.sketch.encode())
            raise PinpressError(f"{error} (drawn in {sketch})") from error
        raise
    if os.path.isfile(out) and building.MARK not in files.read(out, MOST_BYTES):
        raise PinpressError(f"{out} is there already, and was not written from a pin table: give another name by --out")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PinpressWarning)  # `check` says them, with lines of the URDF that is written
        press = draft.press(slide=slide)
        files.write(out, draft.urdf)
    files.write(sketch, draft.sketch.encode())
    print(check_document(str(out), replace(draft._document(), file=str(out), text=draft.urdf), slide=slide, in_file=False))
    print("\n".join([*_other_places(draft, slide), *_estimates(draft)]))
    print(f"wrote {out} and {sketch} of {press.name}")
    return 0


def _other_places(draft: DrawnPress, slide: str | None) -> list[str]:
    """Results of the other side, for each pin whose lengths allow another place."""
    if not (others := list(draft.other_places())):
        return []
    rows = [["", f"is at [{draft.unit}]", "might be at", "with that"]]
    for name, here, there in others:
        places = [f"({x:.6g}, {z:.6g})" for x, z in np.round((here, there), 9) + 0.0]
        rows.append([name, *places, _with_other_place(draft, name, slide)])
    return ["", "Other places that the lengths of pins allow, and the press that another side would make", *tables.fitted_words(rows)]


def _with_other_place(draft: DrawnPress, pin: str, slide: str | None) -> str:
    """Stroke and least transmission angle with a pin in its other place, or the reason why the press does not work."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PinpressWarning)
        try:
            facts = draft.with_other_place(pin).check(slide).facts
        except PinTableError as error:
            return error.problem
    return "no press" if facts is None else summarise_facts(facts)


def _estimates(draft: DrawnPress) -> list[str]:
    rows = [[link, words] for link, words in draft.estimates()]
    return ["", "Estimated, as the table does not give it", *tables.fitted_words(rows), ""] if rows else [""]
