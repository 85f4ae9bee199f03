"""Which joints drive a linkage: what becomes of freedoms that the named ones leave, and a proposal where none is named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...common.quantities import Array
from ...common.results import Record
from ..document import Finding
from ..linkage import Linkage
from .freedoms import columns_at, conditioning, free_ways, generic_ways, pivots

WEAK = 0.02  # conditioning below which drivers hardly determine the linkage
# What names of joints say in files of robots and machines, as parts of words.
OF_MOTORS = ("mot", "driv", "act", "servo", "crank", "cyl")
OF_OTHERS = ("free", "passive", "rev", "ball", "univ", "rod", "coupler", "follower", "spring")


@dataclass(frozen=True, repr=False)
class Proposal(Record):
    """Joints that would drive a linkage well. None is ever taken without being named.

    Attributes:
        drivers: names of the joints, the argument of `load`.
        conditioning: how well they determine the linkage in its home pose: least singular value of their rows among the orthonormal ways in
            which it moves, angles in rad and travels in sizes of the linkage; 1 at best, 0 at a dead point [-].
        others: names of the second best set; empty if there is none.
        conditioning_of_others: of these [-].
    """

    drivers: tuple[str, ...]
    conditioning: float
    others: tuple[str, ...]
    conditioning_of_others: float

    @property
    def in_words(self) -> str:
        """The proposal as an argument of `load`, and the second best set."""
        if not self.drivers:
            return "no drivers: nothing moves that a motor could move"
        second = f"; next best drivers={list(self.others)!r} ({self.conditioning_of_others:.2f})" if self.others else ""
        return f"drivers={list(self.drivers)!r} (conditioning {self.conditioning:.2f} of 1{second})"


def is_press(press: Linkage) -> bool:
    """Whether a slide works, which is no driver. Every freedom of such a linkage has a driver, or a loop was forgotten."""
    return press.slide is not None and press.joints[press.slide_guide.joint] not in press.motors


def settle(press: Linkage) -> tuple[Linkage, tuple[Finding, ...]]:
    """The linkage with what its drivers leave free: spins and swings held, sprung joints, those of a floating base and others as passive
    coordinates. Of drivers that depend on each other independent ones are left. And warnings of these drivers.

    A press, and a linkage that cannot be put together, stay as they are where the drivers do not fit; `checks.assembly.errors` says why. So
    does one without drivers, unless springs and base are all that moves.
    """
    assembly, called = press.assembly, press.document.called("robot", press.name)
    if not assembly.closes or (assembly.determined and (is_press(press) or len(press.drivers) < 2)):
        return press, ()
    ways = _without_ratios(press, free_ways(press.structure, columns_at(press.structure, press.closed)))
    named = [press.joints.index(driver) for driver in press.drivers]
    if assembly.determined:
        return press, tuple(_weak(called, press.drivers, conditioning(ways, named)))
    if ways.shape[1] > generic_ways(press.structure, press.closed):
        return press, ()  # two assemblies meet here
    weights = np.zeros(press.model.nv)
    weights[named] = np.maximum(preferences(press)[named], 1e-2)  # one with a spring may be driven, if it is named
    independent = pivots(ways, weights)
    motors = tuple(name for name, joint in zip(press.drivers, named, strict=True) if joint in independent)
    free = press.undriven(motors)
    refused = free.of("passive") if not named else motors != press.drivers or free.of("swing", "passive") if is_press(press) else not motors
    if refused:
        return press, ()
    passive = free.of("spring", "base", "passive")
    findings = list(_weak(called, motors, conditioning(ways, [press.joints.index(name) for name in motors])))
    if dropped := [name for name in press.drivers if name not in motors]:
        problem = f"{len(named)} drivers are named, but only {len(motors)} move it independently in this pose"
        remedy = f"torques would not be unique, so it is loaded without {', '.join(dropped)}, as with drivers={list(motors)!r}"
        findings.append(Finding("warning", called, None, problem, remedy))
    return replace(press, drivers=(*motors, *passive), passive=passive, held=free.of("spin", "swing")), tuple(findings)


def _weak(called: str, drivers: Sequence[str], least: float) -> list[Finding]:
    """The warning of drivers that hardly determine a linkage."""
    if least >= WEAK:
        return []
    problem = f"drivers {', '.join(drivers)} hardly determine it: conditioning {least:.1g} of 1"
    return [Finding("warning", called, None, problem, "pp.propose_drivers(path) names better ones; or start from another pose")]


def propose(press: Linkage) -> Proposal:
    """Drivers of a linkage, whatever drives it now: those of the greatest motion that is not determined by the ones before, weighted by
    `preferences`. Spins, swings, springs and a floating base take no driver."""
    free = press.undriven(())
    taken = [place for place, each in zip(free.places, free.freedoms, strict=True) if each.kind != "passive"]
    still = _without_ratios(press, free_ways(press.structure, columns_at(press.structure, press.closed, len(press.held)), taken))
    weights = preferences(press)
    best = pivots(still, weights)

    def volume(joints: Sequence[int]) -> float:
        """What the greedy choice makes large: the product of weights and of parts that are independent of each other."""
        return float(np.prod(np.linalg.svd(weights[list(joints), None] * still[list(joints)], compute_uv=False)))

    further = [pivots(still, np.where(np.arange(len(weights)) == joint, 0.0, weights)) for joint in best]
    second = max((joints for joints in further if len(joints) == len(best)), key=volume, default=[])
    names = [tuple(name for j, name in enumerate(press.joints) if j in joints) for joints in (best, second)]
    return Proposal(names[0], conditioning(still, best) if best else 0.0, names[1], conditioning(still, second) if second else 0.0)


def _without_ratios(press: Linkage, ways: Array) -> Array:
    """Orthonormal ways (nv, k), in which a geared joint counts as much as the one that it follows, whatever the ratio."""
    units = np.ones(len(ways))
    for _ in press.couplings:  # as often as the longest train has pairs
        for pair in press.couplings:
            units[pair.follower] = units[pair.leader] * (abs(pair.multiplier) or 1.0)
    return np.asarray(np.linalg.qr(ways / units[:, None])[0])


def preferences(press: Linkage) -> Array:
    """(nv,) how probably a motor moves each joint: less the farther from the frame, more in a slide with limits and in one that is called
    so, less in one that carries no mass, follows in a gear or has effort limit 0. Nine of ten drivers that files name are so found."""
    weights = np.ones(press.model.nv)
    levels: list[int] = []
    followed = {contact.relation: contact.second - 1 for contact in press.contacts}  # gears are named as they drive each other
    followers = {followed.get(k, relation.joint) for k, relation in enumerate(press.relations)}
    limits = {joint.name: joint.limits for joint in press.document.description.joints}
    for joint, (name, parent) in enumerate(zip(press.joints, press.structure.parents, strict=True)):
        levels.append(0 if parent < 0 else 1 + levels[parent])
        lowered = name.lower()
        weights[joint] = (
            0.75 ** levels[joint]
            * (3.0 if not press.axes[joint].turns and limits.get(name) else 1.0)
            * (1.0 if press.model.inertias[joint + 1].mass else 0.2)
            * (0.2 if joint in followers else 1.0)
            * (1.0 if press.model.upperEffortLimit[joint] > 0.0 else 0.01)
            * (4.0 if any(part in lowered for part in OF_MOTORS) else 1.0)
            * (0.25 if any(part in lowered for part in OF_OTHERS) else 1.0)
        )
    weights[[press.joints.index(name) for name in (*press.sprung, *press.base)]] = 0.0
    return weights
