"""What a description says that nothing reads is told: misspelt attributes, and elements in the wrong place. What other programs write is
not."""

import warnings
from importlib.metadata import files

import pytest
from support import mistakes

import pinpress as pp
from pinpress.common.errors import UrdfError
from pinpress.linkage.checks import grammar
from pinpress.linkage.loading import parse

RIGHT = mistakes.URDF.read_text(encoding="utf-8")
JOINT = '<joint name="P" type="continuous">'
UNREAD = {
    JOINT.replace("<joint", '<joint nmae="Q"'): (
        JOINT,
        "its attribute 'nmae' is not read, did you mean 'name'?; correct or remove it: attributes of <joint> are name, type",
    ),
    JOINT.replace(">", ' axis="0 1 0">'): (JOINT, "its attribute 'axis' is not read; write an element <axis> in this <joint>"),
    '<link name="rod" mass="20">': (
        '<link name="rod">',
        "its attribute 'mass' is not read; correct or remove it: attributes of <link> are name",
    ),
    "<inertial mass='15'>": ("<inertial>", "its attribute 'mass' is not read; write an element <mass> in this <inertial>"),
    '<loop_joint name="W" type="spherical" xyz="0 0 0.1">': (
        '<loop_joint name="W" type="spherical">',
        "its attribute 'xyz' is not read; correct or remove it: attributes of <loop_joint> are name, type",
    ),
    '<robot name="press" verson="1.0">': ('<robot name="press">', "its attribute 'verson' is not read, did you mean 'version'?"),
    '<transmission name="drive"><jonit name="P"/>': (
        '<transmission name="drive">',
        "<jonit> in it is not read, did you mean 'joint'?; write <joint name=\"...\"/>, the driver",
    ),
    "<origin><xyz>0.03 0 0</xyz></origin>": (
        '<origin xyz="0.03 0 0"/>',
        "<xyz> in it is not read; write what it says as attributes of <origin>: xyz, rpy",
    ),
    "<origin>0.03 0 0</origin>": (
        '<origin xyz="0.03 0 0"/>',
        'has neither xyz nor rpy; text in it is not read; write <origin xyz="..." rpy="..."/>',
    ),
}
FOREIGN = (
    '<joint name="P" type="continuous"><dynamics damping="0" K="1" D="2" mu_coulomb="0.1" spring_stiffness="3"/>',
    '<joint name="P" type="continuous" dont_collapse="true">',
    '<joint drake:name="P" name="P" type="continuous">',
)


def loaded(folder, text):
    """What is warned of; the file is called as no program writes it."""
    file = folder / "Stößel der Presse.urdf"
    file.write_text(text, encoding="utf-8")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pp.load(file)
    found = [str(warning.message) for warning in caught]
    listed = [finding.message(str(file)) for finding in pp.check(file).warnings]
    assert listed == found
    return [each.removeprefix(f"{file}:") for each in found]


@pytest.mark.parametrize("wrong", UNREAD)
def test_what_nothing_reads_is_told(tmp_path, wrong):
    right, said = UNREAD[wrong]
    assert right in RIGHT
    text = RIGHT.replace(right, wrong, 1)
    (found,) = loaded(tmp_path, text)
    line = text[: text.index(wrong)].count("\n") + 1
    assert found.startswith(f"{line}: <")
    assert said in found


@pytest.mark.parametrize("more", FOREIGN)
def test_what_other_programs_write_is_not(tmp_path, more):
    assert loaded(tmp_path, RIGHT.replace(JOINT, more, 1)) == []


@pytest.mark.exhaustive
def test_robots_of_other_programs_are_read_in_silence():
    every = [path for path in files("example-robot-data") if path.suffix == ".urdf"]
    assert len(every) > 50
    for path in every:
        assert list(grammar.find_unknown(parse(path.locate()).robot)) == []


LOOP = """<loop name="W" type="spherical"><predecessor link="rod"><origin xyz="0 0 -0.4"/></predecessor>
  <successor link="slide"/></loop>"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("xyz=", "xzy=", "unknown attribute 'xzy', did you mean 'xyz'?; in <origin> write: xyz, rpy"),
        ("<origin", "<orign", "unknown element <orign>, did you mean 'origin'?; in <predecessor> write one of: origin"),
        ("</loop>", "<axsi/></loop>", "unknown element <axsi>, did you mean 'axis'?"),
    ],
)
def test_a_misspelt_loop_of_another_dialect_is_refused(tmp_path, old, new, said):
    start, end = RIGHT.index("  <loop_joint"), RIGHT.index("  <transmission")
    right = RIGHT[:start] + LOOP + RIGHT[end:]
    assert loaded(tmp_path, right) == []
    with pytest.raises(UrdfError) as caught:
        loaded(tmp_path, RIGHT[:start] + LOOP.replace(old, new, 1) + RIGHT[end:])
    assert said in str(caught.value)
