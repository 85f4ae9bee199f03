"""`pinpress balance`: find the best counterweights of a press."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from ..balancing.counterweights import OperatingCondition, with_die
from ..balancing.optimum import balance
from ..balancing.problem import AXES, QUANTITIES, AddedMass, Peak, Range, Rms, Target
from ..balancing.regions import CounterweightRegion, Vector
from ..balancing.result import BalancedPress
from ..common.errors import PinpressError, suggestion
from ..common.files import make_folder
from ..dynamics.inputs import Inputs, motion_in_words, of_loads, of_press, stated
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..linkage.linkage import Linkage
from ..linkage.writing import write_urdf
from .words import part_specs
from .words.forces import add_force_options, loads
from .words.motions import add_motion_options, motion_of
from .words.outputs import add_out_option, print_inputs, say_written
from .words.part_values import numbers
from .words.press import add_press_options, add_refused_option, drawn, load_as_drawn, refuse_without_table, table_parameters, with_zero
from .words.units import quantity, read_quantity

KINDS = {"range": Range, "rms": Rms, "peak": Peak}
MASS = "added_mass"
REGION = "LINK:at=X/Y/Z, LINK:radius=R[,centre=X/Y/Z], LINK:corner=X/Y/Z,corner=X/Y/Z,... or LINK:replaces, with [,mass=LEAST/MOST]"
CRITERION = f"{'|'.join(KINDS)}:QUANTITY[:BEARING][:AXIS] or {MASS}"
EPILOG = f"""\
regions: {REGION}
  a point; a circle in the plane of motion; a segment or polygon of corners; or the link itself, with more or less mass in the same shape.
  Lengths are in m, or have units (300mm), in the link's frame. All take ,mass=LEAST/MOST in kg (default: 0/inf, without limit) and
  ,gyration=R, the radius of gyration of the counterweight's material. With ,replaces after a place the counterweight replaces the link's
  mass. With several dies, settings or speeds: ,reset=mass for a mass that is changed for each of them, ,reset=position for a mass that
  moves in its shape.
criteria: {CRITERION}
  quantities: {", ".join(QUANTITIES)}; the last two need a bearing; axes: {", ".join(AXES)}.
  Range and rms do not include the constant part, peaks include it.

{part_specs.explained("load", "spring")}
e.g. pinpress balance zxn2_3000b --speed 70 --region crank:radius=0.3 --region rod:radius=0.3,mass=0/200 --minimise range:shaking_force:z
     --limit range:shaking_force:x=1000 --limit added_mass=661 --out out --report
"""


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `balance` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "balance",
        help="find the counterweights that minimise shaking forces, torque or bearing forces",
        description="Find the best counterweights of a press that turns at constant speed, or with --motion by a table, and prove that\n"
        "they are optimal. Prints them, the limits that are active, and all forces before and after. With --out it also\n"
        "writes balanced.urdf, balance.csv (forces before and after, SI units) and counterweights.csv; with --report also report.html,\n"
        "the balanced press with its curves (dashed: before balancing).",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_motion_options(parser, several=True)
    option(
        "--die",
        type=quantity("kg"),
        action="append",
        default=[],
        metavar="KG",
        help="mass of an upper die in the slide's centre of mass (default: no die); may be given several times, like --speed",
    )
    option(
        "--setting",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="setting of the press by a parameter of its pin table, such as r=10 for another stroke, several with commas;"
        " may be given several times, like --die",
    )
    add_balance_options(parser, required=True)
    add_force_options(parser, friction=False, stiffness=False)
    add_refused_option(
        parser, "--friction", "balancing needs forces that are linear in the masses; friction makes them nonlinear: leave it out"
    )
    for name in ("--motor", "--flywheel"):
        add_refused_option(
            parser, name, "balancing is at constant speed, where motor and flywheel have no effect on the links: leave it out"
        )
    option("--points", type=int, metavar="N", help="number of crank angles of the period (default: 360 a turn)")
    add_press_options(parser)
    add_out_option(parser, "the files")
    option("--report", action="store_true", help="also write report.html, in the first setting with the first die at the first speed")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the counterweights with their effects, and write the files.

    Raises:
        PinpressError: An option names no region or criterion, --report is given without --out, or computing or writing fails.
    """
    if options.out is None and options.report:
        raise PinpressError("--report needs a folder to write into: also give --out DIR")
    acting = loads(options)
    as_drawn = load_as_drawn(options)
    press = with_zero(as_drawn, options.zero)
    speeds = options.speed or [None]
    conditions = [
        OperatingCondition(motion_of(each, options, speed), acting, each if setting or die else None, setting + die)
        for set_up, setting in _set_up(press, options)
        for each, die in _with_dies(set_up, options.die, ", " if setting else "")
        for speed in speeds
    ]
    if len(speeds) > 1:  # one die or setting stands in several conditions
        conditions = [replace(each, name=each.name and f"{each.name} ({number})") for number, each in enumerate(conditions)]
    balanced = balanced_by(press, conditions, options)
    if options.out is not None:
        make_folder(options.out)
    print(balanced)
    print_inputs(_inputs(balanced, options))
    if options.out is not None:
        _write(balanced, as_drawn, options.out, options.report)
    return 0


def _set_up(press: Linkage, options: argparse.Namespace) -> list[tuple[Linkage, str]]:
    """The press in each setting, and the setting as text; without settings the press itself."""
    found = []
    for words in options.setting:
        refuse_without_table(options.file, f"--setting {words}")
        own = table_parameters(words.split(","))
        others = [spec for spec in options.parameters if spec.partition("=")[0] not in own]
        drawn_so = drawn(options.file, [*others, *words.split(",")], "--setting ").press(slide=options.slide)
        found.append((with_zero(drawn_so, options.zero), words.replace(",", ", ")))
    return found or [(press, "")]


def _with_dies(press: Linkage, dies: Sequence[float], behind: str) -> list[tuple[Linkage, str]]:
    """The press with each upper die [kg], and the die as text after ``behind``; without dies the press itself."""
    if not dies:
        return [(press, "")]
    if press.slide is None:
        raise PinpressError(f"--die: {press.name} has no slide to fix a die to: leave --die out")
    if not all(mass >= 0 for mass in dies):
        raise PinpressError(f"--die {min(dies):g}: the mass of a die cannot be negative; write e.g. --die 300")
    return [(with_die(press, mass, press.slide), f"{behind}die of {mass:g} kg") for mass in dies]


def add_balance_options(parser: argparse.ArgumentParser, *, required: bool) -> None:
    """Options of `balanced_by`; ``required``: whether a press is always balanced."""
    option = parser.add_argument
    option(
        "--region",
        action="append",
        required=required,
        default=[],
        metavar="LINK:KEYS",
        help="region for a counterweight, see below; may be given several times",
    )
    option(
        "--minimise",
        action="append",
        required=required,
        default=[],
        metavar="CRITERION[=WEIGHT]",
        help="criterion to minimise, see below; may be given several times: each counts relative to its value before, times its weight (1)",
    )
    option(
        "--limit",
        action="append",
        default=[],
        metavar="CRITERION=MOST",
        help="upper limit of a criterion, in its SI unit or with a unit, e.g. 12kN; may be given several times",
    )


def balanced_by(press: Linkage, conditions: Sequence[OperatingCondition], options: argparse.Namespace) -> BalancedPress:
    """Balance a press by `add_balance_options`; raises `PinpressError` if an option names no region or criterion."""
    regions = [_region(words) for words in options.region]
    minimise, limits = _objective(options.minimise), _by_target("--limit", options.limit, "")
    return balance(press, conditions, regions=regions, minimise=minimise, limits=limits)


def _inputs(balanced: BalancedPress, options: argparse.Namespace) -> Inputs:
    """Inputs of the balance as text; regions and criteria as given."""
    return [
        *of_press(balanced.original),
        *(("motion", motion_in_words(condition.motion)) for condition in balanced.conditions),
        *([] if options.motion is None else [("motion from", options.motion)]),
        *(("setting", words) for words in options.setting),
        *(("die", f"{mass:g} kg") for mass in options.die),
        *of_loads(balanced.conditions[0].loads),
        *((name, words) for name in ("region", "minimise", "limit") for words in getattr(options, name)),
        stated(),
    ]


def _write(balanced: BalancedPress, as_drawn: Linkage, folder: Path, with_report: bool) -> None:
    """Write the files and say so; ``as_drawn``: the press before, as its file draws it, which the balanced one's URDF does too."""
    write_urdf(as_drawn.with_inertias(list(balanced.press.model.inertias), balanced.press.name), folder / "balanced.urdf")
    balanced.to_csv(folder / "balance.csv")
    anew = any(weights != balanced.counterweights for weights in balanced.settings)
    files = {f"counterweights_{k}.csv" if anew else "counterweights.csv": weights for k, weights in enumerate(balanced.settings)}
    for file, weights in files.items():
        weights.to_csv(folder / file)
    written = ["balanced.urdf", "balance.csv", *files]
    if with_report:
        from ..visual.reports.report import report  # Plotly is optional, and slow to import

        # with all bearings, of which balancing computes only those that are asked for
        first, press = balanced.conditions[0], balanced.presses[0]
        before = inverse_dynamics(first.set_up(balanced.original), balanced.reactions_before[0].motion, first.loads)
        after = inverse_dynamics(press, balanced.reactions_after[0].motion, first.loads)
        report(press, after.motion, folder / "report.html", reactions=after, before=before, results=[balanced])
        written.append("report.html")
    say_written(folder, written)


def _region(words: str) -> CounterweightRegion:
    """Read a region from a text such as ``rod:radius=0.3,mass=0/200``."""

    def wrong(problem: str) -> PinpressError:
        return PinpressError(f"--region {words}: {problem}; it takes {REGION}; write e.g. --region crank:radius=0.3,mass=0/200")

    link, _, keys = words.rpartition(":")  # a link's name may have a colon in it
    if not link:
        raise wrong("it names no link and place")
    given: dict[str, list[Any]] = {}
    for word in keys.split(","):
        name, _, text = word.partition("=")
        if name not in KEYS:
            raise wrong(f"no key {name!r}{suggestion(name, KEYS)}")
        if name in given and name != "corner":
            raise wrong(f"{name} is given twice")
        try:
            given.setdefault(name, []).append(KEYS[name](text))
        except ValueError as error:
            raise wrong(f"{name} is {text!r}, {error}") from None
    corners = tuple(given.pop("corner", ()))
    fields = {name: value for name, (value,) in given.items()}
    try:
        return CounterweightRegion(link, corners=corners, **fields)
    except PinpressError as error:
        raise wrong(str(error)) from None


def _objective(specs: Sequence[str]) -> Target | Mapping[Target, float]:
    """The objective from ``range:shaking_force:z``, or with weights ``range:shaking_force:z=1`` and ``rms:driving_torque=0.5``."""
    if len(specs) == 1 and "=" not in specs[0]:
        return _target("--minimise", specs[0], specs[0])
    return _by_target("--minimise", specs, "1")


def _by_target(option: str, specs: Sequence[str], default: str) -> Mapping[Target, float]:
    """Criteria with their numbers; ``default``: weight of a criterion without one; empty: they are limits, and each needs one."""
    found: dict[Target, float] = {}
    for spec in specs:
        words, equals, text = spec.rpartition("=")
        target = _target(option, spec, words if equals else spec)
        if target in found:
            raise _wrong(option, spec, f"the {target.words} is given twice")
        if not equals and not default:
            raise _wrong(option, spec, "it has no number")
        try:
            found[target] = read_quantity(text, "-" if default else target.unit) if equals else float(default)
        except ValueError as error:
            raise _wrong(option, spec, f"{text!r} is {error}") from None
    return found


def _target(option: str, spec: str, words: str) -> Target:
    if words == MASS:
        return AddedMass()
    kind, _, rest = words.partition(":")
    quantity, _, rest = rest.partition(":")
    for name, known, what in ((kind, [*KINDS, MASS], "criterion"), (quantity, list(QUANTITIES), "quantity")):
        if name not in known:
            raise _wrong(option, spec, f"no {what} {name!r}{suggestion(name, known)}; there are: {', '.join(known)}")
    bearing, axis = None, rest or None
    if quantity.startswith("bearing"):
        first, _, last = rest.rpartition(":")  # a bearing's name may have a colon in it
        bearing, axis = (first, last) if first and last in AXES else (rest, None)
        if not bearing:
            raise _wrong(option, spec, "it names no bearing")
    if axis is not None and axis not in AXES:
        raise _wrong(option, spec, f"no axis {axis!r}; there are: {', '.join(AXES)}")
    try:
        return KINDS[kind](quantity, axis, bearing)
    except PinpressError as error:
        raise _wrong(option, spec, str(error)) from None


def _wrong(option: str, spec: str, problem: str) -> PinpressError:
    number = {"--minimise": "[=WEIGHT]", "--limit": "=MOST"}[option]
    example = {"--minimise": "range:shaking_force:z", "--limit": "peak:bearing_force:A=1e5"}[option]
    return PinpressError(f"{option} {spec}: {problem}; it takes {CRITERION}, with {number}; write e.g. {option} {example}")


def _point(text: str) -> Vector:
    try:
        x, y, z = (read_quantity(part, "m") for part in text.split("/"))
    except ValueError:
        raise ValueError("not x, y, z as 0.1/0/-0.2") from None
    return x, y, z


def _least_and_most(text: str) -> tuple[float, float]:
    try:
        least, most = numbers(text, "kg")
    except ValueError:
        raise ValueError("not the least and the most, as 0/200 or 5/inf") from None
    return least, most


def _alone(text: str) -> bool:
    if text:
        raise ValueError("but takes no value")
    return True


KEYS: Mapping[str, Callable[[str], Any]] = {
    "at": _point,
    "radius": partial(read_quantity, unit="m"),
    "centre": _point,
    "corner": _point,
    "mass": _least_and_most,
    "gyration": partial(read_quantity, unit="m"),
    "replaces": _alone,
    "reset": str,
}
