"""The state in which a press on springs starts without vibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.quantities import Array
from ...loads.process import ForceInterval
from ..driven_press import GeneralizedForce
from ..failures import failure
from .equations import ElasticEquations
from .press.geometry import Springs
from .press.sprung_press import SprungPress
from .strokes import Segment
from .task import MOST_STEPS, PAST_TURNING, Task


def resting(task: Task, start: float) -> Array:
    """The state (2 size,) at time 0 whose springs carry weight, loads and the inertia forces of the rigid motion, so that no vibration
    begins. Journals with clearance rest on their bearings on the side to which these forces press them; preloaded joints are open where
    these forces open them.

    A free crank is accelerated by what its drive then leaves.

    Raises:
        SimulationError: the springs do not carry them.
    """
    y, v, a = task.rigid(np.zeros(1))
    phase = task.strokes.begin(start + PAST_TURNING * np.sign(task.speed))
    segment = task.strokes.active(phase, task.strokes.places(start))
    equations, sprung = replace(task.equations, segments=(segment,)), task.equations.sprung
    by_crank = v[0] / v[0, -1]  # rates of a free crank's coordinates by its own
    v, a = task.begins * v, task.begins**2 * a
    if equations.train is not None:
        start_of_bodies, train = equations.body_start, equations.train
        mode, rates = train.begun(start, float(v[0, -1]))
        by_crank[:start_of_bodies], v[0, :start_of_bodies] = 0.0, rates
        equations = replace(equations, modes=(train.due(mode, 0.0, v[0]),))
    if sprung.closed is None:
        return np.concatenate([_balance(equations, y, v, a, by_crank, task.tolerance)[0], v[0]])
    loads, contacts = segment[: len(task.strokes.driven.forces)], task.strokes.contacts
    closed = replace(equations, sprung=sprung.closed, segments=((*loads, *(None for _ in contacts)),))
    y = _balance(closed, y, v, a, by_crank, task.tolerance)
    if sprung.open_pins:
        aside = replace(sprung.closed, springs=_press_aside(sprung, closed, y, v))
        y = _balance(replace(closed, sprung=aside), y, v, a, by_crank, task.tolerance)
    touching: Segment = tuple(contact.rising[0] for contact in contacts)
    for _ in range(MOST_STEPS):
        y = _balance(replace(equations, segments=((*loads, *touching),)), y, v, a, by_crank, task.tolerance)
        before, touching = touching, _members_touching(equations, contacts, y, v)
        if touching == before:
            return np.concatenate([y[0], v[0]])
    raise failure("cannot go on", 0.0, message="preloaded joints neither stay closed nor open at the start")


def _members_touching(equations: ElasticEquations, contacts: Sequence[GeneralizedForce], y: Array, v: Array) -> Segment:
    """The laws of all contacts of pins, and of the members of preloaded joints that touch at a state (1, size); None of the others."""
    sprung, pins, state = equations.sprung, len(equations.sprung.open_pins), equations.state(np.zeros(1), y, v)
    laws: list[ForceInterval | None] = [contact.rising[0] for contact in contacts]
    for number, contact in enumerate(contacts[pins:], pins):
        place, law = float(equations.paths[contact.row].over(sprung, state).value[0]), contact.rising[0]
        laws[number] = law if law.lower < place <= law.upper else None
    return tuple(laws)


def _balance(equations: ElasticEquations, y: Array, v: Array, a: Array, by_crank: Array, tolerance: float) -> Array:
    """Coordinates (1, size) near ``y`` at which all forces balance the inertia forces of given accelerations (1, size); those of the drive
    train, which has no springs, and of a frame on its mounts, which stands at its place, are found with them."""
    still = [*range(equations.body_start), *equations.unsprung]
    for _ in range(MOST_STEPS):
        linear = equations.linearised(np.zeros(1), y, v, a, np.zeros(1, dtype=int))
        matrix = linear.stiffness[0]
        matrix[:, still] = equations.mass[:, still]
        if equations.crank is None:
            matrix[:, -1] = (linear.mass if linear.mass.ndim == 2 else linear.mass[0]) @ by_crank
        step = np.linalg.solve(matrix, linear.left[0])
        if equations.crank is None:
            a, step[-1] = a + step[-1] * by_crank, 0.0
        a[0, still] += step[still]
        step[still] = 0.0
        y = y + step
        if np.abs(step).max() <= tolerance:
            return y
    raise failure("cannot go on", 0.0, message="the springs do not carry the links at the start")


def _press_aside(sprung: SprungPress, closed: ElasticEquations, y: Array, v: Array) -> Springs:
    """The springs of the closed press, slack where the forces press journals with clearance aside in their bearings."""
    geometry, springs = closed.sprung.geometry, closed.sprung.springs
    extension, rest = geometry.strains(closed.state(np.zeros(1), y, v)).extension[0], springs.rest.copy()
    for pin in sprung.open_pins:
        of_pin = springs.bearing == pin.bearing
        rest[of_pin] = extension[of_pin] * (pin.clearance.radial / max(float(np.linalg.norm(extension[of_pin])), 1e-300))
    return springs._replace(rest=rest)
