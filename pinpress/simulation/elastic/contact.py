"""Pins with clearance: the journal flies within the bearing's clearance, touches the bearing, and is thrown back.

With the distance e of the journal's centre from that of the bearing, the radial clearance c and the depth d = e - c, the bearing pushes the
journal back along the line of both centres with the force N:

- "linear": N = k d + b d', spring and damper side by side.
- "hertz": N = K d^1.5 (1 + X d' / v), with the speed v at which the journal touches.

The contact ends where N vanishes: it never pulls, so that a damped contact ends before the depth does. For the restitution e, speed after
by speed before, any K, exponent and mass give the same condition on X, by integrating d' dd' / (1 + X d' / v) from v to -e v:

    X - ln(1 + X) = -e X - ln(1 - e X)

The factors in common use, 3/4 (1 - e^2) (Lankarani and Nikravesh 1990) and 8/5 (1 - e)/e (Flores et al. 2011), approximate its solution:
for e = 0.5 they give restitutions of 0.725 and 0.470.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ...common import plausibility
from ...common.arguments import number
from ...common.errors import PinpressError, caution, shown
from ...common.numerics import sign_change
from ...common.parameters import parameter
from ...loads.process import ForceInterval

LAWS = ("linear", "hertz")


@dataclass(frozen=True)
class Clearance:
    """The clearance of a pin, and its contact.

    Attributes:
        radial: radius of the bearing less radius of the journal [m].
        law: "linear", with the stiffness and the damper that `Elastic` gives to this bearing, or "hertz".
        restitution: of the contact by "hertz", speed after by speed before, above 0, at most 1 [-].
        hertz_stiffness: K of the contact by "hertz" [N/m^1.5], see `hertz_stiffness`.
    """

    radial: float = field(metadata=parameter("m", "positive"))
    law: str = "linear"
    restitution: float | None = field(default=None, metadata=parameter("-", "positive"))
    hertz_stiffness: float | None = field(default=None, metadata=parameter("N/m^1.5", "positive"))

    def __post_init__(self) -> None:
        radial = number("Clearance: radial", self.radial, "m", positive=True)
        if not radial < 0.1:
            raise PinpressError(f"Clearance: radial is {radial:g} m: give the radial clearance in m, such as 5e-5")
        if radial > 2e-3:  # no bearing of a press is so loose
            caution(f"Clearance: radial is {radial:g} m, {1e3 * radial:g} mm: give it in m, {1e-3 * radial:g} if mm are meant")
        if not isinstance(self.law, str) or self.law not in LAWS:
            raise PinpressError(f"Clearance: law is {shown(self.law)}: give one of {', '.join(map(repr, LAWS))}")
        of_hertz = {"restitution": self.restitution, "hertz_stiffness": self.hertz_stiffness}
        for name, value in of_hertz.items():
            if (value is None) == (self.law == "hertz"):
                need = "give it" if value is None else "leave it out, or give law='hertz'"
                raise PinpressError(f"Clearance: {name} belongs to the law 'hertz': {need}")
        if self.restitution is not None and not 0.0 < number("Clearance: restitution", self.restitution) <= 1.0:
            raise PinpressError(f"Clearance: restitution is {self.restitution:g}: give a number above 0, at most 1")
        if self.hertz_stiffness is not None:
            number("Clearance: hertz_stiffness", self.hertz_stiffness, "N/m^1.5", positive=True)


def hertz_stiffness(bearing_radius: float, journal_radius: float, modulus: float = 2.07e11, poisson: float = 0.3) -> float:
    """K of a contact by Hertz between a journal and its bearing of one material, 4 / (3 (s + s)) sqrt(R_b R_j / (R_b - R_j)) with
    s = (1 - nu^2) / E [N/m^1.5], as for spheres (Lankarani and Nikravesh 1990).

    Args:
        bearing_radius: R_b [m].
        journal_radius: R_j, below that of the bearing [m].
        modulus: E of both [N/m2].
        poisson: nu of both [-].

    Raises:
        PinpressError: a value is out of range.
    """
    outer, inner = (
        number("bearing_radius", bearing_radius, "m", positive=True),
        number("journal_radius", journal_radius, "m", positive=True),
    )
    if not inner < outer:
        raise PinpressError(
            f"journal_radius is {inner:g}, not below bearing_radius, {outer:g}: give radii whose difference is the clearance [m]"
        )
    ratio = number("poisson", poisson)
    if not 0.0 <= ratio <= 0.5:
        raise PinpressError(f"poisson is {ratio:g}: give a number from 0 to 0.5")
    plausibility.cylinder("hertz_stiffness", "bearing_radius", outer)
    young = number("modulus", modulus, "N/m2", positive=True)
    plausibility.modulus(young)
    softness = (1 - ratio**2) / young
    return 4 / (6 * softness) * math.sqrt(outer * inner / (outer - inner))


def damping_factor(restitution: float) -> float:
    """X of the module for a restitution [-]; 0 for one of 1.

    Raises:
        PinpressError: the restitution is not above 0, or above 1.
    """
    e = number("restitution", restitution)
    if not 0.0 < e <= 1.0:
        raise PinpressError(f"restitution is {e:g}: give a number above 0, at most 1")
    if e >= 1 - 1e-9:  # it loses nothing
        return 0.0

    def missing(share: float) -> float:  # X = share / e, below which ln(1 - e X) is finite
        x = share / e
        return (x - math.log1p(x)) + (share + math.log1p(-share))

    low, high = 1e-12, 1 - 1e-15
    if missing(high) > 0:  # almost plastic: X is beyond floating point
        raise PinpressError(f"restitution is {e:g}: give one of 0.03 or more")
    return sign_change(missing, low, high, 1e-15) / e


@dataclass(frozen=True, eq=False)
class OpenPin:
    """A pin with clearance between two bodies.

    Attributes:
        bearing: its number.
        bodies: of points 1 and 2.
        arms: points 1 and 2 from the centres of mass of their bodies, in the drawn pose [m].
        clearance: the clearance.
        stiffness: of the linear contact [N/m].
        damping: of the linear contact [N s/m].
    """

    bearing: int
    bodies: tuple[int, int]
    arms: tuple[complex, complex]
    clearance: Clearance
    stiffness: float
    damping: float

    def contact(self) -> ForceInterval:
        """The contact along the negative distance of both centres, measured from the negative clearance: minus the depth."""
        if self.clearance.law == "linear":
            law = partial(_linear, self.stiffness, self.damping)
            return ForceInterval(0.0, -math.inf, law, one_sided=True, heeds_velocity=self.damping > 0)
        assert self.clearance.hertz_stiffness is not None
        assert self.clearance.restitution is not None
        stiffness, factor = self.clearance.hertz_stiffness, damping_factor(self.clearance.restitution)
        return HertzContact(0.0, -math.inf, partial(_hertz, stiffness, 0.0), True, factor > 0, stiffness=stiffness, factor=factor)


@dataclass(frozen=True)
class HertzContact(ForceInterval):
    """A contact by Hertz, whose damping follows from the speed at which it is struck.

    Attributes:
        stiffness: K [N/m^1.5].
        factor: X of the module.
        speed: at which it was struck [m/s]; 0: not yet.
    """

    stiffness: float = 0.0
    factor: float = 0.0
    speed: float = field(default=0.0, compare=False)

    def struck(self, speed: float) -> HertzContact:
        """The contact struck at a speed [m/s]."""
        return replace(self, force=partial(_hertz, self.stiffness, self.factor / max(speed, 1e-300)), speed=speed)


def _linear(stiffness: float, damping: float, place: Any, rate: Any) -> Any:
    return -stiffness * place - damping * rate


def _hertz(stiffness: float, damping: float, place: Any, rate: Any) -> Any:
    depth = np.maximum(-np.asarray(place), 0.0)
    return stiffness * depth * np.sqrt(depth) * (1.0 - damping * rate)
