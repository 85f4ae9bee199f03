"""The rows of a run by all unknowns, linear about present estimates: masses, losses, forces in bearings, the encoder's zero.

The equations (`weak_form`) hold at the crank's angle, which is the encoder's reading less its zero z. By z they change as

    d rows / dz = (rows at zero z + h, less rows at zero z - h) / (2 h)

with all other unknowns as found last, which is Gauss and Newton's method from pass to pass.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...common.quantities import GRAVITY, Array
from ...dynamics.inverse_dynamics import inverse_dynamics
from ...kinematics.cycle import moved
from ...linkage.linkage import Linkage
from ...loads.link import Load
from ..records import MeasuredRun
from ..regressor import Coefficients, InertialEquations, loss_columns, loss_parameters
from .prior import Losses, Unknowns
from .weak_form import Rows, SmoothAngle, quantities

STEP = 1e-3  # deviations by which masses are changed for slopes of friction
EACH = 3  # of so many points one is taken for them
TURN = 1e-5  # by which the zero is changed for its slope [rad]
BY_FORCE = ("pins", "slide_guide")  # friction that grows with the forces in bearings


class Known(NamedTuple):
    """What acts beside the unknowns: inertia of the drive [kg m2] and loads."""

    inertia: float
    loads: tuple[Load, ...]


class RunEquations(NamedTuple):
    """What the rows of a run are made of.

    Attributes:
        unknowns: of the press.
        losses: that are looked for.
        known: what acts beside them.
        run: the record.
        smooth: its angle, as the encoder reads it.
    """

    unknowns: Unknowns
    losses: Losses
    known: Known
    run: MeasuredRun
    smooth: SmoothAngle

    def rows(self, at: Array, slopes: Mapping[str, Array]) -> list[Rows]:
        """Rows by all unknowns, linear about these estimates (unknowns,).

        Args:
            at: the estimates.
            slopes: of friction, from `friction_slopes`; empty where forces in bearings are taken as those at the estimates.
        """
        zero = self.unknowns.zero
        at_zero = self._at_angle(at, at[zero])
        around = [self._at_angle(at, at[zero] + step) for step in (TURN, -TURN)]
        changing = sum((at[self.unknowns.place(name)] * each for name, each in slopes.items()), np.zeros(1))
        found = []
        for row, ahead, behind in zip(at_zero, *around, strict=True):
            more = np.zeros((len(row.values), len(at)))
            more[:, zero] = (ahead.columns @ at + ahead.known - behind.columns @ at - behind.known) / (2 * TURN)
            if row.quantity == "torque":
                more = more + changing
            found.append(Rows(row.quantity, row.columns + more, row.values, row.known - more @ at))
        return found

    def friction_slopes(self, at: Array) -> dict[str, Array]:
        """(rows, unknowns) by which the torque of friction in pins and in the guide changes with masses and cylinder, at these values, by a
        unit of each such unknown."""
        unknowns, losses, smooth = self.unknowns, self.losses, _shifted(self.smooth, at[self.unknowns.zero])
        by_force = [name for name in losses.friction if name in BY_FORCE]
        some = slice(None, None, EACH)
        points = smooth.angle[some], smooth.speed[some], smooth.acceleration[some]

        def friction(values: Array) -> Array:
            press, cylinder = unknowns.equations.pressed(values[: unknowns.inertial]), _cylinder(unknowns, values)
            return loss_columns(press, *points, by_force, False, radii=losses.radii, cylinder_load=cylinder)

        plain, spread = friction(at), unknowns.at(np.zeros(unknowns.inertial))[1]
        moving = np.abs(spread).max(axis=0) > 0
        rest = np.zeros(len(at) - unknowns.inertial)
        by_deviation = [(friction(at + STEP * np.append(step, rest)) - plain) / STEP for step in spread[:, moving].T]
        found = np.zeros((len(by_force), len(points[0]), len(at)))
        found[:, :, : unknowns.inertial] = np.stack(by_deviation, axis=-1).swapaxes(0, 1) @ np.linalg.pinv(spread[:, moving])
        if unknowns.cylinder is not None:
            weight = GRAVITY * sum(each.mass for each in unknowns.equations.press.model.inertias)
            for k, size in zip(unknowns.cylinder, (weight, weight / unknowns.equations.press.size), strict=True):
                step = np.zeros(len(at))
                step[k] = STEP * size
                found[:, :, k] = ((friction(at + step) - plain) / (STEP * size)).T
        where, there = np.arange(len(smooth.angle)), np.arange(len(smooth.angle))[some]
        names = [each.name for each in loss_parameters(by_force, False, losses.radii is not None)]
        return {
            name: smooth.integrals(np.stack([np.interp(where, there, column) for column in each.T], axis=1))
            for name, each in zip(names, found, strict=True)
        }

    def _at_angle(self, at: Array, zero: float) -> list[Rows]:
        """Rows where the encoder has this zero, with forces in bearings of the press and cylinder of these estimates."""
        unknowns, known, smooth = self.unknowns, self.known, _shifted(self.smooth, zero)
        equations, inertial, measured = unknowns.equations, unknowns.inertial, quantities(self.run)
        press = equations.pressed(at[:inertial]) if set(BY_FORCE) & set(self.losses.friction) and at[inertial:].any() else equations.press
        coefficients, added, found = equations.coefficients(smooth.angle, tuple(measured)), added_masses(equations, self.run), []
        for name, values in measured.items():
            inside = smooth.equations(coefficients[name])
            columns, extra = np.zeros((len(inside), len(at))), inside @ added
            columns[:, :inertial] = inside
            if name == "torque":  # friction is between links, the cylinder stands on the frame: nothing reaches the foundation
                columns[:, inertial : unknowns.zero] = loss_rows(press, smooth, self.losses, _cylinder(unknowns, at))
                if known.inertia:
                    extra = extra + smooth.equations(_constant_inertia(smooth.angle, known.inertia))[:, 0]
                if known.loads:
                    motion = moved(equations.press, equations.press.branch, smooth.angle, smooth.speed, 0.0 * smooth.angle, None, "auto")
                    plain, loaded = (inverse_dynamics(equations.press, motion, loads, bearings=()) for loads in ((), known.loads))
                    extra = extra + smooth.integrals((loaded.driving_torque - plain.driving_torque)[:, None])[:, 0]
            rows = columns, smooth.measured(values), extra
            found.append(Rows(name, *(rows if name == "torque" else map(smooth.without_offset, rows))))
        return found


def loss_rows(press: Linkage, smooth: SmoothAngle, losses: Losses, cylinder: tuple[float, float] = (0.0, 0.0)) -> Array:
    """(rows, losses) of a run by its losses; forces in bearings are those of this press with this cylinder."""
    angle, speed, acceleration = smooth.angle, smooth.speed, smooth.acceleration
    friction, there = losses.friction, losses.cylinder
    return smooth.integrals(loss_columns(press, angle, speed, acceleration, friction, there, radii=losses.radii, cylinder_load=cylinder))


def _shifted(smooth: SmoothAngle, zero: float) -> SmoothAngle:
    return smooth._replace(angle=smooth.angle - zero)


def _cylinder(unknowns: Unknowns, values: Array) -> tuple[float, float]:
    """Force and stiffness of the balance cylinder among the unknowns."""
    there = unknowns.cylinder
    return (0.0, 0.0) if there is None else (float(values[there[0]]), float(values[there[1]]))


def _constant_inertia(angle: Array, inertia: float) -> Coefficients:
    one = np.ones((len(angle), 1))
    return Coefficients(inertia * one, 0 * one, 0 * one, 0.5)


def added_masses(equations: InertialEquations, run: MeasuredRun) -> Array:
    """(inertial,) parameters of masses that were fastened to links."""
    added, starts = np.zeros(len(equations.parameters)), np.cumsum([0, *(basis.shape[1] for basis in equations.bases)])
    model = equations.press.model
    for link, mass in run.added_mass.items():
        frame = model.frames[model.getFrameId(link)]
        if frame.parentJoint == 0:
            continue  # on the frame of the press it makes no torque
        at, basis = frame.placement.translation, equations.bases[frame.parentJoint - 1]
        tensor = mass * (at @ at * np.eye(3) - np.outer(at, at))
        ten = np.array([mass, *(mass * at), tensor[0, 0], tensor[0, 1], tensor[1, 1], tensor[0, 2], tensor[1, 2], tensor[2, 2]])
        own = ten if basis.shape[1] == 10 else _plane_part(basis, ten)
        added[starts[frame.parentJoint - 1] : starts[frame.parentJoint]] += own
    return added


def _plane_part(basis: Array, ten: Array) -> Array:
    """The four parameters in the plane of the ten of a mass at a point."""
    first, second = basis[1:4, 1] @ ten[1:4], basis[1:4, 2] @ ten[1:4]
    return np.array([ten[0], first, second, (first**2 + second**2) / ten[0]])
