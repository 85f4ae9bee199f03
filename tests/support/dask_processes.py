"""A Dask cluster of separate processes on this machine, started by the commands that the guide names."""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]


@contextmanager
def dask_processes(folder, workers=2, dashboard=False, nanny=False):
    """The scheduler's file, and the processes of the scheduler and the workers, which are killed at the end of the block.

    Args:
        folder: folder for the scheduler's file, logs and the workers' files.
        workers: number of workers, of one thread each.
        dashboard: whether the scheduler shows what it does, on a port of its choice that its log names.
        nanny: whether a second process watches over each worker and starts it anew when it dies.
    """
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join((str(TESTS.parent), str(TESTS))),
        "OMP_NUM_THREADS": "1",
        "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "20s",
        "DASK_TEMPORARY_DIRECTORY": str(folder),
    }
    file, processes = Path(folder) / "scheduler.json", []

    def start(what, *arguments):
        command = [sys.executable, "-m", "dask", what, "--host", "127.0.0.1", "--scheduler-file", str(file), *arguments]
        with open(Path(folder) / f"{what}{len(processes)}.log", "w") as log:
            processes.append(subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=log, start_new_session=True))

    try:
        start("scheduler", "--port", "0", *(("--dashboard-address", "127.0.0.1:0") if dashboard else ("--no-dashboard",)))
        while not file.exists():
            assert processes[0].poll() is None, f"the scheduler has ended: see {folder}"
            time.sleep(0.02)
        for _ in range(workers):
            start("worker", "--nthreads", "1", "--no-dashboard", *(() if nanny else ("--no-nanny",)))
        yield file, processes
    finally:
        for process in processes:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
