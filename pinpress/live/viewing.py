"""Show a press in a window of the browser, to move and to change."""

from __future__ import annotations

import html
import os
import sys
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType

from numpy.typing import ArrayLike

from ..common.arguments import number, typed
from ..common.errors import PinpressError
from ..common.files import path_of
from ..dynamics.inverse_dynamics import NONE_GIVEN
from ..linkage.linkage import Linkage
from ..linkage.loading import load
from ..loads.link import Friction, Load
from .drivers import default_speed
from .pictures import Operation
from .session import Opened, Session
from .sources import LinkageSource, opened


class LiveView:
    """A window (or several at one address) that `view` has opened. It ends with `close`, with its ``with`` block, or with the program.

    Attributes:
        url: address of the window, only for this machine. Whoever knows it can change the press in the window, and write files next to
            the press's file; so it contains a secret.
    """

    def __init__(self, session: Session, watch: bool) -> None:
        try:
            from .server import Server  # it takes Tornado, which is optional
        except ImportError as error:
            raise PinpressError("the window needs Tornado and Meshcat, which are not installed: pip install 'pinpress[view]'") from error
        self._session, self._server = session, Server(session, watch)

    @property
    def url(self) -> str:
        return self._server.url

    @property
    def broken(self) -> str | None:
        """The reason why the file cannot be read now; None if it can be read."""
        return self._session.broken

    def close(self) -> None:
        """End the window's server. Open windows stay as they are and report this."""
        self._server.close()

    def wait(self, seconds: float) -> bool:
        """Wait, and return whether the server has ended.

        Args:
            seconds: longest time to wait [s].
        """
        return self._server.join(seconds)

    def __enter__(self) -> LiveView:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<LiveView at {self.url}>"

    def _repr_html_(self) -> str:
        """The window itself, in a notebook that runs on this machine."""
        return f'<iframe src="{html.escape(self.url)}" width="100%" height="720" style="border: 0"></iframe>'


@typed
def view(
    press: Linkage | str | os.PathLike[str],
    speed: float | None = None,
    *,
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    stiffness: Mapping[str, float] = NONE_GIVEN,
    traces: Sequence[tuple[str, ArrayLike]] = (),
    watch: bool = False,
    browser: bool | None = None,
) -> LiveView:
    """Open a window in the browser in which a press moves with its forces, and can be changed.

    Sliders change link lengths and pivots (or the numbers of a pin table) and the speed; slide, driving torque and largest bearing force
    follow. Of several drivers one moves; sliders set the positions of the others. A changed press can be written to a file next to the
    press's file. In a notebook the window appears in the cell whose last line is ``pp.view(press)``.

    The window is served on 127.0.0.1 to everybody who knows its address.

    Args:
        press: a press, or the path of a pin table, URDF, SDF or MJCF file, or the name of a shipped press.
        speed: speed of the driver [rad/s or m/s]; by default 60 r/min, or 0.1 m/s for a sliding driver. The window can change it.
        loads: see `inverse_dynamics`.
        friction: see `inverse_dynamics`.
        stiffness: see `inverse_dynamics`.
        traces: points whose paths are drawn, such as a coupler point, see `record`. They follow their links when lengths are changed.
        watch: whether the file is read again whenever it is saved.
        browser: whether a window is opened at once; by default only outside notebooks.

    Returns:
        The window, with its address.

    Raises:
        PinpressError: the press cannot be opened, `cycle` or `inverse_dynamics` refuse it, `watch` is given without a file, or Tornado or
            Meshcat is not installed.
    """
    path = None if isinstance(press, Linkage) else path_of("press", press)
    if watch and path is None:
        raise PinpressError("watch is True, but the press is not given as a file: give the path of its file")

    def opening() -> Opened:
        source = LinkageSource.of(press) if isinstance(press, Linkage) else opened(os.fspath(press), load, {})
        unit = f"{source.press.driver_coordinates[0].unit}/s"
        given = default_speed(source.press) if speed is None else number("speed", speed, unit=unit)
        return Opened(source, Operation(given, loads, friction, stiffness, traces=traces))

    return window(opening, path if watch else None, "ipykernel" not in sys.modules if browser is None else browser)


def window(opening: Callable[[], Opened], watched: str | None, browser: bool) -> LiveView:
    """Open a window.

    Args:
        opening: function that opens the press, at once and whenever its file is saved.
        watched: file that opens the press again when it is saved; then its first version may be wrong. None: no file is watched.
        browser: whether the browser is opened.

    Raises:
        PinpressError: the press cannot be opened.
    """
    session = Session(opening, watched)
    try:
        session.open()
    except PinpressError:
        if watched is None or not os.path.exists(watched):
            raise
    shown = LiveView(session, watched is not None)
    if browser:
        webbrowser.open(shown.url)
    return shown
