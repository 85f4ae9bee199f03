"""A caller's own drives and loads: what they depend on beyond what they declare is found and refused; what they raise, or answer that is no
number, is named with the place in the run; their warnings are the caller's."""

import dataclasses
import math
import re
import warnings
from typing import Any

import numpy as np
import pytest
from support import texts
from support.generators import large_linkages
from support.texts import without_mass

import pinpress as pp
from pinpress.loads.process import ForceInterval
from pinpress.simulation.law_trials import tried

pytestmark = pytest.mark.usefixtures("time_limit")

METHODS = ("reduced", "constraint")
START = {"speed": 8.0, "angle": 1.0, "flywheel": pp.drives.Flywheel(20.0)}


@pytest.fixture(scope="module")
def press():
    return texts.shipped("crank_slide")


@pytest.mark.parametrize("geared", [False, True])
def test_the_librarys_own_drives_are_asked_as_they_are(geared):
    kinds = {name: getattr(pp.drives, name) for name in dir(pp.drives) if name.endswith(("Motor", "Torque"))}
    made = {
        "ConstantTorque": lambda kind: kind(100.0),
        "InductionMotor": lambda kind: kind(75e3, 1485 * pp.RPM),
        "InverterMotor": lambda kind: kind(500.0, 1485 * pp.RPM, 50.0),
        "ServoMotor": lambda kind: kind([0.0, 1.0, 2.0], [0.0, 3.0, 6.0], 1e4, 10.0, 500.0),
        "SlipClutchMotor": lambda kind: kind(189.0, 1470 * pp.RPM, 1320 * pp.RPM, 900 * pp.RPM),
    }
    assert set(made) == set(kinds)
    for name, kind in kinds.items():
        drive = made[name](kind)
        drive = pp.drives.Geared(drive, 5.0) if geared else drive
        assert tried(drive, [], 1.0)[0] is drive, name
        own = type("Own", (kind,), {})  # a caller's own class, if made from one of the library's
        assert tried(made[name](own), [], 1.0)[0].part.__class__ is own


class Own:
    """A drive of torque by ``law`` (speed, angle, time, state)."""

    inertia, rated_torque, corners = 0.0, None, ()

    def __init__(self, law, timed=False, state=(), rates=lambda *_: (), **members):
        self.law, self.timed, self.state, self.rates = law, timed, state, rates
        self.__dict__.update(members)

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return self.law(speed, angle, time, state)

    motor_torque = torque

    def motor_speed(self, speed):
        return speed


class Push:
    """A load by ``law`` (height, velocity) on an interval, on the way down."""

    datum: float | None = None

    def __init__(self, law, upper=0.15, lower=0.05):
        self.law, self.upper, self.lower = law, upper, lower

    def intervals(self, downwards):
        return (ForceInterval(self.upper, self.lower, self.law),) if downwards else ()


class Hysteresis:
    """On until 9 rad/s, then off until 7 rad/s."""

    def __init__(self):
        self.on = True

    def __call__(self, speed, *_):
        if np.ndim(speed):
            return np.array([self(w) for w in np.ravel(speed)]).reshape(np.shape(speed))
        self.on = speed < 9.0 if self.on else speed < 7.0
        return 300.0 if self.on else 0.0


class Count:
    def __init__(self):
        self.calls = 0

    def __call__(self, *at):
        self.calls += 1
        return 1.0 + self.calls + 0.0 * at[0]


# ------------------------------------------------------------------------------------------------------------------- what is not declared

DEPENDS = {
    "angle": (lambda w, a, t, s: 100.0 * np.sin(a) - w, "depends on the angle"),
    "time": (lambda w, a, t, s: 100.0 * np.cos(5.0 * t) - w, "depends on the time"),
    "time, late": (lambda w, a, t, s: np.where(np.asarray(t) > 1.5, 100.0, 0.0) - w, "depends on the time"),
    "what was before": (Hysteresis(), "depends on what it was asked before"),
    "number of calls": (Count(), "depends on what it was asked before"),
    "the whole array": (lambda w, a, t, s: np.max(w) + 0.0 * w, "array differs"),
}


@pytest.mark.parametrize("name", DEPENDS)
def test_a_drive_that_depends_on_more_than_it_declares(press, method, name):
    law, problem = DEPENDS[name]
    for drive in (Own(law), pp.drives.Geared(Own(law), 2.0)):
        with pytest.raises(pp.PinpressError, match=rf"(Own|Geared): torque.*{problem}"):
            pp.simulate(press, 0.2, drive=drive, method=method, **START)


@pytest.mark.parametrize(
    ("drive", "problem"),
    [
        (
            Own(lambda w, a, t, s: -w, motor_torque=lambda w, a=0.0, t=0.0, s=(): np.sin(a) - w),
            "motor_torque depends on the angle.*let timed be True",
        ),
        (Own(lambda w, a, t, s: -w, timed=True, corners=(3.0,)), "corners is"),
        # three torques of one speed are no scenarios where the class does not say so
        (Own(lambda w, a, t, s: np.array([1.0, 2.0, 3.0]) + 0.0 * w), r"Own: torque.*has shape \(3,\)"),
        *((Own(lambda w, a, t, s: -10.0 * w, corners=corners), "Own: corners") for corners in (("a",), (None,), 3.0)),
    ],
    ids=["motor", "timed", "scenarios", "text", "None", "number"],
)
def test_drives_that_declare_too_little_are_refused(press, drive, problem):
    with pytest.raises(pp.PinpressError, match=problem):
        pp.simulate(press, 0.2, drive=drive, **START)


def test_a_drive_that_depends_on_the_speed_though_it_is_declared_not_to(press):
    with pytest.raises(pp.PinpressError, match=r"Own: torque depends on the speed; let heeds_speed be True"):
        pp.simulate(press, 0.2, drive=Own(lambda w, a, t, s: 50.0 - w, heeds_speed=False), **START)
    swinging = Own(lambda w, a, t, s: 0.0 * w, heeds_speed=False)
    assert "repetition" in pp.simulate(press, 40.0, angle=2.0, drive=swinging, loads=[Stop(1e5)], points=11).stats.solvers


def test_what_depends_and_says_so_is_the_same_for_both_methods(press):
    """The angle's torque has a potential, so that the energy tells what the speed must be."""
    drive = Own(lambda w, a, t, s: 100.0 * math.sin(a), timed=True)
    runs = [pp.simulate(press, 0.6, drive=drive, method=method, **START) for method in METHODS]
    assert abs(runs[0].crank_angle[-1] - runs[1].crank_angle[-1]) < 1e-8
    for run in runs:
        np.testing.assert_allclose(run.drive_work, 100.0 * (np.cos(1.0) - np.cos(run.crank_angle)), rtol=0, atol=1e-7)


def test_memory_that_is_not_declared_of_a_drive_that_is_timed(press, method):
    with pytest.raises(pp.PinpressError, match=r"Own: torque depends on what it was asked before.*state"):
        pp.simulate(press, 0.2, drive=Own(Hysteresis(), timed=True), method=method, **START)
    count = Count()
    counted = Own(lambda w, a, t, s: s[0], timed=True, state=(1.0,), rates=lambda *at: (count(*at),))
    with pytest.raises(pp.PinpressError, match=r"Own: rates depends on what it was asked before"):
        pp.simulate(press, 0.2, drive=counted, method=method, **START)


def test_a_dependence_that_shows_only_in_the_run(press, method):
    """At the angles between 1.3 and 1.4 alone, where no trial is made: the run's own states tell."""
    drive = Own(lambda w, a, t, s: 100.0 * ((np.asarray(a) > 1.3) & (np.asarray(a) < 1.4)) + 0.0 * w)
    with pytest.raises(pp.PinpressError, match=r"Own: torque depends on more than the speed.*timed"):
        pp.simulate(press, 0.2, drive=drive, method=method, **START)


def test_one_of_several_drives(tmp_path):
    file = tmp_path / "discs.urdf"
    file.write_text(TWO_DISCS, encoding="utf-8")
    several = pp.load(file, driver=("P", "Q"))
    drive = {"Q": Own(lambda w, a, t, s: 10.0 * np.sin(a))}
    with pytest.raises(pp.PinpressError, match=r"Own: torque depends on the angle"):
        pp.simulate(several, 0.1, speed=(1.0, 2.0), drive=drive, method="constraint")


TWO_DISCS = """<robot name="discs"><link name="frame"/>{}</robot>""".format(
    "".join(
        f"""<link name="{link}"><inertial><mass value="4"/><inertia ixx="2" ixy="0" ixz="0" iyy="3" iyz="0" izz="2"/></inertial></link>
        <joint name="{joint}" type="continuous"><parent link="frame"/><child link="{link}"/><axis xyz="0 -1 0"/></joint>"""
        for link, joint in (("p", "P"), ("q", "Q"))
    )
)


LOADS = {
    "calls": (Push(Count()), "Push: force.*depends on what it was asked before"),
    "the whole array": (Push(lambda h, v: np.max(h) + 0.0 * h), "Push: force.*array differs"),
    "calls in time": (pp.loads.TimeForce(Count()), "TimeForce: force"),
    "the whole array in time": (pp.loads.TimeForce(lambda t: np.max(t) + 0.0 * np.asarray(t)), "TimeForce: force"),
}


@pytest.mark.parametrize("name", LOADS)
def test_a_load_that_depends_on_more_than_it_declares(press, method, name):
    load, problem = LOADS[name]
    with pytest.raises(pp.PinpressError, match=problem):
        pp.simulate(press, 0.2, loads=[load], method=method, **START)


def test_stretches_that_move(press, method):
    class Moving(Push):
        def intervals(self, downwards):
            self.upper += 0.001
            return super().intervals(downwards)

    with pytest.raises(pp.PinpressError, match=r"Moving: intervals\(True\) differ"):
        pp.simulate(press, 0.2, loads=[Moving(lambda h, v: 10.0 + 0.0 * h)], method=method, **START)


# ---------------------------------------------------------------------------------------------------- what fails in the middle of a run


def above(limit, otherwise):
    """-w up to a speed, and then something else; of arrays too."""

    def law(w, a, t, s):
        if np.max(np.abs(w)) > limit:
            return otherwise(w)
        return 2000.0 - w

    return law


def fails(*_):
    raise ZeroDivisionError("a table ends here")


ANSWERS = {
    "raises": (fails, "cannot be worked out: ZeroDivisionError: a table ends here"),
    "nan": (lambda w: w * math.nan, "is nan; give finite numbers"),
    "None": (lambda w: None, "is None; give finite numbers"),
    "text": (lambda w: "much", "is 'much'; give finite numbers"),
    "complex": (lambda w: 1j * np.asarray(w), "complex128.*; give finite numbers"),
    "shape": (lambda w: np.ones(7), r"has shape \(7,\)"),
}


@pytest.mark.parametrize("name", ANSWERS)
def test_a_drive_that_fails_in_the_middle(press, method, name):
    """Beyond 25 rad/s, at which nothing is tried before, but the run arrives from 8 rad/s."""
    otherwise, problem = ANSWERS[name]
    with pytest.raises(pp.SimulationError, match=f"Own: torque at speed.*{problem}|Own: torque.*{problem}") as caught:
        pp.simulate(press, 5.0, drive=Own(above(25.0, otherwise)), method=method, **START)
    error = caught.value
    assert 0.0 <= error.time < 5.0
    assert error.crank_angle >= 1.0
    assert re.search(r"time .* s, crank angle .* deg", str(error))
    if name == "raises":
        assert isinstance(error.__cause__, ZeroDivisionError)


@pytest.mark.parametrize("name", ANSWERS)
def test_a_load_that_fails_in_the_middle(press, method, name):
    """Beyond 1.2 m/s, at which nothing is tried before."""
    otherwise, problem = ANSWERS[name]

    def law(h, v):
        return otherwise(h) if np.max(np.abs(v)) > 1.2 else 100.0 + 0.0 * h

    with pytest.raises(pp.SimulationError, match=f"Push: force.*{problem}") as caught:
        pp.simulate(press, 2.0, loads=[Push(law)], method=method, **START | {"speed": 20.0})
    assert 0.0 <= caught.value.time < 2.0
    assert caught.value.crank_angle >= 1.0
    if name == "raises":
        assert isinstance(caught.value.__cause__, ZeroDivisionError)


def test_a_force_in_time_that_fails_in_the_middle(press, method):
    def law(t):
        return fails(t) if np.max(t) > 0.1 and np.max(t) < 0.3 else 10.0 + 0.0 * np.asarray(t)

    with pytest.raises(pp.SimulationError, match=r"TimeForce: force at time 0\.1.* s cannot be worked out") as caught:
        pp.simulate(press, 0.25, loads=[pp.loads.TimeForce(law)], method=method, **START)
    assert 0.0 < caught.value.time < 0.3


def test_scenarios_name_a_law_that_fails(press):
    with pytest.raises(pp.SimulationError, match=r"Own: torque at speed .* is nan.*time") as caught:
        pp.simulate_batch(
            press, 5.0, **START | {"speed": [8.0, 10.0]}, drive=Own(above(25.0, lambda w: np.where(np.abs(w) > 25.0, np.nan, 0.0)))
        )
    assert caught.value.time < 5.0


# --------------------------------------------------------------------------------------------------------------------------- warnings


def test_warnings_of_a_callers_law_are_the_callers(press, method):
    """Above 24 rad/s the logarithm of zero, in a branch that is not taken, warns as it does outside, unless the caller turned that off."""

    def law(w, a, t, s):
        left = np.maximum(24.0 - np.abs(w), 0.0)
        return 2000.0 + np.where(left > 0.0, 1e-3 * np.log(left), 0.0)

    with pytest.warns(RuntimeWarning, match="divide by zero"):
        pp.simulate(press, 0.2, drive=Own(law, corners=(24.0,)), method=method, **START)
    with warnings.catch_warnings(), np.errstate(divide="ignore"):
        warnings.simplefilter("error")
        pp.simulate(press, 0.2, drive=Own(law, corners=(24.0,)), method=method, **START)


@pytest.mark.parametrize("inertia", [-0.01, math.nan, np.array([1.0, -1.0]), np.ones((2, 2)), None])
def test_inertia_of_a_drive_that_makes_no_sense(press, inertia):
    """Also where that of the flywheel makes up for it."""
    with pytest.raises(pp.PinpressError, match="Own: inertia"):
        pp.simulate(press, 0.05, drive=Own(lambda w, a, t, s: -1.0 * w, inertia=inertia), **START)
    assert pp.simulate(press, 0.05, drive=Own(lambda w, a, t, s: -1.0 * w, inertia=0.0), **START).stats.energy_error < 1e-9


def test_a_law_that_fails_is_not_taken_for_a_missing_steady_state(press):
    """Its excitation makes it go from period to period over time; beyond 25 rad/s its torque ends."""
    drive = Own(above(25.0, fails), timed=True, state=(0.0,), rates=lambda w, a, t, s: (1.0 - s[0],))
    with pytest.raises(pp.SimulationError, match=r"Own: torque at speed 25 rad/s.*cannot be worked out: ZeroDivisionError"):
        pp.steady_state(press, 8.0, drive=drive, flywheel=START["flywheel"])


# ------------------------------------------------------------------------------------------------------------------- inverse dynamics


class QuietError(Exception):
    """Of a caller who has not thought of its message."""

    def __str__(self):
        raise ValueError("no message")


@pytest.fixture(scope="module")
def motion(press):
    return pp.cycle(press, 8.0, points=12)


def of_motion(law):
    return [pp.loads.PointForce("slide", lambda motion: law(np.ones((12, 3))))]


def on_the_way_down(law):
    return [Push(lambda h, v: law(np.asarray(h)))]


def in_time(law):
    return [pp.loads.TimeForce(lambda time: law(np.asarray(time)))]


KINDS = {
    "load on 'slide': force": of_motion,
    "Push: force": on_the_way_down,
    "TimeForce: force": in_time,
}


def logarithm(x):
    return np.where(x < math.inf, 1.0, np.log(0.0 * x))


@pytest.mark.parametrize("what", KINDS)
def test_a_load_that_fails_over_a_motion(press, motion, what):
    for error, said in (
        (ZeroDivisionError("a table ends here"), "a table ends here"),
        (QuietError(), "without a message"),
    ):

        def law(x, error=error):
            raise error

        with pytest.raises(pp.PinpressError, match=f"{what}.* cannot be worked out: {type(error).__name__}: {said}") as caught:
            pp.inverse_dynamics(press, motion, KINDS[what](law))
        assert caught.value.__cause__ is error


@pytest.mark.parametrize("what", KINDS)
def test_a_load_that_answers_what_is_no_force(press, motion, what):
    for answer in (None, "much", 1j, 10**5000, math.nan, np.ones(7)):
        with pytest.raises(pp.PinpressError, match=what):
            pp.inverse_dynamics(press, motion, KINDS[what](lambda x, answer=answer: answer))


def linear(upper, lower):
    return pp.loads.ForceInterval(upper, lower, lambda height, velocity: 1e3 + 0 * height)


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (None, r"intervals\(True\) is None; give a tuple of ForceInterval, \(\) for none"),
        (3, r"intervals\(True\) is 3; give a tuple of ForceInterval"),
        (((0.1, 0.0),), "give a tuple of ForceInterval"),
        ((linear(0.0, 0.1),), "an interval from 0.1 to 0.0 m; give lower < upper"),
        ((linear("high", 0.1),), "an interval from 0.1 to 'high' m; give lower < upper"),
        ((linear(0.1, math.nan),), "give lower < upper"),
        ((linear(0.1, 0.0), linear(0.2, 0.05)), "its intervals overlap at 0.05 m; write two loads"),
    ],
)
def test_a_load_whose_intervals_are_none(press, motion, answer, said):
    """A method that returns nothing on the way up, most of all; where it was not a run that asked, the last of what overlaps counted."""

    class Broken(Push):
        def intervals(self, downwards):
            return answer

    for asked in (
        lambda: pp.inverse_dynamics(press, motion, [Broken(None)]),
        lambda: pp.simulate(press, 0.1, speed=5.0, loads=[Broken(None)]),
        lambda: pp.ratings.speed_limit(press, pp.ratings.Capacities(1e6, torque=1e5), loads=[Broken(None)]),
        lambda: pp.sweeps.operating_points(press, [5.0], forces=[1.0], unit_load=Broken(None)),
    ):
        with pytest.raises(pp.PinpressError, match=f"Broken: .*{said}"):
            asked()


def test_a_load_whose_datum_is_none(press, motion):
    class Broken(Push):
        datum: Any = "bottom"

    for asked in (lambda: pp.inverse_dynamics(press, motion, [Broken(lambda x: 0.0)]), lambda: pp.loads.datum(Broken(None), press)):
        with pytest.raises(pp.PinpressError, match=r"Broken: datum is .*'bottom'"):
            asked()


def test_a_multiplied_load_is_called_by_its_own_name(press):
    with pytest.warns(pp.PinpressWarning, match="^Blanking acts from 2 to 6 m above its datum, nowhere on the slide's stroke"):
        pp.sweeps.operating_points(press, [5.0], forces=[1e5], unit_load=pp.loads.Blanking(1.0, 6.0, 2.0))


def test_a_load_without_stretches(press, motion):
    class Broken(Push):
        def intervals(self, downwards):
            raise KeyError("no such table")

    with pytest.raises(pp.PinpressError, match=r"Broken: intervals\(True\) cannot be worked out: KeyError: 'no such table'"):
        pp.inverse_dynamics(press, motion, [Broken(None)])


@pytest.mark.parametrize("what", KINDS)
def test_warnings_of_a_load_over_a_motion_are_the_callers(press, motion, what):
    with pytest.warns(RuntimeWarning, match="divide by zero"):
        pp.inverse_dynamics(press, motion, KINDS[what](logarithm))
    with warnings.catch_warnings(), np.errstate(divide="ignore"):
        warnings.simplefilter("error")
        pp.inverse_dynamics(press, motion, KINDS[what](logarithm))


def test_warnings_of_a_load_over_many_speeds_are_the_callers(press):
    """At operating points, where loads are multiplied, too."""
    for make in (of_motion, on_the_way_down):
        (unit,) = make(logarithm)
        with pytest.warns(RuntimeWarning, match="divide by zero"):
            pp.sweeps.operating_points(press, [5.0, 6.0], forces=[1.0, 2.0], unit_load=unit, points=12)
        with pytest.raises(pp.PinpressError, match=r"(slide'|Push): force.* cannot be worked out: ZeroDivisionError: a table ends here$"):
            pp.sweeps.operating_points(press, [5.0, 6.0], forces=[1.0, 2.0], unit_load=make(fails)[0], points=12)


def test_a_law_that_fails_is_not_taken_for_missing_mass():
    """A crank and a rod without mass leave no inertia at the dead centres; the load ends long before one of these is met."""
    light = large_linkages.load(without_mass(texts.shipped("crank_slide").text.decode(), "crank", "rod"))
    load = Push(lambda h, v: fails(h) if np.max(np.abs(v)) > 1.2 else 100.0 + 0.0 * h)
    with pytest.raises(pp.SimulationError, match=r"Push: force at height 0\.15 m, .* cannot be worked out: ZeroDivisionError.*\(time"):
        pp.simulate(light, 0.05, speed=20.0, angle=4.0, loads=[load])


# ------------------------------------------------------------------------------------------------------------------------- derivatives

VARIABLES = {"P.crank.x": (0.05, 0.1, 0.2)}


def peak(trial):
    return (trial.reactions.driving_torque**2).sum() / 1e4


def synthesised(press, law):
    load = Push(law, upper=0.3, lower=-0.3)
    load.datum = -0.4
    return pp.synthesis.synthesise(press, VARIABLES, minimise=peak, loads=[load], speed=8.0, points=12)


@pytest.mark.parametrize("law", [lambda h, v: 500.0 * abs(h), lambda h, v: 500.0 * np.real(h), lambda h, v: 50.0 * np.abs(v) + 100.0 * h])
def test_a_law_whose_derivative_is_lost_is_refused(press, law):
    """Derivatives are taken by complex numbers, of which `abs` and `real` lose the part that tells them."""
    with pytest.raises(
        pp.PinpressError, match=r"Push: force of complex numbers does not have its derivative by the (height|velocity); write"
    ):
        synthesised(press, law)


@pytest.mark.parametrize(
    "law", [lambda h, v: 500.0 * h**2 - 20.0 * v, lambda h, v: 300.0, lambda h, v: np.where(h > 0.1, 0.0 * h, 9e3 * h)]
)
def test_a_law_with_its_derivative_is_taken(press, law):
    found = synthesised(press, law)
    assert found.value < found.start_value


def test_a_law_that_fails_where_a_press_is_synthesised(press):
    with pytest.raises(pp.PinpressError, match=r"Push: force at height .* cannot be worked out: ZeroDivisionError: a table ends here"):
        synthesised(press, fails)
    with pytest.raises(
        pp.PinpressError, match=r"Push: force of complex numbers cannot be worked out: ZeroDivisionError: .*; write it with"
    ):
        synthesised(press, lambda h, v: fails(h) if np.iscomplexobj(h) else 1.0 * h)


# ----------------------------------------------------------------------------------------------------------------------------- declared


def jumping(w, a, t, s):
    return np.where(np.asarray(w) < 24.0, 200.0, -200.0) + 0.0 * w


def test_a_torque_that_jumps(press):
    """Declared so it is followed over time from the start on, undeclared as far as it goes over the angle; the run is the same."""
    started = {"speed": 23.0, "flywheel": pp.drives.Flywheel(30.0)}
    declared = pp.simulate(press, 0.2, drive=Own(jumping, corners=(pp.drives.Corner(24.0, jump=True),)), **started)
    plain = pp.simulate(press, 0.2, drive=Own(jumping, corners=(24.0,)), **started)
    geared = pp.drives.Geared(Own(jumping, corners=(pp.drives.Corner(24.0, jump=True),)), 2.0)
    assert "angle" not in declared.stats.solvers
    assert "angle" in plain.stats.solvers
    np.testing.assert_allclose(plain.crank_angle, declared.crank_angle, atol=1e-8)
    assert geared.corners == (pp.drives.Corner(12.0, jump=True),)


def test_a_corner_at_infinity_is_none(press):
    """As of a limit that is not there."""
    law, options = lambda w, a, t, s: -10.0 * w, START | {"points": 5}
    plain, endless = (pp.simulate(press, 0.2, drive=Own(law, corners=corners), **options) for corners in ((), (math.inf, -math.inf)))
    np.testing.assert_array_equal(plain.crank_angle, endless.crank_angle)


@pytest.mark.parametrize(("give", "said"), [({"jump": 1}, "jump is 1"), ({"speed": "fast"}, "speed is")])
def test_a_corner_that_makes_no_sense(give, said):
    with pytest.raises(pp.PinpressError, match=f"Corner: {said}"):
        pp.drives.Corner(**{"speed": 3.0} | give)


@dataclasses.dataclass(frozen=True)
class Stop:
    """A spring that pushes below a height, both ways."""

    stiffness: float
    damping: float = 0.0
    heeds_velocity: bool = False
    datum: float | None = None

    def law(self, height, velocity):
        return self.stiffness * (0.1 - height) - self.damping * velocity

    def intervals(self, downwards):
        return (ForceInterval(0.1, -math.inf, self.law, one_sided=True, heeds_velocity=self.heeds_velocity),)


def test_a_force_that_depends_on_velocity_though_it_is_declared_not_to(press):
    with pytest.raises(pp.PinpressError, match="Stop: force depends on the velocity; let heeds_velocity"):
        pp.simulate(press, 0.05, loads=[Stop(1e4, 100.0)], **START)
    pp.simulate(press, 0.05, loads=[Stop(1e4, 100.0, heeds_velocity=True)], **START)


def test_equal_intervals_both_ways_have_no_direction(press):
    """So a press that swings against them repeats itself, and needs to be followed for one swing alone."""
    run = pp.simulate(press, 40.0, angle=2.0, loads=[Stop(1e5)], points=11)
    assert "repetition" in run.stats.solvers
