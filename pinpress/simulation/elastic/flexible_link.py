"""Links that bend and stretch: finite elements in the plane, reduced by the method of Craig and Bampton.

A model of finite elements is a mass and a stiffness matrix. Of its motions those are kept that the bearings can cause: what it does where
one bearing after another is moved slowly, and its lowest vibrations with all bearings held (Craig and Bampton, AIAA Journal 6 (1968) 1313).
The vibrations of the free link in these motions, except for the three in which it moves as a whole, are its shapes Psi. Points of the link
are then at

    r + exp(i phi) (s + Psi q)

in the plane, with the centre of mass at r, the turn phi, the place s in the undeformed link, and small coordinates q of the shapes. As
the shapes of a free link move neither its centre of mass nor turn it on the whole, its kinetic energy is

    m |r'|^2 / 2 + (J + 2 c.q + m q.q) phi'^2 / 2 + phi' q.G q' + m q'.q' / 2

with shapes that have the link's mass each, c = int s.Psi dm and G = int Psi x Psi dm. So all inertia forces of the turning frame are there:
centrifugal ones stretch the link, those of Coriolis bend it. Stiffness by tension, as in a rotor's blade, is not.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common import files
from ...common.arguments import number, numbers, whole_number
from ...common.errors import PinpressError, caution, shown
from ...common.frozen import Frozen
from ...common.numerics import undamped_modes
from ...common.quantities import Array, ComplexArray
from ...common.reading.matrices import craig_bampton, read_model, refuse_negative_mass, symmetric_matrix

TURN = 2  # direction of a degree of freedom that turns


@dataclass(frozen=True, eq=False)
class FlexibleLink(Frozen):
    """A link that bends and stretches, as the matrices of a finite-element model in the plane, free in space.

    Axes of the model are any two of the plane; the places of its bearings say how it lies. Mass, centre of mass and moment of inertia must
    be those of the linkage.

    Attributes:
        link: name of the link; its bearings are pins, and it is not the crank.
        bearings: names of all its bearings -> number of the node at which each is.
        mass: (n, n) mass matrix [kg, kg m, kg m2].
        stiffness: (n, n) stiffness matrix [N/m, N, N m].
        nodes: (k, 2) places of the nodes [m].
        degrees: (n, 2) of each row of the matrices: the number of its node, and 0 or 1 for its displacement along the first or second axis,
            2 for its turn from the first axis to the second; -1, -1 for a coordinate of a model that is reduced already.
        modes: number of vibrations with its bearings held that are kept.
        damping_ratio: of each vibration of the free link, from 0 to 2 [-].
    """

    link: str
    bearings: Mapping[str, int]
    mass: Array
    stiffness: Array
    nodes: Array
    degrees: NDArray[np.intp]
    modes: int = 4
    damping_ratio: float = 0.01

    def __post_init__(self) -> None:
        what, values = f"FlexibleLink of {shown(self.link)}", vars(self)
        for name in ("mass", "stiffness"):  # of more rows programs that keep matrices sparse reduce them in seconds
            values[name] = symmetric_matrix(f"{what}: {name}", values[name], 2000)
        refuse_negative_mass(f"{what}: mass", self.mass)
        count = len(self.mass)
        if self.stiffness.shape != self.mass.shape:
            raise PinpressError(f"{what}: stiffness has shape {self.stiffness.shape}, mass {self.mass.shape}: give both for the same rows")
        values["nodes"] = numbers(f"{what}: nodes", self.nodes, (None, 2), unit="m")
        degrees = numbers(f"{what}: degrees", self.degrees, (count, 2))
        node, direction = degrees.T
        apart = (degrees != np.round(degrees)).any() or len(np.unique(degrees[node >= 0], axis=0)) < np.count_nonzero(node >= 0)
        known = np.isin(node, np.arange(len(self.nodes))) & np.isin(direction, [0, 1, TURN]) | ((node == -1) & (direction == -1))
        if apart or not known.all():
            raise PinpressError(
                f"{what}: degrees must say for each row of the matrices the number of its node, from 0 to {len(self.nodes) - 1}, and 0 or 1"
                " for its displacement along the axes or 2 for its turn, each once; leave out what moves across the plane"
            )
        values["degrees"] = degrees.astype(np.intp)
        if not isinstance(self.bearings, Mapping) or len(set(map(str, self.bearings.values()))) < 2:
            raise PinpressError(
                f"{what}: bearings is {shown(self.bearings)}: give a mapping, name of each bearing: number of its node; at least two"
            )
        for name, place in self.bearings.items():
            whole_number(f"{what}: node of bearing {shown(name)}", place, 0, len(self.nodes) - 1)
            if not all(((degrees == (place, along)).all(axis=1)).any() for along in (0, 1)):
                raise PinpressError(f"{what}: node {place} of bearing {shown(name)} has no rows for its displacement along both axes")
        whole_number(f"{what}: modes", self.modes, 0, 50)
        ratio = number(f"{what}: damping_ratio", self.damping_ratio)
        if not 0.0 <= ratio <= 2.0:
            raise PinpressError(f"{what}: damping_ratio is {ratio:g}: give a number from 0 to 2; steel has 0.001 to 0.02")
        if ratio >= 1.0:
            caution(f"{what}: damping_ratio is {ratio:g}: give {ratio / 100:g} if per cent are meant; steel has 0.001 to 0.02")
        super().__post_init__()

    @property
    def natural_frequency(self) -> Array:
        """(m,) natural frequencies of the free link, as it is reduced [rad/s]."""
        return self._reduced.frequency

    @cached_property
    def _reduced(self) -> _Reduced:
        return _reduced(self)


def read_flexible_link(
    link: str,
    file: str | os.PathLike[str],
    *,
    bearings: Mapping[str, int],
    stiffness: str | os.PathLike[str] | None = None,
    nodes: Any = None,
    degrees: Any = None,
    modes: int = 4,
    damping_ratio: float = 0.01,
) -> FlexibleLink:
    """Read the matrices of a flexible link: one NumPy file, or two files in the Matrix Market format.

    Args:
        link: name of the link.
        file: a file `.npz` with ``mass``, ``stiffness``, ``nodes`` and ``degrees`` of `FlexibleLink`; or the mass matrix, `.mtx`,
            perhaps compressed, `.mtx.gz`.
        bearings: names of all bearings of the link -> number of the node at which each is, counted from 0.
        stiffness: the stiffness matrix, `.mtx`, where ``file`` is one.
        nodes: (k, 2) places of the nodes [m], where ``file`` is a matrix.
        degrees: (n, 2) node and direction of each row, where ``file`` is a matrix.
        modes: number of vibrations with its bearings held that are kept.
        damping_ratio: of each vibration of the free link [-].

    Raises:
        PinpressError: a file cannot be read, lacks an array, or the arrays make no sense.
    """
    second = None if stiffness is None else files.path_of("stiffness", stiffness)
    return FlexibleLink(link, bearings, *read_model(files.path_of("file", file), second, nodes, degrees), modes, damping_ratio)


# ------------------------------------------------------------------------------------------------------------------------------- reduction


class _Reduced(NamedTuple):
    """A free link in its own vibrations, of modal masses of 1, in the axes of its model.

    Mass [kg], centre of mass [m] and inertia about it [kg m2]; rising frequencies (m,) [rad/s], displacements (k, m) of the nodes, along
    the first axis and i times along the second, and the integrals c (m,) and G (m, m) of the module.
    """

    mass: float
    centre: complex
    inertia: float
    frequency: Array
    shapes: ComplexArray
    stretch: Array
    swirl: Array


def _reduced(link: FlexibleLink) -> _Reduced:
    what, mass, stiffness = f"FlexibleLink of {shown(link.link)}", link.mass, link.stiffness
    node, direction = link.degrees.T
    x, z = link.nodes[node].T  # of rows without a node they do not count
    along, across, turning = (np.where(direction == k, 1.0, 0.0) for k in (0, 1, TURN))
    whole = np.stack([along, across, across * x - along * z + turning], axis=1)
    # A motion of the whole link costs a millionth of the stiffness at most, by rounding of the file.
    if np.abs(stiffness @ whole).max() > 1e-6 * np.abs(stiffness).max() * max(1.0, float(np.abs(link.nodes).max())):
        raise PinpressError(
            f"{what}: its stiffness matrix resists when the link moves as a whole: give that of a link that nothing holds, with nodes in m"
        )
    rigid = whole.T @ mass @ whole
    total = float(rigid[0, 0])
    if not total > 0:
        raise PinpressError(f"{what}: its mass matrix has no mass: give kg")
    centre = complex(rigid[1, 2], -rigid[0, 2]) / total
    inertia = float(rigid[2, 2]) - total * abs(centre) ** 2
    at_bearings = np.flatnonzero(np.isin(node, list(link.bearings.values())) & np.isin(direction, (0, 1)))
    try:
        basis = craig_bampton(mass, stiffness, at_bearings, link.modes)
    except np.linalg.LinAlgError as error:
        raise PinpressError(f"{what}: it moves though all its bearings are held: some rows lack stiffness") from error
    try:
        squared, vectors = undamped_modes(basis.T @ mass @ basis, basis.T @ stiffness @ basis)
    except np.linalg.LinAlgError as error:
        raise PinpressError(f"{what}: its bearings can move without moving any mass: give the consistent mass matrix") from error
    if not squared[3] > 0 or np.abs(squared[:3]).max() > 1e-3 * squared[3]:
        raise PinpressError(f"{what}: more than three of its motions cost no energy: its parts are not joined, or it has a hinge")
    shapes = basis @ vectors[:, 3:]
    dilation = along * (x - centre.real) + across * (z - centre.imag)
    turned = np.zeros_like(shapes)  # by a quarter of a turn
    rows = {(int(n), int(d)): row for row, (n, d) in enumerate(link.degrees) if d in (0, 1)}
    for (n, d), row in rows.items():
        if (n, 1 - d) in rows:
            turned[row] = (2 * d - 1) * shapes[rows[n, 1 - d]]
    swirl = -shapes.T @ mass @ turned
    at_nodes = np.zeros((len(link.nodes), shapes.shape[1]), dtype=complex)
    for k, factor in ((0, 1.0), (1, 1j)):
        at_nodes[node[direction == k]] += factor * shapes[direction == k]
    return _Reduced(
        total, centre, inertia, np.sqrt(squared[3:]), at_nodes, np.asarray(dilation @ mass @ shapes), np.asarray(0.5 * (swirl - swirl.T))
    )


# -------------------------------------------------------------------------------------------------------------------------- in the linkage


@dataclass(frozen=True, eq=False)
class FlexibleBody:
    """A flexible link of a press, with shapes that have the link's mass each.

    Attributes:
        name: of the link.
        body: its number.
        columns: of its shapes' coordinates among all coordinates.
        mass: of the link [kg].
        stiffness: (m,) of its shapes [N/m].
        damping: (m,) [N s/m].
        stretch: (m,) c of the module [kg m].
        swirl: (m, m) G of the module [kg].
        places: (k,) nodes from the centre of mass, in the axes of the plane, in the drawn pose [m].
        shapes: (k, m) their displacements [-].
        nodes: nodes of its bearings.
        at_bearing: (m,) displacements of each bearing, by its number [-].
    """

    name: str
    body: int
    columns: slice
    mass: float
    stiffness: Array
    damping: Array
    stretch: Array
    swirl: Array
    places: ComplexArray
    shapes: ComplexArray
    nodes: tuple[int, ...]
    at_bearing: Mapping[int, ComplexArray]


def flexible_body(link: FlexibleLink, body: int, first: int, pins: Mapping[int, tuple[str, complex]], own: RigidInertia) -> FlexibleBody:
    """A flexible link put where the linkage has it.

    Args:
        link: its description.
        body: its number.
        first: column of the coordinate of its first shape.
        pins: name and place of each of its bearings by their numbers, in the axes of the plane, in the drawn pose.
        own: the link as a rigid body.

    Raises:
        PinpressError: bearings, mass, centre of mass or moment of inertia are not those of the link.
    """
    what, reduced = f"FlexibleLink of {shown(link.link)}", link._reduced
    names = [name for name, _ in pins.values()]
    if sorted(map(str, link.bearings)) != sorted(names):
        raise PinpressError(
            f"{what}: bearings names {', '.join(map(str, link.bearings))}, and the link has {', '.join(names)}: name all of them"
        )
    nodes = link.nodes @ (1.0, 1j) - reduced.centre
    by_model = np.array([nodes[link.bearings[name]] for name in names])
    by_linkage = np.array([place - own.centre for _, place in pins.values()])
    sides = [places - places.mean() for places in (by_model, by_linkage)]
    turn = complex(sides[0].conj() @ sides[1])
    turn /= abs(turn) or 1.0
    span = float(np.abs(sides[1]).max())
    for words, given, needed, size in (
        ("places of the bearings from each other [m]", turn * sides[0], sides[1], span),
        ("places of the bearings from the centre of mass [m]", turn * by_model, by_linkage, span),
        ("mass [kg]", reduced.mass, own.mass, own.mass),
        ("moment of inertia [kg m2]", reduced.inertia, own.inertia, own.inertia),
    ):
        if not np.abs(np.subtract(given, needed)).max() <= 0.02 * size:  # two per cent: model and linkage may differ in details
            texts = (", ".join(_text(value) for value in np.atleast_1d(places)) for places in (given, needed))
            raise PinpressError(f"{what}: {words} by its matrices: {next(texts)}; in the linkage: {next(texts)}; let both be the same")
    shapes = turn * reduced.shapes * np.sqrt(own.mass)
    return FlexibleBody(
        name=link.link,
        body=body,
        columns=slice(first, first + len(reduced.frequency)),
        mass=own.mass,
        stiffness=own.mass * reduced.frequency**2,
        damping=2 * link.damping_ratio * own.mass * reduced.frequency,
        stretch=reduced.stretch * np.sqrt(own.mass),
        swirl=reduced.swirl * own.mass,
        places=np.asarray(turn * nodes, dtype=complex),
        shapes=shapes,
        nodes=tuple(link.bearings[name] for name in names),
        at_bearing={number: shapes[link.bearings[name]] for number, (name, _) in pins.items()},
    )


class RigidInertia(NamedTuple):
    """A link as a rigid body: mass [kg], centre of mass in the drawn pose [m], moment of inertia about it [kg m2]."""

    mass: float
    centre: complex
    inertia: float


def _text(value: complex) -> str:
    return f"{value.real:.5g}" if not np.iscomplexobj(value) else f"({value.real:.5g}, {value.imag:.5g})"
