"""A press in space on springs, with a universal and a ball joint, beside Exudyn's rigid bodies, in the same run.

Against turning, a spring of pinpress pulls with the cosine between an axis of one body and one of the other, square to it where the joint
is not twisted. Exudyn's `ObjectConnectorRigidBodySpringDamper` takes angles of rotation, which differ beyond the first order, and a
universal joint it has not; so it gets that law as a function.
"""

from typing import Any

import numpy as np
import pytest
from support.presses.presses_on_springs import PINS, rssp, stiffness_of

import pinpress as pp

TORQUE, SPEED, STIFFNESS = 50.0, 100 * pp.RPM, 2e8
STEP = 8e-6  # of Exudyn's Runge-Kutta method of order 4 [s]


UNTIL = 0.022  # three swings of the lowest vibration [s]


@pytest.mark.exhaustive
def test_press_in_space_beside_exudyn():
    """From the same state, under a torque: places and turns of all links at the end."""
    press = rssp()
    elastic = pp.elasticity.Elastic(stiffness_of(press, STIFFNESS, PINS), damping_ratio=0.002)
    run = pp.simulate(press, UNTIL, speed=SPEED, drive=pp.drives.ConstantTorque(TORQUE), elastic=elastic, tolerance=1e-8)
    segment: Any = run.trajectory.segments[0]
    solution = segment.solution
    sprung, states = solution.equations.sprung, solution.panels.states[[0, -1]]
    geometry, state = sprung.geometry, sprung.state(*np.split(states, 2, axis=1), derivatives=False)
    places, speeds = geometry.places(state.coordinates), geometry.places(state.rates)
    matrices, changes = (each.reshape(2, -1, 3, 3) for each in (state.turned.matrix, state.turned.rate))
    start = [(places[0, b], matrices[0, b], speeds[0, b], changes[0, b] @ matrices[0, b].T) for b in range(geometry.count)]
    theirs = exudyn_ends(sprung, start)
    for body, (place, matrix) in enumerate(theirs):
        np.testing.assert_allclose(place, places[1, body], rtol=0, atol=1e-12)
        np.testing.assert_allclose(matrix, matrices[1, body], rtol=0, atol=3e-11)
    assert np.abs(run.displacement[..., :3]).max() > 1e-6  # it yields
    assert np.abs(run.displacement[..., 3:]).max() > 5e-6  # and twists


def exudyn_ends(sprung, start):
    """Places and matrices of the bodies at the end, from places, matrices, velocities and skew matrices of angular velocity."""
    import exudyn
    from exudyn import itemInterface as items  # noqa: N813
    from exudyn.utilities import RigidBodyInertia

    mbs = exudyn.SystemContainer().AddSystem()
    inertias, bodies = sprung.press.model.inertias, []
    for body, (place, matrix, speed, spin) in enumerate(start):
        axes = sprung.geometry.own_axes[body]
        made = mbs.CreateRigidBody(
            inertia=RigidBodyInertia(sprung.geometry.mass_of[body], axes.T @ inertias[sprung.geometry.joints[body]].inertia @ axes),
            referencePosition=place.tolist(),
            referenceRotationMatrix=matrix,
            initialVelocity=speed.tolist(),
            initialAngularVelocity=[spin[2, 1], spin[0, 2], spin[1, 0]],
            gravity=sprung.geometry.gravity.tolist(),
            nodeType=exudyn.NodeType.RotationRotationVector,
            returnDict=True,
        )
        bodies.append(made["bodyNumber"])
    bodies.append(mbs.AddObject(items.ObjectGround()))

    def marker(body, place):
        return mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=bodies[body], localPosition=place.tolist()))

    springs, lines = sprung.springs, sprung.geometry.lines
    for bearing in np.unique(springs.bearing):
        own = np.flatnonzero(springs.bearing == bearing)
        straight, twisting = own[lines.place[own] > 0], own[lines.place[own] == 0]
        k = straight[0]
        ends = [marker(lines.first[k], lines.arm1[k]), marker(lines.second[k], lines.arm2[k])]
        along = np.abs(lines.direction[straight]).sum(axis=0)  # bearings pull along the world's axes
        stiff, damp = (springs.stiffness[k] * along).tolist(), (springs.damping[k] * along).tolist()
        mbs.AddObject(items.ObjectConnectorCartesianSpringDamper(markerNumbers=ends, stiffness=stiff, damping=damp))
        if len(twisting):
            law = by_cosines([(lines.direction[i], lines.arm2[i], springs.stiffness[i], springs.damping[i]) for i in twisting])
            mbs.AddObject(items.ObjectConnectorRigidBodySpringDamper(markerNumbers=ends, springForceTorqueUserFunction=law))
    crank = marker(sprung.geometry.crank_body, np.zeros(3))  # whose third axis is its own
    mbs.AddLoad(items.LoadTorqueVector(markerNumber=crank, loadVector=[0.0, 0.0, TORQUE], bodyFixed=True))
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.endTime = UNTIL
    settings.timeIntegration.numberOfSteps = round(UNTIL / STEP)
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.RK44)
    kinds = exudyn.OutputVariableType.Position, exudyn.OutputVariableType.RotationMatrix
    found = ([np.array(mbs.GetObjectOutputBody(body, kind, [0.0, 0.0, 0.0])) for kind in kinds] for body in bodies[:-1])
    return [(place, matrix.reshape(3, 3)) for place, matrix in found]


def by_cosines(pairs):
    """Torque of springs between axes (one of each body, stiffness, damping), in the axes of the first body."""

    def law(mbs, time, item, displacement, rotation, velocity, angular_velocity, *others):
        turned, torque = in_turn(rotation), np.zeros(3)
        for one, other, stiffness, damping in pairs:
            axis = turned @ other
            lever = np.cross(axis, one)
            torque += (stiffness * (one @ axis) + damping * (lever @ angular_velocity)) * lever
        return [0.0, 0.0, 0.0, *torque]

    return law


def in_turn(angles):
    """Rotation by angles about the first, the second and the third axis of the turned body."""
    (a, b, c), (x, y, z) = np.cos(angles), np.sin(angles)
    return np.array([[b * c, -b * z, y], [x * y * c + a * z, -x * y * z + a * c, -x * b], [-a * y * c + x * z, a * y * z + x * c, a * b]])
