"""Cam tables: errors between their points against independent numbers, points of laws with corners, files that controllers read."""

import dataclasses

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import pinpress as pp
from pinpress.common.numerics import quintics
from pinpress.jobs.job import results_of
from pinpress.servo.cam_tables import LAYOUTS, SAMPLES, largest_error, points_of
from pinpress.servo.state_curve import state_curve

PERIOD = 2 * np.pi
DRIVE = pp.servo.ServoDrive(inertia=1.0, ratio=5.0)
# steps: errors of lines, cubics and quintics between the points, sampled at 200 places a step by a NumPy script of its own
SINE = {
    8: (0.0112008, 1.44228e-4, 7.428e-7),
    36: (6.03328e-4, 3.82932e-7, 9.72162e-11),
    72: (1.51336e-4, 2.4011e-8, 1.52385e-12),
    360: (6.0599e-6, 3.8457e-11, None),
}
SLIDE = {  # of crank_slide [um]
    8: (8362.79, 158.915, 1.85903),
    36: (472.669, 0.467685, 3.15855e-4),
    72: (118.785, 0.0294308, 5.0e-6),
    360: (4.75932, 4.719e-5, None),
}


def errors(curve, steps):
    points = points_of(curve, steps, True)
    places = points.master[:-1] + np.linspace(0, 1, SAMPLES + 1)[:, None] * np.diff(points.master)
    cubic = CubicHermiteSpline(points.master, points.slave, points.velocity)(places) - curve.at(places.ravel())[0].reshape(places.shape)
    linear, quintic = (largest_error(curve, points, name, True)[0] for name in ("linear", "quintic"))
    return linear, np.abs(cubic).max(), quintic


def heights(angle, r=0.1, rod=0.4):
    """Position of crank_slide's slide and its derivatives by the crank angle, in closed form."""
    root = np.sqrt(rod**2 - (r * np.sin(angle)) ** 2)
    first = -r * np.sin(angle) + r**2 * np.sin(2 * angle) / (2 * root)
    second = -r * np.cos(angle) + r**2 * np.cos(2 * angle) / root + r**4 * np.sin(2 * angle) ** 2 / (4 * root**3)
    return r * np.cos(angle) - root, first, second


@pytest.mark.parametrize(("reference", "digits"), [(SINE, 5e-6), (SLIDE, 5e-6)], ids=["sine", "slide"])
def test_errors_between_points_are_those_of_an_independent_script(reference, digits):
    share = np.linspace(0.0, 1.0, 2001)
    if reference is SINE:
        wave = 2 * np.pi * share
        sine = share - np.sin(wave) / PERIOD, (1 - np.cos(wave)) / 360, PERIOD / 360**2 * np.sin(wave)
        curve, scale = state_curve(360 * share, *sine), 1.0
    else:
        value, first, second = heights(PERIOD * share)
        curve, scale = state_curve(360 * share, value, first * PERIOD / 360, second * (PERIOD / 360) ** 2), 1e6
    for steps, printed in reference.items():
        for found, known in zip(errors(curve, steps), printed, strict=True):
            rounding = 2e-14 if reference is SINE else 5e-9  # of a double; 5.0e-6 um has two digits
            assert known is None or scale * found == pytest.approx(known, rel=digits, abs=max(rounding, 0.6 * 10.0 ** _last_digit(known)))


def _last_digit(number):
    """Exponent of the last printed digit."""
    mantissa, _, exponent = f"{number!r}".partition("e")
    return int(exponent or 0) - len(mantissa.partition(".")[2])


def test_first_quintic_of_a_table_with_eight_steps():
    ends = PERIOD / 8 * np.arange(2)
    coefficients = quintics(np.diff(ends), *heights(ends))[:, 0]
    known = [-0.3, 0, -0.0375, 0.000127529795076, -0.000302286734375, 0.000653866842532]
    assert coefficients == pytest.approx(known, abs=6e-16)
    assert np.polynomial.polynomial.polyval(PERIOD / 16, coefficients) == pytest.approx(-0.305776330623, abs=6e-13)
    assert heights(PERIOD / 16)[0] == pytest.approx(-0.30577725606, abs=6e-12)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_fewest_points_that_keep_the_tolerance_are_heights_of_the_slide(layout):
    press = pp.load("crank_slide")
    table = pp.servo.cam_table(press, pp.cycle(press, speed=PERIOD), layout=layout, tolerance=1e-5)
    exact = heights(np.radians(table.master) + np.pi)  # drawn at bottom dead centre
    assert table.slave == pytest.approx(1e3 * (exact[0] + 0.5), abs=1e-7)
    assert table.velocity == pytest.approx(1e3 * np.radians(1) * exact[1], abs=1e-9)
    assert table.acceleration == pytest.approx(1e3 * np.radians(1) ** 2 * exact[2], abs=1e-9)
    assert table.closed
    assert table.advance == 0
    assert table.error <= 1e-2
    angle = np.linspace(0, PERIOD, 1001)
    curve = state_curve(np.degrees(angle), *(1e3 * np.radians(1) ** order * each for order, each in enumerate(heights(angle + np.pi))))
    fewer = points_of(curve, len(table.master) - 2, True)
    assert largest_error(curve, fewer, table.interpolation, True)[0] > 1e-2


def test_files_for_controllers(tmp_path):
    press = pp.load("crank_slide")
    motion = pp.cycle(press, speed=PERIOD)
    written = {}
    for layout in LAYOUTS:
        table = pp.servo.cam_table(press, motion, layout=layout, tolerance=1e-4)
        paths = table.write(tmp_path / f"{layout}.txt")
        content = paths[0].read_bytes()
        assert content.count(b"\n") == content.count(b"\r\n") > 4
        assert b"," not in content.split(b"\r\n")[-2]
        written[layout] = table, content.decode().splitlines()
        head = paths[-1].read_text() if len(paths) == 2 else content.decode()
        said = ("press: crank_slide", "SHA-256 of the URDF", "0 to 360 deg in 1 s", "[mm/deg2]", "largest error", table.interpolation)
        assert [words for words in said if words not in head] == []
    table, lines = written["xyva"]
    assert np.loadtxt(lines) == pytest.approx(np.column_stack(list(table.columns().values())), abs=1e-10)
    table, lines = written["pairs"]
    assert np.loadtxt(lines) == pytest.approx(np.column_stack([table.master, table.slave]), abs=1e-10)
    table, lines = written["sew"]
    assert int(lines[0]) == len(lines) - 1 == len(table.master)
    assert lines[1] == "0.0000000000;0.0000000000"
    table, lines = written["lenze"]
    assert [line.split()[:2] for line in lines] == [line.split(";")[:2] for line in written["sew"][1][1:]]
    table, lines = written["kas"]
    assert (lines[0], lines[1], lines[-1]) == ("CYCLIC;YES;", "TABLE_BEGIN;;", "TABLE_END;;")
    assert len(lines) - 4 >= 4
    assert lines[-2] == f"360.0000000000;{table.slave[0]:.10f};SPLINE"


@pytest.mark.parametrize("sense", [1, -1])
def test_angles_go_on_beyond_a_turn_and_below_zero(sense):
    press = pp.load("crank_slide")
    table = pp.servo.cam_table(press, pp.cycle(press, speed=sense * 7.0), of="angle")
    assert list(table.slave) == [0, sense * 360]
    assert list(table.velocity) == [sense, sense]
    assert table.period == pytest.approx(PERIOD / 7.0)
    assert f"{sense * 360:+d} deg on; make the slave modulo 360 deg" in " ".join(table.head)


def test_laws_have_points_at_their_corners_and_accelerations_of_both_sides():
    press = pp.load("crank_slide")
    law = pp.servo.motion_by_law(press, DRIVE, "3-4-5", time=1.0, path=pp.servo.Stop(bottom=0.2))
    table = pp.servo.cam_table(press, law, of="angle", tolerance=1e-5)
    pauses = np.flatnonzero(np.diff(law.angle) == 0)
    ends = 360 / law.duration * (law.time[[pauses[0], pauses[-1] + 1]] - law.time[0])
    assert table.corners >= 1
    assert np.abs(table.master[:, None] - ends).min(axis=0).max() < 1e-6
    exact = state_curve(law.time - law.time[0], np.degrees(law.angle), np.degrees(law.speed), np.degrees(law.acceleration))
    drawn = np.linspace(0, 360, 4001)
    h = np.diff(table.master)
    step = np.clip(np.searchsorted(table.master, drawn, side="right") - 1, 0, len(h) - 1)
    c = quintics(h, table.slave, table.velocity, table.acceleration)[:, step]
    curve = np.polynomial.polynomial.polyval(drawn - table.master[step], c, tensor=False)
    assert np.abs(curve - exact.at(drawn / 360 * law.duration)[0]).max() <= np.degrees(1e-5)
    jerky = pp.servo.motion_by_law(press, DRIVE, "modified trapezoid", time=1.0, path=pp.servo.Stop())
    assert pp.servo.cam_table(press, jerky, of="height").error <= 1e-3


def test_motions_in_time_close_by_their_period_or_run_once():
    press = pp.load("crank_slide")
    time = np.arange(240) / 240
    swing = 0.3 * np.sin(2 * np.pi * time)
    rates = {"speed": 0.6 * np.pi * np.cos(2 * np.pi * time), "acceleration": -1.2 * np.pi**2 * np.sin(2 * np.pi * time)}
    motion = pp.servo_cycle(press, swing, **rates, time=time, period=1.0)
    table = pp.servo.cam_table(press, motion, of="angle", period=1.0, tolerance=1e-5)
    assert table.closed
    assert table.advance == 0
    assert table.slave == pytest.approx(np.degrees(0.3) * np.sin(np.radians(table.master)), abs=1e-6)
    once = pp.servo.cam_table(press, motion, of="angle", tolerance=1e-5)
    assert not once.closed
    assert once.period == pytest.approx(239 / 240)
    assert "run the table once" in " ".join(once.head)


def test_a_table_in_a_job_is_that_of_its_motion():
    job = pp.job("crank_slide", speed=PERIOD, cam_table={"height": 1e-5, "angle": 1e-4, "layout": "pairs"})
    by_library = pp.servo.cam_table(job.press, job.motion(), layout="pairs", tolerance=1e-5)
    assert [table.of for table in job.cam_tables()] == ["height", "angle"]
    assert np.array_equal(job.cam_tables()[0].slave, by_library.slave)
    assert [type(each).__name__ for each in results_of(job)] == ["CamPoints", "CamPoints"]
    with pytest.raises(pp.PinpressError, match="neither height nor angle; write height: 1 um"):
        job.with_(**{"cam_table.height": None, "cam_table.angle": None}).cam_tables()


def of_press(**options):
    press = pp.load("crank_slide")
    return pp.servo.cam_table(press, pp.cycle(press, **{"speed": PERIOD, **options.pop("motion", {})}), **options)


REFUSALS = [
    (lambda: of_press(of="depth"), "give 'angle' or 'height'"),
    (lambda: of_press(layout="xyv"), "layout is 'xyv', did you mean 'xyva'"),
    (lambda: of_press(layout="pairs", tolerance=1e-9), "5000 steps with linear interpolation have an error of"),
    (lambda: of_press(motion={"points": 12}), "the states of the motion do not resolve its height"),
    (lambda: of_press(of="angle", layout="kas", motion={"speed": -PERIOD}), "turn the crank forwards"),
    (lambda: of_press(period=0.5), "the motion takes 0.99"),
    (lambda: of_press(tolerance=0.0), "tolerance is 0"),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message for _, message in REFUSALS])
def test_refused(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()


def test_result_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        of_press().error = 0.0
