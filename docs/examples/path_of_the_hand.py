"""How do I get the inverse kinematics of my own closed-loop robot?

The five-bar arm moves its hand along a straight line, from rest to rest. Which angles of both motors do that, and which
torques? `pp.inverse_kinematics` finds the angles for places of a frame, here of the link `gripper`, and stays in the
assembly in which the file draws the arm.
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

robot = pp.load("five_bar.urdf")  # of this folder
time = np.linspace(0.0, 0.5, 201)
share = (time / 0.5) ** 3 * (10 - 15 * (time / 0.5) + 6 * (time / 0.5) ** 2)  # of the way, from rest to rest
begin = robot.placements("gripper", [0.0, 0.0])[:3, 3]
path = begin + np.outer(share, [-0.08, 0.0, -0.05])  # m

angles = pp.inverse_kinematics(robot, "gripper", path)
away = robot.placements("gripper", angles)[:, :3, 3] - path
print(f"the hand is on its path to 1e-10 m: {np.abs(away).max() < 1e-10}")

motion = pp.servo_cycle(robot, angles, time=time)
reactions = pp.inverse_dynamics(robot, motion)
for name, angle, torque in zip(("left", "right"), angles.T, reactions.driving_torque.T, strict=True):
    print(f"{name} motor: turns by {np.degrees(angle[-1]):+.2f} deg, {torque.min():+.2f} to {torque.max():+.2f} N m")

figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(6.3, 3.8), layout="constrained")
above.plot(time, np.degrees(angles), label=["left motor", "right motor"])
above.set(ylabel="angle [deg]")
above.legend()
below.plot(time, reactions.driving_torque)
below.set(xlabel="time [s]", ylabel="torque [N m]")
