"""Loads on the links of a press whose geometry changes, and the derivatives of their forces.

A constant force does not feel the geometry. A process load is a force over the slide's height and speed, which do: its law is
differentiated by a complex step, exactly, as its stretches are smooth; that of a caller's own load must be found to agree with its
differences. No other load is known well enough.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array, ComplexArray
from ..common.errors import PinpressError, said, shown
from ..dynamics.applied_loads import apply, asked
from ..engines.forces import AppliedForce
from ..engines.friction import REST
from ..engines.planar.model import Plane, flat
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.caller_laws import OWN_LOADS, LawError
from ..loads.link import Load, PointForce
from ..loads.process import ProcessLoad, Stretch
from .motion import STEP

DIFFERENCE, ROUGHLY = 1e-5, 1e-3  # share of a range over which a law's slope is taken, and how near that must come
ANALYTIC = "write it with NumPy's functions that are smooth in complex numbers, without abs, max, real or float"


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
        applied = apply(asked([load]), press, motion)
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
    down = speed < -REST * press.size * np.abs(motion.crank_speed).max()  # as `forces` decides
    for downwards in (True, False):
        for stretch in load.stretches(downwards):
            inside = (down == downwards) & (stretch.lower < above) & (above <= stretch.upper)
            at = above[inside], speed[inside]
            try:
                law = np.asarray(stretch.force(at[0] + 1j * STEP * height[inside], at[1] + 1j * STEP * velocity[inside]), dtype=complex)
            except Exception as error:
                raise LawError(
                    f"{type(load).__name__}: force of complex numbers cannot be worked out: {said(error)}; {ANALYTIC}"
                ) from error
            if type(load) not in OWN_LOADS and inside.any():
                _refuse_not_analytic(type(load).__name__, stretch, *at)
            result[inside] = np.imag(law) / STEP * ((np.real(law) > 0) if stretch.one_sided else 1.0)
    return result


def _refuse_not_analytic(name: str, stretch: Stretch, height: Array, velocity: Array) -> None:
    """Raise LawError where a caller's force of complex numbers is not that of its derivative: `abs`, say, loses the imaginary part."""
    for of, a, b in (("height", 1.0, 0.0), ("velocity", 0.0, 1.0)):
        size = DIFFERENCE * (max(float(np.ptp(height)), DIFFERENCE) if a else max(float(np.abs(velocity).max(initial=0.0)), DIFFERENCE))
        exact = np.imag(stretch.force(height + 1j * STEP * a, velocity + 1j * STEP * b)) / STEP * np.ones_like(height)
        above, below = (np.asarray(stretch.force(height + way * a * size, velocity + way * b * size), dtype=float) for way in (1, -1))
        near = (above - below) / (2 * size)
        least = DIFFERENCE * float(np.abs(above).max(initial=0.0)) / (size / DIFFERENCE)
        wrong = np.abs(exact - near) > ROUGHLY * np.maximum(np.abs(exact), np.abs(near)) + least
        if 2 * wrong.sum() > wrong.size:  # at a kink one or other may differ
            raise LawError(f"{name}: force of complex numbers does not have its derivative by the {of}; {ANALYTIC}")
