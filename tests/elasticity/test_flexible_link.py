"""Links that bend: against closed forms of beams, rods as springs, the rigid limit, energy, and what cannot be."""

from typing import Any

import numpy as np
import pytest
import scipy.io
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import Elastic, FlexibleLink, Rod, Stiffness, flexible_beam, natural_frequencies, read_flexible_link
from pinpress.elasticity.straight_beam import _beam_stiffness
from pinpress.engines.planar.model import to_complex
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.elastic.parts_in_words import elastic_in_words
from pinpress.simulation.elastic.press.assembly import pins_of, rigid_inertia, sprung_press
from pinpress.simulation.elastic.press.paths import load_path
from pinpress.simulation.elastic.press.plane import DrawnBodies

JF75G, SIX_BAR = "jf75g_125_plain", "zxn2_3000b"
STEEL, AREA, BENDING = 2.1e11, 0.033, 4e-5  # [Pa, m2, m4]
LENGTH, MASS = 0.3, 77.49  # of the main rod of the JF75G, of even section
PINNED = (np.pi / LENGTH) ** 2 * np.sqrt(STEEL * BENDING / (MASS / LENGTH))  # [rad/s]


ACROSS = np.array([4.730040745, 7.853204624]) ** 2 / LENGTH**2 * np.sqrt(STEEL * BENDING * LENGTH / MASS)  # free, across and along
ALONG = np.pi * np.sqrt(STEEL * AREA / (MASS * LENGTH))


def nearest(values, wanted):
    return [int(np.abs(values - each).argmin()) for each in wanted]


def main_rod(**more):
    return flexible_beam(shipped(JF75G), "main_rod", ("P2", "P4"), **{"area": AREA, "second_moment": BENDING} | more)


def stiffness_of(press, value=2e9, **more):
    guides = [joint for joint, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
    return Stiffness(dict.fromkeys(press.bearings, value), moments=dict.fromkeys(guides, 0.1 * value), **more)


def test_free_beam():
    """(beta l)^2 sqrt(E I / m l^3) with cosh(x) cos(x) = 1, and along it pi c / l; of fourth order in the elements."""
    errors = []
    for count in (6, 12):
        found = main_rod(elements=count, modes=50).natural_frequency
        errors.append(np.abs(found[nearest(found, ACROSS)] / ACROSS - 1).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)
    assert errors[1] < 2e-4
    found = main_rod(elements=40, modes=50).natural_frequency
    assert found[nearest(found, [ALONG])] == pytest.approx(ALONG, rel=3e-4)


def test_vibrations_that_are_kept():
    """Frequencies come down to those of all elements as more vibrations are kept."""
    full, found = main_rod(modes=50).natural_frequency[0], [main_rod(modes=count).natural_frequency[0] for count in (1, 6, 20)]
    assert found[0] > found[1] > found[2] > full * (1 - 1e-12)
    assert found[2] == pytest.approx(full, rel=1e-3)


def test_beam_on_pins_in_the_press():
    """(pi / l)^2 sqrt(E I l / m) between stiff pins, with the crank at its dead centre."""
    press, soft = shipped(JF75G), main_rod(second_moment=BENDING / 100)
    elastic = Elastic(stiffness_of(press, 1e12), flexible_links=[soft])
    modes = natural_frequencies(press, elastic, angle=pp.dead_centres(press).bottom_angle)
    assert modes.natural_frequency[0, 0] == pytest.approx(PINNED / 10, rel=2e-4)
    assert modes.words(0, 0)[0] == "main_rod 100 %"
    assert 0.004 < modes.damping_ratio[0, 0] < 0.01  # that of the free link, less its lower frequency


@pytest.mark.parametrize(("modes", "share"), [(50, 1.0), (1, 96 / np.pi**4)])
def test_beam_bent_by_a_force_at_its_middle(modes, share):
    """F l^3 / 48 E I; the lowest vibration alone bends by 96 / pi^4 of it."""
    found = main_rod(modes=modes)._reduced
    across = (found.shapes[4] - 0.5 * (found.shapes[0] + found.shapes[8])).imag
    assert (across**2 / found.frequency**2).sum() == pytest.approx(share * LENGTH**3 / (48 * STEEL * BENDING), rel=1e-4)


def test_beam_stretched_by_its_own_turning():
    """m w^2 l^2 / 12 E A of a beam that turns at w; and what couples stretching with bending, by integrals of the shapes."""
    found = main_rod(elements=60, modes=50)._reduced
    longer = ((found.shapes[-1] - found.shapes[0]).real * found.stretch / found.frequency**2).sum()
    assert longer == pytest.approx(MASS * LENGTH**2 / (12 * STEEL * AREA), rel=1e-3)
    place, beta = (np.arange(20000) + 0.5) / 20000, 7.853204624
    bent = np.cosh(beta * place) + np.cos(beta * place) - 1.000777312 * (np.sinh(beta * place) + np.sin(beta * place))
    stretched = np.sqrt(2) * np.cos(np.pi * place)
    along, second = nearest(found.frequency, [ALONG, ACROSS[1]])
    assert abs(found.swirl[along, second]) == pytest.approx(abs((bent * stretched).mean()), rel=5e-3)


def slide_compliance(press, elastic, angles):
    """(n,) how far the slide yields under a static force of 1 N: each mode by its share over its squared frequency."""
    modes, sprung = natural_frequencies(press, elastic, angle=angles), sprung_press(press, elastic)
    driven = driven_press(press, pp.drives.PrescribedSpeed(1.0), None, [pp.loads.ConstantForce(1e5, 0.01)], None, None, {})
    place, _, _ = sprung.geometry.rigid(pp.servo_cycle(press, angle=angles, speed=0.0))
    count = modes.natural_frequency.shape[1]
    full = np.zeros((len(angles) * count, place.shape[1]))
    full[:, : 3 * press.model.nv] = modes.shapes.reshape(len(full), -1)
    moved = sprung.geometry.state(np.repeat(place, count, axis=0), full)
    slide = load_path(sprung, driven.coordinates[0]).over(sprung, moved).rate.reshape(-1, count)
    return (slide**2 / modes.natural_frequency**2).sum(axis=1)


def test_a_beam_between_pins_yields_as_a_rod():
    """Under a static force on the slide: pins bend no beam."""
    press, angles = shipped(SIX_BAR), np.array([0.1, 2.2, 5.1])
    beams = [
        flexible_beam(press, "coupler", ("B", "C"), area=0.03, second_moment=1e-4, modes=2),
        flexible_beam(press, "rod", ("F", "E"), area=0.06, second_moment=3e-4, modes=3),
    ]
    elastic = Elastic(stiffness_of(press), flexible_links=beams)
    rods = [Rod("coupler", ("B", "C"), STEEL * 0.03 / 1.243), Rod("rod", ("E", "F"), STEEL * 0.06 / 0.48)]
    expected = pp.elasticity.compliance(press, stiffness_of(press, rods=rods), angle=angles).compliance
    np.testing.assert_allclose(slide_compliance(press, elastic, angles), expected, rtol=1e-9)
    modes = natural_frequencies(press, elastic, angle=angles)
    for shares in (modes.strain_energy, modes.kinetic_energy):
        np.testing.assert_allclose(sum(shares.values()), 1.0, rtol=1e-12)


def three_arms(press, axial, bending):
    """The rocker of the six-bar as three beams from its centre of mass to its bearings, whose mass is nearly all at the centre."""
    drawn = DrawnBodies(press)
    body, pins = pins_of(drawn, "rocker")
    own = rigid_inertia(drawn, body)
    arms = {name: place - own.centre for name, place in pins.items()}
    nodes = np.array([[0.0, 0.0], *([arm.real, arm.imag] for arm in arms.values())])
    mass, stiffness = np.diag([own.mass, own.mass, own.inertia, *np.tile([1.0, 1.0, 1e-3], len(arms))]), np.zeros((12, 12))
    for k, arm in enumerate(arms.values(), 1):
        along, rows = arm / abs(arm), np.r_[0:3, 3 * k : 3 * k + 3]
        turn = np.kron(np.eye(2), [[along.real, along.imag, 0], [-along.imag, along.real, 0], [0, 0, 1]])
        stiffness[np.ix_(rows, rows)] += turn.T @ _beam_stiffness(axial, bending, abs(arm)) @ turn
    degrees = [[node, along] for node in range(len(nodes)) for along in range(3)]
    return FlexibleLink("rocker", {name: k for k, name in enumerate(arms, 1)}, mass, stiffness, nodes, degrees, modes=50), body, arms


def test_a_link_of_three_pins_bends_under_load():
    """Its arms are cantilevers: the slide yields by the work of F^2 l / E A + F^2 l^3 / 3 E I in each, beside what the springs yield."""
    press, angles, axial, bending = shipped(SIX_BAR), np.array([0.4, 2.2, 5.1]), 1e10, 2e7
    link, body, arms = three_arms(press, axial, bending)
    motion = pp.servo_cycle(press, angle=angles, speed=0.0)
    loads = [[pp.loads.PointForce("slide", tuple(force * press.slide_direction))] for force in (1e6, 0.0)]
    pushed, idle = (pp.inverse_dynamics(press, motion, loads=each) for each in loads)
    drawn, found = DrawnBodies(press), 0.0
    turned = np.exp(1j * sprung_press(press, Elastic(stiffness_of(press))).geometry.rigid(motion)[0][:, 3 * body + 2])
    for name, arm in arms.items():
        force = to_complex(drawn.plane, pushed.bearing_force[name] - idle.bearing_force[name]) / 1e6
        own, length = force / (turned * arm / abs(arm)), abs(arm)
        found = found + own.real**2 * length / axial + own.imag**2 * length**3 / (3 * bending)
    springs = pp.elasticity.compliance(press, stiffness_of(press), angle=angles).compliance
    assert (found > 0.05 * springs).all()
    yields = slide_compliance(press, Elastic(stiffness_of(press), damping_ratio=0.0, flexible_links=[link]), angles)
    np.testing.assert_allclose(yields, springs + found, rtol=1e-7)


def test_derivatives():
    """Of springs on links that bend, a rod beside them, and of their inertia, by differences."""
    press, rng = shipped(SIX_BAR), np.random.default_rng(1)
    beam = flexible_beam(press, "coupler", ("B", "C"), area=0.03, second_moment=1e-4, modes=3)
    stiffness = stiffness_of(press, rods=[Rod("rod", ("E", "F"), 9e8), Rod("rocker", ("D", "C"), 9e8)], frame=4e9)
    sprung = sprung_press(press, Elastic(stiffness, crown_mass=5000.0, damping_ratio=0.1, flexible_links=[beam]))
    place, _, _ = sprung.geometry.rigid(pp.servo_cycle(press, angle=[0.3, 2.0], speed=1.0))
    free = sprung.free_coordinates(place) + 1e-3 * rng.normal(size=(2, sprung.free))
    state = free, rng.normal(size=free.shape), rng.normal(size=free.shape)

    def forces(y, v, a):
        return -sprung.spring_forces(sprung.state(y, v), False).force

    def inertia(y, v, a):
        return sprung.varying_inertia(sprung.state(y, v), a)

    def kinetic(y, v):
        return sprung.geometry.kinetic_energy(sprung.state(y, v)) - 0.5 * np.einsum("nf,fg,ng->n", v, sprung.mass, v)

    at, given = sprung.spring_forces(sprung.state(free, state[1])), inertia(*state)
    steps = 1e-6 * np.eye(sprung.free)
    for which, found, law in (
        (0, at.stiffness, forces),
        (1, at.damping, forces),
        (0, given.by_place, lambda *of: inertia(*of).force),
        (1, given.by_rate, lambda *of: inertia(*of).force),
        (2, given.by_acceleration, lambda *of: inertia(*of).force),
    ):
        moved = [[law(*(each + s * step * (k == which) for k, each in enumerate(state))) for s in (1, -1)] for step in steps]
        numeric = np.stack([(one - two) / 2e-6 for one, two in moved], axis=2)
        np.testing.assert_allclose(found, numeric, rtol=0, atol=2e-7 * np.abs(found).max())
    rest = inertia(free, state[1], 0 * free).force  # the power of the inertia forces is the rate of the kinetic energy
    gained = [kinetic(free + s * 1e-6 * state[1], state[1]) for s in (1, -1)]
    np.testing.assert_allclose((rest * state[1]).sum(axis=1), (gained[0] - gained[1]) / 2e-6, rtol=1e-5, atol=1e-6)


def stroke(*links, loads=()):
    press, speed = shipped(JF75G), 300 * pp.RPM
    elastic = Elastic(stiffness_of(press), flexible_links=links)
    drive = pp.drives.PrescribedSpeed(speed)
    return pp.steady_state(press, speed, drive=drive, loads=list(loads), elastic=elastic, points=121)


@pytest.mark.exhaustive
def test_stroke_with_a_rod_that_bends():
    """Energy, and how much deeper or higher the slide goes under load."""
    blanking = [pp.loads.Blanking(1.25e6, 0.010, 0.005)]
    rigid, bent = stroke(loads=blanking), stroke(main_rod(modes=1), loads=blanking)
    assert bent.stats.energy_error < 1e-9
    assert abs(bent.deepest - rigid.deepest) > 1e-5
    assert bent.peaks["P4"] != pytest.approx(rigid.peaks["P4"], rel=1e-3)


def test_kinetic_energy_of_a_rod_that_bends_is_what_the_other_links_leave():
    """Shapes have the modal mass 1 kg, so that the share of a rigid link is its own m v^2 + J w^2."""
    press = shipped(JF75G)
    modes = natural_frequencies(press, Elastic(stiffness_of(press), flexible_links=[main_rod(modes=3)]), angle=[0.3])
    left = np.ones(modes.natural_frequency.shape[1])
    for body, inertia in enumerate(list(press.model.inertias)[1:]):
        name, moved = press.link_of(body + 1), modes.shapes[0, :, body]
        if name != "main_rod":
            normal = press.engine().turning_axes(body + 1)[0]
            own = inertia.mass * (moved[:, :2] ** 2).sum(axis=1) + normal @ inertia.inertia @ normal * moved[:, 2] ** 2
            np.testing.assert_allclose(modes.kinetic_energy[name][0], own, rtol=1e-9, atol=1e-12)
            left -= own
    np.testing.assert_allclose(modes.kinetic_energy["main_rod"][0], left, rtol=1e-9, atol=1e-9)


def test_rigid_limit():
    """An idle stroke comes to that of a rigid rod in proportion to the rod's compliance."""
    rigid, *soft = stroke(), *(stroke(main_rod(area=AREA * times, second_moment=BENDING * times, modes=2)) for times in (20, 40))
    beside = [np.abs(run.bearing_force["P4"] - rigid.bearing_force["P4"]).max() / rigid.peaks["P4"] for run in soft]
    assert beside[0] / beside[1] == pytest.approx(2.0, rel=0.02)
    assert beside[1] < 1e-3


def test_free_crank():
    """Running down with a rod that bends: energy, and the held crank's forces behind a heavy flywheel."""
    press, speed = shipped(JF75G), 300 * pp.RPM
    elastic = Elastic(stiffness_of(press), flexible_links=[main_rod(modes=1, area=AREA / 10)])
    heavy_wheel, prescribed = pp.drives.Flywheel(1e9), pp.drives.PrescribedSpeed(speed)
    light: Any = pp.simulate(press, 0.05, speed=speed, flywheel=pp.drives.Flywheel(20), elastic=elastic, points=51)
    heavy: Any = pp.simulate(press, 0.05, speed=speed, flywheel=heavy_wheel, elastic=elastic, points=51)
    held: Any = pp.simulate(press, 0.05, drive=prescribed, elastic=elastic, points=51)
    assert light.stats.energy_error < 1e-10
    assert ("flexible links", "main_rod, 2 shapes") in elastic_in_words(elastic)
    np.testing.assert_allclose(heavy.bearing_force["P4"], held.bearing_force["P4"], rtol=0, atol=1e-5 * held.peaks["P4"])


def test_files(tmp_path):
    beam = main_rod(modes=2)
    np.savez(tmp_path / "rod.npz", mass=beam.mass, stiffness=beam.stiffness, nodes=beam.nodes, degrees=beam.degrees)
    found = [read_flexible_link("main_rod", tmp_path / "rod.npz", bearings={"P2": 0, "P4": 8}, modes=2)]
    for name in ("mass", "stiffness"):
        scipy.io.mmwrite(tmp_path / f"{name}.mtx", scipy.sparse.csr_array(getattr(beam, name)), precision=17)
    files = {"file": tmp_path / "mass.mtx", "stiffness": tmp_path / "stiffness.mtx"}
    given = {"bearings": {"P2": 0, "P4": 8}, "nodes": beam.nodes, "degrees": beam.degrees, "modes": 2}
    found.append(read_flexible_link("main_rod", **files, **given))
    for each in found:
        np.testing.assert_allclose(each.natural_frequency, beam.natural_frequency, rtol=1e-9)
    (tmp_path / "text.npz").write_text("no arrays")
    np.savez(tmp_path / "short.npz", mass=beam.mass)
    for name, message in (("text.npz", "no file of arrays"), ("short.npz", "lacks stiffness, nodes"), ("none.npz", "none.npz")):
        with pytest.raises(pp.PinpressError, match=message):
            read_flexible_link("main_rod", tmp_path / name, bearings={"P2": 0, "P4": 8})
    with pytest.raises(pp.PinpressError, match="no Matrix Market file"):
        read_flexible_link("main_rod", tmp_path / "text.npz", **given, stiffness=tmp_path / "stiffness.mtx")


def test_a_link_that_is_reduced_already():
    """Rows without nodes beside the displacements of the bearings, in axes of another direction and origin."""
    beam = main_rod(modes=3)
    outer, inner = [0, 1, 24, 25], [*range(2, 24), 26]
    _, vectors = scipy.linalg.eigh(beam.stiffness[np.ix_(inner, inner)], beam.mass[np.ix_(inner, inner)])
    basis = np.zeros((27, 7))
    basis[outer, range(4)] = 1.0
    basis[np.ix_(inner, range(4))] = -np.linalg.solve(beam.stiffness[np.ix_(inner, inner)], beam.stiffness[np.ix_(inner, outer)])
    basis[inner, 4:] = vectors[:, :3]
    turn = np.kron(np.eye(2), [[0.8, 0.6], [-0.6, 0.8]])
    basis[:, :4] = basis[:, :4] @ turn
    nodes = 0.5 + beam.nodes[[0, 8]] @ np.array([[0.8, 0.6], [-0.6, 0.8]])
    degrees = [[0, 0], [0, 1], [1, 0], [1, 1], [-1, -1], [-1, -1], [-1, -1]]
    reduced = basis.T @ beam.mass @ basis, basis.T @ beam.stiffness @ basis
    link = FlexibleLink("main_rod", {"P2": 0, "P4": 1}, *reduced, nodes=nodes, degrees=degrees, modes=3)
    np.testing.assert_allclose(link.natural_frequency, beam.natural_frequency, rtol=1e-8)
    press = shipped(JF75G)
    both = [Elastic(stiffness_of(press), flexible_links=[each]) for each in (beam, link)]
    one, two = (natural_frequencies(press, each, angle=[1.0]).natural_frequency for each in both)
    np.testing.assert_allclose(one, two, rtol=1e-8)


@pytest.mark.parametrize("side", [1, -1])
def test_a_beam_is_no_link_whose_centre_of_mass_lies_beside_its_line(side):
    """By more than a thousandth of its length, on either side."""
    press = shipped(JF75G)
    body = next(joint for joint in range(1, press.model.njoints) if press.link_of(joint) == "main_rod")

    def with_centre(aside):
        inertias = [each.copy() for each in press.model.inertias]
        along = inertias[body].lever / np.linalg.norm(inertias[body].lever)
        inertias[body].lever = inertias[body].lever + side * aside * LENGTH * np.cross(along, (0.0, 1.0, 0.0))
        return flexible_beam(press.with_inertias(inertias), "main_rod", ("P2", "P4"), area=AREA, second_moment=BENDING)

    assert with_centre(0.5e-3).link == "main_rod"
    with pytest.raises(pp.PinpressError, match=r"its centre of mass lies -?0\.6 mm beside its line"):
        with_centre(2e-3)
