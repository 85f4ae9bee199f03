"""A pin with clearance in each turn: the journal's orbit, its impacts and their scatter, and an estimate of the wear.

A journal that loses contact strikes again in every turn, and small differences grow from impact to impact. Single peaks then mean little;
their distribution over many turns and many starts is reproducible.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import number, typed, whole_number
from ..common.errors import PinpressError, shown
from ..common.frozen import read_only
from ..common.quantities import Array
from ..common.results import Tabular
from ..common.tables import Columns
from ..drives.transmission import PrescribedSpeed
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Load
from ..simulation.elastic.contact import OpenPin
from ..simulation.elastic.description import Elastic
from ..simulation.elastic.press.friction import bodies_of
from ..simulation.elastic.press.plane import PlaneGeometry
from ..simulation.elastic.run import ElasticRun, ElasticSegment, segment_of
from ..simulation.elastic.states import SolutionStates, journal_places, solution_states
from ..simulation.elastic.yielding import bearing_number
from ..simulation.simulate import simulate

INTERVALS = 24  # equal intervals of a panel of the solution; orbit, forces and wear are sampled at their ends
TURN_COLUMNS = ("start", "turn", "peak", "depth", "impacts", "flight")  # columns of a turn in `_impacts_by_turn`


@dataclass(frozen=True, eq=False, repr=False)
class ImpactsByTurn(OfPress, Tabular):
    """A pin with clearance in the whole turns of one or several runs. All arrays are read-only.

    Attributes:
        press_name: name of the linkage.
        bearing: name of the pin.
        radial: radial clearance of the pin [m].
        start: (t,) number of the run that each turn belongs to, from 0.
        turn: (t,) number of the turn in its run, from 0; settling turns are counted but not listed.
        peak: (t,) largest force of the turn [N].
        depth: (t,) largest distance of the two centres less the radial clearance [m]; negative if the journal does not touch in the turn.
        impacts: (t,) number of times that the journal touches the bearing after a flight.
        flight: (t,) share of the turn in which the journal does not touch the bearing [-].
        orbit: (m, 2) positions of the journal's centre relative to the bearing's centre, along the two axes of the plane, in the listed
            turns of the first run [m].
    """

    _press: Linkage
    bearing: str
    radial: float
    start: NDArray[np.int_]
    turn: NDArray[np.int_]
    peak: Array
    depth: Array
    impacts: NDArray[np.int_]
    flight: Array
    orbit: Array

    @property
    def mean_peak(self) -> float:
        """Mean of the turns' peaks [N]."""
        return float(self.peak.mean())

    @property
    def spread(self) -> float:
        """Standard deviation of the turns' peaks, as a share of their mean [-]."""
        return float(self.peak.std() / self.peak.mean()) if self.peak.mean() > 0 else 0.0

    @property
    def title(self) -> str:
        return (
            f"ImpactsByTurn of {self.bearing} of {self.press_name}: {len(self.peak)} turns, peaks {self.peak.min():.4g} to"
            f" {self.peak.max():.4g} N"
        )

    def columns(self) -> Columns:
        """A row for each turn."""
        return {
            "start": self.start,
            "turn": self.turn,
            "peak [N]": self.peak,
            "depth [m]": self.depth,
            "impacts": self.impacts,
            "flight [-]": self.flight,
        }


@typed
def journal_impacts(run: ElasticRun, bearing: str) -> ImpactsByTurn:
    """The impacts of a pin with clearance in a run.

    Args:
        run: run of `simulate` with clearances, of at least one whole turn.
        bearing: name of the pin.

    Raises:
        PinpressError: the run has no whole turn, or the pin has no clearance.
        UnknownNameError: the linkage has no such bearing.
    """
    return _joined([_impacts_by_turn(run, bearing, 0, 0)])


@typed
def impact_statistics(
    press: Linkage,
    elastic: Elastic,
    bearing: str,
    *,
    speed: float,
    turns: int = 10,
    settling: int = 2,
    starts: int = 4,
    loads: Sequence[Load] = (),
) -> ImpactsByTurn:
    """The impacts of a pin with clearance over many turns of several runs, whose initial crank angles are evenly spaced over a turn.

    If the motion is chaotic, single impacts mean little, but their distribution does.

    Args:
        press: a press with one driver.
        elastic: an `Elastic` with a clearance of this pin.
        bearing: name of the pin.
        speed: speed of the crank [rad/s].
        turns: counted turns of each run.
        settling: settling turns of each run before the counted turns.
        starts: number of runs.
        loads: as in `simulate`.

    Raises:
        PinpressError: a number is out of range; also as `simulate`.
        UnknownNameError: the linkage has no such bearing.
    """
    counted, settled = whole_number("turns", turns, 1, 10_000), whole_number("settling", settling, 0, 10_000)
    rate, runs = number("speed", speed, "rad/s"), []
    if not rate:
        raise PinpressError("speed is 0: give the speed of the crank [rad/s]")
    if not isinstance(elastic, Elastic):
        raise PinpressError(f"elastic is {shown(elastic)}: give an Elastic with a clearance of {shown(bearing)}")
    duration = (counted + settled) * 2 * np.pi / abs(rate)
    for start in range(whole_number("starts", starts, 1, 10_000)):
        angle = 2 * np.pi * start / starts
        run = simulate(press, duration, angle=angle, drive=PrescribedSpeed(rate), loads=loads, elastic=elastic)
        assert isinstance(run, ElasticRun)
        runs.append(_impacts_by_turn(run, bearing, start, settled))
    return _joined(runs)


@typed
def wear_depth(run: ElasticRun, bearing: str, *, radius: float, width: float, hardness: float, coefficient: float) -> float:
    """Estimate the mean wear depth of a pin's bearing per hour, by Archard's law [m/h].

    The worn volume is coefficient x integral of force over sliding distance / hardness (Archard 1953), spread over the bearing's surface 2
    pi radius width. The coefficient scatters by a factor of ten with lubrication and dirt, so the result can compare designs but cannot
    predict the life.

    Args:
        run: an elastic run, or steady state.
        bearing: name of the pin.
        radius: radius of the journal [m].
        width: width of the bearing [m].
        hardness: hardness of the softer part [N/m2]; 1e9 for bronze of about 100 HB.
        coefficient: Archard's wear coefficient k [-]; 1e-8 to 1e-6 with a lubricating film, 1e-4 and more without lubrication.

    Raises:
        PinpressError: a number is not positive, the bearing is a guide, or the press moves in space.
        UnknownNameError: the linkage has no such bearing.
    """
    sizes = {"radius": (radius, "m"), "width": (width, "m"), "hardness": (hardness, "N/m2"), "coefficient": (coefficient, "-")}
    r, w, h, k = (number(name, value, unit, positive=True) for name, (value, unit) in sizes.items())
    segment = _segment(run)
    press = run.problem.driven.press
    place = bearing_number(press, bearing)
    joints = len(press.joints)
    if place < joints and not press.axes[place].turns:
        raise PinpressError(f"bearing {shown(bearing)} is a guide: its wear is spread over its way; give a pin")
    sprung = segment.solution.equations.sprung
    if not isinstance(sprung.geometry, PlaneGeometry):
        raise PinpressError(f"{press.name} moves in space: wear is estimated for pins of planar presses alone")
    states = _samples(segment)
    first, second = bodies_of(sprung, place)
    rates = states.bodies.rates  # each body has the rates of two coordinates and an angle
    sliding = np.abs(rates[:, 3 * second + 2] - rates[:, 3 * first + 2]) * r
    force = np.linalg.norm(states.forces.in_bearings[place], axis=1)
    volume = k / h * float(np.trapezoid(force * sliding, states.times))
    return volume / (2 * np.pi * r * w) * 3600 / segment.end


def _samples(segment: ElasticSegment) -> SolutionStates:
    """States in equal steps of each panel, with both of its ends. A panel ends where a journal touches or leaves its bearing, so the states
    include both sides of such an instant."""
    share = np.linspace(0.0, 1.0, INTERVALS + 1)
    return solution_states(segment.solution, np.repeat(np.arange(segment.steps), len(share)), np.tile(share, segment.steps))


def _impacts_by_turn(run: ElasticRun, bearing: str, start: int, settling: int) -> ImpactsByTurn:
    """The whole turns of a run, without the first ones; ``start``: number of the run."""
    segment, press = _segment(run), run.problem.driven.press
    pin = _open_pin(segment, press, bearing)
    states = _samples(segment)
    crank_angle, *_ = states.crank
    turned = np.abs(crank_angle - crank_angle[0]) / (2 * np.pi)
    turns = int(np.floor(turned[-1] + 1e-9))
    if turns - settling < 1:
        raise PinpressError(f"the run of {segment.end:g} s has {turns} whole turns: give one with more than {settling}")
    offset = journal_places(segment.solution.equations.sprung, pin, states.bodies)  # complex, relative to the bearing's centre
    force = np.linalg.norm(states.forces.in_bearings[pin.bearing], axis=1)
    depth = np.abs(offset) - pin.clearance.radial
    turn = np.minimum(turned, turns - 1e-9).astype(int)  # the run's last instant belongs to its last whole turn
    turn[turned > turns + 1e-9] = turns
    # contact is decided between two samples, because at the instant of contact rounding errors would decide
    between = np.flatnonzero(np.diff(states.times) > 0)
    lengths, touches, turn_between = np.diff(states.times)[between], depth[between] + depth[between + 1] > 0, turn[between]
    strikes = np.append(False, touches[1:] & ~touches[:-1])
    rows = []
    for count in range(settling, turns):
        in_turn, spans = turn == count, turn_between == count
        flight = float(lengths[spans & ~touches].sum() / lengths[spans].sum())
        rows.append((start, count, float(force[in_turn].max()), float(depth[in_turn].max()), int(strikes[spans].sum()), flight))
    columns = {name: read_only(np.array(column)) for name, column in zip(TURN_COLUMNS, zip(*rows, strict=True), strict=True)}
    orbit = np.stack([offset.real, offset.imag], axis=1)[(turn >= settling) & (turn < turns)]
    return ImpactsByTurn(press, bearing, pin.clearance.radial, orbit=read_only(orbit), **columns)


def _joined(parts: Sequence[ImpactsByTurn]) -> ImpactsByTurn:
    """All turns of several runs."""
    columns = {name: read_only(np.concatenate([getattr(part, name) for part in parts])) for name in TURN_COLUMNS}
    first = parts[0]
    return ImpactsByTurn(first._press, first.bearing, first.radial, orbit=first.orbit, **columns)


def _segment(run: ElasticRun) -> ElasticSegment:
    if not isinstance(run, ElasticRun):
        raise PinpressError(f"run is {shown(run)}: give an ElasticRun, as simulate(..., elastic=...) returns it")
    return segment_of(run)


def _open_pin(segment: ElasticSegment, press: Linkage, bearing: str) -> OpenPin:
    place = bearing_number(press, bearing)
    for pin in segment.solution.equations.sprung.open_pins:
        if pin.bearing == place:
            return pin
    raise PinpressError(f"pin {shown(bearing)} has no clearance in this run: give Elastic(clearances={{{bearing!r}: Clearance(...)}})")
