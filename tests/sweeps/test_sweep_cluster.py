"""A sweep on a Dask cluster of separate processes, one worker of which is killed."""

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest
from support.sweep_points import fails_at_odd, logged
from support.time_limit import within

import pinpress as pp
from pinpress.sweeps.sweeping import sweep

HERE = Path(__file__).resolve().parents[1]


@pytest.fixture
def cluster(tmp_path):
    """Client, and the processes of the scheduler and the two workers."""
    distributed = pytest.importorskip("distributed")  # here, as to import it takes longer than to collect all tests of a room
    environment = os.environ | {
        "PYTHONPATH": str(HERE),
        "OMP_NUM_THREADS": "1",
        "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "20s",
        "DASK_TEMPORARY_DIRECTORY": str(tmp_path),
    }
    address = tmp_path / "scheduler.json"
    processes = []

    def start(what, *arguments):
        command = [sys.executable, "-m", "distributed.cli." + what, "--no-dashboard", *arguments]
        with open(tmp_path / f"{what}{len(processes)}.log", "w") as log:
            processes.append(subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=log, stderr=log, start_new_session=True))

    try:
        start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(address))
        with within(120):
            while not address.exists():
                time.sleep(0.02)
        for _ in range(2):
            start("dask_worker", "--scheduler-file", str(address), "--nthreads", "1", "--no-nanny", "--host", "127.0.0.1")
        with distributed.Client(scheduler_file=str(address)) as client:
            client.wait_for_workers(2, timeout=60)
            yield client, processes
    finally:
        for process in processes:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.mark.exhaustive
def test_a_worker_is_killed_in_the_middle(cluster, tmp_path):
    client, (scheduler, *workers) = cluster
    file, log = tmp_path / "r.sqlite", tmp_path / "log"
    points, killed = range(400), []

    def kill(share):
        if share > 0.4 and not killed:
            killed.append(workers[0].pid)
            os.kill(workers[0].pid, signal.SIGKILL)

    with within(120):
        function = partial(logged, log=str(log), pause=0.01)
        found = sweep(function, {"a": points}, to=file, executor=client.get_executor(), in_flight=8, progress=kill)
    assert killed == [workers[0].pid]
    assert found.failed == ()
    assert found.values["twice"].tolist() == [2 * a for a in points]
    by = Counter(found.values["process"].tolist())
    assert set(by) == {worker.pid for worker in workers}, "both have worked"
    done = Counter(int(line.split(",")[0]) for line in log.read_text().splitlines())
    assert sorted(done) == list(points)
    # Dask has done again what the killed worker had in hand, or had not handed over: eight tasks of at most 0.2 s
    assert sum(done.values()) - len(points) <= 8 * 20
    # A function that fails, and one that no worker can do.
    assert len(sweep(fails_at_odd, {"a": points}, executor=client.get_executor()).failed) == 200

    def kill_the_scheduler(share):
        if share > 0.2 and scheduler.poll() is None:
            scheduler.kill()
            scheduler.wait()

    other = tmp_path / "other.sqlite"
    function = partial(logged, log=str(log), pause=0.01)
    with within(120), pytest.raises(pp.PinpressError, match="call the same sweep again, with a new executor"):
        sweep(function, {"a": points}, to=other, executor=client.get_executor(), in_flight=8, progress=kill_the_scheduler)
    assert len(points) - len(pp.sweeps.read(other).missing) > 0.2 * len(points)
