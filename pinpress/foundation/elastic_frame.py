"""Frames that bend: a finite-element model of the frame, reduced by the method of Craig and Bampton.

Interfaces are the nodes at which mounts, bearings, guides, bed and attachments act. The reduction keeps two kinds of motion: the static
constraint modes (a unit displacement of one interface degree of freedom, all others fixed), and the lowest normal modes with fixed
interfaces (Craig and Bampton, AIAA Journal 6 (1968) 1313). So the static response to forces at the interfaces is exact for any number of
normal modes.

The reduced model has six coordinates of the mean motion of the frame (displacement and rotation of its point at the world origin) and the
modal coordinates q of its free vibrations, of modal mass 1: M = diag(Y, 1), K = diag(0, w^2), with the spatial inertia Y of the whole
frame. Only the mean motion has momentum. So an extremely stiff frame behaves like a rigid frame within rounding error.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from ..common import files
from ..common.arguments import number, numbers, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError, caution, shown
from ..common.frozen import FrozenMapping, read_only
from ..common.numerics import undamped_modes
from ..common.quantities import Array
from ..common.reading.matrices import craig_bampton, large_matrix, read_model, refuse_negative_mass
from ..common.results import Tabular
from ..common.tables import Column
from .frame_parts import COORDINATES, axis_index, rows_at

MOST_ROWS = 40_000  # of sparse matrices: this reduction takes a minute; larger models should be condensed in their own program
RIGID = 1e-6  # a rigid-body motion may meet this share of the stiffness by rounding errors
AT = 1e-3  # a place may differ from a node by this share of the frame's size
WHOLE = "frame"  # name of the frame's mean motion in the list of parts


@dataclass(frozen=True, eq=False, repr=False)
class ElasticFrame(Tabular):
    """A frame that bends, made by `reduced_frame`, `read_frame` or `beam_frame`. All arrays are read-only.

    Attributes:
        nodes: name of an interface -> (3,) place in world axes [m].
        bed: name of the interface on which the loads on the frame act (the process force).
        carrier: name of the interface that carries crank and guides, and the mass of the links.
        bearings: name of a bearing or guide on the frame -> name of the interface that carries it instead.
        inertia: (6, 6) spatial inertia of the frame about the world origin, linear before angular [kg, kg m, kg m2].
        natural_frequency: (m,) natural frequencies of the free reduced frame, rising [rad/s].
        motions: name of an interface -> (6, 6 + m) its displacement at the world origin and its rotation, for a unit of each coordinate:
            six of the mean motion of the frame, m of its free vibrations of modal mass 1 kg.
        places: (k, 3) nodes of the model, for pictures and for points of the frame [m].
        shapes: (k, 3, 6 + m) displacements of these nodes for a unit of each coordinate.
        lines: (l, 2) numbers of the nodes that a picture connects by lines.
        loss_factor: loss factor of the frame's material and joints, the same at all frequencies [-].
    """

    nodes: Mapping[str, tuple[float, float, float]]
    bed: str
    carrier: str
    bearings: Mapping[str, str]
    inertia: Array
    natural_frequency: Array
    motions: Mapping[str, Array]
    places: Array
    shapes: Array
    lines: NDArray[np.intp]
    loss_factor: float

    @property
    def title(self) -> str:
        lowest = self.natural_frequency[0] / (2 * np.pi)
        return f"ElasticFrame: {self.mass:.6g} kg, {len(self.nodes)} interfaces, {len(self.natural_frequency)} modes from {lowest:.4g} Hz"

    def columns(self) -> dict[str, Column]:
        """A row for each free vibration: its number and its natural frequency."""
        return {"mode": np.arange(1, len(self.natural_frequency) + 1), "natural_frequency [rad/s]": self.natural_frequency}

    @property
    def mass(self) -> float:
        """Mass of the frame [kg]."""
        return float(self.inertia[0, 0])

    def stiffness_between(self, one: str, other: str, *, axis: str = "z") -> float:
        """Static stiffness of the free frame against two forces that press two interfaces apart, such as slide and bed [N/m].

        Args:
            one: name of an interface.
            other: name of another interface.
            axis: direction of the forces, "x", "y" or "z". The interfaces must lie on a line in this direction; otherwise the forces would
                turn the frame.

        Raises:
            UnknownNameError: there is no such interface.
            PinpressError: the axis is not "x", "y" or "z", or the interfaces do not lie on a line along it.
        """
        for name in (one, other):
            if name not in self.nodes:
                raise UnknownNameError("interface", name, self.nodes)
        along = axis_index(axis)
        apart = np.delete(np.subtract(self.nodes[one], self.nodes[other]), along)
        if np.abs(apart).max() > AT * size_of(self.places):
            raise PinpressError(f"{one} and {other} are not on one line along {axis}: two forces there would turn the frame")
        stretch = (rows_at(self.motions[one], self.nodes[one]) - rows_at(self.motions[other], self.nodes[other]))[along, 6:]
        yielding = float(((stretch / self.natural_frequency) ** 2).sum())
        if yielding == 0:
            raise PinpressError(f"{one} and {other} do not move apart in any vibration of the frame: they are one place")
        return 1 / yielding

    def node_at(self, point: ArrayLike) -> str:
        """Name of the interface at a place in world axes [m].

        Raises:
            PinpressError: no interface is at this place.
        """
        names = list(self.nodes)
        away = np.linalg.norm(np.array(list(self.nodes.values())) - np.asarray(point, dtype=float), axis=1)
        nearest = int(away.argmin())
        if away[nearest] > AT * size_of(self.places):
            raise PinpressError(
                f"no interface of the frame is at {_text(point)} m: the nearest, {names[nearest]}, is {1e3 * away[nearest]:.4g} mm away;"
                " make an interface there"
            )
        return names[nearest]

    def rows_near(self, point: ArrayLike) -> Array:
        """Rows (3, 6 + m) of the displacement of a node of the model at a place in world axes [m].

        Raises:
            PinpressError: no node is at this place.
        """
        away = np.linalg.norm(self.places - np.asarray(point, dtype=float), axis=1)
        nearest = int(away.argmin())
        if away[nearest] > AT * size_of(self.places):
            raise PinpressError(
                f"no node of the frame is at {_text(point)} m: the nearest is at {_text(self.places[nearest])} m; give this place, or"
                " (interface, place) for a place that moves with an interface"
            )
        return np.asarray(self.shapes[nearest])


@typed
def reduced_frame(
    mass: Any,
    stiffness: Any,
    *,
    nodes: ArrayLike,
    degrees: ArrayLike,
    interfaces: Mapping[str, int],
    bed: str,
    carrier: str,
    bearings: Mapping[str, str] | None = None,
    modes: int = 20,
    loss_factor: float = 0.0,
    lines: ArrayLike | None = None,
) -> ElasticFrame:
    """Reduce a finite-element model of a free (unsupported) frame.

    Leave out all links of the press and all attachments. In a finite-element program, make each interface a master node with six degrees of
    freedom that moves the bore of a bearing or the face of a foot.

    Args:
        mass: (n, n) mass matrix, consistent or lumped; rows may have no mass. Up to 6000 rows, or 40 000 as a sparse matrix of SciPy [kg,
            kg m, kg m2].
        stiffness: (n, n) stiffness matrix [N/m, N, N m].
        nodes: (k, 3) places of the nodes in world axes [m].
        degrees: (n, 2) for each row of the matrices: the number of its node, and 0, 1, 2 for its displacement along x, y, z, or 3, 4, 5 for
            its turn about them; -1, -1 for a coordinate of a model that is reduced already.
        interfaces: name -> number of its node, which has all six degrees of freedom; every mount needs an interface.
        bed: name of the interface on which the loads on the frame act.
        carrier: name of the interface that carries crank and guides, and the mass of the links.
        bearings: name of a bearing or guide of the press on the frame -> name of the interface that carries it instead; None: all on
            ``carrier``.
        modes: number of normal modes with fixed interfaces that are kept.
        loss_factor: loss factor of the frame's material and joints [-].
        lines: (l, 2) numbers of the nodes that a picture connects by lines; None: no lines.

    Raises:
        UnknownNameError: ``bed``, ``carrier`` or the interface of a bearing is not among the interfaces.
        PinpressError: the frame of the matrices is not free, the matrices do not fit nodes and degrees, or an interface lacks a degree of
            freedom.

    Warns:
        PinpressWarning: the frame is so large that its nodes may be in mm.
    """
    what = "the frame"
    m, k = (large_matrix(f"{what}: {name}", given, MOST_ROWS) for name, given in (("mass", mass), ("stiffness", stiffness)))
    refuse_negative_mass(f"{what}: mass", m)
    if m.shape != k.shape:
        raise PinpressError(f"{what}: stiffness has shape {k.shape}, mass {m.shape}: give both for the same rows")
    places = numbers(f"{what}: nodes", nodes, (None, 3), unit="m")
    rows = _rows_of_degrees(degrees, m.shape[0], len(places))
    numbered = _check_interfaces(interfaces, rows, len(places))
    for name, each in (("bed", bed), ("carrier", carrier), *(bearings or {}).items()):
        if not isinstance(each, str) or each not in numbered:
            raise UnknownNameError(f"interface for {name}", each, numbered)
    loss = number("loss_factor", loss_factor)
    if loss < 0:
        raise PinpressError(f"loss_factor is {loss:g}: give a number that is not negative; welded steel has 0.002 to 0.02")
    joined = np.zeros((0, 2)) if lines is None else numbers(f"{what}: lines", lines, (None, 2))
    if not np.isin(joined, np.arange(len(places))).all():
        raise PinpressError(f"{what}: lines join nodes by their numbers, from 0 to {len(places) - 1}: give two node numbers for each line")
    # no frame is this large: its places are probably in mm
    if size_of(places) > 50.0:
        caution(f"{what}: its nodes are up to {size_of(places):.4g} m apart: if mm are meant, give all in m, kg and N")
    inertia, frequency, motions = _free_vibrations(m, k, places, rows, numbered, whole_number("modes", modes, 0, 200))
    shapes = np.zeros((len(places), 3, motions.shape[1]))
    for (node, direction), row in rows.items():
        if direction < 3:
            shapes[node, direction] = motions[row]
    at_nodes = {name: np.array([motions[rows[node, along]] for along in range(6)]) for name, node in numbered.items()}
    return ElasticFrame(
        nodes=FrozenMapping({name: tuple(places[node].tolist()) for name, node in numbered.items()}),
        bed=bed,
        carrier=carrier,
        bearings=FrozenMapping(dict(bearings or {})),
        inertia=read_only(inertia),
        natural_frequency=read_only(frequency),
        motions=FrozenMapping({name: _at_origin(each, places[numbered[name]]) for name, each in at_nodes.items()}),
        places=read_only(np.array(places)),
        shapes=read_only(shapes),
        lines=read_only(joined.astype(np.intp)),
        loss_factor=loss,
    )


@typed
def read_frame(
    file: str | os.PathLike[str],
    *,
    interfaces: Mapping[str, int],
    bed: str,
    carrier: str,
    stiffness: str | os.PathLike[str] | None = None,
    nodes: Any = None,
    degrees: Any = None,
    bearings: Mapping[str, str] | None = None,
    modes: int = 20,
    loss_factor: float = 0.0,
    lines: ArrayLike | None = None,
) -> ElasticFrame:
    """Read the matrices of a frame, and reduce them: one NumPy file, or two files in the Matrix Market format.

    Args:
        file: a file `.npz` with ``mass``, ``stiffness``, ``nodes`` and ``degrees`` of `reduced_frame`; or the mass matrix, `.mtx`,
            or compressed, `.mtx.gz`.
        interfaces: as for `reduced_frame`.
        bed: as for `reduced_frame`.
        carrier: as for `reduced_frame`.
        stiffness: the stiffness matrix, `.mtx`, if ``file`` is the mass matrix.
        nodes: (k, 3) places of the nodes [m], if ``file`` is the mass matrix.
        degrees: (n, 2) node and direction of each row, if ``file`` is the mass matrix.
        bearings: as for `reduced_frame`.
        modes: as for `reduced_frame`.
        loss_factor: as for `reduced_frame`.
        lines: as for `reduced_frame`.

    Raises:
        PinpressError: a file cannot be read or lacks an array; also as `reduced_frame`.
    """
    other = None if stiffness is None else files.path_of("stiffness", stiffness)
    mass, stiff, nodes, degrees = read_model(files.path_of("file", file), other, nodes, degrees)
    return reduced_frame(
        mass,
        stiff,
        nodes=nodes,
        degrees=degrees,
        interfaces=interfaces,
        bed=bed,
        carrier=carrier,
        bearings=bearings,
        modes=modes,
        loss_factor=loss_factor,
        lines=lines,
    )


def _text(place: ArrayLike) -> str:
    return f"({', '.join(f'{value:.4g}' for value in np.asarray(place, dtype=float))})"


def size_of(places: Array) -> float:
    """Largest extent of places (k, 3) along an axis [m]."""
    return float(np.ptp(places, axis=0).max()) or 1.0


def _rows_of_degrees(degrees: ArrayLike, count: int, nodes: int) -> dict[tuple[int, int], int]:
    """Row of each degree of freedom, (node, direction); raises PinpressError if they are not as in `reduced_frame`."""
    given = numbers("the frame: degrees", degrees, (count, 2))
    rows: dict[tuple[int, int], int] = {}
    for row, (node, direction) in enumerate(given.tolist()):
        if (node, direction) == (-1, -1):
            continue
        if (node, direction) in rows or node not in range(nodes) or direction not in range(6):
            again = ", as another row is" if (node, direction) in rows else ""
            raise PinpressError(
                f"the frame: row {row} of degrees is {node:g}, {direction:g}{again}: give for each row of the matrices the number of its"
                f" node, from 0 to {nodes - 1}, and 0, 1, 2 for its displacement along x, y, z or 3, 4, 5 for its turn about them, each"
                " once"
            )
        rows[int(node), int(direction)] = row
    return rows


def _check_interfaces(interfaces: Mapping[str, int], rows: Mapping[tuple[int, int], int], nodes: int) -> dict[str, int]:
    """Number of the node of each interface; raises PinpressError as `reduced_frame`."""
    if not isinstance(interfaces, Mapping) or not interfaces:
        raise PinpressError(f"interfaces is {shown(interfaces)}: give a mapping, name of each interface: number of its node")
    numbered: dict[str, int] = {}
    for name, given in interfaces.items():
        if not isinstance(name, str) or name == WHOLE:
            raise PinpressError(f"interface {shown(name)}: give it another name; {WHOLE!r} is the mean motion of the frame")
        node = whole_number(f"node of interface {shown(name)}", given, 0, nodes - 1)
        if any((node, along) not in rows for along in range(6)):
            raise PinpressError(
                f"interface {shown(name)}: node {node} does not have all six degrees of freedom: make it a master node that spreads its"
                " displacement over the nodes around it"
            )
        if node in numbered.values():
            raise PinpressError(f"interface {shown(name)}: node {node} is an interface already: name it once")
        numbered[name] = node
    return numbered


def _free_vibrations(
    mass: Any, stiffness: Any, places: Array, rows: Mapping[tuple[int, int], int], interfaces: Mapping[str, int], modes: int
) -> tuple[Array, Array, Array]:
    """Spatial inertia (6, 6), frequencies (m,) and motions (n, 6 + m) of all rows, for the reduced frame; raises PinpressError."""
    from scipy.linalg import null_space  # slow to import

    whole = _whole_motions(mass.shape[0], places, rows)
    reach = max(1.0, float(np.abs(places).max()))
    if np.abs(stiffness @ whole).max() > RIGID * abs(stiffness).max() * reach:
        raise PinpressError(
            "the frame: its stiffness matrix resists when the frame moves as a whole: give that of a frame that nothing holds, with nodes"
            " in m"
        )
    outer = np.array([rows[node, along] for node in interfaces.values() for along in range(6)])
    try:
        basis = craig_bampton(mass, stiffness, outer, modes)
    except np.linalg.LinAlgError as error:
        raise PinpressError("the frame: it moves though all its interfaces are held: some rows lack stiffness") from error
    rigid = np.vstack([whole[outer], np.zeros((basis.shape[1] - len(outer), 6))])
    if np.abs(basis @ rigid - whole).max() > RIGID * reach:
        raise PinpressError(
            "the frame: rows without a node move when the frame moves as a whole: give all nodes, or the reduced coordinates"
        )
    inertia = whole.T @ mass @ whole
    small, stiff = basis.T @ mass @ basis, basis.T @ stiffness @ basis
    free = null_space(rigid.T @ small)
    try:
        np.linalg.cholesky(inertia)
        squared, vectors = undamped_modes(free.T @ small @ free, free.T @ stiff @ free)
    except np.linalg.LinAlgError as error:
        motion = _massless(small[: len(outer), : len(outer)], list(interfaces))
        raise PinpressError(
            f"the frame: {motion} moves no mass: give rotary inertia to its node, or the consistent mass matrix of the frame"
        ) from error
    # a loose part has a frequency of zero, within the rounding error of the largest frequency
    if not len(squared) or squared[0] <= 1e-12 * squared[-1]:
        raise PinpressError("the frame: more than six of its motions cost no energy: its parts are not joined, or it has a hinge")
    return inertia, np.sqrt(squared), np.hstack([whole, basis @ (free @ vectors)])


def _massless(mass: Array, interfaces: Sequence[str]) -> str:
    """The motion of an interface that moves the least mass, as text, from the mass matrix (6 interfaces, 6 interfaces)."""
    own = np.diag(mass)
    scale = np.where(own > 0, own, 1.0) ** -0.5
    name, along = divmod(int(np.abs(np.linalg.eigh(scale[:, None] * mass * scale)[1][:, 0]).argmax()), 6)
    return f"interface {shown(interfaces[name])} along its coordinate {COORDINATES[along]}"


def _whole_motions(count: int, places: Array, rows: Mapping[tuple[int, int], int]) -> Array:
    """(n, 6) displacements and rotations of all rows in the six rigid-body motions, each a unit motion of the point at the world origin."""
    whole = np.zeros((count, 6))
    for (node, direction), row in rows.items():
        if direction < 3:
            whole[row, :3], whole[row, 3:] = np.eye(3)[direction], -pin.skew(places[node])[direction]
        else:
            whole[row, direction] = 1.0
    return whole


def _at_origin(motion: Array, place: Array) -> Array:
    """(6, n) displacement at the world origin and rotation, from the displacement at a place (3,) and the rotation of a node."""
    return read_only(np.vstack([motion[:3] + pin.skew(place) @ motion[3:], motion[3:]]))
