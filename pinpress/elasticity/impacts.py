"""What a pin with clearance does turn by turn: the journal's orbit, its impacts, their spread, and an estimate of the wear.

A journal that loses contact strikes again in every turn, and small differences grow from impact to impact. Single peaks then mean little;
what repeats is their distribution over many turns and many starts.
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
from ..simulation.elastic.states import journal_places, solution_states
from ..simulation.elastic.yielding import bearing_number
from ..simulation.simulate import simulate

PLACES = 24  # on a panel, at which orbit, forces and wear are read
OF_TURN = ("start", "turn", "peak", "depth", "impacts", "flight")


@dataclass(frozen=True, eq=False, repr=False)
class ImpactsByTurn(OfPress, Tabular):
    """A pin with clearance over the whole turns of one or several runs. All arrays are read-only.

    Attributes:
        press_name: name of the linkage.
        bearing: name of the pin.
        radial: its radial clearance [m].
        start: (t,) number of the run that each turn belongs to, from 0.
        turn: (t,) number of the turn in its run, from 0.
        peak: (t,) largest force of the turn [N].
        depth: (t,) largest depth of the journal in the bearing [m].
        impacts: (t,) number of times that the journal touches the bearing after a flight.
        flight: (t,) share of the turn in which it does not touch [-].
        orbit: (m, 2) places of the journal's centre from that of the bearing, in the two axes of the plane, over the first run [m].
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
        run: of at least one whole turn, from `simulate` with clearances.
        bearing: name of the pin.

    Raises:
        PinpressError: the run has no whole turn, or the pin no clearance.
        UnknownNameError: the linkage has no such bearing.
    """
    return _joined([_of_run(run, bearing, 0, 0)])


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
    """The impacts of a pin with clearance over many turns from several starts, whose crank angles differ.

    Where the motion is chaotic, their distribution is what means something.

    Args:
        press: a press with one driver.
        elastic: an `Elastic` with a clearance of this pin.
        bearing: name of the pin.
        speed: of the crank [rad/s].
        turns: counted turns of each run.
        settling: turns before them that are not counted.
        starts: number of runs.
        loads: as in `simulate`.

    Raises:
        PinpressError: a number is out of range; else as `simulate`.
        UnknownNameError: the linkage has no such bearing.
    """
    counts = whole_number("turns", turns, 1, 10_000), whole_number("settling", settling, 0, 10_000)
    rate, runs = number("speed", speed, "rad/s"), []
    if not rate:
        raise PinpressError("speed is 0: give the speed of the crank [rad/s]")
    if not isinstance(elastic, Elastic):
        raise PinpressError(f"elastic is {shown(elastic)}: give an Elastic with a clearance of {shown(bearing)}")
    turn = 2 * np.pi / abs(rate)
    for start in range(whole_number("starts", starts, 1, 10_000)):
        angle = 2 * np.pi * start / starts
        run = simulate(press, sum(counts) * turn, angle=angle, drive=PrescribedSpeed(rate), loads=loads, elastic=elastic)
        assert isinstance(run, ElasticRun)
        runs.append(_of_run(run, bearing, start, counts[1]))
    return _joined(runs)


@typed
def wear_depth(run: ElasticRun, bearing: str, *, radius: float, width: float, hardness: float, coefficient: float) -> float:
    """Estimate the mean depth that wears off the bearing of a pin in an hour, by Archard's law [m/h].

    The worn volume is coefficient x sum of force x sliding way / hardness (Archard 1953), spread over the bearing's surface 2 pi radius
    width. The coefficient scatters by a factor of ten with lubrication and dirt: the result compares designs, it does not predict the life.

    Args:
        run: an elastic run, or steady state.
        bearing: name of the pin.
        radius: of the journal [m].
        width: of the bearing [m].
        hardness: of the softer part [N/m2]; 1e9 for bronze of about 100 HB.
        coefficient: Archard's wear coefficient k [-]; 1e-8 to 1e-6 where a film lubricates, 1e-4 and more where it is dry.

    Raises:
        PinpressError: a number is not positive, or the bearing is a guide.
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
    times, weights = _even(segment)
    states = segment.states(times)
    sprung = segment.solution.equations.sprung
    if not isinstance(sprung.geometry, PlaneGeometry):
        raise PinpressError(f"{press.name} moves in space: wear is estimated for pins of planar presses alone")
    first, second = bodies_of(sprung, place)
    rates = states.bodies.rates
    sliding = np.abs(rates[:, 3 * second + 2] - rates[:, 3 * first + 2]) * r
    force = np.linalg.norm(states.forces.in_bearings[place], axis=1)
    volume = k / h * float(weights @ (force * sliding))
    return volume / (2 * np.pi * r * w) * 3600 / segment.end


def _of_run(run: ElasticRun, bearing: str, number_of_run: int, settling: int) -> ImpactsByTurn:
    segment, press = _segment(run), run.problem.driven.press
    pin = _open_pin(segment, press, bearing)
    panels, share = segment.steps, np.linspace(0.0, 1.0, PLACES + 1)
    states = solution_states(segment.solution, np.repeat(np.arange(panels), len(share)), np.tile(share, panels))
    angle = states.crank[0]
    gone = np.abs(angle - angle[0]) / (2 * np.pi)
    turns = int(np.floor(gone[-1] + 1e-9))
    if turns - settling < 1:
        raise PinpressError(f"the run of {segment.end:g} s has {turns} whole turns: give one with more than {settling}")
    gap = journal_places(segment.solution.equations.sprung, pin, states.bodies)
    force = np.linalg.norm(states.forces.in_bearings[pin.bearing], axis=1)
    turn = np.where(gone < turns + 1e-9, np.minimum(gone, turns - 1e-9), gone).astype(int)
    touching = np.abs(gap) > pin.clearance.radial
    rows = []
    for count in range(settling, turns):
        in_turn = turn == count
        lengths = np.where(in_turn[1:] & in_turn[:-1], np.diff(states.times), 0.0)
        flying = float(lengths[~touching[1:]].sum() / lengths.sum())
        struck = gone[1:][in_turn[1:] & touching[1:] & ~touching[:-1]]
        # Touches within a ten-thousandth of a turn are one impact.
        impacts = int(len(struck) and 1 + (np.diff(struck) > 1e-4).sum())
        depth = float(np.abs(gap[in_turn]).max()) - pin.clearance.radial
        rows.append((number_of_run, count, float(force[in_turn].max()), depth, impacts, flying))
    columns = {name: read_only(np.array(column)) for name, column in zip(OF_TURN, zip(*rows, strict=True), strict=True)}
    orbit = np.stack([gap.real, gap.imag], axis=1)[turn >= settling]
    return ImpactsByTurn(press, bearing, pin.clearance.radial, orbit=read_only(orbit), **columns)


def _joined(parts: Sequence[ImpactsByTurn]) -> ImpactsByTurn:
    """All turns of several runs."""
    columns = {name: read_only(np.concatenate([getattr(part, name) for part in parts])) for name in OF_TURN}
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


def _even(segment: ElasticSegment) -> tuple[Array, Array]:
    """Times (n,) of a segment on all of its panels, and the weights (n,) of the trapezoidal rule over them."""
    times = np.linspace(0.0, segment.end, max(721, PLACES * segment.steps + 1))
    weights = np.full(len(times), times[1])
    weights[[0, -1]] *= 0.5
    return times, weights
