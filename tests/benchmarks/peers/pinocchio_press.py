"""A press in Pinocchio's C++: `pinocchio_loop.cpp`, what its user writes there, compiled when it is first needed.

The compiler is that of the machine, Pinocchio's headers and library are those of its wheel, with the wheel's own definitions, and Eigen's
headers come with the extra `peers`. Compiling takes half a minute; the library is kept in the user's cache folder, one for each version of
Pinocchio, compiler and source. Header-only and for the machine's own processor (`-O3 -march=native`) it took three minutes to compile, and
was no faster.
"""

import ctypes
import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from benchmarks.peers.loop_equations import ends_of, with_loops
from benchmarks.peers.peer import Answer, Peer

from pinpress.common.errors import PinpressError, SimulationError
from pinpress.common.quantities import Array
from pinpress.linkage.linkage import Linkage

SOURCE = Path(__file__).with_name("pinocchio_loop.cpp")
COMPILERS = ("c++", "g++", "clang++")
PATIENCE = 900.0  # time after which the compiler is given up [s]


class PinocchioCpp(Peer):
    """Inverse dynamics by a loop over the crank angles in Pinocchio's C++."""

    cannot = "runs, process loads, friction: the loop is all that is written; closing: it starts from a closed pose"

    def __init__(self, press: Linkage) -> None:
        """Compile the loop where that has not been done, and hand it the press.

        Raises:
            PinpressError: the press has several drivers, gear pairs, welded loops or no loops; or there is no compiler, no Eigen, or the
                compiler fails.
        """
        self._ends = ends_of(press)
        if press.couplings:
            raise PinpressError(f"{press.name} has gear pairs, which are not compared in it")
        self.name = f"Pinocchio {pin.__version__} in C++"
        self._press = press
        self._library = _library()
        self._handle = ctypes.c_void_p(self._library.create_press(*self._description()))

    def __del__(self) -> None:
        if hasattr(self, "_handle"):
            self._library.delete_press(self._handle)

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """See `Peer`."""
        press, angle = self._press, np.ascontiguousarray(angle, dtype=float)
        count, joints = len(angle), len(press.joints)
        torque, force = np.empty(count), np.empty((count, joints + len(self._ends), 3))
        done = self._library.inverse_dynamics(
            self._handle, count, _numbers(angle), ctypes.c_double(speed), _numbers(press.closed), _numbers(torque), _numbers(force)
        )
        if done < count:
            raise SimulationError(f"{self.name} does not close the loops of {press.name}", 0.0, float(angle[done]))
        return Answer(torque, with_loops(press, self._ends, force[:, :joints], force[:, joints:]))

    def _description(self) -> list[Any]:
        """Arguments of ``create_press``."""
        press, tree = self._press, self._press.model
        places, bodies = list(tree.jointPlacements)[1:], list(tree.inertias)[1:]
        given: list[Any] = [
            np.array(list(tree.parents)[1:], dtype=np.intc),
            np.array([axis.turns for axis in press.axes], dtype=np.intc),
            np.array([axis.direction for axis in press.axes]),
            np.array([place.rotation for place in places]),
            np.array([place.translation for place in places]),
            np.array([body.mass for body in bodies]),
            np.array([body.lever for body in bodies]),
            np.array([body.inertia for body in bodies]),
            np.array(tree.gravity.linear),
        ]
        ends = np.array([(end.joint1, end.joint2) for end in self._ends], dtype=np.intc)
        ats = np.array([(end.point1, end.point2) for end in self._ends])
        self._kept = [*given, ends, ats]  # the arrays live until the call is over
        head, tail = [_numbers(array) for array in given], [_numbers(ends), _numbers(ats)]
        return [len(bodies), *head, len(self._ends), *tail, press.driver_indices[0], _numbers(np.ascontiguousarray(press.closed))]


def _numbers(array: Any) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


# ------------------------------------------------------------------------------------------------------------------------------ compiling


def _library() -> ctypes.CDLL:
    """The compiled loop, from the cache where it is there.

    Raises:
        PinpressError: there is no compiler, no Eigen, or the compiler fails.
    """
    command = _command()
    version = subprocess.run([command[0], "--version"], capture_output=True, text=True, check=False, timeout=PATIENCE).stdout
    key = "\n".join([*command, version, pin.__version__, SOURCE.read_text(encoding="utf-8")])
    path = _cache() / f"pinocchio_loop_{hashlib.sha256(key.encode()).hexdigest()[:16]}.so"
    try:
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            _compile(command, path)
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise PinpressError(f"its loop cannot be kept or loaded: {error}") from None
    library.create_press.restype = ctypes.c_void_p
    return library


def _command() -> list[str]:
    """The compiler with its options, but for the file it writes.

    Raises:
        PinpressError: there is no compiler, or no Eigen.
    """
    compiler = next((found for found in map(shutil.which, (os.environ.get("CXX", ""), *COMPILERS)) if found), None)
    if compiler is None:
        raise PinpressError("no C++ compiler is found; install g++ or clang, or set CXX")
    prefix = Path(pin.__file__).resolve().parents[4]
    includes = [prefix / "include", prefix / "include" / "pinocchio" / "deprecated", _eigen(prefix)]
    targets = prefix / "lib" / "cmake" / "pinocchio" / "pinocchioTargets.cmake"
    if not targets.exists():
        raise PinpressError("this installation of Pinocchio has no headers")
    # The first target is that of the headers alone: what Boost's variants of so many joints need.
    defined = re.search(r'INTERFACE_COMPILE_DEFINITIONS "([^"$\\]*)"', targets.read_text(encoding="utf-8"))
    definitions = [*(defined[1].split(";") if defined else []), "NDEBUG", "PINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION"]
    options = ["-std=c++17", "-O2", "-fPIC", "-shared", "-fvisibility=hidden"]
    linked = [f"-L{prefix / 'lib'}", "-lpinocchio_default", f"-Wl,-rpath,{prefix / 'lib'}"]
    found = [word for include in includes for word in ("-isystem", str(include))]
    return [compiler, *options, *(f"-D{name}" for name in definitions), *found, str(SOURCE), *linked]


def _eigen(prefix: Path) -> Path:
    """Folder of Eigen's headers: of the wheel `cmeel-eigen`, or of the system."""
    wheels = (Path(entry) / "cmeel.prefix" for entry in sys.path)
    for root in (prefix, *wheels, Path("/usr"), Path("/usr/local")):
        if (root / "include" / "eigen3" / "Eigen" / "Core").exists():
            return root / "include" / "eigen3"
    raise PinpressError("Eigen's headers are not installed; pip install 'pinpress[peers]'")


def _cache() -> Path:
    """The user's folder for what can be made again."""
    home = Path.home() / ("Library/Caches" if sys.platform == "darwin" else ".cache")
    return Path(os.environ.get("XDG_CACHE_HOME") or home) / "pinpress"


def _compile(command: list[str], path: Path) -> None:
    """Write the library; a second process that does the same at the same time does no harm.

    Raises:
        PinpressError: the compiler fails.
    """
    made = path.with_suffix(f".{os.getpid()}")
    try:
        done = subprocess.run([*command, "-o", str(made)], capture_output=True, text=True, check=False, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        raise PinpressError(f"{command[0]} takes more than {PATIENCE:g} s") from None
    if done.returncode:
        said = next((line for line in done.stderr.splitlines() if "error" in line), f"code {done.returncode}")
        raise PinpressError(f"{command[0]} fails: {said.strip()}")
    os.replace(made, path)
