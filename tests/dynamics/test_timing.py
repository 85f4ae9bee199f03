"""Windows above a height and the timing diagram, against the closed form of a slider-crank and independent numbers."""

import math

import numpy as np
import pytest

import pinpress as pp
from pinpress.jobs.job import results_of

SPEED = 2 * math.pi  # a stroke a second
RAD = math.pi / 180
# height [m]: from and to [deg], window [deg] and [s] at 60 strokes a minute, by an independent NumPy script
WINDOWS = {
    0.05: (54.3146652873, 305.6853347127, 251.3706694253, 0.69825186),
    0.1: (82.8192442185, 277.1807557815, 194.3615115631, 0.53989309),
    0.12: (94.2256239195, 265.7743760805, 171.5487521611, 0.47652431),
}


def angle_at(height):
    """Crank angle above bottom dead centre at a height of crank_slide, r = 0.1 m, l = 0.4 m, by the law of cosines [deg]."""
    pin = 0.5 - height
    return math.degrees(math.acos((0.1**2 + pin**2 - 0.4**2) / (2 * 0.1 * pin)))


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("height", WINDOWS)
def test_one_window_through_top_dead_centre(height, sense):
    [window] = pp.measures.windows(pp.cycle(pp.load("crank_slide"), sense * SPEED), above=height)
    begins, ends, turned, duration = WINDOWS[height]
    assert np.degrees([window.crank_angle, window.ends_at]) == pytest.approx([begins, ends][::sense], abs=6e-11)
    assert np.degrees(window.turned) == pytest.approx(turned, abs=2.1e-10)  # the script's own last digit: 1.9e-10 off the closed form
    assert window.duration == pytest.approx(duration, abs=6e-9)
    assert np.degrees(window.turned) == pytest.approx(360 - 2 * angle_at(height), abs=1e-11)


def test_window_and_dwell_share_the_turn_and_a_zero_moves_the_window():
    press = pp.load("zxn2_3000b")
    motion = pp.cycle(press, 7.0)
    [window] = pp.measures.windows(motion, above=0.02)
    assert window.turned + pp.measures.dwell_angle(motion, 0.02) == pytest.approx(2 * math.pi, abs=1e-9)
    from_top = pp.job("zxn2_3000b", zero="tdc", speed=7.0, feed={"above": 0.02}).timing().feed
    assert from_top.crank_angle > from_top.ends_at  # through the period's end
    assert from_top.turned == pytest.approx(window.turned, abs=1e-9)
    top = pp.dead_centres(press).top_angle
    assert (window.crank_angle - top - from_top.crank_angle + 1.0) % (2 * math.pi) == pytest.approx(1.0, abs=1e-9)


def test_process_acts_between_the_heights_of_its_load_on_its_way():
    press = pp.load("crank_slide")
    blow = pp.loads.Blanking(1e5, start=0.006, end=0.002, stripping=1e3)
    loads = [blow, pp.loads.ConstantForce(1e4, 0.01), pp.loads.PointForce("slide", (0.0, 0.0, 1.0))]
    bars = pp.measures.timing(press, pp.cycle(press, SPEED), 0.1, loads=loads).bars
    upper, lower, pulse = angle_at(0.006), angle_at(0.002), angle_at(0.01)
    known = [(pulse, 360 - pulse), (lower, upper), (360 - upper, 360 - lower), (360 - pulse, pulse), WINDOWS[0.1][:2]]
    assert [each.name for each in bars] == ["die open", "process", "process", "process", "feed window"]
    assert np.degrees([(each.crank_angle, each.ends_at) for each in bars]) == pytest.approx(np.array(known), abs=1e-7)
    to_the_bottom = pp.measures.timing(press, pp.cycle(press, SPEED), 0.1, loads=[pp.loads.DeepDrawing(1e4, start=0.04)]).bars[1]
    assert np.degrees([to_the_bottom.crank_angle, to_the_bottom.turned]) == pytest.approx([360 - angle_at(0.04), angle_at(0.04)], abs=1e-8)


@pytest.mark.parametrize("sense", [1, -1])
def test_feeder_reserve_and_windows_of_others(sense):
    press = pp.load("crank_slide")
    motion = pp.cycle(press, sense * SPEED)
    found = pp.measures.timing(press, motion, 0.1, feed_time=0.4, bars={"ejector": (20 * RAD, 80 * RAD), "holder": (300 * RAD, 40 * RAD)})
    feeder, reserve, ejector, holder = found.bars[-4:]
    assert found.reserve == reserve.duration == pytest.approx(0.53989309 - 0.4, abs=6e-9)
    assert feeder.crank_angle == found.feed.crank_angle
    assert reserve.ends_at == pytest.approx(found.feed.ends_at)
    assert found.highest_speed == pytest.approx(found.feed.turned / 0.4)
    assert np.degrees([ejector.turned, holder.turned]) == pytest.approx([60, 100] if sense > 0 else [300, 260])
    assert holder.duration == pytest.approx(holder.turned / SPEED)
    [chart] = [block for block in found.described()[0].blocks if hasattr(block, "curves")]
    assert [curve.name for curve in chart.curves] == [each.name for each in found.bars]
    assert [np.ptp(curve.x) for curve in chart.curves] == pytest.approx([each.turned for each in found.bars])


def test_a_feeder_that_needs_too_long_is_warned_of():
    press = pp.load("crank_slide")
    with pytest.warns(
        pp.PinpressWarning, match=r"needs 600 ms, but the slide is above 100 mm for 539\.893 ms: it fits up to 53\.989 r/min"
    ):
        found = pp.measures.timing(press, pp.cycle(press, SPEED), 0.1, feed_time=0.6)
    assert found.reserve == pytest.approx(0.53989309 - 0.6, abs=6e-9)
    assert "reserve" not in [each.name for each in found.bars]


def test_the_diagram_of_a_job():
    job = pp.job("crank_slide", speed=SPEED, feed={"above": 0.1, "time": 0.4, "bars": {"muting": (0.1, 3.0)}})
    assert [type(each).__name__ for each in results_of(job)] == ["TimingDiagram"]
    assert [each.name for each in job.timing().bars] == ["feed window", "feeder", "reserve", "muting"]


REFUSALS = [
    (lambda press, motion: pp.measures.windows(motion, above=0.2), r"above is 0\.2: give a distance between 0 and the stroke"),
    (lambda press, motion: pp.measures.windows(motion, above=0.0), r"above is 0"),
    (lambda press, motion: pp.measures.timing(press, motion, 0.1, bars={"ejector": (1.0, 1.0)}), "bars: ejector is .*two different"),
    (lambda press, motion: pp.measures.timing(press, motion, 0.1, bars={"ejector": (1.0, 2.0, 3.0)}), "bars: ejector is .*two different"),
    (lambda press, motion: pp.measures.timing(press, motion, 0.1, feed_time=-1.0), "feed_time is -1"),
    (lambda press, motion: pp.measures.timing(pp.load("thin_wall"), motion, 0.1), "other joints"),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=range(len(REFUSALS)))
def test_refused(call, message):
    press = pp.load("crank_slide")
    with pytest.raises(pp.PinpressError, match=message):
        call(press, pp.cycle(press, SPEED))
