"""Recordings and reports of every shipped press, the ZXN2-3000(B) before and after balancing, and the README's pictures of them.

Each press runs at its nominal speed. Recordings and reports go into viz/out.
"""

from make import OUT, VIZ, shot, write

import pinpress as pp

STROKES_A_MINUTE = {"thin_wall": 72, "zxn2_3000b": 70, "zxn2_3000b_balanced": 70, "crank_slide": 70}
OTHERS = 300  # those of Zhang 2007
TRACES = {"zxn2_3000b": [("coupler", (0.6, 0.0, 0.1))], "thin_wall": [("bar", (0.648, 0.0, 0.0))]}
PICTURES = {"zxn2_3000b": 0.2, "jf75g_125_symmetric": 0.06, "thin_wall": 0.3}  # when [s]
AT_TOP = "() => { scrollTo(0, 0); viewer.render(); }"


def main(quick: bool = False) -> None:
    """Write them; ``quick``: of one press."""
    out = OUT[0] if OUT else VIZ / "out"
    out.mkdir(parents=True, exist_ok=True)
    for name in ["thin_wall"] if quick else pp.presses():
        press = pp.load(name)
        result = pp.inverse_dynamics(press, pp.cycle(press, STROKES_A_MINUTE.get(name, OTHERS) * pp.RPM))
        shown = {"reactions": result, "traces": TRACES.get(name, ())}
        page = pp.record(press, result.motion, out / f"{name}.html", **shown)
        print(page, pp.report(press, result.motion, out / f"{name}_report.html", **shown))
        if name in PICTURES:
            picture = pp.video.image(page, out / f"{name}.png", time=PICTURES[name], size=(1200, 960))
            write(VIZ / f"{name}.png", picture.read_bytes())
    balanced = pp.load("zxn2_3000b_balanced")
    presses = pp.load("zxn2_3000b"), balanced
    before, after = (pp.inverse_dynamics(press, pp.cycle(press, 70 * pp.RPM, points=720)) for press in presses)
    page = pp.report(balanced, after.motion, out / "before_and_after.html", reactions=after, before=before)
    write(VIZ / "report.png", shot(f"{page.resolve().as_uri()}#t=0.2", ".verdict", AT_TOP, (1500, 940)))
    write(VIZ / "comparison.png", pp.plots.draw(after, "torque", "shaking", "peaks", before=before))
