"""Everyday mistakes in URDFs: what is said to each."""

import pytest
from support import mistakes


def said(folder, text):
    file = folder / "press.urdf"
    file.write_text(text, encoding="utf-8")
    return mistakes.said_to(str(file))


@pytest.mark.parametrize("mistake", mistakes.IN_URDFS)
def test_what_is_said(tmp_path, mistake):
    expected = mistakes.IN_URDFS[mistake]
    found = said(tmp_path, mistakes.with_mistake(mistakes.URDF, expected.edits))
    assert any(expected.words in line for line in found), found


def test_nothing_is_said_to_what_is_right(tmp_path):
    assert said(tmp_path, mistakes.URDF) == []
