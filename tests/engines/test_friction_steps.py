"""Steps of the fixed point of friction, against the closed form of efforts that answer a change by m times it."""

import numpy as np
import pytest

from pinpress.engines.friction import fixed_point


def settled(slopes):
    answers = np.array(slopes)[None]
    return fixed_point(lambda efforts: (1.0 + answers * efforts, 1.0 + np.abs(answers * efforts)[0]), np.ones_like(answers), 1e-15)


@pytest.mark.parametrize("slope", [-30.0, -19.0, -5.0, -1.0, -0.5, 0.0, 0.9, 0.99])
def test_efforts_that_answer_a_change_settle(slope):
    efforts, change = settled([slope])
    assert change is None
    assert efforts == pytest.approx(1 / (1 - slope), rel=1e-12 / (1 - slope) if slope > 0 else 1e-12)


def test_states_settle_each_with_a_share_of_its_own():
    slopes = np.array([-19.0, -3.0, 0.5, 0.99])
    efforts, change = settled(slopes)
    assert change is None
    assert efforts[0] == pytest.approx(1 / (1 - slopes), rel=1e-10)


@pytest.mark.parametrize("slope", [-40.0, 1.0])
def test_efforts_that_nothing_stops_are_said(slope):
    assert settled([slope])[1] is not None
