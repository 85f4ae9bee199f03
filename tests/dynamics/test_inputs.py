"""What a result was computed from, in words: every load, drive and press says what it is, and a changed press that it was changed."""

import dataclasses
import datetime

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.common.quantities import RAM
from pinpress.dynamics.inputs import described, inputs
from pinpress.simulation.run import inputs_of

SPEED = 70 * pp.RPM
BLANK = pp.loads.Blanking(1e6, 0.006, 0.002)


def steady(time):
    return np.full_like(time, 5.0)


class OfCallers:
    """A load of a caller's own."""

    datum = None

    def __repr__(self):
        return "my press tool"


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (BLANK, "blanking: force = 1000 kN, start = 6 mm, end = 2 mm, stripping = 0 N"),
        (pp.loads.ForceStroke([0.0, 0.01, 0.05], [8e5, 6e5, 0.0]), "force stroke: heights = (0, 10, 50) mm, forces = (800, 600, 0) kN"),
        (
            pp.loads.ForceStroke(np.linspace(0, 0.05, 6), np.linspace(8e5, 1e5, 6), datum=-0.9),
            "force stroke: heights = 6 numbers from 0 to 50 mm, forces = 6 numbers from 100 to 800 kN, datum = -900 mm",
        ),
        (pp.loads.PointForce("rod", (0.0, 0.0, 5.0)), "point force: link = rod, force = (0, 0, 5) N, point = (0, 0, 0) mm"),
        (pp.loads.TimeForce(steady), "time force: force = steady, edges = ()"),
        (pp.loads.Friction(0.08, 0.06), "friction: coefficient = 0.08, radius = 60 mm, viscous = 0, preload = 0 N"),
        (pp.drives.Flywheel(2000.0, 70 * pp.RPM), "flywheel: inertia = 2000 kg m2, speed = 70 r/min"),
        (
            pp.drives.Geared(pp.drives.ConstantTorque(567.0), 20.7),
            "geared: ratio = 20.7, gear inertia = 0 kg m2, efficiency = 1; drive: constant torque: value = 567 N m",
        ),
        (
            pp.drives.Brake(4e4, closes=pp.drives.SwitchPoint(time=0.1)),
            "brake: torque = 40 kN m, rise = 0 s; closes: switch point: time = 0.1 s",
        ),
        (pp.drives.SwitchPoint(angle=np.pi), "switch point: angle = 180 deg"),
        (OfCallers(), "my press tool"),
        ("what was sent in words", "what was sent in words"),
    ],
    ids=lambda part: type(part).__name__,
)
def test_parts_in_words(part, words):
    assert described(part) == words


def test_what_drives_a_driver_that_slides_has_forces():
    servo = pp.drives.ServoMotor((0.0, 1.0), (0.0, 0.1), 2e6, 9e3, 50e3, 40.0)
    constant = pp.drives.ConstantTorque(20000.0)
    assert described(constant, RAM) == "constant torque: value = 20 kN"
    geared = described(pp.drives.Geared(constant, 600.0, gear_inertia=3.0), RAM)
    assert geared == "geared: ratio = 600, gear inertia = 3 kg, efficiency = 1; drive: constant torque: value = 20 kN m"
    assert described(pp.drives.PrescribedSpeed(0.1), RAM) == "prescribed speed: speed = 0.1 m/s"
    assert described(servo, RAM).split("stiffness = ")[1] == "2 kN/mm, damping = 9000 N s/m, peak torque = 50 kN, inertia = 40 kg"


def test_inputs_of_reactions():
    press = texts.shipped("zxn2_3000b")
    friction = dict.fromkeys(["A", "B"], pp.loads.Friction(0.1, 0.05)) | {"slide_guide": pp.loads.Friction(0.05)}
    reactions = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=24), [BLANK], friction, {"A": 1e9})
    rows = dict(inputs(reactions))
    assert rows["press"] == "zxn2_3000b, driven at joint A; its slide is link slide"
    assert rows["file"].startswith("zxn2_3000b.urdf, shipped with pinpress, SHA-256 of the URDF ")
    assert rows["motion"] == "one period at 70 r/min, 24 states"
    assert rows["load"] == described(BLANK)
    both, guide = (described(friction[name]) for name in ("A", "slide_guide"))
    assert rows["friction"] == f"A, B: {both}; slide_guide: {guide}"
    assert rows["stiffness"] == "A: 1000 kN/mm"
    assert rows["computed by"] == f"pinpress {pp.__version__}, engine 'plane', on {datetime.date.today().isoformat()}"
    nothing = dict(inputs(pp.inverse_dynamics(press, reactions.motion)))
    assert (nothing["loads"], nothing["friction"]) == ("none but weight", "none")
    assert inputs_of(reactions) == inputs(reactions)


def test_a_changed_press_says_so():
    press = texts.shipped("zxn2_3000b")
    heavier = press.model.copy()
    heavier.inertias[1].mass += 1.0
    hanging = press.model.copy()
    hanging.gravity.linear = np.array([0.0, 0.0, -1.6])
    said = []
    for model in (press.model, heavier, hanging):
        changed = dataclasses.replace(press, model=model)
        said.append(dict(inputs(pp.inverse_dynamics(changed, pp.cycle(changed, SPEED, points=24)))))
    assert ["changed" in rows["file"] for rows in said] == [False, True, False]
    assert [rows.get("gravity") for rows in said] == [None, None, "(0, 0, -1.6) m/s2"]


def test_inputs_of_a_run():
    press = texts.shipped("crank_slide")
    clutch = pp.drives.Clutch(500.0, closes=pp.drives.SwitchPoint(time=0.01))
    parts = {"drive": pp.drives.ConstantTorque(50.0), "flywheel": pp.drives.Flywheel(20.0), "clutch": clutch}
    run = pp.simulate(press, 0.05, speed=SPEED, angle=0.5, loads=[BLANK], points=12, **parts)
    rows = dict(inputs_of(pp.inverse_dynamics(press, run, [BLANK])))
    assert rows["motion"] == "simulated from crank angle 28.6479 deg at 70 r/min, 0.05 s, 12 states"
    assert [rows[name] for name in parts] == [described(part).removeprefix(f"{name}: ") for name, part in parts.items()]
    assert "method 'reduced' by explicit, tolerance 1e-11" in rows["computed by"]


def test_prescribed_motion():
    press, time = texts.shipped("crank_slide"), np.linspace(0.0, 1.0, 201)
    motion = pp.servo_cycle(press, 2 * np.pi * time - np.sin(2 * np.pi * time), time=time, period=1.0)
    assert dict(inputs(pp.inverse_dynamics(press, motion)))["motion"] == "prescribed, crank at up to 120 r/min, over 1 s, 201 states"
