"""Commands in the shell blocks of the pages do what they are there for, run one after the other in a folder as a reader runs them.

Blocks that show what is printed (``console``) are run with their pages, in `test_docs`; those in tables and sentences are forms, with FILE
in them, and their options exist.
"""

import re
import shlex
from pathlib import Path

import pytest
from support import page_blocks
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
NOT_RUN = {  # commands that begin so, and why
    "pinpress view": "serves until it is stopped; tests/live",
    "pinpress measured vibration": "its records are made by the page's own script; tests/cli/measured/test_vibration_command.py",
    "python3 -m venv": "tests/project/test_installed_wheel.py",
    ".venv/bin/": "tests/project/test_installed_wheel.py",
    "pip install": "tests/project/test_installed_wheel.py",
    "dask scheduler": "serves until it is stopped; tests/sweeps/test_sweep_cluster.py",
    "dask worker": "as the scheduler",
    "rattler-build": "needs conda-forge; `nox -s review` renders its recipe",
}
QUICK = ("pin_table",)
TOGETHER = "\n".join(path.read_text("utf-8") for path in (*sorted(DOCS.glob("*.md")), ROOT / "README.md", ROOT / "CHANGELOG.md"))


def commands(page: str) -> list[str]:
    """Those of a page's shell blocks, lines that go on put together, without variables of the environment."""
    shell = [block.body for block in page_blocks.blocks((DOCS / f"{page}.md").read_text("utf-8")) if block.language in ("", "sh", "bash")]
    lines = [line for body in shell for line in body.replace("\\\n", " ").splitlines() if line.strip()]
    return [re.sub(r"^(\w+=\S+ +)+", "", line) for line in lines]


PAGES = [path.stem for path in sorted(DOCS.glob("*.md")) if commands(path.stem)]


def run_here(command: str) -> bool:
    return not command.startswith(tuple(NOT_RUN))


@pytest.mark.parametrize("page", rest_exhaustive([page for page in PAGES if any(map(run_here, commands(page)))], *QUICK))
def test_commands_of_a_page_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("docs", "urdf"):  # as in a checkout
        (tmp_path / folder).symlink_to(ROOT / folder)
    text = (DOCS / f"{page}.md").read_text("utf-8")
    if 'title="' in text:  # its commands may read the files that it shows, and those that its code writes
        for _ in page_blocks.run(text, {}):
            pass
    for command in filter(run_here, commands(page)):
        program, *words = shlex.split(command, comments=True)
        assert program == "pinpress", command
        if words[0] == "new":
            Path(words[1]).unlink(missing_ok=True)  # a page that shows several presses gives them all one name
        code = main(words)
        assert code == 0, (command, capsys.readouterr().err)
        files = [words[place + 1] for place, word in enumerate(words) if word == "--out"]
        assert all(Path(file).exists() for file in files), command


def test_every_reason_is_needed() -> None:
    every = [command for page in PAGES for command in commands(page)]
    assert [start for start in NOT_RUN if not any(command.startswith(start) for command in every)] == []


NAMES = set(re.findall(r"`pinpress ((?:measured )?[a-z]+)(?=[ `])", TOGETHER))


@pytest.mark.parametrize("name", sorted(NAMES))
def test_options_of_commands_in_sentences_exist(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main([*name.split(), "--help"])
    assert end.value.code == 0, f"there is no pinpress {name}"
    options = set(re.findall(r"--[a-z][\w-]*", capsys.readouterr().out))
    forms = rf"{name}|\S+\.yaml|{'|'.join(pp.presses())}" if name == "report" else name  # its name may be left out
    forms += "(?! (?:identify|force|vibration))" if name == "measured" else ""
    said = {
        option
        for words in re.findall(rf"`pinpress (?:{forms})(?=[ `])([^`]*)`", TOGETHER)
        for option in re.findall(r"--[a-z][\w-]*", words)
    }
    assert said - options == set()
