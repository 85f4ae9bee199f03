"""What do the pins of a four-bar carry?

Every press linkage is made of loops like this one: the crank AB, the coupler BC, the rocker DC, and the frame with the shafts A and D.
Find its motion and its forces by hand, with points as complex numbers, and then let pinpress find them from a table of pins. Both must
agree within rounding error. The crank turns counter-clockwise at a constant 60 r/min; gravity pulls down.

| link | length | mass | centre of mass | moment of inertia about it |
|---|---|---|---|---|
| crank AB | 100 mm | 6 kg | 40 mm from A, on AB | 0.02 kg m² |
| coupler BC | 300 mm | 10 kg | 150 mm from B, on BC | 0.09 kg m² |
| rocker DC | 250 mm | 12 kg | 125 mm from D, on DC | 0.08 kg m² |
| frame AD | 320 mm, along +x | | | |
"""

# %% What is given
# A point is the complex number x + i z: x to the right, z up, A at zero. The angle `q` of the crank counts from +x, counter-clockwise, and
# C stands above the line BD. All is in metres, kilograms, seconds and radians.

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

a, b, c, d = 0.100, 0.300, 0.250, 0.320  # crank, coupler, rocker, frame [m]
masses, inertias = (6.0, 10.0, 12.0), (0.02, 0.09, 0.08)  # of crank, coupler, rocker [kg], [kg m2]
g, w = 9.81, 2 * np.pi  # gravity [m/s2], speed of the crank [rad/s]
q = np.linspace(0.0, 2 * np.pi, 360, endpoint=False)
B, D = a * np.exp(1j * q), d

# %% Position
# The loop is closed where a exp(iq) + b exp(iu) = d + c exp(iv). Find the pin C and the angles u of the coupler and v of the rocker, at
# all 360 crank angles at once.
# Hint: The triangle BCD has three known sides at every crank angle. The law of cosines gives its angle at B, `np.angle` the direction from
# B to D.

# Gap: C, u and v, each an array (360,)
diagonal = np.abs(D - B)
angle = np.arccos((b**2 + diagonal**2 - c**2) / (2 * b * diagonal))
C = B + b * np.exp(1j * (np.angle(D - B) + angle))
u, v = np.angle(C - B), np.angle(C - D)
# End of the gap
np.testing.assert_allclose(B + b * np.exp(1j * u), D + c * np.exp(1j * v), rtol=0, atol=1e-14, err_msg="the loop is not closed")
assert np.all(((D - B).conj() * (C - B)).imag > 0), "C is below the line BD: this is the other assembly"

# %% Velocity
# Differentiate the loop by time: i w B + i u' (C - B) = i v' (C - D). This is one equation of complex numbers, so two of real ones, and it
# is linear in the speeds u' and v'.
# Hint: Multiply by the conjugate of C - D and take real and imaginary parts: |C - D|² is real, so that v' stays in one of them alone.

# Gap: du and dv, the speeds of coupler and rocker [rad/s], each (360,)
along = (C - D).conj()
du = -w * (B * along).imag / ((C - B) * along).imag
dv = ((w * B + du * (C - B)) * along).real / c**2
# End of the gap
np.testing.assert_allclose(w * B + du * (C - B), dv * (C - D), rtol=0, atol=1e-13, err_msg="the two ways to C have different velocities")

# %% Acceleration
# Differentiate once more. The unknowns u'' and v'' have the same factors as u' and v' had; what is new are the centripetal terms.
# Hint: -w² B + (i u'' - u'²)(C - B) = (i v'' - v'²)(C - D). Bring all that is known to one side, divide by i, and go on as before.

# Gap: ddu and ddv, the angular accelerations of coupler and rocker [rad/s2], each (360,)
along = (C - D).conj()
known = 1j * (w**2 * B + du**2 * (C - B) - dv**2 * (C - D))
ddu = -(known * along).imag / ((C - B) * along).imag
ddv = ((known + ddu * (C - B)) * along).real / c**2
# End of the gap
accelerations = -(w**2) * B + (1j * ddu - du**2) * (C - B), (1j * ddv - dv**2) * (C - D)
np.testing.assert_allclose(*accelerations, rtol=0, atol=1e-12, err_msg="the two ways to C have different accelerations")

# %% Forces
# Cut all pins. Let A and D be the forces of the frame on crank and rocker, B that of the crank on the coupler, C that of the rocker on the
# coupler, and T the torque on the crank: nine unknowns. Newton and Euler give three equations for each of three links. `centre` and
# `acceleration` of the centres of mass are there; write the equations as matrices (360, 9, 9) and right sides (360, 9).
# Hint: The unknowns are A_x, A_z, B_x, B_z, C_x, C_z, D_x, D_z, T. A force (x, z) with the arm s from the centre of mass has the moment
# s_x z - s_z x, counter-clockwise. A pin's force enters the link that it acts on with +, the link that it comes from with -.

centre = 0.4 * B, B + 0.5 * (C - B), D + 0.5 * (C - D)
acceleration = -(w**2) * 0.4 * B, -(w**2) * B + 0.5 * (1j * ddu - du**2) * (C - B), 0.5 * (1j * ddv - dv**2) * (C - D)
turning = 0 * q, ddu, ddv
# Gap: `unknowns` (360, 9), by np.linalg.solve
matrix, right = np.zeros((len(q), 9, 9)), np.zeros((len(q), 9))
pins = {"A": (0, 0 * B), "B": (1, B), "C": (2, C), "D": (3, D + 0 * B)}  # the column of each pair of unknowns, and the point
on = ({"A": +1, "B": -1}, {"B": +1, "C": +1}, {"D": +1, "C": -1})  # crank, coupler, rocker
for link in range(3):
    x, z, moment = 3 * link, 3 * link + 1, 3 * link + 2  # rows
    for name, sign in on[link].items():
        column, point = pins[name]
        arm = point - centre[link]
        matrix[:, x, 2 * column] = matrix[:, z, 2 * column + 1] = sign
        matrix[:, moment, 2 * column], matrix[:, moment, 2 * column + 1] = -sign * arm.imag, sign * arm.real
    right[:, x] = masses[link] * acceleration[link].real
    right[:, z] = masses[link] * (acceleration[link].imag + g)
    right[:, moment] = inertias[link] * turning[link]
matrix[:, 2, 8] = 1.0  # the torque acts on the crank
unknowns = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
# End of the gap
force = {name: unknowns[:, 2 * k : 2 * k + 2] for k, name in enumerate("ABCD")}
torque = unknowns[:, 8]
assert abs(torque.mean()) < 1e-12, "over a whole turn, the drive gives no work to links without losses"

# %% The same with pinpress
# Write the linkage as a table of pins (see docs/pin_table.md) and compare: torque and all pin forces. pinpress has the force of one link on
# the other in world axes (x, y, z), of the first link that a pin joins on the second.
# Hint: `pp.build(units="mm", frame="A D", pins={...}, links={...}, drive="A")`, then `pp.cycle` and `pp.inverse_dynamics`. A pin that two
# lengths fix is {"B": 300, "D": 250, "side": "up"}.

# Gap: `reactions` of the linkage `press` at the 360 crank angles
press = pp.build(
    units="mm",
    frame="A D",
    pins={
        "A": [0, 0],
        "D": [320, 0],
        "B": {"from": "A", "length": 100, "angle": 0},
        "C": {"B": 300, "D": 250, "side": "up"},
    },
    links={
        "crank": {"pins": "A B", "mass": 6, "com": [40, 0], "inertia": 0.02},
        "coupler": {"pins": "B C", "mass": 10, "com": [150, 0], "inertia": 0.09},
        "rocker": {"pins": "D C", "mass": 12, "com": [125, 0], "inertia": 0.08},
    },
    drive="A",
)
reactions = pp.inverse_dynamics(press, pp.cycle(press, speed=w, points=360))
# End of the gap
deviation = {"torque": np.abs(reactions.driving_torque - torque).max() / np.abs(torque).max()}
for name, sign in {"A": 1, "B": 1, "C": -1, "D": 1}.items():
    theirs = sign * reactions.bearing_force[name][:, [0, 2]]  # C is the coupler's force on the rocker there
    deviation[f"force {name}"] = np.abs(theirs - force[name]).max() / np.abs(force[name]).max()
for name, share in deviation.items():
    assert share < 1e-12, f"{name} deviates by {share:.1e} of its largest value"
print(f"torque {torque.min():.4f} to {torque.max():.4f} N m")
for name, values in force.items():
    size = np.hypot(*values.T)
    print(f"{name}: at most {size.max():.4f} N, at a crank angle of {np.degrees(q[size.argmax()]):.0f} degrees")
print("largest deviation below 1e-12 of the largest value")

figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(6.3, 4.4), layout="constrained")
for name, values in force.items():
    above.plot(np.degrees(q), np.hypot(*values.T), label=name)
above.set(ylabel="pin force [N]", ylim=(0, 300))
above.legend(ncols=4)
below.plot(np.degrees(q), torque)
below.plot(np.degrees(q[::12]), reactions.driving_torque[::12], "k.", label="pinpress")
below.set(xlabel="crank angle [degrees]", ylabel="torque [N m]")
below.legend()
