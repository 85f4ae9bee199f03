"""All reactions of a press with one driver as functions of the crank angle alone.

At a crank angle every reaction, and every rate of the slide, is exactly

    R = g + u a + v w^2 + d w + p1 P1 + ...

with the driver's acceleration a and speed w, and forces P on the links. Weights, springs and constant loads are in g, dampers and viscous
friction in d. The functions g, u, v, d and p are smooth. They are found from the engine itself, as differences of states, and kept as
polynomials, panel by panel (`dynamics.panels`). Of the driving torque u is the reduced inertia, v half its slope, and p of the process
force the slide's slope with the sign changed, so that

    a = (torque - g - v w^2 - d w - p P) / (u + J)

is the equation of motion, with an inertia J of flywheel and drive at the driver.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import suitable_numbers
from ..common.errors import PinpressError, UnknownNameError
from ..common.frozen import NamedArrays
from ..common.quantities import Array, DriverCoordinate, Values
from ..common.results import Tabular
from ..common.tables import Columns
from ..dynamics.panels import POWERS, Panels

STANDING, ACCELERATION, SQUARE, SPEED, FORCES = 0, 1, 2, 3, 4  # terms: g, u, v, d, and the first p
EXPONENTS = POWERS.astype(float)  # with whole numbers NumPy takes longer
PARTS, FEWER = 64, 5  # of a panel of 14 terms each 64th is exact to 1e-13 with 5 terms

Places: TypeAlias = NDArray[np.int64]


class Quantity(NamedTuple):
    """A number or vector of a press.

    Attributes:
        name: such as "driving_torque", "force_A".
        unit: SI unit.
        size: 1, or 3 for a vector in world axes.
    """

    name: str
    unit: str
    size: int

    @property
    def components(self) -> list[str]:
        """Names of its components."""
        return [self.name] if self.size == 1 else [f"{self.name}_{axis}" for axis in "xyz"]


class TableState(NamedTuple):
    """One state of a press from its table, or n states. Signs are those of `Motion` and `Reactions`.

    Attributes:
        table: the table.
        values: (components,) or (components, n), see `PressTable.components`.
    """

    table: PressTable
    values: Array

    @property
    def slide_position(self) -> Values:
        """One number or (n,) [m]."""
        return self._number("slide_position")

    @property
    def slide_velocity(self) -> Values:
        """One number or (n,) [m/s]."""
        return self._number("slide_velocity")

    @property
    def slide_acceleration(self) -> Values:
        """One number or (n,) [m/s2]."""
        return self._number("slide_acceleration")

    @property
    def driving_torque(self) -> Values:
        """One number or (n,) [N m], of a driver that slides [N]."""
        return self._number("driving_torque")

    @property
    def shaking_force(self) -> Array:
        """(3,) or (n, 3) [N]."""
        return self._vectors(self.table._places("shaking_force"))

    @property
    def shaking_moment(self) -> Array:
        """(3,) or (n, 3) about the world origin [N m]."""
        return self._vectors(self.table._places("shaking_moment"))

    @property
    def bearing_force(self) -> NamedArrays[np.float64]:
        """(3,) or (n, 3) by the names of the bearings [N]."""
        return NamedArrays(self.table.bearings, self._vectors(self.table._force_places))

    @property
    def bearing_moment(self) -> NamedArrays[np.float64]:
        """(3,) or (n, 3) by the names of the bearings [N m]."""
        return NamedArrays(self.table.bearings, self._vectors(self.table._moment_places))

    def _number(self, name: str) -> Values:
        number: Any = self.values[self.table._places(name)[0]]
        return number if number.ndim else float(number)

    def _vectors(self, places: Places) -> Array:
        vectors: Array = self.values[places]
        return vectors if self.values.ndim == 1 else vectors.swapaxes(-1, -2)


@dataclass(frozen=True, eq=False, repr=False)
class PressTable(Tabular):
    """A press with one driver as functions of its driver's position; made by `tabulate`. It can be pickled.

    Attributes:
        press_name: name of the press.
        origin: rows of what the table is made from: press, file, loads, version.
        coordinate: what the driver's position is: a crank angle [rad], or the position of a driver that slides [m].
        inputs: names of the forces P, as `at` takes them.
        bearings: names of the bearings and guides whose force and moment the table has.
        quantities: all that the table has.
        components: names of the components that are not zero throughout.
        functions: panels of polynomials; their rows are the terms g, u, v, d, p1 ..., each of all `components` and of one more
            that is zero.
        tolerance: share of the largest value of a quantity that polynomials were allowed to miss.
        error: name of a quantity -> largest difference from the engine in the compared states, as a share of its largest value there [-].
            It is the largest of a number of states, not a bound.
        compared: number of these states, at random speeds, accelerations and forces between the nodes of the polynomials.
        largest: name of a quantity -> its largest value in these states, in its unit.
    """

    press_name: str
    origin: tuple[tuple[str, str], ...]
    coordinate: DriverCoordinate
    inputs: tuple[str, ...]
    bearings: tuple[str, ...]
    quantities: tuple[Quantity, ...]
    components: tuple[str, ...]
    functions: Panels
    tolerance: float
    error: Mapping[str, float]
    compared: int
    largest: Mapping[str, float]

    @property
    def title(self) -> str:
        parts = [(len(self.bearings), "bearing"), (len(self.components), "component"), (len(self.functions.borders) - 1, "panel")]
        counted = ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for count, what in parts)
        return f"PressTable of {self.press_name}: {counted}, largest error found {max(self.error.values()):.1g}"

    def columns(self) -> Columns:
        """A row for each quantity: its largest value in the compared states, and the largest error there."""
        return {
            "quantity": [each.name for each in self.quantities],
            "largest": [self.largest[each.name] for each in self.quantities],
            "unit": [each.unit for each in self.quantities],
            "error [-]": [self.error[each.name] for each in self.quantities],
        }

    def at(self, angle: Values, speed: Values, acceleration: Values = 0.0, **inputs: Values) -> TableState:
        """The press in one state, or in n.

        Args:
            angle: position of the driver, any number of turns: one number, or (n,) [rad or m].
            speed: of the driver [rad/s or m/s].
            acceleration: of the driver [rad/s2 or m/s2].
            inputs: the forces by their names, 0 by default; ``force`` is the process force on the slide [N], and resists the working
                stroke where it is positive.

        Raises:
            PinpressError: the driver does not reach a position; a number is not finite.
            UnknownNameError: an input that the table does not have.
        """
        for name in inputs:
            if name not in self.inputs:
                raise UnknownNameError("input", name, self.inputs)
        try:
            weights: list[Any] = [1.0, acceleration, speed * speed, speed, *(inputs.get(name, 0.0) for name in self.inputs)]
            size = sum(weights, angle)
        except (TypeError, ValueError):  # of lists, of arrays of several shapes
            size = None
        if not isinstance(size, float):
            return self._at_several(angle, speed, acceleration, inputs)
        if not math.isfinite(size):
            raise PinpressError(f"the state of {self.press_name} is not finite: give finite angle, speed, acceleration and inputs")
        panel, _, x = self.functions.panel_of(self._local(float(angle)))
        rows = np.dot(x**EXPONENTS, self._by_panel[panel])
        return TableState(self, np.dot(weights, rows.reshape(len(weights), -1)))

    def acceleration(self, angle: float, speed: float, torque: float, force: float = 0.0, added_inertia: float = 0.0) -> float:
        """Acceleration of the driver [rad/s2 or m/s2] in one state: the equation of motion.

        Args:
            angle: position of the driver [rad or m].
            speed: of the driver [rad/s or m/s].
            torque: on the driver [N m], on one that slides a force [N].
            force: the first of the `inputs`, the process force on the slide unless others were given.
            added_inertia: inertia of flywheel and drive at the driver [kg m2 or kg].

        Raises:
            PinpressError: the driver does not reach the position; an argument is no finite number; no mass resists the torque.
        """
        edges, middles, rows = self._equation
        try:
            place = self._local(angle)
            part = min(bisect_right(edges, place), len(middles)) - 1
            x, square = place - middles[part], speed * speed
            opposed = inertia = 0.0
            for g, u, v, d, p in rows[part]:
                opposed = opposed * x + (g + v * square + d * speed + p * force)
                inertia = inertia * x + u
            moved, surplus = inertia + added_inertia, torque - opposed
            if moved > 0.0 and math.isfinite(surplus):
                return surplus / moved
        except (TypeError, ValueError):  # words, arrays
            raise PinpressError(f"the state of {self.press_name} is no single one: give numbers; `at` takes arrays") from None
        raise PinpressError(
            f"{self.press_name} has no acceleration at {self.coordinate.at(angle)}: give finite speed, torque and force, and an"
            " added_inertia where its links have no mass"
        )

    def _at_several(self, angle: Values, speed: Values, acceleration: Values, inputs: Mapping[str, Values]) -> TableState:
        given = [angle, speed, acceleration, *(inputs.get(name, 0.0) for name in self.inputs)]
        try:
            columns = np.broadcast_arrays(*given)
        except ValueError:
            shapes = ", ".join(str(np.shape(each)) for each in given)
            raise PinpressError(f"angle, speed, acceleration and inputs have shapes {shapes}: give one number or (n,) each") from None
        several = [np.atleast_1d(each) for each in columns]
        angles, speeds, accelerations, *forces = suitable_numbers("the state", several, "finite numbers, one or (n,) each", (None, None))
        if columns[0].ndim == 0:  # numbers that are no floats
            return self.at(
                angles.item(), speeds.item(), accelerations.item(), **{n: p.item() for n, p in zip(self.inputs, forces, strict=True)}
            )
        weights = np.array([np.ones(len(angles)), accelerations, speeds**2, speeds, *forces])
        local = np.array([self._local(each) for each in angles.tolist()])
        rows = self.functions.at(local, derivative=False)[0].reshape(len(weights), -1, len(local))
        return TableState(self, np.einsum("tn,tcn->cn", weights, rows))

    def _local(self, angle: float) -> float:
        """A position moved by whole periods into the range of the table."""
        low, high = self._range
        if self.functions.period is not None and math.isfinite(angle):
            return angle - math.floor((angle - low) / self.functions.period) * self.functions.period
        if not low <= angle <= high:
            ends = f"{low * self.coordinate.scale:.6g} to {self.coordinate.shown(high)}"
            raise PinpressError(
                f"{self.press_name} is not tabulated at {self.coordinate.at(angle)}: its driver goes from {ends}; stay within that"
            )
        return angle

    def _places(self, name: str) -> Places:
        """Where the components of a quantity are among the values; the last place, which is zero, for those that are zero throughout."""
        try:
            return self._slots[name]
        except KeyError:
            raise PinpressError(f"the table of {self.press_name} has no {name}: {_REMEDIES[name]}") from None

    @cached_property
    def _slots(self) -> dict[str, Places]:
        place = {name: k for k, name in enumerate(self.components)}
        return {each.name: np.array([place.get(name, len(place)) for name in each.components]) for each in self.quantities}

    @cached_property
    def _force_places(self) -> Places:
        return np.reshape([self._slots[f"force_{name}"] for name in self.bearings], (-1, 3)).astype(int)

    @cached_property
    def _moment_places(self) -> Places:
        return np.reshape([self._slots[f"moment_{name}"] for name in self.bearings], (-1, 3)).astype(int)

    @cached_property
    def _range(self) -> tuple[float, float]:
        return float(self.functions.borders[0]), float(self.functions.borders[-1])

    @cached_property
    def _by_panel(self) -> list[Array]:
        """(q, rows) coefficients of rising powers of each panel."""
        return [np.ascontiguousarray(panel.T) for panel in self.functions.coefficients]

    @cached_property
    def _equation(self) -> tuple[list[float], list[float], list[list[tuple[float, ...]]]]:
        """The terms g, u, v, d and the first p of the driving torque as falling powers of the distance from the middle of parts of panels.

        One number takes less time on many parts with few powers. These are edges and middles of the parts, and for each part its powers.
        """
        torque = self.term_of("driving_torque")[:, : FORCES + 1]
        terms = np.zeros((len(torque), FORCES + 1, len(POWERS)))
        terms[:, : torque.shape[1]] = torque
        nodes, borders = np.polynomial.chebyshev.chebpts1(FEWER), self.functions.borders
        places = -1.0 + (2.0 * np.arange(PARTS)[:, None] + 1.0 + nodes) / PARTS
        refit = np.linalg.inv(np.vander(nodes)) @ (places[..., None] ** POWERS)  # (parts, fewer, q)
        edges = np.append(borders[:-1, None] + np.diff(borders)[:, None] * np.arange(PARTS) / PARTS, borders[-1])
        half = 0.5 * np.diff(edges)
        by_part = np.einsum("kfq,ptq->pkft", refit, terms).reshape(len(half), FEWER, FORCES + 1)
        rows = by_part / half[:, None, None] ** np.arange(FEWER)[::-1, None]
        return edges.tolist(), (edges[:-1] + half).tolist(), [list(map(tuple, each)) for each in rows.tolist()]

    def term_of(self, component: str) -> Array:
        """(p, terms, q) coefficients of the functions of a component, of rising powers."""
        by_term = self.functions.coefficients.reshape(len(self.functions.borders) - 1, FORCES + len(self.inputs), -1, len(POWERS))
        return np.asarray(by_term[:, :, self.components.index(component)])


_REMEDIES = {
    **dict.fromkeys(("shaking_force", "shaking_moment"), "tabulate it with bearings, or without bearings=() for all"),
    **dict.fromkeys(("slide_position", "slide_velocity", "slide_acceleration"), "the press has no slide"),
}
