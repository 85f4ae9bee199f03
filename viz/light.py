"""Makes PNG files light enough for pages, at most 150 kB: by a palette of as many colours as that allows, and where 64 are too many by
fewer pixels. The scripts that make pictures import it; ``python viz/light.py FILE ...`` does it by hand.
"""

import io
import sys
from pathlib import Path

from PIL import Image

LIGHT = 150_000  # most bytes
COLOURS = (256, 128, 64)


def light(path: Path) -> Path:
    """Write a PNG file anew with a palette, and return its path; one that is light stays as it is."""
    if path.stat().st_size <= LIGHT:
        return path
    picture = Image.open(path).convert("RGB")
    while True:
        for colours in COLOURS:
            content = io.BytesIO()
            picture.quantize(colours, dither=Image.Dither.NONE).save(content, format="PNG", optimize=True)
            if content.tell() <= LIGHT:
                path.write_bytes(content.getvalue())
                return path
        picture = picture.resize((picture.width * 4 // 5, picture.height * 4 // 5), Image.Resampling.LANCZOS)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        print(name, light(Path(name)).stat().st_size)
