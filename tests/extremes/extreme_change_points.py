"""Cases where a linkage comes near to a place where its driver does not determine it, is there, or goes through."""

import math
from typing import Any

import numpy as np
from extremes.extreme_case import CLOSE, EPS, METHODS, ROUNDING, Case, Outcome, loaded, refusal
from extremes.extreme_crank_slide import CrankSlider, spinning
from scipy.optimize import brentq
from support.generators.random_linkages import four_bar

import pinpress as pp
from pinpress.loads.process import Blanking

QUARTER = 0.5 * math.pi
ORDINARY = CrankSlider()
FLYWHEEL = pp.drives.Flywheel(50.0)
SAME = 2e-14  # lengths that differ by less, some ten roundings with all that is added to them, count as equal


def rod_for(one_less: float) -> float:
    """Length of the rod for a crank of 0.1 m shorter than it by that share."""
    return 0.1 / (1 - one_less)


def beside(one_less: float) -> Any:
    """Crank angles all round, and about 90 and 270 degrees, where within an angle of sqrt(2 (1 - lambda)) the slide stops."""
    near = math.sqrt(2 * one_less) * np.array([-3.0, -1.0, -0.5, 0.0, 0.5, 1.0, 3.0])
    return np.concatenate([np.linspace(0.0, 2 * math.pi, 25), QUARTER + near, 3 * QUARTER + near])


# ------------------------------------------------------------------------------------------------- the crank nearly as long as the rod


def nearly(power: int) -> Case:
    """Torque and motion at lambda = 1 - 10^-power."""
    one_less = 10.0**-power
    near = CrankSlider(rod=rod_for(one_less))
    # At 90 degrees the slide's lever is the root of a difference of squares: what is lost there, no way of calculating regains.
    bound = ROUNDING + 10 * EPS / one_less
    judge = near.judge(bound)
    expected = "closed form within its conditioning, 10 eps / (1 - lambda)"
    if power > 12:

        def judge_or_refuse(found: Any) -> Outcome:
            refused = isinstance(found, pp.PinpressError)
            return refusal(pp.SingularityError, [QUARTER, 3 * QUARTER], 1e-5)(found) if refused else near.judge(bound)(found)

        judge, expected = judge_or_refuse, expected + ", or refused at 90 deg (the margin there is below 1e-6)"
    return Case(
        "Crank nearly as long as the rod",
        f"lambda = 1 - 1e-{power}, all round and beside 90 deg",
        expected,
        lambda engine: spinning(near.press(), engine, beside(one_less)),
        judge,
        refused=power > 12,
    )


def crossing(name: str, one_less: float, speed: float, duration: float, flywheel: float = 50.0, long: bool = False) -> Case:
    """A free run over change points, or close to them."""
    same = one_less < SAME  # the rod is as long as the crank but for some roundings
    mechanism = CrankSlider(rod=rod_for(one_less))
    near = math.sqrt(2 * one_less)
    corners = [place + share * near for place in (QUARTER, 3 * QUARTER) for share in (-100, -10, -3, 0, 3, 10, 100)] if one_less else []

    def scene(method: str) -> pp.Run:
        return pp.simulate(mechanism.press(), duration, speed=speed, flywheel=pp.drives.Flywheel(flywheel), method=method)

    told_apart = same or one_less > 5e-12
    judged = (CrankSlider(rod=0.1) if same else mechanism).free_run(flywheel, at=[] if same else corners)

    def judge(found: Any) -> Outcome:
        refused = refusal(pp.SimulationError, [QUARTER, 3 * QUARTER], 1e-5)
        return refused(found) if isinstance(found, pp.PinpressError) else judged(found)

    expected = "kept energy and the time by quadrature" + (", the slide going on as -2 r cos q" if same else "")
    return Case(
        "Through change points and close by them: runs",
        name,
        expected + ("" if told_apart else ", or refused at 90 deg (there the rod turns a million times as fast as the crank)"),
        scene,
        judge,
        METHODS,
        refused=not told_apart,
        long=long,
    )


EXACT = CrankSlider(rod=0.1)


def exactly(name: str, angles: dict[str, Any], expected: float) -> Case:
    """`cycle` over a change point."""
    return Case(
        "Crank nearly as long as the rod",
        name,
        f"SingularityError at {math.degrees(expected):.0f} deg (1e-5 rad)",
        lambda engine: pp.cycle(EXACT.press(), engine=engine, **angles),
        refusal(pp.SingularityError, [expected], 1e-5),
        refused=True,
    )


def up_to_it(share: float) -> Case:
    """With lambda = 1 the slide stands at -2 r cos q, as long as no change point is passed."""
    angles = np.linspace(-share, share, 25) * QUARTER
    return Case(
        "Crank nearly as long as the rod",
        f"lambda = 1, up to {90 * share:.10g} deg",
        "closed form, -2 r cos q and its torque, within its conditioning, 10 eps / cos^3 q",
        lambda engine: spinning(EXACT.press(), engine, angles),
        # a rod longer by eps changes the slide's lever by eps / cos^2 q of itself, and the lever's slope by one cos q more
        EXACT.judge(ROUNDING + 10 * EPS / math.cos(share * QUARTER) ** 3),
    )


# -------------------------------------------------------------------------------------------------------- where there is no answer

NONE = "Where mathematics has no answer"
LOCKING = (1.0, 0.8, 0.3, 0.7, 0.9)  # ground, crank, coupler, rocker, drawn angle: at its locks coupler and rocker are in one line
LOCKS = math.acos((1.0 + 0.64 - 1.0) / 1.6) - 0.9, math.acos((1.0 + 0.64 - 0.16) / 1.6) - 0.9
SHORT = CrankSlider(rod=0.09)
BLANK = {"speed": 5.0, "angle": 3.0, "flywheel": pp.drives.Flywheel(5.0)}


def through_locks() -> Case:
    """The crank swings between its locks, while the rod turns: driven there, the same press has none."""
    driven = "P"

    def scene(method: str) -> pp.Run:
        return pp.simulate(SHORT.press(), 0.6, speed=30.0, method=method, points=61)

    def judge(found: Any) -> Outcome:
        press = SHORT.press()
        by_rod = pp.load(press.file, driver=driven)
        speed = float(pp.servo_cycle(press, angle=[0.0], speed=30.0).v[0, press.joints.index(driven)])
        expected = pp.simulate(by_rod, 0.6, speed=speed, points=61)
        return Outcome(float(np.abs(found.joint_position - expected.joint_position).max()), CLOSE)

    return Case(
        "Through change points and close by them: runs",
        "crank longer than rod, through its locks and back",
        "the run of the same press driven at its rod, which turns fully, by `reduced`",
        scene,
        judge,
        ("constraint",),
    )


def four() -> pp.Linkage:
    return loaded(four_bar(*LOCKING).urdf("O"))


def stalls(found: Any) -> Outcome:
    """Where the kinetic energy is used up: two thirds of 1 MN's half sine over 30 mm are more than it."""
    energy = 0.5 * (float(ORDINARY.inertia(3.0)) + 5.0) * 25.0 + float(ORDINARY.potential(3.0))

    def left(q: float) -> float:
        into = min(max(0.05 - (float(ORDINARY.slide(q)) + 0.5), 0.0), 0.03)
        return energy - float(ORDINARY.potential(q)) - 2e6 / math.pi * 0.03 * (1 - math.cos(0.5 * math.pi * into / 0.03))

    begin = float(brentq(lambda q: float(ORDINARY.slide(q)) + 0.5 - 0.05, 3.3, 6.2, xtol=1e-15))
    return refusal(pp.SimulationError, [float(brentq(left, begin, 6.2, xtol=1e-15))], 1e-7)(found)


def whole_turn(name: str, linkage: Any, angles: list[float], given: dict[str, Any]) -> Case:
    return Case(
        NONE,
        name,
        "SingularityError at the lock (1e-6 rad)",
        lambda engine: (pp.servo_cycle if "angle" in given else pp.cycle)(linkage(), speed=7.0, engine=engine, **given),
        refusal(pp.SingularityError, angles, 1e-6),
        refused=True,
    )


def run_into(name: str, linkage: Any, angle: float, speed: float) -> Case:
    return Case(
        NONE,
        name,
        "SimulationError at the lock (1e-3 rad)",
        lambda method: pp.simulate(linkage(), 2.0, speed=speed, flywheel=pp.drives.Flywheel(5.0), method=method),
        refusal(pp.SimulationError, [math.copysign(angle, speed)], 1e-3),
        ("reduced",),
        refused=True,
    )


def drawn_there(name: str, text: Any) -> Case:
    return Case(
        NONE,
        name,
        "SingularityError at 0 deg, by `load`",
        lambda _: loaded(text()),
        refusal(pp.SingularityError, [0.0], 0.0),
        ("either",),
        refused=True,
    )


CASES = [
    *(nearly(power) for power in (2, 4, 6, 8, 10, 12, 13, 14)),
    up_to_it(0.99),
    up_to_it(0.9999),
    exactly("lambda = 1, a turn of 360 points", {"speed": 7.0, "points": 360}, QUARTER),
    exactly("lambda = 1, a turn of 7 points, none near 90 deg", {"speed": 7.0, "points": 7}, QUARTER),
    exactly("lambda = 1, backwards", {"speed": -7.0, "points": 90}, -QUARTER),
    crossing("lambda = 1, 3 turns at 8 rad/s", 0.0, 8.0, 2.4),
    crossing("lambda = 1, backwards", 0.0, -8.0, 0.8),
    crossing("lambda = 1, no flywheel", 0.0, 60.0, 0.2, flywheel=0.0),
    crossing("lambda = 1, 100 turns", 0.0, 20.0, 31.0, long=True),
    *(crossing(f"lambda = 1 - 1e-{power}, a turn", 10.0**-power, 8.0, 0.8) for power in (2, 4, 6, 8, 10, 12, 13, 14)),
    through_locks(),
    whole_turn("a four-bar that locks, a turn", four, [LOCKS[0]], {"points": 90}),
    whole_turn("the same, backwards from 0 to 1.01 times the lock", four, [LOCKS[1]], {"angle": np.array([0.0, 1.01 * LOCKS[1]])}),
    whole_turn("crank longer than rod (0.1, 0.09 m)", SHORT.press, [math.asin(0.9)], {"points": 90}),
    run_into("crank longer than rod, a run", SHORT.press, math.asin(0.9), 30.0),
    run_into("the same, backwards", SHORT.press, math.asin(0.9), -30.0),
    run_into("a four-bar that locks, a run", four, LOCKS[0], 3.0),
    Case(
        NONE,
        "1 MN of blanking on 2 kJ: it stalls",
        "SimulationError where the kinetic energy is used up (1e-7 rad)",
        lambda method: pp.simulate(ORDINARY.press(), 1.0, loads=[Blanking(1e6, 0.05, 0.02)], method=method, **BLANK),
        stalls,
        METHODS,
        refused=True,
    ),
    drawn_there("a parallelogram drawn in one line", lambda: four_bar(1.0, 0.3, 1.0, 0.3, 0.0).urdf("O")),
    drawn_there(
        "a four-bar drawn where its rocker cannot push",
        lambda: four_bar(1.0, 0.3, 0.8, 0.7, math.acos((1.21 + 1.0 - 0.49) / 2.2)).urdf("D"),
    ),
]
