"""One process at a time on a file of results."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..common import files
from ..common.errors import PinpressError

# A lock of the kernel's (POSIX) ends with its process, also one that is killed, and is not handed on to worker processes, which may outlive
# it. But it is the process's as a whole: two threads are told apart by this set.
_held: set[Path] = set()


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock of a file, ``.lock`` beside it, which is removed at the end.

    Raises:
        PinpressError: another sweep writes to the file.
    """
    path = Path(os.path.realpath(path))
    lock = path.with_name(path.name + ".lock")
    if lock in _held:
        raise PinpressError(f"{path} is being written by another sweep of this process: wait for its end, or give another file")
    _held.add(lock)
    try:
        with files.refused(path):
            descriptor = _taken(path, lock)
        try:
            yield
        finally:
            lock.unlink(missing_ok=True)  # while it is held: nobody else can have taken it
            os.close(descriptor)
    finally:
        _held.discard(lock)


def _taken(path: Path, lock: Path) -> int:
    while True:
        descriptor = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            try:
                fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except (BlockingIOError, PermissionError):
                holder = os.read(descriptor, 20).decode(errors="replace").strip() or "unknown"
                raise PinpressError(
                    f"{path} is being written by another sweep (process {holder}): wait for its end, or give another file"
                ) from None
            if _same(descriptor, lock):
                os.ftruncate(descriptor, 0)
                os.write(descriptor, f"{os.getpid()}\n".encode())
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)  # its holder has just removed it


def _same(descriptor: int, lock: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(lock))
    except FileNotFoundError:
        return False
