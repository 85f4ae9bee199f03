"""Two members pressed against each other: tie rods and uprights, a screw and its nut, the two gibs of a guide.

While both touch, a load from outside stretches both together, so that the joint is as stiff as the sum, and the load adds only its share
to each. The load at which one of them is free is the larger, the stiffer that one is beside the other; from there on the other carries
alone (any textbook of machine elements, preloaded bolts).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...common.arguments import numbers, positive
from ...common.errors import caution
from ...common.frozen import Frozen
from ...common.quantities import Array

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

    loaded: float
    relieved: float
    preload: float

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
        given = numbers("PreloadedJoint: load", load, unit="N")
        alone = np.where(given > 0, self.loaded, self.relieved)
        closed = np.clip(given, -self.slack_load, self.opening_load)
        return np.asarray(closed / self.stiffness + (given - closed) / alone)

    def forces(self, load: ArrayLike) -> tuple[Array, Array]:
        """Force of the loaded member and force of the relieved one under loads of any shape, both as large as the preload without a load
        and never negative [N]. Their difference is the load."""
        stretched = self.elongation(load)
        return np.maximum(self.preload + self.loaded * stretched, 0.0), np.maximum(self.preload - self.relieved * stretched, 0.0)


def closed_stiffness(given: object) -> object:
    """The stiffness of a part with both members of its joint touching; anything but a `PreloadedJoint` is returned unchanged."""
    return given.stiffness if isinstance(given, PreloadedJoint) else given
