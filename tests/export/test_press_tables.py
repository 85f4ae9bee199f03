"""A press as a table: against the engine at random states, identities of its functions, presses that have none, and mistakes."""

import pickle

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from support import texts
from support.exploring import examples
from support.generators import period_presses, random_linkages, redundant_linkages, spatial_crank_slide, spatial_linkages
from support.presses import two_servos
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.pin_table.templates import TEMPLATES, template

STATES = 60
RUBBING = {"hypocycloid", "screw"}  # templates whose teeth or threads are refused


def press_named(name):
    return texts.shipped(name) if name in pp.presses() else pp.build(texts.file(template(name).decode(), "press.yaml"))


def states_of(table, rng, turns=3):
    """Random positions, speeds and accelerations, several turns away where the driver turns."""
    low, high = table.functions.borders[[0, -1]]
    away = rng.integers(-turns, turns + 1, STATES) * (table.functions.period or 0.0)
    fastest = 12.0 if table.coordinate.turns else 2.0
    return rng.uniform(low, high, STATES) + away, fastest * rng.uniform(-1, 1, STATES), 5 * fastest * rng.uniform(-1, 1, STATES)


def reference(press, states, *given):
    angle, speed, acceleration = states
    motion = pp.servo_cycle(press, angle, speed=speed, acceleration=acceleration)
    return motion, pp.inverse_dynamics(press, motion, *given)


def pushed(press, force):
    """The process force as an outer one on the slide (n, 3); that on the bolster moves no link."""
    return pp.loads.PointForce(press.slide, np.multiply.outer(force, press.slide_direction), tuple(press.tool.point))


def check(press, table, seed=0, share=1e-11, force=1e6):
    """Every quantity against the engine: forces by the largest force, moments by that on an arm as long as the linkage."""
    rng = np.random.default_rng(seed)
    states = states_of(table, rng)
    pushes = rng.uniform(-force, force, STATES) if "force" in table.inputs else np.zeros(STATES)
    motion, wanted = reference(press, states, [pushed(press, pushes)] if "force" in table.inputs else [])
    found = table.at(*states, **({"force": pushes} if "force" in table.inputs else {}))
    forces = [(found.bearing_force[name], wanted.bearing_force[name]) for name in table.bearings]
    largest = max(np.abs(each).max() for _, each in forces)
    moments = [(found.bearing_moment[name], wanted.bearing_moment[name]) for name in table.bearings]
    moments += [(found.driving_torque, wanted.driving_torque)]
    arm = largest * (press.size if press.driver_coordinates[0].turns else 1.0)
    for ours, theirs in forces:
        assert np.abs(ours - theirs).max() < share * largest
    for ours, theirs in moments:
        assert np.abs(ours - theirs).max() < share * max(arm, np.abs(theirs).max())
    still = table.at(*states)
    free = reference(press, states)[1]
    assert np.abs(still.shaking_force - free.shaking_force).max() < share * max(np.abs(free.shaking_force).max(), 1e-3 * largest)
    if press.slide is not None:
        for name in ("slide_position", "slide_velocity", "slide_acceleration"):
            theirs = getattr(motion, name)
            assert getattr(found, name) == pytest.approx(theirs, rel=1e-10, abs=share * np.abs(theirs).max()), name
    return table


WITHOUT_LOSS = sorted({*pp.presses(), *TEMPLATES} - RUBBING)


@pytest.mark.parametrize("name", rest_exhaustive(WITHOUT_LOSS, "zxn2_3000b", "jf75g_125_symmetric", "rssp", "toggle"))
def test_a_table_is_the_engine(name):
    press = press_named(name)
    table = check(press, pp.export.tabulate(press))
    assert 0 < max(table.error.values()) < 1e-11
    # one state alone and many at once
    angle, speed, acceleration = (each[:1] for each in states_of(table, np.random.default_rng(5)))
    one = table.at(float(angle[0]), float(speed[0]), float(acceleration[0]), force=2e5)
    assert one.values == pytest.approx(table.at(angle, speed, acceleration, force=2e5).values[:, 0], rel=1e-12, abs=1e-9)
    assert isinstance(one.driving_torque, float)
    whole, single, several = table.at(0, 2), table.at(np.float32(0), 2.0), table.at([0.0, 0.1], 2)
    assert whole.driving_torque == single.driving_torque == table.at(0.0, 2.0).driving_torque
    assert several.driving_torque[0] == pytest.approx(whole.driving_torque, rel=1e-12)
    assert one.bearing_force[table.bearings[0]].shape == (3,)


@examples(20)
@given(random_linkages.linkages(most=3), st.integers(0, 99))
def test_random_linkages(tmp_path_factory, spec, seed):
    drawing = random_linkages.drawn(spec)
    assume(drawing is not None)
    press = random_linkages.loaded(drawing, tmp_path_factory.mktemp("random"))
    assume(not press.branch_through_change_points.change_points)
    check(press, pp.export.tabulate(press, tolerance=1e-11), seed, share=1e-8)


SEVERAL = {
    "in space": lambda: texts.load(spatial_crank_slide.SPATIAL),
    "with a ball joint": lambda: texts.load(spatial_linkages.four_bar("spherical")),
    "of two turns": lambda: period_presses.five_bar(1.5),
    "of redundant rods": lambda: texts.load(redundant_linkages.rods(3, "revolute")),
}


@pytest.mark.parametrize("name", SEVERAL)
def test_linkages_in_space_of_several_turns_and_redundant_ones(name):
    press = SEVERAL[name]()
    check(press, pp.export.tabulate(press), share=1e-10)


@pytest.mark.parametrize("name", ["zxn2_3000b", "rssp", "toggle", "pirica_double_knuckle"])
def test_identities_of_the_functions(name):
    """Of the torque the term of the squared speed is half the slope of the inertia, that of a force on the slide minus its slope."""
    table = pp.export.tabulate(press_named(name), tolerance=1e-12)
    half = 0.5 * np.diff(table.functions.borders)[:, None]
    _, inertia, square, damping, reach = np.moveaxis(table.term_of("driving_torque"), 1, 0)
    position = table.term_of("slide_position")[:, 0]
    powers, places = np.arange(1, inertia.shape[1]), np.linspace(-1, 1, 33)

    def values(polynomials):
        return polynomials @ np.vander(places, polynomials.shape[1], increasing=True).T

    slope = values(inertia[:, 1:] * powers) / half
    assert values(square) == pytest.approx(0.5 * slope, abs=3e-9 * np.abs(slope).max())
    slope = values(position[:, 1:] * powers) / half
    assert values(reach) == pytest.approx(-slope, abs=1e-9 * np.abs(slope).max())
    assert not damping.any()


def test_the_equation_of_motion_gives_the_run_of_simulate():
    """A second of the six-bar under a constant torque, by SciPy on the table and by `simulate`."""
    press, torque = texts.shipped("zxn2_3000b"), 2000.0
    table = pp.export.tabulate(press, bearings=())

    def slopes(_, state):
        return [state[1], table.acceleration(float(state[0]), float(state[1]), torque, added_inertia=500.0)]

    found = solve_ivp(slopes, (0.0, 1.0), [0.3, 2.0], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    drive, wheel = pp.drives.ConstantTorque(torque), pp.drives.Flywheel(500.0)
    run = pp.simulate(press, 1.0, angle=0.3, speed=2.0, drive=drive, flywheel=wheel, tolerance=1e-11)
    assert found == pytest.approx([run.crank_angle[-1], run.crank_speed[-1]], abs=1e-9)
    angle, speed = found.tolist()
    alike = table.at(angle, speed, table.acceleration(angle, speed, torque))
    assert alike.driving_torque == pytest.approx(torque, rel=1e-9)


def test_springs_dampers_viscous_friction_and_several_inputs():
    press = texts.shipped("crank_slide")
    oil = {"P": pp.loads.Friction(viscous=80.0), "slide_guide": pp.loads.Friction(viscous=2e3)}
    spring, damper = pp.loads.SpringDamper("frame", "slide", 1e5, damping=3e3), pp.loads.PointForce("rod", (300.0, 0.0, -200.0))
    off = pp.loads.PointForce("slide", (0.0, 0.0, 1.0), (0.1, 0.0, 0.0))
    table = pp.export.tabulate(
        press, loads=[spring, damper], inputs={"left": off, "twist": pp.loads.PointMoment("rod", (0.0, 1.0, 0.0))}, friction=oil
    )
    rng = np.random.default_rng(2)
    states, (left, twist) = states_of(table, rng), rng.uniform(-1e5, 1e5, (2, STATES))
    acting = [
        spring,
        damper,
        pp.loads.PointForce("slide", np.multiply.outer(left, [0.0, 0.0, 1.0]), (0.1, 0.0, 0.0)),
        pp.loads.PointMoment("rod", np.multiply.outer(twist, [0.0, 1.0, 0.0])),
    ]
    _, wanted = reference(press, states, acting, oil)
    found = table.at(*states, left=left, twist=twist)
    assert found.driving_torque == pytest.approx(wanted.driving_torque, rel=1e-10, abs=1e-10 * np.abs(wanted.driving_torque).max())
    for name in table.bearings:
        theirs = wanted.bearing_force[name]
        assert np.abs(found.bearing_force[name] - theirs).max() <= 1e-10 * np.abs(theirs).max()


def test_redundant_bearings_share_by_their_stiffness():
    press, rng = texts.shipped("jf75g_125_symmetric"), np.random.default_rng(6)
    soft = dict.fromkeys(press.bearings[::2], 1e8)
    table = pp.export.tabulate(press, stiffness=soft)
    states = states_of(table, rng)
    _, wanted = reference(press, states, (), {}, soft)
    found = table.at(*states)
    for name, theirs in wanted.bearing_force.items():
        assert np.abs(found.bearing_force[name] - theirs).max() < 1e-11 * np.abs(wanted.bearing_force["P5_right"]).max()
    assert "stiffness" in dict(table.origin)


def test_a_rocking_crank_and_a_copy():
    """A four-bar whose crank rocks has a range; a copy by pickle gives the same numbers."""
    press = pp.load(texts.file(random_linkages.four_bar(0.30, 0.20, 0.15, 0.12, 1.0, bounded=False).urdf("O")))
    table = pp.export.tabulate(press)
    low, high = table.functions.borders[[0, -1]]
    with pytest.raises(pp.PinpressError, match=r"four_bar is not tabulated at .* deg: its driver goes from .*; stay within that"):
        table.at(float(high) + 0.01, 1.0)
    again = pickle.loads(pickle.dumps(table))
    middle = 0.5 * float(low + high)
    assert np.array_equal(again.at(middle, 3.0, 2.0).values, table.at(middle, 3.0, 2.0).values)


CHANGING = random_linkages.four_bar(0.30, 0.12, 0.30, 0.12, 1.0, bounded=False).urdf("O")
TABLE = pp.export.tabulate(texts.shipped("crank_slide"), bearings=())


def tabulated(name="crank_slide", **options):
    return pp.export.tabulate(press_named(name), **options)


REFUSED = [
    (lambda: tabulated("hypocycloid"), "has teeth or threads that rub or push apart in 'ring'.*leave out"),
    (
        lambda: pp.export.tabulate(texts.load(spatial_linkages.bennett())),
        "moment_J. of bennett differs by .* from the engine at crank angle .* deg: it jumps there, has no bounds",
    ),
    (lambda: tabulated("screw"), "rub or push apart in 'thread'"),
    (
        lambda: tabulated(friction={"P": pp.loads.Friction(0.1, 0.05), "O": pp.loads.Friction(viscous=2.0)}),
        "crank_slide has dry friction in P, which depends on the size of forces.*leave out its coefficient",
    ),
    (lambda: TABLE.acceleration(0.1, np.nan, 0.0), "crank_slide has no acceleration at .*give finite speed, torque and force"),
    (lambda: tabulated(loads=[pp.loads.Blanking(1e5, 0.006, 0.002)]), "Blanking is no function of the driver's position.*as an input"),
    (lambda: tabulated(inputs={"1st": None}), "input '1st' is no name"),
    (lambda: tabulated(inputs={"a": pp.loads.Blanking(1e5, 0.006, 0.002)}), "give a PointForce of 1 N"),
    (lambda: tabulated(bearings=["X"]), "X"),
    (lambda: tabulated(tolerance=1e-20), "tolerance .*a number from 1e-13 to 1e-3"),
    (lambda: pp.export.tabulate(pp.load(texts.file(CHANGING))), "has a change point at .*where forces have no bounds"),
    (lambda: TABLE.at(0.1, np.inf), "the state of crank_slide is not finite"),
    (lambda: TABLE.at(0.1, 1.0, power=3.0), "power"),
    (lambda: TABLE.at(np.zeros(3), np.zeros(2)), r"shapes \(3,\), \(2,\)"),
    (lambda: TABLE.at(0.1, 1.0).shaking_force, "the table of crank_slide has no shaking_force: tabulate it with bearings"),
    (lambda: TABLE.acceleration("0.1", 1.0, 2.0), "the state of crank_slide is no single one: give numbers"),
    (lambda: TABLE.acceleration(np.zeros(3), 1.0, 2.0), "no single one: give numbers; `at` takes arrays"),
    (lambda: TABLE.acceleration(0.1, 1.0, np.nan), "has no acceleration at"),
]


@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_what_has_no_table_is_refused(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()


def test_several_drivers_are_refused():
    press = pp.build(texts.file(two_servos.TWO_SERVOS, "press.yaml"))
    with pytest.raises(pp.PinpressError, match="a table has one driver"):
        pp.export.tabulate(press)
