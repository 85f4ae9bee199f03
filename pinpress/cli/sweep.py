"""`pinpress sweep`: call a function at every point of a grid, here or on a Dask cluster, and write an SQLite file."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import logging
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..common.errors import PinpressError, UnknownNameError
from .words.progress import progress

MOST_A_AXIS = 10_000_000
IN_FLIGHT = 64  # tasks submitted at once, at least
MEMORY = "MALLOC_TRIM_THRESHOLD_=134217728 MALLOC_MMAP_THRESHOLD_=33554432"  # [bytes]
HASTY = "workers return freed memory at once (the default of Dask), which makes large arrays several times slower"
REACHED = 10  # time within which a scheduler must answer [s]
EPILOG = """\
STUDY.py:FUNCTION is a function in your file: def strokes(inertia, force): ... return {"lowest_speed": ...}. Its arguments are the axes'
names. It returns names with numbers, texts or bools; with --at-once it takes and returns arrays, a value for each of many points.

--axis force=0:250e3:100 makes 100 values at equal steps from 0 to 250e3, --axis power=30e3,45e3,60e3 these three values. The function gets
the numbers as they are, without units. The points are all combinations (a full factorial); the last axis changes fastest.

--latin-hypercube 200 makes 200 points instead, spread over the ranges --axis force=0:250e3 --axis power=30e3:60e3: each 200th part of each
range has one value, for any number of axes.

A cluster is started by `dask scheduler` on one machine, and on each that works by
    MALLOC_TRIM_THRESHOLD_=134217728 MALLOC_MMAP_THRESHOLD_=33554432 dask worker tcp://SCHEDULER:8786 --nworkers -1 --nthreads 1
all with pip install 'pinpress[cluster]'. The workers get the file, but not other modules of yours that it imports. After Ctrl-C the same
command continues the work. Any program for SQLite reads the results; pp.sweeps.read("runs.sqlite").to_parquet("runs.parquet") writes them
for pandas, Polars and DuckDB.

e.g. pinpress sweep strokes.py:strokes --axis inertia=100:200:100 --axis force=0:250e3:100 --at-once --to runs.sqlite --processes 4
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `sweep` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "sweep",
        help="call your function at every point of a grid, in processes or on a cluster, and write an SQLite file",
        description="Call your function at every point of a grid, in processes of this machine or on a Dask cluster, and write\n"
        "the results to an SQLite file as they arrive. After a stop the same command continues the work.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("function", metavar="STUDY.py:FUNCTION", help="file and function")
    option("--axis", action="append", required=True, metavar="NAME=VALUES", help="FIRST:LAST:COUNT, or values with commas; see below")
    help = "a Latin hypercube of this number of points in place of all combinations; then each --axis is NAME=LOW:HIGH"
    option("--latin-hypercube", type=int, metavar="N", help=help)
    option("--seed", type=int, metavar="S", help="seed of its random numbers (default: 0); the same seed gives the same points")
    option("--to", type=Path, required=True, metavar="FILE.sqlite", help="file for the results, with a name that ends with .sqlite")
    option("--at-once", action="store_true", help="the function takes many points at once, as arrays")
    option("--points-a-part", type=int, metavar="N", help="number of points in a call, with --at-once (default: 1000)")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--processes", type=int, default=1, metavar="N", help="number of processes on this machine (default: 1)")
    where.add_argument("--cluster", metavar="ADDRESS", help="scheduler of a Dask cluster, such as tcp://127.0.0.1:8786")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Sweep, and print the ranges of the results.

    Raises:
        PinpressError: an option is wrong, the function cannot be imported, the cluster cannot be reached, or the sweep fails.
    """
    from ..sweeps.sweeping import sweep  # to save start-up time, that of all other commands

    if options.points_a_part is not None and not options.at_once:
        raise PinpressError("--points-a-part is the number of points in a call with arrays: also give --at-once, or leave it out")
    grid = _grid(options)
    function, file = _function(options.function)
    done = 0.0
    try:
        with _executor(options, file) as (executor, threads), progress(1.0) as told:

            def tell(share: float) -> None:
                nonlocal done
                done = share
                told(share)

            found = sweep(
                function,
                grid,
                to=options.to,
                at_once=options.at_once if options.points_a_part is None else options.points_a_part,
                paired=options.latin_hypercube is not None,
                executor=executor,
                in_flight=max(IN_FLIGHT, 2 * threads),
                progress=tell,
            )
    except KeyboardInterrupt:  # here the bar is wiped
        said = f"{100 * done:.1f} % of the points are in {options.to}; " if done else ""  # before the first task that is unknown
        print(f"{said}the same command continues the work", file=sys.stderr)
        raise
    print(found)
    return 0


def _grid(options: argparse.Namespace) -> dict[str, Sequence[Any]]:
    """Values of the axes, of all combinations, or point by point of a Latin hypercube."""
    from ..sweeps.experiments import latin_hypercube  # as above

    if options.latin_hypercube is None and options.seed is not None:
        raise PinpressError("--seed is the seed of a --latin-hypercube: also give --latin-hypercube, or leave the seed out")
    read = _axis if options.latin_hypercube is None else _range
    grid: dict[str, Sequence[Any]] = {}
    for words in options.axis:
        name, values = read(words)
        if name in grid:
            raise PinpressError(f"--axis {words}: {name} is given twice")
        grid[name] = values
    return grid if options.latin_hypercube is None else {**latin_hypercube(grid, options.latin_hypercube, seed=options.seed or 0)}


def _range(words: str) -> tuple[str, list[Any]]:
    """Read name and ends of a range from ``name=0:1``."""
    name, _, text = words.partition("=")
    ends = [_value(words, each) for each in text.split(":")] if text.count(":") == 1 else []
    if not name or not ends or any(isinstance(each, str) for each in ends):
        raise PinpressError(f"--axis {words}: a Latin hypercube fills ranges: write NAME=LOW:HIGH, such as force=0:250e3")
    return name, ends


def _axis(words: str) -> tuple[str, list[Any]]:
    """Read name and values of an axis from ``name=0:1:11`` or ``name=1,2,5``."""
    name, equals, text = words.partition("=")
    if not (name and equals and text):
        raise PinpressError(f"--axis {words}: write NAME=FIRST:LAST:COUNT or NAME=VALUE,VALUE,..., such as force=0:250e3:100")
    if text.count(":") == 1:
        raise PinpressError(f"--axis {words}: the number of values is missing: write FIRST:LAST:COUNT, or give --latin-hypercube")
    if text.count(":") != 2:
        return name, [_value(words, each) for each in text.split(",")]
    first, last, count = (_value(words, each) for each in text.split(":"))
    if not isinstance(count, int) or not 2 <= count <= MOST_A_AXIS or isinstance(first, str) or isinstance(last, str):
        raise PinpressError(f"--axis {words}: give the first and the last number, and the number of values, at least 2")
    return name, np.linspace(first, last, count).tolist()


def _value(axis: str, text: str) -> int | float | str:
    """Read a number or a text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    if not text or text[0] in "+-." or text[0].isdigit():
        raise PinpressError(f"--axis {axis}: {text!r} is not a number: give numbers as the function takes them, without units, or texts")
    return text


def _function(words: str) -> tuple[Callable[..., Any], Path]:
    """Import the function of a file; returns the function and the file."""
    path, colon, name = words.rpartition(":")
    file = Path(path).resolve()
    if not colon or not name.isidentifier() or file.suffix != ".py" or not file.stem.isidentifier():
        raise PinpressError(f"{words!r} does not name a function of a file: write STUDY.py:FUNCTION, such as strokes.py:strokes")
    if not file.is_file():
        raise PinpressError(f"there is no file {path}")
    sys.path.insert(0, str(file.parent))
    try:
        module = importlib.import_module(file.stem)
    except Exception as error:
        raise PinpressError(f"{path} cannot be imported ({type(error).__name__}: {error})") from error
    if not module.__file__ or Path(module.__file__).resolve() != file:
        raise PinpressError(f"{path} has the name of another module, {module.__file__ or file.stem}: give the file another name")
    found = getattr(module, name, None)
    if not callable(found):
        raise UnknownNameError(f"function of {path}", name, tuple(each for each, value in vars(module).items() if callable(value)))
    return found, file


@contextmanager
def _executor(options: argparse.Namespace, file: Path) -> Iterator[tuple[Executor | None, int]]:
    """The executor of the work, and its number of threads."""
    if options.cluster is not None:
        with _cluster(options.cluster, file) as found:
            yield found
    elif options.processes < 1:
        raise PinpressError(f"--processes {options.processes}: give the number of processes, at least 1")
    elif options.processes == 1:
        yield None, 1
    else:
        with ProcessPoolExecutor(options.processes, initializer=_begin_worker, initargs=(str(file.parent),)) as pool:
            yield pool, options.processes


@contextmanager
def _cluster(address: str, file: Path) -> Iterator[tuple[Executor, int]]:
    """The executor of a Dask cluster whose workers have the file, and the number of their threads."""
    if importlib.util.find_spec("distributed") is None:
        raise PinpressError("Dask is not installed: pip install 'pinpress[cluster]'")
    from distributed import Client  # optional, and slow to import

    try:
        client = Client(address, timeout=REACHED)
    except (OSError, ValueError) as error:
        raise PinpressError(
            f"no scheduler answers at {address} ({error}): start one by `dask scheduler`, which prints its address"
        ) from error
    with client:
        client.upload_file(str(file))
        threads = sum(client.nthreads().values())
        print(f"{threads} threads; dashboard {client.dashboard_link}", flush=True)
        if not threads:
            print(f"waiting for workers: {MEMORY} dask worker {address} --nworkers -1 --nthreads 1", flush=True)
        if "65536" in client.run(os.environ.get, "MALLOC_TRIM_THRESHOLD_").values():
            print(f"{HASTY}: start them with {MEMORY}", file=sys.stderr, flush=True)
        for name in ("tornado.application", "distributed.batched"):  # the message below reports a lost scheduler, not Dask's tracebacks
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            yield client.get_executor(), threads
        except PinpressError as error:
            if client.status == "running":
                raise
            raise PinpressError(f"the scheduler at {address} has stopped, and its workers too: start them again. {error}") from error


def _begin_worker(folder: str) -> None:
    """Prepare a process of a pool: Ctrl-C ends the command, which ends the pool; studies are imported from the command's folder."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.path.insert(0, folder)
