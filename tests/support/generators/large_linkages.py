"""Linkages of any size for tests and benchmarks; see `n_four_bar` for chains of dyads."""

import math
import tempfile
import warnings
from pathlib import Path

import pinpress as pp

from ..oracles import n_four_bar

TILT = 0.1  # of the pivots of `spatial_chain`, this way and that [rad]
ROW_STEP = 0.2  # distance of the joints on a link of `open_row` [m]


def load(text: str, **more: object) -> pp.Linkage:
    """The linkage of a URDF's text, however long it is."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "linkage.urdf"
        file.write_text(text, encoding="utf-8")
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", ".* the linkage is .* m long", pp.PinpressWarning)
            return pp.load(file, **more)


BODY = '<inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>'


def gear_train(count: int) -> str:
    """``count`` shafts in a row behind the driven one, each turned backwards by the one before; all with 1 kg, 0.1 m from the shaft, and
    0.1 kg m2 about its centre."""
    parts = ['<robot name="gear_train">', '<link name="frame"/>']
    for k in range(count + 1):
        mimic = f'<mimic joint="shaft_{k - 1}" multiplier="-1"/>' if k else ""
        ends = f'<parent link="frame"/><child link="wheel_{k}"/><origin xyz="{k} 0 0"/><axis xyz="0 -1 0"/>{mimic}'
        parts.append(f'<link name="wheel_{k}">{BODY}</link><joint name="shaft_{k}" type="continuous">{ends}</joint>')
    return "\n".join([*parts, '<transmission name="drive"><joint name="shaft_0"/></transmission>', "</robot>"])


def open_row(count: int, ratio: float = -1.0) -> str:
    """``count`` links that hang on each other in a row without loops, the joint of each geared to the one before by this ``ratio``; bodies
    as in `gear_train`."""
    parts = ['<robot name="open_row">', '<link name="frame"/>']
    for k in range(count):
        parent, mimic = (f"link_{k - 1}", f'<mimic joint="joint_{k - 1}" multiplier="{ratio}"/>') if k else ("frame", "")
        place = f'<origin xyz="{ROW_STEP if k else 0.0} 0 0"/><axis xyz="0 -1 0"/>{mimic}'
        parts.append(f'<link name="link_{k}">{BODY}</link>')
        parts.append(f'<joint name="joint_{k}" type="continuous"><parent link="{parent}"/><child link="link_{k}"/>{place}</joint>')
    return "\n".join([*parts, '<transmission name="drive"><joint name="joint_0"/></transmission>', "</robot>"])


def spatial_chain(count: int) -> str:
    """``count`` four-bars in space in a row: upright rods 1 m apart, each on a pivot that is tilted against its neighbours', whose tips are
    joined by bars on a universal joint (two pins) and a ball joint. Joints A0, A1, ... on the frame, B0, C0, ... at the tips."""
    small, upright = n_four_bar.ROD.format(centre="0 0 0", x=0.002, y=0.002, z=0.002), _rod("0 0 0.5", "xy")
    parts = ['<robot name="spatial_chain">', '<link name="frame"/>']
    for k in range(count + 1):
        parts.append(f'<link name="rod_{k}">{upright}</link>')
        parts.append(_joint(f"A{k}", "frame", f"rod_{k}", f"{k} 0 0", f"{(-1) ** k * math.sin(TILT)!r} {math.cos(TILT)!r} 0"))
    for k in range(count):
        parts.append(f'<link name="cross_{k}">{small}</link><link name="bar_{k}">{_rod("0.5 0 0", "yz")}</link>')
        parts.append(_joint(f"B{k}", f"rod_{k}", f"cross_{k}", "0 0 1", "0 1 0"))
        parts.append(_joint(f"C{k}", f"cross_{k}", f"bar_{k}", "0 0 0", "0 0 1"))
        ends = f'<link1 link="bar_{k}" xyz="1 0 0"/><link2 link="rod_{k + 1}" xyz="0 0 1"/>'
        parts.append(f'<loop_joint name="D{k}" type="spherical">{ends}</loop_joint>')
    return "\n".join([*parts, '<transmission name="drive"><joint name="A0"/></transmission>', "</robot>"])


def hinged(text: str, every: int = 1) -> str:
    """A planar chain (`n_four_bar`) whose first, or every second, ... loop is a hinge, which holds rotations too, in place of a ball."""
    start, *loops = text.split('type="spherical"')
    for k, loop in enumerate(loops):
        hinge = ('type="revolute"', loop.replace("</loop_joint>", '<axis xyz="0 1 0"/></loop_joint>'))
        start += "".join(('type="spherical"', loop) if k % every else hinge)
    return start


def geared_chain(count: int) -> str:
    """A planar chain of five-bars: upright rods 1 m apart, their tips joined by two bars each, the pin between which turns half as far as
    that at the first tip, backwards, by a gear pair. Joints A0, A1, ... on the frame, B0, C0, ... at tips and between bars."""
    upright, half = _rod("0 0 0.5", "xy"), _rod("0.25 0 0.15", "xyz")
    parts = ['<robot name="geared_chain">', '<link name="frame"/>']
    for k in range(count + 1):
        parts += [f'<link name="rod_{k}">{upright}</link>', _joint(f"A{k}", "frame", f"rod_{k}", f"{k} 0 0")]
    for k in range(count):
        parts += [f'<link name="left_{k}">{half}</link><link name="right_{k}">{half}</link>']
        parts.append(_joint(f"B{k}", f"rod_{k}", f"left_{k}", "0 0 1"))
        pin = _joint(f"C{k}", f"left_{k}", f"right_{k}", "0.5 0 0.3")
        parts.append(pin.replace("</joint>", f'<mimic joint="B{k}" multiplier="-0.5"/></joint>'))
        ends = f'<link1 link="right_{k}" xyz="0.5 0 -0.3"/><link2 link="rod_{k + 1}" xyz="0 0 1"/>'
        parts.append(f'<loop_joint name="D{k}" type="spherical">{ends}</loop_joint>')
    return "\n".join([*parts, '<transmission name="drive"><joint name="A0"/></transmission>', "</robot>"])


def tied_row(count: int, short: bool) -> str:
    """A crank and ``count`` links in a row behind it, the far end of each on a rod that stands on the frame, written in two ways.

    With ``short`` loops every link hangs on its own rod, and loops join it to its neighbour. Else the links hang on each other, so that the
    loop of each rod goes round all links before it.
    """
    upright, lying = _rod("0 0 0.5", "xy"), _rod("0.5 0 0", "yz")
    parts = ['<robot name="tied_row">', f'<link name="frame"/><link name="crank">{upright}</link>', _joint("A", "frame", "crank", "0 0 0")]
    for k in range(count):
        before = (f"link_{k - 1}", "0 0 0" if short else "1 0 0") if k else ("crank", "0 0 1")
        parts += [
            f'<link name="rod_{k}">{upright}</link><link name="link_{k}">{lying}</link>',
            _joint(f"C{k}", "frame", f"rod_{k}", f"{k + 1} 0 0"),
        ]
        if short:  # the origin of the link is its far end
            parts[-2] = parts[-2].replace(lying, _rod("-0.5 0 0", "yz"))
            parts.append(_joint(f"D{k}", f"rod_{k}", f"link_{k}", "0 0 1"))
            ends = f'<link1 link="{before[0]}" xyz="{before[1]}"/><link2 link="link_{k}" xyz="-1 0 0"/>'
        else:
            parts.append(_joint(f"B{k}", before[0], f"link_{k}", before[1]))
            ends = f'<link1 link="link_{k}" xyz="1 0 0"/><link2 link="rod_{k}" xyz="0 0 1"/>'
        parts.append(f'<loop_joint name="{"B" if short else "D"}{k}" type="spherical">{ends}</loop_joint>')
    return "\n".join([*parts, '<transmission name="drive"><joint name="A"/></transmission>', "</robot>"])


def _rod(centre: str, across: str) -> str:
    """Inertia of a slender rod of 1 m and 1 kg."""
    return n_four_bar.ROD.format(centre=centre, **{axis: 1 / 12 if axis in across else 0.0 for axis in "xyz"})


def _joint(name: str, parent: str, child: str, place: str, axis: str = "0 1 0") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{place}"/>'
    return f'<joint name="{name}" type="continuous">{ends}<axis xyz="{axis}"/></joint>'
