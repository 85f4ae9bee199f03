"""What masses look like: solids of steel of that mass, for counterweights, slides and flywheels."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...common.quantities import Array
from ...linkage.writing import STEEL
from .bearing_layout import Ballast, BodyMass
from .solids import Cylinder, MadeUpSolid, Shape, Sphere, half_disc, volume_and_centre

OWN_SHARE = 0.5  # largest share of a link's mass that its drawn solids take, where they are larger than the link can be
THINNEST, THICKEST = 0.15, 1.6  # of half a disc: in widths of a bar, and as a share of its radius
DISC_THICKNESS, DISC_RADIUS = 0.5, 3.0  # in widths of a bar: a disc is as thick as a bar, but thicker where it would be larger than this,
SQUAT = 1.5  # up to this share of its radius
SLIDE_HEIGHT, SLIDE_DEPTH = 0.75, 0.8  # of a slide's block, as shares of its width
WIDEST, HIGHEST, DEEPEST = 0.42, 0.32, 0.34  # of a slide's block, as shares of the size
RIM = 0.25  # thickness of a flywheel, as a share of its radius
LARGEST_FLYWHEEL = 0.6  # radius, as a share of the size; a larger inertia makes it thicker
_TURNS, _RISE = np.arange(200) * math.pi * (3 - math.sqrt(5)), 1 - (np.arange(200) + 0.5) / 100
EVERYWHERE = np.column_stack([np.cos(_TURNS) * np.sqrt(1 - _RISE**2), np.sin(_TURNS) * np.sqrt(1 - _RISE**2), _RISE])  # 200 directions
HOLES, HOLE, HOLE_AT = 5, 0.16, 0.62  # round recesses of a flywheel, by which its turning is seen: radius and place as shares of its radius


def besides(body: BodyMass, solids: Sequence[MadeUpSolid]) -> Ballast:
    """The counterweight that gives a link its mass and centre of mass beside its drawn solids, as far as these are steel."""
    found = [(volume, (solid.placement @ [*centre, 1.0])[:3]) for solid in solids for volume, centre in [volume_and_centre(solid.shape)]]
    volumes = np.array([volume for volume, _ in found])
    own = min(STEEL * float(volumes.sum()), OWN_SHARE * body.mass)
    if not own > 0:
        return Ballast(body.mass, body.centre)
    centre = volumes @ np.array([at for _, at in found]) / volumes.sum()
    return Ballast(body.mass - own, (body.mass * body.centre - own * centre) / (body.mass - own))


def outside(point: Array, pins: Array, directions: Array) -> float:
    """Distance of a point from the convex outline of pins (k, 3), 0 within it, as far as directions (d, 3) tell it [m]."""
    return max(0.0, float(np.max(directions @ point - np.max(directions @ pins.T, axis=1))))


def plane_counterweight(mass: float, arm: float, width: float, turns: bool) -> tuple[Shape, float]:
    """The solid of a counterweight across the normal of a plane, and its thickness [m]: half a disc about the pivot of a link that turns
    fully, if one of this mass and centre is neither too thin nor too thick, else a disc about the centre of mass.

    Args:
        mass: [kg].
        arm: distance of the centre of mass from the pivot [m].
        width: width of a bar [m].
        turns: whether the link turns fully.
    """
    volume, radius = mass / STEEL, 0.75 * math.pi * arm
    if turns and radius > 0 and THINNEST * width <= (thickness := 2 * volume / (math.pi * radius**2)) <= THICKEST * radius:
        return half_disc(radius, thickness), thickness
    wanted, squat = volume / (math.pi * (DISC_RADIUS * width) ** 2), SQUAT * (volume / (SQUAT * math.pi)) ** (1 / 3)
    thickness = min(max(wanted, DISC_THICKNESS * width), squat)
    return Cylinder(math.sqrt(volume / (math.pi * thickness)), thickness), thickness


def ball(mass: float) -> Sphere:
    """A ball of this mass [kg]."""
    return Sphere((0.75 * mass / (math.pi * STEEL)) ** (1 / 3))


def slide_block(mass: float, least_width: float, least_depth: float, size: float) -> tuple[float, float, float]:
    """Height along the guide, width and depth of a slide's block of this mass, but not too large beside the linkage [m].

    Args:
        mass: [kg].
        least_width: width of what the block hangs on [m].
        least_depth: depth of it [m].
        size: of the linkage [m].
    """
    volume = mass / STEEL
    wide = max(least_width, min((volume / (SLIDE_HEIGHT * SLIDE_DEPTH)) ** (1 / 3), WIDEST * size))
    deep = max(least_depth, min(math.sqrt(volume / wide * SLIDE_DEPTH / SLIDE_HEIGHT), DEEPEST * size))
    return min(volume / (wide * deep), HIGHEST * size), wide, deep


def flywheel_disc(inertia: float, size: float) -> Cylinder:
    """A disc of this moment of inertia about its axis [kg m2], along z; it is thick where it would be large beside the linkage."""
    radius = min((2 * inertia / (math.pi * STEEL * RIM)) ** 0.2, LARGEST_FLYWHEEL * size)
    return Cylinder(radius, 2 * inertia / (math.pi * STEEL * radius**4))


def recesses(flywheel: Cylinder) -> list[tuple[Cylinder, tuple[float, float]]]:
    """Round recesses by which the turning of a flywheel is seen, each with its place (x, y) [m]."""
    hole = Cylinder(HOLE * flywheel.radius, 1.02 * flywheel.length)
    angles = (2 * math.pi * np.arange(HOLES) / HOLES).tolist()
    return [(hole, (HOLE_AT * flywheel.radius * math.cos(angle), HOLE_AT * flywheel.radius * math.sin(angle))) for angle in angles]
