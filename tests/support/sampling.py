"""Of the many cases of one test a few are run by default, the others with the exhaustive tests."""

from collections import defaultdict
from collections.abc import Iterable
from typing import Any

import pytest


def rest_exhaustive(cases: Iterable[Any], *always: Any) -> list[Any]:
    """All cases of a test or a fixture, but that those not named here are exhaustive."""
    return [case if case in always else pytest.param(case, marks=pytest.mark.exhaustive) for case in cases]


def sample(items: list[pytest.Item]) -> None:
    """`pytest.mark.one_in(count)`: of a test's cases the first, and from there each ``count``-th, is not exhaustive."""
    seen: dict[str, int] = defaultdict(int)
    for item in items:
        every = item.get_closest_marker("one_in")
        if every is None or item.get_closest_marker("exhaustive") is not None:
            continue
        test = item.nodeid.partition("[")[0]
        if seen[test] % every.args[0]:
            item.add_marker(pytest.mark.exhaustive)
        seen[test] += 1
