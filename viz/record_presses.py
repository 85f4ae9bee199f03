"""Record every shipped press into viz/out/, each at its nominal speed, and take the README's pictures through Chromium.

python viz/record_presses.py
"""

import os
import shutil
from pathlib import Path

import pinpress as pp

HERE = Path(__file__).parent
STROKES_A_MINUTE = {"jf75g": 300, "thin_wall": 72, "zxn2": 70, "crank_slide": 70}  # by the first letters of a press's name
PICTURES = {"zxn2_3000b": 0.2, "jf75g_125_symmetric": 0.06, "thin_wall": 0.3}  # when [s]
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", "--hide-scrollbars"]


def main() -> None:
    out = HERE / "out"
    out.mkdir(exist_ok=True)
    for name in pp.presses():
        press = pp.load(name)
        speed = next(rate for start, rate in STROKES_A_MINUTE.items() if name.startswith(start)) * pp.RPM
        print(pp.record(press, pp.cycle(press, speed=speed), out / f"{name}.html"))
    for name, time in PICTURES.items():
        picture(out / f"{name}.html", time, HERE / f"{name}.png")


def picture(page: Path, time: float, target: Path) -> None:
    """What the page shows at a time [s]."""
    from playwright.sync_api import sync_playwright

    executable = os.environ.get("CHROMIUM") or shutil.which("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=FLAGS)
        tab = browser.new_page(viewport={"width": 900, "height": 700})
        tab.goto(f"{page.resolve().as_uri()}#t={time}")
        tab.evaluate("viewer.render()")
        tab.screenshot(path=target)
        browser.close()
    print(target)


if __name__ == "__main__":
    main()
