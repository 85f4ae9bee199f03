"""Forward dynamics of a linkage with several drivers: Cassie's legs, 12 drivers, 12 equations of rank 10."""

import numpy as np
import pytest
from support import texts
from support.oracles import cassie

import pinpress as pp
from pinpress.linkage import assembly
from pinpress.simulation.run import inputs_of

SLIPPING = pp.drives.SlipClutchMotor(
    rated_torque=189.0, primary_speed=1470 * pp.RPM, top_speed=1320 * pp.RPM, set_speed=900 * pp.RPM, lag=0.1
)


def five_bar(height=0.2):
    """Two driven cranks of 0.1 m, 0.5 m apart, and two couplers, of 0.25 m if C is 0.2 m above the ground line, on which the other
    four pins are drawn."""
    inertial = '<inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>'

    def pin(name, parent, child, x):
        ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{x} 0 0"/>'
        return f'<joint name="{name}" type="continuous">{ends}<axis xyz="0 -1 0"/></joint>'

    text = f"""<robot name="five_bar"><link name="frame"/>
    {"".join(f'<link name="{link}">{inertial}</link>' for link in ("crank_1", "crank_2", "coupler_1", "coupler_2"))}
    {pin("A", "frame", "crank_1", 0)}{pin("B", "frame", "crank_2", 0.5)}
    {pin("P", "crank_1", "coupler_1", 0.1)}{pin("Q", "crank_2", "coupler_2", -0.1)}
    <loop_joint name="C" type="spherical">
      <link1 link="coupler_1" xyz="0.15 0 {height}"/><link2 link="coupler_2" xyz="-0.15 0 {height}"/>
    </loop_joint>
    <transmission name="a"><joint name="A"/></transmission><transmission name="b"><joint name="B"/></transmission></robot>"""
    return texts.load(text)


@pytest.mark.exhaustive
def test_where_two_drivers_pull_the_linkage_straight():
    """The pins are 0.5 - 0.2 cos s apart: two couplers of 0.25 m are straight at a right angle, and there C is halfway on their line."""
    press, last = five_bar(), np.radians(89.0)
    turned = np.linspace(0.0, last, 30)
    motion = pp.servo_cycle(press, angle=np.column_stack([turned, -turned]), speed=0.0)
    half = 0.25 - 0.1 * np.cos(turned)
    inclined = np.arctan2(np.sqrt(0.25**2 - half**2), half)  # of coupler 1 over the ground, and drawn
    coupler = motion.joint_position[:, press.joints.index("A")] + motion.joint_position[:, press.joints.index("P")]
    np.testing.assert_allclose(coupler, inclined - np.arctan2(0.2, 0.15), rtol=0, atol=1e-9)
    turned = np.linspace(0.0, 2.0, 21)
    with pytest.raises(pp.SingularityError, match=r"five_bar locks on the way from A 85(\.\d*)? deg, B -85(\.\d*)? deg to A ") as caught:
        pp.servo_cycle(press, angle=np.column_stack([turned, -turned]), speed=0.0)
    assert caught.value.crank_angle == pytest.approx(np.pi / 2, abs=1e-6)


@pytest.mark.exhaustive
def test_messages_name_the_drivers_where_a_linkage_locks():
    press = five_bar()
    with pytest.raises(pp.SingularityError) as caught:
        press.configuration([2.0, -2.0])
    way = "from A 0 deg, B 0 deg to A 114.592 deg, B -114.592 deg"
    assert str(caught.value) == f"five_bar locks on the way {way}: keep the motion away from there (A 90 deg, B -90 deg)"
    motion = pp.servo_cycle(press, angle=np.radians([[0.0, 0.0], [89.5, -89.5]]), speed=[[1.0, -1.0]] * 2, acceleration=0.0)
    with pytest.raises(pp.PinpressError, match=r"friction locks the linkage, or nearly so, at A 89\.5 deg, B -89\.5 deg: no"):
        pp.inverse_dynamics(press, motion, friction={name: pp.loads.Friction(0.9, 0.2) for name in press.bearings})


@pytest.fixture(scope="module")
def legs():
    return texts.load(cassie.urdf())


def test_of_many_drivers_a_message_names_the_first_few(legs):
    said = legs.structure.place_of_drivers(np.radians(np.arange(float(len(legs.drivers)))))
    assert said.startswith(f"{legs.drivers[0]} 0 deg, {legs.drivers[1]} 1 deg, ")
    assert said.endswith(f", {legs.drivers[5]} 5 deg and {len(legs.drivers) - 6} more")


def walked(press, path):
    """Closed positions (nv, n), each walked to from the one before."""
    here, before, found = press.closed, np.zeros(path.shape[1]), []
    for after in path:
        least = press.structure.smallest_margin
        here = assembly._walk_between(press.engine("pinocchio"), press.structure, here, before, after, "press", least)
        before = after
        found.append(here)
    return np.array(found).T


@pytest.mark.parametrize(
    ("height", "path"),
    [
        (0.37, np.linspace(0.0, 1.0, 5)[:, None] * [6 * np.pi, -8 * np.pi]),  # so far that Newton's method needs several beginnings
        (0.37, np.repeat([[0.5, 0.2], [0.5, 0.2 + 1e-14], [-3.0, 0.1]], 2, axis=0)),  # rests, and turns back
        (0.22, [[0.57, 2.93], [-2.17, -0.8], [-4.36, -0.49], [-6.36, -1.72]]),  # here Newton's method comes to the other assembly
        (0.37, [[-0.57, -1.31], [-2.15, -2.01], [-0.52, -2.22], [-1.59, -2.85]]),
    ],
)
def test_a_path_closed_at_once_is_the_path_walked(height, path):
    press, path = five_bar(height), np.array(path)  # its cranks turn fully
    found = assembly.follow_drivers(press.engine(), press.structure, press.closed, path, "press")
    np.testing.assert_allclose(found, walked(press, path), rtol=0, atol=1e-10)
    np.testing.assert_array_equal(found[list(press.driver_indices)].T, path)


@pytest.mark.exhaustive
def test_a_free_fall(legs):
    """The legs fall from rest: energy is kept, loops stay closed, and the joints' accelerations are those that need no torque."""
    run = pp.simulate(legs, 0.05, method="constraint")
    assert run.stats.energy_error < 1e-9
    assert run.closure_error.max() < 1e-10
    assert run.crank_angle.shape == run.drive_torque.shape == (121, 12)
    torque = pp.inverse_dynamics(legs, run).driving_torque
    weight = pp.inverse_dynamics(legs, pp.servo_cycle(legs, angle=run.crank_angle[:1], speed=0.0)).driving_torque
    assert np.abs(torque).max() < 1e-9 * np.abs(weight).max()


def test_drives_and_flywheels(legs):
    """Two drives and a flywheel by the names of their joints: the torques that the motion needs are those, less the flywheel's."""
    first, second = legs.drivers[0], legs.drivers[5]
    motor = pp.drives.Geared(pp.drives.InductionMotor(100.0, 1440 * pp.RPM, inertia=1e-4), 50.0)
    drive, flywheel = {first: pp.drives.ConstantTorque(2.0), second: motor}, {first: pp.drives.Flywheel(0.1)}
    run = pp.simulate(legs, 0.02, method="constraint", drive=drive, flywheel=flywheel)
    needed = np.zeros_like(run.drive_torque)
    needed[:, 0] = 2.0 - 0.1 * run.crank_acceleration[:, 0]
    needed[:, 5] = motor.torque(run.crank_speed[:, 5]) - motor.inertia * run.crank_acceleration[:, 5]
    torque = pp.inverse_dynamics(legs, run).driving_torque
    np.testing.assert_allclose(torque, needed, rtol=0, atol=1e-8 * np.abs(needed).max())
    np.testing.assert_array_equal(run.drive_torque[:, 5], motor.torque(run.crank_speed[:, 5]))
    assert run.stats.energy_error < 1e-8


@pytest.mark.exhaustive
def test_two_servo_motors_follow_their_programs():
    """Their torques follow from time and angle; inverse dynamics of the run gives them back, and their works the energy."""
    press, time = five_bar(), np.linspace(0.0, 0.5, 41)
    swing = 0.3 * (1 - np.cos(4 * np.pi * time))
    motor = {"stiffness": 2e4, "damping": 900.0, "peak_torque": 5e3}
    rotor = pp.drives.ServoMotor(time, -5 * swing, stiffness=800.0, damping=36.0, peak_torque=1e3, inertia=0.02)
    drive: dict[str, pp.drives.Drive] = {"A": pp.drives.ServoMotor(time, swing, **motor), "B": pp.drives.Geared(rotor, ratio=5.0)}
    run = pp.simulate(press, 0.5, drive=drive, points=301)
    np.testing.assert_allclose(run.crank_angle[:, 0], 0.3 * (1 - np.cos(4 * np.pi * run.time)), rtol=0, atol=0.02)
    for k, name in enumerate(press.drivers):
        torque = drive[name].torque(run.crank_speed[:, k], run.crank_angle[:, k], run.time)
        np.testing.assert_allclose(run.drive_torque[:, k], torque, rtol=1e-12)
    needed = pp.inverse_dynamics(press, run).driving_torque + run.crank_acceleration * [0.0, 0.02 * 25]
    np.testing.assert_allclose(run.drive_torque, needed, rtol=0, atol=1e-9 * np.abs(needed).max())
    power = (run.drive_torque * run.crank_speed).sum(axis=1)
    assert run.drive_work[-1] == pytest.approx(np.trapezoid(power, run.time), abs=1e-3 * np.abs(run.drive_work).max())
    assert run.stats.energy_error < 1e-9
    assert "simulated from A 0 deg at 0 r/min, B 0 deg at 0 r/min, 0.5 s" in dict(inputs_of(pp.inverse_dynamics(press, run)))["motion"]


def test_a_program_that_stands_still_where_the_run_moves_is_doubted():
    press, time, motor = five_bar(), np.linspace(0.0, 0.5, 41), {"stiffness": 2e4, "damping": 900.0, "peak_torque": 5e3}
    swing = 0.3 * np.sin(4 * np.pi * time)
    drive = {"A": pp.drives.ServoMotor(time, swing, **motor), "B": pp.drives.Geared(pp.drives.ServoMotor(time, -5 * swing, **motor), 5.0)}
    speed = 0.3 * 4 * np.pi * np.array([1.0, -1.0])
    with pytest.warns(pp.PinpressWarning) as caught:
        pp.simulate(press, 0.01, speed=speed, drive=drive, points=2)
    said = [
        "the run begins with 36 r/min of A, where its ServoMotor's program",
        "the run begins with -36 r/min of B, where its ServoMotor's",
    ]
    assert [str(each.message)[: len(words)] for each, words in zip(caught, said, strict=True)] == said
    earlier, before = time - 0.1, 0.3 * np.sin(4 * np.pi * (time - 0.1))
    drive = {"A": pp.drives.ServoMotor(earlier, before, **motor), "B": pp.drives.ServoMotor(earlier, -before, **motor)}
    run = pp.simulate(press, 0.01, speed=speed, drive=drive, points=2)
    assert np.abs(run.drive_torque).max() < 100.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "reduced"}, "method='constraint' simulates it"),
        ({"drive": pp.drives.ConstantTorque(1.0)}, "give a Drive for each, drive={'left-roll-op': "),
        ({"drive": {"elbow": pp.drives.ConstantTorque(1.0)}}, "no driver 'elbow'"),
        ({"drive": {"left-roll-op": 5.0}}, "drive of 'left-roll-op' is 5.0"),
        ({"drive": {"left-roll-op": SLIPPING}}, "drive of 'left-roll-op' has states of its own"),
        ({"speed": [1.0, 2.0]}, "one of each of the 12 drivers"),
        ({"brake": pp.drives.Brake(5.0)}, "clutch and brake are for one"),
        ({"friction": {"left-roll-op": pp.loads.Friction(viscous=1.0)}}, "their runs know no friction in bearings; leave it out"),
    ],
)
def test_arguments_that_several_drivers_do_not_have_are_refused(legs, arguments, message):
    with pytest.raises(pp.PinpressError, match=message):
        pp.simulate(legs, 0.01, **{"method": "constraint", **arguments})


@pytest.mark.parametrize("more", [{"step": 1e-3}, {"loads": [pp.loads.TimeForce(lambda t: 1e5 + 0 * np.asarray(t))]}])
def test_a_prescribed_speed_leaves_nothing_to_integrate(more):
    with pytest.raises(pp.PinpressError, match="leaves nothing to integrate"):
        pp.simulate(texts.shipped("jf75g_125"), 0.3, drive=pp.drives.PrescribedSpeed(31.0), **more)


def two_slides(path):
    """Two blocks that slide upwards, 0.6 m apart, and two rods of 0.35 m from them to a common pin above."""
    body = (
        '<inertial><origin xyz="0.1 0 0"/><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>'
    )
    lines = ['<robot name="two_slides"><link name="frame"/>', *(f'<link name="{name}">{body}</link>' for name in "abcd")]
    for name, link, at in (("J1", "a", 0.0), ("J2", "b", 0.6)):
        lines.append(
            f'<joint name="{name}" type="prismatic"><parent link="frame"/><child link="{link}"/><origin xyz="{at} 0 0"/><axis xyz="0 0 1"/>'
            '<limit lower="-0.1" upper="0.1" effort="1" velocity="1"/></joint>'
            f'<transmission name="{name}_drive"><joint name="{name}"/></transmission>'
        )
    for name, parent, child in (("A", "a", "c"), ("B", "b", "d")):
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        lines.append(f'<joint name="{name}" type="continuous">{ends}<axis xyz="0 -1 0"/></joint>')
    height = (0.35**2 - 0.3**2) ** 0.5
    ends = f'<link1 link="c" xyz="0.3 0 {height!r}"/><link2 link="d" xyz="-0.3 0 {height!r}"/>'
    path.write_text("".join([*lines, f'<loop_joint name="C" type="spherical">{ends}</loop_joint></robot>']))
    return pp.load(path, slide="a")


def test_two_drivers_that_slide(tmp_path):
    press = two_slides(tmp_path / "press.urdf")
    time = np.linspace(0.0, 1.0, 21)
    positions = np.column_stack([0.05 * np.sin(time), 0.1 * (1 - np.cos(time))])
    motion = pp.servo_cycle(press, positions, time=time)
    apart = np.hypot(0.6, positions[:, 1] - positions[:, 0])  # of the ends of the rods, which are an isosceles triangle with it
    lean = np.arctan2(positions[:, 1] - positions[:, 0], 0.6) + np.arccos(apart / 0.7)
    np.testing.assert_allclose(motion.joint_position[:, press.joints.index("A")], lean - np.arccos(0.6 / 0.7), rtol=0, atol=1e-12)
    forces = pp.inverse_dynamics(press, motion)
    assert np.abs(forces.power_residual).max() < 1e-12
    heads = ["driver_position_J1 [m]", "driver_position_J2 [m]", "driving_force_J1 [N]", "driving_force_J2 [N]"]
    assert set(heads) <= set(forces.columns())
    with pytest.raises(pp.PinpressError, match=r"driver 'J1' slides from -100 mm to 100 mm only, .*, and is to be at 210.368 mm"):
        pp.servo_cycle(press, 5 * positions, time=time)
    with pytest.raises(pp.SimulationError, match="the driver slides only from -100 to 100 mm"):
        pp.simulate(press, 0.5, drive={"J1": pp.drives.ConstantTorque(100.0), "J2": pp.drives.ConstantTorque(100.0)})
    screw = pp.drives.Geared(pp.drives.ConstantTorque(0.5), 600.0, gear_inertia=2.0)
    run = pp.simulate(press, 0.02, drive={"J1": pp.drives.ConstantTorque(100.0), "J2": screw}, points=5)
    stated = dict(inputs_of(pp.inverse_dynamics(press, run)))
    assert stated["drive at J1"] == "constant torque: value = 100 N"
    assert stated["drive at J2"].startswith("geared: ratio = 600")
    assert stated["flywheels and drives"] == "inertia 0 kg at J1, 2 kg at J2"
    with pytest.raises(pp.PinpressError, match="driver 'J2' slides, but Flywheel needs a shaft"):
        pp.simulate(press, 0.5, flywheel={"J2": pp.drives.Flywheel(1.0)})
