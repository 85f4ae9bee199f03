"""Texts of pages stand out in both themes, the colour-blind tell curves apart; keys, screen readers and phones get along with a page."""

import itertools
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pinpress as pp
from pinpress.plots import style
from pinpress.visual.shapes.stand_ins import COLOURS, FRAME, STEEL

TEMPLATES = Path(pp.__file__).parent / "visual" / "templates"
SPEED = 70 * pp.RPM
# Machado, Oliveira and Fernandes 2009, "A physiologically-based model for simulation of color vision deficiency", severity 1, of linear RGB
SEEN_BY = {
    "all cones": np.eye(3),
    "no L": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "no M": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "no S": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
TEXTS = [  # colour of a text, what it stands on, and what may lie under that where it is translucent
    *(("ink", on, under) for on in ("surface", "ground", "button", "warning", "veil", "label") for under in ("#000000", "#ffffff")),
    *(("soft", on, "sky") for on in ("surface", "ground", "sky", "floor", "veil")),
    *(("faint", on, "sky") for on in ("surface", "ground", "button", "veil")),
    ("note", "ground", "sky"),
    ("note", "surface", "sky"),
]


def themes() -> dict[str, dict[str, str]]:
    light, dark = (dict(re.findall(r"--([\w-]+): (#\w+);", part)) for part in (TEMPLATES / "theme.css").read_text("utf-8").split("@media"))
    return {"light": light, "dark": dark}


def curves() -> dict[str, list[str]]:
    """Colours of curves; those of the dark theme take the place of the light ones."""
    found = re.search(r"const COLOURS = \[(.*?)\]", (TEMPLATES / "report.js").read_text("utf-8"))
    assert found is not None
    light = re.findall(r"#\w{6}", found[1])
    css = (TEMPLATES / "report.css").read_text("utf-8")
    dark = {tuple(map(int, rgb)): to for *rgb, to in re.findall(r'"rgb\((\d+), (\d+), (\d+)\)"\] \{ --curve: (#\w+)', css)}
    dark[0, 0, 0] = themes()["dark"]["ink"]  # which all others have too
    return {"light": light, "dark": [dark[parsed(colour)] for colour in light]}


def parsed(colour: str) -> tuple[int, ...]:
    return tuple(int(colour[i : i + 2], 16) for i in range(1, len(colour), 2))


def linear(colour: str, under: str = "#000000") -> Any:
    """Linear RGB of a colour, over another one where it is translucent."""
    values, alpha = np.array(parsed(colour)[:3]) / 255, (*parsed(colour), 255)[3] / 255
    values = alpha * values + (1 - alpha) * np.array(parsed(under)[:3]) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def contrast(text: Any, ground: Any) -> float:
    """By WCAG 2.2, from linear RGB."""
    darker, lighter = sorted(np.array([0.2126, 0.7152, 0.0722]) @ colour for colour in (text, ground))
    return float((lighter + 0.05) / (darker + 0.05))


def lab(rgb: Any) -> Any:
    """CIE L*a*b* of linear RGB, for daylight D65."""
    xyz = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]) @ np.clip(
        rgb, 0, 1
    )
    f = np.cbrt(xyz / [0.95047, 1.0, 1.08883])
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_texts_stand_out(theme: str) -> None:
    colours = themes()[theme]
    for text, on, under in TEXTS:
        ground = linear(colours[on], colours.get(under, under))
        assert contrast(linear(colours[text]), ground) >= 4.5, (text, on, under)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_curves_are_told_apart_by_everyone(theme: str) -> None:
    """A distance of 2 is just seen where two colours lie side by side; of the thirteen colours that pages had, two were 3.5 apart."""
    for eyes in SEEN_BY.values():
        seen = [lab(np.array(eyes) @ linear(colour)) for colour in curves()[theme]]
        assert min(np.linalg.norm(one - other) for one, other in itertools.combinations(seen, 2)) > 15
    surface = linear(themes()[theme]["surface"])
    assert all(contrast(linear(colour), surface) > {"light": 2.2, "dark": 4.0}[theme] for colour in curves()[theme])


def test_links_are_told_apart_by_everyone() -> None:
    """Before, the coupler and the slide of the six-bar were 9 apart without L cones, two stand-ins 7 without S cones."""
    palettes = {"stand-ins": [*COLOURS, FRAME, STEEL]}
    for path in sorted((Path(pp.__file__).parents[1] / "urdf").glob("*.urdf")):
        written = re.findall(r'<material name="\w+"><color rgba="(\S+) (\S+) (\S+) 1"/>', path.read_text("utf-8"))
        palettes[path.stem] = [tuple(map(float, rgb)) for rgb in written]
    assert all(len(palette) >= 5 for palette in palettes.values())
    for name, palette in palettes.items():
        colours = ["#" + "".join(f"{round(255 * value):02x}" for value in rgb) for rgb in palette]
        for eyes in SEEN_BY.values():
            seen = [lab(np.array(eyes) @ linear(colour)) for colour in colours]
            least = min(float(np.linalg.norm(one - other)) for one, other in itertools.combinations(seen, 2))
            assert least > (19 if name == "stand-ins" else 14), name


def test_paper_and_page_agree() -> None:
    assert [colour.lower() for colour in style.COLOURS] == curves()["light"]


@pytest.mark.exhaustive
def test_a_page_turns_dark_with_the_system(small_report: Path, shared_view: Callable[..., Any]) -> None:
    page = shared_view(small_report, (1000, 500))
    ask = """() => ['body', '.chart', '.plot .js-line', '.plot .xtick text', '.legend i'].map(what => {
        const look = getComputedStyle(document.querySelector(what));
        return [look.backgroundColor, look.color, look.stroke, look.fill];
    })"""
    light, dark = (page.emulate_media(color_scheme=scheme) or page.evaluate(ask) for scheme in ("light", "dark"))
    colours = {name: [tuple(parsed(theme[key])) for key in ("ground", "surface", "soft")] for name, theme in themes().items()}
    for name, (body, chart, line, tick, swatch) in {"light": light, "dark": dark}.items():
        first = parsed(curves()[name][0])
        read = [tuple(map(int, re.findall(r"\d+", words))) for words in (body[0], chart[0], line[2], tick[3], swatch[0])]
        assert [read[0], read[1], read[2], read[4]] == [colours[name][0], colours[name][1], first, first]
        assert read[3] == colours[name][2]
    page.emulate_media(color_scheme="light")


@pytest.mark.exhaustive
def test_keys_and_names(small_report: Path, view: Callable[..., Any]) -> None:
    page = view(small_report, "#t=0", (1000, 500))
    reached = []
    for _ in range(7):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.id"))
        assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    assert reached == ["show-forces", "show-names", "show-paths", "front-view", "play", "slider", "rate"]
    times = page.evaluate("data.time")
    for focus in ("document.body", "element('slider')"):
        page.evaluate(f"seek(0); document.activeElement.blur(); {focus}.focus()")
        for keys, step in (("ArrowRight", 1), ("ArrowRight", 2), ("Shift+ArrowRight", 12), ("ArrowLeft", 11), ("Shift+ArrowRight", 21)):
            page.keyboard.press(keys)
            assert page.evaluate("now") == times[step]
        page.keyboard.press("Shift+ArrowRight")
        assert page.evaluate("now") == times[-1]  # no further
    assert page.get_attribute("#slider", "aria-valuetext").endswith("mm")
    page.keyboard.press("Space")
    assert page.evaluate("playing && element('play').ariaLabel") == "Pause"
    page.keyboard.press("Space")
    assert page.evaluate("!playing && element('play').ariaLabel") == "Play"
    unnamed = page.evaluate(
        """[...document.querySelectorAll('button, input, select, figure, [role]')].filter(each =>
            each.checkVisibility() && !each.closest('.modebar') && !(each.ariaLabel || each.title || each.textContent.trim())).length"""
    )
    assert unnamed == 0


@pytest.mark.exhaustive
@pytest.mark.parametrize("size", [(390, 844), (667, 375), (320, 640)])
def test_nothing_is_buried_on_a_phone(size: tuple[int, int], small_report: Path, shared_view: Callable[..., Any]) -> None:
    page = shared_view(small_report, size)
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.wait_for_timeout(300)  # until the charts have their width
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    view_box, header, footer = page.evaluate(
        "['#view', 'header', 'footer'].map(what => document.querySelector(what).getBoundingClientRect().toJSON())"
    )
    assert header["bottom"] <= view_box["top"] + 0.5
    assert view_box["bottom"] <= footer["top"] + 0.5
    assert view_box["height"] > 0.25 * size[1]
    assert footer["bottom"] <= size[1]
