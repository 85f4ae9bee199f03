"""Gears, racks and screws in pictures: pitch circles that touch, in front of the links, with marks that turn; teeth and threads."""

import re
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from support.in_browser import data_in, floats

import pinpress as pp
from pinpress.visual.shapes.appearance import bodies
from pinpress.visual.shapes.solids import TriangleMesh, volume_and_centre

PLANETARY: dict[str, Any] = {
    "frame": "S A",
    "pins": {"S": [0, 0], "A": "S", "P": [250, 0]},
    "links": {"sun": {"pins": "S", "mass": 10}, "arm": {"pins": "A P", "mass": 40}, "planet": {"pins": "P", "mass": 12}},
    "drive": "S",
    "meshes": {"sun_planet": {"gears": "sun planet", "teeth": [20, 30]}, "ring": {"gears": "planet frame", "teeth": "30 -80", "at": "A"}},
}
ARBOR = {
    "frame": "O",
    "pins": {"O": [-24, 0], "W": [0, 0]},
    "links": {"pinion": {"pins": "O", "mass": 1}, "slide": {"pins": "W", "guide": "up", "mass": 5}},
    "drive": "O",
    "racks": {"rack": {"pinion": "pinion", "rack": "slide", "radius": 24, "side": "left"}},
}
SCREW = {
    "frame": "S",
    "pins": {"S": {"x": 0, "y": 0, "z": 0, "axis": "z"}, "Q": {"x": 0, "y": 0, "z": -200, "axis": "z"}},
    "links": {
        "flywheel": {"pins": "S", "mass": 300, "com": "S", "inertia": [15, 15, 25]},
        "slide": {"pins": "Q", "guide": "up", "mass": 450},
    },
    "drive": "S",
    "screws": {"spindle": {"screw": "flywheel", "nut": "slide", "lead": 200, "diameter": 300, "hand": "right"}},
}


def shown(table, travel=0.0):
    """The press, and the corners of rings, racks and threads of its links in world axes as drawn, by the links."""
    press = pp.build(**table, units="mm")
    positions = np.outer([-0.5, 0.5], [travel] * press.model.nv)
    placed = {}
    data = press.model.createData()
    pin.framesForwardKinematics(press.model, data, pin.neutral(press.model))
    for body in bodies(press, positions):
        for part in body.parts:
            place = data.oMf[body.frame].homogeneous @ part.placement
            if isinstance(part.shape, TriangleMesh):
                assert volume_and_centre(part.shape)[0] > 0.0  # closed, with its faces outwards
                placed.setdefault(body.name, []).append(part.shape.vertices @ place[:3, :3].T + place[:3, 3])
    return press, placed


def test_pitch_circles_touch():
    press, placed = shown(PLANETARY)
    around = {"sun": (0.0, 0.1), "planet": (0.25, 0.15), "frame": (0.0, 0.4)}
    planes = set()
    for link, (centre, radius) in around.items():
        (ring,) = placed[link]
        away = np.hypot(ring[:, 0] - centre, ring[:, 2])
        assert (away.min() if link == "frame" else away.max()) == pytest.approx(radius, rel=1e-12)  # the frame's is internal
        assert abs(away.max() / away.min() - 1) < 0.12
        planes.add(tuple(np.round([ring[:, 1].min(), ring[:, 1].max()], 12)))
    assert len(planes) == 1
    assert set(press.meshes) == {"sun_planet", "ring"}


def test_rack_reaches_over_its_travel():
    """Its teeth end at the pitch line, and it goes on by a radius behind both ends of the way."""
    _, placed = shown(ARBOR, travel=0.4)
    (rack,) = placed["slide"]
    assert rack[:, 0].min() == pytest.approx(0.0, abs=1e-12)
    assert rack[:, 2].min() < -0.2 - 0.024
    assert rack[:, 2].max() > 0.2 + 0.024
    (ring,) = placed["pinion"]
    assert ring[:, 0].max() == pytest.approx(0.0, abs=1e-12)
    assert np.ptp(ring[:, 1]) == pytest.approx(np.ptp(rack[:, 1]))


def test_thread_has_its_lead_and_hand():
    """A right-handed thread climbs along the axis as it turns counter-clockwise."""
    _, placed = shown(SCREW, travel=0.2)
    (thread,) = placed["flywheel"]
    stations = thread.reshape(-1, 4, 3).mean(axis=1)
    angle = np.unwrap(np.arctan2(stations[:, 1], stations[:, 0]))
    assert np.polyfit(angle, stations[:, 2], 1)[0] == pytest.approx(0.2 / (2 * np.pi), rel=1e-9)
    assert np.hypot(stations[:, 0], stations[:, 1]).mean() == pytest.approx(0.15, rel=0.1)


def test_roller_touches_its_cam():
    """At all crank angles the profile comes as near to the roller's centre as its radius; its corners are a 400th of a turn apart."""
    table = {
        "frame": "O",
        "pins": {"O": [0, 0], "P": [0, -60], "W": {"P": 260, "x": 0, "side": "down"}, "E": [0, 110]},
        "links": {
            "crank": {"pins": "O P", "mass": 20},
            "rod": {"pins": "P W", "mass": 15},
            "slide": {"pins": "W", "guide": "up", "mass": 90},
            "ejector": {"pins": "E", "guide": "up", "mass": 12},
        },
        "drive": "O",
        "cams": {
            "cam": {
                "cam": "crank",
                "follower": "ejector",
                "radius": 110,
                "roller": "40 x 30",
                "law": [[0, 0], [120, 0], {"modified sine": [220, 40]}, [250, 40], {"3-4-5": [350, 0]}],
            }
        },
    }
    press = pp.build(**table, units="mm")
    motion = pp.cycle(press, speed=1.0, points=12)
    parts = {body.name: body.parts for body in bodies(press, motion.joint_position)}
    (cam,) = (part for part in parts["crank"] if isinstance(part.shape, TriangleMesh))
    (roller,) = (part for part in parts["ejector"] if getattr(part.shape, "radius", 0.0) == 0.02)
    crank, ejector = (press.placements(link, motion.crank_angle) for link in ("crank", "ejector"))
    for k in range(12):
        profile = (crank[k] @ cam.placement)[:3] @ np.column_stack([cam.shape.vertices, np.ones(len(cam.shape.vertices))]).T
        away = profile - (ejector[k] @ roller.placement)[:3, 3:]
        assert np.hypot(away[0], away[2]).min() == pytest.approx(0.02, abs=5e-5)


def test_tooth_forces_on_pages(tmp_path):
    """Arrows at the pitch points, which go round with the carrier, rows of a table, and no second list of gear pairs."""
    press = pp.build(**PLANETARY, units="mm")
    motion = pp.cycle(press, speed=5.0, points=60)
    reactions = pp.inverse_dynamics(press, motion)
    data = data_in(pp.record(press, motion, tmp_path / "page.html", reactions=reactions))
    shown = {each["name"]: each for each in data["bearings"]}
    assert list(shown) == [*press.bearings, "sun_planet", "ring"]

    for name, radius in (("sun_planet", 0.1), ("ring", 0.4)):
        np.testing.assert_allclose(floats(shown[name]["force"], 3), reactions.bearing_force[name], rtol=1e-6, atol=1e-4)
        place = floats(data["places"][shown[name]["place"]], 3)
        turned = motion.joint_position[:, press.joints.index("A")]
        np.testing.assert_allclose(place[:, [0, 2]], radius * np.column_stack([np.cos(turned), np.sin(turned)]), atol=1e-6)
    sections = {section.title: section for section in reactions.described()}
    assert "Gear pairs" not in sections
    (table,) = (block for block in sections["Bearings and guides"].blocks if block.name == "teeth_at_peak")
    columns = {column.name: column.cells for column in table.columns}
    assert columns["force of - on"] == ["sun - planet", "planet - frame"]
    np.testing.assert_allclose(np.hypot(columns["tangential"], columns["radial"]), columns["peak force"], rtol=1e-12)


def test_pitch_circles_of_sketches():
    """In the sketch of a table and in a notebook's drawing they have the ratio of their teeth, and touch."""
    table = pp.pin_table.draft(**PLANETARY, units="mm")
    for drawing in (table.sketch, table.press()._repr_html_()):
        found = re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="([\d.]+)"[^>]*stroke-dasharray', drawing)
        sun, planet, _, ring = np.array(found, dtype=float)  # the planet meshes twice
        assert planet[2] / sun[2] == pytest.approx(1.5, abs=0.02)
        assert ring[2] / sun[2] == pytest.approx(4.0, abs=0.02)
        assert np.hypot(*(planet - sun)[:2]) == pytest.approx(planet[2] + sun[2], abs=0.2)
        assert np.hypot(*(planet - ring)[:2]) == pytest.approx(ring[2] - planet[2], abs=0.2)


def test_other_planets_stand_round_the_sun():
    meshes = {name: each | {"planets": 4} for name, each in PLANETARY["meshes"].items()}
    _, placed = shown(PLANETARY | {"meshes": meshes})
    centres = np.array([ring.mean(axis=0)[[0, 2]] for ring in placed["arm"]])
    np.testing.assert_allclose(sorted(centres.tolist()), [[-0.25, 0.0], [0.0, -0.25], [0.0, 0.25]], atol=1e-12)
