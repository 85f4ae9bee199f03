"""Dimensions by the names of pins move what they say, and are drawn as they say."""

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.derivatives import pivot_positions, reshaped
from pinpress.tolerances.dimensions import check_dimensions, correlation_matrix, draw_deviations

tol = pp.tolerances


@pytest.fixture(scope="module")
def press():
    return texts.shipped("zxn2_3000b")


def moved(press, part, by):
    """The press with a dimension that is larger by this much."""
    at = pivot_positions(press)
    return reshaped(press, {key: at[key] + by * np.asarray(vector) for key, vector in part.direction.items()})


def distances(press, link, pins):
    """Distances between pins of a link, in their order."""
    at = pivot_positions(press)
    points = [at.get((pin, link), np.zeros(3)) for pin in pins]
    return np.array([np.linalg.norm(one - other) for k, one in enumerate(points) for other in points[:k]])


@pytest.mark.parametrize(("first", "second"), [("D", "E"), ("E", "D"), ("C", "D")])
def test_a_link_length_changes_one_distance(press, first, second):
    """The second pin moves, whether or not it is the origin of the link's frame: the third one keeps its distance from the first."""
    other = ({"C", "D", "E"} - {first, second}).pop()
    changed = moved(press, tol.link_length(press, first, second, 5e-5), 1e-3)
    pins = (first, other, second)  # distances of other-first, second-first, second-other
    difference = distances(changed, "rocker", pins) - distances(press, "rocker", pins)
    assert difference[:2] == pytest.approx([0.0, 1e-3], abs=1e-12)
    assert abs(difference[2]) > 1e-5


def test_an_angle_grows_to_first_order(press):
    part = tol.pin_angle(press, "C", "D", "E", 1e-4)
    assert (part.name, part.unit) == ("angle CDE", "rad")

    def angle(shape):
        at = pivot_positions(shape)
        one, other = at["C", "rocker"], at["E", "rocker"]
        return np.arccos(one @ other / np.linalg.norm(one) / np.linalg.norm(other))

    assert angle(moved(press, part, 1e-5)) - angle(press) == pytest.approx(1e-5, rel=1e-6)


def test_directions_of_a_guide_and_of_the_frame(press):
    assert tol.pin_position(press, "slide_guide", "x", 1e-4).direction["slide_guide", "frame"] == pytest.approx([1, 0, 0])
    skew = tol.pin_position(press, "E", (3.0, 0.0, 4.0), 1e-4, link="rocker")
    assert (skew.name, *skew.direction["E", "rocker"]) == ("E (3, 0, 4) in rocker", pytest.approx(0.6), 0.0, pytest.approx(0.8))


SAMPLE = [-4e-5, -1e-5, 2e-5, 3e-5]


@pytest.mark.parametrize("shape", ["normal", "uniform", "truncated", SAMPLE], ids=["normal", "uniform", "truncated", "measured"])
def test_drawn_deviations_have_the_moments_of_their_shape(press, shape):
    sd = 4e-5 if shape == "truncated" else None
    part = tol.link_length(press, "E", "F", 5e-5, shape=shape, sd=sd)
    drawn = draw_deviations([part], np.eye(1), 200_000, 0)[0]
    assert drawn.mean() == pytest.approx(part.mean, abs=5 * part.standard_deviation / 200_000**0.5)
    assert drawn.std() == pytest.approx(part.standard_deviation, rel=0.01)
    if shape != "normal":
        assert np.abs(drawn).max() <= 5e-5
    if shape is SAMPLE:
        assert set(drawn) == set(SAMPLE)


def test_sd_of_a_truncated_dimension_goes_over_into_the_uniform_one():
    sd = [tol.Dimension("d", {("F", "rod"): (1, 0, 0)}, 1.0, "truncated", sd=sd).standard_deviation for sd in (1e-3, 990.0, 1010.0)]
    assert sd == pytest.approx([1e-3, 3**-0.5, 3**-0.5], rel=1e-6)


def test_correlated_dimensions(press):
    parts = [tol.link_length(press, *pins, T) for pins, T in [("AB", 1e-5), ("BC", 3e-5), ("EF", 1e-5)]]
    tied = correlation_matrix(parts, {("AB", "EF"): -0.8})
    drawn = draw_deviations(parts, tied, 100_000, 1)
    assert np.corrcoef(drawn) == pytest.approx(tied, abs=0.015)
    assert drawn.std(axis=1) == pytest.approx([1e-5 / 3, 1e-5, 1e-5 / 3], rel=0.01)
    alone = draw_deviations(parts, np.eye(3), 100_000, 1)
    assert np.array_equal(alone[1], drawn[1])  # what is tied to nothing is drawn as without correlation


def test_tolerances_in_mm_and_degrees_are_doubted(press):
    with pytest.warns(pp.PinpressWarning, match=r"the pins of its link are only 0.48 m apart. Is it 0.05 mm\? Write 0.05e-3"):
        check_dimensions(press, [tol.link_length(press, "E", "F", 0.05)])
    with pytest.warns(pp.PinpressWarning, match="give rad, not degrees"):
        check_dimensions(press, [tol.pin_angle(press, "C", "D", "E", 0.5)])
    with pytest.warns(pp.PinpressWarning, match="give deviations from the nominal"):
        tol.link_length(press, "E", "F", 5e-5, shape=[0.48001, 0.47999])


def test_a_pin_on_which_three_links_meet_moves_as_one(tmp_path):
    """A rod of a knuckle press carries both links of the knuckle: its length moves both bearings of the knee, by either name."""
    table = (
        "units: mm\nframe: A O\npins: {A: [0, 0], O: [600, -300], P: {from: O, length: 100, angle: 60}, "
        "K: {A: 300, P: 498, side: left}, S: {K: 400, x: 0, side: down}}\n"
        "links: {crank: {pins: O P, mass: 20}, rod: {pins: P K, mass: 9}, upper: {pins: A K, mass: 9}, lower: {pins: K S, mass: 9}, "
        "slide: {pins: S, guide: up, mass: 100}}\ndrive: O\n"
    )
    (tmp_path / "knuckle.yaml").write_text(table)
    (tmp_path / "longer.yaml").write_text(table.replace("P: 498", "P: 499"))
    press, longer = pp.build(tmp_path / "knuckle.yaml"), pp.build(tmp_path / "longer.yaml")
    for name in ("K_lower", "K_upper"):
        part = tol.link_length(press, "P", name, 1e-3)
        assert set(part.direction) == {("K_lower", "rod"), ("K_upper", "rod")}
        assert pp.dead_centres(moved(press, part, 1e-3)).top_position == pytest.approx(pp.dead_centres(longer).top_position, abs=1e-12)
        assert set(tol.pin_position(press, name, "z", 1e-3, link="rod").direction) == set(part.direction)
    assert set(tol.pin_position(press, "O", "x", 1e-3).direction) == {("O", "frame")}
