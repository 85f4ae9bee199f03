"""Fifteen jobs of a press engineer, as docs/fifteen_jobs.md shows them: lines that the user writes, seconds, result.

Quick: without the sweep, which takes longer than all others.
"""

import contextlib
import os
import re
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from benchmarks.stopwatch import once, table
from support import page_blocks

PAGE = Path(__file__).resolve().parents[3] / "docs" / "fifteen_jobs.md"
LONG = "Three lengths by ten values"


def result(shown: list[page_blocks.Shown]) -> str:
    """What a job prints, by the first two lines with a number that the page shows of it; or the file that it writes."""
    lines = [" ".join(line.split()) for each in shown for line in each.wanted.splitlines()]
    return "; ".join([line for line in lines if re.search(r"\d", line)][:2] or lines[-1:])


def row(title: str, text: str, names: dict[str, object]) -> tuple[object, ...]:
    """Run a job: its name, lines of it, commands, seconds, result, and whether it prints what the page shows."""
    blocks = page_blocks.blocks(text)
    lines = sum(bool(line) for block in blocks if block.language in ("yaml", "python") for line in block.body.splitlines())
    typed = [command for block in blocks if block.language == "console" for command, _ in page_blocks.commands(block.body)]
    shown, seconds = once(lambda: list(page_blocks.run(text, names)), time.perf_counter)
    same = "yes" if all(each.same for each in shown) else "no"
    return title, lines, "; ".join(typed), f"{seconds:.1f}", result(shown), same


@contextlib.contextmanager
def in_a_folder() -> Iterator[None]:
    """Work in a temporary folder."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)


def main(quick: bool) -> None:
    """Run the jobs of the page one after the other, in a folder of their own."""
    start, *jobs = re.split(r"^## ", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    parts = [job.partition("\n") for job in jobs]
    names: dict[str, object] = {}
    with in_a_folder():
        list(page_blocks.run(start, names))
        rows = [row(title, text, names) for title, _, text in parts if not (quick and title == LONG)]
    print(f"Seconds of one run in one process on {os.cpu_count()} cores; the start of Python is not in them.\n")
    print(table(["job", "lines", "command", "s", "result", "as the page shows"], rows))
