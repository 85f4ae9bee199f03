"""The home pose of a linkage: the closed pose that is found first on a ladder of starts and of joints that are held.

A drawn pose that is closed is home as it is, whatever the limits of its joints. Else damped least squares (`engines.mounting`) close the
loops: from a pose that somebody named, from the drawn pose with the drivers where the file has them, with all joints free, from the middles
of the limits, and from random poses. The first pose that closes within the limits of the joints is home; without any, limits are left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..common.errors import AssemblyError, PinpressError, UnknownNameError, caution, cautions_collected, shown
from ..common.quantities import Array
from ..engines.mounting import CLOSED, STARTS, Mounted, Mounting, within
from ..engines.rank import PassiveJacobian
from .linkage import Linkage

ROUNDED = 1e-3  # misfit that rounded numbers may leave where equations are redundant
NEAR = 0.05  # moves of joints up to which Newton's method reaches the same pose as damped steps [rad, lengths of the linkage]
BESIDE = 0.3  # distance of the drivers from a pose in which assemblies meet, where these are told apart [rad, lengths of the linkage]
FAR = 0.8  # moves of joints from which on closing often ends in another assembly than was meant [rad, lengths of the linkage]
MOST_LISTED = 4
MOST_ALIKE = 6  # starts one after the other that end at the same misfit, after which no better one is expected
POSE, HOME = "pose=", "the <home> of the file"


class _Rung(NamedTuple):
    """A start (nv,), the joints that are held there, and whether the others keep to their limits."""

    how: str
    start: Array
    held: Sequence[int]
    limited: bool = True


def mount(press: Linkage, pose: Mapping[str, float] | None = None) -> Linkage:
    """The linkage with its home pose; with the best one that was found if its loops do not close, which `Linkage.assembly` then says.

    Args:
        press: the linkage as drawn.
        pose: coordinates of some of its joints, by their names, near which it is to be put together [rad or m].

    Raises:
        UnknownNameError: the pose names a joint that the linkage does not have.
        AssemblyError: the loops do not close near the pose.
    """
    home = _pose(press, pose or {})
    of_file = press.document.description.home
    if not home and not of_file and closed_as_drawn(press):
        return press
    if not home and of_file:  # a file that pinpress wrote, or a keyframe with all joints, is closed but for rounding
        as_it_stands = _near(press, of_file, HOME)[0]
        placed = replace(press, home=tuple(as_it_stands.start.tolist()), mounted=as_it_stands.how)
        if closes_nearby(placed, as_it_stands.start):
            return replace(placed, home=tuple(placed.closed.tolist()))
    mounting = Mounting(press.structure)
    if home and closed_as_drawn(press) and not press.assembly.determined:
        rung = _near(press, home, POSE)[0]
        # Assemblies meet as drawn, so that several may be near the pose: the one that is farthest from locking.
        if poses := mounting.assemblies(rung.start, rung.held, 2 * BESIDE):
            chosen = max(poses, key=lambda pose: _margin(press, pose))
            _doubt(press, mounting, home, chosen)
            return replace(press, home=tuple(chosen.tolist()), mounted=rung.how)
    ladder: list[Iterable[_Rung]] = [_near(press, home, POSE)]
    if not home:
        ladder = [(*_near(press, of_file, HOME), *_as_drawn(press)), _anywhere(press, mounting), _as_drawn(press, limited=False)]
    best, how = _climb(mounting, ladder)
    if home and best.misfit > ROUNDED:
        gap = 1e3 * best.misfit * press.size
        named = ", ".join(f"{name} {value:g}" for name, value in home.items())
        problem = f"{press.file}: its loops do not close near the pose {named}: at best they are {gap:.3g} mm apart"
        raise AssemblyError(f"{problem}; give another pose, or fewer joints of it", 0.0, gap / 1e3, 0)
    position = mounting.without_turns(best.position)
    if not how.startswith(f"{POSE} with all joints free"):  # of which `checks` warn
        _doubt(press, mounting, home, position)
    return replace(press, home=tuple(position.tolist()), mounted=how)


def _doubt(press: Linkage, mounting: Mounting, named: Mapping[str, float], position: Array) -> None:
    """Warn of a home pose (nv,) in which a joint is far from where a pose names it."""
    wanted, places = position.copy(), [press.joints.index(name) for name in named]
    wanted[places] = list(named.values())
    for name, j in zip(named, places, strict=True):
        if mounting.apart(wanted, position)[j] > FAR:
            unit = "rad" if press.axes[j].turns else "m"
            problem = f"the loops close with joint {name!r} at {position[j]:.6g} {unit}, far from {named[name]:g} of pose="
            caution(f"{press.file}: {problem}; another assembly may be meant: name a pose nearer to it, or fewer joints")


def _climb(mounting: Mounting, ladder: Iterable[Iterable[_Rung]]) -> tuple[Mounted, str]:
    """The first closed pose, and how it was found; else the pose with the least misfit. One that is closed but for rounding ends the climb
    after its part of the ladder."""
    best, how = Mounted(np.empty(0), np.inf), ""
    for rungs in ladder:
        alike = 0
        for rung in rungs:
            reached = mounting.close(rung.start, rung.held, rung.limited)
            alike = alike + 1 if abs(reached.misfit - best.misfit) <= 1e-6 * best.misfit < np.inf else 0
            if reached.misfit < best.misfit:
                best, how = reached, rung.how
            if best.misfit <= CLOSED or alike == MOST_ALIKE:
                break
        if best.misfit <= ROUNDED:
            break
    return best, how


def nearby(press: Linkage) -> list[dict[str, float]]:
    """Poses that choose one of the assemblies near a closed pose in which some meet: coordinates by the names of joints [rad or m].

    With the drivers a little further on, either way, closed poses with the other joints nearby differ by the assembly that they are of."""
    mounting, drivers = Mounting(press.structure), list(press.driver_indices)
    able = [j for j in range(press.model.nv) if j not in drivers]
    found: list[dict[str, float]] = []
    for way in (1.0, -1.0):
        start = press.closed.copy()
        start[drivers] += (way * BESIDE * mounting.lengths * np.where(press.structure.turns, 1.0, 0.1))[drivers]
        if not able or len(poses := mounting.assemblies(start, drivers, 2 * BESIDE)[:MOST_LISTED]) <= len(found):
            continue
        of_drivers = {name: float(start[j]) for name, j in zip(press.drivers, drivers, strict=True)}
        rounded = [
            {name: float(f"{value:.3g}") for name, value in {**of_drivers, **each}.items()}
            for each in mounting.told_apart(poses, len(poses), able)
        ]
        found = [each for each, pose in zip(rounded, poses, strict=True) if _chooses(press, mounting, each, pose)]
    return found


def _chooses(press: Linkage, mounting: Mounting, named: Mapping[str, float], pose: Array) -> bool:
    """Whether coordinates of joints choose the assembly of a pose (nv,)."""
    try:
        with cautions_collected():
            home = mount(replace(press, home=(), mounted=""), named).home
    except AssemblyError:
        return False
    return bool(mounting.apart(np.array(home), pose).max() < 0.05)


def _margin(press: Linkage, pose: Array) -> float:
    """How far a pose (nv,) is from locking: the least singular value of the columns of the passive joints."""
    passive = PassiveJacobian(press.equations(pose).columns, press.structure)
    return float(passive.values.min(initial=1.0)) if len(passive.values) == len(passive.joints) else 0.0


def _pose(press: Linkage, pose: Mapping[str, float]) -> dict[str, float]:
    """The pose that was given; raises errors of its names and numbers."""
    for name, value in pose.items():
        if name not in press.joints:
            raise UnknownNameError("moving joint", name, press.joints)
        if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not np.isfinite(value):
            raise PinpressError(f"pose of joint {name!r} is {shown(value)}: give a finite number, in rad or m")
    return {name: float(value) for name, value in pose.items()}


def closed_as_drawn(press: Linkage) -> bool:
    """Whether the drawn pose is closed, but for what a short step of Newton's method closes."""
    return closes_nearby(press, press.assembly.start)


def closes_nearby(press: Linkage, start: Array) -> bool:
    """Whether Newton's method closes the home pose within a short step of a start (nv,)."""
    return press.assembly.closes and bool((np.abs(press.closed - start) <= NEAR * press.lengths).all())


def _near(press: Linkage, pose: Mapping[str, float], how: str) -> tuple[_Rung, ...]:
    """Rungs near a pose, from the home of the file: its joints held, then only the drivers among them, then none."""
    start, places = press.assembly.start.copy(), {name: j for j, name in enumerate(press.joints)}
    named = [places[name] for name in pose]
    if not named:
        return ()
    for name, value in {**press.document.description.home, **pose}.items():
        start[places[name]] = value
    drivers = [joint for joint in named if joint in press.driver_indices]
    tried = [("as it stands", named), *([("with the drivers held", drivers)] if drivers else []), ("with all joints free", ())]
    ways = (("", True), (", outside limits", False))
    return tuple(_Rung(f"{how} {said}{beyond}", start, held, limited) for beyond, limited in ways for said, held in tried)


def _as_drawn(press: Linkage, limited: bool = True) -> Iterator[_Rung]:
    """Rungs from the drawn pose, within limits or without."""
    start, beyond = press.assembly.start, "" if limited else ", outside limits"
    if not limited or within(press.structure, start)[list(press.driver_indices)].all():
        yield _Rung(f"the drawn pose with the drivers held{beyond}", start, press.driver_indices, limited)
    yield _Rung(f"the drawn pose with all joints free{beyond}", start, (), limited)


def _anywhere(press: Linkage, mounting: Mounting) -> Iterator[_Rung]:
    """Rungs from poses that nobody named."""
    start, finite = press.assembly.start, np.isfinite(mounting.lower) & np.isfinite(mounting.upper)
    middle = start.copy()
    middle[finite] = 0.5 * (mounting.lower[finite] + mounting.upper[finite])
    yield _Rung("the middles of the limits with all joints free", middle, ())
    random = np.random.default_rng(0)
    for k in range(STARTS):
        away = (0.3 + 2.7 * k / STARTS) * random.uniform(-1.0, 1.0, len(start)) * mounting.lengths
        yield _Rung(f"random start {k + 1} with all joints free", (start, middle)[k % 2] + away, ())
