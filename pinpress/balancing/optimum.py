"""Balancing: the counterweights that make shaking forces, torques or bearing forces as small as can be, with the proof that they do.

At a given motion all forces are linear in the mass, mass moment and moment of inertia of every link, and range, rms and peak are convex.
So the best counterweights are the optimum of a convex program: it is found from nowhere, and its dual proves it. (Zhang 2007, 5.5,
searches step by step.)
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pinocchio as pin

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.checks import is_number
from ..common.conic_program import CONE, InfeasibleError
from ..common.errors import PinpressError, shown
from ..dynamics.harmonics import is_cycle
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import Motion, as_prescribed
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .counterweights import Counterweight, refuse_unphysical, sum_of
from .infeasible_limits import contradiction
from .mass_response import Case
from .objectives import AddedMass, Measure, Target
from .problem import ROUNDING, Problem, build
from .program import LARGEST, Design, solve, value_of
from .regions import Layout, Room
from .result import Active, Balance, Outcome

NOTHING = 1e-5  # of the press's moving mass: a counterweight that is lighter,
TRACE = 1e-9  # and without which measures are worse by less than this of what they were before, is none
BALANCED = "_balanced"  # a balanced press's name ends so
PRICELESS = 1e-7  # of the objective before, for as much again of what is limited: a constraint of that price does not hold it back
SPECK = 1e-11  # of a counterweight's mass times the square of its distance: a moment of inertia that is rounding
GROWN = 0.999  # of the most that the program allows: a mass that grows without end
CONFIRMED = 1e-8  # of the forces before balancing: how well inverse dynamics of the balanced press meets what the program promises


@typed
def balance(
    press: Linkage,
    motion: Motion | Sequence[Case],
    rooms: Sequence[Room],
    minimise: Target | Mapping[Target, float],
    limits: Mapping[Target, float] | None = None,
    loads: Sequence[Load] = (),
) -> Balance:
    """The press with the best counterweights.

    Of those that are equally good it is the lightest: to save the press's whole moving mass is worth 1e-6 of the objective before. Range
    and peak are over the motion's states: between these they are larger, by about (pi / states)^2 / 2 of the harmonic that they consist
    of.

    Args:
        motion: or several operating conditions (`Case`), in all of which the limits hold and of which, for every measure, the worst counts.
        rooms: where counterweights may be.
        minimise: a measure (`Range`, `Rms`, `Peak`) or `AddedMass`; or several with weights, each counting relative to what it is before
            balancing (added mass: to the moving mass). The objective of Zhang 2007, (5-14), is
            ``{Rms("shaking_force", "z"): w1, Range("shaking_force", "z"): w2, Rms("shaking_moment", "y"): w3, ...}``.
        limits: the most of measures and of added mass, in their units. 0 is taken literally.
        loads: on the motion, as `inverse_dynamics` takes them; those of cases are in them.

    Raises:
        UnknownNameError: a link or bearing that the press does not have.
        PinpressError: limits that the rooms cannot meet, named, and by how much; a counterweight that would grow without end; a measure
            that is zero before; a room that makes no sense.
    """
    cases = _cases(motion, loads)
    limits = limits or {}
    objective = checked(minimise, limits)
    problem, before = build(press, cases, rooms, [*objective, *limits])
    return balanced(press, cases, problem, before, objective, limits, absolute=len(cases) == 1 and not isinstance(minimise, Mapping))


def balanced(
    press: Linkage,
    cases: Sequence[Case],
    problem: Problem,
    before: tuple[Reactions, ...],
    objective: Mapping[Target, float],
    limits: Mapping[Target, float],
    absolute: bool,
) -> Balance:
    """The best design of a problem, with the press that it makes and what inverse dynamics says of it. Arguments as of `balance`.

    Args:
        absolute: the value of the one measure of the objective is wanted in its unit.
    """
    _refuse_nothing(press, problem, before, objective)
    try:
        design = solve(problem, objective, limits)
    except InfeasibleError:
        raise PinpressError(contradiction(problem, limits)) from None
    u = _without_traces(problem, objective, limits, design.variables)
    bodies = _filled(problem, u)
    result = _fitted(press, problem, bodies)
    _refuse_later_period(cases, result)
    after = tuple(
        inverse_dynamics(result, as_prescribed(case.motion, result), case.loads, bearings=tuple(reactions.bearing_force))
        for case, reactions in zip(cases, before, strict=True)
    )
    _refuse_unconfirmed(problem, u, after)
    scale = _scale(problem, objective) if absolute else 1.0
    measures = [target for target in [*objective, *limits, *(s.measure for s in problem.signals)] if isinstance(target, Measure)]
    weights = [_counterweight(press, room, filling) for room, filling in zip(problem.layouts, bodies, strict=True) if filling.mass]
    empty = [room.room for room, filling in zip(problem.layouts, bodies, strict=True) if not filling.mass]
    return Balance(
        original=press,
        press=result,
        cases=tuple(cases),
        objective=dict(objective),
        limits=dict(limits),
        counterweights=tuple(weights),
        added_mass=problem.added(u),
        value=scale * value_of(problem, objective, u),
        unit=next(iter(objective)).unit if absolute else "",
        bound=scale * design.bound,
        residual=design.residual,
        outcomes=tuple(
            Outcome(measure, number, measure.value(then), measure.value(now))
            for measure in dict.fromkeys(measures)
            for number, (then, now) in enumerate(zip(before, after, strict=True))
        ),
        active=tuple(_active(design, scale, empty)),
        before=before,
        after=after,
    )


def _cases(motion: Motion | Sequence[Case], loads: Sequence[Load]) -> tuple[Case, ...]:
    if isinstance(motion, Motion):
        return (Case(motion, tuple(loads)),)
    if not isinstance(motion, Sequence) or not motion or not all(isinstance(case, Case) for case in motion):
        raise PinpressError("motion is neither a motion, as cycle or simulate return, nor a list of Case(motion, loads)")
    if loads:
        raise PinpressError("loads goes with one motion: give every Case its own, Case(motion, loads)")
    return tuple(motion)


def checked(minimise: Target | Mapping[Target, float], limits: Mapping[Target, float]) -> dict[Target, float]:
    """The objective as targets with weights."""
    if not isinstance(minimise, Mapping | Measure | AddedMass):
        raise PinpressError(f"minimise: {shown(minimise)} is no measure: give Range, Rms, Peak or AddedMass()")
    objective = dict(minimise) if isinstance(minimise, Mapping) else {minimise: 1.0}
    for targets, what, words in ((objective, "weight", "minimise"), (limits, "limit", "limits")):
        for target, number in targets.items():
            if not isinstance(target, Measure | AddedMass):
                raise PinpressError(f"{words}: {shown(target)} is no measure: give Range, Rms, Peak or AddedMass()")
            if not is_number(number) or number < 0:
                raise PinpressError(
                    f"{words}: the {what} of the {target.words} is {shown(number)}: give a finite number that is not negative"
                )
    if not any(objective.values()):
        raise PinpressError("minimise: no weight is above zero, so that all counterweights are as good: give one")
    return {target: float(weight) for target, weight in objective.items() if weight > 0}


def _refuse_later_period(cases: Sequence[Case], result: Linkage) -> None:
    """Raise where a case is one period of the press, and counterweights on a shaft that was balanced make that longer."""
    turns = result.turns_until_back
    if any(is_cycle(case.motion) and case.motion.period_turns != turns for case in cases):
        after = "never" if turns is None else f"only after {turns} turns"
        raise PinpressError(
            f"with a counterweight on a geared shaft that was balanced {result.name} is back {after}, and the motion is shorter: give one"
            " over as many turns, cycle(press, speed, angle=[...]), or no room on that shaft"
        )


def _refuse_nothing(press: Linkage, problem: Problem, before: Sequence[Reactions], objective: Mapping[Target, float]) -> None:
    """Raise where a measure of the objective has nothing to improve, so that relative to it nothing can be said."""
    for signal in problem.signals:
        if signal.measure in objective and not signal.measure.value(before[signal.case]) >= (1 - ROUNDING) * signal.size:
            raise PinpressError(
                f"the {signal.measure.words} of {press.name} is zero before balancing: take it out of minimise, or limit it"
            )


def _without_traces(problem: Problem, objective: Mapping[Target, float], limits: Mapping[Target, float], variables: Array) -> Array:
    """The variables, those zero of rooms that are as good as empty: the solver stops where it cannot tell a little from none."""
    u, start = variables.copy(), 0
    for room in problem.layouts:
        own = slice(start, start + len(room.mass))
        if room.own is None and room.room.mass[0] <= 0 and abs(room.mass @ u[own]) <= NOTHING * problem.moving:
            empty = u.copy()
            empty[own] = 0.0
            if _no_worse(problem, objective, limits, empty, u):
                u = empty
        start += len(room.mass)
    return u


def _no_worse(problem: Problem, objective: Mapping[Target, float], limits: Mapping[Target, float], u: Array, before: Array) -> bool:
    """Whether variables are as good as others, but for a trace, in the objective and in what is limited."""
    held = [signal for signal in problem.signals if signal.measure in limits]
    return value_of(problem, objective, u) <= value_of(problem, objective, before) + TRACE * sum(objective.values()) and all(
        signal.measure.of(signal.at(u)) <= max(limits[signal.measure] / signal.size, signal.measure.of(signal.at(before))) + TRACE
        for signal in held
    )


def _filled(problem: Problem, u: Array) -> list[pin.Inertia]:
    """What every room is filled with, in its joint's frame."""
    ends = np.cumsum([len(room.mass) for room in problem.layouts])[:-1]
    bodies = []
    for room, own in zip(problem.layouts, np.split(u, ends), strict=True):
        filling = room.body(own)
        if room.own is not None and filling.mass <= NOTHING * problem.moving:
            raise PinpressError(
                f"it would be best to leave {shown(room.room.link)} without mass: give its room a least mass, mass=(least, most)"
            )
        bodies.append(filling)
    if problem.unlimited @ u > GROWN * LARGEST * problem.moving:
        rooms = [(filling.mass, room.room) for filling, room in zip(bodies, problem.layouts, strict=True) if math.isinf(room.room.mass[1])]
        _, heaviest = max(rooms, key=lambda pair: pair[0])
        raise PinpressError(
            f"counterweights grow beyond {LARGEST:g} times the moving mass, above all in the {heaviest.words}: limit it, mass=(0, most)"
        )
    return bodies


def _fitted(press: Linkage, problem: Problem, bodies: Sequence[pin.Inertia]) -> Linkage:
    inertias = list(press.model.inertias)
    for room in problem.layouts:
        if room.own is not None:
            inertias[room.joint] = pin.Inertia.Zero()
    for room, filling in zip(problem.layouts, bodies, strict=True):
        inertias[room.joint] = sum_of(inertias[room.joint], filling)
    for room in problem.layouts:
        refuse_unphysical(press, room.joint, inertias[room.joint])
    return press.with_inertias(inertias, name=press.name.removesuffix(BALANCED) + BALANCED)


def _counterweight(press: Linkage, room: Layout, filling: pin.Inertia) -> Counterweight:
    placement = press.model.frames[press.model.getFrameId(room.room.link, pin.BODY)].placement
    about = np.trace(filling.inertia) / 3
    if press.plane is not None:
        normal = press.plane.frames[room.joint - 1][2]
        about = normal @ filling.inertia @ normal
    if abs(about) <= SPECK * abs(filling.mass) * (filling.lever @ filling.lever):
        about = 0.0
    x, y, z = placement.actInv(filling.lever)
    return Counterweight(room.room.link, float(filling.mass), (float(x), float(y), float(z)), float(about))


def _refuse_unconfirmed(problem: Problem, u: Array, after: Sequence[Reactions]) -> None:
    """Raise where inverse dynamics of the balanced press, which knows nothing of the program, does not meet it."""
    for signal in problem.signals:
        promised, found = signal.at(u), signal.measure.varying(signal.measure.series(after[signal.case])) / signal.size
        missed = float(np.abs(found - promised).max())
        if not missed <= CONFIRMED * max(1.0, float(np.abs(signal.fixed).max())):
            raise PinpressError(
                f"the {signal.measure.words} of the balanced press is not what was worked out, but {missed:.1e} of what it was beside it:"
                " the masses are out of proportion; bring those of the rooms nearer to those of the links"
            )


def _scale(problem: Problem, objective: Mapping[Target, float]) -> float:
    (target,) = objective
    return problem.moving if isinstance(target, AddedMass) else next(s.size for s in problem.signals if s.measure == target)


def _active(design: Design, scale: float, empty: Sequence[Room]) -> Iterator[Active]:
    """The named constraints whose dual variables are not zero; rooms that stay empty have no shape that would hold anything back."""
    for rows, prices in zip(design.rows, design.prices, strict=True):
        price = float(prices[0] if rows.kind == CONE else np.abs(prices).sum())
        if not rows.name or price <= PRICELESS or (not rows.unit and any(rows.name.endswith(room.words) for room in empty)):
            continue
        yield Active(rows.name, scale * price / rows.unit if rows.unit else None)
