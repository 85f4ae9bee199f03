"""Products of matrices in one thread."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pinpress.common.products import product

SCRIPT = Path(__file__).parents[1] / "support" / "threads_woken.py"


@pytest.mark.parametrize("complex_rows", [False, True])
@pytest.mark.parametrize("complex_columns", [False, True])
@pytest.mark.parametrize(
    "shape",
    [
        (14, 14, 30_000),
        (14, 14, 5),
        (30_000, 13, 15),
        (1, 9, 40_000),
        (300, 300, 300),
        (1, 300_000, 1),
        (2, 300_000, 1),
        (3, 30_000, 2),
        (2, 0, 7),
        (0, 3, 4),
    ],
)
def test_products_in_pieces(shape, complex_rows, complex_columns):
    rng, (m, k, n) = np.random.default_rng(1), shape
    rows, columns = rng.normal(size=(m, k)), rng.normal(size=(k, n))
    rows, columns = rows + 1j * rows[::-1] if complex_rows else rows, columns - 2j * columns[:, ::-1] if complex_columns else columns
    np.testing.assert_allclose(product(rows, columns), rows @ columns, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(product(columns.T, rows.T), (rows @ columns).T, rtol=1e-12, atol=1e-12)
    if m and k:
        np.testing.assert_allclose(product(rows[0], columns), rows[0] @ columns, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(product(rows, columns[:, 0]), rows @ columns[:, 0], rtol=1e-12, atol=1e-12)


@pytest.mark.exhaustive
@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="threads are counted as Linux does")
def test_threads_of_blas_sleep():
    """What takes the products of this module wakes none of them, though they are there; a large product does."""
    done = subprocess.run(
        [sys.executable, SCRIPT], capture_output=True, text=True, check=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "2"}, timeout=300
    )
    found = {}
    for line in done.stdout.splitlines():
        name, *counts = line.split(",")
        found[name] = tuple(map(int, counts))
    _, most, threads = found.pop("wakes")
    assert len(found) == 6
    assert {name: least for name, (least, *_) in found.items() if least} == {}
    assert most > 0 or not threads  # one core: BLAS has no threads
