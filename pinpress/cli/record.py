"""`pinpress record`: show one period of a press as a page, a film or a picture."""

import argparse
import contextlib
import math
import tempfile
from pathlib import Path

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import CRANK, RAM
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..kinematics.motion import Motion
from .words import part_specs
from .words.forces import add_force_options, forces
from .words.motions import add_motion_options, motion_of
from .words.outputs import SIGNS, add_trace_option
from .words.press import add_press_options, add_refused_option, load_press
from .words.progress import progress
from .words.units import OfDriver, driver_position, read_quantity

EPILOG = f"""\
{part_specs.explained("load", "spring", "friction")}
{SIGNS}Films and pictures need Chromium and pip install 'pinpress[video]'.
e.g. pinpress record zxn2_3000b --speed 70 --out press.html --video press.mp4 --png press.png --at 150
     --load blanking:force=1000kN,start=6mm,end=2mm
"""


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `record` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "record",
        help="a page, film or picture of a press turning, with its forces",
        description="Turn a press through one period at constant speed, or with --motion by a table, and write it as a page to open\n"
        "by double click (--out), a film (--video) or a picture (--png). Process, bearing and shaking forces are drawn as arrows.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_motion_options(parser)
    option("--out", type=Path, metavar="HTML", help="write this page")
    option("--video", type=Path, metavar="MP4", help="write this film, .mp4 or .gif")
    option("--png", type=Path, metavar="PNG", help="write this picture")
    option(
        "--at",
        type=_place,
        default="0",
        metavar="DEG",
        help="crank angle of the picture, or position of a sliding driver in mm; with --motion time from the start in s (default: 0)",
    )
    option("--size", type=_size, metavar="WxH", help="size of film and picture, in pixels (default: 1280x720 and 1280x960)")
    option("--fps", type=int, default=30, metavar="N", help="frames per second of the film (default: %(default)s)")
    option(
        "--slowdown",
        type=float,
        metavar="X",
        help="factor by which the film is slower than the press; 1: real time (default: a period takes at least 4 s)",
    )
    option("--repeats", type=int, default=1, metavar="N", help="periods in the film (default: %(default)s)")
    add_force_options(parser)
    for name in ("--motor", "--flywheel"):
        add_refused_option(parser, name, "record needs a given motion: pinpress simulate ... --out DIR records a run under a motor")
    add_trace_option(parser)
    option("--no-forces", dest="forces", action="store_false", help="leave the forces out")
    option("--points", type=int, metavar="N", help="number of crank angles of the period (default: 360 a turn)")
    add_press_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the requested files, and print their names.

    Raises:
        PinpressError: No file is asked for, or computing or writing fails.
    """
    if options.out is options.video is options.png is None:
        raise PinpressError("nothing to write: give --out page.html, --video film.mp4 or --png picture.png")
    paths = [path.absolute() for path in (options.out, options.video, options.png) if path is not None]
    if len(set(paths)) < len(paths):
        raise PinpressError("--out, --video and --png name the same file: give different names")
    from ..visual.film import film, image  # slow to import
    from ..visual.recording import key_frames, record

    if not options.forces and (options.load or options.spring or options.friction or options.stiffness):
        raise PinpressError("--no-forces hides the forces of loads, springs and friction: leave it out, or leave these out")
    press = load_press(options)
    acting = forces(options, press)
    coordinate = press.driver_coordinates[0]
    if options.motion is None and not math.isfinite(options.at.of(coordinate)):
        raise PinpressError(f"--at is {options.at.text}: give a crank angle in degrees")
    motion = motion_of(press, options, options.speed)
    instant = (
        _time(motion, options.at.of(coordinate))
        if options.motion is None
        else _instant(options.at.text, float(key_frames(press, motion).time[-1]))
    )
    reactions = inverse_dynamics(press, motion, **acting) if options.forces else None
    with tempfile.TemporaryDirectory() as folder:
        page = options.out or Path(folder, "recording.html")
        record(press, motion, page, reactions=reactions, traces=options.trace)
        size = {} if options.size is None else {"size": options.size}
        if options.png is not None:
            image(page, options.png, time=instant, **size)
        if options.video is not None:
            shown = {"frames_per_second": options.fps, "slowdown": options.slowdown, "repeats": options.repeats}
            with progress(1.0) as tell:
                film(page, options.video, **shown, **size, progress=tell)
    written = [str(path) for path in (options.out, options.png, options.video) if path is not None]
    print(f"wrote {', '.join(written)}")
    return 0


def _time(motion: Motion, at: float) -> float:
    """Time [s] within a period at which the driver of a cycle is at a crank angle [rad], or nearest to a position [m]."""
    if motion.period_turns is None:
        return float(motion.time[np.abs(motion.crank_angle - at).argmin()])
    return float(at / motion.crank_speed[0] % (2 * math.pi * motion.period_turns / abs(motion.crank_speed[0])))


def _instant(text: str, duration: float) -> float:
    """Time [s] from the first state of a motion that is not at constant speed, in words; ``duration``: of its recording [s]."""
    try:
        instant = read_quantity(text, "s")
    except ValueError:
        instant = math.nan
    if not 0 <= instant <= duration:
        raise PinpressError(f"--at {text}: with --motion give a time from its first state, from 0 to {duration:g} s")
    return instant


def _place(text: str) -> OfDriver:
    """Reads an option of `argparse`: the position of a driver, or a time."""
    try:
        return driver_position(text)
    except argparse.ArgumentTypeError:
        with contextlib.suppress(ValueError):
            read_quantity(text, "s")
            return OfDriver(text, CRANK.shown_unit, RAM.shown_unit)
        raise


def _size(words: str) -> tuple[int, int]:
    width, by, height = words.partition("x")
    if not (by and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"{words!r} is not a size: give width and height in pixels, e.g. 1280x720")
    return int(width), int(height)
