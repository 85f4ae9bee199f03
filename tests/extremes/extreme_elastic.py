"""Cases of presses on springs: stiffnesses from 1e7 to 1e13 N/m, damping ratios from 0 to 2, blanking and idle."""

import math
import re
from functools import cache
from typing import Any

import numpy as np
from extremes.extreme_case import Case, Outcome
from support.texts import shipped

import pinpress as pp

GROUP = "Presses on springs: JF75G-125 at 300 r/min"
SPEED = 300 * pp.RPM
FORCE, START, END = 1.25e6, 0.010, 0.005
WORK = 2 * FORCE * (START - END) / math.pi  # of the quarter sine, on whatever way the slide comes
USUAL = 2e9, 0.02  # stiffness [N/m] and damping ratio
SOFT = 3e8  # stiffness below which the blank would let the links fall apart [N/m]
ENERGY = 1e-9


def elastic(stiffness: float, ratio: float) -> pp.elasticity.Elastic:
    press = shipped("jf75g_125_plain")
    across = dict.fromkeys(press.bearings, stiffness)
    return pp.elasticity.Elastic(pp.elasticity.Stiffness(across, moments={"slide_guide": 0.1 * stiffness}), damping_ratio=ratio)


def blanking(stiffness: float, ratio: float) -> Any:
    press = shipped("jf75g_125_plain")
    drive, loads = pp.drives.PrescribedSpeed(SPEED), [pp.loads.Blanking(FORCE, START, END)]
    top = pp.dead_centres(press).top_angle
    return pp.simulate(press, math.pi / SPEED, angle=top, drive=drive, loads=loads, elastic=elastic(stiffness, ratio), points=2)


def idle(stiffness: float, ratio: float) -> Any:
    press = shipped("jf75g_125_plain")
    return pp.steady_state(press, SPEED, drive=pp.drives.PrescribedSpeed(SPEED), elastic=elastic(stiffness, ratio), points=37)


def cuts(found: Any) -> Outcome:
    """The load takes the work of its force over its way, and the energies balance."""
    return Outcome(max(abs(found.load_work[-1] / WORK - 1), found.stats.energy_error), ENERGY)


def too_soft(found: Any) -> Outcome:
    said = isinstance(found, pp.PinpressError) and re.search("are too soft", str(found))
    return Outcome(0.0 if said else math.inf, 0.0, "refused: too soft" if said else "")


@cache
def rigid() -> tuple[pp.Reactions, float]:
    press = shipped("jf75g_125_plain")
    found = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=36))
    return found, max(float(np.linalg.norm(force, axis=1).max()) for force in found.bearing_force.values())


def nears(stiffness: float) -> Any:
    """The forces come to those of the rigid press as the square of crank speed by lowest vibration."""
    press = shipped("jf75g_125_plain")
    bottom = pp.dead_centres(press).bottom_angle
    lowest = float(pp.elasticity.natural_frequencies(press, elastic(stiffness, 0.02), angle=[bottom]).natural_frequency[0, 0])

    def judged(found: Any) -> Outcome:
        forces, peak = rigid()
        off = [np.linalg.norm(found.bearing_force[name][:-1] - force, axis=1).max() for name, force in forces.bearing_force.items()]
        return Outcome(max(float(max(off)) / peak, found.stats.energy_error), (SPEED / lowest) ** 2 + 1e-9)

    return judged


def _blanking(stiffness: float, ratio: float) -> Case:
    soft = stiffness < SOFT
    return Case(
        GROUP,
        f"blanking with {FORCE / 1e6:g} MN, {stiffness:.0e} N/m, damping ratio {ratio:g}",
        "refused, as the links would fall apart" if soft else "work 2 F (start - end) / pi, energy balance",
        lambda way: blanking(stiffness, ratio),
        too_soft if soft else cuts,
        ways=("elastic",),
        refused=soft,
    )


def _idle(stiffness: float, ratio: float) -> Case:
    return Case(
        GROUP,
        f"steady stroke without load, {stiffness:.0e} N/m, damping ratio {ratio:g}",
        "forces of the rigid press, to (crank speed / lowest vibration)^2",
        lambda way: idle(stiffness, ratio),
        lambda found: nears(stiffness)(found),
        ways=("elastic",),
    )


CASES = [
    *(_blanking(stiffness, 0.02) for stiffness in (1e7, 1e8, 1e9, 1e11, 1e13)),
    *(_blanking(2e9, ratio) for ratio in (0.0, 0.2, 2.0)),
    *(_idle(stiffness, 0.02) for stiffness in (1e8, 1e10, 1e12, 1e13)),
    *(_idle(2e9, ratio) for ratio in (0.0, 2.0)),
]
