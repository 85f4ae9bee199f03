"""Records of a frame that is hit with a hammer, worked out by the matrix exponential; `foundation` made only mass and stiffness."""

import functools

import numpy as np
from scipy.linalg import expm
from support import texts

from pinpress import foundation, measured

FRAME = foundation.Frame(15000.0, (0.0, 0.1, -0.3), (9000.0, 8000.0, 7000.0))
FEET = [(x, y, -1.3) for x in (-0.9, 0.9) for y in (-0.7, 0.7)]
POINTS = [(-0.9, -0.7, -1.2), (0.9, -0.7, -1.2), (0.9, 0.7, -1.2), (-0.8, -0.5, 1.2), (0.8, 0.6, 1.2)]
SENSORS = {
    f"{name}{axis} [m/s2]": measured.Accelerometer(point, axis) for name, point in zip("ABCDE", POINTS, strict=True) for axis in "xyz"
}
BLOWS = [((-0.9, -0.7, 1.2), (1.0, 0.2, 0.0)), ((0.8, 0.6, 1.2), (0.0, 1.0, 0.2)), ((0.9, -0.6, -1.2), (0.2, 0.0, 1.0))]
RATE = 500.0  # samples a second
BEGIN = 400  # samples before each blow


@functools.cache
def standing(hardness=60.0, loss_factor=0.08):
    """A press on four pads."""
    pad = foundation.RubberPad(0.3, 0.3, 0.04, hardness, loss_factor=loss_factor)
    return foundation.mounted(texts.shipped("jf75g_125"), FRAME, [foundation.pad_mount(foot, pad) for foot in FEET])


def seen(point):
    """(3, 6) displacement of a point by one of each coordinate."""
    x, y, z = point
    return np.hstack([np.eye(3), -np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])])


@functools.cache
def free(blow, seconds=8.0):
    """(n, channels) accelerations after a blow, without noise."""
    system, (point, force) = standing(), BLOWS[blow]
    found = foundation.modes(system)
    shapes, w, ratio = found.shapes, found.natural_frequency, system.loss.diagonal()[0] / system.stiffness.diagonal()[0] / 2
    damping = system.mass @ shapes @ np.diag(2 * ratio * w) @ shapes.T @ system.mass  # proportional: the shapes stay real
    solved = np.linalg.solve(system.mass, np.hstack([system.stiffness, damping]))
    state = np.block([[np.zeros((6, 6)), np.eye(6)], [-solved]])
    step, rows = expm(state / RATE), np.vstack([seen(point) for point in POINTS])
    now = np.concatenate([np.zeros(6), np.linalg.solve(system.mass, seen(point).T @ np.multiply(force, 100.0))])
    accelerations = np.empty((int(seconds * RATE), len(rows)))
    for values in accelerations:
        values[:] = rows @ (state @ now)[6:]
        now = step @ now
    return accelerations, ratio


def columns(blows=(0, 1, 2), noise=0.01, seed=0, seconds=8.0):
    """Columns of a record with these blows after each other, and noise by this share of each channel's root mean square after blows."""
    rng = np.random.default_rng(seed)
    apart = BEGIN + int(seconds * RATE)
    data = np.zeros((apart * len(blows), len(SENSORS)))
    for k, blow in enumerate(blows):  # the frame goes on swinging under the next blow
        begin = k * apart + BEGIN
        data[begin:] += free(blow, (len(data) - begin) / RATE)[0]
    data = data + noise * data.std(axis=0) * rng.normal(size=data.shape)
    return {"time [s]": np.arange(len(data)) / RATE} | {name: data[:, k] for k, name in enumerate(SENSORS)}
