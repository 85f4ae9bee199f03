"""Linkages of any size for tests and benchmarks; see `n_four_bar` for chains of dyads."""

import tempfile
import warnings
from pathlib import Path

import pinpress as pp


def load(text: str, **more: object) -> pp.Linkage:
    """The linkage of a URDF's text, however long it is."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "linkage.urdf"
        file.write_text(text, encoding="utf-8")
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", ".* the linkage is .* m long", pp.PinpressWarning)
            return pp.load(file, **more)


def gear_train(count: int) -> str:
    """``count`` shafts in a row behind the driven one, each turned backwards by the one before; all with 1 kg, 0.1 m from the shaft, and
    0.1 kg m2 about its centre."""
    body = '<inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>'
    parts = ['<robot name="gear_train">', '<link name="frame"/>']
    for k in range(count + 1):
        mimic = f'<mimic joint="shaft_{k - 1}" multiplier="-1"/>' if k else ""
        ends = f'<parent link="frame"/><child link="wheel_{k}"/><origin xyz="{k} 0 0"/><axis xyz="0 -1 0"/>{mimic}'
        parts.append(f'<link name="wheel_{k}">{body}</link><joint name="shaft_{k}" type="continuous">{ends}</joint>')
    return "\n".join([*parts, '<transmission name="drive"><joint name="shaft_0"/></transmission>', "</robot>"])
