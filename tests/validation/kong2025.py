"""Kong X. et al. 2025, Forging and Stamping Technology 50(2), 195-203: the six-bar press ZXN2-3000(B), before and after partial balancing.

The moments of inertia are ours, as the paper prints none; the press is not fitted to the tables. The paper's signs: M_b is minus the
driving torque, as (11) has -M_b next to moments that are positive counter-clockwise; the forces in A act from the crank on the frame,
though (17) names those of the frame on the crank; x points to the right, y up.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike
from validation import kong2025_as_printed
from validation.kong2025_counterweights import PAPER, compared, priced
from validation.pictures import draw
from validation.rows import BEYOND, DATA, NOT, PARTLY, REPRODUCED, SOLVER, Part, Row, Table, rows_from, unclaimed

import pinpress as pp
from pinpress import RPM
from pinpress.common.quantities import Array, Values

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPEED = 70 * RPM
POINTS = 7200  # extremes between two of them are missed by 1e-7 of the curve's swing
MOMENT, ACROSS, UPRIGHT = "driving torque M_b [N m]", "bearing A, x [N]", "bearing A, vertical [N]"
# Tables 2 and 3: maximum and minimum before, after balancing [N m, N]
PRINTED = {
    MOMENT: ((20325, -18150), (19819, -17937)),
    ACROSS: ((120604, -104518), (119421, -100070)),
    UPRIGHT: ((52375, -79419), (50688, -75741)),
}
RANGES = {MOMENT: (38476, 37756), ACROSS: (225122, 219491), UPRIGHT: (131794, 126429)}
REDUCTION = {MOMENT: "-1.8713", ACROSS: "-2.5013", UPRIGHT: "-4.0707"}  # [%]
NAMES = {"before": "zxn2_3000b", "after": "zxn2_3000b_balanced"}
AXES = {"x": 0, "vertical": 2}


@dataclass(frozen=True, eq=False)
class PressTurn:
    """The press before or after balancing, over one turn at 70 strokes/min."""

    press: pp.Linkage
    motion: pp.Motion
    reactions: pp.Reactions

    @property
    def moment(self) -> Array:
        """M_b (n,), with the paper's sign [N m]."""
        return -self.reactions.driving_torque

    def columns(self) -> dict[str, Array]:
        """The curves of tables 2 and 3, with the paper's signs."""
        force = -self.reactions.bearing_force["A"]
        return {MOMENT: self.moment, ACROSS: force[:, 0], UPRIGHT: force[:, 2]}

    def component(self, bearing: str, axis: str) -> Array:
        """(n,) of a bearing force [N]."""
        return self.reactions.bearing_force[bearing][:, AXES[axis]]


@cache
def state(name: str, points: int = POINTS, gravity: float = 9.81) -> PressTurn:
    """A shipped press at 70 strokes/min."""
    press = pp.load(name, gravity=(0, 0, -gravity))
    motion = pp.cycle(press, SPEED, points=points)
    return PressTurn(press, motion, pp.inverse_dynamics(press, motion))


def before() -> PressTurn:
    return state(NAMES["before"])


def after() -> PressTurn:
    return state(NAMES["after"])


def largest_at(motion: pp.Motion, curve: Array) -> float:
    """Crank angle [deg] at which a curve (n,) over a turn is largest, by the parabola through the largest value and its neighbours."""
    top = int(curve.argmax())
    low, high, next_low = (float(curve[(top + k) % len(curve)]) for k in (-1, 0, 1))
    beyond = 0.5 * (low - next_low) / (low - 2 * high + next_low)
    return float(np.degrees(motion.crank_angle[top]) + 360.0 / len(curve) * beyond) % 360.0


def change(first: Array, second: Array) -> float:
    """Change of the range of a curve [%]."""
    return float(100 * (np.ptp(second) / np.ptp(first) - 1))


def extremes(what: str, curves: dict[str, tuple[pp.Motion, Array, Array]]) -> Table:
    """Largest and smallest value of curves before and after balancing, with their crank angles."""

    def ends(motion: pp.Motion, curve: Array) -> tuple[str, ...]:
        places = ((curve.max(), largest_at(motion, curve)), (curve.min(), largest_at(motion, -curve)))
        return tuple(f"{value:.2f} at {angle:.1f} deg" for value, angle in places)

    heads = (what, *(f"{end}, {when}" for when in NAMES for end in ("largest", "smallest")))
    return Table(heads, tuple((words, *ends(motion, one), *ends(motion, two)) for words, (motion, one, two) in curves.items()))


# ------------------------------------------------------------------------------------------------------------------ motor and gearing

STROKES = (50.0, 70.0)  # a minute, of the press
MOTOR_SPEED = (724.9, 1450.0)  # of the motor in operation [r/min]
BELTS, PINION = (2.0, 2.5, 3.15, 4.0), 20  # belt ratios that a designer would try, and teeth of the pinion (ours)
WEAKENED = 25.0  # a ratio above all that serve, to show field weakening (ours)


def motor() -> pp.drives.InverterMotor:
    """Fig. 1: the permanent torque of the motor on its inverter, field weakening above 50 Hz."""
    return pp.drives.InverterMotor(rated_torque=482.0, rated_speed=1485 * RPM, frequency=50.0, overload=1.0)


def serving_ratios() -> tuple[float, float]:
    """Least and largest ratio of motor speed to strokes a minute with which the motor keeps its printed range over that of the press."""
    return MOTOR_SPEED[0] / STROKES[0], MOTOR_SPEED[1] / STROKES[1]


def frequency_at(motor_speed: Values) -> Values:
    """Frequency [Hz] at which the motor gives its permanent torque at a speed [r/min].

    The lag behind the synchronous speed, 15 r/min at the rated point, stays below fN; above it grows with f / fN, as the slope of the
    torque falls with (fN / f)^2 and the permanent torque with fN / f.
    """
    synchronous = motor().synchronous_speed / RPM
    lag = synchronous - 1485
    return np.where(motor_speed <= synchronous - lag, motor_speed + lag, motor_speed / (1 - lag / synchronous)) / synchronous * 50.0


def crank_torque(ratio: float, strokes: Values) -> Values:
    """Permanent torque on the crank [N m] at strokes a minute, without losses."""
    return ratio * motor().torque_limit(frequency_at(ratio * strokes))


def by_ratio() -> Table:
    """What three ratios leave on the crank."""
    rows = []
    for ratio in (*serving_ratios(), WEAKENED):
        torque = [float(crank_torque(ratio, strokes)) for strokes in STROKES]
        columns = (
            (f"{speed / ratio:.1f}" for speed in MOTOR_SPEED),
            (f"{ratio * strokes:.0f}" for strokes in STROKES),
            (f"{float(frequency_at(ratio * strokes)):.1f}" for strokes in STROKES),
            (f"{moment:.0f}" for moment in torque),
            (f"{2e-3 * math.pi * moment:.1f}" for moment in torque),
            (f"{1e-3 * moment * strokes * RPM:.1f}" for moment, strokes in zip(torque, STROKES, strict=True)),
        )
        rows.append((f"{ratio:.3f}", *(" to ".join(column) for column in columns)))
    motion = "strokes/min at 724.9 and 1450 r/min", "motor at 50 and 70 strokes/min [r/min]", "frequency there [Hz]"
    return Table(("ratio", *motion, "permanent torque on the crank there [N m]", "its work in a turn [kJ]", "its power [kW]"), tuple(rows))


def by_belt() -> Table:
    """Ratios of the gear stage behind a belt, and a pair of wheels just below the largest."""
    rows = []
    for belt in BELTS:
        least, largest = (ratio / belt for ratio in serving_ratios())
        wheel = math.floor(PINION * largest)
        rows.append((f"{belt:g}", f"{least:.3f} to {largest:.3f}", f"{wheel} : {PINION}", f"{belt * wheel / PINION:.3f}"))
    return Table(("belt", "gear stages that serve", f"largest with {PINION} teeth on the pinion", "ratio of both"), tuple(rows))


# ---------------------------------------------------------------------------------------------------------------------------- motion


def motion_rows() -> Iterator[Row]:
    """Extremes over the turn, and the crank angles at which they are."""

    def ours() -> list[float]:
        motion, ends = before().motion, pp.dead_centres(before().press)
        position, velocity, acceleration = motion.slide_position, motion.slide_velocity, motion.slide_acceleration
        values = [position.max(), position.min(), ends.stroke, velocity.max(), velocity.min(), acceleration.max(), acceleration.min()]
        values += [ends.bottom_angle / SPEED, np.degrees(ends.bottom_angle), ends.top_angle / SPEED, np.degrees(ends.top_angle)]
        places = [largest_at(motion, curve) for curve in (velocity, -velocity, acceleration, -acceleration)]
        return [*values, *places, pp.measures.dwell_time(pp.cycle(before().press, SPEED, points=720), 1e-3)]

    return rows_from(
        ours,
        ("highest position [m]", "-0.6583", 0.1),
        ("lowest position [m]", "-0.9595", 0.1),
        ("stroke [m]", "0.3012", 0.1),
        ("highest speed upwards [m/s]", "1.3910", 0.1),
        ("highest speed downwards [m/s]", "-1.4690", 0.1),
        ("largest acceleration upwards [m/s2]", "8.7040", 0.1),
        ("largest acceleration downwards [m/s2]", "-17.8620", 0.1),
        ("bottom dead centre [s]", "0.8", 0.5, "", 4),
        ("bottom dead centre, crank angle [deg]", "334.52482", 1e-5, SOLVER),
        ("top dead centre [s]", "", None, "", 4),
        ("top dead centre, crank angle [deg]", "155.49688", 1e-5, SOLVER),
        ("highest speed upwards, crank angle [deg]", "97.95280", 1e-4, SOLVER),
        ("highest speed downwards, crank angle [deg]", "209.97711", 1e-4, SOLVER),
        ("largest acceleration upwards, crank angle [deg]", "250.75276", 1e-4, SOLVER),
        ("largest acceleration downwards, crank angle [deg]", "158.46272", 1e-4, SOLVER),
        ("time within 1 mm of bottom dead centre [s]", "", None, "", 4),
    )


def mass_rows() -> Iterator[Row]:
    def body(turn: PressTurn, joint: str) -> tuple[float, float]:
        inertia = turn.press.model.inertias[turn.press.model.getJointId(joint)]
        return float(inertia.mass), float(inertia.lever[0])

    def weight(joint: str) -> str:
        (m1, c1), (m2, c2) = body(before(), joint), body(after(), joint)
        return f"{m2 - m1:.3f} kg at {(m2 * c2 - m1 * c1) / (m2 - m1):.4f} m"

    for joint, link, mass, centre in (("A", "crank", "1614.656", "-0.0181"), ("E", "rod", "333.216", "0.1924")):
        yield Row(f"mass of the {link} [kg]", mass, lambda joint=joint: body(after(), joint)[0])
        yield Row(f"centre of mass of the {link} from its first pin [m]", centre, lambda joint=joint: body(after(), joint)[1])
        yield Row(f"counterweight on the {link}, from the difference to the press before", "", lambda joint=joint: weight(joint))


# ----------------------------------------------------------------------------------------------------------------------------- forces


def table_rows(*names: str) -> Iterator[Row]:
    """Rows of tables 2 and 3."""
    for name in names:
        for when, turn, (most, least), width in zip(NAMES, (before, after), PRINTED[name], RANGES[name], strict=True):
            yield Row(f"{name}, {when}, maximum", str(most), lambda turn=turn, name=name: turn().columns()[name].max())
            yield Row(f"{name}, {when}, minimum", str(least), lambda turn=turn, name=name: turn().columns()[name].min())
            yield Row(f"{name}, {when}, range", str(width), lambda turn=turn, name=name: np.ptp(turn().columns()[name]))
        reduced = REDUCTION[name]
        words = f"{name}, change of the range [%]"
        yield Row(words, reduced, lambda name=name: change(before().columns()[name], after().columns()[name]), places=2)


def torque_rows() -> Iterator[Row]:
    def at_bottom() -> list[float]:
        turn = before()
        bottom, slope = int(turn.motion.slide_position.argmin()), np.abs(np.gradient(turn.moment, turn.motion.time))
        return [turn.moment[bottom], 100 * slope[bottom] / slope.max()]

    yield from table_rows(MOMENT)
    names = "M_b at bottom dead centre, before [N m]", "its slope there, by the steepest [%]"
    yield from rows_from(at_bottom, (names[0], "", None, "", 0), (names[1], "", None, "", 1))


def torque_extremes() -> Table:
    curves = {words: [sign / 1e3 * turn.moment for turn in (before(), after())] for words, sign in (("M_b", 1), ("`driving_torque`", -1))}
    return extremes("torque [kN m]", {words: (before().motion, *pair) for words, pair in curves.items()})


def bearing_rows() -> Iterator[Row]:
    def changes() -> list[float]:
        return [change(before().component(name, axis), after().component(name, axis)) for name in "ABCDEF" for axis in AXES]

    def shares() -> list[float]:
        sizes = [np.linalg.norm(before().reactions.bearing_force[name], axis=1) for name in "ABC"]
        bottom = before().motion.slide_position.argmin()
        return [float(100 * force / size.max()) for size in sizes for force in (size[bottom], size.min())]

    yield from rows_from(changes, *unclaimed((f"{name}, {axis}, change of the range [%]" for name in "ABCDEF" for axis in AXES), 2))
    kinds = "force at bottom dead centre", "smallest force"
    yield from rows_from(shares, *unclaimed((f"{name}, {kind} by its peak [%]" for name in "ABC" for kind in kinds), 1))


def bearing_extremes() -> Table:
    forces = {f"{name}, {axis}": [1e-3 * turn.component(name, axis) for turn in (before(), after())] for name in "ABCDEF" for axis in AXES}
    return extremes("force [kN]", {words: (before().motion, *pair) for words, pair in forces.items()})


# ------------------------------------------------------------------------------------------------- (18), which leaves out a weight

TURNING = ("B", "D", "E")  # joints of the links whose inertias matter at constant crank speed: coupler, rocker, rod


@dataclass(frozen=True, eq=False)
class CurveParts:
    """The summands of the curves of tables 2 and 3, in the order of `PRINTED`; forces are linear in weights and inertias.

    Attributes:
        rest: (3, n) curves of a press without inertias and without the crank's weight.
        weight: (3, n) share of the crank's weight G1.
        inertia: (3, 3, n) shares of the shipped inertias of the links in `TURNING`.
    """

    rest: Array
    weight: Array
    inertia: Array


@cache
def parts(turn: PressTurn) -> CurveParts:
    """The parts of a press before or after balancing."""

    def curves(press: pp.Linkage, *loads: pp.loads.PointForce) -> Array:
        result = pp.inverse_dynamics(press, turn.motion, loads=list(loads), bearings=["A"])
        return np.array(list(PressTurn(press, turn.motion, result).columns().values()))

    def without_inertia(joint: str) -> pp.Linkage:
        model = turn.press.model.copy()
        body = model.inertias[model.getJointId(joint)]
        model.inertias[model.getJointId(joint)] = pin.Inertia(body.mass, body.lever, np.zeros((3, 3)))
        return replace(turn.press, model=model)

    whole = curves(turn.press)
    crank = turn.press.model.inertias[turn.press.model.getJointId("A")]
    x, y, z = crank.lever.tolist()
    weight = whole - curves(turn.press, pp.loads.PointForce("crank", (0.0, 0.0, 9.81 * crank.mass), (x, y, z)))
    inertia = np.array([whole - curves(without_inertia(joint)) for joint in TURNING])
    return CurveParts(whole - weight - inertia.sum(axis=0), weight, inertia)


def rms_deviation(pair: Sequence[CurveParts], weight: float, shares: ArrayLike) -> float:
    """Root mean square of the deviations of the twelve extremes in tables 2 and 3, each by the printed range before balancing [%].

    Args:
        pair: parts before and after balancing.
        weight: factor of the crank's weight.
        shares: (4,) factors of the shipped inertias of coupler, rocker, rod before and rod after balancing.
    """
    coupler, rocker, rod, balanced_rod = np.asarray(shares, dtype=float).tolist()
    deviations = []
    for summands, when, third in zip(pair, (0, 1), (rod, balanced_rod), strict=True):
        curves = summands.rest + weight * summands.weight + np.tensordot([coupler, rocker, third], summands.inertia, 1)
        for curve, printed in zip(curves, PRINTED.values(), strict=True):
            most, least = printed[when]
            deviations += [(curve.max() - most) / np.subtract(*printed[0]), (curve.min() - least) / np.subtract(*printed[0])]
    return float(100 * np.sqrt(np.mean(np.square(deviations))))


def least_deviation(pair: Sequence[CurveParts], weight: float) -> float:
    """The least `rms_deviation` [%] for any inertias that are not negative, searched from the shipped ones."""
    from scipy.optimize import minimize  # slow to import

    # every tenth state is enough to search
    coarse = [CurveParts(summands.rest[:, ::10], summands.weight[:, ::10], summands.inertia[:, :, ::10]) for summands in pair]
    # extremes have corners, where other crank angles take over: a search without gradients
    best = minimize(lambda shares: rms_deviation(coarse, weight, shares), np.ones(4), method="Nelder-Mead", bounds=[(0.0, None)] * 4)
    return rms_deviation(pair, weight, best.x)


def both() -> list[CurveParts]:
    return [parts(before()), parts(after())]


def weight_rows() -> Iterator[Row]:
    """Which of the printed numbers hold the crank's weight, which (18) leaves out, and what the printed equations give."""

    def deviations() -> list[float]:
        by_shares = [[rms_deviation(both(), weight, share * np.ones(4)) for share in (1.0, 0.0)] for weight in (1.0, 0.0)]
        return [each for weight, pair in zip((1.0, 0.0), by_shares, strict=True) for each in (*pair, least_deviation(both(), weight))]

    def ends() -> list[float]:
        curve = kong2025_as_printed.slide_acceleration(before().press)
        return [curve.max(), curve.min()]

    inertias = "our inertias", "inertias zero", "the best of all inertias"
    words = (f"rms deviation from tables 2 and 3, {g1}, {which} [%]" for g1 in ("with G1", "without G1") for which in inertias)
    yield from rows_from(deviations, *unclaimed(words, 2))
    by_10 = "acceleration of the slide by (10) as printed [m/s2]"
    yield from rows_from(ends, (f"largest {by_10}", "8.7040"), (f"smallest {by_10}", "-17.8620"))


def changes() -> Table:
    """Changes of the extremes by balancing: as printed, and ours with and without the crank's weight."""
    rows = []
    for place, (name, (first, second)) in enumerate(PRINTED.items()):
        ends = []
        for weight in (1.0, 0.0):
            one, two = (part.rest[place] + weight * part.weight[place] + part.inertia[:, place].sum(axis=0) for part in both())
            ends.append((two.max() - one.max(), two.min() - one.min()))
        for k, end in enumerate(("maximum", "minimum")):
            rows.append((f"{name}, {end}", f"{second[k] - first[k]:+d}", *(f"{values[k]:+.0f}" for values in ends)))
    return Table(("change by balancing", "document", "with G1", "without G1"), tuple(rows))


def systems() -> Table:
    """The extremes of tables 2 and 3 before balancing by the printed equations, and with some of them corrected; our inertias."""
    rows = [("tables 2 and 3", *(str(end) for ends, _ in PRINTED.values() for end in ends))]
    for words, corrected in {
        "(11) to (15) as printed": (),
        "(15) corrected": ("(15)",),
        "(12), (13) corrected": ("(12)", "(13)"),
        "all corrected": kong2025_as_printed.WRONG,
    }.items():
        forces = kong2025_as_printed.forces(before().press, corrected)
        curves = forces["M_b"], -forces["F01x"], -forces["F01y"]
        rows.append((words, *(f"{end:.0f}" for curve in curves for end in (curve.max(), curve.min()))))
    return Table(("before balancing", *(f"{name}, {end}" for name in PRINTED for end in ("maximum", "minimum"))), tuple(rows))


# ------------------------------------------------------------------------------------------------ centre of mass, shaking, free runs


@cache
def centre_of_mass(name: str) -> Array:
    """The centre of mass of all that moves, (720, 3) over a turn [m]."""
    press = state(name).press
    data = press.model.createData()
    return np.array([pin.centerOfMass(press.model, data, q).copy() for q in pp.cycle(press, SPEED, points=720).q])


def balance_rows() -> Iterator[Row]:
    def ours() -> list[float]:
        centres = [centre_of_mass(name) for name in NAMES.values()]
        forces = [turn.reactions.shaking_force for turn in (before(), after())]
        return [change(one[:, axis], two[:, axis]) for one, two in (centres, forces) for axis in (0, 2)]

    return rows_from(
        ours,
        ("range of the centre of mass, x, change [%]", "-52.2437", 0.2),
        ("range of the centre of mass, y, change [%]", "-8.9392"),
        ("range of the shaking force, x, change [%]", "-49.4824"),
        ("range of the shaking force, y, change [%]", "-2.7584", 1.0),
    )


def shaking_rows() -> Iterator[Row]:
    def ours() -> list[float]:
        turns = [state(name, POINTS, gravity) if not gravity else state(name) for gravity in (0.0, 9.81) for name in NAMES.values()]
        weighted = pp.balancing.with_counterweights(before().press, PAPER)
        reactions = [*(turn.reactions for turn in turns), pp.inverse_dynamics(weighted, pp.cycle(weighted, SPEED, points=720))]
        return [float(np.ptp(each.shaking_moment[:, 1])) for each in reactions]

    kinds = [f"{words}, {when}" for words in ("inertia alone", "with the weights") for when in NAMES]
    names = [f"range of the shaking moment about D, {kind} [N m]" for kind in kinds]
    return rows_from(ours, *unclaimed([*names, "the same, by counterweights as point masses, after [N m]"], 0))


def frame_extremes() -> Table:
    """Extremes of the centre of mass, and of shaking force and moment of inertia alone."""
    weightless = [state(name, POINTS, 0.0) for name in NAMES.values()]
    turn, motion = pp.cycle(before().press, SPEED, points=720), weightless[0].motion
    axes = {"x": 0, "y": 2}
    curves = {
        f"centre of mass, {words} [mm]": (turn, *(1e3 * centre_of_mass(name)[:, axis] for name in NAMES.values()))
        for words, axis in axes.items()
    } | {
        f"shaking force, {words} [kN]": (motion, *(each.reactions.shaking_force[:, axis] / 1e3 for each in weightless))
        for words, axis in axes.items()
    }
    curves["shaking moment about D [kN m]"] = (motion, *(each.reactions.shaking_moment[:, 1] / 1e3 for each in weightless))
    return extremes("without the weight", curves)


@cache
def free_run(inertia: float) -> pp.Run:
    """Two seconds from crank angle 0 at 70 strokes/min, without a motor."""
    return pp.simulate(before().press, 2.0, speed=SPEED, flywheel=pp.drives.Flywheel(inertia))


def run_rows() -> Iterator[Row]:
    for inertia, angle, speed in ((2000.0, "13.0853886242", "7.1703212858"), (500.0, "-0.57766521797", "7.4974476849")):
        words = f"flywheel {inertia:g} kg m2: crank"
        yield from rows_from(
            lambda inertia=inertia: [free_run(inertia).crank_angle[-1], free_run(inertia).crank_speed[-1]],
            (f"{words} angle after 2 s [rad]", angle, 1e-6, SOLVER),
            (f"{words} speed after 2 s [rad/s]", speed, 1e-6, SOLVER),
        )


# ----------------------------------------------------------------------------------------------------------------------- all together

PARTS = (
    Part(
        "Fig. 1: torque of the motor over frequency",
        REPRODUCED,
        [Row("rated torque [N m], from 75 kW at 1485 r/min", "482", lambda: 75e3 / (1485 * RPM), 0.1, places=1)],
    ),
    Part(
        "Gearing: ratios between motor and crank that keep the motor in its printed range",
        BEYOND,
        [
            Row("highest motor speed / lowest", "", lambda: MOTOR_SPEED[1] / MOTOR_SPEED[0], places=3),
            Row("most strokes/min / fewest", "", lambda: STROKES[1] / STROKES[0], places=3),
            Row("least ratio that serves, 724.9 r/min at 50 strokes/min", "", lambda: serving_ratios()[0], places=3),
            Row("largest ratio that serves, 1450 r/min at 70 strokes/min", "", lambda: serving_ratios()[1], places=3),
            Row("ratio from which 70 strokes/min need a weakened field, 1485 r/min", "", lambda: 1485 / STROKES[1], places=3),
        ],
        "Torques are permanent and without losses; the ratio of 25 shows field weakening.",
        [by_ratio, by_belt],
    ),
    Part("Fig. 3: position, velocity, acceleration of the slide", REPRODUCED, tuple(motion_rows())),
    Part("Table 1: masses and centres of mass after balancing", DATA, tuple(mass_rows()), "The model takes these numbers over."),
    Part(
        "Fig. 5, Table 2: driving torque before and after balancing",
        NOT,
        tuple(torque_rows()),
        "M_b is minus the driving torque of pinpress.",
        [torque_extremes],
    ),
    Part(
        "Fig. 6: forces in the bearings A to F",
        NOT,
        tuple(bearing_rows()),
        "Forces of parent on child, in C and F of link 1 on link 2; x across, y up.",
        [bearing_extremes],
    ),
    Part("Table 3: force in bearing A before and after balancing", NOT, tuple(table_rows(ACROSS, UPRIGHT)), "Of the crank on the frame."),
    Part("(18): the weight that it leaves out", BEYOND, tuple(weight_rows()), "", [changes, systems]),
    Part(
        "Conclusion (4): which bearing forces can fall, and at what price",
        BEYOND,
        (),
        "Counterweights within 0.3 m of the shaft, 0.6 m of the rocker's pivot and 0.3 m of the rod's pin, as in"
        " [Balancing](balancing.md); every number is a proved optimum.",
        [lambda: compared(before().press), lambda: priced(before().press)],
    ),
    Part("Reference [20]: centre of mass and shaking force", PARTLY, tuple(balance_rows()), "", [frame_extremes]),
    Part("Shaking moment: range about the rocker's pivot", BEYOND, tuple(shaking_rows()), "It depends on our inertias."),
    Part(
        "Forward dynamics: free runs",
        BEYOND,
        tuple(run_rows()),
        "From crank angle 0 with 70 strokes/min, without a motor. With the light flywheel the crank swings back.",
    ),
)
NO_RESULTS = "Fig. 2, Fig. 4"  # a kinematic model with a photograph, the forces on each link
CHANGES = ("before, range", "after, range", "change of the range [%]")
# Rows of the page for readers: quantities by the number of their part, all of a part if none is named.
MAIN: dict[str, tuple[str, ...]] = {
    "Fig. 1": (),
    "Fig. 3": (
        "stroke [m]",
        "highest speed upwards [m/s]",
        "highest speed downwards [m/s]",
        "largest acceleration upwards [m/s2]",
        "largest acceleration downwards [m/s2]",
        "bottom dead centre [s]",
    ),
    "Fig. 5, Table 2": tuple(f"driving torque M_b [N m], {row}" for row in CHANGES),
    "Table 3": tuple(f"bearing A, {axis} [N], {row}" for axis in ("x", "vertical") for row in CHANGES),
    "(18)": (
        "rms deviation from tables 2 and 3, with G1, our inertias [%]",
        "rms deviation from tables 2 and 3, without G1, inertias zero [%]",
    ),
}


def torque_picture() -> "Figure":
    """Driving torque before and after balancing; dashes: the extremes of table 2."""
    curves = {when: (turn.motion.time, turn.moment / 1e3) for when, turn in (("before", before()), ("after", after()))}
    return draw("time [s]", "M_b [kN m]", curves, [value / 1e3 for pair in PRINTED[MOMENT] for value in pair], high=7.0)


PICTURES = {"kong2025_torque": torque_picture}
