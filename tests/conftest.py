"""A real browser for the tests that open pages in one."""

import importlib.util
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from in_browser import FLAGS, wait


def unavailable(reason: str) -> None:
    """A missing browser skips these tests on a developer's machine and fails them in CI."""
    (pytest.fail if os.environ.get("CI") else pytest.skip)(reason)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    executable = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    if executable is None or importlib.util.find_spec("playwright") is None:
        unavailable("needs Chromium and playwright")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=executable, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def view(browser: Any) -> Iterator[Callable[..., Any]]:
    """Opens a page of ours; at the end of the test nothing may have gone wrong in it or asked for the network."""
    context = browser.new_context(viewport={"width": 800, "height": 600})
    context.set_offline(True)
    problems: list[str] = []

    def only_files(route: Any) -> None:
        if route.request.url.startswith("file:"):
            route.continue_()
        else:
            problems.append(f"request: {route.request.url}")
            route.abort()

    context.route("**/*", only_files)
    page = context.new_page()
    page.on("console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("dialog", lambda dialog: (problems.append(f"dialog: {dialog.message}"), dialog.dismiss()))

    def open_page(path: Path, fragment: str = "", size: tuple[int, int] = (800, 600)) -> Any:
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.goto(path.as_uri() + fragment)
        wait(page, "viewer.needs_render === false || playing")
        return page

    yield open_page
    context.close()
    assert problems == []
