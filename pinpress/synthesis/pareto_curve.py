"""Trade-off between two objectives of a synthesis: designs that no other design beats in both objectives (their Pareto curve).

Each design is an optimum of `synthesise`: the first objective is minimised under a limit of the second. This epsilon-constraint method
(Y. Y. Haimes et al., IEEE Transactions on Systems, Man, and Cybernetics 1 (1971) 296-297) finds designs on concave parts of the curve too,
which weighted sums miss.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..common.arguments import typed, whole_number
from ..common.errors import PinpressError, PinpressWarning, shown
from ..common.quantities import Array
from ..common.results import Tabular
from ..derivatives.motion import Pivots
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .problem import Function
from .synthesis import UNCONSTRAINED, SynthesisResult, local_optimum, state_problem, synthesise

FIRST, SECOND = "first objective", "second objective"  # names of constraints
GIVEN = 1e-4  # an end of the curve may be worse than the best by this share of the curve's range, to improve the other objective
SAME = 1e-7  # a smaller relative difference between both ends is rounding error: the objectives do not conflict


@dataclass(frozen=True, eq=False, repr=False)
class DesignTradeOff(Tabular):
    """Presses on the Pareto curve of two objectives: a design that is better in one objective is worse in the other.

    Attributes:
        designs: the designs, from the best in the first objective to the best in the second; one design if the objectives do not conflict.
        values: (designs, 2) values of both objectives, for an array its largest element [SI].
    """

    designs: tuple[SynthesisResult, ...]
    values: Array

    @property
    def title(self) -> str:
        first, second = (f"{self.values[0, k]:.6g} to {self.values[-1, k]:.6g}" for k in (0, 1))
        name = self.designs[0].press.name
        return f"DesignTradeOff of {name}: {len(self.designs)} designs, first objective {first}, second {second}"

    @property
    def _pictured(self) -> tuple[str, ...]:
        return SECOND, FIRST

    def columns(self) -> dict[str, Array]:
        """A row for each design: both objectives and the variables, in SI units."""
        columns = {FIRST: self.values[:, 0], SECOND: self.values[:, 1]}
        return columns | {name: np.array([design.variables[name] for design in self.designs]) for name in self.designs[0].variables}


@typed
def trade_off(
    press: Linkage | str | os.PathLike[str],
    variables: Mapping[str, tuple[float, float, float]],
    *,
    first: Function,
    second: Function,
    subject_to: Mapping[str, tuple[Function, float | None, float | None]] = UNCONSTRAINED,
    geometry: Callable[..., Pivots] | None = None,
    speed: float,
    points: int | None = None,
    loads: Sequence[Load] = (),
    designs: int = 9,
) -> DesignTradeOff:
    """Find the trade-off between two objectives, from the least of one to the least of the other.

    Between the ends the first objective is minimised under equally spaced limits of the second. Each search starts from the design before
    and finds the optimum next to it. Use a constraint for a third objective.

    Args:
        press: a planar press, or the file of a pin table, as in `synthesise`.
        variables: name -> (lower bound, start, upper bound), as in `synthesise`.
        first: function of a `Trial` that returns a number, or an array (m,) whose largest element counts.
        second: the other objective, also a function of a `Trial`.
        subject_to: constraints on the whole curve, as in `synthesise`.
        geometry: function of the variables that returns pivots, as in `synthesise`.
        speed: speed of the crank [rad/s].
        points: number of crank angles of the period at which trials are evaluated; None: 360 a turn.
        loads: constant forces, and process loads with a datum.
        designs: number of designs, 2 to 1000.

    Raises:
        PinpressError: a constraint has the name of an objective, ``designs`` is out of range, or as `synthesise`.
        UnknownNameError: the linkage does not have a bearing or link with this name.
    """
    count = whole_number("designs", designs, 2, 1000)
    if not isinstance(subject_to, Mapping):
        raise PinpressError(f"subject_to is a {type(subject_to).__name__}: give a mapping from names")
    if taken := {FIRST, SECOND} & subject_to.keys():
        raise PinpressError(f"subject_to: {shown(min(taken))} is the name of an objective: give the constraint another name")
    objectives = {FIRST: (first, None, None), SECOND: (second, None, None)}
    common: dict[str, Any] = {"geometry": geometry, "speed": speed, "points": points, "loads": loads}
    ends = [
        synthesise(press, variables, minimise=objective, subject_to={**subject_to, **objectives}, **common) for objective in (first, second)
    ]

    def best(minimise: Function, start: Mapping[str, Any], limits: Mapping[str, Any]) -> SynthesisResult:
        # the search starts at an optimum, where slopes may be too small to compare them with difference quotients
        problem = state_problem(press, start, minimise, {**subject_to, **objectives, **limits}, geometry)
        with warnings.catch_warnings():  # the bound of an objective is the curve's, not the caller's
            warnings.filterwarnings("ignore", "constraint '(first|second) objective' misses its bound", PinpressWarning)
            return local_optimum(press, problem, speed, points, loads)

    at_first, at_second = (_values(end) for end in ends)
    # If an objective does not determine all variables, the other objective determines the rest.
    allowed = [low + GIVEN * max(high - low, SAME * abs(low)) for low, high in ((at_first[0], at_second[0]), (at_second[1], at_first[1]))]
    begin = best(second, _from(variables, ends[0]), {FIRST: (first, None, allowed[0])})
    curve = [best(first, _from(variables, ends[1]), {SECOND: (second, None, allowed[1])})]
    (_, high), (_, low) = _values(begin), _values(curve[0])
    if not high - low > SAME * max(abs(high), abs(low)):
        return _curve(curve)
    for limit in np.linspace(low, high, count)[1:-1].tolist():
        curve.append(best(first, _from(variables, curve[-1]), {SECOND: (second, None, limit)}))
    return _curve([begin, *curve[::-1]])


def _from(variables: Mapping[str, tuple[float, float, float]], found: SynthesisResult) -> dict[str, tuple[float, float, float]]:
    """The variables, with a design as their start."""
    return {name: (lower, min(max(found.variables[name], lower), upper), upper) for name, (lower, _, upper) in variables.items()}


def _values(found: SynthesisResult) -> tuple[float, float]:
    """Values of both objectives."""
    first, second = (float(np.max(found.constraints[name])) for name in (FIRST, SECOND))
    return first, second


def _curve(designs: Sequence[SynthesisResult]) -> DesignTradeOff:
    """The curve of the designs that no other design equals or beats in both objectives."""
    values = np.array([_values(design) for design in designs])
    kept = [k for k, (x, y) in enumerate(values) if not any((a <= x) & (b <= y) & ((a < x) | (b < y)) for a, b in values)]
    return DesignTradeOff(tuple(designs[k] for k in kept), values[kept])
