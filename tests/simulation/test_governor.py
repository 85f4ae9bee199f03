"""A stiff governor in space: a shaft that turns freely, two rods with balls that swing out, and a sleeve on springs and hard dampers.

Masses, lengths, springs and dampers are those of problem A05 of the IFToMM library of multibody benchmarks, which prints no positions; here
the springs are slack at the start. The oracle is the Lagrangian by hand: as both rods move alike, it has three coordinates.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support import texts

import pinpress as pp
from pinpress.common.quantities import GRAVITY

DENSITY, BALL, SPIN, LEAN = 3000.0, 5.0, 2 * math.pi, math.pi / 6  # [kg/m3, kg, rad/s, rad]
ROD, SLEEVE = DENSITY * 1.0 * 0.01**2, DENSITY * 0.1**3  # masses [kg]
STIFFNESS, DAMPING, SLACK = 8e5, 4e4, 0.5  # of the springs from the middles of the rods to the sleeve [N/m, N s/m, m]
START = 1.0 - math.cos(LEAN)  # height of the sleeve where its distance from the middles is that of slack springs [m]
HINGED = ROD * (1.0 + 0.01**2 / 4) / 3 + BALL  # moment of inertia of rod and ball about the hinge [kg m2]
ALONG = ROD * 0.01**2 / 6  # the same about the rod
TURNING = ROD * 0.01**2 / 6 + SLEEVE * 0.1**2 / 6  # of shaft and sleeve about the shaft


def urdf():
    def inertial(mass, height, across, along):
        return (
            f'<inertial><origin xyz="0 0 {height!r}"/><mass value="{mass!r}"/>'
            f'<inertia ixx="{across!r}" iyy="{across!r}" izz="{along!r}" ixy="0" ixz="0" iyz="0"/></inertial>'
        )

    mass = ROD + BALL
    centre = -(0.5 * ROD + BALL) / mass
    rod = inertial(mass, centre, HINGED - mass * centre**2, ALONG)
    shaft = inertial(ROD, 0.5, ROD * (1.0 + 0.01**2) / 12, ROD * 0.01**2 / 6)
    sleeve = inertial(SLEEVE, 0.0, SLEEVE * 0.1**2 / 6, SLEEVE * 0.1**2 / 6)
    hinges = "".join(
        f'<joint name="hinge{k}" type="continuous"><parent link="shaft"/><child link="rod{k}"/><axis xyz="0 {-sign} 0"/>'
        f'<origin xyz="0 0 1" rpy="0 {-sign * LEAN!r} 0"/></joint>'
        for k, sign in ((1, 1), (2, -1))
    )
    return (
        f'<robot name="governor"><link name="frame"/><link name="shaft">{shaft}</link><link name="rod1">{rod}</link>'
        f'<link name="rod2">{rod}</link><link name="sleeve">{sleeve}</link>'
        '<joint name="spin" type="continuous"><parent link="frame"/><child link="shaft"/><axis xyz="0 0 1"/></joint>'
        f"{hinges}"
        f'<joint name="lift" type="prismatic"><parent link="shaft"/><child link="sleeve"/><origin xyz="0 0 {START!r}"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="0" velocity="10"/></joint></robot>'
    )


def rates(_, state):
    """By hand: of the turned angle, the lean of the rods, the height of the sleeve, and their rates."""
    _, lean, height, spin, swing, lift = state
    sine, cosine = np.sin(lean), np.cos(lean)
    across, above = 0.5 * sine, 1.0 - 0.5 * cosine - height  # of the middle of a rod, from the sleeve
    length = np.hypot(across, above)
    by_lean, by_height = (0.5 * cosine * across + 0.5 * sine * above) / length, -above / length
    force = STIFFNESS * (length - SLACK) + DAMPING * (by_lean * swing + by_height * lift)
    slope = 2 * (HINGED - ALONG) * sine * cosine  # of the moment of inertia of a rod about the shaft
    whole = TURNING + 2 * (HINGED * sine**2 + ALONG * cosine**2)
    weight = (0.5 * ROD + BALL) * GRAVITY * sine
    swinging = (0.5 * slope * spin**2 - weight - force * by_lean) / HINGED
    lifting = -2 * force * by_height / SLEEVE - GRAVITY
    return np.array([spin, swing, lift, -2 * slope * swing * spin / whole, swinging, lifting])


def slopes(time, state):
    """Derivatives (6, 6) of `rates`; SciPy's own differences overflow for an angle that no rate depends on."""
    steps = 1e-7 * np.eye(6)
    return np.array([(rates(time, state + step) - rates(time, state - step)) / 2e-7 for step in steps]).T


@pytest.mark.exhaustive
@pytest.mark.parametrize("duration", [1.0, pytest.param(10.0, marks=pytest.mark.exhaustive)])
def test_a_stiff_governor_agrees_with_its_lagrangian(duration):
    press = texts.load(urdf(), driver=("spin", "hinge1", "hinge2", "lift"))
    springs = [pp.loads.SpringDamper("sleeve", rod, STIFFNESS, DAMPING, SLACK, point2=(0.0, 0.0, -0.5)) for rod in ("rod1", "rod2")]
    run = pp.simulate(press, duration, speed=[SPIN, 0.0, 0.0, 0.0], loads=springs, points=11)
    start = [0.0, LEAN, START, SPIN, 0.0, 0.0]
    judge = solve_ivp(rates, (0.0, duration), start, "Radau", run.time, rtol=1e-10, atol=1e-12, jac=slopes)
    joints = [press.joints.index(name) for name in press.drivers]
    spin, one, other, lift = run.joint_position.T[joints]
    turned, lean, height = judge.y[:3]
    assert run.stats.solvers[-1] == "implicit"
    assert np.abs(spin - turned).max() < 3e-11
    assert np.abs(np.array([one, other]) - (lean - LEAN)).max() < 3e-11
    assert np.abs(lift - (height - START)).max() < 3e-11
    momentum = (TURNING + 2 * (HINGED * np.sin(LEAN + one) ** 2 + ALONG * np.cos(LEAN + one) ** 2)) * run.v[:, joints[0]]
    assert np.abs(momentum / momentum[0] - 1.0).max() < 1e-11  # nothing turns the shaft
    assert run.stats.energy_error < 1e-10
