"""The text and the columns of a balance: what they say is what inverse dynamics and another balance say."""

import csv
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress.balancing import (
    AddedMass,
    BalancedPress,
    Counterweight,
    CounterweightRegion,
    OperatingCondition,
    Peak,
    Range,
    Rms,
    with_counterweights,
)

X, Z, TORQUE = Range("shaking_force", "x"), Range("shaking_force", "z"), Rms("driving_torque")
MOST_ON_ROCKER, MOST_X, MOST_ADDED = 250.0, 1000.0, 600.0
DIGITS = 6e-5  # the text has five digits, prices three
ARMS = """<robot name="arms"><link name="base"/><link name="one"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"
ixy="0" ixz="0" iyz="0"/></inertial></link><link name="two"><inertial><origin xyz="0.3 0 0"/><mass value="1"/><inertia ixx="1" iyy="1"
izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="J" type="continuous"><parent link="base"/><child link="one"/>
<axis xyz="0 1 0"/></joint><joint name="K" type="continuous"><origin xyz="0.5 0 0"/><parent link="one"/><child link="two"/>
<axis xyz="0 1 0"/></joint><transmission name="t"><joint name="J"/></transmission><transmission name="u"><joint name="K"/></transmission>
</robot>"""


def cases(*speeds: float) -> list[OperatingCondition]:
    return [OperatingCondition(pp.cycle(shipped("zxn2_3000b"), speed * pp.RPM, points=90)) for speed in speeds]


@cache
def pressed(rocker: float = MOST_ON_ROCKER, x: float = MOST_X, added: float = MOST_ADDED) -> BalancedPress:
    """The six-bar under limits that all hold it back."""
    regions = [
        CounterweightRegion("crank", radius=0.3),
        CounterweightRegion("rocker", (0, rocker), radius=0.6),
        CounterweightRegion("rod", radius=0.3),
    ]
    return pp.balancing.balance(shipped("zxn2_3000b"), cases(70), regions=regions, minimise=Z, limits={X: x, AddedMass(): added})


@cache
def at_two_speeds() -> BalancedPress:
    regions = [CounterweightRegion("crank", radius=0.3), CounterweightRegion("rocker", radius=0.6)]
    return pp.balancing.balance(
        shipped("zxn2_3000b"), cases(70, 40), regions=regions, minimise={Z: 1.0, TORQUE: 0.5}, limits={AddedMass(): MOST_ADDED}
    )


@cache
def tilted() -> BalancedPress:
    """A symmetric press with a mass on one side: what was zero is not."""
    press = shipped("jf75g_125_symmetric")
    region = CounterweightRegion("crank_left", (5, 50), at=(0.1, 0, 0.05))
    return pp.balancing.balance(press, pp.cycle(press, 300 * pp.RPM, points=90), regions=[region], minimise=Z)


def row(text: str, name: str) -> list[str]:
    """The cells behind a name in a table."""
    (rest,) = re.findall(rf"^  {re.escape(name)}  +(.*)$", text, flags=re.MULTILINE)
    return rest.split()


def values(text: str, criterion: str) -> list[tuple[float, list[str]]]:
    """For each condition the SI units in one unit of a criterion, and the cells behind its name."""
    found = re.findall(rf"^  {re.escape(criterion)} \[(k?)N(?: m)?\] +(.*)$", text, flags=re.MULTILINE)
    return [(1e3 if kilo else 1.0, rest.split()) for kilo, rest in found]


def section(text: str, title: str) -> str:
    return next(part for part in text.split("\n\n") if part.startswith(title))


def test_the_text_says_what_the_balance_has() -> None:
    balance, text = pressed(), str(pressed())
    assert text.startswith("BalancedPress zxn2_3000b_balanced: ")
    assert "The motion: 70 r/min of joint A, 90 states.\n" in text
    for weight in balance.counterweights:
        mass, *place, inertia = (float(cell) for cell in row(text, weight.link))
        assert (mass, inertia) == pytest.approx((weight.mass, weight.inertia), rel=DIGITS)
        np.testing.assert_allclose(place, 1e3 * np.asarray(weight.position), atol=5.01e-4)  # mm with three decimals
    assert float(row(text, "added mass")[0]) == pytest.approx(balance.added_mass, rel=DIGITS)
    assert re.search(r"^  added mass +\S+ kg +of 600.00 kg, in 2 counterweights, beside 11.522 t of moving mass$", text, flags=re.MULTILINE)
    assert re.search(r"^  range of the shaking force, x +1000.0 N +of 1000.0 N$", text, flags=re.MULTILINE)
    before = "range of the shaking force, z, before"
    for name, number in ((before, balance.changes[0].before), ("reached", balance.value), ("proven bound", balance.bound)):
        assert row(text, name)[:2] == [f"{number / 1e3:.2f}", "kN"]
    for found in (*balance.changes, *balance.side_effects):
        ((unit, (before, after, change, *limit)),) = values(text, found.criterion.words)
        assert unit * float(before) == pytest.approx(found.before, rel=DIGITS)
        assert unit * float(after) == pytest.approx(found.after, rel=DIGITS, abs=1e-5 * found.before)
        assert float(change) == pytest.approx(100 * found.change, abs=0.00501)
        assert limit == (["1000.0"] if found.criterion == X else [])


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "limits", "unit"),
    [
        ("limit of the added mass, 600 kg", [(MOST_ON_ROCKER, MOST_X, MOST_ADDED + 1), (MOST_ON_ROCKER, MOST_X, MOST_ADDED - 1)], "kg"),
        (
            "limit of the range of the shaking force, x, 1000 N",
            [(MOST_ON_ROCKER, MOST_X + 1, MOST_ADDED), (MOST_ON_ROCKER, MOST_X - 1, MOST_ADDED)],
            "N",
        ),
        (
            "most mass of the region on 'rocker', 250 kg",
            [(MOST_ON_ROCKER + 1, MOST_X, MOST_ADDED), (MOST_ON_ROCKER - 1, MOST_X, MOST_ADDED)],
            "kg",
        ),
    ],
)
def test_a_price_is_between_what_one_more_gains_and_one_less_loses(name: str, limits: list[tuple[float, ...]], unit: str) -> None:
    """The optimum is a convex function of a limit."""
    text = section(str(pressed()), "  Held back by")
    words = re.search(rf"^  {re.escape(name)} +the objective falls by (\S+) N for each (\S+) relaxed$", text, flags=re.MULTILINE)
    assert words is not None
    more, less = (pressed(*some).value for some in limits)
    assert words[2] == unit
    assert (1 - 5e-3) * (pressed().value - more) <= float(words[1]) <= (1 + 5e-3) * (less - pressed().value)  # it has three digits


def test_the_shape_of_a_region_has_no_price() -> None:
    assert "\n  radius of the region on 'crank'\n" in str(pressed()) + "\n"


def test_a_weighted_objective_is_relative() -> None:
    balance, text = at_two_speeds(), str(at_two_speeds())
    assert "the least 1 x range of the shaking force, z + 0.5 x rms of the driving torque, each relative to before" in text
    assert row(text, "weighted sum, before")[0] == "1.5000"
    assert row(text, "reached") == [f"{balance.value:.5g}"]
    changes = {criterion: [change for change in balance.changes if change.criterion == criterion] for criterion in (Z, TORQUE)}
    worst = {criterion: max(c.after for c in rows) / max(c.before for c in rows) for criterion, rows in changes.items()}
    assert float(row(text, "reached")[0]) == pytest.approx(worst[Z] + 0.5 * worst[TORQUE], rel=DIGITS)
    assert re.search(r"relaxed$", section(text, "  Held back by"), flags=re.MULTILINE)


def test_operating_conditions_are_told_apart() -> None:
    text = str(at_two_speeds())
    assert section(text, "  Operating conditions").splitlines()[2:] == [
        "  0          70 r/min of joint A, 90 states",
        "  1          40 r/min of joint A, 90 states",
    ]
    found = values(text, "range of the shaking force, z")
    expected = [np.ptp(reactions.shaking_force[:, 2]) for reactions in at_two_speeds().reactions_before]
    assert [condition for _, (condition, *_) in found] == ["0", "1"]
    np.testing.assert_allclose([unit * float(before) for unit, (_, before, *_) in found], expected, rtol=DIGITS)


def test_effects_are_those_of_the_counterweights_alone() -> None:
    """Fitted to the press anew, and all forces from the definitions."""
    balance = pressed()
    fitted = with_counterweights(shipped("zxn2_3000b"), balance.counterweights)
    before, after = (pp.inverse_dynamics(press, pp.cycle(press, 70 * pp.RPM, points=90)) for press in (shipped("zxn2_3000b"), fitted))
    expected = {"range of the driving torque": [np.ptp(some.driving_torque) for some in (before, after)]}
    for name in fitted.bearings_as_drawn:
        peaks = [np.linalg.norm(some.bearing_force[name], axis=1).max() for some in (before, after)]
        expected[f"peak of the bearing force of {name}"] = peaks
    expected["range of the shaking moment, y"] = [np.ptp(some.shaking_moment[:, 1]) for some in (before, after)]
    found = {effect.criterion.words: [effect.before, effect.after] for effect in balance.side_effects}
    assert list(found) == list(expected)  # neither what was asked for nor what a planar press has not
    for name, values in found.items():
        np.testing.assert_allclose(values, expected[name], rtol=1e-10, err_msg=name)  # rounding of torques made up of larger ones


def test_what_was_zero_before_has_no_change(tmp_path: Path) -> None:
    balance = tilted()
    sideways = next(effect for effect in balance.side_effects if effect.criterion == X)
    assert (sideways.before, sideways.after > 100) == (0.0, True)
    assert row(str(balance), "range of the shaking force, x [N]") == ["0", f"{sideways.after:.5g}"]
    columns = balance.columns()
    assert columns["change [-]"][columns["criterion"].index(X.words)] is None
    balance.to_csv(tmp_path / "tilted.csv")
    with (tmp_path / "tilted.csv").open(encoding="utf-8", newline="") as file:
        (line,) = (line for line in csv.DictReader(file) if line["criterion"] == X.words)
    assert line == {
        "criterion": X.words,
        "unit": "N",
        "condition": "0",
        "before": "0.0",
        "after": repr(sideways.after),
        "change [-]": "",
        "limit": "",
    }


def test_limits_stand_beside_their_criteria() -> None:
    columns = pressed().columns()
    assert dict(zip(columns["criterion"], columns["limit"], strict=True))[X.words] == MOST_X
    assert [limit for limit in columns["limit"] if limit is not None] == [MOST_X]


def test_counterweights_as_columns() -> None:
    balance = pressed()
    columns = balance.counterweights.columns()
    links, *numbers = columns.values()
    made = [Counterweight(link, m, (x, y, z), j) for link, m, x, y, z, j in zip(links, *numbers, strict=True)]
    assert made == list(balance.counterweights)
    assert list(columns) == ["link", "mass [kg]", "position_x [m]", "position_y [m]", "position_z [m]", "inertia [kg m2]"]


def test_the_least_mass_is_an_objective_too() -> None:
    press = shipped("zxn2_3000b")
    balance = pp.balancing.balance(
        press, cases(70), regions=[CounterweightRegion("crank", radius=0.3)], minimise=AddedMass(), limits={X: 4000.0}
    )
    assert "The counterweights have the least added mass, with" in str(balance)
    assert row(str(balance), "added mass, before") == ["0", "kg"]
    assert row(str(balance), "reached") == [f"{balance.added_mass:.5g}", "kg"]
    assert re.search(r"4000 N +the objective falls by \S+ kg for each N relaxed", str(balance))


def test_loads_count_in_the_effects() -> None:
    press = shipped("zxn2_3000b")
    down, up = pp.loads.PointForce("slide", (0, 0, -1e5)), pp.loads.PointForce("frame", (0, 0, 1e5))
    (case,) = cases(70)
    balance = pp.balancing.balance(
        press, case.motion, regions=[CounterweightRegion("crank", radius=0.3, mass=(0, 100))], minimise=X, loads=[down, up]
    )
    loaded = pp.inverse_dynamics(balance.press, balance.reactions_after[0].motion, loads=[down, up])
    (torque,) = (effect for effect in balance.side_effects if effect.criterion == Range("driving_torque"))
    assert torque.after == pytest.approx(np.ptp(loaded.driving_torque), rel=1e-12)
    assert "90 states, 2 loads.\n" in str(balance)


def test_several_drivers_and_uneven_motion(tmp_path: Path) -> None:
    """Their torques have a peak in place of a range."""
    (tmp_path / "arms.urdf").write_text(ARMS, encoding="utf-8")
    arms = pp.load(tmp_path / "arms.urdf")
    angle = np.linspace(0, 1, 20)
    motion = pp.servo_cycle(arms, angle=np.stack([angle, 2 * angle], axis=1), speed=np.tile([1.0, 2.0], (20, 1)))
    balance = pp.balancing.balance(arms, motion, regions=[CounterweightRegion("two", at=(-0.3, 0, 0), mass=(0, 0.5))], minimise=Z)
    (torque,) = (effect for effect in balance.side_effects if effect.criterion.quantity == "driving_torque")
    before = pp.inverse_dynamics(arms, motion).driving_torque
    assert torque.criterion == Peak("driving_torque")
    assert torque.before == pytest.approx(np.linalg.norm(before, axis=1).max(), rel=1e-12)
    assert "The motion: a motion of 20 states.\n" in str(balance)
