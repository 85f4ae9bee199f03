"""The scripts that write pictures, tables and pages of the documentation, by their names, and what they share.

python docs/make.py                       # lists them
python docs/make.py pictures slide polar  # one, or parts of it
python docs/make.py servo --quick         # in seconds, into out/quick (--to FOLDER: another folder)

A script is a module of docs, viz or tests with a docstring, whose first sentence is listed, and a function `main(quick)`, or `main(quick,
parts)` if one can ask for a part of what it makes.
"""

import argparse
import ast
import contextlib
import importlib.util
import io
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
DOCS, VIZ = ROOT / "docs", ROOT / "viz"
sys.path[:0] = [str(path) for path in (ROOT, ROOT / "tests", DOCS) if str(path) not in sys.path]

import pinpress as pp  # noqa: E402

OUT: list[Path] = []  # the folder into which files go in place of their own
LIGHT = 150_000  # most bytes of a PNG file
FLAGS = ("--use-gl=angle", "--use-angle=swiftshader-webgl", "--enable-unsafe-swiftshader", "--no-sandbox", "--hide-scrollbars")


@cache
def scripts() -> dict[str, tuple[Path, str]]:
    """Names of the scripts: their files, and the first sentences of their docstrings."""
    patterns = ("docs/*.py", "viz/*.py", "tests/mistakes/*.py", "tests/extremes/extreme_cases.py", "tests/benchmarks/history/table.py")
    listed = {}
    for path in (path for pattern in patterns for path in sorted(ROOT.glob(pattern)) if path != Path(__file__).resolve()):
        code = ast.parse(path.read_text(encoding="utf-8"))
        if any(isinstance(node, ast.FunctionDef) and node.name == "main" for node in code.body):
            listed[path.stem] = path, (ast.get_docstring(code) or "").split("\n\n")[0].replace("\n", " ")
    return listed


def load(name: str) -> ModuleType:
    """A script as a module."""
    spec = importlib.util.spec_from_file_location(f"script_{name}", scripts()[name][0])
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def write(path: Path, content: "Figure | str | bytes") -> Path:
    """Write a picture or a page, in whatever form it is, and print its size."""
    path = OUT[0] / path.name if OUT else path
    path.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(content, str | bytes):
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    else:
        pp.plots.save(content, path)
    if path.suffix == ".png":
        lighten(path)
    print(path, path.stat().st_size)
    return path


def lighten(path: Path) -> None:
    """Write a PNG file that is too heavy again with a palette of as many colours as `LIGHT` allows, and if 64 are too many, with fewer
    pixels."""
    if path.stat().st_size <= LIGHT:
        return
    from PIL import Image  # with Matplotlib, and slow to import

    picture = Image.open(path).convert("RGB")
    while True:
        for colours in (256, 128, 64):
            content = io.BytesIO()
            _with_palette(picture, colours).save(content, format="PNG", optimize=True)
            if content.tell() <= LIGHT:
                path.write_bytes(content.getvalue())
                return
        picture = picture.resize((picture.width * 4 // 5, picture.height * 4 // 5), Image.Resampling.LANCZOS)


def _with_palette(picture: "Image.Image", colours: int) -> "Image.Image":
    """The picture in some colours: half of them by how often they are, which keeps gradients even, half by how far apart, which keeps
    rare colours, as of arrows."""
    import numpy as np
    from PIL import Image
    from scipy.spatial import KDTree

    code = np.array([65_536, 256, 1])  # of red, green and blue: a colour as one number
    halves = (picture.quantize(colours // 2, method=method) for method in (Image.Quantize.MEDIANCUT, Image.Quantize.MAXCOVERAGE))
    palette = np.array([half.getpalette() for half in halves], dtype=float).reshape(-1, 3)
    codes, place = np.unique(np.asarray(picture).reshape(-1, 3) @ code, return_inverse=True)  # sorted much faster than rows
    nearest = KDTree(palette).query(codes[:, None] // code % 256)[1].astype(np.uint8)  # Pillow's own search is coarse: it makes white grey
    made = Image.fromarray(nearest[place].reshape(picture.height, picture.width)).convert("P")
    made.putpalette(palette.astype(np.uint8).tobytes())
    return made


@contextlib.contextmanager
def chromium() -> Iterator[Any]:
    """The browser, which draws by the processor."""
    from playwright.sync_api import sync_playwright  # optional, and slow to import

    with sync_playwright() as playwright:
        program = os.environ.get("CHROMIUM") or shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        yield browser
        browser.close()


def shot(url: str, drawn: str, action: str, size: tuple[int, int] = (1280, 800)) -> bytes:
    """A page in Chromium, as a PNG file: what it shows once there is an element like ``drawn`` and ``action`` has been done."""
    with chromium() as browser:
        page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        page.goto(url)
        page.wait_for_selector(drawn)
        page.wait_for_timeout(2000)
        page.evaluate(action)
        page.wait_for_timeout(2000)
        return bytes(page.screenshot())


@cache
def names_of(page: str) -> dict[str, Any]:
    """The names that the code of a page defines; it runs in a folder of its own, as it writes files."""
    from support import page_blocks

    names: dict[str, Any] = {}
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "docs").symlink_to(DOCS)
        os.chdir(folder)
        sys.path.insert(0, folder)  # modules that a page writes
        try:
            for _ in page_blocks.run((DOCS / f"{page}.md").read_text(encoding="utf-8"), names):
                pass
        finally:
            os.chdir(before)
            sys.path.remove(folder)
    return names


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="make.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", nargs="?")
    parser.add_argument("parts", nargs="*")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--to", type=Path)
    options = parser.parse_args()
    known = scripts()
    if options.name is None:
        print("\n".join(f"{name:18}{words}" for name, (_, words) in known.items()))
        return
    if options.name not in known:
        parser.error(f"there is no script {options.name}: the names are {', '.join(known)}")
    if options.to or options.quick:
        sys.modules["make"].OUT.append(options.to or ROOT / "out" / "quick")
    load(options.name).main(options.quick, *([options.parts] if options.parts else []))


if __name__ == "__main__":
    sys.modules["make"] = sys.modules["__main__"]  # which the scripts import
    main()
