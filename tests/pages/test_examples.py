"""The examples of the manual answer as their pages say, to the printed digit."""

import json
import runpy
from pathlib import Path

import pytest
from support.sampling import rest_exhaustive

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = runpy.run_path(str(DOCS / "example_pages.py"))
QUICK = ("press_from_a_sketch", "bearing_forces", "permissible_force", "my_own_robot")
LONGEST = 60  # lines


@pytest.mark.parametrize("name", rest_exhaustive(PAGES["NAMES"], *QUICK))
def test_example_answers_as_its_page_says(name: str) -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    printed, figure = PAGES["run"](name)
    assert (DOCS / "examples" / f"{name}.md").read_text(encoding="utf-8") == PAGES["page"](name, printed), "python docs/example_pages.py"
    assert figure.axes
    plt.close("all")


def test_every_example_is_listed_short_and_has_page_picture_and_notebook() -> None:
    folder = DOCS / "examples"
    for kind in ("py", "md", "svg", "ipynb"):
        assert {path.stem for path in folder.glob(f"*.{kind}")} == set(PAGES["NAMES"]), kind
    for name in PAGES["NAMES"]:
        assert len(PAGES["script"](name).splitlines()) <= LONGEST
        assert PAGES["parts"](name)[0].endswith("?")
    assert (DOCS / "examples.md").read_text(encoding="utf-8") == PAGES["index"](), "python docs/example_pages.py"


@pytest.mark.parametrize("name", PAGES["NAMES"])
def test_notebook_has_the_code_of_its_script(name: str) -> None:
    notebook = (DOCS / "examples" / f"{name}.ipynb").read_text(encoding="utf-8")
    assert notebook == PAGES["notebook"](name), "python docs/example_pages.py"
    cells = json.loads(notebook)["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    shown = code[-1] == "figure"
    assert "\n".join(code[:-1] if shown else code).split() == PAGES["parts"](name)[2].split()
    assert shown != ("pyplot" in code[0])  # a notebook shows figures of pyplot by itself
