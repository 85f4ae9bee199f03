"""`pinpress view`: show a press in a window of the browser, to move and to change."""

import argparse
import sys

from .words import part_specs
from .words.forces import add_force_options, forces
from .words.motions import SPEED
from .words.outputs import SIGNS
from .words.press import add_press_options, load_press, names_table, naming_values, table_parameters, with_zero
from .words.units import OfDriver, driver_speed

EPILOG = f"""\
Sliders change link lengths and pivots, or the numbers of a pin table; the changed press can be written to a file next to FILE. The window
is served only to this machine, at an address that nobody can guess; Ctrl-C ends it.
{part_specs.explained("load", "spring", "friction")}
{SIGNS}e.g. pinpress view press.yaml --speed 60 --watch
     pinpress view zxn2_3000b --speed 70 --load blanking:force=1000kN,start=6mm,end=2mm
"""
LOOK = 0.2  # interval between checks for Ctrl-C [s]


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `view` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "view",
        help="show a press in a window of the browser, to move and to change",
        description="Show a press turning in the browser, with its forces, and change its lengths, pivots and speed by sliders:\n"
        "slide, driving torque and largest bearing force follow.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_press_options(parser)
    option("--speed", type=driver_speed, metavar="RPM", help=f"{SPEED} (default: 60 r/min or 100 mm/s)")
    add_force_options(parser)
    option("--watch", action="store_true", help="read the file again whenever it is saved, and show its errors")
    option("--no-browser", action="store_true", help="print the address, but open no browser")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Open the window, and wait until Ctrl-C ends it."""
    from ..live.drivers import default_speed  # with what pages need, which is slow to import
    from ..live.pictures import Operation
    from ..live.session import Opened
    from ..live.sources import opened
    from ..live.viewing import window

    table = names_table(options)
    speed: OfDriver | None = options.speed

    def opening() -> Opened:
        parameters = table_parameters(options.parameters) if table else {}
        with naming_values(parameters):
            source = opened(
                options.file, lambda _: load_press(options), parameters, options.slide, lambda press: with_zero(press, options.zero)
            )
        press = source.press
        found = default_speed(press) if speed is None else speed.of(press.driver_coordinates[0])
        acting = forces(options, press)
        return Opened(source, Operation(found, acting["loads"], acting["friction"], acting["stiffness"]))

    with window(opening, options.file if options.watch else None, not options.no_browser) as shown:
        if shown.broken is not None:
            print(shown.broken, file=sys.stderr)
        print(f"{shown.url}\nIt runs until you press Ctrl-C here.", flush=True)
        while not shown.wait(LOOK):
            pass
    return 0
