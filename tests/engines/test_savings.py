"""What is left out changes nothing: results with fewer bearings against those with all.

Bounds are 1e-12 of the peaks: the same equations are solved from sums taken in another order, and rounding is conditioned as they are.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.exploring import examples
from support.generators import period_presses
from support.generators.random_linkages import drawn, linkages, loaded, momentum_balance, peaks, random_friction, random_loads, servo
from support.generators.redundant_linkages import LINKAGES, NOT_PLANAR
from support.generators.small_linkages import geared, two_cranks
from support.generators.spatial_crank_slide import SPATIAL
from support.texts import load as read
from support.texts import shipped

import pinpress as pp

ENGINES = ("plane", "space", "pinocchio")
SAME = 1e-12
NAMES = ("crank_slide", "zxn2_3000b", "thin_wall", "jf75g_125", "flat_gears", *(name for name in LINKAGES if name not in NOT_PLANAR))
SERVO = {"angle": np.array([-0.3, 0.1, 0.45]), "speed": np.array([-6.0, 4.0, 9.0]), "acceleration": np.array([30.0, -50.0, 10.0])}
SCENES = ("bare", "loads", "across", "spring", "friction", "stiffness")


@pytest.fixture(scope="module")
def six_bar():
    return shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def turn(six_bar):
    return pp.cycle(six_bar, speed=7.0, points=24)


@cache
def case(name):
    if name == "flat_gears":
        press = geared('<mimic joint="fast" multiplier="-2" offset="0.1"/>', "fast")
    elif name not in LINKAGES:
        press = shipped(name)
    else:
        made = LINKAGES[name]()
        press = made if isinstance(made, pp.Linkage) else read(made)
    return press, pp.servo_cycle(press, **SERVO)


def scene(kind, press):
    """Arguments of `pinpress.inverse_dynamics`."""
    links = [link for link in press.links if link != press.root]
    normal = press.engine("plane").plane.normal
    flat = np.array([100.0, 0.0, -700.0]) - (normal @ [100.0, 0.0, -700.0]) * normal
    return {
        "bare": {},
        "loads": {
            "loads": [pp.loads.PointForce(link, k * flat) for k, link in enumerate((press.root, *links), 1)]
        },  # a flat press stays flat
        "across": {"loads": [pp.loads.PointForce(link, (100.0, -300.0, 900.0), (0.05, 0.1, -0.1)) for link in links[:2]]},
        "spring": {
            "loads": [pp.loads.SpringDamper(press.root, links[-1], stiffness=3e3, damping=50.0, free_length=0.1, point1=(0.3, -2.0, 3.0))]
        },
        "friction": {"friction": random_friction(press, most=0.05)},
        "stiffness": {"stiffness": {name: 1e8 * (1 + 7 * k % 5) for k, name in enumerate(press.bearings)}},
    }[kind]


def subsets(press, alone=True):
    """None, each alone, some."""
    names = press.bearings
    return [(), *((name,) for name in names), names[::2], names[1::2], names[1:]] if alone else [(), names[::2], names[1::2]]


def agree(some, full, bound=SAME):
    """All that both have, within ``bound`` of the peaks of the full one."""
    force, moment = peaks(full._press, full)
    moment = max(moment, np.abs(full.driving_torque).max())
    assert np.abs(some.driving_torque - full.driving_torque).max() <= bound * moment
    assert some.coupling_torque.keys() == full.coupling_torque.keys()
    for name in full.coupling_torque:
        assert np.abs(some.coupling_torque[name] - full.coupling_torque[name]).max() <= bound * moment, name
    for name in some.bearing_force:
        assert np.abs(some.bearing_force[name] - full.bearing_force[name]).max() <= bound * force, name
        assert np.abs(some.bearing_moment[name] - full.bearing_moment[name]).max() <= bound * moment, name
    assert np.abs(some.shaking_force - full.shaking_force).max() <= bound * force
    assert np.abs(some.shaking_moment - full.shaking_moment).max() <= bound * moment
    power = max(lost.max() for lost in full.friction_power.values())
    assert list(some.friction_power) == list(full.friction_power)
    for name in full.friction_power:
        assert np.abs(some.friction_power[name] - full.friction_power[name]).max() <= bound * power
        np.testing.assert_array_equal(some.indeterminate[name], full.indeterminate[name])


@pytest.mark.parametrize("ratio", [0.5, -2.0])
def test_bearings_of_shafts_that_are_geared_alone(ratio):
    """Their gear pair's torque is in the moment about the pin of the shaft that follows; and so it is by Pinocchio."""
    press = period_presses.five_bar(ratio)
    motion = pp.cycle(press, speed=7.0, points=8)
    full = pp.inverse_dynamics(press, motion, engine="pinocchio")
    assert np.abs(full.bearing_moment["P"][:, 1]).max() > 0.1
    for bearings in subsets(press):
        agree(pp.inverse_dynamics(press, motion, bearings=bearings, engine="plane"), full, 1e-10)


# ------------------------------------------------------------------------------------------------------------------------- the same values


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # such extremes are warned of
@pytest.mark.parametrize("kind", SCENES)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.exhaustive
def test_fewer_bearings_have_the_values_of_all(name, kind, engine):
    """In every kind of scene; on linkages that are redundant, geared, in parallel planes. Pinocchio takes ten times as long, and so
    does friction: of these each bearing with others only, alone in `test_linkages_of_the_other_engine` and, at random,
    `test_any_bearings_of_any_linkage`."""
    press, motion = case(name)
    arguments = scene(kind, press)
    full = pp.inverse_dynamics(press, motion, engine=engine, **arguments)
    for names in subsets(press, alone=engine == "plane" and kind != "friction"):
        some = pp.inverse_dynamics(press, motion, engine=engine, bearings=names, **arguments)
        assert tuple(some.bearing_force) == tuple(some.bearing_moment) == names
        assert set(some.left_out) == set(press.bearings) - set(names)
        agree(some, full)


@examples(10)
@given(
    spec=linkages(),
    load_count=st.integers(0, 2),
    in_plane=st.booleans(),
    chosen=st.sets(st.integers(0, 40)),
    engine=st.sampled_from(ENGINES),
)
@pytest.mark.exhaustive
def test_any_bearings_of_any_linkage(tmp_path, spec, load_count, in_plane, chosen, engine):
    """Power and momentum balance too, 1e-10 as with all bearings."""
    drawing = drawn(spec)
    assume(drawing is not None)
    rng = np.random.default_rng(spec.seed + 3)
    press = loaded(drawing, tmp_path, gravity=rng.normal(size=3) * 10)
    motion, loads = pp.servo_cycle(press, **servo(press, rng)), random_loads(press, rng, load_count, in_plane)
    names = {press.bearings[k % len(press.bearings)] for k in chosen}
    full = pp.inverse_dynamics(press, motion, loads, engine=engine)
    some = pp.inverse_dynamics(press, motion, loads, engine=engine, bearings=names)
    assert set(some.bearing_force) == names
    agree(some, full)
    assert np.abs(some.power_residual).max() <= 1e-10
    force, moment = momentum_balance(press, motion, loads)
    force_peak, moment_peak = peaks(press, full)
    assert np.abs(some.shaking_force - force).max() <= 1e-10 * force_peak
    assert np.abs(some.shaking_moment - moment).max() <= 1e-10 * max(moment_peak, np.abs(moment).max())


OTHERS = {
    "through_space": lambda: read(SPATIAL),
    "ring": lambda: read(LINKAGES["ring"]()),
    "several_drivers": two_cranks,
}


@pytest.mark.parametrize("make", OTHERS.values(), ids=OTHERS)
def test_linkages_of_the_other_engine(make):
    press = make()
    if len(press.drivers) > 1:
        states = np.stack([SERVO["angle"], 0.3 * SERVO["angle"]], axis=1)
        motion = pp.servo_cycle(press, angle=states, speed=np.cos(states), acceleration=np.sin(states))
    else:
        motion = pp.cycle(press, speed=5.0, points=12)
    full = pp.inverse_dynamics(press, motion)
    assert full.engine == "space"
    for names in subsets(press):
        agree(pp.inverse_dynamics(press, motion, bearings=names), full)


@pytest.mark.parametrize("points", [2049, 5000])
def test_long_motions(six_bar, points):
    """Those that are worked through in pieces."""
    motion = pp.cycle(six_bar, speed=7.0, points=points)
    full = pp.inverse_dynamics(six_bar, motion)
    for names in ((), ("A", "C"), ("slide_guide",)):
        agree(pp.inverse_dynamics(six_bar, motion, bearings=names), full)
    some = np.arange(0, points, 113)
    alone = pp.servo_cycle(six_bar, angle=motion.crank_angle[some], speed=7.0, acceleration=0.0)
    np.testing.assert_allclose(alone.slide_acceleration, motion.slide_acceleration[some], rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        pp.inverse_dynamics(six_bar, alone).driving_torque, full.driving_torque[some], rtol=0, atol=SAME * np.abs(full.driving_torque).max()
    )


def test_at_rest(six_bar, engine):
    """Where no rate says how the joints move together."""
    motion = pp.servo_cycle(six_bar, angle=np.linspace(0.0, 6.0, 9), speed=0.0, acceleration=0.0)
    full, bare = (pp.inverse_dynamics(six_bar, motion, engine=engine, bearings=names) for names in (None, ()))
    agree(bare, full)
    assert np.abs(bare.driving_torque).max() > 100.0


def test_all_by_name_are_the_same_bytes(six_bar, turn, engine):
    full = pp.inverse_dynamics(six_bar, turn, engine=engine)
    for names in (six_bar.bearings, list(reversed(six_bar.bearings)), set(six_bar.bearings), dict.fromkeys(six_bar.bearings * 2)):
        named = pp.inverse_dynamics(six_bar, turn, engine=engine, bearings=names)
        assert tuple(named.bearing_force) == six_bar.bearings
        assert named.left_out == ()
        agree(named, full, bound=0.0)


# --------------------------------------------------------------------------------------------------------------------- what reads bearings


def test_a_mapping_of_those_alone(six_bar, turn, engine):
    result = pp.inverse_dynamics(six_bar, turn, engine=engine, bearings=["F", "A"])
    for forces in (result.bearing_force, result.bearing_moment):
        assert list(forces) == ["A", "F"]  # in the linkage's order
        assert len(forces) == 2
        assert "A" in forces
        assert "B" not in forces
        assert [array.shape for array in forces.values()] == [(24, 3)] * 2
        for ask in (forces.__getitem__, forces.get):
            with pytest.raises(pp.PinpressError, match=r"bearing 'B' was left out.*bearings=\['A', 'F', 'B'\]") as caught:
                ask("B")
            assert not isinstance(caught.value, KeyError)
        with pytest.raises(pp.UnknownNameError, match="did you mean 'slide_guide'"):
            forces["slide_gide"]
    with pytest.raises(pp.UnknownNameError):
        pp.inverse_dynamics(six_bar, turn, bearings=["A", "G"])
    with pytest.raises(pp.PinpressError, match="list"):
        pp.inverse_dynamics(six_bar, turn, bearings="A")
    assert result.left_out == ("B", "D", "E", "slide_guide", "C")
    assert "largest bearing force" in repr(result)
    assert "left out" in repr(pp.inverse_dynamics(six_bar, turn, bearings=()))


def test_pages_need_all_bearings(six_bar, turn, tmp_path):
    some = pp.inverse_dynamics(six_bar, turn, bearings=["A", "B"])
    for write in (pp.record, pp.report):
        with pytest.raises(pp.PinpressError, match="left out"):
            write(six_bar, turn, tmp_path / "page.html", reactions=some)
        assert not (tmp_path / "page.html").exists()


@pytest.mark.parametrize("bearings", [(), ("A",)], ids=["none", "one"])
@pytest.mark.parametrize(
    "read",
    [
        pp.measures.extremes,
        lambda some: pp.plots.draw(some, "bearings"),
        lambda some: pp.plots.draw(some, "polar"),
        lambda some: pp.plots.draw(some, "torque", "shaking", "peaks", before=some),
    ],
)
def test_charts_need_all_bearings(six_bar, turn, read, bearings):
    """They tell what is rounding by the largest force."""
    with pytest.raises(pp.PinpressError, match="left out"):
        read(pp.inverse_dynamics(six_bar, turn, bearings=bearings))


@pytest.mark.parametrize("bearings", [(), ("C",), None])
def test_what_overflows_is_refused(six_bar, turn, engine, bearings):
    heavy = pp.loads.PointForce("slide", (0.0, 0.0, 1e308))
    with pytest.raises(pp.PinpressError, match="not finite"):
        pp.inverse_dynamics(six_bar, turn, [heavy, heavy], engine=engine, bearings=bearings)


def test_another_linkage_is_refused(six_bar, turn, engine):
    model = six_bar.model.copy()
    model.jointPlacements[2].translation = 1.01 * model.jointPlacements[2].translation
    longer = replace(six_bar, model=model)
    with pytest.raises(pp.AssemblyError):
        pp.inverse_dynamics(longer, turn, engine=engine, bearings=())


def test_a_guide_holds_the_moments_of_links_that_hang_on_its_slide():
    press = pp.build(Path(pp.__file__).parent / "pin_table" / "templates" / "toggle.yaml")
    motion = pp.cycle(press, 7.0, points=20)
    plane, judge = (pp.inverse_dynamics(press, motion, engine=name) for name in ("plane", "pinocchio"))
    for name in press.bearings:
        np.testing.assert_allclose(
            plane.bearing_moment[name], judge.bearing_moment[name], rtol=0, atol=1e-9 * np.abs(judge.driving_torque).max()
        )
