"""Zhang 2007, chapters 3 and 5: balancing by formulas, the search of table 5-1, and the press before and after it.

The lengths are inferred. The machines of chapter 1 and other upper dies stand in `zhang2007_arrangements`.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial

import numpy as np
from validation.rows import FORMULA, SOLVER, Row, Table, rows_from

import pinpress as pp
from pinpress import RPM
from pinpress.balancing import Counterweight, CounterweightRegion, Range, Rms, balance, classical, with_counterweights
from pinpress.balancing.problem import Criterion
from pinpress.common.quantities import Array

SPEED = 300 * RPM
GRAVITY = 9.80665
POINTS = 720
FLYWHEEL_MASS = 940.0  # [kg]
RADIUS, LENGTH = 0.015, 0.300  # main crank and rod, inferred [m]
AUXILIARY, AUXILIARY_LENGTH = 0.0297, 0.600  # auxiliary crank and rod, inferred [m]
CRANK, ROD, SLIDE = 52.25, 77.49, 2200.0  # masses of the main crank, rod and slide [kg]
AUXILIARY_CRANK, AUXILIARY_ROD, COUNTERWEIGHT = 18.38, 113.31, 1045.0  # masses of auxiliary crank, rod and counterweight [kg]
ON_CRANK, ON_ROD = 0.15, 0.30  # radii of counterweights on crank and rod; ours, as the thesis prints none [m]
# Table 5-1: masses of auxiliary rod and counterweight [kg], and the range of the vertical force that ADAMS found [N]
SEARCH = (
    (100, 1000, "2887.80"),
    (112.36, 1044.5, "191.57"),
    (112.435, 1044.6, "185.96"),
    (114.095, 1044.6, "183.79"),
    (112.575, 1044.6, "177.42"),
    (112.585, 1044.7, "173.90"),
    (112.645, 1045.2, "169.98"),
    (112.71, 1045.2, "166.69"),
    (113.17, 1045.2, "146.80"),
    (113.18, 1045.2, "145.05"),
    (113.21, 1045, "143.75"),
    (113.225, 1045, "143.01"),
    (113.235, 1045, "142.52"),
    (113.25, 1045.1, "142.08"),
    (113.27, 1045, "140.59"),
    (113.32, 1045, "139.65"),
    (113.31, 1045, "139.07"),
)
QUANTITIES = ("vertical maximum", "vertical minimum", "vertical range", "lateral maximum", "lateral minimum", "lateral range")
# Table 5-2: r/min -> maximum, minimum, range of the vertical force, then of the lateral one [N]
BEFORE = {
    300: ("11621.795", "-65789.563", "66952.358", "3496.454", "-3498.509", "6994.963"),
    350: ("12913.322", "-76331.287", "89244.609", "3884.310", "-3887.903", "7772.213"),
    400: ("14016.972", "-90141.253", "104158.225", "4013.591", "-4016.413", "8030.004"),
}
AFTER = {
    300: ("409.087", "-2315.793", "2724.88", "46.503", "-46.530", "93.033"),
    350: ("486.687", "-2847.461", "3334.148", "49.131", "-49.324", "98.455"),
    400: ("509.916", "-3258.413", "3768.329", "53.710", "-53.729", "107.439"),
}
LENGTHS = {  # radius and rod of the main mechanism, those of the auxiliary one, and the place of its rod's mass centre [mm]
    "inferred": (15.0, 300.0, 29.7, 600.0, 300.0),
    "others": (12.92, 360.5, 25.57, 648.0, 322.0),  # within (5-15) and (5-16)
    "others, r2 0.01 mm longer": (12.92, 360.5, 25.58, 648.0, 322.0),
}
OUT_OF_LINE = 4  # step of table 5-1 whose m5 does not fit those before and after
JOINTS = {"auxiliary_rod": "P3", "counterweight": "counterweight_guide"}


@cache
def press(kind: str) -> pp.Linkage:
    """The JF75G-125 of a kind, under our gravity, as the thesis prints none."""
    return pp.load(f"jf75g_125{kind}", gravity=(0, 0, -GRAVITY))


plain, opposed, symmetric = partial(press, "_plain"), partial(press, ""), partial(press, "_symmetric")


@cache
def turning(press: pp.Linkage, speed: float = SPEED) -> pp.Reactions:
    """Reactions of a turn at constant speed [rad/s]."""
    return pp.inverse_dynamics(press, pp.cycle(press, speed, points=POINTS))


def vertical(press: pp.Linkage, speed: float = SPEED) -> float:
    """Range of the vertical shaking force at constant speed [rad/s], in N."""
    return float(np.ptp(turning(press, speed).shaking_force[:, 2]))


def lateral(press: pp.Linkage) -> float:
    """Range of the lateral shaking force [N]; zero if it is rounding next to the bearing forces."""
    return clean(float(np.ptp(turning(press).shaking_force[:, 0])), bearing_peak(press))


def tilting(press: pp.Linkage) -> float:
    """Range of the tilting moment [N m]; zero if it is rounding."""
    return clean(float(np.ptp(turning(press).shaking_moment[:, 1])), bearing_peak(press))


def bearing_peak(press: pp.Linkage, speed: float = SPEED) -> float:
    """Largest component of a bearing force [N]."""
    return max(float(np.abs(force).max()) for force in turning(press, speed).bearing_force.values())


def weight(press: pp.Linkage) -> float:
    """Weight of all that moves [N]."""
    return GRAVITY * float(sum(inertia.mass for inertia in press.model.inertias))


def clean(value: float, peak: float) -> float:
    """The value, zero where it is rounding next to a peak."""
    return value if abs(value) > 1e-9 * abs(peak) else 0.0


# --------------------------------------------------------------------------------------------------------------- chapter 3, by formulas


def rotor_rows() -> Iterator[Row]:
    masses, places, planes = [2.0, -1.2], [[0.10, 0.05, 0.0], [0.0, 0.20, 0.15]], (0.0, 0.30)
    products = [np.array([0.2, 0.0]), np.array([0.0, -0.18])]  # m r, across the shaft [kg m]
    far = [(0.30 - y) / 0.30 for y in (0.05, 0.20)]  # share of each in the first plane
    by_hand = [
        np.linalg.norm(products[0] + products[1]),
        np.linalg.norm(sum(share * product for share, product in zip(far, products, strict=True))),
        np.linalg.norm(sum((1 - share) * product for share, product in zip(far, products, strict=True))),
    ]

    def ours() -> list[float]:
        weights = classical.static_balance(masses, places), *classical.two_plane_balance(masses, places, planes=planes)
        return [float(np.linalg.norm(weight.product)) for weight in weights]

    names = ("in one plane (3.1.5)", "in two planes, first", "in two planes, second")
    rows = ((f"mass times radius {name} [kg m]", f"{hand:.6f}", 1e-3, FORMULA) for name, hand in zip(names, by_hand, strict=True))
    return rows_from(ours, *rows)


def slide_rows() -> Iterator[Row]:
    angle = np.radians(np.arange(POINTS) * 360.0 / POINTS)
    formula = SPEED**2 * RADIUS * (np.cos(angle) + RADIUS / LENGTH * np.cos(2 * angle))  # (3.2.2)
    degrees = (0, 60, 120, 180)
    places = [each * POINTS // 360 for each in degrees]

    def ours() -> list[float]:
        motion = turning(plain()).motion
        error = np.abs(formula - motion.slide_acceleration).max()
        return [*motion.slide_acceleration[places], error, 1e3 * np.ptp(motion.slide_position)]

    names = (f"acceleration at {each} deg from bottom dead centre [m/s2]" for each in degrees)
    return rows_from(
        ours,
        *((name, f"{formula[k]:.4f}", 0.05, FORMULA) for name, k in zip(names, places, strict=True)),
        ("largest error of (3.2.2) over the turn [m/s2]", "", None, "", 4),
        ("stroke [mm]", "", None, "", 2),
    )


def complete_rows() -> Iterator[Row]:
    on_rod = (ROD * LENGTH / 2 + SLIDE * LENGTH) / ON_ROD
    right = ((on_rod + ROD + SLIDE) * RADIUS + CRANK * RADIUS) / ON_CRANK
    wrong = (ROD * RADIUS + CRANK * RADIUS) / ON_CRANK  # as our text reads

    def ours() -> list[float]:
        rod, crank = classical.complete_balance(plain(), rod_radius=ON_ROD, crank_radius=ON_CRANK)
        as_read = Counterweight("crank", wrong, crank.position)
        left = [clean(vertical(with_counterweights(plain(), [rod, other])), vertical(plain())) for other in (crank, as_read)]
        return [rod.mass, crank.mass, wrong, vertical(plain()), *left]

    return rows_from(
        ours,
        ("m'' on the rod [kg]", f"{on_rod:.3f}", 1e-3, FORMULA),
        ("m' on the crank, corrected [kg]", f"{right:.3f}", 1e-3, FORMULA),
        ("m' on the crank, as our text reads [kg]", "", None, "", 3),
        ("range of the vertical shaking force without balancing [N]", "", None, "", 0),
        ("with both, m' corrected [N]", "0", 0, FORMULA),
        ("with both, m' as our text reads [N]", "", None, "", 0),
    )


def approximate_rows() -> Iterator[Row]:
    reciprocating = SLIDE + ROD / 2
    turns = RADIUS / ON_CRANK * (CRANK + ROD / 2)
    force = reciprocating * RADIUS * SPEED**2

    def ours() -> list[float]:
        whole, half = (classical.approximate_balance(plain(), ON_CRANK, share=part) for part in (1.0, 0.5))
        left = [whole.mass]
        for weight in (whole, half):
            after = turning(with_counterweights(plain(), [weight]))
            changes = {(c.quantity, c.order): c.after for c in classical.compare_harmonics(turning(plain()), after)}
            left += [clean(changes[f"force {way} the slide", 1], force) for way in ("along", "across")]
        return left

    return rows_from(
        ours,
        ("m' + m'' on the crank [kg]", f"{turns + RADIUS / ON_CRANK * reciprocating:.3f}", 1e-3, FORMULA),
        ("first order along the slide after it [N]", "0", 0, FORMULA),
        ("first order across the slide after it [N]", f"{force:.1f}", 0.1, FORMULA),
        ("half of m'': first order along the slide [N]", f"{force / 2:.1f}", 0.1, FORMULA),
        ("half of m'': first order across the slide [N]", f"{force / 2:.1f}", 0.1, FORMULA),
    )


def opposed_rows() -> Iterator[Row]:
    by_hand = (SLIDE + ROD / 2) * RADIUS / AUXILIARY - AUXILIARY_ROD / 2

    def ours() -> list[float]:
        press = classical.with_opposed_balancer(plain(), AUXILIARY, rod_length=AUXILIARY_LENGTH, rod_mass=AUXILIARY_ROD)
        built = press.model.inertias[press.model.getJointId("counterweight_guide")].mass
        forces = vertical(plain()), vertical(press), lateral(press), vertical(opposed()), lateral(opposed())
        return [float(built), *forces]

    return rows_from(
        ours,
        ("m6 with an auxiliary rod of 113.31 kg [kg]", f"{by_hand:.2f}", 1e-2, FORMULA),
        ("range of the vertical shaking force without [N]", "", None, "", 0),
        ("range of the vertical shaking force with it [N]", "", None, "", 2),
        ("range of the lateral shaking force with it [N]", "", None, "", 2),
        ("masses of table 5-1 instead, vertical [N]", "", None, "", 2),
        ("masses of table 5-1 instead, lateral [N]", "", None, "", 2),
    )


def guide_rows() -> Iterator[Row]:
    centre = (ROD * LENGTH / 2 + SLIDE * LENGTH) / (ROD + SLIDE)
    simple = (ROD + SLIDE) * GRAVITY * centre / LENGTH * np.tan(np.arcsin(RADIUS / LENGTH))
    words = "peak of X4, the force in the slide's guide, by (3.5.24) [N]"
    yield Row(words, f"{simple:.0f}", lambda: np.abs(turning(plain()).bearing_force["slide_guide"][:, 0]).max(), None, FORMULA)


def symmetric_rows() -> Iterator[Row]:
    def ours() -> list[float]:
        return [measure(press()) for measure in (lateral, tilting, vertical) for press in (opposed, symmetric)]

    return rows_from(
        ours,
        ("range of the lateral shaking force, opposed [N]", "", None, "", 1),
        ("range of the lateral shaking force, symmetric [N]", "0", 0, FORMULA),
        ("range of the tilting moment, opposed [N m]", "", None, "", 1),
        ("range of the tilting moment, symmetric [N m]", "0", 0, FORMULA),
        ("range of the vertical shaking force, opposed [N]", "", None, "", 2),
        ("range of the vertical shaking force, symmetric [N]", "", None, "", 2),
    )


# ---------------------------------------------------------------------------------------------------------- chapter 5, masses and forces


def ranges(press: pp.Linkage) -> Callable[[Array], Array]:
    """The function from (k, 2) masses of auxiliary rod and counterweight [kg] of the opposed press to (k,) ranges of its vertical force at
    300 strokes/min [N]. Forces are linear in the masses, so that three presses are enough for all.
    """
    corners = ((100.0, 1000.0), (120.0, 1000.0), (100.0, 1100.0))
    force, with_rod, with_counterweight = (turning(with_masses(press, *corner)).shaking_force[:, 2] for corner in corners)
    rod, counterweight = (with_rod - force) / 20.0, (with_counterweight - force) / 100.0

    def of_masses(masses: Array) -> Array:
        return np.asarray(np.ptp(force + np.outer(masses[:, 0] - 100.0, rod) + np.outer(masses[:, 1] - 1000.0, counterweight), axis=1))

    return of_masses


def with_masses(press: pp.Linkage, rod: float, counterweight: float) -> pp.Linkage:
    """The opposed press with other masses of its auxiliary rod, whose shape stays, and of its counterweight [kg]."""
    old = {link: press.model.inertias[press.model.getJointId(joint)] for link, joint in JOINTS.items()}
    change, lever = rod - old["auxiliary_rod"].mass, old["auxiliary_rod"].lever
    shape = old["auxiliary_rod"].inertia[1, 1] / old["auxiliary_rod"].mass
    x, y, z = (float(place) for place in lever)
    return with_counterweights(
        press,
        [
            Counterweight("auxiliary_rod", change, (x, y, z), float(shape * change)),
            Counterweight("counterweight", counterweight - old["counterweight"].mass),
        ],
    )


@cache
def proved() -> tuple[Array, float]:
    """Masses [kg] and range [N] of the optimum of table 5-1's problem, by one convex program."""
    regions = [CounterweightRegion(link, replaces=True) for link in JOINTS]
    best = balance(opposed(), pp.cycle(opposed(), SPEED, points=POINTS), regions=regions, minimise=Range("shaking_force", "z"))
    return np.array([weight.mass for weight in best.counterweights]), float(best.changes[0].after)


def objective_rows() -> Iterator[Row]:
    def ratios(press: pp.Linkage) -> list[float]:
        x, y, z = plain().model.jointPlacements[plain().model.getJointId("O")].translation.tolist()
        criteria: list[Criterion] = [
            Rms("shaking_force", "z"),
            Range("shaking_force", "z"),
            Rms("shaking_moment", "y", about=(x, y, z)),
            Range("shaking_moment", "y", about=(x, y, z)),
        ]
        values = [clean(criterion.value(turning(press)) / criterion.value(turning(plain())), 1.0) for criterion in criteria]
        return [*values, sum(values) / 4]

    for press, words in ((opposed, "opposed"), (symmetric, "symmetric")):
        names = [f"{what} of the {of}, {words} by plain" for of in ("vertical force", "tilting moment") for what in ("rms", "fluctuation")]
        rows = ((name, "", None, "", 4) for name in (*names, f"objective, {words}"))
        yield from rows_from(lambda press=press: ratios(press()), *rows)


def search_rows() -> Iterator[Row]:
    masses = np.array([step[:2] for step in SEARCH])
    steps = (
        (f"step {k}, m5 = {rod:g} kg, m6 = {counterweight:g} kg [N]", printed) for k, (rod, counterweight, printed) in enumerate(SEARCH, 1)
    )
    yield from rows_from(lambda: ranges(opposed())(masses).tolist(), *steps)
    yield Row("optimum, m5 [kg]", "32.2837", lambda: proved()[0][0], 0.01, SOLVER, 3)
    yield Row("optimum, m6 [kg]", "1125.9727", lambda: proved()[0][1], 0.001, SOLVER, 3)
    yield Row("optimum, range [N]", "0.04138", lambda: proved()[1], 0.2, SOLVER, 4)


def closed_form_ranges(lengths: Sequence[float], masses: Array) -> Array:
    """(k,) ranges of the vertical force of the opposed press [N] with lengths as in `LENGTHS` and masses (k, 2) of auxiliary rod and
    counterweight, at 300 strokes/min. The cranks' mass centres are at their pins, the main rod's is half-way.
    """
    r1, l1, r2, l2, centre = (1e-3 * length for length in lengths)
    angle = np.linspace(0.0, 2 * np.pi, 7201)

    def accelerations(radius: float, rod: float) -> tuple[Array, Array]:
        """Of the crank's pin and of the slide, along the slide's line."""
        ratio = radius / rod
        root = np.sqrt(1 - (ratio * np.sin(angle)) ** 2)
        pin = -(SPEED**2) * radius * np.cos(angle)
        obliquity = np.cos(2 * angle) / root + (ratio * np.sin(2 * angle)) ** 2 / (4 * root**3)
        return pin, pin - SPEED**2 * rod * ratio**2 * obliquity

    (pin1, slide1), (pin2, slide2) = accelerations(r1, l1), accelerations(r2, l2)
    main = CRANK * pin1 + ROD * (pin1 + slide1) / 2 + SLIDE * slide1
    rod = (1 - centre / l2) * pin2 + centre / l2 * slide2
    return np.asarray(np.ptp(main - AUXILIARY_CRANK * pin2 - np.outer(masses[:, 0], rod) - np.outer(masses[:, 1], slide2), axis=1))


def other_lengths() -> Table:
    """How near the steps of table 5-1 come to the printed ranges with other lengths."""
    masses, printed = np.array([step[:2] for step in SEARCH]), np.array([float(step[2]) for step in SEARCH])
    rows = []
    for words, lengths in LENGTHS.items():
        ours = closed_form_ranges(lengths, masses)
        deviation = 100 * (ours / printed - 1)
        largest = np.abs(np.delete(deviation, OUT_OF_LINE - 1)).max()
        listed = ", ".join(f"{length:g}" for length in lengths)
        ends = (f"{ours[k - 1]:.0f}" for k in (1, 2, 17))
        rows.append((words, listed, *ends, f"{largest:.1f}", f"{deviation[OUT_OF_LINE - 1]:.1f}"))
    heads = ("lengths", "r1, l1, r2, l2, centre of rod [mm]", "step 1 [N]", "step 2", "step 17", "most but step 4 [%]", "step 4 [%]")
    return Table(heads, tuple(rows))


def extremes(press: pp.Linkage, rpm: int, lift: float) -> list[float]:
    """`QUANTITIES` of the shaking force [N] at a speed [r/min], after a constant is added to the vertical force."""
    force, peak = turning(press, rpm * RPM).shaking_force, bearing_peak(press, rpm * RPM)
    axes = force[:, 2] + lift, force[:, 0]
    return [clean(float(extreme(axis)), peak) for axis in axes for extreme in (np.max, np.min, np.ptp)]


def original(rpm: int) -> list[float]:
    """The original's forces include the weights of what moves, as the shaking force does, and of the flywheel."""
    return extremes(plain(), rpm, -FLYWHEEL_MASS * GRAVITY)


def improved(rpm: int) -> list[float]:
    """The improved press's forces include no weight."""
    return extremes(symmetric(), rpm, weight(symmetric()))


def idle_rows() -> Iterator[Row]:
    """Figure 5-11."""
    words = ("vertical force, maximum [N]", "vertical force, minimum [N]", "vertical force, range [N]", "lateral force, range [N]")
    places = [QUANTITIES.index(name) for name in ("vertical maximum", "vertical minimum", "vertical range", "lateral range")]
    printed = (AFTER[300][k] for k in places)
    return rows_from(lambda: [improved(300)[k] for k in places], *zip(words, printed, strict=True))


def comparison_rows() -> Iterator[Row]:
    """Table 5-2, the weights that its extremes hold, and how its ranges grow with the speed."""
    for name, printed, ours in (("original", BEFORE, original), ("improved", AFTER, improved)):
        for rpm, numbers in printed.items():
            quantities = (f"{name}, {rpm} r/min, {quantity} [N]" for quantity in QUANTITIES)
            yield from rows_from(lambda ours=ours, rpm=rpm: ours(rpm), *zip(quantities, numbers, strict=True))
    for rpm in BEFORE:
        words = f"original, {rpm} r/min, weight by the middle of the printed extremes [N]"
        yield Row(words, "", lambda rpm=rpm: middle_weight(rpm), places=0)
    yield Row("weight of what moves in the original [N]", "", lambda: weight(plain()), places=0)
    yield Row("weight of the flywheel [N]", "", lambda: FLYWHEEL_MASS * GRAVITY, places=0)
    for words, lifted in (("without the weight of the flywheel", 0.0), ("without any weight", 1.0)):
        names = (f"original, 300 r/min, vertical {end} {words} [N]" for end in ("maximum", "minimum"))
        ends = zip(names, BEFORE[300][:2], strict=True)
        yield from rows_from(lambda lifted=lifted: extremes(plain(), 300, lifted * weight(plain()))[:2], *ends)
    counterweighted = "original with its counterweight, 300 r/min"
    yield Row(f"{counterweighted}, vertical range [N]", BEFORE[300][2], lambda: vertical(opposed()))
    yield Row(f"{counterweighted}, lateral range [N]", BEFORE[300][5], lambda: lateral(opposed()))
    for place, way, gained in ((2, "vertical", "24.57"), (5, "lateral", "75.19")):
        words = f"300 r/min, {way} range before by after"
        yield Row(f"{words}, from the printed ranges", gained, lambda place=place: float(BEFORE[300][place]) / float(AFTER[300][place]))
        yield Row(words, gained, lambda place=place: gain(place))
    yield from growth_rows()


def middle_weight(rpm: int) -> float:
    """The weight on which the middle of the printed extremes lies [N]; our extremes include weights."""
    highest, lowest = (float(number) for number in BEFORE[rpm][:2])
    included = weight(plain()) + FLYWHEEL_MASS * GRAVITY
    return 0.5 * (sum(original(rpm)[:2]) + 2 * included - highest - lowest)


def gain(place: int) -> float | str:
    """By what a range at 300 r/min became smaller, as the conclusion of 5.7.2 has it."""
    after = improved(300)[place]
    return original(300)[place] / after if after else "no force after"


def growth_rows() -> Iterator[Row]:
    """How lateral ranges grow from 300 to 400 r/min: of the whole press, and in the bearing of the main shaft."""

    def shaking(rpm: int) -> float:
        return float(np.ptp(turning(plain(), rpm * RPM).shaking_force[:, 0]))

    def bearing(rpm: int) -> float:
        return float(np.ptp(turning(opposed(), rpm * RPM).bearing_force["O"][:, 0]))

    ratio, source = f"{float(BEFORE[400][5]) / float(BEFORE[300][5]):.3f}", "of the printed ranges"
    yield Row("original, lateral range at 400 by that at 300 r/min", ratio, lambda: shaking(400) / shaking(300), None, source)
    words = "original with its counterweight, lateral range in the bearing of the main shaft at 400 by that at 300 r/min"
    yield Row(words, ratio, lambda: bearing(400) / bearing(300), None, source)
    yield Row("the same at 300 r/min [N]", BEFORE[300][5], lambda: bearing(300))


def readings() -> Table:
    """What follows from either reading of table 5-2 at 300 r/min."""
    (first, least, width, across, *_), (second, _, _, aside, *_) = ([float(number) for number in BEFORE[rpm]] for rpm in (300, 350))
    widest, after, ours = float(BEFORE[400][2]), float(AFTER[300][2]), original(300)[2]
    rows = []
    for words, most, span in (("maximum as printed", first, first - least), ("range as printed", least + width, width)):
        ratios = f"{most / across:.4f}", f"{second / aside:.4f}", f"{second / most:.4f}", f"{aside / across:.4f}"
        last = f"{widest / span:.4f}", f"{span / after:.2f}", f"{100 * (ours / span - 1):+.1f}"
        rows.append((words, f"{most:.3f}", f"{span:.3f}", *ratios, *last))
    heads = (
        "original, 300 r/min",
        "maximum [N]",
        "range [N]",
        "vertical by lateral maximum",
        "at 350 r/min",
        "vertical maximum, 350 by 300 r/min",
        "lateral maximum",
        "range, 400 by 300 r/min",
        "before by after",
        "ours [%]",
    )
    return Table(heads, tuple(rows))


DISC, AT, TURNED = 0.10, 0.15, np.radians(150.0)  # counterweight of the example: radius, distance from the pin, angle from the rod; ours


def rod_rows() -> Iterator[Row]:
    """(5-3) to (5-6) as printed, with the rod's centre l_i at phi and the counterweight's l_b at beta, both in the rod's axes."""
    mass, own = AUXILIARY_ROD / 2, AUXILIARY_LENGTH / 2  # the rod's centre lies on its axis: phi = 0
    total = AUXILIARY_ROD + mass
    across, along = mass * AT * np.sin(TURNED), AUXILIARY_ROD * own + mass * AT * np.cos(TURNED)
    gamma = np.arctan(across / along)
    eccentric = across / (total * np.sin(gamma))
    middle = eccentric * np.array([np.cos(gamma), np.sin(gamma)])
    place = AT * np.array([np.cos(TURNED), np.sin(TURNED)])
    p, q = (float(np.linalg.norm(centre - middle)) for centre in ((own, 0.0), place))
    inertia = AUXILIARY_ROD * AUXILIARY_LENGTH**2 / 12 + mass * DISC**2 / 2 + AUXILIARY_ROD * p**2 + mass * q**2

    def ours() -> list[float]:
        weight = Counterweight("auxiliary_rod", mass, (float(place[0]), 0.0, float(place[1])), inertia=mass * DISC**2 / 2)
        press = with_counterweights(opposed(), [weight])
        body = press.model.inertias[press.model.getJointId("P3")]
        angle = np.degrees(np.arctan2(body.lever[2], body.lever[0]))
        return [float(body.mass), float(angle), 1e3 * float(np.linalg.norm(body.lever)), float(body.inertia[1, 1])]

    return rows_from(
        ours,
        ("(5-3), mass of both [kg]", f"{total:.4f}", 1e-3, FORMULA),
        ("(5-4), angle of their centre [deg]", f"{np.degrees(gamma):.4f}", 1e-3, FORMULA),
        ("(5-5), its distance from the pin [mm]", f"{1e3 * eccentric:.4f}", 1e-3, FORMULA),
        ("(5-6), moment of inertia about it [kg m2]", f"{inertia:.6f}", 1e-3, FORMULA),
    )
