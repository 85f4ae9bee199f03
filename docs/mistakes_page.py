"""Writes docs/mistakes.md: everyday mistakes in pin tables and URDFs, and what is said to each.

    python docs/mistakes_page.py

The mistakes stand in tests/support/mistakes.py. What is said is what `build` and `load` say today; a test holds the page to it.
"""

import difflib
import re
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent))
sys.path.insert(0, str(DOCS.parent / "tests"))
from support import mistakes  # noqa: E402

PAGE = """\
# Everyday mistakes

What `pp.build` and `pp.load`, and so every command, say to {count} mistakes that people make when they describe a press. An error ends the
call. A warning is a line on stderr in a command and a `PinpressWarning` in Python; a note is what `pinpress check` adds. `python
docs/mistakes_page.py` writes this page: each mistake is put, alone, into the description above its table, and what is said is copied here.

## In pin tables

```yaml
{table}```

{in_tables}
## In URDFs

```xml
{urdf}```

{in_urdfs}"""


def page() -> str:
    """The text of docs/mistakes.md."""
    with tempfile.TemporaryDirectory() as folder:
        table, urdf = Path(folder) / "press.yaml", Path(folder) / "press.urdf"
        in_tables = [
            (name, mistakes.TABLE, made, mistakes.said_to_table(table, made))
            for name, mistake in mistakes.IN_TABLES.items()
            for made in [mistakes.table_with(mistake)]
        ]
        in_urdfs = [
            (name, mistakes.URDF, made, mistakes.said_to_urdf(urdf, made))
            for name, mistake in mistakes.IN_URDFS.items()
            for made in [mistakes.with_mistake(mistakes.URDF, mistake.edits)]
        ]
        rows = [
            "\n".join(
                [HEAD, *(_row(name, right, wrong, [line.replace(f"{folder}/", "") for line in said]) for name, right, wrong, said in part)]
            )
            for part in (in_tables, in_urdfs)
        ]
    return PAGE.format(
        count=len(in_tables) + len(in_urdfs), table=mistakes.TABLE, urdf=mistakes.URDF, in_tables=rows[0] + "\n", in_urdfs=rows[1] + "\n"
    )


HEAD = "| mistake | written | what is said |\n| --- | --- | --- |"


def _row(name: str, right: str, wrong: str, said: list[str]) -> str:
    """A row of the table: the first line that the mistake changes, as it is written there."""
    changes = [line for line in difflib.ndiff(right.splitlines(), wrong.splitlines()) if line[:2] in ("+ ", "- ")]
    changed = [line[2:].strip() for line in changes if line.startswith("+")]
    removed = [line[2:].strip() for line in changes if line.startswith("-")]
    written = _code(changed[0]) + (" ..." if len(changed) > 1 else "") if changed else f"without {_code(removed[0])}"
    written = written if wrong else "nothing"
    return f"| {name} | {written} | {'<br>'.join(_plain(line) for line in said)} |"


def _code(text: str) -> str:
    return f"`{text[:90].replace('|', '/')}`"


def _plain(text: str) -> str:
    """A message in a cell of a Markdown table."""
    return re.sub(r"([<>*_|\[\]])", r"\\\1", " ".join(text.split()))


if __name__ == "__main__":
    (DOCS / "mistakes.md").write_text(page(), encoding="utf-8")
