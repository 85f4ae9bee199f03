"""A sweep of 10 000 simulations killed twice and resumed loses nothing, and repeats nothing that was finished."""

import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from contextlib import closing, suppress
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from support.sweep_10000 import DURATION, INERTIAS, PRESS, grid, stroke
from support.time_limit import within

import pinpress as pp
from pinpress.sweeps.sweeping import sweep

SPEEDS = 400


def executions(log):
    return Counter(log.read_text().splitlines()) if log.exists() else Counter()


def finished(file, copies):
    """Points in the file and its log as a kill has left them, read in copies: (speed, inertia) as the log of executions has them."""
    copies.mkdir()
    for path in (file, file.with_name(f"{file.name}-wal")):
        shutil.copy(path, copies)
    with closing(sqlite3.connect(copies / file.name)) as database:
        numbers = [number for (number,) in database.execute("SELECT point FROM points")]
    speeds = grid(SPEEDS)["speed"]
    return [f"{float(speeds[k // len(INERTIAS)])!r},{float(INERTIAS[k % len(INERTIAS)])!r}" for k in numbers]


@pytest.mark.exhaustive
def test_killed_twice_and_resumed(tmp_path):
    file, log = tmp_path / "r.sqlite", tmp_path / "log"
    points = SPEEDS * len(INERTIAS)
    program = Path(__file__).parents[1] / "support" / "sweep_10000.py"
    started = []

    def start(workers):
        command = [sys.executable, str(program), str(file), str(log), str(SPEEDS), str(workers)]
        # A session of its own, to end its worker processes too, which outlive it.
        started.append(subprocess.Popen(command, start_new_session=True, env=os.environ | {"OMP_NUM_THREADS": "1"}))
        return started[-1]

    try:
        with within(300):
            at_kills = []
            for workers, share in ((0, 0.3), (2, 0.6)):
                process = start(workers)
                while not log.exists() or log.read_bytes().count(b"\n") < share * points:
                    assert process.poll() is None
                    time.sleep(0.002)
                os.kill(process.pid, signal.SIGKILL)  # alone: its workers hold neither the lock nor the file
                assert process.wait() == -signal.SIGKILL
                at_kills.append((finished(file, tmp_path / str(workers)), len(log.read_bytes())))
            last = start(2)
            assert last.wait() == 0
    finally:
        for process in started:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    done = executions(log)
    assert len(done) == points
    for known, until in at_kills:
        assert len(known) == len(set(known)) < points
        assert len(known) > 0.15 * points
        later = log.read_bytes()[until:].decode().split("\n")
        assert not set(known) & set(later), "a finished point was done again"
    assert len(at_kills[0][0]) < len(at_kills[1][0])
    # What was in hand at a kill is done again: at most once for each of the two.
    assert max(done.values()) <= 3
    found = sweep(partial(stroke, log=str(log)), grid(SPEEDS), to=file)
    assert executions(log) == done  # all of it was there
    assert found.failed == ()
    for number in range(0, points, max(1, points // 20) + 1):
        speed, inertia = (float(found.column(name)[number]) for name in ("speed", "inertia"))
        again = stroke(speed, inertia, log=os.devnull)
        assert {name: found.column(name)[number] for name in again} == again
        alone = pp.simulate(PRESS, DURATION, speed=speed, flywheel=pp.drives.Flywheel(inertia), points=2)
        np.testing.assert_allclose([again["angle"], again["speed_after"]], [alone.crank_angle[-1], alone.crank_speed[-1]], rtol=1e-12)
