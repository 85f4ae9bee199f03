"""Libraries and data are compressed inside a page; a browser opens them, or says why it cannot."""

import base64
import re
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support import texts
from support.in_browser import NO_WEBGL, data_in

import pinpress as pp
from pinpress.visual import pages

SPEED = 70 * pp.RPM
STIFF = pp.elasticity.Stiffness(bearings={"O": 1e9})


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    press = texts.shipped("crank_slide")
    return pp.record(press, pp.cycle(press, speed=SPEED, points=36), tmp_path_factory.mktemp("packed") / "out.html")


@pytest.fixture
def said(browser: Any, tmp_path: Path) -> Callable[..., str]:
    """What a page shows of itself in words, in a browser of its own."""

    def words(text: str, before: str = "", **context: Any) -> str:
        path = tmp_path / "page.html"
        path.write_text(text, encoding="utf-8")
        with browser.new_context(**context) as fresh:
            page = fresh.new_page()
            page.add_init_script(before)
            page.goto(path.as_uri())
            return str(page.inner_text(".message"))

    return words


@pytest.mark.parametrize("length", range(9))
def test_base_85_is_the_standard_one(length: int) -> None:
    """Of any number of bytes after the last whole word."""
    content = bytes(range(256)) * length + b"\xff" * length
    packed = pages.pack(content)
    standard = base64.b85decode(packed)
    assert zlib.decompress(standard) == content
    assert packed == base64.b85encode(standard).decode()


def test_pages_of_the_six_bar_are_small(tmp_path: Path) -> None:
    press, before = texts.shipped("zxn2_3000b_balanced"), texts.shipped("zxn2_3000b")
    motion, other = pp.cycle(press, speed=SPEED), pp.inverse_dynamics(before, pp.cycle(before, speed=SPEED))
    reactions, page = pp.inverse_dynamics(press, motion), tmp_path / "out.html"
    assert pp.record(press, motion, page, reactions=reactions).stat().st_size < 0.6e6
    assert len(data_in(page)["time"]) == 361
    assert pp.report(press, motion, page, reactions=reactions, before=other).stat().st_size < 2.6e6


@pytest.mark.exhaustive
def test_a_browser_without_decompression_is_told(recording: Path, said: Callable[..., str]) -> None:
    words = said(recording.read_text("utf-8"), "delete self.DecompressionStream")
    assert (
        words
        == "The page cannot be opened: this browser is too old for it; Chrome and Edge 80, Firefox 113, Safari 16.4 and later show it."
    )


def test_a_browser_without_webgl_has_all_but_the_moving_press(browser: Any, tmp_path: Path) -> None:
    """A drawing, the numbers, and charts whose cursor follows the slider; nothing fails, on paper neither."""
    press = pp.load("crank_slide")
    motion = pp.cycle(press, speed=5.0, points=60)
    path = pp.report(press, motion, tmp_path / "report.html", results=[pp.elasticity.compliance(press, STIFF)])
    with browser.new_context() as fresh:
        page, wrong = fresh.new_page(), list[str]()
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.add_init_script(NO_WEBGL)
        page.goto(path.as_uri())
        assert page.inner_text(".message").startswith("This browser cannot draw the moving press: WebGL is switched off")
        assert page.evaluate("document.querySelector('#drawing').naturalWidth") > 100
        assert "stroke" in page.inner_text(".verdict")
        page.evaluate("setPlaying(false); seek(0.5 * duration)")
        assert page.evaluate("document.querySelectorAll('.plot .js-line').length") > 5
        assert "180.0" in page.inner_text("#crank")
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert page.evaluate("document.querySelector('#snapshot').src.startsWith('data:image/svg')")
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        assert wrong == []


@pytest.mark.exhaustive
def test_a_page_without_scripts_says_so(recording: Path, said: Callable[..., str]) -> None:
    assert "needs JavaScript" in said(recording.read_text("utf-8"), java_script_enabled=False)


@pytest.mark.exhaustive
@pytest.mark.parametrize("share", [pytest.param(0.3, marks=pytest.mark.exhaustive), 0.98])
def test_a_page_that_was_cut_off_says_so(share: float, recording: Path, said: Callable[..., str]) -> None:
    text = recording.read_text("utf-8")
    assert said(text[: int(share * len(text))]).startswith("The page cannot be opened: ")


@pytest.mark.exhaustive
def test_no_script_but_the_pages_own_is_run(recording: Path, browser: Any, tmp_path: Path) -> None:
    """The security policy names them by their digests."""
    foreign = tmp_path / "foreign.html"
    foreign.write_text(recording.read_text("utf-8").replace("<header>", "<header><script>self.foreign = 1</script>"), encoding="utf-8")
    with browser.new_context() as fresh:
        page = fresh.new_page()
        page.goto(foreign.as_uri())
        page.evaluate("unpacked")
        page.evaluate("document.body.append(Object.assign(document.createElement('script'), { textContent: 'self.foreign = 2' }))")
        assert page.evaluate("[typeof viewer, typeof foreign]") == ["object", "undefined"]


def test_licences_stand_in_the_page(recording: Path, tmp_path: Path) -> None:
    """In words, as their licences ask."""
    press = texts.shipped("crank_slide")
    report = pp.report(press, pp.cycle(press, speed=SPEED, points=36), tmp_path / "out.html")
    for page, names in ((recording, ["Robin Deits"]), (report, ["Robin Deits", "Plotly, Inc."])):
        licences = re.search(r'id="licences">(.*?)</script>', page.read_text("utf-8"), re.DOTALL)
        assert licences is not None
        assert all(name in licences[1] for name in names)
