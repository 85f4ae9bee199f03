"""What a result was computed from, in words, so that a page or a printed summary can still be understood years later.

Loads, drives and other parts are described by their class and fields, ``Blanking(force=1000 kN, start=6 mm, end=2 mm)``, in the units that
press builders use. Fields that have no value are left out, and those that must be named and have their default.
"""

import datetime
import hashlib
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..common.errors import shown
from ..common.parameters import declared, in_signature
from ..common.quantities import CRANK, GRAVITY, RAM, DriverCoordinate, quantity
from ..kinematics.main_data import tool_in_words
from ..kinematics.motion import Motion, is_constant, is_cycle
from ..linkage import loading
from ..linkage.linkage import Linkage
from ..linkage.writing import is_as_read
from ..loads.link import Friction, Spring
from .reactions import Reactions

FEW = 4  # numbers that are written out; of more their count and range
DIGITS = 9
STANDARD_GRAVITY = (0.0, 0.0, -GRAVITY)

Inputs = Sequence[tuple[str, str]]
"""Names of inputs and what they are, in words."""


def inputs(reactions: Reactions, motion: str = "", drives: Inputs = (), how: str = "") -> Inputs:
    """Press and file, motion, passive coordinates, loads, friction and stiffnesses of reactions, and by what and when they were stated.

    Args:
        reactions: the reactions.
        motion: the motion in words, where they are not those of `motion_in_words`.
        drives: what drives the press.
        how: how the motion was found.
    """
    return [
        *of_press(reactions._press),
        ("motion", motion or motion_in_words(reactions.motion)),
        *drives,
        *([("passive coordinates", reactions.passive)] if reactions._press.passive else []),
        *of_loads(reactions.loads),
        *of_friction(reactions.friction),
        *([("stiffness", _by_bearing(reactions.stiffness, "N/m"))] if reactions.stiffness else []),
        stated(f"engine {reactions.engine!r}{how}"),
    ]


def stated(how: str = "") -> tuple[str, str]:
    """By what a result was computed, and the day on which that is stated."""
    version = sys.modules[__name__.partition(".")[0]].__version__  # of the package, which cannot be imported from its own modules
    return "computed by", ", ".join(part for part in (f"pinpress {version}", how, f"on {datetime.date.today().isoformat()}") if part)


def of_press(press: Linkage) -> Inputs:
    """The press, the file that it is from, where process forces act on it, and where crank angles are 0 and what gravity is, where they are
    not as usual."""
    drivers = f"{'joints' if len(press.motors) != 1 else 'joint'} {', '.join(press.motors) or 'none'}"
    slide = f"its slide is link {press.slide}" if press.slide else "it has no slide"
    rows = [("press", f"{press.name}, driven at {drivers}; {slide}"), ("file", _file_in_words(press))]
    rows += [] if press.slide is None else [("process", f"force acts {tool_in_words(press)}")]
    rows += [("crank angles", f"counted from {press.zero}")] if press.zero else []
    rows += [("passive", f"joints {', '.join(press.passive)}, without a motor")] if press.passive else []
    coordinates = [CRANK if axis.turns else RAM for axis in press.axes]
    rows += [("spring in a joint", described(each, coordinates[press.joints.index(each.joint)])) for each in press.joint_springs]
    rotors = zip(press.joints, press.model.armature, coordinates, strict=True)
    armature = [f"{value:.{DIGITS}g} {each.in_place_of('kg m2')} at {name}" for name, value, each in rotors if value]
    rows += [("rotors", f"inertia {', '.join(armature)}")] if armature else []
    gravity = tuple(float(part) for part in press.model.gravity.linear)
    return rows if gravity == STANDARD_GRAVITY else [*rows, ("gravity", f"{_numbers(np.array(gravity))} m/s2")]


def _file_in_words(press: Linkage) -> str:
    """The file with the first digits of its contents' SHA-256, and whether the press was changed after it was read."""
    shipped = Path(press.file).stem in loading.presses() and str(loading.locate(Path(press.file).stem)) == press.file
    place = f"{Path(press.file).name}, shipped with pinpress" if shipped else press.file
    changed = "" if is_as_read(press) else "; the press was changed after reading it"
    return f"{place}, SHA-256 of the URDF {hashlib.sha256(press.text).hexdigest()[:16]}{changed}"


def motion_in_words(motion: Motion) -> str:
    """Speed, duration and number of states of a motion."""
    states, first = f"{len(motion.crank_angle)} {'state' if len(motion.crank_angle) == 1 else 'states'}", motion.driver_coordinates[0]
    unit = f"{first.unit}/s"
    if motion.crank_speed.ndim == 1 and first.turns and is_constant(motion.crank_speed):
        speed = written(motion.crank_speed[0], unit)
        return f"one period at {speed}, {states}" if is_cycle(motion) else f"constant speed, {speed}, {states}"
    fastest = f"prescribed, {_speeds_in_words(motion)}"
    return f"{fastest}, {states}" if motion._time is None else f"{fastest}, over {motion.time[-1] - motion.time[0]:.6g} s, {states}"


def _speeds_in_words(motion: Motion) -> str:
    """How fast every driver is; of many the fastest of those that are like the first."""
    coordinates = motion.driver_coordinates
    first, fastest = coordinates[0], np.reshape(np.abs(motion.crank_speed), (-1, len(coordinates))).max(axis=0)
    if len(coordinates) == 1:
        return f"{first.part} at up to {written(fastest[0], f'{first.unit}/s', 6)}"
    if len(coordinates) > FEW:
        alike = [speed for speed, each in zip(fastest, coordinates, strict=True) if each.unit == first.unit]
        return f"{len(coordinates)} drivers, {first.part}s at up to {written(max(alike), f'{first.unit}/s', 6)}"
    parts = zip(motion.drivers, fastest, coordinates, strict=True)
    return ", ".join(f"{name} at up to {written(speed, f'{each.unit}/s', 6)}" for name, speed, each in parts)


def of_loads(loads: Sequence[object]) -> Inputs:
    """Loads and springs as they were given, or that there are none."""
    rows = [("spring" if isinstance(load, Spring) else "load", described(load)) for load in loads]
    return rows or [("loads", "none but weight")]


def of_friction(friction: Mapping[str, Friction]) -> Inputs:
    """Friction of bearings as it was given, or that there is none."""
    return [("friction", _by_bearing(friction) or "none")]


def _by_bearing(given: Mapping[str, Any], unit: str = "") -> str:
    """What bearings have, those that have the same together."""
    names: dict[str, list[str]] = {}
    for bearing, part in given.items():
        names.setdefault(written(part, unit), []).append(bearing)
    return "; ".join(f"{', '.join(bearings)}: {words}" for words, bearings in names.items())


def described(part: object, driver: DriverCoordinate = CRANK) -> str:
    """A load, drive or other part in words: "deep drawing: force = 100 kN, start = 20 mm", with units where they are declared.

    Args:
        part: the part.
        driver: coordinate of the driver on which it acts. Where this slides, it has forces in place of torques, but not behind gears.
    """
    if isinstance(part, str):  # it was described before it was sent here
        return part
    if not is_dataclass(part) or isinstance(part, type):
        return shown(part)
    words, parts = [], []
    for field in in_signature(part):
        value, known = getattr(part, field.name), declared(field)
        if value is not None and not (field.kw_only and value == field.default):
            name, said = field.name.replace("_", " "), written(value, "" if known is None else driver.in_place_of(known.unit))
            if is_dataclass(value):
                parts.append(f"{name}: {said}")
            else:
                words.append(f"{name} = {said}")
    kind = re.sub("(?<=[a-z])(?=[A-Z])", " ", type(part).__name__).lower()
    return "; ".join([f"{kind}: {', '.join(words)}" if words else kind, *parts])


def row(name: str, part: object, driver: DriverCoordinate = CRANK) -> tuple[str, str]:
    """A row of inputs with a part in words, which do not say its kind again where the name of the row says it."""
    return name, described(part, driver).removeprefix(f"{name}: ")


def written(value: object, unit: str, digits: int = DIGITS) -> str:
    """A value in words, numbers with their unit. ``unit``: the SI unit of numbers, empty for none."""
    if is_dataclass(value) and not isinstance(value, type):
        return described(value)
    if isinstance(value, str | bool) or callable(value):
        return value if isinstance(value, str) else getattr(value, "__qualname__", None) or shown(value)
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return shown(value)
    shown_in = quantity(unit or "-").scale(np.ravel(numbers).tolist())
    return f"{_numbers(shown_in.factor * numbers, digits)} {shown_in.unit}".strip()


def _numbers(values: Any, digits: int = DIGITS) -> str:
    if values.ndim == 0:
        return f"{float(values):.{digits}g}"
    if values.size <= FEW:
        return f"({', '.join(f'{value:.{digits}g}' for value in np.ravel(values))})"
    return f"{' x '.join(map(str, values.shape))} numbers from {values.min():.{digits}g} to {values.max():.{digits}g}"
