"""Whatever is handed to the public functions and classes comes back as a result or as a PinpressError, soon; see `hostile_arguments`."""

import inspect
import random
import re

import numpy as np
import pytest
from support import every_result
from support.generators import hostile_arguments
from support.generators.hostile_arguments import RESULTS, TRIED, arguments, calls, cases, judge

import pinpress as pp
from pinpress.common import errors

SLOW = (
    "accuracy.",
    "steady_state",
    "plots.",
    "synthesis.",
    "servo.choose",
    "video.",
    "record",
    "report",
    "foundation.iso",
    "elasticity.over",
    "elasticity.impact",
    "elasticity.snap",
    "elasticity.permissible",
    "servo.best",
    "servo.trade",
    "ratings.rate",
)


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """Odd paths may be written to."""
    monkeypatch.chdir(tmp_path)


# What NumPy would take for numbers without a word.
NO_NUMBERS = ("complex", "masked", "dates", "span", "truths", "texts", "number as text", "True", "ragged")
# Arguments that are texts with a unit too, that are looked at where they are used, or of no use beside the others.
LATER = {"density", "centre", "crown_mass", "Rod.stiffness", "Stiffness.frame", "counts", "motor_constant"}


def is_number(value):
    if isinstance(value, list | tuple):
        return bool(value) and all(map(is_number, value))
    return not isinstance(value, bool) and (isinstance(value, int | float) or getattr(value, "dtype", np.dtype(bool)).kind in "fi")


def is_no_number(name, argument, value):
    """Whether a value stands for a number, or an array of them, and is none."""
    late = name.startswith((*SLOW, "view")) or {argument, f"{name.rpartition('.')[2]}.{argument}"} & LATER
    return value in NO_NUMBERS and not late and is_number(arguments(name)[argument])


def wrong(some):
    problems = ((*case, judge(*case, no_number=is_no_number(*case))) for case in some)
    return [f"{name}({argument}={value}): {problem}" for name, argument, value, problem in problems if problem]


def test_a_sample():
    """Of every argument of what is quick, one odd value or two."""
    quick = [case for case in cases() if not case[0].startswith(SLOW)]
    assert wrong(random.Random(7).sample(quick, 150)) == []


def test_what_was_wrong_once():
    assert (
        wrong(
            [
                ("cycle", "press", "text"),
                ("cycle", "points", "beyond"),
                ("ratings.rate", "speed", "tiny"),
                ("ratings.rate", "speed", "beyond"),
                ("balancing.trade_off", "points", "whole"),
                ("foundation.Frame", "mass", "beyond"),
                ("drives.InductionMotor", "poles", "span"),
                ("loads.ConstantForce", "force", "masked"),
                ("simulate", "points", "span"),
                ("balancing.balance", "minimise", "[]"),
                ("simulate", "progress", "library class"),
                ("simulate", "method", "masked"),
                ("balancing.CounterweightRegion", "replaces", "cube"),
                ("video.film", "path", "nan"),
                ("video.film", "slowdown", "beyond"),
                ("video.film", "frames_per_second", "span"),
                ("accuracy.compare", "progress", "infs"),
                ("classical.compare_harmonics", "orders", "span"),
                ("elasticity.dead_centre_shift", "speed", "huges"),
                ("elasticity.permissible_breakthrough", "clearance", "cube"),
                ("accuracy.compare", "duration", "tiny"),
                ("accuracy.compare", "speed", "tiny"),
                ("measures.pressure_angle", "axis", "huges"),
                ("report", "results", "texts"),
                ("report", "results", "cube"),
                ("elasticity.guide_contact", "offset", "huges"),
                ("measured.identify", "radii", "None"),
                ("tolerances.Dimension", "unit", "masked"),
            ]
        )
        == []
    )


def test_every_public_function_and_class_is_tried():
    """Except results, which functions make, bases of what users write, and a function without arguments."""
    spaces = [pp, *(space for name in dir(pp) if inspect.ismodule(space := getattr(pp, name))), pp.balancing.classical]
    named = {name: getattr(space, name) for space in spaces for name in dir(space)}
    public = {name for name, thing in named.items() if callable(thing) and not is_error(thing) and not is_protocol(thing)}
    results = {kind.__name__ for kind in every_result.returned()} - TRIED | RESULTS
    tried = {name.split(" ")[0].split(".")[-1] for name in calls()}
    assert public - results - tried == {"MotorPower", "SpeedTorqueDrive", "presses"}


def is_protocol(thing):
    return getattr(thing, "_is_protocol", False)


def is_error(thing):
    return inspect.isclass(thing) and issubclass(thing, Exception | Warning)


def test_the_judge_notices(monkeypatch):
    monkeypatch.setitem(hostile_arguments.ODD, "odd", [1])
    monkeypatch.setattr(hostile_arguments, "calls", lambda: {"sum": (lambda x: sum(x) / 0, {"x": [1]})})
    assert judge("sum", "x", "odd").startswith("ZeroDivisionError")
    monkeypatch.setattr(hostile_arguments, "calls", lambda: {"sum": (lambda x: x, {"x": [1]})})
    assert judge("sum", "x", "odd") is None
    assert judge("sum", "x", "odd", no_number=True) == "taken for a number"


def test_numbers_are_known_among_the_arguments():
    assert sum(is_no_number(name, argument, "complex") for name, (_, given) in calls().items() for argument in given) > 450


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", calls())
def test_all(name):
    """Of what takes long each third value, at every argument others; of `stopping`, a hundred runs a call, each 20th."""
    step = 20 if name == "ratings.stopping" else 3 if name.startswith(SLOW) else 1
    assert wrong([case for case in cases(name) if case[0] == name][::step]) == []


@pytest.mark.one_in(20)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize("name", [name for name in calls() if not name.startswith(("view", "video.", "accuracy."))])
def test_valid_arguments_are_taken(name):
    """Else only the first check of all would be tried. Files that are read are missing, and so is the folder to write to."""
    refusal = ""
    try:
        calls()[name][0](**arguments(name))
    except pp.PinpressError as error:
        refusal = str(error)
    assert not refusal or re.search("cannot be read|cannot write|there is no file", refusal), refusal


class Unwritten:
    """A value that cannot be printed."""

    def __repr__(self):
        raise RuntimeError("no words")


@pytest.mark.parametrize("value", [10**5000, [10**5000], Unwritten(), (Unwritten(),)], ids=["digits", "in a list", "silent", "in a tuple"])
@pytest.mark.parametrize(
    ("name", "argument"),
    [
        ("simulate", "drive"),
        ("simulate", "flywheel"),
        ("simulate", "method"),
        ("simulate", "loads"),
        ("inverse_dynamics", "friction"),
        ("inverse_dynamics", "bearings"),
        ("inverse_dynamics", "engine"),
        ("balancing.balance", "minimise"),
        ("elasticity.Stiffness", "rods"),
        ("drives.Brake", "closes"),
        ("drives.Geared", "drive"),
        ("foundation.Mount", "area"),
        ("loads.PointForce", "link"),
        ("loads.TimeForce", "force"),
        ("balancing.CounterweightRegion", "radius"),
        ("sweeps.sweep", "function"),
        ("balancing.with_counterweights", "counterweights"),
        ("derivatives.reshaped", "pivots"),
        ("video.film", "size"),
    ],
)
def test_values_that_cannot_be_printed(monkeypatch, name, argument, value):
    if name == "loads.PointForce":
        monkeypatch.setattr(hostile_arguments, "calls", lambda: {name: (dynamics_of_link, {"link": "slide"})})
    monkeypatch.setitem(hostile_arguments.ODD, "odd", value)
    assert judge(name, argument, "odd") is None


def dynamics_of_link(link):
    return pp.inverse_dynamics(every_result.press(), every_result.motion(), [pp.loads.PointForce(link, (0.0, 0.0, 1.0))])


def test_an_error_that_cannot_be_printed_is_named():
    assert errors.said(KeyError("a")) == "KeyError: 'a'"
    assert errors.said(RuntimeError()) == "RuntimeError"
