"""Heat moves the dead centres as links that are longer do, and a press that is warm throughout grows in proportion."""

import numpy as np
import pint
import pytest
from support import texts
from support.generators.spatial_crank_slide import SPATIAL

import pinpress as pp
from pinpress import tolerances
from pinpress.derivatives import pivot_positions, reshaped


@pytest.fixture(scope="module")
def six_bar():
    return texts.shipped("zxn2_3000b")


def grown(press, rise, expansion):
    """The press with every pivot of its warm links away from the link's origin."""
    at = pivot_positions(press)
    return reshaped(press, {key: at[key] * (1 + expansion * rise[key[1]]) for key in at if key[1] in rise})


def test_warm_links_move_dead_centres_as_longer_ones_do(six_bar):
    rise = {"rocker": 10.0, "rod": 10.0, "crank": -3.0, "coupler": 5.0}
    found = tolerances.heat(six_bar, tolerances.Temperatures(rise, 11.5e-6))
    before, after = pp.dead_centres(six_bar), pp.dead_centres(grown(six_bar, rise, 11.5e-6))
    assert found.bottom_shift == pytest.approx(after.bottom_position - before.bottom_position, abs=5e-8)  # of second order
    assert found.top_shift == pytest.approx(after.top_position - before.top_position, rel=2e-3)
    barely = tolerances.heat(six_bar, tolerances.Temperatures(rise, 11.5e-7)).bottom_shift
    assert barely == pytest.approx(pp.dead_centres(grown(six_bar, rise, 11.5e-7)).bottom_position - before.bottom_position, abs=5e-10)
    assert sum(found.bottom_by_link[name] for name in ("rocker", "rod")) == pytest.approx(-0.110e-3, abs=1e-6)
    assert found.bottom_by_link["rod"] == pytest.approx(10.0 * found.bottom_per_kelvin["rod"])


@pytest.mark.parametrize("press", [texts.shipped("zxn2_3000b"), texts.shipped("jf75g_125_two_point"), texts.load(SPATIAL)])
def test_a_press_that_is_warm_throughout_grows_in_proportion(press):
    """Its height above the table too; that of parallel rods does not depend on how they share forces."""
    table, face = -2.0, -0.6
    rise = dict.fromkeys(press.links, 10.0)
    found = tolerances.heat(press, tolerances.Temperatures(rise, 1e-5, table=table, face=face))
    ends = pp.dead_centres(press)
    assert found.bottom_shift == pytest.approx(1e-4 * (ends.bottom_position + face - table))
    assert found.top_shift == pytest.approx(1e-4 * (ends.top_position + face - table))


def test_materials_by_link_and_a_report_that_names_what_decides(six_bar):
    steel = tolerances.heat(six_bar, tolerances.Temperatures({"rod": 10.0, "frame": 10.0}, table=-1.88))
    mixed = tolerances.heat(six_bar, tolerances.Temperatures({"rod": 10.0, "frame": 10.0}, {"frame": 1e-5}, table=-1.88))
    assert mixed.bottom_by_link["rod"] == steel.bottom_by_link["rod"]
    assert mixed.bottom_by_link["frame"] == pytest.approx(steel.bottom_by_link["frame"] / 1.2)
    assert steel.bottom_by_link["rod"] == pytest.approx(-12e-5 * 0.48, rel=1e-3)
    assert "most by a kelvin                21.365 µm/K   frame" in str(steel)
    assert steel.columns()["link"] == list(steel.bottom_per_kelvin)
    assert "slide" not in steel.bottom_per_kelvin


def test_a_temperature_in_place_of_its_rise_has_a_warning():
    Temperatures = tolerances.Temperatures
    with pytest.warns(pp.PinpressWarning, match=r"'rod' is 303\.15 K, more than usual: give the rise since the press was set"):
        Temperatures({"rod": 303.15})
    assert np.isclose(Temperatures({"rod": 5.0}).times(0.5).rise["rod"], 2.5)


def test_links_that_are_welded_together_are_warm_as_one():
    """Both may be named; the link that they make counts once."""
    cap = '<link name="cap"/><joint name="weld" type="fixed"><parent link="rod"/><child link="cap"/></joint></robot>'
    press = texts.load(texts.shipped("crank_slide").text.decode().replace("</robot>", cap))
    found = tolerances.heat(press, tolerances.Temperatures({"rod": 5.0, "cap": 5.0}, 1e-5))
    assert found.bottom_shift == pytest.approx(-5e-5 * 0.4)
    assert list(found.bottom_by_link) == ["rod"]
    assert found.columns()["bottom_shift [m]"] == pytest.approx([0.0, -5e-5 * 0.4])
    with pytest.raises(pp.PinpressError, match=r"'cap' of .* is welded to a link with another value"):
        tolerances.heat(press, tolerances.Temperatures({"rod": 5.0, "cap": 4.0}))


def test_the_face_of_a_slide_that_is_welded_to_its_carriage_is_measured_from_the_slide():
    """The ram hangs 0.2 m below the carriage that the guide leads; its face is another 0.1 m lower."""
    weld = '<joint name="weld" type="fixed"><parent link="slide"/><child link="ram"/><origin xyz="0 0 -0.2"/></joint>'
    ram = f'<link name="ram"/>{weld}</robot>'
    text = texts.shipped("crank_slide").text.decode().replace("</robot>", ram)
    press = texts.load(text, slide="ram")
    assert press.slide == "ram"
    found = tolerances.heat(press, tolerances.Temperatures({"ram": 10.0}, 1e-5, face=-0.1))
    assert found.bottom_shift == pytest.approx(-1e-4 * 0.3)


def test_quantities_with_units_are_taken():
    unit = pint.UnitRegistry()
    warm = tolerances.Temperatures({"frame": 10.0 * unit.kelvin}, 1e-5 / unit.kelvin, -2000.0 * unit.mm)
    assert (warm.rise["frame"], warm.expansion, warm.table) == pytest.approx((10.0, 1e-5, -2.0))
    guide = tolerances.GuideClearance(0.5 * unit.mm, 250.0 * unit.mm)
    assert (guide.across, guide.length) == pytest.approx((5e-4, 0.25))
