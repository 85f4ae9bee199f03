"""The examples of docs/examples: runs them, and writes a page, a picture and a notebook of each, and the page that lists them.

    python docs/example_pages.py                # all, in two minutes
    python docs/example_pages.py floor friction # some, and the list

An example is a script of at most 60 lines that answers one question. The first line of its docstring is the question, what it prints is the
answer, and ``figure`` is its picture.
"""

import ast
import contextlib
import io
import json
import os
import runpy
import sys
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

import pinpress as pp

DOCS = Path(__file__).resolve().parent
FOLDER = DOCS / "examples"
GROUPS = {
    "Motion and forces": ("press_from_a_sketch", "bearing_forces", "friction", "does_it_lock", "ball_ended_rod"),
    "Motor, flywheel, brake": ("flywheel", "emergency_stop", "which_servo_motor", "balance_cylinder"),
    "What the press may do": ("permissible_force", "how_fast", "torque_over_speed_and_force"),
    "A quieter press": ("which_counterweight", "floor", "break_through", "worn_pin"),
    "A more exact press": ("bottom_dead_centre", "even_drawing_speed", "real_slide_mass"),
    "For roboticists": ("my_own_robot", "pinocchio_beside"),
}
NAMES = tuple(name for names in GROUPS.values() for name in names)
BELOW_THE_GUIDE = ("---", "search:", "  boost: 0.5", "---", "")  # where one searches
BESIDE = {"my_own_robot": "five_bar.urdf"}  # a file of the folder that the example reads


def script(name: str) -> str:
    return (FOLDER / f"{name}.py").read_text(encoding="utf-8")


def parts(name: str) -> tuple[str, str, str]:
    """The question of an example, the words below it, and its code."""
    text = script(name)
    docstring = ast.parse(text).body[0]
    question, words = (ast.get_docstring(ast.parse(text)) or "").split("\n\n", 1)
    return question, words, "\n".join(text.splitlines()[docstring.end_lineno :]).strip()


def run(name: str) -> tuple[str, Figure]:
    """What an example prints, and its picture; in its own folder, as a notebook there runs."""
    before, printed = Path.cwd(), io.StringIO()
    os.chdir(FOLDER)
    try:
        with contextlib.redirect_stdout(printed):
            figure = runpy.run_path(f"{name}.py")["figure"]
    finally:
        os.chdir(before)
    return printed.getvalue(), figure


def page(name: str, printed: str) -> str:
    """The page of an example that prints this."""
    question, words, code = parts(name)
    lines = [*BELOW_THE_GUIDE, f"# {question}", "", words, "", "```python", code, "```", "", "```text", printed.rstrip(), "```", ""]
    lines += [f"![{question}]({name}.svg)", ""]
    if name in BESIDE:
        read = (FOLDER / BESIDE[name]).read_text(encoding="utf-8").rstrip()
        lines += [f"`{BESIDE[name]}`:", "", "```xml", read, "```", ""]
    return "\n".join([*lines, f"[Notebook]({name}.ipynb) · `docs/examples/{name}.py` · [all examples](../examples.md)", ""])


def notebook(name: str) -> str:
    """An example as a notebook, without what it prints."""
    question, words, code = parts(name)
    pieces = [piece.strip() for piece in code.split("\n\n\n")]
    if "pyplot" not in code:  # whose figures a notebook shows by itself
        pieces.append("figure")
    cells: list[dict[str, Any]] = [
        {"cell_type": "markdown", "id": "question", "metadata": {}, "source": _lines(f"# {question}\n\n{words}")}
    ]
    for k, piece in enumerate(pieces):
        cells.append(
            {"cell_type": "code", "execution_count": None, "id": f"code-{k}", "metadata": {}, "outputs": [], "source": _lines(piece)}
        )
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {"cells": cells, "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def index() -> str:
    """The page that lists the examples."""
    lines = ["# Examples", "", "One question each, answered in at most 60 lines; every page has its notebook.", ""]
    for group, names in GROUPS.items():
        lines += [f"## {group}", "", *(f"- [{parts(name)[0]}](examples/{name}.md)" for name in names), ""]
    return "\n".join([*lines, "`python docs/example_pages.py` runs them and writes their pages, pictures and notebooks.", ""])


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def main(names: list[str]) -> None:
    for name in names or NAMES:
        printed, figure = run(name)
        (FOLDER / f"{name}.md").write_text(page(name, printed), encoding="utf-8")
        (FOLDER / f"{name}.ipynb").write_text(notebook(name), encoding="utf-8")
        pp.plots.save(figure, FOLDER / f"{name}.svg")
        print(name)
    (DOCS / "examples.md").write_text(index(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
