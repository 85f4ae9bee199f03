"""The engine in space beside Pinocchio's, which works on one state at a time: through space, redundant, welded, with several drivers."""

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators.spatial_linkages import bennett, bricard, four_bar
from support.oracles import cassie
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.engines.spatial import equations

N = 11
SWING = {name: {"knee-op": 0.1, "knee-shin-joint": 0.1}.get(name.partition("-")[2], 0.3) for name in cassie.DRIVERS}
LINKAGES = {
    "bennett": (bennett, 0.0, 4.0),
    "bricard": (bricard, -0.4, 1.3),
    "spherical": (lambda: four_bar("spherical"), 0.0, 4.0),
    "fixed": (lambda: four_bar("fixed"), 0.0, 4.0),
    "turntable": (lambda: four_bar("revolute", table="table"), 0.0, np.array([1.0, 1.2])),
    "cassie": (cassie.urdf, 0.0, np.array(list(SWING.values()))),
}


def moved(case, engine="auto"):
    """A servo motion of a linkage, its drivers out of step with each other."""
    press, middle, swing = case
    count = len(press.drivers)
    phase = np.linspace(0.3, 2.9, N)[:, None] + 0.4 * np.arange(count)
    angle, speed, acceleration = middle + swing * np.sin(phase), swing * np.cos(phase), -swing * np.sin(phase)
    if count == 1:
        angle, speed, acceleration = (values[:, 0] for values in (angle, speed, acceleration))
    return pp.servo_cycle(press, angle=angle, speed=speed, acceleration=acceleration, engine=engine)


@pytest.fixture(scope="module", params=rest_exhaustive(LINKAGES, "fixed", "turntable"))
def case(request):
    text, middle, swing = LINKAGES[request.param]
    press = texts.load(text())
    return press, middle, swing


def agree(ours, judge, bound):
    """Compare two results, relative to the peaks of forces and moments."""
    for name in ("bearing_force", "bearing_moment"):
        one, other = (np.array(list(getattr(each, name).values())) for each in (ours, judge))
        assert np.abs(one - other).max() <= bound * np.abs(other).max(), name
    moment = max(np.abs(values).max() for values in judge.bearing_moment.values())
    assert np.abs(ours.driving_torque - judge.driving_torque).max() <= bound * moment


def test_motion(case):
    ours, theirs = (moved(case, engine) for engine in ("space", "pinocchio"))
    for name in ("joint_position", "v", "a"):
        one, other = getattr(ours, name), getattr(theirs, name)
        assert np.abs(one - other).max() <= 1e-12 * (1 + np.abs(other).max()), name


def test_forces(case):
    press = case[0]
    motion = moved(case)
    loads = [pp.loads.PointForce(press.links[-1], (30.0, -40.0, 20.0), (0.02, -0.05, 0.01))]
    welds = {loop.name for loop in press.loops if loop.type == "fixed"}
    rubbing = {name: pp.loads.Friction(0.05, radius=0.02) for name in press.bearings if name not in welds}
    stiff = dict.fromkeys(press.bearings[:3], 1e8)
    for more in ({}, {"friction": rubbing}, {"stiffness": stiff}, {"bearings": press.bearings[1:3]}, {"bearings": ()}):
        ours, theirs = (pp.inverse_dynamics(press, motion, loads, engine=engine, **more) for engine in ("space", "pinocchio"))
        if more.get("bearings") == ():
            np.testing.assert_allclose(ours.driving_torque, theirs.driving_torque, rtol=0, atol=1e-11 * np.abs(theirs.driving_torque).max())
        else:
            agree(ours, theirs, 1e-11)
        for name in press.bearings if not more else ():
            np.testing.assert_array_equal(ours.indeterminate[name], theirs.indeterminate[name])


def test_logarithms_of_rotations():
    rng = np.random.default_rng(4)
    vectors = rng.normal(size=(40, 3))
    sizes = np.concatenate([np.linspace(0.0, np.pi - 1e-6, 30), np.pi - np.geomspace(1e-9, 1e-2, 10)])
    vectors *= (sizes / np.linalg.norm(vectors, axis=1))[:, None]
    rotations = np.array([pin.exp3(vector) for vector in vectors]).transpose(1, 2, 0)
    np.testing.assert_allclose(equations._logarithm(rotations).T, vectors, rtol=0, atol=1e-7)
    np.testing.assert_allclose(equations._logarithm(rotations).T[:20], vectors[:20], rtol=0, atol=1e-14)
