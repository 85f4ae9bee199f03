"""Linkages in space on springs: against the plane, the rigid limit, closed forms and other programs."""

import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.texts import FILES, shipped

import pinpress as pp
from pinpress.pin_table.templates import template
from pinpress.simulation.elastic import simulate_elastic
from pinpress.simulation.elastic.in_space.assembly import press_in_space

SPEED = 100 * pp.RPM
PINS = ("O", "B_cross", "B", "slide_guide")  # of the template, with its crank O, rod and slide


@cache
def rssp():
    """The template: a rod with a universal joint at the crank and a ball at the slide."""
    path = Path(tempfile.mkdtemp(dir=FILES.name)) / "rssp.yaml"
    path.write_bytes(template("rssp"))
    return pp.build(path)


def springs(press, stiffness, pins=PINS, **more):
    moments = dict.fromkeys(pins, 0.1 * stiffness)
    return pp.elasticity.Elastic(pp.elasticity.Stiffness(dict.fromkeys(press.bearings, stiffness), moments=moments), **more)


@cache
def idle(stiffness, points=37):
    return stroke(rssp(), SPEED, springs(rssp(), stiffness), points=points)


def stroke(press, speed, elastic, **more):
    return pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic, **more)


def test_a_planar_press_moves_in_space_as_in_its_plane(monkeypatch):
    """Under blanking: forces, events, depth, decay and works of the planar equations."""
    press, speed, stiffness = shipped("jf75g_125_plain"), 300 * pp.RPM, 2e9
    more = {"loads": [pp.loads.Blanking(1.25e6, 0.010, 0.005)], "points": 91}
    plane = stroke(press, speed, springs(press, stiffness, ["slide_guide"]), **more)
    monkeypatch.setattr(simulate_elastic, "press_on_springs", press_in_space)
    space = stroke(press, speed, springs(press, stiffness, press.joints), **more)
    assert space.stats.steps == plane.stats.steps
    for bearing, peak in plane.peaks.items():
        assert space.peaks[bearing] == pytest.approx(peak, rel=2e-8)  # a guide's twist is an angle there, its sine here
    np.testing.assert_allclose(space.events, plane.events, rtol=0, atol=1e-10)
    np.testing.assert_allclose(space.slide_position, plane.slide_position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(space.drive_torque, plane.drive_torque, rtol=0, atol=1e-7 * np.abs(plane.drive_torque).max())
    np.testing.assert_allclose(space.shaking_force, plane.shaking_force, rtol=0, atol=0.01)
    assert space.decay_per_stroke == pytest.approx(plane.decay_per_stroke, rel=1e-8)
    np.testing.assert_allclose(space.displacement[:, :, [0, 2]], plane.displacement[:, :, :2], rtol=0, atol=1e-10)
    assert np.abs(space.displacement[:, :, [1, 3, 5]]).max() < 1e-12
    np.testing.assert_allclose(np.abs(space.displacement[:, :, 4]), np.abs(plane.displacement[:, :, 2]), rtol=0, atol=1e-10)
    assert [each[-1] for each in (space.drive_work, space.load_work, space.lost)] == pytest.approx(
        [each[-1] for each in (plane.drive_work, plane.load_work, plane.lost)], rel=1e-9
    )


def test_rigid_limit_in_space():
    """What is left of the rigid press goes with 1 / stiffness."""
    rigid, runs = pp.inverse_dynamics(rssp(), pp.cycle(rssp(), SPEED, points=36)), [idle(k) for k in (1e9, 2e9)]
    rough = [np.array([run.bearing_force[name][:-1] for name in rssp().bearings]) for run in runs]
    exact = np.array([rigid.bearing_force[name] for name in rssp().bearings])
    left = [np.abs(each - exact).max() for each in rough]
    np.testing.assert_allclose(np.log2(np.divide(left[:-1], left[1:])), 1.0, atol=0.02)
    torque = [np.abs(run.drive_torque[:-1] - rigid.driving_torque).max() for run in runs]
    np.testing.assert_allclose(np.log2(np.divide(torque[:-1], torque[1:])), 1.0, atol=0.02)


def test_energy_in_space():
    run = idle(1e9)
    assert run.stats.energy_error < 1e-9
    assert abs(run.drive_work[-1] - run.lost[-1]) < 1e-9 * run.stats.energy_error + 1e-9 * np.ptp(run.drive_work)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"moments": dict.fromkeys(PINS[:2], 1e8)}, "lacks 'B', 'slide_guide'"),
        ({"bearings": {"O": 1e9}}, "lacks 'B_cross', 'B', 'slide_guide', 'S'"),
        ({"moments": dict.fromkeys((*PINS, "S"), 1e8)}, "'S', which is a ball joint"),
        ({"shaft": 1e6}, "in space knows no shaft"),
    ],
)
def test_refusals_in_space(change, words):
    press = rssp()
    given = {"bearings": dict.fromkeys(press.bearings, 1e9), "moments": dict.fromkeys(PINS, 1e8), **change}
    with pytest.raises(pp.PinpressError, match=words):
        stroke(press, SPEED, pp.elasticity.Elastic(pp.elasticity.Stiffness(**given)))
