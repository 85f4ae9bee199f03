"""The frame of the JF75G-125 on rubber: the findings of Zhang 2007, chapter 2, beside ours, as viz/foundation.md and viz/foundation.png."""

import dataclasses

import numpy as np
from make import VIZ, write
from matplotlib.figure import Figure
from support.markdown import table
from validation import zhang2007_vibration as vibration

import pinpress as pp
from pinpress import foundation
from pinpress.plots import style as figures


def page(model: vibration.Vibration) -> str:
    """The page in Markdown."""
    real = model.machines[vibration.REAL]
    modes = foundation.modes(real)
    idle = []
    for name, system in model.machines.items():
        response = foundation.over_speeds(system, [vibration.AT], points=vibration.POINTS)
        top = float(np.linalg.norm(response.rms["top beam"][0]))
        idle.append((name, f"{response.shaking_force[0]:.4g} N", f"{top:.2g} m/s²", f"{response.floor_force[0]:.4g} N"))
    listed = zip(modes.motion, modes.natural_frequency, modes.damping_ratio, strict=True)
    vibrating = [(name, f"{w / 2 / np.pi:.2f} Hz", f"{w / pp.RPM:.0f} per min", f"{ratio:.3f}") for name, w, ratio in listed]
    parts = [
        INTRODUCTION,
        table(("Zhang 2007 says", "pinpress gives", "agrees"), [(each.says, each.gives, each.agrees) for each in model.findings()]),
        NOTES,
        "What the arrangement does, on the same mounts:\n",
        table(("press, idle at 350 per min", "shaking force, rms", "top beam, rms", "floor, rms"), idle, 3),
        "\nModes of `jf75g_125`:\n",
        table(("mode", "frequency", "speed", "damping ratio"), vibrating, 3),
        f"\nAt rest: {standing(real)}.\n",
        "Other pads, `jf75g_125` idle:\n",
        pads(real),
        "\nPiling harder, `jf75g_125` with feet that are not bolted down (`foundation.lifting_response`), seven strokes from rest:\n",
        harder(model),
        HARDER,
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
    """How much the findings depend on the pads."""
    rows = []
    for width in (0.15, 0.2, 0.25):
        for hardness in (55, 65, 75):
            pad = dataclasses.replace(vibration.PAD, length=width, width=width, hardness=hardness)
            trial = vibration.standing(system.press, pad)
            modes = foundation.modes(trial)
            sway = modes.natural_frequency[modes.motion.index("along x")]
            two, three, most = np.linalg.norm(
                foundation.over_speeds(trial, np.array([200, 300, 350]) * pp.RPM, points=vibration.POINTS).rms["top beam"], axis=1
            )
            frequency = f"{sway / 2 / np.pi:.2f} Hz, {sway / pp.RPM:.0f} per min"
            growth = f"{three / two:.1f} times", f"{most / three:.1f} times", f"{most:.2g} m/s²"
            rows.append((f"{width:g} x {width:g} m, {hardness} Shore A", frequency, *growth))
    return table(("pads", "sway along x", "200 to 300 per min", "300 to 350 per min", "at 350 per min"), rows, 4)


def harder(model: vibration.Vibration) -> str:
    """What feet that lift off make of harder blows."""
    heads = ("force", "lifts", "highest", "longest", "walked", "most on the floor, beside the weight", "of the linear model")
    rows = []
    system = model.machines[vibration.REAL]
    for force in FORCES:
        blows = vibration.blows(system, dataclasses.replace(vibration.PILING, force=force))
        linear = foundation.time_response(system, blows, points={})
        found = foundation.lifting_response(system, blows, points={})
        gap, longest = (1e3 * float(values.max(initial=0.0)) for values in (found.gap, found.end - found.start))
        most, pulled = (-1e-3 * float(each.floor_force[:, 2].min()) for each in (found.motion, linear))
        walked = 1e3 * np.abs(found.walked).max()
        lifts = len(found.mount), f"{gap:.3g} mm", f"{longest:.3g} ms", f"{walked:.2g} mm"
        rows.append((f"{1e-3 * force:g} kN", *lifts, f"{most:.4g} kN", f"{pulled:.4g} kN"))
    return table(heads, rows, 6)


def picture(model: vibration.Vibration) -> Figure:
    points = list(vibration.POINTS)
    with figures.drawing(16.0) as figure:
        panels = figure.subplots(2, 2)
        for panel, motion, axis, title in (
            (panels[0, 0], model.idle, 0, "idle, 350 per min"),
            (panels[0, 1], model.struck, 2, "piling, 50 kN, 350 per min"),
        ):
            order = points if axis == 0 else ["lower beam", "top beam"]
            shown = motion.time >= motion.time[-1] - 0.4
            time, periods = 1e3 * (motion.time[shown] - motion.time[shown][0]), 1
            if motion.period is not None:  # two of it
                time, periods = np.concatenate([time, time + 1e3 * motion.period]), 2
            lines = [
                panel.plot(
                    time,
                    np.tile(motion.acceleration[point][shown, axis], periods),
                    color=figures.COLOURS[points.index(point)],
                    linewidth=0.9,
                )[0]
                for point in order
            ]
            figures.grid(panel, f"acceleration {'xyz'[axis]} [m/s²]")
            panel.set_title(title, loc="left", pad=18)
            panel.set_xlabel("time [ms]")
            figures.above(panel, lines, order)
        lines = []
        for k, name in enumerate(model.machines):
            lines += panels[1, 0].plot(vibration.SPEEDS / pp.RPM, model.top_beam(name), color=figures.COLOURS[k])
        panels[1, 0].set_yscale("log")
        panels[1, 0].set_xlabel("strokes per minute")
        figures.grid(panels[1, 0], "top beam, idle, rms [m/s²]")
        figures.legend(panels[1, 0], lines, list(model.machines), loc="lower right", bbox_to_anchor=(1.0, 0.4))
        frequency, plain = np.geomspace(1, 300, 600), model.machines["plain"]
        lines = [
            panels[1, 1].loglog(frequency, foundation.transmissibility(plain, 2 * np.pi * frequency, axis=axis), color=colour)[0]
            for axis, colour in (("x", figures.COLOURS[0]), ("z", figures.COLOURS[1]))
        ]
        panels[1, 1].set_xlabel("frequency [Hz]")
        figures.grid(panels[1, 1], "transmissibility of the rubber [-]")
        figures.legend(panels[1, 1], lines, ["along x", "along z"], loc="lower left")
    return figure


INTRODUCTION = """# The JF75G-125 on 10 mm of rubber

Zhang 2007, chapter 2, measured accelerations on the frame, on "ordinary rubber, 10 mm thick". It prints no data of the frame and no scale
of the signals, so only its findings can be compared. The press is `jf75g_125`, with its counterweight. We assume:

- a bed of 8 t and a crown of 7 t; the flywheel (940 kg and 136 kg m², printed) is bolted to the crown 0.75 m beside the press's plane, the
  motor (450 kg) 0.9 m beside it; columns of 2.4 GN/m;
- four feet of 0.2 x 0.2 m on rubber of 65 Shore A, with a loss factor of 0.15 and a ratio of dynamic to static stiffness of 1.3;
- a flywheel balanced to G 1.6; piling with 50 kN, because under 100 kN a foot lifts off, where the linear model ends.

Nothing is fitted: we chose pads, masses and columns before we saw results. Setting flywheel and motor apart later left mass and centre of
the whole crown as they were. Written by `python docs/make.py foundation`, which also draws [the picture](foundation.png).
"""
FORCES = (50e3, 100e3, 1250e3)  # the nominal force of the press last [N]
HARDER = """
Under the nominal force the frame would hop by millimetres if nothing held it down: the blow ends at once, and bed and crown swing on the
columns (the frame stretches here, but does not bend). In the linear model the feet pull instead.
"""
NOTES = """
- The resonance is that of swaying on the rubber, which is far softer in shear than in compression. Hardness and size of the pads, which the
  thesis does not print, decide where it lies, and so how strongly the vibration grows towards 350 per min (see the table of pads). It lies
  between 350 and 400 per min with three of those nine pads.
- A force within the frame does not shake a rigid frame. Linkage and frame are rigid here except for the columns. So the model shows the
  stretching between bed and crown under the shock of piling, but not the bending of the beams or the noise.
- Motor and flywheel put the centre of mass 75 mm beside the press's plane; the middle of the feet lies 50 mm beside it. Below the
  resonance of the sway the shaking force, which acts in the plane, twists the frame one way, and the inertia of the swaying frame twists
  it the other way. The two cancel on the columns at 300 per min; towards the resonance the inertia wins.
- The gyroscopic moment of the flywheel is in the model. It changes no natural frequency by more than 5e-5 up to 600 per min, because this
  frame turns too slowly about x and z.
- The stretching dies away after each stroke at any speed, whatever the resonance of the sway. So this decay does not prove
  that working speed and natural frequencies are far apart.
"""


def main(quick: bool = False) -> None:
    """Write the page and draw its picture."""
    model = vibration.Vibration()
    write(VIZ / "foundation.md", page(model))
    write(VIZ / "foundation.png", picture(model))
