"""What does the floor feel?

A high-speed press of 17 t stands on four rubber pads. How much of its shaking force reaches the floor between 150 and
450 strokes a minute, on pads of 40 mm, and on springs a tenth as stiff?
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp
from pinpress import foundation

press = pp.load("jf75g_125_plain")
frame = foundation.Frame(mass=15000, centre=(0, 0, -0.35), inertia=(9000, 8000, 4000))  # all that is not in the URDF
pad = foundation.RubberPad(length=0.2, width=0.2, thickness=0.04, hardness=55, loss_factor=0.15, stiffening=1.3)  # m, Shore A
corners = [(x, y, -1.3) for x in (-0.55, 0.55) for y in (-0.5, 0.5)]
pads = [foundation.pad_mount(corner, pad) for corner in corners]
springs = [foundation.Mount(corner, tuple(0.1 * k for k in pads[0].stiffness), loss_factor=0.05) for corner in corners]

speeds = np.linspace(150, 450, 121) * pp.RPM
figure, axes = plt.subplots(figsize=(6.3, 3.0), layout="constrained")
for name, mounts in {"rubber pads": pads, "springs": springs}.items():
    system = foundation.mounted(press, frame, mounts)
    over = foundation.over_speeds(system, speeds, points={"top": (0, 0, 1.0)})
    share, k = over.transmitted, over.transmitted.argmax()
    print(f"{name}: {share[60]:.2f} of the shaking force at 300", end=", ")
    print(f"{share[k]:.2f} at {speeds[k] / pp.RPM:.0f} strokes a minute")
    axes.plot(speeds / pp.RPM, over.transmitted, label=name)
axes.axhline(1.0, color="grey", linewidth=0.8)
axes.set(xlabel="strokes a minute", ylabel="force on the floor\nby shaking force", yscale="log")
axes.legend()
