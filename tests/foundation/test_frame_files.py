"""Frame files: what stands in one is what the same numbers in Python make; mistakes are named with file, line and keys."""

import bz2
import gzip
import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal
from scipy.io import mmwrite
from support.exploring import examples
from support.texts import shipped

import pinpress as pp
from pinpress import PinpressError, foundation
from pinpress.common.errors import FileEntryError
from pinpress.common.reading import matrices

EXAMPLE = Path(__file__).parents[2] / "docs" / "jf75g_125_frame.yaml"
FEET = [(x, y, -1.3) for x in (-0.55, 0.55) for y in (-0.5, 0.6)]
RIGID = """\
frame: {mass: 15 t, centre: [0, 100 mm, -0.35 m], inertia: [[9000, 10, 0], [10, 8000, 0], [0, 0, 4000 kg m2]]}
mounts:
  - points: [-0.55 -0.5 -1.3 m, -0.55 0.6 -1.3 m]
    stiffness: [50 MN/m, 50 kN/mm, 2e8 N/m]
    damping: 1e4 1e4 4e4 N s/m
    static_stiffness: [4e7, 4e7, 1e8 N/m]
    area: 400 cm2
  - points: [[0.55, -0.5, -1.3], [0.55, 0.6, -1.3 m]]
    pad: {length: 200 mm, width: 0.2 m, thickness: 1 cm, hardness: 65, loss_factor: 15 %, stiffening: 1.3}
crown: {mass: 4 t, centre: 0 0 1 m, inertia: 900 800 700 kg m2}
uprights:
  - {points: [[-0.5, 0, 0], [0.5, 0.4, 0], [0.5, -0.4, 0 m]], stiffness: 1e8 1e8 2e9 N/m, loss_factor: 0.01}
attached:
  NO: {mass: 120 kg, centre: 0.8 0 0.4 m, inertia: 5 6 7 kg m2, on: bed}
  motor:
    mass: 450 kg
    centre: 0 0.9 0.95 m
    inertia: [20, 10, 20 kg m2]
    springs: [{points: [[-0.3, 0.7, 0.8], [-0.3, 1.1, 0.8], [0.3, 0.7, 0.8], [0.3, 1.1, 0.8 m]], stiffness: 4e6 4e6 8e6 N/m}]
rotors:
  - {inertia: 136 kg m2, axis: [0, -2, 0]}
  - {inertia: 1.2 kg m2, axis: 0 1 0, ratio: -3, on: motor}
"""


def rigid():
    """The system of `RIGID`, from Python."""
    pad = foundation.RubberPad(0.2, 0.2, 0.01, hardness=65, loss_factor=0.15, stiffening=1.3)
    spring = {"stiffness": (5e7, 5e7, 2e8), "damping": (1e4, 1e4, 4e4), "static_stiffness": (4e7, 4e7, 1e8), "area": 0.04}
    mounts = [*(foundation.Mount(foot, **spring) for foot in FEET[:2]), *(foundation.pad_mount(foot, pad) for foot in FEET[2:])]
    uprights = [foundation.Mount(p, (1e8, 1e8, 2e9), loss_factor=0.01) for p in ((-0.5, 0, 0), (0.5, 0.4, 0), (0.5, -0.4, 0))]
    bracket = [foundation.Mount((x, y, 0.8), (4e6, 4e6, 8e6)) for x in (-0.3, 0.3) for y in (0.7, 1.1)]
    return foundation.mounted(
        shipped("jf75g_125"),
        foundation.Frame(15e3, (0, 0.1, -0.35), np.array([[9e3, 10, 0], [10, 8e3, 0], [0, 0, 4e3]])),
        mounts,
        crown=foundation.Frame(4e3, (0, 0, 1), (900, 800, 700)),
        uprights=uprights,
        attached={
            "NO": foundation.Attachment(foundation.Frame(120, (0.8, 0, 0.4), (5, 6, 7)), on="bed"),
            "motor": foundation.Attachment(foundation.Frame(450, (0, 0.9, 0.95), (20, 10, 20)), bracket),
        },
        rotors=[foundation.Rotor(136, (0, -1, 0)), foundation.Rotor(1.2, (0, 1, 0), ratio=-3, on="motor")],
    )


def hold_the_same(found, wanted):
    for name in ("mass", "damping", "stiffness", "loss", "gyroscopic", "weight", "mount_load", "sag"):
        assert_array_equal(getattr(found, name), getattr(wanted, name), err_msg=name)
    assert found.mounts == wanted.mounts
    assert list(found.attached) == list(wanted.attached)
    assert (found.bed, found.carrier, found.rotors) == (wanted.bed, wanted.carrier, wanted.rotors)


def read(tmp_path, text, name="frame.yaml"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return foundation.read_mounted(shipped("jf75g_125"), path)


def as_plain(entry):
    """Entries as JSON has them."""
    value = entry.value
    if isinstance(value, tuple):
        return [as_plain(each) for each in value]
    return value if isinstance(value, str) else {name: as_plain(each) for name, each in value.items()}


def test_rigid_parts_are_those_of_python_from_yaml_and_json(tmp_path):
    from pinpress.common.reading.entries import read_entries
    from pinpress.foundation.frame_file import FRAME_FILE

    wanted = rigid()
    hold_the_same(read(tmp_path, RIGID), wanted)
    plain = as_plain(read_entries(tmp_path / "frame.yaml", FRAME_FILE))
    hold_the_same(read(tmp_path, json.dumps(plain), "frame.json"), wanted)


def test_the_frame_of_beams_in_the_manual():
    """The shipped file is what the manual makes in Python: frame of boxes, motor on its bracket, flywheel, rubber pads."""
    places = {"bed": (0, 0.05, -0.8), "crown": (0, 0.05, 0.5)}
    for side, y in (("right", -0.5), ("left", 0.6)):
        places |= {side: (0, y, -0.8), f"upper {side}": (0, y, 0.5)}
        places |= {f"{foot} {side}": (x, y, -1.3) for foot, x in (("back", -0.55), ("front", 0.55))}
    beam, sides = foundation.FrameBeam, ("right", "left")
    boxes = [beam(side, f"upper {side}", width=0.9, height=0.3, wall=0.05, across=(1, 0, 0)) for side in sides]
    boxes += [beam(f"upper {side}", "crown", width=0.9, height=0.7, wall=0.05, across=(1, 0, 0)) for side in sides]
    boxes += [beam(side, "bed", width=1.0, height=0.8, wall=0.06, across=(1, 0, 0)) for side in sides]
    boxes += [beam(s, f"{foot} {s}", width=0.3, height=0.3, across=(0, 1, 0)) for s in sides for foot in ("back", "front")]
    frame = foundation.beam_frame(places, boxes, bed="bed", carrier="crown", loss_factor=0.01)
    pad = foundation.RubberPad(length=0.2, width=0.2, thickness=0.01, hardness=65, loss_factor=0.15, stiffening=1.3)
    rails = [foundation.Mount((x, y, 0.8), (4e6, 4e6, 8e6), loss_factor=0.05) for x in (-0.3, 0.3) for y in (0.7, 1.1)]
    motor = foundation.Attachment(foundation.Frame(mass=450, centre=(0, 0.9, 0.95), inertia=(20, 10, 20)), springs=rails)
    feet = [foundation.pad_mount(foot, pad) for foot in FEET]
    press = shipped("jf75g_125")
    wanted = foundation.mounted(press, frame, feet, attached={"motor": motor}, rotors=[foundation.Rotor(136, (0, -1, 0))])
    found = foundation.read_mounted(press, EXAMPLE)
    for name in ("mass", "stiffness", "loss", "gyroscopic", "mount_load"):  # places stand in another order: rounding
        wide = getattr(wanted, name)
        np.testing.assert_allclose(getattr(found, name)[:6, :6], wide[:6, :6], rtol=1e-9, atol=1e-9 * np.abs(wide).max(), err_msg=name)
    frequencies = [foundation.modes(system).natural_frequency for system in (found, wanted)]
    np.testing.assert_allclose(*frequencies, rtol=1e-6)


FREE = """\
frame:
  matrices: {matrices}
  interfaces: {{bed: 0, crown: 1, foot: 2, other: 3}}
  bed: bed
  carrier: crown
  bearings: {{slide_guide: bed}}
  modes: 3
  loss_factor: 2 %
  lines: lines.csv
mounts:
  - points: 0 0 -1 m
    stiffness: 1e8 1e8 1e8 N/m
  - points: [1 0 -1 m, 0 1 -1 m]
    stiffness: 1e8 1e8 1e8 N/m
attached: {{cabinet: {{mass: 1 kg, centre: 0.3 0.2 0 m, inertia: 1 1 1 kg m2, on: bed}}}}
"""


def beam_matrices(monkeypatch):
    """Mass, stiffness, nodes and degrees of three beams with four interfaces."""
    with monkeypatch.context() as patched:
        patched.setattr(
            "pinpress.foundation.beams.reduced_frame", lambda mass, stiffness, **more: (mass, stiffness, more["nodes"], more["degrees"])
        )
        ends = {"bed": (0, 0, -1), "crown": (0, 0, 1), "foot": (1, 0, -1), "other": (0, 1, -1)}
        beams = [foundation.FrameBeam("bed", end, 0.6, 0.4, (1, 1, 0)) for end in ("crown", "foot", "other")]
        return foundation.beam_frame(ends, beams, bed="bed", carrier="crown", elements=2)


@pytest.mark.parametrize(
    "matrices",
    [
        "frame.npz",
        "{mass: m.mtx, stiffness: k.mtx, nodes: nodes.csv, degrees: degrees.csv}",
        "{mass: m.mtx.gz, stiffness: k.mtx.gz, nodes: nodes.csv, degrees: degrees.csv}",
    ],
)
def test_matrices_are_sought_beside_the_file(matrices, monkeypatch, tmp_path):
    mass, stiffness, nodes, degrees = beam_matrices(monkeypatch)
    np.savez(tmp_path / "frame.npz", mass=mass, stiffness=stiffness, nodes=nodes, degrees=degrees)
    mmwrite(tmp_path / "m.mtx", mass, precision=17)
    mmwrite(tmp_path / "k.mtx", stiffness, precision=17)
    for name in ("m.mtx", "k.mtx"):  # and compressed, as programs and SciPy write them too
        (tmp_path / f"{name}.gz").write_bytes(gzip.compress((tmp_path / name).read_bytes()))
    np.savetxt(tmp_path / "nodes.csv", nodes, delimiter=",", header="x [m],y [m],z [m]", comments="")
    np.savetxt(tmp_path / "degrees.csv", degrees, delimiter=",", fmt="%d")
    lines = [[0, 4], [4, 1], [0, 5], [5, 2], [0, 6], [6, 3]]
    np.savetxt(tmp_path / "lines.csv", lines, delimiter=",", fmt="%d", header="from,to", comments="")
    found = read(tmp_path, FREE.format(matrices=matrices)).frame
    more = {
        "interfaces": {"bed": 0, "crown": 1, "foot": 2, "other": 3},
        "bed": "bed",
        "carrier": "crown",
        "bearings": {"slide_guide": "bed"},
    }
    wanted = foundation.reduced_frame(mass, stiffness, nodes=nodes, degrees=degrees, **more, modes=3, loss_factor=0.02, lines=lines)
    assert (found.bearings, found.loss_factor, found.nodes) == (wanted.bearings, wanted.loss_factor, wanted.nodes)
    assert_array_equal(found.lines, lines)
    np.testing.assert_allclose(found.natural_frequency, wanted.natural_frequency, rtol=1e-12)


def test_nodes_are_in_the_unit_of_their_header(monkeypatch, tmp_path):
    mass, stiffness, nodes, degrees = beam_matrices(monkeypatch)
    mmwrite(tmp_path / "m.mtx", mass, precision=17)
    mmwrite(tmp_path / "k.mtx", stiffness, precision=17)
    np.savetxt(tmp_path / "degrees.csv", degrees, delimiter=",", fmt="%d")
    np.savetxt(tmp_path / "lines.csv", [[0, 4]], delimiter=",", fmt="%d")
    text = FREE.format(matrices="{mass: m.mtx, stiffness: k.mtx, nodes: nodes.csv, degrees: degrees.csv}")
    np.savetxt(tmp_path / "nodes.csv", 1e3 * nodes, delimiter=";", header="x [mm];y [mm];z [mm]", comments="")
    found = read(tmp_path, text).frame
    np.testing.assert_allclose(found.nodes["crown"], nodes[1], rtol=1e-12)
    for header, said in (
        ("x [kg],y [kg],z [kg]", "column 'x' is in 'kg', which is none of m, mm"),
        ("x [mm],y [m],z [mm]", "has several units"),
    ):
        np.savetxt(tmp_path / "nodes.csv", nodes, delimiter=",", header=header, comments="")
        with pytest.raises(FileEntryError, match=re.escape(said)):
            read(tmp_path, text)


@pytest.mark.parametrize(
    ("old", "new", "line", "element", "said"),
    [
        ("mass: 15 t", "mas: 15 t", 1, "frame", "no key here, did you mean 'mass'?"),
        ("mass: 15 t", "mass: 15 mm", 1, "frame: mass", "in 'mm', which is none of kg, t, g"),
        ("mass: 15 t", "mass: -15 t", 1, "frame: mass", "-15000.0; give one finite number that is not negative"),
        ("mass: 15 t", "mass: 15", 1, "frame: mass", "15 has no unit; write 15 t or 15 kg, whichever it is"),
        ("mass: 15 t, ", "", 1, "frame", "mass is missing"),
        ("centre: [0, 100 mm, -0.35 m]", "centre: 0", 1, "frame: centre", "give x, y, z .m., finite"),
        ("centre: [0, 100 mm, -0.35 m]", "centre: 0 1 m", 1, "frame: centre", "give x, y, z .m., finite"),
        ("centre: [0, 100 mm, -0.35 m]", "centre: 0/1/2 m", 1, "frame: centre", "no row of numbers; write numbers with blanks"),
        ("frame:", "farme:", 1, "", "'farme' is no key here, did you mean 'frame'?"),
        ("mounts:", "feet:", 2, "", "'feet' is no key here, did you mean 'mounts'?"),
        ("stiffness: [50 MN/m, 50 kN/mm, 2e8 N/m]", "k: [1, 1, 1]", 4, "mounts: 1", "did you mean 'stiffness'?"),
        ("    stiffness: [50 MN/m, 50 kN/mm, 2e8 N/m]\n", "", 3, "mounts: 1", "stiffness is missing"),
        ("points: [-0.55 -0.5 -1.3 m, -0.55 0.6 -1.3 m]", "points: -0.55 -0.5 m", 3, "mounts: 1", "point is"),
        ("hardness: 65", "hardness: 95", 9, "mounts: 2: pad: hardness", "95"),
        ("length: 200 mm, ", "", 9, "mounts: 2: pad", "length is missing"),
        ("on: bed", "on: bad", None, "", "no part of the frame 'bad', did you mean 'bed'?"),
        ("axis: [0, -2, 0]", "axis: [0, 0, 0]", 21, "rotors: 1: axis", "give"),
        ("axis: [0, -2, 0]", "axis: [0, -2, x]", 21, "rotors: 1: axis: 3", "'x' is no number"),
        (RIGID.partition("rotors:")[2], " {inertia: 136 kg m2}", 20, "rotors", "axis is missing"),
        ("  - points: [-0.55", "  -points: [-0.55", None, "", "is no YAML|mounts"),
        ("-0.55 -0.5 -1.3 m", "-0.55 5.5 -1.3 m", None, "", "would be pulled by the weight"),
    ],
)
def test_mistakes_are_named(old, new, line, element, said, tmp_path):
    assert old in RIGID
    with pytest.raises(FileEntryError, match=said) as caught:
        read(tmp_path, RIGID.replace(old, new, 1))
    error = caught.value
    assert str(error).startswith(str(tmp_path / "frame.yaml"))
    assert error.remedy
    if line is not None:
        assert (error.line, error.element) == (line, element)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("lines.csv", "from,to\n0,2\nx,3\n", "lines.csv, line 3, node 0: 'x' is no number"),
        ("lines.csv", "0,2,3\n", "lines.csv, line 1: 3 cells for 2 columns"),
        ("lines.csv", None, "cannot be read: No such file"),
        ("lines.csv", "0,9\n", "join nodes by their numbers, from 0 to 6"),
        ("frame.npz", "", "is no file of arrays"),
    ],
)
def test_files_beside_it_are_named(name, content, said, monkeypatch, tmp_path):
    mass, stiffness, nodes, degrees = beam_matrices(monkeypatch)
    np.savez(tmp_path / "frame.npz", mass=mass, stiffness=stiffness, nodes=nodes, degrees=degrees)
    (tmp_path / "lines.csv").write_text("0,2\n")
    (tmp_path / name).unlink()
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(FileEntryError, match=said):
        read(tmp_path, FREE.format(matrices="frame.npz"))


@pytest.mark.parametrize("name", ["mass.mtx", "mass.mtx.gz"])
def test_one_matrix_alone_is_refused(tmp_path, name):
    with pytest.raises(FileEntryError, match=f"{name} holds one matrix") as caught:
        read(tmp_path, FREE.format(matrices=name))
    assert caught.value.remedy.startswith("write {mass: m.mtx, stiffness: k.mtx")


@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress])
def test_a_compressed_matrix_that_is_not_whole_is_refused(tmp_path, pack, monkeypatch):
    ending = "gz" if pack is gzip.compress else "bz2"
    path = tmp_path / f"m.mtx.{ending}"
    text = b"%%MatrixMarket matrix array real general\n2 2\n1\n0\n0\n1\n"
    path.write_bytes(pack(text))
    assert_array_equal(matrices.read_market(str(path)), np.eye(2))
    path.write_bytes(pack(text)[:-9])
    with pytest.raises(PinpressError, match="cannot be read: what is compressed in it is not whole"):
        matrices.read_market(str(path))
    path.write_bytes(text)
    with pytest.raises(PinpressError, match="cannot be read: "):
        matrices.read_market(str(path))
    path.write_bytes(pack(text))
    monkeypatch.setattr("pinpress.common.files.read", lambda path, most: pack(text))
    monkeypatch.setattr(matrices, "MOST_BYTES", 40)
    with pytest.raises(PinpressError, match="uncompressed it is larger than 4e-05 MB"):
        matrices.read_market(str(path))


def test_what_is_wrong_with_the_press_is_said_of_the_press(tmp_path):
    press = pp.derivatives.reshaped(shipped("crank_slide"), {("P", "crank"): (0.5, 0, 0)})
    path = tmp_path / "frame.yaml"
    path.write_text(RIGID.replace("on: motor", "on: bed"), encoding="utf-8")
    with pytest.raises(PinpressError) as caught:
        foundation.read_mounted(press, path)
    assert not isinstance(caught.value, FileEntryError)


TOKENS = re.findall(r"[A-Za-z_]+|[-\d.e]+|[\[\]{}:,]|\s+", RIGID + EXAMPLE.read_text("utf-8").partition("frame:")[2])


@examples(40)
@given(st.integers(0, 10_000), st.integers(0, 10_000), st.sampled_from(["drop", "swap", "twice"]))
def test_damaged_files_are_refused_or_read(tmp_path_factory, at, other, how):
    """A token left out, written twice or in place of another one: an error of ours, or a system of finite matrices."""
    text = re.findall(r"[A-Za-z_]+|[-\d.e]+|[\[\]{}:,]|\s+", RIGID)
    k = at % len(text)
    text[k] = {"drop": "", "swap": TOKENS[other % len(TOKENS)], "twice": 2 * text[k]}[how]
    folder = tmp_path_factory.mktemp("frames", numbered=True)
    try:
        found = read(folder, "".join(text))
    except PinpressError:
        return
    assert np.isfinite(found.stiffness).all()
    assert np.isfinite(found.mount_load).all()
