"""Recordings, opened in a real browser with the network off: what a user sees after a double click."""

import dataclasses
import importlib.util
import io
import itertools
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import pinpress as pp

SPEED = 70 * pp.RPM
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", "--hide-scrollbars"]


def unavailable(reason: str) -> None:
    """A missing browser skips these tests on a developer's machine and fails them in CI."""
    (pytest.fail if os.environ.get("CI") else pytest.skip)(reason)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    executable = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    if executable is None or importlib.util.find_spec("playwright") is None:
        unavailable("needs Chromium and playwright")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=executable, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def view(browser: Any) -> Iterator[Callable[..., Any]]:
    """Opens a recording; at the end of the test nothing may have gone wrong in the page or asked for the network."""
    context = browser.new_context(viewport={"width": 800, "height": 600})
    context.set_offline(True)
    problems: list[str] = []

    def only_files(route: Any) -> None:
        if route.request.url.startswith("file:"):
            route.continue_()
        else:
            problems.append(f"request: {route.request.url}")
            route.abort()

    context.route("**/*", only_files)
    page = context.new_page()
    page.on("console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("dialog", lambda dialog: (problems.append(f"dialog: {dialog.message}"), dialog.dismiss()))

    def open_page(path: Path, fragment: str = "") -> Any:
        page.goto(path.as_uri() + fragment)
        wait(page, "viewer.needs_render === false")
        return page

    yield open_page
    context.close()
    assert problems == []


@pytest.fixture(scope="module")
def press() -> Any:
    return pp.load("crank_slide")


@pytest.fixture(scope="module")
def motion(press: Any) -> Any:
    return pp.cycle(press, speed=SPEED, points=120)


@pytest.fixture(scope="module")
def recording(press: Any, motion: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pp.record(press, motion, tmp_path_factory.mktemp("recording") / "out.html")


def data_in(path: Path) -> dict[str, Any]:
    match = re.search(r'<script type="application/json" id="data">(.*?)</script>', path.read_text("utf-8"), re.DOTALL)
    assert match is not None
    return dict(json.loads(match[1]))


def wait(page: Any, condition: str) -> None:
    """Playwright's wait_for_function would need eval, which the page's security policy refuses."""
    end = time.monotonic() + 10
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"not within 10 s: {condition}"
        page.wait_for_timeout(20)


def seek(page: Any, moment: float) -> Any:
    """Screen picture (height, width, 3) at a time [s]."""
    from PIL import Image

    page.evaluate("t => { setPlaying(false); seek(t); viewer.render(); }", moment)
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(float)


def pixels(page: Any, points: Any) -> Any:
    """Where world points (n, 3) lie on the screen, (n, 2), by the viewer's camera."""
    view, projection = (
        np.array(m).reshape(4, 4).T
        for m in page.evaluate("[viewer.camera.matrixWorldInverse.elements, viewer.camera.projectionMatrix.elements]")
    )
    x, y, z = np.asarray(points).T
    clip = projection @ view @ np.array([x, z, -y, np.ones_like(x)])  # three.js has y up
    width, height = page.evaluate("[viewer.renderer.domElement.clientWidth, viewer.renderer.domElement.clientHeight]")
    return np.column_stack([(clip[0] / clip[3] + 1) / 2 * width, (1 - clip[1] / clip[3]) / 2 * height])


def visible(picture: Any, pixel: Any, colour: str) -> bool:
    """Whether a colour, lit or in shade, is within 3 pixels of a place."""
    column, row = np.rint(pixel).astype(int)
    patch = picture[max(row - 3, 0) : row + 4, max(column - 3, 0) : column + 4].reshape(-1, 3)
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], dtype=float)
    likeness = patch @ wanted / (np.linalg.norm(patch, axis=1) * np.linalg.norm(wanted) + 1e-9)
    return bool(np.any(likeness > 0.98))


def half_size(shape: Any) -> Any:
    """Half the extent of a primitive along its axes [m]."""
    return shape.halfSide if hasattr(shape, "halfSide") else (shape.radius, shape.radius, getattr(shape, "halfLength", shape.radius))


def hexadecimal(colour: Any) -> str:
    return "#" + "".join(f"{round(255 * c):02x}" for c in colour[:3])


@pytest.mark.parametrize("name", pp.presses())
def test_links_are_seen_where_the_mechanics_puts_them(name: str, view: Callable[..., Any], tmp_path: Path) -> None:
    press = pp.load(name)
    motion = pp.cycle(press, speed=SPEED, points=120)
    path = pp.record(press, motion, tmp_path / "out.html")
    assert path.stat().st_size < 2e6
    page = view(path, "#t=0")
    legend = {row["name"]: row["colour"] for row in data_in(path)["legend"]}
    assert set(legend) == set(press.links) - {press.model.frames[1].name}
    visuals = pin.buildGeomFromUrdfString(press.model, press.text.decode(), pin.GeometryType.VISUAL)
    data, placements = press.model.createData(), pin.GeometryData(visuals)
    grid = np.array(list(itertools.product((-0.6, 0, 0.6), repeat=3)))  # places inside a body, as others may lie in front of its centre
    pictures = []
    for i in (0, 25, 50, 85):
        pictures.append(seek(page, motion.time[i]))
        pin.updateGeometryPlacements(press.model, data, visuals, placements, motion.q[i])
        seen = set()
        for visual, placement in zip(visuals.geometryObjects, placements.oMg, strict=True):
            places = pixels(page, grid * half_size(visual.geometry) @ placement.rotation.T + placement.translation)
            assert np.all((places > 0) & (places < (800, 600)))  # the camera holds the whole press
            link = press.model.frames[visual.parentFrame].name
            if hexadecimal(visual.meshColor) == legend.get(link) and any(visible(pictures[-1], place, legend[link]) for place in places):
                seen.add(link)
        assert seen == set(legend), f"at point {i}"
    for before, after in itertools.pairwise(pictures):
        assert np.count_nonzero(np.abs(after - before).max(axis=2)[:520] > 30) > 500  # above the control bar


def test_poses_between_keys_and_over_the_seam(press: Any, motion: Any, recording: Path, view: Callable[..., Any]) -> None:
    page = view(recording, "#t=0")
    data, frame = press.model.createData(), press.model.getFrameId("slide")
    group = f"viewer.scene_tree.find(['press', '{press.links.index('slide')}']).object"
    height = f"t => {{ seek(t); return {group}.position.z }}"
    for i in (0, 7, 60, 119):
        pin.framesForwardKinematics(press.model, data, motion.q[i])
        assert page.evaluate(height, motion.time[i]) == pytest.approx(data.oMf[frame].translation[2], abs=1e-6)
    duration = page.evaluate("duration")
    assert duration == pytest.approx(2 * np.pi / SPEED, abs=1e-6)
    assert page.evaluate(height, duration) == pytest.approx(page.evaluate(height, 0), abs=1e-7)


def test_address_slider_and_space_bar(recording: Path, view: Callable[..., Any], motion: Any) -> None:
    page = view(recording, "#t=0.25")
    state = "[now, playing, document.getElementById('time').textContent]"
    assert page.evaluate(state) == [0.25, False, "0.250 s"]
    assert page.inner_text("#crank") == f"crank{np.degrees(0.25 * SPEED):.1f}°"
    assert float(page.inner_text("#slide")[5:-3].replace("\u2212", "-")) == pytest.approx(
        1e3 * np.interp(0.25, motion.time, motion.slide_position), abs=0.1
    )
    page.locator("#slider").fill("0.4")
    assert page.evaluate(state) == [0.4, False, "0.400 s"]
    assert page.evaluate("location.hash") == "#t=0.400"
    page.evaluate("location.hash = '#t=0.1'")
    wait(page, "now === 0.1")
    page.keyboard.press("Space")
    wait(page, "playing && now > 0.12")
    page.keyboard.press("Space")
    stopped = page.evaluate("now")
    page.wait_for_timeout(100)
    assert page.evaluate("[now, playing]") == [stopped, False]


def test_plays_in_real_time(recording: Path, view: Callable[..., Any]) -> None:
    page = view(recording)
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


def test_hostile_names_are_text(press: Any, motion: Any, tmp_path: Path, view: Callable[..., Any]) -> None:
    text = press.text.replace(b'"rod"', b'"r/od &lt;/script&gt;&lt;script&gt;alert(2)&lt;/script&gt;"')
    hostile = dataclasses.replace(press, name="<script>alert(1)</script>{{viewer}}", text=text, model=pin.buildModelFromXML(text.decode()))
    page = view(pp.record(hostile, motion, tmp_path / "out.html"), "#t=0.1")
    assert page.inner_text("h1") == page.title() == "<script>alert(1)</script>{{viewer}}"
    assert "r/od </script><script>alert(2)</script>" in page.inner_text("#legend")
    assert page.evaluate("viewer.scene_tree.find(['press']).object.children.length") == 4


def test_same_input_same_bytes(press: Any, motion: Any, recording: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.html"
    assert pp.record(press, motion, str(again)) == again
    assert again.read_bytes() == recording.read_bytes()
    assert [p.name for p in tmp_path.iterdir()] == ["again.html"]


@pytest.mark.parametrize(("points", "count"), [(2, 2), (36, 37), (120, 121), (1000, 121)])
def test_number_of_keys(points: int, count: int, press: Any, tmp_path: Path) -> None:
    motion = pp.cycle(press, speed=SPEED, points=points)
    data = data_in(pp.record(press, motion, tmp_path / "out.html"))
    assert len(data["time"]) == len(data["crank"]) == len(data["slide"]) == count
    if count > 2:
        assert_allclose([data["time"][-1], data["crank"][-1]], [2 * np.pi / SPEED, 360], atol=1e-6)
        assert data["slide"][-1] == data["slide"][0]


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
    assert data["slide"] is None


def broken(motion: Any, field: str, value: float) -> Any:
    values = np.array(getattr(motion, field))
    values[17] = value
    return dataclasses.replace(motion, **{field: values})


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda m: dataclasses.replace(m, _time=None), "pass time= to cycle"),
        (lambda m: broken(m, "joint_position", np.nan), "motion.q is not finite at index 17"),
        (lambda m: broken(m, "_time", 0.0), "motion.time does not increase"),
    ],
)
def test_motion_that_cannot_be_played(change: Callable[[Any], Any], says: str, press: Any, motion: Any, tmp_path: Path) -> None:
    with pytest.raises(pp.PinpressError, match=re.escape(says)):
        pp.record(press, change(motion), tmp_path / "out.html")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("shape", [b'<mesh filename="rod.stl"/>', b'<capsule radius="0.1" length="1"/>'])
def test_shape_that_cannot_be_drawn(shape: bytes, press: Any, motion: Any, tmp_path: Path) -> None:
    text = press.text.replace(b'<box size="0.400 0.024 0.036"/>', shape)
    assert text != press.text
    with pytest.raises(pp.PinpressError, match=r"link 'rod': .*<box>, <cylinder> and <sphere>"):
        pp.record(dataclasses.replace(press, text=text), motion, tmp_path / "out.html")
    assert list(tmp_path.iterdir()) == []


def test_nothing_to_draw(press: Any, motion: Any, tmp_path: Path) -> None:
    text = re.sub(rb"<visual.*?</visual>", b"", press.text, flags=re.DOTALL)
    with pytest.raises(pp.PinpressError, match="give its links <visual> elements"):
        pp.record(dataclasses.replace(press, text=text), motion, tmp_path / "out.html")


@pytest.mark.parametrize("name", ["missing/out.html", "directory", "file/out.html"])
def test_path_that_cannot_be_written(name: str, press: Any, motion: Any, tmp_path: Path) -> None:
    (tmp_path / "directory").mkdir()
    (tmp_path / "file").touch()
    with pytest.raises(pp.PinpressError, match=r"cannot write .*; give a file in a directory you can write to"):
        pp.record(press, motion, tmp_path / name)
    assert {p.name for p in tmp_path.rglob("*")} == {"directory", "file"}


def test_without_meshcat(press: Any, motion: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(pp.PinpressError, match=re.escape("pip install 'pinpress[recording]'")):
        pp.record(press, motion, tmp_path / "out.html")
    assert list(tmp_path.iterdir()) == []


def test_import_leaves_meshcat_alone() -> None:
    code = "import sys, pinpress.recording; sys.exit('meshcat' in sys.modules or 'umsgpack' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


GEARED = """<robot name="geared">
  <link name="frame"><visual><geometry><box size="0.5 0.02 0.2"/></geometry></visual></link>
  {links}
  <joint name="fast" type="continuous"><parent link="frame"/><child link="pinion"/><origin xyz="-0.1 0 0"/><axis xyz="0 -1 0"/></joint>
  <joint name="slow" type="continuous"><parent link="frame"/><child link="wheel"/><origin xyz="0.1 0 0"/><axis xyz="0 -1 0"/>{mimic}</joint>
  {drives}
</robot>
"""
LINK = """<link name="{0}"><inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><origin xyz="0.04 -0.03 0"/><geometry><box size="0.1 0.02 0.02"/></geometry></visual></link>"""


def geared(folder: Path, mimic: str, *drivers: str) -> Any:
    file = folder / "geared.urdf"
    drives = "".join(f'<transmission name="drive_{name}"><joint name="{name}"/></transmission>' for name in drivers)
    file.write_text(GEARED.format(links=LINK.format("pinion") + LINK.format("wheel"), mimic=mimic, drives=drives), encoding="utf-8")
    return pp.load(file)


def test_a_turn_after_which_the_linkage_is_elsewhere_is_not_closed(tmp_path: Path) -> None:
    """With a gear ratio of 1:2 the wheel has turned half; with 2:1 it is back."""
    for multiplier, keys in (("-0.5", 8), ("-2", 9)):
        press = geared(tmp_path, f'<mimic joint="fast" multiplier="{multiplier}"/>', "fast")
        data = data_in(pp.record(press, pp.cycle(press, speed=SPEED, points=8), tmp_path / "out.html"))
        assert len(data["time"]) == keys


def test_several_drivers(tmp_path: Path, view: Callable[..., Any]) -> None:
    """A linkage with two drivers is recorded too; the angle of the first one is shown."""
    press = geared(tmp_path, "", "fast", "slow")
    time = np.linspace(0, 1, 9)
    motion = pp.cycle(press, angle=np.stack([time, -3 * time], axis=1), speed=[[1.0, -3.0]] * 9, time=time)
    recording = pp.record(press, motion, tmp_path / "two.html")
    assert_allclose(data_in(recording)["crank"], np.degrees(time), atol=1e-4)
    page = view(recording)
    assert not np.array_equal(seek(page, 0.1), seek(page, 0.9))
