"""Kong 2025, conclusion (4): which bearing forces counterweights can lower at all, by how much, and what it costs.

Counterweights may be on crank (within 0.3 m of the shaft), rocker (0.6 m) and rod (0.3 m), as in docs/balancing.md. Every number is a
proved optimum of `balance`, with moments of inertia that are those of the counterweights' best shapes.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from pinpress.balancing.counterweights import Counterweight, with_counterweights
from pinpress.balancing.optimum import balance
from pinpress.balancing.problem import AddedMass, Criterion, Range, Target
from pinpress.balancing.regions import CounterweightRegion
from pinpress.balancing.result import BalancedPress
from pinpress.common.quantities import RPM
from pinpress.dynamics.inverse_dynamics import inverse_dynamics
from pinpress.dynamics.reactions import Reactions
from pinpress.kinematics.cycle import cycle
from pinpress.kinematics.motion import Motion
from pinpress.linkage.linkage import Linkage
from validation.pages import BEYOND, Grid, PageEntry

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
FAR = 0.8  # distance beyond E of a mass on the rod, outside of the regions [m]
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


def conclusion(press: Linkage) -> PageEntry:
    """What conclusion (4) would take, for the press before balancing."""
    motion = cycle(press, SPEED, points=POINTS)
    before = inverse_dynamics(press, motion)
    designs = {"the paper's": (inverse_dynamics(with_counterweights(press, PAPER), motion), f"{ADDED:.0f} kg on crank and rod")}
    for goal in ("A, vertical", "shaking force, x"):
        kept = unharmed(press, motion, before, goal)
        designs[f"least {goal}, none higher"] = inverse_dynamics(kept.press, motion), _listed(kept)
    columns = {words: BEARINGS[words] for words in ("A, x", "A, vertical")} | TORQUE | SHAKING
    compared = Grid(
        ("counterweights", "masses", "ranges in A to F that rise", *(f"{words} [%]" for words in columns)),
        tuple(
            (words, listed, _risen(before, after), *(f"{_change(before, after, each):+.2f}" for each in columns.values()))
            for words, (after, listed) in designs.items()
        ),
    )
    priced = Grid(
        ("range", f"largest fall with {ADDED:.0f} kg [%]", f"{FALL:g} % less takes", "rises most then"),
        tuple(
            (
                each.words,
                f"{round(each.most, 2) + 0.0:.2f}",
                *((each.listed, f"{each.rises}, {each.rise:+.0f} %") if each.mass else ("no mass within the radii", "")),
            )
            for each in prices(press, motion, before)
        ),
    )
    reason = (
        "The vertical force in F carries the slide's weight and inertia alone: no counterweight changes it. The one in E carries the"
        f" rod's too. Counterweights within {REGIONS[2].radius:g} m of the rod's pin do not lower it (tables; radii as in"
        f" [Balancing](balancing.md)); {FAR} m beyond E a mass on the rod does: 500 kg by {_far(press, motion, before, 500.0):.1f} %,"
        f" 3900 kg by {_far(press, motion, before, 3900.0):.0f} %. At best no range rises. A counterweight on the crank alone does this"
        " best: only A and the torque feel it. All this holds for the empty press."
    )
    return PageEntry(("Conclusion (4)",), "which bearing forces can fall, and at what price", BEYOND, (), reason, grids=(compared, priced))


def _balanced(press: Linkage, motion: Motion, minimise: Target, limits: Mapping[Target, float]) -> BalancedPress:
    return balance(press, motion, regions=REGIONS, minimise=minimise, limits=limits)


def _change(before: Reactions, after: Reactions, criterion: Criterion) -> float:
    """Relative change of a criterion [%]."""
    return 100 * (criterion.value(after) / criterion.value(before) - 1)


def _far(press: Linkage, motion: Motion, before: Reactions, mass: float) -> float:
    """Fall of the range of the vertical force in E by a mass on the rod beyond E [%]."""
    after = inverse_dynamics(with_counterweights(press, [Counterweight("rod", mass, (-FAR, 0.0, 0.0))]), motion)
    return -_change(before, after, BEARINGS["E, vertical"])


def _risen(before: Reactions, after: Reactions) -> str:
    risen = [words for words, criterion in BEARINGS.items() if _change(before, after, criterion) > ROUNDING]
    return f"{len(risen)} of {len(BEARINGS)}" if risen else "none"


def _listed(found: BalancedPress) -> str:
    return " and ".join(f"{weight.mass:.0f} kg on the {weight.link}" for weight in found.counterweights)
