"""Bars of doubt are those of the result."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")
from matplotlib.patches import Rectangle

import pinpress as pp


def test_bars_end_at_the_doubts():
    press, time = pp.load("crank_slide"), np.linspace(0, 4, 801)
    run = pp.measured.MeasuredRun(time, 8 * time + np.sin(2.5 * time))
    found = pp.measured.identifiability(press, [run], friction=("crank",))
    figure = pp.plots.draw(found, "doubt")
    bars = [bar.get_width() for bar in figure.axes[0].patches if isinstance(bar, Rectangle)]
    assert bars == pytest.approx([each.torque for each in found.parameters] + [each.shaking for each in found.parameters], abs=1e-12)
    assert figure.axes[0].get_yticklabels()[0].get_text() == found.parameters[0].name
    with pytest.raises(pp.PinpressError, match="Give runs"):
        pp.plots.draw(pp.measured.identifiability(press))
