"""`pinpress new` and `pinpress build`: from a template to a URDF, a sketch and forces."""

import math
import shlex

import pytest
from support.in_browser import data_in

import pinpress as pp
from pinpress.cli.main import main
from pinpress.linkage.document import check_command
from pinpress.pin_table.templates import TEMPLATES


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def figures(text):
    """What is printed below the file's name, without the time it took and the inputs."""
    return [line for line in text.split("\n\nInputs\n")[0].splitlines()[1:] if "time taken" not in line]


def test_from_a_template_to_forces(folder, capsys):
    assert main(["new", "press.yaml", "--template", "knuckle"]) == 0
    assert main(["build", "press.yaml", "--set", "r=95"]) == 0
    said = capsys.readouterr().out
    assert "upper - lower" in said
    assert "no errors" in said
    assert "  stroke                         129." in said
    assert "  K   (" in said  # the knee on the other side, with the stroke that it would give
    assert "stroke 71.765 mm" in said.split("might be at")[1]
    assert sorted(path.name for path in folder.iterdir()) == ["pinpress.schema.json", "press.svg", "press.urdf", "press.yaml"]
    outputs = []
    for file in ("press.urdf", "press.yaml"):
        without = ["--set", "loads=none"] if file == "press.yaml" else []  # which a URDF does not have
        assert main(["analyse", file, "--speed", "60r/min", *without]) == 0
        outputs.append(capsys.readouterr().out)
    assert outputs[0] != outputs[1]  # r is 95 in the URDF alone
    assert main(["build", "press.yaml"]) == 0
    capsys.readouterr()
    assert main(["analyse", "press.urdf", "--speed", "60r/min"]) == 0
    assert figures(capsys.readouterr().out) == figures(outputs[1])


@pytest.mark.parametrize(
    "words", ["analyse knuckle --speed 60r/min", "check knuckle", "check knuckle.yaml", "build knuckle", "view knuckle"]
)
def test_a_template_in_place_of_a_file_says_how_to_make_one(folder, capsys, words):
    assert main(words.split()) == 2
    assert "knuckle: no such file; make one of the template" in capsys.readouterr().err.replace(".yaml: no", ": no")
    with pytest.raises(pp.PinTableError, match=r"pinpress new rssp\.yaml --template rssp, then give rssp\.yaml"):
        pp.build("rssp")


@pytest.mark.exhaustive
def test_the_slide_of_a_table_is_named(folder, capsys):
    assert main(["new", "press.yaml", "--template", "crank-slide"]) == 0
    text = (folder / "press.yaml").read_text(encoding="utf-8").replace("slide:", "ram:")
    text = text.replace("links:", "  V: {P: 450, x: 0, side: down}\nlinks:")
    more = "  arm: {pins: P V, mass: 9}\n  holder: {pins: V, guide: up, mass: 40}\ndrive:"
    (folder / "press.yaml").write_text(text.replace("drive:", more), encoding="utf-8")
    printed = {}
    for name in ("ram", "holder"):
        for words in (["check", "press.yaml"], ["analyse", "press.yaml", "--speed", "60r/min", "--set", "points=60"]):
            capsys.readouterr()
            assert main([*words, "--set", f"slide={name}"]) == 0
            printed[name, words[0]] = capsys.readouterr().out
        assert f"  {name}; heights are above" in printed[name, "analyse"]
        assert main(["build", "press.yaml", "--set", f"slide={name}"]) == 0
        assert capsys.readouterr().out.splitlines()[1:9] == printed[name, "check"].splitlines()[1:9]  # stroke and dead centres
    assert printed["ram", "check"] != printed["holder", "check"]
    loaded = ["report", "press.yaml", "--speed", "60r/min", "--load", "drawing:force=10kN,start=5mm", "--out", "report.html"]
    assert main([*loaded, "--set", "slide=ram"]) == 0
    assert main(["check", "press.yaml"]) == 0
    assert "in a job slide: " in capsys.readouterr().out


@pytest.mark.exhaustive
def test_every_command_takes_other_values_of_a_tables_parameters(folder, capsys):
    assert main(["new", "press.yaml", "--template", "knuckle"]) == 0
    assert main(["build", "press.yaml", "--set", "r=95"]) == 0
    without_load = ["press.yaml", "--set", "loads=none"]  # which a URDF does not have
    for words in (
        ["analyse", "--speed", "60r/min", "--set", "points=60"],
        ["simulate", "--set", "run.duration=0.1s", "--speed", "60r/min"],
        ["check"],
    ):
        shown = []
        for file in (["press.urdf"], [*without_load, "--set", "r=95"], without_load):
            capsys.readouterr()
            assert main([*words, *file]) == 0
            said = capsys.readouterr().out
            assert ("press.yaml with r=95 as URDF" in said) == ("r=95" in file and words != ["check"])
            shown.append([line for line in figures(said) if line.startswith(("  stroke ", "  K "))])
        assert shown[0] == shown[1] != shown[2]


@pytest.mark.exhaustive
def test_a_report_shows_the_table_as_it_is_beside_other_values(folder):
    assert main(["new", "press.yaml", "--template", "crank-slide"]) == 0
    report = ["report", "press.yaml", "--speed", "60r/min", "--set", "points=36", "--out", "report.html"]
    assert main([*report, "--set", "r=90", "--set", "report.before=press.yaml"]) == 0
    rows = {row[0]: row for row in data_in(folder / "report.html")["report"]["sections"][-1]["blocks"][0]["rows"]}
    (position,) = (row for name, row in rows.items() if name.startswith(("slide position", "slide height")))
    assert position[-4:-2] == ["180.00", "200.00"]  # of the crank's radius of 90 and 100 mm


@pytest.mark.parametrize("name", TEMPLATES)
def test_every_template_builds(folder, capsys, name):
    assert main(["new", "press.yml", "--template", name]) == 0
    assert main(["build", "press.yml", "--out", "out.urdf"]) == 0
    assert "0 errors" not in capsys.readouterr().out
    assert (folder / "out.svg").read_text(encoding="utf-8").startswith("<svg")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["new", "there.yaml"], "is there already"),
        (["new", "press.txt"], "does not end in .yaml"),
        (["build", "there.yaml", "--set", "r"], "--set r: write a name and its value"),
        (["build", "there.yaml", "--set", "q=1"], "--set q=1: there is no 'q'; name a section or one of the parameters r, l"),
        (["check", "there.yaml", "--set", "r=9cm"], "--set r=9cm: r: '9cm' is not a number"),
        (["view", "there.yaml", "--no-browser", "--set", "r=9cm"], "--set r=9cm: r: '9cm' is not a number"),
        (["analyse", "mine.urdf", "--speed", "60r/min", "--set", "r=95"], "there is no 'r'"),
        (["analyse", "crank_slide", "--speed", "60r/min", "--set", "q=95"], "there is no 'q'"),
        (["build", "there.yaml", "--out", "press.svg"], "give the URDF's name"),
        (["build", "missing.yaml"], "missing.yaml"),
        (["build", "there.yaml", "--out", "mine.urdf"], "was not written from a pin table"),
        (["analyse", "there.yaml", "--speed", "60r/min", "--set", "drivers=O"], "drivers: it is for a press of a file; leave it out"),
        (["build", "there.yaml", "--set", "l=20"], "drawn in there.svg"),
    ],
)
def test_what_is_refused(folder, capsys, words, said):
    assert main(["new", "there.yaml", "--template", "crank-slide"]) == 0
    (folder / "there.yaml").write_text((folder / "there.yaml").read_text(encoding="utf-8").replace("x: 0", "x: 50"), encoding="utf-8")
    (folder / "mine.urdf").write_text("<robot/>", encoding="utf-8")
    capsys.readouterr()
    assert main(words) == 2
    assert said in capsys.readouterr().err
    assert (folder / "there.svg").exists() == ("drawn" in said)


def test_the_other_side_is_the_press_that_it_makes(folder, capsys):
    """Stroke and least transmission angle are those of the table with the other side."""
    assert main(["new", "press.yaml", "--template", "knuckle"]) == 0
    assert main(["build", "press.yaml"]) == 0
    said = capsys.readouterr().out.split("might be at")[1]
    text = (folder / "press.yaml").read_text(encoding="utf-8")
    (line,) = (line for line in text.splitlines() if line.lstrip().startswith("K:"))
    (side,) = (word for word in ("up", "down", "left", "right") if f"side: {word}" in line)
    other = {"up": "down", "down": "up", "left": "right", "right": "left"}[side]
    (folder / "other.yaml").write_text(text.replace(line, line.replace(f"side: {side}", f"side: {other}")), encoding="utf-8")
    press = pp.build("other.yaml")
    least = min(dyad.least_transmission_angle for dyad in pp.measures.least_transmission_angles(press))
    wanted = f"stroke {1e3 * pp.dead_centres(press).stroke:.3f} mm, least transmission angle {math.degrees(least):.2f} deg"
    assert next(line for line in said.splitlines() if line.startswith("  K ")).endswith(wanted)
    with pytest.raises(pp.UnknownNameError, match="there are: K, S"):
        pp.pin_table.draft("press.yaml").with_other_place("O")


def test_tables_are_checked(folder, capsys):
    """The page is that of the URDF; an error of the table is a finding with its line."""
    assert main(["new", "press.yaml", "--template", "crank-slide"]) == 0
    capsys.readouterr()
    assert main(["check", "press.yaml"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("press.yaml: no errors, no warnings, 1 note\n")
    assert "  stroke                         200.000 mm" in said
    assert main(shlex.split(check_command("press.yaml", parameters=("r=90",)))[1:]) == 0  # what an error of its URDF would name
    assert "  stroke                         180.000 mm" in capsys.readouterr().out
    text = (folder / "press.yaml").read_text(encoding="utf-8").replace("drive: ", "drive: Q")
    (folder / "press.yaml").write_text(text, encoding="utf-8")
    assert main(["check", "press.yaml"]) == 1
    said = capsys.readouterr().out
    line = 1 + next(k for k, line in enumerate(text.splitlines()) if line.startswith("drive"))
    assert f"press.yaml:{line}: error: drive: " in said
    assert main(["check", "missing.yaml"]) == 2
