"""The frame of the JF75G-125 on rubber: the findings of Zhang 2007, chapter 2, beside ours, as viz/foundation.md and viz/foundation.png.

python viz/foundation.py
"""

import dataclasses
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import pinpress as pp
from pinpress import figures, foundation

PAGE = Path(__file__).with_suffix(".md")
PICTURE = Path(__file__).with_suffix(".png")

# Assumed (ours), all of it: Zhang 2007 prints nothing of the frame but "ordinary rubber, 10 mm thick, under the base".
BED = foundation.Frame(mass=8000, centre=(0, 0, -1.0), inertia=(3000, 2500, 3000))
CROWN = foundation.Frame(mass=7000, centre=(0, 0.2, 0.4), inertia=(2500, 2000, 2500))  # with flywheel and motor, behind the crank
PAD = foundation.RubberPad(length=0.2, width=0.2, thickness=0.01, hardness=65, loss_factor=0.15, stiffening=1.3)
FEET = [(x, y, -1.3) for x in (-0.55, 0.55) for y in (-0.5, 0.6)]
# four columns, together 2.4 GN/m: 0.5 mm under 1250 kN
COLUMNS = [foundation.Mount((x, y, -0.3), (1e8, 1e8, 6e8), loss_factor=0.02) for x in (-0.55, 0.55) for y in (-0.4, 0.5)]
UNBALANCE = 940 * 0.04e-3  # of the flywheel, 940 kg of grade G 1.6 at 400 per min: 40 um eccentric [kg m]
PILING = pp.loads.Piling(force=50e3, height=4.86e-5)  # what vibrates is proportional to the force, and decays at the same rate
SPRINGS = [foundation.Mount(foot, (1e6, 1e6, 1e6), loss_factor=0.05) for foot in FEET]

MOUNTS = [foundation.pad_mount(foot, PAD) for foot in FEET]
FLYWHEEL = pp.Flywheel(136)
POINTS = {"top beam": ("crown", (0, 0, 0.9)), "column": ("crown", (-0.6, 0.5, 0.1)), "lower beam": (0, 0, -1.1)}
SPEEDS = np.linspace(150, 450, 121) * pp.RPM
PRESSES = {"plain": "jf75g_125_plain", "with its counterweight": "jf75g_125", "symmetric": "jf75g_125_symmetric"}
AT = 350 * pp.RPM  # of the thesis's signals


def systems() -> dict[str, foundation.MountedPress]:
    return {name: foundation.mounted(pp.load(file), BED, MOUNTS, CROWN, COLUMNS) for name, file in PRESSES.items()}


def flywheel_alone(system: foundation.MountedPress, speed: float) -> np.ndarray:
    """Acceleration (rms) of the top beam by the unbalance of the flywheel on a press that stands: a force that turns in the x-z plane."""
    still = system.press.with_inertias([inertia.__class__.Zero() for inertia in system.press.model.inertias])
    turning = foundation.mounted(still, BED, MOUNTS, CROWN, COLUMNS)

    def force(motion: pp.Motion) -> np.ndarray:
        angle = motion.crank_angle
        return UNBALANCE * speed**2 * np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)

    # on the crank, whose bearing hands it to the crown
    result = pp.inverse_dynamics(still, pp.cycle(still, speed, 90), loads=[pp.PointForce("crank", force)])
    return foundation.steady_response(turning, result, POINTS).rms("top beam")


def idle(system: foundation.MountedPress, speed: float) -> foundation.FrameMotion:
    return foundation.steady_response(system, pp.inverse_dynamics(system.press, pp.cycle(system.press, speed)), POINTS)


def struck(system: foundation.MountedPress) -> foundation.FrameMotion:
    """Seven strokes of piling, from rest."""
    run = pp.simulate(system.press, 1.2, AT, flywheel=FLYWHEEL, loads=[PILING], points=48001)
    return foundation.time_response(system, pp.inverse_dynamics(system.press, run, loads=[PILING]), POINTS, FLYWHEEL)


def distortion(motion: foundation.FrameMotion, point: str, axis: int) -> float:
    """Root of the sum of squares of the higher harmonics of the acceleration by the first."""
    size = np.abs(np.fft.rfft(motion.acceleration[point][:, axis]))
    return float(np.sqrt((size[2:] ** 2).sum()) / size[1])


def decay(system: foundation.MountedPress, motion: foundation.FrameMotion) -> tuple[float, float]:
    """Logarithmic decrement of the stretching between two strokes, seen in the signal and of the mode's damping ratio."""
    modes = foundation.modes(system)
    place = modes.motion.index("stretching")
    modal = motion.coordinates @ (system.mass @ modes.shapes[:, place])
    last = np.abs(motion.acceleration["top beam"][:, 2])
    begin = int(last[: len(last) // 2].argmax())
    length = int(5 * 2 * np.pi / modes.natural_frequency[place] / motion.time[1])
    ringing = modal[begin + 100 : begin + 100 + length]
    ratio = float(modes.damping_ratio[place])
    return foundation.logarithmic_decrement(ringing - ringing.mean()), 2 * np.pi * ratio / np.sqrt(1 - ratio**2)


def size(vector: np.ndarray) -> float:
    return float(np.linalg.norm(vector))


def page(machines: dict[str, foundation.MountedPress]) -> str:
    real, plain = machines["with its counterweight"], machines["plain"]
    modes, over = foundation.modes(real), {name: foundation.over_speeds(system, SPEEDS, POINTS) for name, system in machines.items()}
    at = idle(real, AT)
    alone, moving = size(flywheel_alone(real, AT)), size(at.rms("top beam"))
    rpm = SPEEDS / pp.RPM

    def grown(name: str, upper: float, lower: float) -> float:
        total = np.linalg.norm(over[name].rms["top beam"], axis=1)
        return float(np.interp(upper, rpm, total) / np.interp(lower, rpm, total))

    motion = struck(real)
    assert motion.least_load.min() > 0, "a foot lifts off: the linear model does not hold"
    seen, damped = decay(real, motion)
    ends = [size(idle(real, 350 * pp.RPM).rms(point)) for point in POINTS]
    soft = foundation.isolate(plain.press, foundation.Frame(16000, (0, 0, -0.4), (11e3, 10e3, 5500)), SPRINGS, SPEEDS[20:101], 0.6)
    rows = [
        (
            "flywheel alone, 350 per min: vibration very small",
            f"{alone:.2g} m/s² rms on the top beam, {moving / alone:.0f} times less than with the slide",
            "yes",
        ),
        (
            "idle, to 300 per min: not yet marked; 350: strong",
            f"{grown('with its counterweight', 300, 200):.1f} times from 200 to 300 (square of the speed: 2.25),"
            f" {grown('with its counterweight', 350, 300):.1f} times from 300 to 350 (1.36)",
            "yes, with these pads",
        ),
        (
            "idle: signals like a sine, the machine sways",
            f"higher harmonics {100 * distortion(at, 'top beam', 0):.2g} % of the first on the top beam;"
            f" {at.rms('top beam')[0] / moving:.3f} of it along x, across the machine",
            "yes",
        ),
        (
            "the top beam moves more than columns and lower beam",
            ", ".join(f"{point} {end:.3f}" for point, end in zip(POINTS, ends, strict=True)) + " m/s²",
            "yes, a little",
        ),
        ("the motor's side moves more", "the same on both sides: no motor stands aside in our frame", "no"),
        (
            "piling: dies away after every stroke",
            f"logarithmic decrement of the stretching {seen:.3f}, of the mode's damping {damped:.3f}",
            "yes",
        ),
        (
            "so the speed is far from the natural frequencies",
            f"lowest {modes.natural_frequency[0] / 2 / np.pi:.2f} Hz, {modes.resonance_speeds(1)[0, 0] / pp.RPM:.0f} per min",
            "no: what rings is the stretching, at " + f"{modes.natural_frequency[modes.motion.index('stretching')] / 2 / np.pi:.0f} Hz",
        ),
        (
            "rubber or springs below keep it from the floor",
            f"rubber of 10 mm: {over['plain'].transmitted[rpm <= 401].max():.2f} of the shaking force of the plain press comes through at"
            f" most; for 0.6 between 200 and 400 per min: {soft.stiffness[2] / 1e6:.2f} MN/m together, {1e3 * soft.sag:.0f} mm of sag",
            "springs yes, this rubber no",
        ),
    ]
    table = "\n".join(["| Zhang 2007 says | pinpress gives | agrees |", "|---|---|---|"] + ["| " + " | ".join(row) + " |" for row in rows])
    before = ["| press, idle at 350 per min | shaking force, rms | top beam, rms | floor, rms |", "|---|---:|---:|---:|"]
    for name, system in machines.items():
        response = foundation.over_speeds(system, [AT], POINTS)
        top = size(response.rms["top beam"][0])
        before.append(f"| {name} | {response.shaking_force[0]:.4g} N | {top:.2g} m/s² | {response.floor_force[0]:.4g} N |")
    listed = ["| mode | frequency | speed | damping ratio |", "|---|---:|---:|---:|"]
    for name, w, ratio in zip(modes.motion, modes.natural_frequency, modes.damping_ratio, strict=True):
        listed.append(f"| {name} | {w / 2 / np.pi:.2f} Hz | {w / pp.RPM:.0f} per min | {ratio:.3f} |")
    figures.save_plot(picture(machines, over, at, motion), PICTURE)
    parts = [INTRODUCTION, table, NOTES, "What the arrangement does, on the same mounts:\n", "\n".join(before)]
    parts += [
        "\nModes of `jf75g_125`:\n",
        "\n".join(listed),
        f"\nAt rest: {standing(real)}.\n",
        "Other pads, `jf75g_125` idle:\n",
        pads(real),
    ]
    return "\n".join(parts) + "\n"


def standing(system: foundation.MountedPress) -> str:
    """Loads of the mounts, sag and pressure."""
    shares = ", ".join(f"{100 * share:.1f} %" for share in system.load_share)
    pressure = max(pressure for pressure in system.pressure if pressure is not None)
    return (
        f"{shares} of {system.total_mass:.0f} kg on the feet, sag {1e3 * -system.sag[:, 2].min():.3f} mm, {pressure / 1e6:.2f} MPa at most"
    )


def pads(system: foundation.MountedPress) -> str:
    """How much the findings hang on the pads."""
    lines = ["| pads | sway along x | 200 to 300 per min | 300 to 350 per min | at 350 per min |", "|---|---:|---:|---:|---:|"]
    for width in (0.15, 0.2, 0.25):
        for hardness in (55, 65, 75):
            pad = dataclasses.replace(PAD, length=width, width=width, hardness=hardness)
            trial = foundation.mounted(system.press, BED, [foundation.pad_mount(foot, pad) for foot in FEET], crown=CROWN, columns=COLUMNS)
            modes = foundation.modes(trial)
            sway = modes.natural_frequency[modes.motion.index("along x")]
            two, three, most = np.linalg.norm(
                foundation.over_speeds(trial, np.array([200, 300, 350]) * pp.RPM, POINTS).rms["top beam"], axis=1
            )
            lines.append(
                f"| {width:g} x {width:g} m, {hardness} Shore A | {sway / 2 / np.pi:.2f} Hz, {sway / pp.RPM:.0f} per min"
                f" | {three / two:.1f} times | {most / three:.1f} times | {most:.2g} m/s² |"
            )
    return "\n".join(lines)


def picture(
    machines: dict[str, foundation.MountedPress],
    over: dict[str, foundation.SpeedResponse],
    at: foundation.FrameMotion,
    struck: foundation.FrameMotion,
) -> Figure:
    with figures.drawing(16.0) as figure:
        panels = figure.subplots(2, 2)
        for panel, motion, axis, title in (
            (panels[0, 0], at, 0, "idle, 350 per min"),
            (panels[0, 1], struck, 2, "piling, 50 kN, 350 per min"),
        ):
            order = list(POINTS) if axis == 0 else ["lower beam", "top beam"]
            shown = motion.time >= motion.time[-1] - 0.4
            time, periods = 1e3 * (motion.time[shown] - motion.time[shown][0]), 1
            if motion.period is not None:  # two of it
                time, periods = np.concatenate([time, time + 1e3 * motion.period]), 2
            lines = [
                panel.plot(
                    time,
                    np.tile(motion.acceleration[point][shown, axis], periods),
                    color=figures.COLOURS[list(POINTS).index(point)],
                    linewidth=0.9,
                )[0]
                for point in order
            ]
            figures.grid(panel, f"acceleration {'xyz'[axis]} [m/s²]")
            panel.set_title(title, loc="left", pad=18)
            panel.set_xlabel("time [ms]")
            figures.above(panel, lines, order)
        lines = []
        for k, response in enumerate(over.values()):
            total = np.linalg.norm(response.rms["top beam"], axis=1)
            lines += panels[1, 0].plot(SPEEDS / pp.RPM, total, color=figures.COLOURS[k])
        panels[1, 0].set_yscale("log")
        panels[1, 0].set_xlabel("strokes per minute")
        figures.grid(panels[1, 0], "top beam, idle, rms [m/s²]")
        figures.legend(panels[1, 0], lines, list(over), loc="lower right", bbox_to_anchor=(1.0, 0.4))
        frequency = np.geomspace(1, 300, 600)
        lines = [
            panels[1, 1].loglog(frequency, foundation.transmissibility(machines["plain"], 2 * np.pi * frequency, axis), color=colour)[0]
            for axis, colour in (("x", figures.COLOURS[0]), ("z", figures.COLOURS[1]))
        ]
        panels[1, 1].set_xlabel("frequency [Hz]")
        figures.grid(panels[1, 1], "transmissibility of the rubber [-]")
        figures.legend(panels[1, 1], lines, ["along x", "along z"], loc="lower left")
    return figure


INTRODUCTION = """# The JF75G-125 on 10 mm of rubber

Zhang 2007, chapter 2, measured accelerations on the frame, on "ordinary rubber, 10 mm thick". It prints no data of the frame and no scale
of the signals: what can be compared is what it found. Assumed (ours): bed of 8 t and crown of 7 t (with motor and flywheel), columns of
2.4 GN/m, four feet of 0.2 x 0.2 m on rubber of 65 Shore A, loss factor 0.15, dynamic by static stiffness 1.3; a flywheel balanced to
G 1.6; piling with 50 kN, under which no foot lifts off. Nothing is fitted: pads, masses and columns were chosen before the results were
seen. The press is `jf75g_125`, with its counterweight. Written by `python viz/foundation.py`, which also draws
[the picture](foundation.png).
"""
NOTES = """
- The resonance is that of swaying on the rubber, far softer in shear than in compression. Where it lies, and so how strongly the vibration
  grows towards 350 per min, is decided by hardness and size of the pads, which nobody printed: see the last table. That it lies between
  350 and 400 per min is so with three of those nine pads.
- A force within the frame shakes no rigid frame, and linkage and frame are rigid here but for the columns: of the shock of piling the
  model has the stretching between bed and crown, none of the bending of the beams or the noise.
- The stretching dies away after a stroke wherever the speed lies beside the sway's resonance, as the two have nothing to do with each
  other: this decay is no proof that working speed and natural frequencies are apart.
"""

if __name__ == "__main__":
    PAGE.write_text(page(systems()), encoding="utf-8")
    print(PAGE.read_text(encoding="utf-8"))
