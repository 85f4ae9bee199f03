"""Synthetic records of presses whose masses are drawn from the prior: their truth is known."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from support import texts

import pinpress as pp
from pinpress.measured import MeasuredRun
from pinpress.measured.estimates.prior import Losses, unknowns_of
from pinpress.measured.regressor import inertial_equations, loss_columns
from pinpress.pin_table import templates

OUT_OF_STEP = 2.6  # strokes after which the speed repeats itself
CHANGING = 0.6  # share by which it changes


@cache
def press_of(name):
    """A shipped press, or one of a template."""
    return texts.shipped(name) if name in pp.presses() else pp.build(Path(templates.__file__).with_name(f"{name}.yaml"))


class Drive(NamedTuple):
    """Time, angle, speed and acceleration of a crank."""

    time: np.ndarray
    angle: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray


def drive(strokes, seconds=5.0, rate=500.0, changing=CHANGING):
    """So many strokes a minute on average; the speed changes out of step with the stroke."""
    time, mean = np.arange(0.0, seconds, 1 / rate), strokes * pp.RPM
    turn = 2 * np.pi / (OUT_OF_STEP * 60 / strokes)
    angle = mean * (time + changing / turn * (1 - np.cos(turn * time)))
    speed = mean * (1 + changing * np.sin(turn * time))
    return Drive(time, angle, speed, mean * changing * turn * np.cos(turn * time))


@cache
def columns(name, strokes, friction, cylinder, seconds=5.0, rate=500.0):
    """(n, parameters and losses) of the torque of a press as described."""
    press, moved = press_of(name), drive(strokes, seconds, rate)
    inertial = inertial_equations(press).coefficients(moved.angle)["torque"].columns(moved.speed, moved.acceleration)
    return np.concatenate([inertial, loss_columns(press, *moved[1:], friction, cylinder)], axis=1)


def drawn(name, rng, prior=0.2):
    """Masses and inertias of a real press within the prior."""
    press = press_of(name)
    unknowns = unknowns_of(press, prior, Losses((), False, None))
    change = np.clip(rng.normal(size=unknowns.inertial), -4.5, 4.5)
    return unknowns.at(change)[0]


def run(moved, torque, rng=None, noise=0.0, counts=None, **more):
    """A record with noise of the torque and an encoder whose zero is anywhere within a count."""
    angle = moved.angle
    if counts is not None:
        step = 2 * np.pi / counts
        offset = rng.uniform(-0.5, 0.5) * step
        angle = np.round((angle + offset) / step) * step - offset
    return MeasuredRun(moved.time, angle, torque + (noise * rng.normal(size=len(torque)) if noise else 0.0), **more)
