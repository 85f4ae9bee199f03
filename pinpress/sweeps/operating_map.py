"""Operating points of a press: torque and forces at every speed and every amplitude of its load, without a loop over the points.

At a given crank angle and a constant speed w, torque and every reaction are affine in w^2 and in the amplitude F of a load,

    a(angle) w^2 + c(angle) + d(angle) F

where a comes from inertia, c from weight, springs and constant loads, and d from the load of amplitude one: the equations of motion are
linear in the forces and in the accelerations, which are proportional to w^2. Three calls of inverse dynamics give a, c and d; two or three
more confirm them.

Then for quantities f_k = a_k W + c_k + d_k F in states k, with W = w^2, the largest value over the states, or the largest length of a
vector, is found at (n, m) points (W, F). The grid is cut into tiles. Most states are the largest nowhere in a tile, and can be left out:

- Let u be a unit vector. The difference |f_k| - u . f_j is convex in (W, F), because it is the length of an affine function minus an affine
  function. So where it is not positive at the four corners of a tile, it is not positive in the tile, and |f_k| <= u . f_j <= |f_j| there:
  state j leaves state k out.
- For scalars u is 1 and the value itself stands for the length.

Of a few hundred states few remain in a tile; these are compared at all of its points.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arguments import numbers, typed
from ..common.errors import PinpressError, UnknownNameError
from ..common.frozen import read_only
from ..common.quantities import Array
from ..common.results import Tabular
from ..dynamics.applied_loads import wrap_laws
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import doubt_speeds, period_at
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.caller_laws import AskedLoad, as_given
from ..loads.link import Load, PointForce, PointMoment, Spring
from ..loads.process import ForceInterval, ProcessLoad, TimeForce

SLOW = 1e-9  # share of the highest speed at which inertia is below rounding, but the slide still has a direction of travel
BETWEEN = 0.37  # share of the highest speed and amplitude at which the coefficients are confirmed too
AFFINE = 1e-9  # a quantity that differs by more than this share of its largest value is not affine
TILES = 16  # along either axis: in fewer tiles more states remain, and more tiles take longer to prepare
LEAST = 24  # points of a tile along either axis
Quantities = dict[str, Array]
"""Name -> (k, s) array, components by states."""
Cycle = Callable[[float, float | None], tuple[Motion, Quantities]]


@dataclass(frozen=True, eq=False, repr=False)
class OperatingMap(Tabular):
    """Extremes over a period at every speed and amplitude of a load. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        speeds: (n,) speeds of the driver [rad/s].
        forces: (m,) amplitudes of the load [N].
        results: name -> (n, m) values. The names are largest_driving_torque and smallest_driving_torque [N m]; peak_force_A and so on, the
            largest magnitude of the force in each bearing [N]; range_shaking_force_x, _y and _z, largest less smallest value [N].
        angles: name of an extreme torque or peak force -> (n, m) crank angle at which it occurs [rad]; empty if not requested.
    """

    press_name: str
    speeds: Array
    forces: Array
    results: Mapping[str, Array]
    angles: Mapping[str, Array]

    @property
    def title(self) -> str:
        speeds, forces = (f"{values.min():.6g} to {values.max():.6g}" for values in (self.speeds, self.forces))
        return f"OperatingMap of {self.press_name}: {len(self.speeds)} speeds, {speeds} rad/s, and {len(self.forces)} forces, {forces} N"

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.speeds), len(self.forces)

    @property
    def axes(self) -> dict[str, Array]:
        """Name in the columns -> axis of the grid."""
        return {"speed": self.speeds, "force": self.forces}

    def columns(self) -> dict[str, Array]:
        """A row for each point (the force changes fastest): speed, force, results and angles."""
        columns = {"speed": np.repeat(self.speeds, self.shape[1]), "force": np.tile(self.forces, self.shape[0])}
        columns |= {name: values.ravel() for name, values in self.results.items()}
        columns |= {f"angle_of_{name}": values.ravel() for name, values in self.angles.items()}
        return {f"{name} [{unit_of(name)}]": values for name, values in columns.items()}

    def grid(self, name: str) -> Array:
        """Read a result (n, m), speeds by forces.

        Raises:
            UnknownNameError: there is no such result.
        """
        if name not in self.results:
            raise UnknownNameError("result", name, self.results)
        return self.results[name]


@typed
def operating_points(
    press: Linkage,
    speeds: ArrayLike,
    *,
    forces: ArrayLike = (0.0,),
    unit_load: Load | Sequence[Load] = (),
    loads: Sequence[Load] = (),
    bearings: Collection[str] | None = None,
    points: int | None = None,
    angles: bool = False,
) -> OperatingMap:
    """Find the extremes of torque and forces over a period at constant speed, at every speed and every amplitude of a load.

    They agree with `inverse_dynamics` of `cycle` within rounding error, at a million points a second.

    Args:
        press: a press with one driver that turns fully.
        speeds: (n,) speeds of the driver, all positive or all negative [rad/s].
        forces: (m,) amplitudes by which ``unit_load`` is multiplied, in N for a load of 1 N.
        unit_load: one or several process loads or point forces, such as ``DeepDrawing(force=1.0, start=0.010)``.
        loads: loads that are equal at all points, such as springs.
        bearings: names of the bearings whose peak forces are computed; by default all.
        points: number of crank angles of the period, in equal steps from 0; by default 360 a turn.
        angles: whether to find also the crank angles of extreme torques and peak forces, which takes longer.

    Raises:
        PinpressError: an argument is not as described, a load depends on the speed or on time (for example a damper), or a load is not
            proportional to its amplitude within 1e-9 of the largest value. For such loads use `sweep`, which computes every point.
        UnknownNameError: the press has no such bearing.
        SingularityError: the linkage locks within the period.
        AssemblyError: the linkage cannot be assembled at some crank angle.
    """
    press.refuse_several_drivers("operating points need a press with one driver; sweep computes any function, also with servo_cycle")
    press.refuse_sliding_driver("operating points need a crank at constant speeds; sweep computes any points")
    if press.loses_power or (press.uneven and (bearings is None or len(bearings))):
        press.refuse_contacts("with them forces are not affine; use sweep, which computes every point, or, without losses, bearings=()")
    speed, force = _axis("speeds", speeds, "rad/s"), _axis("forces", forces, "N")
    if not (np.all(speed > 0) or np.all(speed < 0)):
        raise PinpressError("speeds: give only positive or only negative speeds, not 0, because loads depend on the direction of travel")
    units = wrap_laws(list(unit_load) if isinstance(unit_load, Sequence) else [unit_load])
    constant = wrap_laws(list(loads))
    if any(isinstance(load, Spring) for load in units):
        raise PinpressError("unit_load has a spring or damper, which has no amplitude: give it in loads")
    if any(isinstance(load, TimeForce) for load in (*units, *constant)):
        raise PinpressError("a TimeForce depends on time and thus on the speed: use sweep, which computes every point")
    if not units and force.any():
        raise PinpressError("forces are amplitudes of unit_load, which is missing: give e.g. pp.loads.DeepDrawing(force=1.0, start=0.010)")

    doubt_speeds(press, speed)
    at = partial(_cycle, press, units, constant, bearings, points)
    fastest, most = float(speed[np.abs(speed).argmax()]), float(force[np.abs(force).argmax()])
    with np.errstate(all="ignore"):  # values that overflow are refused below
        motion, affine = _coefficients(at, fastest, most)
        ends = {(fastest, float(force.min())), (fastest, float(force.max()))}
        _confirm(at, affine, ends | {(BETWEEN * fastest, BETWEEN * most)})
        results, states = _extremes(affine, speed, force, angles)
    for name, values in results.items():
        if not np.isfinite(values).all():
            raise PinpressError(f"{name} of {press.name} is too large for floating point: lower speeds or forces")
    crank_angles = {name: motion.crank_angle[state] for name, state in states.items()}
    return OperatingMap(press.name, speed, force, results, crank_angles)


class Affine(NamedTuple):
    """A quantity a W + c + d F with k components in s states. A scalar has one component, whose sign counts.

    Attributes:
        a: (k, s) coefficient of the squared speed W.
        c: (k, s) constant.
        d: (k, s) coefficient of the amplitude F.
    """

    a: Array
    c: Array
    d: Array


def largest(quantity: Affine, squares: Array, forces: Array, lengths: bool, states: bool) -> tuple[Array, NDArray[np.intp] | None]:
    """Largest value (n, m) of a quantity over the states, or largest length of a vector, and a state in which it occurs.

    Args:
        quantity: the quantity.
        squares: (n,) squared speeds W, rising.
        forces: (m,) amplitudes F, rising.
        lengths: whether the quantity is a vector whose length is wanted.
        states: whether to find the states too, which doubles the time; otherwise they are None.
    """
    rows, columns = _cuts(len(squares)), _cuts(len(forces))
    kept = _remaining_states(quantity, squares[_corners(rows)], forces[_corners(columns)], lengths)
    best = np.empty((len(squares), len(forces)))
    state = np.empty(best.shape, dtype=np.intp) if states else None
    for i in range(len(rows) - 1):
        for j in range(len(columns) - 1):
            here = slice(rows[i], rows[i + 1]), slice(columns[j], columns[j + 1])
            left = np.flatnonzero(kept[i, j])
            turned = quantity.a[:, left, None] * squares[here[0]] + quantity.c[:, left, None]  # (k, states, n)
            loaded = quantity.d[:, left, None] * forces[here[1]]  # (k, states, m)
            value = turned[0, :, :, None] + loaded[0, :, None]
            if lengths:
                value *= value
                for k in range(1, len(turned)):
                    value += (turned[k, :, :, None] + loaded[k, :, None]) ** 2
            best[here] = value.max(axis=0)
            if state is not None:
                state[here] = left[value.argmax(axis=0)]
    return np.sqrt(best, out=best) if lengths else best, state


def _axis(name: str, values: ArrayLike, unit: str) -> Array:
    array = np.atleast_1d(numbers(name, values, unit=unit))
    if array.ndim != 1 or not array.size:
        raise PinpressError(f"{name} must be a sequence of finite numbers [{unit}], at least one")
    return read_only(array)


@dataclass(frozen=True, eq=False)
class _Multiplied(AskedLoad):
    """A process load whose force is multiplied by a factor; messages call it by the name of the load.

    Attributes:
        factor: factor of its force [-].
    """

    factor: float

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return tuple(replace(part, force=partial(_times, self.factor, part.force)) for part in super().intervals(downwards))


def _multiplied(load: Load, factor: float) -> Load:
    if isinstance(load, PointForce):
        law = partial(_times, factor, load.force) if callable(load.force) else factor * numbers("unit_load: force", load.force)
        return replace(load, force=law)
    if isinstance(load, PointMoment):
        given = load.moment
        of_moment = partial(_times, factor, given) if callable(given) else factor * numbers(f"{load.label}: moment", given, unit="N m")
        return replace(load, moment=of_moment)
    if isinstance(load, ProcessLoad) and not isinstance(load, type):
        return _Multiplied(as_given(load), load.errors if isinstance(load, AskedLoad) else np.geterr(), factor)
    return load  # inverse dynamics refuses it


def _times(factor: float, law: Callable[..., Any], *arguments: Any) -> Any:
    return factor * np.asarray(law(*arguments), dtype=float)


def _cycle(
    press: Linkage,
    units: Sequence[Load],
    loads: Sequence[Load],
    bearings: Collection[str] | None,
    points: int | None,
    speed: float,
    force: float | None,
) -> tuple[Motion, Quantities]:
    """One period at a speed and an amplitude, and its quantities. Without an amplitude (None) the load is left out."""
    motion = period_at(press, speed, points)
    acting = [*loads, *(_multiplied(load, force) for load in units)] if force is not None else list(loads)
    return motion, _quantities(inverse_dynamics(press, motion, acting, bearings=bearings))


def _quantities(found: Reactions) -> Quantities:
    named = {"driving_torque": found.driving_torque[None]}
    named |= {f"force_{name}": force.T for name, force in found.bearing_force.items()}
    return named | {f"shaking_force_{axis}": found.shaking_force.T[k : k + 1] for k, axis in enumerate("xyz")}


def _coefficients(at: Cycle, fastest: float, most: float) -> tuple[Motion, dict[str, Affine]]:
    """The period, and the coefficients of all quantities, from differences between calls that lose few digits."""
    _, still = at(SLOW * fastest, None)
    motion, fast = at(fastest, None)
    loaded = at(SLOW * fastest, most)[1] if most else still
    affine = {}
    for name, c in still.items():
        d = (loaded[name] - c) / most if most else np.zeros_like(c)
        affine[name] = Affine((fast[name] - c) / fastest**2, c, d)
    return motion, affine


def _confirm(at: Cycle, affine: dict[str, Affine], tried: set[tuple[float, float]]) -> None:
    """Raise PinpressError if a quantity is not affine at other speeds and amplitudes."""
    for speed, force in sorted(tried):
        forces = [part for name, part in affine.items() if name != "driving_torque"]
        strongest = max(float(np.abs(a * speed**2).max() + np.abs(c).max() + np.abs(d * force).max()) for a, c, d in forces)
        for name, values in at(speed, force)[1].items():
            a, c, d = affine[name]
            size = max(float(np.abs(part).max()) for part in (a * speed**2, c, d * force, values))
            if name != "driving_torque":  # errors of forces are relative to the largest of all, because one force may be mere rounding
                size = max(size, strongest)
            if not np.abs(a * speed**2 + c + d * force - values).max() <= AFFINE * size:
                raise PinpressError(
                    f"{name} is not affine in the square of the speed and the amplitude of the load: a load depends on the speed (as"
                    " a damper does), or is not proportional to its amplitude. Use sweep, which computes every point"
                )


def _extremes(affine: dict[str, Affine], speeds: Array, forces: Array, angles: bool) -> tuple[dict[str, Array], dict[str, Any]]:
    """Results (n, m), and the states of the extremes (n, m) if the angles are wanted."""
    across, along = np.argsort(speeds**2), np.argsort(forces)
    squares, amplitudes = speeds[across] ** 2, forces[along]
    back = np.ix_(np.argsort(across), np.argsort(along))
    results, states = {}, {}
    for name, quantity in affine.items():
        for result, (values, state) in _named_extremes(name, quantity, squares, amplitudes, angles):
            results[result] = values[back]
            if state is not None:
                states[result] = state[back]
    return results, states


def _named_extremes(name: str, quantity: Affine, squares: Array, forces: Array, angles: bool) -> Iterator[tuple[str, tuple[Array, Any]]]:
    """Names of the results of one quantity, each with its values (n, m) and the states of its extremes (None if not wanted)."""
    if name.startswith("force_"):
        yield f"peak_{name}", largest(_without_nothing(quantity, squares, forces), squares, forces, True, angles)
        return
    wanted = angles and name == "driving_torque"
    high, where_high = largest(quantity, squares, forces, False, wanted)
    low, where_low = largest(Affine(*(-part for part in quantity)), squares, forces, False, wanted)
    if name == "driving_torque":
        yield "largest_driving_torque", (high, where_high)
        yield "smallest_driving_torque", (np.negative(low, out=low), where_low)
    else:
        yield f"range_{name}", (np.add(high, low, out=high), None)


def _without_nothing(vector: Affine, squares: Array, forces: Array) -> Affine:
    """A vector without the components that are rounding errors; at least one remains."""
    a, c, d = vector
    size = np.abs(a).max(axis=1) * squares[-1] + np.abs(c).max(axis=1) + np.abs(d).max(axis=1) * np.abs(forces).max()
    kept = size > 1e-13 * size.max()
    kept[0] |= not kept.any()
    return Affine(a[kept], c[kept], d[kept])


def unit_of(name: str) -> str:
    """Unit of a column."""
    if name.startswith("angle_of_"):
        return "rad"
    return "rad/s" if name == "speed" else "N m" if name.endswith("driving_torque") else "N"


def _cuts(count: int) -> list[int]:
    """Indices at which the tiles along an axis begin, and the end of the last."""
    tiles = max(1, min(TILES, count // LEAST))
    return [round(k * count / tiles) for k in range(tiles + 1)]


def _corners(cuts: list[int]) -> NDArray[np.intp]:
    """First and last point of every tile along an axis (tiles, 2)."""
    return np.array([[start, end - 1] for start, end in itertools.pairwise(cuts)])


def _remaining_states(quantity: Affine, squares: Array, forces: Array, lengths: bool) -> NDArray[np.bool_]:
    """Whether a state may be the largest somewhere in a tile, (rows, columns, s).

    Args:
        quantity: the quantity.
        squares: (rows, 2) squared speeds of the tiles' corners.
        forces: (columns, 2) amplitudes of the tiles' corners.
        lengths: as of `largest`.
    """
    kept = np.empty((len(squares), len(forces), quantity.a.shape[1]), dtype=np.bool_)
    for i, along in enumerate(squares):
        # (k, columns, 5, s): the four corners, then the middle
        w = np.array([along[0], along[0], along[1], along[1], along.mean()])
        f = np.concatenate([forces, forces, forces.mean(axis=1, keepdims=True)], axis=1)
        at = quantity.a[:, None, None] * w[:, None] + quantity.c[:, None, None] + quantity.d[:, None, None] * f[:, :, None]
        size = np.sqrt(np.einsum("kjcs,kjcs->jcs", at, at)) if lengths else at[0]
        judges = size.argmax(axis=2)  # (columns, 5)
        out = np.zeros((len(forces), at.shape[3]), dtype=np.bool_)
        for judge in judges.T[::-1]:
            of = np.take_along_axis(at, judge[None, :, None, None], axis=3)[..., 0]  # (k, columns, 5)
            if lengths:
                middle = of[:, :, 4]
                length = np.linalg.norm(middle, axis=0)
                pointing = middle / np.where(length > 0, length, 1.0)
                lower = np.einsum("kj,kjc->jc", pointing, of[:, :, :4])
            else:
                lower = of[0, :, :4]
            out |= (size[:, :4] <= lower[:, :, None]).all(axis=1)
        np.put_along_axis(out, judges, False, axis=1)  # the judges themselves remain
        kept[i] = ~out
    return kept
