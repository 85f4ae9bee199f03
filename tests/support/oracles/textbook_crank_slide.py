"""The equation of motion of the textbook press `crank_slide`, in closed form, without pinpress.

Crank angle q from bottom dead centre [rad]; lengths in m. ``m`` is numpy, or math or cmath for one crank angle, which is ten times as fast.
"""

import cmath

import numpy as np

R, L, GRAVITY = 0.1, 0.4, 9.81
BOTTOM = -R - L


def height(q, m=np):
    """Of the slide above bottom dead centre. ``m``: math or cmath for one crank angle, which is ten times as fast."""
    return -R * m.cos(q) - m.sqrt(L * L - (R * m.sin(q)) ** 2) - BOTTOM


def lever(q, m=np):
    return R * m.sin(q) + R * R * m.sin(q) * m.cos(q) / m.sqrt(L * L - (R * m.sin(q)) ** 2)


def inertia(q, m=np):
    """Crank 20 kg at 0.03 m and 0.1 kg m2; rod 15 kg midway and 0.2 kg m2; slide 100 kg."""
    tilt = R * m.cos(q) / m.sqrt(L * L - (R * m.sin(q)) ** 2)
    along = lever(q, m)
    centre = (R * m.cos(q) / 2) ** 2 + ((R * m.sin(q) + along) / 2) ** 2
    return 0.1 + 20 * 0.03**2 + 15 * centre + 0.2 * tilt**2 + 100 * along**2


def potential(q, m=np):
    slide = height(q, m) + BOTTOM
    return GRAVITY * (-20 * 0.03 * m.cos(q) + 15 * 0.5 * (-R * m.cos(q) + slide) + 100 * slide)


def slope(function, q):
    """Derivative at crank angles, exact to rounding: of a step along the imaginary axis nothing is subtracted."""
    return function(q + 1e-40j).imag / 1e-40


def acceleration(q, w, torque, flywheel):
    carried, fallen = inertia(q + 1e-40j, cmath), potential(q + 1e-40j, cmath)
    return (torque - (fallen.imag + 0.5 * carried.imag * w * w) / 1e-40) / (carried.real + flywheel)
