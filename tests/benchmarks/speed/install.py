"""What it takes to install pinpress: seconds by pip and by uv, and megabytes, of the package alone and of each extra of users.

Run `python tests/benchmarks/speed/install.py`, or with names of extras; pytest does not collect this file. Each installation is one
of its own: the wheel of this checkout, in a new environment, with no cache, so that all else comes from the index. Megabytes are those of
the files that were unpacked, without compiled bytecode. Seconds depend on the network and on what else the machine does; in brackets are
those of the processor.
"""

import resource
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
from support import distribution
from support.distribution import elsewhere, run

from pinpress.cli.about import OF_USERS

UV = (sys.executable, "-m", "uv")


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: without extras."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        wheel, _ = distribution.build(folder)
        print("| extra | packages | MB | pip | uv |\n|---|---|---|---|---|")
        for extra in ("",) if quick else sys.argv[1:] or ("", *OF_USERS, "all"):
            what = f"{wheel}[{extra}]" if extra else wheel
            by_pip = by_pip_seconds(folder / f"pip-{extra}", what)
            by_uv = by_uv_seconds(folder / f"uv-{extra}", what)
            packages, megabytes = installed(folder / f"uv-{extra}")
            name = f"`{extra}`" if extra else "none"
            print(f"| {name} | {packages} | {megabytes:.0f} | {by_pip} | {by_uv} |", flush=True)


def by_pip_seconds(environment: Path, what: object) -> str:
    run(sys.executable, "-m", "venv", environment, env=elsewhere())
    return _seconds(environment / "bin" / "pip", "install", "-q", "--no-cache-dir", what)


def by_uv_seconds(environment: Path, what: object) -> str:
    run(*UV, "venv", "-q", "--python", sys.executable, environment, env=elsewhere())
    return _seconds(*UV, "pip", "install", "-q", "--no-cache", "--python", environment, what)


def _seconds(*command: object) -> str:
    start, before = time.perf_counter(), _of_processor()
    run(*command, env=elsewhere(), cwd=Path(tempfile.gettempdir()))
    return f"{time.perf_counter() - start:.0f} s ({_of_processor() - before:.0f} s)"


def _of_processor() -> float:
    """Seconds that processes started here have computed."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def installed(environment: Path) -> tuple[int, float]:
    """Packages in an environment, and megabytes of their files."""
    (folder,) = environment.glob("lib/python*/site-packages")
    return len(list(folder.glob("*.dist-info"))), sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6


if __name__ == "__main__":
    main()
