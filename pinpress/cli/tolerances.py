"""`pinpress tolerances`: find the scatter of bottom dead centre, the dimensions that cause it, and the cheapest tolerances."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from ..common.errors import PinpressError
from ..common.files import make_folder
from ..common.quantities import RPM
from ..dynamics.inputs import Inputs, of_press, stated
from ..kinematics.motion_table import read_motion
from .words.motions import MOTION, add_period_option, refuse_without_motion
from .words.outputs import add_out_option, print_inputs, write_pictures
from .words.press import add_press_options, load_press
from .words.units import quantity, read_quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..kinematics.motion import Motion
    from ..linkage.linkage import Linkage
    from ..tolerances.accuracy_budget import AccuracyBudget
    from ..tolerances.allocation import AllocatedTolerances
    from ..tolerances.dead_centre_scatter import DeadCentreScatter
    from ..tolerances.dimension_table import DimensionTable

Key = TypeVar("Key", str, float)
SAMPLES = 100_000
QUANTITIES = {"height": "bottom dead centre", "top": "top dead centre", "stroke": "the stroke"}
EPILOG = """\
--dimensions is a table, a CSV file with these columns; the first two are needed:
  dimension           length E F: between two pins of a link; angle C D E: between two arms of a link;
                      position A x: of a pin or guide in the frame; position E x rocker: in another link
  tolerance           +/- of the dimension
  unit                mm (default), um, m; for angles deg, rad
  shape, sd           normal (default), uniform or truncated; standard deviation (default: a third of the tolerance)
  name                in results
  cost                at this tolerance; half the tolerance costs twice as much (default: 1)
  smallest, largest   tolerances that can be made (default: a tenth and ten times)
or a YAML file with a list of such entries, - {dimension: length E F, tolerance: 0.05}.

--budget 10,50,70 adds the shift of bottom dead centre at these speeds from the first speed, at which the die is set: --clearance F=50um
for each bearing, --stiffness E=3e9 for each elastic bearing, --warm rod=10 for each link that is warmer (in kelvins), --process 500kN.

Numbers are in SI units, lengths in m, or have a unit: 50um.
e.g. pinpress tolerances zxn2_3000b --dimensions docs/zxn2_dimensions.csv --within 50um --force 6mm=3000kN --target height=50um --out out
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `tolerances` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "tolerances",
        help="scatter of bottom dead centre and stroke, the dimensions that cause it, and the cheapest tolerances",
        description="Compute a sample of presses with dimensions that scatter, and print the scatter of their dead centres: the band of\n"
        "99.73 % of the presses, the worst corners, the dimensions by their shares. With --target find the cheapest tolerances,\n"
        "with proof. With --budget print the shift of bottom dead centre by clearances, springs and heat over the speed. With\n"
        "--out also write dimensions.csv, with --target allocated.csv, with --budget budget.csv, and if Matplotlib is\n"
        "installed tolerances.png and budget.png.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("--dimensions", type=Path, required=True, metavar="TABLE", help="dimensions with their tolerances, CSV or YAML, see below")
    option("--within", type=quantity("m"), metavar="M", help="largest deviation of bottom dead centre; prints how many presses keep it")
    option(
        "--force",
        action="append",
        default=[],
        metavar="H=N",
        help="force at a height above bottom dead centre; prints the crank's torque there (the crank turns positively, or negatively if"
        " each --speed is negative)",
    )
    option(
        "--speed",
        action="append",
        default=[],
        metavar="H=RPM",
        help="crank speed at a height on the way down; prints the slide's speed there",
    )
    option(
        "--target",
        action="append",
        default=[],
        metavar="QUANTITY=M",
        help="largest 3 standard deviations of height (bottom dead centre), top or stroke; finds the cheapest tolerances; may be"
        " given once for each",
    )
    help = f"a motion (e.g. of several drivers); its lowest and highest state take the place of the dead centres: {MOTION}"
    option("--motion", metavar="FILE", help=help)
    add_period_option(parser)
    _add_budget_options(parser)
    option("--samples", type=int, default=SAMPLES, metavar="N", help="number of presses (default: %(default)s)")
    option("--seed", type=int, default=0, metavar="N", help="seed of the random numbers (default: %(default)s)")
    add_press_options(parser)
    add_out_option(parser, "the files")
    parser.set_defaults(run=run)


def _add_budget_options(parser: argparse.ArgumentParser) -> None:
    """The options of the accuracy budget."""
    option = parser.add_argument
    option("--budget", metavar="RPM,RPM", help="crank speeds of the accuracy budget; the press is set at the first one, idle and cold")
    option(
        "--clearance",
        action="append",
        default=[],
        metavar="BEARING=M",
        help="radial clearance of a bearing, or clearance of a guide on each side",
    )
    option("--stiffness", action="append", default=[], metavar="BEARING=N/m", help="stiffness of a bearing")
    option(
        "--warm", action="append", default=[], metavar="LINK=K", help="temperature of a link or the frame above its temperature at setting"
    )
    option("--expansion", type=quantity("1/K"), metavar="1/K", help="linear expansion of all links (default: steel, 12e-6)")
    option("--table", type=quantity("m"), metavar="M", help="place of the table in world coordinates, for a warm frame")
    option("--face", type=quantity("m"), metavar="M", help="place of the slide's face from its origin, for a warm slide")
    option("--process", type=quantity("N"), default=0.0, metavar="N", help="force on the slide at bottom dead centre in production")


def run(options: argparse.Namespace) -> int:
    """Print the effect of tolerances on the press, and write the files.

    Raises:
        PinpressError: an option or the table is wrong, presses cannot be assembled, a target cannot be met, or writing fails.
    """
    from ..tolerances.allocation import allocate  # imported here to save start-up time of other commands
    from ..tolerances.dead_centre_scatter import bottom_dead_centre
    from ..tolerances.dimension_table import read_dimensions

    forces, speeds = _by_height("--force", options.force, "N", 1.0), _by_height("--speed", options.speed, "r/min", RPM)
    targets = _named("--target", options.target, _quantity, "m", 1.0, "height=50um")
    press = load_press(options)
    table = read_dimensions(press, options.dimensions)
    motion = _motion(press, options)
    sampled = {"samples": options.samples, "seed": options.seed}
    found = bottom_dead_centre(press, table.parts, forces=forces, speeds=speeds, motion=motion, **sampled)
    budgeted = _budgeted(press, found, options)
    allocated = allocate(press, table.parts, table.costs, targets, table.bounds, motion=motion) if targets else None
    within = None if options.within is None else found.within(options.within)
    if options.out is not None:
        make_folder(options.out)
    print(found)
    if within is not None:
        print(f"  within {1e6 * options.within:g} um at bottom dead centre: {100 * within:.4g} % of the presses")
    if allocated is not None:
        print(f"\n{allocated}")
    if budgeted is not None:
        print(f"\n{budgeted}")
    print_inputs([*of_press(press), *_in_words(options, table), stated()])
    if options.out is not None:
        _write(found, allocated, budgeted, options)
    return 0


def _motion(press: Linkage, options: argparse.Namespace) -> Motion | None:
    """Read the motion of the options; None if the press turns through its dead centres.

    Raises:
        PinpressError: a press with several drivers has no motion, an option does not go with a motion, or as for `read_motion`.
    """
    if options.motion is None:
        if options.period is not None:
            raise PinpressError("--period is the period of --motion: also give --motion, or leave --period out")
        refuse_without_motion(press, "without a motion they have no dead centre")
        return None
    for option in ("force", "speed", "budget"):
        if getattr(options, option):
            raise PinpressError(f"--{option} is for a crank that turns through its dead centres: leave out --{option} or --motion")
    return read_motion(press, options.motion, period=options.period)


def _budgeted(press: Linkage, machining: DeadCentreScatter, options: argparse.Namespace) -> AccuracyBudget | None:
    """Compute the accuracy budget of the options; None without --budget.

    Raises:
        PinpressError: an option of the budget is given without --budget, or is wrong.
    """
    words = {name: getattr(options, name) for name in ("clearance", "stiffness", "warm")}
    if options.budget is None:
        if given := [f"--{name}" for name in words if words[name]]:
            raise PinpressError(f"{', '.join(given)} can only be used with the accuracy budget: also give its speeds, --budget 10,70")
        return None
    from ..elasticity.springs import Stiffness  # both to save start-up time
    from ..tolerances.accuracy_budget import budget
    from ..tolerances.temperatures import STEEL, Temperatures

    try:
        speeds = [RPM * read_quantity(text, "r/min") for text in options.budget.split(",")]
    except ValueError as error:
        raise PinpressError(
            f"--budget {options.budget} is {error}: give speeds with commas between them, as in --budget 10,50,70"
        ) from None
    clearance = _named("--clearance", words["clearance"], str, "m", 1.0, "F=50um")
    stiffness = _named("--stiffness", words["stiffness"], str, "N/m", 1.0, "E=3e9")
    rises = _named("--warm", words["warm"], str, "K", 1.0, "rod=10")
    expansion = STEEL if options.expansion is None else options.expansion
    return budget(
        press,
        speeds=speeds,
        clearance=clearance or None,
        stiffness=Stiffness(stiffness) if stiffness else None,
        temperatures=Temperatures(rises, expansion, options.table, options.face) if rises else None,
        process=options.process,
        machining=machining,
    )


def _in_words(options: argparse.Namespace, table: DimensionTable) -> Inputs:
    """The dimensions, the sample and the options, for `print_inputs`."""
    asked = ("force", "speed", "target", "clearance", "stiffness", "warm")
    return [
        ("dimensions", f"{len(table.parts)} of {options.dimensions}"),
        ("sample", f"{options.samples} presses, seed {options.seed}"),
        *([("motion", options.motion)] if options.motion is not None else []),
        *((option, ", ".join(given)) for option in asked if (given := getattr(options, option))),
        *([("budget at", f"{options.budget} r/min, process {options.process:g} N")] if options.budget else []),
    ]


def _by_height(option: str, words: Sequence[str], unit: str, factor: float) -> dict[float, float]:
    """Read forces or speeds by heights from texts such as ``6mm=3000kN``."""
    example = {"N": "6mm=3000kN", "r/min": "50mm=70rpm"}[unit]
    return _named(option, words, lambda text: read_quantity(text, "m"), unit, factor, example)


def _quantity(text: str) -> str:
    if text not in QUANTITIES:
        raise ValueError
    return text


def _named(option: str, words: Sequence[str], key: Callable[[str], Key], unit: str, factor: float, example: str) -> dict[Key, float]:
    """Read numbers by the key before the equals sign.

    Raises:
        PinpressError: A text is not KEY=NUMBER, or a key is given twice.
    """
    found: dict[Key, float] = {}
    for text in words:
        before, _, after = text.partition("=")
        try:
            name, value = key(before), factor * read_quantity(after, unit)
        except ValueError:
            raise PinpressError(f"{option} {text}: write it as in {option} {example}; {_known(option)}") from None
        if name in found:
            raise PinpressError(f"{option} {text}: {before} is given twice")
        found[name] = value
    return found


def _known(option: str) -> str:
    if option == "--target":
        return "there are " + ", ".join(f"{name} ({words})" for name, words in QUANTITIES.items())
    words = {"--clearance": "a bearing, and its clearance", "--stiffness": "a bearing, and its stiffness", "--warm": "a link, and kelvins"}
    return words.get(option, "a height above bottom dead centre, and what acts there")


def _write(
    found: DeadCentreScatter, allocated: AllocatedTolerances | None, budgeted: AccuracyBudget | None, options: argparse.Namespace
) -> None:
    """Write the files, and print their names."""
    folder, names = options.out, ["dimensions.csv"]
    found.to_csv(folder / "dimensions.csv")
    if allocated is not None:
        allocated.to_csv(folder / "allocated.csv")
        names.append("allocated.csv")
    if budgeted is not None:
        budgeted.to_csv(folder / "budget.csv")
        names.append("budget.csv")

    def draw() -> dict[str, Figure]:
        from ..plots import charts  # slow to import

        height = found.height if options.within is None else found.height.with_limit(options.within)
        pictures = {"tolerances.png": charts.draw(height, "shares", "presses")}
        return pictures if budgeted is None else pictures | {"budget.png": charts.draw(budgeted, "parts")}

    write_pictures(folder, names, draw)
