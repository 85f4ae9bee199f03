"""Files are written whole or left alone, keep what they are, and leave nothing beside them."""

import errno
import os
import signal
import stat
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import pytest
from support.full_disk import full_disk

import pinpress as pp
from pinpress.common import files

pytestmark = pytest.mark.usefixtures("time_limit")

OLD, NEW = b"old content", b"new content, longer than the old one"


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "table.csv"
    path.write_bytes(OLD)
    return path


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o644, 0o755])
def test_mode_is_kept(file, mode):
    file.chmod(mode)
    files.write(file, NEW)
    assert file.read_bytes() == NEW
    assert stat.S_IMODE(file.stat().st_mode) == mode
    assert os.listdir(file.parent) == [file.name]


def test_owner_is_kept(file):
    """By root, who may; all others own what they may replace, or become its owner."""
    if os.geteuid() == 0:
        os.chown(file, 65534, 65533)
    before = file.stat()
    files.write(file, NEW)
    assert (file.stat().st_uid, file.stat().st_gid) == (before.st_uid, before.st_gid)


@pytest.mark.parametrize("name", ["new", "table.csv"])
def test_others_write_elsewhere(file, name):
    """Beside the file nothing is seen until it is whole, nor where writing it has failed."""
    before = os.listdir(file.parent)
    with pytest.raises(ZeroDivisionError), files.written(file.with_name(name)) as part:
        part.write_bytes(NEW[: 1 // 0])
    assert os.listdir(file.parent) == before
    with files.written(file.with_name(name), ".png") as part:
        part.write_bytes(NEW)
        assert part.suffix == ".png"
        assert os.listdir(file.parent) == before
    assert file.with_name(name).read_bytes() == NEW
    assert not part.exists()


@pytest.mark.parametrize("name", ["missing/film.mp4", ".", "table.csv/film.mp4"])
def test_places_are_refused_before_others_write(file, name):
    with pytest.raises(pp.PinpressError, match="cannot write"), files.written(file.parent / name):
        pytest.fail("it was begun")


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_new_files_go_by_the_mask(tmp_path, mask):
    before = os.umask(mask)
    try:
        files.write(tmp_path / "new", NEW)
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o666 & ~mask


def test_links_stay_links(file):
    link, hard, broken = (file.with_name(name) for name in ("link", "hard", "broken"))
    link.symlink_to(file.name)
    broken.symlink_to("new")
    files.write(link, NEW)
    assert link.is_symlink()
    assert file.read_bytes() == NEW
    files.write(broken, NEW)
    assert broken.is_symlink()
    assert file.with_name("new").read_bytes() == NEW
    os.link(file, hard)
    for content in (b"longer than " + NEW, b"short", b""):
        files.write(hard, content)
        assert file.read_bytes() == content
        assert file.samefile(hard)
    assert sorted(os.listdir(file.parent)) == ["broken", "hard", "link", "new", "table.csv"]


def test_pipes_and_devices_are_written_through(tmp_path):
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()))
    reader.start()
    files.write(pipe, NEW)
    reader.join()
    assert read == [NEW]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    files.write("/dev/null", NEW)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    with pytest.raises(pp.PinpressError, match="cannot write /dev/full: No space left"):
        files.write("/dev/full", NEW)


@pytest.mark.parametrize("kind", ["file", "pipe"])
def test_output_is_written_through(tmp_path, kind):
    """After what was printed, also where the output was sent into a file, which stays the one that is open."""
    words = "from pinpress.common import files; print('before', flush=True); files.write('/dev/stdout', b'content\\n'); print('after')"
    with open(tmp_path / "out", "w+b") as out:
        run = subprocess.run([sys.executable, "-c", words], stdout=out if kind == "file" else subprocess.PIPE, check=True)
        out.seek(0)
        assert (out.read() if kind == "file" else run.stdout) == b"before\ncontent\nafter\n"


@pytest.mark.parametrize("names", [1, 2])
def test_a_full_disk_leaves_what_there_was(file, names):
    if names == 2:
        os.link(file, file.with_name("other"))
    before = sorted(os.listdir(file.parent))
    with full_disk(len(OLD)), pytest.raises(pp.PinpressError, match=f"cannot write {file}: {os.strerror(errno.EFBIG)}"):
        files.write(file, 1000 * NEW)
    assert file.read_bytes() == OLD
    assert sorted(os.listdir(file.parent)) == before


def test_places_without_permission():
    """Nobody may, where the tests are root's."""
    words = (
        "import os, sys; from pinpress import PinpressError; from pinpress.common import files\n"
        "if os.geteuid() == 0: os.setuid(65534)\n"
        "for path in sys.argv[1:]:\n"
        "    try: files.write(path, b'new')\n"
        "    except PinpressError as error: print(error)"
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        open_folder, kept = folder / "open", folder / "open" / "kept"
        open_folder.mkdir()
        kept.write_bytes(OLD)
        kept.chmod(0o444)
        for each, mode in ((folder, 0o555), (open_folder, 0o777)):
            each.chmod(mode)
        try:
            run = subprocess.run([sys.executable, "-c", words, kept, folder / "new"], capture_output=True, text=True, check=True)
        finally:
            folder.chmod(0o755)
        assert run.stdout.count("Permission denied; give a file in a directory you can write to") == 2
        assert kept.read_bytes() == OLD
        assert os.listdir(open_folder) == [kept.name]


def test_an_error_leaves_nothing_beside_the_file(file):
    with full_disk(len(NEW)), pytest.raises(pp.PinpressError):
        files.write(file, 1000 * NEW)
    assert os.listdir(file.parent) == [file.name]


def test_a_kill_leaves_the_file_as_it_was(file):
    """When all is written, but not yet under the file's name."""
    words = (
        "import os, signal, sys; from pinpress.common import files\n"
        "os.fsync = lambda _: os.kill(os.getpid(), signal.SIGKILL)\n"
        "files.write(sys.argv[1], bytes(1_000_000))"
    )
    assert subprocess.run([sys.executable, "-c", words, file]).returncode == -signal.SIGKILL
    assert file.read_bytes() == OLD


def test_writers_keep_the_mode(tmp_path):
    press = pp.load("crank_slide")
    motion = pp.cycle(press, 1.0, points=4)
    for name, write in (("m.csv", motion.to_csv), ("m.mat", motion.to_mat), ("m.urdf", lambda path: pp.write_urdf(press, path))):
        path = tmp_path / name
        path.touch(0o600)
        write(path)
        assert path.stat().st_size > 100
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
