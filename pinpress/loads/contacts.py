"""Contacts as ADAMS writes them: its functions IMPACT and BISTOP, a spring of a power of the depth with a damper that grows with it.

ADAMS' functions of x and its rate, with x the slide's height (ADAMS' documentation; the forces between the parts of Zhang 2007, 5.1.3, are
such functions):

    IMPACT(x, x', x1, k, e, cmax, d) = max(0, k (x1 - x)^e - STEP(x, x1 - d, cmax, x1, 0) x')  where x < x1, else 0
    BISTOP(x, x', x1, x2, k, e, cmax, d) = IMPACT below x1, and above x2  min(0, -k (x - x2)^e - STEP(x, x2, 0, x2 + d, cmax) x')

The damper begins at zero, so that the force does not jump where the slide meets the stop with speed; the force of `ElasticDie` does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..common.arguments import number, positive
from ..common.errors import PinpressError
from ..common.parameters import Checked, parameter
from ..common.quantities import Values
from .process import ForceInterval


@dataclass(frozen=True, eq=False)
class Impact(Checked):
    """A stop or die below the slide by ADAMS' function IMPACT: it pushes upwards, never pulls.

    Attributes:
        height: x1, at which the slide touches the stop [m].
        stiffness: k, force at a depth of 1 m [N/m^e], or (S,) for S scenarios.
        exponent: e, from 1 (a spring) [-]; 1.5 for balls (Hertz), 2.2 is often given for steel.
        damping: cmax, of the damper at the depth d and below [N s/m], or (S,).
        depth: d, over which the damper grows from zero [m]; it must be given with a damper.
        datum: slide position from which heights count [m]; None: that of bottom dead centre.

    Raises:
        PinpressError: a number is not as declared, the exponent is below 1, or a damper has no depth.
    """

    height: float = field(metadata=parameter("m"))
    stiffness: Values = field(metadata=parameter("N/m^e", "positive", scenarios=True))
    exponent: float = field(default=1.5, metadata=parameter("-"))
    damping: Values = field(default=0.0, metadata=parameter("N s/m", "not negative", scenarios=True))
    depth: float | None = field(default=None, metadata=parameter("m", "positive"))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_contact(self)

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return self._both_ways

    @cached_property
    def _both_ways(self) -> tuple[ForceInterval, ...]:
        return _stop(self, self.height, 1)


@dataclass(frozen=True, eq=False)
class TwoSidedStop(Checked):
    """Two stops between which the slide moves free by ADAMS' function BISTOP: the lower one pushes upwards, the upper one downwards.

    Attributes:
        lower: x1, height at which the slide touches the lower stop [m].
        upper: x2, height at which it touches the upper stop, above ``lower`` [m].
        stiffness: k, force at a depth of 1 m [N/m^e], or (S,) for S scenarios.
        exponent: e, from 1 (a spring) [-].
        damping: cmax, of the damper at the depth d and beyond [N s/m], or (S,).
        depth: d, over which the damper grows from zero [m]; it must be given with a damper.
        datum: slide position from which heights count [m]; None: that of bottom dead centre.

    Raises:
        PinpressError: as `Impact`; also where ``upper`` is not above ``lower``.
    """

    lower: float = field(metadata=parameter("m"))
    upper: float = field(metadata=parameter("m"))
    stiffness: Values = field(metadata=parameter("N/m^e", "positive", scenarios=True))
    exponent: float = field(default=1.5, metadata=parameter("-"))
    damping: Values = field(default=0.0, metadata=parameter("N s/m", "not negative", scenarios=True))
    depth: float | None = field(default=None, metadata=parameter("m", "positive"))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_contact(self)
        if not self.upper > self.lower:
            raise PinpressError(f"TwoSidedStop: upper is {self.upper:g}, not above lower, {self.lower:g}; give heights of the slide [m]")

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return self._both_ways

    @cached_property
    def _both_ways(self) -> tuple[ForceInterval, ...]:
        return (*_stop(self, self.lower, 1), *_stop(self, self.upper, -1))


def pick_up_force(mass: float, speed: float, stiffness: float, *, preload: float = 0.0) -> float:
    """Largest force with which a slide picks up a mass that rests against a stop, such as pistons and pad of a die cushion [N].

    The slide comes with its speed onto the mass, over a spring, and keeps its speed. The mass leaves its stop once the spring presses with
    the preload F0; from there on m x" = k (v t - x) - F0, so that the spring's force is F0 + v sqrt(k m) sin(t sqrt(k/m)), with the largest
    value F0 + v sqrt(k m). Where F0 is smaller than v sqrt(k m) the mass then flies ahead. A heavy slide behind a crank with a flywheel
    slows down little; where it does, the force is smaller.

    Args:
        mass: m, picked up [kg].
        speed: v, of the slide where it meets the mass; its size counts [m/s].
        stiffness: k, of what lies between: pins, pad and blank holder [N/m].
        preload: F0, with which the mass is pressed against its stop [N].

    Raises:
        PinpressError: mass or stiffness are not positive, the preload is negative, or a value is not finite.
    """
    m, k = positive("mass", mass, "kg"), positive("stiffness", stiffness, "N/m")
    v, pressed = number("speed", speed, "m/s"), number("preload", preload, "N")
    if pressed < 0:
        raise PinpressError(f"preload is {pressed:g} N: give a force that is not negative, 0 for a mass that lies free")
    return pressed + abs(v) * math.sqrt(k * m)


def _check_contact(load: Impact | TwoSidedStop) -> None:
    name = type(load).__name__
    if not 1.0 <= load.exponent <= 10.0:
        raise PinpressError(
            f"{name}: exponent is {load.exponent:g}; give 1 (a spring) to 10: below 1 the stiffness is infinite where the"
            " slide touches the stop"
        )
    if np.any(load.damping) and load.depth is None:
        raise PinpressError(f"{name}: depth is missing; give the depth [m] over which the damper grows from zero, or use ElasticDie")


def _stop(load: Impact | TwoSidedStop, touching: float, sense: int) -> tuple[ForceInterval, ...]:
    """The intervals of a stop below the slide (``sense`` 1) or above it (-1): where the damper grows, and beyond that."""
    spring, beyond = partial(_power, load.stiffness, load.exponent), -sense * math.inf

    def interval(begin: float, end: float, law: Any, heeds_velocity: bool = True) -> ForceInterval:
        return ForceInterval(max(begin, end), min(begin, end), law, one_sided=True, heeds_velocity=heeds_velocity, sense=sense)

    if not np.any(load.damping) or load.depth is None:
        return (interval(touching, beyond, partial(_push, touching, sense, spring), heeds_velocity=False),)
    full = touching - sense * load.depth
    growing, grown = (partial(_spring_and_damper, touching, sense, spring, load.damping, growth) for growth in (load.depth, None))
    return interval(touching, full, growing), interval(full, beyond, grown)


# Module functions that `partial` binds, not closures: loads can then be sent to other processes.


def _power(stiffness: Any, exponent: float, depth: Any) -> Any:
    """Force of the spring; odd in the depth, so that it is a number a little outside the stop too."""
    if exponent == 1.0:
        return stiffness * depth
    if isinstance(depth, float):
        return stiffness * math.copysign(abs(depth) ** exponent, depth)
    inside = np.real(depth) >= 0
    return stiffness * np.where(inside, 1.0, -1.0) * np.where(inside, depth, -depth) ** exponent


def _push(touching: float, sense: int, spring: Any, height: Any, velocity: Any) -> Any:
    return sense * spring(sense * (touching - height)) + 0.0 * velocity


def _spring_and_damper(touching: float, sense: int, spring: Any, damping: Any, growth: float | None, height: Any, velocity: Any) -> Any:
    """Force of spring and damper; ``growth``: depth over which the damper grows by the cubic of STEP, None if it is full."""
    depth = sense * (touching - height)
    if growth is not None:
        share = depth / growth
        damping = damping * (share * share * (3.0 - 2.0 * share))
    return sense * spring(depth) - damping * velocity
