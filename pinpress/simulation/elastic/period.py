"""One period of a press on springs, found directly.

The period is one system of equations: all panels, the first state and the times at which loads begin and end (`panels`). It starts from the
rigid motion with its own events. Where the crank turns freely, the time of the period's end is unknown too: it ends where the crank has
turned through a period. Where Newton's method fails from there, or the links swing through more events than the rigid press, some
strokes are followed step by step first (`march`). Panels are divided until the error of each is below the tolerance.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...common.numerics import radau_rule
from ...common.quantities import Array
from ..failures import failure
from .equations import ElasticEquations
from .march import cut_to, march
from .panels import Ends, Indices, Mesh, PanelSolution, newton_step, solve
from .press.drive import TrainEvent, TrainMode
from .strokes import CRANK_ANGLE, Event, MotionEvent, Plan, Release, crossing
from .task import FEWEST, FIRST_PANELS, LOOKS, MOST_STEPS, PAST_TURNING, SETTLED, STAGES, ElasticSolution, Task, even_mesh

MIDDLES = (np.arange(LOOKS) + 0.5) / LOOKS  # shares of a panel at which its forces are looked at
MOST_PARTS = 4096  # panels on which vibrations are followed through a period: on more it takes longer than the motion itself
STROKES = 6  # that are followed before a press counts as one that does not repeat its stroke


def periodic(task: Task, start: float) -> ElasticSolution:
    """The motion that repeats itself after a period, from a crank angle at which the rigid press turns.

    Raises:
        SimulationError: it is not found: the press may not repeat its stroke.
    """
    plan = task.strokes.plan(start)
    has_events = bool(task.strokes.borders or (task.equations.train is not None and task.equations.train.jumps))
    # A loose period comes first: it shows whether its events are as planned, and is a near guess if they are.
    guess, tolerance = _rigid_guess(task, plan), (300.0 if has_events else 1.0) * task.tolerance
    if task.equations.train is not None and task.equations.train.jumps:
        rigid = ElasticSolution(replace(task.equations, segments=plan.segments, events=plan.events), guess, task.gain, 0)
        plan = _observe(task, rigid, start) or plan
        guess = _guess_for(plan, guess)
    for attempt in range(6):  # each with the events that the motion before it had
        near = attempt > 0 or not plan.jumps  # else the times at which the torque jumps are still those of the rigid press
        solution = _refine(task._replace(tolerance=tolerance), start, plan, guess, near)
        observed = None if solution is None else _observe(task, solution, start)
        if solution is None or observed is None:
            break
        if not near or not _alike(observed, plan):
            plan, guess = observed, _guess_for(observed, solution.panels)
        elif tolerance == task.tolerance:
            return _with_passage(task, solution)
        else:
            tolerance = task.tolerance
            guess = solution.panels.onto(_divide(solution.panels.mesh, solution.panels.errors(), tolerance))
    y, v, _ = task.rigid(np.zeros(1))
    state, depths = np.concatenate([y[0], v[0]]), []
    for stroke in range(STROKES):
        followed = march(task, start, state, *_period_ends(task, start))
        state = followed.panels.states[-1] - task.gain
        depths.append(_deepest(followed))
        if stroke < 1:
            continue
        of, knots = followed.equations, followed.panels.mesh.knots * abs(task.speed)
        plan, guess = Plan(of.segments, of.events or {}, knots, of.modes), followed.panels
        if any(isinstance(event, Release) for event in plan.events.values()):  # within a period contacts are lost without an event
            observed = _observe(task, followed, start)
            if observed is None:
                continue
            plan, guess = observed, _guess_for(observed, guess)
        solution = _refine(task, start, plan, guess)
        observed = None if solution is None else _observe(task, solution, start)
        if solution is not None and observed is not None and _alike(observed, plan):
            return _with_passage(task, solution)
    shown = ", ".join(f"{1e3 * depth:.4f}" for depth in depths)
    raise failure("does not repeat", strokes=STROKES, depths=shown)


def periodic_near(task: Task, start: float, near: ElasticSolution) -> ElasticSolution | None:
    """The motion of `periodic` of a crank at a constant speed, by that at another speed.

    Where both differ little, one Newton step on its panels does. None if the motion is not found, or has other events.
    """
    of, before = near.equations, near.panels
    assert of.crank is not None
    slower = abs(of.crank.speed / task.speed)
    mesh, size = replace(before.mesh, knots=slower * before.mesh.knots), before.states.shape[1] // 2
    states = np.concatenate([before.states[:, :size], before.states[:, size:] / slower], axis=1)
    guess = replace(before, mesh=mesh, states=states, accelerations=before.accelerations / slower**2, change=np.inf, steps=0)
    plan = Plan(of.segments, of.events or {}, mesh.knots * abs(task.speed), of.modes)
    solution = _refine(task, start, plan, guess)
    observed = None if solution is None else _observe(task, solution, start)
    return None if solution is None or observed is None or not _alike(observed, plan) else _with_passage(task, solution)


def _rigid_guess(task: Task, plan: Plan) -> PanelSolution:
    """The rigid motion on the panels of a plan."""
    rule, share = radau_rule(STAGES), np.diff(plan.knots) / plan.knots[-1]
    counts = np.maximum(FEWEST, np.ceil(FIRST_PANELS * share).astype(int))
    mesh = even_mesh(task.times(plan.knots), counts)
    y, v, _ = task.rigid(mesh.borders)
    _, _, a = task.rigid((mesh.start[:, None] + mesh.length[:, None] * rule.points).ravel())
    accelerations = a.reshape(len(mesh.start), len(rule.points), -1)
    return PanelSolution(mesh, rule, np.concatenate([y, v], axis=1), accelerations, np.inf, 0, np.eye(2 * y.shape[1]))


def _period_ends(task: Task, start: float) -> tuple[float, float]:
    """Time after which a period ends at the latest, and crank angle at which it does; a free crank may take the time of four."""
    if task.equations.crank is not None:
        return task.period, np.inf
    return 4.0 * task.period, start + task.speed * task.period


def _refine(task: Task, start: float, plan: Plan, guess: PanelSolution, near: bool = True) -> ElasticSolution | None:
    """The period with the events of a plan, on as many panels as it takes; None if Newton's method fails. Where the plan is not near,
    the drive's torque jumps at the times that it says."""
    events: dict[int, MotionEvent] = dict(plan.events)
    if task.equations.crank is None:
        events[len(plan.segments)] = Event(CRANK_ANGLE, _period_ends(task, start)[1])
    equations = replace(task.equations, segments=plan.segments, modes=plan.modes, events=events)
    border = _border(task, equations, near)
    for _ in range(8):  # panels are divided so often at most
        panels = solve(equations, guess, border, SETTLED * task.tolerance, MOST_STEPS, task.tolerance)
        if panels is None:
            return None
        errors = panels.errors()
        if errors.max() <= task.tolerance:
            return ElasticSolution(equations, panels, task.gain, panels.steps * errors.size * STAGES)
        guess = panels.onto(_divide(panels.mesh, errors, task.tolerance))
    return None


def _border(task: Task, equations: ElasticEquations, near: bool = True) -> Ends:
    """How the period begins and ends, with the events whose times are unknown."""
    events = equations.events or {}
    free = [knot for knot, event in events.items() if not _known(event) or equations.crank is None]
    free = [knot for knot in free if near or not isinstance(events[knot], TrainEvent)]
    return Ends(True, task.gain, free, equations.integrals)


def _with_passage(task: Task, solution: ElasticSolution) -> ElasticSolution:
    """The solution with a passage in which the lowest vibration is resolved: panels of a smooth motion may be longer than it is."""
    equations, panels = solution.equations, solution.panels
    mesh = panels.mesh
    angle = 3.0  # of the lowest vibration on a panel, up to which collocation has its decay exactly [rad]
    parts = np.maximum(1, np.ceil(mesh.length * equations.sprung.lowest_frequency / angle)).astype(int)
    if parts.max() == 1:
        return solution
    if equations.crank is not None and parts.sum() > MOST_PARTS:
        return replace(solution, panels=replace(panels, passage=_slow_decay(equations, panels) * np.eye(2 * equations.size)))
    border = _border(task, equations)
    return replace(solution, panels=replace(panels, passage=newton_step(equations, panels.onto(_split(mesh, parts)), border, 1).passage))


def _slow_decay(equations: ElasticEquations, panels: PanelSolution) -> float:
    """Factor by which a vibration shrinks at least in a period that takes very many of it: the pose changes so slowly that at each crank
    angle it decays as it would there."""
    size, seen = equations.size, panels.sample(MIDDLES)
    _, stiffness, damping, mass, _ = equations.linearised(seen.time, seen.y, seen.v, seen.a, seen.segment)
    matrix = np.zeros((len(seen.y), 2 * size, 2 * size))
    matrix[:, :size, size:] = np.eye(size)
    matrix[:, size:, :size], matrix[:, size:, size:] = -np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)
    values = np.linalg.eigvals(matrix)
    decays = np.abs(values.real) > 1e-10 * np.abs(values)  # less is rounding of a vibration without dampers
    slowest = np.where(decays, values.real, 0.0).max(axis=1)
    return float(np.exp(slowest @ panels.mesh.length[seen.panel] / LOOKS))


def _known(event: MotionEvent) -> bool:
    """Whether the time of an event is known where the crank's speed is given."""
    return isinstance(event, Event) and event.path == CRANK_ANGLE


def _divide(mesh: Mesh, errors: Array, tolerance: float) -> Mesh:
    """Panels so short that the errors (p,) of these panels become smaller than the tolerance."""
    return _split(mesh, np.maximum(1, np.ceil((errors / tolerance) ** (1 / (STAGES + 1)))).astype(int))


def _split(mesh: Mesh, parts: Indices) -> Mesh:
    """Each panel divided into a number of equal parts, (p,)."""
    ends = [np.linspace(low, high, part + 1) for low, high, part in zip(mesh.low, mesh.high, parts, strict=True)]
    low, high = (np.concatenate([places[piece] for places in ends]) for piece in (slice(None, -1), slice(1, None)))
    return Mesh(mesh.knots, np.repeat(mesh.segment, parts), low, high)


def _observe(task: Task, solution: ElasticSolution, start: float) -> Plan | None:
    """The segments, with the times of their knots, in which forces act by the places that the paths of a motion really reach, and by the
    speeds of the drive's shaft; None if no border explains a change."""
    equations, mesh, strokes = solution.equations, solution.panels.mesh, task.strokes
    seen, ahead = solution.panels.sample(MIDDLES), strokes.turnings_ahead(start)
    places, _ = equations.places(seen.time, seen.y, seen.v)
    angles = equations.whole(seen.time, seen.y, seen.v)[0][:, -1]
    beyond = _beyond_jumps(equations, seen.v)
    passed, direction = np.searchsorted(ahead, np.abs(angles - start)), float(np.sign(task.speed))
    changed = strokes.crossed(places)
    changed[1:] |= (passed[1:] != passed[:-1]) | ((beyond[1:] > 0) != (beyond[:-1] > 0)).any(axis=1)
    rows = [0, *(int(k) for k in np.flatnonzero(changed))]
    turnings = {i: start + direction * ahead[passed[k] - 1] for i, k in enumerate(rows) if k and passed[k] != passed[k - 1]}
    past = {i: angle + direction * PAST_TURNING for i, angle in turnings.items()}
    acting = strokes.along(start + PAST_TURNING * direction, places[rows], past)
    driving = [_mode(task, beyond[k]) for k in rows]
    segments, modes, knots, events = [acting[0]], [driving[0]], [float(mesh.knots[0])], dict[int, MotionEvent]()
    for i in range(1, len(rows)):
        k, share = rows[i], None
        event: MotionEvent | None = None
        if driving[i] != modes[-1]:
            jump = int(np.argmax((beyond[k] > 0) != (beyond[k - 1] > 0)))
            event, share = TrainEvent("jumps", number=jump), crossing(beyond[k - 1, jump], beyond[k, jump])
        elif acting[i] == segments[-1]:
            continue
        elif i in turnings:
            event, share = Event(CRANK_ANGLE, turnings[i]), crossing(angles[k - 1] - turnings[i], angles[k] - turnings[i])
        else:
            for border in strokes.borders:
                share = crossing(places[k - 1, border.path] - border.value, places[k, border.path] - border.value)
                if share is not None:
                    event = border
                    break
        if event is None or share is None:
            return None
        events[len(knots)] = event
        knots.append(float(seen.time[k - 1] + share * (seen.time[k] - seen.time[k - 1])))
        segments.append(acting[i])
        modes.append(driving[i])
    return Plan(tuple(segments), events, np.array([*knots, mesh.knots[-1]]), tuple(mode for mode in modes if mode is not None))


def _beyond_jumps(equations: ElasticEquations, v: Array) -> Array:
    """(n, jumps) by how much the drive's shaft is faster than the speeds at which its torque jumps [rad/s], of rates (n, size)."""
    train = equations.train
    if train is None or not train.jumps:
        return np.zeros((len(v), 0))
    return np.asarray(train.shaft_speed(v)[:, None] - train.jumps)


def _mode(task: Task, beyond: Array) -> TrainMode | None:
    """Mode of a drive train beyond (jumps,) the speeds at which its torque jumps; None if the crank is held."""
    train = task.equations.train
    return None if train is None else train.engaged._replace(faster=tuple(bool(faster > 0) for faster in beyond))


def _alike(first: Plan, second: Plan) -> bool:
    """Whether the same forces act, from the same events on."""
    paths = [[event.path for _, event in sorted(plan.events.items()) if isinstance(event, Event)] for plan in (first, second)]
    sides = [[mode.faster for mode in plan.modes] for plan in (first, second)]
    return first.segments == second.segments and paths[0] == paths[1] and sides[0] == sides[1]


def _guess_for(plan: Plan, near: PanelSolution) -> PanelSolution:
    """A motion on the panels of a plan whose knots are times, as a guess."""
    counts = np.maximum(FEWEST, np.diff(np.searchsorted(near.mesh.borders, plan.knots)))
    return cut_to(near, even_mesh(plan.knots, counts))


def _deepest(solution: ElasticSolution) -> float:
    """Lowest place of the first path, the slide's [m]."""
    seen = solution.panels.sample(np.arange(LOOKS) / LOOKS)
    return float(solution.equations.places(seen.time, seen.y, seen.v)[0][:, 0].min())
