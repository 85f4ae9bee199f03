"""The server answers those who know its address, from its own pages, and nobody else; what is no message of its windows ends them."""

import asyncio
import http.client
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from support import texts
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

import pinpress as pp

KNUCKLE = Path(pp.__file__).parent / "pin_table" / "templates" / "knuckle.yaml"
OFTEN = 0.5  # within which a file that was saved is shown [s]
SLOW = 20.0  # a machine that does much else [s]


@pytest.fixture(scope="module")
def window() -> Iterator[Any]:
    with pp.view(texts.shipped("crank_slide"), 60 * pp.RPM, browser=False) as shown:
        yield shown


def get(url: str, path: str | None = None, **headers: str) -> tuple[int, dict[str, str], bytes]:
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port, timeout=10)
    connection.request("GET", parts.path if path is None else path, headers=headers)
    answer = connection.getresponse()
    found = answer.status, dict(answer.getheaders()), answer.read()
    connection.close()
    return found


def run(coroutine: Coroutine[Any, Any, Any]) -> Any:
    """In a thread of its own: the browser of other tests has a loop in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, coroutine).result()


async def hang_up(socket: Any) -> None:
    """Close a socket and wait until the other side has."""
    socket.close()
    while await asyncio.wait_for(socket.read_message(), 10) is not None:
        pass


def talk(url: str, *messages: str | bytes, count: int = 1, **headers: str) -> list[Any]:
    """What comes after messages: so many answers, or None where the socket is closed."""

    async def talked() -> list[Any]:
        socket = await websocket_connect(HTTPRequest(url.replace("http", "ws") + "socket", headers=headers))
        for message in messages:
            await socket.write_message(message, binary=isinstance(message, bytes))
        found = [await asyncio.wait_for(socket.read_message(), 10) for _ in range(count)]
        if None in found:
            socket.close()
        else:
            await hang_up(socket)
        return [None if each is None else json.loads(each) for each in found]

    return list(run(talked()))


def test_the_page_and_its_parts(window: Any) -> None:
    status, headers, page = get(window.url)
    assert status == 200
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert "unsafe-eval" not in headers["Content-Security-Policy"]
    assert headers["Cache-Control"] == "no-store"
    for part in re.findall(r'(?:src|href)="([a-z.]+)"', page.decode()):
        assert get(window.url, urlsplit(window.url).path + part)[0] == 200


def test_who_does_not_know_the_address_gets_nothing(window: Any) -> None:
    parts = urlsplit(window.url)
    token = parts.path.strip("/")
    assert len(token) > 30
    wrong = ("/", "/x/", "/viewer.js", f"/{token[:-1]}/", f"/{token}x/", f"/{token.upper()}/live.js", f"//{token}/", "/%00/", f"/?{token}")
    for path in wrong:
        assert get(window.url, path)[0] == 403, path


def test_other_origins_and_hosts_are_refused(window: Any) -> None:
    for name, value in (
        *(("Origin", origin) for origin in ("http://example.com", "null", "http://127.0.0.1:1")),
        *(("Host", host) for host in ("example.com", "127.0.0.1")),
    ):
        assert get(window.url, **{name: value})[0] == 403
        with pytest.raises(HTTPClientError, match="403"):
            talk(window.url, **{name: value})


def test_nothing_else_is_served(window: Any) -> None:
    own = urlsplit(window.url).path
    for path in ("../", "%2e%2e/secret", "live.html", "__init__.py", "..%2flive.js", "player.css", "socket/../live.jsx"):
        status = get(window.url, own + path)[0]
        assert status in (403, 404), path
    assert get(window.url, own + "socket")[0] == 400  # no upgrade


def test_it_listens_on_this_machine_alone(window: Any) -> None:
    assert urlsplit(window.url).hostname == "127.0.0.1"
    listening = [line.split()[1] for line in Path("/proc/net/tcp").read_text().splitlines()[1:] if line.split()[3] == "0A"]
    port = f"{urlsplit(window.url).port:04X}"
    assert [address for address in listening if address.endswith(port)] == [f"0100007F:{port}"]


def test_values_are_answered(window: Any) -> None:
    origin = "http://{0.hostname}:{0.port}".format(urlsplit(window.url))
    values = [101.0, 400.0, 0, 0, 0, 0, 0]
    (picture,) = talk(window.url, json.dumps({"type": "set", "values": values, "speed": 30, "shapes": True}), Origin=origin)
    assert picture["type"] == "picture"
    assert picture["values"] == values


@pytest.mark.parametrize("message", ["hello", '{"type": "run"}', b"\x01\x02", "x" * (1 << 17)], ids=["words", "unknown", "bytes", "long"])
def test_what_is_no_message_ends_the_window(window: Any, message: str | bytes) -> None:
    assert talk(window.url, message) == [None]
    test_values_are_answered(window)  # others go on


def test_several_windows_share_the_press(window: Any) -> None:
    async def both() -> tuple[Any, Any]:
        one, two = [await websocket_connect(window.url.replace("http", "ws") + "socket") for _ in range(2)]
        await one.write_message(json.dumps({"type": "set", "values": [99.0, 400, 0, 0, 0, 0, 0], "speed": 30, "shapes": False}))
        found = [json.loads(await asyncio.wait_for(each.read_message(), 10)) for each in (one, two)]
        await hang_up(one)
        await hang_up(two)
        return found[0], found[1]

    one, two = run(both())
    assert one["values"] == two["values"] == [99.0, 400, 0, 0, 0, 0, 0]


def test_it_ends() -> None:
    shown = pp.view(texts.shipped("crank_slide"), browser=False)
    assert f'src="{shown.url}"' in shown._repr_html_()
    assert not shown.wait(0)
    shown.close()
    shown.close()
    assert shown.wait(0)
    with pytest.raises(ConnectionRefusedError):
        get(shown.url)


def test_what_cannot_be_shown_is_refused() -> None:
    with pytest.raises(pp.PinpressError, match="watch"):
        pp.view(texts.shipped("crank_slide"), watch=True, browser=False)
    with pytest.raises(pp.UrdfError, match="No such file"):
        pp.view("none.urdf", watch=True, browser=False)


@pytest.fixture
def watched(tmp_path: Path) -> Iterator[tuple[Path, str, subprocess.Popen[str]]]:
    path = tmp_path / "own.yaml"
    shutil.copy(KNUCKLE, path)
    command = [sys.executable, "-m", "pinpress", "view", str(path), "--speed", "5 rad/s", "--watch", "--no-browser", "--set", "r=85"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield path, process.stdout.readline().strip(), process
    process.kill()
    process.communicate()


def test_a_file_that_is_saved_is_shown_at_once(watched: tuple[Path, str, subprocess.Popen[str]]) -> None:
    """Written in place, and replaced as editors do; wrong, and mended. Ctrl-C then ends it without a word."""
    path, url, process = watched
    text = path.read_text()

    def replaced(content: str) -> None:
        new = path.with_suffix(".new")
        new.write_text(content)
        os.replace(new, path)

    async def saved() -> list[tuple[Any, float]]:
        socket = await websocket_connect(url.replace("http", "ws") + "socket")
        found = []
        for save, content in (
            (path.write_text, text.replace("drive: O", "drive: Q")),
            (path.write_text, text.replace("l: 650", "l: 640")),
            (replaced, text.replace("l: 650", "l: 630")),
        ):
            save(content)
            began = time.monotonic()
            message = json.loads(await asyncio.wait_for(socket.read_message(), SLOW))
            found.append((message, time.monotonic() - began))
            await socket.write_message(json.dumps({"type": "ready", "version": message["version"]}))
        await hang_up(socket)
        return found

    (wrong, _), (mended, _), (other, _) = found = run(saved())
    assert wrong["type"] == "broken"
    assert re.search(r"own.yaml:\d+: drive: .*Q", wrong["text"])
    assert mended["type"] == other["type"] == "opened"
    assert mended["values"][:2] == [85, 640]
    assert other["values"][:2] == [85, 630]
    assert min(seconds for _, seconds in found) < OFTEN
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=SLOW)
    assert process.returncode in (0, 130, -signal.SIGINT)
