"""Cases of noise in a URDF's numbers, of loops drawn open, and of Pinocchio's proximal settings."""

import re
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from extremes.extreme_case import ROUNDING, Case, Outcome, compare, largest, loaded, shipped
from extremes.extreme_crank_slide import CrankSlider, spinning
from extremes.extreme_sizes import of_size
from support.generators.small_linkages import bolted

import pinpress as pp

SIX = "zxn2_3000b"
ROUND = np.linspace(-0.3, 6.2, 25)
MODEST = 100.0  # times the noise: from the crank to the slide the six-bar has levers of 10, and 2 of them
NUMBERS = re.compile(r'\b(xyz|rpy|mass value|i[xyz]{2})="([^"]*)"')


# ----------------------------------------------------------------------------------------------------------------- numbers of a URDF


def rewritten(change: Callable[[float], str]) -> str:
    """The six-bar with every number of its bodies and joints written anew."""

    def anew(match: re.Match[str]) -> str:
        return f'{match.group(1)}="' + " ".join(change(float(number)) for number in match.group(2).split()) + '"'

    return NUMBERS.sub(anew, shipped(SIX).text.decode())


def perturbed(size: float) -> str:
    rng = np.random.default_rng(0)
    return rewritten(lambda number: repr(number * (1 + size * float(rng.uniform(-1, 1)))))


def noisy(name: str, text: Callable[[], str], noise: float) -> Case:
    bound = MODEST * noise + ROUNDING

    def judge(result: pp.Reactions) -> Outcome:
        return Outcome(compare(result, spinning(shipped(SIX), result.engine, ROUND)), bound)

    return Case(
        "Noise in the numbers of a URDF",
        name,
        f"torque and forces change by no more than {MODEST:.0f} times as much",
        lambda engine: spinning(loaded(text()), engine, ROUND),
        judge,
    )


def printed(digits: int) -> Case:
    noise = 0.5 * 10.0 ** (1 - digits) if digits < 17 else 0.0
    return noisy(f"{SIX}, every number with {digits} digits", lambda: rewritten(lambda number: f"{number:.{digits}g}"), noise)


def open_by(gap: float) -> list[Case]:
    """A slide that is drawn off its place: closed, nothing of it is left."""
    mechanism = CrankSlider()

    def six() -> pp.Linkage:
        place = -0.9579409746502484
        text = shipped(SIX).text.decode()
        assert text.count(repr(place)) == 1
        return loaded(text.replace(repr(place), repr(place + gap)))

    def judge(result: pp.Reactions) -> Outcome:
        one = spinning(shipped(SIX), result.engine, ROUND)
        apart = float(np.abs(result.motion.slide_position - one.motion.slide_position).max())
        return Outcome(largest(compare(result, one), apart), ROUNDING)

    return [
        Case(
            "Loops that are drawn open",
            f"crank-slider, by {gap:.0e} m",
            "closed form",
            lambda engine: spinning(loaded(mechanism.text(gap)), engine, ROUND),
            mechanism.judge(ROUNDING),
        ),
        Case(
            "Loops that are drawn open",
            f"{SIX}, by {gap:.0e} m",
            "all as drawn closed",
            lambda engine: spinning(six(), engine, ROUND),
            judge,
        ),
    ]


# ------------------------------------------------------------------------------------------------------------------ proximal settings

STATES = ((0.4, 7.0, 3.0), (2.1, -7.0, 0.0), (5.2, 30.0, -100.0))  # crank angle, speed, acceleration


@cache
def pressed(which: str) -> pp.Linkage:
    if which == "upright":
        return shipped(SIX)
    return bolted(shipped(SIX), "0.3 0.2 0.1") if which == "tilted" else of_size(2.0**-20, 3)


@cache
def asked(which: str) -> tuple[pp.Motion, Any]:
    """States, and the torques that give them their accelerations."""
    angle, speed, acceleration = map(np.array, zip(*STATES, strict=True))
    motion = pp.servo_cycle(pressed(which), speed=speed, angle=angle, acceleration=acceleration)
    return motion, pp.inverse_dynamics(pressed(which), motion).driving_torque


def proximal(which: str) -> Case:
    """The accelerations with which runs under these torques begin."""

    def scene(_: str) -> list[pp.Run]:
        torques = asked(which)[1]
        return [
            pp.simulate(
                pressed(which), 1e-3, speed=w, angle=q, drive=pp.drives.ConstantTorque(float(torque)), method="constraint", points=2
            )
            for (q, w, _), torque in zip(STATES, torques, strict=True)
        ]

    def judge(runs: list[pp.Run]) -> Outcome:
        motion, _ = asked(which)
        return Outcome(largest(*(float(np.abs(run.a[0] - a).max() / np.abs(a).max()) for run, a in zip(runs, motion.a, strict=True))), 1e-9)

    return Case(
        "Proximal settings of Pinocchio's constraint dynamics",
        f"{SIX} {which}",
        "the accelerations that inverse dynamics began with; pinpress chooses mu",
        scene,
        judge,
        ("constraint",),
    )


CASES = [
    *(noisy(f"{SIX}, every number changed by up to {size:.0e}", lambda size=size: perturbed(size), size) for size in (1e-12, 1e-9, 1e-6)),
    *(printed(digits) for digits in (6, 9, 12, 17)),
    *(case for gap in (1e-3, 1e-6, 1e-9, 1e-12) for case in open_by(gap)),
    *(proximal(which) for which in ("upright", "tilted", "times 2^-20")),
]
