"""A press whose slide hangs on only one of its points, without the other chains.

If 1 N on the slide puts no force on a loop, the other loops alone determine the slide's motion, and the slide moves as before without this
loop. Joints that only such loops determined are locked.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError
from ..derivatives.motion import Displacements
from ..engines.structure import configuration
from ..linkage.linkage import Linkage
from .virtual_work import UnitForces

CARRIES = 1e-6  # a loop with more than this share of the largest force carries the slide


class SingleChain(NamedTuple):
    """One chain of a press, as a separate press; ``joints`` and ``loops``: indices of its joints (in v) and loops in the whole press."""

    press: Linkage
    joints: list[int]
    loops: list[int]

    @staticmethod
    def of(press: Linkage, unit: UnitForces, point: str) -> SingleChain:
        """The chain that carries the unit forces of a point.

        Raises:
            PinpressError: the loops of this chain do not determine the slide's motion.
        """
        largest = max(float(np.abs(force).max()) for force in unit.force.values())
        loops = [k for k, loop in enumerate(press.loops) if float(np.abs(unit.force[loop.name]).max()) > CARRIES * largest]
        joints = _kept_joints(press, loops)
        model, locked = press.model, [joint + 1 for joint in range(press.model.nv) if joint not in joints]
        ends = [end for k in loops for end in (press.loops[k].joint1, press.loops[k].joint2)]
        if any(place in locked for place in (*ends, *(model.parents[joint + 1] for joint in joints))):
            raise _no_chain(press, point)
        reduced = pin.buildReducedModel(model, locked, configuration(press.slots, press.closed))
        index = {joint: place for place, joint in enumerate(joints)}
        new = {0: 0} | {joint + 1: place + 1 for joint, place in index.items()}
        alone = replace(
            press,
            model=reduced,
            loops=tuple(replace(press.loops[k], joint1=new[press.loops[k].joint1], joint2=new[press.loops[k].joint2]) for k in loops),
            relations=tuple(
                replace(relation, coefficients={index[joint]: by for joint, by in relation.coefficients.items()})
                for relation in press.relations
                if relation.coefficients.keys() <= index.keys()
            ),
            held_spins=tuple(name for name in press.held_spins if press.joints.index(name) in index),
        )
        if not alone.assembly.determined:
            raise _no_chain(press, point)
        return SingleChain(alone, joints, loops)

    def displacements(self, moved: Displacements) -> Displacements:
        """Displacements of the whole press, in this chain."""
        return Displacements(moved.joints[self.joints], moved.ends[self.loops])


def _kept_joints(press: Linkage, loops: list[int]) -> list[int]:
    """Rising indices in v of the drivers, the slide's guide, the joints on these loops, and those that gears couple to them."""
    indices = {*press.driver_indices, press.slide_guide.joint}
    indices.update(joint for k in loops for joint in press.structure.joints_of_loop[k])
    while more := {joint for relation in press.relations for joint in relation.coefficients if relation.joint in indices} - indices:
        indices |= more
    return sorted(indices)


def _no_chain(press: Linkage, point: str) -> PinpressError:
    return PinpressError(
        f"point {point!r} of {press.name} alone does not hold the slide, so it has no separate chain: parallelism needs a chain for each"
        " point"
    )
