"""A case of the table of extremes: what pinpress does in a scene, how it is judged.

Every case has an expectation that owes nothing to what is judged: a closed form, a law of scaling or of conservation, or the other engine
or method. "It did not crash" is none.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from support import texts

import pinpress as pp

ENGINES = ("plane", "space", "pinocchio")
METHODS = ("reduced", "constraint")
EPS = float(np.finfo(float).eps)
ROUNDING = 1e-12
"""Of the peak: what the engines agree to with each other and with closed forms on ordinary linkages, see docs/motion_and_forces.md."""
CLOSE = 1e-7
"""rad, of speeds times the speed: the methods keep to 1e-11 a step, in tens to hundreds of steps; edges and stops multiply that by tens."""


@dataclass(frozen=True)
class Outcome:
    """``error`` against the expectation and the ``bound`` it is held to, in the same unit; ``what`` happens, where a number does not say
    it. An error of nan or infinity is above any bound."""

    error: float
    bound: float
    what: str = ""

    @property
    def met(self) -> bool:
        return self.error <= self.bound


@dataclass(frozen=True)
class Case:
    """One row of the table.

    Attributes:
        group, name, expected: in words.
        ways: engines or methods, each judged by itself.
        scene: way -> what pinpress makes of it.
        judge: of what the scene gives, or of the `PinpressError` that it ends in where one is expected.
        refused: whether an error may be right.
        long: whether it is left to the command; tests leave it out.
    """

    group: str
    name: str
    expected: str
    scene: Callable[[str], Any]
    judge: Callable[[Any], Outcome]
    ways: tuple[str, ...] = ENGINES
    refused: bool = False
    long: bool = False

    def work(self, way: str) -> Outcome:
        try:
            found: Any = self.scene(way)
        except pp.PinpressError as error:
            found = error
        if isinstance(found, pp.PinpressError) and not self.refused:
            return Outcome(math.inf, 0.0, short(found))
        return self.judge(found)


def short(error: BaseException) -> str:
    """The kind of an error, its crank angle and the beginning of what it says."""
    angle = getattr(error, "crank_angle", None)
    at = "" if angle is None else f" at {math.degrees(angle):.6g} deg"
    said = error.problem if isinstance(error, pp.UrdfError) else str(error).split("; ")[0].split(" (")[0]
    said = re.sub(r"\S*[/\\](?=\w+\.urdf)", "", said)  # where a text was written to is not what happens
    return f"{type(error).__name__}{at}: {said if len(said) < 60 else said[:57] + '...'}"


def refusal(kind: type[pp.PinpressError], angles: Sequence[float], bound: float) -> Callable[[Any], Outcome]:
    """Judges an error: of that kind, at one of the crank angles [rad] within the bound."""

    def judge(found: Any) -> Outcome:
        if not isinstance(found, pp.PinpressError):
            return Outcome(math.inf, bound, "no error, but a result")
        at = getattr(found, "crank_angle", None)
        if not isinstance(found, kind) or at is None:
            return Outcome(math.inf, bound, short(found))
        return Outcome(min(abs(at - angle) for angle in angles), bound, short(found))

    return judge


def largest(*errors: float) -> float:
    """The largest; nan where one is, which `max` may pass over."""
    return float(np.max(errors))


def worst(pairs: Sequence[tuple[Any, Any]]) -> float:
    """The largest difference of any pair of arrays, found and expected, relative to the peak of what is expected; nan where one has it."""
    errors = []
    for found, expected in pairs:
        peak = float(np.abs(expected).max())
        errors.append(float(np.abs(np.asarray(found) - expected).max()) / (peak or 1.0))
    return largest(*errors)


def compare(one: pp.Reactions, other: pp.Reactions, turned: Any = None) -> float:
    """The largest difference of torque, of bearing forces and of moments, each relative to the largest of its kind; ``turned`` (3, 3)
    turns the vectors of ``other`` first. A balanced press has next to no torque: torque and moments are rounded beside the largest
    force at the slide's lever, and at least relative to that."""
    rotation = np.eye(3) if turned is None else turned
    (force, its_force), (moment, its_moment) = (
        [np.array([getattr(result, kind)[name] for name in result.bearing_force]) for result in (one, other)]
        for kind in ("bearing_force", "bearing_moment")
    )
    arm, torque = lever(other) * float(np.abs(its_force).max()), float(np.abs(other.driving_torque).max())
    return largest(
        worst([(force, its_force @ rotation.T)]),
        float(np.abs(moment - its_moment @ rotation.T).max()) / (max(arm, float(np.abs(its_moment).max())) or 1.0),
        float(np.abs(one.driving_torque - other.driving_torque).max()) / (max(arm, torque) or 1.0),
    )


def lever(result: pp.Reactions) -> float:
    """The largest of the slide's at the crank [m]; 0 where there is no slide."""
    motion = result.motion
    return 0.0 if motion._guide is None else float(np.abs(motion.slide_velocity / motion.crank_speed).max())


def loaded(text: str, gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)) -> pp.Linkage:
    """The linkage of a text; of a same text the same one."""
    return texts.load(text, gravity)


def shipped(name: str) -> pp.Linkage:
    return texts.shipped(name)
