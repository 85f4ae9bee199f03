"""Sets of lengths followed to their ends, one at a time, against closed forms of a crank-slide.

A set that is followed among many others takes as many steps as the slowest of them, which would hide that one is stopped too early.
"""

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.derivatives import pivot_positions
from pinpress.derivatives.motion import directed
from pinpress.tolerances.sets_of_lengths.endings import Ending, follow_to_end, shapes_of

R, L = 0.1, 0.4  # of the shipped crank-slide, drawn at bottom dead centre [m]
DEVIATIONS = np.geomspace(1e-4, 6e-2, 60)


@pytest.fixture(scope="module")
def press():
    return texts.shipped("crank_slide")


def alone(press, key, vector=None):
    """The press with one dimension: a pin that moves along a vector, by default away from the origin of its link."""
    away = pivot_positions(press)[key]
    return shapes_of(press, [directed(press, {key: away / np.linalg.norm(away) if vector is None else vector})])


def test_dead_centres_of_a_guide_beside_the_shaft(press):
    """The bottom is at sqrt((r + l)^2 - e^2), the crank turned by asin(e / (r + l)), of which first order leaves the third power of e."""
    shapes, start = alone(press, ("slide_guide", "frame"), (1.0, 0.0, 0.0)), press.closed
    at = pp.servo_cycle(press, [0.0], speed=1.0)
    assert (at.joint_position[0], at.slide_position[0]) == (pytest.approx(start, abs=1e-15), pytest.approx(-(R + L), abs=1e-15))
    ending = Ending(start, np.array([1.0 / (R + L)]), "dead centre")
    for e in DEVIATIONS:
        ended = follow_to_end(shapes, np.array([[e]]), ending)
        assert ended.sound.all()
        assert ended.position[0] == pytest.approx(-np.sqrt((R + L) ** 2 - e * e), abs=4e-16)
        assert abs(ended.rate[0]) < 1e-9


def test_heights_of_a_crank_that_is_longer(press):
    """By the law of cosines; the slide's travel per angle too."""
    shapes, h = alone(press, ("P", "crank")), 0.05

    def at_height(r):
        s = r + L - h
        cosine = (s * s + r * r - L * L) / (2 * r * s)
        sine = np.sqrt(1 - cosine**2)
        return np.arccos(cosine), -r * sine * (1 + r * cosine / np.sqrt(L * L - (r * sine) ** 2))

    angle, rate = at_height(R)
    state = pp.servo_cycle(press, [-angle], speed=1.0)
    assert state.slide_velocity[0] == pytest.approx(rate, rel=1e-13)
    by = 1e-6
    ending = Ending(state.joint_position[0], -np.array([(at_height(R + by)[0] - at_height(R - by)[0]) / (2 * by)]), "height")
    for d in DEVIATIONS[DEVIATIONS < 0.03]:  # longer ones are too far from first order to be known for the same assembly
        low = -(R + d + L)
        ended = follow_to_end(shapes, np.array([[d]]), ending._replace(target=np.array([low + h])))
        assert ended.sound.all()
        assert (ended.position[0], ended.rate[0]) == (pytest.approx(low + h, abs=4e-16), pytest.approx(at_height(R + d)[1], rel=1e-13))

    for off in (1e-6, 2e-6, 4e-6):  # a start that is nearly there is not there yet
        d = 1e-12
        nearly = ending._replace(angle_slopes=np.array([off / d]), target=np.array([-(R + d + L) + h]))
        ended = follow_to_end(shapes, np.array([[d]]), nearly)
        assert ended.rate[0] == pytest.approx(at_height(R + d)[1], rel=1e-13)


def test_held_drivers_stand_still(press):
    """The crank at rest, a quarter of a turn after bottom dead centre: the rod's length alone moves the slide."""
    shapes = alone(press, ("W", "rod"))
    ending = Ending(pp.servo_cycle(press, [np.pi / 2], speed=0.0).joint_position[0], np.zeros(1), "held")
    for d in DEVIATIONS:
        ended = follow_to_end(shapes, np.array([[d]]), ending)
        assert ended.sound.all()
        assert ended.position[0] == pytest.approx(-np.sqrt((L + d) ** 2 - R * R), abs=4e-16)


def test_a_set_that_cannot_be_closed_is_not_sound(press):
    """A rod shorter than the crank: the others of its piece are followed all the same."""
    shapes = alone(press, ("W", "rod"))
    ending = Ending(pp.servo_cycle(press, [np.pi / 2], speed=0.0).joint_position[0], np.zeros(1), "held")
    ended = follow_to_end(shapes, np.array([[-0.35, 0.001]]), ending)
    assert ended.sound.tolist() == [False, True]
    assert ended.position[1] == pytest.approx(-np.sqrt(0.401**2 - R * R), abs=4e-16)
