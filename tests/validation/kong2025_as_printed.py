"""Kong 2025: equations (10) to (15) solved over a turn as they are printed, and with some of them corrected.

The positions are those of the press, which the paper reproduces. Points of the plane are complex numbers, x + i y.
"""

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pinpress import RPM, Linkage, cycle
from pinpress.common.quantities import Array
from pinpress.measures import bearing_positions

SPEED = 70 * RPM
POINTS = 720
UNKNOWNS = ("M_b", "F01x", "F01y", "F21x", "F21y", "F23x", "F23y", "F03x", "F03y", "F43x", "F43y", "F54x", "F54y", "F05")  # (17)
REACTIONS = {"F12": "F21", "F32": "F23", "F34": "F43", "F45": "F54"}  # forces that are minus an unknown
WRONG = ("(12)", "(13)", "(15)")  # those that the errata correct


class Links(NamedTuple):
    """The links over a turn of n states, in the order crank, coupler, rocker, rod, slide.

    Attributes:
        pins: A to F -> (n,) complex places [m].
        turns: (4, n) directions of the links that turn, AB, BC, DC, EF, as complex numbers of length one.
        centres: (5, n) complex places of the centres of mass [m].
        masses: (5,) [kg].
        inertias: (4,) about the centres of mass [kg m2].
    """

    pins: dict[str, Array]
    turns: Array
    centres: Array
    masses: list[float]
    inertias: list[float]


def links(press: Linkage) -> Links:
    """The press before or after balancing."""
    places = bearing_positions(press, cycle(press, SPEED, points=POINTS))
    pins = {name: places[name][:, 0] + 1j * places[name][:, 2] for name in "ABCDEF"}
    turns = np.array([pins[end] - pins[start] for start, end in ("AB", "BC", "DC", "EF")])
    turns /= np.abs(turns)
    bodies = [press.model.inertias[press.model.getJointId(joint)] for joint in ("A", "B", "D", "E", "slide_guide")]
    levers = [body.lever[0] + 1j * body.lever[2] for body in bodies]
    centres = [pins[pin] + turn * lever for pin, turn, lever in zip("ABDE", turns, levers[:4], strict=True)]
    inertias = [float(body.inertia[1, 1]) for body in bodies[:4]]
    return Links(pins, turns, np.array([*centres, pins["F"]]), [float(body.mass) for body in bodies], inertias)


def slide_acceleration(press: Linkage) -> Array:
    """(n,) acceleration a5 of the slide by (7) and (10) as they are printed [m/s2]."""
    pins = links(press).pins
    ab, bc, dc, de, ef = (pins[end] - pins[start] for start, end in ("AB", "BC", "DC", "DE", "EF"))
    none = 0 * ab.real
    matrix = [
        [bc.imag, -dc.imag, none, none],
        [-bc.real, dc.real, none, none],
        [none, -de.imag, -ef.imag, none],
        [none, de.real, ef.real, none - 1],
    ]
    crank = SPEED * np.array([-ab.imag, ab.real, none, none])
    w2, w3, w4, v5 = _solution(matrix, crank)
    changing = [
        [w2 * bc.real, -w3 * dc.real, none, none],
        [w2 * bc.imag, -w3 * dc.imag, none, none],
        [none, w3 * de.real, -w4 * ef.real, none],
        [none, w3 * de.imag, -w4 * ef.imag, none],
    ]
    return np.asarray(_solution(matrix, crank - np.einsum("ijn,jn->in", np.array(changing), np.array([w2, w3, w4, v5])))[3])


def forces(press: Linkage, corrected: Collection[str] = ()) -> dict[str, Array]:
    """(n,) each of the unknowns (17) [N m, N] by (11) to (15) as they are printed, but for those of `WRONG` that are corrected."""
    pins, turns, centres, masses, inertias = links(press)
    angles = np.unwrap(np.angle(turns))
    (s1, s2, s3, s4, _), (m1, m2, m3, m4, m5) = centres, masses
    a1, a2, a3, a4, a5 = (_second_derivative(centre) for centre in centres)
    j2, j3, j4 = (j * _second_derivative(angle).real for j, angle in zip(inertias[1:], angles[1:], strict=True))
    g1, g2, g3, g4, g5 = (9.81 * mass for mass in masses)
    signs = {name: -1.0 if name in corrected else 1.0 for name in WRONG}
    s12, s13 = signs["(12)"], signs["(13)"]
    a, b, c, d, e, f = pins.values()
    slide: list[tuple[dict[str, Array | float], Array | float]] = (
        [({"F45x": 1, "F05": -1}, m5 * a5.imag), ({"F45y": 1}, g5)]
        if "(15)" not in corrected
        else [({"F45x": 1, "F05": -1}, 0.0), ({"F45y": 1}, m5 * a5.imag + g5)]
    )
    equations: list[tuple[dict[str, Array | float], Array | float]] = [
        ({"F01x": 1, "F21x": 1}, m1 * a1.real),
        ({"F01y": 1, "F21y": 1}, m1 * a1.imag + g1),
        ({"M_b": -1, "F01x": (s1 - a).imag, "F21y": (b - s1).real, "F01y": -(s1 - a).real, "F21x": -(b - s1).imag}, 0.0),
        ({"F32x": 1, "F12x": 1}, m2 * a2.real),
        ({"F32y": 1, "F12y": 1}, m2 * a2.imag + g2),
        ({"F32y": s12 * (s2 - c).real, "F12y": (b - s2).real, "F32x": -(c - s2).imag, "F12x": -s12 * (s2 - b).imag}, j2),
        ({"F23x": 1, "F43x": 1, "F03x": 1}, m3 * a3.real),
        ({"F23y": 1, "F43y": 1, "F03y": 1}, m3 * a3.imag + g3),
        (
            {"F23y": (c - s3).real, "F43y": (e - s3).real, "F03y": s13 * (s3 - d).real}
            | {"F23x": -(c - s3).imag, "F43x": -s13 * (s3 - e).imag, "F03x": -(d - s3).imag},
            j3,
        ),
        ({"F34x": 1, "F54x": 1}, m4 * a4.real),
        ({"F34y": 1, "F54y": 1}, m4 * a4.imag + g4),
        ({"F34y": (e - s4).real, "F54x": (s4 - f).imag, "F34x": -(e - s4).imag, "F54y": -(s4 - f).real}, j4),
        *slide,
    ]
    matrix, right = np.zeros((len(UNKNOWNS), len(UNKNOWNS), POINTS)), np.zeros((len(UNKNOWNS), POINTS))
    for k, (terms, value) in enumerate(equations):
        right[k] = value
        for name, factor in terms.items():
            unknown, sign = (REACTIONS[name[:3]] + name[3:], -1) if name[:3] in REACTIONS else (name, 1)
            matrix[k, UNKNOWNS.index(unknown)] += sign * factor
    return dict(zip(UNKNOWNS, _solution(matrix, right), strict=True))


def _solution(matrix: ArrayLike, right: Array) -> Array:
    """(k, n) of the equations (k, k, n) with right sides (k, n)."""
    return np.asarray(np.linalg.solve(np.moveaxis(np.asarray(matrix), -1, 0), right.T[..., None])[..., 0].T)


def _second_derivative(curve: Array) -> Array:
    """By time, of a curve (n,) over the whole turn, by its Fourier series."""
    order = np.fft.fftfreq(len(curve), 1 / len(curve))
    return np.asarray(-(SPEED**2) * np.fft.ifft(order**2 * np.fft.fft(curve)))
