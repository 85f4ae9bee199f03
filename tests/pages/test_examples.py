"""The examples of the manual answer as their pages say, to the printed digit."""

import json
from pathlib import Path

import example_pages
import pytest
from support.sampling import rest_exhaustive

DOCS = Path(__file__).resolve().parents[2] / "docs"
QUICK = ("press_from_a_sketch", "bearing_forces", "permissible_force", "my_own_robot")
LONGEST = 60  # lines


@pytest.mark.parametrize("name", rest_exhaustive(example_pages.NAMES, *QUICK))
def test_example_answers_as_its_page_says(name: str) -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    printed, figure = example_pages.run(name)
    assert example_pages.section(name, printed) in page_of(name), "python docs/make.py example_pages"
    assert figure.axes
    plt.close("all")


def page_of(name: str) -> str:
    (group,) = (group for group, (_, names) in example_pages.GROUPS.items() if name in names)
    return (DOCS / "examples" / f"{group}.md").read_text(encoding="utf-8")


def test_every_example_is_listed_short_and_has_section_picture_and_notebook() -> None:
    folder = DOCS / "examples"
    for kind in ("py", "svg", "ipynb"):
        assert {path.stem for path in folder.glob(f"*.{kind}")} == set(example_pages.NAMES), kind
    assert {path.stem for path in folder.glob("*.md")} == set(example_pages.GROUPS)
    for name in example_pages.NAMES:
        assert len(example_pages.script(name).splitlines()) <= LONGEST
        assert example_pages.parts(name)[0].endswith("?")
        assert f"\n## {example_pages.parts(name)[0]}\n" in page_of(name)
    assert (DOCS / "examples.md").read_text(encoding="utf-8") == example_pages.index(), "python docs/make.py example_pages"


@pytest.mark.parametrize("name", example_pages.NAMES)
def test_notebook_has_the_code_of_its_script(name: str) -> None:
    notebook = (DOCS / "examples" / f"{name}.ipynb").read_text(encoding="utf-8")
    assert notebook == example_pages.notebook(name), "python docs/make.py example_pages"
    cells = json.loads(notebook)["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    shown = code[-1] == "figure"
    assert "\n".join(code[:-1] if shown else code).split() == example_pages.parts(name)[2].split()
    assert shown != ("pyplot" in code[0])  # a notebook shows figures of pyplot by itself
