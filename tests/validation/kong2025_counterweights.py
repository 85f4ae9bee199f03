"""Kong 2025, conclusion (4): which bearing forces counterweights can lower at all, by how much, and what it costs.

Counterweights may be on crank (within 0.3 m of the shaft), rocker (0.6 m) and rod (0.3 m), as in docs/balancing.md. Every number is a
proved optimum of `balance`, with moments of inertia that are those of the counterweights' best shapes.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from validation.rows import Table

from pinpress import RPM, Linkage, Motion, Reactions, cycle, inverse_dynamics
from pinpress.balancing import AddedMass, BalancedPress, Counterweight, CounterweightRegion, Range, balance, with_counterweights
from pinpress.balancing.problem import Criterion, Target

SPEED = 70 * RPM
POINTS = 720
PAPER = (Counterweight("crank", 605.496, (-0.1428, 0.0, 0.0)), Counterweight("rod", 55.536, (-0.0456, 0.0, 0.0)))
ADDED = sum(weight.mass for weight in PAPER)  # [kg]
FALL = 18.0  # fall of a range that one would notice, ten times that which table 2 prints for the torque [%]
REGIONS = (CounterweightRegion("crank", radius=0.3), CounterweightRegion("rocker", radius=0.6), CounterweightRegion("rod", radius=0.3))
AXES = {"x": "x", "vertical": "z"}
BEARINGS = {f"{pin}, {words}": Range("bearing_force", axis, bearing=pin) for pin in "ABCDEF" for words, axis in AXES.items()}
TORQUE = {"torque": Range("driving_torque")}
SHAKING = {f"shaking force, {words}": Range("shaking_force", axis) for words, axis in AXES.items()}
ROUNDING = 1e-4  # a change that is less is none [%]


@dataclass(frozen=True, eq=False)
class Price:
    """What counterweights can do for the range of one force or torque.

    Attributes:
        words: the force or torque.
        most: largest fall with as much mass as the paper adds [%].
        mass: least mass for a fall that one would notice [kg]; None where no mass within the radii does it.
        listed: where that mass goes.
        rises: name of the range that rises most then.
        rise: its change [%].
    """

    words: str
    most: float
    mass: float | None
    listed: str = ""
    rises: str = ""
    rise: float = 0.0


def prices(press: Linkage, motion: Motion, before: Reactions) -> tuple[Price, ...]:
    """The price of the torque and of every component of the bearing forces."""
    return tuple(_price(press, motion, before, words) for words in TORQUE | BEARINGS)


def _price(press: Linkage, motion: Motion, before: Reactions, words: str) -> Price:
    criterion = (TORQUE | BEARINGS)[words]
    most = _balanced(press, motion, criterion, {AddedMass(): ADDED})
    fall = _change(before, inverse_dynamics(most.press, motion), criterion)
    if not most.added_mass:
        return Price(words, fall, None)
    found = _balanced(press, motion, AddedMass(), {criterion: (1 - FALL / 100) * criterion.value(before)})
    after = inverse_dynamics(found.press, motion)
    others = {name: each for name, each in (TORQUE | BEARINGS | SHAKING).items() if name != words}
    changes = {name: _change(before, after, each) for name, each in others.items()}
    rises = max(changes, key=changes.__getitem__)
    return Price(words, fall, found.added_mass, _listed(found), rises, changes[rises])


def unharmed(press: Linkage, motion: Motion, before: Reactions, goal: str) -> BalancedPress:
    """The least range of a force with as much mass as the paper adds at most, no range of torque and bearing forces above what it was."""
    limits: dict[Target, float] = {criterion: criterion.value(before) for criterion in (TORQUE | BEARINGS).values()}
    return _balanced(press, motion, (BEARINGS | SHAKING)[goal], {AddedMass(): ADDED, **limits})


def compared(press: Linkage) -> Table:
    """The paper's counterweights, and those with which no range rises, for the press before balancing."""
    motion = cycle(press, SPEED, points=POINTS)
    before = inverse_dynamics(press, motion)
    designs = {"the paper's": (inverse_dynamics(with_counterweights(press, PAPER), motion), f"{ADDED:.0f} kg on crank and rod")}
    for goal in ("A, vertical", "shaking force, x"):
        kept = unharmed(press, motion, before, goal)
        designs[f"least {goal}, none higher"] = inverse_dynamics(kept.press, motion), _listed(kept)
    columns = {words: BEARINGS[words] for words in ("A, x", "A, vertical")} | TORQUE | SHAKING
    rows = (
        (words, listed, _risen(before, after), *(f"{_change(before, after, criterion):+.2f}" for criterion in columns.values()))
        for words, (after, listed) in designs.items()
    )
    return Table(("counterweights", "masses", "ranges in A to F that rise", *(f"{words} [%]" for words in columns)), tuple(rows))


def priced(press: Linkage) -> Table:
    """What a noticeable fall of each range takes."""
    motion = cycle(press, SPEED, points=POINTS)
    rows = []
    for price in prices(press, motion, inverse_dynamics(press, motion)):
        cost = (price.listed, f"{price.rises}, {price.rise:+.0f} %") if price.mass else ("no mass within the radii", "")
        rows.append((price.words, f"{round(price.most, 2) + 0.0:.2f}", *cost))
    return Table(("range", f"largest fall with {ADDED:.0f} kg [%]", f"{FALL:g} % less takes", "rises most then"), tuple(rows))


def _balanced(press: Linkage, motion: Motion, minimise: Target, limits: Mapping[Target, float]) -> BalancedPress:
    return balance(press, motion, regions=REGIONS, minimise=minimise, limits=limits)


def _change(before: Reactions, after: Reactions, criterion: Criterion) -> float:
    """Relative change of a criterion [%]."""
    return 100 * (criterion.value(after) / criterion.value(before) - 1)


def _risen(before: Reactions, after: Reactions) -> str:
    risen = [words for words, criterion in BEARINGS.items() if _change(before, after, criterion) > ROUNDING]
    return f"{len(risen)} of {len(BEARINGS)}" if risen else "none"


def _listed(found: BalancedPress) -> str:
    return " and ".join(f"{weight.mass:.0f} kg on the {weight.link}" for weight in found.counterweights)
