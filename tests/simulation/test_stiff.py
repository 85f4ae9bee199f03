"""Stiff forces: the implicit method alone, which method is used, and what it costs; the scenes of the table of extremes."""

import numpy as np
import pytest
from extremes.extreme_stiff import CASES, FLYWHEEL, MECHANISM, SPEED, START, Rubbing, SpeedLaw, between, run, swung
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.drives.motors import ConstantTorque
from pinpress.loads.process import ElasticDie

SOME = {case.name: case for case in CASES}
ALWAYS = ("speed law of 1e+11 N m s", "friction of the guide sharp within 1e-09 m/s")


@pytest.mark.parametrize("name", rest_exhaustive(("undamped spring of 1e+13 N/m", *ALWAYS), *ALWAYS))
def test_the_default_method_meets_closed_forms(name):
    outcome = SOME[name].work("auto")
    assert outcome.met, outcome


# ------------------------------------------------------------------------------------------------------------------- which one is used


@pytest.mark.exhaustive
def test_what_ran_is_said():
    ordinary = run("auto")
    assert ordinary.stats.solvers == ("angle",)
    damped = run("auto", loads=[between(1e12, 1e9)])
    assert damped.stats.solvers == ("explicit", "implicit")
    assert run("implicit").stats.solvers == ("implicit",)
    assert run("auto", step=1e-2).stats.solvers == ("fixed step",)
    assert run("auto", loads=[between(1e12, 0.0)]).stats.solvers[-1] == "repetition"
    assert {r.stats.method for r in (ordinary, damped)} == {"reduced"}


@pytest.mark.exhaustive
def test_stiffness_costs_no_steps():
    """A thousand times the stiffness, hardly more steps: an explicit method would take a thousand times as many."""
    few, many = (run("auto", loads=[between(k, 1e-3 * k)]).stats.evaluations for k in (1e10, 1e13))
    assert many < 4 * few


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", ["auto", "constraint"])
@pytest.mark.parametrize("stiffness", [1e11, 1e12, 1e13])
def test_what_a_stiff_damper_has_brought_to_rest_costs_no_steps(method, stiffness):
    """All torques that are left are rounding, 1e-7 rad/s2 and more, and so are the slopes of a careless integrator."""
    found = run(method, loads=[between(stiffness, 1e-3 * stiffness)])
    assert abs(found.crank_angle[-1] - START) < 1e-6
    assert found.stats.evaluations < 6000  # 70 000 and more, or a run that is given up, with slopes over changes hidden by rounding


@pytest.mark.parametrize("spring", [None, between(1e8, 1e5)])
def test_a_stiff_speed_law_costs_runs_of_all_joints_no_steps(spring):
    """What a stiff torque does to the crank passes on to rod and slide one round of Newton's method later."""
    scene = {"drive": SpeedLaw(1e9, 5.0), "speed": 5.0, "loads": [] if spring is None else [spring]}
    ours, other = run("constraint", **scene), run("implicit", **scene)
    assert abs(ours.crank_angle[-1] - other.crank_angle[-1]) < 1e-11
    assert ours.stats.evaluations < 15_000  # 36 000, or a run that is given up, if one round has to make the error smaller


def test_an_ordinary_run_over_time_stays_explicit():
    motor = pp.drives.ServoMotor((0.0, 1.0, 2.0), (START, START + 3.0, START + 8.0), 2e4, 2e3, 1e6)
    assert run("auto", 0.0, drive=motor).stats.solvers == ("explicit",)


@pytest.mark.parametrize("method", ["implicit", "constraint"])
def test_methods_agree_on_a_law_that_is_hardly_stiff(method):
    scene = {"drive": ConstantTorque(400.0), "loads": [between(1e5, 3e3)], "points": 200}
    ours, other = run("auto", **scene), run(method, **scene)
    assert np.abs(ours.crank_angle - other.crank_angle).max() < 1e-9
    assert np.abs(ours.crank_speed - other.crank_speed).max() < 1e-7


@pytest.mark.parametrize(
    ("method", "more", "message"),
    [
        ("implicit", {"step": 1e-3}, "leave it out with method='implicit'"),
        ("explicit", {}, "'auto', 'reduced', 'implicit' or 'constraint'"),
    ],
)
def test_methods_that_cannot_be_are_refused(method, more, message):
    with pytest.raises(pp.PinpressError, match=message):
        run(method, **more)


# ---------------------------------------------------------------------------------------------------------------- swings, and standstill


@pytest.mark.exhaustive
def test_a_repeated_swing_is_a_motion_like_any_other():
    """At any time its energy is that of the start, and it goes where the method that follows each swing goes."""
    scene = {"loads": [between(1e7, 0.0)]}
    ours, other = run("auto", **scene, points=400), run("implicit", **scene, points=400)
    assert "repetition" in ours.stats.solvers
    assert "repetition" not in other.stats.solvers
    assert np.abs(ours.crank_angle - other.crank_angle).max() < 1e-8
    assert ours.stats.energy_error < 1e-8
    assert np.abs(ours.load_work - other.load_work).max() < 1e-6 * np.abs(ours.load_work).max()


def test_a_swing_under_a_steady_torque_pays_its_motor():
    """The motor's torque squared goes on summing up, though all work of a swing is given back."""
    torque = 100.0
    found = run("auto", drive=ConstantTorque(torque), loads=[between(1e10, 0.0)])
    assert "repetition" in found.stats.solvers
    assert found.motor_squared == pytest.approx(torque**2 * found.time, rel=1e-9)
    assert found.drive_work == pytest.approx(torque * (found.crank_angle - START), abs=1e-6)


@pytest.mark.parametrize("efficiency", [1.0, 0.9])
def test_a_swing_under_a_geared_torque_is_repeated_without_losses_alone(efficiency):
    drive = pp.drives.Geared(ConstantTorque(50.0), 2.0, efficiency=efficiency)
    scene = {"speed": SPEED, "angle": START, "flywheel": pp.drives.Flywheel(FLYWHEEL)}
    found = pp.simulate(MECHANISM.press(), 0.05, drive=drive, loads=[between(1e10, 0.0)], **scene)
    assert ("repetition" in found.stats.solvers) == (efficiency == 1.0)


@pytest.mark.parametrize("scene", [{"loads": [between(1e10, 1.0)]}, {"drive": Rubbing(0.0, 1e-3, 1e-6), "loads": [between(1e10, 0.0)]}])
def test_what_is_damped_ever_so_little_is_not_repeated(scene):
    found = pp.simulate(MECHANISM.press(), 0.05, speed=SPEED, angle=START, flywheel=pp.drives.Flywheel(FLYWHEEL), **scene)
    assert "repetition" not in found.stats.solvers


@pytest.mark.exhaustive
def test_friction_sharp_about_standstill_counts_at_the_start():
    """From rest the push alone accelerates the crank, until friction is whole at 1e-3 rad/s: all that follows comes earlier by that."""
    drive = Rubbing(5000.0, 3000.0, 1e-3)
    ours, other = (float(run(method, 0.0, drive=drive).crank_angle[-1]) for method in ("auto", "implicit"))
    assert abs(ours - other) < 1e-8
    assert ours - float(run("auto", 0.0, drive=ConstantTorque(2000.0)).crank_angle[-1]) > 1e-5


@pytest.mark.exhaustive
def test_the_reference_of_swings_is_right():
    """The quadrature itself, against an integration of a spring so soft that it can be followed."""
    slack = float(MECHANISM.slide(START))

    def push(t, q, w):
        return -1e7 * (float(MECHANISM.slide(q)) - slack) * float(MECHANISM.lever(q))

    assert swung(1e7, SPEED) == pytest.approx(MECHANISM.integrated(2.0, SPEED, START, FLYWHEEL, push)[0], abs=1e-8)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("start", "loads"),
    [(1.3, [between(1e6, 0.0, 1.0)]), (0.6, [ElasticDie(0.02, 1e7)])],
    ids=["a spring, over the angle", "thrown back by a die"],
)
def test_wide_swings_are_repeated_too(start, loads):
    ours, other = (
        pp.simulate(
            MECHANISM.press(), 1.0, speed=0.0, angle=start, flywheel=pp.drives.Flywheel(1.0), loads=loads, method=method, points=200
        )
        for method in ("auto", "implicit")
    )
    assert ours.stats.solvers == ("angle", "repetition")
    assert np.abs(ours.crank_angle - other.crank_angle).max() < 1e-8
