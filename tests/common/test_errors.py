"""Errors travel: copied and pickled, as worker processes send them home, they are what they were."""

import copy
import importlib
import multiprocessing
import pickle
import re
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import pinpress as pp
from pinpress.common.conic_program import UnsolvedError
from pinpress.common.errors import FileEntryError, UnknownScenarioError
from pinpress.loads.caller_laws import LawError
from pinpress.pin_table.placement import UnreachableError
from pinpress.servo.conic.never_resting import NoTurnError
from pinpress.servo.conic.optimum import NoMotionError

pytestmark = pytest.mark.usefixtures("time_limit")

ARGUMENTS = {
    UnsolvedError: ("the optimum was not found (NumericalError); give a largest mass",),
    pp.PinpressError: ("speed is 'x': give a number",),
    pp.UrdfError: ("press.urdf", '<joint name="A">', 12, "the axis is zero", "give three numbers"),
    FileEntryError: ("frame.yaml", 3, "mounts: 1", "no stiffness", "write stiffness"),
    pp.PinTableError: ("press.yaml", 7, "pins: C", "no side", "say side: up", "<svg/>"),
    UnreachableError: ("press.yaml", 7, "pins: C", "they do not meet", "make one longer"),
    pp.AssemblyError: ("the loops do not close", 0.5, 1e-3, 7),
    pp.SingularityError: ("the linkage locks", 0.5, 1e-9),
    pp.SimulationError: ("the press stalls", 0.25, 1.5),
    LawError: ("Fan: torque at speed 3 rad/s is nan", 0.25, 1.5),
    pp.UnknownNameError: ("bearing", "Q", ["A", "B"]),
    UnknownScenarioError: (7, 3),
    NoMotionError: ("no motion keeps the limits",),
    NoTurnError: ("no turn takes the time",),
}


def kinds(of=pp.PinpressError):
    """The library's own kinds: other tests have errors of theirs."""
    return [of, *(kind for below in of.__subclasses__() if below.__module__.startswith("pinpress.") for kind in kinds(below))]


def built():
    return [kind(*arguments) for kind, arguments in ARGUMENTS.items()]


def unknown_urdf(_=None):
    pp.load("no_such_press")


def not_assembled(_=None):
    press = pp.load("crank_slide")
    pp.inverse_dynamics(pp.derivatives.reshaped(press, {("P", "crank"): (0.13, 0, 0)}), pp.cycle(press, 1.0, points=4))


def locked(_=None):
    press = pp.load("zxn2_3000b")
    pp.cycle(pp.load(press.file, driver="D"), 1.0)


def stalled(_=None):
    pp.simulate(
        pp.load("crank_slide"), 1.0, speed=1.0, drive=pp.drives.ConstantTorque(-1.0), loads=[pp.loads.ForceStroke([0.0, 0.2], [1e7, 1e7])]
    )


def unknown_bearing(name="Q"):
    press = pp.load("crank_slide")
    return pp.inverse_dynamics(press, pp.cycle(press, 1.0, points=4)).bearing_force[name]


def unknown_scenario(_=None):
    pp.simulate_batch(pp.load("crank_slide"), 0.01, speed=np.array([1.0, 2.0]), points=2)[5]


def raised(call, *arguments):
    with pytest.raises(pp.PinpressError) as caught:
        call(*arguments)
    return caught.value


def same(one, other):
    assert type(one) is type(other)
    assert (str(one), one.args, vars(one)) == (str(other), other.args, vars(other))


def test_every_kind_of_error_is_here():
    for file in Path(pp.__file__).parent.rglob("*.py"):
        if re.search(r"^ *class \w+\(.*Error\b", file.read_text("utf-8"), re.MULTILINE):
            importlib.import_module(".".join(["pinpress", *file.relative_to(Path(pp.__file__).parent).with_suffix("").parts]))
    assert set(kinds()) == set(ARGUMENTS)


@pytest.mark.parametrize("error", built(), ids=lambda error: type(error).__name__)
def test_built_errors_travel(error):
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        same(pickle.loads(pickle.dumps(error, protocol)), error)
    same(copy.copy(error), error)
    same(copy.deepcopy(error), error)


CALLS = [unknown_urdf, not_assembled, locked, stalled, unknown_bearing, unknown_scenario]


@pytest.mark.parametrize("call", CALLS, ids=lambda call: call.__name__)
def test_raised_errors_travel(call):
    error = raised(call)
    same(pickle.loads(pickle.dumps(error)), error)
    same(copy.deepcopy(error), error)


def test_what_cannot_be_pickled_is_described():
    name = lambda: None  # noqa: E731
    error = raised(unknown_bearing, name)
    assert error.name is name
    assert pickle.loads(pickle.dumps(error)).name == repr(name)


def test_notes_stay():
    error = pp.SimulationError("the press stalls", 0.5)
    vars(error)["__notes__"] = ["in the second stroke"]
    same(pickle.loads(pickle.dumps(error)), error)


def raise_one(kind):
    raise kind(*ARGUMENTS[kind])


@pytest.mark.exhaustive
def test_process_pools_report_them():
    with multiprocessing.get_context("fork").Pool(1) as pool:
        for error in built():
            same(raised(pool.map_async(raise_one, [type(error)]).get, 20), error)
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        for error in built():
            same(raised(pool.submit(raise_one, type(error)).result, 20), error)


def test_of_a_pin_of_several_links_all_bearings_are_suggested():
    error = pp.UnknownNameError("bearing", "K", ["D", "K_lower", "H", "K_upper", "Kurbel"])
    assert str(error).startswith("no bearing 'K', did you mean 'K_lower' or 'K_upper'?; there are: D, ")
    assert "did you mean 'H'?" in str(pp.UnknownNameError("bearing", "h", ["H", "h_2"]))  # another case first
    assert "mean" not in str(pp.UnknownNameError("bearing", "", ["_a", "b"]))
