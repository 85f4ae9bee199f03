"""Pictures and films of a recording, for reports and slides."""

from __future__ import annotations

import itertools
import os
import subprocess
import tempfile
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path

from ..common import files
from ..common.arguments import is_whole_number, number, typed, whole_number
from ..common.errors import PinpressError, shown
from ..common.files import path_of
from .browser import opened

NO_FFMPEG = "films need imageio-ffmpeg, which is not installed; pip install 'pinpress[video]'"
SHORTEST_FILM = 4.0  # s, below which a recording is slowed down
MOST_FRAMES = 36_000
SMALLEST, LARGEST = 64, 4096  # pixels a side
PNG = ".png"
# The colours that players expect of a film; said in the file too, as some go by what it says.
BT709 = "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=bt709"
ENCODING = {  # by the file's suffix, for ffmpeg
    ".mp4": ("-vf", BT709, "-c:v", "libx264", "-crf", "18", "-movflags", "+faststart"),
    ".gif": ("-vf", "split[frames][same];[same]palettegen[palette];[frames][palette]paletteuse=dither=none:diff_mode=rectangle"),
}


def image(
    page: str | os.PathLike[str],
    path: str | os.PathLike[str],
    *,
    time: float = 0.0,
    size: tuple[int, int] = (1280, 960),
) -> Path:
    """Write a PNG of what a recording shows at a time, without its controls, and return its path.

    Args:
        page: HTML file written by `record` or `report`.
        path: Path of the picture, ending in `.png`.
        time: Time of the recording, from 0 to its duration [s].
        size: Width and height in pixels. A larger picture is sharper; it does not show more.

    Raises:
        PinpressError: The page is no recording or fails in Chromium, the time or size is out of range, the file cannot be written, or
            Playwright or Chromium is missing.
    """
    size, time = _size(size), number("time", time)
    with files.written(path, _suffix(path, (PNG,))) as part, opened(page, size) as screen:
        if not 0 <= time <= screen.duration:
            raise PinpressError(f"time is {time:g} s, but the recording lasts from 0 to {screen.duration:.7g} s; give one within it")
        picture = screen.picture(time)
        with files.refused(path):
            part.write_bytes(picture)
    return Path(path)


@typed
def film(
    page: str | os.PathLike[str],
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] = (1280, 720),
    frames_per_second: int = 30,
    slowdown: float | None = None,
    repeats: int = 1,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write a film of a recording, without its controls, and return its path.

    Frame k shows the recording at k / (frames_per_second slowdown) [s]. One period makes a loop: its last frame is followed by its first.

    Args:
        page: HTML file written by `record` or `report`.
        path: Path of the film, ending in `.mp4` (H.264) or `.gif` (whose times are rounded to 0.01 s).
        size: Width and height in pixels, even numbers. A larger picture is sharper; it does not show more.
        frames_per_second: Whole number from 1 to 120.
        slowdown: Factor by which the film is slower than the press; 1 is real time. By default the least of 1, 2, 5, 10, 20, 50, ... with
            which the recording takes at least 4 s.
        repeats: Number of times that the recording is played.
        progress: Function called after every frame with the share of frames done, up to 1.

    Raises:
        PinpressError: The page is no recording or fails in Chromium, a number is out of range, the file cannot be written, or
            imageio-ffmpeg, Playwright or Chromium is missing.
    """
    size, rate = _size(size, step=2), whole_number("frames_per_second", frames_per_second, 1, 120)
    times = whole_number("repeats", repeats, 1, MOST_FRAMES)
    if slowdown is not None and number("slowdown", slowdown) <= 0:
        raise PinpressError(f"slowdown is {slowdown:g}; give a positive number, e.g. 10 for a film ten times slower than the press")
    program = _ffmpeg()
    with files.written(path, _suffix(path, ENCODING)) as part, opened(page, size) as screen:
        slower = slow_enough(screen.duration) if slowdown is None else float(slowdown)
        count = _frames(screen.duration * times, slower, rate)
        with _encoder(program, part, rate) as encode:
            for k in range(count):
                encode(screen.picture(k / (rate * slower) % screen.duration))
                if progress is not None:
                    progress((k + 1) / count)
    return Path(path)


def slow_enough(duration: float) -> float:
    """Factor by which a recording of a duration [s] is slowed down so that the eye can follow; the default of `film`."""
    steps = (step * 10.0**power for power in itertools.count() for step in (1, 2, 5))
    return next(slowdown for slowdown in steps if slowdown * duration >= SHORTEST_FILM) if duration > 0 else 1.0


def _frames(duration: float, slowdown: float, rate: int) -> int:
    """Number of frames: the one after the last would show the end of the recording, to half a frame."""
    if not duration > 0:
        raise PinpressError("the recording is of one instant; there is nothing to film: take an image")
    frames = duration * slowdown * rate
    if not 0.5 < frames <= MOST_FRAMES:
        raise PinpressError(
            f"the film would have {frames:.3g} frames; choose slowdown, repeats and frames_per_second for 1 to {MOST_FRAMES}"
        )
    return round(frames)


@contextmanager
def _encoder(program: str, target: Path, rate: int) -> Iterator[Callable[[bytes], None]]:
    """A function that takes the film's frames, PNG; the film is complete at the end of the block."""
    source = ("-f", "image2pipe", "-framerate", str(rate), "-c:v", "png", "-i", "-")
    command = [program, "-y", "-hide_banner", "-loglevel", "error", *source, *ENCODING[target.suffix], "-an", "-bitexact", str(target)]
    with tempfile.TemporaryFile() as said:
        # In a session of its own, so that Ctrl-C does not reach it before it reaches us.
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=said, start_new_session=True)
        assert process.stdin is not None
        pipe = process.stdin

        def refusal() -> PinpressError:
            process.wait()
            said.seek(0)
            reason = " ".join(said.read().decode(errors="replace").split()) or f"exit code {process.returncode}"
            return PinpressError(f"ffmpeg cannot make the film: {reason}; see that the disk is not full, and IMAGEIO_FFMPEG_EXE not set")

        def send(frame: bytes) -> None:
            try:
                pipe.write(frame)
            except OSError:
                raise refusal() from None

        try:
            yield send
            process.communicate()
            if process.returncode:
                raise refusal()
        finally:
            process.kill()
            with suppress(OSError):  # what it has not taken
                pipe.close()
            process.wait()


def _ffmpeg() -> str:
    try:
        return str(import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except ImportError:
        raise PinpressError(NO_FFMPEG) from None
    except RuntimeError as error:
        raise PinpressError(f"imageio-ffmpeg has no ffmpeg: {error}; pip install --force-reinstall imageio-ffmpeg") from error


def _suffix(path: str | os.PathLike[str], possible: Collection[str]) -> str:
    suffix = Path(path_of("path", path)).suffix.lower()
    if suffix not in possible:
        raise PinpressError(f"cannot write {os.fspath(path)}: the name of the file must end in {' or '.join(possible)}")
    return suffix


def _size(size: object, step: int = 1) -> tuple[int, int]:
    sides = list(size) if isinstance(size, tuple | list) else []
    if len(sides) != 2 or not all(is_whole_number(side) and SMALLEST <= side <= LARGEST and side % step == 0 for side in sides):
        kind = "even" if step == 2 else "whole"
        raise PinpressError(f"size is {shown(size)}: give width and height in pixels, two {kind} numbers from {SMALLEST} to {LARGEST}")
    return int(sides[0]), int(sides[1])
