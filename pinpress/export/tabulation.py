"""The functions of a press's table, found from the engine.

Inertia and forces are made so large that they outweigh the weights; differences of states then give the functions term by term. Panels are
halved until polynomials resolve every function, and the table is compared with the engine between their nodes.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from ..common.arguments import suitable_numbers, typed
from ..common.errors import PinpressError, cautions_collected, shown
from ..common.quantities import GRAVITY, Array
from ..dynamics.inputs import inputs as inputs_in_words
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.panels import Panels, last_terms, resolve
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.link import Friction, LinkLoad, Load, PointForce, PointMoment, SpringDamper, TorsionSpring, is_constant
from ..loads.pneumatics import BalanceCylinder
from ..loads.process import TimeForce
from ..simulation.reduced_model import reduced_model_of
from .tables import PressTable, Quantity

AMPLE = 100.0  # how much larger than the weights inertia and forces are where functions are found: none is then lost in rounding error
FAINT = 1e-3  # share of the largest force below which a force counts as that large: rounding error of the largest one is in it
NOTHING = 1e-12  # share of the largest force below which a function is rounding error
LOCKED = 0.01  # share of the driver's range before a lock that is left out, as forces have no bounds there
FIRST_PANELS = 4  # of a turn, before they are halved
HALVINGS = 10  # most of these; with more a function has a jump
PLACES = np.array([-0.93, -0.41, 0.13, 0.69])  # between the nodes of a panel, where the table is compared with the engine
TRUSTED = 1e-7  # error from which on something in the press is not as the functions have it

Input: TypeAlias = PointForce | PointMoment


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
        self.sampled = np.zeros(len(self.amplitudes) * int(self.counts.sum()))  # of each row, at the nodes

    def missed(self, values: Array) -> Array:
        """(p,) what polynomials through values (q, rows, p) miss on each panel, as a share."""
        self.sampled = np.maximum(self.sampled, np.abs(values).max(axis=(0, 2)))
        scale = np.maximum(self._of_quantities(self.sampled), FAINT * self.references)
        shares = self._of_quantities(last_terms(values)) / np.where(scale > 0, scale, 1.0)[..., None]
        return np.asarray(shares.max(axis=(0, 1)))

    @property
    def references(self) -> Array:
        """(quantities,) the largest value of its kind for each quantity."""
        own = self._of_quantities(self.sampled).max(axis=0)
        force = own[self.units == "N"].max(initial=0.0)
        moment = max(force * self.size, own[self.units == "N m"].max(initial=0.0))
        return np.select([self.units == "N", self.units == "N m"], [force, moment], own)

    def cleaned(self, coefficients: Array) -> Array:
        """(p, terms, components, q) of coefficients (p, rows, q), in which functions that are rounding error are zero."""
        by_term = coefficients.reshape(len(coefficients), len(self.amplitudes), -1, coefficients.shape[-1])
        # by samples, as the polynomial through rounding error has coefficients a thousand times larger
        sizes = self.sampled.reshape(len(self.amplitudes), -1) * self.amplitudes[:, None]
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
