"""The presses in other programs: they say what pinpress says, to what their methods allow, and converge to it with their orders."""

import csv
import importlib.util
import re
import subprocess
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from benchmarks.accuracy.contests import (
    determined_force_error,
    find_peers,
    turn_beside_peers,
)
from benchmarks.peers import pinocchio_press
from benchmarks.peers.hand_script import HandScript
from benchmarks.peers.pinocchio_press import PinocchioCpp
from benchmarks.peers.six_bar_press import reduced
from support.generators import small_linkages

import pinpress as pp
from pinpress.accuracy.scenes import DIE, FREE_RUN, SPEED_LAW, Scene, build_scene
from pinpress.accuracy.work_precision import peak_force
from pinpress.pin_table import templates
from pinpress.simulation.reduced_model import reduced_model_of

SPEED = 70 * pp.RPM  # [rad/s]
# The same equations solved otherwise, 1e-14 of the peak; where loops hold each other, by singular values, 5e-12.
EXACT = 1e-12
SHARED = 1e-10
PRESSES = ("zxn2_3000b", "crank_slide", "jf75g_125", "thin_wall")
SPATIAL = ("rssp", "bricard")
KINDS = {  # peer -> package that must be installed, our module
    "Mujoco": ("mujoco", "mujoco_press"),
    "MujocoSteps": ("mujoco", "mujoco_press"),
    "Exudyn": ("exudyn", "exudyn_press"),
    "ExudynInSpace": ("exudyn", "exudyn_in_space"),
    "Drake": ("pydrake", "drake_press"),
    "DrakeSteps": ("pydrake", "drake_press"),
}
IN_SPACE = ["Mujoco", *(["Drake"] if importlib.util.find_spec("pydrake") else [])]  # Drake is an extra of its own, which CI lacks
PUBLISHED = Path(__file__).resolve().parents[3] / "viz" / "accuracy.csv"
FLYWHEEL = 500.0  # [kg m2]
DURATION, ANGLE = 0.5, 2.0  # [s, rad]


@pytest.fixture(scope="module")
def presses():
    """A press by its name; each is made once."""
    own = {
        "rssp": lambda: pp.build(Path(templates.__file__).with_name("rssp.yaml")),
        "bricard": lambda: pp.load(Path(__file__).with_name("bricard.urdf")),
    }
    return cache(lambda name: own[name]() if name in own else pp.load(name))


@pytest.fixture(scope="module")
def made(presses):
    """A peer's class by its module and name, for a press; skips where its program is missing."""

    @cache
    def make(kind, press):
        module, ours = KINDS[kind]
        pytest.importorskip(module)
        return getattr(import_module(f"benchmarks.peers.{ours}"), kind)(presses(press))

    return make


def turn(points, speed=SPEED):
    return np.copysign(2 * np.pi, speed) * np.arange(points) / points


def errors(press, peer, points, speed=SPEED):
    """Largest errors of torque and forces, of their peaks, over a turn; of forces what mechanics determines, of Bricard's ring nothing."""
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=speed, points=points))
    answer = peer.inverse_dynamics(turn(points, speed), speed)
    assert {name: force.shape for name, force in answer.force.items()} == dict.fromkeys(press.bearings, (points, 3))
    torque = np.abs(answer.torque - result.driving_torque).max() / np.abs(result.driving_torque).max()
    return torque, determined_force_error(answer.force, result, peak_force(result.bearing_force))


# ------------------------------------------------------------------------------------------------------------------------ inverse dynamics


@pytest.mark.parametrize("speed", [30.0, -4.0])
@pytest.mark.parametrize("name", ["zxn2_3000b", "zxn2_3000b_balanced", *SPATIAL])
def test_the_hand_scripts(presses, name, speed):
    assert max(errors(presses(name), HandScript(presses(name)), 36, speed)) < EXACT


@pytest.mark.parametrize("name", SPATIAL)
def test_only_forces_that_mechanics_determines_are_judged(presses, name):
    """All of the template's, none of Bricard's linkage; the torque of both."""
    contest = turn_beside_peers(presses(name), 30.0, 12, [HandScript(presses(name))])
    *engines, script = contest.contestants
    assert [entry.method for entry in engines] == ["space", "pinocchio"]
    found = script.errors(script.work())
    assert found.error < EXACT
    assert found.force_error is None if name == "bricard" else found.force_error < EXACT
    assert script.method == "hand script"


@pytest.mark.parametrize("name", SPATIAL)
@pytest.mark.parametrize("kind", IN_SPACE)
def test_programs_in_space(presses, made, kind, name):
    """A cross without mass, and a ring of pins whose loop says two things twice."""
    assert max(errors(presses(name), made(kind, name), 36)) < EXACT


@pytest.mark.parametrize("speed", [7.0, -5.0])
def test_exudyn_in_space(presses, made, speed):
    """The trapezoidal rule, as in the plane, for torque and all forces; the cross without mass is a joint."""
    press, peer = presses("rssp"), made("ExudynInSpace", "rssp")
    coarse, fine = (np.array(errors(press, peer, points, speed)) for points in (360, 720))
    assert (coarse < 6e-3).all()
    assert (coarse / fine > 3.5).all()
    assert (coarse / fine < 4.5).all()
    with pytest.raises(pp.PinpressError, match="loops of bricard hold each other"):
        made("ExudynInSpace", "bricard")
    with pytest.raises(pp.PinpressError, match="equal steps"):
        peer.inverse_dynamics(np.zeros(3), speed)


def compilable():
    try:
        return bool(pinocchio_press._command())
    except pp.PinpressError:
        return False


if compilable():

    @pytest.mark.exhaustive
    def test_pinocchio_in_cpp(presses):
        """Compiled here, which takes half a minute where the cache does not have it; the second model finds it there."""
        for name in ("zxn2_3000b", "jf75g_125", *SPATIAL):
            peer = PinocchioCpp(presses(name))
            assert max(errors(presses(name), peer, 90)) < SHARED
        assert max(errors(presses("zxn2_3000b"), PinocchioCpp(presses("zxn2_3000b")), 360, -SPEED)) < EXACT
        with pytest.raises(pp.SimulationError, match="does not close the loops"):
            peer.inverse_dynamics(np.array([0.0, 1.7, np.nan]), SPEED)


def test_what_is_not_compared_in_a_loop(presses):
    with pytest.raises(pp.PinpressError, match="gear pairs"):
        PinocchioCpp(presses("jf75g_125_symmetric"))
    with pytest.raises(pp.PinpressError, match="on one driver"):
        PinocchioCpp(small_linkages.two_cranks())


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
@pytest.mark.parametrize("name", PRESSES)
def test_mujoco(presses, made, name, speed):
    """With the loops' exact equations it errs by rounding alone, signs and all."""
    assert max(errors(presses(name), made("Mujoco", name), 90, speed)) < EXACT


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["jf75g_125_symmetric", "jf75g_125_two_point"])
def test_mujoco_where_loops_hold_each_other(presses, made, name):
    """The torque, and what the frame takes in all: how its bearings share it, rigid mechanics leaves open. Gear pairs too."""
    press, peer = presses(name), made("Mujoco", name)
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=90))
    answer = peer.inverse_dynamics(turn(90), SPEED)
    assert np.abs(answer.torque - result.driving_torque).max() < SHARED * np.abs(result.driving_torque).max()
    on_frame = [bearing for j, bearing in enumerate(press.joints) if press.model.parents[j + 1] == 0]
    found, expected = (sum(force[bearing] for bearing in on_frame) for force in (answer.force, result.bearing_force))
    assert np.abs(found - expected).max() < SHARED * np.abs(expected).max()


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
@pytest.mark.parametrize("name", PRESSES)
def test_exudyn(presses, made, name, speed):
    """The trapezoidal rule: a quarter of the error with twice the angles; 1e-4 of the peak with 360, less where the motion is smoother."""
    press, peer = presses(name), made("Exudyn", name)
    coarse, fine = (np.array(errors(press, peer, points, speed)) for points in (360, 720))
    assert (coarse < 2e-4).all()
    assert (coarse / fine > 3.5).all()
    assert (coarse / fine < 4.5).all()


def test_exudyn_refuses_angles_that_are_no_run(made):
    peer = made("Exudyn", "crank_slide")
    for angles in ([0.0, 0.1, 0.3], [0.0], [0.0, -0.1, -0.2]):
        with pytest.raises(pp.PinpressError, match="equal steps that go with the speed"):
            peer.inverse_dynamics(np.array(angles), SPEED)


@pytest.mark.parametrize("name", ["zxn2_3000b", "zxn2_3000b_balanced"])
def test_the_equation_in_closed_form(presses, name):
    """Against the inertia, the weight's moment and the slide of the press's own table, which is resolved to 1e-11 of each."""
    table = reduced_model_of(presses(name))
    angles = np.random.default_rng(3).uniform(0, 2 * np.pi, 40)
    values, slopes = table.at(angles)
    own = np.array([values[0], slopes[0], values[2], values[3], slopes[3]])
    found = np.array([reduced(angle, name.endswith("balanced")) for angle in angles.tolist()]).T
    assert (np.abs(found - own).max(axis=1) < 1e-11 * np.abs(own).max(axis=1)).all()


# ------------------------------------------------------------------------------------------------------------------------------- free runs


def free_run(angle, speed, inertia, duration):
    return Scene(FREE_RUN, "", 2 * np.pi / abs(speed), duration, angle, speed, pp.drives.Flywheel(inertia))


def ends(press, peer, steps, angle=ANGLE, speed=SPEED):
    """Errors (steps,) of the crank angle and of forces relative to their largest, and the ends."""
    run = pp.simulate(press, DURATION, speed=speed, angle=angle, flywheel=pp.drives.Flywheel(FLYWHEEL), tolerance=1e-13)
    last = pp.inverse_dynamics(press, run).bearing_force
    peak = max(np.abs(force[-1]).max() for force in last.values())
    found = [peer.prepared(free_run(angle, speed, FLYWHEEL, DURATION))(step) for step in steps]
    angles = np.array([abs(end.crank_angle - run.crank_angle[-1]) for end in found])
    forces = np.array([max(np.abs(end.force[name] - last[name][-1]).max() for name in press.bearings) for end in found])
    assert all(set(end.force) == set(press.bearings) for end in found)
    speeds = np.array([abs(end.crank_speed - run.crank_speed[-1]) for end in found])
    return angles, speeds, forces / peak, found


def order(errors):
    """Of convergence, from errors at steps that are halved."""
    return float(np.log2(errors[0] / errors[-1]) / (len(errors) - 1))


@pytest.mark.parametrize("name", PRESSES)
def test_free_run_by_mujocos_terms(presses, made, name):
    """Classical Runge-Kutta: fourth order; on the loops to rounding after every step."""
    angles, speeds, forces, found = ends(presses(name), made("Mujoco", name), [0.01, 0.005, 0.0025])
    for errors in (angles, speeds, forces):
        assert 3.3 < order(errors) < 5.5
    assert angles[-1] < 1e-7
    assert max(end.loop_gap for end in found) < 1e-14
    assert order([abs(end.energy_error) for end in found]) > 3


@pytest.mark.parametrize("name", ["zxn2_3000b", "crank_slide"])
def test_free_run_by_mujocos_own_steps(presses, made, name):
    """Loops as stiff as 1 / step^2 allows: second order of angle and gap, whatever the integrator's."""
    angles, _, forces, found = ends(presses(name), made("MujocoSteps", name), [0.001, 0.0005, 0.00025])
    assert 1.7 < order(angles) < 2.3
    assert angles[-1] < 1e-5
    assert 1.7 < order([end.loop_gap for end in found]) < 2.3
    assert (forces < 1e-3).all()


@pytest.mark.parametrize("name", PRESSES)
def test_free_run_by_exudyn(presses, made, name):
    """The trapezoidal rule: second order in everything, the gap too, as it keeps the rates of the loops."""
    angles, speeds, forces, found = ends(presses(name), made("Exudyn", name), [0.002, 0.001, 0.0005])
    for errors in (angles, speeds, [end.loop_gap for end in found], [abs(end.energy_error) for end in found]):
        assert 1.7 < order(errors) < 2.5
    assert angles[-1] < 2e-5
    assert (forces < 1e-3).all()


if "Drake" in IN_SPACE:

    def test_free_run_by_drakes_steps(presses, made):
        """First order of angle and forces; the gap is of the second."""
        angles, _, forces, found = ends(presses("zxn2_3000b"), made("DrakeSteps", "zxn2_3000b"), [0.002, 0.001, 0.0005])
        assert 0.9 < order(angles) < 1.2
        assert 0.9 < order(forces) < 1.2
        assert 1.8 < order([end.loop_gap for end in found]) < 2.2
        assert 0.9 < order([abs(end.energy_error) for end in found]) < 1.2


@pytest.mark.parametrize("kind", ["Mujoco", "Exudyn"])
def test_free_run_backwards(presses, made, kind):
    step = 0.005 if kind == "Mujoco" else 0.0005
    angles, _, forces, _ = ends(presses("zxn2_3000b"), made(kind, "zxn2_3000b"), [step], angle=-1.0, speed=-SPEED)
    assert angles[0] < 1e-5
    assert forces[0] < 1e-4


@pytest.mark.parametrize(("kind", "step"), [("Mujoco", 0.25), ("MujocoSteps", 0.05), ("Exudyn", 0.25)])
def test_a_step_too_long_is_said_or_seen(presses, made, kind, step, capfd, tmp_path, monkeypatch):
    """Either no end is found, or one that is finite; nothing is printed and no file is written."""
    monkeypatch.chdir(tmp_path)
    try:
        end = made(kind, "zxn2_3000b").prepared(free_run(ANGLE, SPEED, FLYWHEEL, DURATION))(step)
    except pp.SimulationError:
        pass
    else:
        assert np.isfinite([end.crank_angle, end.crank_speed, end.loop_gap, end.energy_error]).all()
    made(kind, "zxn2_3000b").inverse_dynamics(turn(10), SPEED)
    assert capfd.readouterr().out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("kind", "group", "coarse", "bounds"),
    [  # of angle [rad] and forces (of their peak) at a quarter of the step
        ("Mujoco", DIE, 4e-3, (1e-5, 1e-5)),
        ("Exudyn", DIE, 2e-3, (2e-5, 1e-5)),
        ("Exudyn", SPEED_LAW, 4e-3, (1e-4, 1e-4)),
    ],
)
def test_at_work(presses, made, kind, group, coarse, bounds):
    """Under a motor and against a die, or under a stiff law; steps that run over the edges of a load lose their order there."""
    press, peer = presses("zxn2_3000b"), made(kind, "zxn2_3000b")
    scene = build_scene(press, group, SPEED, 1360.0, 1.0)
    run = pp.simulate(press, 1.0, speed=scene.speed, angle=scene.angle, drive=scene.drive, flywheel=scene.flywheel, loads=scene.loads)
    reactions = pp.inverse_dynamics(press, run)
    peak = max(np.linalg.norm(force[1:], axis=1).max() for force in reactions.bearing_force.values())
    errors = []
    for step in (coarse, coarse / 4):
        end = peer.prepared(scene)(step)
        forces = max(np.abs(end.force[name] - reactions.bearing_force[name][-1]).max() for name in press.bearings)
        errors.append((abs(end.crank_angle - run.crank_angle[-1]), forces / peak))
    assert all(fine < bound for fine, bound in zip(errors[1], bounds, strict=True))
    assert all(fine < rough / 2 for rough, fine in zip(*errors, strict=True))


def program(name):
    """A method's name without the version of its program, which may be another one here."""
    return re.sub(r" [0-9.]+\b", "", name)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("kind", "step"), [("Mujoco", "5 ms"), ("MujocoSteps", "1 ms"), ("Exudyn", "1 ms")])
def test_the_published_errors_are_still_so(presses, made, kind, step):
    """Those of `viz/accuracy.csv`, of which tables and picture of docs/accuracy.md are made, within a factor of three."""
    press, peer = presses("zxn2_3000b"), made(kind, "zxn2_3000b")
    with open(PUBLISHED, newline="", encoding="utf-8") as file:
        rows = {(program(row["method"]), row["setting"]): row for row in csv.DictReader(file) if row["group"] == "free run"}
    row = rows[program(peer.name), f"step {step}"]
    inertia = 4 * float(reduced_model_of(press).at(reduced_model_of(press).borders)[0][0].max())
    duration = 4 * np.pi / SPEED
    truth = pp.simulate(press, duration, speed=SPEED, flywheel=pp.drives.Flywheel(inertia), tolerance=1e-13, points=2)
    end = peer.prepared(free_run(0.0, SPEED, inertia, duration))(float(row["number"]))
    assert 1 / 3 < abs(end.crank_angle - truth.crank_angle[-1]) / float(row["error"]) < 3


def test_mujoco_fails_in_silence(made, capfd, tmp_path, monkeypatch):
    """Where its own steps do not hold together it is an error, and MuJoCo neither prints nor writes its log."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(pp.SimulationError, match="shorter step"):
        made("MujocoSteps", "crank_slide").prepared(free_run(0.0, 20_000 * pp.RPM, 1.0, 0.1))(2e-3)
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []


# -------------------------------------------------------------------------------------------------------------------------------- find


@pytest.fixture
def no_compiler(monkeypatch):
    """Compiling takes longer than all other tests here."""

    def refused():
        raise pp.PinpressError("no compiler today")

    monkeypatch.setattr(pinocchio_press, "_library", refused)


@pytest.mark.usefixtures("no_compiler")
def test_all_peers_of_the_six_bar(presses):
    pytest.importorskip("mujoco")
    pytest.importorskip("exudyn")
    found, skipped = find_peers(presses("zxn2_3000b"))
    drake = ["Drake", "Drake"] if "Drake" in IN_SPACE else []
    assert [peer.name.split()[0] for peer in found] == ["hand", "MuJoCo", "MuJoCo", "Exudyn", *drake, "SciPy", "SciPy", "SciPy"]
    assert [peer.name for peer in found if not peer.inverse and peer.steps] == [
        peer.name for peer in found if peer.name.endswith(("_step", "SAP"))
    ]
    assert skipped[0] == "Pinocchio in C++ is skipped: no compiler today"
    missing = [] if drake else ["Drake", "Drake's steps"]
    assert skipped[1:] == [f"{name} is skipped: not installed; pip install 'pinpress[drake]'" for name in missing]
    assert all(peer.cannot for peer in found if peer.steps)
    for peer in found:
        assert list(peer.steps) == sorted(peer.steps, reverse=True)


@pytest.mark.usefixtures("no_compiler")
@pytest.mark.parametrize(("module", "name"), [("mujoco", "MuJoCo"), ("exudyn", "Exudyn")])
def test_a_missing_program_is_skipped(presses, monkeypatch, module, name):
    monkeypatch.setitem(sys.modules, module, None)
    found, skipped = find_peers(presses("zxn2_3000b"))
    assert f"{name} is skipped: not installed; pip install 'pinpress[peers]'" in skipped
    assert not any(peer.name.startswith(name) for peer in found)


@pytest.mark.exhaustive
@pytest.mark.usefixtures("no_compiler")
def test_the_script_is_for_its_press(presses):
    line = "hand script is skipped: it is for zxn2_3000b, zxn2_3000b_balanced, rssp and bricard alone"
    assert line in find_peers(presses("crank_slide"))[1]


@pytest.mark.exhaustive
@pytest.mark.usefixtures("no_compiler")
def test_what_exudyn_is_not_compared_on(presses):
    pytest.importorskip("exudyn")
    assert any("Exudyn is skipped: jf75g_125_symmetric has gear pairs" in line for line in find_peers(presses("jf75g_125_symmetric"))[1])
    assert any("Exudyn is skipped: loops of" in line for line in find_peers(presses("jf75g_125_two_point"))[1])


@pytest.mark.exhaustive
def test_nothing_is_imported_before():
    code = "import sys, benchmarks.accuracy.contests; sys.exit(any(name in sys.modules for name in ('mujoco', 'exudyn', 'pydrake')))"
    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=Path(__file__).parents[2]).returncode == 0
