"""Folders that last as long as the process that makes them."""

import atexit
import os
import shutil
import tempfile
from pathlib import Path


def process_folder(prefix: str) -> Path:
    """A new folder, removed when this process ends; not by those that are forked from it, which call `atexit` too from Python 3.14 on."""
    folder, process = tempfile.mkdtemp(prefix=prefix), os.getpid()

    def remove() -> None:
        if os.getpid() == process:
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    return Path(folder)
