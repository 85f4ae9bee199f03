"""What turns the crank: motors, flywheel, gears, clutch and brake.

    motor = pp.drives.InductionMotor(rated_power=75e3, rated_speed=1485 * pp.RPM, inertia=1.2)
    drive = pp.drives.Geared(motor, ratio=20.7, efficiency=0.95)  # as the crank sees it
    flywheel = pp.drives.Flywheel(inertia=2000.0)  # kg m2 at the crank
    pp.simulate(press, duration=1.0, speed=70 * pp.RPM, drive=drive, flywheel=flywheel).crank_speed

A drive does not know the press: it gives a torque as a function of speed, angle and time, positive along the driver's axis. Your own drive
is a class with the methods of `Drive`. A `SwitchPoint` says when a clutch or a brake closes or opens.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
