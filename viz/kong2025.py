"""Tables 2 and 3 of Kong 2025 beside ours, as the Markdown table in the README.

python viz/kong2025.py
"""

import numpy as np

import pinpress as pp

POINTS = 7200
# maximum and minimum as printed: before, after balancing [N m, N]
PRINTED = {
    "driving torque M_b [N m]": ((20325, -18150), (19819, -17937)),
    "bearing A, x [N]": ((120604, -104518), (119421, -100070)),
    "bearing A, vertical [N]": ((52375, -79419), (50688, -75741)),
}


def ours() -> dict[str, tuple[tuple[int, int], tuple[int, int]]]:
    """The same rows from the URDF files, with the paper's signs: torque and force of the crank on the motor and on the frame."""
    curves = []
    for name in ("zxn2_3000b", "zxn2_3000b_balanced"):
        press = pp.load(name)
        result = pp.inverse_dynamics(press, pp.cycle(press, speed=70 * pp.RPM, points=POINTS))
        on_frame = -result.bearing_force["A"]
        curves.append((-result.driving_torque, on_frame[:, 0], on_frame[:, 2]))
    extremes = [[(round(curve.max()), round(curve.min())) for curve in curves_of_press] for curves_of_press in curves]
    return {row: (before, after) for row, before, after in zip(PRINTED, *extremes, strict=True)}


def table() -> str:
    """Markdown, one row a quantity and source."""
    lines = ["| | | before, max / min | after, max / min | range changes by |", "|---|---|---|---|---|"]
    calculated = ours()
    for row, printed in PRINTED.items():
        for source, (before, after) in (("Kong 2025", printed), ("pinpress", calculated[row])):
            change = 100 * (np.ptp(after) / np.ptp(before) - 1)
            lines.append(f"| {row} | {source} | {before[0]} / {before[1]} | {after[0]} / {after[1]} | {change:.2f} % |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
