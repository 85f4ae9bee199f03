"""Trials of a caller's own drives and loads before a simulation, and of a drive once more after it.

A law is a function of what it declares to depend on, and of nothing else: the torque of a drive depends on its shaft's speed, and where it
is ``timed`` on angle, time and its own states too; the force of a load on height and velocity; that of a `TimeForce` on time. Simulations
rest on that, because they ask in different orders, one state at a time or many at once. Before a run, drives and loads are therefore
checked against their protocols and tried; after it, the torques of the run are asked for again.

`caller_laws` says how they are asked. The library's own drives and loads are asked as they are.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from .. import drives
from ..common.arguments import any_numbers
from ..common.errors import PinpressError, said, shown
from ..common.parameters import scenario_lengths
from ..common.quantities import Array, Values
from ..drives.protocol import Corner, Drive, corners_of
from ..drives.transmission import Geared
from ..loads.caller_laws import Asked, AskedLoad, Law, LawError, asked_load
from ..loads.caller_laws import name as name_of
from ..loads.link import LinkLoad
from ..loads.process import ProcessLoad, TimeForce

ANGLES, TIMES = (0.7, 2.1, -4.0, 9.5), (0.01, 0.3, 2.0, 11.0)  # a drive is tried at these crank angles [rad] and times [s]
INSIDE = np.linspace(0.02, 0.98, 9)  # a load is tried at these shares of an interval
VELOCITIES = (0.0, -1.0, -0.1, -1e-3, 1e-3, 0.1, 1.0)  # a load is tried at these velocities [m/s]
TRIED_AT = np.array([-1.0, 0.5, 2.0])  # speeds or heights at which a law is asked at once, to see whether it takes arrays


def tried(drive: Any, loads: Iterable[Any], speed: float) -> tuple[Any, list[Any]]:
    """Drive and loads for a run that begins with about this crank speed [rad/s], a caller's own among them wrapped as `caller_laws` says.

    Parts that were tried before stay as they are. What is no drive is refused where the press is put together.

    Raises:
        PinpressError: something is no load, or a part does not answer as its protocol says, or depends on more than it declares.
    """
    return _tried_drive(drive, speed), [_tried_load(load) for load in loads]


def _tried_drive(drive: Any, speed: float) -> Any:
    if isinstance(drive, Mapping):  # of several drivers, by their joints
        return {joint: _tried_drive(part, speed) for joint, part in drive.items()}
    if isinstance(drive, AskedDrive | type | None) or not isinstance(drive, Drive):
        return drive
    if _is_known(drive):
        _check_drive(drive)
        return drive
    # A run that begins more slowly than 10 rad/s may still reach that.
    asked = AskedDrive(drive, np.geterr(), max(abs(speed), 10.0))
    _check_drive(asked)
    _try_drive(asked)
    return asked


def _tried_load(load: Any) -> Any:
    if isinstance(load, LinkLoad):
        return load
    if isinstance(load, type) or not isinstance(load, ProcessLoad | TimeForce):
        raise PinpressError(
            f"load {shown(load)} is no load: give a PointForce, PointMoment, SpringDamper, TorsionSpring or one of pinpress.loads"
        )
    asked = asked_load(load)
    if asked is not load and isinstance(asked, TimeForce):
        times, remedy = np.array([0.0, *TIMES]), "let it depend on the time alone"
        first = _in_turn("TimeForce: force", asked.force, [(t,) for t in times.tolist()], remedy)
        _as_numbers("TimeForce: force", first, asked.force(times))
    elif isinstance(asked, AskedLoad):
        _try_load(asked)
    return asked


def _is_known(drive: object) -> bool:
    """Whether a drive is one of the library's."""
    if isinstance(drive, Geared):
        return _is_known(drive.drive)
    return type(drive).__module__.startswith(f"{drives.__name__}.")


# ------------------------------------------------------------------------------------------------------------------------------- asked

OF_DRIVE = ("speed", "rad/s"), ("angle", "rad"), ("time", "s")


@dataclass(frozen=True, eq=False)
class AskedDrive(Asked):
    """A caller's own drive, or a `Geared` one, asked as `caller_laws` says.

    Attributes:
        about: speed of the crank in the run, by size [rad/s].
    """

    about: float

    @property
    def inertia(self) -> Values:
        return self.part.inertia  # type: ignore[no-any-return]

    @property
    def state(self) -> tuple[float, ...]:
        return self.part.state  # type: ignore[no-any-return]

    @property
    def timed(self) -> bool:
        return self.part.timed  # type: ignore[no-any-return]

    @property
    def heeds_speed(self) -> bool:
        return getattr(self.part, "heeds_speed", True)

    @property
    def rated_torque(self) -> Values | None:
        return self.part.rated_torque  # type: ignore[no-any-return]

    @property
    def corners(self) -> tuple[Values | Corner, ...]:
        return self.part.corners  # type: ignore[no-any-return]

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return self._laws["torque"](speed, angle, time, state)  # type: ignore[no-any-return]

    def motor_torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return self._laws["motor_torque"](speed, angle, time, state)  # type: ignore[no-any-return]

    def motor_speed(self, speed: Values) -> Values:
        return self._laws["motor_speed"](speed)  # type: ignore[no-any-return]

    @cached_property
    def _laws(self) -> dict[str, Law]:
        scenarios = next(iter(scenario_lengths(self.part).values()), None)
        return {
            law: Law(f"{name_of(self)}: {law}", OF_DRIVE, getattr(self.part, law), self.errors, scenarios)
            for law in ("torque", "motor_torque", "motor_speed")
        }

    def rates(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> tuple[Values, ...]:
        shape = np.shape(speed)
        try:
            with np.errstate(**self.errors):
                rates = self.part.rates(speed, angle, time, state)
            numbers = np.array([np.broadcast_to(np.asarray(rate, dtype=float), shape) for rate in rates]).reshape(-1, *shape)
        except Exception as error:
            one_by_one = "; let it work element by element, as NumPy's functions do" if shape else ""
            raise LawError(f"{name_of(self)}: rates cannot be worked out: {said(error)}{one_by_one}") from error
        if len(numbers) != len(self.state) or not (np.isfinite(numbers).all() or not np.isfinite(speed).all()):
            raise LawError(f"{name_of(self)}: rates is {shown(rates)}; give a finite rate of each of {len(self.state)} states")
        return tuple(numbers) if shape else tuple(map(float, numbers))


# ----------------------------------------------------------------------------------------------------------------------------- checked


def _check_drive(drive: Drive) -> None:
    """Raise PinpressError where a drive does not answer as the protocol says."""
    name = name_of(drive)
    inertia = _answer(f"{name}: inertia", lambda: drive.inertia)
    if inertia.ndim > 1 or not np.all(np.isfinite(inertia)) or np.any(inertia < 0):
        raise PinpressError(f"{name}: inertia is {shown(drive.inertia)}; give a finite number that is not negative [kg m2]")
    state = _answer(f"{name}: state", lambda: list(drive.state))
    if state.ndim != 1 or not np.all(np.isfinite(state)):
        raise PinpressError(f"{name}: state is {shown(drive.state)}; give a tuple of finite numbers, () for none")
    if len(state) and not drive.timed:
        raise PinpressError(f"{name}: a drive with states is timed: let timed be True")
    states = tuple(state.tolist())
    rates = _answer(f"{name}: rates", lambda: list(drive.rates(1.0, 0.0, 0.0, states)))
    if rates.shape != state.shape:
        raise PinpressError(f"{name}: rates gives {rates.size} of {state.size} states; give one of each")
    _answer(f"{name}: corners", lambda: [np.ravel(speed)[0] for speed, _ in corners_of(drive)])
    for what in (drive.torque, drive.motor_torque):
        call: Callable[..., Any] = what
        _law(f"{name}: {what.__name__}", partial(call, angle=0.0, time=0.0, state=states), drive.timed)


def _law(what: str, law: Callable[[Any], Any], timed: bool) -> None:
    """Ask a law with a number, and if it is not timed, so that it may be solved over the crank angle, with an array too."""
    number = _answer(what, lambda: law(1.0))
    if not np.all(np.isfinite(number)):
        raise PinpressError(f"{what} is {number}; give finite numbers")
    if not timed:
        shape = (len(TRIED_AT), number.size) if number.ndim else TRIED_AT.shape
        arguments = np.broadcast_to(TRIED_AT[:, None], shape) if number.ndim else TRIED_AT
        array = _answer(f"{what} of an array", lambda: law(arguments))
        if np.broadcast_shapes(array.shape, shape) != shape:
            raise PinpressError(
                f"{what} of an array of shape {shape} has shape {array.shape}; it must take arrays, as NumPy's functions do"
            )


def _answer(what: str, ask: Callable[[], Any]) -> Any:
    """An answer as an array of numbers; raises PinpressError where it is none, or cannot be computed."""
    try:
        with np.errstate(all="ignore"):
            return any_numbers(what, ask())
    except PinpressError:
        raise
    except Exception as error:
        raise PinpressError(f"{what} cannot be worked out: {said(error)}") from error


# ------------------------------------------------------------------------------------------------------------------------------- tried


def _try_drive(drive: AskedDrive) -> None:
    """Raise PinpressError where a drive depends on more than it declares, or gives other values for arrays than for numbers."""
    what, states, timed = name_of(drive), tuple(map(float, drive.state)), drive.timed
    speeds = drive.about * np.concatenate([np.linspace(-2.0, 2.0, 33), [1e-3, -1e-3]])
    if timed and len(drive.corners):
        raise PinpressError(f"{what}: corners is {shown(drive.corners)}; a drive that is timed has none: let corners be ()")
    in_states = [(w, ANGLES[k % 4], TIMES[k % 3], states) for k, w in enumerate(speeds.tolist())]
    for law in ("torque", "motor_torque"):
        ask = getattr(drive, law)
        if timed:
            _in_turn(f"{what}: {law}", ask, in_states, "keep it in `state` and `rates`")
            continue
        arguments = [(w, 0.0, 0.0, ()) for w in speeds.tolist()]
        first = _in_turn(f"{what}: {law}", ask, arguments, "keep it in `state` and `rates`, and let `timed` be True")
        for of, places in (("angle of the shaft", [(a, 0.0) for a in ANGLES]), ("time", [(0.0, t) for t in TIMES])):
            for angle, time in places:
                if _differ(first[::4], [ask(w, angle, time, ()) for w in speeds.tolist()[::4]]):
                    raise PinpressError(f"{what}: {law} depends on the {of}, but timed is False; let timed be True")
        if not drive.heeds_speed and _differ(first, first[:1]):
            raise PinpressError(f"{what}: {law} depends on the speed; let heeds_speed be True")
        all_speeds = np.broadcast_to(speeds[:, None], first.shape) if first.ndim > 1 else speeds
        _as_numbers(f"{what}: {law}", first, ask(all_speeds, 0.0, 0.0, ()))
    if states:
        _in_turn(f"{what}: rates", drive.rates, in_states, "keep it in `state`")


def _try_load(load: AskedLoad) -> None:
    """Raise PinpressError where a load depends on more than height, velocity and direction, or gives other values for arrays than for
    numbers."""
    for downwards in (True, False):
        once, again = load.intervals(downwards), load.intervals(downwards)
        if [(s.upper, s.lower, s.one_sided, s.sense) for s in once] != [(s.upper, s.lower, s.one_sided, s.sense) for s in again]:
            raise PinpressError(f"{name_of(load)}: intervals({downwards}) differ from one call to the next; let them stay the same")
        for interval in once:
            upper = interval.upper if math.isfinite(interval.upper) else max(interval.lower, -1.0) + 1.0
            lower = interval.lower if math.isfinite(interval.lower) else upper - 1.0
            arguments = [(h, v) for h in (lower + (upper - lower) * INSIDE).tolist() for v in VELOCITIES]
            remedy = "let it depend on height and velocity alone, forces in time are a TimeForce"
            first = _in_turn(f"{name_of(load)}: force", interval.force, arguments, remedy)
            by_height = first.reshape(len(INSIDE), len(VELOCITIES), -1)
            if not interval.heeds_velocity and _differ(by_height, by_height[:, :1]):
                raise PinpressError(f"{name_of(load)}: force depends on the velocity; let heeds_velocity of its interval be True")
            heights, velocities = (np.broadcast_to(np.array(values), first.T.shape).T for values in zip(*arguments, strict=True))
            _as_numbers(f"{name_of(load)}: force", first, interval.force(heights, velocities))


def confirm_torques(drive: object, times: Array, angles: Array, speeds: Array, torques: Array) -> None:
    """Raise PinpressError where the torques (n,) of a caller's drive in a run are not those that it gives when it is asked again at these
    states (n,), one by one and backwards."""
    if not isinstance(drive, AskedDrive) or drive.timed:
        return
    # at a corner, and at rest, a torque that jumps there, as behind gears with losses, is that of either side
    corners = np.array([0.0, *(float(np.ravel(speed)[0]) for speed, _ in corners_of(drive))])
    clear = np.flatnonzero((np.abs(speeds - corners[:, None]) > 1e-9 * np.abs(speeds).max()).all(axis=0))
    if not len(clear):
        return
    # of a long run a hundred states are asked again
    backwards = clear[np.unique(np.linspace(0, len(clear) - 1, 100).astype(int))[::-1]]
    again = [drive.torque(float(speeds[k]), float(angles[k]), float(times[k])) for k in backwards]
    by_speed = [drive.torque(float(speeds[k])) for k in backwards]
    if _differ(torques[backwards], np.array([again, by_speed]).reshape(2, -1)):
        raise PinpressError(
            f"{name_of(drive)}: torque depends on more than the speed, but timed is False: asked again at the states of the run it gives"
            " other torques; let timed be True, and keep what it remembers in `state` and `rates`"
        )


def _in_turn(what: str, ask: Callable[..., Any], arguments: Sequence[tuple[Any, ...]], remedy: str) -> Array:
    """Answers of a law; raises PinpressError where they differ when it is asked in another order."""
    first = np.array([ask(*row) for row in arguments], dtype=float)
    if _differ(first, [ask(*row) for row in reversed(arguments)][::-1]):
        raise PinpressError(f"{what} depends on what it was asked before: the same arguments give other values; {remedy}")
    return first


def _as_numbers(what: str, numbers: Array, array: Any) -> None:
    if _differ(numbers, array):
        raise PinpressError(f"{what} of an array differs from that of its numbers; let it work element by element, as NumPy's functions do")


def _differ(answers: Array, others: Any) -> bool:
    # Up to this relative difference two answers are equal within rounding error.
    return bool(np.abs(answers - np.asarray(others, dtype=float)).max() > 1e-9 * np.abs(answers).max())
