"""Columns by inertial parameters against inverse dynamics and Pinocchio's own regressors, and the ranks that presses are known to have."""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, given
from scipy.linalg import null_space
from support import texts
from support.generators.random_linkages import Group, Spec, drawn, linkages, loaded, servo
from support.generators.spatial_linkages import bennett
from support.presses.two_servos import TWO_SERVOS

import pinpress as pp
from pinpress.measured.estimates.base_parameters import base_parameters
from pinpress.measured.regressor import inertial_equations, loss_columns
from pinpress.pin_table import templates

SHAKING = [f"{kind} {axis}" for kind in ("force", "moment") for axis in "xyz"]


def any_motion(press, states=40, seed=0):
    """Angles, speeds and accelerations that have nothing to do with each other."""
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0.1, 2 * np.pi * press.period_turns, states))
    return pp.servo_cycle(press, angles, speed=rng.uniform(1, 3, states), acceleration=rng.uniform(-5, 5, states))


@cache
def press_of(name):
    """A shipped press, or one of a template."""
    return texts.shipped(name) if name in pp.presses() else pp.build(Path(templates.__file__).with_name(f"{name}.yaml"))


def refused(press):
    """Moments that a planar press's four parameters a link do not give."""
    normal = getattr(getattr(press.engine(), "plane", None), "normal", None)
    return set() if normal is None else {f"moment {axis}" for axis, part in zip("xyz", normal, strict=True) if abs(part) < 1 - 1e-9}


def residuals(press, motion):
    """By quantity the largest error of columns x values, relative to the largest torque, force or moment. Of a planar press the moments
    across its normal depend on what is across its plane."""
    equations, found = inertial_equations(press), pp.inverse_dynamics(press, motion)
    frame = press.model.inertias[0]
    weight = frame.mass * press.model.gravity.linear
    still = dict(zip(SHAKING, (*weight, *np.cross(frame.lever, weight)), strict=True))
    all_shaking = np.concatenate([found.shaking_force, found.shaking_moment], axis=1)
    size = {"t": np.abs(found.driving_torque).max(), "f": np.abs(all_shaking[:, :3]).max(), "m": np.abs(all_shaking).max()}
    wanted = {"torque": found.driving_torque, **dict(zip(SHAKING, all_shaking.T, strict=True))}
    wanted = {name: values for name, values in wanted.items() if name not in refused(press)}
    return {
        name: np.abs(equations.columns(motion, name) @ equations.values + still.get(name, 0.0) - values).max() / size[name[0]]
        for name, values in wanted.items()
    }


@pytest.mark.parametrize("name", [*pp.presses(), "rssp", "knuckle"])
def test_columns_times_values_are_inverse_dynamics(name):
    press = press_of(name)
    assert max(residuals(press, any_motion(press)).values()) < 1e-12


def judged(spec, folder):
    """Of a random linkage, if its groups can be placed."""
    drawing = drawn(spec)
    if drawing is None:
        return None
    press = loaded(drawing, folder)
    return max(residuals(press, pp.servo_cycle(press, **servo(press, np.random.default_rng(1)))).values())


@pytest.mark.parametrize(("kinds", "seed"), [(("RRR",), 1), (("RRP", "RPR"), 2), (("triad", "PRR"), 4)])
def test_so_they_are_of_random_linkages(tmp_path, kinds, seed):
    groups = tuple(Group(kind, 0, (k, k + 1, k + 2)) for k, kind in enumerate(kinds))
    found = judged(Spec(groups=groups, seed=seed, tilted=seed > 1, stacked=True, solid=True, extra=True), tmp_path)
    assert found is not None
    assert found < 1e-9


@pytest.mark.exhaustive
@given(linkages())
def test_so_they_are_of_any_linkage(tmp_path_factory, spec):
    found = judged(spec, tmp_path_factory.mktemp("random"))
    assume(found is not None)
    assert found < 1e-9


@pytest.mark.parametrize("name", ["zxn2_3000b", "rssp"])
def test_columns_are_those_of_pinocchios_regressors(name):
    press = press_of(name)
    equations, angle = inertial_equations(press), np.array([0.7, 2.0])
    found = equations.coefficients(angle)["torque"]
    unit = pp.servo_cycle(press, angle, speed=1.0, acceleration=0.0)
    model, data = press.model, press.model.createData()
    for k in range(2):
        q, v, a = unit.q[k], unit.v[k], unit.a[k]
        energy = 2 * pin.computeKineticEnergyRegressor(model, data, q, v).ravel()
        moving = v @ pin.computeJointTorqueRegressor(model, data, q, v, a)
        resting = v @ pin.computeJointTorqueRegressor(model, data, q, 0 * v, 0 * v)
        for ours, ten in ((found.inertia[k], energy), (found.slope[k] / 2, moving - resting), (found.weight[k], resting)):
            theirs = np.concatenate([part @ basis for part, basis in zip(ten.reshape(-1, 10), equations.bases, strict=True)])
            np.testing.assert_allclose(ours, theirs, atol=1e-11 * np.abs(theirs).max())


@pytest.mark.parametrize(
    ("name", "columns", "rank", "constant", "shaken", "shaken_rank"),
    [("zxn2_3000b", 15, 10, 9, 18, 14), ("jf75g_125", 13, 9, 8, 16, 12), ("knuckle", 15, 11, 10, 18, 14)],
)
def test_ranks(name, columns, rank, constant, shaken, shaken_rank):
    """Columns that are not zero and their rank: torque at any speeds, at one constant speed, and with shaking force and moment."""
    press = press_of(name)
    equations, motion = inertial_equations(press), any_motion(press, 80)
    even = pp.cycle(press, 5.0, points=80)
    assert count(equations.columns(motion)) == (columns, rank)
    assert count(equations.columns(even))[1] == constant
    both = np.concatenate([equations.columns(motion, quantity) for quantity in ("torque", "force x", "force z", "moment y")])
    assert count(both) == (shaken, shaken_rank)


def count(columns):
    sizes = np.linalg.norm(columns, axis=0)
    there = sizes > 1e-12 * sizes.max()
    values = np.linalg.svd(columns[:, there] / sizes[there], compute_uv=False)
    return there.sum(), (values > 1e-9 * values[0]).sum()


@pytest.mark.parametrize("name", ["zxn2_3000b", "rssp"])
def test_sums_in_words_are_the_sums_that_torque_determines(name):
    """Read as a formula, each name has the value of its row, to the four digits of its numbers; and other masses with the same sums need
    the same torque."""
    press = press_of(name)
    equations = inertial_equations(press)
    found, values = base_parameters(equations), equations.values
    named = dict(zip([each.name for each in equations.parameters], values, strict=True))
    for words, row in zip(found.names, found.matrix, strict=True):
        first, *others = re.split(r" ([+-]) (?=\d)", words)
        terms = [named[first]]
        for sign, term in zip(others[::2], others[1::2], strict=True):
            factor, _, parameter = term.partition(" ")
            terms.append(float(sign + factor) * named[parameter])
        assert len(terms) == np.count_nonzero(row)
        assert sum(terms) == pytest.approx(row @ values, abs=1e-3 * np.abs(terms).max() + 1e-12)
    heavy = np.flatnonzero([each.size > 0 for each in equations.parameters])  # the cross of a universal joint has no mass
    free, other = null_space(found.matrix[:, heavy]), values.copy()
    assert free.shape[1] >= 4
    other[heavy] += free @ np.random.default_rng(0).normal(size=free.shape[1])
    motion = any_motion(press)
    columns = equations.columns(motion, "torque")
    np.testing.assert_allclose(columns @ other, columns @ values, rtol=0, atol=1e-9 * np.abs(columns @ values).max())


@pytest.mark.parametrize("name", ["zxn2_3000b", "rssp"])
def test_a_press_with_other_parameters_has_them(name):
    press = press_of(name)
    equations = inertial_equations(press)
    np.testing.assert_allclose(inertial_equations(equations.pressed(equations.values)).values, equations.values, rtol=1e-12, atol=1e-12)
    doubled = equations.pressed(2 * equations.values)
    motion = any_motion(press)
    torques = [pp.inverse_dynamics(each, motion).driving_torque for each in (press, doubled)]
    np.testing.assert_allclose(torques[1], 2 * torques[0], rtol=1e-9)


def test_a_body_without_mass_gets_what_it_is_given():
    """All links of a planar press, which had none: then they have the masses, first moments and tensors of the press as it was."""
    press = press_of("zxn2_3000b")
    values = inertial_equations(press).values
    nothing = press.with_inertias([pin.Inertia(0.0, np.zeros(3), np.zeros((3, 3))) for _ in press.model.inertias])
    equations = inertial_equations(nothing)
    assert not equations.values.any()
    again = equations.pressed(values)
    np.testing.assert_allclose(inertial_equations(again).values, values, rtol=1e-12, atol=1e-12 * np.abs(values).max())
    motion = any_motion(press)
    torques = [pp.inverse_dynamics(each, motion).driving_torque for each in (press, again)]
    np.testing.assert_allclose(torques[1], torques[0], rtol=1e-9)


def test_losses_are_those_of_inverse_dynamics():
    """Pins and guide by their friction with the forces of a cylinder in the bearings; the cylinder by its force on the slide."""
    press = texts.shipped("jf75g_125")
    motion = any_motion(press, 30)
    arguments = (motion.crank_angle, motion.crank_speed, motion.crank_acceleration)
    radii = {"P2": 0.1, "P3": 0.05}
    columns = loss_columns(press, *arguments, ("pins", "slide_guide", "gibs", "crank"), True, radii=radii, cylinder_load=(5e3, 2e4))
    _, height = motion.slide_position, motion.slide_position - pp.dead_centres(press).bottom_position
    cylinder = pp.loads.PointForce(press.slide, (5e3 + 2e4 * height)[:, None] * press.slide_direction)
    plain, none = (pp.inverse_dynamics(press, motion, loads).driving_torque for loads in ([cylinder], []))
    np.testing.assert_allclose(columns[:, 5:] @ [5e3, 2e4], plain - none, atol=1e-9 * np.abs(plain).max())
    for k, laws in enumerate(({name: pp.loads.Friction(1e-4, r) for name, r in radii.items()}, {"slide_guide": pp.loads.Friction(1e-4)})):
        rubbing = pp.inverse_dynamics(press, motion, [cylinder], friction=laws).driving_torque
        np.testing.assert_allclose(1e-4 * columns[:, k], rubbing - plain, rtol=1e-2, atol=1e-9 * np.abs(plain).max())


def test_bodies_of_a_ring_in_space_too():
    press = texts.load(bennett())
    angles = np.linspace(0.1, 0.5, 12)
    motion = pp.servo_cycle(press, angles, speed=2.0, acceleration=1.0)
    assert residuals(press, motion)["torque"] < 1e-11


def test_presses_with_two_cranks_are_refused(tmp_path):
    (tmp_path / "table.yaml").write_text(TWO_SERVOS)
    press = pp.build(tmp_path / "table.yaml")
    with pytest.raises(pp.PinpressError, match="records need a press with one crank"):
        inertial_equations(press)
