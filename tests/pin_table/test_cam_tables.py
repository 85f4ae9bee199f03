"""Cams in pin tables: what becomes of the three examples, and refusals at the line of the table."""

import copy
from typing import Any

import numpy as np
import pytest
from support import cams

import pinpress as pp

PLACES = np.radians([0.0, 45.0, 90.0, 200.0])


@pytest.mark.parametrize(
    ("name", "joint", "moved"),
    [
        ("ejector", "ejector_guide", [0.0, 0.02, 0.04, 0.04 - 0.04 * (10 * (2 / 11) ** 3 - 15 * (2 / 11) ** 4 + 6 * (2 / 11) ** 5)]),
        ("feeder", "B", [0.0, -np.radians(15) * (10 * 0.45**3 - 15 * 0.45**4 + 6 * 0.45**5), None, None]),
        ("drawing_press", "holder_guide", [0.0, 0.0, None, -0.06]),
    ],
)
def test_followers_obey_their_laws(name, joint, moved):
    """In metres and radians from the drawn pose; the arm turns clockwise, the blank holder goes down as its lift rises."""
    press = cams.press(name)
    angles = PLACES if name != "drawing_press" else np.radians([0.0, 20.0, 45.0, 180.0])
    found = pp.servo_cycle(press, angles, speed=0.0, acceleration=0.0).joint_position[:, press.joints.index(joint)]
    for value, expected in zip(found, moved, strict=True):
        assert expected is None or value == pytest.approx(expected, abs=1e-14)


def table(**changes):
    found = copy.deepcopy(cams.EJECTOR)
    found["cams"]["eject"].update(changes)
    return found


def test_a_guide_names_its_link():
    assert pp.build(**table(follower="ejector_guide")).text == cams.press("ejector").text


def test_a_drawn_roller_says_offset_or_arm():
    """The pin at its centre is in place of the offset, and of the arm."""
    drawn, feeder = table(at="E"), copy.deepcopy(cams.FEEDER)
    del drawn["cams"]["eject"]["offset"]
    ejector: Any = pp.build(**drawn).contacts[0]
    with_arm: Any = cams.press("feeder").contacts[0]
    assert (ejector.offset, with_arm.arm) == pytest.approx((0.01, 0.12), rel=1e-14)
    del feeder["cams"]["feed"]["at"]
    plain: Any = pp.build(**copy.deepcopy(feeder) | {"cams": {"feed": feeder["cams"]["feed"] | {"arm": 120}}}).contacts[0]
    assert (plain.sense, plain.turning) == (1.0, 1.0)  # the lift is along the arm's own angle, against that of the drawn arm


def test_tables_of_lifts():
    lifts = [[angle, 20.0 * (1.0 - np.cos(np.radians(angle)))] for angle in range(0, 360, 10)]
    plain = table(lifts=lifts)
    del plain["cams"]["eject"]["law"]
    found = pp.cycle(pp.build(**plain), 1.0, points=36)
    np.testing.assert_allclose(found.joint_position[:, 1], 0.02 * (1.0 - np.cos(found.crank_angle)), atol=1e-8)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"law": [[0, 0], {"3-4-5": [90, 40]}]}, "cams: eject: its law is not closed: the lift is 0.04 m at 90 deg"),
        (
            {"law": [[0, 0], [200, 0], [290, 40], [300, 40], {"3-4-5": [350, 0]}]},
            "speed jumps at 200 deg: 0 to 0.0254648 m/rad; write a law",
        ),
        ({"law": [[0, 0], {"3-4-6": [90, 40]}]}, "cams: eject: law: 2: no motion law '3-4-6', did you mean '3-4-5'"),
        ({"law": [[0, 0], {"cubic": [90, 40], "sine": [90, 40]}]}, "law: 2: a piece with 2 laws"),
        ({"law": [[0, 0, 0]]}, "law: 1: 3 numbers; write angle and lift"),
        ({"lifts": [[0, 0]]}, "it needs a law or a table of lifts, one of the two"),
        ({"radius": 10}, "its radius is 0.01 m, not more than the offset 0.01 m"),
        ({"at": "E"}, "the centre of its roller is given twice"),
        ({"at": "O"}, "at: no pin O of ejector; name one of E"),
        ({"roller": 40}, "roller: 1 lengths; write diameter x width"),
        ({"roller": "40 x -3"}, "roller: a length of the roller of -3"),
        ({"kind": "closed"}, "kind: 'closed' is not a word here; write open or groove"),
        ({"follower": "ejektor"}, "no link ejektor, did you mean 'ejector'"),
        ({"rise": 3}, "'rise' is no key here"),
    ],
)
def test_refused(changes, message):
    with pytest.raises(pp.PinTableError, match=message):
        pp.build(**table(**changes))


def test_copies_have_their_rollers_in_front_and_behind():
    """Two ejectors on one camshaft: each guide is loaded in its own plane, and together they bend the shaft in none."""
    copied = table() | {"copies": [{"links": "ejector", "y": [-100, 100], "names": "_front _back"}]}
    press = pp.build(**copied, slide="ejector_front")
    motion = pp.cycle(press, 5.0, points=12)
    reactions, one = (
        pp.inverse_dynamics(press, motion),
        pp.inverse_dynamics(cams.press("ejector"), pp.cycle(cams.press("ejector"), 5.0, points=12)),
    )
    for name, y in (("_front", -0.1), ("_back", 0.1)):
        np.testing.assert_allclose(reactions.bearing_force[f"eject{name}"], one.bearing_force["eject"], atol=1e-9)
        np.testing.assert_allclose(reactions.bearing_moment[f"ejector_guide{name}"], one.bearing_moment["ejector_guide"], atol=1e-9)
        contact: Any = next(each for each in press.contacts if each.name == f"eject{name}")
        assert contact.origin[1] == pytest.approx(y, abs=1e-15)
    np.testing.assert_allclose(reactions.bearing_moment["O"][:, [0, 2]], 0.0, atol=1e-9)


def test_refused_copies():
    mirrored = table() | {"copies": [{"links": "ejector", "mirror": "x", "names": "_l _r"}]}
    with pytest.raises(pp.PinTableError, match="a mirror image of it would turn the other way"):
        pp.build(**mirrored)
    with pytest.raises(pp.PinTableError, match="no roller; give diameter x width"):
        pp.build(**table() | {"cams": {"eject": {"cam": "camshaft", "follower": "ejector", "radius": 80}}})
