"""A frame without symmetry and its mounts, for the tests of foundations; and presses without mass, which leave it alone."""

import functools

import numpy as np
import pinocchio as pin
from support import texts

import pinpress as pp
from pinpress import foundation

WIDE = 0.6  # half the distance between mounts [m]
FEET = {f"foot {k}": (x, y, -1.3) for k, (x, y) in enumerate([(-0.55, -0.5), (-0.55, 0.6), (0.55, -0.5), (0.55, 0.6)])}
PLACES = {"bed": (0, 0.05, -1), "left": (0, 0.6, -1), "right": (0, -0.5, -1), "crown": (0, 0.05, 0.5)}
PLACES |= {"upper left": (0, 0.6, 0.5), "upper right": (0, -0.5, 0.5)} | FEET


@functools.cache
def weightless(name="crank_slide"):
    """A press whose links have no mass: what shakes the frame is what the test puts there."""
    press = texts.shipped(name)
    return press.with_inertias([pin.Inertia.Zero() for _ in press.model.inertias])


def on_four(stiffness, damping=(0.0, 0.0, 0.0), height=-1.0, **more):
    """Four mounts at the corners of a square."""
    return [foundation.Mount((x, y, height), stiffness, damping, **more) for x in (-WIDE, WIDE) for y in (-WIDE, WIDE)]


def uneven(scale=1.0):
    """A frame whose centre of mass is off every axis, and mounts that all differ."""
    inertia = scale * (np.diag([2500.0, 2200.0, 1500.0]) + 120.0 * (np.ones((3, 3)) - np.eye(3)))
    frame = foundation.Frame(scale * 6000.0, (0.05, 0.12, -0.2), inertia)
    mounts = [
        foundation.Mount((x, y, -1.2 + 0.05 * k), tuple(scale * k * np.array([7e5, 8e5, 1.5e6])), tuple(scale * np.array([4e3, 5e3, 9e3])))
        for k, (x, y) in enumerate([(-0.6, -0.5), (0.7, -0.4), (-0.5, 0.8), (0.6, 0.7)], start=2)
    ]
    return frame, mounts


def harmonic_force(press, amplitude, orders=(1,)):
    """A force on the frame through its origin, along z, cosines of the crank angle."""

    def force(motion):
        return np.outer(sum(np.cos(k * motion.crank_angle) for k in orders), [0.0, 0.0, amplitude])

    return pp.loads.PointForce(press.root, force)


def turns(press, speed, count, states):
    """So many turns at constant speed, as one motion in time."""
    return pp.servo_cycle(press, speed=speed, angle=np.sign(speed) * np.linspace(0.0, 2 * np.pi * count, count * states + 1))


def members(stiffer=1.0):
    """A bed and a crown of boxes on two columns, and a leg to each foot."""
    material = {"modulus": 2.1e11 * stiffer, "shear_modulus": 8.1e10 * stiffer}
    box = {"width": 0.8, "height": 0.5, "wall": 0.04, "across": (1, 0, 0)} | material
    found = [foundation.FrameBeam(*ends, **box) for ends in [("right", "bed"), ("bed", "left")]]
    found += [foundation.FrameBeam(*ends, **box) for ends in [("upper right", "crown"), ("crown", "upper left")]]
    column = {"width": 0.6, "height": 0.25, "wall": 0.05, "across": (1, 0, 0)} | material
    found += [foundation.FrameBeam("left", "upper left", **column), foundation.FrameBeam("right", "upper right", **column)]
    leg = {"width": 0.3, "height": 0.3, "across": (0, 1, 0)} | material
    sides = ("right", "left", "right", "left")
    return found + [foundation.FrameBeam(side, foot, **leg) for side, foot in zip(sides, FEET, strict=True)]


@functools.cache
def of_beams(stiffer=1.0, modes=20, elements=3, loss_factor=0.0, guided="crown"):
    bearings = {} if guided == "crown" else {"slide_guide": guided}
    more = {"elements": elements, "modes": modes, "loss_factor": loss_factor, "bearings": bearings}
    return foundation.beam_frame(PLACES, members(stiffer), bed="bed", carrier="crown", **more)
