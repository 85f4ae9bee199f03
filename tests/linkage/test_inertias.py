"""Inertias that no body has are refused, however a linkage is made or changed."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

import pinpress as pp
from pinpress.linkage.linkage import first_unphysical

SOUND = pin.Inertia(300.0, np.zeros(3), np.eye(3))


def inertia(mass=300.0, moments=(1.0, 1.0, 1.0)):
    """One that Pinocchio makes without a look at its moments."""
    made = pin.Inertia.Zero()
    made.mass, made.inertia = mass, np.diag(moments)
    return made


IMPOSSIBLE = {
    "mass below zero": (inertia(mass=-300.0), "a mass of -300 kg"),
    "triangle": (inertia(moments=(1.0, 1.0, 5.0)), "principal moments of inertia of 1, 1 and 5 kg m2, which no body has"),
    "not a number": (inertia(mass=np.nan), "not finite"),
    "infinite": (inertia(mass=np.inf), "not finite"),
    "place": (pin.Inertia(300.0, np.array([0.0, np.nan, 0.0]), np.eye(3)), "not finite"),
}


@pytest.fixture(scope="module")
def press():
    return pp.load("jf75g_125_plain")


def replaced(press, bodies):
    model = press.model.copy()
    for joint, body in enumerate(bodies):
        model.inertias[joint] = body
    return dataclasses.replace(press, model=model)


@pytest.mark.parametrize("change", [lambda press, bodies: press.with_inertias(bodies), replaced], ids=["with_inertias", "replace"])
@pytest.mark.parametrize("which", IMPOSSIBLE)
@pytest.mark.parametrize("place", [0, 2, -1])
def test_no_changed_press_has_them(press, change, which, place):
    bodies = list(press.model.inertias)
    bodies[place], said = IMPOSSIBLE[which]
    link = press.link_of(range(len(bodies))[place])
    where = "" if which in ("not a number", "place") else f"{press.name}: link {link!r}, .* has .*"
    with pytest.raises(pp.PinpressError, match=f"{where}{said}"):
        change(press, bodies)


def test_lamina_point_and_nothing_are_bodies(press):
    bodies = [inertia(moments=(1.0, 2.0, 3.0)), inertia(moments=(0.0, 0.0, 0.0)), inertia(0.0, (0.0, 0.0, 0.0)), SOUND]
    assert first_unphysical(bodies) is None
    bodies = (bodies * 5)[: press.model.njoints]
    assert press.with_inertias(bodies).model.inertias[1].mass == 300.0


def test_a_moment_below_zero_is_no_bodys_but_rounding_of_files_passes():
    """Pinocchio makes no such inertia, but may be given one in other ways. Moments are rounded by a millionth of the largest, in three
    links that are welded together."""
    for moments in ((-1.0, 1.0, 1.0), (-1e-4, 1.0, 1.0), (1.0, 1.0, np.inf)):
        assert first_unphysical([SOUND, SimpleNamespace(mass=3.0, lever=np.zeros(3), inertia=np.diag(moments))])[0] == 1
    off = np.diag([0.5, 0.5, 1.0]) + 0.5e-6 * np.diag([-1.0, -1.0, 0.0])
    total = sum(turn @ off @ turn.T for turn in (np.eye(3), np.eye(3)[[1, 2, 0]], np.eye(3)[[2, 0, 1]]))
    assert first_unphysical([inertia(moments=np.diag(off)), inertia(moments=np.diag(total))]) is None
    assert first_unphysical([inertia(moments=(0.5, 0.49999, 1.0))]) is not None


def test_as_many_inertias_as_joints(press):
    with pytest.raises(pp.PinpressError, match=f"2 inertias of {press.name}: give {press.model.njoints}, the frame's first"):
        press.with_inertias([SOUND, SOUND])
