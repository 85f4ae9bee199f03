"""The pages of docs/reference: every public name as the stubs list them, a few namespaces a page, functions before classes.

mkdocstrings puts signatures and docstrings in their places when the site is built.
"""

import inspect
from operator import attrgetter

from make import DOCS, OUT, write

import pinpress as pp

# In the order in which a reader meets them; of these classes, which functions make, the arguments of the constructor say nothing.
TOP = (
    "build load from_pinocchio presses check write_urdf write_sdf write_mjcf Linkage cycle servo_cycle read_motion Motion dead_centres"
    " inverse_dynamics Reactions simulate simulate_batch steady_state Run ElasticRun RunBatch record record_modes report Header view"
    " LiveView visual_model RPM"
)
MADE_BY_FUNCTIONS = ("Linkage", "Motion", "Reactions", "Run", "ElasticRun", "RunBatch", "LiveView")
PAGES = {  # by file: title, and the namespaces that share the page
    "motion": ("Pin tables and measures", "pin_table measures"),
    "loads": ("Loads and drives", "loads drives"),
    "ratings": ("Ratings, servo motions, motors", "ratings servo mains"),
    "measured": ("Measured machines and tolerances", "measured tolerances"),
    "elasticity": ("Elasticity and foundation", "elasticity foundation"),
    "design": ("Balancing, synthesis, derivatives, sweeps", "balancing balancing.classical synthesis derivatives sweeps fe export"),
    "pages": ("Plots, films, accuracy", "plots video accuracy"),
}

INDEX = """\
# Reference

You find here every public name of `import pinpress as pp`, from the docstrings in the code. Quantities are in SI units and radians; signs
are in [Units and signs](../units_and_signs.md). The names that everyone uses are in `pp`, the others in one namespace a room.

| page | namespaces |
| --- | --- |
| [A press, its motion, forces and runs](pp.md) | `pp` |
"""
SPACE = """\

## pp.{space}

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
    index = INDEX
    for file, (title, spaces) in PAGES.items():
        written[f"{file}.md"] = f"# {title}\n" + "".join(map(_space, spaces.split()))
        index += f"| [{title}]({file}.md) | {', '.join(f'`pp.{space}`' for space in spaces.split())} |\n"
    return written | {"index.md": index}


def _space(space: str) -> str:
    """The part of a page that has a namespace, functions before classes."""
    inside = attrgetter(space)(pp)
    names = [name for name in dir(inside) if not inspect.ismodule(getattr(inside, name))]
    names.sort(key=lambda name: (inspect.isclass(getattr(inside, name)), name))
    return SPACE.format(space=space) + "".join(f"\n::: pinpress.{space}.{name}\n" for name in names)


def _place(name: str) -> tuple[int, str]:
    """The names that a reader meets first, in their order; then the errors, their common base first."""
    order = TOP.split()
    return (order.index(name) if name in order else len(order), name)


def menu() -> str:
    """The lines of mkdocs.yml that lead to these pages."""
    titles = {"pp": "A press, its motion, forces and runs"} | {file: title for file, (title, _) in PAGES.items()}
    return "".join(f'      - "{title}": reference/{file}.md\n' for file, title in titles.items())


def main(quick: bool = False) -> None:
    """Write them."""
    for old in () if OUT else (DOCS / "reference").glob("*.md"):
        old.unlink()
    for file, text in pages().items():
        write(DOCS / "reference" / file, text)
