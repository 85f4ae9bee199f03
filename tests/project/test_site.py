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
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from operator import attrgetter
from pathlib import Path
from typing import Any

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
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(target)]
    done = subprocess.run(command, cwd=ROOT, env=os.environ | {"NO_MKDOCS_2_WARNING": "1"}, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
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


# What users type, and the pages that answer it; the first three that the search shows must have one of them.
QUESTIONS = {
    "install": "install start",
    "torque curve": "motion_and_forces examples/torque_over_speed_and_force tour",
    "bearing load": "motion_and_forces examples/bearing_forces",
    "dead centre": "motion_and_forces",
    "stroke length": "motion_and_forces synthesis",
    "sign convention": "units_and_signs",
    "URDF loop": "describe tour_urdf",
    "loop joint": "describe",
    "loop_joint": "describe",
    "closed chain ROS": "describe examples/my_own_robot",
    "Gazebo SDF": "describe",
    "SolidWorks": "describe pin_table",
    "MuJoCo": "comparison describe",
    "Adams": "comparison",
    "Lagrange multiplier": "pinocchio engines",
    "constraint Jacobian": "pinocchio engines",
    "redundant constraints": "engines describe",
    "over-constrained": "engines describe",
    "dyads": "engines",
    "accuracy of results": "errors accuracy",
    "energy balance": "errors",
    "lockup": "describe examples/does_it_lock",
    "singularity": "describe engines errors",
    "convergence tolerance": "solvers errors",
    "export to Excel": "motion_and_forces",
    "MATLAB": "motion_and_forces",
    "flywheel size": "examples/flywheel simulation",
    "clutch brake stopping time": "simulation examples/emergency_stop",
    "friction in bearings": "simulation motion_and_forces examples/friction",
    "deep drawing": "simulation",
    "blanking force": "simulation press_parts",
    "die cushion": "press_parts",
    "moment of inertia of motor": "motor simulation",
    "motor temperature": "motor",
    "servo motor selection": "servo examples/which_servo_motor",
    "tonnage": "ratings",
    "overload": "ratings",
    "eccentric load": "ratings",
    "counterweight": "balancing examples/which_counterweight",
    "shaking force": "motion_and_forces balancing examples/floor",
    "vibration isolation": "foundation",
    "natural frequency": "elastic_motion foundation",
    "snap-through": "elasticity examples/break_through",
    "slide parallelism": "slide_accuracy",
    "play in bearings": "slide_accuracy",
    "link length optimisation": "synthesis",
    "knuckle joint press": "gallery pin_table tour",
    "hydraulic cylinder": "motion_and_forces gallery",
    "Jupyter notebook": "recording",
    "parallel computing cluster": "sweep",
    "process force without load cell": "process_force",
    "inverse_dynamics": "motion_and_forces reference/pp",
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
    """The first page of the site in a tab, as `mkdocs serve` gives it: the search does not work in pages that are opened from files."""
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
def test_search_field_shows_what_its_program_finds(served: Any) -> None:
    served.click("input.md-search__input")
    served.keyboard.type("loop joint")
    first = served.wait_for_selector("a.md-search-result__link", timeout=60_000)
    assert "/describe.html" in first.get_attribute("href")
