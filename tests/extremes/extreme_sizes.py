"""Cases of extreme proportions, masses, speeds and sizes."""

import math
import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from extremes.extreme_case import EPS, METHODS, ROUNDING, Case, Outcome, largest, lever, loaded, refusal, shipped, short, worst
from extremes.extreme_crank_slide import CrankSlider, spinning

import pinpress as pp

ORDINARY = CrankSlider()
ROUND = np.linspace(-0.3, 6.2, 25)  # crank angles
CLOSED = "closed form"
KEPT = "kept energy and the time by quadrature"


# -------------------------------------------------------------------------------------------------------------------- proportions


def proportion(ratio: float) -> list[Case]:
    """Crank to rod."""
    mechanism = CrankSlider(rod=0.1 / ratio) if ratio > 0.1 else CrankSlider(crank=0.4 * ratio)
    bound = ROUNDING + 10 * EPS / (1 - ratio)
    inverse = Case(
        "Crank to rod from 0.001 to 0.9999",
        f"lambda = {ratio:g}: motion, torque, force on the slide",
        CLOSED + ", within its conditioning, 10 eps / (1 - lambda)" * (ratio > 0.99),
        lambda engine: spinning(mechanism.press(), engine, ROUND),
        mechanism.judge(bound),
    )

    def free(method: str) -> pp.Run:
        return pp.simulate(mechanism.press(), 0.8, speed=8.0, flywheel=pp.drives.Flywheel(50.0), method=method)

    corners = [place + share * math.sqrt(2 * (1 - ratio)) for place in (0.5 * math.pi, 1.5 * math.pi) for share in (-10, -3, 3, 10)]
    at = corners if ratio > 0.99 else ()
    run = Case(
        "Crank to rod from 0.001 to 0.9999: runs",
        f"lambda = {ratio:g}: a turn from 8 rad/s",
        KEPT,
        free,
        mechanism.free_run(50.0, at=at),
        METHODS,
    )
    return [inverse, run]


# ------------------------------------------------------------------------------------------------------------------------- masses

LIGHT = 1e-9
MASSES = {
    "slide 1e-9 of the crank": replace(ORDINARY, slide_mass=2e-8),
    "slide 1e-3 of the crank": replace(ORDINARY, slide_mass=2e-2),
    "slide 1e3 times the crank": replace(ORDINARY, slide_mass=2e4),
    "slide 1e9 times the crank": replace(ORDINARY, slide_mass=2e10),
    "rod 1e-9 of the slide": replace(ORDINARY, rod_mass=1e-7, rod_inertia=2e-9),
    "rod 1e9 times the slide": replace(ORDINARY, rod_mass=1e11, rod_inertia=2e9),
    "crank 1e-9 of all else": replace(ORDINARY, crank_mass=2e-8, crank_inertia=1e-10),
    "crank 1e9 times all else": replace(ORDINARY, crank_mass=2e10, crank_inertia=1e8),
    "no mass but the slide's": replace(ORDINARY, crank_mass=5e-324, crank_inertia=0.0, rod_mass=5e-324, rod_inertia=0.0, crank_centre=0.5),
    "no mass but the rod's": replace(ORDINARY, crank_mass=5e-324, crank_inertia=0.0, slide_mass=5e-324),
    "no moments of inertia, masses at the pins": replace(ORDINARY, crank_inertia=0.0, rod_inertia=0.0, crank_centre=1.0, rod_centre=1.0),
}


def masses(name: str, mechanism: CrankSlider) -> list[Case]:
    """Forces are judged beside the weights of all: nothing of 1e-16 of them can be seen in what they balance."""
    moved = max(mechanism.slide_mass, mechanism.rod_mass) * 9.81
    inverse = Case(
        "Masses from 1e-9 to 1e9 of each other",
        f"{name}: motion, torque, force on the slide",
        CLOSED + ", forces beside the heaviest link's weight",
        lambda engine: spinning(mechanism.press(), engine, ROUND),
        mechanism.judge(ROUNDING, moved),
    )
    # from 20 degrees at a speed that carries it over the top, for what would be a turn
    rise = float(mechanism.potential(math.pi) - mechanism.potential(0.0))
    speed = max(8.0, math.sqrt(4 * abs(rise) / float(mechanism.inertia(0.35))))

    def free(method: str) -> pp.Run:
        return pp.simulate(mechanism.press(), 6.0 / speed, speed=speed, angle=0.35, method=method)

    run = Case(
        "Masses from 1e-9 to 1e9 of each other: runs",
        f"{name}: free from 20 deg at {speed:.3g} rad/s, no flywheel",
        KEPT,
        free,
        mechanism.free_run(0.0, at=np.concatenate([c + np.array([-1e-2, -1e-4, 1e-4, 1e-2]) for c in (0.0, math.pi)]).tolist()),
        METHODS,
    )
    if not float(mechanism.inertia(math.pi)) > 1e-12:
        run = replace(
            run,
            expected="SimulationError at a dead centre (1e-3 rad): no inertia is left there, and no speed that keeps the energy",
            judge=refusal(pp.SimulationError, [0.0, math.pi], 1e-3),
            refused=True,
        )
    return [inverse, run]


# ------------------------------------------------------------------------------------------------------------------------- speeds


@cache
def parts(name: str, engine: str) -> tuple[pp.Reactions, pp.Reactions]:
    """Of the weights alone, at rest; and of the inertias alone at 1 rad/s."""
    press, weightless = shipped(name), pp.load(name, gravity=(0.0, 0.0, 0.0))
    return spinning(press, engine, ROUND, 0.0, 0.0), spinning(weightless, engine, ROUND, 1.0, 0.0)


def quadratic(name: str, rate: float) -> Case:
    """Torque and forces are what the weights ask for plus w^2 times what the inertias ask for."""
    w = rate * pp.RPM

    def judge(result: pp.Reactions) -> Outcome:
        still, moving = parts(name, result.engine)
        parts_of = ((result, 1.0), (still, 1.0), (moving, w * w))
        force, *forces = (np.array([one.bearing_force[b] for b in result.bearing_force]) * factor for one, factor in parts_of)
        torque = np.abs(result.driving_torque - still.driving_torque - w * w * moving.driving_torque).max()
        size = max(float(np.abs(result.driving_torque).max()), lever(moving) * float(np.abs(force).max()))  # as `compare` has it
        return Outcome(largest(float(torque) / size, worst([(force, forces[0] + forces[1])])), 1e-13)

    return Case(
        "From 1 to 20 000 strokes/min",
        f"{name} at {rate:g}/min: torque and bearing forces",
        "w^2 times those without gravity at 1 rad/s, plus those at rest (1e-13)",
        lambda engine: spinning(shipped(name), engine, ROUND, w, 0.0),
        judge,
    )


def fast(rate: float) -> Case:
    """Two turns; below 100/min it needs a flywheel to come over the top."""
    w = rate * pp.RPM
    flywheel = max(1.0, 2e3 / w**2)

    def free(method: str) -> pp.Run:
        return pp.simulate(ORDINARY.press(), 12.0 / w, speed=w, flywheel=pp.drives.Flywheel(flywheel), method=method)

    return Case(
        "From 1 to 20 000 strokes/min: runs",
        f"crank_slide at {rate:g}/min, two turns",
        KEPT,
        free,
        ORDINARY.free_run(flywheel),
        METHODS,
    )


# -------------------------------------------------------------------------------------------------------------------------- sizes

SIX = "zxn2_3000b"


def scaled(text: str, size: float, mass: int) -> str:
    """The URDF with lengths by a factor, masses by a power of it, inertias by that and its square."""

    def grown(match: re.Match[str]) -> str:
        power = {"x": 1, "m": mass, "i": mass + 2, "l": 1, "u": 1}[match.group(1)[0]]
        return f'{match.group(1)}="' + " ".join(repr(float(number) * size**power) for number in match.group(2).split()) + '"'

    return re.sub(r'(?<!axis )\b(xyz|mass value|i[xyz]{2}|lower|upper)="([^"]*)"', grown, text)


def of_size(size: float, mass: int) -> pp.Linkage:
    return loaded(scaled(shipped(SIX).text.decode(), size, mass), (0.0, 0.0, -9.81 * size))


def spring(size: float, mass: int) -> pp.loads.SpringDamper:
    k, length = 2e5 * size**mass, 0.4 * size
    return pp.loads.SpringDamper("frame", "slide", stiffness=k, damping=500 * size**mass, free_length=length, point1=(0.0, 0.0, 0.5 * size))


def stacked(by_bearing: Any) -> Any:
    return np.array([by_bearing[name] for name in by_bearing])


def same_but_larger(name: str, size: float, mass: int) -> list[Case]:
    """With gravity by the factor too, all times and angles stay."""

    def scene(engine: str, size: float = size) -> pp.Reactions:
        return spinning(of_size(size, mass), engine, ROUND, loads=[spring(size, mass)])

    def judge(result: pp.Reactions) -> Outcome:
        one = scene(result.engine, 1.0)
        grown = [
            (result.driving_torque / size ** (mass + 2), one.driving_torque),
            (result.motion.slide_position / size, one.motion.slide_position),
            (result.motion.slide_acceleration / size, one.motion.slide_acceleration),
            (stacked(result.bearing_force) / size ** (mass + 1), stacked(one.bearing_force)),
            (stacked(result.bearing_moment) / size ** (mass + 2), stacked(one.bearing_moment)),
        ]
        return Outcome(worst(grown), 1e-13)

    def free(method: str, size: float = size) -> pp.Run:
        flywheel, loads = pp.drives.Flywheel(500 * size ** (mass + 2)), [spring(size, mass)]
        return pp.simulate(of_size(size, mass), 0.5, speed=8.0, flywheel=flywheel, loads=loads, method=method, points=60)

    def judge_run(run: pp.Run) -> Outcome:
        one = free(run.stats.method, 1.0)
        apart = float(np.abs(run.crank_angle - one.crank_angle).max())
        return Outcome(largest(apart, float(np.abs(run.crank_speed - one.crank_speed).max()) / 8.0), 1e-9)

    words = "masses by the cube" if mass == 3 else "masses as they are"
    return [
        Case(
            "From micrometres to kilometres",
            f"{SIX} times {name}, {words}: all of it",
            "forces by mass x length, torque by mass x length^2 (1e-13)",
            scene,
            judge,
        ),
        Case(
            "From micrometres to kilometres: runs",
            f"{SIX} times {name}, {words}",
            "the same angles at the same times (1e-9: steps are chosen anew)",
            free,
            judge_run,
            METHODS,
        ),
    ]


def too_heavy() -> Case:
    """The reader takes numbers up to 1e12."""

    def judge(found: Any) -> Outcome:
        refused = isinstance(found, pp.UrdfError) and "<mass>" in str(found) and "out of range" in found.problem
        return Outcome(0.0 if refused else math.inf, 0.0, short(found) if isinstance(found, Exception) else "no error")

    return Case(
        "From micrometres to kilometres",
        f"{SIX} times 2^10, masses by the cube: 1e12 kg",
        "UrdfError that names the mass",
        lambda _: of_size(2.0**10, 3),
        judge,
        ("either",),
        refused=True,
    )


def by_size(group: list[list[Case]]) -> list[Case]:
    """First all inverse dynamics, then all runs: they stand in tables of their own."""
    return [case for kind in zip(*group, strict=True) for case in kind]


def proportions_and_masses() -> list[Case]:
    ratios = by_size([proportion(ratio) for ratio in (0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999)])
    return ratios + by_size([masses(name, mechanism) for name, mechanism in MASSES.items()]) + [between_dead_centres()]


def between_dead_centres() -> Case:
    """Where only the slide has mass there is inertia but at dead centres; between them it falls freely."""
    mechanism = MASSES["no mass but the slide's"]

    def free(method: str) -> pp.Run:
        return pp.simulate(mechanism.press(), 0.1, speed=20.0, angle=0.5, method=method)

    return Case(
        "Masses from 1e-9 to 1e9 of each other: runs",
        "no mass but the slide's: between dead centres, from 29 deg at 20 rad/s",
        KEPT,
        free,
        mechanism.free_run(0.0),
        METHODS,
    )


RATES: tuple[Any, ...] = (1.0, 70.0, 1e3, 2e4)
SMALL = [(f"2^{power}", 2.0**power, 3) for power in (-20, -10, 6)] + [(f"1e{power}", 10.0**power, 3) for power in (-6, -3, 1)]
LARGE = [(f"2^{power}", 2.0**power, 0) for power in (-20, 10, 12)] + [(f"1e{power}", 10.0**power, 0) for power in (-6, 3, 4)]

CASES = [
    *proportions_and_masses(),
    *(quadratic(name, rate) for name in (SIX, "jf75g_125") for rate in RATES),
    *(fast(rate) for rate in (1.0, 20.0, 1e3, 2e4)),
    *by_size([same_but_larger(*size) for size in SMALL + LARGE]),
    too_heavy(),
]
