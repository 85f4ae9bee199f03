"""Functions of many points at once: equal to those of one point, resumed, with all that may fail; and what is exported of large sweeps."""

import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.exploring import examples
from support.full_disk import full_disk
from support.sweep_points import dies_at_once, hypotenuse, product, told

import pinpress as pp
from pinpress.sweeps import execution
from pinpress.sweeps.sweeping import sweep

pyarrow = pytest.importorskip("pyarrow")
pytest.importorskip("pyarrow.parquet")

pytestmark = pytest.mark.usefixtures("time_limit")

GRID = {"a": [3, 1, 2], "b": np.array([0.5, 4.0])}


@pytest.fixture
def file(tmp_path):
    return tmp_path / "r.sqlite"


def products(a, b):
    """`product` of many points."""
    return {name: [product(*point)[name] for point in zip(a.tolist(), b.tolist(), strict=True)] for name in product(1, 2)}


def same(one, other):
    assert one.failed == other.failed
    columns, expected = one.columns(), other.columns()
    assert list(columns) == list(expected)
    for name, column in expected.items():
        assert (columns[name] if isinstance(column, list) else columns[name].tolist()) == (
            column if isinstance(column, list) else column.tolist()
        )


@pytest.mark.parametrize("at_once", [1, 4, 6, 1000, True])
def test_as_one_by_one(file, at_once):
    shares = []
    same(sweep(products, GRID, to=file, at_once=at_once, progress=shares.append), sweep(product, GRID))
    assert shares[-1] == 1
    assert len(shares) == (1 if at_once is True else -(-6 // at_once))


@examples(24)
@given(
    lengths=st.lists(st.integers(1, 5), min_size=1, max_size=3),
    at_once=st.integers(1, 30),
    bad=st.sets(st.integers(0, 60)),
    done=st.sets(st.integers(0, 124)),
)
def test_any_division_has_the_points_of_the_grid(tmp_path_factory, lengths, at_once, bad, done):
    """Also where some points are in the file already."""
    grid = {f"x{k}": range(10 * k, 10 * k + length) for k, length in enumerate(lengths)}

    def total(**x):
        return {"sum": sum(x.values())} if sum(x.values()) not in bad else pytest.fail(str(sum(x.values())))

    def totals(**x):
        found = sum(x.values())
        if len(hit := sorted(bad.intersection(found.tolist()))):
            pytest.fail(str(hit[0]))
        return {"sum": found}

    totals.__qualname__ = total.__qualname__
    file, calls = tmp_path_factory.mktemp("sweep") / "r.sqlite", []

    def some(**x):
        calls.append(x)
        return total(**x) if len(calls) - 1 in done else pytest.fail("later")

    some.__qualname__ = total.__qualname__
    sweep(some, grid, to=file)
    same(sweep(totals, grid, to=file, at_once=at_once, retry_failed=True), sweep(total, grid))


def test_paired_axes_and_objects():
    columns = {"a": [1, 1, 5], "b": [2, 2, 7]}
    same(sweep(products, columns, paired=True, at_once=2), sweep(product, columns, paired=True))
    springs = {"none": [], "two": [1.0, 2.0]}
    grid = {"spring": springs, "x": [1, 2, 3]}

    def energies(spring, x):
        assert isinstance(x, np.ndarray)
        return {"energy": [sum(each) * place**2 for each, place in zip(spring, x, strict=True)]}

    same(sweep(energies, grid, at_once=4), sweep(lambda spring, x: {"energy": sum(spring) * x**2}, grid))


def test_processes_find_the_same(file):
    grid = {"a": np.linspace(0, 1, 40), "b": np.linspace(0, 2, 25)}
    one = sweep(hypotenuse, grid, at_once=90)
    with ProcessPoolExecutor(2) as pool:
        two = sweep(hypotenuse, grid, to=file, at_once=90, executor=pool)
    assert str(one) == str(two)
    a, b = np.meshgrid(*grid.values(), indexing="ij")
    assert two.column("c").tobytes() == one.column("c").tobytes() == np.hypot(a, b).tobytes()


def test_interrupted_and_resumed(file):
    """What was finished is not done again, and the function is given the same points together."""
    calls = []

    def tenths(k):
        calls.append(k.tolist())
        return {"tenth": 0.1 * k, "error": [f"not {each}" if each % 5 == 3 else None for each in k]}

    def stop(share):
        if share > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(tenths, {"k": range(60)}, to=file, at_once=8, progress=stop)
    assert len(pp.sweeps.read(file).missing) == 28
    shares = []
    again = sweep(tenths, {"k": range(60)}, to=file, at_once=8, progress=shares.append)
    assert calls == [list(range(first, min(first + 8, 60))) for first in range(0, 60, 8)]
    assert shares == pytest.approx([40 / 60, 48 / 60, 56 / 60, 1])
    assert len(again.failed) == 12
    same(again, sweep(tenths, {"k": range(60)}, at_once=True))


def test_points_that_fail_are_found_by_halving():
    calls = []

    def roots(x):
        calls.append(len(x))
        if (x == 77).any():
            raise ValueError("77")
        with np.errstate(invalid="ignore"):
            found = np.sqrt(x.astype(float))
        return {"root": found, "error": ["small" if each == 3 else None for each in x]}

    found = sweep(roots, {"x": range(-1, 199)}, at_once=100)
    bad = {each.number: each.error for each in found.failed}
    assert bad == {0: "ValueError: the function returned under 'root' nan, which is not finite", 4: "small", 78: "ValueError: 77"}
    good = [k for k in range(200) if k not in bad]
    assert found.column("root")[good].tolist() == np.sqrt(np.arange(-1, 199)[good]).tolist()
    assert np.ma.getmaskarray(found.column("root")).sum() == 3
    assert len(calls) <= 2 + 2 * 7


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
def test_values_that_a_table_cannot_hold_have_failed(column, words):
    columns = sweep(lambda k: {"x": column}, {"k": [1, 2]}, at_once=True).columns()
    assert columns["error"][0] == ""
    assert words in columns["error"][1]
    assert columns["x"][0] == column[0]


def test_a_function_may_change_what_it_is_given():
    def halved(x):
        x /= 2
        if len(x) > 2:
            raise ValueError
        return {"half": x, "error": ["\ud800\0" if each == 1.0 else None for each in x]}

    columns = sweep(halved, {"x": [1.0, 2.0, 3.0, 4.0]}, at_once=True).columns()
    assert columns["x"].tolist() == [1.0, 2.0, 3.0, 4.0]
    assert columns["half"].tolist() == [0.5, None, 1.5, 2.0]
    assert columns["error"][1] == "\\ud800\\0"


def test_other_names_end_the_sweep_and_what_was_done_stays(file):
    def other(k):
        return {"x" if np.max(k) < 4 else "y": k}

    with pytest.raises(pp.PinpressError, match=r"returned y \(number\) at \{'k': 4\}, but x \(number\) before"):
        sweep(other, {"k": range(8)}, to=file, at_once=2)
    assert pp.sweeps.read(file).missing == (4, 5, 6, 7)
    halves = lambda k: {"x" if k[0] < 4 else "y": k} if len(k) < 8 else pytest.fail("halve")  # noqa: E731
    with pytest.raises(pp.PinpressError, match=r"returned y \(number\) at some points, but x \(number\) at others"):
        sweep(halves, {"k": range(8)}, at_once=True)


def test_names_may_come_in_any_order(file):
    def either(k):
        return {"x": k, "y": -k} if k[0] % 4 < 2 else {"y": -k, "x": k}

    found = sweep(either, {"k": range(8)}, to=file, at_once=2)
    assert found.column("y").tolist() == [-k for k in range(8)]


def test_a_disk_that_fills_up(file):
    numbers = {"k": range(400)}
    with full_disk(20_000), pytest.raises(pp.PinpressError, match=f"cannot write {file}"):
        sweep(lambda k: {"x": 0.1 * k}, numbers, to=file, at_once=10)
    kept = 400 - len(pp.sweeps.read(file).missing)
    assert 0 < kept < 400
    same(sweep(lambda k: {"x": 0.1 * k}, numbers, to=file, at_once=10), sweep(lambda k: {"x": 0.1 * k}, numbers))


@pytest.mark.parametrize("at_once", [8, 50])
def test_a_point_that_kills_its_worker_has_failed(file, tmp_path, at_once):
    """The others of its part are done."""
    function = partial(dies_at_once, at=(20, 70), how="kill", log=str(tmp_path / "log"))
    with ProcessPoolExecutor(2) as pool:
        found = sweep(function, {"a": range(100)}, to=file, at_once=at_once, executor=pool, in_flight=4)
    assert [bad.number for bad in found.failed] == [20, 70]
    assert "ends the process that it runs in" in found.failed[0].error
    assert np.ma.compressed(found.column("twice")).tolist() == [2 * k for k in range(100) if k not in (20, 70)]


def test_an_executor_that_is_gone(file):
    with ThreadPoolExecutor(1) as pool:
        pass
    with pytest.raises(pp.PinpressError, match=r"could not do its work .* after 0 of 6 points, which are in .*; call the same sweep again"):
        sweep(products, GRID, to=file, at_once=True, executor=pool)
    with ProcessPoolExecutor(1) as other, pytest.raises(pp.PinpressError, match="cannot be sent to other processes"):
        sweep(lambda a, b: {}, GRID, at_once=True, executor=other)


def test_other_programs_read_what_is_exported(file):
    pandas, duckdb = pytest.importorskip("pandas"), pytest.importorskip("duckdb")

    def late(k):
        return told(k) if k > 7 else pytest.fail("too early")

    sweep(late, {"k": range(20)}, to=file)
    found, target = pp.sweeps.read(file), file.with_name("r.parquet")
    found.to_parquet(target)
    rows = found.to_frame()
    pandas.testing.assert_frame_equal(pandas.read_parquet(target), rows, check_dtype=False)
    by_duckdb = duckdb.sql(f"SELECT count(*), count(number), sum(whole), count(nullif(error, '')) FROM '{target}'").fetchall()
    assert by_duckdb == [(20, 9, rows["whole"].sum(), 11)]
    schema = pyarrow.parquet.read_schema(target)
    assert [str(kind) for kind in schema.types] == ["int64", "double", "string", "bool", "double", "string"]


@pytest.mark.exhaustive
def test_memory_grows_by_the_results_alone(monkeypatch, tmp_path):
    """Many points take little more than the arrays of the result.

    Tasks have one part each here: else a task has as many as take a tenth of a second, more on a faster machine.
    """
    monkeypatch.setattr(execution, "TASK", 0.0)

    def peak(points):
        grid = {"a": np.arange(points // 1000), "b": np.arange(1000)}
        tracemalloc.start()
        with ThreadPoolExecutor(2) as pool:
            sweep(hypotenuse, grid, to=tmp_path / f"{points}.sqlite", at_once=True, executor=pool, in_flight=8)
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    few = peak(10_000)
    assert peak(100_000) - few < 100_000 * 8 * 4  # number, a, b, c
