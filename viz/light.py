"""Makes PNG files light enough for pages, at most 150 kB: by a palette of as many colours as that allows, and where 64 are too many by
fewer pixels. The scripts that make pictures import it; ``python viz/light.py FILE ...`` does it by hand.
"""

import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.spatial import KDTree

LIGHT = 150_000  # most bytes
COLOURS = (256, 128, 64)
CODE = np.array([65_536, 256, 1])  # of red, green and blue: a colour as one number


def light(path: Path) -> Path:
    """Write a PNG file anew with a palette, and return its path; one that is light stays as it is."""
    if path.stat().st_size <= LIGHT:
        return path
    picture = Image.open(path).convert("RGB")
    while True:
        for colours in COLOURS:
            content = io.BytesIO()
            _with_palette(picture, colours).save(content, format="PNG", optimize=True)
            if content.tell() <= LIGHT:
                path.write_bytes(content.getvalue())
                return path
        picture = picture.resize((picture.width * 4 // 5, picture.height * 4 // 5), Image.Resampling.LANCZOS)


def _with_palette(picture: Image.Image, colours: int) -> Image.Image:
    """The picture in some colours: half of them by how often they are, which keeps gradients even, half by how far apart, which keeps
    rare colours, as of arrows."""
    halves = (picture.quantize(colours // 2, method=method) for method in (Image.Quantize.MEDIANCUT, Image.Quantize.MAXCOVERAGE))
    palette = np.array([half.getpalette() for half in halves], dtype=float).reshape(-1, 3)
    codes, place = np.unique(np.asarray(picture).reshape(-1, 3) @ CODE, return_inverse=True)  # sorted much faster than rows
    found = codes[:, None] // CODE % 256
    nearest = KDTree(palette).query(found)[1].astype(np.uint8)  # Pillow's own search is coarse: it makes white grey
    made = Image.fromarray(nearest[place].reshape(picture.height, picture.width)).convert("P")
    made.putpalette(palette.astype(np.uint8).tobytes())
    return made


if __name__ == "__main__":
    for name in sys.argv[1:]:
        print(name, light(Path(name)).stat().st_size)
