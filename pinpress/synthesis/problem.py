"""A synthesis as a mathematical problem: objective and limits over scaled variables, with their exact gradients.

Variables are scaled to 0 at the lower and 1 at the upper bound. The objective and every constraint are scaled by their size at the start.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..common.errors import AssemblyError, PinpressError, shown
from ..common.quantities import Array
from ..derivatives.motion import STEP, Displacements, Pivots, directed, displaced
from .design import Design, Trial
from .table_variables import TableVariables

Function = Callable[[Trial], ArrayLike]


@dataclass(frozen=True)
class Variable:
    """A design variable.

    Attributes:
        name: name of the geometry's argument.
        lower: lower bound [SI].
        start: value at the start [SI].
        upper: upper bound [SI].
    """

    name: str
    lower: float
    start: float
    upper: float

    @property
    def range(self) -> float:
        """Upper bound - lower bound, which scales the variable; one if both are equal [SI]."""
        return (self.upper - self.lower) or 1.0


@dataclass(frozen=True, eq=False)
class Requirement:
    """A function of a trial: the objective or a constraint.

    Attributes:
        name: name of the constraint; empty for the objective.
        function: function of a `Trial`.
        lower: lower bound of the constraint [SI].
        upper: upper bound of the constraint [SI].
        scale: size that divides the values [SI].
    """

    name: str
    function: Function
    lower: float = -np.inf
    upper: float = np.inf
    scale: float = 1.0

    @property
    def title(self) -> str:
        """Name in messages."""
        return f"constraint {shown(self.name)}" if self.name else "the objective"

    def of(self, trial: Trial) -> Array:
        """The elements (m,) for a trial, complex for a complex trial.

        Raises:
            PinpressError: the function fails, or does not return finite numbers.
        """
        try:
            values = np.atleast_1d(np.asarray(self.function(trial)))
        except TypeError as error:
            raise PinpressError(f"{self.title} cannot be computed: {error}; see `Trial` for how to write it") from error
        if values.ndim != 1 or not values.size or values.dtype.kind not in "fciu":
            raise PinpressError(f"{self.title} returns {values.dtype} of shape {values.shape}: return a number, or an array (m,)")
        if not np.isfinite(values).all():
            raise PinpressError(
                f"{self.title} is not finite with {listed(trial.variables)}: return finite numbers within the variables' bounds"
            )
        return values


@dataclass(frozen=True)
class Limit:
    """A bound of a constraint.

    Attributes:
        requirement: index in `Problem.requirements`, in which constraints start at 1.
        side: "lower", "upper" or "equal".
        bound: the bound [SI].
    """

    requirement: int
    side: str
    bound: float

    @property
    def sign(self) -> float:
        """Sign of value - bound if the bound is kept."""
        return -1.0 if self.side == "upper" else 1.0


@dataclass(frozen=True, eq=False)
class Problem:
    """Variables, geometry, objective and constraints of a synthesis.

    Attributes:
        variables: the design variables.
        geometry: function of the variables that returns pivots.
        requirements: the objective, then the constraints.
        table: the pin table whose numbers the variables are; None: they are lengths and pivots of a press.
    """

    variables: tuple[Variable, ...]
    geometry: Callable[..., Pivots]
    requirements: tuple[Requirement, ...]
    table: TableVariables | None = None

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """All bounds of all constraints."""
        limits = []
        for k, requirement in enumerate(self.requirements[1:], 1):
            if requirement.lower == requirement.upper:
                limits.append(Limit(k, "equal", requirement.lower))
                continue
            limits += [Limit(k, "lower", requirement.lower)] * bool(np.isfinite(requirement.lower))
            limits += [Limit(k, "upper", requirement.upper)] * bool(np.isfinite(requirement.upper))
        return tuple(limits)

    def values(self, z: Array) -> dict[str, float]:
        """Name -> value of each variable, from scaled variables (k,) [SI]."""
        return {v.name: float(v.lower * (1.0 - share) + v.upper * share) for v, share in zip(self.variables, z, strict=True)}

    def scaled(self, values: Mapping[str, float]) -> Array:
        """Scaled variables (k,) from values by name [-]."""
        return np.array([(values[v.name] - v.lower) / v.range for v in self.variables])

    def at(self, z: Array, near: Design) -> "Point":
        """Objective and constraints at scaled variables (k,), in the assembly continued from a design nearby.

        Raises:
            AssemblyError: the geometry has a NaN, or cannot be assembled.
            SingularityError: two assemblies meet on the way there.
            PinpressError: a function fails.
        """
        values = self.values(z)
        press = near.start.press
        pivots = self.pivots(values)
        if any(np.asarray(position).dtype.kind == "f" and np.isnan(position).any() for position in pivots.values()):
            raise AssemblyError("the geometry is NaN for these variables", 0.0, np.inf, 0)  # e.g. the root of a negative number
        moved = displaced(press, pivots)
        design = near.next(values, moved, [self._slope(near, values, v.name) for v in self.variables])
        trial = design.trial()
        return Point(self, z.copy(), design, tuple(np.real(requirement.of(trial)).astype(float) for requirement in self.requirements))

    def _slope(self, near: Design, values: dict[str, float], name: str) -> Displacements:
        """The derivative of the displacements by a variable."""
        pivots = self.pivots(values | {name: values[name] + 1j * STEP})
        return directed(near.start.press, {key: np.imag(np.asarray(position, dtype=complex)) / STEP for key, position in pivots.items()})

    def pivots(self, values: Mapping[str, Any]) -> Pivots:
        """The pivots at values by name.

        Raises:
            PinpressError: the geometry fails, or does not return a mapping.
        """
        try:
            pivots = self.geometry(**values)
        except TypeError as error:
            raise PinpressError(f"geometry cannot be called with {', '.join(values)}: {error}; write it with NumPy's functions") from error
        if not isinstance(pivots, Mapping):
            raise PinpressError("geometry does not return a mapping: return {(bearing, link): (x, y, z)}, in the links' own frames [m]")
        return pivots


@dataclass(frozen=True, eq=False)
class Point:
    """A problem at one set of variables.

    Attributes:
        problem: the problem.
        z: (k,) scaled variables.
        design: the design with these variables.
        values: elements (m,) of every requirement [SI].
    """

    problem: Problem
    z: Array
    design: Design
    values: tuple[Array, ...]

    @cached_property
    def slopes(self) -> tuple[Array, ...]:
        """Derivatives (m, k) of every requirement by the scaled variables.

        Raises:
            PinpressError: a function fails for complex numbers, or returns another number of elements than for real numbers.
        """
        variables = self.problem.variables
        trials = [self.design.trial_towards(place, variable.range) for place, variable in enumerate(variables)]
        result = []
        for requirement, values in zip(self.problem.requirements, self.values, strict=True):
            columns = [np.imag(requirement.of(trial)) / STEP for trial in trials]
            if any(column.shape != values.shape for column in columns):
                raise PinpressError(
                    f"{requirement.title} returns another number of elements for complex numbers: write it as `Trial` describes"
                )
            result.append(np.stack(columns, axis=1))
        return tuple(result)

    @property
    def objective(self) -> float:
        """The largest element of the objective, which the search minimises [SI]."""
        return float(self.values[0].max())

    def slacks(self, limit: Limit) -> Array:
        """Scaled slacks (m,) of a bound, negative if the bound is missed; for an equation the differences."""
        return np.asarray(limit.sign * (self.values[limit.requirement] - limit.bound) / self.problem.requirements[limit.requirement].scale)

    def slack_slopes(self, limit: Limit) -> Array:
        """Derivatives (m, k) of the scaled slacks by the scaled variables."""
        return np.asarray(limit.sign * self.slopes[limit.requirement] / self.problem.requirements[limit.requirement].scale)

    def violation(self, limit: Limit) -> float:
        """Scaled amount by which a bound is missed; 0 if it is kept."""
        slacks = self.slacks(limit)
        return float(np.abs(slacks).max() if limit.side == "equal" else max(0.0, -slacks.min()))

    @property
    def widest_violation(self) -> float:
        """Scaled amount by which the worst bound is missed."""
        return max((self.violation(limit) for limit in self.problem.limits), default=0.0)


def missed(point: Point) -> str:
    """A text with the constraints whose bounds are missed, the worst first."""
    words = []
    for limit in sorted(point.problem.limits, key=lambda limit: -point.violation(limit)):
        requirement, violation = point.problem.requirements[limit.requirement], point.violation(limit)
        bound = "value" if limit.side == "equal" else f"{limit.side} bound"
        if violation > 0:
            words.append(f"{requirement.title} misses its {bound} {limit.bound:g} by {violation * requirement.scale:.4g}")
    return ", ".join(words)


def verify_gradients(point: Point, directions: Sequence[Array]) -> None:
    """Check the gradients of all requirements against differences of their values.

    Args:
        point: the point of the check.
        directions: directions (k,) of the scaled variables for both derivatives.

    Raises:
        PinpressError: a function's gradient differs from the difference quotients of its values.
    """
    problem = point.problem
    for direction in directions:
        wrong = list(range(len(problem.requirements)))
        for step in (1e-6, 1e-5, 1e-7):  # the second and third are tried if the first meets a kink
            ahead, back = (problem.at(point.z + sign * step * direction, point.design) for sign in (1.0, -1.0))
            wrong = [k for k in wrong if not _agrees(point, k, direction, (ahead.values[k] - back.values[k]) / (2 * step))]
            if not wrong:
                break
        else:
            raise PinpressError(
                f"{problem.requirements[wrong[0]].title} has a gradient that differs from its values: it removes the imaginary part of"
                " complex numbers, or jumps at the start; see `Trial` for how to write it"
            )


def _agrees(point: Point, requirement: int, direction: Array, difference: Array) -> bool:
    exact, values = point.slopes[requirement] @ direction, point.values[requirement]
    size = max(np.abs(exact).max(), np.abs(difference).max())
    return bool(np.abs(exact - difference).max() <= 1e-3 * size + 1e-6 * np.abs(values).max())  # the latter is rounding error


def listed(variables: Mapping[str, float]) -> str:
    """Names and values of variables as text."""
    return ", ".join(f"{name} = {np.real(value):.6g}" for name, value in variables.items())
