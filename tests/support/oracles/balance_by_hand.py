"""Balancing the ZXN2-3000(B) written out by hand: a peer of `pinpress.balancing.balance` that shares no code with it.

Kinematics are Kong et al. 2025's in closed form, accelerations the second derivative of the Fourier series of the positions, the shaking
force is sum m (g - a), and the best counterweights are bracketed by two linear programs: circles as polygons around and inside them.
Plane vectors are complex numbers, x + i z; every link's own x axis is along AB, BC, DC, EF or that of the world (slide).
"""

import numpy as np
from scipy.optimize import linprog

L1, L2, L31, L32, L4 = 0.143, 1.243, 0.375, 0.480, 0.480
PIVOT_A, CORNER = 1.250 - 0.200j, 0.75 * np.pi
SPEED, GRAVITY = 70 * 2 * np.pi / 60, 9.81
BODIES = (  # link, mass, centre of mass
    ("crank", 1009.16, 0.0567),
    ("coupler", 290.57, 0.8456),
    ("rocker", 2871.07, -0.0086 - 0.0038j),
    ("rod", 277.68, 0.24),
    ("slide", 7073.87, 0.0),
)
PAPER = (("crank", 605.496, -0.1428), ("rod", 55.536, -0.0456))  # its counterweights
INFINITE = (np.inf, np.inf)
SHARP = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}  # the least that HiGHS takes; of ranges before


def links(states):
    """Origin and direction (n,) of every link's own frame, at even crank angles over one turn."""
    crank = np.exp(2j * np.pi * np.arange(states) / states)
    b, zero = PIVOT_A + L1 * crank, np.zeros(states)
    theta3 = np.angle(b) + np.arccos((L31**2 + abs(b) ** 2 - L2**2) / (2 * L31 * abs(b)))
    c, e = L31 * np.exp(1j * theta3), L32 * np.exp(1j * (theta3 - CORNER))
    f = 1j * (e.imag - np.sqrt(L4**2 - e.real**2))
    return {
        "crank": (zero + PIVOT_A, crank),
        "coupler": (b, (c - b) / L2),
        "rocker": (zero, c / L31),
        "rod": (e, (f - e) / L4),
        "slide": (f, zero + 1),
    }


def force(frames, link, place):
    """(n,) of 1 kg at a place in a link's own frame, at constant crank speed."""
    origin, direction = frames[link]
    order = np.fft.fftfreq(len(origin), 1 / len(origin))
    acceleration = -(SPEED**2) * np.fft.ifft(order**2 * np.fft.fft(origin + direction * place))
    return -1j * GRAVITY - acceleration


def shaking_force(weights=(), states=360):
    """(n,) of the press with point masses (link, mass, place) more."""
    frames = links(states)
    return sum(mass * force(frames, link, place) for link, mass, place in (*BODIES, *weights))


def ranges(total):
    """Horizontal and vertical."""
    return np.array([np.ptp(total.real), np.ptp(total.imag)])


def bracket(regions, weights, most=np.inf, limits=INFINITE, sides=48):
    """What the least ``weights @ ranges`` lies between, with counterweights in circles ``regions`` (link -> radius) about the links' own
    origins, of at most ``most`` kg, and each range within its limit."""
    return tuple(_least(regions, np.array(weights), most, limits, sides, out) for out in (1 / np.cos(np.pi / sides), 1.0))


def _least(regions, weights, most, limits, sides, out):
    """Variables: masses in the corners of polygons, since their centre can be anywhere inside and the force depends on that alone; then the
    largest and smallest horizontal and vertical force, in units of the range before."""
    frames, fixed = links(360), shaking_force()
    corners = out * np.exp(2j * np.pi * np.arange(sides) / sides)
    effects = np.array([force(frames, link, radius * corner) for link, radius in regions.items() for corner in corners]).T
    count, unit = effects.shape[1], ranges(fixed)
    rows, bounds = [], []
    for axis, (part, constant) in enumerate(((effects.real, fixed.real), (effects.imag, fixed.imag))):
        for side in (1, -1):
            extremes = np.zeros((len(part), 4))
            extremes[:, 2 * axis + (side < 0)] = -side
            rows.append(np.hstack([side * part / unit[axis], extremes]))
            bounds.append(-side * constant / unit[axis])
        span = np.zeros(count + 4)
        span[count + 2 * axis : count + 2 * axis + 2] = 1.0, -1.0
        rows.append(span[None])
        bounds.append([min(limits[axis] / unit[axis], 10.0)])
    rows.append(np.concatenate([np.ones(count), np.zeros(4)])[None])
    bounds.append([min(most, 1e6)])
    cost = np.concatenate([np.zeros(count), np.outer(weights * unit, (1, -1)).ravel()])
    signs = [(0, None)] * count + [(None, None)] * 4
    found = linprog(cost, np.concatenate(rows), np.concatenate(bounds), bounds=signs, options=SHARP)
    assert found.status == 0, found.message
    return found.fun
