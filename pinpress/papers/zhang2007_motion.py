"""Zhang 2007, chapter 4: the press under a constant torque, by Runge-Kutta, and its motor with a slip clutch."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..common.quantities import RPM
from ..drives.motors import ConstantTorque, SlipClutchMotor
from ..drives.transmission import Flywheel, Geared
from ..linkage.linkage import Linkage
from ..loads.process import Blanking
from ..simulation.simulate import simulate
from ..simulation.steady_state import steady_state
from .pages import CURVES, DATA, NO_RESULT, Entry, Panel, Row, draw
from .zhang2007_presses import FLYWHEEL_INERTIA, SPEED, START, TORQUE, figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SOLVER = "independent solver"
STEP = 1e-4  # h of the thesis [s]
PERIODS = 0.6  # three of them [s]
# The same equation, initial values and inferred geometry, integrated without pinpress: angle [rad], speed [rad/s], height above bottom dead
# centre [mm], slide velocity and acceleration upwards
SOLVED = {
    0.2: ("6.348828154529", "32.243343708291", "0.033919326174", "0.033308238886", "16.337381982412"),
    0.4: ("12.863252626586", "33.055508095625", "0.688295013346", "0.151986910463", "16.354749187920"),
    0.6: ("19.542827320549", "33.819423745531", "3.615793850155", "0.336661987484", "13.330787953640"),
}
NAMES = ("crank angle [rad]", "crank speed [rad/s]", "height [mm]", "slide velocity [m/s]", "slide acceleration [m/s2]")
TOP, PRIMARY, SET = 1320 * RPM, 1470 * RPM, 900 * RPM  # the thesis prints the first; 900 r/min are 300 strokes/min behind its 3 to 1


def entries(given: Mapping[str, Linkage]) -> tuple[Entry, ...]:
    """All tables and figures of the chapter."""
    return (
        Entry(figures(4, 4, 5), "schemes of crank-slider and opposed arrangement", NO_RESULT),
        Entry(figures(4, 6, 8), "drawing of the motor, block diagram of its control, drive train", NO_RESULT),
        _motor(given["jf75g_125_symmetric"]),
        Entry(("Fig. 4-9",), "screenshot of the program", NO_RESULT),
        _run(given["jf75g_125"]),
    )


def motor(set_speed: float = SET) -> SlipClutchMotor:
    """The YCT280-4A; its primary speed is ours."""
    return SlipClutchMotor(rated_torque=189.0, primary_speed=PRIMARY, top_speed=TOP, set_speed=set_speed)


def _motor(press: Linkage) -> Entry:
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
    )
    reason = (
        "YCT280-4A: 30 kW, 189 N m, 1320 to 132 r/min, regulation 2.5 %, 750 kg. (4.3.1) is the law of `SlipClutchMotor`; its K follows"
        " from the torque at top speed, the amplifier's gain from the regulation, and the primary speed of 1470 r/min is ours, as none is"
        " printed. The power does not belong to torque and top speed; it is nearer to that of the motor before the clutch."
    )
    return Entry(("Table 4-1",), "motor with slip clutch", DATA, rows, reason)


def _run(press: Linkage) -> Entry:
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
    ]

    def shown() -> "Figure":
        names = ("position [mm]", "velocity [m/s]", "acceleration [m/s2]", "crank speed [rad/s]")
        drawn = (*curves[2:], curves[1])
        return draw("time [s]", [Panel(name, {"": (run.time, curve)}) for name, curve in zip(names, drawn, strict=True)], 4.0)

    reason = (
        "The printed equations have the mistakes listed below, and no number is printed of their solution. Beside ours stands an"
        " independent solution of the correct equation with the thesis' torque, initial speed and step and the inferred lengths. 567 N m"
        " without losses have no steady state, which the thesis calls its curves: the press speeds up throughout."
    )
    numbers = ("Fig. 4-10", "Fig. 4-11", "Fig. 4-12 (captioned 4-11)")
    caption = "Position above bottom dead centre, upwards positive."
    return Entry(numbers, "motion of the slide by Runge-Kutta", CURVES, tuple(rows), reason, "zhang2007_run", shown, caption)
