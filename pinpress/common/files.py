"""Writing files: whole, or not at all. Reading files of bounded size, and only what is a file. All of the library's files pass here."""

import errno
import os
import secrets
import stat
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from io import FileIO
from pathlib import Path

from .errors import PinpressError, shown


def write(path: str | os.PathLike[str], content: bytes) -> Path:
    """Write a file in one step, so that there is the old content or the new one, never a part of it. Returns the path.

    The file keeps its mode, and a link to it stays a link. One that has several names (hard links) keeps them: it alone is written in
    place, after the disk has given the room, so that a machine that dies meanwhile can leave it mixed. What is no regular file, such as a
    device, a pipe or this program's own output, is written through.

    Raises:
        PinpressError: it cannot be written; what there was is as before.
    """
    with refused(path):
        found = _status(path)
        if found is None:
            _replace(Path(os.path.realpath(path)), None, content)
        elif (stream := _stream(path, found)) is not None:
            with stream:
                _send(stream, content)
        elif found.st_nlink > 1:
            _overwrite(path, found, content)
        else:
            _replace(Path(os.path.realpath(path)), found, content)
    return Path(path)


@contextmanager
def written(path: str | os.PathLike[str], suffix: str = "") -> Iterator[Path]:
    """A temporary file for others to write, with this suffix, whose content `write` puts into ``path`` at the end of the block, if nothing
    failed.

    Raises:
        PinpressError: a path that cannot be written, before the block.
    """
    with ExitStack() as tidying:
        with refused(path):
            if _status(path) is None:
                _refuse_folder(Path(os.path.realpath(path)).parent)
            # not beside the path, where a kill would leave it
            folder = tidying.enter_context(tempfile.TemporaryDirectory(prefix="pinpress-"))
        part = Path(folder, "part" + suffix)
        yield part
        with refused(path):
            content = part.read_bytes()
        write(path, content)


@contextmanager
def refused(path: object) -> Iterator[None]:
    """Turns what goes wrong in writing a file into a PinpressError that names ``path``."""
    if not isinstance(path, str | os.PathLike):  # the number of an open file would be taken for a path
        raise PinpressError(f"cannot write {shown(path)}: it is no path; give the path of a file")
    try:
        yield
    except (OSError, ValueError, TypeError) as error:  # ValueError: a null character in the path; TypeError: no path at all
        reason = getattr(error, "strerror", None) or str(error)
        raise PinpressError(f"cannot write {path}: {reason}; give a file in a directory you can write to") from error


def _status(path: str | os.PathLike[str]) -> os.stat_result | None:
    """Of the file that is there, None where there is none; raise OSError for one that cannot be written."""
    try:
        found = os.stat(path)
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not os.access(path, os.W_OK):  # replacing it would need its folder alone
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return found


def _refuse_folder(folder: Path) -> None:
    if not folder.is_dir():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
    if not os.access(folder, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def _stream(path: str | os.PathLike[str], found: os.stat_result) -> FileIO | None:
    """What a file that is written through is written to: a regular one is, where it is this program's own output."""
    for standard in (1, 2):
        with suppress(OSError):  # closed
            if os.path.samestat(os.fstat(standard), found):
                return FileIO(os.dup(standard), "w")
    return None if stat.S_ISREG(found.st_mode) else FileIO(os.open(path, os.O_WRONLY), "w")


def _replace(target: Path, found: os.stat_result | None, content: bytes) -> None:
    """Write a file beside the target, and give it the target's name, mode and owner."""
    part = target.with_name(f".pinpress-{secrets.token_hex(8)}")
    try:
        if not _nameless(part, found, content):
            descriptor = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
            with FileIO(descriptor, "w") as stream:
                _fill(stream, found, content)
        os.replace(part, target)
    except BaseException:
        with suppress(OSError):
            part.unlink()
        raise


def _nameless(part: Path, found: os.stat_result | None, content: bytes) -> bool:
    """Write a file that has no name as long as it is written, so that a kill leaves nothing of it; whether the system knows such."""
    if not hasattr(os, "O_TMPFILE"):
        return False
    try:
        descriptor = os.open(part.parent, os.O_TMPFILE | os.O_WRONLY, 0o666)
    except OSError:  # not on every file system
        return False
    with FileIO(descriptor, "w") as stream:
        _fill(stream, found, content)
        try:  # src_dir_fd makes it the system call that follows the link to the file
            os.link(f"/proc/self/fd/{descriptor}", part, src_dir_fd=descriptor)
        except OSError:  # /proc is not there
            return False
    return True


def _fill(stream: FileIO, found: os.stat_result | None, content: bytes) -> None:
    descriptor = stream.fileno()
    if found is not None:
        if hasattr(os, "fchown") and (found.st_uid, found.st_gid) != (os.geteuid(), os.getegid()):
            with suppress(OSError):  # only root may
                os.fchown(descriptor, found.st_uid, found.st_gid)
        if hasattr(os, "fchmod"):
            os.fchmod(descriptor, stat.S_IMODE(found.st_mode))
    _send(stream, content)
    os.fsync(descriptor)


def _overwrite(path: str | os.PathLike[str], found: os.stat_result, content: bytes) -> None:
    """Write a file in place."""
    with open(path, "r+b", buffering=0) as stream:
        if content and hasattr(os, "posix_fallocate"):
            try:
                os.posix_fallocate(stream.fileno(), 0, len(content))
            except OSError:
                stream.truncate(found.st_size)
                raise
        _send(stream, content)
        stream.truncate(len(content))
        os.fsync(stream.fileno())


def _send(stream: FileIO, content: bytes) -> None:
    left = memoryview(content)
    while left:
        left = left[stream.write(left) :]


def make_folder(folder: Path) -> None:
    """Make a folder if it is not there; raise PinpressError if that fails."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PinpressError(f"cannot make the folder {folder}: {error.strerror}; choose another --out") from None


def read(path: str | os.PathLike[str], most: int) -> bytes:
    """The content of a regular file: a pipe may never end, a device may have no end.

    Raises:
        OSError: it cannot be read, is no regular file, or has more than ``most`` bytes; `reason` puts it in words.
        ValueError: a null character in the path.
    """
    # Opened before it is looked at, so that it cannot become another in between; without waiting, as a pipe would for a writer.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0))
    with open(descriptor, "rb") as stream:
        status = os.fstat(descriptor)
        if stat.S_ISDIR(status.st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "a pipe, socket or device, not a regular file")
        content = stream.read(most + 1) if status.st_size <= most else None  # + 1: it may have grown since
    if content is None or len(content) > most:
        raise OSError(errno.EFBIG, f"larger than {most / 1e6:g} MB")
    return content


def reason(error: OSError | ValueError) -> str:
    """Why a file could not be read."""
    return getattr(error, "strerror", None) or str(error)


def path_of(name: str, path: object) -> str:
    """A path as text; raises PinpressError, with the name of the argument, where it is none."""
    if isinstance(path, str | Path | os.PathLike):
        text = os.fspath(path)
        if isinstance(text, str):
            return text
    raise PinpressError(f"{name} is {shown(path)}: give the path of a file")
