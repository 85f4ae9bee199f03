"""All benchmarks by their names, and pictures of pages: `python tests/benchmarks/run.py` lists them, a name runs one.

python tests/benchmarks/run.py                      # lists the scripts
python tests/benchmarks/run.py servo tolerances     # runs them; --quick: in a few seconds each, without a meaning of the times

A script is a module in accuracy or speed with a docstring, whose first line is listed, and a function `main(quick)`.
"""

import argparse
import ast
import runpy
import sys
from pathlib import Path

HERE = Path(__file__).parent
FOLDERS = ("accuracy", "speed")


def scripts() -> dict[str, Path]:
    """Names of the scripts and their files: modules with a docstring and a function `main`."""
    files = {path.stem: path for folder in FOLDERS for path in sorted((HERE / folder).glob("*.py"))}
    return {name: path for name, path in files.items() if _has_main(path)}


def _has_main(path: Path) -> bool:
    return any(isinstance(node, ast.FunctionDef) and node.name == "main" for node in ast.parse(path.read_text(encoding="utf-8")).body)


def first_line(path: Path) -> str:
    """The first sentence of a script's docstring."""
    return (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").split("\n\n")[0].replace("\n", " ")


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="run.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    known = scripts()
    if unknown := set(options.names) - set(known):
        parser.error(f"there is no benchmark {', '.join(sorted(unknown))}: the names are {', '.join(known)}")
    for name in options.names:
        sys.argv = [str(known[name])]
        runpy.run_path(str(known[name]))["main"](options.quick)
    if not options.names:
        print("\n".join(f"{name:22}{first_line(path)}" for name, path in known.items()))


if __name__ == "__main__":
    main()
