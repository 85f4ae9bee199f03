"""Torques and forces over a motion, and their signs.

`Reactions` says the signs. A spherical loop transmits only the moment of friction. The driving torque is part of the moment of the driver's
bearing, and the torques of gear pairs and friction are part of the moments of bearings. The forces of teeth and threads (of machine
elements, and of a shaft that moves a slide) belong to no bearing: they load the bearings, see `engines.machine_elements.forces`.
"""

from __future__ import annotations

import contextlib
import importlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common import tables
from ..common.errors import PinpressError, sendable
from ..common.frozen import FrozenMapping, NamedArrays, read_only
from ..common.quantities import Array
from ..common.results import Tabular
from ..engines.energies import power_balance
from ..engines.engine import Engine
from ..engines.machine_elements.forces import indeterminate, inverse_dynamics
from ..engines.wrenches import AppliedConditions, Wrenches
from ..kinematics.motion import MOST_IN_TITLE, Motion, blank, filled
from ..linkage.linkage import Linkage
from ..loads.link import Friction, LinkLoad, Load
from . import applied_loads
from .between import Path, path_of
from .shaking import shaking
from .teeth import ToothForces, tooth_forces

BETWEEN = ("_path", "_between", "_peaks", "_over_time")  # what `extremes` keeps of reactions between their states
ROUNDED = 1e-6  # share of the magnitudes of forces times those of velocities above which a power is clearly no rounding


@dataclass(frozen=True, eq=False, repr=False)
class Reactions(Tabular):
    """Torques and forces over a motion of n states. All arrays are read-only.

    Forces and moments of a joint are the action of parent on child, of a loop the action of link1 on link2, in world axes. Moments are
    about the origin of the child's joint frame, those of a loop about its point. Shaking force and moment are the action of the machine on
    its foundation, weight included. The driving torque is positive along the driver's axis, and is part of the moment of the driver's
    bearing.

    Attributes:
        motion: the motion.
        engine: "plane", "space" or "pinocchio".
        loads: the loads as they were given. In a pickled copy, one that cannot be pickled is its description.
        friction: the friction of bearings and guides as it was given.
        stiffness: the stiffnesses of bearings and guides as they were given [N/m].
        passive: what the passive coordinates of the linkage do, as it was given: "free", "given" or "equilibrium".
        driving_torque: (n,) torque on the driver joint along its axis [N m], force on one that slides [N]; (n, drivers) for several
            drivers, motors first. At passive coordinates it is rounding where they are free, else what holds them.
        coupling_torque: (n, 2) by the name of a joint with a ``<mimic>``: torques of the gear pair on this joint and on the joint it
            mimics, along their axes [N m; N on a joint that slides]. Where no bearings were asked for, they are computed when they are
            first read. Forces between the teeth of two shafts are left out of the shafts' bearings; those of a machine element (such as
            ``<gear_mesh>``), and of a shaft and a slide, are in them. Of a machine element that relates two joints it stands under its
            name, on the joint that the element determines and on the other one.
        bearing_force: (n, 3) by the names of the joints, loops and machine elements that were asked for [N]; of a machine element the force
            of its first on its second link at the point where they touch; with planets the force of one planet.
        bearing_moment: (n, 3) by the same names [N m]; of a machine element about the point where its links touch.
        left_out: names of the joints, loops and machine elements that were not asked for.
        friction_power: (n,) power lost, by the names of all joints, loops and machine elements [W].
        shaking_force: (n, 3) [N]. It is computed when it is first read, from the bearings on the frame, even if they were left out.
        shaking_moment: (n, 3) about the world origin [N m], computed with the shaking force.
        held_moment: (n,) by the names of the held joints (`Linkage.held`): torque that holds the spin, along the joint's axis [N m; N
            on a joint that slides]. It is rounding where nothing turns the link.
        indeterminate: (6,) bool by the names of all joints, loops and machine elements: which components of force and moment, three each,
            rigid mechanics leaves open because of redundant constraints. They are shared by least squares, by default with the least sum of
            squared bearing forces. In a planar press without redundant equations in its plane they are the forces along the normal and the
            tilting moments.
        indeterminate_axes: (3, 3) directions of these components, as rows: world x, y, z; for a planar linkage whose normal is no world
            axis the horizontal in the plane, the normal, and the upward direction in the plane.
        indeterminate_coupling: bool by the name of a joint with a ``<mimic>``: whether rigid mechanics leaves the gear pair's torque open.
    """

    motion: Motion
    engine: str
    loads: tuple[Load, ...]
    friction: Mapping[str, Friction]
    stiffness: Mapping[str, float]
    passive: str
    driving_torque: Array
    bearing_force: NamedArrays[np.float64]
    bearing_moment: NamedArrays[np.float64]
    friction_power: NamedArrays[np.float64]
    left_out: tuple[str, ...]
    _wrenches: Wrenches
    _press: Linkage
    _conditions: AppliedConditions

    @property
    def title(self) -> str:
        extremes = importlib.import_module(".extremes", __package__)  # it stands on this module, as `described` of each result does
        with contextlib.suppress(PinpressError):  # forces that are not finite have no peaks
            return f"Reactions of {self._press.name}: {len(self.driving_torque)} states, {extremes.at_peaks(self).reactions._in_words()}"
        return f"Reactions of {self._press.name}: {len(self.driving_torque)} states, {self._in_words()}"

    def _in_words(self) -> str:
        """Ranges of torques and forces of the drivers, and the largest bearing force."""
        sizes = {name: float(np.linalg.norm(force, axis=1).max()) for name, force in self.bearing_force.items()}
        worst = max(sizes, key=lambda name: sizes[name], default=None)
        force = "bearings left out" if worst is None else f"largest bearing force {sizes[worst]:.6g} N in {worst}"
        return f"{self._driving_in_words()}, {force}"

    def _driving_in_words(self) -> str:
        """Between which torques or forces every driver is driven; of many drivers how many there are."""
        free = self._press.passive if self.passive == "free" else ()
        coordinates, drivers = self.motion.driver_coordinates, [name for name in self.motion.drivers if name not in free]
        if len(drivers) > MOST_IN_TITLE:
            return f"{len(drivers)} drivers"
        efforts = np.reshape(self.driving_torque, (-1, len(coordinates))).T
        of = [f" of {driver}" for driver in drivers] if len(drivers) > 1 else [""] * len(drivers)
        return ", ".join(
            f"driving {each.effort}{name} {effort.min():.6g} to {effort.max():.6g} {each.effort_unit}"
            for each, name, effort in zip(coordinates, of, efforts, strict=False)  # motors are the first
        )

    @cached_property
    def coupling_torque(self) -> NamedArrays[np.float64]:
        press = self._press
        pairs = [k for k, relation in enumerate(press.relations) if relation.is_pair]
        torques = blank(self.motion, self._complete.relations[pairs], 1) if pairs else ()
        by_pair = [np.stack([torque, -pair.multiplier * torque], axis=1) for pair, torque in zip(press.couplings, torques, strict=True)]
        return NamedArrays(tuple(pair.name for pair in press.couplings), np.array(by_pair))

    @cached_property
    def held_moment(self) -> NamedArrays[np.float64]:
        names, first = self._press.held, len(self._press.relations)
        return NamedArrays(names, blank(self.motion, self._complete.relations[first:], 1) if names else np.empty((0, len(self.motion.v))))

    @cached_property
    def power_residual(self) -> Array:
        """(n,) error of the power balance: power of drives and loads less friction and less d/dt (kinetic + potential energy), relative to
        the motion's largest sum of absolute powers [-].

        Where all powers are rounding (a balanced disc, a press kept in its dead centre), it is relative to a millionth of the sum of
        magnitudes of forces times those of velocities. It is computed when it is first read, from velocities and accelerations of the
        bodies, independently of the balance of forces that gives the torque.

        Raises:
            PinpressError: the powers are too large for floating point.
        """
        with np.errstate(all="ignore"):  # what overflows is refused below
            balance, total, apparent = self._power_balance()
        largest = max(total.max(), ROUNDED * apparent.max(), 1e-290)  # smaller numbers have fewer digits [W]
        if not np.isfinite(largest):
            raise PinpressError(f"the powers of {self._press.name} are too large for floating point: lower speed or loads")
        return np.asarray(read_only(blank(self.motion, balance / largest)))

    @cached_property
    def process_force(self) -> Array:
        """(n,) sum of the process loads and forces in time on the slide along its guide's axis [N]; positive resists the working stroke."""
        return read_only(blank(self.motion, applied_loads.process_force(self.loads, self._press, self._filled)))

    @cached_property
    def process_work(self) -> float:
        """Work that the slide does against the process loads and forces in time over the motion [J], over a whole period of a `cycle`.

        It is an integral over time between the edges of the loads. Of a motion that is known only in its states, the laws are integrated
        over the height between the states.
        """

        def power(motion: Motion) -> Iterator[tuple[Array, float]]:
            force = applied_loads.process_force(self.loads, self._press, motion)
            yield (-force * motion.slide_velocity)[:, None], 0.0

        if all(isinstance(load, LinkLoad) for load in self.loads):
            return 0.0
        resolved = None if self._path is None else self._path.resolve(power)
        if resolved is None:
            return float(applied_loads.process_work(self.loads, self._press, self.motion).sum())
        return float(resolved.panels.integrals()[0])

    @cached_property
    def _path(self) -> Path | None:
        """The motion between its states; None if nothing is known there."""
        return path_of(self.motion, self._press, self.loads, self.friction, self.engine)

    @cached_property
    def _largest_force(self) -> float:
        """The largest component of all bearing forces [N]; not finite where one of them is not."""
        return float(np.max([np.abs(force).max(initial=0.0) for force in self.bearing_force.values()], initial=0.0))

    def __getstate__(self) -> dict[str, Any]:
        """The state for copies and pickles."""
        loads = tuple(sendable(load) for load in self.loads)
        if any(isinstance(load, str) for load in loads):
            _ = self.process_force, self.process_work  # they cannot be computed from descriptions
        kept = {name: value for name, value in vars(self).items() if name not in BETWEEN}  # a copy finds them again
        return kept | {"loads": loads}

    @property
    def indeterminate(self) -> NamedArrays[np.bool_]:
        names = carrying(self._press)
        return NamedArrays(names, self._indeterminate[0][: len(names)])

    @property
    def mesh(self) -> Mapping[str, ToothForces]:
        """Tangential, radial and axial forces (n,) of the first on the second link, and the power lost in the teeth, by the names of the
        machine elements except cams that were asked for; see `ToothForces`."""
        asked = [each for each in self._press.contacts if each.name in self.bearing_force and each.kind != "cam"]
        found = ((c.name, self.bearing_force[c.name], self.friction_power[c.name], c) for c in asked)
        return FrozenMapping({name: tooth_forces(self._press, self.motion, c, force, power) for name, force, power, c in found})

    @property
    def indeterminate_coupling(self) -> NamedArrays[np.bool_]:
        pairs = [(k, relation.name) for k, relation in enumerate(self._press.relations) if relation.is_pair]
        return NamedArrays(tuple(name for _, name in pairs), self._indeterminate[1][[k for k, _ in pairs]])

    @cached_property
    def indeterminate_axes(self) -> Array:
        return read_only(self._press.planarity.axes)

    @cached_property
    def _indeterminate(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        positions, press = self._filled.joint_position.T, self._press
        # 256 states are enough: the rank hardly changes along a motion.
        some = positions[:, :: max(1, positions.shape[1] // 256)]
        return indeterminate(press.engine(self.engine), some, self.indeterminate_axes)

    @property
    def shaking_force(self) -> Array:
        return self._shaking[0]

    @property
    def shaking_moment(self) -> Array:
        return self._shaking[1]

    @property
    def _filled(self) -> Motion:
        """The motion as it was computed."""
        return filled(self._press, self.motion)

    @cached_property
    def _complete(self) -> Wrenches:
        """The wrenches of all bearings, found now where all were left out."""
        if len(self._wrenches.force):
            return self._wrenches
        with np.errstate(all="ignore"):  # what overflows is refused
            return find_wrenches(self._press, self._press.engine(self.engine), self._filled, self._conditions, bearings=True)

    @cached_property
    def _shaking(self) -> tuple[Array, Array]:
        press, wrenches = self._press, self._complete
        with np.errstate(all="ignore"):  # what overflows is refused below
            force, moment = shaking(press, self._filled, wrenches, self._conditions.loads)
            if not math.isfinite(force.sum() + moment.sum()):
                raise PinpressError(f"the shaking moment of {self._press.name} is not finite: a load is too large for floating point")
        return read_only((blank(self.motion, force), blank(self.motion, moment)))

    def _power_balance(self) -> tuple[Array, Array, Array]:
        press, motion = self._press, self._filled
        balance, total, apparent = power_balance(press.engine(self.engine), motion.states(press), self._conditions.loads)
        torque = np.nan_to_num(self.driving_torque).reshape(len(motion.crank_angle), -1).T  # of states that are not valid 0
        if self._conditions.efforts is not None:
            supplied = self._conditions.efforts * motion.v.T
            balance, total = balance + supplied.sum(axis=0), total + np.abs(supplied).sum(axis=0)
        driving, lost = torque * motion.v.T[list(press.driver_indices)], self._wrenches.friction.sum(axis=0)
        return balance + driving.sum(axis=0) - lost, total + np.abs(driving).sum(axis=0) + lost, apparent

    @property
    def _driving(self) -> dict[str, Array]:
        """The columns of the driving torques."""
        efforts = [(f"driving_{each.effort}", each.effort_unit) for each in self.motion.driver_coordinates]
        return tables.by_driver(efforts, self.driving_torque, self.motion.drivers)

    def columns(self) -> dict[str, Array]:
        """The motion's columns, then torques, shaking force and moment, bearing forces and moments, under their names with units."""
        columns = self.motion.columns() | self._driving
        for pair, (name, torque) in zip(self._press.couplings, self.coupling_torque.items(), strict=True):
            turns = self._press.axes[pair.follower].turns
            columns[f"coupling_torque_{name} [N m]" if turns else f"coupling_force_{name} [N]"] = torque[:, 0]
        columns |= tables.by_axis("shaking_force", "N", self.shaking_force) | tables.by_axis("shaking_moment", "N m", self.shaking_moment)
        for name, force in self.bearing_force.items():
            columns |= tables.by_axis(f"force_{name}", "N", force) | tables.by_axis(f"moment_{name}", "N m", self.bearing_moment[name])
        for name, power in self.friction_power.items():
            if power.any():
                columns[f"friction_power_{name} [W]"] = power
        return columns


def carrying(press: Linkage, as_drawn: bool = False) -> tuple[str, ...]:
    """Names of everything that transmits forces: bearings, in their own order or in the order of the drawing, then contacts."""
    return (press.bearings_as_drawn if as_drawn else press.bearings) + tuple(contact.name for contact in press.contacts)


def find_wrenches(press: Linkage, engine: Engine, motion: Motion, conditions: AppliedConditions, bearings: bool) -> Wrenches:
    """Torques and, with ``bearings``, the wrenches of all bearings; raises as `inverse_dynamics`."""
    wrenches = inverse_dynamics(engine, motion.states(press), conditions, bearings)
    _refuse_not_finite(motion, wrenches)
    return wrenches


def _refuse_not_finite(motion: Motion, wrenches: Wrenches) -> None:
    """Raise PinpressError where a number is not finite. A sum shows it, and takes less time than looking at every number."""
    arrays = {
        "driving torque": wrenches.torque,
        "torque of a gear pair": wrenches.relations,
        "bearing force": wrenches.force,
        "bearing moment": wrenches.moment,
    }
    if math.isfinite(sum(np.add.reduce(array, axis=None) for array in arrays.values())):
        return
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            states = np.moveaxis(array, 1, 0)
            at = int(np.argmin(np.isfinite(states.reshape(len(states), -1)).all(axis=1)))
            raise PinpressError(
                f"the {name} of {motion.linkage} is not finite at {motion.driver_coordinates[0].at(np.ravel(motion.crank_angle[at])[0])}:"
                " the motion or a load is too large for floating point"
            )
