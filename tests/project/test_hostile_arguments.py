"""Whatever is handed to the public functions and classes comes back as a result or as a PinpressError, soon; see `hostile_arguments`."""

import inspect
import random

import pytest
from support.generators import hostile_arguments
from support.generators.hostile_arguments import calls, cases, judge

import pinpress as pp
from pinpress.common import errors

SLOW = (
    "accuracy.",
    "steady_state",
    "plots.",
    "synthesise",
    "servo.choose",
    "video.",
    "record",
    "report",
    "foundation.iso",
    "elasticity.over_speeds",
)
# Results, which functions make, and what subclasses are made of.
MADE = {
    "ActiveConstraint",
    "DeadCentresInClearances",
    "ForceReversal",
    "HeatShift",
    "SlideParallelism",
    "SlidePlay",
    "AccuracyBudget",
    "BottomCondition",
    "AddedMass",
    "BalancedPress",
    "ConditionComparison",
    "ElasticDeadCentre",
    "DeadCentres",
    "Dyad",
    "DesignTradeOff",
    "StrokePhase",
    "DyadAngles",
    "MotorDuty",
    "EnergyFlow",
    "MotorPower",
    "LoadedGuide",
    "GuideReaction",
    "OpenSurface",
    "SlideCompliance",
    "ExtremeValues",
}
MADE |= {
    "FailedPoint",
    "Group",
    "HarmonicAnalysis",
    "Linkage",
    "Measurement",
    "Motion",
    "MotionSensitivity",
    "PeriodEnergy",
    "OperatingMap",
    "CriterionChange",
}
MADE |= {
    "PressRatings",
    "MotionRatings",
    "Reactions",
    "Run",
    "DeflectedSlide",
    "SnapThroughResponse",
    "PermissibleSpeed",
    "ServoMotion",
    "ActiveLimit",
    "MotionOptimum",
    "TradeOffPoint",
    "MotionLaw",
    "MotorUtilisation",
    "EnergyStore",
    "ComparedMotion",
    "MotionComparison",
    "MotionTable",
    "TriedMotor",
    "MotorChoice",
    "Sweep",
    "SynthesisResult",
}
MADE |= {
    "AccelerationSensitivity",
    "Correction",
    "CrankSlider",
    "DrawnPress",
    "FrameMotion",
    "HarmonicChange",
    "Isolation",
    "VibrationModes",
    "WhirlDiagram",
    "LiftingMotion",
    "ElasticFrame",
    "MountedPress",
    "SpeedResponse",
    "ForceInterval",
}
MADE |= {"CampbellDiagram", "ElasticModes", "ElasticRun", "ElasticSpeedResponse", "ImpactsByTurn", "Resonance"}
MADE |= {
    "FittedMounts",
    "ProcessForceSensor",
    "MeasuredForce",
    "MeasuringPlan",
    "MeasuredModes",
    "OrderSpectra",
    "Spectra",
    "VibrationRecord",
}
MADE |= {
    "AllocatedTolerances",
    "DimensionTable",
    "DeadCentreScatter",
    "LiveView",
    "RunBatch",
    "Scatter",
    "SpeedTorqueDrive",
    "TradeOffCurve",
    "Trial",
    "RotorUnbalance",
    "WorkPrecision",
    "presses",
}
MADE |= {"IdentifiableParameters", "IdentifiedParameter", "IdentifiedPress", "LearntParameter"}


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """Odd paths may be written to."""
    monkeypatch.chdir(tmp_path)


def wrong(some):
    return [f"{name}({argument}={value}): {problem}" for name, argument, value in some if (problem := judge(name, argument, value))]


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
                ("rate", "speed", "tiny"),
                ("rate", "speed", "beyond"),
                ("trade_off", "points", "whole"),
                ("foundation.Frame", "mass", "beyond"),
                ("drives.InductionMotor", "poles", "span"),
                ("loads.ConstantForce", "force", "masked"),
                ("simulate", "points", "span"),
                ("balance", "minimise", "[]"),
                ("simulate", "progress", "library class"),
                ("simulate", "method", "masked"),
                ("CounterweightRegion", "replaces", "cube"),
                ("video.film", "path", "nan"),
                ("video.film", "slowdown", "beyond"),
                ("video.film", "frames_per_second", "span"),
                ("accuracy.compare", "progress", "infs"),
                ("classical.compare_harmonics", "orders", "span"),
                ("dead_centre_shift", "speed", "huges"),
                ("permissible_breakthrough", "clearance", "cube"),
                ("accuracy.compare", "duration", "tiny"),
                ("accuracy.compare", "speed", "tiny"),
                ("measures.pressure_angle", "axis", "huges"),
            ]
        )
        == []
    )


def test_every_public_function_and_class_is_tried():
    spaces = [pp, *(space for name in dir(pp) if inspect.ismodule(space := getattr(pp, name))), pp.balancing.classical]
    named = {name: getattr(space, name) for space in spaces for name in dir(space)}
    public = {name for name, thing in named.items() if callable(thing) and not is_error(thing) and not is_protocol(thing)}
    assert public - {name.rstrip("'").split(".")[-1] for name in calls()} == MADE


def is_protocol(thing):
    return getattr(thing, "_is_protocol", False)


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


def test_the_steady_state_that_is_tried_is_one():
    """Arguments from which one is exchanged must be sound, or only the first check of all would be tried."""
    made, arguments = calls()["steady_state"]
    assert made(**arguments()).crank_speed.min() > 0.0


class Unwritten:
    """A value that cannot be printed."""

    def __repr__(self):
        raise RuntimeError("no words")


@pytest.mark.one_in(5)
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
        ("balance", "minimise"),
        ("Stiffness", "rods"),
        ("Brake", "closes"),
        ("Geared", "drive"),
        ("foundation.Mount", "area"),
        ("PointForce", "link"),
        ("loads.TimeForce", "force"),
        ("CounterweightRegion", "radius"),
        ("sweep", "function"),
        ("with_counterweights", "counterweights"),
        ("reshaped", "pivots"),
        ("video.film", "size"),
    ],
)
def test_values_that_cannot_be_printed(monkeypatch, name, argument, value):
    if name == "PointForce":
        press = hostile_arguments.press()
        monkeypatch.setattr(hostile_arguments, "calls", lambda: {name: (of_link(press), lambda: {"link": "slide"})})
    elif name == "Geared":
        name = "drives.Geared"
    monkeypatch.setitem(hostile_arguments.ODD, "odd", value)
    assert judge(name, argument, "odd") is None


def of_link(press):
    return lambda link: pp.inverse_dynamics(press, hostile_arguments.motion(), [pp.loads.PointForce(link, (0.0, 0.0, 1.0))])


def test_an_error_that_cannot_be_printed_is_named():
    assert errors.said(KeyError("a")) == "KeyError: 'a'"
    assert errors.said(RuntimeError()) == "RuntimeError"
