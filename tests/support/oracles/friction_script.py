"""Two presses with friction, written out by hand in the plane: the tests' independent oracle, which shares no code with pinpress.

Points, forces and accelerations are complex, x + i z; an arm r and a force f make the moment Im(conj(r) f), counter-clockwise. Every loop
closes by the intersection of two circles or of a circle and a line. Then all Newton-Euler equations stand together: unknown are the driving
torque, two components of every pin's force and the guide's force across its line. Friction in a pin makes the moment
-(c w + mu r |F| sign w) on the child, in the guide the force -(c v + mu |N| sign v) on the slide, and the equations, which are not linear
then, are solved by Newton's method with halved steps, from the solution without Coulomb friction.

Sources: lengths and masses as in urdf/crank_slide.urdf (round numbers) and urdf/zxn2_3000b.urdf (Kong 2025; inferred moments of inertia).
"""

from dataclasses import dataclass, field

import numpy as np

G = 9.81  # [m/s2]


@dataclass
class Point:
    """A point over the motion, (n,) each: where it is, its velocity and its acceleration."""

    at: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    def __add__(self, other):
        return Point(self.at + other.at, self.velocity + other.velocity, self.acceleration + other.acceleration)


@dataclass
class Body:
    """A body: its turning rate and acceleration (n,), centre of mass, mass [kg] and moment of inertia about it [kg m2]."""

    name: str
    spin: np.ndarray
    turning: np.ndarray
    centre: Point
    mass: float
    inertia: float


@dataclass
class Pin:
    """A pin, whose force acts on ``child`` and back on ``parent``; None is the frame."""

    name: str
    parent: str | None
    child: str
    at: np.ndarray


@dataclass
class Press:
    """A press in motion: the first pin drives, and the last body, the slide, runs along z without turning."""

    bodies: list[Body]
    pins: list[Pin]
    slide: Body = field(init=False)

    def __post_init__(self):
        self.slide = self.bodies[-1]


def arm(vector, spin, turning):
    """An arm (n,) that turns, as a difference of points."""
    return Point(vector, 1j * spin * vector, (1j * turning - spin**2) * vector)


def fixed(at):
    return Point(at, 0j, 0j)


def intersection(from_point, radius1, to_point, radius2, side):
    """Where circles about two points meet, to the left (side 1) of the line between them, or to the right (-1)."""
    between = to_point - from_point
    distance = np.abs(between)
    along = (distance**2 + radius1**2 - radius2**2) / (2 * distance)
    return from_point + between / distance * (along + 1j * side * np.sqrt(radius1**2 - along**2))


def turned_by(one, other, velocity):
    """Rates x, y with i x one - i y other = velocity."""
    across = (one.conj() * other).imag
    return (velocity.conj() * other).real / across, (velocity.conj() * one).real / across


def crank_slide(angle, speed, acceleration):
    """Crank 0.1 m, straight down at angle 0, rod 0.4 m, slide below."""
    crank = arm(0.1 * np.exp(1j * (angle - np.pi / 2)), speed, acceleration)
    rod = -crank.at.real - 1j * np.sqrt(0.4**2 - crank.at.real**2)
    spin = crank.velocity.real / rod.imag  # no slide velocity along x: Re(v + i w rod) = 0
    turning = (crank.acceleration.real - spin**2 * rod.real) / rod.imag
    rod = arm(rod, spin, turning)
    slide = crank + rod
    bodies = [
        Body("crank", speed, acceleration, arm(0.3 * crank.at, speed, acceleration), 20.0, 0.10),
        Body("rod", spin, turning, crank + arm(rod.at / 2, spin, turning), 15.0, 0.20),
        Body("slide", 0 * spin, 0 * spin, slide, 100.0, 0.80),
    ]
    return Press(bodies, [Pin("O", None, "crank", 0 * slide.at), Pin("P", "crank", "rod", crank.at), Pin("W", "rod", "slide", slide.at)])


def zxn2_3000b(angle, speed, acceleration):
    """The six-bar: crank AB, coupler BC, rocker DC with E, rod EF, slide on x = 0 below the rocker's pivot D, the origin."""
    crank = arm(0.143 * np.exp(1j * angle), speed, acceleration)
    shaft = fixed(1.250 - 0.200j)
    b = shaft + crank
    c = intersection(0 * angle, 0.375, b.at, 1.243, 1)
    coupler_spin, rocker_spin = turned_by(c - b.at, c, -b.velocity)
    drift = -b.acceleration + coupler_spin**2 * (c - b.at) - rocker_spin**2 * c
    coupler_turning, rocker_turning = turned_by(c - b.at, c, drift)
    e = arm(0.480 / 0.375 * c * np.exp(-0.75j * np.pi), rocker_spin, rocker_turning)
    rod = -e.at.real - 1j * np.sqrt(0.480**2 - e.at.real**2)
    rod_spin = e.velocity.real / rod.imag
    rod_turning = (e.acceleration.real - rod_spin**2 * rod.real) / rod.imag
    slide = e + arm(rod, rod_spin, rod_turning)
    rocker_centre = arm((-0.0086 - 0.0038j) / 0.375 * c, rocker_spin, rocker_turning)
    bodies = [
        Body("crank", speed, acceleration, shaft + arm(0.0567 / 0.143 * crank.at, speed, acceleration), 1009.16, 31.5),
        Body("coupler", coupler_spin, coupler_turning, b + arm(0.8456 / 1.243 * (c - b.at), coupler_spin, coupler_turning), 290.57, 37.4),
        Body("rocker", rocker_spin, rocker_turning, rocker_centre, 2871.07, 183.0),
        Body("rod", rod_spin, rod_turning, e + arm(rod / 2, rod_spin, rod_turning), 277.68, 5.33),
        Body("slide", 0 * rod_spin, 0 * rod_spin, slide, 7073.87, 767.8),
    ]
    pins = [
        Pin("A", None, "crank", np.full(angle.shape, 1.250 - 0.200j)),
        Pin("B", "crank", "coupler", b.at),
        Pin("C", "coupler", "rocker", c),
        Pin("D", None, "rocker", 0 * c),
        Pin("E", "rocker", "rod", e.at),
        Pin("F", "rod", "slide", slide.at),
    ]
    return Press(bodies, pins)


def solve(press, lift, coulomb, viscous, preload=0.0):
    """Driving torque (n,), and forces (n,) by pin and of "slide_guide" across its line: {"torque": ..., "O": ..., ...}.

    Args:
        lift: force (n,) upwards on the slide, at its pin [N].
        coulomb: mu r of the pins by name [m], mu of "slide_guide" [-]. viscous: c [N m s, N s/m]. All are named.
        preload: of the guide, whose friction is mu max(preload, |N|) [N].
    """
    bodies, pins, n = press.bodies, press.pins, len(press.slide.spin)
    index = {body.name: 3 * k for k, body in enumerate(bodies)}
    spins = {body.name: body.spin for body in bodies} | {None: 0.0}
    count = 3 * len(bodies)
    guide = 1 + 2 * len(pins)  # unknowns: torque, pins, force of the guide along x, moment of the guide on the slide
    assert count == guide + 2
    matrix, needed = np.zeros((n, count, count)), np.zeros((n, count))
    for body in bodies:
        row, force = index[body.name], body.mass * (body.centre.acceleration + 1j * G)
        needed[:, row], needed[:, row + 1], needed[:, row + 2] = force.real, force.imag, body.inertia * body.turning
    slide = index["slide"]
    speeds, frictions = [], []  # per friction: its speed, and ((row, sign), ...) where it acts along it
    for k, pin in enumerate(pins):
        column, sides = 1 + 2 * k, []
        for name, sign in ((pin.child, 1.0), (pin.parent, -1.0)):
            if name is not None:
                row, centre = index[name], next(body.centre.at for body in bodies if body.name == name)
                matrix[:, row, column] = matrix[:, row + 1, column + 1] = sign
                matrix[:, row + 2, column], matrix[:, row + 2, column + 1] = -sign * (pin.at - centre).imag, sign * (pin.at - centre).real
                sides.append((row + 2, sign))
        speeds.append(spins[pin.child] - spins[pin.parent])
        frictions.append((slice(column, column + 2), sides))
    matrix[:, index[pins[0].child] + 2, 0] = 1.0
    matrix[:, slide, guide] = 1.0
    matrix[:, slide + 2, guide + 1] = 1.0
    speeds.append(press.slide.centre.velocity.imag)
    frictions.append((slice(guide, guide + 1), [(slide + 1, 1.0)]))
    names = [pin.name for pin in pins] + ["slide_guide"]

    needed[:, slide + 1] -= lift
    for name, speed, (_, sides) in zip(names, speeds, frictions, strict=True):
        for row, sign in sides:
            needed[:, row] += sign * viscous[name] * speed

    def residual(x):
        """Of the equations, and its derivative."""
        left, slope = (matrix @ x[..., None])[..., 0] - needed, matrix.copy()
        for name, speed, (columns, sides) in zip(names, speeds, frictions, strict=True):
            force = x[:, columns]
            size, least = np.linalg.norm(force, axis=1), preload if name == "slide_guide" else 0.0
            against = -coulomb[name] * np.sign(speed)
            for row, sign in sides:
                left[:, row] += sign * against * np.maximum(size, least)
                slope[:, row, columns] += sign * ((size > least) * against / np.where(size > 0, size, 1.0))[:, None] * force
        return left, slope

    x = np.linalg.solve(matrix, needed[..., None])[..., 0]
    left, slope = residual(x)
    for _ in range(60):
        step, share = np.linalg.solve(slope, left[..., None])[..., 0], np.ones(n)
        for _ in range(30):
            trial = x - share[:, None] * step
            worse = np.abs(residual(trial)[0]).max(axis=1) > np.maximum(np.abs(left).max(axis=1), 1e-12 * np.abs(needed).max())
            if not worse.any():
                break
            share[worse] /= 2
        moved, x = np.abs(trial - x).max(), trial
        left, slope = residual(x)
        if moved <= 1e-13 * np.abs(x).max():
            break
    else:
        raise ArithmeticError(f"friction not found: the last step is {moved:.3g} N")
    found = {name: x[:, 1 + 2 * k] + 1j * x[:, 2 + 2 * k] for k, name in enumerate(names[:-1])}
    return found | {"torque": x[:, 0], "slide_guide": x[:, guide]}
