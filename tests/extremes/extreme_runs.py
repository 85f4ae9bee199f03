"""Cases a million turns away, of very many turns, and of starts at dead centres."""

import math
import warnings
from collections.abc import Callable

import numpy as np
from extremes.extreme_case import CLOSE, METHODS, ROUNDING, Case, Outcome, largest
from extremes.extreme_crank_slide import CrankSlider, slope, spinning

import pinpress as pp

MECHANISM = CrankSlider()
ROUND = np.linspace(0.1, 6.2, 25)
FLYWHEEL = 50.0


def far(turns: float) -> Case:
    """The closed form at these very floating-point angles; sine and cosine know them exactly."""
    angles = 2 * math.pi * turns + ROUND
    peak = np.abs(MECHANISM.torque(ROUND, 7.0, 3.0)).max()
    steepest = np.abs(np.gradient(MECHANISM.torque(np.linspace(0, 7, 701), 7.0, 3.0), 0.01)).max() / peak
    bound = ROUNDING + 4 * float(steepest) * float(np.spacing(abs(angles[-1])))
    return Case(
        "A million turns away",
        f"crank angles after {turns:.2g} turns",
        "closed form, within four roundings of the angle",
        lambda engine: spinning(MECHANISM.press(), engine, angles),
        MECHANISM.judge(bound),
    )


def far_run(turns: float) -> Case:
    """A run that begins there."""
    begin = 2 * math.pi * turns + 1.0

    def scene(method: str) -> pp.Run:
        return pp.simulate(MECHANISM.press(), 0.5, speed=8.0, angle=begin, flywheel=pp.drives.Flywheel(FLYWHEEL), method=method)

    return Case(
        "Many turns: runs",
        f"a run that begins after {turns:.0e} turns",
        "kept energy and the time by quadrature, within four roundings of the angle",
        scene,
        MECHANISM.free_run(FLYWHEEL, CLOSE + 4 * float(np.spacing(abs(begin)))),
        METHODS,
    )


def many(turns: int, long: bool = False) -> Case:
    """Energy is lost or gained by no more than 1e-11 a turn by `constraint`, whose steps err by that, and 1e-9 at all by `reduced`, whose
    periods close; an error of the energy makes one of the angle, half of it by the way turned through."""

    def scene(method: str) -> pp.Run:
        return pp.simulate(
            MECHANISM.press(), counted(method, turns) * 0.314, speed=20.0, angle=1.0, flywheel=pp.drives.Flywheel(FLYWHEEL), method=method
        )

    def judge(run: pp.Run) -> Outcome:
        q, w = run.crank_angle, run.crank_speed
        energy = 0.5 * (MECHANISM.inertia(q) + FLYWHEEL) * w * w + MECHANISM.potential(q)
        lost = float(np.abs(energy / energy[0] - 1).max())
        allowed = 1e-9 if run.stats.method == "reduced" else 1e-11 * counted("constraint", turns)
        late = MECHANISM.free_run(FLYWHEEL)(run).error / (0.5 * float(q[-1] - q[0]))
        return Outcome(largest(lost, late), allowed)

    return Case(
        "Many turns: runs",
        f"{turns} turns (`constraint`: a tenth)",
        "kept energy, and the time by quadrature: of the energy 1e-9 by `reduced`, 1e-11 a turn by `constraint`",
        scene,
        judge,
        METHODS,
        long=long,
    )


def counted(method: str, turns: int) -> int:
    return turns if method == "reduced" else max(turns // 10, 1)


# ---------------------------------------------------------------------------------------------------------------------- dead centres

STARTS = "Starts at dead centres: runs"


def moving(name: str, angle: float, speed: float, flywheel: float, torque: float = 0.0) -> Case:
    duration = 0.6

    def scene(method: str) -> pp.Run:
        drive = pp.drives.ConstantTorque(torque) if torque else None
        return pp.simulate(
            MECHANISM.press(), duration, speed=speed, angle=angle, flywheel=pp.drives.Flywheel(flywheel), drive=drive, method=method
        )

    def judge(run: pp.Run) -> Outcome:
        at, fast = MECHANISM.integrated(duration, speed, angle, flywheel, (lambda t, q, w: torque) if torque else None)
        return Outcome(largest(abs(float(run.crank_angle[-1]) - at), abs(float(run.crank_speed[-1]) - fast) / max(abs(fast), 1.0)), CLOSE)

    return Case(
        STARTS,
        name,
        "the closed-form equation of motion, integrated by SciPy",
        scene,
        judge,
        METHODS,
    )


def resting(name: str, angle: float, judge: Callable[[pp.Run], Outcome], expected: str) -> Case:
    def scene(method: str) -> pp.Run:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            run = pp.simulate(MECHANISM.press(), 1.5, angle=angle, method=method)
        assert [warning.category for warning in said] == [pp.PinpressWarning] * (abs(angle - math.pi) < 0.1)  # at an unstable rest alone
        return run

    return Case(STARTS, name, expected, scene, judge, METHODS)


def stays(run: pp.Run) -> Outcome:
    """Where it is put, which far from zero lies beside the bottom by the rounding of the angle."""
    return Outcome(float(np.abs(run.crank_angle - run.crank_angle[0]).max()), 1e-9 + 4 * float(np.spacing(run.crank_angle[0])))


def falls(run: pp.Run) -> Outcome:
    """The rounding of pi decides whether and when it comes down; then with the energy of the fall."""
    fallen = MECHANISM.potential(math.pi) - MECHANISM.potential(run.crank_angle)
    kinetic = 0.5 * MECHANISM.inertia(run.crank_angle) * run.crank_speed**2
    return Outcome(float(np.abs(kinetic - fallen).max() / (MECHANISM.potential(math.pi) - MECHANISM.potential(0.0))), 1e-8)


def stiffness() -> tuple[float, float]:
    """Frequency [rad/s] of small swings about the bottom, and rate of growth of errors about the top [1/s]."""
    bend = [(slope(MECHANISM.potential, q + 1e-4) - slope(MECHANISM.potential, q - 1e-4)) / 2e-4 for q in (0.0, math.pi)]
    bottom, top = (abs(float(b)) / float(MECHANISM.inertia(q)) for b, q in zip(bend, (0.0, math.pi), strict=True))
    return math.sqrt(bottom), math.sqrt(top)


# A step errs by 1e-11 rad, 1e-5 of the motions below, and some steps do; the error grows as they do.


def swings(run: pp.Run) -> Outcome:
    """The sine of the linear equation, but for the square of the size: the inertia doubles within 0.05 rad."""
    frequency, _ = stiffness()
    expected = 1e-6 * np.cos(frequency * run.time)
    return Outcome(float(np.abs(run.crank_angle - expected).max()) / 1e-6, 1e-4)


def rolls(run: pp.Run) -> Outcome:
    """From 1e-6 rad beside the top the linear equation's cosh, as long as that is small."""
    _, growth = stiffness()
    expected = 1e-6 * np.cosh(growth * run.time)
    small = expected < 1e-4
    return Outcome(float(np.abs((run.crank_angle - math.pi)[small] / expected[small] - 1).max()), 1e-4)


CASES = [
    *(far(turns) for turns in (1e6, -1e6, 1.5e6)),
    *(far_run(turns) for turns in (1e6, -1e6)),
    many(3000),
    many(10_000, long=True),
    resting("at rest at the bottom", 0.0, stays, "it stays (1e-9 rad, and four roundings of the angle)"),
    resting("at rest a million turns above the bottom", 2 * math.pi * 1e6, stays, "it stays (1e-9 rad, and four roundings of the angle)"),
    resting("at rest at the top", math.pi, falls, "it stays, or comes down with the energy of the fall"),
    resting("at rest 1e-6 rad beside the top", math.pi + 1e-6, rolls, "cosh of the linear equation (1e-4 of it)"),
    resting("at rest 1e-6 rad beside the bottom", 1e-6, swings, "cosine of the linear equation (1e-4 of it)"),
    moving("bottom, 8 rad/s, flywheel", 0.0, 8.0, FLYWHEEL),
    moving("bottom, 5 rad/s, no flywheel: it swings", 0.0, 5.0, 0.0),
    moving("top, 8 rad/s, flywheel", math.pi, 8.0, FLYWHEEL),
    moving("top, -5 rad/s, no flywheel", math.pi, -5.0, 0.0),
    moving("bottom, from rest by 600 N m", 0.0, 0.0, FLYWHEEL, 600.0),
    moving("top, from rest by -600 N m", math.pi, 0.0, FLYWHEEL, -600.0),
]
