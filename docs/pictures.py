"""The pictures of the guide, into docs/pictures: what each feature computes, drawn by pinpress; in a minute.

Scripts of viz make the pictures of presses in three dimensions, of balancing, elasticity, foundation and accuracy, `tour_pictures` those of
the tour, and `gallery_films` the gallery.
"""

import csv
import os
import shlex
import tempfile
import warnings
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from make import DOCS, ROOT, VIZ, load, names_of, shot, write
from matplotlib.figure import Figure

import pinpress as pp
from pinpress.cli.main import main as main_of_pinpress

SPEED = 70 * pp.RPM
BLUE, RED = "#0072B2", "#D55E00"
SIZE = (6.3, 2.9)  # [inch]


@cache
def six_bar() -> pp.Linkage:
    return pp.load("zxn2_3000b")


@cache
def turn() -> pp.Reactions:
    return pp.inverse_dynamics(six_bar(), pp.cycle(six_bar(), speed=SPEED, points=360))


def pins(angle: float) -> dict[str, Any]:
    """Places of the pins of the six-bar in its plane [m]."""
    press, data = six_bar(), six_bar().model.createData()
    pin.forwardKinematics(press.model, data, press.configuration(angle))
    places = {name: data.oMi[press.model.getJointId(name)].translation[[0, 2]] for name in press.joints if "guide" not in name}
    return places | {loop.name: data.oMi[loop.joint1].act(loop.point1)[[0, 2]] for loop in press.loops}


def slip_clutch() -> Figure:
    """docs/motor.md: torque over speed of the motor with slip clutch of Zhang 2007, table 4-1, with and without enough feedback."""
    figure = _figure(SIZE)
    axes = figure.subplots()
    speed = np.linspace(0.0, 1470.0, 148)
    at = {"rated_torque": 189.0, "primary_speed": 1470 * pp.RPM, "top_speed": 1320 * pp.RPM, "set_speed": 900 * pp.RPM}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)  # that it runs without control, which is what is drawn
        enough, low = (pp.drives.SlipClutchMotor(**at, residual_current=0.3, feedback=share) for share in (1.0, 0.5))
    least, most = (np.asarray(limit) for limit in enough.controllable_torque(speed * pp.RPM))
    axes.fill_between(speed, least, most, color="0.9", label="controllable")
    axes.plot(speed, most, color="0.4", lw=1, label="full current")
    axes.plot(speed, least, color="0.4", lw=1, ls="--", label="residual current, 30 %")
    axes.plot(speed, enough.torque(speed * pp.RPM), color=BLUE, label="set to 900 r/min")
    axes.plot(speed, low.torque(speed * pp.RPM), color=RED, ls=":", lw=2.5, label="half of the feedback")
    axes.axhline(189.0, color="0.7", lw=0.8)
    axes.set(xlabel="speed of its shaft [r/min]", ylabel="torque [N m]", xlim=(0, 1500), ylim=(0, 650))
    axes.legend(loc="upper right", fontsize=8)
    return figure


def slide() -> Figure:
    """docs/motion_and_forces.md: the slide over a turn."""
    return pp.plots.draw(turn(), "height", "velocity", "acceleration")


def polar() -> Figure:
    """docs/motion_and_forces.md: forces of two bearings over a turn."""
    return pp.plots.draw(turn(), "polar A", "polar D")


def pole_path() -> Figure:
    """docs/lectures.md: the pole of the coupler."""
    return pp.plots.draw(pp.measures.poles(six_bar(), turn().motion, "coupler", "frame"))


def polygons() -> Figure:
    """docs/lectures.md: both polygons at a crank angle of 60 degrees."""
    return pp.plots.draw(pp.measures.polygons(six_bar(), turn().motion, 60))


def workspace() -> bytes:
    """docs/robots.md: where a five-bar locks, and the dead points of its hand."""
    arm = pp.load(DOCS / "robots" / "five_bar.urdf")
    reach = pp.measures.workspace(arm, "hand", {"left": (-1.5, 1.5), "right": (-1.5, 1.5)}, points=61)
    with tempfile.TemporaryDirectory() as folder:
        return pp.plots.save(pp.plots.draw(reach, "map frame"), Path(folder, "workspace.png")).read_bytes()


def process_force() -> Figure:
    """docs/measured.md: the force that the page finds, over the one that acted."""
    names = names_of("measured")
    figure = pp.plots.draw({"found from the torque of the drive": names["force"]}, "force")
    height = np.linspace(0.0, 0.010, 400)
    acted = np.where((height < 0.009) & (height > 0.001), 1500 * np.sin(np.pi * (0.009 - height) / 0.008), 0.0)
    figure.axes[0].plot(1e3 * height, acted, color=RED, linewidth=0.9, linestyle=(0, (4, 2)))
    return figure


def measured_modes() -> Figure:
    """docs/measured_vibration.md: measured modes beside the calculated ones."""
    return pp.plots.draw(names_of("measured_vibration")["found"], "damping", "mac")


def orders() -> bytes:
    """docs/measured_vibration.md: orders over the speed."""
    spectra = names_of("measured_vibration")["runup"].order_spectra(4)
    with tempfile.TemporaryDirectory() as folder:
        return pp.plots.save(pp.plots.draw(spectra, "orders top"), Path(folder, "orders.png")).read_bytes()


def tolerances() -> Figure:
    """docs/tolerances.md: the dimensions by their shares, and the presses of the sample."""
    parts = pp.tolerances.read_dimensions(six_bar(), DOCS / "zxn2_dimensions.csv").parts
    return pp.plots.draw(pp.tolerances.bottom_dead_centre(six_bar(), parts).height.with_limit(50e-6))


def identifiability() -> Figure:
    """docs/measured.md: what torque and shaking force teach of the masses."""
    columns = {"angle": "crank [deg]", "torque": "motor [N m]", "ratio": 20.7}
    runs = [pp.measured.record(DOCS / "records" / f"{strokes}.csv", **columns) for strokes in (21, 42, 63)]
    return pp.plots.draw(pp.measured.identifiability(six_bar(), runs, friction=("crank", "gibs"), cylinder=True), "doubt")


def play() -> Figure:
    """docs/slide_accuracy.md: the slide in its clearances over the turn."""
    return pp.plots.draw(pp.tolerances.play(six_bar(), turn().motion, dict.fromkeys("ABCDEF", 50e-6)))


def accuracy_budget() -> Figure:
    """docs/slide_accuracy.md: bottom dead centre by parts, from setting to production."""
    return pp.plots.draw(
        pp.tolerances.budget(
            six_bar(),
            speeds=[10 * pp.RPM, SPEED],
            clearance=dict.fromkeys("ABCDEF", 50e-6),
            stiffness=pp.elasticity.Stiffness(dict.fromkeys("ABCDEF", 2e9), shaft=3e7, frame=4e9),
            temperatures=pp.tolerances.Temperatures({"rocker": 10.0, "rod": 10.0}),
            process=500e3,
        ),
        "parts",
    )


def run() -> Figure:
    """docs/simulation.md: the stroke that repeats under motor and load."""
    motor = pp.drives.Geared(pp.drives.InductionMotor(rated_power=75e3, rated_speed=1485 * pp.RPM, inertia=1.2), ratio=20.7)
    drawing = pp.loads.DeepDrawing(force=1e6, start=0.010)
    figure = _figure((6.3, 4.2))
    above, below = figure.subplots(2, 1, sharex=True)
    for inertia, colour in ((6000, BLUE), (2000, RED)):
        steady = pp.steady_state(six_bar(), SPEED, drive=motor, flywheel=pp.drives.Flywheel(inertia=inertia), loads=[drawing], points=720)
        angle = np.degrees(steady.crank_angle - steady.crank_angle[0])
        above.plot(angle, steady.crank_speed / pp.RPM, color=colour, label=f"flywheel of {inertia} kg m²")
        below.plot(angle, steady.drive_torque / 1e3, color=colour)
    above.set_ylabel("speed [strokes/min]")
    below.set_ylabel("torque of the motor\nat the crank [kN m]")
    below.set_xlabel("crank angle [deg]")
    below.set_xticks(range(0, 361, 45))
    above.legend(frameon=False, ncols=2, loc="lower left", bbox_to_anchor=(0.0, 0.98))
    return figure


def pause() -> Figure:
    """docs/press_parts.md: break-through of a blank at an even pace, after a pause, and on impact dampers."""
    page = names_of("press_parts")
    figure = _figure((6.3, 3.8))
    above, below = figure.subplots(2, 1, sharex=True)
    for name, slowest, loads, colour in (
        ("even pace", 1.0, [page["blank"]], "black"),
        ("pause", 0.02, [page["blank"]], BLUE),
        ("impact dampers", 1.0, [page["blank"], page["damper"]], RED),
    ):
        run, _ = page["stroke"](slowest, loads)
        broken = next(time for time, _, place in run.events if abs(place - page["bottom"] - page["blank"].end) < 1e-9)
        time = 1e3 * (run.time - broken)
        near = np.abs(time + 10) < 50
        above.plot(time[near], 1e3 * (run.slide_position[near] - page["bottom"]), color=colour, label=name)
        below.plot(time[near], 1e-3 * run.bearing_force["P4"][near, 2], color=colour)
    above.set_ylabel("slide [mm]")
    above.legend(frameon=False)
    below.set_ylabel("P4, upwards [kN]")
    below.set_xlabel("time from break-through [ms]")
    return figure


def eight_way_guide() -> Figure:
    """docs/press_parts.md: the eight surfaces of a slide guide under a force beside the axis."""
    figure = pp.plots.draw(names_of("press_parts")["gibs"], "surfaces", "rotation")
    figure.axes[1].set(xlim=(310, 335), xticks=range(310, 336, 5))
    return figure


def elastic_stroke() -> Figure:
    """docs/elastic_motion.md: the stroke that JF75G-125 repeats on its springs while it blanks, near bottom dead centre."""
    press, speed = pp.load("jf75g_125_plain"), 300 * pp.RPM
    stiffness = pp.elasticity.Stiffness({"O": 3e9, "P2": 4e9, "P4": 4e9, "slide_guide": 2e9}, moments={"slide_guide": 2e8}, frame=3e9)
    stroke = pp.steady_state(
        press,
        speed,
        drive=pp.drives.PrescribedSpeed(speed),
        loads=[pp.loads.Blanking(force=600e3, start=0.004, end=0.002)],
        elastic=pp.elasticity.Elastic(stiffness, damping_ratio=0.03, crown_mass=4000),
        points=1441,
    )
    from_bottom = np.degrees(stroke.crank_angle - pp.dead_centres(press).bottom_angle + np.pi) % 360 - 180
    order = np.argsort(from_bottom)
    near = order[np.abs(from_bottom[order]) < 60]
    bottom = pp.dead_centres(press).bottom_position
    figure = _figure((6.3, 3.6))
    height, force = figure.subplots(2, 1, sharex=True)
    height.plot(from_bottom[near], 1e3 * (stroke.rigid_slide_position[near] - bottom), color=RED, label="rigid")
    height.plot(from_bottom[near], 1e3 * (stroke.slide_position[near] - bottom), color=BLUE, label="on springs")
    height.set_ylim(-1, 5)
    height.set_ylabel("slide [mm]")
    height.legend(frameon=False)
    force.plot(from_bottom[near], 1e-3 * stroke.bearing_force["P4"][near, 2], color=BLUE)
    force.set_ylabel("P4, upwards [kN]")
    force.set_xlabel("crank angle from rigid bottom dead centre [deg]")
    return figure


def operating_map() -> Figure:
    """docs/sweep.md: the largest torque over speed and force."""
    drawing = pp.loads.DeepDrawing(force=1.0, start=0.020)
    speeds, forces = np.linspace(10, 100, 46) * pp.RPM, np.linspace(0, 3e6, 61)
    points = pp.sweeps.operating_points(six_bar(), speeds, forces=forces, unit_load=drawing)
    figure = _figure(SIZE)
    axes = figure.subplots()
    shown = axes.contourf(forces / 1e3, speeds / pp.RPM, points.grid("largest_driving_torque") / 1e3, 12, cmap="cividis")
    axes.set_xlabel("process force [kN]")
    axes.set_ylabel("strokes/min")
    figure.colorbar(shown, label="largest driving torque [kN m]")
    return figure


def synthesis() -> Figure:
    """docs/synthesis.md: the torque of the empty six-bar before and after its synthesis."""
    found = load("synthesis").less_torque()
    figure = _figure(SIZE)
    axes = figure.subplots()
    for press, colour, words in ((six_bar(), RED, "as shipped"), (found.press, BLUE, "with the lengths found")):
        motion = pp.cycle(press, speed=SPEED, points=361)
        torque = pp.inverse_dynamics(press, motion, bearings=()).driving_torque
        axes.plot(np.degrees(motion.crank_angle), torque / 1e3, color=colour, label=words)
    axes.set_xlabel("crank angle [deg]")
    axes.set_ylabel("driving torque [kN m]")
    axes.set_xticks(range(0, 361, 45))
    axes.legend(frameon=False)
    return figure


def two_assemblies() -> Figure:
    """docs/describe.md: at one crank angle the six-bar closes in two ways."""
    figure = _figure((6.3, 3.4))
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    places = pins(np.radians(200.0))
    centre, radius = places["E"], float(np.hypot(*(places["F"] - places["E"])))
    other = places | {"F": np.array([0.0, centre[1] + np.sqrt(radius**2 - centre[0] ** 2)])}
    for panel, shown, words in ((axes[0], places, "the assembly as drawn"), (axes[1], other, "the other one, never entered")):
        for link, colour in (("AB", "#D55E00"), ("BC", "#0072B2"), ("DCE", "#009E73"), ("EF", "#CC79A7")):
            corners = np.array([shown[name] for name in (link + link[0] if len(link) > 2 else link)])
            panel.plot(*corners.T, color=colour, linewidth=3)
        for name, place in shown.items():
            panel.plot(*place, "o", color="white", markeredgecolor="black", markersize=5)
            here = [each for each, at in shown.items() if np.allclose(at, place, rtol=0, atol=1e-9)]  # F is on D in the other assembly
            aside: dict[str, Any] = {"xytext": (5, 4)} if len(here) == 1 else {"xytext": (-6, -3), "ha": "right"}
            panel.annotate(", ".join(here) if name == here[0] else "", tuple(place), textcoords="offset points", **aside)
        panel.axvline(0.0, color="#7a7a7a", linewidth=0.6, linestyle="--")
        panel.set_aspect("equal")
        panel.set_title(words)
        panel.set_axis_off()
    return figure


def change_point() -> Figure:
    """docs/limits.md: the forces of a crank-slider whose crank is nearly as long as its rod."""
    crank, rods = 0.1, 0.1 * (1 + np.geomspace(1e-3, 3.0, 40))
    largest = []
    for rod in rods:
        pins = {"O": [0, 0], "P": {"from": "O", "length": 1e3 * crank, "angle": -90}, "W": {"P": 1e3 * rod, "x": 0, "side": "down"}}
        links = {
            "crank": {"pins": "O P", "mass": 20},
            "rod": {"pins": "P W", "mass": 10},
            "slide": {"pins": "W", "guide": "up", "mass": 100},
        }
        press = pp.build(units="mm", frame="O", pins=pins, links=links, drive="O")
        reactions = pp.inverse_dynamics(press, pp.cycle(press, speed=60 * pp.RPM, points=1440))
        largest.append(np.linalg.norm(reactions.bearing_force["W"], axis=1).max())
    figure = _figure(SIZE)
    axes = figure.subplots()
    axes.loglog(rods / crank - 1, np.array(largest) / 1e3, color=BLUE)
    axes.set_xlabel("rod / crank - 1")
    axes.set_ylabel("largest force\nbetween rod and slide [kN]")
    return figure


def sketch() -> str:
    """docs/pin_table.md: the drawn pose of its table."""
    return pp.pin_table.draft(ROOT / "urdf" / "zxn2_3000b.yaml").sketch


def pitch_circles() -> str:
    """docs/machine_elements.md: the drawn pose of the template hypocycloid."""
    return pp.pin_table.draft(ROOT / "pinpress" / "pin_table" / "templates" / "hypocycloid.yaml").sketch


def notebook() -> str:
    """docs/pinocchio.md: joints of the tree and loops, as a notebook shows a press."""
    shown = six_bar()._repr_html_()
    picture = shown[shown.index("<svg") : shown.index("</svg>") + len("</svg>")]
    return picture.replace("<svg ", '<svg style="background:#fff" ', 1)


def programs() -> Figure:
    """docs/accuracy.md: error against run time of a free run, of pinpress and of other programs, from viz/accuracy.csv."""
    with (VIZ / "accuracy.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["group"] == "free run" and row["error"]]
    words = {"reduced": "pinpress", "constraint": "pinpress, all joints", "SciPy DOP853, closed form": "hand script, SciPy DOP853"}
    methods = [*words, *(name for name in dict.fromkeys(row["method"] for row in rows) if name.startswith(("MuJoCo", "Exudyn", "Drake")))]
    figure = _figure((6.3, 3.6))
    axes = figure.subplots()
    for name, marker, colour in zip(methods, "os*D^vP", (BLUE, "#56B4E9", "black", RED, "#E69F00", "#009E73", "#CC79A7"), strict=True):
        points = [(1e3 * float(row["seconds [s]"]), float(row["error"])) for row in rows if row["method"] == name and float(row["error"])]
        axes.loglog(*np.array(points).T, marker, linestyle="-", markersize=4, color=colour, label=words.get(name, name))
    axes.set_xlabel("run time of two turns [ms]")
    axes.set_ylabel("error of the crank angle [rad]")
    axes.legend(frameon=False, fontsize=8, ncols=3, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    return figure


def lengths_too_short() -> str:
    """docs/mistakes.md: the sketch that comes with one of its mistakes."""
    try:
        pp.pin_table.draft(ROOT / "tests" / "mistakes" / "lengths-too-short-to-meet.yaml")
    except pp.PinTableError as error:
        return str(error.sketch)
    raise AssertionError("its lengths meet")


def die_trade_off() -> Figure:
    """docs/balancing.md: the curves of the page's own code."""
    return pp.plots.draw(names_of("balancing")["curves"], "trade_off")


def ratings() -> Figure:
    """docs/ratings.md: permissible force, stroke and energy. Kong 2025 prints nominal force and motor; all else is assumed (ours)."""
    capacities = pp.ratings.Capacities(
        nominal_force=3000e3,
        motor_power=75e3,
        nominal_height=0.013,
        flywheel_inertia=2000.0,
        speed_drop=0.2,
        bearings={"A": 1.5e6, "D": 3.3e6, "E": 3.3e6},
    )
    return pp.plots.draw(pp.ratings.rate(six_bar(), SPEED, capacities, points=1081), "force", "near_bottom", "work")


def report_page() -> bytes:
    """docs/commands.md: the page of its command, at the ratings."""
    return _report_in("commands.md", "pinpress press.yaml", "Ratings")


def frame_report() -> bytes:
    """docs/foundation.md: the page of its command, at the frame on its mounts."""
    return _report_in("foundation.md", "pinpress drawing.yaml", "On its mounts")


def frame_modes() -> bytes:
    """docs/foundation.md: the page of the modes of the frame in its frame file, at the first in which the frame bends."""
    press = pp.load("jf75g_125")
    system = pp.foundation.read_mounted(press, DOCS / "jf75g_125_frame.yaml")
    modes = pp.foundation.modes(system)
    first = modes.motion.index("bending")
    with tempfile.TemporaryDirectory() as folder:
        file = pp.record_modes(press, modes, Path(folder, "modes.html"), lowest=first + 1)
        return shot(file.as_uri(), "select:visible", f"() => {{ setPlaying(false); seek(data.modes[{first}].start + 0.25); }}")


def _report_in(page: str, command: str, title: str) -> bytes:
    """The page that a command of the manual makes of the files that it shows, at a section."""
    from support import page_blocks

    text = (DOCS / page).read_text(encoding="utf-8")
    manual = text.replace("\\\n", "")
    _, *words = shlex.split(next(line for line in manual.splitlines() if line.startswith(command)))
    scroll = f"""() => {{
        const titles = [...document.querySelectorAll("#charts h2")];
        titles.find(each => each.textContent.startsWith("{title}")).scrollIntoView();
        viewer.render();
    }}"""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "docs").symlink_to(DOCS)
        for block in page_blocks.blocks(text):
            if block.title:
                Path(folder, block.title).write_text(block.body, encoding="utf-8")
        file = Path(folder, words.pop())
        before = Path.cwd()
        os.chdir(folder)  # where the command finds these files
        main_of_pinpress([*words, str(file)])
        os.chdir(before)
        return shot(file.as_uri() + "#t=0.64", "body:has(#charts h2)", scroll)


def live() -> bytes:
    """docs/recording.md: the live window in Chromium, in which a crank has been made longer."""
    longer_crank = """() => {
        setPlaying(false);
        seek(0.15 * duration);
        change(rows[data.dimensions.findIndex(each => each.name === "A to B")], 165, true);
    }"""
    loads = [pp.loads.DeepDrawing(force=1.5e6, start=0.040)]
    with pp.view(six_bar(), speed=SPEED, loads=loads, browser=False) as window:
        return shot(window.url, ".row", longer_crank)


def _figure(size: tuple[float, float]) -> Figure:
    return Figure(figsize=size, layout="constrained")


PICTURES: tuple[Callable[[], Figure | str | bytes], ...] = (
    slide, polar, pole_path, polygons, workspace, run, slip_clutch, tolerances, identifiability, ratings,
    die_trade_off, play, accuracy_budget, pause, eight_way_guide, elastic_stroke, operating_map, synthesis, two_assemblies, change_point,
    programs, sketch, pitch_circles,
    lengths_too_short, notebook, report_page, frame_report, frame_modes, live, process_force, measured_modes, orders,
)  # fmt: skip


def main(quick: bool = False, parts: Sequence[str] = ()) -> None:
    """Draw them, or some by their names; ``quick``: one of each kind."""
    for picture in PICTURES:
        if picture.__name__ in (parts or (["slide", "sketch", "live"] if quick else [each.__name__ for each in PICTURES])):
            content = picture()
            write(DOCS / "pictures" / f"{picture.__name__}.{'png' if isinstance(content, bytes) else 'svg'}", content)
