"""Frames that bend: beams against Timoshenko's equations, the reduction against the full model, the rigid limit, balances."""

import functools

import numpy as np
import pytest
from scipy.io import mmwrite
from scipy.linalg import eigh, expm
from scipy.optimize import brentq
from scipy.sparse import csr_matrix
from support.generators.frames import FEET, PLACES, harmonic_force, members, of_beams, turns, weightless
from support.texts import shipped

import pinpress as pp
from pinpress import PinpressError, foundation
from pinpress.common.reading import matrices as matrices_of_models
from pinpress.foundation import beams, elastic_frame
from pinpress.foundation.frame_parts import rows_at
from pinpress.foundation.response import displacement_amplitudes

MOUNTS = [foundation.Mount(foot, (8e6, 8e6, 9e8), (2e4, 3e4, 4e5)) for foot in FEET.values()]


def full_model(monkeypatch, elements=3):
    """The matrices that `beam_frame` reduces, and what goes with them."""
    with monkeypatch.context() as patched:
        patched.setattr(beams, "reduced_frame", lambda mass, stiffness, **more: (mass, stiffness, more))
        return foundation.beam_frame(PLACES, members(), bed="bed", carrier="crown", elements=elements)


# --------------------------------------------------------------------------------------------------------------------------------- beams


def timoshenko(beam, length, moment, shear, count):
    """Frequencies of a free beam: roots of what its end lacks, from the equations of Timoshenko integrated along it."""
    bending, sheared = beam.modulus * moment, beam.shear_modulus * shear

    def end(w):  # w' = slope + shear force, slope' = moment, moment' = -shear force - rotary inertia, shear force' = -inertia
        a = np.zeros((4, 4))
        a[0, 1], a[0, 3] = 1.0, 1 / sheared
        a[1, 2] = 1 / bending
        a[2, 1], a[2, 3] = -beam.density * moment * w**2, -1.0
        a[3, 0] = -beam.density * beam.area * w**2
        return np.linalg.det(expm(a * length)[2:, :2] / np.array([[bending], [sheared]]))

    slender = np.pi**2 * np.sqrt(bending / (beam.density * beam.area)) / length**2
    trials = np.linspace(0.05, 8.0, 400) * slender
    values = [end(w) for w in trials]
    found = [brentq(end, *trials[k : k + 2], xtol=1e-10) for k in range(len(trials) - 1) if values[k] * values[k + 1] < 0]
    return np.array(found[:count])


def test_a_free_beam_vibrates_as_timoshenko_says():
    """A short solid beam, five heights long: bending both ways, stretching and twisting; errors fall with the square of the elements."""
    ends, length = {"a": (0.1, 0.2, 0.3), "b": (0.1, 1.2, 0.3)}, 1.0
    beam = foundation.FrameBeam("a", "b", 0.3, 0.2, (1, 1, 0))
    exact = [timoshenko(beam, length, beam.second_moments[k], beam.shear_areas[k], 2) for k in (0, 1)]
    errors = []
    for elements in (10, 20):
        found = foundation.beam_frame(ends, [beam], bed="a", carrier="b", elements=elements, modes=200).natural_frequency
        errors.append([found[np.abs(found / w - 1).argmin()] / w - 1 for w in np.ravel(exact)])
    coarse, fine = np.array(errors)
    assert ((coarse / fine > 3.5) & (coarse / fine < 4.5)).all()
    np.testing.assert_allclose((4 * fine - coarse) / 3, 0.0, atol=1e-4)
    twist = np.pi / length * np.sqrt(beam.shear_modulus * beam.torsion_constant / (beam.density * sum(beam.second_moments)))
    stretch = np.pi / length * np.sqrt(beam.modulus / beam.density)
    for w in (twist, stretch):
        assert np.abs(found / w - 1).min() < np.pi**2 / 24 / 20**2 * 1.1  # linear displacement in an element


@pytest.mark.parametrize(("along", "moment", "shear"), [((0, 0, 1), 0, 0), ((1, 0, 0), 1, 1)])
def test_a_beam_on_two_supports_sags(along, moment, shear):
    """P (L^3 / 48 E I + L / 4 G A_s) in the middle, exact for any number of elements; stretched, L / E A."""
    beam = {"width": 0.4, "height": 0.3, "wall": 0.02, "across": (1, 0, 0), "density": 1.0}
    halves = [foundation.FrameBeam(*ends, **beam) for ends in (("a", "middle"), ("middle", "b"))]
    places = {"a": (0, 0, 0), "middle": (0, 1, 0), "b": (0, 2, 0)}
    one = halves[0]
    bent = foundation.beam_frame(places, halves, bed="middle", carrier="middle", elements=1)
    compliance = 1 / bent.stiffness_between("a", "b", axis="y")
    assert compliance == pytest.approx(2.0 / (one.modulus * one.area), rel=1e-9)
    rows = [rows_at(bent.motions[name], places[name])["xyz".index("z") if along[2] else 0] for name in places]
    stretch = (rows[1] - 0.5 * (rows[0] + rows[2]))[6:]
    expected = 8.0 / (48 * one.modulus * one.second_moments[moment]) + 2.0 / (4 * one.shear_modulus * one.shear_areas[shear])
    assert ((stretch / bent.natural_frequency) ** 2).sum() == pytest.approx(expected, rel=1e-9)


def test_sections_of_boxes():
    """A solid square has 0.1406 a^4 against twisting, one twice as wide 0.229 b a^3 (Timoshenko, Theory of Elasticity, 109), either way
    round; a hollow one the moments of the outer box less those of the inner one."""
    for width, height in ((0.4, 0.2), (0.2, 0.4)):
        flat = foundation.FrameBeam("a", "b", width, height, (1, 0, 0))
        assert flat.torsion_constant == pytest.approx(0.229 * 0.4 * 0.2**3, rel=2e-3)
    solid = foundation.FrameBeam("a", "b", 0.2, 0.2, (1, 0, 0))
    assert solid.torsion_constant == pytest.approx(0.1406 * 0.2**4, rel=3e-3)
    hollow = foundation.FrameBeam("a", "b", 0.3, 0.2, (1, 0, 0), wall=0.01)
    assert hollow.area == pytest.approx(0.3 * 0.2 - 0.28 * 0.18, rel=1e-12)
    assert hollow.second_moments[0] == pytest.approx((0.3 * 0.2**3 - 0.28 * 0.18**3) / 12, rel=1e-12)
    assert hollow.torsion_constant == pytest.approx(4 * (0.29 * 0.19) ** 2 * 0.01 / (2 * (0.29 + 0.19)), rel=1e-12)


# ----------------------------------------------------------------------------------------------------------------------------- reduction


def test_reduced_frame_on_its_mounts_beside_the_full_model(monkeypatch):
    """Natural frequencies of the full matrices with the mounts' springs: from above, closer with each mode kept, all kept to rounding."""
    mass, stiffness, more = full_model(monkeypatch)
    held = stiffness.copy()
    for foot, mount in zip(FEET, MOUNTS, strict=True):
        rows = 6 * more["interfaces"][foot] + np.arange(3)
        held[rows, rows] += mount.stiffness
    full = np.sqrt(eigh(held, mass, eigvals_only=True))
    press = pp.load("crank_slide", gravity=(0, 0, 0)).with_inertias(list(weightless().model.inertias))
    off = []
    for modes in (0, 6, 30, 200):
        found = foundation.modes(foundation.mounted(press, of_beams(modes=modes), MOUNTS)).natural_frequency[:12]
        off.append(found / full[:12] - 1)
        assert (off[-1] > -1e-9).all()
    assert (off[0] >= off[1] - 1e-9).all()
    assert (off[1] >= off[2] - 1e-9).all()
    assert off[0].max() > 1e-2 > off[2].max()
    assert off[2][:6].max() < 1e-4
    np.testing.assert_allclose(off[3], 0.0, atol=1e-9)


def test_statics_of_forces_at_the_interfaces_are_exact(monkeypatch):
    """The compliance between crown and bed of the full model (least squares through its rigid motions), with no vibration kept."""
    _, stiffness, more = full_model(monkeypatch)
    force = np.zeros(len(stiffness))
    force[6 * more["interfaces"]["crown"] + 2], force[6 * more["interfaces"]["bed"] + 2] = 1.0, -1.0
    expected = 1 / (force @ np.linalg.lstsq(stiffness, force, rcond=1e-12)[0])
    for modes in (0, 20):
        assert of_beams(modes=modes).stiffness_between("crown", "bed") == pytest.approx(expected, rel=1e-7)


def lumped(mass, more):
    """The mass matrix with masses at the nodes alone, and rotary inertia at the interfaces alone."""
    degrees, along = np.asarray(more["degrees"]), np.zeros(len(mass))
    for axis in range(3):
        rows = np.flatnonzero(degrees[:, 1] == axis)
        along[rows] = mass[np.ix_(rows, rows)].sum(axis=1)
    turning = np.isin(degrees[:, 0], list(more["interfaces"].values())) & (degrees[:, 1] > 2)
    return np.diag(np.where(turning, np.diag(mass), along))


def test_lumped_masses(monkeypatch):
    """Rows without mass: frequencies on the mounts against those of the full model, statics against the consistent one's."""
    mass, stiffness, more = full_model(monkeypatch)
    at_nodes, held = lumped(mass, more), stiffness.copy()
    assert (np.diag(at_nodes) == 0).sum() > 50
    for foot, mount in zip(FEET, MOUNTS, strict=True):
        rows = 6 * more["interfaces"][foot] + np.arange(3)
        held[rows, rows] += mount.stiffness
    full = np.sort(eigh(at_nodes, held, eigvals_only=True)[-12:] ** -0.5)
    press = pp.load("crank_slide", gravity=(0, 0, 0)).with_inertias(list(weightless().model.inertias))
    system = foundation.mounted(press, foundation.reduced_frame(at_nodes, stiffness, **more | {"modes": 200}), MOUNTS)
    np.testing.assert_allclose(foundation.modes(system).natural_frequency[:12], full, rtol=1e-9)
    for kept in (0, 20):
        found = foundation.reduced_frame(at_nodes, stiffness, **more | {"modes": kept})
        assert found.stiffness_between("crown", "bed") == pytest.approx(of_beams().stiffness_between("crown", "bed"), rel=1e-7)
    bare = np.where(np.asarray(more["degrees"])[:, 1] > 2, 0.0, np.diag(at_nodes))
    with pytest.raises(PinpressError, match=r"interface '[\w ]+' along its coordinate turn about [xyz] moves no mass: give rotary inertia"):
        foundation.reduced_frame(np.diag(bare), stiffness, **more)


@pytest.mark.parametrize("kind", ["consistent", "lumped"])
def test_sparse_matrices_give_what_dense_ones_do(kind, monkeypatch):
    """With ten vibrations, which cut no group of equal legs' equal frequencies: of such a group any share would be right."""
    mass, stiffness, more = full_model(monkeypatch)
    mass = mass if kind == "consistent" else lumped(mass, more)
    dense = foundation.reduced_frame(mass, stiffness, **more | {"modes": 10})
    monkeypatch.setattr(matrices_of_models, "DENSE", 10)
    found = foundation.reduced_frame(csr_matrix(mass), csr_matrix(stiffness), **more | {"modes": 10})
    np.testing.assert_allclose(found.natural_frequency, dense.natural_frequency, rtol=1e-9)
    np.testing.assert_allclose(found.inertia, dense.inertia, rtol=1e-12, atol=1e-9)
    assert found.stiffness_between("crown", "bed") == pytest.approx(dense.stiffness_between("crown", "bed"), rel=1e-9)
    bare = foundation.reduced_frame(csr_matrix(mass), csr_matrix(stiffness), **more | {"modes": 0})
    assert bare.stiffness_between("crown", "bed") == pytest.approx(dense.stiffness_between("crown", "bed"), rel=1e-9)

    def refused(says, mass=mass, stiffness=stiffness, **other):
        with pytest.raises(PinpressError, match=says):
            foundation.reduced_frame(csr_matrix(mass), csr_matrix(stiffness), **more | other)

    odd = stiffness.copy()
    odd[40, 41] += 1e9
    refused("stiffness is not symmetric", stiffness=odd)
    refused("stiffness has entries that are no finite numbers", stiffness=np.where(np.eye(len(mass)) > 0, np.nan, stiffness))
    refused("stiffness has entries that are no finite numbers", stiffness=stiffness * (1 + 0.01j))
    refused("mass is not positive semidefinite", mass=mass - 3 * np.diag(np.diag(mass)))
    refused("resists when the frame moves as a whole", stiffness=stiffness + 1e6 * np.eye(len(mass)))
    refused("moves though all its interfaces are held", stiffness=-stiffness)
    refused("moves though all its interfaces are held", stiffness=0.0 * stiffness)
    monkeypatch.setattr(elastic_frame, "MOST_ROWS", 100)
    refused("give a square matrix of at most 100 rows; condense a larger model")


def test_units_that_are_hardly_meant(monkeypatch):
    """A model in N, mm and t is consistent in itself: its size tells, and so does its mass beside the links."""
    mass, stiffness, more = full_model(monkeypatch, elements=1)
    factor = np.where(np.asarray(more["degrees"])[:, 1] > 2, 1e3, 1.0)
    in_mm = [np.outer(factor, factor) * matrix / 1e3 for matrix in (mass, stiffness)]  # N/mm, and t as kg
    with pytest.warns(pp.PinpressWarning, match="1800 m apart: if mm are meant"):
        foundation.reduced_frame(*in_mm, **more | {"nodes": 1e3 * np.asarray(more["nodes"])})
    press = shipped("jf75g_125")
    with pytest.warns(pp.PinpressWarning, match=r"the frame weighs .* kg, the links .* kg: give its mass in kg, .*e3 if t are meant"):
        foundation.mounted(press, foundation.reduced_frame(mass / 1e3, stiffness, **more), MOUNTS)
    with pytest.warns(pp.PinpressWarning, match="the frame weighs 15 kg"):
        foundation.mounted(press, foundation.Frame(15.0, (0, 0, 0), (9, 8, 4)), MOUNTS)


def test_a_frame_is_read_as_it_is_given(monkeypatch, tmp_path):
    mass, stiffness, more = full_model(monkeypatch, elements=1)
    given = {key: more[key] for key in ("interfaces", "bed", "carrier")}
    expected = foundation.reduced_frame(mass, stiffness, **more)
    np.savez(tmp_path / "frame.npz", mass=mass, stiffness=stiffness, nodes=more["nodes"], degrees=more["degrees"])
    mmwrite(tmp_path / "mass.mtx", csr_matrix(mass))
    mmwrite(tmp_path / "stiffness.mtx", csr_matrix(stiffness))
    matrices = {"stiffness": tmp_path / "stiffness.mtx", "nodes": more["nodes"], "degrees": more["degrees"]}
    for read in (
        foundation.read_frame(tmp_path / "frame.npz", **given),
        foundation.read_frame(tmp_path / "mass.mtx", **given, **matrices),
    ):
        np.testing.assert_allclose(read.natural_frequency, expected.natural_frequency, rtol=1e-7)
        np.testing.assert_allclose(read.inertia, expected.inertia, rtol=1e-9, atol=1e-6)
    assert "crank and guides" in str(expected)
    with pytest.raises(PinpressError, match=r"stiffness.mtx holds one matrix: give the file of the stiffness matrix too"):
        foundation.read_frame(tmp_path / "stiffness.mtx", **given)
    with pytest.raises(PinpressError, match=r"none.mtx cannot be read: No such file"):
        foundation.read_frame(tmp_path / "none.mtx", **given, **matrices)


# -------------------------------------------------------------------------------------------------------------------------- the rigid limit


@pytest.mark.parametrize("guided", ["crown", "upper left"])
def test_a_stiff_frame_is_the_rigid_one(guided):
    """1e10 times as stiff as steel: the results of a rigid frame of the same inertia, to 1e-9, wherever the guide is. In time it is 1e-7:
    there vibrations 1e8 times as fast as the step go through a matrix exponential, and the sudden start makes them ring."""
    stiff, press = of_beams(stiffer=1e10, guided=guided), shipped("jf75g_125")
    centre = np.array([stiff.inertia[5, 1], stiff.inertia[3, 2], stiff.inertia[4, 0]]) / stiff.mass
    tensor = stiff.inertia[3:, 3:] - stiff.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    aside = {"attached": {"motor": foundation.Attachment(foundation.Frame(450, (0, 0.9, 0.9), (20, 10, 20)))}, "rotors": ROTORS}
    rigid = foundation.mounted(press, foundation.Frame(stiff.mass, centre, tensor), MOUNTS, **aside)
    bent = foundation.mounted(press, stiff, MOUNTS, **aside)
    np.testing.assert_allclose(bent.mount_load, rigid.mount_load, atol=1e-9 * rigid.mount_load.max())
    one, two = foundation.modes(bent), foundation.modes(rigid)
    np.testing.assert_allclose(one.natural_frequency[:6], two.natural_frequency, rtol=1e-9)
    assert one.motion[:6] == two.motion
    assert set(one.motion[6:]) == {"bending"}
    crown, top = {"top": ("crown", (0.1, 0.2, 0.9))}, {"top": (0.1, 0.2, 0.9)}
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 20.0, points=180))
    motion = pp.inverse_dynamics(press, turns(press, 20.0, 1, 180))
    for respond, given, share in ((foundation.steady_response, reactions, 1e-9), (foundation.time_response, motion, 1e-7)):
        mine, theirs = respond(bent, given, points=crown), respond(rigid, given, points=top)
        for name in ("displacement", "acceleration")[: 1 if share > 1e-9 else 2]:
            one, two = getattr(mine, name)["top"], getattr(theirs, name)["top"]
            np.testing.assert_allclose(one, two, atol=share * np.abs(two).max())
        np.testing.assert_allclose(mine.floor_force, theirs.floor_force, atol=10 * share * np.abs(theirs.floor_force).max())
    over = [foundation.over_speeds(system, [10.0, 20.0], points=there).rms["top"] for system, there in ((bent, crown), (rigid, top))]
    np.testing.assert_allclose(over[0], over[1], atol=1e-9 * over[1].max())


ROTORS = [foundation.Rotor(136, (0, -1, 0))]


# -------------------------------------------------------------------------------------------------------------------------------- balances


@functools.cache
def bent(loss_factor=0.02):
    return foundation.mounted(shipped("jf75g_125"), of_beams(loss_factor=loss_factor, guided="upper left"), MOUNTS, rotors=ROTORS)


def test_force_on_the_floor_is_what_momentum_leaves():
    """The frame's momentum is that of its mean motion, whatever bends."""
    system, press = bent(), shipped("jf75g_125")
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 20.0, points=180))
    response = foundation.steady_response(system, reactions, points={"bed": "bed"})
    spectrum = np.fft.rfft(response.coordinates, axis=0) * (1j * 20.0 * np.arange(91)[:, None]) ** 2
    momentum = np.fft.irfft(spectrum, 180, axis=0) @ system.mass @ system.rigid
    left = response.shaking_force - momentum[:, :3]
    np.testing.assert_allclose(response.floor_force, left, atol=1e-7 * np.abs(response.shaking_force).max())
    plain = np.array(reactions.shaking_force) - system.press_weight[:3]
    np.testing.assert_allclose(response.shaking_force, plain, atol=1e-9 * np.abs(plain).max())


def test_displacement_by_a_force_is_reciprocal():
    """At standstill, with loss: what a force at A along z does at B along x, the same at B along x does at A along z."""
    system = bent()
    one = rows_at(system.parts["upper left"], PLACES["upper left"])[2]
    two = rows_at(system.parts["foot 1"], FEET["foot 1"])[0]
    w = np.array([30.0, 200.0, 900.0])
    there = [displacement_amplitudes(system, w, np.broadcast_to(force.astype(complex), (3, len(force)))) for force in (one, two)]
    np.testing.assert_allclose(there[0] @ two, there[1] @ one, rtol=1e-8)
    assert np.abs(there[0] @ two).min() > 0


def test_slide_and_bed_move_apart_as_the_stiffness_says():
    """Pressed apart slowly at crown and bed, the frame opens by force / stiffness, about 0.3 mm under 1250 kN."""
    press = weightless()
    system = foundation.mounted(press, of_beams(), MOUNTS)
    force, stiffness = 1.25e6, of_beams().stiffness_between("crown", "bed")
    pair = [harmonic_force(press, -force)]
    result = pp.inverse_dynamics(press, pp.cycle(press, 0.1, points=32), loads=pair)
    wrench = (
        np.cos(result.motion.crank_angle)[:, None]
        * force
        * (rows_at(system.parts["crown"], PLACES["crown"])[2] - rows_at(system.parts["bed"], PLACES["bed"])[2])
    )
    still = np.linalg.solve(system.stiffness, wrench[0])
    opened = (rows_at(system.parts["crown"], PLACES["crown"])[2] - rows_at(system.parts["bed"], PLACES["bed"])[2]) @ still
    assert opened == pytest.approx(force / stiffness, rel=2e-3)  # the mounts resist the little that the feet turn
    on_bed = foundation.steady_response(system, result, points={"bed": PLACES["bed"], "named": "bed", "with": ("bed", PLACES["bed"])})
    for name in ("named", "with"):
        np.testing.assert_allclose(on_bed.displacement[name], on_bed.displacement["bed"], rtol=1e-9, atol=1e-15)
