"""`pinpress servo`: the best motion of a servo press in comparison with usual motions, and the smallest motor for it."""

from __future__ import annotations

import argparse

from ..common.errors import PinpressError
from ..common.files import make_folder
from ..dynamics.inputs import described, of_loads, of_press, stated
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..jobs.job import servo_results
from .options import add_job_options, open_job, print_inputs, say_written, write_cam_tables, write_report

EXAMPLE = """\
e.g. press.yaml, with its table or file: zxn2_3000b:
  loads: {draw: {kind: drawing, force: 1500 kN, start: 60 mm}}
  servo:
    strokes_per_minute: 25
    drive: {inertia: 1.5 kg m2, ratio: 60, gear_inertia: 50 kg m2, peak_torque: 2100 N m, rated_torque: 800 N m, top_speed: 2000 r/min}
    path: {kind: turn}                         # or stop, pendulum, pulse
    limits: [{kind: slide-speed, speed: 200 mm/s, heights: 60 0 mm}]
In place of drive: motors: servo_motors.csv, ratios: 40 50 60 80, gear_inertia: 50 kg m2. The catalogue is a CSV file with the columns
  motor, inertia [kg m2], copper loss [W/(N m)2], speed [r/min], rated torque [N m], peak torque [N m]
and a row for each point of a motor's curves. minimise: heat, time, energy or peak.
pinpress servo press.yaml --out out
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `servo` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "servo",
        help="the motion of a servo press that needs the smallest motor, with proof, and this motor",
        description="Find the motion of the crank with the least heat in the motor, time or energy within limits, and prove that it is\n"
        "optimal. Prints it in comparison with usual motions, with the limits that act. With --out also writes servo.csv (the motion),\n"
        "angle.csv and height.csv (for a controller), comparison.csv, with cam_table its files, and report.html, the press in this motion.",
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_job_options(parser, "the files")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the best motion in comparison with others, and write the files.

    Raises:
        PinpressError: the job is wrong, no motion keeps the limits, no motor is sufficient, or writing fails.
    """
    job = open_job(options)
    given, loads = job.need("servo"), list(job.loads.values())
    job.press.refuse_several_drivers("the best motion needs one crank; give the motion of several drivers as a table, motion: {file: ...}")
    if "motors" in given and job.choose_motor().best is None:
        print(job.choose_motor())
        raise PinpressError("no motor is sufficient: give larger motors, other ratios, more time or a pause")
    parts = [*servo_results(job)]
    best, compared = parts[-3:-1]
    parts += job.cam_tables() if "cam_table" in job.sections else []
    print("\n\n".join(map(str, parts)))
    time = [("time", f"{given['time']:.6g} s a cycle")] if "time" in given else []
    asked = [(name, described(given[name])) for name in ("drive", "path") if name in given]
    asked += [("motors", str(given["motors"]))] if "motors" in given else []
    limits = [("limit", described(each)) for each in given.get("limits", [])]
    print_inputs(job, [*of_press(job.press), *time, *asked, *limits, *of_loads(loads), stated()])
    if options.out is not None:
        from ..servo.controller import controller_table  # seldom needed

        make_folder(options.out)
        motion = job.best_motion().motion
        best.to_csv(options.out / "servo.csv")
        for of in ("angle", "height"):
            controller_table(motion, of, step=given.get("step", 1e-3)).to_csv(options.out / f"{of}.csv")
        compared.to_csv(options.out / "comparison.csv")
        reactions = inverse_dynamics(job.press, motion.motion, loads)  # with all bearings: the optimum has only those with a limit
        page = write_report(job, options.out, results=parts, reactions=reactions)
        say_written(options.out, ["servo.csv", "angle.csv", "height.csv", "comparison.csv", *page, *write_cam_tables(job, options.out)])
    return 0
