"""What a URDF says that is allowed but hardly meant, or meant but not heard: warnings and notes, element by element."""

import math
from collections.abc import Iterator

from .document import Element
from .findings import Finding
from .link_checks import bodies_of, principal_moments

MOST_GYRATION = 10.0  # radius of gyration in lengths of the linkage
DENSEST = 1e7  # that a link may be [kg/m3], hundreds of times as dense as any metal: a wrong unit makes millions


def remarks(robot: Element) -> Iterator[Finding]:
    """Warnings and notes of a URDF; it may have errors too."""
    yield from _names(robot, "link")
    yield from _names(robot, "joint", "loop_joint")
    yield from _drawn_limits(robot)
    yield from _massless(robot)
    yield from _unread(robot)


def inertias(robot: Element, size: float) -> Iterator[Finding]:
    """Warnings of links whose moments of inertia are out of proportion to a linkage of a size [m], or, where they turn, to their mass; of a
    URDF without errors."""
    turning = _turning(robot)
    for link in robot.all("link"):
        for inertial in link.all("inertial"):
            (mass,), inertia = inertial.all("mass")[0].numbers("value"), inertial.all("inertia")[0]
            moments = principal_moments(inertia)
            radius = math.sqrt(max(moments) / mass) if mass > 0 else 0.0
            # No body of this mass and these moments fills more than a sphere does: radius^2 = 5/6 of their sum by the mass.
            filled = 4 / 3 * math.pi * (5 / 6 * sum(moments) / mass) ** 1.5 if mass > 0 else 0.0
            if link.get("name") in turning and filled and mass / filled > DENSEST:
                least = f"with {mass:.6g} kg and moments of inertia up to {max(moments):.3g} kg m2 its density is at least"
                yield _warning(inertia, f"{least} {mass / filled:.0e} kg/m3", "write moments of inertia in kg m2, and the mass in kg")
            if radius > MOST_GYRATION * size:
                yield _warning(
                    inertia,
                    f"the radius of gyration is {radius:.3g} m, of a linkage of {size:.3g} m",
                    "write moments of inertia in kg m2, and the mass in kg",
                )


def _turning(robot: Element) -> set[str]:
    """Names of the links that a joint may turn: the moments of inertia of the others are without effect, and often anything."""
    joints = {joint.all("child")[0].get("link"): joint for joint in robot.all("joint")}

    def turns(link: str) -> bool:
        while (joint := joints.get(link)) is not None:
            if joint.get("type") in ("revolute", "continuous"):
                return True
            link = joint.all("parent")[0].get("link")
        return False

    return {name for name in (link.get("name") for link in robot.all("link")) if turns(name)}


def limits(robot: Element) -> dict[str, tuple[float, float, Element]]:
    """For every joint that has limits, the lower and upper one [rad or m] and their element."""
    found = {}
    for joint in robot.all("joint"):
        for limit in joint.all("limit") if joint.get("type") in ("revolute", "prismatic") else ():
            (lower,), (upper,) = limit.numbers("lower") or (0.0,), limit.numbers("upper") or (0.0,)
            found[joint.get("name")] = lower, upper, limit
    return found


def _names(robot: Element, *tags: str) -> Iterator[Finding]:
    first: dict[str, Element] = {}
    for element in robot.all(*tags):
        name = element.get("name")
        if name != name.strip():
            yield _warning(element, f"the name {name!r} has spaces around it", f'write name="{name.strip()}" here and where it is used')
        alike = first.setdefault(" ".join(name.split()).casefold(), element)
        if alike is not element:
            said = f"{alike.get('name')!r} on line {alike.line}"
            yield _warning(element, f"the name {name!r} differs from {said} only in case or spaces", "give one of them another name")


def _drawn_limits(robot: Element) -> Iterator[Finding]:
    offset = {joint.get("name") for joint in robot.all("joint") for mimic in joint.all("mimic") if any(mimic.numbers("offset"))}
    for name, (lower, upper, limit) in limits(robot).items():
        if not lower <= 0.0 <= upper and name not in offset:
            problem = f"the drawn pose, 0, is outside the limits {lower:g} to {upper:g}"
            yield _warning(limit, problem, "limits count from the drawn pose: shift them (they do not enter any computation)")


def _massless(robot: Element) -> Iterator[Finding]:
    """Bodies with a mass and no moment of inertia at all."""
    bodies = bodies_of(robot)
    frame = next(iter(bodies), None)
    tensors: dict[str | None, list[Element]] = {}
    for link in robot.all("link"):
        for inertial in link.all("inertial"):
            if any(any(mass.numbers("value")) for mass in inertial.all("mass")):
                tensors.setdefault(bodies.get(link.get("name"), frame), []).extend(inertial.all("inertia"))
    for body, inertias in tensors.items():
        moments = principal_moments(inertias[0]) if len(inertias) == 1 else ()
        if body != frame and moments and not any(moments):
            yield _warning(inertias[0], "all moments of inertia are 0: a point mass, which resists no turning", "write them in kg m2")


def _unread(robot: Element) -> Iterator[Finding]:
    for joint in robot.all("joint"):
        for dynamics in joint.all("dynamics"):
            values = [f"{name}={dynamics.get(name)!r}" for name in ("damping", "friction") if any(dynamics.numbers(name))]
            if values:
                problem = f"inverse dynamics does not read {' and '.join(values)}"
                remedy = f"give it friction={{{joint.get('name')!r}: Friction(...)}}"
                yield Finding("note", str(dynamics), dynamics.line, problem, remedy)


def _warning(element: Element, problem: str, remedy: str) -> Finding:
    return Finding("warning", str(element), element.line, problem, remedy)
