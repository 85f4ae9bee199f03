"""Contestants of `accuracy`: a method with a setting, the work that is timed, and how its answer is judged."""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import PinpressError
from ..dynamics.inverse_dynamics import Reactions
from .measurements import Measurement
from .timing import least_seconds


class Errors(NamedTuple):
    """Of an answer, see `Measurement`."""

    error: float
    force_error: float | None = None
    loop_gap: float | None = None
    energy_error: float | None = None
    evaluations: int | None = None


@dataclass(frozen=True)
class Contestant:
    """``work`` is timed; what it returns is judged by ``errors``. A `PinpressError` of either is an answer too."""

    group: str
    method: str
    setting: str
    number: float | None
    work: Callable[[], Any]
    errors: Callable[[Any], Errors]


@dataclass(frozen=True)
class Contest:
    """Contestants of a group, and the reference they are judged by.

    Attributes:
        certificate: difference of the two independent methods that make the reference; certified_by: which these are.
        skipped: what is not among them, and why, a line each.
    """

    group: str
    contestants: tuple[Contestant, ...]
    certificate: float
    certified_by: str
    skipped: tuple[str, ...] = ()


def measured(contestants: Sequence[Contestant], repeats: int, done: Callable[[], None]) -> tuple[Measurement, ...]:
    """All of them, judged once and timed in turn; ``done`` is called after every piece of work."""
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
    """Largest length of the difference of a bearing's force (n, 3), of a peak [N]; ``determined``: without the components that rigid
    mechanics leaves open, which other programs share in ways of their own."""
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
