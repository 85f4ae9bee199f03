"""Contests of `compare`: methods with their settings, the work that is timed, and how its answer is judged.

Run times can be compared because contestants take turns: whatever else the machine does meets all of them.
"""

import gc
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import PinpressError
from ..dynamics.inverse_dynamics import Reactions
from .measurements import Measurement

TURN = 0.02  # of calls before the next one's turn: the first call after another contestant finds its data and code evicted [s]
PATIENCE = 2.0  # after which a contestant, once timed, has had its turns [s]


class Errors(NamedTuple):
    """Errors of an answer, see `Measurement`."""

    error: float
    force_error: float | None = None
    loop_gap: float | None = None
    energy_error: float | None = None
    evaluations: int | None = None


@dataclass(frozen=True)
class Contestant:
    """A method with a setting that takes part in a contest. A `PinpressError` that its work or its judge raises is an answer too.

    Attributes:
        group: of the contest.
        method: "plane", "reduced", ..., or a peer with its version.
        setting: in words.
        number: the setting: a tolerance, a step [s], a proximal parameter, a number of samples; None where it has none.
        work: what is timed.
        errors: judges what the work returns.
    """

    group: str
    method: str
    setting: str
    number: float | None
    work: Callable[[], Any]
    errors: Callable[[Any], Errors]


@dataclass(frozen=True)
class Contest:
    """Contestants of a group, and the reference by which they are judged.

    Attributes:
        group: one of `measurements.GROUPS`.
        contestants: all that take part.
        certificate: difference of the two independent methods that make the reference.
        certified_by: which two these are.
        skipped: a line for each that takes no part, with the reason.
    """

    group: str
    contestants: tuple[Contestant, ...]
    certificate: float
    certified_by: str
    skipped: tuple[str, ...] = ()


def measured(contestants: Sequence[Contestant], repeats: int, done: Callable[[], None]) -> tuple[Measurement, ...]:
    """Judge every contestant once and time all in turn.

    Args:
        contestants: in the order of the result.
        repeats: rounds of timing.
        done: called after every piece of work.
    """
    judged: list[tuple[Contestant, Errors | None, str]] = []
    for contestant in contestants:
        try:
            judged.append((contestant, contestant.errors(contestant.work()), ""))
        except PinpressError as error:
            judged.append((contestant, None, str(error).split(":")[0]))
        done()
    seconds = least_seconds([_tried(contestant.work) for contestant in contestants], repeats, done)
    return tuple(_measurement(*each, time) for each, time in zip(judged, seconds, strict=True))


def force_error(forces: Mapping[str, Array], expected: Reactions, peak: float, determined: bool = False) -> float:
    """Largest distance of a bearing's force from the expected one, as a share of a peak force [-].

    Args:
        forces: (n, 3) by bearing [N].
        expected: has the forces that are right.
        peak: [N].
        determined: leave out the components that rigid mechanics leaves open, which other programs share in ways of their own.
    """
    found = []
    for name, force in expected.bearing_force.items():
        off = forces[name] - force
        if determined:
            off = (off @ expected.indeterminate_axes.T)[:, ~expected.indeterminate[name][:3]]
        found.append(float(np.linalg.norm(off, axis=1).max()))
    return max(found) / peak


def peak_force(forces: Mapping[str, Array]) -> float:
    """Largest force of any bearing (n, 3) in any state [N]; 1 where there is none."""
    return max(float(np.linalg.norm(force, axis=1).max()) for force in forces.values()) or 1.0


def peak_of(values: Array) -> float:
    """The largest size among values; 1 where all are zero, of which a share cannot be given."""
    return float(np.abs(values).max()) or 1.0


def least_seconds(works: Sequence[Callable[[], object]], repeats: int, done: Callable[[], None] = lambda: None) -> list[float]:
    """Least time of a call of each piece of work [s].

    Args:
        works: called without arguments, in turn.
        repeats: rounds, without the garbage collector.
        done: called after every turn.
    """
    best, spent = [float("inf")] * len(works), [0.0] * len(works)
    collecting = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        for _ in range(repeats):
            for k, work in enumerate(works):
                end = time.perf_counter() + TURN
                while spent[k] < PATIENCE:
                    start = time.perf_counter()
                    work()
                    now = time.perf_counter()
                    best[k], spent[k] = min(best[k], now - start), spent[k] + now - start
                    if now > end:
                        break
                done()
    finally:
        if collecting:
            gc.enable()
    return best


def _tried(work: Callable[[], Any]) -> Callable[[], None]:
    def tried() -> None:
        with suppress(PinpressError):
            work()

    return tried


def _measurement(contestant: Contestant, errors: Errors | None, problem: str, seconds: float) -> Measurement:
    """What is not finite is no error, but a problem."""
    values = errors or Errors(math.nan)
    error, force, gap, energy, evaluations = (None if value is None or not math.isfinite(value) else value for value in values)
    return Measurement(
        group=contestant.group,
        method=contestant.method,
        setting=contestant.setting,
        number=contestant.number,
        seconds=seconds,
        error=error,
        force_error=force,
        loop_gap=gap,
        energy_error=None if energy is None else abs(energy),
        evaluations=None if evaluations is None else int(evaluations),
        problem=problem or ("not finite" if error is None else ""),
    )
