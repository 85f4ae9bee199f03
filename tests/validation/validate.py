"""What the three documents print next to what pinpress computes.

python tests/validation/validate.py                   # the tables of all documents, as text
python tests/validation/validate.py kong2025          # of one
python tests/validation/validate.py --write           # all rows next to this file, the main rows and pictures into docs

The exit code is 1 if a number is not within the tolerance next to it.
"""

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from validation import pictures, rows

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs"
DOCUMENTS = ("kong2025", "zhang2007", "chen2002")


def main(words: Sequence[str] | None = None, quick: bool = False) -> int:
    """Print or write the tables; ``quick`` takes the first document alone."""
    parser = argparse.ArgumentParser(prog="validate.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("documents", nargs="*", metavar="DOCUMENT", help=f"of {', '.join(DOCUMENTS)}; default: all")
    parser.add_argument(
        "--write", action="store_true", help="write all rows next to this file, and the main rows and pictures of the pages in docs"
    )
    options = parser.parse_args([DOCUMENTS[0]] if quick else words)
    if unknown := set(options.documents) - set(DOCUMENTS):
        parser.error(f"there is no document {', '.join(sorted(unknown))}: write {', '.join(DOCUMENTS)}")
    failed = False
    for name in options.documents or DOCUMENTS:
        document = import_module(f"validation.{name}")
        if options.write:
            page = DOCS / f"{name}.md"
            page.write_text(rows.fill(page.read_text(encoding="utf-8"), document.PARTS, document.MAIN), encoding="utf-8")
            (HERE / f"{name}.md").write_text(rows.complete(name, document.PARTS, document.NO_RESULTS), encoding="utf-8")
            for picture, draw in document.PICTURES.items():
                pictures.save(draw(), DOCS / "figures" / f"{picture}.png")
        else:
            print("\n\n".join(part.markdown() for part in document.PARTS))
        for row in rows.rows_of(document.PARTS):
            if row.holds is False:
                print(f"{name}: {row.quantity} is {row.value}, not {row.printed}", file=sys.stderr)
                failed = True
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
