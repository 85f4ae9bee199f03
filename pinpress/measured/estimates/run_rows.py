"""The rows of a run for all unknowns, linearised about present estimates: masses, losses, forces in bearings, encoder zero.

The equations (`weak_form`) hold at the crank's angle, which is the encoder's reading minus its zero z. With all other unknowns at their
last estimates, the rows change with z as

    d rows / dz = (rows at zero z + h  -  rows at zero z - h) / (2 h).

Repeated passes are the Gauss-Newton method.
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
from .prior import Losses, Unknowns, about_joint
from .weak_form import Rows, SmoothAngle, quantities

TURN = 1e-5  # step h of the zero for the slopes [rad]
BY_FORCE = ("pins", "slide_guide")  # friction that grows with the forces in bearings


class RunEquations(NamedTuple):
    """The equations of a run.

    Attributes:
        unknowns: the unknowns of the press.
        losses: the losses that are identified.
        drive_inertia: inertia at the crank that is not part of the press [kg m2].
        loads: known loads.
        run: the record.
        smooth: the smoothed reading of the encoder.
    """

    unknowns: Unknowns
    losses: Losses
    drive_inertia: float
    loads: tuple[Load, ...]
    run: MeasuredRun
    smooth: SmoothAngle

    def rows(self, estimate: Array, slopes: Mapping[str, Array]) -> list[Rows]:
        """Rows for all unknowns, linearised about an estimate (unknowns,).

        Args:
            estimate: the estimate.
            slopes: slopes of friction from `friction_slopes`; empty if the forces in bearings are those of the estimate.
        """
        zero = self.unknowns.zero
        here, ahead, behind = (self._rows_at(estimate, estimate[zero] + step) for step in (0.0, TURN, -TURN))
        changing = sum((estimate[self.unknowns.place(name)] * each for name, each in slopes.items()), np.zeros(1))
        rows = []
        for row, after, before in zip(here, ahead, behind, strict=True):
            more = np.zeros((len(row.values), len(estimate)))
            more[:, zero] = (after.columns @ estimate + after.known - before.columns @ estimate - before.known) / (2 * TURN)
            if row.quantity == "torque":
                more = more + changing
            rows.append(row._replace(columns=row.columns + more, known=row.known - more @ estimate))
        return rows

    def friction_slopes(self, estimate: Array) -> dict[str, Array]:
        """Name of a loss -> (rows, unknowns) derivative of its torque by each mass, inertia and parameter of the cylinder.

        Only friction in pins and guide depends on them, because it depends on the forces in the bearings.
        """
        unknowns, losses = self.unknowns, self.losses
        smooth = self.smooth._replace(angle=self.smooth.angle - estimate[unknowns.zero])
        by_force = [name for name in losses.friction if name in BY_FORCE]
        third = slice(None, None, 3)  # points between are interpolated
        points = smooth.angle[third], smooth.speed[third], smooth.acceleration[third]

        def friction(values: Array) -> Array:
            press, load = unknowns.equations.pressed(values[: unknowns.inertial]), _cylinder_load(unknowns, values)
            return loss_columns(press, *points, by_force, False, radii=losses.radii, cylinder_load=load)

        def slope(change: Array) -> Array:
            step = 1e-3
            return np.asarray(friction(estimate + step * change) - plain) / step

        plain, spread = friction(estimate), unknowns.at(np.zeros(unknowns.inertial))[1]
        moving = np.abs(spread).max(axis=0) > 0
        others = np.zeros(len(estimate) - unknowns.inertial)
        by_deviation = np.stack([slope(np.append(change, others)) for change in spread[:, moving].T], axis=-1)
        slopes = np.zeros((len(by_force), len(points[0]), len(estimate)))
        slopes[:, :, : unknowns.inertial] = by_deviation.swapaxes(0, 1) @ np.linalg.pinv(spread[:, moving])
        if unknowns.cylinder is not None:
            weight = GRAVITY * sum(each.mass for each in unknowns.equations.press.model.inertias)
            for k, size in zip(unknowns.cylinder, (weight, weight / unknowns.equations.press.size), strict=True):
                slopes[:, :, k] = slope(size * np.eye(len(estimate))[k]).T / size
        places = np.arange(len(smooth.angle))
        names = [each.name for each in loss_parameters(by_force, False, losses.radii is not None)]
        return {
            name: smooth.integrals(np.stack([np.interp(places, places[third], column) for column in columns.T], axis=1))
            for name, columns in zip(names, slopes, strict=True)
        }

    def _rows_at(self, estimate: Array, zero: float) -> list[Rows]:
        """Rows for this zero of the encoder, with the bearing forces of the estimated press and cylinder."""
        unknowns, smooth = self.unknowns, self.smooth._replace(angle=self.smooth.angle - zero)
        equations, inertial, measured = unknowns.equations, unknowns.inertial, quantities(self.run)
        coefficients, added, rows = equations.coefficients(smooth.angle, tuple(measured)), added_masses(equations, self.run), []
        for name, values in measured.items():
            inside = smooth.equations(coefficients[name])
            columns, extra = np.zeros((len(inside), len(estimate))), inside @ added
            columns[:, :inertial] = inside
            if name == "torque":  # friction acts between links, and the cylinder stands on the frame: nothing reaches the foundation
                by_force = set(BY_FORCE) & set(self.losses.friction) and estimate[inertial:].any()
                press = equations.pressed(estimate[:inertial]) if by_force else equations.press
                columns[:, inertial : unknowns.zero] = loss_rows(press, smooth, self.losses, _cylinder_load(unknowns, estimate))
                if self.drive_inertia:
                    one = np.ones((len(smooth.angle), 1))
                    extra = extra + smooth.equations(Coefficients(self.drive_inertia * one, 0 * one, 0 * one, 0.5))[:, 0]
                if self.loads:
                    extra = extra + smooth.integrals(load_torque(equations.press, smooth.angle, smooth.speed, self.loads)[:, None])[:, 0]
            row = columns, smooth.measured(values), extra
            rows.append(Rows(name, *(row if name == "torque" else map(smooth.without_offset, row))))
        return rows


def loss_rows(press: Linkage, smooth: SmoothAngle, losses: Losses, cylinder_load: tuple[float, float] = (0.0, 0.0)) -> Array:
    """(rows, losses) of a run for its losses, with the bearing forces of this press under this force of its cylinder."""
    state = smooth.angle, smooth.speed, smooth.acceleration
    return smooth.integrals(loss_columns(press, *state, losses.friction, losses.cylinder, radii=losses.radii, cylinder_load=cylinder_load))


def load_torque(press: Linkage, angle: Array, speed: Array | float, loads: tuple[Load, ...]) -> Array:
    """(n,) torque at the crank that known loads need."""
    motion = moved(press, press.branch, angle, speed, 0.0, None, press.engine())
    plain, loaded = (inverse_dynamics(press, motion, each, bearings=()).driving_torque for each in ((), loads))
    return np.asarray(loaded - plain)


def _cylinder_load(unknowns: Unknowns, values: Array) -> tuple[float, float]:
    """Force and stiffness of the balance cylinder among the unknowns."""
    places = unknowns.cylinder
    return (0.0, 0.0) if places is None else (float(values[places[0]]), float(values[places[1]]))


def added_masses(equations: InertialEquations, run: MeasuredRun) -> Array:
    """(inertial,) parameters of masses that were fastened to links."""
    added, model = np.zeros(len(equations.parameters)), equations.press.model
    for link, mass in run.added_mass.items():
        frame = model.frames[model.getFrameId(link)]
        if frame.parentJoint == 0:
            continue  # a mass on the frame of the press needs no torque
        basis, place = equations.bases[frame.parentJoint - 1], equations.places[frame.parentJoint - 1]
        axes = basis[1:4, 1:3] if basis.shape[1] == 4 else np.eye(3)
        point = np.zeros(basis.shape[1])
        point[0], point[1 : 1 + axes.shape[1]] = mass, frame.placement.translation @ axes
        added[place] += about_joint(point)[0]
    return added
