"""What tests ask of a page that is open in a browser (see conftest)."""

import base64
import io
import json
import re
import time
import zlib
from pathlib import Path
from typing import Any

import numpy as np

DRAWN = ["--use-gl=angle", "--use-angle=swiftshader-webgl", "--enable-unsafe-swiftshader"]  # by the processor
FLAGS = [*DRAWN, "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"]

# in front of a page: a browser without WebGL, as on remote desktops
NO_WEBGL = """const drawn = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith("webgl") ? null : drawn.call(this, kind, ...more);
}"""


def data_in(path: Path) -> dict[str, Any]:
    """What a page was given to show."""
    match = re.search(r'<script class="packed" type="application/json" id="data">(.*?)</script>', path.read_text("utf-8"))
    assert match is not None
    return dict(json.loads(zlib.decompress(base64.b85decode(match[1]))))


def floats(packed: str, columns: int = 1) -> Any:
    """Numbers (n,) or vectors (n, columns) as a page is given them."""
    numbers = np.frombuffer(base64.b64decode(packed), "<f4").astype(float)
    return numbers if columns == 1 else numbers.reshape(-1, columns)


def sections(path: Path) -> dict[str, Any]:
    """The sections of a report by their titles."""
    return {section["title"]: section for section in data_in(path)["report"]["sections"]}


def chart(section: Any, title: str) -> Any:
    """The chart or table of a section whose title begins so."""
    (block,) = [block for block in section["blocks"] if block.get("title", "?").startswith(title)]
    return block


def curves(chart: Any) -> dict[str, tuple[Any, Any]]:
    """Places and values of the curves of a chart by their names; places are None if they are those of the key frames."""
    return {curve["name"]: (curve["x"] and floats(curve["x"]), floats(curve["y"])) for curve in chart["curves"]}


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
    *camera, (left, top, width, height) = page.evaluate(
        """(({ camera }, area) => [
            camera.matrixWorldInverse.elements, camera.projectionMatrix.elements, [area.left, area.top, area.width, area.height],
        ])(viewer, viewer.renderer.domElement.getBoundingClientRect())"""
    )
    view, projection = (np.array(elements).reshape(4, 4).T for elements in camera)
    x, y, z = np.asarray(points).T
    clip = projection @ view @ np.array([x, z, -y, np.ones_like(x)])  # three.js has y up
    return np.column_stack([left + (clip[0] / clip[3] + 1) / 2 * width, top + (1 - clip[1] / clip[3]) / 2 * height])


def visible(picture: Any, pixel: Any, colour: str) -> bool:
    """Whether a colour, lit or in shade, is within 3 pixels of a place."""
    column, row = np.rint(pixel).astype(int)
    patch = picture[max(row - 3, 0) : row + 4, max(column - 3, 0) : column + 4].reshape(-1, 3)
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], dtype=float)
    likeness = patch @ wanted / (np.linalg.norm(patch, axis=1) * np.linalg.norm(wanted) + 1e-9)
    return bool(np.any(likeness > 0.98))
