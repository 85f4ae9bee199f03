"""The working stroke of a rated press: crank angles from top to bottom dead centre, which limit governs where, and the work it permits."""

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import PinpressError, shown
from ..kinematics.dead_centres import dead_centres
from ..linkage.linkage import Linkage
from .capacities import Capacities
from .limits import Rated, permissible, under_unit_force, without_masses

ROUNDING = 4 * float(np.finfo(float).eps)
GAUSS = np.polynomial.legendre.leggauss(3)


class Limited(NamedTuple):
    """Limits over the working stroke.

    Attributes:
        angle: (n,) of the crank, from top to bottom dead centre [rad]. forces: name of a limit -> (n,) force it permits, none above the
            nominal one [N]. names: (n,) of the limit that governs; where it changes, of the one that begins to.
        changes: indices of the states at which it changes.
    """

    angle: Array
    forces: dict[str, Array]
    names: tuple[str, ...]
    changes: tuple[int, ...]


def rated(press: Linkage, capacities: Capacities, speed: float, at_speed: bool, engine: str) -> Rated:
    """What is rated, its torque capacity found where a nominal height stands for it. Raises as `angle_at`."""
    ends = dead_centres(press)
    way = 1.0 if speed > 0 else -1.0
    bottom = ends.top_angle + way * ((way * (ends.bottom_angle - ends.top_angle)) % (2 * np.pi * ends.turns))
    make = partial(Rated, press, capacities, speed, at_speed=at_speed, engine=engine, top=ends.top_angle, bottom=bottom, turns=ends.turns)
    given = make(torque=capacities.torque, bottom_position=ends.bottom_position)
    if capacities.nominal_height is None:
        return given
    at = given.motion(np.array([angle_at(given, "nominal_height", capacities.nominal_height)]))
    needed = under_unit_force(without_masses(press), at, ends.bottom_position, (), engine).driving_torque[0]
    return make(torque=capacities.nominal_force * abs(float(needed)), bottom_position=ends.bottom_position)


def angle_at(rated: Rated, name: str, height: float) -> float:
    """Crank angle of the working stroke, unwrapped, at a height above bottom dead centre [m].

    Raises:
        PinpressError: a height that is not between 0 and the stroke.
    """
    from scipy.optimize import brentq

    stroke = dead_centres(rated.press).stroke
    if not 0.0 < height < stroke:
        raise PinpressError(f"{name} is {shown(height)}: give a height between 0 and the stroke of {stroke:.6g} m")

    def above(angle: float) -> float:
        return float(rated.motion(np.array([angle])).slide_position[0]) - rated.bottom_position - height

    return float(brentq(above, rated.top, rated.bottom, xtol=ROUNDING, rtol=ROUNDING))


def limited(rated: Rated, points: int) -> Limited:
    """Limits at ``points`` crank angles in equal steps, the nominal height and the angles at which another limit begins to govern."""
    height = rated.capacities.nominal_height
    marks = [] if height is None else [angle_at(rated, "nominal_height", height)]
    angle = _in_order(rated, np.concatenate([np.linspace(rated.top, rated.bottom, points), marks]))
    names = _governing(_capped(rated, angle))
    next_names: dict[float, str] = {}
    for k in range(len(angle) - 1):
        if names[k] != names[k + 1]:
            next_names[_crossing(rated, names[k], names[k + 1], float(angle[k]), float(angle[k + 1]))] = names[k + 1]
    every = _in_order(rated, np.concatenate([angle, list(next_names)]))
    forces = _capped(rated, every)
    # At a change two limits permit the same but for rounding, which must not decide.
    governing = tuple(next_names.get(float(at), name) for at, name in zip(every, _governing(forces), strict=True))
    return Limited(every, forces, governing, tuple(k for k, at in enumerate(every) if float(at) in next_names))


def work(rated: Rated, angle: Array) -> Array:
    """Work (n,) of the permissible force but for energy from crank angles (n,) to the last of them [J], by Gauss's rule between them."""
    nodes, weights = GAUSS
    middle, half = 0.5 * (angle[1:] + angle[:-1]), 0.5 * np.abs(np.diff(angle))
    motion = rated.motion((middle[:, None] + 0.5 * np.diff(angle)[:, None] * nodes).ravel())
    forces = permissible(rated, motion, energy=False)
    power = np.min(list(forces.values()), axis=0) * np.abs(motion.slide_velocity / rated.speed)
    steps = half * (power.reshape(-1, len(nodes)) @ weights)
    return np.append(np.cumsum(steps[::-1])[::-1], 0.0)


def _in_order(rated: Rated, angles: Array) -> Array:
    """Crank angles in the order of the working stroke, each once."""
    rising = np.unique(angles)
    return (rising if rated.bottom > rated.top else rising[::-1]).copy()


def _crossing(rated: Rated, first: str, second: str, low: float, high: float) -> float:
    """Crank angle between two at which the second limit begins to permit less than the first."""
    from scipy.optimize import brentq

    def ahead(angle: float) -> float:
        """How much more the first limit permits, some number where both permit more than the nominal force."""
        found = permissible(rated, rated.motion(np.array([angle])))
        one, other = (min(float(found[name][0]), 2 * rated.capacities.nominal_force) for name in (first, second))
        return one - other

    before, after = ahead(low), ahead(high)
    if before * after >= 0:  # they change at a state
        return low if before == 0.0 else high
    return float(brentq(ahead, low, high, xtol=ROUNDING, rtol=ROUNDING))


def _capped(rated: Rated, angle: Array) -> dict[str, Array]:
    return {name: np.minimum(force, rated.capacities.nominal_force) for name, force in permissible(rated, rated.motion(angle)).items()}


def _governing(forces: Mapping[str, Array]) -> tuple[str, ...]:
    """Name of the smallest of forces (n,) at every height; of equal ones the first."""
    names = list(forces)
    return tuple(names[k] for k in np.argmin(list(forces.values()), axis=0))
