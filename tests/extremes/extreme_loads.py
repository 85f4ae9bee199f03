"""Cases of extreme loads: stiff dies at impact, pulses, forces of 1 N and of 1 GN."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from extremes.extreme_case import CLOSE, METHODS, Case, Outcome, largest, shipped, worst
from extremes.extreme_crank_slide import CrankSlider, lasting, spinning
from scipy.integrate import quad
from scipy.optimize import brentq

import pinpress as pp
from pinpress.loads.process import ConstantForce, ElasticDie, TimeForce

MECHANISM = CrankSlider()
BOTTOM = -MECHANISM.crank - MECHANISM.rod
ROUND = np.linspace(-0.3, 6.2, 25)
EDGE = 0.02  # height at which dies and piles are met [m]
START, SPEED, FLYWHEEL = 5.0, 10.0, 50.0  # crank angle, speed and inertia before it


def height_angle(height: float) -> float:
    """Crank angle on the way down at a height above bottom dead centre: the cosine rule."""
    along, r, rod = -BOTTOM - height, MECHANISM.crank, MECHANISM.rod
    return 2 * math.pi - math.acos((along * along + r * r - rod * rod) / (2 * r * along))


@dataclass(frozen=True)
class Store:
    """A load that stores ``size`` x^power of work at a way x below the edge [m, J]: a die without damping (2), a pile (1)."""

    size: float
    power: int

    def potential(self, q: Any) -> Any:
        into = np.maximum(EDGE - (MECHANISM.slide(q) - BOTTOM), 0.0)
        return self.size * into**self.power

    @property
    def energy(self) -> float:
        return 0.5 * float(MECHANISM.inertia(START) + FLYWHEEL) * SPEED**2 + float(MECHANISM.potential(START))

    def deepest(self) -> float | None:
        """The way to where the slide is thrown back; None where it gets through bottom dead centre."""

        def left(x: float) -> float:
            return self.energy - float(MECHANISM.potential(height_angle(EDGE - x))) - self.size * x**self.power

        return float(brentq(left, 0.0, EDGE, xtol=1e-18, rtol=1e-15)) if left(EDGE) < 0 else None

    def back(self) -> float:
        """How long it takes until the slide is back where it was, by quadrature.

        Within the die x = X sin^(2/n) of an angle: what is left of the energy is then a square that no longer is a difference.
        """
        deepest = self.deepest()
        assert deepest is not None
        turned = height_angle(EDGE - deepest)
        at_turn = float(MECHANISM.potential(turned))

        def inside(angle: float) -> float:
            part = math.sin(angle) ** (2 / self.power)
            q = height_angle(EDGE - deepest * part)
            fallen = (at_turn - float(MECHANISM.potential(q))) / math.cos(angle) ** 2
            along = 2 / self.power * deepest * math.sin(angle) ** (2 / self.power - 1)  # dx/d(angle) by the cosine
            inertia = float(MECHANISM.inertia(q)) + FLYWHEEL
            return along / abs(float(MECHANISM.lever(q))) * math.sqrt(inertia / (2 * (self.size * deepest**self.power + fallen)))

        def outside(q: float) -> float:
            return math.sqrt(float(MECHANISM.inertia(q) + FLYWHEEL) / (2 * (self.energy - float(MECHANISM.potential(q)))))

        return 2 * (lasting(outside, START, height_angle(EDGE)) + quad(inside, 0.0, 0.5 * math.pi, epsabs=0.0, epsrel=1e-12)[0])

    def judge(self, run: pp.Run) -> Outcome:
        """Through it: energy and time. Thrown back: after that time where it was, as fast, and all work given back."""
        if self.deepest() is None:
            edges = [height_angle(EDGE), 2 * math.pi - height_angle(EDGE)]
            return MECHANISM.free_run(FLYWHEEL, 5 * CLOSE, self.potential, edges)(run)
        off = (
            abs(float(run.crank_angle[-1]) - START),
            abs(float(run.crank_speed[-1]) / SPEED + 1),
            abs(float(run.load_work[-1])) / self.energy,
        )
        return Outcome(largest(*off), 5 * CLOSE)


@cache
def duration(store: Store) -> float:
    return 0.3 if store.deepest() is None else store.back()


def met(name: str, load: Any, store: Store) -> Case:
    """A load met at full speed. Behind an edge an error grows by tens, in a bounce by about four."""

    def scene(method: str) -> pp.Run:
        flywheel = pp.drives.Flywheel(FLYWHEEL)
        return pp.simulate(MECHANISM.press(), duration(store), speed=SPEED, angle=START, flywheel=flywheel, loads=[load], method=method)

    thrown = store.deepest() is not None
    return Case(
        "Impacts and pulses: runs",
        name,
        f"{'back at its start with its speed reversed, at the time' if thrown else 'kept energy and the time'} by quadrature",
        scene,
        store.judge,
        METHODS,
    )


def pulse(force: float, width: float) -> Case:
    """A force on the slide, in time."""
    begin = 0.05
    load = TimeForce(lambda t: np.where((np.asarray(t) >= begin) & (np.asarray(t) < begin + width), force, 0.0), (begin, begin + width))

    def scene(method: str) -> pp.Run:
        flywheel = pp.drives.Flywheel(FLYWHEEL)
        return pp.simulate(MECHANISM.press(), 0.2, speed=SPEED, angle=2.0, flywheel=flywheel, loads=[load], method=method)

    @cache
    def expected() -> tuple[float, float]:
        def torque(t: float, q: float, w: float) -> float:
            return force * float(MECHANISM.lever(q)) if begin <= t < begin + width else 0.0

        return MECHANISM.integrated(0.2, SPEED, 2.0, FLYWHEEL, torque, (begin, begin + width))

    def judge(run: pp.Run) -> Outcome:
        angle, speed = expected()
        return Outcome(largest(abs(float(run.crank_angle[-1]) - angle), abs(float(run.crank_speed[-1]) - speed) / SPEED), CLOSE)

    return Case(
        "Impacts and pulses: runs",
        f"{force:.0e} N for {width:.0e} s",
        "the closed-form equation of motion, integrated by SciPy from edge to edge",
        scene,
        judge,
        METHODS,
    )


SIX = "zxn2_3000b"


def on(link: str, force: float) -> pp.loads.PointForce:
    return pp.loads.PointForce(link, (0.3 * force, 0.0, force), (0.1, 0.0, 0.05))


def superposed(first: float, second: float) -> Case:
    """Forces on slide and coupler."""

    def scene(engine: str, first: float = first, second: float = second) -> pp.Reactions:
        return spinning(shipped(SIX), engine, ROUND, loads=[on("slide", first), on("coupler", second)])

    def judge(both: pp.Reactions) -> Outcome:
        parts = [(both, 1.0), *((scene(both.engine, a, b), c) for a, b, c in ((first, 0.0, -1.0), (0.0, second, -1.0), (0.0, 0.0, 1.0)))]
        errors = []
        for pick in (lambda one: one.driving_torque, forces, moments):
            columns = [factor * pick(one) for one, factor in parts]
            errors.append(float(np.abs(sum(columns)).max()) / max(float(np.abs(column).max()) for column in columns))
        return Outcome(largest(*errors), 1e-14)

    return Case(
        "Forces of 1 N and 1 GN",
        f"{first:.0e} N on the slide and {second:.0e} N on the coupler of {SIX}",
        "superposition, relative to the largest (1e-14)",
        scene,
        judge,
    )


def forces(one: pp.Reactions) -> Any:
    return np.array([one.bearing_force[name] for name in one.bearing_force])


def moments(one: pp.Reactions) -> Any:
    return np.array([one.bearing_moment[name] for name in one.bearing_moment])


def by_virtual_work(force: float) -> Case:
    def scene(engine: str) -> pp.Reactions:
        return spinning(MECHANISM.press(), engine, ROUND, loads=[pp.loads.PointForce("slide", (0.0, 0.0, force))])

    def judge(result: pp.Reactions) -> Outcome:
        q, w, a = result.motion.crank_angle, result.motion.crank_speed, result.motion.crank_acceleration
        on_slide = MECHANISM.slide_force(q, w, a) - force
        torque = MECHANISM.torque(q, w, a) - force * MECHANISM.lever(q)
        return Outcome(worst([(result.driving_torque, torque), (result.bearing_force["W"][:, 2], on_slide)]), 1e-13)

    return Case(
        "Forces of 1 N and 1 GN",
        f"{force:.0e} N on the slide of a crank-slider",
        "closed form: virtual work, balance of the slide (1e-13)",
        scene,
        judge,
    )


DIES: list[Callable[[], Case]] = [
    *(
        lambda k=k: met(f"die of {k:.0e} N/m met at 1 m/s", ElasticDie(EDGE, k), Store(0.5 * k, 2))
        for k in (1e6, 1e8, 1e10, 1e11, 1e12, 1e13)
    ),
    *(lambda f=f: met(f"pile of {f:.0e} N met at 1 m/s", ConstantForce(f, EDGE), Store(f, 1)) for f in (1.0, 1e6, 1e9)),
]

CASES = [
    *(superposed(*pair) for pair in ((1.0, 1.0), (1.0, 1e9), (1e9, 1e9))),
    *(by_virtual_work(force) for force in (1.0, 1e9)),
    *(make() for make in DIES),
    *(pulse(force, width) for force, width in ((1e6, 1e-6), (1e9, 1e-6), (1e9, 1e-9))),
]
