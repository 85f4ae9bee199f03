"""The input of an elastic press: the stiffnesses of its parts, the dampers, and the mass of the crown on its columns.

Static deflections need stiffnesses alone (`Stiffness`). A motion also needs damping and, on columns that yield, the mass of the crown
(`Elastic`). Damping is proportional to stiffness, unless a bearing has a damper of its own. The user gives the damping ratio of the first
mode, the vibration with the lowest natural frequency, at bottom dead centre. The damping ratio of a higher mode is larger, in proportion to
its frequency.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ...common.arguments import number
from ...common.errors import PinpressError, caution, shown
from ...common.frozen import Frozen
from ...loads.mounts import Frame, Mount
from .contact import Clearance
from .flexible_link import FlexibleLink
from .preloaded_joint import PreloadedJoint


@dataclass(frozen=True)
class Rod:
    """A link, or one arm of a link, that stretches along the line between two of its bearings.

    The force in a link with two bearings is the mean of the pulls of both along this line. This is exact if its mass is symmetric about its
    middle. A link with more bearings has arms: an arm begins at the first of the two bearings, and the second one alone loads it.

    Attributes:
        link: name of the link.
        between: names of the two bearings.
        stiffness: stiffness E A / l between the bearings [N/m], or a `PreloadedJoint`, such as a die-height screw and its lock.
        basis: from what the stiffness was computed, as text in results; empty: it was given.
    """

    link: str
    between: tuple[str, str]
    stiffness: float | PreloadedJoint
    basis: str = ""

    @property
    def name(self) -> str:
        """Name of the part in tables."""
        return f"{self.link} {self.between[0]}-{self.between[1]}"


@dataclass(frozen=True, eq=False)
class Stiffness(Frozen):
    """Stiffnesses of the parts of a press. Parts without a stiffness are rigid, and so are gear pairs.

    A `PreloadedJoint` can stand in place of a number. A large enough load frees one of its two members.

    Attributes:
        bearings: name of a bearing -> stiffness [N/m]. It is the radial stiffness of a pin, in space also the one along its axis. It is
            the stiffness of a guide across its axis, in space along each of the two directions across. A guide can also have a
            `PreloadedJoint`: its two gibs with their preload.
        moments: name of a guide, in space also of a pin or weld -> stiffness against turning [N m/rad]. The moment of a guide is about the
            origin of the sliding link's joint frame, as in `Reactions`.
        rods: links and arms that stretch.
        shaft: torsional stiffness of the shaft between the driver's crank and the drive [N m/rad]; None: rigid. The initial angle and speed
            of an elastic motion are those of the shaft's end at the drive, where the flywheel sits and a brake acts.
        frame: stiffness of the columns between table and crown [N/m], or a `PreloadedJoint`: tie rods and uprights with their preload;
            None: rigid. The crown carries all bearings that are on the frame. The table stands on the floor: weight and inertia forces on
            the crown load the columns too.
    """

    bearings: Mapping[str, float | PreloadedJoint] = field(default_factory=dict)
    moments: Mapping[str, float] = field(default_factory=dict)
    rods: Sequence[Rod] = ()
    shaft: float | None = None
    frame: float | PreloadedJoint | None = None


@dataclass(frozen=True, eq=False)
class Elastic(Frozen):
    """A press that yields while it runs: springs, dampers and the crown's mass.

    Attributes:
        stiffness: stiffnesses of its parts. ``bearings`` must name all bearings, and ``moments`` all guides.
        damping_ratio: damping ratio of the first mode (lowest natural frequency) at bottom dead centre, from 0 to 2 [-]. The damping of
            every spring is proportional to its stiffness.
        dampers: name of a bearing or guide -> its damping, which replaces the proportional one [N s/m].
        crown_mass: mass of the crown on its columns, without the linkage [kg]; to be given together with ``stiffness.frame``.
        clearances: name of a pin -> its clearance. Such a press has no steady state: use `simulate`.
        flexible_links: links that bend and stretch.
        mounted_frame: mass, centre of mass and inertia of the frame on its mounts, as for `foundation`; None: the frame is fixed.
        mounts: mounts between floor and frame. Only their forces in the plane of the press count, and their damping must be viscous.
    """

    stiffness: Stiffness
    damping_ratio: float = 0.02
    dampers: Mapping[str, float] = field(default_factory=dict)
    crown_mass: float | None = None
    clearances: Mapping[str, Clearance] = field(default_factory=dict)
    flexible_links: Sequence[FlexibleLink] = ()
    mounted_frame: Frame | None = None
    mounts: Sequence[Mount] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_mounts()
        if not isinstance(self.stiffness, Stiffness):
            raise PinpressError(f"Elastic: stiffness is {shown(self.stiffness)}: give a Stiffness(bearings={{...}}, moments={{...}})")
        if not isinstance(self.flexible_links, Sequence):
            raise PinpressError(f"Elastic: flexible_links is {shown(self.flexible_links)}: give a list of FlexibleLink")
        ratio = number("Elastic: damping_ratio", self.damping_ratio)
        if not 0.0 <= ratio <= 2.0:
            raise PinpressError(f"Elastic: damping_ratio is {ratio:g}: give a number from 0 to 2; steel structures have 0.01 to 0.05")
        if ratio >= 1.0:
            caution(
                f"Elastic: damping_ratio is {ratio:g}, with which the lowest vibration does not swing: give {ratio / 100:g} if per cent are"
                " meant; steel structures have 0.01 to 0.05"
            )
        if (self.stiffness.frame is None) != (self.crown_mass is None):
            raise PinpressError("Elastic: a crown on its columns needs both stiffness.frame [N/m] and crown_mass [kg]; give both, or none")

    def _check_mounts(self) -> None:
        if self.mounted_frame is None and isinstance(self.mounts, Sequence) and not len(self.mounts):
            return
        if not isinstance(self.mounted_frame, Frame):
            raise PinpressError(
                f"Elastic: mounted_frame is {shown(self.mounted_frame)}: give the foundation.Frame that stands on the mounts"
            )
        if not isinstance(self.mounts, Sequence) or not self.mounts or not all(isinstance(mount, Mount) for mount in self.mounts):
            raise PinpressError(f"Elastic: mounts is {shown(self.mounts)}: give a list of foundation.Mount, at least one")
        incompatible = {"crown_mass": self.crown_mass, "clearances": self.clearances, "flexible_links": self.flexible_links}
        for name, value in incompatible.items():
            if value is not None and (name == "crown_mass" or len(value)):  # type: ignore[arg-type]
                raise PinpressError(
                    f"Elastic: a frame on mounts is rigid, and so are links and pins on it: leave out {name}, or the mounts"
                )
