"""Numbers of a pin table: plain numbers and formulas of parameters. Angles in formulas are in degrees."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ..common.errors import suggestion
from .reading import Entry

LONGEST = 200  # characters of a formula
LARGEST = 1e12  # largest number of a table, as in a URDF: powers and products of such numbers are finite
CONSTANTS = {"pi": math.pi}
FUNCTIONS: Mapping[str, Callable[..., float]] = {
    "sqrt": math.sqrt,
    "hypot": math.hypot,
    "abs": abs,
    "min": min,
    "max": max,
    "sin": lambda angle: math.sin(math.radians(angle)),
    "cos": lambda angle: math.cos(math.radians(angle)),
    "tan": lambda angle: math.tan(math.radians(angle)),
    "asin": lambda x: math.degrees(math.asin(x)),
    "acos": lambda x: math.degrees(math.acos(x)),
    "atan": lambda x: math.degrees(math.atan(x)),
    "atan2": lambda y, x: math.degrees(math.atan2(y, x)),
}
_OPERATIONS: Mapping[type[ast.AST], Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}


@dataclass(frozen=True)
class Numbers:
    """How the numbers of a table are read.

    Attributes:
        parameters: name -> value.
        unit: the table's unit of length [m].
    """

    parameters: Mapping[str, float]
    unit: float

    def number(self, entry: Entry) -> float:
        """A plain number or the value of a formula, as `number` reads it."""
        return number(entry, self.parameters)

    def above_zero(self, entry: Entry, what: str) -> float:
        """A number above zero; messages call it ``what``."""
        value = self.number(entry)
        if value <= 0:
            entry.refuse(f"{what} of {value:.6g}", "write a value above zero")
        return value

    def length(self, entry: Entry) -> float:
        """A length of any sign [m]."""
        return self.number(entry) * self.unit


def parameters_of(table: Mapping[str, Entry]) -> dict[str, float]:
    """Evaluate ``parameters``. A parameter may use the parameters before it."""
    values: dict[str, float] = {}
    if "parameters" in table:
        for name, entry in table["parameters"].items("names with numbers: {r: 150}").items():
            if not name.isidentifier() or name in CONSTANTS or name in FUNCTIONS:
                entry.refuse(f"{name!r} cannot name a parameter", "write a word of letters and digits, such as r or l4")
            values[name] = number(entry, values)
    return values


def number(entry: Entry, parameters: Mapping[str, float]) -> float:
    """Read the number of an entry: a plain number or a formula.

    Raises:
        PinTableError: the entry has no number, or its number is not finite or out of range.
    """
    value = entry.value if isinstance(entry.value, float) else formula(entry, parameters)
    if not math.isfinite(value):
        entry.refuse(f"{entry.value} is not a finite number", "write a number")
    if abs(value) > LARGEST:
        entry.refuse(f"{value:.6g} is out of range: {LARGEST:g} is the largest number", "check numbers and units against the drawing")
    return value


def formula(entry: Entry, names: Mapping[str, float]) -> float:
    """Evaluate a formula of names.

    Raises:
        PinTableError: the text is not a formula, has an unknown name, or has no value.
    """
    if not isinstance(entry.value, str):
        entry.refuse(f"{entry.described()} where a number belongs", "write a number or a formula")
    text = entry.value.strip()
    if not text or len(text) > LONGEST:
        entry.refuse(f"a text of {len(text)} characters is not a number", "write a number or a formula")
    for written in _WRITTEN.findall(text):
        if not _PLAIN.fullmatch(written):  # before Python warns of 7in
            entry.refuse(f"{written!r}{f' in {text!r}' * (written != text)} is not a number", _remedy(text))
    try:
        return _value(ast.parse(text, mode="eval").body, names)
    except (SyntaxError, ValueError, TypeError) as error:
        reason = " (out of a function's range)" if "domain" in str(error) else ""
        entry.refuse(f"{text!r} is not a number{reason}", _remedy(text))
    except NameError as error:
        meant = suggestion(error.args[0], [*names, *CONSTANTS, *FUNCTIONS])
        remedy = f"add it to parameters ({'now ' + ', '.join(names) if names else 'now empty'})"
        entry.refuse(f"{error.args[0]!r} in {text!r} is not a parameter{meant}", remedy)
    except (ZeroDivisionError, OverflowError, RecursionError, MemoryError):
        entry.refuse(f"{text!r} has no finite value", "write a formula with a finite value")


_WRITTEN = re.compile(r"(?<![\w.])\.?\d(?:[eE][-+](?=\d)|[\w.])*")  # numbers, with letters and underscores that touch them
_PLAIN = re.compile(r"(?:\d+\.\d*|\.\d+|0|[1-9]\d*)(?:[eE][-+]?\d+)?", re.ASCII)  # unlike 0x10, 0144 and 1_000, of which Python reads some


def _remedy(text: str) -> str:
    if "," in text:
        return "write decimals after a point, not after a comma"
    if re.fullmatch(r"[-+.\deE]+\s*[^\W\d_][^\s(]*|[-+.\deE]+\s*[°%\"]", text):
        return "leave the unit out: lengths are in the table's units, angles in degrees, masses in kg, moments of inertia in kg m2"
    return "write a number, or a formula such as 2 * r + 10"


def _value(node: ast.expr, names: Mapping[str, float]) -> float:
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
        return float(node.value)
    if isinstance(node, ast.Name):
        known = {**CONSTANTS, **names}
        if node.id not in known:
            raise NameError(node.id)
        return known[node.id]
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        return _OPERATIONS[type(node.op)](_value(node.left, names), _value(node.right, names))
    if isinstance(node, ast.UnaryOp) and type(node.op) in _OPERATIONS:
        return _OPERATIONS[type(node.op)](_value(node.operand, names))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        if node.func.id not in FUNCTIONS:
            raise NameError(node.func.id)
        return float(FUNCTIONS[node.func.id](*(_value(each, names) for each in node.args)))
    raise ValueError("not arithmetic")
