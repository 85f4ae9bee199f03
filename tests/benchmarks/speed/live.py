"""How often the live window shows another press while a slider is dragged, in a browser without a window and without a graphics card; and
what a picture costs the processor in the server.

python tests/benchmarks/speed/live.py

All sliders are moved in turn, each to another value at every picture. A machine that does much else shows fewer: the load is printed too.
"""

import json
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks import stopwatch
from support.in_browser import FLAGS

import pinpress as pp
from pinpress.live.pictures import Operation
from pinpress.live.session import Opened, Session
from pinpress.live.sources import opened

TEMPLATES = Path(pp.__file__).parent / "pin_table" / "templates"
SHOWN = ["zxn2_3000b", "jf75g_125", *(str(TEMPLATES / f"{name}.yaml") for name in ("knuckle", "link-drive", "drawing-8-bar", "rssp"))]
SPEED = 0.5  # [rad/s]
SECONDS = 5.0  # of dragging
PICTURES = 40  # whose time in the server is measured
DRAG = """async seconds => {
    setPlaying(false);
    const first = pictures, began = performance.now();
    for (let k = 0; performance.now() - began < 1000 * seconds; k++) {
        const row = rows[k % rows.length], each = data.dimensions[row.index];
        change(row, each.value + each.step * Math.round(3 * Math.sin(k / 5)), false);
        await new Promise(done => setTimeout(done, 4));
    }
    return (pictures - first) / (performance.now() - began) * 1000;
}"""


QUICK = {"SHOWN": ["zxn2_3000b"], "SECONDS": 0.2, "PICTURES": 2}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        print("| press | sliders | states | server, processor time of a picture | pictures a second | load of the machine |")
        print("|---|---|---|---|---|---|")
        for name in SHOWN:
            session = Session(lambda name=name: Opened(opened(name, pp.load, {}), Operation(SPEED, [], {}, {})))
            session.open()
            whole = session.whole()
            spent = processor_time(changing(session, whole))
            with pp.view(name, SPEED, browser=False) as shown:
                page.goto(shown.url)
                page.wait_for_timeout(2000)
                shown_a_second = page.evaluate(DRAG, SECONDS)
            each = (
                f"{len(whole['dimensions'])} | {whole['points']} | {1e3 * spent:.0f} ms | {shown_a_second:.0f} | {os.getloadavg()[0]:.1f}"
            )
            print(f"| {Path(name).stem} | {each} of {os.cpu_count()} |")
        chromium.close()


def changing(session: Session, whole: dict[str, Any]) -> Callable[[int], None]:
    """What moves one slider after the other a little."""

    def change(k: int) -> None:
        values = list(whole["values"])
        place = k % len(values)
        values[place] += whole["dimensions"][place]["step"] * (1 + k % 3)
        session.answer(json.dumps({"type": "set", "values": values, "speed": whole["speed"], "shapes": False}))

    return change


def processor_time(change: Callable[[int], None]) -> float:
    """Of one picture [s]."""
    change(0)

    def pictures() -> None:
        for k in range(PICTURES):
            change(k)

    return stopwatch.once(pictures)[1] / PICTURES


if __name__ == "__main__":
    main()
