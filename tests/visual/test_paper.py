"""Pages on paper, printed by a real browser: the press as an image, whole charts in the width of the page, all bearings."""

import contextlib
import importlib.util
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from support import texts
from support.in_browser import FLAGS

import pinpress as pp
from pinpress.cli.main import main
from pinpress.visual.film import Screen, pdf

MILLIMETRE = 96 / 25.4  # pixels of a page
COLUMN, HEIGHT = 180 * MILLIMETRE, (297 - 14 - 17) * MILLIMETRE  # of what is printed on A4
LAYOUT = """() => [...document.querySelectorAll(".chart:not(.table), .bearing, .figures, #stage")].map(part => {
    const { left, right, height } = part.getBoundingClientRect();
    return { left, right, height };
})"""


@pytest.fixture
def on_paper(small_report: Path, view: Callable[..., Any]) -> Iterator[Any]:
    """The report as it is while it is printed."""
    page = view(small_report, "#t=0.2", (1000, 500))
    page.emulate_media(color_scheme="dark")
    before = page.evaluate("[document.body.innerText, document.querySelector('.plot').clientWidth]")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    yield page
    page.emulate_media(media="screen", color_scheme="light")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.wait_for_timeout(300)
    assert page.evaluate("[document.body.innerText, document.querySelector('.plot').clientWidth]") == before
    assert page.evaluate("[plots()[0]._fullLayout.width, document.querySelectorAll('.bearing').length]") == [before[1], 1]


@pytest.mark.exhaustive
def test_a_page_is_laid_out_for_paper(on_paper: Any) -> None:
    for part in on_paper.evaluate(LAYOUT):
        assert part["left"] >= 0
        assert part["right"] <= COLUMN + 0.5
        assert part["height"] <= HEIGHT  # so that it need not be split
    assert on_paper.evaluate("plots().every(plot => Math.abs(plot._fullLayout.width - plot.clientWidth) < 1)")
    titles = on_paper.evaluate("[...document.querySelectorAll('.bearing h3')].map(title => title.textContent)")
    shown = [title.split(" [")[0] for title in titles if title.startswith("Force in")]
    assert shown == [f"Force in {name}" for name in texts.shipped("zxn2_3000b").bearings_as_drawn]
    assert on_paper.evaluate("getComputedStyle(document.body).color") == "rgb(29, 39, 48)"  # of the light theme
    for control in ("#toolbar", "#play", "#slider", "#rate", ".choice", ".modebar-container", "canvas"):
        assert not on_paper.locator(control).first.is_visible(), control
    colours = on_paper.evaluate(
        """async () => {
            const image = element("snapshot"), pen = new OffscreenCanvas(image.naturalWidth, image.naturalHeight).getContext("2d");
            await image.decode();
            pen.drawImage(image, 0, 0);
            const words = new Uint32Array(pen.getImageData(0, 0, image.naturalWidth, image.naturalHeight).data.buffer);
            return [image.naturalWidth / image.clientWidth, new Set(words).size];
        }"""
    )
    assert colours[0] == pytest.approx(3, abs=0.01)
    assert colours[1] > 500  # the press, not a blank canvas


@pytest.mark.exhaustive
def test_a_pdf_has_the_pages_that_its_charts_fill(small_report: Path, tmp_path: Path) -> None:
    if importlib.util.find_spec("playwright") is None:
        pytest.skip("needs playwright")
    content = pdf(small_report, tmp_path / "report.pdf", time=0.2).read_bytes()
    assert b"Date" not in content  # the same page gives the same bytes
    assert content.startswith(b"%PDF")
    assert 6 <= len(re.findall(rb"/Type\s*/Page\b", content)) <= 12
    assert re.search(rb"/Subtype\s*/Image\s*/Width 2034", content)  # the press, three times 678 pixels
    assert re.search(rb"/MediaBox \[0 0 59[45][.\d]* 84[12]", content)


@pytest.mark.exhaustive
def test_a_browser_prints_the_whole_report_from_its_command_line(small_report: Path, tmp_path: Path) -> None:
    """`chromium --print-to-pdf` prints when the page has loaded: by then it is unpacked."""
    if (program := shutil.which("chromium")) is None:
        pytest.skip("needs chromium")
    out = tmp_path / "report.pdf"
    command = [program, "--headless", *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", f"--print-to-pdf={out}", small_report.as_uri()]
    subprocess.run(command, check=True, capture_output=True, timeout=200)
    assert 6 <= len(re.findall(rb"/Type\s*/Page\b", out.read_bytes())) <= 12


def test_a_report_is_printed_by_its_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked: list[float] = []

    def printed(time: float) -> bytes:
        asked.append(time)
        return b"%PDF"

    monkeypatch.setattr("pinpress.visual.film.opened", lambda *_: contextlib.nullcontext(Screen(0.5, printed, printed)))
    out = tmp_path / "report.pdf"
    monkeypatch.chdir(tmp_path)
    assert main(["report", "crank_slide", "--speed", "70r/min", "--set", "points=24", "--pdf", str(out)]) == 0
    assert capsys.readouterr().out.endswith(f"\nwrote crank_slide.html and {out}\n")
    assert out.read_bytes() == b"%PDF"
    assert asked == [0.0]
    with pytest.raises(pp.PinpressError, match=r"the recording lasts from 0 to 0.5 s"):
        pdf("page.html", out, time=0.6)
    with pytest.raises(pp.PinpressError, match=r"must end in .pdf"):
        pdf("page.html", tmp_path / "report.png")
