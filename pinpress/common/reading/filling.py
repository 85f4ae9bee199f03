"""What may stand at a key of a file or of a call: a few kinds of value, each of which reads an entry and says what it takes.

    Number("N")                       1500 kN
    Numbers("m")                      0 100 -350 mm, or [0, 100, -350 mm]: all share the last unit
    Text(("drawn", "tdc")), Whole(), Truth(), DataFile()
    Part(DeepDrawing, "...")          {force: 1500 kN, start: 40 mm}: the fields of a dataclass
    OneOf({"drawing": Part(...)})     {kind: drawing, ...}
    Whichever({"beams": Part(...)})   a part that one of its keys tells
    Either(Number("kg m2"), Part(...)), Listed(Part(...)), Named(Number("K"))

In a file every number has its unit beside it, but for 0 and for what has no unit. In a call a bare number is in SI units.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, Field, dataclass, field, is_dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, NoReturn, Protocol, TypeVar

from ..arguments import unit_factor
from ..errors import PinpressError, UnknownNameError, suggestion
from ..parameters import declared, in_signature
from ..quantities import CRANK, DriverCoordinate, quantity
from .columns import Wanted, read_columns
from .entries import Entry

T = TypeVar("T")
PURE = ("-", "Shore A")  # numbers of them stand alone
_NUMBER = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf)\s*(\S.*)?")
_REMEDY = re.compile(r"[:;] (?=(?:add|give|leave|move|name|join|make|write|there are)\b)")  # before what to do, in messages of others


@dataclass(frozen=True)
class Around:
    """What the reading of a value depends on besides its entry.

    Attributes:
        coordinate: of the driver that a part moves: where it slides, forces stand in place of torques.
        drivers: of the press -> their coordinates.
        exponent: of the law in whose unit ``e`` stands, as in N/m^e.
        files: data files that were named so far.
    """

    coordinate: DriverCoordinate = CRANK
    drivers: Mapping[str, DriverCoordinate] = field(default_factory=dict)
    exponent: float | None = None
    files: list[Path] = field(default_factory=list)


class Value(Protocol):
    """What may stand at a key."""

    def read(self, entry: Entry, around: Around) -> Any:
        """The value of an entry; raises the error of the entry's file."""


@dataclass(frozen=True)
class Number:
    """A number with a unit.

    Attributes:
        unit: SI unit of the number that is read; "-" for none.
    """

    unit: str

    def read(self, entry: Entry, around: Around) -> float:
        """The number [unit]."""
        if isinstance(entry.value, float):
            return entry.value
        return self.of(entry, entry.text(f"a number, {self.example(around)}").strip(), around)

    def of(self, entry: Entry, text: str, around: Around) -> float:
        """The number of a text that stands in an entry."""
        unit = self.here(around)
        parts = _NUMBER.fullmatch(text)
        comma = re.fullmatch(r"[-+]?\d+,\d+.*", text)
        if parts is None or comma:
            entry.refuse(f"{text!r} is no number", "write decimals after a point" if comma else f"write e.g. {self.example(around)}")
        number, given = parts.groups()
        if given is not None:
            try:
                return float(number) * unit_factor(given, unit)
            except ValueError as error:
                entry.refuse(f"{text!r} is {error}", f"write e.g. {self.example(around, number)}")
        value = float(number)
        if self.unit in PURE or value == 0 or math.isinf(value):
            return value
        entry.refuse(f"{number} has no unit", f"write {' or '.join(f'{number} {name}' for name in usual_units(unit))}, whichever it is")

    def here(self, around: Around) -> str:
        """The unit on this driver, with the exponent of this law."""
        unit = around.coordinate.in_place_of(self.unit)
        return unit if around.exponent is None else unit.replace("^e", f"^{around.exponent:g}")

    def example(self, around: Around, number: str = "1.5") -> str:
        """A number with its unit, for messages."""
        return number if self.unit in PURE else f"{number} {usual_units(self.here(around))[0]}"


def usual_units(unit: str) -> Sequence[str]:
    """The unit in which presses are described, and the SI unit."""
    row = quantity(unit)
    names = [name for name, _, _ in row.shown if name.isascii()] or [name for name in row.read if name.isascii()]
    return list(dict.fromkeys([*[name for name in names if name != unit][:1], unit]))


@dataclass(frozen=True)
class Numbers:
    """Several numbers, or rows of them; those without a unit have that of the last.

    Attributes:
        unit: as of `Number`.
    """

    unit: str

    def read(self, entry: Entry, around: Around) -> tuple[Any, ...]:
        """The numbers [unit]; of rows a tuple each."""
        units = _units(entry)
        if "" in units[:-1] and len({*units} - {""}) > 1:  # which of them a bare number has is not said
            entry.refuse("numbers have different units, and some have none", "write the unit at each number, or one behind the last")
        return self._of(entry, units[-1] if units else "", around)

    def _of(self, entry: Entry, unit: str, around: Around) -> tuple[Any, ...]:
        one = Number(self.unit)
        if isinstance(entry.value, float):
            return (entry.value,)
        if isinstance(entry.value, tuple):
            rows = any(isinstance(each.value, tuple) or _is_row(each.value) for each in entry.value)
            return tuple(self._of(each, unit, around) if rows else one.read(_with_unit(each, unit), around) for each in entry.value)
        return tuple(one.of(entry, text, around) for text in _texts(entry, unit))


@dataclass(frozen=True)
class Rows:
    """Rows of numbers, such as points; one may stand alone.

    Attributes:
        unit: as of `Number`.
    """

    unit: str

    def read(self, entry: Entry, around: Around) -> list[tuple[float, ...]]:
        """A tuple for each row [unit]."""
        rows = Numbers(self.unit).read(entry, around)
        return list(rows) if rows and isinstance(rows[0], tuple) else [rows]


def _texts(entry: Entry, unit: str) -> list[str]:
    """A text for each number of one text, with the unit behind the last, or else ``unit``."""
    numbers, own = _parted(entry.text("numbers with blanks between them"))
    if not numbers or (own and own[0] in ",;/"):
        entry.refuse(f"{entry.value!r} is no row of numbers", "write numbers with blanks between them, and their unit behind the last")
    return [f"{number} {own or unit}".strip() for number in numbers]


def _parted(text: str) -> tuple[list[str], str]:
    """The numbers at the begin of a text, and what stands behind them."""
    words = text.split()
    count = next((k for k, word in enumerate(words) if not _is_number(word)), len(words))
    numbers, rest = words[:count], " ".join(words[count:])
    attached = _NUMBER.fullmatch(rest)
    if attached is not None and attached[2]:  # as in 0 0 5kN
        return [*numbers, attached[1]], attached[2]
    return numbers, rest


def _units(entry: Entry) -> list[str]:
    """The units of all texts of an entry, empty where a text has none; before the last one without those of 0."""
    if isinstance(entry.value, tuple):
        units = [_units(each) for each in entry.value]
        bare = [each.value == "0" for each in entry.value]
        return [unit for own, nought in zip(units[:-1], bare[:-1], strict=True) if not nought for unit in own] + (
            units[-1] if units else []
        )
    numbers, unit = _parted(entry.value) if isinstance(entry.value, str) else ([], "")
    return [unit] if numbers else [""]


def _is_number(word: str) -> bool:
    match = _NUMBER.fullmatch(word)
    return match is not None and match[2] is None


def _is_row(value: object) -> bool:
    """Whether a text begins with two numbers."""
    return isinstance(value, str) and len(_parted(value)[0]) > 1


def _with_unit(entry: Entry, unit: str) -> Entry:
    bare = isinstance(entry.value, str) and _is_number(entry.value.strip())
    return replace(entry, value=f"{entry.value} {unit}".strip()) if bare else entry


@dataclass(frozen=True)
class Text:
    """A text.

    Attributes:
        choices: texts that are allowed; empty: any.
    """

    choices: tuple[str, ...] = ()

    def read(self, entry: Entry, around: Around) -> str:
        """The text."""
        text = entry.text(f"one of {', '.join(self.choices)}" if self.choices else "one text")
        if self.choices and text not in self.choices:
            entry.refuse(f"{text!r} is not known here{suggestion(text, self.choices)}", f"write one of {', '.join(self.choices)}")
        return text


@dataclass(frozen=True)
class Names:
    """Names with blanks between them, or in a list."""

    def read(self, entry: Entry, around: Around) -> list[str]:
        """The names."""
        return entry.names("names with blanks between them")


@dataclass(frozen=True)
class Whole:
    """A whole number."""

    def read(self, entry: Entry, around: Around) -> int:
        """The number."""
        text = entry.text("a whole number")
        return int(text) if re.fullmatch(r"[-+]?\d{1,9}", text) else entry.refuse(f"{text!r} is no whole number", "write one, such as 12")


@dataclass(frozen=True)
class Truth:
    """Yes or no."""

    def read(self, entry: Entry, around: Around) -> bool:
        """Whether it is yes."""
        if isinstance(entry.value, bool):
            return entry.value
        text = entry.text("yes or no")
        known = {"yes": True, "true": True, "no": False, "false": False}
        return known[text.lower()] if text.lower() in known else entry.refuse(f"{text!r} is neither yes nor no", "write yes or no")


@dataclass(frozen=True)
class DataFile:
    """The path of a file, relative to the file in which it stands."""

    def read(self, entry: Entry, around: Around) -> Path:
        """The path, from the current folder."""
        path = entry.folder / entry.text("the path of a file")
        around.files.append(path)
        return path


class Fields(dict[str, Any]):
    """Values of several fields from one key."""


@dataclass(frozen=True)
class DataColumns:
    """A CSV file of two columns in place of fields. A first line without numbers is a header, which may name other units.

    Attributes:
        names: of both columns.
        units: SI units of both columns.
        bare: units of numbers without a header.
        into: name of the field that takes the pairs, or of one field for each column.
        sliding: name, SI unit and unit without a header of the second column where the driver slides.
    """

    names: tuple[str, str]
    units: tuple[str, str]
    bare: tuple[str, str]
    into: tuple[str, ...]
    sliding: tuple[str, str, str] | None = None

    def read(self, entry: Entry, around: Around) -> Fields:
        """The pairs, or the columns by the names of their fields [units]."""
        path = DataFile().read(entry, around)
        (first, second), (one, two), (bare_one, bare_two) = self.names, self.units, self.bare
        if self.sliding is not None and not around.coordinate.turns:
            second, two, bare_two = self.sliding
        with naming(entry):
            table = read_columns(path, {first: Wanted(one, bare=bare_one), second: Wanted(two, bare=bare_two)}, by_order=True)
        columns = [column.tolist() for column in table.values.values()]
        return Fields({self.into[0]: list(zip(*columns, strict=True))} if len(self.into) == 1 else zip(self.into, columns, strict=True))


@dataclass(frozen=True)
class Part(Generic[T]):
    """The fields of a dataclass, or the arguments of a function, by their names.

    Attributes:
        made: the dataclass whose declared fields are the keys.
        example: as a part stands in a file, in braces.
        keys: further keys, and those that are read in another way than their field is declared.
        without: fields that are no keys.
        needed: further keys that must be there.
        finish: makes the part of ``made`` and the values; None: ``made`` does.
        said: what the keys describe, for the manual.
    """

    made: Callable[..., T]
    example: str
    keys: Mapping[str, Value] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()
    finish: Callable[[Callable[..., T], dict[str, Any]], Any] | None = None
    said: str = ""

    @cached_property
    def values(self) -> Mapping[str, Value]:
        """All keys with what may stand at them, in the order of the fields."""
        fields = (each for each in in_signature(self.made) if each.name not in self.without) if is_dataclass(self.made) else ()
        values = {each.name: self.keys[each.name] if each.name in self.keys else value_of(each) for each in fields}
        return values | {name: value for name, value in self.keys.items() if name not in values}

    @cached_property
    def required(self) -> tuple[str, ...]:
        """Keys that must be there."""
        fields = in_signature(self.made) if is_dataclass(self.made) else ()
        lacking = (each.name for each in fields if each.default is each.default_factory is MISSING)
        return (*(name for name in lacking if name not in self.without), *self.needed)

    def read(self, entry: Entry, around: Around) -> T:
        """The part."""
        value: Any = entry.value
        if is_dataclass(self.made) and isinstance(value, self.made):
            return value  # type: ignore[return-value]
        return self.of(entry, entry.known(tuple(self.values), self.example), around)

    def of(self, entry: Entry, items: Mapping[str, Entry], around: Around) -> T:
        """The part of these known keys of an entry."""
        refuse_missing(entry, items, self.required, f"e.g. {self.example}")
        if "exponent" in self.values:  # the unit of other keys has it
            given = items.get("exponent")
            default: Any = next(each.default for each in in_signature(self.made) if each.name == "exponent")
            around = replace(around, exponent=float(default) if given is None else Number("-").read(given, around))
        arguments: dict[str, Any] = {}
        for name, each in items.items():
            value = self.values[name].read(each, around)
            arguments |= value if isinstance(value, Fields) else {name: value}
        with naming(entry, items):
            return self.made(**arguments) if self.finish is None else self.finish(self.made, arguments)


def value_of(each: Field[Any]) -> Value:
    """What may stand at the key of a dataclass's field, by its declaration.

    Raises:
        TypeError: nothing is declared of the field, and its type does not say.
    """
    known = declared(each)
    if known is not None:
        return Numbers(known.unit) if known.axes else Number(known.unit)
    types: Mapping[str, Value] = {"str": Text(), "int": Whole(), "bool": Truth()}
    name = str(each.type).removesuffix(" | None")
    if name not in types:
        raise TypeError(f"what stands at {each.name} is not declared")
    return types[name]


@dataclass(frozen=True)
class OneOf:
    """A part of one of several kinds.

    Attributes:
        kinds: name of a kind -> its part.
        usual: the kind of an entry that names none; None: it must name one.
    """

    kinds: Mapping[str, Part[Any]]
    usual: str | None = None

    def read(self, entry: Entry, around: Around) -> Any:
        """The part of the kind that the entry names."""
        value: Any = entry.value
        for part in self.kinds.values():
            if is_dataclass(part.made) and isinstance(value, part.made):
                return value
        first, *_ = self.kinds
        remedy = f"write one of {', '.join(self.kinds)}"
        if isinstance(entry.value, str) and entry.value in self.kinds:  # a kind that needs no keys
            return self.kinds[entry.value].of(entry, {}, around)
        items = dict(entry.items(f"{{kind: {first}, ...}}"))
        kind = items.pop("kind", None)
        if kind is None and self.usual is None:
            entry.refuse("kind is missing", remedy)
        name = self.usual or "" if kind is None else kind.text(remedy)
        if name not in self.kinds:
            assert kind is not None
            known = next(each for each in self.kinds.values() if each.example)
            kind.refuse(f"no kind {name!r}{suggestion(name, self.kinds)}", f"{remedy}, e.g. {known.example}")
        part = self.kinds[name]
        entry.refuse_unknown(items, tuple(part.values))
        return part.of(entry, items, around)


@dataclass(frozen=True)
class Whichever:
    """A part of one of several kinds, which a key of it tells.

    Attributes:
        parts: a key -> the part that has it; the last one is the part without any of these keys.
    """

    parts: Mapping[str, Part[Any]]

    def read(self, entry: Entry, around: Around) -> Any:
        """The part that has the keys of the entry."""
        *_, last = self.parts.values()
        items = entry.items(last.example)
        return next((part for key, part in self.parts.items() if key in items), last).read(entry, around)


@dataclass(frozen=True)
class Either:
    """A value alone, or a part with keys.

    Attributes:
        alone: what stands alone.
        part: what stands with keys.
        into: the only argument of the part where the value stands alone; None: the value itself is what is read.
    """

    alone: Value
    part: Value
    into: Callable[[Any], Any] | None = None

    def read(self, entry: Entry, around: Around) -> Any:
        """The value, or the part."""
        if isinstance(entry.value, str | float) or (isinstance(entry.value, tuple) and isinstance(self.alone, Rows)):
            value = self.alone.read(entry, around)
            with naming(entry):
                return value if self.into is None else self.into(value)
        return self.part.read(entry, around)


@dataclass(frozen=True)
class Listed:
    """A list of values; one value may stand alone.

    Attributes:
        each: what stands in it.
        several: whether each of them is read as several, which are put behind each other.
    """

    each: Value
    several: bool = False

    def read(self, entry: Entry, around: Around) -> list[Any]:
        """The values."""
        entries = entry.value if isinstance(entry.value, tuple) else (entry,)
        read = [self.each.read(one, around) for one in entries]
        return [each for some in read for each in some] if self.several else read


@dataclass(frozen=True)
class Named:
    """Values by names.

    Attributes:
        each: what stands at a name.
        example: such entries in a file.
    """

    each: Value
    example: str = "{name: ...}"

    def read(self, entry: Entry, around: Around) -> dict[str, Any]:
        """The values by their names."""
        return {name: self.each.read(one, around) for name, one in entry.items(self.example).items()}


def refuse_missing(entry: Entry, items: Mapping[str, Entry], names: Sequence[str], remedy: str) -> None:
    """Refuse an entry that lacks keys."""
    missing = [name for name in names if name not in items]
    if missing:
        entry.refuse(f"{' and '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing", f"write {remedy}")


@contextmanager
def naming(entry: Entry, items: Mapping[str, Entry] | None = None) -> Iterator[None]:
    """Let errors about arguments name the entry from which they are, or the one of these keys; errors about a press stay as they are."""
    try:
        yield
    except PinpressError as error:
        if type(error) not in (PinpressError, UnknownNameError):
            raise
        _refuse_as(entry, items or {}, str(error))


def _refuse_as(entry: Entry, items: Mapping[str, Entry], text: str) -> NoReturn:
    problem, *rest = _REMEDY.split(text, maxsplit=1)
    prefix = re.match(r"[A-Z]\w+: (?=(\w+))", problem)  # of the class, whose fields are the keys
    if prefix is not None and prefix[1] in items:
        entry, problem = items[prefix[1]], problem[prefix.end() :].removeprefix(f"{prefix[1]} is ")
    rest = [each.replace(", or an array (S,) of them", "") for each in rest]
    entry.refuse(problem, rest[0] if rest else "write another value")
