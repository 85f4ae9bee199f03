"""Presses on springs whose frame stands on mounts: the fixed frame, the linear vibration of `foundation`, energy, rigid-body motion."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.presses.presses_on_springs import BLANK, SPEED, WHEEL, induction, jf75g, springs
from support.texts import shipped

import pinpress as pp
from pinpress.simulation.elastic.press.assembly import sprung_press

FRAME = pp.foundation.Frame(9000.0, (0.0, 0.0, 0.3), (3000.0, 4000.0, 2500.0))
HELD: Any = {"drive": pp.drives.PrescribedSpeed(SPEED)}


def mounts(stiffness, damping):
    places = [(x, y, -0.8) for x in (-0.6, 0.6) for y in (-0.5, 0.5)]
    return [pp.foundation.Mount(place, (stiffness,) * 3, (damping,) * 3) for place in places]


def mounted(stiffness, damping, bearings=2e9, press=None):
    return replace(springs(press or jf75g(), bearings), mounted_frame=FRAME, mounts=mounts(stiffness, damping))


def test_stiff_mounts_become_a_fixed_frame():
    fixed, errors = pp.steady_state(jf75g(), SPEED, **HELD, elastic=springs(jf75g()), points=61), []
    for stiffness in (1e10, 1e11):
        run: Any = pp.steady_state(jf75g(), SPEED, **HELD, elastic=mounted(stiffness, 1e-4 * stiffness), points=61)
        errors.append([np.abs(getattr(run, of) - getattr(fixed, of)).max() for of in ("slide_position", "shaking_force", "drive_torque")])
    np.testing.assert_allclose(np.divide(*errors), 10.0, rtol=0.01)


def test_soft_mounts_as_the_linear_frame_shaken_by_the_rigid_press():
    """What is left is of second order: the links' places in the frame change while it moves."""
    run: Any = pp.steady_state(jf75g(), SPEED, **HELD, elastic=mounted(2e6, 2e4, 2e10), points=181)
    system, motion = pp.foundation.mounted(jf75g(), FRAME, mounts(2e6, 2e4)), pp.cycle(jf75g(), SPEED, points=180)
    linear = pp.foundation.steady_response(system, pp.inverse_dynamics(jf75g(), motion), points={"centre": FRAME.centre})
    np.testing.assert_allclose(run.frame_motion[:-1, :2], linear.displacement["centre"][:, [0, 2]], atol=1e-3 * 8.5e-3)
    weight = np.linalg.norm(jf75g().model.gravity.linear) * system.total_mass
    assert -run.floor_force[:-1, 2].mean() == pytest.approx(weight, rel=1e-4)
    assert np.abs(run.floor_force[:, 1]).max() == 0
    assert run.stats.energy_error < 1e-9


@pytest.mark.exhaustive
def test_blanking_under_a_motor_on_soft_mounts():
    """The cut shakes the frame, whose mounts lose energy too; what the process load takes from the slide presses on the frame."""
    run: Any = pp.simulate(
        jf75g(), 0.25, speed=SPEED, drive=induction(), flywheel=WHEEL, loads=[BLANK], elastic=mounted(2e6, 2e4), points=301
    )
    bottom = pp.dead_centres(jf75g()).bottom_position
    assert run.stats.energy_error < 1e-10
    assert [height for _, _, height in run.events] == pytest.approx([bottom + BLANK.start, bottom + BLANK.end], abs=1e-9)
    np.testing.assert_allclose(run.frame_motion[0], 0.0, atol=1e-12)
    assert "floor_force_z [N]" in run.columns()


@pytest.mark.parametrize("name", ["jf75g_125_plain", "zxn2_3000b", "thin_wall", "jf75g_125_symmetric", "jf75g_125_two_point"])
def test_all_turn_with_the_frame(name):
    """When everything turns about the origin, the crank's angle and the gears stand, and no bearing opens."""
    press = shipped(name)
    sprung: Any = sprung_press(press, mounted(1e6, 1e3, 1e9, press))
    coordinates = sprung.geometry.rigid(pp.cycle(press, 1.0, points=5))[0]
    bodies = 3 * len(sprung.geometry.centers) - 3  # but for the ground
    place = sprung.geometry.centers[:-1] + coordinates[:, 0:bodies:3] + 1j * coordinates[:, 1:bodies:3]
    rates = np.zeros_like(coordinates)
    rates[:, 0:bodies:3], rates[:, 1:bodies:3], rates[:, 2:bodies:3] = (1j * place).real, (1j * place).imag, 1.0
    free = sprung.free_rates(rates)
    np.testing.assert_allclose(free @ sprung.carry.T, rates, atol=1e-12)
    np.testing.assert_allclose(free[:, -1], 0.0, atol=1e-12)
    opening = sprung.geometry.strains(sprung.geometry.state(coordinates, rates)).opening[:, sprung.springs.bearing >= 0]
    np.testing.assert_allclose(opening, 0.0, atol=1e-12)


def test_mounts_that_cannot_be_are_refused():
    given = springs(jf75g())
    for change, message in (
        ({"mounts": mounts(1e6, 0)}, "mounted_frame is None"),
        ({"mounted_frame": FRAME}, "give a list of foundation.Mount"),
        ({"mounted_frame": FRAME, "mounts": mounts(1e6, 0), "clearances": {"P4": pp.elasticity.Clearance(1e-4)}}, "leave out clearances"),
    ):
        with pytest.raises(pp.PinpressError, match=message):
            replace(given, **change)
    pad = pp.foundation.Mount((0, 0, 0), (1e6, 1e6, 1e6), loss_factor=0.1)
    for bad, message in (([pad], "loss factor, which belongs"), (mounts(1e6, 0)[:1], "do not hold the frame in its plane")):
        with pytest.raises(pp.PinpressError, match=message):
            pp.steady_state(jf75g(), SPEED, **HELD, elastic=replace(given, mounted_frame=FRAME, mounts=bad))


def test_modes_of_the_frame_on_its_mounts():
    """With stiff bearings the lowest modes are those of `foundation`, in the plane, where the links stand as they do on average."""
    modes = pp.elasticity.natural_frequencies(jf75g(), mounted(2e6, 2e4, 1e11), angle=[0.0])
    linear = pp.foundation.modes(pp.foundation.mounted(jf75g(), FRAME, mounts(2e6, 2e4))).natural_frequency
    beside = np.abs(modes.natural_frequency[0, :3, None] - linear).min(axis=1)
    np.testing.assert_array_less(beside, 1e-2 * modes.natural_frequency[0, :3])
    yielding, moving = modes.words(0, 0)
    assert yielding.startswith("mounts 100 %")
    assert moving.startswith("frame ")
