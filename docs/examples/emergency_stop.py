"""How far does the press run on after the light curtain is broken?

At the signal the clutch opens. The brake closes 30 ms later and reaches its full torque after another 50 ms. Does it
hold the slide at every angle of the turn? After which signal of the closing stroke does the press run on longest? A
spring brake must stop and hold even if half of its springs have failed (ISO 16092-2:2019, 5.2.5.2). So both are asked
twice.

**No distance on this page is advice.** S is the formula of ISO 13855:2010, 6.2.3, for a hand that enters a curtain at a
right angle. Its T is the stopping time plus assumed responses of curtain and control. The 2024 edition has another
formula, S = K T + D_DS + Z. What the model leaves out makes the stop longer: wear, heat and oil of the brake, scatter
of its valve, the margin of the brake monitor, brake disc and clutch plate on the crank, the upper die. Bearing
friction, left out too, makes it shorter. What decides is the stopping time that is measured on the press itself, as the
standard that applies to it demands.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import bisect, minimize_scalar

import pinpress as pp

press, speed, ends = pp.load("zxn2_3000b"), 50 * pp.RPM, pp.dead_centres(pp.load("zxn2_3000b"))
states = pp.cycle(press, speed=1e-3, points=3600)  # so slow that only the weight acts
weight, angles = pp.inverse_dynamics(press, states).driving_torque, np.degrees(states.crank_angle)


def stopping_time(signal, torque):
    """Time [s] from the signal at a crank angle [deg] to standstill, with a brake that holds."""
    brake = pp.drives.Brake(torque, closes=pp.drives.SwitchPoint(time=0.030), rise=0.050)  # N m, s
    path = pp.simulate(press, 3.0, speed=speed, angle=np.radians(signal), brake=brake).trajectory
    return bisect(lambda time: float(path.at(np.array([time])).speed[0, 0] > 1e-9) - 0.5, 0.0, 3.0)


def formula(time, resolution):
    """S [mm], resolution up to 40 mm; as the manuals SICK 8012624 and Rockwell 450L-UM001 print it, with an example."""
    reach = 8 * max(resolution - 14, 0)  # mm
    near = max(2000 * time + reach, 100)  # mm/s of a hand
    return near if near <= 500 else max(1600 * time + reach, 500)


figure, axes = plt.subplots(figsize=(6.3, 2.8), layout="constrained")
for full in (25e3, 32e3):
    for springs, torque in {"all springs": full, "half of the springs": full / 2}.items():
        name = f"{full / 1e3:.0f} kN m, {springs}"
        edges = angles[np.flatnonzero(np.diff(np.abs(weight) > torque))]
        if edges.size:
            print(f"{name}: does not hold from", ", ".join(f"{a:.0f} to {b:.0f} deg" for a, b in edges.reshape(-1, 2)))
            continue
        signals = np.linspace(*np.degrees([ends.top_angle, ends.bottom_angle]), 31)
        times = [stopping_time(signal, torque) for signal in signals]
        near = np.clip(np.argmax(times) + np.array([-1, 1]), 0, 30)
        worst = minimize_scalar(lambda signal, torque=torque: -stopping_time(signal, torque), bounds=signals[near], method="bounded")
        print(f"{name}: holds; stands {-1e3 * worst.fun:.1f} ms after a signal at {worst.x:.1f} deg")
        if full / 2 > np.abs(weight).max():  # else half of the springs do not hold: no curtain helps
            late = -worst.fun + 0.020 + 0.010  # s, responses of curtain and control, both assumed
            print(f"  S before what is left out: {formula(late, 14):.0f} mm (resolution 14 mm), {formula(late, 30):.0f} mm (30 mm)")
        axes.plot(signals, 1e3 * np.array(times), label=name)
axes.set(xlabel="crank angle at the signal [deg]", ylabel="time to standstill [ms]", ylim=(0, None))
axes.legend()
