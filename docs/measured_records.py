"""The records of docs/measured.md: a ZXN2-3000(B) whose slide is 8 % heavier and whose rocker is 10 % lighter than described.

It has friction and a balance cylinder, runs idle behind a servo motor at three speeds that swing by 60 % in 2.6 strokes, and is recorded at
250 Hz: an encoder of 8192 counts on the crank, and the torque of the motor (ratio 20.7) with 1 % noise. Then it works: three strokes at 50
a minute, recorded at 500 Hz, that draw with at most 1.4, 1.5 and 1.6 MN, and strip with up to 90 kN.
"""

from collections.abc import Sequence

import numpy as np
from make import DOCS, write

import pinpress as pp

STROKES, SECONDS, RATE, RATIO, COUNTS, NOISE = (21, 42, 63), 5.0, 250.0, 20.7, 8192, 250.0
SLIDE, ROCKER = 1.08, 0.9
CRANK, VISCOUS, GIBS, CYLINDER, STIFFNESS = 800.0, 60.0, 1500.0, 20e3, 15e3

DRAWN = 0.010  # height from which it draws [m]
STRIPPED = [0.0, 0.002, 0.005, 0.009], [-2e4, -9e4, -4e4, 0.0]  # heights [m] and forces [N]


def machine(press: pp.Linkage) -> pp.Linkage:
    """The press as it really is."""
    shares = {"slide": SLIDE, "rocker": ROCKER}
    inertias = list(press.model.inertias)
    for joint in range(1, len(inertias)):
        share = shares.get(press.link_of(joint), 1.0)
        inertias[joint] = type(inertias[joint])(share * inertias[joint].mass, inertias[joint].lever, share * inertias[joint].inertia)
    return press.with_inertias(inertias)


def required(real: pp.Linkage, motion: pp.Motion, loads: Sequence[pp.loads.PointForce] = ()) -> np.ndarray:
    """(n,) torque at the crank that the real press asks for."""
    rate = motion.slide_velocity / motion.crank_speed
    height = motion.slide_position - pp.dead_centres(real).bottom_position
    idle = CRANK + VISCOUS * motion.crank_speed + GIBS * np.abs(rate) - (CYLINDER + STIFFNESS * height) * rate
    return pp.inverse_dynamics(real, motion, loads).driving_torque + idle


def working(real: pp.Linkage, motion: pp.Motion) -> pp.loads.PointForce:
    """Drawing on the way down, more from stroke to stroke, and stripping on the way up."""
    height = motion.slide_position - pp.dead_centres(real).bottom_position
    stroke = np.floor((motion.crank_angle - motion.crank_angle[0]) / (2 * np.pi))
    drawing = (1.4e6 + 1e5 * stroke) * np.sin(np.pi * np.clip(height / DRAWN, 0.0, 1.0))
    stripping = np.interp(height, *STRIPPED, right=0.0)
    force = np.where(motion.slide_velocity < 0, drawing, stripping)
    return pp.loads.PointForce("slide", force[:, None] * [0.0, 0.0, 1.0])


def write_record(name: str, time: np.ndarray, angle: np.ndarray, torque: np.ndarray) -> None:
    """Write a record as its instruments see it."""
    counts = np.round(angle / (2 * np.pi) * COUNTS) % COUNTS
    rows = [f"{t:.3f},{360 * n / COUNTS:.4f},{m / RATIO:.2f}" for t, n, m in zip(time, counts, torque, strict=True)]
    write(DOCS / "records" / f"{name}.csv", "\n".join(["time [s],crank [deg],motor [N m]", *rows]) + "\n")


def main(quick: bool = False) -> None:
    """Write them."""
    real, rng = machine(pp.load("zxn2_3000b")), np.random.default_rng(23)
    for strokes in STROKES:
        time, mean = np.arange(0.0, SECONDS, 1 / RATE), strokes * pp.RPM
        swing = 2 * np.pi * strokes / 60 / 2.6
        angle = mean * (time + 0.6 / swing * (1 - np.cos(swing * time)))
        motion = pp.servo_cycle(
            real, angle, speed=mean * (1 + 0.6 * np.sin(swing * time)), acceleration=mean * 0.6 * swing * np.cos(swing * time)
        )
        write_record(str(strokes), time, angle, required(real, motion) + NOISE * rng.normal(size=len(time)))
    time = np.arange(round(3 * 500 * 60 / 50) + 5) / 500
    angle = pp.dead_centres(real).top_angle - 0.01 + 50 * pp.RPM * time
    motion = pp.servo_cycle(real, angle, speed=50 * pp.RPM, acceleration=0.0)
    write_record("stroke", time, angle, required(real, motion, [working(real, motion)]) + NOISE * rng.normal(size=len(time)))
