"""Zhang 2007, parts of the press that the thesis names and does not compute: those of 2.1, and the measures of 5.7.6 against the shock."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pinpress.common.quantities import RPM, Array
from pinpress.drives.motors import ServoMotor
from pinpress.dynamics.inverse_dynamics import inverse_dynamics
from pinpress.elasticity.guide_surfaces import eight_way_guide, guide_contact
from pinpress.elasticity.springs import Elastic, PreloadedJoint, Stiffness
from pinpress.elasticity.unit_load import compliance
from pinpress.kinematics.cycle import cycle
from pinpress.kinematics.slide_path import dead_centres
from pinpress.linkage.linkage import Linkage
from pinpress.loads.hydraulics import ImpactDamper, orifice_coefficient
from pinpress.loads.link import Friction
from pinpress.loads.pneumatics import BalanceCylinder
from pinpress.loads.process import Blanking, ProcessLoad
from pinpress.loads.shearing import RateSensitiveBlanking
from pinpress.simulation.elastic.run import ElasticRun
from pinpress.simulation.simulate import simulate
from validation.pages import BEYOND, PageEntry, Panel, Row, draw
from validation.zhang2007_balancing import SPEED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOMINAL = 1250e3  # [N]
BEARINGS = {"O": 3e9, "P2": 4e9, "P4": 4e9, "slide_guide": 2e9}  # springs of `jf75g_125_plain`, assumed [N/m]
GIBS_TURNING = 2e8  # [N m/rad]
TIE_RODS = PreloadedJoint(loaded=2e9, relieved=6e9, preload=2 * NOMINAL)  # twice the nominal force, as 2.1 (2) says; stiffnesses assumed
GIB_PRELOAD = 100e3  # of each of the eight [N]; assumed
CROWN = 4000.0  # [kg]
CYLINDERS = BalanceCylinder(bore=0.125, pressure=4.4e5, volume=0.060, count=4)  # carry the slide at bottom dead centre; assumed
BLANK = RateSensitiveBlanking(600e3, 0.004, 0.002, sensitivity=0.05, reference_speed=1e-3, peak=0.003, remaining=0.5)
EVEN, FIRST = 60 * RPM, np.pi  # speed of the crank, and its angle at the start of a run: top dead centre [rad/s, rad]
PAUSE, NEAR = np.radians(333), 0.05  # angle of the pause, and how far it reaches [rad]
SLOWEST = 0.02  # least share of the even speed


def entries(plain: Linkage) -> tuple[PageEntry, ...]:
    """The parts of 2.1, and what those of 5.7.6 do."""
    return _of_the_frame(plain), _against_the_shock(plain)


def _of_the_frame(plain: Linkage) -> PageEntry:
    bare = compliance(plain, Stiffness(BEARINGS, frame=TIE_RODS.loaded))
    closed = compliance(plain, Stiffness(BEARINGS, frame=TIE_RODS))
    pulled, pressed = (float(force) for force in TIE_RODS.forces(NOMINAL))
    turn = cycle(plain, SPEED, points=720)
    empty, carried = (np.ptp(inverse_dynamics(plain, turn, loads=given).driving_torque) for given in ([], [CYLINDERS]))
    rows = (
        Row("tie rods under the nominal force [kN]", "", 1e-3 * pulled, places=0),
        Row("uprights under the nominal force [kN]", "", 1e-3 * pressed, places=0),
        Row("force at which the uprights lift off [kN]", "", 1e-3 * TIE_RODS.opening_load, places=0),
        Row("stiffness at bottom dead centre, with the preload [kN/mm]", "", 1e-6 * closed.bottom_stiffness, places=0),
        Row("stiffness at bottom dead centre, tie rods alone [kN/mm]", "", 1e-6 * bare.bottom_stiffness, places=0),
        Row("range of the driving torque, idle, 300 strokes/min [N m]", "", float(empty), places=0),
        Row("range of the driving torque with balance cylinders [N m]", "", float(carried), places=0),
        *_guide(plain),
    )
    reason = (
        "2.1 lists four tie rods preloaded to twice the nominal force, an eight-way slide guide and balance cylinders, without their"
        " data. All of ours are assumed: rods of 2e9 N/m, uprights of 6e9 N/m, four cylinders of 125 mm at 4.4 bar with a tank of 60"
        " l, eight gibs of 600 x 80 mm and 2e9 N/m. Preloaded gibs rub without a load; needles (1.2) take a tenth of it."
    )
    return PageEntry(("2.1",), "tie rods, eight-way guide and balance cylinders", BEYOND, rows, reason)


def _guide(plain: Linkage) -> Iterator[Row]:
    """The eight surfaces of the slide's guide under the nominal force beside its axis, with and without enough preload."""
    turn = cycle(plain, SPEED, points=720)
    forces = inverse_dynamics(plain, turn, loads=[Blanking(NOMINAL, 0.004, 0.002)])
    for preload in (GIB_PRELOAD, 0.1 * GIB_PRELOAD):
        surfaces = eight_way_guide(
            facing_x=(0.45, 0.30), facing_y=(0.40, 0.35), length=0.6, width=0.08, stiffness=2e9, preload=preload, middle=0.1
        )
        found = guide_contact(plain, forces, surfaces, offset=(0.03, 0.0, 0.0))
        words = f"nominal force 30 mm beside the axis, gibs with {1e-3 * preload:.0f} kN each"
        yield Row(f"{words}: slide tilts by [1e-6 rad]", "", 1e6 * float(np.linalg.norm(found.rotation, axis=1).max()), places=0)
        yield Row(
            f"{words}: they touch on at least [% of their length]",
            "",
            100 * min(float(each.min()) for each in found.contact.values()),
            places=0,
        )
    for coefficient, words in ((0.03, "sliding"), (0.003, "on needles")):
        rubbing = {"slide_guide": Friction(coefficient, preload=8 * GIB_PRELOAD)}
        lost = inverse_dynamics(plain, turn, friction=rubbing).friction_power["slide_guide"].mean()
        yield Row(
            f"lost by gibs with {1e-3 * GIB_PRELOAD:.0f} kN each, {words} (coefficient {coefficient:g}) [kW]",
            "",
            1e-3 * float(lost),
            places=2,
        )


class _Shock(NamedTuple):
    """A run through break-through.

    Attributes:
        run: the run.
        broken: time of break-through [s].
        period: time of the whole stroke [s].
    """

    run: ElasticRun
    broken: float
    period: float

    @property
    def after(self) -> Array:
        """(n,) whether each state is after break-through."""
        return np.asarray(self.run.time > self.broken)


def shock(plain: Linkage, slowest: float, loads: list[ProcessLoad]) -> _Shock:
    """A blank breaks on the press on springs, whose servo slows down to a share of its even speed near break-through."""
    angle = np.linspace(FIRST - 0.1, FIRST + 2 * np.pi, 4065)  # from before the run on, because a program stands still at its ends
    pace = EVEN * (1 - (1 - slowest) * np.exp(-(((angle - PAUSE) / NEAR) ** 2)))
    times = np.concatenate([[0.0], np.cumsum(0.5 * (1 / pace[1:] + 1 / pace[:-1]) * np.diff(angle))])
    times -= np.interp(FIRST, angle, times)
    servo = ServoMotor(times, angle, stiffness=2e7, damping=2e5, peak_torque=1e6, inertia=60.0)
    springs = Elastic(Stiffness(BEARINGS, {"slide_guide": GIBS_TURNING}, frame=TIE_RODS), damping_ratio=0.03, crown_mass=CROWN)
    until = float(np.interp(np.radians(375), angle, times))
    run = simulate(plain, until, speed=EVEN, angle=FIRST, drive=servo, loads=loads, elastic=springs, points=4001, tolerance=1e-3)
    assert isinstance(run, ElasticRun)
    bottom = dead_centres(plain).bottom_position
    broken = next(time for time, _, place in run.events if abs(place - bottom - BLANK.end) < 1e-9)
    return _Shock(run, broken, float(times[-1]))


def _against_the_shock(plain: Linkage) -> PageEntry:
    oil = 2 * orifice_coefficient(0.160, 0.012)
    dampers = ImpactDamper([-0.003, 0.0025], [oil, oil])
    found = {
        "even pace": shock(plain, 1.0, [BLANK]),
        "pause": shock(plain, SLOWEST, [BLANK]),
        "impact dampers": shock(plain, 1.0, [BLANK, dampers]),
    }
    rows = []
    for name, each in found.items():
        hardest = float(np.abs(each.run.slide_acceleration[each.after]).max())
        upwards = float(each.run.bearing_force["P4"][each.after, 2].max())
        rows += [
            Row(f"{name}: reverse load after break-through [kN]", "", 1e-3 * upwards, places=0),
            Row(f"{name}: largest acceleration of the slide after it [m/s2]", "", hardest, places=0),
            Row(
                f"{name}: range of the vertical force on the frame after it [kN]",
                "",
                1e-3 * float(np.ptp(each.run.shaking_force[each.after, 2])),
                places=0,
            ),
            Row(f"{name}: time of the stroke [s]", "", each.period, places=3),
        ]

    def figure() -> Figure:
        curves = {}
        for name, each in found.items():
            near = np.abs(each.run.time - each.broken) < 0.05
            curves[name] = 1e3 * (each.run.time[near] - each.broken), -1e-3 * each.run.bearing_force["P4"][near, 2]
        return draw("time from break-through [ms]", [Panel("rod on slide, downwards [kN]", curves)])

    reason = (
        "5.7.6 and 1.2.1 name three measures against the shock of blanking, without numbers: another motion of the slide, impact"
        " dampers, and a servo that stops just before break-through. Ours: `jf75g_125_plain` on springs, 60 strokes/min, a blank of"
        " 600 kN whose force falls to half before it breaks; a pace that falls to 2 % at 27 degrees before bottom dead centre; two"
        " dampers with orifices of 12 mm. All is assumed: what counts is the comparison."
    )
    caption = "Force of the rod on the slide about break-through."
    return PageEntry(("5.7.6",), "measures against the shock of blanking", BEYOND, tuple(rows), reason, "zhang2007_shock", figure, caption)
