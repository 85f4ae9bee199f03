"""Why is half of the slide's mass balanced?

A crank press shakes its foundation, and a counterweight on the crank quietens it: the classical rule balances all turning masses and half
of the reciprocating mass. Find by hand what shakes, why half, and what remains; then let pinpress prove that no counterweight is better.
The press runs at 300 strokes/min.

| link | length | mass | centre of mass |
|---|---|---|---|
| crank OP | 50 mm | 40 kg | 15 mm from O, on OP |
| rod PW | 250 mm | 25 kg | 80 mm from P, on PW |
| slide, vertical | | 120 kg | |
"""

# %% What is given
# Bottom dead centre is at the crank angle q = 0, where the pin P points down at the slide. The table of pins describes the press.

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp
from pinpress.balancing import Counterweight, CounterweightRegion, Rms, balance, with_counterweights

r, rod = 0.050, 0.250  # [m]
w = 300 * pp.RPM  # [rad/s]
press = pp.build(
    units="mm",
    frame="O",
    pins={"O": [0, 0], "P": {"from": "O", "length": 50, "angle": -90}, "W": {"P": 250, "x": 0, "side": "down"}},
    links={
        "crank": {"pins": "O P", "mass": 40, "com": [15, 0], "inertia": 0.05},
        "rod": {"pins": "P W", "mass": 25, "com": [80, 0], "inertia": 0.2},
        "slide": {"pins": "W", "guide": "up", "mass": 120},
    },
    drive="O",
)
motion = pp.cycle(press, speed=w, points=720)
q = motion.crank_angle
shaking = pp.inverse_dynamics(press, motion).shaking_force  # (720, 3) of the machine on the foundation, its weight included [N]
shaking = shaking - [0, 0, -9.81 * (40 + 25 + 120)]  # what shakes is what is left without the weight

# %% What shakes
# The foundation feels minus the mass times acceleration of all links. As far as forces go, the rod may be replaced by two masses, one in P
# and one in W, with the same sum and the same centre of mass. Then all masses turn with the crank or go up and down with the slide.
# Hint: Turning are 40 kg at 15 mm and the rod's share at 50 mm: a product of mass and radius. The height of the slide's pin is
# -(r cos q + sqrt(rod² - r² sin² q)). Differentiate it twice, at constant w, or use a complex step.

# Gap: `turning` [kg m], `reciprocating` [kg], `acceleration` (720,) of the slide, upwards
turning = 40 * 0.015 + 25 * (1 - 80 / 250) * r
reciprocating = 120 + 25 * 80 / 250
s, root = np.sin(q), np.sqrt(rod**2 - (r * np.sin(q)) ** 2)
acceleration = w**2 * (r * np.cos(q) + r**2 * (np.cos(q) ** 2 - s**2) / root + (r**2 * s * np.cos(q)) ** 2 / root**3)
# End of the gap
by_hand = np.column_stack([turning * w**2 * np.sin(q), -turning * w**2 * np.cos(q) - reciprocating * acceleration])
np.testing.assert_allclose(by_hand, shaking[:, [0, 2]], rtol=0, atol=1e-12 * np.abs(shaking).max(), err_msg="not what pinpress finds")

# %% Orders
# The slide's acceleration is the series w² r (cos q + A2 cos 2q + A4 cos 4q + ...). Find the amplitudes of orders 1 and 2 in the vertical
# shaking force, and which share of order 2 the usual approximation A2 = r/rod leaves out.
# Hint: The mean of f cos(kq) over evenly spaced angles of a turn is half of the amplitude of order k, exactly.

# Gap: `orders`, the amplitudes of orders 1 and 2 [N], and `left_out` [-]
orders = [abs(2 * np.mean(shaking[:, 2] * np.cos(k * q))) for k in (1, 2)]
left_out = 1 - reciprocating * r * w**2 * (r / rod) / orders[1]
# End of the gap
found = pp.measures.harmonics(motion, shaking, orders=2)
np.testing.assert_allclose(orders, found.amplitude[1:, 2], rtol=1e-12, err_msg="not the harmonics that pinpress finds")
print(f"vertical: order 1 {orders[0]:.1f} N, order 2 {orders[1]:.1f} N, of which r/rod leaves out {100 * left_out:.2f} %")

# %% A counterweight
# A counterweight 0.2 m from O, opposite to the pin P, balances all that turns and the share k of what goes to and fro. Find its mass, then
# the rms of the magnitude of the shaking force over a turn, for all shares from 0 to 1.
# Hint: 0.2 m times its mass is the product to be balanced. In `with_counterweights` its place is in the crank's own axes, whose x points
# from O to P. Forces are linear in masses: the shares 0 and 1 are enough, and those between follow.


# Gap: `weight(k)`, the mass [kg]
def weight(k: float) -> float:
    return (turning + k * reciprocating * r) / 0.2


# End of the gap
def shaken(k: float) -> np.ndarray:
    """The shaking force (720, 2) with the share k, x and z [N]."""
    balanced = with_counterweights(press, [Counterweight("crank", weight(k), (-0.2, 0, 0))])
    force = pp.inverse_dynamics(balanced, motion).shaking_force[:, [0, 2]]
    return force - force.mean(axis=0)


def rms(force: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(force**2, axis=1))))


shares = np.linspace(0.0, 1.0, 41)
none, whole = shaken(0.0), shaken(1.0)
sizes = np.array([rms((1 - k) * none + k * whole) for k in shares])
np.testing.assert_allclose(shaken(0.5), (none + whole) / 2, rtol=0, atol=1e-9, err_msg="forces are linear in masses")
np.testing.assert_allclose(none[:, 0], 0.0, rtol=0, atol=1e-9, err_msg="with k = 0 nothing shakes across: all that turns is balanced")

# %% Why half
# Order 1 of what goes to and fro is F cos q along the guide. Write it as two forces that turn, one with the crank and one against it. What
# does a counterweight do to each? Give the magnitude of order 1 of the shaking force over the crank angle, for k = 1/2.
# Hint: Cos q = (exp(iq) + exp(-iq)) / 2. A counterweight turns with the crank and can only meet the first of the two.

# Gap: `magnitude` [N], of what remains of order 1 with k = 1/2
magnitude = reciprocating * r * w**2 / 2
# End of the gap
half = shaken(0.5)
first = np.column_stack([2 * np.mean(half * f(q)[:, None], axis=0) for f in (np.cos, np.sin)])  # (2, 2) of cos q and sin q
order_1 = np.outer(np.cos(q), first[:, 0]) + np.outer(np.sin(q), first[:, 1])
np.testing.assert_allclose(np.hypot(*order_1.T), magnitude, rtol=1e-10, err_msg="not the magnitude of what remains")
backwards = np.unwrap(np.arctan2(order_1[:, 0], -order_1[:, 1]))  # counted as q is, from below towards +x
np.testing.assert_allclose(np.diff(backwards), -np.diff(q), rtol=1e-9, err_msg="what remains turns against the crank")
print(
    f"rms without a counterweight {rms(shaking[:, [0, 2]]):.1f} N, with k = 0, 1/2, 1: {sizes[0]:.1f}, {sizes[20]:.1f}, {sizes[40]:.1f} N"
)

# %% The proof
# Let pinpress find the counterweight with the least rms, anywhere within 0.2 m of the shaft. It also proves how far from the best any other
# may be. Which share k is it? Try another length of the rod, too: k stays, because no counterweight on the crank reaches order 2.
# Hint: `balance(press, motion, regions=[CounterweightRegion("crank", radius=0.2)], minimise=Rms("shaking_force"))`. The result has
# `counterweights`, with mass and position.

# Gap: `best`, the `product` (3,) of its mass and position [kg m], and the share `k`
best = balance(press, motion, regions=[CounterweightRegion("crank", radius=0.2)], minimise=Rms("shaking_force"))
product = sum(each.mass * np.array(each.position) for each in best.counterweights)  # [kg m], in the crank's own axes
k = (-product[0] - turning) / (reciprocating * r)
# End of the gap
assert abs(k - 0.5) < 1e-6, f"k = {k:.9f} is not half"
assert abs(product[1]) + abs(product[2]) < 1e-6 * abs(product[0]), "the best counterweight is opposite to the pin"
print(f"proved best: k = {k:.6f}, {weight(k):.2f} kg at 0.2 m")

figure, (left, right) = plt.subplots(1, 2, figsize=(6.9, 3.6), layout="constrained")
for share in (0.0, 0.5, 1.0):
    left.plot(*shaken(share).T / 1e3, label=f"k = {share:g}")
left.set(xlabel="shaking force, x [kN]", ylabel="z [kN]", aspect="equal")
left.legend(loc="upper right", fontsize="small")
right.plot(shares, sizes / 1e3)
right.plot(k, rms(shaken(k)) / 1e3, "k.", label="proved best")
right.set(xlabel="share k of the reciprocating mass", ylabel="rms of the shaking force [kN]", ylim=(0, None))
right.legend()
