"""The press on springs beside other programs: integrators that share no code with ours come to the same end."""

from pathlib import Path

import numpy as np
import pytest
from benchmarks.accuracy import on_springs
from benchmarks.accuracy.on_springs import build_springs_scene, springs_contest
from support import texts

import pinpress as pp
from pinpress.pin_table import templates

SPEED = 70 * pp.RPM


@pytest.fixture
def few(monkeypatch):
    """The settings that take least time."""
    monkeypatch.setattr(on_springs, "FINEST", 1e-6)
    monkeypatch.setattr(on_springs, "FINEST_STROKE", 1e-6)
    monkeypatch.setattr(on_springs, "TOLERANCES", (1e-3,))
    monkeypatch.setattr(on_springs, "CERTIFYING", ("LSODA", 1e-9))


@pytest.mark.exhaustive
def test_integrators_and_exudyn_come_to_the_same_end(few):
    """SciPy on the same equations, Exudyn with bodies of its own; Exudyn steps over the edges of the blank."""
    scene = build_springs_scene(texts.shipped("crank_slide"), SPEED, 20.0)
    contest, skipped = springs_contest(scene)
    assert contest.group.certificate < 1e-7
    works = {(entry.method.split(" 1.")[0], entry.setting): entry for entry in contest.contestants}
    bounds = {
        ("elastic", "tolerance 1e-03"): 1e-7,
        ("elastic, steady stroke", "tolerance 1e-03"): 1e-5,
        ("SciPy Radau, on springs", "tolerance 1e-06"): 1e-6,
    }
    if not skipped:  # Exudyn is installed
        bounds |= {("Exudyn", "tolerance 1e-06"): 1e-4}
        works |= {("Exudyn", entry.setting): entry for entry in contest.contestants if entry.method.startswith("Exudyn")}
    for which, bound in bounds.items():
        errors = works[which].errors(works[which].work())
        assert errors.error < bound, which
        assert errors.force_error is not None
        assert errors.force_error < bound, which


def test_the_springs_belong_to_speed_and_size():
    """The lowest vibration is as many times as fast as the crank for every speed."""
    press = texts.shipped("crank_slide")
    scenes = [build_springs_scene(press, factor * SPEED, 20.0) for factor in (1.0, -2.0)]
    stiffness = [scene.elastic.stiffness.bearings["P"] for scene in scenes]
    assert stiffness[1] / stiffness[0] == pytest.approx(4.0, rel=0.05)  # rounded to two digits
    found = pp.elasticity.natural_frequencies(press, scenes[0].elastic, angle=[scenes[0].bottom])
    assert found.natural_frequency[0, 0] == pytest.approx(on_springs.VIBRATIONS * SPEED, rel=0.03)
    for scene in scenes:
        turned = scene.duration * scene.speed - (scene.bottom - scene.angle)
        assert turned / (2 * np.pi) == pytest.approx(round(turned / (2 * np.pi)), abs=1e-9)


def test_what_has_no_springs_is_refused():
    """A press in space has no such springs."""
    with pytest.raises(pp.PinpressError, match="rssp is not planar"):
        build_springs_scene(pp.build(Path(templates.__file__).with_name("rssp.yaml")), 1.0, 1.0)
