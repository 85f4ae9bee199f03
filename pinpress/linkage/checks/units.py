"""Numbers of a URDF that are probably not in SI units: lengths in mm, angles in degrees, masses in g, moments of inertia of any of these.

A wrong unit makes a factor of a thousand, in proportion to the linkage and to the pins of each link; the limits are wide enough that no
machine part reaches them. Only numbers that enter the mechanics are checked, of a URDF without errors.
"""

import math
from collections.abc import Iterator

from ..description import MACHINE_ELEMENTS, Description
from ..document import Document, Finding
from ..element import Element
from .elements import principal_moments
from .grammar import warning

SHORT = 0.5  # a link counts as at least this long [lengths of the linkage], however close together its pins are
OUTSIDE = 3.0  # a centre of mass may be this far from the pins of its link [lengths of the link]
WIDE = 3.0  # a lead or pitch radius may be as large [lengths of the linkage]
NARROW = {"lead": 1e-4, "radius": 1e-3, "diameter": 1e-3, "collar_diameter": 1e-3}
"""Below these no press has teeth or threads [m]: they are metres in a table of millimetres."""
GYRATION = 5.0  # the radius of gyration of a link may be as large [lengths of the link]

KG_M2 = "write moments of inertia in kg m2, and the mass in kg"


def remarks(document: Document, size: float, mass: float, centres: bool = True) -> Iterator[Finding]:
    """Warnings of lengths, angles, masses and moments of inertia in other units.

    Args:
        document: a URDF without errors.
        size: length of its linkage [m].
        mass: that moves [kg].
        centres: whether centres of mass are looked at.
    """
    robot = document.robot
    # A small linkage may weigh 10 t; heavy slides over short cranks make up to 1e5 kg/m3 of the cube of the linkage's size.
    heavy = mass > max(1e4, 1e6 * size**3)
    yield from length(robot, size)
    if heavy:
        yield warning(robot, f"its links weigh {mass:.4g} kg, in a linkage of {size:.3g} m", "write masses in kg, 0.001 for a gram")
    yield from angles(robot)
    yield from _teeth(robot, size)
    description = document.description
    for link in robot.all("link"):
        for inertial in link.all("inertial"):
            if centres:
                yield from _centre(description, link.get("name"), inertial, size)
            if link.get("name") not in document.estimated:
                # No metal has more than 2.3e4 kg/m3; a wrong unit makes millions.
                yield from _inertia(description, link.get("name"), inertial, size, math.inf if heavy else 1e7)


def length(robot: Element, size: float) -> Iterator[Finding]:
    """The warning of a linkage that is longer than any press; it need not close."""
    if size > 50.0:
        yield warning(robot, f"the linkage is {size:.4g} m long", "write lengths in metres, 0.001 for a millimetre")


def _teeth(robot: Element, size: float) -> Iterator[Finding]:
    """Warnings of leads and radii of teeth and threads that are larger than the linkage, or smaller than any."""
    for element in robot.all(*MACHINE_ELEMENTS):
        for name in ("lead", "radius", "diameter", "module"):
            if (length := element.number(name, 0.0)) > WIDE * size:
                yield warning(element, f"{name} is {length:g} m, in a linkage of {size:.3g} m", "write it in metres, 0.01 for 10 mm")
        for name, least in NARROW.items():
            if 0.0 < (length := element.number(name, 0.0)) < least:
                yield warning(element, f"{name} is {1e3 * length:.3g} mm", "write it in metres, in a table in the unit of the table")


def angles(robot: Element) -> Iterator[Finding]:
    """Warnings of roll, pitch and yaw beyond a turn, of any URDF."""
    for part in robot.all("link", "joint", "loop_joint"):
        for parent in (part, *part.all("inertial")):
            for element in parent.all("origin", "link1", "link2"):
                if (most := max(map(abs, element.numbers("rpy")), default=0.0)) > 2 * math.pi:
                    problem = f"rpy={element.get('rpy')!r} turns by more than a full turn: it seems to be in degrees"
                    yield warning(element, problem, f"write radians, {math.radians(most):.17g} for {most:g} degrees")


def _centre(description: Description, name: str, inertial: Element, size: float) -> Iterator[Finding]:
    """The warning of a centre of mass far outside of a link's pins."""
    for origin in inertial.all("origin"):
        centre = origin.numbers("xyz")
        # The link's own origin is one of its pins, so that most links need no look at the others.
        if not description.moves(name) or math.hypot(*centre) <= OUTSIDE * SHORT * size:
            continue
        away = min(math.dist(centre, pin) for pin in description.pins[name])
        if away > (5.0 * size if description.is_on_frame(name) else OUTSIDE * _length(description, name, size)):
            problem = f"the centre of mass is {away:.3g} m from the nearest pin of link {name!r}, in a linkage of {size:.3g} m"
            yield warning(origin, problem, "write it in metres, in the link's own frame")


def _inertia(description: Description, name: str, inertial: Element, size: float, densest: float) -> Iterator[Finding]:
    """Warnings of moments of inertia out of proportion to the link's pins and, where it turns, to its mass; ``densest``: [kg/m3]."""
    (mass,), inertia = inertial.all("mass")[0].numbers("value"), inertial.all("inertia")[0]
    trace = sum(inertia.numbers(name)[0] for name in ("ixx", "iyy", "izz"))
    if mass <= 0 or trace <= 0:
        return
    turns = name in description.turning
    # No body of this mass and these moments fills more than a sphere does: radius^2 = 5/6 of their sum, the trace, by the mass.
    density = mass / (4 / 3 * math.pi * (5 / 6 * trace / mass) ** 1.5)
    suspect = turns and density > densest
    if not suspect and math.sqrt(trace / mass) <= GYRATION * SHORT * size:
        return  # without the principal moments, which take long
    largest = max(principal_moments(inertia))
    radius = math.sqrt(largest / mass)
    if suspect:
        least = f"with {mass:.6g} kg and moments of inertia up to {largest:.3g} kg m2 its density is at least"
        yield warning(inertia, f"{least} {density:.0e} kg/m3", KG_M2)
    # A link on the frame may carry a flywheel, and moments of inertia of a link that slides have no effect.
    wide = not turns or description.is_on_frame(name)
    most = 10.0 * size if wide else GYRATION * _length(description, name, size)
    if radius > most:
        yield warning(inertia, f"the radius of gyration is {radius:.3g} m, of a linkage of {size:.3g} m", KG_M2)


def _length(description: Description, link: str, size: float) -> float:
    """Largest distance of a link's pins, but not less than a part of the linkage's length [m]."""
    pins = description.pins[link]
    return max(SHORT * size, max(math.dist(one, other) for one in pins for other in pins))
