"""All files of the library: they are written whole or not at all, and read only if they are regular files of bounded size."""

import errno
import itertools
import os
import secrets
import stat
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from io import BytesIO, FileIO
from pathlib import Path

from .errors import PinpressError, shown, suggestion


def write(path: str | os.PathLike[str], content: bytes) -> Path:
    """Write a file in one step, so that it holds the old content or the new one, never a part of it. Returns the path.

    The file keeps its mode, and a link to it stays a link. A file with several names (hard links) keeps them: only such a file is written
    in place, after the disk has allocated the room, so that a crash of the machine can leave it mixed. What is no regular file, such as a
    device, a pipe or this program's own output, is written to directly.

    Raises:
        PinpressError: the file cannot be written; its old content is unchanged.
    """
    with refused(path):
        before = _status(path)
        if before is None:
            _replace(Path(os.path.realpath(path)), None, content)
        elif (stream := _stream(path, before)) is not None:
            with stream:
                _send(stream, content)
        elif before.st_nlink > 1:
            _overwrite(path, before, content)
        else:
            _replace(Path(os.path.realpath(path)), before, content)
    return Path(path)


@contextmanager
def written(path: str | os.PathLike[str], suffix: str = "") -> Iterator[Path]:
    """A temporary file with this suffix for other programs to write. Its content is written to ``path`` at the end of the block if nothing
    failed.

    Raises:
        PinpressError: the path cannot be written; raised before the block where that is known.
    """
    with ExitStack() as tidying:
        with refused(path):
            if _status(path) is None:
                parent = Path(os.path.realpath(path)).parent
                if not parent.is_dir():
                    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
                if not os.access(parent, os.W_OK):
                    raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            # Next to the path a kill would leave it.
            folder = tidying.enter_context(tempfile.TemporaryDirectory(prefix="pinpress-"))
        part = Path(folder, "part" + suffix)
        yield part
        with refused(path):
            content = part.read_bytes()
        write(path, content)


@contextmanager
def refused(path: object) -> Iterator[None]:
    """Turns errors of writing a file into a PinpressError that names ``path``."""
    if not isinstance(path, str | os.PathLike):  # the number of an open file would be taken for a path
        raise PinpressError(f"cannot write {shown(path)}: it is no path; give the path of a file")
    try:
        yield
    except (OSError, ValueError, TypeError) as error:  # ValueError: a null character in the path; TypeError: no path at all
        reason = getattr(error, "strerror", None) or str(error)
        raise PinpressError(f"cannot write {path}: {reason}; give a file in a directory you can write to") from error


def _status(path: str | os.PathLike[str]) -> os.stat_result | None:
    """Status of the file at a path, None without a file; raises OSError if the file cannot be written."""
    try:
        status = os.stat(path)
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not os.access(path, os.W_OK):  # to replace it, write access to its folder would be enough
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return status


def _stream(path: str | os.PathLike[str], before: os.stat_result) -> FileIO | None:
    """The stream of a file that is written to directly; None of a regular file, unless it is this program's own output."""
    for standard in (1, 2):
        with suppress(OSError):  # closed
            if os.path.samestat(os.fstat(standard), before):
                return FileIO(os.dup(standard), "w")
    return None if stat.S_ISREG(before.st_mode) else FileIO(os.open(path, os.O_WRONLY), "w")


def _replace(target: Path, before: os.stat_result | None, content: bytes) -> None:
    """Write a file next to the target, and give it the mode, owner and name of the target."""
    part = target.with_name(f".pinpress-{secrets.token_hex(8)}")
    try:
        descriptor = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
        with FileIO(descriptor, "w") as stream:
            _fill(stream, before, content)
        os.replace(part, target)
    except BaseException:
        with suppress(OSError):
            part.unlink()
        raise


def _fill(stream: FileIO, before: os.stat_result | None, content: bytes) -> None:
    """Write a new file with the owner and mode of the file ``before``."""
    descriptor = stream.fileno()
    if before is not None:
        if hasattr(os, "fchown") and (before.st_uid, before.st_gid) != (os.geteuid(), os.getegid()):
            with suppress(OSError):  # only root may
                os.fchown(descriptor, before.st_uid, before.st_gid)
        if hasattr(os, "fchmod"):
            os.fchmod(descriptor, stat.S_IMODE(before.st_mode))
    _send(stream, content)
    os.fsync(descriptor)


def _overwrite(path: str | os.PathLike[str], before: os.stat_result, content: bytes) -> None:
    """Write a file in place."""
    with open(path, "r+b", buffering=0) as stream:
        if content and hasattr(os, "posix_fallocate"):
            try:
                os.posix_fallocate(stream.fileno(), 0, len(content))
            except OSError:
                stream.truncate(before.st_size)
                raise
        _send(stream, content)
        stream.truncate(len(content))
        os.fsync(stream.fileno())


def _send(stream: FileIO, content: bytes) -> None:
    """Write the whole content: a stream may take only a part at a time."""
    left = memoryview(content)
    while left:
        left = left[stream.write(left) :]


def make_folder(folder: Path) -> None:
    """Make a folder if it does not exist; raises PinpressError if that fails."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PinpressError(f"cannot make the folder {folder}: {error.strerror}; choose another --out") from None


def read(path: str | os.PathLike[str], most: int) -> bytes:
    """The content of a regular file. Pipes and devices are refused because they may have no end.

    Raises:
        OSError: the file cannot be read, is no regular file, or has more than ``most`` bytes; `reason` says why.
        ValueError: there is a null character in the path.
    """
    # The file is opened before its status is read, so that it cannot be exchanged in between, and without waiting for a pipe's writer.
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


def uncompressed(path: str, content: bytes, most: int) -> bytes:
    """The content of a file, which is compressed if its name ends in ``.gz`` or ``.bz2``; raises OSError if it is not whole, or has more
    than ``most`` bytes."""
    ending = path.lower().rpartition(".")[2]
    if ending not in ("gz", "bz2"):
        return content
    import bz2  # to save start-up time
    import gzip
    import zlib

    unpacked = gzip.GzipFile(fileobj=BytesIO(content)) if ending == "gz" else bz2.BZ2File(BytesIO(content))
    try:
        with unpacked:
            whole = unpacked.read(most + 1)
    except (EOFError, zlib.error) as error:
        raise OSError(errno.EINVAL, f"what is compressed in it is not whole: {error}") from error
    if len(whole) > most:
        raise OSError(errno.EFBIG, f"uncompressed it is larger than {most / 1e6:g} MB")
    return whole


def reason(error: OSError | ValueError) -> str:
    """Why a file could not be read. For a missing file: whether its folder has one of nearly the same name."""
    text = getattr(error, "strerror", None) or str(error)
    return text + alike(error.filename) if isinstance(error, FileNotFoundError) and isinstance(error.filename, str) else text


def alike(path: str) -> str:
    """The words ", did you mean 'x'?" if the folder of a missing file has one of nearly the same name, else an empty text."""
    folder, name = os.path.split(path)
    try:
        return suggestion(name, itertools.islice(os.listdir(folder or os.curdir), 1000))  # more would take long
    except (OSError, ValueError):
        return ""


def path_of(name: str, path: object) -> str:
    """A path as text; raises PinpressError with the name of the argument where it is no path."""
    if isinstance(path, str | Path | os.PathLike):
        text = os.fspath(path)
        if isinstance(text, str):
            return text
    raise PinpressError(f"{name} is {shown(path)}: give the path of a file")
