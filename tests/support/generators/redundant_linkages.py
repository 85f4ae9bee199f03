"""Planar linkages that close more than they must or have gear pairs, so that rigid mechanics leaves forces open."""

import re

import numpy as np
from support import texts
from support.generators.random_linkages import Drawing

PIVOTS = (0j, 1.0 - 0.2j, 0.45 + 0.6j)  # not in a line: the parallelogram has no change point


def three_cranks(offset=0.0, third=True):
    """A coupler on three parallel cranks of 0.3 m, one of them too many, or on two; ``offset`` spreads the pins along the normal."""
    arm = 0.3 * np.exp(0.5j)
    drawing = Drawing("three_cranks")
    drawing.joint("O", "frame", "crank", PIVOTS[0])
    drawing.joint("B", "crank", "coupler", PIVOTS[0] + arm, offset)
    drawing.joint("D", "frame", "second", PIVOTS[1])
    drawing.loop("C", "coupler", "second", PIVOTS[1] + arm, offset)
    drawing.body("crank", 4.0, PIVOTS[0] + 0.4 * arm)
    drawing.body("second", 3.0, PIVOTS[1] + 0.5 * arm)
    if third:
        drawing.joint("G", "frame", "third", PIVOTS[2], -offset)
        drawing.loop("H", "third", "coupler", PIVOTS[2] + arm, offset)
        drawing.body("third", 2.0, PIVOTS[2] + 0.6 * arm * np.exp(0.3j))
    drawing.body("coupler", 9.0, 0.6 + 0.3j + arm, offset)
    return drawing


def mimicking(text, follower, leader, multiplier, offset=0.0):
    """The text with a gear pair."""
    written = f'<mimic joint="{leader}" multiplier="{multiplier!r}" offset="{offset!r}"/></joint>'
    changed = re.sub(rf'(<joint name="{follower}"(?:(?!</joint>).)*)</joint>', lambda found: found[1] + written, text, count=1, flags=re.S)
    assert changed != text
    return changed


def rods(count, kind="spherical"):
    """A crank-slider with rods side by side, at uneven distances, and masses off the plane; its loops may be pins with an axis."""
    drawing = Drawing("rods")
    pin_p, pin_w = 0.15 * np.exp(0.4j), 0.1 - 0.8j
    drawing.joint("O", "frame", "crank", 0j, 0.05)
    drawing.joint("guide", "frame", "slide", pin_w, -0.1, along=1j)
    for k in range(count):
        drawing.joint(f"P{k}", "crank", f"rod{k}", pin_p, 0.3 * k - 0.25, sense=(-1) ** k)
        drawing.loop(f"W{k}", f"rod{k}", "slide", pin_w, 0.31 * k - 0.2)
        drawing.body(f"rod{k}", 3.0 + k, 0.4 * pin_p + 0.6 * pin_w, 0.3 * k - 0.2)
    drawing.body("crank", 5.0, 0.5 * pin_p, 0.02, tensor=np.array([[0.2, 0.01, 0.03], [0.01, 0.2, -0.02], [0.03, -0.02, 0.3]]))
    drawing.body("slide", 20.0, pin_w - 0.1j, 0.1)
    text = drawing.urdf("O")
    if kind == "spherical":
        return text
    # the loop's axis is the normal, world -y, in frames that are not turned
    return re.sub(r'type="spherical">(.*?)</loop_joint>', r'type="revolute">\1<axis xyz="0 -1 0"/></loop_joint>', text)


def wheels(*pairs, linked=True):
    """Shafts "crank", "s1", "s2", "s3" in a row with eccentric masses, a slope with a "rack"; ``pairs`` are arguments of `mimicking`.

    The crank drives a slide at the joint "guide" if it is ``linked``.
    """
    named = {name for pair in pairs for name in pair[:2]}
    drawing = Drawing("train")
    drawing.joint("crank", "frame", "crank", 0j)
    drawing.body("crank", 4.0, 0.05 + 0.1j)
    if linked:
        drawing.joint("B", "crank", "rod", 0.1 + 0.1j)
        drawing.joint("guide", "frame", "slide", 0.2 + 0.7j, along=1j)
        drawing.loop("C", "rod", "slide", 0.2 + 0.7j, 0.1)
        drawing.body("rod", 2.0, 0.15 + 0.4j)
        drawing.body("slide", 6.0, 0.2 + 0.8j)
    for k in range(1, 4):
        if f"s{k}" in named:
            drawing.joint(f"s{k}", "frame", f"wheel{k}", 0.5 * k + 0.1j, 0.1 * k, sense=(-1) ** (k // 2))
            drawing.body(f"wheel{k}", 2.0 + k, 0.5 * k + 0.2j + 0.05, 0.12 * k)
    if "rack" in named:
        drawing.joint("rack", "frame", "bar", -0.5j, along=np.exp(0.3j))
        drawing.body("bar", 7.0, -0.6j, 0.1)
    return geared(drawing, *pairs)


def geared(drawing, *pairs):
    """The text with gear pairs, and the crank driving."""
    text = drawing.urdf("crank")
    for pair in pairs:
        text = mimicking(text, *pair)
    return text


def five_bar(multiplier):
    """Two cranks on the frame, a dyad between their pins, and a gear pair between the cranks."""
    drawing = Drawing("five_bar")
    left, right, top = 0.2 * np.exp(1.2j), 0.7 + 0.2 * np.exp(2.0j), 0.3 + 0.75j
    drawing.joint("crank", "frame", "crank", 0j)
    drawing.joint("second", "frame", "second", 0.7 + 0j, 0.1)
    drawing.joint("L", "crank", "left", left, 0.05)
    drawing.joint("R", "second", "right", right, sense=-1)
    drawing.loop("T", "left", "right", top, 0.02)
    for link, centre in (("crank", left / 2), ("second", (0.7 + right) / 2), ("left", (left + top) / 2), ("right", (right + top) / 2)):
        drawing.body(link, 3.0, centre, 0.03)
    return geared(drawing, ("second", "crank", multiplier))


def flat_point(drawing, link, xyz):
    """A point of a link's frame in the plane of the drawing."""
    rotation, origin = drawing.placed[link]
    x, y, _ = drawing.world.T @ (origin + rotation @ np.asarray(xyz))
    return complex(x, y)


def pins(drawing):
    """link -> (other link, point) of every pin on it."""
    found = [(parent, child, flat_point(drawing, child, np.zeros(3))) for _, kind, parent, child, *_ in drawing.joints if kind in TURNING]
    found += [(link1, link2, flat_point(drawing, link1, xyz)) for _, ((link1, xyz), (link2, _)) in drawing.loops]
    return {link: [(two if link == one else one, at) for one, two, at in found if link in (one, two)] for link in drawing.placed}


TURNING = ("continuous", "revolute")


def double(drawing, rng, count):
    """Put links beside some that have two pins, on the same pins in other planes: they move alike, and share what the first carried."""
    candidates = {link: ends for link, ends in pins(drawing).items() if link != "frame" and len(ends) >= 2}
    for k in range(count):
        link = str(rng.choice(sorted(candidates)))
        (host1, first), (host2, second) = (candidates[link][i] for i in rng.choice(len(candidates[link]), 2, replace=False))
        heights = rng.uniform(-0.5, 0.5, 3)
        name = f"{'abcdefgh'[rng.integers(8)]}beside{k}"
        drawing.joint(f"joint_beside{k}", host1, name, first, heights[0], sense=int(rng.choice([-1, 1])))
        drawing.loop(f"loop_beside{k}", *rng.permutation([name, host2]), second, heights[1])
        drawing.body(name, rng.uniform(1, 5), (first + second) / 2 + 0.1j, heights[2])


LINKAGES = {
    "two_point": lambda: texts.shipped("jf75g_125_two_point"),
    "symmetric": lambda: texts.shipped("jf75g_125_symmetric"),
    "two_rods": lambda: rods(2),
    "three_rods": lambda: rods(3),
    "one_held_rod": lambda: rods(1, "revolute"),
    "three_held_rods": lambda: rods(3, "revolute"),
    "three_cranks": lambda: three_cranks(0.2).urdf("O"),
    "geared_cranks": lambda: mimicking(three_cranks(0.1).urdf("O"), "G", "D", 1.0),
    "gear_pair": lambda: wheels(("s1", "crank", -1.0, 0.0)),
    "chain": lambda: wheels(("s1", "crank", -1.0, 0.01), ("s2", "s1", 2.0, -0.02), ("s3", "crank", -0.5, 0.0)),
    "rack": lambda: wheels(("s1", "guide", 5.0, 0.01), ("rack", "s1", 0.1, 0.002)),
    "rack_leads": lambda: wheels(("rack", "guide", -2.0, 0.0), ("s1", "rack", -3.0, 0.0)),
    "five_bar": lambda: five_bar(-1.0),
    "five_bar_2": lambda: five_bar(2.0),
    "ring": lambda: wheels(("s1", "crank", -1.0), ("s2", "s1", -1.0), ("crank", "s2", 1.0), linked=False),
}
NOT_PLANAR = ("ring",)  # its idle torques reach no bearing by which the planar engine could share them
