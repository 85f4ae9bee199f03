"""What is shipped: the wheel and the sdist, how much an import brings along, and URDF files that other programs open too."""

import shutil
import sys
import tarfile
import zipfile
from pathlib import Path

import pinocchio
import pytest
from support import distribution
from support.distribution import ROOT, run
from support.sampling import rest_exhaustive

PRESSES = (
    "aida_balance_slide",
    "crank_slide",
    "eccentric_blocks",
    "jf75g_125",
    "jf75g_125_plain",
    "jf75g_125_symmetric",
    "jf75g_125_two_point",
    "pirica_double_knuckle",
    "thin_wall",
    "underdrive",
    "zxn2_3000b",
    "zxn2_3000b_balanced",
)
MODULES = {path.relative_to(ROOT).as_posix() for path in (ROOT / "pinpress").rglob("*.py*") if path.suffix in (".py", ".pyi")}
PAGES = {
    path.relative_to(ROOT).as_posix()
    for room in ("visual", "live", "export")
    for path in (ROOT / "pinpress" / room / "templates").iterdir()
}
TABLES = {path.relative_to(ROOT).as_posix() for path in (ROOT / "pinpress" / "pin_table" / "templates").glob("*.yaml")}
SHIPPED = [f"{name}.{suffix}" for name in PRESSES for suffix in ("urdf", "yaml")]


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> tuple[Path, Path]:
    """The wheel, built from the sdist as an installer without a wheel would, and the sdist."""
    return distribution.build(tmp_path_factory.mktemp("dist"))


@pytest.fixture(scope="module")
def wheel(built, tmp_path_factory) -> Path:
    """Folder in which the wheel is installed."""
    folder = tmp_path_factory.mktemp("site")
    run(sys.executable, "-m", "pip", "install", "--no-deps", "--no-index", "--disable-pip-version-check", "--target", folder, built[0])
    return folder


@pytest.fixture(scope="module")
def editable(tmp_path_factory) -> Path:
    """Folder in which a copy of the checkout is installed as editable: its .pth file leads there."""
    pytest.importorskip("editables", reason="hatchling needs it to build an editable wheel")
    copy, folder = tmp_path_factory.mktemp("copy") / "checkout", tmp_path_factory.mktemp("editable")
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".*", "__pycache__", "tests", "viz", "dist", "out"))
    build = "import sys; from hatchling.build import build_editable; print(build_editable(sys.argv[1]))"
    name = run(sys.executable, "-c", build, folder, cwd=copy).split()[-1]
    zipfile.ZipFile(folder / name).extractall(folder)
    assert not (folder / "pinpress" / "__init__.py").exists()
    return folder


@pytest.fixture(scope="module")
def checkout() -> Path:
    return ROOT


def python(first: Path, code: str, cwd: Path) -> str:
    """Output of code run with ``first`` as the first folder of packages, before those of this interpreter."""
    others = [path for path in sys.path if Path(path).name in ("site-packages", "dist-packages")]
    start = f"import site\nfor folder in {[str(first), *others]!r}: site.addsitedir(folder)\n"
    return run(sys.executable, "-S", "-c", start + code, cwd=cwd, env=distribution.elsewhere())


@pytest.mark.exhaustive
def test_wheel_contents(built):
    with zipfile.ZipFile(built[0]) as archive:
        names = {name for name in archive.namelist() if not name.split("/")[0].endswith(".dist-info")}
        info = [name.split("/", 1)[1] for name in archive.namelist() if name.split("/")[0].endswith(".dist-info")]
        shipped = {name: archive.read(f"pinpress/urdf/{name}") for name in SHIPPED}
    data = {"pinpress/py.typed"} | PAGES | TABLES | {f"pinpress/urdf/{name}" for name in SHIPPED}
    assert names == MODULES | data
    assert "licenses/LICENSE" in info
    assert shipped == {name: (ROOT / "urdf" / name).read_bytes() for name in SHIPPED}


@pytest.mark.exhaustive
def test_sdist_contents(built):
    with tarfile.open(built[1]) as archive:
        names = {name.split("/", 1)[1] for name in archive.getnames() if "/" in name}
    assert names > MODULES
    assert {f"urdf/{name}" for name in SHIPPED} < names
    assert {path.relative_to(ROOT).as_posix() for path in (ROOT / "tests").rglob("*.py")} < names
    assert {"pyproject.toml", "README.md", "LICENSE", "pinpress/py.typed"} | PAGES | TABLES < names
    # What the tests read beside it: they pass where the source distribution is unpacked.
    assert {".ci/run", ".github/workflows/integration.yml", ".pre-commit-config.yaml", ".zenodo.json", "paper/paper.bib"} < names


@pytest.mark.exhaustive
@pytest.mark.parametrize("installed", rest_exhaustive(["checkout", "editable", "wheel"], "checkout"))
def test_presses_load_by_name(request, tmp_path, installed):
    folder = request.getfixturevalue(installed)
    code = "import pinpress as pp; print(pp.__file__, *pp.presses()); print(*(pp.load(name).file for name in pp.presses()), sep='\\n')"
    (imported, *names), *files = (line.split() for line in python(folder, code, tmp_path).splitlines())
    assert tuple(names) == PRESSES
    if installed == "editable":  # from the copy, not from this checkout
        folder = Path(next(folder.glob("*.pth")).read_text(encoding="utf-8").strip())
        assert folder.resolve() != ROOT.resolve()
    assert Path(imported).resolve() == (folder / "pinpress" / "__init__.py").resolve()
    assert [Path(file).parents[2 if installed == "wheel" else 1].resolve() for (file,) in files] == [folder.resolve()] * len(PRESSES)


TURN = "import pinpress as pp; press = pp.load('crank_slide'); motion = pp.cycle(press, 7.0); pp.inverse_dynamics(press, motion)"
RUNS = """
given = dict(drive=pp.drives.ConstantTorque(50.0), flywheel=pp.drives.Flywheel(20.0), loads=[pp.loads.Blanking(1e4, 0.02, 0.01)])
pp.measures.duty_cycle(pp.simulate(press, 0.5, speed=7.0, **given)).utilisation
pp.simulate_batch(press, 0.2, speed=[6.0, 7.0], **given)
motor = pp.drives.Geared(pp.drives.InductionMotor(2e3, 980 * pp.RPM, frequency=50.0, poles=6), 14.0)
pp.steady_state(press, 7.0, **given | {"drive": motor})
pp.ratings.rate(press, 7.0, pp.ratings.Capacities(1e5, nominal_height=0.013, bearings={"P": 1e5}))
pp.sweeps.operating_points(press, speeds=[5.0, 6.0], forces=[1e3, 1e4], unit_load=pp.loads.ConstantForce(1.0, 0.01))
"""


@pytest.mark.parametrize(
    ("code", "unwanted"),
    [
        ("import pinpress", "numpy pinocchio scipy yourdfpy meshcat matplotlib pandas lxml trimesh plotly playwright imageio_ffmpeg PIL"),
        (TURN, "scipy yourdfpy meshcat matplotlib pandas trimesh plotly playwright imageio_ffmpeg PIL pinpress.simulation pinpress.visual"),
        (TURN + RUNS, "scipy matplotlib pandas pinpress.visual"),  # SciPy's import takes several times as long as these runs
    ],
)
def test_import_discipline(checkout, tmp_path, code, unwanted):
    modules = python(checkout, code + "\nimport sys; print(*sys.modules)", tmp_path).split()
    assert "pinpress" in modules
    assert set(unwanted.split()) & set(modules) == set()


@pytest.mark.one_in(12)
@pytest.mark.parametrize("name", PRESSES)
def test_other_programs_open_the_shipped_files(name, capfd):
    from yourdfpy import URDF

    file = str(ROOT / "urdf" / f"{name}.urdf")
    model = pinocchio.buildModelFromUrdf(file)
    shapes = pinocchio.buildGeomFromUrdf(model, file, pinocchio.GeometryType.VISUAL)
    assert capfd.readouterr().err == ""  # where it drops something, Pinocchio only prints
    drawn = URDF.load(file)
    mimicking = {joint.name for joint in drawn.robot.joints if joint.mimic}
    assert set(drawn.actuated_joint_names) | mimicking == set(model.names) - {"universe"}
    assert {link.name for link in drawn.robot.links} == {frame.name for frame in model.frames if frame.type == pinocchio.FrameType.BODY}
    assert shapes.ngeoms == len(drawn.scene.geometry) == sum(len(link.visuals) for link in drawn.robot.links) > 0
