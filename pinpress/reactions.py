"""Inverse dynamics: the driving torque and every bearing and guide force of a motion.

Signs, in one place: forces and moments of a joint are the action of parent on child, of a loop the action of link1 on link2, in world
axes, moments about the origin of the child's joint frame (a loop's about its point; a spherical one transmits none but friction). The
driving torque is positive along the driver's axis; it is part of the driver's bearing moment, as those of gear pairs and friction are of
their bearings'. Shaking force and moment are the action of the machine on its foundation, its weight
included.
"""

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from . import forces, plane_dynamics, spatial_dynamics, tables
from .coordinates import Array, ComplexArray
from .errors import PinpressError, UnknownNameError
from .forces import AppliedForce, Load
from .friction import Friction
from .friction import law as friction_law
from .linkage import Linkage
from .motion import Motion
from .plane import Plane
from .shaking import shaking
from .sharing import compliances
from .wrenches import Wrenches

T = TypeVar("T", bound=np.generic)
NOTHING: Mapping[str, Any] = MappingProxyType({})
STATES_LOOKED_AT = 256  # of a motion, to find what is indeterminate: the rank is the same all along it


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
        driving_torque: (n,) on the driver joint, along its axis [N m]; (n, drivers) where there are several.
        coupling_torque: name of a joint with a ``<mimic>`` -> (n, 2): the torque of the gear pair on it, and on the joint it mimics, along
            their axes [N m; N on one that slides]. A pair alone: the tooth force across the shafts' bearings is not in their forces.
        bearing_force, bearing_moment: name of a joint or loop -> (n, 3) [N, N m].
        friction_power: name of a joint or loop -> (n,) power lost there [W].
        shaking_force: (n, 3) [N]; shaking_moment: (n, 3) about the world origin [N m].
        indeterminate: name -> (6,) bool: components of force (x, y, z) and moment (x, y, z) that rigid mechanics leaves open because a loop
            closes more than it must; shared as `sharing` says, by default with the least sum of squared bearing forces. In a planar press
            whose equations in the plane are all needed they are those along the normal.
        indeterminate_coupling: name of a joint with a ``<mimic>`` -> bool: the same of the gear pair's torque.
    """

    motion: Motion
    engine: str
    driving_torque: Array
    coupling_torque: ByBearing[np.float64]
    bearing_force: ByBearing[np.float64]
    bearing_moment: ByBearing[np.float64]
    friction_power: ByBearing[np.float64]
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

    @property
    def indeterminate(self) -> ByBearing[np.bool_]:
        return ByBearing(self._press.bearings, self._indeterminate[0])

    @property
    def indeterminate_coupling(self) -> ByBearing[np.bool_]:
        return ByBearing(tuple(self.coupling_torque), self._indeterminate[1])

    @cached_property
    def _indeterminate(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        positions = self.motion.joint_position.T
        some = positions[:, :: max(1, positions.shape[1] // STATES_LOOKED_AT)]
        return spatial_dynamics.indeterminate(self._press.spatial, some)

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
        press, motion = self._press, self.motion
        if self.engine == "plane" and press.plane is not None and press.bodies is not None:
            at = _basis(press, press.plane, motion)
            balance, total = plane_dynamics.power_balance(press.plane, press.bodies, at, motion.v.T, motion.a.T, self._applied)
        else:
            balance, total = spatial_dynamics.power_balance(press.spatial, motion.joint_position.T, motion.v.T, motion.a.T, self._applied)
        torque = self.driving_torque.reshape(len(motion.crank_angle), -1).T
        driving, lost = torque * motion.v.T[list(press.spatial.drivers)], self._wrenches.friction.sum(axis=0)
        return balance + driving.sum(axis=0) - lost, total + np.abs(driving).sum(axis=0) + lost

    def columns(self) -> dict[str, Array]:
        """The motion's columns, then torque, shaking force and moment and all bearings', under their names with units."""
        columns = self.motion.columns()
        columns |= tables.by_driver("driving_torque", "N m", self.driving_torque, self.motion.drivers)
        for name, torque in self.coupling_torque.items():
            columns[f"coupling_torque_{name} [N m]"] = torque[:, 0]
        vectors: list[tuple[str, str, Array]] = [("shaking_force", "N", self.shaking_force), ("shaking_moment", "N m", self.shaking_moment)]
        for name in self.bearing_force:
            vectors += [(f"force_{name}", "N", self.bearing_force[name]), (f"moment_{name}", "N m", self.bearing_moment[name])]
        for name, unit, vector in vectors:
            columns |= {f"{name}_{axis} [{unit}]": vector[:, i] for i, axis in enumerate("xyz")}
        for name, power in self.friction_power.items():
            if power.any():
                columns[f"friction_power_{name} [W]"] = power
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


def inverse_dynamics(
    press: Linkage,
    motion: Motion,
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NOTHING,
    stiffness: Mapping[str, float] = NOTHING,
    engine: str = "auto",
) -> Reactions:
    """Driving torque, bearing and guide forces and shaking force of a motion.

    Args:
        loads: forces on links from outside, springs and dampers between links.
        friction: of bearings and guides, by their names.
        stiffness: of bearings and guides, by their names [N/m]: where rigid mechanics leaves open how several share a force, it is shared
            with the least elastic energy (bearings without a stiffness count as rigid), instead of the least sum of squared forces.
        engine: "plane" (all crank angles at once), "pinocchio" (any linkage, one configuration at a time), or "auto": the plane where the
            linkage is planar.

    Raises:
        PinpressError: a motion of a linkage with other joints, a load of wrong shape or with a value that is not finite, friction that
            makes no sense or locks the linkage, a stiffness that is not positive.
        UnknownNameError: a bearing or link that the linkage does not have.
        AssemblyError: a motion of a linkage with other lengths.
    """
    if motion.joints != press.joints or motion.drivers != press.drivers:
        raise PinpressError(f"the motion is of {motion.linkage} with other joints than {press.name}: make it with cycle(press, ...)")
    plane = press.planar(engine)
    if isinstance(loads, Load):
        raise PinpressError(f"loads is one {type(loads).__name__}: give a list, loads=[...]")
    law, compliance = friction_law(friction, press), compliances(stiffness, press)
    with np.errstate(all="ignore"):  # what overflows is refused below
        applied = forces.apply(loads, press, motion)
        if plane is not None and press.bodies is not None:
            at = _basis(press, plane, motion)
            wrenches = plane_dynamics.inverse_dynamics(
                plane, press.bodies, at, motion.v.T, motion.a.T, applied, motion.crank_angle, law, compliance
            )
        else:
            position = motion.joint_position.T
            wrenches = spatial_dynamics.inverse_dynamics(press.spatial, position, motion.v.T, motion.a.T, applied, law, compliance)
        _refuse_not_finite(motion, wrenches)
    names, several = press.bearings, len(press.drivers) > 1
    wrenches.torque.setflags(write=False)
    pairs = [np.stack([torque, -c.multiplier * torque], axis=1) for c, torque in zip(press.couplings, wrenches.coupling, strict=True)]
    return Reactions(
        motion=motion,
        engine="pinocchio" if plane is None else "plane",
        driving_torque=wrenches.torque.T if several else wrenches.torque[0],
        coupling_torque=ByBearing(tuple(c.name for c in press.couplings), np.array(pairs)),
        bearing_force=ByBearing(names, wrenches.force),
        bearing_moment=ByBearing(names, wrenches.moment),
        friction_power=ByBearing(names, wrenches.friction),
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
            states = np.moveaxis(array, 1, 0)
            at = int(np.argmin(np.isfinite(states.reshape(len(states), -1)).all(axis=1)))
            angle = np.degrees(np.ravel(motion.crank_angle[at])[0])
            raise PinpressError(
                f"the {name} of {motion.linkage} is not finite at crank angle {angle:.6g} deg:"
                " the motion or a load is too large for floating point"
            )
