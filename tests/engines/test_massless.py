"""Links between two bearings that are meant to have no mass: a Hooke joint's cross piece in closed form, rods, and what nothing resists."""

import math

import numpy as np
import pytest
from support import texts
from support.generators import large_linkages
from support.texts import NOTHING, without_mass

import pinpress as pp

BEND = 0.5  # angle between the shafts of the Hooke joint [rad]
ROTOR = '<inertial><mass value="3"/><inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.2"/></inertial>'
ANGLES = np.linspace(0.1, 6.2, 12)


def hooke(cross=NOTHING, driven=ROTOR, bend=BEND):
    """Shafts along x and at an angle to it in the x-y plane, through the world origin, with a cross piece between their forks."""
    out = f"{math.cos(bend)!r} {math.sin(bend)!r} 0"
    return f"""<robot name="hooke"><link name="frame"/>
      <link name="driving">{ROTOR}</link><link name="cross">{cross}</link><link name="driven">{driven}</link>
      <joint name="O" type="continuous"><parent link="frame"/><child link="driving"/><axis xyz="1 0 0"/></joint>
      <joint name="A" type="continuous"><parent link="driving"/><child link="cross"/><axis xyz="0 1 0"/></joint>
      <joint name="B" type="continuous"><parent link="cross"/><child link="driven"/><axis xyz="0 0 1"/></joint>
      <loop_joint name="S" type="revolute"><link1 link="frame"/><link2 link="driven"/><axis xyz="{out}"/></loop_joint>
      <transmission name="drive"><joint name="O"/></transmission></robot>"""


@pytest.fixture(scope="module")
def joint():
    return large_linkages.load(hooke())


def transmission(angle):
    """Of the driven shaft, per speed of the driving one, and its derivative by the angle; the driving shaft's fork starts along y, in the
    plane of both shafts."""
    below = 1 - (np.sin(BEND) * np.cos(angle)) ** 2
    ratio = np.cos(BEND) / below
    return ratio, -ratio / below * np.sin(BEND) ** 2 * np.sin(2 * angle)


@pytest.mark.exhaustive
def test_hooke_joint_in_closed_form(joint):
    """The torque accelerates both shafts; the cross piece needs none."""
    w, alpha = 9.0, -4.0
    ratio, rate = transmission(ANGLES)
    motion = pp.servo_cycle(joint, angle=ANGLES, speed=w, acceleration=alpha)
    result = pp.inverse_dynamics(joint, motion)
    expected = 0.2 * alpha + 0.2 * ratio * (ratio * alpha + rate * w**2)
    np.testing.assert_allclose(result.driving_torque, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    assert np.abs(result.power_residual).max() < 1e-12
    for name in joint.bearings:
        assert np.isfinite(result.bearing_force[name]).all()
        assert np.isfinite(result.bearing_moment[name]).all()


@pytest.mark.exhaustive
def test_hooke_joint_keeps_its_energy(joint, method):
    run = pp.simulate(joint, 1.0, speed=9.0, method=method, points=50)
    ratio, _ = transmission(run.crank_angle)
    start, _ = transmission(np.zeros(1))
    energy = 0.1 * (1 + ratio**2) * run.crank_speed**2
    np.testing.assert_allclose(energy, 0.1 * (1 + start[0] ** 2) * 81.0, rtol=1e-9)


def test_rod_without_mass_pulls_along_itself(engine):
    """Of the textbook press: its force at either end is along the line of its pins, and the same."""
    press = large_linkages.load(without_mass(texts.shipped("crank_slide").text.decode(), "rod"))
    result = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=ANGLES, speed=9.0, engine=engine), engine=engine)
    force = result.bearing_force["P"]
    np.testing.assert_allclose(force, result.bearing_force["W"], atol=1e-9 * np.abs(force).max())
    crank_pin = 0.1 * np.stack([np.sin(ANGLES), -np.cos(ANGLES)])
    rod = np.stack([-crank_pin[0], -np.sqrt(0.4**2 - crank_pin[0] ** 2)])
    across = rod[0] * force[:, 2] - rod[1] * force[:, 0]
    assert np.abs(across).max() < 1e-12 * np.abs(force).max()


def test_runs_with_a_rod_without_mass(method):
    """As those with a rod of next to none."""
    text = texts.shipped("crank_slide").text.decode()
    light = NOTHING.replace('"0"', '"1e-12"', 1)
    weightless, nearly = (
        large_linkages.load(one) for one in (without_mass(text, "rod"), without_mass(text, "rod").replace(NOTHING, light))
    )
    runs = [
        pp.simulate(press, 0.5, speed=9.0, flywheel=pp.drives.Flywheel(20.0), method=method, points=20) for press in (weightless, nearly)
    ]
    np.testing.assert_allclose(runs[0].crank_angle, runs[1].crank_angle, atol=1e-9)


def test_what_nothing_resists_is_named():
    """Without a mass anywhere, or where the only mass does not move."""
    everything = without_mass(texts.shipped("crank_slide").text.decode(), "crank", "rod")
    at_dead_centre = large_linkages.load(everything)  # the slide has mass, and is drawn where it turns back: it will move
    assert np.isfinite(pp.inverse_dynamics(at_dead_centre, pp.cycle(at_dead_centre, 9.0)).driving_torque).all()
    with pytest.raises(pp.UrdfError, match="moves without a mass, as do all links that move with it") as caught:
        large_linkages.load(hooke(driven=NOTHING).replace(ROTOR, NOTHING))
    assert caught.value.element == '<link name="driving">'


OF_ONE_BEARING = large_linkages.gear_train(1).replace(large_linkages.BODY.partition("/>")[2].removesuffix("</inertial>"), NOTHING[10:-11])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (hooke(driven=NOTHING.replace('ixx="0"', 'ixx="0.1"')), "not positive"),  # moments of inertia without a mass
        (OF_ONE_BEARING, "the mass 0.0 of a moving link is not positive"),
    ],
)
def test_only_what_is_meant_has_no_mass(text, message):
    with pytest.raises(pp.UrdfError, match=message):
        large_linkages.load(text)
