"""`Linkage.configuration`: Pinocchio's q with the loops closed, of one driver and of several."""

import numpy as np
import pytest
from support import texts
from support.generators.random_linkages import four_bar
from support.oracles import cassie

import pinpress as pp

SEVERAL = 0.05 * np.sin(np.arange(24.0)).reshape(2, 12)


@pytest.fixture(scope="module")
def legs():
    return texts.load(cassie.urdf())


@pytest.mark.parametrize("name", pp.presses())
def test_of_shipped_presses_it_is_that_of_the_motion(name):
    press = texts.shipped(name)
    motion = pp.cycle(press, speed=1.0, points=7)
    found = press.configuration(motion.crank_angle)
    np.testing.assert_allclose(found, motion.q, rtol=0, atol=1e-14)  # sines by another way where joints are closed by roots
    one = press.configuration(motion.crank_angle[3])
    assert (one.shape, found.shape) == ((press.model.nq,), (7, press.model.nq))
    np.testing.assert_allclose(one, motion.q[3], rtol=0, atol=1e-14)
    np.testing.assert_array_equal(press.configuration([motion.crank_angle[3]])[0], one)


def test_of_several_drivers_it_is_followed(legs):
    motion = pp.servo_cycle(legs, angle=SEVERAL, speed=1.0)
    np.testing.assert_array_equal(legs.configuration(SEVERAL), motion.q)
    np.testing.assert_array_equal(legs.configuration(SEVERAL[0]), motion.q[0])


def test_result_is_the_callers_own():
    press = texts.shipped("crank_slide")
    before = press.configuration(0.3)
    changed = press.configuration([0.3, 0.4])
    changed[:] = before[:] = 0.0
    assert np.abs(press.configuration(0.3)).max() > 0.1


@pytest.mark.parametrize("angle", [0.1, np.zeros(3), np.zeros((0, 12)), np.zeros((2, 3))])
def test_other_shapes_of_several_drivers_are_refused(legs, angle):
    with pytest.raises(pp.PinpressError, match=r"angle has shape .*: give \(12,\) or \(n, 12\), the angles of all drivers \[rad\]"):
        legs.configuration(angle)


SHAPE = r"angle has shape .*: give one angle or \(n,\) angles \[rad\]"


@pytest.mark.parametrize(
    ("angle", "problem"),
    [
        *((angle, SHAPE) for angle in ([], [[0.1]], np.zeros((2, 2)))),
        *((angle, "angle") for angle in (np.nan, "0.3", None)),
        (1e8, "turns away"),
    ],
)
def test_what_is_no_angle_is_refused(angle, problem):
    with pytest.raises(pp.PinpressError, match=problem):
        texts.shipped("crank_slide").configuration(angle)


def test_a_linkage_that_locks_says_where():
    """A four-bar of 1, 0.9, 0.7 and 0.6 m, where coupler and rocker are in a line."""
    press = texts.load(four_bar(1.0, 0.9, 0.7, 0.6, 1.0).urdf("O"))
    with pytest.raises(pp.SingularityError, match="locks") as caught:
        press.configuration(3.0)
    stretched = np.arccos((1.0 + 0.9**2 - (0.7 + 0.6) ** 2) / (2 * 0.9))
    assert caught.value.crank_angle == pytest.approx(stretched - 1.0, abs=1e-6)
