"""What NumPy would take for numbers without a word is refused by the argument's name; numbers of every honest kind pass unchanged."""

from datetime import datetime
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from support import texts

import pinpress as pp
from pinpress.common.arguments import number, numbers, positive, suitable_numbers, whole_number

NESTED: list = []
NESTED.append(NESTED)


class Metres:
    """A number with a unit, in the way of pint and astropy."""

    units = "mm"

    def __array__(self, dtype=None, copy=None):
        return np.array(450.0, dtype=dtype)


ODD = [
    *(None, "", "7", b"7", object(), float, {}, {1.0}, iter([1.0]), True, np.True_, 1 + 2j, np.complex128(3), 10**400, -(10**5000)),
    *(np.ma.masked, np.ma.array([1.0, 2.0], mask=[False, True]), [np.ma.array([1.0], mask=[True])], [1.0, np.ma.masked], [True, 1.0]),
    *(np.array([True]), np.array([1j]), np.array(["1"]), np.array([b"1"]), np.array([np.datetime64("2026-01-01")])),
    *(np.timedelta64(1, "s"), datetime(2026, 1, 1), [[1.0], [1.0, 2.0]], [[[1.0, [2.0]]]], NESTED, [10**400], [None], Metres()),
    *(np.zeros(2, dtype="f8,f8"), pd.Series([1.0, None], dtype="Float64"), pd.Timestamp("2026-01-01")),
    *(np.nan, np.inf, -np.inf, [np.nan], np.longdouble("1e4000")),
]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("value", ODD, ids=lambda value: type(value).__name__)
def test_what_is_no_number_is_refused_by_name(value):
    for check in (
        lambda: numbers("the angle", value),
        lambda: number("the angle", value),
        lambda: positive("the angle", value, "m"),
        lambda: whole_number("the angle", value, 0, 10),
    ):
        with pytest.raises(pp.PinpressError, match=r"^the angle ") as caught:
            check()
        assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    "value",
    [
        *(7, 7.0, np.float32(7), np.int8(7), np.array(7.0), Fraction(7), 7 * 10**200 // 10**200),
        *(np.array(7, dtype=object), np.array(7.0, dtype=">f8"), np.longdouble(7)),
    ],
)
def test_a_number_of_any_honest_kind(value):
    assert number("x", value) == positive("x", value, "m") == numbers("x", value) == 7.0
    assert type(number("x", value)) is type(positive("x", value, "m")) is float


@pytest.mark.parametrize("value", [np.complex128(0.1), np.True_, "0.1", np.ma.masked, np.array([0.1, 0.2]), np.nan], ids=repr)
@pytest.mark.parametrize(
    "use",
    [
        lambda press, motion, x: pp.inverse_dynamics(press, motion, friction={"O": pp.loads.Friction(x, 0.05)}),
        lambda press, motion, x: pp.inverse_dynamics(press, motion, friction={"O": pp.loads.Friction(0.1, x)}),
        lambda press, motion, x: pp.inverse_dynamics(press, motion, friction={"O": pp.loads.Friction(0.1, 0.05, x)}),
        lambda press, motion, x: pp.inverse_dynamics(press, motion, stiffness={"O": x}),
        lambda press, motion, x: pp.balancing.with_counterweights(press, pp.balancing.Counterweight("crank", x, (0.1, 0.0, 0.0))),
        lambda press, motion, x: pp.measures.speed_variation(motion, x),
    ],
    ids=["coefficient", "radius", "viscous", "stiffness", "mass", "length"],
)
def test_single_numbers_of_parts_are_held_to_the_same(use, value):
    press = texts.shipped("crank_slide")
    with pytest.raises(pp.PinpressError):
        use(press, pp.cycle(press, 7.0, points=24), value)


def test_arrays_pass_unchanged_and_are_not_the_callers():
    given = np.array([[1.0, 2.0], [3.0, 4.0]])
    for values in (
        given,
        given.tolist(),
        given[:, ::-1][:, ::-1],
        pd.DataFrame(given),
        given.astype(int),
        given.astype(object),
        tuple(given),
    ):
        found = numbers("x", values, (None, 2))
        assert found.dtype == np.float64
        assert np.array_equal(found, given)
        assert not np.shares_memory(found, given)
    assert numbers("x", [10**20, 1]).tolist() == [1e20, 1.0]


@pytest.mark.parametrize(
    ("values", "shape", "problem"),
    [
        ([1.0, 2.0], (3,), r"x has shape \(2,\): give finite numbers of shape \(3,\)"),
        (1.0, (None,), r"x has shape \(\): give finite numbers of shape \(n,\)"),
        ([[1.0]], (None, 2), r"x has shape \(1, 1\): give finite numbers of shape \(n, 2\)"),
        ([[1.0, np.nan]], None, "x is not finite at point 0, 1"),
        (["1"], (3,), r"x is not finite numbers of shape \(3,\), but text: \['1'\]"),
    ],
)
def test_message(values, shape, problem):
    with pytest.raises(pp.PinpressError, match=problem):
        numbers("x", values, shape)


def test_whole_numbers():
    assert whole_number("n", np.int64(3), 2, 3) == 3
    for value in (1, 4, 2.0, 10**30):
        with pytest.raises(pp.PinpressError, match="give a whole number from 2 to 3"):
            whole_number("n", value, 2, 3)


def test_numbers_are_as_the_caller_wants_them():
    assert suitable_numbers("share", 0.5, "a share", suits=lambda share: share < 1) == 0.5
    assert suitable_numbers("points", [(1, 2), (3, 4)], "pairs", (None, 2)).shape == (2, 2)
    for given, shape in ((2.0, ()), ("0.5", ()), ([0.5], ()), (0.5, (1,)), (np.nan, None)):
        with pytest.raises(pp.PinpressError, match=r"^share is .*: give a share below 1$"):
            suitable_numbers("share", given, "a share below 1", shape, lambda share: share < 1)
