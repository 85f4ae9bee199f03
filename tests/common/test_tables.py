"""Columns written and read back: every number to its last bit, names and units as the library states them."""

import dataclasses

import numpy as np
import pytest
from scipy.io import loadmat
from support import texts

import pinpress as pp
from pinpress.common import tables

MOTION = [
    "time [s]",
    "crank_angle [rad]",
    "crank_speed [rad/s]",
    "crank_acceleration [rad/s2]",
    "slide_position [m]",
    "slide_velocity [m/s]",
    "slide_acceleration [m/s2]",
    "closure_error [m]",
]
VECTORS = [("shaking_force", "N"), ("shaking_moment", "N m")]
VECTORS += [(f"{kind}_{name}", unit) for name in ("O", "P", "slide_guide", "W") for kind, unit in (("force", "N"), ("moment", "N m"))]
RESULT = [*MOTION, "driving_torque [N m]", *(f"{name}_{axis} [{unit}]" for name, unit in VECTORS for axis in "xyz")]


@pytest.fixture(scope="module")
def motion():
    return pp.cycle(texts.shipped("crank_slide"), speed=7.0, points=17)


@pytest.fixture(scope="module")
def result(motion):
    load = pp.loads.PointForce("slide", lambda motion: np.outer(np.sin(motion.crank_angle), (0.0, 0.0, 1e6)))
    return pp.inverse_dynamics(texts.shipped("crank_slide"), motion, loads=[load])


@pytest.mark.parametrize(("write", "suffix"), [("to_csv", "csv"), ("to_mat", "mat")])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_no_file_holds_what_is_not_finite(tmp_path, result, write, suffix, value):
    torque = result.driving_torque.copy()
    torque[3] = value
    broken = dataclasses.replace(result, driving_torque=torque)
    with pytest.raises(pp.PinpressError, match=r"driving_torque \[N m\] is not finite in row 3"):
        getattr(broken, write)(tmp_path / f"broken.{suffix}")
    assert list(tmp_path.iterdir()) == []


def test_a_list_of_numbers_is_written_only_where_it_is_finite(tmp_path):
    """Words, truth values and gaps are written; what reads like a number and is none is not."""
    columns = {"name": ["nan", "b"], "of": [True, False], "gap": [None, 1.0]}
    tables.write_csv(tmp_path / "table.csv", columns)
    assert (tmp_path / "table.csv").read_text() == "name,of,gap\nnan,True,\nb,False,1.0\n"
    with pytest.raises(pp.PinpressError, match="height is not finite in row 1"):
        tables.write_csv(tmp_path / "table.csv", columns | {"height": [0.0, float("inf")]})


def test_names_and_units(motion, result):
    assert list(motion.columns()) == MOTION
    assert list(result.columns()) == RESULT


@pytest.mark.parametrize("engine", ["plane", "pinocchio"])
def test_torques_of_gear_pairs_and_powers_of_friction_have_columns(engine):
    """Of a pair the torque on the joint that follows; of bearings those with friction."""
    press = texts.shipped("jf75g_125_symmetric")
    motion = pp.cycle(press, speed=30.0, points=12)
    load = pp.loads.PointForce("slide", (0.0, 0.0, 1e5))
    friction = {"O_left": pp.loads.Friction(0.02, 0.08)}
    result = pp.inverse_dynamics(press, motion, loads=[load], friction=friction, engine=engine)
    columns, bearings = result.columns(), len(press.bearings)
    for name, torque in result.coupling_torque.items():
        assert np.abs(torque).max() > 1.0
        np.testing.assert_array_equal(columns[f"coupling_torque_{name} [N m]"], torque[:, 0])
    np.testing.assert_array_equal(columns["friction_power_O_left [W]"], result.friction_power["O_left"])
    assert len(columns) == len(motion.columns()) + 1 + len(press.couplings) + 6 * (1 + bearings) + 1


def test_columns_are_the_quantities(motion, result):
    columns = result.columns()
    assert columns["time [s]"] is motion.time
    np.testing.assert_array_equal(columns["slide_acceleration [m/s2]"], motion.slide_acceleration)
    assert columns["driving_torque [N m]"] is result.driving_torque
    np.testing.assert_array_equal(columns["shaking_force_z [N]"], result.shaking_force[:, 2])
    np.testing.assert_array_equal(columns["shaking_moment_y [N m]"], result.shaking_moment[:, 1])
    np.testing.assert_array_equal(columns["force_W_x [N]"], result.bearing_force["W"][:, 0])
    np.testing.assert_array_equal(columns["moment_O_y [N m]"], result.bearing_moment["O"][:, 1])


def test_a_frame_is_a_copy(motion):
    frame = motion.to_frame()
    frame.iloc[0, 0] = 9.0
    assert motion.time[0] == 0.0


def test_motions_have_their_joints_in_matlab_too(tmp_path, motion):
    motion.to_mat(tmp_path / "table")  # the name has no ending, and gets none
    loaded = {name: values for name, values in loadmat(tmp_path / "table").items() if not name.startswith("__")}
    expected = {name.split(" [")[0]: values[:, None] for name, values in motion.columns().items()}
    expected |= {"q": motion.q, "v": motion.v, "a": motion.a}
    assert list(loaded) == list(expected)
    for name, values in expected.items():
        np.testing.assert_array_equal(loaded[name], values)


def test_states_without_time_or_slide_have_no_such_columns():
    press = texts.shipped("crank_slide")
    states = pp.servo_cycle(press, speed=1.0, angle=[1.0, 0.5])
    assert list(states.columns()) == MOTION[1:]
    assert list(states.to_frame().columns) == MOTION[1:]


@pytest.mark.parametrize(
    ("unit", "values", "printed", "shown"),
    [
        ("N", [154242.0, 300.0, 1e-5, -1e-5], "kN", ["154.24", "0.30", "0", "0"]),  # rounding is no number, and no "-0"
        ("N", [9999.94, -0.04], "N", ["9999.9", "0"]),
        ("N m", [2.3e7], "MN m", ["23.000"]),
        ("W", [1611.86], "kW", ["1.6119"]),
        ("kg", [12345.6, 0.6], "t", ["12.346", "0.001"]),
        ("m", [0.301261, 1e-6], "mm", ["301.261", "0.001"]),
        ("m/s", [0.0093], "mm/s", ["9.3000"]),
        ("m/s2", [-1234567.0, 9999.0], "m/s²", ["-1 234 567", "9999"]),
        ("N", [0.0], "N", ["0"]),
        ("J", [], "J", []),
    ],
)
def test_numbers_of_a_scale(unit, values, printed, shown):
    scale = tables.scale(unit, values)
    assert (scale.unit, [scale.shown(value) for value in values]) == (printed, shown)


@pytest.mark.parametrize(
    ("value", "shown"),
    [(10326.94, "10 326.9"), (-123456.0, "-123 456"), (1234.5, "1234.5"), (-0.25, "-0.25"), (1e6, "1e+06"), (12345, "12345"), (None, "")],
)
def test_thousands_stand_apart_in_cells(value, shown):
    assert tables.cell(value) == shown


def test_no_zero_has_a_minus_sign():
    line = tables.entry("-0.0", "-0.000", "mm", "at   -0.000 mm, from -0 to (-0.0), -0.5, -0.001 mm, e-0 and -0e3")
    assert line == f"  -0.0{'0.000':>34} mm     at    0.000 mm, from 0 to (0.0), -0.5, -0.001 mm, e-0 and -0e3"
    assert tables.table([["-0", "-0.0", "-0.1"]], [3, 6]) == ["  -0    0.0  -0.1"]
    assert tables.fitted_words([["-0", "-0 %", "x-0"]]) == ["  -0   0 %   x-0"]
