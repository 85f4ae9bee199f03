"""Mass and stiffness matrices of finite-element models: NumPy archives, files in the Matrix Market format, and what a caller hands over."""

from __future__ import annotations

import io
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import files
from ..arguments import numbers
from ..errors import PinpressError
from ..quantities import Array

MOST_BYTES = 200_000_000  # of a file of matrices
MARKET = (".mtx", ".mtx.gz", ".mtx.bz2")  # endings of files in the Matrix Market format
ASYMMETRY = 1e-6  # share of the largest entry by which the halves of a matrix may differ
NEGATIVE = 1e-6  # share of a mass by which rounding in a file may make that of a motion negative
DENSE = 6000  # rows from which on matrices stay sparse
MASSLESS = 1e-12  # share of the square of the longest period below which a vibration has no mass


def symmetric_matrix(what: str, given: Any, most: int) -> Array:
    """A caller's matrix, dense or sparse, as a symmetric array (n, n).

    Raises:
        PinpressError: it is no square, symmetric matrix of finite numbers, or has more than ``most`` rows.
    """
    if hasattr(given, "toarray"):  # of SciPy, sparse
        if max(given.shape) > most:
            raise PinpressError(f"{what} has shape {given.shape}: at most {most} rows; condense the model where it was made")
        given = given.toarray()
    found = numbers(what, given, (None, None))
    if found.shape[0] != found.shape[1] or not 0 < len(found) <= most:
        raise PinpressError(f"{what} has shape {found.shape}: give a square matrix of at most {most} rows")
    if np.abs(found - found.T).max() > ASYMMETRY * np.abs(found).max():
        raise PinpressError(f"{what} is not symmetric: give the whole matrix, both of its halves")
    return np.asarray(0.5 * (found + found.T))


def large_matrix(what: str, given: Any, most: int) -> Any:
    """A caller's sparse matrix as a symmetric one of SciPy in columns (n, n), or as an array where it is small or dense.

    Raises:
        PinpressError: as `symmetric_matrix`.
    """
    if not hasattr(given, "toarray") or max(given.shape) <= DENSE:
        return symmetric_matrix(what, given, DENSE)
    from scipy.sparse import csc_array  # SciPy takes its time to load

    rows, columns = given.shape
    if rows != columns or rows > most:
        raise PinpressError(f"{what} has shape {given.shape}: give a square matrix of at most {most} rows; condense a larger model")
    found = csc_array(given)
    if found.dtype.kind not in "iuf" or not np.isfinite(found.data).all():
        raise PinpressError(f"{what} has entries that are no finite numbers")
    found = found.astype(float)
    if np.abs((found - found.T).data).max(initial=0.0) > ASYMMETRY * np.abs(found.data).max(initial=0.0):
        raise PinpressError(f"{what} is not symmetric: give the whole matrix, both of its halves")
    return csc_array(0.5 * (found + found.T))


def refuse_negative_mass(what: str, mass: Any) -> None:
    """Raise PinpressError if a motion has a negative mass, of a symmetric matrix (n, n), dense or sparse.

    Rows may have no mass, as turns and master nodes have none if masses are lumped. Of a sparse matrix the motions of one row, and of
    two against each other, are looked at: to factor it would take as long as to reduce it.
    """
    own = mass.diagonal()
    scale = 1 / np.sqrt(np.where(own > 0, own, 1.0))
    try:
        if own.min() < 0:
            raise np.linalg.LinAlgError
        if isinstance(mass, np.ndarray):
            if mass[own == 0].any():
                raise np.linalg.LinAlgError
            np.linalg.cholesky(scale[:, None] * mass * scale + NEGATIVE * np.eye(len(mass)))
        else:
            entries = mass.tocoo()
            if (np.abs(entries.data) > (1 + NEGATIVE) * np.sqrt(own[entries.row] * own[entries.col])).any():
                raise np.linalg.LinAlgError
    except np.linalg.LinAlgError:
        raise PinpressError(f"{what} is not positive semidefinite: some motion would have a negative mass; give it as assembled") from None


def craig_bampton(mass: Any, stiffness: Any, outer: NDArray[np.intp], count: int) -> Array:
    """(n, c + k) motions of all rows of a model: each of c rows moved by itself, then k vibrations with these held; see `held_motions`."""
    inner = np.setdiff1d(np.arange(stiffness.shape[0]), outer)
    within, across = np.ix_(inner, inner), np.ix_(inner, outer)
    follow, vibrations = held_motions(mass[within], stiffness[within], stiffness[across], count)
    basis = np.zeros((stiffness.shape[0], len(outer) + vibrations.shape[1]))
    basis[outer, np.arange(len(outer))] = 1.0
    basis[inner] = np.hstack([follow, vibrations])
    return basis


def held_motions(mass: Any, stiffness: Any, across: Any, count: int) -> tuple[Array, Array]:
    """How the rows of a model follow those that are held, and how they vibrate where these stand still (Craig and Bampton).

    Rows without mass follow the others as in statics, and have no vibrations of their own.

    Args:
        mass: (n, n) mass matrix of the rows, dense or sparse.
        stiffness: (n, n) their stiffness matrix, likewise.
        across: (n, c) stiffness between them and the rows that are held, likewise.
        count: number of vibrations.

    Returns:
        (n, c) motions as one after another of the held rows is moved by 1; (n, k) shapes of the lowest vibrations, the lowest first, where
        k is ``count`` or the number of those that there are.

    Raises:
        numpy.linalg.LinAlgError: the stiffness matrix is not positive definite.
        PinpressError: the vibrations of a sparse model do not converge.
    """
    n = stiffness.shape[0]
    if not n:
        return np.zeros(across.shape), np.zeros((0, 0))
    if isinstance(stiffness, np.ndarray):
        from scipy.linalg import cho_factor, cho_solve, eigh  # SciPy takes its time to load

        follow = -cho_solve(cho_factor(stiffness), across)
        if not count:
            return follow, np.zeros((n, 0))
        squared, shapes = eigh(mass, stiffness, subset_by_index=[max(0, n - count), n - 1])  # squares of 1 / frequency, rising
        return follow, np.asarray(shapes[:, squared > MASSLESS * squared[-1]][:, ::-1])
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh, splu  # as above

    try:  # without pivoting the factors are those of Cholesky, and their pivots positive
        factors = splu(stiffness, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:  # exactly singular
        raise np.linalg.LinAlgError from error
    if not (factors.U.diagonal() > 0).all():
        raise np.linalg.LinAlgError
    follow = -factors.solve(across.toarray())
    if not count:
        return follow, np.zeros((n, 0))
    inverse = LinearOperator((n, n), matvec=factors.solve, dtype=float)
    # any vector that has a share of all shapes and none of the motions without mass
    start = factors.solve(mass @ np.random.default_rng(0).standard_normal(n))
    try:
        squared, shapes = eigsh(stiffness, count, mass, sigma=0.0, which="LM", OPinv=inverse, v0=start)
        while True:  # of vibrations of equal frequency Lanczos' method may pass over one: it is looked for across those that are known

            def across_known(vector: Array, known: Array = shapes) -> Array:
                rest = factors.solve(vector)
                return np.asarray(rest - known @ (known.T @ (mass @ rest)))

            rest = LinearOperator((n, n), matvec=across_known, dtype=float)
            missed, shape = eigsh(stiffness, 1, mass, sigma=0.0, which="LM", OPinv=rest, v0=across_known(mass @ start))
            if not missed[0] < squared.max() * (1 - 1e-9):  # one of the same frequency serves as well
                break
            keep = np.argsort(squared)[:-1]
            squared, shapes = np.append(squared[keep], missed), np.column_stack([shapes[:, keep], shape])
    except ArpackError as error:
        raise PinpressError(f"the {count} lowest vibrations of the held model do not converge: give fewer modes") from error
    order = np.argsort(squared)
    return follow, np.asarray(factors.solve(mass @ shapes[:, order]) * squared[order])  # again, for the rows without mass


def read_archive(path: str, wanted: tuple[str, ...]) -> dict[str, Any]:
    """Arrays of a file of `numpy.savez`.

    Raises:
        PinpressError: it is no such file, or one of the wanted arrays is not in it.
    """
    how = f"numpy.savez(file, {', '.join(f'{name}=' for name in wanted)})"
    try:
        with np.load(io.BytesIO(files.read(path, MOST_BYTES)), allow_pickle=False) as archive:
            if not hasattr(archive, "files"):
                raise ValueError
            arrays = {name: archive[name] for name in archive.files}
    except OSError as error:
        raise PinpressError(f"{path} cannot be read: {files.reason(error)}") from error
    except (ValueError, EOFError, KeyError, AttributeError, TypeError) as error:
        raise PinpressError(f"{path} is no file of arrays: write it with {how}") from error
    if missing := [name for name in wanted if name not in arrays]:
        raise PinpressError(f"{path} lacks {', '.join(missing)}: write {how}")
    return arrays


def is_market(path: str) -> bool:
    """Whether a file is one in the Matrix Market format, by its name, perhaps compressed."""
    return path.lower().endswith(MARKET)


def read_market(path: str) -> Any:
    """The matrix of a file in the Matrix Market format, dense or sparse, perhaps compressed by gzip or bzip2.

    Raises:
        PinpressError: it is no such file.
    """
    from scipy.io import mmread  # SciPy takes its time to load

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of the kind of sparse matrix, which does not matter here
            return mmread(io.BytesIO(files.uncompressed(path, files.read(path, MOST_BYTES), MOST_BYTES)))
    except OSError as error:
        raise PinpressError(f"{path} cannot be read: {files.reason(error)}") from error
    except (ValueError, TypeError, IndexError, OverflowError) as error:
        raise PinpressError(f"{path} is no Matrix Market file: {error}; give the matrix as .mtx, or all arrays in one .npz") from error


def read_model(path: str, stiffness: str | None, nodes: Any, degrees: Any) -> tuple[Any, Any, Any, Any]:
    """Mass and stiffness matrix, nodes and degrees of freedom of a model: all of one archive, or two files of matrices and what is given.

    Raises:
        PinpressError: a file cannot be read or lacks an array, or nodes and degrees are given where the file brings them, or neither.
    """
    wanted = ("mass", "stiffness", "nodes", "degrees")
    if stiffness is None:
        if is_market(path):
            raise PinpressError(f"{path} holds one matrix: give the file of the stiffness matrix too, stiffness=, and nodes= and degrees=")
        arrays = read_archive(path, wanted)
        if nodes is not None or degrees is not None:
            raise PinpressError(f"{path} brings its own nodes and degrees: leave out nodes= and degrees=, or give stiffness= too")
        return arrays["mass"], arrays["stiffness"], arrays["nodes"], arrays["degrees"]
    if nodes is None or degrees is None:
        raise PinpressError(f"{path} holds a matrix alone: give nodes= and degrees= too, which say what its rows are")
    return read_market(path), read_market(stiffness), nodes, degrees
