"""Results of the best motion of a servo press: the motion, its proof, the active limits, and the servo motor that follows it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..common.quantities import Array
from ..common.results import Record, Records, Tabular
from ..drives.motors import ServoMotor
from ..dynamics.reactions import Reactions
from ..linkage.linkage import Linkage, OfPress
from .drive import ServoDrive
from .motion import ServoMotion
from .paths import Path

UNITS = {"heat": "N2 m2 s", "time": "s", "energy": "J", "peak": "N m"}
FOLLOWED = 125.0  # default natural frequency of the control of `MotionOptimum.program`, as a multiple of the cycle's frequency


@dataclass(frozen=True, repr=False)
class ActiveLimit(Record, units={"begins_at": "rad", "ends_at": "rad"}):
    """A limit that is active in a best motion, with its price.

    Attributes:
        limit: the limit as text.
        price: by how much the objective falls for each unit by which the limit is relaxed.
        price_unit: unit of the price.
        gain: saving in % of the objective if the limit is relaxed by 1 %, to first order.
        begins_at: first crank angle of the path at which the limit is active [rad].
        ends_at: last crank angle of the path at which the limit is active [rad].
    """

    limit: str
    price: float
    price_unit: str
    gain: float
    begins_at: float
    ends_at: float


@dataclass(frozen=True, eq=False, repr=False)
class MotionOptimum(OfPress, Tabular):
    """The best motion of a press along a path, and the proof that no motion is better.

    The program's motion has a constant acceleration between its nodes. ``motion`` is the same motion by full inverse dynamics, with states
    between the nodes.

    Attributes:
        press_name: name of the press.
        minimise: the weight of each minimised quantity [-]: "heat" [N2 m2 s], "time" [s], "energy" [J], "peak" [N m].
        path: where the crank goes.
        drive: the drive, with the best gear ratio if several were tried.
        value: objective of the motion, computed from the motion and not by the solver.
        bound: dual cost of the program: no motion along these nodes that keeps the limits has a lower objective. The program limits the
            mean torque and mean power of each segment. If they are limited between nodes too, the gap includes the cost of that. If a
            faster turn would need less, the gap refers to a coarser path, see the notes.
        limits: the active limits, with their prices.
        missed: largest share by which the motion exceeds a limit, between nodes too, by full inverse dynamics [-].
        node_error: estimated change of the objective with finer nodes, as a share, from the values with half and (of many nodes) a quarter
            of the nodes [-]. No motion is better than this one by much more than gap and node_error together.
        deviation: (heat by full inverse dynamics, between nodes too) / (heat of the program) - 1 [-]. It falls with the square of the
            number of points.
        notes: what is not proved, and other remarks.
        angle: (N + 1,) crank angles of the nodes [rad].
        speed: (N + 1,) speeds of the crank at the nodes [rad/s].
        time: (N + 1,) times at which the crank passes a node, or leaves it after a rest [s].
        motion: the motion and what it needs from the drive, by full inverse dynamics.
        reactions: the reactions of the motion.
        by_ratio: gear ratio -> objective, for all ratios tried, with the heat at the motor's shaft; infinite if no motion keeps the limits.
    """

    _press: Linkage
    minimise: Mapping[str, float]
    path: Path
    drive: ServoDrive
    value: float
    bound: float
    limits: Records[ActiveLimit]
    missed: float
    node_error: float
    deviation: float
    notes: tuple[str, ...]
    angle: Array
    speed: Array
    time: Array
    motion: ServoMotion
    reactions: Reactions
    by_ratio: Mapping[float, float]
    _stiff: float

    @property
    def gap(self) -> float:
        """(value - bound) / value: no motion along the same nodes is better by more than this share [-]."""
        return (self.value - self.bound) / max(abs(self.value), 1e-300)

    @property
    def title(self) -> str:
        wanted = " and ".join(self.minimise)
        return (
            f"MotionOptimum of {self.press_name}: least {wanted}, {self.motion.duration:.6g} s a cycle, torque at the crank"
            f" {self.motion.rms_torque:.6g} N m rms, proved to {max(self.gap, 0.0):.1e}, error of the nodes {self.node_error:.1e}"
        )

    def columns(self) -> dict[str, Array]:
        """The columns of the motion."""
        return self.motion.columns()

    def program(self, *, stiffness: float | None = None, damping: float | None = None) -> ServoMotor:
        """A servo motor that follows the motion, for `simulate`. Its program has the cycle and one cycle before and after it.

        The angle of its shaft is the crank angle times the gear ratio. So drive the press by ``Geared(best.program(), best.drive.ratio)``,
        from crank angle ``best.angle[0]`` at the speed ``best.speed[0]``. Add ``Flywheel(best.drive.gear_inertia)`` if the gears have
        inertia. The motor does not include the drag of the drive.

        Args:
            stiffness: stiffness of the control, at the motor's shaft [N m/rad]; None: its natural frequency is 125 times that of the cycle.
            damping: damping of the control, at the motor's shaft [N m s/rad]; None: critical damping.
        """
        ratio = self.drive.ratio
        frequency = 2.0 * np.pi * FOLLOWED / self.motion.duration
        stiff = self._stiff * frequency**2 / ratio**2 if stiffness is None else stiffness
        damp = 2.0 * self._stiff * frequency / ratio**2 if damping is None else damping
        time, angle = self.motion.time, self.motion.angle
        kept = np.append(True, np.diff(time) > 1e-6 * self.motion.duration)
        time, angle = time[kept], angle[kept]
        way, period = angle[-1] - angle[0], time[-1] - time[0]
        times = np.concatenate([time[:-1] - period, time[:-1], time + period])
        angles = np.concatenate([angle[:-1] - way, angle[:-1], angle + way])
        peak = 10.0 * self.motion.peak_motor_torque if self.drive.peak_torque is None else 2.0 * self.drive.peak_torque
        return ServoMotor(times, ratio * angles, stiff, damp, peak, self.drive.inertia, self.drive.rated_torque)


@dataclass(frozen=True, repr=False)
class TradeOffPoint(
    Record,
    units={
        "time": "s",
        "strokes_per_minute": "1/min",
        "rms_motor_torque": "N m",
        "peak_motor_torque": "N m",
        "peak_power": "W",
        "energy_drawn": "J",
        "gap": "-",
        "node_error": "-",
    },
):
    """The best motion for one time of a cycle. If no motion keeps the limits, all except time and strokes_per_minute are None.

    Attributes:
        time: largest time of a cycle [s].
        strokes_per_minute: parts made in a minute at this time [1/min].
        rms_motor_torque: rms torque at the motor's shaft [N m].
        peak_motor_torque: largest torque at the motor's shaft [N m].
        peak_power: largest power of a segment: mean torque x mean speed [W].
        energy_drawn: energy drawn in a cycle [J].
        gap: no motion along the same nodes is better by more than this share [-].
        node_error: estimated change of the objective with finer nodes, as a share [-].
    """

    time: float
    strokes_per_minute: float
    rms_motor_torque: float | None
    peak_motor_torque: float | None
    peak_power: float | None
    energy_drawn: float | None
    gap: float | None
    node_error: float | None
