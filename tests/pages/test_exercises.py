"""The exercises: their solutions find what their pages say, and their notebooks have gaps that say what is missing and checks that fail."""

import ast
import json
import re
from pathlib import Path
from typing import Any

import example_pages
import pytest
from support.sampling import rest_exhaustive

DOCS = Path(__file__).resolve().parents[2] / "docs"
COMMAND = "python docs/make.py example_pages"
NAMES = tuple(example_pages.EXERCISES)
MISTAKES = [  # what students may write, and what they are told
    ("four_bar", "(np.angle(D - B) + angle)", "(np.angle(D - B) - angle)", "other assembly"),
    ("four_bar", "(2 * b * diagonal)", "(2 * c * diagonal)", "not closed"),
    ("four_bar", "du = -w", "du = w", "different velocities"),
    ("four_bar", "- dv**2 * (C - D))", "+ dv**2 * (C - D))", "different accelerations"),
    ("four_bar", "acceleration[link].imag + g", "acceleration[link].imag - g", "deviates by"),
    ("four_bar", '"mass": 12', '"mass": 12.000001', "deviates by"),
    ("four_bar", "1j * ddu", "ddu", "different accelerations"),
    ("half_balance", "25 * (1 - 80 / 250)", "25 * 80 / 250", "not what pinpress finds"),
    ("half_balance", "reciprocating = 120 + 25 * 80 / 250", "reciprocating = 120", "not what pinpress finds"),
    ("half_balance", "for k in (1, 2)]", "for k in (1, 4)]", "not the harmonics"),
    ("half_balance", "return (turning + k * reciprocating * r) / 0.2", "return k * reciprocating * r / 0.2", "nothing shakes across"),
    ("half_balance", "magnitude = reciprocating * r * w**2 / 2", "magnitude = reciprocating * r * w**2", "not the magnitude"),
    ("half_balance", "k = (-product[0] - turning)", "k = -product[0]", "is not half"),
    ("stroke_under_load", "* 2 / np.pi\n", "/ 2\n", "quarter of a sine"),
    ("stroke_under_load", "(1 - (1 - drop) ** 2)", "drop**2", "not the flywheel"),
    ("stroke_under_load", "force * np.abs(travel(q))", "force * r * np.abs(np.sin(q))", "not the torque"),
    ("stroke_under_load", "(inertia + linkage))", "inertia)", "not the speed"),
    ("stroke_under_load", "limit = nominal_force * abs(travel(angle))", "limit = nominal_force * height(angle)", "not the ratings"),
    ("stroke_under_load", "power = work * w / (2 * np.pi)", "power = work * w", "not the power"),
]


def code_cells(name: str) -> list[str]:
    cells = json.loads((DOCS / "exercises" / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", NAMES)
def test_solution_finds_what_its_page_says(name: str) -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    printed, figure = example_pages.run(name)
    assert example_pages.exercise_section(name, printed) in (DOCS / "exercises.md").read_text(encoding="utf-8"), COMMAND
    assert figure.axes
    plt.close("all")


def test_every_exercise_has_picture_and_notebook() -> None:
    folder = DOCS / "exercises"
    for kind in ("py", "svg", "ipynb"):
        assert {path.stem for path in folder.glob(f"*.{kind}")} == set(NAMES), kind
    for name in NAMES:
        assert example_pages.parts(name)[0].endswith("?")
        assert (folder / f"{name}.ipynb").read_text(encoding="utf-8") == example_pages.exercise_notebook(name), COMMAND


@pytest.mark.parametrize("name", NAMES)
def test_notebook_has_gaps_and_no_solutions(name: str) -> None:
    steps = [step for step in example_pages.steps(name) if step.gap]
    assert len(steps) == example_pages.script(name).count("# End of the gap") >= 5
    text = (DOCS / "exercises" / f"{name}.ipynb").read_text(encoding="utf-8")
    for step in steps:
        assert step.hint, step.heading
        assert step.gap.splitlines()[-1] not in text, step.heading


@pytest.mark.parametrize("name", NAMES)
def test_names_that_other_code_needs_are_asked_for(name: str) -> None:
    """A student may call everything else as he likes, and may take the page's solution of one step alone."""
    steps = example_pages.steps(name)
    for k, step in enumerate(steps):
        if step.gap:
            asked = re.search("# Gap: (.*)", step.code)[1]
            own = {name for name in names_set(step.gap) if not re.search(rf"\b{name}\b", asked)}
            others = [step.with_gap, *(code for later in steps[k + 1 :] for code in (later.with_gap, later.gap))]
            for code in others:
                assert own & names_needed(code) == set(), step.heading


def names_set(code: str) -> set[str]:
    """Names that lines of code leave behind."""
    body = ast.parse(code).body
    targets = [target for node in body if isinstance(node, ast.Assign) for target in node.targets]
    found = {node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    return found | {node.name for node in body if isinstance(node, ast.FunctionDef)}


def names_needed(code: str) -> set[str]:
    """Names that code reads and does not set itself."""
    tree = list(ast.walk(ast.parse(code)))
    names = [node for node in tree if isinstance(node, ast.Name)]
    own = {node.id for node in names if isinstance(node.ctx, ast.Store)} | {node.arg for node in tree if isinstance(node, ast.arg)}
    return {node.id for node in names} - own


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", NAMES)
def test_open_gaps_say_what_is_missing_and_solutions_fill_them(name: str) -> None:
    """A student who runs each step, is told what is missing, and takes the page's solution."""
    plt = pytest.importorskip("matplotlib.pyplot")
    names: dict[str, Any] = {}
    for step, cell in zip(example_pages.steps(name), code_cells(name), strict=True):
        if step.gap:
            with pytest.raises(NotImplementedError, match=f"^{step.heading}: write "):
                exec(cell, names)
            line = next(line for line in cell.splitlines() if line.startswith("raise "))
            cell = cell.replace(line, step.gap)
        exec(cell, names)
    assert names["figure"].axes
    plt.close("all")


@pytest.mark.parametrize("mistake", rest_exhaustive(MISTAKES, MISTAKES[0], MISTAKES[7]), ids=lambda mistake: mistake[3])
def test_wrong_answers_are_told(mistake: tuple[str, str, str, str]) -> None:
    name, right, wrong, told = mistake
    plt = pytest.importorskip("matplotlib.pyplot")
    code = example_pages.script(name)
    assert right in code
    with pytest.raises(AssertionError, match=told):
        exec(code.replace(right, wrong), {})
    plt.close("all")
