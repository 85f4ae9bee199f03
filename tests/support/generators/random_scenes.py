"""Random scenes of presses: what users combine, from one seed each. `scene` draws a press, a start, a drive and everything that acts.

Sizes follow the press: torques are shares of what its weights ask of the crank, speeds those at which it turns under them.
"""

from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
import yaml
from support import cams, texts
from support.generators import random_linkages, same_linkage, spatial_crank_slide
from support.presses import sliding_presses

import pinpress as pp

drives, loads = pp.drives, pp.loads
Random = np.random.Generator


@dataclass(frozen=True)
class Scene:
    """A press with its name, and what `simulate` is asked."""

    seed: int
    name: str
    press: Any
    duration: float
    given: dict[str, Any] = field(repr=False)

    def __str__(self) -> str:
        given = ", ".join(f"{name}={value!r}" for name, value in self.given.items())
        return f"scene {self.seed}: {self.name}, {self.duration:.6g} s, {given}"


# ---------------------------------------------------------------------------------------------------------------------------- presses

TEMPLATES = ("crank-slide", "drawing-8-bar", "eccentric-block", "guide-bar", "knuckle", "link-drive", "rssp", "toggle")


def shipped(random: Random) -> tuple[str, Any]:
    name = str(random.choice(pp.presses()))
    return name, texts.shipped(name)


@cache
def _template(name: str) -> str:
    return resources.files("pinpress.pin_table").joinpath("templates", f"{name}.yaml").read_text(encoding="utf-8")


def of_template(random: Random) -> tuple[str, Any]:
    """A pin table's template with each parameter and mass changed by up to a tenth."""
    name = str(random.choice(TEMPLATES))
    table = yaml.safe_load(_template(name))
    table.pop("press", None)
    table["parameters"] = {key: value * random.uniform(0.9, 1.1) for key, value in table.pop("parameters", {}).items()}
    for link in table["links"].values():
        if "mass" in link:
            link["mass"] *= random.uniform(0.5, 2.0)
    return name, pp.build(**table)


def crank_slide(random: Random) -> tuple[str, Any]:
    """A crank-slider, offset, upright or lying, with any masses."""
    r = random.uniform(30, 200)
    rod, offset = r * random.uniform(2.5, 6), r * random.choice([0.0, random.uniform(-0.6, 0.6)])
    way = str(random.choice(["up", "right"]))
    across, guided = ("x", "down") if way == "up" else ("z", "right")
    return "crank_slide", pp.build(
        units="mm",
        frame="O",
        pins={
            "O": [0, 0],
            "P": {"from": "O", "length": r, "angle": random.uniform(0, 360)},
            "W": {"P": rod, across: offset, "side": guided},
        },
        links={
            "crank": {"pins": "O P", "mass": random.uniform(5, 200), "com": [random.uniform(-0.5, 1) * r, 0]},
            "rod": {"pins": "P W", "mass": random.uniform(2, 100)},
            "slide": {"pins": "W", "guide": way, "mass": 10 ** random.uniform(1, 3.5)},
        },
        drive="O",
    )


def four_bar(random: Random) -> tuple[str, Any]:
    """A four-bar whose crank turns all the way round, or in part where it does not."""
    ground, coupler, rocker = random.uniform(0.3, 1.0, 3)
    crank = random.uniform(0.3, 1.0) * max(coupler + rocker - ground, 0.1) * 0.5
    if random.random() < 0.8:
        crank = min(crank, 0.9 * (min(ground, coupler, rocker)), 0.9 * (ground - abs(coupler - rocker)))
    angle = random.uniform(0, 6.2)
    if not abs(coupler - rocker) < abs(ground - crank * np.exp(1j * angle)) < coupler + rocker or crank < 0.03:
        return four_bar(random)
    drawing = random_linkages.four_bar(ground, crank, coupler, rocker, angle, int(random.choice([-1, 1])))
    return "four_bar", texts.load(drawing.urdf("O"))


def linkage_spec(random: Random) -> random_linkages.Spec:
    """A crank with one to three dyads or triads."""
    kinds, cuts, hosts = random_linkages.KINDS, 3, 8  # hosts are taken modulo the links that there are
    groups = tuple(
        random_linkages.Group(str(random.choice(kinds)), int(random.integers(cuts)), tuple(map(int, random.integers(0, hosts, 3))))
        for _ in range(random.integers(1, 4))
    )
    flags = {name: bool(random.integers(2)) for name in ("tilted", "stacked", "solid", "extra")}
    return random_linkages.Spec(groups, int(random.integers(2**32)), **flags)


def random_linkage(random: Random) -> tuple[str, Any]:
    """Many lock within a turn."""
    drawing = None
    while drawing is None:
        drawing = random_linkages.drawn(linkage_spec(random))
    return "random_linkage", texts.load(drawing.urdf("crank"))


def in_space(random: Random) -> tuple[str, Any]:
    """The spatial crank-slide of the tests, turned against gravity anyhow."""
    direction = random.normal(size=3)
    return "in_space", texts.load(
        spatial_crank_slide.SPATIAL, gravity=tuple(float(g) for g in -9.81 * direction / np.linalg.norm(direction))
    )


def sliding_driver(random: Random) -> tuple[str, Any]:
    name = str(random.choice(["BELL", "TOGGLE"]))
    return name.lower(), texts.load(getattr(sliding_presses, name))


def screw_or_rack(random: Random) -> tuple[str, Any]:
    """A slide that does not come back after a turn of its driver."""
    lead = random.choice([-1, 1]) * 10 ** random.uniform(-2.5, -1)
    if random.random() < 0.5:
        pins: dict[str, Any] = {"O": [0, 0], "Q": [30, 0]}
        wheel = {"pins": "O", "mass": 2.0, "disc": "30 x 40"}
    else:
        pins = {"O": {"x": 0, "y": 0, "z": 0, "axis": "z"}, "Q": {"x": 0, "y": 0, "z": -200, "axis": "z"}}
        wheel = {"pins": "O", "mass": 300.0, "com": "O", "inertia": [15, 15, random.uniform(1, 30)]}
    return "screw_or_rack", pp.build(
        units="mm",
        frame="O",
        pins=pins,
        links={"wheel": wheel, "slide": {"pins": "Q", "guide": "up", "mass": random.uniform(5, 500)}},
        gears={"slide_guide": f"{lead} * O"},
        drive="O",
    )


def lossy(random: Random) -> float:
    """Efficiency of teeth, often 1."""
    return float(random.choice([1.0, 1.0, random.uniform(0.85, 1.0)]))


def threaded(random: Random) -> tuple[str, Any]:
    """A screw or rack with its forces and losses. Some screws lock themselves."""
    made: dict[str, Any]
    if random.random() < 0.5:
        radius, side = random.uniform(10, 80), int(random.choice([-1, 1]))
        pins: dict[str, Any] = {"O": [0, 0], "Q": [side * radius, 0]}
        made = {"racks": {"rack": {"pinion": "wheel", "rack": "slide", "radius": radius, "efficiency": lossy(random)}}}
        wheel = {"pins": "O", "mass": 2.0, "disc": f"{2 * radius} x 40"}
    else:
        pins = {"O": {"x": 0, "y": 0, "z": 0, "axis": "z"}, "Q": {"x": 0, "y": 0, "z": -200, "axis": "z"}}
        wheel = {"pins": "O", "mass": 300.0, "com": "O", "inertia": [15, 15, random.uniform(1, 30)]}
        diameter = random.uniform(30, 300)
        thread = {"screw": "wheel", "nut": "slide", "lead": diameter * log_uniform(random, 0.05, 1.0), "diameter": diameter}
        rubs = {"friction": random.uniform(0.02, 0.15), "collar_friction": 0.1, "collar_diameter": random.uniform(0.2, 1) * diameter}
        hand = str(random.choice(["left", "right"]))
        made = {"screws": {"thread": thread | {"hand": hand} | (rubs if random.random() < 0.6 else {})}}
    links = {"wheel": wheel, "slide": {"pins": "Q", "guide": "up", "mass": random.uniform(5, 500)}}
    return "threaded", pp.build(units="mm", frame="O", pins=pins, links=links, **made, drive="O")


def planetary(random: Random) -> tuple[str, Any]:
    """A slide whose rod hangs on the carrier or on the planet of a planetary stage, which its sun or its carrier drives."""
    sun, planet = ((20, 20), (40, 20), (20, 40), (20, 30), (30, 15))[int(random.integers(5))]
    radius = random.uniform(0.1, 0.3)
    centre = radius * np.exp(1j * random.uniform(0, 6.28))
    on_planet = random.random() < 0.5
    pin = centre * random.uniform(0.5, 1.2) + on_planet * radius * 0.3 * np.exp(1j * random.uniform(0, 6.28))
    wrist = complex(random.uniform(-0.2, 0.2) * radius, -random.uniform(3, 6) * radius)
    drawing = random_linkages.Drawing("planetary")
    drawing.joint("S", "frame", "sun", 0j)
    drawing.joint("C", "frame", "carrier", 0j)
    drawing.joint("P", "carrier", "planet", centre)
    drawing.joint("B", "planet" if on_planet else "carrier", "rod", pin)
    drawing.joint("G", "frame", "slide", wrist, along=1j)
    drawing.loop("W", "rod", "slide", wrist)
    count, losses = int(random.choice([1, 2])), lossy(random)
    for name, links, teeth in (("inner", ("sun", "planet"), (sun, planet)), ("outer", ("planet", "frame"), (planet, -sun - 2 * planet))):
        ends = {"gear1": links[0], "gear2": links[1], "teeth1": teeth[0], "teeth2": teeth[1], "carrier": "carrier"}
        drawing.element("gear_mesh", name=name, **ends, planets=count, efficiency=losses)
    for link, at in (("sun", 0j), ("carrier", 0.4 * centre), ("planet", centre), ("rod", 0.5 * (pin + wrist)), ("slide", wrist)):
        drawing.body(link, 10 ** random.uniform(0.5, 2), at + 0.1 * radius * complex(*random.normal(size=2)))
    return "planetary", texts.load(drawing.urdf(str(random.choice(["S", "C"]))), slide="slide")


def lever_gear(random: Random) -> tuple[str, Any]:
    """A crank that a wheel on the frame turns by a gear that is fixed to the rod: teeth between two bodies on a moving carrier."""
    teeth, geared = int(random.choice([-120, -60, 20, 40, 60])), int(random.choice([20, 30, 40]))
    crank = random.uniform(0.05, 0.2) * np.exp(1j * random.uniform(0, 6.28))
    wrist = complex(random.uniform(3, 6) * abs(crank), random.uniform(-0.3, 0.3) * abs(crank))
    drawing = random_linkages.Drawing("lever_gear")
    drawing.joint("A", "frame", "crank", 0j)
    drawing.joint("A1", "frame", "wheel", 0j)
    drawing.joint("B", "crank", "rod", crank)
    drawing.joint("G", "frame", "slide", wrist, along=1.0 + 0j)
    drawing.loop("W", "rod", "slide", wrist)
    ends = {"gear1": "wheel", "gear2": "rod", "teeth1": teeth, "teeth2": geared, "carrier": "crank"}
    drawing.element("gear_mesh", name="teeth", **ends, pressure_angle=random.uniform(14, 28), efficiency=lossy(random))
    for link, at in (("crank", 0.5 * crank), ("wheel", 0j), ("rod", 0.5 * (crank + wrist)), ("slide", wrist)):
        drawing.body(link, 10 ** random.uniform(0.5, 2), at + 0.1 * abs(crank) * complex(*random.normal(size=2)))
    return "lever_gear", texts.load(drawing.urdf("A1"), slide="slide")


def cam_driven(random: Random) -> tuple[str, Any]:
    name = str(random.choice(list(cams.TABLES)))
    return name, cams.press(name)


MACHINES = (threaded, planetary, lever_gear, cam_driven)
"""Presses with machine elements."""
PRESSES = {shipped: 6, of_template: 4, crank_slide: 5, four_bar: 3, random_linkage: 2, in_space: 1, sliding_driver: 1, screw_or_rack: 1}
"""How often each is drawn."""


def press(random: Random) -> tuple[str, Any]:
    kinds, shares = list(PRESSES), np.array(list(PRESSES.values()), dtype=float)
    return kinds[int(random.choice(len(kinds), p=shares / shares.sum()))](random)


# ------------------------------------------------------------------------------------------------------------------------------ scales


@dataclass(frozen=True)
class Scale:
    """What moves a press: mean inertia at the driver, largest torque of the weights there, the driver's travel, the slide's stroke and the
    height of its bottom (0 without a slide that comes back)."""

    inertia: float
    weight: float
    low: float
    high: float
    stroke: float


def scale(press: Any) -> Scale:
    turns = press.driver_coordinates[0].turns
    low, high = (0.0, 2 * np.pi) if press.branch.period else press.branch.angles[[0, -1]]
    if not turns:
        low, high = max(low, -0.07), min(high, 0.07)
    elif not press.branch.period:
        low, high = max(low, -1.5), min(high, 1.5)
    angles = np.linspace(low + 0.1 * (high - low), high - 0.1 * (high - low), 25)
    still, moved = (
        pp.inverse_dynamics(press, pp.servo_cycle(press, angles, speed=0.0, acceleration=a), bearings=()).driving_torque for a in (0.0, 1.0)
    )
    inertia = float(np.mean(moved - still))
    stroke = 0.0
    if press.slide is not None:
        stroke = float(np.ptp(pp.servo_cycle(press, angles, speed=1.0, acceleration=0.0).slide_position))
    return Scale(inertia, float(np.abs(still).max()) + 1e-3 * inertia, float(low), float(high), stroke)


def log_uniform(random: Random, low: float, high: float) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


# ------------------------------------------------------------------------------------------------------------------------------- parts


def motor(random: Random, torque: float, speed: float, duration: float, angle: float) -> Any:
    """A drive of about a torque and a speed, at the driver."""
    kind = str(random.choice(["constant", "induction", "induction", "inverter", "slip clutch", "servo", "curve"]))
    sign = 1.0 if random.random() < 0.85 else -1.0
    if kind == "constant":
        return drives.ConstantTorque(sign * torque)
    if kind == "servo":
        return drives.ServoMotor(
            (0.0, 0.4 * duration, 0.8 * duration),
            (angle, angle + sign * 0.3 * speed * duration, angle + sign * 0.5 * speed * duration),
            torque * log_uniform(random, 3, 100),
            torque / speed * log_uniform(random, 1, 30),
            3 * torque,
            inertia=0.05 * torque / speed,
        )
    rated = 2 * np.pi * 25 * random.uniform(0.92, 0.99)
    ratio = rated / speed
    at_shaft = torque / ratio
    inertia = at_shaft / rated * log_uniform(random, 0.01, 1)
    if kind == "induction":
        made: Any = drives.InductionMotor(at_shaft * rated, rated, inertia=inertia)
    elif kind == "inverter":
        made = drives.InverterMotor(at_shaft, rated, 50.0 * random.uniform(0.5, 1.0), inertia=inertia)
    elif kind == "slip clutch":
        made = drives.SlipClutchMotor(at_shaft, 160.0, 0.9 * 160.0, 0.8 * 160.0, inertia=inertia, lag=float(random.choice([0.0, 0.05])))
    else:
        made = DirectCurrent(at_shaft, rated, inertia)
    return drives.Geared(made, sign * ratio, 0.0, float(random.choice([1.0, 1.0, 0.95, 0.8])))


@dataclass(frozen=True)
class DirectCurrent(drives.SpeedTorqueDrive):
    """A law of a user's own: a direct-current motor, whose torque falls in a straight line to zero at its no-load speed."""

    stall: float
    free: float
    inertia: float = 0.0
    rated_torque = None

    def torque(self, speed: Any, angle: Any = 0.0, time: Any = 0.0, state: Any = ()) -> Any:
        return self.stall * (1.0 - speed / self.free)


def process_load(random: Random, stroke: float, force: float) -> Any:
    start = stroke * random.uniform(0.03, 0.4)
    kind = int(random.integers(11))
    return [
        lambda: loads.DeepDrawing(force, start),
        lambda: loads.Blanking(force, start, 0.3 * start),
        lambda: loads.Blanking(force, start, 0.3 * start, stripping=0.1 * force),
        lambda: loads.ConstantForce(force, start),
        lambda: loads.ForceStroke([0.0, 0.4 * start, start], [force, 0.6 * force, 0.0]),
        lambda: loads.ForceStroke([0.0, start], [force, 0.5 * force]),
        lambda: loads.ElasticDie(start, force / start * random.choice([1.0, 30.0]), random.choice([0.0, 0.01]) * force / start),
        lambda: loads.Impact(start, force / start**1.5, 1.5, 0.01 * force / start, 0.1 * start),
        lambda: loads.HydraulicCushion(force, start, 0.1 * start, 0.1 * force),
        lambda: loads.PneumaticCushion(0.05 + 0.1 * stroke, 5e5, (0.05 + 0.1 * stroke) ** 2 * stroke * 2, start),
        lambda: loads.RateSensitiveBlanking(force, start, 0.2 * start, 0.05, 0.05, 0.6 * start, 0.4, 0.05 * force),
    ][kind]()


def link_load(random: Random, press: Any, force: float) -> Any:
    link = press.slide or press.links[-1]
    far = tuple(2 * press.size * random.normal(size=3))
    if random.random() < 0.5:
        return loads.PointForce(link, tuple(0.3 * force * random.normal(size=3)), tuple(0.1 * press.size * random.normal(size=3)))
    stiffness = force / press.size
    return loads.SpringDamper("frame", link, stiffness, random.choice([0.0, 0.1]) * stiffness, press.size, point1=far)


def rubbing(random: Random, press: Any) -> dict[str, Any]:
    names = [name for name in press.bearings if not any(loop.name == name and loop.type == "fixed" for loop in press.loops)]
    chosen = [str(name) for name in random.permutation(names)[: random.integers(1, len(names) + 1)]]
    slides = random_linkages.slides(press)
    return {name: loads.Friction(random.uniform(0.01, 0.1), None if name in slides else 0.03 * press.size) for name in chosen}


def switch(random: Random, duration: float, angle: float, way: float) -> Any:
    """None: from the start on; at a time, or at an angle ahead."""
    return [
        None,
        drives.SwitchPoint(time=random.uniform(0, 0.8) * duration),
        drives.SwitchPoint(angle=angle + way * random.uniform(0.1, 2.0)),
    ][int(random.integers(3))]


# ------------------------------------------------------------------------------------------------------------------------------ scenes


def scene(seed: int) -> Scene:
    """Of one run; some have a clutch or brake."""
    random = np.random.default_rng([1, seed])
    name, made = press(random)
    return Scene(seed, name, made, *_played(random, made))


def machine(seed: int) -> Scene:
    """Of one run of a press with machine elements."""
    random = np.random.default_rng([8, seed])
    name, made = MACHINES[int(random.integers(len(MACHINES)))](random)
    return Scene(seed, name, made, *_played(random, made))


def coupled(seed: int) -> Scene:
    """Of one run with clutch, brake or both."""
    random = np.random.default_rng([6, seed])
    while True:
        name, made = press(random)
        duration, given = _played(random, made)
        if {"clutch", "brake"} & given.keys():
            return Scene(seed, name, made, duration, given)


def started(seed: int) -> Scene:
    """Of one run from rest under a motor that lifts the weights or swings them up."""
    random = np.random.default_rng([7, seed])
    name, made = press(random)
    return Scene(seed, name, made, *_started(random, made))


def batch(seed: int) -> Scene:
    """Of a batch: a crank, without clutch and brake."""
    random = np.random.default_rng([2, seed])
    name, made = press(random)
    while not made.driver_coordinates[0].turns:
        name, made = press(random)
    duration, given = _played(random, made)
    return Scene(seed, name, made, duration, {key: part for key, part in given.items() if key not in ("clutch", "brake")})


def steady(seed: int) -> Scene:
    """Of a steady state: a press that turns round under a motor, with a flywheel, and nothing that depends on time."""
    random = np.random.default_rng([3, seed])
    while True:
        name, made = press(random)
        if made.branch.period:
            duration, given = _played(random, made, heaviest=0.3)
            given.setdefault("flywheel", pp.drives.Flywheel(scale(made).inertia))
            drive = given.get("drive")
            if drive is not None and not drive.timed and turning_speed(drive):
                return Scene(seed, name, made, duration, {key: part for key, part in given.items() if key not in ("clutch", "brake")})


def states(seed: int) -> Scene:
    """Random states of a press under loads, springs and friction, for inverse dynamics: angles, speeds and accelerations (8,)."""
    random = np.random.default_rng([4, seed])
    name, made = press(random)
    size, count = scale(made), 8
    reach = size.high - size.low
    speed = float(np.sqrt(size.weight / size.inertia) * log_uniform(random, 0.3, 5))
    force = size.inertia * speed**2 / made.size
    acting = [link_load(random, made, force) for _ in range(random.integers(3))]
    if size.stroke > 1e-3 * made.size:
        acting += [process_load(random, size.stroke, force) for _ in range(random.integers(2))]
    given: dict[str, Any] = {
        "angle": random.uniform(size.low + 0.05 * reach, size.high - 0.05 * reach, count),
        "speed": speed * random.normal(size=count),
        "acceleration": speed**2 * random.normal(size=count),
        "loads": acting,
        "friction": rubbing(random, made) if random.random() < 0.4 else {},
    }
    return Scene(seed, name, made, 0.0, given)


def cut(seed: int) -> Scene:
    """A random planar linkage with its loops cut in two ways, the second as "other" of what is given, and states of both."""
    random = np.random.default_rng([5, seed])
    drawing = None
    while drawing is None:
        drawing = random_linkages.drawn(linkage_spec(random))
    gravity = tuple(map(float, 10 * random.normal(size=3)))
    made, other = (texts.load(each.urdf("crank"), gravity=gravity) for each in (drawing, same_linkage.cut_elsewhere(drawing, random)))
    return Scene(seed, "random_linkage", made, 0.0, {**random_linkages.servo(made, random), "other": other, "normal": drawing.world[:, 2]})


def turning_speed(drive: Any) -> float:
    """Speed about which a geared motor works, at the driver [rad/s]; 0 of other drives."""
    return 150.0 / drive.ratio if isinstance(drive, pp.drives.Geared) else 0.0


def _started(random: Random, press: Any) -> tuple[float, dict[str, Any]]:
    """A press at rest under a motor on the mains that lifts its weights or swings them up, and a wheel: what solvers over the angle find
    hardest, because a guess at its energy overshoots."""
    size = scale(press)
    reach = size.high - size.low
    wheel = size.inertia * log_uniform(random, 1, 100)
    torque = size.weight * log_uniform(random, 0.3, 1.5)
    speed = float(np.sqrt(size.weight * reach / (wheel + size.inertia)) * log_uniform(random, 0.6, 2.5))
    rated = 50 * np.pi * random.uniform(0.97, 0.993)
    made = drives.InductionMotor(torque * speed, rated, inertia=0.2 * wheel * (speed / rated) ** 2)
    drive = drives.Geared(made, rated / speed, 0.0, float(random.choice([1.0, 0.95])))
    angle = float(random.uniform(size.low + 0.15 * reach, size.high - 0.15 * reach))
    given = {"angle": angle, "speed": 0.0, "drive": drive, "flywheel": pp.drives.Flywheel(wheel)}
    return float(reach / speed * random.uniform(0.3, 1.2)), given


def _played(random: Random, press: Any, heaviest: float = 10.0) -> tuple[float, dict[str, Any]]:
    """Duration and what is given; the largest force does ``heaviest`` times as much work as the wheel holds."""
    if random.random() < 0.3:
        return _started(random, press)
    size = scale(press)
    reach = size.high - size.low
    wheel = size.inertia * log_uniform(random, 0.3, 100)
    torque = size.weight * log_uniform(random, 0.3, 8)
    # a speed at which the wheel carries the press over its weights, or hardly does
    speed = float(np.sqrt(size.weight * reach / (wheel + size.inertia)) * log_uniform(random, 0.3, 5))
    duration = float(min(reach / speed * random.uniform(0.1, 1.0), 20.0))
    start = float(random.choice([0.0, 0.0, random.uniform(-0.1, 0.1), random.uniform(-1, 1), random.uniform(0.5, 1.2)]) * speed)
    angle = float(random.uniform(size.low + 0.15 * reach, size.high - 0.15 * reach))
    if random.random() < 0.2 and press.branch.period:
        angle = float(np.radians(5 * random.integers(72)))
    given: dict[str, Any] = {"angle": angle, "speed": start}
    if random.random() < 0.85:
        given["drive"] = motor(random, torque, speed, duration, angle)
    if random.random() < 0.9:
        given["flywheel"] = drives.Flywheel(wheel)
    acting = []
    energy = 0.5 * (wheel + size.inertia) * speed**2
    if size.stroke > 1e-3 * press.size and random.random() < 0.6:
        force = energy / size.stroke * log_uniform(random, 0.01 * heaviest, heaviest)
        acting += [process_load(random, size.stroke, force) for _ in range(random.choice([1, 1, 1, 2]))]
        if press.branch.period and press.advancing.any():  # without a bottom dead centre
            place = pp.servo_cycle(press, [angle], speed=1.0, acceleration=0.0).slide_position[0]
            acting = [replace(load, datum=float(place) - 0.5 * size.stroke * random.random()) for load in acting]
    if random.random() < 0.2:
        acting.append(link_load(random, press, energy / press.size * log_uniform(random, 0.05, 1)))
    if acting:
        given["loads"] = acting
    couplings = random.random() < 0.35
    way = np.sign(start) or float(random.choice([-1.0, 1.0]))
    turning = press.driver_coordinates[0].turns
    if couplings and turning:
        kinds = int(random.integers(1, 4))
        if kinds & 1:
            opens = drives.SwitchPoint(time=duration * random.uniform(0.5, 1)) if random.random() < 0.3 else None
            closes = switch(random, duration, angle, way)
            given["brake"] = drives.Brake(
                torque * log_uniform(random, 0.1, 5), closes, opens if closes is None else None, random.choice([0.0, 0.05]) * duration
            )
        if kinds & 2 and "flywheel" in given:
            closes = switch(random, duration, angle, way)
            given["clutch"] = drives.Clutch(torque * log_uniform(random, 0.3, 5), closes, rise=random.choice([0.0, 0.05]) * duration)
            given["flywheel"] = drives.Flywheel(wheel, None if closes is None else float(random.choice([start, speed])))
    if turning and random.random() < 0.12:
        given["friction"] = rubbing(random, press)
    return duration, given
