"""The header of a report: what the page says of itself, as data, on the screen and on paper."""

import base64
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support import texts
from support.in_browser import data_in

import pinpress as pp

HOSTILE = '<b>"Press" & \\3</b>'
SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 1"><path d="M0 0h4v1H0z"/></svg>'
TEXTS = {
    "company": "Muster AG",
    "drawing": "4711-03",
    "author": "J. Doe",
    "revision": "B",
    "date": "2026-11-30",
    "notes": "One\n<i>two</i>",
}
ROWS = [["Drawing", "4711-03"], ["Revision", "B"], ["Author", "J. Doe"], ["Date", "2026-11-30"]]


@pytest.fixture(scope="module")
def reactions() -> Any:
    press = texts.shipped("crank_slide")
    return pp.inverse_dynamics(press, pp.cycle(press, speed=5.0, points=24))


def written(reactions: Any, path: Path, **more: Any) -> Path:
    return pp.report(reactions._press, reactions.motion, path, reactions=reactions, **more)


@pytest.fixture(scope="module")
def page(reactions: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("header")
    (folder / "logo.svg").write_text(SVG, encoding="utf-8")
    header = pp.Header(title=HOSTILE, logo=folder / "logo.svg", **TEXTS)
    return written(reactions, folder / "out.html", header=header, inputs=[("read", "press.yaml")])


def test_a_header_is_in_the_page(page: Path) -> None:
    text, data = page.read_text("utf-8"), data_in(page)["report"]
    assert "<title>&lt;b&gt;&quot;Press&quot; &amp; \\3&lt;/b&gt;</title>" in text
    assert HOSTILE not in text
    logo = "data:image/svg+xml;base64," + base64.b64encode(SVG.encode()).decode()
    assert data["header"] == {"logo": logo, "company": "Muster AG", "rows": ROWS, "notes": TEXTS["notes"]}
    *_, row, last = data["inputs"][0]["rows"]
    assert row == ["read", "press.yaml"]
    assert last[0] == "computed by"


def test_a_page_without_a_header_has_the_name_of_the_press(reactions: Any, tmp_path: Path) -> None:
    for header in (None, pp.Header(), pp.Header(title=" ")):
        page = written(reactions, tmp_path / "out.html", header=header)
        assert "<title>crank_slide</title>" in page.read_text("utf-8")
        assert data_in(page)["report"]["header"] is None


def test_a_header_on_the_screen_and_on_paper(page: Path, view: Callable[..., Any]) -> None:
    """The block is at the top, nothing lies on it, and what looks like HTML is text; on paper it has the title."""
    for size in [(1000, 500), (390, 800)]:
        opened = view(page, "#t=0.1", size)
        assert opened.title() == HOSTILE
        for theme in ("light", "dark"):
            opened.emulate_media(color_scheme=theme)
            assert opened.locator("h1").inner_text() == HOSTILE
            head = opened.locator("#head")
            assert head.locator("p").inner_text() == TEXTS["notes"]
            assert opened.evaluate("element('head').querySelector('img').naturalWidth") > 0
            assert [each.inner_text() for each in head.locator("dd").all()] == [words for _, words in ROWS]
            assert opened.evaluate("document.documentElement.scrollWidth") == size[0]
            assert not overlaps(opened)
    opened.evaluate("dispatchEvent(new Event('beforeprint'))")
    opened.emulate_media(media="print")
    assert opened.locator("#head h1").inner_text() == HOSTILE
    assert opened.evaluate("element('head').getBoundingClientRect().bottom <= element('stage').getBoundingClientRect().top")
    assert not overlaps(opened)
    on_sheets = opened.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--title')")
    assert on_sheets.endswith('· Muster AG · Drawing 4711-03 · Revision B · Author J. Doe · Date 2026-11-30"')
    opened.emulate_media(media="screen", color_scheme="light")
    opened.evaluate("dispatchEvent(new Event('afterprint'))")
    assert opened.locator("#stage h1").inner_text() == HOSTILE
    assert opened.evaluate("element('charts').firstElementChild.id") == "head"


def overlaps(opened: Any) -> Any:
    """Parts of the title block that lie on each other."""
    return opened.evaluate(
        """() => {
            const parts = [...document.querySelectorAll("#head > img, #head > strong, #head > h1, #head > p, #head dl > div")];
            const boxes = parts.map(part => part.getBoundingClientRect());
            return boxes.flatMap((a, i) => boxes.slice(i + 1).filter(
                b => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom).map(() => parts[i].outerHTML));
        }"""
    )


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"GIF89a", r"logo\.png, which is no PNG, JPEG or SVG picture; give a PNG, JPEG or SVG file"),
        (b"<svg/>", "no PNG, JPEG or SVG picture"),  # no browser shows it without its namespace
        (b"\x89PNG\r\n\x1a\n" + bytes(1_000_000), r"logo\.png, which cannot be read: larger than 1 MB; give"),
        (None, r"logo\.png, which cannot be read: No such file or directory, did you mean 'logo.svg'\?; give"),
    ],
)
def test_a_wrong_logo_is_refused(content: bytes | None, said: str, tmp_path: Path) -> None:
    (tmp_path / "logo.svg").write_text(SVG, encoding="utf-8")
    if content is not None:
        (tmp_path / "logo.png").write_bytes(content)
    with pytest.raises(pp.PinpressError, match=said):
        pp.Header(logo=tmp_path / "logo.png")


def test_the_kind_of_a_logo_is_that_of_its_content(tmp_path: Path) -> None:
    for content, kind in ((b"\x89PNG\r\n\x1a\n..", "png"), (b"\xff\xd8\xff..", "jpeg")):
        (tmp_path / "logo").write_bytes(content)
        assert str(pp.Header(logo=tmp_path / "logo").picture).startswith(f"data:image/{kind};base64,")


def test_what_is_no_text_is_refused(reactions: Any, tmp_path: Path) -> None:
    for call, said in (
        (lambda: pp.Header(drawing=4711), r'drawing is 4711: give a text, such as drawing="..."'),
        (lambda: pp.Header(title="\ud800"), r"title has the character U\+D800"),
        (lambda: pp.Header(logo=5), "logo is 5: give the path of a file"),
        (lambda: written(reactions, tmp_path / "out.html", header="Press 3"), "header is a str, no Header: give"),
        (lambda: written(reactions, tmp_path / "out.html", inputs=[("a", 5)]), r"inputs has \('a', 5\): give pairs of texts"),
    ):
        with pytest.raises(pp.PinpressError, match=said):
            call()


def test_dashed_curves_have_a_name(reactions: Any, tmp_path: Path) -> None:
    page = written(reactions, tmp_path / "out.html", before=reactions, before_name="variant A", before_inputs=[("changed", "r: 1 -> 2")])
    data = data_in(page)["report"]
    assert data["subtitle"].endswith("; dashed: variant A, crank at 47.7465 r/min")
    assert ["changed", "r: 1 -> 2"] in data["inputs"][1]["rows"]
    assert "dashed: crank_slide, crank" in data_in(written(reactions, page, before=reactions))["report"]["subtitle"]
