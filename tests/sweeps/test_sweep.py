"""Sweeps in one process and with local ones: order, types, files, what fails and what is refused."""

import csv
import json
import os
import signal
import subprocess
import sys
import threading
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from support.full_disk import full_disk
from support.sweep_points import dies, doubled, fails_at_odd, logged, product, raises_at_1
from support.time_limit import within

import pinpress as pp
from pinpress.sweeps.sweeping import sweep

pytestmark = pytest.mark.usefixtures("time_limit")

GRID = {"a": [3, 1, 2], "b": np.array([0.5, 4.0])}
FORMATS = ["csv", "parquet"]


@pytest.fixture(params=FORMATS)
def file(request, tmp_path):
    return tmp_path / f"results.{request.param}"


def rows(path):
    with open(path, newline="") as lines:
        return list(csv.reader(lines))


def same(one, other):
    assert list(one.columns) == list(other.columns)
    assert one.failed == other.failed
    for name, column in one.columns.items():
        assert column.dtype == other.columns[name].dtype
        np.testing.assert_array_equal(np.ma.getmaskarray(column), np.ma.getmaskarray(other.columns[name]))
        assert column.tolist() == other.columns[name].tolist()


def test_last_axis_is_the_fastest():
    found = sweep(product, GRID)
    assert found.shape == (3, 2)
    assert found.columns["a"].tolist() == [3, 3, 1, 1, 2, 2]
    assert found.columns["b"].tolist() == [0.5, 4.0] * 3
    np.testing.assert_array_equal(found.grid("product"), np.outer(GRID["a"], GRID["b"]))
    assert found.columns["even"].dtype == bool
    assert found.columns["which"].tolist() == ["a", "b, or, both", "a", "b, or, both", "a", "b, or, both"]
    assert found.failed == ()
    with pytest.raises(pp.UnknownNameError, match="product"):
        found.grid("produkt")


def test_axes_side_by_side():
    found = sweep(product, {"a": [1, 1, 5], "b": [2, 2, 7]}, paired=True)
    assert found.shape == (3,)
    assert found.grid("product").tolist() == [2, 2, 35]


def test_objects_under_labels():
    press = pp.load("crank_slide")
    dies = {"none": [], "drawing": [pp.loads.DeepDrawing(force=1e5, start=0.01)]}

    def torque(speed, loads):
        motion = pp.cycle(press, speed, points=60)
        return {"torque": pp.inverse_dynamics(press, motion, loads, bearings=()).driving_torque.max()}

    found = sweep(torque, {"loads": dies, "speed": [5.0, 10.0]})
    assert found.columns["loads"].tolist() == ["none", "none", "drawing", "drawing"]
    for i, loads in enumerate(dies.values()):
        for j, speed in enumerate((5.0, 10.0)):
            expected = pp.inverse_dynamics(press, pp.cycle(press, speed, points=60), loads).driving_torque.max()
            assert found.grid("torque")[i, j] == pytest.approx(expected, rel=1e-12)


def test_file_is_read_again_and_written_out(file, tmp_path):
    calls = []

    def counted(**point):
        calls.append(point)
        return product(**point)

    alone = sweep(counted, GRID)
    first = sweep(counted, GRID, to=file)
    content = file.read_bytes()
    second = sweep(counted, GRID, to=file)
    assert len(calls) == 12
    assert file.read_bytes() == content
    same(first, alone)
    same(second, alone)
    assert sorted(os.listdir(tmp_path)) == [file.name, f"{file.name}.sweep"]
    frame = second.to_frame()
    assert frame["product"].tolist() == alone.columns["product"].tolist()
    second.to_csv(tmp_path / "table.csv")
    assert [float(row[2]) for row in rows(tmp_path / "table.csv")[1:]] == alone.columns["product"].tolist()
    pandas = pytest.importorskip("pandas")
    second.to_parquet(tmp_path / "table.parquet")
    pandas.testing.assert_frame_equal(pandas.read_parquet(tmp_path / "table.parquet"), frame, check_dtype=False)


def test_failed_points_are_recorded_and_done_again_where_asked(file):
    """The first point fails: only later is it known what the columns are."""
    found = sweep(fails_at_odd, {"a": [1, 2, 3, 4]}, to=file)
    assert [bad.number for bad in found.failed] == [0, 2]
    assert found.failed[0].point == {"a": 1}
    assert found.failed[0].error == 'ValueError: 1 is odd,\nwhich is "bad"'
    assert found.grid("half").tolist() == [None, 1, None, 2]
    assert found.grid("half").sum() == 3
    assert "2 of which failed" in str(found)
    same(sweep(fails_at_odd, {"a": [1, 2, 3, 4]}, to=file), found)

    def fails_at_odd_no_more(a):
        return {"half": a // 2} if a % 2 else pytest.fail("a point that had not failed")

    fails_at_odd_no_more.__qualname__ = "fails_at_odd"
    mended = sweep(fails_at_odd_no_more, {"a": [1, 2, 3, 4]}, to=file, retry_failed=True)
    assert mended.failed == ()
    assert mended.grid("half").tolist() == [0, 1, 1, 2]
    same(sweep(fails_at_odd, {"a": [1, 2, 3, 4]}, to=file), mended)


def test_all_points_fail(file):
    found = sweep(fails_at_odd, {"a": [1, 3]}, to=file)
    assert len(found.failed) == 2
    assert list(found.columns) == ["a"]
    same(sweep(fails_at_odd, {"a": [1, 3]}, to=file), found)


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        ({"x": np.nan}, "'x' nan, which is not finite"),
        ({"x": np.array([1.0, 2.0])}, "'x' a ndarray, no number"),
        ({"x": None}, "'x' a NoneType"),
        ({"x": 2**60}, "too large"),
        ({"x": "\ud800"}, "UTF-8"),
        ({"error": 1.0}, "'error'"),
        ({}, "return a mapping"),
        (3.0, "returned 3.0"),
    ],
)
def test_what_a_table_cannot_hold_has_failed(returned, words):
    found = sweep(lambda a: {"x": 1.0} if a else returned, {"a": [0, 1]})
    assert [bad.number for bad in found.failed] == [0]
    assert words in found.failed[0].error
    assert found.grid("x").tolist() == [None, 1.0]


def test_words_come_back_as_they_were(file):
    words = ["", "a,b", 'say "x"', "two\nlines", "two\r\nlines", "two\rlines", "\r", ",00000000\n0", "1.0", "True", "é 滑块"]
    found = sweep(lambda k: {"word": words[k]}, {"k": range(len(words))}, to=file)
    assert sweep(lambda k: {}, {"k": range(len(words))}, to=file).columns["word"].tolist() == words == found.columns["word"].tolist()
    found.to_csv(file.with_name("table.csv"))
    assert [row[1] for row in rows(file.with_name("table.csv"))[1:]] == words


def test_labels_of_several_kinds(file):
    grid = {"size": {1: 10, "large": 30, 2.5: 20}, "left": [True, False]}
    found = sweep(lambda size, left: {"x": -size if left else size}, grid, to=file)
    assert found.columns["size"].tolist() == [1, 1, "large", "large", 2.5, 2.5]
    assert found.columns["x"].tolist() == [-10, 10, -30, 30, -20, 20]
    same(sweep(lambda size, left: {}, grid, to=file), found)


def test_other_names_stop_the_sweep_and_what_was_done_stays(tmp_path):
    file = tmp_path / "r.csv"
    with pytest.raises(pp.PinpressError, match=r"y \(number\) at \{'a': 2\}, but x \(number\) before"):
        sweep(lambda a: {"x": 1.0} if a < 2 else {"y": 1.0}, {"a": [0, 1, 2]}, to=file)
    assert len(rows(file)) == 3


@pytest.mark.parametrize("end", range(1, 30))
def test_torn_last_line_is_dropped(tmp_path, end):
    """Torn anywhere in the last two lines, in a quotation with a line's end in it too."""
    file, done = tmp_path / "r.csv", []

    def words(a):
        done.append(a)
        return {"word": f'é"\n{a}', "number": 12.25}

    whole = sweep(words, {"a": [0, 1, 2]}, to=file)
    content = file.read_bytes()
    torn = content[:-end]
    file.write_bytes(torn)
    again = sweep(words, {"a": [0, 1, 2]}, to=file)
    same(again, whole)
    last = len(content.split(b"\n2,")[1]) + 2
    assert done == ([0, 1, 2, 2] if end <= last else [0, 1, 2, 1, 2])
    assert file.read_bytes() == content


def test_damaged_or_foreign_files_are_refused(tmp_path):
    file = tmp_path / "r.csv"
    sweep(product, GRID, to=file)
    content, side = file.read_text(), (tmp_path / "r.csv.sweep").read_text()
    for damaged in (
        content.replace("\n1,3,4.0", "\n1,3,4.5"),
        content.replace("\n1,", "\n99,"),
        content.replace("True", "yes", 1),
        content.replace(",1.5,", ",nan,"),
    ):
        assert damaged != content
        file.write_text(damaged)
        with pytest.raises(pp.PinpressError, match=r"row \d is damaged or was changed"):
            sweep(product, GRID, to=file)
    file.write_text("a,b\n1,2\n")
    with pytest.raises(pp.PinpressError, match="first line"):
        sweep(product, GRID, to=file)
    (tmp_path / "r.csv.sweep").write_text(side[:-5])
    with pytest.raises(pp.PinpressError, match=r"r\.csv\.sweep cannot be read"):
        sweep(product, GRID, to=file)
    os.unlink(tmp_path / "r.csv.sweep")
    with pytest.raises(pp.PinpressError, match=r"not r\.csv\.sweep beside it"):
        sweep(product, GRID, to=file)
    assert file.read_text() == "a,b\n1,2\n"


WORDS = ["plain", "two\nlines", 'say "x", or y', "é 滑块", "\r", "7"]


def told(k):
    if k % 5 == 3:
        raise ValueError(f'not {k},\nor "{k}"')
    return {"number": 0.1 * k, "word": WORDS[k % 6], "even": k % 2 == 0, "whole": k}


def edits(content, seed, count):
    """A content with a bit, a byte, a piece or two lines changed, somewhere."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        at, changed = int(rng.integers(len(content))), bytearray(content)
        match rng.integers(6):
            case 0:
                changed[at] ^= 1 << int(rng.integers(8))
            case 1:
                changed[at] = int(rng.choice(list(b'"\n\r,0\xff')))
            case 2:
                changed[at:at] = bytes([int(rng.choice(list(b'"\n\r,0\xff')))])
            case 3:
                del changed[at : at + int(rng.integers(1, 40))]
            case 4:
                changed[at : at + 20] = bytes(20)
            case 5:
                there = int(rng.integers(len(content)))
                changed[at : at + 1], changed[there : there + 1] = content[there : there + 1], content[at : at + 1]
        yield bytes(changed)


@pytest.mark.parametrize("suffix", ["csv", "parquet", "csv.sweep", "parquet.csv"])
def test_changed_files_are_refused_or_do_no_harm(tmp_path, monkeypatch, suffix):
    """Finished ones, the one beside them, and one that a sweep to Parquet has left: no value is ever another one, no row is lost in the
    middle; at the end a row may pass for one that was not written to its end, and is done again."""
    monkeypatch.setattr(os, "fsync", lambda _: None)  # which takes longer than all else here
    file = tmp_path / ("r.csv" if suffix.startswith("csv") else "r.parquet")
    grid = {"k": range(30)}
    if suffix == "parquet.csv":
        with pytest.raises(KeyboardInterrupt):
            sweep(stopped, grid, to=file)
    right = sweep(told, grid, to=None if suffix == "parquet.csv" else file)
    others = {path: path.read_bytes() for path in tmp_path.iterdir()}
    target = tmp_path / f"r.{suffix}"
    refused = 0
    for changed in edits(others[target], 7, 120):
        for path in tmp_path.iterdir():
            path.unlink()
        for path, content in others.items():
            path.write_bytes(content)
        target.write_bytes(changed)
        done = []

        def counted(k, done=done):
            done.append(k)
            return told(k)

        counted.__qualname__ = "told"
        try:
            found = sweep(counted, grid, to=file)
        except pp.PinpressError:
            refused += 1
        else:
            same(found, right)
            assert set(done) <= {27, 28, 29}
    assert refused > 70


def stopped(k):
    if k == 29:
        raise KeyboardInterrupt
    return told(k)


stopped.__qualname__ = "told"


@pytest.mark.parametrize("damage", [b"\xff", b'"'])
def test_damage_in_the_middle_of_an_unfinished_file_is_told(tmp_path, damage):
    file = tmp_path / "r.csv"
    with pytest.raises(KeyboardInterrupt):
        sweep(stopped, {"k": range(30)}, to=file)
    content = file.read_bytes()
    at = content.index(b"\n5,") + 4
    file.write_bytes(content[:at] + damage + content[at + 1 :])
    with pytest.raises(pp.PinpressError, match=r"r\.csv: row 7|r\.csv: row 8|r\.csv: row 9"):
        sweep(told, {"k": range(30)}, to=file)


def test_an_unfinished_file_most_of_which_is_lost_is_refused(tmp_path):
    """More than a row that was torn can be, though no row after it is whole."""
    file = tmp_path / "r.csv"
    sweep(told, {"k": range(30)}, to=file)
    content = file.read_bytes()
    file.write_bytes(content[: content.index(b"\n5,") + 1] + bytes(300_000))
    with pytest.raises(pp.PinpressError, match=r"r\.csv: row \d+ is damaged"):
        sweep(told, {"k": range(30)}, to=file)


def test_killed_between_the_last_steps(tmp_path):
    """When the Parquet file was written, but the lines beside it, which are those of a CSV, were still there."""
    file, grid = tmp_path / "r.parquet", {"k": range(30)}
    right = sweep(told, grid, to=file)
    sweep(told, grid, to=tmp_path / "r.csv")
    (tmp_path / "r.csv").rename(tmp_path / "r.parquet.csv")
    same(sweep(stopped, grid, to=file), right)
    assert sorted(os.listdir(tmp_path)) == ["r.csv.sweep", "r.parquet", "r.parquet.sweep"]
    same(sweep(stopped, grid, to=file), right)


def test_a_disk_that_fills_up(file):
    """What was finished before is there, and a call with more room does the others."""
    running = file if file.suffix == ".csv" else file.with_name(f"{file.name}.csv")
    done = []

    def counted(k):
        done.append(k)
        return told(k)

    counted.__qualname__ = "told"
    with full_disk(800), pytest.raises(pp.PinpressError, match=f"cannot write {running}: File too large"):
        sweep(counted, {"k": range(30)}, to=file)
    assert running.stat().st_size == 800
    before, done[:] = len(done), []
    same(sweep(counted, {"k": range(30)}, to=file), sweep(told, {"k": range(30)}))
    assert done == list(range(before - 1, 30))


def test_a_sweep_is_kept_in_a_regular_file(tmp_path):
    os.mkfifo(tmp_path / "r.csv")
    with pytest.raises(pp.PinpressError, match="no regular file"):
        sweep(product, GRID, to=tmp_path / "r.csv")


@pytest.mark.parametrize(
    ("function", "grid", "how", "words"),
    [
        (product, {"a": [3, 1], "b": [0.5, 4.0]}, {}, "axis 'a' has 3 values, not 2"),
        (product, {"a": [3, 1, 7], "b": [0.5, 4.0]}, {}, "value 2 of axis 'a' is 2, not 7"),
        (product, {"b": [0.5, 4.0], "a": [3, 1, 2]}, {}, "axes are a, b, not b, a"),
        (lambda a, b: {}, GRID, {}, "function is 'product'"),
        (product, {"a": [3, 1], "b": [0.5, 4.0]}, {"paired": True}, "its axes are those of a full grid"),
    ],
)
def test_another_sweep_is_refused_with_what_differs(file, function, grid, how, words):
    sweep(product, GRID, to=file)
    content = file.read_bytes()
    with pytest.raises(pp.PinpressError, match=words):
        sweep(function, grid, to=file, **how)
    assert file.read_bytes() == content


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"function": 3}, "function is 3"),
        ({"grid": {}}, "grid: give a mapping"),
        ({"grid": {"a": [1], "c": [2]}}, "does not take the axes a, c"),
        ({"grid": {"a": [1]}}, "missing a required argument: 'b'"),
        ({"grid": {"a": [], "b": [1]}}, "axis 'a' has no values"),
        ({"grid": {"a": [np.inf], "b": [1]}}, "not finite"),
        ({"grid": {"a": [1, 1.0], "b": [1]}}, "twice"),
        ({"grid": {"a": [[1]], "b": [1]}}, "objects under labels"),
        ({"grid": {"a": "xyz", "b": [1]}}, "give a sequence"),
        ({"grid": {"a": np.ones((2, 2)), "b": [1]}}, "give a sequence"),
        ({"grid": {"error": [1]}}, "cannot be an axis"),
        ({"grid": {"a": [1, 2], "b": [1]}, "paired": True}, "equally long"),
        ({"to": "results.txt"}, "ends with .csv or .parquet"),
        ({"to": "no/such/folder/r.csv"}, "No such file or directory"),
        ({"to": 5}, "cannot write 5"),
        ({"executor": 4}, "executor is 4"),
        ({"in_flight": 0}, "in_flight is 0"),
        ({"progress": 1}, "progress is 1"),
    ],
)
def test_bad_arguments(arguments, words):
    with pytest.raises(pp.PinpressError, match=words):
        sweep(**{"function": product, "grid": GRID, **arguments})


def test_a_result_named_as_an_axis():
    with pytest.raises(pp.PinpressError, match="the name of an axis"):
        sweep(lambda a: {"a": a}, {"a": [1]})


def test_progress():
    shares = []
    sweep(product, GRID, progress=shares.append)
    assert shares == pytest.approx(np.arange(1, 7) / 6)


def test_processes(file):
    grid = {"a": range(40), "b": range(25)}
    with ProcessPoolExecutor(2) as pool:
        same(sweep(product, grid, to=file, executor=pool), sweep(product, grid))
        for function, inner in ((lambda a, b: {}, grid), (product, {"a": {"lock": threading.Lock()}, "b": [1]})):
            with pytest.raises(pp.PinpressError, match="cannot be sent to other processes"):
                sweep(function, inner, executor=pool)


@pytest.mark.parametrize("how", ["exit", "kill", "crash"])
def test_a_point_that_kills_its_worker_has_failed(file, how):
    """Of many points in a task as of few; the points that were in hand with it are done, and each is called again once at most."""
    log = file.with_name("log")
    with ProcessPoolExecutor(2) as pool:
        found = sweep(partial(dies, at=(20, 200, 201), how=how, log=str(log)), {"a": range(300)}, to=file, executor=pool, in_flight=4)
    assert [bad.number for bad in found.failed] == [20, 200, 201]
    assert "ends the process that it runs in" in found.failed[0].error
    good = [a for a in range(300) if a not in (20, 200, 201)]
    assert np.ma.compressed(found.columns["twice"]).tolist() == [2 * a for a in good]
    called = Counter(log.read_text().split())
    assert max(called[str(a)] for a in (20, 200, 201)) <= 3
    again = sweep(partial(dies, at=(), how=how, log=str(log)), {"a": range(300)}, to=file)
    assert again.failed == found.failed
    same(
        sweep(partial(dies, at=(), how=how, log=os.devnull), {"a": range(300)}, to=file, retry_failed=True),
        sweep(doubled, {"a": range(300)}),
    )


def test_no_process_can_be_started(tmp_path):
    """That is not the points' fault: none of them has failed."""
    file = tmp_path / "r.csv"
    with ProcessPoolExecutor(2, initializer=os._exit, initargs=(1,)) as pool, pytest.raises(pp.PinpressError, match="with a new executor"):
        sweep(doubled, {"a": range(30)}, to=file, executor=pool)
    assert not file.exists() or len(rows(file)) <= 1


def test_a_cluster_gives_up_a_point_that_kills_its_workers():
    """As Dask does, by an exception of the task."""

    class KilledWorker(Exception):  # noqa: N818  its name there
        pass

    class Cluster(ThreadPoolExecutor):
        def submit(self, function, /, *arguments, **_):
            return super().submit(refuse if any(number == 7 for number, _ in arguments[1]) else function, *arguments)

    def refuse(*_):
        raise KilledWorker

    with Cluster(2) as pool:
        found = sweep(doubled, {"a": range(50)}, executor=pool, in_flight=2)
    assert [bad.number for bad in found.failed] == [7]


class SilentError(Exception):
    def __str__(self):
        raise RuntimeError


class LocalError(Exception):
    def __reduce__(self):
        raise TypeError("not to be pickled")


@pytest.mark.parametrize(
    "error", [SystemExit(3), GeneratorExit(), SilentError(), LocalError("x"), MemoryError()], ids=lambda e: type(e).__name__
)
@pytest.mark.parametrize("processes", [False, True])
def test_whatever_a_function_raises_the_sweep_goes_on(error, processes):
    with ProcessPoolExecutor(1) if processes else nullcontext() as pool:
        found = sweep(partial(raises_at_1, error=type(error)), {"a": [0, 1, 2]}, executor=pool)
    assert [bad.number for bad in found.failed] == [1]
    assert found.failed[0].error.startswith(f"{type(error).__name__}: ")
    assert found.columns["twice"].tolist() == [0, None, 4]


def test_few_points_are_in_flight_and_the_executor_stays_open():
    most, running, guard = 0, 0, threading.Lock()

    class Counting(ThreadPoolExecutor):
        def submit(self, *arguments, **named):
            nonlocal most, running
            with guard:
                running += 1
                most = max(most, running)
            future = super().submit(*arguments)
            future.add_done_callback(lambda _: finished())
            return future

    def finished():
        nonlocal running
        with guard:
            running -= 1

    with Counting(2) as pool:
        found = sweep(lambda a: {"x": a}, {"a": range(5000)}, executor=pool, in_flight=3)
        assert pool.submit(int, 3).result() == 3
    assert found.columns["x"].tolist() == list(range(5000))
    assert most <= 3


def test_a_task_that_takes_longer_than_expected_hands_points_back():
    """After a thousand fast points those of 60 ms do not come by the hundreds: a task ends within a fifth of a second and one point."""
    begun = []

    def slow_at_the_end(a):
        if a >= 1000:
            begun.append(a)
            threading.Event().wait(0.06)
        return {"x": a}

    shares = []
    with ThreadPoolExecutor(1) as pool:
        found = sweep(
            slow_at_the_end, {"a": range(1010)}, executor=pool, in_flight=1, progress=lambda share: shares.append((share, len(begun)))
        )
    assert begun == list(range(1000, 1010))
    assert found.columns["x"].tolist() == list(range(1010))
    assert np.diff([count for _, count in shares]).max() <= 4


def test_ctrl_c_in_a_worker_stops_the_sweep(file):
    with ProcessPoolExecutor(1) as pool, pytest.raises(KeyboardInterrupt):
        sweep(partial(raises_at_1, error=KeyboardInterrupt), {"a": [0, 1, 2]}, to=file, executor=pool)
    assert sweep(partial(raises_at_1, error=ValueError), {"a": [0, 1, 2]}, to=file).columns["twice"].tolist() == [0, None, 4]


def test_interrupted_and_resumed(file):
    def interrupted(a):
        if a == 3 and not resumed:
            raise KeyboardInterrupt
        done.append(a)
        return {"x": a}

    done, resumed = [], False
    with pytest.raises(KeyboardInterrupt):
        sweep(interrupted, {"a": range(6)}, to=file)
    resumed = True
    assert sweep(interrupted, {"a": range(6)}, to=file).columns["x"].tolist() == done == list(range(6))


def test_one_at_a_time(tmp_path):
    """Refused in this process and from another one, which a kill releases."""
    file, log = tmp_path / "r.csv", tmp_path / "log"
    held = []

    def again(a):
        with pytest.raises(pp.PinpressError, match="another sweep of this process"):
            sweep(product, GRID, to=file)
        held.append(a)
        return {"x": a}

    sweep(again, {"a": [1]}, to=file)
    assert held == [1]
    other = tmp_path / "other.csv"
    words = (
        "from functools import partial; from support.sweep_points import logged; from pinpress.sweeps.sweeping import sweep;"
        f" sweep(partial(logged, log={str(log)!r}, pause=30), {{'a': [1]}}, to={str(other)!r})"
    )
    holder = subprocess.Popen([sys.executable, "-c", words], cwd=Path(__file__).parents[1])
    try:
        with within(20):
            while not log.exists():
                pass
        with pytest.raises(pp.PinpressError, match=f"another sweep \\(process {holder.pid}\\)"):
            sweep(partial(logged, log=str(log), pause=0), {"a": [1]}, to=other)
    finally:
        holder.send_signal(signal.SIGKILL)
        holder.wait()
    assert sweep(partial(logged, log=str(log), pause=0), {"a": [1]}, to=other).columns["twice"].tolist() == [2]
    assert json.loads((tmp_path / "other.csv.sweep").read_text())["function"] == "logged"
    assert not (tmp_path / "other.csv.lock").exists()
