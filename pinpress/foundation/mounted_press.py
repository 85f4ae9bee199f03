"""A press on its mounts as a linear system: M u'' + C u' + K u = what the machine exerts, about the static position.

Coordinates: of every rigid part of the frame, the displacement of its point at the world origin and its small turn, (x, y, z, rx, ry, rz)
in world axes [m, rad]; the bed's, then the crown's where there are two parts. With spatial inertias about the world origin and wrenches
about it no other point of reference is needed.

What moves in the press rides with the frame. For joint motions q(t) relative to the frame the six equations of a floating tree are
M(q) u'' + (terms in u' of the links' relative velocities) = shaking wrench at a frame at rest + mounts; M(q) is the spatial inertia of the
whole press, and its mean over a period is taken. What is left out (its change over the period, Coriolis forces) is of second
order: the ratio of moving mass to frame times the vibration. The gyroscopic moment of a flywheel, J w times the rate at which the frame
turns its axis, is left out too.

Points and mounts are where they are under the static load. The weight and the mounts' static forces then turn the equilibrium: a force f at
a point p of a part has the potential -f . (t x (t x p)) / 2 beside its work for the turn t, which is the stiffness
f . p - (f p^T + p f^T) / 2. It makes a tall press on soft mounts tip, and pendulums swing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.errors import PinpressError, expect
from ..common.frozen import read_only
from ..common.results import Tabular
from ..common.tables import Column
from ..engines.joints import data_of
from ..kinematics.motion import cycle
from ..linkage.linkage import Linkage
from .matrices import body_inertia, centre_of, refuse_loose, refuse_pulled, rows_at, springs_together, turning_stiffness, weight_wrench
from .mounts import Frame, Mount, listed_mounts

POSES = 180  # of a turn over which the moving mass is averaged: the mean of harmonics below that order is exact


@dataclass(frozen=True, eq=False, repr=False)
class MountedPress(Tabular):
    """A press on its mounts; made by `mounted`. All arrays are read-only; n coordinates, 6 a part (see the module).

    Attributes:
        press: the press.
        frame: the frame, or its bed.
        crown: the part that carries crank and guides; None where the frame is one part.
        mounts: between floor and frame.
        uprights: between bed and crown.
        mass: (n, n) of frame and press, moving masses at their mean.
        damping: (n, n) viscous.
        stiffness: (n, n) of vibrations, with what the weight takes away.
        loss: (n, n) imaginary part of the stiffness.
        weight: (n,) wrench of all weights about the world origin [N, N m].
        press_weight: (6,) of that, the links of the press.
        press_inertia: (6, 6) of the links of the press, see `press_inertia`.
        mount_load: (mounts, 3) what each mount exerts on the frame at rest [N].
        sag: (mounts, 3) displacement of each mount from unloaded [m].
    """

    press: Linkage
    frame: Frame
    crown: Frame | None
    mounts: tuple[Mount, ...]
    uprights: tuple[Mount, ...]
    mass: Array
    damping: Array
    stiffness: Array
    loss: Array
    weight: Array
    press_weight: Array
    press_inertia: Array
    mount_load: Array
    sag: Array

    @property
    def title(self) -> str:
        return f"MountedPress {self.press.name}: {self.total_mass:.6g} kg on {len(self.mounts)} mounts"

    def __str__(self) -> str:
        """Loads, sag and pressure of the mounts at rest."""
        x, y, z = self.centre
        lines = [
            f"{self.press.name} on its mounts at rest: {self.total_mass:.6g} kg, centre of mass {x:.4g}, {y:.4g}, {z:.4g} m",
            f"  {'mount at':<28}{'load':>14}{'share':>10}{'sag':>14}{'pressure':>14}",
        ]
        for mount, load, share, sag, pressure in zip(
            self.mounts, self.mount_load[:, 2], self.load_share, self.sag[:, 2], self.pressure, strict=True
        ):
            place = ", ".join(f"{coordinate:.4g}" for coordinate in mount.point) + " m"
            last = "" if pressure is None else f"{pressure / 1e6:10.4g} MPa"
            lines.append(f"  {place:<28}{load:12.5g} N{100 * share:8.2f} %{-1e3 * sag:11.4g} mm{last}")
        return "\n".join(lines)

    def columns(self) -> dict[str, Column]:
        """Mounts as columns, one a row: place, load and share of the weight, sag, pressure."""
        places = {f"{axis} [m]": [mount.point[i] for mount in self.mounts] for i, axis in enumerate("xyz")}
        return {
            **places,
            "load [N]": self.mount_load[:, 2].tolist(),
            "share [-]": self.load_share.tolist(),
            "sag [m]": (-self.sag[:, 2]).tolist(),
            "pressure [Pa]": list(self.pressure),
        }

    @property
    def parts(self) -> int:
        """Rigid parts of the frame, 1 or 2."""
        return 1 if self.crown is None else 2

    @property
    def total_mass(self) -> float:
        """Of frame and press [kg]."""
        return float(self.mass[0::6, 0::6].sum())

    @property
    def centre(self) -> Array:
        """(3,) mean centre of mass of frame and press [m]."""
        whole = self.mass[:6, :6] + (self.mass[6:, 6:] if self.parts == 2 else 0.0)
        return centre_of(whole)

    @property
    def load_share(self) -> Array:
        """(mounts,) share of the weight on each mount [-]."""
        share: Array = self.mount_load[:, 2] / self.mount_load[:, 2].sum()
        return share

    @property
    def pressure(self) -> tuple[float | None, ...]:
        """Mean pressure on each mount at rest [Pa]; None for one without an area."""
        return tuple(
            None if mount.area is None else float(load / mount.area) for mount, load in zip(self.mounts, self.mount_load[:, 2], strict=True)
        )

    @cached_property
    def mount_rows(self) -> Array:
        """(mounts, 3, n) displacement of each mount's point for each coordinate."""
        return read_only(np.array([rows_at(self.parts, 0, np.array(mount.point)) for mount in self.mounts]))


@typed
def mounted(
    press: Linkage, frame: Frame, mounts: Sequence[Mount], *, crown: Frame | None = None, uprights: Sequence[Mount] = ()
) -> MountedPress:
    """Stand a press on its mounts.

    Args:
        press: its links ride with the frame, or with the crown; their inertia is averaged over a period, mostly one turn of the crank.
        frame: the frame in one part; with ``crown`` its lower part, the bed, on which the loads on the frame act (the process force).
        mounts: between floor and frame.
        crown: upper part of the frame, which carries crank and guides.
        uprights: springs between the two, as mounts.

    Raises:
        PinpressError: arguments of other kinds, a crank that does not turn fully, mounts that leave the frame free or are pulled by
            its weight, a press that tips.
    """
    mounts = listed_mounts(mounts, "mounts")
    if (crown is None) != (len(uprights) == 0):
        raise PinpressError("crown and uprights go together: give both, or neither for a frame in one part")
    if crown is not None:
        expect("crown", crown, Frame, "Frame")
        uprights = listed_mounts(uprights, "uprights")
    return _assembled(press, frame, mounts, crown, tuple(uprights), press_inertia(press))


def with_mounts(system: MountedPress, mounts: Sequence[Mount]) -> MountedPress:
    """The same press on other mounts; quicker than `mounted`. Raises as that."""
    mounts = listed_mounts(mounts, "mounts")
    return _assembled(system.press, system.frame, mounts, system.crown, system.uprights, system.press_inertia)


@typed
def press_inertia(press: Linkage) -> Array:
    """Mean spatial inertia of all links about the world origin over one period.

    Args:
        press: with one driver that turns fully.

    Returns:
        (6, 6), linear before angular [kg, kg m, kg m2].

    Raises:
        PinpressError: the crank does not turn fully, or there are several.
    """
    model, period = press.model, cycle(press, 1.0, points=POSES * press.period_turns)
    data = data_of(model)
    total = np.zeros((6, 6))
    for q in period.q:
        pin.forwardKinematics(model, data, q)
        for place, inertia in zip(data.oMi, model.inertias, strict=True):
            if inertia.mass:
                total += place.act(inertia).matrix()
    return total / len(period.q)


def _assembled(
    press: Linkage, frame: Frame, mounts: tuple[Mount, ...], crown: Frame | None, uprights: tuple[Mount, ...], moving: Array
) -> MountedPress:
    parts, gravity = 1 if crown is None else 2, np.asarray(press.model.gravity.linear)
    bodies = [body_inertia(part) for part in (frame, crown) if part is not None]
    press_weight = weight_wrench(moving, gravity)
    bodies[-1] = bodies[-1] + moving
    weight = np.concatenate([weight_wrench(body, gravity) for body in bodies])
    mass = np.zeros((6 * parts, 6 * parts))
    for k, body in enumerate(bodies):
        mass[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = body
    rows = [rows_at(parts, 0, np.array(mount.point)) for mount in mounts]
    between = [rows_at(parts, 1, np.array(upright.point)) - rows_at(parts, 0, np.array(upright.point)) for upright in uprights]
    springs = list(zip((*mounts, *uprights), rows + between, strict=True))
    refuse_loose(mass, "frame and press have no inertia for", "give the frame its mass and inertia")
    static = springs_together((mount.static, at) for mount, at in springs)
    refuse_loose(static, "the mounts leave the frame free in", "give mounts there, and stiffness in all directions")
    rest = np.linalg.solve(static, weight)
    sag = np.array([at @ rest for at in rows])
    load = -np.array([mount.static for mount in mounts]) * sag
    refuse_pulled(load, gravity)
    stiffness = springs_together((mount.stiffness, at) for mount, at in springs)
    stiffness += turning_stiffness(mounts, uprights, between, rest, load, bodies, gravity)
    system = MountedPress(
        press=press,
        frame=frame,
        crown=crown,
        mounts=mounts,
        uprights=uprights,
        mass=mass,
        damping=springs_together((mount.damping, at) for mount, at in springs),
        stiffness=0.5 * (stiffness + stiffness.T),
        loss=springs_together((mount.loss_factor * np.array(mount.stiffness), at) for mount, at in springs),
        weight=weight,
        press_weight=press_weight,
        press_inertia=moving,
        mount_load=load,
        sag=sag,
    )
    if np.linalg.eigvalsh(system.stiffness)[0] <= 0:
        raise PinpressError(
            f"{press.name} tips over on these mounts: its weight turns it further than they hold; set them wider apart, or stiffer"
        )
    return system
