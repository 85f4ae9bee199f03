"""Freedoms of a closed linkage that its motors do not determine: what they are, which of them are held, and by which joints the others are
described.

A freedom is a way v of all joints that keeps the loops closed and the motors still: [J; S] v = 0, with the Jacobian J of the equations and
the rows S of the motors. Ways are counted in rad, travels in sizes of the linkage. Its kinds:

- ``"spin"``: a link, or a chain of links, turns about the line through two bearings, in loops, while all others rest, and its centre of
  mass is on that line. No weight turns it. A rod between two ball joints is the usual one, in one piece or in several.
- ``"swing"``: the same with the centre of mass off the line. Its weight would turn it.
- ``"spring"``, ``"base"``, ``"passive"``: anything else, described by a joint that a spring moves, by one of the six joints of a floating
  base, or by another joint.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.quantities import Array
from ...common.results import Record
from ...engines.mounting import Mounting
from ...engines.pinocchio.equations import OneConfiguration
from ...engines.rank import rank
from ...engines.structure import Structure, configuration, data_of

LONGEST = 7  # most bodies of a chain, on either side of a loop: a telescopic leg between two balls that are split into hinges has 7
RESTS = 1e-4  # share of the fastest motion below which a body rests; rounded numbers of a file move it by up to 1e-5
LIGHT = 1e-9  # share of the whole mass up to which a body has none: formats that take no zero have 1e-12 kg or less in its place
BALANCED = 1e-6  # a centre of mass this close to the line about which its link spins is on it [sizes of the linkage]
WEAK = 0.02  # share of a way below which a joint hardly moves in it, and is no good coordinate


@dataclass(frozen=True, repr=False)
class Freedom(Record, units={"eccentricity": "m"}):
    """A freedom of a linkage that no motor moves; its kinds are those of the module.

    A spin or swing is held: one joint of the chain stands still, that which moves most in it, first of equals. The chain then does not
    turn about its line against the bearing that carries this joint, as with a universal joint in place of a ball. Torques depend on that
    choice by the chain's moment of inertia about its own line alone. In a pose in which the held joint would not move in the spin the
    linkage locks; the joint that moves most in the home pose keeps such poses far.

    Attributes:
        kind: "spin", "swing", "spring", "base" or "passive".
        joints: names of the joints that move in it. The first is the one that is held, or else the coordinate in `Linkage.passive`.
        bodies: names of the links that move in it and have a mass; of all that move where none has.
        held: whether the first joint is held still.
        eccentricity: of a spin or swing, distance of the centre of mass from the line about which it turns [m]; None for other kinds.
    """

    kind: str
    joints: tuple[str, ...]
    bodies: tuple[str, ...]
    held: bool
    eccentricity: float | None = None


class Undriven(NamedTuple):
    """What the motors of a linkage leave free.

    Attributes:
        freedoms: spins and swings first, then in the order of preference as coordinates: springs, base, others.
        places: index in v of the first joint of each.
    """

    freedoms: tuple[Freedom, ...]
    places: tuple[int, ...]

    def of(self, *kinds: str) -> tuple[str, ...]:
        """The first joints of the freedoms of these kinds."""
        return tuple(each.joints[0] for each in self.freedoms if each.kind in kinds)


def free_ways(structure: Structure, columns: Array, still: Sequence[int] = ()) -> Array:
    """(nv, k) orthonormal ways, in rad and sizes, in which a linkage moves; ``columns``: (rows, nv) Jacobian; ``still``: joints at rest."""
    scaled = columns * structure.lengths
    moving = [j for j in range(structure.model.nv) if j not in set(still)]
    ways = np.zeros((structure.model.nv, len(moving) - rank(scaled[:, moving], structure.rank_tolerance)))
    if ways.size:
        ways[moving] = np.linalg.svd(scaled[:, moving])[2][len(moving) - ways.shape[1] :].T if len(scaled) else np.eye(len(moving))
    return ways


def columns_at(structure: Structure, x: Array, held: int = 0) -> Array:
    """(rows, nv) Jacobian of the loops and relations at joint coordinates (nv,), without the last rows, of ``held`` joints."""
    columns = OneConfiguration(structure).at(x).columns
    return columns[: len(columns) - held]


def undriven(
    structure: Structure,
    x: Array,
    motors: Sequence[int],
    sprung: Sequence[int],
    base: Sequence[int],
    taken: Sequence[int] = (),
    held: int = 0,
) -> Undriven:
    """The freedoms that motors leave in a closed pose.

    Args:
        structure: of the linkage; its own drivers do not matter here.
        x: (nv,) coordinates of the closed pose.
        motors: indices in v of the joints that motors move.
        sprung: of the joints on which springs act.
        base: of the joints of a floating base.
        taken: of joints that are held, or coordinates, already: they are preferred.
        held: number of joints held still, by the last relations of the structure; they count as free here.
    """
    ways = free_ways(structure, columns_at(structure, x, held), motors)
    if not ways.shape[1]:
        return Undriven((), ())
    moves = _Bodies.at(structure, x)
    near = next(_neighbours(structure, x), x)
    moves_near, ways_near = _Bodies.at(structure, near), free_ways(structure, columns_at(structure, near, held), motors)
    freedoms, places = [], []
    for group in moves.groups(ways):
        while (spin := moves.spin(ways, group, taken)) is not None:
            freedom, joint = spin
            # Where three hinges of a ball are oblique, one of them may rest in the spin in this pose alone: the group is larger beside it.
            wider = (each for each in moves_near.groups(ways_near) if set(group) <= set(each))
            again = next((found for each in wider if (found := moves_near.spin(ways_near, each, [joint]))), None)
            if again is None or again[1] != joint:
                break  # an axis happens to go through another one in this pose, as in a spherical wrist
            freedoms.append(freedom)
            places.append(joint)
            ways, ways_near = _without(ways, joint), _without(ways_near, joint)
    tiers = [("spring", sprung, WEAK), ("base", base, WEAK), ("passive", range(structure.model.nv), 0.0)]
    coordinates: list[tuple[int, str]] = []
    for kind, among, least in tiers:
        weights = np.zeros(len(ways))
        weights[list(among)] = 1.0
        weights[list(set(among) & set(taken))] = 1.0 / WEAK
        coordinates += [(joint, kind) for joint in sorted(pivots(ways, weights, least, [joint for joint, _ in coordinates]))]
    if coordinates:
        single = ways @ np.linalg.inv(ways[[joint for joint, _ in coordinates]])  # each moves one of the coordinates alone
        for (joint, kind), way in zip(coordinates, single.T, strict=True):
            freedoms.append(moves.freedom(kind, way, joint))
            places.append(joint)
    return Undriven(tuple(freedoms), tuple(places))


def pivots(ways: Array, weights: Array, least: float = RESTS, chosen: Sequence[int] = ()) -> list[int]:
    """Joints whose motions choose a way each, one after the other: the next one is that with the largest part, times its weight, that does
    not follow from those before it.

    Args:
        ways: (nv, k) orthonormal ways.
        weights: (nv,) of the joints; 0 for one that must not be chosen.
        least: smallest part that is chosen, without its weight [-].
        chosen: joints chosen before.
    """
    rest, found = ways, list[int]()
    for joint in chosen:
        rest = _without(rest, joint)
    while len(chosen) + len(found) < ways.shape[1]:
        parts = np.linalg.norm(rest, axis=1)
        marks = np.where(parts > max(least, 1e-9), parts * weights, 0.0)
        if not marks.max(initial=0.0):
            break
        found.append(_first_largest(marks))
        rest = _without(rest, found[-1])
    return found


def conditioning(ways: Array, joints: Sequence[int]) -> float:
    """How well joints determine the ways (nv, k), k joints: 1 at best, 0 if they do not; of fewer joints, how independent they are."""
    return float(np.linalg.svd(ways[list(joints)], compute_uv=False).min(initial=1.0))


def generic_ways(structure: Structure, x: Array) -> int:
    """Number of free ways in closed poses near a closed pose (nv,): the smallest of four poses, with joints moved by up to 0.15 rad. In the
    pose itself it is larger where assemblies meet, as in a parallelogram drawn in one line."""
    return int(min(free_ways(structure, columns_at(structure, pose)).shape[1] for pose in (x, *_neighbours(structure, x))))


def _neighbours(structure: Structure, x: Array) -> Iterator[Array]:
    """Up to four closed poses (nv,) near a closed pose."""
    mounting, random = Mounting(structure), np.random.default_rng(0)
    for _ in range(4):
        near = mounting.close(x + 0.15 * mounting.lengths * random.uniform(-1.0, 1.0, len(x)), limited=False)
        if near.misfit <= mounting.closed:
            yield near.position


def _without(ways: Array, joint: int) -> Array:
    """Orthonormal ways (nv, k - 1) of those among ways (nv, k) in which a joint rests."""
    return np.asarray(ways @ np.linalg.svd(ways[joint][None])[2][1:].T)


def _first_largest(values: Array) -> int:
    """Index of the first of the largest values, which may differ by rounding."""
    return int(np.flatnonzero(values >= (1.0 - 1e-6) * values.max())[0])


@dataclass(frozen=True, eq=False)
class _Bodies:
    """How the bodies of a linkage move in a pose.

    Attributes:
        structure: of the linkage.
        twists: (bodies, 6, nv) motion of every body by every joint: velocity at the world origin in sizes, angular velocity, world axes.
        places: placements of the bodies in the world.
        links: names of the bodies, by their first links.
    """

    structure: Structure
    twists: Array
    places: list[pin.SE3]
    links: list[str]

    @staticmethod
    def at(structure: Structure, x: Array) -> _Bodies:
        model = structure.model
        data = data_of(model)
        jacobian = pin.computeJointJacobians(model, data, configuration(structure.slots, x)).reshape(6, -1) * structure.lengths
        carried = np.zeros((model.nv + 1, model.nv), dtype=bool)  # by which joints a body is carried
        for joint, parent in enumerate(structure.parents):
            carried[joint] = carried[parent]  # that of the frame is the last
            carried[joint, joint] = True
        jacobian[:3] /= structure.size
        names = {frame.parentJoint: str(frame.name) for frame in reversed(list(model.frames)) if frame.type == pin.BODY}
        links = [names.get(joint, str(model.names[joint])) for joint in range(1, model.njoints)]
        return _Bodies(structure, jacobian * carried[:-1, None], [place.copy() for place in data.oMi][1:], links)

    def groups(self, ways: Array) -> Iterator[tuple[int, ...]]:
        """Groups of moving bodies that may turn while others rest, between bearings of loops: chains of the tree, then across loops, small
        ones first."""
        moves = np.linalg.norm((self.twists @ ways).reshape(len(ways), -1), axis=1) > RESTS
        parents = self.structure.parents

        def chains(body: int) -> list[tuple[int, ...]]:
            chain: list[int] = []
            while body >= 0 and moves[body] and len(chain) < LONGEST:
                chain.append(body)
                body = parents[body]
            return [tuple(chain[:count]) for count in range(1, len(chain) + 1)]

        single = [chain for body in range(len(parents)) for chain in chains(body) if self.structure.on_loop[list(chain)].any()]
        across = [
            (*one, *other)
            for loop in self.structure.loops
            for one, other in product(chains(loop.joint1 - 1), chains(loop.joint2 - 1))
            if set(one).isdisjoint(other)
        ]
        return iter(sorted(dict.fromkeys(single), key=len) + sorted(dict.fromkeys(across), key=len))

    def spin(self, ways: Array, group: Sequence[int], taken: Sequence[int]) -> tuple[Freedom, int] | None:
        """A spin or swing of this group of bodies, and the index of the joint that is held; None if there is none."""
        if not ways.shape[1]:
            return None
        others = np.delete(self.twists, group, axis=0).reshape(-1, len(ways)) @ ways
        values, right = np.linalg.svd(np.vstack([others, np.zeros((ways.shape[1], ways.shape[1]))]), full_matrices=False)[1:]
        for way in (ways @ right[values <= RESTS].T).T:
            freedom = self._spin(way, taken)
            if freedom is not None:
                return freedom
        return None

    def _spin(self, way: Array, taken: Sequence[int]) -> tuple[Freedom, int] | None:
        moving, weighing = self._moving(way)
        if weighing and (self._bearings(set(moving)) < 2 or not self.structure.on_loop[np.abs(way) > RESTS * np.abs(way).max()].all()):
            return None  # a pendulum, or the middle of a wrist that nothing holds at its end
        shares, eccentricity = np.abs(way), 0.0
        joint = next((joint for joint in taken if shares[joint] > WEAK * shares.max()), _first_largest(shares))
        if weighing:
            twists = self.twists[weighing] @ way
            velocity, angular = twists[0, :3], twists[0, 3:]
            turning = float(np.linalg.norm(angular))
            if np.abs(twists - twists[0]).max() > RESTS * np.abs(twists).max() or turning <= RESTS * float(np.linalg.norm(velocity)):
                return None
            if abs(angular @ velocity) > RESTS * turning**2:
                return None  # a screw
            inertias = [self.structure.model.inertias[body + 1] for body in weighing]
            centre = sum(inertia.mass * self.places[body].act(inertia.lever) for body, inertia in zip(weighing, inertias, strict=True))
            mass = sum(inertia.mass for inertia in inertias)
            if mass:
                eccentricity = float(np.linalg.norm(self.structure.size * velocity + np.cross(angular, centre / mass))) / turning
        kind = "spin" if eccentricity <= max(BALANCED * self.structure.size, self.structure.tolerance) else "swing"
        return self.freedom(kind, way, joint, eccentricity), joint

    def freedom(self, kind: str, way: Array, joint: int, eccentricity: float | None = None) -> Freedom:
        """The freedom of a way (nv,) with its first joint."""
        moving, weighing = self._moving(way)
        names = self.structure.model.names
        share = np.abs(way) > RESTS * np.abs(way).max()
        joints = (joint, *(int(j) for j in np.flatnonzero(share) if j != joint))
        bodies = tuple(self.links[body] for body in weighing or moving)
        return Freedom(kind, tuple(str(names[j + 1]) for j in joints), bodies, eccentricity is not None, eccentricity)

    def _moving(self, way: Array) -> tuple[list[int], list[int]]:
        """The bodies that move in a way (nv,), and those of them that have inertia."""
        speeds: NDArray[np.float64] = np.linalg.norm(self.twists @ way, axis=1)
        moving = [int(body) for body in np.flatnonzero(speeds > RESTS * speeds.max(initial=0.0))]
        inertias = self.structure.model.inertias
        least = LIGHT * sum(inertia.mass for inertia in inertias)
        of_size = least * self.structure.size**2
        return moving, [b for b in moving if inertias[b + 1].mass > least or np.abs(inertias[b + 1].inertia).max() > of_size]

    def _bearings(self, moving: set[int]) -> int:
        """How many joints and loops join moving bodies to resting ones."""
        pairs = [(body, parent) for body, parent in enumerate(self.structure.parents)]
        pairs += [(loop.joint1 - 1, loop.joint2 - 1) for loop in self.structure.loops]
        return sum((one in moving) != (other in moving) for one, other in pairs)
