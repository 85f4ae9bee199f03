"""Which lengths draw at an even speed?

The guide-bar press for thin-walled parts draws over 120 mm. The length of its coupler and the height of its slide are
free; the pressure angle may be at most 40 degrees. Synthesis finds the lengths at which the speed of the slide changes
least over the draw.
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

drawn, speed = 0.120, 7.54  # m, rad/s
press = pp.load("thin_wall")


def pressure_angle(trial):
    return pp.measures.pressure_angle(trial.motion, trial.positions["E"], trial.positions["D"], (1.0, 0.0, 0.0))


found = pp.synthesis.synthesise(
    press,
    {"l4": (0.050, 0.220, 0.600), "h": (0.600, 0.630, 0.700)},  # m: least, start, most
    minimise=lambda trial: pp.measures.speed_variation(trial.motion, drawn),
    subject_to={"pressure angle": (pressure_angle, None, np.radians(40))},
    geometry=lambda l4, h: {("E", "coupler"): (l4, 0, 0), ("slide_guide", "frame"): (0, 0, h)},
    speed=speed,
)

figure, axes = plt.subplots(figsize=(6.3, 3.0), layout="constrained")
for name, each in {"as printed": press, "most even": found.press}.items():
    motion = pp.cycle(each, speed, points=720)
    print(f"{name}: the speed changes by {100 * pp.measures.speed_variation(motion, drawn):.2f} % over the draw")
    axes.plot(np.degrees(motion.crank_angle), motion.slide_velocity, label=name)
axes.set(xlabel="crank angle [deg]", ylabel="speed of the slide [m/s]")
axes.legend()
