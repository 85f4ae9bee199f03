"""How loops turn, on which their friction depends: about their own axes, and not at all where that is rounding."""

import numpy as np
import pytest
from support import texts
from support.generators.redundant_linkages import three_cranks
from support.generators.spatial_crank_slide import SPATIAL
from support.generators.spatial_linkages import Drawing, four_bar

import pinpress as pp
from pinpress.engines.wrenches import AppliedConditions
from pinpress.loads.link import Friction

ENGINES = ("space", "pinocchio")


def loads_at(press, engine, angles):
    states = pp.servo_cycle(press, angles, speed=1.0, acceleration=0.0).states(press)
    return press.engine(engine).bearing_loads(states, AppliedConditions([], None, None), states.v)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_speed_of_a_revolute_loop_is_smooth_where_it_turns_back(engine):
    press = texts.load(four_bar("revolute"))
    angles = np.linspace(0.0, 2 * np.pi, 181)
    found = loads_at(press, engine, angles)
    loop = press.bearings.index("C")
    speed, radial = found.speed[loop], found.radial[loop]
    assert speed.min() < -0.1 < 0.1 < speed.max()
    # a magnitude would have a corner, and the vector across it a step
    assert np.abs(np.diff(speed, 2)).max() < 0.1 * np.abs(np.diff(speed)).max()
    assert np.abs(np.diff(radial, axis=0)).max() < 0.1 * np.ptp(radial, axis=0).max()


def table():
    """Three parallel cranks carry a coupler, on which a table stands by a ball; two guides keep the table from turning."""
    drawing = three_cranks(0.2)
    at = 0.6 + 0.3j + 0.3 * np.exp(0.5j)
    drawing.joint("X", "frame", "carriage", at, along=1 + 0j)
    drawing.joint("Z", "carriage", "table", at, along=1j)
    drawing.loop("T", "coupler", "table", at)
    for link in ("carriage", "table"):
        drawing.body(link, 2.0, at)
    return drawing.urdf("O")


@pytest.mark.parametrize("engine", ENGINES)
def test_a_ball_between_links_that_do_not_turn_rests(engine):
    press = texts.load(table())
    found = loads_at(press, engine, np.linspace(0.0, 6.0, 37))
    loop = press.bearings.index("T")
    assert not found.speed[loop].any()
    assert not found.radial[loop].any()
    assert np.abs(found.speed[press.bearings.index("H")]).min() > 0.5


def lid():
    """A slide in space whose lid is shut by two hinges with different axes."""
    link = '<link name="lid"><inertial><mass value="1"/><inertia ixx=".1" ixy="0" ixz="0" iyy=".1" iyz="0" izz=".1"/></inertial></link>'
    hinge = '<joint name="A" type="continuous"><parent link="slide"/><child link="lid"/><axis xyz="1 0 0"/></joint>'
    other = (
        '<loop_joint name="B" type="revolute"><link1 link="slide" xyz=".1 .2 0"/><link2 link="lid" xyz=".1 .2 0"/>'
        '<axis xyz="0 1 0"/></loop_joint>'
    )
    return SPATIAL.replace("</robot>", f"{link}{hinge}{other}</robot>")


@pytest.mark.exhaustive
def test_a_shut_lid_takes_no_power():
    press, open_press = texts.load(lid()), {"O": Friction(0.1, 0.02), "W": Friction(0.1, 0.02)}
    runs = [pp.simulate(press, 0.1, speed=5.0, friction=friction) for friction in (open_press, open_press | {"A": Friction(0.1, 0.02)})]
    np.testing.assert_allclose(runs[1].crank_angle, runs[0].crank_angle, rtol=0, atol=1e-10)
    assert runs[0].lost[-1] > 0.0


def swinging_strut():
    """A strut between two balls, one of them three pins, whose last pin swings it about the line through both. The hinge H rests."""
    drawing = Drawing("strut", seed=2)
    foot, hinge, top = np.array([0.1, 0.2, 0.0]), np.array([0.5, 0.1, 0.4]), np.array([0.7, 0.6, 0.3])
    axes = np.linalg.qr(np.array([[0.5, 0.2, -0.8], [0.1, 0.9, 0.2], [0.7, -0.3, 0.4]]))[0]
    links = ["frame", "fork", "cross", "strut"]
    for k, name in enumerate("ABC"):
        drawing.joint(name, links[k], links[k + 1], foot, axes[k])
        drawing.body(links[k + 1], 1.0, foot + 0.1 * axes[k], 0.2)
    drawing.joint("H", "strut", "head", hinge, np.array([0.6, 0.0, 0.8]))
    drawing.body("head", 2.0, 0.5 * (hinge + top), 0.2)
    drawing.loop("T", "spherical", "head", "frame", top)
    return drawing.urdf("C")


@pytest.mark.exhaustive
def test_a_hinge_that_rests_rubs_in_no_run():
    """Near the locks of the strut the fastest pins have no bounds, and what rounding leaves of the hinge's speed has none either."""
    press = texts.load(swinging_strut())
    assert any(press.branch.locks)
    friction = {name: Friction(0.03, 0.02) for name in press.bearings}
    run = pp.simulate(press, 0.1, speed=0.5, friction=friction, points=21)
    torque = pp.inverse_dynamics(press, run, friction=friction).driving_torque
    assert np.abs(torque).max() < 1e-8
