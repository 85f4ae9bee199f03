"""What it takes to install pinpress: seconds by pip and by uv, and megabytes, of the package alone and of each extra of users.

Each installation is one of its own: the wheel of this checkout, in a new environment, with no cache, so that all else comes from the index.
Megabytes are those of the files that were unpacked, without compiled bytecode. Seconds depend on the network and on what else the machine
does; in brackets are those of the processor.
"""

import sys
import tempfile
import time
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

from benchmarks.stopwatch import table
from support import distribution
from support.distribution import elsewhere, run

from pinpress.cli.versions import OF_USERS

UV = (sys.executable, "-m", "uv")


def main(quick: bool = False) -> None:
    """Print the table; ``quick``: without extras."""
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        wheel, _ = distribution.build(folder)
        for extra in ("",) if quick else ("", *OF_USERS, "all"):
            what, by_pip, by_uv = f"{wheel}[{extra}]" if extra else wheel, folder / f"pip-{extra}", folder / f"uv-{extra}"
            run(sys.executable, "-m", "venv", by_pip, env=elsewhere())
            run(*UV, "venv", "-q", "--python", sys.executable, by_uv, env=elsewhere())
            times = [
                seconds(by_pip / "bin" / "pip", "install", "-q", "--no-cache-dir", what),
                seconds(*UV, "pip", "install", "-q", "--no-cache", "--python", by_uv, what),
            ]
            (packages,) = by_uv.glob("lib/python*/site-packages")
            megabytes = sum(path.stat().st_size for path in packages.rglob("*") if path.is_file()) / 1e6
            rows.append((f"`{extra}`" if extra else "none", len(list(packages.glob("*.dist-info"))), f"{megabytes:.0f}", *times))
    print(table(("extra", "packages", "MB", "pip", "uv"), rows))


def seconds(*command: object) -> str:
    """Wall time of a command, in brackets that of the processor."""
    start, before = time.perf_counter(), getrusage(RUSAGE_CHILDREN)
    run(*command, env=elsewhere(), cwd=Path(tempfile.gettempdir()))
    used = getrusage(RUSAGE_CHILDREN)
    return f"{time.perf_counter() - start:.0f} s ({used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime:.0f} s)"
