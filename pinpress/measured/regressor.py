"""The equations of a press as columns by its unknown parameters: torque at the crank, shaking force and moment.

Kinetic and potential energy are linear in the masses, first moments and moments of inertia of the links about the origins of their joints.
So every measured quantity s is linear in them too. With the speed w of the crank and the time t,

    s = sum over parameters p of  p (d/dt (A w) - share A' w^2 + C).

A, A' = dA/d(angle) and C depend on the crank angle alone. The share is 1/2 for the torque, where A is the inertia at the crank, and 0 for
forces and moments, where A is minus the momentum. After weighting over time and integration by parts, the equation needs no acceleration.
Friction and the force of a balance cylinder are columns too. The parameters are those of Pinocchio, in its order: mass, first moments,
inertia. The columns agree with those of its energy regressors (Gautier 1991).
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

INERTIAL = ("mass", "moment x", "moment y", "moment z", "I xx", "I xy", "I yy", "I xz", "I yz", "I zz")  # in Pinocchio's order
UNITS = ("kg", "kg m", "kg m", "kg m", *("kg m2",) * 6)
TENSOR = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))  # rows and columns of the inertias in this order
SHAKING = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
LOSSES = ("crank", "pins", "slide_guide", "gibs")
PIN = 0.05  # radius of a pin / size of the linkage, if the radius is not known


class Parameter(NamedTuple):
    """An unknown of a press.

    Attributes:
        name: "slide mass", "crank I", "crank friction".
        unit: unit of its values.
        value: value in the description of the press; 0 if the description does not have it.
        size: reference of its relative uncertainty: mass x radius of gyration about the joint for a first moment, otherwise the value; 0 if
            nothing is known before the measurement.
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
        """(n, parameters) of the quantity by the parameters, at speeds and accelerations of the crank, (n,) or one number each."""
        speeds, rates = np.asarray(speed)[..., None], np.asarray(acceleration)[..., None]
        return np.asarray(self.inertia * rates + (1 - self.share) * self.slope * speeds**2 + self.weight)


@dataclass(frozen=True, eq=False, repr=False)
class InertialEquations(Frozen):
    """How the quantities that can be measured depend on masses and inertias of the links.

    Attributes:
        press: the press.
        parameters: parameters of all bodies; in a planar press each body has four, in its plane.
        bases: for each body (10, k): from its k parameters to Pinocchio's ten.
    """

    press: Linkage
    parameters: tuple[Parameter, ...]
    bases: tuple[Array, ...]

    @cached_property
    def values(self) -> Array:
        """(parameters,) values in the description of the press."""
        return np.array([each.value for each in self.parameters])

    @cached_property
    def places(self) -> tuple[slice, ...]:
        """Slices of the parameters of each body."""
        ends = np.cumsum([basis.shape[1] for basis in self.bases]).tolist()
        return tuple(slice(end - basis.shape[1], end) for end, basis in zip(ends, self.bases, strict=True))

    def coefficients(self, angle: Array, wanted: Sequence[str] = ("torque",)) -> dict[str, Coefficients]:
        """Coefficients of the torque and of shaking forces and moments, "force x", "moment y", at crank angles (n,).

        Raises:
            PinpressError: a moment of a planar press about another axis than its normal, which depends on inertias out of the plane.
        """
        engine = self.press.engine()
        if isinstance(engine, PlanarEngine):
            for axis, part in zip("xyz", engine.plane.normal, strict=True):
                if f"moment {axis}" in wanted and abs(part) < 1 - 1e-12:
                    raise PinpressError(
                        f"the moment about {axis} of {self.press.name} depends on inertias of its links out of their plane: leave it out,"
                        " and give forces and the moment about the plane's normal"
                    )
        # in pieces that fit into the cache: 60,000 angles at once take three times as long
        pieces = [self._coefficients(angle[k : k + 20_000], wanted) for k in range(0, max(len(angle), 1), 20_000)]
        shares = {name: 0.5 if name == "torque" else 0.0 for name in wanted}
        joined = {name: [np.concatenate(parts) for parts in zip(*(piece[name] for piece in pieces), strict=True)] for name in wanted}
        return {name: Coefficients(inertia, slope, weight, shares[name]) for name, (inertia, slope, weight) in joined.items()}

    def columns(self, motion: Motion, wanted: str = "torque") -> Array:
        """(n, parameters) of a measured quantity over a motion; their product with ``values`` is the result of inverse dynamics."""
        return self.coefficients(motion.crank_angle, (wanted,))[wanted].columns(motion.crank_speed, motion.crank_acceleration)

    def pressed(self, values: Array, name: str | None = None) -> Linkage:
        """The press with other parameters (parameters,). The tensors of a planar press are scaled, so that its bodies stay real."""
        inertias = [self.press.model.inertias[0]]
        planar = isinstance(self.press.engine(), PlanarEngine)
        for basis, place, own in zip(self.bases, self.places, self.press.model.inertias.tolist()[1:], strict=True):
            inertias.append(_in_plane(own, basis, values[place]) if planar else _inertia(basis @ values[place]))
        return self.press.with_inertias(inertias, name)

    def _coefficients(self, angle: Array, wanted: Sequence[str]) -> dict[str, tuple[Array, ...]]:
        """A, A' and C of each wanted quantity."""
        press = self.press
        unit = moved(press, press.branch, angle, 1.0, 0.0, None, press.engine())
        bodies = press.engine("space").body_motion(unit.states(press), range(1, press.model.njoints))
        gravity = np.array(press.model.gravity.linear)[:, None]
        by_body: dict[str, list[list[Array]]] = {name: [] for name in wanted}
        for basis, *motion in zip(self.bases, *bodies, strict=True):
            body = _Body(*motion)
            energy = body.energy(gravity) if "torque" in wanted else ()
            momentum = body.momentum(gravity) if set(wanted) != {"torque"} else ()
            for name, parts in by_body.items():
                row = () if name == "torque" else SHAKING.index(name)
                parts.append([part[row] @ basis for part in (energy if name == "torque" else momentum)])
        return {name: tuple(np.concatenate(parts, axis=1) for parts in zip(*bodies, strict=True)) for name, bodies in by_body.items()}


class _Body(NamedTuple):
    """The motion of a body's frame at unit speed of the crank, in world axes, (3, n) each; rotation (3, 3, n)."""

    rotation: Array
    origin: Array
    velocity: Array
    spin: Array
    acceleration: Array
    turning: Array

    def energy(self, gravity: Array) -> tuple[Array, Array, Array]:
        """(n, 10) each, by Pinocchio's parameters: twice the kinetic energy, its rate, and the rate of the potential energy."""
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
        """(6, n, 10) each, about the world's origin: momentum and angular momentum, both negative; their rates, negative; weight and its
        moment."""
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
        PinpressError: the press has several drivers, or a sliding driver.
    """
    press.refuse_several_drivers("records need a press with one crank; hold the joints of the other drivers")
    press.refuse_sliding_driver("records need a press with a crank")
    press.refuse_joint_springs("identification does not know them; take them out of the file")
    if press.loses_power:
        press.refuse_contacts("records do not include their losses; leave efficiency and friction out of these elements")
    engine, parameters, bases = press.engine(), list[Parameter](), []
    planar = engine if isinstance(engine, PlanarEngine) else None
    data = press.model.createData()
    pin.forwardKinematics(press.model, data, pin.neutral(press.model))
    names: tuple[str, ...]
    units: tuple[str, ...]
    for body in range(1, press.model.njoints):
        link, inertia = press.link_of(body), press.model.inertias[body]
        ten, lever = np.array(inertia.toDynamicParameters()), inertia.lever
        swing = inertia.inertia + inertia.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))  # about the joint's origin
        if planar is None:
            basis, names, units = np.eye(10), INERTIAL, UNITS
            values, turning = ten, np.trace(swing) / 2
        else:
            # The normal is the same in a body's frame in all poses.
            basis, names, units = _plane_basis(data.oMi[body].rotation.T @ planar.plane.normal)
            first, second = basis[1:4, 1], basis[1:4, 2]
            normal = np.cross(first, second)
            turning = normal @ swing @ normal
            values = np.array([ten[0], first @ ten[1:4], second @ ten[1:4], turning])
        sizes = {"kg": inertia.mass, "kg m": np.sqrt(inertia.mass * turning), "kg m2": turning}
        parameters += [
            Parameter(f"{link} {name}", unit, float(v), float(sizes[unit])) for name, unit, v in zip(names, units, values, strict=True)
        ]
        bases.append(basis)
    return InertialEquations(press, tuple(parameters), tuple(bases))


def _plane_basis(normal: Array) -> tuple[Array, tuple[str, ...], tuple[str, ...]]:
    """(10, 4) from mass, two first moments and moment of inertia about the normal to Pinocchio's ten; names and units of the four."""
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


def _inertia(ten: Array) -> pin.Inertia:
    """The inertia with Pinocchio's ten parameters; that of a body without mass is zero."""
    return pin.Inertia.FromDynamicParameters(ten) if ten[0] > 0 else pin.Inertia(0.0, np.zeros(3), np.zeros((3, 3)))


def _in_plane(own: pin.Inertia, basis: Array, given: Array) -> pin.Inertia:
    """A body's inertia with other parameters in the plane. The tensor about the centre of mass is scaled, and all else stays."""
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
    """The unknowns of friction and balance cylinder, in the order of `loss_columns`; ``radii``: whether the radii of pins are known."""
    units = {
        "crank": {"crank friction": "N m", "crank viscous friction": "N m s/rad"},
        "pins": {"pins friction": "-" if radii else "m"},
        "slide_guide": {"slide guide friction": "-"},
        "gibs": {"gibs friction": "N"},
        "cylinder": {"cylinder force": "N", "cylinder stiffness": "N/m"},
    }
    kinds = [*friction, *(["cylinder"] if cylinder else [])]
    return tuple(Parameter(name, unit, 0.0, 0.0) for kind in kinds for name, unit in units[kind].items())


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
    """(n, losses) torque at the crank by the unknowns of `loss_parameters`.

    Args:
        press: the press, whose masses make the forces in its bearings.
        angle: (n,) crank angle [rad].
        speed: (n,) speed of the crank [rad/s].
        acceleration: (n,) acceleration of the crank [rad/s2].
        friction: kinds of friction, from `LOSSES`.
        cylinder: whether there is a balance cylinder.
        radii: name of a pin -> radius [m]; None: 1 m for each.
        cylinder_load: force of the cylinder at bottom dead centre [N] and its stiffness [N/m], for the forces in bearings.
    """
    motion = moved(press, press.branch, angle, speed, acceleration, None, press.engine())
    sign, columns = np.sign(speed), []
    by_force = {"pins", "slide_guide"} & set(friction)
    powers = _powers(press, motion, radii, cylinder_load) if by_force else {}
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
    if (motion.crank_speed == 0).any():
        motion = moved(press, press.branch, motion.crank_angle, 1.0, 0.0, None, press.engine())
    return motion.slide_velocity / motion.crank_speed, motion.slide_position - dead_centres(press).bottom_position


def turning_bearings(press: Linkage) -> list[str]:
    """Names of the joints and loops in which links turn: the pins."""
    turns = [axis.turns for axis in press.axes] + [loop.type != "fixed" for loop in press.loops]
    return [name for name, turning in zip(press.bearings, turns, strict=True) if turning]


def _powers(press: Linkage, motion: Motion, radii: Mapping[str, float] | None, cylinder: tuple[float, float]) -> dict[str, Array]:
    """(n,) powers lost in all pins and in the guide of the slide, for a coefficient of friction of 1, or of 1 x 1 m [W]."""
    small = 1e-6  # the torque of friction is linear in a small coefficient
    usual = PIN * press.size  # a bearing of this press may have this radius; 1 m would be too large
    pins = turning_bearings(press)
    if radii is None:
        laws = {name: Friction(small / usual, radius=usual) for name in pins}
    else:
        laws = {name: Friction(small, radius=radii[name]) for name in pins if name in radii}
    loads: list[Load] = []
    guide = None
    if press.slide is not None:
        guide = press.joints[press.slide_guide.joint]
        laws[guide] = Friction(small)
        if any(cylinder):
            _, height = slide_rates(press, motion)
            loads.append(force_on_slide(press, cylinder[0] + cylinder[1] * height))
    lost = inverse_dynamics(press, motion, loads, friction=laws, bearings=()).friction_power
    zero = np.zeros(len(motion.crank_angle))
    return {
        "pins": sum((lost[name] / small for name in pins if name in laws), zero),
        "slide_guide": zero if guide is None else lost[guide] / small,
    }
