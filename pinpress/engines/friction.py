"""Friction of bearings: efforts that depend on the bearing forces, which depend on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.errors import PinpressError
from ..common.quantities import Array

REST = 1e-12  # share of the motion's largest speed below which a bearing rests: at a dead centre its speed is rounding
# Shares of a whole step: the first one, and the shortest and longest. Where efforts answer a change by m times it, a share w leaves
# 1 - w (1 - m) of the error: nothing with w = 1 / (1 - m), which Aitken's rule finds from m = -19 to 0.99, and less than all of it where
# m > 1 - 2 / w, which is -15 for the first step and -39 for the shortest.
FIRST_STEP, STEPS = 0.125, (0.05, 100.0)
RUNAWAY = 1e9  # share of the first sizes above which changes grow without end
MOST_ITERATIONS = 200  # of friction efforts and bearing forces in turn: many are needed only where friction nearly locks the linkage


@dataclass(frozen=True, eq=False, repr=False)
class FrictionLaw:
    """The friction of all bearings, joints in Pinocchio's order, then loops; behind them rows of contacts, see `machine_elements`.

    Attributes:
        arm: (bearings,) effort of dry friction by the bearing's radial force: mu r of a pin [m], mu of a guide [-].
        backward: (bearings,) the same where the signed force of a contact and the speed have opposite signs.
        viscous: (bearings,) effort by speed [N m s, of a guide N s/m].
        preload: (bearings,) force with which the gibs of a guide press on it without a load; zero of all others [N].
        turns: (bearings,) False for guides, True for all others.
        pushes: (bearings,) True for rows that are not friction but forces that push gears apart: these are positive, also at rest.
        size: length of the linkage [m].
    """

    arm: Array
    backward: Array
    viscous: Array
    preload: Array
    turns: NDArray[np.bool_]
    pushes: NDArray[np.bool_]
    size: float

    def of(self, rows: NDArray[np.intp]) -> FrictionLaw:
        """The law of some of the rows."""
        arm, backward, viscous, preload = np.array([self.arm, self.backward, self.viscous, self.preload])[:, rows]
        return FrictionLaw(arm, backward, viscous, preload, self.turns[rows], self.pushes[rows], self.size)

    def moving(self, speeds: Array) -> Array:
        """Speeds (bearings, n), set to zero where they are rounding beside the fastest of the motion."""
        turning = np.abs(speeds[self.turns]).max(initial=0.0)
        sliding = max(self.size * turning, np.abs(speeds[~self.turns]).max(initial=0.0))
        return np.where(np.abs(speeds) <= REST * np.where(self.turns, turning, sliding)[:, None], 0.0, speeds)

    def efforts(self, speeds: Array, forces: Callable[[Array], Array], place: Callable[[int], str]) -> Array:
        """Friction efforts (bearings, n), opposed to the speeds: negative where the speed is positive [N m, of a guide N].

        Bearing forces depend on friction and friction on them: both are found in turn until they no longer change.

        Args:
            speeds: (bearings, n) speeds of the bearings [rad/s, of a guide m/s], exactly zero where one rests.
            forces: function of friction efforts (bearings, n) that returns the radial forces (bearings, n) under them, of contacts with
                a sign [N].
            place: gives where the drivers are in a state, in words, for the message of an error.

        Raises:
            PinpressError: there are no consistent forces, because friction locks the linkage, or nearly so.
        """
        steady = -self.viscous[:, None] * speeds
        ways = np.where(self.pushes[:, None], 1.0, -np.sign(speeds))
        forward, backward = (ways * arm[:, None] for arm in (self.arm, self.backward))
        alike = np.array_equal(self.arm, self.backward)  # mostly, and looking at signs takes time

        def follow(efforts: Array) -> tuple[Array, Array]:
            force = forces(efforts)
            pressing = np.maximum(np.abs(force), self.preload[:, None])
            following = steady + (forward if alike else np.where(force * speeds < 0, backward, forward)) * pressing
            # The size is also what the largest force could do, because the force of a single guide may be nothing but rounding.
            return following, np.maximum(np.abs(following).max(axis=0), self.arm.max() * pressing.max(axis=0))

        efforts, change = fixed_point(follow, steady, 1e-15)
        if change is not None:
            raise PinpressError(
                f"friction locks the linkage, or nearly so, at {place(int(np.argmax(change)))}: no consistent bearing forces are found;"
                " lower the coefficients of friction, or keep away from the dead point"
            )
        return efforts


def fixed_point(follow: Callable[[Array], tuple[Array, Array]], start: Array, settled: float) -> tuple[Array, Array | None]:
    """The efforts of friction that follow from the bearing forces under these same efforts.

    Args:
        follow: efforts (bearings, ...) -> the efforts that the forces under them ask for, and sizes (...) by which changes are measured.
        start: efforts to begin with.
        settled: share of the sizes below which a change is rounding.

    Returns:
        The efforts, and None; where they do not settle, the last changes (...), infinite where they are not finite.
    """
    # Whole steps diverge where forces answer a change by a larger, opposite one. They hardly advance where forces nearly support
    # themselves, as in a thread that nearly locks. Then Aitken's rule gives the length of steps, and never reverses one.
    for whole in (True, False):
        efforts, change, first = start, np.full(start.shape[1:], np.inf), np.zeros(start.shape[1:])
        share, last = np.full(start.shape[1:], FIRST_STEP), np.zeros_like(start)
        for k in range(MOST_ITERATIONS):
            following, size = follow(efforts)
            step = following - efforts
            before, change = change, np.abs(step).max(axis=0)
            if k and not whole:
                bend = last - step
                squares = (bend * bend).sum(axis=0)
                share = np.where(squares > 0, share * (last * bend).sum(axis=0) / np.where(squares > 0, squares, 1.0), share).clip(*STEPS)
            efforts, last = (following if whole else efforts + share * step), step
            # rounding can keep the last digits moving: stop where the change no longer shrinks
            if np.all((change <= settled * size) | ((change <= 1e-12 * size) & (change >= before))):
                return efforts, None
            first = size if np.isinf(before).all() else first
            if not (change <= RUNAWAY * first).all():
                break
    return efforts, np.where(np.isfinite(change), change, np.inf)
