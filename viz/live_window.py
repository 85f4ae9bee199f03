"""Makes the picture of docs/live.md: the window of `pinpress view`, in which a crank has been made longer.

    python viz/live_window.py

It needs Chromium and pip install 'pinpress[view,video]'.
"""

import shutil
from pathlib import Path

from light import light  # type: ignore[import-not-found]  # beside this script
from playwright.sync_api import sync_playwright

import pinpress as pp

PICTURE = Path(__file__).parent / "live_window.png"
LOAD = pp.loads.DeepDrawing(force=1.5e6, start=0.040)
SLIDER, LENGTH = "A to B", 165.0  # [mm]
BY_THE_PROCESSOR = ["--use-gl=angle", "--use-angle=swiftshader-webgl", "--enable-unsafe-swiftshader", "--no-sandbox"]
MOVE = """([name, value]) => {
    setPlaying(false);
    seek(0.8 * duration);
    change(rows[data.dimensions.findIndex(each => each.name === name)], value, true);
}"""


def main() -> None:
    with pp.view("zxn2_3000b", 70 * pp.RPM, loads=[LOAD], browser=False) as window, sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=BY_THE_PROCESSOR)
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        page.goto(window.url)
        page.wait_for_selector(".row")
        page.wait_for_timeout(1000)
        page.evaluate(MOVE, [SLIDER, LENGTH])
        page.wait_for_timeout(2000)
        page.screenshot(path=PICTURE)
        chromium.close()
    light(PICTURE)


if __name__ == "__main__":
    main()
