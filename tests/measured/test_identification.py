"""Presses whose masses, friction, cylinder and motor constant are known are found again, with intervals that hold."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from support.presses.measured_presses import columns, drawn, drive, press_of, run

import pinpress as pp
from pinpress.common.conic_program import Rows
from pinpress.measured import MeasuredRun, identifiability, identify
from pinpress.measured.estimates.base_parameters import base_parameters
from pinpress.measured.estimates.cones import TINY, _in_plane, _in_space
from pinpress.measured.estimates.least_squares import Fit, _noise, _sandwich
from pinpress.measured.estimates.weak_form import smoothed
from pinpress.measured.regressor import inertial_equations, loss_columns

STROKES = {"zxn2_3000b": (21, 42, 63), "jf75g_125": (120, 200, 300), "knuckle": (20, 40, 60), "rssp": (40, 80, 120)}
LOSSES = ("crank", "gibs")


def clean(name, seed=0, rate=1000.0, friction=(), losses=()):
    """Records without noise, and the masses that made them."""
    masses = drawn(name, np.random.default_rng(seed), 0.1)
    runs = []
    for strokes in (60, 100, 140) if name == "jf75g_125" else (20, 40, 60):  # where inertia tells masses from weights
        moved = drive(strokes, rate=rate)
        runs.append(run(moved, columns(name, strokes, friction, False, rate=rate) @ np.concatenate([masses, losses])))
    return runs, masses


def noisy(name, seed, counts=8192, noise=0.01, friction=LOSSES):
    """Records with noise; masses, losses, and the bound of Cramer and Rao for base parameters and losses without a prior."""
    rng, press = np.random.default_rng(seed), press_of(name)
    masses = drawn(name, rng)
    parts = [columns(name, strokes, friction, True) for strokes in STROKES[name]]
    whole, described = np.concatenate(parts), inertial_equations(press).values
    inertial = whole[:, : len(described)] @ described
    alone = np.sqrt((inertial**2).mean() / (whole[:, len(described) :] ** 2).mean(axis=0))
    losses = 0.1 * alone * rng.uniform(0.3, 2.0, len(alone))
    size = noise * np.abs(inertial).max()
    truth = np.concatenate([masses, losses])
    runs = [
        run(drive(strokes), part @ truth, rng, size, counts, name=f"{strokes} strokes a minute")
        for strokes, part in zip(STROKES[name], parts, strict=True)
    ]
    return runs, masses, losses, size


def shifted(runs, zero):
    """The same records by an encoder that shows this where the press is as drawn."""
    return [replace(each, angle=each.angle + zero) for each in runs]


def test_variances_that_rounding_made_negative_are_zero():
    """As of an encoder's zero that is known to rounding, beside variances of size one."""
    one, other = np.diag([4.0, -1e-30, 1.0]), np.diag([1.0, -1e-29, 9.0])
    fit = Fit(np.zeros(3), one, other, 0.0, (0.0, 0.0), {}, np.zeros(3))
    assert fit.deviation.tolist() == [2.0, 0.0, 3.0]


@pytest.mark.parametrize(
    ("name", "zero", "known", "exact"),
    [
        ("zxn2_3000b", 0.0, {"encoder zero": (0.0, 1e-15)}, 1e-8),
        ("zxn2_3000b", 0.05, {}, 1e-7),
        pytest.param("knuckle", -0.05, {}, 1e-7, marks=pytest.mark.exhaustive),
        pytest.param("jf75g_125", 0.05, {}, 1e-7, marks=pytest.mark.exhaustive),
    ],
)
@pytest.mark.filterwarnings("ignore:.*residuals scatter more:pinpress.PinpressWarning")  # without noise they are the rounding of sums
def test_without_noise_base_parameters_are_exact(name, zero, known, exact):
    """The encoder's zero hides behind others, ten times as much as they behind each other; those of the JF75G-125 are told least."""
    runs, masses = clean(name, rate=4000.0 if name == "jf75g_125" else 2000.0, friction=("crank",), losses=(80.0, 6.0))
    found = identify(press_of(name), shifted(runs, zero), friction=("crank",), known=known)
    equations = inertial_equations(press_of(name))
    base = base_parameters(equations)
    sizes = np.abs(base.matrix) @ [each.size for each in equations.parameters]
    errors = [abs(each.value - true) for each, true in zip(found.base_parameters, base.matrix @ masses, strict=True)]
    assert (errors / sizes).max() < exact
    assert found.values["encoder zero"] == pytest.approx(zero, abs=exact)
    assert found.losses == pytest.approx({"crank friction": 80.0, "crank viscous friction": 6.0}, rel=10 * exact)


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore:.*residuals scatter more:pinpress.PinpressWarning")
def test_the_press_found_moves_as_the_records_say(tmp_path):
    """In space too; it is a linkage and a URDF."""
    for name, exact in (("rssp", 1e-3), ("zxn2_3000b", 1e-6)):
        runs, masses = clean(name, seed=1, rate=2000.0)
        found = identify(press_of(name), runs, friction=())
        motion = pp.cycle(press_of(name), 11.0, points=50)
        true = inertial_equations(press_of(name)).columns(motion) @ masses
        np.testing.assert_allclose(found.torque(motion), true, atol=exact * np.abs(true).max())
        pp.write_urdf(found.press, tmp_path / "found.urdf")
        again = pp.load(tmp_path / "found.urdf")
        np.testing.assert_allclose(pp.inverse_dynamics(again, motion).driving_torque, found.torque(motion), atol=1e-6 * np.abs(true).max())


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    "name", ["rssp", *(pytest.param(each, marks=pytest.mark.exhaustive) for each in ("jf75g_125", "zxn2_3000b", "knuckle"))]
)
def test_noisy_records_are_within_intervals(name):
    """A press in space among them; nothing is warned of."""
    runs, masses, losses, noise = noisy(name, 3)
    found = identify(press_of(name), runs, friction=LOSSES, cylinder=True)
    truth = dict(zip([each.name for each in inertial_equations(press_of(name)).parameters], masses, strict=True))
    truth |= dict(zip(found.losses, losses, strict=True)) | {"encoder zero": 0.0}
    missed = [each for each in found.intervals if not wide(found.intervals[each], 2.0, truth[each])]
    assert missed == []  # within twice the intervals
    assert found.noise["torque"] == pytest.approx(noise, rel=0.05)
    assert 5 < found.learnt < len(found.parameters)
    assert "doubt" in str(found)
    assert all((each.doubt is None) == (each.posterior == 0) for each in found.base_parameters)  # of a link that has no mass
    for way in (1, -1):  # what it needs is the power of its masses, cylinder and losses, both ways
        motion = pp.cycle(found.press, 3.0 * way, points=40)
        rate, height = motion.slide_velocity / motion.crank_speed, motion.slide_position - pp.dead_centres(found.press).bottom_position
        lifts = (found.losses["cylinder force"] + found.losses["cylinder stiffness"] * height) * rate
        lost = found.losses["crank friction"] + found.losses["gibs friction"] * np.abs(rate)
        masses = pp.inverse_dynamics(found.press, motion).driving_torque
        needed = masses - lifts + way * lost + found.losses["crank viscous friction"] * motion.crank_speed
        np.testing.assert_allclose(found.torque(motion), needed, rtol=0, atol=1e-9 * np.abs(needed).max())
    doubts = [each.doubt for each in found.base_parameters if each.doubt is not None]
    assert 0 < min(doubts) < 0.1 < max(doubts) < 1.5  # the least of what the crank feels most


def wide(interval, by, value):
    """Whether a value is within an interval that is so many times as wide."""
    low, high = interval
    return abs(value - (low + high) / 2) <= by * (high - low) / 2 + 1e-9


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("name", "degrees"),
    [("zxn2_3000b", 4.0), *(pytest.param(*each, marks=pytest.mark.exhaustive) for each in (("knuckle", -3.0), ("jf75g_125", 170.0)))],
)
def test_the_encoders_zero_is_found_and_changes_nothing_else(name, degrees):
    """Some degrees off, or by far, as where it was set at another dead centre, which is said."""
    runs, *_ = noisy(name, 4)
    plain = identify(press_of(name), runs, friction=LOSSES, cylinder=True)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = identify(press_of(name), shifted(runs, np.radians(degrees)), friction=LOSSES, cylinder=True)
    assert ["give record(..., zero=)" in str(each.message) for each in said] == [True] * (abs(degrees) > 90)
    assert wide(found.intervals["encoder zero"], 1.5, np.radians(degrees))
    deviations = {each.name: each.posterior for each in plain.parameters}
    for each in found.parameters:
        if each.name != "encoder zero":
            assert each.value == pytest.approx(plain.values[each.name], abs=0.05 * deviations[each.name])
    motion = pp.cycle(press_of(name), 5.0, points=20)
    np.testing.assert_allclose(found.torque(motion), plain.torque(motion), atol=1e-3 * np.abs(plain.torque(motion)).max())


@pytest.mark.exhaustive
def test_an_encoder_that_counts_downwards_is_half_a_count_off():
    """Two minutes by 8192 counts: nothing is doubted, the zero is half a count."""
    strokes, step, rng = 40, 2 * np.pi / 8192, np.random.default_rng(3)
    moved = drive(strokes, seconds=100.0, rate=500.0)
    masses = drawn("zxn2_3000b", rng)
    torque = columns("zxn2_3000b", strokes, ("crank",), False, 100.0, 500.0) @ [*masses, 500.0, 80.0]
    noise = 0.01 * np.abs(torque).max() * rng.normal(size=len(torque))
    found = identify(
        press_of("zxn2_3000b"), [MeasuredRun(moved.time, np.floor(moved.angle / step) * step, torque + noise)], friction=("crank",)
    )
    assert wide(found.intervals["encoder zero"], 1.5, -step / 2)
    low, high = found.intervals["encoder zero"]
    assert high - low < step
    assert wide(found.intervals["crank friction"], 1.5, 500.0)


@pytest.mark.exhaustive
def test_two_minutes_in_space_settle_from_afar():
    """So many samples leave so little noise that several steps have to be shortened before one leads nearer, and may be whole again."""
    rng = np.random.default_rng(0)
    masses, speeds = drawn("rssp", rng), STROKES["rssp"]
    torques = [columns("rssp", strokes, (), False, 40.0, 1000.0) @ masses for strokes in speeds]
    rubbing, noise = (share * max(np.abs(torque).max() for torque in torques) for share in (0.02, 0.01))
    runs = [run(drive(strokes, 40.0, 1000.0), torque + rubbing, rng, noise, 8192) for strokes, torque in zip(speeds, torques, strict=True)]
    found = identify(press_of("rssp"), runs, friction=LOSSES, cylinder=True)
    for name, value in (("crank friction", rubbing), ("encoder zero", 0.0)):
        assert wide(found.intervals[name], 1.5, value), name


@pytest.mark.exhaustive
def test_what_was_weighed_narrows_what_hides_behind_it():
    """In the JF75G-125 slide and counterweight hide behind each other; the sum of all masses tells the rest of them."""
    name = "jf75g_125"
    runs, masses, losses, _ = noisy(name, 6)
    names = [each.name for each in inertial_equations(press_of(name)).parameters]
    slide, other = (masses[names.index(f"{link} mass")] for link in ("slide", "counterweight"))
    total = sum(mass for each, mass in zip(names, masses, strict=True) if each.endswith(" mass"))
    made = [
        identify(press_of(name), runs, friction=LOSSES, cylinder=True, known=known)
        for known in ({}, {"slide mass": (slide + 1.0, 2.0)}, {"slide mass": (slide + 1.0, 2.0), "total mass": (total, 5.0)})
    ]
    plain, weighed = ({each.name: each for each in found.parameters} for found in made[:2])
    assert weighed["slide mass"].posterior == pytest.approx(2.0, rel=0.01)
    assert weighed["slide mass"].value == pytest.approx(slide + 1.0, abs=0.5)
    assert weighed["counterweight mass"].posterior < 0.5 * plain["counterweight mass"].posterior
    assert wide(made[1].intervals["counterweight mass"], 1.5, other)
    summed = np.array([each.name.endswith(" mass") for each in made[0].parameters], dtype=float)
    deviations = [float(np.sqrt(summed @ found.covariance @ summed)) for found in made]
    assert deviations[2] < 5.0 < 20.0 < deviations[1] < deviations[0]
    assert summed @ list(made[2].values.values()) == pytest.approx(total, abs=10.0)
    assert made[1].learnt < made[0].learnt  # the records add less to it
    assert wide(made[2].intervals["crank friction"], 2.0, losses[0])


def rubbing(name, seed=0, added=None, constant=None, noise=0.0, in_bearings=1.0):
    """Records of a press with friction in pins and guide, a cylinder, and a mass that is fastened to the slide."""
    rng, press = np.random.default_rng(seed), press_of(name)
    real, runs = inertial_equations(press).pressed(drawn(name, rng)), []
    for strokes in (40, 55, 70):
        moved = drive(strokes, seconds=3.5)
        motion = pp.servo_cycle(real, moved.angle, speed=moved.speed, acceleration=moved.acceleration)
        lost = loss_columns(real, *moved[1:], ("crank", "pins", "slide_guide"), True, cylinder_load=(2e4, 1.5e4))
        torque = pp.inverse_dynamics(real, motion).driving_torque + lost @ [
            800.0,
            60.0,
            0.002 * in_bearings,
            0.03 * in_bearings,
            2e4,
            1.5e4,
        ]
        more = {}
        if added:
            torque = torque + added * (motion.slide_acceleration + 9.81) * motion.slide_velocity / moved.speed
            more["added_mass"] = {"slide": added}
        made = run(moved, torque, rng, noise, 8192, **more)
        runs.append(made if constant is None else MeasuredRun(made.time, made.angle, current=made.torque / constant, **more))
    return runs


@pytest.mark.exhaustive
def test_friction_of_pins_and_guide_goes_with_the_forces_of_the_press_found():
    found = identify(press_of("zxn2_3000b"), rubbing("zxn2_3000b", noise=25.0), friction=("crank", "pins", "slide_guide"), cylinder=True)
    truth = {"pins friction": 0.002, "slide guide friction": 0.03, "crank friction": 800.0, "crank viscous friction": 60.0}
    for name, value in truth.items():
        assert wide(found.intervals[name], 1.5, value)
    assert found.values["pins friction"] == pytest.approx(0.002, rel=0.02)
    assert set(found.friction) == {*"ABCDEF", "slide_guide"}
    assert found.friction["A"].coefficient * found.friction["A"].radius == pytest.approx(found.values["pins friction"])
    motion = pp.cycle(press_of("zxn2_3000b"), 5.0, points=40)
    assert found.torque(motion).mean() > pp.inverse_dynamics(found.press, motion).driving_torque.mean() + 700


@pytest.mark.exhaustive
def test_currents_without_noise_tell_the_motor_constant():
    """The same records with and without a mass on the slide; the constant is far from 1, and the press from what is described."""
    made = {"constant": 95.0, "noise": 0.0, "in_bearings": 0.0}
    runs = rubbing("zxn2_3000b", **made)[:2] + rubbing("zxn2_3000b", added=1000.0, **made)[:2]
    found = identify(press_of("zxn2_3000b"), runs, prior=0.5, friction=("crank",), cylinder=True)
    assert found.motor_constant == pytest.approx(95.0, rel=1e-3)
    assert found.values["crank friction"] == pytest.approx(800.0, rel=1e-2)


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore:run. samples are:pinpress.PinpressWarning")  # uneven
def test_samples_that_a_bus_lost_change_little():
    """A sixth of them, each alone; sums over time take what is left by its distances."""
    runs, _ = clean("zxn2_3000b", rate=2000.0, friction=("crank",), losses=(900.0, 50.0))
    rng, kept = np.random.default_rng(4), []
    for each in runs:
        lost = rng.random(len(each.time)) < 0.2
        lost[1:] &= ~lost[:-1]
        kept.append(MeasuredRun(each.time[~lost], each.angle[~lost], each.torque[~lost]))
    found = identify(press_of("zxn2_3000b"), kept, friction=("crank",))
    assert found.values["crank friction"] == pytest.approx(900.0, abs=0.5)
    assert found.values["crank viscous friction"] == pytest.approx(50.0, abs=0.2)


def test_noise_and_sandwiches_count_what_was_fitted_and_what_was_known():
    """Of 12 rows with 8 unknowns four are left to tell the noise; without residuals the sandwich is what is known beforehand, passed on."""
    rng = np.random.default_rng(2)
    columns = rng.normal(size=(12, 8))
    found = [_noise(columns, rng.normal(size=12), 12) ** 2 for _ in range(4000)]
    assert np.mean(found) == pytest.approx(1.0, rel=0.05)
    information, covariance = np.diag([4.0, 9.0]), np.array([[2.0, 0.5], [0.5, 1.0]])
    still = _sandwich(rng.normal(size=(50, 2)), np.zeros(50), information, covariance)
    np.testing.assert_allclose(still, covariance @ information @ covariance)


@pytest.mark.exhaustive
@pytest.mark.parametrize(("added", "exact"), [(200.0, 0.04), (1000.0, 0.008)])
def test_a_known_mass_tells_the_motor_constant(added, exact):
    made = {"constant": 95.0, "noise": 250.0, "in_bearings": 0.0}
    runs = rubbing("zxn2_3000b", **made) + rubbing("zxn2_3000b", added=added, **made)
    found = identify(press_of("zxn2_3000b"), runs, friction=("crank",), cylinder=True)
    low, high = found.motor_constant_interval
    assert wide((low, high), 1.5, 95.0)
    assert (high - low) / 190 < exact
    assert "motor constant" in str(found)


@pytest.mark.exhaustive
def test_shaking_force_tells_what_torque_does_not():
    """Masses that hide behind each other; constant offsets of load cells do not matter."""
    name, rng = "jf75g_125", np.random.default_rng(5)
    press, masses = press_of(name), drawn(name, rng)
    real, runs = inertial_equations(press).pressed(masses), {"torque": [], "both": []}
    for strokes in STROKES[name]:
        moved = drive(strokes, seconds=3.0)
        motion = pp.servo_cycle(real, moved.angle, speed=moved.speed, acceleration=moved.acceleration)
        forces = pp.inverse_dynamics(real, motion)
        cells = {axis: forces.shaking_force[:, k] + 100.0 * rng.normal(size=len(moved.time)) + 5e4 for k, axis in ((0, "x"), (2, "z"))}
        moments = {"y": forces.shaking_moment[:, 1] + 100.0 * rng.normal(size=len(moved.time))}
        torque = forces.driving_torque + 10.0 * rng.normal(size=len(moved.time))
        runs["torque"].append(MeasuredRun(moved.time, moved.angle, torque))
        runs["both"].append(MeasuredRun(moved.time, moved.angle, torque, shaking_force=cells, shaking_moment=moments))
    found = {kind: identify(press, some, friction=()) for kind, some in runs.items()}
    k = [each.name for each in inertial_equations(press).parameters].index("slide mass")
    widths = {kind: np.diff(each.intervals["slide mass"])[0] for kind, each in found.items()}
    assert widths["both"] < 0.3 * widths["torque"]
    assert wide(found["both"].intervals["slide mass"], 1.5, masses[k])
    assert found["both"].learnt > found["torque"].learnt + 2.5


@pytest.mark.exhaustive
def test_loads_and_the_inertia_of_the_drive_are_taken_away():
    press, moved = press_of("crank_slide"), drive(60, seconds=4.0)
    spring = pp.loads.SpringDamper("frame", "slide", 2e4, point1=(0.0, 0.0, 2.0))
    motion = pp.servo_cycle(press, moved.angle, speed=moved.speed, acceleration=moved.acceleration)
    torque = pp.inverse_dynamics(press, motion, [spring]).driving_torque + 7.0 * moved.acceleration + 300.0
    runs = [run(moved, torque, np.random.default_rng(0), 1.0)]
    found = identify(press, runs, friction=("crank",), drive_inertia=7.0, loads=[spring])
    for each in found.parameters:
        if each.before is not None:
            assert wide((each.low, each.high), 2.0, each.before)
    assert wide(found.intervals["crank friction"], 2.0, 300.0)


@pytest.mark.parametrize(("kind", "make"), [("cone", _in_plane), ("semidefinite", _in_space)])
def test_cones_are_those_of_real_bodies(kind, make):
    """Against the definition: a body is real where its pseudo-inertia, in the plane its determinant, is not negative."""
    rng = np.random.default_rng(2)
    for _ in range(200):
        points, weights = rng.normal(size=(5, 3)), rng.uniform(0, 1, 5)
        if kind == "cone":
            ten = np.array([weights.sum(), *(weights @ points)[:2], weights @ (points[:, :2] ** 2).sum(axis=1)])
            worse = ten * [1, 1, 1, 0.5]
            bad = worse[0] * worse[3] < worse[1] ** 2 + worse[2] ** 2
        else:
            tensor = sum(w * (p @ p * np.eye(3) - np.outer(p, p)) for w, p in zip(weights, points, strict=True))
            ten = np.array(
                [weights.sum(), *(weights @ points), *(tensor[i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)))]
            )
            worse, bad = ten - [0, 0, 0, 0, 0.9 * (tensor[0, 0] + tensor[1, 1] - tensor[2, 2]), 0, 0, 0, 0, 0], None
        matrix = make(rng.uniform(0.5, 2.0) ** np.array([0, 1, 1, 2] if kind == "cone" else [0, 1, 1, 1, *(2,) * 6]))[1]
        inside = Rows(kind, matrix, np.zeros(len(matrix)))
        assert inside.outside(matrix @ ten) <= TINY
        if bad is not None:
            assert (inside.outside(matrix @ worse) <= TINY) != bad


def test_estimates_stay_within_the_cones(capfd):
    """Where a torque asks for a rod without inertia and friction that drives; the solver says nothing of it."""
    press, moved = press_of("crank_slide"), drive(60)
    equations = inertial_equations(press)
    low = equations.values.copy()
    names = [each.name for each in equations.parameters]
    low[names.index("rod I")] *= 0.2
    columns_there = equations.coefficients(moved.angle)["torque"].columns(moved.speed, moved.acceleration)
    rng = np.random.default_rng(0)
    with pytest.warns(pp.PinpressWarning):
        found = identify(press, [run(moved, columns_there @ low - 5.0, rng, 0.5)], prior=3.0, friction=("crank",))
    assert capfd.readouterr() == ("", "")
    values = found.values
    assert values["crank friction"] >= -1e-9
    assert values["rod I"] * values["rod mass"] >= values["rod moment x"] ** 2 + values["rod moment z"] ** 2 - 1e-9


@pytest.mark.exhaustive
def test_what_cannot_be_told_is_refused_or_warned_of():
    press, moved = press_of("crank_slide"), drive(60)
    torque = inertial_equations(press).coefficients(moved.angle)["torque"].columns(moved.speed, moved.acceleration)
    values = inertial_equations(press).values
    rng = np.random.default_rng(0)
    good = run(moved, torque @ values + 20.0, rng, 2.0)
    for arguments, words in (
        ({"runs": []}, "there are no runs"),
        ({"runs": [3]}, "a run is a int"),
        ({"runs": [MeasuredRun(moved.time, moved.angle)]}, "has no torque"),
        ({"runs": [good.between(0.0, 1.0)]}, "ten strokes at three speeds"),
        ({"runs": [good, MeasuredRun(moved.time, moved.angle, current=good.torque)]}, "give torques in all runs"),
        ({"runs": [good], "prior": 20.0}, "masses that may be off by a fifth"),
        ({"runs": [good], "prior": {"flywheel": 0.1}}, "no link or parameter 'flywheel'"),
        ({"runs": [good], "friction": ("pin",)}, "did you mean 'pins'"),
        ({"runs": [good], "radii": {"X": 0.1}}, "no bearing 'X'"),
        ({"runs": [good], "known": {"slid mass": (100.0, 1.0)}}, "no parameter 'slid mass', did you mean 'slide mass'"),
        ({"runs": [good], "known": {"slide mass": (100.0, 0.0)}}, "value and standard deviation, both above 0"),
        ({"runs": [good], "known": {"slide mass": 100.0}}, "known slide mass has shape"),
    ):
        with pytest.raises(pp.PinpressError, match=words):
            identify(press, **arguments)
    even = drive(60, changing=0.0)
    steady = inertial_equations(press).coefficients(even.angle)["torque"].columns(even.speed, even.acceleration) @ values
    with pytest.warns(pp.PinpressWarning, match="all runs are at 60 r/min"):
        identify(press, [run(even, steady, rng, 2.0)], friction=())
    with pytest.warns(pp.PinpressWarning, match="1024 steps a turn"):
        identify(press, [run(moved, good.torque, rng, 0.0, 1024)], friction=("crank",))
    late = MeasuredRun(moved.time[10:], moved.angle[10:], good.torque[:-10])
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        identify(press, [late], friction=("crank",))
        identify(press, [replace(good, torque=good.torque / 1000)], friction=("crank",))
    words = " ".join(str(each.message) for each in said)
    assert "times the noise of the torque: an effect has no" in words
    assert "the torque is 0.001 times the torque of the described press: check its unit" in words
    with pytest.warns(pp.PinpressWarning, match="do not show the encoder's zero"):
        identify(press, [run(moved, good.torque, rng, 1e5)], friction=())
    with pytest.warns(pp.PinpressWarning, match="times the prior: give a larger prior"):
        identify(press, [run(moved, torque @ (2 * values) + 20.0, rng, 2.0)], prior=0.05, friction=("crank",))


@pytest.mark.exhaustive
def test_doubts_are_those_that_are_known():
    """At 1 % noise and three speeds: of zxn2 the slide is known and the rod is not; in jf75g slide and counterweight hide each other."""
    doubts = {}
    for name in ("zxn2_3000b", "jf75g_125"):
        runs = [MeasuredRun(*drive(strokes, 8.0)[:2]) for strokes in STROKES[name]]
        found = identifiability(press_of(name), runs, friction=LOSSES, cylinder=True)
        doubts[name] = {each.name: each for each in found.parameters}
        assert found.shaking_learnt > found.learnt + 4
        assert "These runs teach" in str(found)
    assert doubts["zxn2_3000b"]["slide mass"].torque == pytest.approx(0.02, abs=0.01)
    assert doubts["zxn2_3000b"]["crank I"].torque < 0.2
    assert doubts["zxn2_3000b"]["rod I"].torque > 0.98
    assert doubts["jf75g_125"]["slide mass"].torque == pytest.approx(0.86, abs=0.03)
    assert doubts["jf75g_125"]["counterweight mass"].torque == pytest.approx(0.47, abs=0.03)
    assert doubts["jf75g_125"]["slide mass"].shaking < 0.05
    plain = identifiability(press_of("zxn2_3000b"))
    assert (plain.rank, plain.columns_in_torque, plain.shaking_rank, plain.columns_in_shaking) == (10, 15, 14, 18)
    assert "These runs" not in str(plain)
    assert (plain.learnt, plain.shaking_learnt, len(plain.parameters)) == (0.0, 0.0, 0)


def test_the_spline_follows_the_angle_and_finds_its_noise():
    moved, rng = drive(60, 4.0), np.random.default_rng(0)
    noisy_angle = moved.angle + 1e-4 * rng.normal(size=len(moved.time))
    found = smoothed(MeasuredRun(moved.time, noisy_angle))
    assert found.noise == pytest.approx(1e-4, rel=0.1)
    exact = np.interp(found.angle, moved.angle, moved.speed)
    assert np.abs(found.speed - exact).max() < 0.02 * moved.speed.max()


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125"])
def test_intervals_hold_and_errors_are_those_of_the_bound(name):
    """100 presses each, and encoders that are some degrees off, drawn from the prior. Errors by the bound of Cramer and Rao
    of plain least squares; the prior makes them less."""
    rest = ("crank friction", "crank viscous friction", "gibs friction", "cylinder force", "cylinder stiffness", "encoder zero")
    equations = inertial_equations(press_of(name))
    base = base_parameters(equations)
    inside, errors = [], []
    for seed in range(100):
        runs, masses, losses, noise = noisy(name, seed)
        zero = np.random.default_rng(10_000 + seed).normal(scale=0.1)
        found = quietly(name, shifted(runs, zero))
        truth = np.concatenate([base.matrix @ masses, losses, [zero]])
        ends = [(each.low, each.high) for each in found.base_parameters] + [found.intervals[each] for each in rest]
        values = np.array([each.value for each in found.base_parameters] + [found.values[each] for each in rest])
        inside.append([low <= true <= high for (low, high), true in zip(ends, truth, strict=True)])
        errors.append(values - truth)
    whole = np.concatenate([columns(name, strokes, LOSSES, True) for strokes in STROKES[name]])
    first = [next(k for k, each in enumerate(equations.parameters) if words.startswith(each.name)) for words in base.names]
    chosen = np.column_stack([whole[:, [*first, *range(len(equations.parameters), whole.shape[1])]], by_angle(name)])
    sizes = np.linalg.norm(chosen, axis=0)
    _, values, rows = np.linalg.svd(chosen / sizes, full_matrices=False)
    seen = values > 1e-9 * values[0]
    told = (rows[seen] ** 2).sum(axis=0) > 1 - 1e-6  # a force of the cylinder may be a moment of the rocker
    bound = np.where(told, noise / sizes * np.sqrt(((rows[seen].T / values[seen]) ** 2).sum(axis=1)), np.inf)
    cover, ratio = np.mean(inside, axis=0), np.sqrt(np.mean(np.square(errors), axis=0)) / bound
    assert 0.93 <= cover.mean() <= 0.98
    assert cover.min() >= 0.88  # three standard deviations below 0.95
    assert ratio.max() <= 1.1


def by_angle(name):
    """How the torque of a press as described changes with the angle."""
    equations, found = inertial_equations(press_of(name)), []
    for moved in map(drive, STROKES[name]):
        ends = [equations.coefficients(moved.angle + step)["torque"].columns(moved.speed, moved.acceleration) for step in (-1e-5, 1e-5)]
        found.append((ends[1] - ends[0]) @ equations.values / 2e-5)
    return np.concatenate(found)


def quietly(name, runs):
    """One record in hundreds has residuals that look as if they scattered too much."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)
        return identify(press_of(name), runs, friction=LOSSES, cylinder=True)
