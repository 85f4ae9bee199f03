"""Pictures and films of recordings, and `pinpress record`: with a real Chromium and a real ffmpeg, against screenshots taken apart."""

import asyncio
import contextlib
import importlib.util
import io
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import uuid
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support import texts
from support.in_browser import NO_WEBGL
from support.refused_commands import refused

import pinpress as pp
import pinpress.visual.film as filming
from pinpress.cli.main import main
from pinpress.visual.film import Screen, film, image, slow_enough

SPEED = 70 * pp.RPM
DURATION = 2 * np.pi / SPEED
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
MISSING = CHROMIUM is None or not all(map(importlib.util.find_spec, ("playwright", "imageio_ffmpeg", "PIL")))
SIZE = (240, 180)
RATE = 3  # frames a second
TIMES = np.arange(5) / RATE % DURATION  # every third of a second, and how it goes on when it begins again [s]
GREY = 240
SAME = 2.5  # mean difference of two pictures' values, of 255, up to which they differ by compression and rounding of colours alone


@pytest.fixture(scope="session", autouse=True)
def _needs_a_browser() -> None:
    """Before the one that starts Chromium, which is of the session too."""
    if MISSING:
        pytest.skip("needs Chromium, playwright, imageio-ffmpeg and pillow")


@pytest.fixture(scope="module")
def press() -> Any:
    return texts.shipped("crank_slide")


@pytest.fixture(scope="module")
def page(press: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    motion = pp.cycle(press, speed=SPEED, points=36)
    return pp.record(press, motion, tmp_path_factory.mktemp("page") / "press.html", reactions=pp.inverse_dynamics(press, motion))


def stub(folder: Path, duration: float) -> Path:
    """A page that passes for a recording and is opened fast: it turns from black at time 0 to `GREY` at the end."""
    html = folder / "stub.html"
    grey = f"document.documentElement.style.background = `rgb(${{[t, t, t].map(t => {GREY} * t / duration)}})`"
    script = f"const duration = {duration}, viewer = {{render() {{}}}}; let seek = t => {{ {grey}; }}; function setPlaying() {{}}"
    html.write_text(f"<script>{script}</script>", encoding="utf-8")
    return html


@pytest.fixture
def fake_screen(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """In the place of Chromium, for what is done before and after its pictures: from black at time 0 to `GREY` at the end."""
    from PIL import Image

    def fake(duration: float) -> None:
        def picture(time: float) -> bytes:
            out = io.BytesIO()
            Image.new("L", (64, 64), round(GREY * time / duration) if duration else 0).save(out, "PNG")
            return out.getvalue()

        monkeypatch.setattr("pinpress.visual.film.opened", lambda *_: contextlib.nullcontext(Screen(duration, picture, picture)))

    return fake


@pytest.fixture(scope="module")
def chromium_in_a_thread() -> Iterator[tuple[ThreadPoolExecutor, Any]]:
    """Started as the library starts it."""
    from playwright.sync_api import sync_playwright

    with ThreadPoolExecutor(1) as thread:
        playwright = thread.submit(lambda: sync_playwright().start()).result()
        options = {"executable_path": CHROMIUM, "args": list(filming.FLAGS), "chromium_sandbox": os.geteuid() != 0}
        chromium = thread.submit(lambda: playwright.chromium.launch(**options)).result()
        yield thread, chromium
        thread.submit(chromium.close).result()
        thread.submit(playwright.stop).result()


@pytest.fixture
def running(chromium_in_a_thread: tuple[ThreadPoolExecutor, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures and films by a Chromium that runs already, a tab each: to start one takes longer than such a test, and others do."""
    thread, chromium = chromium_in_a_thread
    playwright = SimpleNamespace(chromium=SimpleNamespace(launch=lambda **_: chromium))
    monkeypatch.setattr("playwright.sync_api.sync_playwright", lambda: contextlib.nullcontext(playwright))
    monkeypatch.setattr(filming, "ThreadPoolExecutor", lambda _: contextlib.nullcontext(thread))
    monkeypatch.setattr(filming, "_close", lambda chromium: [context.close() for context in chromium.contexts])


def values(png: bytes) -> Any:
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(float)


def difference(one: Any, other: Any) -> float:
    assert one.shape == other.shape
    return float(np.abs(one - other).mean())


def screenshots(chromium: Any, page: Path, size: tuple[int, int], times: Any, width: int = 960) -> list[Any]:
    """What a page opened from its file shows at times [s], without its controls, in a window `width` CSS pixels wide."""
    scale = size[0] / width
    window = {"width": width, "height": round(size[1] / scale)}
    context = chromium.new_context(viewport=window, device_scale_factor=scale, offline=True)
    tab = context.new_page()
    tab.goto(page.as_uri() + "#t=0")
    tab.evaluate("document.body.classList.add('still')")
    assert not any(tab.locator(control).is_visible() for control in ("#play", "#slider", "#rate", "#toolbar"))
    shots = []
    for at in times:
        tab.evaluate("t => { seek(t); }", at)
        while tab.evaluate("viewer.needs_render"):
            tab.wait_for_timeout(10)
        shots.append(values(tab.screenshot()))
    context.close()
    return shots


@pytest.fixture(scope="module")
def turn(browser: Any, page: Path) -> list[Any]:
    """The recording at `TIMES`, by screenshots."""
    return screenshots(browser, page, SIZE, TIMES)


@pytest.fixture(scope="module")
def filmed(page: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[float]]:
    """A film with a frame at each of `TIMES`, and the progress that was told."""
    told: list[float] = []
    return film(
        page, tmp_path_factory.mktemp("film") / "out.mp4", size=SIZE, frames_per_second=RATE, slowdown=1, repeats=2, progress=told.append
    ), told


@pytest.mark.exhaustive
@pytest.mark.usefixtures("running")
def test_picture_is_what_the_page_shows(page: Path, turn: list[Any], tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    assert image(page, str(out), time=TIMES[1], size=SIZE) == out
    distances = [difference(values(out.read_bytes()), shot) for shot in turn]
    assert distances[1] < 0.05
    assert min(distances[:1] + distances[2:]) > 1
    assert list(tmp_path.iterdir()) == [out]


@pytest.mark.usefixtures("running")
@pytest.mark.exhaustive
def test_larger_pictures_are_of_exact_size_and_show_the_same_more_sharply(page: Path, turn: list[Any], tmp_path: Path) -> None:
    from PIL import Image

    png = image(page, tmp_path / "out.png", time=TIMES[1], size=(481, 361))
    picture = values(png.read_bytes())
    assert picture.shape == (361, 481, 3)
    assert picture[-1].std(axis=0).max() < 60  # no bar of the browser's or the page's along the edges
    assert picture[:, -1].min() > 100
    shrunk = np.asarray(Image.open(png).convert("RGB").resize(SIZE, Image.Resampling.BOX)).astype(float)
    assert difference(turn[1], shrunk) < 3


def frames(path: Path) -> tuple[dict[str, Any], list[Any]]:
    """What ffmpeg says of a film, and its frames."""
    import imageio_ffmpeg

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # it leaves its pipes to Python to close
        about, *pictures = imageio_ffmpeg.read_frames(str(path))
    width, height = about["size"]
    return about, [np.frombuffer(picture, np.uint8).reshape(height, width, 3).astype(float) for picture in pictures]


@pytest.mark.exhaustive
def test_film_shows_the_recording_at_the_times_of_its_frames(filmed: tuple[Path, list[float]], turn: list[Any]) -> None:
    out, told = filmed
    about, shown = frames(out)
    assert about["size"] == SIZE
    assert about["fps"] == RATE
    assert about["codec"] == "h264"
    assert about["pix_fmt"].startswith("yuv420p(tv, bt709")
    assert len(shown) == round(2 * DURATION * RATE) == 5  # the sixth would be beyond the second turn
    for k, frame in enumerate(shown):
        distances = [difference(frame, shot) for shot in turn]
        assert distances[k] < SAME
        assert np.argmin(distances) == k
    assert told == [(k + 1) / 5 for k in range(5)]
    assert list(out.parent.iterdir()) == [out]


@pytest.mark.exhaustive
@pytest.mark.usefixtures("running")
def test_one_turn_is_slowed_down_for_the_eye(tmp_path: Path) -> None:
    _, shown = frames(film(stub(tmp_path, DURATION), tmp_path / "out.mp4", size=(64, 64), frames_per_second=2))
    assert len(shown) == round(5 * DURATION * 2) == 9
    for k, frame in enumerate(shown):  # at 0.5 s the film is at 0.1 s of the press
        assert frame.mean() == pytest.approx(GREY * k / 10 / DURATION, abs=2)


@pytest.mark.parametrize(("duration", "slowdown"), [(10, 1), (4, 1), (3.9, 2), (60 / 70, 5), (0.2, 20), (0.08, 50), (0.03, 200), (0, 1)])
def test_slow_enough(duration: float, slowdown: float) -> None:
    assert slow_enough(duration) == slowdown


@pytest.mark.usefixtures("running")
@pytest.mark.exhaustive
def test_gif(tmp_path: Path) -> None:
    from PIL import Image

    with Image.open(film(stub(tmp_path, DURATION), tmp_path / "out.GIF", size=(64, 64), frames_per_second=10, slowdown=1)) as gif:
        assert gif.format == "GIF"
        assert gif.n_frames == 9  # type: ignore[attr-defined]
        assert gif.info["loop"] == 0  # for ever
        for k in range(9):
            gif.seek(k)
            assert gif.info["duration"] == 100  # ms
            assert np.asarray(gif.convert("RGB")).mean() == pytest.approx(GREY * k / 10 / DURATION, abs=2)


def test_link_stays_a_link(fake_screen: Callable[[float], None], tmp_path: Path) -> None:
    fake_screen(1)
    page = tmp_path / "page.html"
    (tmp_path / "link.png").symlink_to(tmp_path / "real.png")
    image(page, tmp_path / "link.png", size=(64, 64))
    assert (tmp_path / "link.png").is_symlink()
    assert (tmp_path / "real.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.exhaustive
def test_where_an_event_loop_runs(tmp_path: Path) -> None:
    """As in a notebook."""
    page = stub(tmp_path, 1)

    async def cell() -> Path:
        return image(page, tmp_path / "out.png", size=(64, 64))

    with ThreadPoolExecutor(1) as thread:  # as the browser of the tests has a loop in this one
        assert thread.submit(asyncio.run, cell()).result().exists()


REFUSED: list[tuple[Callable[..., Any], dict[str, Any], str]] = [
    (image, {"time": -0.1}, "time is -0.1 s, but the recording lasts from 0 to 0.857142"),
    (image, {"time": 0.86}, "give one within it"),
    (image, {"time": float("nan")}, "time is nan: give one finite number"),
    (image, {"size": (0, 100)}, "two whole numbers from 64 to 4096"),
    (image, {"size": (640.0, 480.0)}, "size is (640.0, 480.0)"),
    (image, {"size": 640}, "size is 640: give width and height"),
    (image, {"size": (640, 480, 3)}, "give width and height"),
    (image, {"size": (5000, 100)}, "from 64 to 4096"),
    (film, {"size": (641, 480)}, "two even numbers"),
    (film, {"frames_per_second": 0}, "frames_per_second is 0: give a whole number from 1 to 120"),
    (film, {"frames_per_second": 29.97}, "frames_per_second is 29.97"),
    (film, {"repeats": 0}, "repeats is 0"),
    (film, {"slowdown": 0.0}, "slowdown is 0; give a positive number"),
    (film, {"slowdown": float("inf")}, "slowdown is inf: give one finite number"),
    (film, {"slowdown": 1e9}, "the film would have 2.57e+10 frames; choose"),
    (film, {"slowdown": 1e-9}, "frames; choose"),
    (image, {"path": "out.jpg"}, "cannot write out.jpg: the name of the file must end in .png"),
    (film, {"path": "out.avi"}, "the name of the file must end in .mp4 or .gif"),
    (film, {"path": "mp4"}, "the name of the file must end in .mp4"),
]


@pytest.mark.parametrize(("make", "arguments", "says"), REFUSED)
def test_numbers_and_names_that_make_no_sense(
    make: Callable[..., None], arguments: dict[str, Any], says: str, fake_screen: Callable[[float], None], tmp_path: Path
) -> None:
    fake_screen(DURATION)
    path = tmp_path / ("out.png" if make is image else "out.mp4")
    with pytest.raises(pp.PinpressError, match=re.escape(says)):
        make(**{"page": tmp_path / "page.html", "path": path, "size": (64, 64), **arguments})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("make", "name"), [(image, "missing/out.png"), (film, "missing/out.mp4")])
def test_path_that_cannot_be_written_is_found_first(make: Any, name: str, page: Path, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr("pinpress.visual.film.opened", lambda *_: pytest.fail("a browser was opened"))
    with pytest.raises(pp.PinpressError, match=r"(?s)cannot write .*; give a file in a directory you can write to"):
        make(page, tmp_path / name)


@pytest.mark.usefixtures("running")
@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "out.html: No such file or directory; give a page that pinpress.record or report wrote"),
        (b"\xff\xfe\x00", "out.html: 'utf-8' codec can't decode"),
        (b"<p>hello", "out.html is no recording; give a page that pinpress.record or report wrote"),
        (b"<script>const duration = 1, seek = null;</script>", "out.html is no recording"),
    ],
)
def test_no_recording(content: bytes | None, says: str, tmp_path: Path) -> None:
    html = tmp_path / "out.html"
    if content is not None:
        html.write_bytes(content)
    with pytest.raises(pp.PinpressError, match=re.escape(says)):
        image(html, tmp_path / "out.png")
    assert {p.name for p in tmp_path.iterdir()} <= {"out.html"}


@pytest.mark.one_in(3)
@pytest.mark.usefixtures("running")
@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ("<script>throw new Error('worn out')</script>", "fails in Chromium: worn out; record it again"),
        ("<img src='https://example.org/x.png'>", "fails in Chromium: .*ERR_INTERNET_DISCONNECTED"),  # as the console says
        ("<script>seek = () => { throw new Error('stuck') }</script>", "fails in Chromium: .*stuck"),
    ],
)
def test_what_goes_wrong_in_the_page_is_said(wrong: str, says: str, tmp_path: Path) -> None:
    html, out = stub(tmp_path, 1), tmp_path / "out.png"
    html.write_text(html.read_text("utf-8") + wrong, encoding="utf-8")
    with pytest.raises(pp.PinpressError, match=says):
        image(html, out, time=0.6, size=(64, 64))
    assert not out.exists()


def with_script(page: Path, path: Path, script: str) -> None:
    """The page with a script of ours in front, which its security policy would not run."""
    text = re.sub("<meta http-equiv[^>]*>", "", page.read_text("utf-8"))
    path.write_text(text.replace("<body>", f"<body><script>{script}</script>"), encoding="utf-8")


@pytest.mark.exhaustive
@pytest.mark.usefixtures("running")
def test_without_webgl(page: Path, tmp_path: Path) -> None:
    html, out = tmp_path / "out.html", tmp_path / "out.png"
    with_script(page, html, NO_WEBGL)
    with pytest.raises(pp.PinpressError, match="fails in Chromium, where WebGL is switched off"):
        image(html, out, time=0.6, size=(64, 64))
    assert not out.exists()


@pytest.mark.usefixtures("running")
@pytest.mark.exhaustive
def test_lost_graphics_are_no_blank_picture(page: Path, tmp_path: Path) -> None:
    html, out = tmp_path / "out.html", tmp_path / "out.png"
    lose = "viewer.renderer.getContext().getExtension('WEBGL_lose_context').loseContext()"
    with_script(page, html, f"unpacked.then(() => {{ const old = seek; seek = time => {{ if (time > 0.5) {lose}; old(time); }} }})")
    with pytest.raises(pp.PinpressError, match="lost its WebGL context"):
        image(html, out, time=0.6, size=(64, 64))


def test_a_recording_of_one_instant(fake_screen: Callable[[float], None], tmp_path: Path) -> None:
    fake_screen(0)
    html = tmp_path / "page.html"
    assert image(html, tmp_path / "out.png", size=(64, 64)).exists()
    with pytest.raises(pp.PinpressError, match="nothing to film"):
        film(html, tmp_path / "out.mp4")


@pytest.mark.exhaustive
def test_without_chromium(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CHROMIUM", str(tmp_path / "chrome"))
    with pytest.raises(pp.PinpressError, match=r"CHROMIUM is .*chrome, which is no program"):
        image(page, tmp_path / "out.png")
    monkeypatch.setenv("CHROMIUM", shutil.which("false") or "false")
    with pytest.raises(pp.PinpressError, match=r"false does not start: .*; set CHROMIUM to"):
        image(page, tmp_path / "out.png")
    monkeypatch.delenv("CHROMIUM")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(pp.PinpressError, match=r"none is on the PATH; .*apt-get install chromium"):
        image(page, tmp_path / "out.png")
    program = tmp_path / "google-chrome"
    program.symlink_to(shutil.which(CHROMIUM or "", path=os.defpath) or CHROMIUM or "")
    assert filming._program() == str(program)


@pytest.mark.parametrize("package", ["playwright", "imageio_ffmpeg"])
def test_without_packages(package: str, page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == package else found(name))
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(pp.PinpressError, match=re.escape("pip install 'pinpress[video]'")):
        film(page, tmp_path / "out.mp4")
    assert list(tmp_path.iterdir()) == []


def test_film_that_ffmpeg_gives_up(fake_screen: Callable[[float], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_screen(1)
    monkeypatch.setitem(importlib.import_module("pinpress.visual.film").ENCODING, ".mp4", ("-c:v", "no_such_codec"))
    with pytest.raises(pp.PinpressError, match=r"ffmpeg cannot make the film: .*no_such_codec"):
        film(tmp_path / "page.html", tmp_path / "out.mp4", size=(64, 64), frames_per_second=1)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def short_path() -> Iterator[Path]:
    """A folder whose name leaves room for those of Chromium's sockets, 108 characters at the most."""
    with tempfile.TemporaryDirectory(prefix="p") as folder:
        yield Path(folder)


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="needs /proc, to find what is left")
@pytest.mark.parametrize("when", ["opening", "filming"])
@pytest.mark.exhaustive
def test_interrupted(when: str, tmp_path: Path, short_path: Path) -> None:
    """Ctrl-C, which a terminal sends to all processes at once."""
    code = f"""if True:
        import sys, pinpress.visual.film
        if {when!r} == 'opening':
            load = pinpress.visual.film._Tab.load
            pinpress.visual.film._Tab.load = lambda *given: (print('now', flush=True), load(*given))
        pinpress.visual.film.film(sys.argv[1], 'out.mp4', size=(64, 64), progress=lambda done: print('now', flush=True))"""
    mark = uuid.uuid4().hex
    folder = tmp_path / "folder"
    folder.mkdir()
    shown = stub(tmp_path, 100)  # 3000 frames
    if when == "opening":  # takes long
        slow = "<script>requestAnimationFrame = done => setTimeout(done, 1000)</script>"
        shown.write_text(shown.read_text("utf-8") + slow, encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(shown)],
        cwd=folder,
        env=os.environ | {"PINPRESS_TEST": mark, "TMPDIR": str(short_path), "PYTHONPATH": str(Path(pp.__file__).parent.parent)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "now\n"
    assert len(list(marked(mark))) > 2  # Python, Playwright's driver, Chromium
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == -signal.SIGINT
    assert said.rstrip().endswith("KeyboardInterrupt")
    assert list(folder.iterdir()) == []
    for _ in range(200):
        if not (left := list(marked(mark))):
            break
        time.sleep(0.1)
    assert left == []
    assert list(short_path.iterdir()) == []


def marked(mark: str) -> Iterator[str]:
    """The living processes that have inherited a mark."""
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if mark.encode() in (folder / "environ").read_bytes():
                yield (folder / "cmdline").read_text().replace("\0", " ")[:200]
        except OSError:
            continue


# ---- the command ----


def command(*words: object) -> int:
    return main(["record", *map(str, words)])


def test_command(
    press: Any,
    fake_screen: Callable[[float], None],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What is asked for; that pictures and films are what is asked for, is tested above."""
    asked_of: dict[str, list[Any]] = {}

    def watched(make: Callable[..., Path]) -> Callable[..., Path]:
        def made(page: Path, *more: Any, **options: Any) -> Path:
            asked_of[make.__name__] = [page.read_bytes(), *more, options]
            return make(page, *more, **options)

        return made

    fake_screen(DURATION)
    for make in (image, film):
        monkeypatch.setattr(f"pinpress.visual.film.{make.__name__}", watched(make))
    names = html, png, mp4 = [tmp_path / name for name in ("out.html", "out.png", "out.mp4")]
    asked = ["--out", html, "--png", png, "--video", mp4, "--at", "90deg", "--size", "160x120", "--fps", 1]
    said = ["--speed", "-70r/min", "--set", "points=360", "--set", "traces={rod: 0 0 -100 mm}"]
    assert command("crank_slide", *said, "--slowdown", 2, "--repeats", 2, *asked) == 0
    assert capsys.readouterr() == (f"wrote {html}, {png}, {mp4}\n", "")
    motion = pp.cycle(press, -SPEED, points=360)
    same = pp.record(press, motion, tmp_path / "same.html", reactions=pp.inverse_dynamics(press, motion), traces=[("rod", (0, 0, -0.1))])
    assert html.read_bytes() == same.read_bytes()
    at = pytest.approx(0.75 * DURATION)  # backwards, 90 deg comes late
    assert asked_of["image"] == [same.read_bytes(), png, {"time": at, "size": (160, 120)}]
    assert callable(asked_of["film"][-1].pop("progress"))
    how = {"frames_per_second": 1, "slowdown": 2.0, "repeats": 2, "size": (160, 120)}
    assert asked_of["film"] == [same.read_bytes(), mp4, how]
    assert png.read_bytes().startswith(b"\x89PNG")
    about, shown = frames(mp4)
    assert (about["fps"], len(shown)) == (1, round(4 * DURATION))
    assert {p.name for p in tmp_path.iterdir()} == {"same.html", *(p.name for p in names)}


def test_command_without_forces_and_with_a_picture_alone(tmp_path: Path, press: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr("pinpress.visual.film.image", lambda page, *more, **size: asked.extend((page.read_bytes(), *more, size)))
    out = tmp_path / "out.png"
    asked_for = ["--png", out, "--no-forces", "--at", "-270deg", "--size", "64x64"]
    assert command("crank_slide", "--speed", "70r/min", "--set", "points=90", *asked_for) == 0
    page = pp.record(press, pp.cycle(press, SPEED, points=90), tmp_path / "same.html")
    assert asked == [page.read_bytes(), out, {"time": pytest.approx(DURATION / 4), "size": (64, 64)}]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "nothing to write: give --out page.html, --video film.mp4 or --png picture.png"),
        (["--out", "out.html", "--set", "traces={rodd: 0 0 0}"], "did you mean 'rod'?"),
        (["--video", "out.avi"], "must end in .mp4 or .gif"),
        (["--out", "out.html", "--size", "640"], "'640' is not a size"),
        (["--out", "out.html", "--size", "axb"], "not a size"),
        (["--out", "out.html", "--set", "traces={rod: 1 2 m}"], "give x, y, z in the link's frame"),
    ],
)
def test_command_refuses(words: list[str], says: str, tmp_path: Path, monkeypatch: Any, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert says in refused(capsys, "record", "crank_slide", "--speed", "70r/min", *words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.exhaustive
def test_command_shows_progress(fake_screen: Callable[[float], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[float] = []
    fake_screen(DURATION)
    monkeypatch.setattr("pinpress.cli.record.progress", lambda total: contextlib.nullcontext(told.append))
    assert command("crank_slide", "--speed", "70r/min", "--video", tmp_path / "out.mp4", "--size", "64x64", "--fps", 1) == 0
    assert told == [0.25, 0.5, 0.75, 1.0]
