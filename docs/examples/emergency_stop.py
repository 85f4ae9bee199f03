"""How far does the press run on after the light curtain is broken?

The clutch opens at the signal and the brake closes 30 ms later. Where in the stroke the signal comes decides how long
the press runs on, so it comes at many crank angles; the longest time, with the speed of a hand, says how far away the
light curtain must be.
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

press, speed = pp.load("zxn2_3000b"), 50 * pp.RPM
delay = 0.030  # s, of valve and piston
angles, times = np.radians(np.arange(0, 360, 15)), []
for angle in angles:
    brake = pp.drives.Brake(torque=25e3, closes=pp.drives.SwitchPoint(time=delay), rise=0.050)  # N m, s
    run = pp.simulate(press, 3.0, speed=speed, angle=angle, brake=brake, points=3001)
    times.append(run.time[np.abs(run.crank_speed) > 1e-6].max())

longest = int(np.argmax(times))
print(f"longest: {1e3 * times[longest]:.0f} ms after a signal at {np.degrees(angles[longest]):.0f} deg")
print(f"light curtain at least {1.6 * times[longest]:.2f} m away")  # 1.6 m/s, ISO 13855

figure, axes = plt.subplots(figsize=(6.3, 2.8), layout="constrained")
axes.plot(np.degrees(angles), 1e3 * np.array(times), "o-")
axes.set(xlabel="crank angle at the signal [deg]", ylabel="time to standstill [ms]", ylim=(0, None))
