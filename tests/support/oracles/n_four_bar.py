"""The assembly of N four-bar linkages, IFToMM benchmark A02 (Universidade da Coruna; Bayo and Avello 1994; N = 2 in IFToMM's library, 40
in its specification): N + 1 upright rods on pivots 1 m apart, N rods that join their tips, all slender, 1 m and 1 kg. It starts upright
with its tips at 1 m/s and passes through poses with all rods in one line, where its loops lose their rank.

On the parallelogram branch it has one degree of freedom with the exact equation phi'' = V g / I sin(phi), phi from upright,
I = (N + 1) / 3 + N [kg m2], V = (N + 1) / 2 + N [kg m].
"""

GRAVITY = 9.81
SPEED = 1.0  # of the tips at the start [m/s]

# phi [rad] and its rate [rad/s] after so many seconds, from the exact equation, integrated in extended precision: all digits are right.
EXACT = {
    1: {
        1: (3.405352987937, 6.875591948593),
        2: (6.360347326331, 1.034434845796),
        5: (16.945277268216, 5.678977607487),
        10: (31.914741297737, 1.966934719437),
    },
    2: {
        1: (3.337870803105, 6.807385240869),
        2: (6.341033361312, 1.018964591438),
        5: (16.654353486654, 6.105067553520),
        10: (31.750597186985, 1.506642180840),
    },
}

# Of N = 2, times at which all rods lie in one line [s].
IN_LINE = (0.714355529293, 1.228159393314, 2.656870451900, 3.170674315921, 4.599385374507, 5.113189238528, 6.541900297114, 7.055704161136)

# Position and velocity of the first tip after 10 s, N = 2, from the comments of Exudyn's test model (generalised-alpha), extrapolated from
# its steps of 0.25 and 0.125 ms by their order 2: x [m].
EXTRAPOLATED = 0.3284573768 + (0.3284573768 - 0.3284552113) / 3

ROD = """<inertial><origin xyz="{centre}"/><mass value="1"/>
    <inertia ixx="{x!r}" ixy="0" ixz="0" iyy="{y!r}" iyz="0" izz="{z!r}"/></inertial>"""


def urdf(count):
    """The assembly of ``count`` windows in the x-z plane, drawn upright; positive angles turn z towards x. Joints A0, A1, ... on the frame,
    B0, B1, ... at the tips, loops C1, C2, ... at the others' tips."""
    inertia = 1 / 12
    upright, lying = (
        ROD.format(centre="0 0 0.5", x=inertia, y=inertia, z=0.0),
        ROD.format(centre="0.5 0 0", x=0.0, y=inertia, z=inertia),
    )
    parts = [f'<robot name="four_bars_{count}">', '<link name="frame"/>']
    for k in range(count + 1):
        parts.append(f'<link name="rod_{k}">{upright}</link>')
        parts.append(_joint(f"A{k}", "frame", f"rod_{k}", f"{k} 0 0"))
    for k in range(count):
        parts.append(f'<link name="top_{k}">{lying}</link>')
        parts.append(_joint(f"B{k}", f"rod_{k}", f"top_{k}", "0 0 1"))
        ends = f'<link1 link="top_{k}" xyz="1 0 0"/><link2 link="rod_{k + 1}" xyz="0 0 1"/>'
        parts.append(f'<loop_joint name="C{k + 1}" type="spherical">{ends}</loop_joint>')
    return "\n".join([*parts, '<transmission name="drive"><joint name="A0"/></transmission>', "</robot>"])


def _joint(name, parent, child, place):
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{place}"/>'
    return f'<joint name="{name}" type="continuous">{ends}<axis xyz="0 1 0"/></joint>'


def inertia(count):
    return (count + 1) / 3 + count


def moment(count):
    return (count + 1) / 2 + count
