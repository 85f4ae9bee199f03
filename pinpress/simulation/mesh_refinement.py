"""Whether panels resolve a solution over the crank angle, and where to cut those that do not.

A polynomial's last terms tell what it misses. Where the crank passes a corner of the drive's torque, or a contact is lost, a panel is cut
just there; any other that is too coarse in its middle.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from .collocation import FLOOR, Flow
from .mesh import FROM_REST, SAME, STEADY, TO_REST, Grid, Indices, Push, travelled
from .reduced_model import horner, root, rule

BEYOND = 10.0  # times the largest energy that is known, that it is taken to be on panels where it is not
NARROWEST = 1e-9  # panel [rad]
ROUNDED = 5e-14  # last terms, beside the whole, that may be rounding: no cut makes them less
LAYER = 10.0  # e-folds of half a panel that holds what dies away at its start under a stiff drive
LEAST = 1e-3  # kinetic energy, beside the period's largest, below which a drive that depends on speed may be about to stop the crank


def carried(flow: Flow, grid: Grid) -> Array | None:
    """The kinetic energy (q, p, S) of a flow at the nodes of another grid over the same angles; None where one of them starts from rest."""
    old = flow.grid
    if old.kinds.any() or grid.kinds.any():
        return None
    along = (grid.angle - grid.start) * grid.direction
    panel = np.clip(old.borders.searchsorted(along, side="right") - 1, 0, len(old.kinds) - 1)
    low, high = old.borders[panel], old.borders[panel + 1]
    x = (2 * (along - low) / (high - low) - 1)[:, :, None]
    q, p, count = flow.energy.shape
    coefficients = rule().polynomial(flow.energy.reshape(q, -1)).reshape(q, p, count)
    value = coefficients[-1][panel]
    for k in range(q - 2, -1, -1):
        value = value * x + coefficients[k][panel]
    # on panels that Newton's method has not settled the energy is of no meaning, and may be anything: it must not set what counts as little
    known = np.arange(len(old.kinds))[:, None] < flow.settled
    highest = np.maximum(np.where(known, flow.energy.max(axis=0), 0.0).max(axis=0), flow.ends[0])
    return np.asarray(np.clip(value, FLOOR * flow.ends[0], BEYOND * highest))


def stopping(flow: Flow) -> NDArray[np.bool_]:
    """Panels (p, S) on which the crank stops, or comes so near to it that time may not be resolved; what follows them is of no meaning."""
    lowest = np.minimum(flow.energy.min(axis=0), flow.ends[1:])
    known = np.arange(len(flow.ends))[:, None] <= flow.settled
    least = 0.0 if flow.held else LEAST * np.where(known, flow.ends, 0.0).max(axis=0)
    found = (lowest <= least) | (np.arange(len(lowest))[:, None] >= flow.settled)
    if flow.grid.kinds[-1] == TO_REST:
        found[-1] = (flow.energy[:, -1] <= 0).any(axis=0)
    return np.asarray(found)


def unresolved(flow: Flow, upto: int, tolerance: float, corners: Sequence[float] = (), which: Indices | slice = slice(None)) -> Array:
    """Where to cut those of the panels before ``upto`` that do not resolve energy or time, as angles travelled.

    A polynomial's last terms tell what it misses; Gauss's rule makes far smaller errors than that. A panel on which the crank passes one of
    the ``corners``, speeds at which a drive's torque is not smooth, is cut there (of one scenario); any other in its middle. ``which`` of
    the scenarios count.
    """
    r, g = rule(), flow.grid
    force, speed, ends = flow.force[:, :upto, which], flow.speed[:, :upto, which], flow.ends[: upto + 1, which]
    q, _, count = force.shape
    last, measure, tolerance = r.legendre[-2:], g.measure[:, :upto, None], max(tolerance, ROUNDED)

    def coarse(integrand: Array, whole: Array) -> NDArray[np.bool_]:
        tail = np.abs(last @ (integrand * measure).reshape(q, -1)).max(axis=0).reshape(upto, count)
        return np.asarray((tail > tolerance * whole).any(axis=1), dtype=np.bool_)

    slowness = 1 / speed
    taken = (r.weights @ (slowness * measure).reshape(q, -1)).reshape(upto, count).sum(axis=0)
    bad = coarse(force, ends.max(axis=0)) | coarse(slowness, taken)
    bad &= np.diff(g.borders[: upto + 1]) > NARROWEST
    if flow.stiffness.any():  # what is not resolved there rings on through the panels that follow
        bad[1:] &= (flow.stiffness[1:upto] <= LAYER) | ~bad[:-1]
    cuts = {panel: _within(flow, panel) for panel in np.flatnonzero(bad).tolist()}
    if count == 1:
        cuts |= _corners_passed(flow, upto, corners)
        for push in g.pushes:
            cuts |= {panel: at for panel, at in _contact_lost(flow, push) if panel < upto}
    return np.array(list(cuts.values()))


def _within(flow: Flow, panel: int) -> float:
    """Where a panel is cut: in its middle, as it runs; under a stiff drive behind the layer at its start, where that is not cut off yet."""
    g, stiffness = flow.grid, flow.stiffness
    low, high = g.borders[panel : panel + 2]
    share = {STEADY: 0.5, FROM_REST: 0.25, TO_REST: 0.75}[int(g.kinds[panel])]
    if stiffness[panel] > 2 * LAYER and (panel == 0 or stiffness[panel - 1] > 2 * LAYER):
        share = LAYER / float(stiffness[panel])
    return float(low + share * (high - low))


def _turning(flow: Flow) -> Array:
    """Speed of the crank (p + 1,) at the borders, of one scenario."""
    g = flow.grid
    inertia = np.maximum(g.inertia_ends + flow.added, np.finfo(float).tiny)
    return np.asarray(g.direction * np.sqrt(2 * np.maximum(flow.ends[:, 0], 0.0) / inertia))


def _corners_passed(flow: Flow, upto: int, corners: Sequence[float]) -> dict[int, float]:
    """Panels on which the crank passes one of these speeds, and where: also where no node sees it."""
    g, found = flow.grid, {}
    if corners:
        ends = _turning(flow)
        speeds = np.concatenate([ends[None, :-1], g.direction * flow.speed[:, :, 0], ends[None, 1:]])[:, :upto]
        for corner in corners:
            for panel in np.flatnonzero((speeds.min(axis=0) < corner) & (speeds.max(axis=0) > corner)).tolist():
                at = _place_of(flow, panel, rule().polynomial(speeds[1:-1, panel]).tolist(), corner)
                if at is not None:
                    found[panel] = at
    return found


def _place_of(flow: Flow, panel: int, polynomial: list[float], level: float) -> float | None:
    """Where on a panel a polynomial in its x passes a level, as angle travelled; None where that is no place away from its borders."""
    g = flow.grid
    polynomial = [polynomial[0] - level, *polynomial[1:]]
    samples = np.linspace(-1.0, 1.0, 2 * len(polynomial)).tolist()
    values = [horner(polynomial[::-1], x) for x in samples]
    for k in range(len(samples) - 1):
        if (values[k] > 0) != (values[k + 1] > 0):
            x = root(polynomial, samples[k], samples[k + 1])
            at = float(travelled(g, np.array([panel]), np.array([x]))[0][0])
            if g.borders[panel] + SAME < at < g.borders[panel + 1] - SAME:
                return at
    return None


def _contact_lost(flow: Flow, push: Push) -> list[tuple[int, float]]:
    """Panels on which a contact's law changes its sign, and where, as angles travelled; of one scenario."""
    g, found, turned = flow.grid, [], _turning(flow)
    for panel in push.panels.tolist() if push.stretch.one_sided else []:
        ends = slice(panel, panel + 2)
        rates = [g.lever[push.row][:, panel] * g.direction * flow.speed[:, panel, 0], g.lever_ends[push.row, ends] * turned[ends]]
        position = np.concatenate([g.position[push.row][:, panel], g.position_ends[push.row, ends]])
        law = np.asarray(push.stretch.force(position - push.datum, np.concatenate(rates)))
        if law.min() < 0 < law.max():
            at = _place_of(flow, panel, rule().polynomial(law[:-2]).tolist(), 0.0)
            if at is not None:
                found.append((panel, at))
    return found
