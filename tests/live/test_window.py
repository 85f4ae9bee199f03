"""The window in a real browser: sliders, curves, reasons, files; at no time a script or a request that is not its own."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support import texts
from support.generators.hostile import load_hostile
from support.in_browser import NO_WEBGL, wait
from support.presses.two_servos import TWO_SERVOS

import pinpress as pp

KNUCKLE = Path(pp.__file__).parent / "pin_table" / "templates" / "knuckle.yaml"


class Window:
    """A page of a `LiveView`, and what went wrong in it."""

    def __init__(self, browser: Any, url: str, size: tuple[int, int]) -> None:
        self.problems: list[str] = []
        self.context = browser.new_context(viewport={"width": size[0], "height": size[1]})
        self.page = self.context.new_page()
        self.page.on("console", self._said)
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on(
            "request", lambda request: None if request.url.startswith((url, "data:", "blob:")) else self.problems.append(request.url)
        )
        self.page.goto(url)
        wait(self.page, "document.readyState === 'complete' && typeof socket !== 'undefined' && socket.readyState === 1")

    def _said(self, message: Any) -> None:
        if message.type in ("error", "warning") and "GPU stall" not in message.text:
            self.problems.append(message.text)

    def change(self, name: str, value: float) -> None:
        """Move a slider and let it go; wait for the answer."""
        self.page.evaluate(
            """([name, value]) => {
                setPlaying(false);
                const row = rows[data.dimensions.findIndex(each => each.name === name)];
                row.range.value = value;
                row.range.dispatchEvent(new Event("input"));
                row.range.dispatchEvent(new Event("change"));
            }""",
            [name, value],
        )
        wait(self.page, "!waiting && !wanted")


@pytest.fixture
def open_window(browser: Any) -> Iterator[Any]:
    found: list[Window] = []

    def opened(shown: Any, size: tuple[int, int] = (640, 400)) -> Window:
        found.append(Window(browser, shown.url, size))
        return found[-1]

    yield opened
    for window in found:
        window.context.close()
        assert window.problems == []


@pytest.mark.exhaustive
def test_a_slider_changes_the_press(open_window: Any) -> None:
    with pp.view(texts.shipped("crank_slide"), 60 * pp.RPM, browser=False) as shown:
        window = open_window(shown)
        page = window.page
        window.change("O to P", 120.0)
        assert page.evaluate("data.values[0]") == 120.0
        assert page.evaluate("charts[0].range.textContent") == "stroke 240 mm"
        # links, arrows and labels are where the mechanics has them
        pivots = {("P", "crank"): 1.2 * pp.derivatives.pivot_positions(texts.shipped("crank_slide"))["P", "crank"]}
        press = pp.derivatives.reshaped(texts.shipped("crank_slide"), pivots)
        page.evaluate("seek(duration / 4)")
        motion = pp.cycle(press, 60 * pp.RPM, points=4)
        name = page.evaluate("data.legend.map(each => each.name).indexOf('slide')")
        assert name >= 0
        pin = page.evaluate("places[data.bearings.find(each => each.name === 'W').place].slice(3 * 45, 3 * 46)")
        assert_allclose(list(pin.values()) if isinstance(pin, dict) else pin, [0, 0, motion.slide_position[1]], atol=1e-6)
        # keys belong to fields and sliders where these have the focus
        page.focus("#name")
        page.keyboard.type(" x")
        assert page.evaluate("[element('name').value, playing]") == ["crank_slide_changed.urdf x", False]
        page.evaluate("rows[0].range.focus()")
        page.keyboard.press("Shift+ArrowRight")
        wait(page, "!waiting && !wanted")
        assert page.evaluate("data.values[0]") == 121.0
        window.change("O to P", 120.0)
        # what makes no press is said beside the slider, and the last good one comes back
        page.evaluate("(() => { rows[0].field.value = 500; rows[0].field.dispatchEvent(new Event('change')); })()")
        wait(page, "!waiting && rows[0].error.textContent !== ''")
        assert "crank angle" in page.evaluate("rows[0].error.textContent")
        assert page.evaluate("[rows[0].range.value, data.values[0]]") == ["120", 120]


@pytest.mark.exhaustive
def test_the_window_follows_its_file(open_window: Any, tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    shutil.copy(KNUCKLE, path)
    text = path.read_text()
    with pp.view(path, 0.5, watch=True, browser=False) as shown:
        page = open_window(shown).page
        path.write_text(text.replace("drive: O", "drive: <b>Q</b>"))
        wait(page, "!element('broken').hidden")
        assert "<b>Q</b>" in page.evaluate("element('broken').textContent")
        assert page.evaluate("element('broken').children.length") == 0
        path.write_text(text.replace("r: 90", "r: 100").replace("K: {U: upper", "N: [10, 20]\n  K: {U: upper"))
        wait(page, "element('broken').hidden")
        assert page.evaluate("data.dimensions.some(each => each.name === 'N x')")
        page.evaluate("(() => { element('name').value = 'saved.yaml'; element('saving').requestSubmit(); })()")
        wait(page, "element('saved').textContent !== ''")
        assert "r: 100" in (tmp_path / "saved.yaml").read_text()


@pytest.mark.exhaustive
def test_a_window_without_webgl_has_its_curves(browser: Any) -> None:
    """They follow the sliders; where the press would move the window says why it does not."""
    with pp.view(texts.shipped("crank_slide"), 5.0, browser=False) as shown, browser.new_context() as fresh:
        page, wrong = fresh.new_page(), list[str]()
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.add_init_script(NO_WEBGL)
        page.goto(shown.url)
        page.wait_for_selector("#dimensions .row", timeout=20000)
        assert page.inner_text("#view .message").startswith("This browser cannot draw the moving press")
        assert page.inner_text("#curves small >> nth=0") == "stroke 200 mm"
        page.evaluate("change(rows[data.dimensions.findIndex(each => each.name === 'O to P')], 90, true)")
        wait(page, "document.querySelector('#curves small').textContent === 'stroke 180 mm'")  # and not the longer one that is dashed
        assert wrong == []


def test_a_file_that_is_wrong_at_first(open_window: Any, tmp_path: Path, browser: Any) -> None:
    path = tmp_path / "own.yaml"
    path.write_text(KNUCKLE.read_text().replace("drive: O", "drive: Q"))
    with pp.view(path, 0.5, watch=True, browser=False) as shown:
        assert "Q" in (shown.broken or "")
        page = browser.new_context(viewport={"width": 640, "height": 400}).new_page()
        page.goto(shown.url)
        assert "Q" in page.inner_text("#broken")
        shutil.copy(KNUCKLE, path)
        page.wait_for_selector("#dimensions .row", timeout=20000)
        page.context.close()


@pytest.mark.exhaustive
def test_hostile_names_stay_text(open_window: Any, tmp_path: Path) -> None:
    press = load_hostile(tmp_path)
    with pp.view(press, 1.0, browser=False) as shown:
        page = open_window(shown).page
        assert page.evaluate("document.querySelectorAll('#panel script, #panel img, #panel b b, header script, header img').length") == 0
        said = page.evaluate("element('dimensions').textContent")
        assert all(link in said for (link,) in [(press.links[1],)])


@pytest.mark.exhaustive
@pytest.mark.parametrize("table", ["rssp", "toggle", "eccentric-block"])
def test_other_presses(table: str, open_window: Any) -> None:
    """In space, with a cylinder that drives, with gears: all dimensions are moved, and the curves follow."""
    with pp.view(KNUCKLE.with_name(f"{table}.yaml"), browser=False) as shown:
        window = open_window(shown)
        for i, each in enumerate(window.page.evaluate("data.dimensions")):
            window.change(each["name"], each["value"] + 2 * each["step"])
            now = window.page.evaluate("[data.values, rows.map(row => row.error.textContent)]")
            assert now[0][i] != each["value"] or now[1][i] != ""
        assert np.isfinite(window.page.evaluate("charts.map(chart => chart.high)")).all()


@pytest.mark.exhaustive
def test_another_driver_is_chosen(open_window: Any, tmp_path: Path) -> None:
    path = tmp_path / "two_servos.yaml"
    path.write_text(TWO_SERVOS)
    with pp.view(path, browser=False) as shown:
        page = open_window(shown).page
        assert page.evaluate("[rows[0].box.hidden, rows[1].box.hidden, charts.length]") == [True, False, 4]
        page.select_option("#moving", "B")
        wait(page, "!waiting && data.moving === 'B'")
        assert page.evaluate("[rows[0].box.hidden, rows[1].box.hidden, charts[2].title.textContent]") == [
            False,
            True,
            "torque that holds A",
        ]
