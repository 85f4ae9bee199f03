"""Experiments: levels and Latin hypercubes, their margins, reproducibility and refusals, and a sweep filled by them."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest
from support.exploring import examples

import pinpress as pp

ends = st.tuples(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6)).map(lambda pair: (pair[0], pair[0] + pair[1]))


@given(ranges=st.dictionaries(st.sampled_from("abcde"), ends, min_size=1), count=st.integers(1, 60), seed=st.integers(0, 2**63 - 1))
@examples(30)
def test_every_part_of_every_range_has_one_point(ranges, count, seed):
    """Bins by exact whole numbers, but for points that rounding of large ends moves across a border."""
    points = pp.sweeps.latin_hypercube(ranges, count, seed=seed)
    assert list(points) == list(ranges)
    for name, (low, high) in ranges.items():
        values = np.array(points[name])
        assert values.min() >= low - 1e-9 * abs(low)
        assert values.max() <= high + 1e-9 * abs(high)
        share = (np.sort(values) - low) / (high - low) * count
        slack = 4e-16 * max(abs(low), abs(high)) / (high - low) * count
        assert (share >= np.arange(count) - slack).all()
        assert (share <= np.arange(1, count + 1) + slack).all()


def test_points_are_uniform_and_the_arguments_independent():
    points = pp.sweeps.latin_hypercube({"a": (2.0, 5.0), "b": (-1.0, 0.0)}, 4000, seed=3)
    a, b = (np.array(points[name]) for name in "ab")
    assert kstest((a - 2) / 3, "uniform").statistic <= 1 / 4000 + 1e-12  # one in each part: no more than that from the diagonal
    assert abs(np.corrcoef(a, b)[0, 1]) < 4 / np.sqrt(4000)  # four deviations of independent ones
    inside = kstest(((a - 2) / 3 * 4000) % 1.0, "uniform")
    assert inside.pvalue > 1e-3  # at random within the parts


def test_a_seed_gives_the_same_points_again():
    ranges = {"a": (0.0, 1.0), "b": (0.0, 1.0)}
    one, again, other = (pp.sweeps.latin_hypercube(ranges, 20, seed=seed) for seed in (5, 5, 6))
    assert one == again
    assert one != other
    assert pp.sweeps.latin_hypercube(ranges, 20) == pp.sweeps.latin_hypercube(ranges, 20, seed=0)


def test_means_scatter_less_than_those_of_random_points():
    """Of a sum of functions of one argument each a hypercube's mean scatters with 1/n^1.5, that of random points with 1/n^0.5."""
    n = 100
    means = []
    for seed in range(40):
        points = pp.sweeps.latin_hypercube({"x": (0.0, 1.0), "y": (0.0, 1.0)}, n, seed=seed)
        means.append(np.mean(np.square(points["x"]) + np.exp(points["y"])))
    random = np.hypot(np.sqrt(4 / 45), np.sqrt((np.e**2 - 1) / 2 - (np.e - 1) ** 2)) / np.sqrt(n)
    assert np.mean(means) == pytest.approx(1 / 3 + np.e - 1, abs=1e-3)
    assert np.std(means) < random / 20


def test_levels_are_equally_spaced_and_combine():
    axes = pp.sweeps.full_factorial({"a": (0.0, 4.0), "b": (-1.0, 1.0)}, {"a": 5, "b": 2})
    assert axes == {"a": (0.0, 1.0, 2.0, 3.0, 4.0), "b": (-1.0, 1.0)}
    table = pp.sweeps.sweep(lambda a, b: {"sum": a + b}, axes)
    assert table.column("sum").tolist() == [a + b for a, b in itertools.product(*axes.values())]
    assert pp.sweeps.full_factorial({"a": np.array([1.0, 2.0])}, 3)["a"] == (1.0, 1.5, 2.0)


def test_a_sweep_is_filled():
    points = pp.sweeps.latin_hypercube({"a": (0.0, 4.0), "b": (-1.0, 1.0)}, 7, seed=2)
    table = pp.sweeps.sweep(lambda a, b: {"sum": a + b}, points, paired=True)
    assert table.column("a").tolist() == list(points["a"])
    assert table.column("sum").tolist() == pytest.approx(np.add(points["a"], points["b"]))
