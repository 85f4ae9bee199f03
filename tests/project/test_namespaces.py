"""What help says of a namespace: a short text with an example that runs, and signatures that can be read."""

import inspect
import re
import textwrap
from operator import attrgetter

import numpy as np
import pytest
from support.sampling import rest_exhaustive

import pinpress as pp

NAMESPACES = [name for name in dir(pp) if inspect.ismodule(getattr(pp, name))]
NEEDS = {
    "plots": "matplotlib",
    "ratings": "matplotlib",
    "accuracy": "matplotlib",
    "sweeps": "pandas",
    "video": "playwright imageio_ffmpeg meshcat",
}
SLOW = ("accuracy", "plots", "ratings", "video")  # a comparison, pictures, a browser
LONGEST = 20  # lines of a text


def torque_of(speed):
    press = pp.load("crank_slide")
    return {"torque": pp.inverse_dynamics(press, pp.cycle(press, speed=speed, points=24)).driving_torque.max()}


@pytest.fixture
def names():
    press = pp.load("zxn2_3000b")
    motion = pp.cycle(press, speed=70 * pp.RPM, points=90)
    reactions = pp.inverse_dynamics(press, motion)
    return {"pp": pp, "np": np, "press": press, "motion": motion, "reactions": reactions, "torque_of": torque_of}


def names_of_plots(press, motion, reactions):
    """What the example of `plots` draws beside the reactions: two presses, two loads, axes of the caller."""
    from matplotlib.figure import Figure  # optional

    drawing = pp.loads.DeepDrawing(force=1e6, start=0.01)
    pressing = pp.inverse_dynamics(press, motion, [drawing])
    plain, balanced = pp.load("jf75g_125_plain"), pp.load("jf75g_125")
    before, after = (pp.inverse_dynamics(one, pp.cycle(one, speed=300 * pp.RPM, points=24)) for one in (plain, balanced))
    return {"before": before, "after": after, "idle": reactions, "pressing": pressing, "axes": Figure().subplots()}


def example(name):
    """The indented part of a namespace's text."""
    (code,) = re.findall(r"(?:^    .*\n|^\n(?=    ))+", attrgetter(name)(pp).__doc__, flags=re.MULTILINE)
    return textwrap.dedent(code)


@pytest.mark.parametrize("name", rest_exhaustive(NAMESPACES, *(name for name in NAMESPACES if name not in SLOW)))
def test_text_is_short_and_its_example_runs(name, names, tmp_path, monkeypatch):
    assert 6 <= getattr(pp, name).__doc__.count("\n") <= LONGEST
    assert f"pp.{name}." in example(name)
    for needed in NEEDS.get(name, "").split():
        pytest.importorskip(needed)
    monkeypatch.chdir(tmp_path)
    if name == "plots":
        names |= names_of_plots(names["press"], names["motion"], names["reactions"])
    exec(compile(example(name), name, "exec"), names)


def test_package_names_every_namespace():
    assert [name for name in NAMESPACES if f"`{name}`" not in pp.__doc__] == []


def test_signatures_name_types_as_they_are_written():
    """Resolved, an array-like alone has 600 letters."""
    signatures = {name: str(inspect.signature(thing)) for name, thing in functions_and_classes()}
    assert [name for name, shown in signatures.items() if re.search(r"numpy\._typing|numpy\.ndarray|typing\.", shown)] == []


def functions_and_classes():
    """Those of all namespaces, and the classes' methods."""
    for space in (pp, *(getattr(pp, name) for name in NAMESPACES), pp.balancing.classical):
        for thing in map(space.__getattr__, dir(space)):
            if inspect.isfunction(thing):
                yield f"{space.__name__}.{thing.__name__}", thing
            elif inspect.isclass(thing) and not issubclass(thing, Exception):
                yield f"{space.__name__}.{thing.__name__}", thing
                methods = (method for name, method in vars(thing).items() if inspect.isfunction(method) and not name.startswith("_"))
                yield from ((method.__qualname__, method) for method in methods)
