"""What all windows of a press share: the press as it is now, and the answers to messages of windows.

Messages are JSON objects with a ``type``. A window sends ``set`` (values of all dimensions, the speed, and whether it wants new shapes of
the links, which take longest), ``move`` (the driver that is to move while the others stand), ``save`` (the name of a file, and whether an
old one may be replaced) and ``ready`` (the picture that it has drawn last). Everything else is refused. A window receives ``opened``
(everything), ``picture`` (the press with other values), ``refused`` (no press has these values: the last good one stays), ``broken`` (the
file cannot be read now), ``saved``, ``exists`` and ``unsaved``.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from ..common.errors import PinpressError, cautions_collected
from ..common.quantities import RPM, Array, DriverCoordinate
from .drivers import default_speed
from .pictures import Operation, Picture, colours, picture, suitable
from .sources import MovingDriver, Source, checked_name, finite

Message = dict[str, Any]
KEYS = {
    "set": {"values", "speed", "shapes"},
    "move": {"driver"},
    "save": {"name", "replace"},
    "ready": {"version"},
}  # of messages, besides their type
LONGEST = 1 << 16  # bytes of a message


class RefusedMessageError(Exception):
    """A message that our windows do not send."""


@dataclass(frozen=True, eq=False)
class Opened:
    """A press to look at, and how it runs.

    Attributes:
        source: the press, and how it can be changed.
        operation: how it runs.
    """

    source: Source
    operation: Operation


@dataclass(frozen=True, eq=False)
class Answer:
    """What is sent after a message.

    Attributes:
        everyone: to all windows; None for nothing.
        sender: to the window that asked; None for nothing.
        drawn: version of the picture that the window has drawn, where it says so.
    """

    everyone: Message | None = None
    sender: Message | None = None
    drawn: int | None = None


class Session:
    """The press that is shown, as it was opened and as it is now.

    Attributes:
        version: number of pictures so far.
        broken: why the file cannot be read now; None if it can be read.
    """

    def __init__(self, opening: Callable[[], Opened], watched: str | None = None) -> None:
        self._opening, self._watched = opening, watched
        self._given: Opened  # as it was opened, with all its drivers
        self._opened: Opened | None = None
        self.broken: str | None = None
        self._operation: Operation
        self._picture: Picture
        self._hastened = 1.0  # speed that a window has chosen, as a share of the given speed
        self._values: list[float] = []
        self._before: list[Message] = []  # curves of the press as it was opened
        self._colours: dict[str, Array] = {}  # of the links as they were opened
        self._notes: list[str] = []
        self._moving: str | None = None  # the driver that a window has chosen
        self.version = 0

    def open(self) -> None:
        """Open the press, the first time or again; the speed that a window has chosen stays.

        Raises:
            PinpressError: it cannot be opened; what was open before stays.
        """
        try:
            with cautions_collected() as notes:
                opened = self._opening()
                given, opened = opened, self._with_one_moving(opened)
                operation = suitable(opened.source.press, opened.operation)
                if self._opened is not None:
                    operation = replace(operation, speed=operation.speed * self._hastened)
                first = picture(opened.source.press, operation, None)
        except PinpressError as error:
            self.broken = str(error)
            raise
        self._given, self._opened, self._operation, self._picture = given, opened, operation, first
        self.broken, self._notes = None, notes
        self._values = [each.value for each in opened.source.dimensions]
        self._before, self._colours = first.data["curves"], colours(first.links)
        self.version += 1

    def _with_one_moving(self, opened: Opened) -> Opened:
        """A press with one moving driver: of several the one that a window has chosen, at first the first one. It has the given speed if
        both turn, or both slide."""
        press = opened.source.press
        if len(press.drivers) == 1:
            return opened
        source = MovingDriver.of(opened.source, self._moving)
        same_kind = press.driver_coordinates[0].turns == source.press.driver_coordinates[0].turns
        return Opened(source, opened.operation if same_kind else replace(opened.operation, speed=default_speed(source.press)))

    @property
    def files(self) -> tuple[str, ...]:
        """The files that the press was read from."""
        if self._opened is None:
            return () if self._watched is None else (self._watched,)
        return self._opened.source.files

    @property
    def coordinate(self) -> DriverCoordinate:
        """What the driver's coordinate is."""
        return self._picture.press.driver_coordinates[0]

    def whole(self) -> Message:
        """Everything that a window needs, as it is now."""
        if self._opened is None:
            return {"type": "broken", "text": self.broken, "version": self.version}
        source = self._opened.source
        with cautions_collected():
            now = picture(self._picture.press, self._operation, None, self._made_up(self._values), first=True)
        self._picture = now
        turns = self.coordinate.turns
        return self._message("opened", now) | {
            "name": now.press.name,
            "dimensions": [asdict(each) for each in source.dimensions],
            "speed_unit": "r/min" if turns else "mm/s",
            "suggested": source.suggested,
            "folder": str(source.folder),
            "suffixes": source.suffixes,
            "broken": self.broken,
            "drivers": source.drivers if isinstance(source, MovingDriver) else [],
        }

    def answer(self, text: str | bytes) -> Answer:
        """What is answered to a message of a window.

        Raises:
            RefusedMessageError: our windows do not send it.
        """
        message = _understood(text)
        if message["type"] == "ready":
            return Answer(drawn=message["version"] if isinstance(message["version"], int) else 0)
        if self._opened is None:
            return Answer()
        return {"set": self._set, "move": self._move, "save": self._save}[message["type"]](message)

    def _move(self, message: Message) -> Answer:
        """Let another driver move; the driver that has moved stands where its slider is, and lengths stay as they are."""
        assert self._opened is not None
        old = self._opened.source
        if not isinstance(old, MovingDriver) or message["driver"] not in old.drivers:
            raise RefusedMessageError("no driver of this press")
        moving = self._moving
        self._moving = message["driver"]
        opened = self._with_one_moving(self._given)
        same_kind = opened.source.press.driver_coordinates[0].turns == self.coordinate.turns
        speed = self._operation.speed if same_kind else opened.operation.speed
        try:
            with cautions_collected() as notes:
                operation = replace(suitable(opened.source.press, opened.operation), speed=speed)
                now = picture(opened.source.changed(self._values), operation, None, self._made_up(self._values))
                before = picture(opened.source.press, operation, now.links)
        except PinpressError as error:
            self._moving = moving
            return Answer(sender={"type": "refused", "text": str(error)})
        self._opened, self._operation, self._picture, self._notes = opened, operation, now, notes
        self._before, self._hastened = before.data["curves"], operation.speed / opened.operation.speed
        self.version += 1
        return Answer(everyone=self.whole())

    def _set(self, message: Message) -> Answer:
        assert self._opened is not None
        source = self._opened.source
        try:
            values = finite(message["values"], len(source.dimensions))
            (shown,) = finite([message["speed"]], 1)
            operation = replace(self._operation, speed=shown * (RPM if self.coordinate.turns else 1e-3))
            with cautions_collected() as notes:
                press = source.changed(values)
                if press is not self._picture.press and press is not source.press:
                    press.follow_beside(self._picture.press)
                kept = None if message["shapes"] else self._picture.links
                now = picture(press, operation, kept, self._made_up(values))
                if operation.speed != self._operation.speed:
                    self._before = picture(source.press, operation, self._picture.links).data["curves"]
        except PinpressError as error:
            return Answer(sender={"type": "refused", "text": str(error)})
        self._values, self._operation, self._picture, self._notes = values, operation, now, notes
        self._hastened = operation.speed / self._opened.operation.speed
        self.version += 1
        return Answer(everyone=self._message("picture", now))

    def _made_up(self, values: Sequence[float]) -> dict[str, Array]:
        """The links whose own shapes no longer fit, with the colours that they had."""
        assert self._opened is not None
        return {link: self._colours[link] for link in self._opened.source.made_up(values) if link in self._colours}

    def _message(self, kind: str, now: Picture) -> Message:
        speed = self._operation.speed / (RPM if self.coordinate.turns else 1e-3)
        return now.data | {
            "type": kind,
            "version": self.version,
            "values": self._values,
            "speed": float(f"{speed:.9g}"),
            "before": self._before,
            "notes": self._notes[:5],
            "points": self._operation.points,
            "moving": self._picture.press.driver,
        }

    def _save(self, message: Message) -> Answer:
        assert self._opened is not None
        source = self._opened.source
        try:
            path = checked_name(message["name"], source)
            if os.path.exists(path) and not message["replace"]:
                return Answer(sender={"type": "exists", "text": f"{path} is there already"})
            with cautions_collected():
                source.write(self._values, path)
        except PinpressError as error:
            return Answer(sender={"type": "unsaved", "text": str(error)})
        return Answer(sender={"type": "saved", "text": str(path)})


def _understood(text: str | bytes) -> Message:
    """A message of a window, its keys and their kinds checked; numbers are checked where they are used."""
    if not isinstance(text, str) or len(text) > LONGEST:
        raise RefusedMessageError("no text, or too long")
    try:
        message = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise RefusedMessageError("no JSON") from error
    kind = message.get("type") if isinstance(message, dict) else None
    if not isinstance(kind, str) or kind not in KEYS or set(message) != KEYS[kind] | {"type"}:
        raise RefusedMessageError("no message that is known")
    for flag in ("shapes", "replace"):
        if not isinstance(message.get(flag, False), bool):
            raise RefusedMessageError(f"{flag} is neither true nor false")
    return dict(message)


def _no_number(word: str) -> float:
    """NaN and Infinity, which are no JSON."""
    raise ValueError(word)
