"""Kong X. et al. 2025, Forging and Stamping Technology 50(2), 195-203: the six-bar press ZXN2-3000(B), before and after partial balancing.

The moments of inertia are ours, as the paper prints none; the press is not fitted to the tables. `_equation_18` works out what would bring
it nearer to them. The paper's signs: M_b is minus the driving torque, as (11) has -M_b beside moments that are positive counter-clockwise;
the forces in A act from the crank on the frame, though (17) names those of the frame on the crank; x points to the right, y up.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pinpress.balancing.counterweights import with_counterweights
from pinpress.common.quantities import RPM, Array
from pinpress.drives.transmission import Flywheel
from pinpress.dynamics.inverse_dynamics import inverse_dynamics
from pinpress.dynamics.reactions import Reactions
from pinpress.kinematics.cycle import cycle
from pinpress.kinematics.measures import dwell_time
from pinpress.kinematics.motion import Motion
from pinpress.kinematics.slide_path import dead_centres
from pinpress.linkage.linkage import Linkage
from pinpress.linkage.loading import load
from pinpress.loads.link import PointForce
from pinpress.simulation.simulate import simulate
from validation import kong2025_as_printed
from validation.kong2025_counterweights import PAPER, conclusion
from validation.kong2025_drive import gearing_entry, motor_entry
from validation.pages import BEYOND, DATA, FINDINGS, NO_RESULT, NOT, PARTLY, REPRODUCED, Erratum, Grid, Page, PageEntry, Panel, Row, draw

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
WHY_NOT = (
    "The paper prints no moments of inertia, and its equations do not give its tables (see (18)). No physically possible inertias reproduce"
    " the tables, and the press is not fitted to them."
)
SEE = "The reasons are those of Fig. 5."
SOLVER = "independent solver"
PINS = ("A", "B", "C", "D", "E", "F")


@dataclass(frozen=True, eq=False)
class PressTurn:
    """The press before or after balancing, over one turn.

    Attributes:
        press: the press.
        motion: one turn at 70 strokes/min.
        reactions: reactions to it.
    """

    press: Linkage
    motion: Motion
    reactions: Reactions

    @property
    def moment(self) -> Array:
        """M_b (n,), with the paper's sign [N m]."""
        return -self.reactions.driving_torque

    @property
    def on_frame(self) -> Array:
        """Force in A (n, 3), of the crank on the frame [N]."""
        return -self.reactions.bearing_force["A"]

    def columns(self) -> dict[str, Array]:
        """The curves of tables 2 and 3."""
        return {MOMENT: self.moment, ACROSS: self.on_frame[:, 0], UPRIGHT: self.on_frame[:, 2]}


def state(name: str, points: int = POINTS, gravity: float = 9.81) -> PressTurn:
    """A shipped press at 70 strokes/min."""
    press = load(name, gravity=(0, 0, -gravity))
    motion = cycle(press, SPEED, points=points)
    return PressTurn(press, motion, inverse_dynamics(press, motion))


def states() -> tuple[PressTurn, PressTurn]:
    """Before and after balancing."""
    return state("zxn2_3000b"), state("zxn2_3000b_balanced")


def page() -> Page:
    """All tables and figures of the paper."""
    before, after = states()
    return Page(
        "kong2025",
        "Kong 2025: the six-bar press ZXN2-3000(B)",
        "Kong X. et al. 2025, Forging and Stamping Technology 50(2), 195-203 (in Chinese): kinematics, driving torque and bearing"
        " forces of a 3000 kN press at 70 strokes/min, before and after partial balancing by counterweights on crank and rod."
        " `zxn2_3000b` and `zxn2_3000b_balanced`; the moments of inertia, which the paper does not print, are named in these files;"
        " gravity, not printed either, is 9.81 m/s2. We read the paper in a transcription, so a mistake of a letter, a sign or a unit"
        " may be the transcription's. The motion agrees, the forces do not: [(18)](#18-the-weight-that-it-leaves-out) has what we know"
        " of the reasons. Written by `python tests/validation/validate.py kong2025`.",
        (
            motor_entry(),
            gearing_entry(),
            PageEntry(("Fig. 2",), "kinematic model and photograph", NO_RESULT),
            _kinematics(before),
            PageEntry(("Fig. 4",), "forces on each link", NO_RESULT),
            _masses(before, after),
            _torque_figure(before, after),
            _table("Table 2", "driving torque before and after balancing", (MOMENT,), before, after),
            _bearings(before, after),
            _table("Table 3", "force in bearing A before and after balancing", (ACROSS, UPRIGHT), before, after),
            _equation_18(before, after),
            CONCLUSIONS,
            conclusion(before.press),
            _claims(before, after),
            _moments(before, after),
            _runs(before.press),
        ),
        ERRATA,
    )


def _kinematics(before: PressTurn) -> PageEntry:
    motion, ends = before.motion, dead_centres(before.press)
    s, v, a = motion.slide_position, motion.slide_velocity, motion.slide_acceleration
    # crank angles [deg] of the extremes by an independent solution that shares no code with pinpress
    solved = {
        "highest speed upwards": ("97.95280", v),
        "highest speed downwards": ("209.97711", -v),
        "largest acceleration upwards": ("250.75276", a),
        "largest acceleration downwards": ("158.46272", -a),
    }
    rows = (
        Row("highest position [m]", "-0.6583", float(s.max()), 0.1),
        Row("lowest position [m]", "-0.9595", float(s.min()), 0.1),
        Row("stroke [m]", "0.3012", ends.stroke, 0.1),
        Row("highest speed upwards [m/s]", "1.3910", float(v.max()), 0.1),
        Row("highest speed downwards [m/s]", "-1.4690", float(v.min()), 0.1),
        Row("largest acceleration upwards [m/s2]", "8.7040", float(a.max()), 0.1),
        Row("largest acceleration downwards [m/s2]", "-17.8620", float(a.min()), 0.1),
        Row("bottom dead centre [s]", "0.8", ends.bottom_angle / SPEED, 0.5, 4),
        Row("bottom dead centre, crank angle [deg]", "334.52482", float(np.degrees(ends.bottom_angle)), 1e-5, None, SOLVER),
        Row("top dead centre [s]", "", ends.top_angle / SPEED, places=4),
        Row("top dead centre, crank angle [deg]", "155.49688", float(np.degrees(ends.top_angle)), 1e-5, None, SOLVER),
        *(
            Row(f"{what}, crank angle [deg]", angle, largest_at(motion, curve), 1e-4, None, SOLVER)
            for what, (angle, curve) in solved.items()
        ),
        Row("time within 1 mm of bottom dead centre [s]", "", dwell_time(cycle(before.press, SPEED, points=720), 1e-3), places=4),
    )

    def shown() -> "Figure":
        time = motion.time
        panels = (
            Panel("position [m]", {"": (time, s)}, (-0.6583, -0.9595)),
            Panel("velocity [m/s]", {"": (time, v)}, (1.3910, -1.4690)),
            Panel("acceleration [m/s2]", {"": (time, a)}, (8.7040, -17.8620)),
        )
        return draw("time [s]", panels, 3.6)

    caption = "Dashes: the extremes as printed."
    reason = (
        "The paper itself accepts a deviation of 0.5 % (300 mm stroke on the nameplate). Its conclusion (1) speaks of the crank angles of"
        " the largest speeds and accelerations, but prints none; ours stand below. The position has its extremes at the dead centres."
    )
    return PageEntry(
        ("Fig. 3",), "position, velocity, acceleration of the slide", REPRODUCED, rows, reason, "kong2025_slide", shown, caption
    )


def largest_at(motion: Motion, curve: Array) -> float:
    """Crank angle [deg] at which a curve (n,) over a turn is largest, by the parabola through the largest value and its neighbours."""
    top = int(curve.argmax())
    low, high, next_low = (float(curve[(top + k) % len(curve)]) for k in (-1, 0, 1))
    beyond = 0.5 * (low - next_low) / (low - 2 * high + next_low)
    return float(np.degrees(motion.crank_angle[top]) + 360.0 / len(curve) * beyond) % 360.0


def _masses(before: PressTurn, after: PressTurn) -> PageEntry:
    def body(each: PressTurn, joint: str) -> tuple[float, float]:
        inertia = each.press.model.inertias[each.press.model.getJointId(joint)]
        return float(inertia.mass), float(inertia.lever[0])

    rows, words = [], []
    for joint, link, mass, centre in (("A", "crank", "1614.656", "-0.0181"), ("E", "rod", "333.216", "0.1924")):
        (m1, c1), (m2, c2) = body(before, joint), body(after, joint)
        rows += [Row(f"mass of the {link} [kg]", mass, m2), Row(f"centre of mass of the {link} from its first pin [m]", centre, c2)]
        words.append(f"{m2 - m1:.3f} kg at {(m2 * c2 - m1 * c1) / (m2 - m1):.4f} m on the {link}")
    reason = (
        f"The model takes these numbers over. The differences from the press before balancing are counterweights of {words[0]} and"
        f" {words[1]}."
    )
    return PageEntry(("Table 1",), "masses and centres of mass after balancing", DATA, tuple(rows), reason)


def _table(number: str, title: str, names: tuple[str, ...], before: PressTurn, after: PressTurn) -> PageEntry:
    rows = []
    for name in names:
        curves = before.columns()[name], after.columns()[name]
        for when, curve, (most, least), width in zip(("before", "after"), curves, PRINTED[name], RANGES[name], strict=True):
            rows += [
                Row(f"{name}, {when}, maximum", str(most), float(curve.max())),
                Row(f"{name}, {when}, minimum", str(least), float(curve.min())),
                Row(f"{name}, {when}, range", str(width), float(np.ptp(curve))),
            ]
        change = 100 * (np.ptp(curves[1]) / np.ptp(curves[0]) - 1)
        rows.append(Row(f"{name}, change of the range [%]", REDUCTION[name], float(change), places=2))
    if ACROSS in names:
        direction = (
            "(17) names F01, of the frame on the crank, whose extremes stand in Fig. 6. The rows below have the crank on the frame,"
            " which comes nearer to the printed vertical forces; across, neither is near."
        )
        return PageEntry((number,), title, NOT, tuple(rows), f"{SEE} {direction}")
    direction = (
        "(11) has -M_b beside moments that are positive counter-clockwise. So M_b is minus the driving torque of pinpress, which"
        " stands below the rows."
    )
    heads = ("torque [kN m]", *(f"{end}, {when}" for when in ("before", "after") for end in ("largest", "smallest")))
    turns = [("M_b", 1.0), ("`driving_torque`", -1.0)]
    both = tuple(
        (words, *(end for each in (before, after) for end in _ends(each.motion, sign / 1e3 * each.moment))) for words, sign in turns
    )
    return PageEntry((number,), title, NOT, tuple(rows), f"{SEE} {direction}", grids=(Grid(heads, both),))


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


def parts(given: PressTurn) -> CurveParts:
    """The parts of a press before or after balancing."""
    whole = _curves(given.press, given.motion, ())
    crank = given.press.model.inertias[given.press.model.getJointId("A")]
    x, y, z = crank.lever.tolist()
    holding = PointForce("crank", (0.0, 0.0, 9.81 * crank.mass), (x, y, z))
    weight = whole - _curves(given.press, given.motion, [holding])
    inertia = np.array([whole - _curves(_without_inertia(given.press, joint), given.motion, ()) for joint in TURNING])
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
    for each, when, third in zip(pair, (0, 1), (rod, balanced_rod), strict=True):
        curves = each.rest + weight * each.weight + np.tensordot([coupler, rocker, third], each.inertia, 1)
        for curve, printed in zip(curves, PRINTED.values(), strict=True):
            most, least = printed[when]
            deviations += [(curve.max() - most) / np.subtract(*printed[0]), (curve.min() - least) / np.subtract(*printed[0])]
    return float(100 * np.sqrt(np.mean(np.square(deviations))))


def least_deviation(pair: Sequence[CurveParts], weight: float) -> float:
    """The least `rms_deviation` [%] for any inertias that are not negative, searched from the shipped ones."""
    from scipy.optimize import minimize  # slow to import

    # every tenth state is enough to search
    coarse = [CurveParts(each.rest[:, ::10], each.weight[:, ::10], each.inertia[:, :, ::10]) for each in pair]
    # extremes have corners, where other crank angles take over: a search without gradients
    found = minimize(lambda shares: rms_deviation(coarse, weight, shares), np.ones(4), method="Nelder-Mead", bounds=[(0.0, None)] * 4)
    return rms_deviation(pair, weight, found.x)


def _equation_18(before: PressTurn, after: PressTurn) -> PageEntry:
    """Which of the printed numbers hold the crank's weight, which (18) leaves out, and what the printed equations give."""
    pair = [parts(each) for each in (before, after)]
    rows: list[Row] = []
    for words, weight in (("with G1", 1.0), ("without G1", 0.0)):
        rows += [
            Row(f"rms deviation from tables 2 and 3, {words}, our inertias [%]", "", rms_deviation(pair, weight, np.ones(4)), places=2),
            Row(f"the same, {words}, inertias zero [%]", "", rms_deviation(pair, weight, np.zeros(4)), places=2),
            Row(f"the same, {words}, the best of all inertias [%]", "", least_deviation(pair, weight), places=2),
        ]
    printed = kong2025_as_printed.slide_acceleration(before.press)
    rows += [
        Row("largest acceleration of the slide by (10) as printed [m/s2]; Fig. 3 prints 8.7040", "", float(printed.max()), places=4),
        Row("the smallest; Fig. 3 prints -17.8620", "", float(printed.min()), places=4),
    ]
    reason = (
        "(18) lists no G1, the weight of the crank. The balancing changes the crank's mass, so the changes of the extremes show which"
        " numbers hold G1 (first table): the torque seems to, the vertical force in A not. The rows have the root mean square of the"
        " deviations of the twelve extremes in tables 2 and 3, each by the printed range of its curve before balancing: with G1 no"
        " inertias help, without G1 inertias of zero are the best. The tables do not come from the printed equations (second table):"
        " solved as they stand, (11) to (15) give a third of the torque, and (10) half of the slide's accelerations and less."
    )
    return PageEntry(("(18)",), "the weight that it leaves out", BEYOND, tuple(rows), reason, grids=(_changes(pair), _systems(before)))


def _changes(pair: Sequence[CurveParts]) -> Grid:
    """Changes of the extremes by balancing: as printed, and ours with and without the crank's weight."""
    rows = []
    for place, (name, (before, after)) in enumerate(PRINTED.items()):
        ends = []
        for weight in (1.0, 0.0):
            first, second = (each.rest[place] + weight * each.weight[place] + each.inertia[:, place].sum(axis=0) for each in pair)
            ends.append((second.max() - first.max(), second.min() - first.min()))
        for k, end in enumerate(("maximum", "minimum")):
            rows.append((f"{name}, {end}", f"{after[k] - before[k]:+d}", *(f"{each[k]:+.0f}" for each in ends)))
    return Grid(("change by balancing", "document", "with G1", "without G1"), tuple(rows))


def _systems(before: PressTurn) -> Grid:
    """The extremes of tables 2 and 3 before balancing by the printed equations, and with some of them corrected; our inertias."""
    rows = [("tables 2 and 3", *(str(end) for ends, _ in PRINTED.values() for end in ends))]
    for words, corrected in {
        "(11) to (15) as printed": (),
        "(15) corrected": ("(15)",),
        "(12), (13) corrected": ("(12)", "(13)"),
        "all corrected": kong2025_as_printed.WRONG,
    }.items():
        found = kong2025_as_printed.forces(before.press, corrected)
        curves = found["M_b"], -found["F01x"], -found["F01y"]
        rows.append((words, *(f"{end:.0f}" for curve in curves for end in (curve.max(), curve.min()))))
    heads = ("before balancing", *(f"{name}, {end}" for name in PRINTED for end in ("maximum", "minimum")))
    return Grid(heads, tuple(rows))


def _curves(press: Linkage, motion: Motion, loads: Sequence[PointForce]) -> Array:
    """The curves of tables 2 and 3, (3, n), in the order of `PRINTED`."""
    result = inverse_dynamics(press, motion, loads=loads, bearings=["A"])
    return np.array(list(PressTurn(press, motion, result).columns().values()))


def _without_inertia(press: Linkage, joint: str) -> Linkage:
    """A press whose link at this joint has no moment of inertia about its centre of mass."""
    model = press.model.copy()
    body = model.inertias[model.getJointId(joint)]
    model.inertias[model.getJointId(joint)] = pin.Inertia(body.mass, body.lever, np.zeros((3, 3)))
    return replace(press, model=model)


def _torque_figure(before: PressTurn, after: PressTurn) -> PageEntry:
    def shown() -> "Figure":
        curves = {when: (each.motion.time, each.moment / 1e3) for when, each in (("before", before), ("after", after))}
        return draw("time [s]", [Panel("M_b [kN m]", curves, [value / 1e3 for pair in PRINTED[MOMENT] for value in pair])], 6.0)

    bottom = int(before.motion.slide_position.argmin())
    slope = np.abs(np.gradient(before.moment, before.motion.time))
    rows = (
        Row("M_b at bottom dead centre, before [N m]", "", float(before.moment[bottom]), places=0),
        Row("its slope there, by the steepest [%]", "", float(100 * slope[bottom] / slope.max()), places=1),
    )
    reason = f"Its numbers are those of table 2. {WHY_NOT} As the paper says, the torque changes slowly at bottom dead centre."
    caption = "Dashes: the extremes of table 2."
    return PageEntry(("Fig. 5",), "driving torque before and after balancing", NOT, rows, reason, "kong2025_torque", shown, caption)


def _bearings(before: PressTurn, after: PressTurn) -> PageEntry:
    def shown() -> "Figure":
        panels = []
        for bearing in PINS:
            for axis, words in ((0, "x"), (2, "y")):
                curves = {
                    when: (each.motion.time, each.reactions.bearing_force[bearing][:, axis] / 1e3)
                    for when, each in (("before", before), ("after", after))
                }
                panels.append(Panel(f"{bearing}, F{words} [kN]", curves))
        return draw("time [s]", panels, 3.4, 2)

    rows = []
    for bearing in PINS:
        for axis, words in ((0, "x"), (2, "vertical")):
            ranges = [float(np.ptp(each.reactions.bearing_force[bearing][:, axis])) for each in (before, after)]
            rows.append(Row(f"{bearing}, {words}, change of the range [%]", "", 100 * (ranges[1] / ranges[0] - 1), places=2))
    extremes = Grid(
        ("force [kN]", *(f"{end}, {when}" for when in ("before", "after") for end in ("largest", "smallest"))),
        tuple(
            (f"{bearing}, {words}", *(end for each in (before, after) for end in _ends(each.motion, _in_bearing(each, bearing, axis))))
            for bearing in PINS
            for axis, words in ((0, "x"), (2, "vertical"))
        ),
    )
    bottom = int(before.motion.slide_position.argmin())
    for bearing in "ABC":
        size = np.linalg.norm(before.reactions.bearing_force[bearing], axis=1)
        rows.append(Row(f"{bearing}, force at bottom dead centre by its peak [%]", "", float(100 * size[bottom] / size.max()), places=1))
        rows.append(Row(f"{bearing}, smallest force by its peak [%]", "", float(100 * size.min() / size.max()), places=1))
    reason = (
        f"No numbers are printed except those of table 3. {SEE} Only A changes much, as the paper says. But the forces in all bearings do"
        " not fall (conclusion 4): the ranges in B, C, D and E rise by a quarter to a third of a percent, and in F nothing changes. At"
        " bottom dead centre the forces in A, B and C are small, but they are smallest at another crank angle."
    )
    caption = "Forces of parent on child, in C and F of link 1 on link 2; x across, y up."
    return PageEntry(
        ("Fig. 6",), "forces in the bearings A to F", NOT, tuple(rows), reason, "kong2025_bearings", shown, caption, (extremes,)
    )


def _in_bearing(each: PressTurn, bearing: str, axis: int) -> Array:
    """A component (n,) of a bearing force [kN]."""
    return np.asarray(each.reactions.bearing_force[bearing][:, axis] / 1e3)


def _ends(motion: Motion, curve: Array) -> tuple[str, ...]:
    """Largest and smallest value of a curve (n,) over a turn, with their crank angles."""
    ends = ((curve.max(), largest_at(motion, curve)), (curve.min(), largest_at(motion, -curve)))
    return tuple(f"{value:.2f} at {angle:.1f} deg" for value, angle in ends)


def _ends_on_the_frame(before: PressTurn, after: PressTurn) -> Grid:
    """Extremes of the centre of mass, and of shaking force and moment of inertia alone."""
    weightless = [state(each.press.name, gravity=0.0) for each in (before, after)]
    turn = cycle(before.press, SPEED, points=720)
    centres = [1e3 * _centre_of_mass(each.press) for each in (before, after)]
    curves = {f"centre of mass, {words} [mm]": [(turn, each[:, axis]) for each in centres] for axis, words in ((0, "x"), (2, "y"))}
    curves |= {
        f"shaking force, {words} [kN]": [(each.motion, each.reactions.shaking_force[:, axis] / 1e3) for each in weightless]
        for axis, words in ((0, "x"), (2, "y"))
    }
    curves["shaking moment about D [kN m]"] = [(each.motion, each.reactions.shaking_moment[:, 1] / 1e3) for each in weightless]
    heads = ("without the weight", *(f"{end}, {when}" for when in ("before", "after") for end in ("largest", "smallest")))
    return Grid(heads, tuple((words, *(end for motion, curve in pair for end in _ends(motion, curve))) for words, pair in curves.items()))


def _claims(before: PressTurn, after: PressTurn) -> PageEntry:
    def change(first: Array, second: Array) -> tuple[float, float]:
        across, up = 100 * (np.ptp(second[:, ::2], axis=0) / np.ptp(first[:, ::2], axis=0) - 1)  # y of the world is across the plane
        return float(across), float(up)

    centre = change(_centre_of_mass(before.press), _centre_of_mass(after.press))
    force = change(before.reactions.shaking_force, after.reactions.shaking_force)
    rows = (
        Row("range of the centre of mass, x, change [%]", "-52.2437", centre[0], 0.2),
        Row("range of the centre of mass, y, change [%]", "-8.9392", centre[1]),
        Row("range of the shaking force, x, change [%]", "-49.4824", force[0]),
        Row("range of the shaking force, y, change [%]", "-2.7584", force[1], 1.0),
    )
    reason = (
        "These numbers, quoted from reference [20], depend on lengths, masses and centres of mass alone. Two agree as far as the printed"
        " centres, rounded to 0.1 mm, allow. The other two differ by 3 and 4 %. The shaking moment in the table depends on our inertias."
    )
    title, extremes = "what the balancing does to centre of mass and shaking force", _ends_on_the_frame(before, after)
    return PageEntry(("Reference [20]",), title, PARTLY, rows, reason, grids=(extremes,))


def _centre_of_mass(press: Linkage, points: int = 720) -> Array:
    """The centre of mass of all that moves, (points, 3) over a turn [m]."""
    data = press.model.createData()
    return np.array([pin.centerOfMass(press.model, data, q).copy() for q in cycle(press, SPEED, points=points).q])


def _moments(before: PressTurn, after: PressTurn) -> PageEntry:
    weightless = [state(name, gravity=0.0) for name in ("zxn2_3000b", "zxn2_3000b_balanced")]
    named = (("inertia alone", weightless), ("with the weights", (before, after)))
    rows = tuple(
        Row(f"range of the shaking moment about D, {words}, {when} [N m]", "", float(np.ptp(each.reactions.shaking_moment[:, 1])), places=0)
        for words, pair in named
        for when, each in zip(("before", "after"), pair, strict=True)
    )
    again = inverse_dynamics(press := with_counterweights(before.press, PAPER), cycle(press, SPEED, points=720))
    ours = float(np.ptp(again.shaking_moment[:, 1]))
    rows += (Row("the same, by counterweights as point masses, after [N m]", "", ours, places=0),)
    reason = "The paper does not mention the shaking moment. It falls too, as far as our inertias can say."
    return PageEntry(("Shaking moment",), "range about the rocker's pivot", BEYOND, rows, reason)


def _runs(press: Linkage) -> PageEntry:
    # angle and speed after 2 s by an independent integration that shares no code with pinpress
    solved = {2000.0: ("13.0853886242", "7.1703212858"), 500.0: ("-0.57766521797", "7.4974476849")}
    rows = []
    for inertia, theirs in solved.items():
        run = simulate(press, 2.0, speed=SPEED, flywheel=Flywheel(inertia))
        ends = float(run.crank_angle[-1]), float(run.crank_speed[-1])
        for what, solution, ours in zip(("angle after 2 s [rad]", "speed after 2 s [rad/s]"), theirs, ends, strict=True):
            rows.append(Row(f"flywheel {inertia:g} kg m2: crank {what}", solution, ours, 1e-6, None, SOLVER))
    reason = (
        "The paper has no forward dynamics. These runs start at crank angle 0 with 70 strokes/min, without a motor. With the light"
        " flywheel the crank cannot climb to top dead centre, and swings back."
    )
    return PageEntry(("Forward dynamics",), "free runs", BEYOND, tuple(rows), reason)


CONCLUSIONS = PageEntry(
    ("Conclusions",),
    "by their numbers",
    FINDINGS,
    reason="Conclusion (5), that the work guides similar presses, has nothing to compute.",
    grids=(
        Grid(
            ("", "the paper", "here"),
            (
                (
                    "(1)",
                    "a stroke of 0.3 m; largest speeds and accelerations with their crank angles",
                    "agrees; no angles are printed (Fig. 3)",
                ),
                ("(2)", "equations of all torques and forces", "only corrected ones give a press's forces: errata, (18)"),
                (
                    "(3)",
                    "-1.8713 % of the torque, -2.5013 % and -4.0707 % in A; the rest hardly changes",
                    "-1.72 %, -1.49 %, -3.43 %; agrees",
                ),
                ("(4)", "torque and all bearing forces fall", "the ranges in B to E rise (below)"),
            ),
        ),
    ),
)
ERRATA = (
    Erratum("(3), (5), (8)", "the arm DE at the angle theta3", "it is at theta3 - alpha, alpha = 135 deg"),
    Erratum("(4)", "l_m and l_n with the wrong sign", "l_m + l1 cos(theta1) + l2 cos(theta2) = l31 cos(theta3); with sines and -l_n"),
    Erratum(
        "(10)",
        "the terms of l32 in rows 3 and 4 with the wrong sign; last vector with the first power of omega1",
        "the derivative of (7); its last vector is omega1^2 (-l1 cos(theta1), -l1 sin(theta1), 0, 0)",
    ),
    Erratum("(12)", "moments of F32y and F12x with the wrong sign", "moments about the coupler's centre of mass"),
    Erratum("(13)", "moments of F03y and F43x with the wrong sign", "moments about the rocker's centre of mass"),
    Erratum("(12)-(14)", "a2, a3, a4 called accelerations", "they are angular accelerations"),
    Erratum("(15)", "weight across the slide, inertia along the guide's force", "F45x = F05 across; F45y - G5 = m5 a5 upwards"),
    Erratum("(15), (18)", "inertia and weight of the slide along two axes in (15), along one in (18)", "along one"),
    Erratum("(18)", "no G1", "it belongs to the second entry: see (18) above"),
    Erratum(
        "Conclusion (4)",
        "the balancing lowers all bearing forces",
        "the ranges in B, C, D and E rise a little, see Fig. 6; the vertical one in F cannot fall, see Conclusion (4)",
    ),
)
