"""The motion of a linkage: states in which its loops are closed, with exact rates."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common import tables
from ..common.errors import PinpressError
from ..common.frozen import read_only
from ..common.quantities import Array, DriverCoordinate
from ..common.results import Tabular
from ..engines.engine import LOOSEST, ClosedStates
from ..engines.structure import Slot, configuration
from ..linkage.linkage import NAME_A_SLIDE, Linkage, SlideGuide
from ..linkage.memo import per_linkage

MOST_IN_TITLE = 3  # drivers whose ranges are written out in a title
EQUAL = 1e-9  # difference up to which steps of the crank angle are equal [rad]
ROUNDING = 1e-9  # share of the largest force below which a force, or of the crank speed below which its variation, is rounding


class ClosedFor(NamedTuple):
    """The linkage whose loops were closed in the states of a motion, and these states with what its engine kept of closing them."""

    press: Linkage
    states: ClosedStates


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Tabular):
    """Closed states of a linkage, n of them. All arrays are read-only.

    Attributes:
        linkage: name of the linkage.
        drivers: names of its driver joints.
        driver_coordinates: what their coordinates are: crank angles [rad], or positions of drivers that slide [m].
        joints: names of all joints, in the order of ``v``.
        crank_angle: (n,) angle of the driver joint, unwrapped [rad]; of a driver that slides its position [m]. Angle, speed and
            acceleration are (n, drivers) for several drivers.
        crank_speed: (n,) speed of the driver joint [rad/s or m/s].
        crank_acceleration: (n,) acceleration of the driver joint [rad/s2 or m/s2].
        joint_position: (n, nv) joint coordinates, zero in the drawn pose, angles unwrapped [rad or m].
        v: (n, nv) joint rates in Pinocchio's order [rad/s or m/s].
        a: (n, nv) joint accelerations in Pinocchio's order [rad/s2 or m/s2].
        q: (n, nq) Pinocchio's configurations.
        closure_error: (n,) largest distance between the two sides of a loop [m].
        time: (n,) time of the states [s]. Reading it raises PinpressError for states that have no time, see `servo_cycle`.
        slide_position: (n,) position of the slide link's origin along its guide in world coordinates, positive upwards (see
            `Linkage.slide_direction`) [m]. Reading it, or velocity or acceleration, raises PinpressError where the linkage has no slide.
        slide_velocity: (n,) velocity of the slide in this direction [m/s].
        slide_acceleration: (n,) acceleration of the slide in this direction [m/s2].
        period_turns: turns of the crank in a period, see `Linkage.period_turns`; None if the linkage has no period, or several drivers.
        valid: (n,) bool: whether the drivers bring the linkage into each state. In the others, which only `servo_cycle` with
            ``on_singular="nan"`` makes, all but the coordinates, rates and accelerations of the drivers is NaN.
        reasons: why the first state of each stretch of such states is not reached.
    """

    linkage: str
    drivers: tuple[str, ...]
    driver_coordinates: tuple[DriverCoordinate, ...]
    joints: tuple[str, ...]
    crank_angle: Array
    crank_speed: Array
    crank_acceleration: Array
    joint_position: Array
    v: Array
    a: Array
    closure_error: Array
    _time: Array | None
    _slots: tuple[Slot, ...]
    _guide: SlideGuide | None
    period_turns: int | None
    reasons: tuple[str, ...] = field(default=(), init=False)
    # Not taken over by dataclasses.replace: a motion with other positions must not keep the closure of this one.
    _closed_for: ClosedFor | None = field(default=None, init=False)

    @property
    def title(self) -> str:
        slide = "" if self._guide is None else f", slide at {self.slide_position.min():.6g} to {self.slide_position.max():.6g} m"
        return f"Motion of {self.linkage}: {len(self.crank_angle)} states, {self._drivers_in_words()}{slide}"

    def _drivers_in_words(self) -> str:
        """Between which places every driver moves; of many drivers how many there are."""
        coordinates, several = self.driver_coordinates, len(self.drivers) > 1
        if len(coordinates) > MOST_IN_TITLE:
            return f"{len(coordinates)} drivers"
        places = np.reshape(self.crank_angle, (-1, len(coordinates))).T
        ranges = (f"{at.min() * each.scale:.6g} to {at.max() * each.scale:.6g}" for at, each in zip(places, coordinates, strict=True))
        names = self.drivers if several else (coordinates[0].part,)
        parts = zip(names, ranges, coordinates, strict=True)
        return ", ".join(f"{name} at {ends} {each.shown_unit}" for name, ends, each in parts)

    def states(self, press: Linkage) -> ClosedStates:
        """The states as an engine takes them, with what it kept when it closed them for this very linkage."""
        if self._closed_for is not None and self._closed_for.press is press:
            return self._closed_for.states
        return ClosedStates(self.joint_position.T, self.v.T, self.a.T)

    def __getstate__(self) -> dict[str, Any]:
        """The state for copies and pickles, which do not know the linkage."""
        return vars(self) | {"_closed_for": None}

    @property
    def valid(self) -> NDArray[np.bool_]:
        return np.isfinite(self.closure_error)

    @cached_property
    def complete(self) -> bool:
        """Whether all states are valid."""
        return bool(self.valid.all())

    @property
    def time(self) -> Array:
        if self._time is None:
            raise PinpressError("these states are no motion in time (angle and speed do not fit together): pass time= to servo_cycle")
        return self._time

    @cached_property
    def q(self) -> Array:
        return read_only(configuration(self._slots, self.joint_position.T).T)

    @cached_property
    def slide_position(self) -> Array:
        guide, offset, sign = self._slide()
        return read_only(sign * self.joint_position[:, guide] + offset)

    @property
    def shown_position(self) -> Array:
        """(n,) crank angle within one period, from 0 to 360 deg times its turns; unwrapped where there is no period [deg]. Of a driver that
        slides it is its position [mm], of several drivers that of the first."""
        shown = self.crank_angle.reshape(len(self.crank_angle), -1)[:, 0] * self.driver_coordinates[0].scale
        return shown if self.period_turns is None else np.asarray(shown % (360.0 * self.period_turns))

    def place(self, state: int) -> str:
        """Where the driver is in a state, in words: "crank angle 30 deg", "driver position 12 mm"; of several drivers the time of a state
        that has one."""
        if len(self.drivers) > 1 and self._time is not None:
            return f"time {self._time[state]:.6g} s"
        first = self.driver_coordinates[0]
        return f"{first.position} {self.shown_position[state]:.6g} {first.shown_unit}"

    @property
    def slide_velocity(self) -> Array:
        return self._along_slide(self.v)

    @property
    def slide_acceleration(self) -> Array:
        return self._along_slide(self.a)

    def columns(self) -> dict[str, Array]:
        """Time, drivers, slide and closure error as (n,) columns under their names with units. Of a driver that slides they are
        driver_position, driver_speed and driver_acceleration."""
        columns = {} if self._time is None else {"time [s]": self._time}
        for order in range(3):
            columns |= self._of_drivers(order)
        if self._guide is not None:
            columns |= {
                "slide_position [m]": self.slide_position,
                "slide_velocity [m/s]": self.slide_velocity,
                "slide_acceleration [m/s2]": self.slide_acceleration,
            }
        return columns | {"closure_error [m]": self.closure_error}

    def _of_drivers(self, order: int) -> dict[str, Array]:
        """Columns of all drivers: their positions (0), speeds (1) or accelerations (2)."""
        values = (self.crank_angle, self.crank_speed, self.crank_acceleration)[order]
        return tables.by_driver([each.heads[order] for each in self.driver_coordinates], values, self.drivers)

    def position_columns(self) -> dict[str, Array]:
        """The columns of where the drivers are, for tables beside those of the motion."""
        return self._of_drivers(0)

    @property
    def _pictured(self) -> tuple[str, ...]:
        return next(iter(self._of_drivers(0))), "slide_position [m]" if self._guide is not None else next(iter(self._of_drivers(1)))

    def to_mat(self, path: str | os.PathLike[str]) -> None:
        """Write a MATLAB file with one vector for each column, named without its unit, and the matrices q, v, a.

        Raises:
            PinpressError: a number is not finite, or the file cannot be written.
        """
        tables.write_mat(path, self.columns() | {"q": self.q, "v": self.v, "a": self.a})

    def _along_slide(self, rates: Array) -> Array:
        """(n,) rates of the slide, of those of all joints."""
        guide, _, sign = self._slide()
        return rates[:, guide] if sign > 0 else read_only(-rates[:, guide])

    def _slide(self) -> SlideGuide:
        if self._guide is None:
            raise PinpressError(f"{self.linkage} has no slide: {NAME_A_SLIDE}")
        return self._guide


def of_states(
    press: Linkage, position: Array, v: Array, a: Array, gap: Array, times: Array | None, period_turns: int | None = None
) -> Motion:
    """The motion with these closed states.

    Args:
        press: the linkage.
        position: (nv, n) joint coordinates [rad or m].
        v: (nv, n) joint rates [rad/s or m/s].
        a: (nv, n) joint accelerations [rad/s2 or m/s2].
        gap: (n,) largest gaps of a loop [m].
        times: (n,) [s], None if the states have no time.
        period_turns: turns of the crank in a period, None for none.
    """
    return motion_of_states(shared_by_motions(press), position, v, a, gap, times, period_turns)


def motion_of_states(
    fixed: SharedByMotions, position: Array, v: Array, a: Array, gap: Array, times: Array | None, period_turns: int | None
) -> Motion:
    """`of_states` of a linkage of which this is known."""
    drivers = fixed.indices
    for each in (position, v, a):  # views of them would else be made writable again
        each.setflags(write=False)
    return Motion(
        linkage=fixed.linkage,
        drivers=fixed.drivers,
        driver_coordinates=fixed.driver_coordinates,
        joints=fixed.joints,
        crank_angle=position[drivers].T,
        crank_speed=v[drivers].T,
        crank_acceleration=a[drivers].T,
        joint_position=position.T,
        v=v.T,
        a=a.T,
        closure_error=gap,
        _time=times,
        _slots=fixed.slots,
        _guide=fixed.guide,
        period_turns=period_turns,
    )


class SharedByMotions(NamedTuple):
    """What all motions of a linkage have in common, by the names of `Motion`.

    Attributes:
        indices: of the drivers in v, one number where there is one driver.
    """

    linkage: str
    drivers: tuple[str, ...]
    driver_coordinates: tuple[DriverCoordinate, ...]
    indices: int | list[int]
    joints: tuple[str, ...]
    slots: tuple[Slot, ...]
    guide: SlideGuide | None


@per_linkage
def shared_by_motions(press: Linkage) -> SharedByMotions:
    guide = None if press.slide is None else press.slide_guide
    indices = press.driver_indices[0] if len(press.drivers) == 1 else list(press.driver_indices)
    return SharedByMotions(press.name, press.drivers, press.driver_coordinates, indices, press.joints, press.slots, guide)


def as_prescribed(motion: Motion, press: Linkage) -> Motion:
    """The states of a motion as those of another linkage that moves alike. From a simulated run, which belongs to its press, only the
    motion is taken."""
    kept = {each.name: getattr(motion, each.name) for each in fields(Motion) if each.init}
    return Motion(**(kept | {"linkage": press.name, "period_turns": press.turns_until_back}))


def closed_motion(
    press: Linkage, fixed: SharedByMotions, states: ClosedStates, gap: Array, times: Array | None, period_turns: int | None
) -> Motion:
    """The motion with these states, in which the loops of a linkage were closed; arguments as of `of_states`."""
    motion = motion_of_states(fixed, states.position, states.v, states.a, gap, times, period_turns)
    vars(motion)["_closed_for"] = ClosedFor(press, states)
    return motion


def accelerated(press: Linkage, motion: Motion, states: ClosedStates) -> Motion:
    """The motion of a linkage with the accelerations of these states, which are else its own. From a simulated run only the motion is
    taken."""
    return closed_motion(press, shared_by_motions(press), states, motion.closure_error, motion._time, motion.period_turns)


def filled(press: Linkage, motion: Motion) -> Motion:
    """The motion with the home pose of its press, at rest, in place of states that are not valid; the motion itself if all are."""
    if motion.complete:
        return motion
    gaps, rest = ~motion.valid, np.zeros(len(press.joints))
    x, v, a = (
        np.where(gaps[:, None], fill, values).T.copy()
        for values, fill in ((motion.joint_position, press.closed), (motion.v, rest), (motion.a, rest))
    )
    return of_states(press, x, v, a, np.where(gaps, 0.0, motion.closure_error), motion._time, motion.period_turns)


def with_gaps(press: Linkage, motion: Motion, drivers: Sequence[Array], gaps: Sequence[int], reasons: Sequence[str]) -> Motion:
    """The motion with gaps in some states, where ``drivers`` are positions, speeds and accelerations (n, drivers) of the drivers."""
    blanked = []
    for values, of_drivers in zip((motion.joint_position, motion.v, motion.a), drivers, strict=True):
        own = values.T.copy()
        own[:, gaps] = np.nan
        own[list(press.driver_indices)] = np.reshape(of_drivers, (-1, len(press.drivers))).T
        blanked.append(own)
    error = motion.closure_error.copy()
    error[gaps] = np.nan
    x, v, a = blanked
    result = of_states(press, x, v, a, error, motion._time, motion.period_turns)
    vars(result)["reasons"] = tuple(reasons)
    return result


def with_gaps_of(press: Linkage, motion: Motion, asked: Motion) -> Motion:
    """The motion with the gaps of another one, of which it has been `filled`."""
    if motion is asked or asked.complete:
        return motion
    indices, valid = list(press.driver_indices), asked.valid[:, None]
    pairs = zip((motion.joint_position, motion.v, motion.a), (asked.joint_position, asked.v, asked.a), strict=True)
    of_drivers = [np.where(valid, values[:, indices], given[:, indices]) for values, given in pairs]
    return with_gaps(press, motion, of_drivers, np.flatnonzero(~asked.valid).tolist(), asked.reasons)


def blank(motion: Motion, values: Array, axis: int = 0) -> Array:
    """Values with NaN in the states of a motion that are not valid; states are along the axis."""
    if motion.complete:
        return values
    result = np.array(values)
    np.moveaxis(result, axis, 0)[~motion.valid] = np.nan
    return result


def refuse_other_joints(press: Linkage, motion: Motion) -> None:
    """Raise PinpressError where a motion is of a linkage with other joints or drivers."""
    if motion.joints != press.joints or motion.drivers != press.drivers:
        raise PinpressError(f"the motion is of {motion.linkage} with other joints than {press.name}: make it with cycle(press, ...)")


def refuse_motion_of_another(press: Linkage, motion: Motion) -> None:
    """Raise PinpressError where a motion is not of this linkage: of one with other joints or drivers, or of other lengths."""
    refuse_other_joints(press, motion)
    if motion._closed_for is not None and motion._closed_for.press is press:
        return
    open_by = press.engine().gaps(motion.joint_position.T)
    if not open_by.max() <= max(LOOSEST * press.size, press.structure.tolerance):
        worst = int(open_by.argmax())
        raise PinpressError(
            f"the motion leaves the loops of {press.name} open by {open_by[worst]:.3g} m at {motion.place(worst)}, so that it is one of"
            " other lengths, or with another zero: make it with cycle(press, ...) or servo_cycle(press, ...)"
        )


# ---------------------------------------------------------------------------------------------------------------- what the states are


def is_cycle(motion: Motion) -> bool:
    """Whether the states are one period of a single crank in equal steps, without the end of the period."""
    angle = motion.crank_angle
    if motion.period_turns is None or len(angle) < 3:
        return False
    period = float(np.copysign(2 * np.pi * motion.period_turns, angle[-1] - angle[0]))
    return bool(np.allclose(np.diff(angle, append=angle[0] + period), period / len(angle), rtol=0.0, atol=EQUAL))


def is_constant(speed: Array) -> bool:
    """Whether speeds (n,) or (n, drivers) are constant to rounding."""
    return bool(np.all(np.ptp(speed, axis=0) <= ROUNDING * np.abs(speed).max(axis=0)))


def finite(quantity: str, values: Array) -> Array:
    """The values (n, ...), after a check.

    Raises:
        PinpressError: there is no value, or one is not finite.
    """
    if not len(values):
        raise PinpressError(f"{quantity} has no states: give a motion of at least one")
    if not np.isfinite(values).all():
        at = int(np.argwhere(~np.isfinite(values))[0][0])
        raise PinpressError(f"{quantity} is not finite at index {at}: give what cycle, simulate and inverse_dynamics return")
    return values
