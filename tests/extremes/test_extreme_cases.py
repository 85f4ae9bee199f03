"""Every case of the table of extremes (`extreme_cases.py`) is held to its bound; of runs of many turns a shorter one."""

import math

import pytest
from extremes.extreme_case import Case, Outcome
from extremes.extreme_cases import CASES, table
from extremes.extreme_runs import many

import pinpress as pp

pytestmark = pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # that no press is like that

FEWER = many(500)
MORE = many(3000)  # takes six times as long, a third of the time of all cases
SHORT = [(case, way) for case in (*CASES, FEWER) for way in case.ways if not case.long and case.name != MORE.name]

ALWAYS = range(6, len(SHORT), 24)  # every 24th case, from where these take little time


@pytest.mark.parametrize(
    ("case", "way"),
    [
        pytest.param(case, way, id=f"{case.group}: {case.name}, {way}", marks=() if k in ALWAYS else pytest.mark.exhaustive)
        for k, (case, way) in enumerate(SHORT)
    ],
)
def test_case(case: Case, way: str) -> None:
    outcome = case.work(way)
    assert outcome.met, f"{case.expected}: {outcome}"


def test_the_run_left_out_is_in_the_table() -> None:
    assert [case.group for case in CASES if case.name == MORE.name] == [FEWER.group]


def test_no_two_cases_are_called_the_same() -> None:
    names = [(case.group, case.name) for case in CASES]
    assert len(set(names)) == len(names)


def test_the_table_says_what_is_not_met() -> None:
    """A wrong result, an error that was not expected, a foreign one and a bound of nan are all shown as such."""

    def raises(error: Exception) -> object:
        raise error

    scenes = {
        "wrong": (lambda way: 1.0, lambda found: Outcome(found, 0.5)),
        "not a number": (lambda way: math.nan, lambda found: Outcome(found, 0.5)),
        "refused": (lambda way: raises(pp.SimulationError("it stalls", 0.1, 1.0)), lambda found: Outcome(0.0, 0.5)),
        "foreign": (lambda way: raises(ZeroDivisionError("division")), lambda found: Outcome(0.0, 0.5)),
        "right": (lambda way: 0.1, lambda found: Outcome(found, 0.5)),
    }
    rows = list(table(("plane",), [Case("group", name, "", scene, judge, ("plane",)) for name, (scene, judge) in scenes.items()]))[2:]
    said = dict(zip(scenes, rows, strict=True))
    assert [name for name, row in said.items() if "**not met**" in row] == ["wrong", "not a number", "refused", "foreign"]
    assert "SimulationError at 57.2958 deg: it stalls" in said["refused"]
    assert "ZeroDivisionError" in said["foreign"]
