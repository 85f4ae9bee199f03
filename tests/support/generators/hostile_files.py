"""Files that would hold a program up for ever, fill the memory or end the process, and how to load or draw them where that does no harm."""

import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
SECONDS, BYTES = 60, 2_500_000_000  # that a process may take, of address space; a hundred megabytes of it are in use at the start
JUDGE = """
import resource, sys
import numpy as np
import pinpress as pp
from pinpress.visual.shapes.appearance import bodies
for file in sys.argv[1:]:
    try:
        press = pp.load(file)
        bodies(press, np.zeros((2, len(press.joints))))
        print("sound")
    except pp.PinpressError as error:
        print(str(error).replace(chr(10), " "))
"""


def judged(*files: os.PathLike[str] | str) -> list[str]:
    """What comes of loading and drawing these files in a process with limited time and memory: "sound", or the message of the error."""
    limits = f"ulimit -v {BYTES // 1024}; exec timeout {SECONDS} " + '"$@"'
    command = ["bash", "-c", limits, "bash", sys.executable, "-c", JUDGE, *map(os.fspath, files)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=2 * SECONDS, stdin=subprocess.DEVNULL, check=False)
    assert done.returncode == 0, f"ended with {done.returncode} after {done.stdout!r}: {done.stderr[-2000:]}"
    return done.stdout.splitlines()


def press(more: str = "", visual: str = "") -> str:
    """A crank on a frame, as URDF."""
    crank = f'<link name="crank">{INERTIAL}{visual}</link>'
    joint = '<joint name="O" type="continuous"><parent link="frame"/><child link="crank"/><axis xyz="0 -1 0"/></joint>'
    drive = '<transmission name="drive"><joint name="O"/></transmission>'
    return f'<robot name="crank"><link name="frame"/>{crank}{joint}{drive}{more}</robot>'


def with_mesh(folder: Path, name: str, content: bytes) -> Path:
    """A URDF whose crank is drawn as this mesh file."""
    (folder / name).write_bytes(content)
    file = folder / f"{name}.urdf"
    file.write_text(press(visual=f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'), encoding="utf-8")
    return file


def chain(count: int) -> str:
    """Links welded one to the next."""
    links = ["crank", *(f"l{i}" for i in range(count))]
    ends = "".join(f'<joint name="to_{b}" type="fixed"><parent link="{a}"/><child link="{b}"/></joint>' for a, b in pairwise(links))
    return press("".join(f'<link name="{link}"/>' for link in links[1:]) + ends)


def shafts(count: int) -> str:
    """Shafts geared to the crank."""
    return press(
        "".join(
            f'<link name="s{i}">{INERTIAL}</link><joint name="S{i}" type="continuous"><parent link="frame"/><child link="s{i}"/>'
            '<axis xyz="0 -1 0"/><mimic joint="O" multiplier="-1"/></joint>'
            for i in range(count)
        )
    )


def loops(count: int) -> str:
    """Loops between the same two links."""
    hinge = '<joint name="X" type="continuous"><parent link="frame"/><child link="x"/><axis xyz="0 -1 0"/></joint>'
    ends = '<link1 link="x"/><link2 link="crank"/>'
    closed = "".join(f'<loop_joint name="L{i}" type="spherical">{ends}</loop_joint>' for i in range(count))
    return press(f'<link name="x">{INERTIAL}</link>{hinge}{closed}')


TRIANGLE = """<geometry id="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>"""
SHOWN = '<instance_geometry url="#g"/>'


def collada(nodes: str, scene: str = '<node><instance_node url="#a"/></node>', more: str = "") -> bytes:
    """A COLLADA file of one triangle."""
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        '<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>'
        f"<library_geometries>{TRIANGLE}</library_geometries>{more}<library_nodes>{nodes}</library_nodes>"
        f'<library_visual_scenes><visual_scene id="s">{scene}</visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    ).encode()


def _chain_of_nodes(count: int, each: int = 1) -> bytes:
    inside = "".join(f'<node id="n{i}">{f"""<instance_node url="#n{i + 1}"/>""" * each}</node>' for i in range(count))
    return collada(f'{inside}<node id="n{count}">{SHOWN}</node>', '<node><instance_node url="#n0"/></node>')


_SAMPLER = (
    '<library_effects><effect id="e"><profile_COMMON><newparam sid="x"><sampler2D><source>x</source></sampler2D></newparam>'
    '<technique sid="t"><phong><diffuse><texture texture="x" texcoord="y"/></diffuse></phong></technique></profile_COMMON></effect>'
    '</library_effects><library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>'
)
_SKIN = '<library_controllers><controller id="c"><skin source="#d"/></controller><controller id="d"><skin source="#c"/></controller>'
_CORNERS = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"

MESHES = {  # name, content, what is said
    "one.dae": (collada(f'<node id="a">{SHOWN}</node>'), "sound"),
    "itself.dae": (collada(f'<node id="a">{SHOWN}<instance_node url="#a"/></node>'), "refer to each other in a ring"),
    "ring.dae": (
        collada(f'<node id="a">{SHOWN}<instance_node url="#b"/></node><node id="b"><instance_node url="#a"/></node>'),
        "refer to each other in a ring",
    ),
    "scene.dae": (
        collada("", f'<node id="a">{SHOWN}<node id="b"><instance_node url="#a"/></node></node>'),
        "refer to each other in a ring",
    ),
    "unnamed.dae": (
        collada(f'<node>{SHOWN}<instance_node url="#"/></node>', '<node><instance_node url="#"/></node>'),
        "refer to each other in a ring",
    ),
    "bomb.dae": (_chain_of_nodes(10, each=10), "more than 10000 nodes, every instance counted"),
    "deep.dae": (_chain_of_nodes(9000), "more than 200 levels"),
    "deep_enough.dae": (_chain_of_nodes(150), "sound"),
    "many.dae": (collada(f'<node id="a">{SHOWN * 20000}</node>'), "more than 10000 nodes, every instance counted"),
    "skin.dae": (
        collada('<node id="a"><instance_controller url="#c"/></node>', more=f"{_SKIN}</library_controllers>"),
        "cannot be read as triangles",
    ),
    "sampler.dae": (collada(f'<node id="a">{SHOWN}</node>', more=_SAMPLER), "sound"),
    "pipe.obj": (b"mtllib pipe.mtl\nusemtl x\n" + _CORNERS + b"f 1 2 3\n", "sound"),
    "endless.obj": (b"mtllib /dev/zero\nusemtl x\n" + _CORNERS + b"f 1 2 3\n", "sound"),
    "continued.obj": (b"mtl\\\nlib pipe.mtl\n" + _CORNERS + b"f 1 2 3\n", "sound"),
    "round.obj": (_CORNERS + b"f " + b"1 2 3 " * 100_000 + b"\n", "a polygon with more than 1000 corners"),
    "groups.obj": (_CORNERS + b"".join(b"o x%d\nf 1 2 3\n" % i for i in range(10_000)), "sound"),
    "triangles.obj": (_CORNERS + b"f 1 2 3\n" * 500_001, "more than 500000 triangles"),
    "triangles.stl": (b" " * 80 + (500_001).to_bytes(4, "little") + bytes(50 * 500_001), "more than 500000 triangles"),
    "count.stl": (b" " * 80 + b"\xff\xff\xff\xff" + bytes(50), "not an STL file, or one that ends early"),
}

URDFS = {
    "chain": (chain(2_000), "there are 2002 <link>, more than 1000"),
    "deep": (chain(600), "more than 500 joints away from the root link"),
    "deep_enough": (chain(490), "sound"),
    "shafts": (shafts(200), "sound"),
    "loops": (loops(600), "there are 600 <loop_joint>, more than 500"),
    "attributes": (press("<link " + " ".join(f'a{i}="1"' for i in range(200_000)) + "/>"), "200000 attributes, more than 100"),
    "elements": (press("<gazebo/>" * 110_000), "more than 100000 elements"),
    "levels": (press("<gazebo>" * 300 + "</gazebo>" * 300), "nested too deeply"),
    "name": (press().replace('"crank"', f'"{"x" * 10**6}"'), "a name or value of 1000000 characters, more than 1000"),
    "digits": (press().replace('value="1"', f'value="{"1" * 10**6}"'), "a name or value of 1000000 characters, more than 1000"),
    "large": (press(f"<!--{'x' * 20_000_000}-->"), "larger than 20 MB"),
    "faults": (
        press("".join(f'<joint name="q{i}" type="fixed"><parent link="p{i}"/><child link="c{i}"/></joint>' for i in range(900))),
        "no link 'p0'",
    ),
    "entities": (f'<!DOCTYPE robot [<!ENTITY a "{"x" * 1000}"><!ENTITY b "{"&a;" * 1000}">]><robot name="&b;"/>', "document type"),
    "external": ('<!DOCTYPE robot [<!ENTITY a SYSTEM "file:///etc/hostname">]><robot name="x">&a;</robot>', "document type"),
}
