"""What if a pin wears by 0.1 mm?

A worn pin lets the rod leave its bearing and strike it again. The stroke on springs, with 0.1 mm of radial clearance in
the wrist pin, shows how hard and how often it knocks, compared with the force of the rigid press.
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

press, speed = pp.load("jf75g_125_plain"), 300 * pp.RPM
springs = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 2e9), moments={"slide_guide": 2e8})  # N/m, N m/rad
worn = pp.elasticity.Elastic(springs, damping_ratio=0.03, clearances={"P4": pp.elasticity.Clearance(1e-4)})
run = pp.simulate(press, 0.4, speed=speed, drive=pp.drives.PrescribedSpeed(speed), elastic=worn, points=4001)

knocks = pp.elasticity.journal_impacts(run, "P4")
rigid = np.linalg.norm(pp.inverse_dynamics(press, pp.cycle(press, speed)).bearing_force["P4"], axis=1)
print(f"{knocks.impacts.mean():.1f} impacts a turn; peak {knocks.mean_peak / 1e3:.1f} kN, {rigid.max() / 1e3:.1f} kN without clearance")
print(f"the pin is off its bearing for {100 * knocks.flight.mean():.0f} % of the turn")

last = run.time > run.time[-1] - 0.2  # the last turn
figure, axes = plt.subplots(figsize=(6.3, 3.0), layout="constrained")
axes.plot(1e3 * (run.time[last] - 0.2), np.linalg.norm(run.bearing_force["P4"], axis=1)[last] / 1e3, label="worn")
axes.plot(np.linspace(0, 200, len(rigid), endpoint=False), rigid / 1e3, label="rigid, no clearance")
axes.set(xlabel="time [ms]", ylabel="force of the wrist pin [kN]")
axes.legend()
