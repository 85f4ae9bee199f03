"""Random trees of joints in space with loops through points, springs and rotors in joints, and fewer motors than degrees of freedom."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

import pinpress as pp


def sprung_tree(seed: int, folder: Path, joints: int = 8, loops: int = 1) -> pp.Linkage:
    """A linkage of 4 joints at least more than equations, drawn closed; motors are drivers at random, the other drivers are passive."""
    rng = np.random.default_rng(seed)
    places, lines = {"frame": pin.SE3.Identity()}, ['<link name="frame"/>']
    for k in range(joints):
        parent = "frame" if k < 2 else f"link{k - 1 if rng.random() < 0.7 else rng.integers(0, k)}"
        place = pin.SE3(pin.exp3(rng.uniform(-1.5, 1.5, 3)), rng.uniform(-0.4, 0.4, 3))
        places[f"link{k}"] = places[parent] * place
        kind = "prismatic" if rng.random() < 0.2 else "continuous"
        limit = '<limit lower="-9" upper="9" effort="9" velocity="9"/>' if kind == "prismatic" else ""
        axis = rng.normal(size=3)
        lines.append(
            f'<joint name="joint{k}" type="{kind}"><parent link="{parent}"/><child link="link{k}"/><origin xyz="{_text(place.translation)}"'
            f' rpy="{_text(pin.rpy.matrixToRpy(place.rotation))}"/><axis xyz="{_text(axis / np.linalg.norm(axis))}"/>{limit}</joint>'
        )
        moments, turned = rng.uniform(0.5, 1.0, 3) * 0.02, pin.exp3(rng.uniform(-1, 1, 3))
        i = turned @ np.diag(moments) @ turned.T
        names = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
        tensor = " ".join(f'{name}="{float(i[a, b])!r}"' for name, a, b in names)
        inertial = f'<origin xyz="{_text(rng.uniform(-0.2, 0.2, 3))}"/><mass value="{rng.uniform(0.3, 3.0)!r}"/><inertia {tensor}/>'
        lines.append(f'<link name="link{k}"><inertial>{inertial}</inertial></link>')
    for k in range(loops):
        ends = (f"link{joints - 1 - k}", "frame" if k else f"link{rng.integers(0, 2)}")
        point = places[ends[0]].act(rng.uniform(-0.3, 0.3, 3))
        points = "".join(f'<link{e} link="{end}" xyz="{_text(places[end].actInv(point))}"/>' for e, end in enumerate(ends, 1))
        lines.append(f'<loop_joint name="loop{k}" type="spherical">{points}</loop_joint>')
    for k in rng.choice(joints, 3, replace=False):
        stiffness, reference, damping = rng.uniform(0.0, 20.0), rng.uniform(-1.0, 1.0), rng.uniform(0.0, 0.5)
        lines.append(f'<joint_spring joint="joint{k}" stiffness="{stiffness}" reference="{reference}" damping="{damping}"/>')
        lines.append(f'<armature joint="joint{k}" inertia="{rng.uniform(0.0, 0.05)}"/>')
    path = folder / f"sprung_tree_{seed}.urdf"
    path.write_text(f'<robot name="sprung_tree">{"".join(lines)}</robot>')
    undriven = pp.load(path, drivers=_independent(path, rng))
    motors = int(rng.integers(1, len(undriven.drivers)))
    return replace(undriven, passive=undriven.drivers[motors:])


def _independent(path: Path, rng: np.random.Generator) -> list[str]:
    """Joints that determine all others well."""
    from scipy.linalg import null_space, qr

    from pinpress.linkage.loading import build, parse

    press = build(parse(path), ["joint0"], None)
    free = null_space(press.equations(np.zeros(press.model.nv)).columns)
    _, _, order = qr(free.T * rng.uniform(0.5, 1.0, len(free)), pivoting=True)
    return [press.joints[joint] for joint in order[: free.shape[1]]]


def _text(numbers: np.ndarray) -> str:
    return " ".join(repr(float(number)) for number in numbers)
