"""The equation of motion of the six-bar press ZXN2-3000(B) in closed form, as an expert writes it, by SciPy's integrators.

    (I + J) w' + I' w^2 / 2 + V' = torque + F y'

SciPy integrates this equation, with reduced inertia I, potential energy V and slide position y by the crank angle, worked out from the
triangles of `six_bar_script` in plain numbers, which for one state are ten times as fast as NumPy. Loads begin and end at crank angles that
are known beforehand, so that every smooth part is integrated for itself, up to the event that ends it; so are a slipping and a gripped
clutch.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from benchmarks.peers.peer import Peer, RunEnd
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support.oracles.six_bar_script import (
    AX,
    AY,
    COS,
    CRANK,
    GRAVITY,
    J2,
    J3,
    L1,
    L2,
    L4,
    L31,
    L32,
    M2,
    M3,
    M5,
    P2,
    P3,
    Q3,
    ROD,
    SIN,
    six_bar,
    world_forces,
)

from pinpress.accuracy.scenes import SPEED_LAW, Scene
from pinpress.common.errors import SimulationError
from pinpress.common.quantities import Array
from pinpress.loads.process import ProcessLoad

BOTH, EXPLICIT = (1e-4, 1e-6, 1e-8, 1e-10), (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
INTEGRATORS = {"DOP853": EXPLICIT, "LSODA": EXPLICIT, "Radau": BOTH}  # tolerances worth measuring
SAMPLES = 721  # crank angles between which a load's edges are sought
Push = tuple[Callable[[Any, Any], Any], float]  # a load's law by height and velocity, and where heights begin
BEHIND = 1e-9  # an edge that the crank has just passed [rad]
UNSTABLE = "its steps are stable only below the time in which the law forgets"


class Reduced(NamedTuple):
    """The press at a crank angle; slopes are derivatives by the crank angle.

    Attributes:
        inertia: reduced inertia [kg m2].
        inertia_slope: its slope [kg m2/rad].
        weight: slope of the potential energy [N m].
        slide: slide position [m].
        lever: slope of the slide position [m].
    """

    inertia: float
    inertia_slope: float
    weight: float
    slide: float
    lever: float


def reduced(angle: float, balanced: bool) -> Reduced:
    """The press at a crank angle [rad], worked out at a crank speed of 1 rad/s."""
    m1, p1, j1 = CRANK[balanced]
    m4, p4, j4 = ROD[balanced]
    b1x, b1y = L1 * math.cos(angle), L1 * math.sin(angle)
    bx, by = AX + b1x, AY + b1y
    square = bx * bx + by * by
    along = 0.5 * (L31 * L31 - L2 * L2 + square) / square
    beside = math.sqrt(L31 * L31 / square - along * along)
    b3x, b3y = along * bx - beside * by, along * by + beside * bx
    e3x, e3y = L32 / L31 * (COS * b3x + SIN * b3y), L32 / L31 * (COS * b3y - SIN * b3x)
    b4x, b4y = -e3x, -math.sqrt(L4 * L4 - e3x * e3x)
    b2x, b2y = b3x - bx, b3y - by
    across = b2x * b3y - b2y * b3x
    w2, w3 = (b1y * b3x - b1x * b3y) / across, (b1y * b2x - b1x * b2y) / across
    w4 = -w3 * e3y / b4y
    right_x, right_y = b1x + w2 * w2 * b2x - w3 * w3 * b3x, b1y + w2 * w2 * b2y - w3 * w3 * b3y
    a2, a3 = (right_x * b3x + right_y * b3y) / across, (right_x * b2x + right_y * b2y) / across
    a4 = -(a3 * e3y + w3 * w3 * e3x + w4 * w4 * b4x) / b4y
    lever, bend = w3 * e3x + w4 * b4x, a3 * e3x - w3 * w3 * e3y + a4 * b4x - w4 * w4 * b4y
    f1, f2, f4 = p1 / L1, P2 / L2, p4 / L4
    g3x, g3y = (P3 * b3x - Q3 * b3y) / L31, (P3 * b3y + Q3 * b3x) / L31
    v2x, v2y = -b1y - f2 * w2 * b2y, b1x + f2 * w2 * b2x
    c2x, c2y = -b1x - f2 * (a2 * b2y + w2 * w2 * b2x), -b1y + f2 * (a2 * b2x - w2 * w2 * b2y)
    v4x, v4y = -w3 * e3y - f4 * w4 * b4y, w3 * e3x + f4 * w4 * b4x
    c4x = -a3 * e3y - w3 * w3 * e3x - f4 * (a4 * b4y + w4 * w4 * b4x)
    c4y = a3 * e3x - w3 * w3 * e3y + f4 * (a4 * b4x - w4 * w4 * b4y)
    j3 = J3 + M3 * (g3x * g3x + g3y * g3y)
    inertia = (
        j1
        + m1 * p1 * p1
        + J2 * w2 * w2
        + M2 * (v2x * v2x + v2y * v2y)
        + j3 * w3 * w3
        + j4 * w4 * w4
        + m4 * (v4x * v4x + v4y * v4y)
        + M5 * lever * lever
    )
    slope = J2 * w2 * a2 + M2 * (v2x * c2x + v2y * c2y) + j3 * w3 * a3 + j4 * w4 * a4 + m4 * (v4x * c4x + v4y * c4y) + M5 * lever * bend
    weight = GRAVITY * (m1 * f1 * b1x + M2 * v2y + M3 * w3 * g3x + m4 * v4y + M5 * lever)
    return Reduced(inertia, 2 * slope, weight, e3y + b4y, lever)


class SixBarEquation(Peer):
    """An integrator of SciPy on the closed form of the press, as an expert writes it for this one press."""

    inverse = False

    def __init__(self, integrator: str, balanced: bool) -> None:
        """Take one of `INTEGRATORS` for the press with its counterweights or without."""
        self.name, self.tolerances = f"SciPy {integrator}, closed form", INTEGRATORS[integrator]
        self.left_out = {SPEED_LAW: UNSTABLE} if integrator == "DOP853" else {}
        self.integrator, self.balanced = integrator, balanced

    def prepared(self, scene: Scene) -> Callable[[float], RunEnd]:
        """See `Peer`.

        The edges of the loads are found beforehand. The crank turns in the positive direction only, and the clutch holds after it has
        gripped.
        """
        at = partial(reduced, balanced=self.balanced)
        return partial(self._run, scene, at, *_edges(scene.loads, at))

    def _run(
        self, scene: Scene, at: Callable[[float], Reduced], edges: Array, acting: Callable[[float], tuple[Push, ...]], tolerance: float
    ) -> RunEnd:
        """Run to the end of a scene. Raises SimulationError where the integrator gives up or the crank turns back."""
        slips = scene.clutch is not None
        time, evaluations = 0.0, 0
        own = scene.speed if scene.flywheel.speed is None else scene.flywheel.speed
        y = np.array([scene.angle, scene.speed, *([own] if slips else [])])
        gripped = partial(_crosses, 0.0)
        gripped.terminal = True  # type: ignore[attr-defined]
        while time < scene.duration:
            ahead = float(np.min((edges - y[0] - BEHIND) % (2 * math.pi), initial=math.inf)) + BEHIND
            pushes = acting(y[0] + 0.5 * ahead) if len(edges) else ()
            rates = partial(_slipping if slips else _turning, scene, at, pushes)
            reaches = partial(_reaches, float(y[0]) + ahead)
            reaches.terminal = True  # type: ignore[attr-defined]
            events = ([gripped] if slips else []) + ([reaches] if len(edges) else [])
            rise = scene.clutch.rise if scene.clutch is not None else 0.0
            until = rise if slips and time < rise else scene.duration
            found = solve_ivp(rates, (time, until), y, self.integrator, rtol=tolerance, atol=tolerance, events=events)
            evaluations += found.nfev
            time, y = float(found.t[-1]), found.y[:, -1]
            if not found.success or not np.isfinite(y).all() or y[1] < 0:
                raise SimulationError(f"{self.name} finds no end of the run: {found.message}", time, float(y[0]))
            if slips and len(found.t_events[0]):
                slips, y = False, y[:2]
        state = at(float(y[0]))
        acceleration = _acceleration(scene, state, (), float(y[1]))
        forces = world_forces(six_bar(y[0], y[1], acceleration, self.balanced))
        return RunEnd(float(y[0]), float(y[1]), None, None, {name: force[0] for name, force in forces.items()}, evaluations)


def _edges(loads: Sequence[ProcessLoad], at: Callable[[float], Reduced]) -> tuple[Array, Callable[[float], tuple[Push, ...]]]:
    """Crank angles (n,) from 0 to 2 pi at which a load begins or ends, and a function for the loads that act at an angle between them."""
    angles = np.linspace(0.0, 2 * math.pi, SAMPLES).tolist()
    if not loads:
        return np.zeros(0), lambda angle: ()
    heights = [at(angle).slide for angle in angles]
    k = int(np.argmin(heights))
    dead = float(brentq(lambda angle: at(angle).lever, angles[k] - 0.1, angles[k] + 0.1, xtol=1e-15))
    bottom = at(dead).slide
    found = {dead}
    ends = {
        end for load in loads for down in (True, False) for s in load.intervals(down) for end in (s.lower, s.upper) if math.isfinite(end)
    }
    for height in ends:
        for low, high in itertools.pairwise(angles):
            if (at(low).slide - bottom > height) != (at(high).slide - bottom > height):
                found.add(float(brentq(lambda angle, height=height: at(angle).slide - bottom - height, low, high, xtol=1e-15)))

    def acting(angle: float) -> tuple[Push, ...]:
        here = at(angle)
        intervals = (s for load in loads for s in load.intervals(here.lever < 0))
        return tuple((s.force, bottom) for s in intervals if s.lower < here.slide - bottom <= s.upper)

    return np.array(sorted(found)), acting


def _acceleration(scene: Scene, state: Reduced, pushes: tuple[Push, ...], speed: float) -> float:
    """Acceleration of the crank, which turns with flywheel and drive [rad/s2]."""
    torque, inertia = 0.0, state.inertia + float(scene.flywheel.inertia)
    if scene.drive is not None:
        torque, inertia = float(scene.drive.torque(speed)), inertia + float(scene.drive.inertia)
    for force, bottom in pushes:
        torque += state.lever * float(force(state.slide - bottom, state.lever * speed))
    return (torque - state.weight - 0.5 * state.inertia_slope * speed * speed) / inertia


def _turning(scene: Scene, at: Callable[[float], Reduced], pushes: tuple[Push, ...], time: float, y: Any) -> list[float]:
    angle, speed = y.tolist()
    return [speed, _acceleration(scene, at(angle), pushes, speed)]


def _slipping(scene: Scene, at: Callable[[float], Reduced], pushes: tuple[Push, ...], time: float, y: Any) -> list[float]:
    """Rates of crank and flywheel on the two sides of a clutch that slips."""
    angle, speed, own = y.tolist()
    state, clutch = at(angle), scene.clutch
    assert clutch is not None
    assert scene.drive is not None
    through = clutch.torque * (min(1.0, time / clutch.rise) if clutch.rise else 1.0)
    torque = through - state.weight - 0.5 * state.inertia_slope * speed * speed
    for force, bottom in pushes:
        torque += state.lever * float(force(state.slide - bottom, state.lever * speed))
    inertia = float(scene.flywheel.inertia) + float(scene.drive.inertia)
    return [speed, torque / state.inertia, (float(scene.drive.torque(own)) - through) / inertia]


def _crosses(level: float, time: float, y: Any) -> float:
    return float(y[2] - y[1]) - level


def _reaches(edge: float, time: float, y: Any) -> float:
    return float(y[0]) - edge
