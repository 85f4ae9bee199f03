"""What stiffnesses, guides, links that bend and their results refuse, each with its message: a table of (call, message)."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import (
    Clearance,
    Elastic,
    GuideSurface,
    PreloadedJoint,
    Rod,
    Stiffness,
    campbell,
    compliance,
    dead_centre_shift,
    eight_way_guide,
    flexible_beam,
    guide_contact,
    natural_frequencies,
    permissible_breakthrough,
    slide_deflection,
    snap_through,
)

JF75G, SIX_BAR = "jf75g_125_plain", "zxn2_3000b"
SPEED = 300 * pp.RPM
EVEN = {"P4_left": 1e9, "P4_right": 1e9}
BEARINGS = {"O": 3e9, "P2": 4e9, "P4": 4e9, "slide_guide": 2e9}
TIE_RODS, LOOSE = PreloadedJoint(loaded=2e9, relieved=6e9, preload=2.5e6), PreloadedJoint(2e9, 6e9, 1e4)
GUIDE = eight_way_guide(facing_x=(0.3, 0.2), facing_y=(0.25, 0.28), length=0.6, width=0.1, stiffness=5e8, preload=1e5)
DEPENDENT = [
    pp.loads.ElasticDie(0.0, 1e9),
    pp.loads.PointForce("slide", lambda motion: (0, 0, 1.0)),
    pp.loads.SpringDamper("frame", "slide", 1.0, 2.0),
]


def broken(**more):
    return snap_through(**{"force": 1.25e6, "stiffness": 6e8, "mass": 2600.0} | more)


def shared_by_guide(bearings, **more):
    return compliance(shipped("jf75g_125_symmetric"), Stiffness(bearings, **more), angle=[0.0, 0.4, 1.3])


def deflected(stiffness):
    press = shipped(JF75G)
    return slide_deflection(press, pp.cycle(press, SPEED, points=12), stiffness)


def shifted(**more):
    return dead_centre_shift(shipped("crank_slide"), Stiffness({"W": 1e9}), **{"speed": 1.0} | more)


def springs(name=JF75G, **more):
    press = shipped(name)
    return Stiffness(dict.fromkeys(press.bearings, 2e9), moments={"slide_guide": 2e8}, **more)


def elastic():
    return Elastic(springs())


def vibrate(**given):
    return natural_frequencies(shipped("crank_slide"), **{"elastic": Elastic(springs("crank_slide"))} | given)


def main_rod(**more):
    return flexible_beam(shipped(JF75G), "main_rod", ("P2", "P4"), **{"area": 0.033, "second_moment": 4e-5} | more)


def changed(**more):
    return replace(main_rod(), **more)


def bend(*links, clearances=None, **more):
    return natural_frequencies(
        shipped(JF75G), Elastic(springs(**more), flexible_links=list(links), clearances=clearances or {}), angle=[0.0]
    )


def struck(load):
    elastic, held = Elastic(springs(), flexible_links=[main_rod()]), pp.drives.PrescribedSpeed(SPEED)
    return pp.steady_state(shipped(JF75G), SPEED, drive=held, loads=[load], elastic=elastic, points=5)


def guided(surfaces, force=(1e4, 0.0, 1e5), point=(0.1, 0.0, 0.0), **more):
    """Surfaces of the crank-slide press under a force on its slide."""
    press, load = shipped("crank_slide"), pp.loads.PointForce("slide", force, point)
    reactions = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=[0.0, 0.4], speed=0.0), loads=[load], **more)
    return guide_contact(press, reactions, surfaces)


def of_two_points():
    press = shipped("jf75g_125_two_point")
    reactions = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=[0.1], speed=0.0), loads=[pp.loads.ConstantForce(1e6, 0.02)])
    assert np.isfinite(guide_contact(press, reactions, GUIDE).shift).all()
    return guide_contact(press, reactions, GUIDE, offset=(0.0, 0.1, 0.0))


def surface(**changes):
    return GuideSurface(**{"name": "a", "point": (0, 0, 0), "normal": (1, 0, 0), "length": 1, "width": 1, "stiffness": 1e9} | changes)


REFUSALS = [
    (lambda: broken(force=0.0), "force is 0.0"),
    (lambda: broken(stiffness=-6e8), "stiffness is"),
    (lambda: broken(mass=np.inf), "mass is inf"),
    (lambda: broken(damping_ratio=1.0), "damping_ratio is 1"),
    (lambda: broken(damping_ratio=-0.1), "damping_ratio is -0.1"),
    (lambda: broken(break_time=-1.0), "break_time is -1"),
    (lambda: broken(clearance=np.nan), "clearance is nan"),
    (lambda: broken(break_time=100.0), "more than 1000 periods"),
    (lambda: permissible_breakthrough(0.0, 6e8, 2600.0), "reverse_force is 0"),
    (lambda: permissible_breakthrough([1e5, 2e5], [6e8, 6e8, 6e8], 2600.0), "of one length"),
    (lambda: compliance(shipped("crank_slide"), Stiffness()), "no part of crank_slide is elastic"),
    (lambda: compliance(shipped("crank_slide"), Stiffness({"Q": 1e9})), "no bearing 'Q'"),
    (lambda: compliance(shipped("crank_slide"), Stiffness({"O": -1e9})), "stiffness of bearing 'O' is -1000000000.0"),
    (lambda: compliance(shipped("crank_slide"), Stiffness({"O": True})), "stiffness of bearing 'O' is True"),
    (lambda: compliance(shipped("crank_slide"), Stiffness(moments={"P": 1e9})), "'P', which is not a guide"),
    (lambda: compliance(shipped("crank_slide"), Stiffness(rods=1e9)), "rods is 1000000000.0: give a list of Rod"),
    (lambda: compliance(shipped("crank_slide"), Stiffness(rods=[Rod("bar", ("P", "W"), 1e9)])), "no moving link 'bar'"),
    (
        lambda: compliance(shipped("crank_slide"), Stiffness(rods=[Rod("rod", ("P", "O"), 1e9)])),
        "bearing 'O' is not on that link; there are: P, W",
    ),
    (lambda: compliance(shipped("crank_slide"), Stiffness(rods=[Rod("rod", ("P", "P"), 1e9)])), "names of two of its bearings"),
    (lambda: compliance(shipped("crank_slide"), Stiffness(rods=[Rod("rod", ("P", "W"), 1e9)] * 2)), "several parts are named rod P-W"),
    (lambda: compliance(shipped("crank_slide"), Stiffness(rods=["rod"])), "give a list of Rod"),
    (lambda: compliance(shipped("crank_slide"), Stiffness({"O": 1e9}, shaft=0.0)), "stiffness of the shaft is 0.0"),
    (lambda: compliance(shipped("crank_slide"), Stiffness({"O": 1e9}, frame=np.nan)), "stiffness of the frame is nan"),
    (lambda: compliance(shipped("crank_slide"), Stiffness(shaft=1e9)), "nothing of crank_slide yields at crank angle 0 deg"),
    (lambda: compliance(shipped("crank_slide"), Stiffness([("O", 1e9)])), "bearings is"),
    (lambda: compliance(shipped("crank_slide"), {"O": 1e9}), "stiffness is a dict"),
    (lambda: shared_by_guide({"P4_left": 1e9, "P4_right": 2e9}, moments={"slide_guide": 1e7}), "make both sides alike"),
    (lambda: shared_by_guide(EVEN, rods=[Rod("slide", ("slide_guide", "P4_left"), 1e8)]), "make both sides alike"),
    (lambda: compliance(shipped("crank_slide"), Stiffness(rods=[Rod("slide", ("slide_guide", "W"), 1e9)])), "its bearings meet"),
    (lambda: PreloadedJoint(0.0, 1e9, 1e5), "PreloadedJoint: loaded is 0.0[;:] give a positive number"),
    (lambda: PreloadedJoint(1e9, 1e9, -1e5), "PreloadedJoint: preload is -1"),
    (lambda: PreloadedJoint(1e9, "stiff", 1e5), "PreloadedJoint: relieved"),
    (lambda: deflected(Stiffness(BEARINGS | {"O": TIE_RODS})), "stiffness of 'O' is a PreloadedJoint, which a guide has across its axis"),
    (lambda: deflected(Stiffness(BEARINGS | {"slide_guide": TIE_RODS})), "both gibs of a guide are alike"),
    (lambda: deflected(Stiffness(BEARINGS, {"slide_guide": TIE_RODS})), "stiffness of guide 'slide_guide' against turning"),
    (
        lambda: dead_centre_shift(shipped(JF75G), Stiffness(BEARINGS, frame=LOOSE), speed=SPEED),
        r"the joint of frame opens by 31\.416 rad/s",
    ),
    *((partial(shifted, speed=speed), "speed") for speed in ([np.nan], [], [[1.0]], "fast")),
    *((partial(shifted, loads=[load]), "may depend on the speed") for load in DEPENDENT),
    (lambda: dead_centre_shift(shipped("crank_slide"), Stiffness({"W": 1e9}, shaft=1e-3), speed=50.0), "too soft"),
    (lambda: slide_deflection(shipped("crank_slide"), shipped("crank_slide"), Stiffness({"W": 1e9})), "motion is a Linkage"),
    (lambda: campbell(shipped(JF75G), elastic(), speeds=[3.0, 2.0]), "rising"),
    (lambda: campbell(shipped(JF75G), elastic(), speeds=[0.0]), "positive"),
    (lambda: campbell(shipped(JF75G), elastic(), speeds=[]), "rising"),
    (lambda: campbell(shipped(JF75G), elastic(), speeds=[1.0], orders=0), "orders"),
    (lambda: vibrate(angle=[[0.0]]), "angle has shape"),
    (lambda: vibrate(angle=[]), "angle has shape"),
    (lambda: vibrate(flywheel=pp.drives.Flywheel([1.0, 2.0])), "several inertias"),
    (lambda: vibrate(elastic=Elastic(Stiffness({"O": 1e9}))), "lacks 'P'"),
    (lambda: vibrate(elastic=Elastic(Stiffness({"O": 1e9}), clearances={"P": Clearance(1e-4)})), "leave the clearances out"),
    (lambda: bend(changed(mass=np.eye(3))), "stiffness has shape"),
    (lambda: bend(changed(stiffness=np.triu(main_rod().stiffness))), "not symmetric"),
    (lambda: bend(changed(stiffness=main_rod().stiffness + 1e9 * np.eye(27))), "resists when the link moves as a whole"),
    (lambda: bend(changed(degrees=np.zeros((27, 2)))), "each once"),
    (lambda: bend(changed(bearings={"P2": 0})), "number of its node"),
    (lambda: bend(changed(bearings={"P2": 0, "P4": 9})), "node of bearing 'P4'"),
    (lambda: bend(changed(modes=-1)), "modes"),
    (lambda: bend(changed(damping_ratio=3)), "damping_ratio is 3"),
    (lambda: bend(changed(mass=-main_rod().mass)), "negative mass"),
    (lambda: bend(changed(mass=0.0 * main_rod().mass)), "no mass"),
    (lambda: bend(changed(bearings={"P2": 0, "P9": 8})), "name all of them"),
    (lambda: bend(changed(bearings={"P2": 0, "P4": 7})), "places of the bearings from each other"),
    (lambda: bend(changed(mass=1.1 * main_rod().mass)), r"mass \[kg\] by its matrices: 85.239; in the linkage: 77.49"),
    (lambda: bend(changed(nodes=1000 * main_rod().nodes)), "resists when"),
    (lambda: bend(changed(link="slide")), "it slides in a guide"),
    (lambda: bend(changed(link="crank")), "it is the crank"),
    (lambda: bend(changed(link="rod")), "no moving link"),
    (lambda: bend(main_rod(elements=1)), "elements"),
    (lambda: bend(main_rod(area=0)), "area"),
    (lambda: bend(flexible_beam(shipped(JF75G), "main_rod", ("P2", "O"), area=1, second_moment=1)), "a beam has two"),
    (lambda: bend(flexible_beam(shipped(SIX_BAR), "rocker", ("D", "E"), area=1, second_moment=1)), "a beam has two"),
    (lambda: bend(main_rod(), main_rod()), "yields twice"),
    (lambda: bend(main_rod(), rods=[Rod("main_rod", ("P2", "P4"), 1e9)]), "yields twice"),
    (lambda: bend(1), "give FlexibleLinks"),
    (lambda: Elastic(springs(), flexible_links=main_rod()), "give a list"),
    (lambda: struck(pp.loads.PointForce("main_rod", (0.0, 0.0, 1.0))), "a load acts on the flexible link 'main_rod'"),
    (lambda: struck(pp.loads.SpringDamper("frame", "main_rod", 1e4, point1=(0, 0, 1.0))), "a load acts on the flexible link 'main_rod'"),
    (lambda: guided([]), "give a list of GuideSurface"),
    (lambda: guided([GUIDE[0], GUIDE[0]]), "several surfaces are named left front x"),
    (lambda: guided([replace(GUIDE[0], normal=(0.0, 0.0, 1.0))]), "not across the guide's axis"),
    (lambda: guided(GUIDE[:2]), "do not hold the slide of crank_slide .* on both sides"),
    (lambda: guided([replace(each, clearance=1e-4, preload=0.0) for each in GUIDE[:4]], (0, 0, 1e5), (0, 0.1, 0)), "do not hold the slide"),
    (lambda: guided(GUIDE, (0.0, 1e5, 0.0), (0.0, 0.0, 0.0)), "across the plane of crank_slide"),
    (lambda: guided(GUIDE, bearings=("W",)), "leave out 'slide_guide'"),
    (of_two_points, "parallel rods of jf75g_125_two_point share moments"),
    (lambda: surface(stiffness=0.0), "GuideSurface 'a': stiffness"),
    (lambda: surface(preload=1e5, clearance=1e-4), "give one of them"),
    (lambda: surface(clearance=-1e-4), "not negative"),
    (lambda: surface(normal=(0.0, 0.0, 0.0)), "normal"),
    (lambda: surface(name=""), "a name of its own"),
]


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message for _, message in REFUSALS])
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()
