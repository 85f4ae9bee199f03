"""Matrices of a straight beam, for a link without a finite-element model."""

from __future__ import annotations

import numpy as np

from ..common import plausibility
from ..common.arguments import positive, typed, whole_number
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..linkage.linkage import Linkage
from ..simulation.elastic.flexible_link import FlexibleLink
from ..simulation.elastic.press.assembly import pins_of, rigid_inertia
from ..simulation.elastic.press.plane import DrawnBodies

STEEL = 2.1e11  # modulus of elasticity [Pa]


@typed
def flexible_beam(
    press: Linkage,
    link: str,
    between: tuple[str, str],
    *,
    area: float,
    second_moment: float,
    modulus: float = STEEL,
    elements: int = 8,
    modes: int = 4,
    damping_ratio: float = 0.01,
) -> FlexibleLink:
    """Make the matrices of a straight beam (Euler and Bernoulli) between the two bearings of a link.

    The mass per length is a parabola along the beam, so that mass, centre of mass and moment of inertia equal those of the link; for a link
    of uniform section it is constant. Shear deformation is neglected: the beam should be at least ten times as long as high.

    Args:
        press: the linkage, which gives length and mass of the link.
        link: name of the link.
        between: names of its two bearings.
        area: area of the section [m2].
        second_moment: second moment of area of the section, about the axis across the plane [m4].
        modulus: modulus of elasticity [Pa].
        elements: number of finite elements, from 3 to 100.
        modes: number of normal modes with fixed bearings that are kept.
        damping_ratio: damping ratio of each vibration of the free link [-].

    Raises:
        UnknownNameError: the linkage has no such link or bearing.
        PinpressError: the link is not a straight beam between two bearings, or a number is out of range.
    """
    count, drawn = whole_number("elements", elements, 3, 100), DrawnBodies(press)
    axial = positive("modulus", modulus, "Pa") * positive("area", area, "m2")
    bending = float(modulus) * positive("second_moment", second_moment, "m4")
    body, pins = pins_of(drawn, link)
    if not isinstance(between, tuple | list) or sorted(map(str, between)) != sorted(pins) or len(pins) != 2:
        raise PinpressError(
            f"beam {shown(link)}: between is {shown(between)}, and its bearings are {', '.join(pins)}: a beam has two, name both; for other"
            " links give matrices"
        )
    first, last = (pins[name] for name in between)
    mass, centre, inertia = rigid_inertia(drawn, body)
    length, along = abs(last - first), (last - first) / abs(last - first)
    place = (centre - first) * along.conjugate()
    if abs(place.imag) > 1e-3 * length:
        raise PinpressError(f"beam {shown(link)}: its centre of mass lies {1e3 * place.imag:.3g} mm beside its line: give matrices for it")
    plausibility.modulus(float(modulus))
    plausibility.section(f"beam {shown(link)}", float(area), float(second_moment), length)
    h = length / count
    spread = _spread_mass(link, mass, place.real, inertia, length, count)
    matrices = np.zeros((2, 3 * count + 3, 3 * count + 3))
    for k, share in enumerate(spread):
        matrices[:, 3 * k : 3 * k + 6, 3 * k : 3 * k + 6] += share * _beam_mass(h), _beam_stiffness(axial, bending, h)
    nodes = np.stack([h * np.arange(count + 1), np.zeros(count + 1)], axis=1)
    degrees = np.stack([np.repeat(np.arange(count + 1), 3), np.tile(np.arange(3), count + 1)], axis=1)
    ends = {between[0]: 0, between[1]: count}
    return FlexibleLink(link, ends, matrices[0], matrices[1], nodes, degrees, modes, damping_ratio)


def _spread_mass(link: str, mass: float, centre: float, inertia: float, length: float, count: int) -> Array:
    """Masses (count,) of the elements of a beam, on a parabola, with a given total mass, centre of mass (from the start) and moment of
    inertia about it."""
    h, middle = length / count, (np.arange(count) + 0.5) / count
    powers = np.stack([np.ones(count), middle, middle**2])
    moments = np.stack([np.ones(count), middle * length, (middle * length) ** 2 + h**2 / 12])
    masses = np.linalg.solve(moments @ powers.T, [mass, mass * centre, inertia + mass * centre**2]) @ powers
    if not (masses > 0).all():
        raise PinpressError(
            f"beam {shown(link)}: its mass of {mass:.4g} kg, centre of mass at {centre / length:.3g} of its length and moment of inertia of"
            f" {inertia / (mass * length**2):.3g} m l2 are not those of a beam, e.g. 0.083 m l2 for a uniform beam; give matrices for it"
        )
    return np.asarray(masses)


def _beam_stiffness(axial: float, bending: float, h: float) -> Array:
    matrix = np.zeros((6, 6))
    matrix[np.ix_([0, 3], [0, 3])] = axial / h * np.array([[1, -1], [-1, 1]])
    rows = [
        [12, 6 * h, -12, 6 * h],
        [6 * h, 4 * h * h, -6 * h, 2 * h * h],
        [-12, -6 * h, 12, -6 * h],
        [6 * h, 2 * h * h, -6 * h, 4 * h * h],
    ]
    matrix[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = bending / h**3 * np.array(rows)
    return matrix


def _beam_mass(h: float) -> Array:
    """(6, 6) consistent mass matrix of an element of mass 1."""
    matrix = np.zeros((6, 6))
    matrix[np.ix_([0, 3], [0, 3])] = np.array([[2, 1], [1, 2]]) / 6
    rows = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h]]
    rows += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
    matrix[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = np.array(rows) / 420
    return matrix
