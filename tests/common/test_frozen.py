"""Results travel: copied, pickled and sent home by other processes they are what they were, bit by bit, and as read-only."""

import copy
import dataclasses
import functools
import multiprocessing
import pickle
import types
from collections.abc import Mapping, Sequence, Set
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pinocchio as pin
import pytest
from support import every_result

import pinpress as pp

pytestmark = pytest.mark.usefixtures("time_limit")
WAYS = {"pickle": lambda value: pickle.loads(pickle.dumps(value)), "copy": copy.copy, "deepcopy": copy.deepcopy}
DRAWING = pp.loads.DeepDrawing(force=1e4, start=0.02)
KINDS = sorted(every_result.public(), key=lambda kind: kind.__name__)


def parts(value):
    """What a value consists of, under names: all fields of ours, private ones too, but not what is kept when it is first asked for."""
    if dataclasses.is_dataclass(value):
        kept = ("_closed_for",)  # what an engine kept of a motion for the linkage that it closed, which copies do not know
        return {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.name not in kept}
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, tuple | list):
        return dict(enumerate(value))
    if isinstance(value, functools.partial):
        return {"function": value.func, "arguments": value.args, "keywords": value.keywords}
    if isinstance(value, types.MethodType):
        return {"function": value.__func__, "of": value.__self__}
    if type(value).__module__.startswith(("pinpress", "scipy")):
        return dict(zip(("maker", "arguments", "state"), value.__reduce_ex__(4), strict=False))
    return None


def same(one, other, where="", seen=None):
    """Fail where two values differ in a bit."""
    seen = {} if seen is None else seen
    if seen.setdefault(id(one), other) is not other or one is other:
        return
    assert type(one) is type(other), where
    if isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape), where
        if one.dtype == object:
            assert one.tolist() == other.tolist(), where
        else:
            assert np.ascontiguousarray(one).tobytes() == np.ascontiguousarray(other).tobytes(), where
            np.testing.assert_array_equal(np.ma.getmaskarray(one), np.ma.getmaskarray(other), where)
        return
    inner, others = parts(one), parts(other)
    if inner is None:
        exact = isinstance(one, float) and repr(one) == repr(other)
        assert exact or isinstance(one, types.FunctionType | type | pin.Force) or one == other, where
        return
    assert list(inner) == list(others), where
    for name, value in inner.items():
        same(value, others[name], f"{where}.{name}", seen)


def arrays(value, where="", seen=None):
    """Arrays that a user can reach: in attributes that are public, kept ones too, in mappings and sequences."""
    seen = set() if seen is None else seen
    if id(value) in seen:
        return
    seen.add(id(value))
    if isinstance(value, np.ndarray):
        yield where, value
        if isinstance(value, np.ma.MaskedArray):
            yield f"{where}.data", value.data
            yield f"{where}.mask", value.mask
        return
    inner = parts(value) if isinstance(value, Mapping | tuple | list) or dataclasses.is_dataclass(value) else {}
    if dataclasses.is_dataclass(value):
        kept = {
            name: found
            for kind in type(value).__mro__
            for name, found in vars(kind).items()
            if isinstance(found, functools.cached_property)
        }
        inner = {name: getattr(value, name, None) for name in inner | kept if not name.startswith("_")}
    for name, found in inner.items():
        yield from arrays(found, f"{where}.{name}", seen)


def containers(value):
    for field in dataclasses.fields(value):
        found = getattr(value, field.name)
        if isinstance(found, Mapping | Sequence | Set) and not field.name.startswith("_"):
            yield field.name, found


def made(kind):
    """Of this very class."""
    return [value for value in every_result.made() if type(value) is kind]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", KINDS)
def test_copies_are_what_they_were(kind, way):
    assert made(kind)
    for value in made(kind):
        same(value, WAYS[way](value), kind.__name__)


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_in_reach_can_be_written(kind):
    for value in made(kind):
        for where, each in (("itself", value), *((way, make(value)) for way, make in WAYS.items())):
            for name, array in arrays(each, kind.__name__):
                assert not array.flags.writeable, f"{name} of {where}"
            for name, container in containers(each):
                for change in ("__setitem__", "__delitem__", "append", "add", "update", "clear"):
                    assert not hasattr(container, change), f"{name} of {where}"


def computed(press):
    """Motion, forces, runs and ratings of a press."""
    motion = pp.cycle(press, every_result.SPEED, points=12)
    return (
        motion,
        pp.inverse_dynamics(press, motion, [DRAWING]),
        pp.simulate(press, 0.1, speed=2.0, flywheel=pp.drives.Flywheel(20.0)).joint_position,
        pp.simulate(press, 0.02, speed=2.0, method="constraint", points=3).joint_position,
        pp.simulate_batch(press, 0.1, speed=np.array([2.0, 3.0]), points=3).crank_angle,
        pp.dead_centres(press),
        pp.sweeps.operating_points(press, [5.0, 7.0], forces=[0.0, 1e3], unit_load=DRAWING, points=8),
    )


@pytest.fixture(scope="module", params=["zxn2_3000b", "jf75g_125_symmetric"])
def press(request):
    return pp.load(request.param)


def test_results_do_not_depend_on_what_was_computed_before(press):
    used = pp.load(press.name)
    pp.dead_centres(used)
    pp.simulate(used, 0.3, speed=-5.0, angle=2.0, points=7)
    pp.inverse_dynamics(used, pp.servo_cycle(used, speed=3.0, angle=np.array([9.0, -4.0, 0.3])), engine="pinocchio")
    pp.simulate(used, 0.05, speed=3.0, loads=[DRAWING], points=7)
    same(computed(used), computed(pp.load(press.name)))


@pytest.mark.parametrize("start", ["fork", "spawn"])
def test_other_processes_find_the_same(start):
    """A worker that gets the press, with what it has kept, and one that imports all anew."""
    press = pp.load("zxn2_3000b")
    with ProcessPoolExecutor(1, multiprocessing.get_context(start)) as pool:
        same(pool.submit(computed, press).result(20), computed(press))


def test_scenarios_that_were_sent_are_simulated_once_more():
    sent = WAYS["pickle"](every_result.runs())
    same(sent[0].joint_position, every_result.runs()[0].joint_position)
