"""What does one stroke cost the flywheel?

A crank press blanks a sheet. The force acts over a few millimetres, the motor is far too small for it: the flywheel gives the work, slows
down, and is driven up again until the next stroke. Find work, torque, flywheel, drop of speed and permissible force by hand, then by
pinpress.

| given | |
|---|---|
| crank press | radius 100 mm, rod 400 mm, nominal force 1000 kN from 6 mm above bottom dead centre |
| speed at the start of the stroke | 60 r/min |
| sheet | met 5 mm above bottom dead centre, through at 1 mm; force F sin(π/2 · way/4 mm), F = 800 kN |
| flywheel | may lose 20 % of its speed in a stroke |
"""

# %% What is given
# The crank angle q is zero at bottom dead centre, so that the stroke begins at q = -π, at the top. The way down ends at q = 0.

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

import pinpress as pp

r, rod, w = 0.100, 0.400, 60 * pp.RPM  # [m], [m], [rad/s]
largest, start, end = 800e3, 0.005, 0.001  # of the sheet [N], [m], [m]
nominal_force, nominal_height, drop = 1000e3, 0.006, 0.20
press = pp.load("crank_slide")  # crank 20 kg, 0.1 kg m2, centred at 30 mm; rod 15 kg, 0.2 kg m2, in its middle; slide 100 kg
sheet = pp.loads.Blanking(largest, start=start, end=end)
q = np.linspace(-np.pi, 0.0, 721)

# %% The work of a stroke
# How much work does the sheet take?
# Hint: Integrate F sin(π/2 (start - h)/(start - end)) over the height h from start to end.

# Gap: `work` [J]
work = largest * (start - end) * 2 / np.pi
# End of the gap
np.testing.assert_allclose(work / (start - end) / largest, 0.6366, atol=5e-5, err_msg="not the mean of a quarter of a sine, times the way")

# %% The crank
# Find the height h of the slide above bottom dead centre and its travel per crank angle, dh/dq, at all crank angles q. The torque that
# holds a force on the slide is the force times |dh/dq|, because the power is the same on both sides. Which torque does the sheet need at
# most?
# Hint: H = r + rod - r cos q - sqrt(rod² - r² sin² q).


# Gap: `height(q)`, `travel(q)` for any crank angles; `force`, `torque` (721,) of the sheet
def height(q: np.ndarray) -> np.ndarray:
    return r + rod - r * np.cos(q) - np.sqrt(rod**2 - (r * np.sin(q)) ** 2)


def travel(q: np.ndarray) -> np.ndarray:
    return r * np.sin(q) + r**2 * np.sin(q) * np.cos(q) / np.sqrt(rod**2 - (r * np.sin(q)) ** 2)


h = height(q)
force = np.where((h <= start) & (h >= end), largest * np.sin(np.pi / 2 * (start - h) / (start - end)), 0.0)
torque = force * np.abs(travel(q))
# End of the gap
motion = pp.servo_cycle(press, q, speed=w)
idle, pressing = pp.inverse_dynamics(press, motion), pp.inverse_dynamics(press, motion, loads=[sheet])
needed = pressing.driving_torque - idle.driving_torque  # weights and inertia are in both
np.testing.assert_allclose(torque, needed, rtol=0, atol=1e-9 * needed.max(), err_msg="not the torque that pinpress finds")
print(f"work {work:.1f} J, torque up to {torque.max() / 1e3:.2f} kN m")

# %% The flywheel
# The flywheel alone gives the work, from w to (1 - 0.20) w. How large must it be, at the crank's shaft?
# Hint: Half of J w² before, half of J (0.8 w)² after.

# Gap: `inertia` [kg m2]
inertia = 2 * work / (w**2 * (1 - (1 - drop) ** 2))
# End of the gap
given = inertia / 2 * (w**2 - ((1 - drop) * w) ** 2)
np.testing.assert_allclose(given, work, rtol=1e-12, err_msg="not the flywheel that gives the work")

# %% The drop of speed
# Now let the flywheel run through a stroke with no motor at all, from top dead centre to top dead centre. The linkage's own inertia helps a
# little. At the top the slide rests, the crank turns, and the rod turns about its upper end in W. How fast is the crank after one turn?
# Hint: The energy of the crank about O, and of the rod about W with the speed w r / rod, belongs to the flywheel's. Weights give nothing
# over a whole turn.

# Gap: `after`, the speed after the stroke [rad/s]
linkage = 0.1 + 20 * 0.030**2 + (0.2 + 15 * 0.200**2) * (r / rod) ** 2
after = np.sqrt(w**2 - 2 * work / (inertia + linkage))
# End of the gap
run = pp.simulate(press, 1.5, angle=-np.pi, speed=w, flywheel=pp.drives.Flywheel(inertia), loads=[sheet], points=3001)
by_angle = CubicHermiteSpline(run.crank_angle, run.crank_speed, run.crank_acceleration / run.crank_speed)
np.testing.assert_allclose(run.load_work[-1], work, rtol=1e-9, err_msg="not the work of the stroke")
np.testing.assert_allclose(by_angle(np.pi), after, rtol=1e-9, err_msg="not the speed after the stroke")
print(f"flywheel {inertia:.1f} kg m2, after the stroke {100 * after / w:.2f} % of the speed")

# %% The permissible force
# A catalogue prints the force that a press may give at a height h: the nominal force, the force that the torque for the nominal force at
# the nominal height allows, or the force that the flywheel's energy allows if it stays constant from h to the bottom, whichever is least.
# Find it at the heights of pinpress, `found.crank_angle`. How many kN may the press give 20 mm above the bottom, and what limits it?
# Hint: The torque is the nominal force times |dh/dq| where h is the nominal height; find that angle with `scipy.optimize.brentq`.

capacities = pp.ratings.Capacities(nominal_force=nominal_force, nominal_height=nominal_height, flywheel_inertia=inertia, speed_drop=drop)
found = pp.ratings.rate(press, w, capacities)
at = found.height > 0  # at the bottom itself torque and energy limit nothing
# Gap: `permissible`, an array as long as found.crank_angle[at] [N], and `at_20_mm` [N]
angle = brentq(lambda q: height(q) - nominal_height, -1.0, 0.0, xtol=1e-15)
limit = nominal_force * abs(travel(angle))
by_torque = limit / np.maximum(np.abs(travel(found.crank_angle[at])), 1e-300)
permissible = np.minimum(np.minimum(nominal_force, by_torque), work / height(found.crank_angle[at]))
higher = brentq(lambda q: height(q) - 0.020, -2.0, 0.0, xtol=1e-15)
at_20_mm = min(nominal_force, limit / abs(travel(higher)), work / 0.020)
# End of the gap
np.testing.assert_allclose(permissible, found.force[at], rtol=1e-9, err_msg="not the ratings of pinpress")
np.testing.assert_allclose(at_20_mm, work / 0.020, rtol=1e-12, err_msg="20 mm above the bottom the flywheel is the limit")
print(f"20 mm above the bottom: {at_20_mm / 1e3:.1f} kN, by the flywheel")

# %% The motor
# In continuous strokes a motor gives back in each turn what the sheet took. How much power must it have on average, at 60 strokes/min?
# Then look at the stroke that repeats itself: the motor works on the way down too, so that the speed drops less.
# Hint: Power is work by time.

# Gap: `power` [W]
power = work * w / (2 * np.pi)
# End of the gap
motor = pp.drives.Geared(pp.drives.InductionMotor(rated_power=3e3, rated_speed=1425 * pp.RPM, inertia=0.01), ratio=24)
steady = pp.steady_state(press, w, drive=motor, flywheel=pp.drives.Flywheel(inertia), loads=[sheet])
duty = pp.measures.duty_cycle(steady)
np.testing.assert_allclose(duty.drive_work, work, rtol=1e-9, err_msg="in a stroke that repeats itself the motor gives what the sheet takes")
np.testing.assert_allclose(power, duty.drive_work / duty.duration * w / duty.mean_speed, rtol=1e-9, err_msg="not the power at 60 r/min")
print(f"motor {power / 1e3:.3f} kW on average; with one of 3 kW the speed drops by {100 * duty.speed_drop:.1f} %")
print(
    f"its utilisation is {duty.utilisation:.2f}, by the rms of its torque: above 1 it becomes too warm, though 3 kW are more than the mean"
)

figure, (left, right) = plt.subplots(1, 2, figsize=(6.9, 3.2), layout="constrained")
left.plot(np.degrees(run.crank_angle), run.crank_speed / pp.RPM, label="flywheel alone")
two_turns = np.concatenate([steady.crank_angle - 2 * np.pi, steady.crank_angle])
left.plot(np.degrees(two_turns), np.tile(steady.crank_speed, 2) / pp.RPM, label="with motor, repeated")
left.set(xlabel="crank angle [degrees]", ylabel="speed [r/min]", xlim=(-180, 180), ylim=(47, 68))
left.legend(fontsize="small", loc="upper right")
right.plot(1e3 * found.height, found.force / 1e3, label="permissible")
right.plot(1e3 * height(q), force / 1e3, label="sheet")
right.set(xlabel="height above bottom dead centre [mm]", ylabel="force [kN]", xlim=(0, 30))
right.legend()
