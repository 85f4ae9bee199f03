"""A real browser for the tests that open pages in one; and nothing is skipped in continuous integration."""

import gc
import importlib.util
import os
import random
import shutil
import signal
import sys
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any

# Bytecode is kept, whatever the machine's habit: every test that starts Python, and every worker, would compile all of pinpress again,
# and pytest rewrites all of Hypothesis too.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402
from support.exploring import EXPLORE, FIXED  # noqa: E402
from support.sampling import sample  # noqa: E402
from support.skips import pytest_make_collect_report, pytest_runtest_makereport  # noqa: E402
from support.time_limit import time_limit  # noqa: E402

# hooks and a fixture for all tests
__all__ = ["pytest_make_collect_report", "pytest_runtest_makereport", "time_limit"]

settings.load_profile(FIXED)

# What `nohup` or a script's `&` ignores, all processes that the tests start would ignore too, and those of Ctrl-C would never end.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Workers are as many as cores. Where each had as many threads too, these would wait for each other.
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
assert "numpy" not in sys.modules or ONE_THREAD.items() <= os.environ.items(), "NumPy reads them once"
os.environ.update(ONE_THREAD)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Modules that need a browser come first, then those with one of each result: one worker gets all of them.

    Else each would start a browser, load the pages and compute the results.
    """
    sample(items)
    in_browser = {item.path for item in items if "browser" in getattr(item, "fixturenames", ())}
    items.sort(key=lambda item: (item.path not in in_browser, not hasattr(getattr(item, "module", None), "every_result")))


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Thousands of collected tests stay to the end: the garbage collector need not look through them again and again."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.collect()
        gc.freeze()
        gc.enable()


def pytest_collection_finish() -> None:
    """Options that came by the environment are read by now, and are not those of runs that tests start."""
    os.environ.pop("PYTEST_ADDOPTS", None)


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Exploring, all tests draw from one seed, which is chosen here if it is not given."""
    if config.option.hypothesis_profile == EXPLORE and config.option.hypothesis_seed is None:
        config.option.hypothesis_seed = str(random.SystemRandom().randrange(2**32))


def pytest_report_header(config: pytest.Config) -> list[str]:
    if config.option.hypothesis_profile != EXPLORE:
        return []
    return [f"new random cases; these again: --hypothesis-profile={EXPLORE} --hypothesis-seed={config.option.hypothesis_seed}"]


@pytest.fixture(params=["plane", "space", "pinocchio"])
def engine(request: Any) -> str:
    """Every engine that takes a planar linkage."""
    return str(request.param)


@pytest.fixture(params=["reduced", "constraint"])
def method(request: Any) -> str:
    """The two methods of a run that share no equation of motion."""
    return str(request.param)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    executable = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    if executable is None or importlib.util.find_spec("playwright") is None:
        pytest.skip("needs Chromium and playwright")
    from playwright.sync_api import sync_playwright
    from support.in_browser import FLAGS  # with NumPy, after its threads are counted

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=executable, args=FLAGS)
        yield chromium
        chromium.close()


class Tab:
    """A tab without a network, and what went wrong in it or asked for the network."""

    def __init__(self, browser: Any) -> None:
        self.problems: list[str] = []
        self.context = browser.new_context(viewport={"width": 800, "height": 600})
        self.context.set_offline(True)
        self.context.route("**/*", self._only_files)
        self.page = self.context.new_page()
        self.page.on("console", self._said)
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("dialog", self._asked)

    def _said(self, message: Any) -> None:
        drawing = "GL Driver Message (OpenGL, Performance" in message.text  # a screenshot makes the software renderer wait, it says
        if message.type in ("error", "warning") and not drawing:
            self.problems.append(message.text)

    def _asked(self, dialog: Any) -> None:
        self.problems.append(f"dialog: {dialog.message}")
        dialog.dismiss()

    def _only_files(self, route: Any) -> None:
        if route.request.url.startswith("file:"):
            route.continue_()
        else:
            self.problems.append(f"request: {route.request.url}")
            route.abort()

    def open(self, path: Path, fragment: str = "", size: tuple[int, int] = (800, 600)) -> Any:
        """A page, loaded anew."""
        from support.in_browser import wait  # with NumPy, after its threads are counted

        self.page.set_viewport_size({"width": size[0], "height": size[1]})
        self.page.goto("about:blank")  # else a page of the same address would stay as it is
        self.page.goto(path.as_uri() + fragment)
        self.page.evaluate("unpacked")
        wait(self.page, "viewer.needs_render === false || playing")
        return self.page

    def kept(self, path: Path, size: tuple[int, int] = (800, 600)) -> Any:
        """A page at its beginning, as the test before left it, for tests that leave what they find: loading takes longer than most."""
        if self.page.url.partition("#")[0] != path.as_uri():
            self.open(path, "#t=0", size)
        self.page.evaluate("setPlaying(false); seek(0); window.scrollTo(0, 0)")
        return self.page

    def see_to_problems(self) -> None:
        """Nothing may have gone wrong, nor may the network have been asked for anything; what has is this test's alone."""
        problems, self.problems[:] = self.problems[:], []
        assert problems == []


@pytest.fixture(scope="session")
def tab(browser: Any) -> Iterator[Tab]:
    """One for all tests: the second page in a tab opens in half the time of the first."""
    tab = Tab(browser)
    yield tab
    tab.context.close()


@pytest.fixture
def view(tab: Tab) -> Iterator[Callable[..., Any]]:
    """Opens a page of ours; at the end of the test nothing may have gone wrong in it or asked for the network."""
    yield tab.open
    tab.page.goto("about:blank")  # that no page goes on into the next test
    tab.see_to_problems()


@pytest.fixture
def shared_view(tab: Tab) -> Iterator[Callable[..., Any]]:
    """As `view`, but a page that is open already is not loaded anew."""
    yield tab.kept
    tab.see_to_problems()
