"""Record every shipped press with its forces into viz/out/, each at its nominal speed, with a report, and take the README's pictures.

python viz/record_presses.py
"""

from pathlib import Path

from light import light  # type: ignore[import-not-found]  # beside this script

import pinpress as pp

HERE = Path(__file__).parent
STROKES_A_MINUTE = {"jf75g": 300, "thin_wall": 72, "zxn2": 70, "crank_slide": 70}  # by the first letters of a press's name
TRACES = {"zxn2_3000b": [("coupler", (0.6, 0.0, 0.1))], "thin_wall": [("bar", (0.648, 0.0, 0.0))]}
PICTURES = {"zxn2_3000b": 0.2, "jf75g_125_symmetric": 0.06, "thin_wall": 0.3}  # when [s]
SIZE = (1200, 960)  # pixels


def main() -> None:
    out = HERE / "out"
    out.mkdir(exist_ok=True)
    for name in pp.presses():
        speed = next(rate for start, rate in STROKES_A_MINUTE.items() if name.startswith(start)) * pp.RPM
        press = pp.load(name)
        result = pp.inverse_dynamics(press, pp.cycle(press, speed=speed))
        page = pp.record(press, result.motion, out / f"{name}.html", reactions=result, traces=TRACES.get(name, ()))
        print(page, pp.report(press, result.motion, out / f"{name}_report.html", reactions=result, traces=TRACES.get(name, ())))
        if name in PICTURES:
            print(light(pp.video.image(page, HERE / f"{name}.png", time=PICTURES[name], size=SIZE)))


if __name__ == "__main__":
    main()
