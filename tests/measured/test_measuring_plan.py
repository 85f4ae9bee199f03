"""Plans of measuring: what motions tell, against least squares of their samples, and shares of the time against any others."""

from functools import cache

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress import RPM, PinpressError, PinpressWarning
from pinpress.measured import measuring_motions, plan
from pinpress.measured.regressor import inertial_equations, loss_columns

PRESS = "zxn2_3000b"
WANTED = ["crank friction", "crank viscous friction", "gibs friction", "cylinder stiffness", "crank I", "slide mass"]
EXPECTED = {
    "crank friction": 1500.0,
    "crank viscous friction": 200.0,
    "gibs friction": 5000.0,
    "cylinder force": 8e4,
    "cylinder stiffness": 5e4,
}


@cache
def motions():
    return dict(measuring_motions(shipped(PRESS), [30 * RPM, 50 * RPM, 70 * RPM], strokes=(1.0, 2.6)))


def planned(names, **more):
    return plan(
        shipped(PRESS), {name: motions()[name] for name in names}, noise=1380.0, cylinder=True, expected=EXPECTED, wanted=WANTED, **more
    )


def columns(angle, speed, acceleration):
    """(n, p) of the torque by masses, inertias and losses, and last by the encoder's zero: how it falls as the angle grows."""
    press, values = shipped(PRESS), np.array([*inertial_equations(shipped(PRESS)).values, *EXPECTED.values()])

    def at(angles):
        inertial = inertial_equations(press).coefficients(angles)["torque"].columns(speed, acceleration)
        return np.hstack([inertial, loss_columns(press, angles, speed, acceleration, ("crank", "gibs"), True)])

    return np.column_stack([at(angle), (at(angle - 1e-5) - at(angle + 1e-5)) @ values / 2e-5])


@cache
def before():
    """(p, p) information before: of each link a fifth of mass, radius of gyration and inertia about the centre of mass, of losses twice
    what is expected, of the zero 0.1 rad."""
    values, covariance = inertial_equations(shipped(PRESS)).values, np.zeros((26, 26))
    for k in range(0, 20, 4):
        mass, x, z = values[k], values[k + 1] / values[k], values[k + 2] / values[k]
        central = values[k + 3] - mass * (x**2 + z**2)
        change = np.array([[1, 0, 0, 0], [x, mass, 0, 0], [z, 0, mass, 0], [x**2 + z**2, 2 * mass * x, 2 * mass * z, 1]])
        sizes = 0.2 * np.array([mass, np.sqrt(central / mass), np.sqrt(central / mass), central])
        covariance[k : k + 4, k : k + 4] = change @ np.diag(sizes**2) @ change.T
    covariance[20:, 20:] = np.diag([*(2 * each for each in EXPECTED.values()), 0.1]) ** 2
    return np.linalg.inv(covariance)


def test_deviations_are_those_of_least_squares():
    """A record of 26 strokes at 500 Hz, sampled anew: rows of the samples beside those of the prior."""
    speed, swing = 50 * RPM, 50 * RPM / 2.6
    seconds = 26 * 2 * np.pi / speed
    time = np.arange(round(500 * seconds)) / 500
    angle = speed * time - 0.3 * speed / swing * (np.cos(swing * time) - 1)
    rows = columns(angle, speed * (1 + 0.3 * np.sin(swing * time)), 0.3 * speed * swing * np.cos(swing * time)) / 1380.0
    covariance = np.linalg.inv(rows.T @ rows + before())
    names = [each.name for each in inertial_equations(shipped(PRESS)).parameters] + list(EXPECTED)
    found = planned(["50 r/min ±30 % in 2.6 strokes"], time=seconds)
    np.testing.assert_allclose(found.deviation, [np.sqrt(covariance[k, k]) for k in map(names.index, WANTED)], rtol=0.01)


def test_plans_promise_what_identify_then_finds():
    """A record of the motion that is planned: the deviations of what is found in it."""
    press, rng = shipped(PRESS), np.random.default_rng(1)
    name, seconds = "50 r/min ±30 % in 2.6 strokes", 26 * 60 / 50
    motion = measuring_motions(press, [50 * RPM])[name]
    time = np.arange(round(500 * seconds)) / 500
    swing = 50 * RPM / 2.6
    angle = 50 * RPM * (time - 0.3 / swing * (np.cos(swing * time) - 1))
    state = angle, 50 * RPM * (1 + 0.3 * np.sin(swing * time)), 50 * RPM * 0.3 * swing * np.cos(swing * time)
    truth = [*inertial_equations(press).values, *EXPECTED.values()]
    torque = columns(*state)[:, :-1] @ truth + 1380.0 * rng.normal(size=len(time))
    found = pp.measured.identify(press, [pp.measured.MeasuredRun(time, angle, torque)], friction=("crank", "gibs"), cylinder=True)
    deviations = {each.name: each.posterior for each in found.parameters}
    promised = plan(press, {name: motion}, noise=1380.0, time=seconds, cylinder=True, expected=EXPECTED, wanted=["slide mass", "crank I"])
    np.testing.assert_allclose(promised.deviation, [deviations["slide mass"], deviations["crank I"]], rtol=0.1)


def test_what_was_weighed_need_not_be_measured():
    wanted = ["slide mass", "cylinder stiffness"]
    known = {"slide mass": (shipped(PRESS).model.inertias[5].mass, 5.0)}
    plain, weighed = (
        plan(shipped(PRESS), motions(), noise=1380.0, cylinder=True, expected=EXPECTED, wanted=wanted, known=each) for each in ({}, known)
    )
    assert weighed.deviation[0] == pytest.approx(5.0, rel=0.01)
    assert weighed.deviation[1] < plain.deviation[1]


def small():
    return shipped("crank_slide"), {"even": pp.cycle(shipped("crank_slide"), 7.0, points=24)}


def test_what_single_motions_leave_unknown():
    """One speed tells neither kind of friction from the other, nor does one that swings with the stroke; a period of 2.6 strokes does."""
    with pytest.warns(PinpressWarning, match="crank friction, crank viscous friction: these motions do not determine it"):
        even = planned(["70 r/min"])
    assert even.worst > 2.0
    assert even.unknown[0] == ("crank friction", "crank viscous friction")
    assert "at one speed viscous and constant friction" in str(even)
    with pytest.warns(PinpressWarning, match="do not determine it"):
        in_step = planned(["50 r/min ±30 % in 1 strokes"])
    assert in_step.worst == pytest.approx(1.77, abs=0.02)
    assert "in step with the stroke" in in_step.why[0]
    free = planned(["50 r/min ±30 % in 2.6 strokes"])
    assert free.worst == pytest.approx(0.2445, abs=0.005)
    assert free.unknown == ((),)
    assert free.why == ("",)


@pytest.mark.exhaustive
def test_shares_are_the_best_there_are():
    """No other shares, drawn at random, make the sum of squares of relative deviations less than the proof allows."""
    found = planned(list(motions()))
    assert found.gap < 2e-3
    assert found.share.sum() == pytest.approx(1.0)
    best = (found.interval**2).sum()
    assert best < (found.interval_alone**2).sum(axis=1).min()
    rng = np.random.default_rng(5)
    for _ in range(6):
        two = rng.choice(len(motions()), 2, replace=False)
        part = {name: motions()[name] for name in np.array(list(motions()))[two]}
        other = plan(shipped(PRESS), part, noise=1380.0, cylinder=True, expected=EXPECTED, wanted=["slide mass"])
        assert other.worst >= 0  # of two motions the best shares for another aim are shares for this one too
        pair = planned_for(other.share, list(part))
        assert pair >= best * (1 - found.gap)


def planned_for(share, names):
    """Sum of squares of intervals for given shares, from the times in which each motion is measured."""
    information = before() + sum(each * informed(name) for each, name in zip(share, names, strict=True))
    covariance = np.linalg.inv(information)
    names = [each.name for each in inertial_equations(shipped(PRESS)).parameters] + list(EXPECTED)
    places = [names.index(name) for name in WANTED]
    true = np.array([*(each.size for each in inertial_equations(shipped(PRESS)).parameters), *EXPECTED.values()])
    return float((1.96**2 * np.diag(covariance)[places] / true[places] ** 2).sum())


@cache
def informed(name):
    """(p, p) information of 24 s of a motion at 500 Hz."""
    motion = motions()[name]
    rows = columns(motion.crank_angle, motion.crank_speed, motion.crank_acceleration)
    return 24 * 500 / 1380.0**2 * rows.T @ rows / len(rows)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: measuring_motions(shipped(PRESS), [-3.0]), "give positive speeds"),
        (lambda: measuring_motions(shipped(PRESS), [3.0], swing=1.0), "swing is 1"),
        (lambda: plan(shipped(PRESS), {}, noise=1.0), "motions is {}"),
        (lambda: plan(shipped("crank_slide"), motions(), noise=1.0), "belongs to zxn2_3000b, not to crank_slide"),
        (lambda: planned(["70 r/min"], time=0.0), "time is 0.0"),
        (lambda: plan(*small(), noise=1.0, expected={"cranck friction": 3.0}), "no loss 'cranck friction', did you mean"),
        (lambda: plan(*small(), noise=1.0, wanted=[]), "wanted is empty"),
        (lambda: plan(*small(), noise=1.0, wanted=["slid mass"]), "no parameter 'slid mass'"),
    ],
)
def test_plans_that_make_no_sense_are_named(make, says):
    with pytest.raises(PinpressError, match=says):
        make()


def test_motions_are_named_and_swing():
    found = measuring_motions(shipped(PRESS), [5.0], swing=0.2, strokes=(2.6, 3.4))
    assert list(found) == ["47.75 r/min", "47.75 r/min ±20 % in 2.6 strokes", "47.75 r/min ±20 % in 3.4 strokes"]
    for name, motion in found.items():
        assert np.ptp(motion.crank_speed) == pytest.approx(0.0 if "±" not in name else 2.0, rel=0.01)
        np.testing.assert_allclose(np.gradient(motion.crank_angle, motion.time)[5:-5], motion.crank_speed[5:-5], rtol=2e-3)


def test_default_aims_are_what_can_be_told():
    found = plan(shipped("crank_slide"), measuring_motions(shipped("crank_slide"), [7.0], count=4), noise=5.0)
    assert {"crank friction", "crank viscous friction", "gibs friction"} <= set(found.parameters)
    assert len(found.parameters) < 12
    assert pp.measured.MeasuringPlan is type(found)
