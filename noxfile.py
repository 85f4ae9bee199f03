#!/usr/bin/env -S uv run --script

# /// script
# dependencies = ["nox>=2025.2"]
# ///

"""The command of maintainers: `nox -l` lists the sessions. Five are for every day: check, docs, bench, validate, measure.

`.ci/run` is what the continuous integration runs, and needs no nox; it also tests the lowest and the newest versions.
"""

from pathlib import Path

import nox

nox.needs_version = ">=2025.2"
nox.options.default_venv_backend = "uv|virtualenv"
CONSTRAINTS = ".ci/constraints.txt"
PINOCCHIOS = ["3.10", "3.11", "3.12", "3.13", "3.14"]  # the Pythons for which Pinocchio's wheels exist
ALONE = ("manual", "page_licences")  # scripts of docs/make.py that come last or need arguments


def installed(session: nox.Session, extra: str = "test") -> None:
    """Install the package with an extra, in the versions of the continuous integration."""
    session.install("-e", f".[{extra}]", "-c", CONSTRAINTS)


@nox.session
def check(session: nox.Session) -> None:
    """Run linter, types, import layers and all tests, the long ones too; words behind -- go to pytest in place of all tests."""
    installed(session)
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("mypy")
    session.run("lint-imports", "--no-cache")
    session.run("python", "-m", "pytest", *(session.posargs or ["-m", ""]))


@nox.session(default=False)
def docs(session: nox.Session) -> None:
    """Write pictures and tables of the pages, then the site and the PDF; -- NAME ...: these scripts alone; -- site: the site alone."""
    installed(session)
    listed = session.run("python", "docs/make.py", silent=True) or ""
    names = session.posargs or [name for name in (line.split()[0] for line in listed.splitlines()) if name not in ALONE]
    for name in names:
        if name != "site":
            session.run("python", "docs/make.py", name)
    if not session.posargs or "site" in names:
        session.run("mkdocs", "build", "--strict")
    if not session.posargs:
        session.run("python", "docs/make.py", "manual")


@nox.session(default=False)
def bench(session: nox.Session) -> None:
    """Run benchmarks by their names, -- NAME ... [--quick]; without a name list them."""
    installed(session)
    session.run("python", "tests/benchmarks/run.py", *session.posargs)


@nox.session(default=False)
def validate(session: nox.Session) -> None:
    """Print what the documents print next to ours, -- [DOCUMENT ...] [--write]; fails if a number is not reproduced."""
    installed(session)
    session.run("python", "tests/validation/validate.py", *session.posargs)


@nox.session(default=False)
def measure(session: nox.Session) -> None:
    """Print the sizes of the project, by room."""
    session.run("python", "tests/support/sizes.py")


@nox.session(default=False, python=PINOCCHIOS)
def wheel(session: nox.Session) -> None:
    """Build sdist and wheel, install the wheel alone and try it as a stranger would, on one Python; nox -s wheel-3.13."""
    session.install("-e", ".[report]", "build", "hatchling", "hypothesis", "pytest", "pytest-xdist", "uv", "-c", CONSTRAINTS)
    versions = {"UV_CONSTRAINT": str(Path(CONSTRAINTS).resolve()), "PIP_CONSTRAINT": str(Path(CONSTRAINTS).resolve())}
    session.run("python", "-m", "pytest", "-m", "exhaustive", "tests/project/test_installed_wheel.py", *session.posargs, env=versions)


@nox.session(default=False)
def review(session: nox.Session) -> None:
    """Compare the repository with the habits of scientific Python, and check CITATION.cff, the Markdown and the workflow."""
    session.install("sp-repo-review[cli]", "cffconvert", "rumdl", "zizmor")
    session.run("sp-repo-review", ".")
    session.run("cffconvert", "--validate")
    session.run("rumdl", "check", ".")
    session.run("zizmor", "--offline", ".github")


@nox.session(default=False, python=PINOCCHIOS[0])
def recipe(session: nox.Session) -> None:
    """Build the recipe for conda-forge and run its tests, with packages of PyPI in place of those of conda-forge; on Linux."""
    session.install(".", "pip", "hatchling", "py-rattler-build>=0.73")
    session.install("build")
    session.run("python", "-m", "build", "--sdist")
    session.run("python", "conda/build_here.py")


if __name__ == "__main__":
    nox.main()
