"""The server of a window: on this machine alone, on a free port, and only for those who know its address.

The address contains a token, which is compared in constant time. A request without it, for another host (as after a rebinding of names), or
from a page of another origin is refused with 403. There are a page, four files and a socket, and nothing else: no path is ever looked up on
the disk. The socket takes the messages of `live.session`; any other message closes it.
"""

from __future__ import annotations

import asyncio
import hmac
import html
import importlib.resources
import json
import re
import secrets
import threading
from collections.abc import Callable, Mapping
from typing import Any

from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from .. import visual
from ..common.errors import PinpressError
from ..visual.pages import meshcat_script
from .session import LONGEST, Message, RefusedMessageError, Session
from .sources import state_of_files

HOST = "127.0.0.1"
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src data: blob:; connect-src 'self'; base-uri 'none';"
    " form-action 'none'; frame-ancestors 'self' http://localhost:* http://127.0.0.1:* https://localhost:* vscode-webview:"
)
SCRIPTS = ("scene.js", "overlays.js", "camera.js", "playback.js")  # those of recordings, which go before ours
STYLES = ("theme.css", "player.css")


class Server:
    """A session's server, in a thread with its own event loop.

    Attributes:
        url: the address of the window.
        session: the press that it shows.
        windows: open windows.
    """

    def __init__(self, session: Session, watch: bool) -> None:
        self.session, self._watch = session, watch
        self.windows: set[_Socket] = set()
        self._loop = asyncio.new_event_loop()
        (self._listening,) = bind_sockets(0, HOST)
        port, token = self._listening.getsockname()[1], secrets.token_urlsafe(24)
        self.url = f"http://{HOST}:{port}/{token}/"
        self._hosts = {f"{HOST}:{port}", f"localhost:{port}"}
        self._token = token
        self._stopped: asyncio.Event
        started = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(started,), name="pinpress view", daemon=True)
        self._thread.start()
        started.wait()

    def close(self) -> None:
        """End it; windows say that it has ended."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._stopped.set)
            self._thread.join()

    def join(self, timeout: float) -> bool:
        """Wait, and return whether it has ended."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self, started: threading.Event) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve(started))
        finally:
            self._loop.close()

    async def _serve(self, started: threading.Event) -> None:
        self._stopped = asyncio.Event()
        shared = {"server": self}
        routes = [(r"/([^/]+)/", _Page, shared), (r"/([^/]+)/socket", _Socket, shared), (r"/([^/]+)/([a-z]+\.(?:js|css))", _File, shared)]
        application = Application(
            routes,
            default_handler_class=_Nothing,
            default_handler_args=shared,
            websocket_max_message_size=LONGEST,
            log_function=lambda handler: None,
        )
        http = HTTPServer(application)
        http.add_sockets([self._listening])
        watching = asyncio.create_task(self._look()) if self._watch else None
        started.set()
        await self._stopped.wait()
        if watching is not None:
            watching.cancel()
            await asyncio.wait([watching])
        http.stop()
        for window in list(self.windows):
            window.close(1001, "ended")
        await http.close_all_connections()

    def refused(self, request: Any, token: str) -> bool:
        """Whether a request does not come from one of our windows."""
        known = hmac.compare_digest(token.encode(), self._token.encode())
        origin = request.headers.get("Origin")
        foreign = origin is not None and origin not in {f"http://{host}" for host in self._hosts}
        return not known or foreign or request.host not in self._hosts

    def tell(self, message: Message) -> None:
        """Send a message to all windows."""
        for window in self.windows:
            window.send(message)

    async def _look(self) -> None:
        """Open the press again whenever its files were saved."""
        seen, missed = state_of_files(self.session.files), 0
        while True:
            await asyncio.sleep(0.1)
            now = state_of_files(self.session.files)
            missed = missed + 1 if now is None else 0  # an editor may be replacing a file that is missing for a moment
            if now == seen or (now is None and missed < 10):
                continue
            seen = now
            try:
                self.session.open()
                self.tell(self.session.whole())
            except Exception as error:  # a defect of pinpress too: else the window would stay as it is without a word
                text = str(error) if isinstance(error, PinpressError) else f"{type(error).__name__}: {error}"
                self.tell({"type": "broken", "text": text, "version": self.session.version})


class _Ours(RequestHandler):
    """What all answers have in common: who may ask, and the headers for browsers."""

    def initialize(self, server: Server) -> None:
        self.served_by = server

    def prepare(self) -> None:
        path = self.request.path.split("/")
        if self.served_by.refused(self.request, path[1] if len(path) > 1 else ""):
            raise HTTPError(403)

    def set_default_headers(self) -> None:
        self.set_header("Content-Security-Policy", POLICY)
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cache-Control", "no-store")
        self.clear_header("Server")

    def write_error(self, status_code: int, **_: Any) -> None:
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish({403: "not for you", 404: "nothing here"}.get(status_code, "no"))


class _Nothing(_Ours):
    def get(self) -> None:
        raise HTTPError(404)


class _Page(_Ours):
    def get(self, token: str) -> None:
        whole = self.served_by.session.whole()
        text = _template("live.html" if whole["type"] == "opened" else "broken.html")
        data = json.dumps(whole, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
        title = html.escape(whole.get("name", "pinpress"))
        player = _of_recordings("player.html")
        fields = {"title": title, "data": data, "player": player.replace("{{title}}", title)}
        self.finish(re.sub(r"\{\{(\w+)\}\}", lambda match: fields[match[1]], text))  # in one pass: what is filled in is not searched


class _File(_Ours):
    def get(self, token: str, name: str) -> None:
        if name not in _FILES:
            raise HTTPError(404)
        self.set_header("Content-Type", ("text/javascript" if name.endswith("js") else "text/css") + "; charset=utf-8")
        self.finish(_FILES[name]())


class _Socket(WebSocketHandler):
    """A window. It is sent the newest picture once it has drawn the one before."""

    def initialize(self, server: Server) -> None:
        self.served_by = server
        self._drawing = False
        self._newest: Message | None = None

    def prepare(self) -> None:
        if self.served_by.refused(self.request, self.request.path.split("/")[1]):
            raise HTTPError(403)

    def check_origin(self, origin: str) -> bool:
        return True  # `prepare` has checked it

    def open(self, token: str) -> None:
        self.set_nodelay(True)
        self.served_by.windows.add(self)

    def on_close(self) -> None:
        self.served_by.windows.discard(self)

    def on_message(self, message: str | bytes) -> None:
        try:
            answer = self.served_by.session.answer(message)
        except RefusedMessageError as error:
            self.close(1008, str(error))
            return
        if answer.sender is not None:
            self.send(answer.sender)
        if answer.everyone is not None:
            self.served_by.tell(answer.everyone)
        if answer.drawn is not None:
            self._drawn(answer.drawn)

    def _drawn(self, version: int) -> None:
        """The window has drawn a picture, or a page that was loaded."""
        newest, first, self._newest, self._drawing = self._newest, not self._drawing, None, False
        if newest is not None:
            self.send(newest)
        elif first and version != self.served_by.session.version:
            self.send(self.served_by.session.whole())

    def send(self, message: Message) -> None:
        """Send a message. While the window is behind, a picture takes the place of older pictures that wait."""
        if message["type"] in ("picture", "opened"):
            if self._drawing:
                waiting = self._newest or {}
                self._newest = waiting | message | ({"type": "opened"} if waiting.get("type") == "opened" else {})
                return
            self._drawing = True
        try:
            self.write_message(json.dumps(message, separators=(",", ":"), allow_nan=False))
        except WebSocketClosedError:
            self.served_by.windows.discard(self)


def _template(name: str) -> str:
    return (importlib.resources.files(__package__) / "templates" / name).read_text("utf-8")


def _of_recordings(name: str) -> str:
    return (importlib.resources.files(visual) / "templates" / name).read_text("utf-8")


_FILES: Mapping[str, Callable[[], str]] = {
    "viewer.js": lambda: meshcat_script().read_text("utf-8"),
    "live.js": lambda: "\n".join([*map(_of_recordings, SCRIPTS), _template("live.js")]),
    "broken.js": lambda: _template("broken.js"),
    "live.css": lambda: "\n".join([*map(_of_recordings, STYLES), _template("live.css")]),
}
