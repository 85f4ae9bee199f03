"""The ZXN2-3000(B) before and after balancing: a report of both into viz/out/, the README's picture of it, and charts for a paper.

python viz/before_and_after.py
"""

import os
import shutil
from pathlib import Path

from light import light  # type: ignore[import-not-found]  # beside this script

import pinpress as pp

HERE = Path(__file__).parent
SPEED = 70 * pp.RPM
DRAWN = ["--use-gl=angle", "--use-angle=swiftshader-webgl", "--enable-unsafe-swiftshader"]  # by the processor
FLAGS = [*DRAWN, "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"]


def main() -> None:
    out = HERE / "out"
    out.mkdir(exist_ok=True)
    plain, balanced = pp.load("zxn2_3000b"), pp.load("zxn2_3000b_balanced")
    before, after = (pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=720)) for press in (plain, balanced))
    page = pp.report(balanced, after.motion, out / "before_and_after.html", reactions=after, before=before)
    print(page, light(picture(page, HERE / "report.png")))
    for name, figure in (
        ("comparison", pp.plots.draw(after, "torque", "shaking", "peaks", before=before)),
        ("polar", pp.plots.draw(before, "polar")),
        ("slide", pp.plots.draw(before, "height", "velocity", "acceleration")),
        ("torque", pp.plots.draw(before, "torque")),
        ("bearings", pp.plots.draw(before, "bearings")),
        ("shaking", pp.plots.draw(before, "shaking", "harmonics")),
    ):
        print(*(pp.plots.save(figure, out / f"zxn2_3000b_{name}.{suffix}") for suffix in ("svg", "png")))
    print(light(pp.plots.save(pp.plots.draw(after, "torque", "shaking", "peaks", before=before), HERE / "comparison.png")))


def picture(page: Path, target: Path) -> Path:
    """A report in a window as wide as a desk's screen, scrolled to the bearings. (`pp.video.image` pictures the press.)"""
    from playwright.sync_api import sync_playwright

    executable = os.environ.get("CHROMIUM") or shutil.which("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=FLAGS)
        tab = browser.new_page(viewport={"width": 1500, "height": 940})
        tab.goto(f"{page.resolve().as_uri()}#t=0.2")
        tab.select_option("#bearing", label="D")
        tab.evaluate("document.querySelectorAll('h2')[1].scrollIntoView(); viewer.render()")
        tab.wait_for_timeout(300)
        tab.screenshot(path=target)
        browser.close()
    return target


if __name__ == "__main__":
    main()
