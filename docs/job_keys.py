"""The sections and keys of a job, into docs/jobs.md between its marks, from the values that read them."""

import re

from make import DOCS, write

from pinpress.jobs import schema

PAGE = DOCS / "jobs.md"
MARK = "<!-- keys -->"


def page() -> str:
    """The page with its sections and keys as they are now."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(f"{MARK}\n")
    after = rest.partition(f"{MARK}\n")[2]
    keys = re.sub(r"\n{3,}", "\n\n", "\n".join(schema.manual()))
    return f"{before}{MARK}\n\n{keys.strip()}\n\n{MARK}\n{after}"


def main(quick: bool = False) -> None:
    """Write the page."""
    write(PAGE, page())
