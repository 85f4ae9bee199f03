"""Chen 2002: what a designer of this press would draw. Charts over crank and height of the ram, and even speed weighed against forces.

In the charts l6 and l4 are those of the example in shares of l3, and the part worked is 30 % of the stroke, as 120 of 400 mm are. The paper
prints no forces and no process; the process here, a force of 10 kN over the 120 mm, is ours.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np
from validation.rows import FORMULA, Row, Table

from pinpress import Linkage, cycle, inverse_dynamics
from pinpress.common.quantities import Array
from pinpress.derivatives import reshaped
from pinpress.loads import ForceStroke
from pinpress.measures import bearing_positions, pressure_angle, quick_return_ratio, speed_variation, stroke
from pinpress.synthesis import DesignTradeOff, SynthesisResult, Trial, synthesise, trade_off

SPEED = 7.54  # speed of the crank [rad/s]
STROKE, RATIO, DRAWN = 0.400, 1.5, 0.120  # stroke [m], time ratio and length drawn [m] of the example
HALF = math.pi / 2 * (RATIO - 1) / (RATIO + 1)  # half of the angle between the bar's ends, (11)
BAR = STROKE / (2 * math.sin(HALF))  # l3 by (21) [m]
PRINTED = {"l1": 0.108, "l4": 0.220, "h": 0.630}  # [m]
PRINTED_BAR, PIVOTS = 0.648, 0.350  # l3 and l6 of the example [m]
AXIS = (1.0, 0.0, 0.0)  # axis of the ram's guide
STEEPEST = math.radians(40)  # largest pressure angle that the paper allows

# -------------------------------------------------------------------------------------------------------------------------------- charts

CRANKS, HEIGHTS = np.linspace(0.08, 0.28, 11), np.linspace(0.88, 1.08, 11)  # l1 / l3 and h / l3
CHARTED = 90  # states of a turn


@cache
def charted(press: Linkage, crank: float, height: float) -> tuple[float, float, float, float]:
    """Time ratio, stroke by l3, largest pressure angle [deg] and drop of speed [%] over 30 % of the stroke.

    Args:
        press: the press of the example.
        crank: l1 / l3.
        height: h / l3.
    """
    changed = reshaped(press, {("B", "crank"): (crank * PRINTED_BAR, 0, 0), ("slide_guide", "frame"): (0, 0, height * PRINTED_BAR)})
    motion = cycle(changed, SPEED, points=CHARTED)
    at, way = bearing_positions(changed, motion), stroke(motion)
    steepest = math.degrees(pressure_angle(motion, at["E"], at["D"], AXIS))
    return quick_return_ratio(motion), way / PRINTED_BAR, steepest, 100 * speed_variation(motion, DRAWN / STROKE * way)


def steepest(crank: Any, height: Any) -> Any:
    """Largest pressure angle [deg], as `charted`, by (18) at both ends of the height of the bar's end: l3 and l3 cos(theta / 2)."""
    ends = np.maximum(np.abs(height - 1), np.abs(height - np.sqrt(1 - (crank * PRINTED_BAR / PIVOTS) ** 2)))
    return np.degrees(np.arcsin(ends * PRINTED_BAR / PRINTED["l4"]))


def chart_rows(press: Callable[[], Linkage]) -> Iterator[Row]:
    """Two points of the charts; their time ratio, stroke and pressure angle by formulas."""
    for i, j in ((1, 2), (6, 8)):
        place = float(CRANKS[i]), float(HEIGHTS[j])
        half, where = math.asin(place[0] * PRINTED_BAR / PIVOTS), f"l1 / l3 = {place[0]:g}, h / l3 = {place[1]:g}"

        def ours(k: int, place: tuple[float, float] = place) -> Callable[[], float]:
            return lambda: charted(press(), *place)[k]

        yield Row(f"{where}: time ratio K", f"{(math.pi + 2 * half) / (math.pi - 2 * half):.6f}", ours(0), 1e-4, FORMULA)
        yield Row(f"{where}: stroke / l3", f"{2 * math.sin(half):.6f}", ours(1), 1e-4, FORMULA)
        yield Row(f"{where}: largest pressure angle [deg]", f"{steepest(*place):.5f}", ours(2), 1e-3, FORMULA)
        yield Row(f"{where}: drop of speed over 30 % of the stroke [%]", "", ours(3), places=2)


def evenest(press: Linkage) -> Table:
    """For three cranks the height with the evenest speed."""
    rows = []
    for i in (1, 4, 8):
        crank = float(CRANKS[i])
        values = [charted(press, crank, float(height)) for height in HEIGHTS]
        j = min(range(len(HEIGHTS)), key=lambda k: values[k][3])
        rows.append((f"{crank:g}", f"{values[j][3]:.2f}", f"{HEIGHTS[j]:.2f}", f"{values[j][2]:.1f}"))
    return Table(("l1 / l3", "least drop of speed in the chart [%]", "at h / l3", "pressure angle there [deg]"), tuple(rows))


# ------------------------------------------------------------------------------------------------------------ even speed against forces

FORCE = 10e3  # of the process [N]
PROCESS = ForceStroke(heights=[-0.075, -0.055, 0.065, 0.085], forces=[0.0, FORCE, FORCE, 0.0], datum=0.2193)  # about the ram's middle
VARIABLES = {"l1": (0.080, 0.108, 0.160), "l4": (0.080, 0.220, 0.600), "h": (0.600, 0.630, 0.700)}  # bounds are ours
STATES, JUDGED = 60, 720  # states of a turn in searches, and in what is shown of their results
DESIGNS = 4


def with_middle_kept(l1: Any, l4: Any, h: Any) -> Mapping[tuple[str, str], Any]:
    """All lengths for the paper's stroke and time ratio [m]; the frame's pins are moved along the guide so that the ram works where it did,
    and the process with it."""
    middle = np.sqrt(l4**2 - (h - BAR) ** 2)
    aside = math.sqrt(PRINTED["l4"] ** 2 - (PRINTED["h"] - PRINTED_BAR) ** 2) - middle
    return {
        ("A", "frame"): (aside, 0, l1 / math.sin(HALF)),
        ("C", "frame"): (aside, 0, 0),
        ("B", "crank"): (l1, 0, 0),
        ("D", "bar"): (BAR, 0, 0),
        ("E", "coupler"): (l4, 0, 0),
        ("slide_guide", "frame"): (0, 0, h),
    }


def drop(trial: Trial) -> float:
    """Drop of speed over 120 mm [-]."""
    return speed_variation(trial.motion, DRAWN)


def pins(trial: Trial) -> Array:
    """Forces in the crank's pin and in the bar's end, the largest of all pins [N]."""
    forces = trial.reactions.bearing_force
    return np.concatenate([_size(forces["B"]), _size(forces["D"])])


def guide(trial: Trial) -> Array:
    """Side force on the ram's guide [N]."""
    return _size(trial.reactions.bearing_force["slide_guide"])


def _size(force: Array) -> Array:
    return np.asarray(np.sqrt((force * force).sum(axis=1)))


def weighed_table(press: Linkage) -> Table:
    """Trade-offs between even speed and forces, and the design that weighs all of them equally."""
    rows = [_cells("the example", PRINTED, worth(press))]
    for force, words in ((pins, "force in the pins"), (guide, "side force on the guide")):
        for k, design in enumerate(front(press, force).designs, 1):
            rows.append(_cells(f"even speed against {words}, {k}", design.variables, worth(design.press)))
    best = weighed(press)
    rows.append(_cells("all four weighed equally", best.variables, worth(best.press)))
    heads = ("design", "l1 [mm]", "l4 [mm]", "h [mm]", "drop of speed [%]", "torque [N m]", "pins [kN]", "guide [kN]")
    return Table(heads, tuple(rows))


def _cells(words: str, lengths: Mapping[str, float], values: tuple[float, float, float, float]) -> tuple[str, ...]:
    even, torque, largest, side = values
    return words, *(f"{1e3 * lengths[name]:.1f}" for name in VARIABLES), f"{even:.2f}", f"{torque:.0f}", f"{largest:.2f}", f"{side:.2f}"


def worth(press: Linkage) -> tuple[float, float, float, float]:
    """Drop of speed over 120 mm [%], largest driving torque [N m], largest force in a pin and side force on the guide [kN]."""
    motion = cycle(press, SPEED, points=JUDGED)
    reactions = inverse_dynamics(press, motion, loads=[PROCESS])
    sizes = {name: float(np.linalg.norm(force, axis=1).max()) / 1e3 for name, force in reactions.bearing_force.items()}
    largest = max(sizes[pin] for pin in ("A", "B", "C", "D", "E"))
    return 100 * speed_variation(motion, DRAWN), float(reactions.driving_torque.max()), largest, sizes["slide_guide"]


def weighed(press: Linkage) -> SynthesisResult:
    """The least sum of drop of speed, torque, force in the pins and side force, each by that of the example.

    A largest value has corners. So three more variables stand above torque and forces, and their sum is minimised.
    """
    even, *loads = worth(press)
    forces = {"torque": (_torque, loads[0]), "pins": (pins, 1e3 * loads[1]), "guide": (guide, 1e3 * loads[2])}

    def below(name: str) -> Any:
        function, unit = forces[name]
        return lambda trial: function(trial) / unit - trial.variables[name]

    return synthesise(
        press,
        VARIABLES | dict.fromkeys(forces, (0.1, 1.2, 6.0)),
        minimise=lambda trial: 100 * drop(trial) / even + sum(trial.variables[name] for name in forces),
        subject_to=_steep() | {name: (below(name), None, 0.0) for name in forces},
        geometry=lambda l1, l4, h, **_: with_middle_kept(l1, l4, h),
        speed=SPEED,
        points=STATES,
        loads=[PROCESS],
    )


def _torque(trial: Trial) -> Array:
    return trial.reactions.driving_torque


def front(press: Linkage, second: Any) -> DesignTradeOff:
    """Even speed against a force, with a pressure angle of up to 40 deg."""
    return trade_off(
        press,
        VARIABLES,
        first=drop,
        second=second,
        subject_to=_steep(),
        geometry=with_middle_kept,
        speed=SPEED,
        points=STATES,
        loads=[PROCESS],
        designs=DESIGNS,
    )


def _steep() -> dict[str, tuple[Any, None, float]]:
    return {
        "pressure angle": (lambda trial: pressure_angle(trial.motion, trial.positions["E"], trial.positions["D"], AXIS), None, STEEPEST)
    }
