"""Record every shipped press into viz/out/, and take the README's picture of the ZXN2-3000(B) through Chromium.

python viz/record_presses.py
"""

import os
import shutil
from pathlib import Path

import pinpress as pp

HERE = Path(__file__).parent
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", "--hide-scrollbars"]


def main() -> None:
    out = HERE / "out"
    out.mkdir(exist_ok=True)
    for name in pp.presses():
        press = pp.load(name)
        print(pp.record(press, pp.cycle(press, speed=70 * pp.RPM), out / f"{name}.html"))
    picture(out / "zxn2_3000b.html", 0.2, HERE / "zxn2_3000b.png")


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
