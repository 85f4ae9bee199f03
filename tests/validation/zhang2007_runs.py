"""Zhang 2007, chapter 4 and 5.7: the press runs under a constant torque, behind its motor with a slip clutch, and under process loads."""

import dataclasses
import math
from collections.abc import Iterator
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from validation.rows import FORMULA, SOLVER, Row, rows_from
from validation.zhang2007_balancing import (
    AUXILIARY,
    AUXILIARY_CRANK,
    AUXILIARY_ROD,
    COUNTERWEIGHT,
    CRANK,
    GRAVITY,
    RADIUS,
    ROD,
    SLIDE,
    SPEED,
    clean,
    opposed,
    plain,
    symmetric,
    weight,
)

from pinpress import RPM, Linkage, Run, cycle, inverse_dynamics, servo_cycle, simulate, steady_state
from pinpress.common.quantities import Array
from pinpress.drives import ConstantTorque, Flywheel, Geared, SlipClutchMotor
from pinpress.loads import Blanking, ConstantForce, DeepDrawing, Impact, ProcessLoad, TimeForce, TwoSidedStop, step
from pinpress.measures import duty_cycle

FLYWHEEL_INERTIA = 136.0  # [kg m2]
TORQUE = 567.0  # M_d of (4.3.3) [N m]
START = 10 * np.pi  # speed at which its runs begin, at bottom dead centre [rad/s]
STEP = 1e-4  # h of the thesis [s]
PERIODS = 0.6  # three of them [s]
# The same equation, initial values and inferred geometry, integrated without pinpress: angle [rad], speed [rad/s], height above bottom dead
# centre [mm], slide velocity and acceleration upwards
SOLVED = {
    0.2: ("6.348828154529", "32.243343708291", "0.033919326174", "0.033308238886", "16.337381982412"),
    0.4: ("12.863252626586", "33.055508095625", "0.688295013346", "0.151986910463", "16.354749187920"),
    0.6: ("19.542827320549", "33.819423745531", "3.615793850155", "0.336661987484", "13.330787953640"),
}
FIVE, LASTING = 5, 1.0  # strokes of figures 5-13 to 5-15, and how long they last there [s]
EDGED = 20_001  # states of a run under a load as it is printed, whose edges last 0.1 ms
ENOUGH, STATES = 1.2, 6001  # time in which the press makes five strokes under each load [s], and its states
PEAKS = {"piling": "3046.0493", "blanking": "2831.9312", "drawing": "2479.5322"}  # of their vertical forces [N]
NAMES = ("crank angle [rad]", "crank speed [rad/s]", "height [mm]", "slide velocity [m/s]", "slide acceleration [m/s2]")
TOP, PRIMARY, SET = 1320 * RPM, 1470 * RPM, 900 * RPM  # the thesis prints the first; 900 r/min are 300 strokes/min behind its 3 to 1
# Process loads
NOMINAL = 1250e3  # [N]
ALLEGED = 1250.0  # the force in the thesis' load functions, whose unit in ADAMS is the newton [N]
START_HEIGHT, BREAK_HEIGHT = 0.010, 0.005  # slide heights at 0.1616 and 0.1738 s, the window of its text [m]
# Crank speed [rad/s] where the punch meets the sheet in the first stroke and where its force ends, of a solver without pinpress; work W [J]
BLANKING, DRAWING = ("31.9220326706", "31.1117998356"), ("31.9220326706", "30.3740590987")


def motor(set_speed: float = SET) -> SlipClutchMotor:
    """The motor YCT280-4A of table 4-1; its primary speed is ours."""
    return SlipClutchMotor(rated_torque=189.0, primary_speed=PRIMARY, top_speed=TOP, set_speed=set_speed)


def motor_rows() -> Iterator[Row]:
    """Table 4-1, and what the motor does with the press."""

    def steady() -> list[float]:
        wheel, load = Flywheel(FLYWHEEL_INERTIA), Blanking(1250e3, 0.010, 0.005)
        period = steady_state(symmetric(), SPEED, drive=Geared(motor(), 3.0), flywheel=wheel, loads=[load])
        speed = period.crank_speed / RPM
        return [float(60 / period.time[-1]), float(100 * np.ptp(speed) / speed.mean())]

    def loaded_torque() -> float:
        return float(Geared(motor(), 3.0).torque(SET * (1 - motor().regulation) / 3))

    yield Row("torque at the crank, 2.5 % below the set speed (4.3.3) [N m]", "567", loaded_torque, 1e-6, "3 x 189", 1)
    yield Row("power at 189 N m and 1320 r/min [kW]", "30", lambda: 189 * TOP / 1e3, places=1)
    yield Row("power at 189 N m and 1470 r/min, slip included [kW]", "30", lambda: 189 * PRIMARY / 1e3, places=1)
    yield from rows_from(
        steady,
        ("blanking 5 mm with 1250 kN, set to 300 strokes/min: strokes/min held", "", None, "", 2),
        ("its speed variation within a stroke [%]", "", None, "", 2),
    )
    yield Row("GD2 of the flywheel, 4 g J0 [N m2]", "", lambda: 4 * GRAVITY * FLYWHEEL_INERTIA, places=1)
    yield Row("4 g 30 / pi, the constant of (4.3.2)", "375", lambda: 4 * GRAVITY / RPM, places=1)
    for strokes in (150, 300, 440):
        words = f"a quarter of this load, set to {strokes} strokes/min"
        yield from rows_from(
            lambda strokes=strokes: slip(strokes),
            (f"{words}: lost by slip in a stroke [J]", "", None, "", 0),
            (f"{words}: share of the motor's work that reaches the crank [%]", "", None, "", 1),
        )


def slip(strokes: float) -> tuple[float, float]:
    """What the clutch loses [J], and the share of the motor's work that reaches the crank [%]; 440 strokes/min are at its top speed."""
    drive, wheel, load = Geared(motor(3 * strokes * RPM), 3.0), Flywheel(FLYWHEEL_INERTIA), Blanking(NOMINAL / 4, 0.010, 0.005)
    duty = duty_cycle(steady_state(symmetric(), strokes * RPM, drive=drive, flywheel=wheel, loads=[load]))
    assert duty.slip_loss is not None
    assert duty.efficiency is not None
    return duty.slip_loss, 100 * duty.efficiency


def control_rows() -> Iterator[Row]:
    """4.3 on the control: what there is without feedback, and where control is lost with too little of it."""
    current = ((1470 - 900) / (1470 - 1320)) ** -0.25  # by (4.3.1) the current with which the rated torque is held at 900 r/min
    drop = 0.025 * 900
    error = drop * ((1470 - 900 + drop) / 150) ** 0.25  # below the set speed, at which the current is full [r/min]
    light = 0.2 * 189.0

    def closed_loop() -> float:
        from scipy.optimize import brentq  # slow to import

        return float(brentq(lambda speed: float(motor().torque(speed)) - light, 0.9 * SET, SET)) / RPM

    words = "open loop, 900 r/min at the rated torque: speed at a fifth of the torque [r/min]"
    yield Row(words, f"{1470 - 570 * 0.2**2:.1f}", lambda: float(motor().speed_under(light, current)) / RPM, 0.01, FORMULA)
    yield Row("closed loop, set to 900 r/min: the same [r/min]", "", closed_loop, places=1)
    for feedback in (1.0, 0.8, 0.62):

        def full(feedback: float = feedback) -> float:
            return float(dataclasses.replace(motor(), feedback=feedback).control_speeds[0]) / RPM

        words = f"feedback of {100 * feedback:g} %: full current, and no control, below [r/min]"
        yield Row(words, f"{(900 - error) / feedback:.1f}", full, 0.01, FORMULA)
    least = "least feedback with which there is any control [%]"
    yield Row(least, f"{100 * (900 - error) / 1470:.1f}", lambda: 100 * motor().control_speeds[0] / PRIMARY, 0.1, FORMULA)


def motion_rows() -> Iterator[Row]:
    """Figs 4-10 to 4-12."""

    def solution(press: Linkage, duration: float, **options: Any) -> Run:
        return simulate(press, duration, speed=START, drive=ConstantTorque(TORQUE), flywheel=Flywheel(FLYWHEEL_INERTIA), **options)

    def states() -> list[float]:
        run = solution(opposed(), PERIODS, points=601)
        height = 1e3 * (run.slide_position - run.slide_position[0])
        curves = run.crank_angle, run.crank_speed, height, run.slide_velocity, run.slide_acceleration
        return [float(curve[round(1000 * time)]) for time in SOLVED for curve in curves]

    names = (f"{name} after {time:g} s" for time in SOLVED for name in NAMES)
    printed = (number for numbers in SOLVED.values() for number in numbers)
    yield from rows_from(states, *((name, number, 1e-7, SOLVER, 9) for name, number in zip(names, printed, strict=True)))
    words, exact = "crank angle after 0.6 s by RK4 with h = 0.1 ms [rad]", SOLVED[0.6][0]
    yield Row(words, exact, lambda: solution(opposed(), PERIODS, points=7, step=STEP).crank_angle[-1], 1e-7, SOLVER, 9)
    words = "rise of the crank speed in 1 s [%]"
    yield Row(words, "", lambda: 100 * (solution(opposed(), 1.0, points=2).crank_speed[-1] / START - 1), places=1)
    for place, words in enumerate(("(4.2.12), plain", "(4.2.41), opposed")):
        words = f"{words}: crank angle after 0.6 s less the exact one [rad]"
        yield Row(words, "", lambda place=place: simplified_errors()[place], places=6)


@cache
def simplified_errors() -> list[float]:
    """How far (4.2.12) and (4.2.41) are from the exact equation after 0.6 s [rad], with J0 in the inertia and the squares of the speed that
    our text lacks."""
    from scipy.integrate import solve_ivp  # slow to import

    main, auxiliary = ROD + SLIDE, AUXILIARY_ROD + COUNTERWEIGHT
    cases = (  # inertia, its part that swings, product of mass and radius
        (plain(), 0.289, main * RADIUS**2, (CRANK + main) * RADIUS),
        (
            opposed(),
            0.289 + 0.217,
            main * RADIUS**2 + auxiliary * AUXILIARY**2,
            (CRANK + main) * RADIUS - (AUXILIARY_CRANK + auxiliary) * AUXILIARY,
        ),
    )
    errors = []
    for press, inertia, swinging, product in cases:

        def rates(_: float, state: Array, inertia: float = inertia, swinging: float = swinging, product: float = product) -> list[float]:
            angle, speed = state
            torque = TORQUE - swinging * math.sin(angle) * math.cos(angle) * speed**2 - GRAVITY * product * math.sin(angle)
            return [speed, torque / (FLYWHEEL_INERTIA + inertia + swinging * math.sin(angle) ** 2)]

        angle = solve_ivp(rates, (0.0, PERIODS), [0.0, START], "DOP853", rtol=1e-11, atol=1e-11).y[0, -1]
        exact = simulate(press, PERIODS, speed=START, drive=ConstantTorque(TORQUE), flywheel=Flywheel(FLYWHEEL_INERTIA), points=2)
        errors.append(float(angle - exact.crank_angle[-1]))
    return errors


def laws(force: float) -> dict[str, ProcessLoad]:
    """The load cases by name, with this largest force [N], over slide heights instead of windows in time."""
    height = 0.5 * 0.015 * (1 + 0.05) * (SPEED * 0.0025) ** 2  # 2.5 ms before bottom dead centre
    return {
        "piling": ConstantForce(force, height),
        "blanking": Blanking(force, START_HEIGHT, BREAK_HEIGHT),
        "drawing": DeepDrawing(force, START_HEIGHT),
    }


def on_slide(load: ProcessLoad, heights: Array) -> Array:
    """Force of a load on the slide on its way down, (n,) at heights (n,) [N]."""
    force = np.zeros_like(heights)
    for interval in load.intervals(downwards=True):
        inside = (heights >= interval.lower) & (heights <= interval.upper)
        force[inside] = interval.force(heights[inside], np.zeros(int(inside.sum())))
    return force


def run(press: Linkage, load: ProcessLoad | TimeForce, duration: float = 0.2, points: int = 4001) -> Run:
    """One stroke under the thesis' constant torque, from bottom dead centre at 300 strokes/min."""
    drive, wheel = ConstantTorque(TORQUE), Flywheel(FLYWHEEL_INERTIA)
    return simulate(press, duration, speed=START, drive=drive, flywheel=wheel, loads=[load], points=points)


def law_rows() -> Iterator[Row]:
    """Figs 5-8 to 5-10: the load laws over the slide's height."""
    half, sine = 0.5 * (START_HEIGHT + BREAK_HEIGHT), 1250 * np.sin(np.pi / 4)
    cases = (
        ("piling, at bottom dead centre: F [kN]", 1250.0, "piling", 0.0),
        ("blanking, half-way: F sin(pi / 4) [kN]", sine, "blanking", half),
        ("blanking, at break-through: F [kN]", 1250.0, "blanking", BREAK_HEIGHT),
        ("drawing, a quarter of the way: F sin(pi / 4) [kN]", sine, "drawing", 0.75 * START_HEIGHT),
        ("drawing, half-way: F [kN]", 1250.0, "drawing", 0.5 * START_HEIGHT),
    )
    return rows_from(
        lambda: [float(on_slide(laws(NOMINAL)[name], np.array([height]))[0]) / 1e3 for *_, name, height in cases],
        *((words, f"{expected:.3f}", 1e-3, FORMULA) for words, expected, *_ in cases),
    )


def step_rows() -> Iterator[Row]:
    """Fig. 5-12: the cubic with zero slopes at both ends."""
    cases = {0.05: 0.0, 0.125: 0.15625, 0.15: 0.5, 0.175: 0.84375, 0.25: 1.0}
    return rows_from(
        lambda: [5 * float(step(x, 0.1, 0.0, 0.2, 1.0)) for x in cases],
        *((f"5 STEP(x, 0.1, 0, 0.2, 1) at {x:g}", f"{5 * y:.6f}", 1e-3 if y else 0, FORMULA) for x, y in cases.items()),
    )


def contact_rows() -> Iterator[Row]:
    """5.1.2 (3) and 5.1.3: contacts between parts, of which ADAMS has two functions."""
    k, e, c, d = 2.2e9, 1.5, 1e5, 0.5e-3
    below, both = Impact(0.0, k, e, c, d), TwoSidedStop(0.0, 0.030, k, e, c, d)

    def force(load: ProcessLoad, height: float, speed: float) -> float:
        (touched,) = (interval for interval in load.intervals(speed < 0) if interval.lower < height <= interval.upper)
        return float(touched.acting(touched.force(height, speed)))

    pressed, leaving = k * (d / 2) ** e + c / 2 * 0.1, k * 1e-3**e - c * 0.1
    return rows_from(
        lambda: [force(below, -d / 2, -0.1), force(below, -1e-3, 0.1), force(both, 0.03 + d / 2, 0.1)],
        ("IMPACT, 0.25 mm deep, 0.1 m/s downwards [N]", f"{pressed:.2f}", 1e-3, FORMULA),
        ("IMPACT, 1 mm deep, 0.1 m/s upwards [N]", f"{leaving:.2f}", 1e-3, FORMULA),
        ("BISTOP, 0.25 mm beyond its upper stop, 0.1 m/s upwards [N]", f"{-pressed:.2f}", 1e-3, FORMULA),
    )


def case_rows(name: str) -> Iterator[Row]:
    """Figs 5-13 to 5-15: forces under piling, blanking or drawing."""

    def largest(force: float) -> float:
        return float(np.abs(frame_forces(symmetric(), laws(force)[name]).vertical).max())

    yield Row("peak of the vertical force [N], with 1250 kN", PEAKS[name], lambda: largest(NOMINAL), places=0)
    yield Row("peak of the vertical force [N], with 1250 N", PEAKS[name], lambda: largest(ALLEGED), places=0)
    yield from rows_from(
        lambda: in_five_strokes(name),
        (f"{AS_PRINTED}: peak [N]", PEAKS[name], None, "", 1),
        (f"{AS_PRINTED}: what it changes of the lateral force in one main shaft, by the range of that [%]", "small", None, "", 1),
        ("1250 kN: turns of the crank in 1 s", "5", None, "", 3),
        ("1250 kN, five strokes: range of the lateral force, one main shaft [kN]", "", None, "", 2),
        ("the same, both shafts [kN]", "", None, "", 2),
    )
    if name == "blanking":
        yield from window_rows()
    if name != "piling":
        yield from stroke_rows(name)


AS_PRINTED = "the load as printed, 1250 N along the motion, in windows of time, five strokes"
NO_LOAD = ConstantForce(0.0, START_HEIGHT)


def window_rows() -> Iterator[Row]:
    """Both readings of the window of 5.7.4: the sine at its end, and the crank radius that follows from a sheet of 5 mm."""

    @cache
    def heights() -> tuple[Array, Array, NDArray[np.bool_]]:
        turn = cycle(symmetric(), SPEED, points=7200)
        return turn.time, turn.slide_position - turn.slide_position[0], turn.slide_velocity < 0

    def passed(height: float) -> float:
        time, above, down = heights()
        return float(np.interp(-height, -above[down], time[down]))

    def reading(end: float) -> list[float]:
        first, last = np.interp((0.1616, end), *heights()[:2]).tolist()
        scale = (START_HEIGHT - BREAK_HEIGHT) / (first - last)  # lengths of a press whose slide moves 5 mm from 0.1616 s to the end
        return [math.sin((end - 0.1616) * math.pi / 0.0488), 1e3 * RADIUS * scale, 1e3 * first * scale, 1e3 * last * scale]

    yield Row("slide at 10 mm, from which the crank radius is inferred [s]", "0.1616", lambda: passed(START_HEIGHT))
    yield Row("slide at 5 mm, likewise [s]", "0.1738", lambda: passed(BREAK_HEIGHT))
    for end in (0.1738, 0.1838):
        yield from rows_from(
            lambda end=end: reading(end),
            (f"window to {end} s: sine at its end, with pi / 0.0488", "", None, "", 3),
            (f"window to {end} s: crank radius, rod twenty times as long [mm]", "", None, "", 2),
            (f"window to {end} s: height at which it begins [mm]", "", None, "", 2),
            (f"window to {end} s: height at which it ends [mm]", "", None, "", 2),
        )


def stroke_rows(name: str) -> Iterator[Row]:
    """Work, torque and speeds of one stroke of blanking or drawing."""
    lower, (first, last) = {"blanking": (BREAK_HEIGHT, BLANKING), "drawing": (0.0, DRAWING)}[name]

    def ours() -> list[float]:
        load = laws(NOMINAL)[name]
        stroke = run(symmetric(), load, 0.205)
        heights = stroke.slide_position - stroke.slide_position[0]
        down = stroke.slide_velocity < 0
        torque = on_slide(load, heights[down]) * -stroke.slide_velocity[down] / stroke.crank_speed[down]
        ends = [_speed_at(symmetric(), stroke, height) for height in (START_HEIGHT, lower)]
        return [float(stroke.load_work[-1]), float(torque.max()), *ends]

    return rows_from(
        ours,
        ("work of the stroke, 2 F s / pi [J]", f"{NOMINAL * (START_HEIGHT - lower) * 2 / np.pi:.3f}", 1e-4, FORMULA),
        ("largest load torque at the crank [N m]", "14587.29", 1e-2, SOLVER, 1),
        ("crank speed as the force begins [rad/s]", first, 1e-6, SOLVER),
        ("crank speed as it ends [rad/s]", last, 1e-6, SOLVER),
    )


def _speed_at(press: Linkage, stroke: Run, height: float) -> float:
    """Crank speed as the slide passes a height on the first way down [rad/s]."""
    from scipy.optimize import brentq  # slow to import

    bottom = stroke.slide_position[0]

    def above(angle: float) -> float:
        return float(servo_cycle(press, speed=1.0, angle=[angle]).slide_position[0] - bottom - height)

    angle = brentq(above, np.pi, 2 * np.pi - 1e-9, xtol=1e-14) if height else 2 * np.pi
    driver = press.driver_indices[0]
    time = brentq(lambda t: float(stroke.trajectory.at(np.array([t])).position[driver, 0]) - angle, 0.1, stroke.time[-1], xtol=1e-14)
    return float(stroke.trajectory.at(np.array([time])).speed[driver, 0])


class FrameForces(NamedTuple):
    """Forces of the mechanism on the frame, the weight and the die's reaction on the bed left out.

    Attributes:
        run: the run.
        time: (n,) of its states, or of those of a part of it [s].
        vertical: (n,) [N].
        lateral: (n,) [N].
        shaft: (n,) lateral, of the left main shaft alone [N].
    """

    run: Run
    time: Array
    vertical: Array
    lateral: Array
    shaft: Array


def frame_forces(press: Linkage, load: ProcessLoad | TimeForce, duration: float = 0.205, points: int = 2001) -> FrameForces:
    """The forces on the frame under a load, from bottom dead centre on; see `run`."""
    strokes = run(press, load, duration, points)
    force = inverse_dynamics(press, strokes, loads=[load]).bearing_force
    on_frame = -np.sum([force[name] for name in ("O_left", "O_right", "slide_guide", "counterweight_guide")], axis=0)
    return FrameForces(strokes, strokes.time, on_frame[:, 2] + weight(press), on_frame[:, 0], -force["O_left"][:, 0])


def printed(name: str) -> TimeForce:
    """A load of 5.7 as it is printed: windows in time in each of five strokes, along the motion of the slide, with 1250 N.

    `STEP` opens and shuts them within 0.1 ms, that of drawing within 0.01 ms. The pulses of piling have bottom dead centre at 0.1 s, the
    others at 0.2 s.
    """
    start, end, shut, over = {
        "piling": (0.0975, 0.1025, 1e-4, math.inf),
        "blanking": (0.1616, 0.1838, 1e-4, 0.0488),
        "drawing": (0.1616, 0.2, 1e-5, 0.0244),
    }[name]
    strokes = 0.2 * np.arange(FIVE)
    edges = np.add.outer(strokes, [start - 1e-4, start, end - shut, end]).ravel().tolist()
    return TimeForce(partial(_printed_force, start, end, shut, over), edges)


def _printed_force(start: float, end: float, shut: float, over: float, time: Array) -> Array:
    within = np.mod(time, 0.2)
    wave = 1.0 if math.isinf(over) else np.sin((within - start) * np.pi / over)
    return np.asarray(-ALLEGED * wave * step(within, start - 1e-4, 0.0, start, 1.0) * step(within, end - shut, 1.0, end, 0.0))


def five_strokes(press: Linkage, load: ProcessLoad) -> FrameForces:
    """The forces on the frame over five turns of the crank from bottom dead centre, however long they take; see `run`."""
    forces = frame_forces(press, load, ENOUGH, STATES)
    turning = forces.run.crank_angle <= 2 * np.pi * FIVE + 1e-9
    return forces._replace(**{name: getattr(forces, name)[turning] for name in ("time", "vertical", "lateral", "shaft")})


def in_five_strokes(name: str) -> list[float]:
    """Five strokes with 1250 kN over the slide's height, and with the load as it is printed: `case_rows` has the quantities."""
    strokes = five_strokes(symmetric(), laws(NOMINAL)[name])
    in_time, idle = (frame_forces(symmetric(), load, LASTING, EDGED) for load in (printed(name), NO_LOAD))
    turns = float(np.interp(LASTING, strokes.run.time, strokes.run.crank_angle) / (2 * np.pi))
    aside = float(100 * np.abs(in_time.shaft - idle.shaft).max() / np.ptp(idle.shaft))
    shaft, both = (float(np.ptp(force)) for force in (strokes.shaft, strokes.lateral))
    peak = float(np.abs(strokes.vertical).max())
    return [float(np.abs(in_time.vertical).max()), aside, turns, shaft / 1e3, clean(both, peak) / 1e3]
