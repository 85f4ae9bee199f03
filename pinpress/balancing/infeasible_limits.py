"""Which of a problem's limits contradict one another, where no counterweights fulfil them all."""

from collections.abc import Mapping

from .objectives import Target
from .problem import Problem
from .program import relaxed

INVOLVED = 1e-6  # of all: a limit with a smaller part in the contradiction has none


def contradiction(problem: Problem, limits: Mapping[Target, float]) -> str:
    """In words: the limits that cannot be met together, and what the least common excess is.

    All limits are let out by the same share of their measures before balancing (masses: of their own size), the least that makes them
    possible; those whose dual variables are then not zero are the ones that stand against one another.
    """
    excess, prices = relaxed(problem, limits)
    names = list(dict.fromkeys(name for name, price in prices if price > INVOLVED)) or [name for name, _ in prices]
    return (
        f"no counterweights in these rooms fulfil {' and '.join(f'the {name}' for name in names)}: they would if each were let out by"
        f" {100 * excess:.3g} % (of its measure before balancing; of a mass, of itself or the moving mass); allow more, or give more room"
    )
