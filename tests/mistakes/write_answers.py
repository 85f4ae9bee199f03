"""tests/mistakes/answers.md, what is said to every mistake of this folder and to wrong calls, and docs/mistakes.md, a choice of it.

What is said is computed; a test holds both files to it.
"""

import re
from pathlib import Path

from make import DOCS, ROOT, write
from support import mistakes

PAGE = """\
# What is said to everyday mistakes

`python docs/make.py write_answers` writes this file. Each row names a file of this folder, or a call, the line in which it differs
from the right one, and the answer, with `press` for the file's name.

## In pin tables

`press.yaml` is without a mistake:

```yaml
{table}```

{in_tables}

## In URDFs

`press.urdf` is without a mistake:

```xml
{urdf}```

{in_urdfs}

## In calls

```python
{calls}```

These are the answers to calls after these lines:

{in_calls}
"""
GUIDE = """\
# Everyday mistakes

`pp.build` and `pp.load`, and so every command, answer {count} mistakes that people make when they describe a press. An error ends the
call. A warning is a line on stderr in a command, and a `PinpressWarning` in Python. A note is what `pinpress check` adds. Each answer names
the file, the line, what is written there and what to write instead.

You can try them: each mistake is a file of the folder `tests/mistakes`, such as `pinpress check tests/mistakes/no-units.yaml`. These are
some of them, with `press` for the file's name; `tests/mistakes/answers.md` has the answers to all.

{chosen}

Where lengths do not meet, `pinpress build` also draws how far they reach:

![lengths-too-short-to-meet.yaml: pin C is sought 700 mm from B and 375 mm from D; the circles do not meet](pictures/lengths_too_short.svg)

Functions answer wrong calls in the same way, after `press = pp.load("zxn2_3000b")` and `motion = pp.cycle(press, speed=70 * pp.RPM)`:

{calls}

`python docs/make.py write_answers` writes this page.
"""
CHOSEN = (
    "no-units.yaml",
    "m-where-mm-are-meant.yaml",
    "no-side.yaml",
    "lengths-too-short-to-meet.yaml",
    "slide-in-tonnes.yaml",
    "one-length-in-mm.urdf",
    "masses-in-g.urdf",
    "no-driver.urdf",
    "axis-in-the-plane.urdf",
)
CHOSEN_CALLS = (1, 2, 5, 6)  # places in `CALLS`
TAB = "\t"
HEAD = "| file | written | answer |\n| --- | --- | --- |"
HEAD_OF_CALLS = "| call | answer |\n| --- | --- |"

RIGHT_CALLS = """\
from dataclasses import replace

import pinpress as pp

press = pp.load("zxn2_3000b")
motion = pp.cycle(press, speed=70 * pp.RPM)
reactions = pp.inverse_dynamics(press, motion, loads=[pp.loads.Blanking(force=4e6, start=0.008, end=0.003)])
bearings = dict.fromkeys(press.bearings, 3e9)  # N/m
springs = pp.elasticity.Elastic(pp.elasticity.Stiffness(bearings, moments={"slide_guide": 2e8}), damping_ratio=0.03)
in_newtons_per_mm = replace(springs.stiffness, bearings=dict.fromkeys(press.bearings, 3e6))
held, speed = pp.drives.PrescribedSpeed(70 * pp.RPM), 70 * pp.RPM
tol = pp.tolerances
rods = [tol.link_length(press, "D", "E", 50e-6), tol.link_length(press, "E", "F", 50e-6)]
"""
CALLS = (
    'pp.load("zxn2_3000")',
    "pp.cycle(press)",
    "pp.cycle(press, speed=60)",
    'pp.cycle(press, speed="70 rpm")',
    "pp.inverse_dynamics(press, motion, loads=pp.loads.Blanking(force=4e6, start=0.008, end=0.003))",
    "pp.inverse_dynamics(press, motion, loads=[pp.loads.Blanking(force=3000, start=0.008, end=0.003)])",
    "pp.inverse_dynamics(press, motion, loads=[pp.loads.Blanking(force=4e6, start=8, end=3)])",
    "pp.inverse_dynamics(press, motion, loads=[pp.loads.Blanking(force=4e6, start=0.003, end=0.008)])",
    "pp.inverse_dynamics(press, motion, loads=[pp.loads.DeepDrawing(force=4e6, start=0.4)])",
    "pp.inverse_dynamics(press, pp.cycle(press, speed=speed, points=24), loads=[pp.loads.Blanking(force=4e6, start=2e-4, end=1e-4)])",
    'pp.inverse_dynamics(press, motion, loads=[pp.loads.SpringDamper("frame", "slide", stiffness=5e4, free_length=400)])',
    'pp.inverse_dynamics(pp.load("crank_slide"), motion)',
    'reactions.bearing_force["a"]',
    "pp.servo_cycle(press, angle=[0.0, 0.1, 0.2], speed=[7.0, 7.0, 7.0], time=[0.0, 1.0, 2.0])",
    "pp.drives.InductionMotor(rated_power=75e3, rated_speed=1485)",
    "pp.drives.InductionMotor(rated_power=75, rated_speed=1485 * pp.RPM, inertia=1.2)",
    "pp.simulate(press, 0.1, speed=speed, drive=pp.drives.InductionMotor(75e3, 1485 * pp.RPM))",
    "pp.simulate(press, duration=1.0, speed=7.0, drive=pp.drives.PrescribedSpeed(8.0))",
    "pp.steady_state(press, 7.0, drive=pp.drives.ConstantTorque(5e3))",
    "pp.steady_state(press, speed, drive=held, elastic=3e9)",
    "pp.steady_state(press, speed, drive=held, elastic=pp.elasticity.Elastic(pp.elasticity.Stiffness(bearings)))",
    'pp.steady_state(press, speed, drive=held, elastic=replace(springs, stiffness=replace(springs.stiffness, bearings={"G": 3e9})))',
    "pp.steady_state(press, speed, drive=held, elastic=replace(springs, stiffness=in_newtons_per_mm))",
    "replace(springs, damping_ratio=2)",
    "replace(springs, damping_ratio=3)",
    "replace(springs, stiffness=replace(springs.stiffness, frame=4e9))",
    "pp.elasticity.Clearance(radial=0.05)",
    'pp.elasticity.Clearance(radial=5e-5, law="hertz", restitution=0.7)',
    'pp.steady_state(press, speed, drive=held, elastic=replace(springs, clearances={"F": pp.elasticity.Clearance(5e-5)}))',
    'tol.bottom_dead_centre(press, [tol.link_length(press, "E", "F", 0.05)], samples=100)',
    'tol.link_length(press, "D", "F", 50e-6)',
    'tol.Dimension("rod", {("F", "rod"): (0, 0, 0)}, 50e-6)',
    'tol.bottom_dead_centre(press, [tol.pin_position(press, "slide_guide", "z", 1e-4)], samples=100)',
    "tol.bottom_dead_centre(press, rods, samples=1000).height.band(0.9973)",
    "tol.bottom_dead_centre(press, rods, forces={6.0: 3e6})",
    'tol.allocate(press, rods, None, {"height": 2e-6})',
    'tol.play(press, motion, {"F": 0.05})',
    'tol.play(press, motion, {"G": 5e-5})',
    'tol.play(press, motion, {"F": tol.GuideClearance(5e-5, length=0.8)})',
    'tol.play(press, motion, {"slide_guide": tol.GuideClearance(5e-5, length=0.0005)})',
    'tol.play(press, motion, {"F": 5e-5}, known_to=5)',
    'tol.heat(press, tol.Temperatures({"rod": 313.15}))',
    'tol.heat(press, tol.Temperatures({"EF": 10.0}))',
    'tol.heat(press, tol.Temperatures({"frame": 10.0}))',
    'tol.heat(press, tol.Temperatures({"rod": 10.0}, expansion=12))',
    "tol.budget(press, speeds=[speed])",
    'tol.budget(press, speeds=[speed], stiffness=pp.elasticity.Stiffness({"F": 3e3}))',
    'tol.parallelism(press, {"F": rods})',
)


def answers() -> str:
    """The text of tests/mistakes/answers.md."""
    tables, urdfs = mistakes.files(mistakes.TABLE), mistakes.files(mistakes.URDF)
    return PAGE.format(
        count=len(tables) + len(urdfs),
        table=mistakes.TABLE.read_text(encoding="utf-8"),
        urdf=mistakes.URDF.read_text(encoding="utf-8"),
        in_tables="\n".join([HEAD, *map(_row, tables)]),
        in_urdfs="\n".join([HEAD, *map(_row, urdfs)]),
        calls=RIGHT_CALLS,
        in_calls="\n".join([HEAD_OF_CALLS, *_calls()]),
    )


def guide() -> str:
    """The text of docs/mistakes.md."""
    files = [file for right in (mistakes.TABLE, mistakes.URDF) for file in mistakes.files(right)]
    named = {file.name: file for file in files}
    calls = _calls()
    return GUIDE.format(
        count=len(files),
        chosen="\n".join([HEAD, *(_row(named[name]) for name in CHOSEN)]),
        calls="\n".join([HEAD_OF_CALLS, *(calls[place] for place in CHOSEN_CALLS)]),
    )


def _row(file: Path) -> str:
    """A row of the table: the file, the first line that its mistake changes, and what is said."""
    _, put_in, taken_out = mistakes.changes(file)
    if put_in:
        written = _code(put_in[0]) + (" ..." if len(put_in) > 1 else "")
    else:
        written = f"without {_code(taken_out[0])}" if len(file.read_text(encoding="utf-8").splitlines()) > 1 else "nothing"
    said = (line.replace(str(file), f"press{file.suffix}") for line in mistakes.said(file))
    return f"| {file.name} | {written} | {'<br>'.join(map(_plain, said))} |"


def _calls() -> list[str]:
    """A row for each of `CALLS`: the call, and what is said."""
    names: dict[str, object] = {}
    exec(RIGHT_CALLS, names)
    return [f"| `{call}` | {'<br>'.join(map(_plain, mistakes.heard(lambda call=call: eval(call, names))))} |" for call in CALLS]


def _code(text: str) -> str:
    return f"`{text.strip(' ').replace(TAB, '⇥')[:90].replace('|', '/')}`"


def _plain(text: str) -> str:
    """A message as Markdown. Braces at the end of a cell would be attributes of it."""
    return re.sub(r"([*_|\[\]])", r"\\\1", re.sub("[<>{}]", lambda found: f"&#{ord(found[0])};", " ".join(text.split())))


def main(quick: bool = False) -> None:
    """Write both."""
    write(ROOT / "tests" / "mistakes" / "answers.md", answers())
    write(DOCS / "mistakes.md", guide())
