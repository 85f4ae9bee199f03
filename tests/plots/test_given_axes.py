"""Plots on axes that the caller gives: the same curves as in a figure of ours, on these axes and on no others."""

import numpy as np
import pytest
from support import every_result, texts
from support.sampling import rest_exhaustive

import pinpress as pp

pytest.importorskip("matplotlib")

from matplotlib.figure import Figure

from pinpress import plots

PLOTS = {
    "draw": (3, lambda ax: plots.draw(every_result.reactions(), "height", "velocity", "acceleration", ax=ax)),
    "draw bearings": (2, lambda ax: plots.draw(every_result.reactions(), "bearings", "moments", ax=ax)),
    "draw polar": (2, lambda ax: plots.draw(every_result.reactions(), "polar O", "polar P", ax=ax)),
    "draw harmonics": (2, lambda ax: plots.draw(every_result.reactions(), "shaking", "harmonics", ax=ax)),
    "draw before": (2, lambda ax: plots.draw(every_result.reactions(), "torque", "peaks", before=every_result.reactions(), ax=ax)),
    "draw whirl": (1, lambda ax: plots.draw(made("WhirlDiagram"), "whirl", ax=ax)),
    "draw vibration": (1, lambda ax: plots.draw({"press": made("FrameMotion")}, "acceleration z", ax=ax)),
    "draw guide": (2, lambda ax: plots.draw(made("LoadedGuide"), "surfaces", "rotation", ax=ax)),
    "draw campbell": (1, lambda ax: plots.draw(made("CampbellDiagram"), "campbell", ax=ax)),
    "draw two": (1, lambda ax: plots.draw({name: made("SnapThroughResponse") for name in "ab"}, "spring_force", ax=ax)),
    "draw elastic": (2, lambda ax: plots.draw(made("ElasticRun"), "beside_rigid", "forces", ax=ax)),
    "draw trade_off": (1, lambda ax: plots.draw({name: made("TradeOffCurve") for name in "ab"}, "trade_off", ax=ax)),
    "draw servo": (4, lambda ax: plots.draw({"even": made("ServoMotion")}, "height", "crank_speed", "torque", "power", ax=ax)),
    "draw plane": (1, lambda ax: plots.draw(made("ServoMotion"), "plane", ax=ax)),
    "draw ratings": (3, lambda ax: plots.draw(made("PressRatings"), "force", "near_bottom", "work", ax=ax)),
    "accuracy": (1, lambda ax: pp.accuracy.plot(made("WorkPrecision"), ax=ax)),
    "draw tolerances": (2, lambda ax: plots.draw(made("Scatter").with_limit(5e-5), "shares", "presses", ax=ax)),
    "draw play": (2, lambda ax: plots.draw(made("SlidePlay"), "offset", "by_bearing", ax=ax)),
    "draw budget": (1, lambda ax: plots.draw(made("AccuracyBudget"), "parts", ax=ax)),
    "draw measured force": (1, lambda ax: plots.draw({"one": made("MeasuredForce")}, "force", ax=ax)),
    "draw spectra": (1, lambda ax: plots.draw(made("Spectra"), "spectra", ax=ax)),
    "draw modes": (2, lambda ax: plots.draw(made("MeasuredModes"), "damping", "mac", ax=ax)),
    "draw orders": (1, lambda ax: plots.draw(made("OrderSpectra"), "orders Ax", ax=ax)),
    "draw doubt": (1, lambda ax: plots.draw(made("IdentifiableParameters"), "doubt", ax=ax)),
}


def made(kind):
    return next(value for value in every_result.made() if type(value).__name__ == kind)


def curves(axes):
    return [line.get_xydata() for line in axes.lines] + [patch.get_height() for patch in axes.patches]


def test_every_plot_takes_axes():
    assert {name.split()[0] for name in PLOTS} == set(dir(plots)) - {"save"} | {"accuracy"}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", rest_exhaustive(PLOTS, "draw", "draw polar", "draw before"))
def test_on_given_axes(name):
    count, plot = PLOTS[name]
    figure = Figure(figsize=(8, 8))
    other, *given = figure.subplots(count + 1, 1)
    assert plot(given[0] if count == 1 else np.array(given)) is figure
    ours = plot(None).axes
    assert len(ours) == count
    for mine, own in zip(given, ours, strict=True):
        for one, two in zip(curves(mine), curves(own), strict=True):
            np.testing.assert_array_equal(one, two)
        assert mine.get_ylabel() == own.get_ylabel() or not own.get_ylabel()
    assert not other.has_data()
    assert figure.legends == []
    figure.draw_without_rendering()


@pytest.mark.parametrize(
    ("ax", "message"),
    [
        (3, "ax is 3: give axes of Matplotlib"),
        ([3, 4, 5], "give axes of Matplotlib"),
        ([], "ax has 0 axes, but there are 3 charts to draw"),
    ],
)
def test_axes_that_do_not_fit_are_refused(ax, message):
    with pytest.raises(pp.PinpressError, match=message):
        plots.draw(every_result.motion(), "position", "velocity", "acceleration", ax=ax)
    with pytest.raises(pp.PinpressError, match="ax is 3: give axes of Matplotlib"):
        plots.draw(every_result.reactions(), "torque", ax=3)


def test_letters_of_a_polar_diagram_suit_its_size():
    reactions = pp.inverse_dynamics(texts.shipped("zxn2_3000b"), pp.cycle(texts.shipped("zxn2_3000b"), 7.0, points=36))
    small = Figure(figsize=(3, 3))
    plots.draw(reactions, "polar A", ax=small.subplots())
    small.draw_without_rendering()
    assert len(small.axes[0].texts) > 4
