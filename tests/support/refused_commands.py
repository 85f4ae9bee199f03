"""Commands that refuse their words."""

import pytest

from pinpress.cli.main import main


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """What a command prints on stderr when it refuses its words, itself or by argparse: with the status 2 of wrong usage, and nothing on
    stdout."""
    status: object
    try:
        status = main([*map(str, arguments)])
    except SystemExit as end:  # argparse's
        status = end.code
    out, err = capsys.readouterr()
    assert status == 2
    assert out == ""
    assert err
    return err


def one_line(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """The one line on stderr of a command that is refused by pinpress, not by argparse."""
    err = refused(capsys, *arguments)
    assert err.startswith("pinpress: ")
    assert err.count("\n") == 1
    return err
