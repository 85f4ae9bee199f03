"""Gears that mesh, put into linkages by hand: the equation of a pair, and the contact between its teeth."""

from dataclasses import replace

import numpy as np
from support.texts import load

from pinpress.engines.constraints import Relation
from pinpress.engines.contacts import Contact, Planets, Rubbing, UnitWrench
from pinpress.engines.structure import drawn_placements, joints_between

MINUS_Y = np.array([0.0, -1.0, 0.0])


def planar(bodies, loops=(), drivers=(), name="meshed"):
    """A linkage in the x-z plane that is drawn in world axes.

    Args:
        bodies: by the names of their joints (parent body, type, place (x, z), mass, centre of mass (x, z), inertia about y); a joint that
            slides goes along "x" or "z" in place of its type.
        loops: by name (body 1, body 2, place (x, z)).
        drivers: joints whose coordinates determine all others, without gears.
    """
    places, lines = {"frame": (0.0, 0.0)}, ['<link name="frame"/>']

    def point(body, x, z):
        return f"{x - places[body][0]!r} 0 {z - places[body][1]!r}"

    for joint, (parent, kind, place, mass, center, inertia) in bodies.items():
        places[f"{joint}_body"] = place
        on = parent if parent == "frame" else f"{parent}_body"
        axis, limit = {"turns": ("0 -1 0", ""), "x": ("1 0 0", LIMIT), "z": ("0 0 1", LIMIT)}[kind]
        lines += [
            f'<link name="{joint}_body"><inertial><origin xyz="{point(f"{joint}_body", *center)}"/><mass value="{mass}"/>'
            f'<inertia ixx="{inertia}" ixy="0" ixz="0" iyy="{inertia}" iyz="0" izz="{inertia}"/></inertial></link>',
            f'<joint name="{joint}" type="{"prismatic" if limit else "continuous"}"><parent link="{on}"/><child link="{joint}_body"/>'
            f'<origin xyz="{point(on, *place)}"/><axis xyz="{axis}"/>{limit}</joint>',
        ]
    for loop, (body1, body2, place) in loops.items() if loops else ():
        ends = [(e, body if body == "frame" else f"{body}_body") for e, body in ((1, body1), (2, body2))]
        ends = "".join(f'<link{e} link="{body}" xyz="{point(body, *place)}"/>' for e, body in ends)
        lines.append(f'<loop_joint name="{loop}" type="spherical">{ends}</loop_joint>')
    return load(f'<robot name="{name}">{"".join(lines)}</robot>', drivers=tuple(drivers))


LIMIT = '<limit lower="-9" upper="9" effort="1" velocity="1"/>'


def meshing(press, name, gears, teeth, carrier, centers, drivers, pressure_angle=20.0, efficiency=1.0, planets=None):
    """The linkage with a pair of spur gears.

    Args:
        press: the linkage.
        name: of the pair.
        gears: Pinocchio joints of the two gears.
        teeth: of both; negative of an internal gear.
        carrier: Pinocchio joint of the body that carries both.
        centers: (2, 3) centres of both in the carrier's joint frame.
        drivers: joints whose coordinates determine all others with the gears.
        pressure_angle: [deg].
        efficiency: of the pair.
        planets: how many planets it stands for, and the joint of the one that is drawn.
    """
    (first, second), (z1, z2), (c1, c2) = gears, teeth, np.array(centers, dtype=float)
    places = drawn_placements(press.model)
    parents = [parent - 1 for parent in list(press.model.parents)[1:]]
    row = {}
    for gear, z in ((first, z1), (second, z2)):
        for joint, sign in joints_between(parents, carrier - 1, gear - 1).items():
            if press.axes[joint].turns:
                own = places[joint + 1].rotation @ press.axes[joint].direction
                row[joint] = row.get(joint, 0.0) + z * sign * float(np.sign(own @ MINUS_Y))
    row = {joint: value for joint, value in row.items() if value}
    by = next(iter(row.values()))
    relation = Relation(name, {joint: value / by for joint, value in row.items()})
    axis = places[carrier].rotation.T @ MINUS_Y
    distance = np.linalg.norm(c2 - c1)
    u = (c2 - c1) / distance
    r1 = distance * z1 / (z1 + z2)
    on_second = -(z1 + z2) / (by * distance)  # tangential, by the effort of the relation
    outwards = np.sign(r1) if z1 > 0 else np.sign(r1 - distance)  # from the first gear to the second, along u
    unit = UnitWrench(
        point=c1 + r1 * u,
        force=on_second * np.cross(axis, u),
        couple=np.zeros(3),
        push=abs(on_second) * np.tan(np.radians(pressure_angle)) * outwards * u,
    )
    arm = (1 - efficiency) * abs(on_second * r1 * z2 / (z1 + z2))
    rubbing = (Rubbing(first, second, np.zeros(3), axis, arm, arm),) if arm else ()
    of = None
    if planets is not None:
        count, planet = planets
        of = Planets(count, planet, *((c1, c2) if planet == first else (c2, c1)), axis)
    contact = Contact(name, "gears", len(press.relations), first, second, carrier, unit, rubbing, of)
    return replace(press, relations=(*press.relations, relation), contacts=(*press.contacts, contact), drivers=tuple(drivers))
