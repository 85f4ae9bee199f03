"""Derivatives of motion and reactions by pivots: against closed forms, and against differences of changed linkages, to second order."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, given
from support import texts
from support.exploring import examples
from support.generators import spatial_linkages
from support.generators.random_linkages import drawn, linkages

import pinpress as pp
from pinpress.derivatives.motion import STEP, Displacements, directed, motion_derivatives, nowhere, pivot_positions
from pinpress.derivatives.reshape import reshaped
from pinpress.synthesis.design import Design, Start

SPEED = 7.0
MOTION = ("joint_position", "v", "a", "slide_position", "slide_velocity", "slide_acceleration")
REACTIONS = ("driving_torque", "shaking_force", "shaking_moment")
H = 2e-4  # of steps along directions as long as the linkage: the error of a difference is of its square, and rounding does not show yet
ROUNDING = 1e-8  # of a difference, relative: that of values, 1e-13 or so, divided by the step
UNITS = {  # directions in which the redundant presses stay closed: crank pins, rods and guides alike on both sides
    "jf75g_125_symmetric": {
        **{(f"P2_{side}", f"crank_{side}"): (0.3, 0, 0) for side in ("left", "right")},
        **{(f"P4_{side}", f"main_rod_{side}"): (-0.7, 0, 0) for side in ("left", "right")},
        ("O_left", "frame"): (0.5, 0, 0.2),
        ("O_right", "frame"): (-0.5, 0, 0.2),
        ("slide_guide", "frame"): (0, 0, 0.4),
    },
    "eccentric_blocks": {
        **{(f"P2_{side}", f"crank_{side}"): (0.3, 0, 0) for side in ("left", "right")},
        **{(f"P4_{side}", f"main_rod_{side}"): (-0.7, 0, 0) for side in ("left", "right")},
    },
    "pirica_double_knuckle": {
        ("A", "crank"): (0.2, 0, 0),
        **{(f"C_{side}", f"upper_arm_{side}"): (0.4, 0, 0) for side in ("left", "right")},
        **{(f"N_{side}", f"rocker_{side}"): (0.3, 0, 0) for side in ("left", "right")},
        **{(f"D_{side}", f"toggle_{side}"): (-0.5, 0, 0) for side in ("left", "right")},
    },
    "jf75g_125_two_point": {
        **{(f"P2_{end}", "crank"): (0.3, 0, 0.1) for end in ("back", "front")},
        **{(f"P4_{end}", f"main_rod_{end}"): (-0.7, 0, 0.2) for end in ("back", "front")},
        ("O", "frame"): (0.3, 0, 0.1),
    },
}


def direction(press, rng):
    """All pivots at once in the plane, as far as the linkage is long."""
    if press.name in UNITS:
        return UNITS[press.name]
    moved = {}
    for (bearing, link), position in pivot_positions(press).items():
        frame = press.model.frames[press.model.getFrameId(link, pin.BODY)]
        plane = press.engine("plane").plane
        body = plane.frames[frame.parentJoint - 1] if frame.parentJoint else np.array([*plane.axes, plane.normal])
        normal = frame.placement.rotation.T @ body[2]
        vector = press.size * rng.normal(size=len(position))
        moved[bearing, link] = vector - (vector @ normal) * normal
    return moved


def moved(press, along, step):
    positions = pivot_positions(press)
    return reshaped(press, {pivot: positions[pivot] + step * np.asarray(vector) for pivot, vector in along.items()})


def check(exact, differences, name):
    """Central differences with steps H and H / 2 come to the derivative, the second four times as near."""
    size = np.abs(exact).max()
    first, second = (np.abs(difference - exact).max() / size for difference in differences)
    assert first <= 1e-2, name  # the same quantity at all
    assert second <= 0.3 * first + ROUNDING, name


def check_motion(press, states, along):
    motion = pp.servo_cycle(press, **states)
    (derivative,) = motion_derivatives(press, motion, [along])
    pairs = [[pp.servo_cycle(moved(press, along, sign * h), **states) for sign in (1, -1)] for h in (H, H / 2)]
    for name in MOTION[: 6 if press.slide else 3]:
        values = [[getattr(changed, name) for changed in pair] for pair in pairs]
        differences = [(ahead - back) / (2 * h) for (ahead, back), h in zip(values, (H, H / 2), strict=True)]
        if np.abs(getattr(derivative, name)).max() > 0:
            check(getattr(derivative, name), differences, name)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["jf75g_125_symmetric", "thin_wall", "zxn2_3000b"])
def test_motion_derivatives_are_those_of_changed_presses(name):
    press = texts.shipped(name)
    angle = np.linspace(0.1, 6.2, 12)
    states = {"angle": angle, "speed": 3 + np.sin(angle), "acceleration": 5 * np.cos(angle)}
    check_motion(press, states, direction(press, np.random.default_rng(3)))


@pytest.mark.exhaustive
@examples(8)
@given(spec=linkages(most=3))
def test_motion_and_reaction_derivatives_of_random_linkages(spec):
    drawing = drawn(spec)
    assume(drawing is not None)
    press = texts.load(drawing.urdf("crank"))
    low, high = (-1.0, 1.0) if press.branch.period else press.branch.angles[[0, -1]]
    states = {"angle": np.array([0.0, 0.01, 0.02]) * min(1.0, 10 * high, -10 * low), "speed": SPEED}
    along = {pivot: 0.1 * vector for pivot, vector in direction(press, np.random.default_rng(spec.seed)).items()}
    check_trials(press, pp.servo_cycle(press, **states), along)


# ------------------------------------------------------------------------------------------------------------------------------ reactions


def start(press, motion, along, loads=()):
    """The design of a press as it is."""
    closure = press.engine().close(motion.crank_angle, motion.joint_position.T)
    states = closure.position, closure.first, closure.second, closure.gap
    plane = press.engine("plane").plane
    return Design(Start(press, plane, motion, loads), {"s": 0.0}, nowhere(press), (directed(press, along),), plane, *states)


def seen(press, trial):
    """Names and arrays of all that a trial shows."""
    reactions = trial.reactions
    result = {name: getattr(trial.motion, name) for name in MOTION[: 6 if press.slide else 3]}
    result |= {name: getattr(reactions, name) for name in REACTIONS[: 3 if press.engine("plane").bodies.in_one_plane else 2]}
    result |= {f"position of {name}": trial.positions[name] for name in press.bearings}
    engine = press.engine("plane")
    if not engine.plane.redundant:
        result |= {f"force in {name}": reactions.bearing_force[name] for name in press.bearings}
    if not engine.plane.redundant and engine.bodies.in_one_plane:
        result |= {f"moment in {name}": reactions.bearing_moment[name] for name in press.bearings}
    return result


def check_trials(press, motion, along, loads=()):
    design = start(press, motion, along, loads)
    exact = {name: values.imag / STEP for name, values in seen(press, design.trial_towards(0, 1.0)).items()}
    slope = design.slopes[0]
    pairs = []
    for h in (H, H / 2):
        pairs.append(
            [
                seen(press, design.next({"s": 0.0}, Displacements(s * h * slope.joints, s * h * slope.ends), [slope]).trial())
                for s in (1, -1)
            ]
        )
    for name, derivative in exact.items():
        if np.abs(derivative).max() > 1e-9 * np.abs(seen(press, design.trial())[name]).max():
            differences = [(ahead[name] - back[name]) / (2 * h) for (ahead, back), h in zip(pairs, (H, H / 2), strict=True)]
            check(derivative, differences, name)


@pytest.mark.parametrize("name", pp.presses())
def test_reaction_derivatives_are_those_of_changed_presses(name):
    """With a constant force on a link."""
    press = texts.shipped(name)
    load = pp.loads.PointForce(press.links[1], (2e3, 0.0, -5e3), (0.1, 0.0, 0.05))
    check_trials(press, pp.cycle(press, SPEED, points=24), direction(press, np.random.default_rng(4)), [load])


@pytest.mark.parametrize("turned_round", [False, True])
def test_a_process_load_follows_the_slide(turned_round):
    """A die 0.15 m above bottom dead centre, met and left between two of the states whatever the step; the guide's axis up, and down."""
    press = texts.load(texts.guide_turned_round("zxn2_3000b")) if turned_round else texts.shipped("zxn2_3000b")
    load = pp.loads.ElasticDie(height=0.15, stiffness=2e6, damping=1e4, datum=pp.dead_centres(press).bottom_position)
    check_trials(press, pp.cycle(press, SPEED, points=24), direction(press, np.random.default_rng(5)), [load])


@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125_symmetric", "thin_wall"])
def test_a_trial_shows_the_motion_and_reactions_of_its_press(name):
    press = texts.shipped(name)
    motion = pp.cycle(press, SPEED, points=24)
    load = pp.loads.PointForce(press.links[1], (2e3, 0.0, -5e3), (0.1, 0.0, 0.05))
    design = start(press, motion, direction(press, np.random.default_rng(6)), [load])
    slope = design.slopes[0]
    trial = design.next({"s": 0.01}, Displacements(0.01 * slope.joints, 0.01 * slope.ends), [slope]).trial()
    expected = pp.cycle(trial.press, SPEED, points=24)
    result = pp.inverse_dynamics(trial.press, expected, [load])
    for attribute in MOTION:
        values = getattr(expected, attribute)
        assert np.abs(getattr(trial.motion, attribute) - values).max() <= 1e-11 * np.abs(values).max(), attribute
    for attribute in REACTIONS:
        values = getattr(result, attribute)
        assert np.abs(getattr(trial.reactions, attribute) - values).max() <= 1e-10 * np.abs(values).max(), attribute
    for bearing, force in result.bearing_force.items():
        assert np.abs(trial.reactions.bearing_force[bearing] - force).max() <= 1e-9 * np.abs(force).max(), bearing


# ----------------------------------------------------------------------------------------------------------------------------- closed forms


def test_a_crank_slide_has_the_derivatives_of_its_formula():
    """Complex step through s = -(r cos q + sqrt(l^2 - r^2 sin^2 q)) and its derivatives by q, written out."""
    press = texts.shipped("crank_slide")
    angle = np.linspace(0.0, 6.2, 40)
    speed, acceleration = 3 + np.sin(angle), 5 * np.cos(angle)

    def slide(r, length):
        c, s = np.cos(angle), np.sin(angle)
        root = np.sqrt(length**2 - r**2 * s**2)
        first = r * s + r**2 * s * c / root
        second = r * c + r**2 * (c**2 - s**2) / root + r**4 * s**2 * c**2 / root**3
        return -(r * c + root), first * speed, second * speed**2 + first * acceleration

    motion = pp.servo_cycle(press, angle=angle, speed=speed, acceleration=acceleration)
    derivatives = motion_derivatives(press, motion, [{("P", "crank"): (1, 0, 0)}, {("W", "rod"): (1, 0, 0)}])
    for derivative, lengths in zip(derivatives, ((0.1 + 1j * STEP, 0.4), (0.1, 0.4 + 1j * STEP)), strict=True):
        for name, values in zip(MOTION[3:], slide(*lengths), strict=True):
            exact = values.imag / STEP
            assert np.abs(getattr(derivative, name) - exact).max() <= 1e-12 * np.abs(exact).max(), name


@pytest.mark.parametrize("name", pp.presses())
def test_a_press_made_larger_moves_to_scale(name):
    """Along its own positions all travels grow in proportion, and no angle changes."""
    press = texts.shipped(name)
    motion = pp.cycle(press, SPEED, points=24)
    positions = pivot_positions(press)
    flat = {pivot: position - (position @ [0, 1, 0]) * np.array([0, 1, 0]) for pivot, position in positions.items()}
    (derivative,) = motion_derivatives(press, motion, [flat])
    for joint, axis in enumerate(press.axes):
        for attribute in MOTION[:3]:
            exact = 0.0 if axis.turns else getattr(motion, attribute)[:, joint]
            size = np.abs(getattr(motion, attribute)).max()
            assert np.abs(getattr(derivative, attribute)[:, joint] - exact).max() <= 1e-12 * size, attribute
    assert np.abs(derivative.slide_position - motion.slide_position).max() <= 1e-12 * np.abs(motion.slide_position).max()


# ---------------------------------------------------------------------------------------------------------------------------- what is wrong


REFUSALS = [  # press, whose motion, a direction and the message
    ("bennett", "bennett", {}, "exact derivatives are those of planar linkages .*, which bennett is not"),
    ("jf75g_125_two_point", "jf75g_125_two_point", {("P4_front", "main_rod_front"): (1, 0, 0)}, "do not stay closed"),
    ("crank_slide", "crank_slide", {("P", "crank"): (0, 1, 0)}, "out of the plane"),
    ("thin_wall", "crank_slide", {("D", "bar"): (1, 0, 0)}, "other joints"),
]


@pytest.mark.parametrize(("name", "of", "direction", "message"), REFUSALS)
def test_directions_and_motions_that_do_not_fit_are_refused(name, of, direction, message):
    press, moving = (texts.load(spatial_linkages.bennett()) if each == "bennett" else texts.shipped(each) for each in (name, of))
    with pytest.raises(pp.PinpressError, match=message):
        motion_derivatives(press, pp.cycle(moving, SPEED, points=12), [direction])
