"""The chain of one point of a slide on several points, without the other chains.

If 1 N on the slide puts no force on a loop, the other loops alone determine the slide's motion, and the slide moves as before without this
loop. Joints that only such loops determined are locked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError
from ..common.quantities import Array
from ..derivatives.motion import Displacements
from ..engines.structure import configuration
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from .sets_of_lengths.endings import Ending, shapes_of, sound
from .sets_of_lengths.shapes import Shapes
from .virtual_work import unit_forces

ALONE = 1e-6  # a point or loop with a smaller share of the largest force does not carry the slide


class Chain(NamedTuple):
    """The height of a point of a slide by the m dimensions of its chain.

    Attributes:
        dimensions: indices of these dimensions among all dimensions.
        slopes: (m, n) derivatives of the height by the dimensions, in the states of a motion.
        shapes: the chain alone; None without dimensions.
        ending: the crank of the chain at bottom dead centre.
    """

    dimensions: list[int]
    slopes: Array
    shapes: Shapes | None
    ending: Ending

    @staticmethod
    def of(press: Linkage, motion: Motion, points: Sequence[str], point: str, which: list[int], moved: Sequence[Displacements]) -> Chain:
        """The chain of a point.

        Args:
            press: the press.
            motion: a motion that ends at bottom dead centre.
            points: all points of the slide.
            point: the point.
            which: indices of the dimensions of the chain.
            moved: displacements of the pivots per unit of all dimensions.

        Raises:
            PinpressError: the point alone does not hold the slide.
        """
        refusal = PinpressError(
            f"point {point!r} of {press.name} alone does not hold the slide, so it has no separate chain: parallelism needs a chain for"
            " each point"
        )
        # With 1 N/m at the other points all other parts are rigid, so this point alone carries.
        unit = unit_forces(press, motion, stiffness={other: 1.0 for other in points if other != point})
        sizes = {name: float(np.abs(force).max()) for name, force in unit.force.items()}
        if not max(sizes[other] for other in points if other != point) < ALONE * sizes[point]:
            raise refusal
        slopes = np.array([unit.shift(moved[k]) for k in which]).reshape(len(which), len(motion.v))
        loops = [k for k, loop in enumerate(press.loops) if sizes[loop.name] > ALONE * max(sizes.values())]
        joints = _kept_joints(press, loops)
        alone = _reduced(press, joints, loops)
        if alone is None or not alone.assembly.determined:
            raise refusal
        shapes = shapes_of(alone, [Displacements(moved[k].joints[joints], moved[k].ends[loops]) for k in which]) if which else None
        return Chain(which, slopes, shapes, Ending(motion.joint_position[-1][joints], np.zeros(len(which)), "held"))

    def heights(self, deviations: Array) -> Array:
        """Deviations (n,) of the point's height at bottom dead centre from the nominal press, for all dimensions off by (k, n) [m].

        Raises:
            PinpressError: some of these presses cannot be closed there.
        """
        if self.shapes is None:
            return np.zeros(deviations.shape[1])
        nominal = self.shapes.position(self.ending.start[:, None], np.zeros((len(self.dimensions), 1)))
        return sound(self.shapes, deviations[self.dimensions], self.ending, "at bottom dead centre").position - nominal


def _kept_joints(press: Linkage, loops: list[int]) -> list[int]:
    """Rising indices in v of the drivers, the slide's guide, the joints on these loops, and those that gears and cams couple to them."""
    indices = {*press.driver_indices, press.slide_guide.joint}
    indices.update(joint for k in loops for joint in press.structure.joints_of_loop[k])
    while more := {joint for relation in press.relations for joint in relation.joints if relation.joint in indices} - indices:
        indices |= more
    return sorted(indices)


def _reduced(press: Linkage, joints: list[int], loops: list[int]) -> Linkage | None:
    """The press with these joints (in v) and loops alone; None if one of them is on a link that no other joint carries."""
    index = {joint: place for place, joint in enumerate(joints)}
    new = {0: 0} | {joint + 1: place + 1 for joint, place in index.items()}
    kept = [press.loops[k] for k in loops]
    if any(body not in new for loop in kept for body in (loop.joint1, loop.joint2)) or any(
        press.model.parents[joint + 1] not in new for joint in joints
    ):
        return None
    locked = [body for body in range(1, press.model.njoints) if body not in new]
    return replace(
        press,
        model=pin.buildReducedModel(press.model, locked, configuration(press.slots, press.closed)),
        loops=tuple(replace(loop, joint1=new[loop.joint1], joint2=new[loop.joint2]) for loop in kept),
        relations=tuple(relation.between(index) for relation in press.relations if index.keys() >= {*relation.joints}),
        contacts=(),  # positions alone are asked of it
        held=tuple(name for name in press.held if press.joints.index(name) in index),
        home=tuple(press.home[joint] for joint in joints) if press.home else (),
    )
