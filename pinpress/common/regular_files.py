"""Reading files of bounded size, and only what is a file: a pipe may never end, a device may have no end."""

import errno
import os
import stat
from pathlib import Path

from .errors import PinpressError, shown


def read(path: str | os.PathLike[str], most: int) -> bytes:
    """The content of a regular file.

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
