"""Zhang 2007, 5.4: searches of the kinds that it names, next to the proved optimum of table 5-1's problem."""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import NamedTuple

import numpy as np
from validation.rows import Row
from validation.zhang2007_balancing import SEARCH, opposed, proved, ranges

from pinpress.common.quantities import Array
from pinpress.sweeps import full_factorial, latin_hypercube

MASSES = {"m5": (0.0, 150.0), "m6": (900.0, 1200.0)}  # of auxiliary rod and counterweight, within which is searched; ours [kg]
COUNT, LEVELS = 1000, 32  # points of a search at random; levels of each mass of one on a grid
FIRST_STEP, LAST_STEP = 16.0, 1e-4  # of the search along the coordinates [kg]
MOST_PASSES = 10_000
SPREAD = ("Monte Carlo", "Latin hypercube", "full factorial")  # searches whose points do not depend on what they reach
EVALUATIONS = dict(zip((*SPREAD, "step by step", "simplex"), (COUNT, COUNT, LEVELS**2, 117, 191), strict=True))


class Search(NamedTuple):
    """What a search has reached.

    Attributes:
        masses: (2,) of auxiliary rod and counterweight [kg].
        least: range of the vertical force with them [N].
        ranges: (k,) ranges of all masses tried, in their order [N].
    """

    masses: Array
    least: float
    ranges: Array

    @property
    def evaluations(self) -> int:
        """Number k of masses tried."""
        return len(self.ranges)


@cache
def all_searches() -> Mapping[str, Search]:
    return searches(ranges(opposed()))


def searches_rows() -> Iterator[Row]:
    for name, count in EVALUATIONS.items():
        yield Row(f"{name}, range after {count} evaluations [N]", "", lambda name=name: all_searches()[name].least, places=4)
    yield Row("simplex, m5 and m6 [kg]", "", lambda: ", ".join(f"{mass:.3f}" for mass in all_searches()["simplex"].masses))
    yield Row("proved optimum, range [N]", "", lambda: proved()[1], places=4)
    words = "masses of table 5-1 after its 17 steps, with our lengths, range [N]"
    yield Row(words, "", lambda: ranges(opposed())(np.array([SEARCH[-1][:2]]))[0], places=2)


def searches(objective: Callable[[Array], Array]) -> Mapping[str, Search]:
    """Searches of an objective, (k,) of masses (k, 2), by the names of their methods."""
    ends = {}
    for name in SPREAD:
        masses = tried(name)
        values = objective(masses)
        ends[name] = Search(masses[values.argmin()], float(values.min()), values)
    return ends | {"step by step": along_coordinates(objective), "simplex": by_simplex(objective)}


def tried(name: str) -> Array:
    """(k, 2) the masses that a search without steps tries [kg]."""
    if name == "full factorial":
        axes = full_factorial(MASSES, LEVELS)
        return np.array(np.meshgrid(*axes.values(), indexing="ij")).reshape(2, -1).T
    if name == "Latin hypercube":
        return np.array(list(latin_hypercube(MASSES, COUNT, seed=1).values())).T
    low, high = np.array(list(MASSES.values())).T
    return np.asarray(np.random.default_rng(1).uniform(low, high, (COUNT, 2)))


def along_coordinates(objective: Callable[[Array], Array]) -> Search:
    """Steps along one mass after the other from the start of table 5-1, halved where neither way leads down."""
    place, step = np.array(SEARCH[0][:2], dtype=float), FIRST_STEP
    value = float(objective(place[None])[0])
    ranges = [value]
    for _ in range(MOST_PASSES):
        before = value
        for way in step * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]):
            ranges.append(float(objective((place + way)[None])[0]))
            if ranges[-1] < value:
                place, value = place + way, ranges[-1]
        if value == before:
            step /= 2
        if step < LAST_STEP:
            break
    return Search(place, value, np.array(ranges))


def by_simplex(objective: Callable[[Array], Array]) -> Search:
    """The simplex method of SciPy from the start of table 5-1."""
    from scipy.optimize import minimize  # slow to import

    ranges: list[float] = []

    def called(masses: Array) -> float:
        ranges.append(float(objective(masses[None])[0]))
        return ranges[-1]

    options = {"xatol": LAST_STEP, "fatol": 1e-8, "maxfev": 100_000}
    best = minimize(called, np.array(SEARCH[0][:2], dtype=float), method="Nelder-Mead", options=options)
    return Search(best.x, float(best.fun), np.array(ranges))
