"""Springs, dampers and mounts of an elastic press as text, for the inputs that pages and commands state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...dynamics.inputs import Inputs, row, written
from ...loads.mounts import Mount
from .description import Elastic, Stiffness
from .preloaded_joint import PreloadedJoint

DIGITS = 4


def stiffness_in_words(stiffness: Stiffness) -> Inputs:
    """The stiffnesses of a press's parts; equal ones stand together."""
    rows: list[tuple[str, float | PreloadedJoint, str]] = [(name, value, "N/m") for name, value in stiffness.bearings.items()]
    rows += [(f"{name}, turning", value, "N m/rad") for name, value in stiffness.moments.items()] if stiffness.moments else []
    rows += [(f"{rod.name}{rod.basis and f', {rod.basis}'}", rod.stiffness, "N/m") for rod in stiffness.rods]
    rows += [] if stiffness.shaft is None else [("shaft", stiffness.shaft, "N m/rad")]
    rows += [] if stiffness.frame is None else [("frame", stiffness.frame, "N/m")]
    names: dict[str, list[str]] = {}
    for name, value, unit in rows:
        words = written(value, unit, DIGITS)
        if isinstance(value, PreloadedJoint):
            loaded, relieved = (written(each, unit, DIGITS) for each in (value.loaded, value.relieved))
            words = f"{loaded} and {relieved}, preloaded by {written(value.preload, 'N', DIGITS)}"
        names.setdefault(words, []).append(name)
    return [("elastic parts", "; ".join(f"{', '.join(some)}: {words}" for words, some in names.items()))]


def elastic_in_words(elastic: Elastic) -> Inputs:
    """What yields, and what damps it."""
    words = [("damping", f"ratio {elastic.damping_ratio:g} of the lowest vibration at bottom dead centre")]
    if elastic.dampers:
        words.append(("dampers", ", ".join(f"{name} {written(value, 'N s/m', DIGITS)}" for name, value in elastic.dampers.items())))
    if elastic.crown_mass is not None:
        words.append(("crown", f"{elastic.crown_mass:.6g} kg"))
    for name, each in elastic.clearances.items():
        law = each.law if each.law == "linear" else f"{each.law}, restitution {each.restitution:g}"
        words.append((f"clearance of {name}", f"{written(each.radial, 'm', DIGITS)} radial, contact law {law!r}"))
    if elastic.flexible_links:
        words.append(("flexible links", ", ".join(f"{each.link}, {len(each.natural_frequency)} shapes" for each in elastic.flexible_links)))
    if elastic.mounted_frame is not None:
        words += [row("frame", elastic.mounted_frame), ("mounts", mounts_in_words(elastic.mounts))]
    return [*stiffness_in_words(elastic.stiffness), *words]


def mounts_in_words(mounts: Sequence[Mount]) -> str:
    """Springs with their places; those that differ in nothing else stand together."""
    places: dict[Mount, list[str]] = {}
    for mount in mounts:
        place = ", ".join(f"{value:.4g}" for value in mount.point)
        places.setdefault(replace(mount, point=(0.0, 0.0, 0.0)), []).append(f"({place})")
    return "; ".join(f"{len(some)} at {', '.join(some)} m: {_spring(mount)}" for mount, some in places.items())


def _spring(mount: Mount) -> str:
    words = [f"{_along_axes(1e-6, mount.stiffness)} kN/mm along x, y, z"]
    words += [f"{_along_axes(1e-6, mount.static)} kN/mm at rest"] if mount.static != mount.stiffness else []
    words += [f"damping {_along_axes(1e-3, mount.damping)} kN s/m"] if any(mount.damping) else []
    words += [f"loss factor {mount.loss_factor:.4g}"] if mount.loss_factor else []
    return ", ".join(words + ([] if mount.area is None else [f"area {mount.area:.4g} m²"]))


def _along_axes(factor: float, values: Sequence[float]) -> str:
    return " / ".join(f"{factor * value:.4g}" for value in values)
