"""Writes the records of docs/measured.md: a ZXN2-3000(B) whose slide is 8 % heavier and whose rocker is 10 % lighter than described.

    python docs/measured_records.py

It has friction and a balance cylinder, runs idle behind a servo motor at three speeds that swing by 60 % in 2.6 strokes, and is recorded at
250 Hz: an encoder of 8192 counts on the crank, and the torque of the motor (ratio 20.7) with 1 % noise.
"""

from pathlib import Path

import numpy as np

import pinpress as pp

FOLDER = Path(__file__).resolve().parent / "records"
STROKES, SECONDS, RATE, RATIO, COUNTS, NOISE = (21, 42, 63), 5.0, 250.0, 20.7, 8192, 250.0
SLIDE, ROCKER = 1.08, 0.9
CRANK, VISCOUS, GIBS, CYLINDER, STIFFNESS = 800.0, 60.0, 1500.0, 20e3, 15e3


def machine(press: pp.Linkage) -> pp.Linkage:
    """The press as it really is."""
    shares = {"slide": SLIDE, "rocker": ROCKER}
    inertias = list(press.model.inertias)
    for joint in range(1, len(inertias)):
        share = shares.get(press.link_of(joint), 1.0)
        inertias[joint] = type(inertias[joint])(share * inertias[joint].mass, inertias[joint].lever, share * inertias[joint].inertia)
    return press.with_inertias(inertias)


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    real, rng = machine(pp.load("zxn2_3000b")), np.random.default_rng(23)
    bottom = pp.dead_centres(real).bottom_position
    for strokes in STROKES:
        time, mean = np.arange(0.0, SECONDS, 1 / RATE), strokes * pp.RPM
        swing = 2 * np.pi * strokes / 60 / 2.6
        angle = mean * (time + 0.6 / swing * (1 - np.cos(swing * time)))
        motion = pp.servo_cycle(
            real, angle, speed=mean * (1 + 0.6 * np.sin(swing * time)), acceleration=mean * 0.6 * swing * np.cos(swing * time)
        )
        rate = motion.slide_velocity / motion.crank_speed
        torque = pp.inverse_dynamics(real, motion).driving_torque + CRANK + VISCOUS * motion.crank_speed + GIBS * np.abs(rate)
        torque += NOISE * rng.normal(size=len(time)) - (CYLINDER + STIFFNESS * (motion.slide_position - bottom)) * rate
        counts = np.round(angle / (2 * np.pi) * COUNTS) % COUNTS
        rows = [f"{t:.3f},{360 * n / COUNTS:.4f},{m / RATIO:.2f}" for t, n, m in zip(time, counts, torque, strict=True)]
        (FOLDER / f"{strokes}.csv").write_text("\n".join(["time [s],crank [deg],motor [N m]", *rows]) + "\n")


if __name__ == "__main__":
    main()
