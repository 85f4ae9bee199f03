"""The sections and keys of a job, and a whole job, into docs/jobs.md, from the values that read them and from the tests."""

import re

from make import DOCS, ROOT, write

from pinpress.jobs import schema

PAGE = DOCS / "jobs.md"
JOB = ROOT / "tests" / "jobs" / "press_job.yaml"
MARK = "<!-- keys -->"
BLOCK = '```yaml title="press.yaml"\n'
END = "```\n"


def page() -> str:
    """The page with its job, its sections and its keys as they are now."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(f"{MARK}\n")
    head, _, tail = before.partition(BLOCK)
    before = f"{head}{BLOCK}{JOB.read_text(encoding='utf-8')}{END}{tail.partition(END)[2]}"
    after = rest.partition(f"{MARK}\n")[2]
    keys = re.sub(r"\n{3,}", "\n\n", "\n".join(schema.manual()))
    return f"{before}{MARK}\n\n{keys.strip()}\n\n{MARK}\n{after}"


def main(quick: bool = False) -> None:
    """Write the page."""
    write(PAGE, page())
