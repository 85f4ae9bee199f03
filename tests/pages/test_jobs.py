"""The page on jobs lists every section and key as they are read, and every job that a page shows is one, also for editors."""

import re
import warnings
from collections.abc import Iterator
from pathlib import Path

import jsonschema
import make
import pytest
import yaml
from support import page_blocks

import pinpress as pp
from pinpress.jobs.grammar import SECTIONS
from pinpress.jobs.schema import schema

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = {path.stem: path.read_text(encoding="utf-8") for path in sorted([*DOCS.glob("*.md"), DOCS.parent / "README.md"])}
PRESS = ("file", "base", "pins")  # keys of which a whole job has one
SCHEMA = jsonschema.Draft7Validator(schema())
MOST_WORDS = 900  # of the page on jobs, before its list of keys


def jobs(page: str) -> Iterator[page_blocks.Block]:
    """The blocks of a page that are whole jobs."""
    for block in page_blocks.blocks(PAGES[page]):
        if block.language == "yaml":
            items = yaml.safe_load(block.body)
            if isinstance(items, dict) and len(items) > 1 and any(key in items for key in PRESS):
                yield block


def test_the_page_shows_the_job_of_the_tests_and_the_keys_that_are_read() -> None:
    assert PAGES["jobs"] == make.load("job_keys").page(), "python docs/make.py job_keys"
    assert re.findall(r"^### `(\w+)`", PAGES["jobs"], re.MULTILINE) == list(SECTIONS)


def test_the_page_is_short_before_its_keys() -> None:
    text = re.sub(r"^```.*?^```", " ", PAGES["jobs"].partition("<!-- keys -->")[0], flags=re.DOTALL | re.MULTILINE)
    assert len(re.findall(r"\w[\w.'’-]*", text)) <= MOST_WORDS


@pytest.mark.parametrize("page", [page for page in PAGES if any(jobs(page))])
def test_jobs_of_a_page_are_read_and_pass_the_schema(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(DOCS)
    for block in page_blocks.blocks(PAGES[page]):
        if block.title:  # a file, which jobs may name
            with Path(block.title).open("a", encoding="utf-8") as file:
                file.write(block.body)
        if block.language == "console":
            for command, _ in page_blocks.commands(block.body):
                if command.startswith("pinpress new "):  # a template, which jobs may have for a base
                    page_blocks.terminal(command)
    for block in jobs(page):
        path = Path(block.title or "job_of_the_page.yaml")
        path.write_text(block.body, encoding="utf-8")
        items = yaml.safe_load(block.body)
        assert [error.message for error in SCHEMA.iter_errors(items)] == [], f"{page}.md, line {block.line}"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pp.PinpressWarning)
            pp.job(path)


def test_sections_of_the_pages_pass_the_schema() -> None:
    """Blocks that show some sections of a job are read with a press beside them."""
    for page, text in PAGES.items():
        for block in page_blocks.blocks(text):
            items = yaml.safe_load(block.body) if block.language == "yaml" else None
            if isinstance(items, dict) and set(items) <= set(SECTIONS) and not any(key in items for key in PRESS):
                errors = [error.message for error in SCHEMA.iter_errors({"file": "zxn2_3000b", **items})]
                assert errors == [], f"{page}.md, line {block.line}"
