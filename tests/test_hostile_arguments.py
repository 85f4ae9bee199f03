"""Whatever is handed to the public functions and classes comes back as a result or as a PinpressError, soon; see `hostile_arguments`."""

import inspect
import random

import hostile_arguments
import pytest
from hostile_arguments import calls, cases, judge

import pinpress as pp

SLOW = (
    "accuracy",
    "steady_state",
    "plot_",
    "save_plot",
    "foundation.plot",
    "synthesise",
    "film",
    "still",
    "record",
    "report",
    "foundation.iso",
)
# Results, which functions make, and what subclasses are made of.
MADE = {"Accuracy", "Active", "AddedMass", "Balance", "DeadCentreShift", "DeadCentres", "Duty", "EccentricLoad", "Elasticity", "Extreme"}
MADE |= {"FailedPoint", "Finding", "Harmonics", "Linkage", "Measurement", "Motion", "MotionDerivative", "OperatingPoints", "Outcome"}
MADE |= {"Ratings", "Reactions", "Report", "Run", "Runs", "SlideDeflection", "SnapThrough", "SpeedLimit", "Stats", "Sweep", "Synthesis"}
MADE |= {"TradeOff", "Trial", "presses"}


def wrong(some):
    return [f"{name}({argument}={value}): {problem}" for name, argument, value in some if (problem := judge(name, argument, value))]


def test_a_sample():
    """Of every argument of what is quick, one odd value or two."""
    quick = [case for case in cases() if not case[0].startswith(SLOW)]
    assert wrong(random.Random(7).sample(quick, 400)) == []


def test_what_was_wrong_once():
    assert (
        wrong(
            [
                ("cycle", "press", "text"),
                ("cycle", "points", "beyond"),
                ("ratings", "speed", "tiny"),
                ("ratings", "speed", "beyond"),
                ("trade_off", "points", "whole"),
                ("foundation.Frame", "mass", "beyond"),
                ("drives.InductionMotor", "poles", "span"),
                ("loads.Piling", "force", "masked"),
                ("simulate", "points", "span"),
                ("balance", "minimise", "[]"),
            ]
        )
        == []
    )


def test_every_public_function_and_class_is_tried():
    public = {name for name in pp.__all__ if callable(getattr(pp, name)) and not is_error(getattr(pp, name))}
    assert public - {name.rstrip("'") for name in calls()} == MADE


def is_error(thing):
    return inspect.isclass(thing) and issubclass(thing, Exception | Warning)


def test_the_judge_notices(monkeypatch):
    monkeypatch.setitem(hostile_arguments.ODD, "odd", [1])
    found = {"sum": (lambda x: sum(x) / 0, lambda: {"x": [1]})}
    monkeypatch.setattr(hostile_arguments, "calls", lambda: found)
    assert judge("sum", "x", "odd").startswith("ZeroDivisionError")


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", calls())
def test_all(name):
    assert wrong(case for case in cases(name) if case[0] == name) == []
