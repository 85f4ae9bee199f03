"""What results of measurements show: process forces, spectra, orders, modes, identified parameters, plans."""

from __future__ import annotations

import numpy as np

from ..common.outlets.described import Along, Bars, Block, Chart, Column, Curve, Figure, Map, Mark, Section, Table
from ..common.quantities import Array, quantity
from ..dynamics.reactions import Reactions
from ..foundation.mounted_press import VibrationModes
from .hit_modes import MeasuredModes
from .identification import IdentifiedPress
from .measuring_plan import MeasuringPlan
from .mount_fit import UNSEEN, FittedMounts
from .records import MeasuredRun
from .stroke_force import MeasuredForce
from .vibration_record import VibrationRecord
from .vibration_spectra import OrderSpectra, Spectra
from .what_is_known import IdentifiableParameters

MOST_CHANNELS = 8  # strongest channels, which share one chart
DECADES = 3.0  # decades of amplitude in the colour scale
TURN = 2 * np.pi  # from Hz to rad/s
ROOM = 1.06  # end of a chart of modes, divided by the highest frequency
MOST_NAMES = 4  # most names of parameters that a motion leaves unknown
INTERVAL = "95 % interval"
FREE, DAMPING = "natural frequency", "damping ratio"


def run(found: MeasuredRun, page: Reactions | None = None) -> tuple[Section, ...]:
    """A record: its samples, the speed of the crank, and all signals over the time."""
    low, high = found.speeds
    figures = [
        Figure("samples", str(len(found.time)), where=f"in {quantity('s').text(found.duration, 4)}"),
        Figure("sampled at", TURN / found.sampling, "frequency"),
        Figure("turns of the crank", found.strokes, "number"),
        Figure("lowest speed", low, "rad/s", "over a hundredth of the record"),
        Figure("highest speed", high, "rad/s", "over a hundredth of the record"),
    ]
    if found.resolution is not None:
        figures.append(Figure("step of the encoder", found.resolution, "angle", f"{TURN / found.resolution:.6g} in a turn of the crank"))
    figures += [Figure(f"mass added to {link}", mass, "kg") for link, mass in found.added_mass.items()]

    signals = [(name.replace("_", " "), values, unit) for name, values, unit in found._signals()]
    along, charts = Along("time", "s", found.time), []
    for kind in ("torque", "current", "shaking force", "shaking moment", "height", "angle"):
        curves = [Curve(name, values) for name, values, _ in signals if name.startswith(kind)]
        if curves:
            charts.append(Chart(kind, kind.capitalize(), next(unit for name, _, unit in signals if name.startswith(kind)), along, curves))
    columns = [
        Column("", [name for name, *_ in signals]),
        Column("smallest", [float(values.min()) for _, values, _ in signals]),
        Column("largest", [float(values.max()) for _, values, _ in signals]),
    ]
    table = Table("signals", "Signals", columns, quantities=["height" if name == "height" else unit for name, _, unit in signals])
    return (Section("Record", figures, [*charts, table], note="\n  ".join(found.notes)),)


def force(found: MeasuredForce, page: Reactions | None = None) -> tuple[Section, ...]:
    """A process force over the height of the slide, down and up, with its 95 % band."""
    ways = [("down", found.heights, found.slide_height, found.force, found.interval)]
    if len(found.heights_up):
        ways.append(("up", found.heights_up, found.slide_height_up, found.force_up, found.interval_up))
    curves = []
    for way, _, places, forces, interval in ways:
        rising = np.argsort(places, kind="stable")
        curves.append(Curve(way, forces[rising], places[rising], interval[rising]))
    largest = int(found.force.argmax())
    doubt = f"± {quantity('N').text(2 * float(found.deviation[largest]), 2)}"
    figures = [
        Figure("largest force", float(found.force[largest]), "N", f"{doubt}, at {quantity('m').text(float(found.heights[largest]), 4)}"),
        Figure("work", found.work, "J", f"± {quantity('J').text(2 * found.work_deviation, 2)}"),
        Figure("residuals by noise", found.misfit, "number", f"under force; {found.idle_misfit:.2f} without"),
    ]
    columns = [
        Column("way", [way for way, heights, *_ in ways for _ in heights]),
        Column("height", [float(height) for _, heights, *_ in ways for height in heights], "height"),
        Column("force", [float(value) for *_, forces, _ in ways for value in forces], "N"),
        Column("lowest", [float(low) for *_, interval in ways for low in interval[:, 0]], "N"),
        Column("highest", [float(high) for *_, interval in ways for high in interval[:, 1]], "N"),
    ]
    note = f"Lowest and highest: {INTERVAL}."
    note += " The force has edges between these heights: set them closer where it changes." if found.edges else ""
    chart = Chart("force", "Process force", "N", Along("height above bottom dead centre", "m"), curves)
    return (Section("Measured force", figures, [chart, Table("force", "", columns, most=200)], note=note),)


def record(found: VibrationRecord, page: Reactions | None = None) -> tuple[Section, ...]:
    """Accelerometers with their places and what they measured."""
    sensors = found.accelerometers
    places, along, peaks = [], [], []
    for k, sensor in enumerate(sensors.values()):
        places.append(("crown " if sensor.on_crown else "") + ", ".join(f"{each:.4g}" for each in sensor.place) + " m")
        along.append(sensor.direction if isinstance(sensor.direction, str) else ", ".join(f"{each:.3g}" for each in sensor.along))
        peaks.append(max(float(np.abs(run.acceleration[:, k]).max()) for run in found.runs))
    columns = [Column("channel", list(sensors)), Column("at", places), Column("along", along)]
    for run in found.runs:
        columns.append(Column(f"{run.name}, rms", [float(run.acceleration[:, k].std()) for k in range(len(sensors))], "m/s2"))
    return (Section("Accelerometers", blocks=[Table("channels", "", [*columns, Column("peak", peaks, "m/s2")], most=200)]),)


def spectra(found: Spectra, page: Reactions | None = None) -> tuple[Section, ...]:
    """Spectral densities of the strongest channels in one chart, and of each channel in its own chart."""
    along = Along("frequency", "frequency", TURN * found.frequency[1:])
    size = np.sqrt(np.maximum(found.density[1:], np.finfo(float).tiny))
    strongest = sorted(np.argsort(-found.rms, kind="stable")[:MOST_CHANNELS])
    curves = [Curve(name, size[:, k]) for k, name in enumerate(found.channels)]
    few = "" if len(curves) <= MOST_CHANNELS else f"The {MOST_CHANNELS} strongest of {len(curves)} channels."
    unit, title = "m/s2/√Hz", "Spectra of the acceleration"
    blocks: list[Block] = [Chart("spectra", title, unit, along, [curves[k] for k in strongest], logarithmic="y", note=few)]
    for curve in curves:
        blocks.append(Chart(f"spectrum {curve.name}", curve.name, unit, along, [curve], logarithmic="y", detail=True))
    columns = [
        Column("channel", list(found.channels)),
        Column("rms", found.rms.tolist(), "m/s2"),
        Column("strongest line", (TURN * found.frequency[1 + found.density[1:].argmax(axis=0)]).tolist(), "frequency"),
    ]
    peaks = ", ".join(f"{line:.4g}" for line in found.lines)
    blocks.append(Table("channels", "", columns, most=200))
    return (Section("Spectra", [Figure("peaks", f"{peaks} Hz" if peaks else "none")], blocks),)


def orders(found: OrderSpectra, page: Reactions | None = None) -> tuple[Section, ...]:
    """Amplitudes over speed and frequency, one map for each channel: orders are rays from the origin, natural frequencies are horizontal
    lines."""
    speed, order = np.meshgrid(found.speed, found.order, indexing="ij")
    across, up = Along("crank speed", "rad/s", speed), Along("frequency", "frequency", order * speed)
    strongest = int(found.amplitude.max(axis=(0, 1)).argmax())
    highest = float((order * speed).max())
    beside = () if found.beside is None else found.beside.natural_frequency
    marks = [Mark("calculated", float(w)) for w in beside if w < highest]
    blocks: list[Block] = []
    for k, name in enumerate(found.channels) if len(found.speed) > 1 else ():
        look = {"decades": DECADES, "marks": marks, "detail": k != strongest}
        blocks.append(Map(f"orders {name}", name, "m/s2", across, up, found.amplitude[:, :, k], **look))  # type: ignore[arg-type]
    rows = [(name, place) for k, name in enumerate(found.channels) for place in found.peaks(k)]
    windows = [int(found.of(name, float(found.order[place])).argmax()) for name, place in rows]
    columns = [
        Column("channel", [name for name, _ in rows]),
        Column("order", [float(found.order[place]) for _, place in rows]),
        Column("largest", [float(found.of(name, float(found.order[place])).max()) for name, place in rows], "m/s2"),
        Column("at", [float(found.speed[window]) for window in windows], "rad/s"),
        Column("frequency", [float(found.order[place] * found.speed[k]) for (_, place), k in zip(rows, windows, strict=True)], "frequency"),
    ]
    one = "" if len(found.speed) > 1 else "One window makes no picture over the speed: give fewer turns, or runs at several speeds."
    return (Section("Orders", blocks=[*blocks, Table("orders", "", columns, most=200)], note=one),)


def modes(found: MeasuredModes, page: Reactions | None = None) -> tuple[Section, ...]:
    """Measured modes next to the calculated ones: damping over frequency, and the agreement of all shapes."""
    figures = [
        Figure("hits", str(len(found.hits)), where=f"{len(found.channels)} channels"),
        Figure("noise", found.noise, "share", "of the energy"),
    ]
    w, ratio, doubt = found.natural_frequency, found.damping_ratio, 2 * found.damping_ratio_deviation
    columns = [
        Column("frequency", w.tolist(), "frequency"),
        Column("±", [f"{quantity('frequency').text(2 * float(each), 1)}" for each in found.natural_frequency_deviation]),
        Column("speed", w.tolist(), "rad/s"),
        Column(DAMPING, [f"{value:.4f} ± {each:.1g}" for value, each in zip(ratio, doubt, strict=True)]),
    ]
    blocks: list[Block] = []
    if found.beside is not None:
        columns += _calculated(found, found.beside)
        blocks += _beside(found, found.beside)
    note = "\n  ".join(found.doubts)
    note = note if found.beside is not None else "\n  ".join([*found.doubts, GIVE_MODES])
    return (Section("Measured modes", figures, [*blocks, Table("modes", "", columns, most=200)], note=note),)


GIVE_MODES = "For the modes of a model beside them: modes(beside=foundation.modes(system))."


def _calculated(found: MeasuredModes, beside: VibrationModes) -> list[Column]:
    """Columns of the calculated partners; a mode without a partner has empty cells."""
    partners = [(k, place) if place >= 0 else None for k, place in enumerate(found.partner)]

    def cells(values: Array) -> list[float | None]:
        return [None if pair is None else float(values[pair[1]]) for pair in partners]

    def off(pair: tuple[int, int]) -> str:
        return f"{100 * (beside.natural_frequency[pair[1]] / found.natural_frequency[pair[0]] - 1):+.2f} %"

    return [
        Column("calculated", cells(beside.natural_frequency), "frequency"),
        Column("off by", ["none" if pair is None else off(pair) for pair in partners]),
        Column("damping", ["" if pair is None else f"{beside.damping_ratio[pair[1]]:.4f}" for pair in partners]),
        Column("MAC", ["" if pair is None else f"{found.mac[pair]:.3f}" for pair in partners]),
        Column("motion", ["" if pair is None else beside.motion[pair[1]] for pair in partners]),
    ]


def _beside(found: MeasuredModes, beside: VibrationModes) -> list[Block]:
    w, ratio = found.natural_frequency, found.damping_ratio
    doubt = 2 * found.damping_ratio_deviation
    curves = [
        Curve(
            beside.motion[place],
            np.array([ratio[k], beside.damping_ratio[place]]),
            np.array([w[k], beside.natural_frequency[place]]),
            look="guide",
        )
        for k, place in enumerate(found.partner)
        if place >= 0
    ]
    curves.append(Curve("measured", ratio, w, np.column_stack([ratio - doubt, ratio + doubt]), look="points"))
    curves.append(Curve("calculated", beside.damping_ratio, beside.natural_frequency, look="points"))
    along, highest = Along(FREE, "frequency"), float(max(w.max(), beside.natural_frequency.max()))
    theirs, ours = Along("calculated", "frequency", beside.natural_frequency), Along("measured", "frequency", w)
    return [
        Chart("damping", "Damping of measured and calculated modes", "share", along, curves, reach=(0.0, ROOM * highest)),
        Map("mac", "Agreement of shapes (MAC)", "number", theirs, ours, found.mac, written=True),
    ]


def plan(found: MeasuringPlan, page: Reactions | None = None) -> tuple[Section, ...]:
    """How long each motion is measured, and how well the parameters are known afterwards."""
    left = []
    for names in found.unknown:
        more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        left.append(", ".join(names[:MOST_NAMES]) + more or "nothing")
    motions = [
        Column("motion", list(found.motions)),
        Column("measure", [float(share * found.time) if share else None for share in found.share], "s"),
        Column("alone: worst ±", found.interval_alone.max(axis=1).tolist(), "share"),
        Column("leaves unknown", left),
    ]
    reasons = []
    for why in dict.fromkeys(each for each in found.why if each):
        these = [name for name, each in zip(found.motions, found.why, strict=True) if each == why]
        reasons.append(f"{', '.join(these)}: {why}")
    after = [Column("after the plan", list(found.parameters)), Column(f"{INTERVAL} ±", found.interval.tolist(), "share")]
    proof = f"No other shares make the sum of squares less by more than {quantity('share').text(found.gap, 2)}."
    blocks = [Table("motions", "", motions, "\n  ".join(reasons), most=200), Table("parameters", "Parameters", after, proof, most=200)]
    return (Section("Measuring plan", blocks=blocks),)


def identified(found: IdentifiedPress, page: Reactions | None = None) -> tuple[Section, ...]:
    """Parameters before and after the identification."""
    figures: list[Figure] = []
    if found.motor_constant is not None and found.motor_constant_interval is not None:
        low, high = found.motor_constant_interval
        figures.append(Figure("motor constant at the crank", found.motor_constant, "N m/A", f"{low:.5g} to {high:.5g}"))
    figures.append(Figure("noise of a sample", ", ".join(f"{name} {size:.3g}" for name, size in found.noise.items())))
    values = [0.0 if abs(each.value) < each.posterior * 1e-6 else each.value for each in found.parameters]
    columns = [
        Column("", [each.name for each in found.parameters]),
        Column("before", ["" if each.before is None else f"{each.before:.5g}" for each in found.parameters]),
        Column("found", [f"{value:.5g} {each.unit}" for value, each in zip(values, found.parameters, strict=True)]),
        Column(INTERVAL, [f"{each.low:.5g} to {each.high:.5g}" for each in found.parameters]),
        Column("doubt", ["" if each.doubt is None else f"{each.doubt:.2f}" for each in found.parameters]),
    ]
    note = "Doubt is the standard deviation by that before: what is near 1 was not learnt from these records."
    return (Section("Identified press", figures, [Table("parameters", "", columns, note, most=200)]),)


def fitted(found: FittedMounts, page: Reactions | None = None) -> tuple[Section, ...]:
    """Fitted values of mounts, and measured next to fitted modes."""
    beside, partner = found.measured.beside, found.measured.partner
    motions = [beside.motion[place] if beside is not None and place >= 0 else "" for place in partner]
    unseen = ["the modes do not show it" if high > UNSEEN * low else "" for low, high in found.intervals]
    values = [
        Column("", list(found.names)),
        Column("value", [f"{value:.4f}" for value in found.values]),
        Column(INTERVAL, [f"{low:.4f} to {high:.4f}" for low, high in found.intervals]),
        Column("", unseen),
    ]
    pairs = [
        Column("motion", motions),
        Column("measured", found.measured.natural_frequency.tolist(), "frequency"),
        Column("fitted", found.frequency.tolist(), "frequency"),
        Column(DAMPING, [f"{value:.4f}" for value in found.measured.damping_ratio]),
        Column("fitted", [f"{value:.4f}" for value in found.damping_ratio]),
    ]
    title = f"Mounts fitted to {len(found.frequency)} measured modes"
    return (Section(title, blocks=[Table("values", "", values, most=200), Table("modes", "Modes", pairs, most=200)]),)


def identifiable(found: IdentifiableParameters, page: Reactions | None = None) -> tuple[Section, ...]:
    """What the torque determines, and the uncertainty of each parameter after these runs."""
    sums = Table("sums", "Sums that torque determines, whatever is known before", [Column("", list(found.sums))], most=200)
    if not found.parameters:
        note = "Give runs, identifiability(press, runs), for the doubt that they leave of each parameter."
        return (Section("Identifiable parameters", blocks=[sums], note=note),)
    names = [each.name for each in found.parameters]
    torque, shaking = [each.torque for each in found.parameters], [each.shaking for each in found.parameters]
    series = {"torque": np.minimum(torque, 1.0), "torque, shaking force and moment": np.minimum(shaking, 1.0)}
    note = (
        f"These runs teach {found.learnt:.1f} of {len(names)} parameters by torque, {found.shaking_learnt:.1f} with shaking force."
        " Doubt: 1 for nothing learnt, 0 for fully known."
    )
    columns = [Column("", names), Column("torque", torque, "number"), Column("and shaking force", shaking, "number")]
    blocks: list[Block] = [
        sums,
        Bars("doubt", "Doubt that is left, by that before", "number", names, series),
        Table("doubt", "Doubt", columns, most=200),
    ]
    return (Section("Identifiable parameters", blocks=blocks, note=note),)


SECTIONS = {
    MeasuredRun: run,
    MeasuredForce: force,
    VibrationRecord: record,
    Spectra: spectra,
    OrderSpectra: orders,
    MeasuredModes: modes,
    MeasuringPlan: plan,
    IdentifiedPress: identified,
    FittedMounts: fitted,
    IdentifiableParameters: identifiable,
}
"""How results of this room are described."""
