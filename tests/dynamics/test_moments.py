"""Moments on links and torsion springs between them: printed values of an independent solution in maximal coordinates, the principle of
virtual power, springs in joints of files, and the energy of runs by every method."""

import numpy as np
import pytest
from support.generators.random_linkages import four_bar
from support.generators.spatial_crank_slide import SPATIAL
from support.texts import load, shipped

import pinpress as pp

SPRING = pp.loads.TorsionSpring("crank", "rod", 500.0)

# load, driving torque [N m], bearing force W along x [N]: crank_slide at 60 deg and 10 rad/s, by a solution in maximal coordinates
PRINTED = {
    "none": ([], 155.002041674, 345.638488155),
    "couple on the rod": ([pp.loads.PointMoment("rod", 20.0)], 157.562779273, 396.853240128),
    "in world axes": ([pp.loads.PointMoment("rod", (0.0, -20.0, 0.0))], 157.562779273, 396.853240128),
    "a function": ([pp.loads.PointMoment("rod", lambda motion: np.tile([0.0, -20.0, 0.0], (1, 1)))], 157.562779273, 396.853240128),
    "on the crank": ([pp.loads.PointMoment("rod", 20.0, on="crank")], 177.562779273, 396.853240128),
    "crank to rod": ([SPRING], 868.729061177, 1965.85822257),
    "rod to crank": ([pp.loads.TorsionSpring("rod", "crank", 500.0)], 868.729061177, 1965.85822257),
    "frame to crank": ([pp.loads.TorsionSpring("frame", "crank", 500.0)], 678.600817272, 345.638488155),
}


@pytest.mark.parametrize("name", PRINTED)
def test_printed_values(name, engine):
    loads, torque, along = PRINTED[name]
    press = shipped("crank_slide")
    motion = pp.servo_cycle(press, angle=[np.pi / 3], speed=[10.0], acceleration=[0.0])
    found = pp.inverse_dynamics(press, motion, loads, engine=engine)
    np.testing.assert_allclose([found.driving_torque[0], found.bearing_force["W"][0, 0]], [torque, along], rtol=3e-12)
    assert abs(found.power_residual[0]) < 1e-14


def spatial_loads(motion):
    """Moments that change their direction, on a rod that turns in space and on the frame."""
    angle = motion.crank_angle
    moment = np.stack([30 * np.cos(angle), 20 * np.sin(2 * angle), 10 + 5 * angle], axis=1)
    return [
        pp.loads.PointMoment("rod", moment),
        pp.loads.PointMoment("frame", (1.0, 2.0, 3.0)),
        pp.loads.PointMoment("crank", -3.0, on="rod"),
    ]


@pytest.mark.parametrize("engine", ["space", "pinocchio"])
def test_power_in_space(engine):
    """The torque changes by minus the power of the moments, and what comes from outside shakes the frame."""
    press = load(SPATIAL)
    motion = pp.cycle(press, speed=4.0, points=24)
    loads = spatial_loads(motion)
    alone, loaded = (pp.inverse_dynamics(press, motion, given, engine=engine) for given in ((), loads))
    joints = [list(press.model.names).index(name) for name in press.joints]
    bodies = {press.model.frames[press.model.getFrameId(name)].parentJoint: name for name in press.links}
    spins = press.engine("space").body_motion(motion.states(press), joints).spin  # (bodies, 3, n)
    spin = {bodies[joint]: spins[k].T for k, joint in enumerate(joints)}
    opposite = np.array([0.0, 3.0, 0.0])
    power = ((loads[0].moment - opposite) * spin["rod"]).sum(axis=1) + spin["crank"] @ opposite
    np.testing.assert_allclose((loaded.driving_torque - alone.driving_torque) * 4.0, -power, atol=1e-12 * np.abs(power).max())
    outside = loads[0].moment + np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(loaded.shaking_moment - alone.shaking_moment, outside, atol=1e-11 * np.abs(alone.shaking_moment).max())
    np.testing.assert_allclose(loaded.shaking_force, alone.shaking_force, atol=1e-12 * np.abs(alone.shaking_force).max())


def test_as_springs_in_joints_of_a_file():
    """A torsion spring between the two links of a pin does what a spring in the pin does, in engines and in runs."""
    text = four_bar(1.0, 0.3, 0.9, 0.8, 1.0).urdf("O")
    plain = load(text)
    bodies = {plain.model.frames[plain.model.getFrameId(link)].parentJoint: link for link in plain.links}
    number = next(joint for joint, parent in enumerate(plain.model.parents) if parent)
    pin, parent, child = plain.joints[number - 1], bodies[plain.model.parents[number]], bodies[number]
    sprung = load(text.replace("</robot>", f'<joint_spring joint="{pin}" stiffness="40" reference="0.3" damping="2"/></robot>'))
    spring = pp.loads.TorsionSpring(parent, child, 40.0, 2.0, 0.3)
    motion = pp.cycle(plain, speed=5.0, points=24)
    torque = pp.inverse_dynamics(plain, motion, [spring]).driving_torque
    np.testing.assert_allclose(torque, pp.inverse_dynamics(sprung, motion).driving_torque, rtol=1e-10, atol=1e-10)
    runs = [pp.simulate(press, 0.5, speed=3.0, loads=given) for press, given in ((plain, [spring]), (sprung, []))]
    np.testing.assert_allclose(runs[0].crank_speed, runs[1].crank_speed, rtol=1e-9)


MOMENTS = [
    pp.loads.TorsionSpring("crank", "rod", 500.0, 3.0, 0.4),
    pp.loads.TorsionSpring("frame", "crank", 20.0),
    pp.loads.PointMoment("crank", (3.0, -30.0, 0.0), on="rod"),
    pp.loads.PointMoment("slide", (0.0, 100.0, 0.0)),
]


@pytest.mark.parametrize("method", ["reduced", "constraint", "implicit"])
def test_runs(method):
    """Inverse dynamics of a run asks for the torque that its flywheel alone supplies."""
    press, flywheel = shipped("crank_slide"), pp.drives.Flywheel(5.0)
    run = pp.simulate(press, 0.3, speed=10.0, flywheel=flywheel, loads=MOMENTS, method=method)
    found = pp.inverse_dynamics(press, run, MOMENTS)
    np.testing.assert_allclose(found.driving_torque, -5.0 * run.crank_acceleration, atol=1e-6)
    assert np.abs(found.power_residual).max() < 1e-12
    rod = run.joint_position[:, press.joints.index("P")]
    stored = 250 * (rod - 0.4) ** 2 + 10 * run.crank_angle**2
    lost = 3.0 * np.trapezoid(run.v[:, press.joints.index("P")] ** 2, run.time)
    given = 30.0 * (run.crank_angle - (run.crank_angle + rod))
    work = stored[-1] - stored[0] + lost - (given[-1] - given[0])
    assert run.load_work[-1] - run.load_work[0] == pytest.approx(work, abs=2e-2)


@pytest.mark.exhaustive
def test_elastic_motion():
    """On stiff springs the drive supplies what inverse dynamics asks for, but for the way that the springs yield."""
    press, held = shipped("crank_slide"), pp.drives.PrescribedSpeed(10.0)
    stiff = pp.elasticity.Elastic(pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 1e10), moments={"slide_guide": 1e9}))
    loads = [
        pp.loads.TorsionSpring("frame", "rod", 20.0),
        pp.loads.PointMoment("rod", 20.0, on="frame"),
        pp.loads.PointMoment("crank", (3.0, -30.0, 0.0), on="rod"),
    ]
    asked = pp.inverse_dynamics(press, pp.cycle(press, speed=10.0, points=72), loads).driving_torque
    found = pp.steady_state(press, 10.0, drive=held, loads=loads, elastic=stiff, points=73).drive_torque[:-1]
    np.testing.assert_allclose(found, asked, atol=1e-5 * np.abs(asked).max())
    with pytest.raises(pp.PinpressError, match="winds it up by a turn"):
        pp.steady_state(press, 10.0, drive=held, loads=MOMENTS, elastic=stiff)


def test_in_a_job(tmp_path):
    (tmp_path / "job.yaml").write_text(
        "file: crank_slide\nspeed: 10 rad/s\npoints: 12\nloads:\n"
        "  couple: {kind: moment, link: rod, moment: 20 N m}\n"
        "  spring: {kind: torsion-spring, link1: crank, link2: rod, stiffness: 500 N m/rad, free_angle: 30 deg}\n"
    )
    press = shipped("crank_slide")
    loads = [pp.loads.PointMoment("rod", 20.0), pp.loads.TorsionSpring("crank", "rod", 500.0, free_angle=np.pi / 6)]
    wanted = pp.inverse_dynamics(press, pp.cycle(press, speed=10.0, points=12), loads).driving_torque
    np.testing.assert_array_equal(pp.job(tmp_path / "job.yaml").reactions().driving_torque, wanted)


REFUSED = {
    "shape": (lambda: pp.loads.PointMoment("rod", (1.0, 2.0)), r"moment has shape \(2,\)"),
    "stiffness": (lambda: pp.loads.TorsionSpring("crank", "rod", -1.0), "stiffness is -1"),
    "no turn": (lambda: asked(pp.loads.TorsionSpring("frame", "slide", 1.0)), "do not turn against each other"),
    "unknown": (lambda: asked(pp.loads.PointMoment("rodd", 1.0)), "did you mean 'rod'"),
    "rows": (lambda: asked(pp.loads.PointMoment("rod", np.ones((5, 3)))), "5 rows, but the motion has 12 states"),
    "in space": (lambda: asked(pp.loads.TorsionSpring("frame", "rod", 1.0), load(SPATIAL)), "axes that are not parallel"),
    "run in space": (lambda: pp.simulate(load(SPATIAL), 0.1, speed=1.0, loads=[pp.loads.PointMoment("rod", 1.0)]), "axes that are not par"),
    "law in a run": (
        lambda: pp.simulate(shipped("crank_slide"), 0.1, speed=1.0, loads=[pp.loads.PointMoment("rod", lambda motion: 1.0)]),
        "takes a constant moment",
    ),
}


def asked(given, press=None):
    press = press or shipped("crank_slide")
    return pp.inverse_dynamics(press, pp.cycle(press, speed=1.0, points=12), [given])


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name):
    call, message = REFUSED[name]
    with pytest.raises(pp.PinpressError, match=message):
        call()


def test_frame_on_mounts():
    """A moment from outside tilts the frame on its mounts by M / (k - m g h), one that the frame takes itself does not."""
    press, held, width, above = shipped("crank_slide"), pp.drives.PrescribedSpeed(10.0), 0.6, 0.8
    frame = pp.foundation.Frame(mass=9000, centre=(0, 0, 0.3), inertia=(3000, 4000, 2500))
    places = [(x, y, 0.3 - above) for x in (-width, width) for y in (-0.5, 0.5)]
    mounts = [pp.foundation.Mount(place, (6e6, 6e6, 6e6), (1e5, 1e5, 1e5)) for place in places]
    springs = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 1e10), moments={"slide_guide": 1e9})
    elastic = pp.elasticity.Elastic(springs, damping_ratio=0.03, mounted_frame=frame, mounts=mounts)
    free, taken, none = (
        pp.steady_state(press, 10.0, drive=held, loads=loads, elastic=elastic, points=73).frame_motion[:-1, 2].mean()
        for loads in ([pp.loads.PointMoment("rod", 20.0)], [pp.loads.PointMoment("rod", 20.0, on="frame")], [])
    )
    stiffness = 4 * 6e6 * width**2
    assert free - none == pytest.approx(20.0 / (stiffness - 9000 * 9.81 * above), rel=1e-3)  # the linkage is lighter by as much
    assert abs(taken - none) < 1e-3 * abs(free - none)


def test_one_number_is_refused_for_a_linkage_in_another_plane(tmp_path):
    """It is about the world's -y, and would move nothing there without a word."""
    (tmp_path / "arm.urdf").write_text(
        '<robot name="arm"><link name="frame"/><link name="bar"><inertial><origin xyz="0 0.2 0"/><mass value="2"/>'
        '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="O" type="continuous"><parent link="frame"/><child link="bar"/><axis xyz="1 0 0"/></joint>'
        '<transmission name="t"><joint name="O"/></transmission></robot>'
    )
    press = pp.load(tmp_path / "arm.urdf")
    motion = pp.cycle(press, 2.0, points=8)
    for asked in (
        lambda: pp.inverse_dynamics(press, motion, [pp.loads.PointMoment("bar", 5.0)]),
        lambda: pp.simulate(press, 0.1, loads=[pp.loads.PointMoment("bar", 5.0)]),
    ):
        with pytest.raises(pp.PinpressError, match="is a moment in the x-z plane, and arm does not move in it: give three numbers"):
            asked()
    plain, moved = (pp.inverse_dynamics(press, motion, loads) for loads in ((), [pp.loads.PointMoment("bar", (5.0, 0.0, 0.0))]))
    np.testing.assert_allclose(moved.driving_torque, plain.driving_torque - 5.0, rtol=0, atol=1e-12)
