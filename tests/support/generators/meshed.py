"""Planar linkages with machine elements, by the places of their pins in the drawing."""

from support.texts import load

LIMIT = '<limit lower="-9" upper="9" effort="1" velocity="1"/>'


def planar(bodies, elements, drivers, loops=()):
    """A linkage in the x-z plane that is drawn in world axes.

    Args:
        bodies: by the names of their joints (parent body, type, place (x, z), mass, centre of mass (x, z), inertia about y); a joint that
            slides goes along "x" or "z" in place of its type. Links are named by their joints, "O_body".
        elements: text of machine elements.
        drivers: joints that motors move.
        loops: by name (body 1, body 2, place (x, z)).
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
        sides = "".join(f'<link{e} link="{body}" xyz="{point(body, *place)}"/>' for e, body in ends)
        lines.append(f'<loop_joint name="{loop}" type="spherical">{sides}</loop_joint>')
    return load(f'<robot name="meshed">{"".join(lines)}{elements}</robot>', drivers=drivers)
