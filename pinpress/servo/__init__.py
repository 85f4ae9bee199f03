"""Servo presses: the motion of the crank that needs the smallest motor or gives the most strokes a minute, proved to be the best.

    drive = pp.servo.ServoDrive(inertia=0.08, ratio=100.0, peak_torque=2000.0, rated_torque=600.0)
    loads = [pp.loads.DeepDrawing(1.5e6, 0.06)]
    slow = pp.servo.SlideSpeed(0.2, heights=(0.06, 0.0))
    best = pp.servo.best_motion(press, drive, loads, minimise="heat", time=60 / 25, path=pp.servo.Turn(), limits=[slow])
    print(best)  # value, bound and gap; the limits that act with their prices
    best.motion.rms_motor_torque, best.motion.peak_power

A `ServoDrive` describes the motor and its gear, a path (`Turn`, `Stop`, `Pendulum`, `Pulse`) where the crank goes in a cycle, and a
`ServoMotion` what a motion asks of the drive, by full inverse dynamics. `evaluate` makes one of any motion.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
