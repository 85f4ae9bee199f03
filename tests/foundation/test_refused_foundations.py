"""What parts of frames, presses on mounts and their responses refuse, each with its message: a table of (call, message)."""

import functools

import numpy as np
import pytest
from support.generators import frames
from support.generators.frames import harmonic_force, on_four, turns, uneven, weightless
from support.generators.period_presses import five_bar, of_two_motors
from support.texts import shipped

import pinpress as pp
from pinpress import foundation

HEAVY = {"mass": 1000.0, "centre": (0, 0, 0), "inertia": (300, 300, 300)}
PAD = {"length": 0.1, "width": 0.1, "thickness": 0.01}
BODY = foundation.Frame(100.0, (0, 0, 0), (1, 1, 1))
ROTOR = foundation.Rotor(10.0, (0, 1, 0))
BEAM = {"width": 0.3, "height": 0.2, "across": (0, 0, 1)}
TWO = {"a": (0, 0, 0), "b": (1, 0, 0)}
POINTS = {"top": (0.3, 0.2, 1.5)}
MASS, KZ = 1000.0, 1e5
CENTRED = foundation.Frame(MASS, (0, 0, -1.0), (500, 500, 500))
CENTRE = {"centre": (0, 0, -1.0)}
STEEL = foundation.Frame(15000, (0, 0, -0.6), (9000, 8000, 4000))
SPRINGS = on_four((2e6, 2e6, 2e6), (2e3, 2e3, 2e3), height=-0.6)
SPEEDS = np.linspace(200, 400, 11) * pp.RPM
FEET = [foundation.Mount(foot, (8e6, 8e6, 9e8), (2e4, 3e4, 4e5)) for foot in frames.FEET.values()]
JUMPING = pp.loads.PointForce("frame", lambda motion: np.outer(motion.crank_angle > 3.0, [0, 0, 1e5]))
PERIOD = np.pi / 3  # of two motors, 12 and 6 rad/s


def light(press=None, frame=None, mounts=None, **more):
    """A press without mass on a frame and four mounts."""
    mounts = on_four((1e6, 1e6, 1e6)) if mounts is None else mounts
    return foundation.mounted(press or weightless(), frame or foundation.Frame(**HEAVY), mounts, **more)


def uneven_press(**more):
    return foundation.mounted(shipped("crank_slide"), *uneven(), **more)


def spinning():
    return uneven_press(rotors=[ROTOR])


@functools.cache
def shaken():
    return foundation.mounted(shipped("jf75g_125"), *uneven())


def one_mass():
    return foundation.mounted(weightless(), CENTRED, on_four((1e6, 1e6, KZ)))


def steady(system=None, speed=20.0, loads=(), reactions=None, **more):
    """The steady response of a press on its mounts at constant speed, or to other reactions."""
    system = shaken() if system is None else system
    if reactions is None:
        reactions = pp.inverse_dynamics(system.press, pp.cycle(system.press, speed, points=60), loads=loads)
    return foundation.steady_response(system, reactions, **more)


def of_plain_press():
    press = shipped("jf75g_125_plain")
    return pp.inverse_dynamics(press, pp.cycle(press, 20.0, points=60))


def swinging():
    press = shipped("jf75g_125")
    return pp.inverse_dynamics(press, pp.servo_cycle(press, speed=[1.0, 2.0, 3.0], angle=[0.0, 0.1, 0.3], acceleration=0.0))


def pushed(amplitude, count=1):
    """A force on the frame along z, amplitude times the weight, a sine of the crank angle."""
    press, push = weightless(), amplitude * MASS * 9.81

    def force(motion):
        return np.outer(push * np.sin(motion.crank_angle), [0.0, 0.0, 1.0])

    return pp.inverse_dynamics(press, turns(press, 20.0, count, 90), loads=[pp.loads.PointForce(press.root, force)])


def slipping():
    """A run in which a clutch slips."""
    press, clutch = shipped("jf75g_125"), pp.drives.Clutch(torque=2000.0, closes=pp.drives.SwitchPoint(time=0.0))
    wheel = pp.drives.Flywheel(136.0, speed=30.0)
    return pp.inverse_dynamics(press, pp.simulate(press, 0.02, speed=0.0, flywheel=wheel, clutch=clutch, points=21))


@functools.cache
def motors():
    """Reactions of a press with two motors."""
    press, time = of_two_motors(), PERIOD * np.arange(720) / 720
    return pp.inverse_dynamics(press, pp.servo_cycle(press, np.outer(time, [12.0, 6.0]), time=time, period=PERIOD))


@functools.cache
def on_motors():
    return foundation.mounted(of_two_motors(), *uneven(), motion=motors().motion)


def rotors_that_change_their_speed():
    press, time = five_bar(0.5), np.arange(360) / 360
    motion = pp.servo_cycle(press, 4 * np.pi * time + 0.5 * np.sin(2 * np.pi * time), time=time, period=1.0)
    system = foundation.mounted(press, *uneven(), rotors=[foundation.Rotor(50.0, (0, -1, 0))], motion=motion)
    return foundation.steady_response(system, pp.inverse_dynamics(press, motion), points=POINTS, period=1.0)


def box(**more):
    return foundation.FrameBeam("a", "b", **BEAM | more)


def simple(places=TWO, beam=None, **more):
    return foundation.beam_frame(places, [beam or box()], **{"bed": "a", "carrier": "b"} | more)


def matrices(**more):
    """Two bodies at one place, joined in all six directions."""
    joined = np.kron([[1.0, -1.0], [-1.0, 1.0]], 1e6 * np.eye(6))
    given = {"nodes": [(0, 0, 0), (0, 0, 0)], "degrees": [(k, i) for k in (0, 1) for i in range(6)], "interfaces": {"a": 0, "b": 1}}
    return foundation.reduced_frame(**{"mass": np.eye(12), "stiffness": joined, "bed": "a", "carrier": "b"} | given | more)


def on_frame(mounts=FEET, **more):
    return foundation.mounted(shipped("jf75g_125"), frames.of_beams(), mounts, **more)


def odd_bearing():
    return foundation.beam_frame(frames.PLACES, frames.members(), bed="bed", carrier="crown", bearings={"P2": "bed"}, elements=1)


def on_two_supports():
    places = {"a": (0, -1, 0), "b": (0, 1, 0)}
    bent = foundation.beam_frame(places, [foundation.FrameBeam("a", "b", 0.4, 0.3, (1, 0, 0))], bed="a", carrier="b")
    return foundation.mounted(weightless(), bent, [foundation.Mount(place, (1e6, 1e6, 1e6)) for place in places.values()])


def nothing_shakes():
    press = weightless()
    return pp.inverse_dynamics(press, pp.cycle(press, 3.0, points=32))


def isolate(**more):
    return foundation.isolate(shipped("jf75g_125_plain"), STEEL, SPRINGS, speeds=SPEEDS, **more)


def shaken_by_motors(flywheel):
    return steady(on_motors(), reactions=motors(), points=POINTS, period=PERIOD, flywheel=flywheel)


REFUSALS = [
    (lambda: foundation.RubberPad(**PAD), "either hardness"),
    (lambda: foundation.RubberPad(**PAD, hardness=50, shear_modulus=1e6), "either hardness"),
    (lambda: foundation.RubberPad(**PAD, hardness=95), "hardness is 95; give 20 to 80"),
    (lambda: foundation.RubberPad(**PAD | {"thickness": 0.0}, hardness=50), "thickness is 0.0"),
    (lambda: foundation.RubberPad(**PAD, hardness=50, stiffening=0.5), "stiffening is 0.5"),
    (lambda: foundation.RubberPad(**PAD, hardness=float("nan")), "hardness is nan"),
    (lambda: foundation.Mount((0, 0), (1, 1, 1)), r"point is \(0, 0\)"),
    (lambda: foundation.Mount((0, 0, 0), (1, 1, -1)), "stiffness is"),
    (lambda: foundation.Mount((0, 0, 0), (1, 1, 1), loss_factor=-0.1), "loss_factor is -0.1"),
    (lambda: foundation.Mount((0, 0, 0), (1, 1, 1), area=0.0), "area is 0.0"),
    (lambda: foundation.Mount((0, 0, 0), "stiff"), "stiffness is 'stiff'"),
    (lambda: foundation.pad_mount((0, 0, 0), None), "pad is a NoneType, no RubberPad"),
    (lambda: foundation.Frame(**HEAVY | {"mass": -1.0}), "mass is -1.0"),
    (lambda: foundation.Frame(**HEAVY | {"inertia": (1, 1, 3)}), "no body has this inertia"),
    (lambda: foundation.Frame(**HEAVY | {"inertia": np.eye(3) + np.eye(3, k=1)}), "symmetric"),
    (lambda: foundation.Frame(**HEAVY | {"centre": (0, 0, np.inf)}), "centre is"),
    (lambda: foundation.logarithmic_decrement(np.arange(5.0)), "of 5 samples does not swing"),
    (lambda: foundation.logarithmic_decrement(np.arange(50.0)), "shorter than two periods"),
    (lambda: foundation.logarithmic_decrement(np.sin(np.arange(50.0)), rate=2.0, band=(0.5, 1.5)), "half the rate, 1 Hz"),
    (lambda: foundation.modes(None), "system is a NoneType"),
    (lambda: light(mounts=[]), "give a list of Mount"),
    (lambda: light(mounts=on_four((1e6, 1e6, 1e6))[:1]), "leave the frame free in turn"),
    (lambda: light(mounts=on_four((0.0, 1e6, 1e6))), "leave the frame free in x"),
    (lambda: light(frame=foundation.Frame(0.0, (0, 0, 0), (0, 0, 0))), "no inertia for"),
    (lambda: light(frame=foundation.Frame(**HEAVY | {"centre": (2.0, 0, 0)})), "mount 1 of 4 would be pulled"),
    (lambda: light(frame=foundation.Frame(**HEAVY | {"centre": (0, 0, 50.0)}), mounts=on_four((1e5, 1e5, 1e5))), "tips over"),
    (lambda: light(crown=foundation.Frame(**HEAVY)), "crown and uprights go together"),
    (lambda: light(press="crank_slide"), "press is a str"),
    (lambda: foundation.Rotor(-1.0, (0, 1, 0)), "inertia is -1.0"),
    (lambda: foundation.Rotor(1.0, (0, 0, 0)), "x, y, z of a direction"),
    (lambda: foundation.Rotor(1.0, (0, 1)), "axis"),
    (lambda: foundation.Rotor(1.0, (0, 1, 0), on=3), "on is 3"),
    (lambda: foundation.Attachment("motor"), "body is 'motor'"),
    (lambda: foundation.Attachment(BODY, springs=[1]), "springs is"),
    (lambda: foundation.Attachment(BODY, on=1), "on is 1"),
    (lambda: uneven_press(attached={"frame": foundation.Attachment(BODY)}), "a name other than frame"),
    (lambda: uneven_press(attached={"motor": BODY}), "give an Attachment"),
    (lambda: uneven_press(attached={"motor": foundation.Attachment(BODY, on="crown")}), "no part of the frame 'crown'"),
    (lambda: uneven_press(rotors=[foundation.Rotor(1.0, (0, 1, 0), on="crown")]), "no part of the frame 'crown'"),
    (lambda: uneven_press(rotors=[1.0]), "give a list of Rotor"),
    (lambda: foundation.whirl(uneven_press(), [1.0]), "nothing spins"),
    (lambda: foundation.whirl(spinning(), [2.0, 1.0]), "speeds is"),
    (lambda: foundation.whirl(spinning(), [0.0]), "speeds is"),
    (lambda: foundation.whirl(spinning(), [1.0]).critical_speeds(0), "order is 0"),
    (lambda: steady(spinning(), points={}, flywheel=pp.drives.Flywheel(1.0)), "leave out flywheel="),
    (lambda: box(width=-1.0), "width is -1.0"),
    (lambda: box(wall=0.1), "fills the box"),
    (lambda: box(across=(0, 0, 0)), "x, y, z of a direction"),
    (lambda: foundation.FrameBeam(1, "b", **BEAM), "names of places"),
    (lambda: simple(beam=box(across=(1, 0, 0))), "lies along it"),
    (lambda: simple({"a": (0, 0, 0)}), "at least two"),
    (lambda: simple({"a": (0, 0, 0), "b": (0, 0, 0)}), "are one"),
    (lambda: simple({"a": (0, 0, 0), "b": (0, 1)}), "place 'b'"),
    (lambda: simple(TWO | {"frame": (0, 1, 1)}), "another name"),
    (lambda: simple(TWO | {"c": (0, 1, 1)}), "no beam reaches c"),
    (lambda: simple(beam=foundation.FrameBeam("a", "d", **BEAM)), "no place 'd'"),
    (lambda: simple(bed="c"), "no interface for bed 'c'"),
    (lambda: simple(bearings={"O": "c"}), "no interface for O 'c'"),
    (lambda: simple(elements=0), "elements is 0"),
    (lambda: simple(modes=-1), "modes is -1"),
    (lambda: simple(loss_factor=-0.1), "loss_factor is -0.1"),
    (lambda: foundation.beam_frame(TWO, [], bed="a", carrier="b"), "at least one"),
    (lambda: simple().stiffness_between("a", "c"), "no interface 'c'"),
    (lambda: simple().stiffness_between("a", "b"), "would turn the frame"),
    (lambda: simple().stiffness_between("a", "b", axis="up"), "axis is 'up'"),
    (lambda: matrices(mass=np.eye(6)), "give both for the same rows"),
    (lambda: matrices(stiffness=np.eye(12)), "resists when the frame moves as a whole"),
    (lambda: matrices(stiffness=np.zeros((12, 12))), "more than six of its motions cost no energy"),
    (lambda: matrices(mass=-np.eye(12)), "not positive semidefinite"),
    (lambda: matrices(mass=np.diag([1.0] * 9 + [0.0] * 3)), "interface 'b' along .* moves no mass"),
    (lambda: matrices(degrees=[(0, 0)] * 12), "row 1 of degrees is 0, 0, as another row is"),
    (lambda: matrices(degrees=[(k, i) for k in (1, 2) for i in range(6)]), "row 6 of degrees is 2, 0: .* from 0 to 1"),
    (lambda: matrices(interfaces={}), "give a mapping"),
    (lambda: matrices(interfaces={"a": 0, "b": 0}), "name it once"),
    (lambda: matrices(interfaces={"a": 0, "frame": 1}), "another name"),
    (lambda: matrices(lines=[(0, 5)]), "lines join nodes"),
    (lambda: matrices(lines=[(0, 0.5)]), "from 0 to 1"),
    (lambda: matrices(degrees=[(0, i) for i in range(6)] + [(1, 0)] + [(-1, -1)] * 5), "does not have all six degrees of freedom"),
    (lambda: on_frame([foundation.Mount((0, 0, 9), (1e6,) * 3)]), "no interface of the frame is at"),
    (lambda: on_frame(crown=foundation.Frame(1.0, (0, 0, 0), (1, 1, 1)), uprights=FEET), "has no crown="),
    (lambda: on_frame(attached={"bed": foundation.Attachment(foundation.Frame(1, (0, 0, 0), (1, 1, 1)))}), "a name other"),
    (lambda: foundation.mounted(shipped("jf75g_125"), odd_bearing(), FEET), "no bearing on the frame 'P2'"),
    (lambda: steady(on_frame(), points={"p": (9, 9, 9)}), "no node of the frame is at"),
    (lambda: steady(on_frame(), points={"p": "top"}), "no part of the frame 'top'"),
    (lambda: foundation.isolate(shipped("jf75g_125"), frames.of_beams(), FEET, speeds=[1.0], transmitted=0.5), "frame is"),
    (lambda: steady(points={"top": (0, 0)}), "point 'top' is"),
    (lambda: steady(points={"top": ("crown", (0, 0, 0))}), "no part of the frame 'crown'; there are: frame"),
    (lambda: steady(points=[(0, 0, 0)]), "points is a list"),
    (lambda: foundation.steady_response(shaken(), None, points={}), "reactions is a NoneType"),
    (lambda: steady(points=POINTS).rms("tip"), "no point 'tip', did you mean 'top'"),
    (lambda: steady(points={}, flywheel=136.0), "flywheel is a float"),
    (lambda: steady(points={}, flywheel=pp.drives.Flywheel([1.0, 2.0])), "several scenarios"),
    (lambda: foundation.over_speeds(shaken(), [3.0, 2.0], points={}), "speeds is"),
    (lambda: foundation.over_speeds(shaken(), 3.0, points={}), "speeds is 3.0"),
    (lambda: foundation.transmissibility(shaken(), [1.0], axis="up"), "axis is 'up'"),
    (lambda: foundation.transmissibility(shaken(), [1.0], axis={}), "axis is {}"),
    (lambda: foundation.over_speeds(shaken(), [3.0], points=POINTS).growth("top"), "needs two speeds"),
    (lambda: foundation.lifting_response(one_mass(), pushed(1.0), points=CENTRE, strokes=0), "strokes is 0"),
    (lambda: foundation.lifting_response(one_mass(), pushed(1.0, count=2), points=CENTRE, strokes=2), "strokes go with one period"),
    (lambda: foundation.lifting_response(one_mass(), None, points=CENTRE), "reactions is a NoneType"),
    (
        lambda: foundation.lifting_response(
            foundation.mounted(weightless(), CENTRED, [*on_four((1e6, 1e6, KZ)), foundation.Mount((0, 0, 0), (1e5, 1e5, 0))]),
            pushed(1.0),
            points={},
        ),
        "mount 5 has no stiffness along z",
    ),
    (lambda: foundation.logarithmic_decrement(np.random.default_rng(3).normal(size=4000)), "stands out of the noise"),
    (lambda: steady(reactions=of_plain_press(), points={}), "the reactions are of jf75g_125_plain, and jf75g_125 is on the mounts: give"),
    (lambda: steady(reactions=swinging(), points={}), "no period"),
    (lambda: foundation.time_response(shaken(), swinging(), points={}), "equal intervals"),
    (lambda: steady(one_mass(), np.sqrt(4 * KZ / MASS), [harmonic_force(weightless(), 150.0)], points={}), "no damping"),
    (lambda: steady(speed=30.0, loads=[JUMPING], points={}), "do not resolve"),
    (lambda: foundation.time_response(shaken(), slipping(), points={}, flywheel=pp.drives.Flywheel(136.0)), "clutch slips"),
    (on_two_supports, "the mounts leave the frame free in turn about y"),
    (lambda: steady(one_mass(), reactions=nothing_shakes(), points={}).transmitted, "nothing to transmit"),
    (lambda: foundation.over_speeds(one_mass(), [3.0], points={}).transmitted, "nothing to transmit"),
    (lambda: foundation.isolate(weightless(), CENTRED, on_four((1e6,) * 3), speeds=[3.0], transmitted=0.1), "needs no isolation"),
    (lambda: isolate(transmitted=0.2, sag=0.005), "isolation and sag conflict.*5 mm need"),
    (lambda: isolate(transmitted=1e-6), "no stiffness lets these mounts pass on at most 1e-06"),
    (lambda: isolate(transmitted=1.5), r"transmitted is 1\.5"),
    (lambda: isolate(transmitted=0.5, sag=0), "sag is 0"),
    (lambda: foundation.mounted(of_two_motors(), *uneven()), "give motion=servo_cycle"),
    (lambda: foundation.mounted(of_two_motors(), *uneven(), rotors=[ROTOR], motion=motors().motion), "rotors spin with one crank"),
    (lambda: foundation.mounted(five_bar(0.5), *uneven(), motion=motors().motion), "with other joints than"),
    (lambda: steady(on_motors(), reactions=motors(), points=POINTS), "say after which period="),
    (lambda: steady(on_motors(), reactions=motors(), points=POINTS, period=1.0), r"period is 1 s, but the 720 states take"),
    (lambda: shaken_by_motors(pp.drives.Flywheel(1.0)), r"give flywheel=\{'O'"),
    (lambda: shaken_by_motors({"Q": pp.drives.Flywheel(1.0)}), "no driver 'Q'"),
    (lambda: foundation.isolate(of_two_motors(), *uneven(), speeds=[5.0], transmitted=0.5), "over the speeds of one crank"),
    (lambda: foundation.over_speeds(on_motors(), [5.0, 10.0], points=POINTS), "one speed does not say"),
    (rotors_that_change_their_speed, "the rotors change their speed"),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message for _, message in REFUSALS])
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()
