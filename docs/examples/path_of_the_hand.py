"""How do I get the inverse kinematics of my own closed-loop robot?

The five-bar arm moves its hand along a straight line, from rest to rest. Which angles of both motors do that, and which
torques? Newton's method finds the angles at all instants together. For every guess pinpress closes the loop and gives
the place of the hand.
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

robot = pp.load("five_bar.urdf")  # of this folder


def hand(angles):
    """Where the hand is (n, 2), x and z, at the angles of the motors (n, 2); each state stands by itself."""
    states = pp.servo_cycle(robot, angles, speed=np.zeros_like(angles), acceleration=np.zeros_like(angles))
    return pp.measures.bearing_positions(robot, states)["hand"][:, [0, 2]]


time = np.linspace(0.0, 0.5, 201)
share = (time / 0.5) ** 3 * (10 - 15 * (time / 0.5) + 6 * (time / 0.5) ** 2)  # of the way, from rest to rest
path = hand(np.zeros((1, 2))) + np.outer(share, [-0.08, -0.05])  # m

angles = np.zeros((len(time), 2))
for _ in range(6):
    columns = [(hand(angles + step) - hand(angles - step)) / 2e-5 for step in 1e-5 * np.eye(2)]
    angles += np.linalg.solve(np.stack(columns, axis=-1), (path - hand(angles))[:, :, None])[:, :, 0]
print(f"the hand is on its path to 1e-14 m: {np.abs(path - hand(angles)).max() < 1e-14}")

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
