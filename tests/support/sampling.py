"""Of the many cases of one test a few are run by default, the others with the exhaustive tests."""

from collections import defaultdict
from collections.abc import Iterable
from math import isqrt
from typing import Any
from zlib import crc32

import pytest

IN_TURN = ("engine", "method")  # parameters whose values are ways to the same numbers


def rest_exhaustive(cases: Iterable[Any], *always: Any) -> list[Any]:
    """All cases of a test or a fixture, but that those not named here are exhaustive."""
    return [case if case in always else pytest.param(case, marks=pytest.mark.exhaustive) for case in cases]


def sample(items: list[pytest.Item]) -> None:
    """Marks cases as exhaustive.

    - Of a test by several engines or methods all but one, which differs from test to test: other tests compare them with each other.
    - Of n cases of a test all but the first, and from there each k-th: k is about the root of n, and odd, so that cases by two
      parameters take turns in both. `pytest.mark.one_in(k)` says another k.
    """
    ways: dict[tuple[str, str], list[str]] = defaultdict(list)
    for item in _short(items):
        for name, value in _ways(item):
            if value not in ways[_test(item), name]:
                ways[_test(item), name].append(value)
    for item in _short(items):
        for name, value in _ways(item):
            every = ways[_test(item), name]
            if value != every[crc32(_test(item).encode()) % len(every)]:
                item.add_marker(pytest.mark.exhaustive)
    cases: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in _short(items):
        cases[_test(item)].append(item)
    for same in cases.values():
        sparse = same[0].get_closest_marker("one_in")
        step = isqrt(len(same)) | 1 if sparse is None else sparse.args[0]
        for number, item in enumerate(same):
            if number % step:
                item.add_marker(pytest.mark.exhaustive)


def _short(items: list[pytest.Item]) -> list[pytest.Item]:
    return [item for item in items if item.get_closest_marker("exhaustive") is None]


def _test(item: pytest.Item) -> str:
    return item.nodeid.partition("[")[0]


def _ways(item: pytest.Item) -> list[tuple[str, str]]:
    """Names and values of the parameters of `IN_TURN`."""
    parameters = item.callspec.params if hasattr(item, "callspec") else {}
    return [(name, parameters[name]) for name in IN_TURN if isinstance(parameters.get(name), str)]
