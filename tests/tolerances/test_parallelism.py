"""Slopes of slides on two and four points, against chains of their own, closed forms and least squares by hand."""

import re
from dataclasses import replace
from math import erf

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress import tolerances as tol
from pinpress.derivatives import pivot_positions, reshaped

HALF = 0.3  # from the middle of the two-point press to its points [m]


@pytest.fixture(scope="module")
def two_points():
    return texts.shipped("jf75g_125_two_point")


def chain(press, side):
    """Radius, rod, height of the shaft and indexing of the throw of one point."""
    pin, point = f"P2_{side}", f"P4_{side}"
    return [
        tol.link_length(press, "O", pin, 10e-6, name=f"r {side}"),
        tol.link_length(press, pin, point, 20e-6, name=f"rod {side}"),
        tol.pin_position(press, "O", "z", 10e-6, name=f"shaft {side}"),
        tol.Dimension(f"index {side}", {(pin, "crank"): (0.0, 0.0, 0.015)}, np.radians(0.02), unit="rad"),
    ]


def chains(press):
    return {f"P4_{side}": chain(press, side) for side in ("front", "back")}


@pytest.fixture(scope="module")
def found(two_points):
    return tol.parallelism(two_points, chains(two_points), samples=20_000)


def test_two_points_have_the_slopes_of_crank_slides(found):
    along, across = found.slopes
    assert (along.first_order_sd, across.first_order_sd) == pytest.approx((0.0, 19.245e-6), rel=1e-4)
    assert across.sd == pytest.approx(19.245e-6, rel=0.02)
    assert found.slope_sd[30, 1] == pytest.approx(18.06e-6, rel=1e-3)  # a quarter of a turn after bottom dead centre
    assert across.worst_case == pytest.approx(2 * 40e-6 / (2 * HALF))
    assert found.within(2 * 19.245e-6) == pytest.approx(0.9545, abs=0.006)
    assert share(across, "rod front") == pytest.approx(1 / 3)
    assert share(across, "index back") == pytest.approx(0.0, abs=1e-12)


def share(slope, name):
    return slope.share[[part.name for part in slope.parts].index(name)]


def gradient(found, name):
    """Derivatives (2,) of both slopes by a dimension."""
    return [slope.gradient[[part.name for part in slope.parts].index(name)] for slope in found.slopes]


def test_a_point_moves_as_a_press_with_its_chain_alone(two_points, found):
    """The press with one rod has the same lengths: what moves its slide tilts the other one."""
    single, by = texts.shipped("jf75g_125"), 1e-5
    pivots, centres = pivot_positions(single), pp.dead_centres(single)
    longer = {
        "r": {("P2", "crank"): pivots["P2", "crank"] + [by, 0, 0]},
        "rod": {("P4", "main_rod"): pivots["P4", "main_rod"] + [by, 0, 0]},
        "shaft": {("O", "frame"): pivots["O", "frame"] + [0, 0, by]},
    }
    for name, moved in longer.items():
        change = pp.dead_centres(reshaped(single, moved)).bottom_position - centres.bottom_position
        assert gradient(found, f"{name} back")[1] == pytest.approx(change / by / (2 * HALF), rel=1e-4)
        assert gradient(found, f"{name} front")[1] == pytest.approx(-change / by / (2 * HALF), rel=1e-4)


def test_every_press_of_the_sample_has_the_slope_of_two_presses_with_one_rod(two_points):
    """Tolerances a hundred times as wide, of lengths and of the indexing, which does nothing at the dead centre to first order."""
    wide = {
        point: [tol.Dimension(part.name, part.direction, 100 * part.tolerance, unit=part.unit) for part in parts]
        for point, parts in chains(two_points).items()
    }
    found = tol.parallelism(two_points, wide, samples=30)
    single, slope = texts.shipped("jf75g_125"), found.slopes[1]
    pivots, angle = pivot_positions(single), pp.dead_centres(two_points).bottom_angle
    names, drawn = [part.name for part in slope.parts], found.deviations

    def height(side, k):
        r, rod, shaft, index = (drawn[names.index(f"{what} {side}"), k] for what in ("r", "rod", "shaft", "index"))
        along = pivots["P2", "crank"] / np.linalg.norm(pivots["P2", "crank"])
        moved = {
            ("P2", "crank"): pivots["P2", "crank"] + r * along + index * np.array([0.0, 0.0, 0.015]),
            ("P4", "main_rod"): pivots["P4", "main_rod"] + rod * pivots["P4", "main_rod"] / np.linalg.norm(pivots["P4", "main_rod"]),
            ("O", "frame"): pivots["O", "frame"] + [0.0, 0.0, shaft],
        }
        return pp.servo_cycle(reshaped(single, moved), [angle], speed=0.0).slide_position[0]

    for k in (0, 29):
        assert slope.deviation[k] == pytest.approx((height("back", k) - height("front", k)) / (2 * HALF), abs=1e-12)
    assert (
        np.abs(slope.gradient @ drawn - slope.deviation).max() > 1e-7
    )  # first order is not exact, 1e5 times as far off as the presses are
    assert slope.corners == pytest.approx([-slope.worst_case, slope.worst_case], rel=1e-3)
    assert not found.slopes[0].deviation.any()


def test_the_indexing_of_the_throws_alone_tilts_the_slide_of_second_order(two_points):
    """Each throw is off its dead centre by its own angle: the slide is higher there by z'' / 2 times its square."""
    indexing = {
        point: [tol.Dimension(part.name, part.direction, 0.03, unit="rad") for part in parts[3:]]
        for point, parts in chains(two_points).items()
    }
    found = tol.parallelism(two_points, indexing, samples=50)
    front, back = (found.deviations[[part.name for part in found.slopes[1].parts].index(f"index {side}")] for side in ("front", "back"))
    assert found.slopes[1].first_order_sd == pytest.approx(0.0, abs=1e-12)
    curvature = 0.015 * (1 + 0.015 / 0.3)
    arc = 0.015  # on a straight line the throw becomes longer by as much as its angle takes it away from the arc
    expected = 0.5 * (curvature - arc) * (back**2 - front**2) / (2 * HALF)
    assert found.slopes[1].deviation == pytest.approx(expected, abs=2e-3 * np.abs(expected).max())
    assert "No dimension tilts the slide to first order" in str(found)


def test_guides_hold_the_slope_of_soft_points(two_points, found):
    k, turning = 1e9, 1e8
    held = tol.parallelism(two_points, chains(two_points), point_stiffness=k, guide_stiffness=turning, samples=100)
    share = 2 * k * HALF**2 / (2 * k * HALF**2 + turning)
    assert held.slopes[1].first_order_sd == pytest.approx(share * found.slopes[1].first_order_sd)
    assert held.guide_moment_sd[1] == pytest.approx(turning * held.slopes[1].first_order_sd)
    assert held.point_force_sd == pytest.approx(held.guide_moment_sd[1] / (2 * HALF))
    assert found.point_force_sd is None
    assert found.misfit_sd.max() < 1e-12


def test_rods_that_err_alike_tilt_the_slide_less(two_points):
    """The slope is the difference of two heights: its variance falls by the coefficient of correlation of the rods."""
    rods = {point: each[1:2] for point, each in chains(two_points).items()}
    springs = {"point_stiffness": 1e9, "guide_stiffness": 1e8}
    alone = tol.parallelism(two_points, rods, samples=100, **springs)
    alike = tol.parallelism(two_points, rods, samples=100, correlation={("rod front", "rod back"): 0.75}, **springs)
    assert alone.slopes[1].first_order_sd > 1e-6
    assert alike.slope_sd == pytest.approx(0.5 * alone.slope_sd, rel=1e-9)
    assert alike.point_force_sd == pytest.approx(0.5 * alone.point_force_sd, rel=1e-9, abs=1e-6)


def test_presses_that_keep_a_table_of_permissible_slopes(two_points, found):
    """0.01 mm and 0.03 mm a metre, over 0.5 m along the line of the points; a force beside their middle tilts the slide on its springs."""
    row = tol.PermissibleSlope
    k, turning, sd = 1e9, 1e8, 19.245e-6
    table = {"fine": row(5e-6, 15e-6), "coarse": row(10e-6, 30e-6), "slope": row(0.0, 38.49e-6)}
    shares = found.kept(table, (0.8, 0.5))
    assert [shares[name] for name in table] == pytest.approx(
        [erf(limit / sd / np.sqrt(2)) for limit in (25e-6, 50e-6, 38.49e-6)], abs=0.006
    )
    assert shares["slope"] == found.within(38.49e-6)

    held = tol.parallelism(two_points, chains(two_points), point_stiffness=k, guide_stiffness=turning, samples=20_000)
    tilt = 1e5 * 0.02 / (2 * k * HALF**2 + turning)
    left = held.slopes[1].first_order_sd
    limit = tilt + left
    middle = held.places.mean(axis=0)
    loaded = held.kept({"under force": row(0.0, limit, 1e5, np.add(middle, (0.0, 0.02)))}, (1.0, 1.0))["under force"]
    assert loaded == pytest.approx(0.5 * (erf(1 / np.sqrt(2)) + erf((2 * tilt + left) / left / np.sqrt(2))), abs=0.01)
    within = [np.abs(slope.deviation + by_force) <= limit for slope, by_force in zip(held.slopes, (0.0, tilt), strict=True)]
    assert loaded == np.mean(np.logical_and(*within))  # a force upwards raises its own side
    elsewhere = replace(held, places=np.add(held.places, (0.1, -0.2)))  # the origin of the places does not matter
    moved = row(0.0, limit, 1e5, np.add(middle, (0.1, 0.02 - 0.2)))
    assert elsewhere.kept({"under force": moved}, (1.0, 1.0))["under force"] == loaded
    assert held.kept({"across": row(0.0, 0.9e-3, 1e5, np.add(middle, (1.0, 0.0)))}, (1.0, 1.0))["across"] == 0.0  # 1e-3 by the guides alone


def test_a_dimension_of_several_points_moves_them_alike(two_points):
    shaft = tol.pin_position(two_points, "O", "z", 1e-5)
    rod = tol.link_length(two_points, "P2_front", "P4_front", 2e-5)
    found = tol.parallelism(two_points, {"P4_front": [shaft, rod], "P4_back": [shaft]}, samples=100)
    assert gradient(found, "O z") == pytest.approx([0, 0], abs=1e-9)
    assert share(found.slopes[1], "P2_front-P4_front") == pytest.approx(1.0)


def six_bar_on_two_points(half):
    """The text of zxn2_3000b with two rods, beside its plane."""
    text = re.sub(r"<visual>.*?</visual>", "", texts.shipped("zxn2_3000b").text.decode(), flags=re.DOTALL)
    parts = [re.search(pattern, text, re.DOTALL)[0] for pattern in (r'<link name="rod".*?</link>', r'<joint name="E".*?</joint>')]
    parts.append(re.search(r'<loop_joint name="F".*?</loop_joint>', text)[0])
    doubled = ""
    for side, y in (("front", -half), ("back", half)):
        link, joint, loop = (re.sub(r'"(rod|E|F)"', rf'"\1_{side}"', part) for part in parts)
        doubled += link + re.sub(r'xyz="(\S+) 0 (\S+)"', rf'xyz="\1 {y} \2"', joint, count=1)
        doubled += loop.replace('link2 link="slide" xyz="0 0 0"', f'link2 link="slide" xyz="0 {y} 0"')
    for part in parts:
        text = text.replace(part, "")
    return text.replace("</robot>", doubled + "</robot>")


def test_a_six_bar_on_two_points_against_the_six_bar_with_one_rod():
    """Coupler and rocker move both points alike; the slide's guide along itself moves none; rods and their seats tilt the slide."""
    press, single = texts.load(six_bar_on_two_points(0.4)), texts.shipped("zxn2_3000b")
    shared = [tol.link_length(press, pin, "C", 5e-4) for pin in "DB"]
    own = {
        side: [
            tol.link_length(press, f"E_{side}", f"F_{side}", 5e-4, name=f"rod {side}"),
            tol.Dimension(f"seat {side}", {(f"E_{side}", "rocker"): (1.0, 0.0, 0.0)}, 5e-4),
        ]
        for side in ("front", "back")
    }
    guide = tol.pin_position(press, "slide_guide", "z", 1e-3)
    found = tol.parallelism(press, {"F_front": [*shared, *own["front"], guide], "F_back": [*shared, *own["back"]]}, samples=20)
    slope, at, angle = found.slopes[1], pivot_positions(single), pp.dead_centres(press).bottom_angle
    drawn = dict(zip([part.name for part in slope.parts], found.deviations[:, 19], strict=True))
    heights = {}
    for side in ("front", "back"):
        by = {("C", "rocker"): drawn["DC"], ("C", "coupler"): drawn["BC"], ("F", "rod"): drawn[f"rod {side}"]}
        moved = {key: at[key] * (1 + deviation / np.linalg.norm(at[key])) for key, deviation in by.items()}
        moved["E", "rocker"] = at["E", "rocker"] + [drawn[f"seat {side}"], 0.0, 0.0]
        heights[side] = pp.servo_cycle(reshaped(single, moved), [angle], speed=0.0).slide_position[0]
    assert slope.deviation[19] == pytest.approx((heights["back"] - heights["front"]) / 0.8, abs=1e-12)
    assert [gradient(found, name)[1] for name in ("DC", "BC", "slide_guide z")] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


BODY = '<inertial><mass value="{}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
WIDTH, DEPTH = 0.4, 0.25


def four_point_text(from_slide=False):
    """Two cranks that gears turn against each other, at x = -WIDTH and WIDTH, with rods at y = -DEPTH and DEPTH. Rods hang by their upper
    pins P from the cranks and close loops at their lower pins W, or the other way round."""
    links, joints, loops = [], [], []
    for side, x in (("left", -WIDTH), ("right", WIDTH)):
        mimic = "" if side == "left" else '<mimic joint="left" multiplier="-1"/>'
        links.append(f'<link name="crank_{side}">{BODY.format(20)}</link>')
        joints.append(
            f'<joint name="{side}" type="continuous"><parent link="frame"/><child link="crank_{side}"/><origin xyz="{x} 0 0"/>'
            f'<axis xyz="0 -1 0"/>{mimic}</joint>'
        )
        for end, y in (("front", -DEPTH), ("back", DEPTH)):
            links.append(f'<link name="rod_{side}_{end}">{BODY.format(10)}</link>')
            upper, lower = (f"P_{side}_{end}", f"crank_{side}", f"0 {y} -0.02"), (f"W_{side}_{end}", "slide", f"{x} {y} 0")
            joint, loop, along = (lower, upper, 0.3) if from_slide else (upper, lower, -0.3)
            joints.append(
                f'<joint name="{joint[0]}" type="continuous"><parent link="{joint[1]}"/><child link="rod_{side}_{end}"/>'
                f'<origin xyz="{joint[2]}"/><axis xyz="0 -1 0"/></joint>'
            )
            loops.append(
                f'<loop_joint name="{loop[0]}" type="spherical"><link1 link="rod_{side}_{end}" xyz="0 0 {along}"/>'
                f'<link2 link="{loop[1]}" xyz="{loop[2]}"/></loop_joint>'
            )
    guide = (
        '<joint name="guide" type="prismatic"><parent link="frame"/><child link="slide"/><origin xyz="0 0 -0.32"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    )
    drive = '<transmission name="drive"><joint name="left"/></transmission>'
    slide = f'<link name="slide">{BODY.format(500)}</link>'
    return f'<robot name="four_points"><link name="frame"/>{slide}{"".join(links + joints)}{guide}{"".join(loops)}{drive}</robot>'


@pytest.mark.parametrize("from_slide", [False, True])
def test_four_points_take_the_plane_of_least_squares_and_force_the_rest_into_the_slide(from_slide):
    press = texts.load(four_point_text(from_slide))
    points = [f"W_{side}_{end}" for side in ("left", "right") for end in ("front", "back")]
    rods = {point: [tol.link_length(press, point.replace("W", "P"), point, 3e-5, name=point)] for point in points}
    k, turning = 2e9, 5e7
    free = tol.parallelism(press, rods, samples=100)
    held = tol.parallelism(press, rods, point_stiffness=k, guide_stiffness=turning, samples=100)
    assert set(free.points) == set(points)
    points = list(free.points)
    x = np.array([-WIDTH if "left" in point else WIDTH for point in points])
    y = np.array([-DEPTH if "front" in point else DEPTH for point in points])
    assert free.places == pytest.approx(np.column_stack([x, y]))
    for number, point in enumerate(points):
        lower = -np.eye(4)[number]  # a longer rod
        assert gradient(free, point) == pytest.approx([x @ lower / (x @ x), y @ lower / (y @ y)])
        assert gradient(held, point) == pytest.approx([k * x @ lower / (k * x @ x + turning), k * y @ lower / (k * y @ y + turning)])
    twist = 1e-5 / 4 * 2  # four rods of a standard deviation of 10 um: the twist is a quarter of their alternating sum
    assert free.misfit_sd == pytest.approx(twist * np.ones(4))
    order = [[part.name for part in free.slopes[0].parts].index(point) for point in points]
    assert free.slopes[0].deviation == pytest.approx(-(x / (x @ x)) @ free.deviations[order], abs=1e-12)  # rods straight, at the bottom
    assert held.point_force_sd[0] > k * twist
    assert "forced into the slide" in str(free)


def test_a_guide_beside_several_points_may_not_stand_askew_by_a_moment_that_is_open():
    press = texts.load(four_point_text())
    motion = pp.cycle(press, 7.0, points=12)
    assert tol.play(press, motion, {"guide": 2e-5}).offset == pytest.approx(0.0, abs=1e-5)
    with pytest.raises(pp.PinpressError, match="does not determine the moment of this guide"):
        tol.play(press, motion, {"guide": tol.GuideClearance(2e-5, 0.3)})
