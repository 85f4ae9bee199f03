"""What a page cannot show, as its viewer computes in single precision, is refused by name, and nothing of it is written."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.visual import pages

URDF = Path(__file__).resolve().parents[2] / "urdf"
BOX = '<box size="0.46 0.03 1.02"/>'


def turn(press, speed):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)  # that it is fast
        return pp.cycle(press, speed, points=24)


@pytest.mark.parametrize("make", [pp.record, pp.report])
def test_a_motion_too_slow_or_too_fast_for_the_viewer_is_refused(tmp_path, make):
    """Its time is beyond 3.4e38 s, and would be infinite there; or times are the same there."""
    press, file = texts.shipped("crank_slide"), tmp_path / "page.html"
    large = r"the time of the motion is .*: a page shows numbers up to 3e\+38"
    for speed in (1e-300, 1e-38):
        with pytest.raises(pp.PinpressError, match=large):
            make(press, turn(press, speed), file)
    with pytest.raises(pp.PinpressError, match="are too near to each other to be shown"):
        pp.record(press, turn(press, 1e45), file)
    assert not file.exists()


@pytest.mark.parametrize("make", [pp.record, pp.report])
def test_a_page_does_not_replace_another_file(tmp_path, make):
    press = texts.shipped("crank_slide")
    for name in ("press.urdf", "press.YAML", "page.pdf", "cycle.csv", "page"):
        file = tmp_path / name
        file.write_bytes(b"mine")
        with pytest.raises(pp.PinpressError, match=r"would be a web page: end its name in \.html"):
            make(press, turn(press, 1.0), file)
        assert file.read_bytes() == b"mine"


@pytest.mark.parametrize("speed", [1e-37, 1e30])
def test_what_the_viewer_can_tell_apart_is_shown(tmp_path, speed):
    press = texts.shipped("crank_slide")
    assert pp.record(press, turn(press, speed), tmp_path / "page.html").exists()


@pytest.mark.parametrize("shape", ['<box size="1e39 0.03 1.02"/>', '<sphere radius="1e300"/>', '<cylinder radius="0.1" length="1e39"/>'])
def test_a_shape_too_large_for_the_viewer_is_refused(tmp_path, shape):
    text, file = (URDF / "crank_slide.urdf").read_text(encoding="utf-8"), tmp_path / "page.html"
    assert BOX in text
    (tmp_path / "press.urdf").write_text(text.replace(BOX, shape), encoding="utf-8")
    press = pp.load(tmp_path / "press.urdf")
    with pytest.raises(pp.PinpressError, match=r"a visual of link 'frame' is 1e\+\d+: a page shows numbers up to 3e\+38"):
        pp.record(press, turn(press, 7.0), file)
    assert not file.exists()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_page_never_has_a_number_that_is_not_finite(value):
    with pytest.raises(pp.PinpressError, match=re.escape("the page cannot show the slide: a value of it is not finite")):
        pages.page("recording.html", "press", {"time": [0.0, 1.0], "slide": [0.5, value]}, {})
