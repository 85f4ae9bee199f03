"""Files that a model names: MuJoCo opens no pipe, and nothing beside the model's folder."""

import os

import pytest

import pinpress as pp

pytest.importorskip("mujoco")
BODY = (
    '<worldbody><body><joint name="A" axis="0 1 0"/><geom type="box" size=".1 .2 .1" mass="1"/></body></worldbody>'
    '<actuator><motor joint="A"/></actuator>'
)


def model(folder, content):
    folder.mkdir(exist_ok=True)
    path = folder / "arm.xml"
    path.write_text(f"<mujoco>{content}{BODY}</mujoco>", encoding="utf-8")
    return path


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in folders here")
@pytest.mark.parametrize(
    "content",
    [
        '<include file="pipe"/>',
        '<asset><mesh name="k" file="pipe"/></asset>',
        '<compiler meshdir="sub"/><asset><mesh name="k" file="../pipe"/></asset>',
        '<compiler assetdir="sub"/><asset><texture name="t" type="2d" file="pipe"/></asset>',
        '<include file="inner.xml"/>',
    ],
)
def test_a_pipe_is_refused_instead_of_waited_for(tmp_path, content):
    folder = tmp_path / "model"
    path = model(folder, content)
    (folder / "sub").mkdir()
    (folder / "inner.xml").write_text('<mujoco><asset><hfield name="h" file="pipe"/></asset></mujoco>')
    for place in (folder / "pipe", folder / "sub" / "pipe"):
        os.mkfifo(place)
    with pytest.raises(pp.PinpressError, match=r"<(include|mesh|texture|hfield).*pipe' is not a regular file"):
        pp.load(path)


@pytest.mark.parametrize("way", ["../other.xml", "sub/../../other.xml", "{}", "link.xml"])
def test_what_is_included_is_below_the_models_folder(tmp_path, way):
    other = tmp_path / "other.xml"
    other.write_text("<mujoco><option timestep='1'/></mujoco>")
    path = model(tmp_path / "model", f'<include file="{way.format(other)}"/>')
    (tmp_path / "model" / "link.xml").symlink_to(other)
    with pytest.raises(pp.PinpressError, match=r"<include.*other.xml' is outside of the model's folder"):
        pp.load(path)


def test_what_is_included_beside_the_model_is_read(tmp_path):
    path = model(tmp_path / "model", '<include file="sub/inner.xml"/>')
    (tmp_path / "model" / "sub").mkdir()
    (tmp_path / "model" / "sub" / "inner.xml").write_text('<mujoco><option timestep="1"/></mujoco>')
    assert pp.load(path).joints == ("A",)
