"""Mechanisms of robots whose loops can be drawn far open: a five-bar, a platform on six legs, and legs with one to three rods between ball
joints, each rod cut in the middle by a loop of six equations. At zero all of them are closed."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pinpress.engines.constraints import LoopJoint, Relation
from pinpress.engines.structure import Structure, build_structure

X, Y, Z = np.eye(3)


def beside(point: np.ndarray, *by: float) -> np.ndarray:
    """A point (3,) so far from another one."""
    return point + np.array(by)


class Drawn:
    """A mechanism in its closed pose, drawn in world axes."""

    def __init__(self) -> None:
        self.model, self.places = pin.Model(), [np.zeros(3)]
        self.loops: list[LoopJoint] = []
        self.still: list[Relation] = []
        self.drivers: list[int] = []

    def joint(self, parent: int, point: Sequence[float], axis: np.ndarray, slides: bool = False, drives: bool = False) -> int:
        """Add a joint with its origin at a point, and return its index."""
        kind = (pin.JointModelPrismaticUnaligned if slides else pin.JointModelRevoluteUnaligned)(np.array(axis, dtype=float))
        place = pin.SE3(np.eye(3), np.array(point) - self.places[parent])
        joint = int(self.model.addJoint(parent, kind, place, f"j{len(self.places)}"))
        self.places.append(np.array(point, dtype=float))
        if drives:
            self.drivers.append(joint - 1)
        return joint

    def ball(self, parent: int, point: Sequence[float], axes: Sequence[np.ndarray] = (Z, Y, X)) -> int:
        """Hinges about axes through one point; the index of the last one."""
        for axis in axes:
            parent = self.joint(parent, point, axis)
        return parent

    def loop(self, kind: str, joint1: int, joint2: int, point: Sequence[float]) -> None:
        one, two = (np.array(point) - self.places[joint] for joint in (joint1, joint2))
        self.loops.append(LoopJoint(f"l{len(self.loops)}", kind, joint1, one, np.eye(3), joint2, two, np.eye(3), 0))

    def rod(self, crank: int, end1: np.ndarray, body: int, end2: np.ndarray) -> None:
        """A rod between balls on a crank and on a body, cut in the middle; it does not spin against the crank's ball."""
        along = (end2 - end1) / np.linalg.norm(end2 - end1)
        across = np.cross(along, X) / np.linalg.norm(np.cross(along, X))
        half1 = self.ball(crank, end1, (across, np.cross(along, across), along))
        half2 = self.ball(body, end2, (np.cross(along, across), across, along))
        self.still.append(Relation(f"j{half1}", {half1 - 1: 1.0}))
        self.loop("fixed", half1, half2, 0.5 * (end1 + end2))

    def structure(self) -> Structure:
        return build_structure(self.model, tuple(self.loops), tuple(self.still), tuple(self.drivers))


def five_bar() -> Structure:
    """Two cranks and two rods in the plane, ending in a ball."""
    drawn = Drawn()
    for side in (-1.0, 1.0):
        crank = drawn.joint(0, (0.15 * side, 0.0, 0.0), Y, drives=True)
        drawn.joint(crank, (0.3 * side, 0.0, 0.2), Y)
    drawn.loop("spherical", 2, 4, (0.0, 0.0, 0.45))
    return drawn.structure()


def six_legs() -> Structure:
    """A platform on six legs, each a universal joint, a slide and a ball; the first leg carries it in the tree."""
    drawn, feet = Drawn(), np.deg2rad([10.0, 110.0, 130.0, 230.0, 250.0, 350.0])
    heads, platform = np.deg2rad([50.0, 70.0, 170.0, 190.0, 290.0, 310.0]), 0
    for k, (at, above) in enumerate(zip(feet, heads, strict=True)):
        foot, head = np.array([0.5 * np.cos(at), 0.5 * np.sin(at), 0.0]), np.array([0.3 * np.cos(above), 0.3 * np.sin(above), 0.6])
        leg = drawn.ball(0, foot, (X, Y))
        leg = drawn.joint(leg, foot, (head - foot) / np.linalg.norm(head - foot), slides=True, drives=True)
        if k == 0:
            platform = drawn.ball(leg, head)
        else:
            drawn.loop("spherical", leg, platform, head)
    return drawn.structure()


def leg(rods: int) -> Structure:
    """A leg with 13, 19 or 27 joints: one rod moves the ankle about one axis, two about both; a third moves the knee."""
    drawn, hip, knee, ankle = Drawn(), np.zeros(3), np.array([0.02, 0.0, -0.4]), np.array([0.0, 0.0, -0.8])
    body = drawn.joint(0, hip, Z, drives=True) if rods != 2 else 0
    body = drawn.joint(body, hip, X, drives=True)
    thigh = drawn.joint(body, hip, Y, drives=True)
    shin = drawn.joint(thigh, knee, Y, drives=rods < 3)
    pitch = drawn.joint(shin, ankle, Y)
    foot = drawn.joint(pitch, ankle, X, drives=rods == 1)
    for side in (1.0, -1.0)[: min(rods, 2)]:
        axle, end = beside(knee, -0.02, 0.05 * side, -0.12), beside(ankle, -0.06, 0.045 * side, 0.02)
        crank = drawn.joint(shin, axle, Y, drives=True)
        drawn.rod(crank, beside(axle, -0.06, 0.01 * side, 0.005), foot if rods > 1 else pitch, end)
    if rods == 3:
        axle = beside(hip, 0.03, 0.04, -0.1)
        crank = drawn.joint(thigh, axle, Y, drives=True)
        drawn.rod(crank, beside(axle, 0.07, 0.01, -0.01), shin, beside(knee, 0.06, 0.05, 0.03))
    return drawn.structure()


class Mechanism(NamedTuple):
    """A mechanism by its name."""

    name: str
    structure: Structure


def mechanisms() -> list[Mechanism]:
    """The five mechanisms."""
    return [
        Mechanism("five-bar", five_bar()),
        Mechanism("platform on six legs", six_legs()),
        *(Mechanism(f"leg of {joints} joints", leg(rods)) for rods, joints in ((1, 13), (2, 19), (3, 27))),
    ]
