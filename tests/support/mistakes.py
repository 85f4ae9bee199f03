"""Everyday mistakes in pin tables and URDFs: the files of tests/mistakes, and what is said to each."""

import difflib
import warnings
from collections.abc import Callable
from pathlib import Path

import pinpress as pp

FOLDER = Path(__file__).resolve().parents[1] / "mistakes"
TABLE, URDF = FOLDER / "press.yaml", FOLDER / "press.urdf"  # those without a mistake


def files(right: Path) -> list[Path]:
    """The files with a mistake, in the order of the places in the ``right`` file where the mistakes are."""
    found = [file for file in FOLDER.glob(f"*{right.suffix}") if file != right]
    return sorted(found, key=lambda file: (changes(file)[0], file.name))


def changes(file: Path) -> tuple[int, list[str], list[str]]:
    """The number of unchanged lines in front of a mistake, the lines that it puts in, and those that it takes out; without the comment."""
    right = (TABLE if file.suffix == TABLE.suffix else URDF).read_text(encoding="utf-8").splitlines()[1:]
    wrong = file.read_text(encoding="utf-8").splitlines()[1:]
    steps = [step for step in difflib.SequenceMatcher(None, right, wrong, autojunk=False).get_opcodes() if step[0] != "equal"]
    put_in = [line for _, _, _, first, last in steps for line in wrong[first:last]]
    taken_out = [line for _, first, last, _, _ in steps for line in right[first:last]]
    return steps[0][1], put_in, taken_out


def said(file: Path) -> list[str]:
    """What is said to a description, a line each: the error of `load` or `build`, or else its warnings, or else the notes of `check`."""
    read = pp.build if file.suffix == TABLE.suffix else pp.load
    if found := heard(lambda: read(file)):
        return found
    return [f"note: {note.message(str(file))}" for note in pp.check(file).notes if "redundant" not in note.problem]


def heard(call: Callable[[], object]) -> list[str]:
    """What is said to a call, a line each: the error that it raises, or else its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            call()
        except pp.PinpressError as error:
            return [f"error: {error}"]
    return [f"warning: {warning.message}" for warning in caught]
