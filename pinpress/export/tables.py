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
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import suitable_numbers, typed
from ..common.errors import PinpressError, UnknownNameError, cautions_collected, shown
from ..common.frozen import NamedArrays
from ..common.quantities import GRAVITY, Array, DriverCoordinate, Values
from ..common.results import Tabular
from ..common.tables import Columns
from ..dynamics.inputs import inputs as inputs_in_words
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.panels import POWERS, Panels, last_terms, resolve
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.link import Friction, LinkLoad, Load, PointForce, PointMoment, SpringDamper, TorsionSpring, is_constant
from ..loads.pneumatics import BalanceCylinder
from ..loads.process import TimeForce
from ..simulation.reduced_model import reduced_model_of

STANDING, ACCELERATION, SQUARE, SPEED, FORCES = 0, 1, 2, 3, 4  # terms: g, u, v, d, and the first p
AMPLE = 100.0  # how much larger than the weights inertia and forces are where functions are found: none is then lost in rounding error
FAINT = 1e-3  # share of the largest force below which a force counts as that large: rounding error of the largest one is in it
NOTHING = 1e-12  # share of the largest force below which a function is rounding error
LOCKED = 0.01  # share of the driver's range before a lock that is left out, as forces have no bounds there
FIRST_PANELS = 4  # of a turn, before they are halved
HALVINGS = 10  # most of these; with more a function has a jump
EXPONENTS = POWERS.astype(float)  # with whole numbers NumPy takes longer
PARTS, FEWER = 64, 5  # of a panel of 14 terms each 64th is as exact with 5 terms
PLACES = np.array([-0.93, -0.41, 0.13, 0.69])  # between the nodes of a panel, where the table is compared with the engine
TRUSTED = 1e-7  # error from which on something in the press is not as the functions have it

Input: TypeAlias = PointForce | PointMoment
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
            PinpressError: the driver does not reach the position; a number is not finite; no mass resists the torque.
        """
        edges, middles, rows = self._equation
        place = self._local(angle)
        part = min(bisect_right(edges, place), len(middles)) - 1
        x, square = place - middles[part], speed * speed
        opposed = inertia = 0.0
        for g, u, v, d, p in rows[part]:
            opposed = opposed * x + (g + v * square + d * speed + p * force)
            inertia = inertia * x + u
        moved, surplus = inertia + added_inertia, torque - opposed
        if not (moved > 0.0 and math.isfinite(surplus)):
            raise PinpressError(
                f"{self.press_name} has no acceleration at {self.coordinate.at(angle)}: give finite speed, torque and force, and an"
                " added_inertia where its links have no mass"
            )
        return surplus / moved

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


@typed
def tabulate(
    press: Linkage,
    bearings: Collection[str] | None = None,
    loads: Sequence[Load] = (),
    inputs: Mapping[str, Input | None] | None = None,
    tolerance: float = 1e-9,
    friction: Mapping[str, Friction] = NONE_GIVEN,
    stiffness: Mapping[str, float] = NONE_GIVEN,
) -> PressTable:
    """Tabulate a press with one driver: its slide, driving torque, shaking force and bearing forces as functions of the driver's position.

    Of a crank that does not turn fully the table has the range to 1 % before each lock.

    Args:
        press: the press.
        bearings: names of the bearings and guides whose forces and moments the table has; by default all. With ``()`` it has slide and
            driving torque alone, without the shaking force.
        loads: what acts over the whole stroke whatever the process does: springs, dampers, `BalanceCylinder`, constant forces and moments.
        inputs: name -> the force or moment of one unit that the name stands for, constant in world axes: a `PointForce` of 1 N at any point
            of a link, or a `PointMoment` of 1 N m. None stands for the process force between slide and bolster, which resists the
            working stroke where it is positive. By default ``{"force": None}`` for a press with a slide.
        tolerance: share of the largest value of a quantity that the table may miss, from 1e-13 to 1e-3. It is mostly a thousand times more
            accurate: see `PressTable.error`.
        friction: viscous friction of bearings and guides, by their names.
        stiffness: stiffnesses by which redundant bearings share their forces, as in `inverse_dynamics` [N/m].

    Raises:
        PinpressError: several drivers; a change point; dry friction; teeth or threads that rub, or push gears apart; a slide that does not
            come back after a period; a load that depends on time, or on the speed otherwise than as a damper; an input that is no constant
            force; a press whose forces are not as the functions have them.
        UnknownNameError: a bearing or link that the press does not have.
    """
    share = float(
        suitable_numbers("tolerance", tolerance, "a number from 1e-13 to 1e-3", suits=lambda value: (value >= 1e-13) & (value <= 1e-3))
    )
    _refuse(press, loads, friction)
    units = _checked_inputs(press, inputs)
    sampler = _Sampler.of(press, bearings, tuple(loads), friction, stiffness, units)
    model = reduced_model_of(press)
    if model.gains.any():
        raise PinpressError(f"{press.name} does not come back after a period, as its slide is on a screw or a rack: it cannot be tabulated")
    borders, sizes = _first_borders(press, model.borders, model.period is not None), _Sizes(sampler)
    with cautions_collected():  # of states that nobody asked for
        panels, _ = resolve(sampler.functions, borders, sizes.missed, share, float(np.diff(borders)[0]) / 2**HALVINGS)
        by_term = sizes.cleaned(panels.coefficients)
        live = by_term.any(axis=(0, 1, 3)) | np.equal(sampler.components, "driving_torque")
        kept = np.pad(by_term[:, :, live], ((0, 0), (0, 0), (0, 1), (0, 0)))
        table = PressTable(
            press_name=press.name,
            origin=tuple(row for row in inputs_in_words(sampler.still(bearings=())) if row[0] != "motion"),
            coordinate=press.driver_coordinates[0],
            inputs=tuple(units),
            bearings=sampler.bearings,
            quantities=sampler.quantities,
            components=tuple(name for name, lives in zip(sampler.components, live, strict=True) if lives),
            functions=Panels(panels.borders, kept.reshape(len(kept), -1, kept.shape[-1]), model.period),
            tolerance=share,
            error={},
            compared=0,
            largest={},
        )
        return _with_errors(table, sampler, sizes)


def stands(load: Load) -> bool:
    """Whether a load is in the functions g and d: a spring, damper, balance cylinder, or constant force or moment."""
    return isinstance(load, SpringDamper | TorsionSpring | BalanceCylinder) or is_constant(load)


def _refuse(press: Linkage, loads: Sequence[Load], friction: Mapping[str, Friction]) -> None:
    """Raise PinpressError where reactions are no linear functions as above."""
    press.refuse_several_drivers("a table has one driver; simulate it in Python, or hold the other drivers")
    if press.uneven:
        names = ", ".join(repr(each.name) for each in press.contacts if each.rubbing or each.unit.push.any())
        raise PinpressError(
            f"{press.name} has teeth or threads that rub or push apart in {names}, so that forces are not in proportion to loads:"
            " leave out their losses and pressure angles to tabulate it"
        )
    if points := press.branch_through_change_points.change_points:
        places = ", ".join(press.driver_coordinates[0].at(each.angle) for each in points)
        raise PinpressError(f"{press.name} has a change point at {places}, where forces have no bounds: it cannot be tabulated")
    if dry := [name for name, each in friction.items() if isinstance(each, Friction) and (each.coefficient or each.preload)]:
        raise PinpressError(
            f"{press.name} has dry friction in {', '.join(dry)}, which depends on the size of forces and on the way: leave out its"
            " coefficient and preload to tabulate it"
        )
    for load in loads:
        if not stands(load):
            given = load.label if isinstance(load, LinkLoad) else type(load).__name__
            raise PinpressError(
                f"{given} is no function of the driver's position alone: leave it out of loads, and give its force as an input"
            )


def _checked_inputs(press: Linkage, inputs: Mapping[str, Input | None] | None) -> Mapping[str, Input | None]:
    if inputs is None:
        return {} if press.slide is None else {"force": None}
    for name, load in inputs.items():
        if not isinstance(name, str) or not name.isidentifier() or name in ("angle", "speed", "acceleration"):
            raise PinpressError(f"input {shown(name)} is no name: write letters and digits, not angle, speed or acceleration")
        if load is None:
            press.slide_guide  # noqa: B018  raises where there is no slide
        elif not is_constant(load):
            raise PinpressError(f"input {name!r} is {shown(load)}: give a PointForce of 1 N, a PointMoment of 1 N m, or None")
    return inputs


def _first_borders(press: Linkage, borders: Array, turns: bool) -> Array:
    """Borders of the first panels, within the locks."""
    low, high = float(borders[0]), float(borders[-1])
    if not turns:
        below, above = (LOCKED * (high - low) if lock is not None else 0.0 for lock in press.branch.locks)
        low, high = low + below, high - above
    revolutions = (high - low) / (2 * np.pi) if press.driver_coordinates[0].turns else 1.0
    return np.linspace(low, high, max(2, math.ceil(FIRST_PANELS * revolutions - 1e-9)) + 1)


@dataclass(frozen=True)
class _Sampler:
    """Reactions of a press from the engine.

    Attributes:
        press: the press.
        bearings: names of its bearings in the table.
        shaking: whether the table has the shaking force.
        loads: loads in the functions g and d.
        friction: viscous friction, in d.
        stiffness: of redundant bearings.
        inputs: see `tabulate`.
        amplitudes: of the terms: 1, acceleration, speed^2, speed, forces. The size of each term at its amplitude is far above that of g.
    """

    press: Linkage
    bearings: tuple[str, ...]
    shaking: bool
    loads: tuple[Load, ...]
    friction: Mapping[str, Friction]
    stiffness: Mapping[str, float]
    inputs: Mapping[str, Input | None]
    amplitudes: Array

    @classmethod
    def of(
        cls,
        press: Linkage,
        bearings: Collection[str] | None,
        loads: tuple[Load, ...],
        friction: Mapping[str, Friction],
        stiffness: Mapping[str, float],
        inputs: Mapping[str, Input | None],
    ) -> _Sampler:
        size = press.size
        length = size if press.driver_coordinates[0].turns else 1.0
        mass = sum(inertia.mass for inertia in list(press.model.inertias)[1:])
        square, force = AMPLE * GRAVITY * size / length**2, AMPLE * GRAVITY * max(mass, 1.0)
        sizes = [1.0, AMPLE * GRAVITY / length, square, math.sqrt(square)]
        forces = [force * (size if isinstance(unit, PointMoment) else 1.0) for unit in inputs.values()]
        first = cls(press, (), False, loads, friction, stiffness, inputs, np.array(sizes + forces))
        named = tuple(first.still(bearings).bearing_force)
        return replace(first, bearings=named, shaking=bool(named))

    def still(self, bearings: Collection[str] | None) -> Reactions:
        """The press at rest where its driver is drawn."""
        return self._reactions(self._motion(np.zeros(1), 0.0, 0.0), [], bearings)

    @cached_property
    def quantities(self) -> tuple[Quantity, ...]:
        effort = self.press.driver_coordinates[0].effort_unit
        slide = [Quantity("slide_position", "m", 1), Quantity("slide_velocity", "m/s", 1), Quantity("slide_acceleration", "m/s2", 1)]
        shaking = [Quantity("shaking_force", "N", 3), Quantity("shaking_moment", "N m", 3)]
        return (
            *(slide if self.press.slide is not None else []),
            Quantity("driving_torque", effort, 1),
            *(shaking if self.shaking else []),
            *(Quantity(f"force_{name}", "N", 3) for name in self.bearings),
            *(Quantity(f"moment_{name}", "N m", 3) for name in self.bearings),
        )

    @cached_property
    def components(self) -> list[str]:
        return [name for each in self.quantities for name in each.components]

    def functions(self, angles: Array) -> Array:
        """Rows (terms x components, n) of g, u, v, d and p at positions (n,), term by term."""
        cases = np.zeros((len(self.amplitudes) + 1, len(self.amplitudes) - 2))  # acceleration, speed, forces
        _, acceleration, square, speed, *forces = self.amplitudes
        cases[1:3, 0], cases[3:5, 1] = (acceleration, -acceleration), (speed, -speed)
        for k, force in enumerate(forces):
            cases[5 + k, 2 + k] = force
        states = np.repeat(cases.T, len(angles), axis=1)
        values = self.values(np.tile(angles, len(cases)), states[1], states[0], states[2:])
        rest, ahead, back, onwards, backwards, *loaded = np.moveaxis(values.reshape(len(values), len(cases), -1), 1, 0)
        by_force = [(each - rest) / force for each, force in zip(loaded, forces, strict=True)]
        by_acceleration, by_speed = 0.5 * (ahead - back) / acceleration, 0.5 * (onwards - backwards) / speed
        terms = [rest, by_acceleration, (0.5 * (onwards + backwards) - rest) / square, by_speed]
        return np.concatenate([*terms, *by_force])

    def values(self, angle: Array, speed: Array, acceleration: Array, forces: Array) -> Array:
        """(components, n) in n states; ``forces``: (inputs, n)."""
        motion = self._motion(angle, speed, acceleration)
        acting = [_acting(unit, force) for unit, force in zip(self.inputs.values(), forces, strict=True)]
        reactions = self._reactions(motion, acting, self.bearings)
        slide = [motion.slide_position, motion.slide_velocity, motion.slide_acceleration] if self.press.slide is not None else []
        vectors = [reactions.shaking_force, reactions.shaking_moment] if self.shaking else []
        vectors += [*reactions.bearing_force.values(), *reactions.bearing_moment.values()]
        return np.concatenate([np.reshape([*slide, reactions.driving_torque], (-1, len(angle))), *(each.T for each in vectors)])

    def _reactions(self, motion: Motion, acting: Sequence[Load], bearings: Collection[str] | None) -> Reactions:
        return inverse_dynamics(self.press, motion, [*self.loads, *acting], self.friction, self.stiffness, bearings=bearings)

    def _motion(self, angle: Array, speed: Array | float, acceleration: Array | float) -> Motion:
        return motion_through_change_points(self.press, angle, speed, acceleration, np.arange(len(angle), dtype=float))


def _acting(unit: Input | None, size: Array) -> Load:
    """An input of these sizes (n,) in states whose times are 0, 1, ..."""
    if unit is None:
        return TimeForce(lambda time: size[time.astype(int)])
    if isinstance(unit, PointMoment):
        return replace(unit, moment=np.multiply.outer(size, unit.vectors(unit.moment)))
    return replace(unit, force=np.multiply.outer(size, np.asarray(unit.force)))


class _Sizes:
    """Sizes of all functions over the panels so far, with which what polynomials miss is compared.

    The terms count at their amplitudes. A force that is much smaller than the largest one is found with the rounding error of that one, and
    so is a moment with that of the largest force at the linkage's size.
    """

    def __init__(self, sampler: _Sampler) -> None:
        self.amplitudes, self.size = sampler.amplitudes, sampler.press.size
        self.units = np.array([each.unit for each in sampler.quantities])
        self.starts = np.cumsum([0, *(each.size for each in sampler.quantities)])[:-1]
        self.counts = np.array([each.size for each in sampler.quantities])
        self.largest = np.zeros((len(self.amplitudes), len(self.units)))

    def missed(self, values: Array) -> Array:
        """(p,) what polynomials through values (q, rows, p) miss on each panel, as a share."""
        self.largest = np.maximum(self.largest, self._of_quantities(np.abs(values).max(axis=(0, 2))))
        scale = np.maximum(self.largest, FAINT * self.references)
        shares = self._of_quantities(last_terms(values)) / np.where(scale > 0, scale, 1.0)[..., None]
        return np.asarray(shares.max(axis=(0, 1)))

    @property
    def references(self) -> Array:
        """(quantities,) the largest value of its kind for each quantity."""
        own = self.largest.max(axis=0)
        force = own[self.units == "N"].max(initial=0.0)
        moment = max(force * self.size, own[self.units == "N m"].max(initial=0.0))
        return np.select([self.units == "N", self.units == "N m"], [force, moment], own)

    def cleaned(self, coefficients: Array) -> Array:
        """(p, terms, components, q) of coefficients (p, rows, q), in which functions that are rounding error are zero."""
        by_term = coefficients.reshape(len(coefficients), len(self.amplitudes), -1, coefficients.shape[-1])
        sizes = np.abs(by_term).sum(axis=3).max(axis=0) * self.amplitudes[:, None]
        return np.where((sizes > NOTHING * np.repeat(self.references, self.counts))[:, :, None], by_term, 0.0)

    def _of_quantities(self, rows: Array) -> Array:
        """(terms, quantities, ...) largest components of rows (terms x components, ...), with the terms at their amplitudes."""
        by_term = rows.reshape(len(self.amplitudes), -1, *rows.shape[1:])
        largest = np.maximum.reduceat(by_term, self.starts, axis=1)
        return np.asarray(largest * self.amplitudes.reshape(-1, *[1] * rows.ndim))


def _with_errors(table: PressTable, sampler: _Sampler, sizes: _Sizes) -> PressTable:
    """The table with the largest differences from the engine in states between the nodes of its polynomials.

    Raises:
        PinpressError: a difference is too large.
    """
    borders = table.functions.borders
    angles = (borders[:-1, None] + 0.5 * (1.0 + PLACES) * np.diff(borders)[:, None]).ravel()
    _, acceleration, _, speed, *forces = sampler.amplitudes
    largest_states = np.array([speed, acceleration, *forces])
    states = largest_states[:, None] * np.random.default_rng(0).uniform(-1.0, 1.0, (len(largest_states), len(angles)))
    exact = sampler.values(angles, states[0], states[1], states[2:])
    values = table.at(angles, states[0], states[1], **dict(zip(table.inputs, states[2:], strict=True))).values
    missed = np.abs(values[[place for each in table.quantities for place in table._places(each.name)]] - exact)
    error, largest = {}, {}
    for each, start, reference in zip(table.quantities, sizes.starts, sizes.references, strict=True):
        part = slice(start, start + each.size)
        largest[each.name] = float(np.abs(exact[part]).max())
        if largest[each.name] <= NOTHING * reference:
            largest[each.name] = 0.0
        error[each.name] = float(missed[part].max()) / max(largest[each.name], FAINT * reference) if largest[each.name] else 0.0
        if not error[each.name] <= max(TRUSTED, 10.0 * table.tolerance):
            place = table.coordinate.at(float(angles[int(missed[part].max(axis=0).argmax())]))
            raise PinpressError(
                f"{each.name} of {table.press_name} differs by {error[each.name]:.1g} of its largest value from the engine at {place}:"
                " it jumps there, has no bounds, or is not in proportion to loads; leave out the element or load that does that"
            )
    return replace(table, error=error, compared=len(angles), largest=largest)
