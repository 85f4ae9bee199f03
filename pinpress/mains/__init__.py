"""Motor and flywheel of a press on the mains: which motor of a catalogue suffices, with which gear and which flywheel.

motors = pp.mains.read_motors("motors.csv")
choice = pp.mains.choose_drive(press, motors, [drawing], ratios=[12, 15], flywheels=(0.2, 3.0), speeds=(90 * pp.RPM, 105 * pp.RPM),
                               speed_drop=0.06)
print(choice)  # every motor with every gear, and its smallest flywheel
run = pp.steady_state(press, choice.best.mean_speed, drive=choice.drive, flywheel=choice.flywheel, loads=[drawing])
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
