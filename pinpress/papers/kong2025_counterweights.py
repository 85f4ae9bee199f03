"""Kong 2025, conclusion (4): which bearing forces counterweights can lower at all, by how much, and what it costs.

Counterweights may be on crank (within 0.3 m of the shaft), rocker (0.6 m) and rod (0.3 m), as in docs/balancing.md. Every number is a
proved optimum of `balance`, with moments of inertia that are those of the counterweights' best shapes.
"""

from collections.abc import Mapping

from ..balancing.counterweights import Counterweight, with_counterweights
from ..balancing.optimum import balance
from ..balancing.problem import AddedMass, Criterion, Range, Target
from ..balancing.regions import CounterweightRegion
from ..balancing.result import BalancedPress
from ..common.quantities import RPM
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import Motion, cycle
from ..linkage.linkage import Linkage
from .pages import BEYOND, PageEntry, Row

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


def conclusion(press: Linkage) -> PageEntry:
    """What conclusion (4) would take, for the press before balancing."""
    motion = cycle(press, SPEED, points=POINTS)
    before = inverse_dynamics(press, motion)
    paper = inverse_dynamics(with_counterweights(press, PAPER), motion)
    limits: dict[Target, float] = {AddedMass(): ADDED, **{criterion: criterion.value(before) for criterion in (TORQUE | BEARINGS).values()}}
    rows = [Row("the paper's counterweights: ranges in A to F that rise", "", _risen(before, paper))]
    for goal in ("A, vertical", "shaking force, x"):
        kept = _balanced(press, motion, (BEARINGS | SHAKING)[goal], limits)
        after = inverse_dynamics(kept.press, motion)
        rows += [
            Row(f"least {goal}, none above what it was, at most {ADDED:.0f} kg: counterweights", "", _listed(kept)),
            Row(f"least {goal}: ranges in A to F that rise", "", _risen(before, after)),
        ]
        for words, each in ({words: BEARINGS[words] for words in ("A, x", "A, vertical")} | TORQUE | SHAKING).items():
            rows.append(Row(f"least {goal}: {words}, change of the range [%]", "", _change(before, after, each), places=2))
    for words, criterion in (TORQUE | BEARINGS).items():
        most = _balanced(press, motion, criterion, {AddedMass(): ADDED})
        change = _change(before, inverse_dynamics(most.press, motion), criterion)
        rows.append(Row(f"{words}: largest fall of the range with at most {ADDED:.0f} kg [%]", "", change, places=2))
        taken = _price(press, motion, before, criterion) if most.added_mass else "no mass does it"
        rows.append(Row(f"{words}: what {FALL:g} % less takes", "", taken))
    reason = (
        "Conclusion (4) says that the torque and the forces in all bearings fall. With the paper's counterweights the ranges in B to E"
        " rise (Fig. 6), and no counterweights on crank, rocker and rod could do what it says: the vertical force in F carries the"
        " slide's weight and inertia, which they do not touch, and that in E the rod's as well, to which they only add. The most that can"
        " be had is that none rises, and then a counterweight on the crank alone is best: the crank turns evenly, so that only A and the"
        " torque feel it. A third of the paper's mass there lowers the horizontal shaking force by 88 %, where the paper's"
        f" counterweights reach 47 %, and no bearing pays. A fall that one would notice, {FALL:g} %, ten times the printed one of the"
        " torque, takes one to eight tonnes in all bearings but D, and the horizontal shaking force pays. All this is the empty press: the"
        " force of a process adds to the bearings whatever the counterweights are."
    )
    return PageEntry(("Conclusion (4)",), "which bearing forces can fall, and at what price", BEYOND, tuple(rows), reason)


def _balanced(press: Linkage, motion: Motion, minimise: Target, limits: Mapping[Target, float]) -> BalancedPress:
    return balance(press, motion, regions=REGIONS, minimise=minimise, limits=limits)


def _price(press: Linkage, motion: Motion, before: Reactions, criterion: Criterion) -> str:
    """The least mass for a noticeable fall of a range, where it goes, and which other range rises most."""
    found = _balanced(press, motion, AddedMass(), {criterion: (1 - FALL / 100) * criterion.value(before)})
    after = inverse_dynamics(found.press, motion)
    others = {words: each for words, each in (TORQUE | BEARINGS | SHAKING).items() if each != criterion}
    changes = {words: _change(before, after, each) for words, each in others.items()}
    dearest = max(changes, key=changes.__getitem__)
    return f"{_listed(found)}; rises most: {dearest}, {changes[dearest]:+.0f} %"


def _change(before: Reactions, after: Reactions, criterion: Criterion) -> float:
    """Relative change of a criterion [%]."""
    return 100 * (criterion.value(after) / criterion.value(before) - 1)


def _risen(before: Reactions, after: Reactions) -> str:
    risen = [words for words, criterion in BEARINGS.items() if _change(before, after, criterion) > ROUNDING]
    return f"{len(risen)} of {len(BEARINGS)}: {'; '.join(risen)}" if risen else "none"


def _listed(found: BalancedPress) -> str:
    return " and ".join(f"{weight.mass:.0f} kg on the {weight.link}" for weight in found.counterweights)
