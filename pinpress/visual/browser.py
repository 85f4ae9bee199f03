"""Recordings in headless Chromium, without a network: nothing else here knows Playwright.

A page is laid out in a window whose longer side is always `LONGER_SIDE` CSS pixels, however many pixels a picture of it has: a larger
picture is a sharper one, not one with smaller writing.
"""

import base64
import importlib.util
import math
import os
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..common.errors import PinpressError

if TYPE_CHECKING:
    from playwright.sync_api import Browser, CDPSession, Page

NOT_INSTALLED = "pictures and films need Playwright, which is not installed; pip install 'pinpress[video]'"
NO_CHROMIUM = (
    "pictures and films need Chromium or Chrome, and none is on the PATH; install it (Debian, Ubuntu: apt-get install chromium; else"
    " https://www.chromium.org/getting-involved/download-chromium), or set the environment variable CHROMIUM to its program"
)
PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
DRAWN = ("--use-gl=angle", "--use-angle=swiftshader-webgl", "--enable-unsafe-swiftshader")  # by the processor: the same everywhere
# tiles that are drawn again in part come out a little otherwise, from run to run
FLAGS = (*DRAWN, "--disable-partial-raster", "--disable-dev-shm-usage", "--hide-scrollbars")
LONGER_SIDE = 960.0
PATIENCE = 120_000  # ms
PLAYER = "[typeof duration, typeof seek, typeof setPlaying, typeof viewer].join() === 'number,function,function,object'"
STILL = """() => {
    setPlaying(false);
    document.body.classList.add("still");
    dispatchEvent(new Event("resize"));
    return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
}"""
SHOW = "time => { seek(time); viewer.render(); }"
LOST = "Boolean(viewer.renderer) && viewer.renderer.getContext().isContextLost()"


@dataclass(frozen=True)
class Screen:
    """A recording, opened.

    Attributes:
        duration: of the recording [s].
        picture: makes a PNG of what it shows at a time [s].
    """

    duration: float
    picture: Callable[[float], bytes]


@contextmanager
def opened(page: str | os.PathLike[str], size: tuple[int, int]) -> Iterator[Screen]:
    """Open a recording in a browser, without its controls.

    Args:
        page: the HTML file that `record` or `report` wrote.
        size: width and height of the pictures, in pixels.

    Raises:
        PinpressError: no such file, or not one of these; Playwright or Chromium missing; anything that goes wrong in the page, now or
            when a picture is taken.
    """
    content, program = _content(page), _program()
    if importlib.util.find_spec("playwright") is None:
        raise PinpressError(NOT_INSTALLED)
    # All in a thread of its own: Playwright's event loop cannot run inside another one, as a notebook has, and Ctrl-C must not strike it.
    with ThreadPoolExecutor(1) as thread:
        opening = ExitStack()
        try:
            tab = thread.submit(_open, opening, page, content, program, size).result()
            yield Screen(tab.duration, lambda time: thread.submit(tab.picture, time).result())
        finally:
            thread.submit(opening.close).result()


class _Tab:
    def __init__(self, name: str, page: "Page", devtools: "CDPSession", clip: dict[str, float]) -> None:
        self._name, self._page, self._devtools, self._clip = name, page, devtools, clip
        self._problems: list[str] = []
        page.set_default_timeout(PATIENCE)
        page.on("console", lambda message: self._problems.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: self._problems.append(str(error)))
        page.on("crash", lambda _: self._problems.append("it crashed"))

    def load(self, content: str) -> None:
        self._do(self._page.set_content, content)  # not by its address: Chromium as a snap sees no temporary files
        if not self._do(self._page.evaluate, PLAYER):
            raise PinpressError(f"{self._name} is no recording; give a page that pinpress.record or report wrote")
        self.duration = float(self._do(self._page.evaluate, "duration"))
        self._do(self._page.evaluate, STILL)

    def picture(self, time: float) -> bytes:
        self._do(self._page.evaluate, SHOW, time)
        # Nearly all of the time is drawing: JPEG is not faster, and reading the canvas alone, without the labels over it, is slower.
        shot = self._do(self._devtools.send, "Page.captureScreenshot", {"format": "png", "optimizeForSpeed": True, "clip": self._clip})
        if self._do(self._page.evaluate, LOST):  # of which the page says nothing
            raise PinpressError(f"{self._name} was not drawn: Chromium has lost its WebGL context; try again, or a smaller size")
        return base64.b64decode(shot["data"])

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

    root = hasattr(os, "geteuid") and os.geteuid() == 0  # for whom Chromium has no sandbox
    try:
        playwright = opening.enter_context(sync_playwright())
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS), chromium_sandbox=not root, handle_sigint=False)
    except Error as error:
        raise PinpressError(f"{program} does not start: {_line(error.message)}; set CHROMIUM to a Chromium or Chrome that does") from error
    opening.callback(_close, browser)
    context = browser.new_context(no_viewport=True, reduced_motion="reduce", offline=True)
    tab = context.new_page()
    devtools = context.new_cdp_session(tab)
    scale = max(size) / LONGER_SIDE
    width, height = (side / scale for side in size)
    window = {"width": math.ceil(width - 1e-9), "height": math.ceil(height - 1e-9), "deviceScaleFactor": scale, "mobile": False}
    devtools.send("Emulation.setDeviceMetricsOverride", window)
    screen = _Tab(os.fspath(page), tab, devtools, {"x": 0, "y": 0, "width": width, "height": height, "scale": 1})
    screen.load(content)
    return screen


def _close(browser: "Browser") -> None:
    from playwright.sync_api import Error  # optional, and slow to import

    with suppress(Error):  # it is gone already
        browser.close()


def _content(page: str | os.PathLike[str]) -> str:
    try:
        return Path(page).read_text("utf-8")
    except (OSError, ValueError) as error:  # ValueError: a null character in the path, or not UTF-8
        reason = getattr(error, "strerror", None) or str(error)
        raise PinpressError(f"cannot read {os.fspath(page)}: {reason}; give a page that pinpress.record or report wrote") from error


def _program() -> str:
    named = os.environ.get("CHROMIUM")
    if named:
        found = shutil.which(named)
        if found is None:
            raise PinpressError(f"the environment variable CHROMIUM is {named}, which is no program; set it to Chromium's or Chrome's")
        return found
    found = next(filter(None, map(shutil.which, PROGRAMS)), None)
    if found is None:
        raise PinpressError(NO_CHROMIUM)
    return found


def _line(message: str) -> str:
    """The first line that says something of an error in Chromium or Playwright."""
    return next((line.strip() for line in message.splitlines() if line.strip()), "no reason given")
