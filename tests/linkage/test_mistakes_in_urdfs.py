"""Everyday mistakes in URDFs: what is said to each."""

import pytest
from support import mistakes


@pytest.mark.parametrize("mistake", mistakes.IN_URDFS)
def test_what_is_said(tmp_path, mistake):
    expected = mistakes.IN_URDFS[mistake]
    found = mistakes.said_to_urdf(tmp_path / "press.urdf", mistakes.with_mistake(mistakes.URDF, expected.edits))
    assert any(expected.words in line for line in found), found


def test_nothing_is_said_to_what_is_right(tmp_path):
    assert mistakes.said_to_urdf(tmp_path / "press.urdf", mistakes.URDF) == []
