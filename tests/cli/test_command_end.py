"""How commands end where the output cannot be written, nobody reads it, or Ctrl-C comes: an exit code, at most a line, no traceback."""

import os
import signal
import subprocess
import sys

import pytest

pytestmark = pytest.mark.usefixtures("time_limit")

COMMANDS = {
    "module": ["-m", "pinpress"],
    "script": ["-c", "import sys; sys.argv[0] = '/usr/bin/pinpress'; from pinpress.cli.main import main; sys.exit(main())"],
}
AT_IMPORT = """
import os, signal, sys
class Finder:
    def find_spec(self, name, *_):
        if name == os.environ["INTERRUPTED_AT"]:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Finder())
"""


def run(command, *arguments, **more):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"} | more.pop("env", {})
    return subprocess.run([sys.executable, *COMMANDS[command], *arguments], env=environment, stderr=subprocess.PIPE, text=True, **more)


@pytest.mark.parametrize("arguments", [["check", "crank_slide"], ["--help"]], ids=" ".join)
def test_output_that_cannot_be_written(arguments):
    with open("/dev/full", "w") as full:
        ended = run("module", *arguments, stdout=full)
    assert (ended.returncode, ended.stderr) == (2, "pinpress: cannot write the output: No space left on device\n")


@pytest.mark.exhaustive
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_output_that_nobody_reads(unbuffered):
    reader, writer = os.pipe()
    os.close(reader)
    ended = run("module", "check", "crank_slide", stdout=writer, env={"PYTHONUNBUFFERED": unbuffered})
    os.close(writer)
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.exhaustive
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_files_are_written_for_nobody_too(tmp_path, unbuffered):
    """`pinpress analyse ... --out out | head -1`: the files are still wanted."""
    reader, writer = os.pipe()
    os.close(reader)
    arguments = ["analyse", "crank_slide", "--speed", "60r/min", "--set", "points=24", "--out", "out"]
    ended = run("module", *arguments, stdout=writer, env={"PYTHONUNBUFFERED": unbuffered}, cwd=tmp_path)
    os.close(writer)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert {file.name for file in (tmp_path / "out").iterdir()} == {"cycle.csv", "recording.html", "report.html"}


@pytest.mark.parametrize(
    ("command", "module"),
    [
        ("module", "numpy"),
        ("module", "pinpress.cli.record"),
        ("module", "pinpress.visual.recording"),
        ("script", "numpy"),
    ],
)
def test_interrupted(tmp_path, command, module):
    """While modules are imported: those of the library, those of the command, and later those of its work."""
    (tmp_path / "sitecustomize.py").write_text(AT_IMPORT)
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    arguments = ["analyse", "crank_slide", "--speed", "60r/min", "--out", str(tmp_path / "out")]
    ended = run(command, *arguments, stdout=subprocess.DEVNULL, env={"PYTHONPATH": path, "INTERRUPTED_AT": module}, cwd=tmp_path)
    assert ended.returncode == 130
    assert ended.stderr.split(" ... ")[-1] == "pinpress: interrupted\n"
    assert "Traceback" not in ended.stderr


def test_the_library_leaves_ctrl_c_alone():
    words = "import signal, pinpress; assert signal.getsignal(signal.SIGINT) is signal.default_int_handler"
    subprocess.run([sys.executable, "-c", words], check=True)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.exhaustive
def test_a_warning_that_comes_twice_is_said_once():
    arguments = ["analyse", "crank_slide", "--speed", "60r/min", "--set", "points=8", "--load", "drawing:force=630kN,start=6m"]
    ended = run("module", *arguments, stdout=subprocess.DEVNULL)
    assert ended.stderr.count("warning: DeepDrawing acts from 0 to 6 m") == 1
