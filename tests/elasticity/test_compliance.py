"""Compliance at the slide against closed forms, Castigliano's theorem and linkages with displaced pins."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import fsolve
from support import texts

import pinpress as pp
from pinpress.balancing.classical import as_crank_slider
from pinpress.elasticity.slide_under_load import slide_deflection
from pinpress.elasticity.springs import Rod, Stiffness, springs_of
from pinpress.elasticity.unit_load import _moving_mass, compliance, hold

ANGLES = np.array([0.0, 0.4, 1.3, 2.2, 3.6, 5.1])


def yielding(press, frame=5e9, shaft=3e7):
    """Uneven stiffnesses of every bearing, guide, frame and shaft."""
    guides = [name for name in press.joints if not press.axes[press.joints.index(name)].turns]
    numbers = iter(np.random.default_rng(7).uniform(1e9, 5e9, len(press.bearings)))
    return Stiffness({name: float(next(numbers)) for name in press.bearings}, dict.fromkeys(guides, 4e7), (), shaft, frame)


def geometry(press):
    """Crank radius and rod length of a shipped crank-slider."""
    found = as_crank_slider(press)
    return found.crank_radius, found.rod_length


def test_crank_slide_by_hand():
    """The rod carries 1 / cos(beta), the guide tan(beta), the shaft r sin(theta + beta) / cos(beta)."""
    press = texts.shipped("crank_slide")
    r, length = geometry(press)
    stiffness = Stiffness({"O": 2e9, "P": 1e9, "W": 3e9, "slide_guide": 5e8}, {}, [Rod("rod", ("P", "W"), 7e8)], 1e6, 4e9)
    found = compliance(press, stiffness, angle=ANGLES)
    beta = np.arcsin(r * np.sin(ANGLES) / length)
    along = 1 / np.cos(beta) ** 2
    by_hand = {
        "O": along / 2e9,
        "P": along / 1e9,
        "W": along / 3e9,
        "slide_guide": np.tan(beta) ** 2 / 5e8,
        "rod P-W": along / 7e8,
        "shaft": (r * np.sin(ANGLES + beta) / np.cos(beta)) ** 2 / 1e6,
        "frame": np.full(len(ANGLES), 1 / 4e9),
    }
    assert found.parts.keys() == by_hand.keys()
    for name, expected in by_hand.items():
        np.testing.assert_allclose(found.parts[name], expected, rtol=1e-11, atol=1e-24)
    assert found.bottom_stiffness == pytest.approx(1 / (1 / 2e9 + 1 / 1e9 + 1 / 3e9 + 1 / 7e8 + 1 / 4e9), rel=1e-12)
    assert sum(found.bottom_shares.values()) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("name", pp.presses())
def test_castigliano(name):
    """The deflection is the derivative of the elastic energy, a quadratic of the force on the slide: central differences are exact."""
    press = texts.shipped(name)
    stiffness = yielding(press)
    if name in ("eccentric_blocks", "jf75g_125_symmetric", "pirica_double_knuckle"):  # whose guides would share with the rods
        stiffness = replace(stiffness, moments={})
    motion = pp.servo_cycle(press, speed=9.0, angle=ANGLES)
    guide = press.slide_guide[0]
    axis = press.model.jointPlacements[guide + 1].rotation @ press.axes[guide].direction

    on_frame = {name for j, name in enumerate(press.joints, 1) if press.model.parents[j] == 0} | {
        k.name for k in press.loops if k.joint1 == 0
    }

    def energy(force):
        load = pp.loads.PointForce(press.slide, force * axis)
        found = pp.inverse_dynamics(press, motion, [load], stiffness=stiffness.bearings)
        total = found.driving_torque**2 / (2 * stiffness.shaft)
        crown = 0.0
        for bearing, k in stiffness.bearings.items():
            inside = found.bearing_force[bearing]
            if bearing in stiffness.moments:
                total = total + found.bearing_moment[bearing][:, 1] ** 2 / (2 * stiffness.moments[bearing])
            total = total + (inside[:, 0] ** 2 + inside[:, 2] ** 2) / (2 * k)
            if bearing in on_frame:
                crown = crown - inside @ axis
        return total + crown**2 / (2 * stiffness.frame)

    force = 1e5
    slope = (energy(force + 1e5) - energy(force - 1e5)) / 2e5
    expected = slide_deflection(press, motion, stiffness, loads=[pp.loads.PointForce(press.slide, force * axis)]).deflection
    np.testing.assert_allclose(slope, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


L1, L2, L31, L32, L4 = 0.143, 1.243, 0.375, 0.480, 0.480  # ZXN2-3000(B), Kong 2025
A, D = 1.25 - 0.2j, 0j


def test_displaced_pins_of_the_six_bar():
    """The same springs put into the loop equations of Kong 2025 and solved anew: the difference is of second order in the load."""
    press = texts.shipped("zxn2_3000b")
    names = ("A", "B", "C", "D", "E", "F", "slide_guide")
    stiff = {name: 1e9 * (1 + 0.2 * i) for i, name in enumerate(names)}
    rods = [Rod("coupler", ("B", "C"), 8e8), Rod("rod", ("E", "F"), 9e8), Rod("rocker", ("D", "E"), 2e9)]
    angle, load = 5.2, pp.loads.PointForce("slide", (0, 0, 2e6))
    motion = pp.servo_cycle(press, speed=7.33, angle=[angle])
    found = pp.inverse_dynamics(press, motion, [load])
    force = {name: complex(*found.bearing_force[name][0, [0, 2]]) for name in names}
    torque, crown = found.driving_torque[0], -(force["A"] + force["D"]).imag

    def along(one, another):
        return ((another - one) / abs(another - one)).conjugate()

    def solved(share):
        """Position of the slide with a share of the deflections: the child gives way against the force of the parent on it."""
        give = {name: -share * force[name] / stiff[name] for name in names}
        lift = 1j * share * crown / 6e9
        turned = angle - share * torque / 4e7
        crank = A + lift + give["A"] + L1 * np.exp(1j * turned)

        def points(x, longer):
            t2, t3, t4, y = x
            coupler = crank + give["B"]
            end_c = coupler + (L2 + longer[0]) * np.exp(1j * t2)
            pivot = D + lift + give["D"]
            end_e = pivot + (L32 + longer[2]) * np.exp(1j * (t3 - np.radians(135)))
            rod = end_e + give["E"]
            slide = 1j * y + give["slide_guide"].real
            end_f = rod + (L4 + longer[1]) * np.exp(1j * t4)
            rows = end_c + give["C"] - pivot - L31 * np.exp(1j * t3), end_f + give["F"] - slide
            return coupler, end_c, pivot, end_e, rod, end_f, rows

        def gaps(x, longer):
            return [part for gap in points(x, longer)[-1] for part in (gap.real, gap.imag)]

        rigid, none = guess, (0.0, 0.0, 0.0)
        coupler, end_c, pivot, end_e, rod, end_f, _ = points(rigid, none)
        c_half = 0.5 * (along(coupler, end_c) * (-force["C"] - force["B"])).real  # pulled by what acts outwards at the ends
        f_half = 0.5 * (along(rod, end_f) * (-force["F"] - force["E"])).real
        e_arm = (along(pivot, end_e) * -force["E"]).real
        longer = share * np.array([c_half / 8e8, f_half / 9e8, e_arm / 2e9])
        return fsolve(gaps, rigid, args=(longer,), xtol=1e-12)[3]

    crank = A + L1 * np.exp(1j * angle)
    t3 = np.angle(crank) + np.arccos((L31**2 + abs(crank) ** 2 - L2**2) / (2 * L31 * abs(crank)))
    t2 = np.angle(L31 * np.exp(1j * t3) - crank)
    end_e = L32 * np.exp(1j * (t3 - np.radians(135)))
    t4 = -np.arccos(-end_e.real / L4)
    guess = np.array([t2, t3, t4, end_e.imag + L4 * np.sin(t4)])
    assert guess[3] == pytest.approx(motion.slide_position[0], abs=1e-9)
    linear = slide_deflection(press, motion, Stiffness(stiff, {}, rods, 4e7, 6e9), loads=[load]).deflection[0]
    rigid = solved(0.0)
    errors = np.array([abs(solved(share) - rigid - share * linear) for share in (1.0, 0.5, 0.25)])
    assert abs(linear) > 2e-3
    assert errors[0] < 0.02 * abs(linear)
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.1)


def test_rod_between_pins_in_different_planes():
    """A rod that also leads across the plane yields along its line in the plane, which alone carries."""
    text = texts.shipped("crank_slide").text.decode()
    ends = '<link1 link="rod" xyz="0.400 0 0" rpy="0 0 0"/><link2 link="slide" xyz="0 0 0" rpy="0 0 0"/>'
    assert text.count(ends) == 1
    askew = texts.load(text.replace(ends, ends.replace("0.400 0 0", "0.400 0.3 0").replace('slide" xyz="0 0 0', 'slide" xyz="0 0.3 0')))
    stiffness = Stiffness({"P": 1e9}, {}, [Rod("rod", ("P", "W"), 7e8)])
    straight, found = (compliance(press, stiffness, angle=ANGLES) for press in (texts.shipped("crank_slide"), askew))
    np.testing.assert_allclose(found.compliance, straight.compliance, rtol=1e-12)


def test_two_shafts_are_twice_as_stiff():
    one, two = texts.shipped("jf75g_125_plain"), texts.shipped("jf75g_125_symmetric")
    single = compliance(one, Stiffness({"O": 2e9, "P2": 1e9, "P4": 3e9}, {}, [Rod("main_rod", ("P2", "P4"), 7e8)]), angle=ANGLES)
    halves = {f"{name}_{side}": k for name, k in (("O", 2e9), ("P2", 1e9), ("P4", 3e9)) for side in ("left", "right")}
    rods = [Rod(f"main_rod_{side}", (f"P2_{side}", f"P4_{side}"), 7e8) for side in ("left", "right")]
    double = compliance(two, Stiffness(halves, {}, rods), angle=ANGLES)
    np.testing.assert_allclose(single.compliance, 2 * double.compliance, rtol=1e-11)
    assert double.bottom_stiffness == pytest.approx(2 * single.bottom_stiffness, rel=1e-12)


def test_uneven_rods_side_by_side():
    """Springs in series in each of two paths, which are parallel."""
    press = texts.shipped("jf75g_125_two_point")
    stiff = {"O": 4e9, "P2_front": 1e9, "P2_back": 2e9, "P4_front": 3e9, "P4_back": 5e9}
    rods = [Rod("main_rod_front", ("P2_front", "P4_front"), 6e8), Rod("main_rod_back", ("P2_back", "P4_back"), 2e9)]
    paths = 1 / (1 / 1e9 + 1 / 3e9 + 1 / 6e8) + 1 / (1 / 2e9 + 1 / 5e9 + 1 / 2e9)
    beta = np.arcsin(0.05 * np.sin(ANGLES))
    found = compliance(press, Stiffness(stiff, {}, rods), angle=ANGLES)
    np.testing.assert_allclose(found.compliance, (1 / 4e9 + 1 / paths) / np.cos(beta) ** 2, rtol=1e-9)


def test_soft_springs_are_warned_of_once():
    with pytest.warns(pp.PinpressWarning, match="Stiffness: the largest of bearings is 2e\\+06 N/m") as caught:
        compliance(texts.shipped("jf75g_125_plain"), Stiffness(dict.fromkeys(("O", "P2", "P4"), 2e6)), angle=[0.0])
    assert len(caught) == 1


def test_guides_that_would_share_with_the_rods():
    """Symmetric halves leave nothing for the guide to hold; uneven ones would turn the slide in it."""
    press = texts.shipped("jf75g_125_symmetric")
    even = Stiffness({"P4_left": 1e9, "P4_right": 1e9}, {"slide_guide": 1e7})
    assert compliance(press, even, angle=ANGLES).bottom_stiffness == pytest.approx(2e9, rel=1e-12)
    with pytest.raises(pp.PinpressError, match="make both sides alike"):
        compliance(press, replace(even, bearings={"P4_left": 1e9, "P4_right": 2e9}), angle=ANGLES)


BEVEL = """<link name="cross"><inertial><mass value="1e-9"/>
<inertia ixx="1e-12" ixy="0" ixz="0" iyy="1e-12" iyz="0" izz="1e-12"/></inertial>
</link><joint name="bevel" type="continuous"><parent link="frame"/><child link="cross"/><origin xyz="1 0 0"/><axis xyz="1 0 0"/>
<mimic joint="{0}"/></joint></robot>"""


@pytest.mark.exhaustive
def test_sharing_is_looked_at_in_presses_that_are_not_planar():
    """The same press with a shaft across its plane, which carries nothing."""
    planar = texts.shipped("jf75g_125_symmetric")
    press = texts.load(planar.text.decode().replace("</robot>", BEVEL.format(planar.driver)))
    assert "plane" not in press.engines
    even = Stiffness({"P4_left": 1e9, "P4_right": 1e9}, {"slide_guide": 1e7})
    assert compliance(press, even, angle=[0.4]).compliance[0] == pytest.approx(
        compliance(planar, even, angle=[0.4]).compliance[0], rel=1e-9
    )
    with pytest.raises(pp.PinpressError, match="make both sides alike"):
        compliance(press, replace(even, bearings={"P4_left": 1e9, "P4_right": 2e9}), angle=[0.4])


def mass_of(press, stiffness, angles):
    held = hold(press, springs_of(press, stiffness), pp.servo_cycle(press, speed=0.0, angle=angles))
    return _moving_mass(held) / np.sum(list(held.moved(held.unit).values()), axis=0) ** 2


def test_effective_mass_of_single_springs():
    """The slide alone above its pin; all that moves at dead centre on the shaft's bearing; on the shaft's spring the reduced inertia."""
    press = texts.shipped("crank_slide")
    r, length = geometry(press)
    slide, rod = (press.model.inertias[press.model.getJointId(name)] for name in ("slide_guide", "P"))
    sine = r * np.sin(ANGLES) / length
    turning = rod.inertia[1, 1] + rod.mass * rod.lever @ rod.lever  # about P: the rod turns so that the slide's pin stays on its line
    found = compliance(press, Stiffness({"W": 1e9}), angle=ANGLES)
    np.testing.assert_allclose(found.effective_mass, slide.mass + turning * sine**2 / length**2, rtol=1e-12)
    moving = sum(inertia.mass for inertia in list(press.model.inertias)[1:])
    assert compliance(press, Stiffness({"O": 1e9}), angle=[0.0]).effective_mass[0] == pytest.approx(moving, rel=1e-12)
    for name in ("crank_slide", "zxn2_3000b", "jf75g_125_two_point"):
        press, angles = texts.shipped(name), np.array([0.7, 2.0, 4.4])
        motion = pp.servo_cycle(press, speed=1.0, angle=angles)
        data = press.model.createData()
        energy = [pin.computeKineticEnergy(press.model, data, q, v) for q, v in zip(np.array(motion.q), np.array(motion.v), strict=True)]
        expected = 2 * np.array(energy) / motion.slide_velocity**2
        np.testing.assert_allclose(mass_of(press, Stiffness(shaft=1e7), angles), expected, rtol=1e-8)
