"""Inverse dynamics: the driving torque and every bearing and guide force of a motion.

Signs, in one place: forces and moments of a joint are the action of parent on child, of a loop the action of link1 on link2, in world
axes, moments about the origin of the child's joint frame (a loop's pin transmits none). The driving torque is positive along the driver's
axis and is part of the driver's bearing moment. Shaking force and moment are the action of the machine on its foundation, its weight
included.
"""

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from . import loads as loads_module
from . import plane_dynamics, spatial, tables
from .coordinates import Array, ComplexArray
from .errors import PinpressError, UnknownNameError
from .linkage import Linkage
from .loads import AppliedForce, PointForce
from .motion import Motion
from .plane import Plane
from .shaking import shaking
from .wrenches import Wrenches

T = TypeVar("T", bound=np.generic)


class ByBearing(Mapping[str, NDArray[T]]):
    """Read-only mapping from the names of joints and loops to arrays; an unknown name is a `PinpressError` that lists the known ones."""

    def __init__(self, names: tuple[str, ...], values: NDArray[T]) -> None:
        values.setflags(write=False)
        self._names, self._values = names, values

    def __getitem__(self, name: str) -> NDArray[T]:
        if name not in self._names:
            raise UnknownNameError("bearing", name, self._names)
        values: NDArray[T] = self._values[self._names.index(name)]
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


@dataclass(frozen=True, eq=False, repr=False)
class Reactions:
    """Torque and forces over a motion of n states. All arrays are read-only; signs: see the module.

    Attributes:
        motion: the motion. engine: "plane" or "pinocchio".
        driving_torque: (n,) on the driver joint, along its axis [N m].
        bearing_force, bearing_moment: name of a joint or loop -> (n, 3) [N, N m].
        shaking_force: (n, 3) [N]; shaking_moment: (n, 3) about the world origin [N m].
        indeterminate: name -> (6,) bool: components of force (x, y, z) and moment (x, y, z) that rigid mechanics leaves open because a loop
            closes more than it must; given as those with the least sum of squared bearing forces. Along the normal in a planar press.
    """

    motion: Motion
    engine: str
    driving_torque: Array
    bearing_force: ByBearing[np.float64]
    bearing_moment: ByBearing[np.float64]
    _wrenches: Wrenches
    _press: Linkage
    _applied: list[AppliedForce]

    def __repr__(self) -> str:
        return f"<Reactions of {self._press.name}: {len(self.driving_torque)} states, bearings {', '.join(self.bearing_force)}>"

    @cached_property
    def power_residual(self) -> Array:
        """(n,) power of drive and loads less d/dt (kinetic + potential energy), relative to the motion's largest sum of absolute powers.

        Computed when it is first asked for, from the bodies' velocities and accelerations, independently of the torque's own recursion.
        """
        with np.errstate(all="ignore"):  # what overflows is refused below
            balance, total = self._power_balance()
        largest = total.max()
        if not np.isfinite(largest):
            raise PinpressError(f"the powers of {self._press.name} are too large for floating point: lower speed or loads")
        residual = balance / largest if largest > 0 else np.zeros_like(balance)  # at rest nothing flows
        residual.setflags(write=False)
        return np.asarray(residual)

    @cached_property
    def indeterminate(self) -> ByBearing[np.bool_]:
        if self.engine == "plane" and self._press.bodies is not None:
            return ByBearing(self._press.bearings, self._press.bodies.indeterminate)
        return ByBearing(self._press.bearings, spatial.indeterminate(self._press.spatial, self.motion.q.T))

    @property
    def shaking_force(self) -> Array:
        return self._shaking[0]

    @property
    def shaking_moment(self) -> Array:
        return self._shaking[1]

    @cached_property
    def _shaking(self) -> tuple[Array, Array]:
        with np.errstate(all="ignore"):  # what overflows is refused below
            force, moment = shaking(self._press, self.motion, self._wrenches.force, self._wrenches.moment, self._applied)
            if not math.isfinite(force.sum() + moment.sum()):
                raise PinpressError(f"the shaking moment of {self._press.name} is not finite: a load is too large for floating point")
        for array in (force, moment):
            array.setflags(write=False)
        return force, moment

    def _power_balance(self) -> tuple[Array, Array]:
        press, motion, torque = self._press, self.motion, self.driving_torque
        if self.engine == "plane" and press.plane is not None and press.bodies is not None:
            at = _basis(press, press.plane, motion)
            return plane_dynamics.power_balance(press.plane, press.bodies, at, motion.v.T, motion.a.T, torque, self._applied)
        return spatial.power_balance(press.spatial, motion.q.T, motion.v.T, motion.a.T, torque, self._applied)

    def columns(self) -> dict[str, Array]:
        """The motion's columns, then torque, shaking force and moment and all bearings', under their names with units."""
        columns = self.motion.columns()
        columns["driving_torque [N m]"] = self.driving_torque
        vectors: list[tuple[str, str, Array]] = [("shaking_force", "N", self.shaking_force), ("shaking_moment", "N m", self.shaking_moment)]
        for name in self.bearing_force:
            vectors += [(f"force_{name}", "N", self.bearing_force[name]), (f"moment_{name}", "N m", self.bearing_moment[name])]
        for name, unit, vector in vectors:
            columns |= {f"{name}_{axis} [{unit}]": vector[:, i] for i, axis in enumerate("xyz")}
        return columns

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the columns, one state a line, full precision, units in the header."""
        tables.write_csv(path, self.columns())

    def to_frame(self) -> "tables.DataFrame":
        """The columns as a pandas DataFrame."""
        return tables.frame(self.columns())

    def to_mat(self, path: str | os.PathLike[str]) -> None:
        """Write a MATLAB file with one vector a column; names without units."""
        tables.write_mat(path, self.columns())


def inverse_dynamics(press: Linkage, motion: Motion, loads: Sequence[PointForce] = (), engine: str = "auto") -> Reactions:
    """Driving torque, bearing and guide forces and shaking force of a motion.

    Args:
        loads: forces on links from outside.
        engine: "plane" (all crank angles at once), "pinocchio" (any linkage, one configuration at a time), or "auto": the plane where the
            linkage is planar.

    Raises:
        PinpressError: a motion of a linkage with other joints, a load of wrong shape or with a value that is not finite.
        AssemblyError: a motion of a linkage with other lengths.
    """
    if motion.joints != press.joints or motion.driver != press.driver:
        raise PinpressError(f"the motion is of {motion.linkage} with other joints than {press.name}: make it with cycle(press, ...)")
    plane = press.planar(engine)
    if isinstance(loads, PointForce):
        raise PinpressError("loads is one PointForce: give a list, loads=[...]")
    applied = loads_module.apply(loads, press, motion)
    with np.errstate(all="ignore"):  # what overflows is refused below
        if plane is not None and press.bodies is not None:
            at = _basis(press, plane, motion)
            wrenches = plane_dynamics.inverse_dynamics(plane, press.bodies, at, motion.v.T, motion.a.T, applied)
        else:
            wrenches = spatial.inverse_dynamics(press.spatial, motion.q.T, motion.v.T, motion.a.T, applied)
        _refuse_not_finite(motion, wrenches)
    names = press.bearings
    wrenches.torque.setflags(write=False)
    return Reactions(
        motion=motion,
        engine="pinocchio" if plane is None else "plane",
        driving_torque=wrenches.torque,
        bearing_force=ByBearing(names, wrenches.force),
        bearing_moment=ByBearing(names, wrenches.moment),
        _wrenches=wrenches,
        _press=press,
        _applied=applied,
    )


def _basis(press: Linkage, plane: Plane, motion: Motion) -> ComplexArray:
    at = motion.basis(press)
    return plane_dynamics.closed_basis(plane, motion.joint_position.T) if at is None else at


def _refuse_not_finite(motion: Motion, wrenches: Wrenches) -> None:
    """Raise where anything is not finite. A sum is not where a term is not, and costs a pass less than looking at each."""
    if math.isfinite(wrenches.force.sum() + wrenches.moment.sum()):  # the torque is among the moments
        return
    arrays = {
        "driving torque": wrenches.torque,
        "bearing force": wrenches.force,
        "bearing moment": wrenches.moment,
    }
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            states = np.moveaxis(array, -2, 0) if array.ndim > 1 else array
            at = int(np.argmin(np.isfinite(states.reshape(len(states), -1)).all(axis=1)))
            raise PinpressError(
                f"the {name} of {motion.linkage} is not finite at crank angle {np.degrees(motion.crank_angle[at]):.6g} deg:"
                " the motion or a load is too large for floating point"
            )
