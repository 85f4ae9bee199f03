"""`pinpress sweep`: studies of a file here, in processes and on a cluster; interrupted; what is refused."""

import os
import signal
import subprocess
import sys
import time

import pytest
from support.dask_processes import dask_processes

import pinpress as pp
from pinpress.cli.main import main

pytest.importorskip("pandas")

STUDY = """
import time

def area(a, b, kind="full"):
    if a > b:
        raise ValueError("a is longer")
    return {"area": a * b, "made": kind}

def areas(a, b):
    return {"area": a * b}

def slowly(a):
    time.sleep(0.05)
    return {"twice": 2 * a}

number = 3
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    """The file of a study in the working folder, under a name of its own: it is imported into this process."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    name = f"study_{tmp_path.name}".replace("-", "_")
    (tmp_path / f"{name}.py").write_text(STUDY)
    yield f"{name}.py"
    sys.modules.pop(name, None)


def test_a_sweep_of_a_file(study, capsys):
    assert (
        main(["sweep", f"{study}:area", "--axis", "a=0:3:4", "--axis", "b=1,2.5", "--axis", "kind=full,half", "--to", "runs.sqlite"]) == 0
    )
    assert "Sweep of area: 16 points, 6 of which failed" in capsys.readouterr().out
    frame = pp.sweeps.read("runs.sqlite").to_frame()
    assert frame["a"].tolist() == [0.0] * 4 + [1.0] * 4 + [2.0] * 4 + [3.0] * 4
    good = frame[frame["error"] == ""]
    assert (good["area"] == good["a"] * good["b"]).all()
    assert (good["made"] == good["kind"]).all()
    assert frame["error"][8] == "ValueError: a is longer"


def test_processes_and_one_process_write_the_same(study, capsys):
    axes = ["--axis", "a=0:3:50", "--axis", "b=1:2:40", "--at-once", "--points-a-part", "300"]
    assert main(["sweep", f"{study}:areas", *axes, "--to", "one.sqlite"]) == 0
    assert main(["sweep", f"{study}:areas", *axes, "--to", "two.sqlite", "--processes", "2"]) == 0
    one, two = (pp.sweeps.read(f"{name}.sqlite").column("area") for name in ("one", "two"))
    assert len(one) == 2000
    assert one.tobytes() == two.tobytes()


def test_a_latin_hypercube(study, capsys):
    """The points are those of Python, as many as are asked for; one in each part of each range; the same command finds them done."""
    words = [
        "sweep",
        f"{study}:areas",
        "--axis",
        "a=0:3",
        "--axis",
        "b=1e3:2e3",
        "--latin-hypercube",
        "40",
        "--at-once",
        "--to",
        "spread.sqlite",
    ]
    assert main([*words, "--seed", "7"]) == 0
    assert "40 points" in capsys.readouterr().out
    frame, points = pp.sweeps.read("spread.sqlite").to_frame(), pp.sweeps.latin_hypercube({"a": (0.0, 3.0), "b": (1e3, 2e3)}, 40, seed=7)
    for name, (low, high) in {"a": (0, 3), "b": (1e3, 2e3)}.items():
        assert frame[name].tolist() == list(points[name])
        assert sorted(((frame[name] - low) / (high - low) * 40).astype(int)) == list(range(40))
    assert (frame["area"] == frame["a"] * frame["b"]).all()
    assert main([*words, "--seed", "7"]) == 0
    assert main(words) == 2
    assert "spread" in capsys.readouterr().err  # other points: another sweep


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["{}:area", "--axis", "a=0:3"], "the number of values is missing: write FIRST:LAST:COUNT, or give --latin-hypercube"),
        (["{}:area", "--axis", "a=0:3:4", "--latin-hypercube", "9"], "a Latin hypercube fills ranges: write NAME=LOW:HIGH"),
        (["{}:area", "--axis", "a=1,2", "--latin-hypercube", "9"], "a Latin hypercube fills ranges: write NAME=LOW:HIGH"),
        (["{}:area", "--axis", "a=low:high", "--latin-hypercube", "9"], "a Latin hypercube fills ranges: write NAME=LOW:HIGH"),
        (["{}:area", "--axis", "a=3:0", "--latin-hypercube", "9"], "the range of 'a' goes from 3 to 0; give the lower end first"),
        (["{}:area", "--axis", "a=0:3", "--latin-hypercube", "0"], "count is 0"),
        (["{}:area", "--axis", "a=1,2", "--seed", "3"], "--seed is the seed of a --latin-hypercube"),
        (["{}:area", "--axis", "a=1"], "does not take the axes a: missing a required argument: 'b'"),
        (["{}:are", "--axis", "a=1"], "did you mean 'area'"),
        (["{}:number", "--axis", "a=1"], "no function of"),
        (["{}", "--axis", "a=1"], "write STUDY.py:FUNCTION"),
        (["none.py:area", "--axis", "a=1"], "there is no file none.py"),
        (["broken.py:area", "--axis", "a=1"], "broken.py cannot be imported (ZeroDivisionError"),
        (["json.py:area", "--axis", "a=1"], "json.py has the name of another module"),
        (["{}:area", "--axis", "a"], "--axis a: write NAME=FIRST:LAST:COUNT"),
        (["{}:area", "--axis", "a=1kN"], "'1kN' is not a number"),
        (["{}:area", "--axis", "a=1:2:1"], "the number of values, at least 2"),
        (["{}:area", "--axis", "a=1:2:2.5"], "the number of values, at least 2"),
        (["{}:area", "--axis", "a=x:2:3"], "give the first and the last number"),
        (["{}:area", "--axis", "a=1", "--axis", "a=2"], "a is given twice"),
        (["{}:area", "--axis", "a=1", "--processes", "0"], "--processes 0"),
        (["{}:slowly", "--axis", "a=1", "--at-once", "--points-a-part", "0"], "at_once is 0"),
        (["{}:slowly", "--axis", "a=1", "--points-a-part", "9"], "also give --at-once, or leave it out"),
    ],
)
def test_what_is_refused(study, capsys, words, says):
    for name, content in (("broken", "1 / 0"), ("json", "")):
        with open(f"{name}.py", "w") as file:
            file.write(content)
    assert main(["sweep", *(word.format(study) for word in words), "--to", "runs.sqlite"]) == 2
    printed = capsys.readouterr().err
    assert says in printed
    assert printed.count("\n") == 1
    assert not os.path.exists("runs.sqlite")


@pytest.mark.parametrize(("to", "name"), [("runs", "runs"), ("runs.csv", "runs"), ("runs.parquet", "runs"), ("a.b.db", "a.b")])
def test_other_endings_are_refused(study, capsys, to, name):
    assert main(["sweep", f"{study}:area", "--axis", "a=0:3:4", "--axis", "b=1,2.5", "--to", to]) == 2
    assert f"write '{name}.sqlite'; a CSV or Parquet file is written from the result" in capsys.readouterr().err
    assert not os.path.exists(to)


def _wait_for_points(process):
    """Until a sweep has put some points into its log."""
    while not os.path.exists("runs.sqlite-wal") or os.path.getsize("runs.sqlite-wal") < 10_000:
        assert process.poll() is None
        time.sleep(0.01)


@pytest.mark.exhaustive
@pytest.mark.parametrize("where", [[], ["--processes", "2"]])
def test_ctrl_c_leaves_what_was_done(study, where):
    command = [sys.executable, "-m", "pinpress", "sweep", f"{study}:slowly", "--axis", "a=1:40:40", "--to", "runs.sqlite"]
    process = subprocess.Popen([*command, *where], stderr=subprocess.PIPE, text=True, start_new_session=True)
    _wait_for_points(process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to the processes of the pool too
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "of the points are in runs.sqlite; the same command continues the work" in said
    assert "Traceback" not in said
    assert 0 < len(pp.sweeps.read("runs.sqlite").missing) < 40
    done = subprocess.run([*command, *where], stdout=subprocess.PIPE, text=True, check=True)
    assert "40 points, 0 of which failed" in done.stdout
    assert pp.sweeps.read("runs.sqlite").column("twice").tolist() == [2.0 * k for k in range(1, 41)]


@pytest.mark.exhaustive
def test_a_cluster(study, tmp_path, capsys):
    distributed = pytest.importorskip("distributed")
    axes = ["--axis", "a=0:3:50", "--axis", "b=1:2:40", "--at-once", "--points-a-part", "300"]
    (tmp_path / "cluster").mkdir()
    with dask_processes(tmp_path / "cluster") as (file, _):
        with distributed.Client(scheduler_file=str(file)) as client:
            client.wait_for_workers(2, timeout=60)
            address = client.scheduler.address
        assert main(["sweep", f"{study}:areas", *axes, "--to", "runs.sqlite", "--cluster", address]) == 0
    assert "2 threads; dashboard" in capsys.readouterr().out
    assert main(["sweep", f"{study}:areas", *axes, "--to", "one.sqlite"]) == 0
    one, runs = (pp.sweeps.read(f"{name}.sqlite").column("area") for name in ("one", "runs"))
    assert one.tobytes() == runs.tobytes()
    assert main(["sweep", f"{study}:areas", *axes, "--to", "other.sqlite", "--cluster", address]) == 2
    assert "start one by `dask scheduler`" in capsys.readouterr().err
    assert main(["sweep", f"{study}:areas", *axes, "--to", "other.sqlite", "--cluster", "nowhere"]) == 2


@pytest.mark.exhaustive
def test_a_scheduler_that_dies_is_told_without_tracebacks(study, tmp_path):
    distributed = pytest.importorskip("distributed")
    words = [f"{study}:slowly", "--axis", "a=1:400:400", "--to", "runs.sqlite"]
    (tmp_path / "cluster").mkdir()
    with dask_processes(tmp_path / "cluster") as (file, (scheduler, *_)):
        with distributed.Client(scheduler_file=str(file)) as client:
            client.wait_for_workers(2, timeout=60)
            address = client.scheduler.address
        command = [sys.executable, "-m", "pinpress", "sweep", *words, "--cluster", address]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        _wait_for_points(process)
        scheduler.kill()
        _, said = process.communicate(timeout=60)
    assert process.returncode == 2
    assert f"pinpress: the scheduler at {address} has stopped, and its workers too: start them again" in said
    assert "Traceback" not in said
    done = 400 - len(pp.sweeps.read("runs.sqlite").missing)
    assert f"after {done} of 400 points, which are in runs.sqlite; call the same sweep again" in said
