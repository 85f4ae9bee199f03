"""All benchmarks by their names: `python tests/benchmarks/run.py` lists them, a name runs one.

python tests/benchmarks/run.py                      # lists the scripts
python tests/benchmarks/run.py servo savings        # runs them; --quick: in a few seconds each, without a meaning of the times

A script is a module in accuracy or speed with a docstring, whose first line is listed, and a function `main(quick)`.
"""

import argparse
import ast
import os
import sys
from importlib import import_module
from pathlib import Path

HERE = Path(__file__).resolve().parent


def scripts() -> dict[str, str]:
    """Names of the scripts and the first sentences of their docstrings: modules with a function `main`."""
    listed = {}
    for path in sorted([*HERE.glob("accuracy/*.py"), *HERE.glob("speed/*.py")]):
        code = ast.parse(path.read_text(encoding="utf-8"))
        if any(isinstance(node, ast.FunctionDef) and node.name == "main" for node in code.body):
            listed[f"{path.parent.name}.{path.stem}"] = (ast.get_docstring(code) or "").split("\n\n")[0].replace("\n", " ")
    return {name.partition(".")[2]: words for name, words in listed.items()}


def run(name: str, quick: bool) -> None:
    """Run a script; with `quick` in a few seconds, without a meaning of the times."""
    folder = next(path.parent.name for path in HERE.glob(f"*/{name}.py"))
    import_module(f"benchmarks.{folder}.{name}").main(quick)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="run.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    known = scripts()
    if unknown := set(options.names) - set(known):
        parser.error(f"there is no benchmark {', '.join(sorted(unknown))}: the names are {', '.join(known)}")
    os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"  # before NumPy is imported
    sys.path[:0] = [str(HERE.parents[1]), str(HERE.parent), str(HERE.parents[1] / "docs")]
    for name in options.names:
        run(name, options.quick)
    if not options.names:
        print("\n".join(f"{name:22}{words}" for name, words in known.items()))


if __name__ == "__main__":
    main()
