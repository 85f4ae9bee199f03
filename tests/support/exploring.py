"""How many random cases a property is tried on: few and always the same ones, or many new ones under `--hypothesis-profile=explore`."""

import os
from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, settings

FIXED, EXPLORE = "fixed", "explore"  # names of profiles
MORE = 30  # cases explored for each one that is tried in continuous integration
FEWER = 6  # cases that are tried there for each one that is always tried

# Cases are whole presses, which take long to make, and folders may be shared: neither says anything of the property.
_COMMON = settings(deadline=None, suppress_health_check=list(HealthCheck))
settings.register_profile(FIXED, _COMMON, derandomize=True)
settings.register_profile(EXPLORE, _COMMON, derandomize=False, print_blob=True)


def examples(count: int) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorates a property that is tried on ``count`` cases in continuous integration, on the first sixth of them elsewhere.

    Drawn at random, these may be such as are legal but hardly meant.
    """
    if not settings.default.derandomize:
        count *= MORE
    elif not os.environ.get("CI"):
        count = max(2, -(-count // FEWER))
    drawn = settings(max_examples=count)
    return lambda test: pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")(drawn(test))
