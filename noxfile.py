#!/usr/bin/env -S uv run --script

# /// script
# dependencies = ["nox>=2025.2"]
# ///

"""What `.ci/run` does, in parts, for contributors who know nox: `nox -l` lists the sessions.

`.ci/run` stays the whole: it also tests the lowest and the newest versions.
"""

from pathlib import Path

import nox

nox.needs_version = ">=2025.2"
nox.options.default_venv_backend = "uv|virtualenv"
CONSTRAINTS = ".ci/constraints.txt"
PINOCCHIOS = ["3.10", "3.11", "3.12", "3.13", "3.14"]  # the Pythons for which Pinocchio's wheels exist


def installed(session: nox.Session, extra: str = "test") -> None:
    """Install the package with an extra, in the versions of the continuous integration."""
    session.install("-e", f".[{extra}]", "-c", CONSTRAINTS)


@nox.session
def tests(session: nox.Session) -> None:
    """Run the tests without the long ones; words behind -- go to pytest."""
    installed(session)
    session.run("python", "-m", "pytest", *session.posargs)


@nox.session(default=False)
def long(session: nox.Session) -> None:
    """Run the long tests: extremes, rare cases and most cases of tests with many."""
    installed(session)
    session.run("python", "-m", "pytest", "-m", "exhaustive", *session.posargs)


@nox.session(default=False, python=PINOCCHIOS)
def wheel(session: nox.Session) -> None:
    """Build sdist and wheel, install the wheel alone and try it as a stranger would, on one Python; nox -s wheel-3.13."""
    session.install("-e", ".[report]", "build", "hatchling", "hypothesis", "pytest", "pytest-xdist", "uv", "-c", CONSTRAINTS)
    versions = {"UV_CONSTRAINT": str(Path(CONSTRAINTS).resolve()), "PIP_CONSTRAINT": str(Path(CONSTRAINTS).resolve())}
    session.run("python", "-m", "pytest", "-m", "exhaustive", "tests/project/test_installed_wheel.py", *session.posargs, env=versions)


@nox.session
def lint(session: nox.Session) -> None:
    """Run the linter, the type checker and the check that imports point down."""
    installed(session)
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("mypy")
    session.run("lint-imports", "--no-cache")


@nox.session(default=False)
def docs(session: nox.Session) -> None:
    """Build the site, into out/site."""
    installed(session, "docs,report,plots")
    session.run("mkdocs", "build", "--strict")


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
