"""Every malformed URDF of the corpus is refused with an error that names the place and the fault, and listed by `check` as well."""

import re

import pytest
from support import texts
from support.generators.malformed_linkages import DEAD, DRIVERS, GOES, MOBILITIES, OPEN, ROBOT
from support.generators.malformed_urdf import ELEMENTS, FILES

import pinpress as pp

CORPUS = [
    *(pytest.param(text, pp.UrdfError, *expected, id=f"{expected[-1]}") for text, *expected in [*FILES, *ELEMENTS, *DRIVERS]),
    *(pytest.param(text, pp.UrdfError, ROBOT, None, problem, id=problem) for text, problem in MOBILITIES),
    *(pytest.param(text, pp.AssemblyError, *expected, id=f"{expected[-1]}") for text, *expected in OPEN),
    *(pytest.param(text, pp.SingularityError, ROBOT, None, problem, id=problem) for text, problem in DEAD),
]


@pytest.fixture
def file(tmp_path):
    return tmp_path / "press.urdf"


def written(file, text):
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return file


@pytest.mark.parametrize(("text", "error", "element", "line", "problem"), CORPUS)
def test_malformed(file, capfd, text, error, element, line, problem):
    written(file, text)
    with pytest.raises(pp.PinpressError) as caught:
        pp.load(file)
    assert type(caught.value) is error
    listed = pp.check(file).errors
    first = listed[0]
    assert (first.element, first.line) == (element, line)
    assert first.problem.partition("; it misses")[0] == problem if problem.startswith("mobility is 0") else problem in first.problem
    assert first.remedy
    said = str(first.error) + (f" ({len(listed) - 1} more: pinpress check {file} lists them)" if len(listed) > 1 else "")
    assert str(caught.value) == said
    if isinstance(caught.value, pp.UrdfError):
        assert (caught.value.file, caught.value.element, caught.value.line) == (str(file), element, line)
        assert (caught.value.problem, caught.value.remedy) == (first.problem, first.remedy)
    assert capfd.readouterr() == ("", "")


def test_the_corpus_is_of_linkages_that_load_but_for_the_fault(file):
    assert pp.check(written(file, GOES)).errors == ()
    assert pp.load(file).mobility == 1


@pytest.mark.parametrize("tag", ["robot", "link", "joint"])
def test_names_that_turn_the_line_round_are_refused(tag, tmp_path):
    text = texts.shipped("crank_slide").text.decode()
    path = tmp_path / "press.urdf"
    path.write_text(re.sub(rf'<{tag} name="', f'<{tag} name="\u202e', text, count=1), encoding="utf-8")
    with pytest.raises(pp.PinpressError, match=r"has the character U\+202E"):
        pp.load(path)
