"""What a process load is: intervals of force over the slide's height, and the datum that heights are measured from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.parameters import parameter as parameter  # named in pinpress.loads

if TYPE_CHECKING:
    from ..linkage.linkage import Linkage

Law = Callable[[Any, Any], Any]  # of numbers a number, of arrays an array


@dataclass(frozen=True)
class ForceInterval:
    """One smooth interval of a process force, in one direction of travel.

    Attributes:
        upper: height up to which it acts, lower < height <= upper [m]; may be infinite.
        lower: height from which it acts [m]; may be infinite.
        force: law of height [m] and velocity along the axis [m/s] that returns the force on the slide along the axis [N]. Of numbers it
            gives a number, or (S,) where the load has scenarios; of arrays (..., S) the same shape. It is smooth, a little beyond the
            interval too.
        one_sided: whether it is a contact: where the law gives less than zero the contact is lost, and the force is zero.
    """

    upper: float
    lower: float
    force: Law
    one_sided: bool = False


@runtime_checkable
class ProcessLoad(Protocol):
    """A force between slide and bolster. Any class with these two members is one.

    Its intervals are the same whenever they are asked for, and their forces depend on height, velocity and direction of travel alone.
    """

    @property
    def datum(self) -> float | None:
        """Slide position from which heights are measured [m]; None for that of bottom dead centre."""

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        """The intervals on the way down (against the guide's axis) or up; disjoint, no force outside them."""


@typed
def datum(load: ProcessLoad, press: Linkage) -> float:
    """Slide position from which the heights of a load are measured [m].

    Raises:
        PinpressError: the linkage has no slide, or neither it has a bottom dead centre nor the load a datum.
    """
    from ..kinematics.dead_centres import dead_centres  # imports the linkage, whose dynamics imports the loads

    if not isinstance(load, ProcessLoad) or isinstance(load, type):
        raise PinpressError(f"load is a {type(load).__name__}: give a process load")
    _ = press.slide_guide
    if load.datum is not None:
        return load.datum
    try:
        return dead_centres(press).bottom_position
    except PinpressError as error:
        raise PinpressError(
            f"{type(load).__name__}: {press.name} has no bottom dead centre to measure heights from ({error});"
            " give datum=, a slide position [m]"
        ) from error
