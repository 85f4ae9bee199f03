"""The pages, pictures and notebooks of the examples in docs/examples and of the exercises in docs/exercises, which it runs in two minutes,
and the page that lists them.

An example is a script of at most 60 lines that answers one question. The first line of its docstring is the question, what it prints is the
answer, and ``figure`` is its picture. The examples of a group share a page.

An exercise is such a script too, the solution, in steps for a class. A step begins with ``# %% Heading``; the comment below says what to
do, from ``# Hint:`` on how. What students are to write is between ``# Gap: what it is`` and ``# End of the gap``: their notebook has a line
there that says what is missing. The page has what comes out.
"""

import ast
import contextlib
import io
import json
import os
import re
import runpy
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from make import DOCS, write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOLDER = DOCS / "examples"
GROUPS = {  # by the page's file
    "forces": ("Examples: motion and forces", ("press_from_a_sketch", "bearing_forces", "friction", "does_it_lock", "ball_ended_rod")),
    "motor": ("Examples: motor, flywheel, brake", ("flywheel", "emergency_stop", "which_servo_motor", "balance_cylinder")),
    "permissible": ("Examples: what the press may do", ("permissible_force", "how_fast", "torque_over_speed_and_force")),
    "quiet": ("Examples: a quieter press", ("which_counterweight", "floor", "break_through", "worn_pin")),
    "exact": ("Examples: a more exact press", ("bottom_dead_centre", "even_drawing_speed", "real_slide_mass")),
    "robots": ("Examples: for roboticists", ("my_own_robot", "path_of_the_hand", "pinocchio_beside")),
}
NAMES = tuple(name for _, names in GROUPS.values() for name in names)
EXERCISES = ("four_bar", "half_balance", "stroke_under_load")
GAP = re.compile(r"^# Gap: (.*?)\n(.*?)^# End of the gap\n?", re.MULTILINE | re.DOTALL)
BELOW_THE_GUIDE = ("---", "search:", "  boost: 0.5", "---", "")  # where one searches
INDEX = """\
# Examples

Each example answers one question in at most 60 lines, and has its notebook.

{examples}

`python docs/make.py example_pages` runs them and writes their pages, pictures and notebooks.
"""
EXERCISES_HEAD = """\
# Exercises for classes

You find here three classes of about two hours each. Students find results by hand, with hints, and then compare them with pinpress. Each
step of a notebook has a gap to fill. Below the gap is a check, which compares with a conservation law or with pinpress, to nine digits and
more, and says what is wrong.

Students start from the notebooks; in the folder of the repository, `pip install '.[plots]' notebook` brings all that they need. The
solutions are the scripts in `docs/exercises`. `python docs/make.py example_pages` runs them and writes this page, pictures and notebooks.

"""
BESIDE = {"my_own_robot": "five_bar.urdf"}  # a file of the folder that this example and those below it read


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


def run(name: str) -> "tuple[str, Figure]":
    """What an example prints, and its picture; in its own folder, as a notebook there runs."""
    before, printed = Path.cwd(), io.StringIO()
    os.chdir(folder(name))
    try:
        with contextlib.redirect_stdout(printed):
            figure = runpy.run_path(f"{name}.py")["figure"]
    finally:
        os.chdir(before)
    return printed.getvalue(), figure


def page(group: str, printed: dict[str, str]) -> str:
    """The page of a group whose examples print this."""
    title, names = GROUPS[group]
    return "\n".join([*BELOW_THE_GUIDE, f"# {title}", "", *(section(name, printed[name]) for name in names)])


def section(name: str, printed: str) -> str:
    """The section of an example that prints this."""
    question, words, code = parts(name)
    lines = [f"## {question}", "", words, "", "```python", code, "```", "", "```text", printed.rstrip(), "```", ""]
    lines += [f"![{question}]({name}.svg)", ""]
    if name in BESIDE:
        read = (FOLDER / BESIDE[name]).read_text(encoding="utf-8").rstrip()
        lines += [f"[`{BESIDE[name]}`]({BESIDE[name]}), which the notebook reads from its folder:", "", "```xml", read, "```", ""]
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


def exercises_page(printed: dict[str, str]) -> str:
    """The page of the exercises whose solutions print this."""
    return EXERCISES_HEAD + "\n".join(exercise_section(name, printed[name]) for name in EXERCISES)


def exercise_section(name: str, printed: str) -> str:
    """The section of an exercise whose solution prints this."""
    question, words, _ = parts(name)
    headings = ", ".join(step.heading.lower() for step in steps(name))
    lines = [f"## {question}", "", words, "", f"Steps: {headings}. What comes out:", "", "```text", printed.rstrip(), "```", ""]
    lines += [f"![{question}](exercises/{name}.svg)", ""]
    return "\n".join([*lines, f"[Notebook with gaps](exercises/{name}.ipynb) · solution: `docs/exercises/{name}.py`", ""])


def exercise_notebook(name: str) -> str:
    """An exercise as a notebook with gaps."""
    question, words, _ = parts(name)
    cells = [("markdown", f"# {question}\n\n{words}")]
    for step in steps(name):
        cells.append(("markdown", f"## {step.heading}\n\n{step.words}"))
        if step.hint:
            cells.append(("markdown", f"<details markdown>\n<summary>Hint</summary>\n\n{step.hint}\n\n</details>"))
        cells.append(("code", step.with_gap.strip()))
    return _notebook_of(cells)


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
        cells.append(dict(sorted({"cell_type": kind, "id": name, "metadata": {}, "source": text.splitlines(keepends=True), **run}.items())))
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {"cells": cells, "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def index() -> str:
    """The page that lists the examples."""
    groups = []
    for group, (title, names) in GROUPS.items():
        heading = title.partition(": ")[2]
        linked = [f"- [{parts(name)[0]}](examples/{group}.md#{_place(parts(name)[0])})" for name in names]
        groups += [f"## {heading[0].upper()}{heading[1:]}", "", *linked, ""]
    return INDEX.replace("{examples}", "\n".join(groups).strip())


def _place(heading: str) -> str:
    """The name of a heading's place in its page."""
    return re.sub(r"[^\w\s-]", "", heading).strip().lower().replace(" ", "-")


def main(quick: bool = False, parts: Sequence[str] = ()) -> None:
    """Run and write all, or some by their names, with the list; ``quick``: one group of examples."""
    chosen = set(parts or (GROUPS["forces"][1] if quick else (*NAMES, *EXERCISES)))
    groups = [group for group, (_, members) in GROUPS.items() if chosen.intersection(members)]  # a page has all examples of its group
    exercises = EXERCISES if chosen.intersection(EXERCISES) else ()
    printed = {}
    for name in (*(name for group in groups for name in GROUPS[group][1]), *exercises):
        printed[name], figure = run(name)
        write(folder(name) / f"{name}.ipynb", exercise_notebook(name) if name in EXERCISES else notebook(name))
        write(folder(name) / f"{name}.svg", figure)
    if exercises:
        write(DOCS / "exercises.md", exercises_page(printed))
    for group in groups:
        write(FOLDER / f"{group}.md", page(group, printed))
    write(DOCS / "examples.md", index())
