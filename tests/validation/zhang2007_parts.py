"""Zhang 2007, parts of the press that the thesis names and does not compute: those of 2.1, and the measures of 5.7.6 against the shock."""

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np
from validation.rows import Row, rows_from
from validation.zhang2007_balancing import SPEED, plain

from pinpress import RPM, ElasticRun, Motion, cycle, dead_centres, inverse_dynamics, simulate
from pinpress.common.quantities import Array
from pinpress.drives import ServoMotor
from pinpress.elasticity import Elastic, PreloadedJoint, Stiffness, compliance, eight_way_guide, guide_contact
from pinpress.loads import BalanceCylinder, Blanking, Friction, ImpactDamper, ProcessLoad, RateSensitiveBlanking, orifice_coefficient

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


def frame_rows() -> Iterator[Row]:
    """Tie rods, balance cylinders and the eight-way guide of 2.1."""

    def rods() -> list[float]:
        pulled, pressed = (1e-3 * float(force) for force in TIE_RODS.forces(NOMINAL))
        frames = TIE_RODS, TIE_RODS.loaded
        stiffness = [1e-6 * compliance(plain(), Stiffness(BEARINGS, frame=frame)).bottom_stiffness for frame in frames]
        torques = [np.ptp(inverse_dynamics(plain(), turn(), loads=loads).driving_torque) for loads in ([], [CYLINDERS])]
        return [pulled, pressed, 1e-3 * TIE_RODS.opening_load, *stiffness, *map(float, torques)]

    of_rods = (
        "tie rods under the nominal force [kN]",
        "uprights under the nominal force [kN]",
        "force at which the uprights lift off [kN]",
        "stiffness at bottom dead centre, with the preload [kN/mm]",
        "stiffness at bottom dead centre, tie rods alone [kN/mm]",
        "range of the driving torque, idle, 300 strokes/min [N m]",
        "range of the driving torque with balance cylinders [N m]",
    )
    yield from rows_from(rods, *((name, "", None, "", 0) for name in of_rods))
    for preload in (GIB_PRELOAD, 0.1 * GIB_PRELOAD):
        words = f"nominal force 30 mm beside the axis, gibs with {1e-3 * preload:.0f} kN each"
        names = (f"{words}: slide tilts by [1e-6 rad]", f"{words}: they touch on at least [% of their length]")
        yield from rows_from(lambda preload=preload: guide(preload), *((name, "", None, "", 0) for name in names))
    for coefficient, words in ((0.03, "sliding"), (0.003, "on needles")):
        name = f"lost by gibs with {1e-3 * GIB_PRELOAD:.0f} kN each, {words} (coefficient {coefficient:g}) [kW]"
        yield Row(name, "", lambda coefficient=coefficient: rubbing(coefficient), places=2)


@cache
def turn() -> Motion:
    return cycle(plain(), SPEED, points=720)


def guide(preload: float) -> tuple[float, float]:
    """Tilt of the slide [1e-6 rad] and least contact of a surface [%] under the nominal force beside the axis."""
    forces = inverse_dynamics(plain(), turn(), loads=[Blanking(NOMINAL, 0.004, 0.002)])
    surfaces = eight_way_guide(
        facing_x=(0.45, 0.30), facing_y=(0.40, 0.35), length=0.6, width=0.08, stiffness=2e9, preload=preload, middle=0.1
    )
    contact = guide_contact(plain(), forces, surfaces, offset=(0.03, 0.0, 0.0))
    tilt = 1e6 * float(np.linalg.norm(contact.rotation, axis=1).max())
    return tilt, 100 * min(float(share.min()) for share in contact.contact.values())


def rubbing(coefficient: float) -> float:
    """Power lost by preloaded gibs [kW]."""
    gibs = {"slide_guide": Friction(coefficient, preload=8 * GIB_PRELOAD)}
    return 1e-3 * float(inverse_dynamics(plain(), turn(), friction=gibs).friction_power["slide_guide"].mean())


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


def shock(slowest: float, loads: list[ProcessLoad]) -> _Shock:
    """A blank breaks on the press on springs, whose servo slows down to a share of its even speed near break-through."""
    angle = np.linspace(FIRST - 0.1, FIRST + 2 * np.pi, 4065)  # from before the run on, because a program stands still at its ends
    pace = EVEN * (1 - (1 - slowest) * np.exp(-(((angle - PAUSE) / NEAR) ** 2)))
    times = np.concatenate([[0.0], np.cumsum(0.5 * (1 / pace[1:] + 1 / pace[:-1]) * np.diff(angle))])
    times -= np.interp(FIRST, angle, times)
    servo = ServoMotor(times, angle, stiffness=2e7, damping=2e5, peak_torque=1e6, inertia=60.0)
    springs = Elastic(Stiffness(BEARINGS, {"slide_guide": GIBS_TURNING}, frame=TIE_RODS), damping_ratio=0.03, crown_mass=CROWN)
    until = float(np.interp(np.radians(375), angle, times))
    run = simulate(plain(), until, speed=EVEN, angle=FIRST, drive=servo, loads=loads, elastic=springs, points=4001, tolerance=1e-3)
    assert isinstance(run, ElasticRun)
    bottom = dead_centres(plain()).bottom_position
    broken = next(time for time, _, place in run.events if abs(place - bottom - BLANK.end) < 1e-9)
    return _Shock(run, broken, float(times[-1]))


def shock_rows() -> Iterator[Row]:
    """Measures against the shock of blanking, of 5.7.6."""

    def ours(slowest: float, loads: list[ProcessLoad]) -> list[float]:
        blow = shock(slowest, loads)
        upwards = 1e-3 * float(blow.run.bearing_force["P4"][blow.after, 2].max())
        hardest = float(np.abs(blow.run.slide_acceleration[blow.after]).max())
        return [upwards, hardest, 1e-3 * float(np.ptp(blow.run.shaking_force[blow.after, 2])), blow.period]

    oil = 2 * orifice_coefficient(0.160, 0.012)
    dampers = ImpactDamper([-0.003, 0.0025], [oil, oil])
    for name, slowest, loads in (
        ("even pace", 1.0, [BLANK]),
        ("pause", SLOWEST, [BLANK]),
        ("impact dampers", 1.0, [BLANK, dampers]),
    ):
        yield from rows_from(
            lambda slowest=slowest, loads=loads: ours(slowest, loads),
            (f"{name}: reverse load after break-through [kN]", "", None, "", 0),
            (f"{name}: largest acceleration of the slide after it [m/s2]", "", None, "", 0),
            (f"{name}: range of the vertical force on the frame after it [kN]", "", None, "", 0),
            (f"{name}: time of the stroke [s]", "", None, "", 3),
        )
