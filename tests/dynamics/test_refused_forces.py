"""What forces refuse of loads, springs, friction and motions, each with its message: a table of (call, message); and what results keep."""

import csv
import math
import sys
from functools import cache

import numpy as np
import pytest
from support import texts
from support.generators.random_linkages import Drawing

import pinpress as pp
from pinpress.loads import Friction, PointForce, SpringDamper

ENGINES = ("plane", "space", "pinocchio")
PRESS, SIX_BAR = texts.shipped("crank_slide"), texts.shipped("zxn2_3000b")
UP = (0.0, 0.0, 1.0)
ROD_END, ROD = '<link1 link="rod" xyz="0.400 0 0" rpy="0 0 0"/>', '<link1 link="rod" xyz="0.390 0 0" rpy="0 0 0"/>'
MEETING = {"link1": "slide", "link2": "frame", "point2": (0.0, 0.0, -0.5)}  # at bottom dead centre, crank angle 0
GUIDE = pp.elasticity.eight_way_guide(facing_x=(0.1, 0.1), facing_y=(0.1, 0.1), length=0.3, width=0.05, stiffness=1e9)


@cache
def motion(press=PRESS, points=12):
    return pp.cycle(press, speed=7.0, points=points)


@cache
def result(press=PRESS):
    return pp.inverse_dynamics(press, motion(press))


def forces(*loads, press=PRESS, **options):
    return pp.inverse_dynamics(press, motion(press), loads=loads, **options)


def rubbing(friction, press=SIX_BAR):
    return pp.inverse_dynamics(press, motion(press), friction=friction)


def spring(**values):
    return SpringDamper("slide", "frame", **values)


def failing(motion):
    raise ZeroDivisionError("mine")


def driven(motion):
    """A press whose energy is not defined: its motion is not a period at constant speed."""
    return pp.measures.driving_energy(pp.inverse_dynamics(PRESS, motion))


def servo():
    time = np.linspace(0.0, 1.0, 101)
    return pp.servo_cycle(PRESS, 2 * np.pi * time - np.sin(2 * np.pi * time), time=time, period=1.0)


@cache
def energy():
    return pp.measures.driving_energy(pp.inverse_dynamics(PRESS, pp.cycle(PRESS, 7.0, points=36)))


@cache
def fixed_loop():
    drawing = Drawing("welded")
    for name, parent, child, place in (
        ("O", "frame", "crank", 0j),
        ("B", "crank", "near", 0.1j),
        ("D", "frame", "rocker", 1.0 + 0j),
        ("C", "rocker", "far", 1.0 + 0.5j),
    ):
        drawing.joint(name, parent, child, place)
        drawing.body(child, 1.0, 0.5 + 0.2j)
    drawing.loop("W", "near", "far", 0.5 + 0.4j)
    return texts.load(drawing.urdf("O").replace("spherical", "fixed"))


REFUSALS = [
    # loads
    (lambda: forces(PointForce("slide", np.zeros((11, 3)))), r"load on 'slide': force has shape \(11, 3\); give \(3,\) or \(12, 3\)"),
    (lambda: forces(PointForce("slide", lambda motion: np.zeros((3, 12)))), r"force has shape \(3, 12\)"),
    (lambda: forces(PointForce("slide", lambda motion: None)), "force is not"),  # type: ignore[return-value]
    (lambda: forces(PointForce("slide", failing)), "load on 'slide': force cannot be worked out: ZeroDivisionError: mine"),
    (lambda: forces(PointForce("slid", UP)), "no link 'slid', did you mean 'slide'.*frame, crank, rod, slide"),
    *(
        (lambda values=values: PointForce("slide", *values), f"^load on 'slide': {message}")
        for values, message in (
            (((0.0, 1.0),), r"force has shape \(2,\); give \(3,\) or \(n, 3\)"),
            ((5.0,), r"force has shape \(\)"),
            (((0.0, math.nan, 0.0),), "force is not finite"),
            (("up",), "force is not a number or an array of numbers"),
            ((UP, (0.0, 0.0)), r"point has shape \(2,\)"),
            ((UP, (0.0, 0.0, math.inf)), "point is not finite"),
            ((UP, "tip"), "point is not a number or an array of numbers"),
        )
    ),
    (lambda: pp.inverse_dynamics(PRESS, motion(), loads=PointForce("slide", UP)), "give a list"),
    *(
        (lambda loads=loads: pp.inverse_dynamics(PRESS, motion(), loads), "load")
        for loads in (spring(), [("slide", "frame")], ["slide"], [None])
    ),
    (lambda: forces(engine="planar"), "unknown engine 'planar'"),
    (lambda: pp.inverse_dynamics(SIX_BAR, motion()), "of crank_slide with other joints than zxn2_3000b"),
    # springs
    *(
        (lambda values=values: spring(**values), f"spring between 'slide' and 'frame': .*{message}")
        for values, message in (
            ({"stiffness": -1.0}, "stiffness is -1.0"),
            ({"damping": -1.0}, "damping is -1.0"),
            ({"free_length": -0.1}, "free_length is -0.1"),
            ({"stiffness": np.nan}, "stiffness is nan"),
            ({"damping": np.inf}, "damping is inf"),
            ({"stiffness": "hard"}, "stiffness is 'hard': give one number that is not negative"),
            ({"stiffness": [1e5, 2e5]}, "give one number"),
            ({"stiffness": None}, "stiffness"),
            ({"point1": (0.0, 0.1)}, r"point1 has shape \(2,\)"),
            ({"point2": (0.0, np.nan, 0.1)}, "point2 is not finite"),
            ({"point2": "slide"}, "point2 is not a number or an array"),
        )
    ),
    *(
        (lambda ends=ends: forces(SpringDamper(*ends, stiffness=1.0)), "no link 'slid', did you mean 'slide'")
        for ends in (("slid", "frame"), ("frame", "slid"))
    ),
    # friction
    *(
        (lambda values=values: Friction(*values), f"^Friction: {message}")
        for values, message in (
            ((-0.1, 0.06), "coefficient is -0.1"),
            ((np.nan, 0.06), "coefficient is nan"),
            ((np.inf, 0.06), "coefficient is inf"),
            (("0.1", 0.06), "coefficient is '0.1'"),
            ((None, 0.06), "coefficient is None"),
            ((np.array([0.1, 0.2]), 0.06), r"coefficient has shape \(2,\)"),
            ((0.1, -0.06), "radius is -0.06"),
            ((0.1, np.nan), "radius is nan"),
            ((0.1, 0.06, -3.0), "viscous is -3.0"),
            ((0.0, None, np.inf), "viscous is inf"),
            ((0.1, None, 0.0, -1e3), "preload is -1000"),
        )
    ),
    *(
        (lambda friction=friction: rubbing(friction), message)
        for friction, message in (
            ({"A": Friction(0.1)}, "'A': its radius is missing"),
            ({"C": Friction(0.1)}, "'C': its radius is missing"),
            ({"slide_guide": Friction(0.1, 0.06)}, "'slide_guide': a guide has no radius"),
            ({"slide_guide": 0.1}, "'slide_guide' is 0.1: give a Friction"),
            ({"A": Friction(0.1, 0.06), "B": None}, "'B' is None"),
            ([Friction(0.1, 0.06)], "mapping"),
            ({"guide": Friction(0.1)}, "no bearing 'guide', did you mean 'slide_guide'"),
        )
    ),
    (
        lambda: pp.inverse_dynamics(
            fixed_loop(), pp.servo_cycle(fixed_loop(), angle=[0.1], speed=1.0), friction={"W": Friction(0.1, 0.05)}
        ),
        "'W': a fixed loop does not turn",
    ),
    # energies
    (lambda: driven(servo()), "not one period of a crank at constant speed"),
    (lambda: energy().speed_drop(0.0), "inertia"),
    (lambda: energy().inertia(-0.1), "speed_drop"),
    # files
    *(
        (lambda thing=thing, to=to, path=path: getattr(thing(), to)(path), "cannot write .*; give a file in a directory")
        for thing in (motion, result)
        for to in ("to_csv", "to_mat")
        for path in ("no such folder/file", ".", "a\0b")
    ),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message[:40] for _, message in REFUSALS])
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()


@pytest.mark.parametrize("values", [{"stiffness": 1e5, "free_length": 0.1}, {"damping": 10.0}, {"stiffness": 1e5, "damping": 10.0}])
def test_ends_that_meet_are_refused(values):
    """Where the force needs a direction there; the crank angle is named."""
    for engine in ENGINES:
        states = pp.servo_cycle(PRESS, angle=[-0.3, 0.0, 0.3], speed=5.0, engine=engine)
        with pytest.raises(pp.PinpressError, match=r"'slide' and 'frame': its ends meet at crank angle -?0 deg"):
            pp.inverse_dynamics(PRESS, states, [SpringDamper(**MEETING, **values)], engine=engine)
        others = pp.servo_cycle(PRESS, angle=[-0.3, 0.3], speed=5.0, engine=engine)
        assert np.isfinite(pp.inverse_dynamics(PRESS, others, [SpringDamper(**MEETING, **values)], engine=engine).driving_torque).all()


@pytest.mark.filterwarnings("ignore:.*r/min:pinpress.PinpressWarning")
def test_forces_out_of_floating_points_range_are_refused(engine):
    """Numbers that overflow are not handed back as inf or nan, and NumPy says nothing."""
    huge, far = (1e308, 1e308, 1e308), (1e5, 1e5, 1e5)
    with pytest.raises(pp.PinpressError, match="not finite"):
        forces(PointForce("slide", huge, far), engine=engine)
    fast = pp.servo_cycle(PRESS, angle=[0.5, 1.0], speed=1e10, engine=engine)
    for values in ({"stiffness": 1e300, "free_length": 0.1}, {"damping": 1e308}):
        with pytest.raises(pp.PinpressError, match="floating point"):
            pp.inverse_dynamics(PRESS, fast, [spring(**values)], engine=engine).power_residual  # noqa: B018
    turn = pp.inverse_dynamics(PRESS, pp.cycle(PRESS, 1e140, points=12), engine=engine)
    with np.errstate(all="ignore"):
        with pytest.raises(pp.PinpressError, match="not finite"):
            _ = forces(PointForce("frame", huge, far), engine=engine).shaking_moment  # all that a load on the frame reaches
        with pytest.raises(pp.PinpressError):
            _ = turn.power_residual


# Motions of a press with other lengths


@pytest.fixture(scope="module")
def shorter():
    """The crank-slide with a rod that is 10 mm shorter."""
    with pytest.warns(pp.PinpressWarning, match="W.*it is 10 mm apart as drawn"):
        return texts.load(PRESS.text.decode().replace(ROD_END, ROD))


def test_forces_of_a_motion_of_other_lengths_are_refused(shorter, engine):
    with pytest.raises(pp.AssemblyError, match="the motion leaves the loops of this linkage open") as refused:
        pp.inverse_dynamics(shorter, motion(), engine=engine)
    assert refused.value.gap == pytest.approx(0.01, rel=1e-6)
    assert np.abs(motion().crank_angle - refused.value.crank_angle % (2 * np.pi)).min() < 1e-9


@pytest.mark.parametrize(
    "take",
    [
        pp.measures.bearing_positions,
        pp.measures.transmission_angle_curves,
        lambda press, motion: pp.derivatives.motion_derivatives(press, motion, [{("W", "rod"): (1.0, 0.0, 0.0)}]),
        lambda press, motion: pp.record(press, motion, "/no/such/folder/never.html"),
        pp.visual_model,
        lambda press, motion: pp.measured.plan(press, {"turning": motion}, noise=1.0),
        lambda press, motion: pp.elasticity.guide_contact(press, result(), GUIDE),
    ],
)
def test_a_motion_of_other_lengths_is_not_read(shorter, take):
    """What is read off a motion alone would be of no press."""
    with pytest.raises(pp.PinpressError, match=r"leaves the loops of crank_slide open by 0\.01 m at crank angle .* of other lengths"):
        take(shorter, motion())
    assert len(pp.measures.bearing_positions(pp.load("crank_slide"), motion())) == 4  # the same press, loaded once more, may take it


# Results


@pytest.mark.parametrize("quantity", ["bearing_force", "bearing_moment", "indeterminate"])
def test_an_unknown_bearing_is_a_key_error_with_the_names_that_there_are(quantity):
    mapping, known = getattr(result(), quantity), ("O", "P", "slide_guide", "W")
    for kind in (pp.PinpressError, KeyError):
        with pytest.raises(kind) as refused:
            mapping["slide_guid"]
        assert (refused.value.name, refused.value.known) == ("slide_guid", known)  # type: ignore[attr-defined]
        assert str(refused.value) == "no bearing 'slide_guid', did you mean 'slide_guide'?; there are: O, P, slide_guide, W"
    assert (mapping.get("slide_guid"), mapping.get("Q", 3), tuple(mapping)) == (None, 3, known)
    assert "Q" not in mapping
    assert None not in mapping


def test_results_cannot_be_written_to(engine):
    states = pp.cycle(PRESS, 7.0, points=3, engine=engine)
    found = pp.inverse_dynamics(PRESS, states, engine=engine)
    arrays = [states.q, states.v, states.a, found.shaking_force, found.shaking_moment, found.power_residual]
    arrays += [*states.columns().values(), *found.columns().values()]
    arrays += [part[name] for name in found.bearing_force for part in (found.bearing_force, found.bearing_moment, found.indeterminate)]
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    with pytest.raises(TypeError):
        found.bearing_force["O"] = np.zeros(3)
    for thing in (PRESS, states, found):
        with pytest.raises(AttributeError):
            thing.motion = None


def test_frames_need_pandas(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    for thing in (motion(), result()):
        with pytest.raises(pp.PinpressError, match=r"pip install 'pinpress\[tables\]'"):
            thing.to_frame()


def renamed(names):
    text = PRESS.text.decode()
    for old, new in names.items():
        escaped = new.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
        text = text.replace(f'joint name="{old}"', f'joint name="{escaped}"')
    return result(texts.load(text))


def test_hostile_names_are_names(tmp_path):
    names = {"O": "<script>alert(1)</script>", "P": 'Kurbel, "Zapfen"  1', "slide_guide": "导轨", "W": "a'b;c"}
    hostile = renamed(names)
    assert set(hostile.bearing_force) == set(names.values())
    hostile.to_csv(tmp_path / "result.csv")
    with open(tmp_path / "result.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == list(hostile.columns())
    for old, new in names.items():
        np.testing.assert_array_equal(hostile.bearing_force[new], result().bearing_force[old])
        column = [float(row[header.index(f"force_{new}_x [N]")]) for row in rows]
        assert column == hostile.bearing_force[new][:, 0].tolist()
    for found in (hostile, *map(renamed, ({"O": "肘", "P": "膝"}, {"O": "A-1", "P": "A 1"}, {"O": "shaft [left]"}))):
        assert_all_columns_in_mat(found, tmp_path / "result.mat")


def assert_all_columns_in_mat(found, file):
    from scipy.io import loadmat

    found.to_mat(file)
    loaded = {name: values for name, values in loadmat(file).items() if not name.startswith("__")}
    assert all(name.isascii() and name.isidentifier() for name in loaded)
    for values, column in zip(loaded.values(), found.columns().values(), strict=True):
        assert values[:, 0].tolist() == column.tolist()


def test_loads_from_a_generator_stay_in_the_power_balance():
    found = pp.inverse_dynamics(PRESS, motion(), loads=(PointForce("slide", (0.0, 0.0, force)) for force in (-1e6,)))
    assert np.abs(found.power_residual).max() < 1e-9
