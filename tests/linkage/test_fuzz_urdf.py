"""Mutated URDF files, a few of those that `python tests/support/generators/fuzz_urdf.py` makes by the thousand; and that it would notice
a fault."""

import os
import time

import pytest
from support.generators import fuzz_urdf
from support.generators.malformed_linkages import GOES

import pinpress as pp


@pytest.mark.exhaustive
def test_mutated_files_are_refused_or_sound():
    counted, wrong = fuzz_urdf.run(range(40), seed=21)
    assert wrong == {}
    assert counted["refused"] > 20
    assert counted["plane"] > 4
    assert counted["space"] > 0


@pytest.mark.exhaustive
def test_every_base_is_sound(tmp_path):
    for name, text in fuzz_urdf.bases().items():
        sound = ("plane", "space", *(("space, drawn pose alone",) if name[0].isdigit() else ()))  # some of the robots lock soon
        assert fuzz_urdf.judge(text.encode(), tmp_path) in sound, name


def test_cases_are_the_same_again():
    assert fuzz_urdf.case(3, 7) == fuzz_urdf.case(3, 7)
    assert len({fuzz_urdf.case(3, number) for number in range(50)}) > 45


def sleep_die_or_answer(number):
    if number == 0:
        time.sleep(60)
    if number == 1:
        os._exit(139)
    return number > 2, str(number)


@pytest.mark.exhaustive
def test_worker_goes_on():
    worker = fuzz_urdf.Worker(sleep_die_or_answer, seconds=2)
    try:
        assert [worker(number) for number in (0, 1, 2, 3, 3)] == [
            (False, "hangs: no end after 2 s"),
            (False, "crashes: exit code 139"),
            (False, "2"),
            (True, "3"),
            (True, "3"),
        ]
    finally:
        worker.stop()


def test_a_warning_is_no_fault(tmp_path):
    path, in_millimetres = tmp_path / "centre.urdf", GOES.replace("<inertial>", '<inertial><origin xyz="50 0 0"/>', 1)
    path.write_text(in_millimetres)
    with pytest.warns(pp.PinpressWarning):
        pp.load(path)
    assert fuzz_urdf.judge(in_millimetres.encode(), tmp_path) == "plane"


def fails(*_):
    raise ValueError("no PinpressError")


@pytest.mark.parametrize(
    ("owner", "name", "value", "message"),
    [
        (fuzz_urdf, "model_mass", lambda *_: 3.0, "mass 3.0 kg, not 4.0"),
        (fuzz_urdf, "gap_of", lambda *_: 1e-6, "a loop is 1e-06 m open"),
        (pp, "load", fails, "no PinpressError"),
    ],
)
def test_a_fault_is_noticed(tmp_path, monkeypatch, owner, name, value, message):
    monkeypatch.setattr(owner, name, value)
    with pytest.raises((AssertionError, ValueError), match=message):
        fuzz_urdf.judge(GOES.encode(), tmp_path)
