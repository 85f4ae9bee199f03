"""How large must the flywheel be?

The stroke that repeats under motor and load is found directly for flywheels of many sizes. A motor is overheated if its
utilisation, rms torque by rated torque, is above 1. The smallest flywheel that keeps it below 1 is the answer, with its
drop of speed. It has no reserve: starts, friction and other losses than those of torque are not included.
"""

import matplotlib.pyplot as plt

import pinpress as pp

press = pp.load("zxn2_3000b")
motor = pp.drives.Geared(pp.drives.InductionMotor(rated_power=75e3, rated_speed=1485 * pp.RPM, inertia=1.2), ratio=20.7)
drawing = pp.loads.DeepDrawing(force=1e6, start=0.010)

inertias = [1500, 2000, 2500, 3000, 3500, 4000, 5000, 6000, 8000]  # kg m2 at the crank's shaft
duties = []
for inertia in inertias:
    steady = pp.steady_state(press, 70 * pp.RPM, drive=motor, flywheel=pp.drives.Flywheel(inertia), loads=[drawing])
    duties.append(pp.measures.duty_cycle(steady))
least, duty = next(each for each in zip(inertias, duties, strict=True) if each[1].utilisation < 1)
print(f"{least} kg m2: utilisation {duty.utilisation:.3f}, the speed drops by {100 * duty.speed_drop:.1f} %")

figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(6.3, 4.0), layout="constrained")
above.plot(inertias, [duty.utilisation for duty in duties], "o-")
above.axhline(1.0, color="grey", linewidth=0.8)
above.set_ylabel("utilisation of the motor")
below.plot(inertias, [100 * duty.speed_drop for duty in duties], "o-")
below.set_ylabel("drop of speed [%]")
below.set_xlabel("flywheel [kg m²]")
