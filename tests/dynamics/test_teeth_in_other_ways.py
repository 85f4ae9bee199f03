"""Presses with teeth and threads, written in other ways: turned, mirrored, with other names. All forces are the same, by every engine."""

import numpy as np
import pytest
from support.generators import same_linkage
from support.generators.machine_elements import RUBBING
from support.second_opinion import worst_force

import pinpress as pp
from pinpress.loads import Friction, PointForce, PointMoment

SAME = 1e-9  # of the largest force, as of all scenes of the second opinion


LOADED = {"planets": "planet", "worm": "wheel"}  # the others have a slide
PLAIN = same_linkage.Same(None)


def reactions(name, press, engine="auto", same=PLAIN):
    """Forces of states in which both bodies of the element drive, under a force and a moment on one link, with friction in a bearing."""
    sense, link = same.sense, LOADED.get(name, "slide")
    angles, speeds = np.linspace(-0.2, 0.3, 5), np.array([-2.0, 1.0, 3.0, 2.0, -1.0])
    motion = pp.servo_cycle(press, sense * angles, speed=sense * speeds, acceleration=sense * 4.0, engine=engine)
    moment = np.linalg.det(same.vectors) * same.vectors @ (0.0, 40.0, 0.0)
    loads = [PointForce(same.names.get(link, link), tuple(same.vectors @ (300.0, -200.0, 5000.0)))]
    loads += [PointMoment(same.names.get(link, link), tuple(moment))]
    return pp.inverse_dynamics(press, motion, loads, {press.driver: Friction(0.1, radius=0.02)}, engine=engine)


@pytest.mark.parametrize("way", same_linkage.WAYS)
@pytest.mark.parametrize("name", RUBBING)
@pytest.mark.filterwarnings("ignore:load on '.*wheel'")  # it is on the wheel's axis, and stands still
def test_another_way_to_write_it_has_the_same_forces(name, way):
    press = pp.build(**RUBBING[name])
    same = way(press, np.random.default_rng(7))
    first, other = reactions(name, press), reactions(name, same.press, same=same)
    assert worst_force(press, first, other, same) < SAME


@pytest.mark.parametrize("name", RUBBING)
@pytest.mark.filterwarnings("ignore:load on 'wheel'")
def test_every_engine_has_the_same_forces(name):
    press = pp.build(**RUBBING[name])
    first, *others = (reactions(name, press, engine) for engine in press.engines)
    assert others
    for other in others:
        assert worst_force(press, first, other) < SAME
