"""Which dimension decides how exact bottom dead centre is?

A hundred thousand presses are drawn with tolerances on their lengths, and every one is closed. Their bottom dead
centres scatter, and two dimensions make nearly all of it: those deserve the better machine tool.
"""

import numpy as np

import pinpress as pp
from pinpress import tolerances as tol

press = pp.load("zxn2_3000b")
parts = [
    *(tol.link_length(press, *pins, 50e-6) for pins in ("AB", "DC", "DE", "EF")),  # +/- 0.05 mm
    tol.link_length(press, "B", "C", 100e-6),
    tol.pin_angle(press, "C", "D", "E", np.radians(0.01)),
    *(tol.pin_position(press, "A", axis, 100e-6) for axis in ("x", "z")),
]
found = tol.bottom_dead_centre(press, parts)
print(f"standard deviation {1e6 * found.height.sd:.1f} um; {100 * found.within(50e-6):.1f} % of the presses within 0.05 mm")
for k in np.argsort(-found.height.share)[:3]:
    print(f"{found.height.parts[k].name}: {100 * found.height.share[k]:.0f} %")

figure = pp.plots.draw(found.height.with_limit(50e-6))
