"""Pictures, films and paper of a page, made in headless Chromium without a network.

A page is laid out in a window whose longer side is always 960 CSS pixels, for pictures of any size. So a larger picture is sharper, and its
text does not become smaller.
"""

from __future__ import annotations

import base64
import importlib.util
import itertools
import math
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..common import files
from ..common.arguments import is_whole_number, number, typed, whole_number
from ..common.errors import PinpressError, shown
from ..common.files import path_of

if TYPE_CHECKING:
    from playwright.sync_api import Browser, CDPSession, Page

MOST_FRAMES = 36_000
# the colour space that players expect; it is also written into the file, because some players read it there
BT709 = "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=bt709"
ENCODING = {  # options of ffmpeg by the file's suffix
    ".mp4": ("-vf", BT709, "-c:v", "libx264", "-crf", "18", "-movflags", "+faststart"),
    ".gif": ("-vf", "split[frames][same];[same]palettegen[palette];[frames][palette]paletteuse=dither=none:diff_mode=rectangle"),
}

# software rendering gives the same picture on every machine; partly redrawn tiles would differ slightly from run to run
DRAWN = ("--use-gl=angle", "--use-angle=swiftshader-webgl", "--enable-unsafe-swiftshader")
FLAGS = (*DRAWN, "--disable-partial-raster", "--disable-dev-shm-usage", "--hide-scrollbars")
PLAYER = "[typeof duration, typeof seek, typeof setPlaying, typeof viewer].join() === 'number,function,function,object'"
STILL = """() => {
    setPlaying(false);
    document.body.classList.add("still");
    dispatchEvent(new Event("resize"));
    return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
}"""
# the page is not used after printing, so it need not be drawn for the screen again
PAPER = "time => { setPlaying(false); document.body.classList.remove('still'); removeEventListener('afterprint', toScreen); seek(time); }"
LOST = "Boolean(viewer.renderer) && viewer.renderer.getContext().isContextLost()"


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
        path: path of the picture, ending in `.png`.
        time: time of the recording, from 0 to its duration [s].
        size: width and height in pixels. A larger picture is sharper; it does not show more.

    Raises:
        PinpressError: the page is not a recording or fails in Chromium, the time or size is out of range, the file cannot be written, or
            Playwright or Chromium is missing.
    """
    size, time = _size(size), number("time", time, "s")
    with files.written(path, _suffix(path, [".png"])) as part, opened(page, size) as screen:
        picture = screen.picture(_within(time, screen.duration))
        with files.refused(path):
            part.write_bytes(picture)
    return Path(path)


def pdf(page: str | os.PathLike[str], path: str | os.PathLike[str], *, time: float = 0.0) -> Path:
    """Print a recording or report to a PDF file on A4, and return its path.

    An image of the press comes first. No chart is split over pages, and the charts of all bearings are printed. Printing the page in a
    browser gives the same result. The same page gives the same bytes.

    Args:
        page: HTML file written by `record` or `report`.
        path: path of the file, ending in `.pdf`.
        time: time of the recording at which the press is shown, from 0 to its duration [s].

    Raises:
        PinpressError: the page is not a recording or fails in Chromium, the time is out of range, the file cannot be written, or Playwright
            or Chromium is missing.
    """
    time = number("time", time, "s")
    with files.written(path, _suffix(path, [".pdf"])) as part, opened(page, (1280, 960)) as screen:  # paper has another layout
        content = screen.printed(_within(time, screen.duration))
        with files.refused(path):
            part.write_bytes(content)
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
        path: path of the film, ending in `.mp4` (H.264) or `.gif` (whose times are rounded to 0.01 s).
        size: width and height in pixels, even numbers. A larger picture is sharper; it does not show more.
        frames_per_second: whole number from 1 to 120.
        slowdown: factor by which the film is slower than the press; 1 is real time. By default the smallest of 1, 2, 5, 10, 20, 50, ... for
            which the recording takes at least 4 s.
        repeats: number of times that the recording is played.
        progress: function that is called after every frame with the share of finished frames, up to 1.

    Raises:
        PinpressError: the page is not a recording or fails in Chromium, a number is out of range, the file cannot be written, or
            imageio-ffmpeg, Playwright or Chromium is missing.
    """
    size, rate = _size(size, step=2), whole_number("frames_per_second", frames_per_second, 1, 120)
    times = whole_number("repeats", repeats, 1, MOST_FRAMES)
    if slowdown is not None and number("slowdown", slowdown) <= 0:
        raise PinpressError(f"slowdown is {slowdown:g}; give a positive number, e.g. 10 for a film ten times slower than the press")
    program = _ffmpeg()
    with files.written(path, _suffix(path, ENCODING)) as part, opened(page, size) as screen:
        if not screen.duration > 0:
            raise PinpressError("the recording is of one instant; there is nothing to film: make an image instead")
        slower = slow_enough(screen.duration) if slowdown is None else float(slowdown)
        frames = screen.duration * times * slower * rate  # rounded: the end of the recording may be off by half a frame
        if not 0.5 < frames <= MOST_FRAMES:
            raise PinpressError(
                f"the film would have {frames:.3g} frames; choose slowdown, repeats and frames_per_second for 1 to {MOST_FRAMES}"
            )
        count = round(frames)
        with _encoder(program, part, rate) as encode:
            for k in range(count):
                encode(screen.picture(k / (rate * slower) % screen.duration))
                if progress is not None:
                    progress((k + 1) / count)
    return Path(path)


def _within(time: float, duration: float) -> float:
    if not 0 <= time <= duration:
        raise PinpressError(f"time is {time:g} s, but the recording lasts from 0 to {duration:.7g} s; give one within it")
    return time


def slow_enough(duration: float) -> float:
    """Factor by which a recording of a duration [s] is slowed down so that the eye can follow; the default of `film`."""
    steps = (step * 10.0**power for power in itertools.count() for step in (1, 2, 5))
    return next(slowdown for slowdown in steps if slowdown * duration >= 4.0) if duration > 0 else 1.0


@contextmanager
def _encoder(program: str, target: Path, rate: int) -> Iterator[Callable[[bytes], None]]:
    """A function that takes the film's frames as PNG; the film is complete at the end of the block."""
    source = ("-f", "image2pipe", "-framerate", str(rate), "-c:v", "png", "-i", "-")
    command = [program, "-y", "-hide_banner", "-loglevel", "error", *source, *ENCODING[target.suffix], "-an", "-bitexact", str(target)]
    with tempfile.TemporaryFile() as said:
        # In a separate session, so that Ctrl-C does not reach it first.
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
            with suppress(OSError):  # ffmpeg may stop before it has read all frames
                pipe.close()
            process.wait()


def _ffmpeg() -> str:
    try:
        return str(import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except ImportError:
        raise PinpressError("films need imageio-ffmpeg, which is not installed; pip install 'pinpress[video]'") from None
    except RuntimeError as error:
        raise PinpressError(f"imageio-ffmpeg has no ffmpeg: {error}; pip install --force-reinstall imageio-ffmpeg") from error


def _suffix(path: str | os.PathLike[str], possible: Collection[str]) -> str:
    suffix = Path(path_of("path", path)).suffix.lower()
    if suffix not in possible:
        raise PinpressError(f"cannot write {os.fspath(path)}: the name of the file must end in {' or '.join(possible)}")
    return suffix


def _size(size: object, step: int = 1) -> tuple[int, int]:
    sides = list(size) if isinstance(size, tuple | list) else []
    if len(sides) != 2 or not all(is_whole_number(side) and 64 <= side <= 4096 and side % step == 0 for side in sides):
        kind = "even" if step == 2 else "whole"
        raise PinpressError(f"size is {shown(size)}: give width and height in pixels, two {kind} numbers from 64 to 4096")
    return int(sides[0]), int(sides[1])


@dataclass(frozen=True)
class Screen:
    """A recording that is open in a browser.

    Attributes:
        duration: duration of the recording [s].
        picture: function that makes a PNG of the recording at a time [s], without its controls.
        printed: function that makes a PDF of the page at a time [s]; the page cannot be used afterwards.
    """

    duration: float
    picture: Callable[[float], bytes]
    printed: Callable[[float], bytes]


@contextmanager
def opened(page: str | os.PathLike[str], size: tuple[int, int]) -> Iterator[Screen]:
    """Open a recording in a browser.

    Args:
        page: HTML file that `record` or `report` wrote.
        size: width and height of the pictures, in pixels.

    Raises:
        PinpressError: the file does not exist or is not a recording, Playwright or Chromium is missing, or the page fails, now or when a
            picture is taken.
    """
    try:
        content = Path(page).read_text("utf-8")
    except (OSError, ValueError) as error:  # ValueError: a null character in the path, or not UTF-8
        reason = getattr(error, "strerror", None) or str(error)
        raise PinpressError(f"cannot read {os.fspath(page)}: {reason}; give a page that pinpress.record or report wrote") from error
    program = _program()
    if importlib.util.find_spec("playwright") is None:
        raise PinpressError("pictures, films and PDF files need Playwright, which is not installed; pip install 'pinpress[video]'")
    # In a separate thread: Playwright's event loop cannot run inside a notebook's event loop, and Ctrl-C must not interrupt it.
    with ThreadPoolExecutor(1) as thread:
        opening = ExitStack()
        try:
            tab = thread.submit(_open, opening, page, content, program, size).result()
            yield Screen(
                tab.duration,
                picture=lambda time: thread.submit(tab.picture, time).result(),
                printed=lambda time: thread.submit(tab.printed, time).result(),
            )
        finally:
            thread.submit(opening.close).result()


class _Tab:
    """A recording in a tab of the browser. Every error of the page becomes a PinpressError at the next action."""

    def __init__(self, name: str, page: Page, devtools: CDPSession, clip: dict[str, float]) -> None:
        self._name, self._page, self._devtools, self._clip = name, page, devtools, clip
        self._problems: list[str] = []
        self._still = False  # whether the page is shown without its controls
        page.set_default_timeout(120_000)  # timeout of each action [ms]
        page.on("console", lambda message: self._problems.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: self._problems.append(str(error)))
        page.on("crash", lambda _: self._problems.append("it crashed"))

    def load(self, content: str) -> None:
        self._do(self._page.set_content, content)  # not by its address, because Chromium as a snap cannot read temporary files
        self._do(self._page.evaluate, "typeof unpacked === 'object' ? unpacked : null")
        if not self._do(self._page.evaluate, PLAYER):
            raise PinpressError(f"{self._name} is no recording; give a page that pinpress.record or report wrote")
        if self._do(self._page.evaluate, "document.body.classList.contains('flat')"):
            raise PinpressError(f"{self._name} fails in Chromium, where WebGL is switched off or missing; allow it")
        self.duration = float(self._do(self._page.evaluate, "duration"))

    def picture(self, time: float) -> bytes:
        if not self._still:
            self._do(self._page.evaluate, STILL)
            self._still = True
        self._do(self._page.evaluate, "time => { seek(time); viewer.render(); }", time)
        # drawing takes nearly all of the time: JPEG is not faster, and reading the canvas without its labels is slower
        shot = self._do(self._devtools.send, "Page.captureScreenshot", {"format": "png", "optimizeForSpeed": True, "clip": self._clip})
        if self._do(self._page.evaluate, LOST):  # the page itself does not report a lost context
            raise PinpressError(f"{self._name} was not drawn: Chromium has lost its WebGL context; try again, or a smaller size")
        return base64.b64decode(shot["data"])

    def printed(self, time: float) -> bytes:
        self._do(self._page.evaluate, PAPER, time)
        content = self._do(partial(self._page.pdf, format="A4", print_background=True, tagged=True, outline=True))
        if self._do(self._page.evaluate, LOST):
            raise PinpressError(f"{self._name} was not drawn: Chromium has lost its WebGL context; try again")
        # Chromium's dates are replaced by blanks, because a PDF contains byte offsets
        return re.sub(rb"/(?:Creation|Mod)Date \(D:[^)]*\)", lambda date: b" " * len(date[0]), content)

    def _do(self, action: Callable[..., Any], *arguments: Any) -> Any:
        from playwright.sync_api import Error  # optional, and slow to import

        try:
            result = action(*arguments)
        except Error as error:
            self._problems.append(error.message)
        if self._problems:  # a blank picture is worse than none
            raise PinpressError(f"{self._name} fails in Chromium: {_line(self._problems[0])}; record it again, or give another page")
        return result


def _open(opening: ExitStack, page: str | os.PathLike[str], content: str, program: str, size: tuple[int, int]) -> _Tab:
    from playwright.sync_api import Error, sync_playwright  # optional, and slow to import

    root = hasattr(os, "geteuid") and os.geteuid() == 0  # Chromium has no sandbox for root
    try:
        playwright = opening.enter_context(sync_playwright())
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS), chromium_sandbox=not root, handle_sigint=False)
    except Error as error:
        raise PinpressError(f"{program} does not start: {_line(error.message)}; set CHROMIUM to a Chromium or Chrome that does") from error
    opening.callback(_close, browser)
    context = browser.new_context(no_viewport=True, reduced_motion="reduce", offline=True)
    tab = context.new_page()
    devtools = context.new_cdp_session(tab)
    scale = max(size) / 960
    width, height = ((side + 1e-3) / scale for side in size)  # Chromium cuts 480.99999 pixels to 480
    window = {"width": math.ceil(width - 0.01), "height": math.ceil(height - 0.01), "deviceScaleFactor": scale, "mobile": False}
    devtools.send("Emulation.setDeviceMetricsOverride", window)
    screen = _Tab(os.fspath(page), tab, devtools, {"x": 0, "y": 0, "width": width, "height": height, "scale": 1})
    screen.load(content)
    return screen


def _close(browser: Browser) -> None:
    from playwright.sync_api import Error  # optional, and slow to import

    with suppress(Error):  # it may already be closed
        browser.close()


def _program() -> str:
    if named := os.environ.get("CHROMIUM"):
        program = shutil.which(named)
        if program is None:
            raise PinpressError(f"the environment variable CHROMIUM is {named}, which is no program; set it to Chromium's or Chrome's")
        return program
    for name in ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"):
        if program := shutil.which(name):
            return program
    raise PinpressError(
        "pictures, films and PDF files need Chromium or Chrome, and none is on the PATH; install it (Debian, Ubuntu: apt-get install"
        " chromium; else https://www.chromium.org/getting-involved/download-chromium), or set the environment variable CHROMIUM to its"
        " program"
    )


def _line(message: str) -> str:
    """The first line with text of a message of Chromium or Playwright."""
    return next((line.strip() for line in message.splitlines() if line.strip()), "no reason given")
