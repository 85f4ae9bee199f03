"""A press as C, as an FMU and as MATLAB: compiled, run and compared with the engine and with `simulate`."""

import ctypes
import re
import shutil
import subprocess
import zipfile
from functools import cache
from typing import Any

import fmpy
import fmpy.validation
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave
from scipy.integrate import solve_ivp
from support import texts
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.cli.main import main
from pinpress.export.c_source import identifiers
from pinpress.pin_table.templates import TEMPLATES, template

STRICT = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"]
WITHOUT_LOSS = sorted({*pp.presses(), *TEMPLATES} - {"hypocycloid", "screw"})
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc (Debian: gcc) is not installed")
needs_octave = pytest.mark.skipif(shutil.which("octave-cli") is None, reason="Octave (Debian: octave) is not installed")


def press_named(name):
    return texts.shipped(name) if name in pp.presses() else pp.build(texts.file(template(name).decode(), "press.yaml"))


@cache
def table_of(name, **options):
    return pp.export.tabulate(press_named(name), **options)


def states_of(table, count=50):
    rng, (low, high) = np.random.default_rng(4), table.functions.borders[[0, -1]]
    angle = rng.uniform(low, high, count) + (table.functions.period or 0.0) * rng.integers(-3, 4, count)
    return angle, rng.uniform(-2, 2, count), rng.uniform(-9, 9, count), rng.uniform(-1e5, 1e5, count)


def close(found, table, states, share):
    """Outputs (n, k) against the table, which its own tests compare with the engine."""
    wanted = table.at(*states[:3], force=states[3]).values[:-1].T
    return (
        np.abs(np.asarray(found) - wanted).max() <= share * np.abs(wanted).max()
        and (np.abs(found - wanted).max(axis=0) <= share * np.abs(wanted).max(axis=0) + 1e-300).all()
    )


def compiled(folder, *options, source="press.c", target="press.so"):
    done = subprocess.run(["gcc", *STRICT, *options, source, "-o", target], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / target


# ------------------------------------------------------------------------------------------------------------------------------- C


@needs_gcc
@pytest.mark.parametrize("name", rest_exhaustive(WITHOUT_LOSS, "zxn2_3000b", "toggle"))
def test_compiled_c_is_the_engine(name, tmp_path):
    """To 1e-12 of the largest value of each quantity; a force or moment far below the largest one by a thousandth of that one."""
    table, press = table_of(name, tolerance=1e-12), press_named(name)
    source, header = pp.export.c_code(table, tmp_path / "press.c")
    assert (source.name, header.name) == ("press.c", "press.h")
    doubles = ctypes.POINTER(ctypes.c_double)
    call = ctypes.CDLL(str(compiled(tmp_path, "-O3", "-shared", "-fPIC"))).press_all
    call.argtypes = [ctypes.c_double] * 3 + [doubles] * 2
    states, found = states_of(table), []
    for angle, speed, acceleration, force in zip(*states, strict=True):
        outputs = (ctypes.c_double * len(table.components))()
        assert call(angle, speed, acceleration, (ctypes.c_double * 1)(force), outputs) == 0
        found.append(list(outputs))
    motion = pp.servo_cycle(press, states[0], speed=states[1], acceleration=states[2])
    push = pp.loads.PointForce(press.slide, np.multiply.outer(states[3], press.slide_direction), tuple(press.tool.point))
    engine, free = pp.inverse_dynamics(press, motion, [push]), pp.inverse_dynamics(press, motion)
    forces, moments = engine.bearing_force, engine.bearing_moment
    largest = max(np.abs(force).max() for force in forces.values())
    arm = largest * (press.size if table.coordinate.turns else 1.0)
    wanted = {name: (getattr(motion, name), 0.0) for name in ("slide_position", "slide_velocity", "slide_acceleration")}
    wanted |= {"driving_torque": (engine.driving_torque, arm)}
    wanted |= {"shaking_force": (free.shaking_force, largest), "shaking_moment": (free.shaking_moment, arm)}
    wanted |= {f"force_{name}": (force, largest) for name, force in forces.items()}
    wanted |= {f"moment_{name}": (moment, arm) for name, moment in moments.items()}
    columns = dict(zip(table.components, np.transpose(found), strict=True))
    for quantity in table.quantities:
        theirs, of_its_kind = wanted[quantity.name]
        ours = np.transpose([columns.get(component, np.zeros(len(found))) for component in quantity.components])
        faint = 1e-3 if table.largest[quantity.name] else 1.0  # what is zero has the rounding error of the largest force
        allowed = 1e-12 * max(np.abs(theirs).max(), faint * of_its_kind)
        assert np.abs(ours - np.reshape(theirs, ours.shape)).max() <= allowed, quantity.name


@needs_gcc
@pytest.mark.parametrize(("name", "single"), [("crank_slide", True), ("toggle", False), ("jf75g_125_plain", True)])
def test_the_self_test_and_the_sanitizers(name, single, tmp_path):
    pp.export.c_code(table_of(name), tmp_path / "press.c", single=single)
    program = compiled(tmp_path, "-O1", "-fsanitize=address,undefined", "-DPRESS_SELF_TEST", target="test")
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("press: passed, largest error ")
    source = tmp_path / "press.c"
    # the self test fails where the first number of every panel, of the torque, is 1 kN m too large
    wrong_number = re.compile(r"(?<=    \{\n        \{\n            )[^f,]+")
    text, count = wrong_number.subn(lambda number: f"{float(number[0]) + 1e3!r}", source.read_text())
    assert count == len(table_of(name).functions.borders) - 1
    source.write_text(text)
    program = compiled(tmp_path, "-DPRESS_SELF_TEST", target="test")
    wrong = subprocess.run([program], capture_output=True, text=True, check=False)
    assert (wrong.returncode, "FAILED" in wrong.stdout) == (1, True)


@needs_gcc
def test_outside_the_range_is_no_number(tmp_path):
    table = table_of("toggle")
    pp.export.c_code(table, tmp_path / "press.c")
    library = ctypes.CDLL(str(compiled(tmp_path, "-shared", "-fPIC")))
    outputs, inputs, result = (ctypes.c_double * len(table.components))(), (ctypes.c_double * 1)(), ctypes.c_double()
    number = ctypes.c_double
    assert library.press_all(number(1e3), number(0), number(0), inputs, outputs) == 1
    assert np.isnan(list(outputs)).all()
    assert library.press_acceleration(number(float("nan")), number(0), number(0), inputs, number(0), ctypes.byref(result)) == 1
    assert np.isnan(result.value)


@needs_gcc
def test_an_inertia_that_is_not_positive_has_no_acceleration(tmp_path):
    table = table_of("crank_slide")
    pp.export.c_code(table, tmp_path / "press.c")
    library, number, result = ctypes.CDLL(str(compiled(tmp_path, "-shared", "-fPIC"))), ctypes.c_double, ctypes.c_double()
    inputs = (ctypes.c_double * 1)()
    for added, code in ((5.0, 0), (-1e6, 1), (float("nan"), 1)):
        assert library.press_acceleration(number(1.0), number(2.0), number(30.0), inputs, number(added), ctypes.byref(result)) == code
        assert np.isnan(result.value) == bool(code)
        if code:
            with pytest.raises(pp.PinpressError, match="crank_slide has no acceleration at"):
                table.acceleration(1.0, 2.0, 30.0, added_inertia=added)
        else:
            assert result.value == pytest.approx(table.acceleration(1.0, 2.0, 30.0, added_inertia=added), rel=1e-12)


# ------------------------------------------------------------------------------------------------------------------------------ FMU


@pytest.fixture(scope="module")
def six_bar(tmp_path_factory):
    """The six-bar as an FMU, unzipped, with its description."""
    path = pp.export.fmu(table_of("zxn2_3000b"), tmp_path_factory.mktemp("fmu") / "six bar.fmu")
    return path, fmpy.extract(str(path)), fmpy.read_model_description(str(path))


@needs_gcc
@pytest.mark.parametrize("name", rest_exhaustive(["zxn2_3000b", "rssp", "toggle"], "toggle"))
def test_an_fmu_is_valid_and_its_sources_compile_without_a_warning(name, tmp_path):
    path = pp.export.fmu(table_of(name), tmp_path / "press.fmu")
    assert fmpy.validation.validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as packed:
        packed.extractall(tmp_path)
        assert [each for each in packed.namelist() if each.startswith("binaries/")] == ["binaries/linux64/press.so"]
    for source in ("fmu.c", "press.c"):
        compiled(tmp_path / "sources", "-c", source=source, target="part.o")
    first = path.read_bytes()
    assert pp.export.fmu(table_of(name), tmp_path / "press.fmu").read_bytes() == first


def references(description):
    return {each.name: each.valueReference for each in description.modelVariables}


@needs_gcc
def test_dependencies_have_no_algebraic_loop(six_bar):
    """What depends on the states alone does not depend on the inputs: a process law outside needs the slide's position."""
    _, _, description = six_bar
    names = {each.variable.name: {variable.name for variable in each.dependencies} for each in description.outputs}
    assert names["slide_position"] == {"angle"}
    assert names["slide_velocity"] == {"angle", "speed"}
    assert names["acceleration"] == {"angle", "speed", "torque", "force"} == names["force_A_x"]


@needs_gcc
def test_model_exchange_under_motor_flywheel_and_blanking(six_bar):
    """Three seconds by SciPy on the FMU's derivatives, stopped where the blank begins and breaks, against `simulate`."""
    press, blank, wheel = texts.shipped("zxn2_3000b"), pp.loads.Blanking(1e6, 0.006, 0.002), pp.drives.Flywheel(6000.0)
    drive = pp.drives.Geared(pp.drives.InductionMotor(75e3, 1470 * pp.RPM, 50.0, 4, 2.5, 0.0), 20.0)
    run = pp.simulate(press, 3.0, speed=7.0, drive=drive, flywheel=wheel, loads=[blank], tolerance=1e-11)
    _, folder, description = six_bar
    at = references(description)
    model = FMU2Model(
        guid=description.guid, unzipDirectory=folder, modelIdentifier=description.modelExchange.modelIdentifier, instanceName="press"
    )
    model.instantiate()
    model.setupExperiment(startTime=0.0)
    model.enterInitializationMode()
    model.setReal([at["angle"], at["speed"], at["added_inertia"]], [run.crank_angle[0], run.crank_speed[0], 6000.0])
    model.exitInitializationMode()
    model.enterContinuousTimeMode()
    bottom = press_bottom(press)
    states, slope = np.zeros(2), np.zeros(2)
    pointers = [ctypes.cast(each.ctypes.data, ctypes.POINTER(ctypes.c_double)) for each in (states, slope)]

    def put(state):
        states[:] = state
        model.fmi2SetContinuousStates(model.component, pointers[0], 2)

    def height(time, state):
        put(state)
        return model.getReal([at["slide_position"]])[0] - bottom

    def slopes(time, state, acting):
        h = height(time, state)
        force = 1e6 * np.sin(0.5 * np.pi * (0.006 - h) / 0.004) if acting else 0.0
        model.setReal([at["torque"], at["force"]], [float(drive.torque(state[1])), force])
        model.fmi2GetDerivatives(model.component, pointers[1], 2)
        return slope.copy()

    def passes(level: float) -> Any:
        def event(time, state, acting):
            return height(time, state) - level

        vars(event).update(terminal=True, direction=-1)
        return event

    time, state, acting = 0.0, np.array([run.crank_angle[0], run.crank_speed[0]]), False
    while time < 3.0:
        level = passes(0.002 if acting else 0.006)
        leg = solve_ivp(slopes, (time, 3.0), state, method="DOP853", rtol=1e-12, atol=1e-12, events=level, args=(acting,))
        time, state, acting = leg.t[-1], leg.y[:, -1], not acting
    assert state == pytest.approx([run.crank_angle[-1], run.crank_speed[-1]], abs=1e-9)
    model.terminate()
    model.freeInstance()


def press_bottom(press):
    return pp.dead_centres(press).bottom_position


def slave(six_bar):
    _, folder, description = six_bar
    found = FMU2Slave(
        guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier, instanceName="press"
    )
    found.instantiate()
    return found, references(description)


@needs_gcc
@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_co_simulation_is_the_run_of_simulate(six_bar, step):
    press = texts.shipped("zxn2_3000b")
    wheel, torque = pp.drives.Flywheel(500.0), pp.drives.ConstantTorque(2000.0)
    run = pp.simulate(press, 1.0, angle=0.3, speed=2.0, drive=torque, flywheel=wheel, tolerance=1e-12)
    press, at = slave(six_bar)
    press.setupExperiment(startTime=0.0)
    press.enterInitializationMode()
    press.setReal([at["angle"], at["speed"], at["torque"], at["added_inertia"]], [0.3, 2.0, 2000.0, 500.0])
    press.exitInitializationMode()
    steps = round(1 / step)
    for k in range(steps):
        press.doStep(currentCommunicationPoint=k / steps, communicationStepSize=1 / steps)
        if k == steps // 2:  # a step that is taken back leaves no trace
            kept = press.getFMUState()
            press.doStep(currentCommunicationPoint=(k + 1) / steps, communicationStepSize=0.3)
            press.setFMUState(kept)
            press.freeFMUState(kept)
    found = press.getReal([at["angle"], at["speed"], at["driving_torque"]])
    assert found[:2] == pytest.approx([run.crank_angle[-1], run.crank_speed[-1]], abs=1e-10)
    taken = 2000.0 - 500.0 * run.crank_acceleration[-1]
    assert found[2] == pytest.approx(taken, rel=1e-8)
    press.terminate()
    press.freeInstance()


@needs_gcc
def test_fmpy_runs_it_as_any_tool_would(six_bar):
    path, _, _ = six_bar
    result = fmpy.simulate_fmu(
        str(path), stop_time=0.5, start_values={"angle": 0.3, "speed": 2.0, "torque": 2000.0, "added_inertia": 500.0}, output_interval=0.01
    )
    wheel, torque = pp.drives.Flywheel(500.0), pp.drives.ConstantTorque(2000.0)
    run = pp.simulate(texts.shipped("zxn2_3000b"), 0.5, angle=0.3, speed=2.0, drive=torque, flywheel=wheel, tolerance=1e-12)
    assert result["angle"][-1] == pytest.approx(run.crank_angle[-1], abs=1e-9)


@needs_gcc
def test_an_fmu_says_what_is_wrong(tmp_path):
    path = pp.export.fmu(table_of("toggle"), tmp_path / "press.fmu")
    description, folder = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    press = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier="press", instanceName="mine")

    press.instantiate(callbacks=None)
    press.setupExperiment(startTime=0.0)
    press.enterInitializationMode()
    at = references(description)
    for name, value in (("speed", float("nan")), ("added_inertia", -1.0), ("tolerance", 1.0), ("acceleration", 1.0)):
        with pytest.raises(FMICallException):
            press.setReal([at[name]], [value])
    press.setReal([at["position"]], [1e3])
    with pytest.raises(FMICallException):
        press.exitInitializationMode()
    press.freeInstance()


# --------------------------------------------------------------------------------------------------------------------------- MATLAB


@needs_octave
@pytest.mark.parametrize("name", ["zxn2_3000b", "toggle"])
def test_octave_computes_the_same(name, tmp_path):
    table = table_of(name)
    pp.export.matlab(table, tmp_path / "press.m")
    states = states_of(table, 12)
    np.savetxt(tmp_path / "states.txt", np.transpose(states), fmt="%.17g")
    program = "s = load('states.txt'); for k = 1:rows(s), printf('%.17g ', press(s(k,1), s(k,2), s(k,3), s(k,4))); printf('\\n'); end"
    program += "; printf('%g ', press(NaN, 0, 0, 0)); printf('\\n');"
    done = subprocess.run(["octave-cli", "--quiet", "--eval", program], cwd=tmp_path, capture_output=True, text=True, check=True)
    *lines, last = done.stdout.strip().splitlines()
    assert close([[float(number) for number in line.split()] for line in lines], table, states, 1e-13)
    assert set(last.split()) == {"NaN"}


# ------------------------------------------------------------------------------------------------------------------------- mistakes

REFUSED = [
    (lambda folder: pp.export.c_code(table_of("crank_slide"), folder / "press.cpp"), "give a name of letters and digits that ends in .c"),
    (lambda folder: pp.export.c_code(table_of("crank_slide"), folder / "my press.c"), "ends in .c"),
    (lambda folder: pp.export.matlab(table_of("crank_slide"), folder / "1.m"), "ends in .m"),
    (lambda folder: pp.export.fmu(table_of("crank_slide"), folder / "press.zip"), "give a name that ends in .fmu"),
    (lambda folder: pp.export.fmu(table_of("crank_slide"), folder / "p.fmu", platform="amiga"), "platform is 'amiga': give linux32"),
    (lambda folder: pp.export.fmu(table_of("crank_slide"), folder / "p.fmu", compiler="gcc -no-such"), "gcc could not compile the FMU"),
    (lambda folder: pp.export.fmu(table_of("crank_slide"), folder / "no" / "p.fmu"), "cannot write"),
]


@needs_gcc
@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_what_cannot_be_written_is_refused(call, message, tmp_path):
    with pytest.raises(pp.PinpressError, match=message):
        call(tmp_path)


def test_without_a_compiler_it_has_sources_and_says_so(tmp_path):
    with pytest.warns(pp.PinpressWarning, match="there is no compiler 'no-such-cc', so that press.fmu has sources alone"):
        path = pp.export.fmu(table_of("crank_slide"), tmp_path / "press.fmu", compiler="no-such-cc")
    with zipfile.ZipFile(path) as packed:
        assert sorted(packed.namelist()) == ["modelDescription.xml", "sources/fmu.c", "sources/press.c", "sources/press.h"]


def test_names_that_c_forbids_or_that_fall_together():
    assert identifiers(["a b", "a-b", "A_b", "ü"]) == ("a_b", "a_b_2", "A_b_3", "_")


# -------------------------------------------------------------------------------------------------------------------------- command


def test_the_command_exports_a_job(tmp_path, monkeypatch, capsys):
    """Springs of the job are in the table; its process load is left outside, and said."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "press.yaml").write_text(
        "file: crank_slide\nloads:\n  draw: {kind: drawing, force: 100 kN, start: 30 mm}\n"
        "  lift: {kind: point-force, link: slide, force: [0 kN, 0 kN, 3 kN]}\n"
    )
    assert main(["export", "press.yaml", "--to", "m", "--bearing", "P"]) == 0
    said = capsys.readouterr().out
    assert "PressTable of crank_slide: 1 bearing" in said
    assert "left outside, as forces that the program gives: draw" in said
    assert "wrote press.m (" in said
    press = texts.shipped("crank_slide")
    lifted = pp.export.tabulate(press, ["P"], [pp.loads.PointForce("slide", (0.0, 0.0, 3e3))])
    pp.export.matlab(lifted, "again.m")
    written = [re.search(r"table\(:, :, 1\).*", (tmp_path / name).read_text(), re.DOTALL)[0] for name in ("press.m", "again.m")]
    assert written[0] == written[1]
    assert "outputs(1)  slide_position [m]" in (tmp_path / "press.m").read_text()
    assert main(["export", "crank_slide", "--to", "c", "--no-bearings", "--out", "small.c"]) == 0
    assert {path.name for path in tmp_path.glob("small.*")} == {"small.c", "small.h"}


def test_options_of_another_format_are_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for words, said in (
        (["--to", "fmu", "--single"], "--single is of C tables"),
        (["--to", "c", "--platform", "win64"], "--compiler and --platform are of an FMU"),
        (["--to", "m", "--compiler", "cc"], "--compiler and --platform are of an FMU"),
    ):
        assert main(["export", "crank_slide", *words]) == 2
        assert said in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["export", "crank_slide", "--to", "c", "--bearing", "O", "--no-bearings"])
    assert list(tmp_path.iterdir()) == []


def test_an_input_may_have_the_name_of_the_torque(tmp_path):
    """All variables of an FMU have names of their own."""
    twist = {"torque": pp.loads.PointMoment("rod", (0.0, 1.0, 0.0)), "tolerance": pp.loads.PointForce("slide", (0.0, 0.0, 1.0))}
    table = pp.export.tabulate(texts.shipped("crank_slide"), bearings=(), inputs=twist)
    path = pp.export.fmu(table, tmp_path / "press.fmu", compiler=None)
    names = [each.name for each in fmpy.read_model_description(str(path)).modelVariables]
    assert len({name.lower() for name in names}) == len(names)
    assert {"torque", "torque_2", "tolerance", "tolerance_2"} <= set(names)
