"""A press on its mounts in reports: loads at rest, modes, vibration, and what reaches the floor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...common import tables
from ...common.quantities import RPM, Array
from ...dynamics.extremes import AXES
from ...dynamics.inputs import Inputs, described
from ...foundation.lifting import LiftingMotion
from ...foundation.mounted_press import MountedPress, VibrationModes
from ...foundation.mounts import Frame
from ...foundation.response import FrameMotion
from ...foundation.speed_response import Isolation, SpeedResponse
from ...foundation.whirl_modes import WhirlDiagram
from ...simulation.elastic.parts_in_words import mounts_in_words
from ..swinging_frame import frame_lines
from .blocks import Block, Figure, Figures, Follows, Line, LineChart, Section, Table, with_prefix
from .shown import Shown, refuse_others

NOTHING = 1e-3  # a direction in which nothing vibrates more than this share of the largest acceleration has no chart, but its numbers
MOST_MODES = 24  # of a table
MOST_DRAWN = 12  # modes of a chart, the lowest
MOST_MOUNTS = 8  # whose loads are drawn, those with the least
DECADE = 10.0  # ratio of largest to smallest value up to which an axis is linear


def standing(system: MountedPress, shown: Shown) -> Section:
    """The section of a press at rest on its mounts; raises `PinpressError` where it is of another press."""
    refuse_others("mounts", system.press, shown)
    load, length = tables.scale("N", system.upward_load.tolist()), tables.scale("m", [0.0])
    pressed = any(pressure is not None for pressure in system.pressure)
    heads = ["mount", "x [m]", "y [m]", "z [m]", f"load [{load.unit}]", "share [%]", "sag [mm]", *(["pressure [MPa]"] if pressed else [])]
    rows = []
    for k, mount in enumerate(system.mounts):
        pressure = system.pressure[k]
        cells = [
            *(f"{value:.4g}" for value in mount.point),
            load.shown(float(system.upward_load[k])),
            f"{100 * system.load_share[k]:.2f}",
        ]
        cells.append(length.shown(float(system.downward_sag[k])))
        rows.append([f"{k + 1}", *cells, *(["" if pressure is None else f"{1e-6 * pressure:.4g}"] if pressed else [])])
    views = [_view(system, "from the front", 0, 2), _view(system, "from the side", 1, 2)]
    centre = ", ".join(f"{round(value, 4) + 0.0:g}" for value in system.centre)
    note = f"{system.total_mass:.6g} kg of frame and press, mean centre of mass at ({centre}) m."
    return Section("On its mounts at rest", [Table("", heads, rows), *views], _inputs(system), note)


def _view(system: MountedPress, where: str, across: int, up: int) -> LineChart:
    """The frame, what stands aside on it, its mounts and the centre of mass of all, seen along a world axis."""
    axes, chains = [across, up], dict[str, list[Array]]()
    for line in frame_lines(system):
        if not line.name.startswith("mount "):
            chains.setdefault(line.name, []).append(line.places)
    lines = []
    for name, some in chains.items():
        for k, walk in enumerate(_walks(some)):
            lines.append(Line(name if k == 0 else f"{name}, part {k + 1}", walk[:, axes[1]], walk[:, axes[0]]))
    points = {"mounts": np.array([mount.point for mount in system.mounts])}
    points |= {f"{name}, centre": np.array([each.body.centre], dtype=float) for name, each in system.attached.items()}
    points |= {"centre of mass": system.centre[None]}
    lines += [Line(name, places[:, axes[1]], places[:, axes[0]], points=True) for name, places in points.items()]
    return LineChart(
        f"The frame {where}, {AXES[up]} over {AXES[across]}", "m", lines, across=f"{AXES[across]} [m]", follows="nothing", square=True
    )


def _walks(chains: Sequence[Array]) -> list[Array]:
    """Chains of places (k, 3) as walks without a jump, one for each set that hangs together; each chain is walked there and back."""
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
    """The parts of the frame and the springs that they stand on, in words."""
    parts = [("frame", system.frame)] if system.crown is None else [("bed", system.frame), ("crown", system.crown)]
    springs = [(name, some) for name, some in (("mounts", system.mounts), ("uprights", system.uprights)) if some]
    aside = [
        (name, "; ".join([described(each.body), *([mounts_in_words(each.springs)] if each.springs else ["bolted on"])]))
        for name, each in system.attached.items()
    ]
    spinning = [(f"rotor {k + 1}", described(rotor)) for k, rotor in enumerate(system.rotors)]
    own = [(name, described(part) if isinstance(part, Frame) else part.title) for name, part in parts]
    return [*own, *((name, mounts_in_words(some)) for name, some in springs), *aside, *spinning]


def modes(found: VibrationModes, shown: Shown) -> Section:
    """The section of the modes; raises `PinpressError` where they are of another press."""
    refuse_others("modes", found.system.press, shown)
    frequencies = found.natural_frequency / (2 * np.pi)
    rows = [
        [motion, f"{frequency:.3f}", f"{60 * frequency:.1f}", f"{ratio:.4f}"]
        for motion, frequency, ratio in zip(found.motion, frequencies, found.damping_ratio, strict=True)
    ][:MOST_MODES]
    return Section("Modes on the mounts", [Table("", ["motion", "frequency [Hz]", "resonance at [r/min]", "damping ratio"], rows)])


def vibration(found: FrameMotion, shown: Shown) -> Section:
    """The section of a vibration over time; raises `PinpressError` where it is of another press."""
    refuse_others("vibration", found.system.press, shown)
    least = found.least_load
    number = int(least.argmin())
    lifts = ", which lifts off unless it is bolted down" if least[number] < 0 else ""
    figures = [
        Figure("shaking force, rms", with_prefix(_rms(found.shaking_force), "N")),
        Figure("force on the floor, rms", with_prefix(_rms(found.floor_force), "N")),
        Figure("least load on a mount", with_prefix(float(least[number]), "N"), f"mount {number + 1} of {len(least)}{lifts}"),
    ]
    rows = [[point, *(f"{value:.4g}" for value in (*found.rms(point), *found.peak(point)))] for point in found.acceleration]
    table = Table("", ["acceleration [m/s²]", *(f"{what} {axis}" for what in ("rms", "peak") for axis in AXES)], rows)
    over = "over one period" if found.period is not None else f"over {found.time[-1]:.6g} s{' from rest' * found.from_rest}"
    blocks: list[Block] = [Figures(figures), *_over_time(found, shown), table]
    return Section("Vibration on the mounts", blocks, _inputs(found.system), f"About the static position, {over}.")


def _over_time(found: FrameMotion, shown: Shown) -> Iterator[LineChart]:
    """Charts of the accelerations along each axis, and of the forces; a period is closed, as the recording is."""
    time = found.time if found.period is None else np.append(found.time, found.period)
    follows: Follows = "time" if len(shown.frames.time) > 1 and abs(time[-1] - shown.frames.time[-1]) <= 1e-6 * time[-1] else "nothing"

    def line(name: str, values: Array) -> Line:
        return Line(name, values if found.period is None else np.append(values, values[0]), time)

    largest = max((float(np.abs(values).max()) for values in found.acceleration.values()), default=0.0)
    for i, axis in enumerate(AXES):
        lines = [line(point, values[:, i]) for point, values in found.acceleration.items()]
        if any(np.abs(each.y).max() > NOTHING * largest for each in lines):
            yield LineChart(f"Acceleration along {axis}", "m/s²", lines, across="time [s]", follows=follows)
    scale = tables.scale("N", [float(np.abs(force).max()) for force in (found.floor_force, found.shaking_force)])
    shaking = np.abs(found.shaking_force).max(axis=0)
    lines = [
        line(f"{name}, {axis}", scale.factor * force[:, i])
        for i, axis in enumerate(AXES)
        for name, force in (("floor", found.floor_force), ("shaking", found.shaking_force))
        if shaking[i] > NOTHING * shaking.max()
    ]
    if lines:
        title = "Force on the floor beside the shaking force, without the weight"
        yield LineChart(title, scale.unit, lines, across="time [s]", follows=follows)


def _rms(vectors: Array) -> float:
    return float(np.sqrt(np.mean(np.sum((vectors - vectors.mean(axis=0)) ** 2, axis=1))))


def over_speeds(found: SpeedResponse, shown: Shown) -> Section:
    """The section of a vibration over the speed; raises `PinpressError` where it is of another press."""
    refuse_others("vibration over the speed", found._press, shown)
    speed = found.speed / RPM
    points = [Line(point, np.linalg.norm(values, axis=1), speed) for point, values in found.rms.items()]
    scale = tables.scale("N", [float(max(found.shaking_force.max(), found.floor_force.max()))])
    forces = [Line(name, scale.factor * force, speed) for name, force in (("floor", found.floor_force), ("shaking", found.shaking_force))]
    blocks = [_over(f"{what}, rms", unit, lines) for what, unit, lines in (("Acceleration", "m/s²", points), ("Force", scale.unit, forces))]
    return Section("Vibration over the speed", blocks, note="Of the idle press, all directions together.")


def _over(title: str, unit: str, lines: list[Line]) -> LineChart:
    """A chart over the speed, with a logarithmic axis where the values differ much."""
    low, high = min(float(line.y.min()) for line in lines), max(float(line.y.max()) for line in lines)
    wide = low > 0 and high > DECADE * low
    return LineChart(title, unit, lines, across="crank speed [r/min]", follows="nothing", logarithmic="y" if wide else "")


def whirling(found: WhirlDiagram, shown: Shown) -> Section:
    """The section of modes over the speed; raises `PinpressError` where they are of another press."""
    refuse_others("modes", found.system.press, shown)
    speed, order = found.speed / RPM, np.argsort(found.frequency[-1])[:MOST_MODES]
    rows = []
    for k in order:
        first, last = (f"{found.frequency[end, k] / (2 * np.pi):.4f}" for end in (0, -1))
        rows.append([f"{k + 1}", first, last, found.words(int(k)), f"{found.damping_ratio[-1, k]:.4f}"])
    heads = ["mode", *(f"at {speed[end]:.4g} r/min [Hz]" for end in (0, -1)), "whirl there", "damping ratio"]
    lines = [Line(f"mode {k + 1}", found.frequency[:, k] / (2 * np.pi), speed) for k in order[:MOST_DRAWN]]
    lines.append(Line("first harmonic of the crank", found.speed / (2 * np.pi), speed))
    critical = ", ".join(f"{each / RPM:.4g}" for each in found.critical_speeds()[:MOST_DRAWN])
    note = f"Lowest critical speeds of the first harmonic: {critical} r/min." if critical else "No critical speed of the first harmonic."
    chart = LineChart("Natural frequency", "Hz", lines, across="crank speed [r/min]", follows="nothing", logarithmic="")
    return Section("Modes while the rotors spin", [chart, Table("", heads, rows)], _inputs(found.system), note)


def lifting(found: LiftingMotion, shown: Shown) -> Section:
    """The section of a vibration with feet that lift off; raises `PinpressError` where it is of another press."""
    rest = vibration(found.motion, shown)
    rows = []
    for number in np.unique(found.mount):
        which = found.mount == number
        longest, gap = 1e3 * float((found.end - found.start)[which].max()), 1e3 * float(found.gap[which].max())
        walked = 1e3 * float(np.abs(found.walked[number - 1]).max())
        rows.append([f"{number}", f"{int(which.sum())}", *(f"{value:.4g}" for value in (longest, gap, walked))])
    table = Table("Feet that lift off", ["mount", "lifts", "longest [ms]", "largest gap [mm]", "walked [mm]"], rows)
    after = "" if not len(found.change) else " It does not repeat itself." if found.repeats_after is None else " It repeats itself."
    note = f"Mounts press and do not pull; {len(found.mount)} lifts over {found.motion.time[-1]:.6g} s.{after}"
    blocks = list(rest.blocks)
    if rows:
        blocks[:0] = [table, _loads(found.motion)]
    return Section("Vibration on mounts that only press", blocks, rest.inputs, note)


def _loads(motion: FrameMotion) -> LineChart:
    """The force on each mount over time, weight included; nothing where a foot has lifted off."""
    force = (motion.mount_force + motion.system.mount_load)[:, :, 2]
    scale = tables.scale("N", [float(np.abs(force).max())])
    drawn = np.sort(np.argsort(force.min(axis=0), kind="stable")[:MOST_MOUNTS])
    lines = [Line(f"mount {k + 1}", scale.factor * force[:, k], motion.time) for k in drawn]
    title = "Force on each mount, weight included"
    return LineChart(title, scale.unit, lines, across="time [s]", follows="nothing")


def isolation(found: Isolation, shown: Shown) -> Section:
    """The section of mounts that isolate; raises `PinpressError` where they are of another press."""
    refuse_others("isolation", found.system.press, shown)
    worst = int(found.transmitted.argmax())
    figures = [
        Figure("stiffness of the mounts", f"{found.factor:.4g}", "times those given"),
        Figure("sag at rest", f"{1e3 * found.sag:.4g} mm"),
        Figure("transmitted", f"{100 * found.transmitted[worst]:.4g} %", f"at most, at {found.speed[worst] / RPM:.4g} r/min"),
    ]
    chart = _over("Force on the floor by shaking force", "%", [Line("transmitted", 100 * found.transmitted, found.speed / RPM)])
    rest = standing(found.system, shown)
    inputs = [("mounts that isolate" if name == "mounts" else name, words) for name, words in rest.inputs]
    return Section("The stiffest mounts that isolate", [Figures(figures), chart, *rest.blocks], inputs, rest.note)
