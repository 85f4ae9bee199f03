"""Closures of grids of crank angles that are kept with a press: they change no number, are bounded, and are dropped by copies."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pinocchio as pin

import pinpress as pp
from pinpress.engines.planar import chain
from pinpress.kinematics import motion as motions
from pinpress.linkage import assembly


def closings(monkeypatch, press, calls):
    """How many times the loops are closed while these functions of the press are called."""
    count = []
    motions._known(press)  # the branch is closed once, to judge the chain of dyads

    def counted(close):
        return lambda *arguments: count.append(arguments) or close(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(motions, "closed", counted(assembly.closed))
        patch.setattr(chain, "close", counted(chain.close))
        for call in calls:
            call(press)
    return len(count)


def turn(points, speed=7.0, engine="auto"):
    return lambda press: pp.cycle(press, speed, points=points, engine=engine).a


def test_the_same_angles_are_closed_once(monkeypatch):
    press = pp.load("zxn2_3000b")
    assert closings(monkeypatch, press, [turn(40), turn(40, 3.0), turn(40, -7.0), turn(40, engine="pinocchio")]) == 3
    heavier = press.with_inertias([pin.Inertia(2 * i.mass, i.lever, 2 * i.inertia) for i in press.model.inertias])
    assert closings(monkeypatch, heavier, [turn(40)]) == 0
    assert closings(monkeypatch, press, [turn(n) for n in (41, 42, 43, 44, 40)]) == 5, "only the last few are kept"
    assert closings(monkeypatch, press, [turn(7000), turn(7000)]) == 2, "large ones are not kept"
    assert closings(monkeypatch, replace(press, zero="x"), [turn(40)]) == 1
    assert closings(monkeypatch, pickle.loads(pickle.dumps(press)), [turn(40)]) == 1


def test_kept_closures_change_no_number():
    press = pp.load("jf75g_125_two_point")
    pp.cycle(press, 5.0, points=60)
    for speed in (2.0, 9.0):
        again, new = pp.cycle(press, speed, points=60), pp.cycle(pp.load("jf75g_125_two_point"), speed, points=60)
        for name in ("joint_position", "v", "a", "closure_error", "crank_angle"):
            np.testing.assert_array_equal(getattr(again, name), getattr(new, name))
            assert not getattr(again, name).flags.writeable
        forces = [pp.inverse_dynamics(press, each) for each in (again, pickle.loads(pickle.dumps(again)))]
        expected = pp.inverse_dynamics(press, new)
        for each in forces:
            for bearing in press.bearings:
                np.testing.assert_allclose(each.bearing_force[bearing], expected.bearing_force[bearing], rtol=0, atol=1e-9)


def test_threads_share_what_is_kept():
    press = pp.load("crank_slide")
    expected = {points: pp.cycle(press, 5.0, points=points).slide_acceleration for points in range(3, 13)}
    with ThreadPoolExecutor(4) as pool:
        for points, found in zip(
            200 * list(expected), pool.map(lambda n: pp.cycle(press, 5.0, points=n), 200 * list(expected)), strict=True
        ):
            np.testing.assert_array_equal(found.slide_acceleration, expected[points])


def test_forces_belong_to_their_masses_bearings_and_loads():
    press, speeds = pp.load("zxn2_3000b"), (4.0, 5.0, 6.0)
    motions_of = [pp.cycle(press, speed, points=30) for speed in speeds]
    heavier = press.with_inertias([pin.Inertia(2 * i.mass, i.lever, 2 * i.inertia) for i in press.model.inertias])
    plain = [pp.inverse_dynamics(press, motion) for motion in motions_of]
    pushed = pp.inverse_dynamics(press, motions_of[2], [pp.loads.PointForce("slide", (0.0, 0.0, 1e5))])
    doubled = [pp.inverse_dynamics(heavier, pp.cycle(heavier, speed, points=30)) for speed in speeds[::-1]]
    some = pp.inverse_dynamics(heavier, pp.cycle(heavier, 4.0, points=30), bearings=["B"])
    assert np.abs(pushed.driving_torque - plain[2].driving_torque).max() > 1e3
    np.testing.assert_allclose(some.bearing_force["B"], doubled[2].bearing_force["B"], rtol=1e-12, atol=1e-8)
    for one, two in zip(plain, reversed(doubled), strict=True):
        np.testing.assert_allclose(two.driving_torque, 2 * one.driving_torque, rtol=1e-12, atol=1e-8)
