"""What an engineer reads off a simulated run, as text."""

from collections.abc import Sequence

import numpy as np

from ..common.units import RPM
from ..dynamics.inverse_dynamics import Reactions
from ..dynamics.summary import _bearings
from ..kinematics.dead_centres import stroke_turns
from ..linkage.linkage import Linkage
from .duty_cycle import Duty, duty, strokes
from .run import Run

MOST_STROKES = 8  # listed in full
FIRST_STROKES = 5  # listed of more, with the last one


def simulation_summary(press: Linkage, run: Run, result: Reactions, scene: Sequence[tuple[str, str]], steady: bool = False) -> str:
    """Speeds, energies, the motor's torque, strokes and bearing forces of a run, and how well the equations are fulfilled.

    Args:
        result: of the inverse dynamics of this run, under its loads; its driving torque is what flywheel, drive, clutch and brake give
            together. scene: what was simulated, names and words. steady: whether the run is the period of a steady state.

    Extremes of speed and of the motor's torque are those of 720 states a turn, works are exact; torques and forces of the crank and the
    bearings are the largest of the run's states. Signs as in `reactions`.
    """
    whole = duty(run)
    lines = [
        f"{press.name}: {'a period of its steady state, ' if steady else ''}{run.time[-1]:.6g} s, {len(run.crank_angle)} states,"
        f" method {run.stats.method!r}",
        *(f"  {name:26}{words}" for name, words in scene),
        *_end(run, steady),
        *_speeds(whole, steady),
        *_work(whole),
        *_motor(run, whole),
        *_torque(result),
        *_strokes(strokes(run), stroke_turns(run.problem.driven.press)),
        *_bearings(run, result),
        "",
        "Checks",
        f"  {'largest loop gap':26}{run.stats.closure_error:12.3g} m",
        f"  {'energy error':26}{run.stats.energy_error:12.3g} of the largest energy",
        f"  {'largest power residual':26}{np.abs(result.power_residual).max():12.3g} of the peak power",
        f"  {'steps':26}{run.stats.steps:12d}        {run.stats.evaluations} evaluations",
    ]
    return "\n".join(lines)


def _end(run: Run, steady: bool) -> list[str]:
    angle = np.degrees(run.crank_angle)
    turns = f"{(angle[-1] - angle[0]) / 360 + 0.0:.6g} turns from the start"
    return [
        "",
        "At the end, as at the start" if steady else "At the end",
        f"  {'crank angle':26}{angle[-1]:12.3f} deg    {turns}",
        f"  {'crank speed':26}{run.crank_speed[-1] / RPM:12.6g} r/min",
    ]


def _speeds(whole: Duty, steady: bool) -> list[str]:
    recovery = [f"  {'from lowest to highest':26}{whole.recovery_time:12.6g} s"] if steady else []
    return [
        "",
        "Crank speed",
        f"  {'mean':26}{whole.mean_speed / RPM:12.6g} r/min",
        f"  {'highest':26}{whole.highest_speed / RPM:12.6g} r/min",
        f"  {'lowest':26}{whole.lowest_speed / RPM:12.6g} r/min",
        f"  {'speed drop':26}{100 * whole.speed_drop:12.6g} %      of the mean",
        *recovery,
    ]


def _work(whole: Duty) -> list[str]:
    return [
        "",
        "Work",
        f"  {'drive':26}{whole.drive_work:12.6g} J      on the crank's shaft",
        f"  {'loads':26}{whole.load_work:12.6g} J      taken",
        f"  {'flywheel':26}{whole.flywheel_work:12.6g} J      given off, with the drive's inertia, from highest to lowest speed",
        f"  {'lost':26}{whole.lost:12.6g} J      in clutch and brake",
    ]


def _motor(run: Run, whole: Duty) -> list[str]:
    if run.problem.driven.drive is None and run.problem.driven.prescribed is None:
        return []
    use = [] if whole.utilisation is None else [f"  {'utilisation':26}{100 * whole.utilisation:12.6g} %      rms by rated torque"]
    return [
        "",
        "Motor (torque at its own shaft)",
        f"  {'rms':26}{whole.motor_rms:12.6g} N m",
        f"  {'peak':26}{whole.motor_peak:12.6g} N m",
        *use,
    ]


def _torque(result: Reactions) -> list[str]:
    lines = ["", "Torque at the crank (flywheel, drive, clutch and brake together)"]
    torque, motion = result.driving_torque, result.motion
    for name, at in (("largest", int(torque.argmax())), ("smallest", int(torque.argmin()))):
        lines.append(f"  {name:26}{torque[at]:12.6g} N m    at {motion.crank_degrees[at]:8.3f} deg, {motion.time[at]:.6f} s")
    return lines


def _strokes(found: Sequence[Duty], turns: int | None) -> list[str]:
    if not found:
        return ["", "Strokes: none, the crank does not get through a period"]
    heads = ["start [s]", "duration [s]", "mean [r/min]", "lowest [r/min]", "drive [J]", "loads [J]"]
    what = "turns of the crank" if turns in (None, 1) else f"each {turns} turns of the crank"
    lines = ["", f"Strokes ({what}, from the start)", f"  {'':6}" + "".join(f"{head:>16}" for head in heads)]
    few = len(found) <= MOST_STROKES
    for k in range(len(found)) if few else [*range(FIRST_STROKES), len(found) - 1]:
        stroke = found[k]
        if not few and k == len(found) - 1:
            lines.append(f"  {'...':>6}")
        values = (stroke.start, stroke.duration, stroke.mean_speed / RPM, stroke.lowest_speed / RPM, stroke.drive_work, stroke.load_work)
        lines.append(f"  {k + 1:6d}" + "".join(f"{value:16.6g}" for value in values))
    return lines
