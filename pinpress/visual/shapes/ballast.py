"""What masses look like: solids of steel of that mass, for counterweights, slides and flywheels."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ...common.errors import PinpressError
from ...common.quantities import Array
from ...linkage import loading
from ...linkage.linkage import Linkage
from .bearing_layout import Ballast, BodyMass
from .solids import Cylinder, MadeUpSolid, Shape, Sphere, half_disc, volume_and_centre

DENSITY = 7850.0  # of steel [kg/m3]
OWN_SHARE = 0.5  # largest share of a link's mass that its drawn solids take, where they are larger than the link can be
THINNEST, THICKEST = 0.15, 1.6  # of half a disc: in widths of a bar, and as a share of its radius
DISC_THICKNESS, DISC_RADIUS = 0.5, 3.0  # in widths of a bar: a disc is as thick as a bar, but thicker where it would be larger than this,
SQUAT = 1.5  # up to this share of its radius
SLIDE_HEIGHT, SLIDE_DEPTH = 0.75, 0.8  # of a slide's block, as shares of its width
WIDEST, HIGHEST, DEEPEST = 0.42, 0.32, 0.34  # of a slide's block, as shares of the size
SEEN = 1e-3  # a mass that was added to a link is shown from this share of the link's mass,
FARTHEST = 2.0  # and no farther from the link's centre of mass than this, as a share of the size
RIM = 0.25  # thickness of a flywheel, as a share of its radius
LARGEST_FLYWHEEL = 0.6  # radius, as a share of the size; a larger inertia makes it thicker
_TURNS, _RISE = np.arange(200) * math.pi * (3 - math.sqrt(5)), 1 - (np.arange(200) + 0.5) / 100
EVERYWHERE = np.column_stack([np.cos(_TURNS) * np.sqrt(1 - _RISE**2), np.sin(_TURNS) * np.sqrt(1 - _RISE**2), _RISE])  # 200 directions
HOLES, HOLE, HOLE_AT = 5, 0.16, 0.62  # round recesses of a flywheel, by which its turning is seen: radius and place as shares of its radius


def added_masses(press: Linkage) -> dict[int, tuple[pin.Inertia, Ballast]]:
    """What has been added to the masses of a linkage since it was read, as `balance` does, by the joint: the inertia before, and what was
    added, both in the joint's frame."""
    try:
        before = loading.assembled(press.document, press.drivers, press.slide).model
    except PinpressError:  # of a text that was exchanged
        return {}
    if list(before.names) != list(press.model.names):
        return {}
    found = {}
    for joint, (was, now) in enumerate(zip(before.inertias, press.model.inertias, strict=True)):
        mass = now.mass - was.mass
        if mass > SEEN * now.mass:
            centre = (now.mass * now.lever - was.mass * was.lever) / mass
            if np.linalg.norm(centre - was.lever) < FARTHEST * press.size:
                found[joint] = was, Ballast(mass, centre)
    return found


def besides(body: BodyMass, solids: Sequence[MadeUpSolid]) -> Ballast:
    """The counterweight that gives a link its mass and centre of mass beside its drawn solids, as far as these are steel."""
    found = [(volume, (solid.placement @ [*centre, 1.0])[:3]) for solid in solids for volume, centre in [volume_and_centre(solid.shape)]]
    volumes = np.array([volume for volume, _ in found])
    own = min(DENSITY * float(volumes.sum()), OWN_SHARE * body.mass)
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
    volume, radius = mass / DENSITY, 0.75 * math.pi * arm
    if turns and radius > 0 and THINNEST * width <= (thickness := 2 * volume / (math.pi * radius**2)) <= THICKEST * radius:
        return half_disc(radius, thickness), thickness
    wanted, squat = volume / (math.pi * (DISC_RADIUS * width) ** 2), SQUAT * (volume / (SQUAT * math.pi)) ** (1 / 3)
    thickness = min(max(wanted, DISC_THICKNESS * width), squat)
    return Cylinder(math.sqrt(volume / (math.pi * thickness)), thickness), thickness


def ball(mass: float) -> Sphere:
    """A ball of this mass [kg]."""
    return Sphere((0.75 * mass / (math.pi * DENSITY)) ** (1 / 3))


def slide_block(mass: float, least_width: float, least_depth: float, size: float) -> tuple[float, float, float]:
    """Height along the guide, width and depth of a slide's block of this mass, but not too large beside the linkage [m].

    Args:
        mass: [kg].
        least_width: width of what the block hangs on [m].
        least_depth: depth of it [m].
        size: of the linkage [m].
    """
    volume = mass / DENSITY
    wide = max(least_width, min((volume / (SLIDE_HEIGHT * SLIDE_DEPTH)) ** (1 / 3), WIDEST * size))
    deep = max(least_depth, min(math.sqrt(volume / wide * SLIDE_DEPTH / SLIDE_HEIGHT), DEEPEST * size))
    return min(volume / (wide * deep), HIGHEST * size), wide, deep


def flywheel_disc(inertia: float, size: float) -> Cylinder:
    """A disc of this moment of inertia about its axis [kg m2], along z; it is thick where it would be large beside the linkage."""
    radius = min((2 * inertia / (math.pi * DENSITY * RIM)) ** 0.2, LARGEST_FLYWHEEL * size)
    return Cylinder(radius, 2 * inertia / (math.pi * DENSITY * radius**4))


def recesses(flywheel: Cylinder) -> list[tuple[Cylinder, tuple[float, float]]]:
    """Round recesses by which the turning of a flywheel is seen, each with its place (x, y) [m]."""
    hole = Cylinder(HOLE * flywheel.radius, 1.02 * flywheel.length)
    angles = (2 * math.pi * np.arange(HOLES) / HOLES).tolist()
    return [(hole, (HOLE_AT * flywheel.radius * math.cos(angle), HOLE_AT * flywheel.radius * math.sin(angle))) for angle in angles]
