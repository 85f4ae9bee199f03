"""Solids of steel that stand for masses: counterweights, slides and flywheels."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...common.quantities import Array
from ...linkage.writing import STEEL
from .bearing_layout import Ballast, BodyMass
from .solids import Cylinder, MadeUpSolid, Shape, Sphere, half_disc, volume_and_centre

_TURNS, _RISE = np.arange(200) * math.pi * (3 - math.sqrt(5)), 1 - (np.arange(200) + 0.5) / 100
EVERYWHERE = np.column_stack([np.cos(_TURNS) * np.sqrt(1 - _RISE**2), np.sin(_TURNS) * np.sqrt(1 - _RISE**2), _RISE])  # 200 directions


def besides(body: BodyMass, solids: Sequence[MadeUpSolid]) -> Ballast:
    """The counterweight that gives a link its mass and centre of mass, in addition to its drawn solids as steel."""
    sizes = [volume_and_centre(solid.shape) for solid in solids]
    volumes = np.array([volume for volume, _ in sizes])
    own = min(STEEL * float(volumes.sum()), 0.5 * body.mass)  # at most half of the link's mass, because solids may be drawn too large
    if not own > 0:
        return Ballast(body.mass, body.centre)
    centres = [(solid.placement @ [*centre, 1.0])[:3] for solid, (_, centre) in zip(solids, sizes, strict=True)]
    centre = volumes @ np.array(centres) / volumes.sum()
    return Ballast(body.mass - own, (body.mass * body.centre - own * centre) / (body.mass - own))


def outside(point: Array, pins: Array, directions: Array) -> float:
    """Distance of a point from the convex outline of pins (k, 3), measured along directions (d, 3); 0 within the outline [m]."""
    return max(0.0, float(np.max(directions @ point - np.max(directions @ pins.T, axis=1))))


def plane_counterweight(mass: float, arm: float, width: float, turns: bool) -> tuple[Shape, float]:
    """The solid of a counterweight across the normal of a plane, and its thickness [m]: for a link that turns fully, half a disc about its
    pivot, if a half disc of this mass and centre is neither too thin nor too thick; otherwise a disc about the centre of mass.

    Args:
        mass: mass [kg].
        arm: distance of the centre of mass from the pivot [m].
        width: width of a bar [m].
        turns: whether the link turns fully.
    """
    volume, radius = mass / STEEL, 0.75 * math.pi * arm
    if turns and radius > 0 and 0.15 * width <= (thickness := 2 * volume / (math.pi * radius**2)) <= 1.6 * radius:
        return half_disc(radius, thickness), thickness
    # as thick as a bar; if the radius would exceed 3 widths of a bar, thicker, up to 1.5 radii
    thickness = min(max(volume / (math.pi * (3.0 * width) ** 2), 0.5 * width), 1.5 * (volume / (1.5 * math.pi)) ** (1 / 3))
    return Cylinder(math.sqrt(volume / (math.pi * thickness)), thickness), thickness


def ball(mass: float) -> Sphere:
    """A ball of this mass [kg]."""
    return Sphere((0.75 * mass / (math.pi * STEEL)) ** (1 / 3))


def slide_block(mass: float, least_width: float, least_depth: float, size: float) -> tuple[float, float, float]:
    """Height along the guide, width and depth of a slide's block of this mass, limited by the size of the linkage [m].

    Args:
        mass: mass [kg].
        least_width: width of the part from which the block hangs [m].
        least_depth: depth of this part [m].
        size: size of the linkage [m].
    """
    volume, height, depth = mass / STEEL, 0.75, 0.8  # height and depth as shares of the width
    wide = max(least_width, min((volume / (height * depth)) ** (1 / 3), 0.42 * size))
    deep = max(least_depth, min(math.sqrt(volume / wide * depth / height), 0.34 * size))
    return min(volume / (wide * deep), 0.32 * size), wide, deep


def flywheel_disc(inertia: float, size: float) -> Cylinder:
    """A disc along z that stands for a flywheel of this moment of inertia about its axis [kg m2]. It has this inertia as steel, with a
    thickness of a quarter of its radius, where its radius is then from 0.15 to 0.3 of the linkage's size [m]; else it is a symbol of the
    nearer of these sizes."""
    radius = float(np.clip((2 * inertia / (math.pi * STEEL * 0.25)) ** 0.2, 0.15 * size, 0.3 * size))
    return Cylinder(radius, 0.25 * radius)
