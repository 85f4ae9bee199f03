"""Two members pressed against each other: tie rods and uprights, a screw and its nut, the two gibs of a guide.

While both touch, a load from outside stretches both together, so that the joint is as stiff as the sum, and the load adds only its share to
each. The load at which one of them is free is the larger, the stiffer that member is compared with the other; from there on the other
carries alone (any textbook of machine elements, preloaded bolts).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...common.arguments import numbers, positive
from ...common.errors import caution
from ...common.frozen import Frozen
from ...common.parameters import parameter
from ...common.quantities import Array
from ...loads.process import ForceInterval

STIFFEST = 1e15  # [N/m, N m/rad], beyond other sizes, as what counts as rigid is given so; rounding of places is then a force of 0.1 N
FAINT = 1e3  # no joint of a press is preloaded by less [N]


@dataclass(frozen=True)
class PreloadedJoint(Frozen):
    """A joint of two members with a preload, in place of a stiffness in `Stiffness`.

    A positive load pulls: it adds to the loaded member and takes from the relieved one. Of a frame these are tie rods and uprights; of a
    rod with a screw, the screw and its lock; of a guide the gib that the slide is pressed on and the one opposite.

    Attributes:
        loaded: stiffness of the member that a positive load adds to, all tie rods together [N/m].
        relieved: stiffness of the member that it takes from, all uprights together [N/m].
        preload: force with which both press on each other without a load [N].

    Raises:
        PinpressError: a number is not positive.

    Warns:
        PinpressWarning: the preload is below 1 kN: it may be in kN.
    """

    loaded: float = field(metadata=parameter("N/m", "positive"))
    relieved: float = field(metadata=parameter("N/m", "positive"))
    preload: float = field(metadata=parameter("N", "positive"))

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("loaded", "relieved"):
            object.__setattr__(self, name, positive(f"PreloadedJoint: {name}", getattr(self, name), "N/m", STIFFEST))
        object.__setattr__(self, "preload", positive("PreloadedJoint: preload", self.preload, "N"))
        if self.preload < FAINT:
            caution(f"PreloadedJoint: preload is {self.preload:g} N: if kN are meant, write {self.preload:g}e3")

    @property
    def stiffness(self) -> float:
        """Stiffness while both members touch [N/m]."""
        return self.loaded + self.relieved

    @property
    def opening_load(self) -> float:
        """Load at which the relieved member is free, as the uprights lift off [N]."""
        return self.preload * self.stiffness / self.relieved

    @property
    def slack_load(self) -> float:
        """Load against it, as a positive number, at which the loaded member is free, as the tie rods go slack [N]."""
        return self.preload * self.stiffness / self.loaded

    def elongation(self, load: ArrayLike) -> Array:
        """Elongation by loads of any shape [m]."""
        loads = numbers("PreloadedJoint: load", load, unit="N")
        alone = np.where(loads > 0, self.loaded, self.relieved)
        closed = np.clip(loads, -self.slack_load, self.opening_load)
        return np.asarray(closed / self.stiffness + (loads - closed) / alone)

    def forces(self, load: ArrayLike) -> tuple[Array, Array]:
        """Force of the loaded member and force of the relieved one under loads of any shape, both as large as the preload without a load
        and never negative [N]. Their difference is the load."""
        stretched = self.elongation(load)
        return np.maximum(self.preload + self.loaded * stretched, 0.0), np.maximum(self.preload - self.relieved * stretched, 0.0)


def closed_stiffness(given: object) -> object:
    """The stiffness of a part with both members of its joint touching; anything but a `PreloadedJoint` is returned unchanged."""
    return given.stiffness if isinstance(given, PreloadedJoint) else given


# ----------------------------------------------------------------------------------------------------------------------- in elastic motion


@dataclass(frozen=True)
class JointSpring:
    """A preloaded joint in series with a spring, as a die-height screw is with the pin at the end of its rod.

    While both members touch, the whole is as stiff as f(loaded + relieved), with f(k) = 1 / (1 / (ends k) + 1 / series); with one member
    alone f(loaded), or f(relieved). Three springs side by side do the same: one that always holds, of f(loaded) + f(relieved) -
    f(loaded + relieved), never negative as f is concave, and two members of their own that push one way each.

    Attributes:
        name: of the part that has the joint.
        bearing: number of the bearing with whose spring it yields; -1: the columns of a crown.
        joint: stiffnesses of both members, and their preload.
        ends: number of bearings, this one among them, each of which has the same share of the joint's elongation.
        series: stiffness of the spring in series; infinite: there is none [N/m].
        number: which of the bearing's springs it is.
    """

    name: str
    bearing: int
    joint: PreloadedJoint
    ends: int = 1
    series: float = math.inf
    number: int = 0

    def _in_series(self, stiffness: float) -> float:
        return 1 / (1 / (self.ends * stiffness) + 1 / self.series)

    def open(self, spring: int, damping: float) -> OpenJoint:
        """The joint whose members may lift off, in place of the spring of this number, with its damper while closed [N s/m]."""
        joint = self.joint
        closed, pulled, pressed = map(self._in_series, (joint.stiffness, joint.loaded, joint.relieved))
        members = closed - pressed, closed - pulled
        reach = joint.slack_load / closed, joint.opening_load / closed
        always = pulled + pressed - closed if math.isfinite(self.series) else 0.0
        rest = (members[0] * reach[0] - members[1] * reach[1]) / always if always > 0 else 0.0
        share = damping / closed
        dampers = share * members[0], share * members[1]
        return OpenJoint(self.name, self.bearing, spring, always, share * always, rest, members, dampers, reach)


@dataclass(frozen=True)
class OpenJoint:
    """A preloaded joint as the spring that always holds and two members, each of which pushes until its force vanishes.

    With the extension x, positive where the joint is pulled, the loaded member pulls with k (reach + x) + c x' and the relieved one pushes
    with k (reach - x) - c x'. Neither does the opposite, so that a damped member lifts off before its spring is relaxed.

    Attributes:
        name: of the part.
        bearing: number of the bearing that it is part of; -1: the columns of a crown.
        spring: number of the spring in whose place it stands.
        always: stiffness of the spring that always holds [N/m].
        damping: its damper [N s/m].
        rest: extension at which it is slack [m].
        members: stiffnesses of the loaded and of the relieved member [N/m].
        dampers: of both [N s/m].
        reach: how far the joint is pressed until the loaded member is slack, and pulled until the relieved one is [m].
    """

    name: str
    bearing: int
    spring: int
    always: float
    damping: float
    rest: float
    members: tuple[float, float]
    dampers: tuple[float, float]
    reach: tuple[float, float]

    def contacts(self) -> tuple[ForceInterval, ForceInterval]:
        """The loaded and the relieved member, as contacts along the extension."""
        loaded, relieved = (
            partial(_member, *member) for member in zip(self.members, self.dampers, (-self.reach[0], self.reach[1]), strict=True)
        )
        return (
            ForceInterval(math.inf, -self.reach[0], loaded, one_sided=True, heeds_velocity=self.dampers[0] > 0, sense=-1),
            ForceInterval(self.reach[1], -math.inf, relieved, one_sided=True, heeds_velocity=self.dampers[1] > 0),
        )

    def strains(self, extension: Array) -> tuple[Array, Array]:
        """By how much (n,) the loaded member is stretched, and the relieved one pressed [m]."""
        return np.maximum(self.reach[0] + extension, 0.0), np.maximum(self.reach[1] - extension, 0.0)

    def spring_force(self, extension: Array) -> Array:
        """Force (n,) of the springs of both members along the extension [N]."""
        stretched, pressed = self.strains(extension)
        return self.members[1] * pressed - self.members[0] * stretched

    def spring_slope(self, extension: Array) -> Array:
        """Minus the derivative (n,) of `spring_force` [N/m]."""
        stretched, pressed = self.strains(extension)
        return self.members[1] * (pressed > 0) + self.members[0] * (stretched > 0)

    def stored_energy(self, extension: Array) -> Array:
        """Energy (n,) in the springs of both members [J]."""
        stretched, pressed = self.strains(extension)
        return np.asarray(0.5 * (self.members[0] * stretched**2 + self.members[1] * pressed**2))


def _member(stiffness: float, damping: float, touching: float, place: Any, rate: Any) -> Any:
    return stiffness * (touching - place) - damping * rate
