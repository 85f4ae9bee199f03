"""What sweeps, experiments and operating points refuse, each with its message: a table of (call, message)."""

from functools import partial

import numpy as np
import pytest
from support import texts
from support.generators.small_linkages import two_cranks
from support.sweep_points import product

import pinpress as pp
from pinpress.sweeps import full_factorial, latin_hypercube, operating_points, sweep

GRID = {"a": [3, 1, 2], "b": np.array([0.5, 4.0])}
RANGES = {"a": (0.0, 1.0), "b": (0.0, 1.0)}
SPRING = pp.loads.SpringDamper("frame", "slide", stiffness=2e5, free_length=0.4, point1=(0, 0, 0.5))
DAMPER = pp.loads.SpringDamper("frame", "slide", damping=1e4, point1=(0, 0, 0.5))
PUSH = pp.loads.PointForce("coupler", (0.2, 0.0, 0.0), (0.5, 0, 0))
BRAKING = pp.loads.PointForce("slide", lambda motion: np.outer(motion.slide_velocity, (0.0, 0.0, -1.0)))


def swept(**arguments):
    return sweep(**{"function": product, "grid": GRID} | arguments)


def returning(columns):
    """A sweep of a function of many points that returns these columns."""
    return sweep(lambda k: columns, {"k": [1, 2]}, at_once=True)


def points_of(**arguments):
    given = {"press": texts.shipped("zxn2_3000b"), "speeds": [1.0, 5.0], "forces": [0.0, 1e6], "unit_load": PUSH}
    return operating_points(**given | arguments)


REFUSALS = [
    (lambda: swept(function=3), "function is 3"),
    (lambda: swept(grid={}), "grid: give a mapping"),
    (lambda: swept(grid={"a": [1], "c": [2]}), "does not take the axes a, c"),
    (lambda: swept(grid={"a": [1]}), "missing a required argument: 'b'"),
    (lambda: swept(grid={"a": [], "b": [1]}), "axis 'a' has no values"),
    (lambda: swept(grid={"a": [np.inf], "b": [1]}), "not finite"),
    (lambda: swept(grid={"a": [1, 1.0], "b": [1]}), "twice"),
    (lambda: swept(grid={"a": [[1]], "b": [1]}), "objects under labels"),
    (lambda: swept(grid={"a": "xyz", "b": [1]}), "give a sequence"),
    (lambda: swept(grid={"a": np.ones((2, 2)), "b": [1]}), "give a sequence"),
    (lambda: swept(grid={"error": [1]}), "cannot be an axis"),
    (lambda: swept(grid={"a": [1, 2], "b": [1]}, paired=True), "equally long"),
    (lambda: swept(to="results.csv"), r"write 'results\.sqlite'; a CSV or Parquet file is written"),
    (lambda: swept(to="runs"), r"write 'runs\.sqlite'"),
    (lambda: swept(to="no/such/folder/r.sqlite"), "cannot write no/such/folder/r.sqlite: unable to open"),
    (lambda: swept(to=5), "cannot write 5"),
    (lambda: swept(executor=4), "executor is 4"),
    (lambda: swept(in_flight=0), "in_flight is 0"),
    (lambda: swept(progress=1), "progress is 1"),
    (lambda: sweep(lambda a: {"a": a}, {"a": [1]}), "the name of an axis"),
    (lambda: sweep(lambda k: {f"x{j}": j for j in range(2000)}, {"k": [1]}), "returns 2000 values: return at most 1900"),
    (lambda: swept(to="/proc/r.sqlite"), "cannot write /proc/r.sqlite"),
    (lambda: swept(to="/sys/kernel/r.sqlite"), "cannot write /sys/kernel/r.sqlite"),
    (lambda: pp.sweeps.read("no/such/other.sqlite"), "there is no file"),
    (lambda: swept(at_once=True, grid={"a": [1, "x"], "b": [1]}), "labels of axis 'a' are of several kinds"),
    (lambda: swept(at_once=0), "at_once is 0"),
    (lambda: swept(at_once="all"), "at_once is 'all': give True, False, or the number of points"),
    (lambda: swept(at_once=True, to="runs"), r"write 'runs\.sqlite'"),
    (lambda: swept(at_once=True, grid={"a": [1]}), "missing a required argument: 'b'"),
    (lambda: returning(3.0), "returned 3.0; return a mapping of names to a value for each point"),
    (lambda: returning({}), "return a mapping"),
    (lambda: returning({"x": 1.0}), "returned 1.0 under 'x'; return one value for each of the 2 points"),
    (lambda: returning({"x": np.ones(3)}), r"shape \(3,\) under 'x'"),
    (lambda: returning({"x": np.ones((2, 2))}), r"shape \(2, 2\)"),
    (lambda: returning({"x": "ab"}), "return one value for each"),
    (lambda: returning({"x": [1.0, "a"]}), "numbers and words under 'x'; return values of one kind"),
    (lambda: returning({"k": np.ones(2)}), "the name of an axis"),
    (lambda: returning({"point": np.ones(2)}), "name them by a word other than"),
    (lambda: returning({"\ud800": np.ones(2)}), "name them by a word other than"),
    (lambda: returning({"x": np.ones(2), "error": "bad"}), "under 'error'; return for each of the 2 points"),
    (lambda: returning({"error": [None, "bad"]}), "only errors, but some points have no error"),
    (lambda: latin_hypercube({}, 5), "ranges is"),
    (lambda: latin_hypercube([("a", (0, 1))], 5), "ranges"),
    (lambda: latin_hypercube({"": (0, 1)}, 5), "not a name of an argument; give texts"),
    (lambda: full_factorial({"": (0, 1)}, 3), "not a name of an argument; give texts"),
    (lambda: latin_hypercube({3: (0, 1)}, 5), "3 is not a name"),
    (lambda: latin_hypercube({"a": 5.0}, 5), r"'a' is 5\.0; give its lowest and highest value"),
    (lambda: full_factorial({"a": 5.0}, 3), r"'a' is 5\.0; give its lowest and highest value"),
    (lambda: latin_hypercube({"a": (0, 1, 2)}, 5), "give its lowest and highest value"),
    (lambda: full_factorial({"a": (0, 1, 2)}, 3), "give its lowest and highest value"),
    (lambda: latin_hypercube({"a": (1.0, 1.0)}, 5), "from 1 to 1; give the lower end first"),
    (lambda: full_factorial({"a": (1.0, 1.0)}, 3), "from 1 to 1; give the lower end first"),
    (lambda: latin_hypercube({"a": (2.0, 1.0)}, 5), "give the lower end first"),
    (lambda: full_factorial({"a": (2.0, 1.0)}, 3), "give the lower end first"),
    (lambda: latin_hypercube({"a": (0.0, np.inf)}, 5), "range of 'a' is inf"),
    (lambda: full_factorial({"a": (0.0, np.inf)}, 3), "range of 'a' is inf"),
    (lambda: latin_hypercube({"a": ("0", 1.0)}, 5), "range of 'a' is '0'"),
    (lambda: full_factorial({"a": ("0", 1.0)}, 3), "range of 'a' is '0'"),
    *((partial(latin_hypercube, RANGES, count), "count") for count in (0, -3, 2.5, "5", 10**9)),
    *((partial(latin_hypercube, RANGES, 5, seed=seed), "seed") for seed in (-1, 0.5, "x")),
    *((partial(full_factorial, RANGES, levels), "levels") for levels in (1, 0, 1.5, "3", {"a": 1, "b": 2})),
    (lambda: full_factorial(RANGES, {"a": 3}), "levels: 'b' is missing"),
    (lambda: full_factorial(RANGES, {"a": 3, "b": 3, "c": 3}), "'c'"),
    (lambda: full_factorial(RANGES, 10**4), "100000000 combinations; give fewer than 10000000, or a latin_hypercube"),
    (lambda: points_of(press=3), "press is a int"),
    (lambda: points_of(speeds=[1.0, 0.0]), "only positive or only negative"),
    (lambda: points_of(speeds=[1.0, -1.0]), "only positive or only negative"),
    (lambda: points_of(speeds=[]), "speeds must be"),
    (lambda: points_of(speeds="fast"), "speeds is not a number or an array of numbers, but text: 'fast'"),
    (lambda: points_of(forces=[np.nan]), "forces is not finite at point 0"),
    (lambda: points_of(forces=[[1.0]]), "forces must be"),
    (lambda: points_of(unit_load=()), "which is missing"),
    (lambda: points_of(unit_load=SPRING), "no amplitude"),
    (lambda: points_of(unit_load=pp.loads.TimeForce(lambda time: 1.0)), "depends on time"),
    (lambda: points_of(unit_load=BRAKING), "is not affine in the square of the speed"),
    (lambda: points_of(unit_load=pp.loads.ElasticDie(0.02, 1.0, damping=0.1)), "is not affine in the square of the speed"),
    (lambda: points_of(unit_load=pp.loads.ElasticDie(0.02, 1.0), forces=[-1e8, 1e8]), "not proportional to its amplitude"),
    (lambda: points_of(unit_load=5), "load 5 is no load"),
    (lambda: points_of(loads=[DAMPER]), "is not affine in the square of the speed"),
    (lambda: points_of(loads=SPRING), "give a list"),
    (lambda: points_of(bearings=["Z"]), "no bearing 'Z'"),
    (lambda: points_of(points=1), "points"),
    (lambda: points_of(angles=1), "angles is 1"),
    (lambda: points_of(speeds=[1e160]), "too "),
    (lambda: operating_points(two_cranks(), [7.0]), "geared has 2 drivers: operating points need a press with one driver"),
]


@pytest.mark.filterwarnings("ignore:.*rad/s, .* r/min:pinpress.PinpressWarning")
@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message for _, message in REFUSALS])
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()
