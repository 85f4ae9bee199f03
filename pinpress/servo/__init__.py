"""Servo presses: the motion of the crank that needs the smallest motor or gives the most strokes a minute, proved to be the best.

    drive = pp.servo.ServoDrive(inertia=0.08, ratio=100.0, peak_torque=2000.0, rated_torque=600.0)
    loads = [pp.loads.DeepDrawing(1.5e6, 0.06)]
    time = np.linspace(0.0, 60 / 25, 721)
    speed = np.full_like(time, 25 * pp.RPM)
    constant = pp.servo.evaluate(press, drive, loads, time=time, angle=speed * time, speed=speed, acceleration=0.0)
    constant.rms_torque, constant.peak_power

A `ServoDrive` describes the motor and its gear, a path (`Turn`, `Stop`, `Pendulum`, `Pulse`) where the crank goes in a cycle, and a
`ServoMotion` what a motion asks of the drive, by full inverse dynamics.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
