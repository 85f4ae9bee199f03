"""Both engines offer the same, and agree; nobody above them asks which of them there is."""

import dataclasses
import inspect
from pathlib import Path

import numpy as np
import pytest
from support import texts
from support.generators.spatial_linkages import four_bar

import pinpress as pp
from pinpress.engines.energies import energies, power_balance
from pinpress.engines.engine import ClosedStates, Engine
from pinpress.engines.pinocchio.engine import PinocchioEngine
from pinpress.engines.planar.engine import PlanarEngine
from pinpress.engines.spatial.engine import SpatialEngine
from pinpress.engines.wrenches import AppliedForce

PRESSES = ["crank_slide", "zxn2_3000b", "jf75g_125_symmetric", "thin_wall"]
SPEED = 7.0
OFFERED = sorted(name for name, member in vars(Engine).items() if name[0] != "_" and (callable(member) or isinstance(member, property)))


@pytest.fixture(scope="module", params=PRESSES)
def press(request):
    return pp.load(request.param)


@pytest.fixture(scope="module")
def states(press):
    motion = pp.cycle(press, speed=SPEED, points=24)
    return ClosedStates(motion.joint_position.T, motion.v.T, motion.a.T)


@pytest.fixture(params=["plane", "space"])
def both(request, press):
    """An engine that works on all states at once, and Pinocchio's."""
    return press.engine(request.param), press.engine("pinocchio")


@pytest.mark.parametrize("kind", [PlanarEngine, SpatialEngine, PinocchioEngine])
def test_an_engine_offers_what_the_interface_names_and_takes_the_same(kind):
    for name in OFFERED:
        asked = getattr(Engine, name)
        if callable(asked):
            assert list(inspect.signature(getattr(kind, name)).parameters) == list(inspect.signature(asked).parameters), name
        else:
            assert hasattr(kind, name) or name in [field.name for field in dataclasses.fields(kind)], name
    further = {name for name, member in vars(kind).items() if not name.startswith("_") and callable(member)} - set(OFFERED)
    assert further <= {"of"}, "what one engine alone offers is asked of no engine"


def test_chosen_by_name(press):
    assert press.engines == ("plane", "space", "pinocchio")
    assert press.engine() is press.engine("auto") is press.engine("plane")
    assert [press.engine(name).name for name in press.engines] == list(press.engines)
    assert press.engine("pinocchio") is press.engine("pinocchio")
    for wrong in ("planar", None, 3):
        with pytest.raises(pp.PinpressError, match="unknown engine"):
            press.engine(wrong)


def test_a_linkage_in_space_has_two():
    press = texts.load(four_bar("fixed"))
    assert press.engines == ("space", "pinocchio")
    assert press.engine().name == "space"
    with pytest.raises(pp.PinpressError, match="not a planar linkage"):
        press.engine("plane")
    with pytest.raises(pp.PinpressError, match="because"):
        press.plane_or_refuse("because")


def test_closing_along_a_way_is_closing_by_angle_in_other_units(press, both):
    start, along = press.closed[:, None], np.array([[2.5]])
    for engine in both:
        by_angle, by_way = engine.close(np.zeros(1), start), engine.closing_function()(np.zeros((1, 1)), along, start)
        np.testing.assert_array_equal(by_way.position, by_angle.position)
        np.testing.assert_allclose(by_way.first, 2.5 * by_angle.first, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(by_way.second, 2.5**2 * by_angle.second, rtol=1e-9, atol=1e-9)


def test_points_energies_and_power_agree(press, states, both):
    joint, point = len(press.joints), np.array([0.03, 0.0, 0.07])
    load = AppliedForce(joint, point, np.tile([10.0, 0.0, -500.0], (24, 1)))
    one, other = both
    for first, second in (
        (one.body_motion(states, [joint]), other.body_motion(states, [joint])),
        (one.body_motion(states, [joint]).points(point[None]), other.body_motion(states, [joint]).points(point[None])),
        (energies(one, states), energies(other, states)),
    ):
        for mine, theirs in zip(first, second, strict=True):
            size = max(np.abs(theirs).max(), 1e-3)
            np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-9 * size)
    mine, theirs = (power_balance(engine, states, [load]) for engine in (one, other))
    np.testing.assert_allclose(mine.balance, theirs.balance, rtol=0, atol=1e-9 * theirs.total.max())


def test_what_links_can_do_is_said_in_the_world_and_in_a_joint(press):
    plane, space = press.engine("plane"), press.engine("space")
    np.testing.assert_array_equal(space.directions, np.eye(3))
    np.testing.assert_allclose(plane.directions @ plane.turning_axes()[0], 0.0, atol=1e-15)
    for joint in range(1, press.model.njoints):
        assert plane.turning_axes(joint).shape == (1, 3)
        assert np.linalg.norm(plane.turning_axes(joint)) == pytest.approx(1.0, abs=1e-14)


def test_every_loop_is_closed_once(press, both):
    for engine in both:
        order = list(engine.closing_order())
        assert sorted(k for k, _ in order) == list(range(len(press.loops) + len(press.couplings)))


def test_a_loop_without_lengths_moves():
    """An eccentric press without an eccentricity: gear and slide guide are what is left."""
    press = pp.build(Path(pp.__file__).parent / "pin_table" / "templates" / "eccentric-block.yaml", e=0)
    assert np.ptp(pp.cycle(press, 1.0, points=8).slide_position) == 0
