"""A plugin of pytest: nothing is skipped in continuous integration."""

import os
from collections.abc import Generator

import pytest


def _fail_where_skipped(report: pytest.CollectReport | pytest.TestReport) -> None:
    """What a test needs may be missing on a developer's machine; in CI, nothing is, and a test that does not run says nothing."""
    if os.environ.get("CI") and report.skipped and not hasattr(report, "wasxfail"):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        report.outcome, report.longrepr = "failed", f"{report.nodeid} in CI: {reason}"


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    _fail_where_skipped(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    _fail_where_skipped(report)
    return report
