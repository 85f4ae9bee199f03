"""Sweeps in one process and with local ones: order, types, files, what fails and what is refused."""

import csv
import os
import pickle
import signal
import sqlite3
import subprocess
import sys
import threading
from collections import Counter
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import closing, nullcontext
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from support.full_disk import full_disk
from support.sweep_points import dies, doubled, fails_at_odd, logged, product, raises_at_1, told
from support.time_limit import within

import pinpress as pp
from pinpress.common.outlets.described import Chart, Map
from pinpress.sweeps.sweeping import sweep

pytestmark = pytest.mark.usefixtures("time_limit")

TESTS = Path(__file__).parents[1]
GRID = {"a": [3, 1, 2], "b": np.array([0.5, 4.0])}


@pytest.fixture
def file(tmp_path):
    return tmp_path / "r.sqlite"


def points(path):
    """What another program reads in the file: (point, error, checksum, results) of every point."""
    with closing(sqlite3.connect(path)) as database:
        return database.execute("SELECT * FROM points ORDER BY point").fetchall()


def rows(path):
    with open(path, newline="") as lines:
        return list(csv.reader(lines))


def same(one, other):
    assert list(one.columns()) == list(other.columns())
    assert one.failed == other.failed
    for name in (*one.axes, *one.results):
        column = one.column(name)
        assert column.dtype == other.column(name).dtype
        np.testing.assert_array_equal(np.ma.getmaskarray(column), np.ma.getmaskarray(other.column(name)))
        assert column.tolist() == other.column(name).tolist()


def test_charts_of_a_grid():
    """A map over the first two axes at the middle of the third, in rising order; a curve over one; nothing where there is no grid."""

    def of_grid(a, b, c=0.0):
        if (a, b) == (3, 4.0):
            raise ValueError(a)
        return {"sum": a + 10 * b + 100 * c, "word": "x"}

    (section,) = sweep(of_grid, GRID | {"c": [5.0, 7.0, 9.0]}).described()
    (drawn,) = (block for block in section.blocks if isinstance(block, Map))
    assert (drawn.title, drawn.up.name, drawn.across.name) == ("sum at c = 7", "a", "b")
    np.testing.assert_array_equal(drawn.values, [[706, 741], [707, 742], [708, np.nan]])
    (section,) = sweep(of_grid, {"a": [3, 1, 2], "b": [0.5]}).described()
    (line,) = (block for block in section.blocks if isinstance(block, Chart))
    assert (line.curves[0].x.tolist(), line.curves[0].y.tolist()) == ([1, 2, 3], [6, 7, 8])
    for axes, paired in (({"a": ["x", "y"]}, False), ({"a": [1, 2], "b": [3, 4]}, True)):
        (section,) = sweep(told_in_words, axes, paired=paired).described()
        assert not any(isinstance(block, Chart | Map) for block in section.blocks)


def told_in_words(a, b=0):
    return {"word": str(a)}


def test_last_axis_is_the_fastest():
    found = sweep(product, GRID)
    assert found.shape == (3, 2)
    assert found.column("a").tolist() == [3, 3, 1, 1, 2, 2]
    assert found.column("b").tolist() == [0.5, 4.0] * 3
    np.testing.assert_array_equal(found.grid("product"), np.outer(GRID["a"], GRID["b"]))
    assert found.column("even").dtype == bool
    assert found.column("which").tolist() == ["a", "b, or, both", "a", "b, or, both", "a", "b, or, both"]
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
    assert found.column("loads").tolist() == ["none", "none", "drawing", "drawing"]
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
    same(pp.sweeps.read(file), alone)
    assert file.read_bytes() == content
    same(first, alone)
    same(second, alone)
    assert os.listdir(tmp_path) == [file.name]
    frame = second.to_frame()
    assert frame["product"].tolist() == alone.column("product").tolist()
    second.to_csv(tmp_path / "table.csv")
    assert [float(row[2]) for row in rows(tmp_path / "table.csv")[1:]] == alone.column("product").tolist()
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
    assert list(found.columns()) == ["a", "error"]
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
    assert sweep(lambda k: {}, {"k": range(len(words))}, to=file).column("word").tolist() == words == found.column("word").tolist()
    found.to_csv(file.with_name("table.csv"))
    assert [row[1] for row in rows(file.with_name("table.csv"))[1:]] == words


def test_names_that_sql_takes_for_one(file):
    """And names of its own columns."""
    names = ["x", "X", "number", "Point", "select", 'say "x"', "Error", "é", "a b"]
    grid = {"k": range(3)}
    found = sweep(lambda k: {name: float(10 * k + j) for j, name in enumerate(names)}, grid, to=file)
    assert [found.column(name)[2] for name in names] == [20.0 + j for j in range(len(names))]
    same(sweep(lambda k: {}, grid, to=file), found)


def test_labels_of_several_kinds(file):
    grid = {"size": {1: 10, "large": 30, 2.5: 20}, "left": [True, False]}
    found = sweep(lambda size, left: {"x": -size if left else size}, grid, to=file)
    assert found.column("size").tolist() == [1, 1, "large", "large", 2.5, 2.5]
    assert found.column("x").tolist() == [-10, 10, -30, 30, -20, 20]
    same(sweep(lambda size, left: {}, grid, to=file), found)


def test_other_names_stop_the_sweep_and_what_was_done_stays(file):
    with pytest.raises(pp.PinpressError, match=r"y \(number\) at \{'a': 2\}, but x \(number\) before"):
        sweep(lambda a: {"x": 1.0} if a < 2 else {"y": 1.0}, {"a": [0, 1, 2]}, to=file)
    assert len(points(file)) == 2


def test_names_may_come_in_any_order(file):
    def either(a):
        return {"x": a, "y": -a} if a % 2 else {"y": -a, "x": a}

    found = sweep(either, {"a": range(4)}, to=file)
    assert found.column("x").tolist() == [0, 1, 2, 3]
    same(sweep(either, {"a": range(4)}, to=file), found)


def test_numbers_come_back_bit_by_bit(file):
    numbers = [0.1 + 0.2, -0.0, 5e-324, 1.7976931348623157e308, 2.0, 2, -(2**53), np.float64(1 / 3), np.float32(0.1), np.int64(7), 1e22]
    found = sweep(lambda k: {"x": numbers[k]}, {"k": range(len(numbers))}, to=file)
    again = sweep(lambda k: {}, {"k": range(len(numbers))}, to=file)
    expected = np.array([float(number) for number in numbers]) + 0.0  # SQLite takes -0.0 for 0.0
    assert again.column("x").tobytes() == found.column("x").tobytes() == expected.tobytes()


def test_a_file_without_points_is_begun(file):
    """As a kill may leave it just after its name was made."""
    file.touch()
    same(sweep(product, GRID, to=file), sweep(product, GRID))


@pytest.mark.parametrize("rest", [1, 99, 1024, 1500, 2500])
def test_a_file_that_is_cut_off(file, rest):
    sweep(product, GRID, to=file)
    file.write_bytes(file.read_bytes()[:-rest])
    for call in (lambda: pp.sweeps.read(file), lambda: sweep(product, GRID, to=file)):
        with pytest.raises(pp.PinpressError, match="is damaged"):
            call()


def test_what_another_program_changes_is_refused(file):
    sweep(product, GRID, to=file)
    content = file.read_bytes()
    for changed, words in (
        ("UPDATE points SET product = 4.5 WHERE point = 3", "point 3 is damaged or was changed"),
        ("UPDATE points SET product = 'four' WHERE point = 3", "point 3 is damaged or was changed"),
        ("UPDATE points SET product = NULL WHERE point = 3", "point 3 is damaged or was changed"),
        ("UPDATE points SET even = NOT even WHERE point = 3", "point 3 is damaged or was changed"),
        ("UPDATE points SET which = 'none' WHERE point = 3", "point 3 is damaged or was changed"),
        ("UPDATE points SET error = 'it failed' WHERE point = 2", "point 2 is damaged or was changed"),
        ("UPDATE points SET point = 99 WHERE point = 2", "point 99 is damaged or was changed"),
        (
            "INSERT INTO points SELECT 7, error, checksum, product, larger, even, which FROM points WHERE point = 1",
            "point 7 is damaged or was changed",
        ),
        ("ALTER TABLE points ADD COLUMN more REAL", "does not have the columns that its description names"),
        ("UPDATE sweep SET description = replace(description, 'larger', 'smaller')", "the checksum of its description does not fit"),
        ("DELETE FROM sweep", "the checksum of its description does not fit"),
        ("CREATE INDEX i ON points(error)", "not have the tables of a sweep"),
        ("DROP TABLE points", "not have the tables of a sweep"),
    ):
        file.write_bytes(content)
        with closing(sqlite3.connect(file)) as database, database:
            database.execute(changed)
        with pytest.raises(pp.PinpressError, match=words):
            sweep(product, GRID, to=file)
        with pytest.raises(pp.PinpressError, match=words):
            pp.sweeps.read(file)


def test_a_point_that_is_deleted_is_done_again(file):
    right, done = sweep(product, GRID, to=file), []
    with closing(sqlite3.connect(file)) as database, database:
        database.execute("DELETE FROM points WHERE point = 3")

    def counted(**point):
        done.append(point)
        return product(**point)

    counted.__qualname__ = "product"
    same(sweep(counted, GRID, to=file), right)
    assert done == [{"a": 1, "b": 4.0}]


@pytest.mark.parametrize("content", [b"a,b\n1,2\n", b"SQLite format 3\0" + bytes(200), bytes(5000)])
def test_other_files_are_refused_and_left_alone(file, content):
    file.write_bytes(content)
    with pytest.raises(pp.PinpressError, match=r"r\.sqlite is damaged, or is not the file of a sweep"):
        sweep(product, GRID, to=file)
    assert file.read_bytes() == content


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


def killed(file, grid):
    """A sweep of `told` whose process is killed at its last point."""
    program = f"""
import os, signal
from support.sweep_points import told
from pinpress.sweeps.sweeping import sweep

def killing(k):
    return told(k) if k < {len(grid["k"]) - 1} else os.kill(os.getpid(), signal.SIGKILL)

killing.__qualname__ = "told"
sweep(killing, {grid!r}, to={str(file)!r})
"""
    assert subprocess.run([sys.executable, "-c", program], cwd=TESTS).returncode == -signal.SIGKILL


def again(file, grid, files):
    """The sweep of `told` once more, from files as they were put there, and the points that it does; None where it is refused."""
    for path in file.parent.iterdir():
        path.unlink()
    for path, content in files.items():
        path.write_bytes(content)
    done = []

    def counted(k):
        done.append(k)
        return told(k)

    counted.__qualname__ = "told"
    try:
        return sweep(counted, grid, to=file), done
    except pp.PinpressError:
        return None, done


@pytest.mark.parametrize(("log", "count"), [(False, 150), (True, 40), pytest.param(True, 150, marks=pytest.mark.exhaustive)])
def test_changed_files_are_refused_or_do_no_harm(file, log, count):
    """A finished file, and the log that a kill has left: no value is ever another one, no point is lost without being done again."""
    grid = {"k": range(30)}
    right = sweep(told, grid, to=None if log else file)
    if log:
        killed(file, grid)
    files = {path: path.read_bytes() for path in file.parent.iterdir()}
    target = file.with_name("r.sqlite-wal") if log else file
    refused = 0
    for changed in edits(files[target], 7, count):
        found, _ = again(file, grid, {**files, target: changed})
        refused += found is None
        if found is not None:
            same(found, right)
    assert refused > 70 or log  # from the log SQLite takes what is whole, and leaves the rest


@pytest.mark.exhaustive
def test_a_log_that_is_torn_loses_its_end_alone(file):
    grid = {"k": range(30)}
    right = sweep(told, grid)
    killed(file, grid)
    files = {path: path.read_bytes() for path in file.parent.iterdir()}
    log = file.with_name("r.sqlite-wal")
    assert again(file, grid, files)[1] == [29]
    left = [29]
    for end in range(100, len(files[log]), 1500):
        found, done = again(file, grid, {**files, log: files[log][:-end]})
        same(found, right)
        assert done == list(range(done[0], 30))
        assert done[0] <= left[0]
        left = done
    assert left[0] < 5


def test_a_disk_that_fills_up(file):
    """What was finished before is there, and a call with more room does the others."""
    done = []

    def counted(k):
        done.append(k)
        return told(k)

    counted.__qualname__ = "told"
    for size in (0, 800, 3000, 8000, 20_000):
        known = len(points(file)) if file.exists() and file.stat().st_size else 0
        done[:] = []
        with full_disk(size), pytest.raises(pp.PinpressError, match=f"cannot write {file}: "):
            sweep(counted, {"k": range(30)}, to=file)
        assert done == list(range(known, known + len(done)))
    before, done[:] = len(points(file)), []
    assert before > 5
    same(sweep(counted, {"k": range(30)}, to=file), sweep(told, {"k": range(30)}))
    assert done == list(range(before, 30))
    assert os.listdir(file.parent) == [file.name]


def test_a_sweep_that_was_stopped_can_be_read(file):
    def stopped(k):
        if k == 12:
            raise KeyboardInterrupt
        return told(k)

    with pytest.raises(KeyboardInterrupt):
        sweep(stopped, {"k": range(30)}, to=file)
    assert os.listdir(file.parent) == [file.name]
    found = pp.sweeps.read(file)
    whole = sweep(told, {"k": range(30)})
    assert found.missing == tuple(range(12, 30))
    assert found.failed == whole.failed[:2]
    assert np.ma.compressed(found.column("word")).tolist() == np.ma.compressed(whole.column("word")[:12]).tolist()
    assert "2 of which failed, 18 are not done" in str(found)
    found.to_csv(file.with_name("table.csv"))
    assert [row[1] for row in rows(file.with_name("table.csv"))[12:15]] == ["1.1", "", ""]


@pytest.mark.parametrize("write", ["to_csv", "to_parquet"])
def test_labels_of_several_kinds_are_exported(tmp_path, write):
    found = sweep(lambda size: {"x": 1.0}, {"size": {1: 10, "large": 30, 2.5: 20}})
    getattr(found, write)(tmp_path / "table")
    if write == "to_csv":
        assert [row[0] for row in rows(tmp_path / "table")] == ["size", "1", "large", "2.5"]
    else:
        assert pytest.importorskip("pandas").read_parquet(tmp_path / "table")["size"].tolist() == ["1", "large", "2.5"]


def test_a_sweep_is_kept_in_a_regular_file(tmp_path):
    os.mkfifo(tmp_path / "r.sqlite")
    with pytest.raises(pp.PinpressError, match="not a regular file"):
        sweep(product, GRID, to=tmp_path / "r.sqlite")


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


@pytest.mark.one_in(3)
@pytest.mark.parametrize("how", ["exit", "kill", "crash"])
def test_a_point_that_kills_its_worker_has_failed(file, how):
    """Of many points in a task as of few; the points that were in hand with it are done, and each is called again once at most."""
    log = file.with_name("log")
    with ProcessPoolExecutor(2) as pool:
        found = sweep(partial(dies, at=(20, 200, 201), how=how, log=str(log)), {"a": range(300)}, to=file, executor=pool, in_flight=4)
    assert [bad.number for bad in found.failed] == [20, 200, 201]
    assert "ends the process that it runs in" in found.failed[0].error
    good = [a for a in range(300) if a not in (20, 200, 201)]
    assert np.ma.compressed(found.column("twice")).tolist() == [2 * a for a in good]
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
    file = tmp_path / "r.sqlite"
    with ProcessPoolExecutor(2, initializer=os._exit, initargs=(1,)) as pool, pytest.raises(pp.PinpressError, match="with a new executor"):
        sweep(doubled, {"a": range(30)}, to=file, executor=pool)
    assert points(file) == []


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


def test_points_beside_one_that_kills_its_workers_do_not_fail():
    """Dask accuses every task that the dying worker held, whichever ran: only one with no other beside it is judged. And it answers a call
    that it has accused before with the same error, at once."""

    class KilledWorker(Exception):  # noqa: N818  its name there
        pass

    class Cluster(Executor):
        def __init__(self):
            self.held, self.accused, self.condemned = [], Counter(), set()

        def submit(self, function, /, *arguments, **_):
            future, numbers, call = Future(), [number for number, _ in arguments[1]], pickle.dumps((function, arguments))
            if call in self.condemned:
                future.set_exception(KilledWorker())
            elif self.held or 7 in numbers:
                self.condemned.add(call)
                self.held.append(future)
                self.accused.update(numbers)
                if 7 in numbers:
                    threading.Timer(0.2, self.kill).start()
            else:
                future.set_result(function(*arguments))
            return future

        def kill(self):
            held, self.held = self.held, []
            for future in held:
                future.set_exception(KilledWorker())

    cluster = Cluster()
    found = sweep(doubled, {"a": range(50)}, executor=cluster, in_flight=4)
    assert [bad.number for bad in found.failed] == [7]
    assert cluster.accused[7] == 3, "in a task of several, alone beside others, with nothing beside it"
    assert max(count for number, count in cluster.accused.items() if number != 7) == 2, "others were accused as it was, twice"
    assert found.column("twice").tolist() == [2 * a if a != 7 else None for a in range(50)]


def test_a_result_is_lost_on_its_way():
    """As Dask loses it when a worker dies while its result is fetched; what can never be carried out ends the sweep all the same."""
    asked = Counter()

    class Cluster(ThreadPoolExecutor):
        def submit(self, function, /, *arguments, **_):
            asked.update(numbers := [number for number, _ in arguments[1]])
            return super().submit(refuse if 7 in numbers and asked[7] <= lost else function, *arguments)

    def refuse(*_):
        raise ValueError("not enough values to unpack (expected 3, got 2)")

    lost = 1
    with Cluster(2) as pool:
        found = sweep(doubled, {"a": range(50)}, executor=pool, in_flight=2)
    assert not found.failed
    assert found.column("twice").tolist() == [2 * a for a in range(50)]
    lost = 10**9
    with Cluster(2) as pool, pytest.raises(pp.PinpressError, match=r"could not do its work \(ValueError: not enough values"):
        sweep(doubled, {"a": range(50)}, executor=pool, in_flight=2)


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
    assert found.column("twice").tolist() == [0, None, 4]


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
    assert found.column("x").tolist() == list(range(5000))
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
    assert found.column("x").tolist() == list(range(1010))
    assert np.diff([count for _, count in shares]).max() <= 4


def test_ctrl_c_in_a_worker_stops_the_sweep(file):
    with ProcessPoolExecutor(1) as pool, pytest.raises(KeyboardInterrupt):
        sweep(partial(raises_at_1, error=KeyboardInterrupt), {"a": [0, 1, 2]}, to=file, executor=pool)
    assert sweep(partial(raises_at_1, error=ValueError), {"a": [0, 1, 2]}, to=file).column("twice").tolist() == [0, None, 4]


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
    assert sweep(interrupted, {"a": range(6)}, to=file).column("x").tolist() == done == list(range(6))


def test_a_file_that_is_written_takes_no_other_sweep(file):
    tried = []

    def again(a):
        for call in (lambda: sweep(product, GRID, to=file), lambda: pp.sweeps.read(file)):
            with pytest.raises(pp.PinpressError, match="in use, by another sweep"):
                call()
        tried.append(a)
        return {"x": a}

    sweep(again, {"a": [1]}, to=file)
    assert tried == [1]


@pytest.mark.exhaustive
def test_one_at_a_time(tmp_path):
    """Refused from another process, which a kill releases."""
    log = tmp_path / "log"
    other = tmp_path / "other.sqlite"
    words = (
        "from functools import partial; from support.sweep_points import logged; from pinpress.sweeps.sweeping import sweep;"
        f" sweep(partial(logged, log={str(log)!r}, pause=30), {{'a': [1]}}, to={str(other)!r})"
    )
    holder = subprocess.Popen([sys.executable, "-c", words], cwd=TESTS)
    try:
        with within(20):
            while not log.exists():
                pass
        with pytest.raises(pp.PinpressError, match="in use, by another sweep"):
            sweep(partial(logged, log=str(log), pause=0), {"a": [1]}, to=other)
        with pytest.raises(pp.PinpressError, match="in use, by another sweep"):
            pp.sweeps.read(other)
    finally:
        holder.send_signal(signal.SIGKILL)
        holder.wait()
    assert sweep(partial(logged, log=str(log), pause=0), {"a": [1]}, to=other).column("twice").tolist() == [2]
    assert sorted(os.listdir(tmp_path)) == ["log", "other.sqlite"]
