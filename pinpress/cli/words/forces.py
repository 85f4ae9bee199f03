"""Options of forces on a press: loads, springs between links, friction, flywheel, and stiffnesses that share forces."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TypedDict

from ...linkage.linkage import Linkage
from ...loads.link import Friction, Load
from . import part_specs
from .part_specs import ALL


def add_force_options(parser: argparse.ArgumentParser, *, friction: bool = True, stiffness: bool = True) -> None:
    """Options of `forces`: loads and springs, and on request friction and stiffnesses of bearings."""
    option = parser.add_argument
    option("--load", metavar="KIND:KEYS", action="append", default=[], help="process load, see below; may be given several times")
    option("--spring", metavar="KEYS", action="append", default=[], help="spring, see below; may be given several times")
    if friction:
        option("--friction", metavar="NAME:KEYS", action="append", default=[], help="friction of a bearing or guide, or of all, see below")
    if stiffness:
        option(
            "--stiffness",
            metavar="NAME=N/m",
            action="append",
            default=[],
            help=f"stiffness of a bearing, or with {ALL}= of all other bearings; it shares the forces of redundant bearings"
            "; may be given several times",
        )


def add_flywheel_option(parser: argparse.ArgumentParser, meaning: str, *, several: bool = False) -> None:
    """Option --flywheel; ``meaning``: the end of its help; ``several``: whether it may be given several times."""
    action, default = ("append", list[str]()) if several else ("store", None)
    parser.add_argument("--flywheel", metavar="J", action=action, default=default, help=f"inertia at the driver joint, in kg m2; {meaning}")


class Forces(TypedDict):
    """Forces on the links in addition to gravity, as arguments of `inverse_dynamics`."""

    loads: list[Load]
    friction: dict[str, Friction]
    stiffness: dict[str, float]


def loads(options: argparse.Namespace) -> list[Load]:
    """The process loads and springs of `add_force_options`."""
    springs = (part_specs.part("--spring", part_specs.SPRING, words) for words in options.spring)
    return [*map(part_specs.load, options.load), *springs]


def forces(options: argparse.Namespace, press: Linkage) -> Forces:
    """Loads, springs, friction and stiffnesses of `add_force_options`.

    Raises:
        PinpressError: A text does not describe a part; see `part_specs`.
    """
    stiffness = part_specs.by_bearing("--stiffness", options.stiffness, "N/m", "stiffness", "1e9")
    return {
        "loads": loads(options),
        "friction": part_specs.frictions(options.friction, press),
        "stiffness": with_others(stiffness, press.bearings),
    }


def with_others(given: dict[str, float], names: Sequence[str]) -> dict[str, float]:
    """Numbers by names; of ``names`` without a number, with the number of `ALL`."""
    if ALL not in given or ALL in names:
        return given
    return dict.fromkeys(names, given[ALL]) | {name: number for name, number in given.items() if name != ALL}
