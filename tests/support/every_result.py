"""One of each public class of data: of every result, and of every description that calls take."""

import dataclasses
import inspect
import re
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from support import cams, hammer_hits, texts
from support.generators.machine_elements import meshing
from support.sweep_points import fails_at_odd

import pinpress as pp
from pinpress import foundation
from pinpress.balancing import classical
from pinpress.common.results import Records
from pinpress.kinematics.measures import stroke
from pinpress.linkage.driving.freedoms import Freedom

SPEED = 7.0
DEEP = pp.loads.DeepDrawing(force=1e4, start=0.05)
X, Z = pp.balancing.Range("shaking_force", "x"), pp.balancing.Range("shaking_force", "z")
STIFFNESS = pp.elasticity.Stiffness({"W": 1e9, "P": 2e9, "O": 4e9}, {}, [pp.elasticity.Rod("rod", ("P", "W"), 5e8)], frame=8e9)
CAPACITIES = pp.ratings.Capacities(1e5, nominal_height=0.01, bearings={"W": 2e5}, flywheel_inertia=100.0, speed_drop=0.1, motor_power=2e4)
MOUNTS = [foundation.Mount((x, y, -0.5), (1e6, 1e6, 2e6), (1e3, 1e3, 2e3)) for x in (-1.0, 1.0) for y in (-0.5, 0.5)]
BEAM = foundation.FrameBeam("a", "b", 0.3, 0.2, (0, 0, 1))
ROTOR = foundation.Rotor(50.0, (0.0, 1.0, 0.0))
FRAME = foundation.Frame(6000.0, (0.0, 0.0, 0.2), np.diag([900.0, 1100.0, 700.0]))


@cache
def tabulated():
    """A press as a table of its angle."""
    return pp.export.tabulate(press(), ["W"])


def two_points():
    """A dimension of one of the points of the two-point press."""
    return {"P4_front": [pp.tolerances.link_length(texts.shipped("jf75g_125_two_point"), "P2_front", "P4_front", 1e-5)], "P4_back": []}


WARM = pp.tolerances.Temperatures({"rod": 10.0, "frame": 4.0}, table=-0.8)
SERVO = pp.servo.ServoDrive(inertia=0.1, ratio=10.0, peak_torque=500.0)
MEASUREMENT = pp.accuracy.Measurement("table", "reduced", "64 samples", 64.0, 1e-3, 1e-12)
ACCURACY = pp.accuracy.WorkPrecision(
    "crank_slide",
    "a turn",
    "a machine",
    {"table": pp.accuracy.Group("", "of a call", "of a table", 1e-14, "two methods")},
    Records(pp.accuracy.Measurement, [MEASUREMENT]),
    (),
)
PIN_TABLE = {
    "units": "mm",
    "parameters": {"r": 100},
    "frame": "O",
    "pins": {"O": [0, 0], "P": {"from": "O", "length": "r", "angle": -90}, "W": {"P": 400, "x": 0, "side": "down"}},
    "links": {
        "crank": {"pins": "O P", "mass": 20},
        "rod": {"pins": "P W", "mass": 15},
        "slide": {"pins": "W", "guide": "up", "mass": 90},
    },
    "drive": "O",
}
TOLERANCES = {"dimensions": {"length P W": {"tolerance": "0.05 mm"}}}  # of a job
TRIALS = []  # seen by the synthesis


def push(motion):
    """A force that a function of the motion gives."""
    return np.outer(motion.slide_velocity, [0.0, 0.0, -10.0])


def even(time):
    return np.full_like(time, 100.0)


@cache
def vibrations():
    """A record of three hits, of which a speed of the crank is said too."""
    return pp.measured.vibration(hammer_hits.columns(seconds=2.5), hammer_hits.SENSORS, speed=30.0)


@cache
def force_sensor():
    return pp.measured.force_sensor(press(), [0.0, 0.02, 0.04])


def one_turn():
    """A record of a turn from top to top."""
    time = np.arange(400) / 400 * 2 * np.pi / SPEED
    states = pp.servo_cycle(press(), pp.dead_centres(press()).top_angle + SPEED * time, speed=SPEED, acceleration=0.0)
    torque = pp.inverse_dynamics(press(), states).driving_torque + 0.5 * np.sin(1e4 * np.arange(400) ** 2)
    return pp.measured.MeasuredRun(time, states.crank_angle, torque)


@cache
def measured_force():
    return force_sensor().force(one_turn())


@cache
def hit_modes():
    return vibrations().modes(beside=foundation.modes(hammer_hits.standing()))


@cache
def press():
    return texts.shipped("crank_slide")


@cache
def motion():
    return pp.cycle(press(), SPEED, points=24)


@cache
def guided():
    guide = pp.elasticity.eight_way_guide(facing_x=(0.3, 0.2), facing_y=(0.2, 0.3), length=0.5, width=0.1, stiffness=1e9, clearance=1e-5)
    return pp.elasticity.guide_contact(press(), reactions(), guide, offset=(0.05, 0.02, 0.0))


def geared():
    """Reactions of a press with teeth."""
    teeth = pp.build(**meshing(efficiency=0.98))
    return pp.inverse_dynamics(teeth, pp.servo_cycle(teeth, angle=[0.0, -1.0, -2.0], speed=[-5.0] * 3, acceleration=[0.0] * 3))


@cache
def cam_reactions():
    return pp.inverse_dynamics(cams.press("ejector"), pp.cycle(cams.press("ejector"), SPEED, points=24))


@cache
def reactions():
    return pp.inverse_dynamics(
        press(), motion(), [DEEP, pp.loads.PointForce("slide", push)], {"W": pp.loads.Friction(coefficient=0.1, radius=0.05)}
    )


@cache
def rated_pins():
    plain = pp.ratings.PlainBearing(0.08, 0.08, pressure=4e7, wear_rate=1e-15)
    return pp.ratings.pins(reactions(), {"W": plain, "O": pp.ratings.RollingBearing(8e5, static_rating=1e6)})


@cache
def stops():
    return pp.ratings.stopping(press(), SPEED, 500.0, 0.02, 0.03, monitor=0.02, inertia=1.0)


@cache
def motor_choice():
    return pp.servo.choose_motor(press(), [MOTOR], [], ratios=[5.0], time=1.0, points=24)


@cache
def drive_choice():
    given = {"ratios": [15.0], "flywheels": (0.5, 1.0), "speeds": (9.0, 11.0), "speed_drop": 0.06}
    return pp.mains.choose_drive(press(), {"11 kW": MAINS}, [DEEP], **given)


MAINS = pp.drives.InductionMotor(11e3, 1465 * pp.RPM, inertia=0.055)
MOTOR = pp.servo.CatalogueMotor("short", 0.1, [0.0, 200.0], [100.0, 50.0], [500.0, 400.0])


@cache
def served():
    time = np.linspace(0.0, 1.0, 25)
    angle = 2 * np.pi * time
    return pp.servo.evaluate(press(), SERVO, [DEEP], time=time, angle=angle, speed=2 * np.pi, acceleration=0.0)


@cache
def best_motion():
    return pp.servo.best_motion(press(), SERVO, [DEEP], time=1.0, limits=[pp.servo.SlideSpeed(0.6, (0.1, 0.0))], points=24)


@cache
def allocated():
    return pp.tolerances.allocate(press(), [pp.tolerances.link_length(press(), "P", "W", 5e-5)], None, {"height": 2e-5})


@cache
def dimension_table():
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "dimensions.csv"
        table.write_text("dimension, tolerance\nlength P W, 0.05\n")
        return pp.tolerances.read_dimensions(press(), table)


@cache
def scattered():
    return pp.tolerances.bottom_dead_centre(press(), [pp.tolerances.link_length(press(), "P", "W", 5e-5)], samples=200)


@cache
def run():
    return pp.simulate(press(), 0.3, speed=SPEED, drive=pp.drives.ConstantTorque(50.0), flywheel=pp.drives.Flywheel(20.0), loads=[DEEP])


@cache
def motor_energy():
    motor = pp.drives.InductionMotor(11e3, 1450 * pp.RPM, load_loss=800.0, rated_rise=80.0, thermal_time=1800.0)
    drive, flywheel = pp.drives.Geared(motor, 1450 * pp.RPM / SPEED), pp.drives.Flywheel(20.0)
    return pp.measures.motor_energy(pp.simulate(press(), 0.1, speed=SPEED, drive=drive, flywheel=flywheel), initial_rise=20.0)


@cache
def on_springs():
    stiffness = pp.elasticity.Stiffness(dict.fromkeys(press().bearings, 2e8), moments={"slide_guide": 2e7})
    return pp.elasticity.Elastic(stiffness)


@cache
def elastic_run():
    drive = pp.drives.PrescribedSpeed(SPEED)
    return pp.steady_state(press(), SPEED, drive=drive, loads=[DEEP], elastic=on_springs(), points=20)


@cache
def campbell():
    return pp.elasticity.campbell(press(), on_springs(), speeds=[100.0, 500.0], orders=3)


@cache
def impacts():
    stiffness = pp.elasticity.Stiffness(dict.fromkeys(press().bearings, 2e7), moments={"slide_guide": 2e6})
    elastic = pp.elasticity.Elastic(stiffness, clearances={"P": pp.elasticity.Clearance(1e-4)})
    run = pp.simulate(press(), 0.43, drive=pp.drives.PrescribedSpeed(30.0), elastic=elastic, points=20)
    return pp.elasticity.journal_impacts(run, "P")


@cache
def run_over_joints():
    clutch = pp.drives.Clutch(torque=500.0, closes=pp.drives.SwitchPoint(time=0.01), rise=0.01)
    return pp.simulate(press(), 0.05, speed=SPEED, flywheel=pp.drives.Flywheel(20.0), clutch=clutch, method="constraint", points=10)


@cache
def runs():
    """The last one stalls."""
    load = pp.loads.ForceStroke([0.0, 0.2], [3e4, 3e4])
    return pp.simulate_batch(press(), 0.3, speed=np.array([SPEED, 20.0, 0.1]), flywheel=pp.drives.Flywheel(20.0), loads=[load], points=5)


@cache
def sweep():
    return pp.sweeps.sweep(fails_at_odd, {"a": [1, 2, 3]})


@cache
def balance():
    return pp.balancing.balance(
        press(), motion(), regions=[pp.balancing.CounterweightRegion("crank", radius=0.2, mass=(0, 50))], minimise=Z, limits={X: 1e5}
    )


@cache
def synthesis():
    limits = {"stroke": (long_stroke, None, 0.3)}
    return pp.synthesis.synthesise(press(), minimise=shortest, subject_to=limits, **CRANK_LENGTH)


@cache
def held():
    """A synthesis that a bound holds."""
    return pp.synthesis.synthesise(press(), minimise=long_stroke, **CRANK_LENGTH)


def checked():
    found = pp.check(press().file)
    freedom = Freedom("swing", ("A",), ("rod",), True, 0.012)
    return (
        found,
        pp.propose_drivers(press()),
        freedom,
        *found.findings,
        found.facts,
        *found.facts.closings,
        *found.facts.bearings,
        found.facts.data,
    )


def shortest(trial):
    TRIALS.append(trial)
    return (long_stroke(trial) - 0.15) ** 2


def long_stroke(trial):
    return stroke(trial.motion)


def crank(radius):
    return {("P", "crank"): (radius, 0, 0)}


CRANK_LENGTH = {"variables": {"radius": (0.05, 0.1, 0.2)}, "geometry": crank, "speed": SPEED, "points": 24}


@cache
def mounted():
    return foundation.mounted(press(), FRAME, MOUNTS)


def hammered():
    """Feet that lift off, by a force on the frame of three times its weight."""
    force = pp.loads.PointForce(press().root, lambda motion: np.outer(np.sin(motion.crank_angle), [0.0, 0.0, 2e5]))
    return foundation.lifting_response(mounted(), pp.inverse_dynamics(press(), motion(), loads=[force]), points={"head": (0.0, 0.0, 1.0)})


@cache
def response():
    return foundation.steady_response(mounted(), reactions(), points={"head": (0.0, 0.0, 1.0)})


@cache
def trade_off():
    return pp.balancing.trade_off(
        press(),
        motion(),
        regions=[pp.balancing.CounterweightRegion("crank", radius=0.2, mass=(0, 50))],
        first=X,
        second=pp.balancing.AddedMass(),
        points=2,
    )


@cache
def leg():
    return pp.load(Path(__file__).resolve().parents[2] / "docs" / "robots" / "leg.urdf")


@cache
def limit_uses():
    return pp.measures.joint_limits(pp.inverse_dynamics(leg(), pp.servo_cycle(leg(), [[0.0, 0.1], [0.1, 0.2]], speed=1.0)))


@cache
def workspace():
    return pp.measures.workspace(leg(), "foot", {"hip": (-0.5, 0.5), "crank": (-1.4, 0.4)}, points=5)


@cache
def compared_conditions():
    conditions = [pp.balancing.OperatingCondition(motion(), name=name) for name in ("one", "two")]
    regions = [pp.balancing.CounterweightRegion("crank", radius=0.2, mass=(0, 50))]
    return pp.balancing.compare_conditions(press(), conditions, regions=regions, minimise=X)


@cache
def two_cranks():
    return classical.with_opposed_balancer(press(), 0.05)


@cache
def measured_run():
    time = np.linspace(0.0, 3.0, 601)
    angle = 8.0 * time + np.sin(2.5 * time)
    torque = pp.inverse_dynamics(press(), pp.servo_cycle(press(), angle, time=time)).driving_torque
    return pp.measured.MeasuredRun(time, angle, torque + 20.0 + np.random.default_rng(0).normal(size=len(time)))


@cache
def identified():
    return pp.measured.identify(press(), [measured_run()], friction=("crank",))


@cache
def identifiable():
    return pp.measured.identifiability(press(), [measured_run()], friction=("crank",))


def descriptions():
    """One of each public class of what callers describe, with numbers that differ from the defaults."""
    losses = {"load_loss": 800.0, "constant_loss": 200.0, "rated_rise": 80.0, "thermal_time": 1800.0}
    switches = {"closes": pp.drives.SwitchPoint(time=1.0), "opens": pp.drives.SwitchPoint(time=2.0)}
    cylinder = {"rod": 0.03, "count": 2, "exponent": 1.4, "datum": 0.0}
    measured = {"quantity": "bearing_force", "axis": "x", "bearing": "O"}
    return [
        pp.loads.Friction(0.1, 0.02, viscous=0.1),
        pp.loads.SpringDamper("frame", "slide", 1e4, damping=10.0, free_length=0.3, point1=(0.0, 0.0, 1.0)),
        pp.loads.PointForce("slide", (0.0, 0.0, 1.0)),
        pp.loads.PointMoment("rod", (0.0, 1.0, 0.0), on="crank"),
        pp.JointSpring("O", 100.0, reference=0.1, damping=2.0),
        pp.loads.TorsionSpring("crank", "rod", 500.0, damping=1.0, free_angle=0.2),
        DEEP,
        pp.loads.ForceStroke([0.0, 0.1], [1e3, 2e3]),
        pp.loads.TimeForce(even, edges=[0.1]),
        pp.loads.Idle(0.0),
        pp.loads.ConstantForce(1e5, 0.02, datum=0.0),
        pp.loads.Blanking(1e5, 0.02, 0.01, stripping=1e3),
        pp.loads.RateSensitiveBlanking(1e5, 0.02, 0.01, 0.05, 1e-3, peak=0.015, stripping=1e3),
        pp.loads.ElasticDie(0.01, 1e7, damping=10.0),
        pp.loads.Impact(0.01, 1e7, damping=1e3, depth=1e-3),
        pp.loads.TwoSidedStop(0.01, 0.02, 1e7, damping=10.0, depth=1e-3),
        pp.loads.ImpactDamper([0.0, 0.01], [1e5, 1e5], exponent=2.0),
        pp.loads.HydraulicCushion(1e4, 0.01, rise=1e-3, return_force=1e3),
        pp.loads.BalanceCylinder(0.1, 6e5, 0.02, height=0.0, **cylinder),
        pp.loads.PneumaticCushion(0.1, 6e5, 0.02, 0.01, **cylinder),
        pp.drives.Flywheel(2.0, speed=SPEED),
        pp.drives.ConstantTorque(3.0),
        pp.drives.SwitchPoint(time=0.1),
        pp.drives.Corner(10.0, jump=True),
        pp.drives.Brake(100.0, **switches, rise=0.1),
        pp.drives.Clutch(100.0, **switches, rise=0.1),
        pp.drives.DirectCurrentLink(0.05, 450.0, 560.0, 750.0, mains_power=3e4),
        pp.drives.InductionMotor(11e3, 150.0, frequency=50.0, poles=4, inertia=0.1, **losses),
        pp.drives.InverterMotor(70.0, 150.0, 30.0, curve=[(10.0, 70.0), (50.0, 60.0)], inertia=0.1, feeds_back=True, **losses),
        pp.drives.ServoMotor([0.0, 1.0], [0.0, 7.0], 1e3, 1e2, 500.0, inertia=0.1, copper=0.01, regeneration=0.5),
        pp.drives.SlipClutchMotor(70.0, 160.0, 150.0, 100.0, feedback=0.9, residual_current=0.1, excitation_power=100.0, **losses),
        pp.drives.PrescribedSpeed(7.0),
        pp.drives.Geared(pp.drives.ConstantTorque(3.0), 4.0, gear_inertia=0.1, efficiency=0.9),
        X,
        pp.balancing.Peak(**measured),
        pp.balancing.Rms(**measured),
        pp.balancing.AddedMass(),
        pp.balancing.CounterweightRegion("crank", mass=(0.0, 10.0), radius=0.2, gyration=0.1),
        pp.balancing.Counterweight("crank", 1.0, position=(0.1, 0.0, 0.0), inertia=0.1),
        pp.balancing.OperatingCondition(motion(), press=press(), name="one"),
        STIFFNESS,
        *STIFFNESS.rods,
        pp.elasticity.Elastic(STIFFNESS, crown_mass=2000.0, dampers={"O": 1e4}),
        pp.elasticity.Clearance(1e-4, law="hertz", restitution=0.7, hertz_stiffness=1e10),
        pp.elasticity.PreloadedJoint(1e9, 3e9, 1e5),
        pp.elasticity.GuideSurface("right", (0.2, 0.0, 0.0), (1.0, 0.0, 0.0), 0.5, 0.1, 1e9, preload=2e4),
        pp.elasticity.FlexibleLink(**flexible_rod()),
        CAPACITIES,
        pp.ratings.Gibs(0.3, 0.1, normal=(1.0, 0.0, 0.0), middle=0.1),
        pp.ratings.PlainBearing(0.08, 0.09, pressure=4e7, wear_rate=1e-15),
        pp.ratings.RollingBearing(8e5, kind="ball", count=2, static_rating=1e6),
        pp.tolerances.link_length(press(), "P", "W", 5e-5),
        pp.tolerances.GuideClearance(2e-5, 0.2),
        pp.tolerances.PermissibleSlope(2e-5, 6e-5, 1e5, (0.1, 0.0)),
        WARM,
        SERVO,
        MOTOR,
        pp.servo.Turn(),
        pp.servo.Stop(0.1),
        pp.servo.Pendulum(0.05, dwell=0.1),
        pp.servo.Pulse((0.02, 0.01, 0.0), back=0.005, dwell=0.1),
        pp.servo.SlideSpeed(1.0, (0.1, 0.0)),
        pp.servo.CrankSpeed(20.0, (0.05, 0.0)),
        pp.servo.RmsTorque(50.0),
        pp.servo.SlideAcceleration(50.0, (0.05, 0.0)),
        pp.servo.CrankAcceleration(500.0),
        pp.servo.BearingForce("W", 1e5),
        pp.servo.FeedWindow(0.1, 0.2),
        pp.servo.TorqueRate(1e5),
        pp.measured.Accelerometer((0.5, 0.2, 1.0), "z", gain=9.81),
        measured_run(),
        FRAME,
        *MOUNTS[:1],
        BEAM,
        ROTOR,
        foundation.Attachment(FRAME, springs=MOUNTS),
        foundation.RubberPad(0.1, 0.1, 0.01, hardness=50, loss_factor=0.1),
        pp.Header(title="Press 3", company="Muster AG", drawing="4711-03", author="J. Doe", revision="B", date="today", notes="one\ntwo"),
    ]


def flexible_rod():
    """Two points on a spring that does not bend: what describes them."""
    stiffness = np.kron([[1, -1], [-1, 1]], np.diag([1e9, 0.0]))
    matrices = {"mass": np.eye(4), "stiffness": stiffness, "nodes": [[0.0, 0.0], [0.5, 0.0]], "degrees": [[0, 0], [0, 1], [1, 0], [1, 1]]}
    return matrices | {"link": "rod", "bearings": {"P": 0, "W": 1}, "modes": 2, "damping_ratio": 0.01}


@cache
def made():
    """One of each: descriptions and results."""
    budget = pp.tolerances.budget(press(), speeds=[SPEED], stiffness=STIFFNESS, process=1e4)
    loose = pp.tolerances.budget(press(), speeds=[SPEED], clearance={"W": 1e-5})
    opposed = pp.inverse_dynamics(two_cranks(), pp.cycle(two_cranks(), SPEED, points=24))
    return [
        *descriptions(),
        *(press(), motion(), reactions(), run(), run().stats, elastic_run(), impacts(), run_over_joints(), runs()),
        *(sweep(), *sweep().failed),
        *(
            pp.dead_centres(press()),
            pp.measures.duty_cycle(run()),
            *pp.measures.least_transmission_angles(press()),
            limit_uses()[0],
            *checked(),
            workspace(),
            pp.measures.trace(press(), motion(), "rod", (0.1, 0.0, 0.05), "T"),
            pp.measures.poles(press(), motion(), "rod", "frame"),
            pp.measures.polygons(press(), motion(), 3),
            *pp.measures.grashof(press()),
            pp.measures.cam(cams.press("ejector"), cam_reactions(), "eject"),
        ),
        *(pp.measures.phases(motion(), 0.05)[0], pp.measures.transmission_angle_curves(press(), motion()), motor_energy()),
        *(
            geared().mesh["teeth"],
            pp.measures.driving_energy(reactions()),
            pp.measures.harmonics(motion(), motion().v),
            pp.measures.extremes(reactions())[0],
        ),
        *(balance(), *balance().changes, *balance().active, *balance().counterweights, trade_off(), compared_conditions()),
        pp.synthesis.trade_off(press(), first=shortest, second=long_stroke, designs=2, **CRANK_LENGTH),
        *(synthesis(), synthesis().table()[0], *held().active, *TRIALS[:1]),
        pp.elasticity.flexible_beam(press(), "rod", ("P", "W"), area=0.01, second_moment=1e-5, elements=3),
        pp.elasticity.compliance(press(), STIFFNESS, angle=[0.1, 0.5]),
        pp.elasticity.slide_deflection(press(), motion(), STIFFNESS),
        pp.elasticity.dead_centre_shift(press(), STIFFNESS, speed=[1.0, SPEED]),
        pp.elasticity.snap_through(1e6, 6e8, mass=2600.0),
        pp.elasticity.natural_frequencies(press(), on_springs(), angle=[0.1, 0.5], flywheel=pp.drives.Flywheel(2.0)),
        pp.elasticity.over_speeds(press(), on_springs(), speeds=[6.0, SPEED]),
        *(guided(), guided().surfaces[0], guided().opened[0], campbell(), campbell().resonances[0]),
        *(pp.ratings.rate(press(), SPEED, CAPACITIES, points=9), pp.ratings.speed_limit(press(), CAPACITIES)),
        *(drive_choice(), *drive_choice().tried),
        *(rated_pins(), *rated_pins().uses.values(), pp.fe.load_cases(press(), reactions(), "rod"), tabulated()),
        *(stops(), stops().worst, *stops().cases.values(), stops().distance("ANSI B11.19", resolution=0.014)),
        pp.ratings.rate_motion(press(), pp.cycle(press(), 1.0, points=9), pp.ratings.Capacities(1e5, drivers={"O": 5e4})),
        pp.ratings.eccentric_load(
            press(), pp.servo_cycle(press(), speed=0.0, angle=[0.1]), force=1e5, offset=(0.02, 0.0, 0.0), gibs=pp.ratings.Gibs(0.3, 0.1)
        ),
        pp.sweeps.operating_points(press(), [5.0, SPEED], forces=[0.0, 1e3], unit_load=DEEP, points=8, angles=True),
        *(
            force_sensor(),
            measured_force(),
            pp.measured.plan(press(), pp.measured.measuring_motions(press(), [SPEED], count=4), noise=20.0),
        ),
        *(vibrations(), vibrations().spectra(), vibrations().order_spectra(3), hit_modes()),
        pp.measured.fit_mounts(hammer_hits.standing(), hit_modes()),
        *(identified(), identified().parameters[0], identifiable(), identifiable().parameters[0]),
        pp.derivatives.acceleration_derivatives(press(), motion()),
        *pp.derivatives.motion_derivatives(press(), motion(), [{("P", "crank"): (1, 0, 0)}]),
        *(scattered(), scattered().height, allocated(), dimension_table(), pp.tolerances.heat(press(), WARM)),
        *(budget, *loose.conditions, pp.tolerances.parallelism(texts.shipped("jf75g_125_two_point"), two_points(), samples=50)),
        *(pp.tolerances.play(press(), motion(), {"W": 5e-5}), pp.tolerances.play_over_speeds(press(), {"W": 5e-5}, speed=[SPEED, 12.0])),
        *pp.tolerances.play(press(), pp.cycle(press(), 15.0, points=24), {"W": 5e-5}).reversals[:1],
        *(best_motion(), *best_motion().limits[:1], served(), pp.servo.vdi_law("3-4-5"), pp.servo.capacitor(served())),
        pp.servo.trade_off(press(), SERVO, times=[1.0], path=pp.servo.Stop(), points=24)[0],
        *(pp.servo.motor_use(MOTOR, served()), pp.servo.compare_motions({"even": served()})),
        *(*pp.servo.compare_motions({"even": served()}).rows, pp.servo.controller_table(served(), step=0.05)),
        *(pp.servo.cam_table(press(), motion(), tolerance=1e-4), pp.measures.windows(motion(), 0.05)[0]),
        pp.measures.timing(press(), motion(), 0.05, feed_time=0.1, loads=[DEEP], bars={"muting": (3.5, 5.5)}),
        *(motor_choice(), *motor_choice().tried),
        *(mounted(), response(), foundation.modes(mounted()), hammered()),
        foundation.beam_frame({"a": (0, 0, 0), "b": (0, 1, 0)}, [BEAM], bed="a", carrier="b", elements=1),
        foundation.whirl(foundation.mounted(press(), FRAME, MOUNTS, rotors=[ROTOR]), [5.0, SPEED]),
        foundation.over_speeds(mounted(), [5.0, SPEED], points={"head": (0.0, 0.0, 1.0)}),
        foundation.isolate(press(), FRAME, MOUNTS, speeds=[40.0, 50.0], transmitted=0.5),
        *DEEP.intervals(True),
        *(ACCURACY, *ACCURACY.groups.values(), MEASUREMENT),
        pp.pin_table.draft(**PIN_TABLE),
        pp.job("crank_slide", loads={"draw": DEEP}, speed=SPEED, capacities={"nominal_force": 1e5}, tolerances=TOLERANCES),
        *(classical.as_crank_slider(press()), classical.unbalance(press(), "crank")),
        classical.static_balance([2.0], [[0.1, 0.0, 0.0]]),
        *classical.compare_harmonics(reactions(), opposed, orders=2)[:1],
    ]


def rooms():
    """All modules of public names."""
    return [pp, *filter(inspect.ismodule, (getattr(pp, name) for name in dir(pp))), classical]


def public():
    """All public classes of data."""
    named = [getattr(room, name) for room in rooms() for name in dir(room)]
    return {kind for kind in named if inspect.isclass(kind) and dataclasses.is_dataclass(kind)}


# What public functions return and results hold that is no result.
DESCRIPTIONS = {
    "DriverCoordinate",
    "Dimension",
    "GuideClearance",
    "PermissibleSlope",
    "Temperatures",
    "AddedMass",
    "Clearance",
    "Elastic",
    "FlexibleLink",
    "Flywheel",
    "Geared",
    "InductionMotor",
    "Capacities",
    "Frame",
    "Friction",
    "Job",
    "Link",
    "Linkage",
    "Criterion",
    "Mount",
    "OperatingCondition",
    "CatalogueMotor",
    "ServoDrive",
    "ServoMotor",
    "Corner",
    "Parameter",
    "Parts",
    "Pin",
    "PlainBearing",
    "RollingBearing",
    "Stiffness",
    "Tool",
    "Tree",
}  # callers give these
SOLUTION = {"ClosedStates", "SimulationProblem", "Trajectory"}  # behind a motion: the equations and what solves them
HOLDERS = {"NamedArrays", "Records"}  # of arrays, and of results


def returned():
    """All classes of data that public functions return, with those that their members are, and so on."""
    found, left = set(), [function for room in rooms() for name in dir(room) if inspect.isfunction(function := getattr(room, name))]
    while left:
        for kind in _named_in_returns(left.pop()):
            if kind.__name__ not in DESCRIPTIONS | SOLUTION | HOLDERS and kind not in found:
                found.add(kind)
                left += [member for base in kind.__mro__ for name, member in vars(base).items() if not name.startswith("_")]
                left += [base for base in kind.__mro__ if base.__module__.startswith("pinpress.")]
    return found


def _named_in_returns(made):
    """Classes of data of ours in the annotations of what a function returns, or of the public fields of a class."""
    made = inspect.unwrap(getattr(made, "fget", None) or getattr(made, "func", None) or getattr(made, "__func__", made))
    if inspect.isclass(made):
        words = [note for name, note in inspect.get_annotations(made).items() if not name.startswith("_")]
    elif inspect.isfunction(made):
        words = [inspect.get_annotations(made).get("return", "")]
    else:
        return
    for name in re.findall(r"[A-Za-z]\w*", " ".join(map(str, words))):
        kind = getattr(sys.modules[made.__module__], name, None)
        if inspect.isclass(kind) and kind.__module__.startswith("pinpress.") and not issubclass(kind, Exception):
            yield kind
