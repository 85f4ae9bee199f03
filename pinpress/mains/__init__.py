"""Motor and flywheel of a press on the mains: which motor of a catalogue suffices, with which gear and which flywheel.

    from pathlib import Path

    columns = "motor, rated power [kW], rated speed [r/min], breakdown ratio, inertia [kg m2]"
    Path("motors.csv").write_text(f"{columns}\\n280S-4, 75, 1485, 2.5, 1.2\\n")
    motors, drawing = pp.mains.read_motors("motors.csv"), pp.loads.DeepDrawing(force=1e6, start=0.01)
    speeds = 60 * pp.RPM, 80 * pp.RPM
    choice = pp.mains.choose_drive(press, motors, [drawing], ratios=[20.7], flywheels=(5.0, 20.0), speeds=speeds, speed_drop=0.06)
    print(choice)  # every motor with every gear, and its smallest flywheel
    run = pp.steady_state(press, choice.best.mean_speed, drive=choice.drive, flywheel=choice.flywheel, loads=[drawing])

The flywheel is on the shaft of the motor.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
