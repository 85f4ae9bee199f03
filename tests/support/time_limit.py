"""A limit of time for tests of what might never end: one that does not must not hold up the others."""

import signal
from contextlib import contextmanager

import pytest

LIMIT = 120.0  # [s]; every call takes seconds at most, which on a machine with other work may be a minute


@contextmanager
def within(seconds):
    def over(*_):
        raise TimeoutError(f"not done in {seconds:g} s")

    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture
def time_limit(request):
    """For modules whose tests might never end: `pytest.mark.usefixtures("time_limit")`."""
    if "hypothesis" in request.keywords:  # as long as its cases take, of which there may be many
        yield
    else:
        with within(LIMIT):
            yield
