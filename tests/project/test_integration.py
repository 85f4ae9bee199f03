"""Continuous integration cannot be green where something did not run: a step that fails ends it, and a test that is skipped there fails."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support import skips

ROOT = Path(__file__).resolve().parents[2]
# Stands for every program of .ci/run: notes what it is asked for, fails at the call of this number, and makes environments of itself.
PROGRAM = """#!/bin/sh
echo "$(basename "$0") $*" >> "$CALLS"
[ "$(wc -l < "$CALLS")" = "$FAILS_AT" ] && exit 3
if [ "$1 $2" = "-m venv" ]; then
  mkdir -p "$3/bin"
  for name in python pip ruff mypy lint-imports uv pinpress; do cp "$0" "$3/bin/$name"; done
fi
exit 0
"""


def integrate(folder: Path, fails_at: int) -> tuple[int, list[str], str]:
    """Exit code, calls and output of .ci/run where one call fails, with environments left over from a run before."""
    shutil.copytree(ROOT / ".ci", folder / ".ci")
    programs, calls = folder / "programs", folder / "calls"
    programs.mkdir()
    for name in ("python3", "python3.10", "python3.13", "python3.14", "chromium"):
        (programs / name).write_text(PROGRAM)
        (programs / name).chmod(0o755)
    for name in (".venv-test", ".venv-lowest", ".venv-3.13", ".venv-newest"):
        shutil.copytree(programs, folder / name / "bin")
        shutil.copy(programs / "python3", folder / name / "bin" / "python")
    environment = {"PATH": f"{programs}:/usr/bin:/bin", "CALLS": str(calls), "FAILS_AT": str(fails_at), "HOME": str(folder)}
    done = subprocess.run([folder / ".ci" / "run"], env=environment, capture_output=True, text=True, check=False)
    return done.returncode, calls.read_text().splitlines(), done.stdout


@pytest.mark.exhaustive
def test_every_step_that_fails_ends_the_integration(tmp_path: Path) -> None:
    code, steps, output = integrate(tmp_path / "good", 0)
    assert code == 0
    assert "NOT TESTED" not in output
    # The last asks for newer releases, which is no test; pythons are looked for by `-c`, and may be missing.
    *tests, _ = [number for number, step in enumerate(steps, 1) if " -c " not in step]
    assert [steps[number - 1] for number in tests].count("python -m pytest") == 1
    for number in tests:
        code, calls, _ = integrate(tmp_path / str(number), number)
        assert code == 3, calls
        assert calls == steps[:number]


@pytest.mark.exhaustive
def test_a_python_that_is_not_there_is_named(tmp_path: Path) -> None:
    _, steps, _ = integrate(tmp_path / "all", 0)
    asked = next(number for number, step in enumerate(steps, 1) if step.startswith("python3.13 -c"))
    code, _, output = integrate(tmp_path / "without", asked)
    assert code == 0
    assert "NOT TESTED: Python 3.13 is not on this machine" in output


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", ".ci/run", "README.md"])
def test_files_that_commands_name_are_there(page: str) -> None:
    named = re.findall(r"(?:tests|viz|docs|urdf|pinpress)/[\w/.{},-]*\w\}?", (ROOT / page).read_text(encoding="utf-8"))
    expanded = subprocess.run(["bash", "-c", f"echo {' '.join(named)}"], capture_output=True, text=True, check=True).stdout.split()
    assert expanded
    assert [path for path in expanded if not any((ROOT / each).exists() for each in (path, f"{path}.py"))] == []


SCRIPTS = [
    path.relative_to(ROOT).as_posix()
    for pattern in ("docs/*.py", "viz/*.py", "tests/benchmarks/**/*.py", "tests/validation/validate.py", "tests/**/[efsw]*_*.py")
    for path in sorted(ROOT.glob(pattern))
    if "__main__" in path.read_text(encoding="utf-8")
]
FROM_ELSEWHERE = "import runpy, sys; sys.path[0] = sys.argv[1].rpartition('/')[0]; runpy.run_path(sys.argv[1], run_name='imported')"


@pytest.mark.exhaustive
@pytest.mark.parametrize("script", SCRIPTS)
def test_scripts_find_what_they_import_from_any_folder(script: str, tmp_path: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [sys.executable, "-c", FROM_ELSEWHERE, str(ROOT / script)]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_nothing_is_skipped(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    pytester.makepyfile(
        test_module="import pytest; pytest.importorskip('no_such_package')\ndef test(): pass",
        test_tests="""
            import pytest
            def test_package(): pytest.importorskip("no_such_package")
            @pytest.fixture
            def browser(): pytest.skip("no browser")
            def test_fixture(browser): pass
            @pytest.mark.skipif(True, reason="elsewhere")
            def test_mark(): pass
            @pytest.mark.xfail
            def test_xfail(): assert False
            def test_passes(): pass
        """,
    )
    monkeypatch.delenv("CI", raising=False)
    pytester.inline_run("-p", "no:cacheprovider", plugins=[skips]).assertoutcome(passed=1, skipped=5)
    monkeypatch.setenv("CI", "1")
    reports = pytester.inline_run("-p", "no:cacheprovider", "--continue-on-collection-errors", plugins=[skips])
    failed = {str(report.longrepr).partition(" in CI: ")[0] for report in reports.getfailures()}
    assert failed == {"test_module.py", *(f"test_tests.py::test_{name}" for name in ("package", "fixture", "mark"))}
    assert len(reports.getreports("pytest_runtest_logreport")) > 0


@pytest.mark.exhaustive
def test_a_test_that_hangs_is_ended_with_its_trace(tmp_path: Path) -> None:
    """In compiled code, where no signal handler of Python would run."""
    (tmp_path / "test_hanging.py").write_text(
        "import ctypes\ndef test_hangs(): ctypes.PyDLL(None).sleep(60)\ndef test_after(): pass\n", encoding="utf-8"
    )
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-c",
        ROOT / "pyproject.toml",
        "-n",
        "1",
        "-o",
        "faulthandler_timeout=1",
        "--rootdir",
        tmp_path,
    ]
    done = subprocess.run([*command, tmp_path], env=os.environ, capture_output=True, text=True, check=False, timeout=50)
    assert done.returncode == 1
    assert 'test_hanging.py", line 2 in test_hangs' in done.stderr
    assert "1 failed, 1 passed" in done.stdout


def declared() -> dict[str, str]:
    """The lowest version of each package that pyproject.toml names, but for Drake, which is an extra that CI does not install."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8").partition("[project.scripts]")[0]
    text = re.sub("^drake = .*$", "", text, flags=re.MULTILINE)
    return dict(re.findall(r'"([\w-]+)(?:\[\w+\])?>=([\d.]+)(?:,<[\d.]+)?(?:;[^"]*)?"', text))


@pytest.mark.parametrize("name", ["constraints", "constraints-lowest"])
def test_constraints_are_those_of_the_declared_versions(name: str) -> None:
    """The lowest are the declared ones (or the first release after them), and nothing is left to chance."""

    def numbers(version: str) -> tuple[int, ...]:
        return tuple(int(n) for n in re.findall(r"\d+", version))

    text = (ROOT / ".ci" / f"{name}.txt").read_text(encoding="utf-8")
    pinned = dict(re.findall(r"^([\w-]+)==([\w.]+)", text, flags=re.MULTILINE))
    lowest = declared()
    assert len(lowest) > 20
    for package, version in lowest.items():
        assert numbers(pinned[package]) >= numbers(version), package
        if name.endswith("lowest"):
            assert numbers(pinned[package])[: len(numbers(version))] == numbers(version), package
