"""Zhang 2007, chapter 5: a counterweight on a rod by its formulas, and searches of the kinds that it names beside the proved optimum."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pinpress.balancing.counterweights import Counterweight, with_counterweights
from pinpress.balancing.optimum import balance
from pinpress.balancing.problem import Range
from pinpress.balancing.regions import CounterweightRegion
from pinpress.common.quantities import Array
from pinpress.kinematics.cycle import cycle
from pinpress.linkage.linkage import Linkage
from pinpress.sweeps.experiments import full_factorial, latin_hypercube
from validation.pages import BEYOND, FORMULAS, PageEntry, Panel, Row, draw
from validation.zhang2007_balancing import POINTS, SEARCH, SPEED, ranges

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MASSES = {"m5": (0.0, 150.0), "m6": (900.0, 1200.0)}  # of auxiliary rod and counterweight, within which is searched; ours [kg]
COUNT, LEVELS = 1000, 32  # points of a search at random; levels of each mass of one on a grid
FIRST_STEP, LAST_STEP = 16.0, 1e-4  # of the search along the coordinates [kg]
MOST_PASSES = 10_000
DISC, AT, TURNED = 0.10, 0.15, np.radians(150.0)  # counterweight of the example: radius, distance from the pin, angle from the rod; ours
FORMULA = "formula"
SPREAD = ("Monte Carlo", "Latin hypercube", "full factorial")  # searches whose points do not depend on what was found


class Search(NamedTuple):
    """What a search has found.

    Attributes:
        masses: (2,) of auxiliary rod and counterweight [kg].
        least: range of the vertical force with them [N].
        ranges: (k,) ranges of all masses tried, in their order [N].
    """

    masses: Array
    least: float
    ranges: Array

    @property
    def evaluations(self) -> int:
        """Number k of masses tried."""
        return len(self.ranges)


def entries(press: Linkage) -> tuple[PageEntry, ...]:
    """(5-3) to (5-6), and the searches, of the opposed press."""
    return (_counterweight(press), _searches(press))


def _counterweight(press: Linkage) -> PageEntry:
    joint = press.model.getJointId("P3")
    rod = press.model.inertias[joint]
    mass, along = rod.mass / 2, np.array([rod.lever[0], rod.lever[2]])
    own, phi = float(np.linalg.norm(along)), float(np.arctan2(along[1], along[0]))
    beta = phi + TURNED
    place = AT * np.array([np.cos(beta), np.sin(beta)])
    # as printed, with the rod's centre l_i at phi and the counterweight's l_b at beta, both in the rod's own axes
    total = rod.mass + mass
    moments = mass * AT * np.sin(TURNED), rod.mass * own + mass * AT * np.cos(TURNED)
    gamma = phi + np.arctan(moments[0] / moments[1])
    eccentric = moments[0] / (total * np.sin(gamma - phi))
    middle = eccentric * np.array([np.cos(gamma), np.sin(gamma)])
    p, q = (float(np.linalg.norm(centre - middle)) for centre in (along, place))
    inertia = rod.inertia[1, 1] + mass * DISC**2 / 2 + rod.mass * p**2 + mass * q**2
    weight = Counterweight("auxiliary_rod", mass, (float(place[0]), 0.0, float(place[1])), inertia=mass * DISC**2 / 2)
    found = with_counterweights(press, [weight]).model.inertias[joint]
    angle, distance = float(np.arctan2(found.lever[2], found.lever[0])), float(np.linalg.norm(found.lever))
    rows = (
        Row("(5-3), mass of both [kg]", f"{total:.4f}", float(found.mass), 1e-3, None, FORMULA),
        Row("(5-4), angle of their centre [deg]", f"{np.degrees(gamma):.4f}", float(np.degrees(angle)), 1e-3, None, FORMULA),
        Row("(5-5), its distance from the pin [mm]", f"{1e3 * eccentric:.4f}", 1e3 * distance, 1e-3, None, FORMULA),
        Row("(5-6), moment of inertia about it [kg m2]", f"{inertia:.6f}", float(found.inertia[1, 1]), 1e-3, None, FORMULA),
    )
    reason = (
        "`with_counterweights` does what (5-3) to (5-6) do. The thesis has no example. Ours: on the auxiliary rod a disc of half its"
        " mass, as 5.5.4 advises, with a radius of 100 mm, 150 mm from the pin, 150 degrees from the rod's own centre. (5-4) finds the"
        " angle only where m l + m_b l_b cos(beta - phi) is positive, and (5-5) is 0 / 0 of a counterweight on the rod's line."
    )
    return PageEntry(("(5-3) to (5-6)",), "a rod with its counterweight", FORMULAS, rows, reason)


def _searches(press: Linkage) -> PageEntry:
    objective = ranges(press)
    found, best = searches(objective), proved(press)
    rows = [Row(f"{name}, range after {each.evaluations} evaluations [N]", "", each.least, places=4) for name, each in found.items()]
    rows += [
        Row(f"{name}, m5 and m6 [kg]", "", f"{each.masses[0]:.3f}, {each.masses[1]:.3f}")
        for name, each in found.items()
        if each.least < 10 * best.least
    ]
    rows += [
        Row("proved optimum, range [N]", "", best.least, places=4),
        Row(
            "masses of table 5-1 after its 17 steps, with our lengths, range [N]",
            "",
            places=2,
            ours=float(objective(np.array([SEARCH[-1][:2]]))[0]),
        ),
    ]

    def shown() -> "Figure":
        curves = {name: (np.arange(1.0, each.evaluations + 1), np.minimum.accumulate(each.ranges)) for name, each in found.items()}
        return draw("evaluations", [Panel("best range so far [N]", curves, (best.least,), logarithmic=True)], 6.5)

    reason = (
        "5.4 names the search along coordinates, the simplex, random directions and others, and uses none of them. Ours, between m5 ="
        " 0 and 150 kg and m6 = 900 and 1200 kg: points at random, evenly spread or on a grid, which 5.4 does not name, find the"
        " valley and no more. A search along one mass after the other stalls there as ADAMS did, because the valley runs along m5 +"
        " m6. The simplex follows it to its end, but proves nothing. The convex program finds the optimum in one solution, tens to"
        " hundreds of times faster (`python tests/benchmarks/features/searches.py`)."
    )
    title = "searches at random, on a grid, step by step, and the proved optimum"
    return PageEntry(("5.4",), title, BEYOND, tuple(rows), reason, "zhang2007_searches", shown, "Dashes: the proved optimum.")


def proved(press: Linkage) -> Search:
    """The optimum of table 5-1's problem by `pinpress.balancing.balance`, one convex program."""
    regions = [CounterweightRegion("auxiliary_rod", replaces=True), CounterweightRegion("counterweight", replaces=True)]
    best = balance(press, cycle(press, SPEED, points=POINTS), regions=regions, minimise=Range("shaking_force", "z"))
    least = float(best.changes[0].after)
    return Search(np.array([weight.mass for weight in best.counterweights]), least, np.array([least]))


def searches(objective: Callable[[Array], Array]) -> Mapping[str, Search]:
    """Searches of an objective, (k,) of masses (k, 2), by the names of their methods."""
    found = {}
    for name in SPREAD:
        masses = tried(name)
        values = objective(masses)
        found[name] = Search(masses[values.argmin()], float(values.min()), values)
    return found | {"step by step": along_coordinates(objective), "simplex": by_simplex(objective)}


def tried(name: str) -> Array:
    """(k, 2) the masses that a search without steps tries [kg]."""
    if name == "full factorial":
        axes = full_factorial(MASSES, LEVELS)
        return np.array(np.meshgrid(*axes.values(), indexing="ij")).reshape(2, -1).T
    if name == "Latin hypercube":
        return np.array(list(latin_hypercube(MASSES, COUNT, seed=1).values())).T
    low, high = np.array(list(MASSES.values())).T
    return np.asarray(np.random.default_rng(1).uniform(low, high, (COUNT, 2)))


def along_coordinates(objective: Callable[[Array], Array]) -> Search:
    """Steps along one mass after the other from the start of table 5-1, halved where neither way leads down."""
    at, step = np.array(SEARCH[0][:2], dtype=float), FIRST_STEP
    value = float(objective(at[None])[0])
    ranges = [value]
    for _ in range(MOST_PASSES):
        before = value
        for way in step * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]):
            ranges.append(float(objective((at + way)[None])[0]))
            if ranges[-1] < value:
                at, value = at + way, ranges[-1]
        if value == before:
            step /= 2
        if step < LAST_STEP:
            break
    return Search(at, value, np.array(ranges))


def by_simplex(objective: Callable[[Array], Array]) -> Search:
    """The simplex method of SciPy from the start of table 5-1."""
    from scipy.optimize import minimize  # slow to import

    ranges: list[float] = []

    def called(at: Array) -> float:
        ranges.append(float(objective(at[None])[0]))
        return ranges[-1]

    options = {"xatol": LAST_STEP, "fatol": 1e-8, "maxfev": 100_000}
    found = minimize(called, np.array(SEARCH[0][:2], dtype=float), method="Nelder-Mead", options=options)
    return Search(found.x, float(found.fun), np.array(ranges))
