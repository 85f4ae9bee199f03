"""Files made to do harm end in a PinpressError, soon and in little memory, however the process that reads them is limited."""

import os

import pytest
from support.generators import hostile_files
from support.generators.hostile_files import MESHES, URDFS

import pinpress as pp

# Of every way to do harm one file, in one process, so that the rest need not start Python each.
QUICK_MESHES = "one.dae ring.dae scene.dae unnamed.dae bomb.dae skin.dae sampler.dae pipe.obj continued.obj round.obj"
QUICK_URDFS = "deep attributes faults name entities external"


def expect(folder, named, files):
    os.mkfifo(folder / "pipe.mtl")
    for file, said, (_, expected) in zip(files, hostile_files.judged(*files), named, strict=True):
        assert expected in said, file.name


def meshes(folder, names):
    named = [MESHES[name] for name in names]
    expect(folder, named, [hostile_files.with_mesh(folder, name, content) for name, (content, _) in zip(names, named, strict=True)])


def urdfs(folder, names):
    files = [folder / f"{name}.urdf" for name in names]
    for file, name in zip(files, names, strict=True):
        file.write_text(URDFS[name][0], encoding="utf-8")
    expect(folder, [URDFS[name] for name in names], files)


@pytest.mark.exhaustive
def test_meshes(tmp_path):
    meshes(tmp_path, QUICK_MESHES.split())


@pytest.mark.exhaustive
def test_urdfs(tmp_path):
    urdfs(tmp_path, QUICK_URDFS.split())


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sorted({*MESHES} - {*QUICK_MESHES.split()}))
def test_more_meshes(tmp_path, name):
    meshes(tmp_path, [name])


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sorted({*URDFS} - {*QUICK_URDFS.split()}))
def test_more_urdfs(tmp_path, name):
    urdfs(tmp_path, [name])


def test_what_is_no_file(tmp_path):
    """Pipes and devices that never end, files larger than the disk, links in a ring."""
    os.mkfifo(tmp_path / "pipe.urdf")
    (tmp_path / "ring.urdf").symlink_to(tmp_path / "ring.urdf")
    with (tmp_path / "sparse.urdf").open("wb") as file:
        file.truncate(20_000_000_000)
    for path, problem in {
        tmp_path / "pipe.urdf": "not a regular file",
        "/dev/zero": "not a regular file",
        tmp_path / "sparse.urdf": "larger than 20 MB",
        tmp_path / "ring.urdf": "symbolic links",
        tmp_path / ("x" * 300 + ".urdf"): "name too long",
    }.items():
        with pytest.raises(pp.UrdfError, match=f"(?i){problem}"):
            pp.load(path)
    for name, problem in (("pipe.stl", "not a regular file"), ("sparse.stl", "larger than 100 MB")):
        (tmp_path / name.replace("stl", "urdf")).rename(tmp_path / name)
        urdf = tmp_path / "press.urdf"
        urdf.write_text(hostile_files.press(visual=f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'), encoding="utf-8")
        press = pp.load(urdf)
        with pytest.raises(pp.PinpressError, match=problem):
            pp.record(press, pp.cycle(press, 1.0, points=12), tmp_path / "page.html")
