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

import numpy as np

import pinpress as pp

press = pp.load("zxn2_3000b")
for torque in (25e3, 32e3):  # N m
    stops = pp.ratings.stopping(press, 50 * pp.RPM, torque, delay=0.030, rise=0.050, control=0.010, device=0.020)  # s
    for springs, case in stops.cases.items():
        name = f"{torque / 1e3:.0f} kN m, {springs}"
        for low, high, way in case.slips:
            print(f"{name}: does not hold from {np.degrees(low):.0f} to {np.degrees(high):.0f} deg, where it {way}")
        if case.worst is not None:
            print(f"{name}: holds; stands {1e3 * case.worst.time:.1f} ms after a signal at {np.degrees(case.worst.signal):.1f} deg")

for resolution in (0.014, 0.030):  # m, of the curtain
    distance = stops.distance("ISO 13855:2010", resolution=resolution).distance
    print(f"S before what is left out: {1e3 * distance:.0f} mm ({1e3 * resolution:.0f} mm)")

figure = pp.plots.draw(stops, "time")
