"""Stiffness of rods from the sections of a pin table: closed forms, jobs, what stays rigid, refusals."""

from typing import Any

import numpy as np
import pytest

import pinpress as pp
from pinpress.jobs.job import results_of
from pinpress.pin_table.templates import template

CRANK = """
press: crank
units: mm
frame: O
pins: {O: [0, 0], P: {from: O, length: 100, angle: -90}, W: {P: 400, x: 0, side: down}}
links:
  crank: {pins: O P, section: 90 x 50}
  rod:   {pins: P W, section: 80 x 60, overhang: 40}
  slide: {pins: W, guide: up, mass: 100}
drive: O
speed: 60 r/min
points: 36
loads: {push: {kind: constant-force, force: 100 kN, height: 20 mm}}
elastic: {frame: 3 GN/m}
"""
STIFFNESS = 2.1e11 * 0.08 * 0.06 / 0.4


@pytest.fixture
def table(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "press.yaml").write_text(CRANK)
    return tmp_path / "press.yaml"


def test_a_rod_yields_by_its_length_and_its_slope(table):
    """Under 1 N on the slide a rod with the slope b bears 1 / cos b: it moves the slide by l / (E A cos2 b)."""
    drawn = pp.pin_table.draft(table)
    (rod,) = pp.pin_table.rods(drawn)
    assert (rod.link, rod.between) == ("rod", ("P", "W"))
    assert rod.stiffness == pytest.approx(STIFFNESS, rel=1e-14)
    assert rod.basis == "80 x 60 mm and 210 GPa"
    found = pp.elasticity.compliance(drawn.press(), pp.elasticity.Stiffness(rods=[rod]), angle=np.linspace(0, 6, 20))
    slope = np.arcsin(0.25 * np.sin(found.crank_angle))
    assert found.compliance == pytest.approx(1 / (STIFFNESS * np.cos(slope) ** 2), rel=1e-12)


def test_links_that_are_no_rods_stay_rigid(tmp_path):
    """The crank is driven, the upper link has three pins; the lower one meets it."""
    (tmp_path / "knuckle.yaml").write_bytes(template("knuckle"))
    rods = pp.pin_table.rods(pp.pin_table.draft(tmp_path / "knuckle.yaml"), modulus=2e11)
    assert [rod.name for rod in rods] == ["coupler P-C", "lower K-S"]
    assert [rod.stiffness for rod in rods] == pytest.approx([2e11 * 0.12 * 0.09 / 0.65, 2e11 * 0.2 * 0.14 / 0.36], rel=1e-12)
    (tmp_path / "rssp.yaml").write_bytes(template("rssp").replace(b"pins: B S, mass: 6", b"pins: B S, section: 60 x 40"))
    assert pp.pin_table.rods(pp.pin_table.draft(tmp_path / "rssp.yaml")) == []  # in space


def answer(job: Any) -> Any:
    return next(results_of(job))


def test_a_job_takes_the_sections(table):
    job = pp.job(table)
    press = job.press
    rod, frame = pp.elasticity.Rod("rod", ("P", "W"), STIFFNESS), 3e9
    loads = [*job.loads.values()]
    expected = pp.elasticity.slide_deflection(press, job.motion(), pp.elasticity.Stiffness(rods=[rod], frame=frame), loads=loads)
    answers: list[Any] = [*results_of(job)]
    stiff, bent = answers
    assert bent.deflection == pytest.approx(expected.deflection, rel=1e-12)
    assert "Rods by E A / l: rod P-W of 80 x 60 mm and 210 GPa. Rigid links: crank, slide. Rigid bearings: O, P, slide_guide, W." in str(
        stiff
    )
    softer, given, rigid = (pp.job(table, elastic={"frame": frame, **more}) for more in SETTINGS)
    assert {*answer(softer).parts} == {"rod P-W", "frame"}
    for other, stiffness in ((softer, 0.1e11 / 2.1e11 * STIFFNESS), (given, 4e9)):
        of_rod = answer(other).parts["rod P-W"]
        assert of_rod == pytest.approx(answer(job).parts["rod P-W"] * STIFFNESS / stiffness, rel=1e-12)
    assert {*answer(rigid).parts} == {"frame"}
    assert "Rods by" not in str(answer(given))


SETTINGS = [{"modulus": "10 GPa"}, {"rods": {"rod": "4 GN/m"}}, {"rods": {"rod": "rigid"}}]


def test_a_run_on_springs_has_the_rods_too(table):
    bearings = {"all": {"stiffness": "1 GN/m", "moment_stiffness": "1 MN m/rad"}}
    job = pp.job(table, elastic={}, bearings=bearings)
    assert [rod.name for rod in job.elastic.stiffness.rods] == ["rod P-W"]


def test_refusals(table):
    for changes, message in (
        ({"links.rod.density": "2700"}, "elastic: link rod has a density of 2700 kg/m3, so its section is not of steel; give modulus"),
        ({"elastic": {"rods": {"slide": "4 GN/m", "rood": "4 GN/m"}}}, "no moving link 'rood'"),
        ({"elastic": {"rods": {"crank": "4 GN"}}}, "elastic: rods: crank: .*4 GN"),
        ({"elastic": {"modulus": 0.0}}, "modulus is 0"),
    ):
        with pytest.raises(pp.PinpressError, match=message):
            next(results_of(pp.job(table, **changes)))
    with pytest.raises(pp.PinpressError, match="rods: rocker has 3 bearings, and a rod has two; leave it out"):
        next(results_of(pp.job("zxn2_3000b", speed=7.0, points=36, elastic={"rods": {"rocker": 1e9}})))
    with pytest.raises(pp.PinpressError, match="modulus is of the sections of a table of pins; leave it out, and write rods"):
        next(results_of(pp.job("zxn2_3000b", speed=7.0, points=36, elastic={"modulus": "210 GPa"})))
