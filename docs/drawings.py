"""The drawings of docs/engines.md and docs/errors.md, into docs/drawings: what the two pages explain, on the six-bar press."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from make import DOCS, load, write
from matplotlib.figure import Figure

import pinpress as pp

PICTURES = load("pictures")
SPEED, pins, six_bar = PICTURES.SPEED, PICTURES.pins, PICTURES.six_bar

COLOURS = {"crank": "#D55E00", "coupler": "#0072B2", "rocker": "#009E73", "rod": "#CC79A7", "slide": "#555555", "frame": "#000000"}
CORNERS = {"crank": "AB", "coupler": "BC", "rocker": "DCED", "rod": "EF"}
CUT, GREY = "#B3392B", "#8a8a8a"
ANGLE = np.radians(40.0)
PRESSED = np.radians(272.0)  # under the drawing load


def tree() -> Figure:
    """The six-bar with its two loops, and the same as a tree of joints with two bearings cut."""
    figure = Figure(figsize=(6.6, 3.7), layout="constrained")
    drawn, graph = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    places = pins(ANGLE)
    for corners, name, at in (("ABCD", "loop C", (0.62, 0.0)), ("DEF", "loop F", (-0.10, -0.42))):
        drawn.fill(*np.array([places[corner] for corner in corners]).T, color="#f0e442", alpha=0.35, linewidth=0)
        drawn.annotate(name, at, color=GREY, ha="center", fontsize=9)
    _links(drawn, places)
    drawn.add_patch(_slide(places["F"]))
    drawn.set_title("the press: two bearings close loops", fontsize=9)
    for name, place in places.items():
        _pin(drawn, name, place, CUT if name in "CF" else "black")
    boxes = {"frame": (1.0, 3.0), "crank": (0.0, 2.0), "coupler": (0.0, 1.0), "rocker": (1.0, 2.0), "rod": (1.0, 1.0), "slide": (2.0, 2.0)}
    for parent, child, joint in (("frame", "crank", "A"), ("frame", "rocker", "D"), ("frame", "slide", "slide_guide")):
        _branch(graph, boxes[parent], boxes[child], joint)
    for parent, child, joint in (("crank", "coupler", "B"), ("rocker", "rod", "E")):
        _branch(graph, boxes[parent], boxes[child], joint)
    for one, two, loop, bend in (("coupler", "rocker", "C", -0.15), ("rod", "slide", "F", -0.15)):
        style = {"arrowstyle": "-", "color": CUT, "linestyle": "--", "linewidth": 1.6, "connectionstyle": f"arc3,rad={-bend}"}
        graph.annotate("", boxes[two], boxes[one], arrowprops=style | {"shrinkA": 16, "shrinkB": 12})
        middle = (np.array(boxes[one]) + boxes[two]) / 2
        graph.annotate(loop, (middle[0] + 0.13, middle[1] - 0.17), color=CUT, fontsize=10, ha="center")
    for name, (x, y) in boxes.items():
        box = {"boxstyle": "round,pad=0.35", "facecolor": "white", "edgecolor": COLOURS[name], "linewidth": 1.6}
        graph.text(x, y, name, ha="center", va="center", fontsize=9, bbox=box)
    graph.set(xlim=(-0.5, 2.5), ylim=(0.5, 3.5))
    graph.set_title("the tree: C and F are cut", fontsize=9)
    for axes in (drawn, graph):
        axes.set_axis_off()
    drawn.set_aspect("equal")
    return figure


def dyads() -> Figure:
    """The two dyads of the six-bar, each closed by one root: two circles, and a circle and a line."""
    figure = Figure(figsize=(6.6, 3.4), layout="constrained")
    first, second = figure.subplots(1, 2)
    places = pins(ANGLE)
    for axes, pair, at in ((first, (("B", "coupler"), ("D", "rocker")), "C"), (second, (("E", "rod"),), "F")):
        for name, link in pair:
            _arc(axes, places[name], places[at] - places[name], COLOURS[link])
            axes.plot(*np.array([places[name], places[at]]).T, color=COLOURS[link], linewidth=3)
            _pin(axes, name, places[name])
    b, d, e = places["B"], places["D"], places["E"]
    along = (d - b) / np.linalg.norm(d - b)
    across = places["C"] - b - along * (along @ (places["C"] - b))
    _other(first, places["C"] - 2 * across)
    first.plot(*np.array([places["A"], b]).T, color=COLOURS["crank"], linewidth=3)
    _pin(first, "A", places["A"])
    _pin(first, "C", places["C"], CUT)
    first.set_title("1. crank known: C is where two circles meet", fontsize=9)
    second.axvline(0.0, color=COLOURS["slide"], linestyle="--", linewidth=1)
    _other(second, np.array([0.0, 2 * e[1] - places["F"][1]]))
    _pin(second, "F", places["F"], CUT)
    second.set_title("2. rocker known: F is on the guide's line", fontsize=9)
    for axes in (first, second):
        axes.set_aspect("equal")
        axes.set_axis_off()
    return figure


def blocks() -> Figure:
    """The blocks in which the equations of two presses are solved, each to the right of those that it needs."""
    figure = Figure(figsize=(6.6, 3.9), layout="constrained")
    for axes, name in zip(figure.subplots(2, 1, height_ratios=(1.0, 3.0)), ("zxn2_3000b", "jf75g_125_symmetric"), strict=True):
        press = pp.load(name)
        texts, needs = _blocks(press)
        columns: list[int] = []
        for before in needs:
            columns.append(1 + max((columns[place] for place in before), default=-1))
        places = [(float(column), -columns[:place].count(column)) for place, column in enumerate(columns)]
        for place, before in zip(places, needs, strict=True):
            for other in before:
                axes.annotate("", place, places[other], arrowprops={"arrowstyle": "->", "color": GREY, "shrinkA": 34, "shrinkB": 52})
        for place, text in zip(places, texts, strict=True):
            box = {"boxstyle": "round,pad=0.35", "facecolor": "white", "edgecolor": CUT if place[0] == 0.0 else "black", "linewidth": 1.2}
            axes.text(*place, text, ha="center", va="center", fontsize=8, bbox=box)
        axes.set(xlim=(-0.35, 2.45), ylim=(min(y for _, y in places) - 0.5, 0.5))
        axes.set_title(name, fontsize=9, loc="left")
        axes.set_axis_off()
    return figure


def _blocks(press: pp.Linkage) -> tuple[list[str], list[set[int]]]:
    """What the driver and every block of a press determine, and for each the places of those that it needs."""
    engine: Any = press.engine("plane")
    equations = engine.equations
    rows = equations.functions.rows
    texts, needs = [f"driver\n{press.drivers[0]}"], [set[int]()]
    found_by = {rows[press.driver_indices[0]]: 0}
    for block in equations.blocks:
        turning = all(press.axes[joint].turns for joint in block.joints)
        kinds = {(1, 2): "dyad: two circles" if turning else "dyad: circle and line", (1, 1): "lever", (0, 1): "gear pair"}
        before = {row for loop in block.loops for row, _ in loop.earlier_functions}
        coupled = {joint for relation in block.relations for joint in equations.functions.plane.relation_rows[relation]}
        before |= {rows[joint] for joint in coupled.difference(block.joints)}
        needs.append({found_by[row] for row in before})
        found_by |= dict.fromkeys(block.rows, len(texts))
        joints = ", ".join(press.joints[joint] for joint in block.joints)
        loops = "".join(f"\nloop {press.loops[loop.loop].name}" for loop in block.loops)
        texts.append(f"{kinds[len(block.loops), len(block.joints)]}\n{joints}{loops}")
    return texts, needs


def forces() -> Figure:
    """The cut bearings under load: the same force, in opposite directions, on both links; and what the guide gives."""
    press = six_bar()
    motion = pp.servo_cycle(press, angle=[PRESSED], speed=SPEED, acceleration=0.0)
    reactions = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", (0.0, 0.0, 1.5e6))])
    figure = Figure(figsize=(6.6, 3.9), layout="constrained")
    axes = figure.subplots()
    places = pins(PRESSED)
    _links(axes, places)
    axes.add_patch(_slide(places["F"]))
    scale = 0.30 / 1.5e6  # [m/N]
    for name, one, two in (("C", "coupler", "rocker"), ("F", "rod", "slide")):
        force = reactions.bearing_force[name][0, ::2]
        for link, sign in ((two, 1.0), (one, -1.0)):
            _arrow(axes, places[name], sign * scale * force, COLOURS[link])
        size = f"{name}: {np.linalg.norm(force) / 1e3:.0f} kN"
        axes.annotate(size, tuple(places[name] + np.array([0.06, 0.05 if name == "C" else 0.03])), fontsize=9)
    guide = reactions.bearing_force["slide_guide"][0, ::2]
    low = places["F"] + np.array([0.0, -0.20])
    _arrow(axes, low, scale * guide, COLOURS["frame"])
    axes.annotate(f"guide: {abs(guide[0]) / 1e3:.0f} kN", tuple(low + np.array([0.11, -0.015])), fontsize=9)
    _arrow(axes, low + np.array([0.0, -0.42]), np.array([0.0, 0.30]), GREY)
    axes.annotate("process: 1500 kN", tuple(low + np.array([-0.04, -0.32])), fontsize=9, color=GREY, ha="right")
    words = {
        "coupler": "force of the rocker on the coupler",
        "rocker": "of the coupler on the rocker",
        "slide": "of the rod on the slide",
        "rod": "of the slide on the rod",
    }
    handles = [axes.plot([], [], color=COLOURS[link], linewidth=2)[0] for link in words]
    axes.legend(handles, words.values(), frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(0.5, 0.33))
    for name, place in places.items():
        _pin(axes, "" if name in "CF" else name, place, CUT if name in "CF" else "black")
    axes.set_aspect("equal")
    axes.set_axis_off()
    return figure


def sharing() -> Figure:
    """Two rods that hold one slide: what each carries, as rigid mechanics leaves it open, and by stiffnesses."""
    press = pp.load("jf75g_125_two_point")
    motion = pp.cycle(press, 300 * pp.RPM, points=360)
    load = pp.loads.DeepDrawing(force=1e6, start=0.005)
    figure = Figure(figsize=(6.6, 2.5), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(2.0, 1.0))
    words = ("no stiffness given:\nleast squares", "front rod twice\nas stiff as the back")
    for k, stiffness in enumerate(({}, {"P4_front": 2e9, "P4_back": 1e9})):
        found = pp.inverse_dynamics(press, motion, loads=[load], stiffness=stiffness)
        for name, colour, shift in (("P4_front", "#0072B2", -0.18), ("P4_back", "#56B4E9", 0.18)):
            most = np.linalg.norm(found.bearing_force[name], axis=1).max() / 1e3
            left.bar(k + shift, most, 0.34, color=colour, label=name if k == 0 else None)
            left.annotate(f"{most:.0f}", (k + shift, most), (0, 2), textcoords="offset points", ha="center", fontsize=8)
        moment = np.linalg.norm(found.bearing_moment["slide_guide"], axis=1).max() / 1e3
        right.bar(k, moment, 0.5, color=COLOURS["slide"])
        right.annotate(f"{moment:.0f}", (k, moment), (0, 2), textcoords="offset points", ha="center", fontsize=8)
    left.set_xticks([0, 1], words, fontsize=8)
    left.set(ylabel="largest force [kN]", ylim=(0, 760))
    left.legend(frameon=False, fontsize=8, loc="upper left")
    right.set_xticks([0, 1], ["equal", "2 : 1"], fontsize=8)
    right.set(ylabel="moment of the guide [kN m]", ylim=(0, 115))
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
    return figure


def estimates() -> Figure:
    """Runs of two seconds at many tolerances: the true error of the crank angle, and what the energy balance says without knowing it."""
    press, flywheel = six_bar(), pp.drives.Flywheel(2000)
    given: dict[str, Any] = {"speed": SPEED, "flywheel": flywheel}
    exact = pp.simulate(press, 2.0, tolerance=1e-12, **given).crank_angle[-1]
    tolerances = np.geomspace(1e-3, 1e-11, 9)
    figure = Figure(figsize=(6.6, 2.9), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, method in zip(panels, ("constraint", "implicit"), strict=True):
        runs = [pp.simulate(press, 2.0, method=method, tolerance=each, **given) for each in tolerances]
        missed = [abs(run.crank_angle[-1] - exact) for run in runs]
        axes.loglog(tolerances, missed, "o-", color="#0072B2", label="error of the crank angle [rad]")
        axes.loglog(tolerances, [run.stats.energy_error for run in runs], "s--", color="#D55E00", label="energy error of the run")
        axes.loglog(tolerances, tolerances, color=GREY, linewidth=0.8, label="the tolerance")
        axes.set(xlabel="tolerance asked for", title=f"method {method!r}")
        axes.title.set_fontsize(9)
        axes.invert_xaxis()
    panels[0].legend(frameon=False, fontsize=8)
    return figure


def _links(axes: Any, places: dict[str, Any]) -> None:
    for link, corners in CORNERS.items():
        axes.plot(*np.array([places[name] for name in corners]).T, color=COLOURS[link], linewidth=3)


def _slide(pin_place: Any) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((pin_place[0] - 0.16, pin_place[1] - 0.24), 0.32, 0.24, facecolor="#dddddd", edgecolor=COLOURS["slide"])


def _pin(axes: Any, name: str, place: Any, colour: str = "black") -> None:
    axes.plot(*place, "o", color="white", markeredgecolor=colour, markeredgewidth=1.6 if colour == CUT else 1.0, markersize=6, zorder=5)
    axes.annotate(name, tuple(place), (5, 5), textcoords="offset points", color=colour, fontsize=10)


def _branch(axes: Any, parent: Iterable[float], child: Iterable[float], joint: str) -> None:
    style = {"arrowstyle": "-|>", "color": "black", "shrinkA": 12, "shrinkB": 13}
    axes.annotate("", tuple(child), tuple(parent), arrowprops=style)
    middle = (np.array([*parent]) + np.array([*child])) / 2
    axes.annotate(joint, (middle[0] + 0.06, middle[1] + 0.05), fontsize=8)


def _arc(axes: Any, centre: Any, radius: Any, colour: str) -> None:
    turn = np.linspace(0.0, 2 * np.pi, 200)
    axes.plot(
        *(centre[:, None] + np.linalg.norm(radius) * np.array([np.cos(turn), np.sin(turn)])), color=colour, linewidth=0.8, linestyle=":"
    )


def _other(axes: Any, place: Any) -> None:
    axes.plot(*place, "x", color=GREY, markersize=7)
    axes.annotate("the other\nassembly", tuple(place), (6, -4), textcoords="offset points", color=GREY, fontsize=8, va="top")


def _arrow(axes: Any, place: Any, along: Any, colour: str) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "linewidth": 2, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tuple(place + along), tuple(place), arrowprops=style, zorder=6)
    axes.plot(*np.array([place, place + along]).T, alpha=0.0)  # the axes make room for it


DRAWINGS: tuple[Callable[[], Figure], ...] = (tree, dyads, blocks, forces, sharing, estimates)


def main(quick: bool = False, parts: Sequence[str] = ()) -> None:
    """Draw them, or some by their names; ``quick``: all but the runs."""
    for drawing in DRAWINGS[: -1 if quick else None]:
        if not parts or drawing.__name__ in parts:
            write(DOCS / "drawings" / f"{drawing.__name__}.svg", drawing())
