"""Writing files: whole, or not at all."""

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from .errors import PinpressError


def write(path: str | os.PathLike[str], content: bytes) -> Path:
    """Write a file in one step, so that none is left half written; a link to a file stays one. Returns the path.

    Raises:
        PinpressError: it cannot be written.
    """
    with written(path) as part, refused(path):
        part.write_bytes(content)
    return Path(path)


@contextmanager
def written(path: str | os.PathLike[str], suffix: str = "") -> Iterator[Path]:
    """A file to write, with this suffix, that becomes ``path`` at the end of the block, if nothing failed.

    Raises:
        PinpressError: a path that cannot be written, before the block.
    """
    with ExitStack() as tidying:
        with refused(path):
            target = Path(os.path.realpath(path))
            if target.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            # in the same directory, so that the last step is atomic
            folder = tidying.enter_context(tempfile.TemporaryDirectory(dir=target.parent, prefix=".pinpress-"))
        part = Path(folder, "part" + suffix)
        yield part
        with refused(path):
            os.replace(part, target)


@contextmanager
def refused(path: object) -> Iterator[None]:
    """Turns what goes wrong in writing a file into a PinpressError that names ``path``."""
    try:
        yield
    except (OSError, ValueError, TypeError) as error:  # ValueError: a null character in the path; TypeError: no path at all
        reason = getattr(error, "strerror", None) or str(error)
        raise PinpressError(f"cannot write {path}: {reason}; give a file in a directory you can write to") from error
