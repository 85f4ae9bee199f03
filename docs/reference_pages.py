"""Writes docs/reference: a page a namespace, with every public name as the stubs list them, functions before classes.

    python docs/reference_pages.py

mkdocstrings puts signatures and docstrings in their places when the site is built.
"""

import inspect
from operator import attrgetter
from pathlib import Path

import pinpress as pp

FOLDER = Path(__file__).resolve().parent / "reference"
# In the order in which a reader meets them; of these classes, which functions make, the arguments of the constructor say nothing.
TOP = (
    "build load presses check write_urdf Linkage cycle servo_cycle read_motion Motion dead_centres inverse_dynamics Reactions simulate"
    " simulate_batch steady_state Run ElasticRun RunBatch record record_modes report view LiveView visual_model RPM"
)
MADE_BY_FUNCTIONS = ("Linkage", "Motion", "Reactions", "Run", "ElasticRun", "RunBatch", "LiveView")
SPACES = (
    "pin_table loads drives measures ratings servo measured tolerances elasticity foundation balancing balancing.classical synthesis"
    " derivatives sweeps plots video accuracy"
)

INDEX = """\
# Reference

Every public name of `import pinpress as pp`, from the docstrings in the code. Quantities are in SI units and radians; signs are in
[Units and signs](../units_and_signs.md). The names that everyone uses stand in `pp` itself, the others in one namespace a room.

| namespace | names |
| --- | --- |
"""
SPACE = """\
# pp.{space}

::: pinpress.{space}
    options:
      members: false
      show_root_heading: false
      show_root_toc_entry: false
"""
MADE = """\
    options:
      merge_init_into_class: false
"""


def pages() -> dict[str, str]:
    """Text of every page, by the name of its file."""
    top = sorted((name for name in dir(pp) if not inspect.ismodule(getattr(pp, name))), key=_place)
    written = {"pp.md": "# pp\n\nWhat everyone uses: a press, its motion, the forces, a run, the pages to look at, and the errors.\n"}
    written["pp.md"] += "".join(f"\n::: pinpress.{name}\n{MADE if name in MADE_BY_FUNCTIONS else ''}" for name in top)
    index = INDEX + _row("pp", "pp.md", "", top)
    for space in SPACES.split():
        inside = attrgetter(space)(pp)
        names = [name for name in dir(inside) if not inspect.ismodule(getattr(inside, name))]
        names.sort(key=lambda name: (inspect.isclass(getattr(inside, name)), name))
        file = f"{space.replace('.', '_')}.md"
        written[file] = SPACE.format(space=space) + "".join(f"\n::: pinpress.{space}.{name}\n" for name in names)
        index += _row(f"pp.{space}", file, f"{space}.", names)
    return written | {"index.md": index}


def _place(name: str) -> tuple[int, str]:
    """The names that a reader meets first, in their order; then the errors, their common base first."""
    order = TOP.split()
    return (order.index(name) if name in order else len(order), name)


def _row(title: str, file: str, prefix: str, names: list[str]) -> str:
    return f"| [`{title}`]({file}) | {', '.join(f'[`{name}`]({file}#pinpress.{prefix}{name})' for name in names)} |\n"


def menu() -> str:
    """The lines of mkdocs.yml that lead to these pages."""
    files = {"pp": "pp"} | {f"pp.{space}": space.replace(".", "_") for space in SPACES.split()}
    return "".join(f"      - {title}: reference/{file}.md\n" for title, file in files.items())


if __name__ == "__main__":
    for old in FOLDER.glob("*.md"):
        old.unlink()
    for file, text in pages().items():
        (FOLDER / file).write_text(text, encoding="utf-8")
