"""`pinpress record`: one period or motion of a press as a page, a film or a picture."""

import argparse
import math
import tempfile
from pathlib import Path

import numpy as np

from ..common.errors import PinpressError
from ..common.reading.entries import entry_of_text
from ..common.reading.filling import Around, Number
from ..jobs.grammar import JOB, OfDriver
from ..jobs.job import Job, traces_of
from ..kinematics.motion import Motion
from .options import SHORT, SIGNS, add_job_options, open_job, progress

EPILOG = f"""\
{SIGNS}Films and pictures need Chromium and pip install 'pinpress[video]'. Paths of points: traces: {{rod: 0 0 400 mm}}.
{SHORT}pinpress record press.yaml --out press.html --video press.mp4 --png press.png --at 150deg
"""


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `record` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "record",
        help="a page, film or picture of a press turning, with its forces",
        description="Turn a press through one period at constant speed, or move it by its table, and write it as a page to open by\n"
        "double click (--out), a film (--video) or a picture (--png). Process, bearing and shaking forces are drawn as arrows.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_job_options(parser)
    option("--out", type=Path, metavar="HTML", help="write this page")
    option("--video", type=Path, metavar="MP4", help="write this film, .mp4 or .gif")
    option("--png", type=Path, metavar="PNG", help="write this picture")
    help = "crank angle of the picture, such as 150deg, or position of a sliding driver; of a given motion its time (default: 0)"
    option("--at", default="0", metavar="PLACE", help=help)
    option("--size", type=_size, metavar="WxH", help="size of film and picture, in pixels (default: 1280x720 and 1280x960)")
    option("--fps", type=int, default=30, metavar="N", help="frames per second of the film (default: %(default)s)")
    help = "factor by which the film is slower than the press; 1: real time (default: a period takes at least 4 s)"
    option("--slowdown", type=float, metavar="X", help=help)
    option("--repeats", type=int, default=1, metavar="N", help="periods in the film (default: %(default)s)")
    option("--no-forces", dest="forces", action="store_false", help="leave the forces out")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the requested files, and print their names.

    Raises:
        PinpressError: no file is asked for, or computing or writing fails.
    """
    if options.out is options.video is options.png is None:
        raise PinpressError("nothing to write: give --out page.html, --video film.mp4 or --png picture.png")
    paths = [path.absolute() for path in (options.out, options.video, options.png) if path is not None]
    if len(set(paths)) < len(paths):
        raise PinpressError("--out, --video and --png name the same file: give different names")
    from ..visual.film import film, image  # slow to import
    from ..visual.recording import key_frames, record

    job = open_job(options)
    motion = job.motion()
    instant = _instant(job, motion, options.at, float(key_frames(job.press, motion).time[-1]))
    reactions = job.reactions() if options.forces else None
    with tempfile.TemporaryDirectory() as folder:
        page = options.out or Path(folder, "recording.html")
        record(job.press, motion, page, reactions=reactions, traces=traces_of(job))
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


def _instant(job: Job, motion: Motion, text: str, duration: float) -> float:
    """The time [s] of --at within the recording: at a crank angle or position, or of a given motion the time itself."""
    entry = entry_of_text(text, "--at", (), JOB)
    if "motion" in job.sections:
        time = Number("s").read(entry, Around())
        if not 0 <= time <= duration:
            raise PinpressError(f"--at {text}: give a time from the motion's first state, from 0 to {duration:g} s")
        return time
    coordinates = dict(zip(job.press.drivers, job.press.driver_coordinates, strict=True))
    at = OfDriver(Number("rad")).read(entry, Around(drivers=coordinates))
    if not math.isfinite(at):
        raise PinpressError(f"--at is {text}: give a crank angle, such as 150deg")
    if motion.period_turns is None:
        return float(motion.time[np.abs(motion.crank_angle - at).argmin()])
    return float(at / motion.crank_speed[0] % (2 * math.pi * motion.period_turns / abs(motion.crank_speed[0])))


def _size(words: str) -> tuple[int, int]:
    width, by, height = words.partition("x")
    if not (by and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"{words!r} is not a size: give width and height in pixels, e.g. 1280x720")
    return int(width), int(height)
