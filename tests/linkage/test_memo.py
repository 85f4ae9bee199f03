"""A linkage whose model was changed in place is refused whatever is asked of it; copies and results stand on their own."""

import copy
import dataclasses
import pickle
from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

import pinpress as pp
from pinpress.linkage.memo import per_linkage
from pinpress.simulation.reduced_model import reduced_model_of


def heavier(model: pin.Model) -> None:
    model.inertias[2].mass *= 1.5


def longer(model: pin.Model) -> None:
    model.jointPlacements[2].translation = 1.1 * model.jointPlacements[2].translation


def on_the_moon(model: pin.Model) -> None:
    model.gravity.linear = np.array([0.0, 0.0, -1.62])


def with_armature(model: pin.Model) -> None:
    model.armature[0] = 3.0


CHANGES = [heavier, longer, on_the_moon, with_armature]


def used(press: pp.Linkage) -> pp.Motion:
    """A turn of a press of which everything was asked before."""
    motion = pp.cycle(press, speed=7.0, points=12)
    for engine in ("plane", "space", "pinocchio"):
        pp.inverse_dynamics(press, motion, engine=engine)
    pp.simulate(press, 0.05, speed=7.0)
    pp.dead_centres(press)
    return motion


ASKED: dict[str, Callable[[pp.Linkage, pp.Motion], object]] = {
    "cycle": lambda press, motion: pp.cycle(press, speed=7.0, points=12),
    "cycle by Pinocchio": lambda press, motion: pp.cycle(press, speed=7.0, points=12, engine="pinocchio"),
    "inverse dynamics": lambda press, motion: pp.inverse_dynamics(press, motion),
    "inverse dynamics by Pinocchio": lambda press, motion: pp.inverse_dynamics(press, motion, engine="pinocchio"),
    "simulate": lambda press, motion: pp.simulate(press, 0.05, speed=7.0),
    "simulate by constraints": lambda press, motion: pp.simulate(press, 0.05, speed=7.0, method="constraint"),
    "dead centres": lambda press, motion: pp.dead_centres(press),
    "closed pose": lambda press, motion: press.closed,
    "inertias": lambda press, motion: press.with_inertias([pin.Inertia.Zero()] * 4),
    "model": lambda press, motion: press.model,
    "operating points": lambda press, motion: pp.sweeps.operating_points(press, [7.0]),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_model_changed_in_place_is_refused_by_all(change):
    press = pp.load("crank_slide")
    motion = used(press)
    change(press.model)
    for ask in ASKED.values():
        with pytest.raises(pp.PinpressError, match=r"model of crank_slide was changed in place.*dataclasses\.replace"):
            ask(press, motion)


def test_what_follows_later_from_a_changed_model_is_refused_too():
    """A result's residual, a copy of the press, and a press that was made of a model which somebody keeps."""
    press, model = pp.load("crank_slide"), pp.load("crank_slide").model.copy()
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=7.0, points=12))
    made = dataclasses.replace(press, model=model)
    heavier(model)
    with pytest.raises(pp.PinpressError, match="changed in place"):
        pp.cycle(made, speed=7.0)
    pp.cycle(press, speed=7.0)  # that of the original goes on
    heavier(press.model)
    with pytest.raises(pp.PinpressError, match="changed in place"):
        _ = result.power_residual


@pytest.mark.parametrize("change", CHANGES)
def test_a_press_of_a_changed_copy_is_that_of_a_press_never_used(change):
    press, fresh = pp.load("crank_slide"), pp.load("crank_slide")
    used(press)
    made = []
    for each in (press, fresh):
        model = each.model.copy()
        change(model)
        made.append(dataclasses.replace(each, model=model))
    of_used, of_fresh = (pp.inverse_dynamics(each, pp.cycle(each, speed=7.0, points=12)) for each in made)
    np.testing.assert_array_equal(of_used.driving_torque, of_fresh.driving_torque)
    np.testing.assert_array_equal(of_used.motion.slide_position, of_fresh.motion.slide_position)


WAYS = [copy.copy, copy.deepcopy, lambda press: pickle.loads(pickle.dumps(press))]


@pytest.mark.parametrize("again", [*WAYS, dataclasses.replace])
def test_copies_answer_alike_and_notice_a_change_of_their_own(again):
    """What was worked out travels with a copy, read-only."""
    press = pp.load("crank_slide")
    torque, ends, table = pp.inverse_dynamics(press, used(press)).driving_torque, pp.dead_centres(press), reduced_model_of(press)
    other = again(press)
    assert pp.dead_centres(other) == ends
    np.testing.assert_array_equal(reduced_model_of(other).coefficients, table.coefficients)
    if again in WAYS:
        assert not vars(other)["_kept"].of_masses.keys() ^ vars(press)["_kept"].of_masses.keys()
    with pytest.raises(ValueError, match="read-only"):
        reduced_model_of(other).coefficients[0] = 1.0
    np.testing.assert_array_equal(pp.inverse_dynamics(other, pp.cycle(other, speed=7.0, points=12)).driving_torque, torque)
    heavier(other.model)
    with pytest.raises(pp.PinpressError, match="changed in place"):
        pp.cycle(other, speed=7.0)


def test_a_model_that_is_not_finite_is_refused_as_that():
    press = pp.load("crank_slide")
    model = press.model.copy()
    model.inertias[1].mass = np.nan
    with pytest.raises(pp.PinpressError, match="is not finite"):
        pp.cycle(dataclasses.replace(press, model=model), speed=7.0)


def test_ends_of_loops_and_all_that_follows_from_a_model_are_read_only():
    press = pp.load("zxn2_3000b")
    used(press)
    loop = press.loops[0]
    for array in (loop.point1, loop.rotation2, press.closed, press.branch.coefficients, press.axes[0].direction):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    mine = loop.point1.copy()
    moved = dataclasses.replace(loop, point1=mine)
    mine[0] += 1.0  # what a caller hands in stays his
    np.testing.assert_array_equal(moved.point1, loop.point1)


def test_a_force_changed_afterwards_does_not_change_a_result():
    press = pp.load("crank_slide")
    motion, force = pp.cycle(press, speed=7.0, points=12), np.tile([0.0, 0.0, 500.0], (12, 1))
    result = pp.inverse_dynamics(press, motion, [pp.loads.PointForce("slide", force)])
    force *= 100.0
    assert np.abs(result.power_residual).max() < 1e-12


def test_the_motion_of_a_balanced_press_is_no_run_of_the_old_one():
    press = pp.load("crank_slide")
    run = pp.simulate(press, 0.1, speed=40.0, flywheel=pp.drives.Flywheel(5.0), points=13)
    found = pp.balancing.balance(
        press,
        run,
        regions=[pp.balancing.CounterweightRegion("crank", radius=0.1, mass=(0.0, 20.0))],
        minimise=pp.balancing.Range("shaking_force", axis="z"),
    )
    (after,) = found.reactions_after
    assert type(after.motion) is pp.Motion
    assert after.motion.linkage == found.press.name
    for name in ("time", "joint_position", "v", "a"):
        np.testing.assert_array_equal(getattr(after.motion, name), getattr(run, name))


def test_other_masses_keep_what_follows_from_the_geometry_alone():
    press = pp.load("zxn2_3000b")
    used(press)
    before = reduced_model_of(press).coefficients
    heavy = press.with_inertias([pin.Inertia(2.0 * each.mass, each.lever, 2.0 * each.inertia) for each in press.model.inertias])
    assert heavy.branch is press.branch
    assert pp.dead_centres(heavy) is pp.dead_centres(press)
    np.testing.assert_allclose(reduced_model_of(heavy).coefficients[:, 0], 2.0 * before[:, 0], rtol=1e-12)
    assert dataclasses.replace(press).branch is not press.branch


def test_an_error_is_raised_each_time():
    asked = []

    @per_linkage
    def never(press):
        asked.append(press.name)
        raise pp.PinpressError("no")

    press = pp.load("crank_slide")
    for _ in range(2):
        with pytest.raises(pp.PinpressError, match="no"):
            never(press)
    assert asked == ["crank_slide"] * 2
