"""Files beside the package: citation, archive, paper, forms and extras say what the package says."""

import json
import re
import runpy
from importlib import import_module
from pathlib import Path

import pytest
import yaml

import pinpress as pp

ROOT = Path(__file__).resolve().parents[2]
FORMS = sorted(path for path in (ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml") if path.name != "config.yml")


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def project() -> str:
    return text("pyproject.toml")


def test_citation_and_archive_name_the_package() -> None:
    citation, archive = yaml.safe_load(text("CITATION.cff")), json.loads(text(".zenodo.json"))
    assert citation["version"] == pp.__version__
    assert citation["title"] == archive["title"]
    assert citation["license"] == archive["license"] == "MIT"
    assert citation["keywords"] == archive["keywords"]
    assert [each["name"] for each in citation["authors"]] == [each["name"] for each in archive["creators"]]
    assert citation["references"][0]["doi"] == archive["related_identifiers"][0]["identifier"]


def test_citation_says_when_the_version_was_released_if_it_was() -> None:
    """As the changelog's heading of the version does, and the tag of the archive is the version's."""
    heading = re.search(rf"^## {re.escape(pp.__version__)} \((.*)\)$", text("CHANGELOG.md"), flags=re.MULTILINE)
    assert heading is not None, "the changelog has no heading of this version"
    released = yaml.safe_load(text("CITATION.cff")).get("date-released")
    assert str(released) == heading[1] if heading[1] != "unreleased" else released is None


def test_changelog_goes_by_release_newest_first() -> None:
    headings = re.findall(r"^## (.*)$", text("CHANGELOG.md"), flags=re.MULTILINE)
    found = [re.fullmatch(r"(\d+)\.(\d+)\.(\d+) \((unreleased|\d{4}-\d\d-\d\d)\)", heading) for heading in headings]
    assert None not in found
    versions = [tuple(int(number) for number in each.groups()[:3]) for each in found if each]
    assert versions == sorted(versions, reverse=True)


def test_citation_archive_and_project_agree_on_names_and_words() -> None:
    citation, archive = yaml.safe_load(text("CITATION.cff")), json.loads(text(".zenodo.json"))
    declared = dict(re.findall(r"^(\w+) = (.*)$", project().partition("[project]")[2], flags=re.MULTILINE))
    assert declared["license"] == f'"{citation["license"]}"'
    assert re.findall(r'name = "(.*?)"', declared["authors"]) == [each["name"] for each in citation["authors"]]
    assert {word.lower() for word in citation["keywords"]} <= set(re.findall(r'"(.*?)"', declared["keywords"]))
    assert archive["description"].startswith("Mechanical press linkages as ")
    assert declared["description"].startswith('"Mechanical press linkages as ')


def test_the_paper_cites_what_its_list_has() -> None:
    cited = set(re.findall(r"@(\w+\d\w*|drake)", text("paper/paper.md")))
    listed = set(re.findall(r"^@\w+\{(\w+),", text("paper/paper.bib"), flags=re.MULTILINE))
    assert cited == listed


def test_the_papers_times_and_errors_are_those_that_were_measured() -> None:
    measured = vars(import_module("benchmarks.accuracy.program_tables"))
    assert measured["in_paper"]() in text("paper/paper.md")
    turns = [row for file in measured["LINKAGES"] for row in measured["rows_of"](file) if row["group"] == "inverse dynamics"]
    errors = {row["method"]: max(float(row[of] or 0) for of in ("error", "force_error")) for row in turns}
    of_exudyn = [error for method, error in errors.items() if method.startswith("Exudyn")]
    assert max(error for error in errors.values() if error not in of_exudyn) < 1e-12
    assert 3e-3 < max(of_exudyn) < 4e-3
    assert "better than 1e-12 of the peak but\nExudyn, whose steps err by up to 4e-3" in text("paper/paper.md")


def test_the_paper_has_the_sections_and_the_length_that_joss_asks_for() -> None:
    """Of its guide for authors; the disclosure of how AI was used is for those who hand it in."""
    body = text("paper/paper.md").split("---", 2)[2].partition("# References")[0]
    titles = re.findall(r"^# (.*)$", body, flags=re.MULTILINE)
    wanted = ["Summary", "Statement of need", "State of the field", "Software design", "Research impact statement", "Acknowledgements"]
    assert titles == wanted
    words = [line for line in body.splitlines() if not line.startswith(("|", "#"))]
    assert 750 <= len(" ".join(words).split()) <= 1750


def test_the_papers_findings_are_those_of_the_pages() -> None:
    page = text("tests/validation/kong2025.md")
    assert re.search(r"^\| least shaking force, x, none higher \| 218 kg on the crank \| none \|.*\| -88\.", page, flags=re.MULTILINE)
    assert "| range of the shaking force, x, change [%] | -49.4824 | -47." in page
    balancing = text("docs/balancing.md")
    assert "| after its 17 steps | 113.31 | 1045.00 | 139.07 |" in balancing
    assert re.search(r"^\| optimum \| 32.2836 \| 1125.9727 \|  \| 0\.04", balancing, flags=re.MULTILINE)


def test_every_reference_of_the_paper_is_whole() -> None:
    """Each has its authors, title and year; what is in a journal, volume or number and pages; what has a DOI, one in its form."""
    for kind, key, fields in re.findall(r"^@(\w+)\{(\w+),\n(.*?)^\}", text("paper/paper.bib"), flags=re.MULTILINE | re.DOTALL):
        given = dict(re.findall(r"^  (\w+) = \{(.*)\}", fields, flags=re.MULTILINE))
        assert {"author", "title", "year"} <= given.keys(), key
        if kind == "article":
            assert {"journal", "number", "pages"} <= given.keys() or {"journal", "volume", "pages"} <= given.keys(), key
        assert re.fullmatch(r"10\.\d{4,}/\S+", given.get("doi", "10.1234/x")), key


@pytest.mark.parametrize("path", FORMS, ids=lambda path: path.stem)
def test_forms_ask_for_what_is_needed(path: Path) -> None:
    form = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert {"name", "description", "labels", "body"} <= form.keys()
    names = [field["id"] for field in form["body"]]
    assert len(set(names)) == len(names)
    for field in form["body"]:
        assert field["type"] == "textarea"
        assert field["attributes"]["label"]
    if path.stem != "press":
        assert "pinpress --version" in path.read_text(encoding="utf-8")


def test_there_are_forms() -> None:
    assert {path.stem for path in FORMS} == {"bug", "press", "wrong_number"}


def test_all_is_every_extra_of_users() -> None:
    """Those that `pinpress --version` lists, by the extras that hold the others."""
    from pinpress.cli.versions import OF_USERS

    extras = dict(re.findall(r"^(\w+) = (\[.*?\])", project(), flags=re.MULTILINE | re.DOTALL))
    held = set(re.findall(r"\w+", re.search(r"pinpress\[([\w,]+)\]", extras["all"])[1]))
    for name in list(held):
        if inner := re.search(r"pinpress\[([\w,]+)\]", extras[name]):
            held |= set(inner[1].split(","))
    assert held == set(OF_USERS)


ON_CONDA_FORGE = {  # names that differ from those on PyPI
    "pin": "pinocchio-python",
    "lazy-loader": "lazy_loader",
    "meshcat": "meshcat-python",
    "matplotlib": "matplotlib-base",
    "playwright": "playwright-python",
}


def declared(*lists: str) -> dict[str, str]:
    """Lowest versions by their names on conda-forge, of lists of `pyproject.toml`."""
    named = "".join(re.search(rf"^{name} = \[(.*?)\](?:\n|  #)", project(), flags=re.MULTILINE | re.DOTALL)[1] for name in lists)
    return {ON_CONDA_FORGE.get(name, name): f">={version}" for name, version in re.findall(r'"([\w-]+)>=([\d.]+)"', named)}


def test_the_recipe_for_conda_forge_has_the_names_and_versions_of_the_project() -> None:
    from pinpress.cli.versions import OF_USERS

    recipe = yaml.safe_load(text("conda/recipe.yaml"))
    lowest = recipe["context"]["python_min"]
    assert f'requires-python = ">={lowest}"' in project()
    assert recipe["context"]["version"] == pp.__version__
    assert recipe["about"]["license"] == "MIT"
    commands = re.findall(r'^pinpress = "pinpress.*"$', project(), flags=re.MULTILINE)
    assert recipe["build"]["python"]["entry_points"] == [command.replace('"', "") for command in commands]
    required = {part: dict(line.split(" ", 1) for line in lines if " " in line) for part, lines in recipe["requirements"].items()}
    python = {"python": ">=${{ python_min }}"}
    assert required["run"] == python | declared("dependencies")
    assert required["run_constraints"] == declared(*OF_USERS)
    assert required["host"] == {"python": "${{ python_min }}.*"} | declared("requires")


def test_tools_of_contributors_have_the_versions_of_the_continuous_integration() -> None:
    version = re.search(r"^ruff==(.*)$", text(".ci/constraints.txt"), flags=re.MULTILINE)[1]
    hooks = yaml.safe_load(text(".pre-commit-config.yaml"))["repos"]
    assert next(repo["rev"] for repo in hooks if "ruff" in repo["repo"]) == f"v{version}"


def test_sessions_of_nox_run_what_the_continuous_integration_runs() -> None:
    ci = text(".ci/run").replace(".venv-test/bin/", "")
    said = [" ".join(re.findall(r'"([^"]+)"', line)) for line in re.findall(r"session\.run\((.*)\)", text("noxfile.py"))]
    for command in ("ruff check .", "ruff format --check .", "mypy", "lint-imports --no-cache", "python -m pytest"):
        assert any(line.startswith(command) for line in said)
        assert command in ci


def test_sizes_count_code_without_comments_and_docstrings() -> None:
    sizes = runpy.run_path(str(ROOT / "tests" / "support" / "sizes.py"))
    assert sizes["code_lines"]('"""Words."""\n\n# a remark\nx = [\n    1,\n]\n\n\ndef f():\n    """More."""\n    return x\n') == 5
    rooms = sizes["counted"]((ROOT / "pinpress" / "accuracy").glob("*.py"), ROOT / "pinpress")
    assert rooms["accuracy"][0] == 3


def test_the_hosts_workflow_runs_the_continuous_integration_with_its_pythons() -> None:
    job = yaml.safe_load(text(".github/workflows/integration.yml"))["jobs"]["run"]
    *_, pythons, last = (step.get("run", "") for step in job["steps"])
    assert last == ".ci/run"
    tested = re.findall(r"^core \S+ (3\.\d+) ", text(".ci/run"), flags=re.MULTILINE)
    assert f"uv python install {' '.join(tested)}\n" in pythons


def test_pythons_are_the_same_wherever_they_are_named() -> None:
    pythons = re.findall(r'"(3\.\d+)"', re.search(r"^PINOCCHIOS = (.*)$", text("noxfile.py"), flags=re.MULTILINE)[1])
    tested = re.findall(r"^core \S+ (3\.\d+) ", text(".ci/run"), flags=re.MULTILINE)
    assert (tested[0], tested[-1]) == (pythons[0], pythons[-1])
    assert f'requires-python = ">={pythons[0]}"' in project()
    for page in ("README.md", "docs/install.md", "docs/start.md"):
        assert f"Python {tested[0]} to {tested[-1]}" in text(page), page
