"""The accuracy of bottom dead centre as one table: machining, clearances, springs and heat, over speed, process and temperature.

    tol = pp.tolerances
    print(tol.budget(
        press,
        speeds=[10 * pp.RPM, 70 * pp.RPM],
        clearance=dict.fromkeys("ABCDEF", 50e-6),
        stiffness=springs,
        process=5e5,
        temperatures=tol.Temperatures({"rocker": 10.0, "rod": 10.0}),
        machining=tol.bottom_dead_centre(press, parts),
    ))

The height of the die is set while the press turns slowly, idle and cold. Later the press runs at another speed, then with the force of the
process, then warm. The rise is the shift of bottom dead centre from the first condition to another. Machining causes no rise: it differs
from press to press, and setting the die removes it.

GB/T 29548-2024 tests the change of the bottom dead centre of an idle press in three phases: it speeds up from its initial state to its
largest speed (3.2), warms at 80 % of that speed (3.3), and continues warm (3.4). With ``speeds=[slow, largest, 0.8 * largest]`` the first
two phases are differences of the rises "idle" and "idle, warm". The standard's permissible values are not built in, because only its terms
were available.

In every condition the slide stands at z + p + d over the crank angle. z is the position in the rigid press, p the offset in the clearances
(see `play`), and d the deflection of the springs (`elasticity.slide_deflection`, quasi-static). The lowest position near the rigid dead
centre is bottom dead centre. The shift by heat is added. All parts are of first order, so they can be added.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import LARGEST, number, numbers, typed
from ..common.errors import PinpressError
from ..common.quantities import GRAVITY, DriverCoordinate
from ..common.results import Record, Records, Tabular
from ..common.tables import Column
from ..dynamics.applied_loads import force_on_slide
from ..elasticity.slide_under_load import slide_deflection
from ..elasticity.springs import Stiffness
from ..kinematics.cycle import doubt_speeds
from ..kinematics.servo_motion import servo_cycle
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress, is_same_press, told_apart
from ..loads.link import Load
from .clearances import KNOWN_TO, GuideClearance, play
from .clearances_over_speed import SLOWEST
from .dead_centre_scatter import DeadCentreScatter
from .temperatures import Temperatures, heat

WINDOW = np.radians(6.0)  # range on both sides of the rigid dead centre in which the lowest position is searched [rad]
STATES = 121  # crank angles in this range: half a step of 0.05 deg moves a slide by less than 1e-6 of the crank radius
PARTS = ("clearances", "springs", "heat")
NEGLIGIBLE = 5e-8  # smaller shifts are not printed [m]


@dataclass(frozen=True, repr=False)
class BottomCondition(
    Record,
    units=dict.fromkeys(("clearances", "springs", "crank", "heat", "shift", "lowest", "highest", "rise"), "m") | {"speed": "rad/s"},
):
    """Bottom dead centre of a press in one condition, compared with the rigid press without clearances.

    Attributes:
        speed: speed of the crank [rad/s].
        condition: "idle", "process", "idle, warm" or "process, warm".
        clearances: shift by clearances [m].
        springs: shift by springs [m].
        crank: remaining shift, because the slide is lowest next to the rigid dead centre and not at it [m].
        heat: shift by heat [m].
        shift: sum of all shifts, positive upwards [m].
        lowest: lowest possible shift, with undetermined bearings and stiffnesses at the ends of their ranges [m].
        highest: highest possible shift, with the same at their other ends [m].
        rise: shift - shift in the first condition, in which the press is set [m].
    """

    speed: float
    condition: str
    clearances: float
    springs: float
    crank: float
    heat: float
    shift: float
    lowest: float
    highest: float
    rise: float


@dataclass(frozen=True, eq=False, repr=False)
class AccuracyBudget(OfPress, Tabular):
    """Shifts of the bottom dead centre of a press by their causes. Positive shifts are upwards.

    Attributes:
        press_name: name of the press.
        coordinate: what the coordinate of the driver is.
        conditions: bottom dead centre in every condition; the press is set in the first one.
        machining: scatter of the bottom dead centre with the dimensions of the press; None if not given.
    """

    _press: Linkage
    coordinate: DriverCoordinate
    conditions: Records[BottomCondition]
    machining: DeadCentreScatter | None

    @property
    def worst(self) -> BottomCondition:
        """The condition with the largest rise."""
        return max(self.conditions, key=lambda condition: abs(condition.rise))

    @property
    def largest_rise(self) -> float:
        """Largest rise of bottom dead centre, positive upwards [m]."""
        return self.worst.rise

    @property
    def decides(self) -> str:
        """The cause of most of the largest rise: "clearances", "springs" or "heat"."""
        return max(PARTS, key=lambda part: abs(self.change(part)))

    def change(self, part: str) -> float:
        """Contribution of a cause to the largest rise [m]."""
        return float(getattr(self.worst, part) - getattr(self.conditions[0], part))

    @property
    def title(self) -> str:
        return f"AccuracyBudget of {self.press_name}: bottom dead centre rises by {self.largest_rise:+.4g} m at most"

    def columns(self) -> dict[str, Column]:
        """A row for each condition."""
        return self.conditions.columns()


@typed
def budget(
    press: Linkage,
    *,
    speeds: ArrayLike,
    clearance: Mapping[str, float | GuideClearance] | None = None,
    stiffness: Stiffness | None = None,
    temperatures: Temperatures | None = None,
    loads: Sequence[Load] = (),
    process: float = 0.0,
    machining: DeadCentreScatter | None = None,
    known_to: float = KNOWN_TO,
    stiffness_known_to: float = 0.1,
) -> AccuracyBudget:
    """Compute the shifts of a press's bottom dead centre over speed, process and temperature, by their causes.

    Args:
        press: a press with one crank and a slide.
        speeds: (S,) speeds of the crank [rad/s]; the press is set at the first one.
        clearance: clearances of the bearings, as in `play`; None: no clearances.
        stiffness: stiffnesses of the parts, as in `elasticity.compliance`; None: rigid.
        temperatures: temperatures of the links of the warm press, as in `heat`; None: the press stays cold.
        loads: loads that always act, such as a balance cylinder.
        process: force of the process on the slide at bottom dead centre, e.g. in coining; positive resists the working stroke [N]. Use 0 if
            the process has ended before, as in blanking.
        machining: result of `bottom_dead_centre`, shown next to the other shifts.
        known_to: relative uncertainty of masses and loads, as in `play` [-].
        stiffness_known_to: relative uncertainty of stiffnesses, all at their worst at once [-].

    Raises:
        PinpressError: neither clearance nor stiffness nor temperatures are given, a speed is zero or not finite, the slide is lowest more
            than 6 degrees from the rigid dead centre, the driver slides, or machining belongs to another press; also as `play`, `heat` and
            `elasticity.slide_deflection`.
        UnknownNameError: as these functions.
        SingularityError: the linkage locks.
    """
    press.refuse_several_drivers("budget needs a press with one crank; bottom_dead_centre and play take a motion of several")
    press.refuse_sliding_driver("budget needs a press with a crank")
    if clearance is None and stiffness is None and temperatures is None:
        raise PinpressError("budget has nothing that moves the dead centre: give clearance, stiffness or temperatures")
    if machining is not None and not is_same_press(machining._press, press):
        its = told_apart(machining._press, press)
        raise PinpressError(f"machining is the scatter of {its}: give the scatter of {press.name}, bottom_dead_centre(press, ...)")
    crank_speeds = np.atleast_1d(numbers("speeds", speeds, unit="rad/s"))
    if crank_speeds.ndim != 1 or not len(crank_speeds) or not np.all(np.abs(crank_speeds) >= SLOWEST):
        raise PinpressError("speeds has no value, or a speed of zero: give speeds of the crank, first that for setting the press [rad/s]")
    doubt = number("stiffness_known_to", stiffness_known_to, "-")
    if not 0.0 <= doubt < 1.0:
        raise PinpressError(f"stiffness_known_to is {doubt:g}: give a share from 0 to below 1, e.g. 0.1 for stiffnesses known to 10 %")
    force = number("process", process, "N")
    if not abs(force) <= LARGEST:
        raise PinpressError(f"process is {force:g} N: give the force at bottom dead centre, at most {LARGEST:g} N")
    doubt_speeds(press, crank_speeds)
    plausibility.forces("process", abs(force), GRAVITY * float(press.model.inertias[press.slide_guide.joint + 1].mass))
    warm = 0.0 if temperatures is None else heat(press, temperatures).bottom_shift
    conditions: list[BottomCondition] = []
    for speed in map(float, crank_speeds):
        states = [_bottom(press, speed, loads, clearance, stiffness, known_to, doubt)]
        if force:
            pushed = [*loads, force_on_slide(press, force)]
            states.append(replace(_bottom(press, speed, pushed, clearance, stiffness, known_to, doubt), condition="process"))
        if temperatures is not None:
            cold = states[-1]
            ends = {name: getattr(cold, name) + warm for name in ("shift", "lowest", "highest")}
            states.append(replace(cold, condition=f"{cold.condition}, warm", heat=warm, **ends))
        first = conditions[0] if conditions else states[0]
        conditions += (replace(state, rise=state.shift - first.shift) for state in states)
    return AccuracyBudget(press, press.driver_coordinates[0], Records(BottomCondition, conditions), machining)


def _bottom(
    press: Linkage,
    speed: float,
    loads: Sequence[Load],
    clearance: Mapping[str, float | GuideClearance] | None,
    stiffness: Stiffness | None,
    known_to: float,
    stiffness_known_to: float,
) -> BottomCondition:
    """Bottom dead centre of the cold press at a speed, under loads, with no rise."""
    centres = dead_centres(press)
    angles = centres.bottom_angle + np.linspace(-WINDOW, WINDOW, STATES)
    motion = servo_cycle(press, angles if speed > 0 else angles[::-1], speed=speed)
    rigid = motion.slide_position - motion.slide_position[STATES // 2]
    offset = low = high = deflection = doubt = np.zeros(STATES)
    if clearance is not None:
        placed = play(press, motion, clearance, loads, known_to=known_to)
        offset, low, high = placed.offset, placed.lowest, placed.highest
    if stiffness is not None:
        deflected = slide_deflection(press, motion, stiffness, loads=loads)
        deflection, largest = deflected.deflection, float(np.abs(deflected.deflection).max())
        if largest > 0.5 * centres.stroke:  # first order does not hold
            raise PinpressError(
                f"the springs of {press.name} deflect by {1e3 * largest:.3g} mm at {speed:.5g} rad/s, but the stroke is only"
                f" {1e3 * centres.stroke:.3g} mm: check stiffnesses [N/m], speed and loads"
            )
        doubt = stiffness_known_to * np.sum([np.abs(part) for part in deflected.parts.values()], axis=0)
    lowest = int((rigid + offset + deflection).argmin())
    if lowest in (0, STATES - 1):
        raise PinpressError(
            f"the slide of {press.name} is lowest more than 6 deg from its rigid bottom dead centre at {speed:.5g} rad/s: check"
            " stiffnesses and loads"
        )
    parts = {"clearances": float(offset[lowest]), "springs": float(deflection[lowest]), "crank": float(rigid[lowest])}
    return BottomCondition(
        speed=speed,
        condition="idle",
        **parts,
        heat=0.0,
        shift=sum(parts.values()),
        lowest=float((rigid + low + deflection - doubt).min()),
        highest=float((rigid + high + deflection + doubt).min()),
        rise=0.0,
    )
