"""A press, what drives it and what it works against, as both methods of simulation see it.

Every force from outside acts along a coordinate of the linkage (see `force_coordinates`): a process load along the slide's position, a
spring along its length, a constant force along the path of its point.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common import plausibility
from ..common.checks import numbers
from ..common.errors import PinpressError, SimulationError, shown
from ..drives.transmission import Drive, Flywheel, PrescribedSpeed
from ..dynamics import applied_loads as forces
from ..kinematics.dead_centres import dead_centres
from ..kinematics.motion import carried
from ..linkage.linkage import Linkage
from ..loads import caller_laws
from ..loads.link import Load, PointForce, SpringDamper
from ..loads.process import ProcessLoad, Stretch, TimeForce
from .force_coordinates import Coordinate, Length, Path, SlidePosition
from .protocol_checks import check_drive, check_load
from .reduced_model import COORDINATES, roots, tabulated

if TYPE_CHECKING:
    pass

THIN = 1e-8  # stretch of a load, in lengths of the linkage, that its crank angle still tells apart


@dataclass(frozen=True, eq=False)
class Acting:
    """A force along a coordinate of the scene.

    Attributes:
        row: of the coordinate. datum: its value from which the stretches count [m].
        rising, falling: what acts while the coordinate rises, and falls; the same object where that does not matter.
        time: the force as a function of time in place of these; edges: instants at which that is not smooth.
        drive: of which it is the torque, None where it is a load.
    """

    row: int
    datum: float
    rising: tuple[Stretch, ...] = ()
    falling: tuple[Stretch, ...] = ()
    time: Callable[[Any], Any] | None = None
    edges: tuple[float, ...] = ()
    drive: Drive | None = None

    def stretches(self, rising: bool) -> tuple[Stretch, ...]:
        return self.rising if rising else self.falling

    def borders(self) -> tuple[float, ...]:
        """Values of the coordinate at which the force is not smooth."""
        ends = {end for stretch in self.rising + self.falling for end in (stretch.lower, stretch.upper)}
        return tuple(sorted(self.datum + end for end in ends if math.isfinite(end)))


@dataclass(frozen=True, eq=False)
class Scene:
    """What is simulated.

    Attributes:
        press: the linkage. drive: what turns its driver joint, None for nothing.
        inertia: of flywheel and drive at the driver joint, a number or (S,) for S scenarios [kg m2].
        coordinates: along which forces act; that of the slide, if there is one, comes first. forces: the forces.
    """

    press: Linkage
    drive: Drive | PrescribedSpeed | None
    inertia: Any
    coordinates: tuple[Coordinate, ...]
    forces: tuple[Acting, ...]


def build(press: Linkage, drive: Drive | PrescribedSpeed | None, flywheel: Flywheel | None, loads: Sequence[Load]) -> Scene:
    """The scene of a simulation.

    Raises:
        PinpressError: a load that is none, or cannot be simulated; heights to be measured from a bottom dead centre that is not there.
        UnknownNameError: a load on a link that the linkage does not have.
    """
    listed(loads)
    coordinates: list[Coordinate] = [] if press.slide is None else [SlidePosition(*press.slide_guide)]
    acting: list[Acting] = []
    if drive is not None and not isinstance(drive, PrescribedSpeed):
        check_drive(drive)
    for load in loads:
        if isinstance(load, PointForce):
            coordinate, act = _point(press, load, len(coordinates))
        elif isinstance(load, SpringDamper):
            coordinate, act = _spring(press, load, len(coordinates))
        elif isinstance(load, TimeForce):
            check_load(load)
            coordinate, act = None, Acting(_slide(press), 0.0, time=load.force, edges=tuple(load.edges))
        elif isinstance(load, ProcessLoad) and not isinstance(load, type):
            coordinate, act = None, _process(press, load)
        else:
            raise PinpressError(f"load {shown(load)} is none: give a PointForce, a SpringDamper or one of pinpress.loads")
        if coordinate is not None:
            coordinates.append(coordinate)
        if act is not None:
            acting.append(act)
    inertia = 0.0 if flywheel is None else flywheel.inertia
    if drive is not None and not isinstance(drive, PrescribedSpeed):
        inertia = inertia + drive.inertia
    return Scene(press, drive, inertia, tuple(coordinates), tuple(acting))


def listed(loads: object) -> None:
    """Raise PinpressError where loads are no list."""
    if isinstance(loads, Load) and not isinstance(loads, type):
        raise PinpressError(f"loads is one {type(loads).__name__}: give a list, loads=[...]")
    if not isinstance(loads, list | tuple):
        raise PinpressError(f"loads is {shown(loads)}: give a list, loads=[...]")


def driving(row: int, drive: Drive) -> Acting:
    """The torque of a drive along the angle of its joint, coordinate ``row``."""

    def torque(angle: Any, speed: Any) -> Any:
        return drive.torque(speed)

    always = (Stretch(math.inf, -math.inf, torque),)
    return Acting(row, 0.0, always, always, drive=drive)


def _slide(press: Linkage) -> int:
    """Row of the slide's position.

    Raises:
        PinpressError: the linkage has no slide.
    """
    _ = press.slide_guide
    return 0


def _process(press: Linkage, load: ProcessLoad) -> Acting | None:
    check_load(load)
    rising, falling = load.stretches(downwards=False), load.stretches(downwards=True)
    row = _slide(press)
    if not rising and not falling:
        return None
    low, high = _turning_points(press, load)
    datum = low if load.datum is None else load.datum
    plausibility.heights(
        caller_laws.name(load),
        [(stretch.lower, stretch.upper) for stretch in (*rising, *falling)],
        low - datum,
        high - datum,
        press.size,
    )
    least = THIN * press.size
    for stretch in (*rising, *falling):
        if stretch.upper - stretch.lower < least:
            raise PinpressError(
                f"{caller_laws.name(load)}: a stretch of {stretch.upper - stretch.lower:g} m is thinner than a simulation resolves;"
                f" give at least {least:.2g} m"
            )
    rising, falling = tuple(rising), tuple(falling)
    return Acting(row, datum, rising, rising if _same(rising, falling) else falling)


def _same(some: tuple[Stretch, ...], others: tuple[Stretch, ...]) -> bool:
    """Whether stretches are the same, so that the way the slide goes does not matter."""

    def key(stretch: Stretch) -> tuple[Any, ...]:
        law = stretch.force.call if isinstance(stretch.force, caller_laws.Law) else stretch.force
        parts = (law.func, *map(id, law.args)) if isinstance(law, partial) else (law,)
        return stretch.upper, stretch.lower, stretch.one_sided, *parts

    return [key(stretch) for stretch in some] == [key(stretch) for stretch in others]


def _turning_points(press: Linkage, load: ProcessLoad) -> tuple[float, float]:
    """Slide positions of bottom and top dead centre; of a slide without them, which a load with a datum does not need, no ends at all.

    Raises:
        PinpressError: there is no bottom dead centre to measure the load's heights from.
    """
    name, everywhere = caller_laws.name(load), (-math.inf, math.inf)
    if len(press.drivers) > 1 or press.passage.period is None:
        if load.datum is not None:
            return everywhere
        raise PinpressError(
            f"{name}: {press.name} does not turn fully with one driver, so that there is no bottom dead centre to measure heights from;"
            " give datum=, a slide position [m]"
        )
    try:
        table, row = tabulated(press), COORDINATES + _slide(press)
    except SimulationError:  # its shafts do not come back together: no table, but dead centres all the same
        return everywhere if load.datum is not None else (dead_centres(press).bottom_position, dead_centres(press).top_position)
    turns = roots(table, row, 0.0, slope=True)
    if not len(turns) and load.datum is not None:
        return everywhere
    if not len(turns):
        raise PinpressError(f"{name}: the slide of {press.name} does not turn back; give datum=, a slide position [m]")
    position = carried(press, turns, 1.0).slide_position  # exact, for stiff dies
    return float(position.min()), float(position.max())


def _point(press: Linkage, load: PointForce, row: int) -> tuple[Coordinate | None, Acting | None]:
    what = f"load on {shown(load.link)}"
    joint, point = forces.place(press, load.link, load.point, what, "point")
    if callable(load.force) or np.ndim(load.force) != 1:
        raise PinpressError(
            f"{what}: a simulation takes a constant force, (3,) in world axes [N]; for one that changes write one of pinpress.loads,"
            " or a class with their members `datum` and `stretches`"
        )
    force = numbers(f"{what}: force", load.force)
    if force.shape != (3,):
        raise PinpressError(f"{what}: force has shape {force.shape}; give (3,), in world axes [N]")
    if not joint:  # on the frame, which does not move
        return None, None
    constant = (Stretch(math.inf, -math.inf, _one),)
    return Path((joint, point), force), Acting(row, 0.0, constant, constant)


def _one(position: Any, velocity: Any) -> Any:
    return position * 0.0 + 1.0


def _spring(press: Linkage, load: SpringDamper, row: int) -> tuple[Coordinate, Acting]:
    def push(length: Any, rate: Any) -> Any:
        return load.stiffness * (load.free_length - length) - load.damping * rate

    always = (Stretch(math.inf, -math.inf, push),)
    return Length(*forces.spring_ends(load, press)), Acting(row, 0.0, always, always)


def not_positive(inertia: float, time: float | None, angle: float) -> SimulationError:
    """The inertia at the crank is zero or less."""
    return SimulationError(
        f"the inertia of linkage, flywheel and drive at the crank is {inertia:.6g} kg m2, so no torque determines the motion;"
        " give masses or a flywheel",
        time,
        angle,
    )


def too_slow(time: float, angle: float) -> SimulationError:
    """A period has not come to its end."""
    return SimulationError("the press does not get through a stroke: the drive is too weak for the load", time, angle)
