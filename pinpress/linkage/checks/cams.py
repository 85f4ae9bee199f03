"""Problems of cams that their elements show without the drawing."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from ...common.errors import suggestion
from ...engines.machine_elements.cams import CamLaw, law_problem
from ..cams import points
from ..description import Cam, Description, Joint
from ..element import Element
from .grammar import Problem
from .machine_elements import link_problems

KINDS = ("open", "groove")
ROUNDED = 1e-9  # share of the largest lift that is rounding


def problems(robot: Element, description: Description) -> Iterator[Problem]:
    """Problems of all cams."""
    moved: set[str] = set()
    for element, cam in zip(robot.all("cam"), description.cams, strict=True):
        faults = list(link_problems(element, (cam.cam, cam.follower), description))
        for link in (cam.cam, cam.follower):
            if link in description.links and not description.moves(link):
                faults.append(
                    (element, f"link {link!r} does not move", "name a cam that turns, and a follower that a guide or a pivot carries")
                )
        yield from faults
        if not faults and cam.cam and cam.follower:
            turning, following = (description.carriers[description.bodies[link]] for link in (cam.cam, cam.follower))
            guided = following.type == "prismatic"
            checks = (
                _joint_problems(cam, turning, following, description, following.name in moved),
                _number_problems(element, cam, guided),
                _law_problems(element, cam, guided),
            )
            yield from ((element, *problem) for problem in itertools.chain(*checks))
            moved.add(following.name)


def _joint_problems(cam: Cam, turning: Joint, following: Joint, description: Description, moved: bool) -> Iterator[tuple[str, str]]:
    if turning.type not in ("revolute", "continuous"):
        yield f"the cam {cam.cam!r} does not turn: joint {turning.name!r} is {turning.type}", "name a link that a pin carries"
    carriers = [description.bodies[joint.parent] for joint in (turning, following)]
    if carriers[0] != carriers[1]:
        apart = f"{carriers[0]!r} carries the cam {cam.cam!r}, and {carriers[1]!r} the follower {cam.follower!r}"
        yield apart, "name a cam and a follower that one link carries"
    rivals = [f"relation {each.name!r} moves it" for each in description.relations if each.joints[:1] == (following.name,)]
    rivals += ["it is geared"] if following.mimic else []
    rivals += ["it is driven"] if following.name in description.drivers else []
    rivals += ["another cam moves it"] if moved else []
    if rivals:
        problem = f"joint {following.name!r} of the follower obeys the cam, and {' and '.join(rivals)}"
        yield problem, "remove one of them"


def _law_problems(element: Element, cam: Cam, guided: bool) -> Iterator[tuple[str, str]]:
    law = points(cam, 1.0 if guided else math.pi / 180)
    if element.all("point") and element.all("row"):
        yield "has points of a law and rows of a table", "write only one of the two"
    elif problem_and_remedy := law_problem(law, cam.tabulated, "m" if guided else "rad"):
        yield problem_and_remedy
    elif not cam.center and cam.drawn_at is None:
        lift = float(CamLaw(law, cam.tabulated)(np.zeros(1))[0][0])
        if abs(lift) > ROUNDED * max(abs(point.lift) for point in law):
            shown = f"{lift:.6g} m" if guided else f"{math.degrees(lift):.6g} deg"
            problem = f"its law has the lift {shown} at 0 deg, in the drawn pose, and the coordinate of the follower is 0 there"
            yield problem, "draw the press where the lift is 0, or write the angle of the law at which it is drawn: drawn_at"


def _number_problems(element: Element, cam: Cam, guided: bool) -> Iterator[tuple[str, str]]:
    for name in ("radius", "roller_radius", "roller_width"):
        if name in element.attributes and not element.fault(name) and not element.number(name, 1.0) > 0.0:
            yield f"{name} is {element.get(name)}", "write a length above 0"
    if cam.kind not in KINDS:
        yield f"unknown kind {cam.kind!r}{suggestion(cam.kind, KINDS)}", f"write one of: {', '.join(KINDS)}"
    if cam.center and (cam.offset is not None or cam.arm is not None):
        yield "the centre of its roller is given twice", "keep its drawn centre, or else offset or arm"
    if guided and cam.arm is not None:
        yield "its follower is in a guide and has no arm", "write offset, the distance of the guide from the axis of the cam"
    if not guided and cam.offset is not None:
        yield "its follower is on an arm and has no offset", "write arm, the length from its pivot to the centre of the roller"
    if not guided and cam.arm is None and not cam.center:
        yield "its follower turns, and nothing says how long its arm is", "write arm, the length from its pivot to the centre of the roller"
    if cam.arm is not None and not cam.arm > 0.0:
        yield f"arm is {cam.arm:g}", "write a length above 0"
    if guided and abs(cam.offset or 0.0) >= cam.radius > 0.0:
        problem = (
            f"its radius is {cam.radius:g} m, not more than the offset {abs(cam.offset or 0.0):g} m: the roller does not reach the cam"
        )
        yield problem, "write a larger radius or a smaller offset"
