"""`pinpress view`: show a press in a live window of the browser, to move and to change."""

import argparse
import sys

from ..jobs.job import traces_of
from .options import SHORT, SIGNS, add_job_options, open_job

EPILOG = f"""\
Sliders change link lengths and pivots, or the numbers of a table of pins; the changed press can be written to a file next to FILE. The
window is served only to this machine, at an address that nobody can guess; Ctrl-C ends it. Paths of points: traces: {{rod: 0 0 400 mm}}.
{SIGNS}{SHORT}pinpress view press.yaml --speed 60r/min --watch
"""
LOOK = 0.2  # interval between checks for Ctrl-C [s]


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `view` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "view",
        help="show a press in a window of the browser, to move and to change",
        description="Show a press turning in the browser, with its forces, and change its lengths, pivots and speed by sliders:\n"
        "slide, driving torque and largest bearing force follow. Without a speed it turns at 60 r/min or 100 mm/s.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_job_options(parser)
    parser.add_argument("--watch", action="store_true", help="read the file again whenever it is saved, and show its errors")
    parser.add_argument("--no-browser", action="store_true", help="print the address, but open no browser")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Open the window, and wait until Ctrl-C ends it."""
    from ..live.drivers import default_speed  # with what pages need, which is slow to import
    from ..live.pictures import Operation
    from ..live.session import Opened
    from ..live.sources import opened
    from ..live.viewing import window

    def opening() -> Opened:
        job = open_job(options)
        file = options.file if job.drawn is not None else job.source.model
        source = opened(str(file), lambda _: job.press, job.parameters, job.sections.get("slide"), job.with_zero)
        speed = default_speed(source.press) if job.speed is None else job.speed
        return Opened(source, Operation(speed, list(job.loads.values()), job.friction, job.stiffness, traces=traces_of(job)))

    with window(opening, options.file if options.watch else None, not options.no_browser) as shown:
        if shown.broken is not None:
            print(shown.broken, file=sys.stderr)
        print(f"{shown.url}\nIt runs until you press Ctrl-C here.", flush=True)
        while not shown.wait(LOOK):
            pass
    return 0
