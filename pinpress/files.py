"""Writing files: whole, or not at all."""

import os
from contextlib import suppress
from pathlib import Path

from .errors import PinpressError


def write(path: str | os.PathLike[str], content: bytes) -> Path:
    """Write a file in one step, so that none is left half written; a link to a file stays one. Returns the path.

    Raises:
        PinpressError: it cannot be written.
    """
    try:
        target = Path(os.path.realpath(path))
        part = target.parent / f".{target.name}.{os.getpid()}.part"  # in the same directory, so that the last step is atomic
        try:
            part.write_bytes(content)
            os.replace(part, target)
        finally:
            with suppress(OSError):  # gone already, unless something failed
                part.unlink()
    except (OSError, ValueError, TypeError) as error:  # ValueError: a null character in the path; TypeError: no path at all
        reason = getattr(error, "strerror", None) or str(error)
        raise PinpressError(f"cannot write {path}: {reason}; give a file in a directory you can write to") from error
    return Path(path)
