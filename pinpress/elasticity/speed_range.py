"""An elastic press over its range of speeds: the speeds at which orders of the stroke meet natural frequencies, and the strokes themselves.

At constant speed all forces repeat with the stroke. Their harmonics, the orders, have 1, 2, 3, ... times the stroke's frequency. If an
order meets a natural frequency, the press resonates. The Campbell diagram shows both over the speed, but not how strongly an order excites
the press. The strokes show this: each is the steady state of the elastic press at one speed, under its loads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import rising_speeds, typed, whole_number
from ..common.errors import SimulationError
from ..common.frozen import FrozenMapping, read_only
from ..common.quantities import RPM, Array
from ..common.results import Record, Records, Tabular
from ..drives.transmission import Flywheel, PrescribedSpeed
from ..dynamics.inverse_dynamics import NONE_GIVEN
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Load
from ..simulation.elastic.description import Elastic
from ..simulation.elastic.run import ElasticRun
from ..simulation.steady_state import steady_state_near
from .vibration import ElasticModes, natural_frequencies

MOST_ORDERS = 10_000  # most orders of a diagram, to keep its lists finite
TOLERANCE = 1e-3  # error of a coordinate / largest deflection; the relative error of peaks is about a hundred times smaller
STATES = 720  # states of a turn in which the force on the frame is computed


@dataclass(frozen=True, repr=False)
class Resonance(Record, units={"speed": "rad/s", "slowest": "rad/s", "fastest": "rad/s"}):
    """An order that meets a natural frequency in a range of speeds.

    Attributes:
        mode: number of the mode; the lowest mode is 1.
        order: order of the harmonic; 1 is the frequency of the stroke.
        speed: crank speed at which the order meets the mean of the natural frequency over the turn [rad/s].
        slowest: lowest crank speed at which the order meets the natural frequency anywhere in the turn [rad/s].
        fastest: highest such crank speed [rad/s].
    """

    mode: int
    order: int
    speed: float
    slowest: float
    fastest: float


@dataclass(frozen=True, eq=False, repr=False)
class CampbellDiagram(OfPress, Tabular):
    """Natural frequencies and the orders of the strokes over the speed of the crank. All arrays are read-only.

    The frequencies change with the crank angle, but not with the speed: so each mode is a band.

    Attributes:
        press_name: name of the press.
        modes: the natural frequencies over a period.
        speed: (s,) speeds of the crank [rad/s].
        orders: number of orders.
        resonances: orders that meet a natural frequency between the lowest and the highest speed, by falling speed.
        turns: turns of the crank in a period; the orders are harmonics of the period.
    """

    _press: Linkage
    modes: ElasticModes
    speed: Array
    orders: int
    resonances: Records[Resonance]
    turns: int

    @property
    def title(self) -> str:
        low, high = self.speed[0], self.speed[-1]
        return f"CampbellDiagram of {self.press_name}: {len(self.resonances)} resonances from {low:.4g} to {high:.4g} rad/s"

    def columns(self) -> dict[str, Array]:
        """A row for each mode: the least, mean and largest natural frequency over the period."""
        frequency = self.modes.natural_frequency
        columns = {"mode": np.arange(1, frequency.shape[1] + 1)}
        return columns | {
            "lowest_frequency [rad/s]": frequency.min(axis=0),
            "mean_frequency [rad/s]": frequency.mean(axis=0),
            "highest_frequency [rad/s]": frequency.max(axis=0),
        }

    def order_frequency(self, order: int) -> Array:
        """(s,) angular frequency of an order at each speed [rad/s]."""
        return np.asarray(self.speed * order / self.turns)


@typed
def campbell(press: Linkage, elastic: Elastic, *, speeds: ArrayLike, orders: int = 20, flywheel: Flywheel | None = None) -> CampbellDiagram:
    """Find the speeds at which orders of the stroke meet natural frequencies of an elastic press (Campbell diagram).

    Args:
        press: a press with one driver that turns fully.
        elastic: the elastic parts, as for `simulate`.
        speeds: (s,) speeds of the crank, positive and rising [rad/s].
        orders: number of orders, 1 to 10 000.
        flywheel: as for `natural_frequencies`.

    Raises:
        PinpressError: as `natural_frequencies`, or the speeds or orders are not as described.
    """
    speed = rising_speeds("speeds", speeds)
    count = whole_number("orders", orders, 1, MOST_ORDERS)
    modes = natural_frequencies(press, elastic, flywheel=flywheel)
    turns, frequency = press.period_turns or 1, modes.natural_frequency
    order = np.arange(1, count + 1)[:, None] / turns
    slowest, mean, fastest = frequency.min(axis=0) / order, frequency.mean(axis=0) / order, frequency.max(axis=0) / order
    met = np.argwhere((fastest >= speed[0]) & (slowest <= speed[-1]))
    resonances = [Resonance(int(m) + 1, int(k) + 1, float(mean[k, m]), float(slowest[k, m]), float(fastest[k, m])) for k, m in met]
    resonances.sort(key=lambda resonance: -resonance.speed)
    return CampbellDiagram(press, modes, read_only(speed), count, Records(Resonance, resonances), turns)


@dataclass(frozen=True, eq=False, repr=False)
class ElasticSpeedResponse(OfPress, Tabular):
    """The periodic strokes of an elastic press at s speeds. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        elastic: the elastic parts.
        speed: (s,) speeds of the crank [rad/s].
        rigid_deepest: bottom dead centre of the rigid press [m].
        deepest: (s,) lowest position of the slide [m].
        deepest_angle: (s,) crank angle at this position [rad].
        peaks: name of a bearing -> (s,) largest force of the bearing [N].
        reverse_force: (s,) largest pull of the linkage on the slide, upwards along the guide's axis [N].
        frame_force: (s,) largest force of linkage, crown and loads on the frame, less the mean force [N].
        drive_torque: (s,) largest torque of the drive, forwards or backwards [N m].
        lost: (s,) work lost in the dampers in a period [J].
    """

    _press: Linkage
    elastic: Elastic
    speed: Array
    rigid_deepest: float
    deepest: Array
    deepest_angle: Array
    peaks: Mapping[str, Array]
    reverse_force: Array
    frame_force: Array
    drive_torque: Array
    lost: Array

    @property
    def title(self) -> str:
        speeds, most = f"{self.speed[0]:.4g} to {self.speed[-1]:.4g} rad/s", self.depth.max()
        return f"ElasticSpeedResponse of {self.press_name}: {len(self.speed)} speeds, {speeds}, slide up to {most:.4g} m too deep"

    @property
    def depth(self) -> Array:
        """(s,) lowest position of the slide below the rigid bottom dead centre [m]."""
        return self.rigid_deepest - self.deepest

    def columns(self) -> dict[str, Array]:
        """A row for each speed."""
        columns = {"speed [rad/s]": self.speed, "depth [m]": self.depth, "deepest [m]": self.deepest}
        columns |= {"deepest_angle [rad]": self.deepest_angle}
        columns |= {f"peak_{name} [N]": values for name, values in self.peaks.items()}
        columns |= {"reverse_force [N]": self.reverse_force, "frame_force [N]": self.frame_force}
        return columns | {"drive_torque [N m]": self.drive_torque, "lost [J]": self.lost}


@typed
def over_speeds(press: Linkage, elastic: Elastic, *, speeds: ArrayLike, loads: Sequence[Load] = ()) -> ElasticSpeedResponse:
    """Find the periodic stroke of an elastic press at each of many constant speeds, idle or under loads.

    The relative error of peaks is about 1e-5.

    Args:
        press: a press with one driver that turns fully.
        elastic: the elastic parts, as for `simulate`.
        speeds: (s,) speeds of the crank, positive and rising [rad/s].
        loads: as in `simulate`; nothing in them may depend on time.

    Raises:
        PinpressError: an argument is not as described; also as `steady_state`.
        SimulationError: the press does not repeat its stroke at one of the speeds, which is named.
    """
    speed = rising_speeds("speeds", speeds)
    runs: list[ElasticRun] = []
    for rate in speed[::-1].tolist():  # a faster stroke has fewer vibrations, so from fast to slow panels are only divided
        runs.insert(0, _stroke(press, elastic, rate, loads, runs[0] if runs else None))
    mean = [np.diff(run.time) @ (run.shaking_force[1:] + run.shaking_force[:-1]) / (2 * run.time[-1]) for run in runs]
    frame = [float(np.linalg.norm(run.shaking_force - about, axis=1).max()) for run, about in zip(runs, mean, strict=True)]

    def each_of(values: Sequence[float]) -> Array:
        return read_only(np.array(values, dtype=float))

    return ElasticSpeedResponse(
        _press=press,
        elastic=elastic,
        speed=read_only(speed),
        rigid_deepest=dead_centres(press).bottom_position,
        deepest=each_of([run.deepest for run in runs]),
        deepest_angle=each_of([run.deepest_angle for run in runs]),
        peaks=FrozenMapping({name: each_of([run.peaks[name] for run in runs]) for name in press.bearings}),
        reverse_force=each_of([run.reverse_force for run in runs]),
        frame_force=each_of(frame),
        drive_torque=each_of([float(np.abs(run.drive_torque).max()) for run in runs]),
        lost=each_of([float(run.lost[-1]) for run in runs]),
    )


def _stroke(press: Linkage, elastic: Elastic, speed: float, loads: Sequence[Load], near: ElasticRun | None) -> ElasticRun:
    """The stroke at a speed, starting from the stroke at another speed; raises `SimulationError` that names the speed."""
    drive, points = PrescribedSpeed(speed), STATES * (press.period_turns or 1) + 1
    try:
        run = steady_state_near(near, press, speed, 0.0, drive, None, loads, NONE_GIVEN, points, elastic, TOLERANCE)
    except SimulationError as error:
        raise SimulationError(f"at {speed / RPM:.5g} r/min: {error.args[0]}", error.time, error.crank_angle, error.reason) from error
    assert isinstance(run, ElasticRun)
    return run
