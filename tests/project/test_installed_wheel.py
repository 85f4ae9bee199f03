"""The wheel as a stranger gets it: alone in a new environment, run in an empty folder, it does what the README says and passes tests of the
source distribution; and the README's first line works where that is unpacked.

Packages come from the index that pip and uv are set up with; `UV_CONSTRAINT` and `PIP_CONSTRAINT` name their versions.
"""

import re
import sys
import tarfile
from dataclasses import dataclass
from pathlib import Path

import pytest
from support import distribution, page_blocks
from support.distribution import ROOT, elsewhere, run

README = (ROOT / "README.md").read_text(encoding="utf-8")
WHAT_TESTS_NEED = ("pytest", "pytest-xdist", "hypothesis")
# Rooms from the description to the forces, with random and damaged presses, that need no extra of developers.
TESTS = ("cli/test_versions", "dynamics/test_reference", "engines/test_one_joint", "kinematics/test_poses", "linkage/test_urdf")

pytestmark = pytest.mark.exhaustive


@dataclass(frozen=True)
class Stranger:
    """A new environment with the wheel in it, and the folder that the source distribution is unpacked in."""

    environment: Path
    unpacked: Path

    def run(self, program: str, *words: object, cwd: Path) -> str:
        return run(self.environment / "bin" / program, *words, cwd=cwd, env=elsewhere())

    def install(self, *what: object) -> None:
        """By uv, which takes seconds; beside the environment, so that no file of the checkout is near."""
        folder = self.environment.parent
        run(sys.executable, "-m", "uv", "pip", "install", "-q", "--python", self.environment, *what, cwd=folder, env=elsewhere())


@pytest.fixture(scope="module")
def stranger(tmp_path_factory: pytest.TempPathFactory) -> Stranger:
    folder = tmp_path_factory.mktemp("stranger")
    wheel, sdist = distribution.build(folder)
    run(sys.executable, "-m", "uv", "venv", "-q", "--python", sys.executable, folder / "environment", env=elsewhere())
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    made = Stranger(folder / "environment", folder / sdist.name.removesuffix(".tar.gz"))
    made.install(f"{wheel}[report]")
    return made


def test_the_readmes_commands_and_code_run_in_an_empty_folder(stranger: Stranger, tmp_path: Path) -> None:
    (command,) = re.findall(r"bin/pinpress (.*)", README)
    assert "wrote zxn2_3000b.html" in stranger.run("pinpress", *command.split(), cwd=tmp_path)
    assert (tmp_path / "zxn2_3000b.html").stat().st_size > 1_000_000
    code, _ = [block.body for block in page_blocks.blocks(README) if block.language == "python"]  # the second takes a file of the checkout
    (printed,) = [block.body for block in page_blocks.blocks(README) if block.language == "text"]
    assert stranger.run("python", "-c", code, cwd=tmp_path).strip() == printed.strip()
    assert (tmp_path / "report.html").stat().st_size > 1_000_000


def test_commands_find_what_is_shipped_in_the_wheel(stranger: Stranger, tmp_path: Path) -> None:
    """Presses, templates of tables and of pages; not those of a checkout."""
    where = stranger.run("python", "-c", "import pinpress; print(pinpress.__file__)", cwd=tmp_path)
    assert Path(where.strip()).is_relative_to(stranger.environment)
    versions = stranger.run("pinpress", "--version", cwd=tmp_path)
    needed, optional = (versions.partition(f"\n{part}\n")[2].partition("\n\n")[0] for part in ("Needed", "Optional"))
    assert needed
    assert "not installed" not in needed
    assert re.findall(r"(\S+) +not installed", optional)  # only what the extra brings is there
    stranger.run("pinpress", "new", "press.yaml", "--template", "knuckle", cwd=tmp_path)
    stranger.run("pinpress", "build", "press.yaml", cwd=tmp_path)
    assert "stroke" in stranger.run("pinpress", "check", "press.urdf", cwd=tmp_path)
    stranger.run("pinpress", "record", "underdrive", "--speed", "40r/min", "--out", "underdrive.html", cwd=tmp_path)
    assert (tmp_path / "underdrive.html").stat().st_size > 300_000


def test_an_extra_is_added_by_the_words_of_the_message(stranger: Stranger, tmp_path: Path) -> None:
    """pip and uv take the pinpress that is there, and need none from an index."""
    draw = "import pinpress as pp; press = pp.load('crank_slide'); pp.plots.draw(pp.cycle(press, 7.0), 'position')"
    with pytest.raises(AssertionError, match=r"pip install 'pinpress\[plots\]'"):
        stranger.run("python", "-c", draw, cwd=tmp_path)
    stranger.install("pinpress[plots]")
    stranger.run("python", "-c", draw, cwd=tmp_path)


def test_tests_of_the_source_distribution_pass_with_the_wheel(stranger: Stranger) -> None:
    stranger.install(*WHAT_TESTS_NEED)
    package = stranger.unpacked / "pinpress"
    if package.exists():
        package.rename(stranger.unpacked / "not_this_one")
    tests = [f"tests/{name}.py" for name in TESTS]
    printed = stranger.run("pytest", "-q", "-n", "0", "-m", "", "-p", "no:cacheprovider", *tests, cwd=stranger.unpacked)
    passed = re.search(r"(\d+) passed", printed)
    assert passed is not None
    assert int(passed[1]) > 80


def test_the_readmes_first_line_works_where_the_source_distribution_is_unpacked(stranger: Stranger, tmp_path: Path) -> None:
    (line,) = re.findall(r"```\n(python3 -m venv \.venv .*)\n```", README)
    with tarfile.open(next(stranger.unpacked.parent.glob("*.tar.gz"))) as archive:
        archive.extractall(tmp_path, filter="data")
    (folder,) = tmp_path.iterdir()
    python = Path(sys.executable).parent
    run("bash", "-euc", line, cwd=folder, env=elsewhere(PATH=f"{python}:/usr/bin:/bin"))
    assert (folder / "zxn2_3000b.html").exists()
