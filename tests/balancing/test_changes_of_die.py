"""Balance over several dies, strokes and speeds: against brute force, against each condition alone, and against closed forms."""

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.balancing import (
    AddedMass,
    Counterweight,
    CounterweightRegion,
    OperatingCondition,
    Range,
    balance,
    classical,
    compare_conditions,
    with_counterweights,
)

Z, X, MASS = Range("shaking_force", "z"), Range("shaking_force", "x"), AddedMass()
TORQUE = Range("driving_torque")
SPEED = 300 * pp.RPM
DIES = (0.0, 150.0, 400.0)


def with_die(press, mass):
    """The press with an upper die under its slide."""
    return with_counterweights(press, [Counterweight("slide", mass, (0.0, 0.0, -0.4))]) if mass else press


def conditions(press, dies=DIES, points=72, speed=SPEED):
    presses = [with_die(press, mass) for mass in dies]
    return [
        OperatingCondition(pp.cycle(each, speed, points=points), press=each, name=f"die of {mass:g} kg")
        for each, mass in zip(presses, dies, strict=True)
    ]


@pytest.fixture(scope="module")
def plain():
    return texts.shipped("jf75g_125_plain")


def values(press, cases, criterion, weights):
    """The criterion in every condition with counterweights, by inverse dynamics."""
    return np.array(
        [criterion.value(pp.inverse_dynamics(with_counterweights(case.press or press, weights), case.motion)) for case in cases]
    )


@pytest.mark.parametrize("shares", [None, (1.0, 2.0, 5.0)])
@pytest.mark.parametrize("criterion", [Z, X, TORQUE], ids=lambda each: each.words)
def test_the_worst_and_the_mean_are_those_of_brute_force(plain, criterion, shares):
    """One mass opposite to the crank pin; the series are linear in it, so that two of them give all on the grid."""
    cases, at = conditions(plain), (-0.12, 0.0, 0.02)
    best = balance(
        plain, cases, regions=[CounterweightRegion("crank", at=at, mass=(0, 400))], minimise=criterion, limits={X: 5e4}, shares=shares
    )
    grid, reached, wide = np.linspace(0.0, 400.0, 10_001), [], []
    for case in cases:
        pair = [with_counterweights(case.press, [Counterweight("crank", m, at)]) for m in (1.0, 101.0)]
        first, second = ([c.series(pp.inverse_dynamics(each, case.motion))[:, 0] for c in (criterion, X)] for each in pair)
        some = [a + np.multiply.outer((grid - 1.0) / 100.0, b - a) for a, b in zip(first, second, strict=True)]
        reached.append(np.ptp(some[0], axis=1))
        wide.append(np.ptp(some[1], axis=1))
    objective = np.max(reached, axis=0) if shares is None else np.array(shares) @ reached / sum(shares)
    objective = np.where(np.max(wide, axis=0) <= 5e4, objective, np.inf)
    slope = np.abs(np.diff(objective[np.isfinite(objective)])).max()  # of a step of the grid
    assert best.bound <= objective.min() * (1 + 1e-9)
    assert objective.min() - slope <= best.value <= objective.min() * (1 + 1e-6)
    after = values(plain, cases, criterion, best.counterweights)
    assert best.value == pytest.approx(after.max() if shares is None else np.array(shares) @ after / sum(shares), rel=1e-8)


def test_a_compromise_on_two_links_is_that_of_brute_force(plain):
    """Two masses, one search in the other."""
    cases = conditions(plain, (0.0, 600.0))
    places = (("crank", (-0.15, 0.0, 0.0)), ("main_rod", (-0.1, 0.0, 0.0)))
    regions = [CounterweightRegion(link, at=at, mass=(0, 300)) for link, at in places]
    weights = {Z: 1.0, X: 0.8}
    best = balance(plain, cases, regions=regions, minimise=weights)
    series = {}
    for number, case in enumerate(cases):
        for criterion in weights:
            own = [criterion.series(pp.inverse_dynamics(case.press or plain, case.motion))[:, 0]]
            for link, at in places:
                changed = with_counterweights(case.press, [Counterweight(link, 100.0, at)])
                own.append((criterion.series(pp.inverse_dynamics(changed, case.motion))[:, 0] - own[0]) / 100.0)
            series[number, criterion] = own
    size = {c: max(np.ptp(series[number, c][0]) for number in range(2)) for c in weights}

    def objective(first, second):
        total = 0.0
        for criterion, weight in weights.items():
            each = [s[0] + first * s[1] + second * s[2] for s in (series[k, criterion] for k in (0, 1))]
            total += weight * max(map(np.ptp, each)) / size[criterion]
        return total

    found = least(lambda first: least(lambda second: objective(first, second)))
    assert best.value == pytest.approx(found, rel=1e-6)
    assert best.bound <= found * (1 + 1e-9)


def least(convex):
    """The minimum of a convex function of a mass from 0 to 300 kg, by the golden section."""
    low, high, section = 0.0, 300.0, (5**0.5 - 1) / 2
    middle = [high - section * (high - low), low + section * (high - low)]
    values = [convex(each) for each in middle]
    for _ in range(40):
        if values[0] <= values[1]:
            high, middle[1], values[1] = middle[1], middle[0], values[0]
            middle[0] = high - section * (high - low)
            values[0] = convex(middle[0])
        else:
            low, middle[0], values[0] = middle[0], middle[1], values[1]
            middle[1] = low + section * (high - low)
            values[1] = convex(middle[1])
    return min(values)


@pytest.mark.parametrize(
    "region",
    [
        CounterweightRegion("crank", at=(-0.15, 0, 0), mass=(0, 500), reset="mass"),
        CounterweightRegion("crank", radius=0.15, mass=(200, 200), reset="position"),
        CounterweightRegion("crank", corners=((0, 0, 0), (-0.2, 0, 0)), mass=(150, 150), reset="position"),
    ],
    ids=["mass", "position in a circle", "position on a slot"],
)
@pytest.mark.parametrize("criterion", [Z, TORQUE], ids=lambda each: each.words)
def test_what_is_set_anew_is_the_optimum_of_each_condition(plain, region, criterion):
    cases = conditions(plain)
    anew = balance(plain, cases, regions=[region], minimise=criterion)
    alone = [balance(plain, [case], regions=[region], minimise=criterion).value for case in cases]
    assert anew.value == pytest.approx(max(alone), rel=1e-7)
    np.testing.assert_allclose([each.after for each in anew.changes if each.criterion == criterion], alone, rtol=1e-6)
    compromise = compare_conditions(plain, cases, regions=[region], minimise=criterion)
    assert (compromise.names[0], *compromise.names[-2:]) == ("none", "compromise", "set anew")
    np.testing.assert_allclose(compromise.values[1:4].diagonal(), alone, rtol=1e-7)
    worst = compromise.values.max(axis=1)
    assert worst[-1] * (1 - 1e-9) <= worst[-2] <= min(worst[1:-2]) * (1 + 1e-9)
    assert worst[-2] < worst[0]


def test_a_mass_that_only_moves_stays(plain):
    region = CounterweightRegion("crank", radius=0.15, mass=(0, 500), reset="position")
    best = balance(plain, conditions(plain), regions=[region], minimise=Z, limits={X: 4.5e4})
    (first,), (second,), (third,) = best.settings
    assert first.mass == pytest.approx(second.mass, rel=1e-8)
    assert first.mass == pytest.approx(third.mass, rel=1e-8)
    assert best.added_mass == pytest.approx(first.mass, rel=1e-12)
    for case, weights, press in zip(best.conditions, best.settings, best.presses, strict=True):
        again = with_counterweights(case.press or plain, weights)
        assert Z.value(pp.inverse_dynamics(again, case.motion)) == pytest.approx(Z.value(pp.inverse_dynamics(press, case.motion)), rel=1e-9)
    text = str(best)
    assert all(f"{name}" in text for name in ("  die of 0 kg    300 r/min of joint", "The worst operating condition counts."))


def test_an_opposed_counterweight_follows_the_die(plain):
    """Zhang 2007, 3.5: m6 r2 = (m5 + m7) r1 at equal ratios; a die of m7 asks for m7 r1 / r2 more, and then nothing shakes."""
    opposed = classical.with_opposed_balancer(plain, 0.0297)
    heavier = CounterweightRegion("counterweight", at=(0, 0, 0), reset="mass")
    size = Z.value(pp.inverse_dynamics(plain, pp.cycle(plain, SPEED, points=72)))
    best = balance(opposed, conditions(opposed), regions=[heavier], minimise=MASS, limits={Z: 0.0})
    found = [sum(weight.mass for weight in weights) for weights in best.settings]
    np.testing.assert_allclose(found, np.array(DIES) * 0.015 / 0.0297, rtol=1e-9, atol=1e-6)
    assert best.added_mass == pytest.approx(400 * 0.015 / 0.0297, rel=1e-9)
    for press in best.presses:
        force = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=72)).shaking_force
        assert np.ptp(force, axis=0).max() < 1e-9 * size


def test_strokes_are_presses_of_their_own():
    """A table with another crank radius: the counterweight on the crank is the same body in both, and its optimum that of brute force."""
    presses = [pp.build(**crank_slide(radius)) for radius in (100, 60)]
    cases = [OperatingCondition(pp.cycle(each, 10.0, points=72), press=each, name=each.name) for each in presses]
    region = CounterweightRegion("crank", at=(-0.2, 0, 0), mass=(0, 200))
    best = balance(presses[0], cases, regions=[region], minimise=Z)
    masses = np.linspace(0, 200, 2001)
    both = []
    for press, case in zip(presses, cases, strict=True):
        one, two = (
            Z.series(pp.inverse_dynamics(with_counterweights(press, [Counterweight("crank", m, (-0.2, 0, 0))]), case.motion))
            for m in (1.0, 2.0)
        )
        both.append(np.ptp(one + (masses - 1.0) * (two - one), axis=0))
    found = np.max(both, axis=0)
    assert found.min() - np.abs(np.diff(found)).max() <= best.value <= found.min() * (1 + 1e-9)


def crank_slide(radius):
    return {
        "press": f"stroke_{2 * radius}",
        "units": "mm",
        "frame": "O",
        "pins": {"O": [0, 0], "P": {"from": "O", "length": radius, "angle": -90}, "W": {"P": 400, "x": 0, "side": "down"}},
        "links": {
            "crank": {"pins": "O P", "mass": 20, "com": [30, 0], "inertia": 0.1},
            "rod": {"pins": "P W", "mass": 15},
            "slide": {"pins": "W", "guide": "up", "mass": 100},
        },
        "drive": "O",
    }


def test_one_condition_is_the_press_with_its_die(plain):
    """A die in the condition, or in the press itself."""
    die = with_die(plain, 300.0)
    region = CounterweightRegion("crank", radius=0.2)
    motion = pp.cycle(die, SPEED, points=72)
    own = balance(die, motion, regions=[region], minimise={Z: 1.0, X: 1.0})
    other = balance(plain, [OperatingCondition(motion, press=die)], regions=[region], minimise={Z: 1.0, X: 1.0})
    assert own.value == pytest.approx(other.value, rel=1e-9)
    assert other.press.model.inertias[3].mass == pytest.approx(2200.0)
    assert other.presses[0].model.inertias[3].mass == pytest.approx(2500.0)


def test_a_comparison_is_a_table(plain, tmp_path):
    regions = [CounterweightRegion("crank", radius=0.15, mass=(0, 300))]
    found = compare_conditions(plain, conditions(plain, (0.0, 400.0)), regions=regions, minimise=Z)
    assert found.names == ("none", "best for die of 0 kg", "best for die of 400 kg", "compromise")
    columns = found.columns()
    assert list(columns) == ["design", "die of 0 kg [N]", "die of 400 kg [N]", "worst [N]", "added mass [kg]"]
    assert columns["added mass [kg]"][0] == 0.0
    np.testing.assert_allclose(columns["worst [N]"], found.values.max(axis=1))
    for design, row in zip(found.designs, found.values[1:], strict=True):
        np.testing.assert_allclose(values(plain, design.conditions, Z, design.counterweights), row, rtol=1e-9)
