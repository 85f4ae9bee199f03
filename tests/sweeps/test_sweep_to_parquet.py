"""Large sweeps into a folder of Parquet files, in one process and with local ones: equal to small ones, resumed, with all that may fail."""

import itertools
import json
import os
import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.exploring import examples
from support.full_disk import full_disk
from support.sweep_points import dies, dies_at_once, fails_at_odd, hypotenuse, product, told

import pinpress as pp
from pinpress.sweeps import execution, sweep, sweep_to_parquet

pyarrow = pytest.importorskip("pyarrow")
pytest.importorskip("pyarrow.parquet")

pytestmark = pytest.mark.usefixtures("time_limit")

GRID = {"a": [3, 1, 2], "b": np.array([0.5, 4.0])}


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "runs"


def contents(folder):
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def same(large, table):
    """A large sweep has the columns of a small one, bit by bit; its numbers are floats."""
    columns = large.columns()
    assert columns.pop("point").tolist() == list(range(large.points))
    expected = table.columns()
    assert list(columns) == list(expected)
    for name, column in expected.items():
        got = columns[name]
        assert (got if isinstance(got, list) else got.tolist()) == (column if isinstance(column, list) else column.tolist())
    assert large.failed == len(table.failed)


@pytest.mark.parametrize("points_a_part", [1, 4, 6, 1000])
def test_as_a_small_sweep(folder, points_a_part):
    shares = []
    large = sweep_to_parquet(product, GRID, to=folder, points_a_part=points_a_part, progress=shares.append)
    same(large, sweep(product, GRID))
    assert shares[-1] == 1
    assert len(shares) == large.parts == -(-6 // points_a_part)


@examples(24)
@given(
    lengths=st.lists(st.integers(1, 5), min_size=1, max_size=3),
    points_a_part=st.integers(1, 30),
    at_once=st.booleans(),
    bad=st.sets(st.integers(0, 60)),
)
def test_any_division_has_the_points_of_the_grid(tmp_path_factory, lengths, points_a_part, at_once, bad):
    grid = {f"x{k}": range(10 * k, 10 * k + length) for k, length in enumerate(lengths)}

    def total(**x):
        return {"sum": sum(x.values())} if sum(x.values()) not in bad else pytest.fail(str(sum(x.values())))

    def totals(**x):
        found = sum(x.values())
        if len(hit := sorted(bad.intersection(found.tolist()))):
            pytest.fail(str(hit[0]))
        return {"sum": found}

    folder = tmp_path_factory.mktemp("sweep")
    same(
        sweep_to_parquet(totals if at_once else total, grid, to=folder, points_a_part=points_a_part, at_once=at_once),
        sweep(total, grid),
    )


def test_paired_axes_and_objects(folder, tmp_path):
    columns = {"a": [1, 1, 5], "b": [2, 2, 7]}
    same(sweep_to_parquet(product, columns, to=folder, paired=True, points_a_part=2), sweep(product, columns, paired=True))
    springs = {"none": [], "two": [1.0, 2.0]}
    grid = {"spring": springs, "x": [1, 2, 3]}

    def energy(spring, x):
        return {"energy": sum(spring) * x**2}

    def energies(spring, x):
        assert isinstance(x, np.ndarray)
        return {"energy": [sum(each) * place**2 for each, place in zip(spring, x, strict=True)]}

    for k, function in enumerate((energy, energies)):
        same(sweep_to_parquet(function, grid, to=tmp_path / str(k), points_a_part=4, at_once=bool(k)), sweep(energy, grid))


def test_processes_write_the_same_bytes(folder, tmp_path):
    grid = {"a": np.linspace(0, 1, 40), "b": np.linspace(0, 2, 25)}
    one = sweep_to_parquet(hypotenuse, grid, to=folder, points_a_part=90, at_once=True)
    with ProcessPoolExecutor(2) as pool:
        two = sweep_to_parquet(hypotenuse, grid, to=tmp_path / "two", points_a_part=90, at_once=True, executor=pool)
    assert contents(folder) == contents(tmp_path / "two")
    assert str(one).splitlines()[1:] == str(two).splitlines()[1:]
    a, b = np.meshgrid(*grid.values(), indexing="ij")
    assert two.columns()["c"].tobytes() == np.hypot(a, b).tobytes()


def test_interrupted_and_resumed(folder, tmp_path):
    """What was finished can be read by others, and is not done again; the whole is as if nothing had been."""
    whole = sweep_to_parquet(told, {"k": range(60)}, to=tmp_path / "whole", points_a_part=8)
    done = []

    def counted(k):
        done.append(k)
        return told(k)

    def stop(share):
        if share > 0.5:
            raise KeyboardInterrupt

    counted.__qualname__ = "told"
    with pytest.raises(KeyboardInterrupt):
        sweep_to_parquet(counted, {"k": range(60)}, to=folder, points_a_part=8, progress=stop)
    assert len(done) == 32
    assert len(pytest.importorskip("pandas").read_parquet(folder)) == 32
    shares = []
    again = sweep_to_parquet(counted, {"k": range(60)}, to=folder, points_a_part=8, progress=shares.append)
    assert done == list(range(60))
    assert shares == pytest.approx([40 / 60, 48 / 60, 56 / 60, 1])
    assert contents(folder) == contents(tmp_path / "whole")
    assert (again.failed, again.points) == (whole.failed, whole.points) == (12, 60)
    sweep_to_parquet(counted, {"k": range(60)}, to=folder, points_a_part=8)
    (folder / "part-000002.parquet").unlink()
    with pytest.raises(pp.PinpressError, match="has 7 parts, not 8: call the sweep again"):
        again.columns()
    sweep_to_parquet(counted, {"k": range(60)}, to=folder, points_a_part=8)
    assert done == [*range(60), *range(16, 24)]
    assert contents(folder) == contents(tmp_path / "whole")


def test_parts_without_a_good_point_have_all_columns(folder):
    """They come first here, when nobody knows yet what the results are; after a stop too, and where a part comes back from a folder."""

    def late(k):
        if k < 7:
            raise ValueError(f"{k} is too early")
        return {"x": float(k), "word": "late", "good": True}

    stopped = itertools.count()

    def stop(_):
        if next(stopped) == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep_to_parquet(late, {"k": range(10)}, to=folder, points_a_part=2, progress=stop)
    found = sweep_to_parquet(late, {"k": range(10)}, to=folder, points_a_part=2)
    schemas = {str(pyarrow.parquet.read_schema(file)).split("-- schema metadata")[0] for file in folder.glob("*.parquet")}
    assert len(schemas) == 1
    same(found, sweep(late, {"k": range(10)}))
    never = folder.with_name("never")
    found = sweep_to_parquet(fails_at_odd, {"a": [1, 3, 5]}, to=never, points_a_part=1)
    assert (found.failed, found.results) == (3, ())
    assert found.columns()["a"].tolist() == [1, 3, 5]
    (never / "part-000001.parquet").unlink()

    def fails_no_more(a):
        return {"half": a / 2}

    fails_no_more.__qualname__ = "fails_at_odd"
    mended = sweep_to_parquet(fails_no_more, {"a": [1, 3, 5]}, to=never, points_a_part=1)
    assert mended.columns()["half"].tolist() == [None, 1.5, None]
    assert pytest.importorskip("pandas").read_parquet(never)["half"].count() == 1


def test_points_that_fail_at_once_are_found_by_halving(folder):
    calls = []

    def roots(x):
        calls.append(len(x))
        if (x == 77).any():
            raise ValueError("77")
        with np.errstate(invalid="ignore"):
            found = np.sqrt(x.astype(float))
        return {"root": found, "error": ["small" if each == 3 else None for each in x]}

    found = sweep_to_parquet(roots, {"x": range(-1, 199)}, to=folder, points_a_part=100, at_once=True)
    columns = found.columns()
    bad = {number: error for number, error in enumerate(columns["error"]) if error}
    assert bad == {0: "ValueError: the function returned under 'root' nan, which is not finite", 4: "small", 78: "ValueError: 77"}
    good = [k for k in range(200) if k not in bad]
    assert columns["root"][good].tolist() == np.sqrt(np.arange(-1, 199)[good]).tolist()
    assert np.ma.getmaskarray(columns["root"]).sum() == 3
    assert len(calls) <= 2 + 2 * 7


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        (3.0, "returned 3.0; return a mapping of names to a value for each point"),
        ({}, "return a mapping"),
        ({"x": 1.0}, "returned 1.0 under 'x'; return one value for each of the 2 points"),
        ({"x": np.ones(3)}, r"shape \(3,\) under 'x'"),
        ({"x": np.ones((2, 2))}, r"shape \(2, 2\)"),
        ({"x": "ab"}, "return one value for each"),
        ({"x": [1.0, "a"]}, "numbers and words under 'x'; return values of one kind"),
        ({"k": np.ones(2)}, "the name of an axis"),
        ({"point": np.ones(2)}, "name them by a word other than"),
        ({"\ud800": np.ones(2)}, "name them by a word other than"),
        ({"x": np.ones(2), "error": "bad"}, "under 'error'; return for each of the 2 points"),
        ({"error": [None, "bad"]}, "errors alone, though some points have none"),
    ],
)
def test_what_makes_no_table_ends_the_sweep(folder, returned, words):
    with pytest.raises(pp.PinpressError, match=words):
        sweep_to_parquet(lambda k: returned, {"k": [1, 2]}, to=folder, at_once=True)


@pytest.mark.parametrize(
    ("column", "words"),
    [
        (np.array([1.0, np.inf]), "inf, which is not finite"),
        (np.ma.array([1.0, 2.0], mask=[False, True]), "no value, as it is masked"),
        (np.array([1, 2**60]), "too large to be kept exactly"),
        (np.array([1, -(2**63)]), "too large to be kept exactly"),
        ([1.0, None], "a NoneType, no number"),
        (["a", "b\0"], "null character"),
        (np.array(["a", "\ud800"]), "UTF-8"),
    ],
)
def test_values_that_a_table_cannot_hold_have_failed(folder, column, words):
    columns = sweep_to_parquet(lambda k: {"x": column}, {"k": [1, 2]}, to=folder, at_once=True).columns()
    assert columns["error"][0] == ""
    assert words in columns["error"][1]
    assert columns["x"][0] == column[0]


def test_a_function_may_change_what_it_is_given(folder):
    def halved(x):
        x /= 2
        if len(x) > 2:
            raise ValueError
        return {"half": x, "error": ["\ud800\0" if each == 1.0 else None for each in x]}

    columns = sweep_to_parquet(halved, {"x": [1.0, 2.0, 3.0, 4.0]}, to=folder, at_once=True).columns()
    assert columns["x"].tolist() == [1.0, 2.0, 3.0, 4.0]
    assert columns["half"].tolist() == [0.5, None, 1.5, 2.0]
    assert columns["error"][1] == "\\ud800\\0"


def test_other_names_end_the_sweep_and_what_was_done_stays(folder):
    for at_once in (False, True):
        to = folder.with_name(str(at_once))

        def other(k):
            return {"x" if np.max(k) < 4 else "y": k}

        with pytest.raises(pp.PinpressError, match=r"returned y \(number\) in part 2, but x \(number\) in others"):
            sweep_to_parquet(other, {"k": range(8)}, to=to, points_a_part=2, at_once=at_once)
        assert len(list(to.glob("*.parquet"))) == 2
    with pytest.raises(pp.PinpressError, match=r"returned y \(number\) at \{'k': 4\}, but x \(number\) before"):
        sweep_to_parquet(other, {"k": range(8)}, to=folder)


def test_names_may_come_in_any_order(folder):
    def either(k):
        return {"x": k, "y": -k} if (k % 4 < 2) else {"y": -k, "x": k}

    found = sweep_to_parquet(either, {"k": range(8)}, to=folder, points_a_part=2)
    assert found.columns()["y"].tolist() == [-k for k in range(8)]
    assert {tuple(pyarrow.parquet.read_schema(file).names) for file in folder.glob("*.parquet")} == {("point", "k", "x", "y", "error")}


def test_files_that_are_not_as_they_were_are_refused(folder):
    sweep_to_parquet(product, GRID, to=folder, points_a_part=2)
    before, part = contents(folder), folder / "part-000001.parquet"
    other = folder.with_name("other")
    sweep_to_parquet(product, {"a": [3, 1, 2], "b": [0.5, 5.0]}, to=other, points_a_part=2)
    for content, words in (
        (b"", r"part-000001\.parquet is damaged"),
        (before[part.name][:-7], "damaged .*: delete it, and call the sweep again"),
        ((other / part.name).read_bytes(), "is no part of this sweep"),
    ):
        part.write_bytes(content)
        with pytest.raises(pp.PinpressError, match=words):
            sweep_to_parquet(product, GRID, to=folder, points_a_part=2)
    part.write_bytes(before[part.name])
    (folder / "part-000007.parquet").write_bytes(before[part.name])
    with pytest.raises(pp.PinpressError, match=r"part-000007\.parquet is no part of this sweep"):
        sweep_to_parquet(product, GRID, to=folder, points_a_part=2)
    (folder / "part-000007.parquet").unlink()
    found = sweep_to_parquet(product, GRID, to=folder, points_a_part=2)
    group = pyarrow.parquet.read_metadata(part).row_group(0)
    for k in range(group.num_columns):
        changed = bytearray(before[part.name])
        column = group.column(k)
        start = column.dictionary_page_offset if column.has_dictionary_page else column.data_page_offset
        changed[start + column.total_compressed_size - 1] ^= 1
        part.write_bytes(changed)
        with pytest.raises(pp.PinpressError, match=r"part-000001\.parquet is damaged"):
            found.columns()
    (folder / "_sweep.json").write_text("[]")
    with pytest.raises(pp.PinpressError, match="no description of a sweep"):
        sweep_to_parquet(product, GRID, to=folder, points_a_part=2)
    folder.rename(folder.with_name("elsewhere"))
    with pytest.raises(pp.PinpressError, match="has 0 parts, not 3"):
        found.columns()


@pytest.mark.parametrize(
    ("function", "grid", "how", "words"),
    [
        (product, {"a": [3, 1], "b": [0.5, 4.0]}, {}, "axis 'a' has 3 values, not 2"),
        (lambda a, b: {}, GRID, {}, "function is 'product'"),
        (product, GRID, {"points_a_part": 3}, "its points_a_part is 2, not 3"),
        (product, GRID, {"at_once": True}, "its at_once is False, not True"),
    ],
)
def test_another_sweep_is_refused_with_what_differs(folder, function, grid, how, words):
    sweep_to_parquet(product, GRID, to=folder, points_a_part=2)
    before = contents(folder)
    with pytest.raises(pp.PinpressError, match=words):
        sweep_to_parquet(function, grid, to=folder, **{"points_a_part": 2, **how})
    assert contents(folder) == before


def test_long_axes_are_described_by_a_checksum(folder):
    columns = {"k": np.arange(20_000)}
    sweep_to_parquet(lambda k: {"x": k}, columns, to=folder, paired=True, points_a_part=10_000, at_once=True)
    assert "20000 labels with the checksum" in json.loads((folder / "_sweep.json").read_text())["axes"]["k"][0]
    columns["k"][7] = -1
    with pytest.raises(pp.PinpressError, match="labels with the checksum"):
        sweep_to_parquet(lambda k: {"x": k}, columns, to=folder, paired=True, points_a_part=10_000, at_once=True)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"function": 3}, "function is 3"),
        ({"grid": {"a": [1, "x"], "b": [1]}}, "labels of axis 'a' are of several kinds"),
        ({"grid": {"a": [1]}}, "missing a required argument: 'b'"),
        ({"points_a_part": 0}, "points_a_part is 0"),
        ({"function": lambda **x: {"y": 1}, "grid": {"\ud800": [1]}}, "cannot have the name"),
        ({"at_once": 1}, "at_once is 1"),
        ({"to": 5}, "to is 5"),
        ({"to": "/proc/none/here"}, "cannot write /proc/none/here: No such file"),
        ({"to": __file__}, "cannot write"),
        ({"to": "runs.sqlite"}, "runs.sqlite is the name of a file, but this sweep is written to a folder"),
        ({"to": Path(__file__).parent}, "has other files in it, such as "),
        ({"executor": 4}, "executor is 4"),
        ({"in_flight": 0}, "in_flight is 0"),
        ({"progress": 1}, "progress is 1"),
    ],
)
def test_bad_arguments(folder, arguments, words):
    with pytest.raises(pp.PinpressError, match=words):
        sweep_to_parquet(**{"function": product, "grid": GRID, "to": folder, **arguments})


def test_a_disk_that_fills_up(folder):
    sweep_to_parquet(told, {"k": range(4)}, to=folder.with_name("whole"), points_a_part=2)
    with full_disk(2000), pytest.raises(pp.PinpressError, match=r"cannot write .*part-000000"):
        sweep_to_parquet(told, {"k": range(4)}, to=folder, points_a_part=2)
    sweep_to_parquet(told, {"k": range(4)}, to=folder, points_a_part=2)
    assert contents(folder) == contents(folder.with_name("whole"))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("at_once", [True, False])
def test_a_point_that_kills_its_worker_has_failed(folder, tmp_path, at_once):
    """The others of its part are done, those of other parts as they would be without it."""
    function = dies_at_once if at_once else dies
    how = {"how": "kill", "log": str(tmp_path / "log")}
    with ProcessPoolExecutor(2) as pool:
        found = sweep_to_parquet(
            partial(function, at=(20, 70), **how),
            {"a": range(100)},
            to=folder,
            points_a_part=8,
            at_once=at_once,
            executor=pool,
            in_flight=4,
        )
    errors = found.columns()["error"]
    assert [k for k, error in enumerate(errors) if error] == [20, 70]
    assert "ends the process that it runs in" in errors[20]
    whole = sweep_to_parquet(
        partial(function, at=(), **how), {"a": range(100)}, to=tmp_path / "whole", points_a_part=8, at_once=at_once
    ).columns()
    twice = found.columns()["twice"]
    assert np.ma.compressed(twice).tolist() == np.delete(whole["twice"], [20, 70]).tolist()
    differing = [name for name, content in contents(folder).items() if content != (tmp_path / "whole" / name).read_bytes()]
    assert sorted(differing) == ["part-000002.parquet", "part-000008.parquet"]


def test_an_executor_that_is_gone(folder):
    with ThreadPoolExecutor(1) as pool:
        pass
    with pytest.raises(pp.PinpressError, match=r"could not do its work .* after 0 of 6 points, which are in .*; call the same sweep again"):
        sweep_to_parquet(product, GRID, to=folder, executor=pool)
    same(sweep_to_parquet(product, GRID, to=folder), sweep(product, GRID))
    with ProcessPoolExecutor(1) as other, pytest.raises(pp.PinpressError, match="cannot be sent to other processes"):
        sweep_to_parquet(lambda a, b: {}, GRID, to=folder.with_name("other"), executor=other)


def test_other_programs_read_the_folder(folder):
    pandas, duckdb = pytest.importorskip("pandas"), pytest.importorskip("duckdb")
    found = sweep_to_parquet(told, {"k": range(20)}, to=folder, points_a_part=7)
    rows = found.to_frame()
    pandas.testing.assert_frame_equal(pandas.read_parquet(folder), rows, check_dtype=False)
    by_duckdb = duckdb.sql(f"SELECT count(*), count(number), sum(whole), count(nullif(error, '')) FROM '{folder}/*.parquet'").fetchall()
    assert by_duckdb == [(20, 16, rows["whole"].sum(), 4)]


@pytest.mark.exhaustive
def test_memory_does_not_grow_with_the_points(tmp_path, monkeypatch):
    """A million points take the memory of the parts under way, a thirtieth of what their table takes.

    Tasks have one part each here: else a task has as many as take a tenth of a second, more on a faster machine.
    """
    monkeypatch.setattr(execution, "TASK", 0.0)

    def peak(points):
        grid = {"a": np.arange(points // 1000), "b": np.arange(1000)}
        tracemalloc.start()
        with ThreadPoolExecutor(2) as pool:
            sweep_to_parquet(hypotenuse, grid, to=tmp_path / f"{points}", at_once=True, executor=pool, in_flight=8)
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert len(os.listdir(tmp_path / f"{points}")) == points // 1000 + 1
        return found

    peak(1000)  # it imports pyarrow, which takes more than all points
    some, all_points = peak(100_000), peak(1_000_000)
    assert all_points < 1e6 * 8 * 4 / 30
    assert all_points < 2 * some
