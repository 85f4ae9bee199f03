"""The ZXN2-3000(B) before and after balancing: a report of both into viz/out/, the README's picture of it, and charts for a paper.

python viz/before_and_after.py
"""

from pathlib import Path

import pinpress as pp

HERE = Path(__file__).parent
SPEED = 70 * pp.RPM


def main() -> None:
    out = HERE / "out"
    out.mkdir(exist_ok=True)
    plain, balanced = pp.load("zxn2_3000b"), pp.load("zxn2_3000b_balanced")
    before, after = (pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=720)) for press in (plain, balanced))
    page = pp.report(balanced, after.motion, out / "before_and_after.html", after, before=before)
    print(page, pp.still(page, HERE / "report.png", 0.2, (1600, 1000)))
    for name, figure in (
        ("comparison", pp.plot_comparison(before, after)),
        ("polar", pp.plot_polar(before)),
        ("slide", pp.plot_slide(before.motion)),
        ("torque", pp.plot_torque(before)),
        ("bearings", pp.plot_bearings(before)),
        ("shaking", pp.plot_shaking(before)),
    ):
        print(*(pp.save_plot(figure, out / f"zxn2_3000b_{name}.{suffix}") for suffix in ("svg", "png")))
    print(pp.save_plot(pp.plot_comparison(before, after), HERE / "comparison.png"))


if __name__ == "__main__":
    main()
