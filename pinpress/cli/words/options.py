"""Common parts of the commands: options of several commands, their explanations, and writing of pages."""

from __future__ import annotations

import argparse
import importlib.util
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from ...common import tables
from ...common.errors import PinpressError, PinTableError, UnknownNameError
from ...common.results import Tabular
from ...drives.transmission import Flywheel
from ...dynamics.inputs import Inputs
from ...dynamics.inverse_dynamics import Reactions
from ...kinematics.slide_path import dead_centres
from ...linkage.linkage import Linkage
from ...linkage.loading import load, presses
from ...loads.link import Friction, Load
from ...loads.mounts import Frame, Mount
from ...pin_table.templates import TEMPLATES
from ...simulation.elastic.description import Elastic, Stiffness
from . import part_specs
from .part_specs import ALL, COLUMNS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...foundation.mounted_press import MountedPress
    from ...kinematics.motion import Motion
    from ...pin_table.building import DrawnPress

FRAME_FILES = (".yaml", ".yml", ".json")
SIGNS = """\
angles are in degrees of the driver joint, 0 as the file draws it, or with --zero at a dead centre; forces are the action of parent on child
(of a loop, of link1 on link2) in world axes, z up; the shaking force is the action of the machine on its foundation.
"""
ZEROS = {"drawn": "the drawn pose", "tdc": "top dead centre", "bdc": "bottom dead centre"}
SPEED = "crank speed, in r/min, negative: backwards; highest speed of a driver that slides, in mm/s"
FILE = f"pin table (.yaml), URDF, SDF or MJCF file, or the name of a shipped press: {', '.join(presses())}"


def add_press_options(parser: argparse.ArgumentParser) -> None:
    """Options of `load_press`: those by which a file is read, and where crank angles are 0."""
    add_reading_options(parser)
    parser.add_argument(
        "--zero",
        type=str.lower,
        choices=ZEROS,
        default="drawn",
        help="where crank angles are 0, those given, printed and written: as drawn, or at top or bottom dead centre; they rise where the"
        " driver turns positively (default: %(default)s)",
    )


def add_reading_options(parser: argparse.ArgumentParser) -> None:
    """Options by which a press is read: file, drivers, slide, whether loops may be drawn far open, other values of a table's parameters."""
    option = parser.add_argument
    option("file", metavar="FILE", help=FILE)
    driver = "driven joint, where the URDF has no <transmission> or another is meant; may be given several times"
    option("--driver", metavar="JOINT", action="append", help=driver)
    add_slide_option(parser)
    option("--allow-open", action="store_true", help="close loops that are drawn open by more than a tenth of the linkage")
    parameter = "another value of a parameter of the pin table, such as r=150; may be given several times"
    option("--set", dest="parameters", metavar="NAME=VALUE", action="append", default=[], help=parameter)


def add_slide_option(parser: argparse.ArgumentParser) -> None:
    """Option --slide, the link whose motion and process force are meant."""
    parser.add_argument("--slide", metavar="LINK", help="slide, where it is not the link called slide")


def table_parameters(specs: Sequence[str]) -> dict[str, str]:
    """Values by the names of a pin table's parameters, from words such as ``r=150``.

    Raises:
        PinpressError: Words that are no value of a parameter, or a parameter given twice.
    """
    found: dict[str, str] = {}
    for words in specs:
        name, equals, value = words.partition("=")
        if not (name and equals and value):
            raise PinpressError(f"{words!r} is no value of a parameter: write NAME=VALUE, such as r=150")
        if name in found:
            raise PinpressError(f"{words!r}: {name} is given twice")
        found[name] = value
    return found


def names_table(options: argparse.Namespace) -> bool:
    """Whether the file is a pin table, or a shipped press with other values of its table's parameters; raises PinpressError where an option
    is given that does not go with what it is."""
    if not _is_table(options.file):
        if not options.parameters:
            return False
        refuse_without_table(options.file, f"--set {options.parameters[0]}")
    if options.driver is not None or options.allow_open:
        raise PinpressError(f"{options.file} is a pin table, which says what drives: leave out --driver and --allow-open")
    return True


def refuse_without_table(file: str, words: str) -> None:
    """Raise PinpressError where parameters are given in words, and the file is neither a pin table nor a shipped press."""
    if not _is_table(file) and file not in presses():
        raise PinpressError(f"{words}: only a pin table has parameters, and {file} is none: leave it out")


def load_press(options: argparse.Namespace, **more: Any) -> Linkage:
    """The press that the options name, with crank angles counted as they say; ``more`` goes to `load`."""
    return with_zero(load_as_drawn(options, **more), options.zero)


def load_as_drawn(options: argparse.Namespace, **more: Any) -> Linkage:
    """The press that the options name, built from a pin table or loaded from a file in another format; ``more`` goes to `load`."""
    if names_table(options):
        return drawn(options.file, options.parameters).press(slide=options.slide, **more)
    return load(options.file, driver=options.driver, slide=options.slide, allow_open=options.allow_open, **more)


def load_other(options: argparse.Namespace, file: str, slide: str | None = None) -> Linkage:
    """Another press than that of `load_press`, as its own file has it, with crank angles counted as the options say.

    ``slide`` names its slide where its file leaves that open.
    """
    press = drawn(file).press() if _is_table(file) else load(file)
    if press.slide is None and slide is not None:
        press = drawn(file).press(slide=slide) if _is_table(file) else load(file, slide=slide)
    return with_zero(press, options.zero)


def _is_table(file: str) -> bool:
    """Whether a file is a pin table, or would be one: for the name of a template reading says how to make it."""
    return file.lower().endswith((".yaml", ".yml")) or (file in TEMPLATES and not Path(file).exists())


def drawn(table: str, specs: Sequence[str] = (), option: str = "--set ") -> DrawnPress:
    """The press that a pin table draws.

    Args:
        table: The file.
        specs: Other values of its parameters, such as ``r=150``.
        option: What stands before them on the command line, for messages.

    Raises:
        PinTableError: The table makes no press with these values.
        PinpressError: As `table_parameters`.
    """
    from ...pin_table.building import draft  # with a parser that a URDF does without

    parameters = table_parameters(specs)
    with naming_values(parameters, option):
        return draft(table, **parameters)


@contextmanager
def naming_values(parameters: Mapping[str, str], option: str = "--set ") -> Iterator[None]:
    """Raise errors of a pin table's values under the words by which the command line gives them.

    Args:
        parameters: Values by the names of parameters.
        option: What stands before them on the command line.

    Raises:
        PinTableError: One of the values is wrong.
    """
    from ...pin_table.reading import CALL  # with a parser that a URDF does without

    try:
        yield
    except PinTableError as error:
        name = error.element.rpartition(": ")[2]
        if error.file != CALL or name not in parameters:
            raise
        raise PinTableError(f"{option}{name}={parameters[name]}", None, "", error.problem, error.remedy) from error


def with_zero(press: Linkage, zero: str) -> Linkage:
    """The press with crank angles counted from where `ZEROS` says."""
    if zero == "drawn":
        return press
    press.refuse_several_drivers(f"their angles are 0 where the press is drawn; leave out --zero {zero}")
    press.refuse_sliding_driver(f"its positions are 0 where the press is drawn; leave out --zero {zero}")
    ends = dead_centres(press)
    return press.drawn_at(ends.top_angle if zero == "tdc" else ends.bottom_angle, ZEROS[zero])


def add_force_options(parser: argparse.ArgumentParser, *, friction: bool = True, stiffness: bool = True) -> None:
    """Options of `forces`: loads and springs, and where it is computed with them friction and stiffnesses of bearings."""
    option = parser.add_argument
    add_load_option(parser)
    option("--spring", metavar="KEYS", action="append", default=[], help="spring, see below; may be given several times")
    if friction:
        option("--friction", metavar="NAME:KEYS", action="append", default=[], help="friction of a bearing or guide, or of all, see below")
    if stiffness:
        option(
            "--stiffness",
            metavar="NAME=N/m",
            action="append",
            default=[],
            help=f"stiffness of a bearing, or with {ALL}= of those not named otherwise, by which forces are shared that rigid mechanics"
            " leaves open; may be given several times",
        )


def add_load_option(parser: argparse.ArgumentParser) -> None:
    """Option --load."""
    words = "process load, see below; may be given several times"
    parser.add_argument("--load", metavar="KIND:KEYS", action="append", default=[], help=words)


def add_flywheel_option(parser: argparse.ArgumentParser, meaning: str, *, several: bool = False) -> None:
    """Option --flywheel; ``meaning``: what else its help says; ``several``: whether it may be given several times."""
    action, default = ("append", list[str]()) if several else ("store", None)
    parser.add_argument("--flywheel", metavar="J", action=action, default=default, help=f"inertia at the driver joint, in kg m2; {meaning}")


def add_refused_option(parser: argparse.ArgumentParser, name: str, why: str) -> None:
    """An option that other commands have, and this one refuses with a reason."""

    class Refused(argparse.Action):
        def __call__(self, *_: Any) -> None:
            raise PinpressError(f"{name}: {why}")

    parser.add_argument(name, action=Refused, nargs="?", help=argparse.SUPPRESS)


def add_spring_options(parser: argparse.ArgumentParser) -> None:
    """Options of `springs`."""
    option = parser.add_argument
    help = "the press runs on springs: stiffness of a bearing, or of all, see below; may be given several times"
    option("--stiffness", metavar="NAME=N/m", action="append", default=[], help=help)
    help = "that of a guide against turning, see below"
    option("--moment-stiffness", metavar="NAME=Nm/rad", action="append", default=[], help=help)
    option("--elastic", metavar="KEYS", help="damping, shaft and frame of a press on springs, see below")
    option("--clearance", metavar="NAME:KEYS", action="append", default=[], help="clearance of a pin of a press on springs, see below")
    add_joint_option(parser)
    add_mount_options(parser, "a press on springs shakes it")
    why = "loss of rubber belongs to vibration of one frequency; give --mount with stiffness= and damping=, of the pad at that which counts"
    add_refused_option(parser, "--pad", why)


def add_joint_option(parser: argparse.ArgumentParser) -> None:
    """Option --preloaded-joint."""
    help = "preloaded joint of a guide or the frame in place of its stiffness, see below; may be given several times"
    parser.add_argument("--preloaded-joint", metavar="NAME:KEYS", action="append", default=[], help=help)


def add_mount_options(parser: argparse.ArgumentParser, what: str) -> None:
    """Options of `mounted_press`; ``what``: happens with the frame, for the help."""
    option = parser.add_argument
    option("--frame", metavar="KEYS|FILE", help=f"the frame on its mounts, see below, or a frame file: {what}")
    option("--mount", metavar="KEYS", action="append", default=[], help="a mount below it, see below; may be given several times")


def mounted_press(
    options: argparse.Namespace, press: Linkage, pad: str | None = None, *, motion: Motion | None = None
) -> MountedPress | None:
    """The press on its mounts, of `add_mount_options`; None where none are given.

    Args:
        options: those of `add_mount_options`.
        press: the press that stands on them.
        pad: what the rubber pad of each mount is; None for none.
        motion: as of `mounted`.

    Raises:
        PinpressError: one is given without the other, or beside a file; as `part_specs`, `read_mounted` and `mounted`.
    """
    from ...foundation.frame_file import read_mounted  # seldom needed
    from ...foundation.mounted_press import mounted

    if _is_frame_file(options.frame):
        if options.mount or pad is not None:
            raise PinpressError(f"--{'mount' if options.mount else 'pad'}: the mounts stand in {options.frame}: leave it out")
        return read_mounted(press, options.frame, motion=motion)
    given = _frame_and_mounts(options, pad)
    return None if given is None else mounted(press, *given, motion=motion)


def _rigid_frame(options: argparse.Namespace, press: Linkage) -> tuple[Frame | None, Sequence[Mount]]:
    """The frame and its mounts, of `add_mount_options`, for a press on springs; raises as `mounted_press`, and where there is more."""
    system = mounted_press(options, press) if _is_frame_file(options.frame) else None
    if system is None:
        return _frame_and_mounts(options, None) or (None, [])
    more = [name for name in ("crown", "attached", "rotors") if getattr(system, name)]
    if more or not isinstance(system.frame, Frame):
        what = more[0] if more else "the beams or matrices"
        raise PinpressError(f"--frame: a press on springs stands on one rigid frame: leave out {what} of {options.frame}")
    return system.frame, system.mounts


def _is_frame_file(words: str | None) -> bool:
    return words is not None and words.lower().endswith(FRAME_FILES)


def _frame_and_mounts(options: argparse.Namespace, pad: str | None) -> tuple[Frame, list[Mount]] | None:
    """The frame and its mounts from words; None where none are given."""
    if (options.frame is None) != (not options.mount):
        raise PinpressError("--frame and --mount go together, for the press on its mounts: give --frame and every --mount, or a frame file")
    if options.frame is None:
        return None
    return part_specs.part("--frame", part_specs.FRAME, options.frame), part_specs.mounts(options.mount, pad)


class Forces(TypedDict):
    """What acts on the links besides gravity, under the names that `inverse_dynamics` gives it."""

    loads: list[Load]
    friction: dict[str, Friction]
    stiffness: dict[str, float]


def loads(options: argparse.Namespace) -> list[Load]:
    """The process loads and springs of `add_force_options`."""
    springs = (part_specs.part("--spring", part_specs.SPRING, words) for words in options.spring)
    return [*map(part_specs.load, options.load), *springs]


def forces(options: argparse.Namespace, press: Linkage) -> Forces:
    """Loads, springs, friction and stiffnesses of `add_force_options`.

    Raises:
        PinpressError: Words that are none; see `part_specs`.
    """
    stiffness = part_specs.by_bearing("--stiffness", options.stiffness, "N/m", "stiffness", "1e9")
    return {
        "loads": loads(options),
        "friction": part_specs.frictions(options.friction, press),
        "stiffness": _with_others(stiffness, press.bearings),
    }


def springs(options: argparse.Namespace, press: Linkage) -> Elastic | None:
    """The springs on which a press runs, of `add_spring_options`; None where none are given.

    Raises:
        UnknownNameError: a bearing or guide that the press does not have.
        PinpressError: as `part_specs`; also where a bearing or guide has no stiffness.
    """
    if not options.stiffness:
        beside = ("moment_stiffness", "elastic", "clearance", "preloaded_joint", "frame", "mount")
        alone = next((name for name in beside if getattr(options, name)), None)
        if alone is None:
            return None
        option = f"--{alone.replace('_', '-')}"
        raise PinpressError(f"{option} is for a press on springs: give --stiffness of its bearings too, e.g. --stiffness {ALL}=2e9")
    balls = {loop.name for loop in press.loops if loop.type == "spherical"}
    guides = [name for name, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
    turning_ones = guides if "plane" in press.engines else [name for name in press.bearings if name not in balls]
    across = part_specs.by_bearing("--stiffness", options.stiffness, "N/m", "stiffness", "2e9")
    turning = part_specs.by_bearing("--moment-stiffness", options.moment_stiffness, "N m/rad", "stiffness against turning", "2e8")
    also = part_specs.Yielding() if options.elastic is None else part_specs.part("--elastic", part_specs.ELASTIC, options.elastic)
    clearances = part_specs.clearances(options.clearance, press)
    joints = part_specs.joints(options.preloaded_joint, press)
    if COLUMNS in joints and also.frame is not None:
        raise PinpressError(f"--elastic frame={also.frame:g}: --preloaded-joint {COLUMNS} stands for the columns: leave out either")
    stiffness = Stiffness(
        _of_all("--stiffness", across, press.bearings, "2e9") | {name: joint for name, joint in joints.items() if name != COLUMNS},
        moments=_of_all("--moment-stiffness", turning, turning_ones, "2e8"),
        shaft=also.shaft,
        frame=joints.get(COLUMNS, also.frame),
    )
    frame, mounts = _rigid_frame(options, press)
    try:
        return Elastic(stiffness, also.damping_ratio, {}, also.crown_mass, clearances, mounted_frame=frame, mounts=mounts)
    except PinpressError as error:
        raise PinpressError(f"{error}" if options.elastic is None else f"--elastic {options.elastic}: {error}") from None


def _of_all(option: str, given: dict[str, float], names: Sequence[str], example: str) -> dict[str, float]:
    """Numbers by all names; those that are not given take that of `ALL`."""
    found = _with_others(given, names)
    for name in found:
        if name not in names:
            raise UnknownNameError("bearing", name, (*names, ALL))
    missing = [repr(name) for name in names if name not in found]
    if missing:
        lacks = f"{option} lacks {', '.join(missing)}: all of them yield in an elastic motion"
        raise PinpressError(f"{lacks}; give e.g. {option} {ALL}={example} for the rest")
    return {name: found[name] for name in names}


def _with_others(given: dict[str, float], names: Sequence[str]) -> dict[str, float]:
    """Numbers by names, with that of `ALL` for those of ``names`` that are not given."""
    if ALL not in given or ALL in names:
        return given
    return dict.fromkeys(names, given[ALL]) | {name: number for name, number in given.items() if name != ALL}


def add_out_option(parser: argparse.ArgumentParser, files: str) -> None:
    """Option --out; ``files``: the files that are written, in words for the help."""
    parser.add_argument("--out", type=Path, metavar="DIR", help=f"folder for {files}; made if it is not there")


def add_page_options(parser: argparse.ArgumentParser, files: str) -> None:
    """Options of `write_pages`; ``files``: the files that are written, in words for the help."""
    add_out_option(parser, files)
    add_trace_option(parser)
    parser.add_argument("--report", action="store_true", help="also write report.html: the recording and charts that follow it")


def add_trace_option(parser: argparse.ArgumentParser) -> None:
    """Option --trace, points whose paths are drawn."""
    help = "draw the path of a point, in m in the link's frame; may be given several times"
    parser.add_argument("--trace", type=named_point("a link", "rod:0,0,0.4"), action="append", default=[], metavar="LINK:X,Y,Z", help=help)


def refuse_pages_without_folder(options: argparse.Namespace) -> None:
    """Raise PinpressError where a report or paths are asked for, and no folder to write them into."""
    if options.out is None and (options.report or options.trace):
        raise PinpressError(f"--{'report' if options.report else 'trace'} needs a folder to write into: give --out DIR too")


def named_point(of: str, example: str) -> Callable[[str], tuple[str, tuple[float, float, float]]]:
    """What reads an option of `argparse`: a name and x, y, z [m], ``coupler:0.6,0,0.1``.

    Args:
        of: What the name is of, for messages.
        example: A point, for messages.
    """

    def read(words: str) -> tuple[str, tuple[float, float, float]]:
        name, _, point = words.rpartition(":")  # a name may have a colon in it
        try:
            x, y, z = map(float, point.split(","))
        except ValueError:
            x = y = z = math.nan
        if not name or not math.isfinite(x + y + z):
            raise argparse.ArgumentTypeError(f"{words!r} is no point of {of}; give its name and x, y, z in m, e.g. {example}")
        return name, (x, y, z)

    return read


def write_pages(
    press: Linkage,
    reactions: Reactions,
    options: argparse.Namespace,
    names: Sequence[str],
    before: Reactions | None = None,
    results: Sequence[Tabular] = (),
    flywheel: Flywheel | None = None,
) -> None:
    """Write recording.html, and report.html where it is wanted, and say what has been written.

    Args:
        press: the linkage that is shown.
        reactions: to the motion that is shown.
        options: those of `add_page_options`.
        names: of the files that have been written before, in the same folder.
        before: reactions of another press, for the report.
        results: other results of the press, for the report.
        flywheel: on the driver's shaft; None: that of a run.
    """
    from ...visual.recording import record  # the pages are slow to import

    pages = ["recording.html"]
    record(press, reactions.motion, options.out / "recording.html", reactions=reactions, traces=options.trace, flywheel=flywheel)
    if options.report:
        from ...visual.reports.report import report  # slow to import

        page = options.out / "report.html"
        report(
            press,
            reactions.motion,
            page,
            reactions=reactions,
            traces=options.trace,
            before=before,
            results=results,
            flywheel=flywheel,
        )
        pages.append("report.html")
    say_written(options.out, [*names, *pages])


def print_inputs(rows: Inputs) -> None:
    """Print what a result was computed from."""
    print("\n".join(["", "Inputs", *tables.fitted_words(rows)]))


def say_written(folder: Path, names: Sequence[str]) -> None:
    """Print which files have been written."""
    *first, last = (str(folder / name) for name in names)
    print(f"\nwrote {', '.join(first)} and {last}")


def write_pictures(folder: Path, written: Sequence[str], draw: Callable[[], Mapping[str, Figure]]) -> None:
    """Write pictures where Matplotlib is installed, and say which files have been written.

    Args:
        folder: of the files.
        written: names of those that have been written before.
        draw: gives the figures by the names of their files; it is called where Matplotlib is installed.
    """
    if importlib.util.find_spec("matplotlib") is None:
        print(f"\nwrote {', '.join(str(folder / name) for name in written)}; for pictures: pip install 'pinpress[plots]'")
        return
    from ...plots import style  # slow to import

    figures = draw()
    for name, figure in figures.items():
        style.save(figure, folder / name)
    say_written(folder, [*written, *figures])
