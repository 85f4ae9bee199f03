"""Record every shipped press with its forces into viz/out/, each at its nominal speed, with a report, and take the README's pictures.

python viz/record_presses.py
"""

from pathlib import Path

from light import light  # type: ignore[import-not-found]  # beside this script

import pinpress as pp

HERE = Path(__file__).parent
STROKES_A_MINUTE = {"thin_wall": 72, "zxn2_3000b": 70, "zxn2_3000b_balanced": 70, "crank_slide": 70}
OTHERS = 300  # those of Zhang 2007
TRACES = {"zxn2_3000b": [("coupler", (0.6, 0.0, 0.1))], "thin_wall": [("bar", (0.648, 0.0, 0.0))]}
PICTURES = {"zxn2_3000b": 0.2, "jf75g_125_symmetric": 0.06, "thin_wall": 0.3}  # when [s]
SIZE = (1200, 960)  # pixels


def main() -> None:
    out = HERE / "out"
    out.mkdir(exist_ok=True)
    for name in pp.presses():
        speed = STROKES_A_MINUTE.get(name, OTHERS) * pp.RPM
        press = pp.load(name)
        result = pp.inverse_dynamics(press, pp.cycle(press, speed=speed))
        page = pp.record(press, result.motion, out / f"{name}.html", reactions=result, traces=TRACES.get(name, ()))
        print(page, pp.report(press, result.motion, out / f"{name}_report.html", reactions=result, traces=TRACES.get(name, ())))
        if name in PICTURES:
            print(light(pp.video.image(page, HERE / f"{name}.png", time=PICTURES[name], size=SIZE)))


if __name__ == "__main__":
    main()
