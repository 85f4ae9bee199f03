"""What objectives and constraints of a synthesis see: the press with one set of variables, its motion and its reactions.

An objective is a plain NumPy function of a `Trial`. Its exact gradient is found by a complex step: for every variable the function is
called once with a trial whose arrays are complex, value + i h derivative with h so small that h^2 is nothing. The imaginary part of what it
returns is then h times its derivative. The derivatives of motion and reactions are exact (`pinpress.derivatives`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from ..common.arrays import Array
from ..common.errors import PinpressError, UnknownNameError
from ..common.frozen import Frozen, read_only
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage

SHARED = "several bearings share forces that rigid mechanics leaves open, so derivatives of these are not known: use driving_torque"
OUT_OF_PLANE = "the links lie in several planes, so the derivatives of moments are not known: use forces or driving_torque"


@dataclass(frozen=True, eq=False, repr=False)
class TrialReactions(Frozen):
    """Reactions of a trial, with the names, signs and units of `Reactions`.

    Attributes:
        driving_torque: (n,) [N m].
        shaking_force: (n, 3) [N].
    """

    driving_torque: Array
    shaking_force: Array
    _bearing_force: Mapping[str, Array] | None
    _bearing_moment: Mapping[str, Array] | None
    _shaking_moment: Array | None

    @property
    def bearing_force(self) -> Mapping[str, Array]:
        """Name of a joint or loop -> (n, 3) force [N].

        Raises:
            PinpressError: in a gradient of a linkage in which several bearings share forces.
        """
        if self._bearing_force is None:
            raise PinpressError(SHARED)
        return self._bearing_force

    @property
    def bearing_moment(self) -> Mapping[str, Array]:
        """Name of a joint or loop -> (n, 3) moment [N m].

        Raises:
            PinpressError: in a gradient of a linkage in which several bearings share forces, or whose links lie in several planes.
        """
        if self._bearing_moment is None:
            raise PinpressError(SHARED if self._bearing_force is None else OUT_OF_PLANE)
        return self._bearing_moment

    @property
    def shaking_moment(self) -> Array:
        """(n, 3) about the world origin [N m].

        Raises:
            PinpressError: in a gradient of a linkage whose links lie in several planes.
        """
        if self._shaking_moment is None:
            raise PinpressError(OUT_OF_PLANE)
        return self._shaking_moment


@dataclass(frozen=True, eq=False, repr=False)
class Trial(Frozen):
    """A press with one set of variables, as objectives and constraints see it.

    Its arrays are complex where a gradient is worked out. Write a function of a trial with NumPy's arithmetic, sums, ``min``, ``max``,
    ``ptp``, ``sqrt``, ``sin`` and the like, which take complex numbers, and compare real parts. Instead of ``abs(x)``, ``hypot`` and
    ``arctan2`` write ``np.where(x.real < 0, -x, x)``,
    ``np.sqrt(x * x + y * y)`` and ``np.arctan(y / x)``. `synthesise` refuses a function whose gradient is not that of its values.

    Attributes:
        variables: name -> value [SI].
        motion: over one period at constant speed; see `cycle`.
        positions: name of a bearing -> (n, 3) its world position [m].
    """

    variables: Mapping[str, float]
    motion: Motion
    positions: Positions
    _press: Callable[[], Linkage]
    _reactions: Callable[[], TrialReactions]

    @cached_property
    def press(self) -> Linkage:
        """The press itself; its numbers are real in a gradient too."""
        return self._press()

    @cached_property
    def reactions(self) -> TrialReactions:
        """The reactions of the press, worked out when they are first asked for."""
        return self._reactions()


class Positions(Mapping[str, Array]):
    """World positions (n, 3) of bearings by their names, worked out when they are asked for."""

    def __init__(self, names: Sequence[str], at: Callable[[int], Array]) -> None:
        self._names, self._at = names, at

    def __getitem__(self, name: str) -> Array:
        if name not in self._names:
            raise UnknownNameError("bearing", name, self._names)
        return read_only(self._at(self._names.index(name)))

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
