"""Modes, events and solvers of a simulation, each for itself."""

import math
import pickle
import string

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.simulation import failures, solvers
from pinpress.simulation.coupling import SLIPPING
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.over_time.equations_of_motion import ReducedDynamics
from pinpress.simulation.over_time.events import (
    CrankStops,
    PressStarts,
    ending_events,
)
from pinpress.simulation.over_time.hybrid_system import HybridSystem
from pinpress.simulation.reduced_model import WEIGHT

MOTOR = pp.drives.Geared(pp.drives.InverterMotor(20.0, 1450 * pp.RPM, 45.0), 20.0)


def margins_of(events, system, mode, y):
    """The margins of events at the start."""
    return [event.margin(system, mode, 0.0, y, system.at(y)) for event in events]


@pytest.fixture(scope="module")
def press():
    return texts.shipped("crank_slide")


def begun(press, angle=1.0, speed=5.0, drive=None, flywheel=None, loads=(), clutch=None, brake=None):
    """The system of a press, and its mode and vector at the start."""
    driven = driven_press(press, drive, flywheel, list(loads), clutch, brake)
    system = HybridSystem(ReducedDynamics(driven.model), driven)
    return system, *system.begin(0.0, np.array([angle]), np.array([speed]), np.zeros(4))


def kinds(system, mode, y):
    return [type(event) for event in ending_events(system, mode, y)]


@pytest.mark.parametrize("speed", [5.0, -5.0])
def test_a_brake_is_a_coupling_to_the_frame(press, speed):
    """Its torque is against the motion, whichever way that goes, and its grip comes as the crank comes to rest."""
    system, mode, y = begun(press, speed=speed, brake=pp.drives.Brake(50.0))
    free, coasting, same = begun(press, speed=speed)
    assert mode.brake.grip is SLIPPING
    slowed, alone = system.rates(mode, 0.0, y)[1], free.rates(coasting, 0.0, same)[1]
    inertia = free.driven.model.at(np.array([1.0]))[0][0, 0]
    assert slowed - alone == pytest.approx(-math.copysign(50.0, speed) / inertia, rel=1e-12)
    (stops,) = (event for event in ending_events(system, mode, y) if isinstance(event, CrankStops))
    assert margins_of([stops], system, mode, y) == [abs(speed)]
    assert system.rates(mode, 0.0, y)[-1] == pytest.approx(50.0 * abs(speed), rel=1e-15)  # lost
    after, rest = stops.after(system, mode, 0.1, y)
    assert rest[1] == 0.0
    pull = -free.driven.model.at(np.array([1.0]))[0][WEIGHT, 0]  # of the weights; the brake holds up to 50 N m
    assert after.way == (0 if abs(pull) <= 50.0 else math.copysign(1, pull))


@pytest.mark.parametrize(("share", "rests"), [(1.0, True), (1.0 - 1e-6, False)])
def test_rounding_does_not_decide_whether_a_brake_holds(press, share, rests):
    """A brake of just the torque of the weights holds them, with clutch and load too; one that is weaker by a millionth does not."""
    weights = abs(float(ReducedDynamics(driven_press(press, None, None, [], None, None).model).at(np.array([1.0]), np.zeros(1)).weight))
    for loads in ([], [pp.loads.Blanking(0.0, 0.3, 0.0)]):
        clutch = pp.drives.Clutch(20.0, closes=pp.drives.SwitchPoint(time=9.0))
        for coupling in (None, clutch):
            parts = {"flywheel": pp.drives.Flywheel(3.0), "loads": loads, "clutch": coupling, "brake": pp.drives.Brake(share * weights)}
            system, mode, y = begun(press, speed=0.0, **parts)
            assert mode.rests is rests
            if rests:
                assert min(margins_of(ending_events(system, mode, y), system, mode, y)) >= 0.0


@pytest.mark.filterwarnings("ignore:.*it begins with a jump")
def test_a_press_that_stands_waits_for_its_drive_alone(press):
    class Idle:
        inertia, rated_torque, corners, state, timed = 0.0, None, (), (), True

        def torque(self, speed, angle=0.0, time=0.0, state=()):
            return 0.0

        motor_torque = torque

        def rates(self, speed, angle=0.0, time=0.0, state=()):
            return ()

        def motor_speed(self, speed):
            return speed

    load = pp.loads.Blanking(1e5, 0.25, 0.0, stripping=1e5)
    system, mode, y = begun(press, speed=0.0, drive=Idle(), loads=[load])
    assert mode.rests
    assert kinds(system, mode, y) == [PressStarts]
    assert min(margins_of(ending_events(system, mode, y), system, mode, y)) > 0
    assert system.rates(mode, 0.0, y)[:2].tolist() == [0.0, 0.0]


@pytest.mark.parametrize("reason", failures.REASONS)
def test_every_failure_says_which_it_is(reason):
    fields = [name for _, name, _, _ in string.Formatter().parse(failures.REASONS[reason]) if name]
    error = failures.failure(reason, 0.5, 1.0, **dict.fromkeys(fields, 7.0))
    assert error.reason == reason
    assert "time 0.5 s" in str(error)
    assert pickle.loads(pickle.dumps(error)).reason == reason


def problem(press, method="reduced", **parts):
    given = dict.fromkeys(("drive", "flywheel", "clutch", "brake")) | {"loads": []} | parts
    driven = driven_press(press, given["drive"], given["flywheel"], given["loads"], given["clutch"], given["brake"])
    return solvers.SimulationProblem(driven, method, np.array([1.0]), np.array([5.0]), 0.5, 1e-11)


def test_a_problem_travels_and_is_the_same(press):
    """To another process, say: all that the library's own drives and loads are made of can be pickled."""
    loads = [
        pp.loads.Blanking(1e4, 0.1, 0.05),
        pp.loads.SpringDamper("frame", "slide", 1e4, 10.0, 0.3, point1=(0.0, 0.0, -1.0)),
        pp.loads.PointForce("slide", (0.0, 0.0, -100.0)),
    ]
    given = problem(press, drive=MOTOR, flywheel=pp.drives.Flywheel(5.0), loads=loads)
    here, there = (solvers.march(one).at(np.array([0.1, 0.5])) for one in (given, pickle.loads(pickle.dumps(given))))
    np.testing.assert_array_equal(here.position, there.position)
    np.testing.assert_array_equal(here.integrals, there.integrals)
