"""The timing diagram of a press: windows of the crank angle in which the die is open, the strip is fed and the process acts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arguments import positive, suitable_numbers, typed
from ..common.errors import PinpressError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.quantities import RPM, Array
from ..common.results import Records, Tabular
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..kinematics.periodic_curve import step_time
from ..kinematics.slide_windows import AngleWindow, window, windows, windows_where
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Load
from ..loads.process import ProcessLoad
from .applied_loads import acting_between

NO_BARS: Mapping[str, ArrayLike] = FrozenMapping({})


@dataclass(frozen=True, eq=False, repr=False)
class TimingDiagram(OfPress, Tabular):
    """Windows of a period as the bars of a diagram.

    Attributes:
        above: height above bottom dead centre above which the strip is fed [m].
        feed: the longest window above this height.
        feed_time: time that the feeder needs [s]; None if it is not given.
        bars: all windows.
        backwards: whether the crank turns backwards, so that a window begins at its larger angle.
    """

    _press: Linkage
    above: float
    feed: AngleWindow
    feed_time: float | None
    bars: Records[AngleWindow]
    backwards: bool

    @property
    def reserve(self) -> float | None:
        """Time of the feed window that the feeder leaves [s], negative if the window is too short; None without the feeder's time."""
        return None if self.feed_time is None else self.feed.duration - self.feed_time

    @property
    def highest_speed(self) -> float | None:
        """Crank speed at which the feeder needs the whole window [rad/s]; None without the feeder's time."""
        return None if self.feed_time is None else self.feed.turned / self.feed_time

    @property
    def title(self) -> str:
        """The press, the feed window, and the reserve of the feeder."""
        said = f"{math.degrees(self.feed.turned):.6g} deg, {1e3 * self.feed.duration:.6g} ms above {1e3 * self.above:.6g} mm"
        left = "" if self.reserve is None else f", reserve {1e3 * self.reserve:.4g} ms"
        return f"TimingDiagram of {self.press_name}: feed window {said}{left}"

    def columns(self) -> dict[str, object]:  # type: ignore[override]  # those of the windows
        """The bars, a row each."""
        return dict(self.bars.columns())


@typed
def timing(
    press: Linkage,
    motion: Motion,
    above: float,
    *,
    feed_time: float | None = None,
    loads: Sequence[Load] = (),
    bars: Mapping[str, ArrayLike] = NO_BARS,
) -> TimingDiagram:
    """The timing diagram of a press over a period: feed window, feeder with its reserve, process, and other windows that you give.

    All ends are roots of the slide's path. The feeder begins where the slide rises through the height.

    Args:
        press: the press.
        motion: one period at constant speed.
        above: height above bottom dead centre above which the strip can be fed [m].
        feed_time: time that the feeder needs [s].
        loads: process loads are shown where they act, and the die is open above all of them; other loads are not shown.
        bars: name -> crank angles at which a window begins and ends, such as those of an ejector, a blank holder, or the muting of a light
            curtain [rad]. A window whose end is the smaller angle goes through the end of the period.

    Raises:
        PinpressError: as `windows`, the motion is of another press, or a window of ``bars`` is not two different angles.

    Warns:
        PinpressWarning: the feeder needs more time than the window has.
    """
    refuse_motion_of_another(press, motion)
    feed = max(windows(motion, above), key=lambda each: each.turned)
    feed = AngleWindow("feed window", feed.crank_angle, feed.ends_at, feed.turned, feed.duration)
    rows = [*_process(press, motion, loads), feed]
    step = step_time(motion).real
    needed = None if feed_time is None else positive("feed_time", feed_time, "s")
    if needed is not None:
        if needed > feed.duration:
            most = feed.turned / needed
            caution(
                f"the feeder needs {1e3 * needed:.6g} ms, but the slide is above {1e3 * above:.6g} mm for {1e3 * feed.duration:.6g} ms:"
                f" it fits up to {most / RPM:.5g} r/min"
            )
        rows.append(window(motion, "feeder", feed.crank_angle, needed / step))
        if needed < feed.duration:
            rows.append(window(motion, "reserve", rows[-1].ends_at, (feed.duration - needed) / step))
    period = 2 * math.pi * (motion.period_turns or 1)
    backwards = bool(motion.crank_speed[0] < 0)
    for name, given in bars.items():
        if not isinstance(name, str):
            raise PinpressError(f"bars has the name {shown(name)}: give text")
        ends = suitable_numbers(f"bars: {name}", given, "two different crank angles [rad]", (2,), lambda both: both[0] != both[1])
        turned = float((ends[0] - ends[1] if backwards else ends[1] - ends[0]) % period)
        rows.append(window(motion, name, float(ends[0]), turned / abs(float(motion.crank_speed[0])) / step))
    return TimingDiagram(press, above, feed, needed, Records(AngleWindow, rows), backwards)


def _process(press: Linkage, motion: Motion, loads: Sequence[Load]) -> list[AngleWindow]:
    """Windows in which process loads act, and in which the slide is above all of them."""
    rows: list[AngleWindow] = []
    highest = -math.inf
    for load in loads:
        if not isinstance(load, ProcessLoad) or not (borders := acting_between(load, press)):
            continue
        levels = {level for _, *ends in borders for level in ends if math.isfinite(level)}

        def acts(position: Array, downwards: NDArray[np.bool_], borders: list[tuple[bool, float, float]] = borders) -> NDArray[np.bool_]:
            inside = [(downwards == down) & (position > lower) & (position < upper) for down, lower, upper in borders]
            return np.asarray(np.any(inside, axis=0))

        rows += windows_where(motion, "process", levels, acts)
        highest = max(highest, *(upper for _, _, upper in borders))
    if math.isfinite(highest):
        rows = [*windows_where(motion, "die open", [highest], lambda position, downwards: position > highest), *rows]
    return rows
