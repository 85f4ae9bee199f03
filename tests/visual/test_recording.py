"""Recordings, opened in a real browser with the network off: what a user sees after a double click."""

import dataclasses
import itertools
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose
from support import texts
from support.generators.hostile import NAMES, load_hostile
from support.generators.small_linkages import bolted, geared, two_cranks
from support.in_browser import data_in, floats, pixels, seek, visible, wait
from support.sampling import rest_exhaustive

import pinpress as pp

SPEED = 70 * pp.RPM
SMALL, MIDDLE = (400, 300), (480, 400)  # windows that are drawn fast; the press is 315 pixels high in the larger one


@pytest.fixture(scope="module")
def press() -> Any:
    return texts.shipped("crank_slide")


@pytest.fixture(scope="module")
def motion(press: Any) -> Any:
    return pp.cycle(press, speed=SPEED, points=120)


@pytest.fixture(scope="module")
def recording(press: Any, motion: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pp.record(press, motion, tmp_path_factory.mktemp("recording") / "out.html")


def half_size(shape: Any) -> Any:
    """Half the extent of a primitive along its axes [m]."""
    return shape.halfSide if hasattr(shape, "halfSide") else (shape.radius, shape.radius, getattr(shape, "halfLength", shape.radius))


def same(rgba: Any, colour: str | None) -> bool:
    """Whether a colour is that of six hexadecimal digits, but for rounding."""
    return colour is not None and bool(np.all(np.abs(255 * rgba[:3] - [int(colour[i : i + 2], 16) for i in (1, 3, 5)]) <= 0.51))


ON_COUPLER = (0.6, 0.0, 0.1)  # a point in its frame [m]
LONGEST = 0.2  # arrow of the largest force, in diagonals of the press's box


def arrows_at(page: Any, time: float) -> list[dict[str, Any]]:
    """The arrows of the page as they are drawn at a time [s]: foot and tip in the press's axes, colour."""
    return list(
        page.evaluate(
            """time => {
                if (now !== time) seek(time);  // else it would be drawn again
                return arrows.map(({ group, parts: [,, shaft, head] }) => {
                    const along = new THREE.Vector3(0, 1, 0).applyQuaternion(group.quaternion);
                    const { r, g, b } = shaft.material.color, length = shaft.scale.y + head.scale.y;
                    const foot = group.position.toArray(), tip = group.position.clone().addScaledVector(along, length).toArray();
                    return { shown: group.visible, foot, tip, colour: [r, g, b].map(c => 255 * c) };
                });
            }""",
            time,
        )
    )


@pytest.mark.parametrize("name", pp.presses())
def test_loads_are_given_where_the_mechanics_puts_them(name: str, tmp_path: Path) -> None:
    """Every press, without a browser; the next test sees the simplest, and the one of most links and bearings, in one."""
    press = texts.shipped(name)
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=24))
    page = data_in(pp.record(press, result.motion, tmp_path / "out.html", reactions=result))
    assert {row["name"] for row in page["legend"]} == set(press.links) - {press.model.frames[1].name}
    assert [bearing["name"] for bearing in page["bearings"]] == list(press.bearings)
    places = [floats(path, 3) for path in page["places"]]
    data, size = press.model.createData(), press.size
    for i, q in enumerate(result.motion.q):
        pin.framesForwardKinematics(press.model, data, q)
        for bearing, foot in zip(page["bearings"], feet_of(press, data), strict=True):
            path = places[bearing["place"]]
            assert_allclose(path[min(i, len(path) - 1)], foot, atol=1e-5 * size)  # what rests is given once
    forces = [*result.bearing_force.values(), result.shaking_force]
    assert page["peak"] == pytest.approx(max(np.linalg.norm(force, axis=1).max() for force in forces), rel=1e-6)
    for packed, force in zip([*(bearing["force"] for bearing in page["bearings"]), page["shaking"]], forces, strict=True):
        assert_allclose(floats(packed, 3), [*force, force[0]], atol=1e-6 * page["peak"])


def feet_of(press: Any, data: Any) -> list[Any]:
    """Where the bearings are [m]."""
    joints = [data.oMi[j].translation for j in range(1, press.model.njoints)]
    return joints + [data.oMi[loop.joint1].act(loop.point1) for loop in press.loops]


@pytest.mark.parametrize("name", rest_exhaustive(["crank_slide", "jf75g_125_symmetric"], "crank_slide"))
def test_links_and_loads_are_seen_where_the_mechanics_puts_them(name: str, view: Callable[..., Any], tmp_path: Path) -> None:
    press = texts.shipped(name)
    motion = pp.cycle(press, speed=SPEED, points=120)
    result = pp.inverse_dynamics(press, motion)
    path = pp.record(press, motion, tmp_path / "out.html", reactions=result)
    assert path.stat().st_size < 2e6
    page = view(path, "#t=0", MIDDLE)
    page.evaluate("document.querySelector('header').hidden = true")  # it would lie on the press
    page.click("#show-names")  # they would lie on the arrows
    see_arrows(page, press, motion, [*result.bearing_force.values(), result.shaking_force])
    page.evaluate("['forces', 'paths'].forEach(over => element('show-' + over).click())")  # they would lie on the links
    see_links(page, press, motion, {row["name"]: row["colour"] for row in data_in(path)["legend"]})


def see_links(page: Any, press: Any, motion: Any, legend: dict[str, str]) -> None:
    """Pixels of every link's colour where one of its shapes is, at several times, and pictures that differ."""
    assert set(legend) == set(press.links) - {press.model.frames[1].name}
    visuals = pin.buildGeomFromUrdfString(press.model, press.text.decode(), pin.GeometryType.VISUAL)
    data, placements = press.model.createData(), pin.GeometryData(visuals)
    grid = np.array(list(itertools.product((-0.6, 0, 0.6), repeat=3)))  # places inside a body, as others may lie in front of its centre
    pictures = []
    for i in (0, 25, 85):
        pictures.append(seek(page, motion.time[i]))
        pin.updateGeometryPlacements(press.model, data, visuals, placements, motion.q[i])
        shapes = list(zip(visuals.geometryObjects, placements.oMg, strict=True))
        inside = [grid * half_size(visual.geometry) @ placement.rotation.T + placement.translation for visual, placement in shapes]
        places = pixels(page, np.concatenate(inside)).reshape(len(shapes), len(grid), 2)
        assert np.all((places > 0) & (places < MIDDLE))  # the camera holds the whole press
        seen = set()
        for (visual, _), its in zip(shapes, places, strict=True):
            link = press.model.frames[visual.parentFrame].name
            if link in seen or not same(visual.meshColor, legend.get(link)):
                continue
            if any(visible(pictures[-1], place, legend[link]) for place in its):
                seen.add(link)
        assert seen == set(legend), f"at point {i}"
    for before, after in itertools.pairwise(pictures):
        assert np.count_nonzero(np.abs(after - before).max(axis=2)[:310] > 30) > 180  # above the control bar


def see_arrows(page: Any, press: Any, motion: Any, forces: list[Any]) -> None:
    """Arrows at the bearings and as long as the loads, at several times, and pixels of their colours along them."""
    peak = max(np.linalg.norm(force, axis=1).max() for force in forces)
    longest, data = LONGEST * page.evaluate("size"), press.model.createData()
    seen, wanted = set(), min(3, len(forces) - 1)
    for i in (0, 31, 62, 93):
        picture = seek(page, motion.time[i]) if len(seen) < wanted else None
        pin.framesForwardKinematics(press.model, data, motion.q[i])
        feet = feet_of(press, data)
        for k, (drawn, force) in enumerate(zip(arrows_at(page, motion.time[i]), forces, strict=True)):
            share = np.linalg.norm(force[i]) / peak
            assert drawn["shown"] == (share >= 0.02)
            if not drawn["shown"]:
                continue
            foot, tip = np.array(drawn["foot"]), np.array(drawn["tip"])
            assert_allclose(tip - foot, longest * force[i] / peak / np.sqrt(share), atol=1e-5 * longest)  # by the root of the force
            if k < len(feet):
                assert_allclose(foot, feet[k], atol=1e-5 * longest)
            ends = pixels(page, [foot, tip])
            assert np.all((ends > 0) & (ends < MIDDLE))  # the camera holds the arrows too
            if picture is None:
                continue
            head = np.rint(ends[0] + 0.88 * (ends[1] - ends[0])).astype(int)
            patch = picture[head[1] - 2 : head[1] + 3, head[0] - 2 : head[0] + 3].reshape(-1, 3)
            if np.linalg.norm(ends[1] - ends[0]) > 20 and np.abs(patch - drawn["colour"]).max(axis=1).min() < 12:
                seen.add(k)
    # other arrows may lie on some of them, the largest is seen at one of these times at least
    assert len(seen) >= wanted, seen


@pytest.mark.exhaustive
def test_poses_between_keys_and_over_the_seam(press: Any, motion: Any, recording: Path, shared_view: Callable[..., Any]) -> None:
    page = shared_view(recording, SMALL)
    data, frame = press.model.createData(), press.model.getFrameId("slide")
    group = f"viewer.scene_tree.find(['press', '{press.links.index('slide')}']).object"
    height = f"t => {{ seek(t); return {group}.position.z }}"
    for i in (0, 7, 60, 119):
        pin.framesForwardKinematics(press.model, data, motion.q[i])
        assert page.evaluate(height, motion.time[i]) == pytest.approx(data.oMf[frame].translation[2], abs=1e-6)
    duration = page.evaluate("duration")
    assert duration == pytest.approx(2 * np.pi / SPEED, abs=1e-6)
    assert page.evaluate(height, duration) == pytest.approx(page.evaluate(height, 0), abs=1e-7)


@pytest.mark.exhaustive
def test_without_forces(recording: Path, shared_view: Callable[..., Any]) -> None:
    page = shared_view(recording, SMALL)
    assert page.evaluate("[arrows.length, element('show-forces').offsetParent, element('scale').offsetParent]") == [0, None, None]
    assert page.evaluate("[...document.querySelectorAll('#labels span')].every(value => value.textContent === '')")


@pytest.mark.exhaustive
def test_plays_in_real_time_by_address_slider_and_space_bar(recording: Path, tab: Any, motion: Any) -> None:
    page = tab.open(recording, size=SMALL)
    assert page.evaluate("playing")
    page.locator("#rate").select_option("0.25")
    page.evaluate("seek(0)")
    moments = page.evaluate(
        """() => new Promise(done => {
            const seen = [];
            const step = stamp => {
                seen.push([stamp, now]);
                stamp - seen[0][0] > 700 ? done(seen) : requestAnimationFrame(step);
            };
            requestAnimationFrame(step);
        })"""
    )
    (stamp0, time0), (stamp1, time1) = moments[0], moments[-1]
    assert time1 - time0 == pytest.approx(0.25 * (stamp1 - stamp0) / 1000, abs=0.03)
    page.click("#play")
    assert not page.evaluate("playing")

    state = "[now, playing, document.getElementById('time').textContent]"
    page.evaluate("location.hash = '#t=0.25'")
    wait(page, "now === 0.25")
    assert page.evaluate(state) == [0.25, False, "0.250 s"]
    assert page.inner_text("#crank") == f"crank {np.degrees(0.25 * SPEED):.1f}°"
    height = np.interp(0.25, motion.time, motion.slide_position) - motion.slide_position.min()  # bottom dead centre is among the states
    assert float(page.inner_text("#slide").removeprefix("above BDC ")[:-3]) == pytest.approx(1e3 * height, abs=0.1)
    page.locator("#slider").fill("0.4")
    assert page.evaluate(state) == [0.4, False, "0.400 s"]
    assert page.evaluate("location.hash") == "#t=0.400"
    page.keyboard.press("Space")
    wait(page, "playing && now > 0.41")
    page.keyboard.press("Space")
    stopped = page.evaluate("now")
    page.wait_for_timeout(100)
    assert page.evaluate("[now, playing]") == [stopped, False]
    tab.see_to_problems()


class Tags(HTMLParser):
    """The tags of a page, and the text in each kind of them."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.names = [""]
        self.text: dict[str, str] = {}
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.names.append(tag)

    def handle_data(self, data: str) -> None:
        self.text[self.names[-1]] = self.text.get(self.names[-1], "") + data


def test_hostile_names_are_text(recording: Path, tmp_path: Path) -> None:
    """The page has the tags of any other; in tests/visual/test_report.py a browser shows such names."""
    hostile = load_hostile(tmp_path)
    motion = pp.cycle(hostile, speed=SPEED, points=36)
    path = pp.record(hostile, motion, tmp_path / "out.html", reactions=pp.inverse_dynamics(hostile, motion))
    found, plain = Tags(path.read_text("utf-8")), Tags(recording.read_text("utf-8"))
    assert found.names == plain.names
    assert found.text["h1"].strip() == found.text["title"].strip() == NAMES["crank_slide"]
    data = data_in(path)
    assert NAMES["rod"] in [row["name"] for row in data["legend"]]
    assert {NAMES["P"], NAMES["W"]} < {bearing["name"] for bearing in data["bearings"]}


@pytest.fixture(scope="module")
def traced(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any, Any]:
    """A recording with forces and the path of a point of the coupler, the press and the forces."""
    press = texts.shipped("zxn2_3000b")
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=120))
    path = tmp_path_factory.mktemp("traced") / "out.html"
    return pp.record(press, result.motion, path, reactions=result, traces=[("coupler", ON_COUPLER)]), press, result


@pytest.mark.exhaustive
def test_arrows_take_colour_with_load(traced: tuple[Path, Any, Any], shared_view: Callable[..., Any]) -> None:
    path, press, result = traced
    motion, page = result.motion, shared_view(path, MIDDLE)
    force = np.linalg.norm(result.bearing_force["A"], axis=1)
    order = np.argsort(force)
    blue, green, red = [], [], []
    for i in order[[5, 40, 80, -1]]:
        colour = arrows_at(page, motion.time[i])[press.bearings.index("A")]["colour"]
        for channel, value in zip((red, green, blue), colour, strict=True):
            channel.append(value)
    assert np.all(np.diff(red) > 0)
    assert np.all(np.diff(green) < 0)
    peak = max(np.linalg.norm(f, axis=1).max() for f in (*result.bearing_force.values(), result.shaking_force))
    assert page.inner_text("#peak") == f"{peak / 1e3:.0f} kN"
    assert page.evaluate("[0, 1e-3, 0.9, 12.345, 999.6, 41234, 3.4156e6, 2e9].map(newtons)") == [
        *("0 N", "0 N", "900 mN", "12.3 N", "1.00 kN", "41.2 kN", "3.42 MN", "2000 MN")  # rounding beside the peak is no force
    ]


@pytest.mark.exhaustive
def test_toolbar_shows_and_hides(traced: tuple[Path, Any, Any], shared_view: Callable[..., Any]) -> None:
    page = shared_view(traced[0], MIDDLE)

    def as_at_first() -> Any:
        """The page at 0.1 s, with labels that come from their first places: they stay where they were before."""
        seek(page, 0.1)
        page.evaluate("labels.forEach(label => { label.spot = 0; })")
        return seek(page, 0.1)

    buttons, pictures = ("#show-forces", "#show-names", "#show-paths", "#front-view"), [as_at_first()]

    def differing(one: Any, other: Any) -> int:
        return int(np.count_nonzero(np.abs(other - one).max(axis=2)[50:310] > 30))

    for button in buttons:
        page.click(button)
        pictures.append(seek(page, 0.1))
        assert differing(*pictures[-2:]) > 50, button
    (left, _), (right, below) = pixels(page, [(0.0, 0.1, 0.3), (0.0, -0.1, 0.3)]), pixels(page, [(0.0, 0.0, 0.3), (0.0, 0.0, 0.0)])
    assert abs(right[0] - below[0]) < 0.5
    assert right[1] < below[1]
    assert abs(left[0] - right[0]) < 0.5
    for button in buttons:
        page.click(button)
    assert differing(as_at_first(), pictures[0]) < 50


@pytest.mark.exhaustive
def test_names_and_loads_stand_at_the_bearings(traced: tuple[Path, Any, Any], shared_view: Callable[..., Any]) -> None:
    path, press, result = traced
    motion, page = result.motion, shared_view(path, MIDDLE)
    page.evaluate("t => { seek(t); viewer.render(); }", motion.time[40])
    labels = page.evaluate(
        """[...document.querySelectorAll('#labels div')].map(
            chip => [...chip.querySelectorAll('p')].map(row => [...row.children].map(cell => cell.textContent)))"""
    )
    shown = {name: value for rows in labels for name, value in rows}
    assert set(shown) == {*press.bearings, "force on the floor"}
    for name, force in result.bearing_force.items():
        assert re.fullmatch(r"\d{3}|\d\d\.\d|\d\.\d\d", shown[name].removesuffix(" kN"))  # three digits
        assert float(shown[name].removesuffix(" kN")) == pytest.approx(np.linalg.norm(force[40]) / 1e3, rel=5e-3)
    together = [[name for name, _ in rows] for rows in labels if len(rows) > 1]
    assert together == [["slide_guide", "F"]]
    data = press.model.createData()
    pin.framesForwardKinematics(press.model, data, motion.q[40])
    expected = pixels(page, [data.oMi[j].translation for j in range(1, 5)])
    dots = page.evaluate(
        """[...document.querySelectorAll('#labels i')].slice(0, 4).map(dot => dot.getBoundingClientRect()).map(
            box => [box.x + box.width / 2, box.y + box.height / 2])"""
    )
    assert_allclose(dots, expected, atol=1.0)
    nothing_covered(page)


def nothing_covered(page: Any) -> None:
    """No label lies on another one, on the heading or on the buttons, or beyond the window."""
    boxes = page.evaluate(
        """[...document.querySelectorAll('#labels div, header, #toolbar')].map(part => part.getBoundingClientRect()).map(
            box => [box.left, box.top, box.right, box.bottom])"""
    )
    for (l1, t1, r1, b1), (l2, t2, r2, b2) in itertools.combinations(boxes, 2):
        assert r1 <= l2 or r2 <= l1 or b1 <= t2 or b2 <= t1
    assert all(left >= 0 and top >= 0 and right <= page.viewport_size["width"] for left, top, right, _ in boxes)


@pytest.mark.exhaustive
def test_labels_step_aside_where_many_bearings_are(view: Callable[..., Any], tmp_path: Path) -> None:
    """Thirteen labels on a phone: each stands free, and a line leads from its dot to where it is far from it."""
    press = texts.shipped("jf75g_125_symmetric")
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=12))
    page = view(pp.record(press, result.motion, tmp_path / "out.html", reactions=result), "#t=0", (390, 640))
    for time in result.motion.time[:4]:
        page.evaluate("t => { seek(t); viewer.render(); }", time)
        nothing_covered(page)
        ends = page.evaluate(
            """labels.filter(({ leader }) => leader.style.display !== "none").map(({ leader, chip, x, y }) => {
                const area = areaInView(chip), [x1, y1, x2, y2] = ["x1", "y1", "x2", "y2"].map(name => Number(leader.getAttribute(name)));
                const onEdge = x2 >= area.left - 1 && x2 <= area.right + 1 && y2 >= area.top - 1 && y2 <= area.bottom + 1;
                return [Math.hypot(x1 - x, y1 - y), onEdge];
            })"""
        )
        assert all(off < 0.1 and on_edge for off, on_edge in ends)
    assert ends


@pytest.mark.exhaustive
def test_where_there_is_no_place_for_all_labels_the_largest_forces_have_theirs(view: Callable[..., Any], tmp_path: Path) -> None:
    """61 bearings of twenty four-bars in a row, on a phone."""
    pins: dict[str, Any] = {"O": [0, 0], "P0": [60, 0]}
    links = {"crank": {"pins": "O P0", "mass": 5}}
    for k in range(20):
        pins |= {f"D{k}": [400 * (k + 1), 0], f"P{k + 1}": {f"P{k}": 400, f"D{k}": 90, "side": "up"}}
        links |= {f"coupler_{k}": {"pins": f"P{k} P{k + 1}", "mass": 5}, f"rocker_{k}": {"pins": f"D{k} P{k + 1}", "mass": 5}}
    press = pp.build(units="mm", frame=" ".join(["O", *(f"D{k}" for k in range(20))]), pins=pins, links=links, drive="O")
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=36))
    page = view(pp.record(press, result.motion, tmp_path / "out.html", reactions=result), "#t=0.2", (390, 640))
    page.evaluate("viewer.render()")
    covered, peaks, visible = page.evaluate(
        """[Math.max(...labels.map((one, i) => Math.max(0, ...labels.slice(i + 1).map(two => one.crowded || two.crowded ? 0
                : shared(areaInView(one.chip), areaInView(two.chip)) / two.width / two.height)))),
            labels.map(({ peak }) => peak), labels.map(({ chip }) => getComputedStyle(chip).visibility === "visible")]"""
    )
    assert covered < 0.11
    assert 10 < sum(visible) < len(visible)
    assert peaks == sorted(peaks, reverse=True)
    assert all(visible[:5])


@pytest.mark.exhaustive
def test_paths_of_slide_and_coupler_point(traced: tuple[Path, Any, Any], shared_view: Callable[..., Any]) -> None:
    file, press, result = traced
    motion, page = result.motion, shared_view(file, MIDDLE)
    page.click("#show-names")
    page.click("#show-forces")
    data, frame = press.model.createData(), press.model.getFrameId("coupler", pin.BODY)
    path = []
    for q in motion.q:
        pin.framesForwardKinematics(press.model, data, q)
        path.append(data.oMf[frame].act(np.array(ON_COUPLER)))
    page.evaluate("t => { seek(t); }", motion.time[20])
    dots = page.evaluate("dots.map(({ dot }) => dot.position.toArray())")
    assert_allclose(dots, [[0, 0, motion.slide_position[20]], path[20]], atol=1e-6)
    picture, blue = seek(page, motion.time[80]), np.array([0x29, 0x70, 0xBF]) * 0.7  # of the coupler, darker
    for place in pixels(page, np.array(path)[::6]):
        column, row = np.rint(place).astype(int)
        patch = picture[row - 3 : row + 4, column - 3 : column + 4].reshape(-1, 3)
        assert np.abs(patch - blue).max(axis=1).min() < 45
    ends = page.evaluate(
        """paths.children.map(mesh => mesh.geometry.parameters.path).filter(path => path?.isLineCurve3).map(
            path => [path.v1.toArray(), path.v2.toArray()])[0]"""
    )
    assert_allclose(sorted(end[2] for end in ends), [motion.slide_position.min(), motion.slide_position.max()], atol=1e-6)
    page.click("#show-names")
    page.click("#show-forces")


def test_run_that_swings_back_and_stops(tmp_path: Path) -> None:
    """A free linkage swings; each crank angle comes several times."""
    press = texts.shipped("crank_slide")
    run = pp.simulate(press, duration=2.0, speed=0.0, angle=1.0)
    assert np.any(np.diff(run.crank_angle) > 0)
    assert np.any(np.diff(run.crank_angle) < 0)
    data = data_in(pp.record(press, run, tmp_path / "out.html", reactions=pp.inverse_dynamics(press, run)))
    assert data["time"][-1] == pytest.approx(run.time[-1], abs=1e-6)
    height = run.slide_position - pp.dead_centres(press).bottom_position
    assert_allclose(data["height"], np.interp(data["time"], run.time, height), atol=1e-4)
    assert_allclose(data["crank"], np.degrees(np.interp(data["time"], run.time, run.crank_angle)), atol=0.05)


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # such extremes are warned of
@pytest.mark.exhaustive
def test_small_and_fast_press_of_meshes(
    recording: Path, motion: Any, tmp_path: Path, view: Callable[..., Any], shared_view: Callable[..., Any]
) -> None:
    """A millimetre high, 20 000 strokes a minute, its rod's shank an STL file in millimetres beside the URDF.

    Times and positions are shown as finely as they differ, the picture is that of the large press of boxes.
    """
    import trimesh

    def pictured(page: Any, time: float) -> Any:
        page.evaluate("element('show-names').click()")  # they are placed anew at each drawing
        return seek(page, time)[50:300]

    window = (560, 400)  # so wide that all numbers stand in one row
    page = shared_view(recording, window)
    page.set_viewport_size({"width": window[0], "height": window[1]})
    page.wait_for_timeout(100)  # where it was open in another one
    large = pictured(page, motion.time[40])
    trimesh.creation.box(extents=(400.0, 24.0, 36.0)).export(tmp_path / "shank.stl")

    def scaled(match: re.Match[str]) -> str:
        return f'{match[1]}="{" ".join(repr(float(word) / 1000) for word in match[2].split())}"'

    boxes = texts.shipped("crank_slide").text.decode()
    meshed = boxes.replace('<box size="0.400 0.024 0.036"/>', '<mesh filename="shank.stl" scale="1e-6 1e-6 1e-6"/>')
    assert meshed != boxes
    text = re.sub(r'(?<!axis )\b(xyz|size|radius|length)="([^"]*)"', scaled, meshed)
    (tmp_path / "small.urdf").write_text(text, encoding="utf-8")
    press = pp.load(tmp_path / "small.urdf")
    fast = pp.cycle(press, speed=20_000 * pp.RPM, points=120)
    page = view(pp.record(press, fast, tmp_path / "out.html"), "#t=0", window)
    small = pictured(page, fast.time[40])
    assert page.inner_text("#time") == "0.00100 s"
    assert page.inner_text("#slide") == f"above BDC {1e6 * (fast.slide_position[40] - fast.slide_position.min()):.1f} µm"
    assert np.count_nonzero(np.abs(small - large).max(axis=2) > 30) < 100


def test_same_input_same_bytes(press: Any, motion: Any, recording: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.html"
    assert pp.record(press, motion, str(again)) == again
    assert again.read_bytes() == recording.read_bytes()
    assert [p.name for p in tmp_path.iterdir()] == ["again.html"]


@pytest.mark.parametrize(("points", "count"), [(4, 5), (36, 37), (360, 361), (1000, 361)])
def test_number_of_keys(points: int, count: int, press: Any, tmp_path: Path) -> None:
    motion = pp.cycle(press, speed=SPEED, points=points)
    data = data_in(pp.record(press, motion, tmp_path / "out.html"))
    assert len(data["time"]) == len(data["crank"]) == len(data["height"]) == count
    if count > 2:
        assert_allclose([data["time"][-1], data["crank"][-1]], [2 * np.pi / SPEED, 360], atol=1e-6)
        assert data["height"][-1] == data["height"][0]


def test_part_of_a_turn_is_not_closed(press: Any, motion: Any, tmp_path: Path) -> None:
    half = dataclasses.replace(
        motion,
        **{
            f.name: getattr(motion, f.name)[:60]
            for f in dataclasses.fields(motion)
            if f.init and np.shape(getattr(motion, f.name))[:1] == (120,)
        },
    )
    assert len(data_in(pp.record(press, half, tmp_path / "out.html"))["time"]) == 60


def test_unequal_time_steps_and_no_slide(press: Any, motion: Any, tmp_path: Path) -> None:
    times = 5 + motion.time + 0.3 * motion.time**2
    no_slide = dataclasses.replace(press, slide=None), dataclasses.replace(motion, _time=times, _guide=None)
    data = data_in(pp.record(*no_slide, tmp_path / "out.html"))
    assert_allclose(data["time"][:-1], times - 5, atol=1e-6)
    assert data["height"] is None


def broken(motion: Any, field: str, value: float) -> Any:
    values = np.array(getattr(motion, field))
    values[17] = value
    return dataclasses.replace(motion, **{field: values})


def spoiled(press: Any, motion: Any) -> Any:
    """Reactions with a shaking force that is not finite."""
    result = pp.inverse_dynamics(press, motion)
    result._shaking[0].setflags(write=True)
    result._shaking[0][5, 2] = np.nan
    return result


def test_what_cannot_be_recorded_is_refused(press: Any, motion: Any, tmp_path: Path) -> None:
    other, balanced = texts.shipped("zxn2_3000b"), texts.shipped("zxn2_3000b_balanced")
    turn = pp.cycle(other, speed=SPEED, points=36)
    result, file = pp.inverse_dynamics(other, turn), tmp_path / "out.html"
    states = pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=60))
    faster = pp.inverse_dynamics(other, pp.cycle(other, speed=3 * SPEED, points=36))
    heavier = pp.inverse_dynamics(balanced, pp.cycle(balanced, speed=SPEED, points=36))
    long = pp.servo_cycle(press, angle=np.arange(0, 2 * np.pi * 600, 0.5), speed=1.0)

    def traced(traces: Any) -> Any:
        return lambda: pp.record(press, motion, file, traces=traces)

    for says, call in [
        ("pass time= to servo_cycle", lambda: pp.record(press, dataclasses.replace(motion, _time=None), file)),
        ("motion.joint_position is not finite at index 17", lambda: pp.record(press, broken(motion, "joint_position", np.nan), file)),
        ("motion.time does not increase", lambda: pp.record(press, broken(motion, "_time", 0.0), file)),
        ("turns 120 deg from one state to the next, too far", lambda: pp.record(press, pp.cycle(press, speed=SPEED, points=3), file)),
        ("600 turns are more than a recording holds (555)", lambda: pp.record(press, long, file)),
        ("shaking_force is not finite", lambda: pp.record(press, motion, file, reactions=spoiled(press, motion))),
        ("the reactions are of another motion", lambda: pp.record(press, motion, file, reactions=states)),
        ("the reactions are of another motion", lambda: pp.record(press, motion, file, reactions=result)),
        ("the reactions are of another motion", lambda: pp.record(other, turn, file, reactions=faster)),
        ("the reactions are of zxn2_3000b_balanced, another press than", lambda: pp.record(other, turn, file, reactions=heavier)),
        ("the motion is of zxn2_3000b with other joints than crank_slide", lambda: pp.record(press, turn, file)),
        ("reactions is a Motion, no Reactions: give what inverse_dynamics", lambda: pp.record(other, turn, file, reactions=turn)),
        ("motion is a Reactions, no Motion: give what cycle or simulate", lambda: pp.record(other, result, file)),
        ("press is a str, no Linkage: give what load returns", lambda: pp.report("zxn2_3000b", turn, file)),
        ("before is a str, no Reactions", lambda: pp.report(other, turn, file, before="zxn2_3000b")),
        ("cannot write None", lambda: pp.record(other, turn, None)),
        ("no link 'connecting_rod'", traced([("connecting_rod", (0, 0, 0))])),
        ("trace of 'rod': point has shape (2,)", traced([("rod", (0, 0))])),
        ("trace of 'rod': point is not finite", traced([("rod", (0, 0, np.inf))])),
        ("give a list of a link and a point", traced(("rod", (0, 0, 0)))),
        ("traces is one str: give a list", traced("rod")),
    ]:
        with pytest.raises(pp.PinpressError, match=re.escape(says)):
            call()
        assert list(tmp_path.iterdir()) == [], says
    assert pp.record(pp.load("zxn2_3000b"), turn, file, reactions=result).exists()  # the same press, loaded again


@pytest.mark.one_in(3)
@pytest.mark.parametrize("turned", ["0 0 3.141592653589793", "0 0 -1.5707963267948966", "0 0 1.5707963267948966"])
def test_a_press_is_seen_from_its_front(turned: str, tmp_path: Path) -> None:
    """The ZXN2's frame is a wall behind its links, which face -y as drawn."""
    turned_press = bolted(texts.shipped("zxn2_3000b"), turned)
    data = data_in(pp.record(turned_press, pp.cycle(turned_press, speed=SPEED, points=36), tmp_path / "out.html"))
    yaw = float(turned.split()[2])
    assert_allclose(data["front"], [np.sin(yaw), -np.cos(yaw), 0], atol=1e-9)


@pytest.mark.parametrize("name", ["missing/out.html", "directory.html", "file/out.html"])
def test_path_that_cannot_be_written(name: str, press: Any, motion: Any, tmp_path: Path) -> None:
    (tmp_path / "directory.html").mkdir()
    (tmp_path / "file").touch()
    with pytest.raises(pp.PinpressError, match=r"cannot write .*; give a file in a directory you can write to"):
        pp.record(press, motion, tmp_path / name)
    assert {p.name for p in tmp_path.rglob("*")} == {"directory.html", "file"}


def test_a_turn_after_which_the_linkage_is_elsewhere_is_not_closed(tmp_path: Path) -> None:
    """With a gear ratio of 1:2 the wheel has turned half; with 2:1 it is back."""
    for multiplier, keys in (("-0.5", 8), ("-2", 9)):
        press = geared(f'<mimic joint="fast" multiplier="{multiplier}"/>', "fast")
        data = data_in(pp.record(press, pp.cycle(press, speed=SPEED, points=8), tmp_path / "out.html"))
        assert len(data["time"]) == keys


def test_several_drivers(tmp_path: Path) -> None:
    """The angle of the first one is shown; a picture of such a linkage is in tests/visual/test_report.py."""
    press = two_cranks()
    time = np.linspace(0, 1, 9)
    motion = pp.servo_cycle(press, angle=np.stack([time, -3 * time], axis=1), speed=[[1.0, -3.0]] * 9, time=time)
    assert_allclose(data_in(pp.record(press, motion, tmp_path / "two.html"))["crank"], np.degrees(time), atol=1e-4)
