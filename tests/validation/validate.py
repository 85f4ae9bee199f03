"""`python tests/validation/validate.py`: every table and figure of the documents, ours beside theirs."""

import argparse
import sys
import time
from pathlib import Path

from pinpress.common.command_end import ended

sys.path.insert(0, str(Path(__file__).parents[1]))
from validation import DOCUMENTS, reproduced


def main(arguments: list[str] | None = None) -> int:
    """Run the command.

    Args:
        arguments: words behind ``python tests/validation/validate.py``; by default those of this process.

    Returns:
        The exit code: 1 where a number that counts as reproduced is not, 2 with a line on stderr where the input is at fault, others see
        `command_end.ended`.
    """
    return ended("validate", lambda: _run(arguments))


def _run(arguments: list[str] | None) -> int:
    parser = argparse.ArgumentParser(
        prog="python tests/validation/validate.py",
        description="Every table and figure of the documents behind the shipped presses, ours beside theirs.",
    )
    parser.add_argument("documents", nargs="*", metavar="DOCUMENT", help=f"which of {', '.join(DOCUMENTS)}; default: all")
    parser.add_argument("--out", metavar="DIR", help="write a page for each document, with figures, instead of printing")
    options = parser.parse_args(arguments)
    failed = False
    for name in dict.fromkeys(options.documents or DOCUMENTS):
        began = time.perf_counter()
        print(f"{name} ...", end=" ", file=sys.stderr, flush=True)
        page = reproduced(name)
        missed = [row for row in page.rows if row.holds is False]
        text = page.markdown() if options.out is None else "\n".join(map(str, page.write(options.out)))
        print(f"{time.perf_counter() - began:.1f} s", file=sys.stderr)
        print(text)
        for row in missed:
            print(f"{name}: {row.quantity} is {row.ours}, not {row.theirs}", file=sys.stderr)
        failed = failed or bool(missed)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
