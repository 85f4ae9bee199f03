"""Contests of benchmarks: peers at work, proximal settings and reduced tables; their errors are what theory and the published files say."""

import csv
import math
from pathlib import Path

import pytest
from benchmarks.accuracy.contests import PROXIMAL, proximal_contest, run_beside_peers, table_contest
from benchmarks.peers.six_bar_press import INTEGRATORS, SixBarEquation
from support import texts
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.accuracy.scenes import CLUTCH, DIE, SPEED_LAW, build_scene
from pinpress.accuracy.work_precision import flywheel_inertia

SPEED = 70 * pp.RPM
PUBLISHED = Path(__file__).resolve().parents[3] / "viz" / "accuracy.csv"


def judged(contest):
    """(method, setting as a number) -> errors of its answer."""
    return {(entry.method, entry.number): entry.errors(entry.work()) for entry in contest.contestants}


@pytest.mark.parametrize("group", rest_exhaustive((CLUTCH, DIE, SPEED_LAW), DIE))
def test_scenes_at_work(group):
    """All joints and the reduced equation agree on the end, and so does SciPy on the closed form, which shares no code with them."""
    press = texts.shipped("zxn2_3000b")
    scene = build_scene(press, group, SPEED, 1360.0, 2 * math.pi / SPEED)
    contest, skipped = run_beside_peers(press, scene, [SixBarEquation(name, balanced=False) for name in INTEGRATORS])
    assert contest.name == group
    assert contest.group.certificate < 1e-11
    works = {(entry.method, entry.setting): entry for entry in contest.contestants}
    integrator = "LSODA" if group == SPEED_LAW else "DOP853"
    for method, setting, bound in (
        ("reduced", "tolerance 1e-11", 1e-10),
        (f"SciPy {integrator}, closed form", "tolerance 1e-10", 5e-9),
    ):
        errors = works[method, setting].errors(works[method, setting].work())
        assert errors.error < bound
        assert errors.force_error < bound
    assert any("Runge-Kutta" in method for method, _ in works) == (group != SPEED_LAW)
    assert any(line.startswith("SciPy DOP853") for line in skipped) == (group == SPEED_LAW)


def test_proximal_settings():
    """Without mu nothing finite; with one iteration an error that grows as mu; the setting of method constraint as exact as any."""
    press = texts.shipped("zxn2_3000b")
    contest = proximal_contest(press, SPEED, flywheel_inertia(press))
    assert 0 < contest.group.certificate < 1e-10
    by = judged(contest)
    assert not math.isfinite(by["1 iteration", 0.0].error)
    assert by["1 iteration", 1e-8].error == pytest.approx(10 * by["1 iteration", 1e-9].error, rel=0.02)
    assert by["1 iteration", 1e-8].force_error == pytest.approx(10 * by["1 iteration", 1e-9].force_error, rel=0.02)
    assert by["5 iterations", 1e-2].error > 0.1
    (chosen,) = (errors for (method, _), errors in by.items() if method == "as chosen")
    assert chosen.error == contest.group.certificate
    assert chosen.force_error < 1e-13


def test_the_table_converges_faster_than_any_power():
    contest = table_contest(texts.shipped("zxn2_3000b"))
    assert 0 < contest.group.certificate < 1e-13
    errors = {entry.setting: entry.errors(entry.work()) for entry in contest.contestants if entry.method == "reduced"}
    assert errors["14 samples"].error > 0.01
    assert errors["56 samples"].error < 1e-6
    assert errors["224 samples"].error < 1e-13
    chosen = contest.contestants[-1]
    assert chosen.errors(chosen.work()).error < 1e-13
    with open(PUBLISHED, newline="", encoding="utf-8") as file:
        published = {row["setting"]: float(row["error"]) for row in csv.DictReader(file) if row["group"] == "reduced table"}
    for setting, found in errors.items():
        assert max(found.error, published[setting]) < 1e-11 or 1 / 3 < found.error / published[setting] < 3


def test_loops_that_share_a_load_have_no_proximal_settings():
    press = texts.shipped("jf75g_125_two_point")
    assert f"{PROXIMAL} are skipped" in proximal_contest(press, 300 * pp.RPM, 1.0)
