"""The built site: it builds without a warning, has every public name, needs no network, fits a phone, its links lead somewhere, and its
search finds.
"""

import importlib.util
import inspect
import os
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from html import unescape
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from operator import attrgetter
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import manual
import pytest

import pinpress as pp

ROOT = Path(__file__).resolve().parents[2]
SPACES = [name for name in dir(pp) if inspect.ismodule(getattr(pp, name))] + ["balancing.classical"]
SITE_TOOLS = ("mkdocs", "material", "mkdocstrings_handlers")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built site; no warnings."""
    if any(importlib.util.find_spec(name) is None for name in SITE_TOOLS):
        pytest.skip("needs pip install -e '.[docs]'")
    target = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(target)]  # --quiet would make warnings no errors
    done = subprocess.run(command, cwd=ROOT, env=os.environ | {"NO_MKDOCS_2_WARNING": "1"}, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return target


@pytest.mark.exhaustive
def test_site_has_every_public_name_with_its_signature_and_docstring(site: Path) -> None:
    pages = {path: path.read_text(encoding="utf-8") for path in (site / "reference").glob("*.html")}
    together = "\n".join(pages.values())
    for name in (*dir(pp), *(f"{space}.{name}" for space in SPACES for name in dir(attrgetter(space)(pp)))):
        thing = attrgetter(name)(pp)
        if inspect.ismodule(thing):
            continue
        (at,) = (place.end() for place in re.finditer(rf'<h2 id="{re.escape(f"pinpress.{name}")}"', together))
        shown = re.split("<h2 ", together[at:])[0]
        words = _words(unescape(re.sub(r"<[^>]*>", "", shown)))
        documented = "One revolution per minute" if name == "RPM" else thing.__doc__
        assert _words(documented.split("\n\n")[0]) in words, f"{name}: its docstring"
        if inspect.isfunction(thing):
            assert set(inspect.signature(thing).parameters) <= set(words.split()), f"{name}: its signature"


def _words(passage: str) -> str:
    return " ".join(re.findall(r"\w+", passage))


@pytest.mark.exhaustive
def test_pages_say_of_which_version_they_are(site: Path) -> None:
    assert all(f"pinpress {pp.__version__}\n" in path.read_text(encoding="utf-8") for path in site.rglob("*.html"))


@pytest.mark.exhaustive
def test_site_asks_for_nothing_from_the_network(site: Path) -> None:
    """Links that a reader may click are no requests."""
    for path in site.rglob("*.html"):
        page = path.read_text(encoding="utf-8")
        fetched = re.findall(r'<(?:script|img|iframe|source)\b[^>]*\bsrc="(https?:[^"]*)"', page)
        fetched += re.findall(r'<link\b[^>]*rel="(?:stylesheet|preload|preconnect|icon)"[^>]*href="(https?:[^"]*)"', page)
        assert fetched == [], path.name


NO_OVERFLOW = """() => {
    const width = document.documentElement.clientWidth;
    const scrolls = element => element && (
        ["auto", "scroll", "hidden"].includes(getComputedStyle(element).overflowX) && element.getBoundingClientRect().right <= width + 1
        || scrolls(element.parentElement));
    return [...document.querySelectorAll(".md-content *")]
        .filter(element => element.getBoundingClientRect().width && element.getBoundingClientRect().right > width + 1)
        .filter(element => !scrolls(element.parentElement)).map(element => element.outerHTML.slice(0, 100));
}"""


@pytest.mark.exhaustive
def test_site_fits_a_phone(site: Path, browser: Any) -> None:
    """Tables and code scroll by themselves; no page is wider than the screen."""
    page = browser.new_page(viewport={"width": 390, "height": 844})
    for path in sorted(site.rglob("*.html")):
        page.goto(path.as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= 390, path.name
        assert page.evaluate(NO_OVERFLOW) == [], path.name
    page.close()


EXTERNAL = {  # looked at by hand: tests have no network
    "https://distributed.dask.org",
    "https://github.com/clemense/yourdfpy",
    "https://github.com/stack-of-tasks/pinocchio",
    "https://nox.thea.codes",
    "https://pint.readthedocs.io",
    "https://pola.rs",
    "https://pre-commit.com",
}


class Page(HTMLParser):
    """The names of a page's places, and where its links and pictures lead."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.links: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.places.add(given.get("id") or "")
        self.links |= {target for key in ("href", "src") if (target := given.get(key))}


@pytest.mark.exhaustive
def test_links_lead_to_places_that_exist(site: Path) -> None:
    """Those of the built pages, whoever wrote them: Markdown, docstrings, the menu."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    broken, external = set(), set()
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if parts.scheme:
                external.add(link)
            elif path.name != "404.html" and not (
                target.exists() and (not parts.fragment or target.suffix != ".html" or unquote(parts.fragment) in pages[target].places)
            ):
                broken.add(f"{path.relative_to(site)}: {link}")
    assert broken == set()
    assert {link for link in external if not link.startswith("data:")} == EXTERNAL


@pytest.mark.exhaustive
def test_manual_is_printed_with_contents_and_page_numbers(site: Path, browser: Any, tmp_path: Path) -> None:
    """A short one; the whole takes a minute."""
    menu = [{"Start": [{"Five minutes": "start.md"}, {"The tour": "tour.md"}]}, {"Engines": "engines.md"}, {"Changelog": "CHANGELOG.md"}]
    first = manual.write(tmp_path / "manual.pdf", site, menu, browser)
    assert list(first) == ["start.html", "tour.html", "engines.html"]  # the changelog is left out
    assert first["start.html"] == 2  # behind the contents
    assert 2 < first["tour.html"] < first["engines.html"]
    content = (tmp_path / "manual.pdf").read_bytes()
    assert content.count(b"/Type /Page\n") > first["engines.html"]
    assert b"/Subtype /Image" in content


# What users type, and the pages that answer it; the first three that the search shows must have one of them.
QUESTIONS = {
    "install": "install start",
    "torque curve": "motion_and_forces examples/permissible tour",
    "bearing load": "motion_and_forces examples/forces",
    "dead centre": "motion_and_forces tour",
    "instant centre": "lectures glossary",
    "Grashof": "lectures reference/motion",
    "stroke length": "motion_and_forces synthesis",
    "sign convention": "units_and_signs",
    "URDF loop": "describe",
    "loop joint": "describe",
    "loop_joint": "describe",
    "closed chain ROS": "describe examples/robots",
    "Gazebo SDF": "describe",
    "SolidWorks": "describe pin_table",
    "MuJoCo": "accuracy describe",
    "Adams": "accuracy",
    "Lagrange multiplier": "pinocchio engines",
    "constraint Jacobian": "pinocchio engines",
    "redundant constraints": "engines describe",
    "over-constrained": "engines describe",
    "dyads": "engines",
    "accuracy of results": "errors accuracy",
    "energy balance": "errors",
    "lockup": "describe examples/forces",
    "singularity": "describe engines errors robots",
    "Jacobian of a frame": "robots",
    "workspace": "robots",
    "computed torque controller": "robots",
    "parallel robot": "robots examples/robots",
    "Stewart platform": "robots describe",
    "convergence tolerance": "accuracy errors",
    "export to Excel": "motion_and_forces",
    "MATLAB": "motion_and_forces export",
    "Simulink": "export",
    "FMU": "export",
    "flywheel size": "examples/motor simulation",
    "clutch brake stopping time": "simulation examples/motor stopping",
    "friction in bearings": "simulation motion_and_forces examples/forces",
    "deep drawing": "simulation",
    "blanking force": "simulation press_parts",
    "die cushion": "press_parts",
    "moment of inertia of motor": "motor simulation",
    "motor temperature": "motor",
    "cam table": "cam_tables",
    "feed window": "timing servo",
    "timing diagram": "timing",
    "motion controller": "cam_tables servo",
    "choose a motor": "mains servo",
    "size of the flywheel": "mains",
    "servo motor selection": "servo examples/motor",
    "tonnage": "ratings",
    "bearing life": "pins",
    "finite elements": "fe",
    "CalculiX": "fe",
    "inertia relief": "fe",
    "pressure of a pin": "pins",
    "L10": "pins",
    "wear of a bush": "pins",
    "jobs of a press engineer": "fifteen_jobs",
    "light curtain": "stopping examples/motor",
    "safety distance": "stopping",
    "emergency stop": "stopping examples/motor",
    "overload": "ratings",
    "eccentric load": "ratings",
    "counterweight": "balancing examples/quiet",
    "shaking force": "motion_and_forces balancing examples/quiet",
    "vibration isolation": "foundation",
    "natural frequency": "elastic_motion foundation",
    "snap-through": "elasticity examples/quiet",
    "slide parallelism": "slide_accuracy",
    "play in bearings": "slide_accuracy",
    "link length optimisation": "synthesis",
    "knuckle joint press": "gallery pin_table tour",
    "hydraulic cylinder": "motion_and_forces gallery",
    "Jupyter notebook": "recording",
    "parallel computing cluster": "sweep",
    "process force without load cell": "measured",
    "inverse kinematics": "robots examples/robots",
    "hybrid press": "several_drivers",
    "two motors": "several_drivers",
    "inverse_dynamics": "motion_and_forces reference/pp",
    "own load": "simulation",
    "own drive": "simulation motor",
    "forces for FE": "motion_and_forces",
    "finite element forces": "motion_and_forces",
    "1000 variants": "sweep",
    "toggle double rods": "pin_table describe",
    "planetary gear": "machine_elements",
    "rack and pinion": "machine_elements",
    "tooth force": "machine_elements",
    "screw press": "machine_elements",
    "self-locking": "machine_elements",
    "cam law": "machine_elements",
    "power residual": "errors",
    "Windows": "install",
}
ASK = """async ([program, questions]) => {
    const index = await (await fetch("search/search_index.json")).json();
    const worker = new Worker(program);
    const asked = (message, kind) => new Promise(answered => {
        worker.onmessage = ({data}) => { if (data.type === kind) answered(data.data); };
        worker.postMessage(message);
    });
    await asked({type: 0, data: {config: index.config, docs: index.docs, options: {suggest: false}}}, 1);
    const found = [];
    for (const question of questions) {
        const {items} = await asked({type: 2, data: question}, 3);
        found.push(items.map(results => results[0].location));
    }
    return found;
}"""


@pytest.fixture
def served(site: Path, browser: Any) -> Iterator[Any]:
    """The first page of the site in a tab, as `mkdocs serve` gives it."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(SimpleHTTPRequestHandler, directory=str(site))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{server.server_port}/index.html")
        yield page
        page.close()
        server.shutdown()


@pytest.mark.exhaustive
def test_search_has_the_right_page_among_the_first_three(site: Path, served: Any) -> None:
    """Asked of the theme's own search program, in a browser."""
    (program,) = (site / "assets" / "javascripts" / "workers").glob("search*.js")
    answers = served.evaluate(ASK, [program.relative_to(site).as_posix(), list(QUESTIONS)])
    shown = {
        asked: [place.partition("#")[0].removesuffix(".html") for place in places[:3]]
        for asked, places in zip(QUESTIONS, answers, strict=True)
    }
    assert {asked: places for asked, places in shown.items() if not {*QUESTIONS[asked].split()} & {*places}} == {}


@pytest.mark.exhaustive
@pytest.mark.parametrize("opened", ["served", "from a file"])
def test_search_field_shows_what_its_program_finds(site: Path, served: Any, opened: str) -> None:
    """Also in pages that are opened by a double click, where browsers start no workers."""
    if opened == "from a file":
        served.goto((site / "index.html").as_uri())
    served.click("input.md-search__input")
    served.keyboard.type("loop joint")
    served.wait_for_selector("li.md-search-result__item:first-child a[href*='/describe.html']", timeout=60_000)
