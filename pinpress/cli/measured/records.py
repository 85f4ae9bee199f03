"""Options of commands that read records of a running press or identify a press."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...common.errors import PinpressError, shown
from ..options import number

if TYPE_CHECKING:
    from ...measured.records import MeasuredRun


def add_column_options(parser: argparse.ArgumentParser) -> None:
    """Options of `read_record`: columns, gears and the encoder, the same for all records of a command."""
    option = parser.add_argument
    option("--angle", required=True, metavar="COLUMN", help="angle of the crank or the motor, rad, deg, turns or counts")
    option("--torque", required=True, metavar="COLUMN", help="torque of the motor, N m or kN m, or its current, A")
    option("--time", metavar="COLUMN", help="column of the time (default: time or t)")
    option("--ratio", type=float, default=1.0, metavar="R", help="motor turns / crank turns, for the torque (default: 1)")
    option("--angle-ratio", type=float, default=1.0, metavar="R", help="encoder turns / crank turns (default: 1)")
    option(
        "--offset", type=float, default=0.0, metavar="A", help="reading of the angle's column at crank angle 0, in its unit (default: 0)"
    )
    option("--counts", type=float, metavar="N", help="counts of the encoder in a turn, for an angle in counts")


def read_record(options: argparse.Namespace, file: str, **more: Any) -> MeasuredRun:
    """Read a record by `add_column_options`; ``more`` goes to `measured.record`. Raises as `measured.record`."""
    from ...measured.records import record  # to save start-up time

    asked = {name: getattr(options, name) for name in ("torque", "time", "ratio", "angle_ratio", "counts")}
    return record(file, options.angle, **asked, zero=options.offset, **more)


def add_identification_options(parser: argparse.ArgumentParser) -> None:
    """Options of `identification` and --drive-inertia."""
    option = parser.add_argument
    option("--prior", type=float, default=0.2, metavar="P", help="share by which masses may differ from the description (default: 0.2)")
    option(
        "--known",
        action="append",
        default=[],
        metavar="NAME=VALUE,SD",
        help='weighed or gauged value with standard deviation, in SI units: "slide mass=2200,5"; may be given several times',
    )
    option(
        "--friction",
        default="crank,slide_guide",
        metavar="KINDS",
        help="kinds of friction: crank, pins, slide_guide, gibs, or none (default: %(default)s)",
    )
    option("--cylinder", action="store_true", help="a balance cylinder carries the slide")
    option(
        "--drive-inertia",
        type=number("kg m2"),
        default=0.0,
        metavar="J",
        help="inertia of motor, gears and flywheel at the crank, such as 1200kg m2",
    )


def identification(options: argparse.Namespace) -> dict[str, Any]:
    """Arguments of `measured.identify` and `measured.identifiability` from `add_identification_options`."""
    friction = [] if options.friction == "none" else options.friction.split(",")
    return {"prior": options.prior, "known": _known(options.known), "friction": friction, "cylinder": options.cylinder}


def identification_in_words(options: argparse.Namespace) -> list[tuple[str, str]]:
    """The same, as `print_inputs` takes it."""
    given = [("prior", f"{options.prior:g}"), ("friction", options.friction)]
    given += [("known", "; ".join(options.known))] if options.known else []
    return [*given, *([("cylinder", "yes")] if options.cylinder else [])]


def _known(words: Sequence[str]) -> Mapping[str, tuple[float, float]]:
    """Values and standard deviations by the names of parameters."""
    found: dict[str, tuple[float, float]] = {}
    for text in words:
        name, _, numbers = text.partition("=")
        try:
            value, deviation = (float(each) for each in numbers.split(","))
        except ValueError:
            raise PinpressError(
                f"--known {shown(text)} is not a value with its standard deviation: write NAME=VALUE,SD, as in --known 'slide mass=2200,5'"
            ) from None
        found[name.strip()] = value, deviation
    return found
