"""The same linkage with the zeros of its joints elsewhere, drawn open there."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from pinpress.linkage.linkage import Linkage


def with_other_zeros(press: Linkage, offsets: np.ndarray) -> Linkage:
    """The linkage with every coordinate larger by an offset (nv,) [rad or m]: at home where the linkage was drawn."""
    model = press.model.copy()
    for j, (axis, slot, offset) in enumerate(zip(press.axes, press.slots, offsets.tolist(), strict=True), 1):
        back = -offset * axis.direction
        step = pin.SE3(pin.exp3(back), np.zeros(3)) if axis.turns else pin.SE3(np.eye(3), back)
        model.jointPlacements[j] = model.jointPlacements[j] * step
        if not slot.unbounded:
            model.lowerPositionLimit[slot.start] += offset
            model.upperPositionLimit[slot.start] += offset
    relations = tuple(
        replace(each, offset=each.offset + sum(by * offsets[joint] for joint, by in each.coefficients.items())) for each in press.relations
    )
    return replace(press, model=model, relations=relations, home=tuple((press.closed + offsets).tolist()), mounted="test")
