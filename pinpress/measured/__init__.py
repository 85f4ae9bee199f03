"""Identify a press from the signals of its drive: crank angle and motor torque.

    time = np.arange(0.0, 8.0, 0.002)  # of a file: run = pp.measured.record("70.csv", "crank [rad]", "motor [N m]", ratio=20.7)
    angle = 5.0 * time + 0.9 * np.sin(2.0 * time)
    torque = pp.inverse_dynamics(press, pp.servo_cycle(press, angle, time=time)).driving_torque + 500.0
    run = pp.measured.MeasuredRun(time, angle, torque + 100.0 * np.random.default_rng(0).normal(size=len(time)))
    found = pp.measured.identify(press, [run], friction=("crank",))
    found.press, found.values["slide mass"], found.intervals["slide mass"], found.learnt

A `MeasuredRun` is a record with a continuous crank angle and the torque at the crank: from a file by `record`, or from arrays.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
