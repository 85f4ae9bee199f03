"""What keeps a linkage from being loaded once its links are put together: its drawn pose does not close, or its drivers do not suit it."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from ..common.arrays import Array
from ..common.errors import AssemblyError, SingularityError, UrdfError
from ..engines.closure import ACCEPTED
from ..engines.coordinates import configuration, data_of
from ..engines.planar.model import PARALLEL
from ..engines.spatial.constraints import Rows
from ..engines.spatial.kinematics import Passive, rank, singular_values
from . import mobility
from .linkage import Linkage
from .urdf.findings import Finding

CLOSE_TO_DRAWN = 0.25  # how far closing the drawn pose may turn a joint [rad], or move it in lengths of the linkage
SEEN = 1e-9  # gaps below are rounding [lengths of the linkage, rad]
UNSEEN = 1e-8  # axes that miss each other by less change the rank of no equations [rad]
BESIDE = 1e-3  # how far from the drawn pose the rank is looked at again [rad, lengths of the linkage]
MASSLESS = 1e-13  # share of the inertia that the heaviest link might have, below which none is left
ROUNDED = 1e-2  # axes as near to parallel as this are meant to be parallel [rad]


def errors(press: Linkage) -> Iterator[Finding]:
    """All that is wrong; each carries a UrdfError, AssemblyError or SingularityError."""
    assembled = closes(press)
    if assembled and press.determined:
        yield from _unseen(press)
        yield from _massless(press)
        return
    rows = press.closed_rows if assembled else press.equations(press.as_drawn)
    free = press.model.nv - rank(rows.columns)
    yield from _unseen(press)
    if assembled and free > len(press.drivers) and _free_beside(press) == len(press.drivers):
        yield _change_point(press, rows)
    elif free != len(press.drivers):
        yield _mobility(press, rows, free)
    if not assembled:
        yield from _open(press, rows)
    elif free == len(press.drivers):
        yield from list(_dead_point(press, rows)) or _massless(press)


def closes(press: Linkage) -> bool:
    """Whether the linkage closes near its drawn pose."""
    tolerance = ACCEPTED * press.engine().tolerance
    near = CLOSE_TO_DRAWN * max(1.0, press.size)
    return bool(press.drawn.gap[0] <= tolerance) and bool(np.abs(press.closed - press.as_drawn).max() <= near)


def apart(press: Linkage, each: mobility.Held, gaps: Array) -> str:
    """How far a loop or gear pair is open, in words."""
    distance, angle = mobility.opening(press, each, gaps)
    shown = [f"{short(1e3 * distance)} mm"] if distance > SEEN * press.size or angle <= SEEN else []
    return " and ".join(shown + [f"{short(np.degrees(angle))} deg"] * (angle > SEEN))


def short(number: float) -> str:
    """Three digits, or all before the point; one of what is rounding."""
    return f"{number:.0f}" if 100 <= number < 1e9 else f"{number:.3g}" if number > SEEN else f"{number:.0e}"


def rounded(press: Linkage) -> str | None:
    """The remedy for axes that are nearly, but not, parallel; None where they are, or far from it."""
    off = _off(press)[0]
    if not PARALLEL < off < ROUNDED:
        return None
    return f"axes are up to {off:.2g} rad from parallel: write angles in full, 1.5707963267948966 for a quarter turn"


def _off(press: Linkage) -> tuple[float, str, int | None]:
    """By how much the joint or loop that does so most misses the plane, its element and line."""
    joints: list[tuple[float, str, int | None]]
    joints = [(off, f'<joint name="{name}">', None) for off, name in zip(mobility.joints_off_plane(press), press.joints, strict=True)]
    loops = [
        (off, f'<loop_joint name="{loop.name}">', loop.line) for off, loop in zip(mobility.loops_off_plane(press), press.loops, strict=True)
    ]
    return max([*joints, *loops], key=lambda each: each[0])


def _unseen(press: Linkage) -> Iterator[Finding]:
    """Of axes so nearly parallel that the rank of the equations does not show it, but their gaps do, beyond rounding."""
    off, element, line = _off(press)
    if PARALLEL < off < UNSEEN and press.loops and (remedy := rounded(press)):
        problem = f"its axis is {off:.2g} rad from parallel to that of joint {press.driver!r}, or out of the plane across it"
        yield Finding.of(UrdfError(press.file, element, line, problem, remedy))


def _mobility(press: Linkage, rows: Rows, free: int) -> Finding:
    drive = "one joint drives" if len(press.drivers) == 1 else f"{len(press.drivers)} joints drive"
    problem = f"mobility is {free}, but {drive}"
    if free > len(press.drivers):
        problem += f": with {_driver(press)} held still, {_joints(mobility.undetermined(press, rows))} can move"
        remedy = "a <loop_joint> is missing, a link hangs free, or a driver is missing"
    else:
        if alone := mobility.overconstraining(press, rows):
            problem += f": {' or '.join(each.title for each in alone)} contradicts the others"
        elif free == 0 and (locking := mobility.locking(press, rows)):
            problem += f": held by {', '.join(each.title for each in locking)}"
        stuck = rounded(press) or "a loop, a gear pair or a fixed joint too many: nothing can move"
        remedy = "drive fewer joints" if free > 0 else stuck
    return Finding.of(UrdfError(press.file, f'<robot name="{press.name}">', None, problem, remedy))


def _free_beside(press: Linkage) -> int:
    """Degrees of freedom that the equations leave a little beside the drawn pose, where none of them fails by chance."""
    count = int(press.model.nv)
    lengths = np.array([1.0 if axis.turns else press.size for axis in press.axes])
    beside = press.closed + BESIDE * lengths * np.random.default_rng(0).uniform(-1, 1, count)
    return count - rank(press.equations(beside).columns)


def _change_point(press: Linkage, rows: Rows) -> Finding:
    """Of a parallelogram drawn in one line, say: two assemblies meet there."""
    problem = "two assemblies meet in the drawn pose, and the loops do not say which of them it is"
    remedy = "draw the linkage a little further on"
    smallest = float(singular_values(rows.columns)[press.model.nv - len(press.drivers) - 1])
    error = SingularityError(f"{press.file}: {problem}; {remedy}", 0.0, smallest)
    return Finding("error", f'<robot name="{press.name}">', None, problem, remedy, error)


def _open(press: Linkage, rows: Rows) -> Iterator[Finding]:
    """The loops and gear pairs that Newton's method left open, widest as drawn first."""
    owners = mobility.held(press)
    closest = press.closed_rows.gaps if np.isfinite(press.drawn.gap[0]) else rows.gaps
    gaps, left = ([each.gap(of) for each in owners] for of in (rows.gaps, closest))
    # Where loops hold each other, all of them may be left open; those that are drawn closed are not to blame.
    still_open = [k for k in range(len(owners)) if min(gaps[k], left[k]) > ACCEPTED * press.spatial.tolerance]
    still_open = still_open or [int(np.argmax(gaps))]
    remedy = rounded(press) or "draw it closed, or change the link lengths"
    if press.engine().redundant(press.as_drawn):
        remedy += "; loops hold each other here, so that lengths and angles must fit to all digits"
    for k in sorted(still_open, key=lambda k: -gaps[k]):
        each, iterations = owners[k], press.drawn.iterations
        problem = "does not close near the drawn pose"
        error = AssemblyError(f"{press.file}:{each.by.line}: {each.title} {problem}; {remedy}", 0.0, gaps[k], iterations)
        yield Finding("error", each.element, each.by.line, f"{problem}: {apart(press, each, rows.gaps)} apart as drawn", remedy, error)


def _dead_point(press: Linkage, rows: Rows) -> Iterator[Finding]:
    columns = rows.columns[:, press.spatial.passive]
    values = singular_values(columns)
    if rank(columns) == columns.shape[1]:
        return
    problem = f"{_driver(press)} does not determine the drawn pose"
    free = _joints(mobility.undetermined(press, rows))
    remedy = f"draw the linkage away from its dead point ({free} can move with the driver held still)"
    smallest = float(values.min()) if len(values) == columns.shape[1] else 0.0
    error = SingularityError(f"{press.file}: {problem}; {remedy}", 0.0, smallest)
    yield Finding("error", f'<robot name="{press.name}">', None, problem, remedy, error)


def _massless(press: Linkage) -> Iterator[Finding]:
    """Of a linkage with links that have no mass: a motion that no mass resists."""
    masses = [inertia.mass for inertia in press.model.inertias]
    if all(masses[1:]):
        return
    # One driver may be drawn where the only heavy link is at its dead centre: there it is about to move.
    rates = np.hstack([press.drawn.first, press.drawn.second]) if len(press.drivers) == 1 else _rates(press)
    mass = pin.crba(press.model, data_of(press.model), configuration(press.slots, press.closed))
    resisted = rates.T @ mass @ rates
    values, ways = np.linalg.eigh(resisted if len(press.drivers) > 1 else resisted.diagonal().sum().reshape(1, 1))
    if values[0] > MASSLESS * max(masses[1:]) * press.size**2:
        return
    moved = rates if len(press.drivers) == 1 else rates @ ways[:, :1]
    moving = np.flatnonzero(np.abs(moved).max(axis=1) > SEEN)
    body = next(int(j) + 1 for j in moving if not masses[j + 1])
    problem = "it moves without a mass, as do all links that move with it: nothing resists the drive"
    error = UrdfError(press.file, f'<link name="{press.link_of(body)}">', None, problem, "write its <mass> and <inertia>")
    yield Finding.of(error)


def _rates(press: Linkage) -> Array:
    """(nv, drivers) rates of all joints at a unit rate of each driver alone, in the closed drawn pose."""
    rows, drivers = press.closed_rows, list(press.driver_indices)
    passive = Passive(rows.columns, press.spatial)
    rates = np.array([passive.rates(-rows.columns[:, driver]) for driver in drivers]).T
    rates[drivers] = np.eye(len(drivers))
    return rates


def _driver(press: Linkage) -> str:
    return f"joint {', '.join(map(repr, press.drivers))}"


def _joints(names: list[str]) -> str:
    return f"joint {names[0]!r}" if len(names) == 1 else f"joints {', '.join(map(repr, names))}"
