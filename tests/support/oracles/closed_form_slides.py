"""Motions of slides in closed form, over one turn of a crank at constant speed. Parameters may be complex: the formulas are analytic."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class SlideTurn:
    """What measures need of a motion. Made of states at crank angles (n,) in equal steps, by the derivatives with the crank angle."""

    crank_angle: np.ndarray
    crank_speed: np.ndarray
    slide_position: np.ndarray
    slide_velocity: np.ndarray
    slide_acceleration: np.ndarray
    period_turns: int = 1


def turn(states, points, speed, begin=0.0):
    """The turn of a slide whose position and first two derivatives by the crank angle are ``states(angle)``."""
    angle = begin + np.sign(np.real(speed)) * 2 * np.pi / points * np.arange(points)
    position, first, second = states(angle)
    return SlideTurn(angle, np.full(points, speed), position, first * speed, second * speed**2)


def crank_slide(radius=0.1, rod=0.4, offset=0.02):
    """States of a slide below a crank pivot, ``offset`` beside it: its position -radius cos q - sqrt(rod^2 - (radius sin q + offset)^2)."""

    def states(angle):
        across, rate = radius * np.sin(angle) + offset, radius * np.cos(angle)
        along = np.sqrt(rod**2 - across**2)
        first = -across * rate / along
        second = -(rate**2 - across * radius * np.sin(angle) + first**2) / along
        return -radius * np.cos(angle) - along, radius * np.sin(angle) - first, radius * np.cos(angle) - second

    return states


def scotch_yoke(radius=0.1):
    """States of a slide on a rod without end: -radius cos q."""
    return lambda angle: (-radius * np.cos(angle), radius * np.sin(angle), radius * np.cos(angle))


def guide_bar(crank=0.108, bar=0.648, coupler=0.220, pivot=0.350, guide=0.630):
    """States of the ram of Chen 2002, towards -x on its working stroke; lengths l1, l3, l4, l6, h."""

    def states(angle):
        # The bar's direction as sine and cosine; its angle's derivatives from tan = (pivot + crank sin q) / (crank cos q).
        x, y = crank * np.cos(angle), pivot + crank * np.sin(angle)
        square = x**2 + y**2
        turned = (crank**2 + crank * pivot * np.sin(angle)) / square
        turning = crank * pivot * np.cos(angle) * square - (crank**2 + crank * pivot * np.sin(angle)) * 2 * crank * pivot * np.cos(angle)
        turning = turning / square**2
        cosine, sine = bar * x / np.sqrt(square), bar * y / np.sqrt(square)
        across, rate, bend = guide - sine, -cosine * turned, sine * turned**2 - cosine * turning
        along = np.sqrt(coupler**2 - across**2)
        first = -across * rate / along
        second = -(rate**2 + across * bend + first**2) / along
        return cosine + along, -sine * turned + first, -cosine * turned**2 - sine * turning + second

    return states


def four_bar(crank=0.143, coupler=1.243, rocker=0.375, pivot=(1.25, -0.2)):
    """Crank pin B, pin C and rocker pivot D, (n, 3) each, at crank angles (n,): the crank-rocker of Kong 2025, D in the origin."""

    def pins(angle):
        bx, by = pivot[0] + crank * np.cos(angle), pivot[1] + crank * np.sin(angle)
        square = bx**2 + by**2
        along = (rocker**2 - coupler**2 + square) / (2 * square)
        across = np.sqrt(rocker**2 / square - along**2)
        zero = np.zeros_like(bx)
        b = np.stack([bx, zero, by], axis=1)
        c = np.stack([along * bx - across * by, zero, along * by + across * bx], axis=1)
        return b, c, np.zeros_like(b)

    return pins
