"""Mounts that keep a press from shaking the floor: how stiff they may be, over its range of speeds.

Mounts isolate what is faster than sqrt(2) times their natural frequency, and the softer they are the more; but soft mounts sag, and the
press sways on them, or tips.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.checks import finite_numbers
from ..common.errors import PinpressError, shown
from ..common.results import Tabular
from ..common.units import RPM
from ..linkage.linkage import Linkage
from .mounted_press import MountedPress, mounted, with_mounts
from .mounts import Frame, Mount, listed_mounts
from .response import solved
from .speed_response import floor_rms, rising, shaking_rms, spectra
from .vibration_modes import undamped

TRIALS = 97  # stiffnesses tried, evenly in their logarithm, from the stiffest down
SOFTEST, STIFFEST = 0.01, 4.0  # lowest natural frequency beside the lowest and the highest speed, between which is looked
REFINED = 1e-9  # of the stiffness found, relative


@dataclass(frozen=True, eq=False, repr=False)
class Isolation(Tabular):
    """The stiffest mounts that isolate. All arrays are read-only.

    Attributes:
        system: the press on them.
        mounts: these mounts.
        factor: their stiffness by that of the mounts given [-].
        speed: (s,) of the crank [rad/s].
        transmitted: (s,) force on the floor by shaking force at each speed [-].
    """

    system: MountedPress
    mounts: tuple[Mount, ...]
    factor: float
    speed: Array
    transmitted: Array

    @property
    def title(self) -> str:
        most, speeds = self.transmitted.max(), f"{self.speed[0]:.4g} to {self.speed[-1]:.4g} rad/s"
        return f"Isolation of {self.system.press.name}: {self.factor:.4g} times the stiffness, {most:.3g} transmitted at {speeds}"

    def __str__(self) -> str:
        x, y, z = self.stiffness
        worst = self.speed[self.transmitted.argmax()]
        frequencies = ", ".join(f"{w / (2 * np.pi):.3g}" for w in np.sqrt(undamped(self.system)[0]))
        return "\n".join(
            [
                f"{self.system.press.name}: the stiffest mounts that isolate, {self.factor:.4g} times as stiff as those given",
                f"  all together        {x:12.4g} {y:12.4g} {z:12.4g} N/m along x, y, z",
                f"  natural frequencies {frequencies} Hz",
                f"  sag at rest         {1e3 * self.sag:12.4g} mm",
                f"  transmitted         {self.transmitted.max():12.4g} at most, at {worst / RPM:.4g} per min",
            ]
        )

    def columns(self) -> dict[str, Array]:
        """Speed and share transmitted as columns; the mounts' are those of `system`."""
        return {"speed [rad/s]": self.speed, "transmitted [-]": self.transmitted}

    @property
    def stiffness(self) -> Array:
        """(3,) of all mounts together along x, y and z [N/m]."""
        return np.asarray(np.sum([mount.stiffness for mount in self.mounts], axis=0))

    @property
    def sag(self) -> float:
        """Largest vertical displacement of a mount at rest [m]."""
        return _sag(self.system)


@typed
def isolate(
    press: Linkage,
    frame: Frame,
    mounts: Sequence[Mount],
    *,
    speeds: ArrayLike,
    transmitted: float,
    sag: float | None = None,
) -> Isolation:
    """The stiffest mounts with which the idle press passes on at most a share of its shaking force, at every one of its speeds.

    Args:
        press: with one driver that turns fully.
        frame: in one part.
        mounts: where they stand, and their ratios of stiffness. All their stiffnesses are multiplied by one factor, their damping by its
            root, which keeps damping ratios as they are.
        speeds: (s,) of the crank, rising, close enough that no resonance falls between two [rad/s].
        transmitted: force on the floor by shaking force, roots of mean squares, more than 0 and less than 1.
        sag: largest displacement of a mount at rest [m]; None: any.

    Raises:
        PinpressError: an argument that makes no sense; a press that shakes nothing; no such mounts: the error names what conflicts.
    """
    speed, mounts = rising("speeds", speeds), listed_mounts(mounts, "mounts")
    limit = _between("transmitted", transmitted, 1.0, "a share, more than 0 and less than 1")
    most_sag = None if sag is None else _between("sag", sag, np.inf, "a positive length [m]")
    given = mounted(press, frame, mounts)
    frequency, harmonics = spectra(given, speed)
    shaking = shaking_rms(given, harmonics)
    wish = f"pass on at most {limit:g} of the shaking force between {speed[0] / RPM:.4g} and {speed[-1] / RPM:.4g} per min"
    if not shaking.all():
        raise PinpressError(f"no force of {press.name} shakes the frame: it needs no isolation")

    def passed(factor: float) -> Array:
        try:
            system = with_mounts(given, _scaled(mounts, factor))
        except PinpressError:  # it tips
            return np.full(len(speed), np.inf)
        return floor_rms(system, frequency, solved(system, frequency, harmonics)) / shaking

    lowest = float(undamped(given)[0][0])
    factors = np.geomspace((STIFFEST * speed[-1]) ** 2 / lowest, (SOFTEST * speed[0]) ** 2 / lowest, TRIALS)
    worst: list[float] = []
    for factor in factors:
        worst.append(float(passed(float(factor)).max()))
        if worst[-1] <= limit:
            break
    else:
        best = int(np.argmin(worst))
        raise PinpressError(
            f"no stiffness lets these mounts {wish}: the least is {worst[best]:.3g}, at {factors[best]:.3g} times theirs; lower their"
            " damping, set them wider apart and nearer to the height of the centre of mass, against tipping and rocking, or give the"
            " frame more mass"
        )
    low, high = float(factors[len(worst) - 1]), float(factors[max(len(worst) - 2, 0)])
    while high > (1 + REFINED) * low:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if passed(middle).max() <= limit else (low, middle)
    chosen = _scaled(mounts, low)
    system = with_mounts(given, chosen)
    if most_sag is not None and _sag(system) > most_sag:
        raise PinpressError(
            f"isolation and sag conflict: to {wish} the mounts may be at most {low:.4g} times as stiff as those given, but sag"
            f" {1e3 * _sag(system):.4g} mm then; {1e3 * most_sag:.4g} mm need {low * _sag(system) / most_sag:.4g} times: allow more sag or"
            " more force, or raise the lowest speed"
        )
    share = passed(low)
    return Isolation(system, chosen, low, speed, share)


def _scaled(mounts: Sequence[Mount], factor: float) -> tuple[Mount, ...]:
    return tuple(
        replace(
            mount,
            stiffness=tuple(factor * np.array(mount.stiffness)),
            damping=tuple(np.sqrt(factor) * np.array(mount.damping)),
            static_stiffness=tuple(factor * np.array(mount.static)),
        )
        for mount in mounts
    )


def _sag(system: MountedPress) -> float:
    return float(np.abs(system.sag[:, 2]).max())


def _between(name: str, given: object, upper: float, wanted: str) -> float:
    value = finite_numbers(given)
    if value is None or value.ndim or not 0 < value < upper:
        raise PinpressError(f"{name} is {shown(given)}: give {wanted}")
    return float(value)
