"""Progress on a terminal and in a log, and the time that is left."""

import io
import re
import sys
import time

import pytest

from pinpress.cli import simulate
from pinpress.cli.options import progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.exhaustive
def test_a_bar_on_a_terminal_after_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("COLUMNS", "80")
    with progress(10.0, simulate.BAR) as told:
        told(2.5)
        assert terminal.getvalue() == ""
        time.sleep(1.05)
        told(5.0)
        assert " 50 % |" in terminal.getvalue()
        assert "5.000 of 10.000 s" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r")  # wiped


@pytest.mark.parametrize("stream", [Terminal, io.StringIO])
def test_the_time_left_follows_from_the_speed_of_this_run(monkeypatch: pytest.MonkeyPatch, stream: type[io.StringIO]) -> None:
    """Half of the work is there from an earlier run; from there on a hundredth takes a minute, now more and now less."""
    output, clock = stream(), [0.0]
    monkeypatch.setattr(sys, "stderr", output)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    monkeypatch.setattr("tqdm.std.time", lambda: clock[0])
    with progress(1.0) as told:
        for minute in range(21):
            clock[0] = 60.0 * minute
            told(0.5 + 0.01 * minute + 0.003 * (minute % 2))
        lines = output.getvalue().replace("\r", "\n").strip().splitlines()
    assert lines[-1].startswith(" 70 % |")
    left = re.search(r"(?:(\d+):)?(\d+):(\d+) to go$", lines[-1])
    assert left is not None
    assert 25 <= 60 * int(left[1] or 0) + int(left[2]) <= 35


def test_a_log_has_a_line_a_minute(monkeypatch: pytest.MonkeyPatch) -> None:
    output, clock = io.StringIO(), [0.0]
    monkeypatch.setattr(sys, "stderr", output)
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    with progress(100.0) as told:
        for second in range(1, 101):
            clock[0] = second
            told(second)
        assert output.getvalue() == " 61 % |" + output.getvalue()[7:]
        assert output.getvalue().endswith("| 00:39 to go\n")
        assert output.getvalue().count("\n") == 1
