"""Shift of the bottom dead centre of a warm press.

    warm = tolerances.Temperatures({"rocker": 10.0, "rod": 10.0, "frame": 4.0}, table=-1.88)
    tolerances.heat(press, warm).bottom_shift

A link that is warmer by dT grows by the share a dT in all directions, with a the coefficient of linear expansion; so do the distances of
its pins. A warm frame moves bearings and guides away from its table. To first order in a dT, about 1e-4, the slide's motion follows from
virtual work, see `virtual_work`. The result is the height of the slide's face above the table, which grows by a dT if all parts are equally
warm.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..common import plausibility
from ..common.arguments import number, typed
from ..common.errors import PinpressError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import Array
from ..common.results import Tabular
from ..derivatives.motion import Displacements, nowhere
from ..kinematics.motion import Motion, of_states
from ..kinematics.servo_motion import servo_cycle
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress
from .dead_centre_scatter import ends_of, refuse_several_drivers
from .dimensions import refuse_unknown
from .virtual_work import unit_forces

STEEL = 12e-6  # linear expansion of structural steel up to 100 degrees Celsius, EN 1993-1-1:2005, 3.2.6 [1/K]


@dataclass(frozen=True, eq=False)
class Temperatures(Checked):
    """Temperature rises of the parts of a press since it was measured or set.

    Attributes:
        rise: name of a link, or of the frame -> rise of its temperature, negative if it is colder [K].
        expansion: coefficient of linear expansion of all links, or name of a link -> its coefficient [1/K]. The default, also for links
            that are not named, is structural steel of EN 1993-1-1, 3.2.6; grey cast iron has about 1e-5.
        table: position of the table in world coordinates along `Linkage.slide_direction`, required for a warm frame [m].
        face: position of the slide's face, or of the die on it, from the slide's origin along the same direction (negative below the
            origin), required for a warm slide [m].
    """

    rise: Mapping[str, float]
    expansion: float | Mapping[str, float] = STEEL
    table: float | None = field(default=None, metadata=parameter("m"))
    face: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        if not isinstance(self.rise, Mapping) or not self.rise:
            raise PinpressError(f"Temperatures: rise is {shown(self.rise)}: give a mapping, name of a link: rise [K], e.g. {{'rod': 10.0}}")
        rises = {name: number(f"Temperatures: rise of {shown(name)}", value, "K") for name, value in self.rise.items()}
        for name, kelvins in rises.items():
            if abs(kelvins) > 100.0:
                caution(
                    f"Temperatures: rise of {shown(name)} is {kelvins:g} K, more than usual: give the rise since the press was set, not the"
                    " temperature of the link"
                )
        named = self.expansion if isinstance(self.expansion, Mapping) else {"all links": self.expansion}
        coefficients = {name: number(f"Temperatures: expansion of {name}", value, "1/K") for name, value in named.items()}
        for name, value in coefficients.items():
            if not 0.0 <= value <= 1e-4:
                raise PinpressError(
                    f"Temperatures: expansion of {name} is {value:g} 1/K: give 0 to 0.0001 1/K; steel has 1.2e-5, aluminium 2.4e-5"
                )
        set_field(self, "rise", FrozenMapping(rises))
        set_field(self, "expansion", FrozenMapping(coefficients) if named is self.expansion else coefficients["all links"])
        super().__post_init__()

    def of(self, link: str) -> float:
        """Coefficient of a link [1/K]."""
        return self.expansion.get(link, STEEL) if isinstance(self.expansion, Mapping) else self.expansion

    def times(self, share: float) -> Temperatures:
        """These temperatures, with all rises multiplied by a share."""
        return Temperatures({name: share * value for name, value in self.rise.items()}, self.expansion, self.table, self.face)


@dataclass(frozen=True, eq=False, repr=False)
class HeatShift(OfPress, Tabular):
    """Shifts of a press's dead centres by warm links. A shift is that of the slide's face from the table, positive upwards.

    Attributes:
        press_name: name of the press.
        rise: name of a link -> rise of its temperature [K].
        bottom_by_link: name of a warm link -> its part of the shift of bottom dead centre [m].
        top_by_link: name of a warm link -> its part of the shift of top dead centre [m].
        bottom_per_kelvin: name of a link, warm or not -> shift of bottom dead centre per kelvin [m/K]; without frame or slide if the
            position of table or face is not given.
    """

    _press: Linkage
    rise: Mapping[str, float]
    bottom_by_link: Mapping[str, float]
    top_by_link: Mapping[str, float]
    bottom_per_kelvin: Mapping[str, float]

    @property
    def bottom_shift(self) -> float:
        """Shift of bottom dead centre [m]."""
        return float(sum(self.bottom_by_link.values()))

    @property
    def top_shift(self) -> float:
        """Shift of top dead centre [m]."""
        return float(sum(self.top_by_link.values()))

    @property
    def title(self) -> str:
        return f"HeatShift of {self.press_name}: bottom dead centre {self.bottom_shift:+.4g} m off"

    def columns(self) -> dict[str, object]:  # type: ignore[override]  # words and numbers
        """A row for each link in ``bottom_per_kelvin``."""
        names = list(self.bottom_per_kelvin)
        return {
            "link": names,
            "rise [K]": [self.rise.get(name, 0.0) for name in names],
            "bottom_shift [m]": [self.bottom_by_link.get(name, 0.0) for name in names],
            "top_shift [m]": [self.top_by_link.get(name, 0.0) for name in names],
            "bottom_per_kelvin [m/K]": [self.bottom_per_kelvin[name] for name in names],
        }


@typed
def heat(press: Linkage, temperatures: Temperatures, *, motion: Motion | None = None) -> HeatShift:
    """Compute the shifts of a press's dead centres by warm links and a warm frame.

    If parallel rods with different temperatures hold the slide, the slide takes their mean; see `parallelism` for the tilt.

    Args:
        press: a press with a slide, in a plane or in space.
        temperatures: temperature rises of the links and the frame.
        motion: the motion of the drivers, as in `bottom_dead_centre`; None: one crank turns through the dead centres.

    Raises:
        UnknownNameError: the press does not have a link with this name.
        PinpressError: welded links have different temperatures; the frame is warm without a table, or the slide without a face; the press
            has no slide, several drivers and no motion, or no dead centres; the motion belongs to another press.
    """
    rises = _by_body(press, temperatures.rise)
    coefficients = _by_body(press, temperatures.expansion) if isinstance(temperatures.expansion, Mapping) else {}
    frame, slide = 0, press.slide_guide.joint + 1
    assert press.slide is not None  # it has a guide
    for body, link, name, place in (
        (frame, press.root, "table", temperatures.table),
        (slide, press.slide, "face", temperatures.face),
    ):
        if place is not None:
            plausibility.length(f"Temperatures: {name}", abs(float(place)), press.size)
        elif rises.get(body):
            raise PinpressError(f"{link!r} of {press.name} is warm: give the position of its {name}, Temperatures(..., {name}=...) [m]")
    if motion is None:
        refuse_several_drivers(press)
        turned = dead_centres(press)
        ends = servo_cycle(press, [turned.bottom_angle, turned.top_angle], speed=0.0)
    else:
        x = motion.joint_position[list(ends_of(press, motion))].T.copy()
        ends = of_states(press, x, np.zeros_like(x), np.zeros_like(x), np.zeros(2), None)
    unit = unit_forces(press, ends)
    names = {press.frame_of(link).parentJoint: link for link in reversed(list(temperatures.rise))}  # of welded links the first
    per_kelvin: dict[str, Array] = {}
    for body in range(press.model.njoints):
        shift = unit.shift(_growth(press, body))
        if body == frame:
            if temperatures.table is None:
                continue
            shift = shift - temperatures.table
        elif body == slide:
            if temperatures.face is None:
                continue
            up = press.model.jointPlacements[slide].rotation.T @ press.slide_direction
            shift = shift + float(press.frame_of(press.slide).placement.translation @ up) + temperatures.face
        per_kelvin[names.get(body, press.link_of(body))] = coefficients.get(body, temperatures.of("")) * shift
    warm = {names[body]: value for body, value in rises.items() if value}
    bottom, top = ({name: value * float(per_kelvin[name][end]) for name, value in warm.items()} for end in (0, 1))
    return HeatShift(
        press,
        FrozenMapping(dict(temperatures.rise)),
        FrozenMapping(bottom),
        FrozenMapping(top),
        FrozenMapping({name: float(slopes[0]) for name, slopes in per_kelvin.items()}),
    )


def _growth(press: Linkage, body: int) -> Displacements:
    """Displacements of the pivots of a body for a relative growth of 1, from the origin of its frame."""
    moved = nowhere(press)
    for joint, parent in enumerate(list(press.model.parents)[1:]):
        if parent == body:
            moved.joints[joint] = press.model.jointPlacements[joint + 1].translation
    for k, loop in enumerate(press.loops):
        for side, (carrier, point) in enumerate(((loop.joint1, loop.point1), (loop.joint2, loop.point2))):
            if carrier == body:
                moved.ends[k, side] = point
    return moved


def _by_body(press: Linkage, by_link: Mapping[str, float]) -> dict[int, float]:
    """Index of a Pinocchio joint -> the value of its body's links.

    Raises:
        UnknownNameError: the press does not have a link with this name.
        PinpressError: welded links have different values.
    """
    values: dict[int, float] = {}
    for name, value in by_link.items():
        refuse_unknown("link", name, press.links)
        body = press.frame_of(name).parentJoint
        if values.get(body, value) != value:
            raise PinpressError(
                f"{shown(name)} of {press.name} is welded to a link with another value: give both links the same value, or name only one"
            )
        values[body] = value
    return values
