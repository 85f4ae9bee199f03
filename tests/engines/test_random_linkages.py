"""The planar engine against Pinocchio's, and both against momentum and energy, on linkages nobody thought of.

The engines share the reading of the URDF and the crank's branch, and no equation: one has complex vectors and dyads, the other Pinocchio's
constraint models and recursive Newton-Euler algorithm. Peaks are over all bearings and states of a linkage.

States are taken between the drawn pose, which is drawn clear of singularities, and half-way to where the linkage locks, at most 0.05 rad
away: that bounds the condition numbers, and with them what rounding may do.
"""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.exploring import examples
from support.generators.random_linkages import (
    Drawing,
    Group,
    Spec,
    apart,
    drawn,
    linkages,
    loaded,
    momentum_balance,
    newton_euler,
    peaks,
    random_loads,
    servo,
)

import pinpress as pp

ENGINES = ("plane", "space", "pinocchio")


def check(press, states, loads):
    """Every comparison of one linkage."""
    weight = np.array([1.0 if axis.turns else 1.0 / press.size for axis in press.axes])  # lengths in lengths of the linkage
    motions = {engine: pp.servo_cycle(press, **states, engine=engine) for engine in ENGINES}
    *batched, other = (motions[engine] for engine in ENGINES)
    for one, name in itertools.product(batched, ("v", "a")):
        expected = weight * getattr(other, name)
        error = np.abs(weight * getattr(one, name) - expected).max()
        assert error <= 1e-11 * np.abs(expected).max(), name  # two Newton iterations stop at gaps of rounding, conditioned as the drawing
    for motion in motions.values():
        assert motion.closure_error.max() <= 1e3 * press.engine("pinocchio").tolerance

    results = {engine: pp.inverse_dynamics(press, motions[engine], loads, engine=engine) for engine in ENGINES}
    force_peak, moment_peak = peaks(press, results["pinocchio"])
    for engine in ENGINES[:-1]:
        same = pp.inverse_dynamics(press, motions[engine], loads, engine="pinocchio")
        for compared, bound in ((same, 1e-13), (results["pinocchio"], 1e-12)):  # of the same states; of states closed by the other engine
            assert list(results[engine].bearing_force) == list(compared.bearing_force)
            assert max(apart(results[engine], compared)) <= bound

    for engine in ENGINES:
        result = results[engine]
        assert result.engine == engine
        assert np.abs(result.power_residual).max() <= 1e-10
        force, moment = momentum_balance(press, motions[engine], loads)
        assert np.abs(result.shaking_force - force).max() <= 1e-10 * force_peak
        assert np.abs(result.shaking_moment - moment).max() <= 1e-10 * max(moment_peak, np.abs(moment).max())
        forces, moments, idle = newton_euler(press, motions[engine], result, loads)
        assert np.abs(forces).max() <= 1e-12 * force_peak
        assert np.abs(moments).max() <= 1e-12 * moment_peak
        assert np.abs(idle).max(initial=0.0) <= 1e-12 * moment_peak
    for name in press.bearings:
        for engine in ENGINES[:-1]:
            np.testing.assert_array_equal(results[engine].indeterminate[name], results["pinocchio"].indeterminate[name], err_msg=name)


@examples(12)
@given(spec=linkages(), load_count=st.integers(0, 2), in_plane=st.booleans())
def test_engines_agree_and_balance(tmp_path, spec, load_count, in_plane):
    """Velocities and accelerations to 1e-11, forces and moments to 1e-12 of their peak, power and momentum to 1e-10: see `check`."""
    drawing = drawn(spec)
    assume(drawing is not None)
    rng = np.random.default_rng(spec.seed + 1)
    press = loaded(drawing, tmp_path, gravity=rng.normal(size=3) * 10)
    assert "plane" in press.engines
    check(press, servo(press, rng), random_loads(press, rng, load_count, in_plane))


@pytest.mark.one_in(11)
@pytest.mark.parametrize("cut", [0, 1, 2])
@pytest.mark.parametrize("kind", ["RRR", "RRP", "RPR", "PRR"])
def test_every_dyad_with_every_cut(tmp_path, kind, cut):
    """One dyad on crank and frame, and one between two moving links, tilted, stacked and solid: no kind is left to chance."""
    groups = (Group(kind, cut, (1, 0, 0)), Group(kind, cut + 1, (1, 1, 0)))
    spec = Spec(groups, 1000 + cut, tilted=True, stacked=True, solid=True, extra=True)
    rng = np.random.default_rng(cut)
    press = loaded(drawn(spec), tmp_path, gravity=(1.0, -2.0, -9.0))
    assert [len(block.loops) for block in press.engine("plane").plane.blocks] == [1, 1]
    check(press, servo(press, rng), random_loads(press, rng, 2, False))


def stephenson():
    """A six-bar in which neither loop closes without the other: the crank's bar drives a plate that two rockers carry."""
    drawing = Drawing("stephenson")
    drawing.joint("crank", "frame", "crank", -0.5 + 1.2j)
    drawing.joint("bar", "crank", "bar", -0.3 + 1.2j)
    drawing.joint("plate", "bar", "plate", 1.6 + 1.5j, bounded=True)
    drawing.joint("left", "frame", "left", 1.0 + 0j, bounded=True)
    drawing.joint("right", "frame", "right", 2.0 + 0j, sense=-1, bounded=True)
    drawing.loop("P", "plate", "left", 1.1 + 1.0j)
    drawing.loop("Q", "right", "plate", 2.2 + 1.1j)
    centres = {"crank": -0.45 + 1.25j, "bar": 0.6 + 1.3j, "plate": 1.6 + 1.2j, "left": 1.05 + 0.6j, "right": 2.1 + 0.5j}
    for link, centre in centres.items():
        drawing.body(link, 3.0, centre, tensor=np.diag([0.1, 0.1, 0.2]))
    return drawing


def test_two_loops_that_close_together(tmp_path):
    """A Stephenson linkage over a whole turn: one block of two loops, both engines the same, and energy and momentum in balance."""
    press = loaded(stephenson(), tmp_path)
    assert [len(block.loops) for block in press.engine("plane").plane.blocks] == [2]
    assert press.branch.period == pytest.approx(2 * np.pi)
    turn = 2 * np.pi * np.arange(12) / 12
    check(press, {"angle": turn, "speed": np.full(12, 7.0), "acceleration": np.linspace(-40, 40, 12)}, [])
    assert np.ptp(pp.cycle(press, speed=7.0).q[:, press.joints.index("left")]) > 0.1  # it does move


@pytest.mark.exhaustive
@pytest.mark.parametrize("tilted", [False, True])
def test_the_generator_draws_closed_linkages(tmp_path, tilted):
    """The drawn pose is closed as it is written, so `load` moves no joint: 1e-13 is rounding over a chain of frames."""
    groups = (Group("RRR", 0, (0, 0, 0)), Group("RPR", 1, (2, 1, 0)), Group("triad", 1, (0, 0, 3)))
    press = loaded(drawn(Spec(groups, 7, tilted=tilted, stacked=tilted, solid=tilted)), tmp_path)
    assert np.abs(press.closed).max() < 1e-13
    assert sorted(len(block.loops) for block in press.engine("plane").plane.blocks) == [1, 1, 2]
    assert press.mobility == 1
