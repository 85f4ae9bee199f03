"""docs/gallery.md, and a film of each of its presses into docs/gallery: a stroke under load, over and over; in Chromium some 20 s each.

Films are animated WebP, which browsers, GitHub and the site show as they show pictures. They need pip install 'pinpress[video]'.
"""

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from make import DOCS, ROOT, write

import pinpress as pp
from pinpress.pin_table.templates import template

DURATION, RATE = 4.0, 12  # of a film [s], and its pictures a second
LIGHT = 300_000  # most bytes of a film


class Shown(NamedTuple):
    """A press of the gallery.

    Attributes:
        table: name of the template, or of the shipped press.
        title: what kind of press it is.
        words: a sentence about it.
        acting: speed, force, and height above bottom dead centre at which the force begins; empty: as in the template.
    """

    table: str
    title: str
    words: str
    acting: tuple[str, str, str] | tuple[()] = ()

    @property
    def shipped(self) -> bool:
        return self.table in pp.presses()

    @property
    def file(self) -> str:
        """The press for the commands, which run one after the other in one folder: its name, or a file of the template."""
        return self.table if self.shipped else f"{self.table}.yaml"


PRESSES = (
    Shown("crank-slide", "Crank press", "A crank, a rod and a slide: every other press is compared with it."),
    Shown(
        "eccentric-block", "Eccentric press without a rod", "A block on the eccentric slides across the slide. A geared shaft balances it."
    ),
    Shown("knuckle", "Knuckle-joint press", "A crank straightens a knee above the slide. It makes great forces, as for coining."),
    Shown("toggle", "Hydraulic toggle press", "A cylinder pushes the knee. The driver slides between its ends of travel."),
    Shown("link-drive", "Link-drive press", "A plate between crank, rocker and rod slows the slide where it works."),
    Shown(
        "zxn2_3000b",
        "Six-bar press",
        "The ZXN2-3000(B), 3000 kN (Kong 2025): it goes down slowly and returns quickly.",
        ("70r/min", "2000kN", "20mm"),
    ),
    Shown("drawing-8-bar", "Eight-bar drawing press", "Its speed is nearly constant over the whole draw."),
    Shown("guide-bar", "Guide-bar press", "A block swings a bar, for quick return and an even speed over the draw."),
    Shown(
        "hypocycloid",
        "Hypocycloid press",
        "A planet rolls in a ring with twice its teeth: its pin goes straight, and the guide carries nothing.",
    ),
    Shown(
        "jf75g_125_symmetric",
        "Symmetric high-speed press",
        "Two mirrored halves on geared shafts leave no lateral shaking force and no tilting moment.",
        ("300r/min", "1250kN", "2mm"),
    ),
    Shown(
        "aida_balance_slide",
        "High-speed press with a balance slide",
        "A lever moves the slide, and a rocker a balance slide against it. The lever's fulcrum sets the stroke.",
        ("300r/min", "1250kN", "2mm"),
    ),
    Shown(
        "pirica_double_knuckle",
        "Double-knuckle high-speed press",
        "A crank straightens two knees by L-shaped arms, whose weights balance the slide at every stroke.",
        ("300r/min", "450kN", "2mm"),
    ),
    Shown("rssp", "Spatial press", "The crank turns about an axis across the press. Its rod has a ball at either end."),
)

HEAD = """\
# Gallery

Thirteen kinds of presses in a stroke under load, each made from a [job](jobs.md) of a few lines: a [table of pins](pin_table.md), a speed
and a load. Arrows are the forces of bearings and process, and the force on the floor. `python docs/make.py gallery_films` makes all films.
"""


def page() -> str:
    """The page, in Markdown."""
    return HEAD + "".join(_entry(shown) for shown in PRESSES)


def _entry(shown: Shown) -> str:
    lines = sum(bool(line.partition("#")[0].strip()) for line in _table(shown).decode().splitlines())
    commands = [] if shown.shipped else [f"pinpress new {shown.file} --template {shown.table}"]
    commands.append(" ".join(["pinpress record", shown.file, *_options(shown), f"--out {shown.table}.html"]))
    base = " more than the press that it is based on" if b"\nbase:" in b"\n" + _table(shown) else ""
    return (
        f"\n## {shown.title}\n\n![{shown.title}, one stroke under load](gallery/{shown.table}.webp)\n\n"
        f"{shown.words} {lines} lines{base}.\n\n```\n" + "\n".join(commands) + "\n```\n"
    )


def _options(shown: Shown) -> Sequence[str]:
    """What acts on a shipped press; a template says it itself."""
    if not shown.acting:
        return ()
    speed, force, start = shown.acting
    return f"--speed {speed}", f"--load drawing:force={force},start={start}"


def _table(shown: Shown) -> bytes:
    return (ROOT / "urdf" / f"{shown.table}.yaml").read_bytes() if shown.shipped else template(shown.table)


def film(shown: Shown, folder: Path) -> bytes:
    """Make the film of a press; ``folder``: for what is not kept."""
    table = folder / f"{shown.table}.yaml"
    table.write_bytes(_table(shown))
    loads = {"draw": dict(zip(("kind", "force", "start"), ("drawing", *shown.acting[1:]), strict=True))} if shown.acting else {}
    job = pp.job(shown.table if shown.shipped else table, **({"speed": shown.acting[0], "loads": loads} if shown.acting else {}))
    motion = job.motion()
    recording = pp.record(job.press, motion, folder / "press.html", reactions=job.reactions())
    period = float(motion.time[-1]) * len(motion.time) / (len(motion.time) - 1)
    played = folder / "press.mp4"
    pp.video.film(recording, played, size=(480, 400), frames_per_second=RATE, slowdown=DURATION / period)
    return _webp(played)


def _webp(played: Path) -> bytes:
    """The film as animated WebP that begins anew at its end, by the same ffmpeg that made it."""
    import imageio_ffmpeg

    path = played.with_suffix(".webp")
    options = ["-c:v", "libwebp_anim", "-quality", "45", "-compression_level", "6", "-loop", "0", "-an", "-bitexact"]
    program = imageio_ffmpeg.get_ffmpeg_exe()
    subprocess.run([program, "-y", "-loglevel", "error", "-i", str(played), *options, str(path)], check=True)
    if path.stat().st_size > LIGHT:
        sys.exit(f"the film has {path.stat().st_size} bytes, more than {LIGHT}: take fewer pictures a second")
    return path.read_bytes()


def main(quick: bool = False, parts: Sequence[str] = ()) -> None:
    """Write the page and the films, or some by the names of their presses; ``quick``, or the part "page": the page alone."""
    write(DOCS / "gallery.md", page())
    with tempfile.TemporaryDirectory() as folder:
        for shown in () if quick else PRESSES:
            if not parts or shown.table in parts:
                write(DOCS / "gallery" / f"{shown.table}.webp", film(shown, Path(folder)))
