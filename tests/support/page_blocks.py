"""The fenced blocks of a documentation page, run as a reader would: one Python session, one terminal, one folder.

```python   runs; a ```text block right below it is what it prints
```console  lines that begin with "$ " are commands of pinpress, what follows them is what they print
```xml title="name"  is appended to the file of that name; python too, as a module that other blocks import
```

Where a page shows ``...`` anything may stand (times, rounding); all else is compared as printed.
"""

import contextlib
import doctest
import io
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pinpress.cli.main import main

FENCE = re.compile(r"^```(?P<words>[^\n`]*)\n(?P<body>.*?)^```$", flags=re.DOTALL | re.MULTILINE)
CHECKER = doctest.OutputChecker()


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, the file that it is part of, its text, the line of the page where it begins."""

    language: str
    title: str
    body: str
    line: int


@dataclass(frozen=True)
class Shown:
    """What a page says a block prints, and what it does print."""

    block: Block
    wanted: str
    printed: str

    @property
    def same(self) -> bool:
        return CHECKER.check_output(self.wanted, self.printed, doctest.ELLIPSIS)


def blocks(page: str) -> list[Block]:
    """Those of a page, in order."""
    found = []
    for match in FENCE.finditer(page):
        language, _, rest = match["words"].partition(" ")
        title = re.search(r'title="([^"]+)"', rest)
        found.append(Block(language, title[1] if title else "", match["body"], page.count("\n", 0, match.start()) + 1))
    return found


def run(page: str, names: dict[str, object]) -> Iterator[Shown]:
    """Run the blocks of a page in the working folder, with ``names`` as the session's; yields what is shown, printed or not."""
    found, names["__name__"] = blocks(page), "__main__"
    for block, after in zip(found, [*found[1:], Block("", "", "", 0)], strict=True):
        if block.title:
            if block.language == "python":
                compile(block.body, block.title, "exec")  # also where no other block imports it
            with Path(block.title).open("a", encoding="utf-8") as file:
                file.write(block.body)
        elif block.language == "python":
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile(block.body, f"<line {block.line}>", "exec"), names)
            yield Shown(block, after.body if after.language == "text" else "", printed.getvalue())
        elif block.language == "console":
            for command, wanted in commands(block.body):
                yield Shown(block, wanted, terminal(command))


def commands(body: str) -> Iterator[tuple[str, str]]:
    """Commands of a console block with what they print."""
    for part in re.split(r"^\$ ", body, flags=re.MULTILINE)[1:]:
        command, _, wanted = part.partition("\n")
        yield command, wanted


def terminal(command: str) -> str:
    """What a command of pinpress prints."""
    program, *arguments = shlex.split(command)
    if program != "pinpress":
        raise ValueError(f"the page shows {command!r}: only commands of pinpress are run here")
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed), contextlib.suppress(SystemExit):
        main(arguments)
    return printed.getvalue()
