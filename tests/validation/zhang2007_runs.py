"""Zhang 2007, chapter 4 and 5.7: the press runs under a constant torque, behind its motor with a slip clutch, and under process loads."""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pinpress.common.quantities import RPM, Array
from pinpress.drives.motors import ConstantTorque
from pinpress.drives.slip_clutch import SlipClutchMotor
from pinpress.drives.transmission import Flywheel, Geared
from pinpress.dynamics.inverse_dynamics import inverse_dynamics
from pinpress.kinematics.cycle import cycle
from pinpress.kinematics.servo_motion import servo_cycle
from pinpress.linkage.linkage import Linkage
from pinpress.loads.contacts import Impact, TwoSidedStop
from pinpress.loads.process import Blanking, ConstantForce, DeepDrawing, ProcessLoad, TimeForce, step
from pinpress.simulation.duty import duty_cycle
from pinpress.simulation.run import Run
from pinpress.simulation.simulate import simulate
from pinpress.simulation.steady_state import steady_state
from validation.pages import CURVES, DATA, FORMULAS, NO_RESULT, NOT, PageEntry, Panel, Row, draw, figures
from validation.zhang2007_balancing import GRAVITY, SPEED, clean, weight

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SOLVER, FORMULA = "independent solver", "formula"
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


def motion_entries(given: Mapping[str, Linkage]) -> tuple[PageEntry, ...]:
    """All tables and figures of chapter 4."""
    return (
        PageEntry(figures(4, 4, 5), "schemes of crank-slider and opposed arrangement", NO_RESULT),
        PageEntry(figures(4, 6, 8), "drawing of the motor, block diagram of its control, drive train", NO_RESULT),
        _motor(given["jf75g_125_symmetric"]),
        _control(),
        PageEntry(("Fig. 4-9",), "screenshot of the program", NO_RESULT),
        _run(given["jf75g_125_plain"], given["jf75g_125"]),
    )


def load_entries(press: Linkage) -> tuple[PageEntry, ...]:
    """Figures 5-8 to 5-10 and 5-12 to 5-15, for the symmetric press."""
    return (_laws(), _step(), _contacts(), *_cases(press))


def motor(set_speed: float = SET) -> SlipClutchMotor:
    """The motor YCT280-4A of table 4-1; its primary speed is ours."""
    return SlipClutchMotor(rated_torque=189.0, primary_speed=PRIMARY, top_speed=TOP, set_speed=set_speed)


def _motor(press: Linkage) -> PageEntry:
    drive = motor()
    behind = Geared(drive, 3.0)
    loaded = SET * (1 - drive.regulation)
    steady = steady_state(press, SPEED, drive=behind, flywheel=Flywheel(FLYWHEEL_INERTIA), loads=[Blanking(1250e3, 0.010, 0.005)])
    speed = steady.crank_speed / RPM
    rows = (
        Row("torque at the crank, 2.5 % below the set speed (4.3.3) [N m]", "567", float(behind.torque(loaded / 3)), 1e-6, 1, "3 x 189"),
        Row("power at 189 N m and 1320 r/min [kW]", "30", 189 * TOP / 1e3, places=1),
        Row("power at 189 N m and 1470 r/min, slip included [kW]", "30", 189 * PRIMARY / 1e3, places=1),
        Row("blanking 5 mm with 1250 kN, set to 300 strokes/min: strokes/min held", "", float(60 / steady.time[-1]), places=2),
        Row("its speed variation within a stroke [%]", "", float(100 * np.ptp(speed) / speed.mean()), places=2),
        Row("GD2 of the flywheel, 4 g J0 [N m2]", "", 4 * GRAVITY * FLYWHEEL_INERTIA, places=1),
        Row("4 g 30 / pi, the constant of (4.3.2)", "375", 4 * GRAVITY / RPM, places=1),
        *_slip(press),
    )
    reason = (
        "(4.3.1) is the law of `SlipClutchMotor`; its K follows from the torque at top speed, the amplifier's gain from the"
        " regulation, and the primary speed of 1470 r/min is ours, as none is printed. The power does not belong to torque and top"
        " speed; it is nearer to that of the motor before the clutch. The clutch loses the torque times the difference of its speeds,"
        " much at low speed, as the thesis says (last rows). Press makers give a flywheel as GD2, as (4.3.2) does: J is GD2 / (4 g)."
    )
    return PageEntry(("Table 4-1",), "motor with slip clutch", DATA, rows, reason)


def _control() -> PageEntry:
    """4.3 on the control: what there is without feedback, and where control is lost with too little of it."""
    from scipy.optimize import brentq  # slow to import

    closed = motor()
    held = (1470 - 900) / (1470 - 1320)  # by (4.3.1) to the power of -1/4 the current with which the rated torque is held at 900 r/min
    drop = 0.025 * 900
    error = drop * ((1470 - 900 + drop) / 150) ** 0.25  # below the set speed, at which the current is full [r/min]
    light = 0.2 * 189.0

    def more(speed: float) -> float:
        return float(closed.torque(speed)) - light

    rows = [
        Row(
            "open loop, 900 r/min at the rated torque: speed at a fifth of the torque [r/min]",
            f"{1470 - 570 * 0.2**2:.1f}",
            float(closed.speed_under(light, held**-0.25)) / RPM,
            0.01,
            1,
            FORMULA,
        ),
        Row("closed loop, set to 900 r/min: the same [r/min]", "", float(brentq(more, 0.9 * SET, SET)) / RPM, places=1),
    ]
    for feedback in (1.0, 0.8, 0.62):
        full, _ = dataclasses.replace(closed, feedback=feedback).control_speeds
        words = f"feedback of {100 * feedback:g} %: full current, and no control, below [r/min]"
        rows.append(Row(words, f"{(900 - error) / feedback:.1f}", full / RPM, 0.01, 1, FORMULA))
    least = "least feedback with which there is any control [%]"
    rows.append(Row(least, f"{100 * (900 - error) / 1470:.1f}", 100 * closed.control_speeds[0] / PRIMARY, 0.1, 1, FORMULA))
    reason = (
        "4.3 says that without feedback the characteristic is soft and control is lost over a wide range, with too little feedback"
        " over some. By (4.3.1) it is lost wherever the excitation current is at its largest. Ours: set to 900 r/min, the gain from"
        " the regulation."
    )
    return PageEntry(("4.3, control",), "where the speed control is lost", FORMULAS, tuple(rows), reason)


def _slip(press: Linkage) -> Iterator[Row]:
    """What the clutch loses at set speeds of 150, 300 and 440 strokes/min, the last at its top speed."""
    for strokes in (150, 300, 440):
        drive, wheel, load = Geared(motor(3 * strokes * RPM), 3.0), Flywheel(FLYWHEEL_INERTIA), Blanking(NOMINAL / 4, 0.010, 0.005)
        duty = duty_cycle(steady_state(press, strokes * RPM, drive=drive, flywheel=wheel, loads=[load]))
        assert duty.slip_loss is not None
        assert duty.efficiency is not None
        words = f"a quarter of this load, set to {strokes} strokes/min"
        yield Row(f"{words}: lost by slip in a stroke [J]", "", duty.slip_loss, places=0)
        yield Row(f"{words}: share of the motor's work that reaches the crank [%]", "", 100 * duty.efficiency, places=1)


def _run(plain: Linkage, press: Linkage) -> PageEntry:
    drive, wheel = ConstantTorque(TORQUE), Flywheel(FLYWHEEL_INERTIA)
    run = simulate(press, PERIODS, speed=START, drive=drive, flywheel=wheel, points=601)
    fixed = simulate(press, PERIODS, speed=START, drive=drive, flywheel=wheel, points=7, step=STEP)
    second = simulate(press, 1.0, speed=START, drive=drive, flywheel=wheel, points=2)
    bottom = run.slide_position[0]
    curves = (run.crank_angle, run.crank_speed, 1e3 * (run.slide_position - bottom), run.slide_velocity, run.slide_acceleration)
    rows = [
        Row(f"{name} after {time:g} s", theirs, float(curve[round(1000 * time)]), 1e-7, 9, SOLVER)
        for time, solved in SOLVED.items()
        for name, theirs, curve in zip(NAMES, solved, curves, strict=True)
    ]
    rows += [
        Row("crank angle after 0.6 s by RK4 with h = 0.1 ms [rad]", SOLVED[0.6][0], float(fixed.crank_angle[-1]), 1e-7, 9, SOLVER),
        Row("rise of the crank speed in 1 s [%]", "", float(100 * (second.crank_speed[-1] / START - 1)), places=1),
        *_simplified(plain, press),
    ]

    def shown() -> "Figure":
        names = ("position [mm]", "velocity [m/s]", "acceleration [m/s2]", "crank speed [rad/s]")
        drawn = (*curves[2:], curves[1])
        return draw("time [s]", [Panel(name, {"": (run.time, curve)}) for name, curve in zip(names, drawn, strict=True)], 4.0)

    reason = (
        "No number of the solution is printed. Beside ours stands an independent solution of the correct equation with the thesis'"
        " torque, initial speed and step and the inferred lengths. (4.2.12) and (4.2.41), corrected, leave out what is small with the"
        " ratio of crank to rod: the error is small, as the thesis says (last rows). It calls its curves steady, but 567 N m without"
        " losses have no steady state: the press speeds up throughout."
    )
    numbers = ("Fig. 4-10", "Fig. 4-11", "Fig. 4-12 (captioned 4-11)")
    caption = "Position above bottom dead centre, upwards positive."
    return PageEntry(numbers, "motion of the slide by Runge-Kutta", CURVES, tuple(rows), reason, "zhang2007_run", shown, caption)


def _simplified(plain: Linkage, opposed: Linkage) -> Iterator[Row]:
    """How far (4.2.12) and (4.2.41) are from the exact equation, with J0 in the inertia and the squares of the speed that our text"
    " lacks."""
    from scipy.integrate import solve_ivp  # slow to import

    r1, r2 = 0.015, 0.0297
    main, auxiliary = 77.49 + 2200.0, 113.31 + 1045.0
    cases = {  # inertia, its part that swings, product of mass and radius
        "(4.2.12), plain": (plain, 0.289, main * r1**2, (52.25 + main) * r1),
        "(4.2.41), opposed": (opposed, 0.289 + 0.217, main * r1**2 + auxiliary * r2**2, (52.25 + main) * r1 - (18.38 + auxiliary) * r2),
    }
    for words, (press, inertia, swinging, product) in cases.items():

        def rates(_: float, state: Array, inertia: float = inertia, swinging: float = swinging, product: float = product) -> list[float]:
            angle, speed = state
            torque = TORQUE - swinging * math.sin(angle) * math.cos(angle) * speed**2 - GRAVITY * product * math.sin(angle)
            return [speed, torque / (FLYWHEEL_INERTIA + inertia + swinging * math.sin(angle) ** 2)]

        found = solve_ivp(rates, (0.0, PERIODS), [0.0, START], "DOP853", rtol=1e-11, atol=1e-11).y[0, -1]
        exact = simulate(press, PERIODS, speed=START, drive=ConstantTorque(TORQUE), flywheel=Flywheel(FLYWHEEL_INERTIA), points=2)
        yield Row(f"{words}: crank angle after 0.6 s less the exact one [rad]", "", float(found - exact.crank_angle[-1]), places=6)


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


def _laws() -> PageEntry:
    given = laws(NOMINAL)
    span = START_HEIGHT - BREAK_HEIGHT
    half = START_HEIGHT - 0.5 * span
    rows = (
        _law("piling, at bottom dead centre: F [kN]", 1250.0, given["piling"], 0.0),
        _law("blanking, half-way: F sin(pi / 4) [kN]", 1250 * np.sin(np.pi / 4), given["blanking"], half),
        _law("blanking, at break-through: F [kN]", 1250.0, given["blanking"], BREAK_HEIGHT),
        _law("drawing, a quarter of the way: F sin(pi / 4) [kN]", 1250 * np.sin(np.pi / 4), given["drawing"], 0.75 * START_HEIGHT),
        _law("drawing, half-way: F [kN]", 1250.0, given["drawing"], 0.5 * START_HEIGHT),
    )

    def shown() -> "Figure":
        heights = np.linspace(0.012, 0.0, 1201)
        return draw(
            "slide below 12 mm above bottom dead centre [mm]",
            [Panel("force [kN]", {name: (1e3 * (0.012 - heights), on_slide(law, heights) / 1e3) for name, law in given.items()})],
            5.5,
        )

    reason = "Over the slide's height, as the thesis defines them; blanking from 10 to 5 mm and drawing from 10 to 0 mm."
    return PageEntry(figures(5, 8, 10), "load laws of piling, blanking, drawing", FORMULAS, rows, reason, "zhang2007_loads", shown)


def _law(what: str, expected: float, load: ProcessLoad, height: float) -> Row:
    return Row(what, f"{expected:.3f}", float(on_slide(load, np.array([height]))[0]) / 1e3, 1e-3, None, FORMULA)


def _step() -> PageEntry:
    def value(x: float) -> float:
        return 5 * float(step(x, 0.1, 0.0, 0.2, 1.0))

    # the cubic with zero slopes at both ends
    rows = tuple(
        Row(f"5 STEP(x, 0.1, 0, 0.2, 1) at {x:g}", f"{5 * expected:.6f}", value(x), 1e-3 if expected else 0, None, FORMULA)
        for x, expected in ((0.05, 0.0), (0.125, 0.15625), (0.15, 0.5), (0.175, 0.84375), (0.25, 1.0))
    )

    def shown() -> "Figure":
        x = np.linspace(0.0, 0.4, 801)
        up, pulse = 5 * step(x, 0.1, 0, 0.2, 1), 5 * step(x, 0.1, 0, 0.2, 1) * step(x, 0.2, 1, 0.3, 0)
        return draw("time [s]", [Panel("value", {"step": (x, up), "pulse of two steps": (x, pulse)})], 5.0)

    return PageEntry(("Fig. 5-12",), "ADAMS' function STEP", FORMULAS, rows, "", "zhang2007_step", shown)


def _contacts() -> PageEntry:
    """5.1.2 (3) and 5.1.3: contacts between parts, of which ADAMS has two functions."""
    k, e, c, d = 2.2e9, 1.5, 1e5, 0.5e-3
    below = Impact(0.0, k, e, c, d)
    both = TwoSidedStop(0.0, 0.030, k, e, c, d)

    def force(load: ProcessLoad, height: float, speed: float) -> float:
        (found,) = (each for each in load.intervals(speed < 0) if each.lower < height <= each.upper)
        return float(found.acting(found.force(height, speed)))

    expected = (
        ("IMPACT, 0.25 mm deep, 0.1 m/s downwards [N]", k * (d / 2) ** e + c / 2 * 0.1, force(below, -d / 2, -0.1)),
        ("IMPACT, 1 mm deep, 0.1 m/s upwards [N]", k * 1e-3**e - c * 0.1, force(below, -1e-3, 0.1)),
        ("BISTOP, 0.25 mm beyond its upper stop, 0.1 m/s upwards [N]", -k * (d / 2) ** e - c / 2 * 0.1, force(both, 0.03 + d / 2, 0.1)),
    )
    rows = tuple(Row(name, f"{by_hand:.2f}", ours, 1e-3, 2, FORMULA) for name, by_hand, ours in expected)
    reason = (
        "5.1.2 (3) names contacts between parts, 5.1.3 the function IMPACT, a spring-damper that only presses. ADAMS has BISTOP too; their"
        " damper grows by STEP: `Impact` and `TwoSidedStop`. Ours: k = 2.2e9 N/m^1.5, a damper of 1e5 N s/m from 0.5 mm on."
    )
    return PageEntry(("5.1.2 (3), 5.1.3",), "ADAMS' functions of contact", FORMULAS, rows, reason)


def _cases(press: Linkage) -> tuple[PageEntry, ...]:
    cases = {
        "piling": ("Fig. 5-13", ()),
        "blanking": ("Fig. 5-14", _windows(press) + _stroke(press, "blanking", BREAK_HEIGHT, BLANKING)),
        "drawing": ("Fig. 5-15", _stroke(press, "drawing", 0.0, DRAWING)),
    }
    entries = []
    for name, (number, rows) in cases.items():
        peak = PEAKS[name]
        found = [_peak(press, laws(force)[name]) for force in (NOMINAL, ALLEGED)]
        peaks = (
            Row("peak of the vertical force [N], with 1250 kN", peak, found[0], places=0),
            Row("with 1250 N", peak, found[1], places=0),
        )
        shown = _figure(press, laws(NOMINAL)[name])
        rows = (*peaks, *_five_strokes(press, name), *rows)
        entries.append(PageEntry((number,), f"forces under {name}", NOT, rows, _WHY[name], f"zhang2007_{name}", shown, _CAPTION))
    return tuple(entries)


AS_PRINTED = "the load as printed, 1250 N along the motion, in windows of time, five strokes"
NO_LOAD = ConstantForce(0.0, START_HEIGHT)
_CAPTION = (
    "Forces of the mechanism on the frame in five strokes under 1250 kN and 567 N m, less the weight; the die's reaction on the bed is left"
    " out. The lateral forces of both main shafts cancel."
)
_NOMINAL = (
    "The rows are sizes of peaks. The thesis' peaks are negative, because it lets the force act along the slide's motion. Its load"
    " functions read 1250, without a unit, in a model in newtons (table 5-1), and its peaks fit 1250 N in order of size: they are some"
    " hundred newtons beyond the 2316 N of empty strokes. Of panel (b) it says that the lateral force changes little: with 1250 N ours"
    " in one main shaft does so, with 1250 kN it is two to ten times as large."
)
_SEE = "For sizes and signs of the peaks see Fig. 5-13."
_WHY = {
    "piling": f"{_NOMINAL} Its pulses of piling assume bottom dead centre at 0.1 s, its windows of blanking at 0.2 s: one model cannot"
    " satisfy both.",
    "blanking": (
        f"{_SEE} The window can be read in two ways: the text ends it at 0.1738 s, the load function at 0.1838 s, where its sine with"
        " pi / 0.0488 is 0.990. We take the text's, because a sheet of 5 mm then begins and ends at round heights; the inferred crank"
        " radius of 15 mm rests on this choice. Our windows go with the slide's height."
    ),
    "drawing": f"{_SEE} With pi / 0.0244 the force turns negative after 0.186 s; a half sine up to 0.2 s has pi / 0.0384.",
}


def _windows(press: Linkage) -> tuple[Row, ...]:
    """Both readings of the window of 5.7.4: the sine at its end, and the crank radius that follows from a sheet of 5 mm."""
    turn = cycle(press, SPEED, points=7200)
    heights, down = turn.slide_position - turn.slide_position[0], turn.slide_velocity < 0
    when = [float(np.interp(-height, -heights[down], turn.time[down])) for height in (START_HEIGHT, BREAK_HEIGHT)]
    names = ("slide at 10 mm, from which the crank radius is inferred [s]", "slide at 5 mm, likewise [s]")
    rows = [Row(name, theirs, ours) for name, theirs, ours in zip(names, ("0.1616", "0.1738"), when, strict=True)]
    for end in (0.1738, 0.1838):
        first, last = np.interp((0.1616, end), turn.time, heights).tolist()
        scale = (START_HEIGHT - BREAK_HEIGHT) / (first - last)  # lengths of a press whose slide moves 5 mm from 0.1616 s to the end
        rows += [
            Row(
                f"window to {end} s: sine at its end, with pi / 0.0488",
                "",
                math.sin((end - 0.1616) * math.pi / 0.0488),
                places=3,
            ),
            Row(f"window to {end} s: crank radius, rod twenty times as long [mm]", "", 1e3 * 0.015 * scale, places=2),
            Row(f"window to {end} s: height at which it begins [mm]", "", 1e3 * first * scale, places=2),
            Row(f"window to {end} s: height at which it ends [mm]", "", 1e3 * last * scale, places=2),
        ]
    return tuple(rows)


def _stroke(press: Linkage, name: str, lower: float, speeds: tuple[str, str]) -> tuple[Row, ...]:
    load = laws(NOMINAL)[name]
    stroke = run(press, load, 0.205)
    heights = stroke.slide_position - stroke.slide_position[0]
    down = stroke.slide_velocity < 0
    ends = [_speed_at(press, stroke, height) for height in (START_HEIGHT, lower)]
    torque = on_slide(load, heights[down]) * -stroke.slide_velocity[down] / stroke.crank_speed[down]
    work = NOMINAL * (START_HEIGHT - lower) * 2 / np.pi
    return (
        Row("work of the stroke, 2 F s / pi [J]", f"{work:.3f}", float(stroke.load_work[-1]), 1e-4, None, FORMULA),
        Row("largest load torque at the crank [N m]", "14587.29", float(torque.max()), 1e-2, 1, SOLVER),
        Row("crank speed as the force begins [rad/s]", speeds[0], ends[0], 1e-6, None, SOLVER),
        Row("crank speed as it ends [rad/s]", speeds[1], ends[1], 1e-6, None, SOLVER),
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


def _peak(press: Linkage, load: ProcessLoad) -> float:
    return float(np.abs(frame_forces(press, load).vertical).max())


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
    found = frame_forces(press, load, ENOUGH, STATES)
    turning = found.run.crank_angle <= 2 * np.pi * FIVE + 1e-9
    return found._replace(**{name: getattr(found, name)[turning] for name in ("time", "vertical", "lateral", "shaft")})


def _five_strokes(press: Linkage, name: str) -> tuple[Row, ...]:
    """Five strokes with 1250 kN over the slide's height, and with the load as it is printed."""
    found = five_strokes(press, laws(NOMINAL)[name])
    in_time, idle = (frame_forces(press, load, LASTING, EDGED) for load in (printed(name), NO_LOAD))
    peak, turns = float(np.abs(found.vertical).max()), float(np.interp(LASTING, found.run.time, found.run.crank_angle) / (2 * np.pi))
    shaft, both = (float(np.ptp(force)) for force in (found.shaft, found.lateral))
    aside = float(100 * np.abs(in_time.shaft - idle.shaft).max() / np.ptp(idle.shaft))
    return (
        Row(f"{AS_PRINTED}: peak [N]", PEAKS[name], float(np.abs(in_time.vertical).max()), places=1),
        Row(f"{AS_PRINTED}: what it changes of the lateral force in one main shaft, by the range of that [%]", "small", aside, places=1),
        Row("1250 kN: turns of the crank in 1 s", "5", turns, places=3),
        Row("1250 kN, five strokes: range of the lateral force, one main shaft [kN]", "", shaft / 1e3, places=2),
        Row("the same, both shafts [kN]", "", clean(both, peak) / 1e3, places=2),
    )


def _figure(press: Linkage, load: ProcessLoad) -> "Callable[[], Figure]":
    def shown() -> "Figure":
        found = five_strokes(press, load)
        time = found.time
        lateral = {"one main shaft": (time, found.shaft / 1e3), "both": (time, found.lateral / 1e3)}
        panels = [Panel("(a) vertical force [kN]", {"": (time, found.vertical / 1e3)}), Panel("(b) lateral force [kN]", lateral)]
        return draw("time [s]", panels, 4.5)

    return shown
