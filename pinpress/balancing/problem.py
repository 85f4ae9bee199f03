"""What balancing knows of a press: rooms as variables, and measures as series that are linear in them, all about one in size."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common.arrays import Array
from ..common.conic_program import Rows
from ..common.errors import PinpressError, shown
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..linkage.linkage import Linkage
from .mass_response import Case, Change, change, moving_mass
from .objectives import Forces, Measure, Target, refuse_unknown
from .regions import Layout, Room, layout, points_of

ROUNDING = 1e-11  # of what the rooms could do to a measure: one that small is zero
NOISE = 1e-12  # of the forces that a measure is a component of: one that small is rounding


@dataclass(frozen=True, eq=False, repr=False)
class Signal:
    """The series that a measure is of in one case, over its size: ``fixed + effects @ u`` for variables u.

    Attributes:
        measure: of which. case: its number. size: what one is, in the measure's unit.
        fixed: (n, components). effects: (n, components, variables). Both `Measure.varying`.
    """

    measure: Measure
    case: int
    size: float
    fixed: Array
    effects: Array

    def at(self, u: Array) -> Array:
        """(n, components)."""
        return np.asarray(self.fixed + self.effects @ u)


@dataclass(frozen=True, eq=False, repr=False)
class Problem:
    """All that may be asked of some rooms: the constraints of their shapes, signals, and the mass that they add.

    Attributes:
        layouts: of the rooms, whose variables stand one after the other. rows: constraints on them (variables,).
        signals: of the measures in all cases. mass: (variables,) [kg]. own: mass taken off links [kg]. moving: of the press [kg].
    """

    layouts: tuple[Layout, ...]
    rows: tuple[Rows, ...]
    signals: tuple[Signal, ...]
    mass: Array
    own: float
    moving: float

    @property
    def unlimited(self) -> Array:
        """(variables,) `mass` of rooms without a most mass, of others zero."""
        return np.concatenate([room.mass * math.isinf(room.room.mass[1]) for room in self.layouts])

    def added(self, u: Array) -> float:
        """Added mass [kg]."""
        return float(self.mass @ u) - self.own


def build(press: Linkage, cases: Sequence[Case], rooms: Sequence[Room], targets: Sequence[Target]) -> tuple[Problem, tuple[Reactions, ...]]:
    """The problem of some measures, and the press's reactions.

    Raises as `balancing.balance`.
    """
    if not isinstance(rooms, list | tuple) or not rooms or not all(isinstance(room, Room) for room in rooms):
        raise PinpressError("rooms is no list of Room: say on which links counterweights may be, [Room('crank', radius=0.3)]")
    measures = list(dict.fromkeys(target for target in targets if isinstance(target, Measure)))
    for measure in measures:
        refuse_unknown(measure, press)
    bearings = tuple(dict.fromkeys(measure.bearing for measure in measures if measure.bearing is not None))
    before = tuple(inverse_dynamics(press, case.motion, case.loads, bearings=bearings) for case in cases)
    turning, moving = any(measure.quantity != "shaking_force" for measure in measures), moving_mass(press)
    layouts = _layouts(press, rooms, turning, [moving] * len(rooms))
    signals = [signal for number, case in enumerate(cases) for signal in _signals(press, case, number, before[number], layouts, measures)]
    # A room's unit is then the mass with which it changes the measures by their size.
    shares = _shares(layouts, signals)
    layouts = _layouts(press, rooms, turning, [moving * share for share in shares])
    factors = np.concatenate([np.full(len(room.mass), share) for room, share in zip(layouts, shares, strict=True)])
    signals = [replace(signal, effects=signal.effects * factors) for signal in signals]
    own = sum(room.own.mass for room in layouts if room.own is not None)
    return Problem(layouts, _joined(layouts), tuple(signals), np.concatenate([room.mass for room in layouts]), own, moving), before


def _signals(
    press: Linkage, case: Case, number: int, before: Reactions, layouts: Sequence[Layout], measures: Sequence[Measure]
) -> list[Signal]:
    """The signals of a case."""
    torque = any(not measure.quantity.startswith("shaking") for measure in measures)
    changes = [change(press, case, before, part, torque) for room in layouts for part in room.parts]
    owns = [change(press, case, before, points_of(press, room.room.link, room.own), torque) for room in layouts if room.own is not None]
    return [_signal(measure, number, before, changes, owns) for measure in measures]


def _signal(measure: Measure, number: int, before: Reactions, changes: Sequence[Change], owns: Sequence[Change]) -> Signal:
    """A measure's signal; ``changes`` by one of each variable, ``owns`` by what rooms replace."""
    forces: list[Forces] = [before, *changes, *owns]
    fixed, *others = (measure.varying(measure.series(each)) for each in forces)
    effects, owned = np.stack(others[: len(changes)], axis=2), others[len(changes) :]
    # Nothing before: what matters is what the rooms do; nor these: all is rounding of what cancels.
    influence = max(measure.of(effect) for effect in others[: len(changes)])
    noise = NOISE * max(float(np.abs(measure.vector(each)).max()) for each in forces)
    size = next((size for size in (measure.of(fixed), influence) if size > max(noise, ROUNDING * influence)), noise or 1.0)
    return Signal(measure, number, size, (fixed - sum(owned)) / size, effects / size)


def _shares(layouts: Sequence[Layout], signals: Sequence[Signal]) -> list[float]:
    """For every room one over its largest effect, at most one."""
    largest = np.max([np.abs(signal.effects).max(axis=(0, 1)) for signal in signals], axis=0) if signals else np.ones(1)
    ends = np.cumsum([len(room.mass) for room in layouts])[:-1]
    return [1.0 / max(1.0, float(part.max(initial=0.0))) for part in np.split(largest, ends)]


def _layouts(press: Linkage, rooms: Sequence[Room], turning: bool, units: Sequence[float]) -> tuple[Layout, ...]:
    """Rooms as variables, one of which means a unit [kg] each."""
    layouts = tuple(layout(press, room, turning, unit) for room, unit in zip(rooms, units, strict=True))
    replaced = [room.joint for room in layouts if room.own is not None]
    for room in layouts:
        if room.own is not None and replaced.count(room.joint) > 1:
            raise PinpressError(f"two rooms replace the mass of link {shown(room.room.link)}: let one of them add to it")
    return layouts


def _joined(layouts: Sequence[Layout]) -> tuple[Rows, ...]:
    """The constraints of rooms on the variables of all."""
    width, start, rows = sum(len(room.mass) for room in layouts), 0, []
    for room in layouts:
        for part in room.rows:
            coefficients = np.zeros((len(part.coefficients), width))
            coefficients[:, start : start + len(room.mass)] = part.coefficients
            rows.append(replace(part, coefficients=coefficients))
        start += len(room.mass)
    return tuple(rows)
