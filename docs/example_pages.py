"""The examples of docs/examples and the exercises of docs/exercises: runs them, and writes a page, a picture and a notebook of each, and
the pages that list them.

    python docs/example_pages.py                # all, in two minutes
    python docs/example_pages.py floor four_bar # some, and the lists

An example is a script of at most 60 lines that answers one question. The first line of its docstring is the question, what it prints is the
answer, and ``figure`` is its picture.

An exercise is such a script too, the solution, in steps for a class. A step begins with ``# %% Heading``; the comment below says what to
do, from ``# Hint:`` on how. What students are to write stands between ``# Gap: what it is`` and ``# End of the gap``: their notebook has a
line there that says what is missing, and the page shows it folded.
"""

import ast
import contextlib
import io
import json
import os
import re
import runpy
import sys
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

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
    "For roboticists": ("my_own_robot", "path_of_the_hand", "pinocchio_beside"),
}
NAMES = tuple(name for names in GROUPS.values() for name in names)
EXERCISES = {  # and what is found in each
    "four_bar": "position, velocity, acceleration and pin forces from the closed loop of vectors",
    "half_balance": "the shaking force and its orders, a counterweight, why half, and a proof",
    "stroke_under_load": "work, torque, flywheel, drop of speed, permissible force, motor",
}
GAP = re.compile(r"^# Gap: (.*?)\n(.*?)^# End of the gap\n?", re.MULTILINE | re.DOTALL)
BELOW_THE_GUIDE = ("---", "search:", "  boost: 0.5", "---", "")  # where one searches
TO_TEACHERS = """
These are three classes of about two hours each. Students find results by hand, with hints, and then compare them with pinpress. Each step
of a notebook has a gap to fill. Below the gap stands a check, which compares with a conservation law or with pinpress, to nine digits and
more, and says what is wrong. A gap that is still open says what belongs there.

{list}

Students start from the notebooks; in the folder of the repository, `pip install '.[plots]' notebook` brings all that they need. The
solutions are the scripts in `docs/exercises`; the pages show them folded. `python docs/example_pages.py` runs them and writes pages,
pictures and notebooks.
"""
BESIDE = dict.fromkeys(("my_own_robot", "path_of_the_hand"), "five_bar.urdf")  # a file of the folder that the example reads


class Step(NamedTuple):
    """A step of an exercise.

    Attributes:
        heading: what it is about.
        words: what to do.
        hint: how; empty where there is none.
        code: with the solution.
    """

    heading: str
    words: str
    hint: str
    code: str

    @property
    def gap(self) -> str:
        """What students are to write, as code; empty where nothing is left out."""
        found = GAP.search(self.code)
        return found[2].strip() if found else ""

    @property
    def with_gap(self) -> str:
        """The code that students get: in place of the solution a line that says what to write there."""

        def missing(gap: re.Match[str]) -> str:
            text = json.dumps(f"{self.heading}: write {gap[1]}", ensure_ascii=False)
            blank = 2 if gap.string.startswith("def ", gap.end()) else 1
            return f"raise NotImplementedError({text})\n" + blank * "\n"

        return GAP.sub(missing, self.code)


def folder(name: str) -> Path:
    return DOCS / "exercises" if name in EXERCISES else FOLDER


def script(name: str) -> str:
    return (folder(name) / f"{name}.py").read_text(encoding="utf-8")


def parts(name: str) -> tuple[str, str, str]:
    """The question of an example, the words below it, and its code."""
    text = script(name)
    docstring = ast.parse(text).body[0]
    question, words = (ast.get_docstring(ast.parse(text)) or "").split("\n\n", 1)
    return question, words, "\n".join(text.splitlines()[docstring.end_lineno :]).strip()


def run(name: str) -> tuple[str, Figure]:
    """What an example prints, and its picture; in its own folder, as a notebook there runs."""
    before, printed = Path.cwd(), io.StringIO()
    os.chdir(folder(name))
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
        lines += [f"[`{BESIDE[name]}`]({BESIDE[name]}), which the notebook reads from its own folder:", "", "```xml", read, "```", ""]
    return "\n".join([*lines, f"[Notebook]({name}.ipynb) · `docs/examples/{name}.py` · [all examples](../examples.md)", ""])


def steps(name: str) -> list[Step]:
    """The steps of an exercise."""
    found = []
    for chunk in re.split(r"^# %% ", parts(name)[2], flags=re.MULTILINE)[1:]:
        heading, below = chunk.split("\n", 1)
        comment = re.match(r"(?:#.*\n)*", below)
        assert comment is not None
        words, _, hint = re.sub(r"^# ?", "", comment[0], flags=re.MULTILINE).partition("Hint: ")
        found.append(Step(heading, words.strip(), hint.strip(), below[comment.end() :].strip()))
    return found


def exercise_page(name: str, printed: str) -> str:
    """The page of an exercise whose solution prints this."""
    question, words, _ = parts(name)
    lines = [*BELOW_THE_GUIDE, f"# {question}", "", words, "", f"[Notebook with gaps]({name}.ipynb) · [all exercises](../exercises.md)", ""]
    for step in steps(name):
        lines += [f"## {step.heading}", "", step.words, "", "```python", step.with_gap.strip(), "```", ""]
        if step.hint:
            lines += _folded("Hint", step.hint)
        if step.gap:
            lines += _folded("Solution", f"```python\n{step.gap}\n```")
    lines += ["## What comes out", "", "```text", printed.rstrip(), "```", "", f"![{question}]({name}.svg)", ""]
    return "\n".join([*lines, f"The whole solution: `docs/exercises/{name}.py`.", ""])


def exercise_notebook(name: str) -> str:
    """An exercise as a notebook with gaps."""
    question, words, _ = parts(name)
    cells = [("markdown", f"# {question}\n\n{words}")]
    for step in steps(name):
        cells.append(("markdown", f"## {step.heading}\n\n{step.words}"))
        if step.hint:
            cells.append(("markdown", "\n".join(_folded("Hint", step.hint)).strip()))
        cells.append(("code", step.with_gap.strip()))
    return _notebook_of(cells)


def exercise_index() -> str:
    """The page that lists the exercises."""
    listed = "\n".join(f"- [{parts(name)[0]}](exercises/{name}.md): {found}" for name, found in EXERCISES.items())
    return f"# Exercises\n{TO_TEACHERS.replace('{list}', listed)}"


def notebook(name: str) -> str:
    """An example as a notebook, without what it prints."""
    question, words, code = parts(name)
    pieces = [piece.strip() for piece in code.split("\n\n\n")]
    if "pyplot" not in code:  # whose figures a notebook shows by itself
        pieces.append("figure")
    return _notebook_of([("markdown", f"# {question}\n\n{words}"), *(("code", piece) for piece in pieces)])


def _notebook_of(pieces: list[tuple[str, str]]) -> str:
    """A notebook of cells that are "markdown" or "code"; code has not run."""
    numbers: Counter[str] = Counter()
    cells: list[dict[str, Any]] = []
    for kind, text in pieces:
        run: dict[str, Any] = {"execution_count": None, "outputs": []} if kind == "code" else {}
        name = "question" if kind == "markdown" and not cells else f"{kind}-{numbers[kind]}"
        numbers[kind] += kind == "code" or bool(cells)
        cells.append(dict(sorted({"cell_type": kind, "id": name, "metadata": {}, "source": _lines(text), **run}.items())))
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {"cells": cells, "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def index() -> str:
    """The page that lists the examples."""
    lines = ["# Examples", "", "Each page answers one question in at most 60 lines, and has its notebook.", ""]
    for group, names in GROUPS.items():
        lines += [f"## {group}", "", *(f"- [{parts(name)[0]}](examples/{name}.md)" for name in names), ""]
    return "\n".join([*lines, "`python docs/example_pages.py` runs them and writes their pages, pictures and notebooks.", ""])


def _folded(title: str, text: str) -> list[str]:
    """Markdown that opens by a click, in notebooks, on GitHub and in the site."""
    return ["<details markdown>", f"<summary>{title}</summary>", "", text, "", "</details>", ""]


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def main(names: list[str]) -> None:
    for name in names or (*NAMES, *EXERCISES):
        printed, figure = run(name)
        write_page, write_notebook = (exercise_page, exercise_notebook) if name in EXERCISES else (page, notebook)
        (folder(name) / f"{name}.md").write_text(write_page(name, printed), encoding="utf-8")
        (folder(name) / f"{name}.ipynb").write_text(write_notebook(name), encoding="utf-8")
        pp.plots.save(figure, folder(name) / f"{name}.svg")
        print(name)
    (DOCS / "exercises.md").write_text(exercise_index(), encoding="utf-8")
    (DOCS / "examples.md").write_text(index(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
