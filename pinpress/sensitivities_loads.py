"""Loads on the links of a press whose geometry changes, and the derivatives of their forces.

A constant force does not feel the geometry. A process load is a force over the slide's height and speed, which do: its law is
differentiated by a complex step, exactly, as its stretches are smooth. No other load is known well enough.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .coordinates import Array, ComplexArray
from .errors import PinpressError, shown
from .forces import AppliedForce, Load, PointForce, apply
from .friction import REST
from .linkage import Linkage
from .loads import ProcessLoad
from .motion import Motion
from .plane import Plane, flat
from .sensitivities import STEP


class Push(NamedTuple):
    """A load on a moving link.

    Attributes:
        body: its joint in v. arm: from that joint to the point, in the drawn pose. force, turned: (n,) the force and its derivative; all
            complex in the plane's axes. braced: the frame takes the opposite force in the same line, so that none of it leaves the machine.
    """

    body: int
    arm: complex
    force: ComplexArray
    turned: ComplexArray
    braced: bool


def refuse_unknown(loads: Sequence[Load]) -> None:
    """Raise PinpressError for a load whose force has no exact derivative here."""
    if not isinstance(loads, list | tuple):
        raise PinpressError(f"loads is a {type(loads).__name__}: give a list, loads=[...]")
    for load in loads:
        if isinstance(load, PointForce) and not callable(load.force):
            continue
        if isinstance(load, ProcessLoad) and not isinstance(load, type):
            if load.datum is None and (load.stretches(True) or load.stretches(False)):
                raise PinpressError(
                    f"{type(load).__name__}: the bottom dead centre moves with the geometry: give datum=, a slide position [m]"
                )
            continue
        raise PinpressError(
            f"load {shown(load)}: exact derivatives are known of constant PointForces and of process loads with a datum: give these"
        )


def pushes(plane: Plane, press: Linkage, motion: Motion, loads: Sequence[Load], height: Array, velocity: Array) -> list[Push]:
    """The loads on moving links, where the slide's height and speed have these derivatives (n,)."""
    result = []
    for load in loads:
        applied = apply([load], press, motion)
        braced = not isinstance(load, PointForce)
        for each in applied:
            if each.joint:
                turned = _turned(load, press, motion, height, velocity) if isinstance(load, ProcessLoad) else 0.0
                result.append(_push(plane, each, turned, braced))
    return result


def _push(plane: Plane, load: AppliedForce, turned: Array | float, braced: bool) -> Push:
    body = load.joint - 1
    arm = complex(*(plane.frames[body] @ load.point)[:2])
    guide = plane.directions[plane.prismatic.index(body), 0] if braced else 0.0
    force = flat(plane, load.force)
    return Push(body, arm, force, turned * guide * np.ones_like(force), braced)


def _turned(load: ProcessLoad, press: Linkage, motion: Motion, height: Array, velocity: Array) -> Array:
    """Derivative (n,) of a process load's force along the guide."""
    above, speed, result = motion.slide_position - (load.datum or 0.0), motion.slide_velocity, np.zeros_like(height)
    down = speed < -REST * press.spatial.size * np.abs(motion.crank_speed).max()  # as `forces` decides
    for downwards in (True, False):
        for stretch in load.stretches(downwards):
            inside = (down == downwards) & (stretch.lower < above) & (above <= stretch.upper)
            law = stretch.force(above[inside] + 1j * STEP * height[inside], speed[inside] + 1j * STEP * velocity[inside])
            result[inside] = np.imag(law) / STEP * ((np.real(law) > 0) if stretch.one_sided else 1.0)
    return result
