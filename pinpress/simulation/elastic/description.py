"""What yields in a press, and by how much: stiffnesses, dampers, and the mass of a crown that its columns carry.

Stiffnesses are static quantities; a motion on them also needs dampers. Without better knowledge they are proportional to the springs, so
that the lowest vibration of the press at its bottom dead centre has the damping ratio that is given. A vibration of a higher frequency then
has a larger damping ratio, in proportion.
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

MOST_DAMPING = 2.0  # largest damping ratio


@dataclass(frozen=True)
class Rod:
    """A link, or an arm of one, that stretches along the line of two of its bearings.

    The force in a rod is the mean of the pulls of both bearings along their line, which is exact for a rod whose mass is symmetric about
    its middle. On a link with more bearings it is an arm: it begins at the first of the two bearings, and is loaded by the second alone.

    Attributes:
        link: name of the link.
        between: names of two of its bearings.
        stiffness: stiffness E A / l between them [N/m], or a joint, such as a die-height screw and its lock.
    """

    link: str
    between: tuple[str, str]
    stiffness: float | PreloadedJoint

    @property
    def name(self) -> str:
        """Name of the part in tables."""
        return f"{self.link} {self.between[0]}-{self.between[1]}"


@dataclass(frozen=True, eq=False)
class Stiffness(Frozen):
    """Stiffnesses of the parts of a press. All parts without one are rigid, and so are gear pairs. A `PreloadedJoint` in place of a
    number opens where its load opens it.

    Attributes:
        bearings: name of a bearing -> radial stiffness, in space also along its axis; of a guide, stiffness across its axis [N/m],
            or of both gibs with their preload; in space of each of the two directions across.
        moments: name of a guide, in space also of a pin or weld -> stiffness against turning [N m/rad]. The moment of a guide is about the
            origin of the sliding link's joint frame, as in `Reactions`.
        rods: links and arms that stretch.
        shaft: torsional stiffness of the shaft between the driver's crank and the drive [N m/rad]; None: rigid. An elastic motion counts
            the start's angle and speed at the drive's end, where the flywheel sits and a brake acts.
        frame: stiffness of the columns between the crown, which has all bearings on the frame, and the table [N/m], or of tie rods and
            uprights with their preload; None: rigid. The table stands on the floor, so that weight and inertia forces that press on the
            crown load the columns too.
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
        stiffness: of its parts; it must name all bearings, and all guides against turning.
        damping_ratio: of the lowest vibration at bottom dead centre, from 0 to 2 [-]; all springs have dampers in proportion.
        dampers: name of a bearing or guide -> its damper in place of that [N s/m].
        crown_mass: mass of the crown on its columns, without the linkage [kg]; it is needed where ``stiffness.frame`` is given.
        clearances: name of a pin -> its clearance; such a press is simulated, it has no steady state.
        flexible_links: links that bend and stretch.
        mounted_frame: mass of the frame that stands on mounts, as for `foundation`; None: the frame is fixed.
        mounts: between floor and frame; only what they do in the plane of the press counts, with viscous damping.
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
        if not 0.0 <= ratio <= MOST_DAMPING:
            raise PinpressError(
                f"Elastic: damping_ratio is {ratio:g}: give a number from 0 to {MOST_DAMPING:g}; steel structures have 0.01 to 0.05"
            )
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
        others = {"crown_mass": self.crown_mass, "clearances": self.clearances, "flexible_links": self.flexible_links}
        for name, value in others.items():
            if value is not None and (name == "crown_mass" or len(value)):  # type: ignore[arg-type]
                raise PinpressError(
                    f"Elastic: a frame on mounts is rigid, and so are links and pins on it: leave out {name}, or the mounts"
                )
