"""A press whose names would be markup and scripts, were they not text."""

from pathlib import Path
from typing import Any

import pinpress as pp

NAMES = {
    "crank_slide": "<script>alert(1)</script>{{viewer}}",
    "rod": "r/od </script><script>alert(2)</script>",
    "P": "<img src=x onerror=alert(3)>",
    "W": "<b>$_{x}$</b> & _W",
}


def load_hostile(folder: Path) -> Any:
    """The crank-slider with these names."""
    text = pp.load("crank_slide").text.decode()
    for name, hostile in NAMES.items():
        escaped = hostile.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
        assert f'"{name}"' in text
        text = text.replace(f'"{name}"', f'"{escaped}"')
    file = folder / "hostile.urdf"
    file.write_text(text, encoding="utf-8")
    return pp.load(file)
