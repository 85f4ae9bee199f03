"""A press with a rod of finite elements beside Exudyn's floating frame of reference (ObjectFFRFreducedOrder), in the same run."""

import numpy as np
import pytest
import scipy.sparse
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import Elastic, FlexibleLink, Stiffness
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.elastic.equations import ElasticEquations, HeldCrank
from pinpress.simulation.elastic.march import march
from pinpress.simulation.elastic.press.assembly import sprung_press
from pinpress.simulation.elastic.press.paths import load_path
from pinpress.simulation.elastic.strokes import Strokes
from pinpress.simulation.elastic.task import Task

LENGTH, HIGH, THICK, COLUMNS, ROWS = 0.3, 0.04, 0.1, 10, 2  # of the rod, and its elements
MASS, INERTIA = 77.49, 77.49 * 0.3**2 / 12


def plane_stress(modulus, ratio, a, b):
    """Stiffness (8, 8), and mass (4, 4) of one direction for a mass of 1, of a rectangle a x b, by Gauss points."""
    law = modulus / (1 - ratio**2) * np.array([[1, ratio, 0], [ratio, 1, 0], [0, 0, (1 - ratio) / 2]])
    signs, stiffness, mass = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), np.zeros((8, 8)), np.zeros((4, 4))
    for x in (-(3**-0.5), 3**-0.5):
        for y in (-(3**-0.5), 3**-0.5):
            shape = 0.25 * (1 + signs[:, 0] * x) * (1 + signs[:, 1] * y)
            by_x, by_y = 0.5 / a * signs[:, 0] * (1 + signs[:, 1] * y), 0.5 / b * signs[:, 1] * (1 + signs[:, 0] * x)
            strain = np.zeros((3, 8))
            strain[0, ::2], strain[1, 1::2], strain[2, ::2], strain[2, 1::2] = by_x, by_y, by_y, by_x
            stiffness += 0.25 * a * b * THICK * strain.T @ law @ strain
            mass += 0.25 * np.outer(shape, shape)
    return stiffness, mass


def rod():
    """Rows of the matrices are x and y of each node; density rises to the ends, so that the moment of inertia is the press's."""
    a, b = LENGTH / COLUMNS, HIGH / ROWS
    nodes = np.array([[i * a, j * b - HIGH / 2] for i in range(COLUMNS + 1) for j in range(ROWS + 1)])
    mass, stiffness = np.zeros((2, len(nodes), len(nodes))), np.zeros((2 * len(nodes),) * 2)
    element = plane_stress(2.1e11, 0.3, a, b)
    for i in range(COLUMNS):
        for j in range(ROWS):
            corners = np.array([i, i + 1, i + 1, i]) * (ROWS + 1) + [j, j, j + 1, j + 1]
            for k, weight in enumerate((1.0, (i + 0.5 - COLUMNS / 2) ** 2)):
                mass[k][np.ix_(corners, corners)] += weight * element[1]
            rows = (2 * corners[:, None] + [0, 1]).ravel()
            stiffness[np.ix_(rows, rows)] += element[0]
    about = nodes - [LENGTH / 2, 0]
    moments = [[each.sum(), np.einsum("ik,ij,jk->", about, each, about)] for each in mass]
    each_way = np.tensordot(np.linalg.solve(np.transpose(moments), [MASS, INERTIA]), mass, 1)
    degrees = [[node, along] for node in range(len(nodes)) for along in (0, 1)]
    ends = {"P2": ROWS // 2, "P4": COLUMNS * (ROWS + 1) + ROWS // 2}
    link = FlexibleLink("main_rod", ends, np.kron(each_way, np.eye(2)), stiffness, nodes, degrees, modes=4, damping_ratio=0.0)
    return link, each_way


@pytest.mark.exhaustive
def test_half_a_stroke():
    pytest.importorskip("exudyn")
    press, speed, (link, each_way) = shipped("jf75g_125_plain"), 900 * pp.RPM, rod()
    stiffness = Stiffness(dict.fromkeys(press.bearings, 2e9), moments={"slide_guide": 2e8})
    sprung = sprung_press(press, Elastic(stiffness, flexible_links=[link]))
    start, until = pp.dead_centres(press).bottom_angle - np.pi, np.pi / speed
    driven = driven_press(press, pp.drives.PrescribedSpeed(speed), None, [], None, None)
    paths = tuple(load_path(sprung, coordinate) for coordinate in driven.coordinates)
    equations = ElasticEquations(sprung, driven, paths, HeldCrank(start, speed), segments=((),))
    whole = [each[0] for each in sprung.geometry.rigid(pp.servo_cycle(press, angle=[start], speed=speed))]
    y, v = sprung.free_coordinates(whole[0][None])[0, :-1], sprung.free_rates(whole[1][None])[0, :-1]
    task = Task(equations, Strokes(driven, 1), lambda times: (times, times, times), 2 * until, speed, np.zeros(2 * len(y)), 1e-10)
    ended = march(task, start, np.concatenate([y, v]), until).panels.states[-1:]
    state = equations.state(np.array([until]), *np.split(ended, 2, axis=1))
    pulls = -sprung.pulls(sprung.geometry.strains(state))[0]
    theirs = exudyn_pulls(sprung, whole, link, each_way, until)
    np.testing.assert_allclose(
        theirs, pulls, rtol=0, atol=3e-9 * np.abs(pulls).max()
    )  # the terms of Coriolis are 2e-8, centrifugal ones 4e-5
    assert np.abs(state.coordinates[0, sprung.geometry.flexible[0].columns]).max() > 1e-5  # it bends


def exudyn_pulls(sprung, whole, link, each_way, until):
    import exudyn
    from exudyn import FEM
    from exudyn import itemInterface as items  # noqa: N813

    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    ground, bent, press = mbs.AddObject(items.ObjectGround()), sprung.geometry.flexible[0], sprung.press
    bodies, angles = {}, {}
    for j in range(press.model.nv):
        centre, place, rates = sprung.geometry.centers[j], whole[0][3 * j : 3 * j + 3], whole[1][3 * j : 3 * j + 3]
        weight = [*sprung.geometry.weight[3 * j : 3 * j + 2].tolist(), 0.0]
        at = np.array([centre.real + place[0], centre.imag + place[1], 0.0])
        if j == bent.body:
            model = FEM.FEMinterface()
            model.nodes = {"Position": np.column_stack([bent.places.real, bent.places.imag, np.zeros(len(bent.places))])}
            model.massMatrix = scipy.sparse.csr_matrix(np.kron(each_way, np.eye(3)))
            count = len(bent.places)
            rows = np.arange(3 * count).reshape(-1, 3)[:, :2].ravel()
            space, turned = np.zeros((3 * count, 3 * count)), np.zeros((3 * count, bent.shapes.shape[1]))
            turn = np.kron(np.eye(count), _turn(link, bent))
            space[np.ix_(rows, rows)] = turn @ link.stiffness @ turn.T
            model.stiffnessMatrix = scipy.sparse.csr_matrix(space)
            turned[::3], turned[1::3] = bent.shapes.real, bent.shapes.imag
            model.modeBasis = {"matrix": turned, "type": "HCBmodes"}
            reduced = FEM.ObjectFFRFreducedOrderInterface(model, rigidBodyNodeType=exudyn.NodeType.RotationRxyz)
            cosine, sine = np.cos(place[2]), np.sin(place[2])
            made = reduced.AddObjectFFRFreducedOrder(
                mbs,
                positionRef=at.tolist(),
                initialVelocity=[*rates[:2].tolist(), 0.0],
                rotationMatrixRef=np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]]),
                initialAngularVelocity=[0.0, 0.0, float(rates[2])],
                gravity=[each / bent.mass for each in weight],
            )
            bodies[j] = made["oFFRFreducedOrder"]
            continue
        turning = 1e14 if j == press.driver_indices[0] else sprung.geometry.inertia[3 * j + 2]  # it holds the crank's speed
        node = mbs.AddNode(
            items.NodeRigidBody2D(
                referenceCoordinates=[centre.real, centre.imag, 0.0], initialCoordinates=place.tolist(), initialVelocities=rates.tolist()
            )
        )
        bodies[j] = mbs.AddObject(items.ObjectRigidBody2D(mass=sprung.geometry.inertia[3 * j], inertia=turning, nodeNumber=node))
        own = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=bodies[j], localPosition=[0.0, 0.0, 0.0]))
        mbs.AddLoad(items.LoadForceVector(markerNumber=own, loadVector=weight))
        angles[j] = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=2))

    def marker(body, arm, bearing):
        if body == press.model.nv:
            return mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=[arm.real, arm.imag, 0.0]))
        if body == bent.body:
            node = link.bearings[press.bearings[bearing]]
            return mbs.AddMarker(items.MarkerSuperElementPosition(bodyNumber=bodies[body], meshNodeNumbers=[node], weightingFactors=[1.0]))
        return mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=bodies[body], localPosition=[arm.real, arm.imag, 0.0]))

    lines, own, turns, springs = sprung.geometry.lines, sprung.springs, sprung.linear, []
    for k, along in enumerate(lines.direction):
        stiff, damp = ([value * abs(along.real), value * abs(along.imag), 0.0] for value in (own.stiffness[k], own.damping[k]))
        sides = ((lines.first[k], lines.arm1[k]), (lines.second[k], lines.arm2[k]))
        ends = [marker(int(body), complex(arm), int(own.bearing[k])) for body, arm in sides]
        springs.append(mbs.AddObject(items.ObjectConnectorCartesianSpringDamper(markerNumbers=ends, stiffness=stiff, damping=damp)))
    fixed = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))
    for k, body in enumerate(int(row.argmax()) // 3 for row in turns.rows[turns.shared > 0]):  # without the shapes of the rod
        given = {"stiffness": float(turns.stiffness[k]), "damping": float(turns.damping[k])}
        mbs.AddObject(items.ObjectConnectorCoordinateSpringDamper(markerNumbers=[fixed, angles[int(body)]], **given))
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.endTime = until
    settings.timeIntegration.numberOfSteps = 1000
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.timeIntegration.absoluteTolerance = settings.timeIntegration.relativeTolerance = 1e-10
    mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.DOPRI5)
    forces = np.array([mbs.GetObjectOutput(spring, exudyn.OutputVariableType.Force) for spring in springs])
    return forces[:, 0] * lines.direction.real + forces[:, 1] * lines.direction.imag


def _turn(link, bent):
    """(2, 2) from the axes of the rod's model to those of the plane."""
    ends = [link.nodes[node] @ (1, 1j) for node in link.bearings.values()], [bent.places[node] for node in link.bearings.values()]
    turn = (ends[1][1] - ends[1][0]) / (ends[0][1] - ends[0][0])
    return np.array([[turn.real, -turn.imag], [turn.imag, turn.real]])
