"""Force and work of the process over a motion: works against their integrals in closed form, and what copies keep."""

import pickle

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.loads import (
    Blanking,
    ConstantForce,
    DeepDrawing,
    ElasticDie,
    ForceInterval,
    ForceStroke,
    Idle,
    PointForce,
    SpringDamper,
    TimeForce,
)

SPEED = 70 * pp.RPM
WORKS = [  # of a stroke [J]
    (Blanking(1e6, 0.006, 0.002), 1e6 * 0.004 * 2 / np.pi),
    (Blanking(1e6, 0.006, 0.002, stripping=3e4), 1e6 * 0.004 * 2 / np.pi + 3e4 * 0.004),
    (DeepDrawing(1e6, 0.05), 1e6 * 0.05 * 2 / np.pi),
    (ForceStroke([0.0, 0.02, 0.03], [6e5, 6e5, 0.0]), 6e5 * 0.025),
    (ConstantForce(1e6, 0.01), 0.0),
    (ElasticDie(0.01, 1e8), 0.0),
    (Idle(), 0.0),
]


@pytest.mark.parametrize(("load", "work"), WORKS, ids=lambda part: type(part).__name__)
@pytest.mark.parametrize(("points", "speed"), [(36, SPEED), (360, -SPEED)])
def test_work_of_a_stroke_in_closed_form(load, work, points, speed):
    press = texts.shipped("zxn2_3000b")
    reactions = pp.inverse_dynamics(press, pp.cycle(press, speed, points=points), [load])
    assert reactions.process_work == pytest.approx(work, rel=1e-12, abs=2e-9)  # J, of 5 kJ and more that go to and fro


def test_work_of_a_damped_die_against_that_of_the_drive():
    """All that the drive does over a period is lost in the die."""
    press, die = texts.shipped("zxn2_3000b"), ElasticDie(0.05, 1e6, 4e5)
    reactions = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=36), [die])
    assert reactions.process_work == pytest.approx(pp.measures.driving_energy(reactions).work, rel=1e-8)


def test_work_of_a_run_is_that_which_it_has_integrated():
    press = texts.shipped("zxn2_3000b")
    for load, error in ((Blanking(1e6, 0.006, 0.002), 1e-12), (TimeForce(lambda time: 1e3 * np.sin(time)), 1e-10)):
        run = pp.simulate(press, 1.3, speed=SPEED, flywheel=pp.drives.Flywheel(2e4), loads=[load])
        assert pp.inverse_dynamics(press, run, [load]).process_work == pytest.approx(run.load_work[-1], rel=error)


def test_force_is_that_of_process_loads_alone():
    press = texts.shipped("zxn2_3000b")
    motion, blank = pp.cycle(press, SPEED, points=720), Blanking(1e6, 0.006, 0.002)
    others = [PointForce("slide", (0.0, 0.0, 1e3)), SpringDamper("frame", "slide", 1e5)]
    reactions = pp.inverse_dynamics(press, motion, [blank, *others, TimeForce(lambda time: 5.0)])
    height = motion.slide_position - pp.dead_centres(press).bottom_position
    acts = (motion.slide_velocity < 0) & (height > 0.002) & (height <= 0.006)
    assert acts.any()
    np.testing.assert_allclose(
        reactions.process_force, 5.0 + np.where(acts, 1e6 * np.sin(np.pi / 2 * (0.006 - height) / 0.004), 0), rtol=1e-12
    )
    assert not pp.inverse_dynamics(press, motion, others).process_force.any()


def test_what_was_given_is_kept():
    press = texts.shipped("zxn2_3000b")
    motion, friction = pp.cycle(press, SPEED, points=24), {"A": pp.loads.Friction(0.1, 0.1)}
    loads = [Blanking(1e6, 0.006, 0.002), TimeForce(lambda time: 7.0)]
    reactions = pp.inverse_dynamics(press, motion, loads, friction, {"D": 1e9})
    assert reactions.loads == tuple(loads)
    assert (dict(reactions.friction), dict(reactions.stiffness)) == (friction, {"D": 1e9})
    sent = pickle.loads(pickle.dumps(reactions))  # a function without a name cannot be sent, what it gave can
    assert sent.loads[0] is not None
    assert isinstance(sent.loads[0], Blanking)
    assert "TimeForce" in str(sent.loads[1])
    assert sent.process_work == reactions.process_work
    np.testing.assert_array_equal(sent.process_force, reactions.process_force)


class Cushion:
    """A caller's own load: a spring below a slide position, in both directions, and friction of 2 kN against the motion."""

    datum = -0.9

    def intervals(self, downwards):
        return (ForceInterval(0.0, -np.inf, lambda height, velocity: -1e6 * height - 2e3 * np.sign(velocity)),)


def test_a_load_of_a_callers_own():
    """The spring gives back what it takes; the friction acts on the way down from the datum to bottom dead centre and up again."""
    press = texts.shipped("zxn2_3000b")
    reactions = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=90), [Cushion()])
    depth = Cushion.datum - pp.dead_centres(press).bottom_position
    assert reactions.process_work == pytest.approx(2 * 2e3 * depth, rel=1e-5)


def test_doubts_are_said_once():
    press = texts.shipped("zxn2_3000b")
    with pytest.warns(pp.PinpressWarning, match="nowhere on the slide's stroke"):
        reactions = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=24), [Blanking(1e6, 6.0, 2.0)])
    assert (reactions.process_force.any(), reactions.process_work) == (False, 0.0)  # a second warning would be an error


@pytest.mark.parametrize(
    ("load", "said"),
    [
        (Blanking(1e6, 2e-4, 1e-4), "from 0.0001 to 0.0002 m above its datum, and none of the motion's 24 states is there"),
        (Blanking(0.0, 0.02, 0.019, stripping=1e5), "none of the motion's 24 states is there"),
        (ConstantForce(1e6, 1e-5), "below 1e-05 m above its datum, and none of the motion's 25 states is there"),
    ],
)
def test_a_load_between_two_states_is_said(load, said):
    """The slide travels through the load, on the way down, on the way up, or turns in it, and none of the states shows it."""
    press = texts.shipped("zxn2_3000b")
    motion = pp.cycle(press, SPEED, points=25 if isinstance(load, ConstantForce) else 24)
    with pytest.warns(pp.PinpressWarning, match=said):
        reactions = pp.inverse_dynamics(press, motion, [load])
    assert not reactions.process_force.any()


def test_a_motion_that_ends_above_a_load_is_no_mistake():
    """A positioning move that stays above the blank: nothing is said (a warning would be an error)."""
    press = texts.shipped("zxn2_3000b")
    motion = pp.cycle(press, SPEED, points=360)
    high = np.flatnonzero(motion.slide_position > pp.dead_centres(press).bottom_position + 0.1)
    angle = motion.crank_angle[high[:20]]
    move = pp.servo_cycle(press, angle=angle, speed=np.full(20, SPEED), acceleration=np.zeros(20), time=(angle - angle[0]) / SPEED)
    assert not pp.inverse_dynamics(press, move, [Blanking(1e6, 0.006, 0.002)]).process_force.any()
