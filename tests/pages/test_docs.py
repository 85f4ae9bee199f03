"""The documentation says what is so: its code runs, its tables are what their scripts print, its pages are short."""

import dataclasses
import inspect
import re
import shlex
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any

import make
import numpy as np
import pytest
from support import mistakes, page_blocks
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.cli.main import _parser

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
TABLES = ("balancing", "servo", "synthesis")  # scripts in viz, of the pages of the same names
RUN = [
    "cam_tables",
    "balancing",
    "commands",
    "elastic_motion",
    "elasticity",
    "export",
    "fe",
    "mains",
    "foundation",
    "jobs",
    "lectures",
    "motion_and_forces",
    "ratings",
    "recording",
    "robots",
    "servo",
    "pins",
    "several_drivers",
    "simulation",
    "slide_accuracy",
    "start",
    "stopping",
    "sweep",
    "synthesis",
    "timing",
    "tolerances",
]

RUN += [
    "engines",
    "errors",
    "fifteen_jobs",
    "press_parts",
    "machine_elements",
    "measured",
    "measured_vibration",
    "motor",
    "pin_table",
    "pinocchio",
    "units_and_signs",
]
# these take as long as all others
LONG = {"elastic_motion", "foundation", "measured", "motor", "pinocchio", "press_parts", "ratings", "simulation", "sweep"}
LONG |= {"balancing", "elasticity", "measured_vibration", "recording", "robots", "servo", "several_drivers", "synthesis", "slide_accuracy"}
LONG |= {"fifteen_jobs", "jobs", "motion_and_forces", "stopping", "tolerances"}
SPACES = [name for name in dir(pp) if inspect.ismodule(getattr(pp, name))] + ["balancing.classical"]
PICTURED = ["accuracy", "balancing", "describe", "elasticity", "foundation", "limits", "motion_and_forces", "pin_table", "pinocchio"]
PICTURED += ["elastic_motion", "measured", "servo", "commands", "mistakes", "motor", "kong2025", "zhang2007", "chen2002"]
PICTURED += [
    "ratings",
    "recording",
    "robots",
    "simulation",
    "slide_accuracy",
    "sweep",
    "synthesis",
    "tolerances",
    "tour",
    "units_and_signs",
]
PICTURED += ["engines", "errors", "machine_elements", "measured_vibration", "press_parts"]
SITE_TOOLS = ("mkdocs", "material", "mkdocstrings_handlers")


def text(page: str) -> str:
    return (DOCS / f"{page}.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", rest_exhaustive(RUN, *set(RUN) - LONG))
def test_code_of_a_page_runs_and_prints_what_is_shown(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))  # modules that a page writes
    (tmp_path / "docs").symlink_to(DOCS)  # records, as in a checkout
    names: dict[str, Any] = {}
    for shown in page_blocks.run(text(page), names):
        assert shown.same, f"{page}.md, line {shown.block.line}, shows\n{shown.wanted}\nbut prints\n{shown.printed}"
    if page == "pinocchio":
        _end_the_viewer(names["viewer"].viewer.window)
    if page == "motion_and_forces":
        _point_force_is_seen_by_the_drive_but_not_by_the_foundation(names)


def _end_the_viewer(window: Any) -> None:
    """Meshcat leaves its server to the end of the session."""
    window.server_proc.kill()
    window.server_proc.communicate()
    window.zmq_socket.close()


def _point_force_is_seen_by_the_drive_but_not_by_the_foundation(names: dict[str, Any]) -> None:
    pressing, reactions = names["pressing"], names["reactions"]
    assert pressing.driving_torque.max() > 1.5 * reactions.driving_torque.max()
    np.testing.assert_allclose(pressing.shaking_force, reactions.shaking_force, atol=1e-6)
    before, after = (sum(inertia.mass for inertia in press.model.inertias) for press in (names["press"], pp.load("with_die.urdf")))
    assert after == pytest.approx(before + 500)


def test_every_page_with_code_is_run() -> None:
    shown = ("python", "console")
    with_code = {path.stem for path in DOCS.glob("*.md") if any(block.language in shown for block in page_blocks.blocks(text(path.stem)))}
    assert with_code - {*RUN, "tour"} == set()  # the tour has a test of its own


@pytest.mark.parametrize("name", rest_exhaustive(TABLES, "balancing"))
def test_tables_are_what_their_scripts_print(name: str) -> None:
    for table in make.load(name).table().split("\n\n"):
        assert table in text(name)


def test_comparisons_show_what_was_measured() -> None:
    measured = import_module("benchmarks.accuracy.program_tables")
    for table in measured.table().split("\n\n"):
        assert table in text("accuracy")
    assert measured.in_short() in (ROOT / "README.md").read_text(encoding="utf-8")


def test_shipped_presses_are_listed() -> None:
    assert {name for name in pp.presses() if f"`{name}`" not in text("describe")} == set()


def test_links_between_files_lead_somewhere() -> None:
    """As they lie in the repository; the site's own are checked by its building."""
    for path in DOCS.rglob("*.md"):
        for target in re.findall(r"\]\((?!http)([^)#]+)", path.read_text(encoding="utf-8")):
            assert (path.parent / target).exists(), f"{path.relative_to(ROOT)}: {target}"


def test_names_and_files_in_sentences_exist() -> None:
    """Code is run; this is for what stands between it."""
    pages = {path.name: path.read_text(encoding="utf-8") for path in (*DOCS.glob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md")}
    missing = [
        f"{page}: pp.{name}" for page, words in pages.items() for name in re.findall(r"`pp\.([\w.]*\w)", words) if not _is_public(name)
    ]
    files = r"(?:python |`)((?:tests|viz|docs|pinpress)/[\w/.]*\w)"
    missing += [f"{page}: {file}" for page, words in pages.items() for file in re.findall(files, words) if not (ROOT / file).exists()]
    made = r"python docs/make\.py (\w+)"
    missing += [f"{page}: {name}" for page, words in pages.items() for name in re.findall(made, words) if name not in make.scripts()]
    assert missing == []


def test_glossary_has_each_quantity_of_a_motion_of_reactions_and_of_a_run() -> None:
    press = pp.load("crank_slide")
    columns = [*pp.cycle(press, 7.0, points=4).columns(), *pp.simulate(press, 0.1, speed=7.0, points=4).columns()]
    quantities = {column.partition(" ")[0] for column in columns} - {"time"}
    quantities |= {field.name for field in dataclasses.fields(pp.Reactions) if "Array" in str(field.type) and field.name[0] != "_"}
    quantities |= {"shaking_force", "shaking_moment", "process_force", "power_residual", "indeterminate", "coupling_torque"}
    assert {name for name in quantities if f"`{name}`" not in text("glossary")} == set()


def _is_public(name: str) -> bool:
    try:
        attrgetter(name)(pp)
    except AttributeError:
        return False
    return True


def test_reference_has_every_public_name() -> None:
    """The pages are those that their script writes, and have all namespaces."""
    scripts = make.load("reference_pages")
    written = {path.name: path.read_text(encoding="utf-8") for path in (DOCS / "reference").glob("*.md")}
    assert written == scripts.pages(), "python docs/make.py reference_pages"
    assert scripts.menu() in (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert sorted(space for _, spaces in scripts.PAGES.values() for space in spaces.split()) == sorted(SPACES)


@pytest.mark.exhaustive
def test_answers_to_mistakes_are_what_is_said_today() -> None:
    script = make.load("write_answers")
    answers = script.answers()
    assert (ROOT / "tests" / "mistakes" / "answers.md").read_text(encoding="utf-8") == answers, "python docs/make.py write_answers"
    assert (DOCS / "mistakes.md").read_text(encoding="utf-8") == script.guide(), "python docs/make.py write_answers"
    assert "|  |" not in answers, "nothing is said to a mistake"


@pytest.mark.parametrize("right", [mistakes.TABLE, mistakes.URDF], ids=lambda file: file.name)
def test_mistakes_are_named_in_their_files_and_nothing_is_said_to_what_is_right(right: Path) -> None:
    assert mistakes.said(right) == []
    for file in mistakes.files(right):
        named = re.search(r"Mistake: (?:an? |the )?(.*?)(?: -->)?\n", file.read_text(encoding="utf-8"))
        assert named is not None, file
        assert re.sub(r"\W+", "-", named[1].replace("'s", "")).lower() == file.stem


@pytest.mark.parametrize("page", sorted([*DOCS.glob("*.md"), ROOT / "README.md"]), ids=lambda page: page.stem)
def test_commands_of_pages_are_read(page: Path) -> None:
    """The parser knows the options of every command that stands whole in a block; those with ... are not looked at."""
    blocks = re.findall(r"^```.*?\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    parser, commands = _parser()
    lines = (line.removeprefix("$ ") for block in blocks for line in block.replace("\\\n", "").splitlines())
    for line in lines:
        if line.startswith("pinpress ") and "..." not in line:
            words = shlex.split(line, comments=True)[1:]
            assert parser.parse_args([*([] if words[0] in commands else ["report"]), *words]).run


def test_the_gallery_is_what_its_script_writes() -> None:
    gallery_films = make.load("gallery_films")
    assert text("gallery") == gallery_films.page(), "python docs/make.py gallery_films page"
    films = {path.stem: path.stat().st_size for path in (DOCS / "gallery").glob("*.webp")}
    assert set(films) == {shown.table for shown in gallery_films.PRESSES}
    assert max(films.values()) <= gallery_films.LIGHT


def minutes(page: str) -> float:
    """Time to read a page aloud once in the mind, at 200 words a minute; code, tables and pictures are looked at, not read."""
    page = re.sub(r"<!-- keys -->.*<!-- keys -->", " ", page, flags=re.DOTALL)  # looked things up in
    prose = re.sub(r"^ *```.*?^ *```|^ *\|.*?$|!\[[^\]]*\]|\]\([^)]*\)|\A---.*?^---", " ", page, flags=re.DOTALL | re.MULTILINE)
    return len(re.findall(r"\w[\w.'’-]*", prose)) / 200


def test_each_page_is_read_in_eight_minutes() -> None:
    """The changelog is looked things up in."""
    pages = [*DOCS.rglob("*.md"), *(ROOT / "viz").glob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    assert {path.name: minutes(path.read_text(encoding="utf-8")) for path in pages if minutes(path.read_text(encoding="utf-8")) > 8} == {}


def test_pages_of_features_have_light_pictures() -> None:
    """With words for those who do not see them, and a command of the page that makes them."""
    for page in PICTURED:
        shown = re.findall(r"!\[([^\]]*)\]\(([^)]+)\)", text(page))
        assert shown, page
        assert all(len(words) > 10 and (DOCS / path).stat().st_size <= 150_000 for words, path in shown), page
        assert re.search(r"python docs/make\.py \w+|python tests/validation/\w+\.py|pinpress build", text(page)), page


@pytest.mark.parametrize(("folder", "made_by"), [("pictures", "PICTURES"), ("drawings", "DRAWINGS")])
def test_every_picture_of_the_guide_is_made_and_shown(folder: str, made_by: str) -> None:
    made = {picture.__name__ for picture in getattr(make.load(folder), made_by)}
    assert {path.stem for path in (DOCS / folder).iterdir()} == made
    pages = "".join(path.read_text(encoding="utf-8") for path in DOCS.glob("*.md"))
    assert {name for name in made if f"({folder}/{name}." not in pages} == set()
