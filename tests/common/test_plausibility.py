"""What is legal but hardly meant is warned of, once and where it is called; nothing sensible is."""

import re
import subprocess
import sys
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.exploring import examples
from support.generators import frames
from support.generators.random_linkages import four_bar
from support.texts import load as load_text
from support.texts import shipped

import pinpress as pp
from pinpress import drives, elasticity, foundation, loads, ratings, servo, tolerances
from pinpress.balancing import classical
from pinpress.cli.main import main
from pinpress.common import plausibility

URDF = Path(__file__).resolve().parents[2] / "urdf"
CRANK_SLIDE = (URDF / "crank_slide.urdf").read_text(encoding="utf-8")
TURN = 2 * np.pi


def load(folder, *edits, text=CRANK_SLIDE, **options):
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    file = folder / "press.urdf"
    file.write_text(text, encoding="utf-8")
    return pp.load(file, **options)


@pytest.fixture(scope="module")
def press():
    return pp.load("crank_slide")


def scaled(text, length=1.0, mass=1.0, inertia=1.0, centre=1.0):
    """The numbers of a URDF in other units."""

    def times(factor):
        return lambda match: match[1] + " ".join(repr(float(x) * factor) for x in match[2].split()) + '"'

    text = re.sub(r'(<(?:origin|link[12] link="\w+") xyz=")([^"]*)"', times(length), text)
    text = re.sub(r'(<inertial>\s*<origin xyz=")([^"]*)"', times(centre), text)
    text = re.sub(r'(<mass value=")([^"]*)"', times(mass), text)
    return re.sub(r'(\bi[xyz]{2}=")([^"]*)"', times(inertia), text)


# Linkages


@pytest.mark.parametrize("name", pp.presses())
def test_shipped_presses_are_sensible(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pp.load(name)
    assert pp.check(name).warnings == ()


@pytest.mark.one_in(7)
@pytest.mark.parametrize("name", ["crank_slide", "zxn2_3000b", "jf75g_125"])
@pytest.mark.parametrize(
    ("units", "said"),
    [
        pytest.param({"length": 1e3, "inertia": 1e6}, r"the linkage is \d+(\.\d)? m long; write lengths in metres", id="mm, kg mm2"),
        pytest.param({"length": 1e3}, r"the linkage is \d+(\.\d)? m long; write lengths in metres", id="mm"),
        pytest.param({"inertia": 1e6}, "the radius of gyration is .* m, of a linkage of", id="kg mm2"),
        pytest.param({"mass": 1e3, "inertia": 1e9}, "the radius of gyration is .* m, of a linkage of", id="g, g mm2"),
        pytest.param({"inertia": 1e4}, "the radius of gyration is .* m, of a linkage of", id="kg cm2"),
        pytest.param({"mass": 1e3, "inertia": 1e3}, r"weigh .* write masses in kg|its density is at least", id="g, g m2"),
        pytest.param({"mass": 1e3}, r"weigh .* write masses in kg|its density is at least .*; write moments of inertia in kg m2", id="g"),
        pytest.param({"inertia": 1e-3}, r"its density is at least .*; write moments of inertia in kg m2, and the mass in kg", id="t m2"),
        pytest.param({"centre": 1e3}, "the centre of mass is .* m from the nearest pin .*; write it in metres", id="centres in mm"),
    ],
)
def test_other_units_in_a_urdf_are_warned_of(tmp_path, name, units, said):
    text = scaled((URDF / f"{name}.urdf").read_text(encoding="utf-8"), **units)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        press = load(tmp_path, text=text)
    assert any(re.search(said, str(warning.message)) for warning in caught)
    assert len({str(warning.message) for warning in caught}) == len(caught)
    assert any(re.search(said, f"{found.problem}; {found.remedy}") for found in pp.check(press.file).warnings)


def test_one_link_with_moments_of_inertia_a_thousand_times_too_large_is_warned_of(tmp_path):
    """Of a rod between two pins; one of the same size on the frame might be a flywheel."""
    text = (URDF / "zxn2_3000b.urdf").read_text(encoding="utf-8")
    start = text.index('<link name="coupler">')
    end = text.index("</inertial>", start)
    with pytest.warns(
        pp.PinpressWarning, match="<inertia> of <link name=.coupler.>: the radius of gyration is 11.3 m, of a linkage of 1.8"
    ):
        load(tmp_path, text=text[:start] + scaled(text[start:end], inertia=1e3) + text[end:])


@pytest.mark.parametrize("place", ['<link2 link="slide" xyz="0 0 0"', '<origin xyz="0.030 0 0"', '<origin xyz="0.200 0 0"'])
def test_angles_in_degrees_are_warned_of(tmp_path, place):
    """At a loop and at centres of mass, where the linkage moves as before."""
    text = re.sub(re.escape(place) + r'( rpy="[^"]*")?', f'{place} rpy="0 90 0"', CRANK_SLIDE, count=1)
    assert text != CRANK_SLIDE
    said = r"rpy='0 90 0' turns by more than a full turn: it seems to be in degrees; write radians, 1.5707963267948966 for 90 degrees"
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        press = load(tmp_path, text=text)
    assert [re.search(said, str(warning.message)) is not None for warning in caught].count(True) == 1
    assert any(re.search(said, f"{found.problem}; {found.remedy}") for found in pp.check(press.file).warnings)


def test_angles_in_degrees_are_why_a_loop_is_open(tmp_path):
    edit = ('<origin xyz="0.100 0 0"', '<origin xyz="0.100 0 0" rpy="0 5 90"')
    with pytest.raises(pp.UrdfError, match=r'name="W">: it is .* apart as drawn.*rpy=.0 5 90. turns by more than a full turn.*in degrees'):
        load(tmp_path, edit)
    found = pp.check(tmp_path / "press.urdf")
    assert [each.element for each in found.warnings] == ['<origin> of <joint name="P">']


def test_a_long_stroke_is_warned_of_by_check(tmp_path):
    """In a linkage that is small enough for metres."""
    text = scaled(CRANK_SLIDE, length=40.0, mass=40.0, inertia=4e4)
    press = load(tmp_path, text=text)
    (found,) = (found for found in pp.check(press.file).warnings if "limit" not in found.problem)
    assert found.problem == "slide 'slide' goes 8 m to and fro"
    assert found.element == '<joint name="slide_guide">'


@pytest.mark.parametrize("rod", ["0.370", "0.393"])
def test_a_loop_that_is_drawn_open_is_warned_of(tmp_path, rod):
    edit = ('<link1 link="rod" xyz="0.400 0 0"', f'<link1 link="rod" xyz="{rod} 0 0"')
    said = f"it is {1e3 * (0.4 - float(rod)):.3g} mm apart as drawn; draw it closed.*moved joint .slide_guide"
    with pytest.warns(pp.PinpressWarning, match=f'loop_joint name="W">: {said}'):
        load(tmp_path, edit)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(tmp_path, (edit[0], edit[1].replace(rod, "0.397")))


@pytest.mark.exhaustive
def test_a_loop_that_is_drawn_far_open_is_closed_with_a_warning(tmp_path, capsys):
    edit = ('<link1 link="rod" xyz="0.400 0 0"', '<link1 link="rod" xyz="0.340 0 0"')
    with pytest.warns(pp.PinpressWarning, match="it is 60 mm apart as drawn; draw it closed.*moved joint 'slide_guide' by 0.06 m"):
        press = load(tmp_path, edit)
    assert press.assembly.how == "the drawn pose with the drivers held"
    assert press.assembly.moved == pytest.approx({"slide_guide": 0.06})
    assert press.assembly.gap_drawn == pytest.approx(0.06)
    assert pp.dead_centres(press).stroke == pytest.approx(0.2)
    assert not pp.check(press.file).errors
    with pytest.warns(pp.PinpressWarning, match="it is 60 mm apart as drawn"):
        assert main(["analyse", press.file, "--speed", "60r/min"]) == 0
    assert main(["check", press.file, "--set", "pose={slide_guide: 60 mm}"]) == 0
    with pytest.raises(pp.UnknownNameError, match="slide_gide"):
        load(tmp_path, edit, pose={"slide_gide": 0.06})


@pytest.mark.exhaustive
def test_a_command_says_warnings_in_one_plain_line_each(tmp_path):
    file = tmp_path / "press.urdf"
    file.write_text(CRANK_SLIDE.replace('<link1 link="rod" xyz="0.400 0 0"', '<link1 link="rod" xyz="0.390 0 0"'), encoding="utf-8")
    command = [sys.executable, "-m", "pinpress", "analyse", str(file), "--speed", "60r/min", "--out", str(tmp_path)]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    assert re.fullmatch(rf"warning: {re.escape(str(file))}:\d+: <loop_joint name=\"W\">: it is 10 mm apart as drawn; [^\n]*\n", said)


@examples(10)
@given(
    stroke=st.floats(0.002, 0.6),
    ratio=st.floats(3.0, 20.0),
    hard=st.floats(1e-4, 35.0),
    slide=st.floats(1.0, 2e4),
    slender=st.floats(1.0, 30.0),
)
def test_sensible_presses_are_never_warned_of(tmp_path, stroke, ratio, hard, slide, slender):
    """Crank-slides from small and fast to large and slow, their links bars of steel, the slide a cube that its rod reaches out of, that
    weighs a twentieth of it or more, and that is accelerated by so many g."""
    speed = np.sqrt(hard * 9.81 / (0.5 * stroke * (1 + 1 / ratio)))
    slide = max(slide, 0.05 * 7850 * (0.5 * stroke * ratio) ** 3 / slender**2)
    edge = (slide / 7850) ** (1 / 3)
    crank, rod = 0.5 * stroke, max(0.5 * stroke * ratio, edge)

    def bar(length):
        side = length / slender
        mass = 7850 * length * side**2
        return mass, mass * side**2 / 6, mass * (length**2 + side**2) / 12

    (of_crank, about, across), (of_rod, rod_about, rod_across) = bar(crank), bar(rod)
    block = slide * edge**2 / 6
    edits = [
        ('<mass value="20"/><inertia ixx="0.05" ixy="0" ixz="0" iyy="0.10" iyz="0" izz="0.05"/>', (of_crank, about, across, across)),
        (
            '<mass value="15"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.20" iyz="0" izz="0.20"/>',
            (of_rod, rod_about, rod_across, rod_across),
        ),
        ('<mass value="100"/><inertia ixx="0.75" ixy="0" ixz="0" iyy="0.80" iyz="0" izz="0.80"/>', (slide, block, block, block)),
    ]
    bodies = [
        (old, f'<mass value="{m!r}"/><inertia ixx="{x!r}" ixy="0" ixz="0" iyy="{y!r}" iyz="0" izz="{z!r}"/>') for old, (m, x, y, z) in edits
    ]
    lengths = [
        ('<origin xyz="0.100 0 0"/>', f'<origin xyz="{crank!r} 0 0"/>'),
        ('<link1 link="rod" xyz="0.400 0 0"', f'<link1 link="rod" xyz="{rod!r} 0 0"'),
        ('<origin xyz="0 0 -0.500"/>', f'<origin xyz="0 0 {-crank - rod!r}"/>'),
        ('lower="-0.01" upper="0.21"', f'lower="{-0.1 * stroke!r}" upper="{1.1 * stroke!r}"'),
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        press = load(tmp_path, *bodies, *lengths)
        turn = pp.cycle(press, speed=speed, points=24)
        again = pp.servo_cycle(press, speed=turn.crank_speed, angle=turn.crank_angle, acceleration=0.0, time=turn.time)
        pp.inverse_dynamics(press, again)
        pp.simulate(press, 1e-3, speed=speed, points=3)


# Process loads


# A load in inverse dynamics and in a run: press, load, words of the warning.
ODD_LOADS = [
    ("crank_slide", loads.Blanking(1e5, 10.0, 5.0), "Blanking acts from 5 to 10 m above its datum, nowhere on the slide's stroke"),
    ("crank_slide", loads.Blanking(1e5, 0.9, 0.4), "Blanking acts from 0.4 to 0.9 m above its datum, nowhere"),
    ("crank_slide", loads.ForceStroke([0.0, 10.0, 20.0], [0.0, 1e5, 2e5]), "ForceStroke acts from 0 to 20 m above its datum, far off"),
    ("crank_slide", loads.ConstantForce(1e5, 0.008, datum=-500.0), "ConstantForce acts from -inf to 0.008 m above its datum, nowhere"),
    ("crank_slide", loads.DeepDrawing(1e5, 0.02, datum=-500.0), "DeepDrawing acts from 0 to 0.02 m above its datum, nowhere"),
    ("crank_slide", loads.PointForce("rod", (0.0, 0.0, 1e3), (200.0, 0.0, 0.0)), "load on 'rod': point is 200 m from its link's origin"),
    ("crank_slide", loads.SpringDamper("frame", "slide", 1e4, point1=(0, 0, 600.0)), "spring between 'frame' and 'slide': point1 is 600 m"),
    ("zxn2_3000b", loads.ConstantForce(3e6, 8.0), "ConstantForce acts up to 8 m above its datum, and the slide's"),
    ("zxn2_3000b", loads.DeepDrawing(3000.0, 0.05), "its largest force is 3000 N, 4.3 % of the weight of the slide: if kN are meant"),
    ("zxn2_3000b", loads.ForceStroke([0.0, 0.01], [0.0, 2000.0]), "ForceStroke: its largest force is 2000 N, 2.9 % of the weight"),
    (
        "zxn2_3000b",
        loads.ImpactDamper([-3.0, 2.5], [1e6, 1e6]),
        "ImpactDamper acts up to 2.5 m above its datum, and the slide's stroke ends",
    ),
    ("zxn2_3000b", loads.PneumaticCushion(0.25, 6e5, 0.06, -0.08), "PneumaticCushion acts from -inf to -0.08 m above its datum, nowhere"),
    ("zxn2_3000b", loads.DeepDrawing(3e6, 0.5), "DeepDrawing begins at 0.5 m above its datum, and the slide's stroke ends at 0.30"),
]


@pytest.mark.parametrize(("name", "load", "message"), ODD_LOADS, ids=[message for *_, message in ODD_LOADS])
def test_loads_in_other_units_are_warned_of_once(name, load, message):
    press = shipped(name)
    for call in (
        lambda: pp.inverse_dynamics(press, pp.cycle(press, 7.0, points=36), [load]),
        lambda: pp.simulate(press, 1e-3, speed=7.0, flywheel=drives.Flywheel(1e4), loads=[load]),
    ):
        with pytest.warns(pp.PinpressWarning, match=re.escape(message)) as caught:
            call()
        assert [warning.filename for warning in caught] == [__file__]


MISTAKES = [
    (lambda: loads.orifice_coefficient(160.0, 12.0), "orifice_coefficient: piston is 160 m: if mm are meant, write 160e-3"),
    (lambda: loads.RateSensitiveBlanking(6e5, 0.004, 0.002, 0.05, reference_speed=1.0), "if mm/s are meant, write 1e-3"),
    (lambda: drives.InductionMotor(75e3, 1485 * pp.RPM, rated_rise=80.0, thermal_time=45.0), "if minutes are meant, write 45 * 60"),
    (lambda: drives.ServoMotor([0.0, 1.0], [0.0, 1.0], 1e4, 1e2, 1e3, thermal_time=30.0), "if minutes are meant, write 30 * 60"),
    (lambda: classical.with_opposed_balancer(plain(), 29.7), "beside a linkage of 0.315 m: give it in m, 29.7e-3 if mm are meant"),
    (lambda: classical.with_balance_shafts(plain(), radius=0.15, shaft_distance=800.0), "with_balance_shafts: shaft_distance is 800 m"),
    (lambda: classical.mirrored(plain(), 500.0), "mirrored: shaft_distance is 500 m"),
    (lambda: rubbing(slide_guide=loads.Friction(0.1, preload=80.0)), "its preload is 80 N: if kN are meant, write 80e3"),
    (lambda: guide_of((450.0, 300.0), (0.0, 0.0, 0.0)), "point is 450 m from its link's origin, far off a linkage of 0.315 m"),
    (lambda: drives.InductionMotor(75, 1485 * pp.RPM, inertia=1.2), "give rated_power in W, and inertia in kg m2"),
    (lambda: drives.InverterMotor(482.0, 1485 * pp.RPM, 40.0, inertia=1.2e4), "give rated_torque in N m, and inertia"),
    (lambda: drives.InductionMotor(75e3, 1485 * pp.RPM, frequency=314.0), "9420 r/min at 314 Hz with 4 poles"),
    (lambda: drives.InductionMotor(75e3, 1485 * pp.RPM, breakdown_ratio=250), "if per cent are meant, write 250e-2"),
    (lambda: drives.InverterMotor(482.0, 1485 * pp.RPM, 40.0, overload=150), "overload is 150: if per cent are meant, write 150e-2"),
    (lambda: drives.InductionMotor(75e3, 1485 * pp.RPM, constant_loss=1.5), "constant_loss is 1.5 W: if kW are meant, write 1.5e3"),
    (lambda: drives.InductionMotor(75e3, 1485 * pp.RPM, rated_rise=378.0), "rated_rise is 378 K: give by how much it becomes warmer"),
    (lambda: drives.Brake(2e4, rise=150.0), "Brake: rise is 150 s: if ms are meant, write 150e-3"),
    (lambda: loads.Blanking(4e6, 0.008, 0.003, stripping=200.0), "beside a force of 4e+06 N: if kN are meant, write 200e3"),
    (lambda: loaded(loads.ElasticDie(0.002, 1e3), points=360), "0.2 % of the weight of the slide: give stiffness in N/m, 1e6 for 1 kN/mm"),
    (
        lambda: driven(drives.Geared(drives.InductionMotor(3.0, 1400 * pp.RPM), 20.0)),
        "the rated torque of InductionMotor is 0.4093 N m at the crank, 0.42 % of the 98.1 N m that hold the weight of the slide",
    ),
    (
        lambda: driven(drives.InductionMotor(3e3, 1400 * pp.RPM)),
        "InductionMotor would turn the crank at 1500 r/min, at which the acceleration of the slide reaches 314 g: put gears between them",
    ),
    (lambda: driven(None, flywheel=drives.Flywheel(5e6)), "beside a linkage of 135 kg and 0.5 m: if kg mm2 are meant, write 5"),
    (lambda: driven(None, brake=drives.Brake(0.4)), "0.41 % of the 98.1 N m that hold the weight of the slide"),
    (lambda: driven(None, angle=90.0), "angle is 90 rad: if degrees are meant, write numpy.radians(angle)"),
    (lambda: pp.servo_cycle(crank_slide(), np.arange(0.0, 181.0), speed=5.0), "if degrees are meant, write numpy.radians(angle)"),
    (lambda: guide_of((0.45, 0.3), (50.0, 30.0, 0.0)), "offset is 50 m from its link's origin, far off a linkage of 0.315 m"),
    (lambda: elasticity.compliance(plain(), springs(2e6), angle=[0.0]), "2.16e+04 N, deflects by 10.8 mm: give N/m"),
    (
        lambda: elasticity.natural_frequencies(plain(), elasticity.Elastic(springs(2e6)), angle=[0.0]),
        "Stiffness: the largest of bearings is 2e+06 N/m",
    ),
    (
        lambda: elasticity.natural_frequencies(plain(), elasticity.Elastic(springs(2e9, 2e2)), angle=[0.0]),
        "Stiffness: the largest of moments is 200 N m/rad, which the weight of the slide at the length of the linkage, 6.8e+03 N m, turns",
    ),
    (
        lambda: elasticity.natural_frequencies(plain(), elasticity.Elastic(springs(2e9, frame=4e9), crown_mass=12.0), angle=[0.0]),
        "Elastic: crown_mass is 12 kg, beside 2330 kg of the links: if t are meant, write 12e3",
    ),
    (lambda: elasticity.snap_through(4e6, 3e6, 7e3), "which 4e+06 N deflect by 1.33e+03 mm: give N/m, 1e6 for 1 kN/mm"),
    (lambda: elasticity.snap_through(4e6, 3e9, 7.0), "mass is 7 kg, which swings at 3.29e+03 Hz on 3e+09 N/m: if t are meant, write 7e3"),
    (lambda: elasticity.permissible_breakthrough(4e5, 3e9, 7e3, break_time=2.0), "break_time is 2 s: if ms are meant, write 2e-3"),
    (lambda: elasticity.snap_through(4e6, 3e9, 7e3, clearance=0.2), "clearance is 0.2 m: if mm are meant, write 0.2e-3"),
    (lambda: elasticity.hertz_stiffness(80.05, 80.0), "hertz_stiffness: bearing_radius is 80.05 m: if mm are meant, write 80.05e-3"),
    (lambda: elasticity.hertz_stiffness(0.08005, 0.08, modulus=207), "modulus is 207 Pa: if GPa are meant, write 207e9; if MPa, 207e6"),
    (lambda: beam(area=20_000, second_moment=1e8), "give m2 and m4, 1e-6 for 1 mm2"),
    (lambda: beam(area=1e-4, second_moment=0.02), "are those of no section of a link of 0.48 m"),
    (lambda: beam(area=0.02, second_moment=1e-4, modulus=2.1e5), "modulus is 210000 Pa: if GPa are meant"),
    (lambda: beam(area=0.02, second_moment=1e-4, damping_ratio=1.5), "damping_ratio is 1.5: give 0.015 if per cent are meant"),
    (lambda: guide_of((0.45, 0.3), (0.0, 0.0, 0.0), length=600.0), "beside a linkage of 0.315 m: give it in m, 600e-3 if mm are meant"),
    (lambda: tolerances.link_length(six_bar(), "E", "F", 5e-5, sd=5e-4), "dimension 'EF': sd is 0.0005 m, above its tolerance of 5e-05"),
    (lambda: scattered(forces={0.006: 3e3}), "forces at 0.006 m: its largest force is 3000 N, 4.3 % of the weight"),
    (lambda: scattered(speeds={0.006: 70}), "speed is 70 rad/s, 668.451 r/min, at which the acceleration of the slide"),
    (lambda: tolerances.allocate(six_bar(), rods(), None, {"height": 20}), "give it in m, 20e-6 if um are meant"),
    (lambda: tolerances.heat(six_bar(), tolerances.Temperatures({"frame": 10.0}, table=-1500.0)), "give it in m, 1500e-3 if mm are meant"),
    (lambda: tolerances.budget(six_bar(), speeds=[70], clearance={"F": 5e-5}), "speed is 70 rad/s, 668.451 r/min"),
    (lambda: tolerances.budget(six_bar(), speeds=[7.0], clearance={"F": 5e-5}, process=3000.0), "if kN are meant, write 3e+06"),
    (lambda: tolerances.PermissibleSlope(0.02), "PermissibleSlope: constant is 0.02 m: if mm are meant, write 0.02e-3"),
    (lambda: on_mounts(place=900.0), "mount 1: point is 900 m from its link's origin, far off a linkage of 0.315 m"),
    (lambda: on_mounts(stiffness=5e4, wide=4.0), "give stiffness in N/m, 1e6 for 1 kN/mm, and mass in kg"),
    (
        lambda: on_mounts(inertia=(5.0, 4.0, 3.0)),
        "frame: with a mass of 9000 kg and a moment of inertia of 5 kg m2 its radius of gyration is 0.0236 m, around a linkage of 0.315 m",
    ),
    (lambda: foundation.Mount((0, 0, 0), (1e6, 1e6, 1e6), loss_factor=8), "Mount: loss_factor is 8: if per cent are meant, write 8e-2"),
    (lambda: foundation.RubberPad(0.2, 200, 0.05, 65), "RubberPad: width is 200 m: if mm are meant, write 200e-3"),
    (lambda: ratings.rate(crank_slide(), 6.0, ratings.Capacities(40.0, torque=4e3)), "if kN are meant, write 40000"),
    (lambda: ratings.rate(crank_slide(), 6.0, ratings.Capacities(250.0, torque=4e3)), "if kN are meant, write 250000"),
    (
        lambda: ratings.rate(crank_slide(), 6.0, ratings.Capacities(4e4, torque=4e3, motor_power=2.2)),
        "motor_power by speed is 0.3667 N m at the crank, 0.37 % of the 98.1 N m that hold the weight of the slide",
    ),
    (
        lambda: pp.sweeps.operating_points(crank_slide(), [6.0], forces=[3e6], unit_load=loads.Blanking(3e6, 0.008, 0.003)),
        "Blanking: its largest force is 9e+12 N, 9.2e+09 times the weight of the slide: give it in N",
    ),
    (lambda: servo.ServoDrive(inertia=5e3, peak_torque=2e3, top_speed=260.0), "give peak_torque in N m, and inertia in kg m2"),
    (
        lambda: servo.CatalogueMotor("m", 5e3, [0.0, 260.0], [700.0, 400.0], [2e3, 1e3]),
        "m: its rated torque takes 650 s to turn its own rotor up to speed",
    ),
    (
        lambda: servo.best_motion(crank_slide(), servo.ServoDrive(0.1, 20.0), time=1000.0, points=60),
        "time is 1000 s: if ms are meant, write 1000e-3; n strokes a minute take 60 / n",
    ),
    (lambda: servo.SlideSpeed(200.0), "SlideSpeed: speed is 200 m/s: if mm/s are meant, write 200e-3"),
    (
        lambda: loaded(loads.SpringDamper("frame", "slide", 5e4, free_length=400.0, point1=(0, 0, 0.5))),
        "free_length is 400 m, beside a linkage of 0.5 m: give it in m, 400e-3 if mm are meant",
    ),
    (lambda: rubbing(O=loads.Friction(0.05, radius=30)), "its radius is 30 m, beside a linkage of 0.5 m: if mm are meant, write 30e-3"),
    (lambda: rubbing(O=loads.Friction(5, radius=0.03)), "friction of 'O': its coefficient is 5: if per cent are meant, write 5e-2"),
]


def crank_slide():
    return shipped("crank_slide")


def plain():
    return shipped("jf75g_125_plain")


def six_bar():
    return shipped("zxn2_3000b")


def loaded(*acting, points=12, **more):
    return pp.inverse_dynamics(crank_slide(), pp.cycle(crank_slide(), 7.0, points=points), acting, **more)


def rubbing(**friction):
    return loaded(friction=friction)


def driven(drive, **more):
    return pp.simulate(crank_slide(), 1e-3, speed=7.0, drive=drive, points=2, **more)


def guide_of(facing_x, offset, length=0.6):
    surfaces = elasticity.eight_way_guide(facing_x=facing_x, facing_y=(0.4, 0.35), length=length, width=0.08, stiffness=2e9, preload=1e5)
    return elasticity.guide_contact(plain(), pp.inverse_dynamics(plain(), pp.cycle(plain(), 7.0, points=12)), surfaces, offset=offset)


def springs(stiffness, turning=2e8, **more):
    return elasticity.Stiffness(dict.fromkeys(plain().bearings, stiffness), moments={"slide_guide": turning}, **more)


def beam(**section):
    return elasticity.flexible_beam(six_bar(), "rod", ("E", "F"), **section)


def rods():
    return [tolerances.link_length(six_bar(), *pins, 5e-5) for pins in (("E", "F"), ("D", "E"))]


def scattered(**more):
    return tolerances.bottom_dead_centre(six_bar(), rods(), samples=50, **more)


def on_mounts(place=0.9, stiffness=3e8, wide=1.0, inertia=(5000.0, 4000.0, 3000.0)):
    mounts = [foundation.Mount((x, y, -place), (stiffness,) * 3) for x in (-0.5 * wide, 0.5 * wide) for y in (-0.4 * wide, 0.6 * wide)]
    return foundation.mounted(plain(), foundation.Frame(9000.0, (0.0, 0.1, 0.0), inertia), mounts)


@pytest.mark.parametrize(("call", "message"), MISTAKES, ids=[message for _, message in MISTAKES])
def test_numbers_in_other_units_are_warned_of(call, message):
    """Where it is called. Other numbers of the call may be warned of too, and the call itself may fail."""
    with pytest.warns(pp.PinpressWarning) as caught, suppress(pp.PinpressError):
        call()
    said = [str(warning.message) for warning in caught]
    assert any(message in text for text in said), said
    assert {warning.filename for warning in caught} == {__file__}


# One angle; a turn, also without its end; steps of two, without the end; tens; few; a servo program.
DEGREES = [
    [90.0],
    np.arange(0.0, 361.0),
    np.arange(0.0, 360.0),
    np.arange(-90.0, 90.0, 2.0),
    np.arange(10.0, 351.0, 10.0),
    [0.0, 45.0, 180.0],
    [0.0, 83.0, 157.0, 203.0, 360.0],
]
RADIANS = [[100.0], np.arange(0.0, 101.0), -np.arange(0.0, 605.0), np.arange(7.0, 67.0), np.arange(0.0, 901.0), 2 * np.arange(0.0, 40.0)]


@pytest.mark.parametrize("angles", DEGREES)
def test_whole_degrees_are_doubted(angles):
    with pytest.warns(pp.PinpressWarning, match=re.escape("rad: if degrees are meant, write numpy.radians(angle)")):
        pp.servo_cycle(crank_slide(), angles, speed=5.0, acceleration=0.0)


@pytest.mark.parametrize("angles", RADIANS)
def test_whole_radians_are_not_doubted(angles):
    pp.servo_cycle(crank_slide(), angles, speed=5.0, acceleration=0.0)


def test_degrees_of_several_drivers_are_doubted():
    going = np.arange(0.0, 91.0)
    with pytest.warns(pp.PinpressWarning, match="angle is up to 90 rad: if degrees"):
        plausibility.angles("angle", np.column_stack([going, np.zeros(91)]))
    plausibility.angles("angle", np.column_stack([going, going + 7.0]))


@examples(10)
@given(height=st.floats(1e-5, 0.1999), thin=st.floats(0.01, 0.99), datum=st.booleans())
def test_loads_on_the_stroke_are_never_warned_of(height, thin, datum):
    """Nor is a stop beneath the slide's way, or one that is always pressed upon."""
    press = shipped("crank_slide")
    place = pp.dead_centres(press).bottom_position if datum else None
    given = [
        pp.loads.Blanking(1e3, height, thin * height, datum=place),
        pp.loads.DeepDrawing(1e3, height, datum=place),
        pp.loads.ConstantForce(1e3, height, datum=place),
        pp.loads.ElasticDie(-height, 1e5, datum=place),
        pp.loads.ElasticDie(50 * height, 1e5, datum=place),
        pp.loads.ForceStroke([thin * height, height], [0.0, 1e3], datum=place),
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*none of the motion's 12 states is there")  # a blank may be thin, which is said rightly
        pp.inverse_dynamics(press, pp.cycle(press, 7.0, points=12), given)
        pp.simulate(press, 1e-3, speed=7.0, flywheel=pp.drives.Flywheel(1e4), loads=given, points=3)


def steady(press, speed):
    motor = pp.drives.InductionMotor(1e5, 0.98 * speed, frequency=speed / TURN, poles=2)
    return pp.steady_state(press, speed, drive=motor, flywheel=pp.drives.Flywheel(100.0))


SPEEDS = {
    "cycle": lambda press, speed: pp.cycle(press, speed),
    "servo motion": lambda press, speed: pp.servo_cycle(press, speed=[speed, speed], angle=[0.0, 1.0]),
    "simulate": lambda press, speed: pp.simulate(press, 1e-3, speed=speed, points=2),
    "prescribed": lambda press, speed: pp.simulate(press, 1e-3, drive=pp.drives.PrescribedSpeed(speed), points=2),
    "scenarios": lambda press, speed: pp.simulate_batch(press, 1e-3, speed=[speed, 5.0], points=2),
    "steady state": steady,
    "operating points": lambda press, speed: pp.sweeps.operating_points(press, [speed]),
    "ratings": lambda press, speed: pp.ratings.rate(press, speed, pp.ratings.Capacities(1e6, nominal_height=6e-3, shaking_force=1e5)),
    "dead centre": lambda press, speed: pp.elasticity.dead_centre_shift(press, pp.elasticity.Stiffness({"W": 1e9}), speed=speed),
    "foundation": lambda press, speed: pp.foundation.over_speeds(pp.foundation.mounted(press, *frames.uneven()), [5.0, speed], points={}),
}
PARTS = {
    "drive": lambda speed: pp.drives.PrescribedSpeed(speed),
    "flywheel": lambda speed: pp.drives.Flywheel(1.0, speed),
}


@pytest.mark.parametrize("name", SPEEDS)
def test_speeds_of_no_press_are_warned_of(press, name):
    """Those at which the slide is accelerated as that of no press; none beside it, where a function tries twice the speed."""
    said = "speed.* is 60 rad/s, 572.958 r/min, at which the acceleration of the slide reaches 45.9 g: lower it; in Python 60 r/min are 60 "
    with pytest.warns(pp.PinpressWarning, match=said) as caught:
        SPEEDS[name](press, 60.0)
    assert {(warning.filename, str(warning.message)) for warning in caught} == {(__file__, str(caught[0].message))}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        SPEEDS[name](press, 55.0)


@pytest.mark.parametrize("name", PARTS)
def test_speeds_of_no_shaft_are_warned_of(name):
    said = r"speed is 1450 rad/s, 13846.5 r/min: lower it; in Python 1450 r/min are 1450 \* pinpress.RPM"
    with pytest.warns(pp.PinpressWarning, match=said):
        PARTS[name](1450.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        PARTS[name](152.0)


def test_a_crank_that_moves_no_slide_may_turn_fast(tmp_path):
    """A linkage without slide, one whose slide hardly moves, and a servo motion that is fast where the slide is not accelerated."""
    small = [('<origin xyz="0.100 0 0"/>', '<origin xyz="0.0004 0 0"/>'), ('<origin xyz="0 0 -0.500"/>', '<origin xyz="0 0 -0.4004"/>')]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pp.cycle(load_text(four_bar(1.0, 0.3, 0.9, 0.7, 0.5).urdf("O")), 999.0)
        pp.cycle(load(tmp_path, *small), 999.0)
        pp.servo_cycle(shipped("crank_slide"), angle=[1.34, 1.341], speed=100.0)


@examples(30)
@given(
    power=st.floats(50.0, 5e5),
    slip=st.floats(0.005, 0.15),
    poles=st.sampled_from([2, 4, 6, 8]),
    size=st.floats(0.5, 2.0),
    strokes=st.floats(10.0, 150.0),
    angle=st.floats(-700.0, 700.0),
)
def test_sensible_drives_are_never_warned_of(power, slip, poles, size, strokes, angle):
    """Motors of 50 W to 500 kW, with rotors as in catalogues, on presses whose slides they can lift, and their flywheels and brakes."""
    top = 2 * TURN * 50.0 / poles
    rotor = size * 3e-9 * power**1.2 * poles**2 / 16 * 1e3 * (157.0 / top) ** 0.5
    motor = pp.drives.InductionMotor(power, (1 - slip) * top, poles=poles, inertia=rotor, constant_loss=0.01 * power, rated_rise=80.0)
    press = shipped("crank_slide")
    ratio = top / (strokes * pp.RPM)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wheel, brake = pp.drives.Flywheel(size * 50.0), pp.drives.Brake(size * 100.0, pp.drives.SwitchPoint(time=1e-3), rise=0.1)
        pp.simulate(press, 1e-3, speed=5.0, angle=angle, drive=pp.drives.Geared(motor, ratio), flywheel=wheel, brake=brake, points=2)
