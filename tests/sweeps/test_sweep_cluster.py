"""Sweeps on a Dask cluster of separate processes, some of which are killed."""

import os
import signal
from collections import Counter
from functools import partial
from pathlib import Path
from urllib.request import urlopen

import numpy as np
import pytest
from support.dask_processes import dask_processes
from support.sweep_points import dies_at_once, fails_at_odd, logged, logged_at_once
from support.time_limit import within

import pinpress as pp
from pinpress.sweeps.sweeping import sweep


@pytest.fixture
def cluster(tmp_path):
    """Client, and the processes of the scheduler and the two workers."""
    distributed = pytest.importorskip("distributed")  # here, as to import it takes longer than to collect all tests of a room
    # The time is that in which a scheduler that was killed is sought.
    with dask_processes(tmp_path) as (file, processes), distributed.Client(scheduler_file=str(file), timeout=5) as client:
        client.wait_for_workers(2, timeout=60)
        yield client, processes


def killing(process, share):
    """A function of the finished share that kills a process beyond a share."""

    def kill(finished):
        if finished > share and process.poll() is None:
            process.kill()
            process.wait()

    return kill


@pytest.mark.exhaustive
def test_a_worker_is_killed_in_the_middle(cluster, tmp_path):
    client, (scheduler, *workers) = cluster
    file, log = tmp_path / "r.sqlite", tmp_path / "log"
    points, function = range(400), partial(logged, log=str(log), pause=0.01)
    with within(120):
        progress = killing(workers[0], 0.4)
        found = sweep(function, {"a": points}, to=file, executor=client.get_executor(), in_flight=8, progress=progress)
    assert workers[0].poll() == -signal.SIGKILL
    assert found.failed == ()
    assert found.column("twice").tolist() == [2 * a for a in points]
    by = Counter(found.column("process").tolist())
    assert set(by) == {worker.pid for worker in workers}, "both have worked"
    done = Counter(int(line.split(",")[0]) for line in log.read_text().splitlines())
    assert sorted(done) == list(points)
    # Dask has done again what the killed worker had in hand, or had not handed over: eight tasks of at most 0.2 s
    assert sum(done.values()) - len(points) <= 8 * 20
    # A function that fails, and one that no worker can do.
    assert len(sweep(fails_at_odd, {"a": points}, executor=client.get_executor()).failed) == 200
    other = tmp_path / "other.sqlite"
    with within(120), pytest.raises(pp.PinpressError, match="call the same sweep again, with a new executor"):
        sweep(function, {"a": points}, to=other, executor=client.get_executor(), in_flight=8, progress=killing(scheduler, 0.2))
    assert len(points) - len(pp.sweeps.read(other).missing) > 0.2 * len(points)


@pytest.mark.exhaustive
def test_a_cluster_writes_what_one_process_writes(cluster, tmp_path):
    """Though a worker is killed on the way; and what the scheduler's death leaves is gone on with."""
    client, (scheduler, *workers) = cluster
    grid, log = {"a": np.linspace(0.0, 1.0, 100), "b": np.linspace(0.0, 2.0, 100)}, str(tmp_path / "log")
    alone = sweep(partial(logged_at_once, log=log, pause=0.0), grid, at_once=100)
    function, executor = partial(logged_at_once, log=log, pause=0.02), client.get_executor()
    with within(120):
        progress = killing(workers[0], 0.3)
        found = sweep(function, grid, to=tmp_path / "r.sqlite", at_once=100, executor=executor, in_flight=8, progress=progress)
    assert workers[0].poll() == -signal.SIGKILL
    assert found.failed == ()
    assert found.column("c").tobytes() == alone.column("c").tobytes()
    other = tmp_path / "other.sqlite"
    with within(120), pytest.raises(pp.PinpressError, match="call the same sweep again, with a new executor"):
        sweep(function, grid, to=other, at_once=100, executor=executor, in_flight=8, progress=killing(scheduler, 0.3))
    left = len(pp.sweeps.read(other).missing)
    assert 0 < left < 7500
    before = len(Path(log).read_text().splitlines())
    again = sweep(partial(logged_at_once, log=log, pause=0.0), grid, to=other, at_once=100)
    assert len(Path(log).read_text().splitlines()) - before == left / 100
    assert again.column("c").tobytes() == alone.column("c").tobytes()


@pytest.mark.exhaustive
def test_a_point_that_kills_its_workers_has_failed_on_a_cluster(tmp_path):
    """Dask gives its part up after four deaths; the workers are started anew by their nannies. One can look at it in the dashboard."""
    distributed = pytest.importorskip("distributed")
    cluster = dask_processes(tmp_path, nanny=True, dashboard=True)
    with cluster as (file, _), distributed.Client(scheduler_file=str(file)) as client, within(120):
        client.wait_for_workers(2, timeout=60)
        with urlopen(client.dashboard_link, timeout=30) as page:
            assert "BokehJS" in page.read().decode() or page.status == 200
        function = partial(dies_at_once, at=(7,), how="exit", log=os.devnull)
        found = sweep(function, {"a": range(20)}, to=tmp_path / "r.sqlite", at_once=5, executor=client.get_executor())
    assert [bad.number for bad in found.failed] == [7]
    assert np.ma.compressed(found.column("twice")).tolist() == [2 * k for k in range(20) if k != 7]
