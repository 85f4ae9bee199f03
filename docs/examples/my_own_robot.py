"""Which torques do the motors of my own closed-loop robot need?

The URDF of a five-bar arm with two motors has the tree as usual, and next to it the pin that closes the loop. `pp.load`
closes it. A path of both motors is a motion, and inverse dynamics gives both torques and the force in every bearing.
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

robot = pp.load("five_bar.urdf")  # of this folder
time = np.linspace(0.0, 1.0, 201)
left, right = 0.4 * np.sin(2 * np.pi * time), 0.4 * (1 - np.cos(2 * np.pi * time))  # rad, from the drawn pose
motion = pp.servo_cycle(robot, np.column_stack([left, right]), time=time)
reactions = pp.inverse_dynamics(robot, motion)

for name, torque in zip(("left", "right"), reactions.driving_torque.T, strict=True):
    print(f"{name} motor: {torque.min():+.2f} to {torque.max():+.2f} N m")
for name, force in reactions.bearing_force.items():
    print(f"{name}: up to {np.linalg.norm(force, axis=1).max():.2f} N")

figure, axes = plt.subplots(figsize=(6.3, 2.6), layout="constrained")
axes.plot(time, reactions.driving_torque, label=["left motor", "right motor"])
axes.set(xlabel="time [s]", ylabel="torque [N m]")
axes.legend()
