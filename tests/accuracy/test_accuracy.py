"""What `compare` measures: errors that fall as their methods' orders say, references that are what they claim, problems said as such.

Times are not judged: they are the machine's.
"""

import csv
import dataclasses
import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest
from support import texts
from support.generators import small_linkages, spatial_linkages
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.accuracy import work_precision
from pinpress.accuracy.scenes import CLUTCH, DIE, FREE_RUN, SPEED_LAW, build_scene
from pinpress.accuracy.work_precision import INVERSE_DYNAMICS, Contestant, Errors, measure
from pinpress.cli.main import main
from pinpress.common.results import Records

SPEED = 70 * pp.RPM
PUBLISHED = Path(__file__).resolve().parents[2] / "viz" / "accuracy.csv"


@pytest.fixture(scope="module")
def alone():
    """Each piece of work is done once: no time is judged."""

    def without_clock(works, repeats, done):
        for work in works:
            work()
            for _ in range(repeats):
                done()
        return [1e-3] * len(works)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work_precision, "least_seconds", without_clock)
        yield


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module", params=rest_exhaustive(["a few settings", "all settings"], "a few settings"))
def measured(request, alone, told):
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "a few settings":
            patch.setattr(work_precision, "TOLERANCES", (1e-4, 1e-8, 1e-11, 1e-12))
            patch.setattr(work_precision, "STEPS", work_precision.STEPS[:3])
        told.clear()
        return pp.accuracy.compare(texts.shipped("zxn2_3000b"), SPEED, points=36, repeats=1, scenes=[FREE_RUN], progress=told.append)


@pytest.mark.exhaustive
def test_all_groups_are_measured(measured, told):
    assert tuple(dict.fromkeys(m.group for m in measured.measurements)) == tuple(measured.groups) == (INVERSE_DYNAMICS, FREE_RUN)
    assert all(m.seconds > 0 for m in measured.measurements)
    assert told == sorted(told)
    assert told[-1] == pytest.approx(1.0)


@pytest.mark.exhaustive
def test_references_are_certified(measured):
    """Two independent methods each: the engines, constraint and reduced dynamics."""
    bounds = {INVERSE_DYNAMICS: 1e-13, FREE_RUN: 1e-11}  # three times and more what is reached
    for group, bound in bounds.items():
        assert 0 < measured.groups[group].certificate < bound
        assert measured.groups[group].certified_by
    for m in measured.of(FREE_RUN):  # nothing is said to be known better than that
        assert m.error is None or m.error >= measured.groups[FREE_RUN].certificate


def test_inverse_dynamics(measured):
    rows = measured.of(INVERSE_DYNAMICS)
    assert [row.method for row in rows] == ["plane", "space", "pinocchio"]
    for row in rows:
        assert row.error < 1e-13
        assert row.force_error < 1e-13
        assert row.loop_gap < 1e-14
        assert row.energy_error < 1e-14
        assert row.evaluations == 36


def test_the_published_errors_are_still_so(measured):
    """Those of `viz/accuracy.csv`, of which tables and picture of docs/accuracy.md are made: within a factor of three, but for rounding."""
    with open(PUBLISHED, newline="", encoding="utf-8") as file:
        published = {(row["method"], row["setting"]): row for row in csv.DictReader(file) if row["group"] == FREE_RUN}
    rounding = {"error": 1e-11, "force_error": 1e-11}
    for m in measured.of(FREE_RUN):
        row = published[m.method, m.setting]
        for name, least in rounding.items():
            found, said = getattr(m, name), row[name]
            if found is not None and max(found, float(said)) > least:
                assert 1 / 3 < found / float(said) < 3, (m.method, m.setting, name)


def test_fixed_steps_converge_with_order_four(measured, method):
    rows = measured.of(FREE_RUN, f"{method}, Runge-Kutta 4")
    for quantity in ("error", "force_error", "energy_error"):
        errors = np.array([getattr(row, quantity) for row in rows[:3]])
        orders = np.log2(errors[:-1] / errors[1:])
        assert (orders > 3.5).all(), quantity
        assert orders.mean() < 7.0, quantity  # of `reduced` errors change their sign on the way
    assert rows[0].number == pytest.approx(2 * rows[1].number)
    assert rows[1].evaluations == pytest.approx(2 * rows[0].evaluations, rel=0.01)


def test_tolerances_are_kept(measured):
    """The error falls with the tolerance, and is at most a thousand tolerances."""
    for method in ("reduced", "constraint"):
        rows = measured.of(FREE_RUN, method)
        assert all(row.error <= max(1e3 * row.number, measured.groups[FREE_RUN].certificate) for row in rows)
    rows = measured.of(FREE_RUN, "constraint")
    assert rows[0].error > 1e4 * rows[-1].error
    assert rows[0].evaluations < rows[-1].evaluations
    assert all(row.loop_gap < 1e-14 for row in measured.of(FREE_RUN))


def test_the_default_is_as_exact_as_any(measured):
    """That it is the fastest of these too is what `pinpress accuracy` prints; a time is no thing to assert."""
    default = next(row for row in measured.of(FREE_RUN, "reduced") if row.number == 1e-11)
    others = [row for row in measured.of(FREE_RUN) if row.method.startswith("constraint")]
    assert default.error <= 2 * min(row.error for row in others)  # both are rounding
    assert default.error <= 1e-12


def test_each_tolerance_of_the_reduced_equation_holds(measured):
    """Over the crank angle the panels of the table resolve a free run to rounding, at any tolerance."""
    rows = measured.of(FREE_RUN, "reduced")
    assert rows
    for row in rows:
        assert row.error <= 0.1 * row.number + 1e-12


@pytest.mark.parametrize("tolerance", [1e-6, 1e-10])
def test_a_clutch_is_not_stiff(tolerance):
    """Implicit steps, tried where nothing is stiff, took up to twice the evaluations of the whole run."""
    press = texts.shipped("zxn2_3000b")
    scene = build_scene(press, CLUTCH, SPEED, 1360.0, 4 * math.pi / SPEED)
    run = pp.simulate(
        press,
        scene.duration,
        speed=0.0,
        angle=scene.angle,
        drive=scene.drive,
        flywheel=scene.flywheel,
        loads=scene.loads,
        clutch=scene.clutch,
        tolerance=tolerance,
    )
    assert run.stats.solvers == ("explicit",)


@pytest.mark.exhaustive
@pytest.mark.parametrize("group", [CLUTCH, DIE, SPEED_LAW])
def test_tolerances_of_scenes_at_work(alone, group):
    press = texts.shipped("zxn2_3000b")
    measured = pp.accuracy.compare(press, SPEED, points=12, repeats=1, scenes=[group])
    for row in measured.of(group):
        assert row.error is not None, (row.method, row.setting, row.problem)
        if row.setting.startswith("tolerance"):
            assert row.error <= max(1e4 * row.number, measured.groups[group].certificate), (row.method, row.setting)
    default = next(row for row in measured.of(group, "reduced") if row.number == 1e-11)
    assert default.error < 1e-10


def test_fastest(measured):
    rows = measured.fastest(FREE_RUN, 1e-6)
    assert [row.seconds for row in rows] == sorted(row.seconds for row in rows)
    assert len({row.method for row in rows}) == len(rows)
    assert all(row.error <= 1e-6 for row in rows)
    assert measured.fastest(FREE_RUN, 0.0) == ()


def test_text(measured):
    text = str(measured)
    assert all(m.method in text for m in measured.measurements)
    assert "engines plane and pinocchio agree to" in text
    assert "all joints and the reduced equation agree to" in text
    assert max(map(len, text.split("\n"))) <= 100


def test_csv_and_frame(measured, tmp_path):
    measured.to_csv(tmp_path / "accuracy.csv")
    with open(tmp_path / "accuracy.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(measured.measurements)
    for row, m in zip(rows, measured.measurements, strict=True):
        assert float(row["seconds [s]"]) == m.seconds
        assert (float(row["error"]) if row["error"] else None) == m.error
        assert row["method"] == m.method
    pytest.importorskip("pandas")
    frame = measured.to_frame()
    assert list(frame.columns) == list(measured.columns())
    assert len(frame) == len(rows)
    with pytest.raises(pp.PinpressError, match=r"accuracy\.csv"):
        measured.to_csv(tmp_path / "none" / "accuracy.csv")


@pytest.mark.exhaustive
def test_plot(measured):
    pytest.importorskip("matplotlib")
    figure = pp.accuracy.plot(measured)
    inverse, angle = figure.axes
    assert len(inverse.lines) == 3 + 1  # engines, and how closely the reference is known
    assert len(angle.lines) == len({m.method for m in measured.of(FREE_RUN)}) + 1
    constraint = measured.of(FREE_RUN, "constraint")
    assert any(np.array_equal(line.get_ydata(), [m.error for m in constraint]) for line in angle.lines)
    for axes in figure.axes:
        assert axes.get_xscale() == axes.get_yscale() == "log"
    with pytest.raises(pp.PinpressError, match="accuracy"):
        pp.accuracy.plot(None)


def test_a_problem_is_said():
    """A contestant that raises, or whose answer is not finite, is timed, and has a problem in place of an error."""

    def fails():
        raise pp.SimulationError("the press stalls: it comes to rest", 0.1, 0.2)

    entries = [
        Contestant(FREE_RUN, "raises", "", None, fails, lambda answer: Errors(0.0)),
        Contestant(FREE_RUN, "is not finite", "", None, lambda: math.nan, lambda answer: Errors(answer, math.inf, 1.0)),
        Contestant(FREE_RUN, "is right", "", None, lambda: 0.0, lambda answer: Errors(answer)),
    ]
    raised, wild, right = measure(entries, repeats=1)
    assert (raised.error, raised.problem) == (None, "the press stalls")
    assert (wild.error, wild.force_error, wild.loop_gap, wild.problem) == (None, None, 1.0, "not finite")
    assert (right.error, right.problem) == (0.0, "")
    assert min(raised.seconds, wild.seconds, right.seconds) > 0


@pytest.mark.exhaustive
def test_a_spatial_linkage(alone, tmp_path):
    """The torque gives the accelerations back under forward dynamics. Bennett's linkage has redundant rows in space."""
    file = tmp_path / "bennett.urdf"
    file.write_text(spatial_linkages.bennett(), encoding="utf-8")
    measured = pp.accuracy.compare(pp.load(file), 10.0, duration=0.05, points=12, repeats=1, scenes=[FREE_RUN, DIE])
    assert not measured.of(DIE)  # it has no slide
    assert any(line.startswith("elastic die is skipped") for line in measured.skipped)
    assert [row.method for row in measured.of(INVERSE_DYNAMICS)] == ["space", "pinocchio"]
    assert measured.groups[INVERSE_DYNAMICS].certified_by == "torque and forward dynamics under it"
    assert measured.groups[INVERSE_DYNAMICS].certificate < 1e-12
    assert measured.groups[FREE_RUN].certificate < 1e-10
    assert all(row.error < max(1e-14, row.number or 0.0) for row in measured.of(FREE_RUN, "reduced"))


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"speed": 0.0}, "speed is 0"),
        ({"speed": math.nan}, "speed"),
        ({"points": 1}, "points"),
        ({"points": 2.5}, "points"),
        ({"repeats": 0}, "repeats"),
        ({"repeats": True}, "repeats"),
        ({"scenes": ["dancing"]}, "scenes"),
        ({"scenes": FREE_RUN}, "scenes"),
        ({"duration": -1.0}, "duration"),
        ({"flywheel": 500.0}, "flywheel"),
        ({"press": "zxn2_3000b"}, "press"),
    ],
)
def test_wrong_arguments(alone, arguments, problem):
    given = {"press": texts.shipped("crank_slide"), "speed": SPEED} | arguments
    with pytest.raises(pp.PinpressError, match=problem):
        pp.accuracy.compare(**given)


def test_several_drivers():
    with pytest.raises(pp.PinpressError, match="2 drivers"):
        pp.accuracy.compare(small_linkages.two_cranks(), SPEED)


def test_measurements_are_plain_values(measured):
    for m in measured.measurements:
        for field in dataclasses.fields(m):
            assert isinstance(getattr(m, field.name), str | float | int | None), field.name


@pytest.mark.exhaustive
def test_command(alone, capsys, tmp_path):
    """What is asked for is measured and written."""
    out = tmp_path / "made" / "out"
    job = ["--speed", "-300r/min", "--set", "flywheel=2.5 kg m2", "--set", "run.duration=20ms"]
    words = ["crank_slide", *job, "--points", "12", "--repeats", "1", "--scene", "free run", "--out", str(out)]
    assert main(["accuracy", *words]) == 0
    said = capsys.readouterr().out
    assert "crank_slide: -300 r/min; runs of 0.02 s with a flywheel of 2.5 kg m2" in said
    assert "  flywheel      inertia = 2.5 kg m2\n  scenes        free run\n  computed by   pinpress " in said
    assert f"wrote {out / 'accuracy.csv'} and {out / 'accuracy.png'}" in said
    assert (out / "accuracy.png").stat().st_size > 30_000
    with open(out / "accuracy.csv", newline="", encoding="utf-8") as file:
        assert {row["group"] for row in csv.DictReader(file)} == {INVERSE_DYNAMICS, FREE_RUN}


def test_command_without_matplotlib(measured, capsys, tmp_path, monkeypatch):
    """The table is written all the same; `test_command` is the one that measures."""
    monkeypatch.setattr(work_precision, "compare", lambda *given, **named: measured)
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == "matplotlib" else find(name, *more))
    words = ["crank_slide", "--speed", "300r/min", "--points", "12", "--repeats", "1", "--out", str(tmp_path)]
    assert main(["accuracy", *words]) == 0
    assert "for pictures: pip install 'pinpress[plots]'" in capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == ["accuracy.csv"]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["zxn2", "--speed", "70r/min"], "zxn2_3000b"),
        (["zxn2_3000b", "--speed", "0"], "speed is 0"),
        (["zxn2_3000b"], "give --speed 70r/min"),
        (["zxn2_3000b", "--speed", "70r/min", "--repeats", "0"], "repeats is 0"),
        (["zxn2_3000b", "--speed", "70r/min", "--set", "flywheel=much"], "much"),
        (["zxn2_3000b", "--speed", "70r/min", "--out", __file__], "test_accuracy.py"),
    ],
)
def test_command_refuses(alone, capsys, words, says):
    assert main(["accuracy", *words]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.startswith("pinpress: ")
    assert error.count("\n") == 1


def test_a_long_problem_does_not_widen_the_table():
    """It stands at the end of its line, and the line is broken where it is too long."""
    problem = "a program does not keep this press together, whatever its step is: give a shorter step, or another program"
    rows = [
        pp.accuracy.Measurement("free run", "reduced", f"step {k} ms", k, 0.01, None if k else 1e-3, 1e-3, problem=problem[: k * 99])
        for k in (0, 1, 2)
    ]
    group = pp.accuracy.Group("", "of a run", "of its end", 0.1, "two")
    told = pp.accuracy.WorkPrecision("press", "", "", {"free run": group}, Records(pp.accuracy.Measurement, rows), ())
    lines = str(told).split("\n")
    assert max(map(len, lines)) <= 98
    assert "               time [ms]    error  force error" in lines
    assert problem in " ".join(" ".join(lines).split())
