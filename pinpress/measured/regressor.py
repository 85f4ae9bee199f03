"""The equations of a press as columns by its unknown parameters: torque at the crank, shaking force and moment.

Kinetic and potential energy are linear in masses, first moments and moments of inertia about the joints' origins, so that everything
that is measured is, with the crank's angle, its speed w and the time t,

    s = sum over parameters p of  p (d/dt (A w) - share A' w^2 + C)

with A, A' = dA/d(angle) and C, which depend on the angle alone. Share is 1/2 for the torque (A is the inertia at the crank) and 0 for
forces and moments (A is minus the momentum). A sum that is read so needs no acceleration where it is weighted over time. What is lost in
bearings, guides and gibs and what a balance cylinder does are columns too. Parameters are Pinocchio's, in its order: mass, first moments,
inertia; the columns agree with those of its energy regressors (Gautier 1991).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import Frozen
from ..common.quantities import Array
from ..dynamics.applied_loads import force_on_slide
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..engines.body_motion import cross, turned_back
from ..engines.planar.engine import PlanarEngine
from ..kinematics.cycle import moved
from ..kinematics.motion import Motion
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import NAME_A_SLIDE, Linkage
from ..loads.link import Friction, Load

INERTIAL: tuple[str, ...] = (
    "mass",
    "moment x",
    "moment y",
    "moment z",
    "I xx",
    "I xy",
    "I yy",
    "I xz",
    "I yz",
    "I zz",
)  # as Pinocchio has them
UNITS: tuple[str, ...] = ("kg", "kg m", "kg m", "kg m", *("kg m2",) * 6)
TENSOR = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))  # rows and columns of the inertias in this order
LOSSES = ("crank", "pins", "slide_guide", "gibs")
SMALL = 1e-6  # coefficient of friction by which the torque of friction is found: it is linear in a small one
PIN = 0.05  # radius of a pin by the size of the linkage, where none is known
ABSENT = 1e-12  # share of the largest column below which a parameter is in no equation
PIECE = 20_000  # angles that are taken at once


class Parameter(NamedTuple):
    """An unknown of a press.

    Attributes:
        name: "slide mass", "crank I", "crank friction".
        unit: of it.
        value: as the press has it, of what it does not have 0.
        size: to which a relative uncertainty refers: of a first moment mass x radius of gyration about the joint, else the value; 0 where
            nothing is known beforehand.
    """

    name: str
    unit: str
    value: float
    size: float


class Coefficients(NamedTuple):
    """A, A' and C of one measured quantity at n angles, (n, parameters) each, and its share; see the module."""

    inertia: Array
    slope: Array
    weight: Array
    share: float

    def columns(self, speed: Array | float, acceleration: Array | float) -> Array:
        """(n, parameters) of the quantity by the parameters, at speeds and accelerations of the crank, (n,) or one each."""
        speeds, rates = np.asarray(speed)[..., None], np.asarray(acceleration)[..., None]
        return np.asarray(self.inertia * rates + (1 - self.share) * self.slope * speeds**2 + self.weight)


@dataclass(frozen=True, eq=False, repr=False)
class InertialEquations(Frozen):
    """How the quantities that can be measured depend on masses and inertias of the links.

    Attributes:
        press: the press.
        parameters: of all bodies; of a planar press the four of each in its plane.
        bases: of every body, (10, k): its k parameters to Pinocchio's ten.
    """

    press: Linkage
    parameters: tuple[Parameter, ...]
    bases: tuple[Array, ...]

    @cached_property
    def values(self) -> Array:
        """(parameters,) as the press has them."""
        return np.array([each.value for each in self.parameters])

    def coefficients(self, angle: Array, wanted: Sequence[str] = ("torque",)) -> dict[str, Coefficients]:
        """Coefficients of the torque and of shaking forces and moments, "force x", "moment y", at crank angles (n,).

        Raises:
            PinpressError: a moment of a planar press about another axis than its normal: its parameters in the plane do not give it.
        """
        self._refuse_across(wanted)
        pieces = [self._coefficients(angle[k : k + PIECE], wanted) for k in range(0, max(len(angle), 1), PIECE)]
        if len(pieces) == 1:
            return pieces[0]
        joined = {}
        for name in wanted:
            parts = [piece[name] for piece in pieces]
            inertia, slope, weight = (np.concatenate([part[k] for part in parts]) for k in range(3))
            joined[name] = Coefficients(inertia, slope, weight, parts[0].share)
        return joined

    def columns(self, motion: Motion, wanted: str = "torque") -> Array:
        """(n, parameters) of a measured quantity over a motion: their product with ``values`` is what inverse dynamics gives."""
        return self.coefficients(motion.crank_angle, (wanted,))[wanted].columns(motion.crank_speed, motion.crank_acceleration)

    def _refuse_across(self, wanted: Sequence[str]) -> None:
        engine = self.press.engine()
        if isinstance(engine, PlanarEngine):
            for axis, part in zip("xyz", engine.plane.normal, strict=True):
                if f"moment {axis}" in wanted and abs(part) < 1 - ABSENT:
                    raise PinpressError(
                        f"the moment about {axis} of {self.press.name} depends on inertias of its links out of their plane: leave it out,"
                        " and give forces and the moment about the plane's normal"
                    )

    def pressed(self, values: Array, name: str | None = None) -> Linkage:
        """The press with other parameters (parameters,). Of a planar press tensors are scaled, so that they stay ones of real bodies."""
        inertias, start = [self.press.model.inertias[0]], 0
        planar = isinstance(self.press.engine(), PlanarEngine)
        for body, basis in enumerate(self.bases, 1):
            own = self.press.model.inertias[body]
            given = values[start : start + basis.shape[1]]
            start += basis.shape[1]
            inertias.append(_in_plane(own, basis, given) if planar else _inertia(basis @ given))
        return self.press.with_inertias(inertias, name)

    def _coefficients(self, angle: Array, wanted: Sequence[str]) -> dict[str, Coefficients]:
        press = self.press
        unit = moved(press, press.branch, angle, 1.0, 0.0, None, press.engine())
        bodies = press.engine("space").body_motion(unit.states(press), range(1, press.model.njoints))
        gravity = np.array(press.model.gravity.linear)[:, None]
        found: dict[str, list[tuple[Array, Array, Array]]] = {name: [] for name in wanted}
        for basis, *motion in zip(self.bases, *bodies, strict=True):
            moving = _Body(*motion)
            if "torque" in found:
                found["torque"].append(tuple(part @ basis for part in moving.energy(gravity)))
            if any(name != "torque" for name in wanted):
                momentum = moving.momentum(gravity)
                for name in wanted:
                    if name != "torque":
                        row = ("force x", "force y", "force z", "moment x", "moment y", "moment z").index(name)
                        found[name].append(tuple(part[row] @ basis for part in momentum))
        made = {}
        for name, parts in found.items():
            inertia, slope, weight = (np.concatenate([part[k] for part in parts], axis=1) for k in range(3))
            made[name] = Coefficients(inertia, slope, weight, 0.5 if name == "torque" else 0.0)
        return made


class _Body(NamedTuple):
    """The motion of a body's frame at unit speed of the crank, in world axes, (3, n) each; rotation (3, 3, n)."""

    rotation: Array
    origin: Array
    velocity: Array
    spin: Array
    acceleration: Array
    turning: Array

    def energy(self, gravity: Array) -> tuple[Array, Array, Array]:
        """(n, 10) each: twice the kinetic energy, its rate of change, and the rate of the potential energy, by Pinocchio's parameters."""
        back = self.rotation
        v, w = turned_back(back, self.velocity), turned_back(back, self.spin)
        dv, dw = turned_back(back, self.acceleration - cross(self.spin, self.velocity)), turned_back(back, self.turning)
        n = v.shape[-1]
        twice, rate, weight = np.empty((10, n)), np.empty((10, n)), np.zeros((10, n))
        twice[0], rate[0] = (v * v).sum(axis=0), 2 * (v * dv).sum(axis=0)
        twice[1:4], rate[1:4] = 2 * cross(v, w), 2 * (cross(dv, w) + cross(v, dw))
        for k, (i, j) in enumerate(TENSOR, 4):
            many = 1.0 if i == j else 2.0
            twice[k], rate[k] = many * w[i] * w[j], many * (dw[i] * w[j] + w[i] * dw[j])
        weight[0] = -(gravity * self.velocity).sum(axis=0)
        weight[1:4] = -turned_back(back, cross(np.broadcast_to(gravity, self.spin.shape), self.spin))
        return twice.T, rate.T, weight.T

    def momentum(self, gravity: Array) -> tuple[Array, Array, Array]:
        """(6, n, 10) each: minus momentum and moment of momentum about the world origin, minus their rates, and weight with its moment."""
        n = self.origin.shape[-1]
        moment, rate, weight = np.zeros((10, 6, n)), np.zeros((10, 6, n)), np.zeros((10, 6, n))
        moment[0, :3], rate[0, :3], weight[0, :3] = self.velocity, self.acceleration, gravity
        moment[0, 3:], rate[0, 3:] = cross(self.origin, self.velocity), cross(self.origin, self.acceleration)
        weight[0, 3:] = cross(self.origin, np.broadcast_to(gravity, self.origin.shape))
        for k in range(3):
            arm = self.rotation[:, k]
            turned = cross(self.spin, arm)
            changed = cross(self.turning, arm) + cross(self.spin, turned)
            moment[1 + k, :3], rate[1 + k, :3] = turned, changed
            moment[1 + k, 3:] = cross(self.origin, turned) + cross(arm, self.velocity)
            rate[1 + k, 3:] = cross(self.origin, changed) + cross(arm, self.acceleration)
            weight[1 + k, 3:] = cross(arm, np.broadcast_to(gravity, arm.shape))
        for k, (i, j) in enumerate(TENSOR, 4):
            pairs = ((i, j),) if i == j else ((i, j), (j, i))
            for a, b in pairs:
                along, spin = self.rotation[:, a], (self.rotation[:, b] * self.spin).sum(axis=0)
                turning = (self.rotation[:, b] * self.turning).sum(axis=0)
                moment[k, 3:] += along * spin
                # The tensor turns with the body: d/dt (R E R' w) = w x (R E R' w) + R E R' dw/dt.
                rate[k, 3:] += cross(self.spin, along * spin) + along * turning
        back = (1, 2, 0)
        return -moment.transpose(back), -rate.transpose(back), weight.transpose(back)


def inertial_equations(press: Linkage) -> InertialEquations:
    """The equations of a press with one crank.

    Raises:
        PinpressError: it has several drivers, or one that slides.
    """
    press.refuse_several_drivers("records need a press with one crank; hold the joints of the other drivers")
    press.refuse_sliding_driver("records need a press with a crank")
    engine, parameters, bases = press.engine(), [], []
    planar = engine if isinstance(engine, PlanarEngine) else None
    for body in range(1, press.model.njoints):
        link, inertia = press.link_of(body), press.model.inertias[body]
        ten = np.array(inertia.toDynamicParameters())
        if planar is None:
            basis, names, units = np.eye(10), INERTIAL, UNITS
        else:
            basis, names, units = _plane_basis(_normal(press, planar, body))
        swing = _about_joint(inertia)
        if planar is None:
            values, turning = ten, np.trace(swing) / 2
        else:
            normal = np.cross(basis[1:4, 1], basis[1:4, 2])
            turning = normal @ swing @ normal
            values = np.array([ten[0], basis[1:4, 1] @ ten[1:4], basis[1:4, 2] @ ten[1:4], turning])
        sizes = {"kg": inertia.mass, "kg m": np.sqrt(inertia.mass * turning), "kg m2": turning}
        parameters += [
            Parameter(f"{link} {name}", unit, float(v), float(sizes[unit])) for name, unit, v in zip(names, units, values, strict=True)
        ]
        bases.append(basis)
    return InertialEquations(press, tuple(parameters), tuple(bases))


def _normal(press: Linkage, engine: PlanarEngine, body: int) -> Array:
    """(3,) normal of a planar press's plane in a body's frame; the same in all poses."""
    data = press.model.createData()
    pin.forwardKinematics(press.model, data, pin.neutral(press.model))
    return np.asarray(data.oMi[body].rotation.T @ engine.plane.normal)


def _plane_basis(normal: Array) -> tuple[Array, tuple[str, ...], tuple[str, ...]]:
    """(10, 4) from mass, two first moments and the moment of inertia about the normal to Pinocchio's ten, and what they are called."""
    across = [k for k in range(3) if k != int(np.argmax(np.abs(normal)))]
    first = np.eye(3)[across[0]] - normal[across[0]] * normal
    first /= np.linalg.norm(first)
    second = np.cross(first, normal)
    if second[across[1]] < 0:
        second = -second
    basis = np.zeros((10, 4))
    basis[0, 0] = 1.0
    basis[1:4, 1], basis[1:4, 2] = first, second
    basis[4:, 3] = [normal[i] * normal[j] for i, j in TENSOR]
    return basis, ("mass", f"moment {'xyz'[across[0]]}", f"moment {'xyz'[across[1]]}", "I"), ("kg", "kg m", "kg m", "kg m2")


def _about_joint(inertia: pin.Inertia) -> Array:
    """(3, 3) tensor about the joint's origin."""
    lever = inertia.lever
    return np.asarray(inertia.inertia + inertia.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever)))


def _inertia(ten: Array) -> pin.Inertia:
    """Of Pinocchio's ten parameters; a body without mass has none."""
    return pin.Inertia.FromDynamicParameters(ten) if ten[0] > 0 else pin.Inertia(0.0, np.zeros(3), np.zeros((3, 3)))


def _in_plane(own: pin.Inertia, basis: Array, given: Array) -> pin.Inertia:
    """A body's inertia with other parameters in the plane: what is across it stays, the tensor about the centre of mass is scaled."""
    mass, first, second, about_joint = given
    if mass <= 0:
        return pin.Inertia(0.0, np.zeros(3), np.zeros((3, 3)))
    a, b = basis[1:4, 1], basis[1:4, 2]
    normal = np.cross(a, b)
    lever = (first * a + second * b) / mass + normal * (normal @ own.lever)
    central = max(about_joint - (first**2 + second**2) / mass, 0.0)
    before = float(normal @ own.inertia @ normal)
    disc = np.outer(normal, normal) + 0.5 * (np.eye(3) - np.outer(normal, normal))
    return pin.Inertia(mass, lever, own.inertia * (central / before) if before > 0 else central * disc)


# ------------------------------------------------------------------------------------------------------------- losses and balance cylinder


def loss_parameters(friction: Sequence[str], cylinder: bool, radii: bool) -> tuple[Parameter, ...]:
    """The unknowns of friction and of a balance cylinder, in the order of `loss_columns`; ``radii``: whether those of pins are known."""
    found = []
    for name in friction:
        if name == "crank":
            found += [Parameter("crank friction", "N m", 0.0, 0.0), Parameter("crank viscous friction", "N m s/rad", 0.0, 0.0)]
        elif name == "pins":
            found.append(Parameter("pins friction", "-" if radii else "m", 0.0, 0.0))
        elif name == "slide_guide":
            found.append(Parameter("slide guide friction", "-", 0.0, 0.0))
        else:
            found.append(Parameter("gibs friction", "N", 0.0, 0.0))
    if cylinder:
        found += [Parameter("cylinder force", "N", 0.0, 0.0), Parameter("cylinder stiffness", "N/m", 0.0, 0.0)]
    return tuple(found)


def refuse_losses(press: Linkage, friction: Sequence[str], cylinder: bool) -> None:
    """Refuse losses or a balance cylinder that a press cannot have."""
    for name in friction:
        if not isinstance(name, str):
            raise PinpressError(f"friction is {shown(friction)}: give names, of {', '.join(LOSSES)}")
        if name not in LOSSES:
            raise UnknownNameError("kind of friction", name, LOSSES)
    if len(set(friction)) < len(friction):
        raise PinpressError(f"friction is {shown(friction)}: name each kind once")
    if press.slide is None and (cylinder or {"slide_guide", "gibs"} & set(friction)):
        raise PinpressError(f"{press.name} has no slide: leave out friction of its guide, gibs and cylinder, or {NAME_A_SLIDE}")


def loss_columns(
    press: Linkage,
    angle: Array,
    speed: Array,
    acceleration: Array,
    friction: Sequence[str],
    cylinder: bool,
    *,
    radii: Mapping[str, float] | None = None,
    cylinder_load: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """(n, losses) torque at the crank by the unknowns of `loss_parameters`, with the forces of this press in its bearings.

    Args:
        press: the press, by whose masses forces in bearings are.
        angle: (n,) crank angle [rad].
        speed: (n,) speed of the crank [rad/s].
        acceleration: (n,) [rad/s2].
        friction: kinds, of `LOSSES`.
        cylinder: whether there is a balance cylinder.
        radii: of the pins, by their names [m]; None: 1 m each.
        cylinder_load: force of the cylinder at bottom dead centre [N] and its stiffness [N/m], for the forces in bearings.
    """
    motion = moved(press, press.branch, angle, speed, acceleration, None, press.engine())
    sign, columns = np.sign(speed), []
    powers = _powers(press, motion, radii, cylinder_load) if {"pins", "slide_guide"} & set(friction) else {}
    turning = np.where(speed == 0, 1.0, speed)
    rate, height = slide_rates(press, motion)
    for name in friction:
        if name == "crank":
            columns += [sign, speed]
        elif name == "gibs":
            columns.append(np.abs(rate) * sign)
        else:
            columns.append(powers[name] / turning)
    if cylinder:
        columns += [-rate, -rate * height]
    return np.stack(columns, axis=1) if columns else np.zeros((len(angle), 0))


def slide_rates(press: Linkage, motion: Motion) -> tuple[Array, Array]:
    """(n,) travel of the slide by angle of the crank [m/rad], and (n,) its height above bottom dead centre [m]; 0 without a slide."""
    if press.slide is None:
        return np.zeros(len(motion.crank_angle)), np.zeros(len(motion.crank_angle))
    speed = motion.crank_speed
    if (speed == 0).any():
        motion = moved(press, press.branch, motion.crank_angle, 1.0, 0.0, None, press.engine())
        speed = motion.crank_speed
    return motion.slide_velocity / speed, motion.slide_position - dead_centres(press).bottom_position


def _powers(press: Linkage, motion: Motion, radii: Mapping[str, float] | None, cylinder: tuple[float, float]) -> dict[str, Array]:
    """(n,) powers lost in all pins, and in the slide's guide, by a unit of friction [W]."""
    turns = [axis.turns for axis in press.axes] + [loop.type != "fixed" for loop in press.loops]
    pins = [name for name, turning in zip(press.bearings, turns, strict=True) if turning]
    guide = None if press.slide is None else press.joints[press.slide_guide.joint]
    known = dict.fromkeys(pins, PIN * press.size) if radii is None else radii
    share = SMALL / (PIN * press.size) if radii is None else SMALL  # of 1 m, by a radius that bearings of this press may have
    laws = {name: Friction(share, radius=known[name]) for name in pins if name in known}
    if guide is not None:
        laws[guide] = Friction(SMALL)
    loads: list[Load] = []
    if press.slide is not None and any(cylinder):
        _, height = slide_rates(press, motion)
        loads.append(force_on_slide(press, cylinder[0] + cylinder[1] * height))
    found = inverse_dynamics(press, motion, loads, friction=laws, bearings=())
    power = {name: found.friction_power[name] / SMALL for name in laws}
    zero = np.zeros(len(motion.crank_angle))
    return {"pins": sum((power[name] for name in pins if name in power), zero), "slide_guide": zero if guide is None else power[guide]}
