"""The wheel and the source distribution of this checkout, and programs that are run beside it, without it on their path."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
CHECKOUT_VARIABLES = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")  # they would lead a new environment back to this one


def run(*command: object, **options) -> str:
    """What a command prints; an AssertionError with all that it says where it fails."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def elsewhere(**more: str) -> dict[str, str]:
    """The variables of this process, but for those that name this checkout or its environment."""
    return {name: value for name, value in os.environ.items() if name not in CHECKOUT_VARIABLES} | more


def build(folder: Path) -> tuple[Path, Path]:
    """The wheel, built from the sdist as an installer without a wheel would, and the sdist."""
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, ROOT)
    return next(folder.glob("*.whl")), next(folder.glob("*.tar.gz"))
