"""What a press on its mounts shows: loads at rest, modes, vibration, feet that lift off, and the force on the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..common.outlets.described import Along, Block, Chart, Column, Curve, Figure, Section, Table
from ..common.quantities import RPM, Array, quantity
from ..dynamics.extremes import AXES
from ..dynamics.inputs import Inputs, described, row
from ..dynamics.reactions import Reactions
from ..loads.mounts import Frame
from ..simulation.elastic.parts_in_words import mounts_in_words
from .elastic_frame import ElasticFrame
from .frame_lines import frame_lines
from .lifting import LiftingMotion
from .mounted_press import MountedPress, VibrationModes, natural_modes
from .response import FrameMotion, rms_about_mean
from .speed_response import Isolation, SpeedResponse
from .whirl_modes import WhirlDiagram

NOTHING = 1e-3  # a direction with a smaller share of the largest acceleration gets numbers, but no chart
MOST_MODES = 24  # modes in a table
MOST_DRAWN = 12  # modes in a chart, the lowest ones
MOST_MOUNTS = 8  # mounts whose loads are drawn, those with the smallest loads
SPEED = "crank speed"


def standing(system: MountedPress, page: Reactions | None = None) -> tuple[Section, ...]:
    """A press at rest on its mounts."""
    places = np.array([mount.point for mount in system.mounts])
    columns = [
        Column("mount", [str(k + 1) for k in range(len(places))]),
        *(Column(f"{axis} [m]", places[:, i].tolist()) for i, axis in enumerate(AXES)),
        Column("load", system.upward_load.tolist(), "N"),
        Column("share", system.load_share.tolist(), "share"),
        Column("sag", system.downward_sag.tolist(), "length"),
    ]
    if any(pressure is not None for pressure in system.pressure):
        columns.append(Column("pressure", list(system.pressure), "Pa"))
    views = [_view(system, "front", 0, 2), _view(system, "side", 1, 2)]
    centre = ", ".join(f"{round(value, 4) + 0.0:g}" for value in system.centre)
    note = f"{system.total_mass:.6g} kg of frame and press, mean centre of mass at ({centre}) m."
    blocks: list[Block] = [Table("mounts", "", columns, most=200), *views]
    return (Section("On its mounts at rest", (), blocks, _inputs(system), note, system.press, "mounts"),)


def _view(system: MountedPress, where: str, across: int, up: int) -> Chart:
    """The frame, its attachments, its mounts and the centre of mass of everything, seen along a world axis."""
    chains = dict[str, list[Array]]()
    for line in frame_lines(system):
        if not line.name.startswith("mount "):
            chains.setdefault(line.name, []).append(line.places)
    curves = []
    for name, some in chains.items():
        for k, walk in enumerate(_walks(some)):
            curves.append(Curve(name if k == 0 else f"{name}, part {k + 1}", walk[:, up], walk[:, across]))
    points = {"mounts": np.array([mount.point for mount in system.mounts])}
    points |= {f"{name}, centre": np.array([each.body.centre], dtype=float) for name, each in system.attached.items()}
    points |= {"centre of mass": system.centre[None]}
    curves += [Curve(name, places[:, up], places[:, across], look="points") for name, places in points.items()]
    title = f"The frame from the {where}, {AXES[up]} over {AXES[across]}"
    return Chart(f"frame_{where}", title, "m", Along(AXES[across], "m"), curves, square=True)


def _walks(chains: Sequence[Array]) -> list[Array]:
    """Chains of places (k, 3) as walks without a jump, one walk for each connected set. A walk follows each chain there and back."""
    at: dict[bytes, list[int]] = {}
    for k, chain in enumerate(chains):
        for end in chain[[0, -1]] + 0.0:  # -0.0 is the same place
            at.setdefault(end.tobytes(), []).append(k)
    left, found = set(range(len(chains))), list[Array]()
    for first in range(len(chains)):
        if first not in left:
            continue
        place, back = chains[first][0], list[Array]()
        walk = [place[None]]
        while True:
            here = at[(place + 0.0).tobytes()]
            while here and here[-1] not in left:
                here.pop()
            if here:
                chain = chains[here[-1]]
                left.remove(here.pop())
                way = chain if np.array_equal(chain[0], place) else chain[::-1]
                back.append(way[::-1])
            elif back:
                way = back.pop()
            else:
                break
            walk.append(way[1:])
            place = way[-1]
        found.append(np.vstack(walk))
    return found


def _inputs(system: MountedPress) -> Inputs:
    """The parts of the frame and their springs, as text."""
    parts = [("frame", system.frame)] if system.crown is None else [("bed", system.frame), ("crown", system.crown)]
    springs = [(name, some) for name, some in (("mounts", system.mounts), ("uprights", system.uprights)) if some]
    aside = [
        (name, "; ".join([described(each.body), *([mounts_in_words(each.springs)] if each.springs else ["bolted on"])]))
        for name, each in system.attached.items()
    ]
    spinning = [(f"rotor {k + 1}", described(rotor)) for k, rotor in enumerate(system.rotors)]
    own = [row(name, part) if isinstance(part, Frame) else (name, part.title) for name, part in parts]
    return [*own, *((name, mounts_in_words(some)) for name, some in springs), *aside, *spinning]


def bending_frame(found: ElasticFrame, page: Reactions | None = None) -> tuple[Section, ...]:
    """The interfaces of a frame that bends, and its lowest free vibrations."""
    uses = [
        ", ".join(
            ["bed"] * (name == found.bed)
            + ["crank and guides"] * (name == found.carrier)
            + [bearing for bearing, node in found.bearings.items() if node == name]
        )
        for name in found.nodes
    ]
    places = [", ".join(f"{value:.4g}" for value in place) for place in found.nodes.values()]
    interfaces = [Column("interface", list(found.nodes)), Column("place [m]", places), Column("carries", uses)]
    lowest = ", ".join(f"{w / (2 * np.pi):.4g}" for w in found.natural_frequency[:6])
    figures = [Figure("mass", found.mass, "kg"), Figure("free vibrations", f"{lowest} Hz")]
    return (Section("Frame that bends", figures, [Table("interfaces", "", interfaces, most=200)]),)


def modes(found: VibrationModes, page: Reactions | None = None) -> tuple[Section, ...]:
    """The modes on the mounts."""
    frequency = found.natural_frequency
    columns = [
        Column("motion", list(found.motion)),
        Column("frequency", frequency.tolist(), "frequency"),
        Column("resonance at", frequency.tolist(), "rotational speed"),
        Column("damping ratio", found.damping_ratio.tolist(), "number"),
    ]
    return (Section("Modes on the mounts", (), [Table("modes", "", columns, most=MOST_MODES)], (), "", found.system.press, "modes"),)


def vibration(found: FrameMotion, page: Reactions | None = None) -> tuple[Section, ...]:
    """The vibration over time, about the static position."""
    least, system = found.least_load, found.system
    number = int(least.argmin())
    lifts = ", which lifts off unless it is bolted down" if least[number] < 0 else ""
    figures = [
        Figure("shaking force, rms", rms_about_mean(found.shaking_force), "N"),
        Figure("force on the floor, rms", rms_about_mean(found.floor_force), "N", kind="floor"),
        Figure("least load on a mount", float(least[number]), "N", f"mount {number + 1} of {len(least)}{lifts}", kind="floor"),
    ]
    pressures = [pressure for pressure in system.pressure if pressure is not None]
    figures += [Figure("mean pressure at rest", max(pressures), "Pa", "at most")] if pressures else []
    figures.append(Figure("sag at rest", float(np.abs(system.downward_sag).max()), "m", "at most"))
    values = {
        f"{what} {axis}": [float(size(point)[i]) for point in found.acceleration]
        for what, size in (("rms", found.rms), ("peak", found.peak))
        for i, axis in enumerate(AXES)
    }
    columns = [Column("acceleration", list(found.acceleration)), *(Column(head, cells, "m/s2") for head, cells in values.items())]
    over = f"over one period of {found.period:.6g} s" if found.period is not None else f"over {found.time[-1]:.6g} s"
    over += " from rest" * (found.period is None and found.from_rest)
    blocks: list[Block] = [*_over_time(found), Table("accelerations", "", columns)]
    note = f"On {len(system.mounts)} mounts, about the static position, {over}."
    return (Section("Vibration on the mounts", figures, blocks, _inputs(system), note, system.press, "vibration"),)


def _over_time(found: FrameMotion) -> list[Chart]:
    """Charts of the accelerations along each axis, and of the forces."""
    along = Along("time", "s", found.time, period=found.period)
    largest = max((float(np.abs(values).max()) for values in found.acceleration.values()), default=0.0)
    charts = []
    for i, axis in enumerate(AXES):
        curves = [Curve(point, values[:, i]) for point, values in found.acceleration.items()]
        if any(np.abs(each.y).max() > NOTHING * largest for each in curves):
            charts.append(Chart(f"acceleration {axis}", f"Acceleration along {axis}", "m/s2", along, curves))
    shaking = np.abs(found.shaking_force).max(axis=0)
    forces = [
        Curve(f"{name}, {axis}", force[:, i])
        for i, axis in enumerate(AXES)
        for name, force in (("floor", found.floor_force), ("shaking", found.shaking_force))
        if shaking[i] > NOTHING * shaking.max()
    ]
    title = "Force on the floor next to the shaking force, without the weight"
    return [*charts, *([Chart("floor", title, "N", along, forces)] if forces else [])]


def over_speeds(found: SpeedResponse, page: Reactions | None = None) -> tuple[Section, ...]:
    """The vibration of the idle press over the speed."""
    along = Along(SPEED, "rad/s", found.speed)
    points = {point: np.linalg.norm(values, axis=1) for point, values in found.rms.items()}
    forces = {"floor": found.floor_force, "shaking": found.shaking_force}
    blocks: list[Block] = []
    if points:
        blocks.append(_over("points", "Acceleration, rms", "m/s2", along, points))
    blocks.append(_over("floor", "Force, rms", "N", along, forces))
    if found.shaking_force.all():
        blocks.append(_over("transmitted", "Force on the floor by shaking force", "share", along, {"transmitted": found.transmitted}))
    columns = [
        Column("speed", found.speed.tolist(), "rad/s"),
        *(Column(point, values.tolist(), "m/s2") for point, values in points.items()),
        Column("shaking", found.shaking_force.tolist(), "N"),
        Column("floor", found.floor_force.tolist(), "N"),
    ]
    blocks.append(Table("over_speed", "", columns))
    note = "Of the idle press, root mean square, all directions together."
    return (Section("Vibration over the speed", (), blocks, (), note, found._press, "vibration over the speed"),)


def _over(name: str, title: str, unit: str, along: Along, values: dict[str, Array]) -> Chart:
    """A chart over the speed, with a logarithmic axis if the values differ much."""
    low, high = min(float(each.min()) for each in values.values()), max(float(each.max()) for each in values.values())
    wide = low > 0 and high > 10.0 * low
    curves = [Curve(curve, each) for curve, each in values.items()]
    return Chart(name, title, unit, along, curves, logarithmic="y" if wide else "")


def whirling(found: WhirlDiagram, page: Reactions | None = None) -> tuple[Section, ...]:
    """Natural frequencies over the speed, with the first two harmonics of the crank and the points where they meet."""
    order = np.argsort(found.frequency[-1])[:MOST_MODES]
    columns = [
        Column("mode", [str(k + 1) for k in order]),
        *(Column(f"at {found.speed[end] / RPM:.4g} r/min", found.frequency[end, order].tolist(), "frequency") for end in (0, -1)),
        Column("whirl there", [found.words(int(k)) for k in order]),
        Column("damping ratio", found.damping_ratio[-1, order].tolist(), "number"),
    ]
    curves = []
    for k in order[:MOST_DRAWN]:
        backward = found.words(int(k)) == "backward"
        curves.append(Curve(f"mode {k + 1}{', backward' * backward}", found.frequency[:, k], look="limit" if backward else "line"))
    curves += [Curve(f"harmonic {harmonic} of the crank", harmonic * found.speed, look="guide") for harmonic in (1, 2)]
    met = [(float(speed), harmonic * float(speed)) for harmonic in (1, 2) for speed in found.critical_speeds(harmonic)]
    inside = np.array([pair for pair in met if found.speed[0] <= pair[0] <= found.speed[-1]]).reshape(-1, 2)
    curves += [Curve("critical speeds", inside[:, 1], inside[:, 0], look="points")] if len(inside) else []
    critical = ", ".join(f"{each / RPM:.4g}" for each in found.critical_speeds()[:MOST_DRAWN])
    note = f"Lowest critical speeds of the first harmonic: {critical} r/min." if critical else "No critical speeds of the first harmonic."
    chart = Chart("whirl", "Natural frequency", "frequency", Along(SPEED, "rad/s", found.speed), curves)
    blocks: list[Block] = [chart, Table("modes", "", columns)]
    return (Section("Modes while the rotors spin", (), blocks, _inputs(found.system), note, found.system.press, "modes"),)


def lifting(found: LiftingMotion, page: Reactions | None = None) -> tuple[Section, ...]:
    """A vibration with feet that lift off."""
    (rest,) = vibration(found.motion, page)
    numbers = [int(number) for number in np.unique(found.mount)]
    which = {number: found.mount == number for number in numbers}
    columns = [
        Column("mount", numbers),
        Column("lifts", [int(some.sum()) for some in which.values()]),
        Column("longest", [float((found.end - found.start)[some].max()) for some in which.values()], "s"),
        Column("largest gap", [float(found.gap[some].max()) for some in which.values()], "m"),
        Column("walked", [float(np.abs(found.walked[number - 1]).max()) for number in numbers], "m"),
    ]
    after = ""
    if len(found.change):
        changed = quantity("share").text(float(found.change[-1]))
        every = {None: f"does not repeat itself, the last stroke changed it by {changed}", 1: "repeats itself every stroke"}
        after = f" It {every.get(found.repeats_after, f'repeats itself every {found.repeats_after} strokes')}."
    lifts = f"{len(found.mount)} lifts" if numbers else "no mount lifts off"
    note = f"Mounts press and do not pull; {lifts} over {found.motion.time[-1]:.6g} s.{after} {rest.note}"
    blocks = [Table("lifts", "Feet that lift off", columns), _loads(found.motion), *rest.blocks] if numbers else list(rest.blocks)
    return (replace(rest, title="Vibration on mounts that only press", blocks=blocks, note=note),)


def _loads(motion: FrameMotion) -> Chart:
    """The force on each mount over time, weight included; no curve while its foot has lifted off."""
    force = (motion.mount_force + motion.system.mount_load)[:, :, 2]
    drawn = np.sort(np.argsort(force.min(axis=0), kind="stable")[:MOST_MOUNTS])
    curves = [Curve(f"mount {k + 1}", force[:, k]) for k in drawn]
    return Chart("mount_forces", "Force on each mount, weight included", "N", Along("time", "s", motion.time), curves)


def isolation(found: Isolation, page: Reactions | None = None) -> tuple[Section, ...]:
    """Mounts that isolate."""
    worst = int(found.transmitted.argmax())
    together = " ".join(quantity("N/m").text(value, 4) for value in found.stiffness)
    frequencies = ", ".join(f"{w / (2 * np.pi):.3g}" for w in np.sqrt(natural_modes(found.system)[0]))
    figures = [
        Figure("stiffness of the mounts", found.factor, "-", f"times those given; together {together} along x, y, z"),
        Figure("natural frequencies", f"{frequencies} Hz"),
        Figure("sag at rest", found.sag, "m"),
        Figure("transmitted", float(found.transmitted[worst]), "share", f"at most, at {found.speed[worst] / RPM:.4g} r/min", kind="floor"),
    ]
    along = Along(SPEED, "rad/s", found.speed)
    chart = _over("transmitted", "Force on the floor by shaking force", "share", along, {"transmitted": found.transmitted})
    (rest,) = standing(found.system, page)
    inputs = [("mounts that isolate" if name == "mounts" else name, words) for name, words in rest.inputs]
    title = "The stiffest mounts that isolate"
    return (Section(title, figures, [chart, *rest.blocks], inputs, rest.note, found.system.press, "isolation"),)


SECTIONS = {
    MountedPress: standing,
    ElasticFrame: bending_frame,
    VibrationModes: modes,
    FrameMotion: vibration,
    SpeedResponse: over_speeds,
    WhirlDiagram: whirling,
    LiftingMotion: lifting,
    Isolation: isolation,
}
"""How results of this room are described."""
