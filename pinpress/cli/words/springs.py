"""Options of elastic parts: stiffnesses, preloaded joints, clearances, and the frame on its mounts."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...common.errors import PinpressError, UnknownNameError
from ...linkage.linkage import Linkage
from ...loads.mounts import Frame, Mount
from ...simulation.elastic.description import Elastic, Stiffness
from . import part_specs
from .forces import with_others
from .part_specs import ALL, COLUMNS
from .press import add_refused_option

if TYPE_CHECKING:
    from ...foundation.mounted_press import MountedPress
    from ...kinematics.motion import Motion

FRAME_FILES = (".yaml", ".yml", ".json")


def add_spring_options(parser: argparse.ArgumentParser) -> None:
    """Options of `springs`."""
    option = parser.add_argument
    help = "the press runs on springs: stiffness of a bearing, or of all, see below; may be given several times"
    option("--stiffness", metavar="NAME=N/m", action="append", default=[], help=help)
    help = "stiffness of a guide against turning, see below"
    option("--moment-stiffness", metavar="NAME=Nm/rad", action="append", default=[], help=help)
    option("--elastic", metavar="KEYS", help="damping, shaft and frame of a press on springs, see below")
    option("--clearance", metavar="NAME:KEYS", action="append", default=[], help="clearance of a pin of a press on springs, see below")
    add_joint_option(parser)
    add_mount_options(parser, "a press on springs shakes it")
    why = "the loss factor of rubber needs one frequency; give --mount with stiffness= and damping= of the pad at the main frequency"
    add_refused_option(parser, "--pad", why)


def add_joint_option(parser: argparse.ArgumentParser) -> None:
    """Option --preloaded-joint."""
    help = "preloaded joint of a guide or the frame in place of its stiffness, see below; may be given several times"
    parser.add_argument("--preloaded-joint", metavar="NAME:KEYS", action="append", default=[], help=help)


def add_mount_options(parser: argparse.ArgumentParser, what: str) -> None:
    """Options of `mounted_press`; ``what``: happens with the frame, for the help."""
    option = parser.add_argument
    option("--frame", metavar="KEYS|FILE", help=f"the frame on its mounts, see below, or a frame file: {what}")
    option("--mount", metavar="KEYS", action="append", default=[], help="a mount below it, see below; may be given several times")


def springs(options: argparse.Namespace, press: Linkage) -> Elastic | None:
    """Read the springs on which a press runs from `add_spring_options`; None without springs.

    Raises:
        UnknownNameError: the press has no such bearing or guide.
        PinpressError: as for `part_specs`; also if a bearing or guide has no stiffness.
    """
    if not options.stiffness:
        beside = ("moment_stiffness", "elastic", "clearance", "preloaded_joint", "frame", "mount")
        alone = next((name for name in beside if getattr(options, name)), None)
        if alone is None:
            return None
        option = f"--{alone.replace('_', '-')}"
        raise PinpressError(f"{option} is for a press on springs: also give --stiffness of its bearings, e.g. --stiffness {ALL}=2e9")
    balls = {loop.name for loop in press.loops if loop.type == "spherical"}
    guides = [name for name, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
    turning_ones = guides if "plane" in press.engines else [name for name in press.bearings if name not in balls]
    across = part_specs.by_bearing("--stiffness", options.stiffness, "N/m", "stiffness", "2e9")
    turning = part_specs.by_bearing("--moment-stiffness", options.moment_stiffness, "N m/rad", "stiffness against turning", "2e8")
    also = part_specs.Yielding() if options.elastic is None else part_specs.part("--elastic", part_specs.ELASTIC, options.elastic)
    clearances = part_specs.clearances(options.clearance, press)
    joints = part_specs.joints(options.preloaded_joint, press)
    if COLUMNS in joints and also.frame is not None:
        raise PinpressError(
            f"--elastic frame={also.frame:g}: --preloaded-joint {COLUMNS} also describes the columns: leave out one of them"
        )
    stiffness = Stiffness(
        _of_all("--stiffness", across, press.bearings, "2e9") | {name: joint for name, joint in joints.items() if name != COLUMNS},
        moments=_of_all("--moment-stiffness", turning, turning_ones, "2e8"),
        shaft=also.shaft,
        frame=joints.get(COLUMNS, also.frame),
    )
    frame, mounts = _rigid_frame(options, press)
    try:
        return Elastic(stiffness, also.damping_ratio, {}, also.crown_mass, clearances, mounted_frame=frame, mounts=mounts)
    except PinpressError as error:
        raise PinpressError(f"{error}" if options.elastic is None else f"--elastic {options.elastic}: {error}") from None


def _of_all(option: str, given: dict[str, float], names: Sequence[str], example: str) -> dict[str, float]:
    """Numbers for all names; names without a number take the number of `ALL`."""
    found = with_others(given, names)
    for name in found:
        if name not in names:
            raise UnknownNameError("bearing", name, (*names, ALL))
    missing = [repr(name) for name in names if name not in found]
    if missing:
        lacks = f"{option} lacks {', '.join(missing)}: in an elastic motion all of them are elastic"
        raise PinpressError(f"{lacks}; give e.g. {option} {ALL}={example} for the rest")
    return {name: found[name] for name in names}


def mounted_press(
    options: argparse.Namespace, press: Linkage, pad: str | None = None, *, motion: Motion | None = None
) -> MountedPress | None:
    """Read the press on its mounts from `add_mount_options`; None without mounts.

    Args:
        options: options of `add_mount_options`.
        press: the press that stands on them.
        pad: rubber pad of each mount; None without pads.
        motion: as for `mounted`.

    Raises:
        PinpressError: frame or mounts are missing, or are given in addition to a file; as for `part_specs`, `read_mounted` and `mounted`.
    """
    from ...foundation.frame_file import read_mounted  # seldom needed
    from ...foundation.mounted_press import mounted

    if _is_frame_file(options.frame):
        if options.mount or pad is not None:
            raise PinpressError(
                f"--{'mount' if options.mount else 'pad'}: {options.frame} already contains the mounts: leave this option out"
            )
        return read_mounted(press, options.frame, motion=motion)
    given = _frame_and_mounts(options, pad)
    return None if given is None else mounted(press, *given, motion=motion)


def _rigid_frame(options: argparse.Namespace, press: Linkage) -> tuple[Frame | None, Sequence[Mount]]:
    """The frame and its mounts for a press on springs; raises as `mounted_press`, and if the frame is not one rigid body."""
    system = mounted_press(options, press) if _is_frame_file(options.frame) else None
    if system is None:
        return _frame_and_mounts(options, None) or (None, [])
    more = [name for name in ("crown", "attached", "rotors") if getattr(system, name)]
    if more or not isinstance(system.frame, Frame):
        what = more[0] if more else "the beams or matrices"
        raise PinpressError(f"--frame: a press on springs stands on one rigid frame: leave out {what} of {options.frame}")
    return system.frame, system.mounts


def _is_frame_file(words: str | None) -> bool:
    return words is not None and words.lower().endswith(FRAME_FILES)


def _frame_and_mounts(options: argparse.Namespace, pad: str | None) -> tuple[Frame, list[Mount]] | None:
    """Read the frame and its mounts from texts; None without both."""
    if (options.frame is None) != (not options.mount):
        raise PinpressError("a press on its mounts needs --frame and --mount: give --frame and every --mount, or a frame file")
    if options.frame is None:
        return None
    return part_specs.part("--frame", part_specs.FRAME, options.frame), part_specs.mounts(options.mount, pad)
