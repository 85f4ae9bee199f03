"""How a command ends: with an exit code and at most one line on stderr, never with a traceback.

Ctrl-C may come while modules are still being imported and nothing catches it yet. Therefore this module is imported first, and lets Ctrl-C
end the command.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from typing import Any

INTERRUPTED = 130  # exit code of a command that Ctrl-C ended, as in shells: 128 + the signal's number


def ended(program: str, run: Callable[[], int]) -> int:
    """Run a command to its end, its output written out. Warnings of ours are lines on stderr.

    Returns its exit code: 2 where the input is at fault or the output cannot be written, 130 after Ctrl-C. A reader that closes the output,
    as ``| head`` does, does not end the command: it still writes its files.
    """
    from .errors import PinpressError  # not at the top: Ctrl-C must be handled before anything else is imported

    if signal.getsignal(signal.SIGINT) is _end_at_once:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with redirect_stdout(sys.stdout and _Output(sys.stdout)):
            try:
                with _plain_warnings():
                    return run()
            finally:
                if sys.stdout is not None:
                    sys.stdout.flush()
    except PinpressError as error:
        return _refused(program, " ".join(str(error).split()), 2)
    except KeyboardInterrupt:
        return _refused(program, "interrupted", INTERRUPTED)
    except OSError as error:
        if error.filename is not None:  # it is not about the output, but a defect of pinpress
            raise
        _silence()
        return _refused(program, f"cannot write the output: {error.strerror or error}", 2)


class _Output:
    """Standard output that goes on without its reader: what nobody reads any more is discarded."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write a text, unless its reader has gone."""
        with self._reader_may_go():
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write out what is in the buffer, unless its reader has gone."""
        with self._reader_may_go():
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @staticmethod
    @contextmanager
    def _reader_may_go() -> Iterator[None]:
        try:
            yield
        except BrokenPipeError:
            _silence()


@contextmanager
def _plain_warnings() -> Iterator[None]:
    """Warnings of ours are printed as one plain line, the same words once; a file and line of Python, which others have, would say nothing
    to those who wrote a command."""
    import warnings  # only once Ctrl-C is seen to

    from .errors import PinpressWarning  # as above

    usual = warnings.formatwarning
    said: set[str] = set()

    def formatted(message: Warning | str, category: type[Warning], filename: str, lineno: int, line: str | None = None) -> str:
        if issubclass(category, PinpressWarning):
            words = f"warning: {' '.join(str(message).split())}\n"
            first = words not in said
            said.add(words)
            return words if first else ""
        return usual(message, category, filename, lineno, line)

    warnings.formatwarning = formatted
    try:
        yield
    finally:
        warnings.formatwarning = usual


def _refused(program: str, words: str, code: int) -> int:
    with suppress(OSError):
        print(f"{program}: {words}", file=sys.stderr, flush=True)
    return code


def _silence() -> None:
    """Discard the rest of the output, which Python would otherwise try to write when it ends, with an error message."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


def _end_at_once(*_: object) -> None:
    os.write(2, b"pinpress: interrupted\n")
    os._exit(INTERRUPTED)


def _is_command() -> bool:
    """Whether this program is the command. While ``python -m pinpress`` imports the package, the program's name is -m."""
    name = sys.argv[0] if getattr(sys, "argv", None) else ""
    return name == "-m" or os.path.splitext(os.path.basename(name))[0] == "pinpress"


if (
    _is_command()
    and threading.current_thread() is threading.main_thread()
    and signal.getsignal(signal.SIGINT) is signal.default_int_handler
):
    signal.signal(signal.SIGINT, _end_at_once)
