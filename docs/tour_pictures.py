"""The pictures of the tour: what its press does. Its sketch, docs/tour/sketch.svg, is drawn by hand."""

import tempfile
from pathlib import Path

from make import DOCS, write

import pinpress as pp

HERE = DOCS / "tour"
NEAR_BOTTOM = 0.505  # s, at 60 strokes/min, under load
COINING = pp.loads.ForceStroke(heights=[0.002, 0.001, 0.0005, 0.0], forces=[0.0, 0.30e6, 0.70e6, 1.60e6])  # as in the tour


def main(quick: bool = False) -> None:
    """Draw them; ``quick``: without the press in the browser."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        draft = pp.pin_table.draft(table(folder, "650"))
        write(HERE / "drawn_pose.svg", draft.sketch)
        try:
            pp.pin_table.draft(table(folder, "550"))
        except pp.PinTableError as error:
            write(HERE / "does_not_meet.svg", str(error.sketch))
        press = draft.press()
        motion = pp.cycle(press, speed=60 * pp.RPM, points=720)
        loaded = pp.inverse_dynamics(press, motion, loads=[COINING])
        write(HERE / "slide.svg", pp.plots.draw(motion, "position", "velocity", "acceleration"))
        write(HERE / "bearings.svg", pp.plots.draw(loaded, "bearings"))
        if not quick:
            page = pp.record(press, motion, folder / "knuckle.html", reactions=loaded, traces=[("lower", (0.0, 0.0, 0.0))])
            picture = pp.video.image(page, folder / "knuckle.png", time=NEAR_BOTTOM, size=(900, 720))
            write(HERE / "knuckle.png", picture.read_bytes())


def table(folder: Path, coupler: str) -> Path:
    """The tour's pin table with a coupler of this length [mm], in a file."""
    text = (DOCS / "tour.md").read_text(encoding="utf-8")
    shown = text.partition('```yaml title="knuckle.yaml"\n')[2].partition("```")[0]
    path = folder / "knuckle.yaml"
    path.write_text(shown.replace("P: 650", f"P: {coupler}"), encoding="utf-8")
    return path
